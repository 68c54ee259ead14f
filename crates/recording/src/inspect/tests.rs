//! Inspections of recordings that are written here.

use super::*;
use crate::kept::Kept;
use crate::ros2_writer::{Ros2Recording, Ros2Value};
use crate::topic_map::TopicMap;

const MS: i64 = 1_000_000;

/// Ten seconds of two joints at 100 Hz with a pause of half a second, a point at 10 Hz whose stamps
/// are 20 to 29 ms older than their log time, a word, and two frames.
fn example() -> Box<Kept> {
    let mut recording = Ros2Recording::new().unwrap();
    let joints = recording
        .add_topic("/arm/joints", "sensor_msgs/msg/JointState")
        .unwrap();
    let point = recording
        .add_topic("/point", "geometry_msgs/msg/PointStamped")
        .unwrap();
    let word = recording.add_topic("/word", "std_msgs/msg/String").unwrap();
    let tf = recording
        .add_topic("/tf", "tf2_msgs/msg/TFMessage")
        .unwrap();
    let fixed = recording
        .add_topic("/tf_static", "tf2_msgs/msg/TFMessage")
        .unwrap();
    let turn = |parent, child, w| {
        [
            ("transforms[0].header.stamp", Ros2Value::Nanos(0)),
            ("transforms[0].header.frame_id", Ros2Value::Text(parent)),
            ("transforms[0].child_frame_id", Ros2Value::Text(child)),
            ("transforms[0].transform.rotation.w", Ros2Value::Number(w)),
        ]
    };
    recording
        .write(fixed, 0, &turn("world", "base", 1.0))
        .unwrap();
    recording.write(tf, 0, &turn("base", "hand", 1.0)).unwrap();
    recording.write(tf, 0, &turn("base", "ghost", 0.0)).unwrap();
    for step in 0..1000_i64 {
        let at = 10 * MS * step + if step > 500 { 500 * MS } else { 0 };
        recording
            .write(
                joints,
                at,
                &[
                    ("name[0]", Ros2Value::Text("elbow")),
                    ("name[1]", Ros2Value::Text("wrist")),
                    ("velocity[0]", Ros2Value::Number(1.0)),
                    ("velocity[1]", Ros2Value::Number(2.0)),
                ],
            )
            .unwrap();
        if step % 10 == 0 {
            let stamp = at - (20 + step / 10 % 10) * MS;
            recording
                .write(
                    point,
                    at,
                    &[
                        ("header.stamp", Ros2Value::Nanos(stamp)),
                        ("point.x", Ros2Value::Number(0.5)),
                    ],
                )
                .unwrap();
        }
    }
    recording.write(point, 4 * MS, &[]).unwrap();
    recording
        .write(word, 5 * MS, &[("data", Ros2Value::Text("idle"))])
        .unwrap();
    Kept::new(&recording.finish().unwrap())
}

#[test]
fn rates_gaps_clocks_and_frames_are_found() {
    let mut kept = example();
    // A message of the joints is cut.
    let cut = kept
        .messages
        .iter()
        .position(|(topic, ..)| kept.topics[topic.index()].name == "/arm/joints")
        .unwrap();
    kept.messages[cut + 3].2.truncate(30);
    let found = inspect_reader(kept.as_mut(), &InspectOptions::default());
    let names: Vec<&str> = found
        .topics
        .iter()
        .map(|topic| topic.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["/arm/joints", "/point", "/tf", "/tf_static", "/word"]
    );
    let joints = &found.topics[0];
    assert_eq!((joints.messages, joints.gaps, joints.misfits), (1000, 1, 1));
    assert!((joints.rate_hz.unwrap() - 999.0 / 10.49).abs() < 1e-9);
    assert!((joints.median_period_secs.unwrap() / 0.01 - 1.0).abs() < 0.03);
    assert_eq!(
        (joints.longest_gap_secs, joints.longest_gap_at_nanos),
        (Some(0.51), Some(5_000 * MS))
    );
    let point = &found.topics[1];
    assert_eq!((point.out_of_order, point.unstamped, point.gaps), (1, 1, 1));
    assert_eq!(point.behind_stamp_secs, Some((0.02, 0.029)));
    assert_eq!(found.duration_secs(), Some(10.49));
    let frames: Vec<(&str, &str, bool)> = found
        .frames
        .iter()
        .map(|edge| (edge.frame.as_str(), edge.parent.as_str(), edge.is_static))
        .collect();
    assert_eq!(frames, [("base", "world", true), ("hand", "base", false)]);
    assert!(
        found.frame_problems[0]
            .0
            .starts_with("ghost in base: the quaternion")
    );
    let table = found.to_string();
    assert!(
        table.contains("not as their schema says: 1 message of /arm/joints")
            && table.contains("95.23"),
        "{table}"
    );
    let _: serde_json::Value = serde_json::to_value(&found).unwrap();
}

#[test]
fn the_draft_is_a_map_that_can_be_used() {
    let mut kept = example();
    let draft = inspect_reader(kept.as_mut(), &InspectOptions::default()).draft_map();
    for expected in [
        "[\"/arm/joints.velocity_wrist\"]\nfrom = \"/arm/joints.velocity[name='wrist']\"\n# unit = \"\" # fill in: rad/s if the joint turns",
        "from = \"/point.point.x\"\nunit = \"m\"",
        "from = \"/word.data\"\nvalues = [\"idle\"] # fill in",
        "#   hand in base (moving)",
        "position_of = \"hand\"\n# in_frame = \"world\"",
        "#   /point: 0.020000 s to 0.029000 s",
    ] {
        assert!(draft.contains(expected), "{expected}\nis not in\n{draft}");
    }
    assert!(
        !draft.contains("/tf.") && !draft.contains("stamp.sec"),
        "{draft}"
    );
    let map = TopicMap::parse("draft.toml", &draft).unwrap();
    let mut again = example();
    again.next = 0;
    let mut stream = crate::SignalStream::new(again, &map, &[]).unwrap();
    assert!(stream.absent().is_empty());
    let mut instants = 0;
    while stream.next_instant().unwrap().is_some() {
        instants += 1;
    }
    // The two messages at the end come more than a second too late.
    assert_eq!(
        (instants, stream.notes()[0].kind),
        (1000, crate::StreamNoteKind::Late)
    );
    let velocity = stream
        .layout()
        .signal("/arm/joints.velocity_wrist")
        .unwrap();
    assert_eq!(stream.snapshot().value(velocity), Some(2.0));
}

#[test]
fn an_empty_recording_has_nothing() {
    let mut kept = Kept::new(&Ros2Recording::new().unwrap().finish().unwrap());
    let found = inspect_reader(kept.as_mut(), &InspectOptions::default());
    assert_eq!(
        (found.messages, found.duration_secs(), found.complete),
        (0, None, true)
    );
    assert!(
        TopicMap::parse("draft.toml", &found.draft_map())
            .unwrap()
            .signals
            .is_empty()
    );
}
