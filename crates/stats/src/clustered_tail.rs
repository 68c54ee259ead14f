//! How probable a better count of clustered trials is at a threshold: a sum over all outcomes, not its limit.
//!
//! # Definition
//! At the threshold `p0` and the correlation `rho` that is most likely there, of clusters of `n_i` trials with `f_i` failures
//!
//! ```text
//! T = sum_i round(c w_i f_i),   w_i = 1 / (1 + (n_i - 1) rho)
//! P(T < t) + P(T = t)/2 under  f_i ~ beta-binomial(n_i, 1 - p0, rho), independent       evidence that the rate is above p0
//! P(T > t) + P(T = t)/2                                                                 evidence that it is below
//! ```
//!
//! `w_i` weighs a cluster by what a trial of it tells. Each trial has a cell where clusters are of one size, of few trials or few
//! themselves; else all trials have at least [`CELLS`] cells, and each cluster as many as it has trials, or [`CELLS_OF_ONE`]. Rounding coarsens the count, and its distribution is
//! that of the count as it is rounded. Of the outcomes the one is counted that has fewer cells. Where it has more than [`MOST_CELLS`]
//! nothing is asked: hundreds of clusters have it, and the ratio of likelihoods is near its limit.
//!
//! # Why
//! The ratio of likelihoods ([`crate::BetaBinomial::likelihood_tests`]) has the distribution of its limit for many clusters. In the
//! tails that a study of several requirements uses that is far off where few people fail: of 25 with four attempts each, who
//! are as alike as a correlation of 0.6 makes them, a rate of 0.9 is "above 0.9" at a level of 1.25 % in 3.9 % of all
//! cohorts. Nobody who fails is the likely cohort there, and one who fails once does not tell how alike attempts are.
//! [`mod@crate::clustered`] has the errors with this sum and without it.
//!
//! # Source
//! The most likely nuisance parameter under the hypothesis in its place, with the distribution there: C. J. Lloyd,
//! "Exact p-values for discrete models obtained by estimation and maximization" (2008), the first of its two steps. Half of what was
//! observed: H. O. Lancaster, "Significance tests in discrete distributions" (1961). Weights: J. N. K. Rao and A. J. Scott (1992).
//! Deviations: the second step, a maximum over all correlations, is left out, as it is that of clusters that are one trial
//! each and shows nothing; the whole of what was observed would count cohorts without any failure against such as have few, though
//! these show nothing by themselves: of 20 people with five attempts, 98 of 100 could not show a rate above 0.9. The
//! distribution of the ratio itself would find a little more, but can be summed for few clusters of one size only.
//!
//! # Assumes
//! As [`mod@crate::beta_binomial`].
//!
//! # Guarantee
//! None by itself; beside the other tests as measured in [`mod@crate::clustered`]. Cost: below a millisecond for hundreds of clusters,
//! some milliseconds for a rate in the middle of tens of thousands of trials.

/// Cells of all trials of clusters that differ in size, and of each of them, at least.
const CELLS: f64 = 1200.0;
const CELLS_OF_ONE: f64 = 20.0;

/// The most cells that a count may have.
const MOST_CELLS: f64 = 800.0;

/// A cluster of more trials counts as one of so many with the same share of failures, and as close to the same variance as
/// one of so many can have: never less.
const MOST_TRIALS: f64 = 65_536.0;

/// Clusters alike: successes, failures, how many.
pub(crate) type Alike = (f64, f64, f64);

/// The probabilities of a higher and of a lower count at this mean rate and correlation, each with half of that of this one; `None`
/// where it has too many cells.
pub(crate) fn tails(clusters: &[Alike], mean: f64, correlation: f64) -> Option<(f64, f64)> {
    let cells = Cells::new(clusters, correlation);
    let (failures, all) = cells.count(clusters);
    if failures.min(all - failures) > MOST_CELLS {
        return None;
    }
    if 2.0 * failures <= all {
        return Some(Side::new(clusters, &cells, 1.0 - mean).tails());
    }
    let mirrored: Vec<Alike> = clusters
        .iter()
        .map(|&(s, f, times)| (f, s, times))
        .collect();
    let (few, many) = Side::new(&mirrored, &cells, mean).tails();
    Some((many, few))
}

