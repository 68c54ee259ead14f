//! Predicates and quantities that are ready to be evaluated.

use super::bind::{Dimensions, amount, truth};
use super::error::PredicateError;
use super::eval::{Amount, Truth};
use super::lint::PredicateLint;
use super::responsible::{responsible, signals_of_amount, signals_of_truth};
use super::{Predicate, Quantity};
use crate::signal::{SignalIndex, SignalValues, Trace};
use crate::units::{Dimension, Unit};

/// A predicate whose signals have been found in a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundPredicate {
    truth: Truth,
    lints: Vec<PredicateLint>,
    /// The dimension of all its comparisons of numbers, if they have one in common.
    dimension: Option<Dimension>,
}

/// A quantity whose signals have been found in a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundQuantity {
    amount: Amount,
    unit: Option<Unit>,
    lints: Vec<PredicateLint>,
}

impl BoundPredicate {
    /// The truth now; `None` where it is unknown. The values (a [`Cursor`](crate::Cursor) or a
    /// [`Snapshot`](crate::Snapshot)) must be those of the trace that the predicate was bound to,
    /// or of one with the same channels and fields.
    #[must_use]
    pub fn eval<V: SignalValues + ?Sized>(&self, values: &V) -> Option<bool> {
        self.truth.eval(values)
    }

    /// How far the values are from changing the truth: positive where true, negative where false,
    /// 0 on the border, infinite where nothing but truth values and names decides; `None` where
    /// the truth is unknown. `a < b` has the robustness b - a in the coherent SI unit of the two,
    /// `&` the least and `|` the greatest of their sides; all of it is defined at
    /// [`Predicate`].
    #[must_use]
    pub fn robustness<V: SignalValues + ?Sized>(&self, values: &V) -> Option<f64> {
        self.truth.judge(values).map(|judged| judged.robustness)
    }

    /// The truth and the robustness together, for little more than the price of one.
    #[must_use]
    pub fn judge<V: SignalValues + ?Sized>(&self, values: &V) -> Option<(bool, f64)> {
        let judged = self.truth.judge(values)?;
        Some((judged.truth, judged.robustness))
    }

    /// The signals that make the predicate what it is now, in the order of the text: with their
    /// values alone it would have the same truth, whatever the others were. Of a conjunction that
    /// is false they are those of each side that is false, of a true one those of both sides; of a
    /// disjunction the other way round. None if the truth is unknown.
    ///
    /// ```
    /// use trace::{Field, Predicate, Snapshot, Trace};
    /// let mut layout = Trace::new();
    /// layout.add_channel("/robot", vec![Field::number("speed", "m/s"), Field::bool("ready")])?;
    /// let fine = Predicate::parse("/robot.speed < 250 mm/s & /robot.ready")?.bind(&layout)?;
    /// let mut now = Snapshot::new(&layout);
    /// now.update(0, 1.5, &[0.4, 1.0])?;
    /// assert_eq!(fine.eval(&now), Some(false));
    /// assert_eq!(fine.responsible(&now), [layout.signal("/robot.speed").expect("it is there")]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn responsible<V: SignalValues + ?Sized>(&self, values: &V) -> Vec<SignalIndex> {
        responsible(&self.truth, values)
    }

    /// All signals that are read, in the order of the text, each once: as long as none of them
    /// changes, neither does the predicate.
    #[must_use]
    pub fn signals(&self) -> Vec<SignalIndex> {
        let mut found = Vec::new();
        signals_of_truth(&self.truth, &mut found);
        found
    }

    /// What the robustness measures, in the coherent SI unit: the dimension of the comparisons of
    /// numbers; `None` if there are none, they differ, or their units are not known.
    #[must_use]
    pub fn robustness_dimension(&self) -> Option<Dimension> {
        self.dimension
    }

    /// What is allowed but rests on an assumption, for example numbers without a unit.
    #[must_use]
    pub fn lints(&self) -> &[PredicateLint] {
        &self.lints
    }
}

impl BoundQuantity {
    /// The value now, in the unit [`BoundQuantity::unit`]; `None` where it is missing. The values
    /// must be those of the trace that the quantity was bound to, or of one with the same channels
    /// and fields.
    #[must_use]
    pub fn eval<V: SignalValues + ?Sized>(&self, values: &V) -> Option<f64> {
        let value = self.amount.eval(values);
        (!value.is_nan()).then_some(value)
    }

    /// All signals that are read, in the order of the text, each once: as long as none of them
    /// changes, neither does the value.
    #[must_use]
    pub fn signals(&self) -> Vec<SignalIndex> {
        let mut found = Vec::new();
        signals_of_amount(&self.amount, &mut found);
        found
    }

    /// The unit of the value; `None` if it is not known, as for numbers without a unit.
    #[must_use]
    pub fn unit(&self) -> Option<&Unit> {
        self.unit.as_ref()
    }

    /// What is allowed but rests on an assumption, for example numbers without a unit.
    #[must_use]
    pub fn lints(&self) -> &[PredicateLint] {
        &self.lints
    }
}

impl Predicate {
    /// Looks the signals up in `trace`, which may still be empty but must have its channels, and
    /// checks types, units and frames. The result is meant for this trace and for those with the
    /// same channels.
    ///
    /// # Errors
    /// [`PredicateError`] if a signal or a value of an enumeration is not in the trace, or types,
    /// units or frames do not fit.
    pub fn bind(&self, trace: &Trace) -> Result<BoundPredicate, PredicateError> {
        let (truth, findings) = truth(&self.0, trace)?;
        Ok(BoundPredicate {
            truth,
            lints: findings.lints,
            dimension: match findings.dimensions {
                Dimensions::One(dimension) => Some(dimension),
                Dimensions::None | Dimensions::Several => None,
            },
        })
    }
}

impl Quantity {
    /// Looks the signals up in `trace` and checks types, units and frames, as [`Predicate::bind`]
    /// does.
    ///
    /// # Errors
    /// [`PredicateError`] if a signal or a value of an enumeration is not in the trace, or types,
    /// units or frames do not fit.
    pub fn bind(&self, trace: &Trace) -> Result<BoundQuantity, PredicateError> {
        let (operand, findings) = amount(&self.0, trace)?;
        Ok(BoundQuantity {
            unit: operand.scale.unit().cloned(),
            amount: operand.amount,
            lints: findings.lints,
        })
    }
}
