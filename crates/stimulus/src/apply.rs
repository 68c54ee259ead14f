//! Settings applied to a bench's data, before the bench reads it.
//!
//! A dotted key walks through tables by name, and through arrays by place (from 0) or, in an
//! array of tables, by the value of `name`. What it finds must be a value (or a distribution,
//! which the setting replaces by a constant) of the setting's kind: a setting never makes a key
//! that the data does not have, unless the caller declares that the key may be absent. So a
//! misspelt key is an error before anything runs, and not an episode with the default value.

use toml::{Table, Value};

use crate::distribution::{DETAILS, KINDS};
use crate::error::StimulusError;
use crate::key::{segments, similar};
use crate::setting::{Setting, Settings};

/// Sets every key in `data`; all or nothing.
///
/// ```
/// let mut data: toml::Table = toml::from_str("[human]\npull = { uniform = [1.0, 15.0] }")?;
/// let settings = [("human.pull".to_owned(), stimulus::Setting::from(2.5))].into();
/// stimulus::apply(&mut data, &settings)?;
/// assert_eq!(data["human"]["pull"].as_float(), Some(2.5));
///
/// let wrong = [("human.pul".to_owned(), stimulus::Setting::from(2.5))].into();
/// let error = stimulus::apply(&mut data, &wrong).unwrap_err();
/// assert_eq!(error.to_string(),
///     "there is no `human.pul` to set (there is `human`); did you mean `pull`?");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StimulusError::UnknownKey`] for a key that the data does not have;
/// [`StimulusError::Unsettable`] for a table, an array, or a value of another kind.
pub fn apply(data: &mut Table, settings: &Settings) -> Result<(), StimulusError> {
    apply_declared(data, settings, &|_| false)
}

/// As [`apply`], but the last part of a key for which `may_be_absent` holds is added when it is
/// missing (an optional value whose default the bench knows).
///
/// # Errors
/// Those of [`apply`].
pub fn apply_declared(
    data: &mut Table,
    settings: &Settings,
    may_be_absent: &dyn Fn(&str) -> bool,
) -> Result<(), StimulusError> {
    let mut changed = data.clone();
    for (key, setting) in settings {
        let path = segments(key).map_err(|problem| StimulusError::unsettable(key, problem))?;
        set(&mut changed, key, &path, setting, may_be_absent(key))?;
    }
    *data = changed;
    Ok(())
}

fn set(
    data: &mut Table,
    key: &str,
    path: &[String],
    setting: &Setting,
    may_be_absent: bool,
) -> Result<(), StimulusError> {
    // `segments` gives at least one part.
    let Some((last, parents)) = path.split_last() else {
        return Ok(());
    };
    let (first, parents) = match parents.split_first() {
        Some((first, rest)) => (first, rest),
        None => return set_in_table(data, key, path, setting, may_be_absent),
    };
    let mut place = match data.get_mut(first) {
        Some(place) => place,
        None => return Err(unknown(key, path, 0, data.keys().map(String::as_str))),
    };
    for (depth, part) in parents.iter().enumerate() {
        place = child(place, key, path, depth + 1, part)?;
    }
    match place {
        Value::Table(table) => set_in_table(table, key, path, setting, may_be_absent),
        _ => replace(child(place, key, path, path.len() - 1, last)?, key, setting),
    }
}

fn set_in_table(
    table: &mut Table,
    key: &str,
    path: &[String],
    setting: &Setting,
    may_be_absent: bool,
) -> Result<(), StimulusError> {
    let last = path.last().map_or("", String::as_str);
    if let Some(value) = table.get_mut(last) {
        return replace(value, key, setting);
    }
    if !may_be_absent {
        let names = table.keys().map(String::as_str);
        return Err(unknown(key, path, path.len() - 1, names));
    }
    table.insert(last.to_owned(), setting.to_toml());
    Ok(())
}

/// The value at `part` of a table or an array.
fn child<'v>(
    place: &'v mut Value,
    key: &str,
    path: &[String],
    depth: usize,
    part: &str,
) -> Result<&'v mut Value, StimulusError> {
    let names = names_in(place);
    let found = match place {
        Value::Table(table) => table.get_mut(part),
        Value::Array(array) => match part.parse::<usize>() {
            Ok(index) => array.get_mut(index),
            Err(_) => array.iter_mut().find(|entry| name_of(entry) == Some(part)),
        },
        _ => None,
    };
    found.ok_or_else(|| unknown(key, path, depth, names.iter().map(String::as_str)))
}

fn name_of(entry: &Value) -> Option<&str> {
    entry.get("name")?.as_str()
}

fn names_in(place: &Value) -> Vec<String> {
    match place {
        Value::Table(table) => table.keys().cloned().collect(),
        Value::Array(array) => {
            let names = array.iter().filter_map(name_of);
            names.map(str::to_owned).collect()
        }
        _ => Vec::new(),
    }
}

fn unknown<'n>(
    key: &str,
    path: &[String],
    depth: usize,
    names: impl IntoIterator<Item = &'n str>,
) -> StimulusError {
    StimulusError::UnknownKey {
        key: key.to_owned(),
        known: path[..depth].join("."),
        similar: similar(&path[depth], names).map(str::to_owned),
    }
}

