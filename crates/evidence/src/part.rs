//! Models of parts of a system.
//!
//! # Definition
//! A model has nothing for a subject *because it is a model of another part* where another model, of the same technique and under the
//! same conditions, has a number for it, and has none for something that this one has a number for. Then it excludes nothing by its
//! silence. A later version of a model, which speaks of all that the earlier one does, makes no part of it.
//!
//! # Assumes
//! That what one model of a study speaks of need not be repeated in another.
//!
//! # Guarantee
//! None of the system: it decides of what a model is asked, not whether it is right.

use crate::{Evidence, Measure, Subject};

/// Whether a model has nothing for a subject because it is a model of another part of the system.
#[must_use]
pub fn is_of_another_part(evidence: &[Evidence], model: &Evidence, subject: &Subject) -> bool {
    let has_nothing = model.finding(subject).is_some_and(|finding| {
        matches!(
            finding.measure,
            Measure::NotExpressible { .. } | Measure::NotCovered { .. }
        )
    });
    let mut others = evidence.iter().filter(|other| {
        other.id != model.id
            && !other.intermediate
            && other.technique == model.technique
            && other.conditions == model.conditions
    });
    has_nothing && others.any(|other| says(other, subject) && adds(model, other))
}

/// Whether a piece has a number for a subject.
fn says(piece: &Evidence, subject: &Subject) -> bool {
    piece
        .finding(subject)
        .is_some_and(|finding| match finding.measure {
            Measure::Counts { .. } | Measure::Probability { .. } => true,
            Measure::NotCovered { .. } | Measure::NotExpressible { .. } => false,
        })
}

/// Whether a piece has a number for something that another one has none for.
fn adds(piece: &Evidence, other: &Evidence) -> bool {
    let mut subjects = piece.findings.iter().map(|finding| &finding.subject);
    subjects.any(|subject| says(piece, subject) && !says(other, subject))
}
