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
