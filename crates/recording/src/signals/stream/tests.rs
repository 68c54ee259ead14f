//! Streams of recordings that are written here.

use std::collections::BTreeMap;

use super::*;
use crate::kept::Kept;
use crate::ros2_writer::{Ros2Recording, Ros2Value};

const MS: i64 = 1_000_000;

type Fields<'a> = Vec<(&'a str, Ros2Value<'a>)>;

/// A recording of messages given as (topic, type, log time in ms, fields).
fn recorded(messages: &[(&str, &str, i64, Fields<'_>)]) -> Box<Kept> {
    let mut recording = Ros2Recording::new().unwrap();
    let mut ids = BTreeMap::new();
    for (topic, type_name, log_ms, fields) in messages {
        let id = *ids
            .entry(*topic)
            .or_insert_with(|| recording.add_topic(topic, type_name).unwrap());
        recording.write(id, log_ms * MS, fields).unwrap();
    }
    Kept::new(&recording.finish().unwrap())
}

fn map(text: &str) -> TopicMap {
    TopicMap::parse("t.toml", text).unwrap()
}

fn streamed(
    reader: Box<Kept>,
    map: &TopicMap,
    wanted: &[&str],
) -> Result<SignalStream, Vec<BindError>> {
    let wanted: Vec<String> = wanted.iter().map(|name| (*name).to_owned()).collect();
    SignalStream::new(reader, map, &wanted)
}

/// Instants in ms with the value of each signal, NaN as -1.
fn values(stream: &mut SignalStream, names: &[&str]) -> Vec<(f64, Vec<f64>)> {
    let signals: Vec<_> = names
        .iter()
        .map(|name| stream.layout().signal(name).unwrap())
        .collect();
    let mut all = Vec::new();
    while let Some(instant) = stream.next_instant().unwrap() {
        let values = signals
            .iter()
            .map(|signal| stream.snapshot().value(*signal).unwrap_or(-1.0));
        all.push((instant.time_nanos as f64 / 1e6, values.collect()));
    }
    all
}

const JOINTS: &str = "sensor_msgs/msg/JointState";
const TEXT: &str = "std_msgs/msg/String";
const NUMBER: &str = "std_msgs/msg/Float64";

#[test]
fn signals_of_several_topics_and_kinds() {
    let mut messages = Vec::new();
    for step in 0..4_i64 {
        let number = step as f64;
        messages.push((
            "/joints",
            JOINTS,
            10 * step,
            vec![
                ("name[0]", Ros2Value::Text("elbow")),
                ("name[1]", Ros2Value::Text("wrist")),
                ("velocity[0]", Ros2Value::Number(3.0 * number)),
                ("velocity[1]", Ros2Value::Number(4.0 * number)),
            ],
        ));
        let phase = ["idle", "serve", "lost", "idle"][step as usize];
        messages.push((
            "/phase",
            TEXT,
            10 * step + 5,
            vec![("data", Ros2Value::Text(phase))],
        ));
        messages.push((
            "/on",
            "std_msgs/msg/Bool",
            10 * step + 5,
            vec![("data", Ros2Value::Bool(step > 1))],
        ));
    }
    let map = map(r#"
["/robot.wrist"]
from = "/joints.velocity[name='wrist']"
scale = 0.5
unit = "rad/s"
["/robot.speed"]
norm = ["/joints.velocity[0]", "/joints.velocity[1]"]
["/robot.phase"]
from = "/phase.data"
values = ["idle", "serve"]
"#);
    let wanted = ["/robot.wrist", "/robot.speed", "/robot.phase", "/on.data"];
    let mut stream = streamed(recorded(&messages), &map, &wanted).unwrap();
    let serving = trace::Predicate::parse("/robot.phase = 'serve' & /on.data = false").unwrap();
    assert!(serving.bind(stream.layout()).is_ok());
    let found = values(&mut stream, &wanted);
    let expected = [
        (0.0, [0.0, 0.0, -1.0, -1.0]),
        (5.0, [0.0, 0.0, 0.0, 0.0]),
        (10.0, [2.0, 5.0, 0.0, 0.0]),
        (15.0, [2.0, 5.0, 1.0, 0.0]),
        (20.0, [4.0, 10.0, 1.0, 0.0]),
        (25.0, [4.0, 10.0, -1.0, 1.0]),
        (30.0, [6.0, 15.0, -1.0, 1.0]),
        (35.0, [6.0, 15.0, 0.0, 1.0]),
    ];
    assert_eq!(found, expected.map(|(ms, values)| (ms, values.to_vec())));
    let notes = stream.notes();
    assert_eq!(
        (notes[0].kind, notes[0].first.as_str()),
        (StreamNoteKind::UnknownName, "lost")
    );
    assert!(!stream.complete());
}

#[test]
fn what_is_not_there_is_told_at_once() {
    let messages = [("/x", NUMBER, 0, vec![]), ("/t", TEXT, 0, vec![])];
    let map = map(
        "[\"/a.b\"]\nfrom = \"/x.dada\"\n[\"/c.d\"]\nfrom = \"/t.data\"\n[\"/e.f\"]\nfrom = \"/gone.data\"\n",
    );
    let all_known = || {
        let mut kept = recorded(&messages);
        kept.known = usize::MAX;
        kept
    };
    let errors = streamed(all_known(), &map, &["/a.b", "/c.d"]).unwrap_err();
    let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(
        texts[0].contains("/a.b (line 1 of the topic map)"),
        "{texts:?}"
    );
    assert!(texts[1].contains("is text; list its values"), "{texts:?}");
    let errors = streamed(all_known(), &map, &["/y.data", "/t.data", "/x.nothing"]).unwrap_err();
    assert!(
        errors[0].to_string().contains("it has /t, /x"),
        "{}",
        errors[0]
    );
    assert!(errors[1].to_string().contains("lists its values"));
    assert_eq!(errors.len(), 3);
    let stream = streamed(all_known(), &map, &["/e.f"]).unwrap();
    assert!(
        stream.absent()[0]
            .to_string()
            .contains("no topic for /gone.data")
    );
}

#[test]
fn topics_that_appear_late_are_bound_then() {
    let messages = [
        ("/x", NUMBER, 0, vec![("data", Ros2Value::Number(1.0))]),
        ("/late", NUMBER, 10, vec![("data", Ros2Value::Number(2.0))]),
        ("/late", NUMBER, 20, vec![("data", Ros2Value::Number(3.0))]),
    ];
    let mut kept = recorded(&messages);
    kept.known = 1;
    let map = map("[\"/a.x\"]\nfrom = \"/x.data\"\n[\"/a.y\"]\nfrom = \"/late.data\"\n");
    let mut stream = streamed(kept, &map, &[]).unwrap();
    let found = values(&mut stream, &["/a.x", "/a.y"]);
    assert_eq!(
        found,
        [
            (0.0, vec![1.0, -1.0]),
            (10.0, vec![1.0, 2.0]),
            (20.0, vec![1.0, 3.0])
        ]
    );
}

fn stamped(ms: i64, x: f64) -> Fields<'static> {
    vec![
        ("header.stamp", Ros2Value::Nanos(ms * MS)),
        ("point.x", Ros2Value::Number(x)),
        ("header.frame_id", Ros2Value::Text("camera")),
    ]
}

const POINT: &str = "geometry_msgs/msg/PointStamped";

#[test]
fn header_time_orders_what_came_late() {
    let messages = [
        ("/p", POINT, 100, stamped(90, 1.0)),
        ("/q", POINT, 110, stamped(60, 2.0)),
        ("/p", POINT, 120, stamped(110, 3.0)),
        ("/p", POINT, 130, stamped(0, 4.0)),
        ("/p", POINT, 1500, stamped(1490, 5.0)),
        ("/q", POINT, 1510, stamped(80, 6.0)),
        ("/p", POINT, 2600, stamped(2590, 7.0)),
        ("/q", POINT, 2700, stamped(100, 8.0)),
    ];
    let map = map("[time]\nfrom = \"header\"\n");
    let mut stream = streamed(recorded(&messages), &map, &["/p.point.x", "/q.point.x"]).unwrap();
    let found = values(&mut stream, &["/p.point.x", "/q.point.x"]);
    let expected = [
        (60.0, [-1.0, 2.0]),
        (90.0, [1.0, 2.0]),
        (110.0, [3.0, 2.0]),
        (1490.0, [5.0, 2.0]),
        (2590.0, [7.0, 2.0]),
    ];
    // The stamp 80 came when 60, 90 and 110 had been given; 100 as well.
    assert_eq!(found, expected.map(|(ms, values)| (ms, values.to_vec())));
    let kinds: Vec<_> = stream
        .notes()
        .iter()
        .map(|note| (note.kind, note.count, note.first_offset))
        .collect();
    assert_eq!(
        kinds,
        [
            (StreamNoteKind::Late, 2, 6),
            (StreamNoteKind::Unstamped, 1, 4)
        ]
    );
}

#[test]
fn clocks_that_differ_are_not_mixed() {
    let messages = [
        ("/x", NUMBER, 10_000_000, vec![]),
        ("/p", POINT, 10_000_001, stamped(90, 1.0)),
    ];
    let map = map("[time]\nfrom = \"header\"\n");
    let mut stream = streamed(recorded(&messages), &map, &["/p.point.x", "/x.data"]).unwrap();
    let error = loop {
        match stream.next_instant() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("no error"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(
        error.contains("messages of /x have no header") && error.contains("of /p are 9999.9"),
        "{error}"
    );
    assert!(!stream.complete());
    // Within a minute of each other they are, and that is told.
    let messages = [
        ("/x", NUMBER, 100, vec![]),
        ("/p", POINT, 200, stamped(150, 1.0)),
    ];
    let mut stream = streamed(recorded(&messages), &map, &["/p.point.x", "/x.data"]).unwrap();
    assert_eq!(values(&mut stream, &["/p.point.x"]).len(), 2);
    assert_eq!(stream.notes()[0].kind, StreamNoteKind::LogTimeTaken);
    assert!(stream.complete());
}

#[test]
fn simulated_time_is_that_of_the_clock_until_it_is_reset() {
    let clock = |ms: i64| vec![("clock", Ros2Value::Nanos(ms * MS))];
    let number = |x: f64| vec![("data", Ros2Value::Number(x))];
    const CLOCK: &str = "rosgraph_msgs/msg/Clock";
    let mut messages = vec![
        ("/x", NUMBER, 5, number(0.0)),
        ("/clock", CLOCK, 10, clock(1000)),
        ("/x", NUMBER, 15, number(1.0)),
        ("/clock", CLOCK, 20, clock(1100)),
        ("/x", NUMBER, 20, number(2.0)),
        ("/clock", CLOCK, 30, clock(1100)),
        ("/x", NUMBER, 28, number(3.0)),
        ("/x", NUMBER, 35, number(4.0)),
    ];
    let map = map("[time]\nfrom = \"clock\"\n");
    let run = |messages: &[(&str, &str, i64, Fields<'_>)]| {
        let mut stream = streamed(recorded(messages), &map, &["/x.data"]).unwrap();
        let found = values(&mut stream, &["/x.data"]);
        let kinds: Vec<_> = stream
            .notes()
            .iter()
            .map(|note| (note.kind, note.count))
            .collect();
        (found, kinds)
    };
    let (found, kinds) = run(&messages);
    // Where the clock stands still, each message is a sample.
    let expected = [
        (1050.0, vec![1.0]),
        (1100.0, vec![2.0]),
        (1100.0, vec![3.0]),
        (1100.0, vec![4.0]),
    ];
    assert_eq!(found, expected);
    assert_eq!(kinds, [(StreamNoteKind::BeforeClock, 1)]);
    messages.extend([
        ("/clock", CLOCK, 40, clock(0)),
        ("/x", NUMBER, 45, number(9.0)),
    ]);
    let (found, kinds) = run(&messages);
    assert_eq!(found, expected);
    assert_eq!(kinds[1].0, StreamNoteKind::ClockReset);
    let errors = streamed(recorded(&messages[..1]), &map, &["/x.data"]).unwrap_err();
    assert!(
        errors[0]
            .to_string()
            .contains("the recording does not have"),
        "{}",
        errors[0]
    );
}

#[test]
fn points_are_told_in_the_frame_that_is_wanted() {
    const TF: &str = "tf2_msgs/msg/TFMessage";
    let turned = |ms: i64, parent: &'static str, child: &'static str, x: f64| {
        vec![
            ("transforms[0].header.stamp", Ros2Value::Nanos(ms * MS)),
            ("transforms[0].header.frame_id", Ros2Value::Text(parent)),
            ("transforms[0].child_frame_id", Ros2Value::Text(child)),
            (
                "transforms[0].transform.translation.x",
                Ros2Value::Number(x),
            ),
            ("transforms[0].transform.rotation.z", Ros2Value::Number(1.0)), // half a turn about z
        ]
    };
    let broken = vec![
        ("transforms[0].header.frame_id", Ros2Value::Text("world")),
        ("transforms[0].child_frame_id", Ros2Value::Text("ghost")),
    ];
    let messages = [
        ("/tf_static", TF, 0, turned(0, "world", "base", 10.0)),
        ("/tf", TF, 10, turned(10, "base", "camera", 1.0)),
        ("/tf", TF, 12, broken),
        ("/p", POINT, 20, stamped(15, 0.25)),
        ("/tf", TF, 30, turned(30, "base", "camera", 2.0)),
    ];
    let map = map(r#"
[time]
from = "header"
["/seen"]
point = "/p.point"
in_frame = "world"
["/away.distance"]
distance_between = ["world", "camera"]
"#);
    let mut stream = streamed(recorded(&messages), &map, &[]).unwrap();
    assert_eq!(
        stream.layout().signal_names().collect::<Vec<_>>(),
        ["/seen.x", "/seen.y", "/seen.z", "/away.distance"]
    );
    assert_eq!(
        stream.layout().channels[0].fields[0].frame.as_deref(),
        Some("world")
    );
    let found = values(&mut stream, &["/seen.x", "/away.distance"]);
    // In the base the point is at (camera at 1.25) - 0.25 = 1; in the world at 10 - 1.
    let expected = [(10.0, [-1.0, 9.0]), (15.0, [9.0, 9.0]), (30.0, [9.0, 8.0])];
    for ((ms, found), (expected_ms, expected)) in found.iter().zip(expected) {
        assert_eq!(*ms, expected_ms);
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-12),
            "{ms}: {found:?}"
        );
    }
    assert_eq!(found.len(), 3);
    let notes = stream.notes();
    assert_eq!(
        (notes[0].kind, notes.len()),
        (StreamNoteKind::BadTransform, 1)
    );
    assert!(
        notes[0].first.starts_with("ghost in world: the quaternion"),
        "{}",
        notes[0].first
    );
}

#[test]
fn a_stream_is_collected_as_a_trace() {
    let messages: Vec<_> = (0..3_i64)
        .map(|step| {
            (
                "/x",
                NUMBER,
                10 * step,
                vec![("data", Ros2Value::Number(step as f64))],
            )
        })
        .collect();
    let map = map("[\"/a.x\"]\nfrom = \"/x.data\"\nunit = \"m\"\nstaleness = \"4 ms\"\n");
    let trace = streamed(recorded(&messages), &map, &[])
        .unwrap()
        .collect()
        .unwrap();
    let channel = trace.channel("/a").unwrap();
    assert_eq!(
        channel.times_secs,
        [0.0, 0.004000001, 0.01, 0.014000001, 0.02]
    );
    assert_eq!(
        channel
            .values
            .iter()
            .map(|value| value.is_nan())
            .collect::<Vec<_>>(),
        [false, true, false, true, false]
    );
    assert!(trace.complete && trace.validate().is_ok());
    let infinite = [(
        "/x",
        NUMBER,
        0,
        vec![("data", Ros2Value::Number(f64::INFINITY))],
    )];
    assert!(
        streamed(recorded(&infinite), &map, &[])
            .unwrap()
            .collect()
            .is_err()
    );
}

#[test]
fn messages_that_do_not_fit_are_samples_without_values_and_counted() {
    let mut kept = recorded(&[
        ("/x", NUMBER, 0, vec![]),
        ("/x", NUMBER, 10, vec![]),
        ("/x", NUMBER, 20, vec![]),
    ]);
    kept.messages[1].2.truncate(7);
    let mut stream = streamed(kept, &TopicMap::default(), &["/x.data"]).unwrap();
    let missing = [(0.0, vec![0.0]), (10.0, vec![-1.0]), (20.0, vec![0.0])];
    assert_eq!(values(&mut stream, &["/x.data"]), missing);
    let notes = stream.notes();
    assert_eq!(
        (notes[0].kind, notes[0].count, notes[0].first_offset),
        (StreamNoteKind::Undecodable, 1, 2)
    );
    assert!(
        notes[0].to_string().contains("1 message of /x"),
        "{}",
        notes[0]
    );
}

#[test]
fn topics_of_other_systems_need_no_slash() {
    let mut kept = recorded(&[("/x", NUMBER, 0, vec![("data", Ros2Value::Number(7.0))])]);
    kept.topics[0].name = "wheel.left".to_owned();
    let map = map("[\"/a.x\"]\nfrom = \"wheel.left.data\"\n");
    let wanted = ["/a.x", "/wheel.left.data"];
    let mut stream = streamed(kept, &map, &wanted).unwrap();
    assert_eq!(values(&mut stream, &wanted), [(0.0, vec![7.0, 7.0])]);
}

#[test]
fn moments_know_where_they_stand_in_the_recording() {
    let messages = [
        ("/p", POINT, 100, stamped(90, 1.0)),
        ("/q", POINT, 110, stamped(60, 2.0)),
        ("/p", POINT, 120, stamped(110, 3.0)),
    ];
    let wanted = ["/p.point.x", "/q.point.x"];
    for (source, expected) in [("header", [110, 100, 120]), ("log", [100, 110, 120])] {
        let map = map(&format!("[time]\nfrom = \"{source}\"\n"));
        let mut stream = streamed(recorded(&messages), &map, &wanted).unwrap();
        let moments = std::iter::from_fn(|| stream.next_instant().unwrap());
        let logged: Vec<i64> = moments.map(|moment| moment.log_nanos / MS).collect();
        assert_eq!(logged, expected);
    }
}

/// What is steady, in ms, after each instant, if nothing was logged before `log_ms`.
fn steady_ms(text: &str, log_ms: i64) -> Vec<Option<f64>> {
    let number = |value| vec![("data", Ros2Value::Number(value))];
    let messages = [10, 20].map(|ms| ("/a", NUMBER, ms, number(1.0)));
    let mut stream = streamed(recorded(&messages), &map(text), &["/s.a"]).unwrap();
    let mut steady = vec![stream.steady_until_secs(log_ms * MS)];
    loop {
        match stream.poll().unwrap() {
            Polled::At(_) => steady.push(stream.steady_until_secs(log_ms * MS)),
            Polled::Nothing => {}
            Polled::End => break,
        }
    }
    let in_ms = |secs: f64| (secs * 1e3 * 1e3).round() / 1e3;
    steady.into_iter().map(|it| it.map(in_ms)).collect()
}

#[test]
fn signals_are_steady_until_the_clock_or_until_they_are_too_old() {
    let at_once = "[time]\nreorder = \"0 s\"\n";
    let plain = "[\"/s.a\"]\nfrom = \"/a.data\"\n";
    let fresh = format!("{plain}staleness = \"5 ms\"\n");
    assert_eq!(
        steady_ms(&format!("{at_once}{plain}"), 50),
        [None, Some(50.0), Some(50.0)]
    );
    // The past is no news.
    assert_eq!(
        steady_ms(&format!("{at_once}{plain}"), 15),
        [None, Some(15.0), None]
    );
    // At 15 ms the first value is fresh for the last time, which is an instant too.
    assert_eq!(
        steady_ms(&format!("{at_once}{fresh}"), 50),
        [None, Some(15.0), None, Some(25.0)]
    );
    // What waits to be put in order may stand anywhere from its time on.
    let waits = format!("[time]\nreorder = \"100 s\"\n{plain}");
    assert_eq!(steady_ms(&waits, 50), [None, Some(20.0), Some(50.0)]);
    // A message may always come later than it was sent.
    let publish = format!("[time]\nfrom = \"publish\"\nreorder = \"0 s\"\n{plain}");
    assert_eq!(steady_ms(&publish, 50), [None, None, None]);
}

#[test]
fn each_publisher_of_a_topic_has_joints_of_its_own() {
    let of = |name: &'static str, at_ms: i64, speed: f64| {
        let fields = vec![
            ("name[0]", Ros2Value::Text(name)),
            ("velocity[0]", Ros2Value::Number(speed)),
        ];
        ("/joints", JOINTS, at_ms, fields)
    };
    let reader = recorded(&[
        of("arm", 0, 1.0),
        of("grip", 5, 2.0),
        of("arm", 10, 3.0),
        of("grip", 15, 4.0),
    ]);
    let map = map("[\"/r.arm\"]\nfrom = \"/joints.velocity[name='arm']\"\n\
         [\"/r.grip\"]\nfrom = \"/joints.velocity[name='grip']\"\n");
    let mut stream = streamed(reader, &map, &[]).unwrap();
    let (mut seen, mut sampled) = (Vec::new(), Vec::new());
    while let Some(instant) = stream.next_instant().unwrap() {
        let value = |field| {
            let signal = trace::SignalIndex { channel: 0, field };
            stream.snapshot().value(signal).unwrap_or(-1.0)
        };
        seen.push((instant.time_nanos / MS, value(0), value(1)));
        sampled.push(stream.sampled()[0].clone());
    }
    let kept = [
        (0, 1.0, -1.0),
        (5, 1.0, 2.0),
        (10, 3.0, 2.0),
        (15, 3.0, 4.0),
    ];
    assert_eq!(seen, kept);
    let (arm, grip) = (vec![true, false], vec![false, true]);
    assert_eq!(sampled, [arm.clone(), grip.clone(), arm, grip]);
}

#[test]
fn messages_of_one_time_are_samples_one_after_another() {
    let number = |topic, at_ms, value| {
        (
            topic,
            NUMBER,
            at_ms,
            vec![("data", Ros2Value::Number(value))],
        )
    };
    let reader = recorded(&[
        number("/a", 0, 1.0),
        number("/a", 1, -3.0),
        number("/b", 1, 7.0),
        number("/a", 1, 2.0),
        number("/b", 2, 8.0),
    ]);
    let mut stream = streamed(reader, &TopicMap::default(), &["/a.data", "/b.data"]).unwrap();
    let mut more = Vec::new();
    let mut seen = Vec::new();
    while let Some(instant) = stream.next_instant().unwrap() {
        let value = |channel| {
            let signal = trace::SignalIndex { channel, field: 0 };
            stream.snapshot().value(signal).unwrap_or(-1.0)
        };
        seen.push((instant.time_nanos / MS, value(0), value(1)));
        more.push(instant.more);
    }
    assert_eq!(
        seen,
        [(0, 1.0, -1.0), (1, -3.0, 7.0), (1, 2.0, 7.0), (2, 2.0, 8.0)]
    );
    assert_eq!(more, [false, true, false, false]);
}

#[test]
fn a_transform_is_not_interpolated_over_a_wide_gap() {
    let tf = |at_ms: i64, x: f64| {
        let fields = vec![
            ("transforms[0].header.stamp.sec", Ros2Value::Number(0.0)),
            ("transforms[0].header.frame_id", Ros2Value::Text("world")),
            ("transforms[0].child_frame_id", Ros2Value::Text("hand")),
            (
                "transforms[0].transform.translation.x",
                Ros2Value::Number(x),
            ),
            ("transforms[0].transform.rotation.w", Ros2Value::Number(1.0)),
        ];
        ("/tf", "tf2_msgs/msg/TFMessage", at_ms, fields)
    };
    let point = |at_ms: i64| {
        let fields = vec![
            ("header.frame_id", Ros2Value::Text("hand")),
            ("point.x", Ros2Value::Number(0.0)),
        ];
        ("/p", "geometry_msgs/msg/PointStamped", at_ms, fields)
    };
    let signal = "[\"/hand\"]\npoint = \"/p.point\"\nin_frame = \"world\"\n";
    let read = |time: &str| {
        let reader = recorded(&[tf(0, 0.0), point(1500), tf(3000, 6.0)]);
        let map = map(&format!("{time}{signal}"));
        values(&mut streamed(reader, &map, &[]).unwrap(), &["/hand.x"])
    };
    assert_eq!(read(""), [(1500.0, vec![-1.0])]);
    let wide = "[time]\nframe_gap = \"3 s\"\nframe_wait = \"5 s\"\nreorder = \"5 s\"\n";
    assert_eq!(read(wide), [(1500.0, vec![3.0])]);
}
