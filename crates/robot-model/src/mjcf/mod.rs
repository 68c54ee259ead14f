//! MJCF: MuJoCo's own language, with classes of defaults, includes, frames and every way to say an orientation.
//!
//! Source: the XML reference of MuJoCo 3.17. Bodies without an inertial get the sum of their geoms, as `inertiafromgeom`
//! says. Unnamed bodies and joints are called `body_N` and `joint_N` by their place in the text. What the tree does not
//! hold (tendons, connect and weld constraints, muscles, flexible bodies, replicas, height fields, solver settings) is a
//! gap; a scene that needs it should be given to MuJoCo as it is.

mod assets;
mod bodies;
mod compiler;
mod defaults;
mod drives;
mod geoms;
mod include;
mod joints;

use std::collections::BTreeMap;

use crate::diagnostics::{Effect, Problems};
use crate::model::{Format, Model};
use crate::reader::{Loaded, Reader, Resolver};
use crate::xml::{self, Element};

use compiler::Compiler;
use defaults::Defaults;

/// Reads an MJCF text, known as `file`. Everything that is not carried over is in [`Loaded::gaps`].
///
/// # Errors
/// All problems that prevent loading, with their places.
pub fn parse_mjcf(file: &str, text: &str, resolve: &mut Resolver<'_>) -> Result<Loaded, Problems> {
    let root = xml::read(file, text).map_err(|problem| Problems(vec![problem]))?;
    let mut reader = Reader::new(resolve);
    let model = document(&mut reader, root);
    reader.finish(model)
}

/// What the parts of a reading share.
struct Context<'a, 'r, 's> {
    reader: &'a mut Reader<'r, 's>,
    compiler: Compiler,
    defaults: Defaults,
    /// Meshes by name: index, or `None` after a gap.
    meshes: BTreeMap<String, Option<usize>>,
    /// The file that paths are relative to.
    main: std::sync::Arc<str>,
    /// Gaps that were reported, so that a class with many members reports once.
    reported: std::collections::BTreeSet<(crate::Place, String)>,
}

/// Reads the root element.
pub(crate) fn document(reader: &mut Reader<'_, '_>, mut root: Element) -> Option<Model> {
    if root.name != "mujoco" {
        let message = format!("an MJCF starts with <mujoco>, not with <{}>", root.name);
        reader.problem(&root.place, message, "name the file of the model");
        return None;
    }
    let main = std::sync::Arc::clone(&root.place.file);
    include::expand(reader, &mut root, &main, 0);
    reader.known_attributes(&root, &["model"]);
    let mut model = Model::empty(root.get("model").unwrap_or("mujoco"), Format::Mjcf);
    let compiler = Compiler::read(reader, &root);
    let defaults = Defaults::read(reader, &root);
    let mut context = Context {
        reader,
        compiler,
        defaults,
        meshes: BTreeMap::new(),
        main,
        reported: std::collections::BTreeSet::new(),
    };
    for option in root.all("option") {
        context.option(option, &mut model);
    }
    for asset in root.all("asset") {
        context.assets(asset);
    }
    let mut places = vec![];
    for body in root.all("worldbody") {
        context.world(body, &mut model, &mut places);
    }
    // A joint may stand behind the bodies inside its own; positions are listed by link.
    model.joints.sort_by_key(|joint| joint.link);
    for child in &root.children {
        match child.name.as_str() {
            "contact" => context.contact(child, &mut model),
            "equality" => context.equality(child, &mut model),
            "actuator" => context.actuators(child, &mut model),
            "sensor" => context.sensors(child, &mut model),
            "option" | "asset" | "worldbody" | "compiler" | "default" => {}
            "visual" | "statistic" => context.reader.passed_over("mujoco", child, Effect::Looks),
            "size" | "custom" | "extension" => {
                context.reader.passed_over("mujoco", child, Effect::Nothing);
            }
            _ => context.reader.passed_over("mujoco", child, Effect::Motion),
        }
    }
    context.compiler.set_total_mass(&mut model);
    context.reader.link_places = places;
    Some(model)
}

impl Context<'_, '_, '_> {
    fn option(&mut self, element: &Element, model: &mut Model) {
        if let Some(step) = self.reader.number(element, "timestep") {
            model.time_step_secs = self
                .reader
                .positive(&element.place, "option@timestep", step);
        }
        if let Some(gravity) = self.reader.attribute::<3>(element, "gravity") {
            model.gravity_m_s2 = Some(gravity);
        }
        self.ignored(element, &["timestep", "gravity"], Effect::Motion);
        for child in &element.children {
            self.reader.passed_over("option", child, Effect::Motion);
        }
    }

    /// Notes the attributes that are not among the known ones, each place once.
    fn ignored(&mut self, element: &Element, known: &[&str], effect: Effect) {
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            if known.contains(&name) || matches!(name, "name" | "class" | "user" | "group") {
                continue;
            }
            let path = format!("{}@{name}", element.name);
            if self
                .reported
                .insert((attribute.place.clone(), path.clone()))
            {
                let what = format!(
                    "ignored (\"{}\")",
                    crate::reader::shortened(&attribute.value)
                );
                let consequence = "MuJoCo's default is used instead";
                self.reader
                    .gap(&attribute.place, path, what, effect, consequence);
            }
        }
    }
}
