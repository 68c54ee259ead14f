//! Other simulators and rigs as they are: a command that leaves a recording.
//!
//! For each episode the command of the ledger is run in the study's folder. Of its words
//! `{stimulus}` becomes the path of a JSON file with what is to be done (crate `stimulus`),
//! `{seed}` the episode's seed, a whole number below 2^64, and `{recording}` the path at which it
//! has to leave a recording, in any format that is read here. It has to end with code 0 within a
//! limit of real time. The recording is judged through the study's `topics.toml`. A persistent command
//! gets the same by a line on its input (`persistent.rs`).
//!
//! What of the stimulus is a distribution is drawn here, from the random stream of its key under the
//! episode's seed: as a scene draws, so that the same keys and seed are the same numbers in both.
//!
//! A command that fails or hangs is no error: it is what the episode shows, with what it left of a
//! recording. The recording is moved to its place once the command has ended, so that nothing writes
//! to what is there.

use super::once;
use super::persistent::{Episode, Pool, Program};
use crate::asset;
use crate::consent::Consent;
use diagnostic::{Problem, Source};
use evidence::{Asset, AssetRole, Tool};
use host::files::write_whole;
use host::store::Inputs;
use host::{Cancel, Host};
use judging::recording::ReadingRules;
use std::path::{Path, PathBuf};
use std::time::Duration;
use stimulus::{AbstractTest, Settings, Stimulus, VariedStimulus};
use study::{CommandText, Study};
use testbench::scene::drawn_number;
use testbench::{Drawn, Failure, Part};
use trace::Trace;

/// Where what is under way is kept; hidden, so that it is taken for no recording.
const WORK: &str = ".work";

/// A command that gives episodes.
pub struct OutsideCommand {
    words: Vec<String>,
    /// The study's folder.
    folder: PathBuf,
    stimulus: VariedStimulus,
    leaves: String,
    limit: Duration,
    /// The processes of a persistent command.
    pool: Option<Pool>,
    assets: Vec<Asset>,
    rules: ReadingRules,
    /// The topic map.
    map: String,
    /// That it may run, or why not.
    consent: Result<Consent, Problem>,
}

