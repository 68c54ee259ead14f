//! What a study's result is worth: whether the fault was found and located, beside what two simpler
//! ways of comparing would have said and what theory allows.

use crate::fault::{Fault, Site};
use crate::matrix::site;
use crate::study::{LEVEL, MARGIN, Synthetic, ids, rate};
use crate::theory::{Side, joined_degrees, power, seen};
use evidence::{
    Comparison, CredibleInterval, Evidence, Measure, Outcome, Subject, Suspect, Symptom,
};

/// The score of one study.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// What was planted.
    pub fault: Fault,
    /// Power of the tests that match the fault.
    pub theory: Powers,
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

/// What theory allows of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Powers {
    /// Of the matching test at the declared level, if it were known how alike the attempts of one person are.
    pub known: f64,
    /// The same where that is learned from the people.
    pub learned: f64,
    /// Of the tests that decide when all of the study's comparisons are allowed for, likewise.
    pub of_all: f64,
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
    Score {
        fault: study.planted.fault,
        theory: theory(study),
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
/// a failure mode that a model cannot express, be it the model that is wrong or, on strong evidence, the one that shows it.
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
        Some(Site::Simulation) if study.planted.fault == Fault::ExtraBehaviour => study
            .suspects
            .iter()
            .filter(|suspect| site(suspect) == Site::Simulation && suspect.is_strong())
            .flat_map(|suspect| &suspect.symptoms)
            .any(|symptom| matches!(symptom, Symptom::RateDiffers { subject, .. } if subject == &subjects[0])),
        _ => false,
    }
}

