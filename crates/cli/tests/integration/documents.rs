//! What the documents say: every link leads somewhere, and every crate has a README. What they show is run by `snippets.rs`.

use crate::support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use support::{files_below, read, root};

/// All documents that are kept, but the licences of others and what fuzzing found.
fn documents() -> Vec<PathBuf> {
    let root = root();
    let all = files_below(&root).into_iter();
    let documents = all.filter(|path| path.extension().is_some_and(|it| it == "md"));
    // Texts that are built into the program link within the terminal alone.
    let documents = documents.filter(|path| !path.starts_with(root.join("crates/cli/src")));
    documents.collect()
}

#[test]
fn every_relative_link_leads_to_a_file_and_every_anchor_to_a_heading() {
    let mut broken = Vec::new();
    let mut checked = 0;
    for document in documents() {
        let text = read(&document);
        for target in links(&text) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            checked += 1;
            if let Some(reason) = fault(&document, &text, &target) {
                broken.push(format!("{}: {target}: {reason}", document.display()));
            }
        }
    }
    assert!(checked > 60, "only {checked} links were found");
    assert!(broken.is_empty(), "broken links:\n{}", broken.join("\n"));
}

/// Why a link leads nowhere.
fn fault(document: &Path, text: &str, target: &str) -> Option<String> {
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let folder = document.parent().expect("a document lies in a folder");
    let path = match file {
        "" => document.to_owned(),
        file => folder.join(file),
    };
    if !path.exists() {
        return Some("no such file".into());
    }
    if anchor.is_empty() {
        return None;
    }
    let other;
    let text = match file {
        "" => text,
        _ => {
            other = read(&path);
            &other
        }
    };
    (!anchors(text).contains(anchor)).then(|| "no such heading".into())
}

/// The lines of a Markdown text outside blocks of code.
fn lines_of_prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence && !line.starts_with("    ")
    })
}

/// A line without what stands between backquotes.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// The targets of all links and pictures of a Markdown text.
fn links(text: &str) -> Vec<String> {
    let mut targets = Vec::new();
    for line in lines_of_prose(text) {
        let line = without_code(line);
        let behind = line.split("](").skip(1);
        targets.extend(behind.filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())));
    }
    targets
}

/// The names by which the headings of a Markdown text are linked to, as GitHub forms them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = lines_of_prose(text).filter(|line| line.starts_with('#'));
    let mut anchors = BTreeSet::new();
    for heading in headings {
        let heading = heading.trim_start_matches('#').trim();
        let kept = heading
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let name: String = kept.flat_map(char::to_lowercase).collect();
        let name = name.replace(' ', "-");
        let again = (1..).map(|count| format!("{name}-{count}"));
        let mut names = std::iter::once(name.clone()).chain(again);
        let free = names.find(|name| !anchors.contains(name));
        anchors.extend(free);
    }
    anchors
}

/// The example is compiled and run as a test of the crate's documentation, since that begins with the README.
#[test]
fn every_crate_has_a_readme_and_every_library_an_example_in_it() {
    let metadata = support::metadata();
    for package in metadata.workspace_packages() {
        let folder = package
            .manifest_path
            .parent()
            .expect("a folder")
            .as_std_path();
        let readme = read(&folder.join("README.md"));
        let library = folder.join("src/lib.rs");
        if library.exists() {
            let begins = r#"#![doc = include_str!("../README.md")]"#;
            assert!(read(&library).starts_with(begins), "{}", package.name);
            // What Python loads is no library for Rust; its package's tests run the example.
            let is_for_python = package.targets.iter().any(|target| target.is_cdylib());
            let example = if is_for_python {
                "```python\n"
            } else {
                "```rust\n"
            };
            assert!(readme.contains(example), "{}", package.name);
        }
    }
}
