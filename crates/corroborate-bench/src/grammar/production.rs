//! The grammar's productions: each adds a part of a system between two locations of a machine.
//!
//! * [`Builder::act`]: an action that may have to be tried again, and may fail;
//! * [`Builder::retry`]: at most so many attempts, each of which may miss;
//! * [`Builder::fork`]: something that happens in a share of the runs, and costs a detour;
//! * [`Builder::travel`]: a way of several cells, on each of which one may slip, or lose something;
//! * [`Builder::exchange`]: a message and its answer, each of which may be lost, sent again so many times;
//! * [`Builder::serve`]: a queue that is worked off, from which somebody may walk away;
//! * [`Builder::assemble`]: parts in an order that nothing prescribes, each of which may jam;
//! * [`Builder::repairable`]: work that breaks, is repaired, or is given up, by rates;
//! * [`Builder::lattice`]: a way on a grid with a drift to the side, which ends at a wall.

use super::machine::{
    Branch, Command, Constant, Counter, Factor, Guard, Machine, Mode, Time, Update,
};
use crate::random::Random;

/// Builds a machine part by part.
#[derive(Debug)]
pub struct Builder<'a> {
    /// What has been built.
    pub machine: Machine,
    /// From which numbers are drawn.
    pub random: &'a mut Random,
    /// How names of constants begin.
    prefix: &'static str,
}

fn branch(weight: &[Factor], to: usize, updates: &[Update]) -> Branch {
    Branch {
        weight: weight.to_vec(),
        to,
        updates: updates.to_vec(),
    }
}

/// Numbers have few digits, as in a model that somebody wrote.
fn short(value: f64) -> f64 {
    (value * 1e3).round().max(1.0) / 1e3
}

impl<'a> Builder<'a> {
    /// An empty machine with its start.
    pub fn new(time: Time, start: &str, step_secs: f64, random: &'a mut Random) -> Self {
        let prefix = random.one_of(&["p_", "prob_", "c", "k_", "pr"]);
        Self {
            machine: Machine {
                time,
                step_secs,
                constants: Vec::new(),
                locations: vec![start.to_owned()],
                counters: Vec::new(),
                commands: Vec::new(),
                modes: Vec::new(),
                done: 0,
                near: None,
                alarm: None,
            },
            random,
            prefix,
        }
    }

    /// A location.
    pub fn location(&mut self, name: &str) -> usize {
        self.machine.locations.push(name.to_owned());
        self.machine.locations.len() - 1
    }

    fn counter(&mut self, name: String, first: i32, most: i32) -> usize {
        self.machine.counters.push(Counter { name, first, most });
        self.machine.counters.len() - 1
    }

    fn constant(&mut self, name: &str, value: f64) -> usize {
        let name = format!("{}{name}", self.prefix);
        let value = short(value);
        self.machine.constants.push(Constant { name, value });
        self.machine.constants.len() - 1
    }

    fn command(&mut self, at: usize, guards: &[Guard], branches: Vec<Branch>) {
        self.machine.commands.push(Command {
            at,
            guards: guards.to_vec(),
            branches,
        });
    }

    fn mode(&mut self, name: &str, at: usize, constant: usize, repeats: bool) -> usize {
        let failed = self.location(&format!("lost_to_{name}"));
        self.machine.modes.push(Mode {
            name: name.to_owned(),
            at,
            failed,
            constant,
            repeats,
        });
        failed
    }

    /// The rate at which a part goes on, in continuous time.
    fn pace(&mut self, name: &str) -> Vec<Factor> {
        match self.machine.time {
            Time::Rates => {
                let pace = self.random.between(0.3, 2.0);
                vec![Factor::Of(self.constant(&format!("pace_{name}"), pace))]
            }
            _ => Vec::new(),
        }
    }

    /// An action that fails with some probability once it is taken; before that it may have to wait.
    pub fn act(&mut self, from: usize, to: usize, name: &str, low: f64, high: f64) {
        let value = self.random.log_between(low, high);
        let fails = self.constant(name, value);
        let mut pace = self.pace(name);
        let mut at = from;
        if self.machine.time != Time::Rates && self.random.chance(0.5) {
            let value = self.random.between(0.1, 0.5);
            let waits = self.constant(&format!("wait_{name}"), value);
            at = self.location(&format!("try_{name}"));
            let stay = branch(&[Factor::Of(waits)], from, &[]);
            self.command(
                from,
                &[],
                vec![stay, branch(&[Factor::Not(waits)], at, &[])],
            );
        }
        let failed = self.mode(name, at, fails, false);
        let mut lost = pace.clone();
        pace.push(Factor::Not(fails));
        lost.push(Factor::Of(fails));
        self.command(
            at,
            &[],
            vec![branch(&pace, to, &[]), branch(&lost, failed, &[])],
        );
    }

