//! `<sensor>`: lidar, camera, IMU, contact, force and torque; others by their type alone.
//!
//! Used for SDF and for the sensors that a URDF carries in `<gazebo>`. Rates are `update_rate`; 0 there means "as often
//! as possible" and is kept as no rate.

use crate::diagnostics::Effect;
use crate::model::Model;
use crate::pose::Pose;
use crate::reader::Reader;
use crate::sensor::{Camera, Fan, Lidar, Noise, Sensor, SensorKind};
use crate::xml::Element;

/// Reads a sensor on a link (or the world), or on a joint. Its pose must be in the link's frame: a caller that knows
/// other frames replaces `pose_in_link`.
pub(crate) fn read(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    model: &Model,
    link: Option<usize>,
    joint: Option<usize>,
) -> Option<Sensor> {
    let name = reader.required(element, "name").to_owned();
    let type_name = reader.required(element, "type").to_owned();
    let pose_in_link = match element.child("pose") {
        Some(pose) => super::pose::plain(reader, pose),
        None => Pose::IDENTITY,
    };
    let rate_hz = reader.child_number(element, "update_rate");
    let mut sensor = Sensor {
        kind: kind(reader, element, &type_name, model, joint)?,
        name,
        link,
        pose_in_link,
        rate_hz: rate_hz.filter(|rate| *rate > 0.0),
        noise: vec![],
    };
    noises(reader, element, "", &mut sensor.noise, 0);
    leftovers(reader, element);
    Some(sensor)
}

/// Children of a sensor that say nothing about the measurement, or that other functions read.
fn leftovers(reader: &mut Reader<'_, '_>, element: &Element) {
    for child in &element.children {
        match child.name.as_str() {
            "plugin" => reader.passed_over("sensor", child, Effect::Control),
            "pose" | "update_rate" | "ray" | "lidar" | "imu" | "camera" | "contact"
            | "force_torque" | "visualize" | "topic" | "always_on" | "enable_metrics" => {}
            _ => reader.passed_over("sensor", child, Effect::Sensing),
        }
    }
}

fn kind(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    type_name: &str,
    model: &Model,
    joint: Option<usize>,
) -> Option<SensorKind> {
    Some(match type_name {
        "ray" | "gpu_ray" | "lidar" | "gpu_lidar" => {
            let body = element.child("lidar").or_else(|| element.child("ray"));
            SensorKind::Lidar(lidar(reader, body.unwrap_or(element)))
        }
        "imu" => SensorKind::Imu,
        "camera" | "depth" | "depth_camera" | "rgbd_camera" | "rgbd" | "wideanglecamera" => {
            let body = element.child("camera").unwrap_or(element);
            SensorKind::Camera(camera(reader, body, type_name))
        }
        "contact" => {
            let named = element.child("contact").into_iter();
            let names = named.flat_map(|contact| contact.all("collision"));
            SensorKind::Contact {
                shapes: names.map(|name| name.text.clone()).collect(),
            }
        }
        "force_torque" if joint.is_some_and(|index| index < model.joints.len()) => {
            SensorKind::ForceTorque {
                joint: joint.unwrap_or(0),
            }
        }
        other => {
            let what = format!("sensors of type {other} are known by name only");
            let consequence = "it measures nothing here";
            reader.gap(&element.place, "sensor", what, Effect::Sensing, consequence);
            SensorKind::Other(other.to_owned())
        }
    })
}

fn lidar(reader: &mut Reader<'_, '_>, element: &Element) -> Lidar {
    let scan = element.child("scan");
    let mut fan = |name: &str| {
        let part = scan.and_then(|scan| scan.child(name));
        part.map_or(
            Fan {
                count: 1,
                first_rad: 0.0,
                last_rad: 0.0,
            },
            |part| Fan {
                count: count(reader, part, "samples", 1),
                first_rad: reader.child_number(part, "min_angle").unwrap_or(0.0),
                last_rad: reader.child_number(part, "max_angle").unwrap_or(0.0),
            },
        )
    };
    let (horizontal, vertical) = (fan("horizontal"), fan("vertical"));
    let range = element.child("range");
    let mut of_range = |name: &str, default: f64| match range.and_then(|range| range.child(name)) {
        // An unlimited range is written as inf.
        Some(child) => reader
            .limit(&child.place, name, &child.text)
            .unwrap_or(f64::INFINITY),
        None => default,
    };
    Lidar {
        horizontal,
        vertical,
        nearest_m: of_range("min", 0.0),
        farthest_m: of_range("max", f64::INFINITY),
        resolution_m: of_range("resolution", 0.0),
    }
}

/// A whole positive number in a child.
fn count(reader: &mut Reader<'_, '_>, element: &Element, name: &str, default: u32) -> u32 {
    let Some(number) = reader.child_number(element, name) else {
        return default;
    };
    if (1.0..=1e7).contains(&number) && number.fract() == 0.0 {
        return number as u32;
    }
    let message = format!("{name} is {number}");
    reader.problem(
        &element.place,
        message,
        "give a whole number from 1 to 10000000",
    );
    default
}

fn camera(reader: &mut Reader<'_, '_>, element: &Element, type_name: &str) -> Camera {
    let image = element.child("image").unwrap_or(element);
    let clip = element.child("clip").unwrap_or(element);
    Camera {
        horizontal_view_rad: reader
            .child_number(element, "horizontal_fov")
            .unwrap_or(1.047),
        width_pixels: count(reader, image, "width", 320),
        height_pixels: count(reader, image, "height", 240),
        nearest_m: reader.child_number(clip, "near").unwrap_or(0.1),
        farthest_m: reader.child_number(clip, "far").unwrap_or(100.0),
        depth: type_name.contains("depth") || type_name.contains("rgbd"),
    }
}

/// All `<noise>` below, each under the names of the elements that lead to it.
fn noises(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    path: &str,
    found: &mut Vec<(String, Noise)>,
    depth: usize,
) {
    for child in &element.children {
        if child.name == "noise" {
            if let Some(noise) = noise(reader, child) {
                found.push((path.to_owned(), noise));
            }
        } else if depth < 4 && child.name != "plugin" {
            let skipped = depth == 0; // `imu/`, `ray/` repeat the kind of the sensor
            let below = match (skipped, path) {
                (true, _) => String::new(),
                (false, "") => child.name.clone(),
                (false, path) => format!("{path}/{}", child.name),
            };
            noises(reader, child, &below, found, depth + 1);
        }
    }
}

fn noise(reader: &mut Reader<'_, '_>, element: &Element) -> Option<Noise> {
    let type_name = element.get("type").or_else(|| element.text_of("type"));
    match type_name.unwrap_or("none") {
        "none" => return None,
        "gaussian" | "gaussian_quantized" => {}
        _ => {
            reader.passed_over("sensor", element, Effect::Sensing);
            return None;
        }
    }
    for child in &element.children {
        let known = ["type", "mean", "stddev", "bias_mean", "bias_stddev"];
        if !known.contains(&child.name.as_str()) {
            reader.passed_over("noise", child, Effect::Sensing);
        }
    }
    let mut number = |name: &str| reader.child_number(element, name).unwrap_or(0.0);
    Some(Noise {
        mean: number("mean"),
        standard_deviation: number("stddev").abs(),
        bias_mean: number("bias_mean"),
        bias_standard_deviation: number("bias_stddev").abs(),
    })
}
