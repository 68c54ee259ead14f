//! URDF: `<robot>` with links, joints, materials, transmissions, `ros2_control` and Gazebo's extensions.
//!
//! Source: the XML specification of the ROS package `urdf` (links, joints, transmissions), `ros2_control`'s hardware
//! description, and the `<gazebo>` elements that Gazebo's converter reads. A joint's origin is the frame of its child at
//! position zero, so a link's `pose_in_parent` is its joint's origin and anchors are zero. Deviations: a planar joint
//! becomes two slides and a turn, in this order; a floating joint's axis means nothing.

mod control;
mod gazebo;
mod joints;
mod links;

use std::collections::BTreeMap;

use crate::diagnostics::{Effect, Place, Problems};
use crate::model::{Format, Joint, Link, Model};
use crate::pose::{Pose, from_roll_pitch_yaw};
use crate::reader::{Loaded, Reader, Resolver, joined};
use crate::tree::{self, NoTree};
use crate::xml::{self, Element};

use joints::RawJoint;
use links::RawLink;

/// Reads a URDF text, known as `file`. Everything that is not carried over is in [`Loaded::gaps`].
///
/// # Errors
/// All problems that prevent loading, with their places.
pub fn parse_urdf(file: &str, text: &str, resolve: &mut Resolver<'_>) -> Result<Loaded, Problems> {
    let root = xml::read(file, text).map_err(|problem| Problems(vec![problem]))?;
    let mut reader = Reader::new(resolve);
    let root = reader.expanded(root, &Default::default())?;
    let model = robot(&mut reader, &root);
    reader.finish(model)
}

/// Reads the root element.
pub(crate) fn robot(reader: &mut Reader<'_, '_>, root: &Element) -> Option<Model> {
    if root.name != "robot" {
        let message = format!("a URDF starts with <robot>, not with <{}>", root.name);
        reader.problem(&root.place, message, "name the file of the robot");
        return None;
    }
    reader.known_attributes(root, &["name", "version"]);
    let mut parts = Parts::default();
    for child in root.all("material") {
        links::material(reader, child, &mut parts.colours);
    }
    for child in &root.children {
        match child.name.as_str() {
            "link" => {
                let link = links::link(reader, child, &parts.colours);
                parts.links.push(link);
            }
            "joint" => parts.joints.extend(joints::joint(reader, child)),
            "transmission" | "ros2_control" | "gazebo" | "material" => {}
            _ => reader.passed_over("robot", child, Effect::Nothing),
        }
    }
    parts.assemble(reader, root)
}

/// What was read, before it is a tree.
#[derive(Default)]
struct Parts {
    colours: BTreeMap<String, [f64; 4]>,
    links: Vec<RawLink>,
    joints: Vec<RawJoint>,
}

impl Parts {
    fn assemble(self, reader: &mut Reader<'_, '_>, root: &Element) -> Option<Model> {
        let name = root.get("name").unwrap_or("robot");
        let mut model = Model::empty(name, Format::Urdf);
        let order = self.tree(reader, root)?;
        let mut index_of = vec![0; self.links.len()];
        let mut places = vec![];
        for (index, (raw, connection)) in order.iter().enumerate() {
            index_of[*raw] = index;
            let raw = &self.links[*raw];
            let joint = connection.map(|joint| &self.joints[joint]);
            let parent = joint.and_then(|joint| self.link_called(&joint.parent));
            model.links.push(Link {
                name: raw.name.clone(),
                parent: parent.map(|parent| index_of[parent]),
                pose_in_parent: joint.map_or(Pose::IDENTITY, |joint| joint.origin),
                inertial: raw.inertial,
                shapes: raw.shapes.clone(),
                gravity: true,
                contact_group: Some(name.to_owned()),
                kinematic: false,
            });
            places.push(raw.place.clone());
            if let Some(joint) = joint {
                let own = joint.joints.iter().cloned();
                model
                    .joints
                    .extend(own.map(|own| Joint { link: index, ..own }));
            }
        }
        unique_joints(reader, &model, root);
        joints::couplings(reader, &self.joints, &mut model);
        control::read(reader, root, &mut model);
        gazebo::read(reader, root, &mut model);
        reader.link_places = places;
        Some(model)
    }

