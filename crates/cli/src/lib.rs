#![doc = include_str!("../README.md")]
//!
//! A command is parsed into plain data (`args`), carried out
//! (`command`), and ends in an [`corroborate::Outcome`] or a
//! [`diagnostic::Problem`], which choose the exit code here and nowhere else.

mod args;
mod command;
mod drawing;
mod explain;
mod memory;
mod physics_library;
mod python_path;
mod shown_calibration;
mod shown_problem;
mod terminal;
mod trust;
mod written;

use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::sync::Arc;

/// Carries out the command of these arguments, of which the first is the program's name, and gives the exit code. It is the
/// process's only work: it catches Ctrl-C and ends the process where the arguments are wrong, or ask for help.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = args::with_peers_spelling(arguments.into_iter());
    let parsed = args::parsed(arguments).unwrap_or_else(|error| error.exit());
    let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let host = host::Host {
        events: terminal::events(parsed.quiet),
        cancel: match parsed.command {
            // It waits for an editor and has no work that would be lost: a signal ends it at once.
            args::Command::LanguageServer(_) => Arc::default(),
            _ => terminal::cancel_on_interrupt(),
        },
        physics_library: physics_library::find(),
        build: corroborate::build(),
        python_path: python_path::of_environment(),
        scratch: std::env::temp_dir(),
        trust: host::Trust {
            readable: parsed.allow,
            ..trust::of_environment(parsed.trust)
        },
        memory: Arc::new(memory::Memory::unlimited()),
    };
    match command::carry_out(&parsed.command, &host) {
        Ok(done) => finish(&parsed.command, &done),
        Err(problem) => {
            let problem = match parsed.command {
                args::Command::Run(_)
                | args::Command::Simulate(_)
                | args::Command::Rare(_)
                | args::Command::Calibrate(_) => problem.resumable(),
                _ => problem,
            };
            terminal::to_stderr(&shown_problem::rendered(&problem, colour));
            shown_problem::exit_code(&problem)
        }
    }
}

/// Which studies may run the programs that they name, as this user's environment and records say; `is_given` for this call: for
/// faces that are no command line.
pub fn trust(is_given: bool) -> host::Trust {
    trust::of_environment(is_given)
}

/// Makes the pack of a study that has been run, drawn as the command `pack` draws it: for faces that are no command line.
///
/// # Errors
/// As of [`corroborate::pack()`].
pub fn pack(
    request: &corroborate::PackRequest,
    host: &host::Host,
) -> Result<corroborate::pack::PackReport, diagnostic::Problem> {
    command::pack::packed(request, host)
}

/// Prints the result and turns the outcome into the exit code.
fn finish(command: &args::Command, done: &command::Done) -> u8 {
    let mut out = std::io::stdout().lock();
    // The summaries colour what they quote, so they have cleaned it themselves.
    let is_coloured = matches!(command, args::Command::Run(_) | args::Command::Report(_))
        && terminal::use_colour();
    let shown = match done.output.as_bytes().first() {
        _ if is_coloured => done.output.as_str().into(),
        Some(b'{' | b'[') => diagnostic::printable_json(&done.output),
        _ => diagnostic::printable(&done.output),
    };
    let printed = out.write_all(shown.as_bytes()).and_then(|()| out.flush());
    match printed {
        // The reader of a pipe may stop early; that is no fault of ours.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            terminal::to_stderr(&format!("the result could not be printed: {error}"));
            corroborate::Outcome::DataLost.exit_code()
        }
        _ => done.outcome.exit_code(),
    }
}
