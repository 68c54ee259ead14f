//! Texts to units, by recursive descent.

use super::dimension::Dimension;
use super::factor::Factor;
use super::symbols::{has_offset, lookup, similar};
use super::{Unit, UnitError, UnitErrorKind};

/// The deepest nesting of brackets.
const MAX_NESTING: usize = 16;

/// What a text begins with.
#[derive(Debug)]
pub(crate) enum Prefix {
    /// A unit, and its length in bytes with the blanks before it.
    Unit(Unit, usize),
    /// A word that is no unit, and the place of it: start and end in bytes.
    Word(UnitErrorKind, usize, usize),
    /// Something else.
    Nothing,
}

/// The whole of `text` as a unit.
pub(super) fn whole(text: &str) -> Result<Unit, UnitError> {
    let mut scanner = Scanner::new(text, true);
    scanner.skip_blanks();
    let start = scanner.at;
    let unit = scanner.product()?;
    scanner.skip_blanks();
    if scanner.at == text.len()
        && let Some(mut unit) = unit
    {
        text.trim().clone_into(&mut unit.text);
        return Ok(unit);
    }
    Err(scanner.no_unit(start))
}

/// The longest unit that `text` begins with, after blanks. Operators belong to it as long as units
/// follow them: of `m / s / /a.x` the unit is `m / s`.
pub(crate) fn prefix(text: &str) -> Result<Prefix, UnitError> {
    let mut scanner = Scanner::new(text, false);
    scanner.skip_blanks();
    let start = scanner.at;
    if scanner.rest().starts_with('(') {
        return Ok(Prefix::Nothing);
    }
    if let Some(mut unit) = scanner.product()? {
        text[start..scanner.at].clone_into(&mut unit.text);
        return Ok(Prefix::Unit(unit, scanner.at));
    }
    scanner.at = start;
    match scanner.word() {
        Some((name, _)) => {
            let end = start + name.len();
            Ok(Prefix::Word(unknown(name), start, end))
        }
        None => Ok(Prefix::Nothing),
    }
}

fn unknown(name: &str) -> UnitErrorKind {
    let name = name.to_owned();
    if has_offset(&name) {
        return UnitErrorKind::Offset { name };
    }
    let similar = similar(&name);
    UnitErrorKind::Unknown { name, similar }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Separator {
    Times,
    Divide,
}

struct Scanner<'t> {
    text: &'t str,
    at: usize,
    nesting: usize,
    /// Whether nothing but a unit may stand in the text.
    whole: bool,
}

impl<'t> Scanner<'t> {
    fn new(text: &'t str, whole: bool) -> Self {
        Scanner {
            text,
            at: 0,
            nesting: 0,
            whole,
        }
    }

    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    fn skip_blanks(&mut self) {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start().len();
    }

    fn error(&self, from: usize, kind: UnitErrorKind) -> UnitError {
        UnitError::new(self.text, from..self.at.max(from), kind)
    }

    /// What is said of a text that is no unit, where scanning began at `start`.
    fn no_unit(&mut self, start: usize) -> UnitError {
        let _ = self.separator();
        self.skip_blanks();
        let at = self.at.max(start);
        self.at = at;
        match self.word() {
            Some((name, _)) if lookup(name).is_none() => {
                UnitError::new(self.text, at..at + name.len(), unknown(name))
            }
            _ => UnitError::new(self.text, at..self.text.len(), UnitErrorKind::Unexpected),
        }
    }

    /// Factors joined by products and quotients; `None`, and nothing taken, if there is no unit.
    fn product(&mut self) -> Result<Option<Unit>, UnitError> {
        let start = self.at;
        let Some(mut unit) = self.factor()? else {
            self.at = start;
            return Ok(None);
        };
        let mut divided = false;
        loop {
            let before = self.at;
            let Some(separator) = self.separator() else {
                self.at = before;
                return Ok(Some(unit));
            };
            let Some(next) = self.factor()? else {
                self.at = before;
                return Ok(Some(unit));
            };
            if divided && separator == Separator::Times {
                return Err(self.error(start, UnitErrorKind::Ambiguous));
            }
            divided |= separator == Separator::Divide;
            let joined = match separator {
                Separator::Times => unit.times(&next),
                Separator::Divide => unit.divided_by(&next),
            };
            unit = joined.ok_or_else(|| self.error(start, UnitErrorKind::TooLarge))?;
        }
    }

    /// What joins two factors, with the blanks around it; blanks alone are a product.
    fn separator(&mut self) -> Option<Separator> {
        let start = self.at;
        self.skip_blanks();
        let found = match self.rest().chars().next()? {
            '/' => Some((Separator::Divide, 1)),
            letter @ ('*' | '.' | '\u{b7}' | '\u{22c5}') => {
                Some((Separator::Times, letter.len_utf8()))
            }
            _ => None,
        };
        match found {
            Some((separator, length)) => {
                self.at += length;
                self.skip_blanks();
                Some(separator)
            }
            None => (self.at > start).then_some(Separator::Times),
        }
    }

