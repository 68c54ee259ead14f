//! The slips that a model's text leaves room for.

use super::{MOST_VALUES, NEAR_BY, Slip};
use crate::draws;
use crate::model_change::Read;
use crate::number::commands;
use prism_lang::Span;
use prism_lang::ast::{
    Assignment, BinaryOp, Expr, ExprKind, ModuleBody, Type, UnaryOp, VariableRange,
};
use prism_lang::edit;
use prism_lang::resolved::ModelType;
use std::collections::BTreeSet;

/// How far a whole number is moved.
const STEPS: [i64; 4] = [1, -1, 2, -2];

/// How far a whole number is moved that is not merely miscounted.
const FARTHEST: i64 = 8;

/// Other whole numbers, the nearest first: at least `from` away, and none below 0.
fn far(value: i64, from: i64) -> impl Iterator<Item = i64> {
    let steps = (from..=FARTHEST).flat_map(|step| [step, -step]);
    steps.map(move |step| value + step).filter(|it| *it >= 0)
}

/// All of them with their kinds, those of few places first. Numbers that are far from the one that is written are of the kind of those
/// that are near: they are no likelier for being counted apart.
pub(super) fn slips(read: &Read<'_>) -> Vec<(u8, Slip)> {
    let kinds = [
        (0, digits_of_numbers(read)),
        (1, whole_numbers(read)),
        (2, beginnings(read)),
        (3, moved_bounds(read)),
        (4, parts(read)),
        (5, exchanges(read)),
        (1, far_whole_numbers(read)),
        (2, far_beginnings(read)),
        (4, far_parts(read)),
        (6, redirected(read)),
    ];
    let with_kind = |(kind, all): (u8, Vec<Slip>)| all.into_iter().map(move |it| (kind, it));
    kinds.into_iter().flat_map(with_kind).collect()
}

/// A part of a guard or formula, and what else may have been meant.
pub(super) struct Part {
    /// Where it stands.
    pub(super) whole: Span,
    /// What may stand in its place.
    pub(super) others: Vec<String>,
    /// The same with a number that is far from the one that is written.
    pub(super) far: Vec<String>,
}

/// A number that a guard or formula compares a variable with.
pub(super) struct Bound {
    pub(super) variable: String,
    pub(super) value: i64,
    pub(super) span: Span,
}

fn is_comparison(operator: BinaryOp) -> bool {
    matches!(operator, BinaryOp::Equal | BinaryOp::NotEqual) || is_order(operator)
}

fn is_order(operator: BinaryOp) -> bool {
    matches!(
        operator,
        BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual
    )
}

/// All guards, and the bodies of formulas, in the order of the text.
fn conditions<'r>(read: &'r Read<'_>) -> Vec<&'r Expr> {
    let guards = commands(&read.tree).into_iter().map(|it| &it.guard);
    let formulas = read.tree.formulas.iter().map(|it| &it.body);
    let mut all: Vec<&Expr> = guards.chain(formulas).collect();
    all.sort_by_key(|it| it.span.start);
    all
}

/// Every operation between two operands in an expression.
fn each_operation<'e>(expr: &'e Expr, then: &mut dyn FnMut(&'e Expr)) {
    match &expr.kind {
        ExprKind::Binary(_, left, right) => {
            then(expr);
            each_operation(left, then);
            each_operation(right, then);
        }
        ExprKind::Unary(_, inner) => {
            then(expr);
            each_operation(inner, then);
        }
        ExprKind::Name(_) => then(expr),
        ExprKind::IfThenElse(condition, one, other) => {
            for part in [condition, one, other] {
                each_operation(part, then);
            }
        }
        ExprKind::Call(_, all) => {
            for part in all {
                each_operation(part, then);
            }
        }
        _ => {}
    }
}

/// All numbers that guards and formulas compare variables with.
pub(super) fn bounds(read: &Read<'_>) -> Vec<Bound> {
    let mut found = Vec::new();
    for condition in conditions(read) {
        each_operation(condition, &mut |expr| {
            let ExprKind::Binary(operator, left, right) = &expr.kind else {
                return;
            };
            let sides = [(left, right), (right, left)];
            let known = sides
                .into_iter()
                .find_map(|(own, other)| match (&own.kind, &other.kind) {
                    (ExprKind::Name(name), ExprKind::Int(value)) => Some(Bound {
                        variable: name.clone(),
                        value: *value,
                        span: other.span,
                    }),
                    _ => None,
                });
            found.extend(known.filter(|_| is_comparison(*operator)));
        });
    }
    found
}

