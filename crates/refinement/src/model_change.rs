//! Changes of a formal model: a rate set to counts, a failure branch put in, a
//! draw that is made once.
//!
//! # Definition
//! * *Rate*: the updates that make the failure's proposition true have a
//!   constant as their probability. It becomes the share that was counted. Where
//!   the probability is an expression of several constants, such as
//!   `(1-again)*slips`, each is tried as the share and as one minus it, and of
//!   those with which the solved model has the counted rate that one is taken
//!   with which all other answers change least.
//! * *Solve*: where no constant, set to the share, gives the counted rate, since it acts more than once in a run or
//!   shares its expression with others, the constant is solved for ([`crate::solve`]); likewise a number that is written
//!   into a command ([`Number`]). Of several constants with which
//!   the model would have the rate, the one is taken whose log-odds change least; the others are named. Where the
//!   updates that make the proposition true are certain (the last of so many attempts has failed), the chance lies in
//!   what leads there: every constant of the model is tried, and the one is taken that leaves least disagreement with
//!   all evidence.
//! * *Branch*: the proposition is `variable=value` and no command gives the variable this value. If the model has no such
//!   value, the variable gets one more of this name. A command of
//!   its module that assigns it gets an update that sets it, with the share that
//!   was counted as its probability; all its other probabilities are multiplied
//!   by the rest. Tried are the commands whose guard asks for what the
//!   opportunity's proposition says; if there are none, those that leave the
//!   variable's initial value, then the others, in the order of the text. Where
//!   no command as a whole gives the counted rate, one of its updates is divided
//!   instead, so that what is tried again is not counted again. A state that a requirement names and nothing leads to gets its branch
//!   likewise ([`crate::unreached`]).
//! * *Branchless*: a branch of a command is taken out, and its probability goes to another one ([`crate::branches`]).
//! * *Split*: a branch is put in for which a constant was written that nothing uses ([`crate::unused`]).
//! * *Idle*: what leads to a value that the model declares or asks for and never comes to ([`crate::idle`]).
//! * *Slip*: a slip of the text that nothing in it shows ([`crate::slips`]).
//! * *Once*: if the constant has the counted share and the model's rate for the
//!   failure differs all the same, the model draws more than once where the
//!   counts have one opportunity. The commands are taken once.
//!
//! # Assumes
//! One change is enough: all else of the model is right. The share that was counted is taken for the rate.
//!
//! # Guarantee
//! A branch, a constant of an expression and a draw made once are solved, and only offered if the model's
//! rate then is the wanted one to within [`NEAR`] of it: a command that is taken
//! several times in a run, or not in all, does not pass. (Exactly equal it need not
//! be: a run may time out first.) A rate is offered with the value that it gives,
//! which may differ.

mod branching;
mod solving;

pub(crate) use branching::{number_in_words, solve_branch};
pub(crate) use solving::{
    AS_GOOD, FARTHEST, digits, once_or_solve, rate_or_solve, solved, with_interval,
};

use crate::branches::{self, Branch};
use crate::counts::Counts;
use crate::draws::{Draw, Equality, draws, equalities, names_of};
use crate::idle::{self, Idle};
use crate::number::Number;
use crate::slips::{self, Slip};
use crate::solve::Scale;
use crate::structure::FREE_VALUE;
use crate::unreached::{self, Place};
use crate::unused::{self, Split};
use evidence::Subject;
use prism_lang::ast::{ExprKind, Model};
use prism_lang::{Constants, Value, edit, resolved};
use std::collections::BTreeMap;

/// The answers to a study's questions; `None` where the model cannot be asked.
pub type Values = BTreeMap<Subject, Option<f64>>;

/// Solves texts of one model.
pub trait Solver {
    /// What a text of the model answers.
    ///
    /// # Errors
    /// Why it cannot be solved, in words.
    fn values(&self, text: &str) -> Result<Values, String>;
}

/// Relative difference up to which a solved rate is the wanted one.
pub const SAME: f64 = 1e-6;

/// Relative difference up to which a draw counts as made once.
pub const NEAR: f64 = 0.05;

