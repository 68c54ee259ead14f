//! A sentence as tokens: connectives and punctuation, and everything else as words.
//!
//! A *word* is a run of letters that are neither white space, nor a connective, a parenthesis or a
//! comma: a name, a number, a comparison sign, a signal such as `/robot.hand_speed`. A text in
//! quotes belongs to its word whole. A full stop at the end of the sentence is dropped.

use crate::diagnostic::Span;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Word,
    Not,
    And,
    Or,
    Xor,
    Implies,
    Iff,
    Open,
    Close,
    Comma,
}

/// A token, its text and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token<'t> {
    pub(crate) kind: Kind,
    pub(crate) text: &'t str,
    pub(crate) span: Span,
}

impl Token<'_> {
    /// Whether this is the given word, whatever its case.
    pub(crate) fn is(&self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word)
    }

    /// Whether this is one of the given words.
    pub(crate) fn is_any(&self, words: &[&str]) -> bool {
        words.iter().any(|word| self.is(word))
    }
}

/// Signs with their kinds, longer ones first.
const SIGNS: [(&str, Kind); 14] = [
    ("<=>", Kind::Iff),
    ("<->", Kind::Iff),
    ("=>", Kind::Implies),
    ("->", Kind::Implies),
    ("&&", Kind::And),
    ("||", Kind::Or),
    ("!=", Kind::Word),
    ("&", Kind::And),
    ("|", Kind::Or),
    ("!", Kind::Not),
    ("~", Kind::Not),
    ("(", Kind::Open),
    (")", Kind::Close),
    (",", Kind::Comma),
];

/// The words that are connectives.
const WORDS: [(&str, Kind); 6] = [
    ("and", Kind::And),
    ("or", Kind::Or),
    ("not", Kind::Not),
    ("xor", Kind::Xor),
    ("implies", Kind::Implies),
    ("iff", Kind::Iff),
];

/// The tokens of `text`.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut start = 0;
    while let Some(next) = text[start..].chars().next() {
        if next.is_whitespace() {
            start += next.len_utf8();
            continue;
        }
        let (kind, length) = match sign(&text[start..]) {
            Some((sign, kind)) if kind != Kind::Word => (kind, sign.len()),
            _ => (Kind::Word, word_length(&text[start..])),
        };
        let end = start + length;
        tokens.push(token(text, kind, start, end));
        start = end;
    }
    drop_full_stop(&mut tokens);
    tokens
}

fn token(text: &str, kind: Kind, start: usize, end: usize) -> Token<'_> {
    let word = &text[start..end];
    let kind = match kind {
        Kind::Word => (WORDS.iter())
            .find(|(name, _)| word.eq_ignore_ascii_case(name))
            .map_or(Kind::Word, |(_, kind)| *kind),
        other => other,
    };
    Token {
        kind,
        text: word,
        span: Span::new(start, end),
    }
}

fn sign(text: &str) -> Option<(&'static str, Kind)> {
    (SIGNS.iter().copied()).find(|(sign, _)| text.starts_with(sign))
}

/// The length in bytes of the word at the start of `text`, at least one letter.
fn word_length(text: &str) -> usize {
    let mut length = 0;
    let mut before: Option<char> = None;
    while let Some(letter) = text[length..].chars().next() {
        let rest = &text[length..];
        if letter.is_whitespace() {
            break;
        }
        match sign(rest) {
            Some((_, kind)) if kind != Kind::Word && length > 0 => break,
            Some((sign, Kind::Word)) => {
                length += sign.len();
                before = sign.chars().last();
                continue;
            }
            _ => {}
        }
        // An apostrophe inside a word ("robot's") is a letter; elsewhere it opens a text in quotes.
        let opens =
            matches!(letter, '\'' | '"' | '`') && !before.is_some_and(char::is_alphanumeric);
        let closing = rest[letter.len_utf8()..].find(letter);
        length += match closing {
            Some(inner) if opens => inner + 2 * letter.len_utf8(),
            _ => letter.len_utf8(),
        };
        before = Some(letter);
    }
    length
}

fn drop_full_stop(tokens: &mut Vec<Token<'_>>) {
    let Some(last) = tokens.last_mut() else {
        return;
    };
    if last.kind == Kind::Word && last.text.ends_with('.') {
        last.text = &last.text[..last.text.len() - 1];
        last.span.end -= 1;
        if last.text.is_empty() {
            tokens.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        tokens(text).iter().map(|token| token.text).collect()
    }

    #[test]
    fn words_signs_and_quotes_are_told_apart() {
        assert_eq!(
            texts("when !a&&/robot.state != 'let go', the robot's hand"),
            [
                "when",
                "!",
                "a",
                "&&",
                "/robot.state",
                "!=",
                "'let go'",
                ",",
                "the",
                "robot's",
                "hand"
            ]
        );
        assert_eq!(texts("a<=>b => c"), ["a", "<=>", "b", "=>", "c"]);
        assert_eq!(texts("speed<=3"), ["speed<=3"]);
    }

    #[test]
    fn the_full_stop_is_dropped_but_no_decimal_point() {
        assert_eq!(texts("stop within 0.5 s."), ["stop", "within", "0.5", "s"]);
        assert_eq!(texts("satisfy x ."), ["satisfy", "x"]);
    }

    #[test]
    fn connectives_may_be_words() {
        let kinds: Vec<Kind> = tokens("a AND NOT b").iter().map(|t| t.kind).collect();
        assert_eq!(kinds, [Kind::Word, Kind::And, Kind::Not, Kind::Word]);
    }
}
