//! Instruments: what is true where they are mounted, before any error.

use std::collections::BTreeMap;

use stimulus::Distribution;

use super::actuating::Actuating;
use super::build::{Built, BuiltRobot};
use super::data::{SceneData, Sensor, SensorKind};
use super::draws::Draws;
use super::sensing::joints_of;
use super::vision::{self, Marker, View};
use super::walker::{Walker, wrapped};
use super::wrench;
use crate::geometry::{
    Pose, Quaternion, Vector, add, compose, from_roll_pitch_yaw, norm, rotate, scale, subtract,
};
use crate::physics::{Layout, Physics, Touch};
use crate::random::Stream;

/// What instruments look at.
pub(super) struct Scenery<'a> {
    pub(super) now_secs: f64,
    pub(super) physics: &'a dyn Physics,
    pub(super) built: &'a Built,
    pub(super) people: &'a [Walker],
    pub(super) data: &'a SceneData,
    pub(super) actuators: &'a [Actuating],
    /// The touches of the last step.
    pub(super) touches: &'a [Touch],
}

/// Where an instrument is mounted: a body and a pose in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mount {
    pub(super) body: usize,
    pub(super) place: Pose,
}

/// What an instrument is, and what it remembers between measurements.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Instrument {
    robot_shapes: std::ops::Range<usize>,
    mount: Mount,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Encoder {
        joints: Vec<usize>,
        resolution: f64,
    },
    Pose {
        forward_velocity: bool,
    },
    Odometry(Odometry),
    Imu {
        before: Option<(f64, Vector)>,
    },
    Lidar {
        angles_rad: Vec<f64>,
        shortest_m: f64,
        longest_m: f64,
    },
    Contact,
    Detector {
        half_view_rad: f64,
        longest_m: f64,
        probability: f64,
    },
    MarkerCamera {
        view: View,
        /// `None` if there is no such target, which the scene's check refuses.
        marker: Option<Marker>,
        probability: f64,
    },
    DepthCamera {
        view: View,
        pixels: [usize; 2],
    },
    ForceTorque,
    JointTorque {
        joints: Vec<usize>,
    },
    Goal {
        group: String,
    },
    Grip {
        gripper: String,
    },
}

/// Dead reckoning from the turns of wheels.
#[derive(Debug, Clone, PartialEq)]
struct Odometry {
    left: Vec<usize>,
    right: Vec<usize>,
    radius_m: f64,
    separation_m: f64,
    forward_velocity: bool,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
    before: Option<(f64, [f64; 2])>,
}

impl Instrument {
    pub(super) fn new(sensor: &Sensor, robot: &BuiltRobot, layout: &Layout, draws: Draws) -> Self {
        let drawn = |field: &str, d: &Distribution| draws.of("sensor", &sensor.name, field, d);
        let [x, y, z, yaw, pitch] = sensor.mount().map(|(field, d)| drawn(field, &d));
        let kind = match &sensor.kind {
            SensorKind::JointEncoder { joints, resolution } => Kind::Encoder {
                joints: joints_of(robot, joints),
                resolution: *resolution,
            },
            SensorKind::Pose {
                forward_velocity, ..
            } => Kind::Pose {
                forward_velocity: *forward_velocity,
            },
            SensorKind::Odometry {
                left_joints,
                right_joints,
                wheel_radius_m,
                wheel_separation_m,
                forward_velocity,
            } => Kind::Odometry(Odometry {
                left: joints_of(robot, left_joints),
                right: joints_of(robot, right_joints),
                radius_m: drawn("wheel_radius_m", wheel_radius_m),
                separation_m: drawn("wheel_separation_m", wheel_separation_m),
                forward_velocity: *forward_velocity,
                x_m: 0.0,
                y_m: 0.0,
                yaw_rad: 0.0,
                before: None,
            }),
            SensorKind::Imu { .. } => Kind::Imu { before: None },
            SensorKind::Lidar {
                rays,
                first_angle_rad,
                last_angle_rad,
                shortest_m,
                longest_m,
                ..
            } => Kind::Lidar {
                angles_rad: angles(*rays, *first_angle_rad, *last_angle_rad),
                shortest_m: *shortest_m,
                longest_m: *longest_m,
            },
            SensorKind::Contact { .. } => Kind::Contact,
            SensorKind::PersonDetector {
                field_of_view_rad,
                longest_m,
                detection_probability,
                ..
            } => Kind::Detector {
                half_view_rad: field_of_view_rad / 2.0,
                longest_m: *longest_m,
                probability: drawn("detection_probability", detection_probability),
            },
            SensorKind::MarkerCamera {
                target,
                target_part,
                marker_m,
                facing,
                widest_angle_rad,
                horizontal_view_rad,
                vertical_view_rad,
                shortest_m,
                longest_m,
                detection_probability,
                ..
            } => Kind::MarkerCamera {
                view: View::new(
                    *horizontal_view_rad,
                    *vertical_view_rad,
                    *shortest_m,
                    *longest_m,
                ),
                marker: Marker::find(
                    layout,
                    (target, target_part.as_deref()),
                    *marker_m,
                    facing.map(|facing| (facing, *widest_angle_rad)),
                ),
                probability: drawn("detection_probability", detection_probability),
            },
            SensorKind::DepthCamera {
                columns,
                rows,
                horizontal_view_rad,
                vertical_view_rad,
                shortest_m,
                longest_m,
                ..
            } => Kind::DepthCamera {
                view: View::new(
                    *horizontal_view_rad,
                    *vertical_view_rad,
                    *shortest_m,
                    *longest_m,
                ),
                pixels: [*columns, *rows],
            },
            SensorKind::ForceTorque { .. } => Kind::ForceTorque,
            SensorKind::JointTorque { joints } => Kind::JointTorque {
                joints: joints_of(robot, joints),
            },
            SensorKind::Goal { group } => Kind::Goal {
                group: group.clone(),
            },
            SensorKind::Grip { gripper } => Kind::Grip {
                gripper: gripper.clone(),
            },
        };
        Self {
            robot_shapes: robot.added.shapes.clone(),
            mount: Mount {
                body: robot.body(sensor.link()).unwrap_or(robot.added.root),
                place: Pose {
                    position_m: [x, y, z],
                    orientation: from_roll_pitch_yaw([0.0, pitch, yaw]),
                },
            },
            kind,
        }
    }

