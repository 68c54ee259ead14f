//! Sensors in a scene's file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::{key_of, number_within, whole_steps, within, zero};
use crate::bench::ScenarioError;
use crate::controller::PortField;
use crate::geometry::{Vector, norm};

/// A sensor: what it measures, how often, how well, and how it fails.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
pub struct Sensor {
    /// Its name, under which a controller gets it.
    pub name: String,
    /// The robot it is on.
    pub robot: String,
    /// How often it measures.
    pub rate_hz: f64,
    /// Standard deviation of normal noise, by field with its unit: `ranges_m = 0.02`.
    #[serde(default)]
    pub noise: BTreeMap<String, Distribution>,
    /// A constant error of an episode, by field with its unit.
    #[serde(default)]
    pub bias: BTreeMap<String, Distribution>,
    /// From the measurement to its arrival; drawn for each measurement. None overtakes another.
    #[serde(default = "zero")]
    pub latency_secs: Distribution,
    /// Probability that a measurement never arrives.
    #[serde(default = "zero")]
    pub dropout_probability: Distribution,
    /// Faults that may occur.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
    /// Whether each number of a list is recorded; otherwise its smallest and where it stands.
    #[serde(default)]
    pub record_all: bool,
    /// What it measures.
    #[serde(flatten)]
    pub kind: SensorKind,
}

/// A fault of a sensor.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What happens.
    pub kind: FaultKind,
    /// Probability that it occurs in an episode.
    #[serde(default = "one")]
    pub probability: Distribution,
    /// When it begins.
    pub from_secs: Distribution,
    /// When it ends; never if left out.
    pub until_secs: Option<Distribution>,
    /// What is added, by field with its unit, for the kind `offset`.
    #[serde(default)]
    pub offset: BTreeMap<String, Distribution>,
}

/// Kinds of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// It repeats its last measurement, with new times.
    Stuck,
    /// It adds a constant.
    Offset,
    /// Nothing arrives.
    Silent,
}

