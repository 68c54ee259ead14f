//! How easily bodies and joints give way: what the engine scales the softness of constraints with.
//!
//! A contact's regularisation is proportional to the inverse inertias of the two bodies, taken once
//! from the model's reference pose (`body_invweight0`, and `dof_invweight0` for joints' friction and
//! stops). A part of a model, compiled by itself, has other ones than the same bodies in the whole,
//! so that its contacts are softer or harder; taking over the whole's makes them the same.

use std::sync::Arc;

use super::super::layout;
use super::{BodyId, Simulation};

impl Simulation {
    /// A body's inverse inertias, for forces (1/kg) and for torques (1/(kg m²)).
    #[must_use]
    pub fn body_inverse_weights(&self, body: BodyId) -> [f64; 2] {
        let all = self.model_array(layout::MODEL_BODY_WEIGHTS, self.sizes.bodies * 2);
        std::array::from_fn(|kind| all.get(body.0 * 2 + kind).copied().unwrap_or(0.0))
    }

    /// The joints' inverse inertias, in the order of the velocities.
    #[must_use]
    pub fn joint_inverse_weights(&self) -> &[f64] {
        self.model_array(layout::MODEL_JOINT_WEIGHTS, self.sizes.velocities)
    }

    /// Sets a body's inverse inertias; `false` if the model is shared with a duplicate.
    pub fn set_body_inverse_weights(&mut self, body: BodyId, weights: [f64; 2]) -> bool {
        let count = self.sizes.bodies * 2;
        self.model_array_mut(layout::MODEL_BODY_WEIGHTS, count)
            .and_then(|all| all.get_mut(body.0 * 2..body.0 * 2 + 2))
            .map(|own| own.copy_from_slice(&weights))
            .is_some()
    }

    /// Sets the inverse inertia of one velocity's joint; `false` if the model is shared with a
    /// duplicate or has fewer velocities.
    pub fn set_joint_inverse_weight(&mut self, velocity: usize, weight: f64) -> bool {
        let count = self.sizes.velocities;
        self.model_array_mut(layout::MODEL_JOINT_WEIGHTS, count)
            .and_then(|all| all.get_mut(velocity))
            .map(|own| *own = weight)
            .is_some()
    }

    /// An array of numbers that `mjModel` points to.
    pub(super) fn model_array(&self, offset: usize, length: usize) -> &[f64] {
        let model = self.model.as_ptr().cast::<u8>();
        // SAFETY: offsets come from `layout`, confirmed by the self check for this version; the
        // field is a pointer to doubles.
        let start = unsafe { model.add(offset).cast::<*const f64>().read() };
        if start.is_null() || length == 0 {
            return &[];
        }
        // SAFETY: the header gives the array this length, and nothing writes to it but
        // `model_array_mut`, which needs the only simulation that holds the model.
        unsafe { std::slice::from_raw_parts(start, length) }
    }

    /// As [`Self::model_array`], for writing; `None` if the model is shared.
    pub(super) fn model_array_mut(&mut self, offset: usize, length: usize) -> Option<&mut [f64]> {
        let model = Arc::get_mut(&mut self.model)?.raw.as_ptr().cast::<u8>();
        // SAFETY: as in `model_array`.
        let start = unsafe { model.add(offset).cast::<*mut f64>().read() };
        if start.is_null() || length == 0 {
            return None;
        }
        // SAFETY: as in `model_array`; the model is held by `self` alone, borrowed mutably.
        Some(unsafe { std::slice::from_raw_parts_mut(start, length) })
    }
}
