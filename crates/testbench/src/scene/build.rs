//! From a scene's data and the draws of an episode to a layout, and where things are in it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::compliant::{Compliant, keep_apart};
use super::data::{
    Actuator, ActuatorKind, Gripper, GripperKind, GroupMode, JointGroup, Object, Robot, SceneData,
    Sensor, SensorKind,
};
use super::draws::Draws;
use super::fingers::{begin_together, carry, join};
use super::load::Description;
use super::materials::coat;
use super::person::body_of;
use super::sensing::joints_of;
use super::translate::{Added, add_model};
use super::vision::Marker;
use crate::bench::ScenarioError;
use crate::geometry::{IDENTITY, Pose, box_inertia, cylinder_inertia, sphere_inertia};
use crate::physics::{
    BodyPlan, DriveKind, DrivePlan, Form, Inertia, Layout, Motion, Physics, ShapePlan, Solver,
    Surface, Touches,
};
use crate::viewer::{Geometry, Role, VisibleShape};

/// The parsed descriptions of robots and objects, by file and arguments.
pub(super) type Models = BTreeMap<Description, robot_model::Model>;

/// A layout, and the places in it of what the scene names.
#[derive(Debug, Clone)]
pub(super) struct Built {
    pub(super) layout: Layout,
    pub(super) robots: Vec<BuiltRobot>,
    pub(super) people: Vec<BuiltPerson>,
    pub(super) objects: Vec<BuiltObject>,
    /// Shapes of the ground.
    pub(super) ground: Range<usize>,
    /// For each actuator its drives, left before right.
    pub(super) drives: Vec<Range<usize>>,
}

impl Built {
    /// What can be seen of the scene.
    pub(super) fn geometry(&self) -> Geometry {
        let shapes = self.layout.shapes.iter().enumerate();
        let shapes = shapes.map(|(index, shape)| VisibleShape {
            name: shape.name.clone(),
            body: shape.body,
            role: self.role(index, shape),
            pose: shape.pose,
            form: shape.form.clone(),
        });
        Geometry {
            bodies: self
                .layout
                .bodies
                .iter()
                .map(|it| it.name.clone())
                .collect(),
            shapes: shapes.collect(),
        }
    }

    /// Joints of a gripper's robot that others drive.
    pub(super) fn driven_elsewhere(
        &self,
        gripper: &Gripper,
        robot: usize,
        data: &SceneData,
    ) -> Vec<usize> {
        driven_elsewhere(gripper, data, &self.robots[robot].added.joints)
    }

    fn role(&self, index: usize, shape: &ShapePlan) -> Role {
        if self
            .robots
            .iter()
            .any(|it| it.added.shapes.contains(&index))
        {
            Role::Robot
        } else if self.people.iter().any(|it| it.shapes.contains(&index)) {
            Role::Person
        } else if shape.body.is_none() {
            Role::Surroundings
        } else {
            Role::Object
        }
    }
}

/// Where a robot is in the layout.
#[derive(Debug, Clone)]
pub(super) struct BuiltRobot {
    pub(super) added: Added,
    /// Positions of joints at the beginning.
    pub(super) start: Vec<(usize, f64)>,
}

impl BuiltRobot {
    /// The body of a link, or of the root.
    pub(super) fn body(&self, link: Option<&str>) -> Option<usize> {
        match link {
            None => Some(self.added.root),
            Some(name) => self.added.links.get(name).copied(),
        }
    }
}

/// Where an object is in the layout.
#[derive(Debug, Clone)]
pub(super) struct BuiltObject {
    /// Its body; none of a plain one that is fixed to the world.
    pub(super) body: Option<usize>,
    /// Where it stands at the beginning.
    pub(super) pose: Pose,
    /// Bodies by the names of links, of one from a file.
    pub(super) links: BTreeMap<String, usize>,
    pub(super) joints: BTreeMap<String, usize>,
    pub(super) shapes: Range<usize>,
}

/// Where a person is in the layout.
#[derive(Debug, Clone)]
pub(super) struct BuiltPerson {
    /// The parts' bodies, in the order of the person's parts.
    pub(super) bodies: Range<usize>,
    pub(super) shapes: Range<usize>,
    pub(super) height_m: f64,
    pub(super) radius_m: f64,
    /// What holds the parts, of who gives way.
    pub(super) compliant: Option<Compliant>,
}

