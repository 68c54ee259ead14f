//! One episode of a campaign: run, judged, kept.

use super::driver::Campaigning;
use super::failing::EpisodeFailure;
use super::left::LeftEpisodes;
use super::record::{EpisodeRecord, Judged};
use super::tally::{Monitored, monitors};
use super::watched::WatchedEpisodes;
use diagnostic::Problem;
use evidence::FailureKind;
use host::Cancel;
use judging::{Judgement, Judges};
use rig::Rig;
use rig::processor::used_secs;
use std::path::Path;
use study::{Keep, OnFailure};
use temporal::monitor::Verdict;
use testbench::{Creep, OutOfReach};
use trace::Trace;

/// How episodes of a rig are run, judged and recorded.
pub(super) trait Recorder: Sync {
    /// Makes room for work in the campaign's folder. What an earlier call left there is removed.
    fn prepare(&self, folder: &Path) -> Result<(), Problem>;

    /// An episode, and whether the processor time since its beginning is what it took.
    fn episode(&self, bench: &Bench<'_>, number: u64) -> Result<(EpisodeRecord, bool), Problem>;

    /// What its recording in the campaign's folder says of an episode, judged anew; `None` if it is not whole. Nothing is run or written.
    fn judged_again(
        &self,
        bench: &Bench<'_>,
        number: u64,
    ) -> Result<Option<EpisodeRecord>, Problem>;

    /// Removes what is no longer needed.
    fn tidy(&self, folder: &Path);
}

/// The recorder of a rig.
fn recorder<'a>(rig: &'a dyn Rig, interrupt: &Cancel) -> Result<Box<dyn Recorder + 'a>, Problem> {
    Ok(match rig.leaves() {
        Some(command) => Box::new(LeftEpisodes { command }),
        None => Box::new(WatchedEpisodes {
            rig,
            layout: rig.layout(interrupt)?,
        }),
    })
}

/// What is needed to run and judge one episode, on any thread.
pub(super) struct Bench<'a> {
    pub(super) plan: &'a Campaigning<'a>,
    pub(super) recorder: Box<dyn Recorder + 'a>,
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
pub(super) struct Shown {
    end: &'static str,
    simulated_secs: Option<f64>,
    main: Vec<Judged>,
    of_forms: Vec<Verdict>,
    crept: Vec<Creep>,
    out_of_reach: Vec<OutOfReach>,
}

impl<'a> Bench<'a> {
    /// The bench of a campaign, whose forms `of_forms` judge.
    pub(super) fn new(plan: &'a Campaigning<'a>, of_forms: Judges<'a>) -> Result<Self, Problem> {
        let main = Judges::new(plan.study, |_| true)?;
        Ok(Self {
            plan,
            recorder: recorder(plan.rig, plan.interrupt)?,
            monitors: monitors(&main),
            main,
            of_forms,
        })
    }

    /// Runs and judges an episode, unless it was recorded before.
    pub(super) fn episode(&self, number: u64) -> Result<(EpisodeRecord, Effort), Problem> {
        let began = used_secs();
        let (record, is_new) = self.recorder.episode(self, number)?;
        let effort = Effort {
            cpu_secs: (used_secs().zip(began))
                .filter(|_| is_new)
                .map(|(now, began)| now - began),
        };
        Ok((record, effort))
    }

    /// An episode was ended by a failure: its words are kept, or it ends the campaign.
    pub(super) fn meet(
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
    pub(super) fn nothing_of(&self, number: u64, kind: FailureKind) -> EpisodeRecord {
        let unknown = Judged {
            verdict: Verdict::Inconclusive,
            triggered: 0,
            robustness: None,
            decided_at_secs: None,
            left_out: false,
        };
        let shown = Shown {
            end: kind.name(),
            simulated_secs: None,
            main: vec![unknown; self.monitors.len()],
            of_forms: vec![Verdict::Inconclusive; self.of_forms.monitors().count()],
            crept: Vec::new(),
            out_of_reach: Vec::new(),
        };
        self.record(number, shown, None)
    }

    pub(super) fn is_to_be_kept(&self, record: &EpisodeRecord) -> bool {
        let is_failed = record.failure().is_some();
        match self.plan.keep {
            Keep::All => true,
            Keep::None => false,
            Keep::Violations => {
                is_failed || EpisodeRecord::shows_violation(&record.judged, &self.monitors)
            }
        }
    }

    pub(super) fn record(
        &self,
        number: u64,
        shown: Shown,
        recording: Option<String>,
    ) -> EpisodeRecord {
        EpisodeRecord {
            number,
            seed: self.plan.seeds.of(number),
            end: shown.end.into(),
            simulated_secs: shown.simulated_secs,
            recording,
            judged: shown.main,
            forms: shown.of_forms,
            crept: shown.crept,
            out_of_reach: shown.out_of_reach,
        }
    }
}

impl Shown {
    /// With what a recording says of held things and of trajectories.
    pub(super) fn with_mishaps(self, trace: &Trace) -> Self {
        Self {
            crept: Creep::of(trace),
            out_of_reach: OutOfReach::of(trace),
            ..self
        }
    }
}

pub(super) fn shown(
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
        crept: Vec::new(),
        out_of_reach: Vec::new(),
    }
}
