//! The message types that can be written: their fields in order, and the text of their schema.
//!
//! Names, types and order of the fields are those of the ROS 2 packages `builtin_interfaces`,
//! `std_msgs`, `geometry_msgs`, `sensor_msgs`, `nav_msgs`, `tf2_msgs`, `rosgraph_msgs` and `rcl_interfaces`, the same in
//! all distributions since Foxy.

use std::collections::BTreeSet;

/// Types and their fields, one `type name` each, in the order in which they are sent.
const DEFINITIONS: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec;uint32 nanosec"),
    (
        "std_msgs/Header",
        "builtin_interfaces/Time stamp;string frame_id",
    ),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/String", "string data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Int32", "int32 data"),
    (
        "std_msgs/MultiArrayDimension",
        "string label;uint32 size;uint32 stride",
    ),
    (
        "std_msgs/MultiArrayLayout",
        "std_msgs/MultiArrayDimension[] dim;uint32 data_offset",
    ),
    (
        "std_msgs/Float64MultiArray",
        "std_msgs/MultiArrayLayout layout;float64[] data",
    ),
    ("geometry_msgs/Vector3", "float64 x;float64 y;float64 z"),
    ("geometry_msgs/Point", "float64 x;float64 y;float64 z"),
    (
        "geometry_msgs/Quaternion",
        "float64 x;float64 y;float64 z;float64 w",
    ),
    (
        "geometry_msgs/Pose",
        "geometry_msgs/Point position;geometry_msgs/Quaternion orientation",
    ),
    (
        "geometry_msgs/Twist",
        "geometry_msgs/Vector3 linear;geometry_msgs/Vector3 angular",
    ),
    (
        "geometry_msgs/Wrench",
        "geometry_msgs/Vector3 force;geometry_msgs/Vector3 torque",
    ),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation;geometry_msgs/Quaternion rotation",
    ),
    (
        "geometry_msgs/PointStamped",
        "std_msgs/Header header;geometry_msgs/Point point",
    ),
    (
        "geometry_msgs/PoseStamped",
        "std_msgs/Header header;geometry_msgs/Pose pose",
    ),
    (
        "geometry_msgs/TwistStamped",
        "std_msgs/Header header;geometry_msgs/Twist twist",
    ),
    (
        "geometry_msgs/WrenchStamped",
        "std_msgs/Header header;geometry_msgs/Wrench wrench",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header;string child_frame_id;geometry_msgs/Transform transform",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header;string[] name;float64[] position;float64[] velocity;float64[] effort",
    ),
    (
        "sensor_msgs/LaserScan",
        "std_msgs/Header header;float32 angle_min;float32 angle_max;float32 angle_increment;\
         float32 time_increment;float32 scan_time;float32 range_min;float32 range_max;\
         float32[] ranges;float32[] intensities",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header;geometry_msgs/Quaternion orientation;\
         float64[9] orientation_covariance;geometry_msgs/Vector3 angular_velocity;\
         float64[9] angular_velocity_covariance;geometry_msgs/Vector3 linear_acceleration;\
         float64[9] linear_acceleration_covariance",
    ),
    (
        "geometry_msgs/PoseWithCovariance",
        "geometry_msgs/Pose pose;float64[36] covariance",
    ),
    (
        "geometry_msgs/TwistWithCovariance",
        "geometry_msgs/Twist twist;float64[36] covariance",
    ),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header;string child_frame_id;\
         geometry_msgs/PoseWithCovariance pose;geometry_msgs/TwistWithCovariance twist",
    ),
    (
        "tf2_msgs/TFMessage",
        "geometry_msgs/TransformStamped[] transforms",
    ),
    ("rosgraph_msgs/Clock", "builtin_interfaces/Time clock"),
    (
        "rcl_interfaces/Log",
        "builtin_interfaces/Time stamp;uint8 level;string name;string msg;string file;\
         string function;uint32 line",
    ),
];

/// A type of one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Primitive {
    Bool,
    Uint8,
    Int32,
    Uint32,
    Float32,
    Float64,
    Text,
}

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FieldType {
    Primitive(Primitive),
    Message(&'static str),
}

/// One field of a message type.
#[derive(Debug, Clone, Copy)]
pub(super) struct FieldDefinition {
    pub name: &'static str,
    pub field_type: FieldType,
    /// How many of them there are.
    pub count: Count,
}

/// How many values a field holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Count {
    One,
    /// A sequence of any length.
    Any,
    /// An array of this length.
    Exactly(usize),
}

