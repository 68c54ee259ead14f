//! Bounds of what is left to solve when a check is stopped ([`crate::stop`]).
//!
//! *Method.* Of a component that was being solved, what its iteration has reached; of others, some rounds of value
//! iteration, while [`LAST_WORK`] lasts. From below both give an inductive lower bound (see [`super`]); the upper one holds if
//! a guess above it is inductive.
//!
//! *Guarantee.* The bounds contain the optimum, however wide: no value is less than the least right outside, as nothing
//! earned is negative and a best scheduler leaves; and if nothing is earned, none is greater than the greatest. Cost: a few
//! rounds.

use super::{CheckError, Local, OUTSIDE, Search, Solver};
use crate::rounding::Bounds;

/// Multiplications that are done for better bounds once a check is stopped.
pub(super) const LAST_WORK: u64 = 20_000_000;

impl Solver<'_> {
    /// Solves a component; if that is stopped before it has bounds, by some rounds from the values right outside.
    pub(super) fn component_or_enclose(&mut self, component: &[u32]) -> Result<(), CheckError> {
        let options = self.context.options;
        if !options.must_stop() {
            match self.component(component) {
                Err(CheckError::Cancelled) if options.must_stop() => {}
                other => return other,
            }
        }
        let local = Local::new(&self.equations, component, &mut self.position);
        let input_error = self.input_error(&local);
        let (maximise, cap) = (self.equations.maximise, self.equations.cap);
        let mut search = Search::new(&local, maximise, options.precision, cap);
        self.last_work -= search.last_rounds(self.last_work);
        self.keep_reached(component, &mut search, input_error)
    }

    /// Keeps the bounds that a search has reached when the check is stopped.
    pub(super) fn keep_reached(
        &mut self,
        component: &[u32],
        search: &mut Search<'_>,
        input_error: f64,
    ) -> Result<(), CheckError> {
        search.bounds_reached();
        let outside = self.outside(component);
        let has_rewards = !self.equations.reward.is_empty();
        for (low, high) in &mut search.found {
            *low = low.max(outside.low);
            if !has_rewards {
                *high = high.min(outside.high);
            }
        }
        self.keep_found(component, search, input_error)
    }

    /// The least and the greatest value right outside a component.
    fn outside(&mut self, component: &[u32]) -> Bounds {
        for state in component {
            self.position[*state as usize] = 0;
        }
        let mut outside = Bounds {
            low: f64::INFINITY,
            high: 0.0,
        };
        let choices = self.equations.choices;
        for row in component.iter().flat_map(|s| choices.rows(*s as usize)) {
            for target in choices.targets(row).iter().map(|t| *t as usize) {
                let Bounds { low, high } = self.equations.values[target];
                // Choices that may lead to infinite values are left out.
                if self.position[target] == OUTSIDE && low < f64::INFINITY {
                    outside.low = outside.low.min(low);
                    outside.high = outside.high.max(high);
                }
            }
        }
        for state in component {
            self.position[*state as usize] = OUTSIDE;
        }
        outside
    }
}
