//! Verdicts and robustness over time, for a file that viewers open beside the
//! recording.
//!
//! Of a formula, what is known at each instant is shown, written when it
//! changes. Let [low, high] be the bounds of its robustness at the beginning,
//! given what has been seen so far and nothing of what comes. Shown is high,
//! the best that can still come out (so below 0 it is violated); where that
//! is unbounded, low, the least that is certain; and no number where neither
//! is bounded. For `always p` it is the worst so far, for `eventually p` the
//! best so far. At the end the robustness of the whole recording is shown, if
//! it is one number. Of stages the verdict is shown when it changes, and the
//! robustness at the end.
//!
//! Cost: at each instant that of `FormulaJudge::robustness_bounds`, which is
//! constant for most formulas.

use super::{Judgement, Judges, Session};
use diagnostic::Problem;
use recording::{ShownRequirement, ShownVerdict, VerdictFile};
use temporal::formula::RobustnessBounds;
use temporal::monitor::Verdict;

/// A file of verdicts that is being written while a recording is judged.
pub struct Shown {
    file: VerdictFile,
    lines: Vec<Line>,
    /// Log time of the last instant.
    last_nanos: Option<i64>,
}

/// What is shown of one monitor.
struct Line {
    requirement: ShownRequirement,
    verdict: Option<ShownVerdict>,
    robustness: Option<f64>,
}

impl Shown {
    /// Begins a file for all monitors; `texts` says what each requires.
    pub fn new(
        judges: &Judges<'_>,
        text: &dyn Fn(&evidence::Subject) -> String,
    ) -> Result<Self, Problem> {
        let mut file = VerdictFile::new().map_err(|error| failed(&error))?;
        let mut lines = Vec::new();
        for judge in &judges.judges {
            let id = match judge.reading {
                Some(reading) => format!("{} {reading}", judge.subject.id()),
                None => judge.subject.id().to_owned(),
            };
            let requirement = file
                .add_requirement(&id, &text(judge.subject))
                .map_err(|error| failed(&error))?;
            lines.push(Line {
                requirement,
                verdict: None,
                robustness: None,
            });
        }
        Ok(Self {
            file,
            lines,
            last_nanos: None,
        })
    }

    /// Writes what has changed with the last instant, which was logged at
    /// `log_nanos`.
    pub fn instant(&mut self, log_nanos: i64, session: &Session<'_, '_>) -> Result<(), Problem> {
        self.last_nanos = Some(log_nanos);
        let found = session.determined().zip(session.robustness_bounds());
        for (line, ((_, _, verdict), bounds)) in self.lines.iter_mut().zip(found) {
            if let Some(bounds) = bounds {
                line.robustness(&mut self.file, log_nanos, shown_of(bounds))?;
            }
            let verdict = verdict.map_or(ShownVerdict::Undecided, shown_verdict);
            line.verdict(&mut self.file, log_nanos, verdict, "")?;
        }
        Ok(())
    }

    /// Writes the verdicts of the whole recording; gives the file's bytes.
    pub fn finish(mut self, judgements: &[Judgement<'_>]) -> Result<Vec<u8>, Problem> {
        if let Some(log_nanos) = self.last_nanos {
            for (line, judgement) in self.lines.iter_mut().zip(judgements) {
                let findings = &judgement.findings;
                if let Some(robustness) = findings.robustness
                    && robustness.low == robustness.high
                {
                    line.robustness(&mut self.file, log_nanos, robustness.low)?;
                }
                let verdict = shown_verdict(findings.verdict);
                let reason = findings.violation.as_ref().map(reason).unwrap_or_default();
                line.verdict(&mut self.file, log_nanos, verdict, &reason)?;
            }
        }
        self.file.finish().map_err(|error| failed(&error))
    }
}

impl Line {
    fn robustness(
        &mut self,
        file: &mut VerdictFile,
        log_nanos: i64,
        value: f64,
    ) -> Result<(), Problem> {
        // By bits, so that no number is equal to no number.
        if self
            .robustness
            .is_some_and(|last| last.to_bits() == value.to_bits())
        {
            return Ok(());
        }
        self.robustness = Some(value);
        file.robustness(self.requirement, log_nanos, value)
            .map_err(|error| failed(&error))
    }

    fn verdict(
        &mut self,
        file: &mut VerdictFile,
        log_nanos: i64,
        verdict: ShownVerdict,
        reason: &str,
    ) -> Result<(), Problem> {
        // At the end the reason is known, too.
        if self.verdict == Some(verdict) && reason.is_empty() {
            return Ok(());
        }
        self.verdict = Some(verdict);
        file.verdict(self.requirement, log_nanos, verdict, reason)
            .map_err(|error| failed(&error))
    }
}

fn shown_of(bounds: RobustnessBounds) -> f64 {
    match (bounds.low.is_finite(), bounds.high.is_finite()) {
        (_, true) => bounds.high,
        (true, false) => bounds.low,
        _ => f64::NAN,
    }
}

fn shown_verdict(verdict: Verdict) -> ShownVerdict {
    match verdict {
        Verdict::NotCovered => ShownVerdict::NotCovered,
        Verdict::Satisfied => ShownVerdict::Satisfied,
        Verdict::Violated => ShownVerdict::Violated,
        Verdict::Inconclusive => ShownVerdict::Inconclusive,
    }
}

/// Why a requirement is violated, in one line.
fn reason(violation: &super::Violation) -> String {
    let parts: Vec<String> = violation
        .responsible
        .iter()
        .take(8)
        .map(|part| format!("`{}` is {}", part.proposition, part.value))
        .collect();
    format!(
        "from {:.3} s to {:.3} s: {}",
        violation.from_secs,
        violation.to_secs,
        parts.join(", ")
    )
}

fn failed(error: &dyn std::fmt::Display) -> Problem {
    Problem::new("cannot-write", format!("the verdicts over time: {error}"))
}
