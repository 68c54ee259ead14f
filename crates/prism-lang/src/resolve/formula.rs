//! Formulas: true or false in a state, a number in a state, or true or false of a path.

use super::properties::PropertyResolver;
use super::scope::Renaming;
use crate::ast::{self, BinaryOp, ExprKind, Type, UnaryOp};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::Function;
use crate::property::{Filter, Objective, Path, Quantity, StateFormula};

/// How deep a formula may be once its references are written out.
const MAX_DEPTH: usize = 500;
/// How many operators references may make in all.
const MAX_NODES: usize = 200_000;

/// A formula of any kind.
#[derive(Clone)]
pub(super) enum Formula {
    State(StateFormula),
    Number(Quantity),
    Path(Path),
    /// `filter(range, ...)`.
    Range(Filter),
    /// `multi(...)`.
    Objectives(Vec<Objective>),
}

/// The size of what is being resolved.
#[derive(Clone, Copy, Default)]
pub(super) struct Size {
    /// How deep the present place is.
    depth: usize,
    /// The deepest place so far.
    deepest: usize,
    nodes: usize,
}

impl Size {
    /// Starts to measure a part; gives what `finish` needs.
    pub(super) fn start(&mut self) -> Self {
        let outside = *self;
        self.deepest = self.depth;
        outside
    }

    /// The size of the part, from its own root.
    pub(super) fn finish(&mut self, outside: Self) -> Self {
        let part = Self {
            depth: 0,
            deepest: self.deepest - outside.depth,
            nodes: self.nodes - outside.nodes,
        };
        self.deepest = self.deepest.max(outside.deepest);
        part
    }

    /// Adds a copy of a part here.
    pub(super) fn add(&mut self, part: Self) {
        self.deepest = self.deepest.max(self.depth + part.deepest);
        self.nodes += part.nodes;
    }
}

impl<'a> PropertyResolver<'a> {
    /// Whether what has been resolved has not grown too large; reports if it has.
    pub(super) fn is_small(&mut self, span: Span) -> bool {
        if self.size.deepest <= MAX_DEPTH && self.size.nodes <= MAX_NODES {
            return true;
        }
        let message = "this formula becomes too large when its references are written out.";
        let error = Diagnostic::error("too-large", span, message);
        self.scope
            .report(error.remedy("Refer to fewer other properties."));
        false
    }

    /// Resolves a formula of any kind; `None` if something in it was reported.
    pub(super) fn formula(&mut self, expr: &'a ast::Expr) -> Option<Formula> {
        if is_plain(expr) {
            let plain = self.scope.expression(expr, &Renaming::default())?;
            return Some(match plain.ty {
                Type::Bool => Formula::State(StateFormula::Expr(plain)),
                _ => Formula::Number(Quantity::Expr(plain)),
            });
        }
        self.size.depth += 1;
        self.size.nodes += 1;
        self.size.deepest = self.size.deepest.max(self.size.depth);
        let small = self.is_small(expr.span);
        let formula = if small { self.operator(expr) } else { None };
        self.size.depth -= 1;
        formula
    }

    fn operator(&mut self, expr: &'a ast::Expr) -> Option<Formula> {
        let span = expr.span;
        match &expr.kind {
            ExprKind::Label(name) => self.label(name, span),
            ExprKind::Unary(UnaryOp::Not, operand) => Some(match self.condition(operand)? {
                Formula::State(state) => Formula::State(StateFormula::Not(Box::new(state))),
                other => Formula::Path(Path::Not(Box::new(into_path(other)?))),
            }),
            ExprKind::Unary(UnaryOp::Minus, operand) => {
                let operand = self.number(operand, "the operand of `-`")?;
                Some(Formula::Number(Quantity::Minus(Box::new(operand))))
            }
            ExprKind::Binary(operator, a, b) => self.binary(*operator, a, b, span),
            ExprKind::IfThenElse(c, a, b) => self.choice(c, a, b, span),
            ExprKind::Call(name, arguments) => self.call(name, arguments, span),
            ExprKind::Probability { .. } | ExprKind::LongRun { .. } | ExprKind::Reward(_) => {
                self.query(expr)
            }
            ExprKind::Quantified(quantifier, path) => self.path_quantifier(*quantifier, path, span),
            ExprKind::Strategy(strategy) => self.strategy(strategy, span),
            ExprKind::Filter(filter) => self.filter(filter, span),
            ExprKind::Temporal {
                operator,
                bound,
                left,
                right,
            } => {
                let left = left.as_deref();
                self.temporal(*operator, bound.as_deref(), left, right, span)
            }
            _ => None,
        }
    }

