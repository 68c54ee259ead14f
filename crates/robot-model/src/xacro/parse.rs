//! Expressions in Python's grammar, as far as one that gives a value needs it: no statements, no assignments, no lambdas.

use super::value::Value;

/// Parentheses and operators inside one another.
const MAX_DEPTH: usize = 60;

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expr {
    Value(Value),
    Name(String),
    List(Vec<Expr>),
    Tuple(Vec<Expr>),
    Dict(Vec<(Expr, Expr)>),
    /// The element, the names, what is gone through, the conditions.
    Comprehension(Box<Expr>, Vec<String>, Box<Expr>, Vec<Expr>),
    Unary(&'static str, Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    /// Comparisons in a chain.
    Compare(Box<Expr>, Vec<(&'static str, Expr)>),
    And(Box<Expr>, Box<Expr>),
    Or(Box<Expr>, Box<Expr>),
    /// The condition, what it is if that holds, and otherwise.
    If(Box<[Expr; 3]>),
    Call(Box<Expr>, Vec<Expr>, Vec<(String, Expr)>),
    Index(Box<Expr>, Box<Expr>),
    Slice(Box<Expr>, Box<[Option<Expr>; 3]>),
    Attribute(Box<Expr>, String),
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Value(Value),
    Name(String),
    Sign(&'static str),
}

/// Longer ones first.
const SIGNS: [&str; 29] = [
    "**", "//", "<<", ">>", "<=", ">=", "==", "!=", "(", ")", "[", "]", "{", "}", ",", ":", ".",
    "+", "-", "*", "/", "%", "<", ">", "&", "|", "^", "~", "=",
];

const WORDS: [&str; 8] = ["and", "or", "not", "in", "is", "if", "else", "for"];

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else {
            return Ok(tokens);
        };
        let is_number = first.is_ascii_digit()
            || (first == '.' && rest[1..].starts_with(|it: char| it.is_ascii_digit()));
        if is_number {
            let (value, length) = numeral(rest)?;
            tokens.push(Token::Value(value));
            rest = &rest[length..];
        } else if first == '"' || first == '\'' {
            let (text, length) = string(rest, false)?;
            tokens.push(Token::Value(Value::text(text)));
            rest = &rest[length..];
        } else if first.is_alphabetic() || first == '_' {
            let is_part = |it: char| it.is_alphanumeric() || it == '_';
            let length = rest.find(|it| !is_part(it)).unwrap_or(rest.len());
            let (name, behind) = rest.split_at(length);
            if matches!(name, "r" | "u" | "R" | "U") && behind.starts_with(['"', '\'']) {
                let (text, length) = string(behind, name.eq_ignore_ascii_case("r"))?;
                tokens.push(Token::Value(Value::text(text)));
                rest = &behind[length..];
                continue;
            }
            let word = WORDS.iter().find(|it| **it == name);
            tokens.push(word.map_or_else(|| Token::Name(name.to_owned()), |it| Token::Sign(it)));
            rest = behind;
        } else {
            let sign = SIGNS.iter().find(|it| rest.starts_with(**it));
            let sign = sign.ok_or_else(|| format!("`{first}` has no meaning in an expression"))?;
            tokens.push(Token::Sign(sign));
            rest = &rest[sign.len()..];
        }
    }
}

/// A number at the beginning of a text, and how long it is.
fn numeral(text: &str) -> Result<(Value, usize), String> {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let is_part = |it: &&u8| it.is_ascii_digit() || **it == b'_';
        from + bytes[from..].iter().take_while(is_part).count()
    };
    for (prefix, radix) in [("0x", 16), ("0o", 8), ("0b", 2)] {
        if text.len() > 2 && text[..2].eq_ignore_ascii_case(prefix) {
            let end = text[2..]
                .find(|it: char| !it.is_ascii_hexdigit())
                .map_or(text.len(), |it| it + 2);
            let value = i64::from_str_radix(&text[2..end], radix);
            let value = value.map_err(|_| format!("`{}` is not a number", &text[..end]))?;
            return Ok((Value::Int(value), end));
        }
    }
    let mut end = digits(0);
    let mut is_whole = true;
    if bytes.get(end) == Some(&b'.') {
        is_whole = false;
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(end + 1 + sign).is_some_and(u8::is_ascii_digit) {
            is_whole = false;
            end = digits(end + 1 + sign);
        }
    }
    let plain = text[..end].replace('_', "");
    let value = match is_whole {
        true => plain.parse().map(Value::Int).ok(),
        false => None,
    };
    let value = value.or_else(|| plain.parse().map(Value::Float).ok());
    let value = value.ok_or_else(|| format!("`{}` is not a number", &text[..end]))?;
    Ok((value, end))
}

/// A text in quotes at the beginning of a text, and how long it is with them.
fn string(text: &str, is_raw: bool) -> Result<(String, usize), String> {
    let quote = text.chars().next().unwrap_or('"');
    let mut found = String::new();
    let mut characters = text.char_indices().skip(1);
    while let Some((place, character)) = characters.next() {
        match character {
            it if it == quote => return Ok((found, place + 1)),
            '\\' if !is_raw => match characters.next() {
                Some((_, 'n')) => found.push('\n'),
                Some((_, 't')) => found.push('\t'),
                Some((_, it @ ('\\' | '\'' | '"'))) => found.push(it),
                Some((_, it)) => found.extend(['\\', it]),
                None => break,
            },
            it => found.push(it),
        }
    }
    Err("a text in quotes has no end".to_owned())
}

/// The expression that a text is.
pub(super) fn parse(text: &str) -> Result<Expr, String> {
    let tokens = tokens(text)?;
    if tokens.is_empty() {
        return Err("the expression is empty".to_owned());
    }
    let mut parser = Parser {
        tokens,
        at: 0,
        depth: 0,
    };
    let found = parser.tuple()?;
    match parser.tokens.get(parser.at) {
        None => Ok(found),
        Some(token) => Err(format!("`{}` is not expected there", shown(token))),
    }
}

fn shown(token: &Token) -> String {
    match token {
        Token::Value(value) => value.repr(),
        Token::Name(name) => name.clone(),
        Token::Sign(sign) => (*sign).to_owned(),
    }
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
}

type Parsed = Result<Expr, String>;

/// Operators with two operands, the loosest first; those of a row bind alike.
const BINARY: [&[&str]; 6] = [
    &["|"],
    &["^"],
    &["&"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "//", "/", "%"],
];

impl Parser {
    fn is(&self, sign: &str) -> bool {
        matches!(self.tokens.get(self.at), Some(Token::Sign(found)) if *found == sign)
    }

    fn take(&mut self, sign: &str) -> bool {
        let is = self.is(sign);
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        match self.take(sign) {
            true => Ok(()),
            false => Err(match self.tokens.get(self.at) {
                Some(token) => format!("`{sign}` is expected, not `{}`", shown(token)),
                None => format!("`{sign}` is missing at the end"),
            }),
        }
    }

    fn one_of(&mut self, signs: &[&'static str]) -> Option<&'static str> {
        signs.iter().find(|sign| self.take(sign)).copied()
    }

    fn deeper(&mut self, parse: impl FnOnce(&mut Self) -> Parsed) -> Parsed {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("it is nested more than {MAX_DEPTH} deep"));
        }
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    /// Expressions with commas between them are a tuple.
    fn tuple(&mut self) -> Parsed {
        let first = self.conditional()?;
        if !self.is(",") {
            return Ok(first);
        }
        let mut all = vec![first];
        while self.take(",") {
            if self.tokens.get(self.at).is_none() || self.is(")") {
                break;
            }
            all.push(self.conditional()?);
        }
        Ok(Expr::Tuple(all))
    }

    fn conditional(&mut self) -> Parsed {
        self.deeper(|it| {
            let value = it.or()?;
            if !it.take("if") {
                return Ok(value);
            }
            let condition = it.or()?;
            it.expect("else")?;
            let otherwise = it.conditional()?;
            Ok(Expr::If(Box::new([condition, value, otherwise])))
        })
    }

    fn or(&mut self) -> Parsed {
        let mut left = self.and()?;
        while self.take("or") {
            left = Expr::Or(Box::new(left), Box::new(self.and()?));
        }
        Ok(left)
    }

    fn and(&mut self) -> Parsed {
        let mut left = self.not()?;
        while self.take("and") {
            left = Expr::And(Box::new(left), Box::new(self.not()?));
        }
        Ok(left)
    }

    fn not(&mut self) -> Parsed {
        match self.take("not") {
            true => {
                let of = self.deeper(Self::not)?;
                Ok(Expr::Unary("not", Box::new(of)))
            }
            false => self.comparison(),
        }
    }

    fn comparison(&mut self) -> Parsed {
        let first = self.binary(0)?;
        let mut rest = Vec::new();
        loop {
            let operator = match self.one_of(&["<=", ">=", "==", "!=", "<", ">", "in", "is"]) {
                Some("is") if self.take("not") => "is not",
                Some(operator) => operator,
                None if self.is("not") => {
                    self.at += 1;
                    self.expect("in")?;
                    "not in"
                }
                None => break,
            };
            rest.push((operator, self.binary(0)?));
        }
        Ok(match rest.is_empty() {
            true => first,
            false => Expr::Compare(Box::new(first), rest),
        })
    }

    fn binary(&mut self, level: usize) -> Parsed {
        let Some(operators) = BINARY.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some(operator) = self.one_of(operators) {
            let right = self.binary(level + 1)?;
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Parsed {
        match self.one_of(&["-", "+", "~"]) {
            Some(operator) => {
                let of = self.deeper(Self::unary)?;
                Ok(Expr::Unary(operator, Box::new(of)))
            }
            None => self.power(),
        }
    }

    fn power(&mut self) -> Parsed {
        let base = self.postfix()?;
        if !self.take("**") {
            return Ok(base);
        }
        // It binds tighter than a sign before it and looser than one behind it.
        let exponent = self.deeper(Self::unary)?;
        Ok(Expr::Binary("**", Box::new(base), Box::new(exponent)))
    }

    fn postfix(&mut self) -> Parsed {
        let mut value = self.atom()?;
        loop {
            if self.take("(") {
                value = self.call(value)?;
            } else if self.take("[") {
                value = self.index(value)?;
            } else if self.take(".") {
                let Some(Token::Name(name)) = self.tokens.get(self.at).cloned() else {
                    return Err("a name is expected behind `.`".to_owned());
                };
                self.at += 1;
                value = Expr::Attribute(Box::new(value), name);
            } else {
                return Ok(value);
            }
        }
    }

    fn call(&mut self, function: Expr) -> Parsed {
        let (mut arguments, mut named) = (Vec::new(), Vec::new());
        while !self.take(")") {
            let is_named = matches!(
                (self.tokens.get(self.at), self.tokens.get(self.at + 1)),
                (Some(Token::Name(_)), Some(Token::Sign("=")))
            );
            match (is_named, self.tokens.get(self.at).cloned()) {
                (true, Some(Token::Name(name))) => {
                    self.at += 2;
                    named.push((name, self.conditional()?));
                }
                _ => {
                    let argument = self.conditional()?;
                    arguments.push(self.comprehension(argument)?);
                }
            }
            if !self.take(",") {
                self.expect(")")?;
                break;
            }
        }
        Ok(Expr::Call(Box::new(function), arguments, named))
    }

    fn index(&mut self, of: Expr) -> Parsed {
        let mut parts = [None, None, None];
        let mut place = 0;
        let mut is_slice = false;
        while !self.take("]") {
            if self.take(":") {
                is_slice = true;
                place += 1;
                if place > 2 {
                    return Err("a slice has at most three parts".to_owned());
                }
                continue;
            }
            parts[place] = Some(self.conditional()?);
            if !self.is(":") && !self.is("]") {
                self.expect("]")?;
            }
        }
        match (is_slice, parts) {
            (false, [Some(index), ..]) => Ok(Expr::Index(Box::new(of), Box::new(index))),
            (false, _) => Err("an index is missing between `[` and `]`".to_owned()),
            (true, parts) => Ok(Expr::Slice(Box::new(of), Box::new(parts))),
        }
    }

    /// What follows an element, if it is that of a comprehension.
    fn comprehension(&mut self, element: Expr) -> Parsed {
        if !self.take("for") {
            return Ok(element);
        }
        let mut names = Vec::new();
        let in_parentheses = self.take("(");
        loop {
            match self.tokens.get(self.at).cloned() {
                Some(Token::Name(name)) => names.push(name),
                _ => return Err("a name is expected behind `for`".to_owned()),
            }
            self.at += 1;
            if !self.take(",") {
                break;
            }
        }
        if in_parentheses {
            self.expect(")")?;
        }
        self.expect("in")?;
        let over = self.or()?;
        let mut conditions = Vec::new();
        while self.take("if") {
            conditions.push(self.or()?);
        }
        if self.is("for") {
            return Err("a comprehension goes through one list here".to_owned());
        }
        let element = Box::new(element);
        Ok(Expr::Comprehension(
            element,
            names,
            Box::new(over),
            conditions,
        ))
    }

    fn atom(&mut self) -> Parsed {
        let Some(token) = self.tokens.get(self.at).cloned() else {
            return Err("it ends where a value is expected".to_owned());
        };
        self.at += 1;
        match token {
            Token::Value(Value::Text(mut text)) => {
                // Texts behind one another are one.
                while let Some(Token::Value(Value::Text(more))) = self.tokens.get(self.at) {
                    text = format!("{text}{more}").into();
                    self.at += 1;
                }
                Ok(Expr::Value(Value::Text(text)))
            }
            Token::Value(value) => Ok(Expr::Value(value)),
            Token::Name(name) => Ok(match name.as_str() {
                "True" => Expr::Value(Value::Bool(true)),
                "False" => Expr::Value(Value::Bool(false)),
                "None" => Expr::Value(Value::Nothing),
                _ => Expr::Name(name),
            }),
            Token::Sign("(") => self.parenthesised(),
            Token::Sign("[") => self.list(),
            Token::Sign("{") => self.dict(),
            Token::Sign(sign) => Err(format!("`{sign}` stands where a value is expected")),
        }
    }

    fn parenthesised(&mut self) -> Parsed {
        if self.take(")") {
            return Ok(Expr::Tuple(Vec::new()));
        }
        let inner = self.tuple()?;
        let inner = self.comprehension(inner)?;
        self.expect(")")?;
        Ok(inner)
    }

    fn list(&mut self) -> Parsed {
        let mut all = Vec::new();
        while !self.take("]") {
            let element = self.conditional()?;
            let element = self.comprehension(element)?;
            if matches!(element, Expr::Comprehension(..)) && all.is_empty() {
                self.expect("]")?;
                return Ok(element);
            }
            all.push(element);
            if !self.take(",") {
                self.expect("]")?;
                break;
            }
        }
        Ok(Expr::List(all))
    }

    fn dict(&mut self) -> Parsed {
        let mut entries = Vec::new();
        while !self.take("}") {
            let key = self.conditional()?;
            self.expect(":")?;
            entries.push((key, self.conditional()?));
            if !self.take(",") {
                self.expect("}")?;
                break;
            }
        }
        Ok(Expr::Dict(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_expression_is_refused_with_a_reason() {
        for (text, expected) in [
            ("", "empty"),
            ("1 +", "ends where"),
            ("(1", "`)` is missing"),
            ("1 2", "`2` is not expected"),
            ("a ? b", "`?` has no meaning"),
            ("'a", "no end"),
            ("x if y", "`else` is missing"),
            ("a[]", "index is missing"),
            ("lambda x: x", "not expected"),
        ] {
            let reason = parse(text).unwrap_err();
            assert!(reason.contains(expected), "{text}: {reason}");
        }
        let deep = "(".repeat(5_000) + "1" + &")".repeat(5_000);
        assert!(parse(&deep).unwrap_err().contains("nested"));
        let deep = "-".repeat(5_000) + "1";
        assert!(parse(&deep).unwrap_err().contains("nested"));
        let deep = "not ".repeat(5_000) + "1";
        assert!(parse(&deep).unwrap_err().contains("nested"));
    }
}
