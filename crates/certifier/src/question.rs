//! What can be certified: an unbounded until, and a reward before a target.

use prism_lang::ast::Optimum;
use prism_lang::property::{Path, Property, Quantity, RewardObjective, RewardQuery, StateFormula};
use prism_lang::resolved::{Model, ModelType};
use prism_lang::{Comparison, Expr};

use crate::failure::Failure;

/// A question in the form that is certified.
#[derive(Clone, Debug)]
pub struct Question {
    /// What must hold before; none for anything.
    pub left: Option<StateFormula>,
    /// What is to be reached.
    pub right: StateFormula,
    /// The reward structure that is collected before; none for a probability.
    pub reward: Option<usize>,
    /// Whether the greatest value over schedulers is meant, else the least; nothing in a chain.
    pub maximise: bool,
    /// Whether the bounds are those of the contrary's probability.
    pub contrary: bool,
}

impl Question {
    /// The form of a property.
    ///
    /// # Errors
    /// If it has none.
    pub fn new(model: &Model, property: &Property) -> Result<Self, Failure> {
        if model.model_type == ModelType::Lts {
            return Err(unsupported("a model without probabilities"));
        }
        let worst = |comparison: &Comparison| {
            matches!(comparison, Comparison::Less | Comparison::LessEqual)
        };
        match property {
            Property::Probability { bound, path } => {
                let maximise = bound.as_ref().is_none_or(|(c, _)| worst(c));
                Self::of_path(path, maximise)
            }
            Property::Number(Quantity::Probability { optimum, path }) => {
                Self::of_path(path, *optimum != Some(Optimum::Min))
            }
            Property::Number(Quantity::Reward { optimum, reward }) => {
                Self::of_reward(reward, *optimum != Some(Optimum::Min))
            }
            Property::State(StateFormula::Reward { bound, reward }) => {
                Self::of_reward(reward, worst(&bound.0))
            }
            _ => Err(unsupported("a property of this form")),
        }
    }

    fn of_path(path: &Path, maximise: bool) -> Result<Self, Failure> {
        let question = |left: Option<&Path>, right: &Path, contrary: bool| {
            Ok(Self {
                left: left.map(state).transpose()?,
                right: state(right)?,
                reward: None,
                maximise: maximise != contrary,
                contrary,
            })
        };
        match path {
            Path::Finally { operand, bound } if bound.is_unbounded() => {
                question(None, operand, false)
            }
            Path::Until { left, right, bound } if bound.is_unbounded() => {
                question(Some(left), right, false)
            }
            Path::Globally { operand, bound } if bound.is_unbounded() => {
                let contrary = Path::State(Box::new(StateFormula::Not(Box::new(state(operand)?))));
                question(None, &contrary, true)
            }
            _ => Err(unsupported(
                "a path formula other than `F`, `G` and `U` without bounds",
            )),
        }
    }

    fn of_reward(query: &RewardQuery, maximise: bool) -> Result<Self, Failure> {
        match (&query.objective, query.divisor) {
            (RewardObjective::Reach(target), None) => Ok(Self {
                left: None,
                right: (**target).clone(),
                reward: Some(query.structure),
                maximise,
                contrary: false,
            }),
            _ => Err(unsupported("a reward other than `F`")),
        }
    }
}

fn state(path: &Path) -> Result<StateFormula, Failure> {
    match path {
        Path::State(formula) => Ok((**formula).clone()),
        _ => Err(unsupported("a formula of several temporal operators")),
    }
}

pub(crate) fn unsupported(what: &str) -> Failure {
    Failure::Unsupported(what.to_owned())
}

/// Whether a formula without operators of paths holds in a state.
pub(crate) fn holds(
    formula: &StateFormula,
    model: &Model,
    state: &[i64],
    is_initial: bool,
    is_deadlock: bool,
) -> Result<bool, Failure> {
    let holds = |formula| holds(formula, model, state, is_initial, is_deadlock);
    Ok(match formula {
        StateFormula::Expr(expr) => expr.eval_bool(state)?,
        StateFormula::Label(name) => match (name.as_str(), model.label(name)) {
            (_, Some(body)) => Expr::eval_bool(body, state)?,
            ("init", None) => is_initial,
            ("deadlock", None) => is_deadlock,
            _ => return Err(unsupported("a label of the properties' file")),
        },
        StateFormula::Not(a) => !holds(a)?,
        StateFormula::And(a, b) => holds(a)? && holds(b)?,
        StateFormula::Or(a, b) => holds(a)? || holds(b)?,
        StateFormula::Implies(a, b) => !holds(a)? || holds(b)?,
        StateFormula::Iff(a, b) => holds(a)? == holds(b)?,
        _ => return Err(unsupported("a property within a property")),
    })
}
