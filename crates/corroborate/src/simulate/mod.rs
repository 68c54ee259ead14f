//! Episodes of a study's simulation, recorded, judged and counted.

mod report;

pub use report::{EstimateReport, FailureReport, RecordingReport, SimulateReport};

use crate::outcome::Outcome;
use crate::rigs;
use crate::ros2_table::Ros2Table;
use crate::technique;
use crate::technique::campaign::{Campaigning, Finished, Until, judged_by, parse_until, words_of};
use crate::technique::simulation::{Seeds, record_with};
use diagnostic::Problem;
use evidence::{Alone, Cost, Step, Verdict};
use host::Host;
use host::files::write_whole;
use host::store::Inputs;
use rig::Rig;
use std::path::{Path, PathBuf};
use study::{Entry, Keep, OnFailure, PhysicsEngine, Study};

/// What recordings of a simulation hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RecordingForm {
    /// The simulation's own signals.
    #[default]
    Signals,
    /// ROS 2 messages, by the table `ros2.toml` beside the scenario.
    Ros2,
}

/// Episodes to be simulated. [`SimulateRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct SimulateRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The ledger's entry that is simulated.
    pub evidence: String,
    /// How many episodes; by default as many as the ledger says.
    pub episodes: Option<u64>,
    /// A stopping rule instead of the ledger's, such as `requirement 1a is decided at 99 %`.
    pub until: Option<String>,
    /// Which recordings are kept; by default as the ledger says.
    pub keep: Option<Keep>,
    /// What is done when the robot's program or the simulator fails; by default as the ledger says.
    pub on_failure: Option<OnFailure>,
    /// Number of the first episode.
    pub first: u64,
    /// The seed; by default the study's.
    pub seed: Option<u64>,
    /// The folder for recordings and results. One that holds episodes of the same request is gone on with.
    pub out: PathBuf,
    /// The physics engine instead of the ledger's; a command has its own.
    pub engine: Option<PhysicsEngine>,
    /// What the recordings hold.
    pub form: RecordingForm,
}

impl SimulateRequest {
    /// The episodes of this entry of the study in this folder, into `out`.
    pub fn new(
        study: impl Into<PathBuf>,
        evidence: impl Into<String>,
        out: impl Into<PathBuf>,
    ) -> Self {
        Self {
            study: study.into(),
            evidence: evidence.into(),
            episodes: None,
            until: None,
            keep: None,
            on_failure: None,
            first: 1,
            seed: None,
            out: out.into(),
            engine: None,
            form: RecordingForm::default(),
        }
    }
}

/// What was simulated.
#[derive(Clone, Debug)]
pub struct SimulatedEpisodes {
    /// What the episodes show.
    pub report: SimulateReport,
    /// What they cost; of recordings that are not judged nothing is known.
    pub cost: Option<Cost>,
    /// What the verdicts and the stopping rule amount to.
    pub outcome: Outcome,
}

/// Simulates and records episodes, judges them and counts.
///
/// # Errors
/// What the study's files say wrong; `folder-not-empty` if the folder holds episodes of something else; `interrupted` if the
/// host was asked to stop, after which the same request goes on; `no-physics-library` if episodes cannot be simulated here.
pub fn simulate(request: &SimulateRequest, setting: &Host) -> Result<SimulatedEpisodes, Problem> {
    let study = Study::load_for(&request.study, &setting.trust)?;
    let entry = study.entry(&request.evidence)?;
    let rig = match request.engine {
        Some(engine) => rigs::in_engine(&study, entry, engine, setting)?,
        None => rigs::of_entry(&study, entry, setting)?,
    };
    let called = Called {
        study: &study,
        entry,
        request,
        setting,
        seeds: Seeds::new(request.seed.unwrap_or(study.about.seed), entry.seeded_as()),
        count: request.episodes.unwrap_or_else(|| entry.work.episodes()),
    };
    match request.form {
        RecordingForm::Signals => called.campaign(rig.as_ref()),
        RecordingForm::Ros2 => called.ros2(rig.as_ref()),
    }
}

/// A call, with what it names.
struct Called<'a> {
    study: &'a Study,
    entry: &'a Entry,
    request: &'a SimulateRequest,
    setting: &'a Host,
    seeds: Seeds,
    count: u64,
}

