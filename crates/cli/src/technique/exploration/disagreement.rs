//! The search for disagreement: contexts in which the formal model predicts
//! one thing and the bench shows another.
//!
//! An episode ends as soon as the requirement is decided in it.
//!
//! A context is a point of declared parameters, which set the bench's data and,
//! through declared constants, the model. For each context that is looked at
//! the model is checked anew, once: declare choices rather than continuous
//! ranges where models are large.

use super::bench::{OpenBench, failed};
use super::plan::{DisagreementData, Plan};
use crate::problem::Problem;
use crate::study::{Study, Work};
use crate::talk::{Interrupt, Stage};
use crate::technique::campaign::OnLine;
use crate::technique::judging::Judges;
use crate::technique::model_checking::Compiled;
use crate::technique::simulation::Seeds;
use campaign::{Agreement, DisagreementOptions, DisagreementSearch};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;
use stimulus::{Point, Space, Stimulus};
use temporal::monitor::Verdict;
use trace::Trace;

/// What was found of contexts.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DisagreementReport {
    /// The requirement whose probability is compared.
    pub requirement: String,
    /// The ledger's entry whose formal model predicts.
    pub model: String,
    /// Differences up to this one do not matter.
    pub margin: f64,
    /// Probability with which no context is wrongly decided.
    pub confidence: f64,
    /// Episodes that were run.
    pub episodes: u64,
    /// Simulated time of all episodes.
    pub simulated_secs: f64,
    /// Contexts, those that disagree first, by the size of the difference.
    pub contexts: Vec<ContextReport>,
    /// What the first stage suggests, over the first two parameters; the
    /// others are at their nominal values. Estimates, not evidence.
    pub map: Vec<MapReport>,
}

/// A context that was tried until it was decided, or the budget ended.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ContextReport {
    /// Its parameters.
    pub parameters: BTreeMap<String, f64>,
    /// The model's constants that follow the context.
    pub constants: BTreeMap<String, f64>,
    /// The model's probability with these constants, by the sound method.
    pub predicted: f64,
    /// Fresh episodes in which the requirement held.
    pub successes: u64,
    /// Fresh episodes that were judged.
    pub trials: u64,
    /// The bench's rate is at least this, whenever one looked.
    pub low: f64,
    /// The bench's rate is at most this.
    pub high: f64,
    /// disagrees, agrees or undecided.
    pub agreement: String,
}

/// A place of the map.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MapReport {
    /// Its parameters.
    pub parameters: BTreeMap<String, f64>,
    /// The model's probability.
    pub predicted: f64,
    /// The bench's rate, as few episodes suggest it.
    pub simulated: f64,
    /// Standard deviation of that estimate.
    pub sd: f64,
}

/// Episodes between two looks at what they showed.
const BATCH: usize = 20;
/// Contexts that are tried again, at most.
const CONTEXTS: usize = 6;
/// Places of the map in each direction.
const MAP_STEPS: usize = 8;
/// A model is checked for at most so many different contexts.
const MOST_CHECKS: usize = 2000;

