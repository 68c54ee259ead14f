//! Edits of what signals are: their units, the values and the signals that no proposition reads.
//!
//! The definition is that of [`super`].

use super::quantities::add;
use super::{
    Reach, TOPICS, TextEdit, binding, hint_of_free, is_named_after, is_shared, plain, values,
};
use evidence::SuspectKind;
use std::collections::BTreeSet;
use std::ops::Range;
use study::Study;
use trace::units::QuantityValue;

/// Units that are written for one another.
pub(super) const UNITS: [&str; 24] = [
    "mm", "cm", "m", "km", "mm/s", "cm/s", "m/s", "km/h", "ms", "s", "min", "rad", "deg", "rad/s",
    "deg/s", "g", "kg", "mN", "N", "kN", "mA", "A", "mV", "V",
];

/// Fields that no signal is read from, at most, for each of them to be tried.
const MOST_FREE: usize = 12;

/// Scales that differ by less than this part are the same.
const SAME_SCALE: f64 = 1e-6;

/// Letters of a word by which two names are alike.
const SHORTEST_WORD: usize = 3;

/// What names of fields end with for units that have a sign or another word here.
const IN_NAMES: [(&str, &str); 6] = [
    ("kn", "knot"),
    ("kt", "knot"),
    ("kts", "knot"),
    ("kmh", "km/h"),
    ("kph", "km/h"),
    ("mps", "m/s"),
];

/// Quantities in the predicates of traces, with other units of their dimension.
pub(super) fn quantities(study: &Study) -> Vec<TextEdit> {
    let mut found = Vec::new();
    for (name, proposition) in &study.vocabulary.propositions {
        let Some(place) = &proposition.trace else {
            continue;
        };
        for (span, number, unit) in numbers_with_units(&place.text) {
            for other in other_units(unit) {
                found.push(TextEdit {
                    span: place.span.start + span.start..place.span.start + span.end,
                    old: place.text[span.clone()].to_owned(),
                    ..binding(
                        (name, "trace"),
                        place,
                        format!("{number} {other}"),
                        Reach::Runs,
                        None,
                    )
                });
            }
        }
    }
    found
}

/// The numbers of a predicate that have a unit: of `/x.v < 0.3 m/s` it is `0.3` and `m/s`, with their place.
pub(super) fn numbers_with_units(text: &str) -> Vec<(Range<usize>, &str, &str)> {
    let mut found = Vec::new();
    let mut at = 0;
    for word in text.split_inclusive(' ') {
        let bare = word.trim_start_matches(['[', '(']);
        let (start, number) = (at + word.len() - bare.len(), bare.trim_end());
        at += word.len();
        let is_number = number.parse::<f64>().is_ok() && word.ends_with(' ');
        let rest = &text[at..];
        let length = rest
            .find([' ', ')', ']', ',', '&', '|'])
            .unwrap_or(rest.len());
        let unit = &rest[..length];
        if is_number && UNITS.contains(&unit) {
            found.push((start..at + length, number, unit));
        }
    }
    found
}

/// Other units of the same dimension, the nearest first: of those that explain as much the smaller slip is the likelier.
pub(super) fn other_units(unit: &str) -> Vec<&'static str> {
    let parsed = |unit: &str| format!("1 {unit}").parse::<QuantityValue>().ok();
    let Some(own) = parsed(unit) else {
        return Vec::new();
    };
    let others = UNITS.iter().filter_map(|other| {
        let value = parsed(other)?;
        let is_other = value.dimension() == own.dimension() && value.si_value() != own.si_value();
        is_other.then(|| ((value.si_value() / own.si_value()).ln().abs(), *other))
    });
    let mut others: Vec<(f64, &str)> = others.collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    others.into_iter().map(|(_, other)| other).collect()
}

