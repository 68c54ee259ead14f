//! A new outcome of a command, and a new value for the variable that it sets.

use super::{Edit, EditError, add_constants, constant, declares, indentation, set_constant};
use crate::ast::{
    Assignment, Command, Expr, ExprKind, Model, ModuleBody, Update, Variable, VariableRange,
};
use crate::diagnostic::Span;

/// The edits that give a variable one more value.
#[derive(Clone, Debug, PartialEq)]
pub struct Extension {
    /// What is changed.
    pub edits: Vec<Edit>,
    /// The new value.
    pub value: i64,
}

/// Gives a variable one more value at the upper end of its range, which is `high` now, and names it.
///
/// # Errors
/// If no written module owns the variable, its range has no upper end, or the name is taken.
pub fn extend_range(
    text: &str,
    tree: &Model,
    variable: &str,
    high: i64,
    name: &str,
) -> Result<Extension, EditError> {
    if declares(tree, name) {
        return Err(EditError::NameTaken(name.to_owned()));
    }
    let declared =
        declaration(tree, variable).ok_or_else(|| EditError::NoVariable(variable.to_owned()))?;
    let VariableRange::Int { high: end, .. } = &declared.range else {
        return Err(EditError::NoUpperEnd(variable.to_owned()));
    };
    let value = high
        .checked_add(1)
        .ok_or_else(|| EditError::NoUpperEnd(variable.to_owned()))?;
    let line = format!("const int {name} = {value};");
    let bound = own_bound(text, tree, end);
    let mut edits = vec![add_constants(text, tree, &[line], bound)];
    match bound {
        Some(bound) => edits.extend(set_constant(tree, bound, &value.to_string())?),
        None => edits.push(Edit::replace(end.span, name)),
    }
    Ok(Extension { edits, value })
}

fn declaration<'a>(tree: &'a Model, name: &str) -> Option<&'a Variable> {
    let inner = tree.modules.iter().filter_map(|module| match &module.body {
        ModuleBody::Written { variables, .. } => Some(variables),
        ModuleBody::Renamed { .. } => None,
    });
    let mut all = tree.globals.iter().chain(inner.flatten());
    all.find(|variable| variable.name.text == name)
}

/// The constant that is the upper end and nothing else.
fn own_bound<'a>(text: &str, tree: &'a Model, end: &'a Expr) -> Option<&'a str> {
    let ExprKind::Name(name) = &end.kind else {
        return None;
    };
    let is_literal = matches!(constant(tree, name)?.value.as_ref()?.kind, ExprKind::Int(_));
    (is_literal && uses(text, name) == 2).then_some(name)
}

/// How often a name stands in a text as a whole word. Comments count, which errs on the safe side.
fn uses(text: &str, name: &str) -> usize {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices(name)
        .filter(|(at, _)| !text[..*at].ends_with(is_word))
        .filter(|(at, _)| !text[at + name.len()..].starts_with(is_word))
        .count()
}

/// Gives a command a further outcome with probability `chance` (a name or a literal): what its first update does,
/// but with `value` for `variable`. All other probabilities are multiplied by `1-chance`.
pub fn add_branch(
    text: &str,
    command: &Command,
    chance: &str,
    variable: &str,
    value: &str,
) -> Vec<Edit> {
    let indent = format!("\n{}  ", indentation(text, command.span.start));
    let mut edits = Vec::new();
    for (place, update) in command.updates.iter().enumerate() {
        let weight = match &update.probability {
            None => format!("1-{chance}"),
            Some(probability) => format!("{}*(1-{chance})", factor(text, probability)),
        };
        let outcome = &text[body(text, update).start..update.span.end];
        let first = if place == 0 { indent.as_str() } else { "" };
        let span = match place {
            0 => Span::new(blanks_before(text, update.span.start), update.span.end),
            _ => update.span,
        };
        edits.push(Edit::replace(span, format!("{first}{weight} : {outcome}")));
    }
    if let (Some(first), Some(last)) = (command.updates.first(), command.updates.last()) {
        let outcome = with_value(text, first, variable, value);
        let branch = format!("{indent}+ {chance} : {outcome}");
        edits.push(Edit::insert(last.span.end, branch));
    }
    edits
}

