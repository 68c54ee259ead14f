//! What a command found, as an exit code for scripts and CI.

/// How a command that could do its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// All requirements are satisfied on the step that they need, and no current evidence conflicts.
    Holds,
    /// It was interrupted before what was planned was over; what was found so
    /// far is kept.
    Interrupted,
    /// Something could not be decided, or is satisfied for a model or in simulation only.
    Inconclusive,
    /// The work is done but some of its data could not be kept or read.
    DataLost,
    /// Part of the input means nothing; what was asked besides is answered.
    Wrong,
    /// A requirement is violated (of the system, in simulation or for a model), or evidence conflicts.
    Violated,
}

impl Outcome {
    /// The exit code: 0, 1, 2, 3 or 130. (2 is also that of errors that end
    /// a command, 101 a bug of ours.)
    pub fn exit_code(self) -> u8 {
        match self {
            Outcome::Holds => 0,
            Outcome::Violated => 1,
            Outcome::Wrong => 2,
            Outcome::Interrupted => 130,
            Outcome::Inconclusive | Outcome::DataLost => 3,
        }
    }
}
