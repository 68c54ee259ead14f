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
//! | a parameter that a formula reads, or a number in a `trace` binding, has another value | a quantity that the requirement's text says, another unit of the dimension, or a slip by a factor |
//! | a bare number in a `trace` binding has another value | a number that the requirement's text says or the `model` of the same proposition, or a slip by a factor |
//! | a comparison in a `trace` binding is the other way round | nothing but that it can be |
//! | a clause of a `trace` or `model` binding is negated, joined or compared otherwise, or left out (`clauses`) | nothing but that it can be |
//! | a hand-written `property` or `formula` is negated or joined otherwise (`formulas`) | nothing but that it can be |
//! | a hand-written `property`, `trigger` or `opportunity` names another proposition (`names`) | the subject's own words have its name, or nothing but that it can be |
//! | the property of a failure mode says that a proposition comes about (`formulas`) | its other forms name it |
//! | a clause of a `model` binding of several asks for another value or Boolean variable | nothing but that it can be |
//! | a `model` binding has a further case | a state that the model comes to and no proposition names |
//! | a signal in a `trace` binding is another | a signal of topics.toml that no proposition reads, and that the same can be said of |
//! | the field that a signal is read `from` is another | a field of the recordings that no signal is read from, above all one that is called as the signal is |
//! | a proposition in a sentence is another | the requirement's text has its name, or nothing else reads it |
//! | the scope, the condition or the timing of a sentence is another, or a duration in it (`phrases`) | nothing but that it can be; the requirement's text says the duration |
//! | a hand-written `property` or `formula`, or what a `monitor` waits for, names another proposition | the proposition that the other forms of the same requirement name |
//! | a limit `within_secs`, or one in a hand-written `property` | a duration in the requirement's own text or sentence, or the limit of its other form, or a slip by a factor |
//! | the `step` of study.toml, the `mission_time` of a fault tree | a slip by a factor, or a duration that a requirement says |
//! | the `unit` of a signal | the unit that the field's own name ends with, or another unit of the dimension where it ends with none |
//! | the `scale` or the `offset` of a signal | that of a signal whose field ends alike, a slip by a factor, the sign, or what usual units are of each other (`scales`) |
//!
//! Gates of fault trees and branches of formal models are of system models, and tried with these (`gates`, `lines`).
//!
//! A free column, value or signal is tried for every proposition; by itself it suggests nothing, since a model may well
//! have states that no proposition names.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! None: a candidate is an idea. It is accepted only by what it does to all the evidence (`edits`).

pub(super) mod clauses;
mod formulas;
pub(super) mod limits;
mod names;
mod phrases;
mod quantities;
pub(super) mod scales;
mod sentences;
mod times;
mod topics;

use diagnostic::Problem;
use evidence::{Subject, SuspectKind, requirement_form};
use std::collections::BTreeSet;
use std::ops::Range;
use study::{Rule, Study, SubjectForm, quoted_names};
use topics::Topics;
use trace::Table;

/// Which evidence an edit reaches.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reach {
    /// What formal models answer.
    Models,
    /// What the fault tree of this entry gives; the edit is its mission time.
    Tree(String),
    /// What tables count.
    Tables,
    /// How runs are judged.
    Runs,
    /// How runs are judged, what formal models answer, and what tables count.
    All,
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

impl TextEdit {
    /// The edit of all runs that changes nothing.
    pub(super) fn none() -> Self {
        Self {
            file: VOCABULARY,
            span: 0..0,
            old: String::new(),
            new: String::new(),
            kind: SuspectKind::Vocabulary,
            part: String::new(),
            reach: Reach::Runs,
            hint: None,
            is_said: false,
        }
    }

    /// Whether another edit changes the same value.
    pub(super) fn is_of_place(&self, other: &Self) -> bool {
        (self.file, &self.span) == (other.file, &other.span)
    }

    /// Whether another duration takes the place of one.
    pub(super) fn is_of_time(&self) -> bool {
        match self.kind {
            SuspectKind::TimeScale => true,
            SuspectKind::Property | SuspectKind::Monitor => self.is_number(),
            _ => self.file == PARAMETERS && quantities::is_duration(&self.old),
        }
    }

    /// Whether what suggests it says no more than that it is free.
    pub(super) fn is_free(&self) -> bool {
        self.hint.is_some() && !self.is_said
    }

    /// What would stand there, on one line.
    pub(super) fn new_in_words(&self) -> String {
        self.new.replace('\n', ", ")
    }

    /// Whether a number takes the place of a number, in the same unit if it has one, or that of none.
    pub(super) fn is_number(&self) -> bool {
        if self.new.contains('\n') {
            return true;
        }
        let unit_of = |text: &str| -> Option<String> {
            let text = text.trim_start_matches(['<', '=', '>', ' ', '-']);
            let rest = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
            (rest.len() < text.len()).then(|| rest.trim().to_owned())
        };
        let units = (unit_of(&self.old), unit_of(&self.new));
        units.0.is_some() && units.0 == units.1
    }
}

