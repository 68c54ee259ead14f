//! A study whose texts steer terminals, and a folder of recordings with a pipe in it: nothing of the first reaches what is printed or
//! the page, and nothing waits for the second.

use crate::support;

use std::path::Path;
use support::program::corroborate;
use tempfile::TempDir;

/// Renames the window, rings, hides what follows, goes back to the line's beginning, turns the reading direction around.
const STEERING: &str = r"T\u001b]0;own\u0007\u001b[8m\rx\u009b2J\u202ex\u2066";

fn written(folder: &Path, name: &str, change: impl Fn(&str) -> String) {
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).expect("a file of the study");
    let changed = change(&text);
    assert_ne!(text, changed, "{name}");
    std::fs::write(path, changed).expect("written");
}

/// The template, with what steers in each text that a person writes.
fn study() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let made = corroborate(folder.path(), &["init", "s", "--template", "recordings"]);
    assert_eq!(made.code, 0, "{}", made.talk);
    let at = folder.path().join("s");
    let with = |key: &'static str| {
        move |text: &str| -> String {
            let lines = text
                .lines()
                .map(|line| match line.strip_prefix(&format!("{key} = \"")) {
                    Some(rest) => format!("{key} = \"{STEERING}{rest}\n"),
                    None => format!("{line}\n"),
                });
            lines.collect()
        }
    };
    written(&at, "study.toml", with("title"));
    written(&at, "ledger.toml", with("title"));
    written(&at, "ledger.toml", with("changed"));
    written(&at, "requirements.toml", with("text"));
    folder
}

/// The first character that steers.
fn steering(text: &str) -> Option<char> {
    let harmful = |c: &char| {
        c.is_control() && !"\n\t".contains(*c)
            || ('\u{202a}'..='\u{202e}').contains(c)
            || ('\u{2066}'..='\u{2069}').contains(c)
    };
    text.chars().find(harmful)
}

#[test]
fn no_text_of_a_study_steers_what_shows_it() {
    let folder = study();
    for arguments in [
        &["run", "s"][..],
        &["run", "s", "--format", "json"],
        &["plan", "s"],
        &["compare", "s"],
        &["compare", "s", "--format", "json"],
        &["diagnose", "s"],
        &["refine", "s"],
        &["requirements", "s"],
        &["requirements", "s", "--format", "json"],
        &["inspect", "s"],
        &["verify", "s"],
    ] {
        let said = corroborate(folder.path(), arguments);
        assert!(said.code != 101, "{arguments:?}: {}", said.talk);
        assert_eq!(steering(&said.out), None, "{arguments:?}: {:?}", said.out);
        assert_eq!(steering(&said.talk), None, "{arguments:?}: {:?}", said.talk);
    }
    let page = folder.path().join("s/results/report.html");
    let page = std::fs::read_to_string(page).expect("the page");
    assert!(page.contains("own"), "the title is on the page");
    assert_eq!(steering(&page), None);
}

/// Opening a pipe waits for who writes into it, through every signal.
#[cfg(unix)]
#[test]
fn a_pipe_among_recordings_is_left_out_and_said() {
    let folder = TempDir::new().expect("a folder");
    let made = corroborate(folder.path(), &["init", "s", "--template", "recordings"]);
    assert_eq!(made.code, 0, "{}", made.talk);
    let pipe = folder.path().join("s/recordings/pipe.mcap");
    let status = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(status.expect("mkfifo").success());
    let said = corroborate(folder.path(), &["run", "s"]);
    assert!(said.talk.contains("pipe.mcap"), "{}", said.talk);
    assert!(said.talk.contains("not a file"), "{}", said.talk);
    let named = corroborate(folder.path(), &["inspect", "s/recordings/pipe.mcap"]);
    assert_eq!(named.code, 2, "{}", named.talk);
}
