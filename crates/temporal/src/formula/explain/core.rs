//! Formulas with few operators: not, and, or, next, previous, rise, until and since.

use crate::formula::ast::Formula;

/// The largest formula that is explained; `<=>` doubles its operands.
const MAX_SIZE: usize = 5_000;

/// The formula in terms of the few operators, unless that is too large.
pub(super) fn simplest(formula: &Formula) -> Option<Formula> {
    let mut left = MAX_SIZE;
    rewrite(formula, &mut left)
}

fn rewrite(formula: &Formula, left: &mut usize) -> Option<Formula> {
    *left = left.checked_sub(1)?;
    let mut part = |inner: &Formula| rewrite(inner, left).map(Box::new);
    let not = |inner: Box<Formula>| Box::new(Formula::Not(inner));
    let always_true = || Box::new(Formula::True);
    Some(match formula {
        Formula::True | Formula::False | Formula::Atom(_) => formula.clone(),
        Formula::Not(inner) => Formula::Not(part(inner)?),
        Formula::And(operands) => Formula::And(
            operands
                .iter()
                .map(|inner| Some(*part(inner)?))
                .collect::<Option<_>>()?,
        ),
        Formula::Or(operands) => Formula::Or(
            operands
                .iter()
                .map(|inner| Some(*part(inner)?))
                .collect::<Option<_>>()?,
        ),
        Formula::Implies(from, to) => Formula::Or(vec![*not(part(from)?), *part(to)?]),
        Formula::Iff(one, other) => {
            let both = Formula::And(vec![*part(one)?, *part(other)?]);
            let neither = Formula::And(vec![*not(part(one)?), *not(part(other)?)]);
            Formula::Or(vec![both, neither])
        }
        Formula::Next(inner) => Formula::Next(part(inner)?),
        Formula::Previous(inner) => Formula::Previous(part(inner)?),
        Formula::Rise(inner) => Formula::Rise(part(inner)?),
        Formula::Fall(inner) => Formula::Rise(not(part(inner)?)),
        Formula::Eventually(window, inner) => Formula::Until(*window, always_true(), part(inner)?),
        Formula::Always(window, inner) => Formula::Not(Box::new(Formula::Until(
            *window,
            always_true(),
            not(part(inner)?),
        ))),
        Formula::Once(window, inner) => Formula::Since(*window, always_true(), part(inner)?),
        Formula::Historically(window, inner) => Formula::Not(Box::new(Formula::Since(
            *window,
            always_true(),
            not(part(inner)?),
        ))),
        Formula::Until(window, one, other) => Formula::Until(*window, part(one)?, part(other)?),
        Formula::Since(window, one, other) => Formula::Since(*window, part(one)?, part(other)?),
        Formula::Release(window, one, other) => Formula::Not(Box::new(Formula::Until(
            *window,
            not(part(one)?),
            not(part(other)?),
        ))),
        Formula::WeakUntil(window, one, other) => {
            let right = not(part(other)?);
            let neither = Formula::And(vec![*not(part(one)?), *right.clone()]);
            Formula::Not(Box::new(Formula::Until(*window, right, Box::new(neither))))
        }
    })
}
