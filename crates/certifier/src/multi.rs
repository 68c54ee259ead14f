//! Several objectives: an upper bound by weights, a lower one by a mixture of schedulers.
//!
//! *Definition.* Each objective gives a scheduler a number `x_i` that should be large: the probability of a formula (of its
//! contrary, where it should be small), or what is earned within steps (its opposite). With `V(w)` the greatest
//! `sum_i w_i x_i` over schedulers, every `w >= 0` with `w_0 = 1` shows that where `x_i >= t_i` for the others
//!
//! ```text
//! x_0 <= V(w) - sum_i w_i t_i,
//! ```
//!
//! and that nothing meets the bounds if `V(w) < sum_i w_i t_i` for some `w >= 0`. Schedulers with the vectors `x^k` show
//! that every mixture of these is attained, since the first step may be left to chance.
//!
//! *Method.* `V(w)` on the product with machines, cut at the last step that earns: there the scheduler may stay in an
//! end component and have any formulas that can hold together, which is a question of reachability ([`average`] asks
//! the same way), shown by inequalities; before, steps are taken backward in intervals. The choices that are best there
//! give a scheduler, and a chain for each objective. Weights come from linear programmes over the vectors known
//! ([`mod@mixture`]); they need not be right.
//!
//! Source: Forejt, Kwiatkowska and Parker 2012, "Pareto Curves for Probabilistic Model Checking"; Etessami, Kwiatkowska,
//! Vardi and Yannakakis 2008. Trusted: [`crate::formula`]. Cost: a problem for each objective and weight. Guarantee: that
//! of reachability and of directed rounding.
//!
//! What is earned for ever ([`mod@total`]) is shown in rationals, two optima by a curve ([`mod@curve`]).
//!
//! [`average`]: crate::average

use num_traits::{One, Zero};
use prism_lang::ast::Optimum;
use prism_lang::property::{
    Horizon, Objective, Quantity, RewardObjective, RewardQuery, StateFormula,
};
use prism_lang::{Comparison, Rational};

use crate::Certified;
use crate::evaluate::{Evaluator, open};
use crate::failure::Failure;
use crate::formula::{Condition, Machine};
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::product::Product;
use crate::question::unsupported;
use crate::reading::{Choice, Part};
use crate::steps::Row;

mod curve;
mod end;
mod mixture;
mod total;
pub use curve::Curve;
use end::End;
use mixture::{Mixture, mixture};

/// Most objectives, since what can hold together is tried for every set of them.
const MOST_OBJECTIVES: usize = 4;
/// Most weights that are tried.
const MOST_WEIGHTS: usize = 30;
/// Most steps that earn.
const MOST_STEPS: u64 = 100_000;
/// The relative distance of the bounds that ends the search.
const CLOSE: f64 = 1e-8;

/// An objective.
struct Goal {
    kind: Kind,
    /// Whether its number is that of the contrary, or the opposite reward.
    contrary: bool,
    /// What must be reached, and whether it must be passed.
    bound: Option<(Rational, bool)>,
}

enum Kind {
    /// What must recur.
    Path(Condition),
    /// What each choice of each state of the model earns, and within how many steps.
    Reward(Vec<Vec<Interval>>, u64),
    /// The same for ever; negative if it should be small.
    Total(Vec<Vec<Rational>>),
}

/// What is shown for some weights: the greatest weighted sum, and what a scheduler gives each objective.
struct Shown {
    greatest: Interval,
    vector: Vec<Interval>,
}

