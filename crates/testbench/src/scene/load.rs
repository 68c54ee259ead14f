//! The descriptions that a scene names, read by `robot-model`.

use std::collections::BTreeMap;

use robot_model::{Loaded, Problems, own_package_path, package_paths};

use super::build::Models;
use super::data::SceneData;
use super::gaps::{SceneGap, description_gaps};
use crate::bench::ScenarioError;

/// Gives the bytes of a file by its path relative to the scene's.
pub(super) type ReadFile<'a> = dyn Fn(&str) -> Result<Vec<u8>, String> + 'a;

/// Reads the files of all robots and objects, each once, and sees to it that what moves can be moved.
///
/// # Errors
/// [`ScenarioError::Description`] with all that prevents loading or simulating.
pub(super) fn load(
    data: &SceneData,
    file: &ReadFile<'_>,
) -> Result<(Models, Vec<SceneGap>), ScenarioError> {
    let robots = data.robots.iter().map(|robot| (&robot.file, robot.fixed));
    let objects = data.objects.iter();
    let objects = objects.filter_map(|object| Some((object.file.as_ref()?, object.fixed)));
    let mut read: BTreeMap<String, Loaded> = BTreeMap::new();
    let mut gaps = Vec::new();
    for (path, fixed) in robots.chain(objects) {
        if !read.contains_key(path) {
            let loaded = description(path, file)?;
            gaps.extend(description_gaps(path, &loaded));
            read.insert(path.clone(), loaded);
        }
        let refusals = read.get(path).map(|loaded| loaded.refusals(fixed));
        if let Some(refusals) = refusals.filter(|refusals| !refusals.is_empty()) {
            return Err(ScenarioError::Description {
                file: path.clone(),
                reason: Problems(refusals).to_string(),
            });
        }
    }
    let models = read.into_iter().map(|(path, loaded)| (path, loaded.model));
    Ok((models.collect(), gaps))
}

fn description(path: &str, file: &ReadFile<'_>) -> Result<Loaded, ScenarioError> {
    let bad = |reason: String| ScenarioError::Description {
        file: path.to_owned(),
        reason,
    };
    let bytes = file(path).map_err(bad)?;
    let text =
        String::from_utf8(bytes).map_err(|_| bad("the file is not UTF-8 text".to_owned()))?;
    let mut resolve = |address: &str| {
        let paths = package_paths(path, address);
        if paths.is_empty() {
            return file(address);
        }
        let mut text = |path: &str| String::from_utf8(file(path).ok()?).ok();
        let mut own = || own_package_path(path, address, &mut text);
        let found = paths.iter().find_map(|path| file(path).ok());
        let found = found.or_else(|| file(&own()?).ok());
        found.ok_or_else(|| "no such file in the folders around the description".to_owned())
    };
    robot_model::parse(path, &text, &mut resolve).map_err(|problems| bad(problems.to_string()))
}