/// What is to be changed in a model, whatever its text is by then.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelChange {
    /// Set the constant that decides how often the proposition becomes true.
    Rate {
        /// The failure mode.
        mode: String,
        /// Its proposition over the model's variables.
        occurs: String,
        /// What was counted.
        counts: Counts,
    },
    /// Solve for the constant with which the model's rate is the counted one.
    Solve {
        /// The failure mode or requirement.
        subject: Subject,
        /// The constant, or the number in a command.
        number: Number,
        /// What was counted.
        counts: Counts,
    },
    /// Put in what the model does not know: a failure, or a state that a requirement names.
    Branch {
        /// The failure mode or requirement.
        subject: Subject,
        /// What can happen then, in one word of the study.
        name: String,
        /// Its proposition, with a value that no update gives the variable.
        occurs: String,
        /// The proposition of its opportunity.
        after: Option<String>,
        /// Where it is put in, its probability solved for; else where the counted share gives the rate.
        at: Option<Place>,
        /// What was counted.
        counts: Counts,
    },
    /// Take out a branch of a command.
    Branchless {
        /// The failure mode or requirement that it explains.
        subject: Subject,
        /// The branch.
        branch: Branch,
        /// What was counted.
        counts: Counts,
        /// Of how many such changes that move a value.
        tried: usize,
    },
    /// Put in the branch that a constant was written for.
    Split {
        /// The failure mode or requirement that it explains.
        subject: Subject,
        /// The branch.
        split: Split,
        /// What was counted.
        counts: Counts,
        /// Of how many such changes that move a value.
        tried: usize,
    },
    /// Lead to a value that the model declares or asks for, and never comes to.
    Idle {
        /// The failure mode or requirement that it explains.
        subject: Subject,
        /// What is changed.
        change: Idle,
        /// What was counted.
        counts: Counts,
        /// Of how many such changes that move a value.
        tried: usize,
    },
    /// Take back a slip of the text.
    Slip {
        /// The failure mode or requirement that it explains.
        subject: Subject,
        /// The slip.
        change: Slip,
        /// What was counted.
        counts: Counts,
        /// Of how many such changes that move a value.
        tried: usize,
    },
    /// Take the commands that decide the proposition once.
    Once {
        /// The failure mode.
        mode: String,
        /// Its proposition.
        occurs: String,
        /// What was counted.
        counts: Counts,
    },
}

/// A model's text after a change.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// The text.
    pub text: String,
    /// What was done, in one clause.
    pub what: String,
    /// The constant that now has a counted value.
    pub constant: Option<SetConstant>,
    /// What the changed model answers.
    pub values: Values,
    /// What has to be known of it, one sentence each.
    pub notes: Vec<String>,
    /// Other changes that the evidence does not tell apart from this one.
    pub alternatives: Vec<Alternative>,
    /// What the model answers once the next change is made, too, that belongs to it: a constant was set to the share of
    /// a draw that is then made once.
    pub settled: Option<Values>,
}

/// Another change that does as much.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// The number by its name, or what is done.
    pub name: String,
    /// The line of the model's text, from 1.
    pub line: Option<u32>,
}

impl Alternative {
    pub(crate) fn of_number(number: &Number, text: &str) -> Self {
        Self {
            name: number.name().to_owned(),
            line: number.line(text),
        }
    }
}

impl Changed {
    /// A model rewritten to another text, in which no number was fitted, solved.
    pub(crate) fn rewritten(
        text: String,
        what: String,
        solver: &dyn Solver,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            what,
            values: solver.values(&text)?,
            text,
            constant: None,
            notes: Vec::new(),
            alternatives: Vec::new(),
            settled: None,
        })
    }

    /// What the model answers when all is made that belongs to the change.
    #[must_use]
    pub fn at_last(&self) -> &Values {
        self.settled.as_ref().unwrap_or(&self.values)
    }
}

/// A constant that was set to a counted rate.
#[derive(Clone, Debug, PartialEq)]
pub struct SetConstant {
    /// Its name.
    pub name: String,
    /// Whether it is the probability that what was counted does *not* happen: 1 minus the rate.
    pub is_complement: bool,
    /// Whether it was solved for: it is not the counted share, but the model then has the counted rate.
    pub is_solved: bool,
    /// The value, if it was solved for.
    pub value: Option<f64>,
}

/// Why a change is not possible, in one sentence.
pub type Refusal = String;

/// A model's text with what was read of it.
pub(crate) struct Read<'a> {
    pub(crate) text: &'a str,
    pub(crate) tree: Model,
    pub(crate) model: resolved::Model,
}

impl<'a> Read<'a> {
    pub(crate) fn new(text: &'a str) -> Result<Self, Refusal> {
        let words = |found: &[prism_lang::Diagnostic]| {
            let all: Vec<&str> = found.iter().map(|d| d.message.as_str()).collect();
            all.join("; ")
        };
        let tree = prism_lang::parse_model(text)
            .into_result()
            .map_err(|found| words(&found))?;
        let model = prism_lang::resolve(&tree, &Constants::new()).map_err(|found| words(&found))?;
        Ok(Self { text, tree, model })
    }

