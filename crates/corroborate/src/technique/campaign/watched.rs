//! Episodes that are judged while they run: of rigs whose physics are of this program.

use super::driver::hash_of_recording;
use super::failing::EpisodeFailure;
use super::one::{Bench, Recorder, shown};
use super::online::OnLine;
use super::record::EpisodeRecord;
use crate::technique::simulation::problem_at;
use diagnostic::Problem;
use host::files::write_whole;
use host::store::hash_of;
use rig::Rig;
use std::path::Path;
use testbench::{End, Recorded, SimError};
use trace::Trace;

/// Episodes of a rig that are watched.
pub(super) struct WatchedEpisodes<'a> {
    pub(super) rig: &'a dyn Rig,
    /// The topics of its recordings.
    pub(super) layout: Trace,
}

impl Recorder for WatchedEpisodes<'_> {
    /// Recordings are written whole at their place.
    fn prepare(&self, _: &Path) -> Result<(), Problem> {
        Ok(())
    }

    /// Read, if it was recorded, or run.
    fn episode(&self, bench: &Bench<'_>, number: u64) -> Result<(EpisodeRecord, bool), Problem> {
        if let Some(record) = self.judged_again(bench, number)? {
            return Ok((record, false));
        }
        let path = bench.plan.recording(number);
        let seed = bench.plan.seeds.of(number);
        let mut on_line = OnLine::new(
            &[&bench.main, &bench.of_forms],
            &self.layout,
            bench.plan.early_end,
        )?;
        let run = match self.run(bench, seed, &mut on_line) {
            Ok(run) => run,
            Err(error) => {
                let Some(failure) = EpisodeFailure::of_simulator(&error) else {
                    return Err(problem_at(seed, &error));
                };
                bench.meet(number, &failure, false)?;
                return Ok((bench.nothing_of(number, failure.kind), true));
            }
        };
        let failure = run.failure.as_ref().map(EpisodeFailure::of);
        if let (Some(failure), Some(of)) = (&failure, &run.failure) {
            bench.meet(number, failure, of.in_setup)?;
        }
        let judged = on_line.finish(run.trace.complete)?;
        let [main, of_forms] = [0, 1].map(|place| judged.get(place).map_or(&[][..], Vec::as_slice));
        let end = match (failure.as_ref(), run.end) {
            (Some(failure), _) => failure.kind.name(),
            (None, End::Watched) => "decided",
            _ if run.trace.complete => "complete",
            _ => "incomplete",
        };
        let secs = run.trace.end_secs().unwrap_or(0.0);
        let shown = shown(end, Some(secs), main, of_forms).with_mishaps(&run.trace);
        let mut record = bench.record(number, shown, None);
        if bench.is_to_be_kept(&record) {
            let bytes = recording::to_mcap(&run.trace)
                .map_err(|error| Problem::data_lost("cannot-record", error.to_string()))?;
            record.recording = Some(hash_of(&bytes));
            write_whole(&path, &bytes)?;
        }
        Ok((record, true))
    }

    fn judged_again(
        &self,
        bench: &Bench<'_>,
        number: u64,
    ) -> Result<Option<EpisodeRecord>, Problem> {
        let path = bench.plan.recording(number);
        let Some(trace) = recorded(&path, bench.plan.seeds.of(number)) else {
            return Ok(None);
        };
        let shown = shown(
            "complete",
            Some(trace.end_secs().unwrap_or(0.0)),
            &bench.main.judge(&trace)?,
            &bench.of_forms.judge(&trace)?,
        )
        .with_mishaps(&trace);
        let hash = hash_of_recording(&path)?;
        Ok(Some(bench.record(number, shown, Some(hash))))
    }

    fn tidy(&self, _: &Path) {}
}

impl WatchedEpisodes<'_> {
    fn run(
        &self,
        bench: &Bench<'_>,
        seed: u64,
        on_line: &mut OnLine<'_, '_>,
    ) -> Result<Recorded, SimError> {
        let stimulus = self.rig.stimulus();
        self.rig.run(stimulus, seed, on_line, bench.plan.interrupt)
    }
}

/// The recording of an episode of ours. One that is missing, damaged, cut short, of another episode
/// or of one that failed is made again.
fn recorded(path: &Path, seed: u64) -> Option<Trace> {
    let trace = path
        .exists()
        .then(|| recording::read_mcap(path))?
        .ok()?
        .trace;
    let is_ours = trace.metadata.get("seed") == Some(&seed.to_string());
    let is_whole = trace.complete && !trace.metadata.contains_key("failed");
    (is_whole && is_ours).then_some(trace)
}
