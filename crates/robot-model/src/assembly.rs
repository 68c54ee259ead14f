//! Several models in one world, each with a prefix to its names, a pose, and its base fixed or free.

use std::fmt;

use crate::model::{Joint, JointKind, Model};
use crate::pose::Pose;
use crate::shape::Geometry;
use crate::{Format, Mjcf, MjcfError, MjcfOptions, to_mjcf};

/// How the roots of a model hang on the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// As the description says.
    AsDescribed,
    /// Rigidly; free joints of roots are removed.
    Fixed,
    /// Freely; roots that do not move on their own get a joint called `<link>_free`.
    Free,
}

/// Models gathered into one world.
///
/// ```
/// use robot_model::{Assembly, Base, MjcfOptions, Pose, parse};
///
/// let ball = r#"<robot name="ball"><link name="ball">
///   <inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/></inertial>
///   <collision><geometry><sphere radius="0.05"/></geometry></collision></link></robot>"#;
/// let floor = r#"<sdf version="1.9"><model name="floor"><static>true</static><link name="ground">
///   <collision name="c"><geometry><plane/></geometry></collision></link></model></sdf>"#;
/// let mut no_files = |address: &str| Err(format!("{address} is not here"));
/// let ball = parse("ball.urdf", ball, &mut no_files)?.model;
/// let floor = parse("floor.sdf", floor, &mut no_files)?.model;
///
/// let mut scene = Assembly::new("scene");
/// scene.add(&floor, "floor/", Pose::IDENTITY, Base::AsDescribed)?;
/// scene.add(&ball, "left/", Pose::at([0.0, 0.3, 1.0]), Base::Free)?;
/// scene.add(&ball, "right/", Pose::at([0.0, -0.3, 1.0]), Base::Free)?;
/// assert_eq!(scene.model().freedoms(), 12);
/// let mjcf = scene.to_mjcf(&MjcfOptions::default())?;
/// assert!(mjcf.text.contains("left/ball"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    model: Model,
}

/// Why a model cannot be added.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NameTaken {
    /// The name that two things would have.
    pub name: String,
}

impl fmt::Display for NameTaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the scene would have two things called {}; give each model a prefix of its own",
            self.name
        )
    }
}

impl std::error::Error for NameTaken {}

impl Assembly {
    /// An empty world.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            model: Model::empty(name, Format::Mjcf),
        }
    }

    /// Adds a model with `prefix` before all its names, its world frame placed by `pose`.
    ///
    /// Gravity and time step are taken from the first model that has them.
    ///
    /// # Errors
    /// When a link, joint, actuator or mark would have the name of another.
    pub fn add(
        &mut self,
        model: &Model,
        prefix: &str,
        pose: Pose,
        base: Base,
    ) -> Result<(), NameTaken> {
        let based = with_base(model, base);
        self.names_are_new(&based, prefix)?;
        let all = &mut self.model;
        let (links, meshes) = (all.links.len(), all.meshes.len());
        let (joints, named) = (all.joints.len(), |name: &str| format!("{prefix}{name}"));
        all.meshes.extend(based.meshes.iter().cloned());
        all.links.extend(based.links.into_iter().map(|mut link| {
            link.name = named(&link.name);
            link.contact_group = link.contact_group.map(|group| named(&group));
            match &mut link.parent {
                Some(parent) => *parent += links,
                None => link.pose_in_parent = pose.then(&link.pose_in_parent),
            }
            for shape in &mut link.shapes {
                if let Geometry::Mesh { mesh } = &mut shape.geometry {
                    *mesh += meshes;
                }
            }
            link
        }));
        all.joints.extend(based.joints.into_iter().map(|mut joint| {
            joint.name = named(&joint.name);
            joint.link += links;
            joint
        }));
        all.sensors
            .extend(based.sensors.into_iter().map(|mut sensor| {
                sensor.name = named(&sensor.name);
                sensor.link = sensor.link.map(|link| link + links);
                if let Some(joint) = sensor.kind.joint_mut() {
                    *joint += joints;
                }
                sensor
            }));
        all.actuators
            .extend(based.actuators.into_iter().map(|mut actuator| {
                actuator.name = named(&actuator.name);
                actuator.joint += joints;
                actuator
            }));
        all.couplings
            .extend(based.couplings.into_iter().map(|mut coupling| {
                coupling.joint += joints;
                coupling.leader = coupling.leader.map(|leader| leader + joints);
                coupling
            }));
        all.marks.extend(based.marks.into_iter().map(|mut mark| {
            mark.name = named(&mark.name);
            match &mut mark.link {
                Some(link) => *link += links,
                None => mark.pose_in_link = pose.then(&mark.pose_in_link),
            }
            mark
        }));
        let pairs = based.no_contact.iter();
        all.no_contact
            .extend(pairs.map(|pair| pair.map(|link| link + links)));
        all.gravity_m_s2 = all.gravity_m_s2.or(based.gravity_m_s2);
        all.time_step_secs = all.time_step_secs.or(based.time_step_secs);
        Ok(())
    }

    fn names_are_new(&self, model: &Model, prefix: &str) -> Result<(), NameTaken> {
        let known = Names::of(&self.model, "");
        let new = Names::of(model, prefix);
        for (known, new) in known.0.iter().zip(&new.0) {
            if let Some(name) = new.iter().find(|name| known.contains(*name)) {
                return Err(NameTaken { name: name.clone() });
            }
        }
        Ok(())
    }

    /// Everything as one model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Everything as one MJCF text; see [`to_mjcf`].
    ///
    /// # Errors
    /// As [`to_mjcf`].
    pub fn to_mjcf(&self, options: &MjcfOptions) -> Result<Mjcf, MjcfError> {
        to_mjcf(&self.model, options)
    }
}

/// Names of links, joints, actuators and marks.
struct Names([std::collections::BTreeSet<String>; 4]);

impl Names {
    fn of(model: &Model, prefix: &str) -> Self {
        let named = |name: &String| format!("{prefix}{name}");
        Self([
            model.links.iter().map(|link| named(&link.name)).collect(),
            model
                .joints
                .iter()
                .map(|joint| named(&joint.name))
                .collect(),
            model
                .actuators
                .iter()
                .map(|actuator| named(&actuator.name))
                .collect(),
            model.marks.iter().map(|mark| named(&mark.name)).collect(),
        ])
    }
}

/// The model with its roots as wanted.
fn with_base(model: &Model, base: Base) -> Model {
    let mut result = model.clone();
    match base {
        Base::AsDescribed => {}
        // Turned into names of rigid connections, which keeps the indices of the others.
        Base::Fixed => {
            for joint in &mut result.joints {
                if joint.kind == JointKind::Free {
                    joint.kind = JointKind::Fixed;
                }
            }
        }
        Base::Free => {
            let roots: Vec<usize> = result.roots().collect();
            for root in roots {
                let moves = result
                    .joints_of(root)
                    .any(|joint| joint.kind.freedoms() > 0);
                if !moves && !result.links[root].kinematic {
                    let name = format!("{}_free", result.links[root].name);
                    result.insert_joint(Joint::new(name, root, JointKind::Free));
                }
            }
        }
    }
    result
}
