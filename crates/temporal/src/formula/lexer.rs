//! Text to words, as far as a formula must tell them apart.
//!
//! Atoms are not understood here. It is enough to see where they end: at an operator of logic or
//! time, or at a closing bracket that they did not open. What is quoted and what belongs to the
//! name of a signal (`/robot.until`) is one word, so that no operator is seen within.

use std::ops::Range;

use super::parser::FormulaError;

/// A word and its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Token<'t> {
    pub(super) kind: Kind,
    pub(super) text: &'t str,
    pub(super) span: Range<usize>,
}

/// What a word is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// An operator of logic or time.
    Operator(Operator),
    /// A name, signal or quoted text.
    Word,
    Number,
    /// An operator of arithmetic or comparison: it joins what stands on both sides to one atom.
    Joint,
    Open,
    Close,
    OpenSquare,
    CloseSquare,
    Comma,
    End,
}

/// Operators of logic and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Not,
    And,
    Or,
    Implies,
    Iff,
    Next,
    Previous,
    Eventually,
    Always,
    Once,
    Historically,
    Until,
    WeakUntil,
    Release,
    Since,
    Rise,
    Fall,
}

/// The spellings of the operators that are words.
pub(super) const WORDS: [(&str, Operator); 29] = [
    ("not", Operator::Not),
    ("and", Operator::And),
    ("or", Operator::Or),
    ("implies", Operator::Implies),
    ("iff", Operator::Iff),
    ("next", Operator::Next),
    ("X", Operator::Next),
    ("previous", Operator::Previous),
    ("Y", Operator::Previous),
    ("eventually", Operator::Eventually),
    ("F", Operator::Eventually),
    ("always", Operator::Always),
    ("globally", Operator::Always),
    ("G", Operator::Always),
    ("once", Operator::Once),
    ("O", Operator::Once),
    ("historically", Operator::Historically),
    ("H", Operator::Historically),
    ("until", Operator::Until),
    ("U", Operator::Until),
    ("weak_until", Operator::WeakUntil),
    ("W", Operator::WeakUntil),
    ("release", Operator::Release),
    ("releases", Operator::Release),
    ("R", Operator::Release),
    ("since", Operator::Since),
    ("S", Operator::Since),
    ("rise", Operator::Rise),
    ("fall", Operator::Fall),
];

/// Signs, the longer ones first.
const SIGNS: [(&str, Kind); 27] = [
    ("<=>", Kind::Operator(Operator::Iff)),
    ("<->", Kind::Operator(Operator::Iff)),
    ("=>", Kind::Operator(Operator::Implies)),
    ("->", Kind::Operator(Operator::Implies)),
    ("&&", Kind::Operator(Operator::And)),
    ("||", Kind::Operator(Operator::Or)),
    ("==", Kind::Joint),
    ("!=", Kind::Joint),
    ("<=", Kind::Joint),
    (">=", Kind::Joint),
    ("&", Kind::Operator(Operator::And)),
    ("|", Kind::Operator(Operator::Or)),
    ("!", Kind::Operator(Operator::Not)),
    ("=", Kind::Joint),
    ("<", Kind::Joint),
    (">", Kind::Joint),
    ("+", Kind::Joint),
    ("-", Kind::Joint),
    ("*", Kind::Joint),
    ("/", Kind::Joint),
    ("^", Kind::Joint),
    ("%", Kind::Word),
    ("(", Kind::Open),
    (")", Kind::Close),
    ("[", Kind::OpenSquare),
    ("]", Kind::CloseSquare),
    (",", Kind::Comma),
];

/// Where the last word stands in relation to the interval of an operator. Behind one a slash begins
/// a signal, and does not divide.
#[derive(Clone, Copy, PartialEq)]
enum Interval {
    None,
    Open,
    Closed,
}

/// Splits `text` into words; the last one is [`Kind::End`].
pub(super) fn lex(text: &str) -> Result<Vec<Token<'_>>, FormulaError> {
    let mut tokens: Vec<Token<'_>> = Vec::new();
    let mut interval = Interval::None;
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        }
        let after_operand = interval != Interval::Closed
            && (tokens.last()).is_some_and(|token| {
                matches!(
                    token.kind,
                    Kind::Word | Kind::Number | Kind::Close | Kind::CloseSquare
                )
            });
        let (kind, length) = lex_one(text, at, first, after_operand)?;
        let after_operator =
            (tokens.last()).is_some_and(|token| matches!(token.kind, Kind::Operator(_)));
        interval = match (kind, interval) {
            (Kind::OpenSquare, _) if after_operator => Interval::Open,
            (Kind::CloseSquare | Kind::Close, Interval::Open) => Interval::Closed,
            (_, Interval::Open) => Interval::Open,
            _ => Interval::None,
        };
        let span = at..at + length;
        tokens.push(Token {
            kind,
            text: &text[span.clone()],
            span,
        });
        at += length;
    }
    tokens.push(Token {
        kind: Kind::End,
        text: "",
        span: at..at,
    });
    Ok(tokens)
}

/// The kind and length of the word at `at`, which begins with `first`.
fn lex_one(
    text: &str,
    at: usize,
    first: char,
    after_operand: bool,
) -> Result<(Kind, usize), FormulaError> {
    let rest = &text[at..];
    if matches!(first, '\'' | '"' | '`') {
        return match rest[1..].find(first) {
            Some(length) => Ok((Kind::Word, length + 2)),
            None => Err(FormulaError::new(
                text,
                at..text.len(),
                format!("the quotation that begins with {first} does not end"),
                format!("close it with {first}"),
            )),
        };
    }
    let begins_signal = first == '/' && !after_operand && rest[1..].starts_with(is_letter);
    if begins_signal || is_letter(first) && !first.is_ascii_digit() {
        let length = name_length(rest);
        let operator = WORDS
            .iter()
            .find(|(spelling, _)| *spelling == &rest[..length]);
        return Ok((
            operator.map_or(Kind::Word, |(_, operator)| Kind::Operator(*operator)),
            length,
        ));
    }
    if first.is_ascii_digit() {
        return Ok((Kind::Number, number_length(rest)));
    }
    match SIGNS.iter().find(|(sign, _)| rest.starts_with(sign)) {
        Some((sign, kind)) => Ok((*kind, sign.len())),
        None => Err(FormulaError::new(
            text,
            at..at + first.len_utf8(),
            format!("'{first}' means nothing here"),
            match first {
                // As RTAMT and others write it.
                ':' => "write an interval with a comma and units, such as [0, 5 samples] or [0, 500 ms]".to_owned(),
                _ => "use operators such as \"and\", \"until\" and \"<\", and put unusual names in backquotes".to_owned(),
            },
        )),
    }
}

fn is_letter(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// The length of the name or signal at the beginning of `rest`: slashes belong to a signal before
/// its first dot, dots to both, where a letter follows.
fn name_length(rest: &str) -> usize {
    let signal = rest.starts_with('/');
    let mut dotted = false;
    let mut letters = rest.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        let continues = letters.peek().is_some_and(|&(_, next)| is_letter(next));
        match letter {
            '.' if continues => dotted = true,
            '/' if continues && signal && !dotted => {}
            _ if is_letter(letter) => {}
            _ => return at,
        }
    }
    rest.len()
}

/// The length of the number at the beginning of `rest`. A letter behind it begins the next word,
/// as in `5s`, unless it is an exponent.
fn number_length(rest: &str) -> usize {
    let bytes = rest.as_bytes();
    let digits = |from: usize| {
        from + bytes[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count()
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if digits(end + 1 + sign) > end + 1 + sign {
            end = digits(end + 1 + sign);
        }
    }
    end
}
