//! Where the physics library is: as the environment says, else where `tools/mujoco` of the project put it in which this
//! program was built.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The library's place. Set to nothing, `CORROBORATE_MUJOCO` says that there is none.
pub fn find() -> Option<PathBuf> {
    match std::env::var_os("CORROBORATE_MUJOCO") {
        Some(named) => Some(named).filter(|it| !it.is_empty()).map(PathBuf::from),
        None => fetched(&std::env::current_exe().ok()?),
    }
}

/// The library that was fetched into the project of an executable. Several versions may lie there; the engine says which
/// it needs, so the last is named.
fn fetched(executable: &Path) -> Option<PathBuf> {
    let project = executable
        .ancestors()
        .find(|folder| folder.join("tools/mujoco").is_file())?;
    let versions = entries(&project.join(".tools"), "mujoco-");
    let mut libraries = versions
        .iter()
        .flat_map(|version| entries(version, "libmujoco.so."));
    libraries.next_back()
}

/// What lies in a folder under names that begin like this, in the order of names.
fn entries(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let begins = |name: OsString| name.to_string_lossy().starts_with(prefix);
    let mut found: Vec<PathBuf> = all
        .filter(|entry| begins(entry.file_name()))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(&path, "").expect("written");
        path
    }

    #[test]
    fn the_library_of_the_project_is_found_from_its_build_and_no_other() {
        let folder = tempfile::TempDir::new().expect("a temporary folder");
        let project = folder.path().join("project");
        let executable = file(&project, "target/release/corroborate");
        file(&project, ".tools/mujoco-3.16.0/libmujoco.so.3.16.0");
        let newest = file(&project, ".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
        file(&project, ".tools/mujoco-3.17.0/LICENSE");
        assert_eq!(
            fetched(&executable),
            None,
            "no project without tools/mujoco"
        );
        file(&project, "tools/mujoco");
        assert_eq!(fetched(&executable), Some(newest));
        let elsewhere = file(folder.path(), "bin/corroborate");
        assert_eq!(fetched(&elsewhere), None);
    }
}
