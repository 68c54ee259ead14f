//! Where two values or two texts differ.

use super::audit::Audit;
use diagnostic::Problem;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// Characters of a difference that are shown.
const SHOWN: usize = 60;

/// Holds a claimed value against the expected one; how many leaves are the same.
pub fn values<T: Serialize>(
    file: &Path,
    expected: &T,
    claimed: &T,
    audit: &mut Audit,
) -> Result<u64, Problem> {
    values_at(file, "", expected, claimed, audit)
}

/// The same for a value that stands at a place of its file.
pub fn values_at<T: Serialize>(
    file: &Path,
    place: &str,
    expected: &T,
    claimed: &T,
    audit: &mut Audit,
) -> Result<u64, Problem> {
    let plain = |value: &T| {
        serde_json::to_value(value)
            .map_err(|error| Problem::new("bad-result", format!("{}: {error}", file.display())))
    };
    Ok(differ(
        file,
        place,
        &plain(expected)?,
        &plain(claimed)?,
        audit,
    ))
}

fn differ(file: &Path, place: &str, expected: &Value, claimed: &Value, audit: &mut Audit) -> u64 {
    match (expected, claimed) {
        (Value::Object(a), Value::Object(b)) => {
            let names: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            let sides = |name: &String| (a.get(name), b.get(name));
            let each = names.into_iter().map(|name| {
                let (expected, claimed) = sides(name);
                let name = name.replace('~', "~0").replace('/', "~1");
                either(file, &format!("{place}/{name}"), expected, claimed, audit)
            });
            each.sum()
        }
        (Value::Array(a), Value::Array(b)) => (0..a.len().max(b.len()))
            .map(|i| either(file, &format!("{place}/{i}"), a.get(i), b.get(i), audit))
            .sum(),
        (a, b) if a == b => 1,
        (Value::String(a), Value::String(b)) => {
            let same = same_start(a, b);
            let (a, b) = (around(a, same), around(b, same));
            audit.fault(file, place, format!("it says `{b}`, but `{a}` follows"));
            0
        }
        (a, b) => {
            let fault = format!("it is {}, but {} follows", shown(b), shown(a));
            audit.fault(file, place, fault);
            0
        }
    }
}

fn either(
    file: &Path,
    place: &str,
    expected: Option<&Value>,
    claimed: Option<&Value>,
    audit: &mut Audit,
) -> u64 {
    match (expected, claimed) {
        (Some(expected), Some(claimed)) => differ(file, place, expected, claimed, audit),
        (Some(expected), None) => {
            audit.fault(file, place, format!("it lacks {}", shown(expected)));
            0
        }
        (None, Some(claimed)) => {
            audit.fault(file, place, format!("{} does not follow", shown(claimed)));
            0
        }
        (None, None) => 0,
    }
}

fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Holds a text against the expected one; whether they are the same.
pub fn bytes(file: &Path, expected: &str, found: &str, audit: &mut Audit) -> bool {
    if expected == found {
        return true;
    }
    let same = same_start(expected, found);
    let before = &expected[..same];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    let place = match section(before) {
        Some(id) => format!("line {line}, column {column} (below #{id})"),
        None => format!("line {line}, column {column}"),
    };
    let fault = format!(
        "it says `{}`, but `{}` follows; nothing behind was compared",
        around(found, same),
        around(expected, same)
    );
    audit.fault(file, &place, fault);
    false
}

/// How many bytes two texts have in common at their start.
fn same_start(one: &str, other: &str) -> usize {
    let pairs = one.chars().zip(other.chars());
    let same = pairs.take_while(|(a, b)| a == b);
    same.map(|(a, _)| a.len_utf8()).sum()
}

/// The last element of a page that has an identifier.
fn section(before: &str) -> Option<&str> {
    let start = before.rfind(" id=\"")? + 5;
    before[start..].split('"').next()
}

/// Some of a text about a place.
fn around(text: &str, place: usize) -> String {
    let back = text[..place].chars().rev().take(SHOWN / 3);
    let mut shown: Vec<char> = back.collect();
    shown.reverse();
    shown.extend(text[place..].chars().take(2 * SHOWN / 3));
    let one_line = |c: char| if c.is_control() { ' ' } else { c };
    shown.into_iter().map(one_line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_leaf_that_differs_is_named() {
        let mut audit = Audit::default();
        let expected = json!({"a": [1, 2.5, {"b/c": "x"}], "d": null});
        let claimed = json!({"a": [1, 2.6, {"b/c": "y"}, 7], "e": true});
        let same = values(Path::new("f"), &expected, &claimed, &mut audit).expect("plain values");
        let report = super::super::VerifyReport::new(Path::new("r"), Path::new("s"), audit);
        let places: Vec<&str> = report.faults.iter().map(|f| f.place.as_str()).collect();
        assert_eq!(places, ["/a/1", "/a/2/b~1c", "/a/3", "/d", "/e"]);
        assert_eq!(same, 1);
    }

    #[test]
    fn a_difference_of_texts_has_its_place() {
        let mut audit = Audit::default();
        let expected = "<p id=\"one\">α 12</p>\n<p>β 3</p>";
        let file = Path::new("f");
        assert!(bytes(file, expected, expected, &mut audit));
        assert!(!bytes(
            file,
            expected,
            &expected.replace('3', "4"),
            &mut audit
        ));
        assert!(!bytes(file, expected, &format!("{expected}5"), &mut audit));
        assert!(!bytes(file, expected, &expected[..9], &mut audit));
        let report = super::super::VerifyReport::new(Path::new("r"), Path::new("s"), audit);
        assert_eq!(report.faults[0].place, "line 2, column 6 (below #one)");
        assert_eq!(report.faults.len(), 3);
    }
}
