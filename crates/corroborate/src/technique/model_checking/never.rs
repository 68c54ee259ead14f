//! Why nothing triggers a subject in a model, where that is not the model's structure.
//!
//! # Definition
//! What triggers a subject has probability 0 in a model because of
//!
//! * the *bound* of its trigger, where the same formula without the bound has a greater probability: `F<=1 "near"` in a model that needs
//!   two steps to come near;
//! * *constants that are held* at a rate that was counted, where with the means of their posteriors it has: 0 of 30 is no proof of a rate of
//!   0, so nobody who counts such a run contradicts the model ("with the impossible", `evidence::Comparison`).
//!
//! # Assumes
//! The means of the posteriors lie within 0 and 1, as Jeffreys' do.
//!
//! # Guarantee
//! Where neither is said, the probability is 0 for all bounds and for all values of the counted constants but for those of measure 0.

use super::Compiled;
use super::given::path_of;
use super::uncertainty::NO_EFFECT;
use crate::decide::percent;
use crate::technique::counted::CountedConstant;
use diagnostic::Problem;
use evidence::{Finding, Measure, Subject};
use prism_lang::ast::{Expr, ExprKind, TemporalOp};
use study::FormText;

/// That what triggers it has probability 0, and whether it has without its bound; `answer` computes a property's probability.
pub(super) fn reason(
    subject: &Subject,
    trigger: &FormText,
    answer: &dyn Fn(&FormText) -> Result<f64, Problem>,
) -> String {
    let known = match subject {
        Subject::Requirement(_) => "In the model, it is triggered with probability 0",
        Subject::FailureMode(_) => "In the model, the opportunity has probability 0",
    };
    let without = without_its_bound(&trigger.text).map(|text| FormText {
        text,
        ..trigger.clone()
    });
    // What cannot be computed is no reason.
    let share = without.and_then(|text| answer(&text).ok());
    match (share, path_of(&trigger.text)) {
        (Some(share), Some(path)) if share > NO_EFFECT => format!(
            "{known} within the bound of `{path}`; without the bound it is {}.",
            percent(share)
        ),
        _ => format!("{known}."),
    }
}

/// The property that asks whether its formula ever comes true, whenever; `None` where it has no bound.
fn without_its_bound(text: &str) -> Option<String> {
    let parsed = prism_lang::parse_properties(text);
    let property = parsed.tree.properties.first()?;
    let ExprKind::Probability {
        path,
        condition: None,
        ..
    } = &property.formula.kind
    else {
        return None;
    };
    Some(format!("P=? [ {} ]", unbounded(path)?))
}

fn unbounded(path: &Expr) -> Option<Expr> {
    match &path.kind {
        ExprKind::Temporal {
            operator: operator @ (TemporalOp::Finally | TemporalOp::Until),
            bound: Some(_),
            left,
            right,
        } => Some(Expr {
            kind: ExprKind::Temporal {
                operator: *operator,
                bound: None,
                left: left.clone(),
                right: right.clone(),
            },
            span: path.span,
        }),
        _ => None,
    }
}

impl Compiled<'_> {
    /// Takes from findings the probability 0 of their trigger where that is of constants which are held at what was counted.
    pub(super) fn say_what_is_held_at_zero(
        &self,
        held: &[CountedConstant],
        findings: &mut [Finding],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Problem> {
        let is_never = |finding: &Finding| {
            matches!(finding.measure, Measure::NotCovered { .. }) && finding.trigger.is_some()
        };
        if held.is_empty() || !findings.iter().any(is_never) {
            return Ok(());
        }
        let means: Vec<f64> = held.iter().map(|it| it.posterior.mean()).collect();
        let rates = self.solve_at(held, &means, cancel)?;
        let names: Vec<String> = held.iter().map(|it| format!("`{}`", it.name)).collect();
        for (question, rate) in self.questions.iter().zip(rates) {
            let mut of_question = findings.iter_mut();
            let finding = of_question.find(|it| &it.subject == question.subject);
            let Some(finding) = finding.filter(|it| is_never(it)) else {
                continue;
            };
            if rate.trigger.is_some_and(|it| it.greatest > NO_EFFECT) {
                finding.trigger = None;
                finding.measure = Measure::NotCovered {
                    reason: format!(
                        "In the model nothing triggers it because {} {} held at what was counted, which does not show that it never comes.",
                        names.join(", "),
                        if names.len() == 1 { "is" } else { "are" }
                    ),
                    constant: None,
                };
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_bound_of_the_whole_formula_is_taken_away() {
        for (text, expected) in [
            ("P=? [ F<=1 \"near\" ]", Some("P=? [ F \"near\" ]")),
            ("P=? [ \"a\" U<=3 \"b\" ]", Some("P=? [ \"a\" U \"b\" ]")),
            ("P=? [ F \"near\" ]", None),
            ("P=? [ G<=3 \"near\" ]", None),
        ] {
            assert_eq!(without_its_bound(text).as_deref(), expected, "{text}");
        }
    }
}
