//! What counts of a few people say of everybody's mean rate, if there may be people of a kind that none of them is.
//!
//! # Definition
//! A share `1 - s` of all people always fails, and the others have the mean rate `m`, so that the mean of all is `s m`. That none
//! of `n` people is of that kind has the probability `s^n`. The p-value of "the mean of all is at most `t`" is the greatest of
//! these laws: the greatest `(t / m)^n p(m)` over `m` from `t` to 1, where `p(m)` is the p-value of "the mean of the others is at
//! most `m`" by whatever test there is. In the same way that of "at least `t`" allows for people who always succeed.
//!
//! # Why
//! Of ten people eight succeed in 10 of 10 attempts and two in 9 of 10. Nothing shows that attempts of one person are alike, so
//! that the likelihood has a p-value of 0.024 for a rate of at most 0.9. That is more than if all ten had always succeeded, which
//! shows little: `0.9^10`, or 35 %, of all groups of ten have nobody of a tenth of people who cannot do it.
//!
//! The probability of a better count ([`crate::BetaBinomial::threshold_tests`]) allows for it where people are few; it does not suppose
//! that there are people whom nobody met.
//!
//! How often a mean rate of 0.9 is shown to be higher at a level of 5 %, in percent of 300 groups, and how often one of 0.97 is
//! (`cargo run -p corroborate-stats --release --example unmet_kind`):
//!
//! | people x 10 | law | by the model | allowing for others |
//! |---|---|---|---|
//! | 10 | 85 % succeed in 98 %, the others in 45 % | 1.0 [0.3, 2.9] | 0.0 [0.0, 1.3] |
//! | 20 | the same | 3.3 [1.8, 6.0] | 0.0 [0.0, 1.3] |
//! | 40 | the same | 2.7 [1.4, 5.2] | 1.3 [0.5, 3.4] |
//! | 80 | the same | 3.0 [1.6, 5.6] | 2.7 [1.4, 5.2] |
//! | 10 | logits of rates normal | 0.7 [0.2, 2.4] | 0.0 [0.0, 1.3] |
//! | 20 | the same | 5.7 [3.6, 8.9] | 0.0 [0.0, 1.3] |
//! | 40 | the same | 6.7 [4.4, 10.1] | 0.3 [0.1, 1.9] |
//! | 80 | the same | 7.0 [4.6, 10.5] | 5.0 [3.1, 8.1] |
//! | 10 | all alike, 0.97 | 11.0 [7.9, 15.0] | 0.0 [0.0, 1.3] |
//! | 20 | the same | 96.7 [94.0, 98.2] | 0.0 [0.0, 1.3] |
//! | 40 | the same | 100.0 [98.7, 100.0] | 89.7 [85.7, 92.6] |
//!
//! So it needs about `3 / (1 - t)` people before anything is shown, which is what it costs not to suppose anything of those
//! whom nobody met. Conclusions rest on the model, and say where they would not be drawn without it.
//!
//! # Source
//! The supremum over a contaminated family, as in P. J. Huber (1965), "A robust version of the probability ratio test". If all
//! people always succeed it is Clopper and Pearson's exact test with each of them as one trial.
//!
//! # Deviation
//! The greatest value is sought at shares `s` whose `s^n` fall by [`STEP`] each, and half a step beside the best of them, so that
//! it is found to within the root of that factor, in practice to within 2 in 100. Below [`LEAST`] nothing is sought.
//!
//! # Assumes
//! That of the test. People are independent draws of all people, so that each is of the unmet kind with the same
//! probability.
//!
//! # Guarantee
//! As the test's, for people of whom a share may also be of the kind that always fails (or always succeeds) and is not met.
//! Never below the p-value of the test itself. Where people of that kind were met, the test has to know of them.

/// By how much the probability that none was met falls from one share to the next.
pub const STEP: f64 = 0.8;

/// The least probability that none was met of which account is taken.
pub const LEAST: f64 = 1e-6;

/// p-values of "the mean rate is at most the threshold" and "it is at least the threshold", of this many people, by a test that
/// gives both for people of whom the kind was met.
///
/// ```
/// use stats::{BetaBinomial, Sample, with_unmet_kind};
/// let ten: Vec<Sample> = [10, 10, 9, 10, 10, 10, 9, 10, 10, 10].map(|successes| Sample { successes, trials: 10 }).into();
/// let fit = BetaBinomial::fit(&ten)?;
/// assert!(fit.threshold_tests(0.9).0 < 0.09);
/// let (at_most, _) = with_unmet_kind(10.0, 0.9, |mean| fit.threshold_tests(mean));
/// assert!(at_most > 0.3);
/// # Ok::<(), stats::StatsError>(())
/// ```
pub fn with_unmet_kind(
    people: f64,
    threshold: f64,
    test: impl Fn(f64) -> (f64, f64),
) -> (f64, f64) {
    let (at_most, at_least) = test(threshold);
    if !(threshold > 0.0 && threshold < 1.0) {
        return (at_most, at_least);
    }
    // Of those who always succeed: failures are the successes of the mirrored test.
    (
        greatest(people, threshold, at_most, |mean| test(mean).0),
        greatest(people, 1.0 - threshold, at_least, |mean| test(1.0 - mean).1),
    )
}

