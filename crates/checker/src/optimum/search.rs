//! Bounds of the equations of one strongly connected component by value iteration and guesses.
//!
//! *Method.* Rounds of value iteration from below in place (Gauss-Seidel), with the lower and with the upper values outside, or
//! with one of them where they hardly differ; whenever it hardly moves, bounds just below and above are guessed and kept if they are
//! inductive (optimistic value iteration, Hartmanns and Kaminski 2020, here on both sides). States are in the order in which a
//! depth-first search leaves them ([`crate::graph::Components`]), so that within one round values come in from everywhere but
//! along the transitions that close a circle.
//!
//! *Guarantee.* Bounds that are kept hold; see [`super::sound`]. Cost: rounds times entries.

use super::local::{Local, Side};
use super::slack::Slack;
use crate::answer::{CheckError, Options};

/// Rounds of iteration between two looks at how fast it converges, and the most that may be to come.
const LOOK: u64 = 8;
const MOST_ROUNDS: f64 = 96.0;
/// Values of which some become so much greater in one round, relatively, are arriving.
const ARRIVING: f64 = 0.9;

/// The search for bounds of one component.
pub(super) struct Search<'a> {
    pub local: &'a Local,
    pub maximise: bool,
    pub tolerance: f64,
    /// Approximations with the lower and upper values outside.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Bounds that hold.
    pub found: Vec<(f64, f64)>,
    pub rounds: u64,
    /// Whether every other round goes through the states backwards.
    pub alternating: bool,
}

impl<'a> Search<'a> {
    /// From 0, and from the bounds that are known beforehand.
    pub fn new(local: &'a Local, maximise: bool, tolerance: f64, cap: f64) -> Self {
        Self {
            local,
            maximise,
            tolerance,
            low: vec![0.0; local.len()],
            high: vec![0.0; local.len()],
            found: vec![(0.0, cap); local.len()],
            rounds: 0,
            alternating: false,
        }
    }

    /// Iterates until bounds are found or `work` multiplications are done; then what was reached gives what bounds it can.
    pub fn iterate(&mut self, work: u64, cancelled: &dyn Fn() -> bool) -> bool {
        if self.rounds(work, false, cancelled) {
            return true;
        }
        if self.is_one_sided() {
            self.high.clone_from(&self.low);
        }
        // What was reached from below is a lower bound when moved down by the error of a round.
        self.guess(self.tolerance.max(1e-3));
        false
    }

    /// Iterates when a check is stopped, for so many multiplications; the work done.
    pub fn last_rounds(&mut self, work: u64) -> u64 {
        let each = (self.local.entries() + self.local.len()).max(1) as u64;
        let rounds = work / each;
        let mut low = std::mem::take(&mut self.low);
        for round in 0..rounds {
            self.rounds += 1;
            if self.round(&mut low, Side::Low) == 0.0 {
                self.low = low;
                return (round + 1) * each;
            }
        }
        self.low = low;
        rounds * each
    }

    /// The bounds that the values reached from below give when a check is stopped.
    pub fn bounds_reached(&mut self) {
        for (high, low) in self.high.iter_mut().zip(&self.low) {
            *high = high.max(*low);
        }
        self.guess(self.tolerance.max(1e-3));
    }

    /// Whether one side's approximations are near enough to the other's.
    fn is_one_sided(&self) -> bool {
        self.local.is_one_sided(self.tolerance / 1000.0)
    }

    /// Iterates until bounds are found or `work` multiplications are done; not further than it is promising, if it must be.
    pub fn rounds(&mut self, work: u64, promising: bool, cancelled: &dyn Fn() -> bool) -> bool {
        let one_sided = self.is_one_sided();
        let mut change_before = f64::INFINITY;
        let each = (self.local.entries() + self.local.len()).max(1) as u64 * 2;
        let last = self.rounds.max(64) + work / each;
        let mut patience = self.tolerance / 10.0;
        while self.rounds < last {
            if self.rounds.is_multiple_of(16) && cancelled() {
                return false;
            }
            let mut low = std::mem::take(&mut self.low);
            let mut change = self.round(&mut low, Side::Low);
            self.low = low;
            if !one_sided {
                let mut high = std::mem::take(&mut self.high);
                change = change.max(self.round(&mut high, Side::High));
                self.high = high;
            }
            self.rounds += 1;
            if promising && self.rounds.is_multiple_of(LOOK) {
                let factor = (change / change_before).powf(1.0 / LOOK as f64);
                let to_come = (patience / change).ln() / factor.ln();
                // Where values still arrive, change tells nothing of how fast they converge.
                let is_slow = factor < 1.0 && to_come > MOST_ROUNDS - self.rounds as f64;
                let is_late = change > ARRIVING && self.rounds > LOOK;
                if is_slow || is_late {
                    return false;
                }
                change_before = change;
            }
            if change <= patience {
                if one_sided {
                    self.high.clone_from(&self.low);
                }
                if self.guess(self.tolerance) {
                    return true;
                }
                if change == 0.0 {
                    break;
                }
                patience /= 4.0;
            }
        }
        false
    }

