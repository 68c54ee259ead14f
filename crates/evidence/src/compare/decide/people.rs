//! Plans of further people, held against the tests by which a pair is compared.
//!
//! # Definition
//! A plan counts people at their effective size of today; a comparison asks for the likelihood of their counts, too, and finds their
//! effective size again. So of a plan in which a side's trials are made by further people, [`DRAWS`] outcomes are drawn (people as
//! [`crate::resampled`] has it, independent trials by their predictive distribution), and the share of them of which the pair's tests
//! show something is its chance. Where that is clearly below the wanted power the number of trials is doubled, up to [`MOST_PEOPLE`] people;
//! then there is no plan. People with more than [`MOST_EACH`] trials each are not drawn.
//!
//! # Source
//! A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in clinical trial design" (2005), by draws.
//!
//! # Deviation
//! Draws end early where those so far tell that the chance is clearly too small. Agreement of two counts is tested as plans do.
//!
//! # Assumes
//! Further people are of the kinds of those so far, and have as many trials as those had on average.
//!
//! # Guarantee
//! The chance has the error of [`DRAWS`] draws, at most 8 points, and is the same each time.

use super::side::Side;
use super::{MOST_TRIALS, Plan, Planning};
use crate::compare::Belief;
use crate::resampled::{
    CLEARLY, DRAWS, MOST_EACH, MOST_PEOPLE, Population, Resampled, growth, shares,
};
use crate::{FurtherSubjects, Measure};
use stats::{Confidence, Sample};

/// After so many draws without a decision there will not be enough of them.
const ENOUGH_WITHOUT: u64 = DRAWS / 4;