    pub(crate) fn constant(&self, name: &str) -> Option<f64> {
        match self.model.constant(name)? {
            Value::Double(number) => Some(number.to_f64()),
            Value::Int(value) => Some(*value as f64),
            Value::Bool(_) => None,
        }
    }

    pub(crate) fn equalities(&self, text: &str) -> Result<Vec<Equality>, Refusal> {
        equalities(text, &self.tree.formulas)
            .ok_or_else(|| format!("`{text}` must be a conjunction of `variable=value`"))
    }

    /// The constants that can be probabilities between 0 and 1, in the order of the text.
    pub(crate) fn chances(&self) -> Vec<String> {
        let names = self.tree.constants.iter().map(|it| it.name.text.clone());
        let is_chance = |name: &String| {
            matches!(self.model.constant(name), Some(Value::Double(_)))
                && self.constant(name).is_some_and(|it| it > 0.0 && it < 1.0)
        };
        names.filter(is_chance).collect()
    }

    /// Whether some command makes a proposition true, as far as it can be read.
    pub(crate) fn comes_to(&self, occurs: &str) -> bool {
        self.equalities(occurs).is_err() || self.draws(occurs).is_ok()
    }

    fn draws(&self, occurs: &str) -> Result<Vec<Draw<'_>>, Refusal> {
        let wanted = self.equalities(occurs)?;
        let found = draws(&self.tree, &self.model, &wanted);
        match found.is_empty() {
            true => Err(format!("no command makes `{occurs}` true")),
            false => Ok(found),
        }
    }
}

/// The constant that decides how often a proposition becomes true, and its value.
///
/// # Errors
/// Why there is no such constant: the probability is certain, no constant, an expression of several, or
/// different for each of the updates.
fn deciding_constant(text: &str, occurs: &str) -> Result<(String, f64), Refusal> {
    let read = Read::new(text)?;
    match deciding(&read, occurs)? {
        Deciding::Constant(name) => read
            .constant(&name)
            .map(|value| (name.clone(), value))
            .ok_or_else(|| format!("`{name}` is not a constant with a value")),
        Deciding::Expression(names) => Err(match names.as_slice() {
            [] => "its probability is not a constant of the model".into(),
            several => format!("{} decide it together", several.join(", ")),
        }),
        Deciding::Certain => Err(CERTAIN.into()),
    }
}

/// Why there is no constant to be set.
const CERTAIN: &str = "the model has no chance there: it is certain";

/// What decides how often a proposition becomes true.
enum Deciding {
    /// The probability of each update is this constant.
    Constant(String),
    /// Expressions of these constants.
    Expression(Vec<String>),
    /// No chance is left there: what leads there decides.
    Certain,
}

fn deciding(read: &Read, occurs: &str) -> Result<Deciding, Refusal> {
    let draws = read.draws(occurs)?;
    let mut names: Vec<String> = Vec::new();
    let mut is_plain = true;
    for draw in &draws {
        let Some(probability) = draw.update.probability.as_ref() else {
            return Ok(Deciding::Certain);
        };
        is_plain &= matches!(probability.kind, ExprKind::Name(_));
        let mut found = Vec::new();
        names_of(probability, &mut found);
        for name in found {
            let name = draw.body.renamed(name).to_owned();
            if !names.contains(&name) && read.constant(&name).is_some() {
                names.push(name);
            }
        }
    }
    Ok(match names.as_slice() {
        [only] if is_plain => Deciding::Constant(only.clone()),
        _ => Deciding::Expression(names),
    })
}

/// Whether some command makes a proposition true, as far as it can be read.
pub(crate) fn comes_to(text: &str, occurs: &str) -> bool {
    Read::new(text).is_ok_and(|read| read.comes_to(occurs))
}

/// Whether the constant that decides a proposition has the counted share already, so that only how often it is
/// drawn can be wrong.
///
/// # Errors
/// Why nothing decides it.
pub(crate) fn is_set_to(text: &str, occurs: &str, counts: &Counts) -> Result<bool, Refusal> {
    let read = Read::new(text)?;
    // What decides a proposition that is no conjunction of values is not read off the text.
    if read.equalities(occurs).is_err() {
        return Ok(false);
    }
    if let Deciding::Expression(_) | Deciding::Certain = deciding(&read, occurs)? {
        return Ok(false);
    }
    let (_, value) = deciding_constant(text, occurs)?;
    // Constants are written with a few digits; a rounding is no difference.
    Ok((value - counts.rate()).abs() <= 5e-4 * counts.rate().max(1e-3))
}

