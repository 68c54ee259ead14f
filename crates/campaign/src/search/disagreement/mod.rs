//! Search for contexts in which a formal model predicts one thing and the simulator shows another.
//!
//! Three steps. First episodes are spread, and then drawn to where a correlated beta process
//! expects the largest difference between the simulated rate and the predicted one, or knows
//! least. What came out then cuts all contexts into regions. Then the regions are tried with
//! fresh episodes only, which go where a difference may be shown soonest, until each is decided:
//!
//! ```text
//! acquisition   |E r(x) - p(x)| + sd r(x)                r(x) simulated rate, p(x) prediction
//!               1.96 sd r(x) - | |E r(x) - p(x)| - margin |   in turn, and evenly spread
//! regions       boxes, cut where outcomes nearby less p(x) change most
//! differs       the confidence sequence of a region's rate lies beyond [p - margin, p + margin]
//! agrees        it lies within
//! ```
//!
//! Source: R. Goetschalckx, P. Poupart and J. Hoey, "Continuous correlated beta processes" (2011)
//! and B. Bryan and others, "Active learning for identifying function threshold boundaries" (2005),
//! for the first step; `region.rs` and `confirmation.rs` name those of the others. Deviation: the
//! process begins at the prediction, with the weight of two episodes, so that disagreement has to
//! be shown. Cost: O(n) for each of 400 candidates, O(n^2) to fit lengths; at most 400 predictions
//! more than two an explored episode, 128 a region, and one for each place of a map. Guarantee: the
//! probability that any region is wrongly said to differ (or to agree) is at most 1 - confidence,
//! however often one looks. A region is decided as a whole: contexts within one that agrees can
//! differ in both directions. The map is an estimate, and that a difference is found at all is not
//! guaranteed.

mod confirmation;
mod region;
mod surrogate;

use serde::{Deserialize, Serialize};
use stats::Confidence;
use stimulus::{Point, Space};

pub use confirmation::{Agreement, Confirmation, Finding, Question};
pub use region::Region;

use super::cube::{Cube, unordered};
use crate::error::CampaignError;
use crate::random::Random;
use region::Expected;
use surrogate::Surrogate;

/// How many places the search chooses among, beside those that are spread evenly.
const POOL: usize = 400;

/// At how many places a difference is expected, where regions are cut.
const PLACES: usize = 1000;

/// Deviations within which a difference may lie, where the edge of what differs is looked for.
const STRADDLE: f64 = 1.96;

/// How many contexts of a region give the mean of its predictions.
const PREDICTIONS: usize = 128;

/// How often a context of a region is drawn again if constraints do not hold there.
const PATIENCE: usize = 1000;

/// What a model predicts for a context: a probability.
pub type FormalPrediction<'a> = &'a dyn Fn(&Point) -> f64;

/// How a search for disagreement is done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisagreementOptions {
    /// Episodes for the first step.
    pub explore: usize,
    /// All contexts are cut into at most so many regions.
    pub regions: usize,
    /// Differences of probabilities up to this one do not matter.
    pub margin: f64,
    /// Confidence that no region is wrongly decided.
    pub confidence: f64,
}

impl Default for DisagreementOptions {
    /// 300 episodes, 8 regions, a margin of 0.05, confidence 95 %.
    fn default() -> Self {
        Self {
            explore: 300,
            regions: 8,
            margin: 0.05,
            confidence: 0.95,
        }
    }
}

/// A search for disagreement, asked for contexts and told outcomes.
///
/// ```
/// use campaign::{Agreement, DisagreementOptions, DisagreementSearch, Random};
/// let space = stimulus::Space::from_toml(r#"
///     [[parameter]]
///     name = "friction"
///     sets = ["hand.friction"]
///     uniform = [0.0, 1.0]
///     "#)?;
/// // The model says that 95 of 100 succeed; in fact nearly none does when friction is low.
/// let formal = |_: &stimulus::Point| 0.95;
/// let mut simulator = Random::new(1, "simulator");
/// let mut search = DisagreementSearch::new(space.clone(), 1, DisagreementOptions::default())?;
/// for _ in 0..60 {
///     let contexts = search.ask(10, &formal);
///     let outcomes = contexts.into_iter().map(|context| {
///         let rate = if context.0[0] < 0.3 { 0.2 } else { 0.95 };
///         (context, Some(simulator.chance(rate)))
///     });
///     search.tell(&outcomes.collect::<Vec<_>>());
/// }
/// let worst = &search.findings()[0];
/// assert_eq!(worst.agreement, Agreement::Differs);
/// let [from, _] = worst.region.ranges(&space)[0];
/// assert!(from < 0.3 && worst.interval.high < 0.9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DisagreementSearch {
    cube: Cube,
    seed: u64,
    random: Random,
    options: DisagreementOptions,
    asked: usize,
    rows: Vec<Vec<f64>>,
    successes: Vec<bool>,
    predicted: Vec<f64>,
    /// Places to choose among with what the model predicts there: a prediction can take a model
    /// checker's run, so that each is asked for once.
    pool: Vec<(Vec<f64>, f64)>,
    /// The map's lengths, and how many outcomes there were when they were fitted.
    lengths: Vec<f64>,
    fitted_at: usize,
    confirmation: Option<Confirmation>,
    /// Fresh episodes that run, with their regions.
    fresh: Vec<(Point, usize)>,
}

