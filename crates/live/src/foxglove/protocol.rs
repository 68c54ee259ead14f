//! What goes over the wire: texts are JSON with the member `op`, binary frames begin with a byte that says what they are.

use crate::SchemaText;
use serde::{Deserialize, Serialize};

/// The subprotocols that are understood, in the order of preference.
pub(super) const SUBPROTOCOLS: &str = "foxglove.sdk.v1, foxglove.websocket.v1";

/// What a server says in text. Members and operations that are not used are passed over.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum FromServer {
    /// The first thing it says.
    #[serde(rename_all = "camelCase")]
    ServerInfo {
        /// What it can do beyond sending messages.
        #[serde(default)]
        capabilities: Vec<String>,
        /// The encodings it takes from clients.
        #[serde(default)]
        supported_encodings: Vec<String>,
    },
    /// Something went wrong or is worth knowing.
    Status {
        /// 0: information, 1: warning, 2: error.
        #[serde(default)]
        level: u8,
        /// What.
        #[serde(default)]
        message: String,
    },
    /// New channels.
    Advertise {
        /// The channels.
        channels: Vec<Channel>,
    },
    /// Channels that are no more.
    #[serde(rename_all = "camelCase")]
    Unadvertise {
        /// Their numbers.
        channel_ids: Vec<u32>,
    },
    /// What is not used here.
    #[serde(other)]
    Other,
}

/// A channel: one topic in one encoding.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Channel {
    pub(super) id: u32,
    pub(super) topic: String,
    pub(super) encoding: String,
    #[serde(default)]
    pub(super) schema_name: String,
    #[serde(default)]
    pub(super) schema: String,
    #[serde(default)]
    pub(super) schema_encoding: Option<String>,
}

impl Channel {
    /// The definition of the type; `None` if there is none, or it is not what its encoding says.
    pub(super) fn schema_text(&self) -> Option<SchemaText> {
        if self.schema.is_empty() {
            return None;
        }
        let encoding = self.schema_encoding.clone();
        let encoding = encoding.unwrap_or_else(|| default_schema_encoding(&self.encoding));
        // Binary definitions are sent in base 64, the others as they are.
        let data = match encoding.as_str() {
            "protobuf" | "flatbuffer" => super::base64::decode(&self.schema)?,
            _ => self.schema.clone().into_bytes(),
        };
        Some(SchemaText { encoding, data })
    }
}

/// The definition's language where the server does not say it.
fn default_schema_encoding(encoding: &str) -> String {
    match encoding {
        "json" => "jsonschema",
        "ros1" => "ros1msg",
        "cdr" => "ros2msg",
        other => other,
    }
    .to_owned()
}

/// What a client says in text.
#[derive(Debug, Serialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum ToServer<'a> {
    /// Asks for the messages of channels.
    Subscribe { subscriptions: Vec<Subscription> },
    /// Announces a channel of the client.
    Advertise { channels: Vec<ClientChannel<'a>> },
}

/// A wish for a channel's messages, under a number of the client.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    pub(super) id: u32,
    pub(super) channel_id: u32,
}

/// A channel of the client.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ClientChannel<'a> {
    pub(super) id: u32,
    pub(super) topic: &'a str,
    pub(super) encoding: &'a str,
    pub(super) schema_name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) schema_encoding: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) schema: Option<&'a str>,
}

impl ToServer<'_> {
    /// The text to send. Nothing in it can fail to be written as JSON.
    pub(super) fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A message in a binary frame of the server.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct MessageData<'a> {
    pub(super) subscription: u32,
    pub(super) nanos: u64,
    pub(super) payload: &'a [u8],
}

