//! What a sentence means, executed on finite and on ultimately periodic words.
//!
//! A word gives each proposition a truth value at each position. Let `M` be the mode, `C` what
//! triggers (the condition, or its negation after `unless`), and a *run* of something a maximal
//! interval of positions at which it holds. Then a sentence means:
//!
//! 1. The **scope** is a set of disjoint intervals of positions: everything; the runs of `M`; the
//!    runs of `!M` (not in, only in); from the first position to just before the first `M` (before);
//!    from just behind the first run of `M` on (after); from the first `M` on (only before); from the
//!    first position to the end of the first run of `M` (only after).
//! 2. **Triggers** of a scope interval `[s, e]`: without a condition `s`; with `upon`, the positions
//!    in it at which `C` holds and which are `s` or follow a position without `C`; with `whenever`,
//!    the positions in it at which `C` holds.
//! 3. At each trigger `t`, with the rest `[t, e]` of its interval, the **timing** has to be met as
//!    [`Timing`] says. With `only`, it has to be *not* met; where [`Timing`] excuses, it is excused
//!    either way, and a stop condition that does not come excuses `until`, not `before`.
//! 4. Of several **stages**, each but the last is completed at the first position that will do, and
//!    the next begins there. If the scope interval ends before, the rest is excused where the timing
//!    says so; `eventually` is not excused. A stop condition must come if a stage follows.
//!
//! The end of a finite word is no end of the scope. In this reading of finite words (that of LTLf;
//! G. De Giacomo and M. Vardi, "Linear temporal logic and linear dynamic logic on finite traces",
//! IJCAI 2013), what should have happened by the end and has not is missed, also if its time is not
//! yet over, and what should hold to the end has held.
//!
//! # Comparison with FRET
//! Scope, condition and timing are those of NASA's FRET (D. Giannakopoulou, T. Pressburger, A.
//! Mavridou and J. Schumann, "Automated formalization of structured natural language requirements",
//! Information and Software Technology 137, 2021, and the semantics published with the tool,
//! version 3). It deviates from them so:
//!
//! * FRET takes the end of a finite trace for an end of the scope, so `within` and `after` are
//!   excused if the trace ends before their time. Here the end of a trace is a matter of the
//!   monitor's ending.
//! * `after d` asks for the response at `d` and not before; FRET asks for it one step later. Thus it
//!   means the same in steps and in seconds.
//! * Durations have units, and are never read as steps.
//! * The probability is that of meeting the whole requirement in a run; in FRET it belongs to the
//!   timed response.
//! * There is no `finally` (at the last point of the scope). New are sequences of stages.
//!
//! On infinite words nothing else differs: `tests/peers/fret.py` compares the properties with the
//! formulas that FRET publishes, for all scopes, conditions and timings that both have.
//!
//! Cost: for each position all later ones, for stages repeatedly; this is an oracle for tests.

use crate::sentence::{Amount, ConditionKind, ScopeKind, Sentence, Stage, Timing};

/// A word: which propositions hold at which positions.
#[derive(Clone, Copy)]
pub struct Word<'w> {
    /// Whether the proposition of this text holds at this position.
    pub truth: &'w dyn Fn(usize, &str) -> bool,
    /// How many positions are given.
    pub length: usize,
    /// Where the word goes on after its last position: for ever repeated from this position on.
    /// `None` if it ends there.
    pub repeats_from: Option<usize>,
}

/// Whether the sentence holds of the word. Durations in seconds are read with one step as long as
/// `step_secs`, rounded down to whole steps. A sentence that is incomplete does not hold.
#[must_use]
pub fn holds(sentence: &Sentence, word: &Word<'_>, step_secs: f64) -> bool {
    if sentence.is_incomplete() {
        return false;
    }
    let reading = Reading::new(sentence, word, step_secs);
    let scope = reading.scope();
    let mut triggers = scope.iter().flat_map(|interval| reading.triggers(interval));
    triggers.all(|(at, interval)| {
        at >= reading.judged || reading.stages_met(&sentence.stages, at, &interval)
    })
}

