//! What drives joints, and joints that follow others.

/// A drive of a joint, or the interface through which a controller commands it.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// Index of the joint it drives.
    pub joint: usize,
    /// What its command means.
    pub kind: ActuatorKind,
    /// Force at the joint for a unit of the actuator's force; the transmission's ratio.
    pub gear: f64,
    /// Range of the command in its own unit, if limited.
    pub command_range: Option<[f64; 2]>,
    /// Range of the force (N or N m, before the gear), if limited.
    pub force_range: Option<[f64; 2]>,
}

/// What an actuator's command means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ActuatorKind {
    /// A force or torque, N or N m.
    Effort,
    /// A position, rad or m, that a servo holds: force `kp (command - q) - kv q'`; a gain that the description does not
    /// give is `None`.
    Position {
        /// Stiffness, N m/rad or N/m.
        kp: Option<f64>,
        /// Damping, N m s/rad or N s/m.
        kv: Option<f64>,
    },
    /// A speed, rad/s or m/s, that a servo holds: force `kv (command - q')`.
    Velocity {
        /// Gain, N m s/rad or N s/m.
        kv: Option<f64>,
    },
    /// Force `gain command + bias[0] + bias[1] q + bias[2] q'`.
    Affine {
        /// Force for a unit of command.
        gain: f64,
        /// Constant, by position, by speed.
        bias: [f64; 3],
    },
}

/// One joint follows another: `q = c0 + c1 x + c2 x² + c3 x³ + c4 x⁴`, positions counted from their references.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// Index of the joint that follows.
    pub joint: usize,
    /// Index of the joint that leads; `None` holds the follower at `c0`.
    pub leader: Option<usize>,
    /// `c0` to `c4`.
    pub coefficients: [f64; 5],
}
