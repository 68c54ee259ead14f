//! Arguments of `trust`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `trust`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate trust their-study --show          every program that it names, with its file and line
  corroborate trust their-study                 ... and allow it as it is now; what changes is asked anew
  corroborate trust my-study --always           one's own, whatever it will contain
  corroborate trust --list                      which studies are allowed
  corroborate trust their-study --revoke        take it back

A study's programs (commands of its ledger, controllers of its scenes) run as you: they can do what
you can. Nothing else of a study asks: models, the handover, tables, recordings, reports.
`corroborate run their-study --trust` allows them for one call; CORROBORATE_TRUST names folders,
separated by colons, whose studies are allowed: for continuous integration.")]
pub struct Trust {
    /// The study's folder.
    #[arg(required_unless_present = "list")]
    pub study: Option<PathBuf>,
    /// Only show what would run.
    #[arg(long, conflicts_with_all = ["always", "revoke", "list"])]
    pub show: bool,
    /// Allow it whatever its folder will contain.
    #[arg(long, conflicts_with_all = ["revoke", "list"])]
    pub always: bool,
    /// Take back that it is allowed.
    #[arg(long, conflicts_with = "list")]
    pub revoke: bool,
    /// Show which studies are allowed.
    #[arg(long, conflicts_with = "study")]
    pub list: bool,
}
