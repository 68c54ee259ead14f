//! The obligation that a trigger brings: a formula that looks into the future only.
//!
//! Let `R` be the response. The scope interval of the trigger extends for ever, or *while* `S`
//! holds (it ends before the first time without `S`), or *through* the first `L`, which is its last
//! step. `F`, `G`, `U`, `W`, `X` are read from the trigger on; `[n]` is exactly `n` later.
//!
//! | timing | while `S` | through `L` |
//! |---|---|---|
//! | immediately | `R` | `R` |
//! | at the next step | `X (R \| !S)` | `L \| X R` |
//! | eventually | `S U (S & R)` | `!L U R` |
//! | always | `R W !S` | |
//! | never | `!R W !S` | `!(!L U R)` |
//! | within n | `F[0,n] (R \| !S)` | `!((!R & !L) U[n] !R)` |
//! | for n | `!(S U[0,n] (S & !R))` | `!(!L U[0,n] !R)` |
//! | after n | `(S & !R) U[n] (S & R) \| (S & !R) U[0,n] !S` | |
//! | until Q | `R W (Q \| !S)` | `!((!Q & !L) U (!Q & !R))` |
//! | before Q | `!((S & !R) U (S & Q))` | `!((!R & !L) U Q)` |
//!
//! With `only`, the timing is negated, but what is excused stays excused: the negation of "within n
//! R" is "for n not R" and the other way round, likewise "until" and "before", "always" and
//! "eventually not", "never" and "eventually". The negation of "after n" is `!((S & !R) U[n] (S & R))`.
//!
//! Of several stages, all but the last are completed at a point, the first one that will do, and the
//! next stage begins at that point. With `K` for what has to hold there:
//!
//! | timing | then `K` |
//! |---|---|
//! | immediately | `R & K` |
//! | at the next step | `X (!S \| (R & K))` |
//! | eventually | `(S & !R) U (S & R & K)` |
//! | within n | `(S & !R) U[0,n] (!S \| (R & K))` |
//! | for n | `(S & R) U[n] (S & R & K) \| (S & R) U[0,n] !S` |
//! | after n | `(S & !R) U[n] (S & R & K) \| (S & !R) U[0,n] !S` |
//! | until Q | `(S & R & !Q) U (!S \| (Q & K))` |
//! | before Q | `(S & !R & !Q) U (!S \| (R & !Q & K))` |
//!
//! So a stop condition has to come if another stage follows it.

use temporal::formula::Formula;

use super::build::{ALL, always, and, at, eventually, next, not, or, until, up_to, weak_until};
use crate::sentence::Amount;

/// How far the scope interval of a trigger extends.
#[derive(Clone, Debug)]
pub(super) enum Extent {
    /// It has no end.
    Forever,
    /// It ends before the first time at which this does not hold.
    While(Formula),
    /// Its last step is the first one at which this holds. Durations are in steps.
    Through(Formula),
}

/// A timing whose stop condition is a formula.
#[derive(Clone, Debug)]
pub(super) enum When {
    Immediately,
    Next,
    Eventually,
    Always,
    Never,
    Within(Amount),
    For(Amount),
    After(Amount),
    /// The negation of `After`.
    NotAfter(Amount),
    Until(Formula),
    Before(Formula),
}

/// The timing and response that hold where the given ones, as `only` has it, do not.
pub(super) fn negated(when: When, response: Formula) -> (When, Formula) {
    match when {
        When::Immediately => (When::Immediately, not(response)),
        When::Next => (When::Next, not(response)),
        When::Eventually => (When::Never, response),
        When::Always => (When::Eventually, not(response)),
        When::Never => (When::Eventually, response),
        When::Within(amount) => (When::For(amount), not(response)),
        When::For(amount) => (When::Within(amount), not(response)),
        When::After(amount) => (When::NotAfter(amount), response),
        When::NotAfter(amount) => (When::After(amount), response),
        When::Until(stop) => (When::Before(stop), not(response)),
        When::Before(stop) => (When::Until(stop), not(response)),
    }
}