    /// A symbol or a bracket, with its power.
    fn factor(&mut self) -> Result<Option<Unit>, UnitError> {
        let start = self.at;
        if self.rest().starts_with('(') {
            return self.bracket();
        }
        if self.whole && self.takes_one() {
            return Ok(Some(Unit::one()));
        }
        let Some((name, symbol)) = self.word() else {
            return Ok(None);
        };
        let (found, suffix) = match lookup(name) {
            Some(found) => (Some(found), None),
            // The powers of N/cm2 and m/s2.
            None => match name[symbol.len()..].parse::<i8>() {
                Ok(suffix @ 2..=9) => (lookup(symbol), Some(suffix)),
                _ => (None, None),
            },
        };
        let Some((dimension, factor)) = found else {
            return Ok(None);
        };
        self.at += name.len();
        // In a predicate, what is followed by a bracket is a function.
        if !self.whole && self.rest().trim_start().starts_with('(') {
            self.at = start;
            return Ok(None);
        }
        let exponent = suffix.unwrap_or_else(|| self.exponent());
        self.power(start, dimension, factor, exponent).map(Some)
    }

    fn bracket(&mut self) -> Result<Option<Unit>, UnitError> {
        let start = self.at;
        if self.nesting >= MAX_NESTING {
            // In a predicate it may be no unit at all.
            return if self.whole {
                Err(self.error(start, UnitErrorKind::TooLarge))
            } else {
                Ok(None)
            };
        }
        self.nesting += 1;
        self.at += 1;
        self.skip_blanks();
        let inner = self.product()?;
        self.nesting -= 1;
        self.skip_blanks();
        match inner {
            Some(inner) if self.rest().starts_with(')') => {
                self.at += 1;
                let exponent = self.exponent();
                self.power(start, inner.dimension, inner.factor, exponent)
                    .map(Some)
            }
            _ => Ok(None),
        }
    }

    fn power(
        &self,
        start: usize,
        dimension: Dimension,
        factor: Factor,
        exponent: i8,
    ) -> Result<Unit, UnitError> {
        let mut exponents = dimension.exponents();
        for base in &mut exponents {
            let raised = base.checked_mul(exponent);
            *base = raised.ok_or_else(|| self.error(start, UnitErrorKind::TooLarge))?;
        }
        let factor = factor.power(exponent);
        Ok(Unit {
            text: self.text[start..self.at].to_owned(),
            dimension: Dimension::from_exponents(exponents),
            factor: factor.ok_or_else(|| self.error(start, UnitErrorKind::TooLarge))?,
        })
    }

    /// Takes the number 1, as in `1/s`.
    fn takes_one(&mut self) -> bool {
        let mut letters = self.rest().chars();
        let alone = letters.next() == Some('1')
            && !letters
                .next()
                .is_some_and(|next| next.is_alphanumeric() || next == '.');
        self.at += usize::from(alone);
        alone
    }

    /// The word that stands here, and it without the digits at its end; nothing is taken.
    fn word(&self) -> Option<(&'t str, &'t str)> {
        let rest = self.rest();
        let first = rest.chars().next()?;
        if first == '%' {
            return Some((&rest[..1], &rest[..1]));
        }
        if !first.is_alphabetic() && first != '\u{b0}' {
            return None;
        }
        // Superscript digits are numeric, but belong to the exponent.
        let inside = |letter: char| {
            letter.is_alphabetic() || letter.is_ascii_digit() || matches!(letter, '\u{b0}' | '_')
        };
        let length = rest.find(|letter| !inside(letter)).unwrap_or(rest.len());
        let name = &rest[..length];
        Some((name, name.trim_end_matches(|it: char| it.is_ascii_digit())))
    }

    /// The power that is written here, `^2` or `²`; 1, and nothing taken, if there is none.
    fn exponent(&mut self) -> i8 {
        let rest = self.rest();
        if let Some(plain) = rest.strip_prefix('^') {
            let sign = usize::from(plain.starts_with(['-', '+']));
            let digits = plain[sign..].bytes().take_while(u8::is_ascii_digit).count();
            if let Ok(exponent) = plain[..sign + digits].parse() {
                self.at += 1 + sign + digits;
                return exponent;
            }
            return 1;
        }
        let plain = |letter| {
            let found = SUPERSCRIPTS.iter().find(|(raised, _)| *raised == letter);
            found.map(|(_, plain)| *plain)
        };
        let digits: String = rest.chars().map_while(plain).collect();
        match digits.parse() {
            Ok(exponent) => {
                let raised = rest.chars().take(digits.len());
                self.at += raised.map(char::len_utf8).sum::<usize>();
                exponent
            }
            Err(_) => 1,
        }
    }
}

const SUPERSCRIPTS: [(char, char); 12] = [
    ('\u{207b}', '-'),
    ('\u{207a}', '+'),
    ('\u{2070}', '0'),
    ('\u{b9}', '1'),
    ('\u{b2}', '2'),
    ('\u{b3}', '3'),
    ('\u{2074}', '4'),
    ('\u{2075}', '5'),
    ('\u{2076}', '6'),
    ('\u{2077}', '7'),
    ('\u{2078}', '8'),
    ('\u{2079}', '9'),
];
