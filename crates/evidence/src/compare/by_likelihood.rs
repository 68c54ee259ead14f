//! A pair of rates by the likelihood of counts by subject, beside the test at the effective size.
//!
//! # Definition
//! A side has a deviate `z(r)` at each rate `r`, positive where its rate lies above: of counts by subject that of Student's
//! test of their likelihood ([`super::by_cluster`]), of other counts the root of their deviance at the effective size, of a
//! distribution its normal quantile at `r`; with the distance `d`
//!
//! ```text
//! S(d) = min over r of  z1(r)^2 + z2(r + d)^2
//! ```
//!
//! "No difference" has the p-value `P(chi-squared_1 > S(0))`, "second minus first is at least d" that of a normal deviate of
//! size `S(d)^(1/2)`, on the side on which the estimates lie. Against a known number the p-values are those of the counts
//! at that number, and at the ends of the margin. Against a range that is uncertain each direction has the end that it meets.
//!
//! # Why
//! A verdict asks the counts by subject, too ([`super::by_cluster`] says why); a comparison that did not could call different,
//! or within the margin, what the same counts do not show against a threshold. A claim needs both: the greater p-value counts.
//!
//! # Source
//! The profile of a difference: S. G. Self and K.-Y. Liang (1987), S. S. Wilks (1938). Deviation: each side's ratio of likelihoods
//! enters as the normal deviate of its own p-value, which knows how few the subjects are.
//!
//! # Assumes
//! Counts by subject as [`super::by_cluster`] has it, other counts as independent trials at their effective size; both
//! sides are independent of each other. Ratios of likelihoods have the distributions that they have in large samples.
//!
//! # Guarantee
//! Never more claims than by the effective size alone. Asymptotic in the number of subjects; `ERROR_RATES.md` has measured rates.

use super::Belief;
use super::ends::{End, Ends};
use super::pair::{to_agree_with, without_rounding};
use super::uncertain::Uncertain;
use stats::special::{chi_squared_sf, normal_quantile, normal_sf};
use stats::{EffectiveSample, Interval};

/// Deviates beyond this are no better evidence.
const MOST_DEVIATE: f64 = 37.0;

/// Places at which the smallest sum is sought before it is refined, and how often it is.
const PLACES: u32 = 8;
const REFINEMENTS: u32 = 16;

/// Deviates below this do not fall everywhere.
const JUMP: f64 = 0.7;

/// Both p-values of counts beside what is no count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PairByLikelihood {
    /// Of "no difference".
    difference: f64,
    /// Of "the difference is the margin or more".
    equivalence: f64,
}

/// What is asked of a pair.
#[derive(Clone, Copy)]
pub(super) enum Claim {
    /// That they differ.
    Difference,
    /// That the difference is below this margin.
    Within(f64),
}

/// The p-value of a claim; 0, which claims nothing by itself, where no side has counts by subject that tell how alike they are.
pub(super) fn p_value(first: &Belief, second: &Belief, claim: Claim) -> f64 {
    if !tells_how_alike(first) && !tells_how_alike(second) {
        return 0.0;
    }
    let margin = match claim {
        Claim::Difference => 0.0,
        Claim::Within(margin) => margin,
    };
    let beside = |counts: &Side<'_>, other: &Belief| {
        let both = PairByLikelihood::beside(counts, other, margin);
        match claim {
            Claim::Difference => both.difference,
            Claim::Within(_) => both.equivalence,
        }
    };
    match (Side::of(first), Side::of(second)) {
        (Some(one), Some(other)) => match claim {
            Claim::Difference => chi_squared_sf(sum_of_squares(&one, &other, 0.0), 1.0),
            Claim::Within(margin) => {
                p_at_least(&one, &other, margin).max(p_at_least(&other, &one, margin))
            }
        },
        (Some(counts), None) => beside(&counts, second),
        (None, Some(counts)) => beside(&counts, first),
        (None, None) => 0.0,
    }
}

impl PairByLikelihood {
    /// Counts beside numbers between bounds, or between ends that are uncertain.
    fn beside(counts: &Side<'_>, other: &Belief, margin: f64) -> Self {
        match other {
            Belief::Known { bounds, .. } => {
                let nearest = counts.centre().clamp(bounds.low, bounds.high);
                let far = counts.deviate(nearest).abs();
                let Interval { low, high } = to_agree_with(other);
                Self {
                    difference: (2.0 * normal_sf(far)).min(1.0),
                    equivalence: counts
                        .p_above(high - margin)
                        .max(counts.p_below(low + margin)),
                }
            }
            Belief::Range { ends, .. } => Self::beside_ends(counts, ends, margin),
            Belief::Counts { .. } | Belief::Distribution { .. } => Self::default(),
        }
    }