/// The numbers that stand in several comparisons of a variable, one of which is of order: what is compared for equality alone is a name
/// of a state.
fn moved_bounds(read: &Read<'_>) -> Vec<Slip> {
    let all = bounds(read);
    let distinct: BTreeSet<(String, i64)> = all
        .iter()
        .map(|it| (it.variable.clone(), it.value))
        .collect();
    let ordered = ordered_names(read);
    let several = distinct.into_iter().filter(|(variable, value)| {
        let places = all
            .iter()
            .filter(|it| it.variable == *variable && it.value == *value);
        places.count() > 1 && ordered.contains(variable)
    });
    several
        .flat_map(|(variable, old)| {
            [1, -1].map(|step| Slip::Bound {
                variable: variable.clone(),
                old,
                new: old + step,
            })
        })
        .collect()
}

/// What is compared by order, or counted with.
fn ordered_names(read: &Read<'_>) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut add = |expr: &Expr| {
        if let ExprKind::Binary(operator, left, right) = &expr.kind
            && (is_order(*operator) || matches!(operator, BinaryOp::Plus | BinaryOp::Minus))
        {
            for side in [left, right] {
                if let ExprKind::Name(name) = &side.kind {
                    names.insert(name.clone());
                }
            }
        }
    };
    for condition in conditions(read) {
        each_operation(condition, &mut add);
    }
    let all = commands(&read.tree);
    let updates = all.iter().flat_map(|it| &it.updates);
    for assignment in updates.flat_map(|it| &it.assignments) {
        each_operation(&assignment.value, &mut add);
    }
    names
}

fn whole_numbers(read: &Read<'_>) -> Vec<Slip> {
    moved_constants(read, |old| {
        let moved = STEPS.iter().map(|step| old + step);
        moved.filter(|it| *it >= 0).collect()
    })
}

fn far_whole_numbers(read: &Read<'_>) -> Vec<Slip> {
    moved_constants(read, |old| far(old, 3).collect())
}

/// The values of other constants that the variables are given or compared with, which this one is given to or compared with.
fn beside(read: &Read<'_>, name: &str) -> BTreeSet<i64> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for condition in conditions(read) {
        each_operation(condition, &mut |expr| {
            if let ExprKind::Binary(operator, left, right) = &expr.kind
                && is_comparison(*operator)
                && let (ExprKind::Name(left), ExprKind::Name(right)) = (&left.kind, &right.kind)
            {
                pairs.push((left.clone(), right.clone()));
                pairs.push((right.clone(), left.clone()));
            }
        });
    }
    let all = commands(&read.tree);
    let updates = all.iter().flat_map(|it| &it.updates);
    for assignment in updates.flat_map(|it| &it.assignments) {
        if let ExprKind::Name(given) = &assignment.value.kind {
            pairs.push((assignment.variable.text.clone(), given.clone()));
        }
    }
    let own = pairs.iter().filter(|(_, given)| given == name);
    let variables: BTreeSet<&str> = own.map(|(variable, _)| variable.as_str()).collect();
    let others = pairs
        .iter()
        .filter(|(variable, given)| given != name && variables.contains(variable.as_str()));
    others
        .filter_map(|(_, given)| read.constant(given))
        .map(|value| value as i64)
        .collect()
}

/// Constants of type `int` that are compared by order or counted with, with other values.
fn moved_constants(read: &Read<'_>, others: impl Fn(i64) -> Vec<i64>) -> Vec<Slip> {
    let ordered = ordered_names(read);
    let is_end = |name: &str| {
        let mut ranges = crate::idle::declared(read).filter_map(|it| match &it.range {
            VariableRange::Int { low, high } => Some([low, high]),
            _ => None,
        });
        ranges.any(|ends| {
            ends.iter()
                .any(|it| matches!(&it.kind, ExprKind::Name(own) if own == name))
        })
    };
    let mut found = Vec::new();
    for constant in &read.tree.constants {
        let name = &constant.name.text;
        let written = constant.value.as_ref().filter(|_| constant.ty == Type::Int);
        let Some(old) = written.and_then(|it| draws::value_of(it, None, &read.model)) else {
            continue;
        };
        if ordered.contains(name) || is_end(name) {
            // Two names of values that a variable may have stay two.
            let taken = beside(read, name);
            let others = |old| -> Vec<i64> {
                let all = others(old).into_iter();
                all.filter(|new| !taken.contains(new)).collect()
            };
            found.extend(others(old).into_iter().map(|new| Slip::Whole {
                constant: name.clone(),
                old,
                new,
            }));
        }
    }
    found
}

