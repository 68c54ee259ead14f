//! The tree of a formula.

use super::settings::{CompileError, TimeModel};
use crate::clock::rounded;

/// An atom: a position in the list of the atoms of a text ([`Parsed::atoms`](super::Parsed::atoms)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AtomId(pub usize);

/// A formula of temporal logic over atoms; what it means is defined in [`super::semantics`].
#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
    /// Holds everywhere.
    True,
    /// Holds nowhere.
    False,
    /// A statement about the signals at one time.
    Atom(AtomId),
    /// Negation.
    Not(Box<Formula>),
    /// Conjunction; without operands it is true.
    And(Vec<Formula>),
    /// Disjunction; without operands it is false.
    Or(Vec<Formula>),
    /// Implication.
    Implies(Box<Formula>, Box<Formula>),
    /// Equivalence.
    Iff(Box<Formula>, Box<Formula>),
    /// At the next sample, and there is one (discrete time only).
    Next(Box<Formula>),
    /// At the sample before, and there is one (discrete time only).
    Previous(Box<Formula>),
    /// Somewhere in a window of the future.
    Eventually(Interval, Box<Formula>),
    /// Everywhere in a window of the future.
    Always(Interval, Box<Formula>),
    /// The right somewhere in a window of the future, and the left at all times before it.
    Until(Interval, Box<Formula>, Box<Formula>),
    /// `left W right = right R (left | right)`: until, where the right need not come.
    WeakUntil(Interval, Box<Formula>, Box<Formula>),
    /// Dual of until: the right throughout a window, except after the left has been true.
    Release(Interval, Box<Formula>, Box<Formula>),
    /// Somewhere in a window of the past.
    Once(Interval, Box<Formula>),
    /// Everywhere in a window of the past.
    Historically(Interval, Box<Formula>),
    /// The right somewhere in a window of the past, and the left at all times since.
    Since(Interval, Box<Formula>, Box<Formula>),
    /// Becomes true: true here and false just before. At the first sample, it is the operand.
    Rise(Box<Formula>),
    /// Becomes false: `fall(f) = rise(!f)`, thus also at a first sample where `f` is false.
    Fall(Box<Formula>),
}

/// The distances in time at which an operator looks, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The least distance.
    pub low: Bound,
    /// The greatest distance; `None` if there is none.
    pub high: Option<Bound>,
}

/// One end of an [`Interval`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The number, in the unit.
    pub value: f64,
    /// What the number counts.
    pub unit: TimeUnit,
}

/// What the number in a [`Bound`] counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    Seconds,
    /// Samples (discrete time only).
    Samples,
    /// It was not said: samples in discrete time, seconds in dense time.
    Unstated,
}

/// An [`Interval`] whose units are settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Window {
    /// By time; `high_secs` may be infinite.
    Seconds {
        /// The least distance in seconds.
        low_secs: f64,
        /// The greatest distance in seconds, or infinity.
        high_secs: f64,
    },
    /// By number of samples.
    Samples {
        /// The least distance in samples.
        low: u64,
        /// The greatest distance in samples; `None` if there is none.
        high: Option<u64>,
    },
}

impl Window {
    /// The same with ends in seconds rounded to multiples of a resolution.
    pub(super) fn with_resolution(self, resolution_nanos: i64) -> Self {
        // Not more than MAX_BOUND seconds, so the nanoseconds fit.
        let coarser = |secs: f64| {
            if secs.is_finite() {
                rounded((secs * 1e9).round() as i64, resolution_nanos) as f64 / 1e9
            } else {
                secs
            }
        };
        match self {
            Window::Seconds {
                low_secs,
                high_secs,
            } => Window::Seconds {
                low_secs: coarser(low_secs),
                high_secs: coarser(high_secs),
            },
            samples @ Window::Samples { .. } => samples,
        }
    }
}

/// The longest bound of an interval: a thousand million seconds (32 years), or samples.
pub const MAX_BOUND: f64 = 1e9;

impl Bound {
    /// A bound in seconds.
    #[must_use]
    pub const fn secs(value: f64) -> Self {
        Bound {
            value,
            unit: TimeUnit::Seconds,
        }
    }

    /// A bound in samples.
    #[must_use]
    pub fn samples(value: u32) -> Self {
        Bound {
            value: f64::from(value),
            unit: TimeUnit::Samples,
        }
    }
}

impl Interval {
    /// All distances.
    pub const UNBOUNDED: Self = Interval {
        low: Bound {
            value: 0.0,
            unit: TimeUnit::Unstated,
        },
        high: None,
    };

