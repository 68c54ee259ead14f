//! Adaptive integration of a smooth function over an interval that is already cut at its bends.
//!
//! Each piece is integrated by the Gauss-Kronrod pair of 7 and 15 points, whose difference estimates its error. The piece with
//! the largest error is halved until the errors add up to no more than the tolerance. A piece whose halves have the same value
//! and no smaller error is at the rounding noise of the function: it is not halved again. At most [`MOST_HALVINGS`] are made.
//!
//! Source: R. Piessens and others, "QUADPACK" (1983), routines QAG and QK15, with its detection of roundoff. Deviation: a piece
//! at the noise is left alone where QAG gives up as a whole, so that one noisy piece does not spoil the others. The order of
//! operations is fixed, and with it every bit of the result. Cost: 15 evaluations for each piece, 30 for each halving: at most
//! 30,000 beyond the first pieces, whatever the function. Guarantee: the error estimate is usually pessimistic by several
//! digits for smooth functions; where a function is noisy, the result is as good as the noise allows.
//!
//! # Assumes
//! Nothing of the data. The function is smooth between the cuts.

/// Positive nodes of the 15-point Kronrod rule; every second one is also a Gauss node.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];

/// Kronrod weights of [`NODES`].
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];

/// Gauss weights of the odd entries of [`NODES`].
const GAUSS: [f64; 4] = [
    0.129_484_966_168_869_7,
    0.279_705_391_489_276_64,
    0.381_830_050_505_118_9,
    0.417_959_183_673_469_4,
];

/// Halvings allowed in one integral.
const MOST_HALVINGS: usize = 1_000;

/// Halves whose errors add up to more than this part of the whole's are not more accurate than it.
const NO_GAIN: f64 = 0.99;

/// Halves that differ from the whole by more than this part have seen something that the whole has not.
const SAME: f64 = 1e-5;

/// A part of the interval.
#[derive(Clone, Copy)]
struct Piece {
    low: f64,
    high: f64,
    value: f64,
    error: f64,
    /// Whether halving it may make it more accurate.
    improves: bool,
}

impl Piece {
    fn new(function: &impl Fn(f64) -> f64, low: f64, high: f64) -> Self {
        let (value, error) = gauss_kronrod(function, low, high);
        Self {
            low,
            high,
            value,
            error,
            improves: true,
        }
    }

    /// Both halves; `None` if there is no number between the ends.
    fn halves(&self, function: &impl Fn(f64) -> f64) -> Option<[Self; 2]> {
        let middle = 0.5 * (self.low + self.high);
        if middle <= self.low || middle >= self.high {
            return None;
        }
        let mut halves = [
            Self::new(function, self.low, middle),
            Self::new(function, middle, self.high),
        ];
        let [first, second] = &halves;
        let value = first.value + second.value;
        let is_new = (value - self.value).abs() > SAME * value.abs();
        let improves = is_new || first.error + second.error <= NO_GAIN * self.error;
        for half in &mut halves {
            half.improves = improves;
        }
        Some(halves)
    }
}

/// The integral of `function` over the consecutive pieces between the sorted `cuts`, to about
/// `tolerance` in absolute terms.
pub(crate) fn integrate_over_pieces(
    function: &impl Fn(f64) -> f64,
    cuts: &[f64],
    tolerance: f64,
) -> f64 {
    let ends = cuts.windows(2).filter(|ends| ends[1] > ends[0]);
    let mut pieces: Vec<Piece> = ends
        .map(|ends| Piece::new(function, ends[0], ends[1]))
        .collect();
    for _ in 0..MOST_HALVINGS {
        let Some(worst) = to_halve(&pieces, tolerance) else {
            break;
        };
        match pieces[worst].halves(function) {
            Some([first, second]) => {
                pieces[worst] = first;
                pieces.push(second);
            }
            None => pieces[worst].improves = false,
        }
    }
    pieces.sort_by(|a, b| a.low.total_cmp(&b.low));
    pieces.iter().map(|piece| piece.value).sum()
}

/// The piece with the largest error, if the errors of those that halving improves exceed the tolerance.
fn to_halve(pieces: &[Piece], tolerance: f64) -> Option<usize> {
    let improving = pieces.iter().enumerate().filter(|(_, it)| it.improves);
    let (mut sum, mut worst, mut largest) = (0.0, None, f64::NEG_INFINITY);
    for (place, piece) in improving {
        sum += piece.error;
        if piece.error > largest {
            (worst, largest) = (Some(place), piece.error);
        }
    }
    worst.filter(|_| sum > tolerance)
}

