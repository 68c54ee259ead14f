//! How exactly times are known: one definition for staged monitors and both models of time.

/// The resolution of recorded times, in seconds.
pub(crate) const RESOLUTION_SECS: f64 = 1e-9;

/// Distances up to a sample at this time are compared with this tolerance, in seconds: 1 ns, the
/// resolution of recorded times, or four units in the last place of the time where that is coarser
/// (two times are subtracted, and each was rounded, perhaps more than once).
#[inline]
pub(crate) fn tolerance_secs(time_secs: f64) -> f64 {
    RESOLUTION_SECS.max(4.0 * f64::EPSILON * time_secs.abs())
}
