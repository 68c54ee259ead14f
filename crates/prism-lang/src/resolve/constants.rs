//! The values of constants: computed when first needed, exactly, and only once.

use super::expression::{evaluate, literal};
use super::scope::{Renaming, Scope, Symbol, coerce};
use crate::ast::{self, BinaryOp, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, ExprKind};
use crate::number::{Number, Value};

impl<'a> Scope<'a> {
    /// The value of an expression without variables.
    pub(super) fn constant_value(
        &mut self,
        expr: &'a ast::Expr,
        renaming: &Renaming<'a>,
        ty: Type,
        what: &str,
    ) -> Option<Value> {
        let resolved = self.typed(expr, renaming, ty, what)?;
        self.value_of(&resolved, what)
            .and_then(|value| coerce(value, ty))
    }

    fn value_of(&mut self, expr: &Expr, what: &str) -> Option<Value> {
        if !expr.is_constant() {
            let (cause, remedy) = if expr.has_parameters() {
                (
                    "a constant that was left open",
                    "Give the constant a value.",
                )
            } else {
                ("a variable", "Use constants and literals only.")
            };
            let message = format!("{what} must be constant, but this depends on {cause}.");
            let error = Diagnostic::error("not-constant", expr.span, message);
            self.report(error.remedy(remedy));
            return None;
        }
        match evaluate(expr) {
            Ok(value) => Some(value),
            Err(error) => {
                let message = format!("{what} has no value: {}.", error.kind.problem());
                let diagnostic = Diagnostic::error("no-value", error.span, message);
                let mut remedy = error.kind.remedy().to_owned();
                remedy[..1].make_ascii_uppercase();
                self.report(diagnostic.remedy(remedy + "."));
                None
            }
        }
    }

    /// Resolves what decides over states, which no open constant may do.
    pub(super) fn closed(
        &mut self,
        expr: &'a ast::Expr,
        renaming: &Renaming<'a>,
        ty: Type,
        what: &str,
    ) -> Option<Expr> {
        let resolved = self.typed(expr, renaming, ty, what)?;
        if !resolved.has_parameters() {
            return Some(resolved);
        }
        let message = format!("{what} must not depend on a constant that was left open.");
        let error = Diagnostic::error("not-constant", resolved.span, message);
        self.report(error.remedy("Give the constant a value: the states must be known."));
        None
    }

    /// Evaluates a constant's definition and remembers the value.
    pub(super) fn define_constant(
        &mut self,
        constant: &'a ast::Constant,
        span: Span,
    ) -> Option<Expr> {
        let name = constant.name.text.as_str();
        if self.active.iter().any(|(n, _)| *n == name) {
            self.report_cycle(name);
            return None;
        }
        self.active.push((name, constant.name.span));
        let what = format!("constant `{name}`");
        let definition = constant.value.as_ref().and_then(|v| {
            let none = Renaming::default();
            self.typed(v, &none, constant.ty, &what)
        });
        let symbol = match definition {
            None => Symbol::Broken,
            // A constant that depends on open ones is written out where it is used.
            Some(open) if open.has_parameters() && open.variables().is_empty() => {
                Symbol::Formula(as_type(open, constant.ty))
            }
            Some(closed) => self
                .value_of(&closed, &what)
                .and_then(|value| coerce(value, constant.ty))
                .map_or(Symbol::Broken, Symbol::Constant),
        };
        self.active.pop();
        self.redefine(name, symbol.clone());
        match symbol {
            Symbol::Constant(value) => Some(literal(value, span)),
            Symbol::Formula(body) => Some(body),
            _ => None,
        }
    }

    /// The value of a declared constant (`Some(None)`: it was left open, or depends on one that was).
    pub(super) fn constant(&mut self, constant: &'a ast::Constant) -> Option<Option<Value>> {
        let name = constant.name.text.as_str();
        match self.symbol(name) {
            Some(Symbol::ConstantDefinition(_)) => {
                self.define_constant(constant, constant.span);
            }
            Some(Symbol::MissingConstant(_)) => self.missing_constant(constant),
            _ => {}
        }
        match self.symbol(name) {
            Some(Symbol::Constant(value)) => Some(Some(value.clone())),
            Some(Symbol::Parameter(..) | Symbol::Formula(_)) => Some(None),
            _ => None,
        }
    }
}

/// An `int` as a `double`, where that is declared.
fn as_type(expr: Expr, ty: Type) -> Expr {
    if expr.ty == ty {
        return expr;
    }
    let span = expr.span;
    let zero = Expr::double(Number::from_i64(0), span);
    let kind = ExprKind::Binary(BinaryOp::Plus, Box::new(expr), Box::new(zero));
    Expr { kind, ty, span }
}
