//! YAML files, as descriptions load them: maps and lists in blocks or in brackets, scalars, anchors, and the tags that xacro
//! gives units. Scalars are what YAML 1.1 makes of them, as the Python library reads them.

use super::value::Value;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Maps and lists inside one another.
const MAX_DEPTH: usize = 40;

/// Values of a file.
const MAX_VALUES: usize = 200_000;

/// Tags by which a number, or an expression, is in a unit.
const UNITS: [(&str, f64); 6] = [
    ("radians", 1.0),
    ("degrees", std::f64::consts::PI / 180.0),
    ("meters", 1.0),
    ("millimeters", 0.001),
    ("foot", 0.3048),
    ("inches", 0.0254),
];

/// Evaluates an expression behind a tag to a number.
type Numbers<'n> = &'n mut dyn FnMut(&str) -> Result<f64, String>;

/// What a file holds; an error says its line.
pub(super) fn parse(text: &str, numbers: Numbers<'_>) -> Result<Value, String> {
    let mut parser = Parser {
        lines: lines(text),
        at: 0,
        anchors: BTreeMap::new(),
        values: 0,
        numbers,
    };
    let Some(first) = parser.lines.first() else {
        return Ok(Value::Nothing);
    };
    let value = parser.block(first.indent, 0)?;
    match parser.lines.get(parser.at) {
        None => Ok(value),
        Some(line) => Err(format!(
            "line {}: it is indented otherwise than what it belongs to",
            line.number
        )),
    }
}

/// A line that says something.
#[derive(Clone, Debug)]
struct Line {
    number: usize,
    indent: usize,
    text: String,
}

fn lines(text: &str) -> Vec<Line> {
    let mut found: Vec<Line> = Vec::new();
    for (number, raw) in (1..).zip(text.lines()) {
        let raw = raw.trim_start_matches('\u{feff}');
        if raw.starts_with("---") || raw.starts_with('%') {
            // The next document is another file's worth.
            if !found.is_empty() {
                break;
            }
            continue;
        }
        if raw.starts_with("...") {
            break;
        }
        let text = without_comment(raw);
        let trimmed = text.trim();
        if !trimmed.is_empty() {
            found.push(Line {
                number,
                indent: text.len() - text.trim_start().len(),
                text: trimmed.to_owned(),
            });
        }
    }
    found
}

fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    for (place, character) in line.char_indices() {
        match (quote, character) {
            (None, '#') if before.is_whitespace() => return &line[..place],
            (None, '"' | '\'') if !before.is_alphanumeric() => quote = Some(character),
            (Some(open), it) if open == it => quote = None,
            _ => {}
        }
        before = character;
    }
    line
}

struct Parser<'n> {
    lines: Vec<Line>,
    at: usize,
    anchors: BTreeMap<String, Value>,
    values: usize,
    numbers: Numbers<'n>,
}

type Parsed = Result<Value, String>;

/// The key and what follows it, if a line is an entry of a map.
fn entry(text: &str) -> Option<(&str, &str)> {
    let (mut quote, mut depth) = (None, 0_usize);
    for (place, character) in text.char_indices() {
        match (quote, character) {
            (None, '"' | '\'') if place == 0 || depth > 0 => quote = Some(character),
            (Some(open), it) if open == it => quote = None,
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            (None, ':') if depth == 0 => {
                let rest = &text[place + 1..];
                if rest.is_empty() || rest.starts_with([' ', '\t']) {
                    return Some((text[..place].trim(), rest.trim()));
                }
            }
            _ => {}
        }
    }
    None
}

