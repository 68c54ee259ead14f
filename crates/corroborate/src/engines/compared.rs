//! The same episodes in two engines, or of two entries: how far their recordings lie apart, and where their verdicts differ.

use super::report::{
    EngineFailures, EnginesReport, SignalKind, SignalReport, VerdictPair, VerdictReport,
};
use crate::technique::campaign::{Ended, FailureCounts, ended, stops};
use crate::technique::confidence;
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::FailureKind;
use evidence::RunVerdict;
use host::Host;
use judging::{Judges, run_verdict};
use rayon::prelude::*;
use rig::Rig;
use std::collections::BTreeMap;
use study::{Entry, Study};
use temporal::monitor::Verdict;
use testbench::{Compared as Kind, Difference, Unwatched, differences};

/// A call, with what it names.
pub struct Called<'a> {
    pub study: &'a Study,
    pub entry: &'a Entry,
    pub rigs: &'a [Box<dyn Rig>],
    /// What each of them is called.
    pub names: &'a [String],
    pub numbers: Vec<u64>,
    /// By how much numbers may differ, by signal.
    pub tolerances: &'a BTreeMap<String, f64>,
    pub seeds: Seeds,
    pub host: &'a Host,
}

/// What one episode shows.
struct Compared {
    differences: Vec<Difference>,
    /// By engine, in the order of the monitors.
    verdicts: [Vec<Verdict>; 2],
    failed: [Option<FailureKind>; 2],
    words: [String; 2],
}

impl Called<'_> {
    /// Runs each episode in both engines.
    pub fn compare(&self, report: &mut EnginesReport) -> Result<(), Problem> {
        let [first, second] = self.rigs else {
            return Ok(());
        };
        let judges = Judges::new(self.study, |_| true)?;
        let stage = self
            .host
            .events
            .begin("episodes in both engines", self.numbers.len() as u64);
        let numbers = self.numbers.par_iter();
        let compared: Vec<Compared> = numbers
            .map(|number| {
                let a = self.run(first.as_ref(), *number)?;
                let b = self.run(second.as_ref(), *number)?;
                let verdicts = [
                    judges.verdicts_of(a.trace())?,
                    judges.verdicts_of(b.trace())?,
                ];
                stage.advance();
                Ok(Compared {
                    differences: match (a.trace(), b.trace()) {
                        (Some(a), Some(b)) => differences(a, b),
                        _ => Vec::new(),
                    },
                    verdicts,
                    failed: [a.failed, b.failed],
                    words: [a.words, b.words],
                })
            })
            .collect::<Result<_, Problem>>()?;
        drop(stage);
        for which in [0, 1] {
            let failed = self.numbers.iter().zip(&compared);
            let failed =
                failed.map(|(number, it)| (*number, it.failed[which], it.words[which].as_str()));
            stops(self.entry, &self.seeds, failed)?;
        }
        report.signals = signals(&compared, self.tolerances);
        unknown_tolerance(self.tolerances, &report.signals)?;
        report.verdicts = self.verdicts(&judges, &compared);
        // Those that differ come first.
        report
            .verdicts
            .sort_by_key(|it| std::cmp::Reverse(it.differ.len()));
        report.failures = self.failures(&compared)?;
        report.fail_alike = compared.iter().all(|it| it.failed[0] == it.failed[1]);
        Ok(())
    }

    /// An episode in one engine.
    pub(super) fn run(&self, rig: &dyn Rig, number: u64) -> Result<Ended, Problem> {
        let seed = self.seeds.of(number);
        let run = rig.run(rig.stimulus(), seed, &mut Unwatched, &self.host.cancel);
        ended(run, seed, self.numbers.first() == Some(&number))
    }

    /// What failed in each engine, if anything did.
    fn failures(&self, compared: &[Compared]) -> Result<Vec<EngineFailures>, Problem> {
        let level = confidence(self.study.about.confidence)?;
        let mut all = Vec::new();
        for (engine, name) in self.names.iter().enumerate() {
            let numbered = self.numbers.iter().zip(compared);
            let counts =
                FailureCounts::of(numbered.map(|(number, it)| (*number, it.failed[engine])));
            if !counts.is_empty() {
                all.push(EngineFailures {
                    engine: name.clone(),
                    failures: counts.shares(level)?,
                });
            }
        }
        Ok(all)
    }

    fn verdicts(&self, judges: &Judges<'_>, compared: &[Compared]) -> Vec<VerdictReport> {
        judges
            .monitors()
            .enumerate()
            .map(|(index, (subject, reading))| {
                let mut report = VerdictReport {
                    subject: subject.clone(),
                    reading: reading.map(str::to_owned),
                    violated: [0; 2],
                    differ: Vec::new(),
                };
                for (episode, number) in compared.iter().zip(&self.numbers) {
                    let names = [0, 1].map(|engine| run_verdict(episode.verdicts[engine][index]));
                    for (count, name) in report.violated.iter_mut().zip(names) {
                        *count += u64::from(name == RunVerdict::Violated);
                    }
                    if names[0] != names[1] {
                        report.differ.push(VerdictPair {
                            episode: *number,
                            seed: self.seeds.of(*number),
                            first: names[0],
                            second: names[1],
                        });
                    }
                }
                report
            })
            .collect()
    }
}

