//! `corroborate init`: a new study from a template that runs as it is.

use super::{Done, json, schema};
use crate::args::Init;
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use host::files::write_whole;

/// The template's files. It needs no simulation, so that it runs in a moment.
const FILES: [(&str, &str); 10] = [
    ("study.toml", include_str!("../template/study.toml")),
    (
        "requirements.toml",
        include_str!("../template/requirements.toml"),
    ),
    (
        "vocabulary.toml",
        include_str!("../template/vocabulary.toml"),
    ),
    (
        "parameters.toml",
        include_str!("../template/parameters.toml"),
    ),
    ("ledger.toml", include_str!("../template/ledger.toml")),
    ("model.prism", include_str!("../template/model.prism")),
    ("attempts.csv", include_str!("../template/attempts.csv")),
    (
        "requirements.csv",
        include_str!("../template/requirements.csv"),
    ),
    (
        "failure_modes.csv",
        include_str!("../template/failure_modes.csv"),
    ),
    (".gitignore", "results/\n"),
];

/// Makes the folder and its files; refuses to touch a folder with content.
pub fn init(arguments: &Init) -> Result<Done, Problem> {
    let folder = &arguments.folder;
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
    // The first line of each file names its schema; editors that know TOML complete and check by it.
    for file in schema::files() {
        let path = folder.join(".schemas").join(schema::schema_name(file.name));
        write_whole(&path, json(&file.schema)?.as_bytes())?;
    }
    let shown = folder.display();
    Ok(Done {
        output: format!(
            "A study is in {shown}:\n\
             \x20 study.toml         what it is about\n\
             \x20 requirements.toml  what is required\n\
             \x20 vocabulary.toml    what its words mean to each technique\n\
             \x20 ledger.toml        which evidence is to be produced\n\
             \x20 .schemas           the keys of each file, for editors (`corroborate schema FILE` shows them)\n\
             Next: corroborate run {shown}\n"
        ),
        outcome: Outcome::Holds,
    })
}
