//! Whose side the real system takes where two forms of a requirement judge the same runs otherwise.
//!
//! # Definition
//! Counts of the real system were made by people, without the forms. Of two forms that give a piece two rates, the one
//! is *contradicted* whose rate differs strongly from such counts under the same conditions (at least [`STRONG`]), while
//! the other's does not.
//!
//! # Assumes
//! People counted what the requirement means. Their trials are independent, or count at their effective size.
//!
//! # Guarantee
//! This comes before what the sentence says (`forms`): a sentence that says the same as the contradicted form is in doubt
//! with it. How the people counted is not known; counts that were made by a mistaken rule take the side of that rule.

use super::matter::Matter;
use super::strength::{Rate, STRONG, strength};
use crate::{Evidence, Subject};

impl Matter<'_> {
    /// Which of two forms of a subject the counts of the real system contradict, if they contradict one alone.
    pub(super) fn contradicted<'f>(
        &self,
        piece: &Evidence,
        subject: &Subject,
        forms: [&'f str; 2],
    ) -> Option<&'f str> {
        let judged = self.judged(piece, subject);
        let rate = |form: &str| Some(judged.iter().find(|it| it.form == form)?.rate);
        let (one, other) = (rate(forms[0])?, rate(forms[1])?);
        let counted = self.speaking().filter(|it| {
            it.technique.traits().is_counted_by_people
                && it.conditions == piece.conditions
                && it.id != piece.id
        });
        let counted: Vec<Rate> = counted.filter_map(|it| Rate::on(it, subject)).collect();
        let most = |rate: Rate| {
            let against = counted
                .iter()
                .map(|it| strength(rate, *it, self.margin(subject)));
            against.fold(0.0, f64::max)
        };
        match (most(one) >= STRONG, most(other) >= STRONG) {
            (true, false) => Some(forms[0]),
            (false, true) => Some(forms[1]),
            _ => None,
        }
    }
}
