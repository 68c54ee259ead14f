//! Decision processes as evidence: what a model leaves open is bounded over all schedulers.
//!
//! # Definition
//! A person or an environment that is left nondeterministic gives no probability but a range,
//! `[inf P, sup P]` over all schedulers, whichever of `P=?`, `Pmin=?` and `Pmax=?` the study writes. The answer's value is
//! that of the worst scheduler: the least probability of a requirement, the greatest of a failure mode.
//!
//! # Assumes
//! The bounds of both ends hold. Nothing of how choices are made.
//!
//! # Guarantee
//! The range holds for every scheduler, with memory and with chance, as the bounds of both ends do: it reaches from
//! the lower bound of the least to the upper bound of the greatest probability. An end without bounds gives a range
//! without bounds.
//!
//! Where constants were set to counts, both ends are found at each point of the constants' posteriors
//! ([`super::uncertainty`]), each by the scheduler that is worst (or best) there: a scheduler that knows the constants,
//! so that the range holds for schedulers that do not.

use super::Question;
use super::functions::{Ends, Rate};
use diagnostic::Problem;
use evidence::{Guarantee, MethodAnswer, Subject, Worst};
use prism_lang::ast::Optimum;
use study::FormText;

/// What a property's least or greatest probability is at one point of the constants.
pub(super) type ValueOf<'f> = dyn FnMut(&FormText, Optimum) -> Result<f64, Problem> + 'f;

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
            worst: None,
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

/// Which end of the range is the value of a subject.
pub(super) fn worst(subject: &Subject) -> Worst {
    match subject {
        Subject::Requirement(_) => Worst::Least,
        Subject::FailureMode(_) => Worst::Greatest,
    }
}

impl Question<'_> {
    /// Both ends of the rate and of its trigger's probability at one point of the constants.
    pub(super) fn ends_at(&self, value: &mut ValueOf<'_>) -> Result<Rate, Problem> {
        if !self.has_choices {
            let (rate, trigger) = self.rate_at(&mut |text| value(text, Optimum::Min))?;
            return Ok(Rate {
                value: rate.map(Ends::both),
                trigger: trigger.map(Ends::both),
            });
        }
        let mut ends = |text: &FormText| -> Result<Ends, Problem> {
            Ok(Ends {
                least: value(text, Optimum::Min)?,
                greatest: value(text, Optimum::Max)?,
            })
        };
        let trigger = self.trigger().map(&mut ends).transpose()?;
        // Of a model with choices no quotient is asked, but the conditional probability itself.
        let (asked, _) = self.texts();
        let value = match ends(asked) {
            Err(problem) if super::given::is_refused(&problem) => ends(self.property)?,
            found => found?,
        };
        Ok(Rate {
            value: Some(value),
            trigger,
        })
    }
}
