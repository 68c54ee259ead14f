//! Shares in a result's variance by quadrature: exact for polynomials, from few evaluations.
//!
//! # Definition
//! For independent inputs with beta densities, every mean that the shares of [`mod@crate::propagation`] are made of is
//! an integral with these densities as its weights. On the product of Gauss-Jacobi rules of `n` nodes for each of `k`
//! inputs, with `f` the function's values there and `w` the product of the weights,
//!
//! ```text
//! V   = sum w (f - m)^2,  m = sum w f
//! S_j = sum over nodes i of input j of  w_i (E[f | x_j = i] - m)^2 / V
//! T_j = sum over the nodes of all others of  w (sum_i w_i (f - E[f | others])^2) / V
//! ```
//!
//! The recurrence of the polynomials that are orthogonal under Beta(a, b) comes from its canonical moments,
//! `p_(2i-1) = (a+i-1)/(a+b+2i-2)` and `p_(2i) = i/(a+b+2i-1)`, as `z_j = (1-p_(j-1)) p_j`,
//!
//! ```text
//! diagonal_i = z_(2i) + z_(2i+1),   (beside it)_i^2 = z_(2i-1) z_(2i)
//! ```
//!
//! in which no digits cancel. The nodes are the eigenvalues of this tridiagonal matrix, found by bisection of Sturm's
//! count, and a weight is one over the sum of the squares of the orthonormal polynomials there.
//!
//! # Source
//! G. H. Golub and J. H. Welsch, "Calculation of Gauss quadrature rules" (1969); M. Skibinsky, "Some striking
//! properties of binomial and beta moments" (1969), for the canonical moments; W. Barth, R. S. Martin and J. H.
//! Wilkinson (1967) for the bisection. Cost: `n^k + (n-1)^k` evaluations. Deviation: two products, of `n` and of
//! `n - 1` nodes, so that the second tells what the first leaves open.
//!
//! # Assumes
//! Inputs are independent with the beta distributions that are given. The function is smooth over their range.
//!
//! # Guarantee
//! Exact up to rounding where the function is in each input a polynomial of degree below `n`; for functions without a
//! pole near the inputs' range the error falls geometrically with `n`. Each share's error is the difference between
//! the two products. A function that bends or jumps between the nodes can deceive both: the caller holds the variance
//! against that of independent draws.

use crate::posterior::BetaPosterior;
use crate::propagation::Shares;

/// The most nodes for one input.
const MOST_NODES: usize = 16;

/// Nodes and weights of one input's rule, ascending.
type Rule = Vec<(f64, f64)>;

/// The points of two products of Gauss-Jacobi rules.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GaussGrid {
    /// One rule for each input.
    fine: Vec<Rule>,
    coarse: Vec<Rule>,
}

/// What a grid says of a function.
pub(crate) struct GridShares {
    /// The function's variance.
    pub variance: f64,
    /// One entry for each input, 0 where the function does not vary on the grid.
    pub shares: Vec<Shares>,
}

impl GaussGrid {
    /// The finest grid of at most `most` points; `None` where not even three and two nodes for each input fit.
    pub fn within(inputs: &[BetaPosterior], most: usize) -> Option<Self> {
        let k = u32::try_from(inputs.len()).ok()?;
        let points = |n: usize| n.checked_pow(k)?.checked_add((n - 1).checked_pow(k)?);
        let fits = |n: &usize| points(*n).is_some_and(|count| count <= most);
        let nodes = (3..=MOST_NODES).take_while(fits).last()?;
        let rules = |n: usize| inputs.iter().map(|input| gauss_rule(input, n)).collect();
        Some(Self {
            fine: rules(nodes),
            coarse: rules(nodes - 1),
        })
    }

    /// The points, one value for each input.
    pub fn rows(&self) -> Vec<Vec<f64>> {
        let mut rows = product(&self.fine);
        rows.extend(product(&self.coarse));
        rows
    }

