//! A compiled model with its data: the safe face of `mjModel` and `mjData`.

mod drives;
mod queries;
mod weights;

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::NonNull;
use std::sync::Arc;

pub use drives::DriveLaw;
pub use queries::{JointId, RayHit};

use super::EngineError;
use super::functions::{Functions, ObjectKind, RawData, RawModel};
use super::layout;

/// A body of one simulation; obtained from [`Simulation::body`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyId(usize);

/// A collision shape of one simulation; obtained from [`Simulation::geom`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GeomId(usize);

/// A contact found in the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The two shapes in contact.
    pub geoms: [GeomId; 2],
    /// Distance in metres; negative when the shapes overlap.
    pub distance_m: f64,
    /// Where, in the world: the middle of the penetration, at the beginning of the step.
    pub point_m: [f64; 3],
    /// Unit vector from the first shape to the second, in the world.
    pub normal: [f64; 3],
    /// Normal force in newtons, at least 0.
    pub normal_newtons: f64,
    /// Size of the friction force in newtons.
    pub tangential_newtons: f64,
}

/// Everything that determines how a simulation continues; see [`Simulation::save`].
#[derive(Debug, Clone, PartialEq)]
pub struct SavedState(Vec<f64>);

/// Sizes of the arrays, read once from MuJoCo.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    positions: usize,
    velocities: usize,
    controls: usize,
    bodies: usize,
    mocap_bodies: usize,
    sensor_numbers: usize,
}

/// One physics simulation: a model and its state.
pub struct Simulation {
    functions: Arc<Functions>,
    model: Arc<Model>,
    data: NonNull<RawData>,
    sizes: Sizes,
}

// SAFETY: the data are owned by this value alone and MuJoCo keeps no thread-bound state in them,
// so the whole may move to another thread. It is not `Sync`.
unsafe impl Send for Simulation {}

/// A compiled model, which nothing changes; duplicates of a simulation share it.
struct Model {
    functions: Arc<Functions>,
    raw: NonNull<RawModel>,
}

// SAFETY: MuJoCo's functions take the model as constant, so threads may read it together.
unsafe impl Send for Model {}
// SAFETY: as above.
unsafe impl Sync for Model {}

impl Model {
    fn as_ptr(&self) -> *const RawModel {
        self.raw.as_ptr()
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: compiled by this library, owned by this value, and no simulation is left.
        unsafe { (self.functions.delete_model)(self.raw.as_ptr()) }
    }
}

impl Simulation {
    /// Compiles `mjcf`; see [`super::Engine::compile`].
    pub(super) fn compile(functions: Arc<Functions>, mjcf: &str) -> Result<Self, EngineError> {
        let model = Model {
            raw: compile_model(&functions, mjcf)?,
            functions: Arc::clone(&functions),
        };
        // SAFETY: `model` was just compiled.
        let data = NonNull::new(unsafe { (functions.make_data)(model.as_ptr()) });
        let data = data.ok_or(EngineError::OutOfMemory)?;
        let size = |bits: i32, per: usize| {
            // SAFETY: `model` is valid; the function reads it only.
            usize::try_from(unsafe { (functions.state_size)(model.as_ptr(), bits) }).unwrap_or(0)
                / per
        };
        // SAFETY: the offset is confirmed by the self check for this version, and the model is valid.
        let sensor_numbers = unsafe {
            let size = model.as_ptr().cast::<u8>().add(layout::MODEL_SENSOR_DATA);
            size.cast::<i64>().read()
        };
        let sizes = Sizes {
            positions: size(layout::state::QPOS, 1),
            velocities: size(layout::state::QVEL, 1),
            controls: size(layout::state::CTRL, 1),
            bodies: size(layout::state::XFRC_APPLIED, 6),
            mocap_bodies: size(layout::state::MOCAP_POS, 3),
            sensor_numbers: usize::try_from(sensor_numbers).unwrap_or(0),
        };
        let mut simulation = Self {
            functions,
            model: Arc::new(model),
            data,
            sizes,
        };
        simulation.forward();
        Ok(simulation)
    }

    /// Another simulation of the same model in exactly the same state, what follows from the last
    /// step (poses, contacts, forces) included.
    ///
    /// # Errors
    /// [`EngineError::OutOfMemory`].
    pub fn duplicate(&self) -> Result<Self, EngineError> {
        // SAFETY: data and model belong together; for a null destination MuJoCo allocates one.
        let copy = unsafe {
            (self.functions.copy_data)(
                std::ptr::null_mut(),
                self.model.as_ptr(),
                self.data.as_ptr(),
            )
        };
        Ok(Self {
            functions: Arc::clone(&self.functions),
            model: Arc::clone(&self.model),
            data: NonNull::new(copy).ok_or(EngineError::OutOfMemory)?,
            sizes: self.sizes,
        })
    }