/// Whether the planted fault still shows without a comparison.
pub(crate) fn is_open(study: &Synthetic) -> bool {
    let is_solver = |suspect: &Suspect| site(suspect) == Site::Solver;
    let mut suspects = study.suspects.iter();
    match study.planted.site {
        // A method that stopped early may stand beside the one that counts.
        Some(Site::Solver) => suspects.any(|s| is_solver(s) && s.resolved_by.is_none()),
        _ => otherwise_found(study),
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

/// What is known of how alike the attempts of one person are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Likeness {
    Known,
    Learned,
}

fn theory(study: &Synthetic) -> Powers {
    let planted = &study.planted;
    let same = |power: f64| Powers {
        known: power,
        learned: power,
        of_all: power,
    };
    if let Some(each) = planted.seen_in_a_run {
        return same(seen(each, study.setup.simulated + study.setup.recorded));
    }
    let most = |power: &dyn Fn(&Subject) -> f64| {
        let subjects = planted.subjects.iter();
        subjects.map(power).fold(0.0, f64::max)
    };
    let alpha = 1.0 - LEVEL;
    match planted.site {
        None => same(0.0),
        Some(Site::Solver) => same(1.0),
        Some(_) => Powers {
            known: most(&|subject| best_pair(study, subject, alpha, Likeness::Known)),
            learned: most(&|subject| best_pair(study, subject, alpha, Likeness::Learned)),
            of_all: most(&|subject| simultaneous(study, subject)),
        },
    }
}

/// Of the closed procedure (`evidence::compare`) on `n` subjects, one with `m` pieces of evidence: the odd piece against
/// all others together at the level divided by `n m`, and the best pair at the level divided by `n`. The less of their
/// powers bounds that of both.
fn simultaneous(study: &Synthetic, subject: &Subject) -> f64 {
    let tested = study.comparisons.iter();
    let tested = tested.filter(|c| c.p_difference_corrected.is_some());
    let mut subjects: Vec<&Subject> = tested.clone().map(|c| &c.subject).collect();
    subjects.sort_unstable();
    subjects.dedup();
    let of_subject = tested.filter(|c| &c.subject == subject);
    let mut ids: Vec<&str> = of_subject
        .flat_map(|c| [c.left.as_str(), c.right.as_str()])
        .collect();
    ids.sort_unstable();
    ids.dedup();
    let alpha = (1.0 - LEVEL) / subjects.len().max(1) as f64;
    let pair = best_pair(study, subject, alpha, Likeness::Learned);
    if ids.len() < 3 {
        return pair;
    }
    let sides = |wanted: bool| {
        let faulty = study.faulty();
        let own = ids.iter().filter(move |id| faulty.contains(*id) == wanted);
        own.filter_map(|id| side(study, study.piece(id)?, subject, Likeness::Learned))
    };
    let others: Vec<Side> = sides(false).collect();
    let level = alpha / ids.len() as f64;
    let odd = sides(true).map(|one| power(one, together(&others), level));
    odd.fold(0.0, f64::max).min(pair)
}

/// Several sides as one: a computed value, or all trials.
fn together(sides: &[Side]) -> Side {
    if let Some(computed) = sides.iter().find(|side| side.trials.is_infinite()) {
        return *computed;
    }
    let trials: f64 = sides.iter().map(|side| side.trials).sum();
    let successes: f64 = sides.iter().map(|side| side.trials * side.rate).sum();
    let variances = sides.iter().map(|side| {
        let variance = side.trials * side.rate * (1.0 - side.rate);
        (variance, side.degrees)
    });
    Side {
        rate: successes / trials.max(1.0),
        trials,
        degrees: joined_degrees(variances),
    }
}

/// The best of the tests that compare evidence on the faulty asset with other evidence.
fn best_pair(study: &Synthetic, subject: &Subject, alpha: f64, likeness: Likeness) -> f64 {
    let faulty = study.faulty();
    let mut best = 0.0_f64;
    for id in &faulty {
        let piece = study.piece(id);
        let Some(one) = piece.and_then(|piece| side(study, piece, subject, likeness)) else {
            continue;
        };
        let others = study.evidence.iter();
        for other in others.filter(|p| !p.intermediate && !faulty.contains(&p.id.as_str())) {
            if let Some(other) = side(study, other, subject, likeness) {
                best = best.max(power(one, other, alpha));
            }
        }
    }
    best
}

/// The true rate behind a piece of evidence, and how many independent trials it is worth.
fn side(
    study: &Synthetic,
    piece: &Evidence,
    subject: &Subject,
    likeness: Likeness,
) -> Option<Side> {
    let limit = study.setup.limit_steps;
    let measure = &piece.finding(subject)?.measure;
    let truth = &study.setup.truth;
    let simulated = study.assets.simulated(1.0);
    let task = match piece.id.as_str() {
        ids::MODEL => &study.assets.formal,
        ids::SIMULATION => &simulated,
        _ => truth,
    };
    match measure {
        Measure::Counts { trials, .. } if piece.id == ids::EXPERIMENT => {
            let mut rate = rate(task, limit, subject)?;
            if let Subject::FailureMode(mode) = subject {
                let column = study.assets.modes.iter().position(|m| m == mode)?;
                rate = truth.stages[study.assets.columns[column]].fails;
            }
            Some(of_people(study, rate, *trials as f64, likeness))
        }
        Measure::Counts { trials, .. } => Some(Side::independent(
            rate(task, limit, subject)?,
            *trials as f64,
        )),
        Measure::Probability {
            answer, credible, ..
        } => Some(match credible {
            Some(credible) => {
                let rate = rate(task, limit, subject).unwrap_or(answer.value);
                Side::independent(rate, worth(credible))
            }
            None => Side::computed(answer.value),
        }),
        _ => None,
    }
}

/// Attempts of the study's people. Where nobody ever fails (or everybody does), a column says nothing of how alike the
/// attempts of one person are; if they are all alike, a rate `p` has this outcome with probability `(1 - p)^people`.
/// So no test that has to learn it from that column, and holds its level there, rejects `p` sooner.
fn of_people(study: &Synthetic, rate: f64, trials: f64, likeness: Likeness) -> Side {
    let cohort = study.setup.cohort;
    let people = cohort.subjects as f64;
    let worth = cohort.effective(trials / (people * cohort.attempts as f64));
    let is_certain = rate <= 0.0 || rate >= 1.0;
    match (likeness, is_certain) {
        (Likeness::Known, _) => Side::independent(rate, worth),
        (Likeness::Learned, true) => Side::independent(rate, worth.min(people)),
        (Likeness::Learned, false) => Side {
            rate,
            trials: worth,
            degrees: people - 1.0,
        },
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
