//! Bounds in all states that are inductive, so that they can be checked without solving anything.
//!
//! *Problem.* Bounds that a method computes hold, but rounding or stopping early may leave them a little short of
//! being inductive (`u >= F(u)`, `l <= F(l)`; `F` takes one step back).
//!
//! *Method.* With the relative residual `e` and `d` the solution of `d = x + P d` (optimal before absorption, end
//! components collapsed), `x + e d` and `x - e d` are inductive, since `d - P d = x` makes up for a residual of `e x`
//! everywhere. Relative weights keep the digits of small probabilities. `e` is taken a few times larger than
//! computed; the one who checks says whether that was enough. Cost: a second solution of the same equations.
//! Guarantee: none, that is the checking's.

use prism_lang::property::{Path, Property, Quantity, RewardObjective, RewardQuery, StateFormula};

use super::{Evaluator, worst};
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::Sound;
use crate::fairness::not_yet;
use crate::graph::{Backward, NO_ROW, maximal_end_components, qualitative_optimum};
use crate::quotient::Quotient;
use crate::rewards;
use crate::rounding::Bounds;
use crate::shape::{Shape, read_path, shape};

/// Bounds of a value in every state, for a certificate. For the probability of `G` they are those of its contrary's.
#[derive(Clone, Debug, PartialEq)]
pub struct StateBounds {
    /// Lower bounds, meant to be inductive.
    pub lower: Vec<f64>,
    /// Upper bounds, likewise.
    pub upper: Vec<f64>,
    /// For each state the outcomes of the choice that attains the value, in a model with choices.
    pub scheduler: Option<Vec<Option<Outcomes>>>,
}

/// A choice's targets with their probabilities.
pub type Outcomes = Vec<(usize, f64)>;

/// What bounds were found, and what they are widened by.
struct Found {
    low: Vec<f64>,
    high: Vec<f64>,
    /// `d`.
    weight: Vec<f64>,
    /// What each row earns; none for probabilities.
    reward: Vec<Bounds>,
    scheduler: Vec<usize>,
    /// States in which a step is taken.
    open: Vec<bool>,
    maximise: bool,
    most: f64,
}

