//! A controller that runs as a process and is asked line by line.
//!
//! Simulated time stands still while it thinks; only here does a clock of the
//! real world run, so that a controller that hangs is ended and said to hang.

use crate::consent::Consent;
use crate::group::Group;
use crate::processor::Counted;
use crate::start::program;
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use testbench::controller::{LockStep, Lost};

/// The longest line that a controller may answer, in bytes.
const LONGEST_LINE: u64 = 16 << 20;
/// How many lines of its error output are kept, the last ones.
const KEPT_LINES: usize = 200;
/// How many of them an error shows.
const SHOWN_LINES: usize = 12;
/// How long a process has to end by itself once its input has ended.
const GRACE: Duration = Duration::from_secs(2);

/// How long last words are waited for when a controller reports an error.
const WORDS: Duration = Duration::from_millis(50);

/// What is said of a controller that is no program.
pub const NO_COMMAND: &str = "the scene names no `command` for it; add for example `command = [\"python3\", \"controller.py\"]`";

/// The last lines of a process's error output.
pub type Said = Arc<Mutex<VecDeque<String>>>;

/// A running controller.
pub struct Process {
    name: String,
    group: Counted,
    input: Option<ChildStdin>,
    answers: Receiver<Result<String, String>>,
    said: Said,
    listeners: Vec<JoinHandle<()>>,
    limit: Duration,
}

impl Process {
    /// Starts `command` in `folder`, with `PYTHONPATH` if one is given. Each answer has to come within `limit`.
    pub fn start(
        command: &[String],
        folder: &Path,
        python_path: Option<&OsStr>,
        limit: Duration,
        consent: &Consent,
    ) -> Result<Self, String> {
        let name = command.join(" ");
        let Ok(mut prepared) = program(command, folder, consent) else {
            return Err(NO_COMMAND.into());
        };
        prepared
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        if let Some(path) = python_path {
            prepared.env("PYTHONPATH", path);
        }
        // Whatever else a controller hashes or prints, it does the same each time.
        prepared.env("PYTHONHASHSEED", "0");
        let mut group = Group::start(prepared)
            .map_err(|error| format!("`{name}` cannot be started: {error}"))?;
        let (input, output, errors) = (group.input(), group.output(), group.errors());
        let (sender, answers) = sync_channel(1);
        let said = Said::default();
        let mut listeners = Vec::new();
        if let Some(output) = output {
            listeners.push(std::thread::spawn(move || {
                let mut output = BufReader::new(output);
                while let Some(line) = next_line(&mut output) {
                    if sender.send(line).is_err() {
                        break;
                    }
                }
            }));
        }
        if let Some(errors) = errors {
            let said = Arc::clone(&said);
            listeners.push(std::thread::spawn(move || keep_lines(errors, &said)));
        }
        Ok(Self {
            name,
            group: Counted(group),
            input,
            answers,
            said,
            listeners,
            limit,
        })
    }

    /// Why no answer came, with how the process ended and what it said last.
    fn lost(&mut self, what: &str) -> String {
        // A process that has just closed its output is about to end.
        let status = self.group.wait(GRACE);
        let ended = match status {
            Some(status) => format!("it ended with {status}"),
            None => "it still runs and is ended".to_owned(),
        };
        let last = self.last_lines();
        let output = if last.is_empty() {
            String::new()
        } else {
            format!("; its error output ends with\n{last}")
        };
        format!("`{}` {what}; {ended}{output}", self.name)
    }

    /// The last lines of its error output, indented.
    fn last_lines(&self) -> String {
        indented(&self.said)
    }
}

impl LockStep for Process {
    fn exchange(&mut self, line: &str) -> Result<String, Lost> {
        let sent = match &mut self.input {
            Some(input) => writeln!(input, "{line}").and_then(|()| input.flush()),
            None => Err(std::io::Error::other("its input is closed")),
        };
        if sent.is_err() {
            return Err(Lost::Gone(self.lost("does not read its input")));
        }
        match self.answers.recv_timeout(self.limit) {
            Ok(answer) => answer.map_err(|reason| Lost::Gone(self.lost(&reason))),
            Err(RecvTimeoutError::Timeout) => {
                let secs = self.limit.as_secs_f64();
                self.input = None;
                let what = format!("gave no answer within {secs} s");
                Err(Lost::Silent(self.lost(&what)))
            }
            Err(RecvTimeoutError::Disconnected) => Err(Lost::Gone(self.lost("closed its output"))),
        }
    }