    fn beside_ends(counts: &Side<'_>, ends: &Ends, margin: f64) -> Self {
        let beyond =
            p_not_below(counts, &ends.least, 0.0).min(p_not_above(counts, &ends.greatest, 0.0));
        let (floor, ceiling) = match ends.is_range {
            true => (&ends.least, &ends.greatest),
            false => (&ends.greatest, &ends.least),
        };
        Self {
            difference: (2.0 * beyond).min(1.0),
            equivalence: p_not_above(counts, floor, margin)
                .max(p_not_below(counts, ceiling, margin)),
        }
    }
}

/// p-value of "the counts lie below the end by the distance or more".
fn p_not_above(counts: &Side<'_>, end: &End, distance: f64) -> f64 {
    match end {
        End::Known(end) => counts.p_above(end - distance),
        End::Uncertain(end) => p_at_least(counts, &Side::Distributed(end.clone()), distance),
    }
}

/// p-value of "the counts lie above the end by the distance or more".
fn p_not_below(counts: &Side<'_>, end: &End, distance: f64) -> f64 {
    match end {
        End::Known(end) => counts.p_below(end + distance),
        End::Uncertain(end) => p_at_least(&Side::Distributed(end.clone()), counts, distance),
    }
}

fn tells_how_alike(belief: &Belief) -> bool {
    matches!(belief, Belief::Counts { clusters: Some(clusters), .. } if clusters.mean().is_some())
}

/// A side with a deviate at each rate.
enum Side<'b> {
    Counted(&'b Belief, EffectiveSample),
    Distributed(Uncertain),
}

impl<'b> Side<'b> {
    fn of(belief: &'b Belief) -> Option<Self> {
        match belief {
            Belief::Counts { effective, .. } => Some(Self::Counted(belief, *effective)),
            Belief::Distribution {
                posterior,
                quantiles,
                ..
            } => Some(Self::Distributed(Uncertain {
                shape: *posterior,
                quantiles: quantiles.clone(),
            })),
            Belief::Known { .. } | Belief::Range { .. } => None,
        }
    }

    /// Positive where its rate lies above.
    fn deviate(&self, rate: f64) -> f64 {
        let found = match self {
            Self::Counted(belief, effective) => {
                by_subject(belief, rate).unwrap_or_else(|| root_of_deviance(*effective, rate))
            }
            Self::Distributed(number) => deviate_of(number.cdf(rate), number.sf(rate)),
        };
        found.clamp(-MOST_DEVIATE, MOST_DEVIATE)
    }

    /// Where its deviate is 0.
    fn centre(&self) -> f64 {
        match self {
            Self::Counted(Belief::Counts { clusters, .. }, effective) => {
                let mean = clusters.as_ref().and_then(|it| it.mean());
                mean.unwrap_or(effective.successes / effective.trials)
            }
            Self::Counted(belief, _) => belief.estimate(),
            Self::Distributed(number) => number.quantile(0.5),
        }
    }

    /// p-value of "the rate is at most this".
    fn p_above(&self, rate: f64) -> f64 {
        let rate = without_rounding(rate);
        if rate < 0.0 {
            0.0
        } else {
            normal_sf(self.deviate(rate))
        }
    }

    /// p-value of "the rate is at least this".
    fn p_below(&self, rate: f64) -> f64 {
        let rate = without_rounding(rate);
        if rate > 1.0 {
            0.0
        } else {
            normal_sf(-self.deviate(rate))
        }
    }
}

fn by_subject(belief: &Belief, rate: f64) -> Option<f64> {
    let Belief::Counts { clusters, .. } = belief else {
        return None;
    };
    let clusters = clusters.as_ref()?;
    clusters.mean()?;
    let (at_most, at_least) = clusters.doubts(rate);
    Some(deviate_of(at_most, at_least))
}

/// The deviate of which these are the tails beyond and before it.
fn deviate_of(above: f64, below: f64) -> f64 {
    if above <= below {
        -normal_quantile(above.max(f64::MIN_POSITIVE))
    } else {
        normal_quantile(below.max(f64::MIN_POSITIVE))
    }
}