    /// Variance and shares, given the function's value at each of the rows.
    pub fn analyse(&self, outputs: &[f64]) -> GridShares {
        let size = self.fine.iter().map(Vec::len).product();
        let (fine, coarse) = outputs.split_at(size);
        let (fine, coarse) = (
            Moments::of(&self.fine, fine),
            Moments::of(&self.coarse, coarse),
        );
        let shares = fine.shares.iter().zip(&coarse.shares);
        let shares = shares.map(|(fine, coarse)| Shares {
            first_order: fine.0.clamp(0.0, 1.0),
            total: fine.1.clamp(0.0, 1.0),
            first_order_error: (fine.0 - coarse.0).abs(),
            total_error: (fine.1 - coarse.1).abs(),
        });
        GridShares {
            variance: fine.variance,
            shares: shares.collect(),
        }
    }
}

/// All combinations of the rules' nodes, the last input's running fastest.
fn product(rules: &[Rule]) -> Vec<Vec<f64>> {
    let mut rows = vec![Vec::new()];
    for rule in rules {
        let longer = |row: &Vec<f64>| {
            let row = row.clone();
            rule.iter().map(move |(node, _)| {
                let mut row = row.clone();
                row.push(*node);
                row
            })
        };
        rows = rows.iter().flat_map(longer).collect();
    }
    rows
}

/// Variance of a function, and for each input what goes with it alone, and with the others.
struct Moments {
    variance: f64,
    shares: Vec<(f64, f64)>,
}

impl Moments {
    fn of(rules: &[Rule], values: &[f64]) -> Self {
        let weights: Vec<f64> = product_of_weights(rules);
        let weighted = |of: &dyn Fn(usize) -> f64| -> f64 {
            (0..values.len()).map(|at| weights[at] * of(at)).sum()
        };
        let mean = weighted(&|at| values[at]);
        let variance = weighted(&|at| (values[at] - mean).powi(2));
        let mut stride = values.len();
        let shares = rules.iter().map(|rule| {
            stride /= rule.len();
            let node = |at: usize| at / stride % rule.len();
            let mut alone = vec![0.0; rule.len()];
            for at in 0..values.len() {
                alone[node(at)] += weights[at] / rule[node(at)].1 * (values[at] - mean);
            }
            let first: f64 = rule.iter().zip(&alone).map(|((_, w), m)| w * m * m).sum();
            // Along each line of this input, from its first point.
            let total = (0..values.len()).filter(|at| node(*at) == 0).map(|start| {
                let line = |i: usize| values[start + i * stride];
                let centre: f64 = (0..rule.len()).map(|i| rule[i].1 * line(i)).sum();
                let spread = (0..rule.len()).map(|i| rule[i].1 * (line(i) - centre).powi(2));
                weights[start] / rule[0].1 * spread.sum::<f64>()
            });
            let total: f64 = total.sum();
            match variance > 0.0 {
                true => (first / variance, total / variance),
                false => (0.0, 0.0),
            }
        });
        let shares = shares.collect();
        Self { variance, shares }
    }
}

fn product_of_weights(rules: &[Rule]) -> Vec<f64> {
    rules.iter().fold(vec![1.0], |before, rule| {
        let longer = |weight: &f64| {
            let weight = *weight;
            rule.iter().map(move |(_, next)| weight * next)
        };
        before.iter().flat_map(longer).collect()
    })
}