/// Puts the setting in the place of a value of its kind.
fn replace(value: &mut Value, key: &str, setting: &Setting) -> Result<(), StimulusError> {
    let wrong = |problem: &str| Err(StimulusError::unsettable(key, problem));
    let new = match (&*value, setting) {
        (Value::Boolean(_), Setting::Bool(_)) | (Value::String(_), Setting::Text(_)) => {
            setting.to_toml()
        }
        (Value::Integer(_), Setting::Number(number)) => match setting.as_integer() {
            Some(integer) => Value::Integer(integer),
            // A whole number may be how a real one was written ("mass_kg = 1"): the bench decides.
            None => Value::Float(*number),
        },
        (Value::Float(_), Setting::Number(number)) => Value::Float(*number),
        (Value::Table(table), _) if is_distribution(table) => match setting {
            Setting::Number(number) if !table.contains_key("integer") => Value::Float(*number),
            _ => setting.to_toml(),
        },
        (Value::Table(_), _) => return wrong("it is a table; name one of its values"),
        (Value::Array(_), _) => return wrong("it is an array; add the place of an entry, from 0"),
        (Value::Datetime(_), _) => return wrong("it is a date"),
        (Value::Boolean(_), _) => return wrong("it is true or false"),
        (Value::String(_), _) => return wrong("it is a text"),
        (Value::Integer(_) | Value::Float(_), _) => return wrong("it is a number"),
    };
    *value = new;
    Ok(())
}

/// Whether a table is a distribution: one of its kinds, and nothing that does not belong to one.
fn is_distribution(table: &Table) -> bool {
    let known = |key: &String| KINDS.contains(&key.as_str()) || DETAILS.contains(&key.as_str());
    table.keys().all(known) && table.keys().any(|key| KINDS.contains(&key.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &str = r#"
        steps = 20
        fast = true
        label = "a"
        place_m = [0.0, 1.0, 2.0]
        [human]
        pull = { normal = [1.0, 2.0], low = 0.0 }
        count = { integer = [1, 4] }
        [[body]]
        name = "hip"
        mass_kg = 1.0
        [[body]]
        name = "left.wrist"
        mass_kg = 2.0
    "#;

    fn with(key: &str, setting: impl Into<Setting>) -> Result<Table, StimulusError> {
        let mut data: Table = toml::from_str(DATA).unwrap();
        let settings = Settings::from([(key.to_owned(), setting.into())]);
        apply(&mut data, &settings).map(|()| data)
    }

    #[test]
    fn values_of_each_kind_are_replaced() {
        assert_eq!(with("steps", 30.0).unwrap()["steps"], Value::Integer(30));
        assert_eq!(with("steps", 0.5).unwrap()["steps"], Value::Float(0.5));
        assert_eq!(with("fast", false).unwrap()["fast"], Value::Boolean(false));
        assert_eq!(with("label", "b").unwrap()["label"].as_str(), Some("b"));
        assert_eq!(
            with("place_m.2", 5.0).unwrap()["place_m"][2],
            Value::Float(5.0)
        );
        let human = &with("human.pull", 3.0).unwrap()["human"];
        assert_eq!(human["pull"], Value::Float(3.0));
        let human = &with("human.count", 3.0).unwrap()["human"];
        assert_eq!(human["count"], Value::Integer(3));
    }

    #[test]
    fn entries_of_an_array_are_found_by_place_and_by_name() {
        let by_place = with("body.1.mass_kg", 9.0).unwrap();
        let by_name = with("body.\"left.wrist\".mass_kg", 9.0).unwrap();
        assert_eq!(by_place, by_name);
        assert_eq!(by_name["body"][1]["mass_kg"], Value::Float(9.0));
    }

    #[test]
    fn what_cannot_be_set_is_said() {
        for (key, expected) in [
            ("stepz", "did you mean `steps`?"),
            ("body.hop.mass_kg", "(there is `body`); did you mean `hip`?"),
            ("body.7.mass_kg", "there is no `body.7.mass_kg`"),
            ("human", "it is a table"),
            ("place_m", "it is an array"),
            ("fast", "it is true or false"),
            ("label", "it is a text"),
            ("steps.deeper", "there is no `steps.deeper`"),
            ("steps..deeper", "part between its dots is empty"),
            ("", "part between its dots is empty"),
        ] {
            let error = with(key, 1.0).unwrap_err().to_string();
            assert!(error.contains(expected), "{key}: {error}");
        }
    }

    #[test]
    fn nothing_is_set_if_anything_is_wrong() {
        let mut data: Table = toml::from_str(DATA).unwrap();
        let settings = Settings::from([
            ("steps".to_owned(), 1.0.into()),
            ("unknown".to_owned(), 1.0.into()),
        ]);
        assert!(apply(&mut data, &settings).is_err());
        assert_eq!(data, toml::from_str(DATA).unwrap());
    }

    #[test]
    fn declared_keys_may_be_absent() {
        let mut data: Table = toml::from_str(DATA).unwrap();
        let settings = Settings::from([("human.height_m".to_owned(), 1.8.into())]);
        assert!(apply(&mut data, &settings).is_err());
        apply_declared(&mut data, &settings, &|key| key == "human.height_m").unwrap();
        assert_eq!(data["human"]["height_m"], Value::Float(1.8));
    }
}
