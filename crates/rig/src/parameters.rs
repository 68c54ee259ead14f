//! Whether the parameters of a file fit the bench that they set: their units, and their keys.
//!
//! Names in a bench's data end in their units (`mass_kg`, `speed_m_s`). A parameter that says another
//! one is refused, with the factor between the two if there is one: numbers that were meant in
//! kilonewtons must not be run as newtons. Keys without such an ending, and those of other simulators,
//! are not known to have a unit, and are taken as they are.

use diagnostic::{Problem, Source};
use std::ops::Range;
use stimulus::{Distribution, Parameter, Point, Space, Stimulus};
use trace::units::Unit;

/// Endings of names, and the units that they stand for; the longer ones first.
const ENDINGS: [(&str, &str); 17] = [
    ("_rad_s2", "rad/s^2"),
    ("_nms_rad", "N*m*s/rad"),
    ("_nm_rad", "N*m/rad"),
    ("_newtons", "N"),
    ("_kg_m2", "kg*m^2"),
    ("_m_s2", "m/s^2"),
    ("_rad_s", "rad/s"),
    ("_ns_m", "N*s/m"),
    ("_secs", "s"),
    ("_n_m", "N/m"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_nm", "N*m"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_m", "m"),
];

/// Fails where the unit of a parameter is not that of what it sets.
pub fn check_units(space: &Space, source: &Source, code: &'static str) -> Result<(), Problem> {
    for parameter in &space.parameters {
        let Some(text) = &parameter.unit else {
            continue;
        };
        let place = || after(source, &parameter.name, text);
        let set = parameter.sets.iter();
        for (key, expected) in set.filter_map(|key| Some((key, unit_of(key)?))) {
            let Ok(expected_unit) = expected.parse::<Unit>() else {
                continue;
            };
            let Ok(unit) = text.parse::<Unit>() else {
                let message = format!(
                    "parameter `{}`: unknown unit `{text}`; `{key}` is in {expected}",
                    parameter.name
                );
                let problem = Problem::new(code, message).at(source, place());
                return Err(problem.remedy(format!("write unit = \"{expected}\"")));
            };
            if unit.same_as(&expected_unit) {
                continue;
            }
            let message = format!(
                "parameter `{}` is in {text}, and `{key}`, which it sets, in {expected}",
                parameter.name
            );
            let remedy = match unit.conversion_to(&expected_unit) {
                Some(conversion) => format!(
                    "give its numbers in {expected} (1 {text} = {} {expected}), and unit = \"{expected}\"",
                    conversion.apply(1.0)
                ),
                None => "correct `unit`, or the keys in `sets`".to_owned(),
            };
            return Err(Problem::new(code, message)
                .at(source, place())
                .remedy(remedy));
        }
    }
    Ok(())
}

/// Ends and middle of a distribution, in its distribution function; ends that are infinite are
/// taken a thousandth inside.
pub fn tried(distribution: &Distribution) -> [f64; 3] {
    let end = |at: f64, inside: f64| match distribution.quantile(at).is_finite() {
        true => at,
        false => inside,
    };
    [end(0.0, 0.001), 0.5, end(1.0, 0.999)]
}

/// Fails at the first key that `refused` gives a reason for, when the parameter has its nominal value, and at the
/// first parameter whose range the bench does not take to its ends, unless constraints may keep it from them. What
/// sets delays of a test is left to that test.
pub fn check_keys(
    space: &Space,
    test: &stimulus::AbstractTest,
    source: &Source,
    code: &'static str,
    refused: &dyn Fn(&Stimulus) -> Option<String>,
) -> Result<(), Problem> {
    let reason = |space: &Space, point: &Point| match space.stimulus(test, point) {
        Ok(stimulus) => refused(&stimulus),
        Err(error) => Some(error.to_string()),
    };
    for parameter in &space.parameters {
        for key in parameter.sets.iter().filter(|key| !is_of_test(key)) {
            let alone = alone(parameter, vec![key.clone()]);
            if let Some(reason) = reason(&alone, &alone.nominal()) {
                let message = format!("parameter `{}`: {reason}", parameter.name);
                return Err(Problem::new(code, message)
                    .at(source, after(source, &parameter.name, key))
                    .remedy("correct the key in `sets`, or the parameter's range"));
            }
        }
        if !space.constraints.is_empty() || parameter.sets.iter().any(|key| is_of_test(key)) {
            continue;
        }
        let key = parameter.sets.first().map_or("", String::as_str);
        let whole = alone(parameter, parameter.sets.clone());
        for end in tried(&parameter.distribution) {
            let point = whole.at(&[end]);
            if let Some(reason) = reason(&whole, &point) {
                let value = parameter.distribution.quantile(end);
                let message = format!("parameter `{}` cannot be {value}: {reason}", parameter.name);
                return Err(Problem::new(code, message)
                    .at(source, after(source, &parameter.name, key))
                    .remedy("correct its range, or what it sets"));
            }
        }
    }
    Ok(())
}

