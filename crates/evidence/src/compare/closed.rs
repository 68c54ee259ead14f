//! Correction for the number of comparisons by closed testing over all the ways in which pieces can agree.
//!
//! # Definition
//! The pieces on one subject under the same conditions are a *group*; `n` groups have two pieces or more. If some of the
//! pieces of a group have the same true rate, the pieces fall into blocks of equal rates: a partition. A hypothesis of
//! the study is a partition for each of some groups. It is rejected at level `a` if, of its `t` groups, one has
//! `p <= a / t`, where the p-value of
//!
//! * a block of two pieces is that of the pair ("no difference");
//! * a block of more, of which one has runs without a verdict, is the least of its pairs' times their number (Bonferroni);
//! * any other block `B` of more is `|B|` times the least p-value of one piece against all others of the block taken together;
//! * a partition is the least of its blocks' of two pieces or more, times their number (Bonferroni).
//!
//! "No difference" of a pair is rejected if every hypothesis is that has the two in one block. Its corrected p-value is
//! the largest of those hypotheses'. With `c` the largest p-value over the group's partitions that join the pair, and
//! `q_1 >= q_2 >= ...` the largest over all partitions of each of the other groups, that is
//!
//! ```text
//! max over t of t * min(c, q_(t-1)),   q_0 = infinity
//! ```
//!
//! Counts of pieces with one rate are added, at their effective size; distributions as the counts of their beta
//! distribution; of known probabilities what lies within the bounds of all.
//!
//! # Source
//! R. Marcus, E. Peritz and K. R. Gabriel, "On closed testing procedures with special reference to ordered analysis of
//! variance", Biometrika 63 (1976); J. P. Shaffer, "Modified sequentially rejective multiple test procedures", Journal of
//! the American Statistical Association 81 (1986), for the hypotheses that can be true together; S. Holm (1979) for the
//! step from group to group. The block's test against one odd piece is this project's: it is what a single faulty asset
//! makes of a study.
//!
//! # Assumes
//! The test of a block holds its level: pieces that are added together are independent of each other, and all pieces of a
//! block have exactly one rate. Nothing of how the tests depend on each other. No pair was left out for its outcome.
//!
//! # Guarantee and cost
//! The probability of rejecting any true "no difference" is at most `a` where the tests of blocks hold their level, as
//! exact tests of independent counts do (however they depend on each other). In percent of seeded studies (`cargo run -p
//! evidence --release --example false_conflicts`; standard error at most 1.5): each requirement has a model's exact value,
//! a simulation of 200 and experiments of 60 and 40, all with one rate, which is the threshold; with faults, the last
//! experiment of every second requirement is 0.3 below. A false conflict is one of pieces with one rate. *Uncorrected* is
//! a model that meets a threshold which a count misses at the level of one requirement divided by its pieces: a verdict
//! must not call that conflicting, since its rate adds up over the requirements.
//!
//! | requirements | faults | studies | false conflict, margin 0.001 | 0.05 | 0.1 | uncorrected | fault found |
//! |---|---|---|---|---|---|---|---|
//! | 1 | no | 2000 | 2.5 | 2.4 | 1.5 | 2.3 | |
//! | 2 | no | 1000 | 2.8 | 2.7 | 2.0 | 4.5 | |
//! | 2 | yes | 1000 | 1.8 | 1.4 | 0.7 | 1.3 | 99.6 |
//! | 5 | no | 400 | 2.5 | 2.3 | 1.8 | 11.0 | |
//! | 5 | yes | 400 | 3.5 | 3.3 | 2.3 | 6.3 | 99.5 |
//! | 10 | no | 200 | 3.0 | 3.0 | 2.5 | 21.5 | |
//! | 10 | yes | 200 | 2.5 | 2.0 | 1.5 | 13.0 | 100 |
//!
//! Partitions grow fast: with more than
//! [`MOST_PIECES`] in some group, Holm's correction is used for the study.

use super::Belief;
use super::pair::Pair;
use super::past::Before;
use crate::Subject;
use stats::{BetaPosterior, EffectiveSample, Interval, Sample};

/// Pieces of a group up to which its partitions are gone through: 203 of them.
pub(super) const MOST_PIECES: usize = 6;

/// A tested pair: its group's name, its two pieces, and the p-value of "no difference".
pub(super) struct Tested<'a> {
    /// Subject and conditions.
    pub group: (&'a Subject, &'a str),
    /// The identifiers.
    pub pieces: [&'a str; 2],
    /// What is known of them, and their test.
    pub pair: &'a Pair,
    /// The pair's p-value.
    pub p: f64,
}