/// Constants of type `double` whose digits are others: one minus the value where it is no rate, ten times and a tenth of it.
fn digits_of_numbers(read: &Read<'_>) -> Vec<Slip> {
    let is_of_rates = read.model.model_type == ModelType::Ctmc;
    let mut found = Vec::new();
    for constant in &read.tree.constants {
        let written = constant
            .value
            .as_ref()
            .filter(|_| constant.ty == Type::Double);
        let Some((written, value)) = written.zip(read.constant(&constant.name.text)) else {
            continue;
        };
        let chance = (0.0..1.0).contains(&value) && !is_of_rates;
        let chance = chance.then_some(1.0 - value);
        let others = chance.into_iter().chain([value * 10.0, value / 10.0]);
        let others = others.filter(|it| *it > 0.0 && (*it - value).abs() > f64::EPSILON);
        found.extend(others.map(|new| Slip::Digits {
            constant: constant.name.text.clone(),
            old: read.text[written.span.start..written.span.end].to_owned(),
            // Without the noise of the arithmetic.
            new: format!("{}", (new * 1e12).round() / 1e12),
        }));
    }
    found
}

/// Other first values of variables that have few.
fn beginnings(read: &Read<'_>) -> Vec<Slip> {
    let mut found = Vec::new();
    for variable in crate::idle::declared(read) {
        let init = variable.init.as_ref().map(|it| &it.kind);
        if let (VariableRange::Bool, Some(ExprKind::Bool(init))) = (&variable.range, init) {
            found.push(Slip::Begin {
                variable: variable.name.text.clone(),
                new: (!init).to_string(),
            });
        }
        let VariableRange::Int { low, high } = &variable.range else {
            continue;
        };
        let of = |expr: &Expr| draws::value_of(expr, None, &read.model);
        let (Some(low), Some(high), Some(init)) =
            (of(low), of(high), variable.init.as_ref().and_then(of))
        else {
            continue;
        };
        let name = &variable.name.text;
        if high - low < MOST_VALUES {
            let others = (low..=high).filter(|it| *it != init);
            found.extend(others.map(|new| Slip::Begin {
                variable: name.clone(),
                new: new.to_string(),
            }));
        }
    }
    found
}

/// Other first values of counters that have many.
fn far_beginnings(read: &Read<'_>) -> Vec<Slip> {
    let ordered = ordered_names(read);
    let mut found = Vec::new();
    for variable in crate::idle::declared(read) {
        let VariableRange::Int { low, high } = &variable.range else {
            continue;
        };
        let of = |expr: &Expr| draws::value_of(expr, None, &read.model);
        let (Some(low), Some(high), Some(init)) =
            (of(low), of(high), variable.init.as_ref().and_then(of))
        else {
            continue;
        };
        let name = &variable.name.text;
        if high - low >= MOST_VALUES && ordered.contains(name) {
            let others = far(init, 1).filter(|it| (low..=high).contains(it));
            found.extend(others.map(|new| Slip::Begin {
                variable: name.clone(),
                new: new.to_string(),
            }));
        }
    }
    found
}

/// The parts of guards and formulas, in the order of the text.
pub(super) fn places(read: &Read<'_>) -> Vec<Part> {
    let written = |span: Span| &read.text[span.start..span.end];
    let mut found: Vec<Part> = Vec::new();
    for condition in conditions(read) {
        each_operation(condition, &mut |expr| {
            let (others, far) = match &expr.kind {
                ExprKind::Binary(operator, left, right) => (
                    others_of_operation(read, expr, *operator, [left, right]),
                    far_of_operation(read, expr, *operator, [left, right]),
                ),
                ExprKind::Unary(UnaryOp::Not, inner) => match &inner.kind {
                    ExprKind::Name(_) => (vec![written(inner.span).to_owned()], Vec::new()),
                    _ => (Vec::new(), Vec::new()),
                },
                ExprKind::Name(name) if is_boolean(read, name) => {
                    (vec![format!("!{name}")], Vec::new())
                }
                _ => (Vec::new(), Vec::new()),
            };
            if !others.is_empty() {
                found.push(Part {
                    whole: expr.span,
                    others,
                    far,
                });
            }
        });
    }
    // A denied name is a part as a whole, not the name in it as well.
    let denied: Vec<Span> = found
        .iter()
        .map(|it| it.whole)
        .filter(|it| written(*it).starts_with('!'))
        .collect();
    found.retain(|it| {
        !denied
            .iter()
            .any(|of| of.start < it.whole.start && it.whole.end == of.end)
    });
    found
}

