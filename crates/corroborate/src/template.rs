//! A new study from a template that runs as it is.

use diagnostic::Problem;
use host::files::write_whole;
use std::path::Path;

/// The template's files. It needs no simulation, so that it runs in a moment.
const FILES: [(&str, &str); 10] = [
    ("study.toml", include_str!("template/study.toml")),
    (
        "requirements.toml",
        include_str!("template/requirements.toml"),
    ),
    ("vocabulary.toml", include_str!("template/vocabulary.toml")),
    ("parameters.toml", include_str!("template/parameters.toml")),
    ("ledger.toml", include_str!("template/ledger.toml")),
    ("model.prism", include_str!("template/model.prism")),
    ("attempts.csv", include_str!("template/attempts.csv")),
    (
        "requirements.csv",
        include_str!("template/requirements.csv"),
    ),
    (
        "failure_modes.csv",
        include_str!("template/failure_modes.csv"),
    ),
    (".gitignore", "results/\n"),
];

/// Makes a study that runs as it is, to be changed into one's own; refuses to touch a folder with content.
///
/// # Errors
/// `folder-not-empty`, `cannot-write`.
pub fn new_study(folder: &Path) -> Result<(), Problem> {
    let occupied = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if occupied || folder.is_file() {
        return Err(Problem::new(
            "folder-not-empty",
            format!("{} already has content", folder.display()),
        )
        .remedy("name a folder that does not exist yet"));
    }
    for (name, content) in FILES {
        write_whole(&folder.join(name), content.as_bytes())?;
    }
    Ok(())
}
