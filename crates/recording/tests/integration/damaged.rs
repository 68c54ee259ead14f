//! Damaged recordings, from bytes to signals: each is inspected, its draft is taken as a topic map,
//! and all signals are streamed. Nothing panics, drafts are maps, times do not go back, and numbers
//! that are not in the recording do not count as complete without a checksum that says otherwise.

use std::path::{Path, PathBuf};

use recording::{
    Format, InspectOptions, OpenOptions, SignalStream, TopicMap, inspect_reader, open_bytes,
};

type Checked = Result<(), Box<dyn std::error::Error>>;

/// A generator of numbers that look random: D. E. Knuth's MMIX (The Art of Computer Programming,
/// volume 2, section 3.3.4).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: usize) -> usize {
        let (factor, step) = (6_364_136_223_846_793_005, 1_442_695_040_888_963_407);
        self.0 = self.0.wrapping_mul(factor).wrapping_add(step);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

fn files() -> Vec<(PathBuf, Format)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    [
        ("frames/frames.bag", Format::Ros1Bag),
        ("frames/frames/frames.mcap", Format::Mcap),
        ("rosbags/none.bag", Format::Ros1Bag),
        ("rosbags/humble.db3", Format::Rosbag2Database),
    ]
    .map(|(name, format)| (folder.join(name), format))
    .into()
}

fn options() -> OpenOptions {
    OpenOptions {
        record_bytes: 1 << 22,
        memory_bytes: 1 << 22,
        ..OpenOptions::default()
    }
}

/// Inspects `bytes`, and streams all that its draft names; gives how many moments there were.
fn followed(bytes: &[u8], format: Format) -> Result<usize, Box<dyn std::error::Error>> {
    let Ok(mut reader) = open_bytes(bytes.to_vec(), format, &options()) else {
        return Ok(0);
    };
    let found = inspect_reader(reader.as_mut(), &InspectOptions::default());
    assert!(!found.to_string().is_empty());
    let draft = found.draft_map();
    let frames = "\n[\"/tested\"]\nposition_of = \"hand\"\nin_frame = \"world\"\n";
    let mut moments = 0;
    for time in ["log", "header"] {
        let text = draft.replace("from = \"log\"", &format!("from = \"{time}\"")) + frames;
        let map = TopicMap::parse("draft", &text).map_err(|mut errors| errors.remove(0))?;
        let reader = open_bytes(bytes.to_vec(), format, &options())?;
        let Ok(mut stream) = SignalStream::new(reader, &map, &[]) else {
            continue;
        };
        let mut last_nanos = i64::MIN;
        while let Ok(Some(moment)) = stream.next_instant() {
            assert!(moment.time_nanos >= last_nanos);
            last_nanos = moment.time_nanos;
            moments += 1;
        }
        for note in stream.notes() {
            assert!(note.count > 0 && note.to_string().len() > 20);
        }
    }
    Ok(moments)
}

#[test]
fn undamaged_recordings_are_followed_to_their_end() -> Checked {
    for (path, format) in files() {
        let moments = followed(&std::fs::read(&path)?, format)?;
        assert!(moments > 20, "{}: {moments}", path.display());
    }
    Ok(())
}

#[test]
fn flipped_bits_never_panic() -> Checked {
    let mut numbers = Numbers(1);
    for (path, format) in files() {
        let bytes = std::fs::read(&path)?;
        for _ in 0..150 {
            let mut damaged = bytes.clone();
            for _ in 0..=numbers.below(3) {
                let at = numbers.below(damaged.len());
                damaged[at] ^= 1 << numbers.below(8);
            }
            followed(&damaged, format)?;
        }
    }
    Ok(())
}

#[test]
fn overwritten_and_cut_stretches_never_panic() -> Checked {
    let mut numbers = Numbers(2);
    for (path, format) in files() {
        let bytes = std::fs::read(&path)?;
        for _ in 0..100 {
            let mut damaged = bytes.clone();
            let at = numbers.below(damaged.len());
            let length = numbers.below(64).min(damaged.len() - at);
            if numbers.below(2) == 0 {
                damaged.drain(at..at + length);
            } else {
                let value = [0x00, 0xff, 0x7f][numbers.below(3)];
                damaged[at..at + length].fill(value);
            }
            followed(&damaged, format)?;
        }
    }
    Ok(())
}
