//! `<worldbody>`: links as bodies, with inertias, shapes and marks.

use super::{Writer, escaped, list, put};
use crate::model::Link;
use crate::pose::Pose;
use crate::shape::{Geometry, Inertial, Role, Shape};
use std::fmt::Write;

/// What is still to be written, in order.
enum Task {
    Open(usize),
    Close,
}

impl Writer<'_> {
    /// All bodies, without recursion, since chains may be long.
    pub(super) fn bodies(&mut self) {
        let model = self.model;
        let mut children: Vec<Vec<usize>> = vec![vec![]; model.links.len()];
        for (index, link) in model.links.iter().enumerate() {
            if let Some(parent) = link.parent {
                children[parent].push(index);
            }
        }
        self.text.push_str("<worldbody>\n");
        self.marks(None);
        let mut tasks: Vec<Task> = model.roots().map(Task::Open).collect();
        tasks.reverse();
        while let Some(task) = tasks.pop() {
            let Task::Open(index) = task else {
                self.text.push_str("</body>\n");
                continue;
            };
            // The name belongs to MuJoCo's own root; what such a link carries is the world's.
            if !self.is_the_world(index) {
                self.open_body(index);
                tasks.push(Task::Close);
            }
            self.content(index);
            tasks.extend(children[index].iter().rev().map(|child| Task::Open(*child)));
        }
        self.text.push_str("</worldbody>\n");
    }

    /// Whether a link stands for MuJoCo's world body.
    fn is_the_world(&self, index: usize) -> bool {
        let link = &self.model.links[index];
        link.name == "world"
            && link.parent.is_none()
            && link.pose_in_parent == Pose::IDENTITY
            && self
                .model
                .joints_of(index)
                .all(|joint| joint.kind.freedoms() == 0)
    }

    fn open_body(&mut self, index: usize) {
        let link = &self.model.links[index];
        put!(self.text, "<body name=\"{}\"", escaped(&link.name));
        self.pose(&link.pose_in_parent);
        if !link.gravity {
            self.text.push_str(" gravcomp=\"1\"");
        }
        if link.kinematic {
            self.text.push_str(" mocap=\"true\"");
        }
        self.text.push_str(">\n");
        if let Some(inertial) = &link.inertial {
            self.inertial(inertial);
        }
    }

    fn content(&mut self, index: usize) {
        let model = self.model;
        for joint in model.joints_of(index) {
            self.joint(joint);
        }
        let link = &model.links[index];
        for (position, shape) in link.shapes.iter().enumerate() {
            if shape.role == Role::Collision || self.options.visuals {
                self.shape(index, position, shape);
            }
        }
        self.marks(Some(index));
    }

    fn pose(&mut self, pose: &Pose) {
        put!(
            self.text,
            " pos=\"{}\" quat=\"{}\"",
            list(&pose.position_m),
            list(&pose.rotation)
        );
    }

    fn inertial(&mut self, inertial: &Inertial) {
        if inertial.mass_kg <= 0.0 {
            return;
        }
        let (moments, axes) = inertial.principal_axes();
        put!(
            self.text,
            "<inertial pos=\"{}\" quat=\"{}\" mass=\"{}\" diaginertia=\"{}\"/>\n",
            list(&inertial.centre_m),
            list(&axes),
            inertial.mass_kg,
            list(&moments)
        );
    }

    fn shape(&mut self, index: usize, position: usize, shape: &Shape) {
        let link = &self.model.links[index];
        let form = match &shape.geometry {
            Geometry::Plane { .. } if !self.model.is_static(index) => {
                self.notes.push(format!(
                    "the plane on link {} is left out, since MuJoCo knows planes only on links that never move",
                    link.name
                ));
                return;
            }
            Geometry::Mesh { mesh } => {
                if !self.written_meshes.get(*mesh).copied().unwrap_or(false) {
                    return;
                }
                format!("type=\"mesh\" mesh=\"mesh_{mesh}\"")
            }
            other => form(other),
        };
        // Names of shapes need not be unique in URDF and SDF; these are.
        put!(
            self.text,
            "<geom name=\"{}\" {form}",
            escaped(&shape_name(link, position))
        );
        self.pose(&shape.pose_in_link);
        match (shape.role, shape.mask) {
            (Role::Visual, _) => {
                self.text
                    .push_str(" contype=\"0\" conaffinity=\"0\" group=\"2\"");
            }
            (Role::Collision, Some(mask)) => {
                let (kind, touches) = (mask.kind, mask.touches);
                put!(self.text, " contype=\"{kind}\" conaffinity=\"{touches}\"");
            }
            (Role::Collision, None) => {}
        }
        if let Some(friction) = shape.friction {
            // MJCF lists them in this order; those behind keep their default if left out.
            let mut numbers = vec![friction.sliding];
            if let Some(torsional) = friction.torsional_m {
                numbers.push(torsional);
                numbers.extend(friction.rolling_m);
            }
            put!(self.text, " friction=\"{}\"", list(&numbers));
        }
        if let Some(dimensions) = shape.contact_dimensions {
            put!(self.text, " condim=\"{dimensions}\"");
        }
        if let Some(colour) = shape.colour {
            put!(self.text, " rgba=\"{}\"", list(&colour));
        }
        self.text.push_str("/>\n");
    }

    fn marks(&mut self, link: Option<usize>) {
        let model = self.model;
        for mark in model.marks.iter().filter(|mark| mark.link == link) {
            put!(self.text, "<site name=\"{}\"", escaped(&mark.name));
            self.pose(&mark.pose_in_link);
            self.text.push_str("/>\n");
        }
    }
}

/// The name of a link's shape in the written text: `link/0`, `link/1`, by its place among the link's shapes.
#[must_use]
pub fn shape_name(link: &Link, position: usize) -> String {
    format!("{}/{position}", link.name)
}

/// Type and size of a primitive.
fn form(geometry: &Geometry) -> String {
    match geometry {
        Geometry::Box { half_extents_m } => {
            format!("type=\"box\" size=\"{}\"", list(half_extents_m))
        }
        Geometry::Sphere { radius_m } => format!("type=\"sphere\" size=\"{radius_m}\""),
        Geometry::Cylinder { radius_m, length_m } => {
            format!("type=\"cylinder\" size=\"{radius_m} {}\"", length_m / 2.0)
        }
        Geometry::Capsule { radius_m, length_m } => {
            format!("type=\"capsule\" size=\"{radius_m} {}\"", length_m / 2.0)
        }
        Geometry::Ellipsoid { radii_m } => {
            format!("type=\"ellipsoid\" size=\"{}\"", list(radii_m))
        }
        Geometry::Plane { half_extents_m } => {
            format!("type=\"plane\" size=\"{} 1\"", list(half_extents_m))
        }
        Geometry::Mesh { mesh } => format!("type=\"mesh\" mesh=\"mesh_{mesh}\""),
    }
}