impl Evaluator<'_> {
    /// What is shown of several objectives.
    pub(crate) fn objectives(&mut self, objectives: &[Objective]) -> Result<Certified, Failure> {
        self.needs_probabilities()?;
        let (mut machines, mut sets) = (Vec::new(), Vec::new());
        let mut goals = Vec::new();
        for objective in objectives {
            goals.push(self.goal(objective, &mut machines, &mut sets)?);
        }
        let reading = self.reading()?;
        if reading.num_initial > 1 {
            return Err(unsupported(
                "several objectives from several initial states",
            ));
        }
        let optima = goals.iter().filter(|goal| goal.bound.is_none()).count();
        let is_curve = optima == 2 && goals.len() == 2;
        if (optima > 1 && !is_curve) || goals.len() > MOST_OBJECTIVES {
            return Err(unsupported("so many objectives"));
        }
        // What is asked for comes first; if all is required, the first.
        goals.sort_by_key(|goal| goal.bound.is_some());
        let product = Product::new(&reading.choices, &mut machines, &sets)?;
        let end = End::new(product, &goals, &machines)?;
        if is_curve {
            return Ok(Certified {
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
                ends: [Interval::ANY; 2],
                truth: None,
                curve: Some(self.curve(&goals, &end)?),
                states: reading.states.len(),
                inequalities: self.inequalities,
            });
        }
        let found = self.search(&goals, &end)?;
        let bound = goals[0].bound.clone();
        let (value, truth) = match (found, bound) {
            (None, _) => (Interval::ANY, Some(false)),
            (Some(value), None) => (asked(&goals[0], &value), None),
            (Some(value), Some((bound, strict))) => {
                let bound = Interval::of(&bound);
                let truth = match strict {
                    _ if value.low > bound.high => true,
                    false if value.low >= bound.high => true,
                    _ if value.high < bound.low => false,
                    true if value.high <= bound.low => false,
                    _ => return Err(open()),
                };
                (Interval::ANY, Some(truth))
            }
        };
        Ok(Certified {
            low: value.low,
            high: value.high,
            ends: [value; 2],
            truth,
            curve: None,
            states: reading.states.len(),
            inequalities: self.inequalities,
        })
    }

    fn goal(
        &mut self,
        objective: &Objective,
        machines: &mut Vec<Machine>,
        sets: &mut Vec<Vec<bool>>,
    ) -> Result<Goal, Failure> {
        let is_upper = |c: &Comparison| matches!(c, Comparison::Less | Comparison::LessEqual);
        let (path, reward, contrary, bound) = match objective {
            Objective::Optimise(optimum, Quantity::Probability { path, .. }) => {
                (Some(path), None, *optimum == Optimum::Min, None)
            }
            Objective::Optimise(optimum, Quantity::Reward { reward, .. }) => {
                (None, Some(reward), *optimum == Optimum::Min, None)
            }
            Objective::Require(StateFormula::Probability { bound, path }) => {
                (Some(path), None, is_upper(&bound.0), Some(bound))
            }
            Objective::Require(StateFormula::Reward { bound, reward }) => {
                (None, Some(reward), is_upper(&bound.0), Some(bound))
            }
            _ => return Err(unsupported("this objective")),
        };
        let kind = match (path, reward) {
            (Some(path), _) => {
                let formula = self.formula(path, sets)?;
                let formula = if contrary { formula.negated() } else { formula };
                Kind::Path(Condition::read(&formula, machines)?)
            }
            (_, Some(reward)) => self.earned_by_choice(reward, contrary)?,
            _ => return Err(unsupported("this objective")),
        };
        let bound = match bound {
            None => None,
            Some((comparison, bound)) => {
                let exact = bound.exact().cloned();
                let exact = exact.ok_or_else(|| unsupported("a bound that is not rational"))?;
                let exact = match (&kind, contrary) {
                    (_, false) => exact,
                    (Kind::Path(_), true) => Rational::one() - exact,
                    (_, true) => -exact,
                };
                let is_strict = matches!(comparison, Comparison::Less | Comparison::Greater);
                Some((exact, is_strict))
            }
        };
        Ok(Goal {
            kind,
            contrary,
            bound,
        })
    }

    fn earned_by_choice(&mut self, reward: &RewardQuery, opposite: bool) -> Result<Kind, Failure> {
        let steps = match (&reward.objective, reward.divisor) {
            (RewardObjective::Cumulative(Horizon::Steps(steps)), None) => Some(*steps),
            (RewardObjective::Total, None) => None,
            _ => return Err(unsupported("an objective other than `P`, `C` and `C<=`")),
        };
        let reading = self.earning(Some(reward.structure), Part::All)?;
        let Some(steps) = steps else {
            if reading.loses {
                return Err(unsupported("a negative reward among several objectives"));
            }
            let signed = |choice: &Choice| match opposite {
                true => -choice.reward.clone(),
                false => choice.reward.clone(),
            };
            let earned = reading.choices.iter();
            let earned = earned.map(|choices| choices.iter().map(signed).collect());
            return Ok(Kind::Total(earned.collect()));
        };
        if steps > MOST_STEPS {
            return Err(unsupported("so many steps of several objectives"));
        }
        let earned = |choice: &Choice| match opposite {
            true => Interval::of(&-choice.reward.clone()),
            false => Interval::of(&choice.reward),
        };
        let choices = reading.choices.iter();
        let earned = choices.map(|choices| choices.iter().map(earned).collect());
        Ok(Kind::Reward(earned.collect(), steps))
    }

    /// Bounds of the first number where the others meet their bounds; nothing if it is shown that they cannot.
    fn search(&mut self, goals: &[Goal], end: &End) -> Result<Option<Interval>, Failure> {
        let others: Vec<&(Rational, bool)> = (goals[1..].iter())
            .filter_map(|goal| goal.bound.as_ref())
            .collect();
        let mut shown: Vec<Vec<Interval>> = Vec::new();
        let mut bounds = Interval::ANY;
        for _ in 0..MOST_WEIGHTS {
            let found = mixture(&shown, &others);
            let weights = found
                .as_ref()
                .map_or(vec![1.0; goals.len()], Mixture::weights);
            if let Some(mixed) = &found {
                bounds.low = bounds.low.max(mixed.attained);
            }
            let feasible = found.as_ref().is_none_or(|mixed| mixed.feasible);
            let weights = match feasible {
                true => weights,
                // Nothing for the first: can the others be met at all?
                false => [&[0.0], &weights[1..]].concat(),
            };
            let next = self.weighted(goals, end, &weights)?;
            let pairs = weights[1..].iter().zip(&others);
            let bought = pairs.fold(Interval::ZERO, |sum, (weight, (bound, _))| {
                sum.add(&Interval::exactly(*weight).mul(&Interval::of(bound)))
            });
            let left = next.greatest.sub(&bought);
            match feasible {
                true => bounds.high = bounds.high.min(left.high),
                false if left.high < 0.0 => return Ok(None),
                false => {}
            }
            let size = bounds.high.abs().max(1e-3);
            if bounds.high - bounds.low <= CLOSE * size || shown.contains(&next.vector) {
                break;
            }
            shown.push(next.vector);
        }
        Ok(Some(bounds))
    }

    /// The greatest weighted sum, and the vector of a scheduler that comes close.
    fn weighted(&mut self, goals: &[Goal], end: &End, weights: &[f64]) -> Result<Shown, Failure> {
        let (mut sum, mut vectors) = self.staying(goals, end, weights)?;
        let horizon = goals.iter().map(|goal| goal.horizon()).max().unwrap_or(0);
        let rows: Vec<Vec<Row>> = (end.product.choices.iter())
            .map(|choices| choices.iter().map(Row::new).collect())
            .collect();
        for step in (0..horizon).rev() {
            if self.oracle.is_cancelled() {
                return Err(Failure::Cancelled);
            }
            let earned = |goal: &Goal, state: usize, choice: usize| match &goal.kind {
                Kind::Reward(earned, steps) if step < *steps => {
                    earned[end.product.state[state]][choice]
                }
                Kind::Total(earned) => Interval::of(&earned[end.product.state[state]][choice]),
                _ => Interval::ZERO,
            };
            let before = (sum.clone(), vectors.clone());
            for state in 0..sum.len() {
                let value = |choice: usize| {
                    let pairs = goals.iter().zip(weights);
                    let start = pairs.fold(Interval::ZERO, |sum, (goal, weight)| {
                        let earned = earned(goal, state, choice);
                        sum.add(&Interval::exactly(*weight).mul(&earned))
                    });
                    rows[state][choice].mean(start, &before.0)
                };
                let values: Vec<Interval> = (0..rows[state].len()).map(value).collect();
                let middle = |place: &usize| values[*place].low + values[*place].high;
                let best = (0..values.len())
                    .reduce(|a, b| if middle(&b) > middle(&a) { b } else { a })
                    .unwrap_or(0);
                let all = values.iter().copied();
                sum[state] = all.reduce(|a, b| a.best(&b, true)).unwrap_or(sum[state]);
                for (number, goal) in goals.iter().enumerate() {
                    let start = earned(goal, state, best);
                    vectors[number][state] = rows[state][best].mean(start, &before.1[number]);
                }
            }
        }
        let start = end.product.start[0];
        Ok(Shown {
            greatest: sum[start],
            vector: vectors.iter().map(|values| values[start]).collect(),
        })
    }

    /// The same after the last step that earns, in all states of the product.
    fn staying(
        &mut self,
        goals: &[Goal],
        end: &End,
        weights: &[f64],
    ) -> Result<(Vec<Interval>, Vec<Vec<Interval>>), Failure> {
        let by_state = |values: &[Interval]| -> Vec<Interval> {
            end.class.iter().map(|class| values[*class]).collect()
        };
        if goals.iter().any(|goal| matches!(goal.kind, Kind::Total(_))) {
            let (sum, vectors) = self.earning_for_ever(goals, end, weights)?;
            let vectors = vectors.iter().map(|values| by_state(values));
            return Ok((by_state(&sum), vectors.collect()));
        }
        let worth = |bits: u32| -> Rational {
            let inside = (0..goals.len()).filter(|place| bits >> place & 1 == 1);
            inside.map(|place| exact(weights[place])).sum()
        };
        let is_path = |goal: &Goal| matches!(goal.kind, Kind::Path(_));
        let paths = (0..goals.len()).filter(|place| is_path(&goals[*place]));
        let all = worth(paths.fold(0, |bits, place| bits | 1 << place));
        let states = end.class.len();
        // Which formulas are best in each component.
        let chosen: Vec<u32> = (end.together.iter())
            .map(|together| {
                let best = together.iter().copied();
                best.max_by(|a, b| worth(*a).cmp(&worth(*b))).unwrap_or(0)
            })
            .collect();
        let sum = match all.is_zero() {
            true => vec![Interval::ZERO; end.choices.len()],
            false => {
                let shares: Vec<Rational> = chosen.iter().map(|bits| worth(*bits) / &all).collect();
                let choices = end.stopping(&shares, |_, _| true);
                let scale = Interval::of(&all);
                let values = self.goal_of(&choices)?;
                values.iter().map(|value| scale.mul(value)).collect()
            }
        };
        let middle = |choice: &Choice| -> f64 {
            let of = |(to, p): &(usize, Rational)| {
                prism_lang::rational_to_f64(p) * (sum[*to].low + sum[*to].high)
            };
            choice.outcomes.iter().map(of).sum()
        };
        // The place of the best choice that leaves a class; none where it is best to stay.
        let best: Vec<Option<usize>> = (0..end.choices.len())
            .map(|class| {
                let leaves = 0..end.choices[class].len();
                let best = leaves.reduce(|a, b| {
                    let better = middle(&end.choices[class][b]) > middle(&end.choices[class][a]);
                    if better { b } else { a }
                });
                let stays = chosen
                    .get(class)
                    .map(|bits| 2.0 * prism_lang::rational_to_f64(&worth(*bits)));
                best.filter(|place| {
                    stays.is_none_or(|stays| middle(&end.choices[class][*place]) > stays)
                })
            })
            .collect();
        let mut vectors = Vec::new();
        for (place, goal) in goals.iter().enumerate() {
            vectors.push(match is_path(goal) {
                false => vec![Interval::ZERO; states],
                true => {
                    let share = |bits: &u32| match bits >> place & 1 {
                        1 => Rational::one(),
                        _ => Rational::zero(),
                    };
                    let shares: Vec<Rational> = chosen.iter().map(share).collect();
                    let choices = end.stopping(&shares, |class, choice| best[class] == choice);
                    by_state(&self.goal_of(&choices)?)
                }
            });
        }
        Ok((by_state(&sum), vectors))
    }

    /// The greatest probability of the goal, which is the last state but one.
    fn goal_of(&mut self, choices: &[Vec<Choice>]) -> Result<Vec<Interval>, Failure> {
        let of = |end: usize| (0..choices.len()).map(|s| s == end).collect::<Vec<bool>>();
        let (target, failed) = (of(choices.len() - 2), of(choices.len() - 1));
        self.solved(Problem {
            choices,
            target: &target,
            failed: &failed,
            is_reward: false,
            maximise: true,
        })
    }
}

impl Goal {
    fn horizon(&self) -> u64 {
        match self.kind {
            Kind::Path(_) | Kind::Total(_) => 0,
            Kind::Reward(_, steps) => steps,
        }
    }
}

/// The number that was asked for.
fn asked(goal: &Goal, value: &Interval) -> Interval {
    match (&goal.kind, goal.contrary) {
        (Kind::Path(_), false) => value.at_least(0.0).at_most(1.0),
        (Kind::Path(_), true) => value.contrary(),
        (_, false) => *value,
        (_, true) => Interval {
            low: -value.high,
            high: -value.low,
        },
    }
}

fn exact(value: f64) -> Rational {
    Rational::from_float(value).unwrap_or_else(Rational::zero)
}
