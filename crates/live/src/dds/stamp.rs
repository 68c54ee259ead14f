//! Times of the wire in nanoseconds since 1970.
//!
//! RTPS counts whole seconds and fractions of 1/2^32 s (OMG DDSI-RTPS 2.5, 9.3.2.1), so a nanosecond is about 4.3
//! fractions and rounding to the nearest restores exactly what was stamped in nanoseconds.

use rustdds::Timestamp;

const NANOS: u64 = 1_000_000_000;

/// Nanoseconds since 1970; `None` for the marks "zero", "invalid" and "infinite".
pub(crate) fn unix_nanos(stamp: Timestamp) -> Option<i64> {
    let ticks = stamp.to_ticks();
    if ticks == 0 || ticks >= u64::MAX - 1 {
        return None;
    }
    let (seconds, fraction) = (ticks >> 32, ticks & 0xffff_ffff);
    let nanos = (fraction * NANOS + (1 << 31)) >> 32;
    i64::try_from(seconds * NANOS + nanos).ok()
}

/// The stamp of `nanos` since 1970, if it can be written (up to the year 2106).
pub(crate) fn stamp(nanos: i64) -> Option<Timestamp> {
    let nanos = u64::try_from(nanos).ok()?;
    let seconds = u32::try_from(nanos / NANOS).ok()?;
    // Rounded up: rounding back to the nearest then gives the same nanosecond, and so does cutting off.
    let fraction = ((nanos % NANOS) << 32).div_ceil(NANOS);
    Some(Timestamp::from_ticks((u64::from(seconds) << 32) + fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nanoseconds_go_there_and_back() {
        for nanos in [
            1,
            999_999_999,
            1_000_000_000,
            1_792_000_000_123_456_789,
            4_294_967_294_999_999_999,
        ] {
            assert_eq!(stamp(nanos).and_then(unix_nanos), Some(nanos));
        }
        let mut nanos = 1_700_000_000_000_000_000;
        for step in 0..10_000 {
            nanos += step * 7919;
            assert_eq!(stamp(nanos).and_then(unix_nanos), Some(nanos));
        }
    }

    #[test]
    fn marks_are_no_times() {
        for ticks in [0, u64::MAX, u64::MAX - 1] {
            assert_eq!(unix_nanos(Timestamp::from_ticks(ticks)), None);
        }
        assert!(stamp(-1).is_none());
        assert!(stamp(i64::MAX).is_none());
    }
}