impl ModelChange {
    /// Whose rate is set: a failure mode or a requirement.
    #[must_use]
    pub fn subject(&self) -> Subject {
        match self {
            Self::Rate { mode, .. } | Self::Once { mode, .. } => Subject::FailureMode(mode.clone()),
            Self::Solve { subject, .. }
            | Self::Branch { subject, .. }
            | Self::Split { subject, .. }
            | Self::Idle { subject, .. }
            | Self::Slip { subject, .. }
            | Self::Branchless { subject, .. } => subject.clone(),
        }
    }

    /// The name of what [`Self::subject`] is.
    pub fn mode(&self) -> &str {
        match self {
            Self::Rate { mode, .. } | Self::Once { mode, .. } => mode,
            Self::Solve { subject, .. }
            | Self::Branch { subject, .. }
            | Self::Split { subject, .. }
            | Self::Idle { subject, .. }
            | Self::Slip { subject, .. }
            | Self::Branchless { subject, .. } => subject.id(),
        }
    }

    /// What was counted.
    pub fn counts(&self) -> &Counts {
        match self {
            Self::Rate { counts, .. }
            | Self::Solve { counts, .. }
            | Self::Branch { counts, .. }
            | Self::Branchless { counts, .. }
            | Self::Split { counts, .. }
            | Self::Idle { counts, .. }
            | Self::Slip { counts, .. }
            | Self::Once { counts, .. } => counts,
        }
    }

    /// The decades against it before the evidence: a number that is set to counts makes one rate agree whatever the truth is, a
    /// branch is one of those that were tried.
    #[must_use]
    pub fn cost(&self) -> f64 {
        match self {
            Self::Branchless { tried, .. }
            | Self::Split { tried, .. }
            | Self::Idle { tried, .. }
            | Self::Slip { tried, .. } => ((*tried).max(1) as f64).log10(),
            Self::Rate { .. } | Self::Solve { .. } | Self::Branch { .. } | Self::Once { .. } => {
                FREE_VALUE
            }
        }
    }

    /// Whether what is lacking is put in where nothing else explains more: which place it has is for who knows the system.
    #[must_use]
    pub fn is_of_lacking_branch(&self) -> bool {
        match self {
            Self::Branch { at, .. } => at.is_some(),
            Self::Split { .. } | Self::Idle { .. } => true,
            Self::Rate { .. }
            | Self::Solve { .. }
            | Self::Branchless { .. }
            | Self::Slip { .. }
            | Self::Once { .. } => false,
        }
    }

    /// Makes the change and solves the result.
    ///
    /// # Errors
    /// Why it cannot be made, in one sentence.
    pub fn make(&self, text: &str, solver: &dyn Solver) -> Result<Changed, Refusal> {
        match self {
            Self::Rate {
                mode,
                occurs,
                counts,
            } => rate(text, solver, occurs, (mode, counts)),
            Self::Solve {
                subject,
                number,
                counts,
            } => {
                let names = std::slice::from_ref(number);
                let mut found = solved(text, solver, names, (subject, counts))?;
                let made = (self.clone(), found.swap_remove(0).changed);
                Ok(with_interval(text, solver, made).1)
            }
            Self::Once { mode, occurs, .. } => once(text, solver, mode, occurs),
            Self::Branch {
                at: Some(place), ..
            } => unreached::at_place(text, solver, self, *place),
            Self::Branch { .. } => self.branch(text, solver),
            Self::Branchless { branch, .. } => branches::without(text, solver, branch),
            Self::Split { split, .. } => unused::with(text, solver, split),
            Self::Idle { change, .. } => idle::with(text, solver, change),
            Self::Slip { change, .. } => slips::with(text, solver, change),
        }
    }
}

/// The value of a failure mode.
pub fn rate_of(values: &Values, mode: &str) -> Option<f64> {
    value_of(values, &Subject::FailureMode(mode.to_owned()))
}

/// The value of a failure mode or a requirement.
pub(crate) fn value_of(values: &Values, subject: &Subject) -> Option<f64> {
    values.get(subject).copied().flatten()
}

