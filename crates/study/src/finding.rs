//! A finding: one episode that showed something, as a file from which it can
//! be run again, made smaller, and kept as a test.
//!
//! ```toml
//! format = "1.0"
//! found_by = "random tests, boundary values"
//! program = "0.1.0"
//! seed = "17263545121"
//! expected = "fails"
//!
//! [bench]
//! evidence = "E2"
//! scenario = "simulation/scenario.toml"
//! parameters = "simulation/untuned.toml"
//!
//! [shows]
//! violated = "8"
//!
//! [test]
//! name = "typical use"
//! actions = [
//!   { send_signal = "activate", after_secs = 0.5 },
//! ]
//!
//! [settings]
//! "parameters.hand.friction" = 0.28
//! ```
//!
//! From `[test]` on it is the file of a stimulus, as an outside command gets
//! it. The seed is a text, since programs read numbers beyond 2^53 wrongly.

use crate::PhysicsEngine;
use crate::placed::value_place;
use diagnostic::{Problem, Source};
use evidence::FailureKind;
use host::files::write_whole;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::fmt::Write as _;
use std::path::Path;
use stimulus::{AbstractTest, Settings, Stimulus};

/// The version of the file's form.
pub const FORMAT: &str = "1.1";

/// The forms that are read; before 1.1 a finding was always expected to fail.
const READ: [&str; 2] = ["1.0", FORMAT];

/// One episode that showed something.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// By what it was found, in words.
    pub found_by: String,
    /// The version of the program that found it.
    pub program: String,
    /// The episode's seed.
    pub seed: u64,
    /// What was run.
    pub bench: BenchFiles,
    /// What the episode shows.
    pub shows: Shows,
    /// Whether it is expected to show it still.
    pub expected: Expected,
    /// BLAKE3 of the episode's whole recording as MCAP, if it is known.
    pub recording: Option<String>,
    /// What was done to the bench.
    pub stimulus: Stimulus,
}

/// What was run: the ledger's entry, and the files, relative to the study,
/// that it named then.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BenchFiles {
    /// The ledger's entry.
    pub evidence: String,
    /// The handover's scenario.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scenario: Option<String>,
    /// The handover's parameter set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<String>,
    /// The file of a scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// The physics engine of a scene or of the handover; MuJoCo, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<PhysicsEngine>,
    /// When the episode is ended, in whole seconds, since what it shows is
    /// decided by then; it runs to its own end if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until_secs: Option<u32>,
}

/// What a regression is expected to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Expected {
    /// It shows what it did: the fault is known and still there.
    #[default]
    Fails,
    /// It no longer shows it: the fault was fixed and must not come back.
    Passes,
}

impl Expected {
    /// As a file has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fails => "fails",
            Self::Passes => "passes",
        }
    }
}

/// What an episode shows.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shows {
    /// This requirement is violated.
    Violated(String),
    /// This failure mode occurs.
    FailureMode(String),
    /// The robot's program or the simulator ends the episode by failing.
    Failed(FailureKind),
    /// Behaviour that a formal model does not have.
    Unknown(UnknownStep),
}

/// A step of an abstracted recording that the formal model does not have.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnknownStep {
    /// The file of the exploration, relative to the study, that says how
    /// recordings are abstracted.
    pub exploration: String,
    /// The propositions that held before, separated by blanks.
    pub from: String,
    /// Those that held after; absent if the recording ended before, where the
    /// model always goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
}

/// The JSON Schema of a finding or regression.
pub(crate) fn schema() -> schemars::Schema {
    schemars::schema_for!(Text)
}

impl Shows {
    /// How much it matters: what matters more comes first.
    pub fn rank(&self) -> u8 {
        match self {
            Self::Violated(_) => 0,
            Self::FailureMode(_) => 1,
            Self::Failed(FailureKind::ControllerFailed | FailureKind::ControllerHung) => 2,
            Self::Unknown(_) => 3,
            Self::Failed(FailureKind::SimulatorFailed | FailureKind::SimulatorHung) => 4,
        }
    }

    /// Whether the simulator failed, which says nothing of the robot.
    pub fn is_of_simulator(&self) -> bool {
        matches!(
            self,
            Self::Failed(FailureKind::SimulatorFailed | FailureKind::SimulatorHung)
        )
    }
}

impl fmt::Display for Shows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Violated(id) => write!(f, "requirement {id} is violated"),
            Self::FailureMode(id) => write!(f, "failure mode {id}"),
            Self::Failed(kind) => write!(f, "{kind}"),
            Self::Unknown(step) => write!(f, "unknown behaviour: {step}"),
        }
    }
}