/// Searches for disagreement as a plan declares it.
pub fn disagreement(
    study: &Study,
    plan: &Plan,
    bench: &OpenBench,
    interrupt: &Interrupt,
    begin: &dyn Fn(&str, u64) -> Stage,
) -> Result<DisagreementReport, Problem> {
    let Some(data) = &plan.data.disagreement else {
        return Err(plan
            .mistake("", "it says nothing of disagreement")
            .remedy("add a [disagreement] table with the requirement and the contexts"));
    };
    let setup = Setup::new(study, plan, data, bench)?;
    let margin = data.margin.or_else(|| {
        let of = study.requirements.iter().find(|r| r.id == data.requirement);
        of.map(|requirement| requirement.margin)
    });
    let options = DisagreementOptions {
        explore: usize::try_from(data.episodes / 2).unwrap_or(usize::MAX),
        contexts: CONTEXTS,
        margin: margin.unwrap_or(0.05),
        confidence: study.about.confidence,
    };
    let bad = |e: campaign::CampaignError| plan.mistake("[disagreement]", e.to_string());
    let seeds = Seeds::new(
        study.about.seed,
        &format!("disagree {}", plan.evidence(true)),
    );
    let search = DisagreementSearch::new(setup.space.clone(), seeds.of(0), options);
    let mut search = search.map_err(bad)?;
    let formal = Predictions::new(study, plan, data, interrupt)?;
    let stage = begin("looking for disagreement", data.episodes);
    let (mut episodes, mut simulated_secs) = (0, 0.0);
    while episodes < data.episodes && !search.is_over() {
        let count = BATCH.min(usize::try_from(data.episodes - episodes).unwrap_or(BATCH));
        let contexts = search.ask(count, &|context| formal.at(&setup.space, context));
        formal.check()?;
        if contexts.is_empty() {
            break;
        }
        let numbered: Vec<(u64, Point)> = (episodes + 1..).zip(contexts).collect();
        episodes += numbered.len() as u64;
        let outcomes: Vec<(Point, Option<bool>, f64)> = numbered
            .par_iter()
            .map(|(number, context)| {
                let outcome = setup.outcome(context, seeds.of(*number), interrupt);
                stage.advance();
                let (outcome, secs) = outcome?;
                Ok((context.clone(), outcome, secs))
            })
            .collect::<Result<_, Problem>>()?;
        // An episode that could not be judged is no outcome.
        simulated_secs += outcomes.iter().map(|(.., secs)| secs).sum::<f64>();
        let judged = outcomes.into_iter();
        let judged: Vec<(Point, bool)> = judged.filter_map(|(c, o, _)| Some((c, o?))).collect();
        search.tell(&judged);
    }
    let map = search.map(0, 1, MAP_STEPS, &|context| formal.at(&setup.space, context));
    formal.check()?;
    let named = |point: &Point| named(&setup.space, point);
    Ok(DisagreementReport {
        requirement: data.requirement.clone(),
        model: formal.entry.clone(),
        margin: options.margin,
        confidence: options.confidence,
        episodes,
        simulated_secs,
        contexts: search
            .findings()
            .iter()
            .map(|f| context(f, &named, formal.constants(&setup.space, &f.context)))
            .collect(),
        map: map
            .into_iter()
            .map(|cell| MapReport {
                parameters: named(&cell.context),
                predicted: cell.predicted,
                simulated: cell.simulated,
                sd: cell.sd,
            })
            .collect(),
    })
}

fn context(
    finding: &campaign::Finding,
    named: &dyn Fn(&Point) -> BTreeMap<String, f64>,
    constants: Vec<(String, f64)>,
) -> ContextReport {
    ContextReport {
        parameters: named(&finding.context),
        constants: constants.into_iter().collect(),
        predicted: finding.predicted,
        successes: finding.sample.successes,
        trials: finding.sample.trials,
        low: finding.interval.low,
        high: finding.interval.high,
        agreement: match finding.agreement {
            Agreement::Disagrees => "disagrees",
            Agreement::Undecided => "undecided",
            Agreement::Agrees => "agrees",
        }
        .into(),
    }
}

fn named(space: &Space, point: &Point) -> BTreeMap<String, f64> {
    let values = space.parameters.iter().zip(&point.0);
    values.map(|(p, value)| (p.name.clone(), *value)).collect()
}

/// What runs episodes in contexts.
struct Setup<'a> {
    bench: &'a OpenBench,
    judges: Judges<'a>,
    layout: Trace,
    space: Space,
    test: stimulus::AbstractTest,
    requirement: String,
    early_end: bool,
}

impl<'a> Setup<'a> {
    fn new(
        study: &'a Study,
        plan: &Plan,
        data: &DisagreementData,
        bench: &'a OpenBench,
    ) -> Result<Self, Problem> {
        let space = Space {
            parameters: data.parameter.clone(),
            constraints: Vec::new(),
        };
        space
            .check()
            .map_err(|e| plan.mistake("[[disagreement.parameter]]", e.to_string()))?;
        let test = bench.own_tests().iter().find(|t| t.name == data.test);
        let test = test.cloned().ok_or_else(|| {
            plan.mistake(&data.test, format!("the bench has no test `{}`", data.test))
        })?;
        let id = &data.requirement;
        if study.forms.by_id(id).is_none_or(|f| f.monitor.is_none()) {
            let message = format!("the study has no requirement `{id}` with a monitor");
            return Err(plan.mistake(id, message));
        }
        Ok(Self {
            requirement: data.requirement.clone(),
            early_end: plan.data.budget.early_end,
            bench,
            judges: Judges::new(study, |subject| subject.id() == data.requirement)?,
            layout: bench.layout()?,
            space,
            test,
        })
    }

