//! A variant in a simulation: of the handover, of a scene, or of a simulator that is a command.
//!
//! # Definition
//! The same episodes (the same seeds and the same test, which are those of the
//! evidence) are run as they are and with the variant's settings over the
//! bench's data, or over those of a command's stimulus; as they are, those that
//! `run` keeps with the evidence are not run again, unless a
//! failure ended them. A run
//! counts for a subject if it was covered both times. The interval is that of
//! matched pairs (Agresti and Min 2005), the p-value McNemar's exact one.
//! Neither rests on the seed's fixing what a run draws: if it does not, the
//! pairs are two independent samples, and the interval is wider.

use super::file::{ChangeText, Read};
use super::report::Gain;
use crate::rigs;
use crate::technique::campaign::{
    FailureCounts, OnLine, ended, episode_inputs, judged_by, records_judged_by, stops,
};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{FailureKind, Interval, Subject};
use host::store::is_stage_of;
use host::{Host, Stage};
use judging::Judges;
use rayon::prelude::*;
use rig::Rig;
use stats::Pairs;
use std::collections::BTreeMap;
use stimulus::Stimulus;
use study::{Entry, Study};
use temporal::monitor::Verdict;

/// What episodes showed.
pub struct Verdicts {
    /// For each subject of the judges, each episode's verdict.
    pub of: Vec<Vec<Verdict>>,
    /// What ended episodes that did not end by themselves; those are judged up to there.
    pub failures: FailureCounts,
}

/// The verdicts of episodes that need not be run, by their numbers.
type Kept = BTreeMap<u64, Vec<Verdict>>;

/// Episodes of one entry of the ledger.
pub struct Episodes<'a> {
    /// The study.
    pub study: &'a Study,
    /// The entry.
    pub entry: &'a Entry,
    /// How many.
    pub count: u64,
    /// What it is given.
    pub host: &'a Host,
}

impl Episodes<'_> {
    /// The verdicts of the entry as it is.
    pub fn as_it_is(&self, subjects: &[Subject], stage: &Stage) -> Result<Verdicts, Problem> {
        let rig = self.rig()?;
        let kept = self.kept(rig.as_ref(), subjects)?;
        stage.skip(kept.len() as u64);
        self.run(rig.as_ref(), rig.stimulus(), &kept, subjects, stage)
    }

    fn rig(&self) -> Result<Box<dyn Rig>, Problem> {
        rigs::of_entry(self.study, self.entry, self.host)
    }

    /// The verdicts of the episodes that the study's results hold, by number: of this program, these files and monitors.
    fn kept(&self, rig: &dyn Rig, subjects: &[Subject]) -> Result<Kept, Problem> {
        let folder = self.study.folder.join("results/episodes");
        let folder = folder.join(&self.entry.id);
        let program = self.host.build.as_str();
        let inputs = episode_inputs(self.study, self.entry, rig, program);
        if !is_stage_of(&folder, &inputs.hash()) {
            return Ok(Kept::new());
        }
        let judged_by = judged_by(self.study, rig, program);
        let judges = Judges::new(self.study, |_| true)?;
        let monitors: Vec<_> = judges.monitors().collect();
        let place = |subject: &Subject| {
            let mut all = monitors.iter();
            all.position(|(other, reading)| *other == subject && reading.is_none())
        };
        let places: Vec<Option<usize>> = subjects.iter().map(place).collect();
        let whole = records_judged_by(&folder, &judged_by)?.into_iter();
        let whole = whole.filter(|it| it.number <= self.count && it.failure().is_none());
        let verdicts = whole.map(|record| {
            let of = |place: &Option<usize>| {
                let judged = place.and_then(|place| record.judged.get(place));
                judged.map_or(Verdict::NotCovered, |it| it.verdict)
            };
            (record.number, places.iter().map(of).collect())
        });
        Ok(verdicts.collect())
    }

    /// The verdicts of a variant.
    pub fn varied(
        &self,
        read: &Read,
        change: &ChangeText,
        subjects: &[Subject],
        stage: &Stage,
    ) -> Result<Verdicts, Problem> {
        let rig = self.rig()?;
        let mut varied = rig.stimulus().clone();
        // Another simulator may pass over a key that it does not know, which would look like no gain; so it has to be one
        // that its stimulus sets already.
        let refused = match rig.is_outside() {
            true => {
                let applied = stimulus::apply(&mut rig.data().clone(), &change.settings);
                applied.err().map(|error| {
                    let remedy = "the stimulus of the ledger has to set the key to what it is now";
                    (error.to_string(), remedy)
                })
            }
            false => None,
        };
        varied.settings.extend(change.settings.clone());
        let refused = refused.or_else(|| {
            let reason = rig.refuses(&varied)?;
            Some((reason, "correct the keys in `settings`"))
        });
        if let Some((reason, remedy)) = refused {
            return Err(Problem::new(super::file::CODE, reason)
                .at(&read.source, change.evidence.span())
                .remedy(remedy));
        }
        self.run(rig.as_ref(), &varied, &Kept::new(), subjects, stage)
    }

    /// Runs the episodes that are not among `kept`.
    fn run(
        &self,
        rig: &dyn Rig,
        stimulus: &Stimulus,
        kept: &Kept,
        subjects: &[Subject],
        stage: &Stage,
    ) -> Result<Verdicts, Problem> {
        let judges = Judges::new(self.study, |subject| subjects.contains(subject))?;
        let numbers = 1..=self.count;
        let layout = match numbers.clone().all(|number| kept.contains_key(&number)) {
            true => None,
            false => Some(rig.layout(&self.host.cancel)?),
        };
        let seeds = Seeds::new(self.study.about.seed, self.entry.seeded_as());
        let rows: Vec<(Vec<Verdict>, Option<FailureKind>, String)> = numbers
            .into_par_iter()
            .map(|number| {
                if self.host.cancel.is_cancelled() {
                    return Err(Problem::interrupted());
                }
                let (None, Some(layout)) = (kept.get(&number), &layout) else {
                    let verdicts = kept.get(&number).cloned().unwrap_or_default();
                    return Ok((verdicts, None, String::new()));
                };
                let mut on_line = OnLine::new(&[&judges], layout, false)?;
                let seed = seeds.of(number);
                let run = rig.run(stimulus, seed, &mut on_line, &self.host.cancel);
                let run = ended(run, seed, number == 1)?;
                stage.advance();
                let Some(recorded) = run.recorded else {
                    let unknown = vec![Verdict::Inconclusive; subjects.len()];
                    return Ok((unknown, run.failed, run.words));
                };
                let judged = on_line.finish(recorded.trace.complete)?;
                let judged: Vec<_> = judged.into_iter().flatten().collect();
                let of = |subject: &Subject| {
                    let main = judged
                        .iter()
                        .find(|it| it.subject == subject && it.reading.is_none());
                    main.map_or(Verdict::NotCovered, |it| it.findings.verdict)
                };
                Ok((subjects.iter().map(of).collect(), run.failed, run.words))
            })
            .collect::<Result<_, _>>()?;
        let failed = (1..).zip(&rows);
        let failed = failed.map(|(number, (_, kind, words))| (number, *kind, words.as_str()));
        stops(self.entry, &seeds, failed)?;
        let column = |place: usize| rows.iter().map(|(row, ..)| row[place]).collect();
        Ok(Verdicts {
            of: (0..subjects.len()).map(column).collect(),
            failures: FailureCounts::of((1..).zip(rows.iter().map(|(_, failed, _)| *failed))),
        })
    }
}

