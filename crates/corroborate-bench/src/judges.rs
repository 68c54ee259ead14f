//! Runs as traces, and traces judged by every form of every requirement, as the product does it: each form
//! is compiled to a monitor of `temporal`, its words are predicates over the signals of `trace`, and the
//! trace is judged at every row.

use crate::requirements::{Forms, monitor_of};
use crate::task::{Run, STEPS_PER_SEC, Task};
use evidence::{Finding, FormDifference, Measure, RunVerdict, Subject};
use stats::{Confidence, Sample};
use std::collections::BTreeMap;
use temporal::formula::{Ending, FormulaMonitor, TimeModel, Verdict};
use trace::{BoundPredicate, Cursor, Field, Sampling, Trace, Vocabulary, ticks};

/// Signals of a run before those of its stages.
const GENERAL: [&str; 5] = ["done", "ready", "sensed", "finished", "near"];

/// Runs that are named as witnesses, at most.
const WITNESSES: usize = 5;

/// One form, ready to judge.
struct Judge {
    subject: Subject,
    form: &'static str,
    monitor: FormulaMonitor,
    atoms: Vec<usize>,
    clock: f64,
}

/// All forms of a study.
pub struct Judges {
    layout: Trace,
    stages: usize,
    sensing: usize,
    predicates: Vec<BoundPredicate>,
    judges: Vec<Judge>,
}

/// What a campaign of runs shows.
pub struct Judged {
    /// One finding for each subject, by its main form.
    pub findings: Vec<Finding>,
    /// Forms that do not agree with the sentence.
    pub differences: Vec<FormDifference>,
    /// For each form of each subject: runs that it did not cover, that keep it, violate it, leave it open.
    pub counts: Vec<(Subject, &'static str, [u64; 4])>,
}

impl Judges {
    /// The forms of the requirements and of the failure modes of `task`. `words` are further names
    /// for predicates.
    ///
    /// # Errors
    /// What is wrong with a form, in words.
    pub fn new(task: &Task, forms: &[Forms], words: &[(&str, String)]) -> Result<Self, String> {
        let layout = layout(task)?;
        let vocabulary = vocabulary(task, words)?;
        let mut names: BTreeMap<String, usize> = BTreeMap::new();
        let mut judges = Vec::new();
        let mut add = |subject: Subject, form: &'static str, text: &str, clock: f64| {
            let compiled = monitor_of(text)?;
            let mut settings = compiled.settings(TimeModel::Discrete, Ending::Finite);
            settings.explain_samples = 0;
            let monitor = FormulaMonitor::compile(&compiled.requirement.formula, &settings)
                .map_err(|error| error.to_string())?;
            let atoms = compiled.requirement.atoms.iter().map(|atom| {
                let next = names.len();
                *names.entry(atom.text.clone()).or_insert(next)
            });
            let atoms = atoms.collect();
            judges.push(Judge {
                subject,
                form,
                monitor,
                atoms,
                clock,
            });
            Ok::<(), String>(())
        };
        for one in forms {
            let subject = || Subject::Requirement(one.id.to_owned());
            add(subject(), "sentence", &one.sentence, 1.0)?;
            if one.monitor.is_some() || one.clock != 1.0 {
                let text = one.monitor.as_ref().unwrap_or(&one.sentence);
                add(subject(), "monitor", text, one.clock)?;
            }
            if let Some(text) = &one.property {
                add(subject(), "property", text, 1.0)?;
            }
        }
        for Stage { mode, .. } in task.stages.iter().filter(|stage| stage.can_fail) {
            let text = format!("When at_{mode}, the robot shall never satisfy failed_{mode}.");
            add(Subject::FailureMode(mode.clone()), "sentence", &text, 1.0)?;
        }
        let mut texts: Vec<(&String, &usize)> = names.iter().collect();
        texts.sort_by_key(|(_, place)| **place);
        let bound = texts.into_iter().map(|(text, _)| {
            let predicate = vocabulary
                .predicate(text)
                .map_err(|error| error.to_string())?;
            predicate.bind(&layout).map_err(|error| error.to_string())
        });
        Ok(Self {
            predicates: bound.collect::<Result<_, String>>()?,
            stages: task.stages.len(),
            sensing: task.sensing,
            layout,
            judges,
        })
    }

