//! Normal forms of expressions and commands under a permutation, each with a number: equal numbers are equal normal forms.
//!
//! Operands of sums, products, conjunctions, disjunctions, least and greatest numbers are joined and sorted, those of
//! equalities sorted, and `a > b` is `b < a`. Conjunctions and disjunctions in which something may have no value keep their
//! order, since what comes first decides whether the rest is evaluated. Cost: a look-up in a table for each operator, and
//! sorting the operands of a chain.

use prism_lang::ast::{BinaryOp, UnaryOp};
use prism_lang::resolved::{Command, RewardItem, Update};
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
    /// How many were formed, known ones included.
    formed: u64,
}

impl<'m> Terms<'m> {
    /// How many normal forms of parts were formed so far: what the work is measured by.
    pub fn formed(&self) -> u64 {
        self.formed
    }

    /// The operands of an expression whose order does not matter; the expression itself if there are none such.
    pub fn operands(&mut self, expr: &'m Expr, permutation: &Permutation) -> Vec<&'m Expr> {
        let Some(operator) = chained(expr) else {
            return vec![expr];
        };
        let operands = chain(expr, operator);
        let terms = operands.iter().map(|o| self.of(o, permutation));
        let terms: Vec<Term> = terms.collect();
        match self.is_ordered(operator, &terms) {
            true => vec![expr],
            false => operands,
        }
    }

    /// Whether what comes first decides whether the rest is evaluated.
    fn is_ordered(&self, operator: BinaryOp, operands: &[Term]) -> bool {
        matches!(operator, BinaryOp::And | BinaryOp::Or)
            && operands.iter().any(|o| self.may_fail[*o as usize])
    }

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
            ExprKind::Binary(operator, a, b) => match chained(expr) {
                Some(operator) => self.chain(expr, operator, permutation),
                None => {
                    let (a, b) = (self.of(a, permutation), self.of(b, permutation));
                    self.binary(*operator, a, b)
                }
            },
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

    /// A chain of one operator, joined at once where its order does not matter.
    fn chain(&mut self, expr: &'m Expr, operator: BinaryOp, permutation: &Permutation) -> Term {
        let operands = chain(expr, operator);
        let mut terms: Vec<Term> = operands.iter().map(|o| self.of(o, permutation)).collect();
        if self.is_ordered(operator, &terms) {
            return self.nested(expr, operator, &mut terms.into_iter());
        }
        terms.sort_unstable();
        self.join(operator, terms)
    }

    /// A chain as it is nested, of which the operands' normal forms are given in order.
    fn nested(
        &mut self,
        expr: &Expr,
        operator: BinaryOp,
        operands: &mut impl Iterator<Item = Term>,
    ) -> Term {
        match &expr.kind {
            ExprKind::Binary(own, a, b) if *own == operator => {
                let a = self.nested(a, operator, operands);
                let b = self.nested(b, operator, operands);
                self.binary(operator, a, b)
            }
            _ => operands.next().expect("an operand for each place"),
        }
    }

    fn join(&mut self, operator: BinaryOp, sorted: Vec<Term>) -> Term {
        let term = self.node(Operator::Binary(operator), sorted.clone());
        self.joined[term as usize] = Some((operator, sorted));
        term
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
                self.join(operator, parts)
            }
            BinaryOp::Equal | BinaryOp::NotEqual | BinaryOp::Iff => {
                self.node(node(operator), vec![a.min(b), a.max(b)])
            }
            BinaryOp::Greater => self.node(node(BinaryOp::Less), vec![b, a]),
            BinaryOp::GreaterEqual => self.node(node(BinaryOp::LessEqual), vec![b, a]),
            _ => self.node(node(operator), vec![a, b]),
        }
    }

    /// The normal form of a command's image.
    pub fn command(&mut self, command: &'m Command, permutation: &Permutation) -> Term {
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

    /// The normal form of the image of a reward structure's item.
    pub fn item(&mut self, item: &'m RewardItem, permutation: &Permutation) -> Term {
        let parts = [&item.guard, &item.value].map(|e| self.of(e, permutation));
        let transition = item.transition.map_or(-2, |a| action(a, permutation));
        self.intern(Operator::Item, transition, parts.to_vec())
    }

    fn leaf(&mut self, operator: Operator, value: i64) -> Term {
        self.intern(operator, value, Vec::new())
    }

    fn node(&mut self, operator: Operator, operands: Vec<Term>) -> Term {
        self.intern(operator, 0, operands)
    }

    fn intern(&mut self, operator: Operator, value: i64, operands: Vec<Term>) -> Term {
        self.formed += 1;
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

/// The operator of an expression that may be one of a chain.
fn chained(expr: &Expr) -> Option<BinaryOp> {
    match expr.kind {
        ExprKind::Binary(
            operator @ (BinaryOp::And | BinaryOp::Or | BinaryOp::Plus | BinaryOp::Times),
            ..,
        ) => Some(operator),
        _ => None,
    }
}

/// The operands of a chain, in their order.
fn chain(expr: &Expr, operator: BinaryOp) -> Vec<&Expr> {
    let (mut operands, mut open) = (Vec::new(), vec![expr]);
    while let Some(expr) = open.pop() {
        match &expr.kind {
            ExprKind::Binary(own, a, b) if *own == operator => open.extend([&**b, &**a]),
            _ => operands.push(expr),
        }
    }
    operands
}

/// The number of an action's image; -1 for none.
fn action(action: Option<usize>, permutation: &Permutation) -> i64 {
    action.map_or(-1, |a| permutation.action[a] as i64)
}