    /// A formula that is true or false, of a state or of a path.
    fn condition(&mut self, expr: &'a ast::Expr) -> Option<Formula> {
        match self.formula(expr)? {
            found @ (Formula::State(_) | Formula::Path(_)) => Some(found),
            found => {
                self.no_truth_value(expr, &found);
                None
            }
        }
    }

    /// A formula that is true or false in a state.
    pub(super) fn state(&mut self, expr: &'a ast::Expr, what: &str) -> Option<StateFormula> {
        match self.condition(expr)? {
            Formula::State(state) => Some(state),
            _ => {
                let message = format!("{what} must be true or false of a state, not of a path.");
                let error = Diagnostic::error("type", expr.span, message);
                let remedy = "Put the path formula into an operator: `P>=1 [ ... ]`.";
                self.scope.report(error.remedy(remedy));
                None
            }
        }
    }

    /// A formula that is true or false of a path.
    pub(super) fn path(&mut self, expr: &'a ast::Expr) -> Option<Path> {
        self.condition(expr).and_then(into_path)
    }

    /// A formula that is a number.
    pub(super) fn number(&mut self, expr: &'a ast::Expr, what: &str) -> Option<Quantity> {
        let found = match self.formula(expr)? {
            Formula::Number(number) => return Some(number),
            Formula::State(_) => "true or false",
            Formula::Path(_) => "true or false of a path",
            Formula::Range(_) => "a range of numbers",
            Formula::Objectives(_) => "the value of several objectives",
        };
        let message = format!("{what} must be a number, but this is {found}.");
        let error = Diagnostic::error("type", expr.span, message);
        let remedy = "Choose with `condition ? 1 : 0`, or ask for a value with `=?`.";
        self.scope.report(error.remedy(remedy));
        None
    }

    /// Reports a number where something true or false is needed.
    fn no_truth_value(&mut self, expr: &'a ast::Expr, found: &Formula) {
        let (code, message, remedy) = match (&expr.kind, found) {
            (ExprKind::Label(name), _) if self.is_property(expr) => (
                "nested-query",
                format!("the property \"{name}\" has a number as its value."),
                "Refer to a property with a bound, such as `P>=0.9 [ ... ]`, or compare the number.",
            ),
            (ExprKind::Probability { optimum, .. }, _) => (
                "nested-query",
                format!(
                    "`P{}=?` has a number as its value, where true or false is needed.",
                    optimum.map_or("", ast::Optimum::word)
                ),
                "Give it a bound, such as `P>=0.9`.",
            ),
            (ExprKind::Reward(_) | ExprKind::LongRun { .. }, _) => (
                "nested-query",
                "this has a number as its value, where true or false is needed.".to_owned(),
                "Give it a bound, such as `<=5`.",
            ),
            (_, Formula::Number(number)) => (
                "type",
                format!(
                    "a formula must be a bool, but this is {}.",
                    super::expression::article(number.ty().keyword())
                ),
                "Compare it, for example with `>0`.",
            ),
            _ => (
                "type",
                "a formula must be a bool, but this has several values.".to_owned(),
                "Use it on its own.",
            ),
        };
        let error = Diagnostic::error(code, expr.span, message);
        self.scope.report(error.remedy(remedy));
    }

    fn binary(
        &mut self,
        operator: BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        match operator {
            BinaryOp::And | BinaryOp::Or | BinaryOp::Implies | BinaryOp::Iff => {
                self.connective(operator, a, b)
            }
            BinaryOp::Equal | BinaryOp::NotEqual => self.equality(operator, a, b, span),
            _ => {
                let what = format!("an operand of `{}`", operator.symbol());
                let (a, b) = (self.number(a, &what), self.number(b, &what));
                let (a, b) = (Box::new(a?), Box::new(b?));
                Some(match operator {
                    BinaryOp::Less
                    | BinaryOp::LessEqual
                    | BinaryOp::Greater
                    | BinaryOp::GreaterEqual => {
                        Formula::State(StateFormula::Compare(operator, a, b))
                    }
                    _ => Formula::Number(Quantity::Binary(operator, a, b)),
                })
            }
        }
    }

