//! The part of OMG IDL that ROS 2 generates from its messages, and that people write for it.
//!
//! Source: OMG IDL 4.2, section 7.4; ROS 2 design article "Mapping between ROS interface types and
//! DDS IDL types". Read are modules, structures, enumerations (as unsigned numbers of 32 bits),
//! `typedef` with dimensions, sequences and bounded text; annotations, constants and preprocessor
//! lines are passed over. Unions, inheritance, bit masks, optional members and `long double` have
//! other layouts and are refused. Several files may be joined by lines of `=` and `IDL: name`.

mod resolve;
mod tokens;

use std::collections::BTreeMap;

use super::SchemaError;
use super::message_type::{MessageType, Primitive, Type};
use resolve::Resolver;
use tokens::{Token, tokens};

const DEPTH_LIMIT: usize = 64;

/// Reads the IDL `text` and gives its structure called `name` (`package/msg/Type` or
/// `package::msg::Type`).
///
/// # Errors
/// [`SchemaError`] with its line, if something cannot be understood or the structure is missing.
pub fn parse_idl(name: &str, text: &str) -> Result<MessageType, SchemaError> {
    let mut parser = Parser {
        tokens: tokens(text)?,
        at: 0,
        scope: Vec::new(),
        defined: BTreeMap::new(),
    };
    while parser.peek().is_some() {
        parser.definition()?;
    }
    let wanted = name.replace('/', "::");
    let mut resolver = Resolver {
        defined: &parser.defined,
        known: BTreeMap::new(),
    };
    let Some(Defined::Struct(_)) = parser.defined.get(&wanted) else {
        return Err(SchemaError::new(
            0,
            format!("it does not define the structure {name}"),
        ));
    };
    let made = resolver.structure(&wanted, 0)?;
    Ok(MessageType::clone(&made))
}

enum Defined {
    Struct(Vec<(String, Written)>),
    Alias(Written),
    Enumeration(Vec<String>),
}

/// A type as written, before names are looked up.
#[derive(Clone)]
struct Written {
    base: Base,
    dimensions: Vec<u64>,
    scope: Vec<String>,
    line: usize,
}

#[derive(Clone)]
enum Base {
    Plain(Type),
    Named(String),
    Sequence(Box<Written>),
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    scope: Vec<String>,
    defined: BTreeMap<String, Defined>,
}

impl Parser {
    fn peek(&self) -> Option<&str> {
        self.tokens.get(self.at).map(|token| token.text.as_str())
    }

    fn line(&self) -> usize {
        let last = self.tokens.last();
        let token = self.tokens.get(self.at).or(last);
        token.map_or(0, |token| token.line)
    }

    fn error<T>(&self, message: impl Into<String>) -> Result<T, SchemaError> {
        Err(SchemaError::new(self.line(), message))
    }

    fn next(&mut self) -> Result<String, SchemaError> {
        let Some(token) = self.tokens.get(self.at) else {
            return self.error("the text ends too early");
        };
        let text = token.text.clone();
        self.at += 1;
        Ok(text)
    }

    fn accept(&mut self, sign: &str) -> bool {
        let found = self.peek() == Some(sign);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, sign: &str) -> Result<(), SchemaError> {
        if self.accept(sign) {
            return Ok(());
        }
        let found = self.peek().unwrap_or("the end").to_owned();
        self.error(format!("{sign} is expected, not {found}"))
    }

    fn name(&mut self) -> Result<String, SchemaError> {
        let name = self.next()?;
        let starts_well = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if name.replace("::", "").contains(':') {
            self.error("inheritance is not supported in IDL")
        } else if starts_well {
            Ok(name)
        } else {
            self.error(format!("a name is expected, not {name}"))
        }
    }

    /// Passes over annotations; refuses those that change the layout.
    fn annotations(&mut self) -> Result<(), SchemaError> {
        while self.accept("@") {
            let name = self.next()?;
            if name == "optional" {
                return self.error("optional members are not supported");
            }
            if self.accept("(") {
                let mut depth = 1;
                while depth > 0 {
                    match self.next()?.as_str() {
                        "(" => depth += 1,
                        ")" => depth -= 1,
                        _ => {}
                    }
                }
            }
        }
        Ok(())
    }