    /// Advances by one time step.
    pub fn step(&mut self) {
        // SAFETY: model and data belong together and are owned by `self`.
        unsafe { (self.functions.step)(self.model.as_ptr(), self.data.as_ptr()) }
    }

    /// Recomputes everything that follows from positions, velocities and controls, without
    /// advancing time.
    pub fn forward(&mut self) {
        // SAFETY: as in `step`.
        unsafe { (self.functions.forward)(self.model.as_ptr(), self.data.as_ptr()) }
    }

    /// Simulated time in seconds.
    #[must_use]
    pub fn time_secs(&self) -> f64 {
        self.field(layout::TIME)
    }

    /// Generalised positions, in the order of the joints in the model (a free joint takes 7).
    #[must_use]
    pub fn positions(&self) -> &[f64] {
        self.array(layout::QPOS, self.sizes.positions)
    }

    /// Generalised positions, to be set before [`Simulation::forward`].
    pub fn positions_mut(&mut self) -> &mut [f64] {
        self.array_mut(layout::QPOS, self.sizes.positions)
    }

    /// Generalised velocities, in the order of the joints (a free joint takes 6).
    #[must_use]
    pub fn velocities(&self) -> &[f64] {
        self.array(layout::QVEL, self.sizes.velocities)
    }

    /// Generalised velocities, to be set before [`Simulation::forward`].
    pub fn velocities_mut(&mut self) -> &mut [f64] {
        self.array_mut(layout::QVEL, self.sizes.velocities)
    }

    /// Actuator commands, in the order of the actuators in the model.
    #[must_use]
    pub fn controls(&self) -> &[f64] {
        self.array(layout::CTRL, self.sizes.controls)
    }

    /// The force and the torque applied at a body's centre of mass; see [`Simulation::set_applied_force`].
    #[must_use]
    pub fn applied_force(&self, body: BodyId) -> [f64; 6] {
        let all = self.array(layout::XFRC_APPLIED, self.sizes.bodies * 6);
        std::array::from_fn(|axis| all[body.0 * 6 + axis])
    }

    /// Actuator commands, in the order of the actuators in the model.
    pub fn controls_mut(&mut self) -> &mut [f64] {
        self.array_mut(layout::CTRL, self.sizes.controls)
    }

    /// Generalised forces applied until changed, in the order of the velocities.
    pub fn joint_forces_mut(&mut self) -> &mut [f64] {
        self.array_mut(layout::QFRC_APPLIED, self.sizes.velocities)
    }

    /// The accelerations from which the solver starts the next step, in the order of the velocities:
    /// those of the last step, unless they are changed. Where the solver converges they decide only
    /// how soon.
    pub fn warm_start_mut(&mut self) -> &mut [f64] {
        self.array_mut(layout::WARM_START, self.sizes.velocities)
    }

    /// Applies a force and a torque at a body's centre of mass, world frame, until changed.
    pub fn set_applied_force(
        &mut self,
        body: BodyId,
        force_newtons: [f64; 3],
        torque_nm: [f64; 3],
    ) {
        let wrench = self.array_mut(layout::XFRC_APPLIED, self.sizes.bodies * 6);
        wrench[body.0 * 6..body.0 * 6 + 3].copy_from_slice(&force_newtons);
        wrench[body.0 * 6 + 3..body.0 * 6 + 6].copy_from_slice(&torque_nm);
    }

    /// Places the `index`-th mocap body: position in metres, orientation as (w, x, y, z).
    /// An index beyond the model's mocap bodies is ignored.
    pub fn set_mocap(&mut self, index: usize, position: [f64; 3], quaternion: [f64; 4]) {
        if index >= self.sizes.mocap_bodies {
            return;
        }
        let count = self.sizes.mocap_bodies;
        self.array_mut(layout::MOCAP_POS, count * 3)[index * 3..index * 3 + 3]
            .copy_from_slice(&position);
        self.array_mut(layout::MOCAP_QUAT, count * 4)[index * 4..index * 4 + 4]
            .copy_from_slice(&quaternion);
    }

    /// What the model's sensors read, in their order; those of forces are of the last solved step.
    #[must_use]
    pub fn sensor_readings(&self) -> &[f64] {
        self.array(layout::SENSOR_DATA, self.sizes.sensor_numbers)
    }

