//! Which updates of a model make a state formula true.
//!
//! # Definition
//! A formula is taken as a conjunction of `variable=value` (a bare Boolean
//! variable is `=true`, a negated one `=false`; the name of a formula is what the formula says). An update makes it true if it
//! assigns one of these values, and its command's guard asks for none of the
//! others to be different. If some guards ask for all the others, only these
//! updates count: they are the last step, behind which the formula holds. What
//! is no such conjunction has no draws here.
//!
//! Deviation from the semantics: guards are read as far as they are conjunctions
//! themselves, so an update may be found that in fact is never taken. A change
//! that is made there is solved before it is offered, which shows it.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! An update that makes the formula true by an assignment is found if the formula and its guard are such conjunctions; others are not.

use prism_lang::ast::{
    BinaryOp, Command, Expr, ExprKind, Formula, Model, ModuleBody, UnaryOp, Update,
};
use prism_lang::edit::{Body, body_of};
use prism_lang::{Value, resolved};

/// `variable=value`, as it is written.
pub type Equality = (String, Expr);

/// An update that makes a formula true.
pub struct Draw<'a> {
    /// Where it is written, and how its names are renamed.
    pub body: Body<'a>,
    /// The update.
    pub update: &'a Update,
    /// The variable that it sets, as it is written.
    pub variable: &'a str,
    /// Whether its guard asks for all the rest of the formula.
    is_last: bool,
}

/// A state formula as a conjunction of equalities, by the formulas of its model; `None` if it is none.
pub fn equalities(text: &str, formulas: &[Formula]) -> Option<Vec<Equality>> {
    let parsed = prism_lang::parse_properties(text);
    let property = parsed.tree.properties.first()?;
    if !parsed.diagnostics.is_empty() || parsed.tree.properties.len() != 1 {
        return None;
    }
    let mut found = Vec::new();
    let is_conjunction = collect(&property.formula, formulas, &mut found);
    is_conjunction.then_some(found)
}

/// Adds the equalities of a conjunction; whether it has no other parts.
fn collect(expr: &Expr, formulas: &[Formula], into: &mut Vec<Equality>) -> bool {
    let truth = |value| Expr {
        kind: ExprKind::Bool(value),
        span: expr.span,
    };
    match &expr.kind {
        ExprKind::Bool(true) => true,
        ExprKind::Binary(BinaryOp::And, left, right) => {
            let left = collect(left, formulas, into);
            collect(right, formulas, into) && left
        }
        ExprKind::Binary(BinaryOp::Equal, left, right) => match &left.kind {
            ExprKind::Name(name) => {
                into.push((name.clone(), (**right).clone()));
                true
            }
            _ => false,
        },
        ExprKind::Name(name) => match formulas.iter().find(|f| &f.name.text == name) {
            Some(formula) => collect(&formula.body, formulas, into),
            None => {
                into.push((name.clone(), truth(true)));
                true
            }
        },
        ExprKind::Unary(UnaryOp::Not, inner) => match &inner.kind {
            ExprKind::Name(name) if formulas.iter().all(|f| &f.name.text != name) => {
                into.push((name.clone(), truth(false)));
                true
            }
            _ => false,
        },
        _ => false,
    }
}

/// The equalities that a guard asks for, as far as it is a conjunction.
pub fn of_guard(command: &Command, formulas: &[Formula]) -> Vec<Equality> {
    let mut found = Vec::new();
    collect(&command.guard, formulas, &mut found);
    found
}

/// The equalities that a guard names, in any of its cases.
pub fn named_in_guard(command: &Command, formulas: &[Formula]) -> Vec<Equality> {
    fn cases(expr: &Expr, formulas: &[Formula], into: &mut Vec<Equality>) {
        match &expr.kind {
            ExprKind::Binary(BinaryOp::And | BinaryOp::Or, left, right) => {
                cases(left, formulas, into);
                cases(right, formulas, into);
            }
            _ => {
                collect(expr, formulas, into);
            }
        }
    }
    let mut found = Vec::new();
    cases(&command.guard, formulas, &mut found);
    found
}

