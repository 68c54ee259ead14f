//! The exploration itself: batches of episodes, what they show, and what that
//! leads to next.
//!
//! Stimuli of a batch are chosen before any of it runs, and results are taken
//! in their order, so that the result does not depend on the number of threads.

use super::abstraction::{Abstraction, Class};
use super::bench::OpenBench;
use super::episode::{Shown, Watching};
use super::form::{
    BrokenReport, CodeReport, CoverReport, CoverageReport, CrossReport, ExplorationReport,
    FindingReport, ModelTestReport, ModelTestsReport, NO_EVIDENCE, SaturationReport, SetReport,
    SourceReport, Stopped,
};
use super::plan::{Plan, SourceKind};
use super::sources::{Planned, Sources};
use super::tests_of_model::ModelTests;
use crate::problem::{Problem, Source};
use crate::study::{Finding, Shows, Study, UnknownStep};
use crate::talk::{Interrupt, Stage};
use crate::technique::confidence;
use crate::technique::simulation::Seeds;
use campaign::{Coverage, Lcov, SetCoverage};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Holes of a cross that are listed, at most.
const HOLES: usize = 20;

/// What an exploration gives.
pub struct Explored {
    /// The result.
    pub report: ExplorationReport,
    /// The first episode of each finding, in the order of the result.
    pub findings: Vec<Finding>,
}

/// The first episode that showed something, and how many did.
struct Found {
    episode: u64,
    seed: u64,
    planned: Planned,
    count: u64,
}

/// Everything that was seen so far.
struct Seen<'a> {
    coverage: Coverage,
    triggers: SetCoverage<String>,
    states: SetCoverage<Class>,
    transitions: SetCoverage<(Class, Class)>,
    /// All of these and the findings, as texts.
    everything: SetCoverage<String>,
    found: BTreeMap<Shows, Found>,
    broken: Vec<BrokenReport>,
    simulated_secs: f64,
    abstraction: Option<&'a Abstraction>,
    /// The exploration's file.
    file: &'a str,
}

/// Explores. `vary` false runs the bench's own tests as they are, in turn, by
/// way of comparison.
pub fn explore(
    plan: &Plan,
    watching: &Watching<'_>,
    of_model: &ModelTests,
    kinds: &[SourceKind],
    vary: bool,
    interrupt: &Interrupt,
    stage: &Stage,
) -> Result<Explored, Problem> {
    let study = watching.study;
    let seeds = Seeds::new(study.about.seed, &format!("explore {}", plan.data.evidence));
    let own = watching.bench.own_tests();
    let mut sources = Sources::new(plan, kinds, own, of_model, vary, seeds.of(0))?;
    let mut seen = Seen::new(study, plan, watching);
    let level = confidence(study.about.confidence)?;
    let budget = plan.data.budget;
    let (mut episodes, mut stopped) = (0, Stopped::Budget);
    while episodes < budget.episodes {
        let count = budget.batch.min(budget.episodes - episodes);
        let planned = sources.next(count as usize, &watching.situations, &seen.coverage)?;
        let numbered: Vec<(u64, &Planned)> = (episodes + 1..).zip(&planned).collect();
        let shown: Result<Vec<Shown>, Problem> = numbered
            .par_iter()
            .map(|(number, planned)| {
                if interrupt.is_set() {
                    return Err(Problem::interrupted());
                }
                let shown = watching.run(&planned.stimulus, seeds.of(*number), interrupt);
                stage.advance();
                shown
            })
            .collect();
        let shown = match shown {
            Ok(shown) => shown,
            // Whole batches are kept: a part of one would depend on the threads.
            Err(_) if interrupt.is_set() && episodes > 0 => {
                stopped = Stopped::Interrupted;
                break;
            }
            Err(problem) => return Err(problem),
        };
        for ((number, planned), shown) in numbered.iter().zip(&shown) {
            let news = seen.record(*number, seeds.of(*number), planned, shown)?;
            sources.tell(planned, news, &shown.robustness);
        }
        episodes += count;
        let saturation = seen.everything.saturation();
        if let Some(stop) = budget.stop
            && saturation.has_stopped_paying(stop.more, stop.news, level)
        {
            stopped = Stopped::NothingNew;
            break;
        }
    }
    let findings = seen.findings(watching.bench);
    let mut coverage = seen.coverage_report(study, plan)?;
    coverage.saturation.chance_of_news_at_most =
        seen.everything.saturation().chance_of_news_at_most(level);
    let report = ExplorationReport {
        format: "1.0".into(),
        statement: NO_EVIDENCE.into(),
        bench: watching.bench.files.clone(),
        engine: watching.bench.engine.clone(),
        model: plan.data.model.clone(),
        episodes,
        simulated_secs: seen.simulated_secs,
        stopped,
        sources: sources_report(&sources),
        findings: seen.finding_reports(),
        broken: std::mem::take(&mut seen.broken),
        coverage,
        model_tests: model_tests_report(of_model),
        disagreement: None,
    };
    Ok(Explored { report, findings })
}

