//! Limits of time in a requirement's forms that something suggests.
//!
//! # Definition
//! A limit stands in a hand-written property (`F<=11`, in steps or in units of continuous time) and in a monitor
//! (`within_secs = 5.5`). Both are durations, once study.toml says how long a step takes. What a limit may be instead is
//! each duration of the requirement's text and sentence and each limit of its other form, and what a slip by a factor makes
//! of it, the duration of a step among the factors. A limit that the text or the sentence says is not looked at. A limit in
//! steps of no known duration, a count, may be each number of the text ("within two attempts"), and any other that is at most [`FARTHEST`] away. A limit of a
//! property may be that of another requirement's property, or a fault tree's mission time: what one study asks about is often
//! one stretch of time.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! None: what is suggested is an idea, as in [`super`].

use super::quantities::bare_in_text;
use super::{REQUIREMENTS, Reach, TextEdit, block, part_of, values};
use evidence::{Subject, SuspectKind};
use std::ops::Range;
use study::{Study, SubjectForm, Work};
use trace::units::QuantityValue;

/// Slips of a limit.
const FACTORS: [f64; 6] = [10.0, 0.1, 60.0, 1.0 / 60.0, 2.0, 0.5];

/// How far a count of steps is moved, as whole numbers of models are.
const FARTHEST: i32 = 8;

/// Durations that differ by less are the same.
const SAME_SECS: f64 = 1e-9;

/// A limit with its place.
struct Limit {
    span: Range<usize>,
    /// What stands there, and what stands there for another number.
    written: String,
    before: &'static str,
    number: f64,
    /// In seconds, where that is known.
    secs: Option<f64>,
}

/// The limits of a requirement's forms by the durations of its own text and sentence, by each other, or by a factor.
pub(super) fn of_form(study: &Study, form: &SubjectForm) -> Vec<TextEdit> {
    let step = study.about.model.step_secs();
    let (monitor, property) = (of_monitor(study, form), of_property(form, step));
    let secs = |limits: &[Limit]| -> Vec<f64> { limits.iter().filter_map(|it| it.secs).collect() };
    let said = said(study, &form.subject);
    let suggested = |others: Vec<f64>, other: &str| -> Vec<(f64, String)> {
        let of_text = said.iter().map(|it| (*it, format!("its text says {it} s")));
        let of_other = others.into_iter();
        of_text
            .chain(of_other.map(|it| (it, format!("its {other} says {it} s"))))
            .collect()
    };
    let counts = counts(study, &form.subject);
    let of_monitor = Looked {
        form,
        which: "monitor",
        step,
        scale: Some(1.0),
        suggested: suggested(secs(&property), "property")
            .into_iter()
            .chain(called_after(study, &form.subject))
            .collect(),
        counts: &[],
        others: Vec::new(),
    };
    let of_property = Looked {
        form,
        which: "property",
        step,
        scale: step,
        suggested: suggested(secs(&monitor), "monitor"),
        counts: &counts,
        others: elsewhere(study, form),
    };
    let is_said = |limit: &&Limit| {
        if limit.secs.is_none()
            && counts
                .iter()
                .any(|it| (it - limit.number).abs() < SAME_SECS)
        {
            return true;
        }
        limit.secs.is_some_and(|secs| says_secs(&said, secs))
    };
    let mut found = Vec::new();
    for (looked, limits) in [(of_monitor, monitor), (of_property, property)] {
        for limit in limits.iter().filter(|limit| !is_said(limit)) {
            looked.of_limit(limit, &mut found);
        }
    }
    found
}

/// The durations of parameters that are called after a subject: `prompt_time` for the requirement `prompt`.
fn called_after(study: &Study, subject: &Subject) -> Vec<(f64, String)> {
    let parts = |name: &str| -> Vec<String> {
        let parts = name.split(|c: char| !c.is_ascii_alphanumeric());
        parts.map(str::to_lowercase).collect()
    };
    let own = parts(subject.id());
    let all = study.parameters.values.iter();
    let called = all.filter(|(name, value)| {
        let is_time = "1 s"
            .parse()
            .is_ok_and(|second: trace::units::QuantityValue| {
                second.dimension() == value.dimension()
            });
        is_time && parts(name).iter().any(|part| own.contains(part))
    });
    called
        .map(|(name, value)| {
            (
                value.si_value(),
                format!("the parameter {name} says {} s", value.si_value()),
            )
        })
        .collect()
}

