//! The uncertainty of constants that were set to counts, carried through the
//! model.
//!
//! # Definition
//! Each counted constant has the Jeffreys posterior of its counts, independent
//! of the others. The posterior of a probability is that of the model's answer
//! when the constants are drawn from theirs. It is found from the answers
//! at the points of a low-discrepancy design, all questions on the same points
//! (common random numbers), and at the nodes of quadrature rules from which each constant's share in the variance
//! follows (Sobol' indices, `stats::propagation`). Where the answers are rational functions of the constants
//! (`checker::parametric`), these are found once and evaluated at each point, at more of them if floating point
//! suffices; else the model is solved at each.
//!
//! # Guarantee
//! None but convergence: the quantiles are estimates from the design's points, and the shares come with their
//! error. Beside them stand robust bounds, which hold (see [`super::robust`]).

use super::answer::{answer, explore};
use super::functions::Rate;
use super::{Compiled, CountedConstant, MAX_STATES};
use crate::problem::Problem;
use crate::study::{FormText, Method};
use crate::talk::{Interrupt, Stage};
use crate::technique::Influence;
use evidence::{CredibleInterval, Finding, Measure, Subject};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Points at which functions are evaluated where floating point suffices for them, which costs nearly nothing, for each
/// constant and two more.
const POINTS_OF_FUNCTIONS: usize = 8192;

/// A change of a probability below this is rounding.
const NO_EFFECT: f64 = 1e-9;

/// Points at which a model is solved: as many as draws of its constants give quantiles, with those of a grid that
/// tells the shares of up to six constants to a fraction of a point. More constants have their columns exchanged.
fn solves(constants: usize) -> usize {
    match constants {
        0..=6 => 1000 + 100 * constants,
        _ => 250 * (constants + 2),
    }
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
            let posterior = stats::BetaPosterior::jeffreys(constant.sample);
            let as_written = self.solve_at(&[], &[], cancel)?;
            let moved =
                self.solve_at(std::slice::from_ref(constant), &[posterior.mean()], cancel)?;
            for (place, question) in self.questions.iter().enumerate() {
                if let (Subject::Requirement(requirement), Subject::FailureMode(mode)) =
                    (question.subject, &constant.subject)
                    && let (Some(before), Some(after)) =
                        (as_written[place].value, moved[place].value)
                {
                    influences.push(Influence {
                        requirement: requirement.clone(),
                        failure_mode: mode.clone(),
                        bears: (before - after).abs() > NO_EFFECT,
                    });
                }
            }
        }
        Ok(influences)
    }

    pub(super) fn carry_uncertainty(
        &self,
        id: &str,
        counted: &[CountedConstant],
        findings: &mut [Finding],
        interrupt: &Interrupt,
        begin: &dyn Fn(&str, u64) -> Stage,
    ) -> Result<(), Problem> {
        let level = crate::technique::confidence(self.study.about.confidence)?;
        let posteriors: Vec<_> = counted
            .iter()
            .map(|constant| stats::BetaPosterior::jeffreys(constant.sample))
            .collect();
        let functions = self.functions(counted, &|| interrupt.is_set())?;
        let means: Vec<f64> = posteriors
            .iter()
            .map(|posterior| posterior.mean())
            .collect();
        let evaluations = match &functions {
            Some(functions) if functions.is_quick_at(&means) => {
                POINTS_OF_FUNCTIONS * (posteriors.len() + 2)
            }
            _ => solves(posteriors.len()),
        };
        let design = stats::SharesDesign::new(&posteriors, evaluations, self.study.about.seed);
        let stage = begin(
            &format!("{id}: uncertainty of its constants"),
            design.rows().len() as u64,
        );
        let rows: Vec<Vec<Rate>> = design
            .rows()
            .par_iter()
            .map(|point| {
                if interrupt.is_set() {
                    return Err(Problem::interrupted());
                }
                let by_function = functions.as_ref().and_then(|functions| functions.at(point));
                let row = match by_function {
                    Some(row) => Ok(row),
                    None => self.solve_at(counted, point, &|| interrupt.is_set()),
                };
                stage.advance();
                row
            })
            .collect::<Result<_, _>>()?;
        let robust = self.robust_bounds(counted, &posteriors, level, &|| interrupt.is_set())?;
        let names: Vec<&str> = counted.iter().map(|one| one.name.as_str()).collect();
        for (place, question) in self.questions.iter().enumerate() {
            let Some(finding) = findings.iter_mut().find(|f| &f.subject == question.subject) else {
                continue;
            };
            let carried = |values: Option<Vec<f64>>, measure: &mut Measure, robust| {
                let (
                    Some(values),
                    Measure::Probability {
                        answer, credible, ..
                    },
                ) = (values, measure)
                else {
                    return Ok(());
                };
                let found = CredibleInterval::of_design(&names, &design, &values, level)
                    .map_err(|error| Problem::new("cannot-carry-uncertainty", error.to_string()))?;
                *credible = Some(CredibleInterval {
                    by_function: functions.is_some(),
                    robust,
                    ..found.beside(answer.value)
                });
                Ok(())
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

    /// The questions' values with the counted constants at one point; `None`
    /// for questions that the model does not express.
    fn solve_at(
        &self,
        counted: &[CountedConstant],
        point: &[f64],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Rate>, Problem> {
        let names = counted.iter().map(|constant| constant.name.clone());
        let point: Vec<(String, f64)> = names.zip(point.iter().copied()).collect();
        let model = self.model_at(&point)?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let mut known: BTreeMap<String, f64> = BTreeMap::new();
        let mut value = |text: &FormText| -> Result<f64, Problem> {
            if let Some(value) = known.get(&text.text) {
                return Ok(*value);
            }
            let property = self.property(&model, text)?;
            let value = answer(&property, Method::Sound, &space, None, cancel)?.value;
            known.insert(text.text.clone(), value);
            Ok(value)
        };
        let rate = |question: &super::Question<'_>| {
            if question.missing.is_some() {
                return Ok(Rate::default());
            }
            let (value, trigger) = question.rate_at(&mut value)?;
            Ok(Rate { value, trigger })
        };
        self.questions.iter().map(rate).collect()
    }
}
