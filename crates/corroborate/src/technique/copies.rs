//! What of one piece of evidence looks taken from another though no lineage says so.
//!
//! # Definition
//! Looked at are: numbers in models and parameter sets that are rates of another piece's counts (`constants`) or products
//! of two of them (`products`), counts that are another piece's (`counts`), and rows of tables that repeat another table's
//! (`experiment::repeated` by name; `experiment::renamed` by place and by content). Each possible coincidence has a
//! probability if the sources are independent (`stats::coincidence`); one that was met is a *question* to the user if any
//! of its kind as improbable would be met in at most [`LIMIT`] of studies of independent evidence. Beside them stand trials of one
//! table that are alike where it does not say that they belong together (`trials`), equal seeds (`seeds`: in tables a question, where the ledger
//! gives them known), models that compute the same number (`answers`), and models of which most was written once (`statements`), which
//! is stated without a question.
//!
//! What is improbable for its own numbers but not for all that were looked at is *noted*: it changes no outcome.
//!
//! # Assumes
//! Independent sources find numbers, counts and rows as `stats::coincidence` has it. Each kind is held against [`LIMIT`] by
//! itself, so that several kinds together may ask oftener.
//!
//! # Guarantee
//! `cargo run --release -p corroborate-stats --example copies` measures how often studies of independent evidence are asked about, and
//! which copies are found. A ledger's `independent` settles a question, whatever its probability.

mod answers;
mod constants;
mod counts;
mod products;
mod rows;
mod seeds;
mod statements;
mod trials;

use diagnostic::Problem;
use evidence::{CopyKind, Evidence, LineageQuestion, Measure, Subject};
use stats::{Possible, Sample};
use study::Study;

/// The share of studies of independent evidence in which anything is asked, at most, for each kind that has a probability.
pub const LIMIT: f64 = 0.01;

/// The share of one coincidence's own probability up to which it is noted.
const NOTED: f64 = 0.2;

/// A coincidence that was or could have been met.
#[derive(Clone, Debug)]
struct Candidate {
    /// The place of the piece whose asset may be a copy, and of the other, in the ledger.
    pieces: [usize; 2],
    kind: CopyKind,
    subjects: Vec<Subject>,
    /// Of which coincidences it is one: those with the same key are the same.
    key: String,
    chance: f64,
    met: bool,
    /// Whether it is worth a note where it is no question.
    notable: bool,
    finding: String,
    places: Vec<String>,
    /// How the ledger would declare it.
    declare: Option<String>,
}

/// Fills in the questions of all evidence, after the rows that tables share were filled in.
pub fn find(study: &Study, evidence: &mut [Evidence]) -> Result<(), Problem> {
    let mut found = judged(&constants::candidates(study, evidence)?, evidence);
    found.extend(judged(&counts::candidates(study, evidence), evidence));
    found.extend(judged(&products::candidates(study, evidence)?, evidence));
    found.extend(judged(&rows::candidates(study, evidence)?, evidence));
    found.extend(seeds::questions(study, evidence)?);
    found.extend(seeds::fill(study, evidence));
    found.extend(trials::questions(study, evidence)?);
    statements::fill(study, evidence)?;
    found.extend(answers::questions(evidence));
    // That a total is the same is no news where its rows are asked about, or its file.
    let asked: Vec<(usize, String)> = found
        .iter()
        .filter(|(_, it)| it.kind != CopyKind::Counts)
        .map(|(piece, it)| (*piece, it.with.clone()))
        .collect();
    found.retain(|(piece, it)| {
        it.kind != CopyKind::Counts || it.blocks || !asked.contains(&(*piece, it.with.clone()))
    });
    for (piece, mut question) in found {
        let reason = |of: &str, with: &str| {
            let entry = study.ledger.iter().find(|entry| entry.id == of)?;
            entry.independent.reason(with).map(str::to_owned)
        };
        let (id, with) = (evidence[piece].id.clone(), question.with.clone());
        question.settled = match id == with {
            // Independence of all other evidence says nothing of a piece's own trials.
            true => of_own_trials(study, &id),
            false => reason(&id, &with).or_else(|| reason(&with, &id)),
        };
        let is_settled = question.kind == CopyKind::Rows && question.settled.is_some();
        let piece = &mut evidence[piece];
        if is_settled {
            piece.shared_rows.retain(|rows| rows.with != with);
        }
        piece.lineage_questions.push(question);
    }
    Ok(())
}

