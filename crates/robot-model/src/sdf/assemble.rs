//! From links and joints with frames to the tree.

use std::collections::BTreeMap;

use super::joint::{self, Freedoms};
use super::scope::{Collected, FoundJoint, FoundLink, placed, within};
use super::{geometry, sensor};
use crate::actuator::Coupling;
use crate::checks;
use crate::diagnostics::{Effect, Place};
use crate::model::{Joint, JointKind, Link, Mark, Model};
use crate::pose::{Pose, scaled};
use crate::reader::Reader;
use crate::shape::{Inertial, Mask, Role, Shape};
use crate::tree;
use crate::xml::Element;

/// A joint that connects the tree: the moved link, the link it hangs on, and whether the text has them the other way.
struct Connection {
    joint: usize,
    child: usize,
    parent: Option<usize>,
    is_reversed: bool,
}

/// Puts everything together; `prefix` is taken off names.
pub(super) fn assemble(
    reader: &mut Reader<'_, '_>,
    mut collected: Collected<'_>,
    mut model: Model,
    prefix: Option<&str>,
) -> Option<Model> {
    let in_world: Vec<Pose> = collected
        .links
        .iter()
        .map(|link| {
            collected
                .frames
                .in_world(reader, &link.name, &link.element.place)
        })
        .collect();
    let connections = connections(reader, &collected);
    let edges: Vec<tree::Connection> = connections.iter().map(|c| (c.child, c.parent)).collect();
    // Connections were only added between separate trees, so they make no cycle.
    let order = tree::order(collected.links.len(), &edges).ok()?;
    let mut index_of = vec![0; collected.links.len()];
    for (index, (raw, _)) in order.iter().enumerate() {
        index_of[*raw] = index;
    }
    let mut places = vec![];
    for (raw, connection) in &order {
        let found = &collected.links[*raw];
        let connection = connection.map(|index| &connections[index]);
        let parent = connection.and_then(|connection| connection.parent);
        let above = parent.map_or(Pose::IDENTITY, |parent| in_world[parent]);
        let index = model.links.len();
        let link = Link {
            name: found.name.clone(),
            parent: parent.map(|parent| index_of[parent]),
            pose_in_parent: above.inverse().then(&in_world[*raw]),
            inertial: None,
            shapes: vec![],
            gravity: true,
            contact_group: found.group.clone(),
            kinematic: false,
        };
        model.links.push(link);
        places.push(found.element.place.clone());
        match connection {
            Some(connection) => {
                let found = &collected.joints[connection.joint];
                let pose = &in_world[*raw];
                let made = joint::freedoms(reader, found, &mut collected.frames, pose);
                if let Some(made) = made {
                    push_joints(&mut model, index, made, connection.is_reversed);
                }
            }
            None if !found.is_static => {
                let name = free_name(&model, &found.name);
                model.joints.push(Joint::new(name, index, JointKind::Free));
            }
            None => {}
        }
    }
    contents(reader, &mut collected, &in_world, &index_of, &mut model);
    shared_masks(&mut model);
    mimics(reader, &collected, &mut model);
    strip(&mut model, prefix);
    reader.link_places = places;
    Some(model)
}

fn free_name(model: &Model, link: &str) -> String {
    let mut name = format!("{link}_free");
    while model.joint(&name).is_some() {
        name.push('_');
    }
    name
}

fn push_joints(model: &mut Model, link: usize, made: Freedoms, is_reversed: bool) {
    let first = model.joints.len();
    let mut joints = made.joints;
    if is_reversed {
        joints.reverse();
        for joint in &mut joints {
            joint.axis = scaled(joint.axis, -1.0);
        }
    }
    let turn_first = !is_reversed;
    model
        .joints
        .extend(joints.into_iter().map(|joint| Joint { link, ..joint }));
    if let Some(pitch) = made.screw_m_per_rad {
        let (turn, slide) = if turn_first {
            (first, first + 1)
        } else {
            (first + 1, first)
        };
        model.couplings.push(Coupling {
            joint: slide,
            leader: Some(turn),
            coefficients: [0.0, pitch, 0.0, 0.0, 0.0],
        });
    }
}