/// The obligation of all stages, the first one beginning at the trigger.
pub(super) fn obligation(stages: &[(When, Formula)], extent: &Extent) -> Formula {
    let Some(((when, response), earlier)) = stages.split_last() else {
        return Formula::True;
    };
    let last = match extent {
        Extent::Forever => within_scope(when, response.clone(), &Formula::True),
        Extent::While(scope) => within_scope(when, response.clone(), scope),
        Extent::Through(end) => through(when, response.clone(), end),
    };
    let scope = match extent {
        Extent::While(scope) => scope.clone(),
        _ => Formula::True,
    };
    (earlier.iter().rev()).fold(last, |following, (when, response)| {
        staged(when, response.clone(), &scope, following)
    })
}

fn within_scope(when: &When, response: Formula, scope: &Formula) -> Formula {
    let s = || scope.clone();
    let over = || not(scope.clone());
    match when {
        When::Immediately => response,
        When::Next => next(or([response, over()])),
        When::Eventually => until(ALL, s(), and([s(), response])),
        When::Always => weak_until(response, over()),
        When::Never => weak_until(not(response), over()),
        When::Within(amount) => eventually(up_to(*amount), or([response, over()])),
        When::For(amount) if *scope == Formula::True => always(up_to(*amount), response),
        When::For(amount) => not(until(up_to(*amount), s(), and([s(), not(response)]))),
        When::After(amount) => {
            let waiting = and([s(), not(response.clone())]);
            exactly(*amount, waiting, and([s(), response]), scope)
        }
        When::NotAfter(amount) => {
            let waiting = and([s(), not(response.clone())]);
            not(until(at(*amount), waiting, and([s(), response])))
        }
        When::Until(stop) => weak_until(response, or([stop.clone(), over()])),
        When::Before(stop) => not(until(
            ALL,
            and([s(), not(response)]),
            and([s(), stop.clone()]),
        )),
    }
}

/// `waiting` up to exactly `amount` from now, and `reached` there, unless the scope ends before.
fn exactly(amount: Amount, waiting: Formula, reached: Formula, scope: &Formula) -> Formula {
    let over = match scope {
        Formula::True => Formula::False,
        scope => until(up_to(amount), waiting.clone(), not(scope.clone())),
    };
    or([until(at(amount), waiting, reached), over])
}

fn through(when: &When, response: Formula, end: &Formula) -> Formula {
    let open = || not(end.clone());
    match when {
        When::Immediately => response,
        When::Next => or([end.clone(), next(response)]),
        When::Eventually => until(ALL, open(), response),
        When::Never => not(until(ALL, open(), response)),
        When::Within(amount) => {
            let missed = not(response);
            not(until(at(*amount), and([missed.clone(), open()]), missed))
        }
        When::For(amount) => not(until(up_to(*amount), open(), not(response))),
        When::NotAfter(amount) => {
            let waiting = and([not(response.clone()), open()]);
            not(until(at(*amount), waiting, response))
        }
        When::Until(stop) => {
            let going = and([not(stop.clone()), open()]);
            not(until(ALL, going, and([not(stop.clone()), not(response)])))
        }
        When::Before(stop) => not(until(ALL, and([not(response), open()]), stop.clone())),
        // This extent is that of `only after`, and no timing has these for its negation.
        When::Always | When::After(_) => Formula::False,
    }
}

fn staged(when: &When, response: Formula, scope: &Formula, following: Formula) -> Formula {
    let s = || scope.clone();
    let over = || not(scope.clone());
    let missed = not(response.clone());
    let done = and([response.clone(), following.clone()]);
    match when {
        When::Immediately => done,
        When::Next => next(or([over(), done])),
        When::Eventually => until(ALL, and([s(), missed]), and([s(), done])),
        When::Within(amount) => until(up_to(*amount), and([s(), missed]), or([over(), done])),
        When::For(amount) => exactly(*amount, and([s(), response]), and([s(), done]), scope),
        When::After(amount) => exactly(*amount, and([s(), missed]), and([s(), done]), scope),
        When::Until(stop) => {
            let going = and([s(), response, not(stop.clone())]);
            until(ALL, going, or([over(), and([stop.clone(), following])]))
        }
        When::Before(stop) => {
            let going = and([s(), missed, not(stop.clone())]);
            until(ALL, going, or([over(), and([done, not(stop.clone())])]))
        }
        // Refused before: nothing comes after a stage that never ends, nor after `only`.
        When::Always | When::Never | When::NotAfter(_) => Formula::False,
    }
}
