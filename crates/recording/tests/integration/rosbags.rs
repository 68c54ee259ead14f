//! Recordings written by the `rosbags` library (see `files/make_rosbags.py`), whole and damaged.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use recording::{
    Extractor, FieldPath, Format, Loss, OpenOptions, ReadError, Reader, Value, open, open_bytes,
};

/// A message with what identifies it in any format.
type Message = (String, i64, Vec<u8>);

/// How many messages each of the files has.
const MESSAGES: usize = 29;

const ROS1_FILES: [&str; 5] = [
    "none.bag",
    "bz2.bag",
    "lz4.bag",
    "unfinished.bag",
    "unordered.bag",
];
const ROS2_FILES: [&str; 9] = [
    "sqlite",
    "sqlite_file",
    "sqlite_message",
    "split",
    "humble.db3",
    "live_copy.db3",
    "mcap",
    "mcap_file",
    "mcap_message",
];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files/rosbags")
        .join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    fs::read(file(name)).unwrap()
}

/// All messages that a reader gives, and its losses.
fn read(reader: &mut dyn Reader) -> Result<Vec<Message>, ReadError> {
    let names: Vec<String> = reader
        .topics()
        .iter()
        .map(|topic| topic.name.clone())
        .collect();
    let mut messages = Vec::new();
    while let Some(message) = reader.next()? {
        let topic = names[message.topic.index()].clone();
        messages.push((topic, message.log_nanos, message.data.to_vec()));
    }
    Ok(messages)
}

fn read_file(name: &str) -> (Vec<Message>, Vec<Loss>) {
    let mut reader = open(&file(name), &OpenOptions::default()).unwrap();
    let messages = read(&mut *reader).unwrap();
    assert_eq!(reader.complete(), reader.losses().is_empty());
    (messages, reader.losses().to_vec())
}

#[test]
fn every_container_gives_the_same_bytes_in_order() {
    for files in [&ROS1_FILES[..], &ROS2_FILES[..]] {
        let (expected, losses) = read_file(files[0]);
        assert_eq!((expected.len(), losses.len()), (MESSAGES, 0));
        assert!(expected.is_sorted_by_key(|(_, nanos, _)| *nanos));
        for name in &files[1..] {
            let (messages, losses) = read_file(name);
            assert_eq!(messages, expected, "{name}");
            assert_eq!(
                losses.len(),
                usize::from(*name == "unfinished.bag"),
                "{name}"
            );
        }
    }
}

/// How long a held value counts must not hang on which file it lies in, or on which topics are read.
#[test]
fn every_container_knows_when_its_recording_ended_whatever_is_selected() {
    for name in ROS1_FILES.iter().chain(&ROS2_FILES) {
        let (all, _) = read_file(name);
        let last = all.iter().map(|(_, nanos, _)| *nanos).max();
        let first = all[0].0.clone();
        let mut reader = open(&file(name), &OpenOptions::default()).unwrap();
        reader.select(&|topic| topic.name == first);
        let selected = read(&mut *reader).unwrap();
        assert!(selected.iter().all(|(topic, ..)| *topic == first), "{name}");
        assert_eq!(reader.end_nanos(), last, "{name}");
    }
}

/// A row of `expected.csv`: topic, time, path, value as Python writes it.
fn expected_values() -> Vec<(String, i64, String, String)> {
    let text = fs::read_to_string(file("expected.csv")).unwrap();
    let row = |line: &str| {
        let mut cells = line.splitn(4, ',').map(str::to_owned);
        let mut cell = || cells.next().unwrap();
        (cell(), cell().parse().unwrap(), cell(), cell())
    };
    text.lines().map(row).collect()
}

/// Checks each value of each message of a recording against `expected.csv`.
fn check_values(name: &str) {
    let mut reader = open(&file(name), &OpenOptions::default()).unwrap();
    let topics = reader.topics().to_vec();
    let mut rows = expected_values();
    while let Some(message) = reader.next().unwrap() {
        let topic = &topics[message.topic.index()];
        let is_here =
            |row: &(String, i64, String, String)| row.0 == topic.name && row.1 == message.log_nanos;
        let (here, rest): (Vec<_>, Vec<_>) = rows.into_iter().partition(is_here);
        rows = rest;
        assert!(
            !here.is_empty(),
            "{name}: {} at {} is unexpected",
            topic.name,
            message.log_nanos
        );
        let paths: Vec<FieldPath> = here.iter().map(|row| row.2.parse().unwrap()).collect();
        let mut extractor = Extractor::new(topic, &paths).unwrap();
        extractor.verify(message.data).unwrap();
        let values = extractor.extract_values(message.data).unwrap();
        for ((_, nanos, path, expected), value) in here.iter().zip(values) {
            let is_equal = match &value {
                // Bit for bit: the shortest decimal number that is read back as the same double.
                Value::Number(value) => expected
                    .parse::<f64>()
                    .is_ok_and(|number| number.to_bits() == value.to_bits()),
                Value::Bool(value) => expected == &value.to_string(),
                Value::Text(value) => expected == &format!("\"{value}\""),
                Value::Missing => false,
            };
            assert!(
                is_equal,
                "{name}: {path} of {} at {nanos}: {value:?} is not {expected}",
                topic.name
            );
        }
    }
    assert!(
        rows.is_empty(),
        "{name}: {} values are not in the recording",
        rows.len()
    );
}

