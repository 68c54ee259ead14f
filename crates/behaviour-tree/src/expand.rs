//! From elements to nodes: subtrees are put in their places, ports are looked up.

use std::collections::BTreeSet;

use crate::files::{Definitions, Element, as_written};
use crate::mistakes::{Mistakes, Spot};
use crate::tree::{Kind, Leaf, Node, NodeId, Outcome, Precondition, Script};
use crate::types::{Found, Typed, Value, whole};

/// How deep nodes may nest, subtrees included.
const MAX_DEPTH: usize = 200;
/// How many nodes a tree may have, subtrees included.
const MAX_NODES: usize = 10_000;

/// A node with what only its reading needs.
pub(crate) struct Drafted {
    pub node: Node,
    pub spot: Spot,
    /// Why it stands for all that is below it, or is taken for one version of several.
    pub why: Option<String>,
}

/// Names that the ports of a subtree have: its own element, and the scope around it.
#[derive(Clone, Copy)]
struct Scope<'s, 'd> {
    subtree: Option<Element<'d>>,
    around: Option<&'s Scope<'s, 'd>>,
}

pub(crate) struct Expansion<'a, 'd> {
    definitions: &'a Definitions<'d>,
    files: Vec<String>,
    texts: Vec<&'a str>,
    mistakes: &'a mut Mistakes,
    pub nodes: Vec<Drafted>,
    /// The trees around the element that is read.
    open: BTreeSet<&'d str>,
    depth: usize,
    /// Whether there are too many nodes, which is said once.
    is_full: bool,
}

impl<'a, 'd> Expansion<'a, 'd> {
    pub fn new(
        definitions: &'a Definitions<'d>,
        files: &'a [diagnostic::Source],
        mistakes: &'a mut Mistakes,
    ) -> Self {
        Self {
            definitions,
            files: files.iter().map(|it| it.name.clone()).collect(),
            texts: files.iter().map(|it| it.text.as_str()).collect(),
            mistakes,
            nodes: Vec::new(),
            open: BTreeSet::new(),
            depth: 0,
            is_full: false,
        }
    }

    /// All nodes of a tree, the root first.
    pub fn tree(&mut self, id: &'d str, element: Element<'d>) {
        let scope = Scope {
            subtree: None,
            around: None,
        };
        self.open.insert(id);
        self.root_of(element, None, &scope);
    }

    /// The one child of a `BehaviorTree`.
    fn root_of(&mut self, tree: Element<'d>, parent: Option<NodeId>, scope: &Scope<'_, 'd>) {
        let roots: Vec<Element<'d>> = tree.children().collect();
        if roots.len() != 1 {
            let message = format!("`BehaviorTree` has {} children, not 1", roots.len());
            let remedy = "put its nodes into one control node";
            self.mistakes.add(tree.spot(), message, remedy);
        }
        if let Some(root) = roots.first() {
            self.node(*root, parent, scope);
        }
    }

    fn node(&mut self, element: Element<'d>, parent: Option<NodeId>, scope: &Scope<'_, 'd>) {
        if self.nodes.len() >= MAX_NODES || self.depth >= MAX_DEPTH {
            self.too_large(element);
            return;
        }
        let Some((type_name, declared)) = self.type_of(element) else {
            return;
        };
        let is_subtree = matches!(type_name, "SubTree" | "SubTreePlus");
        let found = match is_subtree {
            true => self.subtree(element),
            false => self.typed(element, type_name, declared, scope),
        };
        let id = self.push(element, type_name, found, parent);
        self.depth += 1;
        match is_subtree {
            true => self.inside_subtree(element, id, scope),
            false => element
                .children()
                .for_each(|child| self.node(child, Some(id), scope)),
        }
        self.depth -= 1;
    }

    fn too_large(&mut self, element: Element<'d>) {
        if !std::mem::replace(&mut self.is_full, true) {
            let message = format!(
                "the tree nests deeper than {MAX_DEPTH} nodes or has more than {MAX_NODES}, subtrees included"
            );
            let remedy = "draft a model of a part of it";
            self.mistakes.refuse(element.spot(), message, remedy);
        }
    }

    /// The name of an element's type, and what the text says that it is.
    fn type_of(&mut self, element: Element<'d>) -> Option<(&'d str, Option<Option<Leaf>>)> {
        let tag = element.node.tag_name().name();
        let said = match tag {
            "Action" => Some(Leaf::Action),
            "Condition" => Some(Leaf::Condition),
            "Control" | "Decorator" => None,
            "SubTree" | "SubTreePlus" => return Some((tag, None)),
            _ => return Some((tag, self.definitions.types.get(tag).copied())),
        };
        let id = element.attribute("ID");
        if id.is_none() {
            let message = format!("`{tag}` has no ID");
            self.mistakes
                .add(element.spot(), message, "write `ID=\"...\"`");
        }
        id.map(|id| (id, Some(said)))
    }