impl fmt::Display for UnknownStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.to {
            Some(to) => write!(f, "{{{}}} to {{{to}}}", self.from),
            None => write!(f, "the run ends in {{{}}}", self.from),
        }
    }
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    /// The version of this file's form.
    format: String,
    /// What found it.
    found_by: String,
    /// The version of the program that found it.
    program: String,
    /// The seed of the episode, as a text since it may be larger than TOML's whole numbers.
    seed: String,
    /// What `replay --check` expects of it: `fails` until the fault is fixed, `passes` from then on.
    #[serde(default)]
    expected: Expected,
    /// What was run.
    bench: BenchFiles,
    /// What the episode shows.
    shows: Shows,
    /// BLAKE3 of its whole recording as MCAP.
    #[serde(default)]
    recording: Option<String>,
    /// What was done.
    test: AbstractTest,
    /// What the data was set to, by dotted key.
    #[serde(default)]
    settings: Settings,
}

/// The part of the file before the stimulus.
#[derive(Serialize)]
struct Head<'a> {
    format: &'a str,
    found_by: &'a str,
    program: &'a str,
    seed: String,
    expected: Expected,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a str>,
    bench: &'a BenchFiles,
    shows: &'a Shows,
}

impl Finding {
    /// Reads a finding's file.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        Self::parse(&host::files::read_source(path)?)
    }

    fn parse(source: &Source) -> Result<Self, Problem> {
        let text: Text = crate::toml_text::read("bad-finding", source)?;
        let bad = |word: &str, message: String| {
            Problem::new("bad-finding", message)
                .at(source, value_place(source, &[word]))
                .remedy("`corroborate explore` writes findings; a regression has the same form")
        };
        if !READ.contains(&text.format.as_str()) {
            let message = format!("the format `{}` is not known", text.format);
            return Err(
                bad("format", message).remedy(format!("this program reads {}", READ.join(" and ")))
            );
        }
        let seed = text.seed.parse().map_err(|_| {
            bad(
                "seed",
                format!("`seed` must be a whole number (got `{}`)", text.seed),
            )
            .remedy("a seed is a whole number from 0 to 2^64 - 1, in quotes")
        })?;
        let stimulus = Stimulus {
            test: text.test,
            settings: text.settings,
        };
        stimulus
            .test
            .check()
            .map_err(|error| bad("test", error.to_string()))?;
        Ok(Self {
            found_by: text.found_by,
            program: text.program,
            seed,
            bench: text.bench,
            shows: text.shows,
            expected: text.expected,
            recording: text.recording,
            stimulus,
        })
    }

    /// The file's text; `comment` goes before it, each line behind a `#`.
    pub fn to_toml(&self, comment: &str) -> Result<String, Problem> {
        let mut text = String::new();
        for line in comment.lines() {
            let _ = writeln!(text, "{}", format!("# {line}").trim_end());
        }
        let head = Head {
            format: FORMAT,
            found_by: &self.found_by,
            program: &self.program,
            seed: self.seed.to_string(),
            expected: self.expected,
            recording: self.recording.as_deref(),
            bench: &self.bench,
            shows: &self.shows,
        };
        let head = toml::to_string(&head)
            .map_err(|error| Problem::new("cannot-write", format!("the finding: {error}")))?;
        text.push_str(&head);
        text.push('\n');
        text.push_str(&self.stimulus.to_toml());
        Ok(text)
    }

    /// Says in a finding's file what is expected of it, and leaves all else as it is.
    pub fn expect(path: &Path, expected: Expected) -> Result<(), Problem> {
        let source = host::files::read_source(path)?;
        let mut wanted = Self::parse(&source)?;
        wanted.expected = expected;
        let text = with_expected(&source.text, expected);
        let written = Source {
            name: source.name.clone(),
            text,
        };
        if Self::parse(&written).ok().as_ref() != Some(&wanted) {
            let message = format!("{}: the line of `expected` is not found", source.name);
            return Err(Problem::new("cannot-write", message).remedy(format!(
                "write `expected = \"{}\"` there by hand",
                expected.name()
            )));
        }
        host::files::write_text(path, &written.text, path)
    }

    /// Writes the finding's file.
    pub fn write(&self, path: &Path, comment: &str) -> Result<(), Problem> {
        write_whole(path, self.to_toml(comment)?.as_bytes())
    }
}