impl<'a> Seen<'a> {
    fn new(study: &Study, plan: &'a Plan, watching: &Watching<'a>) -> Self {
        let abstraction = watching.abstraction;
        let judged = study.forms.subjects.iter().filter(|f| f.monitor.is_some());
        let states = abstraction.map(|a| a.states.clone()).unwrap_or_default();
        let transitions = abstraction.map(|a| a.transitions.clone());
        Self {
            coverage: Coverage::new(watching.situations.model.clone()),
            triggers: SetCoverage::new(judged.map(|f| f.subject.id().to_owned())),
            states: SetCoverage::new(states),
            transitions: SetCoverage::new(transitions.unwrap_or_default()),
            everything: SetCoverage::new([]),
            found: BTreeMap::new(),
            broken: Vec::new(),
            simulated_secs: 0.0,
            abstraction,
            file: &plan.file,
        }
    }

    /// Takes what an episode showed; returns how much of it is new.
    fn record(
        &mut self,
        episode: u64,
        seed: u64,
        planned: &Planned,
        shown: &Shown,
    ) -> Result<usize, Problem> {
        self.simulated_secs += shown.simulated_secs;
        if let Some(reason) = &shown.broken {
            self.broken.push(BrokenReport {
                episode,
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
        for shows in self.shows(shown) {
            things.push(shows.to_string());
            let found = self.found.entry(shows).or_insert_with(|| Found {
                episode,
                seed,
                planned: planned.clone(),
                count: 0,
            });
            found.count += 1;
        }
        Ok(self.everything.record(things).new.len())
    }

    /// What an episode shows that is worth a finding, each once.
    fn shows(&self, shown: &Shown) -> Vec<Shows> {
        let violated = shown.violated.iter().cloned().map(Shows::Violated);
        let modes = shown.failure_modes.iter().cloned().map(Shows::FailureMode);
        let unknown = shown.unknown.iter().filter_map(|(from, to)| {
            let abstraction = self.abstraction?;
            Some(Shows::Unknown(UnknownStep {
                exploration: self.file.to_owned(),
                from: abstraction.describe(*from),
                to: to.map(|to| abstraction.describe(to)),
            }))
        });
        let mut all: Vec<Shows> = violated.chain(modes).chain(unknown).collect();
        all.sort();
        all.dedup();
        all
    }

    /// In the order in which they were found.
    fn in_order(&self) -> Vec<(&Shows, &Found)> {
        let mut found: Vec<_> = self.found.iter().collect();
        found.sort_by_key(|(_, found)| found.episode);
        found
    }

    fn findings(&self, bench: &OpenBench) -> Vec<Finding> {
        let finding = |(shows, found): &(&Shows, &Found)| Finding {
            found_by: found.planned.found_by.clone(),
            program: env!("CARGO_PKG_VERSION").into(),
            seed: found.seed,
            bench: bench.files.clone(),
            shows: (*shows).clone(),
            recording: None,
            stimulus: found.planned.stimulus.clone(),
        };
        self.in_order().iter().map(finding).collect()
    }

    fn finding_reports(&self) -> Vec<FindingReport> {
        let report = |(shows, found): &(&Shows, &Found)| FindingReport {
            shows: (*shows).clone(),
            in_words: shows.to_string(),
            file: String::new(),
            first_episode: found.episode,
            seed: found.seed.to_string(),
            found_by: found.planned.found_by.clone(),
            episodes: found.count,
            replayed: false,
        };
        self.in_order().iter().map(report).collect()
    }

    fn coverage_report(&self, study: &Study, plan: &Plan) -> Result<CoverageReport, Problem> {
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
            code: code_report(study, plan)?,
            saturation: SaturationReport {
                seen: saturation.seen,
                seen_once: saturation.seen_once,
                unseen: saturation.unseen(),
                news_in_next: saturation.expected_new(1),
                chance_of_news_at_most: 1.0,
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
    format!("{text} (in {episodes} episodes)")
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

fn code_report(study: &Study, plan: &Plan) -> Result<Option<CodeReport>, Problem> {
    let mut all: Option<Lcov> = None;
    for path in &plan.data.lcov {
        let source = Source::read(&study.folder.join(path))?;
        let lcov = Lcov::parse(&source.text).map_err(|error| {
            Problem::new("bad-exploration", format!("{}: {error}", source.name))
                .remedy("name files in the format that lcov and coverage tools write")
        })?;
        match &mut all {
            Some(all) => all.merge(&lcov),
            None => all = Some(lcov),
        }
    }
    let pair = |share: campaign::Share| [share.covered, share.total];
    Ok(all.map(|lcov| CodeReport {
        lines: pair(lcov.lines()),
        functions: pair(lcov.functions()),
        branches: pair(lcov.branches()),
    }))
}

fn sources_report(sources: &Sources<'_>) -> Vec<SourceReport> {
    let yields = sources.yields.iter();
    let report = yields.map(|(kind, (episodes, with_news))| SourceReport {
        source: kind.name().into(),
        episodes: *episodes,
        with_news: *with_news,
    });
    report.collect()
}

fn model_tests_report(of_model: &ModelTests) -> ModelTestsReport {
    let tests = of_model.tests.iter().map(|test| ModelTestReport {
        source: test.kind.name().into(),
        goal: test.goal.clone(),
        transitions: test.transitions,
        probability: test.probability,
        unmapped: test.unmapped,
        test: test.test.to_string(),
    });
    ModelTestsReport {
        tests: tests.collect(),
        without: of_model.without.clone(),
        transition_cover: of_model
            .cover
            .map(|(classes, paths, transitions)| CoverReport {
                classes,
                paths,
                transitions,
            }),
    }
}
