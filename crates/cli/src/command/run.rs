//! `corroborate run`: produce what is missing or stale, compare, conclude,
//! report.

mod shard;

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Run};
use crate::terminal::{terminal_width, use_colour};
use crate::written;
use corroborate::results::REPORT;
use corroborate::{Ended, EvidenceReport, Outcome, RunReport, RunRequest, run_with_page};
use diagnostic::Problem;
use evidence::{Evidence, StudyResult};

/// Runs a study.
pub fn run(arguments: &Run, setting: &Host) -> Result<Done, Problem> {
    if let (Some(of), Some(out)) = (arguments.shard, &arguments.out) {
        return shard::shard(arguments, of, out, setting);
    }
    use_threads(arguments.threads)?;
    let request = RunRequest {
        techniques: corroborate::Techniques::default(),
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        only: arguments.only.clone(),
    };
    match run_with_page(&request, setting, &report::html) {
        Err(problem) => {
            written::keep(&arguments.written, &arguments.study, Err(&problem))?;
            Err(problem)
        }
        Ok(RunReport::Only(pieces)) => only_some(&pieces, arguments.format),
        Ok(RunReport::Study(result)) => {
            written::keep(&arguments.written, &arguments.study, Ok(&result))?;
            whole(&result, &request, arguments.format)
        }
    }
}

fn whole(result: &StudyResult, request: &RunRequest, format: Format) -> Result<Done, Problem> {
    let output = match format {
        Format::Json => json(result)?,
        Format::Text => format!(
            "{}\nReport: {}\n",
            report::text(result, terminal_width(), use_colour()),
            request.results().join(REPORT).display()
        ),
    };
    Ok(Done {
        output,
        outcome: result.outcome(),
    })
}

fn only_some(pieces: &[EvidenceReport], format: Format) -> Result<Done, Problem> {
    let output = match format {
        Format::Json => {
            let evidence: Vec<&Evidence> = pieces.iter().map(|p| &p.evidence).collect();
            json(&evidence)?
        }
        Format::Text => pieces
            .iter()
            .map(|p| format!("{}: {}\n", p.evidence.id, p.headline))
            .collect(),
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}
