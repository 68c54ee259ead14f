//! A robot's description, as `robot-model` reads it, in a layout.

use std::collections::BTreeMap;
use std::ops::Range;

use robot_model::{Geometry, JointKind as ModelJoint, Link, Model, Role, Shape};

use crate::geometry::{Pose, add, compose, rotate};
use crate::physics::{
    BodyPlan, CouplingPlan, Form, Inertia, JointKind, JointPlan, Layout, Motion, ShapePlan,
    Surface, Touches,
};

/// Where a model is in the layout.
#[derive(Debug, Clone)]
pub(super) struct Added {
    /// The body of its first root.
    pub(super) root: usize,
    /// Bodies by the names of links.
    pub(super) links: BTreeMap<String, usize>,
    /// Joints by name.
    pub(super) joints: BTreeMap<String, usize>,
    pub(super) shapes: Range<usize>,
}

/// Adds a model under a name, its roots placed by `pose`. What has no friction of its own gets
/// `friction`; a model's shapes do not touch each other where its description keeps them apart.
pub(super) fn add_model(
    layout: &mut Layout,
    name: &str,
    model: &Model,
    pose: &Pose,
    fixed: bool,
    friction: f64,
    group: u8,
) -> Added {
    let (bodies, shapes) = (layout.bodies.len(), layout.shapes.len());
    let mut joint_places = vec![None; model.joints.len()];
    for (index, link) in model.links.iter().enumerate() {
        add_link(layout, name, model, index, bodies, pose, fixed);
        for shape in link.shapes.iter().filter(|s| s.role == Role::Collision) {
            add_shape(
                layout,
                name,
                model,
                link,
                shape,
                bodies + index,
                friction,
                group,
            );
        }
    }
    for (index, joint) in model.joints.iter().enumerate() {
        let Some(kind) = kind_of(joint.kind) else {
            continue;
        };
        joint_places[index] = Some(layout.joints.len());
        layout.joints.push(JointPlan {
            name: format!("{name}/{}", joint.name),
            body: bodies + joint.link,
            kind,
            anchor_m: joint.anchor_m,
            axis: joint.axis,
            reference: joint.reference,
            range: joint.limits,
            damping: joint.damping,
            friction_loss: joint.friction,
            armature: joint.armature,
            stiffness: joint.stiffness,
            spring_reference: joint.spring_reference,
            stop: None,
        });
    }
    add_relations(layout, model, bodies, &joint_places);
    let named = model.joints.iter().zip(&joint_places);
    let named = named.filter_map(|(joint, place)| {
        let driven = !matches!(joint.kind, ModelJoint::Ball);
        Some((joint.name.clone(), place.filter(|_| driven)?))
    });
    let links = model.links.iter().enumerate();
    Added {
        root: bodies + model.roots().next().unwrap_or(0),
        links: links
            .map(|(i, link)| (link.name.clone(), bodies + i))
            .collect(),
        joints: named.collect(),
        shapes: shapes..layout.shapes.len(),
    }
}

fn kind_of(kind: ModelJoint) -> Option<JointKind> {
    match kind {
        ModelJoint::Revolute => Some(JointKind::Hinge),
        ModelJoint::Prismatic => Some(JointKind::Slide),
        ModelJoint::Ball => Some(JointKind::Ball),
        ModelJoint::Fixed | ModelJoint::Free => None,
    }
}

fn add_link(
    layout: &mut Layout,
    name: &str,
    model: &Model,
    index: usize,
    first: usize,
    place: &Pose,
    fixed: bool,
) {
    let link = &model.links[index];
    let own = Pose {
        position_m: link.pose_in_parent.position_m,
        orientation: link.pose_in_parent.rotation,
    };
    let pose = match link.parent {
        Some(_) => own,
        None => Pose {
            position_m: add(place.position_m, rotate(place.orientation, own.position_m)),
            orientation: compose(place.orientation, own.orientation),
        },
    };
    layout.bodies.push(BodyPlan {
        name: format!("{name}/{}", link.name),
        parent: link.parent.map(|parent| first + parent),
        pose,
        motion: motion_of(model, index, fixed),
        inertia: link
            .inertial
            .and_then(|it| it.simulated().0)
            .map(|inertial| Inertia {
                mass_kg: inertial.mass_kg,
                centre_m: inertial.centre_m,
                moments_kg_m2: inertial.tensor_kg_m2,
            }),
    });
}

