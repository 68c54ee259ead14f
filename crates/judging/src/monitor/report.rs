//! The form of the verdicts on recordings.

use super::asked::Asked;
use crate::recording::JudgedRecording;
use crate::{Judgement, Responsible, Robustness as FoundRobustness, Violation, run_verdict};
use evidence::{RunVerdict, Subject};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use temporal::monitor::Verdict;

/// Why there is no robustness where truth values decide and no comparison does.
pub const DECIDED_BY_NO_NUMBER: &str = "what decided it is true or false, and no number";

/// What `monitor --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MonitorReport {
    /// Version of this form.
    pub format: String,
    /// What has a meaning that is perhaps not meant.
    pub warnings: Vec<String>,
    /// One for each recording.
    pub recordings: Vec<RecordingVerdicts>,
    /// One for each monitor, over all recordings.
    pub totals: Vec<Total>,
}

/// The verdicts on one recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RecordingVerdicts {
    /// The file.
    pub file: String,
    /// Whether it was recorded to its end and all of it was read.
    pub complete: bool,
    /// What is missing, if it was not.
    pub lost: Option<String>,
    /// What else is to be known about how it was read.
    pub notes: Vec<String>,
    /// How many instants were judged; for a trace in columns, its rows.
    pub instants: u64,
    /// The file with verdicts and robustness over time.
    pub shown_in: Option<String>,
    /// One for each monitor.
    pub verdicts: Vec<SubjectVerdict>,
}

/// The verdict of one monitor on one recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SubjectVerdict {
    /// The requirement or failure mode.
    pub subject: String,
    /// The reading, if it is not the main one.
    pub reading: Option<String>,
    /// The verdict. For a failure mode, `violated` means that it occurred.
    pub verdict: RunVerdict,
    /// How often the precondition was met.
    pub covered: u64,
    /// How often all postconditions were.
    pub passed: u64,
    /// How often one was not.
    pub failed: u64,
    /// How far it is from another verdict, in the SI unit of what it compares:
    /// above 0 satisfied, below 0 violated.
    pub robustness: Option<Robustness>,
    /// Why there is no robustness, if there is none: it could not be computed,
    /// or no comparison of numbers decided the verdict.
    pub no_robustness: Option<String>,
    /// When the verdict was determined, if before the end of the recording;
    /// seconds of its clock.
    pub decided_at_secs: Option<f64>,
    /// From when on it was judged, if not from its first sample on: when all
    /// the signals that it reads had a value; seconds of the recording's clock.
    pub judged_from_secs: Option<f64>,
    /// How long the recording would have to be from the first trigger on, if the verdict is open only because it ends before: `10 s`.
    pub ends_before: Option<String>,
    /// Within what of its end windows began that are pending there and that the verdict leaves out: `5 s`.
    pub left_out: Option<String>,
    /// The part of the recording that shows the violation.
    pub violation: Option<ShownViolation>,
    /// When the first failure shows, in seconds of the recording's clock.
    pub failed_at_secs: Option<f64>,
    /// The proposition that decided then.
    pub failed_proposition: Option<String>,
    /// What that proposition means.
    pub failed_meaning: Option<String>,
    /// Whether it is a requirement's, in its main reading.
    #[serde(skip)]
    is_main: bool,
}

/// What the robustness can be, given what was recorded.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Robustness {
    /// The least; null if there is no limit.
    pub least: Option<f64>,
    /// The greatest; null if there is no limit.
    pub greatest: Option<f64>,
    /// False if triggers fell within an instance of the stages under way: then
    /// only these bounds are known.
    pub exact: bool,
}

/// The shortest part of a recording that shows a violation.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ShownViolation {
    /// Where it begins, in seconds of the recording's clock.
    pub from_secs: f64,
    /// Where it ends.
    pub to_secs: f64,
    /// What is responsible.
    pub responsible: Vec<ShownResponsible>,
}

/// A proposition that is part of the reason.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ShownResponsible {
    /// Its name, or its text.
    pub proposition: String,
    /// What it means, if it is named.
    pub meaning: Option<String>,
    /// What it was.
    pub value: bool,
    /// From when on, in seconds.
    pub from_secs: f64,
    /// Until when.
    pub to_secs: f64,
    /// The signals that it reads.
    pub signals: Vec<ShownSignal>,
}

/// A signal with its unit and frame.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ShownSignal {
    /// Its name, `/topic.field`.
    pub name: String,
    /// Its unit; empty if it has none or none is known.
    pub unit: String,
    /// The frame of its values, if they have one.
    pub frame: Option<String>,
}

