//! MCAP files: what is written comes back bit for bit, and damage is never mistaken for data.

use std::collections::BTreeMap;

use proptest::prelude::*;
use recording::{TraceReadProblem, TraceWriteError, from_mcap, read_mcap, to_mcap, write_mcap};
use trace::{Channel, Field, FieldKind, Trace};

/// The trace with each number as its bits, so that -0.0 differs from 0.0 and NaN equals NaN.
type Bits = (
    Vec<(String, Vec<Field>, Vec<u64>, Vec<u64>)>,
    BTreeMap<String, String>,
    bool,
);

fn bits(trace: &Trace) -> Bits {
    let bits_of = |value: &f64| {
        if value.is_nan() {
            f64::NAN.to_bits()
        } else {
            value.to_bits()
        }
    };
    let channels = trace.channels.iter().map(|channel| {
        (
            channel.topic.clone(),
            channel.fields.clone(),
            channel.times_secs.iter().map(bits_of).collect(),
            channel.values.iter().map(bits_of).collect(),
        )
    });
    (channels.collect(), trace.metadata.clone(), trace.complete)
}

/// A small run: two topics at different rates, all kinds of fields, missing values.
fn handover() -> Trace {
    let mut trace = Trace::new();
    trace.metadata.insert("seed".to_owned(), "42".to_owned());
    let robot = vec![
        Field::enumeration("state", ["sense", "release \"now\""]),
        Field::number("hand.x", "m").in_frame("world"),
        Field::number("hand.y", "m").in_frame("world"),
        Field::bool("crashed"),
    ];
    trace
        .add_channel("/robot", robot)
        .expect("the names are good");
    trace
        .add_channel("/human", vec![Field::number("pull", "N")])
        .expect("the names are good");
    for step in 0..40 {
        let time_secs = f64::from(step) * 0.05;
        let row = [f64::from(step % 2), 0.1 * f64::from(step), f64::NAN, 0.0];
        trace.channels[0]
            .push(time_secs, &row)
            .expect("the row is good");
        if step % 3 == 0 {
            trace.channels[1]
                .push(time_secs, &[1.0 / f64::from(step + 1)])
                .expect("it is good");
        }
    }
    trace
}

#[test]
fn handover_comes_back() {
    let trace = handover();
    let outcome = from_mcap(&to_mcap(&trace).expect("it can be written")).expect("it can be read");
    assert_eq!(bits(&outcome.trace), bits(&trace));
    assert!(outcome.complete);
    assert_eq!(outcome.lost, None);
}

#[test]
fn a_trace_that_was_cut_short_stays_so() {
    let mut trace = handover();
    trace.complete = false;
    let outcome = from_mcap(&to_mcap(&trace).expect("it can be written")).expect("it can be read");
    assert!(!outcome.complete && !outcome.trace.complete);
    assert_eq!(outcome.lost, None);
}

#[test]
fn empty_traces_and_channels_come_back() {
    let mut trace = Trace::new();
    assert_eq!(from_mcap(&to_mcap(&trace).unwrap()).unwrap().trace, trace);
    trace
        .add_channel("/quiet", vec![Field::bool("a"), Field::bool("a.b")])
        .unwrap();
    assert_eq!(from_mcap(&to_mcap(&trace).unwrap()).unwrap().trace, trace);
}

#[test]
fn whole_milliseconds_need_no_exact_time() {
    let mut trace = Trace::new();
    trace
        .add_channel("/clock", vec![Field::bool("tick")])
        .unwrap();
    for step in 0..100_000 {
        trace.channels[0]
            .push(f64::from(step) / 1000.0, &[1.0])
            .unwrap();
    }
    let bytes = to_mcap(&trace).unwrap();
    assert_eq!(bits(&from_mcap(&bytes).unwrap().trace), bits(&trace));
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    for (step, message) in messages.enumerate() {
        let message = message.unwrap();
        assert_eq!(message.log_time, step as u64 * 1_000_000);
        assert_eq!(&*message.data, b"{\"tick\":true}");
    }
}

#[test]
fn messages_and_schema_are_what_other_tools_expect() {
    let bytes = to_mcap(&handover()).unwrap();
    let first = mcap::MessageStream::new(&bytes)
        .unwrap()
        .next()
        .unwrap()
        .unwrap();
    assert_eq!(first.channel.topic, "/robot");
    assert_eq!(first.channel.message_encoding, "json");
    assert_eq!(
        &*first.data,
        br#"{"state":"sense","hand":{"x":0.0},"crashed":false}"#
    );
    let schema = first.channel.schema.clone().expect("there is a schema");
    assert_eq!(schema.encoding, "jsonschema");
    let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
    assert_eq!(
        schema["properties"]["hand"]["properties"]["x"]["type"],
        "number"
    );
    assert_eq!(
        schema["properties"]["hand"]["properties"]["x"]["description"],
        "unit m, frame world"
    );
    assert_eq!(schema["properties"]["state"]["enum"][1], "release \"now\"");
}

