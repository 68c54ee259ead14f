//! `<pose>`: six numbers (metres, radians about fixed axes), or position and quaternion.

use crate::pose::{Pose, from_roll_pitch_yaw, normalized};
use crate::reader::Reader;
use crate::xml::Element;

/// The numbers of a pose, whatever frame they are relative to.
pub(crate) fn plain(reader: &mut Reader<'_, '_>, element: &Element) -> Pose {
    let known = ["relative_to", "frame", "degrees", "rotation_format"];
    reader.known_attributes(element, &known);
    if element.text.is_empty() {
        return Pose::IDENTITY;
    }
    match element.get("rotation_format") {
        None | Some("euler_rpy") => {
            let numbers = reader.exactly::<6>(&element.place, "pose", &element.text);
            let [x, y, z, roll, pitch, yaw] = numbers.unwrap_or_default();
            let degrees = element.attribute("degrees").cloned();
            let degrees = degrees.is_some_and(|text| {
                reader.truth(&text.place, "pose@degrees", &text.value) == Some(true)
            });
            let angles = [roll, pitch, yaw]
                .map(|angle: f64| if degrees { angle.to_radians() } else { angle });
            Pose {
                position_m: [x, y, z],
                rotation: from_roll_pitch_yaw(angles),
            }
        }
        Some("quat_xyzw") => {
            let numbers = reader.exactly::<7>(&element.place, "pose", &element.text);
            let [x, y, z, qx, qy, qz, qw] = numbers.unwrap_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
            Pose {
                position_m: [x, y, z],
                rotation: normalized([qw, qx, qy, qz]),
            }
        }
        Some(other) => {
            let message = format!("rotation_format {other} is not known");
            reader.problem(&element.place, message, "use euler_rpy or quat_xyzw");
            Pose::IDENTITY
        }
    }
}