fn is_boolean(read: &Read<'_>, name: &str) -> bool {
    let mut all = crate::idle::declared(read);
    all.any(|it| it.name.text == name && matches!(it.range, VariableRange::Bool))
}

fn others_of_operation(
    read: &Read<'_>,
    expr: &Expr,
    operator: BinaryOp,
    [left, right]: [&Expr; 2],
) -> Vec<String> {
    use BinaryOp::{And, Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual, Or};
    let signs: &[&str] = match operator {
        And => &["|"],
        Or => &["&"],
        Equal => &["!="],
        NotEqual => &["="],
        Less => &["<=", ">=", ">"],
        LessEqual => &["<", ">", ">="],
        Greater => &[">=", "<=", "<"],
        GreaterEqual => &[">", "<", "<="],
        _ => return Vec::new(),
    };
    let now = match operator {
        And => "&",
        Or => "|",
        Equal => "=",
        NotEqual => "!=",
        Less => "<",
        LessEqual => "<=",
        Greater => ">",
        GreaterEqual => ">=",
        _ => return Vec::new(),
    };
    // Between the operands stand parentheses, blanks and the sign.
    let between = &read.text[left.span.end..right.span.start];
    let Some(at) = between.find(now) else {
        return Vec::new();
    };
    let sign = left.span.end + at;
    let with = |place: Span, text: &str| with_part(read, expr, place, text);
    let sign = Span::new(sign, sign + now.len());
    let mut others: Vec<String> = signs.iter().map(|it| with(sign, it)).collect();
    if let (And | Or, Some(other)) = (operator, signs.first()) {
        others.extend(of_chain(read, expr, (operator, now), other));
    }
    if is_comparison(operator) {
        let written = |it: &Expr| read.text[it.span.start..it.span.end].to_owned();
        for (own, side) in [(right, left), (left, right)] {
            if let ExprKind::Int(value) = side.kind {
                others.extend([1, -1].map(|step| with(side.span, &(value + step).to_string())));
            }
            // `tries>=most-3`.
            if let ExprKind::Binary(BinaryOp::Plus | BinaryOp::Minus, _, added) = &side.kind
                && let ExprKind::Int(value) = added.kind
            {
                let moved = STEPS.iter().map(|step| value + step);
                let moved = moved.filter(|it| *it >= 0);
                others.extend(moved.map(|it| with(added.span, &it.to_string())));
            }
            if let (ExprKind::Name(name), true) = (&own.kind, is_order(operator)) {
                let elsewhere = compared_with(read, name).into_iter();
                let elsewhere = elsewhere.filter(|it| *it != written(side));
                others.extend(elsewhere.map(|it| with(side.span, &it)));
            }
        }
        let mut known = BTreeSet::new();
        others.retain(|it| known.insert(it.clone()));
    }
    others
}

/// A chain of more than two operands with another sign between all of them: who mistakes one `&` for `|` writes it throughout.
fn of_chain(
    read: &Read<'_>,
    expr: &Expr,
    (operator, now): (BinaryOp, &str),
    other: &str,
) -> Option<String> {
    let mut signs = Vec::new();
    let mut rest = expr;
    while let ExprKind::Binary(own, left, right) = &rest.kind
        && *own == operator
    {
        let at = read.text[left.span.end..right.span.start].find(now)?;
        signs.push(left.span.end + at);
        rest = left;
    }
    let mut text = read.text[expr.span.start..expr.span.end].to_owned();
    // From the last to the first, so that places stay.
    for at in &signs {
        let start = at - expr.span.start;
        text.replace_range(start..start + now.len(), other);
    }
    (signs.len() > 1).then_some(text)
}

/// An expression with another text at a place of it.
fn with_part(read: &Read<'_>, expr: &Expr, place: Span, text: &str) -> String {
    format!(
        "{}{text}{}",
        &read.text[expr.span.start..place.start],
        &read.text[place.end..expr.span.end]
    )
}

