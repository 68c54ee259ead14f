//! PRISM's explicit files.

use std::io::{Result, Write};

use super::{Explicit, Written};
use crate::state_space::{Rewards, TransitionRewards};

impl<N: Written> Explicit<'_, N> {
    /// Whether rows belong to choices.
    fn has_choices(&self) -> bool {
        self.space.kind.has_choices()
    }

    /// The name of a choice's action with a blank before it, or nothing.
    fn action(&self, choice: usize) -> String {
        let action = self.space.action(choice);
        action.map_or(String::new(), |a| format!(" {}", self.space.actions()[a]))
    }

    /// Writes the transitions (`.tra`).
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_transitions(&self, out: &mut dyn Write) -> Result<()> {
        let space = self.space;
        let kind = space.kind.keyword().to_uppercase();
        writeln!(out, "# Transitions ({kind})")?;
        let (states, entries) = (space.num_states(), space.num_transitions());
        if !self.has_choices() {
            writeln!(out, "{states} {entries}")?;
        } else {
            writeln!(out, "{states} {} {entries}", space.num_choices())?;
        }
        let is_lts = space.kind == prism_lang::resolved::ModelType::Lts;
        for (number, state) in self.order.iter().enumerate() {
            for (choice, row) in space.choices(*state).enumerate() {
                for (target, at) in self.row(row) {
                    let value = space.matrix.value[at].written();
                    match (self.has_choices(), is_lts) {
                        (false, _) => writeln!(out, "{number} {target} {value}")?,
                        (_, true) => {
                            writeln!(out, "{number} {choice} {target}{}", self.action(row))?;
                        }
                        _ => writeln!(
                            out,
                            "{number} {choice} {target} {value}{}",
                            self.action(row)
                        )?,
                    }
                }
            }
        }
        Ok(())
    }

    /// Writes the states (`.sta`).
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_states(&self, out: &mut dyn Write) -> Result<()> {
        let names = self.space.variables().iter().map(|v| v.name.as_str());
        writeln!(out, "# States")?;
        writeln!(out, "({})", names.collect::<Vec<_>>().join(","))?;
        for (number, state) in self.order.iter().enumerate() {
            writeln!(out, "{number}:{}", self.values(*state))?;
        }
        Ok(())
    }

    /// A state's values as `(1,true)`.
    pub fn values(&self, state: usize) -> String {
        let each = self.space.variables().iter().enumerate().map(|(v, of)| {
            let value = self.space.value(state, v);
            match of.kind {
                prism_lang::resolved::VariableKind::Bool => (value != 0).to_string(),
                _ => value.to_string(),
            }
        });
        format!("({})", each.collect::<Vec<_>>().join(","))
    }

    /// Writes labels (`.lab`) that were evaluated before, one flag for each state; `init` and `deadlock` first.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_labels(&self, labels: &[(String, Vec<bool>)], out: &mut dyn Write) -> Result<()> {
        let of = |states: &[usize]| {
            let mut flags = vec![false; self.space.num_states()];
            states.iter().for_each(|s| flags[*s] = true);
            flags
        };
        let init = ("init".to_owned(), of(self.space.initial_states()));
        let deadlock = ("deadlock".to_owned(), of(self.space.deadlocks()));
        let all: Vec<_> = [&init, &deadlock].into_iter().chain(labels).collect();
        let names = all.iter().enumerate();
        let names = names.map(|(at, (name, _))| format!("{at}=\"{name}\""));
        writeln!(out, "# Labels")?;
        writeln!(out, "{}", names.collect::<Vec<_>>().join(" "))?;
        for (number, state) in self.order.iter().enumerate() {
            let here = (0..all.len()).filter(|at| all[*at].1[*state]);
            let here: Vec<String> = here.map(|at| at.to_string()).collect();
            if !here.is_empty() {
                writeln!(out, "{number}: {}", here.join(" "))?;
            }
        }
        Ok(())
    }

    fn reward_head(&self, index: usize, of: &str, out: &mut dyn Write) -> Result<()> {
        match &self.space.rewards[index].0 {
            Some(name) => writeln!(out, "# Reward structure \"{name}\"")?,
            None => writeln!(out, "# Reward structure")?,
        }
        writeln!(out, "# {of} rewards")
    }

    /// Writes the state rewards (`.srew`) of the structure of this index.
    ///
    /// # Errors
    /// Those of writing.
    ///
    /// # Panics
    /// If there is no such structure, or if these are rewards of another state space.
    pub fn write_state_rewards(
        &self,
        index: usize,
        rewards: &Rewards<N>,
        out: &mut dyn Write,
    ) -> Result<()> {
        self.reward_head(index, "State", out)?;
        let some = rewards.state.iter().filter(|r| !r.is_nothing()).count();
        writeln!(out, "{} {some}", self.space.num_states())?;
        for (number, state) in self.order.iter().enumerate() {
            let reward = &rewards.state[*state];
            if !reward.is_nothing() {
                writeln!(out, "{number} {}", reward.written())?;
            }
        }
        Ok(())
    }

    /// Writes the transition rewards (`.trew`) of the structure of this index.
    ///
    /// # Errors
    /// Those of writing.
    ///
    /// # Panics
    /// If there is no such structure, or if these are rewards of another state space.
    pub fn write_transition_rewards(
        &self,
        index: usize,
        rewards: &Rewards<N>,
        out: &mut dyn Write,
    ) -> Result<()> {
        self.reward_head(index, "Transition", out)?;
        let mut lines = Vec::new();
        for (number, state) in self.order.iter().enumerate() {
            if matches!(rewards.transition, TransitionRewards::None) {
                break;
            }
            for (choice, row) in self.space.choices(*state).enumerate() {
                for (target, at) in self.row(row) {
                    let Some(reward) = rewards.transition.of(row, at).filter(|r| !r.is_nothing())
                    else {
                        continue;
                    };
                    let from = match self.has_choices() {
                        true => format!("{number} {choice}"),
                        false => number.to_string(),
                    };
                    lines.push(format!("{from} {target} {}", reward.written()));
                }
            }
        }
        let states = self.space.num_states();
        match self.has_choices() {
            true => writeln!(out, "{states} {} {}", self.space.num_choices(), lines.len())?,
            false => writeln!(out, "{states} {}", lines.len())?,
        }
        lines.iter().try_for_each(|line| writeln!(out, "{line}"))
    }
}
