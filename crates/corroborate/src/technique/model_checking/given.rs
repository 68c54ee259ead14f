//! What is asked of a model about a triggered requirement: the probability that a run satisfies it, given that the run
//! triggers it.
//!
//! # Definition
//! With the path formulas `X` of the property and `C` of the trigger (`study::TriggerForm`):
//!
//! ```text
//! P(X | C) = 1 - P(!X & C) / P(C)      of a requirement
//! P(X | C) = P(X & C) / P(C)           of a failure mode
//! ```
//!
//! # Deviation
//! The complement is computed for requirements, since their probability is mostly near 1: where no run fails, the
//! answer is exactly 1. Where `C` is certain, `X` alone is asked. Where the checker refuses the conjunction (some bounds
//! in continuous time), or the trigger is unknown, `X` is asked over all runs, and the finding says so
//! (`evidence::Denominator`).
//!
//! Where the model has choices, the least and the greatest conditional probability have a scheduler each, so they are not
//! quotients of optima: the checker finds them in the process with restarts (Baier, Klein, Klüppelholz and Märcker
//! 2014), over the schedulers under which `C` is possible (`super::schedulers`).
//!
//! # Guarantee
//! The bounds of the quotient are those that the bounds of both probabilities imply, rounded outwards.

use super::{Compiled, Question};
use diagnostic::Problem;
use evidence::{Denominator, Interval, Measure, MethodAnswer, Subject};
use study::{FormText, TriggerForm, quoted_names};

/// The two properties whose probabilities' quotient is asked.
#[derive(Clone, Debug)]
pub(super) struct Given {
    /// Of a requirement `!X & C`, of a failure mode `X & C`.
    pub joint: FormText,
    /// `C`.
    pub trigger: FormText,
    /// `X` given `C`, for models whose schedulers may make the quotient another's.
    pub conditional: FormText,
}

/// What one question gave.
pub(super) struct Asked {
    pub measure: Measure,
    pub denominator: Denominator,
    pub trigger: Option<Box<Measure>>,
}

impl<'a> Compiled<'a> {
    /// The properties that are asked, nothing where every run triggers the subject, or why the trigger is unknown.
    pub(super) fn given(
        &self,
        subject: &Subject,
        property: &FormText,
        trigger: &TriggerForm,
    ) -> Result<Result<Option<Given>, String>, Problem> {
        let trigger = match trigger {
            TriggerForm::Always => return Ok(Ok(None)),
            TriggerForm::Unknown(reason) => return Ok(Err(reason.clone())),
            TriggerForm::Runs(text) if self.is_trivial(text) => return Ok(Ok(None)),
            TriggerForm::Runs(text) => text,
        };
        let missing = quoted_names(&trigger.text)
            .into_iter()
            .find_map(|(name, _)| self.not_expressed.get(name.as_str()));
        if let Some(missing) = missing {
            let missing = missing.trim_end_matches('.');
            return Ok(Err(format!(
                "the model does not express what triggers it: {missing}"
            )));
        }
        if let Err(problem) = self.property(&self.model, trigger) {
            return match trigger.from_sentence {
                true => Ok(Err(problem.warning_line())),
                false => Err(problem),
            };
        }
        let Some((path, condition)) = path_of(&property.text).zip(path_of(&trigger.text)) else {
            return Ok(Err("its property is not of the form `P=? [ … ]`".into()));
        };
        let not = match subject {
            Subject::Requirement(_) => "!",
            Subject::FailureMode(_) => "",
        };
        let joint = FormText {
            text: format!("P=? [ {not}({path}) & ({condition}) ]"),
            ..property.clone()
        };
        let conditional = FormText {
            text: format!("P=? [ ({path}) || ({condition}) ]"),
            ..property.clone()
        };
        let bound = self
            .property(&self.model, &joint)
            .and_then(|_| self.property(&self.model, &conditional));
        Ok(bound
            .map(|_| {
                Some(Given {
                    joint,
                    trigger: trigger.clone(),
                    conditional,
                })
            })
            .map_err(|problem| problem.warning_line()))
    }

    /// Whether a trigger that was derived holds on every run of every model: all that it speaks of is bound to `true`.
    fn is_trivial(&self, text: &FormText) -> bool {
        let is_true = |(name, _): (String, _)| {
            let proposition = self.study.vocabulary.propositions.get(&name);
            let binding = proposition.and_then(|it| it.model.as_ref());
            binding.is_some_and(|binding| binding.text.trim() == "true")
        };
        text.from_sentence
            && !text.text.contains(['!', 'X'])
            && !text.text.contains("=>")
            && !text.text.contains("false")
            && quoted_names(&text.text).into_iter().all(is_true)
    }
}

