//! Normal forms of expressions and commands under a permutation, each with a number: equal numbers are equal normal forms.
//!
//! Operands of sums, products, conjunctions, disjunctions, least and greatest numbers are joined and sorted, those of
//! equalities sorted, and `a > b` is `b < a`. Conjunctions and disjunctions in which something may have no value keep their
//! order, since what comes first decides whether the rest is evaluated. Cost: a look-up in a table for each operator.

use prism_lang::ast::{BinaryOp, UnaryOp};
use prism_lang::resolved::{Command, Model, RewardStructure, Update};
use prism_lang::{Expr, ExprKind, Function, Number};
use rustc_hash::FxHashMap;

use super::guess::Permutation;

/// The number of a normal form.
pub(super) type Term = u32;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Operator {
    Bool,
    Int,
    Double,
    Variable,
    Parameter,
    Unary(UnaryOp),
    Binary(BinaryOp),
    Choice,
    Call(Function),
    Assignment,
    Update,
    Command,
    Item,
}

/// Normal forms that were met.
#[derive(Default)]
pub(super) struct Terms<'m> {
    known: FxHashMap<(Operator, i64, Vec<Term>), Term>,
    /// For each of them its operands if they can be joined with those of the same operator around, and whether it may
    /// have no value.
    joined: Vec<Option<(BinaryOp, Vec<Term>)>>,
    may_fail: Vec<bool>,
    numbers: Vec<&'m Number>,
}

impl<'m> Terms<'m> {
    /// The normal form of an expression's image.
    pub fn of(&mut self, expr: &'m Expr, permutation: &Permutation) -> Term {
        match &expr.kind {
            ExprKind::Bool(value) => self.leaf(Operator::Bool, i64::from(*value)),
            ExprKind::Int(value) => self.leaf(Operator::Int, *value),
            ExprKind::Double(number) => {
                let known = self.numbers.iter().position(|other| *other == number);
                let place = known.unwrap_or_else(|| {
                    self.numbers.push(number);
                    self.numbers.len() - 1
                });
                self.leaf(Operator::Double, place as i64)
            }
            ExprKind::Variable(index) => {
                self.leaf(Operator::Variable, permutation.variable[*index] as i64)
            }
            ExprKind::Parameter(index) => self.leaf(Operator::Parameter, *index as i64),
            ExprKind::Unary(operator, a) => {
                let a = self.of(a, permutation);
                self.node(Operator::Unary(*operator), vec![a])
            }
            ExprKind::Binary(operator, a, b) => {
                let (a, b) = (self.of(a, permutation), self.of(b, permutation));
                self.binary(*operator, a, b)
            }
            ExprKind::IfThenElse(a, b, c) => {
                let parts = [a, b, c].map(|e| self.of(e, permutation));
                self.node(Operator::Choice, parts.to_vec())
            }
            ExprKind::Call(function, arguments) => {
                let mut parts: Vec<Term> = (arguments.iter())
                    .map(|a| self.of(a, permutation))
                    .collect();
                if matches!(function, Function::Min | Function::Max) {
                    parts.sort_unstable();
                }
                self.node(Operator::Call(*function), parts)
            }
        }
    }

    fn binary(&mut self, operator: BinaryOp, a: Term, b: Term) -> Term {
        let may_fail = self.may_fail[a as usize] || self.may_fail[b as usize];
        let node = Operator::Binary;
        match operator {
            BinaryOp::And | BinaryOp::Or if may_fail => self.node(node(operator), vec![a, b]),
            BinaryOp::And | BinaryOp::Or | BinaryOp::Plus | BinaryOp::Times => {
                let mut parts = Vec::new();
                for side in [a, b] {
                    match &self.joined[side as usize] {
                        Some((own, operands)) if *own == operator => parts.extend(operands),
                        _ => parts.push(side),
                    }
                }
                parts.sort_unstable();
                let term = self.node(node(operator), parts.clone());
                self.joined[term as usize] = Some((operator, parts));
                term
            }
            BinaryOp::Equal | BinaryOp::NotEqual | BinaryOp::Iff => {
                self.node(node(operator), vec![a.min(b), a.max(b)])
            }
            BinaryOp::Greater => self.node(node(BinaryOp::Less), vec![b, a]),
            BinaryOp::GreaterEqual => self.node(node(BinaryOp::LessEqual), vec![b, a]),
            _ => self.node(node(operator), vec![a, b]),
        }
    }

    /// The images of a module's commands, sorted.
    pub fn commands(
        &mut self,
        model: &'m Model,
        module: usize,
        permutation: &Permutation,
    ) -> Vec<Term> {
        let commands = model.modules[module].commands.iter();
        let mut images: Vec<Term> = commands.map(|c| self.command(c, permutation)).collect();
        images.sort_unstable();
        images
    }

    fn command(&mut self, command: &'m Command, permutation: &Permutation) -> Term {
        let mut parts = vec![self.of(&command.guard, permutation)];
        let updates = command.updates.iter();
        parts.extend(updates.map(|update| self.update(update, permutation)));
        parts[1..].sort_unstable();
        self.intern(
            Operator::Command,
            action(command.action, permutation),
            parts,
        )
    }

    fn update(&mut self, update: &'m Update, permutation: &Permutation) -> Term {
        let mut parts = vec![self.of(&update.probability, permutation)];
        for (variable, value) in &update.assignments {
            let value = self.of(value, permutation);
            let variable = permutation.variable[*variable] as i64;
            parts.push(self.intern(Operator::Assignment, variable, vec![value]));
        }
        parts[1..].sort_unstable();
        self.node(Operator::Update, parts)
    }

    /// The images of a reward structure's items, sorted.
    pub fn items(&mut self, rewards: &'m RewardStructure, permutation: &Permutation) -> Vec<Term> {
        let mut images = Vec::new();
        for item in &rewards.items {
            let parts = [&item.guard, &item.value].map(|e| self.of(e, permutation));
            let transition = item.transition.map_or(-2, |a| action(a, permutation));
            images.push(self.intern(Operator::Item, transition, parts.to_vec()));
        }
        images.sort_unstable();
        images
    }

    fn leaf(&mut self, operator: Operator, value: i64) -> Term {
        self.intern(operator, value, Vec::new())
    }

    fn node(&mut self, operator: Operator, operands: Vec<Term>) -> Term {
        self.intern(operator, 0, operands)
    }

    fn intern(&mut self, operator: Operator, value: i64, operands: Vec<Term>) -> Term {
        let partial = matches!(
            operator,
            Operator::Binary(BinaryOp::Divide | BinaryOp::Power)
                | Operator::Call(Function::Mod | Function::Pow | Function::Log)
        );
        let may_fail = partial || operands.iter().any(|o| self.may_fail[*o as usize]);
        let new = self.joined.len() as Term;
        let term = *self.known.entry((operator, value, operands)).or_insert(new);
        if term == new {
            self.joined.push(None);
            self.may_fail.push(may_fail);
        }
        term
    }
}

/// The number of an action's image; -1 for none.
fn action(action: Option<usize>, permutation: &Permutation) -> i64 {
    action.map_or(-1, |a| permutation.action[a] as i64)
}