/// The gain on one subject, from the verdicts of the same episodes.
pub fn gain(
    subject: &Subject,
    before: &[Verdict],
    after: &[Verdict],
    level: stats::Confidence,
) -> Gain {
    let (pairs, first, second) = counted(subject, before, after);
    let Some(difference) = pairs.difference() else {
        return Gain::NotExpressible {
            reason: "No episode covered it both times.".into(),
        };
    };
    let interval = pairs.interval(level);
    let n = pairs.pairs as f64;
    Gain::Known {
        before: first as f64 / n,
        after: second as f64 / n,
        gain: difference,
        interval: Some(Interval {
            low: interval.low,
            high: interval.high,
        }),
        how: format!(
            "{} episodes with the same seeds: {first} and {second}; only without {}, only with {}",
            pairs.pairs, pairs.only_first, pairs.only_second
        ),
        p_value: Some(pairs.p_value()),
    }
}

/// Episodes that decide the subject both times: as pairs, and how many count each time.
fn counted(subject: &Subject, before: &[Verdict], after: &[Verdict]) -> (Pairs, u64, u64) {
    // Of a failure mode, what is violated has occurred.
    let counts = match subject {
        Subject::Requirement(_) => Verdict::Satisfied,
        Subject::FailureMode(_) => Verdict::Violated,
    };
    let decides = |verdict: &Verdict| matches!(verdict, Verdict::Satisfied | Verdict::Violated);
    let mut pairs = Pairs::default();
    let (mut first, mut second) = (0_u64, 0_u64);
    for (old, new) in before.iter().zip(after) {
        if !(decides(old) && decides(new)) {
            continue;
        }
        let (old, new) = (*old == counts, *new == counts);
        pairs.pairs += 1;
        first += u64::from(old);
        second += u64::from(new);
        pairs.only_first += u64::from(old && !new);
        pairs.only_second += u64::from(new && !old);
    }
    (pairs, first, second)
}
