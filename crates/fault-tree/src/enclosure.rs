//! Numbers that are certain: intervals of doubles that hold a real number, rounded outwards.
//!
//! Source: R. E. Moore, *Interval Analysis*, 1966. IEEE 754 rounds the sum and the product of two doubles to the nearest
//! double, so the real result lies between the neighbours of the rounded one. Each operation here goes to those neighbours:
//! a unit in the last place wider than needed, and independent of the processor's rounding mode. Only sums and products are
//! used, also by [`Enclosure::one_minus_exp`], so that no library's exponential function is believed.

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

/// An interval that holds a real number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// At most the number.
    pub lower: f64,
    /// At least the number.
    pub upper: f64,
}

/// The double below, unless it is exact anyway.
pub(crate) fn down(value: f64) -> f64 {
    value.next_down()
}

/// The double above.
pub(crate) fn up(value: f64) -> f64 {
    value.next_up()
}

/// Products and sums with 0 and products with 1 are exact; only they keep 0 and 1 what they are.
fn product_down(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, _) | (_, 0.0) => 0.0,
        (1.0, x) | (x, 1.0) => x,
        _ => down(a * b).max(0.0),
    }
}

fn product_up(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, _) | (_, 0.0) => 0.0,
        (1.0, x) | (x, 1.0) => x,
        _ => up(a * b),
    }
}

fn sum_down(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, x) | (x, 0.0) => x,
        _ => down(a + b),
    }
}

fn sum_up(a: f64, b: f64) -> f64 {
    match (a, b) {
        (0.0, x) | (x, 0.0) => x,
        _ => up(a + b),
    }
}

impl Enclosure {
    /// The double itself.
    pub fn point(value: f64) -> Self {
        Self {
            lower: value,
            upper: value,
        }
    }

    /// The two doubles next to a rational number, or the double that it is.
    pub fn of(value: &BigRational) -> Self {
        let near = value.to_f64().unwrap_or(f64::NAN);
        let (mut lower, mut upper) = (near, near);
        // The conversion is near, and not trusted to be nearest.
        while is_above(lower, value) {
            lower = down(lower);
        }
        while is_below(upper, value) {
            upper = up(upper);
        }
        Self { lower, upper }
    }

    /// Whether it is one number.
    pub fn is_point(&self) -> bool {
        self.lower == self.upper
    }

    /// How far apart its ends are.
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }

    /// Whether the number is in it.
    pub fn contains(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// The part of it that a probability can be.
    pub(crate) fn clamped(self) -> Self {
        Self {
            lower: self.lower.clamp(0.0, 1.0),
            upper: self.upper.clamp(0.0, 1.0),
        }
    }

    /// `self - other`.
    pub(crate) fn minus(self, other: Self) -> Self {
        Self {
            lower: sum_down(self.lower, -other.upper),
            upper: sum_up(self.upper, -other.lower),
        }
    }

    /// The product of two numbers that are not negative.
    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            lower: product_down(self.lower, other.lower),
            upper: product_up(self.upper, other.upper),
        }
    }

    /// `self / other` for numbers that are not negative; infinite above if `other` may be 0.
    pub(crate) fn over(self, other: Self) -> Self {
        let lower = match self.lower {
            0.0 => 0.0,
            lower => down(lower / other.upper).max(0.0),
        };
        let upper = match (self.upper, other.lower) {
            (0.0, below) if below > 0.0 => 0.0,
            (_, below) if below <= 0.0 => f64::INFINITY,
            (above, below) => up(above / below),
        };
        Self { lower, upper }
    }

    /// `p * high + (1 - p) * low` for every `p` in `self`, `high` and `low` in theirs, all in \[0, 1\]. It is linear in `p`,
    /// so its extremes are at the ends of `p`.
    pub(crate) fn mix(self, high: Self, low: Self) -> Self {
        let below = |p: f64| {
            let rest = if p == 0.0 || p == 1.0 {
                1.0 - p
            } else {
                down(1.0 - p)
            };
            sum_down(product_down(p, high.lower), product_down(rest, low.lower))
        };
        let above = |p: f64| {
            let rest = if p == 0.0 || p == 1.0 {
                1.0 - p
            } else {
                up(1.0 - p)
            };
            sum_up(product_up(p, high.upper), product_up(rest, low.upper))
        };
        let (mut lower, mut upper) = (below(self.lower), above(self.upper));
        if !self.is_point() {
            lower = lower.min(below(self.upper));
            upper = upper.max(above(self.lower));
        }
        Self { lower, upper }.clamped()
    }

    /// `1 - exp(-x)` for every `x >= 0` in `self`.
    ///
    /// `x` is halved until it is at most 1/4. There the series `y - y^2/2 + y^3/6 - ...` alternates with falling terms, so
    /// its value lies between two partial sums. `1 - exp(-2y) = u (2 - u)` with `u = 1 - exp(-y)` leads back.
    pub fn one_minus_exp(self) -> Self {
        let lower = one_minus_exp(self.lower).lower;
        let upper = one_minus_exp(self.upper).upper;
        Self { lower, upper }.clamped()
    }
}

fn one_minus_exp(x: f64) -> Enclosure {
    if x <= 0.0 {
        return Enclosure::point(0.0);
    }
    // exp(-64) is below the distance of 1 to the next double.
    if x > 64.0 {
        return Enclosure {
            lower: down(1.0),
            upper: 1.0,
        };
    }
    let (mut y, mut halvings) = (x, 0);
    while y > 0.25 {
        y /= 2.0;
        halvings += 1;
    }
    let mut value = series(y);
    for _ in 0..halvings {
        let rest = |u: f64, outward: fn(f64) -> f64| outward(2.0 - u);
        value = Enclosure {
            lower: product_down(value.lower, rest(value.lower, down)),
            upper: product_up(value.upper, rest(value.upper, up)),
        }
        .clamped();
    }
    value
}

/// `1 - exp(-y)` for `0 < y <= 1/4`: `y * (1 - y/2 * (1 - y/3 * (...)))`, cut off where the factor is between 0 and 1.
fn series(y: f64) -> Enclosure {
    let mut factor = Enclosure {
        lower: 0.0,
        upper: 1.0,
    };
    for n in (2..=16).rev() {
        let divisor = f64::from(n);
        let share = Enclosure {
            lower: down(y / divisor).max(0.0),
            upper: up(y / divisor),
        };
        factor = Enclosure::point(1.0).minus(share.times(factor));
    }
    Enclosure::point(y).times(factor)
}

fn is_above(double: f64, value: &BigRational) -> bool {
    exact(double).is_some_and(|it| it > *value)
}

fn is_below(double: f64, value: &BigRational) -> bool {
    exact(double).is_some_and(|it| it < *value)
}

/// The rational number that a finite double is.
pub(crate) fn exact(double: f64) -> Option<BigRational> {
    if double == 0.0 {
        return Some(BigRational::zero());
    }
    BigRational::from_float(double)
}