/// A comparison by order with whole numbers that are far from the one that is written.
fn far_of_operation(
    read: &Read<'_>,
    expr: &Expr,
    operator: BinaryOp,
    sides: [&Expr; 2],
) -> Vec<String> {
    if !is_order(operator) {
        return Vec::new();
    }
    let mut others = Vec::new();
    for side in sides {
        let (number, from) = match &side.kind {
            ExprKind::Int(_) => (side, 2),
            ExprKind::Binary(BinaryOp::Plus | BinaryOp::Minus, _, added) => (&**added, 3),
            _ => continue,
        };
        if let ExprKind::Int(value) = number.kind {
            let moved = far(value, from);
            others.extend(moved.map(|it| with_part(read, expr, number.span, &it.to_string())));
        }
    }
    others
}

/// What guards and formulas compare a variable with by order, as it is written.
fn compared_with(read: &Read<'_>, variable: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for condition in conditions(read) {
        each_operation(condition, &mut |expr| {
            if let ExprKind::Binary(operator, left, right) = &expr.kind
                && is_order(*operator)
            {
                for (own, other) in [(left, right), (right, left)] {
                    if matches!(&own.kind, ExprKind::Name(name) if name == variable) {
                        found.insert(read.text[other.span.start..other.span.end].to_owned());
                    }
                }
            }
        });
    }
    found
}

fn parts(read: &Read<'_>) -> Vec<Slip> {
    of_parts(read, |part| part.others)
}

fn far_parts(read: &Read<'_>) -> Vec<Slip> {
    of_parts(read, |part| part.far)
}

fn of_parts(read: &Read<'_>, others: impl Fn(Part) -> Vec<String>) -> Vec<Slip> {
    let all = places(read).into_iter().enumerate();
    all.flat_map(|(place, part)| {
        let old = read.text[part.whole.start..part.whole.end].to_owned();
        others(part).into_iter().map(move |new| Slip::Guard {
            place,
            old: old.clone(),
            new,
        })
    })
    .collect()
}

/// Commands that are near each other in one module and have other guards.
fn exchanges(read: &Read<'_>) -> Vec<Slip> {
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written { commands: own, .. } = &module.body else {
            continue;
        };
        let written = |at: usize| {
            let guard = own[at].guard.span;
            &read.text[guard.start..guard.end]
        };
        for one in 0..own.len() {
            let near = (one + 1..own.len()).take(NEAR_BY);
            let others = near.filter(|other| written(one) != written(*other));
            found.extend(others.map(|other| Slip::Exchange {
                commands: [first + one, first + other],
            }));
        }
        first += own.len();
    }
    found
}

/// Updates that do what others of their module do, give a variable another of its values, or leave an assignment out.
pub(super) fn redirected(read: &Read<'_>) -> Vec<Slip> {
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written { commands: own, .. } = &module.body else {
            continue;
        };
        let updates = || own.iter().flat_map(|it| &it.updates);
        let outcomes: BTreeSet<String> = updates().map(|it| edit::outcome(read.text, it)).collect();
        let written = |it: &Assignment| {
            let value = it.value.span;
            (
                it.variable.text.clone(),
                read.text[value.start..value.end].to_owned(),
            )
        };
        let values: BTreeSet<(String, String)> = updates()
            .flat_map(|it| &it.assignments)
            .map(written)
            .collect();
        for (place, command) in own.iter().enumerate() {
            for (number, update) in command.updates.iter().enumerate() {
                let now = edit::outcome(read.text, update);
                let with = values
                    .iter()
                    .map(|(name, value)| edit::with_value(read.text, update, name, value));
                let without = (0..update.assignments.len()).map(|gone| {
                    let kept = update
                        .assignments
                        .iter()
                        .enumerate()
                        .filter(|(at, _)| *at != gone);
                    let kept: Vec<String> = kept
                        .map(|(_, it)| written(it))
                        .map(|(name, value)| format!("({name}'={value})"))
                        .collect();
                    kept.join(" & ")
                });
                let all = with.chain(outcomes.iter().cloned()).chain(without);
                let all: BTreeSet<String> = all.filter(|to| *to != now && !to.is_empty()).collect();
                found.extend(all.into_iter().map(|to| Slip::Elsewhere {
                    command: first + place,
                    update: number,
                    to,
                }));
            }
        }
        first += own.len();
    }
    found
}