impl OutsideCommand {
    /// The command of a ledger's entry with everything that it names; `stimulus` stands in for the text of its stimulus. Where the
    /// user has not allowed it, it is opened all the same, and does not run.
    ///
    /// # Errors
    /// `cannot-read`, `bad-stimulus`, and what the topic map says wrong.
    pub fn new(
        study: &Study,
        text: &CommandText,
        stimulus: Option<&Source>,
        host: &Host,
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
            consent: Consent::to_command(study, &text.command, host),
            stimulus: match (&text.stimulus, stimulus) {
                (Some(path), Some(source)) => stimulus_of(path, source)?,
                (Some(path), None) => {
                    stimulus_of(path, &host::files::read_source(&study.folder.join(path))?)?
                }
                (None, _) => {
                    VariedStimulus::of(Stimulus::of(AbstractTest::new("as it is", Vec::new())))
                }
            },
            pool: text.persistent.then(Pool::default),
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
                "`{}`, {}; that a seed fixes its run is assumed, not checked",
                self.words.join(" "),
                match self.pool {
                    None => "each episode a process",
                    Some(_) => "many episodes a process",
                }
            ),
        }
    }

    /// Why it may not run, if so.
    pub fn obstacle(&self) -> Option<&Problem> {
        self.consent.as_ref().err()
    }

    /// The files on which it rests.
    pub fn assets(&self) -> &[Asset] {
        &self.assets
    }

    /// What is done in each episode, with what all of them have set to the same value.
    pub fn stimulus(&self) -> &Stimulus {
        &self.stimulus.fixed
    }

    /// All that its stimulus sets; of what is drawn the middle.
    pub(super) fn settings(&self) -> Settings {
        self.stimulus.at(&|_, from| from.quantile(0.5)).settings
    }

    /// What an episode's stimulus leaves to its seed; `None` if nothing of the ledger's stimulus is drawn.
    pub(super) fn drawn(&self, own: &Settings, seed: u64) -> Option<Vec<Drawn>> {
        let open = self.stimulus.varied.iter();
        let open = open.filter(|(key, _)| !own.contains_key(*key));
        let drawn = open.map(|(key, from)| Drawn {
            key: key.clone(),
            value: drawn_number(seed, key, from),
            middle: from.quantile(0.5),
        });
        (!self.stimulus.varied.is_empty()).then(|| drawn.collect())
    }

    /// What an episode is given: its own stimulus, and where it says nothing what the ledger's sets and draws.
    pub(super) fn given(&self, own: &Stimulus, seed: u64) -> Stimulus {
        let mut given = self.stimulus.at(&|key, from| drawn_number(seed, key, from));
        given.settings.extend(own.settings.clone());
        given.test = own.test.clone();
        given
    }

    /// What its episodes depend on, besides their seeds.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add_json("command", &self.words)
            .add("leaves", self.leaves.as_bytes())
            .add("stimulus", self.stimulus.to_json().as_bytes());
        if self.pool.is_some() {
            inputs.add("persistent", b"true");
        }
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
        Self::name_of_recording(&self.leaves, number)
    }

    /// The same of a command that leaves such recordings.
    pub fn name_of_recording(leaves: &str, number: u64) -> String {
        match leaves {
            "" => format!("episode-{number:05}"),
            extension => format!("episode-{number:05}.{extension}"),
        }
    }

    /// Makes room for work in `folder`. What an earlier call left there is removed.
    pub fn prepare(&self, folder: &Path) -> Result<(), Problem> {
        self.tidy(folder);
        let work = work_in(folder);
        std::fs::create_dir_all(&work).map_err(|error| Problem::cannot_write(&work, &error))
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

    /// Runs an episode, in a room that was prepared: `own` is its stimulus where that is another than the ledger's. Gives what
    /// went wrong, if it did not end well.
    pub fn run(
        &self,
        own: Option<&Stimulus>,
        seed: u64,
        recording: &Path,
        interrupt: &Cancel,
    ) -> Result<Option<Failure>, Problem> {
        let consent = self.consent.as_ref().map_err(Problem::clone)?;
        let given = self.given(own.unwrap_or(&self.stimulus.fixed), seed);
        let stimulus = beside(recording, "stimulus.json");
        write_whole(&stimulus, given.to_json().as_bytes())?;
        let failed = match &self.pool {
            None => self.run_once((&stimulus, seed, recording), consent, interrupt),
            Some(pool) => self.run_in(pool, (&stimulus, seed, recording), consent, interrupt),
        };
        Self::remove(&stimulus);
        Ok(failed?.map(|(is_hung, reason)| Failure {
            part: Part::Simulator,
            is_hung,
            words: format!("`{}`: {reason}", self.words.join(" ")),
            in_setup: false,
        }))
    }

    /// In a process of its own: whether it hung, and what went wrong.
    fn run_once(
        &self,
        (stimulus, seed, recording): (&Path, u64, &Path),
        consent: &Consent,
        interrupt: &Cancel,
    ) -> Result<Option<(bool, String)>, Problem> {
        let said = beside(recording, "said");
        let words = self.words.iter().map(|word| {
            word.replace("{stimulus}", &stimulus.to_string_lossy())
                .replace("{seed}", &seed.to_string())
                .replace("{recording}", &recording.to_string_lossy())
        });
        let words: Vec<String> = words.collect();
        let running = once::start(&words, &self.folder, &said, consent)?;
        let (is_hung, reason) = match running.wait(self.limit, interrupt)? {
            None => (
                true,
                format!("it did not end within {} s", self.limit.as_secs_f64()),
            ),
            Some(status) if !status.success() => (false, format!("it ended with {status}")),
            Some(_) if !recording.exists() => (
                false,
                format!("it ended well but {}", no_recording(recording)),
            ),
            Some(_) => {
                Self::remove(&said);
                return Ok(None);
            }
        };
        let reason = format!("{reason}{}", once::last_words(&said));
        Self::remove(&said);
        Ok(Some((is_hung, reason)))
    }

    /// In a process that has others, too.
    fn run_in(
        &self,
        pool: &Pool,
        (stimulus, seed, recording): (&Path, u64, &Path),
        consent: &Consent,
        interrupt: &Cancel,
    ) -> Result<Option<(bool, String)>, Problem> {
        let program = Program {
            words: &self.words,
            folder: &self.folder,
            limit: self.limit,
            consent,
        };
        let episode = Episode {
            stimulus,
            seed,
            recording,
        };
        Ok(match pool.run(&program, &episode, interrupt)? {
            Some(failed) => Some((failed.is_hung, failed.reason)),
            None if !recording.exists() => Some((
                false,
                format!("it said `recorded` but {}", no_recording(recording)),
            )),
            None => None,
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

/// A file of an episode, by its recording.
fn beside(recording: &Path, what: &str) -> PathBuf {
    let mut name = recording.as_os_str().to_owned();
    name.push(".");
    name.push(what);
    PathBuf::from(name)
}

fn no_recording(recording: &Path) -> String {
    format!("left no recording at `{}`", recording.display())
}

/// Where this process works. What an earlier one may still be writing does not get in its way.
fn work_in(folder: &Path) -> PathBuf {
    folder.join(WORK).join(std::process::id().to_string())
}

fn stimulus_of(path: &Path, source: &Source) -> Result<VariedStimulus, Problem> {
    VariedStimulus::read(path, &source.text).map_err(|error| {
        Problem::new("bad-stimulus", format!("{}: {error}", source.name)).remedy(
            "a stimulus has a `test` with `name` and `actions`, and `settings`: values, or numbers that vary such as `{ uniform = [0.2, 0.4] }`",
        )
    })
}
