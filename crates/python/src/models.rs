//! Models of the PRISM language (and explicit files): what they declare, checked, and built as a [`StateSpace`].

use crate::problem::{guarded, raised, raised_input};
use crate::space::StateSpace;
use crate::work::carried_out;
use diagnostic::{Problem, Source};
use host::{Event, Events, Host};
use prism_lang::ast;
use prism_lang::{Constants, Experiment};
use pyo3::prelude::*;
use pythonize::pythonize;
use query::{CheckRequest, Checked, ModelInput, PropertyInput};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use study::{Choice, Method};

/// Endings of files that list states and transitions.
const EXPLICIT: [&str; 3] = ["tra", "all", "drn"];

/// A model; use `corroborate.Model`.
#[pyclass(module = "corroborate._engine", frozen)]
pub(crate) struct Model {
    input: ModelInput,
    /// What it declares; nothing of an explicit file.
    tree: ast::Model,
}

/// What is asked of a model, as the package gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Asked {
    properties: Vec<String>,
    /// Each a file of properties.
    files: Vec<PathBuf>,
    constants: String,
    open: Option<String>,
    method: String,
    precision: f64,
    max_states: Option<u64>,
    timeout_secs: Option<f64>,
    witness: bool,
    certify: bool,
    fair: bool,
    scheduler: bool,
}

#[pymethods]
impl Model {
    /// Reads a text; `name` is what messages call it by.
    #[staticmethod]
    fn parse(text: String, name: String) -> PyResult<Self> {
        guarded(|| Self::of_source(Source::new(name, text)))
    }

    /// Reads a file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        guarded(|| {
            if is_explicit(&path) {
                let tree = prism_lang::parse_model("").tree;
                let input = ModelInput::File(path);
                return Ok(Self { input, tree });
            }
            let (source, _) = host::files::read_prism(&path).map_err(raised)?;
            Self::of_source(source)
        })
    }

    /// What messages call it by.
    #[getter]
    fn name(&self) -> String {
        self.input.name()
    }

    /// Its text; none of an explicit file.
    #[getter]
    fn text(&self) -> Option<&str> {
        match &self.input {
            ModelInput::Text(source) => Some(&source.text),
            ModelInput::File(_) => None,
        }
    }

    /// The keyword of its type, if it has one.
    #[getter]
    fn kind(&self) -> Option<&'static str> {
        self.tree.model_type.map(|(kind, _)| kind.keyword())
    }

    /// The constants that it declares, each with its type and the text of its value.
    #[getter]
    fn constants(&self) -> Vec<(&str, &'static str, Option<&str>)> {
        let text = self.text().unwrap_or_default();
        let all = self.tree.constants.iter();
        let written = |expr: &ast::Expr| text.get(expr.span.start..expr.span.end);
        let each = all.map(|it| {
            let value = it.value.as_ref().and_then(written);
            (it.name.text.as_str(), it.ty.keyword(), value)
        });
        each.collect()
    }

    #[getter]
    fn modules(&self) -> Vec<&str> {
        let all = self.tree.modules.iter();
        all.map(|module| module.name.text.as_str()).collect()
    }

    #[getter]
    fn labels(&self) -> Vec<&str> {
        let all = self.tree.labels.iter();
        all.map(|label| label.name.text.as_str()).collect()
    }

    /// The names of its reward structures; none of one without a name.
    #[getter]
    fn rewards(&self) -> Vec<Option<&str>> {
        let all = self.tree.rewards.iter();
        all.map(|it| it.name.as_ref().map(|name| name.text.as_str()))
            .collect()
    }

    /// Answers properties: the report of `corroborate check --format json` as a dictionary, and the scheduler as JSON.
    fn check<'py>(
        &self,
        py: Python<'py>,
        asked: Asked,
    ) -> PyResult<(Bound<'py, PyAny>, Option<String>)> {
        let request = self.request(&asked)?;
        let host = Host::silent(corroborate::build());
        let printed = Mutex::new(Vec::new());
        let (checked, problem) =
            carried_out(py, host, None, |host| answered(&request, host, &printed))?;
        if let Some(problem) = problem {
            return Err(raised(problem));
        }
        let report = pythonize(py, &checked.report)?;
        let printed = printed.into_inner().unwrap_or_else(PoisonError::into_inner);
        let scheduler = String::from_utf8(printed).ok().filter(|it| !it.is_empty());
        Ok((report, scheduler))
    }

    /// Builds the states.
    fn build(&self, py: Python<'_>, constants: &str, max_states: usize) -> PyResult<StateSpace> {
        let constants = Constants::parse(constants).map_err(bad_constants)?;
        let ModelInput::Text(source) = &self.input else {
            let message = "the states of an explicit file are the file itself";
            return Err(raised_input(
                "unsupported",
                message,
                "use `check`, or a model in the PRISM language",
            ));
        };
        let host = Host::silent(corroborate::build());
        carried_out(py, host, None, |host| {
            let resolved = prism_lang::resolve(&self.tree, &constants);
            let model = resolved.map_err(|found| {
                study::placed::from_diagnostics(source, &found).unwrap_or_else(|| {
                    Problem::new("cannot-resolve", "the model cannot be resolved")
                })
            })?;
            let cancel = || host.cancel.is_cancelled();
            let space = query::explore::<f64>(source, &model, max_states, &cancel)?;
            Ok(StateSpace::new(space, &model))
        })
    }
}

