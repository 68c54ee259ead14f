//! FRET's expressions and formulas, to one tree.
//!
//! # Definition
//! From weak to strong: `->`, `=>`, `<->`, `<=>` (to the left); `|`, `xor`; `&`; `U`, `V`, `S`, `T`; `!`, `~` and the temporal
//! prefixes; comparisons; `+`, `-`; `*`, `/`, `mod`; `-`; `^`. `if a then b` is `a -> b` and takes all behind it.
//!
//! # Source
//! The grammars that come with FRET 3 (`Requirement.g4` of sentences, `LTL.g4` and `NuSMV.g4` of formulas) and its manual's
//! pages on the semantics of its operators.
//!
//! # Deviation
//! A single letter is an operator only where an operator can stand, since variables have such names, too. `at the previous
//! occurrence of` and its like are not read.

use std::fmt;

/// How deeply expressions may be nested, so that no text can exhaust the stack.
const MAX_DEPTH: usize = 200;
/// The longest text: a chain of operators makes a tree as deep as it is long.
const MAX_TOKENS: usize = 4_000;

/// A bound of a temporal operator, both ends included.
pub(crate) type Bound = Option<(u32, u32)>;

/// An expression or formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expr {
    True,
    False,
    Name(String),
    Number(String),
    /// A function with its arguments.
    Call(String, Vec<Expr>),
    /// Arithmetic and comparisons.
    Operation(&'static str, Box<Expr>, Box<Expr>),
    Minus(Box<Expr>),
    Not(Box<Expr>),
    And(Box<Expr>, Box<Expr>),
    Or(Box<Expr>, Box<Expr>),
    Xor(Box<Expr>, Box<Expr>),
    Implies(Box<Expr>, Box<Expr>),
    Iff(Box<Expr>, Box<Expr>),
    /// `X F G Y Z O H`.
    Prefix(char, Bound, Box<Expr>),
    /// `U V S T`.
    Infix(char, Bound, Box<Expr>, Box<Expr>),
    /// `LAST` or `FTP`.
    Point(&'static str),
    /// `P>=p[...]`: comparison, number, formula.
    Probability(String, String, Box<Expr>),
}

/// The text without spaces, with all parentheses: equal texts are equal expressions.
impl fmt::Display for Expr {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::True => out.write_str("true"),
            Self::False => out.write_str("false"),
            Self::Name(name) | Self::Number(name) => out.write_str(name),
            Self::Call(name, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(Self::to_string).collect();
                write!(out, "{name}({})", arguments.join(","))
            }
            Self::Operation(sign, left, right) => write!(out, "({left}{sign}{right})"),
            Self::Minus(inner) => write!(out, "-{inner}"),
            Self::Not(inner) => write!(out, "!{inner}"),
            Self::And(left, right) => write!(out, "({left}&{right})"),
            Self::Or(left, right) => write!(out, "({left}|{right})"),
            Self::Xor(left, right) => write!(out, "({left} xor {right})"),
            Self::Implies(left, right) => write!(out, "({left}->{right})"),
            Self::Iff(left, right) => write!(out, "({left}<->{right})"),
            Self::Prefix(sign, bound, inner) => write!(out, "({sign}{} {inner})", shown(*bound)),
            Self::Infix(sign, bound, left, right) => {
                write!(out, "({left} {sign}{} {right})", shown(*bound))
            }
            Self::Point(name) => out.write_str(name),
            Self::Probability(sign, number, inner) => write!(out, "P{sign}{number}[{inner}]"),
        }
    }
}

fn shown(bound: Bound) -> String {
    bound.map_or(String::new(), |(from, to)| format!("[{from},{to}]"))
}

/// A token with its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Token {
    pub(crate) text: String,
    pub(crate) start: usize,
    pub(crate) end: usize,
    /// Whether it is a name or keyword.
    pub(crate) is_word: bool,
    is_number: bool,
}

impl Token {
    /// Whether it is this word, in any case.
    pub(crate) fn is(&self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word)
    }
}

/// The signs, longer ones first.
const SIGNS: [&str; 27] = [
    "<=>", "<->", "=>", "->", "<=", ">=", "!=", "&&", "||", "<", ">", "=", "!", "~", "&", "|", "(",
    ")", "[", "]", ",", "+", "-", "*", "/", "^", ".",
];

/// The tokens of a text, or what is wrong with it.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(letter) = text[at..].chars().next() {
        if letter.is_whitespace() {
            at += letter.len_utf8();
            continue;
        }
        if found.len() >= MAX_TOKENS {
            return Err(format!("it has more than {MAX_TOKENS} words and signs"));
        }
        let (length, is_word, is_number) = token_at(&text[at..])?;
        let whole = &text[at..at + length];
        let quoted = whole.len() >= 2 && whole.starts_with('"');
        let inner = if quoted {
            &whole[1..whole.len() - 1]
        } else {
            whole
        };
        found.push(Token {
            text: inner.to_owned(),
            start: at,
            end: at + length,
            is_word,
            is_number,
        });
        at += length;
    }
    Ok(found)
}

