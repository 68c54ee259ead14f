//! Recordings of any format, judged by formulas or by the monitors of a study.

use crate::problem::raised_input;
use crate::work::carried_out;
use host::Host;
use judging::{MonitorRequest, Monitored, monitor};
use pyo3::prelude::*;
use pythonize::pythonize;
use std::path::PathBuf;
use temporal::formula::{Ending, TimeModel};

/// What is asked of recordings, as the package gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked {
    recordings: Vec<PathBuf>,
    /// The folder of a study; else formulas are judged.
    study: Option<PathBuf>,
    only: Vec<String>,
    formulas: Vec<String>,
    ending: String,
    time: String,
    map: Option<PathBuf>,
    partial: bool,
}

/// Judges recordings: the report of `corroborate monitor --format json` as a dictionary.
#[pyfunction]
pub(crate) fn monitor_recordings(
    py: Python<'_>,
    asked: Asked,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let mut request = MonitorRequest::new(monitored(&asked)?);
    request.recordings = asked.recordings;
    request.map = asked.map;
    request.partial = asked.partial;
    let host = Host::silent(corroborate::build());
    let report = carried_out(py, host, progress, |host| monitor(&request, host))?;
    Ok(pythonize(py, &report)?.unbind())
}

fn monitored(asked: &Asked) -> PyResult<Monitored> {
    if let Some(folder) = &asked.study {
        let (folder, only) = (folder.clone(), asked.only.clone());
        return Ok(Monitored::Study { folder, only });
    }
    let unknown = |setting: &str, given: &str| {
        let message = format!("`{setting}` cannot be `{given}` for recordings");
        raised_input("bad-setting", message, "see the documentation of `Formula`")
    };
    Ok(Monitored::Formulas {
        texts: asked.formulas.clone(),
        ending: match asked.ending.as_str() {
            "long_enough" => Ending::LongEnough,
            "finite" => Ending::Finite,
            "inconclusive" => Ending::Inconclusive,
            "weak" => Ending::Weak,
            "strong" => Ending::Strong,
            other => return Err(unknown("ending", other)),
        },
        time: match asked.time.as_str() {
            "discrete" => TimeModel::Discrete,
            "dense" => TimeModel::Dense,
            other => return Err(unknown("time", other)),
        },
        start_within_secs: study::START_WITHIN_SECS,
    })
}
