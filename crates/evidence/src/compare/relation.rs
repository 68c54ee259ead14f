//! The relation of two rates: what the two tests and the estimate together show.
//!
//! # Definition
//! Of a pair with margin `m`, *difference shown* (D) means that "no difference" is rejected, corrected over the study;
//! *equivalence shown* (E) that "the difference is `m` or more" is rejected and the estimated difference is below `m`;
//! *inside* that the estimated difference is below `m`. Of a range over all schedulers that is wider than `m`, beside one rate, equivalence
//! is never shown: the estimate is the value of the range that is nearest to the rate.
//!
//! | D | E | estimate | relation | outcome | what is wrong with at most which probability |
//! |---|---|---|---|---|---|
//! | no | yes | inside | equivalent | corroborates | "the rates differ by less than the margin": `1 - g` for the pair |
//! | yes | yes | inside | trivial difference | corroborates | that, and "they differ": `1 - c` anywhere in the study |
//! | yes | no | inside | difference within the margin | inconclusive | "they differ": `1 - c` anywhere in the study |
//! | yes | no | outside | different | conflicts | "they differ": `1 - c` anywhere in the study |
//! | no | no | inside | indeterminate | inconclusive | claims nothing |
//! | no | no | outside | indeterminate, outside the margin | inconclusive | claims nothing |
//!
//! `g` is the study's level of agreement, `c` its confidence. Equivalence with an estimate outside cannot be, by
//! definition. That a conflict's true difference exceeds the margin is not shown but estimated: of a pair whose true
//! difference is just below the margin, the estimate is outside in about half of all samples, however large they are.
//!
//! `ERROR_RATES.md` has the largest probability of each cell at the worst true rates, as sums over all outcomes.
//!
//! # Source
//! W. W. Tryon, "Evaluating statistical difference, equivalence, and indeterminacy using inferential confidence
//! intervals", Psychological Methods 6 (2001), for the outcomes difference, equivalence, trivial difference and
//! indeterminacy; D. Lakens, "Equivalence tests: a practical primer", Social Psychological and Personality Science 8
//! (2017). Deviation: where equivalence is not shown, the estimate's side of the margin is part of the relation, because
//! a difference that is estimated to be tolerable must not fail a build.
//!
//! # Assumes
//! Both sides are independent of each other, of independent trials or of clusters that are declared, at sizes fixed in
//! advance or with all looks recorded.
//!
//! # Guarantee
//! The last column of the table.

use crate::Outcome;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the test of difference, the test of equivalence and the estimate together show of two rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// Equivalence within the margin is shown, a difference is not.
    Equivalent,
    /// Equivalence within the margin is shown, and a difference, too: it is smaller than the margin.
    TrivialDifference,
    /// A difference is shown, its estimate lies within the margin, and equivalence is not shown.
    DifferenceWithinMargin,
    /// A difference is shown, and its estimate is the margin or more.
    Different,
    /// Neither is shown; the estimated difference lies within the margin.
    Indeterminate,
    /// Neither is shown; the estimated difference is the margin or more.
    IndeterminateOutside,
}

impl Relation {
    /// The relation of a pair from its two tests and its estimate. Equivalence counts only where the estimated
    /// difference lies within the margin.
    #[must_use]
    pub fn of(difference_shown: bool, equivalence_shown: bool, inside_margin: bool) -> Self {
        match (difference_shown, equivalence_shown, inside_margin) {
            (false, true, true) => Self::Equivalent,
            (true, true, true) => Self::TrivialDifference,
            (true, false, true) => Self::DifferenceWithinMargin,
            (true, _, false) => Self::Different,
            (false, false, true) => Self::Indeterminate,
            (false, _, false) => Self::IndeterminateOutside,
        }
    }

    /// The outcome of a comparison with this relation: only a shown difference outside the margin is a conflict.
    #[must_use]
    pub fn outcome(self) -> Outcome {
        match self {
            Self::Equivalent | Self::TrivialDifference => Outcome::Corroborates,
            Self::Different => Outcome::Conflicts,
            Self::DifferenceWithinMargin | Self::Indeterminate | Self::IndeterminateOutside => {
                Outcome::Inconclusive
            }
        }
    }

    /// Its name.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::TrivialDifference => "trivial difference",
            Self::DifferenceWithinMargin => "difference within the margin",
            Self::Different => "different",
            Self::Indeterminate => "indeterminate",
            Self::IndeterminateOutside => "indeterminate, outside the margin",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A conflict needs a shown difference and an estimate outside; agreement needs shown equivalence and an estimate
    /// inside; a test that shows something more never makes agreement less.
    #[test]
    fn every_cell_has_the_outcome_that_its_statements_allow() {
        let both = [false, true];
        for (different, equivalent, inside) in both
            .into_iter()
            .flat_map(|d| both.map(|e| (d, e)))
            .flat_map(|(d, e)| both.map(|i| (d, e, i)))
        {
            let outcome = Relation::of(different, equivalent, inside).outcome();
            assert_eq!(outcome == Outcome::Conflicts, different && !inside);
            assert_eq!(outcome == Outcome::Corroborates, equivalent && inside);
        }
    }
}
