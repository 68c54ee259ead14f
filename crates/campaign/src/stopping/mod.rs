//! "Until requirement R is decided": when a campaign may stop, without spoiling what it says.
//!
//! Definition. Episodes are numbered 1, 2, 3, ...; after each, the e-values of
//! [`stats::SequentialTest`] are looked at, and the campaign stops at the first number at which one
//! of them decides (or at the greatest number allowed). Episodes may finish in any order: outcomes
//! wait until all before them are known, so the decision is a function of the numbered outcomes
//! alone, not of threads.
//!
//! Source: as [`stats::confidence_sequence`]. Deviation: none. Cost: constant for an episode, and memory for
//! those that wait. Guarantee: the decision is wrong with probability at most `1 - confidence`, and
//! the interval holds the rate at every number at once with that confidence, so choosing when to
//! stop by looking at them does no harm. Episodes without an outcome (the requirement did not come
//! up) count towards the greatest number only.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use stats::{Confidence, Decision, Interval, RunningInterval, Sample, SequentialTest};

use crate::error::CampaignError;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoppingRule {
    /// Stop once it is decided whether the rate of success is at least this.
    pub threshold: f64,
    /// The confidence in the decision, for example 0.99.
    pub confidence: f64,
    /// Stop after this many episodes in any case.
    pub most: u64,
}

/// Why a campaign stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stop {
    /// The rate is at least the threshold.
    AtLeast,
    /// The rate is below the threshold.
    Below,
    /// The greatest number of episodes was reached with nothing decided.
    Exhausted,
}

/// Follows a campaign under a [`StoppingRule`].
///
/// ```
/// use campaign::{Stop, Stopping, StoppingRule};
/// let rule = StoppingRule { threshold: 0.95, confidence: 0.99, most: 1000 };
/// let mut stopping = Stopping::new(rule)?;
/// // Four of five succeed; they finish in pairs, the later one first.
/// for number in (1..1000).step_by(2) {
///     stopping.tell(number + 1, Some((number + 1) % 5 != 0));
///     stopping.tell(number, Some(number % 5 != 0));
/// }
/// assert_eq!(stopping.stop(), Some(Stop::Below));
/// assert_eq!(stopping.episodes(), 50);
/// assert!(stopping.interval().high < 0.95);
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Stopping {
    rule: StoppingRule,
    test: SequentialTest,
    waiting: BTreeMap<u64, Option<bool>>,
    running: RunningInterval,
    episodes: u64,
    stop: Option<Stop>,
}

impl Stopping {
    /// Before the first episode.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] for a threshold that is no probability, a confidence that is not
    /// strictly between 0 and 1, or no episodes at all.
    pub fn new(rule: StoppingRule) -> Result<Self, CampaignError> {
        let confidence = Confidence::new(rule.confidence)
            .map_err(|error| CampaignError::setting("confidence", error.to_string()))?;
        let test = SequentialTest::new(rule.threshold, confidence)
            .map_err(|error| CampaignError::setting("threshold", error.to_string()))?;
        if rule.most == 0 {
            return Err(CampaignError::setting("most", "allow at least one episode"));
        }
        Ok(Self {
            rule,
            test,
            waiting: BTreeMap::new(),
            running: RunningInterval::new(confidence),
            episodes: 0,
            stop: None,
        })
    }

    /// Takes the outcome of the episode with this number, counted from 1: success, failure, or
    /// `None` if there was none. Numbers told before, and those behind the stop, change nothing.
    pub fn tell(&mut self, number: u64, outcome: Option<bool>) {
        if number > self.episodes {
            self.waiting.entry(number).or_insert(outcome);
        }
        while self.stop.is_none() {
            let Some(outcome) = self.waiting.remove(&(self.episodes + 1)) else {
                return;
            };
            self.episodes += 1;
            if let Some(success) = outcome {
                self.running.observe(success);
            }
            self.look();
        }
        self.waiting.clear();
    }

    fn look(&mut self) {
        self.stop = match self.test.decide(self.running.sample()) {
            Decision::AtLeast => Some(Stop::AtLeast),
            Decision::Below => Some(Stop::Below),
            Decision::Open if self.episodes >= self.rule.most => Some(Stop::Exhausted),
            Decision::Open => None,
        };
    }

    /// Why to stop, if it is time to.
    #[must_use]
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }

    /// How many episodes count: the prefix without gaps, up to the stop.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Successes and trials of these episodes.
    #[must_use]
    pub fn sample(&self) -> Sample {
        self.running.sample()
    }

    /// The rates not excluded, valid at every look.
    #[must_use]
    pub fn interval(&self) -> Interval {
        self.running.interval()
    }

    /// The rule.
    #[must_use]
    pub fn rule(&self) -> StoppingRule {
        self.rule
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const RULE: StoppingRule = StoppingRule {
        threshold: 0.9,
        confidence: 0.95,
        most: 400,
    };

    /// Outcomes of 500 episodes of which some have none.
    fn outcomes(seed: u64, rate: f64) -> Vec<Option<bool>> {
        let mut random = Random::new(seed, "outcomes");
        let mut one = || random.chance(0.9).then(|| random.chance(rate));
        (0..500).map(|_| one()).collect()
    }

    #[test]
    fn the_order_in_which_episodes_finish_changes_nothing() {
        for seed in 0..20 {
            let outcomes = outcomes(seed, 0.8);
            let mut in_order = Stopping::new(RULE).unwrap();
            for (index, outcome) in outcomes.iter().enumerate() {
                in_order.tell(index as u64 + 1, *outcome);
            }
            let mut shuffled = Stopping::new(RULE).unwrap();
            for index in Random::new(seed, "order").permutation(outcomes.len()) {
                shuffled.tell(index as u64 + 1, outcomes[index]);
                shuffled.tell(index as u64 + 1, outcomes[index].map(|o| !o));
            }
            assert_eq!(in_order.stop(), shuffled.stop());
            assert_eq!(in_order.episodes(), shuffled.episodes());
            assert_eq!(in_order.interval(), shuffled.interval());
            assert!(in_order.episodes() <= RULE.most);
        }
    }

    #[test]
    fn a_rate_at_the_threshold_is_rarely_decided_wrongly() {
        let decided = (0..400).filter(|seed| {
            let mut stopping = Stopping::new(RULE).unwrap();
            for (index, outcome) in outcomes(*seed, 0.9).iter().enumerate() {
                stopping.tell(index as u64 + 1, *outcome);
            }
            stopping.stop() == Some(Stop::Below)
        });
        // At most 5 % of 400, within four standard deviations.
        assert!(decided.count() < 20 + 18);
    }

    #[test]
    fn episodes_without_outcome_exhaust_the_campaign() {
        let mut stopping = Stopping::new(StoppingRule { most: 3, ..RULE }).unwrap();
        (1..=3).for_each(|number| stopping.tell(number, None));
        assert_eq!(stopping.stop(), Some(Stop::Exhausted));
        assert_eq!(stopping.sample().trials, 0);
        assert_eq!(stopping.interval(), Interval::VACUOUS);
    }

    #[test]
    fn rules_that_cannot_be_are_refused() {
        for rule in [
            StoppingRule {
                threshold: 1.5,
                ..RULE
            },
            StoppingRule {
                confidence: 1.0,
                ..RULE
            },
            StoppingRule { most: 0, ..RULE },
        ] {
            assert!(Stopping::new(rule).is_err(), "{rule:?}");
        }
    }
}
