//! Midranks: the ranks of observations, ties sharing the mean of the ranks they cover.
//!
//! Ranks are kept doubled, as whole numbers, so that sums of them are exact.

use crate::counts::StatsError;

/// The doubled midranks of a list of observations, and the sizes of its groups of ties.
pub(crate) struct Ranking {
    /// Twice the midrank of each observation, in the order given.
    pub doubled: Vec<u64>,
    /// The doubled rank and the number of observations of each distinct value, ascending.
    pub classes: Vec<(u64, u64)>,
}

impl Ranking {
    /// Ranks `values`.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] when a value is not a number.
    pub fn of(values: &[f64]) -> Result<Self, StatsError> {
        if let Some(&value) = values.iter().find(|value| value.is_nan()) {
            let expected = "a number for each observation";
            return Err(StatsError::OutOfRange {
                what: "observation",
                value,
                expected,
            });
        }
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut doubled = vec![0; values.len()];
        let mut classes = Vec::new();
        let mut start = 0;
        while start < order.len() {
            let mut end = start + 1;
            while end < order.len() && values[order[end]] == values[order[start]] {
                end += 1;
            }
            // Ranks start + 1 ..= end: twice their mean.
            let rank = (start + 1 + end) as u64;
            order[start..end]
                .iter()
                .for_each(|&index| doubled[index] = rank);
            classes.push((rank, (end - start) as u64));
            start = end;
        }
        Ok(Self { doubled, classes })
    }

    /// The sum of `t^3 - t` over groups of `t` tied observations.
    pub fn tie_sum(&self) -> f64 {
        self.classes
            .iter()
            .map(|&(_, size)| (size as f64).powi(3) - size as f64)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_share_their_mean_rank() {
        let ranking = Ranking::of(&[3.0, 1.0, 3.0, -0.0, 0.0]).unwrap();
        assert_eq!(ranking.doubled, vec![9, 6, 9, 3, 3]);
        assert_eq!(ranking.classes, vec![(3, 2), (6, 1), (9, 2)]);
        assert_eq!(ranking.tie_sum(), 12.0);
        assert!(Ranking::of(&[1.0, f64::NAN]).is_err());
    }
}
