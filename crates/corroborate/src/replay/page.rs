//! What the page of a replay shows.

use super::episode::Episode;
use super::{Page, Replayed, scene, shown};
use crate::technique::campaign::kind_of;
use diagnostic::Problem;
use stimulus::Distribution;

impl Replayed<'_> {
    /// The page, of the requirements and failure modes that are asked for.
    pub(super) fn page(&self, only: &[String], hash: &str) -> Result<Page, Problem> {
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
