//! What is earned for ever, among several objectives: policy iteration in rationals, as a proof.
//!
//! *Definition.* Components that earn nothing are classes that may stop, with any formulas that can hold together there; the
//! other choices earn. A scheduler with finite totals stops almost surely, since what should be large must not be earned
//! for ever (which is refused), and what should be small will not. With `x` the values of one such scheduler, weighted,
//!
//! ```text
//! w r_c + sum_t p_ct x_t <= x_s   for every choice c of every class s
//! ```
//!
//! shows that no other has more: what is earned until a step, and `x` there, never grows in the mean, and `x` is bounded
//! and 0 where all has stopped.
//!
//! *Method.* Policy iteration from a scheduler that stops; the values of a scheduler's chain are an oracle's, and count only
//! if they solve all equations. A switch that gains strictly leaves no scheduler that goes on for ever, since around a cycle
//! nothing would be gained. Source: Puterman 1994, section 7.2 (policy iteration); Forejt, Kwiatkowska, Norman and Parker 2011
//! (totals). Cost: an exact chain for each objective and round. Guarantee: exact.

use num_traits::{One, Signed, Zero};
use prism_lang::Rational;

use super::{End, Goal, Kind, exact};
use crate::evaluate::Evaluator;
use crate::failure::Failure;
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::Choice;

/// What a class may do: where it leads (nowhere: it stops), and what each objective has of it at once.
struct Step {
    outcomes: Vec<(usize, Rational)>,
    numbers: Vec<Rational>,
}

/// A step for each class that can stop almost surely.
type Policy = Vec<Option<usize>>;

impl Evaluator<'_> {
    /// The greatest weighted sum and the numbers of a scheduler that has it, in each class.
    pub(super) fn earning_for_ever(
        &mut self,
        goals: &[Goal],
        end: &End,
        weights: &[f64],
    ) -> Result<(Vec<Interval>, Vec<Vec<Interval>>), Failure> {
        let weights: Vec<Rational> = weights.iter().map(|weight| exact(*weight)).collect();
        let steps = steps(goals, end);
        let mut policy = stopping(&steps);
        let horizon = goals.iter().any(|goal| goal.horizon() > 0);
        let starts = end.class[end.product.start[0]];
        if policy[starts].is_none() || (horizon && policy.contains(&None)) {
            return Err(unsupported(
                "several objectives where it may be earned for ever",
            ));
        }
        let worth = |step: &Step, sum: &[Rational]| -> Rational {
            let own: Rational = (step.numbers.iter().zip(&weights))
                .map(|(x, w)| x * w)
                .sum();
            let ahead = step.outcomes.iter().map(|(to, p)| p * &sum[*to]);
            own + ahead.sum::<Rational>()
        };
        loop {
            if self.oracle.is_cancelled() {
                return Err(Failure::Cancelled);
            }
            let mut vectors = Vec::new();
            for (place, goal) in goals.iter().enumerate() {
                vectors.push(self.of_policy(&steps, &policy, place, goal)?);
            }
            let of_class = |class: usize| -> Rational {
                let each = vectors.iter().zip(&weights);
                each.map(|(values, weight)| &values[class] * weight).sum()
            };
            let sum: Vec<Rational> = (0..steps.len()).map(of_class).collect();
            let mut improved = false;
            for (class, taken) in policy.iter_mut().enumerate() {
                let Some(taken) = taken else { continue };
                let mut best = sum[class].clone();
                for (place, step) in steps[class].iter().enumerate() {
                    // What leads to where nothing stops is of no use.
                    if step.outcomes.iter().any(|(to, _)| steps[*to].is_empty()) {
                        continue;
                    }
                    let worth = worth(step, &sum);
                    self.inequalities += 1;
                    if worth > best {
                        (best, *taken, improved) = (worth, place, true);
                    }
                }
            }
            if !improved {
                let intervals = |values: &Vec<Rational>| values.iter().map(Interval::of).collect();
                return Ok((intervals(&sum), vectors.iter().map(intervals).collect()));
            }
        }
    }

    /// What a policy has of an objective, in each class.
    fn of_policy(
        &mut self,
        steps: &[Vec<Step>],
        policy: &Policy,
        objective: usize,
        goal: &Goal,
    ) -> Result<Vec<Rational>, Failure> {
        let (met, missed) = (steps.len(), steps.len() + 1);
        let is_total = matches!(goal.kind, Kind::Total(_));
        let mut choices: Vec<Vec<Choice>> = Vec::with_capacity(steps.len() + 2);
        for (steps, taken) in steps.iter().zip(policy) {
            let (outcomes, reward) = match taken.map(|taken| &steps[taken]) {
                None => (vec![(missed, Rational::one())], Rational::zero()),
                Some(step) => {
                    let own = &step.numbers[objective];
                    let stop = if own.is_zero() { missed } else { met };
                    let outcomes = match step.outcomes.is_empty() {
                        true => vec![(stop, Rational::one())],
                        false => step.outcomes.clone(),
                    };
                    (
                        outcomes,
                        if is_total {
                            own.abs()
                        } else {
                            Rational::zero()
                        },
                    )
                }
            };
            choices.push(vec![Choice { outcomes, reward }]);
        }
        for last in [met, missed] {
            choices.push(vec![Choice {
                outcomes: vec![(last, Rational::one())],
                reward: Rational::zero(),
            }]);
        }
        let is = |of: &dyn Fn(usize) -> bool| (0..choices.len()).map(of).collect::<Vec<bool>>();
        let target = is(&|state| state == met || (is_total && state == missed));
        let failed = is(&|state| state == missed && !is_total);
        let values = self.exactly(Problem {
            choices: &choices,
            target: &target,
            failed: &failed,
            is_reward: is_total,
            maximise: true,
        })?;
        let infinite = || unsupported("several objectives of which one is infinite");
        let signed = |value: Option<Rational>| match value {
            Some(value) if is_total && goal.contrary => Ok(-value),
            Some(value) => Ok(value),
            None => Err(infinite()),
        };
        let values = values.into_iter().take(steps.len());
        values.map(signed).collect()
    }
}