/// Reads a binary frame: `Ok(None)` for one that carries no message, `Err` for one that is cut short.
pub(super) fn message_data(frame: &[u8]) -> Result<Option<MessageData<'_>>, &'static str> {
    match frame {
        [1, rest @ ..] => {
            let cut_short = "a message of the server is shorter than its header";
            let (subscription, rest) = rest.split_first_chunk().ok_or(cut_short)?;
            let (nanos, payload) = rest.split_first_chunk().ok_or(cut_short)?;
            Ok(Some(MessageData {
                subscription: u32::from_le_bytes(*subscription),
                nanos: u64::from_le_bytes(*nanos),
                payload,
            }))
        }
        [_, ..] => Ok(None),
        [] => Err("a binary frame of the server is empty"),
    }
}

/// A binary frame with a message of the client.
pub(super) fn client_message(channel: u32, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(payload.len() + 5);
    frame.push(1);
    frame.extend_from_slice(&channel.to_le_bytes());
    frame.extend_from_slice(payload);
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> FromServer {
        serde_json::from_str(text).expect("understood")
    }

    #[test]
    fn texts_of_a_server_are_understood_as_far_as_they_are_used() {
        let info = read(
            r#"{"op":"serverInfo","name":"x","capabilities":["clientPublish"],"supportedEncodings":["cdr"],"metadata":{}}"#,
        );
        assert!(
            matches!(info, FromServer::ServerInfo { capabilities, supported_encodings }
                if capabilities == ["clientPublish"] && supported_encodings == ["cdr"])
        );
        assert!(matches!(
            read(r#"{"op":"connectionGraphUpdate","x":[1]}"#),
            FromServer::Other
        ));
        assert!(matches!(
            read(r#"{"op":"unadvertise","channelIds":[1,2]}"#),
            FromServer::Unadvertise { channel_ids } if channel_ids == [1, 2]
        ));
    }

    #[test]
    fn definitions_are_text_or_base_64() {
        let text = r#"{"op":"advertise","channels":[
            {"id":1,"topic":"/a","encoding":"protobuf","schemaName":"m","schemaEncoding":"protobuf","schema":"AQI="},
            {"id":2,"topic":"/b","encoding":"cdr","schemaName":"n","schema":"bool x"},
            {"id":3,"topic":"/c","encoding":"json","schemaName":"","schema":""}]}"#;
        let FromServer::Advertise { channels } = read(text) else {
            panic!("no channels");
        };
        let schema = |i: usize| channels[i].schema_text().map(|s| (s.encoding, s.data));
        assert_eq!(schema(0), Some(("protobuf".into(), vec![1, 2])));
        assert_eq!(schema(1), Some(("ros2msg".into(), b"bool x".to_vec())));
        assert_eq!(schema(2), None);
    }

    #[test]
    fn frames_are_read_and_those_cut_short_refused() {
        let mut frame = vec![1, 7, 0, 0, 0];
        frame.extend_from_slice(&5_u64.to_le_bytes());
        frame.extend_from_slice(b"ab");
        let expected = MessageData {
            subscription: 7,
            nanos: 5,
            payload: b"ab",
        };
        assert_eq!(message_data(&frame), Ok(Some(expected)));
        assert_eq!(message_data(&[2, 0]), Ok(None));
        for length in [0, 1, 4, 12] {
            assert!(message_data(&frame[..length]).is_err(), "{length}");
        }
        assert!(matches!(message_data(&frame[..13]), Ok(Some(m)) if m.payload.is_empty()));
    }

    #[test]
    fn texts_of_a_client_have_the_names_of_the_protocol() {
        let subscriptions = vec![Subscription {
            id: 1,
            channel_id: 2,
        }];
        assert_eq!(
            ToServer::Subscribe { subscriptions }.text(),
            r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":2}]}"#
        );
        let channels = vec![ClientChannel {
            id: 3,
            topic: "/t",
            encoding: "json",
            schema_name: "s",
            schema_encoding: None,
            schema: None,
        }];
        assert_eq!(
            ToServer::Advertise { channels }.text(),
            r#"{"op":"advertise","channels":[{"id":3,"topic":"/t","encoding":"json","schemaName":"s"}]}"#
        );
    }
}