impl Model {
    fn of_source(source: Source) -> PyResult<Self> {
        let parsed = prism_lang::parse_model(&source.text);
        if let Some(problem) = study::placed::from_diagnostics(&source, &parsed.diagnostics) {
            return Err(raised(problem));
        }
        Ok(Self {
            input: ModelInput::Text(source),
            tree: parsed.tree,
        })
    }

    fn request(&self, asked: &Asked) -> PyResult<CheckRequest> {
        let mut request = CheckRequest::new(self.input.clone());
        let texts = asked.properties.iter().cloned().map(PropertyInput::Text);
        let files = asked.files.iter().cloned().map(PropertyInput::File);
        request.properties = texts.chain(files).collect();
        request.constants = Experiment::parse(&asked.constants).map_err(bad_constants)?;
        request.open = asked.open.clone();
        request.method = method(&asked.method)?;
        request.precision = asked.precision;
        request.max_states = asked.max_states;
        request.timeout = asked.timeout_secs.map(timeout).transpose()?;
        request.witness = asked.witness;
        request.certify = asked.certify;
        request.fair = asked.fair;
        // Printed here in place of a file.
        request.exports.strategy = asked.scheduler.then(|| "stdout:type=json".to_owned());
        Ok(request)
    }
}

fn is_explicit(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    ending.split(',').any(|form| EXPLICIT.contains(&form))
}

fn bad_constants(error: impl ToString) -> PyErr {
    raised_input(
        "bad-constants",
        error,
        "give each constant one value, for example {\"p\": 0.5}",
    )
}

fn timeout(secs: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(secs).map_err(|_| {
        let message = format!("`timeout` must be a number of seconds from 0 (got {secs})");
        raised_input("bad-setting", message, "give for example timeout=60")
    })
}

fn method(name: &str) -> PyResult<Method> {
    let found = Method::CHOICES.iter().find(|(_, word, _)| *word == name);
    found.map(|(method, ..)| *method).ok_or_else(|| {
        let words: Vec<&str> = Method::CHOICES.iter().map(|(_, word, _)| *word).collect();
        let message = format!("there is no method `{name}`");
        raised_input(
            "bad-setting",
            message,
            &format!("the methods are {}", words.join(", ")),
        )
    })
}

/// Answers, and the mistakes of properties, which the library tells as events.
fn answered(
    request: &CheckRequest,
    host: &Host,
    printed: &Mutex<Vec<u8>>,
) -> Result<(Checked, Option<Problem>), Problem> {
    let mistakes: Arc<Mutex<Vec<Problem>>> = Arc::default();
    let told = mistakes.clone();
    let events = Events::new(move |event| {
        if let Event::Mistake { problem } = event {
            told.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(problem);
        }
    });
    let host = Host {
        events,
        ..host.clone()
    };
    let mut checked = query::check(request, &host, &|bytes| {
        let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
        printed.extend_from_slice(bytes);
        Ok(())
    })?;
    host.go_on()?;
    let mistakes = std::mem::take(&mut *mistakes.lock().unwrap_or_else(PoisonError::into_inner));
    // What was reached before a limit is an answer, too.
    let is_partial = checked.report.is_built() && !checked.report.is_finished();
    let of_work = checked.problem.take().filter(|_| !is_partial);
    Ok((checked, Problem::all(mistakes).or(of_work)))
}
