//! A pair that is looked at again: its tests over all looks.
//!
//! # Definition
//! At each look the pair has the p-values that it would have if that were the only look. Of "no difference" a one-sided
//! one for each direction (half the two-sided p-value where the estimate lies in that direction, and one minus that
//! where it does not), of which twice the smaller counts; of equivalence the larger of its two. Its information is
//! `1 / (1/n1 + 1/n2)` at the effective sizes, those of earlier looks at the design effect of today; a known rate has
//! infinite size. What they amount to over all looks is `stats::continuation`'s p-value from scores. Equivalence of
//! independent counts with a known rate is asked of the counts against the two ends of the margin, exactly
//! (`stats::continued_above` and `continued_below`), and of all counts by subject ([`super::by_likelihood`]).
//!
//! # Assumes
//! Looks are recorded with the counts of both sides, none left out for what it showed. What is computed was the same at all
//! looks, and design effects were those of today. Scores have independent normal increments; where independent counts are
//! held against a known rate, it is enough that trials are independent.
//!
//! # Guarantee
//! At the first look the level is kept exactly as the tests keep it, and equivalence with a known rate at every look.
//! All else holds as far as scores have independent normal increments; `ERROR_RATES.md` has the measured rates.

use super::Belief;
use super::ends::End;
use super::pair::{Pair, to_agree_with, without_rounding};
use stats::{Sample, ScoredLook, continued_above, continued_below, continued_p, continued_rejects};
use std::rc::Rc;

/// What was known of both sides at each look before this one, oldest first; `None` where it is not of the same trials.
pub(super) type Before = [Vec<Option<Belief>>; 2];

/// A look before this one.
#[derive(Clone, Debug)]
struct PastLook {
    /// The p-value of "no difference", by Fisher's test too, and the sign of the difference.
    difference: (f64, f64, f64),
    equivalence: f64,
    sides: [Belief; 2],
}

/// Which p-value is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    Difference,
    DifferenceByFisher,
    Equivalence,
}

/// All looks before this one.
#[derive(Clone, Debug, Default)]
pub(super) struct Past {
    looks: Rc<Vec<PastLook>>,
}

impl Past {
    pub fn new(before: &Before, margin: f64) -> Self {
        let both = before[0].iter().zip(&before[1]);
        let known = both.filter_map(|(a, b)| Some((a.clone()?, b.clone()?)));
        let looks = known.map(|(first, second)| PastLook::of(&Pair::new(first, second, margin)));
        Self {
            looks: Rc::new(looks.collect()),
        }
    }

    /// The same and a pair that was looked at since.
    pub fn and(&self, pair: &Pair) -> Self {
        let mut looks = self.looks.to_vec();
        looks.push(PastLook::of(pair));
        Self {
            looks: Rc::new(looks),
        }
    }

    /// The number of the present look.
    pub fn number(&self, pair: &Pair) -> u64 {
        let all = self.scored(pair, Asked::Equivalence, 1.0, 1.0);
        let mut number = 0;
        let mut information = 0.0;
        for look in all {
            if look.information > information * (1.0 + 1e-9) {
                number += 1;
                information = look.information;
            }
        }
        number.max(1)
    }

    /// The p-value over all looks, given that of the present one.
    pub fn p(&self, pair: &Pair, asked: Asked, once: f64) -> f64 {
        if once <= 0.0 || size_of(pair.first()).is_none() && size_of(pair.second()).is_none() {
            return once;
        }
        if asked == Asked::Equivalence {
            let exact = self.equivalence_with_known(pair);
            return exact.unwrap_or_else(|| continued_p(&self.scored(pair, asked, 1.0, once)));
        }
        let side = |sign: f64| continued_p(&self.scored(pair, asked, sign, once));
        (2.0 * side(1.0).min(side(-1.0))).min(1.0)
    }

    /// Whether it is shown at this level, over all looks.
    pub fn shows(&self, pair: &Pair, asked: Asked, once: f64, level: f64) -> bool {
        if once <= 0.0 || size_of(pair.first()).is_none() && size_of(pair.second()).is_none() {
            return once <= level;
        }
        if asked == Asked::Equivalence {
            if let Some(p) = self.equivalence_with_known(pair) {
                return p <= level;
            }
            return continued_rejects(&self.scored(pair, asked, 1.0, once), level);
        }
        let side =
            |sign: f64| continued_rejects(&self.scored(pair, asked, sign, once), 0.5 * level);
        side(1.0) || side(-1.0)
    }

