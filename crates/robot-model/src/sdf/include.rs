//! `<include>`: replaced by the model it names, with its name, pose and other settings put over it.

use crate::diagnostics::Effect;
use crate::reader::{Reader, joined};
use crate::xml::{Attribute, Element};

/// Includes inside includes.
const MAX_DEPTH: usize = 16;

/// Attribute in which a model keeps the version of its file; no XML name can be like it.
pub(super) const VERSION: &str = "\u{1}version";

/// The version of a root element; 1.6 if it has none.
pub(super) fn version_of(reader: &mut Reader<'_, '_>, root: &Element) -> String {
    if let Some(version) = root.get("version") {
        return version.to_owned();
    }
    let remedy = "add version=\"1.9\"; it is read as 1.6";
    reader.warn(&root.place, "sdf has no version", remedy);
    "1.6".to_owned()
}

/// Whether a version is below `1.minor`.
pub(super) fn below(version: &str, minor: u32) -> bool {
    let mut parts = version.split('.');
    let major: u32 = parts.next().and_then(|part| part.parse().ok()).unwrap_or(1);
    let own: u32 = parts.next().and_then(|part| part.parse().ok()).unwrap_or(6);
    major < 1 || (major == 1 && own < minor)
}

/// Replaces all includes below an element, and marks models with the version they were written in.
pub(super) fn expand(
    reader: &mut Reader<'_, '_>,
    element: &mut Element,
    version: &str,
    depth: usize,
) {
    let children = std::mem::take(&mut element.children);
    for mut child in children {
        match child.name.as_str() {
            "include" => {
                if let Some(model) = included(reader, &child, depth) {
                    element.children.push(model);
                }
            }
            "model" | "world" => {
                child.attributes.push(Attribute {
                    name: VERSION.to_owned(),
                    value: version.to_owned(),
                    place: child.place.clone(),
                });
                expand(reader, &mut child, version, depth);
                element.children.push(child);
            }
            _ => element.children.push(child),
        }
    }
}

fn included(reader: &mut Reader<'_, '_>, include: &Element, depth: usize) -> Option<Element> {
    let Some(uri) = include.text_of("uri").filter(|uri| !uri.is_empty()) else {
        reader.problem(
            &include.place,
            "an include has no uri",
            "add <uri>model://...</uri>",
        );
        return None;
    };
    if depth >= MAX_DEPTH {
        let message = format!("includes are nested more than {MAX_DEPTH} deep");
        reader.problem(
            &include.place,
            message,
            "remove the include that names itself",
        );
        return None;
    }
    let address = address(include, uri);
    let mut root = reader.optional_document(include, &address)?;
    if root.name != "sdf" {
        let what = format!("{address} is <{}>, no SDF", root.name);
        let consequence = "the model is missing; convert it with \"gz sdf -p\"";
        reader.gap(&include.place, "include", what, Effect::Motion, consequence);
        return None;
    }
    let version = version_of(reader, &root);
    expand(reader, &mut root, &version, depth + 1);
    for child in root.children.iter().filter(|child| child.name != "model") {
        reader.passed_over("include", child, Effect::Motion);
    }
    let Some(model) = root
        .children
        .into_iter()
        .find(|child| child.name == "model")
    else {
        reader.problem(
            &include.place,
            format!("{address} holds no model"),
            "correct the uri",
        );
        return None;
    };
    Some(overridden(reader, model, include))
}

/// The file that a `uri` means: a folder holds `model.sdf`.
fn address(include: &Element, uri: &str) -> String {
    let full = joined(&include.place.file, uri);
    let ending = full.rsplit('/').next().unwrap_or("");
    let is_file = [".sdf", ".urdf", ".xml", ".world"]
        .iter()
        .any(|known| ending.ends_with(known));
    if is_file {
        full
    } else {
        format!("{}/model.sdf", full.trim_end_matches('/'))
    }
}

/// The model with what the include says about it.
fn overridden(reader: &mut Reader<'_, '_>, mut model: Element, include: &Element) -> Element {
    if let Some(merge) = include.attribute("merge")
        && reader.truth(&merge.place, "include@merge", &merge.value) == Some(true)
    {
        let what = "the model is nested instead of merged";
        let consequence = "its names carry its own name in front; motion is the same";
        reader.gap(
            &merge.place,
            "include@merge",
            what,
            Effect::Nothing,
            consequence,
        );
    }
    for child in &include.children {
        match child.name.as_str() {
            "name" => set_attribute(&mut model, "name", child),
            "placement_frame" => set_attribute(&mut model, "placement_frame", child),
            "pose" | "static" => {
                model.children.retain(|known| known.name != child.name);
                model.children.push(child.clone());
            }
            "uri" => {}
            "plugin" => reader.passed_over("include", child, Effect::Control),
            _ => reader.passed_over("include", child, Effect::Motion),
        }
    }
    model
}

fn set_attribute(model: &mut Element, name: &str, source: &Element) {
    model.attributes.retain(|attribute| attribute.name != name);
    model.attributes.push(Attribute {
        name: name.to_owned(),
        value: source.text.clone(),
        place: source.place.clone(),
    });
}
