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