impl Called<'_> {
    /// Runs, records and judges episodes.
    fn campaign(&self, rig: &dyn Rig) -> Result<SimulatedEpisodes, Problem> {
        let (request, sampling) = (self.request, &self.entry.sampling);
        let rule = match &request.until {
            Some(text) => Some(parse_until(text)?),
            None => sampling.until.clone(),
        };
        let until = rule
            .as_ref()
            .map(|rule| Until::new(self.study, self.entry, rule))
            .transpose()?;
        let program = self.setting.build.as_str();
        let mut inputs = self.inputs(rig, program);
        if sampling.early_end {
            inputs.add_json("early_end", &true);
        }
        claim(&request.out, &inputs.hash())?;
        let stage = self.stage();
        let plan = Campaigning {
            study: self.study,
            id: &self.entry.id,
            rig,
            seeds: self.seeds.clone(),
            numbers: request.first..request.first + self.count,
            keep: request.keep.unwrap_or(sampling.keep),
            early_end: sampling.early_end,
            on_failure: request.on_failure.unwrap_or(sampling.on_failure),
            until: until.as_ref(),
            folder: &request.out,
            judged_by: judged_by(self.study, rig, program),
            interrupt: &self.setting.cancel,
            stage: &stage,
        };
        let finished = plan.run()?;
        let description_gaps = plan.gaps(&finished);
        drop(stage);
        let met = until
            .as_ref()
            .map(|it| it.is_met(finished.tally.completions(it.subject())));
        let verdicts = self.verdicts(&finished)?;
        // The stopping rule's own test stands in place of the other where both ask the same.
        let is_of_rule = |it: &Alone| {
            rule.as_ref().is_some_and(|rule| {
                let same = rule
                    .threshold
                    .is_none_or(|value| value == it.threshold.value);
                same && rule.requirement == it.requirement
            })
        };
        let own = verdicts.iter().filter(|it| !is_of_rule(it));
        let outcomes = own.map(|it| match it.verdict {
            Verdict::Satisfied => Outcome::Holds,
            Verdict::Violated | Verdict::Conflicting => Outcome::Violated,
            Verdict::Undecided | Verdict::NotCovered => Outcome::Inconclusive,
        });
        let outcome = outcomes.chain([match met {
            None | Some(Some(true)) => Outcome::Holds,
            Some(Some(false)) => Outcome::Violated,
            Some(None) => Outcome::Inconclusive,
        }]);
        let outcome = outcome.max().unwrap_or(Outcome::Holds);
        let report = SimulateReport {
            verdicts,
            until: finished.stopped.clone(),
            table: Some(finished.table.display().to_string()),
            estimates: self.estimates(&finished)?,
            failures: self.failures(&finished)?,
            description_gaps,
            ..self.report(rig, finished.tally.runs(), &|number| {
                request.out.join(rig.recording_name(number))
            })
        };
        Ok(SimulatedEpisodes {
            report,
            cost: Some(finished.cost),
            outcome,
        })
    }

    /// Records episodes as ROS 2 bags, which are not judged.
    fn ros2(&self, rig: &dyn Rig) -> Result<SimulatedEpisodes, Problem> {
        let Some(scenario) = self.scenario() else {
            return Err(Problem::new(
                "not-a-simulation",
                format!("`{}` leaves recordings of its own", self.entry.id),
            )
            .remedy("record its signals"));
        };
        if self.request.until.is_some() || self.request.keep.is_some() {
            return Err(Problem::new(
                "ros2-not-judged",
                "recordings as ROS 2 bags are all kept and not judged",
            )
            .remedy("leave out the stopping rule and what is kept, or record the simulation's own signals"));
        }
        let table = Ros2Table::beside(&self.study.folder.join(scenario), &self.study.reach)?;
        let mut inputs = self.inputs(rig, self.setting.build.as_str());
        inputs.add("ros2", table.text.as_bytes());
        let folder = &self.request.out;
        claim(folder, &inputs.hash())?;
        let numbers = self.request.first..self.request.first + self.count;
        let stage = self.stage();
        let interrupt = &self.setting.cancel;
        let write = |trace: &trace::Trace, path: &Path| table.write(trace, path);
        let written = record_with(rig, &self.seeds, numbers, folder, interrupt, &stage, write)?;
        drop(stage);
        let left_out: u64 = written.iter().map(|(_, left_out)| left_out).sum();
        if left_out > 0 {
            self.setting.events.say(&format!(
                "{left_out} messages are not written: a truth value, a name or a whole number is missing there"
            ));
        }
        let report = self.report(rig, self.count, &|number| {
            folder.join(rig.recording_name(number))
        });
        Ok(SimulatedEpisodes {
            report,
            cost: None,
            outcome: Outcome::Holds,
        })
    }

    fn scenario(&self) -> Option<&Path> {
        self.entry.work.simulated_file()
    }

    fn stage(&self) -> host::Stage {
        let title = format!("{}: episodes", self.entry.id);
        self.setting.events.begin(&title, self.count)
    }

    /// What the recordings depend on.
    fn inputs(&self, rig: &dyn Rig, program: &str) -> Inputs {
        let mut inputs = Inputs::default();
        rig.own_inputs(&mut inputs);
        if !rig.is_outside() {
            inputs.add("program", program.as_bytes());
        }
        inputs.add_json("seed", &self.seeds.of(0));
        inputs
    }

    fn report(
        &self,
        rig: &dyn Rig,
        episodes: u64,
        place: &dyn Fn(u64) -> PathBuf,
    ) -> SimulateReport {
        let tool = rig.tool();
        let numbers = self.request.first..self.request.first + episodes;
        let kept = numbers.map(|number| (number, place(number)));
        let kept = kept.filter(|(_, path)| path.exists());
        SimulateReport {
            format: "1.4".into(),
            evidence: self.entry.id.clone(),
            engine: format!("{} {}", tool.name, tool.version)
                .trim_end()
                .to_owned(),
            episodes,
            recordings: kept
                .map(|(number, path)| RecordingReport {
                    file: path.display().to_string(),
                    seed: self.seeds.of(number),
                })
                .collect(),
            estimates: Vec::new(),
            verdicts: Vec::new(),
            failures: Vec::new(),
            description_gaps: rig.gaps().to_vec(),
            until: None,
            table: None,
        }
    }

    fn estimates(&self, finished: &Finished) -> Result<Vec<EstimateReport>, Problem> {
        let level = technique::confidence(self.study.about.confidence)?;
        let subjects = self.study.forms.subjects.iter().map(|form| &form.subject);
        let decided = subjects.map(|subject| (subject, finished.tally.sample(subject)));
        Ok(decided
            .filter(|(_, sample)| sample.trials > 0)
            .map(|(subject, sample)| {
                let ends = finished.tally.completions(subject);
                let [lowest, highest] = ends.map(|end| stats::confidence_sequence(end, level));
                EstimateReport {
                    subject: subject.clone(),
                    count: sample.successes,
                    trials: sample.trials,
                    undecided: ends[0].trials - sample.trials,
                    low: lowest.low,
                    high: highest.high,
                }
            })
            .collect())
    }

    /// What the episodes show of requirements with a threshold.
    fn verdicts(&self, finished: &Finished) -> Result<Vec<Alone>, Problem> {
        let level = technique::confidence(self.study.about.confidence)?;
        let findings = finished.tally.findings(self.study, finished.intervals)?;
        let findings = technique::counting_undecided(self.study, self.entry, findings)?;
        let requirements = &self.study.requirements;
        Ok(evidence::alone(
            (&self.entry.id, Step::of(self.entry.work.technique())),
            requirements,
            &findings,
            level,
        ))
    }

    fn failures(&self, finished: &Finished) -> Result<Vec<FailureReport>, Problem> {
        let level = technique::confidence(self.study.about.confidence)?;
        let failed = finished.tally.failed();
        Ok(failed
            .map(|(kind, sample)| {
                let interval = stats::confidence_sequence(sample, level);
                let first = finished.first_failed.get(&kind).copied();
                let first = first.unwrap_or(self.request.first);
                FailureReport {
                    kind,
                    count: sample.successes,
                    trials: sample.trials,
                    low: interval.low,
                    high: interval.high,
                    first_episode: first,
                    seed: self.seeds.of(first).to_string(),
                    said: words_of(&self.request.out, first).display().to_string(),
                }
            })
            .collect())
    }
}

/// The file that says which campaign a folder's recordings are of.
const MARK: &str = "campaign";

/// Recordings that are already there are gone on with if they are of the same
/// campaign; others are neither taken for ours nor overwritten.
fn claim(folder: &Path, campaign: &str) -> Result<(), Problem> {
    std::fs::create_dir_all(folder).map_err(|error| Problem::cannot_write(folder, &error))?;
    let mark = folder.join(MARK);
    let entries =
        std::fs::read_dir(folder).map_err(|error| Problem::cannot_read(folder, &error))?;
    let occupied = entries
        .flatten()
        .any(|e| e.file_name().to_string_lossy().starts_with("episode-"));
    let same = std::fs::read_to_string(&mark).is_ok_and(|text| text.trim() == campaign);
    if occupied && !same {
        return Err(Problem::new(
            "folder-not-empty",
            format!(
                "{} already holds recordings of something else",
                folder.display()
            ),
        )
        .remedy("name a new folder"));
    }
    write_whole(&mark, format!("{campaign}\n").as_bytes())
}
