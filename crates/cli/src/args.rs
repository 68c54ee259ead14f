//! The command line, as plain data.

mod assurance;
mod check;
mod decide;
mod diagnose;
mod diff;
#[cfg(test)]
mod documented;
mod engines;
mod explore;
mod format;
mod grouped;
mod language_server;
mod pack;
mod peers;
mod rare;
mod recordings;
#[cfg(test)]
mod reference;
mod refine;
pub mod refused;
mod replay;
mod shard;
mod shell;
mod simulate;
mod study_folder;
mod trust;
mod watch;

pub use assurance::{Assure, Verify};
pub use check::{Check, CheckFormat, Termination};
pub use decide::Decide;
pub use diagnose::Diagnose;
pub use diff::{Diff, DiffFormat, Written};
pub use engines::Engines;
pub use explore::Explore;
pub use format::FormatFiles;
pub use grouped::parsed;
pub use language_server::LanguageServer;
pub use pack::Pack;
pub use peers::with_peers_spelling;
pub use rare::{Calibrate, Rare};
pub use recordings::{
    EndingChoice, Exchange, Exchanged, Inspect, Monitor, Requirements, TakeChoice, TimeChoice,
};
pub use refine::{Refine, WhatIf};
pub use replay::{Replay, Shrink};
pub use shard::Merge;
pub use shell::{Completions, Doctor, Man};
pub use simulate::{RecordingForm, Simulate};
pub use trust::Trust;
pub use watch::Watch;

use study_folder::study_folder;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;
use study::Choice;

/// The longest time that an argument may name, which ends before clocks do: thirty years.
const LONGEST_SECS: f64 = 1e9;

/// A time above 0, as [`trace::duration`] reads it.
fn duration(text: &str) -> Result<Duration, String> {
    use trace::duration::{DurationError, seconds};
    let secs = seconds(text).ok();
    let secs = secs.filter(|secs| *secs > 0.0 && *secs <= LONGEST_SECS);
    secs.map(Duration::from_secs_f64)
        .ok_or_else(|| format!("must be a time above 0: {}", DurationError::REMEDY))
}

/// Reads one of the words of a choice that files of a study have, too.
fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let offered = T::CHOICES.iter();
    let offered = offered.map(|(_, word, meaning)| PossibleValue::new(*word).help(*meaning));
    PossibleValuesParser::new(offered).try_map(|read: String| {
        let chosen = T::CHOICES.iter().find(|(_, word, _)| *word == read);
        chosen.map(|(choice, ..)| *choice).ok_or("not offered")
    })
}

/// Corroborative verification and validation: model checking, simulation and
/// experiments on the same requirements, compared and explained.
#[derive(Debug, Parser)]
#[command(
    name = "corroborate",
    version,
    after_help = "\
Examples:
  corroborate run case-studies/handover         verify a study by all its techniques
  corroborate check model.prism 'P=? [ F x=3 ]' check one property of one model
  corroborate init my-study                     make a new study from a template
  corroborate explain conflicts                 what a word or a diagnostic means

