//! Names of places inside a message.
//!
//! | path | means |
//! |---|---|
//! | `pose.position.x` | a field of a field of a field |
//! | `position[3]` | an element, from 0 |
//! | `transforms[child_frame_id='hand'].transform.translation.x` | the first element whose field has that value |
//! | `transforms[header.frame_id='base', child_frame_id='hand'].…` | … whose fields all have these values |
//! | `position[name='elbow']` | the element at the place where the array beside it, `name`, holds that value |
//! | `length(ranges)` | the number of elements |
//! | `"odd name".x` | a name with other signs, as tables and JSON have them |

use std::fmt;

/// A place inside a message, as written.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldPath {
    text: String,
    pub(crate) steps: Vec<Step>,
    pub(crate) is_length: bool,
}

/// One step from a value to a part of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Step {
    Field(String),
    Index(u64),
    /// The element for which every condition holds.
    Where(Vec<Condition>),
}

/// A place inside an element (or the name of an array beside it), and what must stand there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Condition {
    pub(crate) names: Vec<String>,
    pub(crate) key: Key,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Key {
    Text(String),
    Number(f64),
}

/// A path cannot be understood, or does not fit its topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathError {
    /// The path as written.
    pub path: String,
    /// What is wrong, with a remedy.
    pub message: String,
}

impl fmt::Display for PathError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "\"{}\": {}", self.path, self.message)
    }
}

impl std::error::Error for PathError {}

impl fmt::Display for FieldPath {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

impl std::str::FromStr for FieldPath {
    type Err = PathError;

    fn from_str(text: &str) -> Result<Self, PathError> {
        FieldPath::parse(text)
    }
}

impl FieldPath {
    /// Reads a path.
    ///
    /// # Errors
    /// [`PathError`] if it is malformed.
    pub fn parse(text: &str) -> Result<Self, PathError> {
        let trimmed = text.trim();
        let inner = trimmed
            .strip_prefix("length(")
            .and_then(|rest| rest.strip_suffix(')'));
        let mut scanner = Scanner {
            whole: trimmed,
            rest: inner.unwrap_or(trimmed),
        };
        Ok(FieldPath {
            steps: scanner.steps()?,
            text: trimmed.to_owned(),
            is_length: inner.is_some(),
        })
    }

    /// Whether it picks an element by what stands in or beside it, as `position[name='elbow']` does.
    #[must_use]
    pub fn is_keyed(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, Step::Where(_)))
    }

    /// The path as written.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }

    pub(crate) fn error(&self, message: impl Into<String>) -> PathError {
        PathError {
            path: self.text.clone(),
            message: message.into(),
        }
    }
}

struct Scanner<'t> {
    whole: &'t str,
    rest: &'t str,
}

impl Scanner<'_> {
    fn error<T>(&self, message: impl Into<String>) -> Result<T, PathError> {
        Err(PathError {
            path: self.whole.to_owned(),
            message: message.into(),
        })
    }

    fn steps(&mut self) -> Result<Vec<Step>, PathError> {
        let mut steps = vec![Step::Field(self.name()?)];
        loop {
            if self.accept('.') {
                steps.push(Step::Field(self.name()?));
            } else if self.accept('[') {
                steps.push(self.bracket()?);
            } else if self.rest.is_empty() {
                return Ok(steps);
            } else {
                let found = self.rest.chars().next().unwrap_or(' ');
                return self.error(format!("'{found}' has no meaning here; write a.b[0].c"));
            }
        }
    }

    fn accept(&mut self, sign: char) -> bool {
        match self.rest.trim_start().strip_prefix(sign) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn quoted(&mut self, quote: char) -> Result<String, PathError> {
        let Some(end) = self.rest.find(quote) else {
            return self.error(format!("a text has no end; close it with {quote}"));
        };
        let text = self.rest[..end].to_owned();
        self.rest = &self.rest[end + 1..];
        Ok(text)
    }

    fn name(&mut self) -> Result<String, PathError> {
        if self.accept('"') {
            return self.quoted('"');
        }
        let is_end = |c: char| ".[]()='\", \t".contains(c);
        let end = self.rest.find(is_end).unwrap_or(self.rest.len());
        if end == 0 {
            return self.error("a field's name is missing; write a.b[0].c");
        }
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        Ok(name.to_owned())
    }

    fn bracket(&mut self) -> Result<Step, PathError> {
        if self.rest.starts_with(|c: char| c.is_ascii_digit()) {
            let end = self.rest.find(']').unwrap_or(self.rest.len());
            let Ok(index) = self.rest[..end].trim().parse() else {
                return self.error("an index is a whole number, from 0");
            };
            self.rest = &self.rest[end..];
            return self.close(Step::Index(index));
        }
        let mut conditions = Vec::new();
        loop {
            conditions.push(self.condition()?);
            if !self.accept(',') {
                return self.close(Step::Where(conditions));
            }
        }
    }

    fn close(&mut self, step: Step) -> Result<Step, PathError> {
        if self.accept(']') {
            Ok(step)
        } else {
            self.error("] is missing")
        }
    }

    fn condition(&mut self) -> Result<Condition, PathError> {
        let mut names = vec![self.name()?];
        while self.accept('.') {
            names.push(self.name()?);
        }
        if !self.accept('=') {
            return self.error("write an index, or name='value', between [ and ]");
        }
        for quote in ['\'', '"'] {
            if self.accept(quote) {
                let key = Key::Text(self.quoted(quote)?);
                return Ok(Condition { names, key });
            }
        }
        let end = self.rest.find([',', ']']).unwrap_or(self.rest.len());
        let Ok(number) = self.rest[..end].trim().parse() else {
            return self.error("a value is a number, or a text between quotes");
        };
        self.rest = &self.rest[end..];
        Ok(Condition {
            names,
            key: Key::Number(number),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_as_the_table_says() {
        let steps = |text| FieldPath::parse(text).unwrap().steps;
        let field = |name: &str| Step::Field(name.to_owned());
        assert_eq!(
            steps("a.b[3].c"),
            [field("a"), field("b"), Step::Index(3), field("c")]
        );
        assert_eq!(steps("\"odd name\".x"), [field("odd name"), field("x")]);
        let conditions = vec![
            Condition {
                names: vec!["header".to_owned(), "frame_id".to_owned()],
                key: Key::Text("base, or ]".to_owned()),
            },
            Condition {
                names: vec!["id".to_owned()],
                key: Key::Number(3.0),
            },
        ];
        let read = steps("t[header.frame_id='base, or ]', id=3].x");
        assert_eq!(read, [field("t"), Step::Where(conditions), field("x")]);
        assert!(FieldPath::parse("length(ranges)").unwrap().is_length);
    }

    #[test]
    fn malformed_paths_are_refused() {
        for text in [
            "", ".", "a.", "a[", "a[x]", "a[-1]", "a[1", "a]", "a b", "a[n='x]", "length(a",
        ] {
            assert!(FieldPath::parse(text).is_err(), "{text}");
        }
    }
}
