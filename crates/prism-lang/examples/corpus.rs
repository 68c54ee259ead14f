//! Reads models and properties of a corpus and counts what parses, resolves and is refused.
//!
//! Each line of the standard input is a run: the model's file, the property file, constants (`a=1,b=0:0.1:1`),
//! constants that are left open (`p,q`), and a model type that replaces the model's, separated by tabs; later
//! parts may be left out. Files are relative to the folder in the environment variable `PRISM_TESTS`.
//!
//! ```text
//! printf 'example.nm\texample.nm.props\n' | PRISM_TESTS=... cargo run -p corroborate-prism-lang --example corpus
//! ```
//!
//! Each line of the output is a property: `resolved`, or `refused` with the reason; the last line counts.

use std::collections::BTreeMap;
use std::io::{BufRead, stdin};
use std::path::{Path, PathBuf};

use prism_lang::ast::{ModelType, PropertyFile};
use prism_lang::resolved::Model;
use prism_lang::{
    Constants, Diagnostic, Experiment, line_and_column, parse_model, parse_properties,
    resolve_open, resolve_properties,
};

fn main() {
    let Some(root) = std::env::var_os("PRISM_TESTS").map(PathBuf::from) else {
        eprintln!("set PRISM_TESTS to the folder of the corpus");
        std::process::exit(2);
    };
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for line in stdin().lock().lines().map_while(Result::ok) {
        for (outcome, detail) in run(&root, &line) {
            println!("{outcome}\t{line}\t{detail}");
            *counts.entry(outcome).or_default() += 1;
        }
    }
    println!("{counts:?}");
}

/// The outcomes of one run: one for each property, or one for all if the files cannot be read.
fn run(root: &Path, line: &str) -> Vec<(&'static str, String)> {
    let parts: Vec<&str> = line.split('\t').collect();
    let part = |i: usize| parts.get(i).copied().unwrap_or("");
    let read = |name: &str| std::fs::read_to_string(root.join(name));
    let (Ok(model), Ok(properties)) = (read(part(0)), read(part(1))) else {
        return vec![("unreadable", "a file cannot be read".to_owned())];
    };
    let first = Experiment::parse(part(2)).map(|e| e.valuations().next().unwrap_or_default());
    let given = match first {
        Ok(given) => given,
        Err(error) => return vec![("bad-constants", error.to_string())],
    };
    let open: Vec<&str> = part(3).split(',').filter(|p| !p.is_empty()).collect();
    let model = match read_model(&model, &given, &open, part(4)) {
        Ok(model) => model,
        Err(outcome) => return vec![outcome],
    };
    let parsed = parse_properties(&properties);
    if parsed.has_errors() {
        return vec![(
            "properties-syntax",
            first_error(&properties, &parsed.diagnostics),
        )];
    }
    let own = given.0.into_iter().filter(|(name, _)| {
        let of_file = parsed.tree.constants.iter().any(|c| c.name.text == *name);
        of_file || model.constant(name).is_some()
    });
    let own = Constants(own.collect());
    let count = parsed.tree.properties.len();
    (0..count)
        .map(|place| one(&properties, &parsed.tree, place, &model, &own))
        .collect()
}

fn read_model(
    text: &str,
    given: &Constants,
    open: &[&str],
    model_type: &str,
) -> Result<Model, (&'static str, String)> {
    let mut parsed = parse_model(text);
    if parsed.has_errors() {
        return Err(("model-syntax", first_error(text, &parsed.diagnostics)));
    }
    let replaced = match model_type {
        "dtmc" => Some(ModelType::Dtmc),
        "mdp" => Some(ModelType::Mdp),
        "ctmc" => Some(ModelType::Ctmc),
        _ => None,
    };
    if let Some(replaced) = replaced {
        parsed.tree.model_type = Some((replaced, prism_lang::Span::default()));
    }
    resolve_open(&parsed.tree, given, &Constants::new(), open)
        .map_err(|found| ("model-refused", first_error(text, &found)))
}

/// The outcome of one property: what it refers to stays, the other properties go.
fn one(
    text: &str,
    file: &PropertyFile,
    place: usize,
    model: &Model,
    given: &Constants,
) -> (&'static str, String) {
    let mut only = file.clone();
    let wanted = only.properties[place].clone();
    let detail = format!("{}\t{}", place + 1, wanted.text.replace(['\n', '\t'], " "));
    only.properties
        .retain(|p| p.span == wanted.span || p.name.is_some());
    match resolve_properties(&only, model, given) {
        Ok(_) => ("resolved", detail),
        Err(found) => {
            let own = |d: &&Diagnostic| {
                wanted.span.start <= d.span.start && d.span.end <= wanted.span.end
            };
            let about: Vec<Diagnostic> = found.iter().filter(own).cloned().collect();
            // Others' mistakes do not count here.
            if about.is_empty() && wanted.name.is_some() {
                return ("resolved", detail);
            }
            let shown = if about.is_empty() { &found[..] } else { &about };
            ("refused", format!("{detail}\t{}", first_error(text, shown)))
        }
    }
}

fn first_error(text: &str, found: &[Diagnostic]) -> String {
    let Some(error) = found.iter().find(|d| d.is_error()) else {
        return String::new();
    };
    let (line, column) = line_and_column(text, error.span.start);
    format!("{line}:{column} [{}] {}", error.code, error.message)
}