Exit codes:
  0 all requirements satisfied, nothing conflicts   1 violated, or evidence conflicts
  2 error in the call or the input                  3 inconclusive, or data lost
  101 a bug of ours                                 130 interrupted"
)]
pub struct Arguments {
    /// Say nothing but the result.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Run the programs that the study names, this once (`corroborate trust STUDY` shows and allows them).
    #[arg(long, global = true)]
    pub trust: bool,
    /// Let the study read in this folder, too (may be repeated).
    #[arg(long, global = true, value_name = "FOLDER")]
    pub allow: Vec<PathBuf>,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Produce a study's evidence, compare it, and write the report.
    Run(Run),
    /// Take over the episodes that shards of a run simulated on other machines.
    Merge(Merge),
    /// Say what a run would do: which evidence is stale, and why.
    Plan(Plan),
    /// Check properties of a model in the PRISM language.
    Check(Box<Check>),
    /// Lay out models and property files anew; comments stay.
    Format(FormatFiles),
    /// Answer an editor: diagnostics, hover, definitions, rename, completion (Language Server Protocol over standard input and output).
    LanguageServer(LanguageServer),
    /// Run episodes of a study's simulation and record them.
    Simulate(Simulate),
    /// Look for unexpected behaviour: coverage-driven tests.
    Explore(Explore),
    /// Make a finding as small as it goes, and keep it as a regression.
    Shrink(Shrink),
    /// Run an episode again: recording, verdicts, 3D page; or all regressions.
    Replay(Replay),
    /// Run a scene or the handover in both physics engines, and say how far they differ.
    Engines(Engines),
    /// Estimate how rare an event is, by splitting.
    Rare(Rare),
    /// Fit simulator parameters to an evidence's counts.
    Calibrate(Calibrate),
    /// Offer changes of the assets where evidence disagrees, and make them.
    Refine(Refine),
    /// Try variants of the assets in every technique, side by side.
    WhatIf(WhatIf),
    /// Judge recordings with a study's monitors, or with a formula.
    Monitor(Monitor),
    /// Judge a running system, and record the run.
    Watch(Watch),
    /// Show what is in a recording, and draft its topic map; or in a robot's
    /// description.
    Inspect(Inspect),
    /// Show requirements in all their forms, and where the forms disagree.
    Requirements(Requirements),
    /// Repeat a flaky test until its rate of success is decided.
    Decide(Box<Decide>),
    /// Compare the pieces of evidence of a study that has been run.
    Compare(Compare),
    /// Say what changed between two results of a study: what is stale, what stands, which rates differ beyond chance.
    Diff(Diff),
    /// Find which asset causes the disagreements in a study.
    Diagnose(Diagnose),
    /// Write the report of a study that has been run.
    Report(Report),
    /// Write a study's assurance case, and its evidence as statements.
    Assure(Assure),
    /// Put what assessors ask for into one signed archive; or make the key that signs.
    Pack(Pack),
    /// Check that every figure of a result follows from its evidence, or every byte of an evidence pack.
    Verify(Verify),
    /// Make a new study: from a template, a robot's description, a recording or a behaviour tree.
    Init(Init),
    /// Show which programs a study would run, and allow them: until then they do not run.
    Trust(Trust),
    /// Show the keys of a study's files, or their JSON Schemas for an editor.
    Schema(SchemaOfFile),
    /// Explain a diagnostic, a verdict or a word of the report.
    Explain(Explain),
    /// Say what is present, what is missing, and what each missing thing disables.
    Doctor(Doctor),
    /// Print a shell's completion script.
    Completions(Completions),
    /// Print or write manual pages.
    Man(Man),
}

/// How a result is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs; the schemas are in `schemas/`.
    Json,
}

/// Arguments of `schema`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate schema                            which files there are
  corroborate schema scene.toml                 every key of a scene, with its type and meaning
  corroborate schema scene.toml --format json   the JSON Schema, for editors")]