fn rate(
    text: &str,
    solver: &dyn Solver,
    occurs: &str,
    (mode, counts): (&str, &Counts),
) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let names = match deciding(&read, occurs)? {
        Deciding::Constant(name) => return set(&read, solver, &name, false, counts),
        Deciding::Expression(names) => names,
        Deciding::Certain => return Err(CERTAIN.into()),
    };
    // Of several constants in one expression, it is the one with which the model has the counted rate, and with which
    // all else changes least: a constant that keeps the opportunity from coming, or the run from ending, can give
    // a rate, too.
    let before = solver.values(text)?;
    let mut best: Option<(f64, Changed)> = None;
    for is_complement in [false, true] {
        for name in &names {
            // That a constant is 1 minus the share is only meant where it is nearer to that.
            let share = counts.rate();
            let is_meant = read.constant(name).is_none_or(|now| {
                let [own, other] = [share, 1.0 - share].map(|it| Scale::Odds.distance(now, it));
                !is_complement || other <= own
            });
            if !is_meant {
                continue;
            }
            let Ok(changed) = set(&read, solver, name, is_complement, counts) else {
                continue;
            };
            let rate = rate_of(&changed.values, mode);
            let near = NEAR * counts.rate().max(SAME);
            if !rate.is_some_and(|rate| (rate - counts.rate()).abs() <= near) {
                continue;
            }
            let moved = moved(&before, &changed.values, mode);
            if best.as_ref().is_none_or(|(least, _)| moved < *least) {
                best = Some((moved, changed));
            }
        }
    }
    if let Some((_, changed)) = best {
        return Ok(changed);
    }
    Err(match names.as_slice() {
        [] => "its probability has no constant of the model".into(),
        several => format!(
            "none of {}, set to the counted share, gives the counted rate",
            several.join(", ")
        ),
    })
}

/// How far the values of all but a failure mode moved at most; a value that is lost moved by 1.
fn moved(before: &Values, after: &Values, mode: &str) -> f64 {
    let own = Subject::FailureMode(mode.to_owned());
    let others = before.iter().filter(|(subject, _)| **subject != own);
    let distances = others.filter_map(|(subject, before)| {
        let before = (*before)?;
        let after = after.get(subject).copied().flatten();
        Some(after.map_or(1.0, |after| (after - before).abs()))
    });
    distances.fold(0.0, f64::max)
}

/// The model with a constant set to the counted share, or to what remains of 1, solved.
fn set(
    read: &Read,
    solver: &dyn Solver,
    name: &str,
    is_complement: bool,
    counts: &Counts,
) -> Result<Changed, Refusal> {
    let (value, words) = match is_complement {
        false => (counts.fraction(), counts.words()),
        true => (
            format!("1-{}", counts.fraction()),
            format!("1 minus {}", counts.words()),
        ),
    };
    let edits = edit::set_constant(&read.tree, name, &value).map_err(|e| e.to_string())?;
    let text = edit::apply(read.text, &edits).map_err(|e| e.to_string())?;
    let values = solver.values(&text)?;
    Ok(Changed {
        text,
        what: format!("{name} set to {words}"),
        constant: Some(SetConstant {
            name: name.to_owned(),
            is_complement,
            is_solved: false,
            value: None,
        }),
        values,
        notes: Vec::new(),
        alternatives: Vec::new(),
        settled: None,
    })
}

fn once(text: &str, solver: &dyn Solver, mode: &str, occurs: &str) -> Result<Changed, Refusal> {
    let (_, value) = deciding_constant(text, occurs)?;
    let read = Read::new(text)?;
    let draws = read.draws(occurs)?;
    let variable = draws.first().map(|d| d.variable).unwrap_or_default();
    if draws.iter().any(|draw| draw.variable != variable) {
        return Err("several variables decide it".into());
    }
    let edits = edit::draw_once(text, &read.tree, variable).map_err(|e| e.to_string())?;
    let text = edit::apply(text, &edits).map_err(|e| e.to_string())?;
    let values = solver.values(&text)?;
    match rate_of(&values, mode) {
        Some(rate) if (rate - value).abs() <= NEAR * value.max(SAME) => Ok(Changed {
            text,
            what: format!("{variable} is drawn once in a run, as it was counted"),
            constant: None,
            values,
            notes: Vec::new(),
            alternatives: Vec::new(),
            settled: None,
        }),
        rate => Err(format!(
            "drawn once, its rate would be {}, not the constant's {value}",
            rate.map_or_else(|| "unknown".to_owned(), |rate| rate.to_string())
        )),
    }
}
