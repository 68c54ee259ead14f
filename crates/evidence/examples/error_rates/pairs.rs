//! Pairs over looks: trials are added to one side or both and the pair is compared again, until what is sought is shown,
//! or to the end of the rule (`looks`).
//!
//! The p-values over all looks are worked out here from those of each look, each once, as the definition of
//! `compare/past.rs` says: `compare` itself works all of them out again at each look. `tests/integration/error_rates.rs` holds both
//! against each other.

use super::looks::Going;
use super::several::concluded;
use super::support::{Uniform, at_least, counts, exact, piece, requirement};
use super::table::{Job, Row, all};
use evidence::*;
use stats::{Sample, ScoredLook, continued_p};

/// What is sought of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    Difference,
    Agreement,
}

/// What is compared, and how trials are added.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub going: Going,
    /// Of both sides; the second is known exactly where it is a model's.
    pub rates: [f64; 2],
    pub is_model: bool,
    /// Trials are added to one side at a time, in turn.
    pub one_side: bool,
    pub margin: f64,
    pub first: u64,
}

/// Both sides: counts, and a second one that may be known.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    pub first: Sample,
    /// `Err` for a known rate.
    pub second: Result<Sample, f64>,
}

impl Sides {
    fn estimates(&self) -> [f64; 2] {
        let rate = |sample: &Sample| sample.successes as f64 / sample.trials as f64;
        [
            rate(&self.first),
            self.second.as_ref().map_or_else(|known| *known, rate),
        ]
    }

    fn information(&self) -> f64 {
        let of = |sample: &Sample| 1.0 / sample.trials as f64;
        1.0 / (of(&self.first) + self.second.as_ref().map_or(0.0, of))
    }

    /// The p-value if this was the only look.
    fn once(&self, sought: Sought, margin: f64) -> f64 {
        match (sought, self.second) {
            (Sought::Difference, Ok(second)) => stats::boschloo_exact(self.first, second),
            (Sought::Agreement, Ok(second)) => {
                stats::exact_equivalence(self.first, second, margin).unwrap_or(1.0)
            }
            (Sought::Difference, Err(known)) => stats::binomial_test_two_sided(self.first, known),
            (Sought::Agreement, Err(known)) => {
                let above = match known - margin < 0.0 {
                    true => 0.0,
                    false => stats::binomial_test_above(self.first, known - margin),
                };
                let below = match known + margin > 1.0 {
                    true => 0.0,
                    false => stats::binomial_test_below(self.first, known + margin),
                };
                above.max(below)
            }
        }
    }
}

/// All looks with the p-value that each would have alone.
#[derive(Default)]
pub struct History {
    looks: Vec<(Sides, f64)>,
}

impl History {
    /// The p-value over all looks with this one.
    pub fn and(&mut self, sides: Sides, sought: Sought, margin: f64) -> f64 {
        self.looks.push((sides, sides.once(sought, margin)));
        let p = |directed: &dyn Fn(&Sides, f64) -> f64| {
            let scored = self.looks.iter().map(|(sides, once)| ScoredLook {
                p: directed(sides, *once),
                information: sides.information(),
            });
            continued_p(&scored.collect::<Vec<_>>())
        };
        if sought == Sought::Agreement {
            let samples: Vec<Sample> = self.looks.iter().map(|(sides, _)| sides.first).collect();
            return match sides.second {
                Ok(_) => p(&|_, once| once),
                Err(known) => stats::continued_above(&samples, known - margin)
                    .max(stats::continued_below(&samples, known + margin)),
            };
        }
        let side = |sign: f64| {
            p(&|sides, once| {
                let [first, second] = sides.estimates();
                match (second - first) * sign > 0.0 {
                    true => 0.5 * once,
                    false => 1.0 - 0.5 * once,
                }
            })
        };
        (2.0 * side(1.0).min(side(-1.0))).min(1.0)
    }
}

/// Draws one study until it shows what is sought.
fn comes_out(case: &Case, sought: Sought, uniform: &mut Uniform) -> bool {
    let mut history = History::default();
    let none = Sample {
        successes: 0,
        trials: 0,
    };
    let (mut sides, mut further) = ([none; 2], [case.first; 2]);
    let mut looks = Looks::default();
    for look in 0..case.going.looks() {
        for (place, side) in sides.iter_mut().enumerate() {
            side.successes += uniform.count(further[place], case.rates[place]);
            side.trials += further[place];
        }
        let second = match case.is_model {
            true => Err(case.rates[1]),
            false => Ok(sides[1]),
        };
        let now = Sides {
            first: sides[0],
            second,
        };
        let p = history.and(now, sought, case.margin);
        let [a, b] = now.estimates();
        let is_inside = (a - b).abs() < case.margin;
        if p <= 0.05 && (sought == Sought::Difference || is_inside) {
            return true;
        }
        if sides[0].trials + sides[1].trials > 20 * case.first {
            return false;
        }
        let planned = match case.going {
            Going::AsProposed => proposed(now, case.margin, &mut looks),
            _ => Some([0; 2]),
        };
        let Some(planned) = planned else { return false };
        for (place, more) in further.iter_mut().enumerate() {
            let proposed = || Some(planned[place].min(10 * case.first));
            let is_left_out = case.one_side && place == look % 2;
            let grows = case.going == Going::AsProposed || !is_left_out;
            let trials = sides[place].trials;
            *more = match grows {
                true => case.going.further(trials, p, proposed).unwrap_or(0),
                false => 0,
            };
        }
    }
    false
}

