//! Formulas of temporal logic over arrays and streams.

use crate::problem::{guarded, raised, raised_input};
use crate::signals::{Column, Declared, FORMULA, Held, Judged, Layout, Row};
use diagnostic::{Problem, Source};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use temporal::formula::{
    self, Ending, FormulaJudge, FormulaMonitor, FormulaReport, Interpolation, Settings, Verdict,
};

/// A formula that is ready to judge; use `corroborate.Formula`.
#[pyclass(module = "corroborate._engine", frozen)]
pub(crate) struct Formula {
    text: String,
    parsed: formula::Parsed,
    monitor: FormulaMonitor,
    /// The layout of the last call: mostly that of the next one, and dearer than judging a few samples.
    last: Mutex<Option<Arc<Bound>>>,
}

/// Signals as they were declared, and the atoms over them.
struct Bound {
    declared: Vec<Declared>,
    layout: Layout,
}

/// Least and greatest robustness.
type Bounds = Option<(f64, f64)>;
/// An atom, its truth, from and until when, and the signals that it reads.
type Responsible = (String, bool, f64, f64, Vec<String>);
/// Verdict, robustness, times triggered (none without a trigger), samples, when it was decided, and why it is violated.
type Found = (
    &'static str,
    Bounds,
    Option<u64>,
    u64,
    Option<f64>,
    Option<(f64, f64, Vec<Responsible>)>,
    // What the trace ends before, and what was left out, in words.
    Option<String>,
    Option<String>,
);

#[pymethods]
impl Formula {
    /// Reads and compiles a formula; `parameters` are in seconds.
    #[new]
    fn new(
        text: String,
        parameters: HashMap<String, f64>,
        time: &str,
        interpolation: &str,
        ending: &str,
    ) -> PyResult<Self> {
        let settings = Settings {
            interpolation: self::interpolation(interpolation)?,
            ..match time {
                "discrete" => Settings::discrete(self::ending(ending)?),
                "dense" => Settings::dense(self::ending(ending)?),
                other => return Err(unknown("time", other, "discrete, dense")),
            }
        };
        guarded(|| {
            let parsed = formula::parse(&text, &|name| parameters.get(name).copied());
            let parsed = parsed.map_err(|error| {
                let source = Source::new(FORMULA, &error.text);
                let problem = Problem::new("bad-formula", error.message);
                raised(problem.at(&source, error.span).remedy(error.remedy))
            })?;
            let settings = settings.with_robustness();
            let monitor = FormulaMonitor::compile(&parsed.formula, &settings);
            let monitor = monitor.map_err(|error| {
                let problem = Problem::new("bad-formula", error.to_string());
                raised(problem.at(&Source::new(FORMULA, &text), 0..text.len()))
            })?;
            Ok(Self {
                text,
                parsed,
                monitor,
                last: Mutex::new(None),
            })
        })
    }

    /// The formula with the values of its parameters.
    #[getter]
    fn written_out(&self) -> String {
        self.parsed.to_string()
    }

    /// The texts of its atoms.
    #[getter]
    fn atoms(&self) -> Vec<&str> {
        let atoms = self.parsed.atoms.iter();
        atoms.map(|atom| atom.text.as_str()).collect()
    }

    /// Judges columns, which are not copied.
    fn judge(
        &self,
        py: Python<'_>,
        times: PyReadonlyArray1<'_, f64>,
        declared: Vec<Declared>,
        columns: Vec<Column<'_>>,
        complete: bool,
    ) -> PyResult<Found> {
        let rows = times.len();
        if let Some(place) = columns.iter().position(|column| column.len() != rows) {
            let (name, found) = (&declared[place].0, columns[place].len());
            let message = format!("`{name}` has {found} values and there are {rows} times");
            return Err(raised_input(
                "bad-signals",
                message,
                "give each time one value, NaN where it is missing",
            ));
        }
        let bound = guarded(|| self.bound(declared))?;
        let layout = &bound.layout;
        let times = times.as_array();
        let row = Row::new(layout, &columns);
        let report =
            py.detach(|| guarded(|| judged(&self.monitor, times.iter().copied(), row, complete)))?;
        Ok(self.found(layout, report))
    }

    /// Begins to judge a stream of these signals.
    fn start(&self, declared: Vec<Declared>) -> PyResult<Monitor> {
        guarded(|| {
            let layout = Layout::new(&self.text, &self.parsed, &declared)?;
            let atoms = self.parsed.atoms.iter();
            Ok(Monitor {
                room: layout.room(),
                judge: Some(self.monitor.start()),
                atoms: atoms
                    .map(|atom| atom.text.clone())
                    .collect::<Vec<_>>()
                    .into(),
                layout,
            })
        })
    }
}

