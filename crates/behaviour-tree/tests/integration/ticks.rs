//! An interpreter of behaviour trees that ticks them, written from BehaviorTree.CPP's and Nav2's sources and sharing nothing
//! with the crate: nodes have statuses, are reset and halted, and leaves may be under way for some ticks.

use std::collections::BTreeMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    Idle,
    Running,
    Success,
    Failure,
    Skipped,
}

use Status::{Failure, Idle, Running, Skipped, Success};

/// What a node is, with the attributes that its element has.
#[derive(Clone, Debug)]
pub enum Type {
    Leaf,
    Condition,
    Always(Status),
    Sequence,
    ReactiveSequence,
    Memory,
    Pipeline,
    Persistent,
    Fallback,
    ReactiveFallback,
    Parallel(i64, i64),
    ParallelAll(i64),
    IfThenElse,
    WhileDoElse,
    Switch,
    TryCatch,
    Inverter,
    Force(Status),
    Retry(i64),
    Repeat(i64),
    KeepRunning,
    RunOnce(bool),
    Gate(Status),
    Timeout,
    Delay,
    Recovery(i64),
    RoundRobin(bool),
}

#[derive(Clone, Debug)]
pub struct Ticked {
    pub name: String,
    pub kind: Type,
    /// `_failureIf`, `_successIf`, `_skipIf`, `_while`, in this order; a literal or a draw.
    pub preconditions: Vec<(&'static str, Option<bool>)>,
    pub children: Vec<Ticked>,
    pub status: Status,
    index: usize,
    skipped: usize,
    count: i64,
    failed: i64,
    /// Which children have ended, or (of `RunOnce`) what the child gave.
    ended: Vec<usize>,
    given: Option<Status>,
    left: usize,
}

/// Where draws come from: a script first, then a default; what was drawn is remembered.
pub struct World<'a> {
    pub chances: &'a BTreeMap<String, f64>,
    pub drawn: Vec<(bool, f64)>,
    pub choose: &'a mut dyn FnMut(usize, f64) -> bool,
    /// For how many ticks a leaf is under way.
    pub delay: &'a mut dyn FnMut() -> usize,
    pub most_draws: usize,
    pub kept: Option<BTreeMap<String, bool>>,
    pub ran: Vec<(String, bool)>,
    pub ticks: usize,
}

impl World<'_> {
    fn draw(&mut self, name: &str) -> bool {
        let chance = *self
            .chances
            .get(name)
            .unwrap_or_else(|| panic!("no chance of {name}"));
        let value = (self.choose)(self.drawn.len(), chance);
        self.drawn
            .push((value, if value { chance } else { 1.0 - chance }));
        value
    }

    pub fn is_over(&self) -> bool {
        self.drawn.len() >= self.most_draws || self.ticks > 20 * self.most_draws
    }
}

/// Ticks a tree until it has ended; `None` if that takes too many draws.
pub fn run(tree: &Ticked, world: &mut World<'_>) -> Option<Status> {
    let mut tree = tree.clone();
    loop {
        let status = tree.execute(world);
        if world.is_over() {
            return None;
        }
        if status != Running {
            return Some(status);
        }
    }
}

impl Ticked {
    pub fn new(name: String, kind: Type, children: Vec<Ticked>) -> Self {
        Self {
            name,
            kind,
            preconditions: Vec::new(),
            children,
            status: Idle,
            index: 0,
            skipped: 0,
            count: 0,
            failed: 0,
            ended: Vec::new(),
            given: None,
            left: 0,
        }
    }

    fn execute(&mut self, world: &mut World<'_>) -> Status {
        world.ticks += 1;
        let status = self.precondition(world).unwrap_or_else(|| self.tick(world));
        if status != Skipped {
            self.status = status;
        }
        status
    }

    fn precondition(&self, world: &mut World<'_>) -> Option<Status> {
        if self.status == Running {
            return None;
        }
        for (which, literal) in &self.preconditions {
            let value = literal.unwrap_or_else(|| world.draw(&format!("p_{}_{which}", self.name)));
            let status = match (*which, value) {
                ("failureIf", true) => Failure,
                ("successIf", true) => Success,
                ("skipIf", true) | ("while", false) => Skipped,
                _ => continue,
            };
            return Some(status);
        }
        None
    }

