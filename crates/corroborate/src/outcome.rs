//! What was found, as an exit code for scripts and CI: for each kind of report the rule by which it ends.

use crate::corroboration;
use crate::pack::{PackSignature, PackVerification};
use crate::requirements::exchange::Verdict;
use crate::technique::exploration::ExplorationReport;
use crate::{
    CompareReport, EnginesReport, ExchangeReport, RareReport, ReplayReport, RequirementsReport,
    VerifyReport, replay::RegressionsReport,
};
use evidence::{
    CalibrationReport, Diagnosis, DisagreementMap, Likeness, SearchEnd, Stopped, StudyResult,
};
use judging::MonitorReport;
use query::{CheckReport, PropertyReport};

/// How a command that could do its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// All requirements are satisfied on the step that they need, and no current evidence conflicts.
    Holds,
    /// It was interrupted before what was planned was over; what was found so
    /// far is kept.
    Interrupted,
    /// Something could not be decided, or is satisfied for a model or in simulation only.
    Inconclusive,
    /// The work is done but some of its data could not be kept or read.
    DataLost,
    /// Part of the input means nothing; what was asked besides is answered.
    Wrong,
    /// A requirement is violated (of the system, in simulation or for a model), or evidence conflicts.
    Violated,
}

impl Outcome {
    /// The exit code: 0, 1, 2, 3 or 130. (2 is also that of errors that end
    /// a command, 101 a bug of ours.)
    pub fn exit_code(self) -> u8 {
        match self {
            Outcome::Holds => 0,
            Outcome::Violated => 1,
            Outcome::Wrong => 2,
            Outcome::Interrupted => 130,
            Outcome::Inconclusive | Outcome::DataLost => 3,
        }
    }
}

/// What says how its work ended.
pub trait Ended {
    /// How it ended.
    fn outcome(&self) -> Outcome;
}

/// The first of these that is so, from the gravest on; otherwise all holds.
fn first(found: &[(bool, Outcome)]) -> Outcome {
    let found = found.iter().find(|(is_so, _)| *is_so);
    found.map_or(Outcome::Holds, |(_, outcome)| *outcome)
}

impl Ended for StudyResult {
    fn outcome(&self) -> Outcome {
        corroboration::outcome(self)
    }
}

/// Whether a pair conflicts, or one is inconclusive.
impl Ended for CompareReport {
    fn outcome(&self) -> Outcome {
        let any = |wanted| self.comparisons.iter().any(|c| c.outcome == wanted);
        first(&[
            (any(evidence::Outcome::Conflicts), Outcome::Violated),
            (any(evidence::Outcome::Inconclusive), Outcome::Inconclusive),
        ])
    }
}

/// Whether everything that was checked holds.
impl Ended for VerifyReport {
    fn outcome(&self) -> Outcome {
        first(&[(!self.faults.is_empty(), Outcome::Violated)])
    }
}

/// Whether every byte of a pack is as it was written, and its signature was verified.
impl Ended for PackVerification {
    fn outcome(&self) -> Outcome {
        let is_signed = matches!(self.signature, PackSignature::Valid { .. });
        first(&[
            (!self.faults.is_empty(), Outcome::Violated),
            (!is_signed, Outcome::Inconclusive),
        ])
    }
}

/// What is false is that, whatever else could not be answered or means nothing.
impl Ended for CheckReport {
    fn outcome(&self) -> Outcome {
        let any = |test: &dyn Fn(&PropertyReport) -> bool| self.properties.iter().any(test);
        let is_lost = |p: &PropertyReport| {
            p.error.is_some() || p.certificate.as_ref().is_some_and(|c| !c.is_good())
        };
        let no_distribution = self.distributions.iter().any(|d| d.error.is_some());
        first(&[
            (self.interrupted.is_some(), Outcome::Interrupted),
            (
                any(&|p| p.result.as_deref() == Some("false")),
                Outcome::Violated,
            ),
            (any(&|p| p.is_wrong()), Outcome::Wrong),
            (no_distribution || any(&is_lost), Outcome::Inconclusive),
        ])
    }
}

