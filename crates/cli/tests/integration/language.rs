//! Words that people should not have to read: each phrase here has a standard term, and stays away from messages, help
//! and documents.

use crate::support;
use std::path::Path;
use support::{files_below, read, root, shown};

/// What stands nowhere in a text of the product, and what to write instead.
const NEVER: [(&str, &str); 26] = [
    (" decades", "Bayes factor 10^x"),
    ("had thought of", "unexpected behaviour"),
    ("has thought of", "unexpected behaviour"),
    ("sample is worth", "effective sample size"),
    ("is worth {", "effective sample size {"),
    ("are worth {", "effective sample size {"),
    ("\"Worth \"", "Effective sample size"),
    ("by nothing", "by no evidence"),
    ("It holds (it asks", "is supported"),
    ("for missing it", "one-sided p against rate < x"),
    ("scatter too far", "too heterogeneous to pool"),
    ("set or drawn once", "parameters at their nominal values"),
    ("nobody", "no person, no subscriber, not known"),
    ("was set to the other", "calibrated on the other"),
    ("mended", "fixed"),
    (
        "has no study.toml, so",
        "not a study: x/study.toml does not exist",
    ),
    (
        "not all answers are there",
        "some properties have no result",
    ),
    ("says nothing of", "does not show, is not evidence about"),
    ("say nothing of", "do not show, are not evidence about"),
    ("none that a scheduler", "no scheduler exists for"),
    (
        "count for less where",
        "correlated trials are down-weighted",
    ),
    ("to blame", "causes"),
    ("Nothing is offered", "No proposals"),
    ("Nothing waits", "No undecided comparisons"),
    ("no one of", "none of"),
    ("cannot be told", "is undecided, cannot be derived"),
];

/// Where a phrase is meant: the beginning or the end of the file's name, the words around it, and why.
const ALLOWED: [(&str, &str, &str); 5] = [
    (
        "case-studies/",
        "nobody",
        "no person, in what a study tells of people",
    ),
    (
        "truth/quantity.rs",
        "`nobody` otherwise",
        "a value of the truth `grasped_by`, as scenes record it",
    ),
    (
        "truth/names.rs",
        "nobody",
        "a value of the truth `grasped_by`, as scenes record it",
    ),
    (
        ".md",
        "'nobody'",
        "a value of the truth `grasped_by`, as scenes record it",
    ),
    (
        "simulate-your-robot.md",
        "`nobody`",
        "a value of the truth `grasped_by`, as scenes record it",
    ),
];

/// What may follow "is no": a comparison, not a noun.
const COMPARISONS: [&str; 6] = ["longer", "more", "less", "faster", "nearer", "further"];

/// A text that people read, with the line on which it begins.
struct Text {
    line: usize,
    text: String,
}

#[test]
fn texts_use_standard_terms() {
    let mut found = Vec::new();
    let mut searched = 0;
    for path in files_below(&root()) {
        let name = shown(&path);
        for Text { line, text } in texts(&path, &name) {
            searched += 1;
            for (offset, phrase, instead) in faults(&text) {
                let (from, to) = (offset.saturating_sub(60), offset + phrase.len() + 60);
                let around: String = text
                    .char_indices()
                    .filter(|(at, _)| (from..to).contains(at))
                    .map(|(_, c)| if c == '\n' { ' ' } else { c })
                    .collect();
                if !is_allowed(&name, &around) {
                    let line = line + text[..offset].matches('\n').count();
                    found.push(format!(
                        "{name}:{line}: `{phrase}`; write `{instead}`: {around}"
                    ));
                }
            }
        }
    }
    assert!(searched > 10_000, "only {searched} texts were found");
    assert!(found.is_empty(), "{}\n{}", found.len(), found.join("\n"));
}

#[test]
fn what_is_no_noun_is_found_and_comparisons_are_not() {
    let found = |text: &str| faults(text).len();
    assert_eq!(found("`x` is no number"), 1);
    assert_eq!(found("they are\nno scenes"), 1);
    assert_eq!(found("its formula is none of these"), 1);
    assert_eq!(found("there is no file; it is no longer here"), 0);
    let rust = "// it is no x\nlet a = \"one \\\"two\\\" \\\n   three\"; let b = r#\"x \"y\"\"#; let c = '\"'; \"d\"";
    let texts: Vec<String> = literals(rust).into_iter().map(|it| it.text).collect();
    assert_eq!(texts, ["one \"two\" three", "x \"y\"", "d"]);
}

fn is_allowed(name: &str, around: &str) -> bool {
    let mut allowed = ALLOWED.iter();
    allowed.any(|(file, words, _)| {
        (name.ends_with(file) || name.starts_with(file)) && around.contains(words)
    })
}

