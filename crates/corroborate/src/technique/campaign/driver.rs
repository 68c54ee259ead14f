//! Runs a campaign: goes on from the journal, runs what is missing, counts, and ends in time.

use super::failing::stopped_by;
use super::mishaps::Mishaps;
use super::one::{Bench, Effort};
use super::ordered::in_order;
use super::record::{EpisodeRecord, Journal};
use super::tally::{Intervals, Tally};
use super::took;
use super::until::Until;
use super::{estimates, table};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{Cost, FailureKind, FormDifference};
use host::{Cancel, Stage};
use judging::forms::differences::{DifferenceTally, forms_of, judges};
use rig::Rig;
use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::time::Instant;
use study::{Keep, OnFailure, Study};

/// What is to be done.
pub struct Campaigning<'a> {
    /// The study whose monitors judge.
    pub study: &'a Study,
    /// The evidence's identifier.
    pub id: &'a str,
    /// What gives episodes.
    pub rig: &'a dyn Rig,
    /// Their seeds.
    pub seeds: Seeds,
    /// Their numbers; a stopping rule may end before the last.
    pub numbers: Range<u64>,
    /// Which recordings are kept.
    pub keep: Keep,
    /// Whether an episode ends once all is decided.
    pub early_end: bool,
    /// What is done when an episode is ended by a failure.
    pub on_failure: OnFailure,
    /// When the campaign ends before its last episode.
    pub until: Option<&'a Until>,
    /// Where recordings, journal and table go.
    pub folder: &'a Path,
    /// Hash of what judging depends on.
    pub judged_by: String,
    /// Whether the user wants to stop.
    pub interrupt: &'a Cancel,
    /// Where progress is shown.
    pub stage: &'a Stage,
}

/// A finished campaign.
pub struct Finished {
    /// Counts.
    pub tally: Tally,
    /// How intervals are to be formed.
    pub intervals: Intervals,
    /// Forms that do not agree.
    pub form_differences: Vec<FormDifference>,
    /// What it took.
    pub cost: Cost,
    /// The first episode that each kind of failure ended.
    pub first_failed: BTreeMap<FailureKind, u64>,
    /// What moved in the fingers that held it.
    pub mishaps: Mishaps,
    /// What came of the stopping rule.
    pub stopped: Option<String>,
    /// The table of all episodes.
    pub table: PathBuf,
}