    fn connective(
        &mut self,
        operator: BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
    ) -> Option<Formula> {
        type Join<T> = fn(Box<T>, Box<T>) -> T;
        let (of_states, of_paths): (Join<StateFormula>, Join<Path>) = match operator {
            BinaryOp::And => (StateFormula::And, Path::And),
            BinaryOp::Or => (StateFormula::Or, Path::Or),
            BinaryOp::Implies => (StateFormula::Implies, Path::Implies),
            _ => (StateFormula::Iff, Path::Iff),
        };
        let (left, right) = (self.condition(a), self.condition(b));
        Some(match (left?, right?) {
            (Formula::State(a), Formula::State(b)) => {
                Formula::State(of_states(Box::new(a), Box::new(b)))
            }
            (a, b) => Formula::Path(of_paths(Box::new(into_path(a)?), Box::new(into_path(b)?))),
        })
    }

    /// `=` and `!=` of two numbers, or of two truth values.
    fn equality(
        &mut self,
        operator: BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let (left, right) = (self.formula(a), self.formula(b));
        Some(Formula::State(match (left?, right?) {
            (Formula::State(a), Formula::State(b)) => {
                let same = StateFormula::Iff(Box::new(a), Box::new(b));
                match operator {
                    BinaryOp::Equal => same,
                    _ => StateFormula::Not(Box::new(same)),
                }
            }
            (Formula::Number(a), Formula::Number(b)) => {
                StateFormula::Compare(operator, Box::new(a), Box::new(b))
            }
            _ => {
                let message = format!(
                    "`{}` must compare two numbers, or two formulas that are true or false in a state.",
                    operator.symbol()
                );
                let error = Diagnostic::error("type", span, message);
                self.scope
                    .report(error.remedy("Parentheses may be missing; of paths, write `<=>`."));
                return None;
            }
        }))
    }

    fn choice(
        &mut self,
        condition: &'a ast::Expr,
        then: &'a ast::Expr,
        otherwise: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let condition = self.state(condition, "the condition of `?`");
        let (then, otherwise) = (self.formula(then), self.formula(otherwise));
        match (then?, otherwise?) {
            (Formula::Number(a), Formula::Number(b)) => Some(Formula::Number(Quantity::Choice(
                Box::new(condition?),
                Box::new(a),
                Box::new(b),
            ))),
            (Formula::State(a), Formula::State(b)) => {
                let [condition, a, b] = [condition?, a, b].map(Box::new);
                Some(Formula::State(StateFormula::Choice(condition, a, b)))
            }
            _ => {
                let message = "the two results of `?` must be two truth values or two numbers.";
                let error = Diagnostic::error("type", span, message);
                self.scope
                    .report(error.remedy("Give both results the same type."));
                None
            }
        }
    }

    fn call(
        &mut self,
        name: &'a ast::Name,
        arguments: &'a [ast::Expr],
        span: Span,
    ) -> Option<Formula> {
        if name.text == "multi" {
            return self.objectives(arguments, span);
        }
        let Some(function) = Function::from_name(&name.text) else {
            self.scope.unknown_function(name);
            return None;
        };
        if !self.scope.has_arity(function, arguments.len(), span) {
            return None;
        }
        let what = format!("an argument of `{}`", function.name());
        let resolved: Vec<_> = arguments.iter().map(|a| self.number(a, &what)).collect();
        let resolved: Vec<Quantity> = resolved.into_iter().collect::<Option<_>>()?;
        let fraction = resolved.iter().position(|a| a.ty() == Type::Double);
        if let (Function::Mod, Some(place)) = (function, fraction) {
            let message = format!("{what} must be an int, but this is a double.");
            let error = Diagnostic::error("type", arguments[place].span, message);
            self.scope
                .report(error.remedy("Round it with `floor`, `ceil` or `round`."));
            return None;
        }
        Some(Formula::Number(Quantity::Call(function, resolved)))
    }
}

/// A formula of a state as one of a path's first state.
fn into_path(formula: Formula) -> Option<Path> {
    match formula {
        Formula::State(state) => Some(Path::State(Box::new(state))),
        Formula::Path(path) => Some(path),
        _ => None,
    }
}

/// Whether an expression is about variables only.
fn is_plain(expr: &ast::Expr) -> bool {
    match &expr.kind {
        ExprKind::Unary(_, a) => is_plain(a),
        ExprKind::Binary(_, a, b) => is_plain(a) && is_plain(b),
        ExprKind::IfThenElse(a, b, c) => is_plain(a) && is_plain(b) && is_plain(c),
        ExprKind::Call(name, arguments) => name.text != "multi" && arguments.iter().all(is_plain),
        ExprKind::Bool(_)
        | ExprKind::Int(_)
        | ExprKind::Double(_)
        | ExprKind::Name(_)
        | ExprKind::Error => true,
        _ => false,
    }
}
