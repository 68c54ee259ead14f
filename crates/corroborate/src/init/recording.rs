//! A study drafted from a recording: its signals, and requirements with the ranges that it shows.

mod ranges;

use super::draft::{comment, file_name, filled, plain, quoted, rounded};
use super::{Content, Draft, NewFile};
use diagnostic::Problem;
use ranges::Seen;
use recording::{InspectOptions, Inspection, OpenOptions};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What is larger is not copied but linked to.
const MOST_COPIED: u64 = 64 << 20;

/// Signals about which a draft has requirements.
const MOST_SIGNALS: usize = 4;

/// The texts of `templates/from-recording`.
const TEXTS: [(&str, &str); 7] = [
    (
        "README.md",
        include_str!("../../templates/from-recording/README.md"),
    ),
    (
        "study.toml",
        include_str!("../../templates/from-recording/study.toml"),
    ),
    (
        "parameters.toml",
        include_str!("../../templates/from-recording/parameters.toml"),
    ),
    (
        "vocabulary.toml",
        include_str!("../../templates/from-recording/vocabulary.toml"),
    ),
    (
        "requirements.toml",
        include_str!("../../templates/from-recording/requirements.toml"),
    ),
    (
        "topics.toml",
        include_str!("../../templates/from-recording/topics.toml"),
    ),
    (
        "ledger.toml",
        include_str!("../../templates/from-recording/ledger.toml"),
    ),
];

/// A draft of a study that judges a recording.
///
/// # Errors
/// `bad-recording` as `inspect` says it; `nothing-to-draft` if no number in it changes.
pub(super) fn draft(file: &Path) -> Result<Draft, Problem> {
    let bad = |error: recording::ReadError| Problem::new("bad-recording", error.to_string());
    let opening = OpenOptions::default();
    let found = recording::inspect(file, &opening, &InspectOptions::default()).map_err(bad)?;
    let signals = signals(&found, ranges::of(file, &opening, &found).map_err(bad)?);
    if signals.is_empty() {
        let message = format!(
            "no number in {} changes, so there is nothing to draft a requirement of",
            comment(&file.to_string_lossy())
        );
        return Err(Problem::new("nothing-to-draft", message)
            .remedy("`corroborate inspect` shows what is in it; `corroborate init DIR --template recordings` is a study to begin with"));
    }
    let (copy, is_copied) = kept(file)?;
    let name = file_name(file);
    let values = [
        ("FILE", name.clone()),
        ("TITLE", quoted(&format!("A draft about {name}"))),
        ("KEPT", comment(&copy.path.to_string_lossy())),
        ("PARAMETERS", each(&signals, parameters)),
        ("WORDS", each(&signals, word)),
        ("REQUIREMENTS", each(&signals, requirement)),
        ("SIGNALS", each(&signals, signal)),
        ("ALL", all(&found)),
    ];
    let values: Vec<(&str, &str)> = values
        .iter()
        .map(|(name, value)| (*name, value.as_str()))
        .collect();
    let texts = TEXTS
        .iter()
        .map(|(path, text)| NewFile::text(*path, filled(text, &values)));
    let how = if is_copied {
        "copied to"
    } else {
        "linked to from"
    };
    let mut notes = vec![format!(
        "the recording is {how} {}",
        comment(&copy.path.to_string_lossy())
    )];
    if !found.complete {
        notes.push(
            "something of the recording could not be read: `corroborate inspect` says what".into(),
        );
    }
    Ok(Draft {
        is: format!("a draft that judges {name}"),
        files: texts
            .chain([NewFile::text(".gitignore", "results/\n"), copy])
            .collect(),
        notes,
    })
}

/// A signal of a draft.
struct Drafted {
    name: String,
    seen: Seen,
}

/// Those with a unit first, then in the recording's order; names that predicates can have.
fn signals(found: &Inspection, mut seen: Vec<Seen>) -> Vec<Drafted> {
    seen.retain(|signal| signal.low < signal.high);
    seen.sort_by_key(|signal| signal.unit.is_empty());
    let several = found.topics.len() > 1;
    let mut taken = BTreeSet::new();
    let drafted = seen.into_iter().take(MOST_SIGNALS).map(|seen| Drafted {
        name: plain(&short(&seen, several), &mut taken).to_lowercase(),
        seen,
    });
    drafted.collect()
}

/// What a signal is called: the last parts of its topic and of its path.
fn short(seen: &Seen, several: bool) -> String {
    let topic = seen.topic.rsplit('/').next().unwrap_or_default();
    let field = seen.path.rsplit('.').next().unwrap_or(&seen.path);
    match (several, field) {
        (false, _) => field.to_owned(),
        (true, "data") => topic.to_owned(),
        (true, _) => format!("{topic}_{field}"),
    }
}

fn each(signals: &[Drafted], one: fn(&Drafted) -> String) -> String {
    signals.iter().map(one).collect()
}

/// Its unit after a number, if it has one.
fn unit(of: &Drafted) -> String {
    match of.seen.unit.is_empty() {
        true => String::new(),
        false => format!(" {}", of.seen.unit),
    }
}

