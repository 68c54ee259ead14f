//! Judging traces with the study's monitors.
//!
//! A trace is judged at every time at which any of its signals was recorded,
//! so that nothing falls between two polls; signals keep their last value in
//! between. The clock is the trace's.

use crate::problem::Problem;
use crate::study::{Study, SubjectForm};
use evidence::Subject;
use std::collections::BTreeMap;
use temporal::monitor::{Monitor, MonitorReport, MonitorSpec};
use trace::{Predicate, Sampling, Trace, Valuations};

/// All monitors of a study, compiled.
#[derive(Debug)]
pub struct Judges<'a> {
    study: &'a Study,
    /// The propositions that any monitor uses, each once.
    predicates: Vec<Predicate>,
    /// The monitors, in the order of the subjects.
    judges: Vec<SubjectJudge<'a>>,
}

/// One compiled monitor.
#[derive(Debug)]
struct SubjectJudge<'a> {
    subject: &'a Subject,
    /// `None`: the main reading.
    reading: Option<&'a str>,
    monitor: Monitor,
    /// For each of the monitor's propositions, its place in `predicates`.
    propositions: Vec<usize>,
}

/// What one monitor says of one trace.
#[derive(Clone, Debug)]
pub struct Judgement<'a> {
    /// The requirement or failure mode.
    pub subject: &'a Subject,
    /// `None`: the main reading.
    pub reading: Option<&'a str>,
    /// The verdict and its counts.
    pub report: MonitorReport,
}

impl<'a> Judges<'a> {
    /// Compiles the monitors of those subjects for which `wanted` holds.
    pub fn new(study: &'a Study, wanted: impl Fn(&Subject) -> bool) -> Result<Self, Problem> {
        let mut judges = Self {
            study,
            predicates: Vec::new(),
            judges: Vec::new(),
        };
        let mut places = BTreeMap::new();
        for form in study.forms.subjects.iter().filter(|f| wanted(&f.subject)) {
            for (reading, spec) in specs(form) {
                judges.add(&form.subject, reading, spec, &mut places)?;
            }
        }
        Ok(judges)
    }

    fn add(
        &mut self,
        subject: &'a Subject,
        reading: Option<&'a str>,
        spec: &MonitorSpec,
        places: &mut BTreeMap<String, usize>,
    ) -> Result<(), Problem> {
        let monitor = Monitor::compile(spec)
            .map_err(|error| Problem::new("bad-monitor", error.to_string()))?;
        let mut propositions = Vec::new();
        for name in monitor.propositions() {
            let place = match places.get(name) {
                Some(place) => *place,
                None => {
                    let predicate = self.study.vocabulary.signals.predicate(name);
                    let predicate =
                        predicate.map_err(|e| self.study.vocabulary.predicate_problem(&e))?;
                    self.predicates.push(predicate);
                    places.insert(name.clone(), self.predicates.len() - 1);
                    self.predicates.len() - 1
                }
            };
            propositions.push(place);
        }
        self.judges.push(SubjectJudge {
            subject,
            reading,
            monitor,
            propositions,
        });
        Ok(())
    }

    /// Judges one trace with all monitors in one pass.
    pub fn judge(&self, trace: &Trace) -> Result<Vec<Judgement<'a>>, Problem> {
        let bound = self
            .predicates
            .iter()
            .map(|p| p.bind(trace))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| self.study.vocabulary.predicate_problem(&error))?;
        let sampled = Valuations::sample(trace, &bound, Sampling::EveryRow)
            .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
        self.judges
            .iter()
            .map(|judge| {
                let samples = sampled
                    .times_secs
                    .iter()
                    .enumerate()
                    .map(|(tick, time_secs)| {
                        let value = {
                            let sampled = &sampled;
                            move |proposition: usize| {
                                sampled.value(tick, judge.propositions[proposition])
                            }
                        };
                        (*time_secs, value)
                    });
                let report = judge.monitor.judge(samples, trace.complete);
                Ok(Judgement {
                    subject: judge.subject,
                    reading: judge.reading,
                    report: report
                        .map_err(|error| Problem::new("bad-recording", error.to_string()))?,
                })
            })
            .collect()
    }
}

/// A subject's monitors: the main one and those of other readings.
fn specs(form: &SubjectForm) -> impl Iterator<Item = (Option<&str>, &MonitorSpec)> {
    let main = form.monitor.iter().map(|spec| (None, spec));
    let others = form
        .readings
        .iter()
        .map(|reading| (Some(reading.name.as_str()), &reading.monitor));
    main.chain(others)
}
