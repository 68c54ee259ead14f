//! Worlds and models: what they hold, under which full names, in which frames.

use super::frames::{Frame, Frames};
use super::include::{VERSION, below};
use super::pose;
use crate::diagnostics::{Effect, Place};
use crate::model::Model;
use crate::pose::Pose;
use crate::reader::Reader;
use crate::xml::Element;

/// A link with what its model says about it.
pub(super) struct FoundLink<'e> {
    pub name: String,
    pub element: &'e Element,
    /// Full name of its model.
    pub scope: String,
    pub is_static: bool,
    /// Group of links that do not touch each other.
    pub group: Option<String>,
}

/// A joint with its model.
pub(super) struct FoundJoint<'e> {
    pub name: String,
    pub element: &'e Element,
    pub scope: String,
    pub is_static: bool,
    pub version: String,
}

/// Everything in a document, before it is a tree.
#[derive(Default)]
pub(super) struct Collected<'e> {
    pub frames: Frames,
    pub links: Vec<FoundLink<'e>>,
    pub joints: Vec<FoundJoint<'e>>,
    /// Full names of explicit frames.
    pub marks: Vec<(String, Place)>,
}

/// The full name of something in a scope.
pub(super) fn within(scope: &str, name: &str) -> String {
    let name = name.strip_suffix("::__model__").unwrap_or(name);
    match (scope, name) {
        (scope, "__model__") => scope.to_owned(),
        (_, "world" | "__root__") => String::new(),
        ("", name) => name.to_owned(),
        (scope, name) => format!("{scope}::{name}"),
    }
}

/// The pose of an element and the full name of the frame it is relative to.
pub(super) fn placed(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    scope: &str,
    default: &str,
) -> (String, Pose) {
    let Some(child) = element.child("pose") else {
        return (default.to_owned(), Pose::IDENTITY);
    };
    if let Some(frame) = child.attribute("frame").filter(|old| !old.value.is_empty()) {
        let what = "the attribute of SDF 1.6 and before is ignored";
        let consequence = "the pose is relative to the default frame; use relative_to";
        reader.gap(
            &frame.place,
            "pose@frame",
            what,
            Effect::Motion,
            consequence,
        );
    }
    let relative = child.get("relative_to").filter(|name| !name.is_empty());
    let parent = relative.map_or_else(|| default.to_owned(), |name| within(scope, name));
    (parent, pose::plain(reader, child))
}

/// Adds the frame of an element.
fn add_frame(
    reader: &mut Reader<'_, '_>,
    collected: &mut Collected<'_>,
    element: &Element,
    scope: &str,
    default: &str,
    attached: &str,
) -> String {
    let name = reader.required(element, "name").to_owned();
    add_named(reader, collected, element, &name, scope, default, attached)
}

/// Adds the frame of an element under a name.
fn add_named(
    reader: &mut Reader<'_, '_>,
    collected: &mut Collected<'_>,
    element: &Element,
    name: &str,
    scope: &str,
    default: &str,
    attached: &str,
) -> String {
    if matches!(name, "world" | "__model__" | "__root__") {
        reader.problem(
            &element.place,
            format!("the name {name} is reserved"),
            "choose another",
        );
    }
    let full = within(scope, name);
    let (parent, pose) = placed(reader, element, scope, default);
    let frame = Frame {
        parent,
        pose,
        placement: None,
        attached: attached.to_owned(),
        place: element.place.clone(),
    };
    collected.frames.add(reader, &full, frame);
    full
}

/// Reads a world.
pub(super) fn world<'e>(
    reader: &mut Reader<'_, '_>,
    element: &'e Element,
    collected: &mut Collected<'e>,
    into: &mut Model,
) {
    for child in &element.children {
        match child.name.as_str() {
            "model" => model(reader, child, Some(""), false, collected),
            "frame" => frame(reader, child, "", collected),
            "joint" => joint(reader, child, "", false, element, collected),
            "gravity" => {
                into.gravity_m_s2 = reader.exactly(&child.place, "world/gravity", &child.text);
            }
            "physics" => physics(reader, child, into),
            "plugin" => reader.passed_over("world", child, Effect::Control),
            "light" | "scene" | "gui" | "road" => reader.passed_over("world", child, Effect::Looks),
            "audio" => reader.passed_over("world", child, Effect::Nothing),
            "magnetic_field" | "spherical_coordinates" => {
                reader.passed_over("world", child, Effect::Sensing);
            }
            _ => reader.passed_over("world", child, Effect::Motion),
        }
    }
}

