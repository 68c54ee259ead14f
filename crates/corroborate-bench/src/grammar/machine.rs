//! Machines: the truth of a generated study, from which its model's text, its simulator and its data are made.
//!
//! # Definition
//! A machine has a location, counters in ranges, and commands. A command is enabled at its location where its guards
//! hold; it leads along one of its branches. In *discrete* time a branch's weight is its probability, a command takes
//! one step, and of several enabled commands one is chosen with equal probability where nothing else says which (in the
//! model's text that choice is left open). In *continuous* time weights are rates, and all enabled commands race. A
//! weight is a product of constants and of complements of constants. A location without an enabled command is an end.
//!
//! [`Machine::reaches`] sums the probabilities of a location over all states by Gauss-Seidel iteration from 0, until no
//! value changes by 1e-13: a lower bound whose error is that of the iteration, far below any count's; it serves as truth
//! for scoring only.

use crate::random::Random;
use std::collections::BTreeMap;

/// Time of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// Steps, with probabilities.
    Steps,
    /// Steps, and choices that the model's text leaves open.
    Choices,
    /// Rates.
    Rates,
}

/// A number with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The name that a model gives it.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// A counter.
#[derive(Clone, Debug, PartialEq)]
pub struct Counter {
    /// Its name.
    pub name: String,
    /// Its first value.
    pub first: i32,
    /// Its largest value; the least is 0.
    pub most: i32,
}

/// A factor of a weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// A constant.
    Of(usize),
    /// 1 minus a constant.
    Not(usize),
}

/// What a guard asks of a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// Less than this.
    Below(usize, i32),
    /// Equal to this.
    Is(usize, i32),
    /// More than this.
    Above(usize, i32),
}

/// What a branch does to a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// Sets it.
    Set(usize, i32),
    /// Adds to it.
    Add(usize, i32),
}

/// A branch of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its weight; empty for 1.
    pub weight: Vec<Factor>,
    /// Where it leads.
    pub to: usize,
    /// What it does to counters.
    pub updates: Vec<Update>,
}

/// A command.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// At which location.
    pub at: usize,
    /// Where else it asks for something.
    pub guards: Vec<Guard>,
    /// Its branches.
    pub branches: Vec<Branch>,
}

/// A way to fail.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Its name.
    pub name: String,
    /// The location in which it could happen.
    pub at: usize,
    /// The location in which it has happened.
    pub failed: usize,
    /// The constant that rules it.
    pub constant: usize,
    /// Whether that constant acts more than once in a run.
    pub repeats: bool,
}

/// A machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its time.
    pub time: Time,
    /// Seconds of a step, or of a unit of time.
    pub step_secs: f64,
    /// Its constants.
    pub constants: Vec<Constant>,
    /// The names of its locations; the first is the start.
    pub locations: Vec<String>,
    /// Its counters.
    pub counters: Vec<Counter>,
    /// Its commands.
    pub commands: Vec<Command>,
    /// How it can fail.
    pub modes: Vec<Mode>,
    /// The location in which a run is done.
    pub done: usize,
    /// The location in which the robot is near a person.
    pub near: Option<usize>,
    /// The location of something that does not happen in every run.
    pub alarm: Option<usize>,
}

/// A state: the location, then the counters.
pub type State = Vec<i32>;

/// A run: its states with the seconds at which each was entered.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Run {
    /// Seconds and states, the first at 0.
    pub states: Vec<(f64, State)>,
}

impl Run {
    /// Whether it was at a location.
    #[must_use]
    pub fn was_at(&self, location: usize) -> bool {
        self.entered(location).is_some()
    }

    /// When it first came to a location.
    #[must_use]
    pub fn entered(&self, location: usize) -> Option<f64> {
        let mut states = self.states.iter();
        let found = states.find(|(_, state)| state[0] as usize == location);
        found.map(|(at, _)| *at)
    }

    /// When it ended.
    #[must_use]
    pub fn ended(&self) -> f64 {
        self.states.last().map_or(0.0, |(at, _)| *at)
    }
}

/// A run that comes to no end by then is ended: more than any machine of the grammar takes but for one run in a billion.
const LONGEST: usize = 5000;

impl Machine {
    /// The first state.
    #[must_use]
    pub fn start(&self) -> State {
        let counters = self.counters.iter().map(|counter| counter.first);
        std::iter::once(0).chain(counters).collect()
    }

    /// The value of a weight.
    #[must_use]
    pub fn weight(&self, branch: &Branch) -> f64 {
        let factor = |it: &Factor| match it {
            Factor::Of(place) => self.constants[*place].value,
            Factor::Not(place) => 1.0 - self.constants[*place].value,
        };
        branch.weight.iter().map(factor).product()
    }

    fn holds(guard: &Guard, state: &State) -> bool {
        match guard {
            Guard::Below(place, value) => state[place + 1] < *value,
            Guard::Is(place, value) => state[place + 1] == *value,
            Guard::Above(place, value) => state[place + 1] > *value,
        }
    }

