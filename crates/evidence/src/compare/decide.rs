//! The chance that further trials decide a pair, and how few it takes.
//!
//! # Definition
//! `n1` and `n2` further trials *decide* when the tests of the comparison, applied to all trials
//! together, show agreement or a difference. Given what is known now (Jeffreys' posterior of each
//! rate), the further successes have beta-binomial distributions, and
//!
//! ```text
//! chance(n1, n2) = sum over y1, y2 of P(Y1 = y1) P(Y2 = y2) [decided at (s1 + y1, s2 + y2)]
//! ```
//!
//! The rates are not taken for known, so that a plan after 0 of 5 does not rest on a rate of 0.
//! A *plan* is the cheapest `(n1, n2)` of a kind with `chance >= power`: trials of one side alone,
//! or of both, whose shares in the cost are chosen freely.
//!
//! # Source
//! A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in clinical trial design" (2005), with
//! the decisions of this project. Conflicts are planned at the level that closed testing leaves the
//! pair (see `further`), and by Fisher's test, which is never more powerful than Boschloo's and much
//! quicker: a decision is a little likelier than planned. Agreement of two counts is planned by the comparison's own test where
//! trials are few, and else by approximate ones at a lower level, which show it about as often
//! (`stats::exact_equivalence` has the table).
//!
//! # Deviation
//! For each outcome of one side, the undecided outcomes of the other are two runs about equality,
//! whose ends are found by galloping. Of a side with more than [`REPRESENTATIVES`] outcomes that
//! many equally likely ones stand for all. Sizes are searched by a normal approximation and then
//! settled by the chance itself, to within 2 %, of few trials by larger steps where the comparison's own test asks for more; whole numbers make it a sawtooth, so that some
//! smaller sizes may reach it, too.
//!
//! # Assumes
//! Further trials come from the rates of those so far, of which Jeffreys' posteriors are known; both sides are independent
//! of each other. Further people are as alike as those so far. What is computed stays as it is.
//!
//! # Guarantee
//! The chance is exact for up to [`REPRESENTATIVES`] trials of one side, and else within 0.01
//! (tested against the full sum); of people whose counts are known by person it is held against the comparison's own tests (`people`). Where one side is a model's answer with uncertain constants, the posterior probabilities
//! behind it are within 4e-3 for each end ([`stats::PosteriorPlaces`]). Clustered sides count trials at their design effect of today, of further subjects with as
//! many trials each: more trials of the same subjects decide less often (`promised`).

mod people;
mod side;

use super::{Belief, Levels, pair::Pair};
use side::Side;
use stats::Confidence;
use stats::special::{normal_cdf, normal_quantile};

/// Outcomes of one side that stand for all.
const REPRESENTATIVES: usize = 48;

/// Trials of one side beyond which no plan is made.
const MOST_TRIALS: f64 = 1e7;

/// Shares of the cost that are tried for the first side, in sixteenths.
const SIXTEENTHS: f64 = 16.0;

/// Trials that would decide with at least the wanted chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Further trials of each side.
    pub trials: (u64, u64),
    /// What they cost, in the unit of the costs.
    pub cost: f64,
    /// The chance that they decide.
    pub chance: f64,
    /// The chance that they show agreement.
    pub agreement: f64,
    /// The chance that they show a conflict.
    pub conflict: f64,
}

impl Plan {
    /// So many trials at these costs of one, with the chances of agreement and of a conflict.
    fn of(trials: (u64, u64), costs: (f64, f64), (agreement, conflict): (f64, f64)) -> Self {
        Self {
            trials,
            cost: trials.0 as f64 * costs.0 + trials.1 as f64 * costs.1,
            chance: (agreement + conflict).min(1.0),
            agreement,
            conflict,
        }
    }
}

/// The kinds of plan, each `None` where no number of such trials has the wanted chance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plans {
    /// Of the first side alone.
    pub first: Option<Plan>,
    /// Of the second side alone.
    pub second: Option<Plan>,
    /// Of both.
    pub both: Option<Plan>,
}