    /// Position of a body's frame in the world, in metres.
    #[must_use]
    pub fn body_position(&self, body: BodyId) -> [f64; 3] {
        let all = self.array(layout::XPOS, self.sizes.bodies * 3);
        std::array::from_fn(|axis| all[body.0 * 3 + axis])
    }

    /// Orientation of a body's frame in the world, as (w, x, y, z).
    #[must_use]
    pub fn body_quaternion(&self, body: BodyId) -> [f64; 4] {
        let all = self.array(layout::XQUAT, self.sizes.bodies * 4);
        std::array::from_fn(|axis| all[body.0 * 4 + axis])
    }

    /// Angular (rad/s) and linear (m/s) velocity of a body's frame origin, in the world frame.
    #[must_use]
    pub fn body_velocity(&self, body: BodyId) -> ([f64; 3], [f64; 3]) {
        let mut result = [0.0; 6];
        // The regular body frame, whose origin is the joint side of the link, is object kind 2
        // (`mjOBJ_XBODY`); kind 1 would give the inertial frame.
        const FRAME: c_int = 2;
        // SAFETY: `body` came from this model; the result has the 6 numbers the function writes.
        unsafe {
            (self.functions.object_velocity)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                FRAME,
                body.0 as c_int,
                result.as_mut_ptr(),
                0,
            );
        }
        (
            [result[0], result[1], result[2]],
            [result[3], result[4], result[5]],
        )
    }

    /// The body called `name`.
    #[must_use]
    pub fn body(&self, name: &str) -> Option<BodyId> {
        self.find(ObjectKind::Body, name).map(BodyId)
    }

    /// The shape called `name`.
    #[must_use]
    pub fn geom(&self, name: &str) -> Option<GeomId> {
        self.find(ObjectKind::Geom, name).map(GeomId)
    }

    /// Number of contacts found in the last step, whether or not they carry force.
    #[must_use]
    pub fn contact_count(&self) -> usize {
        usize::try_from(self.field::<c_int>(layout::CONTACT_COUNT)).unwrap_or(0)
    }

    /// The contacts found in the last step, with their forces.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        (0..self.contact_count()).filter_map(|index| self.contact(index))
    }

    /// How often MuJoCo has warned (bad numbers, full buffers) since the start: 0 in a sound run.
    #[must_use]
    pub fn warning_count(&self) -> u64 {
        (0..layout::WARNING_KINDS)
            .map(|kind| {
                let number: c_int = self.field(layout::WARNINGS + kind * 8 + 4);
                u64::try_from(number).unwrap_or(0)
            })
            .sum()
    }

    /// Everything that determines the future of this simulation.
    #[must_use]
    pub fn save(&self) -> SavedState {
        SavedState(self.state(layout::state::INTEGRATION))
    }

    /// Returns to a state saved from this simulation or one of the same model; it then continues
    /// bit for bit as it did from there. A state of another model's size is refused with `false`.
    pub fn restore(&mut self, saved: &SavedState) -> bool {
        let bits = layout::state::INTEGRATION;
        // SAFETY: reads the model only.
        let size = unsafe { (self.functions.state_size)(self.model.as_ptr(), bits) };
        if usize::try_from(size) != Ok(saved.0.len()) {
            return false;
        }
        // SAFETY: the vector has exactly the size MuJoCo reads.
        unsafe {
            (self.functions.set_state)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                saved.0.as_ptr(),
                bits,
            );
        }
        true
    }

    /// A part of the state, by MuJoCo's own copying function.
    pub(super) fn state(&self, bits: i32) -> Vec<f64> {
        // SAFETY: reads the model only.
        let size = unsafe { (self.functions.state_size)(self.model.as_ptr(), bits) };
        let mut state = vec![0.0; usize::try_from(size).unwrap_or(0)];
        // SAFETY: the vector has exactly the size MuJoCo writes.
        unsafe {
            (self.functions.get_state)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                state.as_mut_ptr(),
                bits,
            );
        }
        state
    }

    /// Reads the `index`-th contact; `None` for one whose shapes are not plain geoms.
    fn contact(&self, index: usize) -> Option<Contact> {
        let contacts: *const u8 = self.field(layout::CONTACTS);
        // SAFETY: `index < ncon`, so the record lies inside MuJoCo's contact array.
        let record = unsafe { contacts.add(index * layout::CONTACT_SIZE) };
        // SAFETY: all four fields lie inside the record, aligned as in the header.
        let (distance_m, point_m, normal, geoms) = unsafe {
            (
                record.add(layout::CONTACT_DISTANCE).cast::<f64>().read(),
                record
                    .add(layout::CONTACT_POSITION)
                    .cast::<[f64; 3]>()
                    .read(),
                record.add(layout::CONTACT_FRAME).cast::<[f64; 3]>().read(),
                record
                    .add(layout::CONTACT_GEOMS)
                    .cast::<[c_int; 2]>()
                    .read(),
            )
        };
        let mut force = [0.0; 6];
        // SAFETY: `index < ncon`; the function writes 6 numbers.
        unsafe {
            (self.functions.contact_force)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                index as c_int,
                force.as_mut_ptr(),
            );
        }
        Some(Contact {
            geoms: [
                GeomId(usize::try_from(geoms[0]).ok()?),
                GeomId(usize::try_from(geoms[1]).ok()?),
            ],
            distance_m,
            point_m,
            normal,
            normal_newtons: force[0],
            tangential_newtons: force[1].hypot(force[2]),
        })
    }

    /// The identifier of a named object.
    fn find(&self, kind: ObjectKind, name: &str) -> Option<usize> {
        let name = CString::new(name).ok()?;
        // SAFETY: the name is a C string; the model is read only.
        let id = unsafe {
            (self.functions.name_to_id)(self.model.as_ptr(), kind as c_int, name.as_ptr())
        };
        usize::try_from(id).ok()
    }

    /// Reads a field of `mjData`.
    fn field<T: Copy>(&self, offset: usize) -> T {
        // SAFETY: offsets come from `layout`, confirmed by the self check for this version, and
        // each is read as the type the header gives it.
        unsafe {
            self.data
                .as_ptr()
                .cast::<u8>()
                .add(offset)
                .cast::<T>()
                .read()
        }
    }

    /// An array that `mjData` points to.
    fn array(&self, offset: usize, length: usize) -> &[f64] {
        let start: *const f64 = self.field(offset);
        if start.is_null() || length == 0 {
            return &[];
        }
        // SAFETY: MuJoCo allocated `length` doubles there, as its own size function says, and
        // nothing writes to them while `self` is borrowed.
        unsafe { std::slice::from_raw_parts(start, length) }
    }

    /// As [`Self::array`], for writing.
    fn array_mut(&mut self, offset: usize, length: usize) -> &mut [f64] {
        let start: *mut f64 = self.field(offset);
        if start.is_null() || length == 0 {
            return &mut [];
        }
        // SAFETY: as in `array`, and `self` is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(start, length) }
    }
}

