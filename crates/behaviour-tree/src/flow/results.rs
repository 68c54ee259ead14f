//! How a run goes on when a node has ended: what its parent makes of the result.

use super::{At, Change, Command, Counter, Guard, Making, Target, Variable, sure};
use crate::tree::{Kind, NodeId, Outcome};

use Outcome::{Failure, Skipped, Success};

impl Making<'_> {
    /// Where a run goes on when a node has ended so.
    pub(super) fn result(&mut self, id: NodeId, outcome: Outcome) -> Target {
        let Some((parent, at)) = self.tree.node(id).parent else {
            return self.point(id, At::Over(outcome));
        };
        match self.kind(parent).clone() {
            Kind::Leaf(_) | Kind::Always(_) => unreachable!("leaves have no children in the model"),
            Kind::Pass | Kind::Switch | Kind::Gate(_) | Kind::Deadline => {
                self.result(parent, outcome)
            }
            Kind::Inverter => self.result(parent, inverted(outcome)),
            Kind::Force(forced) if outcome != Skipped => self.result(parent, forced),
            Kind::Force(_) => self.result(parent, Skipped),
            Kind::Sequence { memory, .. } => self.in_sequence(parent, at, outcome, memory),
            Kind::Fallback => self.in_fallback(parent, at, outcome),
            Kind::TryCatch => self.in_try(parent, at, outcome),
            Kind::Choice => self.in_choice(parent, at, outcome),
            Kind::Parallel { .. } => self.in_parallel(parent, at, outcome),
            Kind::ParallelAll { failures } => self.in_parallel_all(parent, at, outcome, failures),
            Kind::Retry(most) => self.in_loop(parent, outcome, most, Failure),
            Kind::Repeat(most) => self.in_loop(parent, outcome, most, Success),
            Kind::KeepRunningUntilFailure => match outcome {
                Failure => self.result(parent, Failure),
                Success | Skipped => self.point(parent, At::Again),
            },
            Kind::RunOnce { then_skip } => self.in_run_once(parent, outcome, then_skip),
            Kind::Recovery(most) => self.in_recovery(parent, at, outcome, most),
            Kind::RoundRobin { wraps } => self.in_round_robin(parent, at, outcome, wraps),
        }
    }

    /// The counter that tells whether a child was executed, where all may be skipped.
    fn any(&mut self, id: NodeId) -> Option<Variable> {
        let children = &self.tree.node(id).children;
        let counted = match self.kind(id) {
            Kind::TryCatch => &children[..children.len() - 1],
            Kind::Sequence {
                all_skipped: Success,
                ..
            } => return None,
            _ => children,
        };
        let all = counted.iter().all(|it| self.may(*it, Skipped));
        all.then(|| self.counter(id, Counter::Any, 1))
    }

    /// The end of a node, with its counters as they were at first.
    fn ended(&mut self, id: NodeId, outcome: Outcome, counters: &[Counter]) -> Target {
        let mut target = self.result(id, outcome);
        for counter in counters {
            let variable = (id, *counter);
            if self.flow.counters.contains_key(&variable) {
                target = target.after(variable, Change::To(0));
            }
        }
        target
    }

    /// The next of a node's children, or its end once all have ended, of which `outcome` is the last.
    fn next_or_done(&mut self, id: NodeId, at: usize, count: usize, outcome: Outcome) -> Target {
        let any = self.any(id);
        if at + 1 < count {
            let next = self.child(id, at + 1);
            let target = self.enter(next);
            return match any.filter(|_| outcome != Skipped) {
                Some(any) => target.after(any, Change::To(1)),
                None => target,
            };
        }
        match (any, outcome) {
            (Some(_), Skipped) => self.point(id, At::Done),
            _ => {
                let end = self.all_ended(id);
                self.ended(id, end, &[Counter::Any, Counter::Next])
            }
        }
    }

    /// How a node ends of whose children none has decided it.
    fn all_ended(&self, id: NodeId) -> Outcome {
        match self.kind(id) {
            Kind::Fallback | Kind::RoundRobin { .. } => Failure,
            _ => Success,
        }
    }

    fn in_sequence(&mut self, id: NodeId, at: usize, outcome: Outcome, memory: bool) -> Target {
        let count = self.tree.arity(id);
        match outcome {
            Failure if memory => {
                // What went before is executed no more, so that the node cannot be skipped as a whole.
                let any = self.any(id);
                let target = self.result(id, Failure);
                match any {
                    Some(any) => target.after(any, Change::To(usize::from(at > 0))),
                    None => target,
                }
            }
            Failure => {
                self.any(id);
                self.ended(id, Failure, &[Counter::Any])
            }
            Success | Skipped => {
                let target = self.next_or_done(id, at, count, outcome);
                if !memory || at + 1 == count {
                    return target;
                }
                let next = self.counter(id, Counter::Next, count - 1);
                target.after(next, Change::To(at + 1))
            }
        }
    }

    fn in_fallback(&mut self, id: NodeId, at: usize, outcome: Outcome) -> Target {
        match outcome {
            Success => {
                self.any(id);
                self.ended(id, Success, &[Counter::Any])
            }
            Failure | Skipped => {
                let count = self.tree.arity(id);
                self.next_or_done(id, at, count, outcome)
            }
        }
    }

    fn in_try(&mut self, id: NodeId, at: usize, outcome: Outcome) -> Target {
        let last = self.tree.arity(id) - 1;
        match outcome {
            _ if at == last => self.result(id, Failure),
            Failure => {
                let any = self.any(id);
                let rescue = self.child(id, last);
                let target = self.enter(rescue);
                match any {
                    Some(any) => target.after(any, Change::To(0)),
                    None => target,
                }
            }
            Success | Skipped => self.next_or_done(id, at, last, outcome),
        }
    }

    fn in_choice(&mut self, id: NodeId, at: usize, outcome: Outcome) -> Target {
        match (at, outcome) {
            (0, Success) => {
                let child = self.child(id, 1);
                self.enter(child)
            }
            (0, _) if self.tree.arity(id) == 3 => {
                let child = self.child(id, 2);
                self.enter(child)
            }
            _ => self.result(id, outcome),
        }
    }

    fn in_parallel(&mut self, id: NodeId, at: usize, outcome: Outcome) -> Target {
        let count = self.tree.arity(id);
        let successes = self.counter(id, Counter::Successes, count);
        let failures = self.counter(id, Counter::Failures, count);
        let target = self.point(id, At::Counted(at + 1));
        match outcome {
            Success => target.after(successes, Change::Plus(1)),
            Failure => target.after(failures, Change::Plus(1)),
            Skipped => target,
        }
    }

    /// So many children of a `Parallel` have ended: it has succeeded, it has failed, or it goes on.
    pub(super) fn counted(&mut self, id: NodeId, ended: usize) -> Vec<Command> {
        let Kind::Parallel {
            successes: needed,
            failures: most,
            ..
        } = *self.kind(id)
        else {
            return Vec::new();
        };
        let count = self.tree.arity(id);
        let (successes, failures) = ((id, Counter::Successes), (id, Counter::Failures));
        let counters = [Counter::Successes, Counter::Failures];
        let succeeded = self.ended(id, Success, &counters);
        if needed == 0 {
            return vec![sure(succeeded)];
        }
        let enough = sure(succeeded.clone()).if_all([Guard::AtLeast(successes, needed)]);
        // It fails with this many failures, or once too few children are left.
        let limit = most.min(count - needed + 1);
        let failed = sure(self.ended(id, Failure, &counters)).if_all([
            Guard::Below(successes, needed),
            Guard::AtLeast(failures, limit),
        ]);
        let undecided = [
            Guard::Below(successes, needed),
            Guard::Below(failures, limit),
        ];
        let on = match ended < count {
            true => {
                let next = self.child(id, ended);
                self.enter(next)
            }
            // Only where all must succeed may children be skipped: none has failed.
            false => succeeded,
        };
        vec![enough, failed, sure(on).if_all(undecided)]
    }

    fn in_parallel_all(&mut self, id: NodeId, at: usize, outcome: Outcome, most: usize) -> Target {
        let count = self.tree.arity(id);
        let any = self.any(id);
        let failures = self.counter(id, Counter::Failures, count);
        let mut target = match at + 1 < count {
            true => {
                let next = self.child(id, at + 1);
                self.enter(next)
            }
            false => self.point(id, At::Done),
        };
        if let Some(any) = any.filter(|_| outcome != Skipped) {
            target = target.after(any, Change::To(1));
        }
        match outcome {
            // Failures beyond those that decide are not told apart.
            Failure if most > 0 => target.after(failures, Change::Plus(1)),
            _ => target,
        }
    }

    /// `again` is the result with which the child is executed again.
    fn in_loop(
        &mut self,
        id: NodeId,
        outcome: Outcome,
        most: Option<u32>,
        again: Outcome,
    ) -> Target {
        match outcome {
            // The count goes on where it was when the node is executed the next time.
            Skipped => self.result(id, Skipped),
            _ if outcome == again && most == Some(1) => self.result(id, again),
            _ if outcome == again => self.point(id, At::Again),
            _ => {
                if let Some(most) = most.filter(|it| *it > 1) {
                    self.counter(id, Counter::Rounds, most as usize - 1);
                }
                self.ended(id, outcome, &[Counter::Rounds])
            }
        }
    }

    fn in_run_once(&mut self, id: NodeId, outcome: Outcome, then_skip: bool) -> Target {
        let ran = self.counter(id, Counter::Ran, if then_skip { 1 } else { 2 });
        let value = match outcome {
            Skipped => return self.result(id, Skipped),
            Failure if !then_skip => 2,
            Success | Failure => 1,
        };
        self.result(id, outcome).after(ran, Change::To(value))
    }

    fn in_recovery(&mut self, id: NodeId, at: usize, outcome: Outcome, most: u32) -> Target {
        if most > 0 {
            self.counter(id, Counter::Rounds, most as usize);
        }
        match (at, outcome) {
            (0, Failure) if most > 0 => self.point(id, At::Again),
            (0, _) => self.ended(id, outcome, &[Counter::Rounds]),
            (_, Success) => {
                let first = self.child(id, 0);
                self.enter(first)
                    .after((id, Counter::Rounds), Change::Plus(1))
            }
            (_, Failure) => self.ended(id, Failure, &[Counter::Rounds]),
            // A recovery that is skipped is no recovery; the count stays.
            (_, Skipped) => self.result(id, Failure),
        }
    }

    /// The child again, while the count lasts.
    pub(super) fn again(&mut self, id: NodeId) -> Vec<Command> {
        let (most, at_last, child) = match self.kind(id) {
            Kind::Retry(most) => (most.map(|it| it - 1), Failure, 0),
            Kind::Repeat(most) => (most.map(|it| it - 1), Success, 0),
            Kind::Recovery(most) => (Some(*most), Failure, 1),
            _ => (None, Failure, 0),
        };
        let counts = !matches!(self.kind(id), Kind::Recovery(_));
        let child = self.child(id, child);
        let again = self.enter(child);
        let Some(most) = most else {
            return vec![sure(again)];
        };
        let rounds = self.counter(id, Counter::Rounds, most as usize);
        let again = match counts {
            true => again.after(rounds, Change::Plus(1)),
            false => again,
        };
        let ended = self.ended(id, at_last, &[Counter::Rounds]);
        vec![
            sure(again).if_all([Guard::Below(rounds, most as usize)]),
            sure(ended).if_all([Guard::Is(rounds, most as usize)]),
        ]
    }

    fn in_round_robin(&mut self, id: NodeId, at: usize, outcome: Outcome, wraps: bool) -> Target {
        let count = self.tree.arity(id);
        let any = self.any(id);
        let next = self.counter(id, Counter::Next, count - 1);
        let is_last = at + 1 == count;
        let behind = Change::To((at + 1) % count);
        match outcome {
            // Without wrapping, the end of the row is reached before the success is looked at.
            Success if is_last && !wraps => self.ended(id, Failure, &[Counter::Next, Counter::Any]),
            Success => {
                let target = self.ended(id, Success, &[Counter::Tried]);
                let target = target.after(next, behind);
                // Without wrapping, the children before are not tried the next time, so that not all can be skipped.
                match any {
                    Some(any) => target.after(any, Change::To(usize::from(!wraps))),
                    None => target,
                }
            }
            Failure | Skipped if is_last && !wraps => match (any, outcome) {
                (Some(_), Skipped) => self.point(id, At::Done),
                _ => self.ended(id, Failure, &[Counter::Next, Counter::Any]),
            },
            Failure | Skipped => {
                let tried = wraps.then(|| self.counter(id, Counter::Tried, count));
                let mut target = self.point(id, At::Begin(0)).after(next, behind);
                if let Some(tried) = tried {
                    target = target.after(tried, Change::Plus(1));
                }
                match any.filter(|_| outcome != Skipped) {
                    Some(any) => target.after(any, Change::To(1)),
                    None => target,
                }
            }
        }
    }

    /// All children were tried in a round, none with success.
    pub(super) fn ended_round(&mut self, id: NodeId) -> Vec<Command> {
        let counters = [Counter::Next, Counter::Tried, Counter::Any];
        self.by_any(id, Failure, &counters)
    }

    /// All children have ended.
    pub(super) fn done(&mut self, id: NodeId) -> Vec<Command> {
        let counters = [Counter::Any, Counter::Next, Counter::Failures];
        let Kind::ParallelAll { failures: most } = *self.kind(id) else {
            let end = self.all_ended(id);
            return self.by_any(id, end, &counters);
        };
        let mut found = Vec::new();
        for (outcome, guard) in [
            (Failure, Guard::AtLeast((id, Counter::Failures), most)),
            (Success, Guard::Below((id, Counter::Failures), most)),
        ] {
            if most == 0 && outcome == Success {
                continue;
            }
            let is_skipped = |it: &Command| it.guards.contains(&Guard::Is((id, Counter::Any), 0));
            for command in self.by_any(id, outcome, &counters) {
                match is_skipped(&command) {
                    true if outcome == Success || most == 0 => found.push(command),
                    true => {}
                    false => found.push(command.if_all([guard])),
                }
            }
        }
        found
    }

    /// The end of a node; skipped if it may be, and no child was executed.
    fn by_any(&mut self, id: NodeId, outcome: Outcome, counters: &[Counter]) -> Vec<Command> {
        let ended = sure(self.ended(id, outcome, counters));
        let Some(any) = self.any(id) else {
            return vec![ended];
        };
        let skipped = sure(self.ended(id, Skipped, counters));
        vec![
            skipped.if_all([Guard::Is(any, 0)]),
            ended.if_all([Guard::Is(any, 1)]),
        ]
    }
}

fn inverted(outcome: Outcome) -> Outcome {
    match outcome {
        Success => Failure,
        Failure => Success,
        Skipped => Skipped,
    }
}
