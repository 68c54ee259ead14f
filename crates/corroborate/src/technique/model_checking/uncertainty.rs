//! The uncertainty of constants that were set to counts, carried through the
//! model.
//!
//! # Definition
//! Each source of counts (`technique::counted`) has the Jeffreys posterior of its counts, over all that its runs without a
//! verdict may have shown, independent of the others; the
//! constants that were set to it have one value. The posterior of a probability is that of the model's answer
//! when the constants are drawn from theirs. It is found from the answers
//! at the points of a low-discrepancy design, all questions on the same points
//! (common random numbers), and at the nodes of quadrature rules from which each constant's share in the variance
//! follows (Sobol' indices, `stats::propagation`). Where the answers are rational functions of the constants
//! (`checker::parametric`), these are found once and evaluated at each point, at more of them if floating point
//! suffices there; else the model is solved at each.
//!
//! A model with choices is solved for its least and its greatest probability over all schedulers at each point. Each end
//! has a distribution; the interval reaches from the lower limit of the least to the upper limit of the greatest, each at
//! half of what the level leaves, so that the whole range lies within with at least the level's posterior probability
//! (Bonferroni's inequality, `evidence::CredibleInterval::of_ends`).
//!
//! A constant that was solved for has at each point the value with which the model has the rate of that point
//! ([`super::solved`]), with the other constants as they are there. Robust bounds are not found then.
//!
//! # Assumes
//! Sources of counts are independent of each other, with Jeffreys' priors, and their trials are, or count at their
//! effective size. The model is right but for these constants.
//!
//! # Guarantee
//! None but convergence: the quantiles are estimates from the design's points, and the shares come with their
//! error. Beside them stand robust bounds, which hold (see [`super::robust`]).

use super::answer::answer;
use super::functions::{Ends, Functions, Rate};
use super::{Compiled, MAX_STATES, schedulers};
use crate::technique::Influence;
use crate::technique::counted::{CountedConstant, Sources};
use diagnostic::Problem;
use evidence::{CredibleInterval, Finding, Measure, RobustBounds, Subject};
use host::{Cancel, Stage};
use prism_lang::ast::Optimum;
use query::explore;
use rayon::prelude::*;
use std::collections::BTreeMap;
use study::{FormText, Method};

/// Points at which functions are evaluated where floating point suffices for them, which costs nearly nothing, for each
/// constant and two more.
const POINTS_OF_FUNCTIONS: usize = 8192;

/// States that are solved at no great cost, over all points.
const STATES_SOLVED: usize = 400_000;

/// Points at which functions are tried before they are evaluated at all others.
const POINTS_TRIED: usize = 64;

/// Where a constant is solved for at each point, which takes some ten answers, there are so many times fewer points.
const SHARE_OF_SOLVED: usize = 4;

/// A change of a probability below this is rounding.
pub(super) const NO_EFFECT: f64 = 1e-9;

/// Points at which a model is solved: as many as draws of its constants give quantiles, with those of a grid that
/// tells the shares of up to six constants to a fraction of a point. More constants have their columns exchanged. A small
/// model is solved at more: the limits that a verdict rests on are far quantiles, which a thousand draws leave open by a point.
fn solves(constants: usize, (states, at_most): (usize, usize)) -> usize {
    let least = match constants {
        0..=6 => 1000 + 100 * constants,
        _ => 250 * (constants + 2),
    };
    least.max(at_most.min(STATES_SOLVED / states.max(1)))
}