pub struct SchemaOfFile {
    /// The kind of file, for example `scene.toml`; all kinds are listed without it.
    pub file: Option<String>,
    /// How it is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate run case-studies/handover
  corroborate run case-studies/handover --out /tmp/results
  corroborate run my-study --only E1 --only E5
  corroborate run my-study --shard 2/8 --out shard-2

Results go to STUDY/results: report.html, study.json, the evidence and the
recorded episodes. What is fresh is not produced again; an interrupted run
goes on where it stopped.")]
pub struct Run {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Where results go instead of STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Produce only this evidence (may be repeated); then nothing is compared.
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// Simulate the K-th of N parts of all episodes alone, into --out; `corroborate merge` puts the parts together.
    #[arg(long, value_name = "K/N", value_parser = shard::shard_of, requires = "out", conflicts_with_all = ["junit", "markdown", "sarif"])]
    pub shard: Option<(u64, u64)>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub written: Written,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate plan case-studies/handover
  corroborate plan my-study --only E1 --format json

The study is read and checked as for a run; nothing is produced or written.
Exits 0 whether or not evidence is stale.")]
pub struct Plan {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Where results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Plan only this evidence (may be repeated); then nothing is compared.
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// Also write mistakes in the study's files in SARIF.
    #[arg(long, value_name = "FILE")]
    pub sarif: Option<PathBuf>,
    /// How the plan is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate compare case-studies/handover
  corroborate compare case-studies/handover E3 E4
  corroborate compare case-studies/handover E3 E4 --format json

Exits 1 if a pair shown conflicts, 3 if one is inconclusive.")]
pub struct Compare {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Only pairs of this evidence (all if left out).
    pub evidence: Vec<String>,
    /// Where the results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How the comparisons are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate report case-studies/handover
  corroborate report case-studies/handover --to report.html")]
pub struct Report {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// The file to write, instead of STUDY/results/report.html.
    #[arg(long, value_name = "FILE")]
    pub to: Option<PathBuf>,
    /// Where the results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub written: Written,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `init`.
#[derive(Debug, Args)]
#[command(after_help = "\
Templates, each of which runs at once:
  docking      a formal model and a table of trials; the one without --template
  cobot        a small arm works beside a person who reaches into its cell; simulated
  mobile       a mobile robot drives to its goal past shelves and a person; simulated
  gripper      a gripper lifts a part and places it in a tray; simulated
  command      an outside simulator of a few lines, against a formal model and trials
  formal       a formal model, requirements in sentences, a table of trials
  recordings   recordings in CSV judged by monitors, and a table of trials
  policy       a learned policy evaluated from many seeds, with a success rate
Examples:
  corroborate init my-study && corroborate run my-study
  corroborate init my-cell --template cobot
  corroborate init my-robot --from robot.urdf
  corroborate init my-runs --from run.mcap
  corroborate init my-plan --from tree.xml --recordings runs")]
pub struct Init {
    /// The folder to make.
    pub folder: PathBuf,
    /// Which template it is made of; the list is below.
    #[arg(long, value_name = "NAME", conflicts_with = "from")]
    pub template: Option<String>,
    /// Draft it from a robot's description (URDF, SDF, MJCF), a recording (MCAP, a bag, CSV, JSON lines, ...) or a behaviour tree (XML of BehaviorTree.CPP) instead.
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Count how the behaviour tree's nodes ended: a recording with Nav2's `/behavior_tree_log`, a folder of them, or a CSV with the columns node and status.
    #[arg(long, value_name = "PATH", requires = "from")]
    pub recordings: Option<PathBuf>,
}

/// Arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate explain unknown-name     a diagnostic's code, as it is shown in brackets
  corroborate explain corroborates     an outcome or a verdict
  corroborate explain                  lists everything that can be explained")]
pub struct Explain {
    /// The code or word.
    pub topic: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn times_mean_the_same_in_all_arguments() {
        let parsed = |words: &str| Arguments::try_parse_from(words.split('|')).map(|it| it.command);
        let timeout =
            |time: &str| match parsed(&format!("corroborate|check|m.prism|--timeout|{time}")) {
                Ok(Command::Check(check)) => check.timeout,
                _ => None,
            };
        let limit =
            |time: &str| match parsed(&format!("corroborate|watch|study|--dds|0|--for|{time}")) {
                Ok(Command::Watch(watch)) => watch.limit,
                _ => None,
            };
        for time in ["300", "300s", "300 s", "5m", "5 min", "5minutes"] {
            let five_minutes = Some(Duration::from_secs(300));
            assert_eq!(
                (timeout(time), limit(time)),
                (five_minutes, five_minutes),
                "{time}"
            );
        }
        for bad in ["", "s", "-1 s", "0s", "0", "1e400 s", "1e10", "5 mm", "now"] {
            assert_eq!((timeout(bad), limit(bad)), (None, None), "{bad}");
        }
    }

    #[test]
    fn the_command_line_is_well_formed_and_every_command_has_examples() {
        Arguments::command().debug_assert();
        for command in Arguments::command().get_subcommands() {
            let help = command
                .get_after_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            assert!(
                help.contains("Example"),
                "{} shows no example",
                command.get_name()
            );
        }
    }
}
