//! One episode of an exploration: what it showed.
//!
//! It is judged while it runs, and ended as soon as all monitors are
//! determined; if it is run for the sake of one requirement, as soon as that
//! one's is.

use super::abstraction::{AbstractTrace, Abstraction, Class};
use super::bench::{OpenBench, failed};
use super::code::matching;
use super::moments::{Moments, Signals};
use super::situations::Situations;
use crate::technique::campaign::{OnLine, is_of_physics, kind_of};
use campaign::Situation;
use diagnostic::Problem;
use evidence::{FailureKind, Subject};
use host::Cancel;
use judging::{Judgement, Judges, SpaceTime};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use stimulus::Stimulus;
use study::Study;
use temporal::monitor::Verdict;
use testbench::SimError;
use trace::{Predicate, Replay, Trace};

/// The part of an episode's seed that controllers are told: what every
/// language reads without rounding.
const CONTROLLERS_SEED: u64 = (1 << 53) - 1;

/// What watches episodes.
pub struct Watching<'a> {
    /// The study.
    pub study: &'a Study,
    /// The bench.
    pub bench: &'a OpenBench,
    /// All monitors of the study.
    pub judges: Judges<'a>,
    /// What searches go by, for each requirement that is searched.
    pub searched: BTreeMap<String, SpaceTime<'a>>,
    /// The channels of the bench's recordings.
    pub layout: Trace,
    /// Their signals.
    pub signals: Signals,
    /// What first holds when the task is over, if the plan says so.
    pub task_over: Option<Predicate>,
    /// Whether episodes end once all is decided.
    pub early_end: bool,
    /// How recordings are held against the model, if they are.
    pub abstraction: Option<&'a Abstraction>,
    /// What situations are told.
    pub situations: Situations,
    /// Where controllers leave which of their lines ran: `SEED.NAME.info` for
    /// each episode, in the format of lcov.
    pub code: Option<PathBuf>,
}

/// What an episode showed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// Requirements that it violates.
    pub violated: Vec<String>,
    /// Failure modes that occurred.
    pub failure_modes: Vec<String>,
    /// Requirements whose precondition was met.
    pub triggered: Vec<String>,
    /// What it was like.
    pub situation: Situation,
    /// What it did, in abstract states.
    pub abstracted: AbstractTrace,
    /// Steps that the model does not have.
    pub unknown: Vec<(Class, Option<Class>)>,
    /// When each of these was, in their order.
    pub unknown_secs: Vec<f64>,
    /// When violations and failure modes showed, by what was.
    pub shown_secs: BTreeMap<String, f64>,
    /// When the recording ended.
    pub end_secs: f64,
    /// When the task was over, if it was, and if anything says when that is.
    pub over_secs: Option<f64>,
    /// What signals it had.
    pub moments: Moments,
    /// The space-time robustness of the requirement for whose sake it was run,
    /// of what was seen until it ended; a number, or it says nothing.
    pub robustness: Option<f64>,
    /// Simulated time.
    pub simulated_secs: f64,
    /// Which lines of the controller's code ran, in the format of lcov.
    pub lcov: Option<String>,
    /// What of the robot's program or of the simulator ended the episode, if it did.
    pub failed: Option<FailureKind>,
    /// Why the physics gave no numbers, if that ended it. Nothing else is said of such an episode.
    pub broken: Option<String>,
}

impl Shown {
    /// When something showed that is worth a finding.
    fn times(&self) -> Vec<f64> {
        let failed = self.failed.map(|_| self.end_secs);
        let all = self.shown_secs.values().chain(&self.unknown_secs);
        all.copied().chain(failed).collect()
    }
}

