//! A failure that a model does not know gets a branch ([`ModelChange::Branch`]).
//!
//! # Definition
//! Commands are tried in the order of [`super`]'s definition: with the branch as one more update, then with one of their
//! updates divided; where none of these gives the counted rate, the probability of the branch is solved for.
//!
//! # Assumes
//! One failure is missing, and comes from one command. The share that was counted is taken for its rate.
//!
//! # Guarantee
//! The changed model gives the counted rate when it is solved. That the branch is where the system has it is not shown.

use super::{
    Alternative, Changed, ModelChange, NEAR, Read, Refusal, SetConstant, Solver, Values,
    solving::{FARTHEST, digits, rate_with},
    value_of as answer_of,
};
use crate::counts::Counts;
use crate::draws::{Equality, of_guard, value_of};
use crate::number::Number;
use crate::solve::{self, Scale};
use evidence::Subject;
use prism_lang::ast::{Command, Expr, ExprKind, Model, ModuleBody, Update};
use prism_lang::edit;
use prism_lang::resolved::ModelType;

impl ModelChange {
    pub(super) fn branch(&self, text: &str, solver: &dyn Solver) -> Result<Changed, Refusal> {
        let Self::Branch {
            subject,
            name,
            occurs,
            after,
            counts,
            ..
        } = self
        else {
            return Err("it is not a branch".into());
        };
        let read = Read::new(text)?;
        let candidates = candidates(&read, occurs, after.as_deref())?;
        let places = candidates.iter().map(|command| (*command, None));
        let updates = candidates.iter().flat_map(|command| {
            let all = command.updates.iter();
            all.map(|update| (*command, Some(update)))
        });
        for (command, update) in places.chain(updates) {
            let share = (counts.fraction(), format!("{name}: {}", counts.words()));
            let branched = with_branch(&read, (command, update), (name, occurs), &share)?;
            let Ok(values) = solver.values(&branched.text) else {
                continue;
            };
            let rate = answer_of(&values, subject);
            if rate.is_some_and(|rate| (rate - counts.rate()).abs() <= NEAR * counts.rate()) {
                let (line, _) = prism_lang::line_and_column(text, command.span.start);
                return Ok(Changed {
                    text: branched.text,
                    what: format!(
                        "{} can happen, with {} {} (line {line})",
                        name.replace('_', " "),
                        number_in_words(&read, update),
                        counts.fraction()
                    ),
                    constant: Some(SetConstant {
                        name: branched.constant,
                        is_complement: false,
                        is_solved: false,
                        value: None,
                    }),
                    values,
                    notes: Vec::new(),
                    alternatives: Vec::new(),
                    settled: None,
                });
            }
        }
        if let Some(changed) = self.solved_branch(&read, &candidates, solver) {
            return Ok(changed);
        }
        let line = |command: &&Command| {
            let (line, _) = prism_lang::line_and_column(text, command.span.start);
            line.to_string()
        };
        let tried: Vec<String> = candidates.iter().map(line).collect();
        Err(format!(
            "none of the commands in lines {} gives the counted rate",
            tried.join(", ")
        ))
    }
}

impl ModelChange {
    /// The first branch for which some probability gives the counted rate: its command is taken more than once in a run,
    /// or not in all.
    fn solved_branch(
        &self,
        read: &Read,
        candidates: &[&Command],
        solver: &dyn Solver,
    ) -> Option<Changed> {
        let Self::Branch {
            subject,
            name,
            occurs,
            counts,
            ..
        } = self
        else {
            return None;
        };
        let of = |command: &&Command| {
            let asked = (subject, name.as_str(), occurs.as_str(), counts);
            let solved = solve_branch(read, solver, (command, None), asked).ok()?;
            let (line, _) = prism_lang::line_and_column(read.text, command.span.start);
            let what = format!(
                "{} can happen, with {} {} each time, with which the share of runs is that of {}",
                name.replace('_', " "),
                number_in_words(read, None),
                digits(solved.value),
                counts.words()
            );
            Some((what, u32::try_from(line).ok(), solved))
        };
        let mut all = candidates.iter().filter_map(of);
        let (what, line, solved) = all.next()?;
        // Elsewhere it may as well be what is lacking.
        let alternatives: Vec<Alternative> = all
            .map(|(name, line, _)| Alternative { name, line })
            .collect();
        let notes = match alternatives.is_empty() {
            true => Vec::new(),
            false => vec![format!(
                "Put in line {}; {} other commands may have it in its place, which the counts of it do not tell apart.",
                line.unwrap_or_default(),
                alternatives.len()
            )],
        };
        Some(Changed {
            what,
            constant: Some(SetConstant {
                name: solved.constant,
                is_complement: false,
                is_solved: true,
                value: Some(solved.value),
            }),
            values: solved.values,
            text: solved.text,
            notes,
            alternatives,
            settled: None,
        })
    }
}

