//! The motion-tracking system: what it reports of object, hand and head.
//!
//! Every reading carries independent normal noise on each coordinate. In a declared share of
//! readings the system confuses the object's markers: it reports the object, never the hand or the
//! head, at a point drawn uniformly from the tracked volume.

use testbench::Stream;
use testbench::geometry::{Pose, Vector};

use crate::robot::TrackedPoses;
use crate::scenario::{TrackingParameters, TrackingVolume};

/// Where things really are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TruePoses {
    pub(crate) object_m: Vector,
    pub(crate) human_hand_m: Vector,
    pub(crate) human_head: Pose,
}

/// One reading and whether it was a glitch, which the robot does not know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    pub(crate) reported: TrackedPoses,
    pub(crate) glitch: bool,
}

/// The tracking system in one episode.
#[derive(Debug, Clone)]
pub(crate) struct Tracker {
    parameters: TrackingParameters,
    volume: TrackingVolume,
    stream: Stream,
}

impl Tracker {
    pub(crate) fn new(
        parameters: &TrackingParameters,
        volume: &TrackingVolume,
        stream: Stream,
    ) -> Self {
        Self {
            parameters: parameters.clone(),
            volume: volume.clone(),
            stream,
        }
    }

    /// Readings from here on draw from another stream.
    pub(crate) fn draw_anew(&mut self, stream: Stream) {
        self.stream = stream;
    }

    /// Takes a reading. The number of draws is the same with and without a glitch, so that
    /// parameter sets share their noise under one seed.
    pub(crate) fn read(&mut self, time_secs: f64, truth: &TruePoses) -> Reading {
        let glitch = self.stream.chance(self.parameters.glitch_rate_per_reading);
        let elsewhere = std::array::from_fn(|axis| {
            self.stream.uniform(
                self.volume.glitch_low_m[axis],
                self.volume.glitch_high_m[axis],
            )
        });
        let object_m = self.noisy(truth.object_m);
        let human_hand_m = self.noisy(truth.human_hand_m);
        let head_m = self.noisy(truth.human_head.position_m);
        let reported = TrackedPoses {
            time_secs,
            object_m: if glitch { elsewhere } else { object_m },
            human_hand_m,
            human_head: Pose {
                position_m: head_m,
                orientation: truth.human_head.orientation,
            },
        };
        Reading { reported, glitch }
    }

    fn noisy(&mut self, point_m: Vector) -> Vector {
        point_m
            .map(|coordinate| coordinate + self.parameters.noise_m * self.stream.standard_normal())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::purpose::Purpose;
    use testbench::geometry::IDENTITY;

    #[test]
    fn glitches_come_at_the_declared_rate_and_move_the_object_only() {
        let parameters = TrackingParameters {
            glitch_rate_per_reading: 0.031,
            noise_m: 0.0,
        };
        let volume = TrackingVolume {
            glitch_low_m: [-1.0; 3],
            glitch_high_m: [1.0; 3],
        };
        let head = Pose {
            position_m: [1.0, 2.0, 3.0],
            orientation: IDENTITY,
        };
        let truth = TruePoses {
            object_m: [5.0; 3],
            human_hand_m: [0.5; 3],
            human_head: head,
        };
        let mut tracker = Tracker::new(&parameters, &volume, Stream::new(3, Purpose::Tracking));
        let readings: Vec<_> = (0..100_000).map(|_| tracker.read(0.0, &truth)).collect();
        let glitches = readings.iter().filter(|reading| reading.glitch).count();
        // Binomial: 3100 with a standard deviation of 55; five of them are 275.
        assert!((glitches as i64 - 3100).abs() < 275, "{glitches}");
        for reading in readings {
            assert_eq!(reading.glitch, reading.reported.object_m != [5.0; 3]);
            assert_eq!(reading.reported.human_hand_m, [0.5; 3]);
            assert_eq!(reading.reported.human_head, head);
        }
    }
}
