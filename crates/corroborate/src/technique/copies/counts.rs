//! Counts of one piece of evidence that are another's: totals copied from table to table, or from a simulation.
//!
//! # Definition
//! Two pieces, at least one of them read from tables, that count a subject in the same number of trials could have met in
//! the count, with the probability of `stats::count_by_chance`. Failure modes of one pair are taken as independent, as
//! their opportunities are told apart; requirements, which follow from them, count where no failure mode was counted.
//!
//! Tables of totals that are the same to the byte under two names are one coincidence of their own: as many trials
//! (`stats::SAME_TRIALS`), and each count again.
//!
//! # Assumes
//! Counts of an independent piece are of the rate that the posterior has, of independent trials: people's attempts that are
//! alike give the same count less often. Failure modes of one pair are independent of each other.
//!
//! # Guarantee
//! Single counts of none or all, and of other numbers of trials, tell nothing. "50 of 50" twice is no question.

use super::{Candidate, counted, is_declared, probability, subject_in_words};
use evidence::{AssetRole, CopyKind, Evidence, Measure, Subject};
use stats::Sample;
use study::Study;

/// The probability up to which one count that is another's is noted.
const NOTED_COUNT: f64 = 0.1;

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
                candidates.extend(of_files(study, evidence, pair));
            }
        }
    }
    candidates
}

/// That two tables of totals are the same to the byte.
fn of_files(study: &Study, evidence: &[Evidence], pair: [usize; 2]) -> Option<Candidate> {
    let [piece, other] = pair.map(|it| &evidence[it]);
    let has_totals = |piece: &Evidence| {
        let entry = study.ledger.iter().find(|entry| entry.id == piece.id);
        let tables = entry.and_then(|entry| entry.work.tables());
        tables.is_some_and(|tables| tables.cohort.is_none() && tables.episodes.is_none())
    };
    if !has_totals(piece) || !has_totals(other) {
        return None;
    }
    let data = |piece: &Evidence| {
        let all = piece.assets.iter();
        let all = all.filter(|it| it.role == AssetRole::Data && !it.hash.is_empty());
        all.cloned().collect::<Vec<_>>()
    };
    let theirs = data(other);
    // The same file under one name is no coincidence.
    let (own, same) = data(piece).into_iter().find_map(|own| {
        let same = theirs.iter().find(|it| it.hash == own.hash)?;
        (same.path != own.path).then(|| (own.path, same.path.clone()))
    })?;
    let again = piece.findings.iter().filter_map(|finding| {
        let theirs = other.finding(&finding.subject)?;
        match (&finding.measure, &theirs.measure) {
            (Measure::Counts { count, trials, .. }, Measure::Counts { .. }) => {
                let sample = Sample::new(*count, *trials).ok()?;
                Some(stats::count_by_chance(sample))
            }
            _ => None,
        }
    });
    let chance = stats::SAME_TRIALS * again.product::<f64>();
    Some(Candidate {
        pieces: pair,
        kind: CopyKind::File,
        subjects: Vec::new(),
        key: format!("{} {} file", pair[0], pair[1]),
        chance,
        met: true,
        notable: true,
        finding: format!(
            "`{own}` is `{same}` to the byte (independent counts are the same with a probability of {})",
            probability(chance)
        ),
        places: vec![own, same],
        declare: None,
    })
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
                // One total that is another's is worth a word where two tables say it.
                notable: chance <= NOTED_COUNT,
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
