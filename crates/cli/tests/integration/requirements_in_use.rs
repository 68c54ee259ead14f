//! Imports and exports of requirements of one study at the same time, each in a process of its own.

use crate::support::program::{command, corroborate};
use std::path::Path;
use std::process::Stdio;
use tempfile::TempDir;

fn study() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let made = corroborate(folder.path(), &["init", "s"]);
    assert_eq!(made.code, 0, "{made:?}");
    folder
}

fn write_table(folder: &Path, name: &str) {
    let rows: String = (0..50)
        .map(|row| format!("{name}-{row},Text {row}.\n"))
        .collect();
    std::fs::write(
        folder.join(format!("{name}.csv")),
        format!("id,text\n{rows}"),
    )
    .expect("written");
}

/// While another process has the lock, nothing is read or changed; once it is gone, however it went, the lock is free.
#[test]
fn who_comes_second_is_refused_with_a_reason() {
    let folder = study();
    let at = folder.path();
    write_table(at, "a");
    let import = ["requirements", "import", "s", "a.csv"];
    let lock = std::fs::File::create(at.join("s/.requirements-sync.lock")).expect("made");
    lock.lock().expect("locked");
    let refused = corroborate(at, &import);
    assert_eq!(refused.code, 2, "{refused:?}");
    for said in [
        "requirements-in-use",
        "another import or export",
        "wait until it is done",
    ] {
        assert!(refused.talk.contains(said), "{refused:?}");
    }
    assert!(!at.join("s/requirements-sync.toml").exists());
    let dry = corroborate(at, &[&import[..], &["--dry-run"]].concat());
    assert_eq!(dry.code, 0, "{dry:?}");
    drop(lock);
    let done = corroborate(at, &import);
    assert_eq!(done.code, 0, "{done:?}");
}

#[test]
fn two_processes_at_the_same_time_lose_nothing() {
    let folder = study();
    let at = folder.path();
    let names = ["a", "b", "c", "d"];
    names.iter().for_each(|name| write_table(at, name));
    let mut left: Vec<&str> = names.to_vec();
    // Who is refused comes again; one of those that start together always gets through.
    for _ in 0..names.len() {
        let started: Vec<_> = left
            .iter()
            .map(|name| {
                let file = format!("{name}.csv");
                let mut import = command(at, &["requirements", "import", "s", &file]);
                import.stdout(Stdio::null()).stderr(Stdio::piped());
                import.spawn().expect("the program starts")
            })
            .collect();
        let ended = started.into_iter().zip(std::mem::take(&mut left));
        for (process, name) in ended {
            let output = process.wait_with_output().expect("it ends");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            match output.status.code() {
                Some(0) => {}
                code => {
                    assert_eq!(code, Some(2), "{said}");
                    assert!(said.contains("requirements-in-use"), "{said}");
                    left.push(name);
                }
            }
        }
    }
    assert!(left.is_empty(), "{left:?}");
    let text = std::fs::read_to_string(at.join("s/requirements.toml")).expect("a text");
    for name in names {
        let count = text.matches(&format!("id = \"{name}-")).count();
        assert_eq!(count, 50, "{name}");
    }
}
