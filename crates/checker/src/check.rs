//! The entry points: a property and a state space in, an answer with its guarantee out.

use prism_lang::resolved::Model;
use prism_lang::{Number, Property, Rational, rational_to_f64};

use crate::amount::Amount;
use crate::answer::{Answer, AnswerValue, CheckError, Guarantee, Options};
use crate::engine::{Exact, Plain, Sound};
use crate::evaluate::Evaluator;
use crate::evaluate::bounds_of_states::StateBounds;
use crate::explore::{ExploreError, ExploreOptions, explore_with};
use crate::method::Method;
use crate::rounding::Bounds;
use crate::state_space::StateSpace;
use crate::symmetry::Symmetry;

/// By how much bounds are tightened when they leave a comparison open, and how far at most.
const TIGHTER: f64 = 1e-6;
const TIGHTEST: f64 = 1e-13;

/// Checks a property of a model, of which `space` is the state space.
///
/// The exact method builds the state space again, with rational probabilities; so does a method with bounds when
/// these, tightened once, leave a comparison such as `P>=0.5` open, unless the model is larger than
/// [`Options::exact_limit`], and for several objectives (`multi`). The answer's `method` says which one was used
/// in the end.
///
/// # Errors
/// See [`CheckError`].
///
/// ```
/// use checker::explore::explore;
/// use checker::{AnswerValue, Method, Options, check};
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
///
/// let text = "dtmc module coin s : [0..2]; [] s=0 -> 1/3:(s'=0) + 1/3:(s'=1) + 1/3:(s'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let properties = parse_properties("P=? [ F s=1 ]; P>=0.5 [ F s=1 ]").tree;
/// let properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
/// let space = explore::<f64>(&model)?;
/// let exactly = Options::with_method(Method::Exact);
/// let half = check(&space, &model, &properties[0].property, &exactly)?;
/// assert_eq!(half.value, AnswerValue::Exact(prism_lang::Rational::new(1.into(), 2.into())));
/// // No floating-point bounds can tell 1/2 from a little less.
/// let at_least_half = check(&space, &model, &properties[1].property, &Options::default())?;
/// assert_eq!(at_least_half.value, AnswerValue::Truth(true));
/// assert_eq!(at_least_half.method, Method::Exact);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check(
    space: &StateSpace<f64>,
    model: &Model,
    property: &Property,
    options: &Options<'_>,
) -> Result<Answer, CheckError> {
    check_or_exact(space, property, options, &|| {
        exact_space(space, model, property, options)
    })
}

/// The same for a state space that no model in the PRISM language stands behind, such as one that was read from
/// files; `exact` is asked for it with rational probabilities.
///
/// # Errors
/// See [`CheckError`], and what `exact` fails with.
pub fn check_or_exact(
    space: &StateSpace<f64>,
    property: &Property,
    options: &Options<'_>,
    exact: &dyn Fn() -> Result<StateSpace<Rational>, CheckError>,
) -> Result<Answer, CheckError> {
    if options.method == Method::Exact {
        return check_exact(&exact()?, property, options);
    }
    let is_multi = matches!(property, Property::Objectives(_));
    if is_multi && space.num_states() <= options.exact_limit {
        let mut answer = in_floats(check_exact(&exact()?, property, options)?);
        if options.method != Method::Sound {
            let note =
                "several objectives are computed in rational arithmetic, whatever method is named";
            answer.notes.push(note.to_owned());
        }
        return Ok(answer);
    }
    let tighter = Options {
        precision: (options.precision * TIGHTER)
            .max(TIGHTEST)
            .min(options.precision),
        ..*options
    };
    let answer = match check_space(space, property, options) {
        Err(CheckError::Undecided {
            bounds, is_whole, ..
        }) if tighter.precision < options.precision => {
            let known = is_whole.then_some(bounds);
            let answer = check_space(space, property, &tighter);
            answer.map_err(|error| with_known(error, known)).map(|mut answer| {
                let precision = tighter.precision;
                let note = format!(
                    "the bounds were tightened to a relative distance of {precision:e} to decide"
                );
                answer.notes.push(note);
                answer
            })
        }
        answer => answer,
    };
    match answer {
        Err(CheckError::Undecided {
            comparison,
            bounds,
            is_whole,
        }) if space.num_states() <= options.exact_limit => {
            let known = is_whole.then_some(bounds);
            let answer = exact().and_then(|space| check_exact(&space, property, options));
            let mut answer = answer.map_err(|error| with_known(error, known))?;
            answer.notes.push(format!(
                "floating-point bounds left open whether a probability is {comparison}, so \
                 rational arithmetic was used"
            ));
            Ok(answer)
        }
        other => other,
    }
}

