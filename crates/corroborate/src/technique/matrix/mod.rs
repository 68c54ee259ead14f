//! Diagnosis by changing one asset at a time: both kinds of requirement model on all kinds of traces,
//! both ways of answering for a model, half the time step, another engine.
//!
//! |  | paths of a formal model | episodes of a simulator | recordings |
//! |---|---|---|---|
//! | logical property | A | B | C |
//! | assertion monitor | D | E | F |
//!
//! `paths` has A and D, `runs` B, E, C and F from what `run` has judged already; `events` looks for
//! behaviour that a model does not know, `repeated` runs episodes again, `edits` changes requirement models one
//! value at a time, `constants` names properties that say nothing, `outliers` looks for a person who differs from all others, and `words` names what runs are read through. `evidence` ranks.

mod candidates;
mod cells;
mod constants;
pub(crate) mod edits;
mod events;
mod excess;
mod formal;
mod gates;
mod lines;
mod outliers;
mod paths;
mod repeated;
mod runs;
mod text;
mod words;

pub use formal::path_seeds;
pub use paths::ModelPaths;
pub use text::as_text;

use crate::corroboration::{self, ANY_STUDY, tables_of};
use crate::technique::model_checking::Compiled;
use diagnostic::Problem;
use evidence::{
    Clue, Diagnosis, Effort, Inaccuracy, Matter, SameTraces, StudyResult, Subject, Symptom,
    contrasts, requirement_form,
};
use host::Host;
use host::store::Inputs;
use judging::forms::drift;
use std::path::Path;
use study::{Study, Work};

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
    result: &'a StudyResult,
    /// The folder of its results.
    folder: &'a Path,
    effort: &'a Effort,
    setting: &'a Host,
}

/// Diagnoses a study that has been run.
pub fn diagnose(
    study: &Study,
    result: &StudyResult,
    folder: &Path,
    effort: &Effort,
    setting: &Host,
) -> Result<Diagnosis, Problem> {
    let diagnosing = Diagnosing {
        study,
        result,
        folder,
        effort,
        setting,
    };
    let mut gathered = Gathered::default();
    diagnosing.formal(&mut gathered)?;
    diagnosing.idle_commands(&mut gathered)?;
    diagnosing.runs(&mut gathered)?;
    diagnosing.events(&mut gathered)?;
    diagnosing.repeated(&mut gathered)?;
    let offered = diagnosing.offered(&mut gathered)?;
    diagnosing.edits(&offered, &mut gathered)?;
    diagnosing.constants(&offered, &mut gathered);
    diagnosing.outliers(&mut gathered)?;
    gathered.clues.extend(drifts(study));
    diagnosing.drifted_constants(&mut gathered)?;
    let tables = tables_of(study);
    let matter = Matter {
        requirements: &result.requirements,
        failure_modes: &result.failure_modes,
        evidence: &result.evidence,
        comparisons: &result.comparisons,
        cells: &gathered.cells,
        tables: &tables,
        study: ANY_STUDY,
    };
    let contrasts = contrasts(&gathered.cells, &gathered.same, |subject| {
        matter.margin(subject)
    });
    let clues = std::mem::take(&mut gathered.clues);
    let mut suspects = evidence::rank(&matter, clues);
    diagnosing.lines(&mut suspects, &offered)?;
    diagnosing.readings(&mut suspects);
    diagnosing.words(&mut suspects);
    Ok(Diagnosis {
        inputs: inputs_of(result),
        effort: effort.clone(),
        contrasts,
        suspects,
        cells: gathered.cells,
        in_order: gathered.in_order,
        not_done: gathered.not_done,
    })
}

/// Whether some form of a requirement, its text or its sentence has a limit of time.
pub fn is_timed(study: &Study, form: &study::SubjectForm) -> bool {
    candidates::limits::is_timed(study, form)
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
    /// Says which commands of formal models are never enabled: what stands there plays no part, which shows in no conflict.
    fn idle_commands(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        for entry in self.entries(|work| work.model().is_some()) {
            let Some(model) = entry.work.model() else {
                continue;
            };
            let cancel = || self.setting.cancel.is_cancelled();
            let found = Compiled::new(self.study, model)?.idle_commands(&cancel);
            self.setting.go_on()?;
            match found {
                Ok(found) if found.idle.is_empty() => {}
                Ok(found) => {
                    let lines: Vec<String> = found.idle.iter().map(usize::to_string).collect();
                    gathered.in_order.push(format!(
                        "{}: the guards of {} of {} commands hold in no state that the model reaches: {}:{}",
                        entry.id,
                        lines.len(),
                        found.lines,
                        model.display(),
                        lines.join(", ")
                    ));
                }
                Err(problem) => gathered.not_done.push(format!(
                    "commands of {} that are never enabled: {}",
                    entry.id,
                    problem.message()
                )),
            }
        }
        Ok(())
    }

    /// Constants that do not have the value of the counts they were set to.
    fn drifted_constants(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        for entry in &self.study.ledger {
            if let Some(model) = entry.work.model() {
                let compiled = Compiled::new(self.study, model)?;
                let known = |id: &str| self.result.evidence.iter().find(|e| e.id == id);
                let found = corroboration::drift(entry, |name| compiled.constant(name), known);
                gathered.clues.extend(found);
            }
        }
        Ok(())
    }

    /// The entries that speak for themselves and whose work `wanted` takes.
    fn entries(&self, wanted: impl Fn(&Work) -> bool) -> Vec<&study::Entry> {
        let entries = self.study.ledger.iter();
        let kept = entries.filter(|entry| !entry.intermediate && wanted(&entry.work));
        kept.collect()
    }
}

/// What a limit of another size than the declared one counts: that the texts differ is certain, and no conflict hangs on it
/// by itself. As much as a form that judges runs otherwise than its sentence where no finding rests on it.
const OTHER_LIMIT: f64 = 1.0;

/// Limits that are not the declared ones. They are certain, but explain no conflict by themselves; one of another size
/// means another requirement, where the other kinds of drift may be a way of writing.
fn drifts(study: &Study) -> Vec<Clue> {
    let found = drift::of_study(study).drift.into_iter();
    found
        .map(|drift| {
            let subject = Subject::Requirement(drift.requirement.clone());
            let words = drift.kind.words();
            Clue {
                inaccuracy: Inaccuracy::RequirementModel,
                asset: requirement_form(&subject, &drift.form, &[]),
                score: match drift.kind {
                    drift::DriftKind::Limit => OTHER_LIMIT,
                    _ => 0.0,
                },
                title: format!(
                    "the {} of requirement {} has {words}",
                    drift.form, drift.requirement
                ),
                explanation: format!(
                    "It has {}, where requirement {} declares {}.",
                    drift.found, drift.requirement, drift.declared
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