/// The connections of the tree, by joints in the order of the text.
fn connections(reader: &mut Reader<'_, '_>, collected: &Collected<'_>) -> Vec<Connection> {
    let index: BTreeMap<&str, usize> = collected
        .links
        .iter()
        .enumerate()
        .map(|(index, link)| (link.name.as_str(), index))
        .collect();
    let mut forest = Forest {
        root: (0..collected.links.len()).collect(),
        connected: vec![false; collected.links.len()],
    };
    let mut found = vec![];
    for (position, joint) in collected.joints.iter().enumerate() {
        let Some((child, parent)) = ends(reader, collected, &index, joint) else {
            continue;
        };
        if joint.is_static || collected.links[child].is_static {
            continue;
        }
        if !is_known_type(joint.element.get("type").unwrap_or("")) {
            let what = "joints of this type are not read";
            let consequence = "the links are not connected by it";
            reader.gap(
                &joint.element.place,
                "joint",
                what,
                Effect::Motion,
                consequence,
            );
            continue;
        }
        match forest.connect(child, parent) {
            Some(is_reversed) => {
                let (child, parent) = match (is_reversed, parent) {
                    (true, Some(parent)) => (parent, Some(child)),
                    _ => (child, parent),
                };
                found.push(Connection {
                    joint: position,
                    child,
                    parent,
                    is_reversed,
                });
            }
            None => {
                let what = format!("joint {} closes a loop and is left out", joint.name);
                let consequence = "the loop is open: its links move more freely";
                let place = &joint.element.place;
                reader.gap(place, "joint", what, Effect::Motion, consequence);
            }
        }
    }
    found
}

fn is_known_type(kind: &str) -> bool {
    let known = [
        "fixed",
        "ball",
        "revolute",
        "continuous",
        "prismatic",
        "universal",
        "revolute2",
        "screw",
    ];
    known.contains(&kind)
}

/// Which links hang together.
struct Forest {
    /// A link nearer to the root of its tree, or itself.
    root: Vec<usize>,
    /// Whether a link hangs on another or on the world.
    connected: Vec<bool>,
}

impl Forest {
    fn root_of(&mut self, mut link: usize) -> usize {
        while self.root[link] != link {
            self.root[link] = self.root[self.root[link]];
            link = self.root[link];
        }
        link
    }

    /// Hangs a child on a parent, or the parent on the child if only that is possible (`true`); `None` if neither.
    fn connect(&mut self, child: usize, parent: Option<usize>) -> Option<bool> {
        let Some(parent) = parent else {
            return (!std::mem::replace(&mut self.connected[child], true)).then_some(false);
        };
        let (below, above) = (self.root_of(child), self.root_of(parent));
        if below == above {
            return None;
        }
        if !self.connected[child] {
            self.connected[child] = true;
            self.root[below] = above;
            Some(false)
        } else if !self.connected[parent] {
            self.connected[parent] = true;
            self.root[above] = below;
            Some(true)
        } else {
            None
        }
    }
}

/// Child and parent of a joint; problems if they are missing.
fn ends(
    reader: &mut Reader<'_, '_>,
    collected: &Collected<'_>,
    index: &BTreeMap<&str, usize>,
    joint: &FoundJoint<'_>,
) -> Option<(usize, Option<usize>)> {
    let mut end = |which: &str| {
        let named = joint.element.child(which);
        // Old files have <child link="..."/>.
        let name = named.map(|child| child.get("link").unwrap_or(&child.text).to_owned());
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            let message = format!("joint {} has no {which}", joint.name);
            reader.problem(&joint.element.place, message, format!("add <{which}>"));
            return None;
        };
        let full = within(&joint.scope, &name);
        if full.is_empty() {
            return Some(None);
        }
        let is_link = |name: &str| index.contains_key(name);
        let link = collected.frames.link_of(&full, &is_link);
        if link.is_none() && !collected.frames.has(&full) {
            let message = format!("joint {} names {full}, which does not exist", joint.name);
            reader.problem(&joint.element.place, message, "correct the name");
            return None;
        }
        // A frame that moves with no link is the world's.
        Some(link.and_then(|link| index.get(link.as_str()).copied()))
    };
    let (child, parent) = (end("child")?, end("parent")?);
    let Some(child) = child else {
        let message = format!("the child of joint {} is the world", joint.name);
        reader.problem(&joint.element.place, message, "exchange parent and child");
        return None;
    };
    if parent == Some(child) {
        let message = format!("joint {} connects a link with itself", joint.name);
        reader.problem(&joint.element.place, message, "correct parent or child");
        return None;
    }
    Some((child, parent))
}

