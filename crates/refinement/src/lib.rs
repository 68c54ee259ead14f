#![doc = include_str!("../README.md")]
//!
//! Nothing here reads or writes files, or runs a technique.

mod branches;
mod counts;
mod diff;
mod draws;
mod exchange;
mod fit;
mod form_change;
mod idle;
mod model_change;
mod model_offers;
mod named_numbers;
mod number;
mod offers;
mod requirement_rates;
mod rewritten;
mod slips;
mod solve;
mod structure;
mod text_change;
mod toml_text;
mod trial;
mod unreached;
mod unused;

pub use branches::Branch;
pub use counts::{Counts, anchors};
pub use diff::unified;
pub use exchange::Exchange;
pub use fit::{MOST as MOST_RUNS_OF_A_FIT, Tried, fitted};
pub use form_change::FormChange;
pub use idle::{Idle, never_taken};
pub use model_change::{
    Alternative, Changed, ModelChange, NEAR, Refusal, SAME, SetConstant, Solver, Values, rate_of,
};
pub use model_offers::{Asked, Ground, Model, ModelOffers};
pub use named_numbers::{NamedNumber, is_all_named, named_numbers};
pub use number::Number;
pub use offers::{Offer, Offers, Ranked};
pub use requirement_rates::NamedOffer;
pub use rewritten::{Rewritten, RewrittenOffer};
pub use slips::Slip;
pub use solve::{Moved, nearest_crossing};
pub use structure::FREE_VALUE;
pub use text_change::{TextChange, steps};
pub use trial::{Touch, Trial};
pub use unreached::{Place, Word};
pub use unused::{Split, SplitBy};
