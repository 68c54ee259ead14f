//! The signals of a formula: columns of arrays, read in place, or the last values of a stream.

use crate::problem::{raised, raised_input};
use diagnostic::{Problem, Source};
use numpy::ndarray::ArrayView1;
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::ops::Range;
use temporal::formula::Parsed;
use trace::{
    BoundPredicate, Field, PredicateError, PredicateErrorKind, SignalIndex, SignalValues, Trace,
    Vocabulary,
};

/// The topic of columns whose names are not those of signals.
const TOPIC: &str = "/data";
/// What messages call a formula by.
pub(crate) const FORMULA: &str = "<formula>";

/// A signal as it is declared: its name, its unit (empty if it has none), and whether it is a truth value.
pub(crate) type Declared = (String, String, bool);

/// The signals that there are, and the atoms of a formula over them.
pub(crate) struct Layout {
    /// Where each declared signal is.
    places: Vec<SignalIndex>,
    atoms: Vec<BoundPredicate>,
    /// The names of the signals that each atom reads.
    reads: Vec<Vec<String>>,
}

impl Layout {
    /// Binds the atoms of a formula to declared signals.
    pub(crate) fn new(text: &str, parsed: &Parsed, declared: &[Declared]) -> PyResult<Self> {
        let trace = trace_of(declared)?;
        let vocabulary = names_of(declared);
        let mut layout = Self {
            places: Vec::new(),
            atoms: Vec::new(),
            reads: Vec::new(),
        };
        for (name, ..) in declared {
            let (topic, field) = topic_and_field(name);
            let place = trace.signal(&format!("{topic}.{field}"));
            layout.places.extend(place);
        }
        let of_place = |signal: SignalIndex| {
            let place = layout.places.iter().position(|it| *it == signal);
            place.map(|place| declared[place].0.clone())
        };
        for atom in &parsed.atoms {
            let bound = (vocabulary.predicate(&atom.text)).and_then(|it| it.bind(&trace));
            let bound = bound.map_err(|error| bad_predicate(text, &atom.span, &error, declared))?;
            let reads = bound.signals().into_iter().filter_map(&of_place);
            layout.reads.push(reads.collect());
            layout.atoms.push(bound);
        }
        Ok(layout)
    }

    /// The place among the declared signals.
    fn declared(&self, signal: SignalIndex) -> Option<usize> {
        self.places.iter().position(|it| *it == signal)
    }

    /// The names of the signals that an atom reads.
    pub(crate) fn reads(&self, atom: usize) -> &[String] {
        &self.reads[atom]
    }

    /// Truth and robustness of all atoms now.
    pub(crate) fn judge(&self, values: &impl SignalValues, into: &mut Judged) {
        for (place, atom) in self.atoms.iter().enumerate() {
            let judged = atom.judge(values);
            into.truth[place] = judged.map(|(truth, _)| truth);
            into.robustness[place] = judged.map_or(f64::NAN, |(_, robustness)| robustness);
        }
    }

    /// Room for the values of all atoms.
    pub(crate) fn room(&self) -> Judged {
        Judged {
            truth: vec![None; self.atoms.len()],
            robustness: vec![f64::NAN; self.atoms.len()],
        }
    }
}

/// Truth and robustness of each atom at one sample.
pub(crate) struct Judged {
    pub truth: Vec<Option<bool>>,
    pub robustness: Vec<f64>,
}

fn topic_and_field(name: &str) -> (&str, &str) {
    let is_signal = |(topic, field): &(&str, &str)| topic.len() > 1 && !field.is_empty();
    let split = name.rsplit_once('.').filter(|_| name.starts_with('/'));
    split.filter(is_signal).unwrap_or((TOPIC, name))
}

fn trace_of(declared: &[Declared]) -> PyResult<Trace> {
    let mut topics: Vec<(&str, Vec<Field>)> = Vec::new();
    for (name, unit, is_truth) in declared {
        let (topic, field) = topic_and_field(name);
        let field = match is_truth {
            true => Field::bool(field),
            false => Field::number(field, unit.as_str()),
        };
        match topics.iter_mut().find(|(known, _)| *known == topic) {
            Some((_, fields)) => fields.push(field),
            None => topics.push((topic, vec![field])),
        }
    }
    let mut trace = Trace::new();
    for (topic, fields) in topics {
        let added = trace.add_channel(topic, fields);
        added.map_err(|error| raised_input("bad-signals", error, "rename the signal"))?;
    }
    Ok(trace)
}

