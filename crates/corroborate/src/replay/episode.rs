//! An episode that is run again.

use crate::technique::exploration::OpenBench;
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use host::store::hash_of;
use host::{Cancel, Host};
use rig::episode_name;
use std::path::{Path, PathBuf};
use stimulus::{AbstractTest, Stimulus};
use study::{BenchFiles, Entry, Finding, Shows, Simulated, Study};
use testbench::{Control, Recorded, SimError, ViewKeeper, Viewer, Watch};

/// An episode that can be run again.
#[derive(Clone, Debug)]
pub struct Episode {
    /// What it is called, in file names too.
    pub name: String,
    /// Where it comes from, in words.
    pub origin: String,
    /// What is run.
    pub bench: BenchFiles,
    /// What is done.
    pub stimulus: Stimulus,
    /// Its seed.
    pub seed: u64,
    /// What it showed, if that is why it is run.
    pub shows: Option<Shows>,
    /// BLAKE3 of its recording, where it was recorded before.
    pub recording: Option<String>,
}

impl Episode {
    /// The episode of a finding's file, or of an evidence by its number, with
    /// the bench that runs it.
    pub fn named(study: &Study, text: &str, host: &Host) -> Result<(Self, OpenBench), Problem> {
        if let Some(file) = finding_file(study, Path::new(text)) {
            let episode = Self::of_finding(Finding::read(&file)?, &file);
            let bench = OpenBench::of_files(study, &episode.bench, host)?;
            return Ok((episode, bench));
        }
        match text.rsplit_once(':') {
            Some((evidence, number)) => Self::of_evidence(study, evidence, number, host),
            None => Err(no_finding(study, Path::new(text))),
        }
    }

    /// The episode of a finding that was read from a file.
    pub fn of_finding(finding: Finding, file: &Path) -> Self {
        Self::of_named(finding, &stem(file))
    }

    /// The episode of a finding.
    pub fn of_named(finding: Finding, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            origin: finding.found_by,
            bench: finding.bench,
            stimulus: finding.stimulus,
            seed: finding.seed,
            shows: Some(finding.shows),
            recording: finding.recording,
        }
    }

    fn of_evidence(
        study: &Study,
        evidence: &str,
        number: &str,
        host: &Host,
    ) -> Result<(Self, OpenBench), Problem> {
        let entry = study.entry(evidence)?;
        let parsed = number.parse::<u64>().ok().filter(|number| *number > 0);
        let Some(number) = parsed else {
            let message =
                format!("the number of an episode must be a whole number from 1 (got `{number}`)");
            return Err(Problem::new("bad-episode", message)
                .remedy(format!("episodes are numbered from 1: {evidence}:1")));
        };
        let episodes = entry.work.episodes();
        if entry.work.simulated().is_some() && number > episodes {
            let message = format!("{evidence} has no episode {number}: it has {episodes}");
            return Err(Problem::new("bad-episode", message).remedy(format!(
                "name one from {evidence}:1 to {evidence}:{episodes}"
            )));
        }
        let bench = OpenBench::of_entry(study, entry, host)?;
        let episode = Self {
            name: format!("{evidence}-{number}"),
            origin: format!("episode {number} of {evidence}"),
            bench: bench.files.clone(),
            stimulus: Stimulus::of(test_of(entry, &bench)?),
            seed: Seeds::new(study.about.seed, entry.seeded_as()).of(number),
            shows: None,
            // That of another simulator is kept as it left it.
            recording: match bench.is_outside() {
                true => None,
                false => kept_recording(study, evidence, number, entry.sampling.early_end),
            },
        };
        Ok((episode, bench))
    }

    /// Runs it, as [`OpenBench::again`] does; `keeper` sees where bodies are.
    pub fn run(
        &self,
        bench: &OpenBench,
        keeper: Option<&mut ViewKeeper>,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        let mut watch = Until {
            until_secs: self.bench.until_secs.map_or(f64::INFINITY, f64::from),
            keeper,
        };
        bench.again(&self.stimulus, self.seed, &mut watch, interrupt)
    }
}

/// The test that an entry of the ledger runs.
fn test_of(entry: &Entry, bench: &OpenBench) -> Result<AbstractTest, Problem> {
    let named = entry.work.simulated().and_then(Simulated::test);
    let mut tests = bench.own_tests().iter();
    let found = tests.find(|test| named.is_none_or(|name| test.name == name));
    found.cloned().ok_or_else(|| {
        let name = named.unwrap_or_default();
        Problem::new(
            "unknown-test",
            format!("there is no abstract test `{name}`"),
        )
        .remedy("name one of the [[abstract_test]] tables")
    })
}

/// Ends an episode at a time, and passes on what is seen.
struct Until<'a> {
    until_secs: f64,
    keeper: Option<&'a mut ViewKeeper>,
}

impl Watch for Until<'_> {
    fn row(&mut self, _: usize, time_secs: f64, _: &[f64]) -> Control {
        match time_secs >= self.until_secs {
            true => Control::Finish,
            false => Control::Continue,
        }
    }

    fn viewer(&mut self) -> Option<&mut dyn Viewer> {
        let keeper = self.keeper.as_deref_mut()?;
        Some(keeper)
    }
}

/// The hash of a recording.
pub fn hash_of_trace(trace: &trace::Trace) -> Result<(String, Vec<u8>), Problem> {
    let bytes = recording::to_mcap(trace)
        .map_err(|error| Problem::new("cannot-record", error.to_string()))?;
    Ok((hash_of(&bytes), bytes))
}

/// Where a finding's file is: as it is named, or in the study.
pub fn finding_file(study: &Study, named: &Path) -> Option<PathBuf> {
    let results = study.folder.join("results/exploration/findings");
    let regressions = study.folder.join("regressions");
    [
        named.to_owned(),
        study.folder.join(named),
        regressions.join(named),
        results.join(named),
    ]
    .into_iter()
    .find(|path| path.is_file())
}

/// Said where there is no such finding.
pub fn no_finding(study: &Study, named: &Path) -> Problem {
    let message = format!(
        "there is no finding {} here, nor in {}",
        named.display(),
        study.folder.display()
    );
    Problem::new("no-finding", message).remedy(
        "`corroborate explore` writes findings; an episode of an evidence is named for example E4:17",
    )
}

fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(
        || "finding".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// The hash of the recording that `run` kept, if it is of a whole episode.
fn kept_recording(study: &Study, evidence: &str, number: u64, early_end: bool) -> Option<String> {
    let folder = study.folder.join("results/episodes").join(evidence);
    let bytes = std::fs::read(folder.join(episode_name(number))).ok()?;
    (!early_end).then(|| hash_of(&bytes))
}
