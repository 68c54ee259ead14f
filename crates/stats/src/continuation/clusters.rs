//! Looks at clustered counts: people are added, each with trials that are alike.
//!
//! # Definition
//! The people added between two looks are a stage of their own. If the mean of people's rates is the threshold, and their
//! rates have a beta distribution of intraclass correlation `rho`, the successes of these people are a sum `X` of
//! beta-binomial numbers, and an outcome `x` stands for the p-values between `P(X > x)` and `P(X >= x)`, as in
//! [`continued_above`](super::continued_above). `rho` is the most likely one of all people seen so far if the mean is the
//! threshold. Judged so are
//! * the first stage, if of at most [`FEW_CLUSTERS`] people and there are others, and
//! * stages of at most [`MOST_CLUSTERS`] new people; against a claim towards the end (that a rate is above a threshold above one half)
//!   only after more than [`FEW_CLUSTERS`] people.
//!
//! All other stages have the p-value of the difference of two scores ([`continued_p`](super::continued_p)): those of more
//! people, whose sum is near to normal, and those in which people who were there have made further trials. The score of a first stage that is judged by its distribution is that of the middle of its p-values.
//! The only look has its own p-value, whatever test that is of, and no p-value is below that of the last look.
//!
//! # Why
//! One person more is far from a normal increment: where 9 of 10 succeed and attempts of one person are alike (0.3), a person
//! who fails ten times comes along once in 480 and is five standard deviations away. After few people the likelihood of all of them, on
//! which scores rest, tells more of a claim towards the end than the distribution at the `rho` that is most likely if the claim is false:
//! people who hardly ever fail would have to differ much to have the mean of the threshold. By scores in every stage, or with a first stage
//! of ten people by its distribution, a wrong claim came out in 8.5 to 10.5 % of 200 studies with 25 looks instead of 5.
//! Two people who never fail have no p-value but a range of them: taken for its upper end they would leave next to nothing
//! to those who come later.
//!
//! # Source
//! J. G. Skellam (1948) and D. A. Williams (1975) for the model, `crate::beta_binomial`; stages are those of
//! [`continuation`](super).
//!
//! # Assumes
//! People are added from one population, independently of each other, and their rates have a beta distribution with one
//! correlation. How many are added may depend on what was seen of others. Whom a stage added is found by counts alone.
//! Other laws of people are measured in `evidence/ERROR_RATES.md`.
//!
//! # Guarantee
//! Exact for stages that are judged by their distribution if `rho` is theirs; it is estimated. Measured rates are in `evidence/ERROR_RATES.md`.

use super::{Growing, ScoredLook, Stage, p_of_stages, scored_stage};
use crate::beta_binomial::Model;
use crate::counts::Sample;
use std::collections::BTreeMap;

/// Stages of more people are judged by scores.
pub const MOST_CLUSTERS: usize = 40;

/// A first stage of more people has the p-value of its look, and after so few the next is judged by scores against a claim towards
/// the end.
pub const FEW_CLUSTERS: usize = 9;

/// So are stages of more trials, whose exact sums cost time.
pub const MOST_TRIALS: u64 = 4000;

/// A look at counts of clusters, all so far.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusteredLook<'a> {
    /// The counts of each cluster; `None` where they are not known.
    pub clusters: Option<&'a [Sample]>,
    /// The p-value of all trials if this was the only look, and their information.
    pub scored: ScoredLook,
}

/// What is held against the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// The rate is at most the threshold: successes speak against it.
    Above,
    /// The rate is at least the threshold: failures do.
    Below,
}

impl Side {
    /// Whether what speaks against the hypothesis is rare if it is true.
    fn is_towards_the_middle(self, threshold: f64) -> bool {
        match self {
            Side::Above => threshold < 0.5,
            Side::Below => threshold > 0.5,
        }
    }
}