/// What ended a second try, with the bounds that the first one left if it was ended from outside.
fn with_known(error: CheckError, known: Option<Bounds>) -> CheckError {
    match (error, known) {
        (CheckError::Cancelled | CheckError::Stopped { reached: None }, Some(_)) => {
            CheckError::Stopped { reached: known }
        }
        (
            CheckError::Stopped {
                reached: Some(bounds),
            },
            Some(known),
        ) => CheckError::Stopped {
            reached: Some(Bounds {
                low: bounds.low.max(known.low),
                high: bounds.high.min(known.high),
            }),
        },
        (error, _) => error,
    }
}

/// A number as the nearest floating-point one, with its bounds.
fn in_floats(mut answer: Answer) -> Answer {
    if let AnswerValue::Exact(value) = &answer.value {
        let bounds = Bounds::literal(&Number::from_rational(value.clone()));
        let (low, high) = (bounds.low, bounds.high);
        answer.value = AnswerValue::Number(rational_to_f64(value));
        if !bounds.is_exact() {
            answer.guarantee = Guarantee::Bounded { low, high };
        }
    }
    answer
}

/// The state space with rational probabilities, as far as the property needs it: up to symmetry if the other one is.
fn exact_space(
    space: &StateSpace<f64>,
    model: &Model,
    property: &Property,
    options: &Options<'_>,
) -> Result<StateSpace<Rational>, CheckError> {
    let go_on = |_| !options.is_cancelled();
    let symmetry = match space.represented {
        Some(_) => Symmetry::of_while(model, [property], &|| !options.is_cancelled()),
        None => Symmetry::default(),
    };
    let limits = ExploreOptions {
        symmetry,
        ..ExploreOptions::for_properties([property])
    };
    explore_with(model, limits, &go_on).map_err(|error| match error {
        ExploreError::Cancelled => CheckError::Cancelled,
        error => CheckError::ExactModel(error.to_string()),
    })
}

/// Checks a property on a state space whose transition probabilities are floating-point numbers.
///
/// # Errors
/// See [`CheckError`]. [`CheckError::Undecided`] when a comparison with a bound is open: decide it by
/// [`check_exact`]. [`CheckError::Unsupported`] for [`Method::Exact`], which needs a rational state space.
///
/// ```
/// use checker::state_space::{Csr, StateSpace};
/// use checker::{AnswerValue, Guarantee, Options, check_space};
/// use prism_lang::{Path, Property, StateFormula, TimeBound};
///
/// // From state 0 to 1 with probability 1/4, to 2 with 1/2, and back with 1/4.
/// let rows = vec![vec![(0, 0.25), (1, 0.25), (2, 0.5)], vec![(1, 1.0)], vec![(2, 1.0)]];
/// let done = vec![("done".to_owned(), vec![false, true, false])];
/// let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], done);
/// let label = StateFormula::Label("done".to_owned());
/// let path = Path::Finally {
///     operand: Box::new(Path::State(Box::new(label))),
///     bound: TimeBound::default(),
/// };
/// let property = Property::Probability { bound: None, path };
/// let answer = check_space(&space, &property, &Options::default())?;
/// let AnswerValue::Number(value) = answer.value else { unreachable!() };
/// assert!((value - 1.0 / 3.0).abs() < 1e-12);
/// let Guarantee::Bounded { low, high } = answer.guarantee else { unreachable!() };
/// assert!(low <= 1.0 / 3.0 && 1.0 / 3.0 <= high && high - low < 1e-12);
/// # Ok::<(), checker::CheckError>(())
/// ```
pub fn check_space(
    space: &StateSpace<f64>,
    property: &Property,
    options: &Options<'_>,
) -> Result<Answer, CheckError> {
    match options.method {
        Method::Exact => Err(CheckError::Unsupported(
            "the exact method needs a state space with rational probabilities".to_owned(),
        )),
        method if method.is_estimate() => Evaluator::<Plain>::new(space, options)?.answer(property),
        _ => Evaluator::<Sound>::new(space, options)?.answer(property),
    }
}

/// Checks a property in rational arithmetic, whatever method the options name.
///
/// # Errors
/// See [`CheckError`].
pub fn check_exact(
    space: &StateSpace<Rational>,
    property: &Property,
    options: &Options<'_>,
) -> Result<Answer, CheckError> {
    let evaluator = Evaluator::<Exact>::new(space, options)?;
    match property {
        Property::Objectives(objectives) => evaluator.objectives(objectives, property),
        property => evaluator.answer(property),
    }
}

/// Bounds of a property's value in every state that are meant to be inductive, so that they can be checked without
/// solving anything (crate `certifier`): the method's own, widened by `slack` times what they fall short.
///
/// # Errors
/// See [`CheckError`]; [`CheckError::Unsupported`] for properties other than unbounded `F`, `G`, `U` and rewards before a
/// target.
pub fn bounds_of_states(
    space: &StateSpace<f64>,
    property: &Property,
    options: &Options<'_>,
    slack: f64,
) -> Result<StateBounds, CheckError> {
    Evaluator::<Sound>::new(space, options)?.bounds_of_states(property, slack)
}
