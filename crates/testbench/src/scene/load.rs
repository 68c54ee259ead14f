//! The descriptions that a scene names, read by `robot-model`.

use std::collections::BTreeMap;

use robot_model::{Loaded, Problems, own_package_path, package_paths};

use super::build::Models;
use super::data::SceneData;
use super::gaps::{SceneGap, description_gaps};
use crate::bench::ScenarioError;

/// A file with the values of its arguments.
pub(super) type Description = (String, robot_model::Arguments);

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
    let robots = data.robots.iter();
    let robots = robots.map(|robot| (robot.description(), robot.fixed));
    let objects = data.objects.iter();
    let objects = objects.filter_map(|object| Some((object.description()?, object.fixed)));
    let mut read: BTreeMap<Description, Loaded> = BTreeMap::new();
    let mut gaps = Vec::new();
    for (of, fixed) in robots.chain(objects) {
        let path = of.0.clone();
        if !read.contains_key(&of) {
            let loaded = description(&of, file)?;
            gaps.extend(description_gaps(&path, &loaded));
            read.insert(of.clone(), loaded);
        }
        let refusals = read.get(&of).map(|loaded| loaded.refusals(fixed));
        if let Some(refusals) = refusals.filter(|refusals| !refusals.is_empty()) {
            return Err(ScenarioError::Description {
                file: path,
                reason: Problems(refusals).to_string(),
            });
        }
    }
    let models = read.into_iter().map(|(of, loaded)| (of, loaded.model));
    Ok((models.collect(), gaps))
}

fn description(
    (path, arguments): &Description,
    file: &ReadFile<'_>,
) -> Result<Loaded, ScenarioError> {
    let path = path.as_str();
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
    robot_model::parse_with(path, &text, arguments, &mut resolve)
        .map_err(|problems| bad(problems.to_string()))
}