impl Plans {
    /// All plans, the cheapest first; one for both sides only where it is cheaper than for one.
    pub fn by_cost(&self) -> Vec<Plan> {
        let mut alone: Vec<Plan> = [self.first, self.second].into_iter().flatten().collect();
        alone.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let least = alone.first().map_or(f64::INFINITY, |plan| plan.cost);
        let both = self.both.filter(|plan| plan.cost < least);
        both.into_iter().chain(alone).collect()
    }

    /// The cheapest of them.
    pub fn cheapest(&self) -> Option<Plan> {
        self.by_cost().first().copied()
    }
}

/// A pair whose decision is planned.
pub(crate) struct Planning<'a> {
    pair: &'a Pair,
    agreement: Confidence,
    conflict: Confidence,
    power: f64,
    open: (bool, bool),
    /// The level at which the size of a count by people is that of its interval.
    confidence: Confidence,
}

impl<'a> Planning<'a> {
    /// Plans for a decision, where a conflict is shown at the level `conflict`.
    pub fn new(pair: &'a Pair, levels: &Levels, conflict: Confidence) -> Self {
        Self {
            pair,
            agreement: levels.agreement,
            conflict,
            power: levels.power,
            open: (true, true),
            confidence: levels.confidence,
        }
    }

    /// The same where trials can be added only to the sides that are open.
    pub fn with_open_sides(self, open: (bool, bool)) -> Self {
        Self { open, ..self }
    }

    /// Plans at these costs of one trial of the first and of the second side.
    pub fn plans(&self, costs: (f64, f64)) -> Plans {
        let (first, second) = (self.pair.first(), self.pair.second());
        let counted = |belief: &Belief| belief.design_effect().is_some();
        let can = (
            self.open.0 && counted(first),
            self.open.1 && counted(second),
        );
        let kept = |plan: Plan| self.kept_by_people(plan, costs);
        let alone = |possible: bool, share: f64| {
            let plan = possible.then(|| self.along(share, costs)).flatten();
            plan.and_then(kept)
        };
        let (first, second) = (alone(can.0, 1.0), alone(can.1, 0.0));
        let mut both = (can.0 && can.1)
            .then(|| self.along(self.best_share(costs)?, costs))
            .flatten();
        // Only a cheaper one is shown, and worth the draws.
        let least = [first, second].into_iter().flatten();
        let least = least.map(|plan| plan.cost).fold(f64::INFINITY, f64::min);
        if both.is_some_and(|plan| plan.cost < least) {
            both = both.and_then(kept);
        }
        Plans {
            first,
            second,
            both,
        }
    }

    /// The share of the cost in the first side with which the approximation is cheapest.
    fn best_share(&self, costs: (f64, f64)) -> Option<f64> {
        (1..SIXTEENTHS as u32)
            .map(|part| f64::from(part) / SIXTEENTHS)
            .filter_map(|share| Some((self.approximate_cost(share, costs)?, share)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, share)| share)
    }

    /// The cheapest plan with this share of the cost in the first side: from the approximation in
    /// steps to a bracket, which is then halved.
    fn along(&self, share: f64, costs: (f64, f64)) -> Option<Plan> {
        let mut cost = self.approximate_cost(share, costs)?;
        let most = most_cost(share, costs);
        let mut best = None;
        let mut too_little = 0.0;
        loop {
            let found = self.plan(cost, share, costs);
            if found.chance >= self.power {
                best = Some(found);
                if too_little > 0.0 || found.trials.0.max(found.trials.1) <= 1 {
                    break;
                }
                cost /= STEP;
            } else {
                too_little = cost;
                if best.is_some() || cost >= most {
                    break;
                }
                cost *= STEP;
            }
        }
        let found = self.halved(too_little, best?, share, costs);
        match self.pair.is_of_few() {
            true => self.settled(found, share, costs),
            false => Some(found),
        }
    }

    /// A plan with the chances of the comparison's own tests; a larger one, where that takes one.
    fn settled(&self, plan: Plan, share: f64, costs: (f64, f64)) -> Option<Plan> {
        let mut trials = plan.trials;
        for _ in 0..MOST_STEPS {
            let chances = self.chances_by(trials, Pair::will_show_agreement);
            let plan = Plan::of(trials, costs, chances);
            if plan.chance >= self.power {
                return Some(plan);
            }
            let more = self::trials(plan.cost * STEP, share, costs);
            trials = match more == trials {
                true => (
                    more.0 + u64::from(share > 0.0),
                    more.1 + u64::from(share < 1.0),
                ),
                false => more,
            };
        }
        None
    }

