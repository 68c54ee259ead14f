//! What is read of files of other tools, in numbers: `cargo run --example columns -- FILE...`.
//!
//! `--text NAME` and `--id NAME` before the files name the attributes of text and id. Of FRET's, each sentence is translated and compared with FRET's formulas.

use requirement_files::fret::{Comparison, compare, translated};
use requirement_files::{Change, Columns, Document, Field, File, Format};
use std::path::Path;

fn main() {
    let mut columns = Columns::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        match name.as_str() {
            "--text" => columns
                .fields
                .extend(arguments.next().map(|it| (Field::Text, it))),
            "--id" => columns.id = arguments.next(),
            _ => of_file(&name, &columns),
        }
    }
}

fn of_file(name: &str, columns: &Columns) {
    match read(Path::new(&name), columns) {
        Ok(document) => shown(name, &document),
        Err(problem) => println!("{name}: not read: {}", problem.replace('\n', " ")),
    }
}

fn read(path: &Path, columns: &Columns) -> Result<Document, String> {
    let file = |path: &Path, name: String| -> Result<File, String> {
        let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
        Ok(File { name, bytes })
    };
    let (format, files) = if path.is_dir() {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path).map_err(|error| error.to_string())? {
            let path = entry.map_err(|error| error.to_string())?.path();
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            if requirement_files::is_doorstop_item(&name) {
                files.push(file(&path, name)?);
            }
        }
        files.sort_by(|one, two| one.name.cmp(&two.name));
        (Format::Doorstop, files)
    } else {
        let name = path.display().to_string();
        let format = Format::of_ending(&name).ok_or("its ending is not known")?;
        (format, vec![file(path, name)?])
    };
    Document::read(format, &files, columns).map_err(|problem| problem.to_string())
}

fn shown(name: &str, document: &Document) {
    println!(
        "{name}: {}, {} requirements, fields {:?}",
        document.format.name(),
        document.items.len(),
        document.fields
    );
    for note in &document.notes {
        println!("  {note}");
    }
    println!("  {}", changed(document));
    if document.format == Format::Fret {
        sentences(document);
    }
}

/// Changes the text of every requirement, one after the other: how often the result is refused.
fn changed(document: &Document) -> String {
    let mut refused = Vec::new();
    for placed in &document.items {
        let mut item = placed.item.clone();
        item.text.push_str(" Changed & <kept>.");
        if let Err(problem) = document.with(&[Change::Set(item, vec![Field::Text])]) {
            refused.push(format!("{}: {}", placed.item.id, problem.message()));
        }
    }
    match refused.first() {
        None => "every text can be changed".to_owned(),
        Some(first) => format!("{} texts cannot be changed, first {first}", refused.len()),
    }
}

fn sentences(document: &Document) {
    let mut counts = [0; 7];
    for placed in &document.items {
        let item = &placed.item;
        let translation = match translated(&item.text) {
            Ok(translation) => translation,
            Err(reason) => {
                println!("  {}: no sentence: {reason}", item.id);
                continue;
            }
        };
        counts[0] += 1;
        counts[5] += usize::from(!translation.definitions.is_empty());
        let Some(formulas) = &placed.formulas else {
            println!("  {}: no formulas", item.id);
            continue;
        };
        let meaning = compare(&translation.sentence, formulas, Some(&translation), None);
        for (at, what, comparison) in [
            (1, "runs", &meaning.runs),
            (3, "runs that end", &meaning.ends),
        ] {
            match comparison {
                Comparison::Same { .. } => counts[at] += 1,
                Comparison::Differs(trace) => {
                    counts[at + 1] += 1;
                    println!("  {}: {what}: {}\n    {trace}", item.id, translation.text);
                }
                Comparison::Excuses { trace, .. } => {
                    counts[6] += 1;
                    println!("  {}: {what}: excuses: {trace}", item.id);
                }
                Comparison::NotCompared(reason) => {
                    println!("  {}: {what}: not compared: {reason}", item.id)
                }
            }
        }
        if let Some(probability) = meaning.probability {
            println!("  {}: {probability}", item.id);
        }
    }
    println!(
        "  {} sentences ({} with names for expressions); on runs that go on {} same, {} differ; on runs that end {} same, {} differ, {} excuse what could still come",
        counts[0], counts[5], counts[1], counts[2], counts[3], counts[4], counts[6]
    );
}