impl Parser<'_> {
    fn line(&self) -> Option<Line> {
        self.lines.get(self.at).cloned()
    }

    fn count(&mut self) -> Result<(), String> {
        self.values += 1;
        match self.values <= MAX_VALUES {
            true => Ok(()),
            false => Err(format!("it has more than {MAX_VALUES} values")),
        }
    }

    /// What an anchor stands for, which counts each time.
    fn anchored(&mut self, name: &str) -> Parsed {
        let value = self.anchors.get(name).cloned();
        let value = value.ok_or_else(|| format!("there is no anchor `&{name}` before"))?;
        self.values += value.size(MAX_VALUES);
        self.count()?;
        Ok(value)
    }

    /// What stands at an indentation.
    fn block(&mut self, indent: usize, depth: usize) -> Parsed {
        self.count()?;
        let Some(line) = self.line() else {
            return Ok(Value::Nothing);
        };
        if depth > MAX_DEPTH {
            return Err(format!(
                "line {}: it is nested more than {MAX_DEPTH} deep",
                line.number
            ));
        }
        if is_item(&line.text) {
            return self.list(indent, depth);
        }
        if entry(&line.text).is_some() && !line.text.starts_with(['[', '{']) {
            return self.map(indent, depth);
        }
        self.at += 1;
        self.value(&line, &line.text, indent, depth)
    }

    fn list(&mut self, indent: usize, depth: usize) -> Parsed {
        let mut values = Vec::new();
        while let Some(line) = self.line() {
            if line.indent != indent || !is_item(&line.text) {
                break;
            }
            let rest = line.text[1..].trim_start();
            let deeper = indent + line.text.len() - rest.len();
            if rest.is_empty() {
                self.at += 1;
                values.push(self.nested(indent, depth)?);
                continue;
            }
            // What stands behind the dash is a block of its own.
            self.lines[self.at] = Line {
                indent: deeper,
                text: rest.to_owned(),
                ..line
            };
            values.push(self.block(deeper, depth + 1)?);
        }
        Ok(Value::list(values))
    }

    fn map(&mut self, indent: usize, depth: usize) -> Parsed {
        let mut entries = Entries::default();
        while let Some(line) = self.line() {
            if line.indent != indent || is_item(&line.text) {
                break;
            }
            let Some((key, rest)) = entry(&line.text) else {
                return Err(format!("line {}: `key: value` is expected", line.number));
            };
            self.at += 1;
            let value = self.value(&line, rest, indent, depth)?;
            entries.add(key, value);
        }
        Ok(entries.dict())
    }

    /// What is behind a key or a dash that stands alone in its line.
    fn nested(&mut self, indent: usize, depth: usize) -> Parsed {
        match self.line() {
            Some(next) if next.indent > indent => self.block(next.indent, depth + 1),
            // A list may stand as far left as its key.
            Some(next) if next.indent == indent && is_item(&next.text) => {
                let is_of_list = self.lines[self.at - 1].text.starts_with('-');
                match is_of_list {
                    true => Ok(Value::Nothing),
                    false => self.list(indent, depth + 1),
                }
            }
            _ => Ok(Value::Nothing),
        }
    }

    /// A value that begins in a line which was taken already.
    fn value(&mut self, line: &Line, text: &str, indent: usize, depth: usize) -> Parsed {
        self.count()?;
        let at = |reason: String| format!("line {}: {reason}", line.number);
        if let Some(rest) = text.strip_prefix('&') {
            let (name, rest) = rest.split_once([' ', '\t']).unwrap_or((rest, ""));
            let value = self.value(line, rest.trim(), indent, depth)?;
            self.anchors.insert(name.to_owned(), value.clone());
            return Ok(value);
        }
        if let Some(name) = text.strip_prefix('*') {
            return self.anchored(name.trim()).map_err(at);
        }
        if let Some(rest) = text.strip_prefix('!') {
            let (tag, rest) = rest.split_once([' ', '\t']).unwrap_or((rest, ""));
            let unit = UNITS.iter().find(|(name, _)| *name == tag);
            let value = rest.trim().trim_matches(['"', '\'']);
            return match unit {
                Some((_, factor)) => (self.numbers)(value)
                    .map(|it| Value::Float(it * factor))
                    .map_err(at),
                None => self.value(line, rest.trim(), indent, depth),
            };
        }
        match text.chars().next() {
            None => self.nested(indent, depth),
            Some('[' | '{') => {
                let text = self.up_to_closing(text);
                let mut flow = Flow {
                    rest: &text,
                    parser: self,
                };
                let value = flow.value(depth).map_err(at)?;
                match flow.rest.trim().is_empty() {
                    true => Ok(value),
                    false => Err(at(format!("`{}` stands behind the end", flow.rest.trim()))),
                }
            }
            Some('|' | '>') if text.len() <= 3 => {
                Ok(Value::text(self.literal(indent, text.starts_with('|'))))
            }
            Some(_) => {
                let mut whole = text.to_owned();
                // A plain text goes on in lines that are indented further.
                while let Some(next) = self
                    .line()
                    .filter(|it| it.indent > indent && entry(&it.text).is_none())
                {
                    whole = format!("{whole} {}", next.text);
                    self.at += 1;
                }
                Ok(scalar(&whole))
            }
        }
    }

    /// Lines up to where all brackets are closed.
    fn up_to_closing(&mut self, text: &str) -> String {
        let mut whole = text.to_owned();
        while open_brackets(&whole) > 0 {
            let Some(next) = self.line() else { break };
            whole = format!("{whole} {}", next.text);
            self.at += 1;
        }
        whole
    }

    /// The lines of a text that is indented.
    fn literal(&mut self, indent: usize, keeps_lines: bool) -> String {
        let mut lines = Vec::new();
        while let Some(next) = self.line().filter(|it| it.indent > indent) {
            lines.push(next.text);
            self.at += 1;
        }
        lines.join(if keeps_lines { "\n" } else { " " }) + "\n"
    }
}

