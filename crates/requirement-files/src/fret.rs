//! Files of NASA's FRET: its requirements in JSON, its sentences and its formulas.
//!
//! # What is read
//! FRET's export of requirements, with its variables (`{"requirements": [...], "variables": [...]}`) or without (a list). Of each
//! requirement: `reqid`, `fulltext`, `rationale`, `status`, `parent_reqid`, and of its `semantics` the formulas `ftExpanded`,
//! `ftInfAUExpanded`, `ptExpanded` and `pctlExpanded`. Everything else stays as it is.
//!
//! # Source
//! The exports that FRET 3 publishes beside its case studies, and its manual. D. Giannakopoulou, T. Pressburger, A. Mavridou
//! and J. Schumann, "Automated formalization of structured natural language requirements", Information and Software Technology
//! 137, 2021.

mod continuation;
mod expression;
mod meaning;
mod sentence;
mod words;

pub use meaning::{Comparison, LONGEST, Trace};
pub use sentence::{Translation, translated};

use crate::edit::{Edit, applied};
use crate::json::{self, Kind, Value, quoted};
use crate::mistakes::{Mistakes, cannot_write};
use crate::{Change, Columns, Document, Field, File, Format, Item, Placed};
use diagnostic::{Problem, Source};
use meaning::{Formula, compared, compared_sentences};
use requirement_lang::sentence::Sentence;

/// A file without requirements.
pub(crate) const EMPTY: &str = "{\n  \"requirements\": [],\n  \"variables\": []\n}\n";

/// The formulas that FRET made of a sentence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Formulas {
    /// Of the future, for traces that end.
    pub future: Option<String>,
    /// Of the future, for traces that go on for ever.
    pub infinite: Option<String>,
    /// Of the past, at the end of a trace.
    pub past: Option<String>,
    /// Of probabilities.
    pub probabilistic: Option<String>,
}

