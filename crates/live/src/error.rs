//! What can go wrong, each with what to do about it.

use std::fmt;

/// Why a live connection could not be made, or ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LiveError {
    /// An option or argument has no meaning; the text says which and what is allowed.
    Option(String),
    /// The other side could not be reached.
    Connect {
        /// The address as it was given.
        to: String,
        /// What the system or the other side answered.
        reason: String,
    },
    /// The other side does not do what was asked (for example it takes no messages from clients).
    Unsupported(String),
    /// Bytes to publish are not what the topic's encoding asks for.
    Encoding(String),
    /// A message could not be sent.
    Send {
        /// The topic's name.
        topic: String,
        /// What the transport answered.
        reason: String,
    },
    /// The transport stopped working and cannot be continued; attach again.
    Transport(String),
    /// All was handed out that there was to come, as it should be; the text says how it ended.
    Ended(String),
}

impl fmt::Display for LiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Option(text)
            | Self::Unsupported(text)
            | Self::Encoding(text)
            | Self::Ended(text) => f.write_str(text),
            Self::Connect { to, reason } => write!(
                f,
                "cannot connect to {to}: {reason}; check that it runs and can be reached from here"
            ),
            Self::Send { topic, reason } => {
                write!(f, "a message on {topic} could not be sent: {reason}")
            }
            Self::Transport(reason) => {
                write!(
                    f,
                    "the connection cannot be continued: {reason}; attach again"
                )
            }
        }
    }
}

impl std::error::Error for LiveError {}