fn motion_of(model: &Model, index: usize, fixed: bool) -> Motion {
    let link = &model.links[index];
    if link.parent.is_none() && link.kinematic {
        return Motion::Led;
    }
    let mut kinds = model.joints_of(index).map(|joint| joint.kind);
    match (
        model.moves(index, fixed),
        kinds.any(|kind| kind_of(kind).is_some()),
    ) {
        (true, true) => Motion::Jointed,
        (true, false) => Motion::Free,
        (false, _) => Motion::Fixed,
    }
}

#[allow(clippy::too_many_arguments, reason = "all are facts of the one shape")]
fn add_shape(
    layout: &mut Layout,
    name: &str,
    model: &Model,
    link: &Link,
    shape: &Shape,
    body: usize,
    friction: f64,
    group: u8,
) {
    let Some(form) = form_of(model, &shape.geometry) else {
        return;
    };
    let touches_nothing = shape
        .mask
        .is_some_and(|mask| mask.kind == 0 && mask.touches == 0);
    let touches = match (&link.contact_group, touches_nothing) {
        (_, true) => Touches::Nothing,
        (Some(_), _) => Touches::AllButGroup(group),
        (None, _) => Touches::All,
    };
    // Shapes often have no name, and names of different links may be the same.
    let number = layout.shapes.len();
    layout.shapes.push(ShapePlan {
        name: format!("{name}/{}/{}{number}", link.name, shape.name),
        body: Some(body),
        pose: Pose {
            position_m: shape.pose_in_link.position_m,
            orientation: shape.pose_in_link.rotation,
        },
        form,
        friction: shape.friction.map_or(friction, |friction| friction.sliding),
        touches,
        surface: Surface::default(),
    });
}

/// `None` for a mesh without a volume, which nothing can touch.
fn form_of(model: &Model, geometry: &Geometry) -> Option<Form> {
    Some(match geometry {
        Geometry::Box { half_extents_m } => Form::Box {
            edges_m: half_extents_m.map(|half| 2.0 * half),
        },
        Geometry::Sphere { radius_m } => Form::Sphere {
            radius_m: *radius_m,
        },
        Geometry::Cylinder { radius_m, length_m } => Form::Cylinder {
            radius_m: *radius_m,
            length_m: *length_m,
        },
        Geometry::Capsule { radius_m, length_m } => Form::Capsule {
            radius_m: *radius_m,
            length_m: *length_m,
        },
        Geometry::Ellipsoid { radii_m } => Form::Ellipsoid { radii_m: *radii_m },
        Geometry::Plane { .. } => Form::Ground,
        Geometry::Mesh { mesh } => {
            let mesh = model.meshes.get(*mesh).filter(|mesh| mesh.is_solid())?;
            Form::Hull {
                points_m: mesh.vertices_m.clone(),
            }
        }
    })
}

fn add_relations(layout: &mut Layout, model: &Model, bodies: usize, joints: &[Option<usize>]) {
    for coupling in &model.couplings {
        let Some(Some(joint)) = joints.get(coupling.joint) else {
            continue;
        };
        let leader = coupling
            .leader
            .map(|leader| joints.get(leader).copied().flatten());
        if leader == Some(None) {
            continue;
        }
        layout.couplings.push(CouplingPlan {
            joint: *joint,
            leader: leader.flatten(),
            coefficients: coupling.coefficients,
            carries: false,
        });
    }
    for pair in &model.no_contact {
        layout.no_contact.push(pair.map(|link| bodies + link));
    }
}
