//! What the joints of a machine have to move, and whether a time step carries their drives.
//!
//! Definition: at a configuration the coordinates `q` of a machine (its joints, and six of a root that is free) have the mass matrix
//! `M`, the sum over bodies of `m Jv' Jv + Jw' I Jw`, and the drives' inertias on its diagonal; position drives, springs and
//! dampers give `K` and `D`. What follows a coupling moves with its leader. The effective inertia of a joint, all others free, is
//! `1 / (M^-1)_ii`.
//!
//! Steps of the length `h` that take stiffness explicitly and damping implicitly (semi-implicit Euler, MuJoCo's `implicitfast`) are
//!
//! ```text
//! v' = (M + h D)^-1 (M v - h K q),   q' = q + h v'
//! ```
//!
//! One joint of the inertia `I` is stable for `k < (4 I + 2 h d) / h^2`. Of several it is asked whether these steps, taken [`STEPS`]
//! times, still grow.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration" (2006), I.1; MuJoCo's documentation, "Numerical
//! integration".
//!
//! Deviation: linear, at one configuration, without contacts and limits of force. Cost: `n^3` for `n` coordinates, and [`STEPS`] times
//! `n^2`. Guarantee: none beyond the linear steps; a machine may be stable here and chatter elsewhere.

use crate::geometry::{Pose, Vector, add, cross, dot, inverse, norm, rotate, scale, subtract};
use crate::physics::{BodyPlan, DriveKind, JointKind, Layout, Motion, Physics};

/// How many steps are taken.
const STEPS: usize = 2000;
/// Those of them at whose growth it is looked.
const LOOKED_AT: usize = 500;
/// The growth of a step from which on it is no rounding, and no drift of what nothing holds.
const GROWS: f64 = 5e-3;

/// A coordinate of a machine.
struct Coordinate {
    /// The joint; none of a root's.
    joint: Option<usize>,
    body: usize,
    axis: Vector,
    anchor_m: Vector,
    is_slide: bool,
}

/// A machine's joints at a configuration.
pub(super) struct Machine {
    coordinates: Vec<Coordinate>,
    mass: Vec<Vec<f64>>,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
}

/// A joint whose drive the step does not carry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TooStiff {
    pub(super) joint: usize,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// The effective inertia, kg m² or kg.
    pub(super) inertia: f64,
    /// The stiffness that would be stable if the joint were driven alone.
    pub(super) stable: f64,
    /// The longest step that carries it alone.
    pub(super) longest_secs: f64,
}

impl Machine {
    /// The machine of these bodies, as they are placed in the engine.
    pub(super) fn new(layout: &Layout, bodies: &[usize], physics: &dyn Physics) -> Self {
        let coordinates = coordinates(layout, bodies, physics);
        let count = coordinates.len();
        let mut mass = vec![vec![0.0; count]; count];
        for body in bodies {
            let ways: Vec<(usize, [Vector; 2])> = coordinates
                .iter()
                .enumerate()
                .filter(|(_, it)| hangs_on(layout, *body, it.body))
                .map(|(place, it)| (place, it.way(layout, *body, physics)))
                .collect();
            let pose = physics.body_pose(*body);
            let plan = &layout.bodies[*body];
            let mass_kg = plan.inertia.map_or(0.0, |it| it.mass_kg);
            for (a, [linear_a, angular_a]) in &ways {
                let spin = turned_inertia(plan, &pose, *angular_a);
                for (b, [linear_b, angular_b]) in &ways {
                    mass[*a][*b] += mass_kg * dot(*linear_a, *linear_b) + dot(spin, *angular_b);
                }
            }
        }
        let joints = coordinates.iter().map(|it| it.joint);
        let joints: Vec<_> = joints.map(|it| it.map(|it| &layout.joints[it])).collect();
        for (place, joint) in joints.iter().enumerate() {
            mass[place][place] += joint.map_or(0.0, |it| it.armature);
        }
        let of = |number: &dyn Fn(&crate::physics::JointPlan) -> f64| {
            joints.iter().map(|it| it.map_or(0.0, number)).collect()
        };
        let mut machine = Self {
            stiffness: of(&|it| it.stiffness),
            damping: of(&|it| it.damping),
            coordinates,
            mass,
        };
        machine.drive(layout);
        machine
    }

    fn drive(&mut self, layout: &Layout) {
        for drive in &layout.drives {
            let own = |it: &Coordinate| it.joint == Some(drive.joint);
            let Some(place) = self.coordinates.iter().position(own) else {
                continue;
            };
            match drive.kind {
                DriveKind::Position { stiffness, damping } => {
                    self.stiffness[place] += stiffness;
                    self.damping[place] += damping;
                }
                DriveKind::Velocity { gain } => self.damping[place] += gain,
                DriveKind::Effort => {}
            }
        }
    }

