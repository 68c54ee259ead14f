//! ROS 2 (and plain DDS) without ROS: a participant of the domain that listens or publishes.
//!
//! Discovery finds the writers of the wanted topics; for each topic one reader is made whose quality of service fits
//! all of them. Messages are handed out as the bytes that were published: DDS carries no definition of a type, so
//! decoding needs one from elsewhere (a table of known types, message files). Numbers of messages are checked for each
//! writer, so that every message that did not arrive is counted.
//!
//! Limits: topics with a key are read without it (ROS 2 has none); a topic of two types is listened to in the type
//! that was seen first; DDS Security is not spoken.

mod listener;
mod names;
mod publisher;
mod quality;
mod raw;
mod reader;
mod sequence;
mod session;
mod stamp;

pub use publisher::DdsPublisher;

use crate::clock::Clock;
use crate::queue::Queue;
use crate::{LiveError, LiveStream, QueueLimits, TopicFilter};
use rustdds::{DomainParticipant, DomainParticipantBuilder};
use std::net::IpAddr;
use std::sync::Arc;

/// How to join a domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DdsOptions {
    /// The domain, 0 to 232 (`ROS_DOMAIN_ID`).
    pub domain: u16,
    /// The addresses of this machine whose networks are used; empty for all.
    pub networks: Vec<IpAddr>,
    /// How much may wait to be taken.
    pub queue: QueueLimits,
}

impl Default for DdsOptions {
    /// Domain 0 on all networks.
    fn default() -> Self {
        Self {
            domain: 0,
            networks: Vec::new(),
            queue: QueueLimits::default(),
        }
    }
}

/// Listens to the wanted topics of a domain. Topics are found as they appear, now or later.
///
/// # Errors
/// When the domain is no domain or no participant can be made (no network, no free port).
///
/// ```no_run
/// use live::{Incoming, Source, TopicFilter, dds};
/// use std::time::Duration;
///
/// let filter = TopicFilter::new(&["/joint_states", "/tf*"], &[]);
/// let mut source = dds::connect(&dds::DdsOptions::default(), filter)?;
/// loop {
///     match source.next(Duration::from_secs(1))? {
///         Some(Incoming::Message(message)) => println!("{} {}", message.topic.name, message.received_nanos),
///         Some(Incoming::Event { event, .. }) => println!("{event:?}"),
///         None => println!("nothing for a second"),
///     }
/// }
/// # #[allow(unreachable_code)]
/// # Ok::<(), live::LiveError>(())
/// ```
pub fn connect(options: &DdsOptions, filter: TopicFilter) -> Result<LiveStream, LiveError> {
    let session = session::Session::join(options)?;
    let queue = Arc::new(Queue::new(options.queue, Clock::start()));
    let options = options.clone();
    LiveStream::start("live-dds", queue, move |outlet| {
        listener::listen(&outlet, session, filter, options);
    })
}

/// Makes a participant.
fn join(options: &DdsOptions) -> Result<DomainParticipant, LiveError> {
    if options.domain > 232 {
        return Err(LiveError::Option(format!(
            "DDS domain {} does not exist: domains are 0 to 232",
            options.domain
        )));
    }
    let mut builder = DomainParticipantBuilder::new(options.domain);
    if !options.networks.is_empty() {
        builder = builder.with_only_networks(options.networks.iter().copied());
    }
    builder.build().map_err(|error| LiveError::Connect {
        to: format!("DDS domain {}", options.domain),
        reason: error.to_string(),
    })
}
