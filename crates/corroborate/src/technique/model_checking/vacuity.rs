//! Properties that say nothing of a model, because no run of any model could make them false, or true.
//!
//! # Definition
//! A state formula is constant if it has one value for all values of its variables, each within its declared range and one
//! step beyond either end: what the range alone excludes (`x <= 9` of `x : [0..9]`) says something of the model, since an
//! update out of range is an error. A formula without variables is none of these: it is what the model's author says, for
//! example that a failure cannot happen. A path formula is constant if constant state formulas make it so, operator by
//! operator.
//!
//! # Deviation
//! None is found where the variables have more than [`MAX_VALUATIONS`] valuations, and where operators have to be seen
//! together (`F a | G !a`).
//!
//! # Guarantee
//! What is said to be constant is: all valuations are tried.

use prism_lang::property::{Path, Quantity, StateFormula};
use prism_lang::resolved::{Model, VariableKind};
use prism_lang::{Expr, Property, VarIndex};
use std::collections::BTreeSet;

/// Valuations that are tried at most.
const MAX_VALUATIONS: u64 = 100_000;

/// The one truth value that the path formula of a property has on all runs of all models with these variables; `None` if
/// it has both, or may have.
pub(super) fn constant_truth(property: &Property, model: &Model) -> Option<bool> {
    match property {
        Property::Probability { path, .. } => of_path(path, model),
        Property::Number(
            Quantity::Probability { path, .. } | Quantity::Conditional { path, .. },
        ) => of_path(path, model),
        Property::Number(_) | Property::State(_) | Property::Range(_) | Property::Objectives(_) => {
            None
        }
    }
}

fn of_path(path: &Path, model: &Model) -> Option<bool> {
    let of = |inner: &Path| of_path(inner, model);
    match path {
        Path::State(formula) => of_state(formula, model),
        Path::Not(inner) => of(inner).map(|it| !it),
        Path::And(left, right) => and(of(left), of(right)),
        Path::Or(left, right) => or(of(left), of(right)),
        Path::Implies(left, right) => or(of(left).map(|it| !it), of(right)),
        Path::Iff(left, right) => Some(of(left)? == of(right)?),
        Path::Next(inner) => of(inner),
        Path::Finally { operand, .. } | Path::Globally { operand, .. } => of(operand),
        Path::Until { left, right, bound } => match (of(left), of(right)) {
            (_, Some(false)) => Some(false),
            (Some(true), Some(true)) => Some(true),
            (_, Some(true)) if bound.first_step() == 0 => Some(true),
            _ => None,
        },
        Path::WeakUntil { left, right, bound } => match (of(left), of(right)) {
            (Some(true), _) => Some(true),
            (_, Some(true)) if bound.is_unbounded() => Some(true),
            (Some(false), Some(false)) if bound.is_unbounded() => Some(false),
            _ => None,
        },
        Path::Release { right, .. } => of(right),
        Path::Timed { left, right, .. } => match left {
            None => of(right),
            Some(_) => None,
        },
    }
}

fn and(left: Option<bool>, right: Option<bool>) -> Option<bool> {
    match (left, right) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        _ => None,
    }
}

fn or(left: Option<bool>, right: Option<bool>) -> Option<bool> {
    and(left.map(|it| !it), right.map(|it| !it)).map(|it| !it)
}

fn of_state(formula: &StateFormula, model: &Model) -> Option<bool> {
    let mut variables = BTreeSet::new();
    collect(formula, model, &mut variables)?;
    if variables.is_empty() {
        return None;
    }
    let mut domains = Vec::new();
    let mut valuations = 1_u64;
    for variable in variables {
        let (low, high) = match model.variables.get(variable)?.kind {
            VariableKind::Bool => (0, 1),
            VariableKind::Int { low, high } => (low.checked_sub(1)?, high.checked_add(1)?),
            VariableKind::Unbounded => return None,
        };
        let values = u64::try_from(high.checked_sub(low)?.checked_add(1)?).ok()?;
        valuations = valuations.checked_mul(values)?;
        domains.push((variable, low, high));
    }
    if valuations > MAX_VALUATIONS {
        return None;
    }
    let mut state: Vec<i64> = model.variables.iter().map(|it| it.init).collect();
    for (variable, low, _) in &domains {
        *state.get_mut(*variable)? = *low;
    }
    let first = value(formula, model, &state)?;
    while next(&mut state, &domains)? {
        if value(formula, model, &state)? != first {
            return None;
        }
    }
    Some(first)
}

