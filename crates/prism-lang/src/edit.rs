//! Changes of a model's text that leave all else as it is written: comments, layout, other definitions.
//!
//! # Definition
//! An [`Edit`] replaces the text of a span. The functions here find, in a syntax tree, the spans that a change of
//! the model touches:
//!
//! * [`set_constant`]: a constant gets another definition. If it is defined as `1-q` by another constant `q`, the
//!   two change places, so that they still add up to 1 and the constant is the one that is written.
//! * [`add_constants`]: lines with new constants.
//! * [`extend_range`]: a variable's range gets one more value, with a name.
//! * [`add_branch`]: each probability `p` of a command becomes `p*(1-q)`, and a new update has the rest, `q`.
//! * [`divide_update`], [`split_update`]: one outcome of a command becomes two; [`with_outcome`]: it becomes another.
//! * [`draw_once`]: commands that assign a variable are taken at most once in a run.
//!
//! # Guarantee
//! Only syntax is looked at: the new text is to be parsed and resolved again before it is used. What stands outside
//! the edited spans stays byte for byte.

mod branch;
mod once;

use crate::ast::{BinaryOp, Constant, Expr, ExprKind, Model, Module, ModuleBody, Name};
use crate::diagnostic::Span;
use std::collections::BTreeMap;
use std::fmt;

pub use branch::{
    Extension, add_branch, divide_update, extend_range, outcome, split_command, split_update,
    with_outcome, with_value,
};
pub use once::draw_once;

/// The replacement of a span of the text; an empty span inserts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// What is replaced.
    pub span: Span,
    /// By what.
    pub text: String,
}

impl Edit {
    /// Replaces a span.
    pub fn replace(span: Span, text: impl Into<String>) -> Self {
        Self {
            span,
            text: text.into(),
        }
    }

    /// Inserts at an offset.
    pub fn insert(offset: usize, text: impl Into<String>) -> Self {
        Self::replace(Span::new(offset, offset), text)
    }
}

/// Why a text cannot be changed as wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EditError {
    /// The model has no constant of this name.
    NoConstant(String),
    /// The model has no variable of this name that a written module owns.
    NoVariable(String),
    /// Nothing assigns the variable.
    NeverAssigned(String),
    /// The variable's range has no upper end that could be raised.
    NoUpperEnd(String),
    /// The model has this name already.
    NameTaken(String),
    /// Two edits touch the same text.
    Overlapping,
}

impl fmt::Display for EditError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoConstant(name) => write!(f, "the model has no constant `{name}`"),
            Self::NoVariable(name) => write!(f, "no module that is written out owns `{name}`"),
            Self::NeverAssigned(name) => write!(f, "no command assigns `{name}`"),
            Self::NoUpperEnd(name) => write!(f, "the range of `{name}` has no upper end"),
            Self::NameTaken(name) => write!(f, "the model already has a `{name}`"),
            Self::Overlapping => f.write_str("two changes touch the same text"),
        }
    }
}

impl std::error::Error for EditError {}

/// Applies edits, in any order.
///
/// # Errors
/// If two of them overlap, or one lies outside the text. Insertions at one place keep their order.
pub fn apply(text: &str, edits: &[Edit]) -> Result<String, EditError> {
    let mut sorted: Vec<&Edit> = edits.iter().collect();
    sorted.sort_by_key(|edit| (edit.span.start, edit.span.end));
    let mut result = String::with_capacity(text.len());
    let mut done = 0;
    for edit in sorted {
        let between = (edit.span.start >= done)
            .then(|| text.get(done..edit.span.start))
            .flatten()
            .ok_or(EditError::Overlapping)?;
        result.push_str(between);
        result.push_str(&edit.text);
        done = edit.span.end;
    }
    result.push_str(text.get(done..).ok_or(EditError::Overlapping)?);
    Ok(result)
}

/// Gives a constant the definition `value`.
///
/// # Errors
/// If the model has no such constant.
///
/// ```
/// use prism_lang::{edit, parse_model};
/// let text = "dtmc const double p = 0.9; const double q = 1 - p; // beside";
/// let edits = edit::set_constant(&parse_model(text).tree, "q", "7/98").unwrap();
/// let changed = edit::apply(text, &edits).unwrap();
/// assert_eq!(changed, "dtmc const double p = 1 - q; const double q = 7/98; // beside");
/// ```
pub fn set_constant(tree: &Model, name: &str, value: &str) -> Result<Vec<Edit>, EditError> {
    let missing = || EditError::NoConstant(name.to_owned());
    let constant = constant(tree, name).ok_or_else(missing)?;
    let Some(definition) = &constant.value else {
        // Declared without a value: the definition goes before the semicolon.
        let end = constant.name.span.end;
        return Ok(vec![Edit::insert(end, format!(" = {value}"))]);
    };
    let mut edits = vec![Edit::replace(definition.span, value)];
    if let Some(other) = complement_of(definition).and_then(|other| self::constant(tree, other))
        && let Some(expr) = &other.value
    {
        edits.push(Edit::replace(expr.span, format!("1 - {name}")));
    }
    Ok(edits)
}

