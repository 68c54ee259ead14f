//! One episode of a campaign: run, judged, kept.

use super::driver::{Campaigning, Source, hash_of_recording};
use super::failing::{EpisodeFailure, words_of};
use super::online::OnLine;
use super::outside::{OutsideCommand, stimulus_in};
use super::record::{EpisodeRecord, Judged};
use super::tally::Monitored;
use crate::technique::operation::only_violations;
use crate::technique::simulation::{Campaign, problem_at};
use diagnostic::Problem;
use evidence::FailureKind;
use host::files::write_whole;
use host::store::hash_of;
use judging::{Judgement, Judges};
use rig::processor::used_secs;
use std::path::{Path, PathBuf};
use study::{Keep, OnFailure};
use temporal::monitor::Verdict;
use testbench::End;
use trace::Trace;

/// Where a command fails in the first episode, how many others are tried to see whether it ever
/// works.
const OTHERS: u64 = 2;

/// What is needed to run and judge one episode, on any thread.
pub(super) struct Bench<'a> {
    pub(super) plan: &'a Campaigning<'a>,
    /// The topics of a bench of ours.
    pub(super) layout: Option<Trace>,
    pub(super) monitors: Vec<Monitored>,
    pub(super) main: Judges<'a>,
    pub(super) of_forms: Judges<'a>,
}

/// What one episode took; `None`s of what was done before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    pub(super) cpu_secs: Option<f64>,
}

/// What was found of an episode.
struct Shown {
    end: &'static str,
    simulated_secs: Option<f64>,
    main: Vec<Judged>,
    of_forms: Vec<Verdict>,
}

impl<'a> Bench<'a> {
    /// Runs and judges an episode, unless it was recorded before.
    pub(super) fn episode(&self, number: u64) -> Result<(EpisodeRecord, Effort), Problem> {
        let began = used_secs();
        let (record, is_new) = match (self.plan.source, &self.layout) {
            (Source::Bench(campaign), Some(layout)) => self.simulated(campaign, layout, number)?,
            (Source::Command(command), _) => (self.commanded(command, number)?, false),
            (Source::Bench(_), None) => {
                return Err(Problem::new(
                    "simulation-failed",
                    "the bench names no topics",
                ));
            }
        };
        let effort = Effort {
            cpu_secs: is_new.then(|| used_secs() - began),
        };
        Ok((record, effort))
    }