    fn reset(&mut self) {
        for child in &mut self.children {
            child.halt_if_running();
        }
    }

    fn halt_if_running(&mut self) {
        if self.status == Running {
            self.halt();
        }
        self.status = Idle;
    }

    fn halt(&mut self) {
        match self.kind {
            Type::Memory => {}
            Type::RoundRobin(_) | Type::Recovery(_) | Type::Retry(_) | Type::Repeat(_) => {
                self.index = 0;
                self.count = 0;
                self.failed = 0;
            }
            Type::RunOnce(_) => {}
            _ => {
                self.index = 0;
                self.ended.clear();
                self.count = 0;
                self.failed = 0;
            }
        }
        self.reset();
    }

    fn tick(&mut self, world: &mut World<'_>) -> Status {
        if world.is_over() {
            return Running;
        }
        let was = self.status;
        match self.kind {
            Type::Leaf | Type::Condition => self.leaf(world),
            Type::Always(status) => status,
            Type::Sequence | Type::Memory | Type::Persistent => self.sequence(was, world),
            Type::Fallback => self.fallback(was, world),
            Type::ReactiveSequence | Type::ReactiveFallback => self.reactive(world),
            Type::Pipeline => self.pipeline(world),
            Type::Parallel(successes, failures) => self.parallel(successes, failures, world),
            Type::ParallelAll(failures) => self.parallel_all(failures, world),
            Type::IfThenElse => self.if_then_else(world),
            Type::WhileDoElse => self.while_do_else(world),
            Type::Switch => self.switch(world),
            Type::TryCatch => self.try_catch(was, world),
            Type::Retry(most) => self.looped(most, Failure, world),
            Type::Repeat(most) => self.looped(most, Success, world),
            Type::Recovery(most) => self.recovery(most, world),
            Type::RoundRobin(wraps) => self.round_robin(wraps, world),
            Type::RunOnce(then_skip) => self.run_once(then_skip, world),
            _ => self.decorated(was, world),
        }
    }

    fn leaf(&mut self, world: &mut World<'_>) -> Status {
        if self.status != Running {
            self.left = (world.delay)();
        }
        if self.left > 0 {
            self.left -= 1;
            return Running;
        }
        let known = world
            .kept
            .as_ref()
            .and_then(|it| it.get(&self.name).copied());
        let known = known.filter(|_| matches!(self.kind, Type::Condition));
        let value = known.unwrap_or_else(|| world.draw(&format!("p_{}", self.name)));
        if let Some(kept) = &mut world.kept {
            kept.insert(self.name.clone(), value);
        }
        world.ran.push((self.name.clone(), value));
        if value { Success } else { Failure }
    }

    fn sequence(&mut self, was: Status, world: &mut World<'_>) -> Status {
        if was == Idle {
            self.skipped = 0;
        }
        self.status = Running;
        while self.index < self.children.len() {
            match self.children[self.index].execute(world) {
                Running => return Running,
                Failure => {
                    self.reset();
                    if !matches!(self.kind, Type::Memory) {
                        self.index = 0;
                    }
                    return Failure;
                }
                Skipped => {
                    self.index += 1;
                    self.skipped += 1;
                }
                _ => self.index += 1,
            }
        }
        let all = self.skipped == self.children.len() && !matches!(self.kind, Type::Persistent);
        self.reset();
        self.index = 0;
        self.skipped = 0;
        if all { Skipped } else { Success }
    }

    fn fallback(&mut self, was: Status, world: &mut World<'_>) -> Status {
        if was == Idle {
            self.skipped = 0;
        }
        self.status = Running;
        while self.index < self.children.len() {
            match self.children[self.index].execute(world) {
                Running => return Running,
                Success => {
                    self.reset();
                    self.index = 0;
                    return Success;
                }
                Skipped => {
                    self.index += 1;
                    self.skipped += 1;
                }
                _ => self.index += 1,
            }
        }
        let all = self.skipped == self.children.len();
        self.reset();
        self.index = 0;
        self.skipped = 0;
        if all { Skipped } else { Failure }
    }