/// Lays the scene out.
///
/// # Errors
/// [`ScenarioError`] for a link or joint that a description does not have.
pub(super) fn build(
    data: &SceneData,
    models: &Models,
    draws: Draws,
) -> Result<Built, ScenarioError> {
    let mut layout = Layout {
        time_step_secs: data.simulation.time_step_secs,
        gravity_m_s2: data.simulation.gravity_m_s2,
        solver: Solver {
            mujoco: data.simulation.mujoco.solver(),
            rapier: data.simulation.rapier.solver(),
        },
        ..Layout::default()
    };
    ground(&mut layout, data, draws);
    let ground = 0..layout.shapes.len();
    let mut group = 1;
    let mut next_group = || {
        group += 1;
        group - 1
    };
    let mut robots = data
        .robots
        .iter()
        .map(|robot| add_robot(&mut layout, robot, models, draws, next_group()))
        .collect::<Result<Vec<_>, _>>()?;
    let objects = data.objects.iter();
    let objects = objects
        .map(|object| add_object(&mut layout, object, models, draws, next_group()))
        .collect::<Result<Vec<_>, _>>()?;
    let people = data.people.iter();
    let people: Vec<BuiltPerson> = people
        .map(|person| body_of(&mut layout, person, draws, next_group()))
        .collect();
    check_steps(data, &people)?;
    keep_apart(&mut layout, &people);
    coat(&mut layout, data, (&robots, &objects, &people), draws)?;
    let drives = data
        .actuators
        .iter()
        .map(|actuator| add_drives(&mut layout, actuator, data, &robots))
        .collect::<Result<_, _>>()?;
    begin_together(&layout, data, &mut robots)?;
    layout.wrenches = borne(data, &layout, &robots)?;
    let built = Built {
        layout,
        robots,
        people,
        objects,
        ground,
        drives,
    };
    check_sensors(data, &built)?;
    Ok(built)
}

/// Steps are short enough for the skin of everybody who gives way.
fn check_steps(data: &SceneData, people: &[BuiltPerson]) -> Result<(), ScenarioError> {
    let step_secs = data.simulation.time_step_secs;
    for (person, built) in data.people.iter().zip(people) {
        let longest_secs = built.compliant.as_ref().map(Compliant::longest_step_secs);
        if let Some(longest_secs) = longest_secs.filter(|longest| step_secs > *longest) {
            let problem = format!(
                "is longer than {longest_secs:.2e} s, which the skin of `{}` allows: a hard skin over a small mass swings quickly",
                person.name
            );
            return Err(ScenarioError::value("simulation.time_step_secs", &problem));
        }
    }
    Ok(())
}

/// The floor touches everything but what is fixed to the world as well.
fn ground(layout: &mut Layout, data: &SceneData, draws: Draws) {
    if let Some(ground) = &data.ground {
        layout.shapes.push(ShapePlan {
            name: "ground".to_owned(),
            body: None,
            pose: Pose {
                position_m: [0.0; 3],
                orientation: IDENTITY,
            },
            form: Form::Ground,
            friction: draws.number("ground.friction", &ground.friction),
            touches: Touches::AllButGroup(0),
            surface: Surface::default(),
        });
    }
}

fn add_robot(
    layout: &mut Layout,
    robot: &Robot,
    models: &Models,
    draws: Draws,
    group: u8,
) -> Result<BuiltRobot, ScenarioError> {
    let key = |field: &str| super::data::key_of("robot", &robot.name, field);
    let model = model_of(models, &robot.description(), &key("file"))?;
    let pose = draws.place("robot", &robot.name, &robot.place());
    let friction = draws.of("robot", &robot.name, "friction", &robot.friction);
    let added = add_model(
        layout,
        &robot.name,
        model,
        &pose,
        robot.fixed,
        friction,
        group,
    );
    let joint = |list: &str, name: &str| {
        let unknown = || ScenarioError::UnknownName {
            key: key(list),
            name: name.to_owned(),
        };
        added.joints.get(name).copied().ok_or_else(unknown)
    };
    let mut start = Vec::new();
    for (name, position) in &robot.joints {
        let field = format!("joints.{name}");
        let position = draws.of("robot", &robot.name, &field, position);
        start.push((joint("joints", name)?, position));
    }
    for (name, friction) in &robot.joint_friction {
        let field = format!("joint_friction.{name}");
        let friction = draws.of("robot", &robot.name, &field, friction);
        layout.joints[joint("joint_friction", name)?].friction_loss = friction;
    }
    for name in &robot.recorded_joints {
        joint("recorded_joints", name)?;
    }
    Ok(BuiltRobot { start, added })
}