/// The Kronrod value alone.
pub(crate) fn kronrod(function: &impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let pairs = NODES.iter().zip(KRONROD).take(7).map(|(node, weight)| {
        weight * (function(centre - half * node) + function(centre + half * node))
    });
    half * (pairs.sum::<f64>() + KRONROD[7] * function(centre))
}

/// The Kronrod rule's places between two ends, with their weights.
pub(crate) fn kronrod_places(low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let both = move |(node, weight): (&f64, &f64)| {
        [
            (centre - half * node, half * weight),
            (centre + half * node, half * weight),
        ]
    };
    let outer = NODES[..7].iter().zip(&KRONROD).flat_map(both);
    outer.chain([(centre, half * KRONROD[7])])
}

/// The Kronrod value and the error estimate of QUADPACK, `(200 |K - G| / scale)^1.5 scale`.
fn gauss_kronrod(function: &impl Fn(f64) -> f64, low: f64, high: f64) -> (f64, f64) {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let middle = function(centre);
    let mut kronrod = KRONROD[7] * middle;
    let mut gauss = GAUSS[3] * middle;
    for index in 0..7 {
        let offset = half * NODES[index];
        let pair = function(centre - offset) + function(centre + offset);
        kronrod += KRONROD[index] * pair;
        if index % 2 == 1 {
            gauss += GAUSS[index / 2] * pair;
        }
    }
    let difference = ((kronrod - gauss) * half).abs();
    let value = kronrod * half;
    let scale = value.abs();
    if scale == 0.0 {
        return (value, difference);
    }
    let relative = (200.0 * difference / scale).powf(1.5).min(1.0);
    (value, (scale * relative).max(difference * f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_22_are_exact() {
        let (value, _) = gauss_kronrod(&|x: f64| x.powi(22), 0.0, 1.0);
        assert!((value - 1.0 / 23.0).abs() < 1e-16, "{value:e}");
        let weights: f64 = 2.0 * KRONROD[..7].iter().sum::<f64>() + KRONROD[7];
        assert!((weights - 2.0).abs() < 1e-15);
        let weights: f64 = 2.0 * GAUSS[..3].iter().sum::<f64>() + GAUSS[3];
        assert!((weights - 2.0).abs() < 1e-15);
    }

    /// A function whose values are off by a hash of the place, far more than the tolerance.
    #[test]
    fn a_noisy_function_ends_within_its_budget_and_near_the_integral() {
        let evaluations = std::cell::Cell::new(0_u32);
        let noisy = |x: f64| {
            evaluations.set(evaluations.get() + 1);
            let hash = x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            x.exp() * (1.0 + 1e-9 * (hash as f64 / f64::from(1 << 24) - 0.5))
        };
        let value = integrate_over_pieces(&noisy, &[0.0, 0.1, 0.5, 1.0], 1e-13);
        let exact = std::f64::consts::E - 1.0;
        assert!((value - exact).abs() < 1e-9, "{:e}", value - exact);
        // Three pieces, and few halvings: the noise is seen, the budget is not used up.
        assert!(evaluations.get() < 3_000, "{}", evaluations.get());
    }

    /// Nothing is gained for long at a pole, whose integral is infinite.
    #[test]
    fn no_function_takes_more_than_the_budget() {
        let evaluations = std::cell::Cell::new(0_u32);
        let pole = |x: f64| {
            evaluations.set(evaluations.get() + 1);
            1.0 / x
        };
        integrate_over_pieces(&pole, &[0.0, 1.0], 1e-13);
        assert!(evaluations.get() <= 30_015, "{}", evaluations.get());
    }

    #[test]
    fn a_narrow_peak_is_found_by_halving() {
        let peak = |x: f64| 1e4 / (1.0 + (1e4 * (x - 0.3)).powi(2));
        let exact = (7e3_f64).atan() + (3e3_f64).atan();
        let value = integrate_over_pieces(&peak, &[0.0, 0.3, 1.0], 1e-12);
        assert!((value - exact).abs() < 1e-10, "{}", value - exact);
    }
}
