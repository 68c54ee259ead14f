//! Publishing to a server that takes messages from its clients.

use super::FoxgloveOptions;
use super::protocol::{ClientChannel, FromServer, ToServer, client_message};
use super::socket::{self, Address, Socket};
use crate::clock::instant;
use crate::{LiveError, Outgoing, PublicationId, Publisher};
use tungstenite::Message as Frame;

/// A connection that publishes. The server must offer the capability `clientPublish`. A broken connection is made
/// again at the next message; that message is sent, those in between were not.
pub struct FoxglovePublisher {
    address: Address,
    options: FoxgloveOptions,
    socket: Option<Socket>,
    topics: Vec<Outgoing>,
    encodings: Vec<String>,
}

impl FoxglovePublisher {
    /// Connects to the server at `url`, as [`connect`](super::connect).
    ///
    /// # Errors
    /// When the server cannot be reached, says nothing about itself, or takes no messages.
    pub fn new(url: &str, options: &FoxgloveOptions) -> Result<Self, LiveError> {
        let mut publisher = Self {
            address: Address::parse(url)?,
            options: *options,
            socket: None,
            topics: Vec::new(),
            encodings: Vec::new(),
        };
        publisher.ensure_connected()?;
        Ok(publisher)
    }

    /// The socket, after connecting and announcing the topics if need be.
    fn ensure_connected(&mut self) -> Result<&mut Socket, LiveError> {
        if self.socket.is_none() {
            let mut socket = socket::open(&self.address, &self.options)?;
            self.encodings = self.greet(&mut socket)?;
            let text = announcement(&self.topics, 0);
            if !self.topics.is_empty() {
                let sent = socket.send(Frame::text(text));
                sent.map_err(|error| LiveError::Transport(error.to_string()))?;
            }
            self.socket = Some(socket);
        }
        self.socket
            .as_mut()
            .ok_or_else(|| LiveError::Transport("there is no connection".to_owned()))
    }

    /// Waits for the server's description of itself; gives the encodings it takes (none: any).
    fn greet(&self, socket: &mut Socket) -> Result<Vec<String>, LiveError> {
        let error = |reason: String| LiveError::Connect {
            to: self.address.url.clone(),
            reason,
        };
        let until = instant() + self.options.connect_timeout;
        while instant() < until {
            let frame = socket::read(socket).map_err(|broken| error(broken.to_string()))?;
            let Some(Frame::Text(text)) = frame else {
                continue;
            };
            if let Ok(FromServer::ServerInfo {
                capabilities,
                supported_encodings,
            }) = serde_json::from_str(text.as_str())
            {
                if capabilities.iter().any(|known| known == "clientPublish") {
                    return Ok(supported_encodings);
                }
                return Err(LiveError::Unsupported(format!(
                    "{} takes no messages from clients (capability clientPublish); allow it there",
                    self.address.url
                )));
            }
        }
        Err(error("it did not say what it is".to_owned()))
    }

    /// Reads away what the server sent, so that neither side is held up and pings are answered.
    fn read_away(&mut self) {
        let Some(socket) = self.socket.as_mut() else {
            return;
        };
        let mut broken = socket.get_ref().set_nonblocking(true).is_err();
        while !broken {
            match socket::read(socket) {
                Ok(Some(Frame::Close(_))) | Err(_) => broken = true,
                Ok(Some(_)) => {}
                Ok(None) => break,
            }
        }
        broken |= socket.get_ref().set_nonblocking(false).is_err();
        if broken {
            self.socket = None;
        }
    }

    fn send(&mut self, name: &str, frame: Frame) -> Result<(), LiveError> {
        self.read_away();
        let sent = self.ensure_connected()?.send(frame);
        sent.map_err(|error| {
            self.socket = None;
            LiveError::Send {
                topic: name.to_owned(),
                reason: error.to_string(),
            }
        })
    }
}

/// The announcement of topics, numbered from `first`.
fn announcement(topics: &[Outgoing], first: usize) -> String {
    let channels = topics.iter().zip(first..).map(|(topic, id)| {
        let schema = topic.schema.as_ref();
        ClientChannel {
            id: u32::try_from(id).unwrap_or(u32::MAX),
            topic: &topic.name,
            encoding: &topic.encoding,
            schema_name: &topic.type_name,
            schema_encoding: schema.map(|schema| schema.encoding.as_str()),
            schema: schema.and_then(|schema| std::str::from_utf8(&schema.data).ok()),
        }
    });
    ToServer::Advertise {
        channels: channels.collect(),
    }
    .text()
}

impl Publisher for FoxglovePublisher {
    fn advertise(&mut self, topic: &Outgoing) -> Result<PublicationId, LiveError> {
        let known = self.encodings.is_empty() || self.encodings.contains(&topic.encoding);
        if !known {
            return Err(LiveError::Unsupported(format!(
                "{} cannot be published as {}: the server takes {}",
                topic.name,
                topic.encoding,
                self.encodings.join(", ")
            )));
        }
        let text = announcement(std::slice::from_ref(topic), self.topics.len());
        self.send(&topic.name, Frame::text(text))?;
        self.topics.push(topic.clone());
        Ok(PublicationId(self.topics.len() - 1))
    }

    /// The protocol carries no stamp from a client: `publish_nanos` is not sent.
    fn publish(
        &mut self,
        publication: PublicationId,
        _publish_nanos: i64,
        data: &[u8],
    ) -> Result<(), LiveError> {
        let topic = self.topics.get(publication.0).ok_or_else(|| {
            LiveError::Option("this publication is of another publisher".to_owned())
        })?;
        let name = topic.name.clone();
        let channel = u32::try_from(publication.0).unwrap_or(u32::MAX);
        self.send(&name, Frame::binary(client_message(channel, data)))
    }
}

impl Drop for FoxglovePublisher {
    fn drop(&mut self) {
        if let Some(socket) = self.socket.as_mut() {
            let _ = socket.close(None);
            let _ = socket.flush();
        }
    }
}
