//! Sensors as descriptions give them: where they are, what they measure, how often and how badly.

use crate::pose::Pose;

/// A sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Index of the link that carries it; `None` for the world or for one that belongs to a joint.
    pub link: Option<usize>,
    /// Its frame in the link's frame.
    pub pose_in_link: Pose,
    /// Measurements in a second, if given.
    pub rate_hz: Option<f64>,
    /// What is added to each measurement, by quantity (`angular_velocity/x`; empty for the only one), in document
    /// order.
    pub noise: Vec<(String, Noise)>,
}

/// Gaussian noise with a bias that is drawn once.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Noise {
    /// Mean, in the unit of the measurement.
    pub mean: f64,
    /// Standard deviation.
    pub standard_deviation: f64,
    /// Mean of the bias.
    pub bias_mean: f64,
    /// Standard deviation of the bias.
    pub bias_standard_deviation: f64,
}

/// What a sensor measures.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorKind {
    /// Angular velocity, linear acceleration, orientation.
    Imu,
    /// Distances along a fan of rays in the sensor's frame, x ahead.
    Lidar(Lidar),
    /// A picture.
    Camera(Camera),
    /// Contact of the named shapes of its link (all of them, if none is named).
    Contact {
        /// Names of shapes.
        shapes: Vec<String>,
    },
    /// Force and torque across a joint.
    ForceTorque {
        /// Index of the joint.
        joint: usize,
    },
    /// Position of a joint, rad or m.
    JointPosition {
        /// Index of the joint.
        joint: usize,
    },
    /// Speed of a joint, rad/s or m/s.
    JointVelocity {
        /// Index of the joint.
        joint: usize,
    },
    /// Force at a joint that a controller may read, N or N m.
    JointEffort {
        /// Index of the joint.
        joint: usize,
    },
    /// A kind that is carried by its name alone (`gps`, `altimeter`, MJCF's `framepos`).
    Other(String),
}

impl SensorKind {
    /// The index of the joint that it measures, if any.
    pub fn joint_mut(&mut self) -> Option<&mut usize> {
        match self {
            Self::ForceTorque { joint }
            | Self::JointPosition { joint }
            | Self::JointVelocity { joint }
            | Self::JointEffort { joint } => Some(joint),
            _ => None,
        }
    }
}

/// Rays of a range finder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lidar {
    /// Rays side by side.
    pub horizontal: Fan,
    /// Rays one above the other.
    pub vertical: Fan,
    /// Nearest distance that is measured, metres.
    pub nearest_m: f64,
    /// Farthest distance that is measured, metres.
    pub farthest_m: f64,
    /// Step of the distances, metres; 0 for none.
    pub resolution_m: f64,
}

/// Equally spaced angles, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// How many.
    pub count: u32,
    /// The first, rad.
    pub first_rad: f64,
    /// The last, rad.
    pub last_rad: f64,
}

/// A pinhole camera looking along x, y to the left, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Angle of view from left to right, rad.
    pub horizontal_view_rad: f64,
    /// Columns.
    pub width_pixels: u32,
    /// Rows.
    pub height_pixels: u32,
    /// Nearest distance seen, metres.
    pub nearest_m: f64,
    /// Farthest distance seen, metres.
    pub farthest_m: f64,
    /// Whether it measures depth.
    pub depth: bool,
}
