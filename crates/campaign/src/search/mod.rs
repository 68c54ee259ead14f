//! Search for the stimulus of smallest value, such as the robustness of a requirement: below zero
//! it is violated.
//!
//! All searches are asked for points and told their values, in any portions and in any order, so
//! that episodes can run elsewhere, in parallel, and a campaign can be interrupted: a search is
//! plain data that can be written down and resumed.
//!
//! | method | good for | source |
//! |---|---|---|
//! | [`CrossEntropy`] | mixed spaces, many cheap noisy episodes | R. Y. Rubinstein (1999) |
//! | [`CmaEs`] | continuous spaces, hundreds to thousands of episodes, correlated parameters | N. Hansen (2016) |
//! | [`RandomSearch`] | what the others have to be better than | |
//! | [`Bayesian`] | few (up to some hundreds of) expensive episodes, noise | D. R. Jones, M. Schonlau and W. J. Welch (1998) |
//!
//! A search stays within the declared ranges and constraints, and within the inner 99.8 % of a
//! distribution that has no limits. Values of episodes are random. A violation that was found is a violation, whatever the noise:
//! its stimulus and seed replay it. A *smallest value* is not: the best of many noisy values is
//! too good to be true, so [`Search::recommend`] gives the point that the search trusts, which
//! fresh seeds then have to confirm.

mod bayesian;
mod cma_es;
mod cross_entropy;
mod cube;
mod disagreement;
pub(crate) mod eigen;
mod gaussian_process;
mod random_search;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stimulus::{Point, Space};

pub use bayesian::Bayesian;
pub use cma_es::CmaEs;
pub use cross_entropy::CrossEntropy;
pub use disagreement::{
    Agreement, Confirmation, DisagreementOptions, DisagreementSearch, Finding, FormalPrediction,
    MapCell, Question, Region,
};
pub use gaussian_process::{GaussianProcess, Prediction};
pub use random_search::RandomSearch;

use crate::error::CampaignError;

/// What is asked for points and told values.
pub trait Search {
    /// The next `count` points to evaluate.
    fn ask(&mut self, count: usize) -> Vec<Point>;

    /// What became of points; points that are none of the space are left out. A value that is no number counts as the largest, for example where a
    /// requirement was not triggered and has no robustness.
    fn tell(&mut self, results: &[(Point, f64)]);

    /// The smallest value that was told, with its point. With noise it is too good to be true.
    fn best(&self) -> Option<&Evaluated>;

    /// The point that the search expects to have the smallest mean value.
    fn recommend(&self) -> Option<Point>;
}

/// A point and the value that was told for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluated {
    /// The point.
    pub point: Point,
    /// Its value, cut to within 1e12 of zero.
    pub value: f64,
    /// Its place among all that was told, from 0.
    pub index: u64,
}

/// Keeps the best of what is told.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Best {
    best: Option<Evaluated>,
    told: u64,
}

impl Best {
    fn tell(&mut self, point: &Point, value: f64) {
        if self.best.as_ref().is_none_or(|best| value < best.value) {
            self.best = Some(Evaluated {
                point: point.clone(),
                value,
                index: self.told,
            });
        }
        self.told += 1;
    }
}

/// Which search to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// [`CrossEntropy`].
    CrossEntropy,
    /// [`CmaEs`].
    CmaEs,
    /// [`Bayesian`].
    Bayesian,
    /// [`RandomSearch`].
    Random,
}

/// A search of any method, as data.
///
/// ```
/// use campaign::{Method, Search, Searcher};
/// let space = stimulus::Space::from_toml(r#"
///     [[parameter]]
///     name = "force"
///     sets = ["force"]
///     uniform = [0.0, 10.0]
///     "#)?;
/// let mut search = Searcher::new(Method::Bayesian, space, 1)?;
/// for _ in 0..10 {
///     let points = search.ask(2);
///     let told: Vec<_> = points.into_iter().map(|p| { let y = (p.0[0] - 7.3).powi(2); (p, y) }).collect();
///     search.tell(&told);
/// }
/// assert!((search.best().unwrap().point.0[0] - 7.3).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Searcher {
    /// Cross-entropy.
    CrossEntropy(Box<CrossEntropy>),
    /// Covariance matrix adaptation.
    CmaEs(Box<CmaEs>),
    /// Bayesian optimisation.
    Bayesian(Box<Bayesian>),
    /// Independent draws.
    Random(Box<RandomSearch>),
}

impl Searcher {
    /// A search of this method with its default settings.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when no point meets the space's constraints.
    pub fn new(method: Method, space: Space, seed: u64) -> Result<Self, CampaignError> {
        Ok(match method {
            Method::CrossEntropy => Self::CrossEntropy(Box::new(CrossEntropy::new(space, seed)?)),
            Method::CmaEs => Self::CmaEs(Box::new(CmaEs::new(space, seed)?)),
            Method::Bayesian => Self::Bayesian(Box::new(Bayesian::new(space, seed)?)),
            Method::Random => Self::Random(Box::new(RandomSearch::new(space, seed)?)),
        })
    }

    fn search(&self) -> &dyn Search {
        match self {
            Self::CrossEntropy(search) => search.as_ref(),
            Self::CmaEs(search) => search.as_ref(),
            Self::Bayesian(search) => search.as_ref(),
            Self::Random(search) => search.as_ref(),
        }
    }

    fn search_mut(&mut self) -> &mut dyn Search {
        match self {
            Self::CrossEntropy(search) => search.as_mut(),
            Self::CmaEs(search) => search.as_mut(),
            Self::Bayesian(search) => search.as_mut(),
            Self::Random(search) => search.as_mut(),
        }
    }
}

impl Search for Searcher {
    fn ask(&mut self, count: usize) -> Vec<Point> {
        self.search_mut().ask(count)
    }

    fn tell(&mut self, results: &[(Point, f64)]) {
        self.search_mut().tell(results);
    }

    fn best(&self) -> Option<&Evaluated> {
        self.search().best()
    }

    fn recommend(&self) -> Option<Point> {
        self.search().recommend()
    }
}

#[cfg(test)]
mod tests;
