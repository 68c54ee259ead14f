//! Diagnosis by changing one asset at a time: both kinds of requirement model on all kinds of traces,
//! both ways of answering for a model, half the time step, another engine.
//!
//! |  | paths of a formal model | episodes of a simulator | recordings |
//! |---|---|---|---|
//! | logical property | A | B | C |
//! | assertion monitor | D | E | F |
//!
//! [`paths`] has A and D, [`runs`] B, E, C and F from what `run` has judged already; [`events`] looks for
//! behaviour that a model does not know, [`repeated`] runs episodes again. `evidence` ranks.

mod cells;
mod events;
mod formal;
mod paths;
mod repeated;
mod runs;
mod text;

pub use formal::path_seeds;
pub use paths::ModelPaths;
pub use text::as_text;

use crate::command::Setting;
use crate::forms::drift;
use crate::problem::Problem;
use crate::store::Inputs;
use crate::study::{Study, Work};
use evidence::{
    Clue, Diagnosis, Inaccuracy, Matter, SameTraces, StudyResult, Subject, Symptom, contrasts,
    requirement_form,
};
use std::path::Path;

/// How much is looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Paths that are sampled from each formal model.
    pub paths: u64,
    /// Episodes that are run again with half the time step, if any.
    pub half_step: Option<u64>,
    /// Episodes that are run in the other engine, too, if any.
    pub engines: Option<u64>,
}

/// What is gathered before it is ranked.
#[derive(Debug, Default)]
struct Gathered {
    cells: Vec<evidence::Cell>,
    same: Vec<SameTraces>,
    clues: Vec<Clue>,
    in_order: Vec<String>,
    not_done: Vec<String>,
}

/// What a diagnosis is made of.
struct Diagnosing<'a> {
    study: &'a Study,
    /// How a command names the study.
    named: String,
    result: &'a StudyResult,
    /// The folder of its results.
    folder: &'a Path,
    effort: &'a Effort,
    setting: &'a Setting,
}

/// Diagnoses a study that has been run.
pub fn diagnose(
    study: &Study,
    result: &StudyResult,
    folder: &Path,
    effort: &Effort,
    setting: &Setting,
) -> Result<Diagnosis, Problem> {
    let diagnosing = Diagnosing {
        study,
        named: study.folder.display().to_string(),
        result,
        folder,
        effort,
        setting,
    };
    let mut gathered = Gathered::default();
    diagnosing.formal(&mut gathered)?;
    diagnosing.runs(&mut gathered)?;
    diagnosing.events(&mut gathered)?;
    diagnosing.repeated(&mut gathered)?;
    gathered.clues.extend(drifts(study));
    let matter = Matter {
        requirements: &result.requirements,
        failure_modes: &result.failure_modes,
        evidence: &result.evidence,
        comparisons: &result.comparisons,
        cells: &gathered.cells,
        study: &diagnosing.named,
    };
    let contrasts = contrasts(&gathered.cells, &gathered.same, |subject| {
        matter.margin(subject)
    });
    let suspects = evidence::rank(&matter, gathered.clues);
    Ok(Diagnosis {
        inputs: inputs_of(result),
        contrasts,
        suspects,
        cells: gathered.cells,
        in_order: gathered.in_order,
        not_done: gathered.not_done,
    })
}

/// The hash of the evidence that a diagnosis is of.
pub fn inputs_of(result: &StudyResult) -> String {
    let mut inputs = Inputs::default();
    for piece in &result.evidence {
        inputs.add(&piece.id, piece.inputs.as_bytes());
    }
    inputs.hash()
}

impl Diagnosing<'_> {
    /// The entries that speak for themselves and whose work `wanted` takes.
    fn entries(&self, wanted: impl Fn(&Work) -> bool) -> Vec<&crate::study::Entry> {
        let entries = self.study.ledger.iter();
        let kept = entries.filter(|entry| !entry.intermediate && wanted(&entry.work));
        kept.collect()
    }
}

/// Limits that are not the declared ones. They are certain, but explain no conflict by themselves.
fn drifts(study: &Study) -> Vec<Clue> {
    let found = drift::of_study(study).drift.into_iter();
    found
        .map(|drift| {
            let subject = Subject::Requirement(drift.requirement.clone());
            let words = drift.kind.words();
            Clue {
                inaccuracy: Inaccuracy::RequirementModel,
                asset: requirement_form(&subject, &drift.form, &[]),
                score: 0.0,
                title: format!(
                    "the {} of requirement {} has {words}",
                    drift.form, drift.requirement
                ),
                explanation: format!(
                    "It has {}, where {} is declared.",
                    drift.found, drift.declared
                ),
                symptom: Symptom::Drifted {
                    subject: subject.clone(),
                    form: drift.form,
                    required: drift.declared,
                    found: drift.found,
                },
                subject,
                figures: Vec::new(),
                witnesses: Vec::new(),
                ruled_out: Vec::new(),
                resolved_by: None,
            }
        })
        .collect()
}
