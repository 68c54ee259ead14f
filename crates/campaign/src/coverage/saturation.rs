//! How much is still unseen: species richness, and the chance that one more episode shows
//! anything new.
//!
//! ```text
//! n episodes saw S bins, Q1 of them in one episode only, Q2 in two
//! Chao2:        S + A Q1^2 / (2 Q2),  A = (n-1)/n          (Q2 = 0: S + A Q1 (Q1-1)/2)
//! Good-Turing:  Q1 / n   expected number of new bins in the next episode
//! m more:       f0 (1 - (1 - Q1/(n f0 + Q1))^m)            f0 = estimate of the unseen
//! upper bound q of the chance of anything new in the next episode: of the last w episodes k had
//! something new; q solves P(Bin(w, q) <= k) = 1 - level
//! ```
//!
//! Source: A. Chao, "Estimating the population size for capture-recapture data with unequal
//! catchability" (1987), with its logarithmic interval; I. J. Good (1953); A. Chao et al. (2014),
//! equation 9 of its appendix, for the extrapolation; for testing: M. Boehme, "STADS: software
//! testing as species discovery" (2018). The upper bound is ours: the set of unseen bins only
//! shrinks, so that the chance of news never rises while generation stays as it is, and the count
//! k dominates a binomial one. Deviation: none. Cost: linear. Guarantee: Chao2 estimates a lower
//! bound of the number of bins that can be seen at all; its interval is approximate. The upper
//! bound is exact (conservative) if the last w + 1 episodes were generated alike and
//! independently, and n was not chosen after looking.

use serde::{Deserialize, Serialize};
use stats::special::normal_quantile;
use stats::{Confidence, Interval, Sample, clopper_pearson};

/// What the counts of bins say about bins that were not seen yet.
///
/// ```
/// use campaign::Saturation;
/// use stats::Confidence;
/// // 100 episodes; four bins seen often, two seen once; the last new one in episode 30.
/// let saturation = Saturation::new(100, [100, 90, 40, 7, 1, 1], &[0, 1, 5, 30]);
/// assert_eq!(saturation.expected_new(1), 0.02);
/// // None of the last 50 episodes showed anything new.
/// let chance = saturation.chance_of_news_at_most(Confidence::P95);
/// assert!((chance - (1.0 - 0.05_f64.powf(1.0 / 50.0))).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Saturation {
    /// How many episodes there were.
    pub episodes: u64,
    /// How many bins were seen.
    pub seen: u64,
    /// How many of them in one episode only.
    pub seen_once: u64,
    /// How many of them in exactly two.
    pub seen_twice: u64,
    /// The later half of the episodes: how many there are.
    pub recent: u64,
    /// How many of these showed something new.
    pub recent_with_news: u64,
}

impl Saturation {
    /// From the number of episodes, each seen bin's number of episodes, and the places (from 0)
    /// of the episodes that showed something new.
    #[must_use]
    pub fn new(episodes: u64, counts: impl IntoIterator<Item = u64>, news: &[u64]) -> Self {
        let mut saturation = Self {
            episodes,
            seen: 0,
            seen_once: 0,
            seen_twice: 0,
            recent: episodes / 2,
            recent_with_news: 0,
        };
        for count in counts {
            saturation.seen += u64::from(count > 0);
            saturation.seen_once += u64::from(count == 1);
            saturation.seen_twice += u64::from(count == 2);
        }
        let first_recent = episodes - saturation.recent;
        let recent = news.iter().filter(|place| **place >= first_recent);
        saturation.recent_with_news = recent.count() as u64;
        saturation
    }

    /// The expected number of bins still unseen that episodes like these can show (Chao2); a lower
    /// bound in expectation.
    #[must_use]
    pub fn unseen(&self) -> f64 {
        let (once, twice) = (self.seen_once as f64, self.seen_twice as f64);
        if twice > 0.0 {
            self.share_of_others() * once * once / (2.0 * twice)
        } else {
            self.share_of_others() * once * (once - 1.0).max(0.0) / 2.0
        }
    }

    /// The factor (n - 1)/n.
    fn share_of_others(&self) -> f64 {
        let n = self.episodes as f64;
        if n > 0.0 { (n - 1.0) / n } else { 0.0 }
    }

    /// An approximate interval for the number of bins in all, seen and unseen (Chao 1987). `None`
    /// when nothing unseen is estimated: then only
    /// [`chance_of_news_at_most`](Self::chance_of_news_at_most) says how sure that is.
    #[must_use]
    pub fn total_interval(&self, confidence: Confidence) -> Option<Interval> {
        let unseen = self.unseen();
        if unseen <= 0.0 {
            return None;
        }
        let z = normal_quantile(1.0 - 0.5 * confidence.alpha());
        let spread = (z * (self.variance() / (unseen * unseen)).ln_1p().sqrt()).exp();
        let seen = self.seen as f64;
        Some(Interval {
            low: seen + unseen / spread,
            high: seen + unseen * spread,
        })
    }

    /// The variance of the estimated total.
    fn variance(&self) -> f64 {
        let (once, twice) = (self.seen_once as f64, self.seen_twice as f64);
        let a = self.share_of_others();
        if twice > 0.0 {
            let ratio = once / twice;
            let terms =
                0.5 * a * ratio.powi(2) + a * a * ratio.powi(3) + 0.25 * a * a * ratio.powi(4);
            return twice * terms;
        }
        let total = self.seen as f64 + self.unseen();
        let variance = 0.5 * a * once * (once - 1.0)
            + 0.25 * a * a * once * (2.0 * once - 1.0).powi(2)
            - 0.25 * a * a * once.powi(4) / total.max(1.0);
        variance.max(0.0)
    }

    /// The expected number of new bins in so many more episodes.
    #[must_use]
    pub fn expected_new(&self, more: u64) -> f64 {
        if self.episodes == 0 || self.seen_once == 0 {
            return 0.0;
        }
        let (n, once) = (self.episodes as f64, self.seen_once as f64);
        let unseen = self.unseen();
        if unseen <= 0.0 {
            // One bin seen once and none twice: Good-Turing's rate, for the next episode only.
            return (once / n * more as f64).min(once);
        }
        if more == 1 {
            return once / n;
        }
        unseen * (1.0 - (1.0 - once / (n * unseen + once)).powf(more as f64))
    }

    /// An upper confidence bound of the chance that the next episode shows anything new, from the
    /// later half of the episodes; 1 without episodes.
    #[must_use]
    pub fn chance_of_news_at_most(&self, confidence: Confidence) -> f64 {
        let Ok(sample) = Sample::new(self.recent_with_news, self.recent) else {
            return 1.0;
        };
        if self.recent == 0 {
            return 1.0;
        }
        // The upper end of a two-sided interval at level 1 - 2 alpha has level 1 - alpha.
        match Confidence::new(1.0 - 2.0 * confidence.alpha()) {
            Ok(two_sided) => clopper_pearson(sample, two_sided).high,
            Err(_) => 1.0,
        }
    }

    /// Whether more episodes of this kind have stopped paying: with this confidence, so many more
    /// of them show news in at most `news` episodes on average.
    #[must_use]
    pub fn has_stopped_paying(&self, more: u64, news: f64, confidence: Confidence) -> bool {
        self.chance_of_news_at_most(confidence) * more as f64 <= news
    }
}
