//! How a way is gone along in time, from rest to rest, within limits.
//!
//! Definition: a profile is `s(t)` from 0 to a length `D` with `s'` at most `v`, `|s''|` at most `a` and, where a jerk `j` is
//! given, `|s'''|` at most `j`; it begins and ends at rest. It is the fastest such: speed, acceleration or jerk is at its limit
//! at every time. Without a jerk it is a trapezoid of speed, with one the double S. A profile that is braked at `t` comes to
//! rest as soon as these limits allow.
//!
//! Source: L. Biagiotti, C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots" (2008), sections 3.2 and 3.4.
//!
//! Cost: constant. Guarantee: each piece is integrated exactly, so the limits hold to the last bits.

/// Limits along a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    /// None: acceleration may jump.
    pub(super) jerk: Option<f64>,
}

/// Where something is on its way: place, speed, acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct OnWay {
    pub(super) place: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

/// A time in which the jerk is constant.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    secs: f64,
    start: OnWay,
    jerk: f64,
}

/// A profile.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Profile {
    pieces: Vec<Piece>,
    end: f64,
    is_braked: bool,
}

impl Piece {
    fn at(&self, secs: f64) -> OnWay {
        let OnWay {
            place,
            speed,
            acceleration,
        } = self.start;
        let (jerk, t) = (self.jerk, secs);
        OnWay {
            place: place + t * (speed + t * (acceleration / 2.0 + t * jerk / 6.0)),
            speed: speed + t * (acceleration + t * jerk / 2.0),
            acceleration: acceleration + t * jerk,
        }
    }
}

impl Profile {
    /// From rest at 0 to rest at `length`, which is not negative.
    pub(super) fn over(length: f64, limits: &Limits) -> Self {
        if length <= 0.0 {
            return Self::default();
        }
        let Limits {
            speed,
            acceleration,
            jerk,
        } = *limits;
        let mut profile = match jerk {
            None => {
                let rising = (speed / acceleration).min((length / acceleration).sqrt());
                let cruising = (length / (acceleration * rising) - rising).max(0.0);
                Self::of(&[
                    (rising, Some(acceleration), 0.0),
                    (cruising, Some(0.0), 0.0),
                    (rising, Some(-acceleration), 0.0),
                ])
            }
            Some(jerk) => {
                let (bend, rising, cruising) = double_s(length, speed, acceleration, jerk);
                let straight = (rising - 2.0 * bend).max(0.0);
                Self::of(&[
                    (bend, None, jerk),
                    (straight, None, 0.0),
                    (bend, None, -jerk),
                    (cruising, None, 0.0),
                    (bend, None, -jerk),
                    (straight, None, 0.0),
                    (bend, None, jerk),
                ])
            }
        };
        profile.end = length;
        profile
    }

    /// From where a profile is at `secs` to rest as soon as its limits allow.
    pub(super) fn braked(&self, secs: f64, limits: &Limits) -> Self {
        let start = self.at(secs);
        let mut profile = Self::default();
        match limits.jerk {
            None => profile.add(
                start,
                start.speed / limits.acceleration,
                Some(-limits.acceleration),
                0.0,
            ),
            Some(jerk) => {
                let Limits { acceleration, .. } = *limits;
                let least = least_of(start, jerk).min(acceleration);
                let fall = ((start.acceleration + least) / jerk).max(0.0);
                profile.add(start, fall, None, -jerk);
                let now = profile.last(start);
                let back = -now.acceleration / jerk;
                let left = now.speed - now.acceleration * now.acceleration / (2.0 * jerk);
                let stay = match now.acceleration < 0.0 {
                    true => (left / -now.acceleration).max(0.0),
                    false => 0.0,
                };
                profile.add(now, stay, None, 0.0);
                let now = profile.last(start);
                profile.add(now, back.max(0.0), None, jerk);
            }
        }
        profile.end = profile.last(start).place;
        profile.is_braked = true;
        profile
    }

    /// Whether it stops on the way.
    pub(super) fn is_braked(&self) -> bool {
        self.is_braked
    }

    /// Pieces one after another, from rest at 0: how long, the acceleration where it jumps, the jerk.
    fn of(pieces: &[(f64, Option<f64>, f64)]) -> Self {
        let mut profile = Self::default();
        let mut start = OnWay::default();
        for (secs, acceleration, jerk) in pieces {
            profile.add(start, *secs, *acceleration, *jerk);
            start = profile.last(start);
        }
        profile
    }

    fn add(&mut self, mut start: OnWay, secs: f64, acceleration: Option<f64>, jerk: f64) {
        start.acceleration = acceleration.unwrap_or(start.acceleration);
        self.pieces.push(Piece { secs, start, jerk });
    }

    /// Where the last piece ends.
    fn last(&self, before: OnWay) -> OnWay {
        self.pieces
            .last()
            .map_or(before, |piece| piece.at(piece.secs))
    }

    /// How long it lasts.
    pub(super) fn duration_secs(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.secs).sum()
    }

    /// Where it is; at rest at its end from then on.
    pub(super) fn at(&self, secs: f64) -> OnWay {
        let mut left = secs.max(0.0);
        for piece in &self.pieces {
            if left < piece.secs {
                return piece.at(left);
            }
            left -= piece.secs;
        }
        OnWay {
            place: self.end,
            ..OnWay::default()
        }
    }
}

