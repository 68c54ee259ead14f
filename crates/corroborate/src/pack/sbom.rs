//! Bills of materials of the system under test, as they are given.
//!
//! # Definition
//! A file is taken if it is JSON that says of itself that it is CycloneDX (`bomFormat`), SPDX 2 (`spdxVersion`) or SPDX 3
//! (`@context` and `@graph`). Nothing else of it is checked: not whether it is complete, nor whether it is of the system that was
//! tested, and the pack says so.

use ::pack::{Content, NotShown, Part, Role};
use diagnostic::{Problem, counted};
use host::files::read_source;
use serde_json::Value;
use std::path::PathBuf;

/// The files as parts.
pub(super) fn parts(files: &[PathBuf], lacks: &mut Vec<NotShown>) -> Result<Vec<Part>, Problem> {
    let say = |words: &str| NotShown {
        of: "the system under test".into(),
        words: words.into(),
    };
    lacks.push(match files.is_empty() {
        true => say("Its software: no bill of materials was given (`--sbom FILE`), so the pack does not say which software was tested."),
        false => say("Its software: the bill of materials is as it was given. Whether it is complete, and of the system that was tested, was not checked."),
    });
    files.iter().enumerate().map(part).collect()
}

fn part((number, file): (usize, &PathBuf)) -> Result<Part, Problem> {
    let source = read_source(file)?;
    let value: Value = serde_json::from_str(&source.text).map_err(|error| {
        let place = offset(&source.text, error.line(), error.column());
        let message = format!("it is not JSON: {error}");
        Problem::new("bad-sbom", message)
            .at(&source, place..place)
            .remedy(REMEDY)
    })?;
    let (kind, components) = kind(&value).ok_or_else(|| {
        let message = format!(
            "{} does not say that it is CycloneDX or SPDX",
            file.display()
        );
        Problem::new("bad-sbom", message).remedy(REMEDY)
    })?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let what = format!(
        "software of the system under test as it was given: {kind}, {}",
        counted(components, "component")
    );
    let name = format!("sbom/{}-{name}", number + 1);
    Ok(Part::new(
        &name,
        Role::Sbom,
        what,
        Content::text(source.text),
    ))
}

const REMEDY: &str =
    "name a CycloneDX or SPDX document in JSON, as syft, trivy or cyclonedx-py write it";

/// The kind of a document with its version, and how many components it names.
fn kind(value: &Value) -> Option<(String, usize)> {
    let text = |key: &str| value.get(key).and_then(Value::as_str);
    let count = |key: &str| value.get(key).and_then(Value::as_array).map_or(0, Vec::len);
    if text("bomFormat") == Some("CycloneDX") {
        return Some((
            format!("CycloneDX {}", text("specVersion")?),
            count("components"),
        ));
    }
    if let Some(version) = text("spdxVersion").and_then(|it| it.strip_prefix("SPDX-")) {
        return Some((format!("SPDX {version}"), count("packages")));
    }
    let context = text("@context")?;
    let is_spdx = context.starts_with("https://spdx.org/rdf/3");
    let graph = value
        .get("@graph")
        .and_then(Value::as_array)
        .filter(|_| is_spdx)?;
    let is_package = |it: &&Value| it.get("type").is_some_and(|it| it == "software_Package");
    Some(("SPDX 3".into(), graph.iter().filter(is_package).count()))
}

fn offset(text: &str, line: usize, column: usize) -> usize {
    let before: usize = text
        .split_inclusive('\n')
        .take(line.saturating_sub(1))
        .map(str::len)
        .sum();
    let mut place = (before + column.saturating_sub(1)).min(text.len());
    while !text.is_char_boundary(place) {
        place -= 1;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documents_are_told_apart_by_what_they_say_of_themselves() {
        let of = |text: &str| kind(&serde_json::from_str(text).expect("JSON"));
        let cyclone = r#"{"bomFormat":"CycloneDX","specVersion":"1.6","components":[{},{}]}"#;
        assert_eq!(of(cyclone), Some(("CycloneDX 1.6".into(), 2)));
        let spdx = r#"{"spdxVersion":"SPDX-2.3","packages":[{}]}"#;
        assert_eq!(of(spdx), Some(("SPDX 2.3".into(), 1)));
        let three = r#"{"@context":"https://spdx.org/rdf/3.0.1/spdx-context.jsonld","@graph":[{"type":"software_Package"},{"type":"Agent"}]}"#;
        assert_eq!(of(three), Some(("SPDX 3".into(), 1)));
        for other in [
            "{}",
            "[]",
            r#"{"bomFormat":"CycloneDX"}"#,
            r#"{"@context":"https://spdx.org/rdf/3"}"#,
            r#"{"spdxVersion":3}"#,
        ] {
            assert_eq!(of(other), None, "{other}");
        }
        assert_eq!(offset("ab\ncd", 2, 2), 4);
        assert_eq!(offset("\u{fc}", 1, 2), 0);
    }
}
