//! What all episodes of an exploration showed together.

use super::abstraction::{Abstraction, Class};
use super::bench::OpenBench;
use super::code::Code;
use super::distinction::{Recorded, Search, Told};
use super::episode::{Shown, Watching};
use super::form::{CoverageReport, CrossReport, FindingReport, SaturationReport, SetReport};
use super::moments::Signals;
use super::plan::Plan;
use super::sources::Planned;
use crate::technique::rows::{Rows, Value};
use campaign::{Coverage, Saturation, SetCoverage};
use diagnostic::Problem;
use evidence::{BrokenEpisode, Discovery, Subject};
use judging::Judges;
use rayon::prelude::*;
use recording::{ParquetColumn, ParquetType};
use stats::Confidence;
use std::collections::{BTreeMap, BTreeSet};
use stimulus::Stimulus;
use study::{Expected, Finding, Shows, Study, UnknownStep};

/// Holes of a cross that are listed, at most.
const HOLES: usize = 20;

/// The first episode that showed something, and how many did.
struct Found {
    episode: u64,
    seed: u64,
    planned: Planned,
    /// All episodes that showed it.
    met: Vec<Met>,
}

/// An episode that showed something.
#[derive(Clone, Debug)]
pub struct Met {
    /// Its number.
    pub episode: u64,
    /// Its seed.
    pub seed: u64,
    /// What was done in it.
    pub stimulus: Stimulus,
    /// What led to it.
    pub found_by: String,
    /// When it showed, in seconds.
    pub secs: f64,
    /// Whether the task was over before.
    pub is_after: bool,
}

/// Everything that was seen so far.
pub struct Seen<'a> {
    /// Situations.
    pub coverage: Coverage,
    triggers: SetCoverage<String>,
    states: SetCoverage<Class>,
    transitions: SetCoverage<(Class, Class)>,
    /// All of these and the findings, as texts.
    everything: SetCoverage<String>,
    found: BTreeMap<Shows, Found>,
    /// Episodes whose physics gave no numbers.
    pub broken: Vec<BrokenEpisode>,
    /// Simulated time of all episodes.
    pub simulated_secs: f64,
    code: Code,
    abstraction: Option<&'a Abstraction>,
    /// The exploration's file.
    file: &'a str,
    bench: &'a OpenBench,
    judged: Vec<String>,
    rows: Rows,
    /// The signals of the bench's layout, and with all names that recordings had.
    layout: &'a Signals,
    signals: Signals,
    /// What signals all episodes had.
    recorded: Recorded,
    /// Whether anything says when the task is over.
    knows_end: bool,
}

impl<'a> Seen<'a> {
    /// Nothing yet.
    pub fn new(study: &Study, plan: &'a Plan, watching: &'a Watching<'a>) -> Self {
        let abstraction = watching.abstraction;
        let judged = study.forms.subjects.iter().filter(|f| f.monitor.is_some());
        let judged: Vec<String> = judged.map(|f| f.subject.id().to_owned()).collect();
        let states = abstraction.map(|a| a.states.clone()).unwrap_or_default();
        let transitions = abstraction.map(|a| a.transitions.clone());
        Self {
            coverage: Coverage::new(watching.situations.model.clone()),
            triggers: SetCoverage::new(judged.iter().cloned()),
            states: SetCoverage::new(states),
            transitions: SetCoverage::new(transitions.unwrap_or_default()),
            everything: SetCoverage::new([]),
            found: BTreeMap::new(),
            broken: Vec::new(),
            simulated_secs: 0.0,
            code: Code::default(),
            abstraction,
            file: &plan.file,
            bench: watching.bench,
            judged,
            rows: Rows::default(),
            layout: &watching.signals,
            signals: watching.signals.clone(),
            recorded: Recorded::new(),
            knows_end: watching.knows_end(),
        }
    }

    /// Reads what of the controller's code ran from the files that a plan
    /// names.
    pub fn read_code(&mut self, study: &Study, plan: &Plan) -> Result<(), Problem> {
        self.code.read(study, plan)
    }

    /// How much is still unseen.
    pub fn saturation(&self) -> Saturation {
        self.everything.saturation()
    }

    /// What was seen, for progress.
    pub fn in_words(&self) -> String {
        let (found, seen) = (self.found.len(), self.saturation().seen);
        format!("{found} found, {seen} different things seen")
    }

