//! Single edits of the requirement models' texts that something in the study suggests.
//!
//! # Definition
//! An edit replaces one value in one text. What is suggested, and by what:
//!
//! | edit | suggested by |
//! |---|---|
//! | a `column` of the vocabulary names another column | a column that no proposition counts, where two propositions count the same one, or one counts the attempts |
//! | a `model` binding `variable=value` names another value, or `variable` another variable | a value that the model assigns and no proposition names, where it has the proposition's name, or where two propositions mean the same states |
//! | a `trace` binding becomes another signal | a signal of topics.toml that no proposition reads, where two propositions read the same predicate |
//! | a `trace` binding `signal == 'value'` names another value | a value of the signal that no proposition names, where it has the proposition's name, or where two propositions read the same predicate |
//! | a quantity in a `trace` binding has another unit | another unit of the dimension |
//! | a hand-written `property`, or what a `monitor` waits for, names another proposition | the proposition that the other forms of the same requirement name |
//! | a limit `within_secs`, or one in a hand-written `property` | a duration in the requirement's own text or sentence, or the limit of its other form, or a slip by a factor |
//! | the `unit` of a signal | the unit that the field's own name ends with, or another unit of the dimension |
//!
//! A free column, value or signal is tried for every proposition; by itself it suggests nothing, since a model may well
//! have states that no proposition names.
//!
//! # Guarantee
//! None: a candidate is an idea. It is accepted only by what it does to all the evidence (`edits`).

pub(super) mod limits;

use crate::problem::Problem;
use crate::study::{Rule, Study, SubjectForm, Work, quoted_names};
use evidence::{Subject, SuspectKind, requirement_form};
use std::collections::BTreeSet;
use std::ops::Range;
use trace::Table;
use trace::units::QuantityValue;

/// Which evidence an edit reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reach {
    /// What formal models answer.
    Models,
    /// What tables count.
    Tables,
    /// How runs are judged.
    Runs,
}

/// One value of one text replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TextEdit {
    /// The file, relative to the study.
    pub file: &'static str,
    /// The place of the value in it.
    pub span: Range<usize>,
    /// What stands there now.
    pub old: String,
    /// What would stand there.
    pub new: String,
    /// What kind of thing is edited.
    pub kind: SuspectKind,
    /// Which part of the file.
    pub part: String,
    /// Which evidence it reaches.
    pub reach: Reach,
    /// What suggests it, in one clause; none for a slip by a factor or another unit of the dimension.
    pub hint: Option<String>,
    /// Whether the hint says this very value, not only that one is free.
    pub is_said: bool,
}

const VOCABULARY: &str = "vocabulary.toml";
const REQUIREMENTS: &str = "requirements.toml";
const TOPICS: &str = "topics.toml";

/// All that is suggested, in the order of the files.
pub(super) fn candidates(study: &Study) -> Result<Vec<TextEdit>, Problem> {
    let mut found = columns(study)?;
    found.extend(model_bindings(study)?);
    for form in &study.forms.subjects {
        found.extend(other_words(study, form));
        found.extend(limits::of_form(study, form));
    }
    found.extend(quantities(study));
    let path = study.folder.join(TOPICS);
    if path.exists() {
        let topics = Topics::of(&crate::problem::Source::read(&path)?.text);
        found.extend(topics.units());
        found.extend(topics.signals(study));
        found.extend(topics.values(study));
    }
    Ok(found)
}

/// An edit of a proposition's binding.
fn binding(
    (proposition, key): (&str, &str),
    place: &crate::study::Binding,
    new: String,
    reach: Reach,
    hint: Option<String>,
) -> TextEdit {
    TextEdit {
        file: VOCABULARY,
        span: place.span.clone(),
        old: place.text.clone(),
        new,
        kind: SuspectKind::Vocabulary,
        part: format!("{proposition}, {key}"),
        reach,
        hint,
        is_said: false,
    }
}

/// Whether more than one of these texts is this one.
fn is_shared<'t>(text: &str, all: impl Iterator<Item = &'t str>) -> bool {
    all.filter(|other| plain(other) == plain(text)).count() > 1
}

