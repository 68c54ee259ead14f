//! The exploration itself: batches of episodes, what they show, and what that
//! leads to next.
//!
//! Stimuli of a batch are chosen before any of it runs, and results are taken
//! in their order, so that the result does not depend on the number of threads.

use super::episode::{Shown, Watching};
use super::faults::faults;
use super::form::{
    CoverReport, ExplorationReport, ModelTestReport, ModelTestsReport, NO_EVIDENCE, SourceReport,
};
use super::journal::Journal;
use super::plan::{Plan, SourceKind};
use super::seen::{Met, Seen};
use super::sources::{Material, Planned, Sources};
use super::tests_of_model::ModelTests;
use crate::technique::confidence;
use crate::technique::rows::Rows;
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{Asset, Exploration, Stopped};
use host::{Cancel, Events, Stage};
use rayon::prelude::*;
use study::Finding;

/// What an exploration gives.
pub struct Explored {
    /// The result.
    pub report: ExplorationReport,
    /// The first episode of each finding, in the order of the result.
    pub findings: Vec<Finding>,
    /// All episodes of each.
    pub met: Vec<Vec<Met>>,
    /// The table of all episodes.
    pub rows: Rows,
}

/// An exploration.
pub struct Exploring<'e, 's> {
    /// How to explore.
    pub plan: &'e Plan,
    /// What looks at episodes.
    pub watching: &'e Watching<'s>,
    /// Tests from the formal model.
    pub of_model: &'e ModelTests,
    /// The sources that are used.
    pub kinds: &'e [SourceKind],
    /// False to run the bench's own tests as they are, in turn, by way of
    /// comparison.
    pub vary: bool,
    /// What bench, model and plan rest on.
    pub assets: Vec<Asset>,
    /// What earlier calls have run.
    pub journal: &'e Journal<Shown>,
    /// Set when the user wants it to end.
    pub interrupt: &'e Cancel,
    /// Where progress is told.
    pub stage: &'e Stage,
    /// Where warnings are.
    pub talk: &'e Events,
}

impl Exploring<'_, '_> {
    /// Explores.
    pub fn run(&self) -> Result<Explored, Problem> {
        let (study, bench) = (self.watching.study, self.watching.bench);
        let name = format!("explore {}", self.plan.data.evidence);
        let seeds = Seeds::new(study.about.seed, &name);
        let material = Material {
            own: bench.own_tests(),
            of_model: self.of_model,
            faults: faults(self.plan, bench.data())?,
        };
        let mut sources = Sources::new(self.plan, self.kinds, material, self.vary, seeds.of(0))?;
        let mut seen = Seen::new(study, self.plan, self.watching);
        let (episodes, stopped) = self.batches(&seeds, &mut sources, &mut seen)?;
        seen.read_code(study, self.plan)?;
        let level = confidence(study.about.confidence)?;
        let report = ExplorationReport {
            found: Exploration {
                format: "1.4".into(),
                statement: NO_EVIDENCE.into(),
                evidence: bench.files.evidence.clone(),
                engine: bench.engine.clone(),
                confirmation: None,
                model: self.plan.data.model.clone(),
                plan: self.plan.file.clone(),
                seed: study.about.seed.to_string(),
                assets: self.assets.clone(),
                episodes,
                simulated_secs: seen.simulated_secs,
                stopped,
                findings: seen.finding_reports(self.watching, level)?,
                broken: std::mem::take(&mut seen.broken),
            },
            bench: bench.files.clone(),
            sources: sources_report(&sources),
            searches: sources.search_reports(),
            coverage: seen.coverage_report(level)?,
            model_tests: model_tests_report(self.of_model),
        };
        Ok(Explored {
            report,
            findings: seen.findings(bench),
            met: seen.met(),
            rows: seen.into_rows(),
        })
    }

    /// Batch after batch; how many episodes there were, and why it ended.
    fn batches(
        &self,
        seeds: &Seeds,
        sources: &mut Sources<'_>,
        seen: &mut Seen<'_>,
    ) -> Result<(u64, Stopped), Problem> {
        let level = confidence(self.watching.study.about.confidence)?;
        let budget = self.plan.data.budget;
        let mut episodes = 0;
        while episodes < budget.episodes {
            let count = budget.batch.min(budget.episodes - episodes);
            let planned =
                sources.next(count as usize, &self.watching.situations, &seen.coverage)?;
            let numbered: Vec<(u64, &Planned)> = (episodes + 1..).zip(&planned).collect();
            let shown = match self.shown(&numbered, seeds, seen) {
                Ok(shown) => shown,
                // Whole batches are counted: a part of one would depend on the threads. What of
                // it was run is in the journal.
                Err(_) if self.interrupt.is_cancelled() => {
                    return Ok((episodes, Stopped::Interrupted));
                }
                Err(problem) => return Err(problem),
            };
            for ((number, planned), shown) in numbered.iter().zip(&shown) {
                let news = seen.record(*number, seeds.of(*number), planned, shown)?;
                if let Some(warning) = sources.tell(planned, news, shown) {
                    self.talk.say(&format!("warning: {warning}"));
                }
            }
            episodes += count;
            if let Some(stop) = budget.stop
                && seen
                    .saturation()
                    .has_stopped_paying(stop.more, stop.news, level)
            {
                return Ok((episodes, Stopped::NothingNew));
            }
        }
        Ok((episodes, Stopped::Budget))
    }

    /// What the episodes of a batch show, from the journal if they are there.
    fn shown(
        &self,
        numbered: &[(u64, &Planned)],
        seeds: &Seeds,
        seen: &Seen<'_>,
    ) -> Result<Vec<Shown>, Problem> {
        let known = numbered.iter().map(|(number, planned)| {
            self.journal
                .known()
                .read(*number, seeds.of(*number), &planned.stimulus)
        });
        let known: Vec<Option<Shown>> = known.collect();
        let there = known.iter().flatten().count();
        self.stage.skip(there as u64);
        let words = seen.in_words();
        let work = numbered.par_iter().zip(known);
        let shown = work.map(|((number, planned), known)| match known {
            Some(known) => Ok(known),
            None => {
                let shown = self.episode(*number, seeds.of(*number), planned)?;
                self.stage.advance_with(|| words.clone());
                Ok(shown)
            }
        });
        shown.collect()
    }

    fn episode(&self, number: u64, seed: u64, planned: &Planned) -> Result<Shown, Problem> {
        if self.interrupt.is_cancelled() {
            return Err(Problem::interrupted());
        }
        let requirement = planned.for_the_sake_of.as_deref();
        let stimulus = &planned.stimulus;
        let shown =
            self.watching
                .run(stimulus, (seed, number == 1), requirement, self.interrupt)?;
        self.journal.add(number, seed, stimulus, &shown)?;
        Ok(shown)
    }
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
        goals: test.goals.clone(),
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