/// One place of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapCell {
    /// The context.
    pub context: Point,
    /// What the model predicts.
    pub predicted: f64,
    /// The simulated rate as the first step's outcomes suggest it (estimated).
    pub simulated: f64,
    /// Standard deviation of that estimate.
    pub sd: f64,
}

impl DisagreementSearch {
    /// A search over the contexts of a space.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] for options out of range; [`CampaignError::TooTight`] when no
    /// point meets the constraints.
    pub fn new(
        space: Space,
        seed: u64,
        options: DisagreementOptions,
    ) -> Result<Self, CampaignError> {
        options.check()?;
        let cube = Cube::new(space, seed)?;
        Ok(Self {
            lengths: vec![surrogate::START_LENGTH; cube.dimensions()],
            cube,
            seed,
            random: Random::new(seed, "disagreement"),
            options,
            asked: 0,
            rows: Vec::new(),
            successes: Vec::new(),
            predicted: Vec::new(),
            pool: Vec::new(),
            fitted_at: 0,
            confirmation: None,
            fresh: Vec::new(),
        })
    }

    /// The next `count` contexts in which to run an episode; fewer or none when all is decided.
    pub fn ask(&mut self, count: usize, formal: FormalPrediction<'_>) -> Vec<Point> {
        let left = self.options.explore.saturating_sub(self.asked);
        if left > 0 {
            return self.explore(count.min(left), formal);
        }
        if self.confirmation.is_none() {
            self.confirmation = Some(self.questions(formal));
        }
        let mut points = Vec::with_capacity(count);
        while points.len() < count {
            let Some(index) = self.confirmation.as_mut().and_then(Confirmation::ask) else {
                break;
            };
            let point = self.fresh_point(index);
            self.fresh.push((point.clone(), index));
            points.push(point);
        }
        points
    }

    /// What came out in contexts that were asked for: whether what the model gives a probability
    /// for happened, or `None` if that could not be judged. Outcomes have to be told in the order
    /// of asking to come again the same.
    pub fn tell(&mut self, outcomes: &[(Point, Option<bool>)]) {
        for (context, outcome) in outcomes {
            if let Some(proposal) = self.cube.settle(context) {
                if let Some(success) = outcome {
                    self.rows.push(proposal.unit);
                    self.successes.push(*success);
                }
            } else if let Some(place) = self.fresh.iter().position(|(p, _)| p == context) {
                let (_, index) = self.fresh.remove(place);
                if let Some(confirmation) = &mut self.confirmation {
                    confirmation.tell(index, *outcome);
                }
            }
        }
    }

    /// How many episodes led to the regions.
    #[must_use]
    pub fn explored(&self) -> usize {
        self.asked
    }

