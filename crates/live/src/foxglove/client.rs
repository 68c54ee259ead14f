//! The listening thread: reads a connection while it lasts, then makes it again.

use super::FoxgloveOptions;
use super::channels::Channels;
use super::protocol::{self, FromServer, ToServer};
use super::socket::{self, Address, Socket};
use crate::clock::instant;
use crate::stream::Outlet;
use crate::{Event, LossCause, Message, TopicFilter};
use std::time::{Duration, Instant};
use tungstenite::Message as Frame;

/// How long to sleep at most before looking whether to stop.
const SLEEP_AT_MOST: Duration = Duration::from_millis(20);

/// Listens until the outlet is stopped.
pub(super) fn listen(
    outlet: &Outlet,
    mut socket: Socket,
    address: &Address,
    filter: TopicFilter,
    options: &FoxgloveOptions,
) {
    let mut channels = Channels::new(filter);
    loop {
        let reason = Session::new(outlet, &mut socket, &mut channels, options).run();
        let Some(reason) = reason else {
            close(&mut socket);
            return;
        };
        let since = outlet.queue.clock.now_nanos();
        channels.forget_connection(&outlet.queue);
        outlet.queue.push_event(Event::Disconnected {
            topic: None,
            reason,
        });
        // Before the new one is made: a server that serves one client at a time waits for the end of the old one.
        drop(socket);
        let Some(again) = reconnect(outlet, address, options) else {
            return;
        };
        socket = again;
        outlet.queue.push_event(Event::Reconnected {
            topic: None,
            away_nanos: outlet.queue.clock.now_nanos() - since,
        });
    }
}

/// Says goodbye. If that fails the connection is gone anyway.
fn close(socket: &mut Socket) {
    let _ = socket.close(None);
    let _ = socket.flush();
}

/// Tries to connect until it succeeds; `None` if stopped. The wait doubles with each failure.
fn reconnect(outlet: &Outlet, address: &Address, options: &FoxgloveOptions) -> Option<Socket> {
    let mut wait = options.first_wait;
    loop {
        let until = instant() + wait;
        while instant() < until {
            if outlet.stopped() {
                return None;
            }
            std::thread::sleep(SLEEP_AT_MOST.min(wait));
        }
        if let Ok(socket) = socket::open(address, options) {
            return Some(socket);
        }
        wait = wait.saturating_mul(2).min(options.longest_wait);
    }
}

/// One connection while it lasts.
struct Session<'a> {
    outlet: &'a Outlet,
    socket: &'a mut Socket,
    channels: &'a mut Channels,
    silence_limit: Duration,
    heard_at: Instant,
    pinged_at: Instant,
}

impl<'a> Session<'a> {
    fn new(
        outlet: &'a Outlet,
        socket: &'a mut Socket,
        channels: &'a mut Channels,
        options: &FoxgloveOptions,
    ) -> Self {
        let now = instant();
        Self {
            outlet,
            socket,
            channels,
            silence_limit: options.silence_limit,
            heard_at: now,
            pinged_at: now,
        }
    }

    /// Reads until the connection breaks, and says why; `None` if stopped.
    fn run(mut self) -> Option<String> {
        while !self.outlet.stopped() {
            match socket::read(self.socket) {
                Ok(Some(frame)) => {
                    self.heard_at = instant();
                    if let Err(reason) = self.take(&frame) {
                        return Some(reason);
                    }
                }
                Ok(None) => {}
                Err(error) => return Some(error.to_string()),
            }
            if let Err(reason) = self.stay_in_touch() {
                return Some(reason);
            }
        }
        None
    }

    /// Asks for a sign of life now and then, and gives up if none comes.
    fn stay_in_touch(&mut self) -> Result<(), String> {
        let now = instant();
        if now - self.heard_at >= self.silence_limit {
            return Err(format!(
                "nothing was heard for {} s, though the server was asked",
                self.silence_limit.as_secs_f64()
            ));
        }
        let quarter = self.silence_limit / 4;
        if now - self.heard_at >= quarter && now - self.pinged_at >= quarter {
            self.pinged_at = now;
            self.send(Frame::Ping(Vec::new().into()))?;
        }
        Ok(())
    }

    fn send(&mut self, frame: Frame) -> Result<(), String> {
        self.socket.send(frame).map_err(|error| error.to_string())
    }

    fn take(&mut self, frame: &Frame) -> Result<(), String> {
        match frame {
            Frame::Text(text) => self.take_text(text.as_str()),
            Frame::Binary(bytes) => {
                self.take_binary(bytes);
                Ok(())
            }
            Frame::Close(_) => Err("the server closed it".to_owned()),
            Frame::Ping(_) | Frame::Pong(_) | Frame::Frame(_) => Ok(()),
        }
    }

    fn take_text(&mut self, text: &str) -> Result<(), String> {
        let queue = &self.outlet.queue;
        match serde_json::from_str(text) {
            Ok(FromServer::Advertise { channels }) => {
                let subscriptions = self.channels.advertised(&channels, queue);
                if !subscriptions.is_empty() {
                    let text = ToServer::Subscribe { subscriptions }.text();
                    self.send(Frame::text(text))?;
                }
            }
            Ok(FromServer::Unadvertise { channel_ids }) => {
                self.channels.unadvertised(&channel_ids, queue);
            }
            Ok(FromServer::Status { level, message }) if level > 0 => {
                let text = format!("the server says: {message}");
                queue.push_event(Event::Notice { text });
            }
            Ok(_) => {}
            Err(error) => {
                let text = format!("a text of the server is not understood: {error}");
                queue.push_event(Event::Notice { text });
            }
        }
        Ok(())
    }

    fn take_binary(&mut self, bytes: &[u8]) {
        let queue = &self.outlet.queue;
        match protocol::message_data(bytes) {
            Ok(Some(data)) => {
                // After taking a subscription back, messages under way may still come.
                if let Some(topic) = self.channels.topic(data.subscription) {
                    queue.push_message(Message {
                        topic: topic.clone(),
                        publish_nanos: i64::try_from(data.nanos).ok(),
                        received_nanos: queue.clock.now_nanos(),
                        sequence: None,
                        data: data.payload.to_vec(),
                    });
                }
            }
            Ok(None) => {}
            Err(_) => queue.push_event(Event::Lost {
                topic: None,
                count: 1,
                cause: LossCause::Undecodable,
            }),
        }
    }
}