/// Whether a text is another unit of the same dimension.
fn is_other_unit(unit: &str, other: &str) -> bool {
    let parsed = |unit: &str| format!("1 {unit}").parse::<QuantityValue>().ok();
    parsed(unit).zip(parsed(other)).is_some_and(|(own, other)| {
        own.dimension() == other.dimension() && own.si_value() != other.si_value()
    })
}

/// A signal of topics.toml.
struct Signal {
    name: String,
    from: String,
    from_at: Range<usize>,
    scale: Option<f64>,
    kind: Option<String>,
    unit: Option<(Range<usize>, String)>,
    values: Vec<String>,
}

impl Signal {
    /// Whether another signal can be said the same of. Where one has no unit the study's own check decides.
    fn is_like(&self, other: &Self) -> bool {
        let unit = |it: &Self| it.unit.as_ref().map(|(_, unit)| unit.clone());
        let units = (unit(self), unit(other));
        let is_same_unit = units.0 == units.1 || units.0.is_none() || units.1.is_none();
        self.kind == other.kind && self.values.is_empty() && other.values.is_empty() && is_same_unit
    }
}

impl Signal {
    /// Whether its scale makes its unit of that with which its field's name ends: newtons of `force_mN` by 0.001.
    fn is_converted(&self, unit: &str) -> bool {
        let Some(scale) = self.scale else {
            return false;
        };
        let named = self.from.rsplit('_').next().unwrap_or_default();
        let value = |unit: &str| format!("1 {unit}").parse::<QuantityValue>().ok();
        let (Some(named), Some(own)) = (value(named), value(unit)) else {
            return false;
        };
        let ratio = named.si_value() / own.si_value();
        named.dimension() == own.dimension() && (ratio - scale).abs() <= SAME_SCALE * scale.abs()
    }
}

/// What topics.toml says, with places.
pub(super) struct Topics {
    signals: Vec<Signal>,
}

impl Topics {
    pub(super) fn of(text: &str) -> Self {
        let mut starts: Vec<usize> = text.match_indices("[\"/").map(|(at, _)| at).collect();
        starts.push(text.len());
        let unquoted = |word: String| word.trim_matches(['"', '\'']).to_owned();
        let signals = starts.windows(2).filter_map(|pair| {
            let name = text[pair[0] + 2..pair[1]].split('"').next()?.to_owned();
            let value = |key: &str| values(text, pair[0]..pair[1], key).into_iter().next();
            let (from_at, from) = value("from")?;
            Some(Signal {
                name,
                from: unquoted(from),
                from_at: from_at.start + 1..from_at.end - 1,
                scale: value("scale").and_then(|(_, scale)| scale.parse().ok()),
                values: listed(&text[pair[0]..pair[1]], "values"),
                kind: value("kind").map(|(_, kind)| unquoted(kind)),
                unit: value("unit").map(|(span, unit)| {
                    let unit = unquoted(unit);
                    (span.start + 1..span.start + 1 + unit.len(), unit)
                }),
            })
        });
        Self {
            signals: signals.collect(),
        }
    }

    /// Other units of the same dimension.
    pub(super) fn units(&self) -> Vec<TextEdit> {
        let mut found = Vec::new();
        for signal in &self.signals {
            let Some((span, unit)) = &signal.unit else {
                continue;
            };
            let field = signal.from.to_lowercase();
            let is_said = |unit: &str| {
                let suffix = format!("_{}", unit.replace('/', "_per_")).to_lowercase();
                field.ends_with(&suffix)
            };
            // What the field's own name says is not looked at, nor what a scale has converted from it.
            if is_said(unit) || signal.is_converted(unit) {
                continue;
            }
            // A unit that is rarely written, if the field's name ends with it.
            let named = signal.from.rsplit('_').next().unwrap_or_default();
            let short = IN_NAMES
                .iter()
                .find(|(short, _)| *short == named.to_lowercase());
            let named = short.map_or(named, |(_, unit)| unit);
            let is_named = !UNITS.contains(&named) && is_other_unit(unit, named);
            let others = other_units(unit).into_iter();
            for other in others.chain(is_named.then_some(named)) {
                // A unit beside a scale is that of what is scaled, not of the field.
                let says = is_said(other) || is_named && other == named;
                let says = says && signal.scale.is_none();
                let hint = says.then(|| format!("its field is called `{}`", signal.from));
                found.push(TextEdit {
                    file: TOPICS,
                    span: span.clone(),
                    old: unit.clone(),
                    new: other.to_owned(),
                    kind: SuspectKind::Vocabulary,
                    part: format!("{}, unit", signal.name),
                    reach: Reach::Runs,
                    is_said: hint.is_some(),
                    hint,
                });
            }
        }
        found
    }

