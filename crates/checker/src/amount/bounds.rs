//! Intervals that contain the number, in spite of rounding.
//!
//! Each operation is rounded outwards by one number of floating point, which is more than its error of half a
//! unit (IEEE 754). Interval arithmetic as in Moore 1966. Undefined is an interval of not-a-numbers.

use std::cmp::Ordering;

use prism_lang::{Number, Rational};

use super::Amount;
use crate::answer::AnswerValue;
use crate::rounding::{Bounds, UNIT};

const UNDEFINED: Bounds = Bounds::exactly(f64::NAN);

/// Rounds outwards; exact zeros and infinities stay.
fn outwards(low: f64, high: f64) -> Bounds {
    if low.is_nan() || high.is_nan() {
        return UNDEFINED;
    }
    let down = |x: f64| if x == 0.0 { x } else { x.next_down() };
    let up = |x: f64| if x == 0.0 { x } else { x.next_up() };
    Bounds {
        low: if low.is_infinite() { low } else { down(low) },
        high: if high.is_infinite() { high } else { up(high) },
    }
}

/// The hull of results of an operation at the corners; `undefined` if one is.
fn hull(corners: [f64; 4], exact: bool) -> Bounds {
    if corners.iter().any(|corner| corner.is_nan()) {
        return UNDEFINED;
    }
    let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match exact {
        true => Bounds { low, high },
        false => {
            // A product of numbers that are not 0 may have underflowed to 0.
            let bounds = outwards(low, high);
            Bounds {
                low: if low == 0.0 && high == 0.0 {
                    -f64::MIN_POSITIVE
                } else {
                    bounds.low
                },
                high: if high == 0.0 {
                    f64::MIN_POSITIVE
                } else {
                    bounds.high
                },
            }
        }
    }
}

impl Amount for Bounds {
    type Entry = f64;

    fn literal(number: &Number) -> Self {
        let nearest = number.to_f64();
        let is_nearest = Rational::from_float(nearest)
            .is_some_and(|exact| number.exact().is_some_and(|number| *number == exact));
        match is_nearest {
            true => Self::exactly(nearest),
            false => outwards(nearest, nearest),
        }
    }

    fn entry(entry: &f64, relative_error: f64) -> Self {
        if relative_error == 0.0 || *entry == 0.0 {
            return Self::exactly(*entry);
        }
        outwards(
            entry * (1.0 - relative_error),
            entry * (1.0 + relative_error),
        )
    }

    fn infinity() -> Self {
        Self::exactly(f64::INFINITY)
    }

    fn undefined() -> Self {
        UNDEFINED
    }

    fn add(&self, other: &Self) -> Self {
        if *self == Self::ZERO {
            return *other;
        }
        if *other == Self::ZERO {
            return *self;
        }
        let (low, high) = (self.low + other.low, self.high + other.high);
        // Small integers add exactly.
        let small = |x: &Self| x.is_exact() && x.low.fract() == 0.0 && x.low.abs() < 1e15;
        if small(self) && small(other) {
            return Self { low, high };
        }
        outwards(low, high)
    }

    fn sub(&self, other: &Self) -> Self {
        // Not `-x`: the opposite of 0 would be printed with a sign.
        self.add(&Self {
            low: 0.0 - other.high,
            high: 0.0 - other.low,
        })
    }

    fn mul(&self, other: &Self) -> Self {
        if *self == Self::ONE {
            return *other;
        }
        if *other == Self::ONE {
            return *self;
        }
        let is_zero = |x: &Self| *x == Self::ZERO;
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        let small = |x: &Self| x.is_exact() && x.low.fract() == 0.0 && x.low.abs() < 9e7;
        hull(
            products,
            is_zero(self) || is_zero(other) || (small(self) && small(other)),
        )
    }

    fn div(&self, other: &Self) -> Self {
        if *other == Self::ONE {
            return *self;
        }
        // By a number that may be 0, anything is possible; by 0 itself, an infinity or nothing.
        if other.low <= 0.0 && other.high >= 0.0 && *other != Self::ZERO {
            return Self {
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
            };
        }
        let quotients = [
            self.low / other.low,
            self.low / other.high,
            self.high / other.low,
            self.high / other.high,
        ];
        hull(quotients, *self == Self::ZERO)
    }

