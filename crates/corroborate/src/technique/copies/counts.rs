//! Counts of one piece of evidence that are another's: totals copied from table to table, or from a simulation.
//!
//! # Definition
//! Two pieces, at least one of them read from tables, that count a subject in the same number of trials could have met in
//! the count, with the probability of `stats::count_by_chance`. Failure modes of one pair are taken as independent, as
//! their opportunities are told apart; requirements, which follow from them, count where no failure mode was counted.
//!
//! # Guarantee
//! Counts of none or all, and of other numbers of trials, tell nothing. "50 of 50" twice is no question.

use super::{Candidate, counted, is_declared, probability, subject_in_words};
use evidence::{CopyKind, Evidence, Subject};
use stats::Sample;
use study::Study;

/// All pairs of counts.
pub(super) fn candidates(study: &Study, evidence: &[Evidence]) -> Vec<Candidate> {
    let is_read = |piece: &Evidence| {
        let entry = study.ledger.iter().find(|entry| entry.id == piece.id);
        entry.is_some_and(|entry| entry.work.is_read())
    };
    let counts: Vec<Vec<(Subject, Sample)>> = evidence.iter().map(counted).collect();
    let mut candidates = Vec::new();
    for later in 0..evidence.len() {
        for earlier in 0..later {
            if is_read(&evidence[earlier]) || is_read(&evidence[later]) {
                let pair = [later, earlier];
                candidates.extend(of_pair(evidence, pair, pair.map(|it| &counts[it])));
            }
        }
    }
    candidates
}

fn of_pair(
    evidence: &[Evidence],
    [later, earlier]: [usize; 2],
    [ours, theirs]: [&Vec<(Subject, Sample)>; 2],
) -> Vec<Candidate> {
    let (piece, other) = (&evidence[later], &evidence[earlier]);
    let common = || {
        ours.iter().filter_map(|(subject, sample)| {
            let (_, theirs) = theirs.iter().find(|(about, _)| about == subject)?;
            let free = !is_declared(piece, other, subject) && !is_declared(other, piece, subject);
            (free && theirs.trials == sample.trials).then_some((subject, *sample, *theirs))
        })
    };
    let is_mode = |subject: &Subject| matches!(subject, Subject::FailureMode(_));
    let has_modes = common().any(|(subject, ..)| is_mode(subject));
    common()
        .filter(|(subject, ..)| !has_modes || is_mode(subject))
        .map(|(subject, sample, theirs)| {
            let chance = stats::count_by_chance(theirs);
            Candidate {
                pieces: [later, earlier],
                kind: CopyKind::Counts,
                subjects: vec![subject.clone()],
                key: format!("{later} {earlier} {subject:?}"),
                chance,
                met: sample == theirs,
                notable: false,
                finding: format!(
                    "{} and {} both count {}/{} of {} (an independent count is the same with a probability of {})",
                    piece.id,
                    other.id,
                    sample.successes,
                    sample.trials,
                    subject_in_words(subject),
                    probability(chance)
                ),
                places: Vec::new(),
                declare: None,
            }
        })
        .collect()
}
