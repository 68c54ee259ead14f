//! How the files of recordings that other libraries wrote are stored.

use std::path::Path;

use recording::{InspectOptions, OpenOptions, inspect};

type Checked = Result<(), Box<dyn std::error::Error>>;

fn stored(path: &Path) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let found = inspect(path, &OpenOptions::default(), &InspectOptions::default())?;
    let lines: Vec<String> = found.files.iter().map(ToString::to_string).collect();
    // What is told in words is told in the table, too.
    assert!(lines.iter().all(|line| found.to_string().contains(line)));
    Ok(lines)
}

#[test]
fn compression_chunks_and_index_are_told() -> Checked {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    for (name, expected) in [
        (
            "mcap/ros2_plain.mcap",
            &["MCAP, not compressed, 4 chunks, index sound"][..],
        ),
        (
            "mcap/ros2_zstd.mcap",
            &["MCAP, chunks compressed (zstd), 4 chunks, index sound"],
        ),
        (
            "mcap/ros2_lz4.mcap",
            &["MCAP, chunks compressed (lz4), 4 chunks, index sound"],
        ),
        (
            "mcap/json_unchunked.mcap",
            &["MCAP, not compressed, 0 chunks, index sound"],
        ),
        (
            "rosbags/none.bag",
            &["ROS 1 bag, not compressed, 5 chunks, index sound"],
        ),
        (
            "rosbags/bz2.bag",
            &["ROS 1 bag, chunks compressed (bz2), 5 chunks, index sound"],
        ),
        (
            "rosbags/lz4.bag",
            &["ROS 1 bag, chunks compressed (lz4), 5 chunks, index sound"],
        ),
        (
            "rosbags/unfinished.bag",
            &["ROS 1 bag, chunks compressed (lz4), 5 chunks, without an index"],
        ),
        ("rosbags/humble.db3", &["SQLite, not compressed"]),
        (
            "rosbags/mcap",
            &["mcap.mcap: MCAP, not compressed, 1 chunk, index without a checksum"],
        ),
        (
            "rosbags/mcap_message",
            &[
                "mcap_message.mcap: MCAP, messages compressed (zstd), 1 chunk, index without a checksum",
            ],
        ),
        (
            "rosbags/mcap_file",
            &[
                "mcap_file.mcap.zstd: MCAP, compressed as a whole (zstd), 1 chunk, index without a checksum",
            ],
        ),
        (
            "rosbags/mcap_file/mcap_file.mcap.zstd",
            &["MCAP, compressed as a whole (zstd), 1 chunk, index without a checksum"],
        ),
        (
            "rosbags/sqlite_message",
            &["sqlite_message.db3: SQLite, messages compressed (zstd)"],
        ),
        (
            "rosbags/sqlite_message/sqlite_message.db3",
            &["SQLite, messages compressed (zstd)"],
        ),
        (
            "rosbags/sqlite_file",
            &["sqlite_file.db3.zstd: SQLite, compressed as a whole (zstd)"],
        ),
        (
            "rosbags/split",
            &[
                "z_0.db3: SQLite, not compressed",
                "a_1.db3: SQLite, not compressed",
            ],
        ),
    ] {
        assert_eq!(stored(&folder.join(name))?, expected, "{name}");
    }
    Ok(())
}

#[test]
fn a_cut_file_has_no_index_and_a_flipped_bit_makes_it_damaged() -> Checked {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/mcap/ros2_zstd.mcap");
    let bytes = std::fs::read(source)?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("damaged.mcap");
    std::fs::write(&path, &bytes[..bytes.len() - 1])?;
    assert!(stored(&path)?[0].ends_with("4 chunks, without an index"));
    // The last bytes are the footer of 29 bytes and the magic of 8; before it stands the summary.
    let mut flipped = bytes.clone();
    let at = flipped.len() - 60;
    flipped[at] ^= 1;
    std::fs::write(&path, &flipped)?;
    assert!(stored(&path)?[0].ends_with("4 chunks, index damaged"));
    Ok(())
}
