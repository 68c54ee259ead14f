//! One episode of an exploration: what it showed.

use super::abstraction::{AbstractTrace, Abstraction, Class};
use super::bench::{OpenBench, failed};
use super::situations::Situations;
use crate::problem::Problem;
use crate::study::Study;
use crate::talk::Interrupt;
use crate::technique::judging::Judges;
use campaign::Situation;
use evidence::Subject;
use std::collections::BTreeMap;
use stimulus::Stimulus;
use temporal::monitor::Verdict;
use testbench::SimError;

/// What watches episodes.
pub struct Watching<'a> {
    /// The study.
    pub study: &'a Study,
    /// The bench.
    pub bench: &'a OpenBench,
    /// All monitors of the study.
    pub judges: Judges<'a>,
    /// How recordings are held against the model, if they are.
    pub abstraction: Option<&'a Abstraction>,
    /// What situations are told.
    pub situations: Situations,
}

/// What an episode showed.
#[derive(Clone, Debug, Default)]
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
    /// The least robustness of each requirement, if it has one.
    pub robustness: BTreeMap<String, f64>,
    /// Simulated time.
    pub simulated_secs: f64,
    /// Why the episode could not be run to its end.
    pub broken: Option<String>,
}

impl Watching<'_> {
    /// Runs an episode and looks at it.
    pub fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Shown, Problem> {
        let recorded = match self.bench.run(stimulus, seed, interrupt) {
            Ok(recorded) => recorded,
            // What the stimulus brought about is a result; what it cannot be is a mistake.
            Err(error @ (SimError::Unstable { .. } | SimError::Trace(_))) => {
                return Ok(Shown {
                    broken: Some(error.to_string()),
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
        let mut shown = Shown {
            simulated_secs: recorded.sim_secs,
            situation: self.situations.of(stimulus, &recorded.trace)?,
            ..Shown::default()
        };
        for judgement in self.judges.judge(&recorded.trace)? {
            if judgement.reading.is_some() {
                continue;
            }
            let findings = judgement.findings;
            let id = judgement.subject.id().to_owned();
            if let Some(robustness) = findings.robustness {
                shown.robustness.insert(id.clone(), robustness.low);
            }
            if findings.triggered > 0 {
                shown.triggered.push(id.clone());
            }
            match (judgement.subject, findings.verdict) {
                (Subject::Requirement(_), Verdict::Violated) => shown.violated.push(id),
                (Subject::FailureMode(_), Verdict::Violated) => shown.failure_modes.push(id),
                _ => {}
            }
        }
        if let Some(abstraction) = self.abstraction {
            shown.abstracted = abstraction.of_trace(&recorded.trace)?;
            shown.unknown = abstraction.unknown(&shown.abstracted);
        }
        Ok(shown)
    }
}
