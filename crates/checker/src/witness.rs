//! Why: the most probable path that shows what a property asks for, or that violates it.
//!
//! *Definition.* For the probability of `left U right`, also within steps (and so `F`): the most probable path through
//! states of `left` to one of `right`. For `G`, `W` and `R`: likewise the path that violates them. In a decision
//! process it is a path of the chain that the answer's scheduler induces; in continuous time the probabilities are
//! those of the jumps. Other formulas have no such path here.
//!
//! Method and source: [`crate::paths`] (Dijkstra; Han, Katoen and Damman 2009). Guarantee: of [`most_probable_path`].
//! A path longer than the formula's bound in steps is none: then no witness is given.

use std::borrow::Cow;

use prism_lang::property::{Path as Formula, Property, Quantity, StateFormula};
use prism_lang::resolved::ModelType;

use crate::answer::{Answer, CheckError, Options};
use crate::engine::Sound;
use crate::evaluate::Evaluator;
use crate::paths::{Path, most_probable_path};
use crate::shape::{Shape, read_path, shape};
use crate::state_space::{Csr, StateSpace};

/// A path that shows something.
#[derive(Debug, Clone, PartialEq)]
pub struct Witness {
    /// Whether it violates the formula; else it satisfies it.
    pub violates: bool,
    /// Its probability.
    pub probability: f64,
    /// Its states, each as `(name=value,...)`.
    pub states: Vec<String>,
    /// The action taken in each state but the last, where the model has choices and the action a name.
    pub actions: Vec<Option<String>>,
}

/// The most probable path that shows what the property asks for; `None` if it asks for no such path, or there is
/// none.
///
/// # Errors
/// See [`CheckError`].
///
/// ```
/// use checker::explore::explore;
/// use checker::{Options, check, witness};
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
/// let text = "mdp module m x : [0..3];
///   [risk] x=0 -> 0.4:(x'=1) + 0.6:(x'=2); [wait] x=0 -> true; [] x=1 -> 0.5:(x'=3) + 0.5:(x'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let asked = parse_properties("Pmax=? [ F x=3 ]").tree;
/// let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
/// let space = explore::<f64>(&model)?;
/// let options = Options::default();
/// let answer = check(&space, &model, &asked[0].property, &options)?;
/// let path = witness(&space, &asked[0].property, &answer, &options)?.unwrap();
/// assert_eq!((path.probability, path.violates), (0.2, false));
/// assert_eq!(path.states, ["(x=0)", "(x=1)", "(x=3)"]);
/// assert_eq!(path.actions[0].as_deref(), Some("risk"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn witness(
    space: &StateSpace<f64>,
    property: &Property,
    answer: &Answer,
    options: &Options<'_>,
) -> Result<Option<Witness>, CheckError> {
    let Some(formula) = path_of(property) else {
        return Ok(None);
    };
    let chain = match (&answer.scheduler, space.kind) {
        (Some(scheduler), _) => Cow::Owned(space.induced(scheduler)),
        (None, ModelType::Ctmc) => Cow::Owned(space.embedded()),
        (None, ModelType::Dtmc) => Cow::Borrowed(space),
        _ => return Ok(None),
    };
    let mut sets = Vec::new();
    let mut evaluator = Evaluator::<Sound>::new(&chain, options)?;
    let Ok(formula) = read_path(formula, &mut sets, &mut |f| evaluator.set(f)) else {
        return Ok(None);
    };
    let states = chain.num_states();
    let Some(Shape::Until {
        left,
        right,
        steps,
        contrary,
    }) = shape(&formula.simplify(), &sets, states)
    else {
        return Ok(None);
    };
    let passable: Vec<bool> = (0..states).map(|s| left[s] && !right[s]).collect();
    let Some(path) = most_probable_path(&only_through(&chain, &passable), &right) else {
        return Ok(None);
    };
    let length = path.states.len() as u64 - 1;
    if steps.0 > length || steps.1.is_some_and(|last| length > last) {
        return Ok(None);
    }
    Ok(Some(told(space, answer, &chain, &path, contrary)))
}

pub(crate) fn path_of(property: &Property) -> Option<&Formula> {
    match property {
        Property::Probability { path, .. } => Some(path),
        Property::Number(Quantity::Probability { path, .. })
        | Property::State(StateFormula::Probability { path, .. }) => Some(path),
        _ => None,
    }
}

/// The chain in which all other states are never left.
pub(crate) fn only_through(chain: &StateSpace<f64>, passable: &[bool]) -> StateSpace<f64> {
    let mut matrix = Csr::with_capacity(passable.len());
    for (state, passable) in passable.iter().enumerate() {
        match passable {
            true => matrix.push_row(chain.matrix.row(state).map(|(to, p)| (to as u32, *p))),
            false => matrix.push_row([(state as u32, 1.0)]),
        }
    }
    StateSpace::from_matrix(matrix, chain.initial_states().to_vec(), Vec::new())
}

fn told(
    space: &StateSpace<f64>,
    answer: &Answer,
    chain: &StateSpace<f64>,
    path: &Path<f64>,
    violates: bool,
) -> Witness {
    let reached = answer
        .scheduler
        .as_ref()
        .map(|scheduler| space.reached_by(scheduler));
    let action = |state: &usize| {
        let (reached, scheduler) = (reached.as_ref()?, answer.scheduler.as_ref()?);
        let row = space.row_of(scheduler, reached[*state]);
        space
            .action(row)
            .map(|action| space.actions()[action].clone())
    };
    Witness {
        violates,
        probability: path.probability,
        states: path
            .states
            .iter()
            .map(|state| chain.describe(*state))
            .collect(),
        actions: path.states[..path.states.len() - 1]
            .iter()
            .map(action)
            .collect(),
    }
}
