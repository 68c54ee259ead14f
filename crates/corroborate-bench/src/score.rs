//! What a study's result is worth: whether the fault was found and located, beside what two simpler
//! ways of comparing would have said and what theory allows.

use crate::fault::{Fault, Site};
use crate::matrix::site;
use crate::study::{LEVEL, MARGIN, Synthetic, ids, rate};
use crate::theory::{Side, power, seen};
use evidence::{
    Comparison, CredibleInterval, Evidence, Measure, Outcome, Subject, Suspect, Symptom,
};

/// The score of one study.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// What was planted.
    pub fault: Fault,
    /// Power of the matching test at the declared level.
    pub theory: f64,
    /// The same at the level divided by the number of the study's comparisons.
    pub theory_corrected: f64,
    /// A disagreement on a subject that the fault touches, with the evidence that rests on it; where
    /// nothing was planted, any disagreement.
    pub found: bool,
    /// The same by point estimates within the margin.
    pub by_points: bool,
    /// The same by overlap of the intervals.
    pub by_overlap: bool,
    /// Place of the faulty asset in the list of suspects, from 1.
    pub rank: Option<usize>,
    /// How many suspects there are.
    pub suspects: usize,
    /// Agreement of evidence that is called independent although one was calibrated on the other.
    pub false_independence: bool,
}

/// Scores a study.
#[must_use]
pub fn score(study: &Synthetic) -> Score {
    let mut places = study.suspects.iter();
    let place = places.position(|suspect| is_culprit(study, suspect));
    let touched: Vec<&Comparison> = study
        .comparisons
        .iter()
        .filter(|c| touches(study, c))
        .collect();
    let (theory, theory_corrected) = theory(study);
    Score {
        fault: study.planted.fault,
        theory,
        theory_corrected,
        found: touched.iter().any(|c| c.outcome == Outcome::Conflicts) || otherwise_found(study),
        by_points: touched.iter().any(|c| differ_by_points(c)),
        by_overlap: touched.iter().any(|c| lie_apart(study, c)),
        rank: place.map(|place| place + 1),
        suspects: study.suspects.iter().filter(|s| s.score > 0.0).count(),
        false_independence: false_independence(study),
    }
}

/// Whether a comparison can show the fault; every one where there is none.
fn touches(study: &Synthetic, comparison: &Comparison) -> bool {
    if study.planted.site.is_none() {
        return true;
    }
    let faulty = study.faulty();
    let is_faulty = |id: &String| faulty.contains(&id.as_str());
    (is_faulty(&comparison.left) || is_faulty(&comparison.right))
        && study.planted.subjects.contains(&comparison.subject)
}

/// Faults that show without a comparison: two forms on the same runs, two methods on the same model,
/// a failure mode that a model cannot express.
fn otherwise_found(study: &Synthetic) -> bool {
    let subjects = &study.planted.subjects;
    match study.planted.site {
        Some(Site::Property | Site::Monitor) => study
            .evidence
            .iter()
            .flat_map(|piece| &piece.form_differences)
            .any(|difference| subjects.contains(&difference.subject)),
        Some(Site::Solver) => study.suspects.iter().any(|suspect| site(suspect) == Site::Solver),
        Some(Site::FormalModel) if study.planted.fault == Fault::MissingMode => study
            .suspects
            .iter()
            .flat_map(|suspect| &suspect.symptoms)
            .any(|symptom| matches!(symptom, Symptom::MissingMode { mode, .. } if subjects[0].id() == mode)),
        _ => false,
    }
}

/// Whether a suspect is the faulty asset: the right kind, and for a requirement's form the right requirement.
fn is_culprit(study: &Synthetic, suspect: &Suspect) -> bool {
    let planted = &study.planted;
    let is_form = matches!(planted.site, Some(Site::Property | Site::Monitor));
    let is_subject = |subject: &Subject| planted.subjects.contains(subject);
    let is_right = !is_form || suspect.subjects.iter().any(is_subject);
    Some(site(suspect)) == planted.site && is_right
}

fn differ_by_points(comparison: &Comparison) -> bool {
    comparison
        .difference
        .is_some_and(|difference| difference.abs() > MARGIN)
}