/// The value of a literal or of a constant.
pub fn value_of(expr: &Expr, body: Option<&Body>, model: &resolved::Model) -> Option<i64> {
    match &expr.kind {
        ExprKind::Int(value) => Some(*value),
        ExprKind::Bool(value) => Some(i64::from(*value)),
        ExprKind::Unary(UnaryOp::Minus, inner) => {
            value_of(inner, body, model).and_then(i64::checked_neg)
        }
        ExprKind::Name(name) => {
            let name = body.map_or(name.as_str(), |body| body.renamed(name));
            match model.constant(name)? {
                Value::Int(value) => Some(*value),
                Value::Bool(value) => Some(i64::from(*value)),
                Value::Double(_) => None,
            }
        }
        _ => None,
    }
}

/// The names in an arithmetic expression, in the order of the text.
pub fn names_of<'e>(expr: &'e Expr, into: &mut Vec<&'e str>) {
    match &expr.kind {
        ExprKind::Name(name) => into.push(name),
        ExprKind::Unary(_, inner) => names_of(inner, into),
        ExprKind::Binary(_, left, right) => {
            names_of(left, into);
            names_of(right, into);
        }
        ExprKind::IfThenElse(condition, then, otherwise) => {
            for part in [condition, then, otherwise] {
                names_of(part, into);
            }
        }
        ExprKind::Call(_, arguments) => {
            for argument in arguments {
                names_of(argument, into);
            }
        }
        _ => {}
    }
}

/// All updates that make the formula true.
pub fn draws<'a>(tree: &'a Model, model: &resolved::Model, wanted: &[Equality]) -> Vec<Draw<'a>> {
    let wanted: Vec<(&str, i64)> = wanted
        .iter()
        .filter_map(|(name, expr)| Some((name.as_str(), value_of(expr, None, model)?)))
        .collect();
    let mut found = Vec::new();
    for module in &tree.modules {
        let Some(body) = body_of(tree, module) else {
            continue;
        };
        let ModuleBody::Written { commands, .. } = &body.written.body else {
            continue;
        };
        for command in commands {
            found.extend(of_command(command, &body, (tree, model), &wanted));
        }
    }
    if found.iter().any(|draw| draw.is_last) {
        found.retain(|draw| draw.is_last);
    }
    found
}

fn of_command<'a>(
    command: &'a Command,
    body: &Body<'a>,
    (tree, model): (&Model, &resolved::Model),
    wanted: &[(&str, i64)],
) -> Vec<Draw<'a>> {
    let guard = of_guard(command, &tree.formulas);
    let asks = |variable: &str| {
        let mut own = guard.iter().filter(|(n, _)| body.renamed(n) == variable);
        own.find_map(|(_, expr)| value_of(expr, Some(body), model))
    };
    let others = |name: &str, holds: &dyn Fn(Option<i64>, i64) -> bool| {
        let mut rest = wanted.iter().filter(|(other, _)| *other != name);
        rest.all(|(other, value)| holds(asks(other), *value))
    };
    let mut found = Vec::new();
    for update in &command.updates {
        for assignment in &update.assignments {
            let name = body.renamed(&assignment.variable.text);
            let value = value_of(&assignment.value, Some(body), model);
            let sets = |(v, wanted): &(&str, i64)| {
                *v == name && value == Some(*wanted) && asks(name) != Some(*wanted)
            };
            let may_hold = others(name, &|asked, value| asked.is_none_or(|it| it == value));
            if wanted.iter().any(sets) && may_hold {
                found.push(Draw {
                    body: body.clone(),
                    update,
                    variable: &assignment.variable.text,
                    is_last: others(name, &|asked, value| asked == Some(value)),
                });
            }
        }
    }
    found
}