/// The full names of the types that can be written, as `sensor_msgs/msg/JointState`.
pub fn ros2_type_names() -> impl Iterator<Item = String> {
    DEFINITIONS
        .iter()
        .filter_map(|(name, _)| name.split_once('/'))
        .map(|(package, name)| format!("{package}/msg/{name}"))
}

/// The short name of a type, `sensor_msgs/JointState`, if it can be written.
pub(super) fn short_name(full_name: &str) -> Option<&'static str> {
    let short = full_name.replacen("/msg/", "/", 1);
    DEFINITIONS
        .iter()
        .find(|(name, _)| *name == short)
        .map(|(name, _)| *name)
}

/// The fields of a type in their order; empty if there is no such type.
pub(super) fn fields_of(short_name: &str) -> Vec<FieldDefinition> {
    let found = DEFINITIONS.iter().find(|(name, _)| *name == short_name);
    let lines = found.map_or("", |(_, lines)| lines);
    lines.split(';').filter_map(field_of_line).collect()
}

fn field_of_line(line: &'static str) -> Option<FieldDefinition> {
    let (type_text, name) = line.split_once(' ')?;
    let (type_name, count) = match type_text.split_once('[') {
        Some((element, "]")) => (element, Count::Any),
        Some((element, length)) => {
            let length = length.strip_suffix(']')?.parse().ok()?;
            (element, Count::Exactly(length))
        }
        None => (type_text, Count::One),
    };
    let field_type = match type_name {
        "bool" => FieldType::Primitive(Primitive::Bool),
        "uint8" => FieldType::Primitive(Primitive::Uint8),
        "int32" => FieldType::Primitive(Primitive::Int32),
        "uint32" => FieldType::Primitive(Primitive::Uint32),
        "float32" => FieldType::Primitive(Primitive::Float32),
        "float64" => FieldType::Primitive(Primitive::Float64),
        "string" => FieldType::Primitive(Primitive::Text),
        message => FieldType::Message(message),
    };
    Some(FieldDefinition {
        name,
        field_type,
        count,
    })
}

/// The schema of a type: its fields, then those of every type that it uses, each under a line of
/// equal signs and its name.
pub(super) fn schema_text(short_name: &'static str) -> String {
    let mut text = lines_of(short_name);
    let (mut done, mut waiting) = (BTreeSet::from([short_name]), used_by(short_name));
    while !waiting.is_empty() {
        let next = waiting.remove(0);
        if done.insert(next) {
            text.push_str(&"=".repeat(80));
            text.push_str(&format!("\nMSG: {next}\n"));
            text.push_str(&lines_of(next));
            waiting.extend(used_by(next));
        }
    }
    text
}

fn lines_of(short_name: &str) -> String {
    let found = DEFINITIONS.iter().find(|(name, _)| *name == short_name);
    let lines = found.map_or("", |(_, lines)| lines).split(';');
    lines.map(|line| format!("{line}\n")).collect()
}

fn used_by(short_name: &str) -> Vec<&'static str> {
    let fields = fields_of(short_name).into_iter();
    let used = fields.filter_map(|field| match field.field_type {
        FieldType::Message(name) => Some(name),
        FieldType::Primitive(_) => None,
    });
    used.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_that_is_used_is_defined() {
        for (name, _) in DEFINITIONS {
            assert!(!fields_of(name).is_empty(), "{name}");
            for used in used_by(name) {
                assert_eq!(short_name(used), Some(used), "{name}");
            }
        }
        assert_eq!(ros2_type_names().count(), DEFINITIONS.len());
        assert_eq!(
            short_name("tf2_msgs/msg/TFMessage"),
            Some("tf2_msgs/TFMessage")
        );
        assert_eq!(short_name("tf2_msgs/msg/Nothing"), None);
    }

    #[test]
    fn a_schema_holds_each_used_type_once() {
        let text = schema_text("tf2_msgs/TFMessage");
        assert!(text.starts_with("geometry_msgs/TransformStamped[] transforms\n====="));
        for used in [
            "geometry_msgs/Vector3",
            "std_msgs/Header",
            "builtin_interfaces/Time",
        ] {
            assert_eq!(text.matches(&format!("MSG: {used}\n")).count(), 1, "{text}");
        }
    }
}
