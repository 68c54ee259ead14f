//! Arguments of `doctor`, `completions` and `man`.

use super::Format;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate doctor
  corroborate doctor --format json

Says what the program finds around it, what is missing, and what each missing
thing disables. Exits 3 if anything is missing.")]
pub struct Doctor {
    /// How it is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate completions bash > ~/.local/share/bash-completion/completions/corroborate
  corroborate completions zsh > ~/.zfunc/_corroborate
  corroborate completions fish > ~/.config/fish/completions/corroborate.fish")]
pub struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate man | man -l -
  corroborate man decide | man -l -
  corroborate man --out ~/.local/share/man/man1")]
pub struct Man {
    /// The command whose page is printed; the program's own without it.
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    pub page: Option<String>,
    /// Write all pages into this folder instead.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}
