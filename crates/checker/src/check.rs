//! The entry points: a property and a state space in, an answer with its guarantee out.

use prism_lang::{Property, Rational};

use crate::answer::{Answer, CheckError, Method, Options};
use crate::engine::{Exact, PrismDefault, Sound};
use crate::property::Checker;
use crate::state_space::StateSpace;

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
        Method::Sound => Checker::<Sound>::new(space, options)?.answer(property, Method::Sound),
        Method::PrismDefault => {
            Checker::<PrismDefault>::new(space, options)?.answer(property, Method::PrismDefault)
        }
        Method::Exact => Err(CheckError::Unsupported(
            "the exact method needs a state space with rational probabilities".to_owned(),
        )),
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
    Checker::<Exact>::new(space, options)?.answer(property, Method::Exact)
}