    /// Whether the requirement held, if it was judged, and the simulated time.
    fn outcome(
        &self,
        context: &Point,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<(Option<bool>, f64), Problem> {
        if interrupt.is_set() {
            return Err(Problem::interrupted());
        }
        let stimulus: Stimulus = self
            .space
            .stimulus(&self.test, context)
            .map_err(|e| Problem::new("bad-exploration", e.to_string()))?;
        let judges = [&self.judges];
        let mut on_line = OnLine::new(&judges, &self.layout, false)?;
        if self.early_end {
            on_line = on_line.until_decided(&self.requirement);
        }
        let recorded = self.bench.watched(&stimulus, seed, &mut on_line, interrupt);
        let recorded = recorded.map_err(|error| failed(&error))?;
        let judgements = on_line.finish(recorded.trace.complete)?;
        let mut judgements = judgements.iter().flatten();
        let main = judgements.find(|j| j.reading.is_none());
        let outcome = main.and_then(|judgement| match judgement.findings.verdict {
            Verdict::Satisfied => Some(true),
            Verdict::Violated => Some(false),
            Verdict::NotCovered | Verdict::Inconclusive => None,
        });
        Ok((outcome, recorded.sim_secs))
    }
}

/// The model's probabilities, each context's computed once.
struct Predictions<'a> {
    /// The ledger's entry.
    entry: String,
    compiled: Compiled<'a>,
    data: &'a DisagreementData,
    interrupt: &'a Interrupt,
    known: RefCell<BTreeMap<Vec<u64>, f64>>,
    failed: RefCell<Option<Problem>>,
}

impl<'a> Predictions<'a> {
    fn new(
        study: &'a Study,
        plan: &'a Plan,
        data: &'a DisagreementData,
        interrupt: &'a Interrupt,
    ) -> Result<Self, Problem> {
        let entry = data.model.as_ref().or(plan.data.model.as_ref());
        let entry = entry.ok_or_else(|| {
            plan.mistake(
                "",
                "it names no model, so there is nothing to disagree with",
            )
        })?;
        let Work::Check { model, .. } = &study.entry(entry)?.work else {
            return Err(plan.mistake(entry, format!("`{entry}` is no formal model")));
        };
        let compiled = Compiled::new(study, model)?;
        for constant in &data.constant {
            if compiled.constant(&constant.name).is_none() {
                let message = format!("the model has no constant `{}`", constant.name);
                return Err(plan.mistake(&constant.name, message));
            }
            if !data.parameter.iter().any(|p| p.name == constant.parameter) {
                let message = format!("there is no parameter `{}`", constant.parameter);
                return Err(plan.mistake(&constant.parameter, message));
            }
        }
        Ok(Self {
            entry: entry.clone(),
            compiled,
            data,
            interrupt,
            known: RefCell::default(),
            failed: RefCell::default(),
        })
    }

    /// The model's probability in a context; 0.5 once something has failed.
    fn at(&self, space: &Space, context: &Point) -> f64 {
        let values = self.constants(space, context);
        let key: Vec<u64> = values.iter().map(|(_, value)| value.to_bits()).collect();
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        if self.failed.borrow().is_some() {
            return 0.5;
        }
        match self.compute(&values) {
            Ok(value) => {
                self.known.borrow_mut().insert(key, value);
                value
            }
            Err(problem) => {
                *self.failed.borrow_mut() = Some(problem);
                0.5
            }
        }
    }

    /// The constants that follow a context.
    fn constants(&self, space: &Space, context: &Point) -> Vec<(String, f64)> {
        let values = self.data.constant.iter().map(|constant| {
            let place = space.index_of(&constant.parameter);
            let value = place.and_then(|p| context.0.get(p)).copied();
            let value = constant.offset + constant.factor * value.unwrap_or(0.0);
            (constant.name.clone(), value.clamp(0.0, 1.0))
        });
        values.collect()
    }

    fn compute(&self, constants: &[(String, f64)]) -> Result<f64, Problem> {
        if self.known.borrow().len() >= MOST_CHECKS {
            let message =
                format!("the model would be checked for more than {MOST_CHECKS} contexts");
            return Err(Problem::new("bad-exploration", message)
                .remedy("declare the parameters that constants follow as a `choice` of values"));
        }
        let cancel = || self.interrupt.is_set();
        let id = &self.data.requirement;
        let found = self.compiled.probability_at(id, constants, &cancel)?;
        found.ok_or_else(|| {
            let message = format!("the model does not express requirement `{id}`");
            Problem::new("bad-exploration", message)
        })
    }

    /// What has failed, if anything has.
    fn check(&self) -> Result<(), Problem> {
        match self.failed.borrow_mut().take() {
            Some(problem) => Err(problem),
            None => Ok(()),
        }
    }
}
