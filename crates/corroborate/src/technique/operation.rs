//! Recordings as evidence: of the robot at work (operation), or of trials with
//! it (experiments). Each recording is a trial, judged by the study's monitors
//! as a simulated episode is.
//!
//! A recording from which something is missing cannot show that a requirement
//! was kept, since what is missing may have broken it: such a trial counts if
//! it is violated, and is undecided otherwise.

use super::same_messages::{self, RepeatedRecording};
use super::sessions::{self, Recorded};
use super::{Produced, simulation};
use diagnostic::Problem;
use evidence::{Asset, AssetRole, Cost, Subject, Tool};
use host::store::Inputs;
use host::{Cancel, Stage};
use judging::forms::differences::{forms_of, judges};
use judging::recording::{JudgedRecording, ReadingRules};
use judging::verdicts::RunVerdicts;
use judging::{JudgedTrace, Judgement, Judges};
use rayon::prelude::*;
use recording::{SkippedPath, TrialPath};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Instant;
use study::{RecordingFiles, Study};
use temporal::formula::Horizon;
use temporal::monitor::Verdict;

/// What a recording of `corroborate watch` says of a simulated rest.
const SIMULATED: &str = "corroborate.watch.simulated";

/// What it says of the topics that came from outside.
const OUTSIDE: &str = "corroborate.watch.outside";

/// The recordings of one entry, found and hashed.
pub struct Recordings {
    rules: ReadingRules,
    trials: Vec<TrialPath>,
    /// What of the folder is no recording, each with the reason.
    skipped: Vec<SkippedPath>,
    /// Those with the same messages as earlier ones, by their places.
    repeated: BTreeMap<usize, RepeatedRecording>,
    /// Whether the ledger says that these are trials of their own.
    is_declared: bool,
    /// One for each file.
    assets: Vec<Asset>,
}

impl Recordings {
    /// Finds the recordings of an entry.
    pub fn find(study: &Study, of: RecordingFiles<'_>) -> Result<Self, Problem> {
        let full = study.folder.join(of.folder);
        let found = recording::trials(&full)
            .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
        if found.trials.is_empty() {
            let message = format!("{} holds no recording", full.display());
            return Err(Problem::new("no-recordings", message)
                .remedy("name a folder of recordings (MCAP, bags, CSV, JSON lines)"));
        }
        let mut assets = Vec::new();
        for trial in &found.trials {
            add_assets(study, &trial.path, &mut assets)?;
        }
        let rules = ReadingRules::of_study(&study.folder, None)?;
        let repeated = same_messages::repeated(&found.trials, &rules.options);
        Ok(Self {
            rules,
            trials: found.trials,
            skipped: found.skipped,
            is_declared: of.repeated.is_some(),
            repeated,
            assets,
        })
    }

    /// How many trials there are.
    pub fn count(&self) -> u64 {
        self.trials.len() as u64
    }

    /// The files.
    pub fn assets(&self) -> &[Asset] {
        &self.assets
    }

    /// What the verdicts depend on, besides the monitors and this program.
    pub fn inputs(&self, study: &Study, inputs: &mut Inputs) -> Result<(), Problem> {
        for asset in &self.assets {
            inputs.add(&asset.path, asset.hash.as_bytes());
        }
        let map = study.folder.join("topics.toml");
        if map.exists() {
            let text = std::fs::read(&map).map_err(|error| Problem::cannot_read(&map, &error))?;
            inputs.add("topics.toml", &text);
        }
        Ok(())
    }

    /// The verdicts of the forms that are held against each other, on every recording in their order.
    pub fn form_verdicts(
        &self,
        study: &Study,
        interrupt: &Cancel,
    ) -> Result<Vec<Vec<Verdict>>, Problem> {
        let forms = forms_of(study);
        self.verdicts(&judges(study, &forms)?, interrupt)
    }

    /// What monitors and forms say of every recording.
    pub fn all_verdicts(&self, study: &Study, interrupt: &Cancel) -> Result<RunVerdicts, Problem> {
        Ok(RunVerdicts {
            main: self.verdicts(&Judges::new(study, |_| true)?, interrupt)?,
            forms: self.form_verdicts(study, interrupt)?,
        })
    }

