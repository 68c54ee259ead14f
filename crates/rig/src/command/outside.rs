//! Other simulators and rigs as they are: a command that leaves a recording.
//!
//! For each episode the command of the ledger is run in the study's folder. Of its words
//! `{stimulus}` becomes the path of a JSON file with what is to be done (crate `stimulus`),
//! `{seed}` the episode's seed, a whole number below 2^64, and `{recording}` the path at which it
//! has to leave a recording, in any format that is read here. It has to end with code 0 within a
//! limit of real time. The recording is judged through the study's `topics.toml`.
//!
//! A command that fails or hangs is no error: it is what the episode shows, with what it left of a
//! recording. The recording is moved to its place once the command has ended, so that nothing writes
//! to what is there.

use crate::asset;
use diagnostic::{Problem, Source};
use evidence::{Asset, AssetRole, Tool};
use host::Cancel;
use host::files::write_whole;
use host::store::Inputs;
use judging::recording::ReadingRules;
use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use stimulus::{AbstractTest, Stimulus};
use study::{CommandText, Study};
use testbench::{Failure, Part};
use trace::Trace;

/// How often a running command is looked at.
const LOOK: Duration = Duration::from_millis(5);
/// How long a command has to end by itself once it is asked to.
const GRACE: Duration = Duration::from_secs(2);
/// How many of the last lines that a failed command said are shown.
const SHOWN_LINES: usize = 12;
/// Where what is under way is kept; hidden, so that it is taken for no recording.
const WORK: &str = ".work";

/// A command that gives episodes.
pub struct OutsideCommand {
    words: Vec<String>,
    /// The study's folder.
    folder: PathBuf,
    stimulus: Stimulus,
    leaves: String,
    limit: Duration,
    assets: Vec<Asset>,
    rules: ReadingRules,
    /// The topic map.
    map: String,
}

impl OutsideCommand {
    /// The command of a ledger's entry with everything that it names; `stimulus` stands in for the text of its stimulus.
    ///
    /// # Errors
    /// `cannot-read`, `bad-stimulus`, and what the topic map says wrong.
    pub fn new(
        study: &Study,
        text: &CommandText,
        stimulus: Option<&Source>,
    ) -> Result<Self, Problem> {
        let cannot = |error| Problem::cannot_read(&study.folder, &error);
        let folder = std::fs::canonicalize(&study.folder).map_err(cannot)?;
        let mut files: Vec<PathBuf> = text.assets.clone();
        // What of the command itself is a file of the study is part of what is tested.
        let of_command = text.command.iter().map(PathBuf::from);
        files.extend(of_command.filter(|word| word.is_relative() && folder.join(word).is_file()));
        files.extend(text.stimulus.clone());
        files.sort();
        files.dedup();
        let assets = files
            .iter()
            .map(|file| asset(&study.folder, AssetRole::SystemModel, file));
        let map = study.folder.join("topics.toml");
        Ok(Self {
            words: text.command.clone(),
            stimulus: match (&text.stimulus, stimulus) {
                (Some(path), Some(source)) => stimulus_of(path, source)?,
                (Some(path), None) => {
                    stimulus_of(path, &host::files::read_source(&study.folder.join(path))?)?
                }
                (None, _) => Stimulus::of(AbstractTest::new("as it is", Vec::new())),
            },
            leaves: text.leaves.clone(),
            limit: Duration::from_secs_f64(text.limit_secs),
            assets: assets.collect::<Result<_, _>>()?,
            rules: ReadingRules::of_study(&study.folder, None)?,
            map: match map.exists() {
                true => host::files::read_source(&map)?.text,
                false => String::new(),
            },
            folder,
        })
    }

    /// The command and what can move a number.
    pub fn tool(&self) -> Tool {
        Tool {
            name: self.words.first().cloned().unwrap_or_default(),
            version: String::new(),
            settings: format!(
                "`{}`, each episode a process; it is taken at its word that a seed fixes its run",
                self.words.join(" ")
            ),
        }
    }

    /// The files on which it rests.
    pub fn assets(&self) -> &[Asset] {
        &self.assets
    }

    /// What is done in each episode.
    pub fn stimulus(&self) -> &Stimulus {
        &self.stimulus
    }

