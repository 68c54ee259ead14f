//! One process for many episodes, each asked for by a line on its input.
//!
//! A simulator whose start costs seconds is started once for each thread. What is said of an episode is as for a process for
//! each: after one that failed or was given up, the process is ended and the next episode has a new one, so that nothing of a
//! failure reaches further. That an episode does not depend on those before it is the program's to keep; `corroborate explain
//! command` says so.

use super::once::cannot_start;
use crate::consent::Consent;
use crate::group::{Group, LOOK, Request};
use crate::process::{Said, indented, keep_lines};
use crate::start;
use diagnostic::Problem;
use host::Cancel;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The longest answer, in bytes.
const LONGEST_LINE: u64 = 1 << 20;
/// How long a process has to end by itself once its input has ended, and then once it is asked to.
const GRACE: Duration = Duration::from_secs(2);

/// The program that all this speaks to.
pub(super) struct Program<'a> {
    pub(super) words: &'a [String],
    /// Where it runs.
    pub(super) folder: &'a Path,
    /// How long an episode may take; the first of a process includes its start.
    pub(super) limit: Duration,
    /// That it may run.
    pub(super) consent: &'a Consent,
}

/// What is asked.
#[derive(Serialize)]
#[serde(tag = "type", rename = "episode")]
pub(super) struct Episode<'a> {
    /// The file with what is to be done.
    pub(super) stimulus: &'a Path,
    pub(super) seed: u64,
    /// Where the recording is to be left.
    pub(super) recording: &'a Path,
}

/// What may be answered.
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
enum Answer {
    /// The recording is there.
    Recorded,
    /// The episode has failed.
    Error { message: String },
}

/// Why there is no answer that the recording is there.
pub(super) struct Failed {
    /// It did not answer in time.
    pub(super) is_hung: bool,
    /// What it did instead, with what it said last.
    pub(super) reason: String,
}

/// Processes that wait for an episode; there are never more than threads that ask.
#[derive(Default)]
pub(super) struct Pool(Mutex<Vec<Serving>>);

