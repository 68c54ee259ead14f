//! A slip of the pen in a model's text that nothing in the text shows: where nothing else explains what disagrees, each is tried.
//!
//! # Definition
//! One of these, everywhere else the text stays as it is:
//!
//! * *elsewhere*: an update does what another one of its module does, gives a variable a value that another one gives it, or leaves an
//!   assignment out;
//! * *whole number*: a constant of type `int` that is compared by order or counted with is one or two more or less;
//! * *digits*: a constant that may be a probability is one minus what is written, and a constant of type `double` ten times or a tenth of it;
//! * *beginning*: a variable of at most [`MOST_VALUES`] values begins with another one;
//! * *bound*: a number that guards compare a variable with in several places is one more or less in all of them, so that what
//!   two commands share between them stays shared;
//! * *guard*: in one guard or formula a comparison leaves out or takes in equality, is turned around or denied, its whole number is one
//!   more or less (one that is added to what the variable is compared with also two) or what the variable is compared with elsewhere, a Boolean variable is denied or not, `&` is `|` or the other way
//!   round, in one place or throughout a chain of operands;
//! * *far*: a whole number of one of these kinds (a constant, a beginning of a counter with many values, what a comparison by order asks
//!   for) is another one, up to eight away: what is solved for, where a number has no digits behind its point;
//! * *exchange*: two commands of a module, at most [`NEAR_BY`] apart, have each other's guards.
//!
//! Each is solved and tried on all evidence ([`crate::structure`]) where the model disagrees strongly with counts. It has to explain all,
//! and more than the number of such changes makes likely by chance. No number is fitted. It stands before the other changes where each
//! of these leaves something in strong disagreement, or where it explains several rates, no branch is enough, and every number that is
//! solved for explains less even if it costs [`CHANCE`] decades alone; else behind them, where it explains less by at most [`BEHIND`]
//! decades. (One rate is given by some slip or other nearly always, and a number that is solved for is right to within the counts
//! whether the wrong one was a slip of digits or any other.)
//!
//! # Assumes
//! That one place is wrong. All kinds are equally likely before, and so are all changes of one kind.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843) over the usual mutations of a text (R. A. DeMillo, R. J. Lipton, F. G. Sayward, "Hints on
//! test data selection", 1978: programs that are nearly right differ from right ones by little). What is offered was solved. Several
//! places may give the same rates; each says so. A guard that then overlaps with another one, or leaves a state without a way
//! out, is judged by its values alone.
//!
//! # Cost
//! One solution for each; at most [`MOST_CHANGES`] in all, of a large model fewer, so that states times solutions stay below
//! [`crate::model_offers::MOST_WORK`].

mod candidates;

use crate::counts::Counts;
use crate::idle::{declared, others_tried};
use crate::model_change::{Changed, ModelChange, Read, Refusal, Solver, Values, value_of};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use crate::structure::{FREE_VALUE, Rewriting, Tried};
use crate::trial::SAME_VALUE;
use candidates::{bounds, places, slips};
use evidence::{STRONG, Subject};
use prism_lang::Span;
use prism_lang::ast::Command;
use prism_lang::edit::{self, Edit};

/// Changes that are tried, at most.
const MOST_CHANGES: usize = 800;

/// How far two commands stand apart that may have each other's guards.
const NEAR_BY: usize = 2;

/// Values of a variable that may begin otherwise, at most.
const MOST_VALUES: i64 = 12;

/// Decades that a number which is solved for costs beside slips: the share of all values that agree as well with the counts is about a
/// tenth. (What it costs beside changes of structure, [`FREE_VALUE`], is a guess that spares numbers less.)
const CHANCE: f64 = 1.0;

/// Decades by which a slip may explain less than a number and is offered behind it.
const BEHIND: f64 = 1.5;

/// One slip that is taken back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Slip {
    /// What an update does, as other updates of its module do it.
    Elsewhere {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// Its update, counted from 0.
        update: usize,
        /// What the update does then.
        to: String,
    },
    /// The value of a constant of type `int`.
    Whole {
        /// The constant.
        constant: String,
        /// Its value.
        old: i64,
        /// Its value then.
        new: i64,
    },
    /// The value of a constant of type `double`.
    Digits {
        /// The constant.
        constant: String,
        /// Its value as it is written.
        old: String,
        /// What is written then.
        new: String,
    },
    /// The first value of a counter or of a Boolean variable.
    Begin {
        /// The variable.
        variable: String,
        /// Its value then.
        new: String,
    },
    /// A number that several guards compare a variable with.
    Bound {
        /// The variable.
        variable: String,
        /// The number.
        old: i64,
        /// The number then.
        new: i64,
    },
    /// A part of one guard or formula.
    Guard {
        /// The part, counted from 0 over all parts of guards and formulas.
        place: usize,
        /// As it is written.
        old: String,
        /// What is written then.
        new: String,
    },
    /// Guards of two commands that change places.
    Exchange {
        /// The commands, counted from 0 over all modules.
        commands: [usize; 2],
    },
}