    /// The cheapest plan found by halving between a cost that is too little and a plan.
    fn halved(&self, mut too_little: f64, mut enough: Plan, share: f64, costs: (f64, f64)) -> Plan {
        for _ in 0..HALVINGS {
            if too_little <= 0.0 || enough.cost <= too_little {
                break;
            }
            let middle = f64::midpoint(too_little, enough.cost);
            let found = self.plan(middle, share, costs);
            if found.chance >= self.power {
                enough = found;
            } else {
                too_little = middle;
            }
        }
        enough
    }

    fn plan(&self, cost: f64, share: f64, costs: (f64, f64)) -> Plan {
        let trials = trials(cost, share, costs);
        Plan::of(trials, costs, self.chances(trials.0, trials.1))
    }

    /// The cost at which the approximate chance suffices.
    fn approximate_cost(&self, share: f64, costs: (f64, f64)) -> Option<f64> {
        let enough = |cost: f64| {
            let (first, second) = trials(cost, share, costs);
            self.approximate_chance(first as f64, second as f64) >= self.power
        };
        let most = most_cost(share, costs);
        let mut high = costs.0.max(costs.1);
        while !enough(high) {
            if high >= most {
                return None;
            }
            high = (2.0 * high).min(most);
        }
        let mut low = 0.0;
        for _ in 0..20 {
            let middle = f64::midpoint(low, high);
            if enough(middle) {
                high = middle
            } else {
                low = middle
            }
        }
        Some(high)
    }
}

/// By how many steps a plan may grow that the comparison's own tests do not bear out.
const MOST_STEPS: usize = 12;

/// By how much a plan is changed at a time, and how often its bracket is halved.
const STEP: f64 = 1.15;
const HALVINGS: usize = 3;

/// Whole trials of each side that a cost buys.
fn trials(cost: f64, share: f64, costs: (f64, f64)) -> (u64, u64) {
    let whole = |part: f64, price: f64| {
        if part > 0.0 {
            (cost * part / price).ceil() as u64
        } else {
            0
        }
    };
    (whole(share, costs.0), whole(1.0 - share, costs.1))
}

/// The cost at which a side reaches the most trials that are planned.
fn most_cost(share: f64, costs: (f64, f64)) -> f64 {
    let of = |part: f64, price: f64| {
        if part > 0.0 {
            MOST_TRIALS * price / part
        } else {
            f64::INFINITY
        }
    };
    of(share, costs.0).min(of(1.0 - share, costs.1))
}