impl Formulas {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// How the meaning of a sentence of ours and of FRET's formulas compare.
#[derive(Clone, Debug, PartialEq)]
pub struct Meaning {
    /// On runs that go on for ever.
    pub runs: Comparison,
    /// On runs that end.
    pub ends: Comparison,
    /// How FRET's probability differs from the sentence's, in one sentence.
    pub probability: Option<String>,
}

/// Compares a sentence with FRET's formulas. `translation` gives the names of the sentence that stand for FRET's expressions,
/// and how long FRET's time point is; where it does not, it is `step_secs`, or else a second.
#[must_use]
pub fn compare(
    sentence: &Sentence,
    formulas: &Formulas,
    translation: Option<&Translation>,
    step_secs: Option<f64>,
) -> Meaning {
    let none = [];
    let definitions = translation.map_or(&none[..], |it| &it.definitions);
    let step_secs = translation
        .and_then(|it| it.step_secs)
        .or(step_secs)
        .unwrap_or(1.0);
    let formula = |name, text: &Option<String>, at_end| {
        let text = text.clone()?;
        Some((name, text, at_end))
    };
    let infinite = formula("ftInfAUExpanded", &formulas.infinite, false)
        .or_else(|| formula("ftExpanded", &formulas.future, false))
        .into_iter()
        .chain(path_of(formulas, sentence).map(|text| ("pctlExpanded", text, false)));
    let finite = formula("ptExpanded", &formulas.past, true)
        .into_iter()
        .chain(formula("ftExpanded", &formulas.future, false));
    let ask = |wanted: Vec<(&'static str, String, bool)>, ends| {
        if wanted.is_empty() {
            return Comparison::NotCompared("the file has no such formula".to_owned());
        }
        let wanted: Vec<Formula<'_>> = wanted
            .iter()
            .map(|(name, text, at_end)| Formula {
                name,
                text,
                at_end: *at_end,
            })
            .collect();
        compared(sentence, definitions, step_secs, &wanted, ends)
    };
    Meaning {
        runs: ask(infinite.collect(), false),
        ends: ask(finite.collect(), true),
        probability: probability(formulas, sentence),
    }
}

/// Compares a sentence with the one that a text of FRET's says, on runs that go on for ever. A probability that one has and the
/// other has not, or that differs, is a difference of its own, which is not looked at here.
#[must_use]
pub fn compare_with_text(
    sentence: &Sentence,
    text: &Translation,
    step_secs: Option<f64>,
) -> Comparison {
    let step_secs = text.step_secs.or(step_secs).unwrap_or(1.0);
    compared_sentences(sentence, &text.sentence, step_secs)
}

/// The formula of paths of a probabilistic formula in which all probabilities are one, or the outermost is the sentence's.
fn path_of(formulas: &Formulas, sentence: &Sentence) -> Option<String> {
    let read = expression::formula(formulas.probabilistic.as_ref()?).ok()?;
    match probability(formulas, sentence) {
        Some(_) => None,
        None => Some(without_probabilities(&read).to_string()),
    }
}

fn without_probabilities(read: &expression::Expr) -> expression::Expr {
    use expression::Expr;
    let one = |inner: &Expr| Box::new(without_probabilities(inner));
    match read {
        Expr::Probability(_, _, inner) => without_probabilities(inner),
        Expr::Not(inner) => Expr::Not(one(inner)),
        Expr::And(left, right) => Expr::And(one(left), one(right)),
        Expr::Or(left, right) => Expr::Or(one(left), one(right)),
        Expr::Implies(left, right) => Expr::Implies(one(left), one(right)),
        Expr::Prefix(sign, bound, inner) => Expr::Prefix(*sign, *bound, one(inner)),
        Expr::Infix(sign, bound, left, right) => Expr::Infix(*sign, *bound, one(left), one(right)),
        other => other.clone(),
    }
}

/// How FRET's probability differs from the sentence's.
fn probability(formulas: &Formulas, sentence: &Sentence) -> Option<String> {
    use expression::Expr;
    let text = formulas.probabilistic.as_ref()?;
    let read = match expression::formula(text) {
        Ok(read) => read,
        Err(reason) => return Some(format!("pctlExpanded cannot be read: {reason}.")),
    };
    let mut all = Vec::new();
    let outer = probabilities(&read, &mut all);
    let is_one = |(sign, number): &(String, String)| {
        sign == ">=" && number.parse::<f64>().is_ok_and(|it| it == 1.0)
    };
    let own = sentence.probability.as_ref();
    let own = own.map(|it| (it.comparison.sign().to_owned(), it.value));
    let others: Vec<_> = all.iter().filter(|it| !is_one(it)).collect();
    match (others.as_slice(), &own) {
        ([], None) => None,
        ([], Some((sign, value))) => Some(format!(
            "FRET's formula asks for probability 1; the sentence for {sign} {value}."
        )),
        ([(sign, number)], Some((own_sign, value)))
            if outer == 1
                && matches!(read, Expr::Probability(ref s, ref n, _) if s == sign && n == number)
                && sign == own_sign
                && number.parse::<f64>().is_ok_and(|it| it == *value) =>
        {
            None
        }
        ([(sign, number), ..], _) => Some(format!(
            "FRET asks for probability {sign} {number} of the response at each trigger; a sentence of ours asks for it of the \
             whole run, with all its triggers."
        )),
    }
}

/// Collects the probabilities in a formula; how many there are.
fn probabilities(read: &expression::Expr, all: &mut Vec<(String, String)>) -> usize {
    use expression::Expr;
    match read {
        Expr::Probability(sign, number, inner) => {
            all.push((sign.clone(), number.clone()));
            probabilities(inner, all);
        }
        Expr::Not(inner) | Expr::Prefix(_, _, inner) => {
            probabilities(inner, all);
        }
        Expr::And(left, right)
        | Expr::Or(left, right)
        | Expr::Implies(left, right)
        | Expr::Iff(left, right)
        | Expr::Infix(_, _, left, right) => {
            probabilities(left, all);
            probabilities(right, all);
        }
        _ => {}
    }
    all.len()
}

pub(crate) fn read(source: Source, columns: &Columns) -> Result<Document, Problem> {
    if !columns.is_empty() {
        return Err(crate::mistakes::bad("FRET's files have no columns to name")
            .remedy("leave out `--field`"));
    }
    let root = json::read(&source)?;
    let mut mistakes = Mistakes::new(&source);
    let mut items = Vec::new();
    let mut notes = Vec::new();
    match list(&root) {
        Some(all) => {
            for value in all {
                items.extend(placed(value, &mut mistakes));
            }
            if let Some(Kind::List(variables)) = root.get("variables").map(|it| &it.kind)
                && !variables.is_empty()
            {
                notes.push(format!(
                    "Kept in the file: {} of FRET.",
                    diagnostic::counted(variables.len(), "variable")
                ));
            }
        }
        None => mistakes.add(
            root.span.start..root.span.start + 1,
            "this is not an export of FRET's requirements",
            "export them from FRET: a list of requirements, or an object with `requirements`",
        ),
    }
    mistakes.or(())?;
    Ok(Document {
        format: Format::Fret,
        sources: vec![source],
        items,
        fields: Field::ALL.to_vec(),
        notes,
        columns: Columns::default(),
        archive: Vec::new(),
        members: Vec::new(),
        archive_name: String::new(),
    })
}

fn list(root: &Value) -> Option<&Vec<Value>> {
    let value = match &root.kind {
        Kind::List(_) => root,
        _ => root.get("requirements")?,
    };
    match &value.kind {
        Kind::List(all) => Some(all),
        _ => None,
    }
}

fn placed(value: &Value, mistakes: &mut Mistakes<'_>) -> Option<Placed> {
    let span = value.span.start..value.span.start + 1;
    if !matches!(value.kind, Kind::Object(_)) {
        mistakes.add(
            value.span.clone(),
            "a requirement is an object in braces",
            "write `{\"reqid\": ...}`",
        );
        return None;
    }
    let mut text = |key: &str, is_needed: bool| match value.get(key).map(|it| (&it.kind, it)) {
        Some((Kind::Text(text), _)) => Some(text.clone()),
        None | Some((Kind::Null, _)) if !is_needed => Some(String::new()),
        None | Some((Kind::Null, _)) => {
            let message = format!("this requirement has no `{key}`");
            mistakes.add(span.clone(), message, "export it again from FRET");
            None
        }
        Some((_, other)) => {
            let message = format!("`{key}` has to be a text in quotes");
            mistakes.add(other.span.clone(), message, "put it in quotes");
            None
        }
    };
    let (id, full) = (text("reqid", true), text("fulltext", true));
    let (rationale, status) = (text("rationale", false), text("status", false));
    let parents = text("parent_reqid", false);
    let id = id?;
    if id.is_empty() {
        mistakes.add(span, "the `reqid` is empty", "give the requirement an id");
        return None;
    }
    let item = Item {
        id,
        text: full?,
        rationale: rationale?,
        status: status?,
        parents: crate::listed(&parents?),
    };
    let formulas = value.get("semantics").map(formulas);
    Some(Placed {
        item,
        source: 0,
        span: value
            .get("reqid")
            .map_or(value.span.clone(), |it| it.span.clone()),
        formulas: formulas.filter(|it| !it.is_empty()),
    })
}

fn formulas(semantics: &Value) -> Formulas {
    // Older versions marked expressions up for their display.
    let of = |key: &str| {
        let text = semantics.text(key)?;
        let marks = ["<b>", "</b>", "<i>", "</i>"].into_iter();
        Some(marks.fold(text.to_owned(), |text, mark| text.replace(mark, "")))
    };
    // FRET writes these where a sentence has no formula of that kind.
    let known =
        |text: &String| !text.is_empty() && !text.starts_with("BAD_") && !text.contains('$');
    Formulas {
        future: of("ftExpanded").filter(known),
        infinite: of("ftInfAUExpanded").filter(known),
        past: of("ptExpanded").filter(known),
        probabilistic: of("pctlExpanded").or_else(|| of("pctl")).filter(known),
    }
}

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let source = &document.sources[0];
    let root = json::read(source)?;
    let all = list(&root).map_or(&[][..], Vec::as_slice);
    let mut edits = Vec::new();
    let mut added = Vec::new();
    for change in changes {
        match change {
            Change::Set(item, fields) => {
                let value = all.iter().find(|it| it.text("reqid") == Some(&item.id));
                let value =
                    value.ok_or_else(|| cannot_write(&item.id, "the file does not have it"))?;
                edits.extend(set(value, item, fields));
            }
            Change::Add(item) => added.push(item),
        }
    }
    edits.extend(add(source, &root, all, &added));
    Ok(vec![File {
        name: source.name.clone(),
        bytes: applied(&source.text, edits).into_bytes(),
    }])
}