/// A model with a branch whose probability was solved for.
pub(crate) struct SolvedBranch {
    pub(crate) text: String,
    /// The constant that has the probability.
    pub(crate) constant: String,
    pub(crate) value: f64,
    pub(crate) values: Values,
}

/// The branch in a command, or in one of its updates, with which a subject has the counted rate: counts of a failure mode are
/// of what the branch leads to, those of a requirement of the runs that keep it, whichever way the branch moves them.
pub(crate) fn solve_branch(
    read: &Read,
    solver: &dyn Solver,
    place: (&Command, Option<&Update>),
    (subject, name, occurs, counts): (&Subject, &str, &str, &Counts),
) -> Result<SolvedBranch, Refusal> {
    let comment = match subject {
        Subject::FailureMode(_) => format!("{name}: {}", counts.words()),
        Subject::Requirement(id) => format!("{name}: requirement {id} holds in {}", counts.words()),
    };
    // What is left by a requirement that holds in most runs is where to begin.
    let share = counts.rate().min(1.0 - counts.rate());
    let start = match subject {
        Subject::FailureMode(_) => counts.rate(),
        Subject::Requirement(_) => share,
    };
    let first = (digits(start), comment);
    let branched = with_branch(read, place, (name, occurs), &first)?;
    let read = Read::new(&branched.text)?;
    let number = Number::Constant(branched.constant.clone());
    let mut rate = |value: f64| rate_with(&read, solver, &number, value, subject);
    let scale = match place.1 {
        None if is_of_rates(&read) => Scale::Log,
        _ => Scale::Odds,
    };
    let found = solve::crossing(&mut rate, (start, scale), counts.rate(), FARTHEST);
    let value = found.ok_or("no probability of the branch gives the counted rate")?;
    let text = number.set(&read, value)?;
    Ok(SolvedBranch {
        values: solver.values(&text)?,
        text,
        constant: branched.constant,
        value,
    })
}

/// Whether the model's numbers are rates in continuous time.
fn is_of_rates(read: &Read) -> bool {
    read.model.model_type == ModelType::Ctmc
}

/// What the number of a further update of a command is: of a part of an update it is a probability, whatever the update's is.
pub(crate) fn number_in_words(read: &Read, update: Option<&Update>) -> &'static str {
    match update {
        None if is_of_rates(read) => "rate",
        _ => "probability",
    }
}

/// The variable and the value of a proposition `variable=value`, and whether the model lacks the value.
fn wanted_value(read: &Read, wanted: &[Equality]) -> Result<(String, String, bool), Refusal> {
    let [(variable, expr)] = wanted else {
        return Err("its proposition is not of the form `variable=value`".into());
    };
    let (value, is_missing) = match &expr.kind {
        ExprKind::Name(name) => (name.clone(), read.model.constant(name).is_none()),
        ExprKind::Int(value) => (value.to_string(), false),
        ExprKind::Bool(value) => (value.to_string(), false),
        _ => return Err("its proposition names no value".into()),
    };
    Ok((variable.clone(), value, is_missing))
}

