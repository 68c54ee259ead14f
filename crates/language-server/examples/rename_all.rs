//! What the editor does to models, held against what they mean: each name of each file that is named is changed to another and back,
//! the changed text is read and built again, definitions are looked up, and the text is laid out.
//!
//! ```text
//! cargo run --release -p corroborate-language-server --example rename_all -- FILE...
//! ```
//!
//! Models whose states are more than a few thousand, or that need constants, are only read again.

use checker::explore::{ExploreOptions, explore_with};
use language_server::mentions::Thing;
use language_server::{Alone, Workspace, cursor, format, rename};
use prism_lang::names::Role;
use prism_lang::{Constants, parse_model, resolve};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const MODEL: &str = "/models/m.prism";

fn workspace(text: &str) -> Workspace {
    let mut workspace = Workspace::new(Box::new(Alone));
    workspace.open(Path::new(MODEL), text);
    workspace
}

/// States, transitions and labels; of a model that is too large or open, whether it resolves and what is wrong with it.
fn meaning(text: &str) -> String {
    let model = match resolve(&parse_model(text).tree, &Constants::new()) {
        Ok(model) => model,
        Err(found) => {
            let codes: Vec<&str> = found.iter().map(|it| it.code).collect();
            return format!("{codes:?}");
        }
    };
    let options = ExploreOptions {
        max_states: 2_000,
        ..ExploreOptions::default()
    };
    let Ok(space) = explore_with::<f64>(&model, options, &|_| true) else {
        return "resolves".into();
    };
    let states: Vec<Vec<i64>> = (0..space.num_states()).map(|it| space.state(it)).collect();
    let labels = model.labels.iter();
    let labels: Vec<_> = labels.map(|(_, it)| space.evaluate(it).ok()).collect();
    format!("built {} {states:?} {labels:?}", space.num_transitions())
}

#[derive(Default)]
struct Counts {
    models: usize,
    names: usize,
    built: usize,
    places: usize,
    without_definition: usize,
    refused: BTreeMap<String, usize>,
    wrong: Vec<String>,
    laid_out: usize,
}

fn one(path: &str, counts: &mut Counts) {
    let Ok((source, _)) = host::files::read_prism(Path::new(path)) else {
        return;
    };
    let text = source.text;
    if parse_model(&text).has_errors() {
        return;
    }
    counts.models += 1;
    let document = Path::new(MODEL);
    let here = workspace(&text);
    let mentions = cursor::in_file(&here, document);
    let before = meaning(&text);
    let is_defined = |thing: &Thing| {
        mentions
            .iter()
            .any(|it| it.thing == *thing && it.role == Role::Definition)
    };
    let things: BTreeSet<&Thing> = mentions.iter().map(|it| &it.thing).collect();
    counts.places += mentions.len();
    counts.without_definition += mentions.iter().filter(|it| !is_defined(&it.thing)).count();
    for thing in things.into_iter().filter(|it| is_defined(it)) {
        let first = mentions
            .iter()
            .find(|it| it.thing == *thing)
            .expect("a place");
        counts.names += 1;
        let new = "fresh_name_0";
        let places = match rename::rename(&here, document, first.span.start, new) {
            Ok(places) => places,
            Err(why) => {
                let why = why.replace(thing.name(), "NAME");
                *counts.refused.entry(why).or_default() += 1;
                continue;
            }
        };
        let changed = rename::replaced(&text, &places[document], new);
        let after = meaning(&changed);
        counts.built += usize::from(after.starts_with("built"));
        let again = workspace(&changed);
        let at = changed.find(new).expect("the new name");
        let back = rename::rename(&again, document, at, thing.name());
        let back = back.map(|it| rename::replaced(&changed, &it[document], thing.name()));
        if after != before || back.as_deref() != Ok(&text) {
            counts.wrong.push(format!("{path}: {thing:?}"));
        }
    }
    let Ok(edits) = format::edits(&here, document) else {
        return;
    };
    let formatted = edits.first().map_or(text.clone(), |it| it.new_text.clone());
    let comments = |text: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.split_once("//"));
        lines.map(|(_, it)| it.trim_end().to_owned()).collect()
    };
    counts.laid_out += 1;
    if meaning(&formatted) != before || comments(&formatted) != comments(&text) {
        counts.wrong.push(format!("{path}: laid out"));
    }
}

fn main() {
    let mut counts = Counts::default();
    for path in std::env::args().skip(1) {
        one(&path, &mut counts);
    }
    println!(
        "{} models, {} places of names, {} of names without a definition; {} names changed and back ({} built again), {} laid out",
        counts.models,
        counts.places,
        counts.without_definition,
        counts.names,
        counts.built,
        counts.laid_out
    );
    for (why, count) in &counts.refused {
        println!("refused {count} times: {why}");
    }
    println!("wrong: {}", counts.wrong.len());
    counts.wrong.iter().for_each(|it| println!("  {it}"));
}
