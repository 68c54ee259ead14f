//! A process for each episode.

use crate::consent::Consent;
use crate::group::{Group, LOOK, Request};
use crate::start::program;
use diagnostic::Problem;
use host::Cancel;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How long a command has to end by itself once it is asked to.
const GRACE: Duration = Duration::from_secs(2);
/// How many of the last lines that a failed command said are shown.
const SHOWN_LINES: usize = 12;

/// Starts a command in `folder`; what it prints goes to the file `said`.
pub(crate) fn start(
    words: &[String],
    folder: &Path,
    said: &Path,
    consent: &Consent,
) -> Result<Running, Problem> {
    let unwritable = |error: std::io::Error| Problem::cannot_write(said, &error);
    let output = File::create(said).map_err(unwritable)?;
    let errors = output.try_clone().map_err(unwritable)?;
    let mut command = program(words, folder, consent).map_err(|error| cannot_start("", error))?;
    command.stdin(Stdio::null()).stdout(output).stderr(errors);
    let started = Group::start(command);
    let group = started.map_err(|error| cannot_start(&words[0], &error.to_string()))?;
    Ok(Running(group))
}

/// The command is no program that can be started.
pub(crate) fn cannot_start(program: &str, error: &str) -> Problem {
    Problem::new(
        "episode-failed",
        format!("`{program}` cannot be started: {error}"),
    )
    .remedy("check `command` in the ledger; it runs in the study's folder")
}

/// The first line that a process has printed that was started with a pipe for its output, if it ends well within `limit`. It may
/// print no more than a pipe holds.
pub(crate) fn output_of(
    mut group: Group,
    limit: Duration,
    interrupt: &Cancel,
) -> Result<String, String> {
    let out = group.output();
    let ended = Running(group).wait(limit, interrupt);
    match ended {
        Ok(Some(status)) if status.success() => {
            let mut text = String::new();
            let read = out.map(|mut it| it.read_to_string(&mut text)).transpose();
            read.map_err(|error| error.to_string())?;
            Ok(text.lines().next().unwrap_or_default().to_owned())
        }
        Ok(Some(status)) => Err(status.to_string()),
        Ok(None) => Err(format!("it did not end within {} s", limit.as_secs())),
        Err(problem) => Err(problem.line()),
    }
}

/// What a command said last.
pub(crate) fn last_words(said: &Path) -> String {
    let text = std::fs::read(said).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().collect();
    let last = &lines[lines.len().saturating_sub(SHOWN_LINES)..];
    match last.is_empty() {
        true => "; it said nothing".to_owned(),
        false => format!("; it said last\n    {}", last.join("\n    ")),
    }
}

/// A process that is ended, with those that it started, if it is no longer waited for.
pub(crate) struct Running(Group);

impl Running {
    /// How it ended; `None` if it did not within `limit`.
    pub(crate) fn wait(
        mut self,
        limit: Duration,
        interrupt: &Cancel,
    ) -> Result<Option<ExitStatus>, Problem> {
        let began = Instant::now();
        loop {
            match self.0.ended() {
                Ok(Some(status)) => return Ok(Some(status)),
                Ok(None) => {}
                Err(error) => return Err(Problem::new("episode-failed", error.to_string())),
            }
            if interrupt.is_cancelled() {
                return Err(Problem::interrupted());
            }
            if began.elapsed() >= limit {
                return Ok(None);
            }
            std::thread::sleep(LOOK);
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.0.ended(), Ok(Some(_))) {
            return;
        }
        self.0.end(Request::Terminate, GRACE);
    }
}