    /// The branches of a state: how likely each is, in discrete time, or its rate, and where it leads.
    #[must_use]
    pub fn branches(&self, state: &State) -> Vec<(f64, State)> {
        let enabled = self.commands.iter().filter(|command| {
            let mut guards = command.guards.iter();
            command.at as i32 == state[0] && guards.all(|guard| Self::holds(guard, state))
        });
        let enabled: Vec<&Command> = enabled.collect();
        let share = match self.time {
            Time::Rates => 1.0,
            _ => 1.0 / enabled.len().max(1) as f64,
        };
        let branches = enabled.iter().flat_map(|command| &command.branches);
        let led = branches.map(|branch| {
            let mut next = state.clone();
            next[0] = branch.to as i32;
            for update in &branch.updates {
                match update {
                    Update::Set(place, value) => next[place + 1] = *value,
                    Update::Add(place, value) => next[place + 1] += *value,
                }
            }
            (share * self.weight(branch), next)
        });
        led.filter(|(weight, _)| *weight > 0.0).collect()
    }

    /// One run.
    pub fn run(&self, random: &mut Random) -> Run {
        let mut run = Run {
            states: vec![(0.0, self.start())],
        };
        let mut at = 0.0;
        while run.states.len() < LONGEST {
            let branches = self.branches(&run.states[run.states.len() - 1].1);
            let total: f64 = branches.iter().map(|(weight, _)| weight).sum();
            if branches.is_empty() {
                return run;
            }
            at += match self.time {
                Time::Rates => -self.step_secs * random.unit().ln() / total,
                _ => self.step_secs,
            };
            let mut left = random.unit() * total;
            let mut chosen = branches.len() - 1;
            for (place, (weight, _)) in branches.iter().enumerate() {
                left -= weight;
                if left < 0.0 {
                    chosen = place;
                    break;
                }
            }
            run.states.push((at, branches[chosen].1.clone()));
        }
        run
    }

    /// The probability that a run comes to a location.
    #[must_use]
    pub fn reaches(&self, location: usize) -> f64 {
        self.reaches_any(&[location])
    }

    /// The probability that a run comes to one of several locations.
    #[must_use]
    pub fn reaches_any(&self, goals: &[usize]) -> f64 {
        let mut places: BTreeMap<State, usize> = BTreeMap::new();
        let mut states = vec![self.start()];
        places.insert(self.start(), 0);
        let mut edges: Vec<Vec<(f64, usize)>> = Vec::new();
        while edges.len() < states.len() {
            let branches = self.branches(&states[edges.len()]);
            let total: f64 = branches.iter().map(|(weight, _)| weight).sum();
            let mut own = Vec::new();
            for (weight, next) in branches {
                let place = *places.entry(next.clone()).or_insert_with(|| {
                    states.push(next);
                    states.len() - 1
                });
                own.push((weight / total, place));
            }
            edges.push(own);
        }
        let is_goal = |state: &State| goals.contains(&(state[0] as usize));
        let mut values: Vec<f64> = states
            .iter()
            .map(|s| f64::from(u8::from(is_goal(s))))
            .collect();
        for _ in 0..100_000 {
            let mut change: f64 = 0.0;
            for place in (0..states.len())
                .rev()
                .filter(|place| !is_goal(&states[*place]))
            {
                let value: f64 = edges[place]
                    .iter()
                    .map(|(share, to)| share * values[*to])
                    .sum();
                change = change.max((value - values[place]).abs());
                values[place] = value;
            }
            if change < 1e-13 {
                break;
            }
        }
        values[0]
    }

    /// How often a mode occurs where it can: of the runs that come to its location, the share that fails so.
    #[must_use]
    pub fn rate(&self, mode: &Mode) -> Option<f64> {
        let could = self.reaches(mode.at);
        (could > 0.0).then(|| self.reaches(mode.failed) / could)
    }

    /// The mode of a name.
    #[must_use]
    pub fn mode(&self, name: &str) -> Option<&Mode> {
        self.modes.iter().find(|mode| mode.name == name)
    }

    /// Whether a location has no way on.
    #[must_use]
    pub fn is_end(&self, location: usize) -> bool {
        !self.commands.iter().any(|command| command.at == location)
    }

    /// The machine as one person or session finds it: what rules each mode is that cluster's own.
    #[must_use]
    pub fn of_cluster(&self, correlation: f64, random: &mut Random) -> Self {
        let mut own = self.clone();
        for mode in &self.modes {
            let constant = &mut own.constants[mode.constant];
            if constant.value < 1.0 && self.time != Time::Rates {
                constant.value = random.rate_of_cluster(constant.value, correlation);
            } else if correlation > 0.0 {
                // A rate varies as a probability of the same spread would.
                constant.value *= (correlation.sqrt() * random.normal() - 0.5 * correlation).exp();
            }
        }
        own
    }
}
