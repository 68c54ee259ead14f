//! Interval models: Markov chains whose transition probabilities are only known to lie in intervals,
//! and the least and largest probability of a property over all chains within them.
//!
//! # Definition
//! An interval model has for each transition `l_ij <= p_ij <= u_ij`; any row with these bounds and the
//! sum 1 may be taken, in each state on its own and at each visit anew. For reachability
//!
//! ```text
//! low(i)  = min over rows p of sum_j p_j low(j),    high(i) = max over rows p of sum_j p_j high(j)
//! ```
//!
//! The best row gives its free mass to the smallest (largest) values first. `low` is iterated from 0
//! upwards and `high` from 1 downwards, component by component, so that both are bounds at every
//! moment; the work ends when a round changes nothing by more than 1e-12.
//!
//! *From a model with uncertain constants* ([`IntervalModel::new`]): each constant lies in an interval.
//! Where every transition probability is a polynomial in which no constant occurs squared, its range
//! over the box is that over the box's corners, and each corner is explored. What is no such polynomial
//! is refused, with the reason. The box is contained in the interval model, whose rows are free of each
//! other: the bounds hold for every choice of the constants, and are conservative.
//!
//! # Source
//! R. Givan, S. Leach and T. Dean, "Bounded-parameter Markov decision processes" (2000); A. Nilim and
//! L. El Ghaoui, "Robust control of Markov decision processes with uncertain transition matrices"
//! (2005), for the robust values and the order of the free mass. Deviations: components; iteration from
//! both sides; corners instead of interval arithmetic.
//!
//! # Cost
//! `2^k` explorations for `k` constants; then rounds times transitions times their logarithm.
//!
//! # Guarantee
//! The bounds hold, rounding included (each mean is widened by more than its error). All transitions
//! keep a positive lower bound, else the model is refused: so all chains within have the same graph, and
//! every open state is left almost surely, however rows are chosen. A constant whose interval begins at 0 or ends at 1 is
//! followed up to there: bounds hold for the limit, and at the end itself unless a loop is then never left.

mod corners;
mod degrees;
mod range;
mod solve;

pub use corners::{ConstantRange, IntervalModelError};
pub use range::Range;

use crate::answer::{Answer, CheckError, Options};
use crate::method::Method;
use crate::property::Checker;
use crate::state_space::{Csr, StateSpace};
use prism_lang::Property;
use prism_lang::resolved::ModelType;
use solve::Robust;

/// A chain with intervals for transition probabilities.
#[derive(Clone, Debug)]
pub struct IntervalModel {
    space: StateSpace<Range>,
}

impl IntervalModel {
    /// An interval model from its rows: `(target, range)`, targets distinct within a row. `labels` give
    /// each label's states (one flag per state).
    ///
    /// # Errors
    /// [`IntervalModelError::Row`] where no probabilities within the ranges sum to 1, or a lower bound is
    /// not positive.
    pub fn from_rows(
        rows: Vec<Vec<(u32, Range)>>,
        initial: Vec<usize>,
        labels: Vec<(String, Vec<bool>)>,
    ) -> Result<Self, IntervalModelError> {
        let space = StateSpace::from_matrix(Csr::from_rows(rows), initial, labels);
        Self::feasible(space)
    }

    /// All chains whose transition probabilities are within `radius` of those of a chain, for example because these are written
    /// with so many digits only. A transition that is certain stays so. Rewards have no ranges.
    ///
    /// # Errors
    /// [`IntervalModelError::Form`] if it is no `dtmc`; [`IntervalModelError::Row`] if a transition might have no probability.
    ///
    /// ```
    /// use checker::explore::explore;
    /// use checker::interval_model::IntervalModel;
    /// use checker::{Guarantee, Options};
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    ///
    /// let text = "dtmc module m s : [0..2]; [] s=0 -> 0.25:(s'=1) + 0.75:(s'=2); endmodule";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).expect("a correct model");
    /// let intervals = IntervalModel::around(explore(&model)?, 0.01)?;
    /// let properties = parse_properties("P=? [ F s=1 ]").tree;
    /// let properties = resolve_properties(&properties, &model, &Constants::new()).expect("correct");
    /// let answer = intervals.check(&properties[0].property, &Options::default())?;
    /// let Guarantee::Bounded { low, high } = answer.guarantee else { unreachable!() };
    /// assert!((low - 0.24).abs() < 1e-12 && (high - 0.26).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn around(space: StateSpace<f64>, radius: f64) -> Result<Self, IntervalModelError> {
        if space.kind != ModelType::Dtmc {
            let kind = space.kind.keyword();
            let why = format!("the probabilities of a {kind} have no ranges");
            return Err(IntervalModelError::Form(why));
        }
        let mut space = corners::as_ranges(space);
        for range in &mut space.matrix.value {
            if range.low < 1.0 {
                range.low = (range.low - radius).next_down();
                range.high = (range.high + radius).next_up().min(1.0);
            }
        }
        Self::feasible(space)
    }

    fn feasible(space: StateSpace<Range>) -> Result<Self, IntervalModelError> {
        for row in 0..space.num_states() {
            let (mut low, mut high) = (0.0, 0.0);
            for (_, range) in space.matrix.row(row) {
                if range.low <= 0.0 || range.low > range.high {
                    return Err(IntervalModelError::Row { state: row });
                }
                low += range.low;
                high += range.high;
            }
            // Sums of probabilities round; what they miss is allowed for where means are formed.
            if low > 1.0 + SUM_TOLERANCE || high < 1.0 - SUM_TOLERANCE {
                return Err(IntervalModelError::Row { state: row });
            }
        }
        Ok(Self { space })
    }

    /// The number of states.
    pub fn num_states(&self) -> usize {
        self.space.num_states()
    }

    /// Bounds of a property's probability over all chains within, as the answer's guarantee.
    ///
    /// # Errors
    /// See [`CheckError`]; a comparison within the property that the bounds leave open is one.
    ///
    /// ```
    /// use checker::interval_model::{ConstantRange, IntervalModel};
    /// use checker::{Guarantee, Options};
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    ///
    /// let tree = parse_model("dtmc const double p = 0.1; module m s : [0..2];
    ///     [] s=0 -> p:(s'=1) + 1-p:(s'=2); endmodule").tree;
    /// let range = ConstantRange { name: "p".into(), low: 0.05, high: 0.2 };
    /// let intervals = IntervalModel::new(&tree, &[range], 1000, &|| false)?;
    /// let model = resolve(&tree, &Constants::new()).expect("a correct model");
    /// let properties = parse_properties("P=? [ F s=2 ]").tree;
    /// let properties = resolve_properties(&properties, &model, &Constants::new()).expect("correct");
    /// let answer = intervals.check(&properties[0].property, &Options::default())?;
    /// let Guarantee::Bounded { low, high } = answer.guarantee else { unreachable!() };
    /// assert!((low - 0.8).abs() < 1e-12 && (high - 0.95).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check(&self, property: &Property, options: &Options<'_>) -> Result<Answer, CheckError> {
        Checker::<Robust>::new(&self.space, options)?.answer(property, Method::Sound)
    }
}

/// By how much a row's sum may miss 1.
const SUM_TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests;