/// The texts of a file that people read: a document as a whole, of a source its literals and the help of arguments.
fn texts(path: &Path, name: &str) -> Vec<Text> {
    let is_document = name.ends_with("README.md")
        || (name.starts_with("docs/") && name.ends_with(".md"))
        || ["ARCHITECTURE.md", "CONTRIBUTING.md"].contains(&name)
        || name.ends_with("src/explain/topics.md");
    if is_document {
        return vec![Text {
            line: 1,
            text: read(path),
        }];
    }
    let is_source = name.starts_with("crates/") && name.contains("/src/") && name.ends_with(".rs");
    let is_test = name.ends_with("tests.rs") || name.contains("/tests/");
    if !is_source || is_test {
        return Vec::new();
    }
    let source = read(path);
    let product = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut texts = literals(product);
    if name.starts_with("crates/cli/src/args") {
        let lines = product.lines().enumerate();
        texts.extend(lines.filter_map(|(number, line)| {
            let text = line.trim_start().strip_prefix("///")?.to_owned();
            Some(Text {
                line: number + 1,
                text,
            })
        }));
    }
    texts
}

/// The string literals of a source.
fn literals(source: &str) -> Vec<Text> {
    let bytes = source.as_bytes();
    let (mut at, mut found) = (0, Vec::new());
    while at < bytes.len() {
        let rest = &source[at..];
        let raw = rest
            .strip_prefix('r')
            .filter(|it| it.starts_with(['"', '#']));
        let is_word = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_');
        at += if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(raw) =
            raw.filter(|it| !is_word && it.trim_start_matches('#').starts_with('"'))
        {
            let hashes = raw.len() - raw.trim_start_matches('#').len();
            let close = format!("\"{}", "#".repeat(hashes));
            let begin = 1 + hashes + 1;
            let end = rest[begin..]
                .find(&close)
                .map_or(rest.len(), |end| begin + end);
            found.push(text(source, at, &rest[begin..end]));
            end + close.len()
        } else if let Some(rest) = rest.strip_prefix('"') {
            let end = closing(rest);
            found.push(text(source, at, &unescaped(&rest[..end])));
            end + 2
        } else if let Some(rest) = rest.strip_prefix("'\\") {
            let end = rest.char_indices().skip(1).find(|(_, c)| *c == '\'');
            end.map_or(2, |(end, _)| end + 3)
        } else if rest.starts_with("'\"'") {
            3
        } else {
            rest.chars().next().map_or(1, char::len_utf8)
        };
    }
    found
}

fn text(source: &str, at: usize, text: &str) -> Text {
    Text {
        line: source[..at].matches('\n').count() + 1,
        text: text.to_owned(),
    }
}

/// Where the quotation mark is that closes a literal.
fn closing(rest: &str) -> usize {
    let mut is_escaped = false;
    let end = rest.char_indices().find(|(_, c)| {
        let closes = *c == '"' && !is_escaped;
        is_escaped = *c == '\\' && !is_escaped;
        closes
    });
    end.map_or(rest.len(), |(end, _)| end)
}

/// A literal as it is shown; a continued line is joined.
fn unescaped(literal: &str) -> String {
    let mut text = String::new();
    let mut rest = literal.chars().peekable();
    while let Some(c) = rest.next() {
        match (c, rest.peek()) {
            ('\\', Some('\n')) => while rest.next_if(|c| c.is_whitespace()).is_some() {},
            ('\\', Some('n')) => text.push(rest.next().map_or('\n', |_| '\n')),
            ('\\', Some(_)) => text.extend(rest.next()),
            _ => text.push(c),
        }
    }
    text
}

/// Where a text has a phrase that it should not have, and what to write instead.
fn faults(text: &str) -> Vec<(usize, String, &'static str)> {
    let plain = text.replace('\n', " ");
    let mut found = Vec::new();
    for (phrase, instead) in NEVER {
        let places = plain.match_indices(phrase);
        found.extend(places.map(|(at, _)| (at, phrase.to_owned(), instead)));
    }
    let words: Vec<&str> = plain.split_whitespace().collect();
    let place = |word: &str| word.as_ptr() as usize - plain.as_ptr() as usize;
    for (number, pair) in words.windows(2).enumerate() {
        let before = number.checked_sub(1).map_or("", |before| words[before]);
        let after = words.get(number + 2).copied().unwrap_or_default();
        let follows_there = ["there", "There", "here", "Here"].contains(&before);
        let is_no = match pair[1] {
            "no" => after.starts_with(char::is_lowercase) && !COMPARISONS.contains(&after),
            "none" => true,
            _ => false,
        };
        if ["is", "are", "was", "were", "be"].contains(&pair[0]) && is_no && !follows_there {
            let phrase = format!("{} {} {after}", pair[0], pair[1]);
            found.push((
                place(pair[0]),
                phrase,
                "is not a valid N, must be N (got x)",
            ));
        }
    }
    found
}
