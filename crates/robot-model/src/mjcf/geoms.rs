//! `<geom>`: form, size, mass, friction and masks.

use super::Context;
use super::bodies::FRAME;
use crate::diagnostics::Effect;
use crate::pose::{Pose, add, length, scaled, subtract, z_axis_to};
use crate::shape::{Friction, Geometry, Inertial, Mask, Role, Shape};
use crate::xml::Element;

/// Density of a geom that says nothing, kg/m³.
const WATER: f64 = 1000.0;

const KNOWN: [&str; 13] = [
    "type",
    "size",
    "fromto",
    "mass",
    "density",
    "friction",
    "contype",
    "conaffinity",
    "condim",
    "rgba",
    "material",
    "mesh",
    "hfield",
];

impl Context<'_, '_, '_> {
    /// A geom in a frame: its shape, and its mass if it counts. `None` after a gap or a problem.
    pub(super) fn geom(
        &mut self,
        given: &Element,
        frame: &Pose,
        class: Option<&str>,
    ) -> Option<(Option<Shape>, Option<Inertial>)> {
        let element = self.defaults.applied(self.reader, given, class);
        let known = [&FRAME[..], &KNOWN[..]].concat();
        self.ignored(&element, &known, Effect::Contact);
        let (geometry, pose) = self.form(&element)?;
        let mask = Mask {
            kind: self.mask(&element, "contype")?,
            touches: self.mask(&element, "conaffinity")?,
        };
        let seen_only = mask.kind == 0 && mask.touches == 0;
        let shape = Shape {
            name: element.get("name").unwrap_or("").to_owned(),
            role: if seen_only {
                Role::Visual
            } else {
                Role::Collision
            },
            pose_in_link: frame.then(&pose),
            geometry,
            friction: self.friction(&element),
            mask: Some(mask),
            contact_dimensions: self.reader.number(&element, "condim").map(|n| n as u8),
            colour: self.reader.attribute::<4>(&element, "rgba"),
        };
        let inertial = self.mass(&element, &shape);
        Some((Some(shape), inertial))
    }

    fn mask(&mut self, element: &Element, name: &str) -> Option<u32> {
        match self.reader.number(element, name) {
            None => Some(1),
            Some(bits) if (0.0..2_147_483_648.0).contains(&bits) && bits.fract() == 0.0 => {
                Some(bits as u32)
            }
            Some(_) => {
                let message = format!("geom@{name} is not a valid mask");
                self.reader
                    .problem(&element.place, message, "give a whole number from 0");
                None
            }
        }
    }

    fn friction(&mut self, element: &Element) -> Option<Friction> {
        let attribute = element.attribute("friction")?;
        let numbers = self
            .reader
            .numbers(&attribute.place, "geom@friction", &attribute.value)?;
        Some(Friction {
            sliding: *numbers.first()?,
            torsional_m: numbers.get(1).copied(),
            rolling_m: numbers.get(2).copied(),
        })
    }

    /// Mass and inertia in the body's frame.
    fn mass(&mut self, element: &Element, shape: &Shape) -> Option<Inertial> {
        let group = self.reader.number(element, "group").unwrap_or(0.0);
        let [first, last] = self.compiler.inertia_groups;
        if !(first..=last).contains(&group) {
            return None;
        }
        let volume = shape.geometry.volume_m3(&self.reader.meshes);
        let mass = match self.reader.number(element, "mass") {
            Some(mass) => mass,
            None => self.reader.number(element, "density").unwrap_or(WATER) * volume,
        };
        if let Geometry::Mesh { mesh } = shape.geometry
            && volume <= 0.0
            && mass <= 0.0
        {
            let source = &self.reader.meshes[mesh].source;
            let what = format!("the mesh {source} has no triangles that enclose a volume");
            let consequence = "it adds no mass to its body";
            self.reader.gap(
                &element.place,
                "geom@mesh",
                what,
                Effect::Motion,
                consequence,
            );
        }
        if mass <= 0.0 {
            return None;
        }
        let Some(own) = shape.geometry.inertial(mass, &self.reader.meshes) else {
            let what = "the inertia of a shape without a volume is not computed";
            let consequence = "it adds no mass to its body";
            self.reader.gap(
                &element.place,
                "geom@mass",
                what,
                Effect::Motion,
                consequence,
            );
            return None;
        };
        Some(own.placed(&shape.pose_in_link))
    }

    /// Geometry and pose of a geom.
    fn form(&mut self, element: &Element) -> Option<(Geometry, Pose)> {
        let kind = element.get("type").unwrap_or("sphere");
        if element.get("mesh").is_some() && kind != "mesh" {
            let what = format!("fitting a {kind} to a mesh is not supported");
            let consequence = "the shape is left out";
            self.reader.gap(
                &element.place,
                "geom@mesh",
                what,
                Effect::Contact,
                consequence,
            );
            return None;
        }
        let sizes = match element.attribute("size") {
            Some(size) => self.reader.numbers(&size.place, "geom@size", &size.value)?,
            None => vec![],
        };
        let from_to = self.pose_from_to(element);
        let pose = match &from_to {
            Some((pose, _)) => *pose,
            None => self.compiler.pose(self.reader, element),
        };
        let half = from_to.map(|(_, half)| half);
        let geometry = match kind {
            "mesh" => {
                let name = self.reader.required(element, "mesh").to_owned();
                let Some(mesh) = self.meshes.get(&name) else {
                    let message = format!("there is no mesh {name}");
                    self.reader
                        .problem(&element.place, message, "add it to <asset>");
                    return None;
                };
                Geometry::Mesh { mesh: (*mesh)? }
            }
            "plane" => Geometry::Plane {
                half_extents_m: [0, 1].map(|axis: usize| sizes.get(axis).copied().unwrap_or(0.0)),
            },
            _ => self.primitive(element, kind, &sizes, half)?,
        };
        Some((geometry, pose))
    }

    fn primitive(
        &mut self,
        element: &Element,
        kind: &str,
        sizes: &[f64],
        half: Option<f64>,
    ) -> Option<Geometry> {
        let mut size = |index: usize| match sizes.get(index) {
            Some(size) => self.reader.positive(&element.place, "geom@size", *size),
            None => {
                let message = format!("a {kind} has only {} sizes", sizes.len());
                self.reader
                    .problem(&element.place, message, "give the others in size=\"...\"");
                None
            }
        };
        Some(match (kind, half) {
            ("sphere", _) => Geometry::Sphere { radius_m: size(0)? },
            ("capsule" | "cylinder", half) => {
                let radius_m = size(0)?;
                let length_m = 2.0 * half.map_or_else(|| size(1), Some)?;
                if kind == "capsule" {
                    Geometry::Capsule { radius_m, length_m }
                } else {
                    Geometry::Cylinder { radius_m, length_m }
                }
            }
            // Between two points, the first size is that of both sides across.
            ("box" | "ellipsoid", Some(half)) => {
                let across = size(0)?;
                full_form(kind, [across, across, half])
            }
            ("box" | "ellipsoid", None) => full_form(kind, [size(0)?, size(1)?, size(2)?]),
            _ => {
                let what = format!("geoms of type {kind} are not read");
                let consequence = "the shape is left out";
                self.reader
                    .gap(&element.place, "geom", what, Effect::Contact, consequence);
                return None;
            }
        })
    }

    /// `fromto`: the pose halfway, z from the second point to the first, and half the distance.
    pub(super) fn pose_from_to(&mut self, element: &Element) -> Option<(Pose, f64)> {
        let [a, b, c, d, e, f] = self.reader.attribute::<6>(element, "fromto")?;
        let (from, to) = ([a, b, c], [d, e, f]);
        let along = self
            .reader
            .axis(&element.place, "fromto", subtract(from, to));
        let pose = Pose {
            position_m: scaled(add(from, to), 0.5),
            rotation: z_axis_to(along),
        };
        Some((pose, length(subtract(to, from)) / 2.0))
    }
}

fn full_form(kind: &str, sizes: [f64; 3]) -> Geometry {
    if kind == "box" {
        Geometry::Box {
            half_extents_m: sizes,
        }
    } else {
        Geometry::Ellipsoid { radii_m: sizes }
    }
}