    /// Takes what an episode showed; returns how much of it is new.
    pub fn record(
        &mut self,
        episode: u64,
        seed: u64,
        planned: &Planned,
        shown: &Shown,
    ) -> Result<usize, Problem> {
        self.simulated_secs += shown.simulated_secs;
        self.row((episode, seed), planned, shown)?;
        if let Some(reason) = &shown.broken {
            self.broken.push(BrokenEpisode {
                episode,
                seed: seed.to_string(),
                reason: reason.clone(),
            });
        }
        let situations = std::slice::from_ref(&shown.situation);
        let recorded = self.coverage.record(situations);
        recorded.map_err(|e| Problem::new("bad-exploration", e.to_string()))?;
        // Cells count in every episode that has them, as Good and Turing need it.
        let mut things: Vec<String> = Vec::new();
        for cross in &self.coverage.model().crosses {
            let labels = cross.of.iter().map(|name| shown.situation.get(name));
            if let Some(labels) = labels.collect::<Option<Vec<_>>>() {
                things.push(format!("cell {} {labels:?}", cross.name));
            }
        }
        self.triggers.record(shown.triggered.iter().cloned());
        things.extend(shown.triggered.iter().map(|id| format!("trigger {id}")));
        let classes = &shown.abstracted.classes;
        self.states.record(classes.iter().copied());
        things.extend(classes.iter().map(|class| format!("state {class}")));
        let steps = classes.windows(2).map(|pair| (pair[0], pair[1]));
        let steps: Vec<(Class, Class)> = steps.collect();
        things.extend(steps.iter().map(|(a, b)| format!("step {a} {b}")));
        self.transitions.record(steps);
        if let Some(text) = &shown.lcov {
            let lines = self.code.take(text)?;
            things.extend(lines.into_iter().map(|line| format!("line {line}")));
        }
        if shown.broken.is_none() {
            let mut moments = shown.moments.clone();
            moments.join(self.layout, &mut self.signals);
            self.recorded.insert(episode, moments);
        }
        for (shows, secs) in self.shows(shown) {
            things.push(shows.to_string());
            let found = self.found.entry(shows).or_insert_with(|| Found {
                episode,
                seed,
                planned: planned.clone(),
                met: Vec::new(),
            });
            found.met.push(Met {
                episode,
                seed,
                stimulus: planned.stimulus.clone(),
                found_by: planned.found_by.clone(),
                secs,
                is_after: shown.over_secs.is_some_and(|over| secs > over),
            });
        }
        Ok(self.everything.record(things).new.len())
    }

    /// An episode's row of the table.
    fn row(
        &mut self,
        (episode, seed): (u64, u64),
        planned: &Planned,
        shown: &Shown,
    ) -> Result<(), Problem> {
        let stimulus = &planned.stimulus;
        let drawn = self.bench.drawn(stimulus, seed)?;
        let rows = &mut self.rows;
        rows.begin();
        rows.plain("episode", "its number", Value::U64(episode));
        rows.plain(
            "seed",
            "from which everything random is drawn",
            Value::U64(seed),
        );
        rows.plain(
            "test",
            "what is done",
            Value::Text(stimulus.test.to_string()),
        );
        rows.plain(
            "found_by",
            "source and choice of values",
            Value::Text(planned.found_by.clone()),
        );
        rows.set(
            ParquetColumn::new("simulated_secs", ParquetType::Double).in_unit("s"),
            Value::Double(shown.simulated_secs),
        );
        if let Some(id) = &planned.for_the_sake_of {
            rows.plain(
                "for_the_sake_of",
                "until this is decided",
                Value::Text(id.clone()),
            );
        }
        if let Some(robustness) = shown.robustness {
            let meaning = "space-time robustness of that requirement; below 0 it is violated";
            rows.plain("robustness", meaning, Value::Double(robustness));
        }
        if let Some(kind) = shown.failed {
            rows.plain(
                "failed",
                "what ended it by failing",
                Value::Text(kind.name().into()),
            );
        }
        if let Some(reason) = &shown.broken {
            rows.plain("broken", "why it broke off", Value::Text(reason.clone()));
        }
        let unknown = shown.unknown.len() as u64;
        rows.plain(
            "unknown",
            "steps that the model does not have",
            Value::U64(unknown),
        );
        for (key, value) in &stimulus.settings {
            rows.key("set", key, value.into());
        }
        for number in drawn.into_iter().flatten() {
            rows.key("drawn", &number.key, Value::Double(number.value));
        }
        for id in &self.judged {
            let violated = shown.violated.contains(id) || shown.failure_modes.contains(id);
            let triggered = shown.triggered.contains(id);
            let meaning = "violated, or of a failure mode: occurred";
            rows.plain(&format!("{id}.violated"), meaning, Value::Bool(violated));
            rows.plain(
                &format!("{id}.triggered"),
                "its precondition was met",
                Value::Bool(triggered),
            );
        }
        Ok(())
    }