/// Whether a key sets a delay or a value of the abstract test.
fn is_of_test(key: &str) -> bool {
    key.starts_with("test.")
}

/// One parameter by itself.
fn alone(parameter: &Parameter, sets: Vec<String>) -> Space {
    Space {
        parameters: vec![Parameter {
            sets,
            ..parameter.clone()
        }],
        constraints: Vec::new(),
    }
}

/// The unit that a key's name ends in.
pub fn unit_of(key: &str) -> Option<&'static str> {
    // Behind the name stand places of arrays and parts of distributions.
    key.rsplit('.').find_map(|part| {
        let part = part.trim_matches(['"', '\'']);
        let (_, unit) = ENDINGS.iter().find(|(ending, _)| part.ends_with(ending))?;
        Some(*unit)
    })
}

/// Where a word stands in quotes behind a name in quotes, or else the name.
fn after(source: &Source, name: &str, word: &str) -> Range<usize> {
    let quoted = |word: &str, from: usize| {
        let at = source.text[from..].find(&format!("\"{word}\""))?;
        let start = from + at + 1;
        Some(start..start + word.len())
    };
    let named = quoted(name, 0).unwrap_or(0..0);
    quoted(word, named.end).unwrap_or(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(unit: &str, key: &str) -> Option<String> {
        let text = format!(
            "[[parameter]]\nname = \"other\"\nsets = [\"a\"]\nunit = \"{unit}\"\nuniform = [0, 1]\n\
             [[parameter]]\nname = \"pull\"\nsets = [\"{key}\"]\nunit = \"{unit}\"\nuniform = [1.0, 15.0]\n"
        );
        let source = Source {
            name: "file.toml".into(),
            text: text.clone(),
        };
        let space = Space::from_toml(&text).unwrap();
        let problem = check_units(&space, &source, "bad-exploration").err()?;
        Some(problem.to_string())
    }

    #[test]
    fn the_unit_has_to_be_that_of_the_key() {
        for (_, unit) in ENDINGS {
            assert!(unit.parse::<Unit>().is_ok(), "{unit}");
        }
        let key = "parameters.human.pull_forward_newtons";
        for fits in ["N", "kg*m/s^2"] {
            assert_eq!(refusal(fits, key), None);
        }
        assert_eq!(refusal("m", "object.1.location_offset_m.2"), None);
        assert_eq!(refusal("N m", "hand.friction.uniform.0"), None);
        let said = refusal("kN", key).unwrap();
        assert!(
            said.contains("is in kN") && said.contains("1 kN = 1000 N"),
            "{said}"
        );
        assert!(said.contains("file.toml:9:"), "{said}");
        let said = refusal("s", "parameters.human.pull_forward_newtons.uniform.0").unwrap();
        assert!(said.contains("correct `unit`"), "{said}");
        assert!(refusal("furlong", key).unwrap().contains("unknown unit"));
    }

    #[test]
    fn a_range_is_tried_to_its_ends() {
        let said = |low: f64| {
            let text = format!(
                "[[parameter]]\nname = \"mass\"\nsets = [\"a.mass_kg\"]\nuniform = [{low}, 0.4]\nnominal = 0.1\n"
            );
            let source = Source {
                name: "file.toml".into(),
                text: text.clone(),
            };
            let refused = |stimulus: &Stimulus| match stimulus.settings.get("a.mass_kg") {
                Some(stimulus::Setting::Number(mass)) if *mass < 0.0 => {
                    Some("a mass is above 0".to_owned())
                }
                _ => None,
            };
            let space = Space::from_toml(&text).unwrap();
            let test = stimulus::AbstractTest::new("t", Vec::new());
            let checked = check_keys(&space, &test, &source, "bad-exploration", &refused);
            checked.err().map(|problem| problem.to_string())
        };
        assert_eq!(said(0.05), None);
        let said = said(-1.0).unwrap();
        assert!(
            said.contains("`mass` cannot be -1: a mass is above 0"),
            "{said}"
        );
        assert!(said.contains("file.toml:3:"), "{said}");
    }
}
