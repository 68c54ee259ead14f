//! `corroborate engines`: the same episodes in two physics engines, and how
//! far they differ; or whether each engine repeats itself, by hashes.

mod determinism;

use super::{Done, Host, json, use_threads};
use crate::args::{Engines, Format};
use corroborate::outcome::Outcome;
use corroborate::technique::campaign::{Ended, FailureCounts, ended, failures_in_words, stops};
use corroborate::technique::confidence;
use corroborate::technique::simulation::{Campaign, Seeds};
use determinism::Repeated;
use diagnostic::Problem;
use evidence::{EpisodeFailures, FailureKind, Subject};
use host::store::Inputs;
use judging::{Judges, verdict_name};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use study::{Entry, Study, Work};
use temporal::monitor::Verdict;
use testbench::{Difference, Unwatched, differences};
use trace::Trace;

/// What `engines --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EnginesReport {
    /// Version of this form.
    pub format: String,
    /// The ledger's entry that was simulated.
    pub evidence: String,
    /// The engines with their versions: the first, the second.
    pub engines: Vec<String>,
    /// How many episodes were run in each.
    pub episodes: u64,
    /// How far the recordings lie apart, signal by signal.
    pub signals: Vec<SignalReport>,
    /// The verdicts in both.
    pub verdicts: Vec<VerdictReport>,
    /// Episodes that the robot's program or the physics ended by failing, in each engine; those are
    /// compared up to there.
    pub failures: Vec<EngineFailures>,
    /// Hashes of repeated and continued episodes, with `--determinism`.
    pub repeated: Vec<Repeated>,
}

/// What failed in one engine.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EngineFailures {
    /// The engine with its version.
    pub engine: String,
    /// Each kind, with its share of the episodes.
    pub failures: Vec<EpisodeFailures>,
}

/// How far a signal lies apart over all episodes.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SignalReport {
    /// `/topic.field`.
    pub signal: String,
    /// Its unit; empty for truth values and names.
    pub unit: String,
    /// Rows that both recordings have.
    pub rows: u64,
    /// Rows that one of them has.
    pub unmatched: u64,
    /// Root mean square of the differences; for truth values and names the
    /// share of rows that differ. Absent without rows.
    pub typical: Option<f64>,
    /// The largest difference.
    pub largest: f64,
    /// When that was.
    pub largest_at_secs: f64,
    /// Means in the first and the second engine. Absent without rows.
    pub means: Option<[f64; 2]>,
}

/// What the engines' recordings show of one requirement or failure mode.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictReport {
    /// Which.
    pub subject: Subject,
    /// The reading; absent for the main one.
    pub reading: Option<String>,
    /// Violations, or occurrences of a failure mode, in each engine.
    pub violated: [u64; 2],
    /// The episodes on which the engines' verdicts differ.
    pub differ: Vec<VerdictPair>,
}

/// An episode on which verdicts differ.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictPair {
    /// The episode's number.
    pub episode: u64,
    /// Its seed.
    pub seed: u64,
    /// The verdict in the first engine.
    pub first: String,
    /// The verdict in the second.
    pub second: String,
}

/// Runs the command.
pub fn engines(arguments: &Engines, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    let entry = study.entry(&arguments.evidence)?;
    let campaigns = campaigns(&study, entry, arguments.determinism, setting)?;
    let seeds = Seeds::new(arguments.seed.unwrap_or(study.about.seed), &entry.id);
    let called = Called {
        study: &study,
        entry,
        campaigns: &campaigns,
        numbers: (1..=arguments.episodes).collect(),
        seeds,
        setting,
    };
    let mut report = EnginesReport {
        format: "1.1".into(),
        evidence: entry.id.clone(),
        engines: campaigns.iter().map(name_of).collect(),
        episodes: arguments.episodes,
        signals: Vec::new(),
        verdicts: Vec::new(),
        failures: Vec::new(),
        repeated: Vec::new(),
    };
    let mut fail_alike = true;
    if arguments.determinism {
        report.repeated = called.repeat()?;
    } else {
        fail_alike = called.compare(&mut report)?;
    }
    let is_same = fail_alike
        && report
            .verdicts
            .iter()
            .all(|verdict| verdict.differ.is_empty())
        && report.repeated.iter().all(|repeated| repeated.same);
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
        outcome: match is_same {
            true => Outcome::Holds,
            false => Outcome::Violated,
        },
    })
}

