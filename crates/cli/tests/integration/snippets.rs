//! Every command and snippet of the documents is run, or stands on a list with the reason why it is not.
//!
//! The pages are README.md and all of `docs/`. Each block of code in them, fenced or indented, is one of these:
//!
//! | block | is |
//! |---|---|
//! | `console` | calls of the program after `$ `, run, and their output compared; `$ echo $?` shows the exit code of the last |
//! | `sh` | run by a shell, in the page's folder, in the order of the page |
//! | `toml` | read, and its keys held against the schemas of a study's files |
//! | anything else, or what is too long or needs what tests have not | on the list `snippets/not_run.toml`, with its reason |
//!
//! Lines of other blocks that call the program are parsed as its arguments all the same (`crates/cli/src/args/documented.rs`).

use crate::support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::program::{Said, command, said};
use support::schema::violations;
use support::{files_below, read, root, shown};

/// A block of code.
#[derive(Debug)]
struct Block {
    line: usize,
    /// What stands behind the fence; empty for one without a language, and for what is indented.
    language: String,
    text: String,
}

impl Block {
    fn begun(line: usize, language: &str) -> Self {
        Self {
            line,
            language: language.to_owned(),
            text: String::new(),
        }
    }

    fn push(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }
}

/// The blocks of a page: fenced, or indented by four spaces behind an empty line.
fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    // The indentation of the fence that is open.
    let mut fence: Option<usize> = None;
    let (mut was_empty, mut is_indented) = (true, false);
    for (number, line) in (1..).zip(page.lines()) {
        let bare = line.trim_start();
        let indent = line.len() - bare.len();
        let is_code = line.starts_with("    ") && (is_indented || was_empty);
        if let Some(language) = bare.strip_prefix("```") {
            if fence.take().is_none() {
                fence = Some(indent);
                blocks.push(Block::begun(number, language));
            }
            is_indented = false;
        } else if let (Some(indent), Some(block)) = (fence, blocks.last_mut()) {
            block.push(line.get(indent..).unwrap_or_default());
        } else if is_code {
            if !is_indented {
                blocks.push(Block::begun(number, ""));
            }
            is_indented = true;
            blocks.last_mut().expect("it was begun").push(&line[4..]);
        } else if !bare.is_empty() {
            is_indented = false;
        }
        was_empty = bare.is_empty();
    }
    blocks
}

/// A block that is not run.
struct NotRun {
    page: String,
    begins: String,
    reason: String,
}

/// The list.
fn not_run() -> Vec<NotRun> {
    let file = root().join("crates/cli/tests/integration/snippets/not_run.toml");
    let list: toml::Table = read(&file).parse().expect("TOML");
    let entries = list["block"].as_array().expect("a list").iter();
    let text = |entry: &toml::Value, key: &str| entry[key].as_str().expect("a text").to_owned();
    entries
        .map(|entry| NotRun {
            page: text(entry, "page"),
            begins: text(entry, "begins"),
            reason: text(entry, "reason"),
        })
        .collect()
}

/// The pages whose blocks are looked at.
fn pages() -> Vec<PathBuf> {
    let mut pages = files_below(&root().join("docs"));
    pages.push(root().join("README.md"));
    pages.retain(|it| it.extension().is_some_and(|it| it == "md"));
    pages
}

/// What became of a page's blocks.
#[derive(Default)]
struct Counts {
    calls: usize,
    scripts: usize,
    tables: usize,
}

