//! MuJoCo as a [`Physics`].

use super::layout::{Layout, Motion};
use super::{DriveState, Hit, JointState, Nearest, Physics, PhysicsState, Touch, Twist, mjcf_of};
use crate::geometry::{Pose, Vector, add, scale, subtract};
use crate::mujoco::{
    BodyId, DriveLaw, Engine, EngineError, GeomId, JointId, SavedState, Simulation,
};

/// How far behind the surface of a shape that is not seen a ray starts again, in metres.
const BEYOND_M: f64 = 1e-6;
/// How many such shapes a ray passes at most.
const PASSED: usize = 64;

/// A scene in MuJoCo.
pub struct MujocoPhysics {
    version: String,
    simulation: Simulation,
    bodies: Vec<BodyId>,
    joints: Vec<JointId>,
    geoms: Vec<GeomId>,
    /// For each body that is led its place among MuJoCo's.
    led: Vec<Option<usize>>,
    touches: Vec<Touch>,
    /// The bodies of which wrenches are asked for, and those of the last step.
    borne: Vec<usize>,
    wrenches: Vec<f64>,
    /// The drives as the layout has them, and the shares that they have.
    drives: Vec<DriveLaw>,
    strengths: Vec<f64>,
}

/// A saved state.
struct Saved {
    engine: SavedState,
    touches: Vec<Touch>,
    wrenches: Vec<f64>,
    strengths: Vec<f64>,
}

impl MujocoPhysics {
    /// Builds the layout in MuJoCo.
    ///
    /// # Errors
    /// When MuJoCo refuses it, or a name is used twice.
    pub fn new(engine: &Engine, layout: &Layout) -> Result<Self, EngineError> {
        let simulation = engine.compile(&mjcf_of(layout))?;
        let lost = |name: &str| EngineError::Model {
            reason: format!("`{name}` is not found again"),
        };
        let bodies = layout.bodies.iter();
        let joints = layout.joints.iter();
        let shapes = layout.shapes.iter();
        let mut count = 0;
        // MuJoCo numbers them in the order of the text: depth first. They hang on the world, so
        // that is their order in the layout.
        let led = layout.bodies.iter().map(|body| {
            (body.motion == Motion::Led).then(|| {
                count += 1;
                count - 1
            })
        });
        let wrenches = simulation.sensor_readings().to_vec();
        let drives = simulation.drives();
        Ok(Self {
            strengths: vec![1.0; drives.len()],
            drives,
            borne: layout.wrenches.clone(),
            wrenches,
            led: led.collect(),
            bodies: bodies
                .map(|body| simulation.body(&body.name).ok_or_else(|| lost(&body.name)))
                .collect::<Result<_, _>>()?,
            joints: joints
                .map(|joint| {
                    simulation
                        .joint(&joint.name)
                        .ok_or_else(|| lost(&joint.name))
                })
                .collect::<Result<_, _>>()?,
            geoms: shapes
                .map(|shape| {
                    simulation
                        .geom(&shape.name)
                        .ok_or_else(|| lost(&shape.name))
                })
                .collect::<Result<_, _>>()?,
            version: engine.version(),
            simulation,
            touches: Vec::new(),
        })
    }

    fn collect_touches(&mut self) {
        let mut touches = std::mem::take(&mut self.touches);
        touches.clear();
        let found = self.simulation.contacts().filter_map(|contact| {
            let [a, b] = contact.geoms;
            Some(Touch {
                shapes: [self.shape_of(a)?, self.shape_of(b)?],
                normal_newtons: contact.normal_newtons,
                tangential_newtons: contact.tangential_newtons,
                point_m: contact.point_m,
                normal: contact.normal,
            })
        });
        touches.extend(found);
        self.touches = touches;
    }

    /// Copies what links bear: positions are brought up to date after a step, forces are not.
    fn collect_wrenches(&mut self) {
        let readings = self.simulation.sensor_readings();
        self.wrenches.clear();
        self.wrenches.extend_from_slice(readings);
    }

    fn shape_of(&self, geom: GeomId) -> Option<usize> {
        self.geoms.iter().position(|known| *known == geom)
    }
}

impl Physics for MujocoPhysics {
    fn engine(&self) -> (&'static str, String) {
        ("MuJoCo", self.version.clone())
    }

    fn substeps(&self) -> usize {
        1
    }

    /// The contact forces are those that made the step; everything else is as it is after it. So a
    /// restored state answers exactly as the one that was saved.
    fn step(&mut self) {
        self.simulation.solve_and_integrate();
        self.collect_touches();
        self.collect_wrenches();
        self.simulation.update_positions();
    }

    fn refresh(&mut self) {
        self.simulation.forward();
        self.collect_wrenches();
    }

    fn time_secs(&self) -> f64 {
        self.simulation.time_secs()
    }

    fn joint(&self, joint: usize) -> JointState {
        let Some(id) = self.joints.get(joint) else {
            return JointState::default();
        };
        JointState {
            position: self.simulation.positions()[id.position_index()],
            velocity: self.simulation.velocities()[id.velocity_index()],
        }
    }

    fn set_joint(&mut self, joint: usize, position: f64) {
        if let Some(id) = self.joints.get(joint) {
            self.simulation.positions_mut()[id.position_index()] = position;
        }
    }