/// How trials are weighed and counted in cells.
struct Cells {
    correlation: f64,
    /// Cells of a trial of weight 1; `None` where each trial has one.
    scale: Option<f64>,
}

impl Cells {
    fn new(clusters: &[Alike], correlation: f64) -> Self {
        let mut cells = Self {
            correlation,
            scale: None,
        };
        let sizes = by_size(clusters);
        let is_fine =
            |&(trials, times): &(f64, f64)| trials <= CELLS_OF_ONE || trials * times <= CELLS;
        if sizes.len() > 1 || !sizes.iter().all(is_fine) {
            let of_one = |trials: f64| cells.weight(trials) * trials;
            let all: f64 = clusters.iter().map(|it| it.2 * of_one(it.0 + it.1)).sum();
            let fine = |it: &Alike| (it.0 + it.1).min(CELLS_OF_ONE) / of_one(it.0 + it.1);
            let finest = clusters.iter().map(fine).fold(CELLS / all, f64::max);
            cells.scale = Some(finest);
        }
        cells
    }

    /// What a trial of a cluster of so many tells.
    fn weight(&self, trials: f64) -> f64 {
        1.0 / (1.0 + (trials - 1.0) * self.correlation)
    }

    /// The cell of so many outcomes of a cluster of so many trials.
    fn place(&self, trials: f64, outcomes: f64) -> f64 {
        match self.scale {
            None => outcomes,
            Some(scale) => (outcomes * scale * self.weight(trials)).round(),
        }
    }

    /// The cells of all failures, and of all trials.
    fn count(&self, clusters: &[Alike]) -> (f64, f64) {
        let failures = clusters.iter();
        let failures = failures.map(|&(s, f, times)| times * self.place(s + f, f));
        let all = clusters.iter();
        let all = all.map(|&(s, f, times)| times * self.place(s + f, s + f));
        (failures.sum(), all.sum())
    }
}

/// The weighted count of one outcome, and what it is made of.
struct Side {
    /// For each size of a cluster the probabilities of its cells, and how many have that size.
    sizes: Vec<(Vec<f64>, u64)>,
    count: f64,
}

impl Side {
    /// Of the second outcome, which has this rate.
    fn new(clusters: &[Alike], cells: &Cells, rate: f64) -> Self {
        let (count, _) = cells.count(clusters);
        let most = count as usize + 1;
        let law = |(trials, times): (f64, f64)| {
            let mut of_cells = vec![0.0; (cells.place(trials, trials) as usize + 1).min(most)];
            for (outcomes, probability) in beta_binomial(trials, rate, cells.correlation) {
                if let Some(cell) = of_cells.get_mut(cells.place(trials, outcomes) as usize) {
                    *cell += probability;
                }
            }
            (of_cells, times as u64)
        };
        let sizes = by_size(clusters).into_iter().map(law).collect();
        Self { sizes, count }
    }

    /// The probabilities of a lower and of a higher count, each with half of that of this one.
    fn tails(&self) -> (f64, f64) {
        let most = self.count as usize + 1;
        let all = self.sizes.iter().fold(vec![1.0], |all, (one, times)| {
            product(&all, &power(one, *times, most), most)
        });
        let below: f64 = all.iter().take(most - 1).sum();
        let at = all.get(most - 1).copied().unwrap_or(0.0);
        let lower = (below + 0.5 * at).min(1.0);
        (lower, 1.0 - lower)
    }
}

/// How many clusters there are of each size.
fn by_size(clusters: &[Alike]) -> Vec<(f64, f64)> {
    let mut sizes: Vec<(f64, f64)> = clusters
        .iter()
        .map(|&(s, f, times)| (s + f, times))
        .collect();
    sizes.sort_by(|one, other| one.0.total_cmp(&other.0));
    sizes.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 += next.1;
        }
        is_same
    });
    sizes
}

