//! From a trace to a recording in ROS 2 types and back, through the readers of this crate.

use recording::{
    Format, OpenOptions, Reader, Ros2Source, Ros2Topic, Ros2TraceOptions, Ros2TraceOutcome,
    Ros2WriteError, SignalStream, TopicMap, open_bytes, ros2_recording_of,
};
use trace::{Field, Trace};

type Checked = Result<(), Box<dyn std::error::Error>>;

/// A second of a robot at 100 Hz and of a person at 10 Hz, with a value missing now and then.
fn example() -> Result<Trace, Box<dyn std::error::Error>> {
    let mut trace = Trace::new();
    let robot = trace.add_channel(
        "/robot",
        vec![
            Field::number("wrist", "rad"),
            Field::number("speed", "rad/s"),
            Field::enumeration("state", ["idle", "serve"]),
            Field::bool("crashed"),
        ],
    )?;
    let person = trace.add_channel(
        "/person",
        ["x", "y", "z"]
            .map(|axis| Field::number(format!("hand.{axis}"), "m").in_frame("world"))
            .into(),
    )?;
    for step in 0..100_u32 {
        let time_secs = f64::from(step) / 100.0;
        let missing = if step % 7 == 3 {
            f64::NAN
        } else {
            time_secs.sin()
        };
        let state = f64::from(step / 50);
        trace.channels[robot].push(time_secs, &[missing, time_secs.cos(), state, 0.0])?;
        if step % 10 == 0 {
            trace.channels[person].push(time_secs, &[time_secs, -1.0, 1.0 / 3.0])?;
        }
    }
    trace.metadata.insert("seed".to_owned(), "42".to_owned());
    Ok(trace)
}

fn topic(name: &str, type_name: &str, rows_of: &str, fields: &[(&str, Ros2Source)]) -> Ros2Topic {
    Ros2Topic {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        rows_of: rows_of.to_owned(),
        fields: fields
            .iter()
            .map(|(path, source)| ((*path).to_owned(), source.clone()))
            .collect(),
    }
}

fn table() -> Vec<Ros2Topic> {
    let signal = |name: &str| Ros2Source::Signal(name.to_owned());
    let text = |text: &str| Ros2Source::Text(text.to_owned());
    vec![
        topic(
            "/joint_states",
            "sensor_msgs/msg/JointState",
            "/robot",
            &[
                ("header.stamp", Ros2Source::Stamp),
                ("name[0]", text("wrist")),
                ("position[0]", signal("/robot.wrist")),
                ("velocity[0]", signal("/robot.speed")),
            ],
        ),
        topic(
            "/state",
            "std_msgs/msg/String",
            "/robot",
            &[("data", signal("/robot.state"))],
        ),
        topic(
            "/crashed",
            "std_msgs/msg/Bool",
            "/robot",
            &[("data", signal("/robot.crashed"))],
        ),
        topic(
            "/person_hand",
            "geometry_msgs/msg/PointStamped",
            "/person",
            &[
                ("header.stamp", Ros2Source::Stamp),
                ("header.frame_id", text("world")),
                ("point.x", signal("/person.hand.x")),
                ("point.y", signal("/person.hand.y")),
                ("point.z", signal("/person.hand.z")),
            ],
        ),
    ]
}

const MAP: &str = r#"
["/robot.wrist"]
from = "/joint_states.position[name='wrist']"
unit = "rad"
["/robot.speed"]
from = "/joint_states.velocity[name='wrist']"
unit = "rad/s"
["/robot.state"]
from = "/state.data"
values = ["idle", "serve"]
["/robot.crashed"]
from = "/crashed.data"
kind = "bool"
["/person.hand"]
point = "/person_hand.point"
frame = "world"
"#;

fn written(start_nanos: i64) -> Result<Ros2TraceOutcome, Box<dyn std::error::Error>> {
    let options = Ros2TraceOptions { start_nanos };
    Ok(ros2_recording_of(&example()?, &table(), &options)?)
}

fn reader(bytes: Vec<u8>) -> Result<Box<dyn Reader + Send>, Box<dyn std::error::Error>> {
    Ok(open_bytes(bytes, Format::Mcap, &OpenOptions::default())?)
}

fn stream(bytes: Vec<u8>, map: &str) -> Result<SignalStream, Box<dyn std::error::Error>> {
    let map = TopicMap::parse("topics.toml", map).map_err(|mut errors| errors.remove(0))?;
    let stream = SignalStream::new(reader(bytes)?, &map, &[]);
    Ok(stream.map_err(|mut errors| errors.remove(0))?)
}

