//! Studies: opened, planned, run, compared, packed, replayed; their evidence and comparisons as tables.

use crate::problem::{guarded, raised};
use crate::table::{Column, Table};
use crate::work::carried_out;
use corroborate::{
    CompareRequest, Ended, MergeRequest, PackRequest, ReplayRequest, RunReport, RunRequest,
    ShardRequest, Study, results::results_folder,
};
use evidence::{Evidence, Finding, Guarantee, Measure, StudyResult, Subject};
use host::Host;
use pyo3::prelude::*;
use pythonize::pythonize;
use serde::Serialize;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

/// What the package knows of its surroundings.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Surroundings {
    physics_library: Option<PathBuf>,
    python_path: Option<OsString>,
    scratch: PathBuf,
    /// Whether the caller has said that programs of its study may run.
    trust: bool,
}

impl Surroundings {
    fn host(self) -> Host {
        Host {
            physics_library: self.physics_library,
            python_path: self.python_path,
            scratch: self.scratch,
            trust: cli::trust(self.trust),
            ..Host::silent(corroborate::build())
        }
    }
}

/// Which study, and where its results are.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked {
    folder: PathBuf,
    out: Option<PathBuf>,
    only: Vec<String>,
}

impl Asked {
    fn request(&self) -> RunRequest {
        RunRequest {
            out: self.out.clone(),
            only: self.only.clone(),
            ..RunRequest::new(&self.folder)
        }
    }
}

/// What a study asks.
#[derive(Serialize)]
struct Opened<'a> {
    title: &'a str,
    requirements: &'a [evidence::Requirement],
    failure_modes: &'a [evidence::FailureMode],
    evidence: Vec<&'a str>,
}

/// Loads a study: what it asks, as a dictionary.
#[pyfunction]
pub(crate) fn study_open(
    py: Python<'_>,
    folder: PathBuf,
    surroundings: Surroundings,
) -> PyResult<Py<PyAny>> {
    let trust = surroundings.host().trust;
    let study = py.detach(|| guarded(|| Study::load_for(&folder, &trust).map_err(raised)))?;
    let opened = Opened {
        title: &study.about.title,
        requirements: &study.requirements,
        failure_modes: &study.failure_modes,
        evidence: study.ledger.iter().map(|entry| entry.id.as_str()).collect(),
    };
    Ok(pythonize(py, &opened)?.unbind())
}

/// What a run would do, as a dictionary.
#[pyfunction]
pub(crate) fn study_plan(
    py: Python<'_>,
    asked: Asked,
    surroundings: Surroundings,
) -> PyResult<Py<PyAny>> {
    let request = asked.request();
    let plan = carried_out(py, surroundings.host(), None, |host| {
        corroborate::plan(&request, host)
    })?;
    Ok(pythonize(py, &plan)?.unbind())
}

/// Runs a study and writes its page; with `only` pieces of evidence, a list of dictionaries.
#[pyfunction]
pub(crate) fn study_run(
    py: Python<'_>,
    asked: Asked,
    surroundings: Surroundings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let request = asked.request();
    let report = carried_out(py, surroundings.host(), progress, |host| {
        corroborate::run_with_page(&request, host, &report::html)
    })?;
    match report {
        RunReport::Only(pieces) => Ok(pythonize(py, &pieces)?.unbind()),
        RunReport::Study(result) => {
            let result = StudyOutcome(Arc::from(result));
            Ok(Bound::new(py, result)?.into_any().unbind())
        }
    }
}

/// Runs a shard of a study's episodes: its report as a dictionary.
#[pyfunction]
pub(crate) fn study_shard(
    py: Python<'_>,
    asked: Asked,
    shard: (u64, u64),
    out: PathBuf,
    surroundings: Surroundings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let request = ShardRequest {
        only: asked.only,
        ..ShardRequest::new(asked.folder, shard, out)
    };
    let report = carried_out(py, surroundings.host(), progress, |host| {
        corroborate::shard(&request, host)
    })?;
    Ok(pythonize(py, &report)?.unbind())
}

/// Takes over the episodes of shards: the report of `corroborate merge --format json` as a dictionary.
#[pyfunction]
pub(crate) fn study_merge(
    py: Python<'_>,
    asked: Asked,
    shards: Vec<PathBuf>,
    surroundings: Surroundings,
) -> PyResult<Py<PyAny>> {
    let request = MergeRequest {
        out: asked.out,
        ..MergeRequest::new(asked.folder, shards)
    };
    let report = carried_out(py, surroundings.host(), None, |host| {
        corroborate::merge(&request, host)
    })?;
    Ok(pythonize(py, &report)?.unbind())
}