    fn link_called(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// The order of the links; problems if they are no tree with one root.
    fn tree(
        &self,
        reader: &mut Reader<'_, '_>,
        root: &Element,
    ) -> Option<Vec<(usize, Option<usize>)>> {
        let before = reader.problems.len();
        let mut index: BTreeMap<&str, usize> = BTreeMap::new();
        for (position, link) in self.links.iter().enumerate() {
            if index.insert(&link.name, position).is_some() {
                let message = format!("two links are called {}", link.name);
                reader.problem(&link.place, message, "rename one of them");
            }
        }
        let mut connections = vec![];
        for joint in &self.joints {
            let ends = [&joint.child, &joint.parent].map(|name| index.get(name.as_str()).copied());
            for (end, name) in ends.iter().zip([&joint.child, &joint.parent]) {
                if end.is_none() {
                    let message = format!(
                        "joint {} names link {name}, which does not exist",
                        joint.name
                    );
                    reader.problem(&joint.place, message, "add the link or correct the name");
                }
            }
            if let [Some(child), Some(parent)] = ends {
                connections.push((child, Some(parent)));
            }
        }
        if self.links.is_empty() {
            reader.problem(&root.place, "the robot has no link", "add a <link>");
        }
        if reader.problems.len() > before {
            return None;
        }
        let order = match tree::order(self.links.len(), &connections) {
            Ok(order) => order,
            Err(error) => {
                self.no_tree(reader, &error);
                return None;
            }
        };
        let roots: Vec<&RawLink> = order
            .iter()
            .filter(|(_, connection)| connection.is_none())
            .map(|(link, _)| &self.links[*link])
            .collect();
        if let [first, second, ..] = roots[..] {
            let message = format!(
                "links {} and {} are both roots, but a URDF is one tree",
                first.name, second.name
            );
            let remedy = format!("connect {} by a joint, or delete it", second.name);
            reader.problem(&second.place, message, remedy);
            return None;
        }
        Some(order)
    }

    fn no_tree(&self, reader: &mut Reader<'_, '_>, error: &NoTree) {
        match error {
            NoTree::TwoParents { link, second } => {
                let joint = &self.joints[*second];
                let message = format!(
                    "link {} is the child of a second joint, {}",
                    self.links[*link].name, joint.name
                );
                let remedy = "a URDF is a tree: describe closed loops in SDF or MJCF";
                reader.problem(&joint.place, message, remedy);
            }
            NoTree::Cycle { connection } => {
                let joint = &self.joints[*connection];
                let message = format!("joint {} lies on a cycle of links", joint.name);
                reader.problem(&joint.place, message, "remove one joint of the cycle");
            }
        }
    }
}

fn unique_joints(reader: &mut Reader<'_, '_>, model: &Model, root: &Element) {
    let mut seen = std::collections::BTreeSet::new();
    for joint in &model.joints {
        if !seen.insert(joint.name.as_str()) {
            let message = format!("two joints are called {}", joint.name);
            reader.problem(&root.place, message, "rename one of them");
        }
    }
}

/// `<origin xyz rpy>`; the identity if there is none.
fn origin(reader: &mut Reader<'_, '_>, parent: &Element) -> Pose {
    let Some(origin) = parent.child("origin") else {
        return Pose::IDENTITY;
    };
    reader.known_attributes(origin, &["xyz", "rpy", "quat_xyzw"]);
    let position_m = reader.attribute::<3>(origin, "xyz").unwrap_or_default();
    let rotation = match reader.attribute::<4>(origin, "quat_xyzw") {
        Some([x, y, z, w]) => crate::pose::normalized([w, x, y, z]),
        None => from_roll_pitch_yaw(reader.attribute::<3>(origin, "rpy").unwrap_or_default()),
    };
    Pose {
        position_m,
        rotation,
    }
}

/// The address of a mesh as URDF names it.
fn address(place: &Place, named: &str) -> String {
    joined(&place.file, named)
}
