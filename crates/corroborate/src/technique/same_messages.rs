//! Recordings that are one another's copies: the same trial, told twice.
//!
//! # Definition
//! Two recordings have the same messages if they have as many, and each is in both at the same place: of the same topic and
//! encoding, logged at the same time, with the same bytes. Names of files, and all that a container adds (its own metadata,
//! chunks, compression), play no part. Recordings without any message are the same if their bytes are.
//!
//! # Cost
//! The first message of each recording is read; all messages only of those whose first is another's.
//!
//! # Assumes
//! Different trials differ in some message: not so where few values were recorded.
//!
//! # Guarantee
//! What is the same is found, as far as it can be read. Not found: a copy that was cut, shifted in time, or written in a
//! format that encodes messages in another way. Two trials may have the same messages if few values were recorded; so the
//! ledger can declare that they are trials of their own (`repeated_recordings`); until then nothing is said that does not hold both
//! with the copies and without them.

use evidence::{CopyKind, LineageQuestion};
use rayon::prelude::*;
use recording::{OpenOptions, ReadError, Reader, TrialPath};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A recording with the same messages as an earlier one of its folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RepeatedRecording {
    /// Its name within the folder.
    pub recording: String,
    /// The name of the first with these messages.
    pub of: String,
}

/// The recordings that have the same messages as earlier ones, each with its place among the trials.
pub(super) fn repeated(
    trials: &[TrialPath],
    options: &OpenOptions,
) -> BTreeMap<usize, RepeatedRecording> {
    let firsts = first_with_same(trials, options).into_iter().enumerate();
    let copies = firsts.filter(|(at, first)| at != first);
    copies
        .map(|(at, first)| {
            let repeated = RepeatedRecording {
                recording: trials[at].name.clone(),
                of: trials[first].name.clone(),
            };
            (at, repeated)
        })
        .collect()
}

/// Of each trial the place of the first with the same messages, which may be its own.
fn first_with_same(trials: &[TrialPath], options: &OpenOptions) -> Vec<usize> {
    let beginnings: Vec<Option<Hash>> = trials
        .par_iter()
        .map(|trial| hash_of(&trial.path, options, 1))
        .collect();
    let mut alike: BTreeMap<Option<Hash>, u64> = BTreeMap::new();
    for beginning in &beginnings {
        *alike.entry(*beginning).or_default() += 1;
    }
    let whole: Vec<Option<Hash>> = trials
        .par_iter()
        .zip(&beginnings)
        .map(|(trial, beginning)| match alike[beginning] {
            1 => None,
            _ => hash_of(&trial.path, options, u64::MAX).or_else(|| hash_of_file(&trial.path)),
        })
        .collect();
    let mut first = BTreeMap::new();
    let place = |(at, hash): (usize, &Option<Hash>)| match hash {
        Some(hash) => *first.entry(*hash).or_insert(at),
        None => at,
    };
    whole.iter().enumerate().map(place).collect()
}

type Hash = [u8; 32];

/// The hash of a recording's first messages, at most `most`; `None` where it has none or cannot be read, which is said when
/// it is judged.
fn hash_of(path: &Path, options: &OpenOptions, most: u64) -> Option<Hash> {
    let mut reader = recording::open(path, options).ok()?;
    messages(reader.as_mut(), most).ok().flatten()
}

fn messages(reader: &mut dyn Reader, most: u64) -> Result<Option<Hash>, ReadError> {
    let mut hasher = blake3::Hasher::new();
    let mut count = 0;
    while count < most {
        // Topics of an unfinished file may be appended, so they are looked up when a message names them.
        let (topic, log_nanos) = match reader.next()? {
            Some(message) => {
                hasher.update(&(message.data.len() as u64).to_le_bytes());
                hasher.update(message.data);
                (message.topic, message.log_nanos)
            }
            None => break,
        };
        let topic = &reader.topics()[topic.index()];
        for text in [&topic.name, &topic.encoding.to_string()] {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        }
        hasher.update(&log_nanos.to_le_bytes());
        count += 1;
    }
    Ok((count > 0).then(|| *hasher.finalize().as_bytes()))
}

fn hash_of_file(path: &Path) -> Option<Hash> {
    let mut hasher = blake3::Hasher::new();
    hasher
        .update_reader(host::files::open_file(path).ok()?)
        .ok()?;
    Some(*hasher.finalize().as_bytes())
}

/// The question of a piece's recordings that are copies of others: open while they count both ways, settled by the ledger's
/// reason why each counts.
pub(crate) fn question(
    id: &str,
    repeated: &[RepeatedRecording],
    declared: Option<&str>,
) -> Option<LineageQuestion> {
    let first = repeated.first()?;
    let more = match repeated.len() - 1 {
        0 => String::new(),
        more => format!(", and {more} more are copies so"),
    };
    let counted = match declared {
        Some(_) => "each counts as a trial",
        None => "until it is settled they count once and each, and only what holds of both is said",
    };
    Some(LineageQuestion {
        with: id.to_owned(),
        kind: CopyKind::Recordings,
        subjects: Vec::new(),
        finding: format!(
            "recording `{}` has the same messages as `{}`{more}: {counted}",
            first.recording, first.of
        ),
        places: Vec::new(),
        chance: 0.0,
        blocks: true,
        settled: declared.map(str::to_owned),
        remedy: format!(
            "remove the copies; or, if they are trials of their own in which the same was recorded, write \
             `repeated_recordings = \"reason\"` in {id}'s entry of ledger.toml"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(name: &str, files: &[(&str, &str)]) -> (std::path::PathBuf, Vec<TrialPath>) {
        let folder =
            std::env::temp_dir().join(format!("corroborate-same-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for (file, text) in files {
            std::fs::write(folder.join(file), text).expect("written");
        }
        let found = recording::trials(&folder).expect("recordings");
        (folder, found.trials)
    }

    #[test]
    fn copies_are_found_by_their_messages_whatever_the_files_are_called() {
        let (folder, trials) = written(
            "copies",
            &[
                ("a.csv", "time_secs,x\n0,1\n1,2\n"),
                ("b.csv", "time_secs,x\n0,1\n1,3\n"),
                // The same rows with another line ending.
                ("c.csv", "time_secs,x\r\n0,1\r\n1,2\r\n"),
                ("d.csv", "time_secs,x\n0,1\n1,2\n2,3\n"),
                ("e.csv", "time_secs,x\n5,1\n"),
            ],
        );
        let found = repeated(&trials, &OpenOptions::default());
        assert_eq!(found.keys().collect::<Vec<_>>(), [&2]);
        assert_eq!(
            found.into_values().collect::<Vec<_>>(),
            [RepeatedRecording {
                recording: "c.csv".into(),
                of: "a.csv".into()
            }]
        );
        std::fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn a_declaration_settles_the_question_and_says_what_counts() {
        let copy = RepeatedRecording {
            recording: "c.csv".into(),
            of: "a.csv".into(),
        };
        let of = |declared| question("O1", std::slice::from_ref(&copy), declared).expect("asked");
        assert!(of(None).is_open() && of(None).finding.contains("count once and each"));
        let settled = of(Some("two trials"));
        assert!(!settled.is_open() && settled.finding.contains("each counts"));
        assert_eq!(question("O1", &[], None), None);
    }
}