    /// The exact p-value of equivalence over all looks, where one side is known and the other counts independent trials.
    fn equivalence_with_known(&self, pair: &Pair) -> Option<f64> {
        let (counted, known) = match (pair.first(), pair.second()) {
            (Belief::Counts { .. }, known @ Belief::Known { .. }) => (0, known),
            (known @ Belief::Known { .. }, Belief::Counts { .. }) => (1, known),
            _ => return None,
        };
        let now = [pair.first().clone(), pair.second().clone()];
        let all = self.looks.iter().map(|look| &look.sides).chain([&now]);
        let mut samples: Vec<Sample> = Vec::with_capacity(self.looks.len() + 1);
        for sides in all {
            let sample = independent(&sides[counted])?;
            if samples.last() != Some(&sample) {
                samples.push(sample);
            }
        }
        let bounds = to_agree_with(known);
        let ends = [bounds.high - pair.margin(), bounds.low + pair.margin()];
        let [floor, ceiling] = ends.map(without_rounding);
        let not_below = match floor < 0.0 {
            true => 0.0,
            false => continued_above(&samples, floor),
        };
        let not_above = match ceiling > 1.0 {
            true => 0.0,
            false => continued_below(&samples, ceiling),
        };
        let by_likelihood = pair.equivalence_by_likelihood();
        Some(not_below.max(not_above).max(by_likelihood))
    }

    /// The looks with their p-values in one direction.
    fn scored(&self, pair: &Pair, asked: Asked, sign: f64, once: f64) -> Vec<ScoredLook> {
        let now = [pair.first(), pair.second()];
        let directed = |p: f64, difference: f64| match difference * sign > 0.0 {
            true => 0.5 * p,
            false => 1.0 - 0.5 * p,
        };
        let mut looks: Vec<ScoredLook> = Vec::with_capacity(self.looks.len() + 1);
        for look in self.looks.iter() {
            let (exact, fisher, difference) = look.difference;
            let p = match asked {
                Asked::Difference => directed(exact, difference),
                Asked::DifferenceByFisher => directed(fisher, difference),
                Asked::Equivalence => look.equivalence,
            };
            let [first, second] = &look.sides;
            looks.push(ScoredLook {
                p,
                information: information([size_at(first, now[0]), size_at(second, now[1])]),
            });
        }
        let p = match asked {
            Asked::Equivalence => once,
            _ => directed(once, pair.difference()),
        };
        looks.push(ScoredLook {
            p,
            information: information(now.map(|side| size_of(side).unwrap_or(f64::INFINITY))),
        });
        looks
    }
}

impl PastLook {
    fn of(pair: &Pair) -> Self {
        let exact = pair.p_difference_once();
        Self {
            difference: (
                exact,
                pair.p_by_fisher_once().unwrap_or(exact),
                pair.difference(),
            ),
            equivalence: pair.doubt_of_equivalence_once(),
            sides: [pair.first().clone(), pair.second().clone()],
        }
    }
}

/// Independent trials; `None` for a known rate.
fn size_of(belief: &Belief) -> Option<f64> {
    match belief {
        Belief::Counts { effective, .. } => Some(effective.trials),
        Belief::Known { .. } => None,
        Belief::Distribution { posterior, .. } => {
            let (a, b) = posterior.parameters();
            Some(a + b)
        }
        Belief::Range { ends, .. } => {
            let sizes = [&ends.least, &ends.greatest]
                .into_iter()
                .filter_map(|end| match end {
                    End::Known(_) => None,
                    End::Uncertain(uncertain) => {
                        let (a, b) = uncertain.shape.parameters();
                        Some(a + b)
                    }
                });
            sizes.reduce(f64::min)
        }
    }
}

/// Counts whose trials are all independent.
fn independent(belief: &Belief) -> Option<Sample> {
    match belief {
        Belief::Counts {
            sample, effective, ..
        } if effective.trials >= sample.trials as f64 => Some(*sample),
        _ => None,
    }
}

/// The size of an earlier count at the design effect of today, so that more trials are never less information.
fn size_at(then: &Belief, now: &Belief) -> f64 {
    match (then, now) {
        (
            Belief::Counts { sample: then, .. },
            Belief::Counts {
                sample, effective, ..
            },
        ) => then.trials as f64 * effective.trials / sample.trials as f64,
        _ => size_of(now).unwrap_or(f64::INFINITY),
    }
}