    fn reactive(&mut self, world: &mut World<'_>) -> Status {
        let (ends, goes_on) = match self.kind {
            Type::ReactiveSequence => (Failure, Success),
            _ => (Success, Failure),
        };
        self.status = Running;
        let mut all_skipped = true;
        for at in 0..self.children.len() {
            let status = self.children[at].execute(world);
            all_skipped &= status == Skipped;
            if status == Running {
                for other in (0..self.children.len()).filter(|it| *it != at) {
                    self.children[other].halt_if_running();
                }
                return Running;
            }
            if status == ends {
                self.reset();
                return ends;
            }
        }
        self.reset();
        if all_skipped { Skipped } else { goes_on }
    }

    fn pipeline(&mut self, world: &mut World<'_>) -> Status {
        let mut skipped = 0;
        for at in 0..self.children.len() {
            match self.children[at].execute(world) {
                Failure => {
                    self.reset();
                    self.index = 0;
                    return Failure;
                }
                Skipped => skipped += 1,
                Running if at >= self.index => {
                    self.index = at;
                    return Running;
                }
                _ => {}
            }
        }
        self.reset();
        self.index = 0;
        if skipped == self.children.len() {
            Skipped
        } else {
            Success
        }
    }

    fn of_all(&self, count: i64) -> i64 {
        let all = self.children.len() as i64;
        if count < 0 {
            (all + count + 1).max(0)
        } else {
            count
        }
    }

    fn parallel(&mut self, successes: i64, failures: i64, world: &mut World<'_>) -> Status {
        self.status = Running;
        let all = self.children.len() as i64;
        let (needed, most) = (self.of_all(successes), self.of_all(failures));
        let mut skipped = 0;
        for at in 0..self.children.len() {
            if !self.ended.contains(&at) {
                match self.children[at].execute(world) {
                    Skipped => skipped += 1,
                    Success => {
                        self.ended.push(at);
                        self.count += 1;
                    }
                    Failure => {
                        self.ended.push(at);
                        self.failed += 1;
                    }
                    _ => {}
                }
            }
            let is_success =
                self.count >= needed || (successes < 0 && self.count + skipped >= needed);
            let is_failure = all - self.failed < needed || self.failed == most;
            if is_success || is_failure {
                self.ended.clear();
                self.count = 0;
                self.failed = 0;
                self.reset();
                return if is_success { Success } else { Failure };
            }
        }
        if skipped == all { Skipped } else { Running }
    }

    fn parallel_all(&mut self, failures: i64, world: &mut World<'_>) -> Status {
        self.status = Running;
        let most = self.of_all(failures);
        let mut skipped = 0;
        for at in 0..self.children.len() {
            if self.ended.contains(&at) {
                continue;
            }
            match self.children[at].execute(world) {
                Skipped => skipped += 1,
                Success => self.ended.push(at),
                Failure => {
                    self.ended.push(at);
                    self.failed += 1;
                }
                _ => {}
            }
        }
        if skipped == self.children.len() {
            return Skipped;
        }
        if skipped + self.ended.len() < self.children.len() {
            return Running;
        }
        let failed = self.failed >= most;
        self.ended.clear();
        self.failed = 0;
        self.reset();
        if failed { Failure } else { Success }
    }

    fn if_then_else(&mut self, world: &mut World<'_>) -> Status {
        self.status = Running;
        if self.index == 0 {
            match self.children[0].execute(world) {
                Success => self.index = 1,
                Failure if self.children.len() == 3 => self.index = 2,
                other => return other,
            }
        }
        let status = self.children[self.index].execute(world);
        if status != Running {
            self.reset();
            self.index = 0;
        }
        status
    }

    fn while_do_else(&mut self, world: &mut World<'_>) -> Status {
        self.status = Running;
        let status = match self.children[0].execute(world) {
            Running => return Running,
            Success => self.children[1].execute(world),
            _ if self.children.len() == 3 => self.children[2].execute(world),
            _ => Failure,
        };
        if status != Running {
            self.reset();
        }
        status
    }

    fn switch(&mut self, world: &mut World<'_>) -> Status {
        let cases = self.children.len() - 1;
        if self.given.is_none() {
            let taken = |case: &usize| world.draw(&format!("p_{}_case_{}", self.name, case + 1));
            self.index = (0..cases).find(taken).unwrap_or(cases);
            self.given = Some(Running);
        }
        let status = self.children[self.index].execute(world);
        if status != Running {
            self.given = None;
            self.reset();
        }
        status
    }

