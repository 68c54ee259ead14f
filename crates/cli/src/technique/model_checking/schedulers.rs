//! Decision processes as evidence: what a model leaves open is bounded over all schedulers.
//!
//! # Definition
//! A person or an environment that is left nondeterministic gives no probability but a range,
//! `[inf P, sup P]` over all schedulers, whichever of `P=?`, `Pmin=?` and `Pmax=?` the study writes. The answer's value is
//! that of the worst scheduler: the least probability of a requirement, the greatest of a failure mode.
//!
//! # Guarantee
//! The range holds for every scheduler, with memory and with chance, as the bounds of both ends do: it reaches from
//! the lower bound of the least to the upper bound of the greatest probability. An end without bounds gives a range
//! without bounds.

use super::{Compiled, CountedConstant};
use crate::problem::Problem;
use crate::study::FormText;
use evidence::{Guarantee, MethodAnswer, Subject};
use prism_lang::ast::Optimum;

/// A property that asks for the least or the greatest probability: `P=?`, `Pmin=?` and `Pmax=?` are one question.
pub(super) fn with_optimum(text: &FormText, optimum: Optimum) -> FormText {
    let asked = ["P=?", "Pmin=?", "Pmax=?"];
    let written = text.text.trim_start();
    let rest = asked.iter().find_map(|asked| written.strip_prefix(asked));
    let Some(rest) = rest else {
        return text.clone();
    };
    FormText {
        text: format!("P{}=?{rest}", optimum.word()),
        ..text.clone()
    }
}

/// Both ends as one answer.
pub(super) fn range(
    subject: &Subject,
    (least, greatest): (MethodAnswer, MethodAnswer),
) -> MethodAnswer {
    let guarantee = match (least.bounds(), greatest.bounds()) {
        (Some(least), Some(greatest)) => Guarantee::Schedulers {
            low: least.low,
            high: greatest.high,
        },
        _ => Guarantee::Estimated {
            reason: "the ends of the range over all schedulers are estimates".into(),
        },
    };
    let worst = match subject {
        Subject::Requirement(_) => &least,
        Subject::FailureMode(_) => &greatest,
    };
    MethodAnswer {
        method: least.method.clone(),
        value: worst.value,
        complement: worst.complement,
        guarantee,
        iterations: least.iterations.max(greatest.iterations),
    }
}

impl Compiled<'_> {
    /// Constants whose uncertainty would have to be carried through both ends of a range.
    pub(super) fn cannot_carry(&self, id: &str, varied: &[CountedConstant]) -> Problem {
        let names: Vec<&str> = varied.iter().map(|one| one.name.as_str()).collect();
        Problem::new(
            "cannot-carry-uncertainty",
            format!(
                "the uncertainty of {} cannot be carried through {id}: its model leaves choices open, so each value of \
                 the constants gives a range over all schedulers",
                names.join(", ")
            ),
        )
        .remedy("write `held = true` for these constants in the ledger, or a model without choices (dtmc)")
    }
}