    /// Bindings of propositions to values of their signal that none of them names.
    pub(super) fn values(&self, study: &Study) -> Vec<TextEdit> {
        let words = &study.vocabulary.propositions;
        let bound: Vec<(&String, &study::Binding)> = words
            .iter()
            .filter_map(|(name, p)| Some((name, p.trace.as_ref()?)))
            .collect();
        let known: BTreeSet<String> = bound.iter().map(|(_, b)| plain(&b.text)).collect();
        let mut found = Vec::new();
        for (name, place) in &bound {
            let Some((signal, value)) = place.text.split_once("==") else {
                continue;
            };
            let (signal, value) = (signal.trim(), value.trim());
            let is_one = value.len() > 1 && value[1..].find('\'') == Some(value.len() - 2);
            let own = self.signals.iter().find(|it| it.name == signal);
            let Some(own) = own.filter(|_| value.starts_with('\'') && is_one) else {
                continue;
            };
            for other in &own.values {
                let new = format!("{signal} == '{other}'");
                if known.contains(&plain(&new)) {
                    continue;
                }
                let all = bound.iter().map(|(_, place)| place.text.as_str());
                let is_said = is_named_after(other, name) && !is_named_after(value, name);
                let free = format!("no proposition names `{other}` of {signal}");
                let hint = hint_of_free(&free, is_said, &place.text, all);
                found.push(TextEdit {
                    is_said,
                    ..binding((name, "trace"), place, new, Reach::Runs, hint)
                });
            }
        }
        found
    }

    /// Fields that no signal is read from, in place of that of a signal that is looked at. One that is called as the signal is says so
    /// itself.
    pub(super) fn other_fields(
        &self,
        fields: &[String],
        is_read: &dyn Fn(&str) -> bool,
    ) -> Vec<TextEdit> {
        let free = fields
            .iter()
            .filter(|field| self.signals.iter().all(|it| it.from != **field));
        let free: Vec<&String> = free.collect();
        let mut found = Vec::new();
        if free.len() > MOST_FREE {
            return found;
        }
        for signal in self.signals.iter().filter(|it| is_read(&it.name)) {
            for field in &free {
                let is_said =
                    shares_word(field, &signal.name) && !shares_word(&signal.from, &signal.name);
                let hint = match is_said {
                    true => format!(
                        "{field} is called as {} is, and no signal is read from it",
                        signal.name
                    ),
                    false => format!("no signal is read from {field}"),
                };
                found.push(TextEdit {
                    file: TOPICS,
                    span: signal.from_at.clone(),
                    old: signal.from.clone(),
                    new: (*field).clone(),
                    kind: SuspectKind::Vocabulary,
                    part: format!("{}, from", signal.name),
                    reach: Reach::Runs,
                    is_said,
                    hint: Some(hint),
                });
            }
        }
        found
    }

