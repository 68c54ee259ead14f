//! Robust bounds of a model's answers: over all constants within the intervals that their counts leave
//! them, at once at the study's level, by an interval model (`checker::interval_model`).

use super::{Compiled, MAX_STATES};
use crate::technique::counted::CountedConstant;
use checker::interval_model::{ConstantRange, IntervalModel, IntervalModelError};
use diagnostic::Problem;
use evidence::{ConstantInterval, Interval, RobustBounds};
use study::FormText;

impl Compiled<'_> {
    /// Bounds for each question, in their order; with the reason where there are none.
    pub(super) fn robust_bounds(
        &self,
        counted: &[CountedConstant],
        level: stats::Confidence,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<RobustBounds>, Problem> {
        // One range for each constant: the box holds the ties between those of one source, too.
        let posteriors: Vec<_> = counted.iter().map(|it| it.posterior).collect();
        let within = stats::credible_box(&posteriors, level);
        let constants: Vec<ConstantInterval> = counted
            .iter()
            .zip(within)
            .map(|(constant, range)| ConstantInterval {
                constant: constant.name.clone(),
                interval: Interval {
                    low: range.low,
                    high: range.high,
                },
            })
            .collect();
        let blank = RobustBounds {
            constants,
            interval: None,
            reason: None,
        };
        let ranges: Vec<ConstantRange> = blank
            .constants
            .iter()
            .map(|one| ConstantRange {
                name: one.constant.clone(),
                low: one.interval.low,
                high: one.interval.high,
            })
            .collect();
        let model = match IntervalModel::new(&self.tree, &ranges, MAX_STATES, cancel) {
            Ok(model) => model,
            Err(IntervalModelError::Cancelled) => return Err(Problem::interrupted()),
            Err(error) => {
                let reason = Some(error.to_string());
                return Ok(vec![RobustBounds { reason, ..blank }; self.questions.len()]);
            }
        };
        let mut found = Vec::new();
        for question in &self.questions {
            found.push(match &question.missing {
                Some(reason) => RobustBounds {
                    reason: Some(reason.clone()),
                    ..blank.clone()
                },
                None => {
                    let (numerator, divisor) = question.texts();
                    let numerator = self.bounds_of(&model, numerator, cancel)?;
                    let divisor = divisor
                        .map(|text| self.bounds_of(&model, text, cancel))
                        .transpose()?;
                    bounded(&blank, question, numerator, divisor)
                }
            });
        }
        Ok(found)
    }

    /// Bounds of one property, or why there are none.
    fn bounds_of(
        &self,
        model: &IntervalModel,
        text: &FormText,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Result<Interval, String>, Problem> {
        let property = self.property(&self.model, text)?;
        let options = checker::Options {
            cancel: Some(cancel),
            ..checker::Options::default()
        };
        match model.check(&property, &options) {
            Err(checker::CheckError::Cancelled) => Err(Problem::interrupted()),
            Err(error) => Ok(Err(error.to_string())),
            Ok(answer) => {
                let number = match answer.value {
                    checker::AnswerValue::Number(value) => Some((value, value)),
                    _ => None,
                };
                let ends = answer.guarantee.bounds().or(number);
                let interval = ends.map(|(low, high)| Interval { low, high });
                Ok(interval.ok_or_else(|| "the model has several initial states".to_owned()))
            }
        }
    }
}

/// The bounds of a question: of a probability, or of the quotient of two.
fn bounded(
    blank: &RobustBounds,
    question: &super::Question<'_>,
    occurs: Result<Interval, String>,
    opportunity: Option<Result<Interval, String>>,
) -> RobustBounds {
    let quotient = |occurs: Interval, opportunity: Interval| match opportunity.low > 0.0 {
        true => Ok(Interval {
            low: (occurs.low / opportunity.high).next_down().max(0.0),
            high: (occurs.high / opportunity.low).next_up().min(1.0),
        }),
        false => Err("what triggers it may have probability 0".to_owned()),
    };
    let found = match opportunity {
        None => occurs,
        Some(opportunity) => occurs.and_then(|occurs| quotient(occurs, opportunity?)),
    };
    let found = found.map(|interval| question.oriented(interval));
    match found {
        Ok(interval) => RobustBounds {
            interval: Some(interval),
            ..blank.clone()
        },
        Err(reason) => RobustBounds {
            reason: Some(reason),
            ..blank.clone()
        },
    }
}
