//! What the user of this machine has allowed of the programs that studies name.
//!
//! A face fills it in: a library reads neither the environment nor a home. What it means is decided in the crate `rig`, which
//! alone starts programs.

use std::path::PathBuf;

/// What is allowed. By default nothing is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trust {
    /// Whether the user has said for this call that programs of its study may run.
    pub is_given: bool,
    /// Folders of the user: programs of studies in and below them may run.
    pub folders: Vec<PathBuf>,
    /// Folders in which studies may read, beside their own; their programs may not run for that.
    pub readable: Vec<PathBuf>,
    /// The folder that keeps which studies were allowed; `None` if there is no place for it.
    pub records: Option<PathBuf>,
}
