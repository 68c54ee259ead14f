//! Arguments of `language-server`.

use clap::Args;

/// Arguments of `language-server`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate language-server      an editor starts it so, and speaks to it over standard input and output

Models and properties in the PRISM language and the files of a study: diagnostics as `check` and `plan` give them, hover,
definitions and references, rename across files, completion, outline, layout. Nothing is computed or written.
How to set up VS Code, Neovim, Helix and Emacs: docs/how-to/use-your-editor.md.
Exits 0 when the editor has shut it down, 2 when its messages ended otherwise.")]
pub struct LanguageServer {
    /// Standard input and output, which is the only way; editors that say so are understood.
    #[arg(long)]
    pub stdio: bool,
}