impl Planning<'_> {
    /// The chance that this many further trials of each side decide.
    #[cfg(test)]
    pub fn chance(&self, first: u64, second: u64) -> f64 {
        let (agreement, conflict) = self.chances(first, second);
        agreement + conflict
    }

    /// The chances that this many further trials of each side show agreement, and a conflict, by approximate tests.
    pub fn chances(&self, first: u64, second: u64) -> (f64, f64) {
        self.chances_by((first, second), Pair::would_show_agreement)
    }

    /// The same by a test of agreement.
    fn chances_by(
        &self,
        (first, second): (u64, u64),
        agreement: impl Fn(&Pair, Confidence) -> bool,
    ) -> (f64, f64) {
        let (a, b) = (
            Side::new(self.pair.first(), first),
            Side::new(self.pair.second(), second),
        );
        // The side whose outcomes are all counted by its distribution function is the larger one.
        let swapped = a.worth > b.worth;
        let (outer, inner) = if swapped { (&b, &a) } else { (&a, &b) };
        let decided = |outer: &Belief, inner: &Belief, kind: Kind| {
            let (first, second) = if swapped {
                (inner, outer)
            } else {
                (outer, inner)
            };
            let pair = self.pair.with(first.clone(), second.clone());
            match kind {
                Kind::Agreement => agreement(&pair, self.agreement),
                Kind::Conflict => !pair.is_inside_margin() && pair.differs(self.conflict),
            }
        };
        let mut guess = [1_u64; 4];
        outer
            .representatives()
            .into_iter()
            .map(|(y, weight)| {
                let outer = outer.after(y);
                let test = |y: u64, kind: Kind| decided(&outer, &inner.after(y), kind);
                let (agreement, conflict) = inner.shown(outer.estimate(), &mut guess, test);
                (weight * agreement, weight * conflict)
            })
            .fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// The chance by normal theory: the difference seen in the end scatters about today's with the
    /// variance that further trials take from it, and is decided beyond or within fixed limits.
    fn approximate_chance(&self, first: f64, second: f64) -> f64 {
        let (now, gain, left) = [(self.pair.first(), first), (self.pair.second(), second)]
            .into_iter()
            .map(|(belief, further)| moments(belief, further))
            .fold((0.0, 0.0, 0.0), |sum, m| {
                (m.0 - sum.0, sum.1 + m.1, sum.2 + m.2)
            });
        let (spread, error) = (gain.sqrt().max(1e-12), left.sqrt());
        let agree = self.pair.margin() + error * normal_quantile(self.agreement.alpha());
        let shown = -error * normal_quantile(0.5 * self.conflict.alpha());
        let conflict = shown.max(self.pair.margin());
        let below = |limit: f64| normal_cdf((limit - now) / spread);
        let differ = below(-conflict) + 1.0 - below(conflict);
        let same = if agree > 0.0 {
            below(agree.min(conflict)) - below(-agree.min(conflict))
        } else {
            0.0
        };
        differ + same
    }
}

/// Mean, variance that `further` trials would take away, and variance left after them.
fn moments(belief: &Belief, further: f64) -> (f64, f64, f64) {
    let Some(posterior) = belief.posterior() else {
        return (belief.estimate(), 0.0, 0.0);
    };
    let (a, b) = posterior.parameters();
    let worth = further / belief.design_effect().unwrap_or(f64::INFINITY);
    let gained = posterior.variance() * worth / (a + b + worth);
    (posterior.mean(), gained, posterior.variance() - gained)
}

/// What is asked of an outcome.
#[derive(Clone, Copy)]
enum Kind {
    Agreement,
    Conflict,
}

#[cfg(test)]
mod promised;

#[cfg(test)]
mod tests {
    use super::super::belief::samples::{counts, known};
    use super::*;
    use stats::{EffectiveSample, Sample};

    fn levels() -> Levels {
        Levels::new(0.95, 0.95).unwrap()
    }

