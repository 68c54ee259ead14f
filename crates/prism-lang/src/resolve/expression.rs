//! Names bound, types checked, formulas inlined, constant parts computed.
//!
//! Typing is PRISM's: an `int` may stand where a `double` is needed, never the reverse; `/` gives a `double`;
//! `=` compares two truth values or two numbers.

use super::scope::{Renaming, Scope, Symbol};
use crate::ast::{self, BinaryOp, Type, UnaryOp};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, ExprKind, Function};
use crate::number::{Number, Value};

/// How deep an expression may be once its formulas are inlined.
const MAX_RESOLVED_DEPTH: usize = 800;
/// How many nodes inlined formulas may make in all.
const MAX_INLINED_NODES: usize = 2_000_000;

impl<'a> Scope<'a> {
    /// Resolves an expression; `None` if something in it was reported.
    pub(super) fn expression(
        &mut self,
        expr: &'a ast::Expr,
        renaming: &Renaming<'a>,
    ) -> Option<Expr> {
        self.resolve(expr, renaming, 0)
    }

    /// Resolves an expression that must be of this type.
    pub(super) fn typed(
        &mut self,
        expr: &'a ast::Expr,
        renaming: &Renaming<'a>,
        ty: Type,
        what: &str,
    ) -> Option<Expr> {
        let resolved = self.expression(expr, renaming)?;
        self.require(&resolved, ty, what).then_some(resolved)
    }

    /// Whether an expression can stand where this type is needed; reports if not.
    fn require(&mut self, expr: &Expr, ty: Type, what: &str) -> bool {
        if expr.ty == ty || (ty == Type::Double && expr.ty == Type::Int) {
            return true;
        }
        let (need, found) = (ty.keyword(), expr.ty.keyword());
        let message = format!(
            "{what} must be {}, but this is {}.",
            article(need),
            article(found)
        );
        let remedy = match (ty, expr.ty) {
            (Type::Bool, _) => "Compare it, for example with `>0`.",
            (Type::Int, Type::Double) => "Round it with `floor`, `ceil` or `round`.",
            _ => "Choose with `condition ? 1 : 0`.",
        };
        self.report(Diagnostic::error("type", expr.span, message).remedy(remedy));
        false
    }

