//! The statistics of one pair of rates.
//!
//! # Assumes
//! Both sides are independent of each other. Counts are of independent trials, or of people as [`super::by_cluster`] has
//! it, of a size fixed in advance (else [`super::past`]); where runs have no verdict, each may be either, and the greatest
//! p-value counts. A distribution is the posterior of constants by Jeffreys' prior.

mod values;

use super::Belief;
use super::by_likelihood::{self, Claim};
use super::ends::{self, End, PlannedSide};
use super::past::{Asked, Before, Past};
use super::uncertain::Uncertain;
use crate::looks::completed;
use stats::{
    BetaPosterior, Confidence, DifferenceVariance, EffectiveSample, Interval, PosteriorPlaces,
    Sample, binomial_test_above, binomial_test_below, binomial_test_two_sided, boschloo_exact,
    fisher_exact, probability_greater, probability_within,
};
use std::cell::OnceCell;
use std::rc::Rc;
use values::{decided, greatest, nearest};

/// The part of the level at which plans test equivalence of counts.
const PLANNED: f64 = 0.9;

/// The factor by which the approximate p-value of equivalence may miss the exact one, of few trials.
const NEAR: f64 = 8.0;

/// So many trials of the smaller side are few.
const FEW: u64 = 200;

/// Two rates that are to be compared at a margin.
pub(super) struct Pair {
    first: Belief,
    second: Belief,
    margin: f64,
    /// What was known at the looks before this one, and what the tests made of it; `None` if the sizes of both samples
    /// were fixed in advance.
    past: Option<(Before, Past)>,
    /// The looks up to and with this one, for those to come.
    past_of_next: OnceCell<Past>,
    /// Where a plan asks what more counts would show against a side that is uncertain otherwise: that side, for means over
    /// it that are taken thousands of times. A conclusion has none and integrates.
    places: Option<Rc<PlannedSide>>,
    /// This pair's uncertain side, for plans.
    places_of_next: OnceCell<Option<Rc<PlannedSide>>>,
    /// The pairs of what each side may be where it has runs without a verdict; none where each run has one.
    ends: Vec<Pair>,
    /// What is asked for several times and takes long: the answers of this look.
    answered: Answered,
}

/// Answers that are worked out once.
#[derive(Default)]
struct Answered {
    difference_by_likelihood: OnceCell<f64>,
    equivalence_by_likelihood: OnceCell<f64>,
    p_difference: OnceCell<f64>,
    p_equivalence: OnceCell<Option<f64>>,
    probability_within: OnceCell<f64>,
}

impl Pair {
    pub fn new(first: Belief, second: Belief, margin: f64) -> Self {
        let has_undecided = first.has_undecided() || second.has_undecided();
        let pairs = |_: ()| {
            let firsts = first.ends().iter();
            let with_all = |one: &Belief| {
                let seconds = second.ends().iter().cloned();
                let pairs = seconds.map(|other| Self::new(one.clone(), other, margin));
                pairs.collect::<Vec<Self>>()
            };
            firsts.flat_map(with_all).collect()
        };
        Self {
            ends: has_undecided.then_some(()).map(pairs).unwrap_or_default(),
            first,
            second,
            margin,
            past: None,
            past_of_next: OnceCell::new(),
            places: None,
            places_of_next: OnceCell::new(),
            answered: Answered::default(),
        }
    }

    /// The greatest of a p-value over all that runs without a verdict may have been; `None` where each run has one.
    fn over_ends(&self, p: impl Fn(&Self) -> f64) -> Option<f64> {
        (!self.ends.is_empty()).then(|| self.ends.iter().map(p).fold(0.0, f64::max))
    }

    /// Whether the rates of both sides may be the same for what runs without a verdict may have been.
    fn may_be_equal(&self) -> bool {
        let (first, second) = (self.first.values(), self.second.values());
        first.low <= second.high && second.low <= first.high
    }