/// The p-value under continuation of "the mean rate is at most the threshold", oldest look first.
#[must_use]
pub fn continued_clusters_above(looks: &[ClusteredLook<'_>], threshold: f64) -> f64 {
    continued(looks, threshold, Side::Above)
}

/// The same of "the mean rate is at least the threshold".
#[must_use]
pub fn continued_clusters_below(looks: &[ClusteredLook<'_>], threshold: f64) -> f64 {
    continued(looks, threshold, Side::Below)
}

fn continued(looks: &[ClusteredLook<'_>], threshold: f64, side: Side) -> f64 {
    let correlation = looks
        .last()
        .and_then(|look| look.clusters)
        .filter(|_| threshold > 0.0 && threshold < 1.0)
        .map(|clusters| Model::new(clusters).most_likely_correlation(threshold));
    let looks = informative(looks);
    let Some((first, later)) = looks.split_first() else {
        return 1.0;
    };
    let once = looks.last().map_or(1.0, |now| now.scored.p);
    let by_distribution = |before: Option<&ClusteredLook<'_>>, look: &ClusteredLook<'_>| {
        let added = added(before, look)?;
        Some(outcome(&added, threshold, correlation?, side))
    };
    let is_few = !later.is_empty() && people(first) <= FEW_CLUSTERS;
    let exact = is_few.then(|| by_distribution(None, first)).flatten();
    let (mut stages, mut growing, mut before) = first_stage(first.scored, exact);
    let mut last = *first;
    for look in later {
        let Some(mut stage) = scored_stage(Some(before), look.scored) else {
            continue;
        };
        stage.growth = growing.by(look.scored.information - before.information);
        if (side.is_towards_the_middle(threshold) || people(last) > FEW_CLUSTERS)
            && let Some(exact) = by_distribution(Some(last), look)
        {
            stage.outcome = exact.p_values;
        }
        stages.push(stage);
        (last, before) = (look, look.scored);
    }
    p_of_stages(&stages).max(once)
}

/// How many people a look has; many where that is not known.
fn people(look: &ClusteredLook<'_>) -> usize {
    let with_trials = |clusters: &[Sample]| clusters.iter().filter(|it| it.trials > 0).count();
    look.clusters.map_or(usize::MAX, with_trials)
}

/// The first stage, how it makes the information grow, and the score from which later ones differ.
fn first_stage(scored: ScoredLook, exact: Option<Outcome>) -> (Vec<Stage>, Growing, ScoredLook) {
    let (p_values, least) = match &exact {
        Some(exact) => (exact.p_values, exact.least),
        None => ((scored.p, scored.p), 0.0),
    };
    let mut growing = Growing::from_first(scored.information, least.ln());
    let stage = Stage {
        growth: growing.by(scored.information),
        outcome: p_values,
    };
    let middle = ScoredLook {
        p: f64::midpoint(p_values.0, p_values.1),
        ..scored
    };
    (vec![stage], growing, middle)
}

/// The looks that hold new trials.
fn informative<'a, 'l>(looks: &'a [ClusteredLook<'l>]) -> Vec<&'a ClusteredLook<'l>> {
    let mut kept: Vec<&ClusteredLook<'_>> = Vec::with_capacity(looks.len());
    for look in looks {
        let before = kept.last().map(|it| it.scored);
        if scored_stage(before, look.scored).is_some() {
            kept.push(look);
        }
    }
    kept
}

/// The clusters that a look has and the one before had not, if it has all of those unchanged, and they are few.
fn added(before: Option<&ClusteredLook<'_>>, look: &ClusteredLook<'_>) -> Option<Vec<Sample>> {
    let mut times: BTreeMap<(u64, u64), usize> = BTreeMap::new();
    let known = before.map_or(Some(&[][..]), |before| before.clusters)?;
    for cluster in known.iter().filter(|it| it.trials > 0) {
        *times
            .entry((cluster.successes, cluster.trials))
            .or_default() += 1;
    }
    let mut new = Vec::new();
    for cluster in look.clusters?.iter().filter(|it| it.trials > 0) {
        match times.get_mut(&(cluster.successes, cluster.trials)) {
            Some(left) if *left > 0 => *left -= 1,
            _ => new.push(*cluster),
        }
    }
    let is_extended = times.values().all(|left| *left == 0);
    let trials: u64 = new.iter().map(|it| it.trials).sum();
    (is_extended && !new.is_empty() && new.len() <= MOST_CLUSTERS && trials <= MOST_TRIALS)
        .then_some(new)
}

/// What a stage of these clusters amounts to.
struct Outcome {
    /// `P(X > x)` and `P(X >= x)` of what speaks against the hypothesis.
    p_values: (f64, f64),
    /// The least p-value that it could have had.
    least: f64,
}

fn outcome(added: &[Sample], threshold: f64, correlation: f64, side: Side) -> Outcome {
    let (mean, found): (f64, u64) = match side {
        Side::Above => (threshold, added.iter().map(|it| it.successes).sum()),
        Side::Below => (1.0 - threshold, added.iter().map(Sample::failures).sum()),
    };
    let mut sum = vec![1.0];
    for cluster in added {
        sum = convolved(&sum, &beta_binomial(cluster.trials, mean, correlation));
    }
    let above: f64 = sum[found as usize + 1..].iter().sum();
    Outcome {
        p_values: (above.min(1.0), (above + sum[found as usize]).min(1.0)),
        least: sum.last().copied().unwrap_or(1.0),
    }
}

fn convolved(one: &[f64], other: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; one.len() + other.len() - 1];
    for (i, a) in one.iter().enumerate() {
        for (j, b) in other.iter().enumerate() {
            sum[i + j] += a * b;
        }
    }
    sum
}

/// The probabilities of 0 to `n` successes of one cluster.
fn beta_binomial(n: u64, mean: f64, correlation: f64) -> Vec<f64> {
    let theta = correlation / (1.0 - correlation);
    let mut logarithms = vec![0.0];
    for k in 0..n {
        let (k, left) = (k as f64, (n - k) as f64);
        let ratio = left / (k + 1.0) * (mean + k * theta) / (1.0 - mean + (left - 1.0) * theta);
        logarithms.push(logarithms.last().expect("the first") + ratio.ln());
    }
    let most = logarithms.iter().copied().fold(f64::MIN, f64::max);
    let weights: Vec<f64> = logarithms.iter().map(|it| (it - most).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|it| it / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::continuation::continued_p;
    use crate::special::binomial_pmf;

    fn samples(counts: &[(u64, u64)]) -> Vec<Sample> {
        let sample = |&(successes, trials): &(u64, u64)| Sample { successes, trials };
        counts.iter().map(sample).collect()
    }

    fn look(clusters: &[Sample], p: f64) -> ClusteredLook<'_> {
        let trials: u64 = clusters.iter().map(|it| it.trials).sum();
        ClusteredLook {
            clusters: Some(clusters),
            scored: ScoredLook {
                p,
                information: trials as f64,
            },
        }
    }

    #[test]
    fn one_cluster_has_the_distribution_of_its_definition() {
        // Without correlation binomial; at mean 1/2 and correlation 1/3 the rate is uniform, and so is the count.
        for (k, found) in beta_binomial(7, 0.3, 0.0).iter().enumerate() {
            let expected = binomial_pmf(k as u64, 7, 0.3);
            assert!((found - expected).abs() < 1e-14, "{k}: {found} {expected}");
        }
        let uniform = beta_binomial(9, 0.5, 1.0 / 3.0);
        assert!(uniform.iter().all(|it| (it - 0.1).abs() < 1e-14));
        // All alike: nearly all or nothing.
        let alike = beta_binomial(5, 0.9, 1.0 - 1e-9);
        assert!((alike[5] - 0.9).abs() < 1e-6 && (alike[0] - 0.1).abs() < 1e-6);
        let many = beta_binomial(2000, 0.999, 0.2);
        let mean: f64 = (0..).zip(&many).map(|(k, p)| f64::from(k) * p).sum();
        assert!((mean / 2000.0 - 0.999).abs() < 1e-9, "{mean}");
    }

    #[test]
    fn a_stage_is_the_sum_of_its_clusters() {
        let added = samples(&[(2, 3), (1, 2)]);
        let (above, at_least) = outcome(&added, 0.6, 0.25, Side::Above).p_values;
        let (one, other) = (beta_binomial(3, 0.6, 0.25), beta_binomial(2, 0.6, 0.25));
        let sum = |from: usize| -> f64 {
            let pairs = (0..4).flat_map(|i| (0..3).map(move |j| (i, j)));
            pairs
                .filter(|(i, j)| i + j >= from)
                .map(|(i, j)| one[i] * other[j])
                .sum()
        };
        assert!((above - sum(4)).abs() < 1e-14 && (at_least - sum(3)).abs() < 1e-14);
    }

    /// Two people who never fail cannot show 95 %, and leave the level to the ten who come later; so does one of whom it was
    /// not known then how alike attempts are.
    #[test]
    fn a_look_at_few_people_does_not_spend_the_level() {
        let ten = [20, 20, 19, 20, 20, 19, 20, 20, 20, 19];
        let ten = ten.map(|it| (it, 20));
        for (first, p) in [(&[(20, 20); 2][..], 0.9), (&[(19, 20); 1], 0.74)] {
            let first = samples(first);
            let all: Vec<Sample> = first.iter().copied().chain(samples(&ten)).collect();
            let again = continued_clusters_above(&[look(&first, p), look(&all, 0.003)], 0.95);
            assert!(again < 0.06, "{first:?}: {again}");
        }
    }

    #[test]
    fn no_looks_show_what_all_people_together_do_not() {
        let (first, more) = (samples(&[(8, 10); 20]), samples(&[(10, 10); 20]));
        let all: Vec<Sample> = first.iter().chain(&more).copied().collect();
        let looks = [look(&first, 1.0), look(&all, 0.4)];
        assert!(continued_clusters_above(&looks, 0.89) >= 0.4);
    }

    /// Successes against "at most" are failures against "at least".
    #[test]
    fn both_sides_are_one_test() {
        let (first, all) = (
            samples(&[(9, 10), (5, 10), (10, 10)]),
            samples(&[(9, 10), (5, 10), (10, 10), (2, 10)]),
        );
        let turned = |samples: &[Sample]| -> Vec<Sample> {
            let one = |it: &Sample| Sample {
                successes: it.failures(),
                trials: it.trials,
            };
            samples.iter().map(one).collect()
        };
        let (first_turned, all_turned) = (turned(&first), turned(&all));
        let above = continued_clusters_above(&[look(&first, 0.3), look(&all, 0.4)], 0.8);
        let below =
            continued_clusters_below(&[look(&first_turned, 0.3), look(&all_turned, 0.4)], 0.2);
        assert!((above / below - 1.0).abs() < 1e-9, "{above} {below}");
    }

    /// A person who fails ten times is five standard deviations away, and still happens once in some hundred.
    #[test]
    fn one_person_more_is_no_normal_increment() {
        let first: Vec<Sample> =
            samples(&[(10, 10), (10, 10), (9, 10), (10, 10), (7, 10), (6, 10)]);
        let all: Vec<Sample> = first.iter().copied().chain(samples(&[(0, 10)])).collect();
        let looks = [look(&first, 0.6), look(&all, 0.02)];
        let by_scores = continued_p(&looks.clone().map(|it| it.scored));
        let found = continued_clusters_below(&looks, 0.9);
        assert!(found > 2.0 * by_scores, "{found} {by_scores}");
    }

    #[test]
    fn what_is_no_stage_of_few_new_people_is_judged_by_scores() {
        let first = samples(&[(9, 10), (5, 10)]);
        let more_of_the_same = samples(&[(18, 20), (5, 10)]);
        let many: Vec<Sample> = first
            .iter()
            .copied()
            .chain((0..=MOST_CLUSTERS as u64).map(|it| Sample {
                successes: 5 + it % 5,
                trials: 10,
            }))
            .collect();
        let correlation = |clusters: &[Sample]| Model::new(clusters).most_likely_correlation(0.7);
        for later in [more_of_the_same, many] {
            let looks = [look(&first, 0.6), look(&later, 0.1)];
            let exact = outcome(&first, 0.7, correlation(&later), Side::Above);
            let middle = ScoredLook {
                p: f64::midpoint(exact.p_values.0, exact.p_values.1),
                ..looks[0].scored
            };
            let by_scores = scored_stage(Some(middle), looks[1].scored).expect("new");
            let stages = |second: Stage| {
                let information = looks[0].scored.information;
                let mut growing = Growing::from_first(information, exact.least.ln());
                let stage = Stage {
                    growth: growing.by(information),
                    outcome: exact.p_values,
                };
                p_of_stages(&[stage, second])
            };
            let found = continued_clusters_above(&looks, 0.7);
            assert_eq!(found, stages(by_scores).max(0.1));
        }
        let unknown = [
            look(&first, 0.6),
            look(&samples(&[(9, 10), (5, 10), (8, 10)]), 0.2),
        ]
        .map(|it| ClusteredLook {
            clusters: None,
            ..it
        });
        let by_scores = continued_p(&unknown.clone().map(|it| it.scored));
        assert_eq!(continued_clusters_below(&unknown, 0.7), by_scores);
    }
}
