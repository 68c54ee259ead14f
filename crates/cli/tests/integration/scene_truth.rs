//! Truth of a scene as a user meets it: what `inspect STUDY` lists, what a proposition gets recorded by naming it, and what a
//! misspelt name is told. The corridor, whose robot is driven by a program in Python.

use crate::support;

use support::copy_study;
use support::simulation::{driven, library};

/// The corridor's study with another meaning of `moving`, in a folder of its own.
fn corridor(moving: &str) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let study = support::root().join("case-studies/corridor");
    copy_study(&study, folder.path());
    let vocabulary = folder.path().join("vocabulary.toml");
    let text = std::fs::read_to_string(&vocabulary).expect("a vocabulary");
    let old = "trace = \"/truth/carrier.speed > standstill_speed\"";
    assert!(text.contains(old), "{text}");
    let new = text.replace(old, &format!("trace = \"{moving}\""));
    std::fs::write(&vocabulary, new).expect("written");
    let scene = folder.path().join("simulation/scene.toml");
    let text = std::fs::read_to_string(&scene).expect("a scene");
    std::fs::write(
        &scene,
        text.replace("duration_secs = 40", "duration_secs = 3"),
    )
    .expect("written");
    folder
}

#[test]
fn a_study_s_signals_are_listed_with_units_frames_and_meanings() {
    let Some(library) = library() else { return };
    let folder = corridor("/truth/carrier.speed > standstill_speed");
    let listed = driven(&library, folder.path(), &["inspect", "."]);
    assert_eq!(listed.code, 0, "{listed:?}");
    let has = |words: &[&str]| {
        let mut lines = listed.out.lines();
        assert!(
            lines.any(|line| words.iter().all(|word| line.contains(word))),
            "no line with {words:?} in {}",
            listed.out
        );
    };
    has(&["S1, S2"]);
    has(&["/truth/carrier.person_distance", "m"]);
    has(&["/truth/anna/left_forearm", "part of a person"]);
    has(&["left_wheel_joint"]);
    has(&["body_velocity.x", "m/s", "body"]);
    has(&[
        "contact.OTHER.caused_by_self",
        "bool",
        "moved into the other",
    ]);
    has(&["OTHER:", "anna.left_forearm", "people"]);
}

#[test]
fn what_a_proposition_names_is_recorded() {
    let Some(library) = library() else { return };
    let folder = corridor(
        "/truth/carrier.contact.people.caused_by_self | /truth/carrier.horizontal_speed > standstill_speed",
    );
    let run = driven(
        &library,
        folder.path(),
        &["simulate", ".", "S1", "-n", "1", "--out", "out"],
    );
    // The journey is cut short, so that its arrival is undecided.
    assert_eq!(run.code, 3, "{run:?}");
    let recording = folder.path().join("out/episode-00001.mcap");
    let trace = recording::read_mcap(&recording).expect("a recording").trace;
    assert!(trace.signal("/truth/carrier.horizontal_speed").is_some());
    assert!(
        trace
            .signal("/truth/carrier.contact.people.caused_by_self")
            .is_some()
    );
    assert!(trace.signal("/truth/carrier.kinetic_energy").is_none());
}

#[test]
fn a_misspelt_quantity_is_told_at_its_place_with_the_nearest_names() {
    let Some(library) = library() else { return };
    let folder = corridor("/truth/carrier.horizontal_sped > standstill_speed");
    let refused = driven(
        &library,
        folder.path(),
        &["simulate", ".", "S1", "-n", "1", "--out", "out"],
    );
    assert_ne!(refused.code, 0, "{refused:?}");
    for words in [
        "unknown-signal",
        "vocabulary.toml",
        "/truth/carrier.horizontal_speed",
        "inspect STUDY",
    ] {
        assert!(refused.talk.contains(words), "{words}: {refused:?}");
    }
}
