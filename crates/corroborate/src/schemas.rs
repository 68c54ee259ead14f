//! JSON Schemas of the files that a study consists of, made from the types that parse them.
//!
//! Editors complete and check the files by them, and the reference of the documentation is made of them.

use crate::calibrate::CalibrationText;
use crate::rare::RareText;
use crate::technique::exploration::Plan;
use crate::what_if::file::Variant;
use rig::Join;
use schemars::{Schema, schema_for};
use serde_json::Value;

/// A kind of file that a study may have.
pub struct FileOfStudy {
    /// Its name, or that of its kind where a study may have several under names of its own.
    pub name: &'static str,
    /// What it says.
    pub says: &'static str,
    /// Its keys.
    pub schema: Schema,
}

impl FileOfStudy {
    /// The schema's file beside a study's files.
    pub fn schema_name(&self) -> String {
        self.name.replace(".toml", ".schema.json")
    }
}

/// What each kind of file says, in the order in which a study is written.
const SAYS: [(&str, &str); 16] = [
    (
        "study.toml",
        "title, levels of confidence, conditions, seed, costs and weights",
    ),
    (
        "parameters.toml",
        "each distance, speed and time once, with its unit",
    ),
    (
        "vocabulary.toml",
        "each proposition, bound to the formal model, to signals and to columns",
    ),
    (
        "requirements.toml",
        "what is required, and the ways to fail",
    ),
    (
        "ledger.toml",
        "the evidence, oldest first: technique, assets, lineage",
    ),
    (
        "topics.toml",
        "where recordings have the signals, with units, frames and clock",
    ),
    (
        "scene.toml",
        "a simulated scene: robots, objects, people, sensors, controllers, tests",
    ),
    (
        "scenario.toml",
        "the handover's scenario: robot, object, person, sensors, tests (`scenario` of an entry of the ledger)",
    ),
    (
        "scenario-parameters.toml",
        "what tuning changes in the handover (`parameters` of an entry of the ledger)",
    ),
    (
        "ros2.toml",
        "which signals `simulate --as` writes into which messages of ROS 2",
    ),
    (
        "exploration.toml",
        "what `explore` may vary, and where its tests come from",
    ),
    ("calibration.toml", "what `calibrate` fits to which counts"),
    ("rare.toml", "the events whose probability `rare` estimates"),
    (
        "variant.toml",
        "a change of the assets that `what-if` tries (in `variants/`)",
    ),
    (
        "finding.toml",
        "an episode that shows something (in `regressions/`); `explore` and `shrink` write it",
    ),
    (
        "looks.toml",
        "the counts by which the study was judged so far; `run` writes it",
    ),
];

/// All kinds of file, in that order.
pub fn files() -> Vec<FileOfStudy> {
    let mut schemas = all();
    schemas.push(("ros2.toml", crate::ros2_table::schema()));
    let with_words = SAYS.iter().filter_map(|(name, says)| {
        let place = schemas.iter().position(|(file, _)| file == name)?;
        let (_, schema) = schemas.swap_remove(place);
        Some(FileOfStudy { name, says, schema })
    });
    with_words.collect()
}

/// The files, each with its schema. Where a study may have several of a kind under names of its own, the name is that of the
/// kind.
pub fn all() -> Vec<(&'static str, Schema)> {
    let mut all = study::schemas::all();
    all.extend([
        ("topics.toml", recording::TopicMap::schema()),
        ("scene.toml", scene()),
        ("scenario.toml", schema_for!(handover::scenario::Scenario)),
        (
            "scenario-parameters.toml",
            schema_for!(handover::scenario::Parameters),
        ),
        ("exploration.toml", Plan::schema()),
        ("calibration.toml", schema_for!(CalibrationText)),
        ("rare.toml", schema_for!(RareText)),
        ("variant.toml", schema_for!(Variant)),
    ]);
    all
}

/// A scene with the table by which a controller is joined over ROS 2, which the test bench does not read.
fn scene() -> Schema {
    let mut scene = testbench::scene::SceneData::schema();
    let mut join = schema_for!(Join).to_value();
    let parts = join.as_object_mut().and_then(|it| it.remove("$defs"));
    if let Some(object) = join.as_object_mut() {
        object.remove("$schema");
        object.remove("title");
    }
    let Some(definitions) = scene.get_mut("$defs").and_then(Value::as_object_mut) else {
        return scene;
    };
    if let Some(Value::Object(parts)) = parts {
        definitions.extend(parts);
    }
    definitions.insert("Ros2".into(), join);
    if let Some(ros2) = definitions
        .get_mut("ControllerData")
        .and_then(|controller| controller.pointer_mut("/properties/ros2"))
    {
        let description = ros2.get("description").cloned();
        *ros2 = serde_json::json!({ "$ref": "#/$defs/Ros2", "description": description });
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_has_its_schema_and_its_words() {
        assert_eq!(files().len(), SAYS.len());
        assert_eq!(files().len(), all().len() + 1);
    }

    #[test]
    fn the_scene_has_the_keys_of_ros_2_and_distributions_where_numbers_are_drawn() {
        let scene = scene().to_value();
        let at = |path: &str| {
            scene
                .pointer(path)
                .unwrap_or_else(|| panic!("{path} in {scene}"))
        };
        assert!(at("/$defs/Ros2/properties/domains").is_object());
        assert_eq!(
            at("/$defs/Simulation/properties/gravity_m_s2/$ref"),
            "#/$defs/Distribution"
        );
        assert_eq!(
            at("/$defs/Object/properties/box_m/items/$ref"),
            "#/$defs/Distribution"
        );
        assert_eq!(
            at("/$defs/Simulation/properties/time_step_secs/type"),
            "number"
        );
    }
}