    /// Plans at Bonferroni's level for a number of comparisons.
    fn at(pair: &Pair, family: usize) -> Planning<'_> {
        Planning::new(pair, &levels(), levels().confidence.simultaneous(family))
    }

    /// The chances of agreement and of a conflict as sums over all outcomes of both sides.
    fn by_full_sum(pair: &Pair, family: usize, first: u64, second: u64) -> (f64, f64) {
        let planning = at(pair, family);
        let (a, b) = (
            Side::new(pair.first(), first),
            Side::new(pair.second(), second),
        );
        let mut chance = (0.0, 0.0);
        for (y, weight) in a.next.representatives(usize::MAX) {
            for (z, other) in b.next.representatives(usize::MAX) {
                let outcome = pair.with(a.after(y), b.after(z));
                let p = outcome.p_by_fisher();
                let differs =
                    p.unwrap_or_else(|| outcome.p_difference()) <= planning.conflict.alpha();
                if outcome.would_show_agreement(planning.agreement) {
                    chance.0 += weight * other;
                } else if differs && !outcome.is_inside_margin() {
                    chance.1 += weight * other;
                }
            }
        }
        chance
    }

    #[test]
    fn the_chance_is_that_of_the_full_sum() {
        let cases = [
            (counts(8, 10), counts(45, 60), 0.15, 30, 20),
            (counts(0, 5), counts(2, 30), 0.1, 40, 0),
            (counts(30, 40), counts(5, 5), 0.2, 100, 90),
            (counts(9, 10), known(0.95), 0.1, 120, 0),
            (counts(3, 20), counts(9, 20), 0.05, 70, 60),
        ];
        for (first, second, margin, n, m) in cases {
            let pair = Pair::new(first, second, margin);
            let found = at(&pair, 3).chance(n, m);
            let expected = by_full_sum(&pair, 3, n, m);
            assert!(
                (found - (expected.0 + expected.1)).abs() < 0.01,
                "{n} {m}: {found} against {expected:?}"
            );
            let (agreement, conflict) = at(&pair, 3).chances(n, m);
            assert!(
                (agreement - expected.0).abs() < 0.01,
                "{agreement} {expected:?}"
            );
            assert!(
                (conflict - expected.1).abs() < 0.01,
                "{conflict} {expected:?}"
            );
        }
    }

    /// 39 of 41 twice is not shown to agree (p = 0.074), so that no plan may count on it.
    #[test]
    fn a_plan_of_few_trials_promises_what_the_comparison_keeps() {
        let pair = Pair::new(counts(38, 40), counts(39, 41), 0.1);
        let planning = at(&pair, 1);
        let (agreement, _) = planning.chances_by((1, 0), Pair::will_show_agreement);
        let kept: f64 = [(38, 0), (39, 1)]
            .into_iter()
            .map(|(successes, y)| {
                let side = Side::new(pair.first(), 1);
                let next = side.next.representatives(usize::MAX);
                let weight: f64 = next.iter().filter(|it| it.0 == y).map(|it| it.1).sum();
                let then = Pair::new(counts(successes, 41), counts(39, 41), 0.1);
                weight * f64::from(u8::from(then.shows_agreement(levels().agreement)))
            })
            .sum();
        assert!(
            (agreement - kept).abs() < 1e-9,
            "{agreement} against {kept}"
        );
    }

    #[test]
    fn plans_have_the_wanted_chance_and_little_less_has_not() {
        let pair = Pair::new(counts(88, 100), counts(4390, 5000), 0.05);
        let planning = at(&pair, 10);
        let plans = planning.plans((1.0, 1.0));
        let all = (plans.first.is_some(), plans.second, plans.both.is_some());
        // The experiment's own variance is too large for simulation alone to decide.
        assert_eq!(all, (true, None, true), "{plans:?}");
        for plan in [plans.first, plans.both].into_iter().flatten() {
            assert!(plan.chance >= 0.8, "{plan:?}");
            let less = |n: u64| (n as f64 * 0.85) as u64;
            assert!(
                planning.chance(less(plan.trials.0), less(plan.trials.1)) < 0.8,
                "{plan:?}"
            );
        }
        let few = Pair::new(counts(88, 100), counts(439, 500), 0.05);
        let plans = at(&few, 10).plans((1.0, 1.0));
        assert!(
            plans.first.is_none() && plans.both.is_some(),
            "now neither alone decides: {plans:?}"
        );
    }

    #[test]
    fn dear_trials_are_replaced_by_cheap_ones() {
        let pair = Pair::new(counts(88, 100), counts(44, 50), 0.08);
        let planning = at(&pair, 1);
        let equal = planning.plans((1.0, 1.0)).both.unwrap();
        let dear = planning.plans((100.0, 1.0)).both.unwrap();
        assert!(dear.trials.0 < equal.trials.0 && dear.trials.1 > equal.trials.1);
        let of_equal = 100.0 * equal.trials.0 as f64 + equal.trials.1 as f64;
        assert!(dear.cost < of_equal, "{} {of_equal}", dear.cost);
    }

    #[test]
    fn clustered_trials_are_planned_as_trials() {
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        let effective = EffectiveSample::at_size(sample, 50.0).unwrap();
        let clustered = Belief::Counts {
            clusters: None,
            sample,
            effective,
            before: None,
            completions: None,
        };
        let pair = Pair::new(clustered, known(0.88), 0.05);
        let plans = at(&pair, 10).plans((1.0, 1.0));
        assert_eq!((plans.second, plans.both), (None, None));
        // As many as 50 independent trials and twice the further ones would take.
        let plain = Pair::new(counts(44, 50), known(0.88), 0.05);
        let single = at(&plain, 10).plans((1.0, 1.0)).first.unwrap();
        let ratio = plans.first.unwrap().trials.0 as f64 / single.trials.0 as f64;
        assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    }
}