/// The entries of a map, and those that `<<` takes from others.
#[derive(Default)]
struct Entries {
    own: Vec<(Value, Value)>,
    merged: Vec<(Value, Value)>,
}

impl Entries {
    fn add(&mut self, key: &str, value: Value) {
        match (key, value) {
            ("<<", Value::Dict(of)) => self.merged.extend(of.iter().cloned()),
            (key, value) => {
                let key = scalar(key);
                self.own.retain(|(known, _)| *known != key);
                self.own.push((key, value));
            }
        }
    }

    /// All of them; what the map has itself counts.
    fn dict(self) -> Value {
        let Self { mut own, merged } = self;
        for (key, value) in merged {
            if own.iter().all(|(known, _)| *known != key) {
                own.push((key, value));
            }
        }
        Value::Dict(Rc::new(own))
    }
}

fn is_item(text: &str) -> bool {
    text == "-" || text.starts_with("- ")
}

fn open_brackets(text: &str) -> i64 {
    let (mut quote, mut open) = (None, 0);
    for character in text.chars() {
        match (quote, character) {
            (None, '"' | '\'') => quote = Some(character),
            (Some(it), character) if it == character => quote = None,
            (None, '[' | '{') => open += 1,
            (None, ']' | '}') => open -= 1,
            _ => {}
        }
    }
    open
}

/// A value in brackets.
struct Flow<'t, 'p, 'n> {
    rest: &'t str,
    parser: &'p mut Parser<'n>,
}

impl Flow<'_, '_, '_> {
    fn take(&mut self, sign: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(sign) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn value(&mut self, depth: usize) -> Parsed {
        self.parser.count()?;
        if depth > MAX_DEPTH {
            return Err(format!("it is nested more than {MAX_DEPTH} deep"));
        }
        if self.take('[') {
            let mut values = Vec::new();
            while !self.take(']') {
                values.push(self.value(depth + 1)?);
                if !self.take(',') && !self.rest.trim_start().starts_with(']') {
                    return Err("`]` is missing".to_owned());
                }
            }
            return Ok(Value::list(values));
        }
        if self.take('{') {
            let mut entries = Entries::default();
            while !self.take('}') {
                let key = self.word(true).to_owned();
                let value = match self.take(':') {
                    true => self.value(depth + 1)?,
                    false => Value::Nothing,
                };
                entries.add(&key, value);
                if !self.take(',') && !self.rest.trim_start().starts_with('}') {
                    return Err("`}` is missing".to_owned());
                }
            }
            return Ok(entries.dict());
        }
        let word = self.word(false).to_owned();
        if word.is_empty() && !self.rest.is_empty() && !self.rest.starts_with([',', ']', '}']) {
            return Err(format!("`{}` is not expected", self.rest));
        }
        let tag = word.strip_prefix('!').and_then(|it| it.split_once(' '));
        let unit = tag.and_then(|(tag, rest)| {
            let found = UNITS.iter().find(|(name, _)| *name == tag)?;
            Some((found.1, rest.trim()))
        });
        match (unit, word.strip_prefix('*')) {
            (Some((factor, text)), _) => Ok(Value::Float((self.parser.numbers)(text)? * factor)),
            (None, Some(name)) => {
                let name = name.to_owned();
                self.parser.anchored(&name)
            }
            (None, None) => Ok(scalar(&word)),
        }
    }

    /// A scalar, up to what ends it.
    fn word(&mut self, is_key: bool) -> &str {
        let text = self.rest.trim_start();
        let quote = text.chars().next().filter(|it| matches!(it, '"' | '\''));
        let end = match quote {
            Some(quote) => text[1..].find(quote).map_or(text.len(), |it| it + 2),
            None => {
                let mut depth = 0;
                let ends = |it: char| {
                    match it {
                        '(' => depth += 1,
                        ')' => depth -= 1,
                        _ => {}
                    }
                    depth == 0 && matches!(it, ',' | ']' | '}') || is_key && it == ':'
                };
                text.find(ends).unwrap_or(text.len())
            }
        };
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        word.trim()
    }
}

