//! Properties of a chain at many points of its open constants, by their rational functions.
//!
//! # Definition
//! Each property is solved once, with the constants open ([`super::solve`]); its function is then evaluated at a
//! point in floating point with bounds of the rounding ([`Compiled`]), or, where these are too wide (coefficients of
//! hundreds of digits that cancel), in rational arithmetic, which takes about a thousand times as long.
//!
//! # Guarantee
//! A value is that of the model at the point to within [`ACCURACY`]. Where a probability of the model may not be
//! positive, so that the model might have another graph there, there is none.

use super::{Compiled, ParametricValue, RationalFunction, Region, solve};
use crate::state_space::StateSpace;
use crate::{CheckError, Options};
use prism_lang::{Property, Rational, rational_to_f64};

/// What rounding may leave open of a value.
pub const ACCURACY: f64 = 1e-10;

/// Functions of a model's open constants, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Functions {
    positive: Vec<Compiled>,
    values: Vec<(RationalFunction, Compiled)>,
}

impl Functions {
    /// Functions of properties, one each. `None` where there are none: the model has choices or several initial states, a
    /// property is not a number or not the same function everywhere, or a function becomes too large.
    ///
    /// # Errors
    /// [`CheckError::Cancelled`] only.
    pub fn of(
        space: &StateSpace<RationalFunction>,
        properties: &[Property],
        parameters: usize,
        options: &Options<'_>,
    ) -> Result<Option<Self>, CheckError> {
        if space.kind.has_choices() {
            return Ok(None);
        }
        let region = Region::unit(parameters);
        let mut functions = Self {
            positive: Vec::new(),
            values: Vec::new(),
        };
        for (place, property) in properties.iter().enumerate() {
            let answer = match solve(space, property, &region, options) {
                Ok(answer) => answer,
                Err(CheckError::Cancelled) => return Err(CheckError::Cancelled),
                Err(_) => return Ok(None),
            };
            let ([part], true) = (&answer.parts[..], answer.undecided.is_empty()) else {
                return Ok(None);
            };
            let [ParametricValue::Function(value)] = &part.values[..] else {
                return Ok(None);
            };
            let Some(compiled) = value.compiled() else {
                return Ok(None);
            };
            functions.values.push((value.clone(), compiled));
            if place > 0 {
                continue;
            }
            // They speak of the model, and are the same for each property.
            for condition in &answer.conditions.each {
                match condition.function.compiled() {
                    Some(function) => functions.positive.push(function),
                    None => return Ok(None),
                }
            }
        }
        Ok(Some(functions))
    }

    /// Whether floating point suffices at a point, and so about it.
    #[must_use]
    pub fn is_quick_at(&self, point: &[f64]) -> bool {
        let mut values = self.values.iter();
        values.all(|(_, compiled)| quickly(compiled, point).is_some())
    }

    /// The properties' values at a point, one number for each open constant; `None` where they are not known.
    #[must_use]
    pub fn at(&self, point: &[f64]) -> Option<Vec<f64>> {
        let positive = self
            .positive
            .iter()
            .all(|function| function.at(point).low > 0.0);
        let exactly = |function: &RationalFunction| {
            let exact: Option<Vec<Rational>> =
                point.iter().map(|x| Rational::from_float(*x)).collect();
            Some(rational_to_f64(&function.at(&exact?)?))
        };
        let value = |(function, compiled): &(RationalFunction, Compiled)| {
            quickly(compiled, point).or_else(|| exactly(function))
        };
        positive.then(|| self.values.iter().map(value).collect())?
    }
}

fn quickly(function: &Compiled, point: &[f64]) -> Option<f64> {
    let bounds = function.at(point);
    (bounds.high - bounds.low <= ACCURACY).then(|| f64::midpoint(bounds.low, bounds.high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explore::explore;
    use crate::{AnswerValue, Method, check_space};
    use prism_lang::{Constants, Number, Value, parse_model, parse_properties};
    use prism_lang::{resolve_open, resolve_properties, resolve_with};

    const MODEL: &str = "dtmc const double p; const double q = 0.5; module m s : [0..3];
        [] s=0 -> p:(s'=1) + 1-p:(s'=2); [] s=1 -> q:(s'=3) + 1-q:(s'=0); endmodule";

    fn functions(model: &str, asked: &str, open: &[&str]) -> Option<Functions> {
        let none = Constants::new();
        let model = resolve_open(&parse_model(model).tree, &none, &none, open).unwrap();
        let asked = resolve_properties(&parse_properties(asked).tree, &model, &none).unwrap();
        let asked: Vec<Property> = asked.into_iter().map(|named| named.property).collect();
        let space = explore::<RationalFunction>(&model).unwrap();
        Functions::of(&space, &asked, open.len(), &Options::default()).unwrap()
    }

    #[test]
    fn values_are_those_of_the_model_solved_at_the_point() {
        let asked = "P=? [ F s=3 ]; P=? [ F<=3 s=2 ]";
        let found = functions(MODEL, asked, &["p", "q"]).unwrap();
        for point in [[0.5, 0.25], [1e-9, 0.999], [0.99, 1e-6]] {
            let mut given = Constants::new();
            for (name, value) in ["p", "q"].into_iter().zip(point) {
                given.set(
                    name.to_owned(),
                    Value::Double(Number::from_approximate(value)),
                );
            }
            let tree = parse_model(MODEL).tree;
            let model = resolve_with(&tree, &Constants::new(), &given).unwrap();
            let space = explore::<f64>(&model).unwrap();
            let properties =
                resolve_properties(&parse_properties(asked).tree, &model, &Constants::new());
            let values = found.at(&point).unwrap();
            for (property, value) in properties.unwrap().iter().zip(values) {
                let options = Options::with_method(Method::Sound);
                let solved = check_space(&space, &property.property, &options).unwrap();
                let AnswerValue::Number(expected) = solved.value else {
                    panic!("no number")
                };
                assert!((value - expected).abs() < 1e-9, "{value} {expected}");
            }
        }
    }

    #[test]
    fn where_the_graph_is_another_and_where_there_is_choice_there_is_none() {
        let found = functions(MODEL, "P=? [ F s=3 ]", &["p", "q"]).unwrap();
        for end in [[0.0, 0.5], [0.5, 1.0], [1.0, 0.0]] {
            assert_eq!(found.at(&end), None);
        }
        // The terms of 1 - (1-p)^60 cancel to their last digit where p is large: then it is found exactly.
        let many =
            "dtmc const double p; module m s : [0..1]; [] s=0 -> p:(s'=1) + 1-p:true; endmodule";
        let found = functions(many, "P=? [ F<=60 s=1 ]", &["p"]).unwrap();
        for point in [1e-3_f64, 0.2, 0.7] {
            let expected = -(60.0 * (-point).ln_1p()).exp_m1();
            let value = found.at(&[point]).unwrap()[0];
            assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        }
        assert!(found.is_quick_at(&[1e-3]) && !found.is_quick_at(&[0.7]));
        let choices = "mdp const double p; module m s : [0..2]; [] s=0 -> p:(s'=1) + 1-p:(s'=2);
            [] s=0 -> (s'=2); endmodule";
        assert!(functions(choices, "Pmax=? [ F s=1 ]", &["p"]).is_none());
    }
}