/// The result of the last run, if it is of the files that the study has now.
#[pyfunction]
pub(crate) fn study_result(py: Python<'_>, asked: Asked) -> PyResult<StudyOutcome> {
    let results = results_folder(&asked.folder, asked.out.as_deref());
    let result = py.detach(|| {
        guarded(|| {
            let found = corroborate::results::read_current_result(&asked.folder, &results);
            found.map_err(raised)
        })
    })?;
    Ok(StudyOutcome(Arc::new(result)))
}

/// The comparisons of the last run: all, or those of some evidence.
#[pyfunction]
pub(crate) fn study_compare(py: Python<'_>, asked: Asked) -> PyResult<Py<PyAny>> {
    let request = CompareRequest {
        study: asked.folder,
        out: asked.out,
        evidence: asked.only,
    };
    let report = py.detach(|| guarded(|| corroborate::compare(&request).map_err(raised)))?;
    Ok(pythonize(py, &report)?.unbind())
}

/// Runs an episode again: the report of `corroborate replay --format json` as a dictionary.
#[pyfunction]
pub(crate) fn study_replay(
    py: Python<'_>,
    asked: Asked,
    episode: String,
    surroundings: Surroundings,
) -> PyResult<Py<PyAny>> {
    let request = ReplayRequest {
        only: asked.only,
        out: asked.out,
        ..ReplayRequest::new(asked.folder, episode)
    };
    let report = carried_out(py, surroundings.host(), None, |host| {
        corroborate::replay::replay_with_page(&request, host, &report::replay::html)
    })?;
    Ok(pythonize(py, &report)?.unbind())
}

/// What is asked of a pack.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct AskedOfPack {
    to: Option<PathBuf>,
    key: Option<PathBuf>,
    sboms: Vec<PathBuf>,
    pdf: Option<PathBuf>,
    with_recordings: bool,
}

/// Packs a study that has been run, as the command does; the report, as a dictionary.
#[pyfunction]
pub(crate) fn study_pack(
    py: Python<'_>,
    asked: Asked,
    pack: AskedOfPack,
    surroundings: Surroundings,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let request = PackRequest {
        out: asked.out,
        to: pack.to,
        key: pack.key,
        sboms: pack.sboms,
        pdf: pack.pdf,
        with_recordings: pack.with_recordings,
        ..PackRequest::new(asked.folder)
    };
    let report = carried_out(py, surroundings.host(), progress, |host| {
        cli::pack(&request, host)
    })?;
    Ok(pythonize(py, &report)?.unbind())
}

/// What a study amounts to; use `corroborate.StudyResult`.
#[pyclass(module = "corroborate._engine", frozen)]
pub(crate) struct StudyOutcome(Arc<StudyResult>);

#[pymethods]
impl StudyOutcome {
    /// All of it, as `study.json` has it.
    fn data(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        Ok(pythonize(py, &*self.0)?.unbind())
    }

    /// The exit code of `corroborate run`.
    #[getter]
    fn exit_code(&self) -> u8 {
        self.0.outcome().exit_code()
    }

    /// The summary, as `corroborate run` prints it.
    fn text(&self, width: usize) -> PyResult<String> {
        guarded(|| Ok(report::text(&self.0, width, false)))
    }

    /// The page.
    fn html(&self) -> PyResult<String> {
        guarded(|| Ok(report::html(&self.0)))
    }

    /// One row for each piece of evidence and each subject of it.
    fn evidence(&self) -> PyResult<Table> {
        guarded(|| Ok(evidence_table(&self.0)))
    }

    /// One row for each pair on each subject.
    fn comparisons(&self) -> PyResult<Table> {
        guarded(|| Ok(comparisons_table(&self.0)))
    }
}

/// The word by which something is serialised.
fn word(value: &impl Serialize) -> Option<String> {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => Some(word),
        _ => None,
    }
}