/// Commands that may get the branch, best first.
fn candidates<'r>(
    read: &'r Read,
    occurs: &str,
    after: Option<&str>,
) -> Result<Vec<&'r Command>, Refusal> {
    let (variable, ..) = wanted_value(read, &read.equalities(occurs)?)?;
    let variable = variable.as_str();
    let after = after.and_then(|text| read.equalities(text).ok());
    let after = after.unwrap_or_default();
    let owner = read.tree.modules.iter().find_map(|m| match &m.body {
        ModuleBody::Written {
            variables,
            commands,
            ..
        } => variables
            .iter()
            .any(|v| v.name.text == variable)
            .then_some(commands),
        ModuleBody::Renamed { .. } => None,
    });
    let commands =
        owner.ok_or_else(|| format!("no module that is written out owns `{variable}`"))?;
    let initial = read.model.variables.iter().find(|v| v.name == variable);
    let initial = initial.map(|v| v.init);
    let mut found: Vec<(u8, &Command)> = commands
        .iter()
        .filter(|command| assigns(command, variable))
        .map(|command| (rank(read, command, variable, &after, initial), command))
        .collect();
    if found.is_empty() {
        // Nothing leads there any more: what is left is where the opportunity is.
        let all = commands.iter();
        let all = all.map(|command| (rank(read, command, variable, &after, None), command));
        found.extend(all.filter(|(rank, _)| *rank == 0));
    }
    if found.is_empty() {
        return Err(format!(
            "no command assigns `{variable}`, and none asks for what its opportunity says"
        ));
    }
    found.sort_by_key(|(rank, command)| (*rank, command.span.start));
    // Where a guard says when the opportunity is, no other command is meant.
    let is_said = found.first().is_some_and(|(rank, _)| *rank == 0);
    found.retain(|(rank, _)| !is_said || *rank == 0);
    Ok(found.into_iter().map(|(_, command)| command).collect())
}

fn assigns(command: &Command, variable: &str) -> bool {
    let mut all = command.updates.iter().flat_map(|u| &u.assignments);
    all.any(|assignment| assignment.variable.text == variable)
}

/// 0: its guard asks for what the opportunity says; 1: it leaves the initial
/// value; 2: neither.
fn rank(
    read: &Read,
    command: &Command,
    variable: &str,
    after: &[Equality],
    initial: Option<i64>,
) -> u8 {
    let value = |expr: &Expr| value_of(expr, None, &read.model);
    let guard = of_guard(command, &read.tree.formulas);
    let asks = |(name, expr): &Equality| {
        let mut own = guard.iter().filter(|(n, _)| n == name);
        own.any(|(_, asked)| value(asked) == value(expr))
    };
    if !after.is_empty() && after.iter().all(asks) {
        0
    } else if guard
        .iter()
        .any(|(n, e)| n == variable && value(e) == initial)
    {
        1
    } else {
        2
    }
}

struct Branched {
    text: String,
    constant: String,
}

fn with_branch(
    read: &Read,
    (command, update): (&Command, Option<&Update>),
    (name, occurs): (&str, &str),
    (share, comment): &(String, String),
) -> Result<Branched, Refusal> {
    let (variable, value, is_missing) = wanted_value(read, &read.equalities(occurs)?)?;
    let (variable, value) = (variable.as_str(), value.as_str());
    let known = read.model.variables.iter().find(|v| v.name == variable);
    let (_, high) = known
        .map(|v| v.kind.bounds())
        .ok_or_else(|| format!("the model has no variable `{variable}`"))?;
    let mut edits = Vec::new();
    if is_missing {
        let extension = edit::extend_range(read.text, &read.tree, variable, high, value)
            .map_err(|error| error.to_string())?;
        edits.extend(extension.edits);
    }
    let constant = new_name(&read.tree, name);
    let line = format!("const double {constant} = {share}; // {comment}");
    edits.push(edit::add_constants(read.text, &read.tree, &[line], None));
    match update {
        // A rate takes nothing from the others.
        None if is_of_rates(read) => {
            if let (Some(first), Some(last)) = (command.updates.first(), command.updates.last()) {
                let outcome = edit::with_value(read.text, first, variable, value);
                let added = format!(" + {constant} : {outcome}");
                edits.push(edit::Edit::insert(last.span.end, added));
            }
        }
        None => edits.extend(edit::add_branch(
            read.text, command, &constant, variable, value,
        )),
        Some(update) => edits.push(edit::divide_update(
            read.text, update, &constant, variable, value,
        )),
    }
    let text = edit::apply(read.text, &edits).map_err(|error| error.to_string())?;
    Ok(Branched { text, constant })
}

/// `pGripFailure` of `grip_failure`.
fn new_name(tree: &Model, mode: &str) -> String {
    let words = mode.split(|c: char| !c.is_ascii_alphanumeric());
    let mut name = "p".to_owned();
    for word in words {
        let mut letters = word.chars();
        name.extend(letters.next().map(|c| c.to_ascii_uppercase()));
        name.extend(letters);
    }
    let mut free = name.clone();
    let mut number = 2;
    while edit::declares(tree, &free) {
        free = format!("{name}{number}");
        number += 1;
    }
    free
}