    /// By linear equations and slack ([`super::slack`]), from what iteration has reached; whether both bounds are close.
    pub fn solve(&mut self, options: &Options<'_>) -> Result<bool, CheckError> {
        let slack = Slack {
            local: self.local,
            maximise: self.maximise,
            tolerance: self.tolerance,
            options,
        };
        let confirmed = match slack.search(self.low.clone()) {
            // What iteration has reached gives bounds.
            Err(CheckError::Cancelled) if options.must_stop() => return Ok(false),
            confirmed => confirmed?,
        };
        if let Some(lower) = &confirmed.lower {
            (self.found.iter_mut().zip(lower)).for_each(|(f, x)| f.0 = f.0.max(*x));
        }
        if let Some(upper) = &confirmed.upper {
            (self.found.iter_mut().zip(upper)).for_each(|(f, x)| f.1 = f.1.min(*x));
        }
        if confirmed.is_close {
            self.low = confirmed.candidate;
        }
        Ok(confirmed.is_close)
    }

    /// One round from below; the greatest relative change.
    fn round(&self, x: &mut [f64], side: Side) -> f64 {
        let mut change = 0f64;
        let states = x.len();
        let backwards = self.alternating && !self.rounds.is_multiple_of(2);
        for position in 0..states {
            let place = if backwards {
                states - 1 - position
            } else {
                position
            };
            let (_, value) = self.local.best(place, x, side, self.maximise);
            let known = x[place];
            if value > known {
                change = change.max((value - known) / value);
                x[place] = value;
            }
        }
        change
    }

    /// Tries bounds at this relative distance; whether both hold.
    pub fn guess(&mut self, distance: f64) -> bool {
        let distance = 0.45 * distance;
        let lower: Vec<f64> = self.low.iter().map(|x| x * (1.0 - distance)).collect();
        let upper: Vec<f64> = self.high.iter().map(|x| x * (1.0 + distance)).collect();
        let held = [
            self.inductive(lower, Side::Low, distance),
            self.inductive(upper, Side::High, distance),
        ];
        for (place, found) in self.found.iter_mut().enumerate() {
            if let Some(lower) = &held[0] {
                found.0 = found.0.max(lower[place]);
            }
            if let Some(upper) = &held[1] {
                found.1 = found.1.min(upper[place]);
            }
        }
        held.iter().all(Option::is_some)
    }

    /// The guess, or what some rounds make of it, if that is inductive.
    ///
    /// A guess that fails by much less than its distance is worth more rounds, forwards and backwards in turn: where a
    /// state's choice neither earns nor leaves, what is to spare has to arrive from other states first, and within one
    /// round the allowance for rounding adds up along the states that are looked at one after the other.
    fn inductive(&self, mut guess: Vec<f64>, side: Side, distance: f64) -> Option<Vec<f64>> {
        const FEW: usize = 6;
        const MANY: usize = 1000;
        /// Rounds in which what is missing has to become less.
        const SPAN: usize = 64;
        let error = match side {
            Side::Low => 1.0 - self.local.error,
            Side::High => 1.0 + self.local.error,
        };
        let by_rounding = 8.0 * self.local.error;
        let allowed = by_rounding.max(distance / 100.0);
        let states = guess.len();
        let mut worst_before = f64::INFINITY;
        for round in 0..MANY {
            let (mut holds, mut worst) = (true, 0.0_f64);
            for position in 0..states {
                let place = if round % 2 == 0 {
                    position
                } else {
                    states - 1 - position
                };
                let (_, value) = self.local.best(place, &guess, side, self.maximise);
                let (next, known) = (value * error, guess[place]);
                let missing = match side {
                    Side::Low => known - next,
                    Side::High => next - known,
                };
                if missing > 0.0 || missing.is_nan() {
                    holds = false;
                    let share = missing / known;
                    worst = worst.max(if share.is_nan() { f64::INFINITY } else { share });
                }
                guess[place] = next;
            }
            if holds {
                return Some(guess);
            }
            if round >= FEW && worst > allowed {
                return None;
            }
            if round % SPAN == SPAN - 1 {
                if worst > by_rounding && worst > 0.9 * worst_before {
                    return None;
                }
                worst_before = worst;
            }
        }
        None
    }
}
