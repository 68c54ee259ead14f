//! Arguments of `refine` and `what-if`.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `refine`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate refine my-study                    show what is offered, as diffs
  corroborate refine my-study --fit              run simulators that are commands for the values, too
  corroborate refine my-study --accept 1 --accept 3
  corroborate refine my-study --all --rounds 5 --to refined

Runs what of the study is missing or stale, then offers changes of the current
assets: a formal model's constants and failure branches, a requirement's
monitor, a simulation's parameters. Each model is solved as changed before it is
offered. What is accepted is written to new files, joins the ledger as a new
entry that names the counts it was set to, and is run. Decisions on what a text
means are never part of --all. Exits 1 if something is offered, 3 if nothing is
and suspects are open; with accepted changes, as `run` does.")]
pub struct Refine {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Offer only what is for this suspect, by its rank as `diagnose` shows it.
    #[arg(long, value_name = "RANK")]
    pub suspect: Option<u32>,
    /// Accept this proposal (may be repeated).
    #[arg(long, value_name = "N", conflicts_with = "all")]
    pub accept: Vec<usize>,
    /// Accept all that needs no decision.
    #[arg(long)]
    pub all: bool,
    /// Search commands' files for the numbers first, so that values and diffs are shown: up to 22 times the episodes a number.
    #[arg(long)]
    pub fit: bool,
    /// Go on refining the models that result, so many times in all.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=20))]
    pub rounds: u16,
    /// Episodes of a simulation that is fitted again; as many as before unless given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub episodes: Option<u64>,
    /// Work in a copy of the study, made in this folder.
    #[arg(long, value_name = "FOLDER")]
    pub to: Option<PathBuf>,
    /// Where `run --out` put the study's results, in STUDY/results unless given.
    #[arg(long, value_name = "FOLDER", conflicts_with = "to")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the proposals are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `what-if`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate what-if case-studies/handover
  corroborate what-if case-studies/handover --variant 'gentler reset' --episodes 500
  corroborate what-if case-studies/corridor

Each file STUDY/variants/*.toml is a variant: constants of a formal model as
expressions over their values, keys of a simulation's data: of its scenario and
parameters, of its scene, of the stimulus of a simulator that is a command.
It is tried in each technique that can express it, on the same draws as the
assets as they are: the same points of the constants' posteriors, the same
seeds. Printed is the predicted gain with its interval, and where techniques
predict gains that exclude each other. Nothing of the study is changed.")]
pub struct WhatIf {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Only the variant with this name (may be repeated).
    #[arg(long, value_name = "NAME")]
    pub variant: Vec<String>,
    /// Episodes of each simulation, with the variant and without.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub episodes: u64,
    /// Points of the constants' posteriors at which each model is solved.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u16).range(20..=10_000))]
    pub points: u16,
    /// Where `run --out` put the study's results, in STUDY/results unless given.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the gains are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