fn root_of_deviance(sample: EffectiveSample, rate: f64) -> f64 {
    let (found, trials) = (sample.successes / sample.trials, sample.trials);
    let part = |own: f64, expected: f64| match own > 0.0 {
        true => own * (own / expected).ln(),
        false => 0.0,
    };
    let deviance = 2.0 * trials * (part(found, rate) + part(1.0 - found, 1.0 - rate));
    deviance.max(0.0).sqrt().copysign(found - rate)
}

/// Whether the p-value of a claim is small enough, as any smaller one is: found without all of the sum where a part of it tells.
/// Plans ask it of thousands of outcomes.
pub(super) fn shows(
    first: &Belief,
    second: &Belief,
    claim: Claim,
    is_small: impl Fn(f64) -> bool,
) -> bool {
    let sides = (Side::of(first), Side::of(second));
    let tells = tells_how_alike(first) || tells_how_alike(second);
    let (true, (Some(one), Some(other))) = (tells, sides) else {
        return is_small(p_value(first, second, claim));
    };
    match claim {
        Claim::Difference => sum_is(&one, &other, 0.0, |sum| is_small(chi_squared_sf(sum, 1.0))),
        Claim::Within(margin) => {
            is_small_at_least(&one, &other, margin, &is_small)
                && is_small_at_least(&other, &one, margin, &is_small)
        }
    }
}

/// Whether the p-value of "the second lies above the first by the distance or more" is small enough.
fn is_small_at_least(
    first: &Side<'_>,
    second: &Side<'_>,
    distance: f64,
    is_small: impl Fn(f64) -> bool,
) -> bool {
    if distance > 1.0 {
        return is_small(0.0);
    }
    match second.centre() - first.centre() < distance {
        true => sum_is(first, second, distance, |sum| {
            is_small(normal_sf(sum.sqrt()))
        }),
        // It is one half at least.
        false => is_small(0.5) && is_small(p_at_least(first, second, distance)),
    }
}

/// p-value of "the second lies above the first by the distance or more".
fn p_at_least(first: &Side<'_>, second: &Side<'_>, distance: f64) -> f64 {
    if distance > 1.0 {
        return 0.0;
    }
    let size = sum_of_squares(first, second, distance).sqrt();
    match second.centre() - first.centre() < distance {
        true => normal_sf(size),
        false => normal_sf(-size),
    }
}

/// The rates between which the least `z1(r)^2 + z2(r + distance)^2` lies: those at which one of both is 0.
fn between(first: &Side<'_>, second: &Side<'_>, distance: f64) -> (f64, f64) {
    let inside = |rate: f64| rate.clamp((-distance).max(0.0), (1.0 - distance).min(1.0));
    let ends = [first.centre(), second.centre() - distance].map(inside);
    (ends[0].min(ends[1]), ends[0].max(ends[1]))
}

/// Whether the least sum is enough, where more is enough whenever less is.
fn sum_is(
    first: &Side<'_>,
    second: &Side<'_>,
    distance: f64,
    is_enough: impl Fn(f64) -> bool,
) -> bool {
    let (low, high) = between(first, second, distance);
    let step = (high - low) / f64::from(PLACES);
    let deviates = |place: u32| {
        let rate = low + f64::from(place) * step;
        [first.deviate(rate), second.deviate(rate + distance)]
    };
    let sum = |[one, other]: [f64; 2]| one.powi(2) + other.powi(2);
    // The least is mostly in the middle, and is no greater than any.
    if !is_enough(sum(deviates(PLACES / 2))) {
        return false;
    }
    let places: Vec<[f64; 2]> = (0..=PLACES).map(deviates).collect();
    let smallest = |sums: &mut dyn Iterator<Item = f64>| sums.fold(f64::INFINITY, f64::min);
    if !is_enough(smallest(&mut places.iter().map(|it| sum(*it)))) {
        return false;
    }
    // Deviates fall as rates rise, so that between two places each has at least the smaller size of both; near 0, where the
    // greater of two p-values changes from one to the other, they jump.
    let least = |one: f64, other: f64| {
        let smaller = one.abs().min(other.abs());
        let is_clear = one * other > 0.0 && smaller > JUMP;
        if is_clear { smaller } else { 0.0 }
    };
    let of_cell = |it: &[[f64; 2]]| sum([least(it[0][0], it[1][0]), least(it[0][1], it[1][1])]);
    is_enough(smallest(&mut places.windows(2).map(of_cell)))
        || is_enough(least_sum(first, second, distance, |sum| !is_enough(sum)))
}

