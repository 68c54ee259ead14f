//! Joints of a layout as Rapier's multibodies, with their drives, springs, friction and couplings.
//!
//! A body with several joints gets a body for each of them but the last in between; those carry
//! [`BETWEEN`] of its mass, since Rapier inverts each body's inertia.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use rapier3d_f64::prelude as r;

use super::build::{Bodies, moves, refused, root_of};
use super::{World, to_pose, to_vector};
use crate::bench::SimError;
use crate::geometry::{norm, scale};
use crate::physics::JointState;
use crate::physics::layout::{DriveKind, JointKind, JointPlan, Layout, Spring};

/// The part of a body's mass that each body between its joints has besides.
const BETWEEN: f64 = 1e-9;

/// Where the layout's joints are in Rapier.
pub(super) struct Joints {
    links: Vec<Link>,
}

/// A joint: the one that moves the rigid body `child` against `parent`.
#[derive(Debug, Clone, Copy)]
struct Link {
    handle: r::MultibodyJointHandle,
    parent: r::RigidBodyHandle,
    child: r::RigidBodyHandle,
    kind: JointKind,
    reference: f64,
    /// Whether the child is none of the layout's bodies.
    is_between: bool,
}

/// The axis of Rapier's six along which a joint moves.
fn axis_of(kind: JointKind) -> r::JointAxis {
    match kind {
        JointKind::Slide => r::JointAxis::LinX,
        JointKind::Hinge | JointKind::Ball => r::JointAxis::AngX,
    }
}

impl Joints {
    pub(super) fn build(
        layout: &Layout,
        placed: &Bodies,
        world: &mut World,
    ) -> Result<Self, SimError> {
        let mut links: Vec<Option<Link>> = vec![None; layout.joints.len()];
        let mut roots: BTreeMap<usize, r::RigidBodyHandle> = BTreeMap::new();
        for (body, plan) in layout.bodies.iter().enumerate() {
            let own: Vec<usize> = (0..layout.joints.len())
                .filter(|joint| layout.joints[*joint].body == body)
                .collect();
            if !moves(layout, body) || own.is_empty() {
                continue;
            }
            let parent = plan.parent.map(|parent| placed.of[parent]);
            let (mut handle, mut offset) = match parent {
                Some(parent) if parent.handle != placed.world => (parent.handle, parent.offset),
                // Each machine has a root of its own, so that none is a part of another.
                fixed => (
                    *roots
                        .entry(root_of(layout, body))
                        .or_insert_with(|| world.bodies.insert(r::RigidBodyBuilder::fixed())),
                    fixed.map_or(r::Pose::IDENTITY, |fixed| fixed.offset),
                ),
            };
            offset *= to_pose(&plan.pose);
            for (place, joint) in own.iter().enumerate() {
                let is_between = place + 1 < own.len();
                let child = match is_between {
                    false => placed.of[body].handle,
                    true => between(placed.of[body].handle, world),
                };
                let ends = (handle, offset, child);
                let mut made = link(layout, &layout.joints[*joint], ends, world)?;
                made.is_between = is_between;
                links[*joint] = Some(made);
                (handle, offset) = (child, r::Pose::IDENTITY);
            }
        }
        let named = links.into_iter().zip(&layout.joints);
        let links = named.map(|(link, plan)| {
            link.ok_or_else(|| refused("joint", &plan.name, "its body is fixed or free"))
        });
        let mut joints = Self {
            links: links.collect::<Result<_, _>>()?,
        };
        joints.add_drives(layout, world)?;
        Ok(joints)
    }

