//! How rare an event is: splitting, for probabilities that plain counting cannot reach.
//!
//! | you have | use |
//! |---|---|
//! | runs that can be saved and continued with other draws | [`split`]: unbiased |
//! | only inputs that determine the outcome (or nearly) | [`subset`]: biased by some 1/particles |
//!
//! Both give one estimate for each independent replication; [`combine`] turns those into an
//! estimate with an interval.

mod adaptive;
mod replications;
mod subset_simulation;
#[cfg(test)]
mod tests;

pub use adaptive::{Branch, Crossing, Descent, Job, SplittingOptions, split};
pub use replications::{RareEstimate, combine};
pub use subset_simulation::{Candidate, Ladder, SubsetOptions, subset};