/// The least `z1(r)^2 + z2(r + distance)^2` over all rates.
fn sum_of_squares(first: &Side<'_>, second: &Side<'_>, distance: f64) -> f64 {
    least_sum(first, second, distance, |_| false)
}

/// The same, or what is found of it so far where that is small enough to know.
fn least_sum(
    first: &Side<'_>,
    second: &Side<'_>,
    distance: f64,
    is_known: impl Fn(f64) -> bool,
) -> f64 {
    let (low, high) = between(first, second, distance);
    let at = |rate: f64| first.deviate(rate).powi(2) + second.deviate(rate + distance).powi(2);
    let step = (high - low) / f64::from(PLACES);
    let mut best = (low, f64::INFINITY);
    for place in 0..=PLACES {
        let rate = low + f64::from(place) * step;
        let sum = at(rate);
        if sum < best.1 {
            best = (rate, sum);
        }
    }
    let (mut low, mut high) = ((best.0 - step).max(low), (best.0 + step).min(high));
    for _ in 0..REFINEMENTS {
        if is_known(best.1) {
            break;
        }
        let third = (high - low) / 3.0;
        let (left, right) = (at(low + third), at(high - third));
        best.1 = best.1.min(left).min(right);
        if left <= right {
            high -= third;
        } else {
            low += third;
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::super::belief::samples::{counts, known};
    use super::super::by_cluster::ByCluster;
    use super::super::pair::Pair;
    use super::*;
    use crate::Measure;
    use crate::uniform::Uniform;
    use stats::{Confidence, Sample};

    /// Both p-values of a pair.
    fn both(first: &Belief, second: &Belief, margin: f64) -> PairByLikelihood {
        PairByLikelihood {
            difference: p_value(first, second, Claim::Difference),
            equivalence: p_value(first, second, Claim::Within(margin)),
        }
    }

    fn of_people(counts: &[(u64, u64)]) -> Belief {
        let sample = |&(successes, trials): &(u64, u64)| Sample { successes, trials };
        let people: Vec<Sample> = counts.iter().map(sample).collect();
        belief(&people)
    }

    fn belief(people: &[Sample]) -> Belief {
        let measure = Measure::of_clusters(people, Confidence::P95).expect("counts");
        Belief::of(&measure).expect("a belief")
    }

    const TEN: [(u64, u64); 10] = [
        (9, 10),
        (10, 10),
        (8, 10),
        (7, 10),
        (9, 10),
        (10, 10),
        (10, 10),
        (6, 10),
        (9, 10),
        (10, 10),
    ];

    /// What a verdict asks of the counts by subject at a threshold, a pair asks at the known number and at its margin.
    #[test]
    fn beside_a_known_number_it_is_what_a_verdict_asks() {
        let people = of_people(&TEN);
        let clusters = ByCluster::new(&TEN.map(|(count, trials)| [count, trials]));
        let found = both(&people, &known(0.95), 0.1);
        let (_, at_least) = clusters.doubts(0.95);
        assert!(
            (found.difference - 2.0 * at_least).abs() < 1e-9,
            "{found:?}"
        );
        let (at_most, _) = clusters.doubts(0.95 - 0.1);
        assert!((found.equivalence - at_most).abs() < 1e-9, "{found:?}");
        let swapped = both(&known(0.95), &people, 0.1);
        assert_eq!(found, swapped);
    }

    /// Of many people who do not differ it is the ratio of likelihoods of two binomial counts, but that the probability of as good a
    /// count has the whole of the one that was observed.
    #[test]
    fn of_many_who_do_not_differ_it_is_that_of_two_counts() {
        let mut people = vec![(1, 2); 300];
        people.extend(vec![(2, 2); 350]);
        people.extend(vec![(0, 2); 50]);
        let first = of_people(&people);
        let (a, n, b, m) = (1000.0, 1400.0, 330.0, 500.0);
        let found = both(&first, &counts(330, 500), 0.1);
        let ln = |k: f64, n: f64, rate: f64| k * rate.ln() + (n - k) * (1.0 - rate).ln();
        let pooled = (a + b) / (n + m);
        let ratio = ln(a, n, a / n) + ln(b, m, b / m) - ln(a, n, pooled) - ln(b, m, pooled);
        let expected = chi_squared_sf(2.0 * ratio, 1.0);
        assert!(
            (found.difference / expected - 1.0).abs() < 0.06,
            "{found:?} {expected}"
        );
        let swapped = both(&counts(330, 500), &first, 0.1);
        assert!((swapped.difference / found.difference - 1.0).abs() < 1e-3);
        assert!((swapped.equivalence / found.equivalence - 1.0).abs() < 1e-3);
    }

    #[test]
    fn without_counts_by_subject_it_claims_nothing() {
        let none = PairByLikelihood::default();
        assert_eq!((none.difference, none.equivalence), (0.0, 0.0));
        for other in [counts(80, 100), known(0.9)] {
            assert_eq!(both(&counts(90, 100), &other, 0.1), none);
        }
        // Of people whose trials all came out alike nothing tells how alike they are.
        let alike = of_people(&[(10, 10), (10, 10), (10, 10)]);
        assert_eq!(both(&alike, &known(0.9), 0.1), none);
    }

    /// Estimates that are the margin or more apart speak for no agreement.
    #[test]
    fn what_lies_beyond_the_margin_does_not_agree() {
        for other in [counts(70, 100), known(0.7)] {
            let found = both(&of_people(&TEN), &other, 0.1);
            assert!(found.equivalence > 0.5, "{found:?}");
        }
    }

    /// A model whose constants are nearly certain is a known number, as a range, too.
    #[test]
    fn a_narrow_distribution_is_a_known_number() {
        let people = of_people(&TEN);
        let shape = stats::BetaPosterior::new(95_000.0, 5_000.0).expect("a distribution");
        let distribution = Belief::Distribution {
            value: 0.95,
            posterior: shape,
            quantiles: None,
        };
        let range = Belief::Range {
            value: 0.95,
            ends: Ends {
                as_written: Interval {
                    low: 0.95,
                    high: 0.95,
                },
                least: End::Uncertain(shape.into()),
                greatest: End::Known(0.95),
                is_range: false,
            },
        };
        let expected = both(&people, &known(0.95), 0.1);
        for other in [distribution, range] {
            let found = both(&people, &other, 0.1);
            for (found, expected) in [
                (found.difference, expected.difference),
                (found.equivalence, expected.equivalence),
            ] {
                assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
            }
        }
    }

    /// What plans ask is what the p-value says, at whatever level: of people beside counts, and beside other people.
    #[test]
    fn a_claim_is_shown_where_its_p_value_is_small() {
        let mut uniform = Uniform(7);
        let mut told = [0_u32; 2];
        for study in 0..60 {
            let them = belief(&uniform.people(8, 10, 0.85, 0.3));
            let rate = 0.4 + 0.5 * uniform.draw();
            let other = match study % 2 {
                0 => belief(&uniform.people(12, 20, rate, 0.1)),
                _ => counts(uniform.sample(300, rate).successes, 300),
            };
            for claim in [Claim::Difference, Claim::Within(0.2), Claim::Within(0.4)] {
                let p = p_value(&them, &other, claim);
                for alpha in [0.6, 0.05, 0.01, 1e-4, 0.99 * p, 1.01 * p] {
                    let found = shows(&them, &other, claim, |p| p <= alpha);
                    assert_eq!(found, p <= alpha, "{p} {alpha}");
                    told[usize::from(found)] += 1;
                }
            }
        }
        assert!(told.iter().all(|times| *times > 200), "{told:?}");
    }

    /// Between people and a simulation neither difference nor agreement is shown in more than 5 % of studies where it is
    /// false; and a comparison never says more than the counts by subject, or the effective size, alone.
    #[test]
    fn false_claims_about_people_are_rare() {
        let mut uniform = Uniform(11);
        let studies = 200;
        let (mut differ, mut agree) = (0, 0);
        for _ in 0..studies {
            let them = belief(&uniform.people(12, 10, 0.85, 0.3));
            let mut simulated = |rate: f64| {
                let sample = uniform.sample(400, rate);
                counts(sample.successes, sample.trials)
            };
            let same = Pair::new(them.clone(), simulated(0.85), 0.1);
            differ += u32::from(same.p_difference() <= 0.05);
            assert!(same.p_difference() >= same.difference_by_likelihood());
            let apart = Pair::new(them, simulated(0.75), 0.1);
            agree += u32::from(apart.shows_agreement(Confidence::P95));
        }
        // 5 % of 200 and three standard deviations.
        assert!(differ <= 19 && agree <= 19, "{differ} {agree}");
    }
}
