//! The difference of two rates that counts as agreement.

use crate::{FailureMode, Requirement, Subject};

/// The margin where none is declared: 5 points.
pub const DEFAULT_MARGIN: f64 = 0.05;

/// The margin of a subject: its own, and that of a declaration without one if it is not among these.
///
/// ```
/// use evidence::{DEFAULT_MARGIN, Requirement, Subject, margin_of};
///
/// let requirements = [Requirement::new("1", "The robot shall grasp the object.").margin(0.1)];
/// let of = |id: &str| margin_of(&requirements, &[], &Subject::Requirement(id.into()));
/// assert_eq!((of("1"), of("2")), (0.1, DEFAULT_MARGIN));
/// ```
pub fn margin_of(
    requirements: &[Requirement],
    failure_modes: &[FailureMode],
    subject: &Subject,
) -> f64 {
    let declared = match subject {
        Subject::Requirement(id) => {
            let mut all = requirements.iter();
            all.find(|it| &it.id == id).map(|it| it.margin)
        }
        Subject::FailureMode(id) => {
            let mut all = failure_modes.iter();
            all.find(|it| &it.id == id).map(|it| it.margin)
        }
    };
    declared.unwrap_or(DEFAULT_MARGIN)
}