/// Numbers of outcomes with their probabilities. From the ratios of neighbours, outwards from the most likely number of
/// independent trials, and then made to add up to 1.
fn beta_binomial(trials: f64, rate: f64, correlation: f64) -> Vec<(f64, f64)> {
    let (few, correlation) = coarser(trials, correlation);
    let theta = correlation / (1.0 - correlation);
    let rest = 1.0 - rate;
    let ratio =
        |k: f64| (few - k) * (rate + k * theta) / ((k + 1.0) * (rest + (few - k - 1.0) * theta));
    let start = (few * rate).floor().min(few);
    let mut up = vec![(start, 1.0)];
    let mut down = Vec::new();
    let (mut k, mut value) = (start, 1.0);
    while k < few {
        value *= ratio(k);
        k += 1.0;
        up.push((k, value));
    }
    (k, value) = (start, 1.0);
    while k > 0.0 {
        k -= 1.0;
        value /= ratio(k);
        down.push((k, value));
    }
    let sum: f64 = down.iter().chain(&up).map(|it| it.1).sum();
    let scale = trials / few;
    down.into_iter()
        .chain(up)
        .map(|(k, value)| (k * scale, value / sum))
        .collect()
}

/// The number of trials that a cluster counts as, and the correlation at which its rate varies as much.
fn coarser(trials: f64, correlation: f64) -> (f64, f64) {
    if trials <= MOST_TRIALS {
        return (trials, correlation);
    }
    let variance = correlation + (1.0 - correlation) / trials;
    let at_least = 1.0 / MOST_TRIALS;
    (
        MOST_TRIALS,
        ((variance - at_least) / (1.0 - at_least)).max(0.0),
    )
}

/// The distribution of the sum of so many that are alike, up to a number of cells.
fn power(one: &[f64], times: u64, most: usize) -> Vec<f64> {
    let (mut all, mut square, mut left) = (vec![1.0], one.to_vec(), times);
    while left > 0 {
        if left & 1 == 1 {
            all = product(&all, &square, most);
        }
        left >>= 1;
        if left > 0 {
            square = product(&square, &square, most);
        }
    }
    all
}