    /// What stays the same, for the controller's setup.
    pub(super) fn facts(&self, sensor: &Sensor) -> BTreeMap<String, f64> {
        let mut facts = BTreeMap::from([("rate_hz".to_owned(), sensor.rate_hz)]);
        let mut fact = |name: &str, value: f64| {
            facts.insert(name.to_owned(), value);
        };
        match &self.kind {
            Kind::Lidar {
                angles_rad,
                shortest_m,
                longest_m,
            } => {
                fact(
                    "first_angle_rad",
                    angles_rad.first().copied().unwrap_or(0.0),
                );
                let step = angles_rad
                    .get(1)
                    .map_or(0.0, |second| second - angles_rad[0]);
                fact("angle_step_rad", step);
                fact("shortest_m", *shortest_m);
                fact("longest_m", *longest_m);
            }
            Kind::Detector {
                half_view_rad,
                longest_m,
                ..
            } => {
                fact("field_of_view_rad", 2.0 * half_view_rad);
                fact("longest_m", *longest_m);
            }
            Kind::MarkerCamera { view, .. } => {
                for (name, value) in view.facts() {
                    fact(name, value);
                }
            }
            Kind::DepthCamera { view, pixels } => {
                for (name, value) in view.facts() {
                    fact(name, value);
                }
                fact("columns", pixels[0] as f64);
                fact("rows", pixels[1] as f64);
            }
            _ => {}
        }
        facts
    }