/// One form whose limits are looked at.
struct Looked<'a> {
    form: &'a SubjectForm,
    /// `property` or `monitor`.
    which: &'static str,
    /// Seconds of a step of the model.
    step: Option<f64>,
    /// Seconds of a unit of its limits, where that is known.
    scale: Option<f64>,
    /// Durations in seconds that something else says, and what says them.
    suggested: Vec<(f64, String)>,
    /// Numbers that its text says, which a count of steps may be.
    counts: &'a [f64],
    /// Numbers that others have in its place, in its own unit, and what says them.
    others: Vec<Elsewhere>,
}

/// A limit that stands elsewhere in the study, in units of the model's time.
pub(super) struct Elsewhere {
    pub number: f64,
    /// Who has it, as a clause.
    pub hint: String,
    /// Whether several have it.
    pub is_common: bool,
}

/// The limits in the properties of other subjects than this one, and the mission times of fault trees; each number once.
fn elsewhere(study: &Study, form: &SubjectForm) -> Vec<Elsewhere> {
    let others = study.forms.subjects.iter();
    let others = others.filter(|other| other.subject != form.subject);
    let limits = others.flat_map(|other| {
        let who = format!("the property of {}", other.subject.in_words());
        let all = of_property(other, None).into_iter();
        all.map(move |limit| (limit.number, who.clone()))
    });
    let trees = study.ledger.iter().filter_map(|entry| {
        let Work::FaultTree {
            mission_time: Some(time),
            ..
        } = &entry.work
        else {
            return None;
        };
        Some((*time, format!("the mission time of {}", entry.id)))
    });
    let mut found: Vec<Elsewhere> = Vec::new();
    for (number, who) in limits.chain(trees) {
        let is_same = |it: &&mut Elsewhere| (it.number - number).abs() < SAME_SECS;
        match found.iter_mut().find(is_same) {
            Some(known) => known.is_common = true,
            None => found.push(Elsewhere {
                number,
                hint: format!("{who} says {number}"),
                is_common: false,
            }),
        }
    }
    found
}

/// The limits in properties of the subjects that something else answers, too.
pub(super) fn of_properties(study: &Study) -> Vec<(f64, String)> {
    let all = study.forms.subjects.iter().flat_map(|form| {
        let who = form.subject.in_words();
        let limits = of_property(form, None).into_iter();
        limits.map(move |limit| {
            (
                limit.number,
                format!("the property of {who} says {}", limit.number),
            )
        })
    });
    all.collect()
}

impl Looked<'_> {
    /// What a limit may be instead; each text once.
    fn of_limit(&self, limit: &Limit, found: &mut Vec<TextEdit>) {
        let said = self.suggested.iter().filter_map(|(secs, hint)| {
            let scale = self.scale?;
            Some((secs / scale, Some(hint.clone()), true))
        });
        let others = self.others.iter();
        let others = others.map(|it| (it.number, Some(it.hint.clone()), it.is_common));
        let slips = FACTORS.into_iter();
        let slips = slips.chain(self.step.into_iter().flat_map(|step| [step, 1.0 / step]));
        let slips = slips.map(|factor| (limit.number * factor, None, false));
        // Steps whose duration nobody says are counted.
        let is_count = limit.secs.is_none() && limit.number.fract() == 0.0;
        let counts = self.counts.iter().filter(|_| is_count);
        let counts = counts.map(|it| (*it, Some(format!("its text says {it}")), true));
        let next = (1..=FARTHEST).flat_map(|step| [f64::from(step), -f64::from(step)]);
        let next = next.map(|step| limit.number + step);
        let next = next.filter(|it| is_count && *it >= 1.0);
        let next = next.map(|it| (it, None, false));
        let all = said.chain(counts).chain(others).chain(next).chain(slips);
        for (number, hint, is_said) in all {
            let new = self.edit(limit, number, (hint, is_said));
            // What has no time to come does not come.
            if new.new.trim_start_matches(limit.before) == "0" {
                continue;
            }
            let mut known = found.iter();
            let is_known = known.any(|it| it.new == new.new && it.span == new.span);
            if new.new != new.old && !is_known {
                found.push(new);
            }
        }
    }

    fn edit(
        &self,
        limit: &Limit,
        number: f64,
        (hint, is_said): (Option<String>, bool),
    ) -> TextEdit {
        let is_property = self.which == "property";
        let (kind, reach) = match is_property {
            true => (SuspectKind::Property, Reach::Models),
            false => (SuspectKind::Monitor, Reach::Runs),
        };
        TextEdit {
            file: REQUIREMENTS,
            span: limit.span.clone(),
            old: limit.written.clone(),
            new: format!(
                "{}{}",
                limit.before,
                number_like(limit, number, is_property)
            ),
            kind,
            part: part_of(self.form, self.which),
            reach,
            is_said,
            hint,
        }
    }
}

