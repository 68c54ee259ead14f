//! `<link>`: inertial, visual and collision.

use std::collections::BTreeMap;

use super::{address, origin};
use crate::checks;
use crate::diagnostics::{Effect, Place};
use crate::pose::Pose;
use crate::reader::Reader;
use crate::shape::{Geometry, Inertial, Role, Shape};
use crate::xml::Element;

/// A link, before its place in the tree is known.
pub(super) struct RawLink {
    pub name: String,
    pub inertial: Option<Inertial>,
    pub shapes: Vec<Shape>,
    pub place: Place,
}

pub(super) fn link(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    colours: &BTreeMap<String, [f64; 4]>,
) -> RawLink {
    reader.known_attributes(element, &["name"]);
    let name = reader.required(element, "name").to_owned();
    let mut raw = RawLink {
        name,
        inertial: None,
        shapes: vec![],
        place: element.place.clone(),
    };
    for child in &element.children {
        match child.name.as_str() {
            "inertial" => raw.inertial = inertial(reader, child, &raw.name),
            "visual" => raw
                .shapes
                .extend(shape(reader, child, Role::Visual, colours)),
            "collision" => raw
                .shapes
                .extend(shape(reader, child, Role::Collision, colours)),
            "self_collision_checking" | "collision_checking" => {
                reader.passed_over("link", child, Effect::Contact);
            }
            _ => reader.passed_over("link", child, Effect::Nothing),
        }
    }
    raw
}

fn inertial(reader: &mut Reader<'_, '_>, element: &Element, link: &str) -> Option<Inertial> {
    let pose = origin(reader, element);
    let mut mass_kg = None;
    let mut tensor_kg_m2 = [0.0; 6];
    for child in &element.children {
        match child.name.as_str() {
            "mass" => mass_kg = reader.number(child, "value"),
            "inertia" => {
                let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
                reader.known_attributes(child, &names);
                tensor_kg_m2 = names.map(|name| reader.number(child, name).unwrap_or(0.0));
            }
            "origin" => {}
            _ => reader.passed_over("inertial", child, Effect::Motion),
        }
    }
    let Some(mass_kg) = mass_kg else {
        let message = format!("the inertial of link {link} has no mass");
        reader.problem(&element.place, message, "add <mass value=\"...\"/>");
        return None;
    };
    let own = Inertial {
        mass_kg,
        centre_m: [0.0; 3],
        tensor_kg_m2,
    };
    checks::inertia(reader, &element.place, link, &own);
    Some(own.placed(&pose))
}

fn shape(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    role: Role,
    colours: &BTreeMap<String, [f64; 4]>,
) -> Option<Shape> {
    reader.known_attributes(element, &["name"]);
    let pose_in_link: Pose = origin(reader, element);
    let mut colour = None;
    let mut form = None;
    for child in &element.children {
        match child.name.as_str() {
            "geometry" => form = Some(child),
            "material" => colour = seen_colour(reader, child, colours),
            "origin" => {}
            "verbose" => reader.passed_over(&element.name, child, Effect::Nothing),
            _ => reader.passed_over(&element.name, child, Effect::Contact),
        }
    }
    let Some(form) = form else {
        let message = format!("a {} has no geometry", element.name);
        reader.problem(
            &element.place,
            message,
            "add <geometry>, or delete the element",
        );
        return None;
    };
    Some(Shape {
        name: element.get("name").unwrap_or("").to_owned(),
        role,
        pose_in_link,
        geometry: geometry(reader, form, role)?,
        friction: None,
        mask: None,
        contact_dimensions: None,
        colour,
    })
}

fn geometry(reader: &mut Reader<'_, '_>, element: &Element, role: Role) -> Option<Geometry> {
    let Some(form) = element.children.first() else {
        reader.problem(
            &element.place,
            "a geometry is empty",
            "add box, cylinder, sphere or mesh",
        );
        return None;
    };
    match form.name.as_str() {
        "box" => {
            reader.known_attributes(form, &["size"]);
            let size = sizes::<3>(reader, form, ["size"; 3], true)?;
            Some(Geometry::Box {
                half_extents_m: size.map(|length| length / 2.0),
            })
        }
        "sphere" => {
            reader.known_attributes(form, &["radius"]);
            let [radius_m] = sizes(reader, form, ["radius"], false)?;
            Some(Geometry::Sphere { radius_m })
        }
        "cylinder" | "capsule" => {
            reader.known_attributes(form, &["radius", "length"]);
            let [radius_m, length_m] = sizes(reader, form, ["radius", "length"], false)?;
            Some(if form.name == "capsule" {
                Geometry::Capsule { radius_m, length_m }
            } else {
                Geometry::Cylinder { radius_m, length_m }
            })
        }
        "mesh" => mesh(reader, form, role),
        other => {
            let message = format!("geometry {other} is not known to URDF");
            let remedy = "use box, cylinder, sphere, capsule or mesh";
            reader.problem(&form.place, message, remedy);
            None
        }
    }
}

/// Positive numbers: each of an attribute of its own, or all of the first (`together`).
fn sizes<const N: usize>(
    reader: &mut Reader<'_, '_>,
    form: &Element,
    names: [&str; N],
    together: bool,
) -> Option<[f64; N]> {
    let mut found = [0.0; N];
    if together {
        reader.required(form, names[0]);
        found = reader.attribute::<N>(form, names[0])?;
    } else {
        for (size, name) in found.iter_mut().zip(names) {
            reader.required(form, name);
            *size = reader.number(form, name)?;
        }
    }
    for (size, name) in found.iter().zip(names) {
        reader.size(&form.place, &format!("{}@{name}", form.name), *size)?;
    }
    Some(found)
}

fn mesh(reader: &mut Reader<'_, '_>, form: &Element, role: Role) -> Option<Geometry> {
    reader.known_attributes(form, &["filename", "scale"]);
    let named = reader.required(form, "filename");
    let scale = reader.attribute::<3>(form, "scale").unwrap_or([1.0; 3]);
    if named.is_empty() {
        return None;
    }
    if scale.contains(&0.0) {
        reader.problem(
            &form.place,
            "the scale of a mesh has a zero",
            "give factors other than 0",
        );
        return None;
    }
    let address = address(&form.place, named);
    let mesh = match role {
        Role::Visual => reader.mesh(&form.place, &address, scale, true)?,
        Role::Collision => reader.surface_mesh(&form.place, &address, scale)?,
    };
    Some(Geometry::Mesh { mesh })
}

/// Remembers the colour of a named material.
pub(super) fn material(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    colours: &mut BTreeMap<String, [f64; 4]>,
) {
    if let Some(colour) = seen_colour(reader, element, colours) {
        let name = element.get("name").unwrap_or("").to_owned();
        colours.insert(name, colour);
    }
}

fn seen_colour(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    colours: &BTreeMap<String, [f64; 4]>,
) -> Option<[f64; 4]> {
    for child in &element.children {
        if child.name != "color" {
            reader.passed_over("material", child, Effect::Looks);
        }
    }
    match element.child("color") {
        Some(colour) => reader.attribute::<4>(colour, "rgba"),
        None => colours.get(element.get("name").unwrap_or("")).copied(),
    }
}