    fn verdicts(
        &self,
        judges: &Judges<'_>,
        interrupt: &Cancel,
    ) -> Result<Vec<Vec<Verdict>>, Problem> {
        // Forms that none can judge by have nothing to read a recording for.
        if judges.monitors().next().is_none() {
            return Ok(vec![Vec::new(); self.trials.len()]);
        }
        let all = self.judged(judges, interrupt, |_, it| Ok(verdicts_of(&counted(it))))?;
        Ok(all.into_iter().map(|(verdicts, _)| verdicts).collect())
    }

    /// Every recording, judged as far as it has the signals, with what `of` makes of that. A signal that none of them has is
    /// a mistake.
    fn judged<'a, T: Send>(
        &self,
        judges: &Judges<'a>,
        interrupt: &Cancel,
        of: impl Fn(&TrialPath, JudgedRecording<'a>) -> Result<T, Problem> + Sync,
    ) -> Result<Vec<(T, BTreeSet<String>)>, Problem> {
        let all = self.on_all(interrupt, |trial, go_on| {
            let there = self.rules.judge_what_is_there(judges, &trial.path, go_on)?;
            Ok((of(trial, there.judged)?, there.lacking))
        })?;
        let lacking = all.iter().map(|(_, lacking)| lacking.clone());
        let by_all = lacking.reduce(|one, other| &one & &other);
        if by_all.is_some_and(|signals| !signals.is_empty()) {
            // Says where the signal is named.
            let go_on = || Ok(());
            self.rules.judge(judges, &self.trials[0].path, &go_on)?;
        }
        Ok(all)
    }

    /// Something of every recording, on all cores, in the order of the recordings.
    fn on_all<T: Send>(
        &self,
        interrupt: &Cancel,
        of: impl Fn(&TrialPath, &dyn Fn() -> Result<(), Problem>) -> Result<T, Problem> + Sync,
    ) -> Result<Vec<T>, Problem> {
        let go_on = || match interrupt.is_cancelled() {
            true => Err(Problem::interrupted()),
            false => Ok(()),
        };
        let all: Vec<Result<T, Problem>> = self
            .trials
            .par_iter()
            .map(|trial| {
                go_on()?;
                of(trial, &go_on)
            })
            .collect();
        // The first that fails is told, whichever fails first.
        all.into_iter().collect()
    }

