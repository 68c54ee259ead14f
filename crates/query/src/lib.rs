//! One model, many properties: a model of the PRISM language is checked, its answers certified, its states and schedulers
//! written, and the work ended early with what it has.
//!
//! ```
//! use host::{BuildId, Host};
//! use query::{CheckRequest, ModelInput, check};
//!
//! let model = "dtmc module m x : [0..2]; [] x=0 -> 0.75:(x'=1) + 0.25:(x'=2); endmodule";
//! let request = CheckRequest::new(ModelInput::text("grip.prism", model))
//!     .property("P=? [ F x=1 ]");
//! let host = Host::silent(BuildId::new("example"));
//! let report = check(&request, &host, &|_| Ok(()))
//!     .and_then(query::Checked::into_report)
//!     .expect("a model without mistakes");
//! let answer = &report.properties[0];
//! assert!(answer.low.unwrap() <= 0.75 && 0.75 <= answer.high.unwrap());
//! ```
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
