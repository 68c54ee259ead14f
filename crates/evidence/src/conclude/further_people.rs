//! Plans of further people, held against the tests by which a verdict is made.
//!
//! # Definition
//! Further people are drawn as [`crate::resampled`] has it. With so many of them the conclusion's own tests are asked ([`super::stand::at_one_look`]): how often, of [`DRAWS`]
//! draws, they show the threshold to be met or missed is the chance. Where it is clearly below the wanted power, the number of people is
//! doubled, up to [`MOST_PEOPLE`]; then there is no plan.
//!
//! # Source
//! A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in clinical trial design" (2005), by draws.
//!
//! # Assumes
//! Further people are of the kinds of those so far. Of a piece that is looked at again each look has [`stats::SHARE_OF_A_LOOK`] of
//! the level.
//!
//! # Guarantee
//! A plan is not made by a test that the verdict does not ask. The chance has the error of [`DRAWS`] draws, at most 8 points, and is the same
//! each time.

use super::stand::doubts;
use crate::compare::{Belief, FurtherSubjects};
use crate::resampled::{
    CLEARLY, DRAWS, MOST_EACH, MOST_PEOPLE, Population, Resampled, growth, shares,
};
use crate::{Measure, Threshold};
use stats::{Confidence, Sample};

/// Levels at which a threshold is shown to be met and to be missed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    pub met: f64,
    pub missed: f64,
}

/// A number of further people with its chances of showing the threshold to be met and to be missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ByPeople {
    pub people: FurtherSubjects,
    pub met: f64,
    pub missed: f64,
}

/// What the verdict's tests make of a planned number of further people; `None` where counts are not known by person, so that they are not
/// asked by person either, and `Some(None)` where no number of them is clearly enough.
pub(super) fn checked(
    measure: &Measure,
    planned: FurtherSubjects,
    (threshold, levels): (Threshold, Shown),
    (level, power): (Confidence, f64),
) -> Option<Option<ByPeople>> {
    let Measure::Counts {
        by_subject: Some(rows),
        ..
    } = measure
    else {
        return None;
    };
    let rows: Vec<Sample> = rows
        .iter()
        .filter_map(|[successes, trials]| Sample::new(*successes, *trials).ok())
        .collect();
    if rows.len() < 2 || planned.each > MOST_EACH {
        return None;
    }
    let population = Population::new(&rows)?;
    // A plan at the effective size may be for more people than these tests need.
    let mut people = FurtherSubjects {
        subjects: planned.subjects.min(MOST_PEOPLE),
        ..planned
    };
    while people.subjects <= MOST_PEOPLE {
        let asked = |people| chances(&population, people, (threshold, levels), level);
        let found = asked(people);
        if found.met + found.missed >= CLEARLY * power {
            let is_cut = people.subjects < planned.subjects;
            return Some(Some(match is_cut {
                true => fewest(found, power, asked),
                false => found,
            }));
        }
        let Some(growth) = growth(people.subjects) else {
            break;
        };
        people.subjects = (people.subjects as f64 * growth).round() as u64;
    }
    Some(None)
}

/// The fewest people, by halving, that have the wanted chance, where so many have it.
fn fewest(enough: ByPeople, power: f64, asked: impl Fn(FurtherSubjects) -> ByPeople) -> ByPeople {
    let mut enough = enough;
    loop {
        let half = FurtherSubjects {
            subjects: enough.people.subjects / 2,
            ..enough.people
        };
        if half.subjects == 0 {
            return enough;
        }
        let found = asked(half);
        if found.met + found.missed < power {
            return enough;
        }
        enough = found;
    }
}

fn chances(
    population: &Population<'_>,
    people: FurtherSubjects,
    (threshold, levels): (Threshold, Shown),
    level: Confidence,
) -> ByPeople {
    let mut drawn = Resampled::default();
    let (mut met, mut missed) = (0_u64, 0_u64);
    for _ in 0..DRAWS {
        let all = drawn.with_further(population, people);
        let belief = Measure::of_clusters(&all, level).ok();
        let belief = belief.and_then(|measure| Belief::of(&measure).ok());
        let Some(belief) = belief else { continue };
        let (not_met, is_met) = doubts(&belief, threshold);
        met += u64::from(not_met <= levels.met);
        missed += u64::from(is_met <= levels.missed);
    }
    let (met, missed) = shares([met, missed]);
    ByPeople {
        people,
        met,
        missed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Direction;

    fn planned(rows: &[[u64; 2]], value: f64, subjects: u64, each: u64) -> Option<ByPeople> {
        let samples = rows.iter().map(|[successes, trials]| Sample {
            successes: *successes,
            trials: *trials,
        });
        let measure = Measure::of_clusters(&samples.collect::<Vec<_>>(), Confidence::P95);
        let threshold = Threshold {
            direction: Direction::AtLeast,
            value,
        };
        let levels = Shown {
            met: 0.025,
            missed: 0.025,
        };
        checked(
            &measure.expect("a measure"),
            FurtherSubjects { subjects, each },
            (threshold, levels),
            (Confidence::P95, 0.8),
        )
        .expect("known by person")
    }

    /// Twenty who nearly always succeed and one who hardly does: no result of one more person decides, whatever the effective size says.
    #[test]
    fn one_more_person_decides_nothing_that_no_result_of_theirs_would() {
        let mut rows = vec![[6, 6]; 18];
        rows.extend([[5, 6], [5, 6], [3, 100]]);
        if let Some(plan) = planned(&rows, 0.85, 1, 10) {
            assert!(plan.people.subjects > 1, "{plan:?}");
        }
    }

    #[test]
    fn people_who_are_alike_are_planned_as_they_were() {
        let plan = planned(&[[9, 10]; 10], 0.8, 20, 10).expect("a plan");
        assert_eq!(plan.people.subjects, 20, "{plan:?}");
        assert!(plan.met > 0.8 && plan.missed < 0.1, "{plan:?}");
        assert_eq!(planned(&[[9, 10]; 10], 0.8, 20, 10), Some(plan));
    }
}
