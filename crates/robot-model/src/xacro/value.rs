//! The values of expressions, as Python has them.

use std::cmp::Ordering;
use std::fmt;
use std::rc::Rc;

/// A value.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Nothing,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    /// A list, or a tuple.
    List(Rc<Vec<Value>>, Kind),
    Dict(Rc<Vec<(Value, Value)>>),
    /// The properties of an `xacro:include` with `ns`, by their scope.
    Namespace(usize),
    /// A function or a module by its name.
    Builtin(&'static str),
    /// A method of a value.
    Method(Rc<Value>, Rc<str>),
}

/// What a sequence is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    List,
    Tuple,
}

impl Value {
    pub fn text(text: impl AsRef<str>) -> Self {
        Self::Text(Rc::from(text.as_ref()))
    }

    pub fn list(values: Vec<Self>) -> Self {
        Self::List(Rc::new(values), Kind::List)
    }

    pub fn tuple(values: Vec<Self>) -> Self {
        Self::List(Rc::new(values), Kind::Tuple)
    }

    /// What it is called in messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Nothing => "None",
            Self::Bool(_) => "a truth value",
            Self::Int(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Text(_) => "a text",
            Self::List(_, Kind::List) => "a list",
            Self::List(_, Kind::Tuple) => "a tuple",
            Self::Dict(_) => "a dictionary",
            Self::Namespace(_) => "a namespace",
            Self::Builtin(_) | Self::Method(..) => "a function",
        }
    }

    /// Whether it counts as true.
    pub fn truth(&self) -> bool {
        match self {
            Self::Nothing => false,
            Self::Bool(value) => *value,
            Self::Int(value) => *value != 0,
            Self::Float(value) => *value != 0.0,
            Self::Text(value) => !value.is_empty(),
            Self::List(values, _) => !values.is_empty(),
            Self::Dict(entries) => !entries.is_empty(),
            Self::Namespace(_) | Self::Builtin(_) | Self::Method(..) => true,
        }
    }

    /// It as a number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Bool(value) => Some(f64::from(u8::from(*value))),
            Self::Int(value) => Some(*value as f64),
            Self::Float(value) => Some(*value),
            Self::Nothing
            | Self::Text(_)
            | Self::List(..)
            | Self::Dict(_)
            | Self::Namespace(_)
            | Self::Builtin(_)
            | Self::Method(..) => None,
        }
    }

    /// It as a whole number, where it is one or a truth value.
    pub fn whole(&self) -> Option<i64> {
        match self {
            Self::Bool(value) => Some(i64::from(*value)),
            Self::Int(value) => Some(*value),
            _ => None,
        }
    }

    /// What Python's `repr` writes.
    pub fn repr(&self) -> String {
        match self {
            Self::Text(text) => quoted(text),
            other => other.to_string(),
        }
    }

    /// Which of two comes first; `None` where Python does not compare them.
    pub fn compare(&self, other: &Self) -> Option<Ordering> {
        if let (Some(a), Some(b)) = (self.whole(), other.whole()) {
            return Some(a.cmp(&b));
        }
        if let (Some(a), Some(b)) = (self.number(), other.number()) {
            return a.partial_cmp(&b);
        }
        match (self, other) {
            (Self::Text(a), Self::Text(b)) => Some(a.cmp(b)),
            (Self::List(a, one), Self::List(b, two)) if one == two => {
                for (a, b) in a.iter().zip(b.iter()) {
                    match a.compare(b)? {
                        Ordering::Equal => {}
                        order => return Some(order),
                    }
                }
                Some(a.len().cmp(&b.len()))
            }
            _ => None,
        }
    }

    /// How many simple values it holds, those inside others too, counted no further than beyond `most`: lists may share what
    /// they hold, so that what is small in memory is large when it is written out.
    pub fn size(&self, most: usize) -> usize {
        let add = |sum: usize, value: &Self| match sum > most {
            true => sum,
            false => sum + value.size(most - sum),
        };
        match self {
            Self::Text(text) => 1 + text.len() / 16,
            Self::List(values, _) => values.iter().fold(1, add),
            Self::Dict(entries) => entries
                .iter()
                .fold(1, |sum, (key, value)| add(add(sum, key), value)),
            _ => 1,
        }
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Nothing, Self::Nothing) => true,
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::List(a, one), Self::List(b, two)) => one == two && a == b,
            (Self::Dict(a), Self::Dict(b)) => {
                let has =
                    |(key, value): &(Self, Self)| b.iter().any(|(k, v)| k == key && v == value);
                a.len() == b.len() && a.iter().all(has)
            }
            (Self::Namespace(a), Self::Namespace(b)) => a == b,
            (Self::Builtin(a), Self::Builtin(b)) => a == b,
            _ => match (self.number(), other.number()) {
                (Some(a), Some(b)) => a == b,
                _ => false,
            },
        }
    }
}