    fn set_drive(&mut self, drive: usize, target: f64) {
        if let Some(control) = self.simulation.controls_mut().get_mut(drive) {
            *control = target;
        }
    }

    /// The model is compiled for this scene alone and shared with nobody, so that its drives can change.
    fn set_drive_strength(&mut self, drive: usize, strength: f64) {
        let Some(law) = self.drives.get(drive) else {
            return;
        };
        if self.strengths[drive] != strength {
            self.strengths[drive] = strength;
            self.simulation.set_drive(drive, &law.of_strength(strength));
        }
    }

    fn drive(&self, drive: usize) -> DriveState {
        let target = self.simulation.controls().get(drive).copied();
        DriveState {
            target: target.unwrap_or(0.0),
            strength: self.strengths.get(drive).copied().unwrap_or(0.0),
        }
    }

    fn apply(&mut self, body: usize, force_newtons: Vector, torque_nm: Vector) {
        if let Some(id) = self.bodies.get(body) {
            self.simulation
                .set_applied_force(*id, force_newtons, torque_nm);
        }
    }

    fn applied(&self, body: usize) -> [Vector; 2] {
        let Some(id) = self.bodies.get(body) else {
            return [[0.0; 3]; 2];
        };
        let [x, y, z, roll, pitch, yaw] = self.simulation.applied_force(*id);
        [[x, y, z], [roll, pitch, yaw]]
    }

    fn body_pose(&self, body: usize) -> Pose {
        let Some(id) = self.bodies.get(body) else {
            return Pose {
                position_m: [0.0; 3],
                orientation: crate::geometry::IDENTITY,
            };
        };
        Pose {
            position_m: self.simulation.body_position(*id),
            orientation: self.simulation.body_quaternion(*id),
        }
    }

    fn body_twist(&self, body: usize) -> Twist {
        let Some(id) = self.bodies.get(body) else {
            return Twist::default();
        };
        let (angular_rad_s, linear_m_s) = self.simulation.body_velocity(*id);
        Twist {
            angular_rad_s,
            linear_m_s,
        }
    }

    fn lead(&mut self, body: usize, pose: &Pose) {
        if let Some(Some(index)) = self.led.get(body) {
            self.simulation
                .set_mocap(*index, pose.position_m, pose.orientation);
        }
    }

    fn touches(&self, touches: &mut Vec<Touch>) {
        touches.extend(&self.touches);
    }

    fn wrench(&self, body: usize) -> Option<[Vector; 2]> {
        let place = self.borne.iter().position(|borne| *borne == body)?;
        let numbers = self.wrenches.get(6 * place..6 * place + 6)?;
        Some([0, 3].map(|first| std::array::from_fn(|axis| numbers[first + axis])))
    }

    fn ray(
        &self,
        from_m: Vector,
        direction: Vector,
        longest_m: f64,
        seen: &dyn Fn(usize) -> bool,
    ) -> Option<Hit> {
        let mut travelled_m = 0.0;
        for _ in 0..PASSED {
            let start_m = add(from_m, scale(travelled_m, direction));
            let hit = self.simulation.ray(start_m, direction, None)?;
            let distance_m = travelled_m + hit.distance_m;
            if distance_m > longest_m {
                return None;
            }
            match self.shape_of(hit.geom) {
                Some(shape) if seen(shape) => return Some(Hit { distance_m, shape }),
                _ => travelled_m = distance_m + BEYOND_M,
            }
        }
        None
    }

    fn distance_m(&mut self, a: usize, b: usize, longest_m: f64) -> f64 {
        match (self.geoms.get(a), self.geoms.get(b)) {
            (Some(a), Some(b)) => self.simulation.geom_distance(*a, *b, longest_m),
            _ => longest_m,
        }
    }

    fn nearest(&mut self, a: usize, b: usize, longest_m: f64) -> Option<Nearest> {
        let (a, b) = (*self.geoms.get(a)?, *self.geoms.get(b)?);
        let (distance_m, points_m) = self.simulation.geom_nearest(a, b, longest_m);
        if distance_m == 0.0 || distance_m >= longest_m {
            return None;
        }
        // MuJoCo's segment has the length of the distance, also of a negative one.
        let normal = scale(1.0 / distance_m, subtract(points_m[1], points_m[0]));
        Some(Nearest {
            distance_m,
            points_m,
            normal,
        })
    }

    fn is_sound(&self) -> bool {
        self.simulation.warning_count() == 0
    }

    fn save(&self) -> PhysicsState {
        PhysicsState::new(Saved {
            engine: self.simulation.save(),
            touches: self.touches.clone(),
            wrenches: self.wrenches.clone(),
            strengths: self.strengths.clone(),
        })
    }

    fn restore(&mut self, saved: &PhysicsState) -> bool {
        let Some(saved) = saved.of::<Saved>() else {
            return false;
        };
        let restored = self.simulation.restore(&saved.engine);
        if restored {
            self.touches.clone_from(&saved.touches);
            self.wrenches.clone_from(&saved.wrenches);
            for (drive, strength) in saved.strengths.iter().enumerate() {
                self.set_drive_strength(drive, *strength);
            }
            self.simulation.update_positions();
        }
        restored
    }
}
