//! `<collision>` and `<visual>`: geometry, surface, material.

use crate::diagnostics::Effect;
use crate::pose::{Pose, z_axis_to};
use crate::reader::{Reader, joined};
use crate::shape::{Friction, Geometry, Mask, Role, Shape};
use crate::xml::Element;

/// Reads a shape whose frame stands at `pose_in_link`.
pub(super) fn shape(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    role: Role,
    pose_in_link: Pose,
) -> Option<Shape> {
    let mut shape = Shape {
        name: element.get("name").unwrap_or("").to_owned(),
        role,
        pose_in_link,
        geometry: Geometry::Sphere { radius_m: 1.0 },
        friction: None,
        mask: None,
        contact_dimensions: None,
        colour: None,
    };
    let mut form = None;
    for child in &element.children {
        match child.name.as_str() {
            "geometry" => form = Some(geometry(reader, child, role)),
            "surface" => surface(reader, child, &mut shape),
            "material" => shape.colour = colour(reader, child),
            "pose" | "density" => {}
            "laser_retro" => reader.passed_over(&element.name, child, Effect::Sensing),
            "max_contacts" => reader.passed_over(&element.name, child, Effect::Contact),
            _ if role == Role::Visual => reader.passed_over("visual", child, Effect::Looks),
            _ => reader.passed_over(&element.name, child, Effect::Contact),
        }
    }
    let Some(form) = form else {
        let message = format!("{} {} has no geometry", element.name, shape.name);
        reader.problem(
            &element.place,
            message,
            "add <geometry>, or delete the element",
        );
        return None;
    };
    let (geometry, turn) = form?;
    shape.geometry = geometry;
    shape.pose_in_link = shape.pose_in_link.then(&turn);
    Some(shape)
}

/// A geometry, and the pose of its frame in the shape's (planes are turned to their normals).
fn geometry(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    role: Role,
) -> Option<(Geometry, Pose)> {
    let form = element.children.first()?;
    let mut size = |name: &str, default: f64| {
        let number = reader.child_number(form, name).unwrap_or(default);
        reader.size(&form.place, &format!("{}/{name}", form.name), number)
    };
    let geometry = match form.name.as_str() {
        "sphere" => Geometry::Sphere {
            radius_m: size("radius", 1.0)?,
        },
        "cylinder" => Geometry::Cylinder {
            radius_m: size("radius", 1.0)?,
            length_m: size("length", 1.0)?,
        },
        "capsule" => Geometry::Capsule {
            radius_m: size("radius", 0.5)?,
            length_m: size("length", 1.0)?,
        },
        "box" => Geometry::Box {
            half_extents_m: triple(reader, form, "size", true)?.map(|length| length / 2.0),
        },
        "ellipsoid" => Geometry::Ellipsoid {
            radii_m: triple(reader, form, "radii", true)?,
        },
        "plane" => return plane(reader, form),
        "mesh" => mesh(reader, form, role)?,
        "empty" => return None,
        other => {
            let what = format!("geometry {other} is not read");
            let consequence = "the shape is left out, so nothing touches it";
            let effect = effect_of(role);
            reader.gap(&form.place, "geometry", what, effect, consequence);
            return None;
        }
    };
    Some((geometry, Pose::IDENTITY))
}

fn effect_of(role: Role) -> Effect {
    match role {
        Role::Visual => Effect::Looks,
        Role::Collision => Effect::Contact,
    }
}

/// Three numbers in a child (1 1 1 if it is missing), positive ones if asked for.
fn triple(
    reader: &mut Reader<'_, '_>,
    form: &Element,
    name: &str,
    positive: bool,
) -> Option<[f64; 3]> {
    let Some(child) = form.child(name) else {
        return Some([1.0; 3]);
    };
    let what = format!("{}/{name}", form.name);
    let numbers = reader.exactly::<3>(&child.place, &what, &child.text)?;
    if positive {
        for number in numbers {
            reader.size(&child.place, &what, number)?;
        }
    }
    Some(numbers)
}

fn plane(reader: &mut Reader<'_, '_>, form: &Element) -> Option<(Geometry, Pose)> {
    let normal = match form.child("normal") {
        Some(child) => {
            let numbers = reader.exactly::<3>(&child.place, "plane/normal", &child.text)?;
            reader.axis(&child.place, "plane/normal", numbers)
        }
        None => [0.0, 0.0, 1.0],
    };
    let half_extents_m = match form.child("size") {
        Some(child) => reader
            .exactly::<2>(&child.place, "plane/size", &child.text)?
            .map(|length| length.abs() / 2.0),
        None => [0.5, 0.5],
    };
    let turn = Pose::turned(z_axis_to(normal));
    Some((Geometry::Plane { half_extents_m }, turn))
}