/// Verdicts on what could be read come before what could not.
impl Ended for MonitorReport {
    fn outcome(&self) -> Outcome {
        first(&[
            (self.is_violated(), Outcome::Violated),
            (!self.is_complete(), Outcome::DataLost),
            (self.is_inconclusive(), Outcome::Inconclusive),
        ])
    }
}

/// Whether forms drifted apart or do not agree on a recording.
impl Ended for RequirementsReport {
    fn outcome(&self) -> Outcome {
        let is_apart = !self.drift.is_empty() || !self.differences.is_empty();
        first(&[
            (is_apart, Outcome::Violated),
            (!self.lost.is_empty(), Outcome::DataLost),
        ])
    }
}

/// Whether both sides were edited, or a sentence of the study means something else than FRET's formulas.
impl Ended for ExchangeReport {
    fn outcome(&self) -> Outcome {
        let mut sentences = self.sentences.iter().filter_map(|it| it.own_runs.as_ref());
        let is_apart = sentences.any(|it| it.verdict == Verdict::Differs);
        first(&[
            (!self.conflicts.is_empty(), Outcome::Inconclusive),
            (is_apart, Outcome::Violated),
        ])
    }
}

/// Whether somebody is suspected by substantial evidence (a Bayes factor of 10), and nothing later has fixed it.
impl Ended for Diagnosis {
    fn outcome(&self) -> Outcome {
        let mut suspects = self.suspects.iter();
        let is_open = suspects.any(|it| it.score >= 1.0 && it.resolved_by.is_none());
        first(&[(is_open, Outcome::Violated)])
    }
}

/// Whether something was found. Simulators that fail say nothing of the robot; what was found stands, whatever else was
/// lost.
impl Ended for ExplorationReport {
    fn outcome(&self) -> Outcome {
        let findings = || self.found.findings.iter();
        let is_of_robot = findings().any(|it| !it.shows.is_of_simulator());
        let is_lost = findings().any(|it| it.shows.is_of_simulator() || !it.found.replayed);
        first(&[
            (
                self.found.stopped == Stopped::Interrupted,
                Outcome::Interrupted,
            ),
            (is_of_robot, Outcome::Violated),
            (is_lost, Outcome::DataLost),
        ])
    }
}

/// Whether formal model and simulation differ anywhere.
impl Ended for DisagreementMap {
    fn outcome(&self) -> Outcome {
        match self.ended {
            SearchEnd::Interrupted => Outcome::Interrupted,
            _ if self.shares.differs > 0.0 => Outcome::Violated,
            SearchEnd::Decided => Outcome::Holds,
            SearchEnd::Budget => Outcome::Inconclusive,
        }
    }
}

/// Whether plain episodes contradict an estimate, or some event has none.
impl Ended for RareReport {
    fn outcome(&self) -> Outcome {
        first(&[
            (self.is_contradicted(), Outcome::Violated),
            (!self.is_complete(), Outcome::Inconclusive),
        ])
    }
}

/// Whether the fitted simulator is like what it was held against.
impl Ended for CalibrationReport {
    fn outcome(&self) -> Outcome {
        match self.conclusion {
            Likeness::Equivalent => Outcome::Holds,
            Likeness::Different => Outcome::Violated,
            Likeness::Undecided | Likeness::Fit => Outcome::Inconclusive,
        }
    }
}

/// Whether the engines agree in verdicts and failures, or repeat themselves.
impl Ended for EnginesReport {
    fn outcome(&self) -> Outcome {
        first(&[(!self.is_same(), Outcome::Violated)])
    }
}

/// Whether the episode shows again what it showed, in the same recording.
impl Ended for ReplayReport {
    fn outcome(&self) -> Outcome {
        first(&[
            (self.shown == Some(false), Outcome::Violated),
            (self.same_bytes == Some(false), Outcome::DataLost),
        ])
    }
}

/// Whether every regression does what is expected of it.
impl Ended for RegressionsReport {
    fn outcome(&self) -> Outcome {
        first(&[(!self.all_as_expected(), Outcome::Violated)])
    }
}
