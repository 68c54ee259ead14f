//! Arguments of `diagnose`.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `diagnose`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate diagnose case-studies/handover
  corroborate diagnose my-study --half-step 20 --engines 20
  corroborate diagnose case-studies/handover --show E1:17

Finds which asset causes the disagreements in a study that has been run,
by changing one asset at a time: properties and monitors on paths sampled from
the formal models, on the episodes and on the recordings; computed answers
against sampled ones; on request half the time step and the other engine.
Prints the matrix and a ranked list of suspects, and adds both to the results'
study.json and report.html. With --show prints one sampled path instead.
Exits 1 if there is a suspect with a score of 1 or more that no later evidence
has fixed.")]
pub struct Diagnose {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Where the results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many paths to sample from each formal model.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub paths: u64,
    /// Run N episodes of each simulation again with half the time step.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub half_step: Option<u64>,
    /// Run N episodes of each scene in the other physics engine, too.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub engines: Option<u64>,
    /// How many recordings of each simulation to read for steps that the models do not have, evenly from all.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub runs: u64,
    /// Print the path with this number that is sampled from the model of this
    /// evidence, and nothing else.
    #[arg(long, value_name = "EVIDENCE:PATH")]
    pub show: Option<String>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
