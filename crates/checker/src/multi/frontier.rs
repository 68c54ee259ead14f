//! How far one can go from a vector in a direction within what schedulers achieve.
//!
//! *Problem.* Maximise `l` such that some mixture of achieved vectors is at least `t + l d` in the numbers that
//! count. Over the corners known this is a linear programme, and its dual gives the weights `w` by which no corner
//! known is better than its value; the scheduler that is best for `w` either shows that nothing is, or is a corner
//! that was not known. Guarantee: exact. Cost: see [`super`].

use num_traits::{One, Zero};
use prism_lang::Rational;

use super::simplex::maximise;
use super::weighted::{Corner, Skeleton};
use crate::answer::{CheckError, Options};

/// The corners known so far.
pub(super) struct Search<'a> {
    skeleton: &'a Skeleton,
    options: &'a Options<'a>,
    /// Where to start.
    from: Vec<Rational>,
    corners: Vec<Corner>,
    /// The share of each corner in the mixture that went furthest in the last question.
    shares: Vec<Rational>,
}

impl<'a> Search<'a> {
    pub fn new(skeleton: &'a Skeleton, from: Vec<Rational>, options: &'a Options<'a>) -> Self {
        Self {
            skeleton,
            options,
            from,
            corners: Vec::new(),
            shares: Vec::new(),
        }
    }

    /// The corners, with their shares, that together went furthest in the last question.
    pub fn mixture(self) -> Vec<(Rational, Corner)> {
        let all = self.shares.into_iter().zip(self.corners);
        all.filter(|(share, _)| !share.is_zero()).collect()
    }

    /// The greatest `l`; none if no mixture is at least the start in the numbers in which the direction is 0.
    ///
    /// (The numbers `counting` must have been asked for together in an all-positive direction before, or the
    /// direction be so itself.)
    pub fn furthest(
        &mut self,
        counting: &[usize],
        direction: &[Rational],
    ) -> Result<Option<Rational>, CheckError> {
        if self.corners.is_empty() {
            let all = vec![Rational::one(); self.from.len()];
            self.corners.push(self.skeleton.best(&all, self.options)?);
        }
        loop {
            self.options.check_cancelled()?;
            let Some((length, weights, shares)) = self.over_corners(counting, direction) else {
                return Ok(None);
            };
            let corner = self.skeleton.best(&weights, self.options)?;
            let reached: Rational = (weights.iter().zip(corner.numbers.iter().zip(&self.from)))
                .map(|(w, (number, start))| w * (number - start))
                .sum();
            if reached <= length {
                self.shares = shares;
                return Ok(Some(length));
            }
            self.corners.push(corner);
        }
    }

    /// The greatest `l` over mixtures of the corners known, the weights that show that there is no greater, and the shares.
    fn over_corners(
        &self,
        counting: &[usize],
        direction: &[Rational],
    ) -> Option<(Rational, Vec<Rational>, Vec<Rational>)> {
        let (corners, slacks) = (self.corners.len(), counting.len());
        // Shares of the corners, `l` and `-l`, and one slack for each number.
        let columns = corners + 2 + slacks;
        let mut rows = Vec::with_capacity(slacks + 1);
        for (place, number) in counting.iter().enumerate() {
            let mut row = vec![Rational::zero(); columns];
            for (column, corner) in self.corners.iter().enumerate() {
                row[column] = &self.from[*number] - &corner.numbers[*number];
            }
            row[corners] = direction[*number].clone();
            row[corners + 1] = -&direction[*number];
            row[corners + 2 + place] = Rational::one();
            rows.push(row);
        }
        let mut shares = vec![Rational::zero(); columns];
        shares[..corners].fill(Rational::one());
        rows.push(shares);
        let mut right = vec![Rational::zero(); slacks];
        right.push(Rational::one());
        let mut cost = vec![Rational::zero(); columns];
        (cost[corners], cost[corners + 1]) = (Rational::one(), -Rational::one());
        let mut solution = maximise(&cost, &rows, &right)?;
        let mut weights = vec![Rational::zero(); self.from.len()];
        for (place, number) in counting.iter().enumerate() {
            weights[*number] = -&solution.reduced[corners + 2 + place];
        }
        solution.point.truncate(corners);
        Some((solution.value, weights, solution.point))
    }
}
