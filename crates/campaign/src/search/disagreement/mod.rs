//! Search for contexts in which a formal model predicts one thing and the simulator shows another.
//!
//! Two stages. First episodes are spread, and then drawn to where a correlated beta process
//! expects the largest difference between the simulated rate and the predicted one, or knows
//! least. Then the most suspicious contexts are tried again with fresh episodes only, all at once,
//! until each is decided:
//!
//! ```text
//! acquisition   |E r(x) - p(x)| + sd r(x)                r(x) simulated rate, p(x) prediction
//! disagrees     the confidence sequence of the rate lies beyond [p - margin, p + margin]
//! agrees        it lies within
//! ```
//!
//! Source: R. Goetschalckx, P. Poupart and J. Hoey, "Continuous correlated beta processes" (2011)
//! for the map; E. Even-Dar, S. Mannor and Y. Mansour (2006) for elimination of what is decided;
//! the confidence sequences are those of [`stats::sequential`], at a level shared among the
//! contexts (C. E. Bonferroni, 1936). Deviation: the process begins at the prediction, with the
//! weight of two episodes, so that disagreement has to be shown. Cost: O(n) for each of 400
//! candidates, O(n^2) to fit lengths; at most 400 predictions more than two an explored episode, and one
//! for each place of a map. Guarantee: the probability that any context is wrongly said to disagree
//! (or to agree) is at most 1 - confidence, however often one looks; the map is an estimate, and
//! that a disagreement is found at all is not guaranteed.

mod confirmation;
mod surrogate;

use serde::{Deserialize, Serialize};
use stats::Confidence;
use stimulus::{Point, Space};

pub use confirmation::{Agreement, Confirmation, Finding};

use super::cube::{Cube, unordered};
use crate::error::CampaignError;
use crate::random::Random;
use surrogate::Surrogate;

/// How many places the search chooses among, beside those that are spread evenly.
const POOL: usize = 400;

/// What a model predicts for a context: a probability.
pub type FormalPrediction<'a> = &'a dyn Fn(&Point) -> f64;

/// How a search for disagreement is done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisagreementOptions {
    /// Episodes for the first stage.
    pub explore: usize,
    /// At most so many contexts are tried again.
    pub contexts: usize,
    /// Differences of probabilities up to this one do not matter.
    pub margin: f64,
    /// Confidence that no context is wrongly decided.
    pub confidence: f64,
}

impl Default for DisagreementOptions {
    /// 300 episodes, 8 contexts, a margin of 0.05, confidence 95 %.
    fn default() -> Self {
        Self {
            explore: 300,
            contexts: 8,
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
/// let mut search = DisagreementSearch::new(space, 1, DisagreementOptions::default())?;
/// for _ in 0..60 {
///     let contexts = search.ask(10, &formal);
///     let outcomes = contexts.into_iter().map(|context| {
///         let rate = if context.0[0] < 0.3 { 0.2 } else { 0.95 };
///         (context, simulator.chance(rate))
///     });
///     search.tell(&outcomes.collect::<Vec<_>>());
/// }
/// let worst = &search.findings()[0];
/// assert_eq!(worst.agreement, Agreement::Disagrees);
/// assert!(worst.context.0[0] < 0.3 && worst.interval.high < 0.9);
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
}

/// One place of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapCell {
    /// The context.
    pub context: Point,
    /// What the model predicts.
    pub predicted: f64,
    /// The simulated rate as the first stage's outcomes suggest it (estimated).
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
        })
    }

    /// The next `count` contexts in which to run an episode; fewer or none when all is decided.
    pub fn ask(&mut self, count: usize, formal: FormalPrediction<'_>) -> Vec<Point> {
        if self.rows.len() >= self.options.explore && self.confirmation.is_none() {
            self.confirmation = Some(self.suspicious_contexts(formal));
        }
        match &mut self.confirmation {
            Some(confirmation) => confirmation.ask(count),
            None => self.explore(count, formal),
        }
    }

    /// What came out in contexts that were asked for: whether what the model gives a probability
    /// for happened. Outcomes have to be told in the order of asking to come again the same.
    pub fn tell(&mut self, outcomes: &[(Point, bool)]) {
        for (context, success) in outcomes {
            if let Some(proposal) = self.cube.settle(context) {
                self.rows.push(proposal.unit);
                self.successes.push(*success);
            } else if let Some(confirmation) = &mut self.confirmation {
                confirmation.tell(context, *success);
            }
        }
    }

    /// Whether there is nothing left to decide.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.confirmation
            .as_ref()
            .is_some_and(Confirmation::is_over)
    }

    /// The contexts of the second stage: those that disagree first, then the undecided, each by
    /// the size of the difference that is sure. Empty during the first stage.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        self.confirmation
            .as_ref()
            .map(Confirmation::findings)
            .unwrap_or_default()
    }

    /// What the first stage suggests over two parameters (by their places), `steps` by `steps`
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

    /// The process of all outcomes of the first stage.
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

    /// The place of the pool where the difference may be largest (the first of equals).
    fn suspicious_point(&mut self, surrogate: &Surrogate) -> Point {
        let score = |(row, predicted): &(Vec<f64>, f64)| {
            let beta = surrogate.at(row, *predicted);
            (beta.mean() - predicted).abs() + beta.sd()
        };
        let scores = self.pool.iter().map(score).enumerate();
        let best = scores.rev().max_by(|a, b| a.1.total_cmp(&b.1));
        let index = best.map_or(0, |(index, _)| index);
        match self.pool.get(index) {
            Some((row, _)) => self.cube.space.at(row),
            None => self.cube.space.nominal(),
        }
    }

    /// The contexts of the largest differences that the process is sure of, far from each other.
    fn suspicious_contexts(&mut self, formal: FormalPrediction<'_>) -> Confirmation {
        let surrogate = self.fitted_surrogate(formal);
        self.fill_pool(formal);
        let tried = self.rows.iter().zip(self.predicted.iter().copied());
        let pool = self.pool.iter().map(|(row, predicted)| (row, *predicted));
        let mut scored: Vec<(f64, Vec<f64>, f64)> = (tried.chain(pool))
            .map(|(row, predicted)| {
                let beta = surrogate.at(row, predicted);
                let sure = (beta.mean() - predicted).abs() - beta.sd();
                (sure, row.clone(), predicted)
            })
            .collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Where a coordinate hardly matters its length is long; contexts may still lie apart in it.
        let metric = surrogate.with_lengths_up_to(surrogate::START_LENGTH);
        let mut chosen: Vec<(Vec<f64>, f64)> = Vec::new();
        for (_, row, predicted) in scored {
            let far = |other: &(Vec<f64>, f64)| metric.distance(&other.0, &row) > 0.5;
            if chosen.len() < self.options.contexts.max(1) && chosen.iter().all(far) {
                chosen.push((row, predicted));
            }
        }
        let contexts = chosen
            .iter()
            .map(|(row, predicted)| (self.cube.space.at(row), *predicted));
        let contexts = contexts.collect();
        Confirmation::of(contexts, self.options.margin, self.options.confidence)
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
        if self.explore == 0 || self.contexts == 0 {
            let problem = "it must be at least 1";
            let name = if self.explore == 0 {
                "explore"
            } else {
                "contexts"
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
