//! The scheduler that is best for a weighted sum of objectives, and what it achieves of each.
//!
//! *Definition.* Maximal end components in which no reward is earned become one state each, which may stop: with any
//! set of formulas that a scheduler can satisfy together by staying there. (Smaller sets than one that can be
//! satisfied are no better, weights being positive.) The others are passed through: rewards that should be large
//! must not be earned for ever, which is refused, and those that should be small will not. What is left is a problem
//! of [`crate::optimum`], with rewards of both signs; policy iteration from a scheduler that stops never leaves
//! those that do. Guarantee: exact.

use num_traits::{One, Zero};
use prism_lang::Rational;

use crate::amount::Extended;
use crate::answer::{CheckError, Options};
use crate::graph::{EndComponent, NO_ROW, maximal_end_components};
use crate::joint::Joint;
use crate::optimum::{self, Problem};
use crate::scheduler::tour::Recurring;
use crate::state_space::Csr;

/// What an objective counts.
#[derive(Debug, Clone)]
pub(crate) enum Kind {
    /// The probability of the formula at this place.
    Path(usize),
    /// What each row of the model earns, in so many steps or for ever.
    Reward {
        rows: Vec<Rational>,
        steps: Option<u32>,
        /// Whether it should be small.
        negative: bool,
    },
}

/// The problem without its weights.
pub(crate) struct Skeleton {
    matrix: Csr<Rational>,
    choice_start: Vec<usize>,
    /// For each objective, what each row earns.
    rewards: Vec<Vec<Rational>>,
    /// For each state that stops, what it has of each objective.
    stops: Vec<Option<Vec<Rational>>>,
    /// What each row stands for.
    pub(super) steps: Vec<Step>,
    /// The state of each state of the product.
    pub(super) class: Vec<u32>,
    /// The components that are one state each.
    pub(super) components: Vec<EndComponent>,
}

/// What a row stands for.
#[derive(Debug, Clone)]
pub(super) enum Step {
    /// A row of the product.
    Row(usize),
    /// Staying in the component at this place, where so much recurs.
    Stay(usize, Recurring),
}

/// A corner of what can be achieved: what a scheduler achieves of each objective, and its row in each state.
#[derive(Debug, Clone)]
pub(crate) struct Corner {
    pub numbers: Vec<Rational>,
    pub chosen: Vec<usize>,
}

/// What stopping in a component has of each objective, and what recurs there.
type Stop = (Vec<Rational>, Recurring);

const NO_CLASS: u32 = u32::MAX;

impl Skeleton {
    pub fn new(joint: &mut Joint<'_, Rational>, kinds: &[Kind]) -> Result<Self, CheckError> {
        let rewards: Vec<Vec<Rational>> = kinds.iter().map(|kind| earned(joint, kind)).collect();
        refuse_infinite(joint, kinds, &rewards)?;
        let everywhere = vec![true; joint.num_states()];
        let is_free = |row: usize| rewards.iter().all(|of| of[row].is_zero());
        let components = maximal_end_components(joint.choices(), &everywhere, is_free);
        let mut stops = Vec::with_capacity(components.len());
        for component in &components {
            stops.push(stopping(joint, component, kinds)?);
        }
        // State 0 is where the model starts; its class comes first.
        let mut class = vec![NO_CLASS; joint.num_states()];
        let mut order: Vec<usize> = (0..components.len()).collect();
        order.sort_by_key(|c| components[*c].states[0]);
        for (number, component) in order.iter().enumerate() {
            for state in &components[*component].states {
                class[*state as usize] = number as u32;
            }
        }
        let mut classes = components.len();
        for class in class.iter_mut().filter(|class| **class == NO_CLASS) {
            *class = classes as u32;
            classes += 1;
        }
        let start = class[0];
        let swap = |class: u32| match class {
            0 => start,
            class if class == start => 0,
            class => class,
        };
        class.iter_mut().for_each(|class| *class = swap(*class));
        let mut by_class: Vec<(usize, &[Stop])> = vec![(usize::MAX, &[]); classes];
        for (number, component) in order.iter().enumerate() {
            by_class[swap(number as u32) as usize] = (*component, &stops[*component]);
        }
        let mut skeleton = Self {
            matrix: Csr::with_capacity(classes),
            choice_start: vec![0],
            rewards: vec![Vec::new(); kinds.len()],
            stops: vec![None; classes],
            steps: Vec::new(),
            class: Vec::new(),
            components: Vec::new(),
        };
        skeleton.fill(joint, &class, &by_class, &rewards);
        (skeleton.class, skeleton.components) = (class, components);
        Ok(skeleton)
    }