impl Campaigning<'_> {
    /// Runs it.
    pub fn run(&self) -> Result<Finished, Problem> {
        let began = Instant::now();
        let forms = forms_of(self.study);
        let bench = Bench::new(self, judges(self.study, &forms)?)?;
        bench.recorder.prepare(self.folder)?;
        let mut journal = Journal::open(self.folder, self.numbers.start, &self.judged_by)?;
        let mut count = Count::new(self, &bench);
        self.go_on_from(&mut journal, &mut count)?;
        let earlier_secs = match count.tally.runs() {
            0 => 0.0,
            _ => took::kept(self.folder),
        };
        let wall_secs = || earlier_secs + began.elapsed().as_secs_f64();
        let rest = self.run_the_rest(&bench, &mut journal, &mut count);
        // Whoever goes on from here adds to it.
        rest.inspect_err(|_| took::keep(self.folder, wall_secs()))?;
        let table = self.folder.join(match self.numbers.start {
            1 => "episodes.parquet".to_owned(),
            first => format!("episodes-{first}.parquet"),
        });
        table::write(&table, self, &bench.monitors, &journal, count.tally.runs())?;
        bench.recorder.tidy(self.folder);
        took::forget(self.folder);
        Ok(count.finish(wall_secs(), table))
    }

    /// Takes what the journal holds, up to the first episode whose recording is not as it was.
    pub(super) fn go_on_from(
        &self,
        journal: &mut Journal,
        count: &mut Count<'_>,
    ) -> Result<(), Problem> {
        let known = self.numbers.start..self.numbers.end.min(self.numbers.start + journal.count());
        let mut taken = 0;
        let work = |(): &mut (), number| {
            self.go_on()?;
            Ok(journal.read(number)?.filter(|record| self.is_kept(record)))
        };
        let take = |_, record: Option<EpisodeRecord>| {
            let Some(record) = record else {
                return Ok(ControlFlow::Break(()));
            };
            if let (Some(kind), OnFailure::Stop) = (record.failure(), self.on_failure) {
                return Err(stopped_by(self.folder, record.number, kind));
            }
            taken += 1;
            Ok(count.take(&record, Effort::default()))
        };
        in_order(known, threads(), || (), work, take)?;
        self.stage.skip(taken);
        count.begin_new();
        // A rule that ends earlier than an earlier call did leaves the rest in the journal.
        if !count.is_decided()
            && taken < journal.count()
            && self.numbers.start + taken < self.numbers.end
        {
            journal.keep(taken)?;
        }
        Ok(())
    }

    fn run_the_rest(
        &self,
        bench: &Bench<'_>,
        journal: &mut Journal,
        count: &mut Count<'_>,
    ) -> Result<(), Problem> {
        let first = self.numbers.start + count.tally.runs();
        if count.is_decided() || first >= self.numbers.end {
            return Ok(());
        }
        let work = |(): &mut (), number| {
            self.go_on()?;
            bench.episode(number)
        };
        let take = |_, (record, effort): (EpisodeRecord, Effort)| {
            journal.add(&record)?;
            let flow = count.take(&record, effort);
            self.stage.advance_with(|| count.in_words());
            Ok(flow)
        };
        in_order(first..self.numbers.end, threads(), || (), work, take)
    }

    pub(super) fn go_on(&self) -> Result<(), Problem> {
        match self.interrupt.is_cancelled() {
            true => Err(Problem::interrupted()),
            false => Ok(()),
        }
    }

    /// Whether a judged episode may be taken as it is: its recording is there if it has to be. One
    /// that failed may have left none.
    fn is_kept(&self, record: &EpisodeRecord) -> bool {
        let path = self.recording(record.number);
        let is_there = match (&record.recording, self.keep) {
            (_, Keep::None) => true,
            (Some(hash), _) => hash_of_recording(&path).is_ok_and(|found| &found == hash),
            (None, Keep::Violations) => true,
            (None, Keep::All) => record.failure().is_some(),
        };
        is_there && record.seed == self.seeds.of(record.number)
    }

    /// Where an episode's recording is.
    pub fn recording(&self, number: u64) -> PathBuf {
        self.folder.join(self.rig.recording_name(number))
    }
}

/// The threads that work in parallel, as the call says.
fn threads() -> usize {
    rayon::current_num_threads()
}

/// Counts that grow with each episode.
pub(super) struct Count<'a> {
    plan: &'a Campaigning<'a>,
    pub(super) tally: Tally,
    differences: DifferenceTally,
    cost: Cost,
    /// Seconds simulated by this call, and with which processor time.
    new_secs: f64,
    new_cpu_secs: f64,
    new_episodes: u64,
    first_failed: BTreeMap<FailureKind, u64>,
    mishaps: Mishaps,
    began: Instant,
    decided: bool,
}

impl<'a> Count<'a> {
    pub(super) fn new(plan: &'a Campaigning<'a>, bench: &Bench<'_>) -> Self {
        Self {
            plan,
            tally: Tally::new(&bench.monitors),
            differences: DifferenceTally::new(bench.of_forms.monitors()),
            cost: Cost {
                evidence: plan.id.to_owned(),
                ..Cost::default()
            },
            new_secs: 0.0,
            new_cpu_secs: 0.0,
            new_episodes: 0,
            first_failed: BTreeMap::new(),
            mishaps: Mishaps::default(),
            began: Instant::now(),
            decided: false,
        }
    }

