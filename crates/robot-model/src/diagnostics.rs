//! What is wrong with a description, and what of it was not carried over, each with its place.

use std::fmt;
use std::sync::Arc;

/// A place in one of the texts.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The file's name as the caller or the description gave it.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Something wrong, and how to fix it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Where.
    pub place: Place,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.place, self.message, self.remedy)
    }
}

/// Why a description could not be loaded: everything that was found, in the order of the text, at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// What a gap concerns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effect {
    /// How bodies move: masses, joints, constraints, drives.
    Motion,
    /// What touches what, and how hard.
    Contact,
    /// What sensors report.
    Sensing,
    /// What commands the robot.
    Control,
    /// Only how it looks.
    Looks,
    /// Nothing physical: names, hints for other programs.
    Nothing,
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Motion => "motion",
            Self::Contact => "contact",
            Self::Sensing => "sensing",
            Self::Control => "control",
            Self::Looks => "looks",
            Self::Nothing => "nothing",
        })
    }
}

/// Something in the description that the tree does not hold, or holds only approximately.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gap {
    /// Where.
    pub place: Place,
    /// The element or attribute, as a path of the innermost names (`joint/safety_controller`, `geom@fluidshape`).
    pub element: String,
    /// What was ignored or approximated.
    pub what: String,
    /// What follows from it.
    pub consequence: String,
    /// Which side of the simulation it concerns.
    pub effect: Effect,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {}: {} ({}: {})",
            self.place, self.element, self.what, self.effect, self.consequence
        )
    }
}
