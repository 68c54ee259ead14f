//! Edits of the `scale` and the `offset` of signals.
//!
//! # Definition
//! Looked at are the signals that a proposition of a subject in disagreement reads. A `scale` may be
//! * that of a sister: another signal whose field's name ends alike (`knee_ncm`, `hip_ncm`), which then says it;
//! * a slip by a factor, by the sign, or between radians and degrees;
//! * a power of ten, or what usual units of one dimension are of each other.
//!
//! A signal without a `scale` may have one, too; where it has a unit, only a sister's, since [`super::topics`] tries its
//! units. An `offset` may be a sister's or what temperatures differ by, and may be lacking.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none.

use super::quantities::{FACTORS, SAME_PART, add, plainly};
use super::topics::UNITS;
use super::{Reach, TOPICS, TextEdit, values};
use evidence::SuspectKind;
use std::ops::Range;
use trace::units::QuantityValue;

/// Slips of a scale, besides those of a number: the sign, thousandths, radians for degrees.
const SCALES: [f64; 5] = [
    -1.0,
    1000.0,
    0.001,
    std::f64::consts::PI / 180.0,
    180.0 / std::f64::consts::PI,
];

/// What units are of each other that [`UNITS`] does not have: hours and seconds, pounds and newtons, inches and centimetres,
/// mmol/l and mg/dl of glucose, bars and kilopascals.
const OTHER_RATIOS: [f64; 5] = [3600.0, 4.448_222, 2.54, 18.0, 100.0];

/// By what zeros of temperatures differ.
const OFFSETS: [f64; 4] = [273.15, -273.15, 32.0, -32.0];

/// Whether an edit would change an offset that is what zeros of temperatures differ by: a constant of nature, and no number that
/// somebody chose.
pub(in super::super) fn is_of_nature(edit: &TextEdit) -> bool {
    let value = edit.old.parse::<f64>().map_or(0.0, f64::abs);
    edit.part.ends_with(", offset") && OFFSETS.contains(&value)
}

/// A signal that is a number.
struct Number {
    name: String,
    from: (Range<usize>, String),
    scale: Option<(Range<usize>, String)>,
    offset: Option<(Range<usize>, String)>,
    has_unit: bool,
}

/// Other scales and offsets of the signals that are looked at.
pub(super) fn of_topics(text: &str, is_read: &dyn Fn(&str) -> bool) -> Vec<TextEdit> {
    let all = numbers(text);
    let mut found = Vec::new();
    for signal in all.iter().filter(|it| is_read(&it.name)) {
        let sisters = || {
            let others = all.iter().filter(|it| it.name != signal.name);
            others.filter(|it| {
                ending(&it.from.1).is_some() && ending(&it.from.1) == ending(&signal.from.1)
            })
        };
        let hint = |it: &Number, key: &str| {
            Some(format!(
                "{}, whose field ends alike, has this {key}",
                it.name
            ))
        };
        for sister in sisters() {
            if let Some((_, scale)) = &sister.scale {
                add(
                    signal.with("scale", scale, hint(sister, "scale")),
                    &mut found,
                );
            }
            if let Some((_, offset)) = &sister.offset {
                add(
                    signal.with("offset", offset, hint(sister, "offset")),
                    &mut found,
                );
            }
        }
        for scale in signal.scales() {
            add(signal.with("scale", &plainly(scale), None), &mut found);
        }
        let is_offset = signal.offset.is_some();
        let lacking = is_offset.then_some(0.0);
        for offset in OFFSETS.into_iter().chain(lacking) {
            if is_offset || !signal.has_unit && offset.abs() > 100.0 {
                add(signal.with("offset", &plainly(offset), None), &mut found);
            }
        }
    }
    found
}

impl Number {
    /// The scales that it may have instead, as numbers.
    fn scales(&self) -> Vec<f64> {
        let own = self
            .scale
            .as_ref()
            .map(|(_, written)| written.parse::<f64>().ok());
        let (own, is_written) = match own {
            None => (1.0, false),
            Some(Some(own)) => (own, true),
            // What is not written as a number is left alone.
            Some(None) => return Vec::new(),
        };
        let slips = FACTORS.iter().chain(&SCALES).map(|factor| own * factor);
        let slips: Vec<f64> = slips.filter(|_| is_written).collect();
        let usual = ratios().into_iter().filter(|_| !self.has_unit);
        let mut found: Vec<f64> = Vec::new();
        for scale in slips.into_iter().chain(usual) {
            let is_same = |other: f64| (scale - other).abs() <= SAME_PART * scale.abs();
            if !is_same(own) && !found.iter().any(|it| is_same(*it)) {
                found.push(scale);
            }
        }
        found
    }

