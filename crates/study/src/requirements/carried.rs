//! Declarations that the agreement of a model with the system carries over to a requirement.
//!
//! ```toml
//! [[requirement]]
//! id = "2"
//! needs = "corroborated"
//!
//! [[requirement.carries_over]]
//! evidence = "E5"                # the model or simulation that speaks of requirement 2
//! on = "1a"                      # the requirement or failure mode on which it agrees with trials of the system
//! shown_by = "E4"                # the same model under other conditions, where that is what agrees; `evidence` itself if left out
//! because = "same controller and sensors; requirement 2 adds no mechanism that 1a does not exercise"
//! ```

use super::Forms;
use crate::Entry;
use diagnostic::{Problem, Problems, did_you_mean};
use evidence::{CarryOver, Requirement, Step, Subject};
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// A declaration as it is written.
#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CarryOverText {
    /// The model or simulation that speaks of this requirement.
    evidence: String,
    /// The requirement or failure mode on which it agrees with trials of the system; this requirement, if absent.
    on: Option<String>,
    /// The same model under other conditions, where that is what agrees; `evidence` itself, if absent.
    shown_by: Option<String>,
    /// Why the agreement holds for this requirement, too.
    because: String,
}

/// The declarations of a requirement. Whether what they name exists is checked when the ledger is there; until then `on`
/// is taken for a requirement.
pub(super) fn carried(texts: Vec<Spanned<CarryOverText>>, requirement: &str) -> Vec<CarryOver> {
    let read = |text: Spanned<CarryOverText>| {
        let text = text.into_inner();
        CarryOver {
            on: Subject::Requirement(text.on.unwrap_or_else(|| requirement.to_owned())),
            shown_by: text.shown_by.unwrap_or_else(|| text.evidence.clone()),
            evidence: text.evidence,
            because: text.because,
        }
    };
    texts.into_iter().map(read).collect()
}

impl Forms {
    /// Checks that what is declared to carry over exists and is a model or simulation, and gives failure modes their kind.
    pub fn complete_carried(
        &self,
        requirements: &mut [Requirement],
        ledger: &[Entry],
        found: &mut Problems,
    ) {
        for requirement in requirements {
            let form = self.by_id(&requirement.id);
            let places = form.map_or(&[][..], |form| &form.carried_at);
            for (declared, place) in requirement.carries_over.iter_mut().zip(places) {
                found.keep(self.check_carried(declared, place, ledger));
                if let Some(form) = self.by_id(declared.on.id()) {
                    declared.on = form.subject.clone();
                }
            }
        }
    }

    fn check_carried(
        &self,
        declared: &CarryOver,
        place: &Range<usize>,
        ledger: &[Entry],
    ) -> Result<(), Problem> {
        for id in [&declared.evidence, &declared.shown_by] {
            let Some(entry) = ledger.iter().find(|entry| &entry.id == id) else {
                let known = ledger.iter().map(|entry| entry.id.as_str());
                let similar = did_you_mean(id, known);
                return Err(Problem::new(
                    "unknown-evidence",
                    format!(
                        "`carries_over` names the evidence `{id}`, which the ledger does not have"
                    ),
                )
                .at(&self.source, place.clone())
                .remedy(match similar {
                    Some(similar) => format!("did you mean `{similar}`?"),
                    None => "name a model or simulation of ledger.toml".to_owned(),
                }));
            };
            if Step::of(entry.work.technique()) == Step::System {
                return Err(Problem::new(
                    "carries-over-trials",
                    format!("`carries_over` expects a model or simulation, but `{id}` is an experiment or operation"),
                )
                .at(&self.source, place.clone())
                .remedy("trials of the system decide by themselves: remove the declaration"));
            }
        }
        if declared.because.trim().is_empty() {
            return Err(Problem::new(
                "carries-over-without-reason",
                "`because` is empty: expected what the carrying over rests on",
            )
            .at(&self.source, place.clone())
            .remedy("write why the model's agreement holds for this requirement, too"));
        }
        let on = declared.on.id();
        if self.by_id(on).is_none() {
            let known = self.subjects.iter().map(|form| form.subject.id());
            return Err(Problem::new(
                "unknown-requirement",
                format!(
                    "`carries_over` names `{on}`, which is neither a requirement nor a failure mode"
                ),
            )
            .at(&self.source, place.clone())
            .remedy(match did_you_mean(on, known) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "name one of requirements.toml on which the model agrees with the system"
                    .to_owned(),
            }));
        }
        Ok(())
    }
}
