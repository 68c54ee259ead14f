//! Refinement: from what a study's evidence disagrees on to patches of its assets' texts.
//!
//! A change is of one text: a formal model ([`ModelChange`]), the requirements' forms ([`FormChange`]), the ledger, a
//! scene or a table ([`TextChange`]). It is made on the text, at the places that it touches, and a change of a model is
//! solved before it is offered, by whatever [`Solver`] the caller has. [`Ground::against`] says what is offered
//! against the suspects of [`evidence::rank`], [`Ground::of_model`] what a model's failures ask for.
//!
//! Nothing here reads or writes files, or runs a technique.
//!
//! ```
//! use evidence::Subject;
//! use refinement::{Counts, ModelChange, Solver, Values, unified};
//!
//! // A solver that knows one model: here anything that answers will do.
//! struct Known;
//! impl Solver for Known {
//!     fn values(&self, _text: &str) -> Result<Values, String> {
//!         Ok([(Subject::FailureMode("slip".into()), Some(0.03))].into())
//!     }
//! }
//! let model = "dtmc\nconst double pSlip = 0.05;\nmodule m\n s : [0..2] init 0;\n \
//!              [] s=0 -> pSlip:(s'=1) + 1-pSlip:(s'=2);\nendmodule\n";
//! let change = ModelChange::Rate {
//!     mode: "slip".into(),
//!     occurs: "s=1".into(),
//!     counts: Counts { evidence: "lab".into(), count: 3, trials: 100 },
//! };
//! let changed = change.make(model, &Known)?;
//! assert_eq!(changed.what, "pSlip set to 3 of 100 in lab");
//! assert!(unified("a", "b", model, &changed.text).contains("+const double pSlip = 3/100;"));
//! # Ok::<(), String>(())
//! ```

mod counts;
mod diff;
mod draws;
mod exchange;
mod fit;
mod form_change;
mod model_change;
mod model_offers;
mod named_numbers;
mod offers;
mod solve;
mod text_change;
mod toml_text;
mod trial;

pub use counts::{Counts, anchors};
pub use diff::unified;
pub use exchange::Exchange;
pub use fit::{MOST as MOST_RUNS_OF_A_FIT, Tried, fitted};
pub use form_change::FormChange;
pub use model_change::{
    Changed, ModelChange, NEAR, Refusal, SAME, SetConstant, Solver, Values, rate_of,
};
pub use model_offers::{Asked, Ground, Model, ModelOffers};
pub use named_numbers::{NamedNumber, is_all_named, named_numbers};
pub use offers::{Offer, Offers, Ranked};
pub use text_change::{TextChange, steps};
pub use trial::{Touch, Trial};
