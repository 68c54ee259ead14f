//! Expressions: precedence climbing over the levels of [`super::operator`].

use super::operator::{
    binary_of, level, level_of, operand_levels, temporal_infix, temporal_prefix,
};
use super::{MAX_DEPTH, Parse, Parser, Reported, describe, name_of};
use crate::ast::{BinaryOp, Expr, ExprKind, Name, StepBound, TemporalOp, UnaryOp};
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{Token, TokenKind};
use crate::number::Number;

/// Which constructs an expression may contain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Context {
    /// What a model may contain.
    Model,
    /// Also labels and `P`.
    State,
    /// Also temporal operators.
    Path,
}

/// Chains of `&` and `|` longer than this are balanced, so that long generated ones are not deep.
const LONGEST_UNBALANCED_CHAIN: usize = 64;

/// An expression and the height of its tree.
pub(super) struct Node {
    pub(super) expr: Expr,
    pub(super) height: usize,
}

impl Node {
    pub(super) fn leaf(kind: ExprKind, span: Span) -> Self {
        Self {
            expr: Expr { kind, span },
            height: 1,
        }
    }
}

impl Parser<'_> {
    /// Reads an expression.
    pub(super) fn expression(&mut self, context: Context) -> Parse<Expr> {
        Ok(self.temporal_binary(context)?.expr)
    }

    /// Reads a property: no temporal operator may stand outside of `P`, so that `R` starts the next property.
    pub(super) fn property_formula(&mut self) -> Parse<Expr> {
        if self.temporal_operator(temporal_prefix).is_some() {
            return self.expression(Context::State);
        }
        let formula = self.if_then_else(Context::State)?.expr;
        if self.is_keyword("U") || self.is_keyword("W") {
            let operator = self.advance();
            self.require_path(Context::State, &operator);
            return Err(Reported);
        }
        Ok(formula)
    }

    pub(super) fn temporal_binary(&mut self, context: Context) -> Parse<Node> {
        let mut left = self.temporal_unary(context)?;
        while let Some(operator) = self.temporal_operator(temporal_infix) {
            let token = self.advance();
            self.require_path(context, &token);
            let chained = matches!(&left.expr.kind, ExprKind::Temporal { left: Some(_), .. });
            if chained && left.expr.span.end == self.tokens[self.at - 2].span.end {
                self.report_parentheses(&token);
            }
            let bound = self.step_bound()?;
            let right = self.temporal_unary(Context::Path)?;
            left = self.temporal_node(operator, bound, Some(left), right, Span::default());
        }
        Ok(left)
    }

    fn temporal_unary(&mut self, context: Context) -> Parse<Node> {
        let Some(operator) = self.temporal_operator(temporal_prefix) else {
            return self.if_then_else(context);
        };
        let token = self.advance();
        self.require_path(context, &token);
        self.nested(|p| {
            let bound = p.step_bound()?;
            let operand = p.temporal_unary(Context::Path)?;
            Ok(p.temporal_node(operator, bound, None, operand, token.span))
        })
    }

    fn temporal_operator(&self, find: fn(&str) -> Option<TemporalOp>) -> Option<TemporalOp> {
        let token = self.peek();
        (token.kind == TokenKind::Keyword)
            .then(|| find(token.text))
            .flatten()
    }

    fn temporal_node(
        &mut self,
        operator: TemporalOp,
        bound: Option<StepBound>,
        left: Option<Node>,
        right: Node,
        start: Span,
    ) -> Node {
        let first = left.as_ref().map_or(start, |l| l.expr.span);
        let span = Span::new(first.start, self.previous_span().end);
        let height = 1 + right.height.max(left.as_ref().map_or(0, |l| l.height));
        let kind = ExprKind::Temporal {
            operator,
            bound: bound.map(Box::new),
            left: left.map(|l| Box::new(l.expr)),
            right: Box::new(right.expr),
        };
        self.node(kind, span, height)
    }

    /// Reports a temporal operator where none may stand.
    fn require_path(&mut self, context: Context, operator: &Token<'_>) {
        if context != Context::Path {
            let message = format!(
                "the temporal operator `{}` may stand only inside `P`.",
                operator.text
            );
            let remedy =
                "Ask for the probability of the path formula: `P=? [ ... ]` or `P>=1 [ ... ]`.";
            self.report(
                Diagnostic::error("temporal-outside-p", operator.span, message).remedy(remedy),
            );
        }
    }

    fn report_parentheses(&mut self, token: &Token<'_>) {
        let message = format!("`{}` needs parentheses here.", token.text);
        let remedy = match token.text {
            "U" | "W" | "R" => {
                format!("Write `(... {} ...)` around the inner formula.", token.text)
            }
            _ => format!("Write `({} ...)`.", token.text),
        };
        self.report(Diagnostic::error("needs-parentheses", token.span, message).remedy(remedy));
    }

    pub(super) fn if_then_else(&mut self, context: Context) -> Parse<Node> {
        let condition = self.binary(context, level::IMPLIES)?;
        if !self.accept("?") {
            return Ok(condition);
        }
        let then = self.binary(context, level::IMPLIES)?;
        self.expect(":")?;
        let otherwise = self.nested(|p| p.if_then_else(context))?;
        let span = condition.expr.span.to(self.previous_span());
        let height = 1 + condition.height.max(then.height).max(otherwise.height);
        let kind = ExprKind::IfThenElse(
            Box::new(condition.expr),
            Box::new(then.expr),
            Box::new(otherwise.expr),
        );
        Ok(self.node(kind, span, height))
    }

    /// Reads operators of at least this level.
    fn binary(&mut self, context: Context, least: u8) -> Parse<Node> {
        let start = self.peek().span.start;
        let mut left = self.prefix(context, least)?;
        while let Some(operator) = self.binary_operator(least) {
            let mut operands = vec![(left, self.previous_span().end)];
            let associative = matches!(operator, BinaryOp::And | BinaryOp::Or);
            let (_, right_level) = operand_levels(operator);
            loop {
                self.advance();
                let operand = self.nested(|p| p.binary(context, right_level))?;
                operands.push((operand, self.previous_span().end));
                if !associative || self.binary_operator(least) != Some(operator) {
                    break;
                }
            }
            left = self.chain(operator, operands, start);
        }
        Ok(left)
    }

    fn binary_operator(&self, least: u8) -> Option<BinaryOp> {
        let token = self.peek();
        // `<<` starts the next property.
        if token.kind != TokenKind::Symbol || self.is_doubled("<") {
            return None;
        }
        if self.takes_condition && self.is_doubled("|") {
            return None;
        }
        binary_of(token.text).filter(|op| level_of(*op) >= least)
    }

    /// Joins operands from the left; a long chain of an associative operator as a balanced tree. Each operand comes with where it
    /// ends, with its parentheses.
    fn chain(&mut self, operator: BinaryOp, operands: Vec<(Node, usize)>, start: usize) -> Node {
        let mut operands = operands;
        while operands.len() > LONGEST_UNBALANCED_CHAIN {
            let mut halved = Vec::with_capacity(operands.len() / 2 + 1);
            let mut rest = operands.into_iter();
            while let Some((a, end)) = rest.next() {
                halved.push(match rest.next() {
                    Some((b, end)) => (self.join(operator, a, (b, end), None), end),
                    None => (a, end),
                });
            }
            operands = halved;
        }
        let mut rest = operands.into_iter();
        let (mut left, _) = rest
            .next()
            .unwrap_or_else(|| (Node::leaf(ExprKind::Error, Span::default()), 0));
        for right in rest {
            left = self.join(operator, left, right, Some(start));
        }
        left
    }

    fn join(
        &mut self,
        operator: BinaryOp,
        a: Node,
        (b, end): (Node, usize),
        start: Option<usize>,
    ) -> Node {
        // With the operands' own parentheses, if they have any.
        let start = start.unwrap_or(a.expr.span.start).min(a.expr.span.start);
        let span = Span::new(start, end.max(b.expr.span.end));
        let height = 1 + a.height.max(b.height);
        let kind = ExprKind::Binary(operator, Box::new(a.expr), Box::new(b.expr));
        self.node(kind, span, height)
    }

    fn prefix(&mut self, context: Context, least: u8) -> Parse<Node> {
        let token = self.peek();
        let (operator, own) = match (token.kind, token.text) {
            (TokenKind::Symbol, "!") => (UnaryOp::Not, level::NOT),
            (TokenKind::Symbol, "-") => (UnaryOp::Minus, level::MINUS),
            _ => return self.basic(context),
        };
        self.advance();
        if own < least {
            self.report_parentheses(&token);
        }
        let operand = self.nested(|p| p.binary(context, own))?;
        let span = token.span.to(self.previous_span());
        let height = operand.height + 1;
        Ok(self.node(
            ExprKind::Unary(operator, Box::new(operand.expr)),
            span,
            height,
        ))
    }

    pub(super) fn basic(&mut self, context: Context) -> Parse<Node> {
        let token = self.peek();
        match token.kind {
            TokenKind::Integer | TokenKind::Real => Ok(self.literal()),
            TokenKind::Name if self.is_symbol_ahead(1, "(") => {
                let function = name_of(&self.advance());
                self.call(function, token.span, context)
            }
            TokenKind::Name => {
                self.advance();
                Ok(Node::leaf(
                    ExprKind::Name(token.text.to_owned()),
                    token.span,
                ))
            }
            TokenKind::Quoted => {
                self.advance();
                self.require_property(context, &token, "labels");
                Ok(Node::leaf(
                    ExprKind::Label(token.text.to_owned()),
                    token.span,
                ))
            }
            TokenKind::Symbol if token.text == "(" => self.parenthesised(context),
            TokenKind::Symbol if self.is_doubled("<") || self.is_doubled("[") => {
                self.strategy(context)
            }
            TokenKind::Symbol if token.text == "[" => Err(self.interval_outside_update()),
            TokenKind::Keyword => self.keyword_expression(context, &token),
            TokenKind::Primed => {
                let message = format!(
                    "`{}'` is a next value, which no expression can read.",
                    token.text
                );
                let error = Diagnostic::error("primed-in-expression", token.span, message);
                self.report(error.remedy(format!(
                    "Remove the prime to read the present value, or write an assignment in parentheses: `({}'=...)`.",
                    token.text
                )));
                Err(Reported)
            }
            TokenKind::Symbol => Err(self.misplaced_symbol(&token)),
            _ => Err(self.expected("an expression")),
        }
    }

    /// Reports a symbol where an operand should be, among them operators of other languages.
    fn misplaced_symbol(&mut self, token: &Token<'_>) -> Reported {
        let previous = self.tokens[self.at.saturating_sub(1)];
        let doubled = previous.text == token.text
            && previous.span.end == token.span.start
            && matches!(token.text, "=" | "&" | "|");
        if doubled {
            let text = token.text;
            let message = format!("there is no operator `{text}{text}`.");
            let span = previous.span.to(token.span);
            let error = Diagnostic::error("syntax", span, message);
            self.report(error.remedy(format!("Write `{text}`.")));
            return Reported;
        }
        self.expected("an expression")
    }

    fn parenthesised(&mut self, context: Context) -> Parse<Node> {
        let open = self.advance();
        // In parentheses, `||` is not what separates a condition.
        let outside = std::mem::replace(&mut self.takes_condition, false);
        let inside = self.nested(|p| p.temporal_binary(context));
        self.takes_condition = outside;
        let inside = inside?;
        if self.is_symbol(")") {
            self.advance();
            return Ok(inside);
        }
        let found = describe(&self.peek());
        let message = format!("expected `)`, found {found}.");
        let error = Diagnostic::error("syntax", self.peek().span, message);
        self.report(
            error
                .related(open.span, "this parenthesis is not closed")
                .remedy("Close the parenthesis, or write an operator."),
        );
        Err(Reported)
    }

    fn literal(&mut self) -> Node {
        let token = self.advance();
        if token.kind == TokenKind::Integer {
            if let Ok(value) = token.text.parse() {
                return Node::leaf(ExprKind::Int(value), token.span);
            }
            let found = super::describe(&token);
            let message = format!("the integer {found} does not fit into 64 bits.");
            let error = Diagnostic::error("literal-too-large", token.span, message);
            self.report(error.remedy("Write it as a double, with a decimal point."));
            return Node::leaf(ExprKind::Error, token.span);
        }
        if Number::parse(token.text).is_none_or(|n| !n.to_f64().is_finite()) {
            let message = format!("the number {} is out of range.", super::describe(&token));
            let error = Diagnostic::error("literal-too-large", token.span, message);
            self.report(error.remedy(
                "Use a number of at most 10000 digits, whose exponent is between -5000 and 308.",
            ));
            return Node::leaf(ExprKind::Error, token.span);
        }
        Node::leaf(ExprKind::Double(token.text.to_owned()), token.span)
    }

    /// Reads the arguments of a call, from the opening parenthesis on.
    fn call(&mut self, function: Name, start: Span, context: Context) -> Parse<Node> {
        self.expect("(")?;
        self.arguments(function, start, context)
    }

    fn arguments(&mut self, function: Name, start: Span, context: Context) -> Parse<Node> {
        let (mut arguments, mut height) = (Vec::new(), 0);
        loop {
            let argument = self.nested(|p| p.temporal_binary(context))?;
            height = height.max(argument.height);
            arguments.push(argument.expr);
            if !self.accept(",") {
                break;
            }
        }
        let close = self.expect(")")?;
        let kind = ExprKind::Call(function, arguments);
        Ok(self.node(kind, start.to(close), height + 1))
    }

    fn keyword_expression(&mut self, context: Context, token: &Token<'_>) -> Parse<Node> {
        match token.text {
            "true" | "false" => {
                self.advance();
                Ok(Node::leaf(ExprKind::Bool(token.text == "true"), token.span))
            }
            "min" | "max" => {
                let function = name_of(&self.advance());
                self.call(function, token.span, context)
            }
            "func" => {
                self.advance();
                self.expect("(")?;
                let function = self.expect_name_or_function("the name of a function")?;
                self.expect(",")?;
                self.arguments(function, token.span, context)
            }
            word if word.starts_with('P') => self.probability(context),
            word if word.starts_with('R') => self.reward(context),
            "S" => self.long_run(context),
            "A" | "E" => self.path_quantifier(context),
            "filter" => self.filter(context),
            "X" | "F" | "G" => {
                if context == Context::Path {
                    self.report_parentheses(token);
                }
                self.temporal_unary(context)
            }
            _ => Err(self.expected("an expression")),
        }
    }

    /// Goes one level down, unless that is too deep.
    pub(super) fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Parse<T>) -> Parse<T> {
        if self.depth >= MAX_DEPTH {
            let span = self.peek().span;
            return Err(self.too_deep(span));
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    /// A node, unless its tree is too high.
    pub(super) fn node(&mut self, kind: ExprKind, span: Span, height: usize) -> Node {
        if height > MAX_DEPTH {
            self.too_deep(span);
            return Node::leaf(ExprKind::Error, span);
        }
        Node {
            expr: Expr { kind, span },
            height,
        }
    }

    /// Reports the depth once: every node above the limit would say the same.
    fn too_deep(&mut self, span: Span) -> Reported {
        if std::mem::replace(&mut self.is_too_deep, true) {
            return Reported;
        }
        let message = format!("this expression is nested more than {MAX_DEPTH} deep.");
        let error = Diagnostic::error("too-deep", span, message);
        self.report(error.remedy("Split it with `formula name = ...;`."));
        Reported
    }
}