fn mesh(reader: &mut Reader<'_, '_>, form: &Element, role: Role) -> Option<Geometry> {
    let Some(uri) = form.text_of("uri").filter(|uri| !uri.is_empty()) else {
        reader.problem(&form.place, "a mesh has no uri", "add <uri>");
        return None;
    };
    for child in &form.children {
        match child.name.as_str() {
            "uri" | "scale" => {}
            _ => reader.passed_over("mesh", child, effect_of(role)),
        }
    }
    let scale = triple(reader, form, "scale", false)?;
    if scale.contains(&0.0) {
        reader.problem(
            &form.place,
            "the scale of a mesh has a zero",
            "give factors other than 0",
        );
        return None;
    }
    let address = joined(&form.place.file, uri);
    let mesh = match role {
        Role::Visual => reader.mesh(&form.place, &address, scale, true)?,
        Role::Collision => reader.surface_mesh(&form.place, &address, scale)?,
    };
    Some(Geometry::Mesh { mesh })
}

fn surface(reader: &mut Reader<'_, '_>, element: &Element, shape: &mut Shape) {
    for child in &element.children {
        match child.name.as_str() {
            "friction" => shape.friction = friction(reader, child),
            "contact" => {
                for below in &child.children {
                    if below.name == "collide_bitmask" {
                        shape.mask = bitmask(reader, below);
                    } else {
                        reader.passed_over("contact", below, Effect::Contact);
                    }
                }
            }
            _ => reader.passed_over("surface", child, Effect::Contact),
        }
    }
}

fn bitmask(reader: &mut Reader<'_, '_>, element: &Element) -> Option<Mask> {
    let text = element.text.trim();
    let number = match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    // MuJoCo's masks are signed.
    let number = number.filter(|bits| *bits <= 0x7fff_ffff);
    if number.is_none() {
        let remedy = "give a number from 0 to 2147483647, or 0x...";
        reader.problem(
            &element.place,
            "collide_bitmask is not a valid mask",
            remedy,
        );
    }
    number.map(|bits| Mask {
        kind: bits,
        touches: bits,
    })
}

/// `mu` of any engine's part; others are approximated by it.
fn friction(reader: &mut Reader<'_, '_>, element: &Element) -> Option<Friction> {
    let mut sliding = None;
    for part in &element.children {
        let (first, second) = match part.name.as_str() {
            "ode" => ("mu", "mu2"),
            "bullet" => ("friction", "friction2"),
            _ => {
                reader.passed_over("friction", part, Effect::Contact);
                continue;
            }
        };
        let numbers = [first, second].map(|name| reader.child_number(part, name));
        for child in &part.children {
            if child.name != first && child.name != second {
                reader.passed_over(&part.name, child, Effect::Contact);
            }
        }
        if let [Some(mu), Some(mu2)] = numbers
            && mu != mu2
        {
            let what = format!("{second} = {mu2} differs from {first} = {mu}, which is used");
            let consequence = "friction is the same in every direction";
            reader.gap(&part.place, "friction", what, Effect::Contact, consequence);
        }
        sliding = sliding.or(numbers[0]).or(numbers[1]);
    }
    let sliding = sliding?;
    if sliding < 0.0 {
        // Gazebo reads -1 as "the default".
        return None;
    }
    Some(Friction {
        sliding,
        torsional_m: None,
        rolling_m: None,
    })
}

fn colour(reader: &mut Reader<'_, '_>, element: &Element) -> Option<[f64; 4]> {
    for child in &element.children {
        match child.name.as_str() {
            "ambient" | "diffuse" | "specular" | "emissive" => {}
            _ => reader.passed_over("material", child, Effect::Looks),
        }
    }
    let child = element
        .child("diffuse")
        .or_else(|| element.child("ambient"))?;
    let numbers = reader.numbers(&child.place, "material/diffuse", &child.text)?;
    match numbers[..] {
        [red, green, blue] => Some([red, green, blue, 1.0]),
        [red, green, blue, opacity] => Some([red, green, blue, opacity]),
        _ => None,
    }
}
