//! `corroborate replay`: one episode run again, bit for bit, as recording,
//! verdicts and a 3D page; or all regressions, as tests.

mod check;
pub mod episode;
mod scene;
mod shown;

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Replay};
use corroborate::outcome::Outcome;
use corroborate::technique::campaign::kind_of;
use corroborate::technique::exploration::ShowsJudge;
use diagnostic::Problem;
use episode::{Episode, failed, hash_of_trace};
use evidence::FailureKind;
use host::files::write_whole;
use judging::verdict_name;
use report::replay::Replay as Page;
use schemars::JsonSchema;
use serde::Serialize;
use shown::Judged;
use std::path::{Path, PathBuf};
use stimulus::Distribution;
use study::Study;
use testbench::{Recorded, ViewKeeper};

/// What `replay --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ReplayReport {
    /// Version of this form.
    pub format: String,
    /// The episode.
    pub episode: String,
    /// Its seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// What of the robot's program or the simulator ended it, if it did not end by itself.
    pub failed: Option<FailureKind>,
    /// What the program said then.
    pub said: Option<String>,
    /// What it showed, in words, if that is why it was replayed.
    pub shows: Option<String>,
    /// Whether it shows it again.
    pub shown: Option<bool>,
    /// BLAKE3 of the recording.
    pub recording: String,
    /// Whether that is the same as before; absent where that is not known.
    pub same_bytes: Option<bool>,
    /// What each requirement's monitor says.
    pub verdicts: Vec<VerdictReport>,
    /// What was written.
    pub files: Vec<String>,
}

/// What a requirement's monitor says.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictReport {
    /// The requirement or failure mode.
    pub subject: String,
    /// The verdict.
    pub verdict: String,
    /// Why, in sentences.
    pub reasons: Vec<String>,
}

/// Replays.
pub fn replay(arguments: &Replay, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    if arguments.check {
        return check::check(&study, arguments, setting);
    }
    let [what] = arguments.what.as_slice() else {
        return Err(
            Problem::new("one-at-a-time", "one episode is replayed at a time")
                .remedy("name one, or run all regressions with --check"),
        );
    };
    if let Some(id) = arguments
        .only
        .iter()
        .find(|id| study.forms.by_id(id).is_none())
    {
        let message = format!("requirements.toml does not declare `{id}`");
        return Err(Problem::new("unknown-subject", message).remedy("check the identifier"));
    }
    let library = setting.physics_library.as_deref();
    let (episode, bench) = Episode::named(&study, what, library)?;
    let judge = match &episode.shows {
        Some(shows) => Some(ShowsJudge::new(&study, shows, &setting.cancel)?),
        None => None,
    };
    if bench.is_outside() {
        setting
            .events
            .say("another simulator shows no bodies: the page has signals and verdicts only");
    }
    let mut keeper = ViewKeeper::default();
    let stage = setting.events.begin("replaying", 1);
    let recorded = episode
        .run(&bench, Some(&mut keeper), &setting.cancel)
        .map_err(|error| failed(&error))?;
    stage.advance();
    drop(stage);
    let shown = match &judge {
        Some(judge) => Some(judge.shows(&recorded)?),
        None => None,
    };
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => study.folder.join("results/replays").join(&episode.name),
    };
    let replayed = Replayed {
        judged: shown::judge(&study, &recorded.trace)?,
        study: &study,
        engine: &bench.engine,
        episode,
        recorded,
        seen: keeper,
        shown,
    };
    replayed.finish(arguments, &folder)
}

/// An episode that was run again, with all that was found.
struct Replayed<'a> {
    study: &'a Study,
    engine: &'a str,
    episode: Episode,
    recorded: Recorded,
    seen: ViewKeeper,
    judged: Judged<'a>,
    shown: Option<bool>,
}

