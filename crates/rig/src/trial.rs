//! A test that is a command: run once, it passes, fails, is not applicable, or its harness breaks.
//!
//! Of the command's words `{seed}` becomes the trial's seed and `{trial}` its number, which parallel trials can tell themselves
//! apart by. Ends are told apart so that none is taken for another:
//!
//! | the command | is |
//! |---|---|
//! | ends with code 0 | passed |
//! | ends with the code that was named for it (77, as in Automake and CTest) | not applicable |
//! | ends with 126 or 127 (a shell cannot run it or does not find it), or 129 to 192 (a shell reports a signal) | error |
//! | is ended by a signal (on Windows: an exception), or is not done within the limit of real time | error |
//! | ends with any other code | failed |
//!
//! A command that cannot be started at all is a mistake of the call and not an outcome. What it prints is kept.

use crate::command::once;
use crate::consent::Consent;
use crate::group;
use diagnostic::Problem;
use host::Cancel;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::Duration;

/// As long as a test may take that has no limit: longer than any machine runs.
const NO_LIMIT: Duration = Duration::from_secs(1 << 32);
/// Codes by which shells report that a command cannot be run or was not found.
const NOT_RUN: std::ops::RangeInclusive<i32> = 126..=127;
/// Codes by which shells report a signal: 128 and its number.
const SIGNALLED: std::ops::RangeInclusive<i32> = 129..=192;

/// A test as a command.
#[derive(Clone, Debug)]
pub struct TrialCommand {
    /// The program and its arguments, with `{seed}` and `{trial}`.
    pub words: Vec<String>,
    /// The folder in which it runs.
    pub folder: PathBuf,
    /// How long a trial may take in real time.
    pub limit: Option<Duration>,
    /// The exit code of a trial that says that it was none.
    pub not_applicable: i32,
}

/// How a trial ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrialEnd {
    /// The test passed.
    Passed,
    /// The test failed, with this exit code.
    Failed(i32),
    /// The test says that it could not be asked this time.
    NotApplicable,
    /// The harness broke; why, in words.
    Error(String),
}

impl TrialCommand {
    /// The words of one trial.
    #[must_use]
    pub fn of(&self, seed: u64, trial: u64) -> Vec<String> {
        let filled = self.words.iter().map(|word| {
            word.replace("{seed}", &seed.to_string())
                .replace("{trial}", &trial.to_string())
        });
        filled.collect()
    }

    /// Runs one trial; what it prints goes to the file `said`.
    ///
    /// # Errors
    /// `test-cannot-start`; `interrupted` if `cancel` asks for it, once the command and what it started are ended.
    pub fn run(
        &self,
        seed: u64,
        trial: u64,
        said: &Path,
        cancel: &Cancel,
    ) -> Result<TrialEnd, Problem> {
        let words = self.of(seed, trial);
        let running =
            once::start(&words, &self.folder, said, &Consent::typed()).map_err(|problem| {
                if problem.code != "episode-failed" {
                    return problem;
                }
                let remedy = "check the program's name behind `--`, and that it may be executed";
                Problem::new("test-cannot-start", problem.message()).remedy(remedy)
            })?;
        let status = running.wait(self.limit.unwrap_or(NO_LIMIT), cancel)?;
        Ok(match (status, self.limit) {
            (Some(status), _) => self.end(status),
            (None, limit) => {
                let secs = limit.unwrap_or(NO_LIMIT).as_secs_f64();
                TrialEnd::Error(format!("not done within {secs} s"))
            }
        })
    }

    fn end(&self, status: ExitStatus) -> TrialEnd {
        if let Some(what) = group::crash(status) {
            return TrialEnd::Error(format!("ended by {what}"));
        }
        let Some(code) = status.code() else {
            return TrialEnd::Error(format!("ended with {status}"));
        };
        match code {
            0 => TrialEnd::Passed,
            code if code == self.not_applicable => TrialEnd::NotApplicable,
            code if NOT_RUN.contains(&code) => TrialEnd::Error(format!(
                "exit code {code}, by which shells report a command that they cannot run"
            )),
            code if SIGNALLED.contains(&code) => TrialEnd::Error(format!(
                "exit code {code}, by which shells report signal {}",
                code - 128
            )),
            code => TrialEnd::Failed(code),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end_of(script: &str, limit: Option<Duration>) -> TrialEnd {
        let folder = tempfile::tempdir().expect("a folder");
        let command = TrialCommand {
            words: ["sh", "-c", script, "sh", "{seed}", "{trial}"]
                .map(String::from)
                .to_vec(),
            folder: folder.path().to_owned(),
            limit,
            not_applicable: 77,
        };
        let said = folder.path().join("said");
        command
            .run(5, 2, &said, &Cancel::default())
            .expect("it starts")
    }

    #[test]
    fn ends_are_told_apart() {
        let error = |part: &str, end: TrialEnd| match end {
            TrialEnd::Error(why) => assert!(why.contains(part), "{why}"),
            other => panic!("{other:?}"),
        };
        assert_eq!(end_of("exit 0", None), TrialEnd::Passed);
        assert_eq!(end_of("exit 3", None), TrialEnd::Failed(3));
        assert_eq!(end_of("exit 255", None), TrialEnd::Failed(255));
        assert_eq!(end_of("exit 77", None), TrialEnd::NotApplicable);
        error("signal 9", end_of("kill -9 $$", None));
        error("signal 11", end_of("exit 139", None));
        error("cannot run", end_of("no-such-program", None));
        let limit = Duration::from_millis(100);
        error("within 0.1 s", end_of("sleep 60", Some(limit)));
        assert_eq!(end_of("test $1 = 5 && test $2 = 2", None), TrialEnd::Passed);
    }

    #[test]
    fn a_program_that_is_not_there_is_a_mistake_of_the_call() {
        let folder = tempfile::tempdir().expect("a folder");
        let command = TrialCommand {
            words: vec!["/no/such/program".into()],
            folder: folder.path().to_owned(),
            limit: None,
            not_applicable: 77,
        };
        let said = folder.path().join("said");
        let problem = command.run(1, 1, &said, &Cancel::default());
        assert_eq!(problem.expect_err("no program").code, "test-cannot-start");
    }
}