    /// The same after looks at some of the same trials, to be looked at again with more.
    pub fn looked_at(mut self, before: Before) -> Self {
        let seconds = self.second.ends().len();
        let undecided = [self.first.undecided(), self.second.undecided()];
        let ends = std::mem::take(&mut self.ends).into_iter().enumerate();
        let looked_at = |(place, end): (usize, Self)| {
            let then = [
                completed(&before[0], (place / seconds, undecided[0]), &end.first),
                completed(&before[1], (place % seconds, undecided[1]), &end.second),
            ];
            end.looked_at(then)
        };
        self.ends = ends.map(looked_at).collect();
        let past = Past::new(&before, self.margin);
        self.past = Some((before, past));
        self
    }

    /// The same margin for what is planned: beliefs of more trials, looked at after these if the pair is looked at again.
    pub fn with(&self, first: Belief, second: Belief) -> Self {
        let mut next = Self::new(first, second, self.margin);
        next.places = self
            .places_of_next
            .get_or_init(|| self.places_of_distribution())
            .clone();
        if let Some((_, past)) = &self.past {
            let past = self.past_of_next.get_or_init(|| past.and(self));
            next.past = Some((Before::default(), past.clone()));
        }
        next
    }

    /// The places of the side that is a distribution or has uncertain ends, if the other has counts.
    fn places_of_distribution(&self) -> Option<Rc<PlannedSide>> {
        use Belief::{Counts, Distribution, Range};
        let uncertain = match (&self.first, &self.second) {
            (uncertain, Counts { .. }) | (Counts { .. }, uncertain) => uncertain,
            _ => return None,
        };
        Some(Rc::new(match uncertain {
            Distribution { posterior, .. } => PlannedSide::Number(PosteriorPlaces::new(posterior)),
            Range { ends, .. } => PlannedSide::Ends {
                least: (&ends.least).into(),
                greatest: (&ends.greatest).into(),
                is_range: ends.is_range,
            },
            _ => return None,
        }))
    }

    /// The uncertain side's places with the posterior of the counts, in a plan.
    fn planned(&self) -> Option<(&PlannedSide, BetaPosterior)> {
        let places = self.places.as_deref()?;
        let counts = match (&self.first, &self.second) {
            (counts @ Belief::Counts { .. }, _) | (_, counts) => counts.posterior()?,
        };
        Some((places, counts))
    }

    /// What was known at the looks before this one.
    pub fn before(&self) -> Option<&Before> {
        self.past.as_ref().map(|(before, _)| before)
    }

    /// The number of this look at the pair; `None` if it is the only one.
    pub fn look(&self) -> Option<u64> {
        self.past.as_ref().map(|(_, past)| past.number(self))
    }

    /// The p-value over all looks.
    fn over_looks(&self, asked: Asked, once: f64) -> f64 {
        match &self.past {
            Some((_, past)) => past.p(self, asked, once),
            None => once,
        }
    }

    /// Whether a difference is shown at this level, by the quickest test.
    pub fn differs(&self, level: Confidence) -> bool {
        let at_size = match self.p_by_fisher_at_size() {
            Some(p) => (Asked::DifferenceByFisher, p),
            None => (Asked::Difference, self.p_difference_at_size()),
        };
        self.shows(at_size, Claim::Difference, level)
    }

    /// Whether a test at the effective size and counts by subject both show it, over all looks. The quicker test comes first,
    /// since what it does not show is not shown.
    fn shows(&self, (asked, at_size): (Asked, f64), claim: Claim, level: Confidence) -> bool {
        let is_small = |p: f64| {
            let once = at_size.max(p);
            match &self.past {
                Some((_, past)) => past.shows(self, asked, once, level.alpha()),
                None => once <= level.alpha(),
            }
        };
        let (one, other) = (&self.first, &self.second);
        let is_one_pair = self.ends.is_empty();
        is_small(0.0) && (!is_one_pair || by_likelihood::shows(one, other, claim, is_small))
    }

    pub fn first(&self) -> &Belief {
        &self.first
    }

    pub fn second(&self) -> &Belief {
        &self.second
    }

    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Second minus first; of a range over all schedulers, its value that is nearest to the other. Of counts those with a
    /// verdict.
    pub fn difference(&self) -> f64 {
        let (first, second) = match self.ends.is_empty() {
            true => self.nearest(),
            false => nearest(decided(&self.first), decided(&self.second)),
        };
        second - first
    }

