//! What is shown of an episode: verdicts with their reasons, moments, signals.

use crate::technique::exploration::Plan;
use diagnostic::Problem;
use evidence::Subject;
use evidence::replay::{Mark, Signal, SignalKind, Tone, Verdict as ShownVerdict};
use judging::{Judgement, Judges, Shown};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use study::{Shows, Study};
use temporal::monitor::Verdict;
use trace::{FieldKind, Trace};

/// At most so many moments are marked of one monitor.
const MOST_MARKS: usize = 12;

/// What was judged of an episode.
pub struct Judged<'a> {
    /// What each monitor says, main readings only.
    pub judgements: Vec<Judgement<'a>>,
    /// The verdicts over time, as MCAP.
    pub over_time: Vec<u8>,
}

/// Judges an episode with all monitors of the study.
pub fn judge<'a>(study: &'a Study, trace: &Trace) -> Result<Judged<'a>, Problem> {
    let judges = Judges::new(study, |_| true)?;
    let text = |subject: &Subject| text_of(study, subject.id());
    let mut shown = Shown::new(&judges, &text)?;
    let judgements = judges.judge_and_watch(trace, &mut |time_secs, session| {
        shown.instant(nanos(time_secs), session)
    })?;
    let over_time = shown.finish(&judgements)?;
    let main = judgements.into_iter().filter(|it| it.reading.is_none());
    Ok(Judged {
        judgements: main.collect(),
        over_time,
    })
}

/// Log time of an instant of a trace.
pub fn nanos(time_secs: f64) -> i64 {
    (time_secs * 1e9).round() as i64
}

/// A requirement's text, or a failure mode's.
pub fn text_of(study: &Study, id: &str) -> String {
    let requirement = study.requirements.iter().find(|it| it.id == id);
    let mode = study.failure_modes.iter().find(|it| it.id == id);
    let text = requirement.map(|it| it.text.clone());
    text.or_else(|| mode.map(|it| it.meaning.clone()))
        .unwrap_or_else(|| id.to_owned())
}

/// What is looked at: what was asked for, or what the episode is of, or all
/// that is violated, or all that was triggered.
pub fn chosen(only: &[String], shows: Option<&Shows>, judged: &Judged<'_>) -> Vec<String> {
    if !only.is_empty() {
        return only.to_vec();
    }
    if let Some(Shows::Violated(id) | Shows::FailureMode(id)) = shows {
        return vec![id.clone()];
    }
    let of = |wanted: &dyn Fn(&Judgement<'_>) -> bool| {
        let found = judged.judgements.iter().filter(|it| wanted(it));
        found
            .map(|it| it.subject.id().to_owned())
            .collect::<Vec<_>>()
    };
    let violated = of(&|it| it.findings.verdict == Verdict::Violated);
    match violated.is_empty() && shows.is_none() {
        true => of(&|it| it.findings.triggered > 0),
        false => violated,
    }
}

/// The verdicts of what is looked at.
pub fn verdicts(study: &Study, judged: &Judged<'_>, ids: &[String]) -> Vec<ShownVerdict> {
    let looked_at = judged
        .judgements
        .iter()
        .filter(|it| is_among(it.subject, ids));
    looked_at
        .map(|judgement| {
            let findings = &judgement.findings;
            let is_mode = matches!(judgement.subject, Subject::FailureMode(_));
            let (verdict, tone) = in_words(findings.verdict, is_mode);
            ShownVerdict {
                id: judgement.subject.id().to_owned(),
                text: text_of(study, judgement.subject.id()),
                verdict: verdict.to_owned(),
                tone,
                reasons: reasons(judgement),
            }
        })
        .collect()
}

fn is_among(subject: &Subject, ids: &[String]) -> bool {
    ids.iter().any(|id| id == subject.id())
}

fn in_words(verdict: Verdict, is_mode: bool) -> (&'static str, Tone) {
    match (verdict, is_mode) {
        (Verdict::Violated, true) => ("occurs", Tone::Bad),
        (Verdict::Satisfied, true) => ("does not occur", Tone::Good),
        (Verdict::Violated, _) => ("violated", Tone::Bad),
        (Verdict::Satisfied, _) => ("satisfied", Tone::Good),
        (Verdict::NotCovered, _) => ("not covered", Tone::Plain),
        (Verdict::Inconclusive, _) => ("inconclusive", Tone::Open),
    }
}

/// Why, in sentences.
pub fn reasons(judgement: &Judgement<'_>) -> Vec<String> {
    let findings = &judgement.findings;
    let mut said = Vec::new();
    if findings.triggered > 0 {
        let times = if findings.triggered == 1 {
            "time"
        } else {
            "times"
        };
        said.push(format!("Triggered {} {times}.", findings.triggered));
    }
    if let Some(violation) = &findings.violation {
        said.push(format!(
            "It shows from {:.3} s to {:.3} s.",
            violation.from_secs, violation.to_secs
        ));
        for part in &violation.responsible {
            let truth = if part.value { "true" } else { "false" };
            said.push(format!(
                "`{}` is {truth} from {:.3} s to {:.3} s; it reads {}.",
                part.proposition,
                part.from_secs,
                part.to_secs,
                part.signals.join(", ")
            ));
        }
    }
    if let Some(robustness) = findings.robustness.and_then(|it| it.by_numbers()) {
        said.push(match robustness.low == robustness.high {
            true => format!("Robustness {:.4}.", robustness.low),
            false => format!(
                "Robustness {:.4} to {:.4}.",
                robustness.low, robustness.high
            ),
        });
    }
    said
}

