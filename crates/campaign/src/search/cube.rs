//! The unit cube in which searches work: which coordinates are discrete, what is allowed, which
//! proposals are open.

use serde::{Deserialize, Serialize};
use stimulus::{Distribution, Options, Parameter, Point, Space};

use crate::design::{Design, Sampler, TAIL};
use crate::error::CampaignError;
use crate::random::Random;

/// How often a proposal that breaks a constraint is drawn again before a known point stands in.
const PATIENCE: usize = 1000;

/// A space seen as a unit cube, with the proposals that have no value yet.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Cube {
    pub(crate) space: Space,
    /// Coordinates of a point that meets the constraints.
    feasible: Vec<f64>,
    open: Vec<Proposal>,
}

/// A proposed point, with the coordinates of the search that it stands for.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Proposal {
    pub(crate) point: Point,
    /// Coordinates that the algorithm learns from; for a discrete parameter not its cell's middle.
    pub(crate) unit: Vec<f64>,
    /// A number of the algorithm's own: the generation that it belongs to.
    pub(crate) generation: u64,
}

impl Cube {
    /// # Errors
    /// [`CampaignError::TooTight`] when no point that meets the constraints is found.
    pub(crate) fn new(space: Space, seed: u64) -> Result<Self, CampaignError> {
        let mut sampler = Sampler::new(space, Design::LowDiscrepancy, seed);
        let feasible = sampler.ask(1)?.pop().unwrap_or(Point(Vec::new()));
        let space = sampler.space().clone();
        Ok(Self {
            feasible: space.unit_of(&feasible),
            space,
            open: Vec::new(),
        })
    }

    pub(crate) fn dimensions(&self) -> usize {
        self.space.dimensions()
    }

    pub(crate) fn parameters(&self) -> impl Iterator<Item = &Parameter> {
        self.space.parameters.iter()
    }

    /// The point at coordinates of the cube. Where a distribution has no limit, the outermost
    /// thousandth of it is left out: a search would go there, and find what never happens.
    pub(crate) fn at(&self, unit: &[f64]) -> Point {
        let pairs = unit.iter().zip(&self.space.parameters);
        let inner: Vec<f64> = pairs
            .map(|(u, parameter)| within_tails(*u, parameter))
            .collect();
        self.space.at(&inner)
    }

    /// Coordinates of a point that was not proposed here; `None` if it is none of the space.
    pub(crate) fn unit_of(&self, point: &Point) -> Option<Vec<f64>> {
        let fits = point.0.len() == self.dimensions() && point.0.iter().all(|x| x.is_finite());
        fits.then(|| self.space.unit_of(point))
    }

    /// Draws until the constraints are met. A draw is what the algorithm learns from, and the
    /// coordinates of the cube that become the point (which can differ by folding and noise).
    pub(crate) fn draw(
        &self,
        random: &mut Random,
        mut one: impl FnMut(&mut Random) -> (Vec<f64>, Vec<f64>),
    ) -> (Vec<f64>, Point) {
        for _ in 0..PATIENCE {
            let (learned, unit) = one(random);
            let point = self.at(&unit);
            if self.space.meets_constraints(&point) {
                return (learned, point);
            }
        }
        (self.feasible.clone(), self.at(&self.feasible))
    }

    pub(crate) fn propose(&mut self, point: Point, unit: Vec<f64>, generation: u64) {
        self.open.push(Proposal {
            point,
            unit,
            generation,
        });
    }

    /// Coordinates of proposals that have no value yet.
    pub(crate) fn open(&self) -> &[Proposal] {
        &self.open
    }

    /// Takes the oldest proposal of this very point; `None` if it was not proposed here.
    pub(crate) fn settle(&mut self, point: &Point) -> Option<Proposal> {
        let index = self.open.iter().position(|p| p.point == *point)?;
        Some(self.open.remove(index))
    }

    /// The coordinates with which a point was proposed, which is settled by this, or those of a
    /// point from elsewhere; `None` if it is none of the space.
    pub(crate) fn settled_unit(&mut self, point: &Point) -> Option<Vec<f64>> {
        let elsewhere = self.unit_of(point)?;
        let proposal = self.settle(point);
        Some(proposal.map_or(elsewhere, |proposal| proposal.unit))
    }
}

fn within_tails(u: f64, parameter: &Parameter) -> f64 {
    let [low, high] = parameter.distribution.support();
    let from = if low.is_finite() { 0.0 } else { TAIL };
    let to = if high.is_finite() { 1.0 } else { 1.0 - TAIL };
    u.clamp(from, to)
}

/// How many values a parameter has, if they are few enough to be told apart one by one.
pub(crate) fn few_values(parameter: &Parameter) -> Option<usize> {
    let count = parameter.distribution.cardinality()?;
    usize::try_from(count).ok().filter(|count| *count <= 32)
}

/// Whether the order of a parameter's values means nothing.
pub(crate) fn unordered(parameter: &Parameter) -> bool {
    matches!(
        parameter.distribution,
        Distribution::Choice {
            options: Options::Labels(_),
            ..
        }
    )
}

/// Folds a number into [0, 1] by reflection at both ends.
pub(crate) fn reflect(x: f64) -> f64 {
    let phase = x.rem_euclid(2.0);
    if phase > 1.0 { 2.0 - phase } else { phase }
}

/// A value that algorithms can order and average: what is no number or infinite counts as the
/// largest (nothing was near a violation) or the smallest finite one.
pub(crate) fn orderly(value: f64) -> f64 {
    const LARGEST: f64 = 1e12;
    if value.is_nan() {
        LARGEST
    } else {
        value.clamp(-LARGEST, LARGEST)
    }
}
