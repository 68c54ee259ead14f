//! From definitions in any order, with names, to a tree: names bound, cycles found, arguments before their gates.
//!
//! Every walk has its own stack, so a chain of a hundred thousand gates is as good as any other tree. The cost is linear in
//! the text, apart from the sorting of names.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use diagnostic::{Problem, Source};

use crate::data::EventData;
use crate::mistakes::Mistakes;
use crate::reading::Reading;
use crate::tree::{Connective, FaultTree, Node, NodeId, NodeKind};

/// A definition as it was read.
#[derive(Debug)]
pub(crate) struct Definition {
    /// `None` for a formula within a gate.
    pub name: Option<String>,
    /// The name's place, or the formula's.
    pub span: Range<usize>,
    pub body: Body,
}

#[derive(Debug)]
pub(crate) enum Body {
    Basic(Option<EventData>),
    House(bool),
    Gate(Connective, Vec<Argument>),
    /// Defined, but not understood, which was said.
    Unknown,
}

#[derive(Debug)]
pub(crate) enum Argument {
    Name(String, Range<usize>),
    /// The definition of that number.
    Formula(usize),
}

/// All definitions of a text.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub definitions: Vec<Definition>,
    /// The top event and its place, where the text says it.
    pub top: Option<(String, Range<usize>)>,
}

impl Draft {
    pub fn define(&mut self, name: Option<String>, span: Range<usize>, body: Body) -> usize {
        self.definitions.push(Definition { name, span, body });
        self.definitions.len() - 1
    }

    /// Binds the names. All mistakes, those found before included, are one problem.
    pub fn resolve(self, source: &Source, mut mistakes: Mistakes<'_>) -> Result<Reading, Problem> {
        let by_name = names(&self.definitions, &mut mistakes);
        let gates = self.bind(&by_name, &mut mistakes);
        let top = self.top.as_ref().and_then(|(name, span)| {
            let found = by_name.get(name.as_str()).copied();
            if found.is_none() {
                mistakes.undefined(span.clone(), name);
            }
            found
        });
        let order = self.ordered(&gates, &mut mistakes);
        if !mistakes.is_empty() {
            let mut known: Vec<&str> = by_name.keys().copied().collect();
            known.sort_unstable();
            return Err(mistakes.into_problem(&known).expect("at least one mistake"));
        }
        drop(by_name);
        let tree = self.build(gates, &order, top);
        let warnings = unused(&tree, source);
        Ok(Reading { tree, warnings })
    }

    /// The arguments of each definition as numbers of definitions.
    fn bind(&self, by_name: &HashMap<&str, usize>, mistakes: &mut Mistakes<'_>) -> Vec<Vec<usize>> {
        let mut gates = Vec::with_capacity(self.definitions.len());
        for definition in &self.definitions {
            let Body::Gate(connective, arguments) = &definition.body else {
                gates.push(Vec::new());
                continue;
            };
            let mut bound = Vec::with_capacity(arguments.len());
            for argument in arguments {
                match argument {
                    Argument::Formula(index) => bound.push(*index),
                    Argument::Name(name, span) => match by_name.get(name.as_str()) {
                        Some(index) => bound.push(*index),
                        None => mistakes.undefined(span.clone(), name),
                    },
                }
            }
            repeated(*connective, &bound, definition, mistakes);
            gates.push(bound);
        }
        gates
    }

    /// The definitions, arguments first. A walk in depth; what leads back to a gate that is being walked is a cycle.
    fn ordered(&self, gates: &[Vec<usize>], mistakes: &mut Mistakes<'_>) -> Vec<usize> {
        const NEW: u8 = 0;
        const OPEN: u8 = 1;
        const DONE: u8 = 2;
        let mut state = vec![NEW; gates.len()];
        let mut order = Vec::with_capacity(gates.len());
        for start in 0..gates.len() {
            if state[start] != NEW {
                continue;
            }
            state[start] = OPEN;
            let mut path = vec![(start, 0)];
            while let Some((at, next)) = path.last_mut() {
                let at = *at;
                let Some(&argument) = gates[at].get(*next) else {
                    state[at] = DONE;
                    order.push(at);
                    path.pop();
                    continue;
                };
                *next += 1;
                match state[argument] {
                    NEW => {
                        state[argument] = OPEN;
                        path.push((argument, 0));
                    }
                    OPEN => self.cycle(&path, argument, mistakes),
                    _ => {}
                }
            }
        }
        order
    }

    fn cycle(&self, path: &[(usize, usize)], back_to: usize, mistakes: &mut Mistakes<'_>) {
        /// Names of a cycle that are shown at its ends.
        const SHOWN: usize = 6;
        // From the end, so that a short way back costs little however deep it is.
        let length = path
            .iter()
            .rev()
            .take_while(|(at, _)| *at != back_to)
            .count()
            + 1;
        let cycle = &path[path.len() - length..];
        let name = |index: usize| match &self.definitions[index].name {
            Some(name) => name.as_str(),
            None => "(formula)",
        };
        let mut shown: Vec<&str> = cycle.iter().take(SHOWN).map(|(at, _)| name(*at)).collect();
        if cycle.len() > 2 * SHOWN {
            shown.push("...");
        }
        let rest = cycle.len().saturating_sub(SHOWN).min(SHOWN);
        shown.extend(cycle[cycle.len() - rest..].iter().map(|(at, _)| name(*at)));
        shown.push(name(back_to));
        let message = format!(
            "`{}` depends on itself: {}",
            name(back_to),
            shown.join(" -> ")
        );
        let span = self.definitions[back_to].span.clone();
        mistakes.add(
            span,
            message,
            "take one of these arguments away: a fault tree has no cycles",
        );
    }