impl Drop for Simulation {
    fn drop(&mut self) {
        // SAFETY: made by this library, owned by `self` and not used afterwards.
        unsafe { (self.functions.delete_data)(self.data.as_ptr()) }
    }
}

/// Parses and compiles MJCF text.
fn compile_model(functions: &Functions, mjcf: &str) -> Result<NonNull<RawModel>, EngineError> {
    let text = CString::new(mjcf).map_err(|_| EngineError::Model {
        reason: "the text holds a zero byte".to_owned(),
    })?;
    let mut message = [0 as c_char; 1024];
    // SAFETY: the text is a C string and the buffer's true size is given.
    let spec = unsafe {
        (functions.parse_xml_string)(
            text.as_ptr(),
            std::ptr::null(),
            message.as_mut_ptr(),
            message.len() as c_int,
        )
    };
    if spec.is_null() {
        // SAFETY: MuJoCo ends its message within the buffer, which starts zeroed.
        return Err(EngineError::Model {
            reason: unsafe { text_of(message.as_ptr()) },
        });
    }
    // SAFETY: `spec` was just parsed; no virtual file system is used.
    let model = NonNull::new(unsafe { (functions.compile)(spec, std::ptr::null()) });
    let result = model.ok_or_else(|| {
        // SAFETY: the message lives as long as the spec, which is deleted below.
        let reason = unsafe { text_of((functions.spec_error)(spec)) };
        EngineError::Model { reason }
    });
    // SAFETY: `spec` is owned here and not used afterwards.
    unsafe { (functions.delete_spec)(spec) };
    result
}

/// Copies a C string on one line.
///
/// # Safety
/// `text` must be null or a zero-terminated string.
unsafe fn text_of(text: *const c_char) -> String {
    if text.is_null() {
        return "no reason was given".to_owned();
    }
    // SAFETY: the caller vouches for the terminator.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
