//! The verdicts of many runs, counted one run at a time, so that memory does not grow with them.

use diagnostic::Problem;
use evidence::{
    Denominator, EpisodeFailures, FailureKind, Finding, Interval, Measure, Reading, Subject,
};
use judging::Judges;
use std::collections::BTreeMap;
use study::{JudgingForm, Study, SubjectForm};
use temporal::monitor::Verdict;

/// Runs that are named as witnesses, at most.
pub const WITNESSES: usize = 5;

/// Whose verdict is counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitored {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// `None`: the main reading.
    pub reading: Option<String>,
}

/// The monitors of judges, in their order.
pub fn monitors(judges: &Judges<'_>) -> Vec<Monitored> {
    let all = judges.monitors();
    all.map(|(subject, reading)| Monitored {
        subject: subject.clone(),
        reading: reading.map(str::to_owned),
    })
    .collect()
}

/// How the intervals of rates are formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Intervals {
    /// The number of runs was chosen beforehand: Wilson's.
    Fixed,
    /// It was chosen by looking at the runs: confidence sequences.
    Anytime,
}

/// Counts of each monitor.
#[derive(Clone, Debug)]
pub struct Tally {
    runs: u64,
    rows: Vec<Row>,
    /// Runs that were ended by a failure, with the first of them.
    failed: BTreeMap<FailureKind, (u64, Vec<String>)>,
}

/// Counts of one monitor.
#[derive(Clone, Debug)]
struct Row {
    monitor: Monitored,
    /// The row of the subject's main monitor.
    main: Option<usize>,
    satisfied: u64,
    violated: u64,
    inconclusive: u64,
    left_out: u64,
    witnesses: Vec<String>,
    /// Runs with another verdict than by the main monitor.
    differing: u64,
    differing_witnesses: Vec<String>,
}

impl Tally {
    /// Before the first run.
    pub fn new(monitors: &[Monitored]) -> Self {
        let is_main = |subject: &Subject| {
            let main = |it: &Monitored| &it.subject == subject && it.reading.is_none();
            monitors.iter().position(main)
        };
        let rows = monitors.iter().map(|monitor| Row {
            monitor: monitor.clone(),
            main: is_main(&monitor.subject),
            satisfied: 0,
            violated: 0,
            inconclusive: 0,
            left_out: 0,
            witnesses: Vec::new(),
            differing: 0,
            differing_witnesses: Vec::new(),
        });
        Self {
            runs: 0,
            rows: rows.collect(),
            failed: BTreeMap::new(),
        }
    }

    /// Counts a run, whose verdicts come in the order of the monitors.
    pub fn add(&mut self, name: &str, verdicts: &[Verdict]) {
        self.runs += 1;
        for (row, verdict) in self.rows.iter_mut().zip(verdicts) {
            match verdict {
                Verdict::Satisfied => row.satisfied += 1,
                Verdict::Violated => {
                    row.violated += 1;
                    witness(&mut row.witnesses, name);
                }
                Verdict::Inconclusive => row.inconclusive += 1,
                Verdict::NotCovered => {}
            }
            let of_main = row.main.and_then(|main| verdicts.get(main));
            if of_main != Some(verdict) {
                row.differing += 1;
                witness(&mut row.differing_witnesses, name);
            }
        }
    }

    /// Which verdicts of the run that was counted last leave out what was pending at its end, in the order of the monitors.
    pub fn left_out(&mut self, verdicts: impl IntoIterator<Item = bool>) {
        for (row, left_out) in self.rows.iter_mut().zip(verdicts) {
            row.left_out += u64::from(left_out);
        }
    }

    /// Counts what ended the run that was counted last, if it did not end by itself. It may have left
    /// no recording, so it goes by its number.
    pub fn ended_by(&mut self, number: u64, failure: Option<FailureKind>) {
        if let Some(kind) = failure {
            let (count, witnesses) = self.failed.entry(kind).or_default();
            *count += 1;
            witness(witnesses, &format!("episode {number}"));
        }
    }

    /// How often each kind of failure ended a run.
    pub fn failed(&self) -> impl Iterator<Item = (FailureKind, stats::Sample)> {
        self.failed.iter().map(|(kind, (count, _))| {
            let sample = stats::Sample {
                successes: *count,
                trials: self.runs,
            };
            (*kind, sample)
        })
    }

    /// Each kind of failure that ended a run.
    pub fn failures(
        &self,
        study: &Study,
        intervals: Intervals,
    ) -> Result<Vec<EpisodeFailures>, Problem> {
        let failures = self.failed.iter().map(|(kind, (count, witnesses))| {
            let sample = stats::Sample {
                successes: *count,
                trials: self.runs,
            };
            Ok(EpisodeFailures {
                kind: *kind,
                measure: counted(study, sample, intervals)?,
                witnesses: witnesses.clone(),
            })
        });
        failures.collect()
    }

    /// How many runs were counted.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Runs in which the requirement was kept, or in which the failure mode occurred, of those that
    /// decide it.
    pub fn sample(&self, subject: &Subject) -> stats::Sample {
        let row = self.row(subject, None);
        row.and_then(Row::sample).unwrap_or(stats::Sample {
            successes: 0,
            trials: 0,
        })
    }

