//! Episodes that were run elsewhere, taken over in the order of their numbers.
//!
//! # Definition
//! A campaign of N episodes may be run in shards: the k-th of n runs the episodes from 1 + floor(N (k-1) / n) to floor(N k / n). Each
//! shard's folder has a journal and recordings, as a campaign on one machine has. Taking over goes on from what the
//! campaign's own journal holds: the next number's record is looked for in the shards, and is taken with its recording, until one is
//! in no shard, the stopping rule ends the campaign, or all are there.
//!
//! # Assumes
//! Shards were made from the same inputs, which their folders' marks say (`shard`).
//!
//! # Guarantee
//! What is taken is the ordered prefix that one machine would have run: the same counts, journal and end of an adaptive rule, whatever
//! the order, number and overlap of shards. A record of another seed, two records of one number that differ, and a recording that
//! has not the hash of what was judged are refused; nothing is taken from behind them.

use super::driver::{Campaigning, Count, hash_of_recording};
use super::failing::words_of;
use super::one::{Bench, Effort};
use super::record::{EpisodeRecord, Journal};
use super::took;
use diagnostic::Problem;
use judging::forms::differences::{forms_of, judges};
use rig::OutsideCommand;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What was taken over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakenOver {
    /// Episodes that the campaign had before.
    pub known: u64,
    /// Episodes that were taken from shards.
    pub taken: u64,
    /// Episodes of which several shards had a record, the same.
    pub repeated: u64,
    /// Numbers that are in no shard and are needed, up to the next that is.
    pub missing: Option<Range<u64>>,
    /// Whether the stopping rule has ended it.
    pub is_decided: bool,
}

/// What a shard has of a campaign.
struct Shard {
    folder: PathBuf,
    journal: Journal,
}

/// The numbers of the episodes of a shard, from 1, of so many.
#[must_use]
pub fn numbers_of(shard: u64, of: u64, episodes: u64) -> Range<u64> {
    let up_to = |shards: u64| {
        let exact = u128::from(episodes) * u128::from(shards) / u128::from(of.max(1));
        1 + u64::try_from(exact).unwrap_or(episodes)
    };
    up_to(shard.saturating_sub(1))..up_to(shard)
}

impl Campaigning<'_> {
    /// Takes over what the campaign's folders in shards hold; these folders stay as they are.
    ///
    /// # Errors
    /// `shards-differ`, `other-seed`, `other-recording`, and what cannot be read or written.
    pub fn take_over(&self, folders: &[PathBuf], wall_secs: f64) -> Result<TakenOver, Problem> {
        let forms = forms_of(self.study);
        let bench = Bench::new(self, judges(self.study, &forms)?)?;
        let shards = self.shards(folders)?;
        let mut journal = Journal::open(self.folder, self.numbers.start, &self.judged_by)?;
        let mut count = Count::new(self, &bench);
        self.go_on_from(&mut journal, &mut count)?;
        let known = count.tally.runs();
        let earlier_secs = took::kept(self.folder);
        let (mut taken, mut repeated, mut missing) = (0, 0, None);
        for number in self.numbers.start + known..self.numbers.end {
            if count.is_decided() {
                break;
            }
            self.go_on()?;
            let Some((record, shard, copies)) = self.found(&shards, number)? else {
                missing = Some(number..self.next_after(&shards, number));
                break;
            };
            self.take_recording(&shard.folder, &record)?;
            journal.add(&record)?;
            taken += 1;
            repeated += u64::from(copies > 1);
            self.stage.advance();
            _ = count.take(&record, Effort::default());
        }
        if taken > 0 {
            took::keep(self.folder, earlier_secs + wall_secs);
        }
        Ok(TakenOver {
            known,
            taken,
            repeated,
            missing,
            is_decided: count.is_decided(),
        })
    }

    /// The journals of all shards that were judged as this campaign judges.
    fn shards(&self, folders: &[PathBuf]) -> Result<Vec<Shard>, Problem> {
        let mut shards = Vec::new();
        for folder in folders {
            for (first, path) in Journal::files(folder)? {
                match Journal::made_elsewhere(&path, first, &self.judged_by)? {
                    Some(journal) => shards.push(Shard {
                        folder: folder.clone(),
                        journal,
                    }),
                    None => {
                        let message = format!(
                            "{} was judged by other requirements, or by another build of the program",
                            path.display()
                        );
                        return Err(Problem::new("other-shard", message)
                            .remedy("run the shard again with this study and this program"));
                    }
                }
            }
        }
        Ok(shards)
    }

    /// The record of an episode, the shard that has it, and how many have the same.
    fn found<'s>(
        &self,
        shards: &'s [Shard],
        number: u64,
    ) -> Result<Option<(EpisodeRecord, &'s Shard, usize)>, Problem> {
        let mut found: Option<(EpisodeRecord, &Shard, usize)> = None;
        for shard in shards {
            let Some(record) = shard.journal.read(number)? else {
                continue;
            };
            if record.seed != self.seeds.of(number) || record.number != number {
                let message = format!(
                    "{} has another seed for episode {number} than this study",
                    shard.journal.path().display()
                );
                return Err(Problem::data_lost("other-seed", message)
                    .remedy("run the shard again with this study"));
            }
            found = match found {
                None => Some((record, shard, 1)),
                Some((first, of, copies)) if first == record => Some((first, of, copies + 1)),
                Some((_, of, _)) => return Err(differ(number, of, shard)),
            };
        }
        Ok(found)
    }

    /// The next number behind a missing one that a shard has.
    fn next_after(&self, shards: &[Shard], number: u64) -> u64 {
        let firsts = shards.iter().map(|it| it.journal.numbers());
        let firsts = firsts.filter(|it| !it.is_empty() && it.start > number);
        firsts
            .map(|it| it.start)
            .min()
            .unwrap_or(self.numbers.end)
            .min(self.numbers.end)
    }

    /// Copies what a shard keeps of an episode: its recording, and what a failing program said.
    fn take_recording(&self, folder: &Path, record: &EpisodeRecord) -> Result<(), Problem> {
        let words = words_of(folder, record.number);
        if words.is_file() {
            copy_whole(&words, &words_of(self.folder, record.number))?;
        }
        let Some(hash) = &record.recording else {
            return Ok(());
        };
        let to = self.recording(record.number);
        let Some(name) = to.file_name() else {
            return Ok(());
        };
        let from = folder.join(name);
        copy_whole(&from, &to)?;
        if &hash_of_recording(&to)? == hash {
            return Ok(());
        }
        // What is not ours does not stay.
        OutsideCommand::remove(&to);
        let message = format!("{} is not the recording that was judged", from.display());
        Err(Problem::data_lost("other-recording", message)
            .remedy("copy the shard's folder again, or run the shard again"))
    }
}