    /// How wide the ranges over all schedulers are, with which agreement says the less; empty if there are none.
    pub fn range_in_words(&self) -> String {
        let widths = [&self.first, &self.second].map(Belief::width_of_range);
        let Some(width) = widths.into_iter().flatten().max_by(f64::total_cmp) else {
            return String::new();
        };
        let meaning = match width > self.margin {
            true if self.is_too_wide() => {
                ", more than the margin: that some scheduler comes so near does not make the model agree"
            }
            true => ", more than the margin: agreement of so wide ranges says little",
            false => "",
        };
        format!(
            " The model leaves choices open; over all schedulers its value ranges over {}{meaning}.",
            super::words::points(width)
        )
    }

    /// The estimates; of ranges, and of what runs without a verdict leave open, their values that are nearest to each other.
    fn nearest(&self) -> (f64, f64) {
        nearest(self.first.values(), self.second.values())
    }

    /// Whether the estimates are less than the margin apart; with runs without a verdict, whether they may be.
    pub fn is_inside_margin(&self) -> bool {
        let (first, second) = self.nearest();
        // Estimates that are the margin apart but for rounding are not less than it apart.
        (second - first).abs() + 1e-12 < self.margin
    }

    pub fn difference_interval(&self, confidence: Confidence) -> Interval {
        let ends = self
            .ends
            .iter()
            .map(|it| it.difference_interval(confidence));
        let hull = ends.reduce(|one, other| Interval {
            low: one.low.min(other.low),
            high: one.high.max(other.high),
        });
        if let Some(hull) = hull {
            return hull;
        }
        let (first, second) = self.nearest();
        let side = |belief: &Belief, nearest: f64| match belief {
            Belief::Known { is_range: true, .. } => (
                nearest,
                Interval {
                    low: nearest,
                    high: nearest,
                },
            ),
            Belief::Range { ends, .. } if ends.is_range => {
                (nearest, ends.interval_of_nearest(nearest, confidence))
            }
            belief => (nearest, belief.interval(confidence)),
        };
        stats::difference_interval(side(&self.second, second), side(&self.first, first))
    }

    /// p-value of "no difference", or twice the smaller posterior tail, over all looks.
    pub fn p_difference(&self) -> f64 {
        if let Some(greatest) = self.over_ends(Self::p_difference) {
            return if self.may_be_equal() { 1.0 } else { greatest };
        }
        self.over_looks(Asked::Difference, self.p_difference_once())
    }

    /// The same if this was the only look.
    pub fn p_difference_once(&self) -> f64 {
        let answer = &self.answered.p_difference;
        *answer.get_or_init(|| {
            let at_size = self.p_difference_at_size();
            at_size.max(self.difference_by_likelihood())
        })
    }

    /// What counts by subject say of "no difference", if it is the only look and each run has a verdict; the ends say it of
    /// themselves.
    pub fn difference_by_likelihood(&self) -> f64 {
        let answer = &self.answered.difference_by_likelihood;
        *answer.get_or_init(|| self.p_by_likelihood(Claim::Difference))
    }

    /// The same of "the difference is the margin or more".
    pub fn equivalence_by_likelihood(&self) -> f64 {
        let answer = &self.answered.equivalence_by_likelihood;
        *answer.get_or_init(|| self.p_by_likelihood(Claim::Within(self.margin)))
    }

    fn p_by_likelihood(&self, claim: Claim) -> f64 {
        match self.ends.is_empty() {
            true => by_likelihood::p_value(&self.first, &self.second, claim),
            false => 0.0,
        }
    }