/// Bindings of propositions to columns that none of them counts.
fn columns(study: &Study) -> Result<Vec<TextEdit>, Problem> {
    let bound: Vec<(&String, &crate::study::Binding)> = study
        .vocabulary
        .propositions
        .iter()
        .filter_map(|(name, p)| Some((name, p.column.as_ref()?)))
        .collect();
    let known: BTreeSet<String> = bound.iter().map(|(_, b)| plain(&b.text)).collect();
    let mut found = Vec::new();
    for entry in &study.ledger {
        let Work::Read {
            cohort: Some(cohort),
            ..
        } = &entry.work
        else {
            continue;
        };
        let Ok(table) = Table::read(&study.folder.join(cohort)) else {
            continue;
        };
        // The first column names the people.
        for header in table.headers().iter().skip(1).filter(|h| *h != "attempts") {
            let is_counted = |b: &String| b == header || b.starts_with(&format!("{header}:"));
            let is_count = table.column(header).is_ok_and(|c| c.as_counts().is_ok());
            if known.iter().any(is_counted) || !is_count {
                continue;
            }
            for (name, place) in bound.iter().filter(|(_, b)| !b.text.contains(':')) {
                let all = bound.iter().map(|(_, b)| b.text.as_str());
                let is_odd = place.text.trim() == "attempts" || is_shared(&place.text, all);
                let hint = is_odd.then(|| {
                    format!(
                        "no proposition counts the column `{header}`, and `{}` is counted otherwise already",
                        place.text
                    )
                });
                let edit = binding((name, "column"), place, header.clone(), Reach::Tables, hint);
                if !found.contains(&edit) {
                    found.push(edit);
                }
            }
        }
    }
    Ok(found)
}

/// Whether a value, a variable or a signal has a proposition's name: `at_done` and `s=done` have that of `done`.
fn is_named_after(text: &str, proposition: &str) -> bool {
    let letters = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let (text, name) = (letters(text), letters(proposition));
    let mut places = text.match_indices(name.as_str());
    places.any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + name.len()..]);
        let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_ascii_alphanumeric());
        is_end(before.chars().next_back()) && is_end(after.chars().next())
    })
}

fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().concat()
}

fn is_word(word: &str) -> bool {
    !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// `variable=value`, if a binding is that.
fn equality(text: &str) -> Option<(String, String)> {
    let (variable, value) = text.split_once('=')?;
    let (variable, value) = (variable.trim(), value.trim());
    (is_word(variable) && is_word(value)).then(|| (variable.to_owned(), value.to_owned()))
}

/// What a model's text lets a binding be instead: the same variable with another value that is assigned, or another
/// variable that is made true, or another formula or label.
fn other_states(text: &str, binding: &str) -> Vec<String> {
    if let Some((variable, _)) = equality(binding) {
        let values = assigned(text, &variable).into_iter();
        return values.map(|value| format!("{variable}={value}")).collect();
    }
    let binding = binding.trim();
    let formulas = declared(text, "formula");
    let labels = declared(text, "label");
    match (is_word(binding), formulas.contains(binding)) {
        (true, true) => formulas.into_iter().collect(),
        (true, false) => made_true(text).into_iter().collect(),
        (false, _) if labels.contains(binding) => labels.into_iter().collect(),
        (false, _) => Vec::new(),
    }
}

/// What a model's text declares by a keyword at the beginning of a line: `in_dock`, or `"done"`, quotes and all.
fn declared(text: &str, keyword: &str) -> BTreeSet<String> {
    let names = text.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix(keyword)?;
        let (name, _) = rest.strip_prefix(' ')?.split_once('=')?;
        Some(name.trim().to_owned())
    });
    names.collect()
}

/// The variables that a model's text makes true: of `(done'=true)` it is `done`.
fn made_true(text: &str) -> BTreeSet<String> {
    let updates = text.split('(').filter_map(|part| {
        let (name, rest) = part.split_once('\'')?;
        let value = rest.trim_start().strip_prefix('=')?.trim_start();
        let is_true = value.strip_prefix("true")?.trim_start().starts_with(')');
        (is_true && is_word(name.trim())).then(|| name.trim().to_owned())
    });
    updates.collect()
}