    /// The table of all episodes.
    pub fn into_rows(self) -> Rows {
        self.rows
    }

    /// What an episode shows that is worth a finding, each once, with when it first showed.
    fn shows(&self, shown: &Shown) -> BTreeMap<Shows, f64> {
        let at = |id: &String| shown.shown_secs.get(id).copied().unwrap_or(shown.end_secs);
        let violated = shown.violated.iter();
        let violated = violated.map(|id| (Shows::Violated(id.clone()), at(id)));
        let modes = shown.failure_modes.iter();
        let modes = modes.map(|id| (Shows::FailureMode(id.clone()), at(id)));
        let failed = shown
            .failed
            .map(|kind| (Shows::Failed(kind), shown.end_secs));
        let unknown = shown.unknown.iter().zip(&shown.unknown_secs);
        let unknown = unknown.filter_map(|((from, to), secs)| {
            let abstraction = self.abstraction?;
            let step = UnknownStep {
                exploration: self.file.to_owned(),
                from: abstraction.describe(*from),
                to: to.map(|to| abstraction.describe(to)),
            };
            Some((Shows::Unknown(step), *secs))
        });
        let mut all: BTreeMap<Shows, f64> = BTreeMap::new();
        for (shows, secs) in violated.chain(modes).chain(failed).chain(unknown) {
            let first = all.entry(shows).or_insert(secs);
            *first = first.min(secs);
        }
        all
    }

    /// What matters first: what shows before the task is over, and of each by its kind; else in the order in which they
    /// were found.
    fn in_order(&self) -> Vec<(&Shows, &Found)> {
        let mut found: Vec<_> = self.found.iter().collect();
        found.sort_by_key(|(shows, found)| {
            let is_after = found.met.iter().all(|met| met.is_after);
            (is_after, shows.rank(), found.episode)
        });
        found
    }

    /// The first episode of each.
    pub fn findings(&self, bench: &OpenBench) -> Vec<Finding> {
        let finding = |(shows, found): &(&Shows, &Found)| Finding {
            found_by: found.planned.found_by.clone(),
            program: env!("CARGO_PKG_VERSION").into(),
            seed: found.seed,
            bench: bench.files.clone(),
            shows: (*shows).clone(),
            expected: Expected::Fails,
            recording: None,
            stimulus: found.planned.stimulus.clone(),
        };
        self.in_order().iter().map(finding).collect()
    }

    /// All episodes of each.
    pub fn met(&self) -> Vec<Vec<Met>> {
        let met = self.in_order().into_iter();
        met.map(|(_, found)| found.met.clone()).collect()
    }

    /// The same as they are reported.
    pub fn finding_reports(
        &self,
        watching: &Watching<'_>,
        level: Confidence,
    ) -> Result<Vec<FindingReport>, Problem> {
        let found = self.in_order();
        found
            .into_par_iter()
            .map(|(shows, found)| {
                let told = self.told_apart(shows, found, watching, level)?;
                let after = found.met.iter().filter(|met| met.is_after).count();
                Ok(FindingReport {
                    shows: shows.clone(),
                    found: Discovery {
                        in_words: shows.to_string(),
                        subject: subject_of(shows),
                        file: String::new(),
                        first_episode: found.episode,
                        seed: found.seed.to_string(),
                        found_by: found.planned.found_by.clone(),
                        episodes: found.met.len() as u64,
                        after_task: self.knows_end.then_some(after as u64),
                        not_told_apart: told.as_ref().err().cloned(),
                        told_apart: told.ok(),
                        replayed: false,
                        causes: Vec::new(),
                        without_cause: None,
                    },
                })
            })
            .collect()
    }