    /// The same with the runs that reached no verdict: as if none of them counted, and as if all did.
    pub fn completions(&self, subject: &Subject) -> [stats::Sample; 2] {
        let decided = self.sample(subject);
        let undecided = self.row(subject, None).map_or(0, |row| row.inconclusive);
        [0, undecided].map(|more| stats::Sample {
            successes: decided.successes + more,
            trials: decided.trials + undecided,
        })
    }

    fn row(&self, subject: &Subject, reading: Option<&str>) -> Option<&Row> {
        let wanted = |row: &&Row| {
            &row.monitor.subject == subject && row.monitor.reading.as_deref() == reading
        };
        self.rows.iter().find(wanted)
    }

    /// One finding for each subject.
    pub fn findings(&self, study: &Study, intervals: Intervals) -> Result<Vec<Finding>, Problem> {
        let forms = study.forms.subjects.iter();
        forms
            .map(|form| self.finding(study, form, intervals))
            .collect()
    }

    fn finding(
        &self,
        study: &Study,
        form: &SubjectForm,
        intervals: Intervals,
    ) -> Result<Finding, Problem> {
        let (Some(_), Some(main)) = (&form.monitor, self.row(&form.subject, None)) else {
            let reason = match &form.no_monitor {
                Some(reason) => format!("It cannot be judged on traces: {reason}."),
                None => "It has no monitor.".into(),
            };
            return Ok(Finding {
                subject: form.subject.clone(),
                measure: Measure::NotExpressible { reason },
                denominator: Denominator::default(),
                trigger: None,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            });
        };
        let readings = form.readings.iter().filter_map(|reading| {
            let other = self.row(&form.subject, Some(&reading.name))?;
            Some(Reading {
                name: reading.name.clone(),
                meaning: reading.meaning.clone(),
                count: other.satisfied,
                trials: other.satisfied + other.violated,
                differing: other.differing,
                witnesses: other.differing_witnesses.clone(),
            })
        });
        Ok(Finding {
            subject: form.subject.clone(),
            measure: self.measure(study, (form, main), intervals)?,
            denominator: self.denominator(main),
            trigger: self.trigger(study, main, intervals)?,
            undecided: main.inconclusive,
            left_out: main.left_out,
            completions: None,
            readings: readings.collect(),
            witnesses: main.witnesses.clone(),
        })
    }

    /// A run without a verdict may have been triggered or not; only one that is known not to be counts as untriggered.
    fn denominator(&self, row: &Row) -> Denominator {
        match self.untriggered(row) {
            0 => Denominator::EveryRun,
            _ => Denominator::Triggered,
        }
    }

    fn untriggered(&self, row: &Row) -> u64 {
        self.runs
            .saturating_sub(row.satisfied + row.violated + row.inconclusive)
    }

    /// The share of runs that trigger the subject; unknown where some reach no verdict.
    fn trigger(
        &self,
        study: &Study,
        row: &Row,
        intervals: Intervals,
    ) -> Result<Option<Box<Measure>>, Problem> {
        if row.inconclusive > 0 || self.runs == 0 {
            return Ok(None);
        }
        let sample = stats::Sample {
            successes: self.runs - self.untriggered(row),
            trials: self.runs,
        };
        Ok(Some(Box::new(counted(study, sample, intervals)?)))
    }

    fn measure(
        &self,
        study: &Study,
        (form, row): (&SubjectForm, &Row),
        intervals: Intervals,
    ) -> Result<Measure, Problem> {
        let Some(sample) = row.sample().filter(|sample| sample.trials > 0) else {
            let asked = form.monitor.as_ref().and_then(JudgingForm::horizon);
            let reached = match (row.inconclusive, asked) {
                (0, _) => String::new(),
                (_, None) => " and a verdict reached".to_owned(),
                (_, Some(asked)) => {
                    format!(" and a verdict reached: it asks for {asked} of a run")
                }
            };
            return Ok(Measure::NotCovered {
                reason: format!(
                    "In none of {} runs was its precondition met{reached}.",
                    self.runs
                ),
                constant: None,
            });
        };
        counted(study, sample, intervals)
    }
}

/// Counts with their interval.
fn counted(study: &Study, sample: stats::Sample, intervals: Intervals) -> Result<Measure, Problem> {
    let level = super::super::confidence(study.about.confidence)?;
    match intervals {
        Intervals::Fixed => super::super::counts(sample.successes, sample.trials, None, level),
        Intervals::Anytime => Ok(anytime(sample, level)),
    }
}

impl Row {
    fn sample(&self) -> Option<stats::Sample> {
        let count = match self.monitor.subject {
            Subject::Requirement(_) => self.satisfied,
            Subject::FailureMode(_) => self.violated,
        };
        stats::Sample::new(count, self.satisfied + self.violated).ok()
    }
}

pub(super) fn witness(witnesses: &mut Vec<String>, name: &str) {
    if witnesses.len() < WITNESSES {
        witnesses.push(name.to_owned());
    }
}