    /// Whether there is nothing left to decide.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.confirmation
            .as_ref()
            .is_some_and(Confirmation::is_over)
    }

    /// The regions: those that differ first, then the undecided, each by the size of the difference
    /// that is sure. Empty during the first step.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        self.confirmation
            .as_ref()
            .map(Confirmation::findings)
            .unwrap_or_default()
    }

    /// What the first step suggests over two parameters (by their places), `steps` by `steps`
    /// values each, row by row of the second one; the others are at their nominal values.
    /// Places where constraints do not hold are left out.
    #[must_use]
    pub fn map(
        &self,
        across: usize,
        down: usize,
        steps: usize,
        formal: FormalPrediction<'_>,
    ) -> Vec<MapCell> {
        let space = &self.cube.space;
        let surrogate = self.surrogate(formal);
        let nominal = space.unit_of(&space.nominal());
        let place = |step: usize| (step as f64 + 0.5) / steps as f64;
        let mut cells = Vec::with_capacity(steps * steps);
        for (row, column) in (0..steps).flat_map(|r| (0..steps).map(move |c| (r, c))) {
            let mut unit = nominal.clone();
            for (index, step) in [(down, row), (across, column)] {
                if let Some(coordinate) = unit.get_mut(index) {
                    *coordinate = place(step);
                }
            }
            let context = space.at(&unit);
            if !space.meets_constraints(&context) {
                continue;
            }
            let predicted = formal(&context);
            let beta = surrogate.at(&space.unit_of(&context), predicted);
            cells.push(MapCell {
                context,
                predicted,
                simulated: beta.mean(),
                sd: beta.sd(),
            });
        }
        cells
    }

    fn unordered(&self) -> Vec<bool> {
        self.cube.parameters().map(unordered).collect()
    }

    /// The process of all outcomes of the first step.
    fn surrogate(&self, formal: FormalPrediction<'_>) -> Surrogate {
        let mut surrogate = Surrogate::new(self.lengths.clone(), self.unordered());
        for (index, (row, success)) in self.rows.iter().zip(&self.successes).enumerate() {
            let known = self.predicted.get(index).copied();
            let predicted = known.unwrap_or_else(|| formal(&self.cube.space.at(row)));
            surrogate.push(row, f64::from(u8::from(*success)), predicted);
        }
        surrogate
    }

    fn explore(&mut self, count: usize, formal: FormalPrediction<'_>) -> Vec<Point> {
        let mut surrogate = self.fitted_surrogate(formal);
        for proposal in self.cube.open() {
            let predicted = self.prediction_at(&proposal.unit, &proposal.point, formal);
            let expected = surrogate.at(&proposal.unit, predicted).mean();
            surrogate.push(&proposal.unit, expected, predicted);
        }
        // A third is spread evenly: what no suspicion leads to has to be seen as well.
        let mut points = Vec::with_capacity(count);
        for _ in 0..count {
            let spread =
                self.asked < 2 * self.cube.dimensions() + 10 || self.asked.is_multiple_of(3);
            let point = match spread {
                true => self.spread_point(),
                false => {
                    self.fill_pool(formal);
                    self.suspicious_point(&surrogate)
                }
            };
            let unit = self.cube.space.unit_of(&point);
            let predicted = self.prediction_at(&unit, &point, formal);
            let expected = surrogate.at(&unit, predicted).mean();
            surrogate.push(&unit, expected, predicted);
            self.asked += 1;
            points.push(point.clone());
            self.cube.propose(point, unit, 0);
        }
        points
    }

    /// The process, its lengths fitted anew when there is a quarter more data than at the last
    /// time.
    fn fitted_surrogate(&mut self, formal: FormalPrediction<'_>) -> Surrogate {
        for index in self.predicted.len()..self.rows.len() {
            let row = &self.rows[index];
            let predicted = self.prediction_at(row, &self.cube.space.at(row), formal);
            self.predicted.push(predicted);
        }
        let mut surrogate = self.surrogate(formal);
        if self.rows.len() >= (self.fitted_at + self.fitted_at / 4).max(20) {
            surrogate.fit_lengths();
            self.lengths = surrogate.lengths().to_vec();
            self.fitted_at = self.rows.len();
        }
        surrogate
    }

    /// What the model predicts, from the pool where it is known.
    fn prediction_at(&self, unit: &[f64], point: &Point, formal: FormalPrediction<'_>) -> f64 {
        let known = self.pool.iter().find(|(row, _)| row == unit);
        known.map_or_else(|| formal(point), |(_, predicted)| *predicted)
    }

    fn spread_point(&mut self) -> Point {
        let (seed, dimensions) = (self.seed, self.cube.dimensions());
        let mut index = self.asked as u64;
        let (_, point) = self.cube.draw(&mut self.random, |_| {
            let row = stats::design_from(index, 1, dimensions, seed)
                .pop()
                .unwrap_or_default();
            // Rejected places are left for ones far along the sequence.
            index += 1_000_000;
            (row.clone(), row)
        });
        point
    }

    /// Fills the pool, the first time.
    fn fill_pool(&mut self, formal: FormalPrediction<'_>) {
        let missing = POOL - self.pool.len().min(POOL);
        for _ in 0..missing {
            let row = self.spread_candidate();
            let predicted = formal(&self.cube.space.at(&row));
            self.pool.push((row, predicted));
        }
    }

    /// The place of the pool where the difference may be largest or, every other time, where it is
    /// least clear whether it is beyond the margin (the first of equals).
    fn suspicious_point(&mut self, surrogate: &Surrogate) -> Point {
        let (margin, at_the_edge) = (self.options.margin, self.asked % 3 == 2);
        let score = |(row, predicted): &(Vec<f64>, f64)| {
            let beta = surrogate.at(row, *predicted);
            let difference = (beta.mean() - predicted).abs();
            match at_the_edge {
                true => STRADDLE * beta.sd() - (difference - margin).abs(),
                false => difference + beta.sd(),
            }
        };
        let scores = self.pool.iter().map(score).enumerate();
        let best = scores.rev().max_by(|a, b| a.1.total_cmp(&b.1));
        let index = best.map_or(0, |(index, _)| index);
        match self.pool.get(index) {
            Some((row, _)) => self.cube.space.at(row),
            None => self.cube.space.nominal(),
        }
    }

    /// The regions that what was explored cuts all contexts into.
    fn questions(&mut self, formal: FormalPrediction<'_>) -> Confirmation {
        let surrogate = self.fitted_surrogate(formal);
        let surrogate = surrogate.with_lengths_up_to(surrogate::LOCAL_LENGTH);
        let space = &self.cube.space;
        let rows = stats::design(PLACES, self.cube.dimensions(), self.seed);
        let expected = rows.iter().map(|row| {
            let unit = space.unit_of(&space.at(row));
            Expected {
                difference: surrogate.local_difference(&unit),
                unit,
            }
        });
        let expected: Vec<Expected> = expected.collect();
        let DisagreementOptions {
            regions,
            margin,
            confidence,
            ..
        } = self.options;
        let regions = region::partition(space, &expected, regions, margin);
        let questions = regions.into_iter().map(|region| {
            let (predicted, predicted_error) = self.mean_prediction(&region, formal);
            Question {
                region,
                predicted,
                predicted_error,
            }
        });
        Confirmation::new(questions.collect(), margin, confidence)
    }

    /// The mean of the predictions in a region, over evenly spread contexts, and twice the standard
    /// error that as many random ones would have.
    fn mean_prediction(&self, region: &Region, formal: FormalPrediction<'_>) -> (f64, f64) {
        let space = &self.cube.space;
        let rows = stats::design(PREDICTIONS, self.cube.dimensions(), self.seed);
        let contexts = rows
            .iter()
            .map(|row| region::context_at(region, space, row));
        let allowed = contexts.filter(|context| space.meets_constraints(context));
        let values: Vec<f64> = allowed.map(|context| formal(&context)).collect();
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let all_alike = values.windows(2).all(|pair| pair[0] == pair[1]);
        match (values.first(), all_alike) {
            // Nothing is known of a region without contexts, and nothing is lost.
            (None, _) => (0.5, 1.0),
            (Some(value), true) => (*value, 0.0),
            _ => (mean, 2.0 * squares.sqrt() / count),
        }
    }

    /// A context of a region, drawn from the declared distributions.
    fn fresh_point(&mut self, index: usize) -> Point {
        let dimensions = self.cube.dimensions();
        let region = self.confirmation.as_ref().and_then(|it| it.region(index));
        let region = region.cloned().unwrap_or_else(|| Region::whole(dimensions));
        let space = &self.cube.space;
        for _ in 0..PATIENCE {
            let row: Vec<f64> = (0..dimensions).map(|_| self.random.open_unit()).collect();
            let point = region::context_at(&region, space, &row);
            if space.meets_constraints(&point) {
                return point;
            }
        }
        // No context of the region is allowed, or hardly any: one that is explored already.
        let inside = self.pool.iter().find(|(row, _)| region.holds(row));
        inside.map_or_else(|| space.nominal(), |(row, _)| space.at(row))
    }

    fn spread_candidate(&mut self) -> Vec<f64> {
        let dimensions = self.cube.dimensions();
        let (_, point) = self.cube.draw(&mut self.random, |random| {
            let row: Vec<f64> = (0..dimensions).map(|_| random.open_unit()).collect();
            (row.clone(), row)
        });
        self.cube.space.unit_of(&point)
    }
}

impl DisagreementOptions {
    fn check(&self) -> Result<(), CampaignError> {
        if !(0.0..1.0).contains(&self.margin) {
            let problem = "it must be at least 0 and below 1";
            return Err(CampaignError::setting("margin", problem));
        }
        if self.explore == 0 || self.regions == 0 {
            let problem = "it must be at least 1";
            let name = if self.explore == 0 {
                "explore"
            } else {
                "regions"
            };
            return Err(CampaignError::setting(name, problem));
        }
        match Confidence::new(self.confidence) {
            Ok(_) => Ok(()),
            Err(error) => Err(CampaignError::setting("confidence", error.to_string())),
        }
    }
}

#[cfg(test)]
mod tests;