fn physics(reader: &mut Reader<'_, '_>, element: &Element, into: &mut Model) {
    for child in &element.children {
        match child.name.as_str() {
            "max_step_size" => {
                let step = reader.child_number(element, "max_step_size");
                let step =
                    step.and_then(|step| reader.positive(&child.place, "max_step_size", step));
                into.time_step_secs = step;
            }
            "real_time_factor" | "real_time_update_rate" => {}
            "gravity" if into.gravity_m_s2.is_none() => {
                into.gravity_m_s2 = reader.exactly(&child.place, "physics/gravity", &child.text);
            }
            _ => reader.passed_over("physics", child, Effect::Contact),
        }
    }
}

/// Reads a model: into the scope of another (`""`: the world's), or alone (`None`).
pub(super) fn model<'e>(
    reader: &mut Reader<'_, '_>,
    element: &'e Element,
    outer: Option<&str>,
    outer_is_static: bool,
    collected: &mut Collected<'e>,
) {
    let known = ["name", "canonical_link", "placement_frame", VERSION];
    reader.known_attributes(element, &known);
    let scope_above = outer.unwrap_or("");
    let name = reader.required(element, "name");
    let full = within(scope_above, name);
    let (parent, pose) = placed(reader, element, scope_above, scope_above);
    let placement = element
        .get("placement_frame")
        .filter(|name| !name.is_empty());
    collected.frames.add(
        reader,
        &full,
        Frame {
            parent,
            pose,
            placement: placement.map(|frame| within(&full, frame)),
            attached: canonical_link(element, &full),
            place: element.place.clone(),
        },
    );
    let mut flag = |name: &str| {
        let child = element.child(name)?;
        reader.truth(&child.place, name, &child.text)
    };
    let is_static = outer_is_static || flag("static") == Some(true);
    let touches_itself = flag("self_collide") == Some(true);
    // Links of nested models belong to the outermost model's body.
    let top = full.split("::").next().unwrap_or(&full).to_owned();
    for child in &element.children {
        match child.name.as_str() {
            "link" => {
                let name = add_frame(reader, collected, child, &full, &full, "");
                collected.links.push(FoundLink {
                    name,
                    element: child,
                    scope: full.clone(),
                    is_static,
                    group: (!touches_itself).then(|| top.clone()),
                });
            }
            "joint" => joint(reader, child, &full, is_static, element, collected),
            "frame" => frame(reader, child, &full, collected),
            "model" => model(reader, child, Some(&full), is_static, collected),
            "pose" | "static" | "self_collide" | "allow_auto_disable" => {}
            "enable_wind" if child.text.trim() != "true" => {}
            "plugin" => reader.passed_over("model", child, Effect::Control),
            _ => reader.passed_over("model", child, Effect::Motion),
        }
    }
}

/// The full name of the link that a model's frame moves with: the named one, or the first, also of nested models.
fn canonical_link(element: &Element, full: &str) -> String {
    if let Some(named) = element
        .get("canonical_link")
        .filter(|name| !name.is_empty())
    {
        return within(full, named);
    }
    let own = element.child("link").and_then(|link| link.get("name"));
    let nested = element.child("model").and_then(|model| model.get("name"));
    own.or(nested)
        .map_or_else(String::new, |name| within(full, name))
}

/// The name of a joint. Before SDF 1.7 a joint and a link could have the same one; then the joint is called `NAME_joint`,
/// as the reference implementation calls it.
fn joint_name(reader: &mut Reader<'_, '_>, element: &Element, model: &Element) -> String {
    let name = reader.required(element, "name").to_owned();
    let is_old = below(model.get(VERSION).unwrap_or("1.6"), 7);
    let mut links = model.all("link");
    if !is_old || name.is_empty() || !links.any(|link| link.get("name") == Some(name.as_str())) {
        return name;
    }
    let renamed = format!("{name}_joint");
    let what = format!("{name} is also the name of a link, so it is called {renamed}");
    let consequence = "nothing moves otherwise; drives and sensors name the joint by it";
    reader.gap(
        &element.place,
        "joint@name",
        what,
        Effect::Nothing,
        consequence,
    );
    renamed
}

fn joint<'e>(
    reader: &mut Reader<'_, '_>,
    element: &'e Element,
    scope: &str,
    is_static: bool,
    model: &Element,
    collected: &mut Collected<'e>,
) {
    let child = element.text_of("child").unwrap_or("");
    let child = within(scope, child);
    let name = joint_name(reader, element, model);
    let name = add_named(reader, collected, element, &name, scope, &child, &child);
    collected.joints.push(FoundJoint {
        name,
        element,
        scope: scope.to_owned(),
        is_static,
        version: model.get(VERSION).unwrap_or("1.6").to_owned(),
    });
}

fn frame(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    scope: &str,
    collected: &mut Collected<'_>,
) {
    reader.known_attributes(element, &["name", "attached_to"]);
    let attached = element.get("attached_to").filter(|name| !name.is_empty());
    let attached = attached.map_or_else(|| scope.to_owned(), |name| within(scope, name));
    let name = add_frame(reader, collected, element, scope, &attached, &attached);
    collected.marks.push((name, element.place.clone()));
}
