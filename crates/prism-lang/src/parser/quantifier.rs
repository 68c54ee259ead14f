//! The operators `P`, `R` and `S` of properties, their bounds, and step bounds.

use super::expression::{Context, Node};
use super::operator::comparison_of;
use super::{Parse, Parser, Reported, name_of};
use crate::ast::{
    Comparison, Expr, ExprKind, Optimum, Reward, RewardIndex, RewardObjective, StateFilter,
    StepBound,
};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, TokenKind};

/// A comparison and a bound; none for `=?`.
type QueryBound = Option<(Comparison, Box<Expr>)>;

impl Parser<'_> {
    /// Reads `P=? [ ... ]`, `Pmax=? [ ... ]`, `P>=p [ ... ]`, `P=? [ ... || ... ]`.
    pub(super) fn probability(&mut self, context: Context) -> Parse<Node> {
        let operator = self.operator_letter(context, "P");
        let optimum = self.optimum(&operator);
        let bound = self.query_bound(optimum, "P")?;
        self.expect("[")?;
        let path = self.formula_before_condition(true)?;
        let (mut condition, mut height) = (None, path.height);
        if self.is_doubled("|") {
            self.advance();
            self.advance();
            let given = self.formula_before_condition(false)?;
            height = height.max(given.height);
            condition = Some(Box::new(given.expr));
        }
        let filter = self.state_filter(bound.is_some())?;
        let close = self.expect("]")?;
        let kind = ExprKind::Probability {
            optimum,
            bound,
            path: Box::new(path.expr),
            condition,
            filter: filter.map(Box::new),
        };
        Ok(self.node(kind, operator.span.to(close), height + 1))
    }

    /// Reads a path formula that a condition may or may not follow.
    fn formula_before_condition(&mut self, takes_condition: bool) -> Parse<Node> {
        let outside = std::mem::replace(&mut self.takes_condition, takes_condition);
        let found = self.nested(|p| p.temporal_binary(Context::Path));
        self.takes_condition = outside;
        found
    }

    /// Reads `S=? [ ... ]`, `S>=p [ ... ]`.
    pub(super) fn long_run(&mut self, context: Context) -> Parse<Node> {
        let operator = self.operator_letter(context, "S");
        let bound = self.query_bound(None, "S")?;
        self.expect("[")?;
        let states = self.nested(|p| p.temporal_binary(Context::State))?;
        let filter = self.state_filter(bound.is_some())?;
        let close = self.expect("]")?;
        let kind = ExprKind::LongRun {
            bound,
            states: Box::new(states.expr),
            filter: filter.map(Box::new),
        };
        Ok(self.node(kind, operator.span.to(close), states.height + 1))
    }

    /// Reads `R{"r"}=? [ ... ]`, `Rmax=? [ ... ]`, `R<=5 [ ... ]`.
    pub(super) fn reward(&mut self, context: Context) -> Parse<Node> {
        let operator = self.operator_letter(context, "R");
        let (mut structure, mut divisor) = (None, None);
        if self.is_symbol("{") {
            structure = Some(self.reward_index(&operator)?);
            if self.accept("/") {
                divisor = Some(self.reward_index(&operator)?);
            }
        }
        let optimum = self.optimum(&operator);
        let bound = self.query_bound(optimum, "R")?;
        self.expect("[")?;
        let (objective, height) = self.nested(Self::reward_objective)?;
        let filter = self.state_filter(bound.is_some())?;
        let close = self.expect("]")?;
        let kind = ExprKind::Reward(Box::new(Reward {
            structure,
            divisor,
            optimum,
            bound,
            objective,
            filter,
        }));
        Ok(self.node(kind, operator.span.to(close), height + 1))
    }

    /// Reads the operator's keyword, and a modifier such as `P(x)`, which no operator knows.
    /// The token's text is the word behind the letter: `min` for `Pmin`.
    fn operator_letter(&mut self, context: Context, letter: &str) -> Token<'static> {
        let operator = self.peek();
        let what = format!("the operator `{letter}`");
        self.require_property(context, &operator, &what);
        self.advance();
        if self.is_symbol("(") {
            let message = format!("`{letter}` has no modifiers in parentheses.");
            let error = Diagnostic::error("syntax", self.peek().span, message);
            let remedy = format!("Write `{letter}=? [ ... ]`.");
            self.report(error.remedy(remedy));
            while !self.at_end() && !self.is_symbol("[") && !self.accept(")") {
                self.advance();
            }
        }
        Token {
            kind: operator.kind,
            text: optimum_word(operator.text),
            span: operator.span,
        }
    }

    /// Reads `min`, `max`, `minmax`, ... behind the letter, or as part of it.
    fn optimum(&mut self, operator: &Token<'_>) -> Option<Optimum> {
        let of_word = |word: &str| Optimum::ALL.into_iter().find(|o| o.word() == word);
        if let Some(optimum) = of_word(operator.text) {
            return Some(optimum);
        }
        let keyword = |p: &Self| match p.peek() {
            token if token.kind == TokenKind::Keyword => of_word(token.text),
            _ => None,
        };
        let first = keyword(self)?;
        self.advance();
        let Some(second @ (Optimum::Min | Optimum::Max)) = keyword(self) else {
            return Some(first);
        };
        self.advance();
        of_word(&format!("{}{}", first.word(), second.word())).or(Some(first))
    }

    fn query_bound(&mut self, optimum: Option<Optimum>, letter: &str) -> Parse<QueryBound> {
        if self.is_symbol("=") && self.is_symbol_ahead(1, "?") {
            self.advance();
            self.advance();
            return Ok(None);
        }
        let token = self.peek();
        if let Some(comparison) = comparison_of(token.text) {
            if let Some(optimum) = optimum {
                let word = optimum.word();
                let message = format!("`{letter}{word}` asks for a value and takes no bound.");
                let error = Diagnostic::error("syntax", token.span, message);
                self.report(error.remedy(format!(
                    "Write `{letter}{word}=?`, or `{letter}{} ...`, which compares under every scheduler.",
                    token.text
                )));
            }
            self.advance();
            let bound = self.nested(|p| p.temporal_binary(Context::Model))?;
            return Ok(Some((comparison, Box::new(bound.expr))));
        }
        if self.is_symbol("=") {
            let message = format!("`{letter}` cannot be compared with `=`.");
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy(format!(
                "Write `{letter}=?` for the value, or compare with <, <=, > or >=."
            )));
            return Err(Reported);
        }
        Err(self.expected("`=?` or a bound such as `>=0.9`"))
    }

    /// Reads `{"name"}` or `{2}`.
    fn reward_index(&mut self, operator: &Token<'_>) -> Parse<RewardIndex> {
        let brace = self.expect("{")?;
        if !operator.text.is_empty() {
            let message = "the reward structure stands before `min` and `max`.";
            let error = Diagnostic::error("syntax", operator.span.to(brace), message);
            let remedy = format!("Write `R{{...}}{}=?`.", operator.text);
            self.report(error.remedy(remedy));
        }
        let index = if self.peek().kind == TokenKind::Quoted {
            RewardIndex::Name(name_of(&self.advance()))
        } else {
            RewardIndex::Index(self.nested(|p| p.temporal_binary(Context::Model))?.expr)
        };
        self.expect("}")?;
        Ok(index)
    }

    /// Reads what stands between the brackets of `R`, and its height.
    fn reward_objective(&mut self) -> Parse<(RewardObjective, usize)> {
        let model = |p: &mut Self| p.nested(|p| p.temporal_binary(Context::Model));
        if self.accept_keyword("C") {
            if self.accept("<=") {
                let bound = model(self)?;
                return Ok((RewardObjective::Cumulative(bound.expr), bound.height));
            }
            return Ok((RewardObjective::Total, 1));
        }
        if self.accept_keyword("I") {
            self.expect("=")?;
            let time = model(self)?;
            return Ok((RewardObjective::Instantaneous(time.expr), time.height));
        }
        // `S` alone is the long-run reward, `S=? [...]` a formula.
        if self.is_keyword("S") && (self.is_symbol_ahead(1, "]") || self.is_symbol_ahead(1, "{")) {
            self.advance();
            return Ok((RewardObjective::LongRun, 1));
        }
        let path = self.temporal_binary(Context::Path)?;
        Ok((RewardObjective::Path(path.expr), path.height))
    }

    /// Reads `{states}{min}{max}` before the closing bracket.
    fn state_filter(&mut self, is_compared: bool) -> Parse<Option<StateFilter>> {
        if !self.accept("{") {
            return Ok(None);
        }
        let states = self.nested(|p| p.temporal_binary(Context::State))?.expr;
        self.expect("}")?;
        let (mut min, mut max) = (false, false);
        while self.is_symbol("{") {
            let brace = self.advance();
            if self.accept_keyword("min") {
                min = true;
            } else if self.accept_keyword("max") {
                max = true;
            } else {
                return Err(self.expected("`min` or `max`"));
            }
            let close = self.expect("}")?;
            if is_compared {
                let message = "a formula with a bound is true or false and has no minimum.";
                let span = brace.span.to(close);
                let error = Diagnostic::error("syntax", span, message);
                self.report(error.remedy("Remove it, or ask for the value with `=?`."));
            }
        }
        Ok(Some(StateFilter { states, min, max }))
    }

    /// Reads the step bound of a temporal operator, if there is one.
    pub(super) fn step_bound(&mut self) -> Parse<Option<StepBound>> {
        if self.is_symbol("[") && !self.is_doubled("[") {
            self.advance();
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
        match comparison_of(token.text)
            .filter(|_| token.kind == TokenKind::Symbol && !self.is_doubled("<"))
        {
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
        // Without temporal operators: `F<=3 R>2 [ C ]` has no release.
        Ok(self.nested(|p| p.if_then_else(Context::Model))?.expr)
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
}

/// The word behind the letter of `Pmin`, `Rmaxmin`, ...
fn optimum_word(keyword: &str) -> &'static str {
    let found = Optimum::ALL.into_iter().find(|o| o.word() == &keyword[1..]);
    found.map_or("", Optimum::word)
}