    fn build(self, gates: Vec<Vec<usize>>, order: &[usize], top: Option<usize>) -> FaultTree {
        let mut place = vec![NodeId(0); gates.len()];
        for (position, index) in order.iter().enumerate() {
            place[*index] = NodeId(position as u32);
        }
        let mut definitions: Vec<Option<Definition>> =
            self.definitions.into_iter().map(Some).collect();
        let mut tree = FaultTree {
            nodes: Vec::with_capacity(order.len()),
            by_name: BTreeMap::new(),
            top: top.map(|index| place[index]),
        };
        for index in order {
            let definition = definitions[*index].take().expect("each once");
            let kind = match definition.body {
                Body::Basic(data) => NodeKind::Basic(data),
                Body::House(value) => NodeKind::House(value),
                Body::Gate(connective, _) => {
                    let arguments = gates[*index].iter().map(|it| place[*it]);
                    NodeKind::Gate(connective, arguments.collect())
                }
                Body::Unknown => unreachable!("what is not understood is a mistake"),
            };
            if let Some(name) = &definition.name {
                tree.by_name.insert(name.clone(), place[*index]);
            }
            tree.nodes.push(Node {
                name: definition.name,
                kind,
                span: definition.span,
            });
        }
        if tree.top.is_none() {
            let roots = tree.roots();
            tree.top = (roots.len() == 1).then(|| roots[0]);
        }
        tree
    }
}

/// The definitions by name; a name that is defined twice is a mistake.
fn names<'a>(
    definitions: &'a [Definition],
    mistakes: &mut Mistakes<'_>,
) -> HashMap<&'a str, usize> {
    let mut by_name: HashMap<&str, usize> = HashMap::with_capacity(definitions.len());
    for (index, definition) in definitions.iter().enumerate() {
        let Some(name) = &definition.name else {
            continue;
        };
        if let Some(first) = by_name.get(name.as_str()) {
            let message = format!("`{name}` is defined twice");
            mistakes.add(
                definition.span.clone(),
                message,
                "give one of them another name, or take it away",
            );
            mistakes.relate(definitions[*first].span.clone(), "first defined here");
        } else {
            by_name.insert(name, index);
        }
    }
    by_name
}

/// An argument given twice changes what a count or an exclusive or means, and is seldom meant.
fn repeated(
    connective: Connective,
    bound: &[usize],
    definition: &Definition,
    mistakes: &mut Mistakes<'_>,
) {
    let matters = matches!(connective, Connective::AtLeast(_) | Connective::Xor);
    if !matters {
        return;
    }
    let mut sorted = bound.to_vec();
    sorted.sort_unstable();
    if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
        let name = definition.name.as_deref().unwrap_or("this formula");
        let message = format!("`{name}` has the same argument twice, which would count it twice");
        mistakes.add(definition.span.clone(), message, "name each argument once");
    }
}

/// Warnings of what the top event does not depend on.
fn unused(tree: &FaultTree, source: &Source) -> Vec<Problem> {
    let mut mistakes = Mistakes::new(source);
    let Some(top) = tree.top else {
        let roots = tree.roots();
        let names: Vec<&str> = roots.iter().take(5).map(|id| tree.name(*id)).collect();
        let message = match roots.is_empty() {
            true => "the text has no gate, so no top event".to_owned(),
            false => format!(
                "{} gates are not arguments of another gate, so no single one is the top event: {}{}",
                roots.len(),
                names.join(", "),
                if roots.len() > 5 { ", ..." } else { "" }
            ),
        };
        mistakes.add(0..0, message, "say which event is asked for");
        return mistakes.into_problems(&[]).0;
    };
    let used = below(tree, top);
    for (id, node) in tree.nodes() {
        if let (false, Some(name)) = (used[id.index()], &node.name) {
            let message = format!("`{name}` is not part of `{}`", tree.name(top));
            mistakes.add(
                node.span.clone(),
                message,
                "use it as an argument, or take it away",
            );
        }
    }
    mistakes.into_problems(&[]).0
}

/// Which nodes an event depends on, itself included.
pub(crate) fn below(tree: &FaultTree, top: NodeId) -> Vec<bool> {
    let mut used = vec![false; tree.nodes.len()];
    used[top.index()] = true;
    // Arguments stand before their gates.
    for index in (0..=top.index()).rev() {
        if let (true, NodeKind::Gate(_, arguments)) = (used[index], &tree.nodes[index].kind) {
            arguments.iter().for_each(|it| used[it.index()] = true);
        }
    }
    used
}