    /// The effective inertia of a joint, all others free.
    pub(super) fn effective(&self, joint: usize) -> Option<f64> {
        let place = self
            .coordinates
            .iter()
            .position(|it| it.joint == Some(joint))?;
        let inverted = inverted(self.mass.clone())?;
        Some(1.0 / inverted[place][place])
    }

    /// The joint whose motion grows most in steps of this length, if any does.
    pub(super) fn too_stiff(&self, layout: &Layout, step_secs: f64) -> Option<TooStiff> {
        let (mass, stiffness, damping, places) = self.led(layout);
        let count = mass.len();
        let mut damped = mass.clone();
        for (place, row) in damped.iter_mut().enumerate() {
            for (other, entry) in row.iter_mut().enumerate() {
                *entry += step_secs * damping[place][other];
            }
        }
        let damped = inverted(damped)?;
        let mut place = vec![1.0; count];
        let mut speed = vec![0.0; count];
        let (mut growth, mut size) = (0.0, f64::NAN);
        for step in 0..STEPS {
            let pushed = times(&mass, &speed);
            let pulled = times(&stiffness, &place);
            let impulse: Vec<f64> = pushed
                .iter()
                .zip(&pulled)
                .map(|(pushed, pulled)| pushed - step_secs * pulled)
                .collect();
            speed = times(&damped, &impulse);
            for (place, speed) in place.iter_mut().zip(&speed) {
                *place += step_secs * speed;
            }
            let moved = speed.iter().map(|it| step_secs * it);
            let now = place
                .iter()
                .copied()
                .chain(moved)
                .map(|it| it * it)
                .sum::<f64>()
                .sqrt();
            if !(now > 0.0 && now.is_finite()) {
                return None;
            }
            if step >= STEPS - LOOKED_AT && size.is_finite() {
                growth += now.ln();
            }
            for it in place.iter_mut().chain(speed.iter_mut()) {
                *it /= now;
            }
            size = 1.0;
        }
        if growth / (LOOKED_AT as f64) < GROWS {
            return None;
        }
        let energy = |it: &usize| mass[*it][*it] * speed[*it] * speed[*it];
        let worst = (0..count).max_by(|a, b| energy(a).total_cmp(&energy(b)))?;
        self.told(places[worst], step_secs)
    }

    fn told(&self, place: usize, step_secs: f64) -> Option<TooStiff> {
        let joint = self.coordinates[place].joint?;
        let (stiffness, damping) = (self.stiffness[place], self.damping[place]);
        let inertia = self.effective(joint)?;
        let stable = (4.0 * inertia + 2.0 * step_secs * damping) / (step_secs * step_secs);
        let root = (damping * damping + 4.0 * inertia * stiffness).sqrt();
        Some(TooStiff {
            joint,
            stiffness,
            damping,
            inertia,
            stable,
            longest_secs: (damping + root) / stiffness.max(f64::MIN_POSITIVE),
        })
    }

    /// The same with those that follow a coupling moved by their leaders: mass, stiffness, damping, and which coordinates are left.
    #[allow(
        clippy::type_complexity,
        reason = "three matrices of one kind and their rows"
    )]
    fn led(&self, layout: &Layout) -> (Vec<Vec<f64>>, Vec<Vec<f64>>, Vec<Vec<f64>>, Vec<usize>) {
        let count = self.coordinates.len();
        let place_of = |joint: usize| {
            self.coordinates
                .iter()
                .position(|it| it.joint == Some(joint))
        };
        // How each coordinate moves with those that lead.
        let mut ways: Vec<(usize, f64)> = (0..count).map(|place| (place, 1.0)).collect();
        for _ in 0..layout.couplings.len().min(count) {
            for coupling in &layout.couplings {
                let leader = coupling.leader.and_then(place_of);
                if let (Some(follower), Some(leader)) = (place_of(coupling.joint), leader) {
                    let (first, slope) = ways[leader];
                    ways[follower] = (first, slope * coupling.coefficients[1]);
                }
            }
        }
        let left: Vec<usize> = (0..count)
            .filter(|place| ways[*place].0 == *place)
            .collect();
        let row_of = |place: usize| left.iter().position(|it| *it == ways[place].0);
        let folded = |entry: &dyn Fn(usize, usize) -> f64| {
            let mut matrix = vec![vec![0.0; left.len()]; left.len()];
            for a in 0..count {
                for b in 0..count {
                    if let (Some(row), Some(column)) = (row_of(a), row_of(b)) {
                        matrix[row][column] += ways[a].1 * ways[b].1 * entry(a, b);
                    }
                }
            }
            matrix
        };
        let on_diagonal = |numbers: &[f64], a: usize, b: usize| match a == b {
            true => numbers[a],
            false => 0.0,
        };
        let mass = folded(&|a, b| self.mass[a][b]);
        let stiffness = folded(&|a, b| on_diagonal(&self.stiffness, a, b));
        let damping = folded(&|a, b| on_diagonal(&self.damping, a, b));
        (mass, stiffness, damping, left)
    }
}