fn shown(of: &Drafted) -> String {
    comment(&format!("{}.{}", of.seen.topic, of.seen.path))
}

fn parameters(of: &Drafted) -> String {
    let (low, high) = (outwards(of.seen.low, false), outwards(of.seen.high, true));
    let (unit, name) = (unit(of), &of.name);
    let meaning = |which: &str| {
        quoted(&format!(
            "DRAFT: the {which} value of {} that is allowed.",
            shown(of)
        ))
    };
    format!(
        "\n# Seen in the recording: {} to {}{unit}. That is what was, not what should be: put in what is required.\n\
         [{name}_low]\nvalue = {}\nmeaning = {}\n\n[{name}_high]\nvalue = {}\nmeaning = {}\n",
        rounded(of.seen.low),
        rounded(of.seen.high),
        quoted(&format!("{low}{unit}")),
        meaning("least"),
        quoted(&format!("{high}{unit}")),
        meaning("greatest"),
    )
}

/// With two digits, and no nearer to the middle.
fn outwards(number: f64, up: bool) -> f64 {
    let step = 10_f64.powi((number.abs().max(1e-12).log10().floor() as i32 - 1).clamp(-300, 300));
    let count = number / step;
    rounded(if up { count.ceil() } else { count.floor() } * step)
}

fn word(of: &Drafted) -> String {
    let name = &of.name;
    let meaning = quoted(&format!(
        "DRAFT: {} is in the range that is allowed.",
        shown(of)
    ));
    format!(
        "\n[{name}_in_range]\nmeaning = {meaning}\ntrace = \"/run.{name} >= {name}_low & /run.{name} <= {name}_high\"\n"
    )
}

fn requirement(of: &Drafted) -> String {
    let name = &of.name;
    let text = quoted(&format!(
        "DRAFT: {} is always in the range that is allowed.",
        shown(of)
    ));
    format!(
        "\n[[requirement]]\nid = \"{name}\"\ntext = {text}\nshall = \"The robot shall always satisfy {name}_in_range.\"\nmargin = 0.10\n"
    )
}

fn signal(of: &Drafted) -> String {
    let from = quoted(&format!("{}.{}", of.seen.topic, of.seen.path));
    let unit = match of.seen.unit.is_empty() {
        true => {
            "# unit = \"m/s\"   the recording does not say it; then give the parameters one, too"
                .into()
        }
        false => format!("unit = {}", quoted(&of.seen.unit)),
    };
    format!("\n[\"/run.{}\"]\nfrom = {from}\n{unit}\n", of.name)
}

/// All that the recording has, as comments.
fn all(found: &Inspection) -> String {
    let map = found.draft_map();
    let lines = map.lines().map(|line| match line.is_empty() {
        true => "#\n".to_owned(),
        false => format!("# {}\n", comment(line)),
    });
    lines.collect()
}

/// The recording's place in the study, and whether it is a copy.
fn kept(file: &Path) -> Result<(NewFile, bool), Problem> {
    let whole = std::fs::canonicalize(file).map_err(|error| Problem::cannot_read(file, &error))?;
    let size = size_of(&whole, MOST_COPIED).map_err(|error| Problem::cannot_read(file, &error))?;
    let is_copied = size <= MOST_COPIED;
    let content = match is_copied {
        true => Content::CopyOf(whole),
        false => Content::LinkTo(whole),
    };
    Ok((
        NewFile {
            path: place(file),
            content,
        },
        is_copied,
    ))
}

/// `recordings/run` with the endings that tell the format.
fn place(file: &Path) -> PathBuf {
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let endings: Vec<&str> = name.split('.').skip(1).collect();
    let known = [
        "mcap", "bag", "db3", "csv", "tsv", "json", "jsonl", "ndjson", "parquet", "zst", "txt",
    ];
    let told = endings
        .iter()
        .rev()
        .take_while(|ending| known.contains(ending))
        .count();
    let mut place = String::from("recordings/run");
    for ending in &endings[endings.len() - told..] {
        let _ = write!(place, ".{ending}");
    }
    place.into()
}

/// Bytes of a file, or of all files in a folder; no farther than `most` is counted.
fn size_of(path: &Path, most: u64) -> std::io::Result<u64> {
    if !path.is_dir() {
        return path.metadata().map(|found| found.len());
    }
    let mut size = 0;
    for entry in std::fs::read_dir(path)? {
        size += size_of(&entry?.path(), most)?;
        if size > most {
            break;
        }
    }
    Ok(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_no_nearer_than_what_was_seen() {
        assert_eq!(outwards(1.234, true), 1.3);
        assert_eq!(outwards(1.234, false), 1.2);
        assert_eq!(outwards(-1.234, false), -1.3);
        assert_eq!(outwards(0.0, true), 0.0);
    }

    #[test]
    fn endings_tell_the_format_and_nothing_else_of_a_name_is_kept() {
        assert_eq!(
            place(Path::new("/a/b c\n.d.mcap.zst")),
            PathBuf::from("recordings/run.mcap.zst")
        );
        assert_eq!(
            place(Path::new("/a/2024.05.01")),
            PathBuf::from("recordings/run")
        );
    }
}
