//! Signals of a recording, one instant after another: what requirements are judged by.
//!
//! A [`SignalStream`] reads messages, decodes of them what the wanted signals need, puts them in
//! order of the chosen time ([`TimeSettings`](crate::TimeSettings)), looks up transforms,
//! interpolates, and gives at each instant a [`Snapshot`](trace::Snapshot) by which predicates are
//! evaluated. Only what waits to be put in order is in memory.
//!
//! # Instants
//! An instant is the time of one or more messages, or one nanosecond after a value has become too
//! old. Between two instants no value changes except those that are interpolated, which are then
//! known at the next instant.
//!
//! Messages of one topic with one time are samples of their own ([`Moment::more`]): the first ones of
//! all topics are taken together, then the second ones, and so on. A message is a sample of the signals
//! that it holds; one without the element that a signal is picked by (`velocity[name='wrist']`) is not
//! one of that signal's. [`SignalStream::sampled`] says of which signals an instant is a sample. Of
//! signals that are interpolated, the last of several samples of one time counts.
//!
//! # Times
//! Times from 10^8 s on (March 1973) are dates; their seconds are counted from the first message,
//! because a double holds the seconds since 1970 only to 2 * 10^-7 s. Smaller ones are kept.
//!
//! # Example
//! ```
//! # use recording::{Ros2Recording, Ros2Value, SignalStream, TopicMap, open, OpenOptions};
//! # let mut recording = Ros2Recording::new()?;
//! # let joints = recording.add_topic("/joint_states", "sensor_msgs/msg/JointState")?;
//! # for step in 0..3_i64 {
//! #     recording.write(joints, 1_000_000 * step, &[
//! #         ("name[0]", Ros2Value::Text("wrist")),
//! #         ("velocity[0]", Ros2Value::Number(0.1 * step as f64)),
//! #     ])?;
//! # }
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("run.mcap");
//! # std::fs::write(&path, recording.finish()?)?;
//! let map = TopicMap::parse("topics.toml", r#"
//! ["/robot.wrist_speed"]
//! from = "/joint_states.velocity[name='wrist']"
//! unit = "rad/s"
//! "#).map_err(|mut errors| errors.remove(0))?;
//! let reader = open(&path, &OpenOptions::default())?;
//! let mut stream = SignalStream::new(reader, &map, &[]).map_err(|mut errors| errors.remove(0))?;
//! let slow = trace::Predicate::parse("/robot.wrist_speed < 150 mrad/s")?.bind(stream.layout())?;
//! let mut judged = Vec::new();
//! while let Some(instant) = stream.next_instant()? {
//!     judged.push((instant.time_secs, slow.eval(stream.snapshot())));
//! }
//! assert_eq!(judged, [(0.0, Some(true)), (0.001, Some(true)), (0.002, Some(false))]);
//! assert!(stream.complete());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bind;
mod decode;
mod error;
mod frames;
mod linear;
mod plan;
mod report;
mod sequencer;
mod source;
mod stream;
mod taking;
mod tf_message;

pub(crate) use tf_message::transforms_of;

pub use bind::BindError;
pub use error::StreamError;
pub use report::{StreamNote, StreamNoteKind};
pub use stream::{Moment, Polled, SignalStream};
