//! The probability of an event, with its guarantee.
//!
//! The probability of a node of the decision diagram is `p * P(high) + (1 - p) * P(low)` (Shannon's expansion; Rauzy 1993).
//! It is computed twice at most: in rationals without rounding, where all data are rational and the numbers stay small enough,
//! and else in intervals of doubles that are rounded outwards.
//!
//! Where basic events have ranges, the result is the range that they leave. The probability of the event is linear in that of
//! each basic event, so its extremes are at ends of ranges. Where the event only rises, or only falls, in each basic event
//! that has a range, it is known at which ends, and the range is attained. Of up to ten others all combinations of ends are
//! tried. With more of them, a basic event may be taken at both its ends in different nodes, so that the range is sound and may
//! be wider than what is attained; [`Guarantee`] says so.

use diagnostic::{Cancel, Problem};
use num_bigint::{BigInt, BigUint};
use num_rational::BigRational;
use num_traits::{One, Zero};
use stats::Confidence;

use crate::analysis::Analysis;
use crate::bdd::{BOTTOM, FALSE, TRUE};
use crate::data::EventData;
use crate::enclosure::Enclosure;
use crate::function::{Direction, Function};
use crate::tree::{NodeId, NodeKind};

/// Basic events with ranges in which an event neither only rises nor only falls, of which all ends are tried.
const MOST_TRIED: usize = 10;
/// Names that a message lists.
const MOST_NAMES: usize = 10;
/// Nodes between looks at the flag that asks to stop.
const NODES_BETWEEN_LOOKS: usize = 4_096;

/// How sure a probability is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guarantee {
    /// The rational number is the probability; the bounds are the doubles next to it.
    Exact,
    /// The probability is one number, and lies within the bounds, which differ by rounding.
    Rounded,
    /// The probability is within the bounds whatever the basic events are within their ranges.
    Range {
        /// Whether some choice within the ranges leads to each bound, up to rounding.
        is_attained: bool,
    },
    /// The same with this confidence, for all counts of basic events together (each at a level by Bonferroni).
    Statistical {
        /// The level, for example 0.95.
        confidence: f64,
        /// Whether some choice within the intervals of the counts leads to each bound, up to rounding.
        is_attained: bool,
    },
}

impl Guarantee {
    /// What that means for a number that lies between `low` and `high` as the probability lies between its bounds. Whether
    /// bounds are attained is of no matter for what may be concluded.
    #[must_use]
    pub fn between(self, low: f64, high: f64) -> stats::Guarantee {
        match self {
            Guarantee::Exact => stats::Guarantee::Exact,
            Guarantee::Rounded | Guarantee::Range { .. } => stats::Guarantee::Bounded { low, high },
            Guarantee::Statistical { confidence, .. } => stats::Guarantee::Statistical {
                confidence,
                low,
                high,
            },
        }
    }
}

/// A probability with its guarantee.
#[derive(Clone, Debug, PartialEq)]
pub struct Probability {
    /// The bounds.
    pub bounds: Enclosure,
    /// The exact value, where the guarantee is [`Guarantee::Exact`].
    pub exact: Option<BigRational>,
    /// How sure it is.
    pub guarantee: Guarantee,
}

