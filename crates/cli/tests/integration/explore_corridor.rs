//! Exploring the corridor, whose robot is driven by a program in Python: its blind spot, and which of its lines ran.
//!
//! Needs the physics library and `python3`. Without the library the test is skipped with a line that says so, except in
//! continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use support::program::{command, contents};
use support::simulation::library;

/// The finding whose words are these.
fn finding<'r>(report: &'r Value, words: &str) -> Option<&'r Value> {
    let mut findings = report["findings"].as_array().expect("findings").iter();
    findings.find(|finding| finding["in_words"] == words)
}

/// The corridor's study in a folder of its own.
fn corridor() -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let from = support::root().join("case-studies/corridor");
    for (path, bytes) in contents(&from) {
        let name = path.strip_prefix(&from).expect("inside");
        if !name.starts_with("results") {
            let to = folder.path().join(name);
            std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
            std::fs::write(to, bytes).expect("written");
        }
    }
    folder
}

#[test]
fn the_corridors_blind_spot_is_found_and_lines_of_its_program_are_counted() {
    let Some(library) = library() else { return };
    let folder = corridor();
    let arguments = [
        "explore",
        ".",
        "exploration.toml",
        "-n",
        "4",
        "--source",
        "own",
        "--format",
        "json",
        "--out",
        "out",
    ];
    let explored = || {
        let output = command(folder.path(), &arguments)
            .env("CORROBORATE_MUJOCO", &library)
            .env("CORROBORATE_CLIENTS", support::root().join("clients"))
            .env("CORROBORATE_COVERAGE", folder.path().join("lines"))
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")
    };
    let first = explored();
    let violated = finding(&first, "requirement speed is violated").expect("found");
    assert_eq!(violated["replayed"], true);
    assert!(finding(&first, "unknown behaviour: {} to {near_person}").is_some());
    let code = &first["coverage"]["code"];
    let (ran, all) = (code["lines"][0].as_u64(), code["lines"][1].as_u64());
    assert!(ran > Some(20) && ran < all, "{code}");
    assert!(
        code["never_run"].to_string().contains("corridor.py: "),
        "{code}"
    );
    // What is taken from the journal says the same.
    assert_eq!(explored(), first);
}
