//! Reading on two threads is reading: the same messages, losses and errors at the same moments.

use std::io::{self, Cursor, Seek, SeekFrom};
use std::sync::Arc;

use super::*;

/// A file of 12 chunks with messages of two topics, some of them out of order.
fn file(compression: Option<::mcap::Compression>) -> Vec<u8> {
    let options = ::mcap::WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(4_000));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let channels = ["/a", "/b"].map(|topic| {
        writer
            .add_channel(0, topic, "json", &BTreeMap::new())
            .unwrap()
    });
    for number in 0..500_u64 {
        let header = ::mcap::records::MessageHeader {
            channel_id: channels[usize::from(number % 7 == 0)],
            sequence: number as u32,
            log_time: 1_000 * (number ^ 8),
            publish_time: 1_000 * number,
        };
        let data = format!(
            "{{\"number\": {number}, \"text\": \"{:080}\"}}",
            number * number
        );
        writer
            .write_to_known_channel(&header, data.as_bytes())
            .unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// Everything that can be seen of reading a file, in order; after `select_after` messages, only `/a`
/// is read.
fn seen(
    source: impl Read + Seek + Send + 'static,
    (has_thread, look_ahead, select_after): (bool, bool, usize),
) -> Vec<String> {
    let options = OpenOptions {
        look_ahead,
        ..OpenOptions::default()
    };
    let mut reader = match McapReader::new(source, &options) {
        Ok(reader) => reader,
        Err(error) => return vec![error.to_string()],
    };
    if !has_thread {
        reader.ahead.stay_here();
    }
    let mut seen = Vec::new();
    loop {
        if seen.len() == select_after {
            reader.select(&|topic| topic.name == "/a");
        }
        let step = match reader.next() {
            Ok(Some(message)) => format!("{message:?}"),
            Ok(None) => "end".to_owned(),
            Err(error) => error.to_string(),
        };
        let is_end = !step.starts_with("RawMessage");
        let state = (reader.complete(), reader.checked(), reader.topics().len());
        seen.push(format!("{step} {state:?} {:?}", reader.losses()));
        if is_end {
            return seen;
        }
    }
}

#[test]
fn a_second_thread_changes_nothing() {
    for compression in [None, Some(::mcap::Compression::Zstd)] {
        let whole = file(compression);
        let places = (0..whole.len()).step_by(whole.len() / 90);
        for (turn, place) in places.enumerate() {
            let mut flipped = whole.clone();
            flipped[place] ^= 0x10;
            for bytes in [flipped, whole[..place].to_vec()] {
                let how = |has_thread| (has_thread, turn % 3 != 0, 40 * (turn % 15));
                let there = seen(Cursor::new(bytes.clone()), how(true));
                let here = seen(Cursor::new(bytes), how(false));
                let other = there.iter().zip(&here).find(|(there, here)| there != here);
                assert_eq!(other, None, "byte {place}");
                assert_eq!(there.len(), here.len());
            }
        }
        let all = seen(Cursor::new(whole.clone()), (true, true, usize::MAX));
        assert_eq!(all.len(), 501, "500 messages and the end");
        assert!(all[500].starts_with("end (true, true, 2) []"));
        // After 100 messages, those of /b are left out.
        let some = seen(Cursor::new(whole), (true, true, 100));
        assert_eq!(some[..100], all[..100]);
        assert!((400..490).contains(&some.len()), "{}", some.len());
    }
}

/// A file whose medium fails from a place on, once it was opened.
struct Failing {
    bytes: Cursor<Vec<u8>>,
    from: u64,
    reads_left: usize,
    alive: Arc<()>,
}

impl Read for Failing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.reads_left = self.reads_left.saturating_sub(1);
        if self.reads_left == 0 && self.bytes.position() >= self.from {
            return Err(io::Error::other("the disk is broken"));
        }
        self.bytes.read(buffer)
    }
}

impl Seek for Failing {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

#[test]
fn a_broken_medium_is_told_after_what_was_read_before() {
    let bytes = file(None);
    let mut reads = 0..;
    let opened = reads.find(|reads_left| {
        let source = failing(&bytes, 0, *reads_left);
        McapReader::new(source, &OpenOptions::default()).is_ok()
    });
    let from = bytes.len() as u64 / 2;
    let how = |has_thread| {
        let source = failing(&bytes, from, opened.unwrap());
        seen(source, (has_thread, true, usize::MAX))
    };
    let there = how(true);
    assert_eq!(there, how(false));
    assert!((100..400).contains(&there.len()), "{}", there.len());
    assert!(there[there.len() - 1].contains("the disk is broken"));
}

fn failing(bytes: &[u8], from: u64, reads_left: usize) -> Failing {
    Failing {
        bytes: Cursor::new(bytes.to_vec()),
        from,
        reads_left,
        alive: Arc::new(()),
    }
}

#[test]
fn the_thread_ends_with_its_reader() {
    let source = failing(&file(None), u64::MAX, 0);
    let alive = source.alive.clone();
    let mut reader = McapReader::new(source, &OpenOptions::default()).unwrap();
    assert!(reader.next().unwrap().is_some());
    assert_eq!(Arc::strong_count(&alive), 2);
    drop(reader);
    assert_eq!(Arc::strong_count(&alive), 1);
}
