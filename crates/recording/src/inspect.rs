//! What is in a recording.

mod periods;
mod units;

pub(crate) use units::usual_unit;
