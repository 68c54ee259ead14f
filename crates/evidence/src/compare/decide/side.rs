//! One side of a planned comparison: what its further trials may bring, and which of that leaves the
//! pair undecided.

use super::{Kind, REPRESENTATIVES};
use crate::compare::Belief;
use stats::{BetaPosterior, EffectiveSample, Predictive, Sample};

/// One side with its further trials.
pub(super) struct Side<'a> {
    belief: &'a Belief,
    further: u64,
    /// Further trials in independent ones.
    pub worth: u64,
    /// The distribution of further successes, in independent trials.
    pub next: Predictive,
}

impl<'a> Side<'a> {
    pub fn new(belief: &'a Belief, further: u64) -> Self {
        let worth = belief
            .design_effect()
            .map_or(0, |effect| (further as f64 / effect).round() as u64);
        let next = match belief {
            Belief::Counts { effective, .. } => {
                Predictive::new(&BetaPosterior::jeffreys(*effective), worth)
            }
            _ => Predictive::at_rate(0.0, 0),
        };
        Self {
            belief,
            further,
            worth,
            next,
        }
    }

    pub fn representatives(&self) -> Vec<(u64, f64)> {
        self.next.representatives(REPRESENTATIVES)
    }

    /// The belief once `y` of the further trials have succeeded.
    pub fn after(&self, y: u64) -> Belief {
        let (
            Belief::Counts {
                sample,
                effective,
                before,
                ..
            },
            true,
        ) = (self.belief, self.worth > 0)
        else {
            return self.belief.clone();
        };
        let more = EffectiveSample {
            successes: (effective.successes + y as f64).min(effective.trials + self.worth as f64),
            trials: effective.trials + self.worth as f64,
        };
        let trials = sample.trials.saturating_add(self.further);
        let successes = if effective.trials >= sample.trials as f64 {
            sample.successes + y
        } else {
            (more.successes / more.trials * trials as f64).round() as u64
        };
        Belief::Counts {
            sample: Sample {
                successes: successes.min(trials),
                trials,
            },
            effective: more,
            clusters: None,
            before: before.clone(),
            completions: None,
        }
    }

    /// The probability of outcomes that show agreement, and of those that show a conflict, when the other side stands
    /// at `rate`.
    ///
    /// On either side of equality, outcomes near to it show agreement, those far from it a
    /// difference, and what lies between neither.
    pub fn shown(
        &self,
        rate: f64,
        guess: &mut [u64; 4],
        test: impl Fn(u64, Kind) -> bool,
    ) -> (f64, f64) {
        let Belief::Counts { effective, .. } = self.belief else {
            let agrees = test(0, Kind::Agreement);
            let differs = !agrees && test(0, Kind::Conflict);
            return (f64::from(u8::from(agrees)), f64::from(u8::from(differs)));
        };
        let total = effective.trials + self.worth as f64;
        let equal = (rate * total - effective.successes)
            .round()
            .clamp(0.0, self.worth as f64) as u64;
        let (mut agreement, mut conflict) = (0.0, 0.0);
        let mass = |one: u64, other: u64| self.next.probability(one.min(other), one.max(other));
        for (side, most) in [(0, equal), (1, self.worth - equal)] {
            let at = |distance: u64| {
                if side == 0 {
                    equal - distance
                } else {
                    equal + distance
                }
            };
            let agree = leading(most, guess[2 * side], |d| test(at(d), Kind::Agreement));
            let same = leading(most, guess[2 * side + 1], |d| !test(at(d), Kind::Conflict));
            (guess[2 * side], guess[2 * side + 1]) = (agree, same);
            // Equality itself belongs to the upper side.
            let first = if side == 0 { 1 } else { 0 };
            if first < agree {
                agreement += mass(at(first), at(agree - 1));
            }
            // Agreement comes before a difference.
            let from = same.max(agree).max(first);
            if from <= most {
                conflict += mass(at(from), at(most));
            }
        }
        (agreement, conflict)
    }
}

/// How many of `0..=most` come before the first for which `holds` does not, when it holds for none
/// after that; by galloping from a guess.
fn leading(most: u64, guess: u64, holds: impl Fn(u64) -> bool) -> u64 {
    // Invariant: everything below `low` holds; `high` does not or is beyond the end.
    let (mut low, mut high) = (0, most + 1);
    let mut probe = guess.min(most);
    let mut step = 1;
    loop {
        if holds(probe) {
            low = probe + 1;
            if low >= high || probe == most {
                return low;
            }
            probe = (probe + step).min(high - 1);
        } else {
            high = probe;
            if low >= high {
                return low;
            }
            probe = probe.saturating_sub(step).max(low);
        }
        step *= 2;
        if low > 0 && high <= most {
            break;
        }
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            low = middle + 1
        } else {
            high = middle
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn galloping_finds_the_same_from_any_guess() {
        for most in [0_u64, 1, 2, 10, 1000] {
            for answer in [0, 1, 2, 5, 10, 11, 500, 1000, 1001] {
                for guess in [0, 1, 3, 9, 400, 5000] {
                    let expected = answer.min(most + 1);
                    assert_eq!(
                        leading(most, guess, |d| d < answer),
                        expected,
                        "{most} {answer} {guess}"
                    );
                }
            }
        }
    }
}