impl FaultKind {
    /// The names as tests have them.
    pub const NAMES: [(Self, &'static str); 3] = [
        (Self::Stuck, "stuck"),
        (Self::Offset, "offset"),
        (Self::Silent, "silent"),
    ];
}

/// What a sensor measures. `link` is where it is mounted, the robot's root if left out; the place
/// is in the link's frame.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub enum SensorKind {
    /// `position`, `velocity` of joints; positions are multiples of the resolution.
    JointEncoder {
        /// The joints that are measured.
        joints: Vec<String>,
        /// Positions are multiples of this, in rad or m; 0 for exact ones.
        #[serde(default)]
        resolution: f64,
    },
    /// `x`, `y`, `z`, `yaw` in the world, `speed` (the magnitude of the velocity) and `turn_rate`: as motion capture has
    /// it.
    Pose {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Whether it measures `forward_velocity`, too: the signed component of the velocity along its heading.
        #[serde(default)]
        forward_velocity: bool,
    },
    /// `x`, `y`, `yaw`, `speed` (a magnitude), `turn_rate` from wheels, by dead reckoning from where the episode
    /// began; it believes the radius and separation given here.
    Odometry {
        /// The joints of the wheels on the left.
        left_joints: Vec<String>,
        /// The joints of the wheels on the right.
        right_joints: Vec<String>,
        /// The radius of the wheels, as the odometry believes it.
        wheel_radius_m: Distribution,
        /// The distance between left and right wheels, as the odometry believes it.
        wheel_separation_m: Distribution,
        /// Whether it measures `forward_velocity`, too: the signed component of the velocity along its heading.
        #[serde(default)]
        forward_velocity: bool,
    },
    /// `angular_velocity` (3) and `acceleration` (3, with gravity) in the link's frame.
    Imu {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
    },
    /// `ranges` of rays in the plane of the mount, from the first angle to the last, to the left.
    Lidar {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Where it is mounted in the link's frame, forwards.
        #[serde(default = "zero")]
        x_m: Distribution,
        /// To the left.
        #[serde(default = "zero")]
        y_m: Distribution,
        /// Upwards.
        #[serde(default = "zero")]
        z_m: Distribution,
        /// Where it looks, from the link's x axis to the left.
        #[serde(default = "zero")]
        yaw_rad: Distribution,
        /// How many rays a measurement has.
        rays: usize,
        /// The angle of the first ray, from where it looks to the left.
        #[serde(default)]
        first_angle_rad: f64,
        /// The angle of the last ray.
        #[serde(default)]
        last_angle_rad: f64,
        /// Nothing nearer than this is measured.
        #[serde(default)]
        shortest_m: f64,
        /// Nothing farther than this is measured.
        longest_m: f64,
    },
    /// `touching` and the sum of normal forces, `force`, on the link.
    Contact {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
    },
    /// `seen`, and `distance` and `bearing` (to the left) of the nearest person who is seen: within
    /// range and field of view, with a free line from the mount, and noticed.
    PersonDetector {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Where it is mounted in the link's frame, forwards.
        #[serde(default = "zero")]
        x_m: Distribution,
        /// To the left.
        #[serde(default = "zero")]
        y_m: Distribution,
        /// Upwards.
        #[serde(default = "zero")]
        z_m: Distribution,
        /// Where it looks, from the link's x axis to the left.
        #[serde(default = "zero")]
        yaw_rad: Distribution,
        /// The whole angle within which it sees.
        field_of_view_rad: f64,
        /// Nothing farther than this is measured.
        longest_m: f64,
        /// Probability that what could be seen is detected, at each measurement.
        #[serde(default = "one")]
        detection_probability: Distribution,
    },
    /// `seen`, and where a marker is in the frame of a camera (`x` along its axis, `y` to the left,
    /// `z` up) with `roll`, `pitch` and `yaw` of what carries it: if it is in view and within range,
    /// nothing stands between, and it is detected.
    MarkerCamera {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Where it is mounted in the link's frame, forwards.
        #[serde(default = "zero")]
        x_m: Distribution,
        /// To the left.
        #[serde(default = "zero")]
        y_m: Distribution,
        /// Upwards.
        #[serde(default = "zero")]
        z_m: Distribution,
        /// Where it looks, from the link's x axis to the left.
        #[serde(default = "zero")]
        yaw_rad: Distribution,
        /// Positive looks down.
        #[serde(default = "zero")]
        pitch_rad: Distribution,
        /// A robot, a person or an object; and a link or a limb of it, the first if left out.
        target: String,
        /// The link or limb that carries the marker; the first if left out.
        target_part: Option<String>,
        /// Where the marker is in that part's frame.
        #[serde(default)]
        marker_m: Vector,
        /// Where its face looks there; a marker without a face is seen from all sides.
        facing: Option<Vector>,
        /// The widest angle between its face and the line to the camera.
        #[serde(default = "steep")]
        widest_angle_rad: f64,
        /// The whole horizontal angle of its view.
        horizontal_view_rad: f64,
        /// The whole vertical angle of its view.
        vertical_view_rad: f64,
        /// Nothing nearer than this is measured.
        #[serde(default)]
        shortest_m: f64,
        /// Nothing farther than this is measured.
        longest_m: f64,
        /// Probability that what could be seen is detected, at each measurement.
        #[serde(default = "one")]
        detection_probability: Distribution,
    },
    /// `depths` along a camera's axis, row by row from the top left.
    DepthCamera {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Where it is mounted in the link's frame, forwards.
        #[serde(default = "zero")]
        x_m: Distribution,
        /// To the left.
        #[serde(default = "zero")]
        y_m: Distribution,
        /// Upwards.
        #[serde(default = "zero")]
        z_m: Distribution,
        /// Where it looks, from the link's x axis to the left.
        #[serde(default = "zero")]
        yaw_rad: Distribution,
        /// Positive looks down.
        #[serde(default = "zero")]
        pitch_rad: Distribution,
        /// Columns of the picture.
        columns: usize,
        /// Rows of the picture.
        rows: usize,
        /// The whole horizontal angle of its view.
        horizontal_view_rad: f64,
        /// The whole vertical angle of its view.
        vertical_view_rad: f64,
        /// Nothing nearer than this is measured.
        #[serde(default)]
        shortest_m: f64,
        /// Nothing farther than this is measured.
        longest_m: f64,
    },
    /// `force` (3) and `torque` (3) that the link's parent exerts on it, at and in the frame of the
    /// mount: a wrist that holds a mass bears its weight, upwards.
    ForceTorque {
        /// The link on which it is mounted; the robot's root if left out.
        link: Option<String>,
        /// Where it is mounted in the link's frame, forwards.
        #[serde(default = "zero")]
        x_m: Distribution,
        /// To the left.
        #[serde(default = "zero")]
        y_m: Distribution,
        /// Upwards.
        #[serde(default = "zero")]
        z_m: Distribution,
        /// Where it looks, from the link's x axis to the left.
        #[serde(default = "zero")]
        yaw_rad: Distribution,
    },
    /// `effort`: the torque about each joint's axis (the force along it, of a slide) that is passed on
    /// to its link.
    JointTorque {
        /// The joints that are measured.
        joints: Vec<String>,
    },
    /// What a group is at: `moving`, and `distance_left` and `angle_left`, by which its last goal was out of reach.
    Goal {
        /// The group.
        group: String,
    },
    /// What a gripper is at: `holding` something, `attached` or not, the `force` by which it is held if it is attached, and the
    /// `width` of a parallel one.
    Grip {
        /// The gripper.
        gripper: String,
    },
}

