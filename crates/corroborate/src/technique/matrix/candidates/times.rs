//! Durations that the study states once for all requirements: the `step` of `study.toml`, and the `mission_time` of a fault
//! tree in `ledger.toml`.
//!
//! # Definition
//! Each may be wrong by a slip: a factor between units of time, a power of ten, or two. A mission time may also be a duration
//! that a requirement's text, a failure mode's meaning, the study's summary or its conditions say, in hours, minutes or seconds, and
//! the limit of a property.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! None: what is suggested is an idea, as in [`super`].

use super::{LEDGER, Reach, STUDY, TextEdit, entry_block, limits, values};
use evidence::SuspectKind;
use std::ops::Range;
use study::{Study, Work};

/// Slips of a duration: other units of time, powers of ten, two.
const FACTORS: [f64; 12] = [
    2.0,
    0.5,
    10.0,
    0.1,
    1000.0,
    0.001,
    60.0,
    1.0 / 60.0,
    24.0,
    1.0 / 24.0,
    3600.0,
    1.0 / 3600.0,
];

/// The units in which a mission may be told, in seconds.
const UNITS: [f64; 4] = [1.0, 60.0, 3600.0, 86_400.0];

/// Durations that differ by less than this part are the same.
const SAME_PART: f64 = 1e-9;

/// Other durations of a step.
pub(super) fn of_step(study: &Study) -> Vec<TextEdit> {
    let Some(written) = study.about.model.step.as_deref() else {
        return Vec::new();
    };
    let Ok(source) = host::files::read_source(&study.folder.join(STUDY)) else {
        return Vec::new();
    };
    let text = source.text;
    let within = text.find("[model]").unwrap_or(0)..text.len();
    let Some((span, _)) = values(&text, within, "step")
        .into_iter()
        .find(|(_, value)| value.trim_matches(['"', '\'']) == written)
    else {
        return Vec::new();
    };
    let digits = written.find(|c: char| !(c.is_ascii_digit() || c == '.'));
    let (number, unit) = written.split_at(digits.unwrap_or(written.len()));
    let Ok(number) = number.parse::<f64>() else {
        return Vec::new();
    };
    let of_factor = |factor: &f64| TextEdit {
        file: STUDY,
        span: span.start + 1..span.end - 1,
        old: written.to_owned(),
        new: format!("{}{unit}", plainly(number * factor)),
        kind: SuspectKind::TimeScale,
        part: "model, step".into(),
        reach: Reach::Models,
        hint: None,
        is_said: false,
    };
    FACTORS.iter().map(of_factor).collect()
}

/// Other mission times of the fault trees.
pub(super) fn of_missions(study: &Study) -> Vec<TextEdit> {
    let said = limits::said_anywhere(study);
    let text = &study.ledger_source.text;
    let mut found = Vec::new();
    for entry in &study.ledger {
        let Work::FaultTree {
            mission_time: Some(own),
            ..
        } = &entry.work
        else {
            continue;
        };
        let all = values(text, entry_block(text, &entry.id), "mission_time");
        let Some((span, written)) = all.into_iter().next() else {
            continue;
        };
        let of = |time: f64, hint: Option<String>| TextEdit {
            file: LEDGER,
            span: Range::clone(&span),
            old: written.clone(),
            new: toml_number(time),
            kind: SuspectKind::TimeScale,
            part: format!("{}, mission_time", entry.id),
            reach: Reach::Tree(entry.id.clone()),
            is_said: hint.is_some(),
            hint,
        };
        let told = said.iter().flat_map(|secs| {
            UNITS.map(|unit| {
                (
                    secs / unit,
                    Some(format!("the study's texts state {secs} s")),
                )
            })
        });
        let asked = limits::of_properties(study).into_iter();
        let asked = asked.map(|(number, hint)| (number, Some(hint)));
        let slips = FACTORS.iter().map(|factor| (own * factor, None));
        for (time, hint) in told.chain(asked).chain(slips) {
            let is_other = (time - own).abs() > SAME_PART * own;
            let edit = of(time, hint);
            let mut known = found.iter();
            if is_other && known.all(|it: &TextEdit| it.new != edit.new || it.part != edit.part) {
                found.push(edit);
            }
        }
    }
    found
}

/// A duration as it would be written: at most nine digits that count.
fn plainly(value: f64) -> String {
    let digits = 8 - value.abs().log10().floor().clamp(-12.0, 8.0) as i32;
    let scale = 10.0_f64.powi(digits);
    format!("{}", (value * scale).round() / scale)
}

/// A number that TOML reads as one with a point.
fn toml_number(value: f64) -> String {
    let text = plainly(value);
    match text.contains('.') {
        true => text,
        false => format!("{text}.0"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_written_as_a_person_would() {
        assert_eq!(plainly(0.1 * 3.0), "0.3");
        assert_eq!(plainly(1.0 / 60.0), "0.0166666667");
        assert_eq!(plainly(28_800.0), "28800");
        assert_eq!(toml_number(8.0), "8.0");
        assert_eq!(toml_number(0.5), "0.5");
    }
}
