//! What several tests of the whole project need.
#![allow(dead_code, reason = "each test uses its part")]

pub mod planted;
pub mod program;
pub mod schema;
pub mod simulation;
pub mod source;

use cargo_metadata::{Metadata, MetadataCommand};
use std::path::{Path, PathBuf};

/// The project's root folder.
pub fn root() -> PathBuf {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest
        .ancestors()
        .nth(2)
        .expect("the crate lies in ROOT/crates/cli")
        .to_owned()
}

/// What cargo knows of the workspace and of the packages that are built here.
pub fn metadata() -> Metadata {
    let host = host();
    MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        // The tests were just built from these very packages, so nothing has to be fetched.
        .other_options(["--locked", "--offline", "--filter-platform", &host].map(String::from))
        .exec()
        .expect("cargo metadata describes the workspace")
}

/// The platform for which this project is built here, as rustc names it.
fn host() -> String {
    let said = std::process::Command::new("rustc").arg("-vV").output();
    let said = String::from_utf8(said.expect("rustc runs").stdout).expect("rustc prints text");
    let line = said.lines().find_map(|line| line.strip_prefix("host: "));
    line.expect("rustc -vV names the host").to_owned()
}

/// All files below `folder`, sorted, without what the project does not keep (builds, tools, results).
pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    const NOT_KEPT: [&str; 7] = [
        "target",
        "node_modules",
        ".git",
        ".tools",
        ".corroborate",
        "results",
        "corpus",
    ];
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{} can be listed: {error}", folder.display()));
        for entry in entries {
            let path = entry.expect("an entry can be read").path();
            let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
            if NOT_KEPT.contains(&name) {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Copies a study's files, without what was made of them.
pub fn copy_study(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("made");
    for entry in std::fs::read_dir(from).expect("a folder").flatten() {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        let is_made = ["results", "regressions"]
            .iter()
            .any(|made| entry.file_name() == *made);
        match from.is_dir() {
            true if is_made => {}
            true => copy_study(&from, &to),
            false => drop(std::fs::copy(from, to).expect("copied")),
        }
    }
}

/// A copy of the study of `conformance/command`, in whose files texts are replaced: the file, the old text, the new one.
pub fn command_study(changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("conformance/command"), folder.path());
    for (file, old, new) in changes {
        let path = folder.path().join(file);
        let text = read(&path);
        assert!(text.contains(old), "{file} has no `{old}`");
        std::fs::write(&path, text.replace(old, new)).expect("written");
    }
    folder
}

/// A file's text.
pub fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A path as it is written in messages: from the root, with `/`.
pub fn shown(path: &Path) -> String {
    path.strip_prefix(root())
        .unwrap_or(path)
        .display()
        .to_string()
}
