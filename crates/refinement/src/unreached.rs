//! A state that a proposition names and no command leads to: some command lacks the branch that leads there.
//!
//! # Definition
//! A model that computes exactly 0 or 1 for a subject, where counts show otherwise, excludes what was seen. If a proposition of the
//! subject's property asks for `variable=value` and no update gives the variable that value, the branch to it is lacking; where all of
//! them are reached, one to a value that a guard asks for and no update gives. It is
//! tried in each command of the module that owns the variable (those that give it values, or where none does, all): as one more update,
//! and as a part of each update. Its probability is solved for so that the subject has the counted rate, and the changed
//! model is held against all evidence ([`crate::structure`]). Those that weigh as much as the best one (to within [`AS_GOOD`]) are
//! offered together, a further update of a command that draws already before others, in the order of the text.
//!
//! # Assumes
//! That what was counted is what the proposition means, and that one branch alone is lacking.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843), with one free number and the choice of a place, which the weight counts against it. What
//! is offered was solved. Where evidence speaks on one subject alone it does not tell the places apart, and says so.
//!
//! # Cost
//! Some twelve solutions for each place: at most [`MOST_PLACES`], of a large model fewer, so that states times solutions stay below
//! [`crate::model_offers::MOST_WORK`].

use crate::counts::{Counts, anchors};
use crate::draws::{self, Equality};
use crate::model_change::{
    AS_GOOD, Alternative, Changed, ModelChange, Read, Refusal, SetConstant, Solver, Values,
    solve_branch, value_of,
};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use evidence::{Evidence, Measure, Subject};
use prism_lang::ast::{Command, ExprKind, ModuleBody};

/// Places that are tried, at most.
const MOST_PLACES: usize = 40;

/// Solutions for one place, about.
const SOLUTIONS: u64 = 12;

/// Places that are offered, at most.
const MOST_OFFERS: usize = 3;

/// A rate that is as near to 0 or 1 is computed as certain.
const CERTAIN: f64 = 1e-12;

/// A proposition that a subject's property asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// The subject.
    pub subject: Subject,
    /// What the study calls it.
    pub name: String,
    /// What it means over the model's variables.
    pub meaning: String,
}

/// Where a branch is put in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The command, counted from 0 over all modules.
    pub command: usize,
    /// The update that is divided, counted from 0; none for one more update.
    pub update: Option<usize>,
}

impl Place {
    /// The line of a model's text that holds it, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let read = Read::new(text).ok()?;
        let all = commands(&read.tree);
        let command = all.get(self.command)?;
        let span = match self.update {
            Some(update) => command.updates.get(update)?.span,
            None => command.span,
        };
        let (line, _) = prism_lang::line_and_column(text, span.start);
        u32::try_from(line).ok()
    }
}

/// A branch that gives the counted rate.
struct Found {
    place: Place,
    weight: f64,
    changed: Changed,
}

