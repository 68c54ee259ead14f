//! Requirements' forms: a monitor's clauses by another reading, a limit by the
//! declared parameter.
//!
//! Both decide what a text means, so `--all` leaves them open. The files are
//! changed at the place of the values; all else stays as it is written.

use super::proposal::{Change, Effect, Offered, Proposal};
use evidence::{Finding, Measure, StudyResult, Subject, Suspect, SuspectKind};
use judging::forms::drift::{self, Drift, DriftKind};
use refinement::{FormChange, Trial, unified};
use study::{ReadingForm, Study};

/// What is offered for the requirements' forms.
pub fn of_forms(study: &Study, result: &StudyResult, offered: &mut Offered) {
    let own = study
        .requirements
        .iter()
        .filter(|r| r.same_quantity_as.is_none());
    for requirement in own {
        let subject = Subject::Requirement(requirement.id.clone());
        let readings = study.forms.of(&subject).map(|form| &form.readings);
        for reading in readings.into_iter().flatten() {
            let shown = shown_by(result, &subject, &reading.name);
            if !shown.is_empty() {
                of_reading(study, result, &subject, reading, &shown, offered);
            }
        }
    }
    for found in drift::of_study(study).drift {
        of_drift(study, &found, offered);
    }
}

/// What is known of a reading on one piece of evidence.
struct Shown<'r> {
    evidence: &'r str,
    finding: &'r Finding,
    reading: &'r evidence::Reading,
}

fn shown_by<'r>(result: &'r StudyResult, subject: &Subject, reading: &str) -> Vec<Shown<'r>> {
    let pieces = result.evidence.iter().filter(|e| !e.intermediate);
    let found = pieces.filter_map(|piece| {
        let finding = piece.finding(subject)?;
        let mut readings = finding.readings.iter();
        let reading = readings.find(|r| r.name == reading && r.differing > 0)?;
        Some(Shown {
            evidence: &piece.id,
            finding,
            reading,
        })
    });
    found.collect()
}

fn of_reading(
    study: &Study,
    result: &StudyResult,
    subject: &Subject,
    reading: &ReadingForm,
    shown: &[Shown],
    offered: &mut Offered,
) {
    let change = FormChange::Reading {
        requirement: subject.id().to_owned(),
        reading: reading.name.clone(),
    };
    let rate = |count: u64, trials: u64| (trials > 0).then(|| count as f64 / trials as f64);
    let effects = shown.iter().map(|it| Effect {
        subject: subject.clone(),
        before: it.finding.measure.estimate(),
        after: rate(it.reading.count, it.reading.trials),
        counted: None,
        p_value: None,
    });
    let words: Vec<String> = shown.iter().map(in_words).collect();
    let mut suspects = result.suspected().iter();
    let is_reading = |it: &&Suspect| {
        let is_form = matches!(it.asset.kind, SuspectKind::Monitor | SuspectKind::Property);
        is_form && it.is_open() && it.subjects.contains(subject)
    };
    let place = suspects.find(is_reading).map(|it| it.rank);
    let offer = FormOffer {
        suspect: place,
        title: format!(
            "requirement {}: its monitor takes the reading `{}`",
            subject.id(),
            reading.name
        ),
        reason: format!("{} {}", reading.meaning, words.join(" ")),
        effects: effects.collect(),
        note: "This decides what the requirement's text means; the tables of experiments keep their counts.",
    };
    offer.add(study, change, offered);
}

/// What is said of a change of the forms.
struct FormOffer {
    suspect: Option<u32>,
    title: String,
    reason: String,
    effects: Vec<Effect>,
    note: &'static str,
}

impl FormOffer {
    /// Offers it, if it can be made.
    fn add(self, study: &Study, change: FormChange, offered: &mut Offered) {
        const FILE: &str = "requirements.toml";
        let text = &study.forms.source.text;
        let changed = match change.make(text) {
            Ok(changed) => changed,
            Err(reason) => {
                offered.refused.push(format!("{}: {reason}.", self.title));
                return;
            }
        };
        // A reading that the monitor has taken already changes nothing.
        let diff = unified(FILE, FILE, text, &changed);
        offered.add(Proposal {
            number: 0,
            suspect: self.suspect,
            title: self.title,
            reason: self.reason,
            file: FILE.into(),
            also: Vec::new(),
            chosen: Vec::new(),
            rivals: Vec::new(),
            diff,
            effects: self.effects,
            tried: Trial::default(),
            notes: vec![self.note.into()],
            needs_decision: true,
            change: Change::Form(change),
        });
    }
}

fn in_words(shown: &Shown) -> String {
    let main = match &shown.finding.measure {
        Measure::Counts { count, trials, .. } => format!("{count} of {trials}"),
        _ => "none".into(),
    };
    format!(
        "On the runs of {}: {main} pass now, {} of {} then.",
        shown.evidence, shown.reading.count, shown.reading.trials
    )
}

/// A time limit that is not the declared one.
fn of_drift(study: &Study, found: &Drift, offered: &mut Offered) {
    if found.kind != DriftKind::Limit || found.form == "property" {
        return;
    }
    let (Some(found_secs), Some(declared_secs)) = (secs(&found.found), secs(&found.declared))
    else {
        return;
    };
    let change = FormChange::Limit {
        requirement: found.requirement.clone(),
        form: found.form.clone(),
        found_secs,
        declared_secs,
    };
    let offer = FormOffer {
        suspect: None,
        title: format!(
            "requirement {}: the limit of its {} becomes {declared_secs} s",
            found.requirement, found.form
        ),
        reason: format!(
            "The {} has {}, where the requirement has {}.",
            found.form, found.found, found.declared
        ),
        effects: Vec::new(),
        note: "If the form limits something else on purpose, it is another requirement. What it changes is known once \
               the traces are judged again.",
    };
    offer.add(study, change, offered);
}

/// The first duration of a finding: `100 s`, or `release_time = 2 s`.
fn secs(text: &str) -> Option<f64> {
    let first = text.split(',').next()?.trim();
    let value = first.rsplit_once('=').map_or(first, |(_, value)| value);
    let value: trace::units::QuantityValue = value.trim().parse().ok()?;
    (value.dimension() == trace::units::Dimension::TIME).then(|| value.si_value())
}
