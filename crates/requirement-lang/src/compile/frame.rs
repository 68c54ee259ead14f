//! Where the triggers are: the frame around the obligation.
//!
//! With `M` for the mode, the scope is `S` and extends while `E` holds:
//!
//! | scope | `S` | `E` |
//! |---|---|---|
//! | global | `true` | for ever |
//! | in M | `M` | `M` |
//! | not in M, only in M | `!M` | `!M` |
//! | before M | `historically !M` | `!M` |
//! | after M | `once (!M & once M)` | for ever |
//! | only before M | `once M` | for ever |
//! | only after M | `!once (!M & once M)` | `S` |
//!
//! With `C` for the condition, the trigger is `rise(S & C)` for `upon`, `S & C` for `whenever`, and
//! `rise(S)` without a condition. For, at a time in the scope, `S & C` becomes true where `C` becomes
//! true within the scope interval or holds at its beginning, and nowhere else.
//!
//! In future logic the frame of an obligation `B` is, with `rising(c) = (c => B) & G(!c => X(c => B))`
//! and `L = M & X !M`, the last step of a run of `M`:
//!
//! | scope | no condition | upon C | whenever C |
//! |---|---|---|---|
//! | global | `B` | `rising(C)` | `G(C => B)` |
//! | in M | `rising(M)` | `rising(M & C)` | `G(M & C => B)` |
//! | not in M, only in M | the same with `!M` for `M` | | |
//! | before M | `!M => B` | `(!M & C => B) & ((!C => X(C & !M => B)) W M)` | `(C => B) W M` |
//! | after M | `!M W (M & (M W (!M & g)))` with the global frame `g` | | |
//! | only before M | `!M W (M & g)` | | |
//! | only after M | `B` | `(C => B) & ((!C => X(C => B)) W L)` | `(C => B) W (L & (C => B))` |

use temporal::formula::Formula;

use super::body::{Extent, When, negated, obligation};
use super::build::{
    ALL, Numbering, always, and, eventually, historically, implies, next, not, once, until,
    weak_until,
};
use crate::sentence::{ConditionKind, ScopeKind, Sentence, Timing};

/// The parts of a sentence as formulas.
pub(super) struct Frame {
    scope: ScopeKind,
    mode: Formula,
    condition: Option<(bool, Formula)>,
    /// Timing and response of each stage, negated where the scope has `only`.
    pub(super) stages: Vec<(When, Formula)>,
}

impl Frame {
    /// The parts of a sentence that was checked.
    pub(super) fn new(sentence: &Sentence, numbering: &mut Numbering) -> Self {
        let mode = numbering.formula(&sentence.scope.mode);
        let condition = sentence.condition.as_ref().map(|condition| {
            let continual = condition.kind == ConditionKind::Whenever;
            (continual, numbering.formula(&condition.triggering()))
        });
        let mut stages = Vec::new();
        for stage in &sentence.stages {
            let when = when(&stage.timing, numbering);
            let response = numbering.formula(&stage.response);
            stages.push(match sentence.scope.kind.is_only() {
                true => negated(when, response),
                false => (when, response),
            });
        }
        Frame {
            scope: sentence.scope.kind,
            mode,
            condition,
            stages,
        }
    }

    /// What holds in the scope and not outside, with past operators.
    pub(super) fn scope(&self) -> Formula {
        let mode = || self.mode.clone();
        match self.scope {
            ScopeKind::Global => Formula::True,
            ScopeKind::In => mode(),
            ScopeKind::NotIn | ScopeKind::OnlyIn => not(mode()),
            ScopeKind::Before => historically(not(mode())),
            ScopeKind::After => once(and([not(mode()), once(mode())])),
            ScopeKind::OnlyBefore => once(mode()),
            ScopeKind::OnlyAfter => not(once(and([not(mode()), once(mode())]))),
        }
    }

    /// How far the scope extends from a trigger, for monitors.
    pub(super) fn extent(&self) -> Extent {
        match self.scope {
            ScopeKind::Global | ScopeKind::After | ScopeKind::OnlyBefore => Extent::Forever,
            ScopeKind::In => Extent::While(self.mode.clone()),
            ScopeKind::NotIn | ScopeKind::OnlyIn | ScopeKind::Before => {
                Extent::While(not(self.mode.clone()))
            }
            ScopeKind::OnlyAfter => Extent::While(self.scope()),
        }
    }

    /// Where the obligation arises, with past operators.
    pub(super) fn trigger(&self) -> Formula {
        match &self.condition {
            None => Formula::rise(self.scope()),
            Some((true, condition)) => and([self.scope(), condition.clone()]),
            Some((false, condition)) => Formula::rise(and([self.scope(), condition.clone()])),
        }
    }

    /// What holds everywhere in the scope, if the sentence is an invariant of its scope.
    fn invariant(&self) -> Option<Formula> {
        match (&self.condition, self.stages.as_slice()) {
            (None, [(When::Always, response)]) => Some(response.clone()),
            (None, [(When::Never, response)]) => Some(not(response.clone())),
            _ => None,
        }
    }

