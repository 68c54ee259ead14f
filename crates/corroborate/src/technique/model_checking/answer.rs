//! One answer of the checker in the form of evidence.

use checker::state_space::StateSpace;
use checker::{AnswerValue, Options};
use diagnostic::Problem;
use evidence::{Guarantee, MethodAnswer};
use prism_lang::{Property, Rational};
use study::Method;

/// The answer to a `P=?` property in the form of evidence.
pub fn answer(
    property: &Property,
    method: Method,
    space: &StateSpace<f64>,
    exact_space: Option<&StateSpace<Rational>>,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<MethodAnswer, Problem> {
    let mut options = Options::with_method(method.of_checker());
    options.cancel = Some(cancel);
    let answer = match (method, exact_space) {
        (Method::Exact, Some(space)) => checker::check_exact(space, property, &options),
        _ => checker::check_space(space, property, &options),
    };
    let answer = answer.map_err(|error| match error {
        checker::CheckError::Cancelled => Problem::interrupted(),
        other => Problem::new("cannot-check", other.to_string()),
    })?;
    let (value, rational) = match &answer.value {
        AnswerValue::Number(value) => (*value, None),
        AnswerValue::Exact(value) => (prism_lang::rational_to_f64(value), Some(value.to_string())),
        _ => {
            return Err(Problem::new(
                "several-initial-states",
                "the model has several initial states, so the property has no single value",
            )
            .remedy("give the model one initial state"));
        }
    };
    Ok(MethodAnswer {
        method: method.name().to_owned(),
        value,
        complement: answer.sharp_complement(),
        guarantee: Guarantee::of(&answer.guarantee, rational.filter(|text| text.len() <= 60)),
        iterations: (answer.iterations > 0).then_some(answer.iterations),
    })
}
