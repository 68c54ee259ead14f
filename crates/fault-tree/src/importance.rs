//! Measures of importance of a basic event `i` for an event `T`.
//!
//! With `P1 = P(T | i occurs)` and `P0 = P(T | i does not occur)`:
//!
//! | measure | definition | says |
//! |---|---|---|
//! | Birnbaum | `P1 - P0` | how much `P(T)` changes with `p_i` |
//! | criticality | `p_i (P1 - P0) / P(T)` | which part of `P(T)` would be gone if `i` could not occur |
//! | risk achievement worth | `P1 / P(T)` | by which factor `P(T)` grows if `i` occurs for certain |
//! | risk reduction worth | `P(T) / P0` | by which factor `P(T)` falls if `i` cannot occur |
//!
//! Source: Z. W. Birnbaum, 1969; W. E. Vesely et al., *Measures of Risk Importance and Their Applications*, NUREG/CR-3385,
//! 1983. As `P(T) = p_i P1 + (1 - p_i) P0`, the criticality is `(P(T) - P0) / P(T)`, which is the measure of Fussell and Vesely
//! as risk analysis has it. (Their older form, the probability of all cut sets with `i` over `P(T)`, is at least as large, and
//! is not computed.)
//!
//! `P1` and `P0` are each computed from the decision diagram, not as differences, so small ones keep their digits; the cost is
//! two evaluations for each basic event of the part of the diagram above it. Guarantee: bounds, for every choice of data within
//! their ranges. Where there are ranges they may be wider than what is attained, since `P1`, `P0` and `P(T)` are bounded
//! apart.

use diagnostic::{Cancel, Problem};

use crate::analysis::Analysis;
use crate::data::EventData;
use crate::enclosure::Enclosure;
use crate::function::Direction;
use crate::probability::evaluate;
use crate::tree::NodeId;

/// How important a basic event is. All are bounds of the value; see the module's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Importance {
    /// The basic event.
    pub event: NodeId,
    /// Its own probability.
    pub probability: Enclosure,
    /// `P1 - P0`. Negative where the basic event prevents the event.
    pub birnbaum: Enclosure,
    /// `p (P1 - P0) / P(T)`: also the measure of Fussell and Vesely. `None` if `P(T)` is 0.
    pub criticality: Option<Enclosure>,
    /// `P1 / P(T)`. `None` if `P(T)` is 0.
    pub risk_achievement_worth: Option<Enclosure>,
    /// `P(T) / P0`; infinite where the event needs the basic event. `None` if `P(T)` is 0.
    pub risk_reduction_worth: Option<Enclosure>,
}

impl Analysis<'_> {
    /// The importance of each basic event on which the event depends, in the order of [`Analysis::support`].
    ///
    /// # Errors
    /// Basic events without data (`missing-event-data`), and interruption.
    pub fn importance(&self, cancel: &Cancel) -> Result<Vec<Importance>, Problem> {
        let data: Vec<Option<&EventData>> = self.data()?;
        let events = self.enclosures(&data);
        let values = self.values(&events, cancel)?;
        let top = values[self.function.root as usize];
        let support = self.function.support(self.events.len());
        let mut found = Vec::new();
        let mut scratch = values.clone();
        for level in (0..self.events.len()).filter(|it| support[*it]) {
            let with = self.given(level, 1.0, &events, &mut scratch, cancel)?;
            let without = self.given(level, 0.0, &events, &mut scratch, cancel)?;
            // The next one starts from the values as they are without a condition.
            let first = self.function.first_up_from(level as u32);
            scratch[first..].copy_from_slice(&values[first..]);
            found.push(self.measures(level, events[level], top, with, without));
        }
        Ok(found)
    }

    /// The probability of the event if one basic event has this probability.
    fn given(
        &self,
        level: usize,
        probability: f64,
        events: &[Enclosure],
        values: &mut [Enclosure],
        cancel: &Cancel,
    ) -> Result<Enclosure, Problem> {
        let mut events = events.to_vec();
        events[level] = Enclosure::point(probability);
        let first = self.function.first_up_from(level as u32);
        evaluate(&self.function, &events, first, values, cancel)?;
        Ok(values[self.function.root as usize])
    }

    fn measures(
        &self,
        level: usize,
        probability: Enclosure,
        top: Enclosure,
        with: Enclosure,
        without: Enclosure,
    ) -> Importance {
        let mut birnbaum = with.minus(without);
        match self.directions[level] {
            Direction::Increasing => birnbaum.lower = birnbaum.lower.max(0.0),
            Direction::Decreasing => birnbaum.upper = birnbaum.upper.min(0.0),
            Direction::Mixed => {}
        }
        birnbaum = Enclosure {
            lower: birnbaum.lower.max(-1.0),
            upper: birnbaum.upper.min(1.0),
        };
        let is_possible = top.upper > 0.0;
        Importance {
            event: self.events[level],
            probability,
            birnbaum,
            criticality: is_possible.then(|| share(probability, birnbaum, top)),
            risk_achievement_worth: is_possible.then(|| with.over(top)),
            risk_reduction_worth: is_possible.then(|| top.over(without)),
        }
    }
}

/// `p * b / t`, where only `b` may be negative.
fn share(p: Enclosure, b: Enclosure, t: Enclosure) -> Enclosure {
    let size = |low: f64, high: f64| {
        p.times(Enclosure {
            lower: low,
            upper: high,
        })
        .over(t)
    };
    let lower = match b.lower < 0.0 {
        true => -size(0.0, -b.lower).upper,
        false => size(b.lower, b.lower).lower,
    };
    let upper = match b.upper < 0.0 {
        true => -size(-b.upper, -b.upper).lower,
        false => size(0.0, b.upper).upper,
    };
    // A part of the whole.
    Enclosure {
        lower,
        upper: upper.min(1.0),
    }
}
