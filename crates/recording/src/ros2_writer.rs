//! Recordings in the message types of ROS 2, as a real robot would leave them.
//!
//! # Format
//! MCAP with the profile `ros2`: schemas in `ros2msg` text, messages in CDR (little endian, the
//! first version of XCDR, OMG "DDS-XTYPES" 1.3, section 7.4), which is what `ros2 bag record`
//! writes. A message begins with the four bytes 00 01 00 00; behind them each number is aligned to
//! its own size; a string is its length with the final zero, the bytes and the zero; a sequence is
//! its length and its elements.
//!
//! # Two ways in
//! [`Ros2Recording`] takes messages one by one, field by field. [`ros2_recording_of`] takes a
//! [`Trace`](trace::Trace) and a table of [`Ros2Topic`]s that says which signal goes into which
//! field of which message, and writes one message for each row.
//!
//! Fields are named by paths, `pose.position.x` or `transforms[0].child_frame_id`; a sequence is as
//! long as the highest index that is named; what is not named is 0, false or empty.
//!
//! # Guarantees
//! The same input gives the same bytes. A number that its field cannot hold exactly as an integer
//! is refused, never wrapped.
//!
//! # Example
//! ```
//! use recording::{Ros2Recording, Ros2Value};
//! let mut recording = Ros2Recording::new()?;
//! let joints = recording.add_topic("/joint_states", "sensor_msgs/msg/JointState")?;
//! recording.write(joints, 1_500_000_000, &[
//!     ("header.stamp", Ros2Value::Nanos(1_500_000_000)),
//!     ("name[0]", Ros2Value::Text("wrist")),
//!     ("position[0]", Ros2Value::Number(0.25)),
//! ])?;
//! let bytes = recording.finish()?;
//! assert!(bytes.starts_with(b"\x89MCAP0\r\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod definitions;
mod encode;
mod error;
mod mapping;
mod writer;

pub use definitions::ros2_type_names;
pub use encode::Ros2Value;
pub use error::Ros2WriteError;
pub use mapping::{
    Ros2Encoder, Ros2Source, Ros2Topic, Ros2TraceOptions, Ros2TraceOutcome, ros2_recording_of,
};
pub use writer::{Ros2Recording, Ros2TopicId};