fn one() -> Distribution {
    Distribution::Constant(1.0)
}

/// Markers are found up to some 75 degrees.
fn steep() -> f64 {
    1.3
}

/// The unit as it stands at the end of a key: `m/s` as `m_s`.
#[must_use]
pub(in crate::scene) fn key_with_unit(field: &PortField) -> String {
    let unit = match field.unit.as_str() {
        "N" => "newtons",
        "Nm" => "nm",
        "m/s^2" => "m_s2",
        "rad/s" => "rad_s",
        "m/s" => "m_s",
        "1" => return field.name.clone(),
        other => other,
    };
    format!("{}_{unit}", field.name)
}

impl Sensor {
    /// The fields of its measurements.
    #[must_use]
    pub fn fields(&self) -> Vec<PortField> {
        let field = |name: &str, unit: &str, length: usize| PortField {
            name: name.to_owned(),
            unit: unit.to_owned(),
            length,
        };
        let planar = || {
            vec![
                field("yaw", "rad", 1),
                field("speed", "m/s", 1),
                field("turn_rate", "rad/s", 1),
            ]
        };
        let signed = |is_told: bool| is_told.then(|| field("forward_velocity", "m/s", 1));
        match &self.kind {
            SensorKind::JointEncoder { joints, .. } => vec![
                field("position", "rad", joints.len()),
                field("velocity", "rad/s", joints.len()),
            ],
            SensorKind::Pose {
                forward_velocity, ..
            } => {
                let place = ["x", "y", "z"].map(|axis| field(axis, "m", 1));
                let place = place.into_iter().chain(planar());
                place.chain(signed(*forward_velocity)).collect()
            }
            SensorKind::Odometry {
                forward_velocity, ..
            } => {
                let place = ["x", "y"].map(|axis| field(axis, "m", 1));
                let place = place.into_iter().chain(planar());
                place.chain(signed(*forward_velocity)).collect()
            }
            SensorKind::Imu { .. } => vec![
                field("angular_velocity", "rad/s", 3),
                field("acceleration", "m/s^2", 3),
            ],
            SensorKind::Lidar { rays, .. } => vec![field("ranges", "m", *rays)],
            SensorKind::Contact { .. } => vec![field("touching", "1", 1), field("force", "N", 1)],
            SensorKind::PersonDetector { .. } => vec![
                field("seen", "1", 1),
                field("distance", "m", 1),
                field("bearing", "rad", 1),
            ],
            SensorKind::MarkerCamera { .. } => {
                let place = ["x", "y", "z"].map(|axis| field(axis, "m", 1));
                let turn = ["roll", "pitch", "yaw"].map(|angle| field(angle, "rad", 1));
                let all = [field("seen", "1", 1)].into_iter().chain(place);
                all.chain(turn).collect()
            }
            SensorKind::DepthCamera { columns, rows, .. } => {
                vec![field("depths", "m", columns * rows)]
            }
            SensorKind::ForceTorque { .. } => {
                vec![field("force", "N", 3), field("torque", "Nm", 3)]
            }
            SensorKind::JointTorque { joints } => vec![field("effort", "Nm", joints.len())],
            SensorKind::Goal { .. } => vec![
                field("moving", "1", 1),
                field("distance_left", "m", 1),
                field("angle_left", "rad", 1),
            ],
            SensorKind::Grip { .. } => vec![
                field("holding", "1", 1),
                field("attached", "1", 1),
                field("force", "N", 1),
                field("width", "m", 1),
            ],
        }
    }

