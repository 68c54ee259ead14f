//! Independent draws from the declared distributions: what a guided search has to be better than.
//!
//! Definition: point i is drawn from the space, whatever was told of points before it. Cost: O(d) a point.
//! Guarantee: the share of points that violate is an unbiased estimate over the declared distributions.

use serde::{Deserialize, Serialize};
use stimulus::{Point, Space};

use super::cube::orderly;
use super::{Best, Evaluated, Search};
use crate::design::{Design, Sampler};
use crate::error::CampaignError;

/// A search that does not learn.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RandomSearch {
    sampler: Sampler,
    /// Stands in where the constraints reject all draws.
    feasible: Point,
    best: Best,
}

impl RandomSearch {
    /// A search over `space`.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the constraints.
    pub fn new(space: Space, seed: u64) -> Result<Self, CampaignError> {
        let sampler = Sampler::new(space, Design::Random, seed);
        let feasible = sampler.clone().ask(1)?.pop().unwrap_or(Point(Vec::new()));
        Ok(Self {
            sampler,
            feasible,
            best: Best::default(),
        })
    }
}

impl Search for RandomSearch {
    fn ask(&mut self, count: usize) -> Vec<Point> {
        let asked = self.sampler.ask(count);
        asked.unwrap_or_else(|_| vec![self.feasible.clone(); count])
    }

    fn tell(&mut self, results: &[(Point, f64)]) {
        for (point, value) in results {
            if point.0.len() == self.sampler.space().dimensions() {
                self.best.tell(point, orderly(*value));
            }
        }
    }

    fn best(&self) -> Option<&Evaluated> {
        self.best.best.as_ref()
    }

    fn recommend(&self) -> Option<Point> {
        self.best().map(|best| best.point.clone())
    }
}