#[test]
fn every_block_of_code_is_run_or_listed_with_a_reason() {
    let list = not_run();
    let mut used = vec![false; list.len()];
    let (mut faults, mut counts) = (Vec::new(), Counts::default());
    for path in pages() {
        let page = shown(&path);
        let folder = scratch();
        let mut last = 0;
        for block in blocks(&read(&path)) {
            let listed = list
                .iter()
                .position(|it| it.page == page && block.text.starts_with(&it.begins));
            if let Some(place) = listed {
                used[place] = true;
                continue;
            }
            let found = run(&block, folder.path(), &mut last, &mut counts);
            if let Err(fault) = found {
                faults.push(format!("{page}:{}: {fault}", block.line));
            }
        }
    }
    faults.extend(faults_of_list(&list, &used));
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
    let Counts {
        calls,
        scripts,
        tables,
    } = counts;
    let found = format!("{calls} calls, {scripts} scripts, {tables} pieces of TOML");
    assert!(calls >= 40 && scripts >= 8 && tables >= 10, "{found}");
    eprintln!("{found}; {} blocks or pages are listed", list.len());
}

/// Entries that name no block, or have no reason.
fn faults_of_list(list: &[NotRun], used: &[bool]) -> Vec<String> {
    let unused = list.iter().zip(used).filter(|(_, used)| !**used);
    let unused = unused.map(|(it, _)| {
        format!(
            "{}: no block begins with {:?}: take it off the list",
            it.page, it.begins
        )
    });
    let bare = list.iter().filter(|it| it.reason.len() < 20);
    let bare = bare.map(|it| format!("{}: {:?} has no reason", it.page, it.begins));
    unused.chain(bare).collect()
}

/// A user stands in the project, but what the calls make is made elsewhere.
fn scratch() -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    for name in ["case-studies", "conformance"] {
        std::os::unix::fs::symlink(root().join(name), folder.path().join(name)).expect("linked");
    }
    let program = env!("CARGO_BIN_EXE_corroborate");
    std::os::unix::fs::symlink(program, folder.path().join("corroborate")).expect("linked");
    folder
}

/// Runs a block; with the exit code of the last call.
fn run(block: &Block, folder: &Path, last: &mut i32, counts: &mut Counts) -> Result<(), String> {
    match block.language.as_str() {
        "console" => {
            for sample in samples(&block.text)? {
                counts.calls += 1;
                sample.compare(folder, last)?;
            }
            Ok(())
        }
        "sh" => {
            counts.scripts += 1;
            script(&block.text, folder)
        }
        "toml" => {
            counts.tables += 1;
            table(&block.text)
        }
        other => Err(format!(
            "a block of `{other}` is not run; make it `console`, `sh` or `toml`, or list it in snippets/not_run.toml with the reason:\n{}",
            block.text
        )),
    }
}

/// Who reads a page has allowed no study to run programs but their own.
fn as_reader<'c>(command: &'c mut Command, folder: &Path) -> &'c mut Command {
    command
        .env("CORROBORATE_TRUST", "")
        .env("XDG_STATE_HOME", folder.join(".state"))
}

/// A shell keeps its functions for the page's next blocks, as a reader's does.
fn script(text: &str, folder: &Path) -> Result<(), String> {
    let before = folder.join(".functions");
    let kept = std::fs::read_to_string(&before).unwrap_or_default();
    let mut command = Command::new("bash");
    command
        .args([
            "-eu",
            "-c",
            &format!("{kept}\n{text}\ndeclare -f > .functions"),
        ])
        .current_dir(folder)
        .env("CORROBORATE_MUJOCO", "");
    let said = said(as_reader(&mut command, folder));
    match said.code {
        0 => Ok(()),
        code => Err(format!(
            "exit code {code} of\n{text}\n{}{}",
            said.out, said.talk
        )),
    }
}

/// The files of a study by the table with which a piece of one begins.
const KINDS: [(&str, &str); 9] = [
    ("evidence", "ledger"),
    ("requirement", "requirements"),
    ("failure_mode", "requirements"),
    ("simulation", "scene"),
    ("person", "scene"),
    ("robot", "scene"),
    ("group", "scene"),
    ("trajectory", "scene"),
    ("gripper", "scene"),
];