/// What hangs on links and joints.
fn contents(
    reader: &mut Reader<'_, '_>,
    collected: &mut Collected<'_>,
    in_world: &[Pose],
    index_of: &[usize],
    model: &mut Model,
) {
    let links = std::mem::take(&mut collected.links);
    for (raw, found) in links.iter().enumerate() {
        let mut inside = Inside {
            reader,
            collected,
            found,
            index: index_of[raw],
            from_world: in_world[raw].inverse(),
        };
        inside.read(model);
    }
    for (name, place) in std::mem::take(&mut collected.marks) {
        let pose = collected.frames.in_world(reader, &name, &place);
        let is_link = |name: &str| links.iter().any(|link| link.name == name);
        let link = collected.frames.link_of(&name, &is_link);
        let raw = link.and_then(|link| links.iter().position(|known| known.name == link));
        model.marks.push(Mark {
            name,
            link: raw.map(|raw| index_of[raw]),
            pose_in_link: raw.map_or(pose, |raw| in_world[raw].inverse().then(&pose)),
        });
    }
    for joint in &collected.joints {
        let index = model.joint(&joint.name);
        for child in joint.element.all("sensor") {
            let link = index.map(|index| model.joints[index].link);
            let made = sensor::read(reader, child, model, link, index);
            model.sensors.extend(made);
        }
    }
    collected.links = links;
}

/// The reading of one link.
struct Inside<'a, 'r, 's, 'e> {
    reader: &'a mut Reader<'r, 's>,
    collected: &'a mut Collected<'e>,
    found: &'a FoundLink<'e>,
    index: usize,
    from_world: Pose,
}

impl Inside<'_, '_, '_, '_> {
    fn read(&mut self, model: &mut Model) {
        let element = self.found.element;
        let mut given = None;
        for child in &element.children {
            let truth = child.text.trim() == "true" || child.text.trim() == "1";
            match child.name.as_str() {
                "inertial" => given = Some(child),
                "collision" | "visual" => {
                    let role = if child.name == "visual" {
                        Role::Visual
                    } else {
                        Role::Collision
                    };
                    let pose = self.pose(child);
                    let made = geometry::shape(self.reader, child, role, pose);
                    model.links[self.index].shapes.extend(made);
                }
                "sensor" => self.sensor(child, model),
                "gravity" => {
                    model.links[self.index].gravity =
                        child.text.trim() != "false" && child.text.trim() != "0"
                }
                "self_collide" if truth => model.links[self.index].contact_group = None,
                "self_collide" | "pose" | "must_be_base_link" => {}
                "kinematic" if !truth => {}
                "enable_wind" if !truth => {}
                "light" | "projector" | "particle_emitter" => {
                    self.reader.passed_over("link", child, Effect::Looks);
                }
                "audio_sink" | "audio_source" | "battery" => {
                    self.reader.passed_over("link", child, Effect::Nothing);
                }
                "plugin" => self.reader.passed_over("link", child, Effect::Control),
                _ => self.reader.passed_over("link", child, Effect::Motion),
            }
        }
        model.links[self.index].inertial = self.inertial(given, model);
    }

    /// The pose of something on the link, in the link's frame.
    fn pose(&mut self, element: &Element) -> Pose {
        let own = &self.found.name;
        let (parent, pose) = placed(self.reader, element, &self.found.scope, own);
        if parent == *own {
            return pose;
        }
        let frames = &mut self.collected.frames;
        let parent = frames.in_world(self.reader, &parent, &element.place);
        self.from_world.then(&parent).then(&pose)
    }

    fn sensor(&mut self, element: &Element, model: &mut Model) {
        let pose_in_link = self.pose(element);
        let made = sensor::read(self.reader, element, model, Some(self.index), None);
        model.sensors.extend(made.map(|made| crate::sensor::Sensor {
            pose_in_link,
            ..made
        }));
    }

    fn inertial(&mut self, given: Option<&Element>, model: &Model) -> Option<Inertial> {
        let is_automatic = given.and_then(|element| element.get("auto")) == Some("true");
        if is_automatic {
            return self.inertial_of_shapes(given, model);
        }
        let Some(element) = given else {
            if self.found.is_static {
                return None;
            }
            let place = &self.found.element.place;
            let what = format!("link {} has no inertial", self.found.name);
            let consequence = "SDF's default is taken: 1 kg and moments of 1 kg m²";
            self.reader
                .gap(place, "link", what, Effect::Motion, consequence);
            return Some(DEFAULT);
        };
        let mut own = DEFAULT;
        for child in &element.children {
            match child.name.as_str() {
                "mass" => own.mass_kg = self.reader.child_number(element, "mass").unwrap_or(1.0),
                "inertia" => {
                    let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
                    let defaults = DEFAULT.tensor_kg_m2;
                    for ((name, default), moment) in
                        names.iter().zip(defaults).zip(&mut own.tensor_kg_m2)
                    {
                        *moment = self.reader.child_number(child, name).unwrap_or(default);
                    }
                }
                "pose" => {}
                _ => self.reader.passed_over("inertial", child, Effect::Motion),
            }
        }
        checks::inertia(self.reader, &element.place, &self.found.name, &own);
        let pose = self.pose(element);
        Some(own.placed(&pose))
    }

