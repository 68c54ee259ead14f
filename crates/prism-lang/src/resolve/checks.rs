//! What can be seen of a model's meaning before it is explored.

use num_traits::{One, Signed};

use super::Resolver;
use super::expression::evaluate;
use crate::arithmetic::Arithmetic;
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, ExprKind, VarIndex};
use crate::number::{Number, Rational, Value};
use crate::resolved::{Module, Update};

/// How far from 1 the constant probabilities of a command may sum up.
const SUM_TOLERANCE: f64 = 1e-12;

impl Resolver<'_> {
    /// Checks probabilities that do not depend on the state.
    pub(super) fn check_probabilities(&mut self, updates: &[Update], command: Span) {
        let mut sum = Some(Number::from_i64(0));
        for update in updates {
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
        let excess = sum.sub(&Number::from_i64(1)).to_f64();
        // Not `>`: a sum that is no number must not pass.
        if !matches!(
            excess.abs().partial_cmp(&SUM_TOLERANCE),
            Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
        ) {
            let message = format!("the probabilities of this command sum to {sum}, not to 1.");
            let remedy = "Write the last one as `1 - (...)`: PRISM would rescale sums that are nearly 1, which changes the model.";
            self.scope
                .report(Diagnostic::error("probability-sum", command, message).remedy(remedy));
        }
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
        for action in 0..self.actions.len() {
            let of_action = |m: &Module| {
                let commands = m.commands.iter().filter(|c| c.action == Some(action));
                commands.cloned().collect::<Vec<_>>()
            };
            let users: Vec<_> = modules
                .iter()
                .map(|m| (m, of_action(m)))
                .filter(|(_, c)| !c.is_empty())
                .collect();
            let blocks = |c: &crate::resolved::Command| c.guard.kind == ExprKind::Bool(false);
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