#[test]
fn every_value_is_the_one_that_was_written() {
    for name in ROS1_FILES.into_iter().chain(ROS2_FILES) {
        check_values(name);
    }
}

#[test]
fn topics_types_counts_and_notes_are_told() {
    for name in ["none.bag", "sqlite", "split", "unfinished.bag"] {
        let reader = open(&file(name), &OpenOptions::default()).unwrap();
        let topics: Vec<_> = reader
            .topics()
            .iter()
            .map(|topic| (topic.name.as_str(), topic.message_count))
            .collect();
        let expected = [
            ("/joint_states", 12),
            ("/tf", 6),
            ("/ready", 4),
            ("/state", 4),
            ("/scan", 3),
        ];
        assert_eq!(
            topics,
            expected.map(|(name, count)| (name, Some(count))),
            "{name}"
        );
    }
    let reader = open(&file("humble.db3"), &OpenOptions::default()).unwrap();
    assert_eq!(reader.topics()[1].type_name, "tf2_msgs/msg/TFMessage");
    assert_eq!(reader.metadata()["ros_distro"], "humble");
}

#[test]
fn only_selected_topics_are_given() {
    for name in ROS1_FILES.into_iter().chain(ROS2_FILES) {
        let (mut expected, _) = read_file(name);
        expected.retain(|(topic, ..)| topic == "/scan" || topic == "/ready");
        let mut reader = open(&file(name), &OpenOptions::default()).unwrap();
        reader.select(&|topic| topic.name == "/scan" || topic.name == "/ready");
        assert_eq!(read(&mut *reader).unwrap(), expected, "{name}");
        let mut reader = open(&file(name), &OpenOptions::default()).unwrap();
        for _ in 0..3 {
            reader.next().unwrap();
        }
        reader.select(&|topic| topic.name == "/scan");
        let rest = read(&mut *reader).unwrap();
        assert_eq!(rest.len(), 3, "{name}");
    }
}

/// Reads damaged bytes; what is given must be among `whole`, without repetition, unless `may_differ`.
fn read_damaged(data: Vec<u8>, format: Format, whole: &BTreeSet<Message>) -> Option<(usize, bool)> {
    let mut reader = match open_bytes(data, format, &OpenOptions::default()) {
        Ok(reader) => reader,
        Err(error) => {
            assert!(error.to_string().len() > 40, "{error}");
            return None;
        }
    };
    let messages = read(&mut *reader).unwrap();
    let count = messages.len();
    let distinct: BTreeSet<Message> = messages.into_iter().collect();
    assert_eq!(distinct.len(), count, "a message is given twice");
    if let Some(foreign) = distinct.difference(whole).next() {
        panic!("a message was not recorded: {foreign:?}");
    }
    Some((count, reader.complete()))
}

/// Cuts a file at every `step`th byte: whatever is given was recorded, and no cut goes unnoticed.
fn cut_everywhere(name: &str, format: Format, step: usize) {
    let whole: BTreeSet<Message> = read_file(name).0.into_iter().collect();
    let data = bytes(name);
    let mut most = 0;
    for len in (0..data.len()).step_by(step) {
        if let Some((count, is_complete)) = read_damaged(data[..len].to_vec(), format, &whole) {
            assert!(
                !is_complete,
                "{name} cut at {len} of {} counts as complete",
                data.len()
            );
            assert!(
                count >= most,
                "{name} cut at {len} gives less than cut before"
            );
            most = count;
        }
    }
    assert!(
        most >= MESSAGES / 2,
        "of the longest cut file {most} messages are recovered"
    );
}

#[test]
fn a_bag_cut_anywhere_gives_only_what_was_recorded() {
    cut_everywhere("none.bag", Format::Ros1Bag, 1);
    cut_everywhere("lz4.bag", Format::Ros1Bag, 1);
    cut_everywhere("unfinished.bag", Format::Ros1Bag, 1);
    cut_everywhere("bz2.bag", Format::Ros1Bag, 37);
}