    /// A run as a trace: a row for the beginning, and one for the end of each stage.
    fn trace(&self, run: &Run) -> Result<Trace, String> {
        let mut trace = self.layout.clone();
        let general = GENERAL.len();
        let width = general + 1 + 2 * self.stages;
        let mut row = vec![0.0; width];
        row[1] = 1.0;
        row[general + 1] = 1.0;
        let push = |trace: &mut Trace, steps: u32, row: &[f64]| {
            // Divided, since a tenth has no exact number: 63 steps end at the 6.3 of a limit.
            let time_secs = f64::from(steps) / f64::from(STEPS_PER_SEC);
            trace.channels[0]
                .push(time_secs, row)
                .map_err(|error| error.to_string())
        };
        push(&mut trace, 0, &row)?;
        for (number, passed) in run.passed.iter().enumerate() {
            let (at, failed) = (general + 1, general + 1 + self.stages);
            row[at + passed.place] = 0.0;
            if passed.failed {
                row[failed + passed.place] = 1.0;
            } else if passed.place == self.sensing {
                row[2] = 1.0;
            }
            match run.passed.get(number + 1) {
                Some(next) => row[at + next.place] = 1.0,
                None if run.done_at == Some(passed.at) => self.end(run, &mut row),
                // What failed last ended it.
                None if run.done_at.is_none() => row[3] = 1.0,
                None => {}
            }
            push(&mut trace, passed.at, &row)?;
        }
        let last = run.passed.last().map_or(0, |passed| passed.at);
        if let Some(at) = run.done_at.filter(|at| *at > last) {
            self.end(run, &mut row);
            push(&mut trace, at, &row)?;
        }
        Ok(trace)
    }

    /// A run is done, and the hand has been near the person.
    fn end(&self, run: &Run, row: &mut [f64]) {
        (row[0], row[3], row[4], row[GENERAL.len()]) = (1.0, 1.0, 1.0, run.speed);
    }

    /// The verdicts of all forms on one run.
    fn verdicts(&self, run: &Run) -> Result<Vec<Verdict>, String> {
        let trace = self.trace(run)?;
        let mut at_work: Vec<_> = self
            .judges
            .iter()
            .map(|judge| judge.monitor.start())
            .collect();
        let mut cursor = Cursor::new(&trace);
        let times = ticks(&trace, Sampling::EveryRow).map_err(|error| error.to_string())?;
        let mut truth = Vec::new();
        for time_secs in times {
            cursor.seek(time_secs);
            let values: Vec<Option<bool>> =
                self.predicates.iter().map(|p| p.eval(&cursor)).collect();
            for (judge, work) in self.judges.iter().zip(&mut at_work) {
                truth.clear();
                truth.extend(judge.atoms.iter().map(|place| values[*place]));
                work.step_truth(time_secs * judge.clock, &truth)
                    .map_err(|error| error.to_string())?;
            }
        }
        Ok(at_work
            .into_iter()
            .map(|work| work.finish(true).verdict)
            .collect())
    }

    /// Judges a campaign of runs.
    ///
    /// # Errors
    /// What cannot be judged, in words.
    pub fn judge(&self, runs: &[Run], level: Confidence) -> Result<Judged, String> {
        let mut counts = vec![[0_u64; 4]; self.judges.len()];
        let mut differing: BTreeMap<(usize, RunVerdict, RunVerdict), (u64, Vec<String>)> =
            BTreeMap::new();
        for (number, run) in runs.iter().enumerate() {
            let verdicts = self.verdicts(run)?;
            let mut reference = 0;
            for (place, verdict) in verdicts.iter().enumerate() {
                counts[place][kind(*verdict)] += 1;
                if self.judges[place].form == "sentence" {
                    reference = place;
                }
                if differ(verdicts[reference], *verdict) {
                    let key = (
                        place,
                        run_verdict(verdicts[reference]),
                        run_verdict(*verdict),
                    );
                    let (count, witnesses) = differing.entry(key).or_default();
                    *count += 1;
                    if witnesses.len() < WITNESSES {
                        witnesses.push(format!("run {number}"));
                    }
                }
            }
        }
        let found = differing.into_iter();
        let differences =
            found.map(
                |((place, reference, verdict), (count, witnesses))| FormDifference {
                    subject: self.judges[place].subject.clone(),
                    reference: "sentence".into(),
                    reference_verdict: reference,
                    form: self.judges[place].form.into(),
                    verdict,
                    count,
                    runs: runs.len() as u64,
                    witnesses,
                },
            );
        Ok(Judged {
            differences: differences.collect(),
            findings: self.findings(&counts, level)?,
            counts: self
                .judges
                .iter()
                .zip(counts)
                .map(|(judge, count)| (judge.subject.clone(), judge.form, count))
                .collect(),
        })
    }