    fn p_difference_at_size(&self) -> f64 {
        use Belief::{Counts, Known};
        if let Some(greatest) = self.over_ends(Self::p_difference_once) {
            return if self.may_be_equal() { 1.0 } else { greatest };
        }
        if let Some((places, counts)) = self.planned() {
            return places.p_difference(&counts);
        }
        if let Some((first, second)) = self.as_ends() {
            return ends::p_difference(&first, &second);
        }
        match (&self.first, &self.second) {
            (
                Counts {
                    sample: a,
                    effective: ea,
                    ..
                },
                Counts {
                    sample: b,
                    effective: eb,
                    ..
                },
            ) => at_effective_size(boschloo_exact, (*a, *ea), (*b, *eb)),
            (
                Counts {
                    sample, effective, ..
                },
                Known { bounds, .. },
            )
            | (
                Known { bounds, .. },
                Counts {
                    sample, effective, ..
                },
            ) => binomial_at_effective_size(*sample, *effective, bounds),
            (Known { bounds: a, .. }, Known { bounds: b, .. }) => {
                if a.low > b.high || b.low > a.high {
                    0.0
                } else {
                    1.0
                }
            }
            (first, second) => match (first.posterior(), second.posterior()) {
                // A distribution is what counts said: two posteriors are further apart than the counts by an exact test.
                (Some(a), Some(b)) => {
                    let exact = as_counts(first).zip(as_counts(second));
                    let exact = exact.map_or(0.0, |(a, b)| at_effective_size(boschloo_exact, a, b));
                    posterior_difference(&a, &b).max(exact)
                }
                (Some(a), None) => tails_beyond(&a, &second.interval(Confidence::P95)),
                (None, Some(b)) => tails_beyond(&b, &first.interval(Confidence::P95)),
                (None, None) => 1.0,
            },
        }
    }

    /// Fisher's p-value of "no difference" between two counts: known everywhere, quickly found, and
    /// never below the one that decides.
    pub fn p_by_fisher(&self) -> Option<f64> {
        // With runs without a verdict there is one p-value, the greatest.
        if !self.ends.is_empty() {
            return None;
        }
        let once = self.p_by_fisher_once()?;
        Some(self.over_looks(Asked::DifferenceByFisher, once))
    }

    /// The same if this was the only look.
    pub fn p_by_fisher_once(&self) -> Option<f64> {
        let at_size = self.p_by_fisher_at_size()?;
        Some(at_size.max(self.difference_by_likelihood()))
    }

    fn p_by_fisher_at_size(&self) -> Option<f64> {
        if !self.ends.is_empty() {
            return None;
        }
        match (&self.first, &self.second) {
            (
                Belief::Counts {
                    sample: a,
                    effective: ea,
                    ..
                },
                Belief::Counts {
                    sample: b,
                    effective: eb,
                    ..
                },
            ) => Some(at_effective_size(fisher_exact, (*a, *ea), (*b, *eb))),
            _ => None,
        }
    }

    /// p-value of "the difference is the margin or more"; `None` where a side is a distribution
    /// and a posterior probability takes its place.
    pub fn p_equivalence(&self) -> Option<f64> {
        let ends = self.ends.iter().map(Self::p_equivalence);
        if let Some(greatest) = greatest(ends) {
            return greatest;
        }
        let once = self.p_equivalence_once()?;
        Some(self.over_looks(Asked::Equivalence, once))
    }

    /// The p-value of equivalence, or the posterior probability that the difference is the margin or more, if this was
    /// the only look.
    pub fn doubt_of_equivalence_once(&self) -> f64 {
        let p = self.p_equivalence_once();
        p.unwrap_or_else(|| 1.0 - self.probability_within())
    }

    /// The same p-value if this was the only look.
    pub fn p_equivalence_once(&self) -> Option<f64> {
        let answer = &self.answered.p_equivalence;
        *answer.get_or_init(|| {
            let at_size = self.p_equivalence_at_size();
            at_size.map(|p| p.max(self.equivalence_by_likelihood()))
        })
    }

