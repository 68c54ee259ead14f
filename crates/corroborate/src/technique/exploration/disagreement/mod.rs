//! The search for disagreement: contexts in which the formal model predicts
//! one thing and the bench shows another.
//!
//! An episode ends as soon as the requirement is decided in it, and is kept
//! in a journal, so that a call that was interrupted goes on where it stopped.
//!
//! A context is a point of declared parameters, which set the bench's data and,
//! through declared constants, the model. For each context that is looked at
//! the model is checked anew, once: declare choices rather than continuous
//! ranges where models are large.

mod contexts;
mod predictions;
mod report;
mod search;
mod text;

use super::bench::OpenBench;
use super::journal::{Journal, Known};
use super::plan::{DisagreementData, Plan};
use crate::technique::simulation::Seeds;
use campaign::{DisagreementOptions, DisagreementSearch};
use contexts::{Contexts, Outcome};
use diagnostic::Problem;
use evidence::{Asset, DisagreementMap, FailureKind};
use host::{Cancel, Stage};
use predictions::Predictions;
use rayon::prelude::*;
use stimulus::{Point, Stimulus};
use study::Study;

pub use search::{MapSearch, map_again};
pub use text::as_text;

/// Episodes between two looks at what they showed.
const BATCH: usize = 20;
/// Places of the map in each direction.
const MAP_STEPS: usize = 8;

/// A search, ready to be done.
pub struct Disagreement<'a> {
    data: &'a DisagreementData,
    options: DisagreementOptions,
    contexts: Contexts<'a>,
    formal: Predictions<'a>,
    bench: &'a OpenBench,
    seeds: Seeds,
    seed: u64,
    plan: String,
    assets: Vec<Asset>,
    interrupt: &'a Cancel,
}

/// Where what an episode showed is taken from.
#[derive(Clone, Copy, Debug)]
pub enum Episodes<'j> {
    /// From a journal, as far as it goes; the others are run and added to it.
    Journal(&'j Journal<Outcome>),
    /// From what a journal has; none is run, and where it ends the search is interrupted.
    Known(&'j Known<Outcome>),
    /// All are run.
    Anew,
}

impl Episodes<'_> {
    fn known(&self) -> Option<&Known<Outcome>> {
        match self {
            Self::Journal(journal) => Some(journal.known()),
            Self::Known(known) => Some(known),
            Self::Anew => None,
        }
    }
}

/// What was run.
#[derive(Clone, Debug, Default)]
struct Spent {
    episodes: u64,
    /// What ended each episode, by number.
    failed: Vec<(u64, Option<FailureKind>)>,
    simulated_secs: f64,
    is_interrupted: bool,
}

impl<'a> Disagreement<'a> {
    /// Holds the plan against study, bench and model, which rest on these assets.
    pub fn new(
        study: &'a Study,
        plan: &'a Plan,
        bench: &'a OpenBench,
        assets: Vec<Asset>,
        interrupt: &'a Cancel,
    ) -> Result<Self, Problem> {
        let Some(data) = &plan.data.disagreement else {
            return Err(plan
                .mistake("", "it has no [disagreement] table")
                .remedy("add a [disagreement] table with the requirement and the contexts"));
        };
        let subject = evidence::Subject::Requirement(data.requirement.clone());
        let margin = data.margin.unwrap_or_else(|| study.margin(&subject));
        let explored = data.explore.unwrap_or(data.episodes * 2 / 5).max(1);
        Ok(Self {
            options: DisagreementOptions {
                explore: usize::try_from(explored).unwrap_or(usize::MAX),
                regions: data.regions,
                margin,
                confidence: study.about.confidence,
            },
            contexts: Contexts::new(study, plan, data, bench, interrupt)?,
            formal: Predictions::new(study, plan, data, interrupt)?,
            seeds: Seeds::new(
                study.about.seed,
                &format!("disagree {}", plan.evidence(true)),
            ),
            seed: study.about.seed,
            plan: plan.file.clone(),
            data,
            bench,
            assets,
            interrupt,
        })
    }