/// What a scalar is.
fn scalar(text: &str) -> Value {
    if let Some(inner) = quoted(text, '"') {
        let plain = inner
            .replace("\\\"", "\"")
            .replace("\\n", "\n")
            .replace("\\t", "\t");
        return Value::text(plain.replace("\\\\", "\\"));
    }
    if let Some(inner) = quoted(text, '\'') {
        return Value::text(inner.replace("''", "'"));
    }
    match text {
        "" | "~" | "null" | "Null" | "NULL" => return Value::Nothing,
        "true" | "True" | "TRUE" | "yes" | "Yes" | "YES" | "on" | "On" | "ON" => {
            return Value::Bool(true);
        }
        "false" | "False" | "FALSE" | "no" | "No" | "NO" | "off" | "Off" | "OFF" => {
            return Value::Bool(false);
        }
        ".inf" | "+.inf" | ".Inf" | ".INF" => return Value::Float(f64::INFINITY),
        "-.inf" | "-.Inf" | "-.INF" => return Value::Float(f64::NEG_INFINITY),
        ".nan" | ".NaN" | ".NAN" => return Value::Float(f64::NAN),
        _ => {}
    }
    let plain = text.replace('_', "");
    let (sign, digits) = match plain.strip_prefix(['+', '-']) {
        Some(rest) => (if plain.starts_with('-') { -1 } else { 1 }, rest),
        None => (1, plain.as_str()),
    };
    let in_radix = |digits: &str, radix| i64::from_str_radix(digits, radix).ok();
    let whole = match digits {
        _ if !digits.starts_with(|it: char| it.is_ascii_digit()) => None,
        _ if digits.starts_with("0x") => in_radix(&digits[2..], 16),
        _ if digits.starts_with("0b") => in_radix(&digits[2..], 2),
        _ if digits.len() > 1 && digits.starts_with('0') => in_radix(&digits[1..], 8),
        _ => digits.parse().ok(),
    };
    if let Some(whole) = whole {
        return Value::Int(sign * whole);
    }
    // YAML 1.1 takes a number with a full stop for one, and an exponent with a sign.
    let has_point =
        digits.contains('.') && digits.starts_with(|it: char| it.is_ascii_digit() || it == '.');
    let exponent = digits.find(['e', 'E']).map(|at| &digits[at + 1..]);
    let is_signed = exponent.is_none_or(|it| it.starts_with(['+', '-']));
    match plain.parse::<f64>() {
        Ok(value) if has_point && is_signed => Value::Float(value),
        _ => Value::text(text),
    }
}

fn quoted(text: &str, quote: char) -> Option<&str> {
    text.strip_prefix(quote)?.strip_suffix(quote)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<String, String> {
        let mut numbers = |text: &str| text.parse::<f64>().map_err(|error| error.to_string());
        parse(text, &mut numbers).map(|it| it.to_string())
    }

    #[test]
    fn blocks_brackets_and_scalars_are_what_the_python_library_reads() {
        // python3 -c 'import yaml, sys; print(yaml.safe_load(sys.stdin))'
        let text = "
# a comment
joint_limits:
  shoulder:   # another
    min: -3.14
    max: 3
    has: true
    name: 'a # b'
    colour: \"x: y\"
  list:
  - 1
  - two
  -
    three: 3
  - four: 4
    five: [1, 2.5, {a: b}]
empty:
text: this is
  a text
spread: [1,
  2, 3]
big: 1e3
more: 1.0e+3
oct: 010
none: ~
url: package://a/b
";
        let expected = "{'joint_limits': {'shoulder': {'min': -3.14, 'max': 3, 'has': True, 'name': 'a # b', \
            'colour': 'x: y'}, 'list': [1, 'two', {'three': 3}, {'four': 4, 'five': [1, 2.5, {'a': 'b'}]}]}, \
            'empty': None, 'text': 'this is a text', 'spread': [1, 2, 3], 'big': '1e3', 'more': 1000.0, 'oct': 8, \
            'none': None, 'url': 'package://a/b'}";
        assert_eq!(read(text).as_deref(), Ok(expected));
    }

    #[test]
    fn tags_of_units_anchors_and_merges_are_read() {
        let text = "a: &x {low: !degrees 180, up: 2}\nb:\n  <<: *x\n  up: 3\nc: !radians 1.5\nd: *x\ne: {<<: *x, up: 4}\n";
        let expected = "{'a': {'low': 3.141592653589793, 'up': 2}, 'b': {'up': 3, 'low': 3.141592653589793}, 'c': 1.5, \
            'd': {'low': 3.141592653589793, 'up': 2}, 'e': {'up': 4, 'low': 3.141592653589793}}";
        assert_eq!(read(text).as_deref(), Ok(expected));
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line_and_nothing_hangs() {
        for (text, expected) in [
            ("a: 1\n   b: 2\n c: 3", "line 2"),
            ("a: *x", "anchor"),
            ("a: [1, 2", "`]` is missing"),
            ("a: {b: 1", "`}` is missing"),
            ("- 1\nb: 2", "line 2"),
        ] {
            let reason = read(text).unwrap_err();
            assert!(reason.contains(expected), "{text}: {reason}");
        }
        assert!(read(&("a: ".to_owned() + &"[".repeat(5_000))).is_err());
        assert!(read(&"- ".repeat(5_000)).is_err());
        assert_eq!(read("").as_deref(), Ok("None"));
    }
}
