//! Episodes that are judged once they are over: of commands that leave recordings in formats of their own.

use super::driver::hash_of_recording;
use super::failing::{EpisodeFailure, words_of};
use super::one::{Bench, Recorder, Shown, shown};
use super::record::EpisodeRecord;
use crate::technique::operation::only_violations;
use diagnostic::Problem;
use judging::Judges;
use judging::recording::JudgedRecording;
use rig::OutsideCommand;
use std::path::{Path, PathBuf};
use study::OnFailure;

/// Where a command fails in the first episode, how many others are tried to see whether it ever
/// works.
const OTHERS: u64 = 2;

/// Episodes of which a command leaves recordings.
pub(super) struct LeftEpisodes<'a> {
    pub(super) command: &'a OutsideCommand,
}

/// Judges a recording that a command left. One that is not complete shows only violations.
pub fn judge_left<'a>(
    command: &OutsideCommand,
    judges: &Judges<'a>,
    path: &Path,
    go_on: &dyn Fn() -> Result<(), Problem>,
) -> Result<JudgedRecording<'a>, Problem> {
    let mut judged = command.rules().judge(judges, path, go_on)?;
    if !judged.complete {
        judged.judgements = only_violations(judged.judgements);
    }
    Ok(judged)
}

impl Recorder for LeftEpisodes<'_> {
    fn prepare(&self, folder: &Path) -> Result<(), Problem> {
        self.command.prepare(folder)
    }

    /// Read, if it was recorded, or run.
    fn episode(&self, bench: &Bench<'_>, number: u64) -> Result<(EpisodeRecord, bool), Problem> {
        let plan = bench.plan;
        let path = plan.recording(number);
        // What a command left that then failed is no episode to be read again.
        let is_new = !path.exists() || words_of(plan.folder, number).exists();
        let (partial, failure) = match is_new {
            true => self.run(bench, number)?,
            false => (path.clone(), None),
        };
        let mut record = match self.judged(bench, &partial, failure.as_ref()) {
            Ok(shown) => bench.record(number, shown, None),
            Err(problem) => match &failure {
                // What it left is no recording.
                Some(failure) if !problem.is_interruption() => {
                    OutsideCommand::remove(&partial);
                    return Ok((bench.nothing_of(number, failure.kind), false));
                }
                _ => return Err(problem),
            },
        };
        if bench.is_to_be_kept(&record) {
            record.recording = Some(hash_of_recording(&partial)?);
            if is_new {
                OutsideCommand::remove(&path);
                std::fs::rename(&partial, &path)
                    .map_err(|error| Problem::cannot_write(&path, &error))?;
            }
        } else if is_new {
            OutsideCommand::remove(&partial);
        }
        // What a command takes of the processor is not known.
        Ok((record, false))
    }

    fn judged_again(
        &self,
        bench: &Bench<'_>,
        number: u64,
    ) -> Result<Option<EpisodeRecord>, Problem> {
        let path = bench.plan.recording(number);
        if !path.exists() || words_of(bench.plan.folder, number).exists() {
            return Ok(None);
        }
        let shown = self.judged(bench, &path, None)?;
        let hash = hash_of_recording(&path)?;
        Ok(Some(bench.record(number, shown, Some(hash))))
    }

    fn tidy(&self, folder: &Path) {
        self.command.tidy(folder);
    }
}

impl LeftEpisodes<'_> {
    /// Runs a command; gives the place of what it left, and what went wrong.
    fn run(
        &self,
        bench: &Bench<'_>,
        number: u64,
    ) -> Result<(PathBuf, Option<EpisodeFailure>), Problem> {
        let (plan, command) = (bench.plan, self.command);
        let run = |number: u64, name: &str| {
            let place = command.room_for(plan.folder, name)?;
            let failure = command.run(None, plan.seeds.of(number), &place, plan.interrupt)?;
            let failure = failure.as_ref().map(EpisodeFailure::of);
            Ok::<_, Problem>((place, failure))
        };
        let (place, failure) = run(number, &command.recording_name(number))?;
        if let Some(failure) = &failure {
            let mut is_ever_well = number != plan.numbers.start;
            for next in number + 1..=number + OTHERS {
                if !is_ever_well && plan.on_failure == OnFailure::Count {
                    let name = format!("tried-{}", command.recording_name(next));
                    let (tried, failure) = run(next, &name)?;
                    OutsideCommand::remove(&tried);
                    is_ever_well = failure.is_none();
                }
            }
            bench.meet(number, failure, !is_ever_well)?;
        } else {
            OutsideCommand::remove(&words_of(plan.folder, number));
        }
        Ok((place, failure))
    }

    fn judged(
        &self,
        bench: &Bench<'_>,
        path: &Path,
        failure: Option<&EpisodeFailure>,
    ) -> Result<Shown, Problem> {
        let judge = |judges| judge_left(self.command, judges, path, &|| bench.plan.go_on());
        let (main, of_forms) = (judge(&bench.main)?, judge(&bench.of_forms)?);
        let Some(failure) = failure else {
            let end = match main.complete {
                true => "complete",
                false => "incomplete",
            };
            return Ok(shown(end, None, &main.judgements, &of_forms.judgements));
        };
        let (main, of_forms) = (
            only_violations(main.judgements),
            only_violations(of_forms.judgements),
        );
        Ok(shown(failure.kind.name(), None, &main, &of_forms))
    }
}
