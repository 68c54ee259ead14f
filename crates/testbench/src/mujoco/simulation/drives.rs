//! The gains and limits of drives, which weak ones have a share of.
//!
//! They stand in the model. So they can be changed only where no duplicate shares it, and a saved state does
//! not hold them: whoever changes them keeps them.

use super::super::layout;
use super::Simulation;

/// How a drive makes its force: `gains . (1, length, velocity) control + biases . (1, length, velocity)`,
/// within its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLaw {
    /// MuJoCo's `gainprm`.
    pub gains: [f64; layout::PARAMETERS],
    /// MuJoCo's `biasprm`.
    pub biases: [f64; layout::PARAMETERS],
    /// The lowest and the highest force.
    pub force_range: [f64; 2],
}

impl DriveLaw {
    /// The same drive with a share of its force.
    #[must_use]
    pub fn of_strength(&self, strength: f64) -> Self {
        Self {
            gains: self.gains.map(|number| strength * number),
            biases: self.biases.map(|number| strength * number),
            force_range: self.force_range.map(|number| strength * number),
        }
    }
}

impl Simulation {
    /// The laws of all drives, in the order of the actuators in the model.
    #[must_use]
    pub fn drives(&self) -> Vec<DriveLaw> {
        let count = self.sizes.controls;
        let gains = self.model_array(layout::MODEL_GAINS, count * layout::PARAMETERS);
        let biases = self.model_array(layout::MODEL_BIASES, count * layout::PARAMETERS);
        let ranges = self.model_array(layout::MODEL_FORCE_RANGES, count * 2);
        (0..count)
            .map(|drive| DriveLaw {
                gains: std::array::from_fn(|i| gains[drive * layout::PARAMETERS + i]),
                biases: std::array::from_fn(|i| biases[drive * layout::PARAMETERS + i]),
                force_range: std::array::from_fn(|i| ranges[drive * 2 + i]),
            })
            .collect()
    }

    /// Sets a drive's law; `false` if the model is shared with a duplicate or has fewer drives.
    pub fn set_drive(&mut self, drive: usize, law: &DriveLaw) -> bool {
        let count = self.sizes.controls;
        if drive >= count {
            return false;
        }
        let parts: [(usize, &[f64]); 3] = [
            (layout::MODEL_GAINS, &law.gains),
            (layout::MODEL_BIASES, &law.biases),
            (layout::MODEL_FORCE_RANGES, &law.force_range),
        ];
        parts.into_iter().all(|(offset, numbers)| {
            let size = numbers.len();
            self.model_array_mut(offset, count * size)
                .and_then(|all| all.get_mut(drive * size..(drive + 1) * size))
                .map(|own| own.copy_from_slice(numbers))
                .is_some()
        })
    }
}