/// The rule of `nodes` points whose weight is the distribution.
fn gauss_rule(of: &BetaPosterior, nodes: usize) -> Rule {
    let (a, b) = of.parameters();
    let moment = |j: usize| {
        let i = j.div_ceil(2) as f64;
        match j {
            0 => 0.0,
            _ if j % 2 == 1 => (a + i - 1.0) / (a + b + 2.0 * i - 2.0),
            _ => i / (a + b + 2.0 * i - 1.0),
        }
    };
    let z = |j: usize| match j {
        0 => 0.0,
        _ => (1.0 - moment(j - 1)) * moment(j),
    };
    let diagonal: Vec<f64> = (0..nodes).map(|i| z(2 * i) + z(2 * i + 1)).collect();
    let beside: Vec<f64> = (1..nodes).map(|i| z(2 * i - 1) * z(2 * i)).collect();
    let below = |x: f64| {
        let mut pivot = 1.0_f64;
        let mut count = 0;
        for i in 0..nodes {
            let from = if i == 0 { 0.0 } else { beside[i - 1] / pivot };
            pivot = diagonal[i] - x - from;
            if pivot == 0.0 {
                pivot = -f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    };
    let rule = (0..nodes).map(|index| {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        loop {
            let middle = f64::midpoint(low, high);
            if middle <= low || middle >= high {
                break;
            }
            if below(middle) > index {
                high = middle;
            } else {
                low = middle;
            }
        }
        (low, weight(low, &diagonal, &beside))
    });
    let mut rule: Rule = rule.collect();
    // Rounding of the nodes leaves the sum a little off 1.
    let sum: f64 = rule.iter().map(|(_, weight)| weight).sum();
    rule.iter_mut().for_each(|(_, weight)| *weight /= sum);
    rule
}

/// One over the sum of the squares of the orthonormal polynomials.
fn weight(x: f64, diagonal: &[f64], beside: &[f64]) -> f64 {
    let (mut before, mut here, mut sum) = (0.0_f64, 1.0_f64, 1.0_f64);
    for (i, next) in beside.iter().enumerate() {
        let last = if i == 0 { 0.0 } else { beside[i - 1].sqrt() };
        let value = ((x - diagonal[i]) * here - last * before) / next.sqrt();
        (before, here) = (here, value);
        sum += value * value;
    }
    1.0 / sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    type Pairs = [(f64, f64)];

    /// Nodes and weights of scipy 1.17's `roots_jacobi(n, b-1, a-1)`, moved to [0, 1] and divided by their sum.
    const SCIPY: &[(f64, f64, &Pairs)] = &[
        (
            3.5,
            97.5,
            &[
                (0.014431512996362528, 0.3108583657894076),
                (0.036843869741498225, 0.5530068968323785),
                (0.070585821976555, 0.13250990079287764),
                (0.12112944949119175, 0.00362483658533626),
            ],
        ),
        (
            0.5,
            5.5,
            &[
                (0.024246714577746964, 0.7166496595707682),
                (0.2070671738371393, 0.25997442034025453),
                (0.5186861115851138, 0.023375920088977282),
            ],
        ),
    ];

    #[test]
    fn rules_are_scipys() {
        for (a, b, expected) in SCIPY {
            let rule = gauss_rule(&BetaPosterior::new(*a, *b).unwrap(), expected.len());
            for ((node, weight), (x, w)) in rule.iter().zip(*expected) {
                assert!((node - x).abs() < 1e-13, "{a} {b}: {node} {x}");
                assert!((weight / w - 1.0).abs() < 1e-9, "{a} {b}: {weight} {w}");
            }
        }
    }

    /// A rule of `n` nodes gives the moments below `2 n`, from no trials to 10^8 of them.
    #[test]
    fn moments_are_exact() {
        for (successes, trials) in [
            (0, 0),
            (0, 5),
            (3, 7),
            (0, 100_000_000),
            (100_000_000, 100_000_000),
            (12_345_678, 100_000_000),
        ] {
            let input = BetaPosterior::jeffreys(Sample { successes, trials });
            let (a, b) = input.parameters();
            for nodes in [2, 5, MOST_NODES] {
                let rule = gauss_rule(&input, nodes);
                let mut expected = 1.0;
                for power in 1..2 * nodes {
                    let before = (power - 1) as f64;
                    expected *= (a + before) / (a + b + before);
                    let found: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                    let off = found / expected - 1.0;
                    assert!(
                        off.abs() < 1e-11,
                        "{successes}/{trials} {nodes} {power}: {off}"
                    );
                }
                let mean = input.mean();
                let variance: f64 = rule.iter().map(|(x, w)| w * (x - mean).powi(2)).sum();
                assert!(
                    (variance / input.variance() - 1.0).abs() < 1e-7,
                    "{successes}/{trials}"
                );
            }
        }
    }

    #[test]
    fn a_grid_uses_what_it_may() {
        let inputs = |k: usize| vec![BetaPosterior::new(2.5, 7.5).unwrap(); k];
        let size =
            |k: usize, most: usize| GaussGrid::within(&inputs(k), most).map(|g| g.rows().len());
        assert_eq!(size(4, 500), Some(256 + 81));
        assert_eq!(size(1, 500), Some(16 + 15));
        assert_eq!(size(3, 34), None);
        assert_eq!(size(70, usize::MAX), None);
    }
}
