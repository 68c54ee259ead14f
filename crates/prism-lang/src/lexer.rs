//! Text to tokens. Every byte that is neither white space nor a comment belongs to a token or to a diagnostic.

use crate::diagnostic::{Diagnostic, Span};

/// Words that cannot be names (PRISM manual, section "Identifiers", and PRISM's own grammar).
pub(crate) const KEYWORDS: &[&str] = &[
    "A",
    "bool",
    "clock",
    "const",
    "ctmc",
    "C",
    "double",
    "dtmc",
    "E",
    "endinit",
    "endinvariant",
    "endmodule",
    "endobservables",
    "endrewards",
    "endsystem",
    "false",
    "formula",
    "filter",
    "func",
    "F",
    "global",
    "G",
    "init",
    "invariant",
    "I",
    "int",
    "label",
    "maxmax",
    "maxmin",
    "max",
    "mdp",
    "minmax",
    "minmin",
    "min",
    "module",
    "X",
    "nondeterministic",
    "observable",
    "observables",
    "Pmaxmax",
    "Pmaxmin",
    "Pmax",
    "Pminmax",
    "Pminmin",
    "Pmin",
    "P",
    "pomdp",
    "popta",
    "probabilistic",
    "prob",
    "pta",
    "rate",
    "rewards",
    "Rmaxmax",
    "Rmaxmin",
    "Rmax",
    "Rminmax",
    "Rminmin",
    "Rmin",
    "R",
    "S",
    "stochastic",
    "system",
    "true",
    "U",
    "W",
];

/// Symbols, longer ones before their prefixes.
const SYMBOLS: &[&str] = &[
    "<=>", "=>", "->", "..", "!=", "<=", ">=", "!", "&", "|", ":", ";", ",", "(", ")", "[", "]",
    "{", "}", "=", "<", ">", "+", "-", "*", "/", "^", "?",
];

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A name that is no keyword.
    Name,
    /// A name with a prime behind it; the token's text has no prime.
    Primed,
    /// A word of [`KEYWORDS`].
    Keyword,
    /// An entry of [`SYMBOLS`].
    Symbol,
    /// Digits only.
    Integer,
    /// A number with a fraction or an exponent.
    Real,
    /// A name in double quotes; the token's text has no quotes.
    Quoted,
    /// The end of the text.
    End,
}

/// A token, its text and its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token<'t> {
    pub(crate) kind: TokenKind,
    pub(crate) text: &'t str,
    pub(crate) span: Span,
}

/// All tokens of a text, closed by an `End`, and what was no token.
pub(crate) fn tokenize(text: &str) -> (Vec<Token<'_>>, Vec<Diagnostic>) {
    let mut lexer = Lexer {
        text,
        at: 0,
        tokens: Vec::new(),
        diagnostics: Vec::new(),
    };
    while lexer.skip_blanks() {
        lexer.next_token();
    }
    lexer.push(TokenKind::End, text.len(), "");
    (lexer.tokens, lexer.diagnostics)
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
    tokens: Vec<Token<'t>>,
    diagnostics: Vec<Diagnostic>,
}

impl<'t> Lexer<'t> {
    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    /// Skips white space and comments; false at the end.
    fn skip_blanks(&mut self) -> bool {
        loop {
            let rest = self
                .rest()
                .trim_start_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
            self.at = self.text.len() - rest.len();
            if !rest.starts_with("//") {
                return !rest.is_empty();
            }
            self.at += rest.find('\n').unwrap_or(rest.len());
        }
    }

    /// Appends a token of the text from here to `end`, and goes on behind it.
    fn push(&mut self, kind: TokenKind, end: usize, text: &'t str) {
        let span = Span::new(self.at, end);
        self.tokens.push(Token { kind, text, span });
        self.at = end;
    }

    fn next_token(&mut self) {
        let rest = self.rest();
        let first = rest.chars().next().unwrap_or(' ');
        if first.is_ascii_alphabetic() || first == '_' {
            self.word();
        } else if first.is_ascii_digit() || starts_with_fraction(rest) {
            self.number();
        } else if first == '"' {
            self.quoted();
        } else if let Some(symbol) = symbol(rest) {
            self.push(TokenKind::Symbol, self.at + symbol.len(), symbol);
        } else {
            self.invalid(first);
        }
    }

    fn word(&mut self) {
        let rest = self.rest();
        let length = rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let word = &rest[..length];
        let end = self.at + length;
        if rest[length..].starts_with('\'') {
            self.push(TokenKind::Primed, end + 1, word);
        } else if KEYWORDS.contains(&word) {
            self.push(TokenKind::Keyword, end, word);
        } else {
            self.push(TokenKind::Name, end, word);
        }
    }

