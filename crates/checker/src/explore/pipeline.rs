//! The order in which states are expanded, on one thread or two.
//!
//! Definition: states are expanded in the order of their numbers, some at a time (a batch). With two threads,
//! one finds the transitions of a batch while the other numbers the targets and writes the rows of the batch
//! before. Batches are numbered in the order in which they were handed out, so that states and rows are the
//! same for any number of threads, and so is the first error.
//!
//! Cost: each batch is handed over twice, some microseconds for hundreds of states; while few states are open,
//! one thread does all. Guarantee: the same bytes on one thread and on two.

use std::sync::mpsc::{Receiver, Sender, channel};

use prism_lang::Arithmetic;

use super::batch::Batch;
use super::generator::Generator;
use super::{ExploreError, Explorer};

/// States of a batch on one thread.
const BATCH: usize = 256;
/// Least and greatest number of states of a batch that is handed over.
const HANDED_OVER: (usize, usize) = (64, 1024);
/// Batches that are handed out at a time.
const AHEAD: usize = 4;
/// A second thread is used for at least so many open states.
const WORTHWHILE: usize = 4096;
/// As long as there are fewer open states, none are handed over.
const FEW: usize = 256;

impl<N: Arithmetic> Explorer<'_, N> {
    /// The number of states that are not expanded.
    fn open(&self) -> usize {
        self.interner.len() - self.assembly.states()
    }

    /// Expands all states that can be reached.
    pub(super) fn expand_all(
        &mut self,
        progress: &dyn Fn(usize) -> bool,
    ) -> Result<(), ExploreError> {
        let mut batch = Batch::new();
        while self.open() > 0 {
            if self.options.threads > 1 && self.open() >= WORTHWHILE {
                return self.expand_on_two_threads(progress);
            }
            self.go_on(progress)?;
            self.step(&mut batch)?;
        }
        Ok(())
    }

    fn go_on(&self, progress: &dyn Fn(usize) -> bool) -> Result<(), ExploreError> {
        match progress(self.interner.len()) {
            true => Ok(()),
            false => Err(ExploreError::Cancelled),
        }
    }

    /// Expands the next states on this thread.
    fn step(&mut self, batch: &mut Batch<N>) -> Result<(), ExploreError> {
        let next = self.assembly.states();
        let end = self.interner.len().min(next + BATCH);
        batch.clear();
        batch
            .states
            .extend_from_slice(self.interner.states(next..end));
        self.generator.fill(batch);
        self.take(batch)
    }

    fn expand_on_two_threads(
        &mut self,
        progress: &dyn Fn(usize) -> bool,
    ) -> Result<(), ExploreError> {
        let generator = self.generator.clone();
        std::thread::scope(|scope| {
            let (hand_out, jobs) = channel();
            let (hand_back, done) = channel();
            scope.spawn(move || fill_all(generator, &jobs, &hand_back));
            self.take_all(&hand_out, &done, progress)
            // The channels close here, which ends the other thread.
        })
    }

    /// Hands out batches and takes them back, until no state is open.
    fn take_all(
        &mut self,
        hand_out: &Sender<Batch<N>>,
        done: &Receiver<Batch<N>>,
        progress: &dyn Fn(usize) -> bool,
    ) -> Result<(), ExploreError> {
        let mut spare = vec![Batch::new()];
        let mut sent = self.assembly.states();
        let mut away = 0;
        while self.open() > 0 {
            self.go_on(progress)?;
            if away == 0 && self.open() < FEW {
                self.step(&mut spare[0])?;
                sent = self.assembly.states();
                continue;
            }
            while away < AHEAD && sent < self.interner.len() {
                // One stays for the steps on this thread.
                let kept = if spare.len() > 1 { spare.pop() } else { None };
                let mut batch = kept.unwrap_or_else(Batch::new);
                sent = self.hand_out(sent, &mut batch);
                away += 1;
                // If the other thread is gone, it has panicked, and receiving fails below.
                let _ = hand_out.send(batch);
            }
            let Ok(mut batch) = done.recv() else {
                return Err(ExploreError::Cancelled);
            };
            away -= 1;
            self.take(&mut batch)?;
            spare.push(batch);
        }
        Ok(())
    }

    /// Puts the states from `sent` on into a batch; returns the first that did not fit.
    fn hand_out(&self, sent: usize, batch: &mut Batch<N>) -> usize {
        let (least, most) = HANDED_OVER;
        let size = (self.open() / AHEAD).clamp(least, most);
        let end = self.interner.len().min(sent + size);
        batch.clear();
        batch
            .states
            .extend_from_slice(self.interner.states(sent..end));
        end
    }
}

/// What the other thread does.
fn fill_all<N: Arithmetic>(
    mut generator: Generator<'_, N>,
    jobs: &Receiver<Batch<N>>,
    hand_back: &Sender<Batch<N>>,
) {
    for mut batch in jobs {
        generator.fill(&mut batch);
        if hand_back.send(batch).is_err() {
            return;
        }
    }
}