impl Planning<'_> {
    /// The plan with the chances that the comparison's own tests give it, a larger one, or none; the same plan where no trials of
    /// it are made by people of whom each one's counts are known.
    pub(super) fn kept_by_people(&self, plan: Plan, costs: (f64, f64)) -> Option<Plan> {
        let sides = [self.pair.first(), self.pair.second()];
        let rows = |place: usize, trials: u64| match trials {
            0 => None,
            _ => rows(sides[place]),
        };
        let by_people = [rows(0, plan.trials.0), rows(1, plan.trials.1)];
        if by_people.iter().all(Option::is_none) {
            return Some(plan);
        }
        let populations = by_people.map(|rows| rows.and_then(Population::new));
        let mut trials = [plan.trials.0, plan.trials.1];
        // A plan at the effective size may be for more people than the comparison's tests need.
        let planned = by_people.iter().zip(trials);
        let planned = planned.filter_map(|(rows, trials)| Some(people((*rows)?, trials).subjects));
        let most = planned.max().unwrap_or(0);
        if most > MOST_PEOPLE {
            let part = MOST_PEOPLE as f64 / most as f64;
            trials = trials.map(|it| (it as f64 * part).floor() as u64);
        }
        loop {
            let mut further = Vec::with_capacity(2);
            let mut most = 0;
            for (place, rows) in by_people.iter().enumerate() {
                let people = rows.map(|rows| people(rows, trials[place]));
                if people.is_some_and(|it| it.each > MOST_EACH) {
                    return Some(plan);
                }
                most = most.max(people.map_or(0, |it| it.subjects));
                // Whole people make whole multiples of their trials.
                trials[place] = people.map_or(trials[place], FurtherSubjects::trials);
                further.push(match (&populations[place], people) {
                    (Some(population), Some(people)) => Further::People(population, people),
                    _ => Further::of_trials(sides[place], trials[place]),
                });
            }
            if most > MOST_PEOPLE || trials.iter().any(|it| *it as f64 > MOST_TRIALS) {
                return None;
            }
            if let Some(chances) = self.chances_by_draws(&sides, &further) {
                return Some(Plan::of((trials[0], trials[1]), costs, chances));
            }
            let growth = growth(most)?;
            trials = trials.map(|it| (it as f64 * growth).floor() as u64);
        }
    }

    /// The shares of draws that show agreement and a conflict; `None` where they are clearly too small together.
    fn chances_by_draws(
        &self,
        sides: &[&Belief; 2],
        further: &[Further<'_>],
    ) -> Option<(f64, f64)> {
        let chances = self.shares_of_draws((sides, further), Resampled::default())?;
        (chances.0 + chances.1 >= CLEARLY * self.power).then_some(chances)
    }

    /// The shares of draws that show agreement and a conflict; `None` where none of the first does.
    fn shares_of_draws(
        &self,
        (sides, further): (&[&Belief; 2], &[Further<'_>]),
        mut drawn: Resampled,
    ) -> Option<(f64, f64)> {
        let (mut agreement, mut conflict) = (0_u64, 0_u64);
        for draw in 0..DRAWS {
            if draw >= ENOUGH_WITHOUT && agreement + conflict == 0 {
                return None;
            }
            let mut after = Vec::with_capacity(2);
            for (belief, further) in sides.iter().zip(further) {
                after.push(further.drawn(belief, &mut drawn, self.confidence)?);
            }
            let [first, second] = after.try_into().ok()?;
            let pair = self.pair.with(first, second);
            if pair.would_show_agreement(self.agreement) {
                agreement += 1;
            } else if !pair.is_inside_margin() && pair.differs(self.conflict) {
                conflict += 1;
            }
        }
        Some(shares([agreement, conflict]))
    }
}

/// What a plan adds to a side.
enum Further<'a> {
    /// People of this population.
    People(&'a Population<'a>, FurtherSubjects),
    /// Independent trials, or nothing, with the successes they may bring and the weight of each.
    Trials(Side<'a>, Vec<(u64, f64)>),
}

impl<'a> Further<'a> {
    fn of_trials(belief: &'a Belief, trials: u64) -> Self {
        let side = Side::new(belief, trials);
        let outcomes = side.representatives();
        Self::Trials(side, outcomes)
    }

    /// What is known of the side with what is drawn for it.
    fn drawn(&self, now: &Belief, by: &mut Resampled, level: Confidence) -> Option<Belief> {
        match self {
            Self::Trials(side, outcomes) => Some(side.after(by.weighted(outcomes))),
            Self::People(population, people) => {
                let all = by.with_further(population, *people);
                let belief = Belief::of(&Measure::of_clusters(&all, level).ok()?).ok()?;
                Some(belief.after_looks_of(now))
            }
        }
    }
}

/// The counts of each of several people with several trials each.
fn rows(belief: &Belief) -> Option<&[Sample]> {
    let Belief::Counts {
        clusters: Some(clusters),
        ..
    } = belief
    else {
        return None;
    };
    clusters.subjects().and_then(|_| clusters.found())
}

/// So many further people with as many trials each as these had on average make at least so many trials.
fn people(rows: &[Sample], trials: u64) -> FurtherSubjects {
    let with_trials: Vec<u64> = rows
        .iter()
        .map(|it| it.trials)
        .filter(|it| *it > 0)
        .collect();
    let sum: u64 = with_trials.iter().sum();
    let each = (sum as f64 / with_trials.len().max(1) as f64)
        .round()
        .max(1.0) as u64;
    FurtherSubjects {
        subjects: trials.div_ceil(each),
        each,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::belief::samples::{counts, known};
    use crate::compare::{Levels, pair::Pair};

    /// Of about 34 attempts each, which twelve people succeed in about as often.
    const TWELVE: [u64; 12] = [22, 21, 20, 23, 24, 27, 24, 22, 21, 17, 20, 28];

    fn twelve() -> Belief {
        let rows = TWELVE.map(|successes| Sample {
            successes,
            trials: 34,
        });
        let measure = Measure::of_clusters(&rows, Confidence::P95).expect("counts");
        Belief::of(&measure).expect("a belief")
    }

    fn levels() -> Levels {
        Levels::new(0.95, 0.95).expect("levels")
    }

    /// What a plan promises is what other draws keep; one person more decides nothing that the likelihood does not see.
    #[test]
    fn a_plan_of_people_promises_what_the_comparison_keeps() {
        let mut kept = 0;
        for (other, margin) in [
            (known(0.757), 0.1),
            (known(0.66), 0.1),
            (known(0.70), 0.08),
            (counts(240, 400), 0.1),
        ] {
            let pair = Pair::new(twelve(), other.clone(), margin);
            let level = levels().confidence.simultaneous(12);
            let levels = levels();
            let planning = Planning::new(&pair, &levels, level).with_open_sides((true, false));
            let Some(plan) = planning.plans((1.0, 1.0)).first else {
                continue;
            };
            assert_eq!(plan.trials.0 % 34, 0, "{plan:?}");
            let first = twelve();
            let rows = rows(&first).expect("people");
            let population = Population::new(rows).expect("several");
            let further = [
                Further::People(&population, people(rows, plan.trials.0)),
                Further::of_trials(&other, 0),
            ];
            let sides = [&first, &other];
            let again = planning.shares_of_draws((&sides, &further), Resampled::seeded(0xfeed));
            let (agreement, conflict) = again.expect("decided");
            assert!((agreement + conflict - plan.chance).abs() < 0.3, "{plan:?}");
            assert!(agreement + conflict > 0.5, "{plan:?} {again:?}");
            kept += 1;
        }
        assert!(kept >= 3, "{kept}");
    }

    /// Independent trials and totals are planned as they were.
    #[test]
    fn what_is_not_known_by_person_is_planned_at_its_effective_size() {
        let pair = Pair::new(counts(60, 100), known(0.62), 0.1);
        let level = levels().confidence;
        let levels = levels();
        let planning = Planning::new(&pair, &levels, level);
        let plan = planning.plans((1.0, 1.0)).first.expect("a plan");
        assert_eq!(planning.kept_by_people(plan, (1.0, 1.0)), Some(plan));
    }
}