/// The ledger's reason why a piece's trials are independent of each other.
fn of_own_trials(study: &Study, id: &str) -> Option<String> {
    let entry = study.ledger.iter().find(|entry| entry.id == id)?;
    entry.independent.of.get(id).cloned()
}

/// The candidates that were met, as questions or notes.
fn judged(candidates: &[Candidate], evidence: &[Evidence]) -> Vec<(usize, LineageQuestion)> {
    let mut keys: Vec<&str> = Vec::new();
    let mut possible: Vec<Possible> = Vec::new();
    let mut places = std::collections::BTreeMap::new();
    for candidate in candidates {
        places.entry(candidate.key.as_str()).or_insert_with(|| {
            keys.push(&candidate.key);
            let [one, other] = candidate.pieces;
            possible.push(Possible {
                // Products of the same rates are met together: several are no more than one.
                pair: match candidate.kind {
                    CopyKind::Product => possible.len(),
                    _ => one.min(other) * evidence.len() + one.max(other),
                },
                chance: candidate.chance,
                met: candidate.met,
            });
            possible.len() - 1
        });
    }
    let corrected = stats::coincidences(&possible);
    let met = candidates.iter().filter_map(|candidate| {
        let chance = corrected[places[candidate.key.as_str()]]?;
        Some((candidate, chance))
    });
    met.filter(|(candidate, chance)| {
        *chance <= LIMIT || (candidate.notable && candidate.chance <= NOTED)
    })
    .map(|(candidate, chance)| (candidate.pieces[0], question(candidate, chance, evidence)))
    .collect()
}

fn question(candidate: &Candidate, chance: f64, evidence: &[Evidence]) -> LineageQuestion {
    let [id, with] = candidate.pieces.map(|piece| evidence[piece].id.as_str());
    let settle = format!("`independent = {{ {with} = \"reason\" }}`");
    let remedy = match &candidate.declare {
        Some(declare) => format!(
            "if it was taken from {with}, declare it in {id}'s entry of ledger.toml: `{declare}`; if not, write {settle} there"
        ),
        None => format!(
            "if one is a copy, leave it out or declare its `calibrated`; if not, write {settle} in {id}'s entry of ledger.toml"
        ),
    };
    LineageQuestion {
        with: with.to_owned(),
        kind: candidate.kind,
        subjects: candidate.subjects.clone(),
        finding: candidate.finding.clone(),
        places: candidate.places.clone(),
        chance,
        blocks: chance <= LIMIT,
        settled: None,
        remedy,
    }
}

/// What a piece counted, neither none nor all, each count once.
fn counted(piece: &Evidence) -> Vec<(Subject, Sample)> {
    let mut found: Vec<(Subject, Sample)> = Vec::new();
    for finding in &piece.findings {
        let Measure::Counts { count, trials, .. } = finding.measure else {
            continue;
        };
        let sample = Sample {
            successes: count,
            trials,
        };
        let known = |other: &Sample| other.trials == trials && other.failures() == count;
        let mut others = found.iter().map(|(_, other)| other);
        if sample.is_informative() && !others.any(|it| it == &sample || known(it)) {
            found.push((finding.subject.clone(), sample));
        }
    }
    found
}

/// Whether the ledger says already that a piece was calibrated on another's count of a subject.
fn is_declared(piece: &Evidence, other: &Evidence, subject: &Subject) -> bool {
    let mut calibrated = piece.calibrated.iter();
    calibrated.any(|it| it.from == other.id && &it.subject == subject)
}

fn subject_in_words(subject: &Subject) -> String {
    subject.in_words()
}

/// A probability in few digits.
fn probability(chance: f64) -> String {
    match chance {
        p if p >= 0.095 => format!("{:.0} %", 100.0 * p),
        p if p >= 0.001 => format!("{:.1} %", 100.0 * p),
        p => format!("{p:.1e}"),
    }
}
