//! The names that an expression can use, and the values of constants.

use std::collections::BTreeMap;

use crate::ast::{self, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, VarIndex};
use crate::number::{Constants, Number, Value};
use crate::resolved::Parameter;
use crate::suggest::suggest;

/// After so many mistakes names are no longer suggested.
const MOST_HELPED: usize = 200;

/// What a name stands for.
#[derive(Clone, Debug)]
pub(super) enum Symbol<'a> {
    /// A constant that has a value.
    Constant(Value),
    /// A constant that is left open.
    Parameter(usize, Type),
    /// A constant without a value, which is reported where it is used.
    MissingConstant(&'a ast::Constant),
    /// A constant whose definition has yet to be evaluated.
    ConstantDefinition(&'a ast::Constant),
    /// A formula, resolved elsewhere.
    Formula(Expr),
    /// A formula that is resolved where it is used (its names may be renamed there).
    FormulaDefinition(&'a ast::Formula),
    /// A variable.
    Variable(VarIndex, Type),
    /// Something that has been reported as wrong.
    Broken,
}

impl Symbol<'_> {
    pub(super) fn noun(&self) -> &'static str {
        match self {
            Self::Constant(_)
            | Self::Parameter(..)
            | Self::MissingConstant(_)
            | Self::ConstantDefinition(_) => "a constant",
            Self::Formula(_) | Self::FormulaDefinition(_) => "a formula",
            Self::Variable(..) => "a variable",
            Self::Broken => "something else",
        }
    }
}

/// New names for old ones, within a renamed copy of a module.
#[derive(Clone, Debug, Default)]
pub(super) struct Renaming<'a> {
    /// 0 for no renaming; distinct for distinct modules.
    pub(super) id: usize,
    pub(super) names: BTreeMap<&'a str, &'a str>,
}