/// The least acceleration (as a positive number) of a stop without a time at the limit: from `b` down to `-p` and back to 0 the
/// speed changes by `(b^2 - p^2) / 2j - p^2 / 2j`.
fn least_of(start: OnWay, jerk: f64) -> f64 {
    let squared = start.acceleration * start.acceleration;
    let least = (jerk * start.speed + squared / 2.0).max(0.0).sqrt();
    least.max(-start.acceleration)
}

/// Times of a double S: of a bend of the speed, of all of its rise, at the highest speed.
fn double_s(length: f64, speed: f64, acceleration: f64, jerk: f64) -> (f64, f64, f64) {
    let (bend, rising) = match speed * jerk >= acceleration * acceleration {
        true => {
            let bend = acceleration / jerk;
            (bend, bend + speed / acceleration)
        }
        false => {
            let bend = (speed / jerk).sqrt();
            (bend, 2.0 * bend)
        }
    };
    let cruising = length / speed - rising;
    if cruising >= 0.0 {
        return (bend, rising, cruising);
    }
    // The highest speed is not reached.
    let bend = acceleration / jerk;
    if length >= 2.0 * acceleration * bend * bend {
        let rising = bend / 2.0 + (bend * bend / 4.0 + length / acceleration).sqrt();
        return (bend, rising, 0.0);
    }
    let bend = (length / (2.0 * jerk)).cbrt();
    (bend, 2.0 * bend, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(jerk: Option<f64>) -> Limits {
        Limits {
            speed: 1.5,
            acceleration: 4.0,
            jerk,
        }
    }

    /// The limits hold everywhere, speed and place are continuous, and it ends at rest.
    fn holds(profile: &Profile, limits: &Limits, from: OnWay, end: f64) {
        let duration = profile.duration_secs();
        let steps = 20_000;
        let step = duration / f64::from(steps);
        let mut before = from;
        for number in 0..=steps {
            let at = profile.at(f64::from(number) * step);
            assert!(at.speed <= limits.speed * (1.0 + 1e-9) && at.speed >= -1e-9);
            assert!(at.acceleration.abs() <= limits.acceleration * (1.0 + 1e-9));
            assert!((at.place - before.place).abs() <= limits.speed * step * 1.001 + 1e-9);
            assert!((at.speed - before.speed).abs() <= limits.acceleration * step * 1.001 + 1e-9);
            if let Some(jerk) = limits.jerk {
                let change = (at.acceleration - before.acceleration).abs();
                assert!(change <= jerk * step * 1.001 + 1e-6, "{change} at {number}");
            }
            before = at;
        }
        let last = profile.at(duration - 1e-9);
        assert!((last.place - end).abs() < 1e-6, "{last:?} for {end}");
        assert!(last.speed.abs() < 1e-6, "{last:?}");
        assert_eq!(
            profile.at(duration + 1.0),
            OnWay {
                place: profile.end,
                ..OnWay::default()
            }
        );
    }

    #[test]
    fn limits_hold_and_profiles_end_at_rest_where_they_should() {
        for jerk in [None, Some(3.0), Some(40.0), Some(1e4)] {
            for length in [1e-4, 0.02, 0.3, 1.0, 7.0] {
                let limits = limits(jerk);
                holds(
                    &Profile::over(length, &limits),
                    &limits,
                    OnWay::default(),
                    length,
                );
            }
        }
    }

    #[test]
    fn durations_are_those_of_the_closed_forms() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} for {b}");
        // A trapezoid: D / v + v / a; a triangle: 2 sqrt(D / a).
        close(
            Profile::over(3.0, &limits(None)).duration_secs(),
            3.0 / 1.5 + 1.5 / 4.0,
        );
        close(
            Profile::over(0.1, &limits(None)).duration_secs(),
            2.0 * (0.1_f64 / 4.0).sqrt(),
        );
        // A double S that reaches all limits: D / v + v / a + a / j.
        close(
            Profile::over(3.0, &limits(Some(40.0))).duration_secs(),
            3.0 / 1.5 + 1.5 / 4.0 + 4.0 / 40.0,
        );
        // One of jerk alone: 4 (D / 2j)^(1/3).
        close(
            Profile::over(1e-3, &limits(Some(40.0))).duration_secs(),
            4.0 * (1e-3_f64 / 80.0).cbrt(),
        );
        // With much jerk the double S is the trapezoid.
        let fast = Profile::over(3.0, &limits(Some(1e9))).duration_secs();
        assert!((fast - Profile::over(3.0, &limits(None)).duration_secs()).abs() < 1e-7);
    }

    #[test]
    fn braked_ones_come_to_rest_within_the_limits_and_not_beyond_the_end() {
        for jerk in [None, Some(3.0), Some(40.0), Some(400.0)] {
            let limits = limits(jerk);
            let way = Profile::over(2.0, &limits);
            for share in [0.02, 0.1, 0.3, 0.5, 0.7, 0.85, 0.97] {
                let secs = share * way.duration_secs();
                let stop = way.braked(secs, &limits);
                holds(&stop, &limits, way.at(secs), stop.end);
                assert!(stop.end <= 2.0 + 1e-6 && stop.end >= way.at(secs).place);
                assert!(stop.duration_secs() <= way.duration_secs() - secs + 1e-6);
            }
        }
    }
}
