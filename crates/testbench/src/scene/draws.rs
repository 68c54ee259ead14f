//! The numbers that an episode draws from a scene's distributions.

use stimulus::Distribution;

use crate::geometry::{Pose, from_roll_pitch_yaw};
use crate::random::Stream;

use super::data::PlaceKeys;

/// Draws under a seed, each from the random stream of its key.
#[derive(Debug, Clone, Copy)]
pub(super) struct Draws {
    pub(super) seed: u64,
}

/// The number that an episode draws for a key from a distribution: the same seed and key, the same number, whatever else is
/// drawn. Scenes draw so, and whoever wants the same numbers elsewhere.
#[must_use]
pub fn drawn_number(seed: u64, key: &str, distribution: &Distribution) -> f64 {
    match distribution {
        Distribution::Constant(value) => *value,
        _ => distribution.quantile(Stream::named(seed, key).unit()),
    }
}

impl Draws {
    /// The number of a key.
    pub(super) fn number(self, key: &str, distribution: &Distribution) -> f64 {
        drawn_number(self.seed, key, distribution)
    }

    /// The number of a field of something in a list.
    pub(super) fn of(self, list: &str, name: &str, field: &str, d: &Distribution) -> f64 {
        self.number(&super::data::key_of(list, name, field), d)
    }

    /// The pose of something in a list.
    pub(super) fn place(self, list: &str, name: &str, place: &PlaceKeys) -> Pose {
        let [x, y, z, yaw] = place
            .fields()
            .map(|(field, distribution)| self.of(list, name, field, distribution));
        Pose {
            position_m: [x, y, z],
            orientation: from_roll_pitch_yaw([0.0, 0.0, yaw]),
        }
    }

    /// A stream for many draws, for example of noise.
    pub(super) fn stream(self, name: &str) -> Stream {
        Stream::named(self.seed, name)
    }
}