#[test]
fn cut_at_any_byte_it_is_refused_or_marked_incomplete() {
    let trace = handover();
    let bytes = to_mcap(&trace).unwrap();
    let mut recovered = 0;
    for length in 0..bytes.len() {
        match from_mcap(&bytes[..length]) {
            Ok(outcome) => {
                assert!(
                    !outcome.complete && !outcome.trace.complete,
                    "cut at {length}"
                );
                assert!(outcome.lost.is_some(), "cut at {length}");
                for (part, whole) in outcome.trace.channels.iter().zip(&trace.channels) {
                    assert!(
                        whole.times_secs.starts_with(&part.times_secs),
                        "cut at {length}"
                    );
                }
                recovered = recovered.max(outcome.trace.channels[0].len());
            }
            Err(error) => assert!(matches!(
                error.problem,
                TraceReadProblem::Empty
                    | TraceReadProblem::NotMcap
                    | TraceReadProblem::NothingLeft(_)
            )),
        }
    }
    assert_eq!(
        recovered, 40,
        "cut within the summary, all messages are still there"
    );
}

#[test]
fn with_any_byte_changed_it_is_refused_or_marked_or_the_same() {
    let trace = handover();
    let mut bytes = to_mcap(&trace).unwrap();
    for place in 0..bytes.len() {
        for change in [0x01, 0x80, 0xff] {
            bytes[place] ^= change;
            if let Ok(outcome) = from_mcap(&bytes)
                && outcome.complete
            {
                assert_eq!(
                    bits(&outcome.trace),
                    bits(&trace),
                    "byte {place} changed by {change}"
                );
            }
            bytes[place] ^= change;
        }
    }
}

#[test]
fn a_long_recording_keeps_what_stands_before_the_damage() {
    let mut trace = Trace::new();
    trace
        .add_channel("/noise", vec![Field::number("value", "1")])
        .unwrap();
    for step in 0..60_000_u32 {
        // Digits that hardly compress, from a multiplicative generator.
        let value = f64::from(step.wrapping_mul(2_654_435_761)) / 4_294_967_296.0;
        trace.channels[0]
            .push(f64::from(step) / 1000.0, &[value])
            .unwrap();
    }
    let bytes = to_mcap(&trace).unwrap();
    let outcome = from_mcap(&bytes[..bytes.len() / 2]).unwrap();
    let kept = outcome.trace.channels[0].len();
    // Half of the rows, give or take two chunks of some 4300 rows: digits compress unevenly.
    assert!(
        (21_000..39_000).contains(&kept),
        "{kept} rows kept of 60000"
    );
    assert!(
        trace.channels[0]
            .values
            .starts_with(&outcome.trace.channels[0].values)
    );
    let lost = outcome.lost.unwrap();
    assert!(
        lost.contains("cut short") && lost.contains("is lost"),
        "{lost}"
    );
}

#[test]
fn files_of_others_are_refused_with_the_reason() {
    let message = |bytes: &[u8]| from_mcap(bytes).unwrap_err().to_string();
    assert!(message(b"").contains("it is empty"));
    assert!(message(b"time,x\n0,1\n").contains("not an MCAP file"));
    let write = |schema_encoding, schema: &[u8], encoding| {
        let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema("Pose", schema_encoding, schema).unwrap();
        writer
            .add_channel(schema, "/pose", encoding, &BTreeMap::new())
            .unwrap();
        writer.finish().unwrap();
        writer.into_inner().into_inner()
    };
    let bytes = write("ros2msg", b"float64 x", "cdr");
    assert!(message(&bytes).contains("encoding \"cdr\" of topic /pose is not readable yet"));
    let bytes = write("jsonschema", b"{}", "json");
    assert!(message(&bytes).contains("topic /pose has no description of its fields"));
}

#[test]
fn messages_that_do_not_fit_are_refused() {
    let schema = br#"{"x-corroborate":{"fields":[
        {"name":"speed","unit":"m/s","kind":"number"},{"name":"on","unit":"","kind":"bool"},
        {"name":"state","unit":"","kind":{"enumeration":["a","b"]}}]}}"#;
    let read = |data: &[u8]| {
        let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema("robot", "jsonschema", schema).unwrap();
        let id = writer
            .add_channel(schema, "/robot", "json", &BTreeMap::new())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id: id,
            sequence: 0,
            log_time: 5,
            publish_time: 5,
        };
        writer.write_to_known_channel(&header, data).unwrap();
        writer.finish().unwrap();
        from_mcap(&writer.into_inner().into_inner())
    };
    let good = read(br#"{ "state": "b", "speed": 3 }"#).unwrap().trace;
    assert_eq!(good.channels[0].times_secs, [5e-9]);
    assert_eq!(good.channels[0].values[0], 3.0);
    assert!(good.channels[0].values[1].is_nan());
    assert_eq!(good.channels[0].values[2], 1.0);
    let bad: [&[u8]; 8] = [
        br#"{"speed":"fast"}"#,
        br#"{"speed":true}"#,
        br#"{"on":1}"#,
        br#"{"state":"c"}"#,
        br#"{"other":1}"#,
        br#"{"speed":1"#,
        br#"{"speed":1} {}"#,
        br#"{"speed":null}"#,
    ];
    for data in bad {
        let error = read(data).unwrap_err().to_string();
        assert!(
            error.contains("message 0 of topic /robot does not fit"),
            "{error}"
        );
    }
}

