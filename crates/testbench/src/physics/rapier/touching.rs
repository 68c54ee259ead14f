//! What touches what in Rapier, and with which force.

use std::collections::BTreeSet;

use rapier3d_f64::prelude as r;

use super::build::{Bodies, moves};
use super::shapes::Shape;
use super::wrenches::friction_of;
use super::{World, of_vector, to_pose};
use crate::geometry::Vector;
use crate::physics::Touch;
use crate::physics::layout::{Layout, Touches};

/// Pairs of rigid bodies that never touch.
pub(super) struct Apart(BTreeSet<[(u32, u32); 2]>);

impl Apart {
    /// Those that the layout names, and a body and the one that it hangs on. As in MuJoCo, what is
    /// fixed to the world touches what hangs on it.
    pub(super) fn new(layout: &Layout, placed: &Bodies) -> Self {
        let handle = |body: usize| placed.of[body].handle;
        let named = layout.no_contact.iter();
        let named = named.filter(|pair| pair.iter().all(|body| *body < layout.bodies.len()));
        let mut pairs: BTreeSet<_> = named
            .map(|[a, b]| ordered(handle(*a), handle(*b)))
            .collect();
        for (index, body) in layout.bodies.iter().enumerate() {
            if let Some(parent) = body.parent
                && moves(layout, index)
                && handle(parent) != placed.world
            {
                pairs.insert(ordered(handle(index), handle(parent)));
            }
        }
        Self(pairs)
    }
}

fn ordered(a: r::RigidBodyHandle, b: r::RigidBodyHandle) -> [(u32, u32); 2] {
    let (a, b) = (a.into_raw_parts(), b.into_raw_parts());
    [a.min(b), a.max(b)]
}

impl r::PhysicsHooks for Apart {
    fn filter_contact_pair(&self, context: &r::PairFilterContext) -> Option<r::SolverFlags> {
        let apart = match (context.rigid_body1, context.rigid_body2) {
            (Some(a), Some(b)) => self.0.contains(&ordered(a, b)),
            _ => false,
        };
        (!apart).then_some(r::SolverFlags::COMPUTE_RIGID_IMPULSES)
    }
}

/// Puts the layout's shapes on their bodies.
pub(super) fn insert(layout: &Layout, shapes: &[Shape], placed: &Bodies, world: &mut World) {
    for (index, (plan, shape)) in layout.shapes.iter().zip(shapes).enumerate() {
        let (handle, offset) = match plan.body {
            None => (placed.world, r::Pose::IDENTITY),
            Some(body) => (placed.of[body].handle, placed.of[body].offset),
        };
        let collider = r::ColliderBuilder::new(shape.form.clone())
            .position(offset * to_pose(&plan.pose) * shape.turn)
            .density(0.0)
            .friction(plan.friction)
            .friction_combine_rule(r::CoefficientCombineRule::Min)
            .restitution(0.0)
            .collision_groups(groups_of(plan.touches))
            .active_hooks(r::ActiveHooks::FILTER_CONTACT_PAIRS)
            .user_data(index as u128);
        let bodies = &mut world.bodies;
        world.colliders.insert_with_parent(collider, handle, bodies);
    }
}

/// As the masks of MuJoCo: two touch if one's kind is among what the other touches.
fn groups_of(touches: Touches) -> r::InteractionGroups {
    const ALL: u32 = i32::MAX as u32;
    let (kind, touched) = match touches {
        Touches::All => (ALL, ALL),
        Touches::AllButGroup(group) => {
            let bit = 1 << group.min(30);
            (bit, ALL & !bit)
        }
        Touches::Kinds { is, touches } => (ALL & is, ALL & touches),
        Touches::Nothing => (0, 0),
    };
    let group = r::Group::from_bits_truncate;
    r::InteractionGroups::new(group(kind), group(touched), r::InteractionTestMode::Or)
}

/// Collects the contacts of the last step: the impulses of its substeps over its length.
pub(super) fn collect(world: &mut World, step_secs: f64, substeps: usize) {
    let shape_of = |handle: r::ColliderHandle| {
        let collider = world.colliders.get(handle)?;
        usize::try_from(collider.user_data).ok()
    };
    let mut touches: Vec<(Touch, Vector)> = Vec::new();
    for pair in world.narrow_phase.contact_pairs() {
        let (Some(a), Some(b)) = (shape_of(pair.collider1), shape_of(pair.collider2)) else {
            continue;
        };
        let first = world.colliders.get(pair.collider1).map(|it| *it.position());
        for manifold in pair.manifolds() {
            let first = first.unwrap_or(r::Pose::IDENTITY);
            add_manifold(manifold, [a, b], &first, step_secs, substeps, &mut touches);
        }
    }
    // The order of pairs is that of Rapier's memory; ours does not depend on it.
    touches.sort_by(|(a, _), (b, _)| {
        let by_shapes = a.shapes.cmp(&b.shapes);
        by_shapes.then(a.normal_newtons.total_cmp(&b.normal_newtons))
    });
    (world.touches, world.frictions) = touches.into_iter().unzip();
}

/// The points of one manifold. Between rigid bodies it has one friction force for all of them, of
/// which Rapier keeps the last substep's impulse; it is shared out as the normal forces are.
fn add_manifold(
    manifold: &r::ContactManifold,
    shapes: [usize; 2],
    first: &r::Pose,
    step_secs: f64,
    substeps: usize,
    touches: &mut Vec<(Touch, Vector)>,
) {
    let points = manifold.points.iter();
    let active: Vec<_> = points
        .filter(|point| point.dist <= 0.0 || point.data.impulse > 0.0)
        .collect();
    let normal: f64 = active.iter().map(|point| point.data.impulse).sum();
    let of_point = |point: &r::TrackedContact<r::ContactData>| {
        let [across, along] = [0, 1].map(|axis| point.data.tangent_impulse[axis]);
        across.hypot(along)
    };
    let has_own = active.iter().any(|point| of_point(point) > 0.0);
    let common = active.first().map_or(0.0, |point| {
        point.data.warmstart_tangent_world.length() * substeps as f64
    });
    for point in active {
        let tangential = match (has_own, normal > 0.0) {
            (true, _) => of_point(point),
            (false, true) => common * point.data.impulse / normal,
            (false, false) => 0.0,
        };
        let touch = Touch {
            shapes,
            normal_newtons: point.data.impulse / step_secs,
            tangential_newtons: tangential / step_secs,
            point_m: of_vector(*first * point.local_p1),
            normal: of_vector(manifold.data.normal),
        };
        let friction = friction_of(&point.data, manifold.data.normal, &touch, step_secs);
        touches.push((touch, friction));
    }
}
