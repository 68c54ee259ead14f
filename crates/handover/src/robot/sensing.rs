//! The robot's three judgements of the human, from encoders and tracking.
//!
//! Gaze: with `h` the head's position, `f` its facing direction and `p` the object's reported
//! position, let `d = (p - h)·f` and `r = |p - h - d f|`. The human looks at the object when
//! `d > 0` and `r <= r0 + d tan(a)`: a cone of half angle `a` that has radius `r0` at the head.
//!
//! Location: the hand lies within a tolerance, axis by axis, of a point at a fixed offset from the
//! object's reported centre.
//!
//! Pressure: some finger encoder has moved by more than a lower and less than an upper number of
//! counts since it was first read.

use testbench::geometry::{add, dot, norm, rotate, scale, subtract, within_box};

use super::interface::{Readings, TrackedPoses};
use crate::scenario::{SensorRule, Sensors};

/// What a sensor node makes of its readings since sensing began.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Latch {
    any: bool,
    last: Option<bool>,
}

impl Latch {
    /// Takes a reading, if there is one.
    fn take(&mut self, reading: Option<bool>) {
        if let Some(satisfied) = reading {
            self.any |= satisfied;
            self.last = Some(satisfied);
        }
    }

    /// `None` while there has been no reading.
    fn report(&self, rule: SensorRule) -> Option<bool> {
        self.last.map(|last| match rule {
            SensorRule::Any => self.any,
            SensorRule::Last => last,
        })
    }
}

/// What the three sensors say; `None` while one has not read anything.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SensorReport {
    /// The human looks at the object.
    pub gaze: Option<bool>,
    /// The human pulls on the object.
    pub pressure: Option<bool>,
    /// The human's hand is on the object.
    pub location: Option<bool>,
}

impl SensorReport {
    /// Whether every sensor has read something.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.gaze.is_some() && self.pressure.is_some() && self.location.is_some()
    }

    /// Whether all three are satisfied.
    #[must_use]
    pub fn all_satisfied(&self) -> bool {
        [self.gaze, self.pressure, self.location] == [Some(true); 3]
    }
}

/// The sensor nodes during one sensing phase.
#[derive(Debug, Clone)]
pub struct SensorNodes {
    rules: Sensors,
    baseline_after_secs: f64,
    began_secs: f64,
    baseline_counts: Option<Vec<i64>>,
    gaze: Latch,
    pressure: Latch,
    location: Latch,
    largest_displacement_counts: i64,
}

impl SensorNodes {
    /// Starts sensing at `now_secs`; the fingers are first read `baseline_after_secs` later.
    #[must_use]
    pub fn begin(rules: &Sensors, baseline_after_secs: f64, now_secs: f64) -> Self {
        Self {
            rules: rules.clone(),
            baseline_after_secs,
            began_secs: now_secs,
            baseline_counts: None,
            gaze: Latch::default(),
            pressure: Latch::default(),
            location: Latch::default(),
            largest_displacement_counts: 0,
        }
    }

    /// Takes one reading of each sensor.
    pub fn read(&mut self, readings: &Readings<'_>) {
        let (rules, outside) = (&self.rules, &readings.sensors);
        let gaze = readings.tracking.map(|it| gaze_satisfied(rules, it));
        let location = readings.tracking.map(|it| location_satisfied(rules, it));
        self.gaze.take(outside.gaze.or(gaze));
        self.location.take(outside.location.or(location));
        if readings.clock_secs - self.began_secs < self.baseline_after_secs - 1e-9 {
            return;
        }
        let baseline = self
            .baseline_counts
            .get_or_insert_with(|| readings.finger_counts.to_vec());
        let moved = largest_displacement(baseline, readings.finger_counts);
        self.largest_displacement_counts = self.largest_displacement_counts.max(moved);
        let pressure = pressure_satisfied(rules, baseline, readings.finger_counts);
        self.pressure.take(outside.pressure.or(Some(pressure)));
    }

