//! A finished campaign held against what it was made from: its recordings judged again, a sample of its episodes run again.
//!
//! # Definition
//! Of each record of the journal whose recording is kept, the recording is judged anew, and its verdicts have to be those of the record. Of all
//! records `k` are drawn without replacement, their episodes are run again by their seeds in a folder of their own, and the whole record has to
//! come out again, with the hash of its recording.
//!
//! # Assumes
//! Who wrote the journal did not know which episodes would be drawn: the draw is not part of the study. A simulator gives the same for the
//! same seed; of one that does not the difference is a fault, too, as nothing tells it from a changed journal.
//!
//! # Guarantee
//! A change of any verdict of an episode whose recording is kept is found. Of `n` episodes of which `f` were changed, all without
//! recordings, none is among `k` drawn with a probability of at most `(1 - k/n)^f`.

use super::driver::Campaigning;
use super::one::Bench;
use super::record::EpisodeRecord;
use super::{in_order, judged_by};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use host::Host;
use judging::forms::differences::{forms_of, judges};
use rig::Rig;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use study::{Entry, Keep, Study};

/// Which episodes of each campaign are run again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// How many.
    pub episodes: u64,
    /// From which number they are drawn.
    pub draw: u64,
}

/// What came of it.
#[derive(Debug, Default)]
pub struct Again {
    /// Recordings that were judged again, with the same verdicts.
    pub judged: u64,
    /// Recordings that are not whole, of which nothing can be judged again.
    pub not_judged: u64,
    /// Episodes that were run again, and gave the same.
    pub run: u64,
    /// Episodes of which something else came, each with what it is.
    pub faults: Vec<(u64, &'static str)>,
}

/// Judges the kept recordings in `folder` again, and runs drawn episodes again.
///
/// # Errors
/// What keeps recordings from being judged and episodes from being run at all.
pub fn again(
    (study, entry, rig, host): (&Study, &Entry, &dyn Rig, &Host),
    folder: &Path,
    records: &[EpisodeRecord],
    sampled: Sampled,
) -> Result<Again, Problem> {
    let scratch = Scratch::below(&host.scratch)?;
    let title = format!("{}: episodes again", entry.id);
    let drawn = drawn(records.len() as u64, &entry.id, sampled);
    let stage = host
        .events
        .begin(&title, (records.len() + drawn.len()) as u64);
    let plan = |folder, keep| Campaigning {
        study,
        id: &entry.id,
        rig,
        seeds: Seeds::new(study.about.seed, entry.seeded_as()),
        numbers: 1..records.len() as u64 + 1,
        keep,
        early_end: entry.sampling.early_end,
        on_failure: study::OnFailure::Count,
        until: None,
        folder,
        judged_by: judged_by(study, rig, host.build.as_str()),
        interrupt: &host.cancel,
        stage: &stage,
    };
    let (kept, fresh) = (plan(folder, Keep::All), plan(&scratch.0, Keep::All));
    let mut found = Again::default();
    kept.judged_again(records, &mut found)?;
    fresh.run_again(records, &drawn, &mut found)?;
    Ok(found)
}

/// A folder that goes away with it.
struct Scratch(PathBuf);

impl Scratch {
    fn below(folder: &Path) -> Result<Self, Problem> {
        static FOLDERS: AtomicU64 = AtomicU64::new(0);
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let name = format!("corroborate-again-{}-{number}", std::process::id());
        let path = folder.join(name);
        // One that is there is of a process that was killed, or somebody else's.
        std::fs::create_dir(&path).map_err(|error| Problem::cannot_write(&path, &error))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Places of the records that are drawn, each once, in order.
fn drawn(records: u64, id: &str, sampled: Sampled) -> Vec<u64> {
    if sampled.episodes >= records {
        return (0..records).collect();
    }
    let seeds = Seeds::new(sampled.draw, id);
    let mut places = BTreeSet::new();
    let mut tried = 0;
    while (places.len() as u64) < sampled.episodes {
        tried += 1;
        places.insert(seeds.of(tried) % records);
    }
    places.into_iter().collect()
}

impl Campaigning<'_> {
    /// Holds the verdicts on kept recordings against the records.
    fn judged_again(&self, records: &[EpisodeRecord], found: &mut Again) -> Result<(), Problem> {
        let forms = forms_of(self.study);
        let bench = Bench::new(self, judges(self.study, &forms)?)?;
        let work = |(): &mut (), place: u64| {
            self.go_on()?;
            let record = &records[place as usize];
            match record.recording {
                Some(_) => bench.recorder.judged_again(&bench, record.number),
                None => Ok(None),
            }
        };
        let take = |place: u64, again: Option<EpisodeRecord>| {
            let record = &records[place as usize];
            self.stage.advance();
            match again {
                Some(again) if same_verdicts(&again, record) => found.judged += 1,
                Some(_) => found.faults.push((
                    record.number,
                    "its recording, judged again, has other verdicts than the journal",
                )),
                None if record.recording.is_some() => found.not_judged += 1,
                None => {}
            }
            Ok(ControlFlow::Continue(()))
        };
        in_order(
            0..records.len() as u64,
            rayon::current_num_threads(),
            || (),
            work,
            take,
        )
    }

    /// Runs the drawn episodes again, and holds what comes against their records.
    fn run_again(
        &self,
        records: &[EpisodeRecord],
        drawn: &[u64],
        found: &mut Again,
    ) -> Result<(), Problem> {
        let forms = forms_of(self.study);
        let bench = Bench::new(self, judges(self.study, &forms)?)?;
        bench.recorder.prepare(self.folder)?;
        let work = |(): &mut (), place: u64| {
            self.go_on()?;
            let number = records[drawn[place as usize] as usize].number;
            Ok(bench.episode(number)?.0)
        };
        let take = |place: u64, again: EpisodeRecord| {
            let record = &records[drawn[place as usize] as usize];
            self.stage.advance();
            let whole = EpisodeRecord {
                recording: record.recording.as_ref().and(again.recording.clone()),
                ..again
            };
            match &whole == record {
                true => found.run += 1,
                false if same_verdicts(&whole, record) => found.faults.push((
                    record.number,
                    "run again with its seed it has the same verdicts, but not the same recording or measures",
                )),
                false => found.faults.push((
                    record.number,
                    "run again with its seed it has other verdicts than the journal",
                )),
            }
            Ok(ControlFlow::Continue(()))
        };
        let numbers = 0..drawn.len() as u64;
        in_order(numbers, rayon::current_num_threads(), || (), work, take)?;
        bench.recorder.tidy(self.folder);
        Ok(())
    }
}

/// Whether all monitors and forms say the same. How a run that was cut short ended is not told by its recording.
fn same_verdicts(one: &EpisodeRecord, other: &EpisodeRecord) -> bool {
    let of = |record: &EpisodeRecord| -> Vec<_> {
        let judged = record.judged.iter();
        judged.map(|it| (it.verdict, it.triggered)).collect()
    };
    of(one) == of(other) && one.forms == other.forms
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_episode_is_drawn_as_often_as_any_other_and_once_in_a_draw() {
        let mut often = [0_u32; 10];
        for draw in 0..2000 {
            let sampled = Sampled { episodes: 3, draw };
            let places = drawn(10, "E1", sampled);
            assert_eq!(places.len(), 3, "{places:?}");
            assert!(places.windows(2).all(|it| it[0] < it[1]), "{places:?}");
            for place in places {
                often[place as usize] += 1;
            }
        }
        // Mean 600, standard deviation 20.5: five of them.
        assert!(often.iter().all(|it| it.abs_diff(600) < 103), "{often:?}");
        let all = Sampled {
            episodes: 99,
            draw: 1,
        };
        assert_eq!(drawn(4, "E1", all), [0, 1, 2, 3]);
        assert!(drawn(0, "E1", all).is_empty());
    }
}
