//! Coverage bins: situations of a requirement that a campaign of tests should have been in.
//!
//! A bin is a formula; a trace hits it if the formula is satisfied, best judged so that what a trace
//! leaves open is not counted ([`Ending::Inconclusive`](temporal::formula::Ending)). Besides scope and trigger, the
//! ways in which the obligation can be met are told apart, with the boundaries of its times: a
//! response within 2 s can come in the first half, in the second half, or late.

use temporal::formula::{Formula, Parsed};

use super::body::{Extent, When, obligation};
use super::build::{ALL, Numbering, and, at, eventually, not, until, up_to};
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
    bins.triggers(sentence, &frame);
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

    /// Scope and trigger.
    fn triggers(&mut self, sentence: &Sentence, frame: &Frame) {
        if sentence.scope.kind != ScopeKind::Global {
            self.somewhere("scope-entered", "the scope is entered", frame.scope());
        }
        self.at_trigger("triggered", "the requirement is triggered", Formula::True);
        if sentence.condition.is_some() {
            let again = eventually(ALL, self.trigger.clone());
            let ends = eventually(ALL, and([not(self.trigger.clone()), again]));
            self.at_trigger(
                "triggered-again",
                "the requirement is triggered more than once",
                ends,
            );
        }
    }

    /// The ways of one stage.
    fn timing(&mut self, when: &When, response: &Formula, extent: &Extent) {
        let scope = match extent {
            Extent::While(scope) => scope.clone(),
            _ => Formula::True,
        };
        let reached =
            |what: &Formula| until(ALL, scope.clone(), and([scope.clone(), what.clone()]));
        match when {
            When::Within(amount) => self.within(*amount, response, &scope),
            When::Until(stop) | When::Before(stop) => {
                let stopped = reached(stop);
                self.at_trigger("stopped", "the stop condition comes", stopped.clone());
                self.at_trigger(
                    "not-stopped",
                    "the stop condition does not come",
                    not(stopped),
                );
            }
            When::Eventually => {
                let later = and([not(response.clone()), reached(response)]);
                let at_once = response.clone();
                self.at_trigger(
                    "response-at-once",
                    "the response is there at the trigger",
                    at_once,
                );
                self.at_trigger(
                    "response-later",
                    "the response comes after the trigger",
                    later,
                );
            }
            When::For(amount) | When::After(amount) | When::NotAfter(amount) => {
                let lasts = until(at(*amount), scope.clone(), scope.clone());
                self.at_trigger("scope-lasts", "the scope lasts for the whole time", lasts);
                self.ended_first(*amount, &scope, scope.clone());
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
        let waiting = and([scope.clone(), not(response.clone())]);
        self.at_trigger(
            "response-late",
            "the time passes in the scope without the response",
            until(at(amount), waiting.clone(), waiting.clone()),
        );
        self.ended_first(amount, scope, waiting);
    }

    /// That the scope ends in the time, before anything else is decided.
    fn ended_first(&mut self, amount: Amount, scope: &Formula, undecided: Formula) {
        if *scope != Formula::True {
            self.at_trigger(
                "scope-ended-first",
                "the scope ends before the time is over",
                until(up_to(amount), undecided, not(scope.clone())),
            );
        }
    }
}
