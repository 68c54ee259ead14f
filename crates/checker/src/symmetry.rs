//! Symmetries of a model: permutations of its variables under which it behaves the same, and that a property does not notice.
//!
//! *Definition.* A permutation of variables (with equal ranges), of actions and of modules is an automorphism of a model if
//! it maps the commands of each module to those of the module's image, and keeps the initial states. If it also keeps every
//! predicate, label, expression and reward structure that the properties speak of, a state and its image satisfy the same
//! formulas and have the same values: the permutation is a bisimulation. So it is enough to explore one state of each orbit:
//! each target of a transition is replaced with the representative of its orbit, and what then coincides is merged.
//!
//! *Method.* Candidates come from matching two modules command by command, as modules that were made by renaming do
//! (`guess.rs`); where the model has such a symmetry but a property notices, a second pair of modules is exchanged
//! with the first. Each candidate is verified on all commands: expressions are brought into a normal form in which operands of
//! commutative operators are sorted, and compared as a whole (`terms.rs`); nothing is assumed of how a candidate was
//! found. The symmetries found are put together to classes (`Class`): blocks of variables that may be exchanged in any way, of
//! which the sorted order is the representative, and powers of one permutation, as in a ring, of which the least image is.
//!
//! *Source.* Kwiatkowska, Norman and Parker 2006, "Symmetry reduction for probabilistic model checking". Deviation: the
//! symmetries are found, not declared; not all of them are.
//!
//! *Guarantee.* Only verified permutations are used, so that every value is that of the whole model; a representative that
//! is not unique would cost states, not correctness. Not for fair schedulers, nor where states are listed or counted
//! (filters): then no symmetry is used.

mod guess;
mod terms;

use std::collections::BTreeSet;

use prism_lang::resolved::{Init, Model};
use prism_lang::{Expr, Property, VarIndex};

use guess::{Guess, Permutation};
use terms::{Term, Terms};

/// Candidates that may fail before the search ends.
const MOST_FAILURES: usize = 200;
/// The longest order of a permutation whose powers are used.
const LONGEST_ORDER: usize = 64;

/// Symmetries of a model that some properties do not notice; by default, none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Symmetry {
    pub(crate) classes: Vec<Class>,
}

/// Permutations that act on variables of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// All ways to exchange these blocks of variables, each in the same order.
    Blocks(Vec<Vec<VarIndex>>),
    /// These permutations and the identity: the pairs `(v, w)` say that the value of `v` becomes that of `w`.
    Powers(Vec<Vec<(VarIndex, VarIndex)>>),
}

impl Symmetry {
    /// The symmetries of a model that are found, and that none of the properties notices.
    ///
    /// ```
    /// use checker::symmetry::Symmetry;
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    /// let text = "mdp module a x : [0..9]; [] x<9 -> 0.5:(x'=x+1) + 0.5:true; endmodule
    ///     module b = a [x=y] endmodule";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    /// let tree = parse_properties("Pmax=? [ F x=9 & y=9 ]; Pmax=? [ F x=9 ]").tree;
    /// let asked = resolve_properties(&tree, &model, &Constants::new()).unwrap();
    /// assert!(!Symmetry::of(&model, [&asked[0].property]).is_none());
    /// assert!(Symmetry::of(&model, [&asked[1].property]).is_none());
    /// ```
    pub fn of<'p>(model: &Model, properties: impl IntoIterator<Item = &'p Property>) -> Self {
        let Some(asked) = Asked::of(model, properties) else {
            return Self::default();
        };
        if model.composition.is_some() {
            return Self::default();
        }
        let mut search = Search::new(model, asked);
        let found = search.generators();
        Self {
            classes: classes(&found, model.variables.len()),
        }
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.classes.is_empty()
    }
}

/// What must stay the same.
struct Asked<'m> {
    expressions: Vec<&'m Expr>,
    rewards: BTreeSet<usize>,
}