    /// Judges every recording; `say` is told of those that are not complete. Gives the verdicts on each, too.
    pub fn produce(
        &self,
        study: &Study,
        id: &str,
        interrupt: &Cancel,
        stage: &Stage,
        say: &dyn Fn(&str),
    ) -> Result<(Produced, Vec<Vec<Verdict>>), Problem> {
        let began = Instant::now();
        let judges = Judges::new(study, |_| true)?;
        let judged = self.judged(&judges, interrupt, |trial, judged| {
            let (said, begins) = said_of_itself(&trial.path, &self.rules)?;
            stage.advance();
            Ok((judged.complete, mixture_of(&said), begins, counted(judged)))
        })?;
        for SkippedPath { path, reason } in &self.skipped {
            let name = path.file_name().unwrap_or(path.as_os_str());
            say(&format!(
                "{id}: {} is left out: {reason}",
                name.to_string_lossy()
            ));
        }
        let (mut all, mut mixtures, mut all_begin) = (Vec::new(), BTreeMap::new(), Vec::new());
        for (trial, (found, lacking)) in self.trials.iter().zip(judged) {
            let (complete, mixture, begins, judgements) = found;
            if !lacking.is_empty() {
                let name = &trial.name;
                let lacking = Vec::from_iter(lacking).join(" and no ");
                say(&format!(
                    "{id}: {name} has no {lacking}; what reads that reaches no verdict there"
                ));
            }
            all_begin.push(begins);
            if let Some(mixture) = mixture {
                *mixtures.entry(mixture).or_insert(0_u64) += 1;
            }
            if !complete {
                let name = &trial.name;
                say(&format!(
                    "{id}: {name} is not complete; it counts only where it is violated"
                ));
            }
            all.push(judgements);
        }
        let recorded: Vec<Recorded<'_>> = self
            .trials
            .iter()
            .zip(all_begin)
            .zip(&all)
            .map(|((trial, begins), judgements)| Recorded {
                name: &trial.name,
                begins,
                verdicts: main_verdicts(judgements),
            })
            .collect();
        let alike_trials = sessions::alike(&recorded);
        for line in too_short(&all).into_iter().chain(pending(&all)) {
            say(&format!("{id}: {line}"));
        }
        let names: Vec<String> = self.trials.iter().map(|trial| trial.name.clone()).collect();
        let findings_once = match self.repeated.is_empty() || self.is_declared {
            true => Vec::new(),
            false => {
                let is_first = |at: &usize| !self.repeated.contains_key(at);
                let first = (0..names.len()).filter(is_first);
                let (judged, names): (Vec<_>, Vec<_>) =
                    first.map(|at| (all[at].clone(), names[at].clone())).unzip();
                simulation::findings(study, &judges, &judged, &names)?
            }
        };
        let produced = Produced {
            tool: Tool {
                name: "corroborate recordings".into(),
                version: env!("CARGO_PKG_VERSION").into(),
                settings: settings(self.trials.len(), &mixtures),
            },
            findings: simulation::findings(study, &judges, &all, &names)?,
            form_differences: Vec::new(),
            description_gaps: Vec::new(),
            failures: Vec::new(),
            clusters: None,
            alike_trials,
            repeated_recordings: self.repeated.values().cloned().collect(),
            findings_once,
            influences: Vec::new(),
            cost: Cost {
                evidence: id.to_owned(),
                wall_secs: began.elapsed().as_secs_f64(),
                ..Cost::default()
            },
        };
        Ok((produced, all.iter().map(|of| verdicts_of(of)).collect()))
    }
}

/// The file of a study's results that keeps the verdicts on an entry's recordings.
pub fn verdicts_name(id: &str) -> String {
    format!("verdicts/{id}.json")
}

/// What a recording counts for: all that is judged, or only violations if something of it is missing.
fn counted(judged: JudgedRecording<'_>) -> Vec<Judgement<'_>> {
    match judged.complete {
        true => judged.judgements,
        false => only_violations(judged.judgements),
    }
}

/// How many recordings end before what a requirement asks for, and so reach no verdict on it.
fn too_short(all: &[Vec<Judgement<'_>>]) -> Vec<String> {
    let line = |(subject, (asked, count)): (&Subject, (Horizon, u64))| {
        let subject = subject.in_words();
        format!(
            "{count} of {} recordings end before the {asked} that {subject} asks for, and reach no verdict on it",
            all.len()
        )
    };
    counted_by_subject(all, |of| of.ends_before)
        .into_iter()
        .map(line)
        .collect()
}

/// How many recordings have a verdict on a requirement that leaves out what was pending at their end.
fn pending(all: &[Vec<Judgement<'_>>]) -> Vec<String> {
    let line = |(subject, (asked, count)): (&Subject, (Horizon, u64))| {
        let subject = subject.in_words();
        format!(
            "in {count} of {} recordings something of {subject} began in the last {asked} and is pending at the end: left out, as \
             other windows were seen whole",
            all.len()
        )
    };
    counted_by_subject(all, |of| of.left_out)
        .into_iter()
        .map(line)
        .collect()
}

/// How many recordings have a horizon of a kind, by subject, with the first of them.
fn counted_by_subject<'j>(
    all: &'j [Vec<Judgement<'_>>],
    of: impl Fn(&JudgedTrace) -> Option<Horizon>,
) -> BTreeMap<&'j Subject, (Horizon, u64)> {
    let mut found = BTreeMap::new();
    for judgement in all.iter().flatten().filter(|it| it.reading.is_none()) {
        if let Some(asked) = of(&judgement.findings) {
            found.entry(judgement.subject).or_insert((asked, 0)).1 += 1;
        }
    }
    found
}

/// The verdicts without those of other readings, which are judged on the same runs.
fn main_verdicts<'j>(judgements: &'j [Judgement<'_>]) -> Vec<(&'j Subject, Verdict)> {
    let main = judgements.iter().filter(|it| it.reading.is_none());
    main.map(|it| (it.subject, it.findings.verdict)).collect()
}