    fn number(&mut self) {
        let rest = self.rest();
        let mut length = count_digits(rest);
        let whole = length;
        if starts_with_fraction(&rest[length..]) {
            length += 1 + count_digits(&rest[length + 1..]);
        }
        length += exponent_length(&rest[length..]);
        // `007` is a number in PRISM, but not an integer.
        let integer = length == whole && (whole == 1 || !rest.starts_with('0'));
        let kind = if integer {
            TokenKind::Integer
        } else {
            TokenKind::Real
        };
        self.push(kind, self.at + length, &rest[..length]);
    }

    fn quoted(&mut self) {
        let inside = &self.rest()[1..];
        let length = inside.find(['"', '\n']).unwrap_or(inside.len());
        let name = inside[..length].trim();
        let closed = inside[length..].starts_with('"');
        let end = self.at + 1 + length + usize::from(closed);
        let is_name = !name.is_empty()
            && !name.starts_with(|c: char| c.is_ascii_digit())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !closed {
            let message = "this quote is not closed on its line.";
            let error = Diagnostic::error("unclosed-quote", Span::new(self.at, end), message);
            self.diagnostics
                .push(error.remedy("Close the name with `\"`."));
        } else if !is_name {
            let message = format!("\"{}\" is not a name.", crate::parser::shortened(name));
            let error = Diagnostic::error("not-a-name", Span::new(self.at, end), message);
            self.diagnostics.push(
                error.remedy("Names are letters, digits and `_`, and do not start with a digit."),
            );
        }
        self.push(TokenKind::Quoted, end, name);
    }

    fn invalid(&mut self, character: char) {
        let (end, message, remedy) = match character {
            '#' => {
                let inside = &self.rest()[1..];
                let length = inside.find('#').map_or(inside.len(), |p| p + 1);
                let message = "PRISM's preprocessor (`#...#`) is not supported.";
                (
                    self.at + 1 + length,
                    message.to_owned(),
                    "Expand the model with PRISM's `prismpp` first.",
                )
            }
            '\'' => (
                self.at + 1,
                "this prime does not follow a name.".to_owned(),
                "Write the prime directly behind the variable: `x'`.",
            ),
            _ => (
                self.at + character.len_utf8(),
                format!(
                    "`{}` is not part of the PRISM language.",
                    character.escape_debug()
                ),
                "Remove it.",
            ),
        };
        let span = Span::new(self.at, end);
        self.diagnostics
            .push(Diagnostic::error("invalid-character", span, message).remedy(remedy));
        self.at = end;
    }
}

/// The symbol that a text begins with.
fn symbol(text: &str) -> Option<&'static str> {
    let first = text.as_bytes().first()?;
    let mut symbols = SYMBOLS.iter().copied();
    // The first byte tells most of them apart.
    symbols.find(|symbol| symbol.as_bytes()[0] == *first && text.starts_with(symbol))
}

fn count_digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

/// Whether a point and a digit follow (two points are a range).
fn starts_with_fraction(text: &str) -> bool {
    text.strip_prefix('.')
        .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

fn exponent_length(text: &str) -> usize {
    let Some(rest) = text.strip_prefix(['e', 'E']) else {
        return 0;
    };
    let sign = usize::from(rest.starts_with(['+', '-']));
    match count_digits(&rest[sign..]) {
        0 => 0,
        digits => 1 + sign + digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        let (tokens, diagnostics) = tokenize(text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        tokens.iter().map(|t| t.text).collect()
    }

    #[test]
    fn ranges_and_fractions_are_told_apart() {
        assert_eq!(texts("[0..3]"), ["[", "0", "..", "3", "]", ""]);
        assert_eq!(texts("0.5 .5 1e-3 007"), ["0.5", ".5", "1e-3", "007", ""]);
        assert_eq!(texts("x'=x<-1"), ["x", "=", "x", "<", "-", "1", ""]);
        assert_eq!(
            texts("a<=>b<=c // rest\n=>"),
            ["a", "<=>", "b", "<=", "c", "=>", ""]
        );
    }

    #[test]
    fn what_is_no_token_is_reported_and_skipped() {
        let (tokens, diagnostics) = tokenize("x @ y #for# \"a b\" é");
        assert_eq!(tokens.len(), 4);
        let codes: Vec<_> = diagnostics.iter().map(|d| (d.code, d.span.start)).collect();
        let invalid = "invalid-character";
        assert_eq!(
            codes,
            [
                (invalid, 2),
                (invalid, 6),
                ("not-a-name", 12),
                (invalid, 18)
            ]
        );
    }

    #[test]
    fn spans_cover_primes_and_quotes() {
        let text = "(x'=1) \"done\"";
        let (tokens, _) = tokenize(text);
        assert_eq!(tokens[1].span.of(text), "x'");
        assert_eq!(
            (tokens[5].kind, tokens[5].span.of(text)),
            (TokenKind::Quoted, "\"done\"")
        );
    }
}