impl Slip {
    /// The first line of a model's text that it changes, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let read = Read::new(text).ok()?;
        let edits = self.edits(&read).ok()?;
        let first = edits.iter().map(|it| it.span.start).min()?;
        let (line, _) = prism_lang::line_and_column(text, first);
        u32::try_from(line).ok()
    }

    /// What of the text is changed, in few words.
    #[must_use]
    pub fn part(&self) -> String {
        match self {
            Self::Elsewhere { to, .. } => format!("an update to {to}"),
            Self::Whole { constant, .. } | Self::Digits { constant, .. } => constant.clone(),
            Self::Begin { variable, .. } => format!("init of {variable}"),
            Self::Bound { variable, old, .. } => format!("{old} of {variable}"),
            Self::Guard { old, .. } => old.clone(),
            Self::Exchange { .. } => "guards of two commands".to_owned(),
        }
    }

    /// What is supposed to be wrong, as a clause.
    #[must_use]
    pub fn supposed(&self) -> &'static str {
        match self {
            Self::Elsewhere { .. } => "one update leads elsewhere",
            Self::Whole { .. } => "one whole number is another",
            Self::Digits { .. } => "one number was written otherwise",
            Self::Begin { .. } => "one variable begins with another value",
            Self::Bound { .. } => "one number of the guards is another",
            Self::Guard { .. } => "one part of a guard is written otherwise",
            Self::Exchange { .. } => "two commands have each other's guards",
        }
    }

    fn words(&self, text: &str) -> String {
        let line = self.line(text).unwrap_or_default();
        match self {
            Self::Elsewhere { to, .. } => format!("`{to}` as what an update of line {line} does"),
            Self::Whole { constant, old, new } => {
                format!("`{constant}` is {new} in place of {old}, in line {line}")
            }
            Self::Digits { constant, old, new } => {
                format!("`{constant}` is {new} in place of {old}, in line {line}")
            }
            Self::Begin { variable, new } => {
                format!("`{variable}` begins with {new}, in line {line}")
            }
            Self::Bound { variable, old, new } => format!(
                "{new} in place of {old} where guards compare `{variable}`, from line {line} on"
            ),
            Self::Guard { old, new, .. } => {
                format!("`{new}` in place of `{old}` in line {line}")
            }
            Self::Exchange { .. } => {
                format!("the guard of line {line} and that of a command near by change places")
            }
        }
    }

    fn edits(&self, read: &Read<'_>) -> Result<Vec<Edit>, Refusal> {
        match self {
            Self::Elsewhere {
                command,
                update,
                to,
            } => {
                let all = commands(&read.tree);
                let update = command_of(&all, *command)?
                    .updates
                    .get(*update)
                    .ok_or("the command has no such update")?;
                Ok(vec![edit::with_outcome(read.text, update, to)])
            }
            Self::Whole { constant, new, .. } => {
                edit::set_constant(&read.tree, constant, &new.to_string())
                    .map_err(|e| e.to_string())
            }
            Self::Digits { constant, new, .. } => {
                edit::set_constant(&read.tree, constant, new).map_err(|e| e.to_string())
            }
            Self::Begin { variable, new } => {
                let mut all = declared(read);
                let init = all
                    .find(|it| it.name.text == *variable)
                    .and_then(|it| it.init.as_ref());
                let init = init.ok_or("the model says no beginning of it")?;
                Ok(vec![Edit::replace(init.span, new.clone())])
            }
            Self::Bound { variable, old, new } => {
                let all = bounds(read);
                let own = all
                    .iter()
                    .filter(|it| it.variable == *variable && it.value == *old);
                let edits: Vec<Edit> = own
                    .map(|it| Edit::replace(it.span, new.to_string()))
                    .collect();
                match edits.is_empty() {
                    true => Err(format!("no guard compares `{variable}` with {old}")),
                    false => Ok(edits),
                }
            }
            Self::Guard { place, old, new } => {
                let all = places(read);
                let part = all.get(*place).ok_or("the model has no such part")?;
                match read.text[part.whole.start..part.whole.end] == **old {
                    true => Ok(vec![Edit::replace(part.whole, new.clone())]),
                    false => Err(format!("the model has no `{old}` there")),
                }
            }
            Self::Exchange {
                commands: [first, second],
            } => {
                let all = commands(&read.tree);
                let first = command_of(&all, *first)?.guard.span;
                let second = command_of(&all, *second)?.guard.span;
                let written = |span: Span| read.text[span.start..span.end].to_owned();
                Ok(vec![
                    Edit::replace(first, written(second)),
                    Edit::replace(second, written(first)),
                ])
            }
        }
    }

    fn make(&self, read: &Read<'_>) -> Result<String, Refusal> {
        edit::apply(read.text, &self.edits(read)?).map_err(|e| e.to_string())
    }
}