fn lie_apart(study: &Synthetic, comparison: &Comparison) -> bool {
    let interval = |id: &str| {
        let finding = study.piece(id)?.finding(&comparison.subject)?;
        finding.measure.interval()
    };
    match (interval(&comparison.left), interval(&comparison.right)) {
        (Some(one), Some(other)) => one.high < other.low || other.high < one.low,
        _ => false,
    }
}

fn false_independence(study: &Synthetic) -> bool {
    let Some(place) = study.assets.calibrated else {
        return false;
    };
    let mode = Subject::FailureMode(study.assets.modes[place].clone());
    study.comparisons.iter().any(|c| {
        c.subject == mode
            && c.left == ids::SIMULATION
            && c.right == ids::EXPERIMENT
            && c.outcome == Outcome::Corroborates
            && c.independent
    })
}

/// Power of the matching test at the declared level, and at that divided by the comparisons made.
fn theory(study: &Synthetic) -> (f64, f64) {
    let planted = &study.planted;
    if let Some(each) = planted.seen_in_a_run {
        let runs = study.setup.simulated + study.setup.recorded;
        let power = seen(each, runs);
        return (power, power);
    }
    match planted.site {
        None => (0.0, 0.0),
        Some(Site::Solver) => (1.0, 1.0),
        Some(_) => {
            let family = study
                .comparisons
                .iter()
                .filter(|c| c.p_difference_corrected.is_some());
            let family = family.count().max(1) as f64;
            let alpha = 1.0 - LEVEL;
            (best_power(study, alpha), best_power(study, alpha / family))
        }
    }
}

/// The best of the tests that compare evidence on the faulty asset with other evidence.
fn best_power(study: &Synthetic, alpha: f64) -> f64 {
    let faulty = study.faulty();
    let mut best = 0.0_f64;
    for subject in &study.planted.subjects {
        for id in &faulty {
            let Some(one) = study
                .piece(id)
                .and_then(|piece| side(study, piece, subject))
            else {
                continue;
            };
            for other in study
                .evidence
                .iter()
                .filter(|p| !p.intermediate && !faulty.contains(&p.id.as_str()))
            {
                if let Some(other) = side(study, other, subject) {
                    best = best.max(power(one, other, alpha));
                }
            }
        }
    }
    best
}

/// The true rate behind a piece of evidence, and how many independent trials it is worth.
fn side(study: &Synthetic, piece: &Evidence, subject: &Subject) -> Option<Side> {
    let limit = study.setup.limit_steps;
    let measure = &piece.finding(subject)?.measure;
    let truth = &study.setup.truth;
    let task = match piece.id.as_str() {
        ids::MODEL => &study.assets.formal,
        ids::SIMULATION => &study.assets.simulator,
        _ => truth,
    };
    match measure {
        Measure::Counts { trials, .. } => {
            let mut rate = rate(task, limit, subject)?;
            let mut trials = *trials as f64;
            if piece.id == ids::EXPERIMENT {
                let cohort = study.setup.cohort;
                trials = cohort.effective(trials / (cohort.subjects * cohort.attempts) as f64);
                if let Subject::FailureMode(mode) = subject {
                    let column = study.assets.modes.iter().position(|m| m == mode)?;
                    rate = truth.stages[study.assets.columns[column]].fails;
                }
            }
            Some(Side { rate, trials })
        }
        Measure::Probability {
            answer, credible, ..
        } => Some(match credible {
            Some(credible) => Side {
                rate: rate(task, limit, subject).unwrap_or(answer.value),
                trials: worth(credible),
            },
            None => Side {
                rate: answer.value,
                trials: f64::INFINITY,
            },
        }),
        _ => None,
    }
}

/// Trials that would leave the variance of a distribution.
fn worth(credible: &CredibleInterval) -> f64 {
    let variance = stats::Draws::new(&credible.quantiles).map_or(0.0, |draws| draws.variance());
    if variance > 1e-18 {
        credible.mean * (1.0 - credible.mean) / variance
    } else {
        f64::INFINITY
    }
}
