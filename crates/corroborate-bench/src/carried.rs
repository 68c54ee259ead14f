//! A formal model with its counted constants open: its answers at points of their posteriors, their distribution,
//! and robust bounds.
//!
//! # Definition
//! As the product does it: each counted constant has the Jeffreys posterior of its counts. The answers are found as
//! rational functions of the constants once ([`checker::parametric::Functions`]) and evaluated at each point of a
//! design; where there are no such functions, or floating point does not suffice for them, the model is solved at each
//! point, of which there are fewer then. A model of many states is always solved: with the handover's 15,623 by functions
//! of its four constants a study took 6 s on average, and takes 0.3 s by solving. Robust bounds are those of an interval
//! model ([`checker::interval_model`]) over all constants within a box that holds them at once at the level
//! ([`stats::credible_box`]).
//!
//! Deviation from the product: fewer points, and no shares of more than first order.

use crate::formal::{Formal, Question};
use checker::explore::explore;
use checker::interval_model::{ConstantRange, IntervalModel};
use checker::parametric::{Functions, RationalFunction};
use checker::{AnswerValue, Options};
use evidence::{CredibleInterval, Interval, Measure};
use prism_lang::{Constants, Property, ast, parse_model};
use stats::{BetaPosterior, Confidence};
use std::collections::BTreeMap;

/// Points at which functions are evaluated.
const POINTS_OF_FUNCTIONS: usize = 500;

/// Points at which a model is solved.
const SOLVES: usize = 250;

/// The same for a model of many states.
const FEW_SOLVES: usize = 40;

/// So many states are many.
const MANY_STATES: usize = 1000;

/// The most states of a corner of an interval model.
const MOST_STATES: usize = 1_000_000;

/// A formal model whose counted constants are open.
pub struct Open<'a> {
    formal: &'a Formal,
    tree: ast::Model,
    /// Functions of the properties' texts, with the place of each function's constants among those counted.
    functions: Option<(Functions, Vec<usize>)>,
    /// How often it is solved, or its functions are evaluated.
    count: usize,
}

impl<'a> Open<'a> {
    /// Opens the counted constants of a model.
    ///
    /// # Errors
    /// What is wrong with the model's text.
    pub fn new(formal: &'a Formal) -> Result<Self, String> {
        let tree = parse_model(&formal.text).into_result();
        let tree = tree.map_err(|e| format!("{e:?}"))?;
        let none = Constants::new();
        let model = prism_lang::resolve(&tree, &none).map_err(|e| format!("{e:?}"))?;
        let space = explore::<f64>(&model).map_err(|error| error.to_string())?;
        let mut open = Self {
            formal,
            tree,
            functions: None,
            count: FEW_SOLVES,
        };
        if space.num_states() > MANY_STATES {
            return Ok(open);
        }
        open.count = SOLVES;
        if let Some((functions, places)) = functions(formal, &open.tree) {
            let means: Vec<f64> = open.posteriors().iter().map(BetaPosterior::mean).collect();
            let means: Vec<f64> = places.iter().map(|place| means[*place]).collect();
            if functions.is_quick_at(&means) {
                (open.functions, open.count) = (Some((functions, places)), POINTS_OF_FUNCTIONS);
            }
        }
        Ok(open)
    }

    /// Points of the constants' posteriors, one column for each in the order of [`Formal::counted`].
    #[must_use]
    pub fn points(&self, seed: u64) -> Vec<Vec<f64>> {
        stats::posterior_design(&self.posteriors(), self.count, seed)
    }

    fn posteriors(&self) -> Vec<BetaPosterior> {
        let counted = self.formal.counted.iter();
        counted.map(|(_, s)| BetaPosterior::jeffreys(*s)).collect()
    }

    /// The value of each question at a point; `None` where the model has none.
    ///
    /// # Errors
    /// What is wrong with the model there.
    pub fn at(&self, point: &[f64]) -> Result<Vec<Option<f64>>, String> {
        if let Some((functions, places)) = &self.functions {
            let open: Vec<f64> = places.iter().map(|place| point[*place]).collect();
            if let Some(values) = functions.at(&open) {
                let texts = self.formal.texts().into_iter();
                return Ok(self.rates(&texts.zip(values).collect()));
            }
        }
        let named = self.formal.counted.iter().zip(point);
        let constants: Vec<(String, f64)> = named
            .map(|((name, _), value)| (name.clone(), *value))
            .collect();
        let methods = [checker::Method::Sound];
        let solved = self.formal.solve(&self.tree, &constants, &methods)?;
        let first = |all: Option<Vec<evidence::MethodAnswer>>| Some(all?.first()?.value);
        Ok(solved.into_iter().map(first).collect())
    }

    /// The questions' rates from the values of the properties' texts.
    fn rates(&self, known: &BTreeMap<&str, f64>) -> Vec<Option<f64>> {
        let rate = |question: &Question| {
            let (occurs, opportunity) = question.property.as_ref()?;
            let occurs = known.get(occurs.as_str())?;
            match opportunity {
                None => Some(*occurs),
                Some(text) => {
                    let of = known.get(text.as_str()).filter(|of| **of > 0.0)?;
                    Some(occurs / of)
                }
            }
        };
        self.formal.questions.iter().map(rate).collect()
    }