impl Replayed<'_> {
    fn finish(&self, arguments: &Replay, folder: &Path) -> Result<Done, Problem> {
        let (hash, bytes) = hash_of_trace(&self.recorded.trace)?;
        let same_bytes = self.episode.recording.as_ref().map(|known| known == &hash);
        let page = self.page(&arguments.only, &hash)?;
        let files = [
            ("replay.html", report::replay::html(&page).into_bytes()),
            ("recording.mcap", bytes),
            ("verdicts.mcap", self.judged.over_time.clone()),
            ("scene.mcap", scene::of_foxglove(&self.seen)?),
        ];
        let mut written: Vec<PathBuf> = Vec::new();
        for (name, content) in &files {
            let path = folder.join(name);
            write_whole(&path, content)?;
            written.push(path);
        }
        let report = self.report(hash, same_bytes, &written);
        Ok(Done {
            output: match arguments.format {
                Format::Json => json(&report)?,
                Format::Text => as_text(&report),
            },
            outcome: match (self.shown, same_bytes) {
                (Some(false), _) => Outcome::Violated,
                (_, Some(false)) => Outcome::DataLost,
                _ => Outcome::Holds,
            },
        })
    }

    fn report(
        &self,
        recording: String,
        same_bytes: Option<bool>,
        files: &[PathBuf],
    ) -> ReplayReport {
        let verdicts = self
            .judged
            .judgements
            .iter()
            .map(|judgement| VerdictReport {
                subject: judgement.subject.id().to_owned(),
                verdict: verdict_name(judgement.findings.verdict).to_owned(),
                reasons: shown::reasons(judgement),
            });
        ReplayReport {
            format: "1.1".into(),
            episode: self.episode.name.clone(),
            seed: self.episode.seed.to_string(),
            failed: self.recorded.failure.as_ref().map(kind_of),
            said: self.recorded.failure.as_ref().map(|it| it.words.clone()),
            shows: self.episode.shows.as_ref().map(ToString::to_string),
            shown: self.shown,
            recording,
            same_bytes,
            verdicts: verdicts.collect(),
            files: files.iter().map(|it| it.display().to_string()).collect(),
        }
    }

    fn page(&self, only: &[String], hash: &str) -> Result<Page, Problem> {
        let (study, trace, judged) = (self.study, &self.recorded.trace, &self.judged);
        let shows = self.episode.shows.as_ref();
        let ids = shown::chosen(only, shows, judged);
        let title = match shows {
            Some(shows) => capitalised(&shows.to_string()),
            None => capitalised(&self.episode.origin),
        };
        Ok(Page {
            title,
            summary: study.about.title.clone(),
            facts: self.facts(hash),
            actions: actions(&self.episode),
            verdicts: shown::verdicts(study, judged, &ids),
            marks: shown::marks(study, trace, judged, &ids)?,
            signals: shown::signals(study, shows, trace, judged, &ids)?,
            scene: scene::of_page(&self.seen),
            produced_by: format!("corroborate {}", env!("CARGO_PKG_VERSION")),
        })
    }

    fn facts(&self, hash: &str) -> Vec<(String, String)> {
        let episode = &self.episode;
        let mut facts = vec![
            ("Found by", episode.origin.clone()),
            ("Evidence", episode.bench.evidence.clone()),
            ("Seed", episode.seed.to_string()),
            ("Physics", self.engine.to_owned()),
            ("Simulated", format!("{:.2} s", self.recorded.sim_secs)),
            (
                "Recording",
                format!("BLAKE3 {}", hash.get(..16).unwrap_or(hash)),
            ),
        ];
        if let Some(failure) = &self.recorded.failure {
            facts.push(("Ended by", kind_of(failure).to_string()));
        }
        if let Some(shown) = self.shown {
            let again = if shown { "yes" } else { "no" };
            facts.insert(0, ("Shown again", again.to_owned()));
        }
        let facts = facts
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value));
        facts.collect()
    }
}

/// The actions and settings of an episode, in words.
fn actions(episode: &Episode) -> Vec<String> {
    let test = episode.stimulus.test.actions.iter().map(|action| {
        let verb = action.verb.to_string();
        match &action.after_secs {
            Distribution::Constant(0.0) => verb,
            Distribution::Constant(secs) => format!("{verb}, {secs} s after the action before"),
            _ => format!("{verb}, after a random time"),
        }
    });
    let settings = episode.stimulus.settings.iter();
    let settings = settings.map(|(key, value)| format!("with {key} = {value}"));
    test.chain(settings).collect()
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

fn as_text(report: &ReplayReport) -> String {
    let mut text = format!("{}, seed {}\n", report.episode, report.seed);
    if let (Some(shows), Some(shown)) = (&report.shows, report.shown) {
        let again = if shown {
            "shown again"
        } else {
            "NOT SHOWN AGAIN"
        };
        text.push_str(&format!("{again}: {shows}\n"));
    }
    text.push_str(match report.same_bytes {
        Some(true) => "the recording is the same, bit for bit\n",
        Some(false) => "THE RECORDING IS NOT THE SAME as before\n",
        None => "no earlier recording is known to compare with\n",
    });
    if let Some(kind) = report.failed {
        text.push_str(&format!("ended by: {kind}\n"));
        for line in report.said.iter().flat_map(|said| said.lines()) {
            text.push_str(&format!("    {line}\n"));
        }
    }
    for verdict in report
        .verdicts
        .iter()
        .filter(|it| it.verdict != "not-covered")
    {
        text.push_str(&format!("{:<28} {}\n", verdict.subject, verdict.verdict));
        if verdict.verdict == "violated" {
            for reason in &verdict.reasons {
                text.push_str(&format!("    {reason}\n"));
            }
        }
    }
    for file in &report.files {
        text.push_str(&format!("{file}\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(ReplayReport).into();
        crate::command::tests::assert_schema_is_committed("replay.schema.json", &schema);
    }
}
