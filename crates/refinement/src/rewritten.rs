//! Other texts of a computed piece that is no formal model, such as a fault tree with one gate changed, tried on all evidence.
//!
//! # Definition
//! Each text is computed. Those that explain what disagrees (`structure`) are offered, the best first.
//!
//! # Cost
//! One computation of each text.
//!
//! # Assumes
//! One change is enough: all else of the text is right.
//!
//! # Guarantee
//! What is offered was computed, not estimated. That nothing else explains as much is not shown.

use crate::counts::{Counts, anchors};
use crate::model_change::{Solver, Values};
use crate::model_offers::Ground;
use crate::structure::Tried;
use crate::trial::Trial;
use evidence::Subject;

/// Texts that are offered for one piece, at most.
const MOST_OFFERS: usize = 4;

/// Another text of a piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Rewritten {
    /// Which kind of change it is: kinds are as likely as each other, and so are the changes of one kind.
    pub kind: u8,
    /// Decades by which the kind is rarer than a wrong kind of gate.
    pub rarer: f64,
    /// Where the change is, in bytes of the old text.
    pub place: usize,
    /// What is changed, as a part of the file.
    pub part: String,
    /// What is done, in one clause.
    pub what: String,
    /// The new text.
    pub text: String,
}

/// A text that explains what disagrees.
#[derive(Clone, Debug, PartialEq)]
pub struct RewrittenOffer {
    /// The text.
    pub rewritten: Rewritten,
    /// What it explains, the strongest disagreement first.
    pub subjects: Vec<Subject>,
    /// What was counted of the first of these.
    pub counts: Counts,
    /// What was answered before.
    pub before: Values,
    /// What is answered then.
    pub values: Values,
    /// What it does to the agreement with all other evidence.
    pub trial: Trial,
    /// Its weight in decades, of the number of texts that were tried, too.
    pub weight: f64,
    /// How many were tried that move a value.
    pub tried: usize,
}

impl Ground<'_> {
    /// Those of some texts of a piece that explain what it disagrees in; none where it agrees.
    #[must_use]
    pub fn of_texts(
        &self,
        evidence: &str,
        text: &str,
        all: &dyn Fn() -> Vec<Rewritten>,
        solver: &dyn Solver,
    ) -> Vec<RewrittenOffer> {
        let mut pieces = self.evidence.iter();
        let own = pieces.find(|piece| piece.id == evidence);
        let (Some(own), Ok(before)) = (own, solver.values(text)) else {
            return Vec::new();
        };
        if self.in_conflict(own, &before).is_empty() {
            return Vec::new();
        }
        let tried = all().into_iter().filter_map(|it| {
            Some(Tried {
                values: solver.values(&it.text).ok()?,
                kind: it.kind,
                change: it,
            })
        });
        let found = self.explaining(own, &before, tried.collect()).into_iter();
        let offers = found.filter_map(|it| {
            let first = it.subjects.first()?;
            Some(RewrittenOffer {
                counts: anchors(self.evidence, own, first).into_iter().next()?,
                trial: self.tried(evidence, &before, &it.values),
                before: before.clone(),
                subjects: it.subjects,
                values: it.values,
                weight: it.weight - it.change.rarer,
                rewritten: it.change,
                tried: it.tried,
            })
        });
        let mut offers: Vec<RewrittenOffer> = offers.collect();
        offers.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        offers.truncate(MOST_OFFERS);
        offers
    }

    /// The weight of a number of a text that was solved for (`structure`), as that of [`RewrittenOffer`].
    #[must_use]
    pub fn weight_of_value(&self, evidence: &str, before: &Values, after: &Values) -> Option<f64> {
        let mut pieces = self.evidence.iter();
        let own = pieces.find(|piece| piece.id == evidence)?;
        self.weight_of_solved(own, before, after)
    }
}