impl<'a> Renaming<'a> {
    pub(super) fn apply(&self, name: &'a str) -> &'a str {
        self.names.get(name).copied().unwrap_or(name)
    }
}

/// The names of a model or a property file, and what was wrong so far.
pub(super) struct Scope<'a> {
    symbols: BTreeMap<String, (Symbol<'a>, Option<Span>)>,
    /// Resolved formulas by renaming and name; `None` if one is wrong.
    pub(super) formulas: BTreeMap<(usize, String), Option<Expr>>,
    /// Constants and formulas that are being evaluated, outermost first.
    pub(super) active: Vec<(&'a str, Span)>,
    /// Nodes that inlined formulas have made so far.
    pub(super) inlined_nodes: usize,
    pub(super) diagnostics: Vec<Diagnostic>,
}

impl<'a> Scope<'a> {
    pub(super) fn new() -> Self {
        Self {
            symbols: BTreeMap::new(),
            formulas: BTreeMap::new(),
            active: Vec::new(),
            inlined_nodes: 0,
            diagnostics: Vec::new(),
        }
    }

    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    pub(super) fn symbol(&self, name: &str) -> Option<&Symbol<'a>> {
        self.symbols.get(name).map(|(symbol, _)| symbol)
    }

    /// Declares a name; an earlier declaration wins and the later one is reported.
    pub(super) fn declare(&mut self, name: &str, span: Option<Span>, symbol: Symbol<'a>) -> bool {
        if let Some((earlier, first)) = self.symbols.get(name) {
            let message = format!("the name `{name}` already stands for {}.", earlier.noun());
            let mut error = Diagnostic::error("duplicate-name", span.unwrap_or_default(), message)
                .remedy("Choose another name.");
            if let Some(first) = first {
                error = error.related(*first, "first declared here");
            }
            self.report(error);
            return false;
        }
        self.symbols.insert(name.to_owned(), (symbol, span));
        true
    }

    pub(super) fn redefine(&mut self, name: &str, symbol: Symbol<'a>) {
        if let Some((old, _)) = self.symbols.get_mut(name) {
            *old = symbol;
        }
    }

    /// The known name that is nearest to an unknown one. All names are looked at, so that after many mistakes nobody is helped so.
    pub(super) fn suggestion(&self, name: &str) -> Option<&str> {
        if self.diagnostics.len() > MOST_HELPED {
            return None;
        }
        suggest(name, self.symbols.keys().map(String::as_str))
    }

    /// Reports a name that stands for nothing.
    pub(super) fn unknown_name(&mut self, name: &str, span: Span) {
        let remedy = match self.suggestion(name) {
            Some(near) => format!("Did you mean `{near}`?"),
            None => "Declare it as a variable, a constant or a formula.".to_owned(),
        };
        let message = format!("the name `{name}` is not declared.");
        self.report(Diagnostic::error("unknown-name", span, message).remedy(remedy));
    }

    /// Reports that the constant or formula `name` is defined by itself.
    pub(super) fn report_cycle(&mut self, name: &str) {
        let from = self
            .active
            .iter()
            .position(|(n, _)| *n == name)
            .unwrap_or(0);
        let cycle = &self.active[from..];
        let path: Vec<&str> = cycle.iter().map(|(n, _)| *n).chain([name]).collect();
        let span = cycle.first().map_or_else(Span::default, |(_, s)| *s);
        let message = format!("`{name}` is defined by itself: {}.", path.join(" -> "));
        let mut error = Diagnostic::error("cyclic-definition", span, message)
            .remedy("Break the cycle by giving one of them a value of its own.");
        for (other, place) in &cycle[1..] {
            error = error.related(*place, format!("through `{other}`"));
        }
        self.report(error);
    }

    /// Declares constants: those given or overridden by value, the others by definition.
    pub(super) fn declare_constants(
        &mut self,
        constants: &'a [ast::Constant],
        given: &Constants,
        overrides: &Constants,
        parameters: &[Parameter],
    ) {
        for constant in constants {
            let name = &constant.name.text;
            if let Some(index) = parameters.iter().position(|p| p.name == *name) {
                let symbol = Symbol::Parameter(index, constant.ty);
                self.declare(name, Some(constant.name.span), symbol);
                continue;
            }
            let symbol = match (overrides.get(name), given.get(name), &constant.value) {
                (Some(value), _, _) | (None, Some(value), None) => {
                    self.given_constant(constant, value)
                }
                (None, Some(_), Some(_)) => self.given_twice(constant),
                (None, None, Some(_)) => Symbol::ConstantDefinition(constant),
                (None, None, None) => Symbol::MissingConstant(constant),
            };
            self.declare(name, Some(constant.name.span), symbol);
        }
    }

    fn given_constant(&mut self, constant: &ast::Constant, value: &Value) -> Symbol<'a> {
        if let Some(value) = coerce(value.clone(), constant.ty) {
            return Symbol::Constant(value);
        }
        let name = &constant.name.text;
        let ty = constant.ty.keyword();
        let message =
            format!("constant `{name}` is declared as {ty}, but it was given the value {value}.");
        let error = Diagnostic::error("type", constant.name.span, message);
        self.report(error.remedy(format!("Give a value of type {ty}.")));
        Symbol::Broken
    }

    fn given_twice(&mut self, constant: &ast::Constant) -> Symbol<'a> {
        let name = &constant.name.text;
        let message = format!("constant `{name}` has a value here, and was given another one.");
        let error = Diagnostic::error("constant-given-twice", constant.span, message);
        self.report(error.remedy(format!(
            "Declare it without a value (`const {} {name};`), or do not give it one.",
            constant.ty.keyword()
        )));
        Symbol::Broken
    }

    /// Reports a constant without a value, once.
    pub(super) fn missing_constant(&mut self, constant: &ast::Constant) {
        let name = &constant.name.text;
        let message = format!("constant `{name}` has no value.");
        let error = Diagnostic::error("undefined-constant", constant.span, message);
        self.report(error.remedy(format!(
            "Give it one here, or from outside with `-const {name}=...`."
        )));
        self.redefine(name, Symbol::Broken);
    }
}

/// A value as one of this type: an int is a double, too.
pub(super) fn coerce(value: Value, ty: Type) -> Option<Value> {
    match (value, ty) {
        (Value::Int(value), Type::Double) => Some(Value::Double(Number::from_i64(value))),
        (value @ Value::Bool(_), Type::Bool)
        | (value @ Value::Int(_), Type::Int)
        | (value @ Value::Double(_), Type::Double) => Some(value),
        _ => None,
    }
}
