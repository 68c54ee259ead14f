//! Least and greatest values together, and how often a formula becomes true.

use super::between::Between;
use super::program::{End, Program};
use crate::formula::positive::Positive;
use crate::formula::report::RobustnessBounds;
use crate::formula::settings::Ending;

/// The least value that a formula can have, and, where something is unknown, the greatest.
#[derive(Debug, Clone)]
pub(in crate::formula) struct Bounded {
    least: Program,
    greatest: Option<Program>,
}

impl Bounded {
    pub(in crate::formula) fn new(formula: &Positive, first_only: bool) -> Self {
        Bounded {
            least: Program::new(formula, End::Least, first_only),
            greatest: None,
        }
    }

    /// Begins to compute the greatest value on its own; so far it was the least one.
    fn split(&mut self) -> &mut Program {
        let least = &self.least;
        self.greatest
            .get_or_insert_with(|| least.with_end(End::Greatest))
    }

    /// Takes the atoms at a place, and what they were between it and the last one.
    pub(in crate::formula) fn step(
        &mut self,
        place: i64,
        between: &[Between],
        atoms: &[RobustnessBounds],
    ) {
        let is_open = |bounds: &RobustnessBounds| bounds.low != bounds.high;
        if self.greatest.is_none()
            && (atoms.iter().any(is_open)
                || between
                    .iter()
                    .any(|part| is_open(&part.first) || is_open(&part.then)))
        {
            self.split();
        }
        self.least.step(place, between, atoms);
        if let Some(greatest) = &mut self.greatest {
            greatest.step(place, between, atoms);
        }
    }

    pub(in crate::formula) fn bounds(&self) -> RobustnessBounds {
        RobustnessBounds {
            low: self.least.bound(f64::NEG_INFINITY),
            high: self
                .greatest
                .as_ref()
                .unwrap_or(&self.least)
                .bound(f64::INFINITY),
        }
    }

    pub(in crate::formula) fn close(&mut self, ending: Ending) -> RobustnessBounds {
        let (low, high) = match ending {
            Ending::Inconclusive => (Some(f64::NEG_INFINITY), Some(f64::INFINITY)),
            Ending::Weak => (Some(f64::INFINITY), Some(f64::INFINITY)),
            Ending::Strong => (Some(f64::NEG_INFINITY), Some(f64::NEG_INFINITY)),
            Ending::Finite | Ending::LongEnough => (None, None),
        };
        self.split().close(high);
        self.least.close(low);
        self.bounds()
    }

    /// The truth from the first place on, as places up to which it holds; after [`Bounded::close`].
    pub(in crate::formula) fn runs(&mut self) -> Vec<(i64, Option<bool>)> {
        let mut runs = Vec::new();
        let mut place = 0;
        loop {
            let least = self.least.root();
            least.forget_before(place);
            let Some(low) = least.first() else {
                return runs;
            };
            let greatest = self.split().root();
            greatest.forget_before(place);
            let Some(high) = greatest.first() else {
                return runs;
            };
            let truth = RobustnessBounds {
                low: low.value,
                high: high.value,
            };
            place = low.end.min(high.end);
            runs.push((place, truth.truth()));
        }
    }

    pub(in crate::formula) fn len(&self) -> usize {
        self.least.len() + self.greatest.as_ref().map_or(0, Program::len)
    }
}

/// Counts how often a formula becomes true: the stretches throughout which it is true, before which
/// it is known to be false or there is nothing. These are the intervals of holding, as in discrete
/// time, also if they have no first point.
#[derive(Debug, Clone)]
pub(in crate::formula) struct Counter {
    work: Bounded,
    place: i64,
    was_false: bool,
    count: u64,
    /// Whether the truth was unknown anywhere that was seen.
    doubtful: bool,
}

impl Counter {
    pub(in crate::formula) fn new(formula: &Positive) -> Self {
        Counter {
            work: Bounded::new(formula, false),
            place: 0,
            was_false: true,
            count: 0,
            doubtful: false,
        }
    }

    pub(in crate::formula) fn step(
        &mut self,
        place: i64,
        between: &[Between],
        atoms: &[RobustnessBounds],
    ) {
        self.work.step(place, between, atoms);
        self.count(true);
    }

    /// Whether the formula may have been true where that was not known.
    pub(in crate::formula) fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// The count as far as it is known.
    pub(in crate::formula) fn so_far(&self) -> u64 {
        self.count
    }

    /// Ends the trace and gives the count.
    pub(in crate::formula) fn close(&mut self, ending: Ending) -> u64 {
        self.work.close(ending);
        self.count(false);
        self.count
    }

    pub(in crate::formula) fn len(&self) -> usize {
        self.work.len()
    }

    /// Takes what has been found since; `seen` is false at the end, when what is unknown is so
    /// because it was not seen.
    fn count(&mut self, seen: bool) {
        loop {
            let least = self.work.least.root();
            least.forget_before(self.place);
            let Some(low) = least.first() else { return };
            let high = match &mut self.work.greatest {
                Some(greatest) => {
                    greatest.root().forget_before(self.place);
                    greatest.root().first()
                }
                None => Some(low),
            };
            let Some(high) = high else { return };
            let is_true = low.value > 0.0;
            self.doubtful |= seen && !is_true && high.value >= 0.0;
            self.count += u64::from(is_true && self.was_false);
            self.was_false = high.value < 0.0;
            self.place = low.end.min(high.end);
        }
    }
}
