//! The matrix of the diagnosis: requirement models on the traces of each system model, and the ranking of
//! suspects that the product makes of it.

use crate::fault::{Assets, Site};
use crate::judges::{Judged, Judges};
use crate::random::Random;
use crate::requirements::id;
use crate::study::ids;
use crate::task::{Run, Task};
use crate::texts::STEP_KEY;
use evidence::{
    Cell, CellPlace, Clue, HALF_STEP, Inaccuracy, JudgedBy, Rate, Subject, Suspect, SuspectAsset,
    SuspectKind, Symptom, Technique, Traces, VerdictCounts, WitnessOf, strength,
};
use stats::Confidence;

/// Paths that are sampled from the formal model.
const PATHS: usize = 400;

/// The cells of one source of traces.
#[must_use]
pub fn cells(
    piece: &str,
    technique: Technique,
    judged: &Judged,
    assets: &Assets,
    level: Confidence,
) -> Vec<Cell> {
    let traces = match technique.witness_of() {
        WitnessOf::Model => Traces::Model,
        WitnessOf::Simulator => Traces::Simulator,
        WitnessOf::System => Traces::Recordings,
    };
    let mut cells: Vec<Cell> = Vec::new();
    for (subject, form, count) in &judged.counts {
        let formal = assets
            .forms
            .iter()
            .any(|f| f.id == subject.id() && f.is_formal);
        let judged_by: &[JudgedBy] = match *form {
            "property" => &[JudgedBy::Property],
            "monitor" => &[JudgedBy::Monitor],
            // The forms that nobody wrote by hand are those of the sentence.
            _ if formal => &[JudgedBy::Property, JudgedBy::Monitor],
            _ => &[JudgedBy::Monitor],
        };
        for judged_by in judged_by {
            let place = CellPlace {
                traces,
                judged_by: *judged_by,
                evidence: piece,
                subject,
            };
            let [not_covered, kept, violated, undecided] = *count;
            let counts = VerdictCounts {
                kept,
                violated,
                not_covered,
                undecided,
            };
            let cell = place.filled(counts, level);
            let same = |c: &&mut Cell| c.subject == *subject && c.judged_by == *judged_by;
            match cells.iter_mut().find(same) {
                Some(of_sentence) => *of_sentence = cell,
                None => cells.push(cell),
            }
        }
    }
    // A path has steps, and no time in which a monitor could judge it; nothing moves on it.
    cells.retain(|c| {
        traces != Traces::Model
            || (c.judged_by == JudgedBy::Property || c.subject.id() != id::IN_TIME)
                && c.subject.id() != id::SLOW
    });
    cells
}

/// The cells of paths that are sampled from the formal model.
///
/// # Errors
/// What cannot be judged, in words.
pub fn of_paths(
    formal: &Task,
    assets: &Assets,
    level: Confidence,
    random: &mut Random,
) -> Result<Vec<Cell>, String> {
    let runs: Vec<Run> = (0..PATHS).map(|_| formal.run(random)).collect();
    let judged = Judges::new(formal, &assets.forms, &assets.words)?.judge(&runs, level)?;
    Ok(cells(
        ids::MODEL,
        Technique::ModelChecking,
        &judged,
        assets,
        level,
    ))
}

/// The same episodes with half the time step, as clues: where verdicts go one way, the step decides them.
#[must_use]
pub fn half_step(assets: &Assets, seed: u64, number: u64, episodes: usize) -> Vec<Clue> {
    let run = |task: &Task, episode: u64| task.run(&mut Random::new(seed ^ number, 1 + episode));
    let (whole, half) = (assets.simulated(1.0), assets.simulated(0.5));
    let pairs: Vec<[Run; 2]> = (0..episodes as u64)
        .map(|episode| [run(&whole, episode), run(&half, episode)])
        .collect();
    let mut clues = Vec::new();
    let done = Subject::Requirement(id::DONE.to_owned());
    clues.extend(clue(assets, done, &pairs, &|run| !run.is_done()));
    for (place, mode) in assets.modes.iter().enumerate() {
        let mode = Subject::FailureMode(mode.clone());
        clues.extend(clue(assets, mode, &pairs, &|run| run.failed_at(place)));
    }
    clues
}

fn clue(
    assets: &Assets,
    subject: Subject,
    pairs: &[[Run; 2]],
    violated: &dyn Fn(&Run) -> bool,
) -> Option<Clue> {
    let count = |wanted: &dyn Fn(bool, bool) -> bool| {
        let all = pairs
            .iter()
            .filter(|[one, other]| wanted(violated(one), violated(other)));
        all.count() as u64
    };
    let (mended, broken) = (count(&|a, b| a && !b), count(&|a, b| !a && b));
    // Of the pairs with two verdicts, half would go either way if the step did not matter.
    let score = strength(
        Rate::Computed(0.5),
        Rate::counted(broken, mended + broken),
        1e-6,
    );
    (score > 0.0 && mended + broken > 0).then(|| Clue {
        inaccuracy: Inaccuracy::Tool,
        asset: SuspectAsset {
            kind: SuspectKind::TimeStep,
            file: None,
            part: Some(format!(
                "{STEP_KEY} = {}",
                assets.step.map_or(1.0, |it| it.step)
            )),
            evidence: vec![ids::SIMULATION.to_owned()],
            together: Vec::new(),
            line: None,
        },
        score,
        title: format!(
            "{} comes out otherwise with half the time step",
            ids::SIMULATION
        ),
        explanation: String::new(),
        symptom: Symptom::RunsOtherwise {
            subject: subject.clone(),
            changed: HALF_STEP.into(),
            violated: [count(&|a, _| a), count(&|_, b| b)],
            episodes: pairs.len() as u64,
            differing: mended + broken,
        },
        subject,
        figures: Vec::new(),
        witnesses: Vec::new(),
        ruled_out: Vec::new(),
        resolved_by: None,
    })
}

/// Where a suspect is.
#[must_use]
pub fn site(suspect: &Suspect) -> Site {
    match suspect.asset.kind {
        SuspectKind::FormalModel | SuspectKind::TimeScale => Site::FormalModel,
        SuspectKind::Simulation => Site::Simulation,
        SuspectKind::Data => Site::Data,
        SuspectKind::Property => Site::Property,
        SuspectKind::Monitor | SuspectKind::Vocabulary => Site::Monitor,
        SuspectKind::Solver => Site::Solver,
        SuspectKind::Engine | SuspectKind::TimeStep => Site::TimeStep,
    }
}