impl Compiled<'_> {
    /// Which failure modes, through constants that are held, bear on which
    /// requirement: those whose constant moves its probability.
    pub(super) fn influences(
        &self,
        held: &[CountedConstant],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Influence>, Problem> {
        let mut influences = Vec::new();
        for constant in held {
            let as_written = self.solve_at(&[], &[], cancel)?;
            let moved = self.solve_at(
                std::slice::from_ref(constant),
                &[constant.posterior.mean()],
                cancel,
            )?;
            for (place, question) in self.questions.iter().enumerate() {
                if let (Subject::Requirement(requirement), Subject::FailureMode(mode)) =
                    (question.subject, &constant.subject)
                    && let (Some(before), Some(after)) =
                        (as_written[place].value, moved[place].value)
                {
                    influences.push(Influence {
                        requirement: requirement.clone(),
                        failure_mode: mode.clone(),
                        bears: (before.least - after.least).abs() > NO_EFFECT
                            || (before.greatest - after.greatest).abs() > NO_EFFECT,
                    });
                }
            }
        }
        Ok(influences)
    }

    pub(super) fn carry_uncertainty(
        &self,
        id: &str,
        (counted, states): (&[CountedConstant], usize),
        findings: &mut [Finding],
        interrupt: &Cancel,
        begin: &dyn Fn(&str, u64) -> Stage,
    ) -> Result<(), Problem> {
        let level = crate::technique::confidence(self.study.about.confidence)?;
        let cancel = || interrupt.is_cancelled();
        let solved = self.solved_for(counted, &cancel)?;
        let counted = &solved.counted[..];
        if counted.is_empty() {
            return Ok(());
        }
        let sources = Sources::of(counted);
        let constants_at = |point: &[f64]| solved.as_written(sources.constants_at(point));
        let functions = self.functions(counted, &cancel)?;
        let functions = functions.filter(|it| !self.is_slow_about(it, &sources, &constants_at));
        let means: Vec<f64> = sources
            .posteriors
            .iter()
            .map(|posterior| posterior.mean())
            .collect();
        let at_most = match solved.is_any() {
            true => POINTS_OF_FUNCTIONS / SHARE_OF_SOLVED,
            false => POINTS_OF_FUNCTIONS,
        };
        let evaluations = match &functions {
            Some(functions) if functions.is_quick_at(&constants_at(&means)) => {
                at_most * (means.len() + 2)
            }
            _ => solves(means.len(), (states, at_most)),
        };
        let design =
            stats::SharesDesign::new(&sources.posteriors, evaluations, self.study.about.seed);
        let stage = begin(
            &format!("{id}: uncertainty of its constants"),
            design.rows().len() as u64,
        );
        let at = |point: &[f64]| {
            let by_function = functions.as_ref().and_then(|functions| functions.at(point));
            match by_function {
                Some(row) => Ok(row),
                None => self.solve_at(counted, point, &cancel),
            }
        };
        let rows: Vec<Option<(Vec<Rate>, bool)>> = design
            .rows()
            .par_iter()
            .map(|point| {
                if interrupt.is_cancelled() {
                    return Err(Problem::interrupted());
                }
                let row = solved.row(sources.constants_at(point), &at, &cancel);
                stage.advance();
                row
            })
            .collect::<Result<_, _>>()?;
        let rows: Option<(Vec<Vec<Rate>>, Vec<bool>)> = rows.into_iter().collect();
        let Some((rows, reached)) = rows else {
            let set = counted.iter().filter(|it| it.solved_for.is_none());
            let set: Vec<CountedConstant> = set.cloned().collect();
            return self.carry_uncertainty(id, (&set, states), findings, interrupt, begin);
        };
        let draws = &reached[..design.draws()];
        let beyond = draws.iter().filter(|reaches| !**reaches).count();
        let out_of_reach = beyond as f64 / draws.len() as f64;
        let robust = match solved.is_any() {
            false => self.robust_bounds(counted, level, &cancel)?,
            true => solved.without_bounds(self.questions.len()),
        };
        let names: Vec<&str> = sources.names.iter().map(String::as_str).collect();
        for (place, question) in self.questions.iter().enumerate() {
            let Some(finding) = findings.iter_mut().find(|f| &f.subject == question.subject) else {
                continue;
            };
            let carried = |values: Option<Vec<Ends>>, measure: &mut Measure, robust| {
                let carry = Carry {
                    names: &names,
                    design: &design,
                    level,
                    question,
                    out_of_reach,
                };
                carry.put(measure, values, functions.is_some(), robust)
            };
            let rates = rows.iter().map(|row| row[place].value).collect();
            let bounds = Some(Box::new(robust[place].clone()));
            carried(rates, &mut finding.measure, bounds)?;
            if let Some(trigger) = &mut finding.trigger {
                let values = rows.iter().map(|row| row[place].trigger).collect();
                carried(values, trigger, None)?;
            }
        }
        Ok(())
    }

    /// Whether floating point suffices for the functions at the means and not about them: in rational arithmetic a point
    /// takes longer than to solve the model there.
    fn is_slow_about(
        &self,
        functions: &Functions<'_, '_>,
        sources: &Sources,
        constants_at: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> bool {
        let means: Vec<f64> = sources.posteriors.iter().map(|it| it.mean()).collect();
        let design =
            stats::SharesDesign::new(&sources.posteriors, POINTS_TRIED, self.study.about.seed);
        let is_quick = |point: &[f64]| functions.is_quick_at(&constants_at(point));
        is_quick(&means) && !design.rows().iter().all(|point| is_quick(point))
    }

    /// The questions' values with the counted constants at one point; `None`
    /// for questions that the model does not express.
    pub(super) fn solve_at(
        &self,
        counted: &[CountedConstant],
        point: &[f64],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Rate>, Problem> {
        let names = counted.iter().map(|constant| constant.name.clone());
        let point: Vec<(String, f64)> = names.zip(point.iter().copied()).collect();
        let model = self.model_at(&point)?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let mut known: BTreeMap<(String, bool), f64> = BTreeMap::new();
        let mut value = |text: &FormText, optimum: Optimum| -> Result<f64, Problem> {
            let key = (text.text.clone(), optimum == Optimum::Max);
            if let Some(value) = known.get(&key) {
                return Ok(*value);
            }
            let property = self.property_over(&model, text, optimum)?;
            let value = answer(&property, Method::Sound, &space, None, cancel)?.value;
            known.insert(key, value);
            Ok(value)
        };
        let rate = |question: &super::Question<'_>| match question.missing {
            Some(_) => Ok(Rate::default()),
            None => {
                let ends = question.ends_at(&mut value);
                Ok(self.unless_refused(question, ends)?.unwrap_or_default())
            }
        };
        self.questions.iter().map(rate).collect()
    }
}

/// What the answers to one question at a design's points say.
struct Carry<'c> {
    names: &'c [&'c str],
    design: &'c stats::SharesDesign,
    level: stats::Confidence,
    question: &'c super::Question<'c>,
    /// The share of draws with a rate that the model cannot have.
    out_of_reach: f64,
}