    /// A step on which nothing fails.
    pub fn pass(&mut self, from: usize, to: usize, name: &str) {
        let pace = self.pace(name);
        self.command(from, &[], vec![branch(&pace, to, &[])]);
    }

    /// At most `most` attempts.
    pub fn retry(&mut self, from: usize, to: usize, name: &str, most: i32) {
        let value = self.random.between(0.2, 0.6);
        let misses = self.constant(name, value);
        let failed = self.mode(name, from, misses, true);
        let tries = self.counter(format!("tries_{name}"), 0, most);
        let again = branch(&[Factor::Of(misses)], from, &[Update::Add(tries, 1)]);
        let goes = branch(&[Factor::Not(misses)], to, &[]);
        self.command(from, &[Guard::Below(tries, most)], vec![goes, again]);
        self.command(
            from,
            &[Guard::Is(tries, most)],
            vec![branch(&[], failed, &[])],
        );
    }

    /// Something that happens in a share of the runs, which then pass through another location.
    pub fn fork(&mut self, from: usize, to: usize, name: &str) -> usize {
        let value = self.random.between(0.15, 0.5);
        let share = self.constant(name, value);
        let aside = self.location(name);
        let turns = branch(&[Factor::Of(share)], aside, &[]);
        self.command(
            from,
            &[],
            vec![turns, branch(&[Factor::Not(share)], to, &[])],
        );
        aside
    }

    /// A way of `cells` cells.
    pub fn travel(&mut self, from: usize, to: usize, name: &str, cells: i32) {
        let total = self.random.log_between(0.05, 0.3);
        let loses = self.constant(name, 1.0 - (1.0 - total).powf(1.0 / f64::from(cells)));
        let value = self.random.between(0.05, 0.3);
        let slips = self.constant(&format!("slip_{name}"), value);
        let failed = self.mode(name, from, loses, true);
        let cell = self.counter(format!("cell_{name}"), 0, cells);
        let on = branch(
            &[Factor::Not(slips), Factor::Not(loses)],
            from,
            &[Update::Add(cell, 1)],
        );
        let stay = branch(&[Factor::Of(slips)], from, &[]);
        let lost = branch(&[Factor::Not(slips), Factor::Of(loses)], failed, &[]);
        self.command(from, &[Guard::Below(cell, cells)], vec![on, stay, lost]);
        self.command(from, &[Guard::Is(cell, cells)], vec![branch(&[], to, &[])]);
    }

    /// A message and its answer over a channel that loses either, sent at most `most` times.
    pub fn exchange(&mut self, from: usize, to: usize, name: &str, most: i32) {
        let value = self.random.between(0.1, 0.35);
        let loses = self.constant(name, value);
        let failed = self.mode(name, from, loses, true);
        let sent = self.counter(format!("sent_{name}"), 0, most);
        let answered = self.location(&format!("heard_{name}"));
        let again = |at| branch(&[Factor::Of(loses)], at, &[]);
        let send = branch(&[Factor::Not(loses)], answered, &[Update::Add(sent, 1)]);
        let unheard = branch(&[Factor::Of(loses)], from, &[Update::Add(sent, 1)]);
        self.command(from, &[Guard::Below(sent, most)], vec![send, unheard]);
        self.command(
            from,
            &[Guard::Is(sent, most)],
            vec![branch(&[], failed, &[])],
        );
        let answer = branch(&[Factor::Not(loses)], to, &[]);
        self.command(answered, &[], vec![answer, again(from)]);
    }

    /// A queue of `waiting`, each step of which serves one or loses patience.
    pub fn serve(&mut self, from: usize, to: usize, name: &str, waiting: i32) {
        let served = self.random.between(0.4, 0.8);
        let served = self.constant(&format!("serve_{name}"), served);
        let total = self.random.log_between(0.05, 0.3);
        let leaves = self.constant(
            name,
            1.0 - (1.0 - total).powf(1.0 / (2.0 * f64::from(waiting))),
        );
        let failed = self.mode(name, from, leaves, true);
        let queue = self.counter(format!("queue_{name}"), waiting, waiting);
        let next = branch(
            &[Factor::Not(leaves), Factor::Of(served)],
            from,
            &[Update::Add(queue, -1)],
        );
        let stay = branch(&[Factor::Not(leaves), Factor::Not(served)], from, &[]);
        let lost = branch(&[Factor::Of(leaves)], failed, &[]);
        self.command(from, &[Guard::Above(queue, 0)], vec![next, stay, lost]);
        self.command(from, &[Guard::Is(queue, 0)], vec![branch(&[], to, &[])]);
    }