/// Columns by their plain names, where these can be names.
fn names_of(declared: &[Declared]) -> Vocabulary {
    let plain = declared.iter().map(|(name, ..)| name.as_str());
    let plain = plain.filter(|name| topic_and_field(name).0 == TOPIC);
    let entry = |name: &str| (name.to_owned(), format!("`{TOPIC}.{name}`"));
    let entries = plain
        .map(entry)
        .filter(|(name, text)| Vocabulary::new([(name.as_str(), text.as_str())]).is_ok());
    // Each by itself is sound, and none refers to another.
    Vocabulary::new(entries).unwrap_or_default()
}

fn bad_predicate(
    text: &str,
    atom: &Range<usize>,
    error: &PredicateError,
    declared: &[Declared],
) -> PyErr {
    let span = match error.entry {
        None => atom.start + error.span.start..atom.start + error.span.end,
        Some(_) => atom.clone(),
    };
    let names: Vec<&str> = declared.iter().map(|(name, ..)| name.as_str()).collect();
    let remedy = match &error.kind {
        // A column may be called as a function is, or have odd letters.
        PredicateErrorKind::UnknownName { name, .. } if names.contains(&name.as_str()) => {
            format!("`{name}` is a word of the language: write {TOPIC}.{name} for the column")
        }
        _ => format!("the signals are {}", names.join(", ")),
    };
    let problem = Problem::new("bad-predicate", error.kind.to_string());
    raised(problem.at(&Source::new(FORMULA, text), span).remedy(remedy))
}

/// Numbers, or truth values.
#[derive(FromPyObject)]
pub(crate) enum Column<'py> {
    /// Of the type `float64`.
    Numbers(PyReadonlyArray1<'py, f64>),
    /// Of the type `bool`.
    Truths(PyReadonlyArray1<'py, bool>),
}

impl Column<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Numbers(array) => array.len(),
            Self::Truths(array) => array.len(),
        }
    }
}

/// Columns where they lie, in any stride.
enum View<'a> {
    Numbers(ArrayView1<'a, f64>),
    Truths(ArrayView1<'a, bool>),
}

/// One row of the columns.
pub(crate) struct Row<'a> {
    layout: &'a Layout,
    columns: Vec<View<'a>>,
    /// For each channel and field, the column.
    at: Vec<Vec<usize>>,
    pub row: usize,
}

impl<'a> Row<'a> {
    pub(crate) fn new(layout: &'a Layout, columns: &'a [Column<'_>]) -> Self {
        let view = |column: &'a Column<'_>| match column {
            Column::Numbers(array) => View::Numbers(array.as_array()),
            Column::Truths(array) => View::Truths(array.as_array()),
        };
        Self {
            layout,
            columns: columns.iter().map(view).collect(),
            at: layout.columns(),
            row: 0,
        }
    }

    pub(crate) fn judge(&self, into: &mut Judged) {
        self.layout.judge(self, into);
    }

    pub(crate) fn room(&self) -> Judged {
        self.layout.room()
    }
}

impl Layout {
    /// For each channel and field, the declared signal.
    fn columns(&self) -> Vec<Vec<usize>> {
        let channels = self.places.iter().map(|it| it.channel + 1).max();
        let mut found = vec![Vec::new(); channels.unwrap_or(0)];
        for (column, place) in self.places.iter().enumerate() {
            let fields = &mut found[place.channel];
            fields.resize(fields.len().max(place.field + 1), 0);
            fields[place.field] = column;
        }
        found
    }
}

impl SignalValues for Row<'_> {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let fields = self.at.get(signal.channel);
        let column = fields.and_then(|fields| fields.get(signal.field));
        match column.and_then(|column| self.columns.get(*column)) {
            Some(View::Numbers(values)) => values[self.row],
            Some(View::Truths(values)) => f64::from(u8::from(values[self.row])),
            None => f64::NAN,
        }
    }
}

/// The last value of each declared signal; not a number before its first.
pub(crate) struct Held<'a> {
    pub layout: &'a Layout,
    pub values: &'a [f64],
}

impl SignalValues for Held<'_> {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let place = self.layout.declared(signal);
        place.map_or(f64::NAN, |place| self.values[place])
    }
}