    /// Episodes, at most.
    pub fn episodes(&self) -> u64 {
        self.data.episodes
    }

    /// Searches.
    pub fn run(
        &self,
        plan: &Plan,
        episodes: Episodes<'_>,
        stage: &Stage,
    ) -> Result<DisagreementMap, Problem> {
        let bad = |e: campaign::CampaignError| plan.mistake("[disagreement]", e.to_string());
        let space = self.contexts.space.clone();
        let search = DisagreementSearch::new(space, self.seeds.of(0), self.options);
        let mut search = search.map_err(bad)?;
        let spent = self.batches(&mut search, episodes, stage)?;
        let predict = |context: &Point| self.formal.at(&self.contexts.space, context);
        let map = search.map(0, 1, MAP_STEPS, &predict);
        self.formal.check()?;
        report::report(self, &search, &map, &spent)
    }

    fn batches(
        &self,
        search: &mut DisagreementSearch,
        episodes: Episodes<'_>,
        stage: &Stage,
    ) -> Result<Spent, Problem> {
        let mut spent = Spent::default();
        while spent.episodes < self.data.episodes && !search.is_over() {
            let left = self.data.episodes - spent.episodes;
            let count = BATCH.min(usize::try_from(left).unwrap_or(BATCH));
            let predict = |context: &Point| self.formal.at(&self.contexts.space, context);
            let contexts = search.ask(count, &predict);
            match self.formal.check() {
                Err(_) if self.interrupt.is_cancelled() => {
                    spent.is_interrupted = true;
                    break;
                }
                checked => checked?,
            }
            let outcomes = match self.outcomes(spent.episodes, &contexts, episodes, stage) {
                // Whole batches are counted: a part of one would depend on the threads. What of it
                // was run is in the journal.
                Err(_) if self.interrupt.is_cancelled() => {
                    spent.is_interrupted = true;
                    break;
                }
                outcomes => outcomes?,
            };
            let Some(outcomes) = outcomes else {
                spent.is_interrupted = true;
                break;
            };
            let failed = outcomes.iter().map(|it| it.failed);
            spent.failed.extend((spent.episodes + 1..).zip(failed));
            spent.episodes += outcomes.len() as u64;
            spent.simulated_secs += outcomes.iter().map(|it| it.simulated_secs).sum::<f64>();
            let told = contexts.into_iter().zip(outcomes);
            let told: Vec<_> = told.map(|(context, it)| (context, it.held)).collect();
            search.tell(&told);
        }
        Ok(spent)
    }

    /// What became of an episode in each context; `None` if one is neither known nor to be run.
    fn outcomes(
        &self,
        before: u64,
        contexts: &[Point],
        episodes: Episodes<'_>,
        stage: &Stage,
    ) -> Result<Option<Vec<Outcome>>, Problem> {
        let stimuli: Result<Vec<Stimulus>, Problem> = contexts
            .iter()
            .map(|context| self.contexts.stimulus(context))
            .collect();
        let numbered: Vec<(u64, Stimulus)> = (before + 1..).zip(stimuli?).collect();
        let known: Vec<Option<Outcome>> = numbered
            .iter()
            .map(|(number, stimulus)| {
                let seed = self.seeds.of(*number);
                episodes.known()?.read(*number, seed, stimulus)
            })
            .collect();
        if matches!(episodes, Episodes::Known(_)) {
            return Ok(known.into_iter().collect());
        }
        stage.skip(known.iter().flatten().count() as u64);
        let work = numbered.par_iter().zip(known);
        // What predicts is of one thread.
        let (seeds, bench, interrupt) = (&self.seeds, &self.contexts, self.interrupt);
        let outcomes = work.map(|((number, stimulus), known)| {
            if let Some(known) = known {
                return Ok(known);
            }
            let seed = seeds.of(*number);
            let outcome = bench.run(stimulus, (seed, *number == 1), interrupt)?;
            if let Episodes::Journal(journal) = episodes {
                journal.add(*number, seed, stimulus, &outcome)?;
            }
            stage.advance();
            Ok(outcome)
        });
        outcomes.collect::<Result<_, _>>().map(Some)
    }
}