/// Divides one outcome of a command in two: with probability `chance` (a name or a literal) it has `value` for
/// `variable`, else it is as before. The other outcomes keep their probabilities, so that a command that is repeated
/// until it has this outcome has the new one with probability `chance` in the end.
pub fn divide_update(
    text: &str,
    update: &Update,
    chance: &str,
    variable: &str,
    value: &str,
) -> Edit {
    let (before, branch) = match &update.probability {
        None => (format!("1-{chance}"), chance.to_owned()),
        Some(probability) => {
            let factor = factor(text, probability);
            (
                format!("{factor}*(1-{chance})"),
                format!("{factor}*{chance}"),
            )
        }
    };
    let outcome = &text[body(text, update).start..update.span.end];
    let other = with_value(text, update, variable, value);
    Edit::replace(
        update.span,
        format!("{before} : {outcome} + {branch} : {other}"),
    )
}

/// Divides one outcome of a command in two: with `chance` (a name or a literal), or with what remains of 1, it is as before, and else
/// `to` happens, which is written as an update is.
pub fn split_update(
    text: &str,
    update: &Update,
    (chance, is_of_added): (&str, bool),
    to: &str,
) -> Edit {
    let rest = format!("1-{chance}");
    let (kept, added) = match (&update.probability, is_of_added) {
        (None, false) => (chance.to_owned(), rest),
        (None, true) => (rest, chance.to_owned()),
        (Some(probability), is_of_added) => {
            let factor = factor(text, probability);
            let (kept, added) = match is_of_added {
                false => (chance.to_owned(), format!("({rest})")),
                true => (format!("({rest})"), chance.to_owned()),
            };
            (format!("{factor}*{kept}"), format!("{factor}*{added}"))
        }
    };
    let outcome = outcome(text, update);
    Edit::replace(update.span, format!("{kept} : {outcome} + {added} : {to}"))
}

/// Divides a whole command in two: with `chance` (a name or a literal), or with what remains of 1, it is as before, and else `to` happens,
/// which is written as an update is.
#[must_use]
pub fn split_command(
    text: &str,
    command: &Command,
    (chance, is_of_added): (&str, bool),
    to: &str,
) -> Vec<Edit> {
    if let [update] = &command.updates[..] {
        return vec![split_update(text, update, (chance, is_of_added), to)];
    }
    let rest = format!("1-{chance}");
    let (kept, added) = match is_of_added {
        true => (format!("({rest})"), chance.to_owned()),
        false => (chance.to_owned(), rest),
    };
    let probabilities = command
        .updates
        .iter()
        .filter_map(|it| it.probability.as_ref());
    let mut edits: Vec<Edit> = probabilities
        .map(|it| Edit::replace(it.span, format!("{kept}*{}", factor(text, it))))
        .collect();
    if let Some(last) = command.updates.last() {
        edits.push(Edit::insert(last.span.end, format!(" + {added} : {to}")));
    }
    edits
}

/// What an update does, without its probability, as it is written.
#[must_use]
pub fn outcome(text: &str, update: &Update) -> String {
    let span = body(text, update);
    text[span.start..span.end].to_owned()
}

/// An update that does something else, with its probability as it is.
#[must_use]
pub fn with_outcome(text: &str, update: &Update, to: &str) -> Edit {
    Edit::replace(body(text, update), to)
}

/// A probability as a factor.
fn factor(text: &str, probability: &Expr) -> String {
    let written = &text[probability.span.start..probability.span.end];
    match probability.kind {
        ExprKind::Name(_) | ExprKind::Int(_) | ExprKind::Double(_) | ExprKind::Call(..) => {
            written.to_owned()
        }
        _ => format!("({written})"),
    }
}

/// The assignments of an update, without its probability.
fn body(text: &str, update: &Update) -> Span {
    let behind = update.probability.as_ref().map(|p| p.span.end);
    let colon = behind.and_then(|end| Some(end + text[end..update.span.end].find(':')? + 1));
    let start = colon.unwrap_or(update.span.start);
    let blanks = text[start..update.span.end].len();
    let trimmed = text[start..update.span.end].trim_start().len();
    Span::new(start + blanks - trimmed, update.span.end)
}

/// What an update does, with another value for one variable.
#[must_use]
pub fn with_value(text: &str, update: &Update, variable: &str, value: &str) -> String {
    let own = format!("({variable}'={value})");
    let is_own = |it: &&Assignment| it.variable.text == variable;
    if update.assignments.is_empty() {
        return own;
    }
    let span = body(text, update);
    let outcome = &text[span.start..span.end];
    match update.assignments.iter().find(is_own) {
        None => format!("{outcome} & {own}"),
        Some(assignment) => {
            let at = assignment.value.span;
            let (before, after) = (
                &outcome[..at.start - span.start],
                &outcome[at.end - span.start..],
            );
            format!("{before}{value}{after}")
        }
    }
}

/// Where the blanks before an offset begin.
fn blanks_before(text: &str, offset: usize) -> usize {
    text[..offset].trim_end().len()
}
