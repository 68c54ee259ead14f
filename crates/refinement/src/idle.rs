//! A value that a model declares or asks for, and never comes to: what leads there was written otherwise.
//!
//! # Definition
//! Four things in a text say a value that the model never has:
//!
//! * a *counter* (a variable with declared bounds that an update counts up or down) whose guards name one number and neither end of
//!   its range: the number is written where the end was meant (`tries : [0..3]` with `tries<2`). In all comparisons of the guards
//!   it becomes one end;
//! * a counter that begins between the ends of its range: it begins at one of them;
//! * a guard that asks for a value that no update gives and that does not hold at the beginning (`cuts=1`): one update of the module
//!   does that, in place of what it does or with it; or it holds at the beginning;
//! * a variable that stands nowhere else: it counts how often something is tried again. Of one command one update leads, as often as
//!   its range allows, to where another update of the module leads.
//!
//! Each such change is solved and tried on all evidence ([`crate::structure`]) where the model disagrees strongly with counts. No
//! number is fitted.
//!
//! # Assumes
//! That one place is wrong, and that what is declared was meant to be used.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843). What is offered was solved. Several places may give the same rates; each says so.
//! Which values are never reached is read off the text, not off the states: a change that leads nowhere moves no value, and is
//! dropped for that.
//!
//! # Cost
//! One solution for each; at most [`MOST_CHANGES`] in all, of a large model fewer, so that states times solutions stay below
//! [`crate::model_offers::MOST_WORK`].

mod candidates;

pub(crate) use candidates::declared;

use crate::counts::Counts;
use crate::draws;
use crate::model_change::{Changed, ModelChange, Read, Refusal, Solver, Values};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use crate::structure::{Rewriting, Tried};
use candidates::{asked_in_vain, changes, limits};
use evidence::Subject;
use prism_lang::ast::Command;
use prism_lang::edit::{self, Edit};

/// Changes that are tried, at most.
const MOST_CHANGES: usize = 400;

/// What makes a model come to a value that it declares or asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Idle {
    /// Another number in the guards of a counter.
    Limit {
        /// The counter.
        variable: String,
        /// The number that its guards name.
        old: i64,
        /// The end of its range, as it is written.
        new: String,
    },
    /// Another value at the beginning.
    Begin {
        /// The counter.
        variable: String,
        /// The end of its range, as it is written.
        new: String,
    },
    /// Another outcome of an update.
    Outcome {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// Its update, counted from 0.
        update: usize,
        /// What a guard asks for.
        asked: String,
        /// What the update does then.
        to: String,
    },
    /// Another outcome of an update, as often as a variable's range allows.
    Again {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// Its update, counted from 0.
        update: usize,
        /// The variable that counts.
        variable: String,
        /// The end of its range, as it is written; none for `bool`.
        most: Option<String>,
        /// What the update does as long as the end is not reached.
        to: String,
    },
}

