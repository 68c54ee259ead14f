//! A constant that nothing uses, or that is added to another one: the branch that it was written for is lacking.
//!
//! # Definition
//! A probability that is declared and stands nowhere else was written to be used. For each such constant `c`, each update of each
//! command, and each command of several updates as a whole, is divided: with `c` (or with `1-c`) it is as it was, and else the run does
//! something else: nothing, what another update of the module does, or a value that a proposition or a guard names and no update gives,
//! alone, with all else that the update does, or with a whole number that is declared and stands nowhere else, too. Each is solved and
//! tried on all evidence ([`crate::structure`]) where the model disagrees strongly with counts. No number is fitted. Of those that explain
//! as much, what leads to a value that nothing else leads to comes first: one branch accounts for both oddities of the text.
//!
//! Likewise where the probability of an update is a sum, as of two branches that were written as one: each term of it in turn is that of
//! a branch of its own, which leads where those of constants do. Sums are often meant, so that what explains by one has to be strong
//! evidence beyond the number of places, which is not asked of a constant that nothing uses.
//!
//! # Assumes
//! That the constant has the value that it was meant to have, and that one branch is lacking.
//!
//! # Guarantee
//! What is offered was solved, and what it leads to was counted. Several places may give the same rates; each says so.
//!
//! # Cost
//! One solution for each; at most [`MOST_SPLITS`] in all, of a large model fewer, so that states times solutions stay below
//! [`crate::model_offers::MOST_WORK`].

use crate::counts::Counts;
use crate::model_change::{Changed, ModelChange, Read, Refusal, Solver, Values};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use crate::structure::{Rewriting, Tried};
use crate::unreached::{Lacking, Place, lacking, of_guards};
use evidence::{STRONG, Subject};
use prism_lang::ast::{BinaryOp, Command, Expr, ExprKind, ModuleBody, Type, Update};
use prism_lang::edit::{self, Edit};
use prism_lang::resolved::ModelType;
use std::collections::BTreeSet;

/// Divided updates that are tried, at most.
const MOST_SPLITS: usize = 400;

/// An update that is divided by a constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Split {
    /// The command, counted from 0 over all modules.
    pub command: usize,
    /// Its update, counted from 0; all of them, if none is named.
    pub update: Option<usize>,
    /// Its probability.
    pub by: SplitBy,
    /// What is done in the added branch, as an update is written.
    pub to: String,
    /// Whether that is a value to which no update leads.
    pub leads_to_lacking: bool,
}

/// By what an update is divided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SplitBy {
    /// The added branch has a constant as its probability.
    Constant(String),
    /// What was there keeps a constant, and the added branch has what remains of 1.
    Rest(String),
    /// The added branch takes one term of the update's probability, which is a sum.
    Term {
        /// Which, counted from 0.
        place: usize,
        /// As it is written.
        written: String,
    },
}

impl SplitBy {
    /// Whether it takes a term of a sum.
    #[must_use]
    pub fn is_term(&self) -> bool {
        matches!(self, Self::Term { .. })
    }

    /// What was written for the branch.
    #[must_use]
    pub fn written_for(&self) -> &str {
        match self {
            Self::Constant(name) | Self::Rest(name) => name,
            Self::Term { written, .. } => written,
        }
    }
}

impl Split {
    /// The line of a model's text that holds the update, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let place = Place {
            command: self.command,
            update: self.update,
        };
        place.line(text)
    }

    /// The branch that is added.
    #[must_use]
    pub fn written(&self) -> String {
        match &self.by {
            SplitBy::Constant(name) => format!("{name} : {}", self.to),
            SplitBy::Rest(name) => format!("1-{name} : {}", self.to),
            SplitBy::Term { written, .. } => format!("{written} : {}", self.to),
        }
    }

    fn make(&self, read: &Read<'_>) -> Result<String, Refusal> {
        let all = commands(&read.tree);
        let command = all
            .get(self.command)
            .ok_or("the model has no such command")?;
        let by = match &self.by {
            SplitBy::Constant(name) => Ok((name.as_str(), true)),
            SplitBy::Rest(name) => Ok((name.as_str(), false)),
            SplitBy::Term { place, .. } => Err(*place),
        };
        let update = self.update.map(|place| {
            let update = command.updates.get(place);
            update.ok_or("the command has no such update")
        });
        let edits = match (update.transpose()?, by) {
            (None, Ok(by)) => edit::split_command(read.text, command, by, &self.to),
            (Some(update), Ok(by)) => vec![edit::split_update(read.text, update, by, &self.to)],
            (Some(update), Err(term)) => term_apart(read.text, update, term, &self.to)
                .ok_or("the update's probability has no such term")?,
            (None, Err(_)) => return Err("a command has no probability to be divided".into()),
        };
        edit::apply(read.text, &edits).map_err(|e| e.to_string())
    }

    fn words(&self, text: &str) -> String {
        let line = self.line(text).unwrap_or_default();
        match &self.by {
            SplitBy::Constant(name) | SplitBy::Rest(name) => format!(
                "`{}` added in line {line}, for which `{name}` was written",
                self.written()
            ),
            SplitBy::Term { written, .. } => format!(
                "`{}` as a branch of its own in line {line}, where `{written}` is added to another probability",
                self.written()
            ),
        }
    }
}

