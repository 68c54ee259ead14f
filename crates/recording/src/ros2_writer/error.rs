//! Why a recording could not be written.

use std::fmt;

use trace::TraceError;

/// Why a ROS 2 recording could not be written.
#[derive(Debug, Clone, PartialEq)]
pub enum Ros2WriteError {
    /// No message type has this name.
    UnknownType {
        /// The name.
        type_name: String,
    },
    /// The message type has no such field.
    UnknownField {
        /// The message type.
        type_name: String,
        /// The path.
        path: String,
    },
    /// A path names a part of a message, not a value, or is given twice.
    BadPath {
        /// The message type.
        type_name: String,
        /// The path.
        path: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A value does not fit the field.
    BadValue {
        /// The path of the field.
        path: String,
        /// The value, as text.
        value: String,
        /// What the field holds.
        expected: &'static str,
    },
    /// The trace has no such topic or signal.
    UnknownSignal {
        /// The name.
        name: String,
    },
    /// The trace is not well-formed.
    Trace(TraceError),
    /// The container refuses, for example because there are more than 65535 topics.
    Format(String),
}

impl fmt::Display for Ros2WriteError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ros2WriteError::UnknownType { type_name } => write!(
                out,
                "messages of type {type_name} cannot be written; there are {}",
                super::ros2_type_names().collect::<Vec<_>>().join(", ")
            ),
            Ros2WriteError::UnknownField { type_name, path } => write!(
                out,
                "messages of type {type_name} have no field {path}; use the names of its definition"
            ),
            Ros2WriteError::BadPath {
                type_name,
                path,
                problem,
            } => write!(
                out,
                "the path {path} in messages of type {type_name} {problem}"
            ),
            Ros2WriteError::BadValue {
                path,
                value,
                expected,
            } => write!(
                out,
                "the field {path} cannot hold {value}; it takes {expected}"
            ),
            Ros2WriteError::UnknownSignal { name } => write!(
                out,
                "the trace has no {name}; use the name of one of its topics or signals"
            ),
            Ros2WriteError::Trace(error) => write!(out, "the trace cannot be written: {error}"),
            Ros2WriteError::Format(problem) => {
                write!(out, "the recording cannot be written: {problem}; split it")
            }
        }
    }
}

impl std::error::Error for Ros2WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Ros2WriteError::Trace(error) => Some(error),
            _ => None,
        }
    }
}

impl From<mcap::McapError> for Ros2WriteError {
    fn from(error: mcap::McapError) -> Self {
        Ros2WriteError::Format(error.to_string())
    }
}
