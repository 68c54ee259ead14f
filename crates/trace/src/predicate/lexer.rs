//! Text to words of the predicate language.
//!
//! The slash has two meanings. After an operand it divides; elsewhere it begins a signal. Within a
//! signal further slashes belong to it before its first dot, if a letter, digit or underscore
//! follows: `/arm/left.x/2` is the signal `/arm/left.x` divided by 2.
//!
//! A unit may follow a number. It extends over `*` and `/` as long as units follow them, even if
//! an entry of the vocabulary has the same name as a unit.

use std::ops::Range;

use super::error::PredicateErrorKind;
use crate::units::{Decimal, Prefix, QuantityValue, prefix};

/// One word of the language.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Token {
    Number(Box<QuantityValue>),
    Text(String),
    Signal(String),
    Name(String),
    /// An operator or bracket, in its first spelling.
    Symbol(&'static str),
    End,
}

impl Token {
    fn is_operand(&self) -> bool {
        !matches!(self, Token::Symbol(symbol) if *symbol != ")")
    }
}

/// Spellings of operators, longer ones first, with the spelling used from here on.
const SYMBOLS: [(&str, &str); 20] = [
    ("==", "="),
    ("=>", "=>"),
    ("!=", "!="),
    ("<=", "<="),
    (">=", ">="),
    ("&&", "&"),
    ("||", "|"),
    ("=", "="),
    ("!", "!"),
    ("<", "<"),
    (">", ">"),
    ("&", "&"),
    ("|", "|"),
    ("+", "+"),
    ("-", "-"),
    ("*", "*"),
    ("/", "/"),
    ("(", "("),
    (")", ")"),
    (",", ","),
];

/// Words that are operators.
const WORDS: [(&str, &str); 3] = [("and", "&"), ("or", "|"), ("not", "!")];

type LexError = (PredicateErrorKind, Range<usize>);

/// Splits `text` into words with their places; the last one is [`Token::End`].
pub(crate) fn lex(text: &str) -> Result<Vec<(Token, Range<usize>)>, LexError> {
    let mut tokens: Vec<(Token, Range<usize>)> = Vec::new();
    let mut at = 0;
    while let Some(letter) = text[at..].chars().next() {
        if letter.is_whitespace() {
            at += letter.len_utf8();
            continue;
        }
        let after_operand = tokens.last().is_some_and(|(token, _)| token.is_operand());
        let (token, length) = lex_one(&text[at..], letter, after_operand)
            .map_err(|(kind, length)| (kind, at..at + length))?;
        tokens.push((token, at..at + length));
        at += length;
    }
    tokens.push((Token::End, at..at));
    Ok(tokens)
}

/// The first word of `rest`, which begins with `first`, and its length in bytes.
fn lex_one(
    rest: &str,
    first: char,
    after_operand: bool,
) -> Result<(Token, usize), (PredicateErrorKind, usize)> {
    if matches!(first, '\'' | '"' | '`') {
        return lex_quoted(rest, first);
    }
    if first == '/' && !after_operand && rest[1..].starts_with(is_word) {
        let length = signal_length(rest);
        return Ok((Token::Signal(rest[..length].to_owned()), length));
    }
    if first.is_ascii_digit() {
        return lex_number(rest);
    }
    if is_word(first) {
        let length = rest.find(|letter| !is_word(letter)).unwrap_or(rest.len());
        let word = &rest[..length];
        let operator = WORDS.iter().find(|(spelling, _)| *spelling == word);
        let token = match operator {
            Some((_, symbol)) => Token::Symbol(symbol),
            None => Token::Name(word.to_owned()),
        };
        return Ok((token, length));
    }
    match SYMBOLS
        .iter()
        .find(|(spelling, _)| rest.starts_with(spelling))
    {
        Some((spelling, symbol)) => Ok((Token::Symbol(symbol), spelling.len())),
        None => Err((
            PredicateErrorKind::Unexpected {
                found: format!("'{first}'"),
                expected: "a number, a signal, a name or an operator",
            },
            first.len_utf8(),
        )),
    }
}

fn is_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// The length of the signal that `rest` begins with.
fn signal_length(rest: &str) -> usize {
    let mut dotted = false;
    let mut letters = rest.char_indices().skip(1).peekable();
    while let Some((at, letter)) = letters.next() {
        let continues = letters.peek().is_some_and(|&(_, next)| is_word(next));
        match letter {
            '.' if continues => dotted = true,
            '/' if continues && !dotted => {}
            _ if is_word(letter) => {}
            _ => return at,
        }
    }
    rest.len()
}

fn lex_quoted(rest: &str, quote: char) -> Result<(Token, usize), (PredicateErrorKind, usize)> {
    let Some(length) = rest[1..].find(quote) else {
        return Err((PredicateErrorKind::Unterminated, rest.len()));
    };
    let inner = rest[1..=length].to_owned();
    let token = if quote == '`' {
        Token::Signal(inner)
    } else {
        Token::Text(inner)
    };
    Ok((token, length + 2))
}

/// A number and the unit behind it, if there is one.
fn lex_number(rest: &str) -> Result<(Token, usize), (PredicateErrorKind, usize)> {
    let end = Decimal::length(rest);
    let malformed = || {
        let tail = rest[end..].find(|letter| !is_word(letter) && letter != '.');
        let whole = end + tail.unwrap_or(rest.len() - end);
        let kind = PredicateErrorKind::Unexpected {
            found: format!("\"{}\"", &rest[..whole]),
            expected: "a finite number, possibly with a unit,",
        };
        (kind, whole)
    };
    // A dot right behind, as in 1.2.3, is a mistake and not the next word.
    let number = Decimal::parse(&rest[..end]).filter(|_| !rest[end..].starts_with('.'));
    let number = number.ok_or_else(malformed)?;
    let unit = prefix(&rest[end..]);
    let unit =
        unit.map_err(|error| (PredicateErrorKind::Unit(error.kind), end + error.span.end))?;
    let (unit, length) = match unit {
        Prefix::Unit(unit, length) => (Some(unit), length),
        // Behind a blank there may be a word like "and".
        Prefix::Word(_, from, to) if from > 0 && is_operator(&rest[end + from..end + to]) => {
            (None, 0)
        }
        Prefix::Word(kind, _, to) => return Err((PredicateErrorKind::Unit(kind), end + to)),
        Prefix::Nothing => (None, 0),
    };
    let value = QuantityValue::new(number, unit);
    Ok((Token::Number(Box::new(value)), end + length))
}

fn is_operator(word: &str) -> bool {
    WORDS.iter().any(|(spelling, _)| *spelling == word)
}
