//! What happens while a system is watched, as JSON lines and as text.

use evidence::{RunVerdict, Subject};
use judging::{JudgedTrace, Judgement, Robustness, Violation, run_verdict};
use schemars::JsonSchema;
use serde::Serialize;

/// One line of `watch --format json`.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct WatchLine {
    /// When it was noticed, in seconds since 1970.
    pub unix_secs: f64,
    /// What happened.
    #[serde(flatten)]
    pub event: WatchEvent,
}

/// What happened.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum WatchEvent {
    /// The connection is made.
    Connected {
        /// To what.
        to: String,
    },
    /// Judging begins.
    Judging {
        /// Version of this form.
        format: String,
        /// Where messages are recorded, if they are.
        recording: Option<String>,
        /// Signals whose topics are not there; they count as missing.
        absent: Vec<String>,
    },
    /// A topic was seen for the first time and is listened to.
    TopicAppeared {
        /// Its name.
        topic: String,
        /// The type of its messages.
        type_name: String,
        /// `outside`, or `simulation` for what our own test bench publishes.
        origin: String,
    },
    /// A wanted topic is not listened to.
    TopicRefused {
        /// Its name.
        topic: String,
        /// Why not.
        reason: String,
    },
    /// Messages are missing.
    Lost {
        /// Their topic, if it is known.
        topic: Option<String>,
        /// How many, at least.
        count: u64,
        /// `transport`, `overflow` (we were too slow), `undecodable` or
        /// `while-away` (between two connections).
        cause: String,
    },
    /// Nobody publishes the topic any more, or the connection broke.
    Disconnected {
        /// The topic; none for the whole connection.
        topic: Option<String>,
        /// What was noticed.
        reason: String,
    },
    /// What was disconnected is there again.
    Reconnected {
        /// The topic; none for the whole connection.
        topic: Option<String>,
        /// How long it was away, in seconds.
        away_secs: f64,
    },
    /// Something else that one should know.
    Notice {
        /// In words.
        text: String,
    },
    /// A verdict is determined: it will not change any more.
    Verdict {
        /// The verdict.
        #[serde(flatten)]
        verdict: LiveVerdict,
        /// From the arrival of the message that determined it to this line, in
        /// seconds.
        latency_secs: f64,
    },
    /// Watching has ended.
    End {
        /// Why.
        reason: String,
        /// One for each monitor.
        verdicts: Vec<LiveVerdict>,
        /// Messages that were received.
        received: u64,
        /// Messages that are known to be lost.
        lost: u64,
        /// Whether nothing was lost and no connection was interrupted.
        complete: bool,
        /// What is missing, a clause each.
        missing: Vec<String>,
        /// The instants that were judged.
        instants: u64,
        /// The recording of the run, if there is one.
        recording: Option<String>,
    },
}

/// The verdict of one monitor on a running system.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LiveVerdict {
    /// The requirement or failure mode.
    pub subject: String,
    /// `requirement` or `failure-mode`.
    pub kind: String,
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
    /// The least and the greatest that the robustness can be.
    pub robustness: Option<[Option<f64>; 2]>,
    /// When it was determined, in seconds from the first instant.
    pub decided_at_secs: Option<f64>,
    /// Why it is violated.
    pub violation: Option<LiveViolation>,
}

/// The shortest part of the run that shows a violation.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LiveViolation {
    /// Where it begins, in seconds from the first instant.
    pub from_secs: f64,
    /// Where it ends.
    pub to_secs: f64,
    /// What is responsible.
    pub responsible: Vec<LiveCause>,
}

/// A proposition that is part of the reason for a violation.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LiveCause {
    /// Its name, or its text.
    pub proposition: String,
    /// What it was.
    pub value: bool,
    /// The signals that it reads.
    pub signals: Vec<String>,
}

