//! MCAP files written by libraries that are not ours (`files/mcap/make.py`) give the numbers that were written; damaged
//! ones give some of them, and say what is lost.

use std::path::PathBuf;

use recording::{
    Encoding, Extractor, FieldPath, Format, Loss, OpenOptions, Reader, Schema, TopicInfo, Value,
    ValueKind, open, open_bytes,
};

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files/mcap")
        .join(name)
}

fn opened(name: &str) -> Box<dyn Reader + Send> {
    open(&path(name), &OpenOptions::default()).expect("a recording")
}

fn topic(reader: &dyn Reader, name: &str) -> TopicInfo {
    let topics = reader.topics().iter();
    let found = topics
        .filter(|topic| topic.name == name)
        .collect::<Vec<_>>();
    assert_eq!(found.len(), 1, "{name}");
    found[0].clone()
}

fn extractor(topic: &TopicInfo, paths: &[&str]) -> Extractor {
    let paths: Vec<FieldPath> = paths.iter().map(|p| FieldPath::parse(p).unwrap()).collect();
    Extractor::new(topic, &paths).unwrap_or_else(|error| panic!("{error}"))
}

/// The values of a topic's messages: log time in nanoseconds, then one for each path.
fn values(reader: &mut dyn Reader, name: &str, paths: &[&str]) -> Vec<(i64, Vec<f64>)> {
    let topic = topic(reader, name);
    let mut extractor = extractor(&topic, paths);
    let mut found = Vec::new();
    reader.select(&|info| info.id == topic.id);
    while let Some(message) = reader.next().expect("a readable file") {
        let mut row = vec![0.0; paths.len()];
        extractor
            .extract(message.data, &mut row)
            .unwrap_or_else(|error| panic!("{error}"));
        found.push((message.log_nanos, row));
    }
    found
}

/// Whether both are the same numbers, NaN being the same as NaN.
fn same(found: &[f64], expected: &[f64]) -> bool {
    found.len() == expected.len()
        && found
            .iter()
            .zip(expected)
            .all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
}

const ROS2: [&str; 3] = ["ros2_zstd.mcap", "ros2_lz4.mcap", "ros2_plain.mcap"];

#[test]
fn joint_states_give_the_numbers_that_were_written() {
    let paths = [
        "header.stamp.sec",
        "header.stamp.nanosec",
        "position[2]",
        "position[name='elbow']",
        "position[name='wrist']",
        "velocity[1]",
        "length(velocity)",
        "length(effort)",
        "effort[0]",
    ];
    for name in ROS2 {
        let mut reader = opened(name);
        let found = values(&mut *reader, "/joint_states", &paths);
        assert_eq!(found.len(), 20, "{name}");
        for (i, (log_nanos, row)) in found.iter().enumerate() {
            let n = i as f64;
            // Every fourth message has no wrist among its names.
            let wrist = if i % 4 == 0 { f64::NAN } else { n + 0.5 };
            let velocity = if i % 3 > 1 { -0.5 * n } else { f64::NAN };
            let expected = [
                1.7e9 + n,
                1000.0 * n,
                n + 0.5,
                n + 0.25,
                wrist,
                velocity,
                (i % 3) as f64,
                0.0,
                f64::NAN,
            ];
            assert_eq!(*log_nanos, 1_000_000 * i as i64);
            assert!(same(row, &expected), "{name} {i}: {row:?} {expected:?}");
        }
        assert!(reader.complete() && reader.checked() && reader.in_time_order());
    }
}

#[test]
fn transforms_are_found_by_their_frames() {
    let x = "transforms[child_frame_id='hand'].transform.translation.x";
    let both = "transforms[header.frame_id='base', child_frame_id='link1'].transform.translation.x";
    let never = "transforms[header.frame_id='map', child_frame_id='hand'].transform.rotation.w";
    let length = "length(transforms)";
    for name in ROS2 {
        let found = values(&mut *opened(name), "/tf", &[x, both, never, length]);
        for (i, (_, row)) in found.iter().enumerate() {
            let link = if i % 3 == 1 { f64::NAN } else { i as f64 + 1.0 };
            let expected = [(i + i % 3) as f64, link, f64::NAN, 3.0];
            assert!(same(row, &expected), "{name} {i}: {row:?}");
        }
        assert_eq!(found.len(), 20);
    }
}

