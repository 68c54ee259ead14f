//! A live topic as the recordings' decoder knows topics, so that live and recorded messages are decoded alike.
//!
//! A Foxglove server sends the definitions of its types. DDS carries none: they come from the caller, for example from a
//! table of known types or from message files.

use crate::{SchemaText, Topic};
use recording::{
    Dialect, Encoding, ProtobufSchema, Schema, SchemaError, TopicId, TopicInfo, parse_idl,
    parse_msg,
};
use std::sync::Arc;

impl Topic {
    /// The topic for [`recording::Extractor`]. Where the transport carried no definition, `definition` is asked for
    /// that of the type; a type without one gets [`Schema::Unknown`] with the reason.
    ///
    /// ```
    /// # let topic = live::Topic {
    /// #     id: 0, name: "/speed".into(), type_name: "std_msgs/msg/Float64".into(), encoding: "cdr".into(), schema: None,
    /// #     qos: None, type_hash: None, origin: live::Origin::Outside, numbered: true,
    /// # };
    /// let definition = |type_name: &str| {
    ///     (type_name == "std_msgs/msg/Float64").then(|| live::SchemaText {
    ///         encoding: "ros2msg".into(),
    ///         data: b"float64 data".to_vec(),
    ///     })
    /// };
    /// let paths = [recording::FieldPath::parse("data")?];
    /// let mut extractor = recording::Extractor::new(&topic.info(&definition), &paths)?;
    /// let mut values = [0.0];
    /// extractor.extract(&[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f], &mut values)?;
    /// assert_eq!(values, [1.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn info(&self, definition: &dyn Fn(&str) -> Option<SchemaText>) -> TopicInfo {
        let encoding = encoding(&self.encoding);
        let schema = match self.schema.clone().or_else(|| definition(&self.type_name)) {
            _ if encoding == Encoding::Json => Schema::Schemaless,
            Some(text) => understood(&self.type_name, &text),
            None => Schema::Unknown {
                reason: format!("there is no definition of its type {}", self.type_name),
            },
        };
        TopicInfo {
            id: TopicId(self.id),
            name: self.name.clone(),
            type_name: self.type_name.clone(),
            encoding,
            schema: Arc::new(schema),
            message_count: None,
        }
    }
}

fn encoding(name: &str) -> Encoding {
    match name {
        "cdr" => Encoding::Cdr,
        "ros1" => Encoding::Ros1,
        "json" => Encoding::Json,
        "protobuf" => Encoding::Protobuf,
        other => Encoding::Unknown(other.to_owned()),
    }
}

/// The definition as a schema, by its language.
fn understood(type_name: &str, text: &SchemaText) -> Schema {
    let read = |parse: &dyn Fn(&str) -> Result<Schema, SchemaError>| {
        std::str::from_utf8(&text.data)
            .map_err(|_| "it is not UTF-8".to_owned())
            .and_then(|text| parse(text).map_err(|error| error.to_string()))
    };
    let schema = match text.encoding.as_str() {
        "ros2msg" => read(&|t| parse_msg(type_name, t, Dialect::Ros2).map(Schema::Struct)),
        "ros1msg" => read(&|t| parse_msg(type_name, t, Dialect::Ros1).map(Schema::Struct)),
        "ros2idl" => read(&|t| parse_idl(type_name, t).map(Schema::Struct)),
        "jsonschema" => Ok(Schema::Schemaless),
        "protobuf" => ProtobufSchema::parse(type_name, &text.data)
            .map(Schema::Protobuf)
            .map_err(|error| error.to_string()),
        other => Err(format!("definitions in {other} are not supported")),
    };
    schema.unwrap_or_else(|error| Schema::Unknown {
        reason: format!("the definition of its type {type_name} cannot be understood: {error}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Origin;

    fn topic(encoding: &str, schema: Option<(&str, &[u8])>) -> Topic {
        Topic {
            id: 3,
            name: "/t".into(),
            type_name: "p/msg/T".into(),
            encoding: encoding.into(),
            schema: schema.map(|(encoding, data)| SchemaText {
                encoding: encoding.into(),
                data: data.to_vec(),
            }),
            qos: None,
            type_hash: None,
            origin: Origin::Outside,
            numbered: false,
        }
    }

    fn none(_: &str) -> Option<SchemaText> {
        None
    }

    #[test]
    fn definitions_are_read_in_their_language() {
        let info = topic("cdr", Some(("ros2msg", b"float64 x"))).info(&none);
        assert_eq!((info.id, info.encoding), (TopicId(3), Encoding::Cdr));
        assert!(matches!(&*info.schema, Schema::Struct(message) if message.field("x").is_some()));
        let info = topic("json", None).info(&none);
        assert_eq!(*info.schema, Schema::Schemaless);
        let info = topic("cdr", None).info(&|name| {
            assert_eq!(name, "p/msg/T");
            Some(SchemaText {
                encoding: "ros2msg".into(),
                data: b"bool y".to_vec(),
            })
        });
        assert!(matches!(&*info.schema, Schema::Struct(message) if message.field("y").is_some()));
    }

    #[test]
    fn what_is_not_understood_is_unknown_with_the_reason() {
        for (encoding, schema, expected) in [
            ("cdr", None, "no definition of its type p/msg/T"),
            (
                "cdr",
                Some(("ros2msg", &b"nonsense!"[..])),
                "cannot be understood",
            ),
            ("cdr", Some(("ros2msg", &[0xff, 0xfe][..])), "not UTF-8"),
            (
                "flatbuffer",
                Some(("flatbuffer", &b""[..])),
                "not supported",
            ),
        ] {
            let info = topic(encoding, schema).info(&none);
            let Schema::Unknown { reason } = &*info.schema else {
                panic!("{:?}", info.schema);
            };
            assert!(reason.contains(expected), "{reason}");
        }
    }
}