/// All episodes' differences together, what matters first: signals that differ, truth values and names before numbers, and
/// of each those that differ most, by share of rows or by tolerance.
fn signals(compared: &[Compared], tolerances: &BTreeMap<String, f64>) -> Vec<SignalReport> {
    let mut sums: Vec<Difference> = Vec::new();
    for episode in compared {
        for difference in &episode.differences {
            match sums.iter_mut().find(|sum| sum.signal == difference.signal) {
                Some(sum) => sum.add(difference),
                None => sums.push(difference.clone()),
            }
        }
    }
    let mut reports: Vec<SignalReport> = sums
        .into_iter()
        .map(|sum| of_signal(sum, tolerances))
        .collect();
    // Equals stay in the order of the recordings.
    reports.sort_by(|a, b| {
        let order = (a.order(), a.tolerance.is_none()).cmp(&(b.order(), b.tolerance.is_none()));
        order.then_with(|| b.relative().total_cmp(&a.relative()))
    });
    reports
}

/// Fails if a tolerance is of no number that is compared.
fn unknown_tolerance(
    tolerances: &BTreeMap<String, f64>,
    signals: &[SignalReport],
) -> Result<(), Problem> {
    let is_there = |name: &String| {
        let mut numbers = signals.iter().filter(|it| it.kind != SignalKind::Event);
        numbers.any(|it| it.signal == *name)
    };
    let Some((name, _)) = tolerances.iter().find(|(name, _)| !is_there(name)) else {
        return Ok(());
    };
    let message = format!("`{name}` has a tolerance and is not a number of both recordings");
    let known = signals.iter().map(|it| it.signal.as_str());
    let problem = Problem::new("bad-settings", message);
    Err(match diagnostic::did_you_mean(name, known) {
        Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
        None => problem.remedy("name a signal as `/topic.field`; `engines` lists them"),
    })
}

fn of_signal(sum: Difference, tolerances: &BTreeMap<String, f64>) -> SignalReport {
    let is_number = matches!(sum.kind, Kind::Number | Kind::Angle);
    SignalReport {
        kind: match sum.kind {
            Kind::Number => SignalKind::Number,
            Kind::Angle => SignalKind::Angle,
            Kind::Truth | Kind::Name => SignalKind::Event,
        },
        typical: sum.typical(),
        means: sum.means(),
        span: (is_number && sum.rows > 0).then(|| sum.span()),
        tolerance: tolerances.get(&sum.signal).copied().filter(|_| is_number),
        signal: sum.signal,
        unit: sum.unit,
        rows: sum.rows,
        unmatched: sum.unmatched,
        largest: sum.largest,
        largest_at_secs: sum.largest_at_secs,
    }
}
