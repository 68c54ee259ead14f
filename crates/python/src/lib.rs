#![doc = include_str!("../README.md")]
//!
//! The functions here are thin: they take numbers, texts and arrays, call the library, and give numbers, dictionaries and
//! arrays. What a user sees, with its documentation and its checks of types, is the package in `python/corroborate/`.
//!
//! | file | holds |
//! |---|---|
//! | `problem.rs` | how a problem, and a panic, becomes an exception |
//! | `words.rs` | what a remedy says to a caller of Python |
//! | `work.rs` | long work: without the interpreter's lock, ended by Ctrl-C, with events for a callback |
//! | `numbers.rs` | statistics |
//! | `formulas.rs`, `signals.rs` | formulas over arrays, read in place, and over streams |
//! | `recordings.rs` | recordings judged |
//! | `studies.rs` | studies run, compared, packed, replayed |
//! | `table.rs`, `table/arrow.rs` | tables whose memory others take over, by Arrow's interface |
//! | `models.rs`, `space.rs` | models checked; their states as arrays |

mod formulas;
mod models;
mod numbers;
mod problem;
mod recordings;
mod signals;
mod space;
mod studies;
mod table;
mod words;
mod work;

use pyo3::prelude::*;

/// The native half of the package `corroborate`; use the package.
#[pymodule]
mod _engine {
    use super::*;

    #[pymodule_export]
    use super::formulas::{Formula, Monitor};
    #[pymodule_export]
    use super::models::Model;
    #[pymodule_export]
    use super::numbers::statistics;
    #[pymodule_export]
    use super::space::StateSpace;

    #[pymodule_export]
    use super::recordings::monitor_recordings;

    #[pymodule_export]
    use super::studies::{
        StudyOutcome, study_compare, study_merge, study_open, study_pack, study_plan, study_replay,
        study_result, study_run, study_shard,
    };
    #[pymodule_export]
    use super::table::Table;

    /// Which build of the engine this is: the same for the same sources.
    #[pyfunction]
    fn build() -> String {
        corroborate::build().as_str().to_owned()
    }

    /// The version of the package, which is that of the command.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }

    /// Carries out the command `corroborate` with these arguments, the program's name first; gives the exit code.
    #[pyfunction]
    fn command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
        py.detach(|| crate::problem::guarded(|| Ok(cli::run(arguments))))
    }

    /// Panics on purpose, for the test of what becomes of a mistake of ours.
    #[pyfunction]
    fn _panic() -> PyResult<()> {
        crate::problem::guarded(|| panic!("asked for"))
    }
}