    /// What the sensors say now.
    #[must_use]
    pub fn report(&self) -> SensorReport {
        SensorReport {
            gaze: self.gaze.report(self.rules.gaze_rule),
            pressure: self.pressure.report(self.rules.pressure_rule),
            location: self.location.report(self.rules.location_rule),
        }
    }

    /// The largest displacement of a finger since the baseline, in counts, over all readings.
    #[must_use]
    pub fn largest_displacement_counts(&self) -> i64 {
        self.largest_displacement_counts
    }
}

/// The largest displacement of any finger, in counts.
fn largest_displacement(baseline: &[i64], counts: &[i64]) -> i64 {
    let moved = baseline
        .iter()
        .zip(counts)
        .map(|(before, now)| (now - before).abs());
    moved.max().unwrap_or(0)
}

/// Whether the human looks at where the object is said to be.
pub(crate) fn gaze_satisfied(rules: &Sensors, tracked: &TrackedPoses) -> bool {
    let facing = rotate(tracked.human_head.orientation, [1.0, 0.0, 0.0]);
    let to_object = subtract(tracked.object_m, tracked.human_head.position_m);
    let along = dot(to_object, facing);
    let across = norm(subtract(to_object, scale(along, facing)));
    along > 0.0 && across <= rules.gaze_head_radius_m + along * rules.gaze_half_angle_rad.tan()
}

/// Whether the hand is where a hand on the object would be.
pub(crate) fn location_satisfied(rules: &Sensors, tracked: &TrackedPoses) -> bool {
    let expected = add(tracked.object_m, rules.location_offset_m);
    within_box(tracked.human_hand_m, expected, rules.location_tolerance_m)
}

