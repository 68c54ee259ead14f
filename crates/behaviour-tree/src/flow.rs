//! From a tree to a program counter with counters: how one run of the root goes on at each point.
//!
//! # Definition
//! A *point* is where a run is: a leaf that is executed, a leaf that has ended in success or failure, a draw, or a node that
//! decides by its counter how to go on. From each point commands lead to others, each with a guard over the counters and,
//! where something is drawn, with two branches. A run begins where the root is entered and ends in success, failure or
//! skipped. Between points nothing is decided: that a child's success lets a `Sequence` go on with its next child is worked
//! out once, here.
//!
//! # Source
//! The results of each node: BehaviorTree.CPP 4 (`src/controls`, `src/decorators`, `TreeNode::checkPreConditions`), and Nav2's
//! plugins. Programs as control flow graphs with explicit counters are how PRISM models are written by hand.
//!
//! # Deviation
//! `RUNNING` is abstracted: what is executed runs to its end before anything else is. So a reactive node asks its first
//! children once per execution, children of `Parallel` run one after another, and no node is halted. Reading a tree notes it
//! where it matters.
//!
//! # Cost
//! At most three points for each leaf and deadline and one or two for each other node; the text is linear in the tree. States are points
//! times the values of counters, of which unreachable combinations are not explored: counters are 0 wherever their node is
//! not executed, but for those that BehaviorTree.CPP keeps (`SequenceWithMemory`, `RunOnce`, `RoundRobin`, and counts of a
//! child that was skipped).
//!
//! # Assumes
//! Draws are independent of each other and of the past; a leaf ends in success or failure.
//!
//! # Guarantee
//! The chain has the distribution of results that the tree has under these assumptions, exactly (compared with an
//! interpreter that ticks the tree, `tests/integration/against_ticks.rs`).

mod results;

use std::collections::{BTreeMap, VecDeque};

use crate::prism::Conditions;
use crate::tree::{BehaviourTree, Draw, Kind, Leaf, NodeId, Outcome};

/// What a point is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum At {
    /// The precondition with this place among the node's.
    Precondition(usize),
    /// The node decides how to begin: by its memory, a gate, or the case of a switch.
    Begin(usize),
    /// A leaf is executed.
    Run,
    /// It has succeeded; the time of a deadline suffices.
    Succeeded,
    /// It has failed; the time of a deadline does not suffice.
    Failed,
    /// So many children have ended.
    Counted(usize),
    /// The child is to be executed again, or not.
    Again,
    /// All children have ended.
    Done,
    /// The run is over.
    Over(Outcome),
}

/// A counter of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Counter {
    /// Executions of the child that are to be followed by others.
    Rounds,
    /// The child with which the node goes on.
    Next,
    /// Children that ended without success, in a round.
    Tried,
    /// Whether a child was executed, so that the node is not skipped.
    Any,
    /// Children that succeeded.
    Successes,
    /// Children that failed.
    Failures,
    /// Whether it was executed before; 2 if it failed then.
    Ran,
    /// The value that a condition keeps: 1 success, 2 failure.
    Kept,
}

pub(crate) type Key = (NodeId, At);
pub(crate) type Variable = (NodeId, Counter);

/// What becomes of a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    To(usize),
    Plus(usize),
}

/// Where a run goes on.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub key: Key,
    pub changes: BTreeMap<Variable, Change>,
}

impl Target {
    fn new(key: Key) -> Self {
        Self {
            key,
            changes: BTreeMap::new(),
        }
    }

    /// The same, with a change that comes before those that it has.
    fn after(mut self, variable: Variable, change: Change) -> Self {
        let later = self.changes.get(&variable).copied();
        let both = match (change, later) {
            (_, Some(Change::To(value))) => Change::To(value),
            (Change::To(value), Some(Change::Plus(more))) => Change::To(value + more),
            (Change::Plus(value), Some(Change::Plus(more))) => Change::Plus(value + more),
            (change, None) => change,
        };
        self.changes.insert(variable, both);
        self
    }
}

/// A condition on a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Guard {
    Is(Variable, usize),
    Below(Variable, usize),
    AtLeast(Variable, usize),
}

/// A command of a point: what it asks of counters, and where it leads. With a draw, the second target is the one where the
/// draw fails.
#[derive(Clone, Debug)]
pub(crate) struct Command {
    pub guards: Vec<Guard>,
    pub draw: Option<Draw>,
    pub to: Vec<Target>,
}

/// The points of a tree with their commands.
#[derive(Debug, Default)]
pub(crate) struct Flow {
    pub points: BTreeMap<Key, Vec<Command>>,
    /// The counters with their greatest values.
    pub counters: BTreeMap<Variable, usize>,
    pub start: Option<Key>,
}

