//! Numbers that a method computes: with what is known of them.

use std::cmp::Ordering;
use std::fmt::Debug;

use num_traits::{One, Zero};
use prism_lang::{Arithmetic, Number, Rational};

use crate::answer::AnswerValue;
use crate::rounding::Bounds;

mod bounds;
mod extended;
mod plain;

pub(crate) use extended::Extended;

/// A real number, infinite or undefined, as a method knows it.
pub(crate) trait Amount: Clone + PartialEq + Debug {
    /// Transition probabilities, rates and rewards of the model.
    type Entry: Arithmetic;

    /// A number of a property.
    fn literal(number: &Number) -> Self;
    /// A number of the model, not negative, that is off by at most this relatively.
    fn entry(entry: &Self::Entry, relative_error: f64) -> Self;
    /// Greater than all numbers.
    fn infinity() -> Self;
    /// Not a number: infinity less infinity, 0 / 0.
    fn undefined() -> Self;
    fn add(&self, other: &Self) -> Self;
    fn sub(&self, other: &Self) -> Self;
    fn mul(&self, other: &Self) -> Self;
    fn div(&self, other: &Self) -> Self;
    /// A power; undefined where it is not real, `None` where the domain has no such number.
    fn pow(&self, exponent: &Self) -> Option<Self>;
    /// A logarithm, likewise.
    fn log(&self, base: &Self) -> Option<Self>;
    /// The largest integer not above; `None` if it is not known.
    fn floor(&self) -> Option<Self>;
    /// The lesser.
    fn least(&self, other: &Self) -> Self;
    /// The greater.
    fn greatest(&self, other: &Self) -> Self;
    /// How they compare; `None` if that is not known (or one is undefined).
    fn compare(&self, other: &Self) -> Option<Ordering>;
    /// Whether they surely are the same number, or the same infinity.
    fn is_undefined(&self) -> bool;
    /// `reward` plus the mean over transitions, whose probabilities are off by at most this relatively.
    fn mean<'a>(
        reward: Option<&Self>,
        transitions: impl Iterator<Item = (&'a Self::Entry, &'a Self)>,
        entry_error: f64,
    ) -> Self
    where
        Self: 'a;
    /// What is known.
    fn bounds(&self) -> Bounds;
    /// As an answer.
    fn answer(&self) -> AnswerValue;

    fn zero() -> Self {
        Self::literal(&Number::from_rational(<Rational as Zero>::zero()))
    }

    fn one() -> Self {
        Self::literal(&Number::from_rational(<Rational as One>::one()))
    }

    fn negative(&self) -> Self {
        Self::zero().sub(self)
    }

    /// Not more than 1: what rounding adds to a probability is taken off.
    fn at_most_one(&self) -> Self {
        self.least(&Self::one())
    }

    /// The one that a scheduler prefers.
    fn best(&self, other: &Self, maximise: bool) -> Self {
        match maximise {
            true => self.greatest(other),
            false => self.least(other),
        }
    }

    /// Whether this is better than the other, as far as is known or guessed.
    fn beats(&self, other: &Self, maximise: bool) -> bool {
        let (this, that) = (self.bounds(), other.bounds());
        match maximise {
            true => this.low > that.low,
            false => this.low < that.low,
        }
    }
}
