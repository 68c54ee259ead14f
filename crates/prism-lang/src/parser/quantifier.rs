//! What only properties contain: `P`, step bounds, and the operators of PRISM that are not supported.

use super::expression::{Context, Node};
use super::operator::comparison_of;
use super::{Parse, Parser, Reported};
use crate::ast::{Comparison, Expr, ExprKind, StepBound};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::Span;
use crate::lexer::{Token, TokenKind};

/// A comparison and a bound; none for `=?`.
type ProbabilityBound = Option<(Comparison, Box<Expr>)>;

impl Parser<'_> {
    /// Reads `P=? [ ... ]` or `P>=p [ ... ]`.
    pub(super) fn probability(&mut self, context: Context) -> Parse<Node> {
        let operator = self.advance();
        self.require_property(context, &operator, "the operator `P`");
        if self.is_symbol("(") || self.is_keyword("min") || self.is_keyword("max") {
            return self.unsupported_operator(&operator);
        }
        let bound = self.probability_bound()?;
        self.expect("[")?;
        let path = self.nested(|p| p.temporal_binary(Context::Path))?;
        if self.is_symbol("{") {
            let brace = self.peek();
            self.skip_braces();
            self.report_unsupported(
                "filters in braces (`{...}`)",
                brace.span,
                "Remove the filter.",
            );
        }
        let close = self.expect("]")?;
        let kind = ExprKind::Probability {
            bound,
            path: Box::new(path.expr),
        };
        Ok(self.node(kind, operator.span.to(close), path.height + 1))
    }

    pub(super) fn probability_bound(&mut self) -> Parse<ProbabilityBound> {
        if self.is_symbol("=") && self.is_symbol_ahead(1, "?") {
            self.advance();
            self.advance();
            return Ok(None);
        }
        let token = self.peek();
        if let Some(comparison) = comparison_of(token.text) {
            self.advance();
            let bound = self.nested(|p| p.temporal_binary(Context::Model))?;
            return Ok(Some((comparison, Box::new(bound.expr))));
        }
        if self.is_symbol("=") {
            let message = "`P` cannot be compared with `=`.";
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy("Write `P=?` for the value, or compare with <, <=, > or >=."));
            return Err(Reported);
        }
        Err(self.expected("`=?` or a bound such as `>=0.9`"))
    }

    /// Reads the step bound of a temporal operator, if there is one.
    pub(super) fn step_bound(&mut self) -> Parse<Option<StepBound>> {
        if self.accept("[") {
            let low = self.nested(|p| p.temporal_binary(Context::Model))?.expr;
            self.expect(",")?;
            let high = self.nested(|p| p.temporal_binary(Context::Model))?.expr;
            self.expect("]")?;
            return Ok(Some(StepBound::Between(low, high)));
        }
        if self.accept("=") {
            return Ok(Some(StepBound::Exactly(self.step_count()?)));
        }
        let token = self.peek();
        match comparison_of(token.text).filter(|_| token.kind == TokenKind::Symbol) {
            Some(comparison) => {
                self.advance();
                Ok(Some(StepBound::Compare(comparison, self.step_count()?)))
            }
            None => Ok(None),
        }
    }

    /// Reads a number of steps: in `F<=t (a)` that is `t`, not a call.
    pub(super) fn step_count(&mut self) -> Parse<Expr> {
        if self.peek().kind == TokenKind::Name && self.is_symbol_ahead(1, "(") {
            let token = self.advance();
            return Ok(Node::leaf(ExprKind::Name(token.text.to_owned()), token.span).expr);
        }
        Ok(self.nested(|p| p.temporal_binary(Context::Model))?.expr)
    }

    pub(super) fn require_property(&mut self, context: Context, token: &Token<'_>, what: &str) {
        if context == Context::Model {
            let message =
                format!("{what} cannot be used here: this expression is about variables only.");
            let error = Diagnostic::error("property-in-model", token.span, message);
            self.report(
                error
                    .remedy("Write the condition itself, or define it with `formula name = ...;`."),
            );
        }
    }

    /// Names a construct of PRISM's property language that is not supported, and skips it.
    pub(super) fn unsupported_operator(&mut self, token: &Token<'_>) -> Parse<Node> {
        let (what, remedy) = match token.text {
            "P" | "Pmin" | "Pmax" | "Pminmin" | "Pminmax" | "Pmaxmin" | "Pmaxmax" => (
                "minimal and maximal probabilities over schedulers",
                "A dtmc has no choices: write `P=? [ ... ]`.",
            ),
            "R" | "Rmin" | "Rmax" | "Rminmin" | "Rminmax" | "Rmaxmin" | "Rmaxmax" => {
                ("expected rewards (`R`)", "Ask for a probability with `P`.")
            }
            "S" => (
                "long-run probabilities (`S`)",
                "Ask for a probability with `P`.",
            ),
            "A" | "E" => (
                "the path quantifiers `A` and `E`",
                "Write `P>=1 [ ... ]` for almost all paths, `P>0 [ ... ]` for some.",
            ),
            "multi" => (
                "queries with several objectives (`multi(...)`)",
                "Ask for each probability on its own.",
            ),
            "filter" => (
                "filters (`filter(...)`)",
                "Ask for the value in the initial state.",
            ),
            _ => {
                return Err(self.expected("an expression"));
            }
        };
        if self.peek().span == token.span {
            self.advance();
        }
        self.report_unsupported(what, token.span, remedy);
        self.skip_operator();
        let span = token.span.to(self.previous_span());
        Ok(Node::leaf(ExprKind::Error, span))
    }

    pub(super) fn report_unsupported(&mut self, what: &str, span: Span, remedy: &str) {
        let message = format!("{what} are not supported.");
        self.report(Diagnostic::error("unsupported", span, message).remedy(remedy));
    }

    /// Skips the rest of an operator: up to and with its bracket, or up to the end of the property.
    pub(super) fn skip_operator(&mut self) {
        let mut open = 0usize;
        while !self.at_end() && !self.is_symbol(";") {
            let token = self.peek();
            match (token.kind, token.text) {
                (TokenKind::Symbol, "[" | "(" | "{") => open += 1,
                (TokenKind::Symbol, "]" | ")" | "}") if open == 0 => return,
                (TokenKind::Symbol, closing @ ("]" | ")" | "}")) => {
                    open -= 1;
                    // Braces and `(modifier)` precede the bracket.
                    let more = self.peek_ahead(1);
                    let goes_on = closing != "]"
                        && matches!(
                            more.text,
                            "[" | "=" | "<" | "<=" | ">" | ">=" | "/" | "{" | "min" | "max"
                        );
                    if open == 0 && !goes_on {
                        self.advance();
                        return;
                    }
                }
                _ => {}
            }
            self.advance();
        }
    }

    pub(super) fn skip_braces(&mut self) {
        while !self.at_end() && !self.is_symbol("]") && !self.is_symbol(";") {
            self.advance();
        }
    }
}
