//! Campaigns: many episodes of one bench, judged while they run, counted as they come.
//!
//! An episode is known by its number; its seed follows from the study's seed, the evidence's
//! identifier and that number. Episodes run on all cores and are taken in the order of their
//! numbers, so that counts, the journal, and the episode at which a stopping rule ends it are the
//! same at any number of threads. What is judged stands in a journal, so that an interrupted
//! campaign goes on where it stopped.

mod driver;
mod ended;
mod estimates;
mod failing;
mod one;
mod online;
mod ordered;
mod outside;
mod record;
mod recount;
mod simulator;
mod table;
mod tally;
mod until;

pub use driver::{Campaigning, Finished, Source};
pub use ended::{
    Ended, FailureCounts, ended, failure_of, in_words as failures_in_words, never_worked, stops,
};
pub use estimates::estimates;
pub use failing::{is_of_physics, kind_of, words_of};
pub use online::OnLine;
pub use outside::{OutsideCommand, stimulus_in};
pub use recount::{form_verdicts, records_judged_by, recount};
pub use simulator::Simulator;
pub use tally::{Intervals, Tally, anytime, monitors};
pub use until::{Until, parse as parse_until};

use crate::technique::Produced;
use crate::technique::simulation::episode_name;
use diagnostic::Problem;
use evidence::{DescriptionGap, Tool};
use host::store::Inputs;
use judging::inputs_of;
use stimulus::Stimulus;
use study::{Entry, Study};

impl Source<'_> {
    /// What an episode depends on, besides its seed and this program.
    pub fn inputs(&self, inputs: &mut Inputs) {
        match self {
            Source::Bench(campaign) => campaign.inputs(inputs),
            Source::Command(command) => command.inputs(inputs),
        }
    }

    /// What judging its recordings depends on, besides the monitors.
    pub fn reading_inputs(&self, inputs: &mut Inputs) {
        match self {
            Source::Bench(_) => {}
            Source::Command(command) => command.reading_inputs(inputs),
        }
    }

    /// The name of an episode's recording.
    pub fn recording_name(&self, number: u64) -> String {
        match self {
            Source::Bench(_) => episode_name(number),
            Source::Command(command) => command.recording_name(number),
        }
    }

    /// What is done in each episode.
    pub fn stimulus(&self) -> &Stimulus {
        match self {
            Source::Bench(campaign) => campaign.stimulus(),
            Source::Command(command) => command.stimulus(),
        }
    }

    /// What of robots' descriptions is not simulated; a simulator that is a command tells nothing of it.
    pub fn gaps(&self) -> &[DescriptionGap] {
        match self {
            Source::Bench(campaign) => campaign.gaps(),
            Source::Command(_) => &[],
        }
    }

    /// The tool, and what can move a number.
    pub fn tool(&self) -> Tool {
        match self {
            Source::Bench(campaign) => campaign.tool(),
            Source::Command(command) => command.tool(),
        }
    }
}

/// What the recordings of an entry's episodes depend on. Another simulator runs the same whichever build of this program
/// calls it.
pub fn episode_inputs(study: &Study, entry: &Entry, source: Source<'_>, program: &str) -> Inputs {
    let mut inputs = Inputs::default();
    source.inputs(&mut inputs);
    if matches!(source, Source::Bench(_)) {
        inputs.add("program", program.as_bytes());
    }
    inputs
        .add("seed", &study.about.seed.to_le_bytes())
        .add("evidence", entry.id.as_bytes());
    if entry.sampling.early_end {
        inputs.add_json("early_end", &true);
    }
    inputs
}

/// The hash of all that judging the episodes of a source depends on.
pub fn judged_by(study: &Study, source: Source<'_>, program: &str) -> String {
    let mut inputs = Inputs::default();
    inputs.add("program", program.as_bytes());
    inputs_of(study, &mut inputs);
    source.reading_inputs(&mut inputs);
    inputs.hash()
}

impl Campaigning<'_> {
    /// Runs it; gives what it shows.
    pub fn produce(&self) -> Result<Produced, Problem> {
        let finished = self.run()?;
        let mut tool = self.source.tool();
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
            description_gaps: self.source.gaps().to_vec(),
            failures: finished.tally.failures(self.study, finished.intervals)?,
            clusters: None,
            alike_trials: None,
            influences: Vec::new(),
            cost: finished.cost,
        })
    }
}