    fn p_equivalence_at_size(&self) -> Option<f64> {
        use Belief::{Counts, Known};
        let ends = self.ends.iter().map(Self::p_equivalence_once);
        if let Some(greatest) = greatest(ends) {
            return greatest;
        }
        match (&self.first, &self.second) {
            (
                Counts {
                    sample: a,
                    effective: ea,
                    ..
                },
                Counts {
                    sample: b,
                    effective: eb,
                    ..
                },
            ) => {
                let test = |a, b| {
                    let exact = stats::exact_equivalence(a, b, self.margin);
                    // Of so many trials that the exact test has none.
                    let by_score = || stats::score_equivalence(a, b, self.margin);
                    exact.or_else(by_score).unwrap_or(1.0)
                };
                Some(at_effective_size(test, (*a, *ea), (*b, *eb)))
            }
            (
                Counts {
                    sample, effective, ..
                },
                known @ Known { .. },
            )
            | (
                known @ Known { .. },
                Counts {
                    sample, effective, ..
                },
            ) => Some(exact_tost(
                *sample,
                *effective,
                &to_agree_with(known),
                self.margin,
            )),
            (a @ Known { .. }, b @ Known { .. }) => {
                Some(if within_for_certain(a, b, self.margin) {
                    0.0
                } else {
                    1.0
                })
            }
            _ => None,
        }
    }

    /// Both sides as ends, where one is a range whose ends are uncertain.
    fn as_ends(&self) -> Option<(ends::Side, ends::Side)> {
        let is_uncertain = |belief: &Belief| matches!(belief, Belief::Range { .. });
        (is_uncertain(&self.first) || is_uncertain(&self.second))
            .then(|| (side(&self.first), side(&self.second)))
    }

    /// Posterior probability that the difference is below the margin, no more than counts by subject let it be.
    pub fn probability_within(&self) -> f64 {
        let answer = &self.answered.probability_within;
        *answer.get_or_init(|| self.find_probability_within())
    }

    fn find_probability_within(&self) -> f64 {
        if let Some(beyond) = self.over_ends(|end| 1.0 - end.probability_within()) {
            return 1.0 - beyond;
        }
        let by_likelihood = 1.0 - self.equivalence_by_likelihood();
        self.probability_within_at_size().min(by_likelihood)
    }

    fn probability_within_at_size(&self) -> f64 {
        if let Some((places, counts)) = self.planned() {
            return places.probability_within(&counts, self.margin);
        }
        if let Some((first, second)) = self.as_ends() {
            return ends::probability_within(&first, &second, self.margin);
        }
        match (self.first.posterior(), self.second.posterior()) {
            (Some(a), Some(b)) => probability_within(&a, &b, self.margin),
            (Some(a), None) => near(&a, &to_agree_with(&self.second), self.margin),
            (None, Some(b)) => near(&b, &to_agree_with(&self.first), self.margin),
            (None, None) => f64::from(u8::from(within_for_certain(
                &self.first,
                &self.second,
                self.margin,
            ))),
        }
    }

    /// Whether agreement within the margin is shown at this level.
    pub fn shows_agreement(&self, level: Confidence) -> bool {
        self.is_inside_margin() && self.is_shown(self.p_equivalence(), level)
    }

    /// The same for plans, which ask it of thousands of outcomes: between two counts by the larger p-value of Agresti and
    /// Caffo's variance and of the score, at [`PLANNED`] of the level, which shows it about as often as the exact test
    /// (`stats::exact_equivalence` has the table), and of counts by subject by their likelihood, too.
    pub fn would_show_agreement(&self, level: Confidence) -> bool {
        use Belief::Counts;
        let (
            Counts {
                sample: a,
                effective: ea,
                ..
            },
            Counts {
                sample: b,
                effective: eb,
                ..
            },
        ) = (&self.first, &self.second)
        else {
            return self.shows_agreement(level);
        };
        let test = |a, b| {
            let tost = stats::tost(a, b, self.margin, DifferenceVariance::AgrestiCaffo);
            let score = stats::score_equivalence(a, b, self.margin).unwrap_or(1.0);
            tost.map_or(1.0, |tost| tost.p_value()).max(score)
        };
        if !self.is_inside_margin() {
            return false;
        }
        let once = (at_effective_size(test, (*a, *ea), (*b, *eb)) / PLANNED).min(1.0);
        let asked = (Asked::Equivalence, once);
        once <= level.alpha() && self.shows(asked, Claim::Within(self.margin), level)
    }