    /// `<inertial auto="true">`: from the collisions and their densities.
    fn inertial_of_shapes(&mut self, given: Option<&Element>, model: &Model) -> Option<Inertial> {
        const WATER: f64 = 1000.0;
        let element = self.found.element;
        let general = given.and_then(|given| self.reader.child_number(given, "density"));
        let named: BTreeMap<&str, f64> = element
            .all("collision")
            .filter_map(|collision| {
                let density = self.reader.child_number(collision, "density")?;
                Some((collision.get("name")?, density))
            })
            .collect();
        let shapes = &model.links[self.index].shapes;
        let meshes = &self.reader.meshes;
        let part = |shape: &Shape| {
            let density = named
                .get(shape.name.as_str())
                .copied()
                .or(general)
                .unwrap_or(WATER);
            let mass = density * shape.geometry.volume_m3(meshes);
            let own = shape.geometry.inertial(mass, meshes)?;
            Some(own.placed(&shape.pose_in_link))
        };
        let touching = shapes.iter().filter(|shape| shape.role == Role::Collision);
        touching
            .filter_map(part)
            .reduce(|sum, next| sum.joined(&next))
    }
}

/// What SDF gives to a link without an inertial.
const DEFAULT: Inertial = Inertial {
    mass_kg: 1.0,
    centre_m: [0.0; 3],
    tensor_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
};

/// Shapes without a mask touch every mask, if the description uses masks at all.
fn shared_masks(model: &mut Model) {
    const ALL: u32 = 0xffff;
    let shapes = || model.links.iter().flat_map(|link| &link.shapes);
    if shapes().all(|shape| shape.mask.is_none()) {
        return;
    }
    for link in &mut model.links {
        for shape in &mut link.shapes {
            shape.mask = shape.mask.or(Some(Mask {
                kind: ALL,
                touches: ALL,
            }));
        }
    }
}

/// `<mimic joint>`: `q = multiplier (leader - reference) + offset`.
fn mimics(reader: &mut Reader<'_, '_>, collected: &Collected<'_>, model: &mut Model) {
    for joint in &collected.joints {
        let Some(mimic) = joint
            .element
            .child("axis")
            .and_then(|axis| axis.child("mimic"))
        else {
            continue;
        };
        let leader = within(&joint.scope, reader.required(mimic, "joint"));
        let [multiplier, offset, reference] =
            [("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0)]
                .map(|(name, default)| reader.child_number(mimic, name).unwrap_or(default));
        let find = |model: &Model, name: &str| {
            let found = model.joint(name)?;
            (model.joints[found].kind.position_size() == 1).then_some(found)
        };
        match (find(model, &joint.name), find(model, &leader)) {
            (Some(follower), Some(leader)) if follower != leader => {
                model.couplings.push(Coupling {
                    joint: follower,
                    leader: Some(leader),
                    coefficients: [offset - multiplier * reference, multiplier, 0.0, 0.0, 0.0],
                })
            }
            _ => {
                let what = format!("no joint {leader} with one freedom exists to be followed");
                let consequence = format!("joint {} moves on its own", joint.name);
                let place: &Place = &mimic.place;
                reader.gap(place, "axis/mimic", what, Effect::Motion, consequence);
            }
        }
    }
}

/// Takes the name of the only model off.
fn strip(model: &mut Model, prefix: Option<&str>) {
    let Some(prefix) = prefix else { return };
    let links = model.links.iter_mut().map(|link| &mut link.name);
    let joints = model.joints.iter_mut().map(|joint| &mut joint.name);
    let marks = model.marks.iter_mut().map(|mark| &mut mark.name);
    for name in links.chain(joints).chain(marks) {
        if let Some(short) = name.strip_prefix(prefix) {
            *name = short.to_owned();
        }
    }
}
