//! Which signal is where in a recording: the topic map, a TOML file that is written once for a
//! robot and used for all its recordings.
//!
//! ```toml
//! [time]
//! from = "header"                # log (the default), publish, header or clock
//!
//! ["/robot.wrist_speed"]         # the signal that requirements speak of
//! from = "/joint_states.velocity[name='wrist']"
//! unit = "rad/s"
//! interpolation = "linear"
//! staleness = "0.5 s"
//!
//! ["/robot.state"]
//! from = "/task.phase"
//! values = ["idle", "serve"]
//!
//! ["/human_hand"]                # three signals: /human_hand.x, .y and .z
//! point = "/person.pose.position"
//! in_frame = "world"
//!
//! ["/robot_hand"]
//! position_of = "hand_link"
//! in_frame = "world"
//! ```
//!
//! # Entries
//! The key is the name of a signal, `/topic.field`, or, for what has several parts, the beginning
//! of their names. Each entry says in one of these ways where its values come from:
//!
//! | key | value | parts, unit unless given |
//! |---|---|---|
//! | `from` | `/topic.path` of one value | one |
//! | `norm` | `/topic.path` of something with x, y and z, or a list of paths of one topic | one |
//! | `point` | `/topic.path` of something with x, y and z, turned and shifted if `in_frame` is given | x, y, z in m |
//! | `vector` | the same, but only turned: a velocity, a force | x, y, z |
//! | `position_of` | the origin of this frame as seen from `in_frame`, from `/tf` | x, y, z in m |
//! | `orientation_of` | the rotation of this frame seen from `in_frame`, a quaternion | x, y, z, w in 1 |
//! | `distance_between` | the origins of these two frames | one, in m |
//! | `speed_of` | the origin of this frame seen from `in_frame`: distance by time between two neighbouring samples, at the later one | one, in m/s |
//!
//! And these say what the values mean:
//!
//! | key | meaning |
//! |---|---|
//! | `unit` | the unit of the values (after `scale` and `offset`) |
//! | `frame` | the frame in which they were recorded; with `in_frame`, the message's `header.frame_id` if not given |
//! | `in_frame` | the frame in which they are wanted |
//! | `kind` | `number` (the default) or `bool` |
//! | `values` | names: a recorded text is one of them, a recorded whole number counts them from 0 |
//! | `scale`, `offset` | a number v becomes scale * v + offset |
//! | `interpolation` | `hold` (the default): the last value counts; `linear`: between two samples |
//! | `staleness` | how long a value counts; older ones are missing. `linear` needs it: wider gaps are not bridged |
//!
//! Linear interpolation is by components, so it is wrong for angles that wrap around.
//!
//! # `[time]`
//! | key | meaning |
//! |---|---|
//! | `from` | which time counts, see [`TimeSource`](crate::TimeSource) |
//! | `reorder` | how much later than others a message may come to be still put in order (`1 s`) |
//! | `frame_wait` | how long to wait for a transform (`1 s`) |
//! | `frame_history` | how long transforms are kept (`10 s`) |
//! | `frame_gap` | the widest gap between two samples of a transform that is interpolated over; within a wider one it is missing (`1 s`) |
//!
//! Signals without an entry are looked up in the recording as they are written: `/topic.path`.

mod entry;
mod error;
mod parse;

pub use entry::{Interpolation, MappedSignal, SignalSource};
pub use error::TopicMapError;

use std::path::Path;

use crate::clock::TimeSettings;

/// A topic map.
///
/// ```
/// use recording::TopicMap;
/// let map = TopicMap::parse("topics.toml", r#"
/// ["/robot.speed"]
/// from = "/odom.twist.twist.linear.x"
/// unit = "m/s"
/// "#).map_err(|mut errors| errors.remove(0))?;
/// assert_eq!(map.signals[0].fields()[0].unit, "m/s");
///
/// let errors = TopicMap::parse("topics.toml", "[\"/robot.speed\"]\nform = \"/odom.x\"\n").unwrap_err();
/// assert!(errors[0].to_string().starts_with("topics.toml:2: "), "{}", errors[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TopicMap {
    /// Which time counts, and how long is waited.
    pub time: TimeSettings,
    /// The entries in the order of the file.
    pub signals: Vec<MappedSignal>,
}

impl TopicMap {
    /// Reads the map in the file at `path`.
    ///
    /// # Errors
    /// Every [`TopicMapError`] there is.
    pub fn read(path: &Path) -> Result<Self, Vec<TopicMapError>> {
        let name = path.display().to_string();
        match trace::read_text(path) {
            Ok(text) => TopicMap::parse(&name, &text),
            Err(error) => Err(vec![TopicMapError::unreadable(&name, &error)]),
        }
    }

    /// Takes a map from `text`; `name` stands for it in errors.
    ///
    /// # Errors
    /// Every [`TopicMapError`] there is.
    pub fn parse(name: &str, text: &str) -> Result<Self, Vec<TopicMapError>> {
        parse::parse(name, text)
    }

    /// The JSON Schema of the file.
    #[must_use]
    pub fn schema() -> schemars::Schema {
        parse::schema()
    }

    /// The entry that gives the signal `name`, and which of its parts it is.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<(&MappedSignal, usize)> {
        self.signals.iter().find_map(|entry| {
            let part = entry.part_names().iter().position(|part| part == name)?;
            Some((entry, part))
        })
    }

    /// The names of all signals, in the order of the file.
    pub fn signal_names(&self) -> impl Iterator<Item = String> {
        self.signals.iter().flat_map(MappedSignal::part_names)
    }
}
