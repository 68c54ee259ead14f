//! Coverage: how often an interval of 95 % holds the truth, by kind of evidence.
//!
//! # Definition
//! From each study in which nothing is planted one interval of each kind is taken at random, so that those
//! counted together are independent. What needs constants that were counted is looked at in every study of toys and serial
//! tasks: where its constants are known, they are counted for this, on the same truth.
//!
//! A *gain* is that of a variant with one rate halved: on pairs of runs with the same seeds
//! ([`stats::Pairs`]), or at the same points of the constants' posteriors
//! ([`stats::paired_difference`]), as `corroborate what-if` predicts it. *Robust bounds* and the *common
//! statement* are one-sided or for the worst case: they hold the truth at least as often as declared, and mostly oftener.

use crate::carried::Open;
use crate::fault::Assets;
use crate::random::Random;
use crate::requirements::id;
use crate::study::{LEVEL, Synthetic, counted_model, ids, rate};
use crate::task::{Run, Task};
use evidence::{Direction, Finding, Interval, Measure, Subject};
use stats::Confidence;
use stats::Pairs;

/// A kind of interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Counts of independent runs.
    Runs,
    /// Counts of people whose attempts are independent.
    People,
    /// Counts of people whose attempts are alike.
    AlikePeople,
    /// A model whose constants were counted.
    Model,
    /// The difference of two pieces of evidence.
    Difference,
    /// What the independent evidence supports together.
    Combined,
    /// What all pieces support at once: a bound on one side.
    Common,
    /// The gain of a variant on the same seeds.
    GainOfRuns,
    /// The gain of a variant of a model whose constants were counted.
    GainOfModel,
    /// Bounds of an interval model.
    Robust,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 10] = [
        Kind::Runs,
        Kind::People,
        Kind::AlikePeople,
        Kind::Model,
        Kind::Difference,
        Kind::Combined,
        Kind::GainOfRuns,
        Kind::GainOfModel,
        Kind::Common,
        Kind::Robust,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::Runs => "simulation and operation: independent runs",
            Kind::People => "experiments: attempts independent",
            Kind::AlikePeople => "experiments: attempts of one person alike",
            Kind::Model => "model checking: constants counted",
            Kind::Difference => "difference of two techniques",
            Kind::Combined => "combined conclusion of two pieces or more",
            Kind::GainOfRuns => "what-if: gain on the same seeds",
            Kind::GainOfModel => "what-if: gain of a model, constants counted",
            Kind::Common => "sound common statement (at least 95 %)",
            Kind::Robust => "robust bounds, constants counted (at least 95 %)",
        }
    }

    /// Whether it promises the level at least, and no more.
    #[must_use]
    pub fn is_bound(self) -> bool {
        matches!(self, Kind::Common | Kind::Robust)
    }

    /// Whether it is the interval of one piece of evidence.
    #[must_use]
    pub fn is_of_a_piece(self) -> bool {
        matches!(
            self,
            Kind::Runs | Kind::People | Kind::AlikePeople | Kind::Model
        )
    }
}

/// What a number that is computed may lack by rounding.
const ROUNDING: f64 = 1e-9;

/// One interval of each kind that the study has, and whether the truth is in it.
///
/// # Errors
/// What is wrong with the formal model.
pub fn coverage(study: &Synthetic, random: &mut Random) -> Result<Vec<(Kind, bool)>, String> {
    let mut found: Vec<(Kind, bool)> = study
        .evidence
        .iter()
        .filter(|piece| [ids::SIMULATION, ids::EXPERIMENT].contains(&piece.id.as_str()))
        .filter_map(|piece| {
            let kind = match piece.id.as_str() {
                ids::SIMULATION => Kind::Runs,
                _ if study.setup.cohort.correlation > 0.0 => Kind::AlikePeople,
                _ => Kind::People,
            };
            let counted: Vec<&Finding> = piece.findings.iter().filter(|f| is_counted(f)).collect();
            let finding = pick(&counted, random)?;
            let truth = study.truth(&finding.subject)?;
            Some((kind, holds(finding.measure.interval()?, truth)))
        })
        .collect();
    let with_interval: Vec<_> = study
        .comparisons
        .iter()
        .filter_map(|c| c.difference_interval)
        .collect();
    if let Some(interval) = pick(&with_interval, random) {
        found.push((Kind::Difference, holds(interval, 0.0)));
    }
    found.extend(conclusions(study, random)?);
    found.push(gain_of_runs(study, random));
    // The models of the case studies are solved too seldom for the ends of an interval.
    if !study.setup.family.is_case_study() {
        found.extend(of_counted_model(study, random)?);
    }
    Ok(found)
}

fn pick<T: Copy>(all: &[T], random: &mut Random) -> Option<T> {
    (!all.is_empty()).then(|| random.one_of(all))
}

/// Whether a truth is within, up to rounding.
fn holds(interval: Interval, truth: f64) -> bool {
    interval.low - ROUNDING <= truth && truth <= interval.high + ROUNDING
}

fn is_counted(finding: &Finding) -> bool {
    matches!(finding.measure, Measure::Counts { trials, .. } if trials > 0)
}