#[test]
fn a_database_cut_anywhere_gives_only_what_was_recorded() {
    let whole: BTreeSet<Message> = read_file("humble.db3").0.into_iter().collect();
    let data = bytes("humble.db3");
    let mut most = 0;
    for len in 0..data.len() {
        if let Some((count, is_complete)) =
            read_damaged(data[..len].to_vec(), Format::Rosbag2Database, &whole)
        {
            assert!(!is_complete, "cut at {len} counts as complete");
            most = most.max(count);
        }
    }
    assert!(
        most >= MESSAGES / 2,
        "of the longest cut file {most} messages are recovered"
    );
}

/// Puts wrong bytes at each place. Formats without checksums cannot notice all of them, but nothing
/// may crash, and lengths that lie must not be followed.
fn spoil_everywhere(name: &str, format: Format, step: usize) {
    let data = bytes(name);
    let spoils: [fn(&mut [u8]); 3] = [
        |place| place[0] ^= 0x10,
        |place| place.fill(0xff),
        |place| place.fill(0),
    ];
    for (index, at) in (0..data.len() - 4).step_by(step).enumerate() {
        let mut spoiled = data.clone();
        spoils[index % spoils.len()](&mut spoiled[at..at + 4]);
        let Ok(mut reader) = open_bytes(spoiled, format, &OpenOptions::default()) else {
            continue;
        };
        let messages = read(&mut *reader).unwrap();
        assert!(
            messages.len() <= MESSAGES + 1,
            "{name} spoiled at {at} has more than was recorded"
        );
        if messages.len() < MESSAGES {
            assert!(
                !reader.complete(),
                "{name} spoiled at {at} lacks messages and counts as complete"
            );
        }
    }
}

#[test]
fn spoiled_bags_neither_crash_nor_lose_messages_silently() {
    spoil_everywhere("none.bag", Format::Ros1Bag, 1);
    spoil_everywhere("lz4.bag", Format::Ros1Bag, 1);
    spoil_everywhere("unfinished.bag", Format::Ros1Bag, 1);
    spoil_everywhere("bz2.bag", Format::Ros1Bag, 37);
}

#[test]
fn spoiled_databases_neither_crash_nor_lose_messages_silently() {
    spoil_everywhere("humble.db3", Format::Rosbag2Database, 1);
}

#[test]
fn a_damaged_chunk_is_named_with_its_place_and_the_others_are_read() {
    let mut data = bytes("bz2.bag");
    let second = find(&data, b"BZh9", 1).unwrap();
    data[second + 30] ^= 0xff;
    let mut reader = open_bytes(data, Format::Ros1Bag, &OpenOptions::default()).unwrap();
    let found = read(&mut *reader).unwrap().len();
    let [loss] = reader.losses() else {
        panic!("one chunk is damaged: {:?}", reader.losses())
    };
    assert_eq!(found as u64 + loss.messages.unwrap(), MESSAGES as u64);
    assert!(loss.offset < second as u64 && loss.offset + 200 > second as u64);
    assert!(
        loss.to_string().contains("cannot be uncompressed"),
        "{loss}"
    );
    let (from, to) = loss.span_nanos.unwrap();
    assert!(1_700_000_000_000_000_000 <= from && from < to);
}

/// Where `pattern` is found for the `nth` time, from 0.
fn find(data: &[u8], pattern: &[u8], nth: usize) -> Option<usize> {
    let mut places = data
        .windows(pattern.len())
        .enumerate()
        .filter(|(_, window)| *window == pattern);
    places.nth(nth).map(|(place, _)| place)
}

#[test]
fn an_index_that_lies_is_noticed() {
    let data = bytes("none.bag");
    // Where the index says that the second chunk is, and how many messages of the last connection it
    // says that the last chunk has.
    let place = find(&data, b"chunk_pos=", 1).unwrap() + b"chunk_pos=".len();
    for place in [place, data.len() - 4] {
        let mut data = data.clone();
        data[place] ^= 1;
        let mut reader = open_bytes(data, Format::Ros1Bag, &OpenOptions::default()).unwrap();
        read(&mut *reader).unwrap();
        assert!(!reader.complete(), "byte {place}");
    }
}

/// A copy of a folder, to take things out of it.
fn copy_of(name: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(file(name)).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    folder
}