fn judged(
    monitor: &FormulaMonitor,
    times: impl Iterator<Item = f64>,
    mut row: Row<'_>,
    complete: bool,
) -> PyResult<FormulaReport> {
    let mut judge = monitor.start();
    let mut room = row.room();
    for (at, time_secs) in times.enumerate() {
        row.row = at;
        row.judge(&mut room);
        let taken = judge.step_both(time_secs, &room.truth, &room.robustness);
        taken.map_err(|error| bad_time(&error))?;
    }
    Ok(judge.finish(complete))
}

fn bad_time(error: &formula::StepError) -> PyErr {
    raised_input(
        "bad-signals",
        error,
        "put the samples in order of time, each time once",
    )
}

impl Formula {
    /// The atoms over these signals.
    fn bound(&self, declared: Vec<Declared>) -> PyResult<Arc<Bound>> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bound) = last.as_ref().filter(|it| it.declared == declared) {
            return Ok(bound.clone());
        }
        let layout = Layout::new(&self.text, &self.parsed, &declared)?;
        let bound = Arc::new(Bound { declared, layout });
        *last = Some(bound.clone());
        Ok(bound)
    }

    fn found(&self, layout: &Layout, report: FormulaReport) -> Found {
        let atoms: Vec<&str> = self.atoms();
        found(&atoms, layout, report)
    }
}

fn found<T: AsRef<str>>(atoms: &[T], layout: &Layout, report: FormulaReport) -> Found {
    let explanation = report.explanation.map(|found| {
        let responsible = found.atoms.into_iter().map(|part| {
            let (text, reads) = (&atoms[part.atom.0], layout.reads(part.atom.0));
            let text = text.as_ref().to_owned();
            (
                text,
                part.value,
                part.from_secs,
                part.to_secs,
                reads.to_vec(),
            )
        });
        (found.from_secs, found.to_secs, responsible.collect())
    });
    (
        verdict(report.verdict),
        report.robustness.map(|bounds| (bounds.low, bounds.high)),
        report.has_trigger.then_some(report.triggered),
        report.samples,
        report.decided_at_secs,
        explanation,
        report.ends_before.map(|it| it.to_string()),
        report.left_out.map(|it| it.to_string()),
    )
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NotCovered => "not-covered",
        Verdict::Satisfied => "satisfied",
        Verdict::Violated => "violated",
        Verdict::Inconclusive => "inconclusive",
    }
}

/// A stream that is being judged; use `corroborate.Monitor`.
#[pyclass(module = "corroborate._engine")]
pub(crate) struct Monitor {
    layout: Layout,
    /// `None` once it has ended.
    judge: Option<FormulaJudge>,
    atoms: Arc<[String]>,
    room: Judged,
}

#[pymethods]
impl Monitor {
    /// Takes a sample: the value of each declared signal, in their order. Gives the verdict once it is determined.
    fn step(&mut self, time_secs: f64, values: Vec<f64>) -> PyResult<Option<&'static str>> {
        guarded(|| {
            let held = Held {
                layout: &self.layout,
                values: &values,
            };
            self.layout.judge(&held, &mut self.room);
            let judge = self.judge.as_mut().ok_or_else(ended)?;
            let taken = judge.step_both(time_secs, &self.room.truth, &self.room.robustness);
            Ok(taken
                .map_err(|error| bad_time(&error))?
                .verdict
                .map(verdict))
        })
    }

    /// The least and the greatest robustness that can still come out.
    fn robustness(&self) -> PyResult<Bounds> {
        guarded(|| {
            let judge = self.judge.as_ref().ok_or_else(ended)?;
            Ok(judge
                .robustness_bounds()
                .map(|bounds| (bounds.low, bounds.high)))
        })
    }

    /// How many values, stretches and times are stored.
    fn stored(&self) -> usize {
        self.judge.as_ref().map_or(0, FormulaJudge::stored)
    }

    /// Ends the stream.
    fn finish(&mut self, complete: bool) -> PyResult<Found> {
        guarded(|| {
            let judge = self.judge.take().ok_or_else(ended)?;
            Ok(found(&self.atoms, &self.layout, judge.finish(complete)))
        })
    }
}

fn ended() -> PyErr {
    raised_input(
        "bad-signals",
        "the stream was ended by `finish`",
        "start another monitor",
    )
}

fn interpolation(name: &str) -> PyResult<Interpolation> {
    match name {
        "hold" => Ok(Interpolation::Hold),
        "linear" => Ok(Interpolation::Linear),
        other => Err(unknown("interpolation", other, "hold, linear")),
    }
}

fn ending(name: &str) -> PyResult<Ending> {
    match name {
        "inconclusive" => Ok(Ending::Inconclusive),
        "weak" => Ok(Ending::Weak),
        "strong" => Ok(Ending::Strong),
        "finite" => Ok(Ending::Finite),
        "long_enough" => Ok(Ending::LongEnough),
        other => Err(unknown(
            "ending",
            other,
            "long_enough, finite, inconclusive, weak, strong",
        )),
    }
}

fn unknown(setting: &str, given: &str, known: &str) -> PyErr {
    let message = format!("`{setting}` cannot be `{given}`");
    raised_input("bad-setting", message, &format!("it can be {known}"))
}