/// Counts with the interval of a confidence sequence, which holds although the number of trials was
/// chosen by looking at them. Whatever else is computed from the counts uses the greatest effective
/// size at which Clopper and Pearson's interval is nowhere within that one, and so pays the same price. (It is the one of the
/// exact tests. Near a certainty, where such trials mostly end, Wilson's upper limit reaches that of a sequence for hardly any
/// trials: one in 399 of 400, for 191.)
pub fn anytime(sample: stats::Sample, level: stats::Confidence) -> Measure {
    let sequence = stats::confidence_sequence(sample, level);
    let covers = |size: f64| {
        stats::EffectiveSample::at_size(sample, size).is_ok_and(|effective| {
            let fixed = stats::clopper_pearson(effective, level);
            fixed.low <= sequence.low && fixed.high >= sequence.high
        })
    };
    let (mut enough, mut too_many) = (0.0, sample.trials as f64);
    for _ in 0..60 {
        let middle = 0.5 * (enough + too_many);
        if covers(middle) {
            enough = middle;
        } else {
            too_many = middle;
        }
    }
    Measure::Counts {
        count: sample.successes,
        trials: sample.trials,
        effective_trials: Some(enough),
        by_subject: None,
        subjects: None,
        interval: Interval {
            low: sequence.low,
            high: sequence.high,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitored(id: &str, reading: Option<&str>) -> Monitored {
        Monitored {
            subject: Subject::Requirement(id.into()),
            reading: reading.map(str::to_owned),
        }
    }

    #[test]
    fn verdicts_are_counted_with_their_first_witnesses() {
        let mut tally = Tally::new(&[monitored("1", None), monitored("1", Some("human"))]);
        use Verdict::{Inconclusive, NotCovered, Satisfied, Violated};
        for number in 0..12 {
            tally.add(&format!("run {number}"), &[Violated, Violated]);
        }
        for verdicts in [
            [Satisfied, Violated],
            [NotCovered, NotCovered],
            [Inconclusive, Satisfied],
        ] {
            tally.add("other", &verdicts);
        }
        let main = &tally.rows[0];
        assert_eq!(
            (main.satisfied, main.violated, main.inconclusive),
            (1, 12, 1)
        );
        assert_eq!((tally.runs(), main.witnesses.len()), (15, WITNESSES));
        assert_eq!(main.witnesses[0], "run 0");
        assert_eq!((main.differing, tally.rows[1].differing), (0, 2));
        tally.left_out([true, false]);
        assert_eq!((tally.rows[0].left_out, tally.rows[1].left_out), (1, 0));
        tally.ended_by(4, Some(FailureKind::ControllerFailed));
        tally.ended_by(5, None);
        let failed: Vec<_> = tally.failed().collect();
        let of_all = stats::Sample::new(1, 15).expect("counts");
        assert_eq!(failed, [(FailureKind::ControllerFailed, of_all)]);
        let sample = tally.sample(&Subject::Requirement("1".into()));
        assert_eq!((sample.successes, sample.trials), (1, 13));
        let ends = tally.completions(&Subject::Requirement("1".into()));
        assert_eq!(ends.map(|it| (it.successes, it.trials)), [(1, 14), (2, 14)]);
        assert_eq!(tally.sample(&Subject::Requirement("2".into())).trials, 0);
    }

    #[test]
    fn counts_found_by_looking_are_worth_less_and_never_nothing() {
        let level = stats::Confidence::new(0.95).expect("a level");
        for (successes, trials) in [(0, 5), (5, 5), (88, 100), (500, 10_000), (1, 1)] {
            let sample = stats::Sample::new(successes, trials).expect("counts");
            let Measure::Counts {
                effective_trials: Some(size),
                interval,
                ..
            } = anytime(sample, level)
            else {
                panic!("counts have a size");
            };
            assert!(
                size > 0.0 && size <= trials as f64,
                "{successes} of {trials}: {size}"
            );
            let effective = stats::EffectiveSample::at_size(sample, size).expect("a size");
            let worth = stats::clopper_pearson(effective, level);
            assert!(worth.low <= interval.low && worth.high >= interval.high);
            let fixed = stats::clopper_pearson(sample, level);
            assert!(interval.high - interval.low >= fixed.high - fixed.low);
        }
    }

    /// A failure more is never worth more than a success in its place, and hardly any is worth nothing.
    #[test]
    fn stopped_counts_near_a_certainty_are_worth_a_good_part_of_their_number() {
        let level = stats::Confidence::P95;
        let size = |successes| {
            let sample = stats::Sample::new(successes, 400).expect("counts");
            match anytime(sample, level) {
                Measure::Counts {
                    effective_trials: Some(size),
                    ..
                } => size,
                other => panic!("{other:?}"),
            }
        };
        let sizes: Vec<f64> = [384, 390, 397, 399, 400].map(size).into();
        assert!(
            sizes.is_sorted() && sizes[0] > 130.0 && sizes[4] < 400.0,
            "{sizes:?}"
        );
    }
}
