//! Why a stream cannot go on.

use std::fmt;

use trace::TraceError;

use super::bind::BindError;
use crate::reader::ReadError;

/// A stream cannot go on.
#[derive(Debug)]
pub enum StreamError {
    /// The recording cannot be read on.
    Read(ReadError),
    /// A topic that appeared late does not fit the topic map.
    Bind(Vec<BindError>),
    /// Messages with and without stamps cannot be put in one order, because the stamps are not of
    /// the recorder's clock.
    MixedClocks {
        /// A topic whose messages have no stamp.
        unstamped: String,
        /// A topic whose messages have one.
        stamped: String,
        /// How far its first stamp is from log time, in seconds.
        apart_secs: f64,
    },
    /// A value does not fit into a trace.
    Trace(TraceError),
}

impl fmt::Display for StreamError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StreamError::Read(error) => error.fmt(out),
            StreamError::Bind(errors) => {
                let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
                out.write_str(&texts.join("; "))
            }
            StreamError::MixedClocks {
                unstamped,
                stamped,
                apart_secs,
            } => write!(
                out,
                "messages of {unstamped} have no header, and the stamps of {stamped} are \
                 {apart_secs} s away from log time, so the two cannot be put in one order; use log \
                 or clock as the time"
            ),
            StreamError::Trace(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for StreamError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            StreamError::Read(error) => Some(error),
            StreamError::Trace(error) => Some(error),
            _ => None,
        }
    }
}
