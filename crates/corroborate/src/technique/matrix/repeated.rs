//! Tools: the same episodes with half the time step, and in the other engine.
//!
//! An episode with the same seed draws the same numbers, so the verdicts are paired: only episodes with two
//! verdicts speak, and what counts is whether they go one way (a sign test). Contact is chaotic: single
//! episodes that come out otherwise, some one way and some the other, are no fault.

use super::{Diagnosing, Gathered};
use crate::corroboration::ANY_STUDY;
use crate::rigs;
use crate::technique::campaign::{FailureCounts, ended, failures_in_words, stops};
use crate::technique::confidence;
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{
    Clue, FailureKind, HALF_STEP, Inaccuracy, Rate, Subject, SuspectAsset, SuspectKind, Symptom,
    Witness, strength,
};
use judging::Judges;
use rayon::prelude::*;
use rig::Rig;
use stimulus::Stimulus;
use study::{Entry, PhysicsEngine, Simulated, Work};
use temporal::monitor::Verdict;
use testbench::{Recorded, SimError, Unwatched};
use toml::Table;

/// One episode, before and after a change.
struct Pair {
    /// In the order of the monitors.
    verdicts: [Vec<Verdict>; 2],
    /// What ended it, if it did not end by itself; it is judged up to there.
    failed: [Option<FailureKind>; 2],
    /// What was said then.
    words: [String; 2],
}

/// What is run again.
struct Changes<'a> {
    rig: &'a dyn Rig,
    entry: &'a Entry,
    episodes: u64,
}

