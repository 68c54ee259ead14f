//! Lines of formal models that are suspected as a whole.
//!
//! # Definition
//! For each model that an open suspect names without a line, what could be changed in it is made and tried
//! ([`refinement::Ground::of_model`]). Of the changes that do no harm and are of a rate that the suspect is named for, or
//! repair what it is named for, the first says the line: the first one that it changes. Other numbers that the evidence
//! does not tell apart from it are named with their lines. Fault trees are in [`super::gates`].
//!
//! # Assumes
//! One change is enough: all else of the model is right. What changes explain is weighed as `refinement` says.
//!
//! # Guarantee
//! A line is where one change makes the evidence agree, not a proof that it is wrong; the score stays that of the model.

use super::gates::OfTree;
use super::{Diagnosing, Gathered};
use crate::refine::proposal::{Asset, current, ground, of_model};
use crate::refine::solver::Solver;
use diagnostic::Problem;
use evidence::{Measure, STRONG, Subject, Suspect, SuspectKind};
use refinement::{Changed, ModelChange, Trial, Values};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A change with the model after it, and what it does to the agreement with all evidence.
type Tried = (ModelChange, Changed, Trial);

/// What could be changed in the formal models and fault trees of a study.
pub(super) struct OfModels {
    pub(super) models: Vec<OfModel>,
    pub(super) trees: Vec<OfTree>,
}

impl OfModels {
    /// Whether a harmless change of the model of a piece explains what disagrees on a subject.
    pub(super) fn explain(&self, evidence: &str, subject: &Subject) -> bool {
        let own = self.models.iter().filter(|it| it.evidence == evidence);
        let mut tried = own.flat_map(|it| &it.changes);
        tried.any(|(.., trial)| {
            !trial.is_harmful() && trial.repairs.iter().any(|it| &it.subject == subject)
        })
    }
}

/// What could be changed in one of them.
pub(super) struct OfModel {
    pub(super) evidence: String,
    text: String,
    /// What it answers now.
    pub(super) before: Values,
    changes: Vec<Tried>,
}

impl OfModel {
    /// What it answers after each change that does no harm, and what counts against the change.
    pub(super) fn answers(&self) -> impl Iterator<Item = (&Values, f64)> {
        let harmless = self
            .changes
            .iter()
            .filter(|(.., trial)| !trial.is_harmful());
        harmless.map(|(change, changed, _)| (changed.at_last(), change.cost()))
    }
}

impl Diagnosing<'_> {
    /// Gives the models among the suspects the lines that a change fixes.
    pub(super) fn lines(
        &self,
        suspects: &mut [Suspect],
        offered: &OfModels,
    ) -> Result<(), Problem> {
        self.tree_lines(suspects, &offered.trees)?;
        self.row_lines(suspects);
        for offered in &offered.models {
            let text = offered.text.as_str();
            for suspect in suspects
                .iter_mut()
                .filter(|it| is_whole_model(it, &offered.evidence))
            {
                if let Some((change, changed)) = best_for(&suspect.subjects, &offered.changes) {
                    point(suspect, text, change, changed);
                }
            }
        }
        Ok(())
    }

    /// The lines of rows of tables that are named by what stands in their first cell, or that count the one subject for which
    /// a table is suspected.
    fn row_lines(&self, suspects: &mut [Suspect]) {
        for suspect in suspects {
            let one = match suspect.subjects.as_slice() {
                [one] if suspect.asset.kind == SuspectKind::Data => Some(one.id().to_owned()),
                _ => None,
            };
            let asset = &mut suspect.asset;
            let part = asset.part.as_deref();
            let row = match part {
                Some(part) => part
                    .strip_prefix("row `")
                    .and_then(|it| it.strip_suffix('`')),
                None => one.as_deref(),
            };
            let (Some(file), Some(row), None) = (&asset.file, row, asset.line) else {
                continue;
            };
            // What is no text has no lines.
            let text = std::fs::read_to_string(self.study.folder.join(file));
            let text = text.unwrap_or_default();
            let is_row = |line: &str| line.split(',').next().is_some_and(|it| it.trim() == row);
            let place = text.lines().position(is_row);
            asset.line = place.and_then(|it| u32::try_from(it + 1).ok());
        }
    }

    /// What could be changed in the formal models that disagree strongly with something.
    pub(super) fn offered(&self, gathered: &mut Gathered) -> Result<OfModels, Problem> {
        let apart = self.disagreements(&self.result.evidence);
        let solver = Solver::new(self.study, &self.setting.cancel);
        let mut models = Vec::new();
        for entry in current(self.study, &self.result.evidence) {
            let disagrees = apart.iter().any(|((one, other, _), apart)| {
                *apart > STRONG && [one, other].contains(&&entry.id)
            });
            let lacks = || {
                let pieces = self.result.evidence.iter();
                pieces.filter(|it| it.id == entry.id).any(|it| {
                    it.findings.iter().any(|finding| {
                        matches!(finding.subject, Subject::FailureMode(_))
                            && matches!(finding.measure, Measure::NotExpressible { .. })
                    })
                })
            };
            let Some(path) = entry.work.model().filter(|_| disagrees || lacks()) else {
                continue;
            };
            let (source, _) = host::files::read_prism(&self.study.folder.join(path))?;
            let asset = Asset {
                entry,
                path,
                text: &source.text,
            };
            let changes = self.changes(&asset, &solver);
            // An interrupted solution is no reason to say that there is no line.
            self.setting.go_on()?;
            match changes {
                Ok((before, changes)) => models.push(OfModel {
                    evidence: entry.id.clone(),
                    text: source.text,
                    before,
                    changes,
                }),
                Err(problem) => gathered.not_done.push(format!(
                    "lines of {}: {}",
                    entry.id,
                    problem.warning_line()
                )),
            }
        }
        let trees = self.offered_trees()?;
        Ok(OfModels { models, trees })
    }

    /// What could be changed in a model, with what it does to all the evidence.
    fn changes(
        &self,
        asset: &Asset<'_>,
        solver: &Solver<'_>,
    ) -> Result<(Values, Vec<Tried>), Problem> {
        let before = solver.values(asset.path, asset.text)?;
        let ground = ground(self.study, self.result);
        let offers = of_model(self.study, self.result, asset, solver)?;
        let tried = |(change, changed): (ModelChange, Changed)| {
            let trial = ground.tried(&asset.entry.id, &before, changed.at_last());
            (change, changed, trial)
        };
        let changes = offers.changes.into_iter().map(tried).collect();
        Ok((before, changes))
    }
}

