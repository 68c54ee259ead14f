//! Whether a recording shows what a finding says.

use super::abstraction::Abstraction;
use super::formal::Formal;
use super::plan::Plan;
use crate::technique::campaign::kind_of;
use diagnostic::Problem;
use host::Cancel;
use judging::Judges;
use std::path::Path;
use study::{Shows, Study};
use temporal::monitor::Verdict;
use testbench::Recorded;

/// Judges recordings for what a finding shows.
pub struct ShowsJudge<'a> {
    shows: Shows,
    judges: Judges<'a>,
    abstraction: Option<Abstraction>,
}

impl<'a> ShowsJudge<'a> {
    /// Prepares to judge; the formal model of unknown behaviour is explored.
    pub fn new(study: &'a Study, shows: &Shows, interrupt: &Cancel) -> Result<Self, Problem> {
        let (Shows::Violated(id) | Shows::FailureMode(id)) = shows else {
            return Self::of_unknown(study, shows, interrupt);
        };
        if study.forms.by_id(id).is_none_or(|f| f.monitor.is_none()) {
            return Err(Problem::new(
                "bad-finding",
                format!("the study has no monitor for `{id}`"),
            )
            .remedy("name a requirement or a failure mode of the study"));
        }
        Ok(Self {
            shows: shows.clone(),
            judges: Judges::new(study, |subject| subject.id() == id)?,
            abstraction: None,
        })
    }

    fn of_unknown(study: &'a Study, shows: &Shows, interrupt: &Cancel) -> Result<Self, Problem> {
        let abstraction = match shows {
            Shows::Unknown(step) => {
                let plan = Plan::load(&study.folder, Path::new(&step.exploration))?;
                let model = plan.data.model.as_ref().ok_or_else(|| {
                    plan.mistake("", "it names no model, so no behaviour is unknown to it")
                })?;
                let formal = Formal::of_entry(study, model, interrupt)?;
                Abstraction::new(study, &plan, &formal)?
            }
            _ => None,
        };
        Ok(Self {
            shows: shows.clone(),
            judges: Judges::new(study, |_| false)?,
            abstraction,
        })
    }

    /// Whether an episode shows it.
    pub fn shows(&self, recorded: &Recorded) -> Result<bool, Problem> {
        let trace = &recorded.trace;
        if let Shows::Failed(kind) = self.shows {
            return Ok(recorded.failure.as_ref().map(kind_of) == Some(kind));
        }
        let Shows::Unknown(step) = &self.shows else {
            let judgements = self.judges.judge(trace)?;
            let mut main = judgements.iter().filter(|j| j.reading.is_none());
            return Ok(main.any(|j| j.findings.verdict == Verdict::Violated));
        };
        let Some(abstraction) = &self.abstraction else {
            return Ok(false);
        };
        let unknown = abstraction.unknown(&abstraction.of_trace(trace)?);
        Ok(unknown.iter().any(|(from, to)| {
            abstraction.describe(*from) == step.from
                && to.map(|to| abstraction.describe(to)) == step.to
        }))
    }
}
