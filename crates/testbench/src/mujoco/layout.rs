//! Where the fields of MuJoCo 3.17.0's `mjData`, `mjContact` and `mjModel` lie, in bytes, on 64-bit machines.
//!
//! Taken with `offsetof` from the headers inside the pinned wheel. Only a dozen fields are needed;
//! everything else goes through MuJoCo's functions. The numbers are trusted only after
//! [`super::Engine::load`] has seen the exact version and a small scene has confirmed each of them
//! (see [`super::self_check`]).

/// `mjData.warning`: array of `mjWarningStat {int lastinfo; int number;}`.
pub(super) const WARNINGS: usize = 160_264;
/// `mjNWARNING`.
pub(super) const WARNING_KINDS: usize = 7;
/// `mjData.ncon`: number of contacts, `int`.
pub(super) const CONTACT_COUNT: usize = 160_560;
/// `mjData.time`: simulated time in seconds, `double`.
pub(super) const TIME: usize = 160_648;
/// `mjData.qpos`: pointer, `nq` doubles.
pub(super) const QPOS: usize = 160_688;
/// `mjData.qvel`: pointer, `nv` doubles.
pub(super) const QVEL: usize = 160_696;
/// `mjData.qacc_warmstart`: pointer, `nv` doubles.
pub(super) const WARM_START: usize = 160_720;
/// `mjData.ctrl`: pointer, `nu` doubles.
pub(super) const CTRL: usize = 160_736;
/// `mjData.qfrc_applied`: pointer, `nv` doubles.
pub(super) const QFRC_APPLIED: usize = 160_744;
/// `mjData.xfrc_applied`: pointer, 6 doubles (force, torque) for each body, at its centre of mass.
pub(super) const XFRC_APPLIED: usize = 160_752;
/// `mjData.mocap_pos`: pointer, 3 doubles for each mocap body.
pub(super) const MOCAP_POS: usize = 160_768;
/// `mjData.mocap_quat`: pointer, 4 doubles for each mocap body.
pub(super) const MOCAP_QUAT: usize = 160_776;
/// `mjData.sensordata`: pointer, `nsensordata` doubles.
pub(super) const SENSOR_DATA: usize = 160_808;
/// `mjData.xpos`: pointer, 3 doubles for each body.
pub(super) const XPOS: usize = 160_840;
/// `mjData.xquat`: pointer, 4 doubles for each body.
pub(super) const XQUAT: usize = 160_848;
/// `mjData.contact`: pointer to `ncon` contacts.
pub(super) const CONTACTS: usize = 161_472;

/// `sizeof(mjContact)`.
pub(super) const CONTACT_SIZE: usize = 584;
/// `mjContact.dist`: `double`, negative when penetrating.
pub(super) const CONTACT_DISTANCE: usize = 0;
/// `mjContact.pos`: 3 doubles, the middle of the penetration.
pub(super) const CONTACT_POSITION: usize = 8;
/// `mjContact.frame`: 9 doubles; the first three point from the first shape to the second.
pub(super) const CONTACT_FRAME: usize = 32;
/// `mjContact.geom`: two `int`.
pub(super) const CONTACT_GEOMS: usize = 540;

/// `mjModel.nsensordata`: 64-bit integer.
pub(super) const MODEL_SENSOR_DATA: usize = 744;
/// `mjModel.body_invweight0`: pointer, 2 doubles (force, torque) for each body.
pub(super) const MODEL_BODY_WEIGHTS: usize = 1_968;
/// `mjModel.dof_invweight0`: pointer, `nv` doubles.
pub(super) const MODEL_JOINT_WEIGHTS: usize = 2_352;
/// `mjModel.jnt_qposadr`: pointer, an `int` for each joint.
pub(super) const MODEL_JOINT_POSITION: usize = 2_112;
/// `mjModel.jnt_dofadr`: pointer, an `int` for each joint.
pub(super) const MODEL_JOINT_VELOCITY: usize = 2_120;

/// `mjModel.actuator_gainprm`: pointer, [`PARAMETERS`] doubles for each actuator.
pub(super) const MODEL_GAINS: usize = 4_856;
/// `mjModel.actuator_biasprm`: pointer, [`PARAMETERS`] doubles for each actuator.
pub(super) const MODEL_BIASES: usize = 4_864;
/// `mjModel.actuator_forcerange`: pointer, 2 doubles for each actuator.
pub(super) const MODEL_FORCE_RANGES: usize = 4_976;
/// `mjNGAIN` and `mjNBIAS`.
pub(super) const PARAMETERS: usize = 10;

/// `mjtState` bits used with `mj_getState` and `mj_setState`.
pub(super) mod state {
    /// `mjSTATE_TIME`.
    pub const TIME: i32 = 1 << 0;
    /// `mjSTATE_QPOS`.
    pub const QPOS: i32 = 1 << 1;
    /// `mjSTATE_QVEL`.
    pub const QVEL: i32 = 1 << 2;
    /// `mjSTATE_ACT`.
    pub const ACT: i32 = 1 << 3;
    /// `mjSTATE_HISTORY`.
    pub const HISTORY: i32 = 1 << 4;
    /// `mjSTATE_WARMSTART`.
    pub const WARMSTART: i32 = 1 << 5;
    /// `mjSTATE_CTRL`.
    pub const CTRL: i32 = 1 << 6;
    /// `mjSTATE_QFRC_APPLIED`.
    pub const QFRC_APPLIED: i32 = 1 << 7;
    /// `mjSTATE_XFRC_APPLIED`.
    pub const XFRC_APPLIED: i32 = 1 << 8;
    /// `mjSTATE_EQ_ACTIVE`.
    pub const EQ_ACTIVE: i32 = 1 << 9;
    /// `mjSTATE_MOCAP_POS`.
    pub const MOCAP_POS: i32 = 1 << 10;
    /// `mjSTATE_MOCAP_QUAT`.
    pub const MOCAP_QUAT: i32 = 1 << 11;
    /// `mjSTATE_USERDATA`.
    pub const USERDATA: i32 = 1 << 12;
    /// `mjSTATE_PLUGIN`.
    pub const PLUGIN: i32 = 1 << 13;
    /// `mjSTATE_INTEGRATION`: all of the above; restoring it continues bit for bit.
    pub const INTEGRATION: i32 = TIME
        | QPOS
        | QVEL
        | ACT
        | HISTORY
        | WARMSTART
        | CTRL
        | QFRC_APPLIED
        | XFRC_APPLIED
        | EQ_ACTIVE
        | MOCAP_POS
        | MOCAP_QUAT
        | USERDATA
        | PLUGIN;
}