    fn last_words(&mut self) -> String {
        // The words come on another way than the answer and may be a moment behind.
        std::thread::sleep(WORDS);
        self.last_lines()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.input = None;
        if self.group.wait(GRACE).is_none() {
            self.group.kill();
        }
        // What it has left behind may hold the pipes open: then the listeners are left behind.
        self.listeners.retain(|listener| !listener.is_finished());
    }
}

/// The next line, at most [`LONGEST_LINE`] long; `None` at the end.
fn next_line(output: &mut impl BufRead) -> Option<Result<String, String>> {
    let mut line = Vec::new();
    match output.take(LONGEST_LINE).read_until(b'\n', &mut line) {
        Ok(0) => None,
        Ok(_) if line.last() != Some(&b'\n') && line.len() as u64 >= LONGEST_LINE => {
            Some(Err("answered a line that is too long".into()))
        }
        Ok(_) => Some(String::from_utf8(line).map_err(|_| "answered no UTF-8 text".into())),
        Err(error) => Some(Err(format!("cannot be read: {error}"))),
    }
}

/// The last lines that were said, indented.
pub fn indented(said: &Said) -> String {
    let said = said.lock().unwrap_or_else(PoisonError::into_inner);
    let skipped = said.len().saturating_sub(SHOWN_LINES);
    let lines = said.iter().skip(skipped).map(|line| format!("    {line}"));
    lines.collect::<Vec<String>>().join("\n")
}

/// Keeps the last lines of what a process writes, until it writes no more.
pub fn keep_lines(errors: impl Read, said: &Said) {
    let mut errors = BufReader::new(errors);
    let mut line = Vec::new();
    while let Ok(1..) = (&mut errors)
        .take(LONGEST_LINE)
        .read_until(b'\n', &mut line)
    {
        let text = String::from_utf8_lossy(&line).trim_end().to_owned();
        line.clear();
        let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
        if said.len() == KEPT_LINES {
            said.pop_front();
        }
        said.push_back(text);
    }
}

#[cfg(test)]
mod tests {
    use super::super::processor;
    use super::*;

    fn start(script: &str, limit: Duration) -> Process {
        let command = ["sh", "-c", script].map(str::to_owned);
        Process::start(&command, Path::new("."), None, limit, &Consent::typed()).unwrap()
    }

    #[test]
    fn lines_are_answered_in_turn() {
        let mut echo = start(
            "while read line; do echo \"<$line>\"; done",
            Duration::from_secs(60),
        );
        assert_eq!(echo.exchange("one").unwrap().trim_end(), "<one>");
        assert_eq!(echo.exchange("two").unwrap().trim_end(), "<two>");
    }

    #[test]
    fn how_a_process_ended_is_said_with_its_last_words() {
        let script = "read line; echo 'no map here' >&2; exit 3";
        let lost = start(script, Duration::from_secs(60))
            .exchange("go")
            .unwrap_err();
        let Lost::Gone(error) = lost else {
            panic!("{lost:?}");
        };
        assert!(error.contains("exit status: 3"), "{error}");
        // Its error output is read on another thread, which may be a moment behind.
        assert!(error.contains("closed its output"), "{error}");
    }

    #[test]
    fn the_time_of_a_program_counts_as_that_of_the_thread() {
        let used_secs = || processor::used_secs().expect("Unix tells");
        let before = used_secs();
        let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done; read line; echo done";
        let mut working = start(work, Duration::from_secs(600));
        working.exchange("go").unwrap();
        let thread_secs = used_secs() - before;
        drop(working);
        let secs = used_secs() - before;
        // A shell needs a tenth of a second or so; what this thread does, hardly anything.
        assert!(
            secs > thread_secs + 0.02,
            "{secs} s, {thread_secs} s of this thread"
        );
    }

    #[test]
    fn a_process_that_hangs_is_ended() {
        let mut hanging = start("read line; exec sleep 600", Duration::from_millis(50));
        let lost = hanging.exchange("go").unwrap_err();
        let Lost::Silent(error) = lost else {
            panic!("{lost:?}");
        };
        assert!(error.contains("no answer within 0.05 s"), "{error}");
        let id = hanging.group.id();
        drop(hanging);
        assert!(!Path::new(&format!("/proc/{id}")).exists());
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let command = ["no-such-program".to_owned()];
        let start = |command: &[String]| {
            Process::start(command, Path::new("."), None, GRACE, &Consent::typed())
        };
        let error = start(&command).err().unwrap();
        assert!(error.contains("no-such-program"), "{error}");
        assert!(start(&[]).is_err());
    }
}