/// When what is looked at was triggered, and when it was violated.
pub fn marks(
    study: &Study,
    trace: &Trace,
    judged: &Judged<'_>,
    ids: &[String],
) -> Result<Vec<Mark>, Problem> {
    let mut marks = Vec::new();
    for judgement in judged
        .judgements
        .iter()
        .filter(|it| is_among(it.subject, ids))
    {
        let id = judgement.subject.id();
        let mut triggered = triggers(study, trace, id)?;
        triggered.truncate(MOST_MARKS);
        marks.extend(triggered.into_iter().map(|time_secs| Mark {
            time_secs,
            text: format!("{id} is triggered"),
            tone: Tone::Plain,
        }));
        if let Some(violation) = &judgement.findings.violation {
            let names = violation.responsible.iter().map(|part| {
                format!(
                    "{}{}",
                    if part.value { "" } else { "not " },
                    part.proposition
                )
            });
            let names: BTreeSet<String> = names.collect();
            let is_mode = matches!(judgement.subject, Subject::FailureMode(_));
            let verb = if is_mode { "occurs" } else { "is violated" };
            let because: Vec<String> = names.into_iter().take(3).collect();
            marks.push(Mark {
                time_secs: violation.to_secs,
                text: format!("{id} {verb}: {}", because.join(", ")),
                tone: Tone::Bad,
            });
        }
    }
    marks.sort_by(|a, b| a.time_secs.total_cmp(&b.time_secs));
    Ok(marks)
}

/// The times at which a monitor begins an instance.
fn triggers(study: &Study, trace: &Trace, id: &str) -> Result<Vec<f64>, Problem> {
    let judges = Judges::new(study, |subject| subject.id() == id)?;
    let (mut times, mut known) = (Vec::new(), 0);
    judges.judge_and_watch(trace, &mut |time_secs, session| {
        let so_far = session.so_far();
        let main = so_far.iter().find(|it| it.reading.is_none());
        let triggered = main.map_or(0, |it| it.findings.triggered);
        if triggered > known {
            times.push(time_secs);
            known = triggered;
        }
        Ok(())
    })?;
    Ok(times)
}

/// The signals that judging what is looked at reads.
pub fn signals(
    study: &Study,
    shows: Option<&Shows>,
    trace: &Trace,
    judged: &Judged<'_>,
    ids: &[String],
) -> Result<Vec<Signal>, Problem> {
    let judges = Judges::new(study, |subject| is_among(subject, ids))?;
    let mut names = judges.signals();
    if let Some(Shows::Unknown(step)) = shows {
        names.extend(signals_of_exploration(study, Path::new(&step.exploration))?);
    }
    let causes = causes(judged, ids);
    let signals = names.iter().filter_map(|name| {
        let causes = causes.get(name).cloned().unwrap_or_default();
        signal(trace, name, causes)
    });
    Ok(signals.collect())
}

/// The signals by which an exploration tells abstract states apart.
fn signals_of_exploration(study: &Study, file: &Path) -> Result<BTreeSet<String>, Problem> {
    let plan = Plan::of_study(study, file)?;
    let declared = plan.data.abstraction.iter().flat_map(|it| &it.proposition);
    let texts = declared.map(|it| it.trace.as_deref().unwrap_or(&it.name));
    let predicates = texts.filter_map(|text| study.vocabulary.signals.predicate(text).ok());
    Ok(predicates
        .flat_map(|predicate| predicate.signals())
        .collect())
}

/// When each signal was part of the reason for a violation.
fn causes(judged: &Judged<'_>, ids: &[String]) -> BTreeMap<String, Vec<(f64, f64)>> {
    let mut causes: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    let looked_at = judged
        .judgements
        .iter()
        .filter(|it| is_among(it.subject, ids));
    let parts = looked_at.filter_map(|it| it.findings.violation.as_ref());
    for part in parts.flat_map(|violation| &violation.responsible) {
        for name in &part.signals {
            let spans = causes.entry(name.clone()).or_default();
            spans.push((part.from_secs, part.to_secs));
        }
    }
    causes
}

fn signal(trace: &Trace, name: &str, causes: Vec<(f64, f64)>) -> Option<Signal> {
    let index = trace.signal(name)?;
    let field = trace.field(index)?;
    let channel = trace.channels.get(index.channel)?;
    let rows = 0..channel.len();
    Some(Signal {
        name: name.to_owned(),
        kind: match &field.kind {
            FieldKind::Bool => SignalKind::Flag,
            FieldKind::Enumeration(names) => SignalKind::Names(names.clone()),
            FieldKind::Number => SignalKind::Number(match field.unit.as_str() {
                "1" => String::new(),
                unit => unit.to_owned(),
            }),
        },
        times_secs: channel.times_secs.clone(),
        values: rows.map(|row| channel.row(row)[index.field]).collect(),
        causes,
    })
}
