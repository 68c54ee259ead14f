//! What `refine` prints.

use super::apply::Applied;
use super::proposal::{Effect, Proposal};
use evidence::{StudyResult, Subject};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// What was offered, and what was done.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RefineReport {
    /// Disagreements that nothing has mended yet, as the suspects are numbered.
    pub open: Vec<Open>,
    /// What is offered.
    pub proposals: Vec<Proposal>,
    /// Disagreements for which nothing is offered, with the reason.
    pub refused: Vec<String>,
    /// What was accepted and made.
    pub applied: Vec<Applied>,
    /// Disagreements that are still open after that; none if nothing was made.
    pub open_after: Option<Vec<Open>>,
}

/// A disagreement that is open.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Open {
    /// Its number in the study's order, from 1.
    pub suspect: usize,
    /// Its headline.
    pub title: String,
}

impl Open {
    /// All of a result.
    pub fn all(result: &StudyResult) -> Vec<Self> {
        let numbered = result.discrepancies.iter().enumerate();
        numbered
            .filter(|(_, d)| d.resolved_by.is_none())
            .map(|(place, d)| Self {
                suspect: place + 1,
                title: d.title.clone(),
            })
            .collect()
    }
}

impl RefineReport {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        write_open(text, "Open disagreements", &self.open)?;
        if self.proposals.is_empty() {
            writeln!(text, "Nothing is offered.")?;
        }
        for proposal in &self.proposals {
            write_proposal(text, proposal)?;
        }
        if !self.refused.is_empty() {
            writeln!(text, "Without a proposal")?;
            for reason in &self.refused {
                writeln!(text, "  {reason}")?;
            }
            writeln!(text)?;
        }
        for applied in &self.applied {
            let entry = applied.entry.as_deref().unwrap_or("changed");
            writeln!(text, "{entry} ({}): {}", applied.file, applied.what)?;
        }
        if let Some(open) = &self.open_after {
            writeln!(text)?;
            write_open(text, "Open disagreements now", open)?;
        }
        Ok(())
    }
}

fn write_open(text: &mut String, heading: &str, open: &[Open]) -> std::fmt::Result {
    writeln!(text, "{heading}: {}", open.len())?;
    for it in open {
        writeln!(text, "  suspect {}: {}", it.suspect, it.title)?;
    }
    writeln!(text)
}

fn write_proposal(text: &mut String, proposal: &Proposal) -> std::fmt::Result {
    let suspect = proposal
        .suspect
        .map_or(String::new(), |n| format!(" (suspect {n})"));
    writeln!(
        text,
        "Proposal {}{suspect}: {}",
        proposal.number, proposal.title
    )?;
    writeln!(text, "  {}", proposal.reason)?;
    for effect in &proposal.effects {
        writeln!(text, "  {}", effect_words(effect))?;
    }
    for note in &proposal.notes {
        writeln!(text, "  {note}")?;
    }
    if proposal.needs_decision {
        writeln!(
            text,
            "  `--all` leaves this open: accept it with `--accept {}`.",
            proposal.number
        )?;
    }
    for line in proposal.diff.lines() {
        writeln!(text, "    {line}")?;
    }
    writeln!(text)
}

fn effect_words(effect: &Effect) -> String {
    let name = match &effect.subject {
        Subject::Requirement(id) => format!("requirement {id}"),
        Subject::FailureMode(id) => id.replace('_', " "),
    };
    let value = |value: Option<f64>| match value {
        Some(value) => format!("{value:.6}"),
        None => "not expressible".to_owned(),
    };
    let mut words = format!(
        "predicted: {name} {} -> {}",
        value(effect.before),
        value(effect.after)
    );
    if let Some(counts) = &effect.counted {
        words.push_str(&format!(", counted {}", counts.words()));
    }
    if let Some(p) = effect.p_value {
        match p < 0.001 {
            true => words.push_str(" (p < 0.001)"),
            false => words.push_str(&format!(" (p {p:.3})")),
        }
    }
    words
}