#[test]
fn a_part_that_is_not_there_is_told() {
    let folder = copy_of("split");
    fs::remove_file(folder.path().join("z_0.db3")).unwrap();
    let mut reader = open(folder.path(), &OpenOptions::default()).unwrap();
    let found = read(&mut *reader).unwrap().len();
    let [loss] = reader.losses() else {
        panic!("one file is gone")
    };
    assert!(loss.message.contains("z_0.db3"), "{loss}");
    assert_eq!(found as u64 + loss.messages.unwrap(), MESSAGES as u64);
    assert!(!reader.complete());
    fs::remove_file(folder.path().join("a_1.db3")).unwrap();
    let error = open(folder.path(), &OpenOptions::default())
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains("copy the whole folder"), "{error}");
}

#[test]
fn a_folder_whose_recorder_was_killed_is_read_in_the_order_of_its_files() {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("run");
    fs::create_dir(&folder).unwrap();
    fs::copy(file("split/a_1.db3"), folder.join("run_10.db3")).unwrap();
    fs::copy(file("split/z_0.db3"), folder.join("run_9.db3")).unwrap();
    let mut reader = open(&folder, &OpenOptions::default()).unwrap();
    assert_eq!(read(&mut *reader).unwrap(), read_file("split").0);
    assert!(reader.losses()[0].message.contains("metadata.yaml"));
    assert!(!reader.complete());
}

#[test]
fn messages_that_only_the_metadata_know_are_told() {
    let folder = copy_of("split");
    let path = folder.path().join("metadata.yaml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(
        &path,
        text.replace("message_count: 14", "message_count: 20"),
    )
    .unwrap();
    let mut reader = open(folder.path(), &OpenOptions::default()).unwrap();
    assert_eq!(read(&mut *reader).unwrap().len(), MESSAGES);
    let [loss] = reader.losses() else {
        panic!("the second file has less than it should")
    };
    assert_eq!(loss.messages, Some(6));
    assert!(
        loss.message.contains("a_1.db3") && loss.message.contains("-wal"),
        "{loss}"
    );
}

#[test]
fn rows_that_are_only_in_the_log_are_missed_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.db3");
    fs::copy(file("live_copy.db3"), &path).unwrap();
    let mut reader = open(&path, &OpenOptions::default()).unwrap();
    assert_eq!(read(&mut *reader).unwrap().len(), 10);
    // A log that is cut gives what was committed before the cut.
    let log = bytes("live_copy.db3-wal");
    fs::write(folder.path().join("run.db3-wal"), &log[..log.len() - 1]).unwrap();
    let mut reader = open(&path, &OpenOptions::default()).unwrap();
    let found = read(&mut *reader).unwrap();
    assert_eq!(found[..], read_file("humble.db3").0[..MESSAGES - 1]);
}

#[test]
fn a_database_within_a_transaction_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.db3");
    fs::copy(file("humble.db3"), &path).unwrap();
    let journal = folder.path().join("run.db3-journal");
    fs::write(&journal, [0; 512]).unwrap();
    assert!(
        open(&path, &OpenOptions::default()).is_ok(),
        "a journal that was emptied does not count"
    );
    fs::write(
        &journal,
        [0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7, 0, 0],
    )
    .unwrap();
    let error = open(&path, &OpenOptions::default())
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("close the recorder") && error.contains("sqlite3"),
        "{error}"
    );
}

#[test]
fn other_databases_and_older_bags_are_refused_with_a_remedy() {
    let message = |data: &[u8], format| {
        let opened = open_bytes(data.to_vec(), format, &OpenOptions::default());
        opened.err().unwrap().to_string()
    };
    let older = message(b"#ROSBAG V1.2\n and so on", Format::Ros1Bag);
    assert!(older.contains("rosbag fix"), "{older}");
    let mut renamed = bytes("humble.db3");
    while let Some(place) = find(&renamed, b"messages", 0) {
        renamed[place..place + 8].copy_from_slice(b"massages");
    }
    let other = message(&renamed, Format::Rosbag2Database);
    assert!(other.contains("\"topics\" and \"messages\""), "{other}");
    let folder = copy_of("sqlite");
    let path = folder.path().join("metadata.yaml");
    let text = fs::read_to_string(&path).unwrap();
    for (old, new, told) in [
        (
            "storage_identifier: sqlite3",
            "storage_identifier: other",
            "ros2 bag convert",
        ),
        ("rosbag2_bagfile", "rosbag2", "ros2 bag reindex"),
        (
            "compression_mode: ''",
            "compression_mode: message\n  compression_format: lz4",
            "lz4",
        ),
    ] {
        let text = text
            .replace("  compression_format: ''\n", "")
            .replace(old, new);
        fs::write(&path, text).unwrap();
        let error = open(folder.path(), &OpenOptions::default())
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains(told), "{error}");
    }
}