    /// The true numbers, a list for each field.
    pub(super) fn measure(
        &mut self,
        scenery: &mut Scenery<'_>,
        stream: &mut Stream,
    ) -> Vec<Vec<f64>> {
        let one = |numbers: &[f64]| numbers.iter().map(|number| vec![*number]).collect();
        match &mut self.kind {
            Kind::Encoder { joints, resolution } => encoder(scenery, joints, *resolution),
            Kind::Pose { forward_velocity } => {
                let pose = scenery.physics.body_pose(self.mount.body);
                let twist = scenery.physics.body_twist(self.mount.body);
                let [x, y, z] = pose.position_m;
                let yaw_rad = yaw_of(pose.orientation);
                let (sine, cosine) = yaw_rad.sin_cos();
                let speed = norm(twist.linear_m_s);
                let mut numbers = vec![x, y, z, yaw_rad, speed, twist.angular_rad_s[2]];
                if *forward_velocity {
                    numbers.push(twist.linear_m_s[0] * cosine + twist.linear_m_s[1] * sine);
                }
                one(&numbers)
            }
            Kind::Odometry(odometry) => one(&odometry.reckon(scenery)),
            Kind::Imu { before } => imu(scenery, self.mount.body, before),
            Kind::Lidar {
                angles_rad,
                shortest_m,
                longest_m,
            } => {
                let at = pose_of(scenery, &self.mount);
                let seen = |shape: usize| !self.robot_shapes.contains(&shape);
                let range = |angle_rad: &f64| {
                    let direction = rotate(at.orientation, [angle_rad.cos(), angle_rad.sin(), 0.0]);
                    let hit = scenery
                        .physics
                        .ray(at.position_m, direction, *longest_m, &seen);
                    let range_m = hit.map_or(f64::NAN, |hit| hit.distance_m);
                    if range_m < *shortest_m {
                        f64::NAN
                    } else {
                        range_m
                    }
                };
                vec![angles_rad.iter().map(range).collect()]
            }
            Kind::Contact => {
                let force: f64 = touching(scenery, self.mount.body).sum();
                let is_touching = touching(scenery, self.mount.body).next().is_some();
                one(&[f64::from(u8::from(is_touching)), force])
            }
            Kind::Detector {
                half_view_rad,
                longest_m,
                probability,
            } => {
                let limits = (*half_view_rad, *longest_m, *probability);
                one(&detect(
                    scenery,
                    &self.mount,
                    &self.robot_shapes,
                    limits,
                    stream,
                ))
            }
            Kind::MarkerCamera {
                view,
                marker,
                probability,
            } => match marker {
                Some(marker) => one(&vision::detect(
                    scenery,
                    &self.mount,
                    view,
                    marker,
                    *probability,
                    stream,
                )),
                None => one(&[f64::NAN; 7]),
            },
            Kind::DepthCamera { view, pixels } => {
                vec![vision::depths(scenery, &self.mount, view, *pixels)]
            }
            Kind::ForceTorque => wrench::at_flange(scenery, &self.mount),
            Kind::JointTorque { joints } => wrench::at_joints(scenery, joints),
            Kind::Goal { group } => one(&goal(scenery, group)),
            Kind::Grip { gripper } => one(&grip(scenery, gripper)),
        }
    }
}

fn angles(rays: usize, first_rad: f64, last_rad: f64) -> Vec<f64> {
    let step_rad = (last_rad - first_rad) / (rays.max(2) - 1) as f64;
    (0..rays)
        .map(|ray| first_rad + step_rad * ray as f64)
        .collect()
}

/// The turn about the vertical of what an orientation makes of the x axis.
pub(super) fn yaw_of(orientation: Quaternion) -> f64 {
    let [x, y, _] = rotate(orientation, [1.0, 0.0, 0.0]);
    y.atan2(x)
}

/// The frame of an instrument in the world.
pub(super) fn pose_of(scenery: &Scenery<'_>, mount: &Mount) -> Pose {
    let body = scenery.physics.body_pose(mount.body);
    Pose {
        position_m: add(
            body.position_m,
            rotate(body.orientation, mount.place.position_m),
        ),
        orientation: compose(body.orientation, mount.place.orientation),
    }
}

fn encoder(scenery: &Scenery<'_>, joints: &[usize], resolution: f64) -> Vec<Vec<f64>> {
    let states = joints.iter().map(|joint| scenery.physics.joint(*joint));
    let rounded = |position: f64| {
        if resolution > 0.0 {
            (position / resolution).round() * resolution
        } else {
            position
        }
    };
    let (positions, velocities) = states
        .map(|state| (rounded(state.position), state.velocity))
        .unzip();
    vec![positions, velocities]
}

/// Angular velocity and specific force in the body's frame; the acceleration is the mean since the
/// measurement before.
fn imu(scenery: &Scenery<'_>, body: usize, before: &mut Option<(f64, Vector)>) -> Vec<Vec<f64>> {
    let twist = scenery.physics.body_twist(body);
    let pose = scenery.physics.body_pose(body);
    let acceleration = match *before {
        Some((then_secs, velocity)) if scenery.now_secs > then_secs => scale(
            1.0 / (scenery.now_secs - then_secs),
            subtract(twist.linear_m_s, velocity),
        ),
        _ => [0.0; 3],
    };
    *before = Some((scenery.now_secs, twist.linear_m_s));
    let specific = add(acceleration, [0.0, 0.0, scenery.built.layout.gravity_m_s2]);
    let [w, x, y, z] = pose.orientation;
    let back = [w, -x, -y, -z];
    vec![
        rotate(back, twist.angular_rad_s).to_vec(),
        rotate(back, specific).to_vec(),
    ]
}

/// Whether a group is on its way, and by how much its last goal was out of reach.
fn goal(scenery: &Scenery<'_>, group: &str) -> [f64; 3] {
    let named = scenery.actuators.iter().find(|it| it.name == group);
    let group = named.and_then(|it| it.group.as_ref());
    group.map_or([f64::NAN; 3], |group| {
        let [distance_m, angle_rad] = group.left();
        [
            f64::from(u8::from(group.is_moving())),
            distance_m,
            angle_rad,
        ]
    })
}