    /// Bindings of propositions to signals that none of them reads.
    pub(super) fn signals(&self, study: &Study) -> Vec<TextEdit> {
        let words = &study.vocabulary.propositions;
        let texts: Vec<&String> = words
            .values()
            .filter_map(|p| Some(&p.trace.as_ref()?.text))
            .collect();
        let is_used = |name: &str| texts.iter().any(|text| text.contains(name));
        let mut found = Vec::new();
        for signal in self.signals.iter().filter(|s| !is_used(&s.name)) {
            for predicate in predicates(study, signal, &texts) {
                for (name, proposition) in words {
                    let Some(place) = &proposition.trace else {
                        continue;
                    };
                    let all = texts.iter().map(|text| text.as_str());
                    let hint = is_shared(&place.text, all).then(|| {
                        format!(
                            "no proposition reads {}, and two read `{}`",
                            signal.name, place.text
                        )
                    });
                    let new = predicate.clone();
                    found.push(binding((name, "trace"), place, new, Reach::Runs, hint));
                }
            }
        }
        found
    }

    /// Another signal in place of one in the predicates of subjects in disagreement: one that no proposition reads, and that
    /// can be said the same of.
    pub(super) fn exchanged(&self, study: &Study, is_read: &dyn Fn(&str) -> bool) -> Vec<TextEdit> {
        let words = &study.vocabulary.propositions;
        let bound = || {
            words
                .iter()
                .filter_map(|(name, p)| Some((name, p.trace.as_ref()?)))
        };
        let is_used =
            |signal: &Signal| bound().any(|(_, place)| reads(&place.text, &signal.name).is_some());
        let free: Vec<&Signal> = self.signals.iter().filter(|it| !is_used(it)).collect();
        let mut found = Vec::new();
        for (name, place) in bound().filter(|(name, _)| is_read(name)) {
            for own in &self.signals {
                let Some(at) = reads(&place.text, &own.name) else {
                    continue;
                };
                for other in free.iter().filter(|other| own.is_like(other)) {
                    let mut new = place.text.clone();
                    new.replace_range(at.clone(), &other.name);
                    let hint = format!("no proposition reads {}", other.name);
                    let edit = binding((name, "trace"), place, new, Reach::Runs, Some(hint));
                    add(edit, &mut found);
                }
            }
        }
        found
    }
}

/// Whether the last part of a field's name and that of a signal have a word in common: `/csv.oil_c` and `/fryer.oil`.
fn shares_word(field: &str, signal: &str) -> bool {
    let words = |name: &str| -> Vec<String> {
        let last = name.rsplit('.').next().unwrap_or(name);
        let words = last.split(|c: char| !c.is_ascii_alphanumeric());
        let words = words.filter(|word| word.len() >= SHORTEST_WORD);
        words.map(str::to_lowercase).collect()
    };
    let of_signal = words(signal);
    words(field).iter().any(|word| of_signal.contains(word))
}

/// Where a predicate reads a signal.
pub(super) fn reads(text: &str, signal: &str) -> Option<Range<usize>> {
    let mut places = text
        .match_indices(signal)
        .map(|(at, _)| at..at + signal.len());
    places.find(|at| {
        let next = text[at.end..].chars().next();
        next.is_none_or(|c| !(c.is_ascii_alphanumeric() || "_./".contains(c)))
    })
}

/// The texts of a list on one line of a TOML text.
fn listed(text: &str, key: &str) -> Vec<String> {
    let mut lines = text.lines().filter_map(|line| {
        let (name, list) = line.split_once('=')?;
        (name.trim() == key).then(|| list.trim().trim_matches(['[', ']']))
    });
    let list = lines.next().unwrap_or_default().split(',');
    let texts = list.map(|word| word.trim().trim_matches(['"', '\'']).to_owned());
    texts.filter(|word| !word.is_empty()).collect()
}