impl Question<'_> {
    /// The texts whose probabilities give the rate: a numerator, and what it is divided by.
    pub(super) fn texts(&self) -> (&FormText, Option<&FormText>) {
        match (&self.opportunity, &self.given) {
            (None, Ok(Some(given))) if self.has_choices => (&given.conditional, None),
            (Some(opportunity), _) => (self.property, Some(opportunity)),
            (None, Ok(Some(given))) => (&given.joint, Some(&given.trigger)),
            (None, _) => (self.property, None),
        }
    }

    /// The rate from the probabilities of [`Question::texts`]; `None` where the subject is never triggered.
    pub(super) fn rate(&self, numerator: f64, divisor: Option<f64>) -> Option<f64> {
        match divisor {
            None => Some(numerator),
            Some(divisor) if divisor > 0.0 && self.is_complement() => {
                Some((1.0 - numerator / divisor).clamp(0.0, 1.0))
            }
            Some(divisor) if divisor > 0.0 => Some((numerator / divisor).min(1.0)),
            Some(_) => None,
        }
    }

    /// Bounds of the rate from those of the quotient.
    pub(super) fn oriented(&self, quotient: Interval) -> Interval {
        match self.is_complement() {
            true => Interval {
                low: 1.0 - quotient.high,
                high: 1.0 - quotient.low,
            },
            false => quotient,
        }
    }

    /// What asks for the probability of the trigger, where that is not certain.
    pub(super) fn trigger(&self) -> Option<&FormText> {
        let given = self.given.as_ref().ok().and_then(Option::as_ref);
        self.opportunity.or(given.map(|given| &given.trigger))
    }

    fn is_complement(&self) -> bool {
        !self.has_choices
            && self.opportunity.is_none()
            && matches!(self.given, Ok(Some(_)))
            && matches!(self.subject, Subject::Requirement(_))
    }

    /// The rate at one state space, whose properties `value` answers; over all runs where the checker refuses the
    /// conjunction. With it the trigger's probability.
    pub(super) fn rate_at(
        &self,
        value: &mut dyn FnMut(&FormText) -> Result<f64, Problem>,
    ) -> Result<(Option<f64>, Option<f64>), Problem> {
        let (numerator, divisor) = self.texts();
        let divisor = divisor.map(&mut *value).transpose()?;
        match value(numerator) {
            Ok(numerator) => Ok((self.rate(numerator, divisor), divisor)),
            Err(problem) if self.opportunity.is_none() && is_refused(&problem) => {
                Ok((Some(value(self.property)?), divisor))
            }
            Err(problem) => Err(problem),
        }
    }

    /// The answers of all methods, each found by `answer`.
    pub(super) fn ask(
        &self,
        methods: usize,
        answer: &dyn Fn(usize, &FormText) -> Result<MethodAnswer, Problem>,
    ) -> Result<Asked, Problem> {
        let all = |text: &FormText| {
            (0..methods)
                .map(|m| answer(m, text))
                .collect::<Result<Vec<_>, _>>()
        };
        let alone = |denominator, trigger| {
            Ok(Asked {
                measure: probability(all(self.property)?),
                denominator,
                trigger,
            })
        };
        let Some(trigger) = self.trigger() else {
            return match &self.given {
                Err(reason) => alone(
                    Denominator::AllRuns {
                        reason: reason.clone(),
                    },
                    None,
                ),
                Ok(_) => alone(Denominator::EveryRun, None),
            };
        };
        let triggers = all(trigger)?;
        let shown = Some(Box::new(probability(triggers.clone())));
        let bounds = triggers[0].bounds();
        if triggers[0].value <= 0.0 && bounds.is_none_or(|bounds| bounds.high <= 0.0) {
            return Ok(Asked {
                measure: Measure::NotCovered {
                    reason: match self.subject {
                        Subject::Requirement(_) => {
                            "In the model, it is triggered with probability 0."
                        }
                        Subject::FailureMode(_) => {
                            "In the model, the opportunity has probability 0."
                        }
                    }
                    .into(),
                },
                denominator: Denominator::Triggered,
                trigger: shown,
            });
        }
        if bounds.is_some_and(|bounds| bounds.low >= 1.0) {
            return alone(Denominator::EveryRun, shown);
        }
        match all(self.texts().0) {
            Ok(joint) => Ok(Asked {
                measure: probability(match self.texts().1 {
                    Some(_) => self.quotients(&joint, &triggers),
                    None => joint,
                }),
                denominator: Denominator::Triggered,
                trigger: shown,
            }),
            Err(problem) if self.opportunity.is_none() && is_refused(&problem) => {
                let reason = format!(
                    "the checker does not compute it given the trigger: {}",
                    problem.message()
                );
                alone(Denominator::AllRuns { reason }, shown)
            }
            Err(problem) => Err(problem),
        }
    }

    fn quotients(&self, joint: &[MethodAnswer], triggers: &[MethodAnswer]) -> Vec<MethodAnswer> {
        let quotient = |(joint, trigger): (&MethodAnswer, &MethodAnswer)| {
            let quotient = joint.quotient(trigger);
            match self.is_complement() {
                true => quotient.contrary(),
                false => quotient,
            }
        };
        joint.iter().zip(triggers).map(quotient).collect()
    }
}

/// The first answer counts, the others stand beside it.
fn probability(mut answers: Vec<MethodAnswer>) -> Measure {
    let answer = answers.remove(0);
    Measure::Probability {
        answer,
        others: answers,
        credible: None,
    }
}

/// Whether the checker does not do what is asked, which is no mistake of the study's.
pub(super) fn is_refused(problem: &Problem) -> bool {
    problem.code == "cannot-check"
}

/// What stands in the brackets of `P=? [ … ]`.
fn path_of(text: &str) -> Option<&str> {
    let (open, close) = (text.find('[')?, text.rfind(']')?);
    text.get(open + 1..close).map(str::trim)
}

#[cfg(test)]
mod tests;
