//! Numbers that the scene's types hold as plain numbers, given as distributions.
//!
//! What is drawn once for an episode and then only used (sizes, gains, limits, angles) is drawn in
//! the table, before it is read: a table `T` with distributions `D_k` at keys `k` becomes `T` with
//! the number `q_k(u_k)` there, `q_k` the quantile function of `D_k` and `u_k` of the random stream
//! that is named by `k`, as for all other numbers of a scene. Rates and periods are whole numbers of
//! time steps and are not drawn.

use serde_json::Value as Json;
use stimulus::Distribution;
use toml::{Table, Value};

/// Keys of numbers that may be distributions, by list; of `box_m` and `marker_m` each element.
const DRAWN: [(&str, &[&str]); 4] = [
    ("object", &["box_m", "radius_m", "length_m"]),
    (
        "actuator",
        &[
            "stiffness",
            "damping",
            "limit",
            "gain",
            "wheel_radius_m",
            "wheel_separation_m",
            "longest_speed_m_s",
            "longest_turn_rate_rad_s",
            "turn_acceleration_rad_s2",
            "gain_nms_rad",
            "torque_limit_nm",
            "gain_ns_m",
            "turn_gain_nms_rad",
            "force_limit_newtons",
        ],
    ),
    (
        "sensor",
        &[
            "resolution",
            "first_angle_rad",
            "last_angle_rad",
            "shortest_m",
            "longest_m",
            "field_of_view_rad",
            "horizontal_view_rad",
            "vertical_view_rad",
            "widest_angle_rad",
            "marker_m",
        ],
    ),
    (
        "gripper",
        &[
            "width_m",
            "force_limit_newtons",
            "speed_m_s",
            "return_stiffness",
            "tension_limit_newtons",
            "reach_m",
            "holding_force_newtons",
            "friction",
        ],
    ),
];

/// Gives the number of a key.
type Draw<'d> = &'d mut dyn FnMut(&str, &Distribution) -> f64;

/// Puts what `draw` gives for a key in the place of each distribution that stands for a plain
/// number; whether there was one.
pub(in crate::scene) fn resolve(table: &mut Table, draw: Draw<'_>) -> bool {
    let mut found = false;
    if let Some(Value::Table(simulation)) = table.get_mut("simulation")
        && let Some(gravity) = simulation.get_mut("gravity_m_s2")
    {
        found |= number(gravity, "simulation.gravity_m_s2", draw);
    }
    for (list, fields) in DRAWN {
        let Some(Value::Array(entries)) = table.get_mut(list) else {
            continue;
        };
        for entry in entries.iter_mut().filter_map(Value::as_table_mut) {
            let name = entry
                .get("name")
                .and_then(Value::as_str)
                .unwrap_or_default();
            let name = name.to_owned();
            for field in fields {
                if let Some(value) = entry.get_mut(*field) {
                    found |= number(value, &super::key_of(list, &name, field), draw);
                }
            }
        }
    }
    found
}

/// A value, or each element of it.
fn number(value: &mut Value, key: &str, draw: Draw<'_>) -> bool {
    if let Value::Array(elements) = value {
        let elements = elements.iter_mut().enumerate();
        return elements.fold(false, |found, (place, element)| {
            number(element, &format!("{key}.{place}"), draw) | found
        });
    }
    if !value.is_table() {
        return false;
    }
    match value.clone().try_into::<Distribution>() {
        Ok(distribution) if distribution.check().is_ok() => {
            *value = Value::Float(draw(key, &distribution));
            true
        }
        // What it is instead is said when it is read.
        _ => false,
    }
}

/// Lets distributions stand, in a scene's schema, where [`resolve`] draws plain numbers.
pub(super) fn allow_in(schema: &mut schemars::Schema) {
    let Some(definitions) = schema.get_mut("$defs").and_then(Json::as_object_mut) else {
        return;
    };
    let simulation: &[&str] = &["gravity_m_s2"];
    for (name, fields) in DEFINITIONS.iter().zip(DRAWN.map(|(_, fields)| fields)) {
        if let Some(definition) = definitions.get_mut(*name) {
            allow_below(definition, fields);
        }
    }
    if let Some(definition) = definitions.get_mut("Simulation") {
        allow_below(definition, simulation);
    }
}

/// The types that hold the elements of the lists of [`DRAWN`], in their order.
const DEFINITIONS: [&str; 4] = ["Object", "Actuator", "Sensor", "Gripper"];

/// Changes the properties with these names, wherever they stand in a schema.
fn allow_below(schema: &mut Json, fields: &[&str]) {
    match schema {
        Json::Object(object) => {
            for (key, value) in object {
                if key == "properties"
                    && let Some(properties) = value.as_object_mut()
                {
                    let drawn = properties.iter_mut();
                    let drawn = drawn.filter(|(name, _)| fields.contains(&name.as_str()));
                    drawn.for_each(|(_, property)| allow(property));
                }
                allow_below(value, fields);
            }
        }
        Json::Array(elements) => {
            let elements = elements.iter_mut();
            elements.for_each(|element| allow_below(element, fields));
        }
        _ => {}
    }
}

/// Changes a number, or the numbers of a list, to a number or a distribution.
fn allow(property: &mut Json) {
    if let Some(items) = property.get_mut("items") {
        return allow(items);
    }
    let Some(object) = property.as_object_mut() else {
        return;
    };
    object.remove("type");
    object.remove("format");
    object.insert("$ref".into(), "#/$defs/Distribution".into());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_numbers_are_drawn_by_key_and_nothing_else_is() {
        let text = "
            simulation = { gravity_m_s2 = { uniform = [9.0, 10.0] } }
            object = [{ name = 'a', box_m = [1.0, { uniform = [2.0, 3.0] }, 4.0], x_m = { uniform = [0.0, 1.0] } }]
            sensor = [{ name = 's', longest_m = { uniform = [5.0, 6.0] }, latency_secs = { uniform = [0.0, 1.0] } }]
        ";
        let mut table: Table = toml::from_str(text).unwrap();
        let mut keys = Vec::new();
        let found = resolve(&mut table, &mut |key, distribution| {
            keys.push(key.to_owned());
            distribution.support()[0]
        });
        assert!(found);
        let expected = [
            "simulation.gravity_m_s2",
            "object.a.box_m.1",
            "sensor.s.longest_m",
        ];
        assert_eq!(keys, expected);
        assert_eq!(table["object"][0]["box_m"][1], Value::Float(2.0));
        assert!(table["object"][0]["x_m"].is_table());
        assert!(table["sensor"][0]["latency_secs"].is_table());
        assert!(!resolve(&mut table, &mut |_, _| 0.0), "all are drawn");
    }
}
