//! How one piece of evidence stands to a threshold.
//!
//! # Assumes
//! Counts are of independent trials, or of people as `compare/by_cluster.rs` has it, of a size fixed in advance where there
//! are no looks. Distributions are posteriors of constants by Jeffreys' prior, and bounds of computed values hold.

use super::fewer::better_without_one;
use super::{CERTAINTY, limits, words};
use crate::compare::{Belief, CountsAtLook, End};
use crate::looks::over_looks;
use crate::{Direction, Finding, PieceStanding, Standing, Step, Threshold};
use stats::{
    Confidence, EffectiveSample, Interval, binomial_test_above, binomial_test_below,
    clustered_test_above, clustered_test_below,
};

/// The levels of the two claims: that the threshold is met, and that it is missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClaimLevels {
    pub met: f64,
    pub missed: f64,
}

impl ClaimLevels {
    /// Both claims at one level.
    pub fn both(level: Confidence) -> Self {
        Self {
            met: level.alpha(),
            missed: level.alpha(),
        }
    }
}

/// A piece of evidence as its figures name it.
#[derive(Clone, Copy)]
pub(super) struct Named<'n> {
    pub id: &'n str,
    pub step: Step,
    /// Its finding on what is judged, and what triggers that in the words of the study.
    pub finding: &'n Finding,
    pub trigger: Option<&'n str>,
}

impl Named<'_> {
    /// Over which runs its figure is taken.
    pub fn condition(&self) -> String {
        self.finding.condition(self.trigger).unwrap_or_default()
    }
}

/// How a piece stands to a threshold at these levels.
pub(super) fn stand(
    named: Named<'_>,
    belief: &Belief,
    threshold: Threshold,
    levels: ClaimLevels,
) -> PieceStanding {
    let (p_not_met, p_met) = doubts(belief, threshold);
    let limits = limits::limits(belief, threshold, levels);
    let contradicted = contradicted(belief, threshold, (p_not_met, p_met), levels);
    let standing = match contradicted {
        Some(_) => Standing::Neither,
        None => standing(p_not_met, p_met, levels),
    };
    PieceStanding {
        evidence: named.id.to_owned(),
        step: named.step,
        standing,
        p_not_met,
        p_met,
        level_met: levels.met,
        level_missed: levels.missed,
        limits,
        elsewhere: false,
        condition: named.condition(),
        words: words::piece(
            (named.id, named.finding.given()),
            belief,
            threshold,
            (p_not_met, p_met),
            (limits, levels),
            contradicted,
        ) + &alike_as_elsewhere(belief, threshold, standing, levels)
            + &all_kinds_met(belief, threshold, standing, levels)
            + &each_triggers(named, standing)
            + &better_without_one(belief, threshold, levels),
    }
}

/// That a claim supposes that trials of one subject are as alike here as in what else was counted of these subjects, if it
/// would not be made with each subject as one trial.
fn alike_as_elsewhere(
    belief: &Belief,
    threshold: Threshold,
    standing: Standing,
    levels: ClaimLevels,
) -> String {
    let Belief::Counts {
        sample,
        effective,
        clusters: Some(clusters),
        before,
        ..
    } = belief
    else {
        return String::new();
    };
    let each = clusters
        .of_one_outcome()
        .filter(|many| *many < effective.trials);
    let Some(Ok(one_each)) = each.map(|many| EffectiveSample::at_size(*sample, many)) else {
        return String::new();
    };
    let (p_below, p_at_least) = doubts_of_counts(one_each, true, threshold.value);
    // As at a first look, where more looks may follow.
    let at_looks = |p: f64| match before {
        Some(_) => (p / stats::SHARE_OF_A_LOOK).min(1.0),
        None => p,
    };
    let (p_not_met, p_met) = match threshold.direction {
        Direction::AtLeast => (at_looks(p_below), at_looks(p_at_least)),
        Direction::AtMost => (at_looks(p_at_least), at_looks(p_below)),
    };
    match standing {
        Standing::Supports if p_not_met > levels.met => words::alike_as_elsewhere(p_not_met),
        Standing::Denies if p_met > levels.missed => words::alike_as_elsewhere(p_met),
        _ => String::new(),
    }
}

/// That a claim supposes that every attempt of a table triggers what is judged, where the table does not count that.
fn each_triggers(named: Named<'_>, standing: Standing) -> String {
    let is_taken = named.finding.takes_each_run_to_trigger(named.trigger);
    match (standing, named.trigger) {
        (Standing::Supports | Standing::Denies, Some(trigger)) if is_taken => {
            words::each_triggers(trigger)
        }
        _ => String::new(),
    }
}

