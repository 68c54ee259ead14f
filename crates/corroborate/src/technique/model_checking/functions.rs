//! The answers to all questions as functions of the constants that were set to counts.

use super::{Compiled, MAX_STATES};
use crate::technique::counted::CountedConstant;
use checker::parametric::RationalFunction;
use checker::{CheckError, Options};
use diagnostic::Problem;
use prism_lang::Constants;
use query::explore;
use std::collections::BTreeMap;
use study::FormText;

/// With more open constants than these in more states than [`MANY_STATES`], functions grow so that the model is solved at all
/// points before they are found.
const MOST_OPEN: usize = 4;
const MANY_STATES: usize = 1_000;

/// What a question gives at one point of the constants.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rate {
    /// The rate that is asked for.
    pub value: Option<Ends>,
    /// The probability of what triggers it, where it is given that.
    pub trigger: Option<Ends>,
}

/// The least and the greatest value over all schedulers: of a chain, its value twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ends {
    pub least: f64,
    pub greatest: f64,
}

impl Ends {
    /// A value that no scheduler changes.
    pub fn both(value: f64) -> Self {
        Self {
            least: value,
            greatest: value,
        }
    }
}

/// Functions of all questions' properties, one point for each set of constants.
pub(super) struct Functions<'a, 'b> {
    of: &'b Compiled<'a>,
    functions: checker::parametric::Functions,
    /// For each open constant of the model the place among those counted.
    places: Vec<usize>,
}

impl<'a> Compiled<'a> {
    /// The properties of all questions that this model can be asked, each once.
    pub(super) fn texts(&self) -> Vec<&FormText> {
        let asked = self.questions.iter().filter(|q| q.missing.is_none());
        let mut texts: Vec<&FormText> = asked
            .flat_map(|question| {
                let (numerator, divisor) = question.texts();
                [Some(numerator), divisor]
            })
            .flatten()
            .collect();
        texts.sort_by(|a, b| a.text.cmp(&b.text));
        texts.dedup_by(|a, b| a.text == b.text);
        texts
    }

    /// The rate that each question asks for and the probability of its trigger, from its properties' values; `None`
    /// where the model cannot be asked, or the trigger has probability 0.
    pub(super) fn rates(&self, known: &BTreeMap<&str, f64>) -> Vec<Rate> {
        let rate = |question: &super::Question<'_>| {
            if question.missing.is_some() {
                return Rate::default();
            }
            let of = |text: &FormText| known.get(text.text.as_str()).copied();
            let (numerator, divisor) = question.texts();
            let trigger = divisor.and_then(of);
            let known = divisor.is_none() || trigger.is_some();
            Rate {
                value: (of(numerator).filter(|_| known))
                    .and_then(|numerator| question.rate(numerator, trigger))
                    .map(Ends::both),
                trigger: trigger.map(Ends::both),
            }
        };
        self.questions.iter().map(rate).collect()
    }

    /// Rational functions of the counted constants; `None` where the checker gives none, so that the model has to be
    /// solved point by point, as a model with choices has to be, whose best choices change with the constants.
    pub(super) fn functions<'b>(
        &'b self,
        counted: &[CountedConstant],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Functions<'a, 'b>>, Problem> {
        if self.model.model_type.has_choices() {
            return Ok(None);
        }
        let open: Vec<&str> = counted.iter().map(|one| one.name.as_str()).collect();
        let none = Constants::new();
        // A guard or an initial value may depend on a constant: then there is no such function.
        let Ok(model) = prism_lang::resolve_open(&self.tree, &none, &none, &open) else {
            return Ok(None);
        };
        let place = |name: &str| open.iter().position(|other| *other == name);
        let places: Option<Vec<usize>> = (model.parameters.iter())
            .map(|parameter| place(&parameter.name))
            .collect();
        let space = explore::<RationalFunction>(&self.source, &model, MAX_STATES, cancel);
        let (Some(places), Ok(space)) = (places, space) else {
            return match cancel() {
                true => Err(Problem::interrupted()),
                false => Ok(None),
            };
        };
        if open.len() > MOST_OPEN && space.num_states() > MANY_STATES {
            return Ok(None);
        }
        let texts = self.texts().into_iter();
        let properties: Vec<_> = texts
            .map(|text| self.property(&model, text))
            .collect::<Result<_, _>>()?;
        let options = Options {
            cancel: Some(cancel),
            ..Options::default()
        };
        let found = checker::parametric::Functions::of(&space, &properties, places.len(), &options);
        match found {
            Err(CheckError::Cancelled) => Err(Problem::interrupted()),
            Err(_) => Ok(None),
            Ok(functions) => Ok(functions.map(|functions| Functions {
                of: self,
                functions,
                places,
            })),
        }
    }
}

impl Functions<'_, '_> {
    /// Whether points like this one cost nearly nothing.
    pub fn is_quick_at(&self, point: &[f64]) -> bool {
        let open: Vec<f64> = self.places.iter().map(|place| point[*place]).collect();
        self.functions.is_quick_at(&open)
    }

    /// The rate that each question asks for at one point of the counted constants; `None` where the functions do not
    /// say it.
    pub fn at(&self, point: &[f64]) -> Option<Vec<Rate>> {
        let open: Vec<f64> = self.places.iter().map(|place| point[*place]).collect();
        let values = self.functions.at(&open)?;
        let texts = self.of.texts().into_iter().map(|text| text.text.as_str());
        Some(self.of.rates(&texts.zip(values).collect()))
    }
}