impl Ground<'_> {
    /// Puts branches to states that nothing leads to before all other changes, where nothing weighs more.
    pub(crate) fn of_unreached(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let Ok(read) = Read::new(model.text) else {
            return;
        };
        let is_branch = |subject: &Subject, found: &ModelOffers| {
            let mut all = found.changes.iter();
            all.any(|(change, _)| {
                matches!(change, ModelChange::Branch { .. }) && change.subject() == *subject
            })
        };
        for subject in self.excluded(own, before) {
            if is_branch(&subject, found) {
                continue;
            }
            let Some(counts) = anchors(self.evidence, own, &subject).into_iter().next() else {
                continue;
            };
            let words = model.words.iter().filter(|it| it.subject == subject);
            let mut targets: Vec<Word> = words
                .flat_map(|word| {
                    let all = read.equalities(&word.meaning).unwrap_or_default();
                    let lacking = lacking(&read, &all).into_iter();
                    lacking.map(|value| Word {
                        meaning: value.meaning,
                        ..word.clone()
                    })
                })
                .collect();
            if targets.is_empty() {
                targets = of_guards(&read)
                    .into_iter()
                    .map(|value| Word {
                        subject: subject.clone(),
                        name: format!("{}_{}", value.variable, value.value),
                        meaning: value.meaning,
                    })
                    .collect();
            }
            let tried: Vec<(ModelChange, Found)> = targets
                .iter()
                .flat_map(|word| self.branches_to(model, own, (&read, before), (word, &counts)))
                .collect();
            self.offer(model, own, before, (&subject, tried), found);
        }
    }

    /// The subjects that the model excludes, or holds for certain, against strong evidence.
    pub(crate) fn excluded(&self, own: &Evidence, before: &Values) -> Vec<Subject> {
        let is_certain = |subject: &Subject| {
            value_of(before, subject)
                .is_some_and(|value| value <= CERTAIN || value >= 1.0 - CERTAIN)
        };
        // A failure mode that it lacks has no value of its own, or 0.
        let lacking = self.failure_modes.iter().filter_map(|mode| {
            let subject = Subject::FailureMode(mode.id.clone());
            let is_lacking = matches!(
                own.finding(&subject).map(|it| &it.measure),
                Some(Measure::Probability { answer, .. }) if answer.value <= CERTAIN
            );
            (is_lacking && self.strongest(own, &subject, Some(0.0)) > evidence::STRONG)
                .then_some(subject)
        });
        let mut all: Vec<Subject> = self.in_conflict(own, before);
        all.retain(is_certain);
        for subject in lacking {
            if !all.contains(&subject) {
                all.push(subject);
            }
        }
        all
    }

    /// The branches to a proposition's state with which the subject has the counted rate.
    fn branches_to(
        &self,
        model: &Model<'_>,
        own: &Evidence,
        (read, before): (&Read<'_>, &Values),
        (word, counts): (&Word, &Counts),
    ) -> Vec<(ModelChange, Found)> {
        let most = model.affordable(MOST_PLACES, SOLUTIONS);
        let places = places(read, &word.meaning);
        let tried = places.len().min(most).max(1) as f64;
        let made = places.into_iter().take(most).filter_map(|place| {
            let change = ModelChange::Branch {
                subject: word.subject.clone(),
                name: word.name.clone(),
                occurs: word.meaning.clone(),
                after: None,
                at: Some(place),
                counts: counts.clone(),
            };
            let changed = change.make(model.text, model.solver).ok()?;
            let trial = self.tried(&own.id, before, changed.at_last());
            let weight = self.weight_of_solved(own, before, changed.at_last())?;
            (!trial.is_harmful()).then(|| {
                let found = Found {
                    place,
                    weight: weight - tried.log10(),
                    changed,
                };
                (change, found)
            })
        });
        made.collect()
    }

    fn offer(
        &self,
        model: &Model<'_>,
        own: &Evidence,
        before: &Values,
        (subject, mut tried): (&Subject, Vec<(ModelChange, Found)>),
        found: &mut ModelOffers,
    ) {
        let best = tried
            .iter()
            .map(|(_, it)| it.weight)
            .fold(f64::NEG_INFINITY, f64::max);
        if best == f64::NEG_INFINITY {
            return;
        }
        tried.retain(|(_, it)| it.weight >= best - AS_GOOD);
        let is_harmless = |changed: &Changed| {
            let trial = self.tried(&own.id, before, changed.at_last());
            !trial.is_harmful() && trial.repairs.iter().any(|it| &it.subject == subject)
        };
        let others = found.changes.iter().map(|it| &it.1);
        if self.heaviest(own, before, others.filter(|it| is_harmless(it))) > best + AS_GOOD {
            return;
        }
        let named: Vec<Alternative> = tried
            .iter()
            .map(|(_, it)| Alternative {
                name: it.changed.what.clone(),
                line: it.place.line(model.text),
            })
            .collect();
        let several = named.len();
        let made = tried.into_iter().take(MOST_OFFERS).enumerate();
        let made: Vec<(ModelChange, Changed)> = made
            .map(|(number, (change, it))| {
                let mut changed = it.changed;
                let others = named.iter().enumerate().filter(|(at, _)| *at != number);
                changed.alternatives = others.map(|(_, it)| it.clone()).collect();
                if several > 1 {
                    changed.notes.push(format!(
                        "The evidence does not tell {several} places of this branch apart; who knows the system decides where it belongs."
                    ));
                }
                (change, changed)
            })
            .collect();
        found.changes.splice(0..0, made);
        let prefix = format!("{} of {}: ", subject.in_words(), model.evidence);
        found.refused.retain(|it| !it.starts_with(&prefix));
    }
}

/// A value that no update gives a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Lacking {
    pub(crate) variable: String,
    /// As it is written.
    pub(crate) value: String,
    /// That the variable has it, as a state formula.
    pub(crate) meaning: String,
}