impl Carry<'_> {
    /// Puts the distribution beside a measure's answer, where there is one with a known error.
    fn put(
        &self,
        measure: &mut Measure,
        values: Option<Vec<Ends>>,
        by_function: bool,
        robust: Option<Box<RobustBounds>>,
    ) -> Result<(), Problem> {
        let (
            Some(values),
            Measure::Probability {
                answer, credible, ..
            },
        ) = (values, measure)
        else {
            return Ok(());
        };
        let least: Vec<f64> = values.iter().map(|ends| ends.least).collect();
        let found = match (self.question.has_choices, answer.bounds()) {
            (true, None) => return Ok(()),
            (true, Some(as_written)) => {
                let greatest: Vec<f64> = values.iter().map(|ends| ends.greatest).collect();
                let worst = schedulers::worst(self.question.subject);
                let both = (least.as_slice(), greatest.as_slice());
                CredibleInterval::of_ends(self.names, self.design, both, worst, self.level)
                    .map(|found| found.beside_ends(as_written))
            }
            (false, _) => CredibleInterval::of_design(self.names, self.design, &least, self.level),
        };
        let found =
            found.map_err(|error| Problem::new("cannot-carry-uncertainty", error.to_string()))?;
        *credible = Some(CredibleInterval {
            by_function,
            robust,
            out_of_reach: self.out_of_reach,
            ..found.beside(answer.value)
        });
        Ok(())
    }
}
