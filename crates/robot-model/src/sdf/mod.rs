//! SDF: `<sdf>` with a model or a world, nested models, includes, and frames that are given relative to others.
//!
//! Source: the specification of SDFormat 1.4 to 1.12 and its document on pose frame semantics (from 1.7 on; older files
//! use the same defaults, only axes of joints up to 1.4 are in the model's frame). Links of a model that is not static
//! and hangs on nothing are free: they get a joint `<link>_free`. A link without an inertial has SDF's default of 1 kg
//! and 1 kg m². Names of a file with one model are its own; in a world and in nested models they are `model::link`.
//!
//! Deviations: the tree needs one parent for each link. A joint whose child already has one is turned round if its
//! parent still hangs on nothing; otherwise it closes a loop and is left out, as a gap.

mod assemble;
mod frames;
mod geometry;
mod include;
mod joint;
pub(crate) mod pose;
mod scope;
pub(crate) mod sensor;

use crate::diagnostics::{Effect, Problems};
use crate::model::{Format, Model};
use crate::reader::{Loaded, Reader, Resolver};
use crate::xml::{self, Element};

use scope::Collected;

/// Reads an SDF text, known as `file`: one model, or a world. Everything that is not carried over is in
/// [`Loaded::gaps`].
///
/// # Errors
/// All problems that prevent loading, with their places.
pub fn parse_sdf(file: &str, text: &str, resolve: &mut Resolver<'_>) -> Result<Loaded, Problems> {
    let root = xml::read(file, text).map_err(|problem| Problems(vec![problem]))?;
    let mut reader = Reader::new(resolve);
    let model = document(&mut reader, root);
    reader.finish(model)
}

/// Reads the root element.
pub(crate) fn document(reader: &mut Reader<'_, '_>, mut root: Element) -> Option<Model> {
    if root.name != "sdf" && root.name != "gazebo" {
        let message = format!("an SDF starts with <sdf>, not with <{}>", root.name);
        reader.problem(
            &root.place,
            message,
            "name the file of the model or the world",
        );
        return None;
    }
    let version = include::version_of(reader, &root);
    include::expand(reader, &mut root, &version, 0);
    let worlds: Vec<&Element> = root.all("world").collect();
    let models: Vec<&Element> = root.all("model").collect();
    for child in &root.children {
        match child.name.as_str() {
            "world" | "model" => {}
            "light" => reader.passed_over("sdf", child, Effect::Looks),
            _ => reader.passed_over("sdf", child, Effect::Motion),
        }
    }
    let (first, rest) = match (&worlds[..], &models[..]) {
        ([world, rest @ ..], _) => (*world, rest),
        ([], [model, rest @ ..]) => (*model, rest),
        ([], []) => {
            let message = "the SDF holds neither a model nor a world";
            reader.problem(&root.place, message, "add a <model> or a <world>");
            return None;
        }
    };
    for other in rest {
        let name = format!("sdf/{}", other.name);
        let consequence = "only the first is loaded";
        reader.gap(&other.place, name, "ignored", Effect::Motion, consequence);
    }
    let mut model = Model::empty(first.get("name").unwrap_or(""), Format::Sdf);
    let mut collected = Collected::default();
    if first.name == "world" {
        scope::world(reader, first, &mut collected, &mut model);
    } else {
        scope::model(reader, first, None, false, &mut collected);
    }
    // The names of a file with one model are those that its author wrote.
    let prefix = (first.name == "model").then(|| format!("{}::", model.name));
    assemble::assemble(reader, collected, model, prefix.as_deref())
}