/// Whether some finger has moved as a pull moves it.
pub(crate) fn pressure_satisfied(rules: &Sensors, baseline: &[i64], counts: &[i64]) -> bool {
    let [low, high] = rules.pressure_counts;
    baseline.iter().zip(counts).any(|(before, now)| {
        let moved = (now - before).abs();
        moved > low && moved < high
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outside::{Reading, SensorsOutside};
    use crate::robot::PlannerStatus;
    use testbench::geometry::{IDENTITY, Pose, Vector, about};

    fn rules() -> Sensors {
        Sensors {
            finger_counts_per_rad: 1000.0,
            pressure_counts: [8, 4000],
            gaze_head_radius_m: 0.1,
            gaze_half_angle_rad: 40.0_f64.to_radians(),
            location_offset_m: [0.0, 0.0, -0.1],
            location_tolerance_m: [0.3; 3],
            gaze_rule: SensorRule::Any,
            pressure_rule: SensorRule::Any,
            location_rule: SensorRule::Last,
        }
    }

    fn tracked(object_m: Vector, human_hand_m: Vector, yaw_rad: f64) -> TrackedPoses {
        let orientation = if yaw_rad == 0.0 {
            IDENTITY
        } else {
            about([0.0, 0.0, 1.0], yaw_rad)
        };
        let human_head = Pose {
            position_m: [0.0; 3],
            orientation,
        };
        TrackedPoses {
            time_secs: 0.0,
            object_m,
            human_hand_m,
            human_head,
        }
    }

    #[test]
    fn the_gaze_cone_ends_where_its_closed_form_says() {
        let looks =
            |object_m, yaw_rad| gaze_satisfied(&rules(), &tracked(object_m, [0.0; 3], yaw_rad));
        for distance_m in [0.2, 1.0, 3.0] {
            // tan 40 degrees is 0.8390996.
            let edge_m = 0.1 + 0.839_099_6 * distance_m;
            assert!(looks([distance_m, 0.0, edge_m - 1e-6], 0.0));
            assert!(!looks([distance_m, 0.0, edge_m + 1e-6], 0.0));
            assert!(!looks([-distance_m, 0.0, 0.0], 0.0), "behind the head");
        }
        // Facing along y, an object on the x axis is a quarter turn away.
        assert!(!looks([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2));
        assert!(looks([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2));
    }

    #[test]
    fn the_location_box_is_centred_below_the_object() {
        let there = |hand_m| location_satisfied(&rules(), &tracked([1.0, 2.0, 3.0], hand_m, 0.0));
        assert!(there([1.29, 1.71, 2.61]) && there([0.71, 2.29, 3.19]));
        for outside in [
            [1.31, 2.0, 2.9],
            [1.0, 2.31, 2.9],
            [1.0, 2.0, 3.21],
            [1.0, 2.0, 2.59],
        ] {
            assert!(!there(outside), "{outside:?}");
        }
    }

    #[test]
    fn pressure_needs_more_than_the_lower_and_fewer_than_the_upper_count() {
        for (moved, expected) in [
            (8, false),
            (9, true),
            (-9, true),
            (3999, true),
            (4000, false),
        ] {
            assert_eq!(
                pressure_satisfied(&rules(), &[0, 50], &[0, 50 + moved]),
                expected,
                "{moved}"
            );
        }
    }

    #[test]
    fn fingers_count_from_their_first_reading_and_each_rule_reports_its_own_way() {
        let mut nodes = SensorNodes::begin(&rules(), 1.0, 10.0);
        let good = tracked([1.0, 0.0, 0.0], [1.0, 0.0, -0.1], 0.0);
        let glitched = tracked([-1.0, 0.0, 0.0], [1.0, 0.0, -0.1], 0.0);
        let mut read = |clock_secs: f64, counts: &[i64], tracking: &TrackedPoses| {
            nodes.read(&Readings {
                clock_secs,
                arm_rad: &[],
                finger_counts: counts,
                tracking: Some(tracking),
                activated: true,
                human_ready: true,
                planner: PlannerStatus::Idle,
                sensors: SensorsOutside::default(),
            });
            nodes.report()
        };
        assert_eq!(
            read(10.5, &[0], &good).pressure,
            None,
            "before the baseline"
        );
        assert_eq!(
            read(11.0, &[100], &good).pressure,
            Some(false),
            "the baseline itself"
        );
        assert_eq!(read(11.1, &[120], &good).pressure, Some(true));
        let last = read(11.2, &[100], &glitched);
        assert_eq!(last.pressure, Some(true), "any");
        assert_eq!(
            (last.gaze, last.location),
            (Some(true), Some(false)),
            "any, last"
        );
        assert!(last.complete() && !last.all_satisfied());
        assert_eq!(nodes.largest_displacement_counts(), 20);
    }

    #[test]
    fn a_sensor_outside_replaces_the_simulated_one_and_says_nothing_while_it_is_not_known() {
        let good = tracked([1.0, 0.0, 0.0], [1.0, 0.0, -0.1], 0.0);
        let mut nodes = SensorNodes::begin(&rules(), 0.0, 0.0);
        let mut read = |clock_secs: f64, gaze: Reading<bool>, pressure: Reading<bool>| {
            nodes.read(&Readings {
                clock_secs,
                arm_rad: &[],
                finger_counts: &[0],
                tracking: Some(&good),
                activated: true,
                human_ready: true,
                planner: PlannerStatus::Idle,
                sensors: SensorsOutside {
                    gaze,
                    pressure,
                    location: Reading::Simulated,
                },
            });
            nodes.report()
        };
        let unknown = Reading::Outside(None);
        let first = read(1.0, unknown, unknown);
        assert_eq!((first.gaze, first.pressure), (None, None));
        assert_eq!(first.location, Some(true), "still simulated");
        let second = read(1.1, Reading::Outside(Some(false)), unknown);
        assert_eq!((second.gaze, second.pressure), (Some(false), None));
        // No finger has moved: the simulation would deny the pull.
        let third = read(1.2, unknown, Reading::Outside(Some(true)));
        assert_eq!((third.gaze, third.pressure), (Some(false), Some(true)));
    }
}
