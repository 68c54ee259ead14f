//! A study as people name it: its folder, its `study.toml`, or nothing at all from within it.

use clap::builder::{OsStringValueParser, TypedValueParser};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// What makes a folder a study.
const ABOUT: &str = "study.toml";

/// How many folders up a study is looked for.
const MOST_UP: usize = 64;

/// Reads the folder of a study.
pub fn study_folder() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().map(folder)
}

/// The folder that is meant. Where the current folder has no `study.toml`, the nearest folder around it that has: whoever stands in a
/// study's folder of models means the study.
fn folder(named: OsString) -> PathBuf {
    let named = PathBuf::from(named);
    if named.file_name().is_some_and(|name| name == ABOUT) && named.is_file() {
        return match named.parent() {
            Some(parent) if parent != Path::new("") => parent.to_owned(),
            _ => PathBuf::from("."),
        };
    }
    if named != Path::new(".") {
        return named;
    }
    let mut around = PathBuf::from(".");
    for up in 1..=MOST_UP {
        if around.join(ABOUT).is_file() {
            return around;
        }
        around = PathBuf::from_iter(std::iter::repeat_n("..", up));
        if !around.is_dir() {
            break;
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_is_named_by_its_folder_or_by_its_file() {
        let place = tempfile::tempdir().expect("a folder");
        let about = place.path().join(ABOUT);
        std::fs::write(&about, "").expect("a file");
        let read = |path: &Path| folder(path.as_os_str().to_owned());
        assert_eq!(read(place.path()), place.path());
        assert_eq!(read(&about), place.path());
        // What does not exist is said as it was named.
        let missing = place.path().join("other").join(ABOUT);
        assert_eq!(read(&missing), missing);
    }
}
