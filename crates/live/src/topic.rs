//! What a topic is, and which topics are wanted.

/// A topic of the running system, as its publishers describe it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its place in the order of appearance on this source, from 0; equal to its index in
    /// [`Source::topics`](crate::Source::topics).
    pub id: u32,
    /// The name as the user knows it. ROS topics begin with `/`; other DDS topics are named as they are.
    pub name: String,
    /// The type as the user knows it, `sensor_msgs/msg/JointState` for ROS 2; a plain DDS type stays as it is.
    pub type_name: String,
    /// How messages are encoded: `cdr`, `json`, `protobuf`, `ros1` or what else a server says.
    pub encoding: String,
    /// The definition of the type if the transport carries it (DDS does not).
    pub schema: Option<SchemaText>,
    /// The quality of service that was asked of the publishers (DDS alone).
    pub qos: Option<Qos>,
    /// The hash of the type's definition that publishers of ROS 2 since Iron announce (`RIHS01_…`).
    pub type_hash: Option<String>,
    /// Who publishes it.
    pub origin: Origin,
    /// Whether messages are numbered, so that each one that did not arrive is counted. Where this is false (Foxglove
    /// WebSocket) the server may leave out messages for a slow reader without saying so.
    pub numbered: bool,
}

/// A type's definition as sent by a server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaText {
    /// The language of the definition: `ros2msg`, `ros2idl`, `ros1msg`, `jsonschema`, `protobuf`, …
    pub encoding: String,
    /// The definition: text, or for `protobuf` a serialised `FileDescriptorSet`.
    pub data: Vec<u8>,
}

/// Who publishes a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The running system.
    Outside,
    /// Our own test bench, through a [`Bridge`](crate::Bridge).
    TestBench,
}

/// The qualities of service that decide what a late or slow reader gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Whether lost datagrams are sent again.
    pub reliability: Reliability,
    /// Whether a late reader gets what was sent before.
    pub durability: Durability,
}

/// Whether lost datagrams are sent again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reliability {
    /// They are not.
    BestEffort,
    /// They are, as long as the publisher keeps them.
    Reliable,
}

/// Whether a late reader gets what was sent before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Durability {
    /// It does not.
    Volatile,
    /// It gets what the publisher still keeps (latched topics, `/tf_static`).
    TransientLocal,
}

/// Which topics are wanted: any that matches one of the patterns to take and none of those to leave. In a pattern `*`
/// stands for any characters, also `/`.
///
/// ```
/// let filter = live::TopicFilter::new(&["/robot/*", "/tf"], &["*/image"]);
/// assert!(filter.wants("/robot/joint_states"));
/// assert!(!filter.wants("/robot/camera/image"));
/// assert!(!filter.wants("/tf_static"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicFilter {
    take: Vec<String>,
    leave: Vec<String>,
}

impl TopicFilter {
    /// Takes what matches a pattern of `take`, except what matches one of `leave`.
    pub fn new(take: &[&str], leave: &[&str]) -> Self {
        let owned = |patterns: &[&str]| patterns.iter().map(|&p| p.to_owned()).collect();
        Self {
            take: owned(take),
            leave: owned(leave),
        }
    }

    /// Takes every topic of ROS (every name that begins with `/`).
    pub fn all() -> Self {
        Self::new(&["/*"], &[])
    }

    /// Leaves out topics that match `pattern`, whatever else is said.
    pub fn leave(&mut self, pattern: &str) {
        self.leave.push(pattern.to_owned());
    }

    /// Whether the topic called `name` is wanted.
    pub fn wants(&self, name: &str) -> bool {
        let any = |patterns: &[String]| patterns.iter().any(|p| matches(p, name));
        any(&self.take) && !any(&self.leave)
    }
}

/// Whether `pattern`, in which `*` stands for any characters, matches the whole of `name`. Greedy from the left: after
/// the first piece each further piece is taken where it first occurs, which finds a match if there is one.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, behind)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(mut rest) = name.strip_prefix(first) else {
        return false;
    };
    let pieces: Vec<&str> = behind.split('*').collect();
    let Some((last, middle)) = pieces.split_last() else {
        return false;
    };
    for piece in middle {
        let Some(at) = rest.find(piece) else {
            return false;
        };
        rest = &rest[at + piece.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_characters() {
        for (pattern, name, expected) in [
            ("/tf", "/tf", true),
            ("/tf", "/tf_static", false),
            ("/tf*", "/tf_static", true),
            ("*", "", true),
            ("/*/state", "/a/b/state", true),
            ("/*/state", "/state", false),
            ("/a*b*c", "/abbc", true),
            ("/a*b*c", "/acb", false),
            ("/ab*ba", "/aba", false),
            ("**", "/x", true),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn what_is_left_out_wins() {
        let mut filter = TopicFilter::all();
        assert!(filter.wants("/a") && !filter.wants("plain"));
        filter.leave("/a");
        assert!(!filter.wants("/a") && filter.wants("/ab"));
    }
}
