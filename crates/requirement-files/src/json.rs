//! JSON with the place of every value, so that a value is replaced where it stands.
//!
//! Source: RFC 8259. Deviation: none in what is accepted; a value may be nested [`MAX_DEPTH`] deep.

use crate::mistakes::bad;
use diagnostic::{Problem, Source};
use std::ops::Range;

/// How deeply values may be nested, so that no text can exhaust the stack.
const MAX_DEPTH: usize = 128;

/// A value with its place.
#[derive(Clone, Debug)]
pub(crate) struct Value {
    pub(crate) span: Range<usize>,
    pub(crate) kind: Kind,
}

/// What a value is.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Null,
    Scalar,
    Text(String),
    List(Vec<Value>),
    /// The keys with their values, in the order of the text.
    Object(Vec<(String, Value)>),
}

impl Value {
    /// The value of a key; of several, the last, as parsers of JSON have it.
    pub(crate) fn get(&self, key: &str) -> Option<&Value> {
        match &self.kind {
            Kind::Object(entries) => {
                let mut entries = entries.iter().rev();
                entries.find(|(name, _)| name == key).map(|(_, it)| it)
            }
            _ => None,
        }
    }

    /// The text of a key, if it is one.
    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        match &self.get(key)?.kind {
            Kind::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// Reads a text.
pub(crate) fn read(source: &Source) -> Result<Value, Problem> {
    let text = &source.text;
    let at = if text.starts_with('\u{feff}') { 3 } else { 0 };
    let mut reader = Reader { text, at };
    let value = reader.value(0).and_then(|value| {
        reader.space();
        match reader.at == text.len() {
            true => Ok(value),
            false => Err("the text goes on behind the end of its value".to_owned()),
        }
    });
    value.map_err(|message| {
        let at = reader.at.min(text.len());
        bad(message)
            .at(source, at..at + 1)
            .remedy("correct it here; the file has to be valid JSON")
    })
}

/// A text as JSON writes it.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            control if (control as u32) < 0x20 => {
                out.push_str(&format!("\\u{:04x}", control as u32));
            }
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
}