fn model_of<'a>(
    models: &'a Models,
    of: &Description,
    key: &str,
) -> Result<&'a robot_model::Model, ScenarioError> {
    models.get(of).ok_or_else(|| ScenarioError::UnknownName {
        key: key.to_owned(),
        name: of.0.clone(),
    })
}

fn add_object(
    layout: &mut Layout,
    object: &Object,
    models: &Models,
    draws: Draws,
    group: u8,
) -> Result<BuiltObject, ScenarioError> {
    let pose = draws.place("object", &object.name, &object.place());
    let friction = draws.of("object", &object.name, "friction", &object.friction);
    if let Some(of) = object.description() {
        let key = super::data::key_of("object", &object.name, "file");
        let model = model_of(models, &of, &key)?;
        let added = add_model(
            layout,
            &object.name,
            model,
            &pose,
            object.fixed,
            friction,
            group,
        );
        return Ok(BuiltObject {
            body: Some(added.root),
            pose,
            links: added.links,
            joints: added.joints,
            shapes: added.shapes,
        });
    }
    let mass_kg = object.mass_kg.as_ref();
    let mass_kg = mass_kg.map(|mass| draws.of("object", &object.name, "mass_kg", mass));
    let (form, moments) = form_of(object, mass_kg.unwrap_or(1.0));
    let identity = Pose {
        position_m: [0.0; 3],
        orientation: IDENTITY,
    };
    // What is fixed belongs to the world, so that it does not touch the ground.
    let (body, at, group) = match mass_kg {
        None => (None, pose, 0),
        Some(mass_kg) => {
            layout.bodies.push(BodyPlan {
                name: object.name.clone(),
                parent: None,
                pose,
                motion: Motion::Free,
                inertia: Some(Inertia {
                    mass_kg,
                    centre_m: [0.0; 3],
                    moments_kg_m2: [moments[0], moments[1], moments[2], 0.0, 0.0, 0.0],
                }),
            });
            (Some(layout.bodies.len() - 1), identity, group)
        }
    };
    layout.shapes.push(ShapePlan {
        name: format!("{}/shape", object.name),
        body,
        pose: at,
        form,
        friction,
        touches: Touches::AllButGroup(group),
        surface: Surface::default(),
    });
    Ok(BuiltObject {
        body,
        pose,
        links: BTreeMap::new(),
        joints: BTreeMap::new(),
        shapes: layout.shapes.len() - 1..layout.shapes.len(),
    })
}

/// The object's form and, for its mass, its moments of inertia.
fn form_of(object: &Object, mass_kg: f64) -> (Form, [f64; 3]) {
    match (object.box_m, object.radius_m, object.length_m) {
        (Some(edges_m), _, _) => (Form::Box { edges_m }, box_inertia(mass_kg, edges_m)),
        (None, Some(radius_m), Some(length_m)) => (
            Form::Cylinder { radius_m, length_m },
            cylinder_inertia(mass_kg, length_m, radius_m),
        ),
        (None, radius_m, _) => {
            // The check of the data has seen to it that a radius is there.
            let radius_m = radius_m.unwrap_or(1.0);
            (Form::Sphere { radius_m }, sphere_inertia(mass_kg, radius_m))
        }
    }
}