#[test]
fn fields_behind_arrays_and_texts_are_found_and_aligned() {
    let paths = [
        "on",
        "a",
        "big",
        "f",
        "three[1]",
        "raw[5]",
        "length(raw)",
        "last",
    ];
    for name in ROS2 {
        let mut reader = opened(name);
        let info = topic(&*reader, "/mixed");
        let kinds = extractor(&info, &paths).kinds().to_vec();
        assert_eq!(kinds[0], ValueKind::Bool);
        assert!(kinds[2].may_round() && !kinds[3].may_round());
        let found = values(&mut *reader, "/mixed", &paths);
        assert_eq!(found.len(), 20);
        for (i, (_, row)) in found.iter().enumerate() {
            let n = i as f64;
            let raw = if i % 7 > 5 { 5.0 } else { f64::NAN };
            let expected = [
                (i % 2) as f64,
                -n,
                (2.0_f64).powi(53) + 2.0 * n,
                0.5 * n,
                -n,
                raw,
                (i % 7) as f64,
                -1e9 * n,
            ];
            assert!(same(row, &expected), "{name} {i}: {row:?} {expected:?}");
        }
    }
}

#[test]
fn texts_are_texts_or_positions_among_names() {
    let mut reader = opened("ros2_zstd.mcap");
    let info = topic(&*reader, "/mixed");
    let mut read = extractor(&info, &["word", "on"]);
    read.set_names(0, vec!["".into(), "a".into(), "ab".into()]);
    reader.select(&|other| other.id == info.id);
    let (mut i, mut row) = (0_usize, [0.0; 2]);
    while let Some(message) = reader.next().unwrap() {
        let word = "abcdefghi"[..i % 10].to_owned();
        let values = read.extract_values(message.data).unwrap();
        assert_eq!(values, [Value::Text(word), Value::Bool(i % 2 == 1)]);
        read.extract(message.data, &mut row).unwrap();
        let expected = if i % 10 < 3 {
            (i % 10) as f64
        } else {
            f64::NAN
        };
        assert!(same(&row[..1], &[expected]));
        read.verify(message.data).unwrap();
        i += 1;
    }
    assert_eq!(i, 20);
    let unlisted: Vec<&str> = read
        .unlisted()
        .iter()
        .map(|(_, text)| text.as_str())
        .collect();
    assert_eq!(unlisted.len(), 7);
    assert!(unlisted.contains(&"abc") && !unlisted.contains(&"ab"));
}

#[test]
fn another_version_of_a_type_is_noticed() {
    let mut reader = opened("ros2_zstd.mcap");
    let joints = topic(&*reader, "/joint_states");
    let Schema::Struct(message) = &*joints.schema else {
        panic!("no structure")
    };
    let mut shorter = message.clone();
    shorter.fields.pop();
    shorter.fields.pop();
    let wrong = TopicInfo {
        schema: std::sync::Arc::new(Schema::Struct(shorter)),
        ..joints.clone()
    };
    let mut read = extractor(&wrong, &["position[0]"]);
    reader.select(&|info| info.id == joints.id);
    let mut found = 0;
    while let Some(message) = reader.next().unwrap() {
        found += usize::from(read.verify(message.data).is_err());
    }
    assert_eq!(found, 20);
}

#[test]
fn rosbags_writes_what_we_read() {
    let mut reader = opened("rosbags.mcap");
    let info = topic(&*reader, "/imu");
    assert_eq!(
        (info.message_count, info.encoding),
        (Some(10), Encoding::Cdr)
    );
    let paths = [
        "header.stamp.nanosec",
        "orientation_covariance[8]",
        "angular_velocity.z",
        "linear_acceleration.z",
    ];
    let found = values(&mut *reader, "/imu", &paths);
    for (i, (log_nanos, row)) in found.iter().enumerate() {
        assert_eq!(*log_nanos, 1000 * i as i64);
        assert_eq!(*row, [5.0, 8.0 + i as f64, 0.1 * i as f64, 9.81]);
    }
    assert_eq!(found.len(), 10);
}

#[test]
fn json_is_read_with_and_without_a_schema_and_others_do_not_disturb_it() {
    let mut reader = opened("json_unchunked.mcap");
    assert_eq!(reader.metadata()["run.seed"], "7");
    let strange = topic(&*reader, "/strange");
    let refused = Extractor::new(&strange, &[FieldPath::parse("x").unwrap()]);
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("cannot be decoded")
    );
    let paths = [
        "hand.x",
        "v[1]",
        "length(v)",
        "ok",
        "gone",
        "nothing.there",
        "state",
    ];
    for (i, (_, row)) in values(&mut *reader, "/robot", &paths).iter().enumerate() {
        let n = i as f64;
        let expected = [
            0.1 * n,
            n + 1.0,
            2.0,
            f64::from(i % 2 == 0),
            f64::NAN,
            f64::NAN,
            f64::NAN,
        ];
        assert!(same(row, &expected), "{i}: {row:?}");
    }
    let by_name = values(
        &mut *opened("json_unchunked.mcap"),
        "/robot",
        &["position[name='wrist']", "v[0]"],
    );
    assert_eq!(by_name.len(), 10);
    assert!(
        by_name
            .iter()
            .enumerate()
            .all(|(i, (_, row))| *row == [3.0 * i as f64, i as f64])
    );
    assert_eq!(
        values(&mut *opened("json_unchunked.mcap"), "/bare", &["n"])[9].1,
        [9.0]
    );
}