    fn fill(
        &mut self,
        joint: &Joint<'_, Rational>,
        class: &[u32],
        stops: &[(usize, &[Stop])],
        rewards: &[Vec<Rational>],
    ) {
        let mut rows: Vec<Vec<usize>> = vec![Vec::new(); stops.len()];
        for row in 0..joint.matrix.num_rows() {
            rows[class[joint.owner(row)] as usize].push(row);
        }
        for (number, rows) in rows.iter().enumerate() {
            for row in rows {
                let entries = merged(joint, *row, class, number as u32);
                if entries.is_empty() {
                    continue;
                }
                self.matrix.push_row(entries);
                self.steps.push(Step::Row(*row));
                for (own, of) in self.rewards.iter_mut().zip(rewards) {
                    own.push(of[*row].clone());
                }
            }
            let (component, stops) = stops[number];
            for (stop, recurring) in stops {
                self.matrix
                    .push_row([(self.stops.len() as u32, Rational::one())]);
                self.stops.push(Some(stop.clone()));
                self.steps.push(Step::Stay(component, recurring.clone()));
                self.rewards
                    .iter_mut()
                    .for_each(|own| own.push(Rational::zero()));
            }
            self.choice_start.push(self.matrix.num_rows());
        }
        self.choice_start
            .resize(self.stops.len() + 1, self.matrix.num_rows());
    }

    /// The best scheduler for a weighted sum, and what it achieves of each objective, from the start.
    pub fn best(&self, weights: &[Rational], options: &Options<'_>) -> Result<Corner, CheckError> {
        let sum = |of: &dyn Fn(usize) -> Rational| -> Rational {
            weights.iter().enumerate().map(|(i, w)| w * of(i)).sum()
        };
        let rows = 0..self.matrix.num_rows();
        let reward = rows
            .map(|row| sum(&|i| self.rewards[i][row].clone()))
            .collect();
        let fixed = |stop: &Option<Vec<Rational>>| {
            stop.as_ref()
                .map(|of| Extended::Finite(sum(&|i| of[i].clone())))
        };
        let problem = self.problem(reward, self.stops.iter().map(fixed).collect());
        let chosen = optimum::exact::solve(&problem, options)?.choice;
        let value = |objective: usize| self.value(objective, &chosen, options);
        let numbers = (0..weights.len()).map(value).collect::<Result<_, _>>()?;
        Ok(Corner { numbers, chosen })
    }

    fn problem(
        &self,
        reward: Vec<Rational>,
        fixed: Vec<Option<Extended>>,
    ) -> Problem<Rational, Extended> {
        Problem {
            matrix: self.matrix.clone(),
            choice_start: self.choice_start.clone(),
            reward: reward.into_iter().map(Extended::Finite).collect(),
            fixed,
            maximise: true,
            merged: 0,
        }
    }

    /// What a scheduler achieves of one objective.
    fn value(
        &self,
        objective: usize,
        chosen: &[usize],
        options: &Options<'_>,
    ) -> Result<Rational, CheckError> {
        let mut matrix = Csr::with_capacity(chosen.len());
        let (mut choice_start, mut reward) = (vec![0], Vec::new());
        for row in chosen {
            if *row != NO_ROW {
                let entries = self.matrix.row(*row);
                matrix.push_row(entries.map(|(to, p)| (to as u32, p.clone())));
                reward.push(Extended::Finite(self.rewards[objective][*row].clone()));
            }
            choice_start.push(matrix.num_rows());
        }
        let fixed = |stop: &Option<Vec<Rational>>| {
            stop.as_ref()
                .map(|of| Extended::Finite(of[objective].clone()))
        };
        let problem = Problem {
            matrix,
            choice_start,
            reward,
            fixed: self.stops.iter().map(fixed).collect(),
            maximise: true,
            merged: 0,
        };
        match optimum::exact::solve(&problem, options)?
            .values
            .swap_remove(0)
        {
            Extended::Finite(value) => Ok(value),
            _ => Err(infinite()),
        }
    }
}