fn add_drives(
    layout: &mut Layout,
    actuator: &Actuator,
    data: &SceneData,
    robots: &[BuiltRobot],
) -> Result<Range<usize>, ScenarioError> {
    let start = layout.drives.len();
    let robot = data.robots.iter().position(|r| r.name == actuator.robot);
    let joints = robot
        .and_then(|robot| robots.get(robot))
        .map(|robot| &robot.added.joints);
    let (kind, limit) = match &actuator.kind {
        ActuatorKind::Position {
            stiffness,
            damping,
            limit,
            ..
        } => {
            let (stiffness, damping) = (*stiffness, *damping);
            (DriveKind::Position { stiffness, damping }, *limit)
        }
        ActuatorKind::Velocity { gain, limit, .. } => (DriveKind::Velocity { gain: *gain }, *limit),
        ActuatorKind::DifferentialDrive {
            gain_nms_rad,
            torque_limit_nm,
            ..
        } => (
            DriveKind::Velocity {
                gain: *gain_nms_rad,
            },
            *torque_limit_nm,
        ),
        ActuatorKind::Effort { limit, .. } => (DriveKind::Effort, *limit),
        ActuatorKind::JointGroup(group) => {
            let plans = group_drives(group);
            return add_each(layout, actuator, joints, &plans);
        }
        ActuatorKind::Gripper(gripper) => {
            return add_gripper(layout, gripper, actuator, data, robots);
        }
        ActuatorKind::PlanarVelocity { .. } => return Ok(start..start),
    };
    for name in actuator.kind.joints() {
        let joint = joints.and_then(|joints| joints.get(name));
        let Some(joint) = joint else {
            return Err(ScenarioError::UnknownName {
                key: super::data::key_of("actuator", &actuator.name, "joint"),
                name: name.to_owned(),
            });
        };
        layout.drives.push(DrivePlan {
            joint: *joint,
            kind,
            limit,
        });
    }
    Ok(start..layout.drives.len())
}

/// A drive for each joint of a group, each with its law and its limit.
fn add_each(
    layout: &mut Layout,
    actuator: &Actuator,
    joints: Option<&BTreeMap<String, usize>>,
    plans: &[(DriveKind, f64)],
) -> Result<Range<usize>, ScenarioError> {
    let start = layout.drives.len();
    let named = actuator.kind.joints().into_iter().zip(plans);
    for (place, (name, (kind, limit))) in named.enumerate() {
        let joint = joints.and_then(|joints| joints.get(name));
        let joint = joint.ok_or_else(|| ScenarioError::UnknownName {
            key: super::data::key_of("group", &actuator.name, &format!("joints.{place}")),
            name: name.to_owned(),
        })?;
        layout.drives.push(DrivePlan {
            joint: *joint,
            kind: *kind,
            limit: *limit,
        });
    }
    Ok(start..layout.drives.len())
}

fn group_drives(data: &JointGroup) -> Vec<(DriveKind, f64)> {
    let group = &data.group;
    let number = |numbers: &Option<super::data::PerJoint>, joint: usize| {
        numbers.as_ref().map_or(0.0, |numbers| numbers.of(joint))
    };
    let kind = |joint: usize| match group.mode {
        GroupMode::Position | GroupMode::Impedance => DriveKind::Position {
            stiffness: number(&group.stiffness, joint),
            damping: number(&group.damping, joint),
        },
        GroupMode::Velocity => DriveKind::Velocity {
            gain: number(&group.damping, joint),
        },
        GroupMode::Torque => DriveKind::Effort,
    };
    let joints = data.torque_limit.iter().enumerate();
    joints.map(|(joint, limit)| (kind(joint), *limit)).collect()
}

fn add_gripper(
    layout: &mut Layout,
    gripper: &Gripper,
    actuator: &Actuator,
    data: &SceneData,
    robots: &[BuiltRobot],
) -> Result<Range<usize>, ScenarioError> {
    let start = layout.drives.len();
    let robot = data.robots.iter().position(|r| r.name == actuator.robot);
    let named = robot.and_then(|robot| robots.get(robot));
    let named = named.map(|robot| &robot.added.joints);
    let mut joints = Vec::new();
    for (place, name) in gripper.joints().iter().enumerate() {
        let joint = named.and_then(|named| named.get(name)).copied();
        joints.push(joint.ok_or_else(|| ScenarioError::UnknownName {
            key: super::data::key_of("gripper", &gripper.name, &format!("joints.{place}")),
            name: name.to_owned(),
        })?);
    }
    match &gripper.kind {
        GripperKind::Parallel { .. } => {
            let elsewhere = named.map(|named| driven_elsewhere(gripper, data, named));
            join(
                layout,
                &gripper.kind,
                &joints,
                &elsewhere.unwrap_or_default(),
            );
        }
        GripperKind::UnderActuated {
            pulley_radii_m,
            tension_limit_newtons,
            ..
        } => {
            for (joint, radius_m) in joints.iter().zip(pulley_radii_m) {
                layout.drives.push(DrivePlan {
                    joint: *joint,
                    kind: DriveKind::Effort,
                    limit: (radius_m.abs() * tension_limit_newtons).max(1e-9),
                });
            }
            carry(layout, &joints);
            add_return_springs(layout, gripper, start..layout.drives.len());
        }
        GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => {}
    }
    Ok(start..layout.drives.len())
}