impl Diagnosing<'_> {
    /// Runs episodes again as far as the effort says.
    pub(super) fn repeated(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        for (asked, option) in [
            (self.effort.half_step, "--half-step"),
            (self.effort.engines, "--engines"),
        ] {
            if asked.is_none() {
                let said = "episodes with half the time step or in the other engine";
                gathered
                    .not_done
                    .push(format!("{said}: not asked for ({option})"));
            }
        }
        for entry in self.entries(Work::is_simulated_here) {
            if let Some(episodes) = self.effort.half_step {
                self.half_step(entry, episodes, gathered)?;
            }
            if let Some(episodes) = self.effort.engines {
                self.other_engine(entry, episodes, gathered)?;
            }
        }
        Ok(())
    }

    fn half_step(
        &self,
        entry: &Entry,
        episodes: u64,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let rig = rigs::of_entry(self.study, entry, self.setting)?;
        let step = rig.time_step_key().and_then(|key| {
            let step_secs = value_at(rig.data(), key)?.as_float()?;
            Some((key, step_secs))
        });
        let Some((key, step_secs)) = step else {
            let said = "it has no time step that can be set";
            gathered
                .not_done
                .push(format!("half the time step of {}: {said}", entry.id));
            return Ok(());
        };
        let whole = rig.stimulus().clone();
        let mut half = whole.clone();
        half.settings.insert(key.into(), (step_secs / 2.0).into());
        let asset = |part: String| SuspectAsset {
            kind: SuspectKind::TimeStep,
            file: file_of(entry),
            part: Some(part),
            evidence: vec![entry.id.clone()],
            together: Vec::new(),
            line: None,
        };
        let changes = Changes {
            rig: rig.as_ref(),
            entry,
            episodes,
        };
        let part = asset(format!("{key} = {step_secs}"));
        self.changed(&changes, [&whole, &half], HALF_STEP, &part, gathered)?;
        Ok(())
    }

    /// The episodes of a rig under one stimulus and another.
    fn changed(
        &self,
        of: &Changes<'_>,
        stimuli: [&Stimulus; 2],
        changed: &str,
        asset: &SuspectAsset,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let run = |which: usize, seed: u64| {
            (of.rig).run(stimuli[which], seed, &mut Unwatched, &self.setting.cancel)
        };
        let pairs = self.pairs(of.entry, of.episodes, changed, &run)?;
        self.compared(of.entry, asset, changed, &pairs, gathered)
    }

    fn other_engine(
        &self,
        entry: &Entry,
        episodes: u64,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let second = match rigs::in_other_engine(self.study, entry, self.setting) {
            Ok(second) => second,
            Err(problem) => {
                let said = match problem.code {
                    "one-engine" => "it is an outside command, which has an engine of its own",
                    "no-physics-library" => "MuJoCo is not here (`corroborate doctor`)",
                    _ => return Err(problem),
                };
                gathered
                    .not_done
                    .push(format!("the other engine for {}: {said}", entry.id));
                return Ok(());
            }
        };
        let rigs = [rigs::of_entry(self.study, entry, self.setting)?, second];
        let run = |changed: usize, seed: u64| {
            let rig = &rigs[changed];
            rig.run(rig.stimulus(), seed, &mut Unwatched, &self.setting.cancel)
        };
        let own = entry.work.simulated().and_then(Simulated::engine);
        let changed = match own.unwrap_or_default() {
            PhysicsEngine::Mujoco => "Rapier in place of MuJoCo",
            PhysicsEngine::Rapier => "MuJoCo in place of Rapier",
        };
        let pairs = self.pairs(entry, episodes, changed, &run)?;
        let asset = SuspectAsset {
            kind: SuspectKind::Engine,
            file: None,
            part: Some(changed.into()),
            evidence: vec![entry.id.clone()],
            together: Vec::new(),
            line: None,
        };
        self.compared(entry, &asset, changed, &pairs, gathered)
    }

    /// The verdicts of episodes as they are and changed.
    fn pairs(
        &self,
        entry: &Entry,
        episodes: u64,
        title: &str,
        run: &(dyn Fn(usize, u64) -> Result<Recorded, SimError> + Sync),
    ) -> Result<Vec<Pair>, Problem> {
        let judges = Judges::new(self.study, |_| true)?;
        let seeds = Seeds::new(self.study.about.seed, entry.seeded_as());
        let title = format!("{}: {title}", entry.id);
        let stage = self.setting.events.begin(&title, episodes);
        let numbers = (1..=episodes).into_par_iter();
        let pairs: Vec<Pair> = numbers
            .map(|number| {
                self.setting.go_on()?;
                let seed = seeds.of(number);
                let run = |changed| ended(run(changed, seed), seed, number == 1);
                let (before, after) = (run(0)?, run(1)?);
                stage.advance();
                Ok(Pair {
                    verdicts: [
                        judges.verdicts_of(before.trace())?,
                        judges.verdicts_of(after.trace())?,
                    ],
                    failed: [before.failed, after.failed],
                    words: [before.words, after.words],
                })
            })
            .collect::<Result<_, Problem>>()?;
        for which in [0, 1] {
            let failed = (1..).zip(&pairs);
            let failed = failed
                .map(|(number, pair)| (number, pair.failed[which], pair.words[which].as_str()));
            stops(entry, &seeds, failed)?;
        }
        Ok(pairs)
    }

    fn compared(
        &self,
        entry: &Entry,
        asset: &SuspectAsset,
        changed: &str,
        pairs: &[Pair],
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let judges = Judges::new(self.study, |_| true)?;
        let monitors: Vec<_> = judges.monitors().collect();
        let (mut differing, mut one_way) = (0, 0);
        for (at, (subject, reading)) in monitors.into_iter().enumerate() {
            if reading.is_some() || !self.is_own(subject) {
                continue;
            }
            let way = |before, after| {
                let of_pair = |pair: &&Pair| violated(pair, at) == [before, after];
                pairs.iter().filter(of_pair).count() as u64
            };
            let (mended, broken) = (way(true, false), way(false, true));
            differing += mended + broken;
            let score = strength(
                Rate::Computed(0.5),
                Rate::counted(broken, mended + broken),
                1e-6,
            );
            if score > 0.0 && mended + broken > 0 {
                one_way += 1;
                let clue = self.clue(entry, asset, changed, (subject, at, score), pairs);
                gathered.clues.push(clue);
            }
        }
        self.failed(entry, changed, pairs, gathered)?;
        gathered.in_order.push(format!(
            "{}, {changed}: of {} episodes, verdicts differ {differing} times; on {one_way} subjects they go one way",
            entry.id,
            pairs.len()
        ));
        Ok(())
    }

    /// Says how often episodes did not end by themselves, as they are and changed.
    fn failed(
        &self,
        entry: &Entry,
        changed: &str,
        pairs: &[Pair],
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let level = confidence(self.study.about.confidence)?;
        for (which, how) in [(0, "as they are"), (1, changed)] {
            let failed = pairs.iter().map(|pair| pair.failed[which]);
            for failures in FailureCounts::of((1..).zip(failed)).shares(level)? {
                let words = failures_in_words(&failures);
                gathered.not_done.push(format!(
                    "verdicts of {} episodes, {how}: {words}; what was not decided by then is not compared",
                    entry.id
                ));
            }
        }
        Ok(())
    }

    fn clue(
        &self,
        entry: &Entry,
        asset: &SuspectAsset,
        changed: &str,
        (subject, at, score): (&Subject, usize, f64),
        pairs: &[Pair],
    ) -> Clue {
        let count = |which: usize| {
            let all = pairs.iter().filter(|pair| violated(pair, at)[which]);
            all.count() as u64
        };
        let before_after = [count(0), count(1)];
        let numbered = (1_u64..).zip(pairs);
        let differing: Vec<u64> = numbered
            .filter(|(_, pair)| violated(pair, at)[0] != violated(pair, at)[1])
            .map(|(number, _)| number)
            .collect();
        let [before, after] = before_after;
        let of = pairs.len();
        Clue {
            inaccuracy: Inaccuracy::Tool,
            asset: asset.clone(),
            subject: subject.clone(),
            score,
            title: format!("{} comes out otherwise with {changed}", entry.id),
            explanation: format!(
                "Episodes in which {} is violated (or occurs): {before} of {of} as they are, {after} with {changed}.",
                subject.in_words()
            ),
            symptom: Symptom::RunsOtherwise {
                subject: subject.clone(),
                changed: changed.to_owned(),
                violated: before_after,
                episodes: of as u64,
                differing: differing.len() as u64,
            },
            figures: Vec::new(),
            witnesses: differing
                .iter()
                .take(3)
                .map(|number| Witness {
                    name: format!("{} episode {number}", entry.id),
                    shows: format!(
                        "{} with another verdict than with {changed}",
                        subject.in_words()
                    ),
                    replay: format!("corroborate replay {ANY_STUDY} {}:{number}", entry.id),
                })
                .collect(),
            ruled_out: Vec::new(),
            resolved_by: None,
        }
    }
}

/// Whether a monitor is violated in an episode, before and after.
fn violated(pair: &Pair, at: usize) -> [bool; 2] {
    [0, 1].map(|which| pair.verdicts[which].get(at) == Some(&Verdict::Violated))
}

/// A value of a rig's data.
fn value_at<'d>(data: &'d Table, key: &str) -> Option<&'d toml::Value> {
    let mut parts = key.split('.');
    let first = data.get(parts.next()?)?;
    parts.try_fold(first, |value, part| value.get(part))
}

fn file_of(entry: &Entry) -> Option<String> {
    let path = entry.work.simulated_file()?;
    Some(path.to_string_lossy().replace('\\', "/"))
}