fn differ(number: u64, one: &Shard, other: &Shard) -> Problem {
    let message = format!(
        "episode {number} is another in {} than in {}: the same seed gave other results",
        one.journal.path().display(),
        other.journal.path().display()
    );
    Problem::data_lost("shards-differ", message).remedy(
        "the machines of both shards do not compute alike, or one shard was changed: run both on machines of one kind, and merge those",
    )
}

/// Copies a file, or a folder of files, whole or not at all. A link is neither: it could lead anywhere.
fn copy_whole(from: &Path, to: &Path) -> Result<(), Problem> {
    if from.is_symlink() {
        let message = format!("{} is a link, not a recording", from.display());
        return Err(Problem::data_lost("other-recording", message)
            .remedy("copy the shard's folder with what its links lead to"));
    }
    if !from.is_dir() {
        let mut source = host::files::open_file(from)?;
        return host::files::write_whole_by(to, |mut file| {
            let copied = std::io::copy(&mut source, &mut file);
            copied.map_err(|error| Problem::cannot_write(to, &error))?;
            Ok(file)
        });
    }
    let partial = to.with_extension("partial");
    let fail = |error: std::io::Error| Problem::cannot_write(&partial, &error);
    for old in [&partial, &to.to_owned()] {
        if old.is_dir() {
            std::fs::remove_dir_all(old).map_err(fail)?;
        }
    }
    std::fs::create_dir_all(&partial).map_err(fail)?;
    let inside = std::fs::read_dir(from).map_err(|error| Problem::cannot_read(from, &error))?;
    for entry in inside {
        let entry = entry.map_err(|error| Problem::cannot_read(from, &error))?;
        copy_whole(&entry.path(), &partial.join(entry.file_name()))?;
    }
    std::fs::rename(&partial, to).map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_episodes_each_once() {
        for episodes in [0, 1, 7, 10, 1000, 1_000_000] {
            for of in [1, 2, 3, 7, 16] {
                let mut next = 1;
                for shard in 1..=of {
                    let numbers = numbers_of(shard, of, episodes);
                    assert_eq!(numbers.start, next, "{shard} of {of}, {episodes} episodes");
                    let size = numbers.end - numbers.start;
                    assert!(size.abs_diff(episodes / of) <= 1, "{numbers:?}");
                    next = numbers.end;
                }
                assert_eq!(next, episodes + 1);
            }
        }
    }
}