/// Joints of the gripper's robot that others drive.
fn driven_elsewhere(
    gripper: &Gripper,
    data: &SceneData,
    named: &BTreeMap<String, usize>,
) -> Vec<usize> {
    let others = data.actuators.iter();
    let others = others.filter(|it| it.robot == gripper.robot && it.name != gripper.name);
    let joints = others.flat_map(|it| it.kind.joints());
    joints.filter_map(|name| named.get(name).copied()).collect()
}

/// Springs that open an under-actuated gripper's joints, besides those that its description has.
fn add_return_springs(layout: &mut Layout, gripper: &Gripper, drives: Range<usize>) {
    if let GripperKind::UnderActuated {
        return_stiffness, ..
    } = &gripper.kind
    {
        for (drive, stiffness) in drives.zip(return_stiffness) {
            let joint = layout.drives[drive].joint;
            layout.joints[joint].stiffness += stiffness;
        }
    }
}

/// Every link and joint that a sensor names exists.
fn check_sensors(data: &SceneData, built: &Built) -> Result<(), ScenarioError> {
    for sensor in &data.sensors {
        let robot = data.robots.iter().position(|r| r.name == sensor.robot);
        let Some(robot) = robot.and_then(|robot| built.robots.get(robot)) else {
            continue;
        };
        let unknown = |field: &str, name: &str| ScenarioError::UnknownName {
            key: super::data::key_of("sensor", &sensor.name, field),
            name: name.to_owned(),
        };
        if robot.body(sensor.link()).is_none() {
            return Err(unknown("link", sensor.link().unwrap_or_default()));
        }
        for joint in sensor.joints() {
            if !robot.added.joints.contains_key(joint) {
                return Err(unknown("joints", joint));
            }
        }
        if let SensorKind::MarkerCamera {
            target,
            target_part,
            ..
        } = &sensor.kind
            && Marker::find(
                &built.layout,
                (target, target_part.as_deref()),
                [0.0; 3],
                None,
            )
            .is_none()
        {
            return Err(match target_part {
                Some(part) => unknown("target_part", &format!("{target}/{part}")),
                None => unknown("target", target),
            });
        }
    }
    Ok(())
}

/// The bodies of which sensors measure what they bear.
fn borne(
    data: &SceneData,
    layout: &Layout,
    robots: &[BuiltRobot],
) -> Result<Vec<usize>, ScenarioError> {
    let mut bodies = BTreeSet::new();
    for sensor in &data.sensors {
        let place = data.robots.iter().position(|r| r.name == sensor.robot);
        let Some(robot) = place.and_then(|robot| robots.get(robot)) else {
            continue;
        };
        match &sensor.kind {
            SensorKind::ForceTorque { .. } => bodies.extend(robot.body(sensor.link())),
            SensorKind::JointTorque { joints } => {
                for joint in joints_of(robot, joints) {
                    let body = layout.joints[joint].body;
                    let joints = layout.joints.iter().filter(|it| it.body == body);
                    if joints.count() > 1 {
                        let key = super::data::key_of("sensor", &sensor.name, "joints");
                        let problem = "names one of several joints of a link, which bear together; use force_torque";
                        return Err(ScenarioError::value(&key, problem));
                    }
                    bodies.insert(body);
                }
            }
            _ => {}
        }
    }
    Ok(bodies.into_iter().collect())
}

/// An engine that does not know what links bear cannot have sensors of it.
///
/// # Errors
/// [`ScenarioError::Value`] naming such a sensor.
pub(super) fn check_engine(
    data: &SceneData,
    layout: &Layout,
    physics: &dyn Physics,
) -> Result<(), ScenarioError> {
    if layout
        .wrenches
        .iter()
        .all(|body| physics.wrench(*body).is_some())
    {
        return Ok(());
    }
    let is_bearing = |sensor: &&Sensor| {
        matches!(
            sensor.kind,
            SensorKind::ForceTorque { .. } | SensorKind::JointTorque { .. }
        )
    };
    let name = data.sensors.iter().find(is_bearing);
    let key = super::data::key_of("sensor", name.map_or("", |it| it.name.as_str()), "kind");
    let (engine, _) = physics.engine();
    let problem = format!(
        "is of a link that is fixed to the world, whose forces {engine} does not compute; mount it on a link that moves, or use MuJoCo"
    );
    Err(ScenarioError::value(&key, &problem))
}