fn token_at(rest: &str) -> Result<(usize, bool, bool), String> {
    let first = rest.chars().next().unwrap_or(' ');
    if first == '"' {
        let end = rest[1..].find('"').ok_or("a text in quotes has no end")?;
        return Ok((end + 2, true, false));
    }
    if first.is_ascii_digit() {
        return Ok((number_length(rest), false, true));
    }
    if first.is_alphabetic() || first == '_' || first == '$' {
        let is_part = |letter: char| letter.is_alphanumeric() || "_.%$".contains(letter);
        let end = rest.find(|letter| !is_part(letter)).unwrap_or(rest.len());
        // A full stop ends a sentence.
        let word = rest[..end].trim_end_matches('.');
        return Ok((word.len(), true, false));
    }
    let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
    match sign {
        Some(sign) => Ok((sign.len(), false, false)),
        None => Err(format!("`{first}` has no meaning in FRET's language")),
    }
}

fn number_length(rest: &str) -> usize {
    let digits = |from: usize| {
        let bytes = rest.as_bytes()[from..].iter();
        from + bytes.take_while(|byte| byte.is_ascii_digit()).count()
    };
    let mut end = digits(0);
    if rest[end..].starts_with('.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    if rest[end..].starts_with(['e', 'E']) {
        let sign = usize::from(rest[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    end
}

/// Reads a formula whole.
pub(crate) fn formula(text: &str) -> Result<Expr, String> {
    let tokens = tokens(text)?;
    let mut reader = Reader::new(&tokens, true);
    let read = reader.expression()?;
    match reader.peek() {
        None => Ok(read),
        Some(token) => Err(format!("`{}` is not expected there", token.text)),
    }
}

/// Reads an expression whole, in which single letters are names.
pub(crate) fn expression(text: &str) -> Result<Expr, String> {
    let tokens = tokens(text)?;
    let mut reader = Reader::new(&tokens, false);
    let read = reader.expression()?;
    match reader.peek() {
        None => Ok(read),
        Some(token) => Err(format!("`{}` is not expected there", token.text)),
    }
}

/// Reads expressions from tokens.
pub(crate) struct Reader<'t> {
    tokens: &'t [Token],
    pub(crate) next: usize,
    is_temporal: bool,
    depth: usize,
}

/// How strongly what stands between two operands binds: sign, strength.
const WEAKEST: u8 = 1;
const OR: u8 = 2;
const AND: u8 = 3;
const TEMPORAL: u8 = 4;
const PREFIX: u8 = 5;
const COMPARISON: u8 = 6;
const SUM: u8 = 7;
const PRODUCT: u8 = 8;
const MINUS: u8 = 9;
const POWER: u8 = 10;

impl<'t> Reader<'t> {
    pub(crate) fn new(tokens: &'t [Token], is_temporal: bool) -> Self {
        Self {
            tokens,
            next: 0,
            is_temporal,
            depth: 0,
        }
    }

    pub(crate) fn peek(&self) -> Option<&'t Token> {
        self.tokens.get(self.next)
    }

    /// The token so many behind the next.
    pub(crate) fn ahead(&self, by: usize) -> Option<&'t Token> {
        self.tokens.get(self.next + by)
    }

    fn peek_is(&self, sign: &str) -> bool {
        self.peek()
            .is_some_and(|token| token.text == sign && !token.is_word)
    }

    fn take_sign(&mut self, sign: &str) -> bool {
        let found = self.peek_is(sign);
        self.next += usize::from(found);
        found
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        match self.take_sign(sign) {
            true => Ok(()),
            false => Err(match self.peek() {
                Some(token) => format!("`{sign}` is expected before `{}`", token.text),
                None => format!("`{sign}` is missing at the end"),
            }),
        }
    }

    /// An expression, as far as it goes.
    pub(crate) fn expression(&mut self) -> Result<Expr, String> {
        self.stronger(WEAKEST)
    }

    fn stronger(&mut self, least: u8) -> Result<Expr, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("it is nested more than {MAX_DEPTH} deep"));
        }
        let mut left = self.operand()?;
        while let Some((sign, strength)) = self.between().filter(|(_, it)| *it >= least) {
            self.next += 1;
            let bound = match sign.len() == 1 && "UVST".contains(sign) {
                true => self.bound()?,
                false => None,
            };
            // All bind to the left.
            let right = self.stronger(strength + 1)?;
            left = joined(sign, bound, left, right);
        }
        self.depth -= 1;
        Ok(left)
    }

    /// What stands between two operands, and how strongly it binds.
    fn between(&self) -> Option<(&'static str, u8)> {
        let token = self.peek()?;
        if token.is_word {
            return match token.text.as_str() {
                "U" if self.is_temporal => Some(("U", TEMPORAL)),
                "V" | "R" if self.is_temporal => Some(("V", TEMPORAL)),
                "S" if self.is_temporal => Some(("S", TEMPORAL)),
                "T" if self.is_temporal => Some(("T", TEMPORAL)),
                _ if token.is("xor") => Some(("xor", OR)),
                _ if token.is("mod") => Some((" mod ", PRODUCT)),
                _ => None,
            };
        }
        Some(match token.text.as_str() {
            "->" | "=>" => ("->", WEAKEST),
            "<->" | "<=>" => ("<->", WEAKEST),
            "|" | "||" => ("|", OR),
            "&" | "&&" => ("&", AND),
            "=" => ("=", COMPARISON),
            "!=" => ("!=", COMPARISON),
            "<" => ("<", COMPARISON),
            "<=" => ("<=", COMPARISON),
            ">" => (">", COMPARISON),
            ">=" => (">=", COMPARISON),
            "+" => ("+", SUM),
            "-" => ("-", SUM),
            "*" => ("*", PRODUCT),
            "/" => ("/", PRODUCT),
            "^" => ("^", POWER),
            _ => return None,
        })
    }

    fn operand(&mut self) -> Result<Expr, String> {
        let Some(token) = self.peek() else {
            return Err("an expression is missing at the end".into());
        };
        self.next += 1;
        if token.is_number {
            return Ok(Expr::Number(token.text.clone()));
        }
        if token.is_word {
            return self.word(token);
        }
        match token.text.as_str() {
            "(" => {
                let inner = self.expression()?;
                self.expect(")")?;
                Ok(inner)
            }
            "!" | "~" => Ok(Expr::Not(Box::new(self.stronger(PREFIX)?))),
            "-" => Ok(Expr::Minus(Box::new(self.stronger(MINUS)?))),
            other => Err(format!("an expression is expected before `{other}`")),
        }
    }

    fn word(&mut self, token: &Token) -> Result<Expr, String> {
        if token.is("true") {
            return Ok(Expr::True);
        }
        if token.is("false") {
            return Ok(Expr::False);
        }
        if token.is("if") {
            let when = self.expression()?;
            match self.peek() {
                Some(then) if then.is("then") => self.next += 1,
                _ => return Err("`then` is missing behind `if`".into()),
            }
            let then = self.expression()?;
            return Ok(Expr::Implies(Box::new(when), Box::new(then)));
        }
        if token.is("at") {
            return Err("`at the ... occurrence of` has no counterpart here".into());
        }
        if token.text == "FTP" {
            return Ok(Expr::Point("FTP"));
        }
        if self.is_temporal
            && let Some(read) = self.temporal(token)?
        {
            return Ok(read);
        }
        match self.take_sign("(") {
            true => self.call(token),
            false => Ok(Expr::Name(token.text.clone())),
        }
    }

    /// A temporal operator, if the word is one where it stands.
    fn temporal(&mut self, token: &Token) -> Result<Option<Expr>, String> {
        let next = self.peek();
        let before_operand = next.is_some_and(|next| {
            (next.is_word && !matches!(next.text.as_str(), "U" | "V" | "S" | "T" | "xor"))
                || next.is_number
                || matches!(next.text.as_str(), "(" | "[" | "!" | "<" | "<=")
        });
        match token.text.as_str() {
            "LAST" => Ok(Some(Expr::Point("LAST"))),
            "P" if next.is_some_and(compares) => self.probability(),
            "X" | "F" | "G" | "Y" | "Z" | "O" | "H" if before_operand => {
                let before = (self.next, self.depth);
                let sign = token.text.chars().next().unwrap_or('X');
                let is_compared = !self.peek_is("[");
                let read = self.bound().and_then(|bound| {
                    let inner = self.stronger(PREFIX)?;
                    Ok(Expr::Prefix(sign, bound, Box::new(inner)))
                });
                match read {
                    Ok(read) => Ok(Some(read)),
                    // `F <= 3` compares a variable.
                    Err(_) if is_compared => {
                        (self.next, self.depth) = before;
                        Ok(None)
                    }
                    Err(reason) => Err(reason),
                }
            }
            _ => Ok(None),
        }
    }

    fn probability(&mut self) -> Result<Option<Expr>, String> {
        let mut sign = String::new();
        while let Some(token) = self.peek().filter(|token| compares(token)) {
            sign.push_str(&token.text);
            self.next += 1;
        }
        let number = match self.peek() {
            Some(token) if token.is_number => token.text.clone(),
            _ => return Err("`P` needs a probability".into()),
        };
        self.next += 1;
        self.expect("[")?;
        let inner = self.expression()?;
        self.expect("]")?;
        Ok(Some(Expr::Probability(sign, number, Box::new(inner))))
    }

    /// `[a,b]`, `[<=b]`, `[<b]`, `[=b]` or `<=b`; `None` without one.
    fn bound(&mut self) -> Result<Bound, String> {
        let in_brackets = self.take_sign("[");
        let compared = ["<=", "<", "="].into_iter().find(|sign| self.peek_is(sign));
        if !in_brackets && compared.is_none() {
            return Ok(None);
        }
        self.next += usize::from(compared.is_some());
        let first = self.whole_number()?;
        let bound = match compared {
            Some("<=") => (0, first),
            Some("<") if first == 0 => return Err("a bound is empty".into()),
            Some("<") => (0, first - 1),
            Some(_) => (first, first),
            None => {
                self.expect(",")?;
                (first, self.whole_number()?)
            }
        };
        if in_brackets {
            self.expect("]")?;
        }
        match bound.0 <= bound.1 {
            true => Ok(Some(bound)),
            false => Err("a bound is empty".into()),
        }
    }

    /// A sum of whole numbers, as `10+1`.
    fn whole_number(&mut self) -> Result<u32, String> {
        let mut sum: u32 = 0;
        loop {
            let number = self.peek().and_then(|token| token.text.parse::<u32>().ok());
            let number = number.ok_or("a bound is not a whole number")?;
            self.next += 1;
            sum = sum.checked_add(number).ok_or("a bound is too large")?;
            if !self.take_sign("+") {
                return Ok(sum);
            }
        }
    }

    fn call(&mut self, name: &Token) -> Result<Expr, String> {
        let mut arguments = Vec::new();
        if !self.take_sign(")") {
            loop {
                arguments.push(self.expression()?);
                if !self.take_sign(",") {
                    break;
                }
            }
            self.expect(")")?;
        }
        Ok(Expr::Call(name.text.clone(), arguments))
    }
}