    fn resolve(
        &mut self,
        expr: &'a ast::Expr,
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Option<Expr> {
        let span = expr.span;
        if depth > MAX_RESOLVED_DEPTH {
            self.too_large(span);
            return None;
        }
        let operand = |scope: &mut Self, e: &'a ast::Expr| scope.resolve(e, renaming, depth + 1);
        match &expr.kind {
            ast::ExprKind::Bool(value) => Some(Expr::bool(*value, span)),
            ast::ExprKind::Int(value) => Some(Expr::int(*value, span)),
            ast::ExprKind::Double(text) => Number::parse(text).map(|n| Expr::double(n, span)),
            ast::ExprKind::Name(name) => self.name(name, span, renaming, depth),
            ast::ExprKind::Unary(operator, a) => {
                let a = operand(self, a)?;
                self.unary(*operator, a, span)
            }
            ast::ExprKind::Binary(operator, a, b) => {
                // Both sides are read before giving up, so that mistakes on both are found.
                let (a, b) = (operand(self, a), operand(self, b));
                self.binary(*operator, a?, b?, span)
            }
            ast::ExprKind::IfThenElse(c, a, b) => {
                let (c, a, b) = (operand(self, c), operand(self, a), operand(self, b));
                self.if_then_else(c?, a?, b?, span)
            }
            ast::ExprKind::Call(function, arguments) => {
                let resolved: Vec<Option<Expr>> =
                    arguments.iter().map(|a| operand(self, a)).collect();
                let arguments = resolved.into_iter().collect::<Option<Vec<_>>>();
                self.call(function, renaming, arguments?, span)
            }
            ast::ExprKind::Error => None,
            _ => {
                self.property_part_in_expression(span);
                None
            }
        }
    }

    /// Reports a part of a property where only variables and constants can stand (the parser reports most).
    fn property_part_in_expression(&mut self, span: Span) {
        let message = "only variables, constants and formulas can be used here.";
        let error = Diagnostic::error("property-in-expression", span, message);
        self.report(error.remedy("Write the condition or the number itself."));
    }

    fn name(
        &mut self,
        name: &'a str,
        span: Span,
        renaming: &Renaming<'a>,
        depth: usize,
    ) -> Option<Expr> {
        // Formulas keep their name in a renamed module: it is their contents that are renamed.
        let is_formula = matches!(self.symbol(name), Some(Symbol::FormulaDefinition(_)));
        let name = if is_formula {
            name
        } else {
            renaming.apply(name)
        };
        match self.symbol(name).cloned() {
            None => {
                self.unknown_name(name, span);
                None
            }
            Some(Symbol::Broken) => None,
            Some(Symbol::Constant(value)) => Some(literal(value, span)),
            Some(Symbol::ConstantDefinition(constant)) => self.define_constant(constant, span),
            Some(Symbol::Parameter(index, ty)) => Some(Expr {
                kind: ExprKind::Parameter(index),
                ty,
                span,
            }),
            Some(Symbol::MissingConstant(constant)) => {
                self.missing_constant(constant);
                None
            }
            Some(Symbol::Variable(index, ty)) => Some(Expr {
                kind: ExprKind::Variable(index),
                ty,
                span,
            }),
            Some(Symbol::Formula(body)) => self.copy_of(&body, span, depth),
            Some(Symbol::FormulaDefinition(formula)) => self.inline(formula, renaming, span, depth),
        }
    }

    /// The resolved body of a formula, at its own place.
    fn inline(
        &mut self,
        formula: &'a ast::Formula,
        renaming: &Renaming<'a>,
        span: Span,
        depth: usize,
    ) -> Option<Expr> {
        let name = formula.name.text.as_str();
        let key = (renaming.id, name.to_owned());
        if !self.formulas.contains_key(&key) {
            if self.active.iter().any(|(n, _)| *n == name) {
                self.report_cycle(name);
                return None;
            }
            self.active.push((name, formula.name.span));
            let body = self.resolve(&formula.body, renaming, depth + 1);
            self.active.pop();
            self.formulas.insert(key.clone(), body);
        }
        let body = self.formulas.get(&key)?.clone()?;
        self.copy_of(&body, span, depth)
    }

    /// A formula's body, unless what it makes is too large.
    fn copy_of(&mut self, body: &Expr, span: Span, depth: usize) -> Option<Expr> {
        let nodes = count_nodes(body, MAX_INLINED_NODES);
        let is_deep = depth + height(body) > MAX_RESOLVED_DEPTH;
        if is_deep || self.inlined_nodes + nodes > MAX_INLINED_NODES {
            self.too_large(span);
            return None;
        }
        self.inlined_nodes += nodes;
        Some(body.clone())
    }

    /// Resolves a formula as such, for use in properties and to find its mistakes.
    pub(super) fn formula(&mut self, formula: &'a ast::Formula) -> Option<Expr> {
        self.inline(formula, &Renaming::default(), formula.span, 0)
    }

    fn too_large(&mut self, span: Span) {
        let message = "this expression becomes too large when its formulas are written out.";
        let error = Diagnostic::error("too-large", span, message);
        self.report(error.remedy("Hold intermediate results in variables or constants."));
    }

    fn unary(&mut self, operator: UnaryOp, a: Expr, span: Span) -> Option<Expr> {
        let ty = match operator {
            UnaryOp::Not => self
                .require(&a, Type::Bool, "the operand of `!`")
                .then_some(Type::Bool)?,
            UnaryOp::Minus => self
                .require(&a, Type::Double, "the operand of `-`")
                .then_some(a.ty)?,
        };
        Some(fold(ExprKind::Unary(operator, Box::new(a)), ty, span))
    }

    fn binary(&mut self, operator: BinaryOp, a: Expr, b: Expr, span: Span) -> Option<Expr> {
        let what = format!("an operand of `{}`", operator.symbol());
        let numeric = |scope: &mut Self| {
            scope.require(&a, Type::Double, &what) & scope.require(&b, Type::Double, &what)
        };
        let ty = match operator {
            BinaryOp::And | BinaryOp::Or | BinaryOp::Implies | BinaryOp::Iff => {
                let both =
                    self.require(&a, Type::Bool, &what) & self.require(&b, Type::Bool, &what);
                both.then_some(Type::Bool)?
            }
            BinaryOp::Equal | BinaryOp::NotEqual => {
                if (a.ty == Type::Bool) != (b.ty == Type::Bool) {
                    self.incomparable(operator, &a, &b, span);
                    return None;
                }
                Type::Bool
            }
            BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => {
                numeric(self).then_some(Type::Bool)?
            }
            BinaryOp::Divide => numeric(self).then_some(Type::Double)?,
            _ => numeric(self).then(|| join(a.ty, b.ty))?,
        };
        Some(fold(
            ExprKind::Binary(operator, Box::new(a), Box::new(b)),
            ty,
            span,
        ))
    }

    fn incomparable(&mut self, operator: BinaryOp, a: &Expr, b: &Expr, span: Span) {
        let message = format!(
            "`{}` cannot compare {} with {}.",
            operator.symbol(),
            article(a.ty.keyword()),
            article(b.ty.keyword())
        );
        let error = Diagnostic::error("type", span, message)
            .related(a.span, article(a.ty.keyword()))
            .related(b.span, article(b.ty.keyword()));
        self.report(
            error.remedy("Compare two truth values or two numbers; parentheses may be missing."),
        );
    }

    fn if_then_else(&mut self, c: Expr, a: Expr, b: Expr, span: Span) -> Option<Expr> {
        if !self.require(&c, Type::Bool, "the condition of `?`") {
            return None;
        }
        if (a.ty == Type::Bool) != (b.ty == Type::Bool) {
            let message = "the two results of `?` must be two truth values or two numbers.";
            let error = Diagnostic::error("type", span, message)
                .related(a.span, article(a.ty.keyword()))
                .related(b.span, article(b.ty.keyword()));
            self.report(error.remedy("Give both results the same type."));
            return None;
        }
        let ty = join(a.ty, b.ty);
        if let ExprKind::Bool(condition) = c.kind {
            let chosen = if condition { a } else { b };
            // A chosen int keeps the type of the whole.
            return Some(match (ty, chosen.kind) {
                (Type::Double, ExprKind::Int(value)) => Expr::double(Number::from_i64(value), span),
                (_, kind) if chosen.ty == ty => Expr { kind, ty, span },
                (_, kind) => {
                    let (c, chosen) = (Expr::bool(true, c.span), Expr { kind, ..chosen });
                    let zero = Expr::double(Number::from_i64(0), span);
                    let kind = ExprKind::IfThenElse(Box::new(c), Box::new(chosen), Box::new(zero));
                    Expr { kind, ty, span }
                }
            });
        }
        let kind = ExprKind::IfThenElse(Box::new(c), Box::new(a), Box::new(b));
        Some(Expr { kind, ty, span })
    }

    fn call(
        &mut self,
        name: &'a ast::Name,
        renaming: &Renaming<'a>,
        arguments: Vec<Expr>,
        span: Span,
    ) -> Option<Expr> {
        let Some(function) = Function::from_name(renaming.apply(&name.text)) else {
            self.unknown_function(name);
            return None;
        };
        if !self.has_arity(function, arguments.len(), span) {
            return None;
        }
        let needed = if function == Function::Mod {
            Type::Int
        } else {
            Type::Double
        };
        let what = format!("an argument of `{}`", function.name());
        let mut fits = true;
        for argument in &arguments {
            fits &= self.require(argument, needed, &what);
        }
        if !fits {
            return None;
        }
        let ty = function.result(arguments.iter().map(|a| a.ty).fold(Type::Int, join));
        Some(fold(ExprKind::Call(function, arguments), ty, span))
    }

    pub(super) fn unknown_function(&mut self, name: &ast::Name) {
        let known = Function::ALL.map(Function::name);
        let remedy = match crate::suggest::suggest(&name.text, known) {
            Some(near) => format!("Did you mean `{near}`?"),
            None => format!("The functions are {}.", known.join(", ")),
        };
        let message = format!("there is no function `{}`.", name.text);
        self.report(Diagnostic::error("unknown-function", name.span, message).remedy(remedy));
    }

    /// Whether a function takes so many arguments; reports if not.
    pub(super) fn has_arity(&mut self, function: Function, found: usize, span: Span) -> bool {
        let (least, most) = function.arity();
        if found >= least && most.is_none_or(|most| found <= most) {
            return true;
        }
        let needed = match most {
            Some(1) => "one argument".to_owned(),
            Some(most) => format!("{most} arguments"),
            None => format!("at least {least} argument"),
        };
        let message = format!("`{}` takes {needed} and has {found}.", function.name());
        let error = Diagnostic::error("wrong-arity", span, message);
        self.report(error.remedy("Give as many arguments as the function takes."));
        false
    }
}

/// The type of a result that may be either.
fn join(a: Type, b: Type) -> Type {
    if a == Type::Int { b } else { a }
}

pub(super) fn article(noun: &str) -> String {
    match noun {
        "int" => "an int".to_owned(),
        other => format!("a {other}"),
    }
}

pub(super) fn literal(value: Value, span: Span) -> Expr {
    match value {
        Value::Bool(value) => Expr::bool(value, span),
        Value::Int(value) => Expr::int(value, span),
        Value::Double(value) => Expr::double(value, span),
    }
}

/// The value of an expression that needs no state.
pub(super) fn evaluate(expr: &Expr) -> Result<Value, crate::EvalError> {
    Ok(match expr.ty {
        Type::Bool => Value::Bool(expr.eval_bool(&[])?),
        Type::Int => Value::Int(expr.eval_int(&[])?),
        Type::Double => Value::Double(expr.eval_number(&[])?),
    })
}

/// A node, computed beforehand if its operands are literals (and it has a value).
fn fold(kind: ExprKind, ty: Type, span: Span) -> Expr {
    let node = Expr { kind, ty, span };
    if let ExprKind::Binary(operator, a, b) = &node.kind
        && let (ExprKind::Bool(left), BinaryOp::And | BinaryOp::Or | BinaryOp::Implies) =
            (&a.kind, operator)
    {
        // The left operand decides, or the right one is the value.
        let decided = match operator {
            BinaryOp::And => (!left).then_some(false),
            BinaryOp::Or => left.then_some(true),
            _ => (!left).then_some(true),
        };
        return match decided {
            Some(value) => Expr::bool(value, span),
            None => Expr::clone(b),
        };
    }
    if !node.operands().iter().all(|o| is_literal(o)) {
        return node;
    }
    match evaluate(&node) {
        Ok(value) => literal(value, span),
        Err(_) => node,
    }
}

fn is_literal(expr: &Expr) -> bool {
    matches!(
        expr.kind,
        ExprKind::Bool(_) | ExprKind::Int(_) | ExprKind::Double(_)
    )
}

fn height(expr: &Expr) -> usize {
    1 + expr.operands().iter().map(|o| height(o)).max().unwrap_or(0)
}

/// The number of nodes, counted up to a limit.
fn count_nodes(expr: &Expr, limit: usize) -> usize {
    let mut count = 1;
    for operand in expr.operands() {
        if count >= limit {
            break;
        }
        count += count_nodes(operand, limit - count);
    }
    count
}