/// Whether a gripper holds something, whether that is attached, by which force, and its width.
fn grip(scenery: &Scenery<'_>, gripper: &str) -> [f64; 4] {
    let named = scenery.actuators.iter().find(|it| it.name == gripper);
    let gripper = named.and_then(|it| it.gripper.as_ref());
    gripper.map_or([f64::NAN; 4], |gripper| {
        let row = gripper.row(
            scenery.data,
            scenery.built,
            scenery.physics,
            scenery.touches,
        );
        let number = |place: usize| row.get(place).copied().unwrap_or(f64::NAN);
        [number(0).min(1.0), number(1), number(2), number(3)]
    })
}

/// The normal forces on a body.
fn touching<'a>(scenery: &'a Scenery<'_>, body: usize) -> impl Iterator<Item = f64> + 'a {
    let shapes = &scenery.built.layout.shapes;
    let is_of = move |shape: usize| shapes.get(shape).is_some_and(|s| s.body == Some(body));
    scenery
        .touches
        .iter()
        .filter(move |touch| touch.normal_newtons > 0.0 && touch.shapes.iter().any(|s| is_of(*s)))
        .map(|touch| touch.normal_newtons)
}

/// Whether anybody is seen, and where the nearest is. One draw for each person.
fn detect(
    scenery: &Scenery<'_>,
    mount: &Mount,
    own: &std::ops::Range<usize>,
    (half_view_rad, longest_m, probability): (f64, f64, f64),
    stream: &mut Stream,
) -> [f64; 3] {
    let at = pose_of(scenery, mount);
    let heading_rad = yaw_of(at.orientation);
    let mut nearest = [0.0, f64::NAN, f64::NAN];
    for (walker, person) in scenery.people.iter().zip(&scenery.built.people) {
        let is_noticed = stream.chance(probability);
        let height_m = at.position_m[2].clamp(0.1, 0.95 * person.height_m);
        let towards = subtract(
            [walker.stance.x_m, walker.stance.y_m, height_m],
            at.position_m,
        );
        let distance_m = norm(towards);
        let bearing_rad = wrapped(towards[1].atan2(towards[0]) - heading_rad);
        if !is_noticed || distance_m > longest_m || bearing_rad.abs() > half_view_rad {
            continue;
        }
        let direction = scale(1.0 / distance_m.max(1e-9), towards);
        let seen = |shape: usize| !own.contains(&shape);
        let hit = scenery
            .physics
            .ray(at.position_m, direction, distance_m, &seen);
        let is_free = hit.is_none_or(|hit| person.shapes.contains(&hit.shape));
        if is_free && (nearest[1].is_nan() || distance_m < nearest[1]) {
            nearest = [1.0, distance_m, bearing_rad];
        }
    }
    nearest
}

impl Odometry {
    /// Advances the reckoned pose by the mean of the wheels' turns on either side, along an arc's
    /// chord at the middle heading.
    fn reckon(&mut self, scenery: &Scenery<'_>) -> Vec<f64> {
        let mean = |joints: &[usize]| {
            let sum: f64 = joints
                .iter()
                .map(|joint| scenery.physics.joint(*joint).position)
                .sum();
            sum / joints.len().max(1) as f64
        };
        let now = [mean(&self.left), mean(&self.right)];
        let (mut forwards_m_s, mut turn_rate_rad_s) = (0.0, 0.0);
        if let Some((then_secs, before)) = self.before {
            let left_m = self.radius_m * (now[0] - before[0]);
            let right_m = self.radius_m * (now[1] - before[1]);
            let (ahead_m, turn_rad) = (
                (left_m + right_m) / 2.0,
                (right_m - left_m) / self.separation_m,
            );
            let middle_rad = self.yaw_rad + turn_rad / 2.0;
            self.x_m += ahead_m * middle_rad.cos();
            self.y_m += ahead_m * middle_rad.sin();
            self.yaw_rad = wrapped(self.yaw_rad + turn_rad);
            let elapsed_secs = scenery.now_secs - then_secs;
            if elapsed_secs > 0.0 {
                forwards_m_s = ahead_m / elapsed_secs;
                turn_rate_rad_s = turn_rad / elapsed_secs;
            }
        }
        self.before = Some((scenery.now_secs, now));
        let speed_m_s = forwards_m_s.abs();
        let mut numbers = vec![self.x_m, self.y_m, self.yaw_rad, speed_m_s, turn_rate_rad_s];
        if self.forward_velocity {
            numbers.push(forwards_m_s);
        }
        numbers
    }
}