/// An entry that only one engine can run.
pub fn one_engine(entry: &Entry) -> Problem {
    Problem::new(
        "one-engine",
        format!(
            "`{}` is no scene, and the second engine runs scenes only; the handover's contacts, servos and short cuts are written for MuJoCo",
            entry.id
        ),
    )
    .remedy("name an entry of the ledger with a `scene`")
}

/// The entry in each engine; MuJoCo alone if repetition is all that is asked.
fn campaigns(
    study: &Study,
    entry: &Entry,
    determinism: bool,
    setting: &Host,
) -> Result<Vec<Campaign>, Problem> {
    let library = setting.physics_library.as_deref();
    match &entry.work {
        Work::SimulateScene { scene, test, .. } => {
            let test = test.as_deref();
            let first = Campaign::of_scene(study, scene, test, library)?;
            for gap in first.gaps() {
                setting.events.say(&gap.to_string());
            }
            let second = Campaign::of_scene_in_rapier(study, scene, test)?;
            Ok(vec![first, second])
        }
        Work::Simulate {
            scenario,
            parameters,
            ..
        } if determinism => Ok(vec![Campaign::new(study, scenario, parameters, library)?]),
        Work::Simulate { .. } => Err(one_engine(entry)),
        _ => Err(Problem::new(
            "not-a-simulation",
            format!("`{}` is no simulation of this test bench", entry.id),
        )
        .remedy("name an entry of the ledger with a scene")),
    }
}

fn name_of(campaign: &Campaign) -> String {
    let tool = campaign.tool();
    format!("{} {}", tool.name, tool.version)
}