    /// Whether both sides are counts and one has so few trials that the approximate tests of plans may miss the exact one.
    pub fn is_of_few(&self) -> bool {
        let trials = [&self.first, &self.second].map(|belief| match belief {
            Belief::Counts { sample, .. } => Some(sample.trials),
            _ => None,
        });
        matches!(trials, [Some(one), Some(other)] if one.min(other) <= FEW)
    }

    /// The same by the comparison's own test where that may say otherwise: of few trials, and within [`NEAR`] of the level.
    pub fn will_show_agreement(&self, level: Confidence) -> bool {
        if !self.is_of_few() || !self.is_inside_margin() {
            return self.would_show_agreement(level);
        }
        let near =
            |alpha: f64| Confidence::new(1.0 - alpha).map(|it| self.would_show_agreement(it));
        let (strict, loose) = (
            near(level.alpha() / NEAR),
            near((level.alpha() * NEAR).min(0.5)),
        );
        match (strict, loose) {
            (Ok(true), _) => true,
            (_, Ok(false)) => false,
            _ => self.shows_agreement(level),
        }
    }

    /// Whether one side alone is a range over all schedulers, and wider than the margin: some schedulers are farther than it away.
    pub fn is_too_wide(&self) -> bool {
        match [&self.first, &self.second].map(Belief::width_of_range) {
            [Some(width), None] | [None, Some(width)] => width > self.margin,
            [Some(_), Some(_)] | [None, None] => false,
        }
    }

    /// Whether equivalence is shown, of the p-value where there is one, else by the posterior probability; of no range that is too wide.
    pub fn is_shown(&self, p_equivalence: Option<f64>, level: Confidence) -> bool {
        if self.is_too_wide() {
            return false;
        }
        if p_equivalence.is_none() && !self.ends.is_empty() {
            return self.ends.iter().all(|end| end.is_shown(None, level));
        }
        if let (None, Some((_, past))) = (p_equivalence, &self.past) {
            let once = self.doubt_of_equivalence_once();
            return past.shows(self, Asked::Equivalence, once, level.alpha());
        }
        match p_equivalence {
            Some(p) => p <= level.alpha(),
            None => self.probability_within() >= level.level(),
        }
    }
}

/// Whether every value between the ends of a side is one that its model allows.
fn is_range(belief: &Belief) -> bool {
    belief.width_of_range().is_some()
}

/// A side as ends; counts by their posterior.
fn side(belief: &Belief) -> ends::Side {
    let (least, greatest) = match (belief, belief.posterior()) {
        (Belief::Range { ends, .. }, _) => (ends.least.clone(), ends.greatest.clone()),
        (_, Some(shape)) => {
            let quantiles = match belief {
                Belief::Distribution { quantiles, .. } => quantiles.clone(),
                _ => None,
            };
            let end = End::Uncertain(Uncertain { shape, quantiles });
            (end.clone(), end)
        }
        (other, None) => {
            let bounds = other.interval(Confidence::P95);
            (End::Known(bounds.low), End::Known(bounds.high))
        }
    };
    ends::Side {
        least,
        greatest,
        is_range: is_range(belief),
    }
}

/// An exact test at the neighbouring whole numbers with the largest p-value.
fn at_effective_size(
    test: impl Fn(Sample, Sample) -> f64,
    first: (Sample, EffectiveSample),
    second: (Sample, EffectiveSample),
) -> f64 {
    let seconds = stats::whole_counts(second.0, second.1);
    let mut largest = 0.0_f64;
    for a in stats::whole_counts(first.0, first.1) {
        for b in &seconds {
            largest = largest.max(test(a, *b));
        }
    }
    largest
}

/// The counts of a side, or those of which a distribution is the posterior by Jeffreys' prior; none where it is narrower or
/// wider than that of any counts.
fn as_counts(belief: &Belief) -> Option<(Sample, EffectiveSample)> {
    match belief {
        Belief::Counts {
            sample, effective, ..
        } => Some((*sample, *effective)),
        Belief::Distribution { posterior, .. } => {
            let (alpha, beta) = posterior.parameters();
            let (successes, failures) = (alpha - 0.5, beta - 0.5);
            let trials = successes + failures;
            let is_of_counts = successes > -1e-6 && failures > -1e-6 && trials >= 1.0;
            let successes = successes.clamp(0.0, trials);
            // One trial more than there are, so that what is rounded is rounded down.
            let sample = Sample::new(successes.ceil() as u64, trials.ceil() as u64 + 1).ok()?;
            is_of_counts.then_some((sample, EffectiveSample { successes, trials }))
        }
        Belief::Known { .. } | Belief::Range { .. } => None,
    }
}

