//! What tests need that simulate the handover: its folder, the physics library and a program that knows it.

use super::program::{Said, command, said};
use super::{read, root};
use std::path::{Path, PathBuf};

/// The case study's folder.
pub fn handover() -> PathBuf {
    root().join("case-studies/handover")
}

/// The ledger's entries with these identifiers, in its order, without what they
/// say of entries that are left out.
pub fn keep_only(folder: &Path, wanted: &[&str]) {
    let path = folder.join("ledger.toml");
    let text = read(&path);
    let mut parts = text.split("[[evidence]]");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        if wanted
            .iter()
            .any(|id| part.contains(&format!("id = \"{id}\"")))
        {
            let lines = part
                .lines()
                .filter(|line| !line.starts_with("reproduced_by"))
                .filter(|line| !line.starts_with("published."));
            kept.push_str("[[evidence]]");
            kept.push_str(&lines.collect::<Vec<_>>().join("\n"));
            kept.push('\n');
        }
    }
    std::fs::write(path, kept).expect("written");
}

/// The physics library. `None` if it is missing, which is said; in continuous integration nothing may be missing.
pub fn library() -> Option<PathBuf> {
    let folders = std::fs::read_dir(root().join(".tools")).ok()?.flatten();
    let mut found: Vec<PathBuf> = folders
        .filter_map(|folder| std::fs::read_dir(folder.path()).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.to_string_lossy().contains("libmujoco.so"))
        .collect();
    found.sort();
    let found = found.pop();
    if found.is_none() {
        assert!(
            std::env::var_os("CI").is_none(),
            "the physics library is missing (run tools/mujoco)"
        );
        eprintln!("skipped: the physics library is missing (run tools/mujoco)");
    }
    found
}

/// What the program says that is started in `folder` and simulates with `library`.
pub fn simulating(library: &Path, folder: &Path, arguments: &[&str]) -> Said {
    said(command(folder, arguments).env("CORROBORATE_MUJOCO", library))
}

/// The same, where a robot's program in Python imports the client.
pub fn driven(library: &Path, folder: &Path, arguments: &[&str]) -> Said {
    said(
        command(folder, arguments)
            .env("CORROBORATE_MUJOCO", library)
            .env("CORROBORATE_CLIENTS", root().join("clients")),
    )
}
