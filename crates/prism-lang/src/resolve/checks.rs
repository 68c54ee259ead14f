//! What can be seen of a model's meaning before it is explored.

use std::cmp::Ordering;

use num_traits::{One, Signed};

use super::Resolver;
use super::expression::evaluate;
use crate::arithmetic::Arithmetic;
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, ExprKind, VarIndex};
use crate::number::{Number, Rational, Value};
use crate::resolved::{Command, Module, RoundedSum, Update};

/// How far from 1 the constant probabilities of a command may sum up.
const SUM_TOLERANCE: f64 = 1e-12;

/// The same, by default, in PRISM.
const PRISMS_TOLERANCE: f64 = 1e-5;

/// Divides constant probabilities by their sum, if all are known exactly.
fn divide(updates: &mut [Update], sum: &Number) -> bool {
    let exact = |update: &Update| constant_number(&update.probability)?.exact().cloned();
    let probabilities: Option<Vec<Rational>> = updates.iter().map(exact).collect();
    let (Some(probabilities), Some(sum)) = (probabilities, sum.exact()) else {
        return false;
    };
    for (update, probability) in updates.iter_mut().zip(probabilities) {
        let divided = Number::from_rational(probability / sum);
        update.probability = Expr::double(divided, update.probability.span);
    }
    true
}

impl Resolver<'_> {
    /// Checks probabilities that do not depend on the state.
    pub(super) fn check_probabilities(&mut self, updates: &mut [Update], command: Span) {
        let mut sum = Some(Number::from_i64(0));
        for update in updates.iter() {
            let Some(p) = constant_number(&update.probability) else {
                sum = None;
                continue;
            };
            if !is_probability(&p) {
                let message = format!("the probability {p} is not between 0 and 1.");
                let error =
                    Diagnostic::error("not-a-probability", update.probability.span, message);
                self.scope
                    .report(error.remedy("Check the constants from which it is computed."));
                return;
            }
            sum = sum.map(|s| s.add(&p));
        }
        let Some(sum) = sum else { return };
        let excess = sum.sub(&Number::from_i64(1)).to_f64().abs();
        // Not `>`: a sum that is no number must not pass.
        let is_within = |tolerance: f64| {
            let order = excess.partial_cmp(&tolerance);
            matches!(order, Some(Ordering::Less | Ordering::Equal))
        };
        if is_within(SUM_TOLERANCE) {
            return;
        }
        // As in PRISM, a sum that misses 1 by the tolerance itself, up to a rounding, is taken.
        let is_rounded = (self.sum_tolerance).is_some_and(|most| is_within(most.next_up()));
        if is_rounded && divide(updates, &sum) {
            let (span, excess) = (command, excess.next_up());
            self.rounded.push(RoundedSum { span, excess });
            return;
        }
        let message = format!("the probabilities of this command sum to {sum}, not to 1.");
        let remedy = match excess < PRISMS_TOLERANCE * (1.0 + 1e-9) {
            true => {
                "Write the last one as `1 - (...)`, or take them as rounded numbers with the option `-sumroundoff 1e-5`, as PRISM does without being asked."
            }
            false => "Write the last one as `1 - (...)`.",
        };
        self.scope
            .report(Diagnostic::error("probability-sum", command, message).remedy(remedy));
    }

    /// Warns of a command that can never run.
    pub(super) fn check_guard(&mut self, guard: &Expr, command: Span) {
        if guard.kind == ExprKind::Bool(false) {
            let message = "this command is never enabled: its guard is always false.";
            let warning = Diagnostic::warning("never-enabled", command, message);
            self.scope.report(
                warning
                    .related(guard.span, "always false")
                    .remedy("Correct the guard, or remove the command."),
            );
        }
    }

    /// Warns of a constant that does not fit its variable.
    pub(super) fn check_assigned_range(&mut self, value: &Expr, target: VarIndex) {
        let variable = &self.variables[target];
        let (low, high) = variable.kind.bounds();
        if let ExprKind::Int(constant) = value.kind
            && (constant < low || constant > high)
        {
            let name = &variable.name;
            let message = format!("{constant} is not in the range {low}..{high} of `{name}`.");
            let warning = Diagnostic::warning("assigned-out-of-range", value.span, message)
                .related(variable.span, "the range is given here")
                .remedy("Widen the range, or guard the command: exploring will stop here with an error.");
            self.scope.report(warning);
        }
    }

    /// Warns of actions that some module blocks for ever.
    pub(super) fn check_synchronisation(&mut self, modules: &[Module]) {
        let mut by_action: Vec<Vec<(&Module, Vec<&Command>)>> = Vec::new();
        by_action.resize_with(self.actions.len(), Vec::new);
        for module in modules {
            for command in &module.commands {
                let Some(users) = command.action.map(|action| &mut by_action[action]) else {
                    continue;
                };
                match users.last_mut() {
                    Some((last, own)) if std::ptr::eq(*last, module) => own.push(command),
                    _ => users.push((module, vec![command])),
                }
            }
        }
        for (action, users) in by_action.iter().enumerate() {
            let blocks = |c: &&Command| c.guard.kind == ExprKind::Bool(false);
            let Some((blocker, commands)) = users.iter().find(|(_, cs)| cs.iter().all(blocks))
            else {
                continue;
            };
            if users.len() < 2 {
                continue;
            }
            let name = &self.actions[action];
            let message = format!(
                "action `{name}` can never happen: module `{}` never takes part in it.",
                blocker.name
            );
            let mut warning = Diagnostic::warning("blocked-action", commands[0].span, message);
            for (module, others) in users.iter().filter(|(m, _)| m.name != blocker.name) {
                warning = warning.related(
                    others[0].span,
                    format!("module `{}` waits for it here", module.name),
                );
            }
            self.scope.report(warning.remedy("Modules synchronise on every action that they share: correct the guard, or rename the action."));
        }
    }
}

fn constant_number(expr: &Expr) -> Option<Number> {
    if !expr.is_constant() {
        return None;
    }
    match evaluate(expr).ok()? {
        Value::Int(value) => Some(Number::from_i64(value)),
        Value::Double(value) => Some(value),
        Value::Bool(_) => None,
    }
}

/// Whether a number is below 0.
pub(super) fn is_negative(number: &Number) -> bool {
    match number.exact() {
        Some(exact) => exact.is_negative(),
        None => number.to_f64() < 0.0,
    }
}

/// Whether a number lies between 0 and 1.
pub(super) fn is_probability(number: &Number) -> bool {
    match number.exact() {
        Some(exact) => !exact.is_negative() && *exact <= <Rational as One>::one(),
        None => (0.0..=1.0).contains(&number.to_f64()),
    }
}