/// Values as bits, all NaNs alike.
fn bits(values: &[f64]) -> Vec<u64> {
    let plain = |value: &f64| if value.is_nan() { f64::NAN } else { *value };
    values.iter().map(|value| plain(value).to_bits()).collect()
}

#[test]
fn a_trace_comes_back_bit_for_bit() -> Checked {
    let trace = example()?;
    for (start_nanos, map) in [
        (0, MAP.to_owned()),
        (1_700_000_000_000_000_000, MAP.to_owned()),
        (
            1_700_000_000_000_000_000,
            format!("{MAP}[time]\nfrom = \"publish\"\n"),
        ),
    ] {
        let back = stream(written(start_nanos)?.bytes, &map)?.collect()?;
        assert!(back.complete);
        for channel in &trace.channels {
            let found = back.channel(&channel.topic).ok_or("the channel is gone")?;
            assert_eq!(found.fields, channel.fields);
            assert_eq!(found.times_secs, channel.times_secs);
            assert_eq!(bits(&found.values), bits(&channel.values));
        }
    }
    Ok(())
}

#[test]
fn the_same_trace_gives_the_same_bytes() -> Checked {
    let outcome = written(5)?;
    assert_eq!(outcome, written(5)?);
    assert_eq!((outcome.messages, outcome.left_out), (310, 0));
    Ok(())
}

#[test]
fn what_cannot_be_written_is_left_out_or_refused() -> Checked {
    let mut trace = example()?;
    trace.channels[0].push(2.0, &[0.0, 0.0, f64::NAN, f64::NAN])?;
    let options = Ros2TraceOptions::default();
    let outcome = ros2_recording_of(&trace, &table(), &options)?;
    assert_eq!((outcome.messages, outcome.left_out), (311, 2));
    let refused = |field: &str, source: Ros2Source| {
        let bad = topic("/t", "std_msgs/msg/Int32", "/robot", &[(field, source)]);
        ros2_recording_of(&trace, &[bad], &options)
            .err()
            .ok_or("it was written")
    };
    let error = refused("data", Ros2Source::Signal("/robot.speed".to_owned()))?;
    assert!(matches!(error, Ros2WriteError::BadValue { .. }), "{error}");
    let error = refused("data", Ros2Source::Signal("/robot.sped".to_owned()))?;
    assert!(
        matches!(error, Ros2WriteError::UnknownSignal { .. }),
        "{error}"
    );
    let error = refused("date", Ros2Source::Number(1.0))?;
    assert!(
        matches!(error, Ros2WriteError::UnknownField { .. }),
        "{error}"
    );
    let late = Ros2TraceOptions {
        start_nanos: -1_000_000_000,
    };
    assert!(ros2_recording_of(&trace, &table(), &late).is_err());
    Ok(())
}

/// Wherever a recording is cut, what is read of it is the beginning of what was written, and it is
/// never taken for all of it.
#[test]
fn a_recording_cut_short_gives_its_beginning_only() -> Checked {
    let trace = example()?;
    let bytes = written(0)?.bytes;
    // The speed is there in every row and grows or falls strictly, so it tells the rows apart.
    let speeds: Vec<f64> = (0..100).map(|row| trace.channels[0].row(row)[1]).collect();
    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        let Ok(mut stream) = stream(bytes[..length].to_vec(), MAP) else {
            continue;
        };
        let Some(speed) = stream.layout().signal("/robot.speed") else {
            continue;
        };
        let mut seen: Vec<f64> = Vec::new();
        while let Ok(Some(_)) = stream.next_instant() {
            let value = stream.snapshot().value(speed);
            seen.extend(value.filter(|value| seen.last() != Some(value)));
        }
        assert_eq!(seen, speeds[..seen.len()], "{length}");
        assert!(
            !stream.complete() || !stream.absent().is_empty(),
            "{length}"
        );
    }
    Ok(())
}

/// The map of a study is checked against what is there, once for all recordings.
#[test]
fn predicates_are_bound_to_the_layout_with_units_and_frames() -> Checked {
    let stream = stream(written(0)?.bytes, MAP)?;
    let predicate = |text: &str| trace::Predicate::parse(text)?.bind(stream.layout());
    assert!(
        predicate("/robot.speed < 10 deg/s & /robot.state = 'serve' & !/robot.crashed").is_ok()
    );
    assert!(predicate("distance(/person.hand, /person.hand) < 10 cm").is_ok());
    assert!(predicate("/robot.speed < 10 cm").is_err());
    assert!(predicate("/robot.state = 'walk'").is_err());
    Ok(())
}