impl Analysis<'_> {
    /// The probability of the event.
    ///
    /// # Errors
    /// Basic events without data (`missing-event-data`), and interruption.
    pub fn probability(&self, cancel: &Cancel) -> Result<Probability, Problem> {
        let data = self.data()?;
        let is_range = |it: &Option<&EventData>| it.is_some_and(EventData::is_range);
        if !data.iter().any(is_range) {
            return self.one_probability(&data, cancel);
        }
        let (bounds, is_attained) = self.range(&data, cancel)?;
        let is_counted = |it: &Option<&EventData>| matches!(it, Some(EventData::Counts { .. }));
        let guarantee = match data.iter().any(is_counted) {
            false => Guarantee::Range { is_attained },
            true => Guarantee::Statistical {
                confidence: self.options.confidence.level(),
                is_attained,
            },
        };
        Ok(Probability {
            bounds,
            exact: None,
            guarantee,
        })
    }

    /// Bounds of the probability of the event if basic events had these probabilities instead of their data, for example at
    /// each point of a distribution.
    ///
    /// # Errors
    /// Basic events without data (`missing-event-data`), and interruption.
    pub fn probability_at(
        &self,
        instead: &[(NodeId, f64)],
        cancel: &Cancel,
    ) -> Result<Enclosure, Problem> {
        let mut events = self.enclosures(&self.data()?);
        for (event, known) in self.events.iter().zip(&mut events) {
            if let Some((_, probability)) = instead.iter().find(|(id, _)| id == event) {
                *known = Enclosure::point(*probability);
            }
        }
        Ok(self.values(&events, cancel)?[self.function.root as usize])
    }

    fn one_probability(
        &self,
        data: &[Option<&EventData>],
        cancel: &Cancel,
    ) -> Result<Probability, Problem> {
        if let Some(exact) = self.exact(data, cancel)? {
            return Ok(Probability {
                bounds: Enclosure::of(&exact),
                exact: Some(exact),
                guarantee: Guarantee::Exact,
            });
        }
        let values = self.values(&self.enclosures(data), cancel)?;
        Ok(Probability {
            bounds: values[self.function.root as usize],
            exact: None,
            guarantee: Guarantee::Rounded,
        })
    }

    /// The data of the basic events by level; `None` for those on which the event does not depend.
    pub(crate) fn data(&self) -> Result<Vec<Option<&EventData>>, Problem> {
        let support = self.function.support(self.events.len());
        let mut data = Vec::with_capacity(self.events.len());
        let mut missing = Vec::new();
        for (event, used) in self.events.iter().zip(support) {
            match &self.tree.node(*event).kind {
                NodeKind::Basic(Some(known)) if used => data.push(Some(known)),
                NodeKind::Basic(None) if used => missing.push(self.tree.name(*event)),
                _ => data.push(None),
            }
        }
        if missing.is_empty() {
            return Ok(data);
        }
        let names = missing[..missing.len().min(MOST_NAMES)].join("`, `");
        let more = missing.len().saturating_sub(MOST_NAMES);
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        let message = format!("no probability is known of `{names}`{more}");
        Err(Problem::new("missing-event-data", message)
            .remedy("give each a probability, a rate with a mission time, an interval or counts"))
    }

    /// An interval for each basic event by level.
    pub(crate) fn enclosures(&self, data: &[Option<&EventData>]) -> Vec<Enclosure> {
        let counted = data
            .iter()
            .flatten()
            .filter(|it| matches!(it, EventData::Counts { .. }));
        let confidence: Confidence = self.options.confidence.simultaneous(counted.count());
        let enclosure = |it: &Option<&EventData>| match it {
            Some(data) => data.enclosure(confidence),
            None => Enclosure::point(0.0),
        };
        data.iter().map(enclosure).collect()
    }

    /// The probability of each node of the function.
    pub(crate) fn values(
        &self,
        events: &[Enclosure],
        cancel: &Cancel,
    ) -> Result<Vec<Enclosure>, Problem> {
        let mut values = vec![Enclosure::point(0.0), Enclosure::point(1.0)];
        values.resize(self.function.nodes.len(), Enclosure::point(0.0));
        evaluate(&self.function, events, 2, &mut values, cancel)?;
        Ok(values)
    }

    fn range(
        &self,
        data: &[Option<&EventData>],
        cancel: &Cancel,
    ) -> Result<(Enclosure, bool), Problem> {
        let mut events = self.enclosures(data);
        let root = self.function.root as usize;
        let levels = data.iter().enumerate();
        let is_open = |(level, data): &(usize, &Option<&EventData>)| {
            data.is_some_and(EventData::is_range) && self.directions[*level] == Direction::Mixed
        };
        let open: Vec<usize> = levels.filter(is_open).map(|(level, _)| level).collect();
        if open.is_empty() || open.len() > MOST_TRIED {
            return Ok((self.values(&events, cancel)?[root], open.is_empty()));
        }
        let ranges: Vec<Enclosure> = open.iter().map(|level| events[*level]).collect();
        let mut found: Option<Enclosure> = None;
        for choice in 0..1_u32 << open.len() {
            for (bit, (level, range)) in open.iter().zip(&ranges).enumerate() {
                let is_upper = choice >> bit & 1 == 1;
                events[*level] = Enclosure::point(if is_upper { range.upper } else { range.lower });
            }
            let value = self.values(&events, cancel)?[root];
            let so_far = found.unwrap_or(value);
            found = Some(Enclosure {
                lower: so_far.lower.min(value.lower),
                upper: so_far.upper.max(value.upper),
            });
        }
        Ok((found.expect("at least two choices"), true))
    }

    /// The exact probability; `None` if some data are not rational, or the numbers would become too large.
    ///
    /// Numerators over the product of the denominators of all basic events from a node's own downwards: so nothing has to be
    /// reduced on the way.
    fn exact(
        &self,
        data: &[Option<&EventData>],
        cancel: &Cancel,
    ) -> Result<Option<BigRational>, Problem> {
        let exact = |it: &Option<&EventData>| match it {
            Some(data) => data.exact(),
            None => Some(BigRational::zero()),
        };
        let Some(events) = data.iter().map(exact).collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let Some(scales) = self.scales(&events) else {
            return Ok(None);
        };
        let mut values: Vec<BigUint> = vec![BigUint::zero(), BigUint::one()];
        let nodes = &self.function.nodes;
        let place = |index: u32| match nodes[index as usize].level {
            BOTTOM => events.len(),
            level => level as usize,
        };
        for node in &nodes[2..] {
            look(values.len(), cancel)?;
            let level = node.level as usize;
            let scaled = |index: u32| match index {
                FALSE => BigUint::zero(),
                TRUE => scales[level + 1].clone(),
                _ if place(index) == level + 1 => values[index as usize].clone(),
                _ => &values[index as usize] * (&scales[level + 1] / &scales[place(index)]),
            };
            let numerator = events[level].numer().magnitude();
            let rest = events[level].denom().magnitude() - numerator;
            values.push(numerator * scaled(node.high) + rest * scaled(node.low));
        }
        let root = self.function.root;
        let denominator = scales[place(root)].clone();
        Ok(Some(BigRational::new(
            BigInt::from(values[root as usize].clone()),
            BigInt::from(denominator),
        )))
    }

    /// The products of denominators from each level downwards, if all numbers together stay within the limit.
    fn scales(&self, events: &[BigRational]) -> Option<Vec<BigUint>> {
        let mut bits = vec![0_u64; events.len() + 1];
        for (level, event) in events.iter().enumerate().rev() {
            bits[level] = bits[level + 1] + event.denom().bits();
        }
        let of_nodes = self.function.nodes[2..]
            .iter()
            .map(|node| bits[node.level as usize]);
        let total = of_nodes
            .chain(bits.iter().copied())
            .fold(0_u64, u64::saturating_add);
        if total > self.options.exact_bits {
            return None;
        }
        let mut scales = vec![BigUint::one(); events.len() + 1];
        for (level, event) in events.iter().enumerate().rev() {
            scales[level] = &scales[level + 1] * event.denom().magnitude();
        }
        Some(scales)
    }
}

/// Computes the values of the nodes from `first` on; those before it are there.
pub(crate) fn evaluate(
    function: &Function,
    events: &[Enclosure],
    first: usize,
    values: &mut [Enclosure],
    cancel: &Cancel,
) -> Result<(), Problem> {
    for index in first..function.nodes.len() {
        look(index, cancel)?;
        let node = function.nodes[index];
        let (high, low) = (values[node.high as usize], values[node.low as usize]);
        values[index] = events[node.level as usize].mix(high, low);
    }
    Ok(())
}

fn look(index: usize, cancel: &Cancel) -> Result<(), Problem> {
    if index.is_multiple_of(NODES_BETWEEN_LOOKS) && cancel.is_cancelled() {
        return Err(Problem::interrupted_while(
            "computing the probability of a fault tree",
        ));
    }
    Ok(())
}
