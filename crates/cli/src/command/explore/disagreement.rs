//! `corroborate explore --disagreement`: where formal model and bench part.

use crate::args::Format;
use crate::command::{Done, Host, json};
use corroborate::outcome::Outcome;
use corroborate::technique::asset;
use corroborate::technique::exploration::{
    Disagreement, Episodes, Journal, Known, OpenBench, Plan, disagreement_text,
};
use diagnostic::Problem;
use evidence::{DisagreementMap, SearchEnd};
use host::files::write_whole;
use std::path::{Path, PathBuf};
use study::Study;

/// The file of the map, in the folder of an exploration.
const DISAGREEMENT: &str = "disagreement.json";
/// The folder of its journal there.
const JOURNAL: &str = "disagreement";

/// What is searched.
pub struct Search<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan,
    pub bench: &'a OpenBench,
    pub folder: &'a Path,
}

impl Search<'_> {
    /// Searches, and writes what was found.
    pub fn done(&self, format: Format, setting: &Host) -> Result<Done, Problem> {
        let journal = Journal::open(
            &self.folder.join(JOURNAL),
            &self.looked_at_by(&setting.build)?,
        )?;
        let report = self.map(Episodes::Journal(&journal), setting)?;
        let path = self.folder.join(DISAGREEMENT);
        write_whole(&path, json(&report)?.as_bytes())?;
        setting
            .events
            .say(&format!("{} is written", path.display()));
        Ok(Done {
            output: match format {
                Format::Json => json(&report)?,
                Format::Text => disagreement_text(&report),
            },
            outcome: outcome(&report),
        })
    }
}

impl Search<'_> {
    fn map(&self, episodes: Episodes<'_>, setting: &Host) -> Result<DisagreementMap, Problem> {
        let search = Disagreement::new(
            self.study,
            self.plan,
            self.bench,
            super::assets_of(self.study, self.plan, true)?,
            &setting.cancel,
        )?;
        let title = "looking for disagreement";
        let stage = setting.events.begin(title, search.episodes());
        search.run(self.plan, episodes, &stage)
    }

    fn looked_at_by(&self, build: &host::BuildId) -> Result<String, Problem> {
        Ok(super::inputs_of_all(self.study, self.plan, self.bench, build)?.hash())
    }
}

/// The map's file beside these results.
pub fn map_file(results: &Path) -> PathBuf {
    results.join("exploration").join(DISAGREEMENT)
}

/// A map once more, by the same search: from the journal of its episodes, or by running all of them.
/// `None` if there is no journal of this program and these inputs.
pub fn map_again(
    study: &Study,
    map: &DisagreementMap,
    results: &Path,
    runs: bool,
    setting: &Host,
) -> Result<Option<DisagreementMap>, Problem> {
    let mut study = Study::load(&study.folder)?;
    study.about.seed = map.seed;
    let mut plan = Plan::load(&study.folder, Path::new(&map.plan))?;
    if let Some(disagreement) = &mut plan.data.disagreement {
        disagreement.episodes = map.budget;
    }
    let entry = study.entry(plan.evidence(true))?;
    let bench = OpenBench::of_entry(&study, entry, setting.physics_library.as_deref())?;
    let folder = results.join("exploration");
    let search = Search {
        study: &study,
        plan: &plan,
        bench: &bench,
        folder: &folder,
    };
    if runs {
        return search.map(Episodes::Anew, setting).map(Some);
    }
    match Known::of(&folder.join(JOURNAL), &search.looked_at_by(&setting.build)?) {
        Some(known) => search.map(Episodes::Known(&known), setting).map(Some),
        None => Ok(None),
    }
}

/// The map of an exploration beside these results, if one was made of these very assets.
pub fn kept_map(study: &Study, results: &Path) -> Result<Option<DisagreementMap>, Problem> {
    let path = map_file(results);
    let Ok(bytes) = std::fs::read(&path) else {
        return Ok(None);
    };
    let map: DisagreementMap = serde_json::from_slice(&bytes).map_err(|error| {
        Problem::new("bad-result", format!("{}: {error}", path.display()))
            .remedy("run corroborate explore --disagreement again, or remove the file")
    })?;
    for of in &map.assets {
        if asset(&study.folder, of.role, Path::new(&of.path))? != *of {
            let message = format!("{} is of another {}", path.display(), of.path);
            return Err(Problem::new("stale-result", message)
                .remedy("run corroborate explore --disagreement again, or remove the file"));
        }
    }
    Ok(Some(map))
}

fn outcome(report: &DisagreementMap) -> Outcome {
    match report.ended {
        SearchEnd::Interrupted => Outcome::Interrupted,
        _ if report.shares.differs > 0.0 => Outcome::Violated,
        SearchEnd::Decided => Outcome::Holds,
        SearchEnd::Budget => Outcome::Inconclusive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_written() {
        let schema: serde_json::Value = schemars::schema_for!(DisagreementMap).into();
        crate::command::tests::assert_schema_is_committed("disagreement.schema.json", &schema);
    }
}