/// The corrected p-values, in the order of the pairs; Holm's where a group has too many pieces.
pub(super) fn corrected(tested: &[Tested<'_>]) -> Vec<f64> {
    let groups = groups(tested);
    if groups.iter().any(|group| group.pieces.len() > MOST_PIECES) {
        let raw: Vec<f64> = tested.iter().map(|pair| pair.p).collect();
        return stats::holm(&raw);
    }
    let within: Vec<Vec<f64>> = groups.iter().map(Group::largest_joining).collect();
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let of_group: Vec<f64> = within.iter().map(|all| largest(all)).collect();
    let mut found = vec![1.0; tested.len()];
    for (place, (group, within)) in groups.iter().zip(&within).enumerate() {
        let mut others = of_group.clone();
        others.remove(place);
        others.sort_by(|a, b| b.total_cmp(a));
        for (pair, own) in group.pairs.iter().zip(within) {
            found[pair.place] = over_groups(*own, &others);
        }
    }
    found
}

/// `max over t of t * min(own, q_(t-1))`, `others` descending.
fn over_groups(own: f64, others: &[f64]) -> f64 {
    let rest = (2..).zip(others).map(|(t, q)| f64::from(t) * own.min(*q));
    rest.fold(own, f64::max).min(1.0)
}

/// A piece of a group: its name, what it shows, and what it showed at each look.
type Member<'a> = (&'a str, &'a Belief, Option<&'a [Option<Belief>]>);

/// All pieces on one subject under the same conditions.
struct Group<'a> {
    name: (&'a Subject, &'a str),
    pieces: Vec<Member<'a>>,
    pairs: Vec<Place>,
    margin: f64,
}

/// A pair of a group.
struct Place {
    /// Its place among the tested.
    place: usize,
    /// Its pieces.
    pieces: [usize; 2],
    p: f64,
}

fn groups<'a>(tested: &[Tested<'a>]) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for (place, one) in tested.iter().enumerate() {
        let found = groups.iter().position(|group| group.name == one.group);
        let index = found.unwrap_or_else(|| {
            groups.push(Group {
                name: one.group,
                pieces: Vec::new(),
                pairs: Vec::new(),
                margin: one.pair.margin(),
            });
            groups.len() - 1
        });
        let group = &mut groups[index];
        let mut place_of = |id: &'a str, belief: &'a Belief, side: usize| {
            let known = group.pieces.iter().position(|(other, ..)| *other == id);
            let place = known.unwrap_or_else(|| {
                group.pieces.push((id, belief, None));
                group.pieces.len() - 1
            });
            // A pair of which neither side can grow does not know what was before.
            if let Some(before) = one.pair.before() {
                group.pieces[place].2 = Some(&before[side]);
            }
            place
        };
        let pieces = [
            place_of(one.pieces[0], one.pair.first(), 0),
            place_of(one.pieces[1], one.pair.second(), 1),
        ];
        group.pairs.push(Place {
            place,
            pieces,
            p: one.p,
        });
    }
    groups
}