/// The two-sided exact test against the bound nearest to the rate.
fn binomial_at_effective_size(
    sample: Sample,
    effective: EffectiveSample,
    bounds: &Interval,
) -> f64 {
    let rate = effective.successes / effective.trials;
    let nearest = rate.max(bounds.low).min(bounds.high);
    stats::whole_counts(sample, effective)
        .into_iter()
        .map(|whole| binomial_test_two_sided(whole, nearest))
        .fold(0.0, f64::max)
}

fn posterior_difference(first: &BetaPosterior, second: &BetaPosterior) -> f64 {
    let (above, below) = (
        probability_greater(first, second),
        probability_greater(second, first),
    );
    (2.0 * above.min(below)).min(1.0)
}

/// Twice the smaller posterior probability of lying beyond the bounds.
fn tails_beyond(posterior: &BetaPosterior, bounds: &Interval) -> f64 {
    (2.0 * posterior.cdf(bounds.high).min(posterior.sf(bounds.low))).min(1.0)
}

/// A bound with a margin added, without what rounding adds: no rate lies beyond 1, but counts do not speak against 1 because
/// a computed 0.9 is a little more.
pub(super) fn without_rounding(bound: f64) -> f64 {
    const ROUNDING: f64 = 1e-9;
    let nearest = bound.clamp(0.0, 1.0);
    match (bound - nearest).abs() <= ROUNDING {
        true => nearest,
        false => bound,
    }
}

/// Two one-sided exact tests of a count against a probability between bounds, at the neighbouring whole numbers with the
/// largest p-value.
fn exact_tost(sample: Sample, effective: EffectiveSample, bounds: &Interval, margin: f64) -> f64 {
    let [floor, ceiling] = [bounds.high - margin, bounds.low + margin].map(without_rounding);
    let both = |whole: Sample| {
        let not_below = match floor < 0.0 {
            true => 0.0,
            false => binomial_test_above(whole, floor),
        };
        let not_above = match ceiling > 1.0 {
            true => 0.0,
            false => binomial_test_below(whole, ceiling),
        };
        not_below.max(not_above)
    };
    let all = stats::whole_counts(sample, effective).into_iter();
    all.map(both).fold(0.0, f64::max)
}

/// Probability of being within the margin of every value between the bounds.
fn near(posterior: &BetaPosterior, bounds: &Interval, margin: f64) -> f64 {
    posterior.probability_between(bounds.high - margin, bounds.low + margin)
}

/// The bounds that a rate has to be near to: of a known number whose value is somewhere between its bounds, both; of a
/// range, of which each value is one that the model allows, either (so the ends change places).
pub(super) fn to_agree_with(known: &Belief) -> Interval {
    let bounds = known.interval(Confidence::P95);
    match known {
        Belief::Known { is_range: true, .. } => Interval {
            low: bounds.high,
            high: bounds.low,
        },
        _ => bounds,
    }
}

/// Two known numbers wherever they are between their bounds; a number and some value of a range; two ranges, if each
/// value of one has one of the other within the margin.
fn within_for_certain(first: &Belief, second: &Belief, margin: f64) -> bool {
    let (a, b) = (
        first.interval(Confidence::P95),
        second.interval(Confidence::P95),
    );
    match (is_range(first), is_range(second)) {
        (false, false) => a.high - b.low < margin && b.high - a.low < margin,
        (true, true) => (a.low - b.low).abs() < margin && (a.high - b.high).abs() < margin,
        (true, false) => b.low > a.low - margin && b.high < a.high + margin,
        (false, true) => a.low > b.low - margin && a.high < b.high + margin,
    }
}

#[cfg(test)]
mod tests;
