//! Foxglove WebSocket: the protocol that bridges, simulators and robots offer to viewers.
//!
//! Source: the protocol's specification (subprotocols `foxglove.websocket.v1` and `foxglove.sdk.v1`, which agree in
//! all that is used here). The server names its channels with their types' definitions; messages of those that are
//! subscribed to come as binary frames with the server's time. A broken connection is made again, waiting longer after
//! each failure, and every wanted topic is subscribed to again.
//!
//! Limits: messages are not numbered, so a server that leaves out messages for a slow reader cannot be found out
//! ([`Topic::numbered`](crate::Topic::numbered) is false); `wss://` (encrypted) is not spoken.

mod base64;
mod channels;
mod client;
mod protocol;
mod publisher;
mod socket;

pub use publisher::FoxglovePublisher;

use crate::clock::Clock;
use crate::queue::Queue;
use crate::{Event, LiveError, LiveStream, QueueLimits, TopicFilter};
use std::sync::Arc;
use std::time::Duration;

/// How to keep a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FoxgloveOptions {
    /// How long a connection may take to be made.
    pub connect_timeout: Duration,
    /// After how long without any sign from the server, though it was asked for one, the connection counts as broken.
    pub silence_limit: Duration,
    /// The first wait before a broken connection is made again; it doubles with each failure up to `longest_wait`.
    pub first_wait: Duration,
    /// The longest wait between attempts.
    pub longest_wait: Duration,
    /// The largest message taken, in bytes; a larger one ends the connection.
    pub largest_message: usize,
    /// How much may wait to be taken.
    pub queue: QueueLimits,
}

impl Default for FoxgloveOptions {
    /// 5 s to connect, 10 s of silence, waits of 0.1 s to 5 s, messages of up to 64 MiB.
    fn default() -> Self {
        Self {
            connect_timeout: Duration::from_secs(5),
            silence_limit: Duration::from_secs(10),
            first_wait: Duration::from_millis(100),
            longest_wait: Duration::from_secs(5),
            largest_message: 64 << 20,
            queue: QueueLimits::default(),
        }
    }
}

/// Listens to the wanted topics of a server at `url` (`ws://host:8765`). The first connection is made before this
/// returns; later ones by themselves.
///
/// # Errors
/// When the address is no `ws://` address or the server cannot be reached or does not speak the protocol.
///
/// ```no_run
/// use live::{Incoming, Source, TopicFilter, foxglove};
/// use std::time::Duration;
///
/// let options = foxglove::FoxgloveOptions::default();
/// let mut source = foxglove::connect("ws://localhost:8765", TopicFilter::all(), &options)?;
/// while let Some(incoming) = source.next(Duration::from_secs(10))? {
///     if let Incoming::Message(message) = incoming {
///         println!("{}: {} bytes of {}", message.topic.name, message.data.len(), message.topic.encoding);
///     }
/// }
/// # Ok::<(), live::LiveError>(())
/// ```
pub fn connect(
    url: &str,
    filter: TopicFilter,
    options: &FoxgloveOptions,
) -> Result<LiveStream, LiveError> {
    let address = socket::Address::parse(url)?;
    let socket = socket::open(&address, options)?;
    let queue = Arc::new(Queue::new(options.queue, Clock::start()));
    queue.push_event(Event::Connected { to: url.to_owned() });
    let options = *options;
    LiveStream::start("live-foxglove", queue, move |outlet| {
        client::listen(&outlet, socket, &address, filter, &options);
    })
}