#[test]
fn protobuf_knows_defaults_presence_and_packing() {
    let paths = [
        "count",
        "on",
        "speed",
        "mode",
        "hand.x",
        "length(points)",
        "points[1].x",
        "points[id='p2'].x",
        "values[2]",
        "values[names='elbow']",
        "big",
        "maybe",
    ];
    let mut reader = opened("protobuf.mcap");
    let mut read = extractor(&topic(&*reader, "/state"), &["names[1]", "mode"]);
    assert_eq!(read.kinds(), [ValueKind::Text, ValueKind::Enumeration]);
    let first = reader.next().unwrap().unwrap();
    let texts = read.extract_values(first.data).unwrap();
    assert_eq!(texts, [Value::Text("elbow".into()), Value::Number(0.0)]);
    let found = values(&mut *opened("protobuf.mcap"), "/state", &paths);
    assert_eq!(found.len(), 10);
    for (i, (_, row)) in found.iter().enumerate() {
        let n = i as f64;
        let only = |there: bool, value: f64| if there { value } else { f64::NAN };
        let points = i % 4;
        let expected = [
            -n,
            (i % 2) as f64,
            0.5 * n,
            (i % 2) as f64,
            only(i % 3 > 0, 1.5 * n),
            points as f64,
            only(points > 1, 10.0 * n + 1.0),
            only(points > 2, 10.0 * n + 2.0),
            300.0 * n,
            -n,
            (1_u64 << 60) as f64 + n,
            only(i % 3 > 0, n - 1.0),
        ];
        assert!(same(row, &expected), "{i}: {row:?} {expected:?}");
    }
}

/// Topic and time of all messages.
fn times(reader: &mut dyn Reader) -> Vec<(u32, i64)> {
    let mut found = Vec::new();
    while let Some(message) = reader.next().expect("a readable file") {
        found.push((message.topic.0, message.log_nanos));
    }
    found
}

#[test]
fn overlapping_chunks_come_in_order_of_time_if_memory_allows() {
    let mut reader = opened("overlapping.mcap");
    let ordered = times(&mut *reader);
    assert!(reader.in_time_order() && reader.complete());
    assert!(ordered.is_sorted_by_key(|(_, time)| *time));
    let options = OpenOptions {
        time_order: false,
        ..OpenOptions::default()
    };
    let mut reader = open(&path("overlapping.mcap"), &options).unwrap();
    let mut as_written = times(&mut *reader);
    assert!(!reader.in_time_order() && !as_written.is_sorted_by_key(|(_, time)| *time));
    as_written.sort_by_key(|(_, time)| *time);
    assert_eq!(as_written, ordered);
    // Chunks as they are in the other files overlap at their ends only.
    let little = OpenOptions {
        memory_bytes: 1,
        ..OpenOptions::default()
    };
    let mut reader = open(&path("ros2_zstd.mcap"), &little).unwrap();
    assert_eq!(times(&mut *reader).len(), 60);
}

/// Everything that a file gives: for each message its topic's name, time and bytes.
type Messages = Vec<(String, i64, Vec<u8>)>;

fn messages(bytes: Vec<u8>) -> Option<(Messages, Vec<Loss>, bool, bool)> {
    let mut reader = open_bytes(bytes, Format::Mcap, &OpenOptions::default()).ok()?;
    let mut found = Vec::new();
    while let Ok(Some(message)) = reader.next() {
        let (topic, data) = (message.topic, message.data.to_vec());
        let log_nanos = message.log_nanos;
        found.push((reader.topics()[topic.index()].name.clone(), log_nanos, data));
    }
    Some((
        found,
        reader.losses().to_vec(),
        reader.complete(),
        reader.checked(),
    ))
}

/// The messages of a whole file, which must be sound.
fn originals(bytes: &[u8]) -> Messages {
    let (all, losses, complete, _) = messages(bytes.to_vec()).expect("a sound file");
    assert!(losses.is_empty() && complete);
    all
}

const SMALL: [&str; 4] = [
    "ros2_small.mcap",
    "json_unchunked.mcap",
    "overlapping.mcap",
    "protobuf.mcap",
];