    /// What can be set only once trees are complete: springs, damping, friction, armature, couplings.
    pub(super) fn finish(&self, layout: &Layout, world: &mut World) -> Result<(), SimError> {
        // A root that is not dynamic has no damping of its own; Rapier's default is not wanted.
        for link in &self.links {
            if let Some((body, _)) = world.multibodies.get_mut(link.handle) {
                body.damping_mut().fill(0.0);
            }
        }
        for (link, plan) in self.links.iter().zip(&layout.joints) {
            let Some((body, id)) = world.multibodies.get_mut(link.handle) else {
                continue;
            };
            let Some(found) = body.link_mut(id) else {
                continue;
            };
            if plan.stiffness != 0.0 {
                if plan.kind == JointKind::Ball {
                    return Err(refused("joint", &plan.name, "it is a ball with a spring"));
                }
                let rest = plan.spring_reference - plan.reference;
                let axis = axis_of(plan.kind) as usize;
                found.joint.set_spring(axis, plan.stiffness, rest);
            }
            let (first, count) = (found.assembly_id(), found.joint().ndofs());
            for place in first..first + count {
                body.damping_mut()[place] = plan.damping;
                body.armature_mut()[place] = plan.armature;
                body.frictions_mut()[place] = plan.friction_loss;
            }
        }
        self.couple(layout, world)
    }

    fn couple(&self, layout: &Layout, world: &mut World) -> Result<(), SimError> {
        for coupling in &layout.couplings {
            let plan = &layout.joints[coupling.joint];
            let refuse = |reason: &str| Err(refused("coupling of", &plan.name, reason));
            let [offset, coeff, rest @ ..] = coupling.coefficients;
            let Some(leader) = coupling.leader else {
                return refuse("it follows no joint");
            };
            if rest.iter().any(|coefficient| *coefficient != 0.0) {
                return refuse("it is not linear");
            }
            let (leads, follows) = (self.links[leader], self.links[coupling.joint]);
            if [leads.kind, follows.kind].contains(&JointKind::Ball) {
                return refuse("it is of a ball");
            }
            let of = |link: Link| world.multibodies.rigid_body_link(link.child).copied();
            let (Some(first), Some(second)) = (of(leads), of(follows)) else {
                return refuse("its joints are in no tree");
            };
            if first.multibody != second.multibody {
                return refuse("it is between two trees");
            }
            if let Some(body) = world.multibodies.get_multibody_mut(first.multibody) {
                body.add_dof_coupling(r::MultibodyDofCoupling {
                    link1: first.id,
                    dof1: 0,
                    axis1: axis_of(leads.kind) as usize,
                    link2: second.id,
                    dof2: 0,
                    axis2: axis_of(follows.kind) as usize,
                    coeff,
                    offset,
                });
            }
        }
        Ok(())
    }

    /// Motors for the drives of positions and velocities; efforts are applied as torques.
    fn add_drives(&mut self, layout: &Layout, world: &mut World) -> Result<(), SimError> {
        let mut driven = vec![false; layout.joints.len()];
        for (index, drive) in layout.drives.iter().enumerate() {
            let plan = &layout.joints[drive.joint];
            let refuse = |reason: &str| Err(refused("drive of", &plan.name, reason));
            if plan.kind == JointKind::Ball {
                return refuse("a ball cannot be driven");
            }
            if matches!(drive.kind, DriveKind::Effort) {
                continue;
            }
            if std::mem::replace(&mut driven[drive.joint], true) {
                return refuse("it has a second servo");
            }
            self.aim(layout, index, world);
        }
        Ok(())
    }

    /// Gives a servo its target.
    pub(super) fn aim(&self, layout: &Layout, drive: usize, world: &mut World) {
        let (target, strength) = (world.targets[drive], world.strengths[drive]);
        let drive = &layout.drives[drive];
        let link = self.links[drive.joint];
        let axis = axis_of(link.kind);
        let (position, velocity, stiffness, damping) = match drive.kind {
            DriveKind::Position { stiffness, damping } => {
                (target - link.reference, 0.0, stiffness, damping)
            }
            DriveKind::Velocity { gain } => (0.0, target, 0.0, gain),
            DriveKind::Effort => return,
        };
        // Rapier takes a servo without stiffness and damping for a rigid one.
        if stiffness <= 0.0 && damping <= 0.0 {
            return;
        }
        let found = world.multibodies.get_mut(link.handle);
        let Some(found) = found.and_then(|(body, id)| body.link_mut(id)) else {
            return;
        };
        let data = &mut found.joint.data;
        data.set_motor_model(axis, r::MotorModel::ForceBased);
        // One that has no strength left is a servo that may not push, not a rigid one.
        let share = strength.max(1e-9);
        let (stiffness, damping) = (share * stiffness, share * damping);
        data.set_motor(axis, position, velocity, stiffness, damping);
        data.set_motor_max_force(axis, strength * drive.limit);
    }

