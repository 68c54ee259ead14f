//! What of a model a property speaks of: reward structures, labels, expressions.

use std::collections::BTreeSet;

use super::{
    Filter, FilterOperand, Objective, Path, Property, Quantity, RewardObjective, RewardQuery,
    StateFormula,
};
use crate::expr::Expr;

/// What of a model a property speaks of.
#[derive(Clone, Debug, Default)]
pub struct Mentioned<'p> {
    /// The indices of the reward structures, in [`Model::rewards`](crate::resolved::Model::rewards).
    pub structures: BTreeSet<usize>,
    /// Predicates and numbers over the variables.
    pub expressions: Vec<&'p Expr>,
    /// Labels, the built-in ones too.
    pub labels: Vec<&'p str>,
    /// Whether states are listed, counted or chosen from by filters.
    pub has_filters: bool,
}

impl Property {
    /// The indices of the reward structures that it speaks of, in [`Model::rewards`](crate::resolved::Model::rewards).
    ///
    /// ```
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    /// let text = "dtmc module m x : [0..1]; endmodule
    ///     rewards \"a\" true : 1; endrewards rewards \"b\" true : 2; endrewards";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    /// let file = parse_properties("P=? [ F x=1 ]; filter(max, R{\"b\"}=? [ F x=1 ]) + 1; R{\"a\"}<3 [ C<=5 ] & x=0").tree;
    /// let asked = resolve_properties(&file, &model, &Constants::new()).unwrap();
    /// let needed = |at: usize| asked[at].property.reward_structures().into_iter().collect::<Vec<_>>();
    /// assert_eq!((needed(0), needed(1), needed(2)), (vec![], vec![1], vec![0]));
    /// ```
    pub fn reward_structures(&self) -> BTreeSet<usize> {
        self.mentioned().structures
    }

    /// All that it speaks of.
    pub fn mentioned(&self) -> Mentioned<'_> {
        let mut found = Mentioned::default();
        match self {
            Self::Probability { path, .. } => in_path(path, &mut found),
            Self::State(formula) => in_state(formula, &mut found),
            Self::Number(quantity) => in_quantity(quantity, &mut found),
            Self::Range(filter) => in_filter(filter, &mut found),
            Self::Objectives(objectives) => {
                for objective in objectives {
                    match objective {
                        Objective::Optimise(_, quantity) => in_quantity(quantity, &mut found),
                        Objective::Require(formula) => in_state(formula, &mut found),
                    }
                }
            }
        }
        found
    }
}

fn in_state<'p>(formula: &'p StateFormula, found: &mut Mentioned<'p>) {
    match formula {
        StateFormula::Expr(expr) => found.expressions.push(expr),
        StateFormula::Label(label) => found.labels.push(label),
        StateFormula::Not(a) | StateFormula::SomeScheduler(a) => in_state(a, found),
        StateFormula::And(a, b)
        | StateFormula::Or(a, b)
        | StateFormula::Implies(a, b)
        | StateFormula::Iff(a, b) => [a, b].iter().for_each(|f| in_state(f, found)),
        StateFormula::Choice(a, b, c) => [a, b, c].iter().for_each(|f| in_state(f, found)),
        StateFormula::Probability { path, .. }
        | StateFormula::ForAll(path)
        | StateFormula::Exists(path) => in_path(path, found),
        StateFormula::Reward { reward, .. } => in_query(reward, found),
        StateFormula::LongRun { states, .. } => in_state(states, found),
        StateFormula::Compare(_, a, b) => [a, b].iter().for_each(|q| in_quantity(q, found)),
        StateFormula::Filter(filter) => in_filter(filter, found),
    }
}

fn in_path<'p>(path: &'p Path, found: &mut Mentioned<'p>) {
    match path {
        Path::State(formula) => in_state(formula, found),
        Path::Not(a) | Path::Next(a) => in_path(a, found),
        Path::Finally { operand, .. } | Path::Globally { operand, .. } => in_path(operand, found),
        Path::And(a, b) | Path::Or(a, b) | Path::Implies(a, b) | Path::Iff(a, b) => {
            [a, b].iter().for_each(|p| in_path(p, found));
        }
        Path::Until { left, right, .. }
        | Path::WeakUntil { left, right, .. }
        | Path::Release { left, right, .. } => {
            [left, right].iter().for_each(|p| in_path(p, found));
        }
        Path::Timed { left, right, .. } => {
            left.iter().for_each(|p| in_path(p, found));
            in_path(right, found);
        }
    }
}

fn in_quantity<'p>(quantity: &'p Quantity, found: &mut Mentioned<'p>) {
    match quantity {
        Quantity::Expr(expr) => found.expressions.push(expr),
        Quantity::Probability { path, .. } => in_path(path, found),
        Quantity::Conditional {
            path, condition, ..
        } => [path, condition].iter().for_each(|p| in_path(p, found)),
        Quantity::Reward { reward, .. } => in_query(reward, found),
        Quantity::LongRun(states) => in_state(states, found),
        Quantity::Minus(a) => in_quantity(a, found),
        Quantity::Binary(_, a, b) => [a, b].iter().for_each(|q| in_quantity(q, found)),
        Quantity::Choice(condition, a, b) => {
            in_state(condition, found);
            [a, b].iter().for_each(|q| in_quantity(q, found));
        }
        Quantity::Call(_, arguments) => arguments.iter().for_each(|q| in_quantity(q, found)),
        Quantity::Filter(filter) => in_filter(filter, found),
    }
}

fn in_query<'p>(reward: &'p RewardQuery, found: &mut Mentioned<'p>) {
    found.structures.insert(reward.structure);
    found.structures.extend(reward.divisor);
    match &reward.objective {
        RewardObjective::Reach(formula) => in_state(formula, found),
        RewardObjective::CoSafe(path) => in_path(path, found),
        RewardObjective::Cumulative(_)
        | RewardObjective::Total
        | RewardObjective::Instantaneous(_)
        | RewardObjective::LongRun => {}
    }
}

fn in_filter<'p>(filter: &'p Filter, found: &mut Mentioned<'p>) {
    found.has_filters = true;
    match &filter.operand {
        FilterOperand::Truth(formula) => in_state(formula, found),
        FilterOperand::Number(quantity) => in_quantity(quantity, found),
    }
    filter.states.iter().for_each(|f| in_state(f, found));
}