impl Watching<'_> {
    /// Runs an episode and looks at it; `for_the_sake_of` a requirement, only
    /// until that is decided. A program that cannot be set up in the first
    /// episode is an error.
    pub fn run(
        &self,
        stimulus: &Stimulus,
        (seed, is_first): (u64, bool),
        for_the_sake_of: Option<&str>,
        interrupt: &Cancel,
    ) -> Result<Shown, Problem> {
        let judges = [&self.judges];
        // Whether the model has behaviour that is still to come, no monitor decides.
        let early_end = self.early_end && self.abstraction.is_none();
        let mut on_line = OnLine::new(&judges, &self.layout, early_end)?;
        if let Some(id) = for_the_sake_of.filter(|_| self.early_end) {
            on_line = on_line.until_decided(id);
        }
        let recorded = match self.bench.watched(stimulus, seed, &mut on_line, interrupt) {
            Ok(recorded) => recorded,
            // What the stimulus brought about is a result; what it cannot be is a mistake.
            // Whatever was seen until then, physics without numbers says nothing of the robot.
            Err(error) if is_of_physics(&error) => {
                let simulated_secs = match &error {
                    SimError::Unstable { time_secs, .. } => *time_secs,
                    _ => 0.0,
                };
                return Ok(Shown {
                    failed: Some(FailureKind::SimulatorFailed),
                    broken: Some(error.to_string()),
                    simulated_secs,
                    ..Shown::default()
                });
            }
            Err(error @ SimError::Stimulus { .. }) => {
                let test = format!("test `{}`", stimulus.test.name);
                return Err(failed(&error).about(&test).remedy(
                    "name what the bench has: its signals and parameters, and keys of its files",
                ));
            }
            Err(error) => return Err(failed(&error)),
        };
        let failed = recorded.failure.as_ref().map(kind_of);
        if let Some(failure) = recorded.failure.as_ref().filter(|it| it.in_setup) {
            return match is_first {
                // It has not worked once.
                true => Err(Problem::new("controller-failed", failure.words.clone())),
                false => Ok(Shown {
                    failed,
                    ..Shown::default()
                }),
            };
        }
        let shown = Shown {
            failed,
            simulated_secs: recorded.sim_secs,
            lcov: self.lcov(seed),
            situation: self.situations.of(stimulus, &recorded.trace)?,
            ..Shown::default()
        };
        let judged = on_line.finish(recorded.trace.complete)?;
        let judged = judged.into_iter().flatten().collect();
        self.looked_at(shown, &recorded.trace, judged, for_the_sake_of)
    }

    /// What there is to see in a recording.
    fn looked_at(
        &self,
        mut shown: Shown,
        trace: &Trace,
        judged: Vec<Judgement<'_>>,
        for_the_sake_of: Option<&str>,
    ) -> Result<Shown, Problem> {
        shown.end_secs = trace.end_secs().unwrap_or(0.0);
        for judgement in judged.into_iter().filter(|it| it.reading.is_none()) {
            let findings = judgement.findings;
            let id = judgement.subject.id().to_owned();
            if findings.triggered > 0 {
                shown.triggered.push(id.clone());
            }
            if findings.verdict == Verdict::Violated {
                let violation = findings.violation.map(|it| it.to_secs);
                let at_secs = violation.or(findings.decided_at_secs);
                let at_secs = at_secs.unwrap_or(shown.end_secs);
                shown.shown_secs.insert(id.clone(), at_secs);
            }
            match (judgement.subject, findings.verdict) {
                (Subject::Requirement(_), Verdict::Violated) => shown.violated.push(id),
                (Subject::FailureMode(_), Verdict::Violated) => shown.failure_modes.push(id),
                _ => {}
            }
        }
        if let Some(searched) = for_the_sake_of.and_then(|id| self.searched.get(id)) {
            shown.robustness = searched.of(trace)?;
        }
        if let Some(abstraction) = self.abstraction {
            shown.abstracted = abstraction.of_trace(trace)?;
            let unknown = abstraction.unknown_at(&shown.abstracted).into_iter();
            (shown.unknown, shown.unknown_secs) = unknown.unzip();
        }
        shown.over_secs = self.over_secs(&shown, trace)?;
        shown.moments = Moments::of(&self.signals, trace, &shown.times());
        Ok(shown)
    }

    /// When the task was over, if it was.
    fn over_secs(&self, shown: &Shown, trace: &Trace) -> Result<Option<f64>, Problem> {
        let Some(over) = &self.task_over else {
            let rests = |it: &Abstraction| it.rests_from_secs(&shown.abstracted);
            return Ok(self.abstraction.and_then(rests));
        };
        let over = over
            .bind(trace)
            .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
        let mut replay = Replay::new(trace);
        while let Some(sample) = replay.advance() {
            if over.eval(&replay) == Some(true) {
                return Ok(Some(sample.time_secs));
            }
        }
        Ok(None)
    }

    /// Whether anything says when the task is over.
    pub fn knows_end(&self) -> bool {
        self.task_over.is_some() || self.abstraction.is_some_and(Abstraction::rests)
    }

    /// What controllers left of an episode.
    fn lcov(&self, seed: u64) -> Option<String> {
        let told = seed & CONTROLLERS_SEED;
        let files = matching(&self.code.as_ref()?.join(format!("{told}.*info")));
        let texts = files
            .iter()
            .filter_map(|file| std::fs::read_to_string(file).ok());
        let text: String = texts.collect();
        (!text.is_empty()).then_some(text)
    }
}
