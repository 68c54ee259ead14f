//! Questions about where things are: rays, distances between shapes, places of joints.

use std::ffi::c_int;

use super::super::functions::ObjectKind;
use super::super::layout;
use super::{BodyId, GeomId, Simulation};

/// What a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// Distance along the ray in metres (for a direction of unit length).
    pub distance_m: f64,
    /// The shape.
    pub geom: GeomId,
}

/// A joint of one simulation: where its first coordinate lies in the generalised positions and
/// velocities; obtained from [`Simulation::joint`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointId {
    position: usize,
    velocity: usize,
}

impl JointId {
    /// Index of its first number in [`Simulation::positions`].
    #[must_use]
    pub fn position_index(self) -> usize {
        self.position
    }

    /// Index of its first number in [`Simulation::velocities`].
    #[must_use]
    pub fn velocity_index(self) -> usize {
        self.velocity
    }
}

impl Simulation {
    /// The part of a step that depends on positions and velocities: where bodies are, what touches.
    ///
    /// [`Simulation::solve_and_integrate`] and then this make a step after which everything that
    /// can be asked belongs to the new positions; after [`Simulation::step`] bodies are where they
    /// were before it.
    pub fn update_positions(&mut self) {
        // SAFETY: model and data belong together and are owned by `self`.
        unsafe { (self.functions.step1)(self.model.as_ptr(), self.data.as_ptr()) }
    }

    /// The part of a step that depends on controls and forces: contact forces, accelerations, new
    /// positions. [`Simulation::update_positions`] has to come before it.
    pub fn solve_and_integrate(&mut self) {
        // SAFETY: as in `update_positions`.
        unsafe { (self.functions.step2)(self.model.as_ptr(), self.data.as_ptr()) }
    }

    /// The joint called `name`.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<JointId> {
        let index = self.find(ObjectKind::Joint, name)?;
        Some(JointId {
            position: self.joint_address(layout::MODEL_JOINT_POSITION, index)?,
            velocity: self.joint_address(layout::MODEL_JOINT_VELOCITY, index)?,
        })
    }

    /// What a ray from `from_m` along `direction` (world frame, not zero) meets first, shapes of
    /// `excluded` aside; `None` if nothing. Shapes made invisible in the model are not met.
    #[must_use]
    pub fn ray(
        &self,
        from_m: [f64; 3],
        direction: [f64; 3],
        excluded: Option<BodyId>,
    ) -> Option<RayHit> {
        let excluded = excluded.map_or(-1, |body| body.0 as c_int);
        let mut geom: c_int = -1;
        // SAFETY: both vectors have three numbers, the result one; the null pointers stand for
        // arguments that the header calls nullable (group filter, surface normal).
        let distance_m = unsafe {
            (self.functions.ray)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                from_m.as_ptr(),
                direction.as_ptr(),
                std::ptr::null(),
                true,
                excluded,
                &raw mut geom,
                std::ptr::null_mut(),
            )
        };
        let geom = GeomId(usize::try_from(geom).ok()?);
        (distance_m >= 0.0).then_some(RayHit { distance_m, geom })
    }

    /// Distance in metres between the surfaces of two shapes, negative when they overlap;
    /// `longest_m` if it is larger than that.
    pub fn geom_distance(&mut self, a: GeomId, b: GeomId, longest_m: f64) -> f64 {
        // SAFETY: both identifiers came from this model; the nullable result is not wanted.
        unsafe {
            (self.functions.geom_distance)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                a.0 as c_int,
                b.0 as c_int,
                longest_m,
                std::ptr::null_mut(),
            )
        }
    }

    /// As [`Simulation::geom_distance`], with a point of each shape's surface between which it is, in the world; the points
    /// mean nothing where the distance is `longest_m`.
    pub fn geom_nearest(&mut self, a: GeomId, b: GeomId, longest_m: f64) -> (f64, [[f64; 3]; 2]) {
        let mut points_m = [0.0; 6];
        // SAFETY: both identifiers came from this model; the result has room for two points.
        let distance_m = unsafe {
            (self.functions.geom_distance)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                a.0 as c_int,
                b.0 as c_int,
                longest_m,
                points_m.as_mut_ptr(),
            )
        };
        let point = |first: usize| std::array::from_fn(|axis| points_m[first + axis]);
        (distance_m, [point(0), point(3)])
    }

    /// An entry of one of the model's tables of joints.
    fn joint_address(&self, offset: usize, joint: usize) -> Option<usize> {
        // SAFETY: offsets come from `layout`, confirmed by the self check for this version; the
        // field is a pointer to an `int` for each joint, and `joint` is one of the model's.
        let address = unsafe {
            let table: *const c_int = self
                .model
                .as_ptr()
                .cast::<u8>()
                .add(offset)
                .cast::<*const c_int>()
                .read();
            table.add(joint).read()
        };
        usize::try_from(address).ok()
    }
}
