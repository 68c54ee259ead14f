//! A diagnosis for people.

use crate::corroboration::ANY_STUDY;
use evidence::{Cell, Diagnosis, Inaccuracy, Suspect};
use std::fmt::Write as _;

/// The matrix with its figures, then the suspects; `study` is how the user named it.
pub fn as_text(diagnosis: &Diagnosis, study: &str) -> String {
    let mut out = String::from(
        "Matrix: A, B, C properties on model paths, episodes, recordings; D, E, F monitors on the same\n",
    );
    for cells in diagnosis.cells.chunk_by(|a, b| a.evidence == b.evidence) {
        let _ = writeln!(
            out,
            "  {}",
            cells.first().map_or("", |cell| cell.evidence.as_str())
        );
        for cell in cells {
            line(cell, &mut out);
        }
    }
    let telling = diagnosis
        .contrasts
        .iter()
        .filter(|c| c.differing.is_some_and(|n| n > 0) || c.strength >= 1.0);
    out.push_str("\nChanging one asset at a time\n");
    for contrast in telling {
        let what = match contrast.changed {
            Inaccuracy::RequirementModel => "requirement model",
            _ => "system model",
        };
        let said = match contrast.differing {
            Some(n) => format!("two verdicts on {n} runs"),
            None => format!("Bayes factor 10^{:.1}", contrast.strength),
        };
        let [one, other] = &contrast.evidence;
        let between = if one == other {
            one.clone()
        } else {
            format!("{one} and {other}")
        };
        let _ = writeln!(
            out,
            "  {}  {:<24} {between}: {what} changed, {said} (p {:.2e})",
            contrast.cells,
            contrast.subject.id(),
            contrast.p_value
        );
    }
    listed("\nIn order", &diagnosis.in_order, &mut out);
    listed("\nNot looked at", &diagnosis.not_done, &mut out);
    out.push_str("\nSuspects (score: log10 of the Bayes factor of the disagreement that goes away without it, times the suspect's share of the blame; above 2 is decisive)\n");
    if diagnosis.suspects.is_empty() {
        out.push_str("  none\n");
    }
    for suspect in &diagnosis.suspects {
        suspected(suspect, study, &mut out);
    }
    out
}

fn line(cell: &Cell, out: &mut String) {
    let id = cell.subject.id();
    let _ = match (&cell.not_judged, cell.interval) {
        (Some(why), _) => writeln!(out, "    {} {id:<24} -  {why}", cell.cell),
        (None, Some(interval)) => writeln!(
            out,
            "    {} {id:<24} {} of {} ({:.3} to {:.3})",
            cell.cell, cell.count, cell.trials, interval.low, interval.high
        ),
        (None, None) => writeln!(
            out,
            "    {} {id:<24} never came up in {} runs",
            cell.cell, cell.runs
        ),
    };
}

fn listed(title: &str, lines: &[String], out: &mut String) {
    if lines.is_empty() {
        return;
    }
    let _ = writeln!(out, "{title}");
    for line in lines {
        let _ = writeln!(out, "  {line}");
    }
}

/// A command for a study as the user named it: alone, or before a file of it.
fn in_study(command: &str, study: &str) -> String {
    let words = command.split(' ').map(|word| {
        let rest = word.strip_prefix(ANY_STUDY);
        match rest.filter(|rest| rest.is_empty() || rest.starts_with('/')) {
            Some(rest) => format!("{}{rest}", study.trim_end_matches('/')),
            None => word.to_owned(),
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

fn suspected(suspect: &Suspect, study: &str, out: &mut String) {
    let source = match suspect.inaccuracy {
        Inaccuracy::Tool => "tool",
        Inaccuracy::RequirementModel => "requirement model",
        Inaccuracy::SystemModel => "system model",
        Inaccuracy::Undetermined => "undetermined",
    };
    let asset = suspect.asset.place_in_words();
    let _ = writeln!(
        out,
        "  {}. {} ({source}, score {:.1}): {}",
        suspect.rank, asset, suspect.score, suspect.title
    );
    let _ = writeln!(out, "     {}", suspect.explanation);
    if let Some(others) = suspect.asset.together_in_words() {
        let _ = writeln!(out, "     {others}");
    }
    for witness in &suspect.witnesses {
        let replay = in_study(&witness.replay, study);
        let _ = writeln!(out, "     witness: {replay}  ({})", witness.shows);
    }
    for reason in &suspect.ruled_out {
        let _ = writeln!(out, "     ruled out: {reason}");
    }
    if let Some((before, id, behind)) = suspect.resolution() {
        let _ = writeln!(out, "     {before}{id}{behind}");
    }
}

#[cfg(test)]
mod tests {
    use super::in_study;

    #[test]
    fn a_command_names_the_study_wherever_it_stands() {
        let command = "corroborate monitor STUDY STUDY/recordings/run1.csv";
        assert_eq!(
            in_study(command, "my/one"),
            "corroborate monitor my/one my/one/recordings/run1.csv"
        );
        assert_eq!(
            in_study("corroborate replay STUDY S1:3", "STUDY2"),
            "corroborate replay STUDY2 S1:3"
        );
    }
}