fn information([first, second]: [f64; 2]) -> f64 {
    1.0 / (1.0 / first + 1.0 / second)
}

#[cfg(test)]
mod tests {
    use super::super::belief::samples::counts;
    use super::*;
    use stats::Confidence;

    fn at(looks: &[[(u64, u64); 2]], margin: f64) -> Pair {
        let (now, before) = looks.split_last().expect("a look");
        let side = |place: usize| -> Vec<Option<Belief>> {
            let of = |look: &[(u64, u64); 2]| Some(counts(look[place].0, look[place].1));
            before.iter().map(of).collect()
        };
        let pair = Pair::new(
            counts(now[0].0, now[0].1),
            counts(now[1].0, now[1].1),
            margin,
        );
        pair.looked_at([side(0), side(1)])
    }

    #[test]
    fn the_first_look_costs_a_fifth() {
        let pair = at(&[[(80, 100), (460, 500)]], 0.1);
        let once = pair.p_difference_once();
        assert!((pair.p_difference() / (once / 0.8) - 1.0).abs() < 1e-6);
        let (continued, once) = (pair.p_equivalence(), pair.doubt_of_equivalence_once());
        assert!((continued.expect("a p-value") - (once / 0.8).min(1.0)).abs() < 1e-6);
        assert_eq!(pair.look(), Some(1));
    }

    #[test]
    fn looks_before_cost_more_and_empty_ones_nothing() {
        let single = at(&[[(180, 200), (460, 500)]], 0.08);
        let again = at(&[[(90, 100), (460, 500)], [(180, 200), (460, 500)]], 0.08);
        assert!(again.p_equivalence() > single.p_equivalence());
        assert_eq!(again.look(), Some(2));
        let twice = at(&[[(180, 200), (460, 500)], [(180, 200), (460, 500)]], 0.08);
        assert_eq!(twice.p_equivalence(), single.p_equivalence());
        assert_eq!((twice.look(), single.look()), (Some(1), Some(1)));
    }

    /// Equivalence with a known rate is that of the counts against both ends of the margin, and costs a fifth at first.
    #[test]
    fn equivalence_with_a_known_rate_is_exact_at_every_look() {
        let known = Belief::Known {
            value: 0.85,
            bounds: stats::Interval {
                low: 0.85,
                high: 0.85,
            },
            is_range: false,
        };
        let of = |looks: &[(u64, u64)]| {
            let (now, before) = looks.split_last().expect("a look");
            let before: Vec<_> = before.iter().map(|(x, n)| Some(counts(*x, *n))).collect();
            let same = vec![Some(known.clone()); before.len()];
            Pair::new(counts(now.0, now.1), known.clone(), 0.1).looked_at([before, same])
        };
        let first = of(&[(52, 60)]);
        let once = first.doubt_of_equivalence_once();
        assert!((first.p_equivalence().expect("a p-value") - (once / 0.8).min(1.0)).abs() < 1e-6);
        let looks = [(52, 60), (104, 120), (205, 240)];
        let samples = looks.map(|(successes, trials)| Sample { successes, trials });
        let expected = continued_above(&samples, 0.75).max(continued_below(&samples, 0.85 + 0.1));
        let third = of(&looks);
        let found = third.p_equivalence().expect("a p-value");
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        for level in [0.9, 0.99, 0.9999] {
            let level = Confidence::new(level).expect("a level");
            assert_eq!(third.shows_agreement(level), found <= level.alpha());
        }
    }

    /// What a plan asks of an outcome is what the comparison will say of it.
    #[test]
    fn what_a_plan_asks_is_what_will_be_said() {
        let now = at(&[[(80, 100), (44, 50)]], 0.15);
        for (a, b) in [(160, 88), (180, 88), (140, 96), (170, 85), (196, 60)] {
            let planned = now.with(counts(a, 200), counts(b, 100));
            let then = at(&[[(80, 100), (44, 50)], [(a, 200), (b, 100)]], 0.15);
            assert_eq!(planned.p_difference(), then.p_difference());
            for level in [0.9, 0.95, 0.99] {
                let level = Confidence::new(level).expect("a level");
                assert_eq!(
                    planned.differs(level),
                    then.p_difference() <= level.alpha(),
                    "{a} {b} {level:?}"
                );
                assert_eq!(
                    planned.shows_agreement(level),
                    then.p_equivalence() <= Some(level.alpha()) && then.is_inside_margin()
                );
            }
        }
    }
}
