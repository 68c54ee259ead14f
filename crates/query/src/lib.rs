#![doc = include_str!("../README.md")]
//!
//! The request is plain data ([`CheckRequest`]), the report serializes by `schemas/check.schema.json` ([`CheckReport`]). An answer
//! without its guarantee does not exist: each says whether it is exact, bounded, statistical or estimated.

mod certify;
mod check;
mod distributions;
mod ending;
mod explicit;
mod explore;
mod export;
mod parametric;
mod properties;
mod ranges;
mod report;
mod request;
mod results;
mod rounded;
mod strategy;
mod written;

pub use certify::CertificateReport;
pub use check::{Checked, check, write_results};
pub use explore::{explore, explore_within};
pub use export::Print;
pub use parametric::{ConditionReport, ParametricReport, PartReport, RangeReport, ValueReport};
pub use report::{
    Built, CheckReport, DistributionReport, PrintedState, PropertyReport, StateProbability,
    WitnessReport,
};
pub use request::{CheckRequest, Exports, ModelInput, PropertyInput};
pub use strategy::{DecisionReport, StrategyReport};
pub use written::number;