impl Pool {
    /// Has an episode run. `None` if it was.
    pub(super) fn run(
        &self,
        program: &Program<'_>,
        episode: &Episode<'_>,
        interrupt: &Cancel,
    ) -> Result<Option<Failed>, Problem> {
        let waiting = self.lock().pop();
        let mut serving = match waiting {
            Some(serving) => serving,
            None => Serving::start(program)?,
        };
        // What does not come back to the pool is ended here.
        match serving.ask(episode, program.limit, interrupt)? {
            None => {
                self.lock().push(serving);
                Ok(None)
            }
            failed => Ok(failed),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Serving>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A process that is ended, with those that it started, when it is dropped.
struct Serving {
    group: Group,
    input: Option<ChildStdin>,
    answers: Receiver<String>,
    said: Said,
}

impl Serving {
    fn start(program: &Program<'_>) -> Result<Self, Problem> {
        let command = start::program(program.words, program.folder, program.consent);
        let mut command = command.map_err(|error| cannot_start("", error))?;
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let started = Group::start(command);
        let mut group =
            started.map_err(|error| cannot_start(&program.words[0], &error.to_string()))?;
        let (sender, answers) = sync_channel(1);
        if let Some(output) = group.output() {
            std::thread::spawn(move || {
                let mut output = BufReader::new(output);
                while let Some(line) = next_line(&mut output) {
                    if sender.send(line).is_err() {
                        break;
                    }
                }
            });
        }
        let said = Said::default();
        if let Some(errors) = group.errors() {
            let said = Said::clone(&said);
            std::thread::spawn(move || keep_lines(errors, &said));
        }
        Ok(Self {
            input: group.input(),
            group,
            answers,
            said,
        })
    }

    fn ask(
        &mut self,
        episode: &Episode<'_>,
        limit: Duration,
        interrupt: &Cancel,
    ) -> Result<Option<Failed>, Problem> {
        let line = serde_json::to_string(episode).unwrap_or_default();
        let sent = match &mut self.input {
            Some(input) => writeln!(input, "{line}").and_then(|()| input.flush()),
            None => Ok(()),
        };
        if sent.is_err() {
            return Ok(Some(self.gone("it does not read its input")));
        }
        let began = Instant::now();
        loop {
            match self.answers.recv_timeout(LOOK) {
                Ok(line) => return Ok(self.understood(&line)),
                Err(RecvTimeoutError::Disconnected) => {
                    return Ok(Some(self.gone("it closed its output")));
                }
                Err(RecvTimeoutError::Timeout) if interrupt.is_cancelled() => {
                    return Err(Problem::interrupted());
                }
                Err(RecvTimeoutError::Timeout) if began.elapsed() >= limit => {
                    let what = format!("it gave no answer within {} s", limit.as_secs_f64());
                    return Ok(Some(self.failed(true, what)));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    fn understood(&mut self, line: &str) -> Option<Failed> {
        match serde_json::from_str(line) {
            Ok(Answer::Recorded) => None,
            Ok(Answer::Error { message }) => Some(self.failed(false, message)),
            Err(_) => {
                let begins: String = line.trim_end().chars().take(80).collect();
                let what = format!(
                    "it printed `{begins}`, which is not an answer; its output is for answers only, print all else to the error output"
                );
                Some(self.failed(false, what))
            }
        }
    }

    /// It has ended, or is about to.
    fn gone(&mut self, what: &str) -> Failed {
        self.input = None;
        let ended = match self.group.wait(GRACE) {
            Some(status) => format!("{what} and ended with {status}"),
            None => what.to_owned(),
        };
        self.failed(false, ended)
    }

    fn failed(&mut self, is_hung: bool, what: String) -> Failed {
        // Last words come on another way than answers, and may be a moment behind.
        std::thread::sleep(10 * LOOK);
        let last = indented(&self.said);
        Failed {
            is_hung,
            reason: match last.is_empty() {
                true => format!("{what}; it said nothing"),
                false => format!("{what}; it said last\n{last}"),
            },
        }
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        // The end of its input is the end of its work; one that is in the middle of an episode may not look.
        self.input = None;
        if self.group.wait(GRACE / 4).is_none() {
            self.group.end(Request::Terminate, GRACE);
        }
    }
}

/// The next line of answers; `None` at their end.
fn next_line(output: &mut impl BufRead) -> Option<String> {
    let mut line = Vec::new();
    match output.take(LONGEST_LINE).read_until(b'\n', &mut line) {
        Ok(0) | Err(_) => None,
        Ok(_) => Some(String::from_utf8_lossy(&line).into_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_secs(60);

    fn run(pool: &Pool, script: &str, limit: Duration, interrupt: &Cancel) -> Option<Failed> {
        let words = ["sh", "-c", script].map(str::to_owned);
        let program = Program {
            words: &words,
            folder: Path::new("."),
            limit,
            consent: &Consent::typed(),
        };
        let episode = Episode {
            stimulus: Path::new("/s.json"),
            seed: u64::MAX,
            recording: Path::new("/r"),
        };
        pool.run(&program, &episode, interrupt).unwrap()
    }

    #[test]
    fn one_process_is_asked_again_and_a_failed_one_is_not() {
        let (pool, never) = (Pool::default(), Cancel::default());
        let script = "while read line; do n=$((n+1)); echo \"$line\" >&2
            if [ $n = 2 ]; then echo '{\"type\":\"error\",\"message\":\"it tipped over\"}'
            else echo '{\"type\":\"recorded\"}'; fi; done";
        assert!(run(&pool, script, LIMIT, &never).is_none());
        let failed = run(&pool, script, LIMIT, &never).unwrap();
        assert!(!failed.is_hung);
        assert!(
            failed.reason.contains("it tipped over"),
            "{}",
            failed.reason
        );
        let asked = r#"{"type":"episode","stimulus":"/s.json","seed":18446744073709551615,"recording":"/r"}"#;
        assert!(failed.reason.contains(asked), "{}", failed.reason);
        // Were it the same process, this would be its third.
        assert!(run(&pool, script, LIMIT, &never).is_none());
        assert!(run(&pool, script, LIMIT, &never).is_some());
    }

    #[test]
    fn what_ends_or_chatters_or_hangs_is_said() {
        let (pool, never) = (Pool::default(), Cancel::default());
        let ended = run(
            &pool,
            "read line; echo 'no mesh' >&2; exit 3",
            LIMIT,
            &never,
        )
        .unwrap();
        assert!(ended.reason.contains("exit status: 3"), "{}", ended.reason);
        assert!(ended.reason.contains("no mesh"), "{}", ended.reason);
        let chatter = run(&pool, "read line; echo hello; read line", LIMIT, &never).unwrap();
        assert!(chatter.reason.contains("`hello`"), "{}", chatter.reason);
        let short = Duration::from_millis(50);
        let hung = run(&pool, "read line; exec sleep 600", short, &never).unwrap();
        assert!(
            hung.is_hung && hung.reason.contains("0.05 s"),
            "{}",
            hung.reason
        );
    }

    #[test]
    fn an_interruption_ends_the_process() {
        let words = ["sh", "-c", "read line; exec sleep 600"].map(str::to_owned);
        let program = Program {
            words: &words,
            folder: Path::new("."),
            limit: LIMIT,
            consent: &Consent::typed(),
        };
        let episode = Episode {
            stimulus: Path::new("/s"),
            seed: 1,
            recording: Path::new("/r"),
        };
        let interrupt = Cancel::default();
        interrupt.cancel();
        let pool = Pool::default();
        let problem = pool.run(&program, &episode, &interrupt).err().unwrap();
        assert!(problem.is_interruption());
        assert!(pool.lock().is_empty());
    }
}