    /// Applies the efforts of drives: on the child, and against them on its parent.
    pub(super) fn push(&self, layout: &Layout, world: &mut World) {
        for link in self.links.iter().filter(|link| link.is_between) {
            if let Some(rigid) = world.bodies.get_mut(link.child) {
                rigid.reset_forces(false);
                rigid.reset_torques(false);
            }
        }
        let told = world.targets.iter().zip(&world.strengths);
        for (drive, (target, strength)) in layout.drives.iter().zip(told) {
            if !matches!(drive.kind, DriveKind::Effort) {
                continue;
            }
            let link = self.links[drive.joint];
            let effort = strength * target.clamp(-drive.limit, drive.limit);
            let data = world.multibodies.get(link.handle);
            let data = data.and_then(|(body, id)| body.link(id));
            let Some(frame) = data.map(|found| found.joint().data.local_frame2) else {
                continue;
            };
            let Some(child) = world.bodies.get(link.child) else {
                continue;
            };
            let frame = child.position() * frame;
            let along = frame.rotation * r::Vector::X * effort;
            for (handle, along) in [(link.child, along), (link.parent, -along)] {
                let Some(rigid) = world.bodies.get_mut(handle) else {
                    continue;
                };
                if !rigid.is_dynamic() {
                    continue;
                }
                match link.kind {
                    JointKind::Slide => {
                        rigid.add_force_at_point(along, frame.translation, true);
                    }
                    JointKind::Hinge | JointKind::Ball => rigid.add_torque(along, true),
                }
            }
        }
    }

    pub(super) fn state(&self, joint: usize, set: &r::MultibodyJointSet) -> JointState {
        let Some(link) = self.links.get(joint) else {
            return JointState::default();
        };
        let found = set.get(link.handle);
        let Some((body, found)) = found.and_then(|(body, id)| Some((body, body.link(id)?))) else {
            return JointState::default();
        };
        let axis = axis_of(link.kind) as usize;
        JointState {
            position: found.joint().coords()[axis] + link.reference,
            velocity: body.joint_velocity(found)[0],
        }
    }

    pub(super) fn set(&self, joint: usize, position: f64, set: &mut r::MultibodyJointSet) {
        let state = self.state(joint, set);
        let Some(link) = self.links.get(joint) else {
            return;
        };
        let Some((body, id)) = set.get_mut(link.handle) else {
            return;
        };
        let Some(first) = body.link(id).map(r::MultibodyLink::assembly_id) else {
            return;
        };
        let mut displacements = vec![0.0; body.ndofs()];
        if let Some(displacement) = displacements.get_mut(first) {
            *displacement = position - state.position;
            body.generalized_velocity_mut()[first] = 0.0;
        }
        body.apply_displacements(&displacements);
    }

    /// Places the bodies of all trees as their joints say.
    pub(super) fn update(&self, world: &mut World) {
        for link in &self.links {
            if let Some((body, _)) = world.multibodies.get_mut(link.handle) {
                body.forward_kinematics(&world.bodies, true);
                body.update_rigid_bodies(&mut world.bodies, true);
            }
        }
    }
}

