//! Units that follow from the definitions of ROS's own message types (REP 103, "Standard Units of
//! Measure and Coordinate Conventions", and the comments of the types).
//!
//! Only what a type fixes is here. The fields of `sensor_msgs/JointState` are not: a joint may turn
//! (rad) or slide (m).

use crate::reader::TopicInfo;
use crate::schema::{MessageType, Schema, Type};

/// Type, field, and the unit of everything below it.
const UNITS: &[(&str, &str, &str)] = &[
    ("geometry_msgs/Point", "", "m"),
    ("geometry_msgs/Point32", "", "m"),
    ("geometry_msgs/Quaternion", "", "1"),
    ("geometry_msgs/Twist", "linear", "m/s"),
    ("geometry_msgs/Twist", "angular", "rad/s"),
    ("geometry_msgs/Accel", "linear", "m/s^2"),
    ("geometry_msgs/Accel", "angular", "rad/s^2"),
    ("geometry_msgs/Wrench", "force", "N"),
    ("geometry_msgs/Wrench", "torque", "N*m"),
    ("geometry_msgs/Transform", "translation", "m"),
    ("geometry_msgs/Pose2D", "theta", "rad"),
    ("geometry_msgs/Pose2D", "x", "m"),
    ("geometry_msgs/Pose2D", "y", "m"),
    ("sensor_msgs/Imu", "angular_velocity", "rad/s"),
    ("sensor_msgs/Imu", "linear_acceleration", "m/s^2"),
    ("sensor_msgs/MagneticField", "magnetic_field", "T"),
    ("sensor_msgs/FluidPressure", "fluid_pressure", "Pa"),
    ("sensor_msgs/LaserScan", "angle_min", "rad"),
    ("sensor_msgs/LaserScan", "angle_max", "rad"),
    ("sensor_msgs/LaserScan", "angle_increment", "rad"),
    ("sensor_msgs/LaserScan", "time_increment", "s"),
    ("sensor_msgs/LaserScan", "scan_time", "s"),
    ("sensor_msgs/LaserScan", "range_min", "m"),
    ("sensor_msgs/LaserScan", "range_max", "m"),
    ("sensor_msgs/LaserScan", "ranges", "m"),
    ("sensor_msgs/Range", "field_of_view", "rad"),
    ("sensor_msgs/Range", "min_range", "m"),
    ("sensor_msgs/Range", "max_range", "m"),
    ("sensor_msgs/Range", "range", "m"),
    ("sensor_msgs/BatteryState", "voltage", "V"),
    ("sensor_msgs/BatteryState", "current", "A"),
    ("sensor_msgs/BatteryState", "percentage", "1"),
    ("builtin_interfaces/Time", "sec", "s"),
    ("builtin_interfaces/Time", "nanosec", "ns"),
    ("builtin_interfaces/Duration", "sec", "s"),
    ("builtin_interfaces/Duration", "nanosec", "ns"),
];

/// The unit that the type of a topic fixes for the number at `path`; empty if it fixes none.
pub(crate) fn usual_unit(info: &TopicInfo, path: &str) -> &'static str {
    match &info.schema.as_ref() {
        Schema::Struct(root) => unit_below(root, path),
        _ => "",
    }
}

fn unit_below(root: &MessageType, path: &str) -> &'static str {
    if path.starts_with("length(") {
        return "1";
    }
    let (mut current, mut unit) = (root, "");
    for step in path.split('.') {
        let name = step.split('[').next().unwrap_or(step);
        unit = own_unit(&current.name, name).unwrap_or(unit);
        let Some((_, field)) = current.field(name) else {
            return unit;
        };
        match innermost(&field.kind) {
            Type::Struct(next) => current = next,
            _ => return unit,
        }
    }
    unit
}

fn own_unit(type_name: &str, field: &str) -> Option<&'static str> {
    let short = type_name.replacen("/msg/", "/", 1);
    let fits = |(type_name, name, _): &&(&str, &str, &str)| {
        *type_name == short && (name.is_empty() || *name == field)
    };
    UNITS.iter().find(fits).map(|(_, _, unit)| *unit)
}

/// The type of the elements of arrays of arrays.
pub(super) fn innermost(kind: &Type) -> &Type {
    match kind {
        Type::Array(element, _) | Type::Sequence(element) => innermost(element),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{Dialect, parse_msg};

    fn unit(text: &str, path: &str) -> &'static str {
        let root = parse_msg("my_msgs/msg/Thing", text, Dialect::Ros2).unwrap();
        unit_below(&root, path)
    }

    #[test]
    fn the_innermost_type_that_says_something_counts() {
        let rule = "=".repeat(80);
        let text = format!(
            "geometry_msgs/Twist twist\ngeometry_msgs/Pose[] poses\nfloat64 x\n{rule}\n\
             MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n{rule}\n\
             MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\n\
             MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n{rule}\n\
             MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\n\
             MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
        );
        assert_eq!(unit(&text, "twist.linear.x"), "m/s");
        assert_eq!(unit(&text, "twist.angular.z"), "rad/s");
        assert_eq!(unit(&text, "poses[3].position.x"), "m");
        assert_eq!(unit(&text, "poses[3].orientation.w"), "1");
        assert_eq!(unit(&text, "length(poses)"), "1");
        assert_eq!(unit(&text, "x"), "");
        assert_eq!(unit(&text, "nothing.there"), "");
    }

    #[test]
    fn every_unit_can_be_read() {
        for (_, _, unit) in UNITS {
            assert!(unit.parse::<trace::units::Unit>().is_ok(), "{unit}");
        }
    }
}
