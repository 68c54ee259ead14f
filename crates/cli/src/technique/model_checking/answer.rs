//! One answer of the checker in the form of evidence.

use crate::problem::{Problem, Source};
use crate::study::Method;
use checker::explore::{ExploreError, ExploreOptions, explore_with};
use checker::state_space::StateSpace;
use checker::{AnswerValue, Options};
use evidence::{Guarantee, MethodAnswer};
use prism_lang::{Property, Rational, resolved};

/// Builds the state space of a model whose text is in `source`.
pub fn explore<N: prism_lang::Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    max_states: usize,
    cancel: &dyn Fn() -> bool,
) -> Result<StateSpace<N>, Problem> {
    let limits = ExploreOptions {
        max_states,
        ..ExploreOptions::default()
    };
    explore_within(source, model, limits, &|_| !cancel())
}

/// The same with all limits, and a choice of reward structures; `go_on` is told how many states there are so far.
pub fn explore_within<N: prism_lang::Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    limits: ExploreOptions,
    go_on: &dyn Fn(usize) -> bool,
) -> Result<StateSpace<N>, Problem> {
    explore_with(model, limits, go_on).map_err(|error| {
        if error == ExploreError::Cancelled {
            return Problem::interrupted();
        }
        let problem = Problem::new("cannot-explore", error.to_string());
        let problem = match error {
            ExploreError::TooManyStates { .. } => problem.remedy(
                "make the model smaller, for example by its constants; `check` takes more with --max-states",
            ),
            _ => problem,
        };
        match error.span() {
            Some(span) => problem.at(source, span.start..span.end),
            None => problem,
        }
    })
}

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
        complement: sharp_complement(&answer),
        guarantee: match &answer.guarantee {
            checker::Guarantee::Exact => Guarantee::Exact {
                rational: rational.filter(|text| text.len() <= 60),
            },
            checker::Guarantee::Bounded { low, high } => Guarantee::Bounded {
                low: *low,
                high: *high,
            },
            checker::Guarantee::Estimated { reason } => Guarantee::Estimated {
                reason: reason.clone(),
            },
            checker::Guarantee::Statistical { .. } => Guarantee::Estimated {
                reason: "a statistical answer".into(),
            },
        },
        iterations: (answer.iterations > 0).then_some(answer.iterations),
    })
}

/// One minus the probability, unless its bounds are so far apart that its digits
/// mean nothing.
pub fn sharp_complement(answer: &checker::Answer) -> Option<f64> {
    match answer.complement_bounds {
        Some((low, high)) if high - low > low * SHARP => None,
        _ => answer.complement,
    }
}

/// Relative width up to which a complement is shown.
const SHARP: f64 = 1e-3;