#[test]
fn a_file_cut_at_any_byte_gives_a_part_of_what_was_written_and_says_so() {
    for name in SMALL {
        let whole = std::fs::read(path(name)).unwrap();
        let all = originals(&whole);
        let mut most = 0;
        for length in 0..whole.len() {
            let Some((found, losses, complete, _)) = messages(whole[..length].to_vec()) else {
                assert!(length < 8, "{name} cut at {length} gives nothing");
                continue;
            };
            assert!(!complete, "{name} cut at {length} is taken for complete");
            assert!(
                found.iter().all(|one| all.contains(one)),
                "{name} cut at {length}"
            );
            assert!(
                losses.iter().all(|loss| loss.offset <= length as u64),
                "{losses:?}"
            );
            assert!(
                found.len() >= most || found.len() + 3 > most,
                "{name} {length}"
            );
            most = most.max(found.len());
        }
        assert_eq!(
            most,
            all.len(),
            "{name}: a file without its end still has all messages"
        );
    }
}

#[test]
fn a_flipped_bit_never_becomes_data_where_checksums_guard_it() {
    for name in SMALL {
        let whole = std::fs::read(path(name)).unwrap();
        let all = originals(&whole);
        for place in 0..whole.len() {
            for bit in [0, 3, 7] {
                let mut bytes = whole.clone();
                bytes[place] ^= 1 << bit;
                let Some((found, losses, complete, checked)) = messages(bytes) else {
                    assert!(place < 8, "{name} byte {place}");
                    continue;
                };
                if checked && name != "json_unchunked.mcap" {
                    let foreign = found.iter().filter(|one| !all.contains(one)).count();
                    assert_eq!(foreign, 0, "{name} byte {place} bit {bit}: {losses:?}");
                }
                let is_short = found.len() < all.len();
                assert!(
                    !is_short || !complete,
                    "{name} byte {place} bit {bit}: silent loss"
                );
            }
        }
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_the_rest_is_given() {
    let whole = std::fs::read(path("ros2_plain.mcap")).unwrap();
    let all = originals(&whole);
    // The first text of the second chunk or later, which nothing but the checksum guards.
    let place = whole
        .windows(5)
        .rposition(|window| window == b"elbow")
        .unwrap();
    let mut bytes = whole.clone();
    bytes[place] ^= 0x20;
    let (found, losses, complete, _) = messages(bytes).unwrap();
    assert!(!complete && losses.len() == 1, "{losses:?}");
    let lost = losses[0].messages.expect("the index tells how many") as usize;
    assert_eq!(found.len() + lost, all.len());
    assert!(lost > 0 && !found.is_empty());
    let (from, to) = losses[0].span_nanos.unwrap();
    let missing = all.iter().filter(|one| !found.contains(one));
    assert!(
        missing
            .clone()
            .all(|(_, time, _)| (from..=to).contains(time))
    );
    assert!(losses[0].to_string().contains("checksum"), "{}", losses[0]);
}

#[test]
fn without_an_index_reading_goes_on_at_the_next_chunk() {
    let whole = std::fs::read(path("ros2_zstd.mcap")).unwrap();
    let all = originals(&whole);
    // Break the end, so that the index is not believed, and the length of the second chunk (the first has the schemas).
    let mut bytes = whole[..whole.len() - 40].to_vec();
    let (mut at, mut chunks) = (8, Vec::new());
    while whole[at] != 0x0f {
        if whole[at] == 6 {
            chunks.push(at);
        }
        at += 9 + u64::from_le_bytes(whole[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    assert!(chunks.len() > 2);
    bytes[chunks[1] + 3] ^= 0x40;
    let (found, losses, complete, _) = messages(bytes).unwrap();
    assert!(!complete && !losses.is_empty());
    assert!(
        found.len() >= all.len() / 2 && found.len() < all.len(),
        "{} {losses:?}",
        found.len()
    );
    assert!(found.iter().all(|one| all.contains(one)));
}

#[test]
fn lying_lengths_cost_no_memory_and_no_panic() {
    let magic = b"\x89MCAP0\r\n";
    let chunk = |length: u64, claimed: u64, compressed: u64| {
        let mut bytes = magic.to_vec();
        bytes.push(6);
        bytes.extend(length.to_le_bytes());
        bytes.extend([0; 16]);
        bytes.extend(claimed.to_le_bytes());
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend(b"zstd");
        bytes.extend(compressed.to_le_bytes());
        bytes.extend([1; 30]);
        bytes
    };
    for (length, claimed, compressed) in [
        (u64::MAX, u64::MAX, u64::MAX),
        (u64::MAX - 8, 10, u64::MAX - 52),
        (44 + 30, u64::MAX, 30),
        (44 + 30, 1 << 29, 30),
        (44 + (1 << 60), 1 << 29, 1 << 60),
    ] {
        let (found, losses, complete, _) = messages(chunk(length, claimed, compressed)).unwrap();
        assert!(found.is_empty() && !losses.is_empty() && !complete);
        assert!(losses.iter().any(|loss| loss.offset >= 8), "{losses:?}");
    }
}