/// A piece of TOML can be read, and what it says is as the schema of its file has it. What the piece leaves out is not missing.
fn table(text: &str) -> Result<(), String> {
    let read_text: toml::Table = text.parse().map_err(|error| format!("{error}\n{text}"))?;
    let kind = read_text
        .keys()
        .find_map(|key| KINDS.iter().find(|(name, _)| name == key));
    let Some((_, file)) = kind else {
        return Err(format!(
            "which file of a study it is of is not known:\n{text}"
        ));
    };
    let schema = read(&root().join(format!("schemas/study/{file}.schema.json")));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    let value = serde_json::to_value(&read_text).expect("TOML as JSON");
    let faults = violations(&schema, &value).into_iter();
    let faults: Vec<String> = faults.filter(|it| !it.contains(" is missing")).collect();
    match faults.is_empty() {
        true => Ok(()),
        false => Err(format!("{}\nin\n{text}", faults.join("\n"))),
    }
}

/// A call that a document shows, and what it shows of the output.
#[derive(Debug)]
struct Sample {
    call: String,
    output: Vec<String>,
}

/// What stands in a block of `console`: a call after `$ `, then its output.
fn samples(text: &str) -> Result<Vec<Sample>, String> {
    let mut samples: Vec<Sample> = Vec::new();
    for line in text.lines() {
        match (line.strip_prefix("$ "), samples.last_mut()) {
            (Some(call), _) => samples.push(Sample {
                call: call.to_owned(),
                output: Vec::new(),
            }),
            (None, Some(sample)) => sample.output.push(line.to_owned()),
            (None, None) => return Err("a block of `console` begins with `$ `".into()),
        }
    }
    Ok(samples)
}

impl Sample {
    /// Runs the call, and compares what it prints.
    fn compare(&self, folder: &Path, last: &mut i32) -> Result<(), String> {
        let shown = self.output.join("\n");
        if self.call == "echo $?" {
            return match shown == last.to_string() {
                true => Ok(()),
                false => Err(format!("the exit code is {last}, shown is {shown}")),
            };
        }
        let words = words(&self.call);
        let (program, arguments) = words.split_first().expect("a call");
        if program != "./corroborate" {
            return Err(format!(
                "a call in `console` is `./corroborate ...` or `echo $?`, not {}",
                self.call
            ));
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let Said { code, out, talk } = said(as_reader(&mut command(folder, &arguments), folder));
        *last = code;
        // A number and its unit are held together by a no-break space, which is not seen in a document.
        let printed = out.replace('\u{a0}', " ");
        let output: Vec<&str> = printed.lines().collect();
        match is_output(&self.output, &output) {
            true => Ok(()),
            false => Err(format!(
                "shown of `{}`\n\n{shown}\n\nbut it prints (exit code {code})\n\n{out}{talk}",
                self.call
            )),
        }
    }
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
fn an_output_is_compared_line_by_line() {
    let shown = |lines: &[&str]| -> Vec<String> { lines.iter().map(|it| (*it).into()).collect() };
    let output = ["a 1 s", "b", "c"];
    assert!(is_output(&shown(&["a ... s", "...", "c"]), &output));
    assert!(is_output(&shown(&["...", "b", "c", "..."]), &output));
    assert!(!is_output(&shown(&["a ... s", "b"]), &output));
    assert!(!is_output(&shown(&["a 2 s", "..."]), &output));
    assert!(!is_output(&shown(&["...", "b"]), &output));
}

#[test]
fn blocks_are_found_fenced_and_indented() {
    let page = "text\n\n    a\n\n      b\n\n* item\n    no block\n\n   ```toml\n   x = 1\n   ```\n```console\n$ c\n```\n";
    let found: Vec<(usize, String, String)> = blocks(page)
        .into_iter()
        .map(|it| (it.line, it.language, it.text))
        .collect();
    let block = |line, language: &str, text: &str| (line, language.to_owned(), text.to_owned());
    let expected = [
        block(3, "", "a\n  b\n"),
        block(10, "toml", "x = 1\n"),
        block(13, "console", "$ c\n"),
    ];
    assert_eq!(found, expected);
}