    /// The signal with this value of a key.
    fn with(&self, key: &str, value: &str, hint: Option<String>) -> TextEdit {
        let known = match key {
            "scale" => &self.scale,
            _ => &self.offset,
        };
        let (span, old, new) = match known {
            Some((span, written)) => (span.clone(), written.clone(), value.to_owned()),
            // A key of its own behind the field.
            None => {
                let (span, from) = &self.from;
                (
                    span.clone(),
                    from.clone(),
                    format!("{from}\n{key} = {value}"),
                )
            }
        };
        TextEdit {
            file: TOPICS,
            span,
            old,
            new,
            kind: SuspectKind::Vocabulary,
            part: format!("{}, {key}", self.name),
            reach: Reach::Runs,
            is_said: hint.is_some(),
            hint,
        }
    }
}

/// The signals of topics.toml that are numbers.
fn numbers(text: &str) -> Vec<Number> {
    let mut starts: Vec<usize> = text.match_indices("[\"/").map(|(at, _)| at).collect();
    starts.push(text.len());
    let numbers = starts.windows(2).filter_map(|pair| {
        let value = |key: &str| values(text, pair[0]..pair[1], key).into_iter().next();
        let is_number = value("kind").is_none_or(|(_, kind)| !kind.contains("bool"))
            && !text[pair[0]..pair[1]]
                .lines()
                .any(|line| line.trim_start().starts_with("values"));
        is_number.then_some(Number {
            name: text[pair[0] + 2..pair[1]].split('"').next()?.to_owned(),
            from: value("from")?,
            scale: value("scale"),
            offset: value("offset"),
            has_unit: value("unit").is_some(),
        })
    });
    numbers.collect()
}

/// What a field's name ends with behind its last `_`: its unit, where people write it so.
fn ending(from: &str) -> Option<&str> {
    let name = from.trim_matches(['"', '\'']);
    name.rsplit(['/', '.'])
        .next()?
        .rsplit_once('_')
        .map(|(_, end)| end)
}

/// Powers of ten, and what usual units of one dimension are of each other, each with its inverse.
fn ratios() -> Vec<f64> {
    let values: Vec<QuantityValue> = UNITS
        .iter()
        .filter_map(|unit| format!("1 {unit}").parse().ok())
        .collect();
    let of_units = values.iter().flat_map(|one| {
        let same = values
            .iter()
            .filter(|other| other.dimension() == one.dimension());
        same.map(|other| one.si_value() / other.si_value())
    });
    let others = OTHER_RATIOS
        .into_iter()
        .flat_map(|ratio| [ratio, 1.0 / ratio]);
    let mut found: Vec<f64> = Vec::new();
    for ratio in of_units.chain(others) {
        if !found
            .iter()
            .any(|it| (it - ratio).abs() <= SAME_PART * ratio)
        {
            found.push(ratio);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[\"/left.force\"]\nfrom = \"/csv.left_kp\"\nscale = 9.81\n\n[\"/right.force\"]\nfrom = \"/csv.right_kp\"\n\n\
                        [\"/oven.heat\"]\nfrom = \"/csv.heat\"\noffset = -263.15\n\n[\"/x.on\"]\nfrom = \"/csv.on_kp\"\nkind = \"bool\"\n";

    fn of(name: &str) -> Vec<TextEdit> {
        of_topics(TEXT, &|it| it == name)
    }

    #[test]
    fn a_scale_is_tried_with_other_factors() {
        let text = "[\"/x.angle\"]\nfrom = \"/imu.yaw\"\nscale = 0.5\nunit = \"rad\"\n";
        let edits = of_topics(text, &|_| true);
        assert_eq!(edits.len(), FACTORS.len() + SCALES.len());
        assert!(edits.iter().all(|it| text[it.span.clone()] == *"0.5"));
        assert!(edits.iter().any(|it| it.new == "-0.5"));
    }

    #[test]
    fn a_scale_that_is_lacking_is_that_of_a_field_that_ends_alike_or_a_usual_one() {
        let edits = of("/right.force");
        let said: Vec<&str> = edits
            .iter()
            .filter(|it| it.is_said)
            .map(|it| it.new.as_str())
            .collect();
        assert_eq!(said, ["\"/csv.right_kp\"\nscale = 9.81"]);
        for usual in ["0.001", "3.6", "60", "18"] {
            let new = format!("\"/csv.right_kp\"\nscale = {usual}");
            assert!(
                edits.iter().any(|it| it.new == new && !it.is_said),
                "{usual}"
            );
        }
        assert!(edits.iter().all(|it| TEXT[it.span.clone()] == it.old));
        assert!(of("/x.on").is_empty(), "what is true or false has no scale");
    }

    #[test]
    fn an_offset_is_tried_as_that_of_temperatures() {
        let edits = of("/oven.heat");
        let mut offsets = edits.iter().filter(|it| it.part.ends_with("offset"));
        assert!(offsets.any(|it| it.old == "-263.15" && it.new == "-273.15"));
    }
}
