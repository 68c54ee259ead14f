//! Where a scene's file says what is wrong with it.

use diagnostic::{Problem, Problems, Source, did_you_mean};
use serde::de::DeserializeOwned;
use std::ops::Range;
use testbench::ScenarioError;
use testbench::scene::SceneData;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The code of what is wrong with a scene.
const BAD_SCENE: &str = "bad-scene";

/// The problem of a scene that cannot be used, at its place in the file as far as that is known, with all others that do not
/// follow from it.
pub fn problem_of(source: &Source, error: &ScenarioError) -> Problem {
    let mut found = Problems::new();
    // Read as data it says where, as a table it does not.
    if let ScenarioError::Syntax { .. } = error {
        read_on(source, &mut found);
    }
    let problem = found.into_problem();
    problem.unwrap_or_else(|| problem_in::<SceneData>(BAD_SCENE, source, error))
}

/// The same of a text that is read as `T`, whose problems have a code of their own.
pub fn problem_in<T: DeserializeOwned>(
    code: &'static str,
    source: &Source,
    error: &ScenarioError,
) -> Problem {
    let mut found = Problems::new();
    match error {
        ScenarioError::Syntax { .. } => drop(study::read_as::<T>(code, source, &[], &mut found)),
        ScenarioError::Several(all) => all
            .iter()
            .for_each(|error| found.add(problem_in::<T>(code, source, error))),
        ScenarioError::Value { .. }
        | ScenarioError::UnknownName { .. }
        | ScenarioError::Description { .. } => found.add(placed(code, source, error)),
    }
    let problem = found.into_problem();
    problem.unwrap_or_else(|| placed(code, source, error))
}

/// All mistakes of a scene's form, and those of its values that do not follow from them.
fn read_on(source: &Source, found: &mut Problems) {
    let taken = SceneData::keys_of_drawn_numbers(&source.text);
    let taken = taken.iter().filter_map(|key| value_at(&source.text, key));
    let taken: Vec<Range<usize>> = taken.collect();
    let Some(data) = study::read_as::<SceneData>(BAD_SCENE, source, &taken, found) else {
        return;
    };
    let wrong = match data.check() {
        Ok(()) => Vec::new(),
        Err(ScenarioError::Several(all)) => all,
        Err(one) => vec![one],
    };
    let has_lost_names = found.has_lost_names();
    let follows = |error: &&ScenarioError| {
        has_lost_names && matches!(error, ScenarioError::UnknownName { .. })
    };
    for error in wrong.iter().filter(|error| !follows(error)) {
        found.add(placed(BAD_SCENE, source, error));
    }
}

/// One mistake at its place.
fn placed(code: &'static str, source: &Source, error: &ScenarioError) -> Problem {
    let text = &source.text;
    let span = match error {
        ScenarioError::Value { key, .. } => span_of(text, key),
        ScenarioError::UnknownName { key, name } => {
            span_of(text, key).map(|span| named(text, span, name))
        }
        ScenarioError::Description { file, .. } => Some(study::placed::quoted(source, file)),
        ScenarioError::Syntax { .. } | ScenarioError::Several(_) => None,
    };
    let problem = Problem::new(code, error.to_string());
    let problem = problem.at(source, span.unwrap_or(0..0));
    let similar = match error {
        ScenarioError::UnknownName { name, .. } => similar_name(text, name),
        _ => None,
    };
    problem.remedy(match similar {
        Some(similar) => format!("did you mean `{similar}`?"),
        None => format!("correct it there (`corroborate explain {code}`)"),
    })
}

/// What has a name in the scene that is like this one.
fn similar_name(text: &str, name: &str) -> Option<String> {
    let root = DeTable::parse(text).ok()?;
    let lists = root.get_ref().values();
    let entries = lists.filter_map(|list| list.get_ref().as_array()).flatten();
    let names = entries.filter_map(|entry| entry.get_ref().get("name")?.get_ref().as_str());
    did_you_mean(name, names).map(str::to_owned)
}

/// The value at a dotted key, if all of it is there.
fn value_at(text: &str, key: &str) -> Option<Range<usize>> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let mut found = root.get_ref().get(parts.next()?)?;
    for part in parts {
        found = below(found.get_ref(), part)?;
    }
    Some(found.span())
}

/// What a table has under a key, or a list by its place or its name.
fn below<'v, 't>(value: &'v DeValue<'t>, part: &str) -> Option<&'v Spanned<DeValue<'t>>> {
    match value {
        DeValue::Table(table) => table.get(part),
        DeValue::Array(list) => match part.parse::<usize>() {
            Ok(place) => list.get(place),
            Err(_) => list.iter().find(|entry| {
                let name = entry.get_ref().get("name");
                name.is_some_and(|name| name.get_ref().as_str() == Some(part))
            }),
        },
        _ => None,
    }
}

/// The value at a dotted key, in which an entry of a list is known by its name or place; else the
/// last of its parents that is there.
pub fn span_of(text: &str, key: &str) -> Option<Range<usize>> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let mut found = root.get_ref().get(parts.next()?)?;
    for part in parts {
        let next = below(found.get_ref(), part);
        match next {
            Some(next) => found = next,
            None => break,
        }
    }
    Some(first_line(text, found.span()))
}

