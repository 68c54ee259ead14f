//! What trials that are alike within groups are worth.
//!
//! # Definition
//! `N` trials in groups of `m` with the intraclass correlation `rho` tell as much as
//!
//! ```text
//! n(rho) = N / (1 + (m - 1) rho)
//! ```
//!
//! independent ones.
//!
//! # Source
//! L. Kish, "Survey sampling" (1965), for the design effect `1 + (m - 1) rho`.
//!
//! # Assumes
//! Trials are exchangeable within a group, with the correlation that is given; groups are independent of each other and of
//! one size.
//!
//! # Guarantee
//! Exact for groups of one size whose trials are exchangeable; of groups of several sizes their mean is not enough
//! (`kish_design_effect`). `rho` is given, not estimated.

/// The design effect of groups of `group_size` trials: the variance of a rate relative to that of independent trials.
///
/// ```
/// assert_eq!(stats::kish_design_effect(10.0, 0.1), 1.9);
/// ```
#[must_use]
pub fn kish_design_effect(group_size: f64, correlation: f64) -> f64 {
    1.0 + (group_size - 1.0).max(0.0) * correlation
}