    /// The counts of each subject by its main form: the monitor that is written by hand, if there is one.
    fn findings(&self, counts: &[[u64; 4]], level: Confidence) -> Result<Vec<Finding>, String> {
        let mut findings: Vec<Finding> = Vec::new();
        for (judge, count) in self.judges.iter().zip(counts) {
            if judge.form == "property" {
                continue;
            }
            let [_, satisfied, violated, open] = *count;
            let is_mode = matches!(judge.subject, Subject::FailureMode(_));
            let finding = finding(
                judge.subject.clone(),
                Sample {
                    successes: if is_mode { violated } else { satisfied },
                    trials: satisfied + violated,
                },
                open,
                level,
            )?;
            match findings.iter_mut().find(|f| f.subject == judge.subject) {
                Some(of_sentence) => *of_sentence = finding,
                None => findings.push(finding),
            }
        }
        Ok(findings)
    }
}

use crate::task::Stage;

/// A finding of counts; not covered without trials.
pub(crate) fn finding(
    subject: Subject,
    sample: Sample,
    undecided: u64,
    level: Confidence,
) -> Result<Finding, String> {
    let measure = if sample.trials == 0 {
        Measure::NotCovered {
            reason: "No run met its precondition.".into(),
            constant: None,
        }
    } else {
        Measure::of_counts(sample, None, level).map_err(|error| error.to_string())?
    };
    Ok(Finding {
        subject,
        measure,
        denominator: evidence::Denominator::default(),
        trigger: None,
        undecided,
        left_out: 0,
        completions: None,
        witnesses: Vec::new(),
        readings: Vec::new(),
    })
}

fn run_verdict(verdict: Verdict) -> RunVerdict {
    match verdict {
        Verdict::NotCovered => RunVerdict::NotCovered,
        Verdict::Satisfied => RunVerdict::Satisfied,
        Verdict::Violated => RunVerdict::Violated,
        Verdict::Inconclusive => RunVerdict::Inconclusive,
    }
}

fn kind(verdict: Verdict) -> usize {
    match verdict {
        Verdict::NotCovered => 0,
        Verdict::Satisfied => 1,
        Verdict::Violated => 2,
        Verdict::Inconclusive => 3,
    }
}

/// Whether one is violated and the other is not, both being decided.
fn differ(one: Verdict, other: Verdict) -> bool {
    let undecided = [one, other].contains(&Verdict::Inconclusive);
    !undecided && (one == Verdict::Violated) != (other == Verdict::Violated)
}

fn layout(task: &Task) -> Result<Trace, String> {
    let mut fields: Vec<Field> = GENERAL.map(Field::bool).into();
    fields.push(Field::number("speed", "m/s"));
    let named = |prefix: &'static str| {
        let stages = task.stages.iter();
        stages.map(move |stage| Field::bool(format!("{prefix}_{}", stage.mode)))
    };
    fields.extend(named("at").chain(named("failed")));
    let mut trace = Trace::new();
    let added = trace.add_channel("/run", fields);
    added.map_err(|error| error.to_string())?;
    Ok(trace)
}

fn vocabulary(task: &Task, words: &[(&str, String)]) -> Result<Vocabulary, String> {
    let mut names: Vec<(String, String)> = GENERAL
        .map(|name| (name.to_owned(), format!("/run.{name}")))
        .into();
    names.push(("slow".into(), "/run.speed < 250 mm/s".into()));
    for stage in &task.stages {
        for prefix in ["at", "failed"] {
            let name = format!("{prefix}_{}", stage.mode);
            names.push((name.clone(), format!("/run.{name}")));
        }
    }
    names.extend(
        words
            .iter()
            .map(|(name, text)| ((*name).to_owned(), text.clone())),
    );
    Vocabulary::new(names).map_err(|errors| format!("{errors:?}"))
}
