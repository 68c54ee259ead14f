//! Bodies of a layout as Rapier's rigid bodies. What does not move against its parent is one body
//! with it.

use rapier3d_f64::prelude as r;

use super::{to_pose, to_vector};
use crate::bench::SimError;
use crate::mujoco::EngineError;
use crate::physics::layout::{BodyPlan, Inertia, Layout, Motion};

/// The rigid body that a body is, or is a part of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub(super) handle: r::RigidBodyHandle,
    /// The body's frame in the rigid body's.
    pub(super) offset: r::Pose,
}

/// Where the layout's bodies are in Rapier.
pub(super) struct Bodies {
    pub(super) of: Vec<Placed>,
    /// The world as a body, for what is fixed to it.
    pub(super) world: r::RigidBodyHandle,
}

/// Something that this engine does not do.
pub(super) fn refused(what: &str, name: &str, reason: &str) -> SimError {
    SimError::Engine(EngineError::Model {
        reason: format!("the engine Rapier does not take the {what} `{name}`: {reason}"),
    })
}

impl Bodies {
    pub(super) fn build(layout: &Layout, set: &mut r::RigidBodySet) -> Result<Self, SimError> {
        let world = set.insert(r::RigidBodyBuilder::fixed());
        let mut bodies = Self {
            of: Vec::with_capacity(layout.bodies.len()),
            world,
        };
        for (index, body) in layout.bodies.iter().enumerate() {
            let parent = body.parent.map(|parent| bodies.of[parent]);
            let in_world = parent.map_or(r::Pose::IDENTITY, |parent| {
                set.get(parent.handle)
                    .map_or(r::Pose::IDENTITY, |rigid| rigid.position() * parent.offset)
            }) * to_pose(&body.pose);
            let placed = match body.motion {
                Motion::Led => Placed::new(
                    set.insert(r::RigidBodyBuilder::kinematic_position_based().pose(in_world)),
                ),
                Motion::Free => floating(set, in_world, weight_of(layout, index)?),
                Motion::Jointed if moves(layout, index) => {
                    let weight = weight_of(layout, index)?;
                    let rigid = r::RigidBodyBuilder::dynamic()
                        .pose(in_world)
                        .can_sleep(false);
                    Placed::new(set.insert(rigid.additional_mass_properties(weight)))
                }
                _ => {
                    let parent = parent.unwrap_or(Placed::new(world));
                    Placed {
                        handle: parent.handle,
                        offset: parent.offset * to_pose(&body.pose),
                    }
                }
            };
            bodies.of.push(placed);
        }
        Ok(bodies)
    }
}

/// A loose body, whose frame in Rapier lies at its centre of mass: the root of a multibody turns
/// about its frame's origin as if that were the centre.
fn floating(set: &mut r::RigidBodySet, in_world: r::Pose, mut weight: r::MassProperties) -> Placed {
    let centre = std::mem::replace(&mut weight.local_com, r::Vector::ZERO);
    let pose = in_world * r::Pose::from_translation(centre);
    let rigid = r::RigidBodyBuilder::dynamic().pose(pose).can_sleep(false);
    Placed {
        handle: set.insert(rigid.additional_mass_properties(weight)),
        offset: r::Pose::from_translation(-centre),
    }
}

impl Placed {
    fn new(handle: r::RigidBodyHandle) -> Self {
        Self {
            handle,
            offset: r::Pose::IDENTITY,
        }
    }
}

/// Whether a body moves against its parent.
pub(super) fn moves(layout: &Layout, index: usize) -> bool {
    match layout.bodies[index].motion {
        Motion::Free => true,
        Motion::Jointed => layout.joints.iter().any(|joint| joint.body == index),
        Motion::Fixed | Motion::Led => false,
    }
}

/// The body without a parent above a body, or itself.
pub(super) fn root_of(layout: &Layout, mut index: usize) -> usize {
    // Bodies come after their parents.
    while let Some(parent) = layout.bodies[index].parent.filter(|parent| *parent < index) {
        index = parent;
    }
    index
}

/// Mass of a body and of all that is fixed to it, in its frame.
fn weight_of(layout: &Layout, root: usize) -> Result<r::MassProperties, SimError> {
    let mut poses = vec![None; layout.bodies.len()];
    poses[root] = Some(r::Pose::IDENTITY);
    let mut sum = own_weight(&layout.bodies[root]);
    for index in root + 1..layout.bodies.len() {
        let body = &layout.bodies[index];
        let parent = body.parent.and_then(|parent| poses[parent]);
        let Some(parent) = parent else { continue };
        if moves(layout, index) || body.motion == Motion::Led {
            continue;
        }
        let pose = parent * to_pose(&body.pose);
        poses[index] = Some(pose);
        sum += own_weight(body).transform_by(&pose);
    }
    if sum.mass() > 0.0 {
        return Ok(sum);
    }
    let name = &layout.bodies[root].name;
    Err(refused("body", name, "it moves and weighs nothing"))
}

fn own_weight(body: &BodyPlan) -> r::MassProperties {
    body.inertia.as_ref().map_or_else(
        || r::MassProperties::new(r::Vector::ZERO, 0.0, r::Vector::ZERO),
        mass_properties,
    )
}

fn mass_properties(inertia: &Inertia) -> r::MassProperties {
    let [xx, yy, zz, xy, xz, yz] = inertia.moments_kg_m2;
    let columns = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    r::MassProperties::with_inertia_matrix(
        to_vector(inertia.centre_m),
        inertia.mass_kg,
        r::Matrix::from_cols_array_2d(&columns),
    )
}
