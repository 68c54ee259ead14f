#![doc = include_str!("../README.md")]
//!
//! | question | answered by |
//! |---|---|
//! | What does `s` of `n` say of a rate? | [`IntervalMethod`], [`wilson`], [`BetaPosterior`] |
//! | Is the rate below, above, at a threshold? | [`binomial_test_below`], [`binomial_test_above`], [`binomial_test_two_sided`] |
//! | Do two rates differ, and by how much? | [`fisher_exact`], [`boschloo_exact`], [`difference_interval`], [`Difference`] |
//! | Do two rates agree within a margin? | [`exact_equivalence()`], [`tost`], [`score_equivalence`], [`probability_within`] |
//! | Do several rates agree, and what are they together? | [`heterogeneity()`], [`chi_squared_homogeneity`], [`pool`], [`power_prior`], [`scattered_rate`] |
//! | Many tests at once? | [`holm`], [`Confidence::simultaneous`] |
//! | Are trials of one person alike? | [`clustered_rate`], [`CommonCorrelation`], [`clustering`], [`BetaBinomial`], [`ClusterRobust`], [`EffectiveSample`] |
//! | Does a group or an ordering matter? | [`kruskal_wallis()`], [`kruskal_wallis_exact`], [`spearman()`], [`spearman_exact`] |
//! | Do two tables repeat each other's rows? | [`shared_rows()`], [`renamed_rows()`], [`rows_by_chance`], [`contents_by_chance`] |
//! | Is a number or a count copied from another? | [`constant_by_chance`], [`count_by_chance`], [`any_coincidence`] |
//! | Do like outcomes stand together in time? | [`runs_test`] |
//! | What are trials worth that are alike within groups? | [`kish_design_effect`] |
//! | Does one subject differ from all others? | [`outlier`](outlier()) |
//! | What may be said while trials go on, at any time? | [`confidence_sequence`], [`SequentialTest`] |
//! | Is the rate at least a threshold, repeating trials until it is known? | [`IndifferenceTest`], [`time_uniform_limits`] |
//! | What may be said when trials are added and the question is asked again? | [`continued_above`], [`continued_p`], [`continued_interval`] |
//! | How many trials does it take? | [`trials_per_arm`], [`further_trials`], [`Predictive`] |
//! | What do uncertain constants do to a result? | [`posterior_design`], [`Draws`], [`variance_shares`], [`SharesDesign`], [`credible_box`] |
//!
//! Each source file opens with its definitions, their source, what they assume, and the guarantee they come with.

mod alike_trials;
mod beta_binomial;
mod binomial;
mod boschloo;
mod cluster;
mod cluster_robust;
mod clustered;
mod clustered_tail;
mod coincidence;
mod combination;
mod common_correlation;
mod continuation;
mod counts;
mod design;
mod draws;
mod equivalence;
mod exact_equivalence;
mod fisher;
mod gauss_grid;
mod grouping;
mod guarantee;
mod heterogeneity;
mod indifference;
mod interval;
mod kruskal_wallis;
mod multiple;
mod outlier;
mod paired;
mod posterior;
mod power;
mod predictive;
mod propagation;
mod quadrature;
mod ranks;
mod renamed_rows;
mod runs;
mod score;
mod sequential;
mod shared_rows;
mod spearman;
pub mod special;
mod unmet_kind;

pub use alike_trials::kish_design_effect;
pub use beta_binomial::BetaBinomial;
pub use binomial::{binomial_test_above, binomial_test_below, binomial_test_two_sided};
pub use boschloo::boschloo_exact;
pub use cluster::{Clustering, clustering};
pub use cluster_robust::ClusterRobust;
pub use clustered::{
    ClusterMethod, ClusteredRate, clustered_rate, clustered_rate_among, clustered_test_above,
    clustered_test_below,
};
pub use coincidence::{
    Possible, SAME_TRIALS, any_coincidence, coincidences, constant_by_chance, contents_by_chance,
    count_by_chance, product_by_chance, quotient_by_chance, rows_by_chance, several_coincidences,
};
pub use combination::{BETWEEN, MOST_BETWEEN, ScatteredRate, power_prior, scattered_rate};
pub use common_correlation::CommonCorrelation;
pub use continuation::{
    ClusteredLook, SHARE_OF_A_LOOK, ScoredLook, continued_above, continued_below,
    continued_clusters_above, continued_clusters_below, continued_interval, continued_lower_limit,
    continued_p, continued_rejects, continued_upper_limit,
};
pub use counts::{
    Confidence, EffectiveSample, Interval, MOST_TRIALS, Sample, StatsError, whole_counts,
};
pub use design::{design, design_from, posterior_design};
pub use draws::{Draws, VarianceShare, variance_shares};
pub use equivalence::{Difference, DifferenceVariance, Tost, difference_interval, tost};
pub use exact_equivalence::exact_equivalence;
pub use fisher::fisher_exact;
pub use grouping::{alike_by_label, alike_in_order};
pub use guarantee::Guarantee;
pub use heterogeneity::{
    ChiSquared, Combined, Heterogeneity, chi_squared_homogeneity, heterogeneity, pool,
};
pub use indifference::{IndifferenceTest, time_uniform_limits};
pub use interval::{IntervalMethod, agresti_coull, clopper_pearson, jeffreys, wilson};
pub use kruskal_wallis::{KruskalWallis, kruskal_wallis, kruskal_wallis_exact};
pub use multiple::holm;
pub use outlier::{Outlier, outlier};
pub use paired::Pairs;
pub use posterior::{
    BetaPosterior, PosteriorPlaces, probability_exceeds, probability_greater, probability_within,
};
pub use power::{Arm, FurtherTrials, Goal, further_trials, trials_per_arm};
pub use predictive::Predictive;
pub use propagation::{
    Propagated, Shares, SharesDesign, credible_box, extremes_at_corners, paired_difference,
};
pub use renamed_rows::{RenamedRows, Unnamed, renamed_rows};
pub use runs::{Runs, runs_test};
pub use score::score_equivalence;
pub use sequential::{
    Decision, RunningInterval, SequentialTest, confidence_sequence, ln_evidence_against,
};
pub use shared_rows::{SharedRows, shared_rows};
pub use spearman::{Spearman, spearman, spearman_exact};
pub use unmet_kind::with_unmet_kind;