/// That a claim supposes that every kind of subjects was met, if it would not be made otherwise.
fn all_kinds_met(
    belief: &Belief,
    threshold: Threshold,
    standing: Standing,
    levels: ClaimLevels,
) -> String {
    let Belief::Counts {
        clusters: Some(clusters),
        ..
    } = belief
    else {
        return String::new();
    };
    if standing == Standing::Neither {
        return String::new();
    }
    let at_least = |value| Threshold {
        direction: Direction::AtLeast,
        value,
    };
    let (p_below, p_at_least) =
        clusters.with_unmet_kind(threshold.value, |value| doubts(belief, at_least(value)));
    let (p_not_met, p_met) = match threshold.direction {
        Direction::AtLeast => (p_below, p_at_least),
        Direction::AtMost => (p_at_least, p_below),
    };
    match standing {
        Standing::Supports if p_not_met > levels.met => {
            words::all_kinds_met(clusters.subjects(), p_not_met)
        }
        Standing::Denies if p_met > levels.missed => {
            words::all_kinds_met(clusters.subjects(), p_met)
        }
        _ => String::new(),
    }
}

/// What p-values against "not met" and "met" show.
pub(super) fn standing(p_not_met: f64, p_met: f64, levels: ClaimLevels) -> Standing {
    match (p_not_met <= levels.met, p_met <= levels.missed) {
        (true, false) => Standing::Supports,
        (false, true) => Standing::Denies,
        (true, true) | (false, false) => Standing::Neither,
    }
}

/// The p-value with which an earlier look showed the contrary of what all trials show now. Looks that contradict each other
/// decide nothing: trials of one rate hardly ever do, so these may be of several.
fn contradicted(
    belief: &Belief,
    threshold: Threshold,
    (p_not_met, p_met): (f64, f64),
    levels: ClaimLevels,
) -> Option<f64> {
    let (p_below, p_at_least) = over_looks::least_before(belief, threshold.value);
    let (p_not_met_then, p_met_then) = match threshold.direction {
        Direction::AtLeast => (p_below, p_at_least),
        Direction::AtMost => (p_at_least, p_below),
    };
    match standing(p_not_met, p_met, levels) {
        Standing::Supports => Some(p_met_then).filter(|p| *p <= levels.missed),
        Standing::Denies => Some(p_not_met_then).filter(|p| *p <= levels.met),
        Standing::Neither => None,
    }
}

/// How far the evidence doubts that the threshold is met, and that it is missed: p-values or
/// posterior probabilities of the contrary. Of counts with runs that reached no verdict the greatest of all that these may
/// have been.
pub(super) fn doubts(belief: &Belief, threshold: Threshold) -> (f64, f64) {
    let of_ends = belief.ends().iter().map(|end| doubts_of(end, threshold));
    // Whatever the runs without a verdict would have shown.
    of_ends.fold((0.0, 0.0), |all, one| (all.0.max(one.0), all.1.max(one.1)))
}

/// The same where each run has a verdict.
fn doubts_of(belief: &Belief, threshold: Threshold) -> (f64, f64) {
    let Threshold { direction, value } = threshold;
    let (at_least, at_most) = match belief {
        Belief::Counts {
            before: Some(_), ..
        } => over_looks::doubts(belief, value),
        Belief::Counts { .. } => {
            let counts = belief.counts();
            counts.map_or((1.0, 1.0), |counts| at_one_look(&counts, value))
        }
        Belief::Distribution {
            quantiles: Some(quantiles),
            ..
        } => (quantiles.cdf(value), quantiles.sf(value)),
        Belief::Distribution { posterior, .. } => (posterior.cdf(value), posterior.sf(value)),
        Belief::Known { bounds, .. } => return doubts_of_known(bounds, threshold),
        Belief::Range { ends, .. } => (
            doubt_of_end(&ends.least, threshold, Direction::AtLeast),
            doubt_of_end(&ends.greatest, threshold, Direction::AtMost),
        ),
    };
    match direction {
        Direction::AtLeast => (at_least, at_most),
        Direction::AtMost => (at_most, at_least),
    }
}

/// p-values of "the rate is below" and "the rate is at least the threshold", of counts that are looked at once.
pub(crate) fn at_one_look(counts: &CountsAtLook, threshold: f64) -> (f64, f64) {
    let at_size = doubts_of_counts(counts.effective, !counts.is_independent(), threshold);
    let by_cluster = counts.doubts_by_cluster(threshold);
    (at_size.0.max(by_cluster.0), at_size.1.max(by_cluster.1))
}

