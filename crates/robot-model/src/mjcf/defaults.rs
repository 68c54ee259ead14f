//! `<default>`: classes of attributes that elements start from, each class from its parent's.

use std::collections::BTreeMap;

use crate::diagnostics::Effect;
use crate::reader::Reader;
use crate::xml::{Attribute, Element};

/// The class that holds for everything.
const MAIN: &str = "main";

/// Elements of drives share one set of defaults.
const DRIVES: [&str; 10] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "plugin",
];

/// Ways to say an orientation: one given by an element replaces those of its class.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

type Class = BTreeMap<String, BTreeMap<String, Attribute>>;

/// All classes, each with what it inherits.
pub(super) struct Defaults {
    classes: BTreeMap<String, Class>,
}

/// The name under which an element's defaults are kept.
fn kind(element: &str) -> &str {
    match element {
        drive if DRIVES.contains(&drive) => "drive",
        other => other,
    }
}

impl Defaults {
    /// Reads all `<default>` elements.
    pub fn read(reader: &mut Reader<'_, '_>, root: &Element) -> Self {
        let mut result = Self {
            classes: BTreeMap::from([(MAIN.to_owned(), Class::new())]),
        };
        for element in root.all("default") {
            let name = element.get("class").unwrap_or(MAIN);
            result.class(reader, element, name, MAIN);
        }
        result
    }

    fn class(&mut self, reader: &mut Reader<'_, '_>, element: &Element, name: &str, parent: &str) {
        let from = if self.classes.contains_key(name) {
            name
        } else {
            parent
        };
        let mut class = self.classes.get(from).cloned().unwrap_or_default();
        for child in element
            .children
            .iter()
            .filter(|child| child.name != "default")
        {
            match child.name.as_str() {
                "joint" | "geom" | "site" | "mesh" | "equality" => {}
                drive if DRIVES.contains(&drive) => {}
                "material" | "camera" | "light" => continue,
                _ => {
                    reader.passed_over("default", child, Effect::Motion);
                    continue;
                }
            }
            let attributes = class.entry(kind(&child.name).to_owned()).or_default();
            if child
                .attributes
                .iter()
                .any(|a| ORIENTATIONS.contains(&a.name.as_str()))
            {
                attributes.retain(|name, _| !ORIENTATIONS.contains(&name.as_str()));
            }
            for attribute in &child.attributes {
                attributes.insert(attribute.name.clone(), attribute.clone());
            }
        }
        self.classes.insert(name.to_owned(), class);
        for child in element.all("default") {
            let below = reader.required(child, "class");
            if !below.is_empty() {
                self.class(reader, child, below, name);
            }
        }
    }

    /// An element with the attributes that it has from its class, from `inherited` (`childclass`), or from all.
    pub fn applied(
        &self,
        reader: &mut Reader<'_, '_>,
        element: &Element,
        inherited: Option<&str>,
    ) -> Element {
        let name = element.get("class").or(inherited).unwrap_or(MAIN);
        let Some(class) = self.classes.get(name) else {
            let message = format!("there is no class {name}");
            reader.problem(
                &element.place,
                message,
                "add <default class=...>, or correct the name",
            );
            return element.clone();
        };
        let mut result = element.clone();
        let oriented = element
            .attributes
            .iter()
            .any(|attribute| ORIENTATIONS.contains(&attribute.name.as_str()));
        for (name, attribute) in class.get(kind(&element.name)).into_iter().flatten() {
            let hidden = oriented && ORIENTATIONS.contains(&name.as_str());
            if !hidden && element.attribute(name).is_none() {
                result.attributes.push(attribute.clone());
            }
        }
        result
    }
}
