//! `corroborate init`: a new study from a template that runs as it is.

use super::{Done, json, schema};
use crate::args::Init;
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use host::files::write_whole;

/// Makes the folder and its files, with the schemas of all files that a study may have.
pub fn init(arguments: &Init) -> Result<Done, Problem> {
    let folder = &arguments.folder;
    corroborate::new_study(folder)?;
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