    /// What its episodes depend on, besides their seeds.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add_json("command", &self.words)
            .add("leaves", self.leaves.as_bytes())
            .add("stimulus", self.stimulus.to_json().as_bytes());
        for asset in &self.assets {
            inputs.add(&asset.path, asset.hash.as_bytes());
        }
    }

    /// What judging its recordings depends on, besides the monitors.
    pub fn reading_inputs(&self, inputs: &mut Inputs) {
        inputs.add("topics.toml", self.map.as_bytes());
    }

    /// The name of an episode's recording.
    pub fn recording_name(&self, number: u64) -> String {
        match self.leaves.as_str() {
            "" => format!("episode-{number:05}"),
            extension => format!("episode-{number:05}.{extension}"),
        }
    }

    /// Makes room for work in `folder`. What an earlier call left there is removed.
    pub fn prepare(&self, folder: &Path) -> Result<(), Problem> {
        self.tidy(folder);
        let work = work_in(folder);
        std::fs::create_dir_all(&work).map_err(|error| Problem::cannot_write(&work, &error))?;
        write_whole(&stimulus_in(folder)?, self.stimulus.to_json().as_bytes())
    }

    /// Removes what is no longer needed.
    pub fn tidy(&self, folder: &Path) {
        Self::remove(&folder.join(WORK));
    }

    /// Removes a file or folder, if it is there.
    pub fn remove(path: &Path) {
        let _ = match path.is_dir() {
            true => std::fs::remove_dir_all(path),
            false => std::fs::remove_file(path),
        };
    }

    /// Where the recording of an episode is made, from where it is to be moved; nothing is there.
    pub fn room_for(&self, folder: &Path, name: &str) -> Result<PathBuf, Problem> {
        let folder =
            std::fs::canonicalize(folder).map_err(|error| Problem::cannot_read(folder, &error))?;
        let recording = work_in(&folder).join(name);
        Self::remove(&recording);
        Ok(recording)
    }

    /// Runs the command once, in a room that was prepared; what went wrong, if it did not end well.
    pub fn run(
        &self,
        stimulus: &Path,
        seed: u64,
        recording: &Path,
        interrupt: &Cancel,
    ) -> Result<Option<Failure>, Problem> {
        let mut said = recording.as_os_str().to_owned();
        said.push(".said");
        let said = PathBuf::from(said);
        let words = self.words.iter().map(|word| {
            word.replace("{stimulus}", &stimulus.to_string_lossy())
                .replace("{seed}", &seed.to_string())
                .replace("{recording}", &recording.to_string_lossy())
        });
        let words: Vec<String> = words.collect();
        let child = self.start(&words, &said)?;
        let ended = Running(child).wait(self.limit, interrupt)?;
        let (is_hung, reason) = match ended {
            None => (
                true,
                format!("it did not end within {} s", self.limit.as_secs_f64()),
            ),
            Some(status) if !status.success() => (false, format!("it ended with {status}")),
            Some(_) if !recording.exists() => (
                false,
                "it ended well but left no recording at `{recording}`".to_owned(),
            ),
            Some(_) => {
                Self::remove(&said);
                return Ok(None);
            }
        };
        let words = format!("`{}`: {reason}{}", self.words.join(" "), last_words(&said));
        Self::remove(&said);
        Ok(Some(Failure {
            part: Part::Simulator,
            is_hung,
            words,
            in_setup: false,
        }))
    }

    fn start(&self, words: &[String], said: &Path) -> Result<Child, Problem> {
        let unwritable = |error: std::io::Error| Problem::cannot_write(said, &error);
        let output = File::create(said).map_err(unwritable)?;
        let errors = output.try_clone().map_err(unwritable)?;
        let mut command = Command::new(&words[0]);
        command
            .args(&words[1..])
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(errors)
            // Ctrl-C is for us; we end what we have started.
            .process_group(0);
        command.spawn().map_err(|error| {
            Problem::new(
                "episode-failed",
                format!("`{}` cannot be started: {error}", words[0]),
            )
            .remedy("check `command` in the ledger; it runs in the study's folder")
        })
    }

    /// A recording as a trace of the signals that are wanted.
    pub fn trace(&self, wanted: &[String], path: &Path) -> Result<Trace, Problem> {
        self.rules.trace(wanted, path)
    }

    /// How its recordings are read.
    pub fn rules(&self) -> &ReadingRules {
        &self.rules
    }
}

/// What a command said last.
fn last_words(said: &Path) -> String {
    let text = std::fs::read(said).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().collect();
    let last = &lines[lines.len().saturating_sub(SHOWN_LINES)..];
    match last.is_empty() {
        true => "; it said nothing".to_owned(),
        false => format!("; it said last\n    {}", last.join("\n    ")),
    }
}

/// Where this process works. What an earlier one may still be writing does not get in its way.
fn work_in(folder: &Path) -> PathBuf {
    folder.join(WORK).join(std::process::id().to_string())
}

/// The stimulus of a campaign, for its command, which runs in another folder.
pub fn stimulus_in(folder: &Path) -> Result<PathBuf, Problem> {
    let folder =
        std::fs::canonicalize(folder).map_err(|error| Problem::cannot_read(folder, &error))?;
    Ok(work_in(&folder).join("stimulus.json"))
}

fn stimulus_of(path: &Path, source: &Source) -> Result<Stimulus, Problem> {
    Stimulus::read(path, &source.text).map_err(|error| {
        Problem::new("bad-stimulus", format!("{}: {error}", source.name))
            .remedy("a stimulus has a `test` with `name` and `actions`, and `settings`")
    })
}

/// A process that is ended, with those that it started, if it is no longer waited for.
struct Running(Child);

impl Running {
    /// How it ended; `None` if it did not within `limit`.
    fn wait(mut self, limit: Duration, interrupt: &Cancel) -> Result<Option<ExitStatus>, Problem> {
        let began = Instant::now();
        loop {
            match self.0.try_wait() {
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

    fn signal(&self, signal: rustix::process::Signal) {
        let id = i32::try_from(self.0.id()).ok();
        if let Some(group) = id.and_then(rustix::process::Pid::from_raw) {
            let _ = rustix::process::kill_process_group(group, signal);
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(Some(_))) {
            return;
        }
        self.signal(rustix::process::Signal::TERM);
        let asked = Instant::now();
        while asked.elapsed() < GRACE {
            if matches!(self.0.try_wait(), Ok(Some(_))) {
                break;
            }
            std::thread::sleep(LOOK);
        }
        self.signal(rustix::process::Signal::KILL);
        let _ = self.0.wait();
    }
}