const VOCABULARY: &str = "vocabulary.toml";
const PARAMETERS: &str = "parameters.toml";
const REQUIREMENTS: &str = "requirements.toml";
const TOPICS: &str = "topics.toml";
const STUDY: &str = "study.toml";
const LEDGER: &str = "ledger.toml";

/// All that is suggested, in the order of the files, with the `fields` that recordings have. Of numbers that formulas read those alone that bear on a subject that
/// `disagrees`, since each is tried on all recordings.
pub(super) fn candidates(
    study: &Study,
    disagrees: &dyn Fn(&Subject) -> bool,
    fields: &[String],
) -> Result<Vec<TextEdit>, Problem> {
    let mut found = columns(study)?;
    // A further case before another one in its place: of edits that explain as much, the first is named first.
    found.extend(clauses::of_vocabulary(study, disagrees));
    found.extend(model_bindings(study)?);
    for form in &study.forms.subjects {
        found.extend(other_words(study, form));
        found.extend(limits::of_form(study, form));
    }
    found.extend(topics::quantities(study));
    found.extend(quantities::in_bindings(study, disagrees));
    found.extend(quantities::parameters(study, disagrees));
    found.extend(formulas::of_forms(study, disagrees));
    found.extend(names::of_forms(study, disagrees));
    found.extend(sentences::of_requirements(study, disagrees));
    found.extend(phrases::of_requirements(study, disagrees));
    found.extend(times::of_step(study));
    found.extend(times::of_missions(study));
    let path = study.folder.join(TOPICS);
    if path.exists() {
        let text = host::files::read_source(&path)?.text;
        let topics = Topics::of(&text);
        let is_judged = |proposition: &str| {
            let mut forms = study.forms.subjects.iter();
            forms.any(|form| {
                disagrees(&form.subject) && of_monitor(form).iter().any(|it| it == proposition)
            })
        };
        let is_read = |signal: &str| {
            let mut words = study.vocabulary.propositions.iter();
            words.any(|(name, it)| {
                let place = it
                    .trace
                    .as_ref()
                    .and_then(|it| topics::reads(&it.text, signal));
                place.is_some() && is_judged(name)
            }) || study.forms.subjects.iter().any(|form| {
                let rule = form.monitor.as_ref().map(|it| &it.rule);
                let text = match rule {
                    Some(Rule::Formula(rule)) => rule.text.as_str(),
                    Some(Rule::Staged(_)) | None => "",
                };
                disagrees(&form.subject) && topics::reads(text, signal).is_some()
            })
        };
        found.extend(scales::of_topics(&text, &is_read));
        found.extend(topics.exchanged(study, &is_judged));
        found.extend(topics.other_fields(fields, &is_read));
        found.extend(topics.units());
        found.extend(topics.signals(study));
        found.extend(topics.values(study));
    }
    Ok(found)
}

/// Whether a subject's sentence, or a predicate that its monitor reads, names a parameter.
pub(super) fn reads_parameters(study: &Study, form: &SubjectForm) -> bool {
    let mut names = study.parameters.declared.keys();
    names.any(|name| quantities::is_reader(study, form, name))
}

/// An edit of a proposition's binding.
fn binding(
    (proposition, key): (&str, &str),
    place: &study::Binding,
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

/// What suggests something free in place of a binding's text: that it has the proposition's own name, or that another
/// proposition means the same already.
fn hint_of_free<'t>(
    free: &str,
    is_said: bool,
    text: &str,
    all: impl Iterator<Item = &'t str>,
) -> Option<String> {
    match (is_said, is_shared(text, all)) {
        (true, _) => Some(format!("{free}; it has this one's name")),
        (false, true) => Some(format!("{free}; two propositions mean `{text}`")),
        (false, false) => None,
    }
}

