//! How regularly something happens, in bounded memory.
//!
//! The periods between neighbouring messages are counted in bins whose edges are 2^k (1 + j/32), so
//! that a quantile is known to within 1/32 of its value (3 %) whatever the rate. Mean, deviation and
//! the longest period are exact; the deviation is computed by B. P. Welford, "Note on a method for
//! calculating corrected sums of squares and products", Technometrics 4 (1962).

/// Bins for each doubling.
const STEPS: usize = 32;
/// log2 of `STEPS`.
const STEP_BITS: u32 = 5;

/// The periods of one topic.
#[derive(Debug, Clone)]
pub(super) struct Periods {
    bins: Vec<u64>,
    count: u64,
    mean_nanos: f64,
    squares: f64,
    /// The longest period and the time at which it began.
    longest: (i64, i64),
    last_nanos: Option<i64>,
    out_of_order: u64,
}

impl Periods {
    pub fn new() -> Self {
        Periods {
            bins: vec![0; (64 - STEP_BITS as usize + 1) * STEPS],
            count: 0,
            mean_nanos: 0.0,
            squares: 0.0,
            longest: (0, 0),
            last_nanos: None,
            out_of_order: 0,
        }
    }

    /// A message came at `time_nanos`.
    pub fn push(&mut self, time_nanos: i64) {
        let Some(last_nanos) = self.last_nanos else {
            self.last_nanos = Some(time_nanos);
            return;
        };
        if time_nanos < last_nanos {
            self.out_of_order += 1;
            return;
        }
        self.last_nanos = Some(time_nanos);
        let period_nanos = time_nanos.saturating_sub(last_nanos);
        self.count += 1;
        self.bins[bin_of(period_nanos as u64)] += 1;
        let before = period_nanos as f64 - self.mean_nanos;
        self.mean_nanos += before / self.count as f64;
        self.squares += before * (period_nanos as f64 - self.mean_nanos);
        if period_nanos > self.longest.0 {
            self.longest = (period_nanos, last_nanos);
        }
    }

    /// How many messages came with an earlier time than one before.
    pub fn out_of_order(&self) -> u64 {
        self.out_of_order
    }

    /// The middle of all periods in seconds, to within 3 %; `None` without any.
    pub fn median_secs(&self) -> Option<f64> {
        let middle = self.count.div_ceil(2);
        let mut seen = 0;
        for (index, &count) in self.bins.iter().enumerate() {
            seen += count;
            if count > 0 && seen >= middle {
                let (from, to) = (edge_of(index), edge_of(index + 1));
                // Of a bin of one value that value.
                let centre = (from + to - 1.0) / 2.0;
                return Some(centre.min(self.longest.0 as f64) / 1e9);
            }
        }
        None
    }

    /// The standard deviation of the periods in seconds; `None` for fewer than two.
    pub fn deviation_secs(&self) -> Option<f64> {
        (self.count > 1).then(|| (self.squares / (self.count - 1) as f64).sqrt() / 1e9)
    }

    /// The longest period and the time at which it began, in nanoseconds; `None` without any.
    pub fn longest_nanos(&self) -> Option<(i64, i64)> {
        (self.count > 0).then_some(self.longest)
    }

    /// How many periods are surely longer than `limit_secs`: those in bins that begin behind it.
    pub fn longer_than(&self, limit_secs: f64) -> u64 {
        let bins = self.bins.iter().enumerate();
        let longer = bins.filter(|(index, _)| edge_of(*index) > limit_secs * 1e9);
        longer.map(|(_, count)| count).sum()
    }
}

fn bin_of(nanos: u64) -> usize {
    if nanos < STEPS as u64 {
        return nanos as usize;
    }
    let exponent = nanos.ilog2();
    let step = (nanos >> (exponent - STEP_BITS)) as usize - STEPS;
    (exponent - STEP_BITS + 1) as usize * STEPS + step
}

/// The least number of nanoseconds in a bin.
fn edge_of(bin: usize) -> f64 {
    if bin < STEPS {
        return bin as f64;
    }
    let (doubling, step) = (bin / STEPS - 1, bin % STEPS);
    (STEPS + step) as f64 * 2_f64.powi(doubling as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_cover_everything_once() {
        let numbers = (0..200).chain((5..63).flat_map(|k| [(1 << k) - 1, 1 << k, (1 << k) + 1]));
        for nanos in numbers.chain([i64::MAX as u64]) {
            let bin = bin_of(nanos);
            let value = nanos as f64;
            assert!(
                edge_of(bin) <= value && value <= edge_of(bin + 1),
                "{nanos}"
            );
            assert!(
                edge_of(bin + 1) - edge_of(bin) <= (value / 32.0).max(1.0) * 1.0001,
                "{nanos}"
            );
        }
    }

    #[test]
    fn periods_are_summed_up() {
        let mut periods = Periods::new();
        let mut time = 0;
        for step in 0..=1000 {
            periods.push(time);
            time += if step == 500 {
                70_000_000
            } else {
                10_000_000 + (step % 3 - 1) * 100_000
            };
        }
        periods.push(0);
        assert_eq!(periods.out_of_order(), 1);
        let median = periods.median_secs().unwrap();
        assert!((median / 0.01 - 1.0).abs() < 1.0 / 32.0, "{median}");
        assert_eq!(
            periods.longest_nanos().map(|(longest, _)| longest),
            Some(70_000_000)
        );
        assert_eq!(periods.longer_than(5.0 * median), 1);
        let list: Vec<f64> = (0..1000)
            .map(|step| {
                if step == 500 {
                    0.07
                } else {
                    0.01 + f64::from(step % 3 - 1) * 1e-4
                }
            })
            .collect();
        let mean = list.iter().sum::<f64>() / 1000.0;
        let variance = list.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 999.0;
        assert!((periods.deviation_secs().unwrap() / variance.sqrt() - 1.0).abs() < 1e-9);
        assert!(Periods::new().median_secs().is_none());
    }
}