/// Bindings to states that the models come to and that no proposition names.
fn model_bindings(study: &Study) -> Result<Vec<TextEdit>, Problem> {
    let bound: Vec<(&String, &crate::study::Binding)> = study
        .vocabulary
        .propositions
        .iter()
        .filter_map(|(name, p)| Some((name, p.model.as_ref()?)))
        .collect();
    let known: BTreeSet<String> = bound.iter().map(|(_, b)| plain(&b.text)).collect();
    let mut found = Vec::new();
    for entry in &study.ledger {
        let Work::Check { model, .. } = &entry.work else {
            continue;
        };
        let text = crate::problem::Source::read(&study.folder.join(model))?.text;
        for (name, place) in &bound {
            for new in other_states(&text, &place.text) {
                if known.contains(&plain(&new)) {
                    continue;
                }
                let all = bound.iter().map(|(_, place)| place.text.as_str());
                let is_said = is_named_after(&new, name) && !is_named_after(&place.text, name);
                let free = format!(
                    "{} comes to `{new}`, which no proposition names",
                    model.display()
                );
                let hint = match (is_said, is_shared(&place.text, all)) {
                    (true, _) => Some(format!("{free} and which has this one's name")),
                    (false, true) => Some(format!("{free}, and two mean `{}`", place.text)),
                    (false, false) => None,
                };
                let edit = TextEdit {
                    is_said,
                    ..binding((name, "model"), place, new, Reach::Models, hint)
                };
                if !found.contains(&edit) {
                    found.push(edit);
                }
            }
        }
    }
    Ok(found)
}

/// The words that a model's text assigns to a variable: of `(state'=done)` it is `done`.
fn assigned(text: &str, variable: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices(&format!("{variable}'")) {
        let rest = text[at + variable.len() + 1..].trim_start();
        let Some(rest) = rest.strip_prefix('=') else {
            continue;
        };
        let rest = rest.trim_start();
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let word = &rest[..end.unwrap_or(rest.len())];
        let is_plain = rest[word.len()..].trim_start().starts_with(')');
        if !word.is_empty() && is_plain {
            found.insert(word.to_owned());
        }
    }
    found
}

/// The propositions that a form of traces names.
fn of_monitor(form: &SubjectForm) -> Vec<String> {
    let texts: Vec<String> = match form.monitor.as_ref().map(|monitor| &monitor.rule) {
        Some(Rule::Staged(spec)) => spec.propositions().into_iter().map(Into::into).collect(),
        Some(Rule::Formula(rule)) => rule.parsed.atoms.iter().map(|a| a.text.clone()).collect(),
        None => Vec::new(),
    };
    let words = texts.iter().flat_map(|text| {
        text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
            .map(str::to_owned)
    });
    words.collect()
}

/// A property's word, or one that a monitor waits for, by a word of the requirement's other forms.
fn other_words(study: &Study, form: &SubjectForm) -> Vec<TextEdit> {
    let words = &study.vocabulary.propositions;
    let mut found = Vec::new();
    let property = form.property.as_ref().filter(|p| !p.from_sentence);
    let asked: Vec<String> = property.map_or_else(Vec::new, |p| {
        quoted_names(&p.text)
            .into_iter()
            .map(|(name, _)| name)
            .collect()
    });
    if let Some(property) = property {
        // What a failure mode's monitor waits for is that it does not occur.
        let of_traces = match form.subject {
            Subject::Requirement(_) => of_monitor(form),
            Subject::FailureMode(_) => Vec::new(),
        };
        let others = of_traces.into_iter().chain(form.experiment.clone());
        let others: BTreeSet<String> = others
            .filter(|w| words.get(w).is_some_and(|p| p.model.is_some()) && !asked.contains(w))
            .collect();
        for (name, place) in quoted_names(&property.text) {
            for other in &others {
                found.push(TextEdit {
                    file: REQUIREMENTS,
                    span: property.span.start + place.start..property.span.start + place.end,
                    old: name.clone(),
                    new: other.clone(),
                    kind: SuspectKind::Property,
                    part: part_of(form, "property"),
                    reach: Reach::Models,
                    hint: Some(format!("the other forms of it name `{other}`")),
                    is_said: true,
                });
            }
        }
    }
    if matches!(form.subject, Subject::FailureMode(_)) {
        return found;
    }
    let others: BTreeSet<String> = asked.into_iter().chain(form.experiment.clone()).collect();
    let text = &study.forms.source.text;
    for (span, word) in values(text, block(text, form), "wait_for") {
        let known = of_monitor(form);
        let fits =
            |w: &&String| words.get(*w).is_some_and(|p| p.trace.is_some()) && !known.contains(w);
        for other in others.iter().filter(fits) {
            let word = word.trim_matches(['"', '\'']);
            let start = span.start + 1;
            found.push(TextEdit {
                file: REQUIREMENTS,
                span: start..start + word.len(),
                old: word.to_owned(),
                new: other.clone(),
                kind: SuspectKind::Monitor,
                part: part_of(form, "monitor"),
                reach: Reach::Runs,
                hint: Some(format!("the other forms of it name `{other}`")),
                is_said: true,
            });
        }
    }
    found
}

