//! `corroborate assure`: a study's assurance case, its provenance, and its evidence as statements
//! that others can sign and check.

mod statement;

use super::{Done, json};
use crate::args::Assure;
use corroborate::outcome::Outcome;
use corroborate::results::{ASSURANCE, REPORT, RESULT, read_current_result, results_folder};
use diagnostic::Problem;
use evidence::StudyResult;
use host::files::write_whole;
use statement::{about_evidence, about_study};

/// Writes the assurance case.
pub fn assure(arguments: &Assure) -> Result<Done, Problem> {
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let result = read_current_result(&arguments.study, &folder)?;
    let to = arguments.to.clone();
    let to = to.unwrap_or_else(|| folder.join(ASSURANCE));
    let files = files(&result)?;
    for (name, content) in &files {
        write_whole(&to.join(name), content.as_bytes())?;
    }
    let case = report::assurance::case(&result);
    let count = |wanted: fn(&report::assurance::Node) -> bool| {
        let nodes = case.safety.nodes.iter().chain(&case.confidence.nodes);
        nodes.filter(|node| wanted(node)).count()
    };
    Ok(Done {
        output: format!(
            "{} files in {}\nThe arguments have {} elements: {} undeveloped, {} defeated.\n",
            files.len(),
            to.display(),
            count(|_| true),
            count(|node| node.undeveloped),
            count(|node| node.defeated),
        ),
        outcome: Outcome::Holds,
    })
}

/// Names and contents of all files of a study's assurance case.
pub fn files(result: &StudyResult) -> Result<Vec<(String, String)>, Problem> {
    let case = report::assurance::case(result);
    let mut files = vec![
        (RESULT.to_owned(), json(result)?),
        (REPORT.to_owned(), report::html(result)),
        (
            "argument.gsn.yaml".to_owned(),
            report::assurance::yaml(&case.safety),
        ),
        (
            "confidence.gsn.yaml".to_owned(),
            report::assurance::yaml(&case.confidence),
        ),
        (
            "provenance.json".to_owned(),
            report::assurance::provenance(result),
        ),
    ];
    let whole = about_study(result, &files);
    files.push(("study.intoto.json".to_owned(), json(&whole)?));
    for piece in &result.evidence {
        let name = format!("evidence/{}.json", piece.id);
        let content = json(piece)?;
        let statement = about_evidence(result, piece, (&name, &content));
        files.push((
            report::assurance::statement_file(&piece.id),
            json(&statement)?,
        ));
        files.push((name, content));
    }
    Ok(files)
}
