//! Types of messages whose fields stand in a fixed order.

use std::sync::Arc;

/// A type of message: its fields in the order in which they are serialised.
#[derive(Debug, Clone, PartialEq)]
pub struct MessageType {
    /// Its name, for example `geometry_msgs/msg/Pose`.
    pub name: String,
    /// Its fields.
    pub fields: Vec<MessageField>,
    /// Named values that are part of the type, not of its messages.
    pub constants: Vec<Constant>,
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct MessageField {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub kind: Type,
}

/// A named value of a type, for example `uint8 STATE_IDLE = 0`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// The type as written.
    pub type_name: String,
    /// The value as written, without quotes.
    pub value: String,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Type {
    /// One number or truth value.
    Primitive(Primitive),
    /// Text in bytes (UTF-8 by convention).
    Text,
    /// Text of wide characters, whose bytes differ between implementations; it is not read.
    WideText,
    /// A nested message.
    Struct(Arc<MessageType>),
    /// As many elements as the type says.
    Array(Box<Type>, u64),
    /// As many elements as each message says.
    Sequence(Box<Type>),
}

/// A number or truth value of fixed size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// Truth value, one byte.
    Bool,
    /// Signed, 8 bits.
    Int8,
    /// Unsigned, 8 bits (also `byte`, `char` and `octet`).
    Uint8,
    /// Signed, 16 bits.
    Int16,
    /// Unsigned, 16 bits.
    Uint16,
    /// Signed, 32 bits.
    Int32,
    /// Unsigned, 32 bits.
    Uint32,
    /// Signed, 64 bits.
    Int64,
    /// Unsigned, 64 bits.
    Uint64,
    /// IEEE 754, 32 bits.
    Float32,
    /// IEEE 754, 64 bits.
    Float64,
}

impl Primitive {
    /// Its size in bytes.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Primitive::Bool | Primitive::Int8 | Primitive::Uint8 => 1,
            Primitive::Int16 | Primitive::Uint16 => 2,
            Primitive::Int32 | Primitive::Uint32 | Primitive::Float32 => 4,
            Primitive::Int64 | Primitive::Uint64 | Primitive::Float64 => 8,
        }
    }
}

impl MessageType {
    /// The field called `name`, with its position. The names that ROS 1 gives to the parts of a
    /// time (`secs`, `nsecs`) stand for those of ROS 2 (`sec`, `nanosec`), and the other way round.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<(usize, &MessageField)> {
        let find = |name: &str| self.fields.iter().enumerate().find(|(_, f)| f.name == name);
        find(name).or_else(|| match name {
            "secs" => find("sec"),
            "nsecs" => find("nanosec"),
            "sec" => find("secs"),
            "nanosec" => find("nsecs"),
            _ => None,
        })
    }
}
