//! The staged monitor: a precondition, then postconditions in order, which counts how often it was
//! covered, passed and failed.
//!
//! Rates of success and failure need these counts, where a formula has one verdict for a trace. The
//! staged form ([`temporal::monitor`]) knows instants, waiting, and holding until something; a
//! sentence is put into it as far as that goes:
//!
//! | sentence | staged form |
//! |---|---|
//! | `when C` | triggers where C becomes true |
//! | `whenever C` | triggers at each sample with C |
//! | no condition | triggers once, at the first sample |
//! | `immediately R` | `assert R` |
//! | `eventually R`, `within D R` | `wait_for R` |
//! | `until Q R` | `hold R until Q` |
//! | invariants (`always R`, `never R` without a condition) | `assert` at each sample of the scope |
//!
//! A scope `in M` or `not in M` is possible where everything happens at the trigger, since the staged
//! form cannot excuse what a scope's end cuts off. While one instance is under way, later triggers
//! begin no other. With one stage this makes no difference to the verdict; with several it can, and
//! the monitor's report says how many there were.

use temporal::monitor::{AtEnd, MonitorSpec, Repeat, Stage, Trigger};

use super::{NotExpressible, check};
use crate::expression::Expression;
use crate::sentence::{Amount, ConditionKind, ScopeKind, Sentence, Timing};

/// The staged monitor of a sentence. An instance that is under way at the end stays open.
///
/// ```
/// use requirement_lang::{Context, compile::staged::staged, parse};
/// use temporal::monitor::{MonitorSpec, Stage};
/// let text = "When grasped, the robot shall until sensed satisfy in_hand, then within 5 s satisfy released";
/// let sentence = parse(text, &Context::default()).into_result().unwrap();
/// assert_eq!(staged(&sentence)?, MonitorSpec::new("grasped", vec![
///     Stage::Hold { proposition: "in_hand".into(), until: "sensed".into(), within_secs: None },
///     Stage::WaitFor { proposition: "released".into(), within_secs: Some(5.0) },
/// ]));
/// # Ok::<(), requirement_lang::compile::NotExpressible>(())
/// ```
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning, or none in stages.
pub fn staged(sentence: &Sentence) -> Result<MonitorSpec, NotExpressible> {
    check(sentence)?;
    let scope = match sentence.scope.kind {
        ScopeKind::Global => Expression::True,
        ScopeKind::In => sentence.scope.mode.clone(),
        ScopeKind::NotIn => sentence.scope.mode.clone().negation(),
        _ => return Err(refused(format!("the scope `{}`", sentence.scope))),
    };
    if let Some(asserted) = invariant(sentence) {
        return Ok(MonitorSpec::invariant(text(&scope), text(&asserted)));
    }
    let instant = sentence
        .stages
        .iter()
        .all(|stage| stage.timing == Timing::Immediately);
    if !instant && scope != Expression::True {
        return Err(refused(format!(
            "the end of the scope `{}`",
            sentence.scope
        )));
    }
    let stages = sentence
        .stages
        .iter()
        .map(|stage| self::stage(&stage.timing, &stage.response));
    let (when, trigger, repeat) = trigger(sentence, scope);
    Ok(MonitorSpec {
        when: text(&when),
        trigger,
        then: stages.collect::<Result<_, _>>()?,
        repeat,
        at_end: AtEnd::InconclusivePending,
    })
}

fn refused(what: String) -> NotExpressible {
    NotExpressible::Staged { what }
}

/// What is asserted at each sample of the scope, if that is all there is.
fn invariant(sentence: &Sentence) -> Option<Expression> {
    match (&sentence.condition, sentence.stages.as_slice()) {
        (None, [stage]) if stage.timing == Timing::Always => Some(stage.response.clone()),
        (None, [stage]) if stage.timing == Timing::Never => Some(stage.response.clone().negation()),
        _ => None,
    }
}

fn trigger(sentence: &Sentence, scope: Expression) -> (Expression, Trigger, Repeat) {
    let Some(condition) = &sentence.condition else {
        let repeat = match scope {
            Expression::True => Repeat::Once,
            _ => Repeat::EveryTrigger,
        };
        return (scope, Trigger::BecomesTrue, repeat);
    };
    let trigger = match condition.kind {
        ConditionKind::Whenever => Trigger::EachSample,
        ConditionKind::Upon | ConditionKind::Unless => Trigger::BecomesTrue,
    };
    let when = match scope {
        Expression::True => condition.triggering(),
        scope => Expression::And(vec![scope, condition.triggering()]),
    };
    (when, trigger, Repeat::EveryTrigger)
}

fn stage(timing: &Timing, response: &Expression) -> Result<Stage, NotExpressible> {
    let proposition = text(response);
    match timing {
        Timing::Immediately => Ok(Stage::Assert { proposition }),
        Timing::Eventually => Ok(Stage::WaitFor {
            proposition,
            within_secs: None,
        }),
        Timing::Within(duration) => match duration.amount {
            Amount::Secs(secs) => Ok(Stage::WaitFor {
                proposition,
                within_secs: Some(secs),
            }),
            _ => Err(refused(format!("{duration}, since its time is in seconds"))),
        },
        Timing::Until(stop) => Ok(Stage::Hold {
            proposition,
            until: text(stop),
            within_secs: None,
        }),
        other => Err(refused(format!("`{other}`"))),
    }
}

/// The expression in the language of predicates, which has no equivalence.
fn text(expression: &Expression) -> String {
    plain(expression).to_string()
}

fn plain(expression: &Expression) -> Expression {
    let all = |operands: &[Expression]| operands.iter().map(plain).collect::<Vec<_>>();
    match expression {
        Expression::Iff(left, right) => {
            let (left, right) = (plain(left), plain(right));
            let neither = vec![left.clone().negation(), right.clone().negation()];
            Expression::Or(vec![
                Expression::And(vec![left, right]),
                Expression::And(neither),
            ])
        }
        Expression::Not(inner) => plain(inner).negation(),
        Expression::And(operands) => Expression::And(all(operands)),
        Expression::Or(operands) => Expression::Or(all(operands)),
        Expression::Implies(left, right) => {
            Expression::Implies(Box::new(plain(left)), Box::new(plain(right)))
        }
        other => other.clone(),
    }
}
