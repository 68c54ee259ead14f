//! How a robot stands at first, and where its end is.

use super::drives::Drive;
use robot_model::pose::{cross, length, rotate, subtract};
use robot_model::{Geometry, JointKind, Model, Pose, Role, Shape};

/// How far above the floor what moves of a fixed robot begins, m.
const CLEARANCE: f64 = 0.01;

/// How a robot stands at first.
pub(super) struct Stance {
    /// How high its root stands over where the description has it, m.
    pub(super) height_m: f64,
    /// Joints that stand elsewhere than the description has them, since that is beyond their limits.
    pub(super) moved: Vec<(usize, f64)>,
    /// Whether the description has a floor of its own.
    pub(super) has_floor: bool,
}

/// Within the limits of all joints, and not in the floor.
pub(super) fn stance(model: &Model, drives: &[Drive<'_>], fixed: bool) -> Stance {
    let mut positions = model.reference_positions();
    let mut moved = Vec::new();
    for drive in drives {
        let Some(wanted) = within(drive.joint.limits, drive.joint.reference) else {
            continue;
        };
        if let Some(at) = model.position_start(drive.index()) {
            positions[at] = wanted;
            moved.push((drive.index(), wanted));
        }
    }
    let has_floor = model.links.iter().enumerate().any(|(link, of)| {
        let plane = |shape: &Shape| matches!(shape.geometry, Geometry::Plane { .. });
        model.is_static(link) && of.shapes.iter().any(plane)
    });
    let poses = model.poses(&positions).unwrap_or_default();
    let counts = |link: usize| !(fixed && model.is_static(link));
    let lowest = (0..poses.len())
        .filter(|link| counts(*link))
        .flat_map(|link| lowest_of(model, link, &poses[link]))
        .fold(f64::INFINITY, f64::min);
    let height_m = match (has_floor || !lowest.is_finite(), fixed) {
        (true, _) => 0.0,
        (false, true) => (CLEARANCE - lowest).max(0.0),
        (false, false) => 0.001 - lowest,
    };
    Stance {
        height_m,
        moved,
        has_floor,
    }
}

/// A position within limits for one that is not, a tenth of the range from the nearer one.
fn within(limits: Option<[f64; 2]>, position: f64) -> Option<f64> {
    let [low, high] = limits.filter(|[low, high]| low < high)?;
    let inside = (high - low) / 10.0;
    match position {
        it if it < low => Some(low + inside),
        it if it > high => Some(high - inside),
        _ => None,
    }
}

/// The lowest points of a link's shapes that can be touched.
fn lowest_of<'m>(model: &'m Model, link: usize, pose: &'m Pose) -> impl Iterator<Item = f64> + 'm {
    let shapes = model.links[link].shapes.iter();
    shapes
        .filter(|shape| shape.role == Role::Collision)
        .filter_map(|shape| lowest_point(model, shape, &pose.then(&shape.pose_in_link)))
}

fn lowest_point(model: &Model, shape: &Shape, pose: &Pose) -> Option<f64> {
    let z = pose.position_m[2];
    // How much of each of the shape's axes points upwards.
    let up = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|axis| rotate(pose.rotation, axis)[2].abs());
    let across = (1.0 - up[2] * up[2]).max(0.0).sqrt();
    Some(match &shape.geometry {
        Geometry::Box {
            half_extents_m: half,
        } => z - (0..3).map(|axis| half[axis] * up[axis]).sum::<f64>(),
        Geometry::Sphere { radius_m } => z - radius_m,
        Geometry::Cylinder { radius_m, length_m } => z - length_m / 2.0 * up[2] - radius_m * across,
        Geometry::Capsule { radius_m, length_m } => z - length_m / 2.0 * up[2] - radius_m,
        Geometry::Ellipsoid { radii_m } => {
            z - (0..3)
                .map(|axis| (radii_m[axis] * up[axis]).powi(2))
                .sum::<f64>()
                .sqrt()
        }
        Geometry::Plane { .. } => return None,
        Geometry::Mesh { mesh } => {
            let corners = model.meshes.get(*mesh)?.vertices_m.iter();
            let lowest = corners
                .map(|corner| pose.apply(*corner)[2])
                .fold(f64::INFINITY, f64::min);
            return lowest.is_finite().then_some(lowest);
        }
    })
}

/// The link at the end of the chain with the most joints that move; of several the farthest from its root.
pub(super) fn end_link(model: &Model) -> usize {
    let poses = model
        .poses(&model.reference_positions())
        .unwrap_or_default();
    let key = |link: usize| {
        let chain = chain(model, link);
        let moving = chain.iter().flat_map(|at| model.joints_of(*at));
        let freedoms: usize = moving
            .filter(|joint| joint.kind != JointKind::Free)
            .map(|joint| joint.kind.freedoms())
            .sum();
        let root = chain.last().copied().unwrap_or(link);
        let far = match (poses.get(link), poses.get(root)) {
            (Some(here), Some(there)) => length(subtract(here.position_m, there.position_m)),
            _ => 0.0,
        };
        (freedoms, far)
    };
    let mut best = (0, (0, -1.0));
    for link in 0..model.links.len() {
        let found = key(link);
        if found.0 > best.1.0 || found.0 == best.1.0 && found.1 > best.1.1 {
            best = (link, found);
        }
    }
    best.0
}

/// A link and those it hangs on, outwards in.
fn chain(model: &Model, link: usize) -> Vec<usize> {
    std::iter::successors(Some(link), |at| model.links[*at].parent).collect()
}

/// The highest speed that a link's origin can have against the root by its joints' highest speeds, in the description's pose,
/// m/s: the sum of what each contributes. `None` if one of them has none.
pub(super) fn fastest(model: &Model, link: usize) -> Option<f64> {
    let poses = model.poses(&model.reference_positions()).ok()?;
    let end = poses.get(link)?.position_m;
    let mut speed = 0.0;
    for at in chain(model, link) {
        for joint in model.joints_of(at) {
            let highest = || joint.velocity_limit.filter(|limit| limit.is_finite());
            speed += match joint.kind {
                JointKind::Revolute => {
                    let axis = rotate(poses[at].rotation, joint.axis);
                    let from_anchor = subtract(end, poses[at].apply(joint.anchor_m));
                    highest()? * length(cross(axis, from_anchor))
                }
                JointKind::Prismatic => highest()?,
                JointKind::Fixed => 0.0,
                JointKind::Ball | JointKind::Free => return None,
            };
        }
    }
    Some(speed)
}