    fn try_catch(&mut self, was: Status, world: &mut World<'_>) -> Status {
        if was == Idle {
            self.skipped = 0;
            self.given = None;
        }
        self.status = Running;
        let last = self.children.len() - 1;
        while self.given.is_none() && self.index < last {
            match self.children[self.index].execute(world) {
                Running => return Running,
                Failure => {
                    self.reset();
                    self.index = 0;
                    self.given = Some(Failure);
                }
                Skipped => {
                    self.index += 1;
                    self.skipped += 1;
                }
                _ => self.index += 1,
            }
        }
        if self.given.is_some() {
            if self.children[last].execute(world) == Running {
                return Running;
            }
            self.reset();
            self.index = 0;
            self.given = None;
            return Failure;
        }
        let all = self.skipped == last;
        self.reset();
        self.index = 0;
        self.skipped = 0;
        if all { Skipped } else { Success }
    }

    fn looped(&mut self, most: i64, again: Status, world: &mut World<'_>) -> Status {
        self.status = Running;
        while (self.count < most || most == -1) && !world.is_over() {
            let status = self.children[0].execute(world);
            match status {
                Running => return Running,
                Skipped => {
                    self.reset();
                    return Skipped;
                }
                _ if status == again => {
                    self.count += 1;
                    self.reset();
                }
                _ => {
                    self.count = 0;
                    self.reset();
                    return status;
                }
            }
        }
        if world.is_over() {
            return Running;
        }
        self.count = 0;
        again
    }

    fn recovery(&mut self, most: i64, world: &mut World<'_>) -> Status {
        self.status = Running;
        while !world.is_over() {
            let status = self.children[self.index].execute(world);
            match (self.index, status) {
                (_, Running) => return Running,
                (0, Failure) if self.count < most => {
                    self.children[0].halt_if_running();
                    self.index = 1;
                }
                (0, _) => {
                    self.halt();
                    return status;
                }
                (_, Success) => {
                    self.children[1].halt_if_running();
                    self.count += 1;
                    self.index = 0;
                }
                (_, Skipped) => {
                    self.index = 0;
                    self.children[1].halt_if_running();
                    return Failure;
                }
                _ => {
                    self.halt();
                    return Failure;
                }
            }
        }
        Running
    }

    fn round_robin(&mut self, wraps: bool, world: &mut World<'_>) -> Status {
        self.status = Running;
        let all = self.children.len();
        let mut skipped = 0;
        while (self.failed as usize) + skipped < all {
            let status = self.children[self.index].execute(world);
            if status == Running {
                return Running;
            }
            self.index += 1;
            if self.index == all {
                if !wraps {
                    skipped += usize::from(status == Skipped);
                    break;
                }
                self.index = 0;
            }
            match status {
                Success => {
                    self.failed = 0;
                    self.reset();
                    return Success;
                }
                Failure => self.failed += 1,
                _ => skipped += 1,
            }
        }
        self.halt();
        if skipped == all { Skipped } else { Failure }
    }

    fn run_once(&mut self, then_skip: bool, world: &mut World<'_>) -> Status {
        if let Some(given) = self.given {
            return if then_skip { Skipped } else { given };
        }
        self.status = Running;
        let status = self.children[0].execute(world);
        if [Success, Failure].contains(&status) {
            self.given = Some(status);
            self.reset();
        }
        status
    }

    fn decorated(&mut self, was: Status, world: &mut World<'_>) -> Status {
        let draws = match self.kind {
            Type::Gate(otherwise) => Some(("if", otherwise)),
            Type::Timeout => Some(("in_time", Failure)),
            _ => None,
        };
        if let Some((what, otherwise)) = draws.filter(|_| was != Running)
            && !world.draw(&format!("p_{}_{what}", self.name))
        {
            return otherwise;
        }
        self.status = Running;
        let status = self.children[0].execute(world);
        if status == Running {
            return Running;
        }
        self.reset();
        match (&self.kind, status) {
            (Type::KeepRunning, Failure) => Failure,
            (Type::KeepRunning, _) => Running,
            (_, Skipped) => Skipped,
            (Type::Inverter, Success) => Failure,
            (Type::Inverter, _) => Success,
            (Type::Force(forced), _) => *forced,
            _ => status,
        }
    }
}