fn part_of(form: &SubjectForm, which: &str) -> String {
    requirement_form(&form.subject, which, &[])
        .part
        .unwrap_or_default()
}

/// The lines of a requirement or failure mode in the file.
fn block(text: &str, form: &SubjectForm) -> Range<usize> {
    let id = format!("\"{}\"", form.subject.id());
    let kind = match form.subject {
        Subject::Requirement(_) => "[[requirement]]",
        Subject::FailureMode(_) => "[[failure_mode]]",
    };
    for (start, _) in text.match_indices(kind) {
        let end = text[start + 2..]
            .find("\n[[")
            .map_or(text.len(), |at| start + 2 + at);
        let is_own = text[start..end].lines().any(|line| {
            let (key, value) = line.split_once('=').unwrap_or((line, ""));
            key.trim() == "id" && value.trim().starts_with(&id)
        });
        if is_own {
            return start..end;
        }
    }
    0..0
}

/// The values of a key within a part of a TOML text, with their places, as they are written.
fn values(text: &str, within: Range<usize>, key: &str) -> Vec<(Range<usize>, String)> {
    let mut found = Vec::new();
    for (at, _) in text[within.clone()].match_indices(key) {
        let from = within.start + at + key.len();
        let rest = &text[from..within.end];
        let Some(value) = rest.trim_start().strip_prefix('=') else {
            continue;
        };
        let value = value.trim_start();
        let start = within.end - value.len();
        let length = match value.chars().next() {
            Some(quote @ ('"' | '\'')) => value[1..].find(quote).map(|at| at + 2),
            _ => value.find(|c: char| !(c.is_ascii_digit() || ".eE+-_".contains(c))),
        };
        let length = length.unwrap_or(value.len());
        if length > 0 {
            found.push((start..start + length, value[..length].to_owned()));
        }
    }
    found
}

/// Units that are written for one another.
const UNITS: [&str; 24] = [
    "mm", "cm", "m", "km", "mm/s", "cm/s", "m/s", "km/h", "ms", "s", "min", "rad", "deg", "rad/s",
    "deg/s", "g", "kg", "mN", "N", "kN", "mA", "A", "mV", "V",
];

/// Quantities in the predicates of traces, with other units of their dimension.
fn quantities(study: &Study) -> Vec<TextEdit> {
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
fn numbers_with_units(text: &str) -> Vec<(Range<usize>, &str, &str)> {
    let mut found = Vec::new();
    let mut at = 0;
    for word in text.split_inclusive(' ') {
        let (start, number) = (at, word.trim_end());
        at += word.len();
        let is_number = number.parse::<f64>().is_ok() && word.ends_with(' ');
        let rest = &text[at..];
        let length = rest.find([' ', ')', '&', '|']).unwrap_or(rest.len());
        let unit = &rest[..length];
        if is_number && UNITS.contains(&unit) {
            found.push((start..at + length, number, unit));
        }
    }
    found
}

/// Other units of the same dimension.
fn other_units(unit: &str) -> Vec<&'static str> {
    let parsed = |unit: &str| format!("1 {unit}").parse::<QuantityValue>().ok();
    let Some(own) = parsed(unit) else {
        return Vec::new();
    };
    let is_other = |other: &&&str| {
        let value = parsed(other);
        value.is_some_and(|v| v.dimension() == own.dimension() && v.si_value() != own.si_value())
    };
    UNITS.iter().filter(is_other).copied().collect()
}