fn infinite() -> CheckError {
    CheckError::Unsupported(
        "a reward of `multi` may be infinite, which cannot be computed yet: bound its steps with `C<=k`".to_owned(),
    )
}

/// What each row earns.
fn earned(joint: &Joint<'_, Rational>, kind: &Kind) -> Vec<Rational> {
    let rows = 0..joint.matrix.num_rows();
    match kind {
        Kind::Path(_) => rows.map(|_| Rational::zero()).collect(),
        Kind::Reward {
            rows: of_model,
            steps,
            negative,
        } => rows
            .map(|row| {
                let clock = joint.clock[joint.owner(row)];
                let reward = &of_model[joint.origin[row]];
                match (steps.is_some_and(|steps| clock >= steps), negative) {
                    (true, _) => Rational::zero(),
                    (_, true) => -reward,
                    (_, false) => reward.clone(),
                }
            })
            .collect(),
    }
}

/// Rewards that should be large must be finite.
fn refuse_infinite(
    joint: &Joint<'_, Rational>,
    kinds: &[Kind],
    rewards: &[Vec<Rational>],
) -> Result<(), CheckError> {
    let everywhere = vec![true; joint.num_states()];
    let all = maximal_end_components(joint.choices(), &everywhere, |_| true);
    for (kind, rewards) in kinds.iter().zip(rewards) {
        let mut rows = all.iter().flat_map(|component| &component.rows);
        if matches!(
            kind,
            Kind::Reward {
                negative: false,
                ..
            }
        ) && rows.any(|row| !rewards[*row].is_zero())
        {
            return Err(infinite());
        }
    }
    Ok(())
}

/// What can be had of the objectives by staying in a component: the greatest sets of formulas.
fn stopping(
    joint: &mut Joint<'_, Rational>,
    component: &EndComponent,
    kinds: &[Kind],
) -> Result<Vec<Stop>, CheckError> {
    let paths: Vec<(usize, usize)> = (kinds.iter().enumerate())
        .filter_map(|(place, kind)| match kind {
            Kind::Path(formula) => Some((place, *formula)),
            Kind::Reward { .. } => None,
        })
        .collect();
    if paths.len() > 16 {
        return Err(CheckError::Unsupported(
            "more than 16 formulas in one `multi` cannot be computed: ask for fewer".to_owned(),
        ));
    }
    let mut masks: Vec<u32> = (0..1 << paths.len()).collect();
    masks.sort_by_key(|mask| std::cmp::Reverse(mask.count_ones()));
    let mut found: Vec<(u32, Recurring)> = Vec::new();
    for mask in masks {
        if found.iter().any(|(greater, _)| greater & mask == mask) {
            continue;
        }
        let inside = |place: &usize| mask & (1 << place) != 0;
        let wanted: Vec<usize> = (0..paths.len())
            .filter(inside)
            .map(|p| paths[p].1)
            .collect();
        if let Some(recurring) = joint.recurring(component, &wanted)? {
            found.push((mask, recurring));
        }
    }
    let values = |(mask, recurring): (u32, Recurring)| {
        let mut values = vec![Rational::zero(); kinds.len()];
        for (place, (objective, _)) in paths.iter().enumerate() {
            if mask & (1 << place) != 0 {
                values[*objective] = Rational::one();
            }
        }
        (values, recurring)
    };
    Ok(found.into_iter().map(values).collect())
}

/// A row's entries by class, without the own one.
fn merged(
    joint: &Joint<'_, Rational>,
    row: usize,
    class: &[u32],
    own: u32,
) -> Vec<(u32, Rational)> {
    let mut entries: Vec<(u32, Rational)> = (joint.matrix.row(row))
        .map(|(target, p)| (class[target], p.clone()))
        .filter(|(class, _)| *class != own)
        .collect();
    entries.sort_by_key(|(class, _)| *class);
    entries.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += &next.1;
        }
        same
    });
    entries
}
