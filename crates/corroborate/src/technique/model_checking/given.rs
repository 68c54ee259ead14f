//! What is asked of a model about a triggered requirement: the probability that a run satisfies it, given that the run
//! triggers it.
//!
//! # Definition
//! With the path formulas `X` of the property and `C` of the trigger (`study::TriggerForm`), which of a failure mode is its
//! opportunity where one is written:
//!
//! ```text
//! P(X | C) = 1 - P(!X & C) / P(C)      of a requirement
//! P(X | C) = P(X & C) / P(C)           of a failure mode
//! ```
//!
//! # Deviation
//! The complement is computed for requirements, since their probability is mostly near 1: where no run fails, the
//! answer is exactly 1. Where `C` is certain, `X` alone is asked. Where the checker refuses the conjunction (some bounds
//! in continuous time), or the trigger is unknown or nowhere written, `X` is asked over all runs, and the finding says so
//! (`evidence::Denominator`).
//!
//! A property that is written as a conditional probability, `P=? [ X || C ]`, has its own `C`, which goes before one that
//! follows from a sentence or a monitor.
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
use host::store::Inputs;
use prism_lang::ast::ExprKind;
use study::{FormText, TriggerForm, quoted_names};

/// Over which runs a subject is asked.
#[derive(Clone, Debug)]
pub(super) enum Over {
    /// Each run triggers it.
    EveryRun,
    /// All runs: nothing says which of them trigger it.
    NoTrigger,
    /// Those that trigger it.
    Given(Box<Given>),
    /// All runs, since what triggers it is unknown to the model, for this reason.
    Unknown(String),
}

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

impl Over {
    /// What an answer depends on besides the properties' texts.
    pub(super) fn inputs(&self, inputs: &mut Inputs) {
        inputs.add_json("over", &self.denominator());
    }

    /// The denominator of the number.
    fn denominator(&self) -> Denominator {
        match self {
            Over::EveryRun => Denominator::EveryRun,
            Over::NoTrigger => Denominator::NoTrigger,
            Over::Given(_) => Denominator::Triggered,
            Over::Unknown(reason) => Denominator::AllRuns {
                reason: reason.clone(),
            },
        }
    }
}

impl<'a> Compiled<'a> {
    /// Over which runs a subject is asked.
    ///
    /// # Errors
    /// A mistake in a trigger that was written by hand, and a trigger written twice.
    pub(super) fn over(
        &self,
        subject: &Subject,
        property: &FormText,
        trigger: &TriggerForm,
    ) -> Result<Over, Problem> {
        if let Some((path, condition)) = conditional(&property.text) {
            if let TriggerForm::Runs(written) = trigger
                && !written.from_sentence
            {
                return Err(self.written_twice(property, written));
            }
            let own = FormText {
                text: format!("P=? [ {condition} ]"),
                ..property.clone()
            };
            return self.given(subject, property, path, &own);
        }
        let trigger = match trigger {
            TriggerForm::Always => return Ok(Over::NoTrigger),
            TriggerForm::Unknown(reason) => return Ok(Over::Unknown(reason.clone())),
            TriggerForm::Runs(text) if self.is_trivial(text) => return Ok(Over::EveryRun),
            TriggerForm::Runs(text) => text,
        };
        match path_of(&property.text) {
            Some(path) => self.given(subject, property, path, trigger),
            None => Ok(Over::Unknown(
                "its property is not of the form `P=? [ … ]`".into(),
            )),
        }
    }

    /// A property with a condition of its own, and a trigger besides.
    fn written_twice(&self, property: &FormText, trigger: &FormText) -> Problem {
        let message = "the property says behind `||` which runs count, and a trigger or an opportunity says it again";
        Problem::new("trigger-twice", message)
            .at_places(
                &self.study.forms.source,
                trigger.span.clone(),
                vec![(property.span.clone(), "the property".into())],
            )
            .remedy(
                "leave one of them out: `P=? [ X ]` with the trigger `P=? [ C ]` asks for what `P=? [ X || C ]` does",
            )
    }

    /// What is asked of the path formula `path` given a trigger.
    fn given(
        &self,
        subject: &Subject,
        property: &FormText,
        path: &str,
        trigger: &FormText,
    ) -> Result<Over, Problem> {
        let missing = quoted_names(&trigger.text)
            .into_iter()
            .find_map(|(name, _)| self.not_expressed.get(name.as_str()));
        if let Some(missing) = missing {
            let missing = missing.trim_end_matches('.');
            return Ok(Over::Unknown(format!(
                "the model does not express what triggers it: {missing}"
            )));
        }
        if let Err(problem) = self.property(&self.model, trigger) {
            return match trigger.from_sentence {
                true => Ok(Over::Unknown(problem.warning_line())),
                false => Err(problem),
            };
        }
        let Some(condition) = path_of(&trigger.text) else {
            return Ok(Over::Unknown(
                "its trigger is not of the form `P=? [ … ]`".into(),
            ));
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
        Ok(match bound {
            Ok(_) => Over::Given(Box::new(Given {
                joint,
                trigger: trigger.clone(),
                conditional,
            })),
            Err(problem) => Over::Unknown(problem.warning_line()),
        })
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
        match &self.over {
            Over::Given(given) if self.has_choices => (&given.conditional, None),
            Over::Given(given) => (&given.joint, Some(&given.trigger)),
            Over::EveryRun | Over::NoTrigger | Over::Unknown(_) => (self.property, None),
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
        self.given().map(|given| &given.trigger)
    }

    /// The properties that are asked of the runs that trigger it, if these are asked.
    pub(super) fn given(&self) -> Option<&Given> {
        match &self.over {
            Over::Given(given) => Some(given),
            Over::EveryRun | Over::NoTrigger | Over::Unknown(_) => None,
        }
    }

    fn is_complement(&self) -> bool {
        !self.has_choices
            && self.given().is_some()
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
            Err(problem) if is_refused(&problem) => Ok((Some(value(self.property)?), divisor)),
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
            return alone(self.over.denominator(), None);
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
            Err(problem) if is_refused(&problem) => {
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

/// The path formula and the condition of a property that is written as `P=? [ X || C ]`.
fn conditional(text: &str) -> Option<(&str, &str)> {
    let parsed = prism_lang::parse_properties(text);
    let property = parsed.tree.properties.first()?;
    let ExprKind::Probability {
        path,
        condition: Some(condition),
        ..
    } = &property.formula.kind
    else {
        return None;
    };
    let of = |span: prism_lang::Span| text.get(span.start..span.end);
    Some((of(path.span)?, of(condition.span)?))
}

#[cfg(test)]
mod tests;
