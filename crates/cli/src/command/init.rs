//! `corroborate init`: a new study, from a template or drafted from a robot's description, a recording or a behaviour tree.

use super::{Done, Host, json};
use crate::args::Init;
use corroborate::Outcome;
use corroborate::init::{InitReport, InitRequest, InitSource, NewFile, Template};
use diagnostic::Problem;
use std::fmt::Write as _;
use std::path::Path;

/// Makes the folder and its files, with the schemas of all files that a study may have.
pub fn init(arguments: &Init, setting: &Host) -> Result<Done, Problem> {
    let folder = &arguments.folder;
    let template = arguments.template.as_deref().map(Template::named);
    let template = template.transpose()?.unwrap_or_default();
    let report = corroborate::init(&InitRequest {
        folder: folder.clone(),
        source: match &arguments.from {
            Some(file) => InitSource::File(file.clone()),
            None => InitSource::Template(template),
        },
        recordings: arguments.recordings.clone(),
        extra: schemas()?,
    })?;
    // Who has it made is who will write it: its programs may run.
    if let Err(problem) = corroborate::consent::own(folder, setting) {
        setting.events.say(&format!(
            "the study is not recorded as yours, so its programs are asked for: {problem}"
        ));
    }
    Ok(Done {
        output: text(folder, &report),
        outcome: Outcome::Holds,
    })
}

/// The first line of each file names its schema; editors that know TOML complete and check by it.
fn schemas() -> Result<Vec<NewFile>, Problem> {
    let files = corroborate::schemas::files().into_iter();
    files
        .map(|file| {
            let path = Path::new(".schemas").join(file.schema_name());
            json(&file.schema).map(|text| NewFile::text(path, text))
        })
        .collect()
}

/// What is worth a line of its own, and what it says.
const SHOWN: [(&str, &str); 7] = [
    (
        "README.md",
        "what there is, what the first run shows, what to change first",
    ),
    ("study.toml", "what it is about"),
    ("requirements.toml", "what is required"),
    ("vocabulary.toml", "what its words mean to each technique"),
    ("ledger.toml", "which evidence is to be produced"),
    ("simulation/scene.toml", "what is simulated"),
    ("counts/by_run.csv", "executions by leaf and run"),
];

fn text(folder: &Path, report: &InitReport) -> String {
    let shown = folder.display();
    let mut output = format!("A study is in {shown}: {}\n", report.is);
    let mut line = |name: &str, says: &str| {
        let _ = writeln!(output, "  {name:21}  {says}");
    };
    for (name, says) in SHOWN {
        if report.files.iter().any(|file| file == Path::new(name)) {
            line(name, says);
        }
    }
    line(
        ".schemas",
        "the keys of each file, for editors (`corroborate schema FILE` shows them)",
    );
    for note in &report.notes {
        let _ = writeln!(output, "{note}");
    }
    let _ = writeln!(output, "Next: corroborate run {shown}");
    output
}