/// A finding's text with what is expected of it: in the line that says so, or before the first table.
fn with_expected(text: &str, expected: Expected) -> String {
    let line = format!("expected = \"{}\"", expected.name());
    let key = |it: &str| {
        it.split('=')
            .next()
            .is_some_and(|key| key.trim() == "expected")
    };
    let is_table = |it: &&str| it.trim_start().starts_with('[');
    let head = text.lines().take_while(|it| !is_table(it)).count();
    let place = text.lines().take(head).position(key);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    match place {
        Some(place) => lines[place] = line,
        None => {
            // The head ends with what it has, and not with the lines between it and the table.
            let before = lines[..head].iter().rposition(|it| !it.trim().is_empty());
            lines.insert(before.map_or(0, |at| at + 1), line);
        }
    }
    // Files of this program were written in the form before.
    for it in lines.iter_mut().take(head) {
        if it.trim() == "format = \"1.0\"" {
            *it = format!("format = \"{FORMAT}\"");
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use stimulus::{Action, Distribution};

    fn finding(shows: Shows) -> Finding {
        let action = Action::set("gaze", true).after(Distribution::Constant(0.25));
        let mut stimulus = Stimulus::of(AbstractTest::new("a \"test\"", vec![action]));
        stimulus.settings.insert("p.mass_kg".into(), 0.1.into());
        Finding {
            found_by: "random".into(),
            program: "0.1.0".into(),
            seed: u64::MAX,
            bench: BenchFiles {
                evidence: "E2".into(),
                scenario: Some("s.toml".into()),
                until_secs: Some(12),
                ..BenchFiles::default()
            },
            shows,
            expected: Expected::Fails,
            recording: None,
            stimulus,
        }
    }

    fn parsed(text: &str) -> Result<Finding, Problem> {
        Finding::parse(&Source {
            name: "f.toml".into(),
            text: text.into(),
        })
    }

    #[test]
    fn what_is_written_is_read_back() {
        let step = |to: Option<&str>| {
            Shows::Unknown(UnknownStep {
                exploration: "exploration.toml".into(),
                from: "held".into(),
                to: to.map(str::to_owned),
            })
        };
        let all = [
            Shows::Violated("8".into()),
            Shows::FailureMode("grip".into()),
            Shows::Failed(FailureKind::ControllerHung),
            step(None),
            step(Some("")),
        ];
        for shows in all {
            let finding = finding(shows);
            let text = finding.to_toml("found\nin vain").unwrap();
            assert!(text.starts_with("# found\n# in vain\n"), "{text}");
            assert_eq!(parsed(&text).unwrap(), finding, "{text}");
        }
    }

    #[test]
    fn what_is_expected_is_written_into_a_file_and_the_rest_is_left() {
        let folder = std::env::temp_dir().join(format!("expected-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("f.toml");
        let now = finding(Shows::Violated("8".into()))
            .to_toml("my note")
            .unwrap();
        // As it was written before there was the key.
        let before = now
            .replace("expected = \"fails\"\n", "")
            .replace("\"1.1\"", "\"1.0\"");
        assert!(!before.contains("expected"));
        for text in [&now, &before] {
            std::fs::write(&path, text).unwrap();
            Finding::expect(&path, Expected::Passes).unwrap();
            assert_eq!(Finding::read(&path).unwrap().expected, Expected::Passes);
            Finding::expect(&path, Expected::Fails).unwrap();
            let again = std::fs::read_to_string(&path).unwrap();
            assert!(again.starts_with("# my note\n") && again.contains("expected = \"fails\"\n"));
            let mut lines: Vec<&str> = again.lines().collect();
            let mut expected: Vec<&str> = now.lines().collect();
            lines.sort_unstable();
            expected.sort_unstable();
            assert_eq!(lines, expected);
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_finding_that_cannot_be_used_is_refused_with_its_place() {
        let good = finding(Shows::Violated("8".into())).to_toml("").unwrap();
        let broken = [
            (good.replace("\"1.1\"", "\"9\""), "format `9`"),
            (good.replace("\"fails\"", "\"fail\""), "fail"),
            (
                good.replace("18446744073709551615", "-1"),
                "`seed` must be a whole number (got `-1`)",
            ),
            (good.replace("violated", "vilated"), "vilated"),
            (good.replace("0.25", "-0.25"), "after_secs"),
        ];
        for (text, expected) in broken {
            let shown = parsed(&text).unwrap_err().to_string();
            assert!(shown.contains(expected), "{shown}");
            assert!(shown.contains("f.toml:"), "{shown}");
        }
    }
}