/// The number of triggers in a finite word.
#[must_use]
pub fn triggers(sentence: &Sentence, word: &Word<'_>) -> usize {
    let reading = Reading::new(sentence, word, 1.0);
    reading
        .scope()
        .iter()
        .map(|interval| reading.triggers(interval).len())
        .sum()
}

/// An interval of positions, both ends included.
#[derive(Clone, Copy)]
struct Interval {
    first: usize,
    last: usize,
    /// Whether the scope ends there, or only what is known of the word.
    ends: bool,
}

impl Interval {
    fn positions(self) -> std::ops::RangeInclusive<usize> {
        self.first..=self.last
    }

    fn from(self, first: usize) -> Self {
        Interval { first, ..self }
    }

    /// What becomes of a stage that is under way at its end.
    fn cut_short(self) -> Completion {
        if self.ends {
            Completion::Excused
        } else {
            Completion::Missed
        }
    }

    /// Whether it has the position.
    fn has(self, position: usize) -> bool {
        self.positions().contains(&position)
    }
}

/// A sentence on a word that is written out far enough.
struct Reading<'a> {
    sentence: &'a Sentence,
    word: &'a Word<'a>,
    /// Positions that are written out.
    length: usize,
    /// Triggers from here on repeat earlier ones.
    judged: usize,
    step_secs: f64,
}

impl<'a> Reading<'a> {
    /// Behind the given positions and three repetitions nothing new comes: after one the past is
    /// settled ("once M"), after two the first run of `M` is over if it ever is, after three every
    /// interval has been seen whole. Each stage needs at most one more and its duration.
    fn new(sentence: &'a Sentence, word: &'a Word<'a>, step_secs: f64) -> Self {
        let mut reading = Reading {
            sentence,
            word,
            length: word.length,
            judged: word.length,
            step_secs,
        };
        if let Some(start) = word.repeats_from {
            let cycle = word.length.saturating_sub(start).max(1);
            reading.judged = word.length + 3 * cycle;
            let durations = sentence
                .stages
                .iter()
                .map(|stage| reading.steps(&stage.timing).unwrap_or(0));
            reading.length =
                reading.judged + durations.map(|steps| steps + 2 * cycle + 2).sum::<usize>();
        }
        reading
    }

    fn truth(&self, expression: &crate::expression::Expression, position: usize) -> bool {
        let folded = match self.word.repeats_from {
            Some(start) if position >= self.word.length => {
                start + (position - start) % (self.word.length - start).max(1)
            }
            _ => position,
        };
        expression.eval(&|text| (self.word.truth)(folded, text))
    }

    fn steps(&self, timing: &Timing) -> Option<usize> {
        timing.duration().map(|duration| match duration.amount {
            Amount::Steps(count) => count as usize,
            Amount::Secs(secs) => (secs / self.step_secs) as usize,
            Amount::Missing => 0,
        })
    }

    /// The maximal intervals of `0..length` in which `inside` holds.
    fn runs(&self, inside: impl Fn(usize) -> bool) -> Vec<Interval> {
        let mut runs: Vec<Interval> = Vec::new();
        for position in (0..self.length).filter(|position| inside(*position)) {
            let ends = position + 1 < self.length;
            match runs.last_mut() {
                Some(run) if run.last + 1 == position => (run.last, run.ends) = (position, ends),
                _ => runs.push(Interval {
                    first: position,
                    last: position,
                    ends,
                }),
            }
        }
        runs
    }