    fn full_name(&self, name: &str) -> String {
        let mut parts = self.scope.clone();
        parts.push(name.to_owned());
        parts.join("::")
    }

    fn definition(&mut self) -> Result<(), SchemaError> {
        self.annotations()?;
        match self.next()?.as_str() {
            ";" => Ok(()),
            "module" => self.module(),
            "struct" => self.structure(),
            "typedef" => self.alias(),
            "enum" => self.enumeration(),
            "const" => {
                while self.next()? != ";" {}
                Ok(())
            }
            other => {
                let problem = format!("{other} is not supported in IDL");
                self.at -= 1;
                self.error(problem)
            }
        }
    }

    fn module(&mut self) -> Result<(), SchemaError> {
        let name = self.name()?;
        if self.scope.len() > DEPTH_LIMIT {
            return self.error("modules are nested too deeply");
        }
        self.scope.push(name);
        self.expect("{")?;
        while !self.accept("}") {
            self.definition()?;
        }
        self.scope.pop();
        Ok(())
    }

    fn structure(&mut self) -> Result<(), SchemaError> {
        let name = self.name()?;
        if self.peek() == Some(":") {
            return self.error("inheritance is not supported in IDL");
        }
        if self.accept(";") {
            return Ok(());
        }
        self.expect("{")?;
        let mut members: Vec<(String, Written)> = Vec::new();
        while !self.accept("}") {
            self.annotations()?;
            let written = self.written(0)?;
            loop {
                let member = self.name()?;
                if members.iter().any(|(known, _)| *known == member) {
                    return self.error(format!("the member {member} stands twice in {name}"));
                }
                members.push((member, self.dimensions(written.clone())?));
                if !self.accept(",") {
                    break;
                }
            }
            self.expect(";")?;
        }
        let name = self.full_name(&name);
        self.defined.insert(name, Defined::Struct(members));
        Ok(())
    }

    fn alias(&mut self) -> Result<(), SchemaError> {
        let written = self.written(0)?;
        let name = self.name()?;
        let written = self.dimensions(written)?;
        self.expect(";")?;
        let name = self.full_name(&name);
        self.defined.insert(name, Defined::Alias(written));
        Ok(())
    }

    fn enumeration(&mut self) -> Result<(), SchemaError> {
        let name = self.name()?;
        self.expect("{")?;
        let mut names = Vec::new();
        let mut has_own_values = false;
        while !self.accept("}") {
            has_own_values |= self.peek() == Some("@");
            self.annotations()?;
            names.push(self.name()?);
            self.accept(",");
        }
        if has_own_values {
            // Their numbers are not the positions; better none than wrong ones.
            names.clear();
        }
        let name = self.full_name(&name);
        self.defined.insert(name, Defined::Enumeration(names));
        Ok(())
    }

    fn dimensions(&mut self, mut written: Written) -> Result<Written, SchemaError> {
        while self.accept("[") {
            let length = self.next()?;
            match length.parse() {
                Ok(length) => written.dimensions.push(length),
                Err(_) => return self.error(format!("{length} is not a length")),
            }
            self.expect("]")?;
        }
        Ok(written)
    }

    fn written(&mut self, depth: usize) -> Result<Written, SchemaError> {
        if depth > DEPTH_LIMIT {
            return self.error("sequences are nested too deeply");
        }
        let line = self.line();
        let word = self.next()?;
        let base = match word.as_str() {
            "sequence" => {
                self.expect("<")?;
                let element = self.written(depth + 1)?;
                self.bound(",")?;
                self.expect(">")?;
                Base::Sequence(Box::new(element))
            }
            "string" | "wstring" => {
                if self.accept("<") {
                    self.next()?;
                    self.expect(">")?;
                }
                Base::Plain(if word == "string" {
                    Type::Text
                } else {
                    Type::WideText
                })
            }
            "unsigned" | "long" | "short" => Base::Plain(Type::Primitive(self.integer(&word)?)),
            other => match primitive(other) {
                Some(primitive) => Base::Plain(Type::Primitive(primitive)),
                None => Base::Named(other.to_owned()),
            },
        };
        Ok(Written {
            base,
            dimensions: Vec::new(),
            scope: self.scope.clone(),
            line,
        })
    }