/// Whether an open suspect is the model of a piece, without a line.
pub(super) fn is_whole_model(suspect: &Suspect, evidence: &str) -> bool {
    let asset = &suspect.asset;
    suspect.is_open()
        && asset.kind == SuspectKind::FormalModel
        && asset.line.is_none()
        && asset.evidence.iter().any(|id| id == evidence)
}

/// The first harmless change of these subjects, their own before those that repair them.
fn best_for<'c>(
    subjects: &[Subject],
    changes: &'c [Tried],
) -> Option<(&'c ModelChange, &'c Changed)> {
    // What repairs more first, as it is offered.
    let mut of_changes: Vec<&Tried> = changes.iter().collect();
    of_changes.sort_by_key(|(.., trial)| Reverse(trial.repairs.len()));
    let harmless = || {
        of_changes
            .iter()
            .copied()
            .filter(|(.., trial)| !trial.is_harmful())
    };
    let own = |subject: &Subject| harmless().find(|(change, ..)| change.subject() == *subject);
    let repairs = |subject: &Subject| {
        harmless().find(|(.., trial)| trial.repairs.iter().any(|it| &it.subject == subject))
    };
    // A branch that is lacking is offered only where no change weighs more.
    let lacking = harmless().find(|(change, _, trial)| {
        let mut repaired = trial.repairs.iter();
        change.is_of_lacking_branch() && repaired.any(|it| subjects.contains(&it.subject))
    });
    let first = lacking.or_else(|| subjects.iter().find_map(own));
    let (change, changed, _) = first.or_else(|| subjects.iter().find_map(repairs))?;
    Some((change, changed))
}

/// Says the line that a change fixes, and those that are not told apart from it.
fn point(suspect: &mut Suspect, text: &str, change: &ModelChange, changed: &Changed) {
    suspect.asset.line = changed_line(text, &changed.text);
    let part = match change {
        ModelChange::Solve { number, .. } => format!("`{}`", number.name()),
        ModelChange::Branchless { branch, .. } => {
            suspect.asset.line = branch.line(text);
            format!("branch `{}`", branch.written(text).unwrap_or_default())
        }
        ModelChange::Branch {
            at: Some(place),
            occurs,
            ..
        } => {
            suspect.asset.line = place.line(text);
            format!("a branch to `{occurs}`")
        }
        ModelChange::Split { split, .. } => {
            suspect.asset.line = split.line(text);
            format!("a branch `{}`", split.written())
        }
        ModelChange::Idle { change, .. } => {
            suspect.asset.line = change.line(text);
            format!("`{}`", change.part())
        }
        ModelChange::Slip { change, .. } => {
            suspect.asset.line = change.line(text);
            format!("`{}`", change.part())
        }
        ModelChange::Rate { .. } | ModelChange::Branch { .. } | ModelChange::Once { .. } => return,
    };
    if let ModelChange::Branchless { .. }
    | ModelChange::Split { .. }
    | ModelChange::Idle { .. }
    | ModelChange::Slip { .. } = change
    {
        suspect
            .explanation
            .push_str(&format!(" With {} the evidence agrees.", changed.what));
    }
    suspect.asset.part = Some(part);
    let file = suspect.asset.file.clone().unwrap_or_default();
    let others = changed.alternatives.iter().map(|other| {
        let name = other.name.trim_matches('`');
        match other.line {
            Some(line) => format!("{file}:{line} (`{name}`)"),
            None => format!("{file} (`{name}`)"),
        }
    });
    suspect.asset.together.extend(others);
}

/// The first line that another takes the place of, from 1; where lines are added alone, the first behind them.
fn changed_line(old: &str, new: &str) -> Option<u32> {
    let mut left: BTreeMap<&str, i32> = BTreeMap::new();
    for line in new.lines() {
        *left.entry(line).or_default() += 1;
    }
    let is_gone = |line: &str| match left.get_mut(line) {
        Some(count) if *count > 0 => {
            *count -= 1;
            false
        }
        _ => true,
    };
    let replaced = old.lines().position(is_gone);
    let added = || old.lines().zip(new.lines()).position(|(a, b)| a != b);
    u32::try_from(replaced.or_else(added)? + 1).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_the_first_that_differs() {
        assert_eq!(changed_line("a\nb\nc", "a\nx\nc"), Some(2));
        assert_eq!(changed_line("a\nb\n", "a\nnew\nb\n"), Some(2));
        assert_eq!(changed_line("a", "a"), None);
        // A constant is declared above the command that has it.
        assert_eq!(changed_line("a\n\nb\nc", "a\nnew\n\nb\nx"), Some(4));
    }
}