/// A body between two joints of one body, at the same place.
fn between(body: r::RigidBodyHandle, world: &mut World) -> r::RigidBodyHandle {
    let mut builder = r::RigidBodyBuilder::dynamic().can_sleep(false);
    if let Some(real) = world.bodies.get_mut(body) {
        real.recompute_mass_properties_from_colliders(&world.colliders);
        let mass = real.mass_properties().local_mprops;
        let inertia = mass.principal_inertia() * BETWEEN;
        let mass = r::MassProperties::new(mass.local_com, mass.mass() * BETWEEN, inertia);
        builder = builder
            .pose(*real.position())
            .additional_mass_properties(mass);
    }
    world.bodies.insert(builder)
}

/// Adds one joint between two rigid bodies.
fn link(
    layout: &Layout,
    plan: &JointPlan,
    (parent, in_parent, child): (r::RigidBodyHandle, r::Pose, r::RigidBodyHandle),
    world: &mut World,
) -> Result<Link, SimError> {
    let substep_secs = layout.time_step_secs / layout.solver.rapier.substeps as f64;
    let locked = match plan.kind {
        JointKind::Hinge => r::JointAxesMask::LOCKED_REVOLUTE_AXES,
        JointKind::Slide => r::JointAxesMask::LOCKED_PRISMATIC_AXES,
        JointKind::Ball => r::JointAxesMask::LOCKED_SPHERICAL_AXES,
    };
    let frame = r::Pose::from_parts(to_vector(plan.anchor_m), turned_to(plan)?);
    let mut joint = r::GenericJoint::new(locked);
    joint.local_frame1 = in_parent * frame;
    joint.local_frame2 = frame;
    if let Some(range) = plan.range {
        if plan.kind == JointKind::Ball {
            return Err(refused("joint", &plan.name, "it is a ball with limits"));
        }
        let limits = range.map(|end| end - plan.reference);
        joint.set_limits(axis_of(plan.kind), limits);
    }
    // Rapier's dry friction of a joint is as soft as its stops.
    if let Some(stop) = &plan.stop {
        joint.softness = stop_softness(&stop.spring(), substep_secs);
    }
    let handle = world.multibodies.insert(parent, child, joint, true);
    Ok(Link {
        handle: handle.ok_or_else(|| refused("joint", &plan.name, "it closes a loop of bodies"))?,
        parent,
        child,
        kind: plan.kind,
        reference: plan.reference,
        is_between: false,
    })
}

/// What Rapier is told, so that a stop gives way as this spring does.
///
/// Rapier solves a stop once with its spring and, after positions have moved, once without its push back, but both times with its
/// compliance `c = 1 / (h w (h w + 2 z))` (`h` the substep, `w` the natural angular frequency, `z` the damping ratio). So a part of
/// the impulse is lost: at rest under an acceleration `a` a stop is passed by `(1 + c) a / w^2` in place of `a / w^2`. With
/// `w sqrt(1 + c)` in place of `w`, and a damping ratio that leaves `c` as it is, it is passed by `a / w^2`, as fast as it was to be;
/// dry friction, of which nothing is lost, depends on `c` alone.
fn stop_softness(spring: &Spring, substep_secs: f64) -> r::SpringCoefficients<f64> {
    let turns = substep_secs * 2.0 * PI * spring.frequency_hz;
    let sum = turns + 2.0 * spring.damping_ratio;
    let stiffer = (1.0 + 1.0 / (turns * sum)).sqrt();
    r::SpringCoefficients::new(
        stiffer * spring.frequency_hz,
        ((sum / stiffer - turns * stiffer) / 2.0).max(0.0),
    )
}

/// The shortest turn that takes x to the joint's axis.
fn turned_to(plan: &JointPlan) -> Result<r::Rotation, SimError> {
    if plan.kind == JointKind::Ball {
        return Ok(r::Rotation::IDENTITY);
    }
    let length = norm(plan.axis);
    if length <= 0.0 || !length.is_finite() {
        return Err(refused("joint", &plan.name, "its axis has no direction"));
    }
    let axis = to_vector(scale(1.0 / length, plan.axis));
    Ok(r::Rotation::from_rotation_arc(r::Vector::X, axis))
}