    fn pow(&self, exponent: &Self) -> Option<Self> {
        if self.is_exact() && exponent.is_exact() {
            let value = self.low.powf(exponent.low);
            let is_integer = value.fract() == 0.0 && value.abs() < 9e15;
            let integers = self.low.fract() == 0.0 && exponent.low.fract() == 0.0;
            return Some(match is_integer && integers && exponent.low >= 0.0 {
                true => Self::exactly(value),
                false => wide(value),
            });
        }
        if self.low < 0.0 {
            return None;
        }
        let [a, b] = [self.low, self.high];
        let [c, d] = [exponent.low, exponent.high];
        let corners = [a.powf(c), a.powf(d), b.powf(c), b.powf(d)].map(wide);
        Some(join(corners))
    }

    fn log(&self, base: &Self) -> Option<Self> {
        if self.low <= 0.0 || base.low <= 0.0 || (base.low <= 1.0 && base.high >= 1.0) {
            return (self.is_exact() && base.is_exact())
                .then(|| wide(self.low.ln() / base.low.ln()));
        }
        let corner = |x: f64, b: f64| wide(x.ln() / b.ln());
        Some(join([
            corner(self.low, base.low),
            corner(self.low, base.high),
            corner(self.high, base.low),
            corner(self.high, base.high),
        ]))
    }

    fn floor(&self) -> Option<Self> {
        let (low, high) = (self.low.floor(), self.high.floor());
        (low == high || low.is_nan()).then_some(Self { low, high })
    }

    fn least(&self, other: &Self) -> Self {
        if self.is_undefined() || other.is_undefined() {
            return UNDEFINED;
        }
        Self {
            low: self.low.min(other.low),
            high: self.high.min(other.high),
        }
    }

    fn greatest(&self, other: &Self) -> Self {
        if self.is_undefined() || other.is_undefined() {
            return UNDEFINED;
        }
        Self {
            low: self.low.max(other.low),
            high: self.high.max(other.high),
        }
    }

    fn compare(&self, other: &Self) -> Option<Ordering> {
        if self.high < other.low {
            Some(Ordering::Less)
        } else if self.low > other.high {
            Some(Ordering::Greater)
        } else if self.is_exact() && other.is_exact() && self.low == other.low {
            Some(Ordering::Equal)
        } else {
            None
        }
    }

    fn is_undefined(&self) -> bool {
        self.low.is_nan()
    }

    /// Sums are rounded to nearest and then widened by more than their error, which for `n` terms is at most
    /// `n u` times the sum of the terms' magnitudes (Higham 2002, section 3.1).
    fn mean<'a>(
        reward: Option<&Self>,
        transitions: impl Iterator<Item = (&'a f64, &'a Self)>,
        entry_error: f64,
    ) -> Self {
        let start = reward.copied().unwrap_or(Self::ZERO);
        let (mut low, mut high) = (start.low, start.high);
        let mut magnitude = low.abs().max(high.abs());
        let mut terms = 1;
        for (p, value) in transitions {
            low += p * value.low;
            high += p * value.high;
            magnitude += p * value.low.abs().max(value.high.abs());
            terms += 1;
        }
        if magnitude == 0.0 || magnitude.is_infinite() || magnitude.is_nan() {
            return Self { low, high };
        }
        let margin = magnitude * 2.0 * (entry_error + f64::from(terms + 2) * UNIT)
            + f64::from(terms) * f64::MIN_POSITIVE;
        Self {
            low: if low >= 0.0 {
                (low - margin).max(0.0)
            } else {
                low - margin
            },
            high: high + margin,
        }
    }

    fn bounds(&self) -> Bounds {
        *self
    }

    fn answer(&self) -> AnswerValue {
        AnswerValue::Number(self.middle())
    }
}

/// Functions of the mathematical library are taken to be off by at most four units in the last place.
fn wide(value: f64) -> Bounds {
    if value.is_nan() || value.is_infinite() {
        return Bounds::exactly(value);
    }
    let margin = value.abs() * 8.0 * UNIT + f64::MIN_POSITIVE;
    Bounds {
        low: value - margin,
        high: value + margin,
    }
}

fn join(corners: [Bounds; 4]) -> Bounds {
    let mut all = corners[0];
    for corner in corners {
        if corner.is_undefined() {
            return UNDEFINED;
        }
        all.low = all.low.min(corner.low);
        all.high = all.high.max(corner.high);
    }
    all
}