/// The next valuation in the order of counting; false after the last.
fn next(state: &mut [i64], domains: &[(VarIndex, i64, i64)]) -> Option<bool> {
    for (variable, low, high) in domains {
        let value = state.get_mut(*variable)?;
        if *value < *high {
            *value += 1;
            return Some(true);
        }
        *value = *low;
    }
    Some(false)
}

/// The variables of a formula; `None` if it depends on more than their values in one state.
fn collect(formula: &StateFormula, model: &Model, into: &mut BTreeSet<VarIndex>) -> Option<()> {
    match formula {
        StateFormula::Expr(expr) => into.extend(expr.variables()),
        StateFormula::Label(name) => into.extend(label(name, model)?.variables()),
        StateFormula::Not(inner) => collect(inner, model, into)?,
        StateFormula::And(left, right)
        | StateFormula::Or(left, right)
        | StateFormula::Implies(left, right)
        | StateFormula::Iff(left, right) => {
            collect(left, model, into)?;
            collect(right, model, into)?;
        }
        StateFormula::Choice(condition, then, otherwise) => {
            for part in [condition, then, otherwise] {
                collect(part, model, into)?;
            }
        }
        _ => return None,
    }
    Some(())
}

fn value(formula: &StateFormula, model: &Model, state: &[i64]) -> Option<bool> {
    let of = |inner: &StateFormula| value(inner, model, state);
    Some(match formula {
        StateFormula::Expr(expr) => expr.eval_bool(state).ok()?,
        StateFormula::Label(name) => label(name, model)?.eval_bool(state).ok()?,
        StateFormula::Not(inner) => !of(inner)?,
        StateFormula::And(left, right) => of(left)? && of(right)?,
        StateFormula::Or(left, right) => of(left)? || of(right)?,
        StateFormula::Implies(left, right) => !of(left)? || of(right)?,
        StateFormula::Iff(left, right) => of(left)? == of(right)?,
        StateFormula::Choice(condition, then, otherwise) => match of(condition)? {
            true => of(then)?,
            false => of(otherwise)?,
        },
        _ => return None,
    })
}

/// A label of the model; none for `init` and `deadlock`, which are no matter of one state's values.
fn label<'m>(name: &str, model: &'m Model) -> Option<&'m Expr> {
    model.label(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Constants;

    fn truth(property: &str) -> Option<bool> {
        let model = "dtmc\nmodule m\n  s : [0..9] init 0;\n  b : bool init false;\n  [] s<9 -> (s'=s+1);\n  [] s=9 -> true;\n\
                     endmodule\nlabel \"never\" = s=0 & s=2;\nlabel \"end\" = s=9;\n";
        let parsed = prism_lang::parse_model(model);
        let model = prism_lang::resolve(&parsed.tree, &Constants::new()).expect("a model");
        let tree = prism_lang::parse_properties(property)
            .into_result()
            .expect(property);
        let mut properties = prism_lang::resolve_properties(&tree, &model, &Constants::new())
            .unwrap_or_else(|found| panic!("{property}: {found:?}"));
        constant_truth(&properties.pop().expect("a property").property, &model)
    }

    #[test]
    fn what_no_model_can_violate_or_satisfy_is_found() {
        for (property, expected) in [
            ("P=? [ G !(s=0 & s=2) ]", Some(true)),
            ("P=? [ F \"never\" ]", Some(false)),
            ("P=? [ F<=7 (b | !b) ]", Some(true)),
            ("P=? [ G (\"never\" => (F s=5)) ]", Some(true)),
            ("P=? [ b U \"never\" ]", Some(false)),
            ("P=? [ b U (b | !b) ]", Some(true)),
            ("P=? [ G !\"never\" || F s=3 ]", Some(true)),
            ("P=? [ G (s=1 => s<2) ]", Some(true)),
        ] {
            assert_eq!(truth(property), expected, "{property}");
        }
    }

    #[test]
    fn what_some_model_violates_is_not_accused() {
        for property in [
            // The range is kept by no more than the updates.
            "P=? [ G s<=9 ]",
            "P=? [ G s>=0 ]",
            "P=? [ F \"end\" ]",
            "P=? [ G !(s=0 & b) ]",
            "P=? [ F \"deadlock\" ]",
            "P=? [ b U>=2 (b | !b) ]",
            "P=? [ G (s=1 => (F s=2)) ]",
        ] {
            assert_eq!(truth(property), None, "{property}");
        }
    }
}