    fn typed(
        &mut self,
        element: Element<'d>,
        type_name: &'d str,
        declared: Option<Option<Leaf>>,
        scope: &Scope<'_, 'd>,
    ) -> Found {
        let typed = Typed {
            element,
            type_name,
            declared,
            children: element.children().count(),
            is_format_4: self.definitions.is_format_4[element.file],
            value: &|name| scope.value(element, name),
        };
        typed.found(self.mistakes)
    }

    fn subtree(&mut self, element: Element<'d>) -> Found {
        let Some(id) = element.attribute("ID") else {
            let message = "`SubTree` has no ID";
            self.mistakes
                .add(element.spot(), message, "write `ID=\"...\"`");
            return Kind::Pass.into();
        };
        if element.children().next().is_some() {
            let message = format!("`SubTree` `{id}` has children");
            let remedy = "write them into the `BehaviorTree` that it names";
            self.mistakes.add(element.spot(), message, remedy);
        }
        if self.open.contains(id) {
            let message = format!("the tree `{id}` contains itself");
            self.mistakes
                .add(element.spot_of("ID"), message, "take the inner one away");
        } else if !self.definitions.trees.contains_key(id) {
            let trees = self.definitions.trees.keys().copied();
            let similar = diagnostic::did_you_mean(id, trees);
            let similar = similar.map_or(String::new(), |it| format!(" (did you mean `{it}`?)"));
            return whole(format!("the tree `{id}` is not defined here{similar}"));
        }
        Kind::Pass.into()
    }

    fn inside_subtree(&mut self, element: Element<'d>, id: NodeId, scope: &Scope<'_, 'd>) {
        let name = element.attribute("ID").filter(|it| !self.open.contains(it));
        let found = name.and_then(|name| Some((name, *self.definitions.trees.get(name)?)));
        let Some((name, tree)) = found else { return };
        let inner = Scope {
            subtree: Some(element),
            around: Some(scope),
        };
        self.open.insert(name);
        self.root_of(tree, Some(id), &inner);
        self.open.remove(name);
    }

    fn push(
        &mut self,
        element: Element<'d>,
        type_name: &'d str,
        found: Found,
        parent: Option<NodeId>,
    ) -> NodeId {
        let id = NodeId(self.nodes.len());
        let given = element.attribute("name");
        let own = match type_name {
            "SubTree" | "SubTreePlus" => element.attribute("ID").unwrap_or(type_name),
            _ => type_name,
        };
        let name = as_written(given.unwrap_or(own));
        let path = match parent {
            Some(parent) => format!("{}/{name}", self.nodes[parent.0].node.path),
            None => name.clone(),
        };
        let place = parent.map(|parent| {
            let siblings = &mut self.nodes[parent.0].node.children;
            siblings.push(id);
            (parent, siblings.len() - 1)
        });
        let spot = element.spot();
        let node = Node {
            kind: found.kind,
            name,
            type_name: own.to_owned(),
            label: String::new(),
            path,
            file: self.files[element.file].clone(),
            line: diagnostic::line_and_column(self.texts[element.file], spot.start).0,
            parent: place,
            children: Vec::new(),
            preconditions: self.preconditions(element),
            is_reactive: found.is_reactive,
            is_named: given.is_some() || own != type_name,
        };
        self.nodes.push(Drafted {
            node,
            spot,
            why: found.why,
        });
        id
    }

    fn preconditions(&mut self, element: Element<'d>) -> Vec<(Precondition, Script)> {
        let mut found = Vec::new();
        for which in Precondition::ALL {
            let Some(text) = element.attribute(&format!("_{}", which.word())) else {
                continue;
            };
            if !self.definitions.is_format_4[element.file] {
                let message = format!("`_{}` is an attribute of format 4", which.word());
                let remedy = "write `BTCPP_format=\"4\"` on `<root>`";
                self.mistakes.add(element.spot(), message, remedy);
            }
            let literal = match text.trim() {
                "true" | "1" => Some(true),
                "false" | "0" => Some(false),
                _ => None,
            };
            let text = as_written(text);
            found.push((which, Script { text, literal }));
        }
        found
    }
}

