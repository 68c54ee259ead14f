//! Coverage bins: situations of a requirement that a campaign of tests should have been in.
//!
//! A bin is a formula; a trace hits it if the formula is satisfied. Besides scope and trigger, the
//! ways in which the obligation can be met are told apart, with the boundaries of its times: a
//! response within 2 s can come in the first half, in the second half, or late.

use temporal::formula::{Formula, Parsed};

use super::body::{Extent, When, obligation};
use super::build::{ALL, Numbering, always, and, at, eventually, not, until, up_to};
use super::frame::Frame;
use super::{NotExpressible, check};
use crate::sentence::{Amount, ScopeKind, Sentence};

/// A situation to be covered.
#[derive(Clone, Debug, PartialEq)]
pub struct Bin {
    /// A short name, unique among the bins of a sentence, for example `response-first-half`.
    pub name: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
    /// Satisfied by the traces that hit the bin.
    pub formula: Parsed,
}

/// The bins of a sentence. Of several stages, only the whole is told apart into met and missed.
///
/// ```
/// use requirement_lang::{Context, compile::coverage::bins, parse};
/// let text = "In lifting mode, when near, the robot shall within 2 s satisfy slow";
/// let sentence = parse(text, &Context::default()).into_result().unwrap();
/// let names: Vec<&str> = bins(&sentence)?.iter().map(|bin| bin.name).collect();
/// assert_eq!(names, [
///     "scope-entered", "triggered", "triggered-again", "met", "missed",
///     "response-first-half", "response-second-half", "response-late", "scope-ended-first",
/// ]);
/// # Ok::<(), requirement_lang::compile::NotExpressible>(())
/// ```
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning.
pub fn bins(sentence: &Sentence) -> Result<Vec<Bin>, NotExpressible> {
    check(sentence)?;
    let mut numbering = Numbering::default();
    let frame = Frame::new(sentence, &mut numbering);
    let mut bins = Bins {
        trigger: frame.trigger(),
        list: Vec::new(),
    };
    if sentence.scope.kind != ScopeKind::Global {
        bins.somewhere("scope-entered", "the scope is entered", frame.scope());
    }
    bins.at_trigger("triggered", "the requirement is triggered", Formula::True);
    if sentence.condition.is_some() {
        let again = and([bins.trigger.clone(), not(Formula::rise(Formula::True))]);
        let later = eventually(ALL, again);
        let twice = and([bins.trigger.clone(), later_than_now(&bins.trigger, later)]);
        bins.somewhere(
            "triggered-again",
            "the requirement is triggered more than once",
            twice,
        );
    }
    let body = obligation(&frame.stages, &frame.extent());
    bins.at_trigger(
        "met",
        "a trigger is followed by what is required",
        body.clone(),
    );
    bins.at_trigger(
        "missed",
        "a trigger is not followed by what is required",
        not(body),
    );
    if let [(when, response)] = frame.stages.as_slice() {
        bins.timing(when, response, &frame.extent());
    }
    let atoms = numbering.atoms;
    let parsed = |(name, meaning, formula)| Bin {
        name,
        meaning,
        formula: Parsed {
            formula,
            atoms: atoms.clone(),
        },
    };
    Ok(bins.list.into_iter().map(parsed).collect())
}

/// That the trigger ends and `later` follows.
fn later_than_now(trigger: &Formula, later: Formula) -> Formula {
    until(ALL, Formula::True, and([not(trigger.clone()), later]))
}

/// A name, a meaning and a formula.
type Entry = (&'static str, &'static str, Formula);

struct Bins {
    trigger: Formula,
    list: Vec<Entry>,
}

impl Bins {
    fn somewhere(&mut self, name: &'static str, meaning: &'static str, what: Formula) {
        self.list.push((name, meaning, eventually(ALL, what)));
    }

    fn at_trigger(&mut self, name: &'static str, meaning: &'static str, what: Formula) {
        let formula = and([self.trigger.clone(), what]);
        self.somewhere(name, meaning, formula);
    }

    /// The ways of one stage.
    fn timing(&mut self, when: &When, response: &Formula, extent: &Extent) {
        let scope = match extent {
            Extent::While(scope) => scope.clone(),
            _ => Formula::True,
        };
        let open = |what: Formula| and([scope.clone(), what]);
        match when {
            When::Within(amount) => self.within(*amount, response, &scope),
            When::Until(stop) | When::Before(stop) => {
                let stopped = until(ALL, scope.clone(), open(stop.clone()));
                self.at_trigger("stopped", "the stop condition comes", stopped.clone());
                self.at_trigger(
                    "not-stopped",
                    "the stop condition does not come",
                    not(stopped),
                );
            }
            When::Eventually => {
                self.at_trigger(
                    "response-at-once",
                    "the response is there at the trigger",
                    response.clone(),
                );
                let later = until(ALL, scope.clone(), open(response.clone()));
                self.at_trigger(
                    "response-later",
                    "the response comes after the trigger",
                    and([not(response.clone()), later]),
                );
            }
            When::For(amount) | When::After(amount) | When::NotAfter(amount) => {
                let lasts = until(at(*amount), scope.clone(), scope.clone());
                self.at_trigger(
                    "scope-lasts",
                    "the scope lasts for the whole time",
                    lasts.clone(),
                );
                self.ended_first(&scope, lasts);
            }
            When::Immediately | When::Next | When::Always | When::Never => {}
        }
    }

    fn within(&mut self, amount: Amount, response: &Formula, scope: &Formula) {
        let half = match amount {
            Amount::Secs(secs) => Amount::Secs(secs / 2.0),
            Amount::Steps(count) => Amount::Steps(count / 2),
            Amount::Missing => Amount::Missing,
        };
        let reached = |amount| {
            until(
                up_to(amount),
                scope.clone(),
                and([scope.clone(), response.clone()]),
            )
        };
        let (early, in_time) = (reached(half), reached(amount));
        self.at_trigger(
            "response-first-half",
            "the response comes in the first half of the time",
            early.clone(),
        );
        self.at_trigger(
            "response-second-half",
            "the response comes in the second half of the time",
            and([not(early), in_time.clone()]),
        );
        let still = always(up_to(amount), and([scope.clone(), not(response.clone())]));
        self.at_trigger(
            "response-late",
            "the time passes in the scope without the response",
            still.clone(),
        );
        self.ended_first(scope, or_reached(in_time, still));
    }

    /// That the scope ends before anything else is decided.
    fn ended_first(&mut self, scope: &Formula, decided: Formula) {
        if *scope != Formula::True {
            self.at_trigger(
                "scope-ended-first",
                "the scope ends before the time is over",
                not(decided),
            );
        }
    }
}

fn or_reached(in_time: Formula, still: Formula) -> Formula {
    super::build::or([in_time, still])
}
