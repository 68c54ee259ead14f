//! Recursive descent from tokens to syntax trees (PRISM manual, sections "The PRISM language" and
//! "Property specification").
//!
//! A mistake is reported where it is found; parsing then goes on behind the next `;` or at the next
//! construct, so that one run finds all mistakes. Cost: linear in the text. Trees are at most
//! [`MAX_DEPTH`] deep, so that no text can exhaust the stack.

mod expression;
mod model;
mod module;
pub(crate) mod operator;
mod properties;
mod quantifier;
mod strategy;
mod system;

use std::borrow::Cow;

use crate::ast::Name;
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{KEYWORDS, Token, TokenKind, tokenize};
use crate::suggest::suggest;

pub use model::parse_model;
pub use properties::parse_properties;

/// How deep a syntax tree may be.
pub(crate) const MAX_DEPTH: usize = 400;

/// How many characters of a token a message quotes.
const MOST_QUOTED: usize = 60;

/// A mistake that has been reported: the caller recovers, or passes it on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reported;

type Parse<T> = Result<T, Reported>;

/// The tokens that are left, and what was wrong so far.
struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Token<'t>>,
    at: usize,
    depth: usize,
    /// Whether too deep a nesting has been reported.
    is_too_deep: bool,
    /// Whether `||` ends the formula that is read: it then separates what is asked for from what is given.
    takes_condition: bool,
    diagnostics: Vec<Diagnostic>,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str) -> Self {
        let (tokens, diagnostics) = tokenize(text);
        Self {
            text,
            tokens,
            at: 0,
            depth: 0,
            is_too_deep: false,
            takes_condition: false,
            diagnostics,
        }
    }

    /// The diagnostics in the order of their places.
    fn finish(mut self) -> Vec<Diagnostic> {
        self.diagnostics.sort_by_key(|d| (d.span.start, d.span.end));
        self.diagnostics
    }

    fn peek(&self) -> Token<'t> {
        self.peek_ahead(0)
    }

    /// The token `ahead` places on; behind the end, the end.
    fn peek_ahead(&self, ahead: usize) -> Token<'t> {
        self.tokens[(self.at + ahead).min(self.tokens.len() - 1)]
    }

    fn advance(&mut self) -> Token<'t> {
        let token = self.peek();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    fn at_end(&self) -> bool {
        self.peek().kind == TokenKind::End
    }

    /// The place of the token read last.
    fn previous_span(&self) -> Span {
        self.tokens[self.at.saturating_sub(1)].span
    }

    fn is_symbol(&self, symbol: &str) -> bool {
        self.is_symbol_ahead(0, symbol)
    }

    fn is_symbol_ahead(&self, ahead: usize, symbol: &str) -> bool {
        let token = self.peek_ahead(ahead);
        token.kind == TokenKind::Symbol && token.text == symbol
    }

    fn is_keyword(&self, keyword: &str) -> bool {
        let token = self.peek();
        token.kind == TokenKind::Keyword && token.text == keyword
    }

    /// Reads this symbol if it is next.
    fn accept(&mut self, symbol: &str) -> bool {
        let found = self.is_symbol(symbol);
        if found {
            self.advance();
        }
        found
    }

    fn accept_keyword(&mut self, keyword: &str) -> bool {
        let found = self.is_keyword(keyword);
        if found {
            self.advance();
        }
        found
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Reports that something else was expected here.
    fn expected(&mut self, what: &str) -> Reported {
        let token = self.peek();
        let found = describe(&token);
        // What is missing before a line break is missing at the end of the earlier line.
        let previous = self.previous_span();
        let between = self.text.get(previous.end..token.span.start).unwrap_or("");
        let span = if self.at > 0 && (between.contains('\n') || self.at_end()) {
            Span::new(previous.start, previous.end)
        } else {
            token.span
        };
        let place = if span == token.span {
            ""
        } else {
            " behind this"
        };
        let message = format!("expected {what}{place}, found {found}.");
        let mut error = Diagnostic::error("syntax", span, message);
        if span != token.span {
            error = error.related(token.span, "found this instead");
        }
        self.report(error.remedy(format!("Write {what} here.")));
        Reported
    }

    /// Reads this symbol, which must be next.
    fn expect(&mut self, symbol: &'static str) -> Parse<Span> {
        if self.is_symbol(symbol) {
            return Ok(self.advance().span);
        }
        Err(self.expected(&format!("`{symbol}`")))
    }

    fn expect_keyword(&mut self, keyword: &'static str) -> Parse<Span> {
        if self.is_keyword(keyword) {
            return Ok(self.advance().span);
        }
        Err(self.expected(&format!("`{keyword}`")))
    }

    /// Reads a name; a keyword in its place is explained.
    fn expect_name(&mut self, what: &str) -> Parse<Name> {
        let token = self.peek();
        if token.kind == TokenKind::Name {
            self.advance();
            return Ok(name_of(&token));
        }
        if token.kind == TokenKind::Keyword {
            let message = format!(
                "`{}` is a word of the PRISM language and cannot be {what}.",
                token.text
            );
            let error = Diagnostic::error("reserved-word", token.span, message);
            self.report(error.remedy("Choose another name."));
            return Err(Reported);
        }
        Err(self.expected(what))
    }

    /// The same where something is declared: a keyword is reported and read, so that what it names is read as well.
    fn expect_new_name(&mut self, what: &str) -> Parse<Name> {
        let token = self.peek();
        let name = self.expect_name(what);
        if name.is_err() && token.kind == TokenKind::Keyword && !self.starts_part() {
            self.advance();
            return Ok(name_of(&token));
        }
        name
    }

    /// Reads the name of an action or function, which may be `min` or `max` when renaming.
    fn expect_name_or_function(&mut self, what: &str) -> Parse<Name> {
        if self.is_keyword("min") || self.is_keyword("max") {
            return Ok(name_of(&self.advance()));
        }
        self.expect_name(what)
    }

    /// Skips to behind the next `;`, or to before a word at which something new starts.
    fn recover(&mut self, stops: &[&str]) {
        while !self.at_end() {
            if self.accept(";") {
                return;
            }
            let token = self.peek();
            if token.kind == TokenKind::Keyword && stops.contains(&token.text) {
                return;
            }
            self.advance();
        }
    }

    /// Skips to behind this word, or to the end.
    fn skip_past(&mut self, keyword: &str) {
        while !self.at_end() {
            if self.accept_keyword(keyword) {
                return;
            }
            self.advance();
        }
    }
}

fn name_of(token: &Token<'_>) -> Name {
    Name {
        text: token.text.to_owned(),
        span: token.span,
    }
}

/// How a message names a token.
fn describe(token: &Token<'_>) -> String {
    match token.kind {
        TokenKind::End => "the end of the text".to_owned(),
        TokenKind::Quoted => format!("\"{}\"", shortened(token.text)),
        TokenKind::Primed => format!("`{}'`", shortened(token.text)),
        _ => format!("`{}`", shortened(token.text)),
    }
}

/// The beginning of what a message quotes: a token may be of any length.
pub(crate) fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MOST_QUOTED) {
        None => text.into(),
        Some((end, _)) => format!("{}...", &text[..end]).into(),
    }
}

/// The keyword that a misspelt word probably was meant to be, among those allowed.
fn suggest_keyword<'k>(word: &str, allowed: &[&'k str]) -> Option<&'k str> {
    debug_assert!(allowed.iter().all(|k| KEYWORDS.contains(k)));
    suggest(word, allowed.iter().copied())
}