/// What Python's `str` writes.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined = |values: &[Self]| {
            let all: Vec<String> = values.iter().map(Self::repr).collect();
            all.join(", ")
        };
        match self {
            Self::Nothing => f.write_str("None"),
            Self::Bool(true) => f.write_str("True"),
            Self::Bool(false) => f.write_str("False"),
            Self::Int(value) => write!(f, "{value}"),
            Self::Float(value) => f.write_str(&float(*value)),
            Self::Text(text) => f.write_str(text),
            Self::List(values, Kind::List) => write!(f, "[{}]", joined(values)),
            Self::List(values, Kind::Tuple) if values.len() == 1 => {
                write!(f, "({},)", joined(values))
            }
            Self::List(values, Kind::Tuple) => write!(f, "({})", joined(values)),
            Self::Dict(entries) => {
                let entry =
                    |(key, value): &(Self, Self)| format!("{}: {}", key.repr(), value.repr());
                let all: Vec<String> = entries.iter().map(entry).collect();
                write!(f, "{{{}}}", all.join(", "))
            }
            Self::Namespace(_) => f.write_str("<namespace>"),
            Self::Builtin(name) => write!(f, "<function {name}>"),
            Self::Method(_, name) => write!(f, "<method {name}>"),
        }
    }
}

/// A number as Python's `repr` writes it: the fewest digits that read back as the same number, with an exponent below
/// 1e-4 and from 1e16 on.
pub(super) fn float(value: f64) -> String {
    if value.is_nan() {
        return "nan".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e16).contains(&magnitude) {
        let text = format!("{value:e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{digits}e{sign}{:02}", exponent.abs());
    }
    let text = format!("{value}");
    match text.contains('.') {
        true => text,
        false => text + ".0",
    }
}

/// A text in quotes, as Python's `repr` writes it.
fn quoted(text: &str) -> String {
    let quote = if text.contains('\'') && !text.contains('"') {
        '"'
    } else {
        '\''
    };
    let mut quoted = String::from(quote);
    for character in text.chars() {
        match character {
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            '\\' => quoted.push_str("\\\\"),
            it if it == quote => quoted.extend(['\\', it]),
            it => quoted.push(it),
        }
    }
    quoted.push(quote);
    quoted
}

/// What a property's text is by itself: a number, a truth value, or a text, which may be in single quotes.
pub(super) fn literal(text: &str) -> Value {
    if text.len() >= 2 && text.starts_with('\'') && text.ends_with('\'') {
        return Value::text(&text[1..text.len() - 1]);
    }
    // With underscores it is a name and not a number.
    if !text.contains('_') {
        if let Some(value) = whole(text) {
            return Value::Int(value);
        }
        if let Some(value) = number(text) {
            return Value::Float(value);
        }
        match text {
            "true" | "True" => return Value::Bool(true),
            "false" | "False" => return Value::Bool(false),
            _ => {}
        }
    }
    Value::text(text)
}

/// A whole number as Python's `int` reads it.
pub(super) fn whole(text: &str) -> Option<i64> {
    text.trim().parse().ok()
}

/// A number as Python's `float` reads it.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    // The standard library reads what Python does but for words like `infinit`.
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_python_does() {
        // python3: [repr(x) for x in (...)]
        for (value, expected) in [
            (0.0, "0.0"),
            (-0.0, "-0.0"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e16, "1e+16"),
            (123456789012345680.0, "1.2345678901234568e+17"),
            (9999999999999998.0, "9999999999999998.0"),
            (0.0001, "0.0001"),
            (0.00001, "1e-05"),
            (-2.5e-7, "-2.5e-07"),
            (1e100, "1e+100"),
            (100.0, "100.0"),
        ] {
            assert_eq!(float(value), expected);
        }
        assert_eq!(float(f64::NAN), "nan");
        assert_eq!(float(f64::NEG_INFINITY), "-inf");
    }

    #[test]
    fn a_propertys_text_is_a_number_a_truth_value_or_a_text() {
        for (text, expected) in [
            ("3", "3"),
            (" 3 ", "3"),
            ("3.50", "3.5"),
            ("1e3", "1000.0"),
            ("true", "True"),
            ("False", "False"),
            ("'3'", "'3'"),
            ("1_000", "'1_000'"),
            ("0x10", "'0x10'"),
            ("", "''"),
            ("arm", "'arm'"),
        ] {
            assert_eq!(literal(text).repr(), expected, "{text}");
        }
    }

    #[test]
    fn lists_and_dictionaries_are_written_as_python_does() {
        let list = Value::list(vec![Value::Int(1), Value::text("it's"), Value::Nothing]);
        assert_eq!(list.to_string(), "[1, \"it's\", None]");
        assert_eq!(Value::tuple(vec![Value::Bool(true)]).to_string(), "(True,)");
        let dict = Value::Dict(Rc::new(vec![(Value::text("a"), Value::Float(1.0))]));
        assert_eq!(dict.to_string(), "{'a': 1.0}");
    }
}
