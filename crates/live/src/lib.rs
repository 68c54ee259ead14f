#![doc = include_str!("../README.md")]
//!
//! The way back is a [`Publisher`]; a [`Bridge`] joins both, so that a robot's part runs in the loop with a simulated
//! rest: some topics come from outside, some from the test bench, paced by the wall clock, all in one stream
//! ([`LiveStream::of_bench`] runs it in a thread).

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