    /// Parts in any order, each of which may jam when it is its turn.
    pub fn assemble(&mut self, from: usize, to: usize, parts: &[&str]) {
        let fitted: Vec<usize> = parts
            .iter()
            .map(|part| self.counter(format!("has_{part}"), 0, 1))
            .collect();
        for (part, own) in parts.iter().zip(&fitted) {
            let value = self.random.log_between(0.03, 0.2);
            let jams = self.constant(part, value);
            let at = self.location(&format!("fitting_{part}"));
            self.command(from, &[Guard::Is(*own, 0)], vec![branch(&[], at, &[])]);
            let failed = self.mode(part, at, jams, false);
            let fits = branch(&[Factor::Not(jams)], from, &[Update::Set(*own, 1)]);
            self.command(
                at,
                &[],
                vec![fits, branch(&[Factor::Of(jams)], failed, &[])],
            );
        }
        let all: Vec<Guard> = fitted.iter().map(|own| Guard::Is(*own, 1)).collect();
        self.command(from, &all, vec![branch(&[], to, &[])]);
    }

    /// Work by rates: it ends, or breaks; what is broken is repaired, or given up.
    pub fn repairable(&mut self, from: usize, to: usize, name: &str) {
        let draw = |random: &mut Random, low, high| random.between(low, high);
        let (ends, breaks) = (draw(self.random, 0.4, 1.2), draw(self.random, 0.1, 0.6));
        let (repaired, given_up) = (draw(self.random, 0.8, 2.0), draw(self.random, 0.05, 0.5));
        let ends = self.constant(&format!("end_{name}"), ends);
        let breaks = self.constant(&format!("break_{name}"), breaks);
        let repaired = self.constant(&format!("repair_{name}"), repaired);
        let given_up = self.constant(name, given_up);
        let broken = self.location(&format!("broken_{name}"));
        let failed = self.mode(name, from, given_up, true);
        let end = branch(&[Factor::Of(ends)], to, &[]);
        self.command(
            from,
            &[],
            vec![end, branch(&[Factor::Of(breaks)], broken, &[])],
        );
        self.command(
            broken,
            &[],
            vec![branch(&[Factor::Of(repaired)], from, &[])],
        );
        self.command(
            broken,
            &[],
            vec![branch(&[Factor::Of(given_up)], failed, &[])],
        );
    }

    /// A way of `length` on a grid `2 * half + 1` wide, begun in its middle; beyond its edge stands a wall.
    pub fn lattice(&mut self, from: usize, to: usize, name: &str, length: i32, half: i32) {
        let value = self.random.between(0.12, 0.3);
        let drifts = self.constant(name, value);
        let value = self.random.between(0.3, 0.7);
        let left = self.constant(&format!("left_{name}"), value);
        let failed = self.mode(name, from, drifts, true);
        let ahead = self.counter(format!("ahead_{name}"), 0, length);
        let side = self.counter(format!("side_{name}"), half, 2 * half);
        let straight = || branch(&[Factor::Not(drifts)], from, &[Update::Add(ahead, 1)]);
        let aside = |way: Factor, by: i32| {
            branch(
                &[Factor::Of(drifts), way],
                from,
                &[Update::Add(ahead, 1), Update::Add(side, by)],
            )
        };
        let wall = |way: Factor| branch(&[Factor::Of(drifts), way], failed, &[]);
        let before = Guard::Below(ahead, length);
        let (to_left, to_right) = (Factor::Of(left), Factor::Not(left));
        let inner = [before, Guard::Above(side, 0), Guard::Below(side, 2 * half)];
        self.command(
            from,
            &inner,
            vec![straight(), aside(to_left, -1), aside(to_right, 1)],
        );
        self.command(
            from,
            &[before, Guard::Is(side, 0)],
            vec![straight(), wall(to_left), aside(to_right, 1)],
        );
        self.command(
            from,
            &[before, Guard::Is(side, 2 * half)],
            vec![straight(), aside(to_left, -1), wall(to_right)],
        );
        self.command(
            from,
            &[Guard::Is(ahead, length)],
            vec![branch(&[], to, &[])],
        );
    }
}
