//! What reading a text gives, and what has to be known for it.

use diagnostic::Problem;
use num_rational::BigRational;

use crate::tree::FaultTree;

/// What a text does not say, and its reading needs.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The time for which the system is under way, in the unit that belongs to the rates: for `lambda=` in Galileo, and
    /// `<system-mission-time/>` in Open-PSA. Without it, a rate is a mistake that is reported.
    pub mission_time: Option<BigRational>,
}

/// A tree, and what is strange in its text.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The tree.
    pub tree: FaultTree,
    /// What can be worked with, but perhaps is not meant: events that the top event does not depend on, attributes without
    /// effect. At most as many as are shown.
    pub warnings: Vec<Problem>,
}
