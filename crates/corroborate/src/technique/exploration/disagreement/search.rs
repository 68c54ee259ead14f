//! A search for disagreement with its journal in the folder of an exploration; the same search once more.

use super::{Disagreement, Episodes};
use crate::kept::exploration_folder;
use crate::technique::exploration::again::{assets_of, inputs_of_all};
use crate::technique::exploration::journal::{Journal, Known};
use crate::technique::exploration::{OpenBench, Plan};
use diagnostic::Problem;
use evidence::DisagreementMap;
use host::{BuildId, Host};
use std::path::Path;
use study::Study;

/// The folder of its journal, in the folder of an exploration.
const JOURNAL: &str = "disagreement";

/// What is searched.
pub struct MapSearch<'a> {
    /// The study.
    pub study: &'a Study,
    /// The plan of the exploration.
    pub plan: &'a Plan,
    /// What runs episodes.
    pub bench: &'a OpenBench,
    /// The folder of the exploration.
    pub folder: &'a Path,
}

impl MapSearch<'_> {
    /// Searches, or goes on where an interrupted search stopped.
    pub fn go_on(&self, host: &Host) -> Result<DisagreementMap, Problem> {
        let journal = Journal::open(&self.folder.join(JOURNAL), &self.looked_at_by(&host.build))?;
        self.map(Episodes::Journal(&journal), host)
    }

    fn map(&self, episodes: Episodes<'_>, host: &Host) -> Result<DisagreementMap, Problem> {
        let search = Disagreement::new(
            self.study,
            self.plan,
            self.bench,
            assets_of(self.study, self.plan, true)?,
            &host.cancel,
        )?;
        let title = "looking for disagreement";
        let stage = host.events.begin(title, search.episodes());
        search.run(self.plan, episodes, &stage)
    }

    fn looked_at_by(&self, build: &BuildId) -> String {
        inputs_of_all(self.study, self.plan, self.bench, build).hash()
    }
}

/// A map once more, by the same search: from the journal of its episodes, or by running all of them.
/// `None` if there is no journal of this program and these inputs.
pub fn map_again(
    study: &Study,
    map: &DisagreementMap,
    results: &Path,
    runs: bool,
    host: &Host,
) -> Result<Option<DisagreementMap>, Problem> {
    let mut study = Study::load_for(&study.folder, &host.trust)?;
    study.about.seed = map.seed;
    let mut plan = Plan::load(&study.folder, Path::new(&map.plan))?;
    if let Some(disagreement) = &mut plan.data.disagreement {
        disagreement.episodes = map.budget;
    }
    let entry = study.entry(plan.evidence(true))?;
    let bench = OpenBench::of_entry(&study, entry, host)?;
    let folder = exploration_folder(results);
    let search = MapSearch {
        study: &study,
        plan: &plan,
        bench: &bench,
        folder: &folder,
    };
    if runs {
        return search.map(Episodes::Anew, host).map(Some);
    }
    match Known::of(&folder.join(JOURNAL), &search.looked_at_by(&host.build)) {
        Some(known) => search.map(Episodes::Known(&known), host).map(Some),
        None => Ok(None),
    }
}