    /// From `low` to `high` seconds.
    #[must_use]
    pub const fn secs(low: f64, high: f64) -> Self {
        Interval {
            low: Bound::secs(low),
            high: Some(Bound::secs(high)),
        }
    }

    /// From `low` to `high` samples.
    #[must_use]
    pub fn samples(low: u32, high: u32) -> Self {
        Interval {
            low: Bound::samples(low),
            high: Some(Bound::samples(high)),
        }
    }

    /// Whether all distances are in it.
    #[must_use]
    pub fn is_unbounded(&self) -> bool {
        self.low.value == 0.0 && self.high.is_none()
    }

    /// Settles the units. A bound whose unit is not stated takes that of the other one, if that
    /// is stated.
    ///
    /// # Errors
    /// [`CompileError`] if a bound is not a number from 0 to [`MAX_BOUND`], a number of samples is
    /// not whole, the ends are the wrong way round or in different units, or samples are counted
    /// in dense time.
    pub fn window(&self, time: TimeModel) -> Result<Window, CompileError> {
        let bounds = [Some(self.low), self.high];
        if let Some(bad) =
            (bounds.iter().flatten()).find(|bound| !(0.0..=MAX_BOUND).contains(&bound.value))
        {
            return Err(CompileError::BadBound { value: bad.value });
        }
        if self.high.is_some_and(|high| {
            (high.unit == self.low.unit || self.low.unit == TimeUnit::Unstated)
                && high.value < self.low.value
        }) {
            return Err(CompileError::EmptyInterval {
                interval: self.to_string(),
            });
        }
        let stated = |unit: TimeUnit| {
            bounds
                .iter()
                .flatten()
                .any(|bound| bound.unit == unit && bound.value != 0.0)
        };
        let any = |unit: TimeUnit| bounds.iter().flatten().any(|bound| bound.unit == unit);
        let by_samples = match (stated(TimeUnit::Seconds), stated(TimeUnit::Samples)) {
            (true, true) => {
                return Err(CompileError::MixedUnits {
                    interval: self.to_string(),
                });
            }
            (true, false) => false,
            (false, true) => true,
            // Only zeros and bounds without a unit.
            (false, false) if any(TimeUnit::Seconds) => false,
            (false, false) => any(TimeUnit::Samples) || time == TimeModel::Discrete,
        };
        if by_samples {
            self.in_samples(time)
        } else {
            Ok(self.in_secs())
        }
    }

    fn in_secs(&self) -> Window {
        Window::Seconds {
            low_secs: self.low.value,
            high_secs: self.high.map_or(f64::INFINITY, |high| high.value),
        }
    }

    fn in_samples(&self, time: TimeModel) -> Result<Window, CompileError> {
        if time == TimeModel::Dense {
            return Err(CompileError::SamplesInDenseTime {
                what: format!("the interval {self}"),
            });
        }
        let whole = |bound: Bound| {
            if bound.value.fract() == 0.0 {
                // Not negative and at most MAX_BOUND, as was checked.
                Ok(bound.value as u64)
            } else {
                Err(CompileError::FractionOfSample { value: bound.value })
            }
        };
        Ok(Window::Samples {
            low: whole(self.low)?,
            high: self.high.map(whole).transpose()?,
        })
    }
}

/// Constructors; those of temporal operators take the window first.
impl Formula {
    /// The atom with this number.
    #[must_use]
    pub const fn atom(index: usize) -> Self {
        Formula::Atom(AtomId(index))
    }