    fn bound(&mut self, sign: &str) -> Result<(), SchemaError> {
        if self.accept(sign) {
            self.next()?;
        }
        Ok(())
    }

    /// The integers whose names have several words.
    fn integer(&mut self, first: &str) -> Result<Primitive, SchemaError> {
        let unsigned = first == "unsigned";
        let size = if unsigned {
            self.next()?
        } else {
            first.to_owned()
        };
        let is_long_long = size == "long" && self.accept("long");
        if size == "long" && !is_long_long && self.peek() == Some("double") {
            return self.error("long double is not supported");
        }
        match (size.as_str(), is_long_long, unsigned) {
            ("short", _, true) => Ok(Primitive::Uint16),
            ("short", _, false) => Ok(Primitive::Int16),
            ("long", false, true) => Ok(Primitive::Uint32),
            ("long", false, false) => Ok(Primitive::Int32),
            ("long", true, true) => Ok(Primitive::Uint64),
            ("long", true, false) => Ok(Primitive::Int64),
            _ => self.error(format!("unsigned {size} is not a type")),
        }
    }
}

fn primitive(name: &str) -> Option<Primitive> {
    Some(match name {
        "boolean" => Primitive::Bool,
        "octet" | "uint8" | "char" => Primitive::Uint8,
        "int8" => Primitive::Int8,
        "int16" => Primitive::Int16,
        "uint16" => Primitive::Uint16,
        "int32" => Primitive::Int32,
        "uint32" => Primitive::Uint32,
        "int64" => Primitive::Int64,
        "uint64" => Primitive::Uint64,
        "float" => Primitive::Float32,
        "double" => Primitive::Float64,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ros_2_generates_is_read() {
        let text = r#"
// generated from rosidl
#include "std_msgs/msg/Header.idl"
module p { module msg {
  typedef double double__36[36];
  module Thing_Constants { const uint8 IDLE = 0; };
  enum Mode { OFF, ON };
  @verbatim (language="comment", text= "a ) b" "second")
  struct Thing {
    @unit (value="m") double x; /* in
    between */ double__36 covariance;
    sequence<p::msg::Point, 3> points; string<10> name; long long n; unsigned long m; Mode mode;
  }; }; };
================================================================================
IDL: p/msg/Point
module p { module msg { struct Point { float x, y; octet raw[2][3]; }; }; };
"#;
        let made = parse_idl("p/msg/Thing", text).unwrap();
        let kinds: Vec<&Type> = made.fields.iter().map(|f| &f.kind).collect();
        assert_eq!(*kinds[0], Type::Primitive(Primitive::Float64));
        let doubles = Box::new(Type::Primitive(Primitive::Float64));
        assert_eq!(*kinds[1], Type::Array(doubles, 36));
        assert_eq!(*kinds[4], Type::Primitive(Primitive::Int64));
        assert_eq!(*kinds[5], Type::Primitive(Primitive::Uint32));
        assert_eq!(made.constants[1].name, "ON");
        let Type::Sequence(point) = kinds[2] else {
            panic!("{made:?}")
        };
        let Type::Struct(point) = &**point else {
            panic!("{made:?}")
        };
        assert_eq!(point.fields[1].name, "y");
        let bytes = Box::new(Type::Primitive(Primitive::Uint8));
        let rows = Type::Array(Box::new(Type::Array(bytes, 3)), 2);
        assert_eq!(point.fields[2].kind, rows);
    }

    #[test]
    fn what_has_another_layout_is_refused_with_its_line() {
        let error = |text: &str| parse_idl("m/A", text).unwrap_err();
        assert_eq!(error("module m {\nstruct A : B {}; };").line, 2);
        assert!(error("module m { union A {}; };").message.contains("union"));
        assert!(
            error("module m { struct A { sequence<A> a; }; };")
                .message
                .contains("contains itself")
        );
        assert!(
            error("module m { struct A { B b; }; };")
                .message
                .contains("not defined")
        );
        assert!(
            error("module m { struct A { @optional long b; }; };")
                .message
                .contains("optional")
        );
    }
}
