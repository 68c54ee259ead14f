//! Publishing into a running system.

use crate::{LiveError, SchemaText};

/// A topic that is to be published.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outgoing {
    /// The name, `/robot/joint_states`.
    pub name: String,
    /// The type, `sensor_msgs/msg/JointState`.
    pub type_name: String,
    /// The encoding of the bytes; `cdr` for DDS.
    pub encoding: String,
    /// The type's definition, for transports that carry it (Foxglove WebSocket).
    pub schema: Option<SchemaText>,
    /// Whether what was sent last is kept for readers that come later (DDS alone).
    pub latched: bool,
}

impl Outgoing {
    /// A topic of ROS 2: encoding `cdr`, no definition, not latched.
    pub fn ros2(name: &str, type_name: &str) -> Self {
        Self {
            name: name.to_owned(),
            type_name: type_name.to_owned(),
            encoding: "cdr".to_owned(),
            schema: None,
            latched: false,
        }
    }
}

/// A topic that was advertised on a [`Publisher`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PublicationId(pub(crate) usize);

/// Where messages can be sent.
pub trait Publisher: Send {
    /// Makes a topic known.
    ///
    /// # Errors
    /// When the transport cannot carry it.
    fn advertise(&mut self, topic: &Outgoing) -> Result<PublicationId, LiveError>;

    /// Sends one encoded message, stamped with `publish_nanos` (since 1970) if the transport carries stamps. For
    /// `cdr` the bytes begin with the encapsulation header.
    ///
    /// # Errors
    /// When the bytes are not what the encoding asks for, or they cannot be sent now.
    fn publish(
        &mut self,
        publication: PublicationId,
        publish_nanos: i64,
        data: &[u8],
    ) -> Result<(), LiveError>;
}