    /// The whole, with past operators.
    pub(super) fn with_past(&self) -> Formula {
        if let Some(invariant) = self.invariant() {
            return always(ALL, implies(self.scope(), invariant));
        }
        let body = obligation(&self.stages, &self.extent());
        if self.scope == ScopeKind::Global && self.condition.is_none() {
            return body;
        }
        always(ALL, implies(self.trigger(), body))
    }

    /// The whole, without past operators, for durations in steps.
    pub(super) fn without_past(&self) -> Formula {
        let scope = match self.scope {
            ScopeKind::Global => Some(Formula::True),
            ScopeKind::In => Some(self.mode.clone()),
            ScopeKind::NotIn | ScopeKind::OnlyIn => Some(not(self.mode.clone())),
            _ => None,
        };
        match (scope, self.invariant()) {
            (Some(scope), Some(invariant)) => always(ALL, implies(scope, invariant)),
            (Some(scope), None) => self.local(scope, obligation(&self.stages, &self.extent())),
            (None, _) => self.since_first_run(),
        }
    }

    /// The frame of a scope that is known from the present.
    fn local(&self, scope: Formula, body: Formula) -> Formula {
        match &self.condition {
            None if scope == Formula::True => body,
            None => rising(scope, body),
            Some((true, condition)) => always(ALL, implies(and([scope, condition.clone()]), body)),
            Some((false, condition)) => rising(and([scope, condition.clone()]), body),
        }
    }

    /// The frame of a scope that depends on the first run of the mode.
    fn since_first_run(&self) -> Formula {
        let mode = || self.mode.clone();
        let outside = || not(mode());
        let after = |begin: Formula| {
            let body = obligation(&self.stages, &Extent::Forever);
            weak_until(
                outside(),
                and([mode(), begin_with(begin, self.local(Formula::True, body))]),
            )
        };
        match self.scope {
            ScopeKind::Before => self.before(),
            ScopeKind::OnlyBefore => after(Formula::True),
            ScopeKind::After => after(mode()),
            _ => self.through_first_run(),
        }
    }

    fn before(&self) -> Formula {
        let outside = || not(self.mode.clone());
        let body = || obligation(&self.stages, &Extent::While(outside()));
        match &self.condition {
            None => implies(outside(), body()),
            Some((true, condition)) => {
                weak_until(implies(condition.clone(), body()), self.mode.clone())
            }
            Some((false, condition)) => {
                let rises = next(implies(and([condition.clone(), outside()]), body()));
                and([
                    implies(and([outside(), condition.clone()]), body()),
                    weak_until(implies(not(condition.clone()), rises), self.mode.clone()),
                ])
            }
        }
    }

    fn through_first_run(&self) -> Formula {
        let last = || and([self.mode.clone(), next(not(self.mode.clone()))]);
        let body = || obligation(&self.stages, &Extent::Through(last()));
        match &self.condition {
            None => body(),
            Some((true, condition)) => {
                let here = || implies(condition.clone(), body());
                weak_until(here(), and([last(), here()]))
            }
            Some((false, condition)) => {
                let here = || implies(condition.clone(), body());
                let rises = implies(not(condition.clone()), next(here()));
                and([here(), weak_until(rises, last())])
            }
        }
    }

    /// That a trigger is reached, without past operators.
    pub(super) fn trigger_reached(&self) -> Formula {
        let mode = || self.mode.clone();
        let condition =
            (self.condition.as_ref()).map_or(Formula::True, |(_, condition)| condition.clone());
        match self.scope {
            ScopeKind::Global => eventually(ALL, condition),
            ScopeKind::In => eventually(ALL, and([mode(), condition])),
            ScopeKind::NotIn | ScopeKind::OnlyIn => eventually(ALL, and([not(mode()), condition])),
            ScopeKind::Before => until(ALL, not(mode()), and([not(mode()), condition])),
            ScopeKind::OnlyBefore => eventually(ALL, and([mode(), eventually(ALL, condition)])),
            ScopeKind::After => {
                let later = and([not(mode()), eventually(ALL, condition)]);
                eventually(ALL, and([mode(), eventually(ALL, later)]))
            }
            ScopeKind::OnlyAfter => {
                let last = and([mode(), next(not(mode()))]);
                until(ALL, not(last), condition)
            }
        }
    }
}

/// `begin` until the rest begins, where it does not hold; nothing at all if `begin` is true.
fn begin_with(begin: Formula, rest: Formula) -> Formula {
    match begin {
        Formula::True => rest,
        begin => weak_until(begin.clone(), and([not(begin), rest])),
    }
}

fn rising(condition: Formula, body: Formula) -> Formula {
    let later = next(implies(condition.clone(), body.clone()));
    and([
        implies(condition.clone(), body),
        always(ALL, implies(not(condition), later)),
    ])
}

fn when(timing: &Timing, numbering: &mut Numbering) -> When {
    match timing {
        Timing::Immediately => When::Immediately,
        Timing::Next => When::Next,
        Timing::Eventually => When::Eventually,
        Timing::Always => When::Always,
        Timing::Never => When::Never,
        Timing::Within(duration) => When::Within(duration.amount),
        Timing::For(duration) => When::For(duration.amount),
        Timing::After(duration) => When::After(duration.amount),
        Timing::Until(stop) => When::Until(numbering.formula(stop)),
        Timing::Before(stop) => When::Before(numbering.formula(stop)),
    }
}