impl<'m> Asked<'m> {
    /// Nothing if it cannot be told, or states are listed.
    fn of<'p: 'm>(
        model: &'m Model,
        properties: impl IntoIterator<Item = &'p Property>,
    ) -> Option<Self> {
        let mut asked = Self {
            expressions: Vec::new(),
            rewards: BTreeSet::new(),
        };
        for property in properties {
            let mentioned = property.mentioned();
            if mentioned.has_filters {
                return None;
            }
            asked.expressions.extend(mentioned.expressions);
            asked.rewards.extend(mentioned.structures);
            for label in mentioned.labels {
                match model.label(label) {
                    Some(definition) => asked.expressions.push(definition),
                    None if ["init", "deadlock"].contains(&label) => {}
                    None => return None,
                }
            }
        }
        Some(asked)
    }
}

/// A symmetry, and the two modules that were matched first.
struct Generator {
    seed: (usize, usize),
    permutation: Permutation,
}

struct Search<'m> {
    model: &'m Model,
    asked: Asked<'m>,
    terms: Terms<'m>,
    /// The commands of each module as they are.
    commands: Vec<Vec<Term>>,
    failures: usize,
}

impl<'m> Search<'m> {
    fn new(model: &'m Model, asked: Asked<'m>) -> Self {
        let mut terms = Terms::default();
        let identity = Permutation::identity(model);
        let modules = 0..model.modules.len();
        let commands = modules.map(|m| terms.commands(model, m, &identity));
        Self {
            commands: commands.collect(),
            model,
            asked,
            terms,
            failures: 0,
        }
    }

    /// Symmetries that exchange modules; none for modules that those before already map to each other.
    fn generators(&mut self) -> Vec<Generator> {
        let modules = self.model.modules.len();
        let mut class: Vec<usize> = (0..modules).collect();
        let mut found = Vec::new();
        for first in 0..modules {
            for second in first + 1..modules {
                if class[first] == class[second] {
                    continue;
                }
                if self.failures > MOST_FAILURES {
                    return found;
                }
                let Some(permutation) = self.exchanging((first, second)) else {
                    self.failures += 1;
                    continue;
                };
                for (module, image) in permutation.module.iter().enumerate() {
                    let (old, new) = (class[module], class[*image]);
                    class
                        .iter_mut()
                        .filter(|c| **c == old)
                        .for_each(|c| *c = new);
                }
                found.push(Generator {
                    seed: (first, second),
                    permutation,
                });
            }
        }
        found
    }

    fn exchanging(&mut self, seed: (usize, usize)) -> Option<Permutation> {
        let alone = Guess::from(self.model, &[seed])?;
        if !self.keeps_model(&alone) {
            return None;
        }
        if self.keeps_asked(&alone) {
            return Some(alone);
        }
        let modules = &self.model.modules;
        let stays = |module: &usize| alone.module[*module] == *module;
        let pairs = (0..modules.len()).filter(stays).flat_map(|a| {
            let others = (a + 1..modules.len()).filter(stays);
            others.map(move |b| (a, b))
        });
        let like =
            |(a, b): &(usize, usize)| modules[*a].commands.len() == modules[*b].commands.len();
        let pairs: Vec<(usize, usize)> = pairs.filter(like).collect();
        for pair in pairs {
            if self.failures > MOST_FAILURES {
                return None;
            }
            match Guess::from(self.model, &[seed, pair]) {
                Some(both) if self.keeps_asked(&both) && self.keeps_model(&both) => {
                    return Some(both);
                }
                _ => self.failures += 1,
            }
        }
        None
    }

    /// Whether a permutation is an automorphism of the model.
    fn keeps_model(&mut self, permutation: &Permutation) -> bool {
        let model = self.model;
        let keeps_start = match &model.init {
            Init::Single(values) => {
                let images = values.iter().zip(&permutation.variable);
                images
                    .into_iter()
                    .all(|(value, image)| values[*image] == *value)
            }
            Init::Predicate(predicate) => self.keeps(predicate, permutation),
        };
        let kinds = model.variables.iter().zip(&permutation.variable);
        let keeps_kinds = kinds
            .into_iter()
            .all(|(v, image)| v.kind == model.variables[*image].kind);
        keeps_start
            && keeps_kinds
            && (0..model.modules.len()).all(|module| {
                let images = self.terms.commands(model, module, permutation);
                images == self.commands[permutation.module[module]]
            })
    }

