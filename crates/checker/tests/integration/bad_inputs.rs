//! Every file of `conformance/bad` gives the diagnostics that stand in it, on their lines, and no others.
//!
//! A mistake is marked on its line with `// ERROR code`, a suspicion with `// WARNING code`. Mistakes that only exploring
//! finds have the codes of [`code_of`]. A `.props` file names its model in its first line.

use checker::explore::{ExploreError, explore};
use prism_lang::{
    Constants, Diagnostic, Severity, Span, line_and_column, parse_model, parse_properties,
};
use std::path::{Path, PathBuf};

/// Line, severity and code.
type Mark = (usize, Severity, String);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/bad")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn expected(text: &str) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (index, line) in text.lines().enumerate() {
        for (word, severity) in [
            ("// ERROR ", Severity::Error),
            ("// WARNING ", Severity::Warning),
        ] {
            if let Some((_, codes)) = line.split_once(word) {
                marks.extend(
                    codes
                        .split_whitespace()
                        .map(|code| (index + 1, severity, code.to_owned())),
                );
            }
        }
    }
    assert!(!marks.is_empty(), "nothing is marked");
    marks
}

fn marks(text: &str, found: &[Diagnostic]) -> Vec<Mark> {
    let mut marks: Vec<Mark> = found
        .iter()
        .map(|d| mark(text, d.span, d.severity, d.code))
        .collect();
    marks.sort_by(|a, b| (a.0, &a.2).cmp(&(b.0, &b.2)));
    marks
}

fn mark(text: &str, span: Span, severity: Severity, code: &str) -> Mark {
    (
        line_and_column(text, span.start).0,
        severity,
        code.to_owned(),
    )
}

/// What a model's text gives, from reading to exploring; the first stage with an error is the last.
fn found_in_model(text: &str) -> Vec<Mark> {
    let parsed = parse_model(text);
    if parsed.has_errors() {
        return marks(text, &parsed.diagnostics);
    }
    let model = match prism_lang::resolve(&parsed.tree, &Constants::new()) {
        Ok(model) => model,
        Err(found) => return marks(text, &found),
    };
    let mut warnings = parsed.diagnostics;
    warnings.extend(model.warnings.iter().cloned());
    let mut all = marks(text, &warnings);
    if let Err(error) = explore::<f64>(&model) {
        let message = error.to_string();
        assert!(
            message.len() > 30 && message.contains(':'),
            "no remedy: {message}"
        );
        let span = error.span().expect("a place");
        let line = line_and_column(text, span.start).0;
        all.push((line, Severity::Error, code_of(&error).to_owned()));
    }
    all
}

fn code_of(error: &ExploreError) -> &'static str {
    match error {
        ExploreError::OutOfRange { .. } => "out-of-range",
        ExploreError::ProbabilitySum { .. } => "probability-sum",
        ExploreError::NotAProbability { .. } => "not-a-probability",
        ExploreError::NoValue { .. } => "no-value",
        ExploreError::NoInitialState { .. } => "no-initial-state",
        other => panic!("no file of conformance/bad is for {other}"),
    }
}

fn found_in_properties(text: &str) -> Vec<Mark> {
    let first = text.lines().next().unwrap_or("");
    let model = first
        .strip_prefix("// MODEL: ")
        .expect("the first line names the model");
    let model = parse_model(&read(&folder().join(model)));
    let model = prism_lang::resolve(&model.tree, &Constants::new()).expect("the model is right");
    let parsed = parse_properties(text);
    if parsed.has_errors() {
        return marks(text, &parsed.diagnostics);
    }
    match prism_lang::resolve_properties(&parsed.tree, &model, &Constants::new()) {
        // What the checker cannot answer yet.
        Ok(read) => read
            .iter()
            .filter(|p| checker::unsupported(&p.property).is_some())
            .map(|p| mark(text, p.span, Severity::Error, "unsupported"))
            .collect(),
        Err(found) => marks(text, &found),
    }
}

#[test]
fn each_mistake_is_found_on_its_line_and_nothing_else_is() {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder())
        .expect("conformance/bad can be listed")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    assert!(paths.len() >= 18, "only {} files", paths.len());
    let mut failures = Vec::new();
    for path in paths {
        let text = read(&path);
        let is_model = path.extension().is_some_and(|e| e == "prism");
        let found = if is_model {
            found_in_model(&text)
        } else {
            found_in_properties(&text)
        };
        let expected = expected(&text);
        if found != expected {
            let name = path.file_name().unwrap_or_default().display().to_string();
            failures.push(format!(
                "{name}\n  expected {expected:?}\n  found    {found:?}"
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Every error says what to do about it.
#[test]
fn each_error_has_a_remedy() {
    for entry in std::fs::read_dir(folder()).expect("conformance/bad can be listed") {
        let path = entry.expect("an entry").path();
        let text = read(&path);
        let mut found = parse_model(&text).diagnostics;
        if path.extension().is_some_and(|e| e == "props") {
            found = parse_properties(&text).diagnostics;
        } else if found.is_empty() {
            let tree = parse_model(&text).tree;
            found = prism_lang::resolve(&tree, &Constants::new())
                .err()
                .map_or_else(Vec::new, |found| found.to_vec());
        }
        for diagnostic in found {
            let place = format!("{}: {}", path.display(), diagnostic.message);
            assert!(
                diagnostic.remedy.is_some_and(|r| !r.is_empty()),
                "{place} has no remedy"
            );
            assert!(
                diagnostic.span.end <= text.len(),
                "{place} lies outside the text"
            );
        }
    }
}
