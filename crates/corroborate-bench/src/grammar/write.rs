//! Generated studies written as folders, and beside them what was planted in each.

use super::catalogue::{Catalogue, Generated};
use std::fmt::Write as _;
use std::path::Path;

/// The file of answers beside the studies.
pub const ANSWERS: &str = "answers.csv";

/// Writes a study's folder.
///
/// # Errors
/// What the operating system refused.
pub fn write(study: &Generated, folder: &Path) -> Result<(), String> {
    for (name, text) in study.files() {
        let path = folder.join(&name);
        let parent = path.parent().unwrap_or(folder);
        trace::create_folder(parent).map_err(|error| error.to_string())?;
        trace::write_file(&path, text.as_bytes()).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// Writes all studies of a catalogue with their answers; how many there are.
///
/// # Errors
/// What the operating system refused.
pub fn write_all(catalogue: &Catalogue, folder: &Path) -> Result<usize, String> {
    let studies = catalogue.studies();
    let mut answers = String::from("study,fault,power,suspect first,subjects,fixed in,what\n");
    for study in &studies {
        write(study, &folder.join(&study.name))?;
        let planted = &study.planted;
        let culprits: Vec<String> = planted
            .culprits
            .iter()
            .map(|it| format!("{} {}", it.kind, it.names))
            .collect();
        let _ = writeln!(
            answers,
            "{},{},{:.3},{},{},{},{}",
            study.name,
            planted.plant.name(),
            planted.power,
            culprits.join(" or ").trim(),
            planted.subjects.join(" "),
            planted.mended_in.join(" "),
            planted.words
        );
    }
    trace::write_file(&folder.join(ANSWERS), answers.as_bytes())
        .map_err(|error| error.to_string())?;
    Ok(studies.len())
}
