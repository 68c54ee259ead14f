//! What could be changed in a formal model so that its failures come as often as they were counted.
//!
//! # Definition
//! For each failure mode: if the model cannot express it, or no command leads to it, and it was counted, a branch
//! ([`ModelChange::Branch`]). Else,
//! if its rate is farther than the declared margin from the counts that it may be set to ([`anchors`], the first of them), or
//! their exact binomial p-value is below the study's level, divided, where no other evidence disagrees strongly with the rate, by
//! the number of failure modes or of the study's comparisons, whichever is larger: the constant set to the counted share or, where
//! that does not give the rate, solved for; or, if it has the share already, the draw made once, else solved for. Then the
//! same for requirements that this leaves in disagreement ([`crate::requirement_rates`]). Branches of commands that should not be
//! there are tried where anything disagrees strongly ([`crate::branches`]), and so are those to states that a proposition names and
//! nothing leads to ([`crate::unreached`]), those for which a constant was written that nothing uses ([`crate::unused`]), what leads to
//! values that the text declares or asks for ([`crate::idle`]), and, where none of all these is enough, slips ([`crate::slips`]).
//!
//! # Assumes
//! One change is enough for each failure mode. The p-value takes all trials as independent ([`Counts::p_value`]), at one
//! look.
//!
//! # Guarantee
//! Each change gives the rate that it promises when the model is solved again, or is refused with the reason. That the system is so is
//! not shown: counts fit other changes, too.

use crate::counts::{Counts, anchors};
use crate::model_change::{
    Changed, ModelChange, SAME, Solver, Values, comes_to, is_set_to, once_or_solve, rate_of,
    rate_or_solve,
};
use crate::unreached::Word;
use evidence::{Comparison, Evidence, FailureMode, Measure, Requirement, STRONG, Subject};

/// A study's evidence, and what it declares.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The ledger, oldest first.
    pub evidence: &'a [Evidence],
    /// What is required.
    pub requirements: &'a [Requirement],
    /// What can go wrong, with margins.
    pub failure_modes: &'a [FailureMode],
    /// The pairs of evidence.
    pub comparisons: &'a [Comparison],
    /// The study's confidence.
    pub confidence: f64,
}

/// How a model is asked about a failure mode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// The failure mode.
    pub mode: String,
    /// What it means over the model's variables; `None` if no single proposition says so.
    pub occurs: Option<String>,
    /// What its opportunity means.
    pub after: Option<String>,
}

/// A formal model as it is, or as it has become.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    /// The evidence that it gives.
    pub evidence: &'a str,
    /// Its text.
    pub text: &'a str,
    /// The questions.
    pub asked: &'a [Asked],
    /// The propositions that they and the properties of requirements ask for.
    pub words: &'a [Word],
    /// Answers them for other texts of it.
    pub solver: &'a dyn Solver,
    /// How many states it has, if that is known: what costs many solutions is only tried on models that are small enough.
    pub states: Option<u64>,
}

/// States times solutions that one kind of change may cost, at most.
pub(crate) const MOST_WORK: u64 = 20_000_000;

impl Model<'_> {
    /// How many changes are tried that cost so many solutions each: at most `most`, of a large model fewer.
    pub(crate) fn affordable(&self, most: usize, solutions: u64) -> usize {
        let affordable = MOST_WORK / solutions / self.states.unwrap_or(1).max(1);
        most.min(usize::try_from(affordable).unwrap_or(most))
    }
}

/// Changes of one model, each made alone.
#[derive(Clone, Debug, Default)]
pub struct ModelOffers {
    /// The changes, with the model after each.
    pub changes: Vec<(ModelChange, Changed)>,
    /// Why there is none for a failure mode.
    pub refused: Vec<String>,
}