/// Whether a test of the claim "met" can err, and of "missed": a known value cannot, certainty is denied by one failure
/// and shown by no count.
pub(super) fn can_err(belief: &Belief, threshold: Threshold) -> bool {
    match belief {
        Belief::Known { .. } => false,
        Belief::Counts { .. } => threshold.value > 0.0 && threshold.value < 1.0,
        Belief::Distribution { .. } | Belief::Range { .. } => true,
    }
}

/// The probability that an end lies on the wrong side of a threshold's value; of one that is known as of a known value.
fn doubt_of_end(end: &End, threshold: Threshold, claimed: Direction) -> f64 {
    let value = threshold.value;
    // What a requirement allows by rounding counts for the claim that it is met, and against the other.
    let slack = match threshold.direction {
        Direction::AtLeast => -CERTAINTY,
        Direction::AtMost => CERTAINTY,
    };
    match (end, claimed) {
        (End::Known(end), Direction::AtLeast) if claimed == threshold.direction => {
            f64::from(u8::from(*end < value + slack))
        }
        (End::Known(end), Direction::AtLeast) => f64::from(u8::from(*end <= value + slack)),
        (End::Known(end), Direction::AtMost) if claimed == threshold.direction => {
            f64::from(u8::from(*end > value + slack))
        }
        (End::Known(end), Direction::AtMost) => f64::from(u8::from(*end >= value + slack)),
        (end, Direction::AtLeast) => end.at_most(value),
        (end, Direction::AtMost) => end.at_least(value),
    }
}

/// A computed probability meets a threshold, misses it, or its bounds straddle it.
fn doubts_of_known(bounds: &Interval, threshold: Threshold) -> (f64, f64) {
    let Threshold { direction, value } = threshold;
    let (met, missed) = match direction {
        Direction::AtLeast => (
            bounds.low >= value - CERTAINTY,
            bounds.high < value - CERTAINTY,
        ),
        Direction::AtMost => (
            bounds.high <= value + CERTAINTY,
            bounds.low > value + CERTAINTY,
        ),
    };
    let doubt = |shown: bool| if shown { 0.0 } else { 1.0 };
    (doubt(met), doubt(missed))
}

/// p-values of "the rate is below" and "the rate is at least the threshold". At a threshold of 1
/// no count shows the rate to be 1, and one failure shows that it is not.
pub(super) fn doubts_of_counts(
    sample: EffectiveSample,
    is_clustered: bool,
    threshold: f64,
) -> (f64, f64) {
    let (test_above, test_below) = match is_clustered {
        true => (
            clustered_test_above as fn(EffectiveSample, f64) -> f64,
            clustered_test_below as fn(EffectiveSample, f64) -> f64,
        ),
        false => (
            binomial_test_above as fn(EffectiveSample, f64) -> f64,
            binomial_test_below as fn(EffectiveSample, f64) -> f64,
        ),
    };
    let below = match threshold >= 1.0 {
        true => 1.0,
        false => test_above(sample, threshold),
    };
    let at_least = match threshold <= 0.0 {
        true => 1.0,
        false => test_below(sample, threshold),
    };
    (below, at_least)
}