impl Group<'_> {
    /// For each pair the largest p-value over the partitions that join it.
    fn largest_joining(&self) -> Vec<f64> {
        let blocks: Vec<f64> = (0..1_u32 << self.pieces.len())
            .map(|block| self.p_of_block(block))
            .collect();
        let mut largest = vec![0.0_f64; self.pairs.len()];
        partitions(self.pieces.len(), &mut |partition| {
            let joined = partition.iter().filter(|block| block.count_ones() > 1);
            let (mut least, mut count) = (f64::INFINITY, 0.0);
            for block in joined {
                least = least.min(blocks[*block as usize]);
                count += 1.0;
            }
            let p = (least * count).min(1.0);
            for (pair, most) in self.pairs.iter().zip(&mut largest) {
                let both = 1 << pair.pieces[0] | 1 << pair.pieces[1];
                if partition.iter().any(|block| block & both == both) {
                    *most = most.max(p);
                }
            }
        });
        largest
    }

    /// What was known before of one piece and of others together; `None` if none of them is looked at again.
    fn before(&self, one: usize, others: &[usize]) -> Option<Before> {
        let all = || others.iter().copied().chain([one]);
        let looks = all().find_map(|place| Some(self.pieces[place].2?.len()))?;
        let at = |place: usize, look: usize| match self.pieces[place].2 {
            Some(before) => before.get(look).cloned().flatten(),
            None => Some(self.pieces[place].1.clone()),
        };
        let of_others = |look: usize| {
            let known: Option<Vec<Belief>> = others.iter().map(|place| at(*place, look)).collect();
            together(known?.iter())
        };
        Some([
            (0..looks).map(|look| at(one, look)).collect(),
            (0..looks).map(of_others).collect(),
        ])
    }

    /// The p-value of "these pieces have one rate"; 1 for fewer than two.
    fn p_of_block(&self, block: u32) -> f64 {
        let of = |block: u32| {
            let places = (0..self.pieces.len()).filter(move |place| block >> place & 1 == 1);
            places.map(|place| self.pieces[place].1)
        };
        match block.count_ones() {
            0 | 1 => 1.0,
            2 => {
                let mut pairs = self.pairs.iter();
                let own = |pair: &&Place| 1 << pair.pieces[0] | 1 << pair.pieces[1] == block;
                pairs.find(own).map_or(1.0, |pair| pair.p)
            }
            // Counts that are known up to runs without a verdict have no sum. If all have one rate, each two have.
            _ if of(block).any(Belief::has_undecided) => {
                let within = |pair: &&Place| pair.pieces.iter().all(|it| block >> it & 1 == 1);
                let pairs: Vec<f64> = self.pairs.iter().filter(within).map(|it| it.p).collect();
                let least = pairs.iter().copied().fold(1.0, f64::min);
                (least * pairs.len() as f64).min(1.0)
            }
            size => {
                let places = (0..self.pieces.len()).filter(|place| block >> place & 1 == 1);
                let against = places.map(|place| {
                    let Some(rest) = together(of(block & !(1 << place))) else {
                        return 0.0;
                    };
                    let one = self.pieces[place].1.clone();
                    let pair = Pair::new(one, rest, self.margin);
                    let is_rest = |other: &usize| *other != place && block >> other & 1 == 1;
                    let others: Vec<usize> = (0..self.pieces.len()).filter(is_rest).collect();
                    match self.before(place, &others) {
                        Some(before) => pair.looked_at(before).p_difference(),
                        None => pair.p_difference(),
                    }
                });
                (f64::from(size) * against.fold(1.0, f64::min)).min(1.0)
            }
        }
    }
}

/// What several pieces with one rate say of it; `None` where known bounds have nothing in common.
fn together<'b>(beliefs: impl Iterator<Item = &'b Belief>) -> Option<Belief> {
    let (mut bounds, mut known) = (
        Interval {
            low: 0.0,
            high: 1.0,
        },
        None,
    );
    let mut sample = Sample {
        successes: 0,
        trials: 0,
    };
    let mut effective = EffectiveSample {
        successes: 0.0,
        trials: 0.0,
    };
    let mut is_distribution = false;
    let mut range = None;
    let mut is_range = true;
    for belief in beliefs {
        match belief {
            Belief::Counts {
                sample: own,
                effective: worth,
                ..
            } => {
                sample.successes += own.successes;
                sample.trials += own.trials;
                effective.successes += worth.successes;
                effective.trials += worth.trials;
            }
            Belief::Known {
                value,
                bounds: own,
                is_range: own_range,
            } => {
                is_range &= *own_range;
                bounds.low = bounds.low.max(own.low);
                bounds.high = bounds.high.min(own.high);
                known = Some(*value);
            }
            // A range is left out beside others: what the others say together holds of the one rate all the same.
            Belief::Range { .. } => range = range.or(Some(belief)),
            Belief::Distribution { posterior, .. } => {
                is_distribution = true;
                let (alpha, beta) = posterior.parameters();
                effective.successes += (alpha - 0.5).max(0.0);
                effective.trials += (alpha - 0.5).max(0.0) + (beta - 0.5).max(0.0);
            }
        }
    }
    match known {
        Some(_) if bounds.low > bounds.high => None,
        Some(value) => Some(Belief::Known {
            value: value.clamp(bounds.low, bounds.high),
            bounds,
            is_range,
        }),
        None if is_distribution => Some(Belief::Distribution {
            value: effective.successes / effective.trials,
            posterior: BetaPosterior::jeffreys(effective),
            quantiles: None,
        }),
        None if sample.trials == 0 => range.cloned(),
        None => Some(Belief::Counts {
            sample,
            effective,
            clusters: None,
            before: None,
            completions: None,
        }),
    }
}

/// All partitions of `count` pieces but the one into single ones, as sets of blocks.
fn partitions(count: usize, found: &mut dyn FnMut(&[u32])) {
    fn next(place: usize, count: usize, blocks: &mut Vec<u32>, found: &mut dyn FnMut(&[u32])) {
        if place == count {
            if blocks.len() < count {
                found(blocks);
            }
            return;
        }
        for index in 0..blocks.len() {
            blocks[index] |= 1 << place;
            next(place + 1, count, blocks, found);
            blocks[index] &= !(1 << place);
        }
        blocks.push(1 << place);
        next(place + 1, count, blocks, found);
        blocks.pop();
    }
    next(0, count, &mut Vec::new(), found);
}

