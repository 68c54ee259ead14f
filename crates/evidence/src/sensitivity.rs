//! What would follow if trials that are counted as independent were alike within people or sessions.
//!
//! # Definition
//! Counts of experiments and operation have *unknown clustering* if nothing tells whose trials they are (totals, recordings),
//! or if all are one person's. With groups of `m` trials and the intraclass correlation `rho` they count as
//! `N / (1 + (m - 1) rho)` independent ones; `m` is all trials of one person, and else assumed: [`ASSUMED_GROUP`] trials.
//! All comparisons and conclusions are drawn again at each of [`CORRELATIONS`], with the same correlation for all such
//! evidence. A decision (a pair that agrees or conflicts, a requirement that is satisfied or violated, with the step on which
//! it is) *holds up to* the largest of these below the first at which it is another.
//!
//! # Source
//! L. Kish, "Survey sampling" (1965), for the design effect. That the least deviation is given at which a conclusion
//! falls follows J. Cornfield et al., "Smoking and lung cancer" (1959).
//!
//! # Assumes
//! All evidence of unknown clustering has one correlation, which is not negative, and groups of one size. Both are
//! supposed, not found.
//!
//! # Guarantee
//! It is no test: nothing is known of the correlation. Decisions between two of the correlations are not looked at.
//! Cost: that of comparing and concluding, for each correlation until all decisions have changed.

use crate::compare::words::list;
use crate::compare::{Computed, compare_knowing};
use crate::{
    ClusterSensitivity, Comparison, Conclusion, Evidence, ExclusionReason, Measure, Outcome, Step,
    Study, Verdict, conclude,
};
use stats::{Confidence, Sample, kish_design_effect};

/// Trials of one person or session where the tables do not tell.
pub const ASSUMED_GROUP: u64 = 10;

/// The correlations at which decisions are drawn again.
pub const CORRELATIONS: [f64; 12] = [
    0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0,
];

/// Adds to each decision that rests on counts of unknown clustering up to which correlation it holds.
pub fn bear_clustering(
    study: &Study<'_>,
    comparisons: &mut [Comparison],
    conclusions: &mut [Conclusion],
) {
    if !study.evidence.iter().any(is_unknown) {
        return;
    }
    let mut pairs: Vec<Option<f64>> = vec![None; comparisons.len()];
    let mut verdicts: Vec<Option<f64>> = vec![None; conclusions.len()];
    let mut below = 0.0;
    let computed = Computed::default();
    for correlation in CORRELATIONS {
        let changed: Vec<Evidence> = study
            .evidence
            .iter()
            .map(|piece| at(study, piece, correlation))
            .collect();
        let again = Study {
            evidence: &changed,
            ..*study
        };
        let compared = compare_knowing(&again, &computed);
        let concluded = conclude(&again, &compared);
        for ((found, was), is) in pairs.iter_mut().zip(&*comparisons).zip(&compared) {
            if was.outcome != is.outcome {
                found.get_or_insert(below);
            }
        }
        for ((found, was), is) in verdicts.iter_mut().zip(&*conclusions).zip(&concluded) {
            // Also where another piece says the same on a lower step.
            if (was.verdict, was.step) != (is.verdict, is.step) {
                found.get_or_insert(below);
            }
        }
        below = correlation;
    }
    for (comparison, found) in comparisons.iter_mut().zip(pairs) {
        let sides = [&comparison.left, &comparison.right];
        if matches!(
            comparison.outcome,
            Outcome::Corroborates | Outcome::Conflicts
        ) {
            let on = |piece: &&Evidence| {
                let finding = piece.finding(&comparison.subject);
                sides.contains(&&piece.id) && finding.is_some_and(|it| is_plain(&it.measure))
            };
            let what = "The comparison";
            comparison.clustering = sensitivity(study.evidence, on, what, found);
        }
    }
    for (conclusion, found) in conclusions.iter_mut().zip(verdicts) {
        // A verdict for the model, or in simulation, counts no trials of the system.
        let is_of_system = conclusion
            .step
            .is_some_and(|step| step >= Step::Corroborated);
        if is_of_system && matches!(conclusion.verdict, Verdict::Satisfied | Verdict::Violated) {
            let decides = |id: &String| {
                let mut excluded = conclusion.excluded.iter();
                !excluded.any(|it| &it.evidence == id && it.reason == ExclusionReason::OneSubject)
            };
            let on =
                |piece: &&Evidence| conclusion.rests_on.contains(&piece.id) && decides(&piece.id);
            let found = sensitivity(study.evidence, on, "The verdict", found);
            conclusion.clustering.extend(found);
        }
    }
}

