//! What the documents say: every link leads somewhere, and what they show is what the program prints.

use crate::support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use support::program::corroborate;
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

/// A call that a document shows, and what it shows of the output.
#[derive(Debug)]
struct Sample {
    call: String,
    output: Vec<String>,
}

/// What stands in blocks of `console`: a call after `$ `, then its output.
fn samples(text: &str) -> Vec<Sample> {
    let mut samples: Vec<Sample> = Vec::new();
    let mut is_console = false;
    for line in text.lines() {
        match (is_console, line.strip_prefix("$ ")) {
            (_, _) if line.starts_with("```") => is_console = line == "```console",
            (true, Some(call)) => samples.push(Sample {
                call: call.to_owned(),
                output: Vec::new(),
            }),
            (true, None) => samples
                .last_mut()
                .expect("a block of `console` begins with a call")
                .output
                .push(line.to_owned()),
            (false, _) => {}
        }
    }
    samples
}

/// The words of a call; what stands in single quotes is one word.
fn words(call: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for letter in call.chars() {
        match letter {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            other => words.last_mut().expect("a word").push(other),
        }
    }
    words
}

/// Whether a line is the shown one, in which `...` stands for any text.
fn is_line(shown: &str, line: &str) -> bool {
    let parts: Vec<&str> = shown.split("...").collect();
    let [first, middle @ .., last] = parts.as_slice() else {
        return shown == line;
    };
    let Some(mut rest) = line.strip_prefix(first) else {
        return false;
    };
    for part in middle {
        let Some(place) = rest.find(part) else {
            return false;
        };
        rest = &rest[place + part.len()..];
    }
    rest.ends_with(last)
}

/// Whether an output is the shown one, in which a line `...` stands for any lines.
fn is_output(shown: &[String], output: &[&str]) -> bool {
    match shown.split_first() {
        None => output.is_empty(),
        Some((first, rest)) if first == "..." => {
            (0..=output.len()).any(|skipped| is_output(rest, &output[skipped..]))
        }
        Some((first, rest)) => {
            let here = output.split_first();
            here.is_some_and(|(line, more)| is_line(first, line) && is_output(rest, more))
        }
    }
}

#[test]
fn what_the_documents_show_is_what_the_program_prints() {
    let root = root();
    let mut documents = files_below(&root.join("docs"));
    documents.push(root.join("README.md"));
    let mut compared = 0;
    for document in documents {
        if document.extension().is_none_or(|it| it != "md") {
            continue;
        }
        // A user stands in the project, but what the calls make is made elsewhere.
        let folder = tempfile::TempDir::new().expect("a temporary folder");
        for name in ["case-studies", "conformance"] {
            std::os::unix::fs::symlink(root.join(name), folder.path().join(name)).expect("linked");
        }
        for sample in samples(&read(&document)) {
            let words = words(&sample.call);
            let (program, arguments) = words.split_first().expect("a call");
            assert_eq!(
                program,
                "./corroborate",
                "{}: {sample:?}",
                document.display()
            );
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let said = corroborate(folder.path(), &arguments);
            // A number and its unit are held together by a no-break space, which nobody sees in a document.
            let printed = said.out.replace('\u{a0}', " ");
            let output: Vec<&str> = printed.lines().collect();
            assert!(
                is_output(&sample.output, &output),
                "{} shows of `{}`\n\n{}\n\nbut it prints (exit code {})\n\n{}{}",
                document.display(),
                sample.call,
                sample.output.join("\n"),
                said.code,
                said.out,
                said.talk
            );
            compared += 1;
        }
    }
    assert!(compared >= 8, "only {compared} samples were found");
}

#[test]
fn an_output_is_compared_line_by_line() {
    let shown = |lines: &[&str]| -> Vec<String> { lines.iter().map(|it| (*it).into()).collect() };
    let output = ["a 1 s", "b", "c"];
    assert!(is_output(&shown(&["a ... s", "...", "c"]), &output));
    assert!(is_output(&shown(&["...", "b", "c", "..."]), &output));
    assert!(!is_output(&shown(&["a ... s", "b"]), &output));
    assert!(!is_output(&shown(&["a 2 s", "..."]), &output));
    assert!(!is_output(&shown(&["...", "b"]), &output));
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
