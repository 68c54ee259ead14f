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
//! commutative operators are sorted, and compared as a whole (`terms.rs`), where they mention what a candidate moves
//! (`pieces.rs`); nothing is assumed of how it was found. The symmetries found are put together to classes (`Class`): blocks of variables that may be exchanged in any way, of
//! which the sorted order is the representative, and powers of one permutation, as in a ring, of which the least image is.
//!
//! *Source.* Kwiatkowska, Norman and Parker 2006, "Symmetry reduction for probabilistic model checking". Deviation: the
//! symmetries are found, not declared; not all of them are.
//!
//! *Cost.* For each of n modules, what mentions the variables and actions that a candidate moves, and tables of a word for
//! each variable, action and module: n modules of one kind take n candidates. Parts that are brought into a normal form are
//! counted, and the search ends after `MOST_PARTS` of them, or when it is asked to, with the symmetries that it has.
//!
//! *Guarantee.* Only verified permutations are used, so that every value is that of the whole model; a representative that
//! is not unique would cost states, not correctness. Not for fair schedulers, nor where states are listed or counted
//! (filters): then no symmetry is used.

mod guess;
mod pieces;
mod terms;

use std::collections::BTreeSet;

use prism_lang::resolved::{Init, Model};
use prism_lang::{Expr, Property, VarIndex};

use guess::{Guess, Owned, Permutation};
use pieces::{Piece, Pieces};
use terms::Terms;

/// Candidates that may fail before the search ends.
const MOST_FAILURES: usize = 200;
/// Parts of expressions of candidates that may be brought into a normal form before the search ends: seconds.
const MOST_PARTS: u64 = 20_000_000;
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
        Self::of_while(model, properties, &|| true)
    }

    /// Like [`Symmetry::of`]; when the function returns false, the symmetries found so far.
    pub fn of_while<'p>(
        model: &Model,
        properties: impl IntoIterator<Item = &'p Property>,
        go_on: &dyn Fn() -> bool,
    ) -> Self {
        let Some(asked) = Asked::of(model, properties) else {
            return Self::default();
        };
        if model.composition.is_some() {
            return Self::default();
        }
        let Some(mut search) = Search::new(model, &asked, go_on) else {
            return Self::default();
        };
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

/// A symmetry of variables, and the two modules that were matched first.
struct Generator {
    seed: (usize, usize),
    /// The variables that move, ascending, and their images.
    moves: Vec<(VarIndex, VarIndex)>,
}

impl Generator {
    /// The image of a variable.
    fn image(&self, variable: VarIndex) -> VarIndex {
        let place = self.moves.binary_search_by_key(&variable, |(v, _)| *v);
        place.map_or(variable, |place| self.moves[place].1)
    }

    /// Whether variables go back to where they were when it is done twice.
    fn is_involution(&self) -> bool {
        self.moves.iter().all(|(v, w)| self.image(*w) == *v)
    }

    fn moved(&self) -> impl Iterator<Item = VarIndex> {
        self.moves.iter().map(|(v, _)| *v)
    }
}

struct Search<'m, 'g> {
    model: &'m Model,
    owned: Owned,
    terms: Terms<'m>,
    /// The commands of each module, the predicate of the initial states if there is one, what is asked.
    pieces: Pieces<'m>,
    /// The first group of what is asked.
    asked: usize,
    failures: usize,
    /// How many parts may have been formed before the search ends.
    most_parts: u64,
    go_on: &'g dyn Fn() -> bool,
}

impl<'m, 'g> Search<'m, 'g> {
    /// Nothing if a reward structure is asked for that the model does not have.
    fn new(model: &'m Model, asked: &Asked<'m>, go_on: &'g dyn Fn() -> bool) -> Option<Self> {
        let mut terms = Terms::default();
        let mut pieces = Pieces::of_modules(model, &mut terms);
        if let Init::Predicate(predicate) = &model.init {
            pieces.add_expr(predicate, &mut terms);
        }
        let first_asked = pieces.groups();
        for expr in &asked.expressions {
            pieces.add_expr(expr, &mut terms);
        }
        for index in &asked.rewards {
            let structure = model.rewards.get(*index)?;
            pieces.add(structure.items.iter().map(Piece::Item), &mut terms);
        }
        Some(Self {
            model,
            owned: Owned::of(model),
            most_parts: terms.formed() + MOST_PARTS,
            terms,
            pieces,
            asked: first_asked,
            failures: 0,
            go_on,
        })
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
                if self.is_over() {
                    return found;
                }
                let Some(permutation) = self.exchanging((first, second)) else {
                    self.failures += 1;
                    continue;
                };
                join_classes(&mut class, &permutation);
                let moved = permutation.moved();
                found.push(Generator {
                    seed: (first, second),
                    moves: moved.map(|v| (v, permutation.variable[v])).collect(),
                });
            }
        }
        found
    }

    fn is_over(&self) -> bool {
        self.failures > MOST_FAILURES || self.terms.formed() > self.most_parts || !(self.go_on)()
    }

    fn exchanging(&mut self, seed: (usize, usize)) -> Option<Permutation> {
        let alone = Guess::from(self.model, &self.owned, &[seed])?;
        if !self.keeps_model(&alone) {
            return None;
        }
        if self.keeps_asked(&alone) {
            return Some(alone);
        }
        let modules = &self.model.modules;
        let stay: Vec<usize> = (0..modules.len())
            .filter(|module| alone.module[*module] == *module)
            .collect();
        for (place, a) in stay.iter().enumerate() {
            for b in &stay[place + 1..] {
                if modules[*a].commands.len() != modules[*b].commands.len() {
                    continue;
                }
                if self.is_over() {
                    return None;
                }
                match Guess::from(self.model, &self.owned, &[seed, (*a, *b)]) {
                    Some(both) if self.keeps_asked(&both) && self.keeps_model(&both) => {
                        return Some(both);
                    }
                    _ => self.failures += 1,
                }
            }
        }
        None
    }

    /// Whether a permutation is an automorphism of the model.
    fn keeps_model(&mut self, permutation: &Permutation) -> bool {
        let model = self.model;
        let image = |v: VarIndex| permutation.variable[v];
        let keeps_start = match &model.init {
            Init::Single(values) => permutation.moved().all(|v| values[image(v)] == values[v]),
            // One of the groups below.
            Init::Predicate(_) => true,
        };
        let kind = |v: VarIndex| &model.variables[v].kind;
        keeps_start
            && permutation.moved().all(|v| kind(v) == kind(image(v)))
            && self.pieces.maps_modules(&mut self.terms, permutation)
            && (self.pieces).keeps(0..self.asked, &mut self.terms, permutation)
    }

    fn keeps_asked(&mut self, permutation: &Permutation) -> bool {
        let asked = self.asked..self.pieces.groups();
        self.pieces.keeps(asked, &mut self.terms, permutation)
    }
}