/// Whether counts show the rate to be below a threshold, and to be at least as high.
pub(super) fn shown_below_and_above(
    sample: EffectiveSample,
    is_clustered: bool,
    threshold: f64,
    level: Confidence,
) -> (bool, bool) {
    let (below, at_least) = doubts_of_counts(sample, is_clustered, threshold);
    (at_least <= level.alpha(), below <= level.alpha())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Measure;
    use stats::{BetaPosterior, Sample};

    fn shown(belief: &Belief, direction: Direction, value: f64) -> Standing {
        let threshold = Threshold { direction, value };
        let (p_not_met, p_met) = doubts(belief, threshold);
        standing(p_not_met, p_met, ClaimLevels::both(Confidence::P95))
    }

    fn counts(successes: u64, trials: u64) -> Belief {
        let sample = Sample { successes, trials };
        Belief::Counts {
            sample,
            effective: sample.into(),
            clusters: None,
            before: None,
            completions: None,
        }
    }

    fn known(low: f64, high: f64) -> Belief {
        Belief::Known {
            value: low,
            bounds: Interval { low, high },
            is_range: false,
        }
    }

    #[test]
    fn counts_need_the_exact_test_to_speak() {
        use Direction::{AtLeast, AtMost};
        // 0.95^59 = 0.048 and 0.95^58 = 0.051: 59 of 59 is the least that shows 95 %.
        assert_eq!(shown(&counts(59, 59), AtLeast, 0.95), Standing::Supports);
        assert_eq!(shown(&counts(58, 58), AtLeast, 0.95), Standing::Neither);
        assert_eq!(shown(&counts(0, 59), AtMost, 0.05), Standing::Supports);
        assert_eq!(shown(&counts(0, 58), AtMost, 0.05), Standing::Neither);
        assert_eq!(shown(&counts(88, 100), AtLeast, 0.95), Standing::Denies);
        assert_eq!(shown(&counts(12, 100), AtMost, 0.05), Standing::Denies);
    }

    #[test]
    fn certainty_takes_one_failure_to_deny_and_no_trials_to_show() {
        use Direction::{AtLeast, AtMost};
        assert_eq!(
            shown(&counts(1_000_000, 1_000_000), AtLeast, 1.0),
            Standing::Neither
        );
        assert_eq!(
            shown(&counts(999_999, 1_000_000), AtLeast, 1.0),
            Standing::Denies
        );
        assert_eq!(shown(&counts(0, 1_000_000), AtMost, 0.0), Standing::Neither);
        assert_eq!(shown(&counts(1, 1_000_000), AtMost, 0.0), Standing::Denies);
    }

    #[test]
    fn bounds_that_straddle_the_threshold_say_nothing() {
        use Direction::{AtLeast, AtMost};
        assert_eq!(shown(&known(0.94, 0.96), AtLeast, 0.95), Standing::Neither);
        assert_eq!(shown(&known(0.96, 0.97), AtLeast, 0.95), Standing::Supports);
        assert_eq!(shown(&known(0.93, 0.94), AtLeast, 0.95), Standing::Denies);
        assert_eq!(shown(&known(0.96, 0.97), AtMost, 0.95), Standing::Denies);
        assert_eq!(shown(&known(0.0, 0.0), AtMost, 0.0), Standing::Supports);
        assert_eq!(
            shown(&known(1.0 - 1e-12, 1.0), AtLeast, 1.0),
            Standing::Supports
        );
        assert_eq!(shown(&known(0.998, 0.998), AtLeast, 1.0), Standing::Denies);
    }

    #[test]
    fn distributions_speak_by_their_tails() {
        let posterior = BetaPosterior::new(86.7, 13.3).unwrap();
        let belief = Belief::Distribution {
            value: 0.88,
            posterior,
            quantiles: None,
        };
        use Direction::AtLeast;
        assert_eq!(shown(&belief, AtLeast, 0.6), Standing::Supports);
        assert_eq!(shown(&belief, AtLeast, 0.87), Standing::Neither);
        assert_eq!(shown(&belief, AtLeast, 0.95), Standing::Denies);
    }

    fn people(counts: &[u64]) -> Belief {
        let counts = counts.iter();
        let people: Vec<Sample> = counts
            .map(|&successes| Sample {
                successes,
                trials: 5,
            })
            .collect();
        let measure = Measure::of_clusters(&people, Confidence::P95).expect("counts");
        Belief::of(&measure).expect("counts")
    }

    /// At the level of one of four requirements: 99 of 100 comes out in 4.7 % of cohorts whose rate is 90 % and who differ by
    /// a correlation of 0.3.
    #[test]
    fn one_failure_of_twenty_people_is_no_proof_at_a_small_level() {
        let mut counts = [5; 20];
        counts[7] = 4;
        let belief = people(&counts);
        let threshold = Threshold {
            direction: Direction::AtLeast,
            value: 0.9,
        };
        let Belief::Counts { effective, .. } = belief else {
            unreachable!()
        };
        let at_the_size = clustered_test_above(effective, 0.9);
        let (not_met, _) = doubts(&belief, threshold);
        assert!(at_the_size < 0.0125, "{at_the_size}");
        assert!(not_met > 0.0125, "{not_met}");
    }

    #[test]
    fn a_claim_needs_both_tests() {
        for counts in [[5, 4, 5, 0, 5, 3, 5, 5], [2, 1, 0, 3, 1, 2, 5, 0]] {
            let belief = people(&counts);
            let Belief::Counts {
                effective,
                clusters: Some(clusters),
                ..
            } = &belief
            else {
                panic!("the counts tell how alike trials are")
            };
            for value in [0.1, 0.3, 0.5, 0.8, 0.95] {
                let direction = Direction::AtLeast;
                let (not_met, met) = doubts(&belief, Threshold { direction, value });
                let (above, below) = clusters.doubts(value);
                assert_eq!(not_met, above.max(clustered_test_above(*effective, value)));
                assert!(met >= below);
            }
        }
    }
}