fn evidence_table(result: &StudyResult) -> Table {
    let pieces = result.evidence.iter();
    let rows = pieces.flat_map(|piece| piece.findings.iter().map(move |finding| (piece, finding)));
    let rows: Vec<(&Evidence, &Finding)> = rows.collect();
    let texts = |name: &str, of: &dyn Fn(&Evidence, &Finding) -> Option<String>| {
        Column::texts(name, rows.iter().map(|(piece, finding)| of(piece, finding)))
    };
    let numbers = |name: &str, of: &dyn Fn(&Measure) -> Option<f64>| {
        let values: Vec<_> = rows
            .iter()
            .map(|(_, finding)| of(&finding.measure))
            .collect();
        Column::numbers(name, &values)
    };
    let counts = rows.iter().map(|(_, finding)| counted(&finding.measure));
    let counts: Vec<Option<[u64; 2]>> = counts.collect();
    let count = |place: usize| counts.iter().map(move |it| it.map(|it| it[place]));
    Table::new(vec![
        texts("evidence", &|piece, _| Some(piece.id.clone())),
        texts("title", &|piece, _| Some(piece.title.clone())),
        texts("technique", &|piece, _| word(&piece.technique)),
        texts("kind", &|_, finding| {
            Some(kind(&finding.subject).to_owned())
        }),
        texts("subject", &|_, finding| {
            Some(finding.subject.id().to_owned())
        }),
        Column::wholes("count", &count(0).collect::<Vec<_>>()),
        Column::wholes("trials", &count(1).collect::<Vec<_>>()),
        numbers("effective_trials", &|measure| effective(measure)),
        numbers("estimate", &Measure::estimate),
        numbers("low", &|measure| Some(measure.interval()?.low)),
        numbers("high", &|measure| Some(measure.interval()?.high)),
        texts("guarantee", &|_, finding| {
            guarantee(&finding.measure).map(str::to_owned)
        }),
        texts("reason", &|_, finding| why_none(&finding.measure)),
    ])
}

fn kind(subject: &Subject) -> &'static str {
    match subject {
        Subject::Requirement(_) => "requirement",
        Subject::FailureMode(_) => "failure-mode",
    }
}

fn counted(measure: &Measure) -> Option<[u64; 2]> {
    match measure {
        Measure::Counts { count, trials, .. } => Some([*count, *trials]),
        Measure::Probability { .. }
        | Measure::NotExpressible { .. }
        | Measure::NotCovered { .. } => None,
    }
}

fn effective(measure: &Measure) -> Option<f64> {
    let (_, worth) = measure.at_its_worth()?;
    Some(worth.trials)
}

fn guarantee(measure: &Measure) -> Option<&'static str> {
    match measure {
        Measure::Counts { .. } => Some("statistical"),
        Measure::NotExpressible { .. } | Measure::NotCovered { .. } => None,
        Measure::Probability { answer, .. } => Some(match &answer.guarantee {
            Guarantee::Exact { .. } => "exact",
            Guarantee::Bounded { .. } => "bounded",
            Guarantee::Schedulers { .. } => "schedulers",
            Guarantee::Statistical { .. } => "statistical",
            Guarantee::Estimated { .. } => "estimated",
        }),
    }
}

fn why_none(measure: &Measure) -> Option<String> {
    match measure {
        Measure::Counts { .. } | Measure::Probability { .. } => None,
        Measure::NotExpressible { reason } | Measure::NotCovered { reason, .. } => {
            Some(reason.clone())
        }
    }
}

fn comparisons_table(result: &StudyResult) -> Table {
    let all = &result.comparisons;
    let texts = |name: &str, of: &dyn Fn(&evidence::Comparison) -> Option<String>| {
        Column::texts(name, all.iter().map(of))
    };
    let numbers = |name: &str, of: &dyn Fn(&evidence::Comparison) -> Option<f64>| {
        Column::numbers(name, &all.iter().map(of).collect::<Vec<_>>())
    };
    let independent: Vec<_> = all.iter().map(|it| Some(it.independent)).collect();
    Table::new(vec![
        texts("kind", &|it| Some(kind(&it.subject).to_owned())),
        texts("subject", &|it| Some(it.subject.id().to_owned())),
        texts("left", &|it| Some(it.left.clone())),
        texts("right", &|it| Some(it.right.clone())),
        texts("outcome", &|it| word(&it.outcome)),
        Column::truths("independent", &independent),
        numbers("difference", &|it| it.difference),
        numbers("low", &|it| Some(it.difference_interval.as_ref()?.low)),
        numbers("high", &|it| Some(it.difference_interval.as_ref()?.high)),
        numbers("margin", &|it| Some(it.margin)),
        numbers("p_difference", &|it| it.p_difference),
        numbers("p_difference_corrected", &|it| it.p_difference_corrected),
        numbers("p_equivalence", &|it| it.p_equivalence),
        texts("reason", &|it| Some(it.reason.clone())),
    ])
}
