//! Which study was probably meant where a folder is none.

use diagnostic::did_you_mean;
use std::path::{Path, PathBuf};

/// Folders that are looked into, at most: a folder of recordings may have very many.
const MOST_LOOKED_AT: usize = 1000;

/// Studies that are named, at most.
const MOST_NAMED: usize = 3;

const MAKE_ONE: &str = "name a study's folder, or make one with `corroborate init FOLDER`";

/// What to do where a folder does not exist: the study beside it whose name is most like it, if one is.
pub(crate) fn remedy(folder: &Path) -> String {
    let beside = match folder.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let name = folder.file_name().map(|it| it.to_string_lossy());
    let found = studies(beside);
    let names = found.iter().filter_map(|it| it.file_name()?.to_str());
    match name.and_then(|name| did_you_mean(&name, names)) {
        Some(meant) => {
            let meant = folder.with_file_name(meant);
            format!("did you mean {}?", meant.display())
        }
        None => MAKE_ONE.to_owned(),
    }
}

/// What to do where a folder is no study: those in it, if there are some.
pub(crate) fn remedy_within(folder: &Path) -> String {
    let found = studies(folder);
    if found.is_empty() {
        return MAKE_ONE.to_owned();
    }
    let named = found.iter().take(MOST_NAMED);
    let named: Vec<String> = named.map(|it| it.display().to_string()).collect();
    let rest = match found.len() > MOST_NAMED {
        true => ", ...",
        false => "",
    };
    format!("name a study in it: {}{rest}", named.join(", "))
}

/// The folders in a folder that are studies, in the order of their names.
fn studies(folder: &Path) -> Vec<PathBuf> {
    let Ok(inside) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let inside = inside.take(MOST_LOOKED_AT).flatten();
    let mut found: Vec<PathBuf> = inside
        .map(|it| match folder == Path::new(".") {
            true => PathBuf::from(it.file_name()),
            false => it.path(),
        })
        .filter(|it| it.join("study.toml").is_file())
        .collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_study_that_is_meant_is_named() {
        let place = tempfile::tempdir().expect("a folder");
        for name in ["handover", "corridor"] {
            let folder = place.path().join(name);
            std::fs::create_dir(&folder).expect("a folder");
            std::fs::write(folder.join("study.toml"), "").expect("a file");
        }
        std::fs::create_dir(place.path().join("handovers")).expect("a folder");
        let said = remedy(&place.path().join("hand-over"));
        let meant = place.path().join("handover");
        assert_eq!(said, format!("did you mean {}?", meant.display()));
        assert_eq!(remedy(&place.path().join("elsewhere")), MAKE_ONE);
        let within = remedy_within(place.path());
        assert!(within.starts_with("name a study in it: "), "{within}");
        assert!(within.ends_with("handover"), "{within}");
        assert_eq!(remedy_within(&meant), MAKE_ONE);
    }
}