/// What the tree's runs are.
pub(crate) fn flow(tree: &BehaviourTree, conditions: Conditions, outcomes: &[[bool; 3]]) -> Flow {
    let mut made = Making {
        tree,
        conditions,
        outcomes,
        flow: Flow::default(),
        open: VecDeque::new(),
    };
    let start = made.enter(tree.root());
    made.flow.start = Some(start.key);
    while let Some(key) = made.open.pop_front() {
        let commands = made.commands(key);
        made.flow.points.insert(key, commands);
    }
    made.flow
}

struct Making<'a> {
    tree: &'a BehaviourTree,
    conditions: Conditions,
    outcomes: &'a [[bool; 3]],
    flow: Flow,
    /// Points whose commands are still to be made.
    open: VecDeque<Key>,
}

impl Making<'_> {
    /// A point, of which commands will be made.
    fn point(&mut self, id: NodeId, at: At) -> Target {
        let key = (id, at);
        self.flow.points.entry(key).or_insert_with(|| {
            self.open.push_back(key);
            Vec::new()
        });
        Target::new(key)
    }

    /// A counter, which goes up to `most`.
    fn counter(&mut self, id: NodeId, counter: Counter, most: usize) -> Variable {
        let known = self.flow.counters.entry((id, counter)).or_default();
        *known = (*known).max(most);
        (id, counter)
    }

    fn kind(&self, id: NodeId) -> &Kind {
        &self.tree.node(id).kind
    }

    fn child(&self, id: NodeId, at: usize) -> NodeId {
        self.tree.node(id).children[at]
    }

    fn may(&self, id: NodeId, outcome: Outcome) -> bool {
        self.outcomes[id.0][outcome as usize]
    }

    /// Where a run goes on when a node is executed.
    fn enter(&mut self, id: NodeId) -> Target {
        match self.tree.node(id).preconditions.is_empty() {
            true => self.enter_body(id),
            false => self.point(id, At::Precondition(0)),
        }
    }

    fn enter_body(&mut self, id: NodeId) -> Target {
        match self.kind(id) {
            Kind::Leaf(_) | Kind::Always(_) => self.point(id, At::Run),
            Kind::Sequence { memory: true, .. }
            | Kind::RunOnce { .. }
            | Kind::RoundRobin { .. } => self.point(id, At::Begin(0)),
            Kind::Gate(_) | Kind::Deadline | Kind::Switch => self.point(id, At::Begin(0)),
            Kind::Sequence { .. }
            | Kind::Fallback
            | Kind::Parallel { .. }
            | Kind::ParallelAll { .. }
            | Kind::Choice
            | Kind::TryCatch
            | Kind::Inverter
            | Kind::Force(_)
            | Kind::Retry(_)
            | Kind::Repeat(_)
            | Kind::KeepRunningUntilFailure
            | Kind::Pass
            | Kind::Recovery(_) => {
                let first = self.child(id, 0);
                self.enter(first)
            }
        }
    }

    fn commands(&mut self, (id, at): Key) -> Vec<Command> {
        match at {
            At::Over(_) => Vec::new(),
            At::Precondition(place) => self.precondition(id, place),
            At::Begin(case) => self.begin(id, case),
            At::Run => self.run(id),
            At::Succeeded if *self.kind(id) == Kind::Deadline => {
                let child = self.child(id, 0);
                vec![sure(self.enter(child))]
            }
            At::Succeeded => vec![sure(self.result(id, Outcome::Success))],
            At::Failed => vec![sure(self.result(id, Outcome::Failure))],
            At::Counted(ended) => self.counted(id, ended),
            At::Again => self.again(id),
            At::Done => self.done(id),
        }
    }

    fn precondition(&mut self, id: NodeId, place: usize) -> Vec<Command> {
        let (which, script) = &self.tree.node(id).preconditions[place];
        let (which, literal) = (*which, script.literal);
        let mut on = |value: bool| match which.ends(value) {
            Some(outcome) => self.result(id, outcome),
            None if place + 1 < self.tree.node(id).preconditions.len() => {
                self.point(id, At::Precondition(place + 1))
            }
            None => self.enter_body(id),
        };
        match literal {
            Some(value) => vec![sure(on(value))],
            None => vec![drawn(Draw::Precondition(which), on(true), on(false))],
        }
    }

    fn run(&mut self, id: NodeId) -> Vec<Command> {
        if let Kind::Always(outcome) = self.kind(id) {
            let outcome = *outcome;
            return vec![sure(self.result(id, outcome))];
        }
        let succeeded = self.point(id, At::Succeeded);
        let failed = self.point(id, At::Failed);
        let is_condition = matches!(self.kind(id), Kind::Leaf(Leaf::Condition));
        if !(is_condition && self.conditions == Conditions::Kept) {
            return vec![drawn(Draw::Leaf, succeeded, failed)];
        }
        let kept = self.counter(id, Counter::Kept, 2);
        let fresh = drawn(
            Draw::Leaf,
            succeeded.clone().after(kept, Change::To(1)),
            failed.clone().after(kept, Change::To(2)),
        );
        vec![
            fresh.if_all([Guard::Is(kept, 0)]),
            sure(succeeded).if_all([Guard::Is(kept, 1)]),
            sure(failed).if_all([Guard::Is(kept, 2)]),
        ]
    }

    fn begin(&mut self, id: NodeId, case: usize) -> Vec<Command> {
        match self.kind(id) {
            Kind::Gate(otherwise) => {
                let otherwise = *otherwise;
                self.gate(id, Draw::Gate, otherwise)
            }
            Kind::Deadline => {
                let (in_time, late) = (self.point(id, At::Succeeded), self.point(id, At::Failed));
                vec![drawn(Draw::Deadline, in_time, late)]
            }
            Kind::Switch => self.case(id, case),
            Kind::RunOnce { then_skip } => {
                let then_skip = *then_skip;
                self.run_once(id, then_skip)
            }
            Kind::RoundRobin { wraps } => {
                let wraps = *wraps;
                self.round_robin(id, wraps)
            }
            _ => self.resume(id),
        }
    }

    fn gate(&mut self, id: NodeId, draw: Draw, otherwise: Outcome) -> Vec<Command> {
        let child = self.child(id, 0);
        vec![drawn(draw, self.enter(child), self.result(id, otherwise))]
    }

    fn case(&mut self, id: NodeId, case: usize) -> Vec<Command> {
        let child = self.child(id, case);
        let taken = self.enter(child);
        let next = match case + 2 < self.tree.arity(id) {
            true => self.point(id, At::Begin(case + 1)),
            false => {
                let last = self.child(id, case + 1);
                self.enter(last)
            }
        };
        vec![drawn(Draw::Case(case), taken, next)]
    }

    fn run_once(&mut self, id: NodeId, then_skip: bool) -> Vec<Command> {
        let ran = self.counter(id, Counter::Ran, if then_skip { 1 } else { 2 });
        let child = self.child(id, 0);
        let mut found = vec![sure(self.enter(child)).if_all([Guard::Is(ran, 0)])];
        let again = match then_skip {
            true => vec![(1, Outcome::Skipped)],
            false => vec![(1, Outcome::Success), (2, Outcome::Failure)],
        };
        for (value, outcome) in again {
            found.push(sure(self.result(id, outcome)).if_all([Guard::Is(ran, value)]));
        }
        found
    }

    /// A sequence with memory goes on with the child that failed.
    fn resume(&mut self, id: NodeId) -> Vec<Command> {
        let most = self.tree.arity(id) - 1;
        let next = self.counter(id, Counter::Next, most);
        let mut found = Vec::with_capacity(most + 1);
        for at in 0..=most {
            let child = self.child(id, at);
            found.push(sure(self.enter(child)).if_all([Guard::Is(next, at)]));
        }
        found
    }

    /// Goes on with the next child unless all were tried in this round.
    fn round_robin(&mut self, id: NodeId, wraps: bool) -> Vec<Command> {
        let count = self.tree.arity(id);
        let next = self.counter(id, Counter::Next, count - 1);
        if !wraps {
            return self.resume(id);
        }
        let tried = self.counter(id, Counter::Tried, count);
        let mut found = Vec::with_capacity(count + 1);
        for at in 0..count {
            let child = self.child(id, at);
            let guards = [Guard::Below(tried, count), Guard::Is(next, at)];
            found.push(sure(self.enter(child)).if_all(guards));
        }
        for command in self.ended_round(id) {
            found.push(command.if_all([Guard::Is(tried, count)]));
        }
        found
    }
}

impl Command {
    /// The same, where all of these hold, too.
    fn if_all(mut self, guards: impl IntoIterator<Item = Guard>) -> Self {
        self.guards.splice(0..0, guards);
        self
    }
}

fn sure(to: Target) -> Command {
    Command {
        guards: Vec::new(),
        draw: None,
        to: vec![to],
    }
}

fn drawn(draw: Draw, succeeded: Target, failed: Target) -> Command {
    Command {
        guards: Vec::new(),
        draw: Some(draw),
        to: vec![succeeded, failed],
    }
}
