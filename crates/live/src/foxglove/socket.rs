//! The connection: address, handshake, and reading with a limit on the time.

use super::FoxgloveOptions;
use super::protocol::SUBPROTOCOLS;
use crate::LiveError;
use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

/// How long one reading waits; a stop and the pings wait for it at most.
const READ_AT_MOST: Duration = Duration::from_millis(20);
/// How long one writing waits.
const WRITE_AT_MOST: Duration = Duration::from_secs(5);

/// A connection to a server.
pub(super) type Socket = WebSocket<TcpStream>;

/// Where a server is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Address {
    /// As it was given.
    pub(super) url: String,
    /// `host:port`.
    authority: String,
}

impl Address {
    pub(super) fn parse(url: &str) -> Result<Self, LiveError> {
        let Some(rest) = url.strip_prefix("ws://") else {
            return Err(LiveError::Option(format!(
                "the address of a Foxglove WebSocket must begin with ws://, such as ws://localhost:8765 (got {url}; for wss:// put a tunnel or proxy before it)"
            )));
        };
        let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
        let port = authority.rsplit_once(':').map(|(_, port)| port);
        let has_port = port.is_some_and(|port| port.parse::<u16>().is_ok());
        if authority.is_empty() || authority.starts_with(':') || authority.contains('@') {
            return Err(LiveError::Option(format!("{url} names no host")));
        }
        let authority = if has_port {
            authority.to_owned()
        } else {
            format!("{authority}:80")
        };
        Ok(Self {
            url: url.to_owned(),
            authority,
        })
    }

    fn error(&self, reason: impl ToString) -> LiveError {
        LiveError::Connect {
            to: self.url.clone(),
            reason: reason.to_string(),
        }
    }
}

/// Makes a connection.
pub(super) fn open(address: &Address, options: &FoxgloveOptions) -> Result<Socket, LiveError> {
    let stream = reach(address, options.connect_timeout)?;
    let prepared = stream
        .set_nodelay(true)
        .and_then(|()| stream.set_read_timeout(Some(options.connect_timeout)))
        .and_then(|()| stream.set_write_timeout(Some(WRITE_AT_MOST)));
    prepared.map_err(|error| address.error(error))?;
    let mut request = address
        .url
        .as_str()
        .into_client_request()
        .map_err(|error| address.error(error))?;
    request.headers_mut().insert(
        "Sec-WebSocket-Protocol",
        HeaderValue::from_static(SUBPROTOCOLS),
    );
    let config = WebSocketConfig::default()
        .max_message_size(Some(options.largest_message))
        .max_frame_size(Some(options.largest_message));
    let (socket, _) = tungstenite::client::client_with_config(request, stream, Some(config))
        .map_err(|error| match error {
            HandshakeError::Failure(error) => address.error(error),
            HandshakeError::Interrupted(_) => address.error("it did not answer in time"),
        })?;
    let limited = socket.get_ref().set_read_timeout(Some(READ_AT_MOST));
    limited.map_err(|error| address.error(error))?;
    Ok(socket)
}

/// Reaches one of the machine's addresses.
fn reach(address: &Address, timeout: Duration) -> Result<TcpStream, LiveError> {
    let found = address.authority.to_socket_addrs();
    let found = found.map_err(|error| address.error(error))?;
    let mut last = address.error("its name has no address");
    for target in found {
        match TcpStream::connect_timeout(&target, timeout) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = address.error(error),
        }
    }
    Err(last)
}

/// The next message, or `None` if none came in a short while.
pub(super) fn read(socket: &mut Socket) -> Result<Option<Message>, Error> {
    match socket.read() {
        Ok(message) => {
            acknowledge_at_once(socket.get_ref());
            Ok(Some(message))
        }
        Err(Error::Io(error)) if waits(error.kind()) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Many servers send small messages only when the one before was acknowledged, and the system waits up to 40 ms with
/// that. The wish holds for a while only, so it is repeated. If it cannot be had, messages merely come later.
#[cfg(target_os = "linux")]
fn acknowledge_at_once(stream: &TcpStream) {
    let _ = rustix::net::sockopt::set_tcp_quickack(stream, true);
}

/// Other systems have no such wish.
#[cfg(not(target_os = "linux"))]
fn acknowledge_at_once(_stream: &TcpStream) {}

fn waits(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_a_port() {
        let authority = |url: &str| Address::parse(url).map(|address| address.authority);
        assert_eq!(authority("ws://robot:8765"), Ok("robot:8765".into()));
        assert_eq!(authority("ws://robot/path?x=1"), Ok("robot:80".into()));
        assert_eq!(authority("ws://[::1]:9"), Ok("[::1]:9".into()));
        assert_eq!(authority("ws://[::1]"), Ok("[::1]:80".into()));
        for wrong in ["wss://robot", "robot:8765", "ws://", "ws://:80", "ws://a@b"] {
            assert!(
                matches!(authority(wrong), Err(LiveError::Option(_))),
                "{wrong}"
            );
        }
    }
}