#[test]
fn malformed_traces_are_not_written() {
    let mut trace = handover();
    trace.channels[1].values[0] = f64::INFINITY;
    assert!(matches!(to_mcap(&trace), Err(TraceWriteError::Trace(_))));
    let mut trace = Trace::new();
    trace
        .channels
        .push(Channel::new("/a", vec![Field::number("_time_secs", "s")]));
    assert!(matches!(to_mcap(&trace), Err(TraceWriteError::Trace(_))));
}

#[test]
fn files_appear_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    write_mcap(&path, &handover()).unwrap();
    write_mcap(&path, &handover()).unwrap();
    assert_eq!(read_mcap(&path).unwrap().trace.channels[0].len(), 40);
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "no temporary file is left"
    );

    let nowhere = folder.path().join("missing/run.mcap");
    let error = write_mcap(&nowhere, &handover()).unwrap_err().to_string();
    assert!(
        error.contains("missing/run.mcap") && error.contains("create the folder"),
        "{error}"
    );
    let error = write_mcap(folder.path(), &handover())
        .unwrap_err()
        .to_string();
    assert!(error.contains("not of a folder"), "{error}");
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "no temporary file is left"
    );

    let error = read_mcap(&nowhere).unwrap_err().to_string();
    assert!(error.contains("check the path"), "{error}");
}

/// Any name of a field, some of which nest, clash or need escapes.
fn field_name() -> impl Strategy<Value = String> {
    prop_oneof!["[ab](\\.[abx]){0,2}", "[a-z_]{1,6}", "[\"\\\\é .]{1,4}"]
}

fn field() -> impl Strategy<Value = Field> {
    let kind = prop_oneof![
        Just(FieldKind::Number),
        Just(FieldKind::Bool),
        prop::collection::btree_set("[a-c\"é]{0,3}", 1..4)
            .prop_map(|names| FieldKind::Enumeration(names.into_iter().collect())),
    ];
    (
        field_name(),
        "[a-z/\"]{0,4}",
        prop::option::of("[a-z]{1,4}"),
        kind,
    )
        .prop_map(|(name, unit, frame, kind)| Field {
            name,
            unit,
            frame,
            kind,
        })
}

/// Any finite double, by its bits, and often NaN, zeros and grid points.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("finite", |value| value.is_finite()),
        Just(f64::NAN),
        Just(-0.0),
        (0..10_000_i32).prop_map(|step| f64::from(step) * 0.002),
    ]
}

fn channel(topic: String) -> impl Strategy<Value = Channel> {
    let fields = prop::collection::btree_map(field_name(), field(), 1..5);
    let rows = prop::collection::vec((number(), prop::collection::vec(number(), 5)), 0..12);
    (fields, rows).prop_map(move |(fields, mut rows)| {
        let fields = fields
            .into_iter()
            .map(|(name, field)| Field { name, ..field })
            .collect();
        let mut channel = Channel::new(topic.clone(), fields);
        rows.retain(|(time_secs, _)| !time_secs.is_nan());
        rows.sort_by(|left, right| left.0.total_cmp(&right.0));
        for (time_secs, mut row) in rows {
            row.truncate(channel.fields.len());
            for (value, field) in row.iter_mut().zip(&channel.fields) {
                *value = match &field.kind {
                    FieldKind::Number => *value,
                    _ if value.is_nan() => *value,
                    FieldKind::Bool => f64::from(u8::from(*value > 1.0)),
                    FieldKind::Enumeration(names) => (value.to_bits() % names.len() as u64) as f64,
                };
            }
            channel.push(time_secs, &row).expect("the row fits");
        }
        channel
    })
}

proptest! {
    #[test]
    fn any_trace_comes_back_bit_for_bit(
        first in channel("/first".to_owned()),
        second in channel("/second/é.x".to_owned()),
        metadata in prop::collection::btree_map(".{0,8}", ".{0,8}", 0..4),
        complete in any::<bool>(),
    ) {
        prop_assume!(first.field_index("_time_secs").is_none());
        let trace = Trace { channels: vec![first, second], metadata, complete };
        let bytes = to_mcap(&trace).expect("it can be written");
        prop_assert_eq!(&bytes, &to_mcap(&trace).expect("it can be written"));
        let outcome = from_mcap(&bytes).expect("it can be read");
        prop_assert_eq!(outcome.lost, None);
        prop_assert_eq!(bits(&outcome.trace), bits(&trace));
    }

    #[test]
    fn any_bytes_are_read_without_panic(tail in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = from_mcap(&tail);
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.extend(tail);
        let _ = from_mcap(&bytes);
    }
}