/// A table has many lines; the first says enough.
fn first_line(text: &str, span: Range<usize>) -> Range<usize> {
    let shown = text.get(span.clone()).unwrap_or_default();
    let length = shown.find('\n').unwrap_or(shown.len());
    span.start..span.start + length
}

/// Where `name` stands in quotes, from the span on; else the span.
fn named(text: &str, span: Range<usize>, name: &str) -> Range<usize> {
    let quoted = format!("\"{name}\"");
    let behind = text.get(span.start..).unwrap_or_default();
    match behind.find(&quoted) {
        Some(place) => span.start + place..span.start + place + quoted.len(),
        None => span,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[simulation]\nduration_secs = 5\n[[sensor]]\nname = \"a\"\nrays = 3\n[[sensor]]\nname = \"b\"\nrays = 0\njoints = [\"left\", \"right\"]\n";

    #[test]
    fn keys_are_found_by_name_and_by_place_or_else_their_parents() {
        let at = |key: &str| span_of(TEXT, key).map(|span| &TEXT[span]);
        assert_eq!(at("simulation.duration_secs"), Some("5"));
        assert_eq!(at("sensor.b.rays"), Some("0"));
        assert_eq!(at("sensor.0.rays"), Some("3"));
        assert_eq!(at("sensor.b.joints.1"), Some("\"right\""));
        assert!(at("sensor.b.fault.0.kind").is_some_and(|text| text.contains("sensor")));
        assert_eq!(at("nothing.at.all"), None);
        let span = span_of(TEXT, "sensor.b.joint").expect("the sensor");
        assert_eq!(&TEXT[named(TEXT, span, "right")], "\"right\"");
    }

    /// Line and message of what is wrong with a scene, with the remedy.
    fn told(text: &str) -> Vec<(usize, String)> {
        let source = Source::new("scene.toml", text);
        let table = toml::from_str(text).expect("TOML");
        let error = SceneData::from_table(table).expect_err("it has mistakes");
        let problems = problem_of(&source, &error).into_each().into_iter();
        let placed = problems.map(|it| {
            let place = it.place().expect("a place");
            let remedy = it.what_to_do().expect("a remedy");
            (place.line, format!("{} {remedy}", it.message()))
        });
        placed.collect()
    }

    const SCENE: &str = r#"name = "hall"
simulation = { duration_secs = 4.0, time_step_secs = 0.005 }
abstract_test = [{ name = "wait", actions = [] }]
[[robot]]
name = "carrier"
file = "carrier.urdf"
[[object]]
name = "shelf"
box_m = [{ uniform = [8.0, 9.0] }, 0.4, 2.0]
[[object]]
name = "box"
box_m = [9.0, 0.4, 2.0]
[[person]]
name = "anna"
x_m = 1.0
y_m = 0.0
activity = "stand"
[[sensor]]
name = "lidar"
robot = "carrier"
kind = "lidar"
rate_hz = 10
rays = 61
first_angle_rad = -1.5
last_angle_rad = 1.5
shortest_m = 0.05
longest_m = 6.0
"#;

    #[test]
    fn all_mistakes_of_a_scene_are_told_each_with_its_line() {
        let mut text = SCENE.to_owned();
        for (old, new) in [
            ("box_m = [9.0, 0.4, 2.0]", "box_m = [9.0, 0.4]"),
            ("\"stand\"", "\"stend\""),
            ("robot = \"carrier\"", "robot = \"karrier\""),
            ("kind = \"lidar\"", "kind = \"lidarr\""),
            ("rate_hz = 10", "rate_hz = -10"),
            ("rays = 61", "rays = 61\nrayz = 3"),
        ] {
            assert!(text.contains(old), "{old}");
            text = text.replacen(old, new, 1);
        }
        let found = told(&text);
        let lines: Vec<usize> = found.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [12, 17, 20, 21, 22, 24], "{found:#?}");
        for ((_, message), said) in found.iter().zip([
            "list of 3",
            "did you mean `stand`?",
            "did you mean `carrier`?",
            "did you mean `lidar`?",
            "",
            "did you mean `rays`?",
        ]) {
            assert!(message.contains(said), "no `{said}`: {message}");
        }
    }

    #[test]
    fn what_follows_from_a_wrong_time_step_is_not_told() {
        let found = told(&SCENE.replace("time_step_secs = 0.005", "time_step_secs = 0"));
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(found[0].1.contains("(got 0)"), "{found:#?}");
    }

    #[test]
    fn a_name_that_is_missing_hides_who_names_it() {
        let found = told(&SCENE.replace("[[robot]]\nname = \"carrier\"", "[[robot]]"));
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(found[0].1.contains("missing field `name`"), "{found:#?}");
    }

    #[test]
    fn what_is_wrong_is_shown_with_its_line() {
        let source = Source {
            name: "scene.toml".into(),
            text: "name = \"s\"\nsimulation = { duration = 5 }\n".into(),
        };
        let error = ScenarioError::Syntax {
            reason: "unknown".into(),
        };
        let shown = problem_of(&source, &error).to_string();
        assert!(shown.contains("scene.toml:2"), "{shown}");
    }
}
