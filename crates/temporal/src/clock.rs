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

/// How exactly times are known, in nanoseconds: the least power of ten that is no less than the
/// tolerance. For times of the calendar, about 1.8e9 s, it is a microsecond.
pub(crate) fn resolution_nanos(time_secs: f64) -> i64 {
    let tolerance_nanos = tolerance_secs(time_secs) * 1e9;
    let mut resolution_nanos = 1;
    // The largest finite times are beyond all that can be counted in nanoseconds.
    while (resolution_nanos as f64) < tolerance_nanos && resolution_nanos < 1_000_000_000 {
        resolution_nanos *= 10;
    }
    resolution_nanos
}

/// A number of nanoseconds rounded to whole multiples of a resolution.
pub(crate) fn rounded(nanos: i64, resolution_nanos: i64) -> i64 {
    (nanos + resolution_nanos / 2).div_euclid(resolution_nanos) * resolution_nanos
}

/// The whole nanoseconds from the first sample's time to this one's, rounded to the resolution of
/// the later of both, since what a sample's time has lost in rounding must not decide whether it
/// meets a deadline. Where that is coarser than a nanosecond, samples at different times that it
/// makes equal are kept apart by a nanosecond. `None` if that is not after `last_nanos`, or too far
/// away (1e18 ns) to count.
pub(crate) fn nanos_since(first_secs: f64, time_secs: f64, last_nanos: Option<i64>) -> Option<i64> {
    let nanos = ((time_secs - first_secs) * 1e9).round();
    if !(0.0..=1e18).contains(&nanos) {
        return None;
    }
    let resolution_nanos = resolution_nanos(first_secs.abs().max(time_secs.abs()));
    let nanos = rounded(nanos as i64, resolution_nanos);
    match last_nanos {
        Some(last) if nanos > last => Some(nanos),
        Some(last) if resolution_nanos > 1 => Some(last + 1),
        Some(_) => None,
        None => Some(nanos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_of_decimal_steps_is_found_at_times_of_the_calendar() {
        for first_secs in [0.0, 12_345.6, 3e6, 1.76e9] {
            let mut last = None;
            for step in 0..5_000_i64 {
                let time_secs = first_secs + step as f64 * 0.1;
                last = nanos_since(first_secs, time_secs, last);
                assert_eq!(last, Some(step * 100_000_000), "{first_secs} + {step}");
            }
        }
    }

    #[test]
    fn later_samples_stay_later() {
        let mut time_secs = 1.76e9;
        let mut last = None;
        for _ in 0..100 {
            let nanos = nanos_since(1.76e9, time_secs, last);
            assert!(nanos.is_some() && nanos > last);
            (last, time_secs) = (nanos, time_secs.next_up());
        }
    }
}