/// The greatest `s^n p(t / s)`, given that of `s = 1`.
fn greatest(people: f64, threshold: f64, of_all: f64, test: impl Fn(f64) -> f64) -> f64 {
    let at = |none_met: f64| {
        let mean = threshold / none_met.powf(1.0 / people);
        (mean < 1.0).then(|| none_met * test(mean))
    };
    let (mut best, mut found, mut none_met) = (1.0, of_all, STEP);
    // Where it is no more than what is found no p-value, which is at most 1, makes more of it.
    while none_met > found.max(LEAST) {
        let Some(here) = at(none_met) else { break };
        if here > found {
            (best, found) = (none_met, here);
        }
        none_met *= STEP;
    }
    let beside = [best * STEP.sqrt(), (best / STEP.sqrt()).min(1.0)];
    let beside = beside.into_iter().filter_map(at).fold(found, f64::max);
    beside.max(threshold.powf(people)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binomial::{binomial_test_above, binomial_test_below};
    use crate::counts::Sample;

    fn binomial(successes: u64, trials: u64, mean: f64) -> (f64, f64) {
        let sample = Sample { successes, trials };
        (
            binomial_test_above(sample, mean),
            binomial_test_below(sample, mean),
        )
    }

    #[test]
    fn people_who_always_succeed_are_a_trial_each() {
        for (people, threshold) in [(10.0, 0.9), (29.0, 0.9), (5.0, 0.5)] {
            let sure = |_: f64| (0.0, 1.0);
            let (at_most, at_least) = with_unmet_kind(people, threshold, sure);
            assert!((at_most - f64::powf(threshold, people)).abs() < 1e-15);
            assert_eq!(at_least, 1.0);
        }
    }

    /// By a fine grid of shares, as the definition says.
    #[test]
    fn the_greatest_of_the_definition_is_found_to_within_a_step() {
        for (successes, threshold, people) in [(98, 0.9, 10.0), (95, 0.8, 20.0), (60, 0.5, 5.0)] {
            let (found, _) = with_unmet_kind(people, threshold, |m| binomial(successes, 100, m));
            let at = |place: u32| {
                let share = threshold + (1.0 - threshold) * f64::from(place) / 10_000.0;
                share.powf(people) * binomial(successes, 100, threshold / share).0
            };
            let greatest = (0..=10_000).map(at).fold(0.0, f64::max);
            assert!(
                found <= greatest * (1.0 + 1e-9) && found >= 0.98 * greatest,
                "{found} {greatest}"
            );
        }
    }

    #[test]
    fn a_certain_threshold_is_the_tests_own() {
        for threshold in [0.0, 1.0] {
            let (found, own) = (
                with_unmet_kind(3.0, threshold, |m| binomial(5, 9, m)),
                binomial(5, 9, threshold),
            );
            assert_eq!(found, own);
        }
    }

    /// Successes of 60 and thresholds.
    fn cases() -> impl Iterator<Item = (u64, f64)> {
        let thresholds = [0.02, 0.1, 0.35, 0.5, 0.77, 0.9, 0.98];
        (0..=60).flat_map(move |successes| thresholds.map(|it| (successes, it)))
    }

    #[test]
    fn never_below_the_test_and_as_it_with_many_people() {
        for (successes, threshold) in cases() {
            let own = binomial(successes, 60, threshold);
            let few = with_unmet_kind(6.0, threshold, |m| binomial(successes, 60, m));
            assert!(few.0 >= own.0 && few.1 >= own.1 && few.0 <= 1.0 && few.1 <= 1.0);
            let many = with_unmet_kind(1e6, threshold, |m| binomial(successes, 60, m));
            assert!((many.0 - own.0).abs() <= 1e-4 && (many.1 - own.1).abs() <= 1e-4);
        }
    }

    #[test]
    fn both_sides_are_one_test() {
        for (successes, threshold) in cases() {
            let (at_most, at_least) =
                with_unmet_kind(7.0, threshold, |m| binomial(successes, 60, m));
            let turned = with_unmet_kind(7.0, 1.0 - threshold, |m| binomial(60 - successes, 60, m));
            assert!((at_most - turned.1).abs() < 1e-9 && (at_least - turned.0).abs() < 1e-9);
        }
    }

    /// A limit is sought by halving: the p-value may not fall where the threshold rises.
    #[test]
    fn the_higher_the_threshold_the_less_is_shown_to_be_above() {
        for successes in [30, 55, 58, 60] {
            let mut before = 0.0;
            for place in 1..100 {
                let (found, _) = with_unmet_kind(12.0, f64::from(place) / 100.0, |m| {
                    binomial(successes, 60, m)
                });
                assert!(
                    found >= before - 1e-12,
                    "{successes} {place}: {found} {before}"
                );
                before = found;
            }
        }
    }
}