fn verdicts_of(judgements: &[Judgement<'_>]) -> Vec<Verdict> {
    let findings = judgements.iter().map(|judgement| &judgement.findings);
    findings.map(|findings| findings.verdict).collect()
}

/// What a recording says of itself, and when its first message was logged, in seconds of the recorder's clock.
fn said_of_itself(
    path: &Path,
    rules: &ReadingRules,
) -> Result<(BTreeMap<String, String>, Option<f64>), Problem> {
    let unreadable =
        |error: &dyn std::fmt::Display| Problem::new("bad-recording", error.to_string());
    let mut reader = recording::open(path, &rules.options).map_err(|error| unreadable(&error))?;
    let first = reader.next().map_err(|error| unreadable(&error))?;
    let begins = first.map(|message| message.log_nanos as f64 / 1e9);
    Ok((reader.metadata().clone(), begins))
}

/// Which part of a run was simulated and which was not; `None` if no part was.
fn mixture_of(said: &BTreeMap<String, String>) -> Option<String> {
    let simulated = said.get(SIMULATED)?;
    // Episodes differ only by their number.
    let entry = simulated.split(',').next().unwrap_or(simulated);
    let outside = said.get(OUTSIDE).filter(|it| !it.is_empty());
    let outside = outside.map_or("nothing", String::as_str);
    Some(format!(
        "simulated as in {entry} but {outside} from outside"
    ))
}

/// How many recordings there are, and how many of them are of mixed origin.
fn settings(count: usize, mixtures: &BTreeMap<String, u64>) -> String {
    let told = mixtures
        .iter()
        .map(|(what, count)| format!("; {count} {what}"));
    let recordings = diagnostic::counted(count, "recording");
    format!("{recordings}{}", told.collect::<String>())
}

/// What a trial from which something is missing can still show.
pub fn only_violations(mut judgements: Vec<Judgement<'_>>) -> Vec<Judgement<'_>> {
    for judgement in &mut judgements {
        if judgement.findings.verdict != Verdict::Violated {
            judgement.findings.verdict = Verdict::Inconclusive;
        }
    }
    judgements
}

/// A file as an asset, or all files of a recording that is a folder.
fn add_assets(study: &Study, path: &Path, assets: &mut Vec<Asset>) -> Result<(), Problem> {
    study.reach.check(path)?;
    let unreadable = |error: &std::io::Error| Problem::cannot_read(path, error);
    if path.is_dir() {
        let entries = std::fs::read_dir(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let mut inside: Vec<_> = entries
            .map_err(|error| unreadable(&error))?
            .iter()
            .map(std::fs::DirEntry::path)
            .collect();
        inside.sort();
        return inside
            .iter()
            .try_for_each(|path| add_assets(study, path, assets));
    }
    let mut hasher = blake3::Hasher::new();
    let file = host::files::open_file(path)?;
    hasher
        .update_reader(file)
        .map_err(|error| unreadable(&error))?;
    let shown = path.strip_prefix(&study.folder).unwrap_or(path);
    assets.push(Asset {
        role: AssetRole::Data,
        path: shown.to_string_lossy().replace('\\', "/"),
        hash: hasher.finalize().to_hex().to_string(),
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_with_a_part_in_the_loop_say_what_came_from_outside() {
        let said = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
            let owned = pairs
                .iter()
                .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
            owned.collect()
        };
        assert_eq!(mixture_of(&said(&[(OUTSIDE, "/felt")])), None);
        let mut mixtures = BTreeMap::new();
        for episode in ["E2, episode 1", "E2, episode 2"] {
            let said = said(&[(SIMULATED, episode), (OUTSIDE, "/felt, /seen")]);
            *mixtures
                .entry(mixture_of(&said).expect("mixed"))
                .or_insert(0) += 1;
        }
        assert_eq!(
            settings(3, &mixtures),
            "3 recordings; 2 simulated as in E2 but /felt, /seen from outside"
        );
        assert_eq!(settings(1, &BTreeMap::new()), "1 recording");
    }
}