    /// What the recordings show at a finding and not elsewhere.
    fn told_apart(
        &self,
        shows: &Shows,
        found: &Found,
        watching: &Watching<'_>,
        level: Confidence,
    ) -> Result<Told, Problem> {
        let defining: BTreeSet<String> = match shows {
            Shows::Violated(id) | Shows::FailureMode(id) => {
                Judges::new(watching.study, |subject| subject.id() == id)?.signals()
            }
            Shows::Unknown(_) => self
                .abstraction
                .map(Abstraction::signals)
                .unwrap_or_default(),
            Shows::Failed(_) => BTreeSet::new(),
        };
        let showed = found.met.iter().map(|met| (met.episode, met.secs));
        let search = Search {
            signals: &self.signals,
            recorded: &self.recorded,
            level,
        };
        Ok(search.of(&showed.collect::<Vec<_>>(), &defining))
    }

    /// What was covered.
    pub fn coverage_report(&self, level: Confidence) -> Result<CoverageReport, Problem> {
        let saturation = self.everything.saturation();
        let describe = |class: &Class| {
            let text = self.abstraction.map(|a| a.describe(*class));
            format!("{{{}}}", text.unwrap_or_default())
        };
        let step = |(from, to): &(Class, Class)| format!("{} to {}", describe(from), describe(to));
        let crosses = self.coverage.model().crosses.iter();
        let crosses = crosses.map(|cross| self.cross_report(&cross.name));
        let known =
            |(from, to): &(Class, Class)| self.abstraction.is_some_and(|a| a.knows(*from, *to));
        Ok(CoverageReport {
            triggers: set_report(&self.triggers, Clone::clone),
            crosses: crosses.collect::<Result<_, _>>()?,
            states: self.abstraction.map(|_| set_report(&self.states, describe)),
            transitions: self.abstraction.map(|_| {
                let mut report = set_report(&self.transitions, step);
                // Several of the model's transitions may show as one.
                let unknown = self.transitions.unknown();
                let unknown = unknown.filter(|(pair, _)| !known(pair));
                report.unknown = unknown.map(|(pair, n)| counted(&step(pair), n)).collect();
                report
            }),
            not_expressed: self
                .abstraction
                .map_or_else(Vec::new, |a| a.not_expressed.clone()),
            code: self.code.report(),
            saturation: SaturationReport {
                seen: saturation.seen,
                seen_once: saturation.seen_once,
                unseen: saturation.unseen(),
                news_in_next: saturation.expected_new(1),
                news_in_100_more: saturation.expected_new(100),
                chance_of_news_at_most: saturation.chance_of_news_at_most(level),
            },
        })
    }

    fn cross_report(&self, name: &str) -> Result<CrossReport, Problem> {
        let bad = |e: campaign::CampaignError| Problem::new("bad-exploration", e.to_string());
        let share = self.coverage.share(name).map_err(bad)?;
        let holes = self.coverage.holes(name, HOLES).map_err(bad)?;
        Ok(CrossReport {
            name: name.to_owned(),
            covered: share.covered,
            total: share.total,
            holes: holes.iter().map(ToString::to_string).collect(),
            seen_though_excluded: self.coverage.seen_though_excluded(name).map_err(bad)?,
        })
    }
}

fn counted(text: &str, episodes: u64) -> String {
    format!("{text} (in {})", diagnostic::counted(episodes, "episode"))
}

fn subject_of(shows: &Shows) -> Option<Subject> {
    match shows {
        Shows::Violated(id) => Some(Subject::Requirement(id.clone())),
        Shows::FailureMode(id) => Some(Subject::FailureMode(id.clone())),
        Shows::Failed(_) | Shows::Unknown(_) => None,
    }
}

fn set_report<T: Ord + Clone>(set: &SetCoverage<T>, text: impl Fn(&T) -> String) -> SetReport {
    let share = set.share();
    SetReport {
        covered: share.covered,
        total: share.total,
        missing: set.missing().map(&text).collect(),
        unknown: set.unknown().map(|(it, n)| counted(&text(it), n)).collect(),
    }
}
