//! How far a computed number can be trusted, as evidence says it.

use crate::Interval;
use crate::finding::WorstCase;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far a computed number can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Guarantee {
    /// Computed without rounding; `rational` is the exact value as `p/q` if
    /// it is short enough to show.
    Exact {
        /// The value as a fraction.
        rational: Option<String>,
    },
    /// The true value lies between these bounds.
    Bounded {
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The model leaves choices open: under each scheduler the value is between these bounds, which are those of the
    /// worst and the best scheduler.
    Schedulers {
        /// Not above the least value.
        low: f64,
        /// Not below the greatest value.
        high: f64,
        /// What the worst scheduler does, where it makes the subject miss its threshold.
        #[serde(default)]
        worst: Option<Box<WorstCase>>,
    },
    /// The true value lies between these with this confidence.
    Statistical {
        /// Probability with which such intervals contain the true value.
        confidence: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// An iteration stopped; the error is unknown.
    Estimated {
        /// Why there is no bound, for example the stopping rule.
        reason: String,
    },
}

impl Guarantee {
    /// What is known of a number as whoever computed it says; `rational` is its exact value, if it is short enough to show.
    /// The one place where engines' guarantees become those of evidence: nothing is lost.
    #[must_use]
    pub fn of(computed: &stats::Guarantee, rational: Option<String>) -> Self {
        match computed {
            stats::Guarantee::Exact => Guarantee::Exact { rational },
            stats::Guarantee::Bounded { low, high } => Guarantee::Bounded {
                low: *low,
                high: *high,
            },
            stats::Guarantee::Statistical {
                confidence,
                low,
                high,
            } => Guarantee::Statistical {
                confidence: *confidence,
                low: *low,
                high: *high,
            },
            stats::Guarantee::Estimated { reason } => Guarantee::Estimated {
                reason: reason.clone(),
            },
        }
    }

    /// The least and the greatest value over all schedulers, if the value is such a range.
    #[must_use]
    pub fn over_schedulers(&self) -> Option<(f64, f64)> {
        match self {
            Guarantee::Schedulers { low, high, .. } => Some((*low, *high)),
            Guarantee::Exact { .. }
            | Guarantee::Bounded { .. }
            | Guarantee::Statistical { .. }
            | Guarantee::Estimated { .. } => None,
        }
    }

    /// Whether the value is an estimate, of whose error nothing is known.
    #[must_use]
    pub fn is_estimated(&self) -> bool {
        match self {
            Guarantee::Estimated { .. } => true,
            Guarantee::Exact { .. }
            | Guarantee::Bounded { .. }
            | Guarantee::Schedulers { .. }
            | Guarantee::Statistical { .. } => false,
        }
    }

    /// Whether what is known of the value holds for certain: it is exact, or lies between bounds.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        match self {
            Guarantee::Exact { .. } | Guarantee::Bounded { .. } | Guarantee::Schedulers { .. } => {
                true
            }
            Guarantee::Statistical { .. } | Guarantee::Estimated { .. } => false,
        }
    }

    /// Where the value lies, and the probability that it does not lie there: 0 between bounds. `None` of what is exact, and
    /// of an estimate.
    #[must_use]
    pub fn within(&self) -> Option<(Interval, f64)> {
        let at = |low: f64, high: f64, doubt: f64| Some((Interval { low, high }, doubt));
        match *self {
            Guarantee::Bounded { low, high } | Guarantee::Schedulers { low, high, .. } => {
                at(low, high, 0.0)
            }
            Guarantee::Statistical {
                confidence,
                low,
                high,
            } => at(low, high, 1.0 - confidence),
            Guarantee::Exact { .. } | Guarantee::Estimated { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MethodAnswer;

    fn statistical(confidence: f64, low: f64, high: f64) -> Guarantee {
        Guarantee::Statistical {
            confidence,
            low,
            high,
        }
    }

    fn answer(value: f64, guarantee: Guarantee) -> MethodAnswer {
        MethodAnswer {
            method: "sampled".into(),
            value,
            complement: None,
            guarantee,
            iterations: None,
        }
    }

    #[test]
    fn nothing_is_lost_between_engines_and_evidence() {
        let level = stats::Guarantee::Statistical {
            confidence: 0.99,
            low: 0.2,
            high: 0.3,
        };
        assert_eq!(Guarantee::of(&level, None), statistical(0.99, 0.2, 0.3));
        let kept = serde_json::to_string(&statistical(0.99, 0.2, 0.3)).expect("it is written");
        let read: Guarantee = serde_json::from_str(&kept).expect("it is read");
        assert_eq!(read, statistical(0.99, 0.2, 0.3));
        assert_eq!(
            Guarantee::of(&stats::Guarantee::Exact, Some("1/3".into())),
            Guarantee::Exact {
                rational: Some("1/3".into())
            }
        );
        let reason = || "it stopped".to_owned();
        assert_eq!(
            Guarantee::of(&stats::Guarantee::Estimated { reason: reason() }, None),
            Guarantee::Estimated { reason: reason() }
        );
    }

    #[test]
    fn a_level_stays_with_the_contrary_and_doubts_of_a_quotient_add_up() {
        let of = |level: f64| answer(0.25, statistical(level, 0.2, 0.3));
        let Guarantee::Statistical {
            confidence,
            low,
            high,
        } = of(0.99).contrary().guarantee
        else {
            panic!("it is statistical still");
        };
        assert_eq!(confidence, 0.99);
        // Outwards, and by rounding only.
        assert!((0.699_999..=0.7).contains(&low) && (0.8..0.800_001).contains(&high));

        let quotient = of(0.99).quotient(&answer(0.5, statistical(0.98, 0.4, 0.6)));
        let (within, doubt) = quotient.guarantee.within().expect("an interval");
        assert!((doubt - 0.03).abs() < 1e-12, "{doubt}");
        assert!(within.low <= 0.2 / 0.6 && within.high >= 0.3 / 0.4);
        let by_exact = of(0.99).quotient(&answer(0.5, Guarantee::Exact { rational: None }));
        let (_, doubt) = by_exact.guarantee.within().expect("an interval");
        assert!((doubt - 0.01).abs() < 1e-12, "{doubt}");
        let hopeless = of(0.4).quotient(&of(0.4)).guarantee;
        assert!(hopeless.is_estimated());
        assert!(of(0.99).bounds().is_none(), "nothing holds for certain");
    }
}