    fn scope(&self) -> Vec<Interval> {
        let mode = |position: usize| self.truth(&self.sentence.scope.mode, position);
        let first = self.runs(mode).first().copied();
        let begin = first.map_or(self.length, |run| run.first);
        let end = first.map_or(self.length, |run| run.last + 1);
        match self.sentence.scope.kind {
            ScopeKind::Global => self.runs(|_| true),
            ScopeKind::In => self.runs(mode),
            ScopeKind::NotIn | ScopeKind::OnlyIn => self.runs(|position| !mode(position)),
            ScopeKind::Before => self.runs(|position| position < begin),
            ScopeKind::After => self.runs(|position| position >= end),
            ScopeKind::OnlyBefore => self.runs(|position| position >= begin),
            ScopeKind::OnlyAfter => self.runs(|position| position < end),
        }
    }

    /// The triggers of a scope interval, each with the rest of it.
    fn triggers(&self, interval: &Interval) -> Vec<(usize, Interval)> {
        let triggered = |position: usize| match &self.sentence.condition {
            None => position == interval.first,
            Some(condition) => {
                let what = condition.triggering();
                let here = self.truth(&what, position);
                match condition.kind {
                    ConditionKind::Whenever => here,
                    ConditionKind::Upon | ConditionKind::Unless => {
                        here && (position == interval.first || !self.truth(&what, position - 1))
                    }
                }
            }
        };
        let positions = interval.positions().filter(|position| triggered(*position));
        positions
            .map(|position| (position, interval.from(position)))
            .collect()
    }

    fn stages_met(&self, stages: &[Stage], at: usize, interval: &Interval) -> bool {
        let rest = interval.from(at);
        match stages {
            [] => true,
            [last] if self.sentence.scope.kind.is_only() => self.not_met(last, rest),
            [last] => self.met(last, rest),
            [stage, later @ ..] => match self.completed(stage, rest) {
                Completion::At(position) => self.stages_met(later, position, interval),
                Completion::Excused => true,
                Completion::Missed => false,
            },
        }
    }

    /// The first position in `interval` at which the stop condition holds.
    fn stop(&self, timing: &Timing, interval: Interval) -> Option<usize> {
        let stop = timing.stop()?;
        interval
            .positions()
            .find(|position| self.truth(stop, *position))
    }

    /// Whether the timing is met in the rest `[t, e]` of the scope interval of a trigger `t`.
    fn met(&self, stage: &Stage, rest: Interval) -> bool {
        let response = |position: usize| self.truth(&stage.response, position);
        let steps = self.steps(&stage.timing).unwrap_or(0);
        let due = rest.first + steps;
        let stop = self.stop(&stage.timing, rest);
        match stage.timing {
            Timing::Immediately => response(rest.first),
            Timing::Next => self.at(rest, rest.first + 1, &response),
            Timing::Eventually => rest.positions().any(response),
            Timing::Always => rest.positions().all(response),
            Timing::Never => !rest.positions().any(response),
            Timing::Within(_) => {
                let in_time = rest
                    .positions()
                    .any(|position| position <= due && response(position));
                in_time || (rest.ends && rest.last < due)
            }
            Timing::For(_) => rest
                .positions()
                .all(|position| position > due || response(position)),
            Timing::After(_) => {
                let early = rest
                    .positions()
                    .any(|position| position < due && response(position));
                !early && self.at(rest, due, &response)
            }
            Timing::Until(_) => rest
                .positions()
                .all(|position| stop.is_some_and(|stop| position >= stop) || response(position)),
            Timing::Before(_) => stop.is_none_or(|stop| {
                rest.positions()
                    .any(|position| position < stop && response(position))
            }),
        }
    }

    /// Whether the response holds at a position, or the scope ends before it.
    fn at(&self, rest: Interval, position: usize, response: &dyn Fn(usize) -> bool) -> bool {
        if rest.has(position) {
            response(position)
        } else {
            rest.ends
        }
    }