/// The distribution of the sum of two, up to a number of cells.
fn product(one: &[f64], other: &[f64], most: usize) -> Vec<f64> {
    let mut all = vec![0.0; (one.len() + other.len() - 1).min(most)];
    for (at, &first) in one.iter().enumerate() {
        let rest = all.get_mut(at..).unwrap_or_default();
        for (sum, &second) in rest.iter_mut().zip(other) {
            *sum += first * second;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special::{binomial_pmf, ln_gamma};

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() <= tolerance * expected.abs(),
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn independent_trials_have_the_binomial_tails() {
        let (above, below) = tails(&[(9.0, 1.0, 3.0), (10.0, 0.0, 2.0)], 0.8, 0.0).expect("few");
        let higher: f64 = (48..=50).map(|k| binomial_pmf(k, 50, 0.8)).sum();
        let half = 0.5 * binomial_pmf(47, 50, 0.8);
        close(above, higher + half, 1e-12);
        close(below, 1.0 - higher - half, 1e-12);
    }

    /// The closed form, from a few trials that differ by chance to such as are all of one outcome.
    #[test]
    fn ratios_of_neighbours_give_the_law() {
        for (trials, rate, correlation) in [
            (4_u32, 0.1, 0.6),
            (50, 0.3, 0.01),
            (7, 0.9, 0.999),
            (300, 0.02, 0.2),
        ] {
            let size = (1.0 - correlation) / correlation;
            let (a, b) = (rate * size, (1.0 - rate) * size);
            let ln_beta = |a: f64, b: f64| ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
            let n = f64::from(trials);
            for (k, found) in beta_binomial(n, rate, correlation) {
                let choose = ln_gamma(n + 1.0) - ln_gamma(k + 1.0) - ln_gamma(n - k + 1.0);
                let expected = (choose + ln_beta(a + k, b + n - k) - ln_beta(a, b)).exp();
                close(found, expected, 1e-9);
            }
        }
    }

    /// All outcomes of clusters of different sizes, one by one.
    #[test]
    fn of_unequal_clusters_it_is_the_sum_over_all_outcomes() {
        let clusters = [(2.0, 1.0, 1.0), (5.0, 0.0, 1.0), (7.0, 2.0, 1.0)];
        let (mean, correlation) = (0.7, 0.25);
        let laws = clusters.map(|(s, f, _)| beta_binomial(s + f, 1.0 - mean, correlation));
        let weight = |n: f64| 1.0 / (1.0 + (n - 1.0) * correlation);
        let all: f64 = clusters
            .iter()
            .map(|(s, f, _)| weight(s + f) * (s + f))
            .sum();
        // The cluster of nine has a cell for each trial with fewer than all have at least.
        let place = |n: f64, f: f64| (f * weight(n) * CELLS / all).round();
        let count: f64 = clusters.iter().map(|(s, f, _)| place(s + f, *f)).sum();
        let (mut above, mut below) = (0.0, 0.0);
        for (i, a) in &laws[0] {
            for (j, b) in &laws[1] {
                for (k, c) in &laws[2] {
                    let sum = place(3.0, *i) + place(5.0, *j) + place(9.0, *k);
                    let part = |is: bool| if is { 0.5 * a * b * c } else { 0.0 };
                    above += part(sum <= count) + part(sum < count);
                    below += part(sum >= count) + part(sum > count);
                }
            }
        }
        let found = tails(&clusters, mean, correlation).expect("few cells");
        close(found.0, above, 1e-9);
        close(found.1, below, 1e-9);
    }

    /// Successes and failures exchanged exchange the sides.
    #[test]
    fn its_mirror_image_is_the_same() {
        let clusters = [(20.0, 1.0, 3.0), (14.0, 9.0, 2.0), (4.0, 0.0, 9.0)];
        let mirrored = clusters.map(|(s, f, times)| (f, s, times));
        for (mean, correlation) in [(0.9, 0.0), (0.7, 0.1), (0.5, 0.4), (0.8, 0.9)] {
            let (above, below) = tails(&clusters, mean, correlation).expect("few");
            let (of_failures_above, of_failures_below) =
                tails(&mirrored, 1.0 - mean, correlation).expect("few");
            close(of_failures_below, above, 1e-9);
            close(of_failures_above, below, 1e-9);
        }
    }

    /// Beyond the trials that are counted one by one a cluster is as one of fewer trials with its variance.
    #[test]
    fn a_hundred_million_trials_each_are_told_by_their_shares() {
        let people = |trials: f64| {
            [0.86, 0.9, 0.93, 0.97].map(|rate| (rate * trials, (1.0 - rate) * trials, 1.0))
        };
        let of_many = tails(&people(1e8), 0.88, 0.02).expect("few");
        let of_few = tails(&people(50_000.0), 0.88, 0.02).expect("few");
        close(of_many.0, of_few.0, 0.01);
        assert!(of_many.0 > 0.01 && of_many.0 < 0.2, "{of_many:?}");
        // As independent trials they count as fewer than they are, not as more.
        let (above, _) = tails(&[(9e7, 1e7, 1.0)], 0.899, 0.0).expect("few");
        assert!(above < 0.3 && above > 0.1, "{above}");
    }

    /// Twelve people of three trials and three of forty, at the correlation that is most likely there: by 400 000 draws of numpy's.
    #[test]
    fn a_rate_in_the_middle_of_unequal_clusters_is_summed() {
        let few = [
            (0.0, 3.0, 1.0),
            (1.0, 2.0, 2.0),
            (2.0, 1.0, 7.0),
            (3.0, 0.0, 2.0),
        ];
        let many = [(20.0, 20.0, 1.0), (17.0, 23.0, 1.0), (16.0, 24.0, 1.0)];
        let clusters = [few.as_slice(), &many].concat();
        let (above, below) = tails(&clusters, 0.6, 0.0594).expect("few cells");
        assert!((below - 0.0909).abs() < 0.003, "{below}");
        assert!((above + below - 1.0).abs() < 1e-9, "{above}");
    }

    /// However many clusters there are, a failure has its cell; of a count that is too long to be summed nothing is said.
    #[test]
    fn of_thousands_of_clusters_no_failure_is_rounded_away() {
        let pairs = [(2.0, 0.0, 4000.0), (1.0, 1.0, 64.0), (0.0, 2.0, 36.0)];
        let (above, below) = tails(&pairs, 0.97, 0.2).expect("136 failures");
        assert!(above < 1e-8 && below > 0.999_999, "{above} {below}");
        let uneven = [
            (1.0, 0.0, 2950.0),
            (2.0, 0.0, 2950.0),
            (0.0, 1.0, 50.0),
            (1.0, 1.0, 50.0),
        ];
        let (above, _) = tails(&uneven, 0.95, 0.0).expect("a hundred failures");
        assert!(above < 1e-20, "{above}");
        let half = [(2.0, 0.0, 2000.0), (0.0, 2.0, 2000.0)];
        assert_eq!(tails(&half, 0.5, 0.9), None);
    }
}