    /// `!inner`.
    #[must_use]
    #[allow(
        clippy::should_implement_trait,
        reason = "the operator's name in logic"
    )]
    pub fn not(inner: Formula) -> Self {
        Formula::Not(Box::new(inner))
    }

    /// `left & right`.
    #[must_use]
    pub fn and(left: Formula, right: Formula) -> Self {
        Formula::And(vec![left, right])
    }

    /// `left | right`.
    #[must_use]
    pub fn or(left: Formula, right: Formula) -> Self {
        Formula::Or(vec![left, right])
    }

    /// `left => right`.
    #[must_use]
    pub fn implies(left: Formula, right: Formula) -> Self {
        Formula::Implies(Box::new(left), Box::new(right))
    }

    /// `eventually interval inner`.
    #[must_use]
    pub fn eventually(interval: Interval, inner: Formula) -> Self {
        Formula::Eventually(interval, Box::new(inner))
    }

    /// `always interval inner`.
    #[must_use]
    pub fn always(interval: Interval, inner: Formula) -> Self {
        Formula::Always(interval, Box::new(inner))
    }

    /// `left until interval right`.
    #[must_use]
    pub fn until(interval: Interval, left: Formula, right: Formula) -> Self {
        Formula::Until(interval, Box::new(left), Box::new(right))
    }

    /// `rise(inner)`.
    #[must_use]
    pub fn rise(inner: Formula) -> Self {
        Formula::Rise(Box::new(inner))
    }

    /// The operands, from left to right.
    #[must_use]
    pub fn operands(&self) -> Vec<&Formula> {
        match self {
            Formula::True | Formula::False | Formula::Atom(_) => Vec::new(),
            Formula::And(operands) | Formula::Or(operands) => operands.iter().collect(),
            Formula::Not(inner)
            | Formula::Next(inner)
            | Formula::Previous(inner)
            | Formula::Rise(inner)
            | Formula::Fall(inner)
            | Formula::Eventually(_, inner)
            | Formula::Always(_, inner)
            | Formula::Once(_, inner)
            | Formula::Historically(_, inner) => vec![inner],
            Formula::Implies(left, right)
            | Formula::Iff(left, right)
            | Formula::Until(_, left, right)
            | Formula::WeakUntil(_, left, right)
            | Formula::Release(_, left, right)
            | Formula::Since(_, left, right) => vec![left, right],
        }
    }

    /// The window of the outermost operator, if it has one.
    #[must_use]
    pub fn interval(&self) -> Option<Interval> {
        match self {
            Formula::Eventually(interval, _)
            | Formula::Always(interval, _)
            | Formula::Once(interval, _)
            | Formula::Historically(interval, _)
            | Formula::Until(interval, ..)
            | Formula::WeakUntil(interval, ..)
            | Formula::Release(interval, ..)
            | Formula::Since(interval, ..) => Some(*interval),
            _ => None,
        }
    }

    /// One more than the largest number of an atom, 0 when there is none.
    #[must_use]
    pub fn atom_count(&self) -> usize {
        match self {
            Formula::Atom(atom) => atom.0.saturating_add(1),
            _ => (self.operands().into_iter())
                .map(Formula::atom_count)
                .max()
                .unwrap_or(0),
        }
    }

    /// Number of operators, constants and atoms.
    #[must_use]
    pub fn size(&self) -> usize {
        1 + self
            .operands()
            .into_iter()
            .map(Formula::size)
            .sum::<usize>()
    }

    /// Windows that are one instant so many seconds away, as in `eventually[2 s, 2 s] p`, in the order
    /// of the text. In discrete time they ask for a sample at just that time: where there is none,
    /// `eventually` and its like are false and `always` and its like true, whatever the signals did.
    #[must_use]
    pub fn exact_instants(&self) -> Vec<Interval> {
        let is_instant = |interval: &Interval| {
            matches!(interval.window(TimeModel::Discrete),
                Ok(Window::Seconds { low_secs, high_secs }) if low_secs == high_secs && low_secs > 0.0)
        };
        let own = self.interval().filter(is_instant);
        let inner = self.operands().into_iter();
        own.into_iter()
            .chain(inner.flat_map(Formula::exact_instants))
            .collect()
    }

    /// Whether its truth at a time depends on that time alone.
    #[must_use]
    pub fn is_propositional(&self) -> bool {
        let own = matches!(
            self,
            Formula::True
                | Formula::False
                | Formula::Atom(_)
                | Formula::Not(_)
                | Formula::And(_)
                | Formula::Or(_)
                | Formula::Implies(..)
                | Formula::Iff(..)
        );
        own && self.operands().into_iter().all(Formula::is_propositional)
    }

    /// What the requirement waits for, if it has the form of a response: of `always (a => b)` it is
    /// `a`; of `always (a & b => c)`, `a & b`; of a conjunction of such with the same `a`, that `a`;
    /// of `always[..] always[..] (a => b)`, too, `a`. Other formulas have none.
    #[must_use]
    pub fn trigger(&self) -> Option<&Formula> {
        match self {
            Formula::Always(_, body) => match body.as_ref() {
                Formula::Implies(left, _) => Some(left),
                inner @ (Formula::Always(..) | Formula::And(_)) => inner.trigger(),
                _ => None,
            },
            Formula::And(operands) => {
                let mut triggers = operands.iter().map(Formula::trigger);
                let first = triggers.next()??;
                triggers.all(|other| other == Some(first)).then_some(first)
            }
            _ => None,
        }
    }
}