impl Reader<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r' | b'\n')) {
            self.at += 1;
        }
    }

    fn expect(&mut self, sign: u8) -> Result<(), String> {
        match self.peek() {
            Some(found) if found == sign => {
                self.at += 1;
                Ok(())
            }
            Some(_) => Err(format!("`{}` was expected here", char::from(sign))),
            None => Err(format!(
                "the text ends where `{}` was expected",
                char::from(sign)
            )),
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value, String> {
        if depth > MAX_DEPTH {
            return Err(format!("values are nested more than {MAX_DEPTH} deep"));
        }
        self.space();
        let start = self.at;
        let kind = match self.peek() {
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.list(depth)?,
            Some(b'"') => Kind::Text(self.string()?),
            Some(_) => self.word()?,
            None => return Err("the text ends where a value was expected".into()),
        };
        Ok(Value {
            span: start..self.at,
            kind,
        })
    }

    fn object(&mut self, depth: usize) -> Result<Kind, String> {
        self.at += 1;
        let mut entries = Vec::new();
        self.space();
        if self.peek() == Some(b'}') {
            self.at += 1;
            return Ok(Kind::Object(entries));
        }
        loop {
            self.space();
            if self.peek() != Some(b'"') {
                return Err("a key in quotes was expected here".into());
            }
            let key = self.string()?;
            self.space();
            self.expect(b':')?;
            entries.push((key, self.value(depth + 1)?));
            self.space();
            if self.peek() != Some(b',') {
                break;
            }
            self.at += 1;
        }
        self.expect(b'}')?;
        Ok(Kind::Object(entries))
    }

    fn list(&mut self, depth: usize) -> Result<Kind, String> {
        self.at += 1;
        let mut values = Vec::new();
        self.space();
        if self.peek() == Some(b']') {
            self.at += 1;
            return Ok(Kind::List(values));
        }
        loop {
            values.push(self.value(depth + 1)?);
            self.space();
            if self.peek() != Some(b',') {
                break;
            }
            self.at += 1;
        }
        self.expect(b']')?;
        Ok(Kind::List(values))
    }

    fn word(&mut self) -> Result<Kind, String> {
        let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte);
        let start = self.at;
        while self.peek().is_some_and(is_part) {
            self.at += 1;
        }
        let word = &self.text[start..self.at];
        match word {
            "null" => Ok(Kind::Null),
            "true" | "false" => Ok(Kind::Scalar),
            number if is_number(number) => Ok(Kind::Scalar),
            _ => {
                self.at = start;
                Err("a value was expected here".into())
            }
        }
    }

    fn string(&mut self) -> Result<String, String> {
        let opened = self.at;
        self.at += 1;
        let mut read = String::new();
        loop {
            let rest = &self.text[self.at..];
            let Some(letter) = rest.chars().next() else {
                self.at = opened;
                return Err("this text in quotes has no end".into());
            };
            match letter {
                '"' => {
                    self.at += 1;
                    return Ok(read);
                }
                '\\' => read.push(self.escape()?),
                control if (control as u32) < 0x20 => {
                    return Err("a text in quotes cannot have a line break or another control character as it is".into());
                }
                other => {
                    read.push(other);
                    self.at += other.len_utf8();
                }
            }
        }
    }

    fn escape(&mut self) -> Result<char, String> {
        let sign = self.text.as_bytes().get(self.at + 1).copied();
        let letter = match sign {
            Some(b'"') => '"',
            Some(b'\\') => '\\',
            Some(b'/') => '/',
            Some(b'b') => '\u{8}',
            Some(b'f') => '\u{c}',
            Some(b'n') => '\n',
            Some(b'r') => '\r',
            Some(b't') => '\t',
            Some(b'u') => return self.code_point(),
            _ => return Err("this escape is not known in JSON".into()),
        };
        self.at += 2;
        Ok(letter)
    }

    fn code_point(&mut self) -> Result<char, String> {
        let unit = |at: usize| {
            let digits = self.text.get(at..at + 4)?;
            let all = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
            all.then(|| u32::from_str_radix(digits, 16).ok()).flatten()
        };
        let first = unit(self.at + 2).ok_or("four hexadecimal digits were expected")?;
        if (0xd800..0xdc00).contains(&first) && self.text[self.at + 6..].starts_with("\\u") {
            let second = unit(self.at + 8).filter(|it| (0xdc00..0xe000).contains(it));
            if let Some(second) = second {
                self.at += 12;
                let code = 0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00);
                return char::from_u32(code).ok_or_else(|| "not a character".to_owned());
            }
        }
        self.at += 6;
        // Half of a pair stands for no character; other parsers keep it as this one.
        Ok(char::from_u32(first).unwrap_or('\u{fffd}'))
    }
}

/// Whether a word is a number as JSON has them.
fn is_number(word: &str) -> bool {
    let word = word.strip_prefix('-').unwrap_or(word);
    let digits = word.bytes().take_while(u8::is_ascii_digit).count();
    let leads_with_zero = digits > 1 && word.starts_with('0');
    digits > 0 && !leads_with_zero && word.parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Value, Problem> {
        read(&Source::new("x.json", text))
    }

    #[test]
    fn values_have_their_places() {
        let text = r#" {"a": "x\u00e9\n", "b": [1, -2.5e3, true, null, {}]}"#;
        let value = of(text).expect("JSON");
        assert_eq!(value.text("a"), Some("xé\n"));
        assert_eq!(
            &text[value.get("a").expect("a").span.clone()],
            r#""x\u00e9\n""#
        );
        let odd = "a\"\\\n\u{1}é";
        let written = quoted(odd);
        let read = of(&format!("[{written}]")).expect("JSON");
        assert!(
            matches!(read.kind, Kind::List(ref all) if matches!(all[0].kind, Kind::Text(ref text) if text == odd))
        );
    }

    #[test]
    fn what_is_not_json_is_placed() {
        for (bad, line, column) in [
            ("{\"a\": }", 1, 7),
            ("{\n  a: 1}", 2, 3),
            ("[1, 2", 1, 6),
            ("[01]", 1, 2),
            ("\"\\x\"", 1, 2),
            ("{} {}", 1, 4),
            ("", 1, 1),
        ] {
            let problem = of(bad).expect_err(bad);
            let place = problem.place().expect("a place");
            assert_eq!((place.line, place.column), (line, column), "{bad}");
        }
        let deep = "[".repeat(100_000);
        assert!(of(&deep).expect_err("deep").message().contains("deep"));
    }
}