impl Idle {
    /// The first line of a model's text that it changes, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let read = Read::new(text).ok()?;
        let first = self
            .edits(&read)
            .ok()?
            .iter()
            .map(|it| it.span.start)
            .min()?;
        let (line, _) = prism_lang::line_and_column(text, first);
        u32::try_from(line).ok()
    }

    /// What of the text is changed, in few words.
    #[must_use]
    pub fn part(&self) -> String {
        match self {
            Self::Limit { variable, old, .. } => format!("{old} of {variable}"),
            Self::Begin { variable, .. } => format!("init of {variable}"),
            Self::Again { variable, .. } => format!("a command that counts {variable}"),
            Self::Outcome { asked, .. } => format!("an update to {asked}"),
        }
    }

    /// What in the text speaks for it, as a clause.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Limit { variable, old, new } => {
                format!("the range of `{variable}` ends at {new}, and its guards name {old} alone")
            }
            Self::Begin { variable, new } => {
                format!("`{variable}` may be {new}, and never is")
            }
            Self::Again { variable, .. } => {
                format!("`{variable}` is declared, and nothing uses it")
            }
            Self::Outcome { asked, .. } => {
                format!("a guard asks for `{asked}`, and no update leads there")
            }
        }
    }

    fn words(&self, text: &str) -> String {
        let line = self.line(text).unwrap_or_default();
        match self {
            Self::Limit { variable, old, new } => {
                format!(
                    "{new} in place of {old} in the guards of `{variable}`, from line {line} on"
                )
            }
            Self::Begin { variable, new } => {
                format!("`{variable}` begins with {new}, in line {line}")
            }
            Self::Again { to, variable, .. } => {
                format!(
                    "`{to}` as what an update of line {line} does, as often as `{variable}` counts"
                )
            }
            Self::Outcome { to, .. } => format!("`{to}` as what an update of line {line} does"),
        }
    }

    fn edits(&self, read: &Read<'_>) -> Result<Vec<Edit>, Refusal> {
        match self {
            Self::Limit { variable, old, new } => {
                let all = limits(read, variable).into_iter();
                let edits: Vec<Edit> = all
                    .filter(|(_, value)| value == old)
                    .map(|(expr, _)| Edit::replace(expr.span, new.clone()))
                    .collect();
                match edits.is_empty() {
                    true => Err(format!("no guard compares `{variable}` with {old}")),
                    false => Ok(edits),
                }
            }
            Self::Begin { variable, new } => {
                let mut all = declared(read);
                let init = all
                    .find(|it| it.name.text == *variable)
                    .and_then(|it| it.init.as_ref());
                let init = init.ok_or("the model says no beginning of it")?;
                Ok(vec![Edit::replace(init.span, new.clone())])
            }
            Self::Outcome {
                command,
                update,
                to,
                ..
            } => {
                let all = commands(&read.tree);
                let command = all.get(*command).ok_or("the model has no such command")?;
                let update = command
                    .updates
                    .get(*update)
                    .ok_or("the command has no such update")?;
                Ok(vec![edit::with_outcome(read.text, update, to)])
            }
            Self::Again { .. } => self.again(read),
        }
    }

    /// The command as it is where the end is reached, and before it one that counts.
    fn again(&self, read: &Read<'_>) -> Result<Vec<Edit>, Refusal> {
        let Self::Again {
            command,
            update,
            variable,
            most,
            to,
        } = self
        else {
            return Err("it counts nothing".into());
        };
        let all = commands(&read.tree);
        let command = all.get(*command).ok_or("the model has no such command")?;
        let update = command
            .updates
            .get(*update)
            .ok_or("the command has no such update")?;
        let guard = &read.text[command.guard.span.start..command.guard.span.end];
        let (before, at_end, counted) = match most {
            Some(most) => (
                format!("({guard}) & {variable}<{most}"),
                format!("({guard}) & {variable}={most}"),
                format!("({variable}'={variable}+1)"),
            ),
            None => (
                format!("({guard}) & !{variable}"),
                format!("({guard}) & {variable}"),
                format!("({variable}'=true)"),
            ),
        };
        let does = match to.as_str() {
            "true" => counted,
            to => format!("{to} & {counted}"),
        };
        let counting = [
            Edit::replace(command.guard.span, before),
            edit::with_outcome(read.text, update, &does),
        ];
        let ending = [Edit::replace(command.guard.span, at_end)];
        let span = command.span;
        let written = |edits: &[Edit]| {
            let mut text = String::new();
            let mut at = span.start;
            for edit in edits {
                text.push_str(&read.text[at..edit.span.start]);
                text.push_str(&edit.text);
                at = edit.span.end;
            }
            text.push_str(&read.text[at..span.end]);
            text.trim_end_matches(';').to_owned()
        };
        let end = if read.text[..span.end].ends_with(';') {
            ";"
        } else {
            ""
        };
        let both = format!("{};\n  {}{end}", written(&counting), written(&ending));
        Ok(vec![Edit::replace(span, both)])
    }

    fn make(&self, read: &Read<'_>) -> Result<String, Refusal> {
        edit::apply(read.text, &self.edits(read)?).map_err(|e| e.to_string())
    }
}

impl Ground<'_> {
    /// Puts changes that lead to values which a model declares or asks for before the other ones, where nothing weighs more.
    pub(crate) fn of_idle(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let Ok(read) = Read::new(model.text) else {
            return;
        };
        if self.in_conflict(own, before).is_empty() {
            return;
        }
        let most = model.affordable(MOST_CHANGES, 1);
        let made = changes(&read)
            .into_iter()
            .take(most)
            .filter_map(|(kind, change)| {
                let text = change.make(&read).ok()?;
                let values = model.solver.values(&text).ok()?;
                Some(Tried {
                    change: (change, text),
                    kind,
                    values,
                })
            });
        // That the text says the value speaks for it, whatever the number of places.
        let explaining = self.explaining_above(f64::NEG_INFINITY, own, before, made.collect());
        self.put_first((model, own), before, explaining, found);
    }
}

impl Rewriting for Idle {
    fn in_words(&self, text: &str) -> String {
        self.words(text)
    }

    fn line(&self, text: &str) -> Option<u32> {
        Self::line(self, text)
    }

    fn note(&self, others: usize) -> String {
        let hint = self.hint();
        format!(
            "No number was fitted for it: {hint}. {}.",
            others_tried(others)
        )
    }

    fn offered(self, subject: Subject, counts: Counts, tried: usize) -> ModelChange {
        ModelChange::Idle {
            subject,
            change: self,
            counts,
            tried,
        }
    }
}

pub(crate) fn others_tried(count: usize) -> String {
    match count {
        0 => "No other change of the kind moves what is answered".to_owned(),
        1 => "One other change of the kind was tried that moves what is answered".to_owned(),
        count => {
            format!("{count} other changes of the kind were tried that move what is answered")
        }
    }
}

/// The model with the change, solved.
pub(crate) fn with(text: &str, solver: &dyn Solver, change: &Idle) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let new = change.make(&read)?;
    Changed::rewritten(new, change.words(text), solver)
}

/// What a guard of the model asks for that no update leads to, with the guard's line, from 1: what is never taken.
#[must_use]
pub fn never_taken(text: &str) -> Option<(String, u32)> {
    let read = Read::new(text).ok()?;
    let asked = asked_in_vain(&read).into_iter().next()?;
    let all = commands(&read.tree);
    let named = |command: &&&Command| {
        let all = draws::named_in_guard(command, &read.tree.formulas);
        all.iter()
            .any(|(variable, expr)| *variable == asked.variable && expr.to_string() == asked.value)
    };
    let command = all.iter().find(named)?;
    let (line, _) = prism_lang::line_and_column(text, command.span.start);
    Some((asked.meaning, u32::try_from(line).ok()?))
}

#[cfg(test)]
mod tests;
