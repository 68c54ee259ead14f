//! `corroborate explain`: what a diagnostic, a verdict or a word means.
//!
//! The texts stand in `explain/topics.md`, one second-level heading for each
//! topic; a first-level heading groups topics in the list.

use crate::args::Explain;
use crate::command::Done;
use corroborate::Outcome;
use diagnostic::{Problem, did_you_mean};

const TOPICS: &str = include_str!("explain/topics.md");

struct Topic<'a> {
    name: &'a str,
    group: &'a str,
    text: &'a str,
}

/// Explains a topic, or lists all.
pub fn explain(arguments: &Explain) -> Result<Done, Problem> {
    let topics = topics();
    let output = match &arguments.topic {
        None => list(&topics),
        Some(name) => {
            let wanted = name.trim_matches(|c| c == '[' || c == ']').to_lowercase();
            let wanted = wanted.replace([' ', '_'], "-");
            let topic = named(&topics, &wanted).ok_or_else(|| {
                let problem = Problem::new("unknown-topic", format!("there is no topic `{name}`"));
                let speaking = speaking_of(&topics, name);
                match did_you_mean(&wanted, topics.iter().map(|t| t.name)) {
                    Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                    None if !speaking.is_empty() => problem.remedy(format!(
                        "these speak of it: {}; `corroborate explain` lists all topics",
                        speaking.join(", ")
                    )),
                    None => problem.remedy("`corroborate explain` lists all topics"),
                }
            })?;
            format!("{}\n\n{}\n", topic.name, topic.text)
        }
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

/// The topic of this name, in the singular or the plural.
fn named<'a, 't>(topics: &'a [Topic<'t>], wanted: &str) -> Option<&'a Topic<'t>> {
    let find = |name: &str| topics.iter().find(|topic| topic.name == name);
    let singular = || find(wanted.strip_suffix('s')?);
    (find(wanted).or_else(|| find(&format!("{wanted}s")))).or_else(singular)
}

/// Most topics that are named for a word that is none.
const MOST_SPEAKING: usize = 4;

/// The topics in whose texts a word stands, those that have it most often first.
fn speaking_of<'t>(topics: &[Topic<'t>], word: &str) -> Vec<&'t str> {
    let word = word.trim().to_lowercase();
    if word.is_empty() {
        return Vec::new();
    }
    let times = |topic: &Topic| topic.text.to_lowercase().matches(&word).count();
    let counted = topics.iter().map(|topic| (times(topic), topic.name));
    let mut found: Vec<(usize, &str)> = counted.filter(|(times, _)| *times > 0).collect();
    found.sort_by_key(|(times, _)| std::cmp::Reverse(*times));
    found.truncate(MOST_SPEAKING);
    found.into_iter().map(|(_, name)| name).collect()
}

/// What a code or word means.
pub fn text(name: &str) -> Option<String> {
    let topics = topics();
    let topic = topics.iter().find(|it| it.name == name)?;
    Some(topic.text.to_owned())
}

fn list(topics: &[Topic]) -> String {
    let mut output = String::new();
    let mut group = "";
    for topic in topics {
        if topic.group != group {
            group = topic.group;
            output.push_str(&format!("\n{group}\n"));
        }
        let first = topic.text.split_inclusive(['.', ':']).next().unwrap_or("");
        let first = first.replace('\n', " ");
        output.push_str(&format!(
            "  {:<29} {}\n",
            topic.name,
            first.trim_end_matches(':')
        ));
    }
    output.trim_start().to_owned()
}

fn topics() -> Vec<Topic<'static>> {
    let mut group = "";
    let mut topics = Vec::new();
    for part in TOPICS.split("\n#").map(|part| part.trim_start_matches('#')) {
        // After the split, a second-level heading begins with one `#` less.
        let (heading, text) = part.split_once('\n').unwrap_or((part, ""));
        let heading = heading.trim();
        if text.trim().is_empty() {
            group = heading;
        } else {
            topics.push(Topic {
                name: heading,
                group,
                text: text.trim(),
            });
        }
    }
    topics
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn a_word_that_is_no_topic_names_those_that_speak_of_it() {
        let said = |topic: &str| {
            let problem = explain(&Explain {
                topic: Some(topic.into()),
            });
            problem.expect_err("no topic").to_string()
        };
        let found = said("Wilson");
        assert!(found.contains("these speak of it: "), "{found}");
        assert!(!said("zxqv").contains("speak of it"));
    }

    /// The report says "step" of what the topic `steps` explains.
    #[test]
    fn a_topic_is_found_in_the_singular_and_in_the_plural() {
        let topics = topics();
        let found = |word: &str| named(&topics, word).map(|topic| topic.name);
        assert_eq!(found("step"), Some("steps"));
        assert_eq!(found("margins"), Some("margin"));
        assert_eq!(found("corroborated"), Some("corroborated"));
        assert_eq!(found("zxqv"), None);
    }

    fn source_files(folder: &Path, files: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                source_files(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(std::fs::read_to_string(&path).expect("a source file"));
            }
        }
    }

    /// Codes as they stand in calls such as `Problem::new("code", …)`.
    fn codes(folder: &str, calls: &[&str]) -> BTreeSet<String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files = Vec::new();
        source_files(&root, &mut files);
        let mut codes = BTreeSet::new();
        for file in &files {
            let tested = file.split("#[cfg(test)]").next().unwrap_or(file);
            for call in calls {
                for rest in tested.split(call).skip(1) {
                    let rest = rest.trim_start();
                    if let Some(code) = rest.strip_prefix('"').and_then(|r| r.split('"').next()) {
                        codes.insert(code.to_owned());
                    }
                }
            }
        }
        codes
    }

    /// What makes a diagnostic in any crate: its code is the first argument, or a constant.
    const CALLS: [&str; 11] = [
        "Problem::new(",
        "raised_input(",
        "data_lost(",
        "undecided(",
        ".problem(",
        "Diagnostic::error(",
        "Diagnostic::warning(",
        ".error(",
        ".warning(",
        "declared(source,",
        "CODE: &str =",
    ];

    #[test]
    fn every_code_of_a_diagnostic_is_explained() {
        let known: BTreeSet<&str> = topics().iter().map(|t| t.name).collect();
        let mut used = BTreeSet::new();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        for entry in std::fs::read_dir(root).expect("the crates").flatten() {
            let folder = format!("../{}/src", entry.file_name().to_string_lossy());
            used.extend(codes(&folder, &CALLS));
        }
        let of_code = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        // Other first arguments have spaces.
        used.retain(|code| !code.is_empty() && code.chars().all(of_code));
        // One of each kind of call, so that none of them is looked for in vain.
        for code in [
            "bad-ledger",
            "syntax",
            "never-enabled",
            "memory-limit",
            "bad-calibration-file",
        ] {
            assert!(used.contains(code), "{code} is not found any more");
        }
        assert!(used.len() > 30, "codes are not found any more: {used:?}");
        let missing: Vec<_> = used
            .iter()
            .filter(|c| !known.contains(c.as_str()))
            .collect();
        assert!(missing.is_empty(), "topics.md does not explain {missing:?}");
    }

    #[test]
    fn topics_are_grouped_and_unique() {
        let topics = topics();
        let names: BTreeSet<_> = topics.iter().map(|t| t.name).collect();
        assert_eq!(names.len(), topics.len());
        assert!(topics.iter().all(|t| !t.group.is_empty()));
    }
}
