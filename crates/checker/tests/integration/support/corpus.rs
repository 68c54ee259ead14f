//! The models of `conformance/models` with the values of their properties, as its README says.

use checker::explore::explore;
use prism_lang::{Arithmetic, Constants, NamedProperty};
use std::path::{Path, PathBuf};

use super::value::Expected;

pub fn models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../conformance/models");
    let entries = std::fs::read_dir(&folder).expect("conformance/models can be listed");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "prism"));
    paths.sort();
    assert!(paths.len() >= 20, "only {} models", paths.len());
    paths
}

/// A property with the values of constants for which its result is known.
pub struct Case {
    pub model: PathBuf,
    pub place: String,
    pub constants: String,
    pub property: NamedProperty,
    pub expected: Expected,
    /// Whether PRISM's stopping rule is stated to be off here.
    pub off: bool,
    /// Whether all iterations without bounds are, however late they stop.
    pub estimates_off: bool,
}

/// All cases of a model, and the values of constants they use.
pub fn cases(model: &Path) -> Vec<Case> {
    let path = model.with_extension("props");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let parsed = prism_lang::parse_properties(&text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{}: {:?}",
        path.display(),
        parsed.diagnostics
    );
    let mut cases = Vec::new();
    let mut from = 0;
    let places: Vec<usize> = parsed
        .tree
        .properties
        .iter()
        .map(|p| p.span.start)
        .collect();
    for (index, place) in places.into_iter().enumerate() {
        let notes = &text[from..place];
        from = place;
        let line = text[..place].lines().count() + 1;
        let results = noted(notes, "RESULT");
        assert!(!results.is_empty(), "{}:{line}: no RESULT", path.display());
        let off = noted(notes, "PRISM-DEFAULT");
        let estimates_off = noted(notes, "ESTIMATES");
        for (constants, value) in results {
            let file = path.file_name().and_then(|n| n.to_str()).unwrap_or("?");
            cases.push(Case {
                model: model.to_owned(),
                place: format!("{file}:{line} ({constants})"),
                off: off.iter().any(|(c, _)| *c == constants),
                estimates_off: estimates_off.iter().any(|(c, _)| *c == constants),
                property: property_of(model, &parsed.tree, &constants, index),
                expected: Expected::parse(&value).unwrap_or_else(|e| panic!("{file}:{line}: {e}")),
                constants,
            });
        }
    }
    assert!(!cases.is_empty(), "{} has no properties", path.display());
    cases
}

pub fn property_of(
    model: &Path,
    tree: &prism_lang::ast::PropertyFile,
    constants: &str,
    index: usize,
) -> NamedProperty {
    let given = Constants::parse(constants).expect("constants in a RESULT line");
    let resolved = resolved(model, constants);
    let mut all = prism_lang::resolve_properties(tree, &resolved, &given)
        .unwrap_or_else(|found| panic!("{}: {found:?}", model.display()));
    all.swap_remove(index)
}

/// The lines `// KEY (constants): value` of a comment.
pub fn noted(comment: &str, key: &str) -> Vec<(String, String)> {
    let lines = comment
        .lines()
        .filter_map(|line| line.trim().strip_prefix("// "));
    lines
        .filter_map(|line| line.strip_prefix(key))
        .filter_map(|rest| match rest.strip_prefix(" (") {
            Some(rest) => rest.split_once("): "),
            None => rest.strip_prefix(": ").map(|value| ("", value)),
        })
        .map(|(constants, value)| (constants.to_owned(), value.trim().to_owned()))
        .collect()
}

pub fn resolved(model: &Path, constants: &str) -> prism_lang::resolved::Model {
    let text = std::fs::read_to_string(model).expect("the model can be read");
    let parsed = prism_lang::parse_model(&text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{}: {:?}",
        model.display(),
        parsed.diagnostics
    );
    let given = Constants::parse(constants).expect("constants in a RESULT line");
    prism_lang::resolve(&parsed.tree, &given)
        .unwrap_or_else(|found| panic!("{}: {found:?}", model.display()))
}

/// Runs every case of every model with the state space in the domain `N`, and reports all failures together.
pub fn for_all<N: Arithmetic>(
    judge: impl Fn(&checker::state_space::StateSpace<N>, &Case) -> Result<(), String>,
) {
    let (mut failures, mut count) = (Vec::new(), 0);
    for model in models() {
        let mut last = None;
        for case in cases(&model) {
            if last
                .as_ref()
                .is_none_or(|(constants, _)| *constants != case.constants)
            {
                let space = explore::<N>(&resolved(&model, &case.constants));
                let space = space.unwrap_or_else(|error| panic!("{}: {error}", case.place));
                last = Some((case.constants.clone(), space));
            }
            let Some((_, space)) = &last else { continue };
            count += 1;
            if let Err(reason) = judge(space, &case) {
                failures.push(format!("{}: {}: {reason}", case.place, case.property.text));
            }
        }
    }
    assert!(count > 150, "only {count} cases were found");
    assert!(
        failures.is_empty(),
        "{} of {count} cases:\n{}",
        failures.len(),
        failures.join("\n")
    );
}
