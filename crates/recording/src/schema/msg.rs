//! Message definitions of ROS 1 and ROS 2, as recordings keep them: the definition of the topic's
//! type, then, each after a line of `=` and a line `MSG: package/Type`, those of all types in it.
//!
//! Sources: ROS 1 wiki, "msg"; ROS 2 documentation, "Interfaces", and REP 2011 for the joining of
//! definitions. A line is `type name`, `type name default` or `type NAME=value`; `type` may end in
//! `[]`, `[n]` or `[<=n]`, text in `<=n`. Bounds are not checked when messages are read, since
//! they do not change their layout.
//!
//! Differences that matter for decoding, and are kept: `byte` is signed in ROS 1 and not in ROS 2;
//! `time` and `duration` are built in to ROS 1; a ROS 2 type without fields has one byte.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::SchemaError;
use super::message_type::{Constant, MessageField, MessageType, Primitive, Type};

/// The deepest nesting of types that is believed.
const DEPTH_LIMIT: usize = 64;

/// Whose definitions they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// ROS 1.
    Ros1,
    /// ROS 2.
    Ros2,
}

/// Reads the joined definitions `text` of the type called `name` (`package/Type` or
/// `package/msg/Type`).
///
/// # Errors
/// [`SchemaError`] with its line, if a line cannot be understood or a type is missing.
pub fn parse_msg(name: &str, text: &str, dialect: Dialect) -> Result<MessageType, SchemaError> {
    let sections = sections(name, text);
    let mut resolver = Resolver {
        sections: &sections,
        dialect,
        known: BTreeMap::new(),
    };
    let root = resolver.section(0, 0)?;
    Ok(MessageType::clone(&root))
}

/// One definition of the joined text.
struct Section<'t> {
    name: String,
    first_line: usize,
    lines: Vec<&'t str>,
}

fn sections<'t>(name: &str, text: &'t str) -> Vec<Section<'t>> {
    let mut found = vec![Section {
        name: short(name),
        first_line: 1,
        lines: Vec::new(),
    }];
    let mut after_rule = false;
    for (index, line) in text.lines().enumerate() {
        let trimmed = line.trim();
        let is_rule = trimmed.len() >= 3 && trimmed.bytes().all(|byte| byte == b'=');
        if is_rule {
            after_rule = true;
        } else if after_rule && let Some(name) = trimmed.strip_prefix("MSG:") {
            after_rule = false;
            found.push(Section {
                name: short(name.trim()),
                first_line: index + 2,
                lines: Vec::new(),
            });
            continue;
        }
        if let Some(section) = found.last_mut() {
            section.lines.push(if is_rule { "" } else { line });
        }
    }
    found
}

/// `package/Type`, whether or not there is a `/msg/` (or `/srv/`, `/action/`) between.
fn short(name: &str) -> String {
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    match parts.as_slice() {
        [package, .., last] => format!("{package}/{last}"),
        _ => name.to_owned(),
    }
}

struct Resolver<'s, 't> {
    sections: &'s [Section<'t>],
    dialect: Dialect,
    /// Types that are done; `None` while one is being worked on.
    known: BTreeMap<usize, Option<Arc<MessageType>>>,
}

impl Resolver<'_, '_> {
    fn section(&mut self, index: usize, depth: usize) -> Result<Arc<MessageType>, SchemaError> {
        let section = &self.sections[index];
        match self.known.get(&index) {
            Some(Some(done)) => return Ok(done.clone()),
            Some(None) => {
                let problem = format!("{} contains itself", section.name);
                return Err(SchemaError::new(section.first_line, problem));
            }
            None => {}
        }
        if depth > DEPTH_LIMIT {
            let problem = "types are nested too deeply";
            return Err(SchemaError::new(section.first_line, problem));
        }
        self.known.insert(index, None);
        let mut made = MessageType {
            name: section.name.clone(),
            fields: Vec::new(),
            constants: Vec::new(),
        };
        for (offset, line) in section.lines.iter().enumerate() {
            self.line(line, section, section.first_line + offset, depth, &mut made)?;
        }
        if made.fields.is_empty() && self.dialect == Dialect::Ros2 {
            made.fields.push(MessageField {
                name: "structure_needs_at_least_one_member".to_owned(),
                kind: Type::Primitive(Primitive::Uint8),
            });
        }
        let made = Arc::new(made);
        self.known.insert(index, Some(made.clone()));
        Ok(made)
    }

