//! What `refine` prints.

use super::apply::Applied;
use super::proposal::{Effect, Proposal};
use evidence::{StudyResult, Subject};
use refinement::{Touch, Trial};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// What was offered, and what was done.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RefineReport {
    /// Suspects that nothing has fixed yet, the strongest first.
    pub open: Vec<Open>,
    /// What is offered.
    pub proposals: Vec<Proposal>,
    /// What nothing can be offered for, with the reason.
    pub refused: Vec<String>,
    /// What was accepted and made.
    pub applied: Vec<Applied>,
    /// Suspects that are still open after that; none if nothing was made.
    pub open_after: Option<Vec<Open>>,
}

/// A suspect that nothing has fixed yet.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Open {
    /// Its rank, as `diagnose` and the report show it.
    pub suspect: u32,
    /// Its headline.
    pub title: String,
    /// Disagreement that goes away without it, in decades.
    pub score: f64,
    /// What is offered against it, by the proposals' numbers.
    pub proposals: Vec<usize>,
}

impl Open {
    /// All of a result, with what is offered against each.
    pub fn all(result: &StudyResult, proposals: &[Proposal]) -> Vec<Self> {
        let open = result.suspected().iter().filter(|it| it.is_open());
        open.map(|it| {
            let own = proposals.iter().filter(|p| p.suspect == Some(it.rank));
            Self {
                suspect: it.rank,
                title: it.title.clone(),
                score: it.score,
                proposals: own.map(|p| p.number).collect(),
            }
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
        write_open(text, "Open suspects", &self.open)?;
        if self.proposals.is_empty() {
            writeln!(text, "No proposals.")?;
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
            write_open(
                text,
                "Open suspects now, before `corroborate diagnose` looks further",
                open,
            )?;
        }
        Ok(())
    }
}

fn write_open(text: &mut String, heading: &str, open: &[Open]) -> std::fmt::Result {
    writeln!(text, "{heading}: {}", open.len())?;
    for it in open {
        write!(
            text,
            "  suspect {} (score {:.1}): {}",
            it.suspect, it.score, it.title
        )?;
        match it.proposals.as_slice() {
            [] => writeln!(text)?,
            [one] => writeln!(text, " (proposal {one})")?,
            more => {
                let numbers: Vec<String> = more.iter().map(usize::to_string).collect();
                writeln!(text, " (proposals {})", numbers.join(", "))?;
            }
        }
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
    for line in trial_words(&proposal.tried) {
        writeln!(text, "  {line}")?;
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

/// What a change repairs, and what it breaks.
fn trial_words(trial: &Trial) -> Vec<String> {
    let listed = |touches: &[Touch]| {
        let words = touches.iter().map(|it| {
            format!(
                "{} on {} (Bayes factor 10^{:.1} -> 10^{:.1})",
                it.evidence,
                it.subject.in_words(),
                it.before,
                it.after
            )
        });
        words.collect::<Vec<_>>().join(", ")
    };
    let mut lines = Vec::new();
    if !trial.repairs.is_empty() {
        lines.push(format!("repairs: {}", listed(&trial.repairs)));
    }
    if !trial.breaks.is_empty() {
        lines.push(format!("WARNING, breaks: {}", listed(&trial.breaks)));
    }
    if !trial.sides.is_empty() {
        lines.push(format!(
            "comes to disagree with what the real system contradicts already: {}",
            listed(&trial.sides)
        ));
    }
    if !trial.against_majority.is_empty() {
        let subjects: Vec<String> = trial
            .against_majority
            .iter()
            .map(Subject::in_words)
            .collect();
        lines.push(format!(
            "WARNING: moves away from the majority of the independent evidence on {}.",
            subjects.join(", ")
        ));
    }
    lines
}

fn effect_words(effect: &Effect) -> String {
    let name = effect.subject.in_words();
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
