//! From counts to intervals, tests and sample sizes.
pub mod binomial;
pub mod counts;
pub mod equivalence;
pub mod fisher;
pub mod interval;
pub mod posterior;
mod quadrature;
pub mod special;

pub use binomial::{binomial_test_above, binomial_test_below, binomial_test_two_sided};
pub use counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
pub use equivalence::{Difference, DifferenceVariance, Tost, tost};
pub use fisher::fisher_exact;
pub use interval::{IntervalMethod, agresti_coull, clopper_pearson, jeffreys, wilson};
pub use posterior::{BetaPosterior, probability_greater, probability_within};
