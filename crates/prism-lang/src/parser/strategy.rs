//! Filters, the path quantifiers `A` and `E`, and the players of `<<...>>` and `[[...]]`.

use super::expression::{Context, Node};
use super::{Parse, Parser, Reported, name_of};
use crate::ast::{Coalition, ExprKind, Filter, Name, Quantifier, Strategy};
use crate::diagnostic::Diagnostic;
use crate::lexer::TokenKind;

impl Parser<'_> {
    /// Whether this symbol follows twice, without a blank between.
    pub(super) fn is_doubled(&self, symbol: &str) -> bool {
        self.is_symbol(symbol)
            && self.is_symbol_ahead(1, symbol)
            && self.peek().span.end == self.peek_ahead(1).span.start
    }

    /// Reads `A [ ... ]` or `E [ ... ]`.
    pub(super) fn path_quantifier(&mut self, context: Context) -> Parse<Node> {
        let operator = self.advance();
        let what = format!("the operator `{}`", operator.text);
        self.require_property(context, &operator, &what);
        let quantifier = if operator.text == "A" {
            Quantifier::ForAll
        } else {
            Quantifier::Exists
        };
        self.expect("[")?;
        let path = self.nested(|p| p.temporal_binary(Context::Path))?;
        let span = operator.span.to(self.expect("]")?);
        let kind = ExprKind::Quantified(quantifier, Box::new(path.expr));
        Ok(self.node(kind, span, path.height + 1))
    }

    /// Reads `<<1,2>> P>=0.5 [ ... ]` or `[[*]] Rmin=? [ ... ]`.
    pub(super) fn strategy(&mut self, context: Context) -> Parse<Node> {
        let start = self.peek();
        let what = format!("strategies (`{0}{0}`)", start.text);
        self.require_property(context, &start, &what);
        self.advance();
        self.advance();
        let (quantifier, close) = match start.text {
            "<" => (Quantifier::Exists, ">"),
            _ => (Quantifier::ForAll, "]"),
        };
        let coalition = self.coalition(close)?;
        self.expect(close_symbol(close))?;
        self.expect(close_symbol(close))?;
        let token = self.peek();
        let operand = match (token.kind, token.text.chars().next()) {
            (TokenKind::Keyword, Some('P' | 'R')) | (TokenKind::Symbol, Some('(')) => {
                self.nested(|p| p.basic(context))?
            }
            _ => return Err(self.expected("`P`, `R` or a parenthesis")),
        };
        let span = start.span.to(self.previous_span());
        let kind = ExprKind::Strategy(Strategy {
            quantifier,
            coalition,
            operand: Box::new(operand.expr),
        });
        Ok(self.node(kind, span, operand.height + 1))
    }

    fn coalition(&mut self, close: &str) -> Parse<Coalition> {
        if self.accept("*") {
            return Ok(Coalition::All);
        }
        let mut players: Vec<Name> = Vec::new();
        while !self.is_symbol(close) {
            if !players.is_empty() {
                self.expect(",")?;
            }
            if !matches!(self.peek().kind, TokenKind::Integer | TokenKind::Name) {
                return Err(self.expected("the name or number of a player"));
            }
            players.push(name_of(&self.advance()));
        }
        Ok(Coalition::Players(players))
    }

    /// Reads `filter(min, P=? [ ... ], x=0)`.
    pub(super) fn filter(&mut self, context: Context) -> Parse<Node> {
        let start = self.advance();
        self.require_property(context, &start, "filters");
        self.expect("(")?;
        let token = self.peek();
        let is_operator =
            token.kind == TokenKind::Name || matches!(token.text, "min" | "max" | "+" | "&" | "|");
        if !is_operator {
            return Err(self.expected("the kind of a filter such as `min`, `forall` or `state`"));
        }
        let operator = name_of(&self.advance());
        self.expect(",")?;
        let inner = if context == Context::Model {
            Context::State
        } else {
            context
        };
        let operand = self.nested(|p| p.temporal_binary(inner))?;
        let (mut states, mut height) = (None, operand.height);
        if self.accept(",") {
            let node = self.nested(|p| p.temporal_binary(inner))?;
            height = height.max(node.height);
            states = Some(Box::new(node.expr));
        }
        let span = start.span.to(self.expect(")")?);
        let kind = ExprKind::Filter(Filter {
            operator,
            operand: Box::new(operand.expr),
            states,
        });
        Ok(self.node(kind, span, height + 1))
    }

    /// Reports an interval where a single probability belongs.
    pub(super) fn interval_outside_update(&mut self) -> Reported {
        let message = "an interval can only be the probability of an update.";
        let error = Diagnostic::error("syntax", self.peek().span, message);
        self.report(error.remedy("Write one number."));
        Reported
    }
}

fn close_symbol(close: &str) -> &'static str {
    if close == ">" { ">" } else { "]" }
}
