//! Truth that a scene records because the study reads it.
//!
//! Every proposition of the vocabulary and every requirement counts, whether this evidence judges it or not, so that files
//! which name propositions (explorations, rare events) find their signals, too.

use super::scene_problem;
use diagnostic::{Problem, Source};
use judging::Judges;
use std::collections::BTreeSet;
use study::{Binding, Study};
use testbench::Bench;
use testbench::scene::{SceneBench, UnknownTruth};

/// The bench with all truth that the study reads of it, and the names of what it would not record of itself.
///
/// # Errors
/// `unknown-signal` at the place that names it, for a quantity that a thing of the scene does not have.
pub(super) fn declared(
    bench: SceneBench,
    study: &Study,
    source: &Source,
) -> Result<(SceneBench, Vec<String>), Problem> {
    let always = bench
        .layout()
        .map_err(|error| scene_problem(source, &error))?;
    // What is of another rig, or of a recording, is none of this scene's business.
    let is_ours = |name: &String| bench.tells_of(name) && always.signal(name).is_none();
    let names: Vec<String> = read_by(study)?.into_iter().filter(is_ours).collect();
    let declared = bench.record_truth(names.iter().cloned());
    match declared.map_err(|error| scene_problem(source, &error))? {
        Ok(bench) => Ok((bench, names)),
        Err(unknown) => Err(told(study, &unknown)),
    }
}

/// All signals that the study names.
fn read_by(study: &Study) -> Result<BTreeSet<String>, Problem> {
    let vocabulary = &study.vocabulary;
    let mut names = Judges::new(study, |_| true)?.signals();
    for (_, binding) in bindings(study) {
        // A text that is wrong is told where it is bound.
        if let Ok(predicate) = vocabulary.signals.predicate(&binding.text) {
            names.extend(predicate.signals());
        }
    }
    Ok(names)
}

fn bindings(study: &Study) -> impl Iterator<Item = (&String, &Binding)> {
    let propositions = study.vocabulary.propositions.iter();
    propositions.flat_map(|(name, it)| {
        let both = it.trace.iter().chain(&it.graded);
        both.map(move |binding| (name, binding))
    })
}

/// The problem at the first place of the vocabulary that has the name.
fn told(study: &Study, unknown: &UnknownTruth) -> Problem {
    let message = format!("`{}` {}", unknown.name, unknown.reason);
    let problem = Problem::new("unknown-signal", message);
    let found = bindings(study).find_map(|(_, binding)| {
        let at = binding.text.find(&unknown.name)?;
        let start = binding.span.start + at;
        Some(start..start + unknown.name.len())
    });
    let problem = match found {
        Some(span) => problem.at(&study.vocabulary.source, span),
        None => problem,
    };
    match unknown.similar.as_slice() {
        [] => {
            problem.remedy("`corroborate inspect STUDY` lists what there is, with units and frames")
        }
        similar => problem.remedy(format!(
            "did you mean {}? `corroborate inspect STUDY` lists all there is",
            similar.join(", ")
        )),
    }
}
