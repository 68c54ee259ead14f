//! What all evidence amounts to together: one value that a study keeps and a report shows.

use crate::compare::{Programme, Together, TrialCosts, Undecided, programme};
use crate::conclude::combined::{Combined, Weights, combine};
use crate::conclude::threshold::{Deciding, NotPlanned, deciding, not_planned};
use crate::{Comparison, Conclusion, Looks, Study, compare_together};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// All evidence together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Synthesis {
    /// All pieces on each subject, compared at once.
    pub together: Vec<Together>,
    /// What the independent evidence on each requirement supports together.
    pub combined: Vec<Combined>,
    /// What a further trial costs.
    pub costs: TrialCosts,
    /// Further trials that would decide each undecided pair.
    pub undecided: Vec<Undecided>,
    /// One set of further trials for all undecided pairs of current evidence.
    pub programme: Option<Programme>,
    /// Further trials that would decide each undecided requirement.
    pub deciding: Vec<Deciding>,
    /// Why there is no such plan for a requirement that is left open.
    #[serde(default)]
    pub not_planned: Vec<NotPlanned>,
    /// The looks at the counts up to this one; none if all sample sizes were fixed in advance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<Looks>,
}

/// Compares, combines and plans, given the pairs' comparisons, the plans for those undecided ([`crate::undecided`], at the
/// same costs) and the conclusions of the same study.
pub fn synthesise(
    study: &Study<'_>,
    (comparisons, undecided): (&[Comparison], Vec<Undecided>),
    conclusions: &[Conclusion],
    costs: TrialCosts,
    weights: &Weights,
) -> Synthesis {
    let deciding = deciding(study, conclusions, &costs);
    Synthesis {
        together: compare_together(study, comparisons),
        combined: combine(study, comparisons, weights),
        programme: programme(&undecided, &costs),
        not_planned: not_planned(study, conclusions, &deciding),
        deciding,
        undecided,
        costs,
        looks: study.looks.cloned(),
    }
}
