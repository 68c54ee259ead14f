//! Adaptive integration of a smooth function over an interval that is already cut at its bends.
//!
//! Each piece is integrated by the Gauss-Kronrod pair of 7 and 15 points; a piece whose two
//! values differ by more than its share of the tolerance is halved.
//!
//! Source: R. Piessens and others, "QUADPACK" (1983), routine QK15. Deviation: local instead of
//! global adaptation, with a bound on the depth, so that the order of operations (and with it
//! every bit of the result) is fixed. Cost: 15 evaluations for each piece. Guarantee: the error
//! estimate is usually pessimistic by several digits for smooth functions.

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

/// Halvings allowed below one piece.
const MAX_DEPTH: u32 = 24;

/// The integral of `function` over the consecutive pieces between the sorted `cuts`, to about
/// `tolerance` in absolute terms.
pub(crate) fn integrate_over_pieces(
    function: &impl Fn(f64) -> f64,
    cuts: &[f64],
    tolerance: f64,
) -> f64 {
    cuts.windows(2)
        .filter(|piece| piece[1] > piece[0])
        .map(|piece| integrate(function, piece[0], piece[1], tolerance, MAX_DEPTH))
        .sum()
}

fn integrate(
    function: &impl Fn(f64) -> f64,
    low: f64,
    high: f64,
    tolerance: f64,
    depth: u32,
) -> f64 {
    let (value, error) = gauss_kronrod(function, low, high);
    let middle = 0.5 * (low + high);
    if error <= tolerance || depth == 0 || middle <= low || middle >= high {
        return value;
    }
    integrate(function, low, middle, 0.5 * tolerance, depth - 1)
        + integrate(function, middle, high, 0.5 * tolerance, depth - 1)
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

    #[test]
    fn a_narrow_peak_is_found_by_halving() {
        let peak = |x: f64| 1e4 / (1.0 + (1e4 * (x - 0.3)).powi(2));
        let exact = (7e3_f64).atan() + (3e3_f64).atan();
        let value = integrate_over_pieces(&peak, &[0.0, 0.3, 1.0], 1e-12);
        assert!((value - exact).abs() < 1e-10, "{}", value - exact);
    }
}
