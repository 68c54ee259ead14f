//! `<gazebo>`: friction, gravity and sensors that Gazebo's converter puts into links.

use crate::diagnostics::Effect;
use crate::model::Model;
use crate::reader::Reader;
use crate::sdf::sensor;
use crate::shape::{Friction, Role};
use crate::xml::Element;

pub(super) fn read(reader: &mut Reader<'_, '_>, root: &Element, model: &mut Model) {
    for element in root.all("gazebo") {
        reader.known_attributes(element, &["reference"]);
        match element.get("reference") {
            None | Some("") => whole(reader, element, model),
            Some(name) => match (model.link(name), model.joint(name)) {
                (Some(link), _) => for_link(reader, element, model, link),
                (None, Some(_)) => for_joint(reader, element),
                (None, None) => {
                    let message = format!("no link or joint is called {name}");
                    reader.warn(&element.place, message, "correct the reference");
                }
            },
        }
    }
}

/// Extensions of the whole robot.
fn whole(reader: &mut Reader<'_, '_>, element: &Element, model: &mut Model) {
    for child in &element.children {
        match child.name.as_str() {
            "static" if reader.truth(&child.place, "static", &child.text) == Some(false) => {}
            "self_collide" => {
                if reader.truth(&child.place, "self_collide", &child.text) == Some(true) {
                    for link in &mut model.links {
                        link.contact_group = None;
                    }
                }
            }
            "plugin" => reader.passed_over("gazebo", child, Effect::Control),
            _ => reader.passed_over("gazebo", child, Effect::Motion),
        }
    }
}

fn for_joint(reader: &mut Reader<'_, '_>, element: &Element) {
    for child in &element.children {
        let effect = match child.name.as_str() {
            "preserveFixedJoint" | "disableFixedJointLumping" => continue,
            "plugin" => Effect::Control,
            "sensor" => Effect::Sensing,
            _ => Effect::Motion,
        };
        reader.passed_over("gazebo", child, effect);
    }
}

fn for_link(reader: &mut Reader<'_, '_>, element: &Element, model: &mut Model, link: usize) {
    let mut friction = [None, None];
    for child in &element.children {
        let what = format!("gazebo/{}", child.name);
        match child.name.as_str() {
            "mu1" | "mu2" => {
                let side = usize::from(child.name == "mu2");
                // Older files give the number as an attribute.
                let text = child.get("value").unwrap_or(&child.text);
                let number = reader.exactly::<1>(&child.place, &what, text);
                friction[side] = number.map(|[mu]| (mu, child));
            }
            "turnGravityOff" => {
                let text = child.get("value").unwrap_or(&child.text);
                let off = reader.truth(&child.place, &what, text) == Some(true);
                model.links[link].gravity = !off;
            }
            "gravity" => {
                let on = reader.truth(&child.place, &what, &child.text) != Some(false);
                model.links[link].gravity = on;
            }
            "selfCollide" | "self_collide" => {
                let text = child.get("value").unwrap_or(&child.text);
                if reader.truth(&child.place, &what, text) == Some(true) {
                    model.links[link].contact_group = None;
                }
            }
            "sensor" => {
                let made = sensor::read(reader, child, model, Some(link), None);
                model.sensors.extend(made);
            }
            "plugin" => reader.passed_over("gazebo", child, Effect::Control),
            "material" | "visual" => reader.passed_over("gazebo", child, Effect::Looks),
            "provideFeedback" => reader.passed_over("gazebo", child, Effect::Sensing),
            _ => reader.passed_over("gazebo", child, Effect::Contact),
        }
    }
    if let Some((sliding, place)) = friction[0].or(friction[1]) {
        if let [Some((first, _)), Some((second, there))] = friction
            && first != second
        {
            let what = format!("mu2 = {second} differs from mu1 = {first}, which is used");
            let consequence = "friction is the same in every direction";
            reader.gap(
                &there.place,
                "gazebo/mu2",
                what,
                Effect::Contact,
                consequence,
            );
        }
        set_friction(reader, model, link, sliding, place);
    }
}

fn set_friction(
    reader: &mut Reader<'_, '_>,
    model: &mut Model,
    link: usize,
    sliding: f64,
    element: &Element,
) {
    if sliding < 0.0 {
        reader.problem(&element.place, "friction is negative", "give 0 or more");
        return;
    }
    let shapes = model.links[link].shapes.iter_mut();
    for shape in shapes.filter(|shape| shape.role == Role::Collision) {
        shape.friction = Some(Friction {
            sliding,
            torsional_m: None,
            rolling_m: None,
        });
    }
}