fn key_of(field: Field) -> &'static str {
    match field {
        Field::Text => "fulltext",
        Field::Rationale => "rationale",
        Field::Status => "status",
        Field::Parents => "parent_reqid",
    }
}

fn set(value: &Value, item: &Item, fields: &[Field]) -> Vec<Edit> {
    let mut edits = Vec::new();
    for field in fields {
        let key = key_of(*field);
        let text = quoted(&item.value(*field));
        match (value.get(key), value.get("reqid")) {
            (Some(known), _) => edits.push(Edit::replace(known.span.clone(), text)),
            (None, Some(id)) => edits.push(Edit::insert(
                id.span.end,
                format!(", {}: {text}", quoted(key)),
            )),
            (None, None) => {}
        }
        // Its formulas were those of the sentence that stood here.
        if *field == Field::Text
            && let Some(semantics) = value.get("semantics")
        {
            edits.push(Edit::replace(semantics.span.clone(), "{}"));
        }
    }
    edits
}

/// Adds requirements behind the last one.
fn add(source: &Source, root: &Value, all: &[Value], items: &[&Item]) -> Vec<Edit> {
    if items.is_empty() {
        return Vec::new();
    }
    let project = all
        .iter()
        .find_map(|it| it.text("project"))
        .unwrap_or_default();
    let object = |item: &&Item| {
        let mut keys: Vec<(&str, String)> = vec![("reqid", item.id.clone())];
        keys.push(("parent_reqid", item.parents.join(", ")));
        keys.push(("project", project.to_owned()));
        keys.push(("rationale", item.rationale.clone()));
        keys.push(("fulltext", item.text.clone()));
        keys.push(("status", item.status.clone()));
        let keys = keys
            .iter()
            .map(|(key, text)| format!("      {}: {}", quoted(key), quoted(text)));
        let keys: Vec<String> = keys.collect();
        format!(
            "    {{\n{},\n      \"semantics\": {{}}\n    }}",
            keys.join(",\n")
        )
    };
    let objects: Vec<String> = items.iter().map(object).collect();
    let objects = objects.join(",\n");
    let close = match &root.kind {
        Kind::List(_) => root.span.end - 1,
        _ => root
            .get("requirements")
            .map_or(root.span.end - 1, |it| it.span.end - 1),
    };
    match all.last() {
        Some(last) => vec![Edit::insert(last.span.end, format!(",\n{objects}"))],
        None => {
            let open = source.text[..close].rfind('[').map_or(close, |at| at + 1);
            vec![Edit::replace(open..close, format!("\n{objects}\n  "))]
        }
    }
}