#[cfg(test)]
mod tests {
    use super::super::belief::samples::{counts, known};
    use super::*;

    /// All pairs of each group, with their corrected p-values.
    fn correct(groups: &[(&'static str, Vec<Belief>)]) -> Vec<(f64, f64)> {
        const IDS: [&str; 8] = ["a", "b", "c", "d", "e", "f", "g", "h"];
        let subject = |name: &str| Subject::Requirement(name.to_owned());
        let mut pairs = Vec::new();
        for (name, beliefs) in groups {
            for (i, one) in beliefs.iter().enumerate() {
                for (j, other) in beliefs.iter().enumerate().skip(i + 1) {
                    let pair = Pair::new(one.clone(), other.clone(), 0.05);
                    pairs.push((subject(name), [IDS[i], IDS[j]], pair));
                }
            }
        }
        let tested: Vec<Tested> = pairs
            .iter()
            .map(|(name, pieces, pair)| Tested {
                group: (name, "typical"),
                pieces: *pieces,
                pair,
                p: pair.p_difference(),
            })
            .collect();
        let corrected = corrected(&tested);
        tested.iter().map(|one| one.p).zip(corrected).collect()
    }

    #[test]
    fn there_are_as_many_partitions_as_bells_numbers_less_one() {
        for (count, bell) in [(2, 2), (3, 5), (4, 15), (5, 52), (6, 203)] {
            let mut all = 0;
            partitions(count, &mut |_| all += 1);
            assert_eq!(all, bell - 1, "{count}");
        }
    }

    /// With one pair a group it is Holm's correction.
    #[test]
    fn single_pairs_are_corrected_by_holm() {
        let groups = [
            ("1", vec![counts(80, 100), counts(95, 100)]),
            ("2", vec![counts(50, 100), counts(60, 100)]),
            ("3", vec![counts(10, 100), counts(22, 100)]),
        ];
        let found = correct(&groups);
        let raw: Vec<f64> = found.iter().map(|(p, _)| *p).collect();
        for ((_, corrected), holm) in found.iter().zip(stats::holm(&raw)) {
            assert!((corrected - holm).abs() < 1e-12, "{corrected} {holm}");
        }
    }

    /// By hand, for three pieces: the pair's own, and three times the least of one against the other two.
    #[test]
    fn three_pieces_by_hand() {
        let found = correct(&[("1", vec![counts(10, 200), counts(12, 200), counts(40, 200)])]);
        let against = |one: (u64, u64), rest: (u64, u64)| {
            stats::boschloo_exact(
                Sample::new(one.0, one.1).unwrap(),
                Sample::new(rest.0, rest.1).unwrap(),
            )
        };
        let all = against((40, 200), (22, 400))
            .min(against((10, 200), (52, 400)))
            .min(against((12, 200), (50, 400)));
        let wanted = |p: f64| p.max(3.0 * all).min(1.0);
        for (p, corrected) in &found {
            assert!((corrected - wanted(*p)).abs() < 1e-12, "{p} {corrected}");
        }
        // The odd one out differs from both, and the two others do not.
        assert!(found[1].1 < 0.001 && found[2].1 < 0.001 && found[0].1 > 0.5);
    }

    #[test]
    fn known_probabilities_that_exclude_each_other_are_apart_whatever_else_there_is() {
        let found = correct(&[("1", vec![known(0.9), known(0.8), counts(85, 100)])]);
        assert_eq!(found[0], (0.0, 0.0));
        assert!(found[1].1 > 0.05 && found[2].1 > 0.05, "{found:?}");
    }

    #[test]
    fn corrected_is_never_below_raw() {
        let rates = [30, 34, 38, 45, 52, 70];
        for a in rates {
            for b in rates {
                let beliefs = vec![counts(a, 200), counts(b, 300), known(0.2)];
                let found = correct(&[
                    ("1", beliefs),
                    ("2", vec![counts(a, 100), counts(20, 100), counts(b, 120)]),
                ]);
                assert!(found.iter().all(|(p, corrected)| corrected >= p));
            }
        }
    }

    #[test]
    fn many_pieces_are_corrected_by_holm() {
        let many: Vec<Belief> = (0..7).map(|i| counts(10 + 6 * i, 100)).collect();
        let found = correct(&[("1", many)]);
        let raw: Vec<f64> = found.iter().map(|(p, _)| *p).collect();
        let wanted = stats::holm(&raw);
        assert!(found.iter().zip(wanted).all(|((_, c), holm)| *c == holm));
    }
}
