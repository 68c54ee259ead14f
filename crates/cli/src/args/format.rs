//! Arguments of `format`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `format`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate format models/*.prism properties.props
  corroborate format models/*.prism --check      changes nothing; exits 1 if something is to be changed
  corroborate format - < model.prism             prints the formatted model

Each declaration and each command stands on a line of its own, broken where it is wider than 100 columns. Names,
parentheses, the order of things and comments stay as they are. Files that end in .props, .prop, .pctl, .csl or .ltl
hold properties, others a model.")]
pub struct FormatFiles {
    /// Models and property files; `-` is standard input.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Change nothing: name the files that are laid out otherwise, and exit with 1 if there are any.
    #[arg(long)]
    pub check: bool,
    /// All files hold properties.
    #[arg(long)]
    pub properties: bool,
}
