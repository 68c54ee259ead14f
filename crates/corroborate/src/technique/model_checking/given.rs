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
//! # Assumes
//! The bounds of both probabilities hold.
//!
//! # Guarantee
//! The bounds of the quotient are those that the bounds of both probabilities imply, rounded outwards.

use super::{Compiled, Question, never};
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
    /// Where `C` was written by hand and something else may trigger the monitor.
    pub beside: Option<Beside>,
}

/// What may trigger the monitor in other runs than those of the trigger that was written by hand.
#[derive(Clone, Debug)]
pub(super) struct Beside {
    /// What triggers the monitor, as a property.
    monitored: FormText,
    /// That only the one of both comes: either way.
    only_one: [FormText; 2],
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
        monitored: &TriggerForm,
    ) -> Result<Over, Problem> {
        let over = self.over_as_written(subject, property, trigger)?;
        let Over::Given(given) = over else {
            return Ok(over);
        };
        let beside = self.beside(&given.trigger, monitored);
        Ok(Over::Given(Box::new(Given { beside, ..*given })))
    }

    /// What tells whether the monitor is triggered in other runs, where the model can be asked.
    fn beside(&self, written: &FormText, monitored: &TriggerForm) -> Option<Beside> {
        let TriggerForm::Runs(monitored) = monitored else {
            return None;
        };
        let (ours, theirs) = (path_of(&written.text)?, path_of(&monitored.text)?);
        if written.from_sentence || ours == theirs {
            return None;
        }
        let only = |one: &str, other: &str| FormText {
            text: format!("P=? [ ({one}) & !({other}) ]"),
            ..written.clone()
        };
        let only_one = [only(ours, theirs), only(theirs, ours)];
        let is_expressed = |text: &FormText| {
            let mut names = quoted_names(&text.text).into_iter();
            names.all(|(name, _)| !self.not_expressed.contains_key(name.as_str()))
                && self.property(&self.model, text).is_ok()
        };
        only_one.iter().all(is_expressed).then(|| Beside {
            monitored: monitored.clone(),
            only_one,
        })
    }

    fn over_as_written(
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
                beside: None,
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

    /// What triggers the monitor, where that may be in other runs.
    pub(super) fn monitored(&self) -> Option<&FormText> {
        Some(&self.given()?.beside.as_ref()?.monitored)
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
        let over_its_runs = match self.other_trigger(&|text| answer(0, text))? {
            Some(other) => other,
            None => Denominator::Triggered,
        };
        let shown = Some(Box::new(probability(triggers.clone())));
        let bounds = triggers[0].bounds();
        if triggers[0].value <= 0.0 && bounds.is_none_or(|bounds| bounds.high <= 0.0) {
            return Ok(Asked {
                measure: Measure::NotCovered {
                    reason: never::reason(
                        self.subject,
                        trigger,
                        &|text| Ok(answer(0, text)?.value),
                    ),
                    constant: None,
                },
                denominator: Denominator::Triggered,
                trigger: shown,
            });
        }
        if bounds.is_some_and(|bounds| bounds.low >= 1.0) {
            let denominator = match over_its_runs {
                Denominator::OtherTrigger { .. } => over_its_runs,
                _ => Denominator::EveryRun,
            };
            return alone(denominator, shown);
        }
        match all(self.texts().0) {
            Ok(joint) => Ok(Asked {
                measure: probability(match self.texts().1 {
                    Some(_) => self.quotients(&joint, &triggers),
                    None => joint,
                }),
                denominator: over_its_runs,
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

    /// The denominator of a trigger that was written by hand, where the model has runs that satisfy it and do not trigger the
    /// monitor, or the other way round.
    fn other_trigger(
        &self,
        answer: &dyn Fn(&FormText) -> Result<MethodAnswer, Problem>,
    ) -> Result<Option<Denominator>, Problem> {
        let Some((given, beside)) = self.given().and_then(|it| Some((it, it.beside.as_ref()?)))
        else {
            return Ok(None);
        };
        for text in &beside.only_one {
            let chance = match answer(text) {
                Ok(found) => found.bounds().map_or(found.value, |bounds| bounds.high),
                Err(problem) if is_refused(&problem) => return Ok(None),
                Err(problem) => return Err(problem),
            };
            if chance > SOME_RUNS {
                let in_words = |text: &FormText| {
                    study::text_in_words(&text.text)
                        .unwrap_or(&text.text)
                        .to_owned()
                };
                return Ok(Some(Denominator::OtherTrigger {
                    trigger: in_words(&given.trigger),
                    monitor: in_words(&beside.monitored),
                }));
            }
        }
        Ok(None)
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

/// Runs of a smaller probability may be rounding.
const SOME_RUNS: f64 = 1e-6;

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
pub(super) fn path_of(text: &str) -> Option<&str> {
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