/// Bindings of propositions to columns that none of them counts.
fn columns(study: &Study) -> Result<Vec<TextEdit>, Problem> {
    let bound: Vec<(&String, &study::Binding)> = study
        .vocabulary
        .propositions
        .iter()
        .filter_map(|(name, p)| Some((name, p.column.as_ref()?)))
        .collect();
    let known: BTreeSet<String> = bound.iter().map(|(_, b)| plain(&b.text)).collect();
    let mut found = Vec::new();
    for entry in &study.ledger {
        let Some(cohort) = entry.work.cohort() else {
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

/// `variable=value` with a value that something is added to or taken from, if a binding is that.
fn sum_equality(text: &str) -> Option<(String, String)> {
    let (variable, value) = text.split_once('=')?;
    let (variable, value) = (variable.trim(), value.trim());
    let is_sum = value.contains(['+', '-']) && !value.contains(['=', '<', '>', '&', '|', '!', '(']);
    (is_word(variable) && is_sum).then(|| (variable.to_owned(), value.to_owned()))
}

/// What a model's text lets a binding be instead: the same variable with another value that is assigned, or another
/// variable that is made true, or another formula or label.
fn other_states(text: &str, binding: &str) -> Vec<String> {
    if let Some((variable, _)) = equality(binding) {
        let values = assigned(text, &variable).into_iter();
        return values.map(|value| format!("{variable}={value}")).collect();
    }
    if let Some((variable, value)) = sum_equality(binding) {
        // Of `n=N-1` it is `n=N`.
        let first = value.split(['+', '-']).next().unwrap_or_default().trim();
        let values = assigned(text, &variable).into_iter();
        let values = values.chain(is_word(first).then(|| first.to_owned()));
        return values.map(|value| format!("{variable}={value}")).collect();
    }
    let binding = binding.trim();
    let formulas = declared(text, "formula");
    let labels = declared(text, "label");
    match (is_word(binding), formulas.contains(binding)) {
        (true, true) => formulas.into_iter().collect(),
        (true, false) => made_true(text).into_iter().collect(),
        (false, _) if labels.contains(binding) => labels.into_iter().collect(),
        // Whatever it says of states, a variable that is made true may say it instead.
        (false, _) => made_true(text).into_iter().collect(),
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

/// Whether a state stands in a text, and not as a part of a longer name or number.
fn mentions(text: &str, state: &str) -> bool {
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_');
    text.match_indices(state).any(|(at, _)| {
        !is_part(text[..at].chars().next_back())
            && !is_part(text[at + state.len()..].chars().next())
    })
}

/// Bindings to states that the models come to and that no proposition names.
fn model_bindings(study: &Study) -> Result<Vec<TextEdit>, Problem> {
    let bound: Vec<(&String, &study::Binding)> = study
        .vocabulary
        .propositions
        .iter()
        .filter_map(|(name, p)| Some((name, p.model.as_ref()?)))
        .collect();
    let known: BTreeSet<String> = bound.iter().map(|(_, b)| plain(&b.text)).collect();
    let mut found = Vec::new();
    for entry in &study.ledger {
        let Some(model) = entry.work.model() else {
            continue;
        };
        let text = host::files::read_prism(&study.folder.join(model))?.0.text;
        for (name, place) in &bound {
            for new in other_states(&text, &place.text) {
                let mut all = known.iter();
                if all.any(|text| mentions(text, &plain(&new))) {
                    continue;
                }
                let all = bound.iter().map(|(_, place)| place.text.as_str());
                let is_said = is_named_after(&new, name) && !is_named_after(&place.text, name);
                let free = format!(
                    "{} comes to `{new}`, which no proposition names",
                    model.display()
                );
                let hint = hint_of_free(&free, is_said, &place.text, all);
                let edit = TextEdit {
                    is_said,
                    ..binding((name, "model"), place, new, Reach::Models, hint)
                };
                if !found.contains(&edit) {
                    found.push(edit);
                }
            }
            for new in clauses::with_other_operands(&place.text, &|own| other_states(&text, own)) {
                let edit = binding((name, "model"), place, new, Reach::Models, None);
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
pub(super) fn of_monitor(form: &SubjectForm) -> Vec<String> {
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
    found.extend(other_words_of_formula(study, form, &asked));
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

/// A word of a formula by one that the property, or the column, of the same subject names and the formula does not.
fn other_words_of_formula(study: &Study, form: &SubjectForm, asked: &[String]) -> Vec<TextEdit> {
    let words = &study.vocabulary.propositions;
    let known = of_monitor(form);
    let others: BTreeSet<&String> = asked.iter().chain(&form.experiment).collect();
    let fits =
        |it: &&&String| words.get(**it).is_some_and(|p| p.trace.is_some()) && !known.contains(it);
    let text = &study.forms.source.text;
    let mut found = Vec::new();
    for (span, quoted) in values(text, block(text, form), "formula") {
        for (place, word) in sentences::words_of(&quoted) {
            if !words.contains_key(word) {
                continue;
            }
            found.extend(others.iter().filter(fits).map(|other| TextEdit {
                file: REQUIREMENTS,
                span: span.start + place.start..span.start + place.end,
                old: word.to_owned(),
                new: (*other).clone(),
                kind: SuspectKind::Monitor,
                part: part_of(form, "monitor"),
                reach: Reach::Runs,
                hint: Some(format!("the other forms of it name `{other}`")),
                is_said: true,
            }));
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
    let kind = match form.subject {
        Subject::Requirement(_) => "[[requirement]]",
        Subject::FailureMode(_) => "[[failure_mode]]",
    };
    block_of(text, kind, form.subject.id())
}

/// The lines of an entry in the ledger.
fn entry_block(text: &str, id: &str) -> Range<usize> {
    block_of(text, "[[evidence]]", id)
}

/// The lines of the table of this kind that has an identifier.
fn block_of(text: &str, kind: &str, id: &str) -> Range<usize> {
    let id = format!("\"{id}\"");
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
}