/// A call, with what it names.
struct Called<'a> {
    study: &'a Study,
    entry: &'a Entry,
    campaigns: &'a [Campaign],
    numbers: Vec<u64>,
    seeds: Seeds,
    setting: &'a Host,
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
    /// Whether in each episode the same failed, or nothing.
    fn compare(&self, report: &mut EnginesReport) -> Result<bool, Problem> {
        let [first, second] = self.campaigns else {
            return Ok(true);
        };
        let judges = Judges::new(self.study, |_| true)?;
        let stage = self
            .setting
            .events
            .begin("episodes in both engines", self.numbers.len() as u64);
        let numbers = self.numbers.par_iter();
        let compared: Vec<Compared> = numbers
            .map(|number| {
                let a = self.run(first, *number)?;
                let b = self.run(second, *number)?;
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
        report.signals = signals(&compared);
        report.verdicts = self.verdicts(&judges, &compared);
        report.failures = self.failures(&compared)?;
        Ok(compared.iter().all(|it| it.failed[0] == it.failed[1]))
    }

    fn run(&self, campaign: &Campaign, number: u64) -> Result<Ended, Problem> {
        let seed = self.seeds.of(number);
        let run = campaign.attempt(seed, &mut Unwatched, &self.setting.cancel);
        ended(run, seed, self.numbers.first() == Some(&number))
    }

    /// What failed in each engine, if anything did.
    fn failures(&self, compared: &[Compared]) -> Result<Vec<EngineFailures>, Problem> {
        let level = confidence(self.study.about.confidence)?;
        let mut all = Vec::new();
        for (engine, campaign) in self.campaigns.iter().enumerate() {
            let numbered = self.numbers.iter().zip(compared);
            let counts =
                FailureCounts::of(numbered.map(|(number, it)| (*number, it.failed[engine])));
            if !counts.is_empty() {
                all.push(EngineFailures {
                    engine: name_of(campaign),
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
                    let names = [0, 1].map(|engine| verdict_name(episode.verdicts[engine][index]));
                    for (count, name) in report.violated.iter_mut().zip(names) {
                        *count += u64::from(name == "violated");
                    }
                    if names[0] != names[1] {
                        report.differ.push(VerdictPair {
                            episode: *number,
                            seed: self.seeds.of(*number),
                            first: names[0].to_owned(),
                            second: names[1].to_owned(),
                        });
                    }
                }
                report
            })
            .collect()
    }
}

/// All episodes' differences together, in the order of the recordings.
fn signals(compared: &[Compared]) -> Vec<SignalReport> {
    let mut sums: Vec<Difference> = Vec::new();
    for episode in compared {
        for difference in &episode.differences {
            match sums.iter_mut().find(|sum| sum.signal == difference.signal) {
                Some(sum) => sum.add(difference),
                None => sums.push(difference.clone()),
            }
        }
    }
    let report = |sum: Difference| SignalReport {
        typical: sum.typical(),
        means: (sum.rows > 0).then(|| sum.sums.map(|total| total / sum.rows as f64)),
        signal: sum.signal,
        unit: sum.unit,
        rows: sum.rows,
        unmatched: sum.unmatched,
        largest: sum.largest,
        largest_at_secs: sum.largest_at_secs,
    };
    sums.into_iter().map(report).collect()
}

/// The hash of a recording: names, times and values, without its metadata,
/// which names engine and version.
pub fn recording_hash(trace: &Trace) -> String {
    let mut inputs = Inputs::default();
    for channel in &trace.channels {
        inputs.add("topic", channel.topic.as_bytes());
        for field in &channel.fields {
            inputs.add("field", field.name.as_bytes());
        }
        for (name, numbers) in [("times", &channel.times_secs), ("values", &channel.values)] {
            let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            inputs.add(name, &bytes);
        }
    }
    inputs.hash()
}

fn text(report: &EnginesReport) -> String {
    let mut out = String::new();
    let (engines, episodes) = (report.engines.join(" and "), report.episodes);
    let _ = writeln!(out, "{}: {episodes} episodes in {engines}", report.evidence);
    if !report.signals.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<44} {:>12} {:>12} {:>9} {:>12} {:>12}",
            "signal", "rms", "largest", "at s", "mean 1", "mean 2"
        );
    }
    for signal in &report.signals {
        let name = match signal.unit.as_str() {
            "" => format!("{} (share)", signal.signal),
            unit => format!("{} ({unit})", signal.signal),
        };
        let number = |number: Option<f64>| number.map_or("-".to_owned(), |n| format!("{n:.6}"));
        let _ = writeln!(
            out,
            "{name:<44} {:>12} {:>12.6} {:>9.3} {:>12} {:>12}",
            number(signal.typical),
            signal.largest,
            signal.largest_at_secs,
            number(signal.means.map(|means| means[0])),
            number(signal.means.map(|means| means[1]))
        );
    }
    for verdict in &report.verdicts {
        let reading = verdict.reading.as_deref().unwrap_or_default();
        let [first, second] = verdict.violated;
        let _ = writeln!(
            out,
            "{:<24} {reading} violated in {first} and {second}; verdicts differ in {} of {episodes}",
            verdict.subject.id(),
            verdict.differ.len()
        );
        for pair in &verdict.differ {
            let _ = writeln!(
                out,
                "    episode {} (seed {}): {} and {}",
                pair.episode, pair.seed, pair.first, pair.second
            );
        }
    }
    for engine in &report.failures {
        for failures in &engine.failures {
            let _ = writeln!(out, "{}: {}", engine.engine, failures_in_words(failures));
        }
    }
    determinism::text(&report.repeated, &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(EnginesReport).into();
        crate::command::tests::assert_schema_is_committed("engines.schema.json", &schema);
    }
}