/// Modules that a permutation maps to each other are of one class.
fn join_classes(class: &mut [usize], permutation: &Permutation) {
    for (module, image) in permutation.module.iter().enumerate() {
        let (old, new) = (class[module], class[*image]);
        if old != new {
            (class.iter_mut())
                .filter(|c| **c == old)
                .for_each(|c| *c = new);
        }
    }
}

/// Classes that act on variables of their own.
fn classes(found: &[Generator], variables: usize) -> Vec<Class> {
    let mut taken = vec![false; variables];
    let mut classes = Vec::new();
    let (exchanges, others): (Vec<&Generator>, Vec<&Generator>) =
        found.iter().partition(|g| g.is_involution());
    for of_base in exchanges.chunk_by(|a, b| a.seed.0 == b.seed.0) {
        if let Some(blocks) = blocks(of_base) {
            take(Class::Blocks(blocks), &mut taken, &mut classes);
        }
    }
    for other in others {
        if let Some(powers) = powers(other) {
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
fn blocks(exchanges: &[&Generator]) -> Option<Vec<Vec<VarIndex>>> {
    let moved = |p: &Generator| -> BTreeSet<VarIndex> { p.moved().collect() };
    let first = exchanges.first()?;
    if exchanges.len() > 1 {
        let all = exchanges.iter().map(|p| moved(p));
        let base = all.reduce(|a, b| &a & &b)?;
        let mut blocks = vec![base.iter().copied().collect::<Vec<_>>()];
        let mut seen = base.clone();
        let is_star = exchanges.iter().all(|p| {
            let image: Vec<VarIndex> = base.iter().map(|v| p.image(*v)).collect();
            let is_new = image.iter().all(|v| seen.insert(*v));
            blocks.push(image);
            is_new && moved(p).len() == 2 * base.len()
        });
        if is_star && !base.is_empty() {
            return Some(blocks);
        }
    }
    let half: Vec<VarIndex> = first.moved().filter(|v| *v < first.image(*v)).collect();
    let image = half.iter().map(|v| first.image(*v)).collect();
    (!half.is_empty()).then(|| vec![half, image])
}

/// All powers of a permutation but the identity; nothing if there are too many.
fn powers(permutation: &Generator) -> Option<Vec<Vec<(VarIndex, VarIndex)>>> {
    let moved: Vec<VarIndex> = permutation.moved().collect();
    let mut powers = Vec::new();
    let mut image = moved.clone();
    loop {
        image.iter_mut().for_each(|v| *v = permutation.image(*v));
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