    pub(super) fn is_decided(&self) -> bool {
        self.decided
    }

    /// What comes from here on is new.
    fn begin_new(&mut self) {
        self.new_episodes = 0;
        self.began = Instant::now();
    }

    pub(super) fn take(&mut self, record: &EpisodeRecord, effort: Effort) -> ControlFlow<()> {
        let path = self.plan.recording(record.number);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let verdicts: Vec<_> = record.judged.iter().map(|judged| judged.verdict).collect();
        self.tally.add(&name, &verdicts);
        self.tally
            .left_out(record.judged.iter().map(|it| it.left_out));
        self.tally.ended_by(record.number, record.failure());
        if let Some(kind) = record.failure() {
            self.first_failed.entry(kind).or_insert(record.number);
        }
        self.differences.add(&name, &record.forms);
        self.mishaps.add(record);
        if let Some(secs) = record.simulated_secs {
            *self.cost.simulated_secs.get_or_insert(0.0) += secs;
            if let Some(cpu_secs) = effort.cpu_secs {
                self.new_secs += secs;
                self.new_cpu_secs += cpu_secs;
            }
        }
        self.new_episodes += 1;
        self.decided = self.plan.until.is_some_and(|until| {
            until.decide(self.tally.completions(until.subject())) != stats::Decision::Open
        });
        match self.decided {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Speed and estimates, for progress.
    fn in_words(&self) -> String {
        let secs = self.began.elapsed().as_secs_f64().max(1e-9);
        let mut words = format!("{:.1} episodes/s", self.new_episodes as f64 / secs);
        if self.new_secs > 0.0 {
            words.push_str(&format!(", {:.0} times real time", self.new_secs / secs));
        }
        for (kind, sample) in self.tally.failed() {
            words.push_str(&format!("; {kind} in {}", sample.successes));
        }
        let estimates = estimates(self.plan.study, &self.tally);
        if !estimates.is_empty() {
            words.push_str(&format!("; {estimates}"));
        }
        words
    }

    fn finish(mut self, wall_secs: f64, table: PathBuf) -> Finished {
        let (episodes, numbers) = (self.tally.runs(), &self.plan.numbers);
        let stopped = self.plan.until.map(|until| {
            let ends = self.tally.completions(until.subject());
            until.outcome_in_words(ends, episodes, numbers.end - numbers.start)
        });
        self.cost.wall_secs = wall_secs;
        if self.new_cpu_secs > 0.0 {
            self.cost.real_time_factor = Some(self.new_secs / self.new_cpu_secs);
        }
        if !self.plan.rig.is_outside() {
            self.cost.cpu_secs = Some(self.new_cpu_secs);
        }
        Finished {
            tally: self.tally,
            intervals: match self.plan.until {
                Some(_) => Intervals::Anytime,
                None => Intervals::Fixed,
            },
            form_differences: self.differences.finish(),
            first_failed: self.first_failed,
            mishaps: self.mishaps,
            cost: self.cost,
            stopped,
            table,
        }
    }
}

/// The hash of a recording, be it a file or a folder of files.
pub(super) fn hash_of_recording(path: &Path) -> Result<String, Problem> {
    let fail = |error: std::io::Error| Problem::cannot_read(path, &error);
    let mut hasher = blake3::Hasher::new();
    if path.is_dir() {
        let entries = std::fs::read_dir(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let mut inside: Vec<PathBuf> = entries.map_err(fail)?.iter().map(|e| e.path()).collect();
        inside.sort();
        for path in inside {
            hasher.update(path.file_name().unwrap_or_default().as_encoded_bytes());
            hasher.update(hash_of_recording(&path)?.as_bytes());
        }
    } else {
        let file = host::files::open_file(path)?;
        hasher.update_reader(file).map_err(fail)?;
    }
    Ok(hasher.finalize().to_hex().to_string())
}