/// A combined conclusion, and a common statement.
fn conclusions(study: &Synthetic, random: &mut Random) -> Result<Vec<(Kind, bool)>, String> {
    let all = study.combined()?;
    let truth = |requirement: &str| study.truth(&Subject::Requirement(requirement.to_owned()));
    let combined: Vec<(Interval, f64)> = all
        .iter()
        .filter(|one| one.model.is_some())
        .filter_map(|one| Some((one.interval?, truth(&one.requirement)?)))
        .collect();
    let common: Vec<bool> = all
        .iter()
        .filter_map(|one| {
            let (bound, truth) = (one.common.as_ref()?, truth(&one.requirement)?);
            Some(match bound.direction {
                Direction::AtLeast => truth >= bound.value - ROUNDING,
                Direction::AtMost => truth <= bound.value + ROUNDING,
            })
        })
        .collect();
    let combined = pick(&combined, random).map(|(it, truth)| (Kind::Combined, holds(it, truth)));
    let common = pick(&common, random).map(|holds| (Kind::Common, holds));
    Ok(combined.into_iter().chain(common).collect())
}

/// The variant of a task that has one rate halved.
fn halved(task: &Task, place: usize) -> Task {
    let mut variant = task.clone();
    variant.stages[place].fails *= 0.5;
    variant
}

/// The true gain of halving a rate.
fn true_gain(study: &Synthetic, place: usize, subject: &Subject) -> Option<f64> {
    let setup = &study.setup;
    let of = |task: &Task| rate(task, setup.limit_steps, subject);
    Some(of(&halved(&setup.truth, place))? - of(&setup.truth)?)
}

fn gain_of_runs(study: &Synthetic, random: &mut Random) -> (Kind, bool) {
    let setup = &study.setup;
    let place = random.below(setup.truth.stages.len());
    let subject = random.one_of(&[id::DONE, id::IN_TIME]);
    let (seed, number) = study.seed;
    let counts = |run: &Run| match subject {
        id::DONE => run.is_done(),
        _ => run.is_done_by(setup.limit_steps),
    };
    let variant = halved(&setup.truth, place);
    let mut pairs = Pairs::default();
    for episode in 0..setup.simulated as u64 {
        let run = |task: &Task| {
            let stream = (number << 16) + 1 + episode;
            counts(&task.run(&mut Random::new(seed ^ 0x9a1, stream)))
        };
        let (first, second) = (run(&setup.truth), run(&variant));
        pairs.pairs += 1;
        pairs.only_first += u64::from(first && !second);
        pairs.only_second += u64::from(second && !first);
    }
    let interval = pairs.interval(Confidence::P95);
    let truth = true_gain(study, place, &Subject::Requirement(subject.to_owned()));
    let covers = truth.is_some_and(|truth| interval.low <= truth && truth <= interval.high);
    (Kind::GainOfRuns, covers)
}

/// What a model with counted constants says: one answer with its interval, its robust bounds, and a gain.
fn of_counted_model(study: &Synthetic, random: &mut Random) -> Result<Vec<(Kind, bool)>, String> {
    let mut setup = study.setup.clone();
    if setup.rig.is_none() {
        setup.count_constants(random);
    }
    let formal = counted_model(&setup, &Assets::sound(&setup))?;
    let level = Confidence::new(LEVEL).map_err(|error| error.to_string())?;
    let open = Open::new(&formal)?;
    let points = open.points(study.seed.0);
    let at = |points: &[Vec<f64>]| -> Result<Vec<Vec<Option<f64>>>, String> {
        points.iter().map(|point| open.at(point)).collect()
    };
    let rows = at(&points)?;
    let column = |rows: &[Vec<Option<f64>>], place: usize| -> Option<Vec<f64>> {
        rows.iter().map(|row| row[place]).collect()
    };
    let places: Vec<usize> = (0..formal.questions.len())
        .filter(|place| column(&rows, *place).is_some())
        .collect();
    let mut found = Vec::new();
    let Some(place) = pick(&places, random) else {
        return Ok(found);
    };
    let subject = &formal.questions[place].subject;
    let (Some(truth), Some(values)) = (study.truth(subject), column(&rows, place)) else {
        return Ok(found);
    };
    let covers = |draws: stats::Draws, truth: f64| {
        let interval = draws.interval(level);
        let (low, high) = (interval.low, interval.high);
        holds(Interval { low, high }, truth)
    };
    let draws = stats::Draws::new(&values).map_err(|error| error.to_string())?;
    // What no constant moves is computed, and has no interval of sampling.
    if draws.variance() > 1e-18 {
        found.push((Kind::Model, covers(draws, truth)));
    }
    if let Some(bounds) = open.robust(level)?[place] {
        found.push((Kind::Robust, holds(bounds, truth)));
    }
    let stage = random.below(setup.truth.stages.len());
    let (_, is_complement) = setup.constant(stage);
    let varied: Vec<Vec<f64>> = points
        .iter()
        .map(|point| {
            let mut point = point.clone();
            point[stage] = match is_complement {
                true => 1.0 - 0.5 * (1.0 - point[stage]),
                false => 0.5 * point[stage],
            };
            point
        })
        .collect();
    let after = column(&at(&varied)?, place);
    if let (Some(after), Some(gain)) = (after, true_gain(study, stage, subject)) {
        let gains = stats::paired_difference(&values, &after);
        let gains = gains.map_err(|error| error.to_string())?;
        if gains.variance() > 1e-18 {
            found.push((Kind::GainOfModel, covers(gains, gain)));
        }
    }
    Ok(found)
}
