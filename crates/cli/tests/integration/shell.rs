//! What the program says of its surroundings, and what shells and `man` read of its command line.

use crate::support;

use serde_json::Value;
use std::process::Command;
use support::program::corroborate;
use support::schema::violations;
use support::{read, root};
use tempfile::TempDir;

#[test]
fn the_doctor_names_what_is_missing_and_what_that_disables() {
    let folder = TempDir::new().expect("a folder");
    // The tests' program is told that there is no physics library.
    let said = corroborate(folder.path(), &["doctor", "--format", "json"]);
    assert_eq!(said.code, 3, "{said:?}");
    let report: Value = serde_json::from_str(&said.out).expect("JSON");
    let schema = read(&root().join("schemas/doctor.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    assert_eq!(violations(&schema, &report), Vec::<String>::new());
    let examined = report["examined"].as_array().expect("a list");
    let physics = examined
        .iter()
        .find(|it| it["name"] == "MuJoCo")
        .expect("physics");
    assert_eq!(physics["presence"], "missing");
    assert!(
        physics["needed_for"]
            .as_str()
            .expect("text")
            .contains("`simulate`")
    );
    let python = examined
        .iter()
        .find(|it| it["name"] == "python3")
        .expect("python");
    let is_there = Command::new("python3")
        .arg("--version")
        .output()
        .is_ok_and(|it| it.status.success());
    assert_eq!(python["presence"] == "present", is_there, "{python}");
    let text = corroborate(folder.path(), &["doctor"]).out;
    assert!(text.contains("MISSING  MuJoCo: "), "{text}");
    assert!(text.contains("\n         disables: scenes"), "{text}");
}

#[test]
fn completions_are_scripts_that_know_every_command() {
    let folder = TempDir::new().expect("a folder");
    for shell in ["bash", "zsh", "fish"] {
        let said = corroborate(folder.path(), &["completions", shell]);
        assert_eq!(said.code, 0, "{said:?}");
        for command in ["decide", "diff", "doctor", "run"] {
            assert!(said.out.contains(command), "{shell}: {command}");
        }
        let file = folder.path().join(shell);
        std::fs::write(&file, &said.out).expect("written");
        // Where the shell is installed, it can read its script.
        if let Ok(read) = Command::new(shell).arg("-n").arg(&file).output() {
            assert!(read.status.success(), "{shell}: {read:?}");
        }
    }
    assert_eq!(corroborate(folder.path(), &["completions", "csh"]).code, 2);
}

#[test]
fn manual_pages_are_of_every_command() {
    let folder = TempDir::new().expect("a folder");
    let page = corroborate(folder.path(), &["man", "decide"]);
    assert_eq!(page.code, 0, "{page:?}");
    assert!(
        page.out.contains(".TH corroborate-decide 1"),
        "{}",
        page.out
    );
    assert!(page.out.contains("\\-\\-at\\-least"), "{}", page.out);
    let written = corroborate(folder.path(), &["man", "--out", "man1"]);
    assert_eq!(written.code, 0, "{written:?}");
    let reference = read(&root().join("docs/reference/commands.md"));
    let commands = reference
        .lines()
        .filter_map(|line| line.strip_prefix("## "));
    let mut count = 1;
    for command in commands.filter(|it| !it.contains(' ')) {
        let file = folder.path().join(format!("man1/corroborate-{command}.1"));
        assert!(file.exists(), "{command}");
        count += 1;
    }
    assert!(
        written.out.starts_with(&format!("{count} pages written")),
        "{}",
        written.out
    );
    let unknown = corroborate(folder.path(), &["man", "decid"]);
    assert!(
        unknown.code == 2 && unknown.talk.contains("did you mean `decide`?"),
        "{unknown:?}"
    );
}
