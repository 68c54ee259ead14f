//! Campaigns: many episodes of one bench, judged while they run, counted as they come.
//!
//! An episode is known by its number; its seed follows from the study's seed, the evidence's
//! identifier and that number. Episodes run on all cores and are taken in the order of their
//! numbers, so that counts, the journal, and the episode at which a stopping rule ends it are the
//! same at any number of threads. What is judged stands in a journal, so that an interrupted
//! campaign goes on where it stopped.

mod again;
mod driver;
mod ended;
mod estimates;
mod failing;
mod left;
mod merged;
mod mishaps;
mod one;
mod online;
mod ordered;
mod record;
mod recount;
mod table;
mod tally;
mod took;
mod until;
mod watched;

pub use again::{Again, Sampled, again};
pub use driver::{Campaigning, Finished};
pub use ended::{
    Ended, FailureCounts, ended, failure_of, in_words as failures_in_words, never_worked, stops,
};
pub use estimates::estimates;
pub use failing::{is_of_physics, kind_of, words_of};
pub use left::judge_left;
pub use merged::{TakenOver, numbers_of};
pub use mishaps::Mishaps;
pub use online::OnLine;
pub(crate) use ordered::in_order;
pub use recount::{form_verdicts, journal_of, records_judged_by, recount};
pub use tally::{Intervals, Tally, anytime, monitors};
pub use until::{Until, parse as parse_until};

use crate::technique::Produced;
use diagnostic::Problem;
use evidence::DescriptionGap;
use host::store::Inputs;
use judging::inputs_of;
use rig::Rig;
use study::{Entry, Simulated, Study};

/// What the recordings of an entry's episodes depend on. Another simulator runs the same whichever build of this program
/// calls it.
pub fn episode_inputs(study: &Study, entry: &Entry, rig: &dyn Rig, program: &str) -> Inputs {
    let mut inputs = Inputs::default();
    rig.own_inputs(&mut inputs);
    if !rig.is_outside() {
        inputs.add("program", program.as_bytes());
    }
    inputs
        .add("seed", &study.about.seed.to_le_bytes())
        .add("evidence", entry.seeded_as().as_bytes());
    if entry.sampling.early_end {
        inputs.add_json("early_end", &true);
    }
    inputs
}

/// The hash of all that judging the episodes of a rig depends on.
pub fn judged_by(study: &Study, rig: &dyn Rig, program: &str) -> String {
    let mut inputs = Inputs::default();
    inputs.add("program", program.as_bytes());
    inputs_of(study, &mut inputs);
    rig.reading_inputs(&mut inputs);
    inputs.hash()
}

impl Campaigning<'_> {
    /// What was not simulated as it is described, and what went otherwise than it is meant to.
    pub fn gaps(&self, finished: &Finished) -> Vec<DescriptionGap> {
        let mut gaps = self.rig.gaps().to_vec();
        let entry = self.study.entry(self.id).ok();
        let mut scene = self.id.to_owned();
        if let Some(Simulated::Scene { scene: path, .. }) = entry.and_then(|it| it.work.simulated())
        {
            scene = path.display().to_string();
        }
        gaps.extend(finished.mishaps.gaps(&scene));
        gaps
    }

    /// Runs it; gives what it shows.
    pub fn produce(&self) -> Result<Produced, Problem> {
        let finished = self.run()?;
        let mut tool = self.rig.tool();
        let description_gaps = self.gaps(&finished);
        if self.early_end {
            tool.settings
                .push_str("; an episode ends once all is decided");
        }
        if let Some(stopped) = &finished.stopped {
            tool.settings.push_str("; ");
            tool.settings.push_str(stopped);
        }
        Ok(Produced {
            tool,
            findings: finished.tally.findings(self.study, finished.intervals)?,
            form_differences: finished.form_differences,
            description_gaps,
            failures: finished.tally.failures(self.study, finished.intervals)?,
            clusters: None,
            alike_trials: None,
            repeated_recordings: Vec::new(),
            findings_once: Vec::new(),
            influences: Vec::new(),
            cost: finished.cost,
        })
    }
}