impl LiveVerdict {
    /// What a monitor says, as it is told.
    pub fn of(judgement: &Judgement<'_>) -> Self {
        let JudgedTrace {
            verdict,
            triggered,
            passed,
            failed,
            robustness,
            no_robustness: _,
            decided_at_secs,
            judged_from_secs: _,
            ends_before: _,
            left_out: _,
            violation,
        } = &judgement.findings;
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            subject: judgement.subject.id().to_owned(),
            kind: match judgement.subject {
                Subject::Requirement(_) => "requirement",
                Subject::FailureMode(_) => "failure-mode",
            }
            .into(),
            reading: judgement.reading.map(str::to_owned),
            verdict: run_verdict(*verdict),
            covered: *triggered,
            passed: *passed,
            failed: *failed,
            robustness: robustness
                .and_then(Robustness::by_numbers)
                .map(|it| [finite(it.low), finite(it.high)]),
            decided_at_secs: *decided_at_secs,
            violation: violation.as_ref().map(LiveViolation::of),
        }
    }

    /// The subject, with the reading if it is not the main one.
    pub fn label(&self) -> String {
        match &self.reading {
            Some(reading) => format!("{} (reading `{reading}`)", self.subject),
            None => self.subject.clone(),
        }
    }

    /// Why it is violated, in words; empty if it is not.
    pub fn why(&self) -> String {
        let Some(violation) = &self.violation else {
            return String::new();
        };
        let causes = violation.responsible.iter().map(|cause| {
            let value = if cause.value { "true" } else { "false" };
            format!("`{}` is {value}", cause.proposition)
        });
        let causes: Vec<String> = causes.collect();
        let (from, to) = (violation.from_secs, violation.to_secs);
        format!("from {from:.3} s to {to:.3} s: {}", causes.join(", "))
    }
}

impl LiveViolation {
    fn of(violation: &Violation) -> Self {
        let responsible = violation.responsible.iter().map(|part| LiveCause {
            proposition: part.proposition.clone(),
            value: part.value,
            signals: part.signals.clone(),
        });
        Self {
            from_secs: violation.from_secs,
            to_secs: violation.to_secs,
            responsible: responsible.collect(),
        }
    }
}

impl WatchEvent {
    /// The event in words, on one line.
    pub fn text(&self) -> String {
        let on = |topic: &Option<String>| match topic {
            Some(topic) => topic.clone(),
            None => "the connection".into(),
        };
        match self {
            Self::Connected { to } => format!("connected to {to}"),
            Self::Judging { recording, .. } => match recording {
                Some(path) => format!("judging; recording to {path}"),
                None => "judging; nothing is recorded (no --out)".into(),
            },
            Self::TopicAppeared {
                topic,
                type_name,
                origin,
            } => match origin.as_str() {
                "simulation" => format!("{topic} is published by the simulation ({type_name})"),
                _ => format!("{topic} appeared ({type_name})"),
            },
            Self::TopicRefused { topic, reason } => format!("{topic} is left out: {reason}"),
            Self::Lost {
                topic,
                count,
                cause,
            } => {
                let topic = topic.as_deref().unwrap_or("a topic not known");
                format!("LOST {count} of {topic} ({cause})")
            }
            Self::Disconnected { topic, reason } => {
                format!("{} is gone: {reason}", on(topic))
            }
            Self::Reconnected { topic, away_secs } => {
                format!("{} is back after {away_secs:.3} s", on(topic))
            }
            Self::Notice { text } => text.clone(),
            Self::Verdict { verdict, .. } => {
                let (label, why) = (verdict.label(), verdict.why());
                let said = match (verdict.kind.as_str(), verdict.verdict) {
                    ("failure-mode", RunVerdict::Violated) => "occurred",
                    ("failure-mode", RunVerdict::Satisfied) => "does not occur",
                    (_, RunVerdict::Violated) => "VIOLATED",
                    (_, other) => other.name(),
                };
                format!("{label}: {said} {why}").trim_end().to_owned()
            }
            Self::End { reason, .. } => format!("ended: {reason}"),
        }
    }
}
