//! What a symmetry must keep, in pieces: a candidate is compared only where it changes something.
//!
//! *Definition.* A group is a set with repetitions of normal forms: the commands of a module, the items of a reward structure,
//! the operands of a conjunction, disjunction, sum or product in which nothing may lack a value, or a single expression.
//! A permutation keeps a group that it maps to itself if the images of its pieces are its pieces, in any order.
//!
//! *Method.* A piece without a variable or action that moves is its own image. Both sides have these in common, so it is enough
//! to compare the others. Cost of a candidate: the size of the pieces that mention what it moves.

use prism_lang::resolved::{ActionId, Command, Model, RewardItem};
use prism_lang::{Expr, VarIndex};

use super::guess::Permutation;
use super::terms::{Term, Terms};

#[derive(Clone, Copy)]
pub(super) enum Piece<'m> {
    Command(&'m Command),
    Item(&'m RewardItem),
    Expr(&'m Expr),
}

impl<'m> Piece<'m> {
    fn term(self, terms: &mut Terms<'m>, permutation: &Permutation) -> Term {
        match self {
            Self::Command(command) => terms.command(command, permutation),
            Self::Item(item) => terms.item(item, permutation),
            Self::Expr(expr) => terms.of(expr, permutation),
        }
    }

    fn action(self) -> Option<ActionId> {
        match self {
            Self::Command(command) => command.action,
            Self::Item(item) => item.transition.flatten(),
            Self::Expr(_) => None,
        }
    }

    /// The variables that it mentions, ascending.
    fn variables(self) -> Vec<VarIndex> {
        let mut found = match self {
            Self::Command(command) => {
                let mut found = command.guard.variables();
                for update in &command.updates {
                    found.extend(update.probability.variables());
                    for (variable, value) in &update.assignments {
                        found.push(*variable);
                        found.extend(value.variables());
                    }
                }
                found
            }
            Self::Item(item) => [item.guard.variables(), item.value.variables()].concat(),
            Self::Expr(expr) => expr.variables(),
        };
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Groups of pieces; those of the modules come first.
pub(super) struct Pieces<'m> {
    /// Each with its group and its normal form, by ascending group.
    all: Vec<(Piece<'m>, usize, Term)>,
    /// Where the pieces of each group begin, and where the last ends.
    begins: Vec<usize>,
    by_variable: Vec<Vec<usize>>,
    by_action: Vec<Vec<usize>>,
    identity: Permutation,
}

impl<'m> Pieces<'m> {
    /// The commands of each module.
    pub fn of_modules(model: &'m Model, terms: &mut Terms<'m>) -> Self {
        let mut pieces = Self {
            all: Vec::new(),
            begins: vec![0],
            by_variable: vec![Vec::new(); model.variables.len()],
            by_action: vec![Vec::new(); model.actions.len()],
            identity: Permutation::identity(model),
        };
        for module in &model.modules {
            pieces.add(module.commands.iter().map(Piece::Command), terms);
        }
        pieces
    }

    pub fn groups(&self) -> usize {
        self.begins.len() - 1
    }

    /// Adds a group.
    pub fn add(&mut self, group: impl IntoIterator<Item = Piece<'m>>, terms: &mut Terms<'m>) {
        let number = self.groups();
        for piece in group {
            let place = self.all.len();
            for variable in piece.variables() {
                self.by_variable[variable].push(place);
            }
            if let Some(action) = piece.action() {
                self.by_action[action].push(place);
            }
            let term = piece.term(terms, &self.identity);
            self.all.push((piece, number, term));
        }
        self.begins.push(self.all.len());
    }

    /// Adds the group of an expression that must keep its value.
    pub fn add_expr(&mut self, expr: &'m Expr, terms: &mut Terms<'m>) {
        let operands = terms.operands(expr, &self.identity);
        self.add(operands.into_iter().map(Piece::Expr), terms);
    }

    /// Whether these groups, each mapped to itself, are kept.
    pub fn keeps(
        &self,
        groups: std::ops::Range<usize>,
        terms: &mut Terms<'m>,
        permutation: &Permutation,
    ) -> bool {
        let moved_actions = (0..permutation.action.len()).filter(|a| permutation.action[*a] != *a);
        let by_action = moved_actions.flat_map(|a| &self.by_action[a]);
        let by_variable = permutation.moved().flat_map(|v| &self.by_variable[v]);
        let range = self.begins[groups.start]..self.begins[groups.end];
        let mut touched: Vec<usize> = (by_variable.chain(by_action).copied())
            .filter(|place| range.contains(place))
            .collect();
        touched.sort_unstable();
        touched.dedup();
        let group = |place: &usize| self.all[*place].1;
        touched
            .chunk_by(|a, b| group(a) == group(b))
            .filter(|of_group| stays(group(&of_group[0]), permutation))
            .all(|of_group| {
                let places = || of_group.iter().map(|place| &self.all[*place]);
                let images = places().map(|(piece, ..)| piece.term(terms, permutation));
                sorted(images) == sorted(places().map(|(.., term)| *term))
            })
    }

    /// Whether the commands of each module that moves become those of its image.
    pub fn maps_modules(&self, terms: &mut Terms<'m>, permutation: &Permutation) -> bool {
        let moved = (0..permutation.module.len()).filter(|m| !stays(*m, permutation));
        let mut moved = moved.map(|module| (module, permutation.module[module]));
        moved.all(|(module, image)| {
            let (from, to) = (self.group(module), self.group(image));
            let images = (from.iter()).map(|(piece, ..)| piece.term(terms, permutation));
            from.len() == to.len() && sorted(images) == sorted(to.iter().map(|(.., term)| *term))
        })
    }

    fn group(&self, number: usize) -> &[(Piece<'m>, usize, Term)] {
        &self.all[self.begins[number]..self.begins[number + 1]]
    }
}

/// Whether a group is mapped to itself: only modules are not.
fn stays(group: usize, permutation: &Permutation) -> bool {
    permutation
        .module
        .get(group)
        .is_none_or(|image| *image == group)
}

fn sorted(terms: impl Iterator<Item = Term>) -> Vec<Term> {
    let mut terms: Vec<Term> = terms.collect();
    terms.sort_unstable();
    terms
}
