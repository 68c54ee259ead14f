//! Schedulers as text, in PRISM's form.
//!
//! Lines `(1,0)=go` with the state's values, or `7=go` with its number; with a memory `(1,0),2=go`. In place of the action
//! may stand the choice's place (indices); a choice without action is named by it, as in `#0`. States where the choice
//! does not matter are left out. Where one of several choices is drawn, each has a line, with its share:
//! `(1,0),0=1/3:go`. Source: PRISM's manual, "Strategies" (`-exportstrat`).

use std::io::{Result, Write};

use prism_lang::Rational;

use super::{Explicit, Written};
use crate::scheduler::Scheduler;

/// One line: what is done in a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// The state.
    pub state: usize,
    /// The memory, if the scheduler has one.
    pub memory: Option<u32>,
    /// The row of the matrix.
    pub row: usize,
    /// How likely it is taken, if there are others.
    pub share: Option<Rational>,
}

impl<N: Written> Explicit<'_, N> {
    /// What a scheduler does, in the order of the states' numbers and then of the memory; without what does not matter.
    pub fn decisions(&self, scheduler: &Scheduler) -> Vec<Decision> {
        let decision = |state: usize, memory: Option<u32>, row: usize| Decision {
            state,
            memory,
            row,
            share: None,
        };
        match scheduler {
            Scheduler::ByState(rows) => (self.order.iter())
                .filter_map(|state| Some(decision(*state, None, (*rows.get(*state)?)?)))
                .collect(),
            Scheduler::WithMemory(memory) => {
                let mut nodes: Vec<_> = memory.nodes.iter().filter(|n| n.matters).collect();
                nodes.sort_by_key(|node| (self.place[node.state], node.memory));
                let decisions = nodes.into_iter().flat_map(|node| {
                    let is_drawn = node.moves.len() > 1;
                    node.moves.iter().map(move |taken| Decision {
                        share: is_drawn.then(|| taken.share.clone()),
                        ..decision(node.state, Some(node.memory), taken.row)
                    })
                });
                decisions.collect()
            }
        }
    }

    /// The name of a choice's action, or its place if it has none.
    pub fn action_or_place(&self, state: usize, row: usize) -> String {
        match self.space.action(row) {
            Some(action) => self.space.actions()[action].clone(),
            None => format!("#{}", row - self.space.choices(state).start),
        }
    }

    /// Writes a scheduler: with the states' values or their numbers, with the names of the actions or the places of
    /// the choices.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_scheduler(
        &self,
        scheduler: &Scheduler,
        with_values: bool,
        with_actions: bool,
        out: &mut dyn Write,
    ) -> Result<()> {
        for decision in self.decisions(scheduler) {
            let Decision {
                state, memory, row, ..
            } = decision;
            match with_values {
                true => write!(out, "{}", self.values(state))?,
                false => write!(out, "{}", self.place[state])?,
            }
            if let Some(memory) = memory {
                write!(out, ",{memory}")?;
            }
            write!(out, "=")?;
            if let Some(share) = decision.share {
                write!(out, "{share}:")?;
            }
            match with_actions {
                true => writeln!(out, "{}", self.action_or_place(state, row))?,
                false => writeln!(out, "{}", row - self.space.choices(state).start)?,
            }
        }
        Ok(())
    }
}
