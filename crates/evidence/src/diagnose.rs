//! Diagnosis: for each disagreement, which asset is to blame.
//!
//! # Definition
//! Webster et al. (2020, section 2.3) name three sources of disagreement:
//! the system model, the requirement model and the tool. They are separated
//! by what differs while all else is the same:
//!
//! * *tool*: one model, one property, two methods. If an answer without a
//!   bound lies outside the bounds of another method, it is wrong by at least
//!   that distance.
//! * *requirement model*: one set of traces, two readings of the requirement.
//!   Every trace with two verdicts is a witness. If two pieces of evidence
//!   conflict under the main reading and not under the other, the reading
//!   explains the conflict.
//! * *system model*: a failure mode whose rates conflict, or that one asset
//!   cannot express although others show it.
//!
//! Each thing that speaks against an asset is a [`Clue`]; [`rank`] gathers
//! them by asset, as [`Suspect`]s. Published evidence that other evidence
//! reproduces is spoken for by that evidence and takes no part.
//!
//! # Assumes
//! Where one thing is changed, all else is the same: the model, the traces, the property. Trials are independent, or count
//! at their effective size.
//!
//! # Guarantee
//! Every comparison with the outcome *conflicts* between evidence that takes
//! part gives a clue against at least one asset, unless both sides agree once
//! the margin is allowed for.

mod alone;
mod blame;
mod cells;
mod columns;
mod contrast;
mod exchanged;
mod forms;
mod hidden;
mod matter;
mod names;
mod places;
mod ranking;
mod rates;
mod shared;
mod sides;
mod strength;
mod suspect;
mod tool;
mod untriggered;
mod voices;

pub use cells::{CellPlace, VerdictCounts};
pub use columns::{ExchangedColumns, exchanged_columns};
pub use contrast::{SameTraces, contrasts};
pub use exchanged::{Exchanged, exchanged, put_right};
pub use matter::{Clue, Counted, Matter, TableOf, requirement_form, system_model};
pub use names::{MixedUp, mixed_up};
pub use places::changed_places;
pub use ranking::rank;
pub use strength::{CERTAIN, Rate, STRONG, signed_strength, strength};
pub use suspect::{
    Cell, Contrast, Diagnosis, Effort, Figure, HALF_STEP, JudgedBy, Suspect, SuspectAsset,
    SuspectKind, Symptom, Traces, Witness,
};
pub use voices::{share_assumption, voices};