impl Ground<'_> {
    /// What could be changed in a model; `before` is what it answers now.
    #[must_use]
    pub fn of_model(&self, model: &Model<'_>, before: &Values) -> ModelOffers {
        let mut found = ModelOffers::default();
        let left = |values: &Values| self.disagreement(model.evidence, values);
        for asked in model.asked {
            let Some(change) = self.wanted(model, asked, before) else {
                continue;
            };
            let made = change.and_then(|change| match change {
                ModelChange::Rate {
                    mode,
                    occurs,
                    counts,
                } => rate_or_solve(model.text, model.solver, (mode, occurs, counts), &left),
                ModelChange::Once {
                    mode,
                    occurs,
                    counts,
                } => once_or_solve(model.text, model.solver, (mode, occurs, counts), &left),
                change => {
                    let changed = change.make(model.text, model.solver)?;
                    Ok((change, changed))
                }
            });
            match made {
                // Two failures may be fixed by one change.
                Ok((_, changed)) if found.changes.iter().any(|(_, o)| o.text == changed.text) => {}
                Ok(made) => found.changes.push(made),
                Err(reason) => found.refused.push(format!(
                    "{} of {}: {reason}.",
                    asked.mode.replace('_', " "),
                    model.evidence
                )),
            }
        }
        self.of_requirements(model, before, &mut found);
        self.of_branches(model, before, &mut found);
        self.of_unreached(model, before, &mut found);
        self.of_unused(model, before, &mut found);
        self.of_idle(model, before, &mut found);
        self.of_slips(model, before, &mut found);
        found
    }

    /// The change that a failure mode asks for, if it does.
    fn wanted(
        &self,
        model: &Model<'_>,
        asked: &Asked,
        before: &Values,
    ) -> Option<Result<ModelChange, String>> {
        let mode = asked.mode.clone();
        let rate = rate_of(before, &mode);
        let target = self.evidence.iter().find(|e| e.id == model.evidence)?;
        let subject = Subject::FailureMode(mode.clone());
        // A model that does not speak of the opportunity lacks nothing, nor does one of another part.
        let is_outside = target
            .finding(&subject)
            .is_some_and(|it| matches!(it.measure, Measure::NotCovered { .. }))
            || evidence::is_of_another_part(self.evidence, target, &subject);
        if is_outside && rate.is_none() {
            return None;
        }
        let counted = anchors(self.evidence, target, &subject);
        let Some(occurs) = asked.occurs.clone() else {
            let is_missing = rate.is_none() && counted.iter().any(|it| it.count > 0);
            let reason = "its `occurs` names no single proposition of the model";
            return is_missing.then(|| Err(reason.into()));
        };
        // What the model knows, but never comes to, has no probability that could be set.
        let rate = rate.filter(|rate| *rate > 0.0 || comes_to(model.text, &occurs));
        let Some(rate) = rate else {
            let counts = counted.into_iter().find(|it| it.count > 0)?;
            return Some(Ok(ModelChange::Branch {
                subject: Subject::FailureMode(mode.clone()),
                name: mode,
                occurs,
                after: asked.after.clone(),
                at: None,
                counts,
            }));
        };
        let counts = counted.into_iter().next()?;
        let is_wanted = self.differs(target, rate, &counts, &mode);
        is_wanted.then(|| rate_or_once(model.text, mode, occurs, counts))
    }

    /// Whether a rate is not what was counted: farther than the margin, or beyond chance, by which each failure mode may be the
    /// one that differs.
    fn differs(&self, own: &Evidence, rate: f64, counts: &Counts, mode: &str) -> bool {
        let subject = Subject::FailureMode(mode.to_owned());
        let is_disputed = self.strongest(own, &subject, Some(rate)) > STRONG;
        let margin = evidence::margin_of(&[], self.failure_modes, &subject);
        let distance = (rate - counts.rate()).abs();
        let compared = self
            .comparisons
            .iter()
            .filter(|it| it.p_difference.is_some());
        let tests = match is_disputed {
            true => 1,
            false => self.failure_modes.len().max(compared.count()).max(1),
        };
        let level = (1.0 - self.confidence) / tests as f64;
        let is_unlikely = counts.p_value(rate).is_some_and(|p| p < level);
        distance > SAME
            && (distance > margin || is_unlikely)
            && !self.is_agreed(own, counts, &subject)
    }
}

/// The constant is set, if it is not yet what was counted; else its draw is made once.
fn rate_or_once(
    text: &str,
    mode: String,
    occurs: String,
    counts: Counts,
) -> Result<ModelChange, String> {
    Ok(match is_set_to(text, &occurs, &counts)? {
        true => ModelChange::Once {
            mode,
            occurs,
            counts,
        },
        false => ModelChange::Rate {
            mode,
            occurs,
            counts,
        },
    })
}
