#![doc = include_str!("../README.md")]
//!
//! | you want | use |
//! |---|---|
//! | points of a parameter space, spread evenly, by chance, or at its limits | [`Sampler`] |
//! | the stimulus that comes nearest to a violation | [`Searcher`]: cross-entropy, CMA-ES, Bayesian optimisation |
//! | contexts in which a formal model and a simulator disagree | [`DisagreementSearch`], [`Confirmation`] |
//! | abstract tests | [`Grammar`], [`Agent`], [`PathMapping`] |
//! | what was covered, what is missing, and whether more episodes pay | [`Coverage`], [`SetCoverage`], [`Lcov`], [`Saturation`] |
//! | the smallest stimulus that still shows it | [`shrink()`] |
//! | the probability of what hardly ever happens | [`splitting`] |
//! | simulator parameters that fit counts | [`calibration`] |
//! | when to stop | [`stopping`] |
//!
//! Episodes that a search or a boundary design chose are witnesses. Rates counted over them are
//! biased, and say nothing about use: only random and low-discrepancy designs follow the declared
//! distributions.
//!
//! # Towards what is missing
//!
//! ```
//! use campaign::{Coverage, CoverageModel, Design, Sampler};
//! use stimulus::{Point, Space};
//!
//! let space = Space::from_toml(
//!     "[[parameter]]\nname = \"speed\"\nsets = [\"speed\"]\ntriangular = [0.0, 0.2, 2.0]")?;
//! let model = CoverageModel::from_toml(
//!     "[[variable]]\nname = \"speed\"\nedges = [0, 0.5, 1, 1.5, 2]\nunit = \"m/s\"\n\
//!      [[cross]]\nname = \"speeds\"\nof = [\"speed\"]")?;
//! let speed = model.variables[0].clone();
//! let situation = |point: &Point| [("speed".to_owned(), speed.label_of(point.0[0]).unwrap_or_default())].into();
//! let mut coverage = Coverage::new(model);
//! let mut sampler = Sampler::new(space, Design::LowDiscrepancy, 1);
//! for point in sampler.ask(4)? {
//!     coverage.record(&[situation(&point)])?;
//! }
//! // Whatever is still missing is asked for: points that lie in the largest hole.
//! while let Some(hole) = coverage.holes("speeds", 1)?.first() {
//!     let points = sampler.ask_where(1, &|point| hole.holds(&situation(point)))?;
//!     coverage.record(&[situation(&points[0])])?;
//! }
//! assert_eq!(coverage.share("speeds")?.rate(), Some(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibration;
pub mod coverage;
pub mod design;
mod error;
pub mod generate;
mod random;
pub mod search;
pub mod shrink;
pub mod splitting;
pub mod stopping;

pub use coverage::{
    Coverage, CoverageModel, Cross, FileCoverage, Hole, Lcov, NewBin, Saturation, SetCoverage,
    Share, Situation, Variable, Visits,
};
pub use design::{Design, Sampler, centred_discrepancy};
pub use error::CampaignError;
pub use generate::{
    ActionPattern, Agent, Alternative, Cover, FromPath, Grammar, Known, PathMapping, PathStep,
    Plan, Rule, StepRule, Values, smallest_cover,
};
pub use random::Random;
pub use search::{
    Agreement, Bayesian, CmaEs, Confirmation, CrossEntropy, DisagreementOptions,
    DisagreementSearch, Evaluated, Finding, FormalPrediction, GaussianProcess, MapCell, Method,
    Prediction, Question, RandomSearch, Region, Search, Searcher,
};
pub use shrink::{NotShown, ShrinkOptions, Shrunk, Size, shrink};
pub use stopping::{Stop, Stopping, StoppingRule};