/// A signal of topics.toml.
struct Signal {
    name: String,
    from: String,
    kind: Option<String>,
    unit: Option<(Range<usize>, String)>,
    values: Vec<String>,
}

/// What topics.toml says, with places.
struct Topics {
    signals: Vec<Signal>,
}

impl Topics {
    fn of(text: &str) -> Self {
        let mut starts: Vec<usize> = text.match_indices("[\"/").map(|(at, _)| at).collect();
        starts.push(text.len());
        let unquoted = |word: String| word.trim_matches(['"', '\'']).to_owned();
        let signals = starts.windows(2).filter_map(|pair| {
            let name = text[pair[0] + 2..pair[1]].split('"').next()?.to_owned();
            let value = |key: &str| values(text, pair[0]..pair[1], key).into_iter().next();
            Some(Signal {
                name,
                from: unquoted(value("from")?.1),
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
    fn units(&self) -> Vec<TextEdit> {
        let mut found = Vec::new();
        for signal in &self.signals {
            let Some((span, unit)) = &signal.unit else {
                continue;
            };
            for other in other_units(unit) {
                let suffix = format!("_{}", other.replace('/', "_per_")).to_lowercase();
                let says = signal.from.to_lowercase().ends_with(&suffix);
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
    fn values(&self, study: &Study) -> Vec<TextEdit> {
        let words = &study.vocabulary.propositions;
        let bound: Vec<(&String, &crate::study::Binding)> = words
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
                let hint = match (is_said, is_shared(&place.text, all)) {
                    (true, _) => Some(format!("{free}, which has this one's name")),
                    (false, true) => Some(format!("{free}, and two read `{}`", place.text)),
                    (false, false) => None,
                };
                found.push(TextEdit {
                    is_said,
                    ..binding((name, "trace"), place, new, Reach::Runs, hint)
                });
            }
        }
        found
    }

    /// Bindings of propositions to signals that none of them reads.
    fn signals(&self, study: &Study) -> Vec<TextEdit> {
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
    fn values_stand_where_they_are_found() {
        let text = "a.then = [{ wait_for = \"x\", within_secs = 25 }]\nwithin_secs=7\n";
        let found = values(text, 0..text.len(), "within_secs");
        let said: Vec<&str> = found.iter().map(|(span, _)| &text[span.clone()]).collect();
        assert_eq!(said, ["25", "7"]);
        let found = values(text, 0..text.len(), "wait_for");
        assert_eq!(&text[found[0].0.clone()], "\"x\"");
    }

    #[test]
    fn the_values_that_a_model_assigns_are_words_behind_its_updates() {
        let text = "[] s=0 -> 0.5:(s'=done) + 0.5:(s'=s+1); [] s=1 -> (s' = 3);";
        let found: Vec<String> = assigned(text, "s").into_iter().collect();
        assert_eq!(found, ["3", "done"]);
        let text =
            "[] at_a -> 0.5:(at_a'=false)&(done'=true) + 0.5:(at_a' = false) & (lost'= true);";
        assert_eq!(other_states(text, "at_b"), ["done", "lost"]);
        assert_eq!(equality("s=done"), Some(("s".into(), "done".into())));
        assert_eq!(equality("s=1 & t=2"), None);
    }

    #[test]
    fn names_are_told_as_words() {
        assert!(is_named_after("s=at_Finished_round", "finished_round"));
        assert!(is_named_after("done", "done") && is_named_after("in-dock", "in_dock"));
        assert!(!is_named_after("s=undone", "done") && !is_named_after("s=done2", "done"));
    }

    #[test]
    fn quantities_stand_with_their_units() {
        let text = "/x.v < 0.3 m/s & (/x.gap > 20 mm)";
        let found: Vec<&str> = numbers_with_units(text)
            .into_iter()
            .map(|(span, ..)| &text[span])
            .collect();
        assert_eq!(found, ["0.3 m/s", "20 mm"]);
        assert_eq!(other_units("m/s"), ["mm/s", "cm/s", "km/h"]);
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
    }
}