impl Evaluator<'_, Sound> {
    /// The bounds; `slack` is how many times more than the residual they are widened by.
    pub fn bounds_of_states(
        mut self,
        property: &Property,
        slack: f64,
    ) -> Result<StateBounds, CheckError> {
        if self.context.options.fair && !self.choices().is_chain() {
            return Err(not_yet("certificates"));
        }
        let found = match property {
            Property::Probability { bound, path } => {
                let maximise = bound.as_ref().is_none_or(|(c, _)| worst(*c));
                self.probability_everywhere(path, maximise)?
            }
            Property::Number(Quantity::Probability { optimum, path }) => {
                let maximise = *optimum != Some(prism_lang::ast::Optimum::Min);
                self.probability_everywhere(path, maximise)?
            }
            Property::Number(Quantity::Reward { optimum, reward }) => {
                let maximise = *optimum != Some(prism_lang::ast::Optimum::Min);
                self.reward_everywhere(reward, maximise)?
            }
            Property::State(StateFormula::Reward { bound, reward }) => {
                self.reward_everywhere(reward, worst(bound.0))?
            }
            _ => return Err(not_of_this_form()),
        };
        Ok(self.widened(&found, slack))
    }

    fn probability_everywhere(&mut self, path: &Path, maximise: bool) -> Result<Found, CheckError> {
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?.simplify();
        let Some(Shape::Until {
            left,
            right,
            steps: (0, None),
            contrary,
        }) = shape(&formula, &sets, self.space.num_states())
        else {
            return Err(not_of_this_form());
        };
        let maximise = maximise != contrary;
        let values = self.until(&left, &right, (0, None), None, maximise)?;
        let low: Vec<f64> = values.iter().map(|v| v.value.low).collect();
        let high: Vec<f64> = values.iter().map(|v| v.value.high).collect();
        let choices = self.choices();
        let sets = qualitative_optimum(choices, &left, &right, maximise);
        let open: Vec<bool> = (0..low.len())
            .map(|s| !sets.never[s] && !sets.surely[s])
            .collect();
        let idle = if maximise {
            maximal_end_components(choices, &open, |_| true)
        } else {
            Vec::new()
        };
        let earned = self.by_row(&high);
        let mut quotient = Quotient::new(choices, true);
        quotient.reward = &earned;
        let done = quotient.add_class(Some(Bounds::ZERO));
        let closed: Vec<bool> = open.iter().map(|open| !open).collect();
        quotient.assign(done, &closed);
        quotient.collapse(idle);
        quotient.separate(&open);
        let weight = quotient.solve::<Sound>(&Bounds::ZERO, &self.context)?;
        let scheduler = self.scheduler.take().unwrap_or_default();
        Ok(Found {
            weight: weight.values.iter().map(|w| w.high).collect(),
            low,
            high,
            reward: Vec::new(),
            scheduler,
            open,
            maximise,
            most: 1.0,
        })
    }

    fn reward_everywhere(
        &mut self,
        query: &RewardQuery,
        maximise: bool,
    ) -> Result<Found, CheckError> {
        let (RewardObjective::Reach(target), None) = (&query.objective, query.divisor) else {
            return Err(not_of_this_form());
        };
        let by_time = self.reward_model(query.structure)?;
        let target = self.set(target)?;
        let model = self.per_step(&by_time);
        if model.loss.is_some() {
            return Err(not_of_this_form());
        }
        let choices = self.choices();
        let optimal = rewards::reach::<Sound>(choices, &model, &target, maximise, &self.context)?;
        let low: Vec<f64> = optimal.values.iter().map(|v| v.low).collect();
        let high: Vec<f64> = optimal.values.iter().map(|v| v.high).collect();
        let open: Vec<bool> = (0..low.len())
            .map(|s| low[s].is_finite() && !target[s])
            .collect();
        let everywhere = vec![true; target.len()];
        let finite = match maximise {
            true => qualitative_optimum(choices, &everywhere, &target, false).surely,
            false => {
                Backward::new(choices)
                    .sure_for_some(choices, &everywhere, &target)
                    .0
            }
        };
        debug_assert!((0..low.len()).all(|s| finite[s] == low[s].is_finite()));
        let earned = self.by_row(&high);
        let mut quotient = Quotient::new(choices, true);
        quotient.reward = &earned;
        let done = quotient.add_class(Some(Bounds::ZERO));
        quotient.assign(done, &target);
        let idle = match maximise {
            true => Vec::new(),
            false => maximal_end_components(choices, &open, |_| true),
        };
        quotient.collapse(idle);
        quotient.separate(&open);
        let weight = quotient.solve::<Sound>(&Bounds::ZERO, &self.context)?;
        Ok(Found {
            weight: weight.values.iter().map(|w| w.high).collect(),
            low,
            high,
            reward: model.into_owned().gain.row,
            scheduler: optimal.scheduler,
            open,
            maximise,
            most: f64::INFINITY,
        })
    }

    /// A number of each state for each of its choices.
    fn by_row(&self, of_state: &[f64]) -> Vec<Bounds> {
        let choices = self.choices();
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let rows = |s: usize| {
            choices
                .rows(s)
                .map(move |_| Bounds::exactly(finite(of_state[s])))
        };
        (0..of_state.len()).flat_map(rows).collect()
    }

    fn widened(&self, found: &Found, slack: f64) -> StateBounds {
        let choices = self.choices();
        let (down, up) = (
            residual(choices, found, &found.low, false),
            residual(choices, found, &found.high, true),
        );
        let by = |residual: f64| slack * (residual + 8.0 * f64::EPSILON);
        let (down, up) = (by(down), by(up));
        let mut bounds = StateBounds {
            lower: found.low.clone(),
            upper: found.high.clone(),
            scheduler: None,
        };
        for state in (0..found.low.len()).filter(|s| found.open[*s]) {
            let weight = found.weight[state];
            bounds.lower[state] = (found.low[state] - down * weight).max(0.0);
            bounds.upper[state] = (found.high[state] + up * weight).min(found.most);
        }
        if !choices.is_chain() && !found.scheduler.is_empty() {
            let outcomes = |row: &usize| {
                let entries = || self.matrix().row(*row).map(|(target, p)| (target, *p));
                (*row != NO_ROW).then(|| entries().collect())
            };
            bounds.scheduler = Some(found.scheduler.iter().map(outcomes).collect());
        }
        bounds
    }
}

/// By how much, relatively, the numbers fall short of being inductive, at most.
fn residual(choices: Choices<'_, f64>, found: &Found, x: &[f64], upper: bool) -> f64 {
    let mut most = 0.0f64;
    for state in (0..x.len()).filter(|s| found.open[*s] && x[*s] > 0.0) {
        let value = |row: usize| {
            let earned = found.reward.get(row).map_or(0.0, |r| r.high);
            let targets = choices.matrix.row(row);
            targets.fold(earned, |sum, (target, p)| sum + p * x[target])
        };
        let values = choices.rows(state).map(value);
        let best = match found.maximise {
            true => values.fold(f64::NEG_INFINITY, f64::max),
            false => values.fold(f64::INFINITY, f64::min),
        };
        let short = if upper {
            best - x[state]
        } else {
            x[state] - best
        };
        if short.is_finite() {
            most = most.max(short / x[state]);
        }
    }
    most
}

fn not_of_this_form() -> CheckError {
    CheckError::Unsupported(
        "only probabilities of `F`, `G` and `U` without bounds and rewards before a target can be certified yet"
            .to_owned(),
    )
}
