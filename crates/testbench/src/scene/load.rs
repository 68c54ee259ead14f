//! The descriptions that a scene names, read by `robot-model`.

use super::build::Models;
use super::data::SceneData;
use super::gaps::{SceneGap, gaps_of};
use crate::bench::ScenarioError;

/// Reads the files of all robots and objects, each once.
///
/// # Errors
/// [`ScenarioError::Description`] with all that prevents loading.
pub(super) fn load(
    data: &SceneData,
    file: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<(Models, Vec<SceneGap>), ScenarioError> {
    let robots = data.robots.iter().map(|robot| &robot.file);
    let objects = data
        .objects
        .iter()
        .filter_map(|object| object.file.as_ref());
    let mut models = Models::new();
    let mut gaps = Vec::new();
    for path in robots.chain(objects) {
        if models.contains_key(path) {
            continue;
        }
        let bad = |reason: String| ScenarioError::Description {
            file: path.clone(),
            reason,
        };
        let bytes = file(path).map_err(bad)?;
        let text = String::from_utf8(bytes).map_err(|_| bad("it is no UTF-8 text".to_owned()))?;
        let mut resolve = |address: &str| file(address);
        let loaded = robot_model::parse(path, &text, &mut resolve)
            .map_err(|problems| bad(problems.to_string()))?;
        gaps.extend(gaps_of(path, &loaded));
        models.insert(path.clone(), loaded.model);
    }
    Ok((models, gaps))
}