/// Whether some form of a requirement, its text or its sentence has a limit of time.
pub(in super::super) fn is_timed(study: &Study, form: &SubjectForm) -> bool {
    !(of_monitor(study, form).is_empty()
        && of_property(form, None).is_empty()
        && said(study, &form.subject).is_empty())
}

/// The durations of a subject's text and sentence.
fn said(study: &Study, subject: &Subject) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    let texts = said_texts(study, subject);
    for secs in texts.iter().flat_map(|text| durations(text)) {
        if !found.contains(&secs) {
            found.push(secs);
        }
    }
    found
}

/// Numbers in words, from two on.
const WORDS: [&str; 11] = [
    "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
];

/// The number that a word is.
pub(super) fn in_words(word: &str) -> Option<f64> {
    let place = WORDS.iter().position(|it| *it == word.to_lowercase())?;
    Some((place + 2) as f64)
}

/// Words right before a number that bounds what is counted.
const BOUNDS: [&str; 12] = [
    "within", "in", "after", "before", "by", "than", "most", "to", "for", "first", "until", "last",
];

/// The numbers with which a subject's text bounds something, in words ("within two looks", not "two of three lamps"); those in
/// digits; no shares.
pub(super) fn counts(study: &Study, subject: &Subject) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for text in said_texts(study, subject) {
        let words = text.split(|c: char| !c.is_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        let in_words = words.windows(2).filter_map(|pair| {
            let is_bound = BOUNDS.contains(&pair[0].to_lowercase().as_str());
            in_words(pair[1]).filter(|_| is_bound)
        });
        let in_digits = bare_in_text(&text).into_iter();
        for number in in_words.chain(in_digits.filter(|it| it.fract() == 0.0 && *it >= 1.0)) {
            if !found.contains(&number) {
                found.push(number);
            }
        }
    }
    found
}

/// A subject's text and sentence.
pub(super) fn said_texts(study: &Study, subject: &Subject) -> Vec<String> {
    match subject {
        Subject::Requirement(id) => {
            let mut all = study.requirements.iter();
            let own = all.find(|r| &r.id == id);
            own.map_or_else(Vec::new, |r| {
                [Some(r.text.clone()), r.sentence.clone()]
                    .into_iter()
                    .flatten()
                    .collect()
            })
        }
        Subject::FailureMode(id) => {
            let mut all = study.failure_modes.iter();
            all.find(|m| &m.id == id)
                .map(|m| m.meaning.clone())
                .into_iter()
                .collect()
        }
    }
}

/// The durations that any requirement or failure mode, the study's summary or its conditions say in words, in seconds.
pub(super) fn said_anywhere(study: &Study) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    let subjects = study.forms.subjects.iter();
    let of_subjects = subjects.map(|form| said(study, &form.subject));
    let conditions = study.about.conditions.values();
    let of_study = [&study.about.summary].into_iter().chain(conditions);
    let of_study = of_study.map(|text| durations(text));
    for new in of_subjects.chain(of_study) {
        for secs in new {
            if !found.contains(&secs) {
                found.push(secs);
            }
        }
    }
    found
}