/// What can be said of a signal: that it holds, or that it is on either side of a parameter that nothing compares.
fn predicates(study: &Study, signal: &Signal, texts: &[&String]) -> Vec<String> {
    if signal.kind.as_deref() == Some("bool") {
        return vec![signal.name.clone()];
    }
    let Some((_, unit)) = &signal.unit else {
        return Vec::new();
    };
    let Ok(own) = format!("1 {unit}").parse::<QuantityValue>() else {
        return Vec::new();
    };
    let is_word = |text: &&&String, name: &str| {
        let mut words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        words.any(|word| word == name)
    };
    let free = study.parameters.declared.keys().filter(|name| {
        let value = study.parameters.values.get(name);
        let fits = value.is_some_and(|v| v.dimension() == own.dimension());
        fits && !texts.iter().any(|text| is_word(&text, name))
    });
    free.flat_map(|name| [">", "<"].map(|sign| format!("{} {sign} {name}", signal.name)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_is_read_as_a_whole_name() {
        assert_eq!(reads("/a.x > 1 & !/b.on", "/b.on"), Some(12..17));
        assert!(reads("/a.xy > 1", "/a.x").is_none());
    }

    #[test]
    fn signals_are_alike_by_kind_and_unit() {
        let text = "[\"/a.x\"]\nfrom = \"/csv.a\"\nunit = \"mm\"\n\n[\"/a.y\"]\nfrom = \"/csv.b\"\nunit = \"deg\"\n\n\
                    [\"/a.on\"]\nfrom = \"/csv.c\"\nkind = \"bool\"\n\n[\"/a.z\"]\nfrom = \"/csv.d\"\n";
        let all = Topics::of(text).signals;
        let like = |one: usize, other: usize| all[one].is_like(&all[other]);
        assert!(like(0, 3) && like(3, 1) && !like(0, 1) && !like(2, 3));
    }

    #[test]
    fn a_field_that_is_called_as_the_signal_is_says_so() {
        let text = "[\"/fryer.oil\"]\nfrom = \"/csv.wall_c\"\n\n[\"/fryer.wall\"]\nfrom = \"/csv.wall_c\"\n";
        let fields = ["/csv.oil_c", "/csv.wall_c", "/csv.door"].map(str::to_owned);
        let found = Topics::of(text).other_fields(&fields, &|name| name == "/fryer.oil");
        let short: Vec<(&str, bool)> = found
            .iter()
            .map(|it| (it.new.as_str(), it.is_said))
            .collect();
        assert_eq!(short, [("/csv.oil_c", true), ("/csv.door", false)]);
        assert_eq!(&text[found[0].span.clone()], "/csv.wall_c");
    }

    #[test]
    fn quantities_stand_with_their_units() {
        let text = "/x.v < 0.3 m/s & (/x.gap > 20 mm)";
        let found: Vec<&str> = numbers_with_units(text)
            .into_iter()
            .map(|(span, ..)| &text[span])
            .collect();
        assert_eq!(found, ["0.3 m/s", "20 mm"]);
        assert_eq!(other_units("m/s"), ["km/h", "cm/s", "mm/s"]);
    }

    #[test]
    fn a_unit_that_the_field_names_is_a_hint() {
        let text = "[\"/x.v\"]\nfrom = \"/csv.speed_cm_per_s\"\nunit = \"m/s\"\n\n[\"/x.b\"]\nfrom = \"/csv.b\"\nkind = \"bool\"\n";
        let topics = Topics::of(text);
        let edits = topics.units();
        let hinted: Vec<&str> = edits
            .iter()
            .filter(|e| e.hint.is_some())
            .map(|e| e.new.as_str())
            .collect();
        assert_eq!(hinted, ["cm/s"]);
        assert_eq!(&text[edits[0].span.clone()], "m/s");
        let said = Topics::of(&text.replace("\"m/s\"", "\"cm/s\"")).units();
        assert!(said.is_empty(), "the field's name says it: {said:?}");
        // A scale that converts from the field's unit leaves none to be tried; another one is no hint.
        let scaled = |scale| {
            let text =
                format!("[\"/x.f\"]\nfrom = \"/csv.force_mN\"\nunit = \"N\"\nscale = {scale}\n");
            Topics::of(&text).units()
        };
        assert!(scaled("0.001").is_empty());
        assert!(scaled("0.0013").iter().all(|edit| edit.hint.is_none()));
    }
}
