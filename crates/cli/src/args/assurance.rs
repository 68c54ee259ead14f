//! Arguments of the commands about assurance.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `assure`.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes argument.gsn.yaml and confidence.gsn.yaml (Goal Structuring Notation, for gsn2x), both in
argument.sacm.xmi (Structured Assurance Case Metamodel 2.3, XMI), provenance.json (W3C PROV), each
evidence as JSON with an in-toto statement about it, and a statement about all of it. The
arguments are drawn in the report, too.

Examples:
  corroborate assure case-studies/handover
  corroborate assure case-studies/handover --to assurance
  gsn2x assurance/argument.gsn.yaml            draws the argument")]
pub struct Assure {
    /// The study's folder, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// The folder to write to, instead of STUDY/results/assurance.
    #[arg(long, value_name = "FOLDER")]
    pub to: Option<PathBuf>,
    /// Where the results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How what was written is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `verify`.
#[derive(Debug, Args)]
#[command(after_help = "\
Computes everything again from the kept evidence and the study's files: counts from tables and
journals of episodes, intervals, comparisons, conclusions, the report; and checks every hash.
A map of disagreement is searched again by the journal of its episodes; for it alone models are
solved. Nothing else is run, solved or simulated again, and nothing is written.
With --deep recordings of episodes are judged again, and episodes that are drawn
anew each time are run again: a journal that was changed does not pass for long.
Of an evidence pack (`corroborate pack`) every byte, every part and the signature are checked.

Examples:
  corroborate verify case-studies/handover/results
  corroborate verify results case-studies/handover
  corroborate verify evidence-pack.zip --key signer.pub.pem

Exit codes:
  0 everything follows   1 something does not, and is named   2 error in the call or the input
  3 a pack without a signature, or without the key that verifies it")]
pub struct Verify {
    /// The folder of results, or an evidence pack.
    pub results: PathBuf,
    /// The study's folder, if not the one in which the results lie.
    pub study: Option<PathBuf>,
    /// How what was found is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Also solve formal models, judge recordings, make the diagnosis, and run a map's episodes and a sample of each simulation's again,
    /// which may take as long as at first.
    #[arg(long)]
    pub deep: bool,
    /// With --deep: how many episodes of each simulation are run again.
    #[arg(long, value_name = "N", default_value_t = corroborate::verify::EPISODES_AGAIN, requires = "deep", conflicts_with = "key")]
    pub episodes: u64,
    /// With --deep: the number from which these episodes are drawn; another each time if left out, and said.
    #[arg(long, value_name = "N", requires = "deep", conflicts_with = "key")]
    pub draw: Option<u64>,
    /// The signer's public key in PEM, by which the signature of an evidence pack is verified.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["study", "deep"])]
    pub key: Option<PathBuf>,
}
