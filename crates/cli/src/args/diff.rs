//! Arguments of `diff`, and the files that several commands write beside what they print.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// How a difference is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum DiffFormat {
    /// For people.
    #[default]
    Text,
    /// For programs; the schema is `schemas/diff.schema.json`.
    Json,
    /// For comments on a change.
    Markdown,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate diff old/results new/results
  corroborate diff main/study.json my-study --format markdown

Says which evidence an edit made stale and which stands, which verdicts changed,
which rates of evidence that was produced again changed beyond chance (at the
study's confidence, with Holm's correction for all of them), and what it cost.
Either is a folder of results, a study that has been run, or the file study.json.
Exits 1 if a verdict got worse, or a rate did beyond chance and by more than the
study's margin.")]
pub struct Diff {
    /// The earlier result.
    pub old: PathBuf,
    /// The later result.
    pub new: PathBuf,
    /// How the difference is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: DiffFormat,
}

/// Files that are written beside what is printed.
#[derive(Clone, Debug, Default, Args)]
pub struct Written {
    /// Also write a test case for each requirement as JUnit XML.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Also write the verdicts in Markdown.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Also write what is violated, and mistakes in the study's files, in SARIF.
    #[arg(long, value_name = "FILE")]
    pub sarif: Option<PathBuf>,
}