fn of_monitor(study: &Study, form: &SubjectForm) -> Vec<Limit> {
    let text = &study.forms.source.text;
    let all = values(text, block(text, form), "within_secs").into_iter();
    let limits = all.filter_map(|(span, written)| {
        let number = written.replace('_', "").parse::<f64>().ok()?;
        Some(Limit {
            span,
            written,
            before: "",
            number,
            secs: Some(number),
        })
    });
    limits.collect()
}

/// The upper limits of time in a property that was written by hand: `<=` right behind a temporal operator.
fn of_property(form: &SubjectForm, step: Option<f64>) -> Vec<Limit> {
    let Some(property) = form.property.as_ref().filter(|p| !p.from_sentence) else {
        return Vec::new();
    };
    let text = &property.text;
    let limits = text.match_indices("<=").filter_map(|(at, sign)| {
        let before = text[..at].chars().next_back()?;
        let rest = &text[at + sign.len()..];
        let end = rest
            .find(|c: char| !(c.is_ascii_digit() || c == '.'))
            .unwrap_or(rest.len());
        let number = rest[..end].parse::<f64>().ok()?;
        let start = property.span.start + at;
        "FGUWR".contains(before).then(|| Limit {
            span: start..start + sign.len() + end,
            written: text[at..at + sign.len() + end].to_owned(),
            before: "<=",
            number,
            secs: step.map(|step| number * step),
        })
    });
    limits.collect()
}

/// A number as it would be written: steps are whole.
fn number_like(limit: &Limit, number: f64, is_property: bool) -> String {
    match is_property && !limit.written.contains('.') {
        true => format!("{}", (number + SAME_SECS).floor()),
        false => format!("{}", (number * 1e9).round() / 1e9),
    }
}

/// Whether a text says a quantity, in whatever unit.
pub(super) fn says(text: &str, wanted: &QuantityValue) -> bool {
    let is_wanted =
        |value: f64| (value - wanted.si_value()).abs() <= SAME_SECS * value.abs().max(1.0);
    let is_time = "1 s"
        .parse::<QuantityValue>()
        .is_ok_and(|it| it.dimension() == wanted.dimension());
    let quantities = super::topics::numbers_with_units(text)
        .into_iter()
        .filter_map(|(_, number, unit)| {
            let value = format!("{number} {unit}").parse::<QuantityValue>().ok()?;
            (value.dimension() == wanted.dimension()).then(|| value.si_value())
        });
    let durations = durations(text).into_iter().filter(|_| is_time);
    quantities.chain(durations).any(is_wanted)
}

/// Whether a duration is one of some.
pub(super) fn says_secs(said: &[f64], secs: f64) -> bool {
    said.iter().any(|it| (it - secs).abs() < SAME_SECS)
}

/// The durations in a text, in seconds.
pub(super) fn durations(text: &str) -> Vec<f64> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let unit =
        |word: &str| trace::duration::unit_secs(word.trim_matches(|c: char| !c.is_alphabetic()));
    let mut found = Vec::new();
    for (place, word) in words.iter().enumerate() {
        let digits = word.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        let (number, rest) = word.split_at(digits.unwrap_or(word.len()));
        let next = words.get(place + 1).copied().unwrap_or_default();
        let scale = match rest.is_empty() {
            true => unit(next),
            false => unit(rest),
        };
        let number = number.parse::<f64>().ok();
        let (number, scale) = match number {
            Some(number) => (Some(number), scale),
            None => (in_words(word), unit(next)),
        };
        if let (Some(number), Some(scale)) = (number, scale) {
            found.push(number * scale);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_of_a_text_are_read_with_their_units() {
        assert_eq!(
            durations("within 60 s, or after 1.5 minutes (500ms)"),
            [60.0, 90.0]
        );
        assert_eq!(durations("at least 70% of 12 attempts"), Vec::<f64>::new());
        assert_eq!(durations("in 500ms at most"), [0.5]);
        assert_eq!(durations("Three hours of two lamps."), [10_800.0]);
    }
}
