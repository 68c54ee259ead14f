//! Attach to a running system without installing its software.
//!
//! A running robot is listened to over **DDS** (ROS 2, [`dds`]) or a **Foxglove WebSocket** ([`foxglove`]). Both give
//! a [`Source`]: one stream of raw messages, each with its topic, the publisher's time and the time of arrival, and of
//! events: topics that appear, messages that were lost, connections that broke and came back. Messages are not decoded
//! here; [`Topic::info`] describes a topic for [`recording::Extractor`].
//!
//! The way back is a [`Publisher`]; a [`Bridge`] joins both, so that a robot's part runs in the loop with a simulated
//! rest: some topics come from outside, some from the test bench, paced by the wall clock, all in one stream
//! ([`LiveStream::of_bench`] runs it in a thread).
//!
//! ```
//! use live::{Incoming, Outgoing, Publisher, Source, TopicFilter, dds};
//! use std::time::Duration;
//!
//! let options = dds::DdsOptions { domain: 100, ..Default::default() };
//! let mut source = dds::connect(&options, TopicFilter::new(&["/speed"], &[]))?;
//!
//! // Elsewhere: a robot, here a publisher of our own.
//! let mut robot = dds::DdsPublisher::new(&options)?;
//! let speed = robot.advertise(&Outgoing::ros2("/speed", "std_msgs/msg/Float64"))?;
//! let mut data = vec![0, 1, 0, 0]; // little-endian CDR
//! data.extend_from_slice(&0.25_f64.to_le_bytes());
//!
//! // What is sent before both have found each other is not heard.
//! let message = loop {
//!     robot.publish(speed, 1_000, &data)?;
//!     if let Some(Incoming::Message(message)) = source.next(Duration::from_millis(10))? {
//!         break message;
//!     }
//! };
//! assert_eq!(message.topic.type_name, "std_msgs/msg/Float64");
//! assert_eq!(message.publish_nanos, Some(1_000));
//! assert_eq!(message.data, data);
//! # Ok::<(), live::LiveError>(())
//! ```

mod bridge;
mod bridge_stream;
mod clock;
pub mod dds;
mod described;
mod error;
pub mod foxglove;
mod pace;
mod publish;
mod queue;
mod source;
mod stream;
mod topic;

pub use bridge::Bridge;
pub use bridge_stream::BridgeFeed;
pub use clock::Clock;
pub use error::LiveError;
pub use pace::{Pacer, Punctuality};
pub use publish::{Outgoing, PublicationId, Publisher};
pub use queue::QueueLimits;
pub use source::{Event, Incoming, LossCause, Message, Source, Totals};
pub use stream::LiveStream;
pub use topic::{Durability, Origin, Qos, Reliability, SchemaText, Topic, TopicFilter};
