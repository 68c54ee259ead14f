//! Every call of the program that a document or a help text shows is one that the program understands, whether or not a test
//! runs it.

use super::{Arguments, with_peers_spelling};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The Markdown files below a folder.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|it| it == "md") {
            found.push(path);
        }
    }
}

/// The calls in a text, each with its line: lines of code, and of examples in a help text, that begin with the program's name.
fn calls(text: &str) -> Vec<(usize, Vec<String>)> {
    let mut calls = Vec::new();
    let mut is_fenced = false;
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        is_fenced ^= line.trim_start().starts_with("```");
        let code = line.trim_start();
        let code = code.strip_prefix("$ ").unwrap_or(code);
        let code = code.strip_prefix("./").unwrap_or(code);
        if !code.starts_with("corroborate ") || !(is_fenced || line.starts_with("  ")) {
            continue;
        }
        let mut call = code.to_owned();
        while call.ends_with('\\') {
            call.pop();
            let Some((_, more)) = lines.next() else { break };
            call.push_str(more.trim_start());
        }
        // What other programs get, and what a file takes, is not ours.
        for one in call.split(" && ") {
            let one = one.split(" | ").next().unwrap_or_default();
            // Which exit codes are expected; in a property two bars mean something else.
            let one = one.split(" || [ ").next().unwrap_or_default();
            let one = one.strip_prefix("./").unwrap_or(one);
            if one.starts_with("corroborate ") {
                calls.push((number + 1, words(one)));
            }
        }
    }
    calls
}

/// The words of a call up to a comment, a redirection, or the two blanks behind which a help text says what it does.
fn words(call: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    let mut letters = call.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, quote) {
            ('\'' | '"', None) => quote = Some(letter),
            (_, Some(open)) if letter == open => quote = None,
            (' ', None) if letters.peek() == Some(&' ') => break,
            (' ', None) => words.push(std::mem::take(&mut word)),
            ('#' | '>', None) if word.is_empty() => break,
            _ => word.push(letter),
        }
    }
    words.push(word);
    words.retain(|it| !it.is_empty());
    words
}

/// The documents and the help texts, each with its name.
fn texts() -> Vec<(String, String)> {
    let mut texts: Vec<(String, String)> = Vec::new();
    let mut found = vec![root().join("README.md"), root().join("ci/README.md")];
    for folder in [
        "docs",
        "case-studies",
        "clients",
        "integrations",
        "crates/cli/src/explain",
    ] {
        pages(&root().join(folder), &mut found);
    }
    // Made of the help texts, which are read below, and of usage lines, in which words stand for others.
    found.retain(|it| !it.ends_with("reference/commands.md"));
    for path in found {
        let text = std::fs::read_to_string(&path).expect("a page");
        texts.push((path.display().to_string(), text));
    }
    for command in Arguments::command().get_subcommands() {
        let help = command.get_after_help().map(ToString::to_string);
        texts.push((
            format!("{} --help", command.get_name()),
            help.unwrap_or_default(),
        ));
    }
    texts
}

#[test]
fn every_call_that_is_shown_is_understood() {
    let (mut count, mut faults) = (0, Vec::new());
    for (name, text) in texts() {
        for (line, words) in calls(&text) {
            count += 1;
            let arguments = with_peers_spelling(words.iter().map(OsString::from));
            let Err(error) = Arguments::try_parse_from(arguments) else {
                continue;
            };
            if ![ErrorKind::DisplayHelp, ErrorKind::DisplayVersion].contains(&error.kind()) {
                faults.push(format!("{name}:{line}: {words:?}: {error}"));
            }
        }
    }
    assert!(count > 200, "only {count} calls were found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_call_is_found_with_its_words() {
    let text = "corroborate in prose\n    corroborate run 'my study' # it\n```sh\n./corroborate check m.prism \\\n  \"P=? [ F x ]\" > out && corroborate plan s | head\ncorroborate run s || [ $? = 1 ]\n```\n";
    let found: Vec<Vec<String>> = calls(text).into_iter().map(|(_, words)| words).collect();
    assert_eq!(
        found,
        [
            vec!["corroborate", "run", "my study"],
            vec!["corroborate", "check", "m.prism", "P=? [ F x ]"],
            vec!["corroborate", "plan", "s"],
            vec!["corroborate", "run", "s"],
        ]
    );
}