/// What each class may do; nothing if it cannot stop almost surely.
fn steps(goals: &[Goal], end: &End) -> Vec<Vec<Step>> {
    let mut all = Vec::with_capacity(end.choices.len());
    for (class, choices) in end.choices.iter().enumerate() {
        let mut own = Vec::new();
        for (choice, (state, place)) in choices.iter().zip(&end.origins[class]) {
            let number = |goal: &Goal| match &goal.kind {
                Kind::Total(earned) => earned[end.product.state[*state]][*place].clone(),
                _ => Rational::zero(),
            };
            own.push(Step {
                outcomes: choice.outcomes.clone(),
                numbers: goals.iter().map(number).collect(),
            });
        }
        for bits in end.together.get(class).into_iter().flatten() {
            let number = |place: usize| match bits >> place & 1 {
                1 => Rational::one(),
                _ => Rational::zero(),
            };
            own.push(Step {
                outcomes: Vec::new(),
                numbers: (0..goals.len()).map(number).collect(),
            });
        }
        all.push(own);
    }
    let stops = stopping(&all);
    for (steps, stops) in all.iter_mut().zip(&stops) {
        if stops.is_none() {
            steps.clear();
        }
    }
    all
}

/// A policy that stops almost surely, where there is one: the greatest set of classes from which one that stops can be reached
/// by steps that do not leave the set.
fn stopping(steps: &[Vec<Step>]) -> Policy {
    let mut allowed = vec![true; steps.len()];
    loop {
        let mut policy: Policy = vec![None; steps.len()];
        loop {
            let mut changed = false;
            for class in (0..steps.len()).filter(|class| allowed[*class]) {
                if policy[class].is_some() {
                    continue;
                }
                let leads = |step: &Step| {
                    let mut targets = step.outcomes.iter();
                    let stays = step.outcomes.iter().all(|(to, _)| allowed[*to]);
                    stays
                        && (step.outcomes.is_empty()
                            || targets.any(|(to, _)| policy[*to].is_some()))
                };
                policy[class] = steps[class].iter().position(leads);
                changed |= policy[class].is_some();
            }
            if !changed {
                break;
            }
        }
        let next: Vec<bool> = policy.iter().map(Option::is_some).collect();
        if next == allowed {
            return policy;
        }
        allowed = next;
    }
}