    /// Takes one line of a definition.
    fn line(
        &mut self,
        line: &str,
        section: &Section<'_>,
        number: usize,
        depth: usize,
        made: &mut MessageType,
    ) -> Result<(), SchemaError> {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            return Ok(());
        }
        let Some((kind_text, rest)) = text.split_once(char::is_whitespace) else {
            let problem = format!("\"{text}\" is a type without a name");
            return Err(SchemaError::new(number, problem));
        };
        let rest = rest.trim_start();
        let length = rest.bytes().take_while(|b| is_name_byte(*b)).count();
        let (name, after) = rest.split_at(length);
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            let problem = format!("\"{text}\" has no name");
            return Err(SchemaError::new(number, problem));
        }
        if let Some(value) = after.trim_start().strip_prefix('=') {
            made.constants.push(Constant {
                name: name.to_owned(),
                type_name: kind_text.to_owned(),
                value: self.constant_value(kind_text, value),
            });
            return Ok(());
        }
        if !after.is_empty() && !after.starts_with(char::is_whitespace) && !after.starts_with('#') {
            let problem = format!("\"{text}\" is not a field");
            return Err(SchemaError::new(number, problem));
        }
        if made.fields.iter().any(|field| field.name == name) {
            let problem = format!("the field {name} stands twice in {}", made.name);
            return Err(SchemaError::new(number, problem));
        }
        let kind = self.kind(kind_text, section, number, depth)?;
        made.fields.push(MessageField {
            name: name.to_owned(),
            kind,
        });
        Ok(())
    }

    fn constant_value(&self, kind: &str, value: &str) -> String {
        let value = value.trim();
        let is_text = kind.starts_with("string") || kind.starts_with("wstring");
        if is_text && self.dialect == Dialect::Ros1 {
            return value.to_owned();
        }
        let quote = value
            .chars()
            .next()
            .filter(|c| is_text && "'\"".contains(*c));
        if let Some(quote) = quote
            && let Some(end) = value[1..].find(quote)
        {
            return value[1..=end].to_owned();
        }
        let end = value.find('#').unwrap_or(value.len());
        value[..end].trim().to_owned()
    }

    /// Reads a type as written: base, bound of text, dimension.
    fn kind(
        &mut self,
        text: &str,
        section: &Section<'_>,
        line: usize,
        depth: usize,
    ) -> Result<Type, SchemaError> {
        let (base, dimension) = match text.find('[') {
            Some(start) => (&text[..start], Some(&text[start..])),
            None => (text, None),
        };
        let base = base.split_once("<=").map_or(base, |(base, _)| base);
        let element = self.base(base, section, line, depth)?;
        let Some(dimension) = dimension else {
            return Ok(element);
        };
        let inner = dimension
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .ok_or_else(|| SchemaError::new(line, format!("\"{text}\" is not a type")))?;
        if inner.is_empty() || inner.starts_with("<=") {
            return Ok(Type::Sequence(Box::new(element)));
        }
        match inner.parse() {
            Ok(length) => Ok(Type::Array(Box::new(element), length)),
            Err(_) => Err(SchemaError::new(line, format!("\"{text}\" is not a type"))),
        }
    }

    fn base(
        &mut self,
        base: &str,
        section: &Section<'_>,
        line: usize,
        depth: usize,
    ) -> Result<Type, SchemaError> {
        if let Some(primitive) = primitive(base, self.dialect) {
            return Ok(Type::Primitive(primitive));
        }
        match base {
            "string" => return Ok(Type::Text),
            "wstring" => return Ok(Type::WideText),
            "time" | "duration" => return Ok(Type::Struct(time(base, self.dialect))),
            _ => {}
        }
        if let Some(index) = self.find(base, section) {
            return Ok(Type::Struct(self.section(index, depth + 1)?));
        }
        match (self.dialect, short(base).as_str()) {
            (Dialect::Ros2, "builtin_interfaces/Time") => {
                Ok(Type::Struct(time("time", self.dialect)))
            }
            (Dialect::Ros2, "builtin_interfaces/Duration") => {
                Ok(Type::Struct(time("duration", self.dialect)))
            }
            _ => Err(SchemaError::new(
                line,
                format!("the type {base} is used, but not defined"),
            )),
        }
    }

    /// The section that defines `base` as named inside `section`.
    fn find(&self, base: &str, section: &Section<'_>) -> Option<usize> {
        let position = |name: &str| self.sections.iter().position(|s| s.name == name);
        if base.contains('/') {
            return position(&short(base));
        }
        let package = section.name.split('/').next().unwrap_or_default();
        let special = (base == "Header").then(|| position("std_msgs/Header"));
        position(&format!("{package}/{base}"))
            .or(special.flatten())
            .or_else(|| position(base))
    }
}

fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

fn primitive(name: &str, dialect: Dialect) -> Option<Primitive> {
    Some(match name {
        "bool" => Primitive::Bool,
        "byte" if dialect == Dialect::Ros1 => Primitive::Int8,
        "int8" => Primitive::Int8,
        "byte" | "char" | "uint8" => Primitive::Uint8,
        "int16" => Primitive::Int16,
        "uint16" => Primitive::Uint16,
        "int32" => Primitive::Int32,
        "uint32" => Primitive::Uint32,
        "int64" => Primitive::Int64,
        "uint64" => Primitive::Uint64,
        "float32" => Primitive::Float32,
        "float64" => Primitive::Float64,
        _ => return None,
    })
}

/// The types of times: seconds and nanoseconds, signed as each version of ROS has them.
fn time(name: &str, dialect: Dialect) -> Arc<MessageType> {
    let (sec, nanosec) = match (name, dialect) {
        ("time", Dialect::Ros1) => (Primitive::Uint32, Primitive::Uint32),
        (_, Dialect::Ros1) => (Primitive::Int32, Primitive::Int32),
        _ => (Primitive::Int32, Primitive::Uint32),
    };
    let field = |name: &str, kind| MessageField {
        name: name.to_owned(),
        kind: Type::Primitive(kind),
    };
    Arc::new(MessageType {
        name: name.to_owned(),
        fields: vec![field("sec", sec), field("nanosec", nanosec)],
        constants: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: &str =
        "================================================================================";

    #[test]
    fn joined_definitions_nest_and_keep_constants_apart() {
        let text = format!(
            "# a pose with a name\nuint8 IDLE=0 # first\nstring NAME=\"a # b\"\nstd_msgs/Header header\n\
             float64[36] covariance\nstring<=10[<=3] names [\"x\"]\nPoint[] points\nint32 n -3\n{RULE}\n\
             MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{RULE}\n\
             MSG: p/Point\nfloat64 x\nfloat64 y\n"
        );
        let made = parse_msg("p/msg/Thing", &text, Dialect::Ros2).unwrap();
        let names: Vec<&str> = made.fields.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["header", "covariance", "names", "points", "n"]);
        assert_eq!(made.constants[0].value, "0");
        assert_eq!(made.constants[1].value, "a # b");
        assert_eq!(made.fields[2].kind, Type::Sequence(Box::new(Type::Text)));
        let Type::Struct(header) = &made.fields[0].kind else {
            panic!("{made:?}")
        };
        let Type::Struct(stamp) = &header.fields[0].kind else {
            panic!("{made:?}")
        };
        assert_eq!(stamp.fields[0].kind, Type::Primitive(Primitive::Int32));
    }

    #[test]
    fn the_two_dialects_differ_where_they_do() {
        let of = |text, dialect| parse_msg("p/T", text, dialect).unwrap().fields;
        assert_eq!(
            of("byte b", Dialect::Ros1)[0].kind,
            Type::Primitive(Primitive::Int8)
        );
        assert_eq!(
            of("byte b", Dialect::Ros2)[0].kind,
            Type::Primitive(Primitive::Uint8)
        );
        assert!(of("", Dialect::Ros1).is_empty());
        assert_eq!(of("", Dialect::Ros2).len(), 1);
        let Type::Struct(time) = &of("time t", Dialect::Ros1)[0].kind else {
            panic!("no time")
        };
        assert_eq!(time.fields[0].kind, Type::Primitive(Primitive::Uint32));
    }

    #[test]
    fn wrong_definitions_are_named_with_their_line() {
        let error = |text: &str| parse_msg("p/T", text, Dialect::Ros2).unwrap_err();
        assert_eq!(error("int32 a\nfoo/Bar b").line, 2);
        assert_eq!(error("int32").line, 1);
        assert_eq!(error("int32 a\nint32 a").line, 2);
        assert_eq!(error("int32[x] a").line, 1);
        assert!(error("T again").message.contains("contains itself"));
    }
}
