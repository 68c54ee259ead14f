//! Several objectives: from the property to the question of [`crate::multi`].

use prism_lang::Comparison;
use prism_lang::ast::Optimum;
use prism_lang::property::{
    Horizon, Objective, Path, Property, Quantity, RewardObjective, RewardQuery, StateFormula,
};
use temporal::ltl::Ltl;

use super::Evaluator;
use super::schedulers::none;
use crate::amount::Extended;
use crate::answer::{Answer, AnswerValue, CheckError, Guarantee};
use crate::engine::Exact;
use crate::fairness::not_yet;
use crate::joint::Joint;
use crate::multi::{self, Achieved, Goal, Kind, Skeleton};
use crate::scheduler::Scheduler;
use crate::shape::{letters, read_path};

/// What is read of the objectives, in their order.
#[derive(Default)]
struct Reading {
    sets: Vec<Vec<bool>>,
    formulas: Vec<Ltl>,
    horizon: u32,
    goals: Vec<Goal>,
}

impl Evaluator<'_, Exact> {
    /// The answer to `multi(...)`.
    pub(crate) fn objectives(
        mut self,
        objectives: &[Objective],
        property: &Property,
    ) -> Result<Answer, CheckError> {
        let (initial, reading, letters) = self.read_objectives(objectives)?;
        let options = self.context.options;
        let formulas = &reading.formulas;
        let mut joint = Joint::new(
            self.choices(),
            formulas,
            &letters,
            reading.horizon,
            initial,
            options,
        )?;
        self.product_states = Some(joint.num_states());
        let kinds: Vec<Kind> = reading.goals.iter().map(|goal| goal.kind.clone()).collect();
        let skeleton = Skeleton::new(&mut joint, &kinds)?;
        Ok(match multi::solve(&skeleton, &reading.goals, options)? {
            Achieved::Truth(holds) => self.of_truths(&[holds], property),
            Achieved::Best(best) => {
                let value = best.map_or(Extended::Undefined, Extended::Finite);
                self.of_amounts(&[value], &[Guarantee::Exact])
            }
            Achieved::Corners(corners) => {
                self.base(AnswerValue::Corners(corners), Guarantee::Exact, Vec::new())
            }
        })
    }

    /// The scheduler that achieves what `multi(...)` asks for, as a mixture of pure ones.
    pub(crate) fn objectives_scheduler(
        mut self,
        objectives: &[Objective],
    ) -> Result<Scheduler, CheckError> {
        if self.choices().is_chain() {
            return none("the model leaves nothing to choose");
        }
        let is_free = |objective: &&Objective| matches!(objective, Objective::Optimise(..));
        if objectives.iter().filter(is_free).count() > 1 {
            return none("a curve has one for each point: give a bound to all objectives but one");
        }
        let (initial, reading, letters) = self.read_objectives(objectives)?;
        let options = self.context.options;
        let (choices, formulas) = (self.choices(), &reading.formulas);
        let horizon = reading.horizon;
        let mut joint = Joint::new(choices, formulas, &letters, horizon, initial, options)?;
        let kinds: Vec<Kind> = reading.goals.iter().map(|goal| goal.kind.clone()).collect();
        let skeleton = Skeleton::new(&mut joint, &kinds)?;
        let Some(mixture) = multi::mixture(&skeleton, &reading.goals, options)? else {
            return none("no scheduler meets the bounds");
        };
        let parts = mixture.into_iter().map(|(share, corner)| {
            let chosen = &corner.chosen;
            let part =
                multi::scheduler::unfolded(choices, initial, &joint, &skeleton, chosen, options)?;
            Ok((share, part))
        });
        let parts = parts.collect::<Result<Vec<_>, CheckError>>()?;
        Ok(Scheduler::WithMemory(multi::scheduler::mixed(parts)))
    }

    /// The initial state, what is asked, and a letter for each state.
    fn read_objectives(
        &mut self,
        objectives: &[Objective],
    ) -> Result<(usize, Reading, Vec<u64>), CheckError> {
        if self.context.options.fair && !self.choices().is_chain() {
            return Err(not_yet("several objectives"));
        }
        let [initial] = *self.space.initial_states() else {
            return Err(CheckError::Unsupported(
                "`multi` over several initial states cannot be computed yet: use a model with one"
                    .to_owned(),
            ));
        };
        let mut reading = Reading::default();
        for objective in objectives {
            self.read_objective(objective, &mut reading)?;
        }
        let letters = letters(&reading.sets, self.space.num_states());
        Ok((initial, reading, letters))
    }

    fn read_objective(
        &mut self,
        objective: &Objective,
        reading: &mut Reading,
    ) -> Result<(), CheckError> {
        let is_max = |optimum: &Optimum| *optimum == Optimum::Max;
        let (kind, contrary, bound) = match objective {
            Objective::Optimise(optimum, Quantity::Probability { path, .. }) => {
                let contrary = !is_max(optimum);
                (self.read_formula(path, contrary, reading)?, contrary, None)
            }
            Objective::Optimise(optimum, Quantity::Reward { reward, .. }) => {
                let contrary = !is_max(optimum);
                (self.read_reward(reward, contrary, reading)?, contrary, None)
            }
            Objective::Require(StateFormula::Probability {
                bound: (comparison, bound),
                path,
            }) => {
                let contrary = is_upper(*comparison);
                let kind = self.read_formula(path, contrary, reading)?;
                (kind, contrary, Some((comparison, bound)))
            }
            Objective::Require(StateFormula::Reward {
                bound: (comparison, bound),
                reward,
            }) => {
                let contrary = is_upper(*comparison);
                let kind = self.read_reward(reward, contrary, reading)?;
                (kind, contrary, Some((comparison, bound)))
            }
            _ => {
                return Err(CheckError::Unsupported(
                    "an objective of `multi` must be one `P` or `R`".to_owned(),
                ));
            }
        };
        let bound = match bound {
            None => None,
            Some((comparison, bound)) => {
                let bound = bound.exact().cloned().ok_or_else(|| {
                    CheckError::Unsupported("a bound of `multi` must be rational".to_owned())
                })?;
                let one = crate::exact::indicator(true);
                let bound = match (&kind, contrary) {
                    (_, false) => bound,
                    (Kind::Path(_), true) => one - bound,
                    (Kind::Reward { .. }, true) => -bound,
                };
                let strict = matches!(comparison, Comparison::Less | Comparison::Greater);
                Some((bound, strict))
            }
        };
        reading.goals.push(Goal {
            kind,
            bound,
            contrary,
        });
        Ok(())
    }

    fn read_formula(
        &mut self,
        path: &Path,
        contrary: bool,
        reading: &mut Reading,
    ) -> Result<Kind, CheckError> {
        let formula = read_path(path, &mut reading.sets, &mut |f| self.set(f))?;
        reading.formulas.push(match contrary {
            true => Ltl::negate(formula).simplify(),
            false => formula.simplify(),
        });
        Ok(Kind::Path(reading.formulas.len() - 1))
    }

    fn read_reward(
        &mut self,
        reward: &RewardQuery,
        negative: bool,
        reading: &mut Reading,
    ) -> Result<Kind, CheckError> {
        let refused = |what: &str| Err(CheckError::Unsupported(what.to_owned()));
        let steps = match &reward.objective {
            RewardObjective::Total => None,
            RewardObjective::Cumulative(Horizon::Steps(steps)) => {
                let Ok(steps) = u32::try_from(*steps) else {
                    return refused("so many steps cannot be counted in `multi`");
                };
                reading.horizon = reading.horizon.max(steps);
                Some(steps)
            }
            _ => return refused("rewards in `multi` must be `C` or `C<=k`"),
        };
        if reward.divisor.is_some() {
            return refused("ratios of rewards in `multi` cannot be computed yet");
        }
        let model = self.reward_model(reward.structure)?;
        if model.loss.is_some() {
            return refused("negative rewards in `multi` cannot be computed yet");
        }
        let number = |amount: Extended| match amount {
            Extended::Finite(value) => value,
            _ => crate::exact::indicator(false),
        };
        let rows = model.gain.row.into_iter().map(number).collect();
        Ok(Kind::Reward {
            rows,
            steps,
            negative,
        })
    }
}

/// Whether a bound is one from above: then less is better.
fn is_upper(comparison: Comparison) -> bool {
    matches!(comparison, Comparison::Less | Comparison::LessEqual)
}