/// The terms of a probability that is a sum; none of what is none.
fn terms(update: &Update) -> Vec<&Expr> {
    fn collect<'e>(expr: &'e Expr, found: &mut Vec<&'e Expr>) {
        match &expr.kind {
            ExprKind::Binary(BinaryOp::Plus, left, right) => {
                collect(left, found);
                collect(right, found);
            }
            _ => found.push(expr),
        }
    }
    let mut found = Vec::new();
    if let Some(probability) = &update.probability {
        collect(probability, &mut found);
    }
    match found.len() {
        0 | 1 => Vec::new(),
        _ => found,
    }
}

/// The update without one term of its probability, and the branch that has it.
fn term_apart(text: &str, update: &Update, term: usize, to: &str) -> Option<Vec<Edit>> {
    let all = terms(update);
    let written = |it: &Expr| text[it.span.start..it.span.end].to_owned();
    let own = written(all.get(term)?);
    let rest: Vec<String> = all
        .iter()
        .enumerate()
        .filter(|(place, _)| *place != term)
        .map(|(_, it)| written(it))
        .collect();
    let colon = all.last()?.span.end;
    let outcome = text[colon..update.span.end].split_once(':')?.1.trim();
    let new = format!("{} : {outcome} + {own} : {to}", rest.join("+"));
    Some(vec![Edit::replace(update.span, new)])
}

impl Ground<'_> {
    /// Puts branches of constants that nothing uses before the other changes, where nothing weighs more.
    pub(crate) fn of_unused(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let Ok(read) = Read::new(model.text) else {
            return;
        };
        let constants = unused(&read);
        let has_sums = commands(&read.tree)
            .iter()
            .any(|it| it.updates.iter().any(|update| !terms(update).is_empty()));
        let lacking = self.excluded(own, before);
        let mut subjects = self.in_conflict(own, before);
        for subject in lacking {
            if !subjects.contains(&subject) {
                subjects.push(subject);
            }
        }
        if constants.is_empty() && !has_sums || subjects.is_empty() {
            return;
        }
        let all = splits(model, &read, &constants);
        let (of_terms, of_constants): (Vec<Split>, Vec<Split>) =
            all.into_iter().partition(|it| it.by.is_term());
        // That nothing uses the constant speaks for it, whatever the number of places.
        for (all, least) in [(of_terms, STRONG), (of_constants, f64::NEG_INFINITY)] {
            let most = model.affordable(MOST_SPLITS, 1);
            let tried = all.into_iter().take(most).filter_map(|split| {
                let text = split.make(&read).ok()?;
                let values = model.solver.values(&text).ok()?;
                Some(Tried {
                    change: (split, text),
                    kind: 0,
                    values,
                })
            });
            let mut explaining = self.explaining_above(least, own, before, tried.collect());
            explaining.sort_by_key(|it| !it.change.0.leads_to_lacking);
            self.put_first((model, own), before, explaining, found);
        }
    }
}

impl Rewriting for Split {
    fn in_words(&self, text: &str) -> String {
        self.words(text)
    }

    fn line(&self, text: &str) -> Option<u32> {
        Self::line(self, text)
    }

    fn note(&self, others: usize) -> String {
        let reason = match &self.by {
            SplitBy::Constant(name) | SplitBy::Rest(name) => {
                format!("nothing else of the model uses `{name}`")
            }
            SplitBy::Term { written, .. } => {
                format!("`{written}` stands in the sum already")
            }
        };
        format!(
            "No number was fitted for it: {reason}. {others} other places were tried that change what is answered."
        )
    }

    fn offered(self, subject: Subject, counts: Counts, tried: usize) -> ModelChange {
        ModelChange::Split {
            subject,
            split: self,
            counts,
            tried,
        }
    }
}

/// The model with the branch, solved.
pub(crate) fn with(text: &str, solver: &dyn Solver, split: &Split) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let new = split.make(&read)?;
    Changed::rewritten(new, split.words(text), solver)
}

/// The probabilities that are declared and stand nowhere else but in comments.
fn unused(read: &Read<'_>) -> Vec<String> {
    let all = read.chances().into_iter();
    all.filter(|name| !is_used(read.text, name)).collect()
}

/// Whether a name stands in a model's text elsewhere than where it is defined, comments left out.
pub(crate) fn is_used(text: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let code = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    let words = code.flat_map(|line| line.split(|c: char| !is_part(c)));
    words.filter(|word| *word == name).count() > 1
}

