//! From counts to intervals, tests and sample sizes.
pub mod counts;
pub mod interval;
pub mod special;

pub use counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
pub use interval::{IntervalMethod, agresti_coull, clopper_pearson, jeffreys, wilson};