    fn keeps_asked(&mut self, permutation: &Permutation) -> bool {
        let (expressions, rewards) = (self.asked.expressions.clone(), self.asked.rewards.clone());
        let identity = Permutation::identity(self.model);
        expressions.iter().all(|e| self.keeps(e, permutation))
            && rewards.iter().all(|index| {
                let Some(structure) = self.model.rewards.get(*index) else {
                    return false;
                };
                let images = self.terms.items(structure, permutation);
                images == self.terms.items(structure, &identity)
            })
    }

    fn keeps(&mut self, expr: &'m Expr, permutation: &Permutation) -> bool {
        let identity = Permutation::identity(self.model);
        self.terms.of(expr, permutation) == self.terms.of(expr, &identity)
    }
}

/// Classes that act on variables of their own.
fn classes(found: &[Generator], variables: usize) -> Vec<Class> {
    let mut taken = vec![false; variables];
    let mut classes = Vec::new();
    let is_exchange = |g: &&Generator| g.permutation.is_involution();
    let mut bases: Vec<usize> = found.iter().map(|g| g.seed.0).collect();
    bases.dedup();
    for base in bases {
        let own = found.iter().filter(|g| g.seed.0 == base);
        let exchanges: Vec<&Permutation> =
            own.filter(is_exchange).map(|g| &g.permutation).collect();
        if let Some(blocks) = blocks(&exchanges) {
            take(Class::Blocks(blocks), &mut taken, &mut classes);
        }
    }
    for other in found.iter().filter(|g| !is_exchange(g)) {
        if let Some(powers) = powers(&other.permutation) {
            take(Class::Powers(powers), &mut taken, &mut classes);
        }
    }
    classes
}

/// Adds a class unless it acts on variables of another one.
fn take(class: Class, taken: &mut [bool], classes: &mut Vec<Class>) {
    let moved: Vec<VarIndex> = match &class {
        Class::Blocks(blocks) => blocks.iter().flatten().copied().collect(),
        Class::Powers(powers) => powers.iter().flatten().map(|(v, _)| *v).collect(),
    };
    if moved.iter().all(|v| !taken[*v]) {
        moved.iter().for_each(|v| taken[*v] = true);
        classes.push(class);
    }
}

/// The blocks that involutions exchange with one of them, which they all move; the first two if they do not agree on it.
fn blocks(exchanges: &[&Permutation]) -> Option<Vec<Vec<VarIndex>>> {
    let moved = |p: &Permutation| -> BTreeSet<VarIndex> { p.moved().collect() };
    let first = exchanges.first()?;
    if exchanges.len() > 1 {
        let all = exchanges.iter().map(|p| moved(p));
        let base = all.reduce(|a, b| &a & &b)?;
        let mut blocks = vec![base.iter().copied().collect::<Vec<_>>()];
        let mut seen = base.clone();
        let is_star = exchanges.iter().all(|p| {
            let image: Vec<VarIndex> = base.iter().map(|v| p.variable[*v]).collect();
            let is_new = image.iter().all(|v| seen.insert(*v));
            blocks.push(image);
            is_new && moved(p).len() == 2 * base.len()
        });
        if is_star && !base.is_empty() {
            return Some(blocks);
        }
    }
    let half: Vec<VarIndex> = first.moved().filter(|v| *v < first.variable[*v]).collect();
    let image = half.iter().map(|v| first.variable[*v]).collect();
    (!half.is_empty()).then(|| vec![half, image])
}

/// All powers of a permutation but the identity; nothing if there are too many.
fn powers(permutation: &Permutation) -> Option<Vec<Vec<(VarIndex, VarIndex)>>> {
    let moved: Vec<VarIndex> = permutation.moved().collect();
    let mut powers = Vec::new();
    let mut image = moved.clone();
    loop {
        image.iter_mut().for_each(|v| *v = permutation.variable[*v]);
        if image == moved {
            return Some(powers);
        }
        if powers.len() == LONGEST_ORDER {
            return None;
        }
        powers.push(moved.iter().copied().zip(image.iter().copied()).collect());
    }
}

#[cfg(test)]
mod tests;