    /// What it is called in a setup.
    #[must_use]
    pub fn kind_name(&self) -> &'static str {
        match self.kind {
            SensorKind::JointEncoder { .. } => "joint_encoder",
            SensorKind::Pose { .. } => "pose",
            SensorKind::Odometry { .. } => "odometry",
            SensorKind::Imu { .. } => "imu",
            SensorKind::Lidar { .. } => "lidar",
            SensorKind::Contact { .. } => "contact",
            SensorKind::PersonDetector { .. } => "person_detector",
            SensorKind::MarkerCamera { .. } => "marker_camera",
            SensorKind::DepthCamera { .. } => "depth_camera",
            SensorKind::ForceTorque { .. } => "force_torque",
            SensorKind::JointTorque { .. } => "joint_torque",
            SensorKind::Goal { .. } => "goal",
            SensorKind::Grip { .. } => "grip",
        }
    }

    /// The link it is mounted on, if the scene names one.
    #[must_use]
    pub fn link(&self) -> Option<&str> {
        match &self.kind {
            SensorKind::Pose { link, .. }
            | SensorKind::Imu { link }
            | SensorKind::Contact { link }
            | SensorKind::Lidar { link, .. }
            | SensorKind::PersonDetector { link, .. }
            | SensorKind::MarkerCamera { link, .. }
            | SensorKind::DepthCamera { link, .. }
            | SensorKind::ForceTorque { link, .. } => link.as_deref(),
            SensorKind::JointEncoder { .. }
            | SensorKind::Odometry { .. }
            | SensorKind::JointTorque { .. }
            | SensorKind::Goal { .. }
            | SensorKind::Grip { .. } => None,
        }
    }

    /// The joints that it reads.
    #[must_use]
    pub fn joints(&self) -> Vec<&str> {
        match &self.kind {
            SensorKind::JointEncoder { joints, .. } | SensorKind::JointTorque { joints } => {
                joints.iter().map(String::as_str).collect()
            }
            SensorKind::Odometry {
                left_joints,
                right_joints,
                ..
            } => left_joints
                .iter()
                .chain(right_joints)
                .map(String::as_str)
                .collect(),
            _ => Vec::new(),
        }
    }

    /// Where it is mounted in its link.
    pub(in crate::scene) fn mount(&self) -> [(&'static str, Distribution); 5] {
        let place = |[x, y, z, yaw]: [&Distribution; 4], pitch: &Distribution| {
            [
                ("x_m", x.clone()),
                ("y_m", y.clone()),
                ("z_m", z.clone()),
                ("yaw_rad", yaw.clone()),
                ("pitch_rad", pitch.clone()),
            ]
        };
        match &self.kind {
            SensorKind::Lidar {
                x_m,
                y_m,
                z_m,
                yaw_rad,
                ..
            }
            | SensorKind::PersonDetector {
                x_m,
                y_m,
                z_m,
                yaw_rad,
                ..
            }
            | SensorKind::ForceTorque {
                x_m,
                y_m,
                z_m,
                yaw_rad,
                ..
            } => place([x_m, y_m, z_m, yaw_rad], &zero()),
            SensorKind::MarkerCamera {
                x_m,
                y_m,
                z_m,
                yaw_rad,
                pitch_rad,
                ..
            }
            | SensorKind::DepthCamera {
                x_m,
                y_m,
                z_m,
                yaw_rad,
                pitch_rad,
                ..
            } => place([x_m, y_m, z_m, yaw_rad], pitch_rad),
            _ => place([&zero(), &zero(), &zero(), &zero()], &zero()),
        }
    }

    pub(super) fn check(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("sensor", &self.name, field);
        whole_steps(&key("rate_hz"), 1.0 / self.rate_hz, time_step_secs)?;
        within(&key("latency_secs"), &self.latency_secs, 0.0, 60.0)?;
        within(
            &key("dropout_probability"),
            &self.dropout_probability,
            0.0,
            1.0,
        )?;
        let fields = self.fields();
        self.check_errors("noise", &self.noise, &fields, 0.0)?;
        self.check_errors("bias", &self.bias, &fields, -1e6)?;
        for (field, distribution) in self.mount() {
            within(&key(field), &distribution, -100.0, 100.0)?;
        }
        for (index, fault) in self.faults.iter().enumerate() {
            let field = |name: &str| key(&format!("fault.{index}.{name}"));
            within(&field("probability"), &fault.probability, 0.0, 1.0)?;
            within(&field("from_secs"), &fault.from_secs, 0.0, 1e6)?;
            if let Some(until_secs) = &fault.until_secs {
                within(&field("until_secs"), until_secs, 0.0, 1e6)?;
            }
            self.check_errors(
                &format!("fault.{index}.offset"),
                &fault.offset,
                &fields,
                -1e6,
            )?;
        }
        self.check_kind()
    }

    /// Errors belong to fields, with the field's unit in the key.
    fn check_errors(
        &self,
        list: &str,
        errors: &BTreeMap<String, Distribution>,
        fields: &[PortField],
        low: f64,
    ) -> Result<(), ScenarioError> {
        for (name, distribution) in errors {
            let key = key_of("sensor", &self.name, &format!("{list}.{name}"));
            let keys: Vec<String> = fields.iter().map(key_with_unit).collect();
            if !keys.contains(name) {
                let problem = format!("is unknown; it may be one of {}", keys.join(", "));
                return Err(ScenarioError::value(&key, &problem));
            }
            within(&key, distribution, low, 1e6)?;
        }
        Ok(())
    }

    fn check_kind(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("sensor", &self.name, field);
        match &self.kind {
            SensorKind::Lidar {
                rays,
                first_angle_rad,
                last_angle_rad,
                shortest_m,
                longest_m,
                ..
            } => {
                number_within(&key("rays"), *rays as f64, 1.0, 4096.0)?;
                number_within(&key("longest_m"), *longest_m, 1e-3, 1e4)?;
                number_within(&key("shortest_m"), *shortest_m, 0.0, *longest_m)?;
                if first_angle_rad > last_angle_rad {
                    let problem = "is above the last angle; rays are counted to the left";
                    return Err(ScenarioError::value(&key("first_angle_rad"), problem));
                }
                Ok(())
            }
            SensorKind::PersonDetector {
                field_of_view_rad,
                longest_m,
                detection_probability,
                ..
            } => {
                number_within(&key("longest_m"), *longest_m, 1e-3, 1e4)?;
                number_within(&key("field_of_view_rad"), *field_of_view_rad, 1e-3, 6.3)?;
                within(
                    &key("detection_probability"),
                    detection_probability,
                    0.0,
                    1.0,
                )
            }
            SensorKind::Odometry {
                wheel_radius_m,
                wheel_separation_m,
                ..
            } => {
                within(&key("wheel_radius_m"), wheel_radius_m, 1e-4, 100.0)?;
                within(&key("wheel_separation_m"), wheel_separation_m, 1e-4, 100.0)
            }
            SensorKind::JointEncoder { resolution, .. } => {
                number_within(&key("resolution"), *resolution, 0.0, 10.0)
            }
            SensorKind::MarkerCamera {
                widest_angle_rad,
                facing,
                detection_probability,
                ..
            } => {
                self.check_view()?;
                number_within(&key("widest_angle_rad"), *widest_angle_rad, 1e-3, 1.571)?;
                let is_direction = |facing: &Vector| norm(*facing) > 1e-6;
                if !facing.as_ref().is_none_or(is_direction) {
                    let problem = "must have a direction, such as [1.0, 0.0, 0.0]";
                    return Err(ScenarioError::value(&key("facing"), problem));
                }
                let probability = key("detection_probability");
                within(&probability, detection_probability, 0.0, 1.0)
            }
            SensorKind::DepthCamera { columns, rows, .. } => {
                self.check_view()?;
                number_within(&key("columns"), *columns as f64, 1.0, 640.0)?;
                number_within(&key("rows"), *rows as f64, 1.0, 480.0)?;
                let pixels = (*columns * *rows) as f64;
                number_within(&key("columns times rows"), pixels, 1.0, 4096.0)
            }
            SensorKind::Pose { .. }
            | SensorKind::Imu { .. }
            | SensorKind::Contact { .. }
            | SensorKind::ForceTorque { .. }
            | SensorKind::JointTorque { .. }
            | SensorKind::Goal { .. }
            | SensorKind::Grip { .. } => Ok(()),
        }
    }

    /// A camera's views are less than half a turn, and its range is not empty.
    fn check_view(&self) -> Result<(), ScenarioError> {
        let (SensorKind::MarkerCamera {
            horizontal_view_rad,
            vertical_view_rad,
            shortest_m,
            longest_m,
            ..
        }
        | SensorKind::DepthCamera {
            horizontal_view_rad,
            vertical_view_rad,
            shortest_m,
            longest_m,
            ..
        }) = &self.kind
        else {
            return Ok(());
        };
        let key = |field: &str| key_of("sensor", &self.name, field);
        number_within(&key("horizontal_view_rad"), *horizontal_view_rad, 1e-3, 3.1)?;
        number_within(&key("vertical_view_rad"), *vertical_view_rad, 1e-3, 3.1)?;
        number_within(&key("longest_m"), *longest_m, 1e-3, 1e4)?;
        number_within(&key("shortest_m"), *shortest_m, 0.0, *longest_m)
    }
}
