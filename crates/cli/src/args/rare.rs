//! Arguments of `rare` and `calibrate`.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `rare`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate rare case-studies/handover case-studies/handover/rare.toml
  corroborate rare my-study my-study/rare.toml --only 'five in a row' --format json

FILE names a scenario, its parameters, and events: a score over signals with a
limit, or a requirement that is violated. Each event's probability in an episode is estimated by splitting (runs
that come near it are saved and continued with other random draws) or by
subsets of the inputs. Replications give the interval; where `plain` asks for
it, plain episodes are counted beside it, and exit code 1 says that the two
contradict each other (3: an event was never reached). Interrupted, it goes on where it stopped.")]
pub struct Rare {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The file of events.
    pub file: PathBuf,
    /// Only the event with this name (may be repeated).
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Where finished parts are kept, instead of STUDY/results/rare.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the estimates are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate calibrate case-studies/handover case-studies/handover/calibration.toml
  corroborate calibrate my-study my-study/calibration.toml --to tuned.toml --format json

FILE names a scenario, the parameters to begin with, what is to be fitted within
which range, and the evidence whose counts are to be reproduced, some of them
held out. Episodes at many parameters give the posterior, in the fast physics
where there is one (`physics` in FILE); the fitted set is then run in the full
physics, and its counts are compared with the evidence's. Exits 0 if what was held
out is shown to be within its margin, 1 if anything differs or contradicts its
prediction, and 3 if neither is shown. Interrupted, it goes on where it stopped.")]
pub struct Calibrate {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The calibration's file.
    pub file: PathBuf,
    /// Write the fitted parameter set to this file.
    #[arg(long, value_name = "FILE")]
    pub to: Option<PathBuf>,
    /// Where finished parts are kept, instead of STUDY/results/calibration.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the report is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
