//! What the messages of a topic hold, read from the recording itself at run time.
//!
//! | language of the schema | function |
//! |---|---|
//! | ROS 2 `.msg` definitions, joined as MCAP and rosbag2 keep them (`ros2msg`) | [`parse_msg`] |
//! | ROS 1 `.msg` definitions, joined as bags keep them (`ros1msg`) | [`parse_msg`] |
//! | the part of OMG IDL that ROS 2 generates (`ros2idl`) | [`parse_idl`] |
//! | protocol buffers, as a `FileDescriptorSet` | [`ProtobufSchema::parse`] |
//!
//! The first three give a [`MessageType`], so that one decoder serves all of them.

mod idl;
mod message_type;
mod msg;
mod protobuf;

pub use idl::parse_idl;
pub use message_type::{Constant, MessageField, MessageType, Primitive, Type};
pub use msg::{Dialect, parse_msg};
pub use protobuf::{ProtoField, ProtoKind, ProtoMessage, ProtobufSchema};
pub(crate) use protobuf::{Wire, next_field, varint};

use std::fmt;

/// What the messages of a topic hold.
#[derive(Debug, Clone, PartialEq)]
pub enum Schema {
    /// Fields in a fixed order, as in ROS 1, ROS 2 and tables.
    Struct(MessageType),
    /// Self-describing messages (JSON).
    Schemaless,
    /// Protocol buffers.
    Protobuf(ProtobufSchema),
    /// It cannot be understood; the topic's messages can be counted, not decoded.
    Unknown {
        /// Why, as a clause, for example `schemas in flatbuffer are not supported`.
        reason: String,
    },
}

/// A schema cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaError {
    /// The line of the schema's text, from 1; 0 where there are no lines.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

impl SchemaError {
    pub(crate) fn new(line: usize, message: impl Into<String>) -> Self {
        SchemaError {
            line,
            message: message.into(),
        }
    }
}

impl fmt::Display for SchemaError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line > 0 {
            write!(out, "line {} of the schema: ", self.line)?;
        }
        out.write_str(&self.message)
    }
}

impl std::error::Error for SchemaError {}
