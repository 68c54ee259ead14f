//! The robustness of what a monitor demands from one of its stages on.
//!
//! For each sample i, in order, a stage gives D(i), a row over the variables of the unbounded stages
//! (see [`super`]), as soon as its window is over and the stage after it has given what the window
//! needs. A window slides, and what it holds is folded by two stacks (K. Tangwongsan, M. Hirzel and
//! S. Schneider, "Low-latency sliding-window aggregation in worst-case constant time", DEBS 2017).

use std::collections::VecDeque;

use super::row::{Carry, Row};
use crate::clock::tolerance_secs;

/// What a stage gives for a sample: D there, and what the variables were since the sample before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<const N: usize> {
    pub(super) row: Row<N>,
    pub(super) carry: Carry<N>,
}

/// A stage at a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Here {
    pub(super) time_secs: f64,
    /// By how much the stage may go on.
    pub(super) on: f64,
    /// By how much it may end.
    pub(super) end: f64,
}

/// How long a stage may last.
#[derive(Debug, Clone)]
pub(super) enum Lasting<const N: usize> {
    /// It is over where it begins.
    OneInstant,
    /// For ever; it has a variable.
    Unbounded { variable: usize },
    /// Up to a deadline.
    Within(Box<Window<N>>),
}

/// A stage at work.
#[derive(Debug, Clone)]
pub(super) struct StageWork<const N: usize> {
    lasting: Lasting<N>,
    /// Samples for which the next stage has not given its row.
    waiting: VecDeque<Here>,
}

impl<const N: usize> StageWork<N> {
    pub(super) fn new(lasting: Lasting<N>) -> Self {
        StageWork {
            lasting,
            waiting: VecDeque::new(),
        }
    }

    pub(super) fn stored(&self) -> usize {
        self.waiting.len()
            + match &self.lasting {
                Lasting::Within(window) => window.times_secs.len(),
                _ => 0,
            }
    }

    /// A sample has come.
    pub(super) fn see(&mut self, here: Here) {
        self.waiting.push_back(here);
    }

    /// Takes what the next stage gave, in order; gives what follows.
    pub(super) fn take(&mut self, from_next: &[Given<N>], out: &mut Vec<Given<N>>) {
        for next in from_next {
            let Some(here) = self.waiting.pop_front() else {
                return;
            };
            let ended = next.row.at_most(here.end);
            match &mut self.lasting {
                Lasting::OneInstant => out.push(Given {
                    row: ended,
                    carry: next.carry,
                }),
                Lasting::Unbounded { variable } => {
                    let row = ended.greater(&Row::variable(*variable, here.on));
                    out.push(Given {
                        row,
                        carry: next.carry.with(*variable, row),
                    });
                }
                Lasting::Within(window) => {
                    let link = Link {
                        on: here.on,
                        ended,
                        carry: next.carry,
                    };
                    window.take(here.time_secs, link, out);
                }
            }
        }
    }

    /// No more samples come; a stage that could go on then has the value `after`.
    pub(super) fn close(&mut self, after: f64, out: &mut Vec<Given<N>>) {
        if let Lasting::Within(window) = &mut self.lasting {
            window.close(after, out);
        }
    }
}

/// Consecutive samples of a window.
#[derive(Debug, Clone, Copy)]
struct Link<const N: usize> {
    /// The least by which the stage may go on in them.
    on: f64,
    /// The best if it ends in them.
    ended: Row<N>,
    /// What the variables were before them.
    carry: Carry<N>,
}

impl<const N: usize> Link<N> {
    fn empty() -> Self {
        Link {
            on: f64::INFINITY,
            ended: Row::nothing(),
            carry: Carry::default(),
        }
    }

    fn then(&self, next: &Self) -> Self {
        let ended = next.carry.of_row(&self.ended);
        Link {
            on: self.on.min(next.on),
            ended: ended.greater(&next.ended.at_most(self.on)),
            carry: self.carry.then(&next.carry),
        }
    }
}

/// The samples within a deadline of those whose value is not given.
#[derive(Debug, Clone)]
pub(super) struct Window<const N: usize> {
    within_secs: f64,
    times_secs: VecDeque<f64>,
    /// Older samples, the oldest last: each the fold from it on.
    old: Vec<Link<N>>,
    new: Vec<Link<N>>,
    new_fold: Link<N>,
    /// Since the last value was given.
    carry: Carry<N>,
}

impl<const N: usize> Window<N> {
    pub(super) fn new(within_secs: f64) -> Self {
        Window {
            within_secs,
            times_secs: VecDeque::new(),
            old: Vec::new(),
            new: Vec::new(),
            new_fold: Link::empty(),
            carry: Carry::default(),
        }
    }

    fn take(&mut self, time_secs: f64, link: Link<N>, out: &mut Vec<Given<N>>) {
        let tolerance_secs = tolerance_secs(time_secs);
        let latest_secs = self.within_secs + tolerance_secs;
        self.give_where(|from_secs| time_secs - from_secs > latest_secs, out);
        self.times_secs.push_back(time_secs);
        self.carry = self.carry.then(&link.carry);
        self.new_fold = self.new_fold.then(&link);
        self.new.push(link);
        let over_secs = self.within_secs - tolerance_secs;
        self.give_where(|from_secs| time_secs - from_secs >= over_secs, out);
    }

    /// Gives the values of those samples whose window is over.
    fn give_where(&mut self, is_over: impl Fn(f64) -> bool, out: &mut Vec<Given<N>>) {
        while self.times_secs.front().is_some_and(|from| is_over(*from)) {
            self.give(f64::NEG_INFINITY, out);
        }
    }

    /// Gives the value of the first sample; `after` is that of going on beyond the last one.
    fn give(&mut self, after: f64, out: &mut Vec<Given<N>>) {
        let fold = match self.old.last() {
            Some(old) => old.then(&self.new_fold),
            None => self.new_fold,
        };
        let mut row = fold.ended;
        row.constant = row.constant.max(fold.on.min(after));
        out.push(Given {
            row,
            carry: std::mem::take(&mut self.carry),
        });
        self.forget_first();
    }

    fn forget_first(&mut self) {
        self.times_secs.pop_front();
        if self.old.is_empty() {
            let mut fold = Link::empty();
            for link in self.new.drain(..).rev() {
                fold = link.then(&fold);
                self.old.push(fold);
            }
            self.new_fold = Link::empty();
        }
        self.old.pop();
    }

    fn close(&mut self, after: f64, out: &mut Vec<Given<N>>) {
        while !self.times_secs.is_empty() {
            self.give(after, out);
        }
    }
}