fn command_of<'a>(all: &[&'a Command], place: usize) -> Result<&'a Command, Refusal> {
    Ok(*all.get(place).ok_or("the model has no such command")?)
}

impl Ground<'_> {
    /// Puts slips that explain what disagrees first, where nothing that was found before is enough.
    pub(crate) fn of_slips(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let Ok(read) = Read::new(model.text) else {
            return;
        };
        let explains_all = |values: &Values| {
            let left = self.most_disagreement(&own.id, values);
            left.is_none_or(|(_, left)| left <= STRONG)
        };
        if self.in_conflict(own, before).is_empty() {
            return;
        }
        let most = model.affordable(MOST_CHANGES, 1);
        let made = slips(&read).into_iter().take(most);
        let tried = made.filter_map(|(kind, change)| {
            let text = change.make(&read).ok()?;
            let values = model.solver.values(&text).ok()?;
            Some(Tried {
                change: (change, text),
                kind,
                values,
            })
        });
        // One that explains more of what it explains, and leaves another thing, does not stand before those that leave nothing.
        let mut explaining =
            self.explaining_where(explains_all, STRONG, (own, before), tried.collect());
        let Some(best) = explaining.first().map(|it| it.weight) else {
            return;
        };
        let is_enough = |changed: &Changed| {
            let trial = self.tried(&own.id, before, changed.at_last());
            !trial.is_harmful() && !trial.repairs.is_empty() && explains_all(changed.at_last())
        };
        let enough = found.changes.iter().filter(|it| is_enough(&it.1));
        let enough: Vec<&(ModelChange, Changed)> = enough.collect();
        // What gives the same values is the same change in other words.
        let is_known = |values: &Values| {
            let mut all = found.changes.iter();
            all.any(|(_, it)| are_same(it.at_last(), values))
        };
        explaining.retain(|it| !is_known(&it.values));
        let is_structural = enough.iter().any(|(change, _)| {
            let is_branch = matches!(
                change,
                ModelChange::Branchless { .. } | ModelChange::Split { .. }
            );
            is_branch || change.is_of_lacking_branch()
        });
        let is_checked = explaining.iter().all(|it| it.subjects.len() > 1);
        // As if they cost less.
        let most = self.heaviest(own, before, enough.iter().map(|it| &it.1)) + FREE_VALUE - CHANCE;
        if enough.is_empty() || is_checked && !is_structural && best >= most {
            self.put_first((model, own), before, explaining, found);
        } else if best >= most - BEHIND {
            self.put_last((model, own), explaining, found);
        }
    }
}

impl Rewriting for Slip {
    fn in_words(&self, text: &str) -> String {
        self.words(text)
    }

    fn line(&self, text: &str) -> Option<u32> {
        Self::line(self, text)
    }

    fn note(&self, others: usize) -> String {
        format!(
            "No number was fitted for it: {}. Nothing in the text says so, but that it explains all that disagrees. {}.",
            self.supposed(),
            others_tried(others)
        )
    }

    fn offered(self, subject: Subject, counts: Counts, tried: usize) -> ModelChange {
        ModelChange::Slip {
            subject,
            change: self,
            counts,
            tried,
        }
    }
}

/// Whether two texts of a model answer the same.
fn are_same(one: &Values, other: &Values) -> bool {
    one.iter()
        .all(|(subject, value)| match (value, value_of(other, subject)) {
            (Some(a), Some(b)) => (a - b).abs() < SAME_VALUE,
            (a, b) => a.is_none() && b.is_none(),
        })
}

/// The model with the change, solved.
pub(crate) fn with(text: &str, solver: &dyn Solver, change: &Slip) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let new = change.make(&read)?;
    Changed::rewritten(new, change.words(text), solver)
}

#[cfg(test)]
mod tests;