    /// Gives each measure the distribution that its constants' posteriors leave it.
    ///
    /// # Errors
    /// What is wrong with the model at some point.
    pub fn carry(
        &self,
        level: Confidence,
        seed: u64,
        measures: &mut [Measure],
    ) -> Result<(), String> {
        let points = self.points(seed);
        let rows = points.iter().map(|point| self.at(point));
        let rows: Vec<Vec<Option<f64>>> = rows.collect::<Result<_, _>>()?;
        let counted = self.formal.counted.iter();
        let names: Vec<&str> = counted.map(|(name, _)| name.as_str()).collect();
        for (place, measure) in measures.iter_mut().enumerate() {
            let values: Option<Vec<f64>> = rows.iter().map(|row| row[place]).collect();
            if let (Some(values), Measure::Probability { credible, .. }) = (values, measure) {
                let carried = CredibleInterval::of_solves(&names, &points, &values, level);
                let mut carried = carried.map_err(|error| error.to_string())?;
                carried.by_function = self.functions.is_some();
                *credible = Some(carried);
            }
        }
        Ok(())
    }

    /// Bounds of each question over all constants that their counts leave at this level, at once; `None` where an
    /// interval model gives none.
    ///
    /// # Errors
    /// What is wrong with a property.
    pub fn robust(&self, level: Confidence) -> Result<Vec<Option<Interval>>, String> {
        let within = stats::credible_box(&self.posteriors(), level);
        let named = self.formal.counted.iter().zip(within);
        let ranges: Vec<ConstantRange> = named
            .map(|((name, _), range)| ConstantRange {
                name: name.clone(),
                low: range.low,
                high: range.high,
            })
            .collect();
        let none = Constants::new();
        let model = prism_lang::resolve(&self.tree, &none).map_err(|e| format!("{e:?}"))?;
        let Ok(box_) = IntervalModel::new(&self.tree, &ranges, MOST_STATES, &|| false) else {
            return Ok(vec![None; self.formal.questions.len()]);
        };
        let bounds = |text: &str| {
            let property = self.formal.property(&model, text)?;
            Ok::<_, String>(bounds_of(&box_, &property))
        };
        let of = |question: &Question| {
            let Some((occurs, opportunity)) = &question.property else {
                return Ok(None);
            };
            let occurs = bounds(occurs)?;
            let Some(opportunity) = opportunity else {
                return Ok(occurs);
            };
            Ok(occurs.zip(bounds(opportunity)?).and_then(quotient))
        };
        self.formal.questions.iter().map(of).collect()
    }
}

/// The functions of all properties; `None` where the checker gives none.
fn functions(formal: &Formal, tree: &ast::Model) -> Option<(Functions, Vec<usize>)> {
    let names: Vec<&str> = formal
        .counted
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let none = Constants::new();
    let model = prism_lang::resolve_open(tree, &none, &none, &names).ok()?;
    let place = |name: &str| names.iter().position(|other| *other == name);
    let places = model.parameters.iter().map(|it| place(&it.name));
    let places: Vec<usize> = places.collect::<Option<_>>()?;
    let space = explore::<RationalFunction>(&model).ok()?;
    let texts = formal.texts().into_iter();
    let properties = texts.map(|text| formal.property(&model, text).ok());
    let properties: Vec<Property> = properties.collect::<Option<_>>()?;
    let options = Options::default();
    let found = Functions::of(&space, &properties, places.len(), &options);
    Some((found.ok()??, places))
}

fn bounds_of(model: &IntervalModel, property: &Property) -> Option<Interval> {
    let answer = model.check(property, &Options::default()).ok()?;
    let number = match answer.value {
        AnswerValue::Number(value) => Some((value, value)),
        _ => None,
    };
    let (low, high) = answer.guarantee.bounds().or(number)?;
    Some(Interval { low, high })
}

/// The bounds of a quotient of probabilities, each division rounded outwards.
fn quotient((occurs, opportunity): (Interval, Interval)) -> Option<Interval> {
    (opportunity.low > 0.0).then(|| Interval {
        low: (occurs.low / opportunity.high).next_down().max(0.0),
        high: (occurs.high / opportunity.low).next_up().min(1.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::{Family, Setup};
    use crate::fault::Assets;
    use crate::random::Random;
    use crate::study::counted_model;

    #[test]
    fn functions_and_solves_agree_and_lie_within_the_robust_bounds() {
        let mut random = Random::new(3, 1);
        let mut setup = Setup::draw(Family::Serial, &mut random);
        setup.count_constants(&mut random);
        let formal = counted_model(&setup, &Assets::sound(&setup)).unwrap();
        let open = Open::new(&formal).unwrap();
        assert!(open.functions.is_some());
        let solving = Open {
            functions: None,
            ..Open::new(&formal).unwrap()
        };
        let robust = open.robust(Confidence::P95).unwrap();
        let means: Vec<f64> = open.posteriors().iter().map(BetaPosterior::mean).collect();
        let (by_function, solved) = (open.at(&means).unwrap(), solving.at(&means).unwrap());
        let mut compared = 0;
        for ((one, other), bounds) in by_function.iter().zip(&solved).zip(&robust) {
            let (Some(one), Some(other)) = (one, other) else {
                assert_eq!(one, other);
                continue;
            };
            assert!((one - other).abs() < 1e-9, "{one} {other}");
            let bounds = bounds.unwrap();
            assert!(bounds.low <= one + 1e-12 && *one <= bounds.high + 1e-12);
            compared += 1;
        }
        assert!(compared > 4, "{compared}");
    }
}