/// The `q` of `1 - q`.
fn complement_of(expr: &Expr) -> Option<&str> {
    match &expr.kind {
        ExprKind::Binary(BinaryOp::Minus, one, other) => match (&one.kind, &other.kind) {
            (ExprKind::Int(1), ExprKind::Name(name)) => Some(name),
            _ => None,
        },
        _ => None,
    }
}

fn constant<'a>(tree: &'a Model, name: &str) -> Option<&'a Constant> {
    tree.constants.iter().find(|c| c.name.text == name)
}

/// Inserts lines with new constants: before the line of the constant `before`, or behind the last constant.
pub fn add_constants(text: &str, tree: &Model, lines: &[String], before: Option<&str>) -> Edit {
    let mut block: String = lines.iter().map(|line| format!("{line}\n")).collect();
    if let Some(next) = before.and_then(|name| constant(tree, name)) {
        return Edit::insert(line_start(text, next.span.start), block);
    }
    let last = tree.constants.iter().map(|c| c.span.end).max();
    let after = last.or_else(|| tree.model_type.map(|(_, span)| span.end));
    let offset = after.map_or(0, |end| line_end(text, end));
    // Behind the last constant's line, or before whatever comes first.
    if offset > 0 && !text[..offset].ends_with('\n') {
        block.insert(0, '\n');
    }
    Edit::insert(offset, block)
}

/// Whether the model declares this name, in whatever role.
pub fn declares(tree: &Model, name: &str) -> bool {
    let constants = tree.constants.iter().map(|c| &c.name);
    let formulas = tree.formulas.iter().map(|f| &f.name);
    let modules = tree.modules.iter().map(|m| &m.name);
    let globals = tree.globals.iter().map(|v| &v.name);
    let inner = tree.modules.iter().flat_map(inner_names);
    constants
        .chain(formulas)
        .chain(modules)
        .chain(globals)
        .chain(inner)
        .any(|it| it.text == name)
}

/// The names that a module declares, or gives to what it copies.
fn inner_names(module: &Module) -> Vec<&Name> {
    match &module.body {
        ModuleBody::Written { variables, .. } => variables.iter().map(|v| &v.name).collect(),
        ModuleBody::Renamed { renames, .. } => renames.iter().map(|(_, new)| new).collect(),
    }
}

/// The module that is written out for a module, and what its names are in this module.
#[derive(Clone, Debug)]
pub struct Body<'a> {
    /// The module whose text holds the commands.
    pub written: &'a Module,
    /// Old names of that text with the new ones of this module.
    pub renames: BTreeMap<&'a str, &'a str>,
}

impl Body<'_> {
    /// A name of the text as this module has it.
    pub fn renamed<'n>(&'n self, name: &'n str) -> &'n str {
        self.renames.get(name).copied().unwrap_or(name)
    }
}

/// Finds where a module, perhaps a renamed copy of a copy, is written out.
pub fn body_of<'a>(tree: &'a Model, module: &'a Module) -> Option<Body<'a>> {
    let mut at = module;
    let mut renames: BTreeMap<&str, &str> = BTreeMap::new();
    for _ in 0..=tree.modules.len() {
        match &at.body {
            ModuleBody::Written { .. } => {
                return Some(Body {
                    written: at,
                    renames,
                });
            }
            ModuleBody::Renamed { base, renames: own } => {
                let mut all: BTreeMap<&str, &str> = renames.clone();
                for (old, new) in own {
                    let last = renames.get(new.text.as_str()).copied();
                    all.insert(&old.text, last.unwrap_or(&new.text));
                }
                renames = all;
                at = tree.modules.iter().find(|m| m.name.text == base.text)?;
            }
        }
    }
    None
}

fn line_start(text: &str, offset: usize) -> usize {
    text[..offset].rfind('\n').map_or(0, |at| at + 1)
}

/// Behind the line break that ends the line.
fn line_end(text: &str, offset: usize) -> usize {
    text[offset..]
        .find('\n')
        .map_or(text.len(), |at| offset + at + 1)
}

/// The blanks at the beginning of the line.
fn indentation(text: &str, offset: usize) -> &str {
    let line = &text[line_start(text, offset)..offset];
    &line[..line.len() - line.trim_start().len()]
}

/// Whether an expression has to stand in parentheses beside `&`.
fn binds_weaker_than_and(expr: &Expr) -> bool {
    matches!(
        expr.kind,
        ExprKind::Binary(BinaryOp::Implies | BinaryOp::Iff | BinaryOp::Or, ..)
            | ExprKind::IfThenElse(..)
    )
}

#[cfg(test)]
mod tests;
