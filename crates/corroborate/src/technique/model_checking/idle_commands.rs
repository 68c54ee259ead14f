//! Commands of a model whose guard holds in no state that it reaches.
//!
//! # Definition
//! A line of the text is *idle* if the guards of all commands that stand on it (several modules may be one text, renamed) hold in no
//! reachable state. That the commands of other modules with the same action never let it be taken is not looked at.
//!
//! # Assumes
//! Nothing.
//!
//! # Guarantee
//! Exact: all reachable states are gone through. What is idle need not be wrong: a constant may switch it off.

use super::{Compiled, MAX_STATES};
use diagnostic::Problem;
use query::explore;
use std::collections::BTreeMap;

/// How many lines have commands, and those that are idle, from 1.
pub(in crate::technique) struct IdleCommands {
    pub lines: usize,
    pub idle: Vec<usize>,
}

impl Compiled<'_> {
    /// The commands that are never enabled.
    ///
    /// # Errors
    /// As exploring the model's states.
    pub(in crate::technique) fn idle_commands(
        &self,
        cancel: &dyn Fn() -> bool,
    ) -> Result<IdleCommands, Problem> {
        let space = explore::<f64>(&self.source, &self.model, MAX_STATES, cancel)?;
        let mut enabled: BTreeMap<usize, bool> = BTreeMap::new();
        for command in self.model.modules.iter().flat_map(|it| &it.commands) {
            let (line, _) = prism_lang::line_and_column(&self.source.text, command.span.start);
            let known = enabled.entry(line).or_default();
            // A guard without a value somewhere is an error that exploring has told of already.
            *known |= space
                .evaluate(&command.guard)
                .is_ok_and(|all| all.contains(&true));
        }
        Ok(IdleCommands {
            lines: enabled.len(),
            idle: enabled
                .iter()
                .filter(|(_, is_enabled)| !**is_enabled)
                .map(|(line, _)| *line)
                .collect(),
        })
    }
}