fn compares(token: &Token) -> bool {
    !token.is_word && token.text.starts_with(['<', '>', '='])
}

fn joined(sign: &'static str, bound: Bound, left: Expr, right: Expr) -> Expr {
    let (left, right) = (Box::new(left), Box::new(right));
    match sign {
        "->" => Expr::Implies(left, right),
        "<->" => Expr::Iff(left, right),
        "|" => Expr::Or(left, right),
        "xor" => Expr::Xor(left, right),
        "&" => Expr::And(left, right),
        "U" => Expr::Infix('U', bound, left, right),
        "V" => Expr::Infix('V', bound, left, right),
        "S" => Expr::Infix('S', bound, left, right),
        "T" => Expr::Infix('T', bound, left, right),
        other => Expr::Operation(other, left, right),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown_as(text: &str) -> String {
        formula(text).map_or_else(|error| error, |read| read.to_string())
    }

    #[test]
    fn operators_bind_as_in_fret() {
        for (text, expected) in [
            ("a -> b -> c", "((a->b)->c)"),
            ("! a = b & c", "(!(a=b)&c)"),
            ("a | b xor c", "((a|b) xor c)"),
            ("x - y*2 <= -3.0 => z", "(((x-(y*2))<=-3.0)->z)"),
            ("if a then b | c", "(a->(b|c))"),
            ("(LAST V (p -> (X q)))", "(LAST V (p->(X q)))"),
            ("(G[0,200] p) | (O[<=3] q)", "((G[0,200] p)|(O[0,3] q))"),
            ("(H[<3] p)", "(H[0,2] p)"),
            ("T * mag(x) <= T", "((T*mag(x))<=T)"),
            ("F <= 3", "(F<=3)"),
            ("P>=1[(G p)]", "P>=1[(G p)]"),
            ("(P>=1[(F<=6 (a = b))])", "P>=1[(F[0,6] (a=b))]"),
            ("(a S b) & (Z FALSE)", "((a S b)&(Z false))"),
        ] {
            assert_eq!(shown_as(text), expected, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_said_and_ends() {
        for bad in [
            "",
            "a b",
            "(a",
            "a & ",
            "f(x",
            "F[2,1] a",
            "F[99999999999,1] a",
            "é ¬ x",
        ] {
            assert!(formula(bad).is_err(), "{bad}");
        }
        assert!(formula(&"(".repeat(100_000)).is_err());
        assert!(formula(&"!".repeat(100_000)).is_err());
        assert!(formula(&"a & ".repeat(100_000)).is_err());
    }
}
