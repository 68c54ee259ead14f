//! A small pack with parts of every kind.

use pack::{About, Content, Key, NotShown, Part, Recording, Role, Sace, write};

pub fn key() -> Key {
    Key::of_seed(std::array::from_fn(|at| at as u8 * 7))
}

pub fn parts() -> Vec<Part> {
    let bytes: Vec<u8> = (0..=255).cycle().take(1_000).collect();
    vec![
        Part::new(
            "results/study.json",
            Role::Results,
            "the result",
            Content::text("{}\n"),
        )
        .as_sace(Sace::TT),
        Part::new(
            "study/../a b.prism",
            Role::Study,
            "a model",
            Content::text("dtmc\n"),
        ),
        Part::new(
            "study/table.csv",
            Role::Study,
            "trials",
            Content::bytes(bytes),
        ),
        Part::new("empty", Role::Log, "nothing", Content::bytes(Vec::new())).as_sace(Sace::SS),
    ]
}

pub fn about() -> About {
    About {
        not_shown: vec![NotShown {
            of: "1a".into(),
            words: "undecided".into(),
        }],
        recordings: vec![Recording {
            path: "run.mcap".into(),
            bytes: 7,
            sha256: "00".repeat(32),
            part: None,
        }],
        ..About::new("A robot docks at its charger")
    }
}

/// A pack, signed or not.
pub fn archive(key: Option<&Key>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(parts(), about(), key, &mut bytes).expect("it is written");
    bytes
}

/// The names and contents of an archive, read by a reader of its own.
pub fn entries(archive: &[u8]) -> Vec<(String, Vec<u8>)> {
    let number = |at: usize| {
        u32::from_le_bytes(archive[at..at + 4].try_into().expect("four bytes")) as usize
    };
    let mut found = Vec::new();
    let mut at = 0;
    while archive[at..].starts_with(b"PK\x03\x04") {
        let (size, length) = (
            number(at + 22),
            usize::from(archive[at + 26]) + 256 * usize::from(archive[at + 27]),
        );
        let name = String::from_utf8(archive[at + 30..at + 30 + length].to_vec()).expect("a name");
        let begin = at + 30 + length;
        found.push((name, archive[begin..begin + size].to_vec()));
        at = begin + size;
    }
    found
}

/// An archive of these entries, as the format has it.
pub fn formed(entries: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in entries {
        let offset = bytes.len() as u32;
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc32fast::hash(content).to_le_bytes());
        common.extend((content.len() as u32).to_le_bytes());
        common.extend((content.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(name.as_bytes());
        bytes.extend(content);
        directory.extend(b"PK\x01\x02\x14\x03");
        directory.extend(&common);
        directory.extend([0; 6]);
        directory.extend((0o100_644u32 << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (begin, size, count) = (
        bytes.len() as u32,
        directory.len() as u32,
        entries.len() as u16,
    );
    bytes.extend(directory);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend(count.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend(size.to_le_bytes());
    bytes.extend(begin.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}