impl Coordinate {
    /// Linear and angular velocity of a body's centre of mass for each unit of the coordinate's.
    fn way(&self, layout: &Layout, body: usize, physics: &dyn Physics) -> [Vector; 2] {
        if self.is_slide {
            return [self.axis, [0.0; 3]];
        }
        let pose = physics.body_pose(body);
        let centre_m = layout.bodies[body]
            .inertia
            .map_or([0.0; 3], |it| it.centre_m);
        let centre = add(pose.position_m, rotate(pose.orientation, centre_m));
        [cross(self.axis, subtract(centre, self.anchor_m)), self.axis]
    }
}

fn coordinates(layout: &Layout, bodies: &[usize], physics: &dyn Physics) -> Vec<Coordinate> {
    let mut found = Vec::new();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for body in bodies {
        let pose = physics.body_pose(*body);
        let each_axis = |anchor_m: Vector, is_slide: bool| {
            axes.map(|axis| Coordinate {
                joint: None,
                body: *body,
                axis,
                anchor_m,
                is_slide,
            })
        };
        if layout.bodies[*body].motion == Motion::Free {
            found.extend(each_axis(pose.position_m, true));
            found.extend(each_axis(pose.position_m, false));
        }
        let own = layout.joints.iter().enumerate();
        for (joint, plan) in own.filter(|(_, it)| it.body == *body) {
            let anchor_m = add(pose.position_m, rotate(pose.orientation, plan.anchor_m));
            if plan.kind == JointKind::Ball {
                found.extend(each_axis(anchor_m, false));
                continue;
            }
            let axis = scale(1.0 / norm(plan.axis).max(1e-12), plan.axis);
            found.push(Coordinate {
                joint: Some(joint),
                body: *body,
                axis: rotate(pose.orientation, axis),
                anchor_m,
                is_slide: plan.kind == JointKind::Slide,
            });
        }
    }
    found
}

/// Whether a body is another or hangs on it.
fn hangs_on(layout: &Layout, body: usize, on: usize) -> bool {
    let above = std::iter::successors(Some(body), |it| layout.bodies[*it].parent);
    above.take_while(|it| *it >= on).any(|it| it == on)
}

/// What a body's inertia makes of an angular velocity, in the world.
fn turned_inertia(plan: &BodyPlan, pose: &Pose, angular: Vector) -> Vector {
    let Some(inertia) = plan.inertia else {
        return [0.0; 3];
    };
    let [xx, yy, zz, xy, xz, yz] = inertia.moments_kg_m2;
    let own = rotate(inverse(pose.orientation), angular);
    let spin = [
        dot([xx, xy, xz], own),
        dot([xy, yy, yz], own),
        dot([xz, yz, zz], own),
    ];
    rotate(pose.orientation, spin)
}

fn times(matrix: &[Vec<f64>], vector: &[f64]) -> Vec<f64> {
    let of_row = |row: &Vec<f64>| row.iter().zip(vector).map(|(a, b)| a * b).sum();
    matrix.iter().map(of_row).collect()
}

/// The inverse by elimination with pivots; `None` of a matrix that has none.
fn inverted(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let count = matrix.len();
    for (place, row) in matrix.iter_mut().enumerate() {
        row.extend((0..count).map(|it| f64::from(u8::from(it == place))));
    }
    for column in 0..count {
        let size = |row: &usize| matrix[*row][column].abs();
        let pivot = (column..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if matrix[pivot][column].abs() < 1e-18 {
            return None;
        }
        matrix.swap(column, pivot);
        let by = 1.0 / matrix[column][column];
        matrix[column].iter_mut().for_each(|it| *it *= by);
        let row = matrix[column].clone();
        for (_, other) in matrix
            .iter_mut()
            .enumerate()
            .filter(|(it, _)| *it != column)
        {
            let by = other[column];
            if by != 0.0 {
                other
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(it, own)| *it -= by * own);
            }
        }
    }
    Some(
        matrix
            .into_iter()
            .map(|row| row[count..].to_vec())
            .collect(),
    )
}