impl<'d> Scope<'_, 'd> {
    /// The value of an attribute of an element in this scope.
    fn value(&self, element: Element<'d>, name: &str) -> Value<'d> {
        match element.attribute(name) {
            None => Value::Absent,
            Some(text) => self.resolved(text),
        }
    }

    /// A text, or what the subtree's ports give for the entry that it names.
    fn resolved(&self, text: &'d str) -> Value<'d> {
        let trimmed = text.trim();
        let entry = trimmed.strip_prefix('$').unwrap_or(trimmed);
        let entry = entry.strip_prefix('{').and_then(|it| it.strip_suffix('}'));
        let Some(entry) = entry else {
            return Value::Text(text);
        };
        let port = self.subtree.and_then(|it| Some((it, it.attribute(entry)?)));
        match (port, self.around) {
            (Some((_, "{=}")), _) | (_, None) => Value::Entry(entry),
            // What is not a literal may be changed by whoever shares the entry.
            (Some((_, given)), Some(around)) => around.resolved(given),
            (None, _) => Value::Entry(entry),
        }
    }
}

/// Whether a result is one that a parent cannot go on with, for which the whole is one leaf.
pub(crate) fn cannot_go_on(kind: &Kind, type_name: &str, may_skip: &[bool]) -> Option<String> {
    let any = may_skip.iter().any(|it| *it);
    match kind {
        Kind::Choice if may_skip.first() == Some(&true) => {
            Some("its condition may be skipped, which ends with an error".to_owned())
        }
        Kind::Parallel { all: false, .. } if any => Some(
            "children that may be skipped are executed again until the counts are reached"
                .to_owned(),
        ),
        Kind::Sequence { .. } if any && type_name == "NonblockingSequence" => {
            Some("a child may be skipped, which ends with an error".to_owned())
        }
        _ => None,
    }
}

/// Which results each node may give, children before parents: success, failure, skipped.
pub(crate) fn outcomes(kind: &Kind, children: &[[bool; 3]]) -> [bool; 3] {
    let any = |which: Outcome| children.iter().any(|it| it[which as usize]);
    let all = |which: Outcome| children.iter().all(|it| it[which as usize]);
    let (success, failure, skipped) = (Outcome::Success, Outcome::Failure, Outcome::Skipped);
    let child = children.first().copied().unwrap_or([true, true, false]);
    match kind {
        Kind::Leaf(_) => [true, true, false],
        Kind::Always(outcome) => single(*outcome),
        Kind::Sequence { all_skipped, .. } => {
            let skips = all(skipped) && *all_skipped == skipped;
            [true, any(failure), skips]
        }
        Kind::Fallback | Kind::RoundRobin { .. } => [any(success), true, all(skipped)],
        Kind::Parallel { .. } => [true, true, false],
        Kind::ParallelAll { .. } => [true, true, all(skipped)],
        Kind::Choice => {
            let branches = &children[1..];
            let may = |which: Outcome| branches.iter().any(|it| it[which as usize]);
            [
                may(success),
                may(failure) || branches.len() < 2,
                may(skipped),
            ]
        }
        Kind::Switch => [any(success), any(failure), any(skipped)],
        Kind::TryCatch => {
            let tried = &children[..children.len().saturating_sub(1)];
            let skips = tried.iter().all(|it| it[skipped as usize]);
            [true, true, skips]
        }
        Kind::Inverter => [child[1], child[0], child[2]],
        Kind::Force(outcome) => {
            let forced = single(*outcome);
            [forced[0], forced[1], child[2]]
        }
        Kind::Retry(_) | Kind::Repeat(_) => child,
        Kind::KeepRunningUntilFailure => [false, child[1], false],
        Kind::RunOnce { then_skip } => [child[0], child[1], child[2] || *then_skip],
        Kind::Gate(outcome) => {
            let other = single(*outcome);
            [
                child[0] || other[0],
                child[1] || other[1],
                child[2] || other[2],
            ]
        }
        Kind::Deadline => [child[0], true, child[2]],
        Kind::Pass => child,
        Kind::Recovery(_) => [true, true, child[2]],
    }
}

/// Preconditions add results of their own.
pub(crate) fn with_preconditions(
    mut found: [bool; 3],
    preconditions: &[(Precondition, Script)],
) -> [bool; 3] {
    for (which, script) in preconditions {
        for value in [true, false] {
            let ends = which.ends(value).filter(|_| script.literal != Some(!value));
            if let Some(outcome) = ends {
                found[outcome as usize] = true;
            }
        }
    }
    found
}

fn single(outcome: Outcome) -> [bool; 3] {
    let mut found = [false; 3];
    found[outcome as usize] = true;
    found
}