    /// An episode of a bench of ours: read, if it was recorded, or run. Whether it was run.
    fn simulated(
        &self,
        campaign: &Campaign,
        layout: &Trace,
        number: u64,
    ) -> Result<(EpisodeRecord, bool), Problem> {
        let path = self.plan.recording(number);
        let seed = self.plan.seeds.of(number);
        if let Some(trace) = recorded(&path, seed) {
            let shown = shown(
                "complete",
                Some(trace.end_secs().unwrap_or(0.0)),
                &self.main.judge(&trace)?,
                &self.of_forms.judge(&trace)?,
            );
            let hash = hash_of_recording(&path)?;
            return Ok((self.record(number, shown, Some(hash)), false));
        }
        let mut on_line = OnLine::new(&[&self.main, &self.of_forms], layout, self.plan.early_end)?;
        let run = match campaign.attempt(seed, &mut on_line, self.plan.interrupt) {
            Ok(run) => run,
            Err(error) => {
                let Some(failure) = EpisodeFailure::of_simulator(&error) else {
                    return Err(problem_at(seed, &error));
                };
                self.meet(number, &failure, false)?;
                return Ok((self.nothing_of(number, failure.kind), true));
            }
        };
        let failure = run.failure.as_ref().map(EpisodeFailure::of_controller);
        if let (Some(failure), Some(of)) = (&failure, &run.failure) {
            self.meet(number, failure, of.in_setup)?;
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
        let shown = shown(end, Some(secs), main, of_forms);
        let mut record = self.record(number, shown, None);
        if self.is_to_be_kept(&record) {
            let bytes = recording::to_mcap(&run.trace)
                .map_err(|error| Problem::data_lost("cannot-record", error.to_string()))?;
            record.recording = Some(hash_of(&bytes));
            write_whole(&path, &bytes)?;
        }
        Ok((record, true))
    }

    /// An episode of another simulator: read, if it was recorded, or run.
    fn commanded(&self, command: &OutsideCommand, number: u64) -> Result<EpisodeRecord, Problem> {
        let plan = self.plan;
        let path = plan.recording(number);
        // What a command left that then failed is no episode to be read again.
        let is_new = !path.exists() || words_of(plan.folder, number).exists();
        let (partial, failure) = match is_new {
            true => self.run(command, number)?,
            false => (path.clone(), None),
        };
        let mut record = match self.judged(command, &partial, failure.as_ref()) {
            Ok(shown) => self.record(number, shown, None),
            Err(problem) => match &failure {
                // What it left is no recording.
                Some(failure) if !problem.is_interruption() => {
                    OutsideCommand::remove(&partial);
                    return Ok(self.nothing_of(number, failure.kind));
                }
                _ => return Err(problem),
            },
        };
        if self.is_to_be_kept(&record) {
            record.recording = Some(hash_of_recording(&partial)?);
            if is_new {
                OutsideCommand::remove(&path);
                std::fs::rename(&partial, &path)
                    .map_err(|error| Problem::cannot_write(&path, &error))?;
            }
        } else if is_new {
            OutsideCommand::remove(&partial);
        }
        Ok(record)
    }

    /// Runs a command; gives the place of what it left, and what went wrong.
    fn run(
        &self,
        command: &OutsideCommand,
        number: u64,
    ) -> Result<(PathBuf, Option<EpisodeFailure>), Problem> {
        let plan = self.plan;
        let stimulus = stimulus_in(plan.folder)?;
        let run = |number: u64, name: &str| {
            let place = command.room_for(plan.folder, name)?;
            let failure = command.run(&stimulus, plan.seeds.of(number), &place, plan.interrupt)?;
            Ok::<_, Problem>((place, failure))
        };
        let (place, failure) = run(number, &plan.source.recording_name(number))?;
        if let Some(failure) = &failure {
            let mut is_ever_well = number != plan.numbers.start;
            for next in number + 1..=number + OTHERS {
                if !is_ever_well && plan.on_failure == OnFailure::Count {
                    let name = format!("tried-{}", plan.source.recording_name(next));
                    let (tried, failure) = run(next, &name)?;
                    OutsideCommand::remove(&tried);
                    is_ever_well = failure.is_none();
                }
            }
            self.meet(number, failure, !is_ever_well)?;
        } else {
            OutsideCommand::remove(&words_of(plan.folder, number));
        }
        Ok((place, failure))
    }

    fn judged(
        &self,
        command: &OutsideCommand,
        path: &Path,
        failure: Option<&EpisodeFailure>,
    ) -> Result<Shown, Problem> {
        let judge = |judges| command.judge(judges, path, &|| self.plan.go_on());
        let (main, of_forms) = (judge(&self.main)?, judge(&self.of_forms)?);
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

    /// An episode was ended by a failure: its words are kept, or it ends the campaign.
    fn meet(
        &self,
        number: u64,
        failure: &EpisodeFailure,
        never_worked: bool,
    ) -> Result<(), Problem> {
        let plan = self.plan;
        let seed = plan.seeds.of(number);
        if never_worked && number == plan.numbers.start {
            return Err(failure.problem(number, seed).remedy(
                "it has not worked once: check what the study says of it; the seed runs this episode alone",
            ));
        }
        if plan.on_failure == OnFailure::Stop {
            return Err(failure
                .problem(number, seed)
                .remedy("mend the program, or count such episodes (`--on-failure count` on the command line)"));
        }
        failure.keep(plan.folder, number, seed)
    }

    /// An episode that left no recording: nothing is known of any requirement.
    fn nothing_of(&self, number: u64, kind: FailureKind) -> EpisodeRecord {
        let unknown = Judged {
            verdict: Verdict::Inconclusive,
            triggered: 0,
            robustness: None,
            decided_at_secs: None,
        };
        let shown = Shown {
            end: kind.name(),
            simulated_secs: None,
            main: vec![unknown; self.monitors.len()],
            of_forms: vec![Verdict::Inconclusive; self.of_forms.monitors().count()],
        };
        self.record(number, shown, None)
    }

    fn is_to_be_kept(&self, record: &EpisodeRecord) -> bool {
        let is_failed = record.failure().is_some();
        match self.plan.keep {
            Keep::All => true,
            Keep::None => false,
            Keep::Violations => {
                is_failed || EpisodeRecord::shows_violation(&record.judged, &self.monitors)
            }
        }
    }

    fn record(&self, number: u64, shown: Shown, recording: Option<String>) -> EpisodeRecord {
        EpisodeRecord {
            number,
            seed: self.plan.seeds.of(number),
            end: shown.end.into(),
            simulated_secs: shown.simulated_secs,
            recording,
            judged: shown.main,
            forms: shown.of_forms,
        }
    }
}

fn shown(
    end: &'static str,
    simulated_secs: Option<f64>,
    main: &[Judgement<'_>],
    of_forms: &[Judgement<'_>],
) -> Shown {
    Shown {
        end,
        simulated_secs,
        main: main.iter().map(Judged::of).collect(),
        of_forms: of_forms.iter().map(|it| it.findings.verdict).collect(),
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