/// All updates divided by these constants, what leads to something that a proposition names and nothing does first.
fn splits(model: &Model<'_>, read: &Read<'_>, constants: &[String]) -> Vec<Split> {
    let mut found: Vec<(u8, Split)> = Vec::new();
    let mut command = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written {
            commands: own,
            variables,
            invariant: _,
        } = &module.body
        else {
            continue;
        };
        let is_own = |it: &Lacking| variables.iter().any(|own| own.name.text == it.variable);
        let named = model.words.iter().flat_map(|word| {
            let all = read.equalities(&word.meaning).unwrap_or_default();
            lacking(read, &all)
        });
        let mut targets: Vec<Target> = Vec::new();
        for value in named.chain(of_guards(read)).filter(is_own) {
            let target = Target::Value(value);
            if !targets.contains(&target) {
                targets.push(target);
            }
        }
        targets.push(Target::Outcome("true".to_owned()));
        for update in own.iter().flat_map(|it| &it.updates) {
            let target = Target::Outcome(edit::outcome(read.text, update));
            if !targets.contains(&target) {
                targets.push(target);
            }
        }
        let counts = unused_counts(read, own);
        for (place, of) in own.iter().enumerate() {
            let by = (constants, counts.as_slice());
            found.extend(of_command(read, (command + place, of), &targets, by));
        }
        command += own.len();
    }
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, split)| split).collect()
}

/// What an added branch does.
#[derive(PartialEq)]
enum Target {
    /// This value, and nothing else or what the divided update does.
    Value(Lacking),
    /// What some update does, or nothing.
    Outcome(String),
}

/// The whole numbers that are declared and stand nowhere else, with each variable of these commands that is given such a constant.
fn unused_counts(read: &Read<'_>, own: &[Command]) -> Vec<(String, String)> {
    let is_whole = |name: &str| {
        let mut all = read.tree.constants.iter();
        all.any(|it| it.name.text == name && it.ty == Type::Int)
    };
    let assignments = own.iter().flat_map(|it| &it.updates);
    let assignments = assignments.flat_map(|it| &it.assignments);
    let given = assignments.filter(|it| match &it.value.kind {
        ExprKind::Name(name) => is_whole(name),
        _ => false,
    });
    let variables: BTreeSet<&str> = given.map(|it| it.variable.text.as_str()).collect();
    let names = read.tree.constants.iter().map(|it| it.name.text.as_str());
    let unused = names.filter(|name| is_whole(name) && !is_used(read.text, name));
    unused
        .flat_map(|name| {
            variables
                .iter()
                .map(move |of| ((*of).to_owned(), name.to_owned()))
        })
        .collect()
}

/// What a branch does that leads to a value: all ways, of a command as a whole or of an update of it.
fn ways(
    read: &Read<'_>,
    update: Option<&Update>,
    value: &Lacking,
    counts: &[(String, String)],
) -> Vec<String> {
    let alone = format!("({}'={})", value.variable, value.value);
    let with = update.map(|it| edit::with_value(read.text, it, &value.variable, &value.value));
    let counted = counts.iter().filter(|(of, _)| *of != value.variable);
    let counted: Vec<String> = counted
        .map(|(of, constant)| format!("{alone} & ({of}'={constant})"))
        .collect();
    let mut all: Vec<String> = counted.into_iter().chain([alone]).chain(with).collect();
    all.dedup();
    all
}

fn of_command(
    read: &Read<'_>,
    (command, of): (usize, &Command),
    targets: &[Target],
    (constants, counts): (&[String], &[(String, String)]),
) -> Vec<(u8, Split)> {
    // Rates make up nothing that could be divided into what happens and what does not.
    if read.model.model_type == ModelType::Ctmc {
        return Vec::new();
    }
    let parts = of.updates.iter().enumerate();
    let parts = parts.map(|(place, update)| (Some(place), Some(update)));
    let whole = (of.updates.len() > 1).then_some((None, None));
    let mut found = Vec::new();
    for (place, update) in whole.into_iter().chain(parts) {
        let own = update.map(|it| edit::outcome(read.text, it));
        let made = targets.iter().flat_map(|target| match target {
            Target::Value(value) => ways(read, update, value, counts)
                .into_iter()
                .map(|to| (0, to))
                .collect(),
            Target::Outcome(outcome) if outcome == "true" => vec![(1, outcome.clone())],
            Target::Outcome(outcome) => vec![(2, outcome.clone())],
        });
        for (rank, to) in made.filter(|(_, to)| own.as_ref() != Some(to)) {
            let of_constants = constants
                .iter()
                .flat_map(|name| [SplitBy::Rest(name.clone()), SplitBy::Constant(name.clone())]);
            let of_terms = update.map(terms).unwrap_or_default();
            let of_terms = of_terms.into_iter().enumerate();
            let of_terms = of_terms.map(|(place, term)| SplitBy::Term {
                place,
                written: read.text[term.span.start..term.span.end].to_owned(),
            });
            for by in of_constants.chain(of_terms) {
                let split = Split {
                    command,
                    update: place,
                    by,
                    to: to.clone(),
                    leads_to_lacking: rank == 0,
                };
                found.push((rank, split));
            }
        }
    }
    found
}