/// A ledger of the two.
pub fn ledger(sides: Sides) -> [Evidence; 2] {
    let first = counts(sides.first.successes, sides.first.trials);
    let second = match sides.second {
        Ok(sample) => counts(sample.successes, sample.trials),
        Err(known) => exact(known),
    };
    let technique = match sides.second {
        Ok(_) => Technique::Simulation,
        Err(_) => Technique::ModelChecking,
    };
    [
        piece("E", Technique::Experiment, vec![(0, first)]),
        piece("S", technique, vec![(0, second)]),
    ]
}

/// The further trials of both sides in the cheapest plan for the pair.
fn proposed(sides: Sides, margin: f64, looks: &mut Looks) -> Option<[u64; 2]> {
    let ledger = ledger(sides);
    *looks = std::mem::take(looks).with(Look::of(&ledger));
    let asked = [Requirement {
        margin,
        ..requirement(0, at_least(0.5))
    }];
    let (mut comparisons, _) = concluded(&ledger, &asked, Some(looks));
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &asked,
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        looks: Some(looks),
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let plans = undecided(&study, &mut comparisons, &TrialCosts::equal());
    let plan = plans.first()?.plans.first()?;
    let of = |id: &str| {
        plan.trials
            .iter()
            .find(|it| it.evidence == id)
            .map_or(0, |it| it.trials)
    };
    Some([of("E"), of("S")])
}

/// How often what is sought is shown.
pub fn share(case: &Case, sought: Sought, studies: u64) -> (u64, u64) {
    let seed =
        31 + case.going as u64 + 10 * u64::from(case.is_model) + 20 * u64::from(case.one_side);
    let mut uniform = Uniform(seed);
    let found = (0..studies).filter(|_| comes_out(case, sought, &mut uniform));
    (found.count() as u64, studies)
}

fn row(case: &Case, sought: Sought, studies: u64) -> Row {
    let [a, b] = case.rates;
    let what = match (case.is_model, case.one_side) {
        (true, _) => "counts and a model",
        (false, false) => "counts, both growing",
        (false, true) => "counts, growing in turn",
    };
    let margin = case.margin;
    let name = format!(
        "{what}, {}: rates {a} and {b}, margin {margin}",
        case.going.name()
    );
    let apart = (a - b).abs();
    let (statement, is_true) = match sought {
        Sought::Difference => ("they differ, at any look", apart > 0.0),
        Sought::Agreement => ("they agree, at any look", apart < margin - 1e-9),
    };
    let most = (!is_true).then_some(0.05);
    Row::counted(&name, statement, share(case, sought, studies), most)
}

/// Of two counts.
pub fn rows(studies: u64) -> Vec<Row> {
    rows_of(studies, &[(false, false), (false, true)])
}

/// Of counts and a rate that a model computes.
pub fn rows_with_a_model(studies: u64) -> Vec<Row> {
    rows_of(studies, &[(true, false)])
}

fn rows_of(studies: u64, kinds: &[(bool, bool)]) -> Vec<Row> {
    let mut jobs: Vec<Job<'_>> = Vec::new();
    let mut add = |case: Case, sought: Sought, studies: u64| {
        jobs.push(Box::new(move || vec![row(&case, sought, studies)]));
    };
    for going in Going::ALL {
        for (is_model, one_side) in kinds.iter().copied() {
            if going == Going::AsProposed && one_side {
                continue;
            }
            let equal = Case {
                going,
                rates: [0.88, 0.88],
                is_model,
                one_side,
                margin: 0.1,
                first: 60,
            };
            let apart = Case {
                rates: [0.85, 0.95],
                ..equal
            };
            let few = match going {
                Going::AsProposed => studies / 10,
                Going::Often => studies / 2,
                _ => studies,
            };
            add(equal, Sought::Difference, few);
            add(apart, Sought::Agreement, few);
            let below = Case {
                rates: [0.95, 0.85],
                ..equal
            };
            add(below, Sought::Agreement, few);
            add(equal, Sought::Agreement, few / 2);
            add(apart, Sought::Difference, few / 2);
        }
    }
    all(&jobs)
}
