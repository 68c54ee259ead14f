//! Arguments of `explore`.

use super::{Format, study_folder};
use clap::Args;
use corroborate::technique::exploration::SourceKind;
use std::path::PathBuf;

/// Arguments of `explore`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate explore case-studies/handover exploration.toml --out /tmp/explored
  corroborate explore my-study exploration.toml --source random --source mutation
  corroborate explore my-study exploration.toml --episodes 500 --format json
  corroborate explore my-study exploration.toml --causes 200
  corroborate explore my-study exploration.toml --plain      by way of comparison
  corroborate explore my-study exploration.toml --disagreement

Tests come from the formal model, from chance within rules, from agents, from
mutation, from search, and with the faults injected that the bench's own data
declare; sources that show new things are drawn more often. Each episode is judged by the study's monitors and
held against the formal model. What is found is a witness and no statistical
evidence: the episodes are chosen, not drawn. Violated requirements come first,
then failure modes, programs that fail, and steps unknown to the model; what
comes only after the task is over (`task_over` in FILE) comes last. Each finding
says what the recordings show then and hardly elsewhere: a rule over signals,
with its counts. Where the bench has a fast physics
the search runs in it (`physics` in FILE), and the full physics has to show what
is found; what it does not show is listed apart. FOLDER gets exploration.json and
findings/NAME.toml, one for each thing that was found, with stimulus and seed,
and a journal: a call that was interrupted goes on where it stopped. With
CORROBORATE_COVERAGE=FOLDER in the environment, controllers that use the client
for Python leave there which of their lines ran.
With --disagreement FOLDER gets disagreement.json: all declared contexts in
regions in which model and bench differ, agree within the margin, or are
undecided, at the study's confidence for all regions together.
Exits 1 if anything was found (or differs), whatever else was lost; otherwise 3 if
a region is undecided, an episode broke off or a finding was not
shown again.")]
pub struct Explore {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The file that says how to explore, relative to the study.
    pub file: PathBuf,
    /// Episodes, at most, instead of the file's budget.
    #[arg(long, short = 'n', value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub episodes: Option<u64>,
    /// Only this source of tests (may be repeated).
    #[arg(long, value_parser = super::choice::<SourceKind>(), value_name = "SOURCE", conflicts_with = "plain")]
    pub source: Vec<SourceKind>,
    /// Run the bench's own tests as they are, in turn, with nothing varied but
    /// their random draws: what an exploration is to be compared with.
    #[arg(long)]
    pub plain: bool,
    /// Seed instead of the study's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Look for contexts in which model and bench differ, instead of
    /// exploring: a map of regions, each decided by fresh episodes.
    #[arg(long, conflicts_with_all = ["plain", "source"])]
    pub disagreement: bool,
    /// Shrink the episodes of each finding, in at most N episodes, and group
    /// them by cause: the settings and actions that are left.
    #[arg(long, value_name = "N", conflicts_with = "disagreement", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub causes: Option<u64>,
    /// Where results go instead of STUDY/results/exploration.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
