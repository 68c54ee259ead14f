//! Episodes in contexts: the bench's own test with the parameters of a context, judged for one
//! requirement.

use super::super::bench::OpenBench;
use super::super::plan::{DisagreementData, Plan};
use crate::technique::campaign::{OnLine, ended};
use diagnostic::Problem;
use evidence::FailureKind;
use host::Cancel;
use judging::Judges;
use serde::{Deserialize, Serialize};
use stimulus::{Point, Space, Stimulus};
use study::Study;
use temporal::monitor::Verdict;
use trace::Trace;

/// What became of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Whether the requirement held; `None` if it could not be judged.
    pub held: Option<bool>,
    /// Simulated time.
    pub simulated_secs: f64,
    /// What ended it, if it did not end by itself.
    #[serde(default)]
    pub failed: Option<FailureKind>,
}

/// What runs episodes in contexts.
pub struct Contexts<'a> {
    bench: &'a OpenBench,
    judges: Judges<'a>,
    layout: Trace,
    /// The declared contexts.
    pub space: Space,
    test: stimulus::AbstractTest,
    requirement: String,
    early_end: bool,
}

impl<'a> Contexts<'a> {
    /// Holds the plan against the study and the bench.
    pub fn new(
        study: &'a Study,
        plan: &Plan,
        data: &DisagreementData,
        bench: &'a OpenBench,
        interrupt: &Cancel,
    ) -> Result<Self, Problem> {
        let space = Space {
            parameters: data.parameter.clone(),
            constraints: Vec::new(),
        };
        space
            .check()
            .map_err(|e| plan.mistake("[[disagreement.parameter]]", e.to_string()))?;
        let test = bench.own_tests().iter().find(|t| t.name == data.test);
        let test = test.cloned().ok_or_else(|| {
            plan.mistake(&data.test, format!("the bench has no test `{}`", data.test))
        })?;
        let id = &data.requirement;
        if study.forms.by_id(id).is_none_or(|f| f.monitor.is_none()) {
            let message = format!("the study has no requirement `{id}` with a monitor");
            return Err(plan.mistake(id, message));
        }
        Ok(Self {
            requirement: data.requirement.clone(),
            early_end: plan.data.budget.early_end,
            bench,
            judges: Judges::new(study, |subject| subject.id() == data.requirement)?,
            layout: bench.layout(interrupt)?,
            space,
            test,
        })
    }

    /// The test in a context.
    pub fn stimulus(&self, context: &Point) -> Result<Stimulus, Problem> {
        let stimulus = self.space.stimulus(&self.test, context);
        stimulus.map_err(|e| Problem::new("bad-exploration", e.to_string()))
    }

    /// Runs an episode until the requirement is decided in it. A program that cannot be set up in the
    /// first episode is an error.
    pub fn run(
        &self,
        stimulus: &Stimulus,
        (seed, is_first): (u64, bool),
        interrupt: &Cancel,
    ) -> Result<Outcome, Problem> {
        if interrupt.is_cancelled() {
            return Err(Problem::interrupted());
        }
        let judges = [&self.judges];
        let mut on_line = OnLine::new(&judges, &self.layout, false)?;
        if self.early_end {
            on_line = on_line.until_decided(&self.requirement);
        }
        let recorded = self.bench.watched(stimulus, seed, &mut on_line, interrupt);
        let run = ended(recorded, seed, is_first)?;
        let Some(recorded) = run.recorded else {
            return Ok(Outcome {
                held: None,
                simulated_secs: 0.0,
                failed: run.failed,
            });
        };
        let judgements = on_line.finish(recorded.trace.complete)?;
        let mut judgements = judgements.iter().flatten();
        let main = judgements.find(|j| j.reading.is_none());
        let held = main.and_then(|judgement| match judgement.findings.verdict {
            Verdict::Satisfied => Some(true),
            Verdict::Violated => Some(false),
            Verdict::NotCovered | Verdict::Inconclusive => None,
        });
        Ok(Outcome {
            held,
            simulated_secs: recorded.sim_secs,
            failed: run.failed,
        })
    }
}
