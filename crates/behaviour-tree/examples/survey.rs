//! How many published trees are read, how many become a model, and why others do not: one line for each file, then counts.
//!
//! ```text
//! cargo run -p corroborate-behaviour-tree --example survey -- FOLDER ...
//! ```
//!
//! All `.xml` files below the folders whose outermost element is `root` and that define a tree are tried.

use behaviour_tree::{Kind, Leaf, Options, read, to_prism};
use diagnostic::{Problem, Source};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut files = Vec::new();
    for folder in std::env::args().skip(1) {
        below(Path::new(&folder), &mut files)?;
    }
    files.sort();
    let (mut trees, mut models, mut noted, mut whole) = (0, 0, 0, 0);
    let mut refused: BTreeMap<String, usize> = BTreeMap::new();
    for path in files {
        let Ok(text) = std::fs::read_to_string(&path) else {
            continue;
        };
        if !text.contains("<root") || !text.contains("<BehaviorTree") {
            continue;
        }
        let source = Source::new(path.display().to_string(), text);
        trees += 1;
        match tried(&source) {
            Ok((notes, opaque, constants)) => {
                models += 1;
                noted += usize::from(notes > 0);
                whole += usize::from(opaque > 0);
                println!(
                    "{}: {constants} constants, {notes} notes, {opaque} nodes taken whole",
                    source.name
                );
            }
            Err(problem) => {
                println!("{}: {}", source.name, problem.line());
                *refused.entry(problem.message().to_owned()).or_default() += 1;
            }
        }
    }
    println!(
        "{trees} files with trees; {models} become a model, {noted} of them with notes, {whole} with nodes taken whole"
    );
    for (message, count) in refused {
        println!("{count} refused: {message}");
    }
    Ok(())
}

/// Numbers of notes, of nodes taken whole, and of constants.
fn tried(source: &Source) -> Result<(usize, usize, usize), Problem> {
    let mut include = |path: &str, from: &str| {
        let path = Path::new(from).parent().unwrap_or(Path::new("")).join(path);
        let text = std::fs::read_to_string(&path);
        let text = text.map_err(|error| Problem::cannot_read(&path, &error))?;
        Ok(Source::new(path.display().to_string(), text))
    };
    let reading = read(source, None, &mut include)?;
    let model = to_prism(&reading.tree, &Options::default());
    let leaves = reading.tree.leaves();
    let opaque = leaves
        .filter(|(_, it)| it.kind == Kind::Leaf(Leaf::Whole))
        .count();
    Ok((reading.notes.len(), opaque, model.constants.len()))
}

fn below(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            below(&path, files)?;
        } else if path.extension().is_some_and(|it| it == "xml") {
            files.push(path);
        }
    }
    Ok(())
}