/// Whether counts of a piece may be of unknown clustering.
fn is_unknown(piece: &Evidence) -> bool {
    let is_real = piece.technique.is_of_system();
    let is_grouped = piece.clusters.as_ref().is_some_and(|it| it.subjects != 1);
    is_real && !is_grouped && piece.findings.iter().any(|it| is_plain(&it.measure))
}

/// Counts that are taken as independent trials.
fn is_plain(measure: &Measure) -> bool {
    let Measure::Counts {
        trials,
        effective_trials,
        ..
    } = measure
    else {
        return false;
    };
    *trials > 1 && effective_trials.is_none_or(|size| size >= *trials as f64)
}

/// Trials in each group, and whether that is an assumption.
fn group(piece: &Evidence, trials: u64) -> (u64, bool) {
    match &piece.clusters {
        Some(clusters) if clusters.subjects == 1 => (trials, false),
        _ => (ASSUMED_GROUP.min(trials), true),
    }
}

/// A piece with its counts at what they are worth at a correlation.
fn at(study: &Study<'_>, piece: &Evidence, correlation: f64) -> Evidence {
    let mut changed = piece.clone();
    if !is_unknown(piece) {
        return changed;
    }
    let level = study.levels.confidence;
    for finding in &mut changed.findings {
        let completions = finding.completions.iter_mut();
        let ends = completions.flat_map(|it| &mut it.ends);
        for measure in ends.chain([&mut finding.measure]) {
            if let Some(known) = measure_at(piece, measure, correlation, level) {
                *measure = known;
            }
        }
    }
    changed
}

/// A count at what it is worth at a correlation; `None` of what is not counted as independent trials.
fn measure_at(
    piece: &Evidence,
    measure: &Measure,
    correlation: f64,
    level: Confidence,
) -> Option<Measure> {
    let Measure::Counts { count, trials, .. } = *measure else {
        return None;
    };
    if !is_plain(measure) {
        return None;
    }
    let (size, _) = group(piece, trials);
    let worth = trials as f64 / kish_design_effect(size as f64, correlation);
    let sample = Sample {
        successes: count,
        trials,
    };
    Measure::of_counts(sample, Some(worth), level).ok()
}

fn sensitivity<'a>(
    evidence: &'a [Evidence],
    bears: impl Fn(&&'a Evidence) -> bool,
    what: &str,
    holds_up_to: Option<f64>,
) -> Option<ClusterSensitivity> {
    let pieces: Vec<&Evidence> = evidence
        .iter()
        .filter(|piece| is_unknown(piece))
        .filter(bears)
        .collect();
    let sizes: Vec<(u64, bool)> = pieces
        .iter()
        .map(|piece| group(piece, most_trials(piece)))
        .collect();
    let (size, _) = *sizes.iter().max()?;
    let is_assumed = sizes.iter().any(|(_, assumed)| *assumed);
    let groups: Vec<String> = pieces.iter().zip(&sizes).map(in_words).collect();
    let holds = match holds_up_to {
        None => "holds at any intraclass correlation".to_owned(),
        Some(most) if most <= 0.0 => format!(
            "holds only if trials are independent, and changes from an intraclass correlation of {} on",
            CORRELATIONS[0]
        ),
        Some(most) => format!("holds up to an intraclass correlation of {most}"),
    };
    Some(ClusterSensitivity {
        evidence: pieces.iter().map(|piece| piece.id.clone()).collect(),
        group_size: size as f64,
        is_assumed,
        holds_up_to,
        statement: format!(
            "{what} counts trials of {} as independent: it {holds}.",
            list(&groups)
        ),
    })
}

fn most_trials(piece: &Evidence) -> u64 {
    let trials = piece.findings.iter().map(|finding| match finding.measure {
        Measure::Counts { trials, .. } => trials,
        _ => 0,
    });
    trials.max().unwrap_or(0)
}

/// Whose trials they are, as far as is known.
fn in_words((piece, (size, is_assumed)): (&&Evidence, &(u64, bool))) -> String {
    let is_declared = !piece.is_of_one_subject();
    match is_assumed {
        true => format!(
            "{} (by people or sessions not known, {size} each assumed)",
            piece.id
        ),
        false if is_declared => format!(
            "{} (all {size} of one person or session, declared to stand for all)",
            piece.id
        ),
        false => format!(
            "{} (all {size} of one person or session, of whom alone they tell)",
            piece.id
        ),
    }
}