/// Those of some equalities that no update makes true, and that do not hold at the beginning.
pub(crate) fn lacking(read: &Read<'_>, all: &[Equality]) -> Vec<Lacking> {
    let of = |(variable, expr): &Equality| {
        let known = read
            .model
            .variables
            .iter()
            .find(|it| &it.name == variable)?;
        if draws::value_of(expr, None, &read.model) == Some(known.init) {
            return None;
        }
        let meaning = match &expr.kind {
            ExprKind::Bool(true) => variable.clone(),
            ExprKind::Bool(false) => format!("!{variable}"),
            _ => format!("{variable}={expr}"),
        };
        (!read.comes_to(&meaning)).then(|| Lacking {
            variable: variable.clone(),
            value: expr.to_string(),
            meaning,
        })
    };
    all.iter().filter_map(of).collect()
}

/// The values that guards name, in any of their cases, and no update gives.
pub(crate) fn of_guards(read: &Read<'_>) -> Vec<Lacking> {
    let mut found: Vec<Lacking> = Vec::new();
    for command in commands(&read.tree) {
        for value in lacking(read, &draws::named_in_guard(command, &read.tree.formulas)) {
            if !found.contains(&value) {
                found.push(value);
            }
        }
    }
    found
}

/// Where a branch to `variable=value` may be put in, best first.
fn places(read: &Read<'_>, meaning: &str) -> Vec<Place> {
    let Ok(equalities) = read.equalities(meaning) else {
        return Vec::new();
    };
    let Some((variable, _)) = equalities.first() else {
        return Vec::new();
    };
    let owns = |body: &ModuleBody| match body {
        ModuleBody::Written { variables, .. } => {
            variables.iter().any(|it| it.name.text == *variable)
        }
        ModuleBody::Renamed { .. } => false,
    };
    let Some(owner) = read.tree.modules.iter().find(|it| owns(&it.body)) else {
        return Vec::new();
    };
    let ModuleBody::Written { commands: own, .. } = &owner.body else {
        return Vec::new();
    };
    let assigns = |command: &Command| {
        let mut all = command.updates.iter().flat_map(|it| &it.assignments);
        all.any(|it| it.variable.text == *variable)
    };
    let any = own.iter().any(assigns);
    let all = commands(&read.tree);
    let position = |command: &Command| all.iter().position(|it| it.span == command.span);
    let candidates = own.iter().filter(|it| !any || assigns(it));
    let mut found: Vec<(u8, Place)> = Vec::new();
    for command in candidates {
        let Some(place) = position(command) else {
            continue;
        };
        let draws = command.updates.len() > 1;
        found.push((
            u8::from(!draws),
            Place {
                command: place,
                update: None,
            },
        ));
        if draws {
            let parts = (0..command.updates.len()).map(|update| Place {
                command: place,
                update: Some(update),
            });
            found.extend(parts.map(|it| (2, it)));
        }
    }
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, place)| place).collect()
}

/// The model with a branch at one place, its probability solved for.
pub(crate) fn at_place(
    text: &str,
    solver: &dyn Solver,
    change: &ModelChange,
    place: Place,
) -> Result<Changed, Refusal> {
    let ModelChange::Branch {
        subject,
        name,
        occurs,
        counts,
        ..
    } = change
    else {
        return Err("it is not a branch".into());
    };
    let read = Read::new(text)?;
    let all = commands(&read.tree);
    let command = all
        .get(place.command)
        .ok_or("the model has no such command")?;
    let update = match place.update {
        Some(update) => Some(
            command
                .updates
                .get(update)
                .ok_or("the command has no such update")?,
        ),
        None => None,
    };
    let solved = solve_branch(
        &read,
        solver,
        (command, update),
        (subject, name, occurs, counts),
    )?;
    let line = place.line(text).unwrap_or_default();
    Ok(Changed {
        what: format!(
            "{} can happen in line {line}, with {} {} each time, with which the share of runs is that of {}",
            name.replace('_', " "),
            crate::model_change::number_in_words(&read, update),
            crate::model_change::digits(solved.value),
            counts.words()
        ),
        values: solved.values,
        text: solved.text,
        constant: Some(SetConstant {
            name: solved.constant,
            is_complement: false,
            is_solved: true,
            value: Some(solved.value),
        }),
        notes: Vec::new(),
        alternatives: Vec::new(),
        settled: None,
    })
}
