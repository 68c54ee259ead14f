//! From counts to intervals, tests and sample sizes.
pub mod binomial;
pub mod cluster;
pub mod counts;
pub mod equivalence;
pub mod fisher;
pub mod heterogeneity;
pub mod interval;
pub mod kruskal_wallis;
pub mod multiple;
pub mod posterior;
mod quadrature;
mod ranks;
pub mod spearman;
pub mod special;

pub use binomial::{binomial_test_above, binomial_test_below, binomial_test_two_sided};
pub use cluster::{Clustering, clustering};
pub use counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
pub use equivalence::{Difference, DifferenceVariance, Tost, tost};
pub use fisher::fisher_exact;
pub use heterogeneity::{
    ChiSquared, Combined, Heterogeneity, chi_squared_homogeneity, heterogeneity, pool,
};
pub use interval::{IntervalMethod, agresti_coull, clopper_pearson, jeffreys, wilson};
pub use kruskal_wallis::{KruskalWallis, kruskal_wallis, kruskal_wallis_exact};
pub use multiple::holm;
pub use posterior::{BetaPosterior, probability_greater, probability_within};
pub use spearman::{Spearman, spearman, spearman_exact};
