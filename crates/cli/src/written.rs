//! Results in the formats of continuous integration: JUnit XML, Markdown, and SARIF with places in the study's files.

use crate::args::Written;
use diagnostic::{Place, Problem, Problems, line_and_column};
use evidence::{StudyResult, Subject, Verdict};
use host::Trust;
use host::files::write_whole_or_through;
use judging::forms::drift::Drift;
use report::sarif::{Alert, Gravity, Spot, sarif};
use std::path::Path;
use study::Study;

/// Writes what was asked for: of the result, or of the mistakes for which there is none.
pub fn keep(
    written: &Written,
    study: &Path,
    result: Result<&StudyResult, &Problem>,
) -> Result<(), Problem> {
    if let (Some(file), Ok(result)) = (&written.junit, result) {
        let suites = report::junit::of_study(result);
        write_whole_or_through(file, report::junit::xml(&suites).as_bytes())?;
    }
    if let (Some(file), Ok(result)) = (&written.markdown, result) {
        write_whole_or_through(file, report::markdown(result).as_bytes())?;
    }
    let alerts = match result {
        Ok(result) => of_study(study, result),
        Err(problem) => of_problem(problem),
    };
    keep_sarif(written.sarif.as_deref(), &alerts)
}

/// Writes findings, if that was asked for.
pub fn keep_sarif(file: Option<&Path>, alerts: &[Alert]) -> Result<(), Problem> {
    match file {
        Some(file) => {
            let text = sarif(env!("CARGO_PKG_VERSION"), alerts);
            write_whole_or_through(file, text.as_bytes())
        }
        None => Ok(()),
    }
}

/// A problem and all others of the same input.
pub fn of_problem(problem: &Problem) -> Vec<Alert> {
    if problem.is_interruption() {
        return Vec::new();
    }
    let all = std::iter::once(problem).chain(problem.others());
    let alerts = all.map(|one| Alert {
        rule: one.code.to_owned(),
        gravity: Gravity::Error,
        message: match one.what_to_do() {
            Some(remedy) => format!("{}\n{remedy}", one.message()),
            None => one.message().to_owned(),
        },
        spot: one.place().map(spot),
    });
    alerts.collect()
}

fn spot(place: &Place) -> Spot {
    Spot {
        file: place.name.clone(),
        line: place.line,
        column: Some(place.column),
    }
}

/// What is violated, and of which evidence conflicts (as the exit code has it), at the requirement in the study's file.
pub fn of_study(folder: &Path, result: &StudyResult) -> Vec<Alert> {
    // Where requirements stand is all that is asked of it, whatever else is wrong.
    let study = Study::read_for(folder, &Trust::default(), &mut Problems::new()).ok();
    let spot = |subject: &Subject| study.as_ref().and_then(|study| requirement(study, subject));
    let found = result.conclusions.iter().filter_map(|conclusion| {
        let (rule, gravity) = match conclusion.verdict {
            Verdict::Violated => ("violated", Gravity::Error),
            Verdict::Conflicting => ("conflicting", Gravity::Error),
            Verdict::Undecided => ("undecided", Gravity::Note),
            Verdict::Satisfied | Verdict::NotCovered => return None,
        };
        let id = &conclusion.requirement;
        Some(Alert {
            rule: rule.to_owned(),
            gravity,
            message: format!("{id}: {}", conclusion.statement),
            spot: spot(&Subject::Requirement(id.clone())),
        })
    });
    let conflicts = result.open_conflicts().into_iter().map(|open| Alert {
        rule: "conflicting".to_owned(),
        gravity: Gravity::Error,
        message: format!("{}: {}", open.subject.in_words(), open.conflict_in_words()),
        spot: spot(&open.subject),
    });
    found.chain(conflicts).collect()
}

/// Where a requirement stands.
fn requirement(study: &Study, subject: &Subject) -> Option<Spot> {
    let form = study.forms.of(subject)?;
    let source = &study.forms.source;
    let (line, column) = line_and_column(&source.text, form.span.start);
    Some(Spot {
        file: source.name.clone(),
        line,
        column: Some(column),
    })
}

/// Forms of requirements that drifted apart, where they stand.
pub fn of_drift(drift: &[Drift]) -> Vec<Alert> {
    let alerts = drift.iter().map(|it| {
        let (file, line) = it.place.rsplit_once(':').unwrap_or((&it.place, ""));
        Alert {
            rule: "drift".to_owned(),
            gravity: Gravity::Warning,
            message: format!(
                "{}, {}: {}, where the requirement has {}\n{}",
                it.requirement, it.form, it.found, it.declared, it.remedy
            ),
            spot: line.parse().ok().map(|line| Spot {
                file: file.to_owned(),
                line,
                column: None,
            }),
        }
    });
    alerts.collect()
}