/// One monitor over all recordings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Total {
    /// The requirement or failure mode.
    pub subject: String,
    /// The reading, if it is not the main one.
    pub reading: Option<String>,
    /// Recordings in which its precondition was met and a verdict reached.
    pub covered: u64,
    /// Recordings that passed.
    pub passed: u64,
    /// Recordings that failed.
    pub failed: u64,
    /// Recordings that ended before a verdict.
    pub inconclusive: u64,
}

impl MonitorReport {
    /// A report on nothing yet.
    pub(super) fn new(warnings: Vec<String>) -> Self {
        Self {
            format: "1.4".into(),
            warnings,
            recordings: Vec::new(),
            totals: Vec::new(),
        }
    }

    /// Whether a requirement is violated, in its main reading, in a recording that is complete: in another one the violation may
    /// be due to what is lost. A failure mode that occurs is a finding, not a violation.
    pub fn is_violated(&self) -> bool {
        let mut complete = self.recordings.iter().filter(|it| it.complete);
        complete.any(|it| it.comes_to(Verdict::Violated))
    }

    /// Whether all recordings are complete.
    pub fn is_complete(&self) -> bool {
        self.recordings.iter().all(|it| it.complete)
    }

    /// Whether a recording ended before a verdict on a requirement, in its main reading.
    pub fn is_inconclusive(&self) -> bool {
        let mut recordings = self.recordings.iter();
        recordings.any(|it| it.comes_to(Verdict::Inconclusive))
    }
}

impl RecordingVerdicts {
    /// Whether a requirement, in its main reading, has this verdict.
    fn comes_to(&self, verdict: Verdict) -> bool {
        let mut main = self.verdicts.iter().filter(|it| it.is_main);
        main.any(|it| it.verdict == run_verdict(verdict))
    }

    /// What was found in `file`.
    pub(super) fn new(asked: &Asked<'_>, file: &Path, found: &JudgedRecording<'_>) -> Self {
        Self {
            file: file.display().to_string(),
            complete: found.complete,
            lost: (!found.lost.is_empty()).then(|| found.lost.join("; ")),
            notes: found.notes.clone(),
            instants: found.instants,
            shown_in: None,
            verdicts: found
                .judgements
                .iter()
                .map(|judgement| SubjectVerdict::new(asked, found, judgement))
                .collect(),
        }
    }
}

impl SubjectVerdict {
    fn new(asked: &Asked<'_>, found: &JudgedRecording<'_>, judgement: &Judgement<'_>) -> Self {
        let findings = &judgement.findings;
        let violation = findings.violation.as_ref();
        let responsible = violation.and_then(|v| v.responsible.last());
        let by_numbers = findings.robustness.and_then(FoundRobustness::by_numbers);
        Self {
            subject: judgement.subject.id().to_owned(),
            reading: judgement.reading.map(str::to_owned),
            verdict: run_verdict(findings.verdict),
            covered: findings.triggered,
            passed: findings.passed,
            failed: findings.failed,
            robustness: by_numbers.map(|found| Robustness {
                least: found.low.is_finite().then_some(found.low),
                greatest: found.high.is_finite().then_some(found.high),
                exact: found.exact,
            }),
            no_robustness: match findings.no_robustness {
                Some(reason) => Some(reason.to_string()),
                None if by_numbers.is_none() && findings.robustness.is_some() => {
                    Some(DECIDED_BY_NO_NUMBER.to_owned())
                }
                None => None,
            },
            decided_at_secs: findings.decided_at_secs,
            judged_from_secs: findings.judged_from_secs,
            ends_before: findings.ends_before.map(|asked| asked.to_string()),
            left_out: findings.left_out.map(|asked| asked.to_string()),
            violation: violation.map(|violation| shown_violation(asked, found, violation)),
            failed_at_secs: violation.map(|v| v.to_secs),
            failed_proposition: responsible.map(|r| r.proposition.clone()),
            failed_meaning: responsible.and_then(|r| asked.meaning(&r.proposition)),
            is_main: matches!(judgement.subject, Subject::Requirement(_))
                && judgement.reading.is_none(),
        }
    }
}

fn shown_violation(
    asked: &Asked<'_>,
    found: &JudgedRecording<'_>,
    violation: &Violation,
) -> ShownViolation {
    let shown = |part: &Responsible| ShownResponsible {
        proposition: part.proposition.clone(),
        meaning: asked.meaning(&part.proposition),
        value: part.value,
        from_secs: part.from_secs,
        to_secs: part.to_secs,
        signals: part
            .signals
            .iter()
            .map(|name| {
                let info = found.signals.get(name);
                ShownSignal {
                    name: name.clone(),
                    unit: info.map(|info| info.unit.clone()).unwrap_or_default(),
                    frame: info.and_then(|info| info.frame.clone()),
                }
            })
            .collect(),
    };
    ShownViolation {
        from_secs: violation.from_secs,
        to_secs: violation.to_secs,
        responsible: violation.responsible.iter().map(shown).collect(),
    }
}
