//! Which stimuli to run next, and what the outcomes so far say.

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
    Prediction, Search, Searcher,
};
pub use shrink::{NotShown, ShrinkOptions, Shrunk, Size, shrink};
pub use stopping::{Stop, Stopping, StoppingRule};