    /// Whether the timing is not met, as `only` demands.
    fn not_met(&self, stage: &Stage, rest: Interval) -> bool {
        let response = |position: usize| self.truth(&stage.response, position);
        let missing = |position: usize| !self.truth(&stage.response, position);
        let due = rest.first + self.steps(&stage.timing).unwrap_or(0);
        let stop = self.stop(&stage.timing, rest);
        match stage.timing {
            Timing::Immediately => missing(rest.first),
            Timing::Next => self.at(rest, rest.first + 1, &missing),
            Timing::Eventually => !rest.positions().any(response),
            Timing::Always => rest.positions().any(missing),
            Timing::Never => rest.positions().any(response),
            // Nowhere in the time, also if the scope ends before it is over.
            Timing::Within(_) => !rest
                .positions()
                .any(|position| position <= due && response(position)),
            // Somewhere in the time not; excused if the scope ends before it is over.
            Timing::For(_) => {
                let broken = rest
                    .positions()
                    .any(|position| position <= due && missing(position));
                broken || (rest.ends && rest.last < due)
            }
            Timing::After(_) => {
                let early = rest
                    .positions()
                    .any(|position| position < due && response(position));
                early || !rest.has(due) || missing(due)
            }
            Timing::Until(_) => stop.is_none_or(|stop| {
                rest.positions()
                    .any(|position| position < stop && missing(position))
            }),
            Timing::Before(_) => {
                let until = |position: usize| stop.is_some_and(|stop| position >= stop);
                rest.positions()
                    .all(|position| until(position) || missing(position))
            }
        }
    }

    /// Where a stage that is followed by another is completed.
    fn completed(&self, stage: &Stage, rest: Interval) -> Completion {
        let response = |position: usize| self.truth(&stage.response, position);
        let due = rest.first + self.steps(&stage.timing).unwrap_or(0);
        let first = rest.positions().find(|position| response(*position));
        let here = |position: usize, well: bool| match (well, rest.has(position)) {
            (false, _) => Completion::Missed,
            (true, true) => Completion::At(position),
            (true, false) => rest.cut_short(),
        };
        match stage.timing {
            Timing::Immediately => here(rest.first, response(rest.first)),
            Timing::Next => {
                let next = rest.first + 1;
                here(next, !rest.has(next) || response(next))
            }
            Timing::Eventually => first.map_or(Completion::Missed, Completion::At),
            Timing::Within(_) => match first {
                Some(first) if first <= due => Completion::At(first),
                _ if rest.has(due) => Completion::Missed,
                _ => rest.cut_short(),
            },
            Timing::For(_) => {
                let held = |position: usize| position > due || response(position);
                here(due, rest.positions().all(held))
            }
            Timing::After(_) => {
                let early = first.is_some_and(|first| first < due);
                here(due, !early && (!rest.has(due) || response(due)))
            }
            Timing::Until(_) | Timing::Before(_) => self.completed_by_stop(stage, rest, first),
            Timing::Always | Timing::Never => Completion::Missed,
        }
    }

    /// The same for `until` and `before`; `first` is where the response first holds.
    fn completed_by_stop(&self, stage: &Stage, rest: Interval, first: Option<usize>) -> Completion {
        let stop = self.stop(&stage.timing, rest);
        let open = |position: &usize| stop.is_none_or(|stop| *position < stop);
        match (&stage.timing, first.filter(open), stop) {
            (Timing::Before(_), Some(first), _) => Completion::At(first),
            (Timing::Before(_), None, Some(_)) => Completion::Missed,
            (Timing::Before(_), None, None) => rest.cut_short(),
            (_, _, stop) => {
                let held = |position: usize| self.truth(&stage.response, position);
                match stop {
                    _ if !rest.positions().take_while(open).all(held) => Completion::Missed,
                    Some(stop) => Completion::At(stop),
                    None => rest.cut_short(),
                }
            }
        }
    }
}

/// Where a stage is completed.
#[derive(Clone, Copy)]
enum Completion {
    At(usize),
    /// The scope ended before.
    Excused,
    Missed,
}
