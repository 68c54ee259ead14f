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

/// What an episode says of a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// It shows it.
    Shown,
    /// It was put to the test and does not show it.
    NotShown,
    /// It does not show it and does not show the contrary, for this reason.
    Undecided(String),
}

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
        Ok(self.said(recorded)? == Said::Shown)
    }

    /// Whether an episode shows it, and if not, whether it was put to the test.
    pub fn said(&self, recorded: &Recorded) -> Result<Said, Problem> {
        let failure = recorded.failure.as_ref();
        let ended =
            failure.map(|it| format!("the episode ended by another failure: {}", kind_of(it)));
        let step = match &self.shows {
            Shows::Failed(kind) => {
                return Ok(match ended {
                    _ if failure.map(kind_of) == Some(*kind) => Said::Shown,
                    None => Said::NotShown,
                    Some(reason) => Said::Undecided(reason),
                });
            }
            Shows::Violated(_) | Shows::FailureMode(_) => return self.judged(recorded),
            Shows::Unknown(step) => step,
        };
        let Some(abstraction) = &self.abstraction else {
            return Ok(Said::NotShown);
        };
        let abstracted = abstraction.of_trace(&recorded.trace)?;
        let is_it = |(from, to): &(u64, Option<u64>)| {
            abstraction.describe(*from) == step.from
                && to.map(|to| abstraction.describe(to)) == step.to
        };
        Ok(match abstraction.unknown(&abstracted).iter().any(is_it) {
            true => Said::Shown,
            false if abstracted.complete => Said::NotShown,
            false => {
                let cut = || "the recording is cut short, and may show it later".to_owned();
                Said::Undecided(ended.unwrap_or_else(cut))
            }
        })
    }

    /// What the main monitor says.
    fn judged(&self, recorded: &Recorded) -> Result<Said, Problem> {
        let judgements = self.judges.judge(&recorded.trace)?;
        let main = judgements.iter().filter(|j| j.reading.is_none());
        let verdicts: Vec<Verdict> = main.map(|j| j.findings.verdict).collect();
        let has = |verdict: Verdict| verdicts.contains(&verdict);
        Ok(
            match (
                has(Verdict::Violated),
                has(Verdict::NotCovered),
                has(Verdict::Inconclusive),
            ) {
                (true, ..) => Said::Shown,
                (_, true, _) => {
                    Said::Undecided("it never came up: its trigger was not met".to_owned())
                }
                (.., true) => Said::Undecided("the recording does not decide it".to_owned()),
                _ => Said::NotShown,
            },
        )
    }
}
