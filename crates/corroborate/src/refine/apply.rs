//! Accepted proposals become files and entries of the ledger.

use super::ledger_text::{Names, NewEntry, SetTo};
use super::lineage::{declare, with_choices};
use super::proposal::{Asset, Change, Proposal, is_of_structure, of_model};
use super::solver::Solver;
use super::texts;
use diagnostic::Problem;
use evidence::{Calibration, StudyResult};
use host::files::{write_prism, write_text};
use refinement::{Changed, Exchange, ModelChange, SetConstant};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::{Entry, Study};

/// A step that was made.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Applied {
    /// The new entry of the ledger; none if a file was changed in its place.
    pub entry: Option<String>,
    /// The file that was written.
    pub file: String,
    /// What was changed.
    pub what: String,
}

/// Makes changes of one study.
pub struct Applier<'a> {
    /// The study as it is.
    pub study: &'a Study,
    /// Its result.
    pub result: &'a StudyResult,
    /// Solves models.
    pub solver: &'a Solver<'a>,
    /// How often models are refined in a row.
    pub rounds: usize,
}

/// A model on its way through the rounds.
struct Step {
    text: String,
    what: Vec<String>,
    set_to: Vec<SetTo>,
}

impl Applier<'_> {
    /// Changes models and forms as accepted, and writes the ledger.
    pub fn apply(&self, accepted: &[&Proposal]) -> Result<Vec<Applied>, Problem> {
        // The ledger first: a change without its lineage would pass for corroboration.
        declare(self.study, accepted)?;
        let mut by_entry: BTreeMap<&str, Vec<&ModelChange>> = BTreeMap::new();
        let mut applied = Vec::new();
        for proposal in accepted {
            match &proposal.change {
                Change::Model { entry, change } => {
                    by_entry.entry(entry).or_default().push(change);
                }
                Change::Form(change) => {
                    let make = |text: &str| change.make(text);
                    applied.push(self.in_place("requirements.toml", proposal, &make)?);
                }
                Change::Text { file, change } => {
                    let file = file.to_string_lossy().replace('\\', "/");
                    let make = |text: &str| change.make(text);
                    applied.push(self.in_place(&file, proposal, &make)?);
                }
                Change::Value { file, value, .. } => {
                    let make = |text: &str| value.make(text);
                    applied.push(self.in_place(file, proposal, &make)?);
                }
                Change::Whole { file, old, new } => {
                    let make = |text: &str| match text == old {
                        true => Ok(new.clone()),
                        false => Err("it was changed since".to_owned()),
                    };
                    applied.push(self.in_place(file, proposal, &make)?);
                }
                Change::Exchange { texts } => {
                    applied.extend(self.together(texts, proposal)?);
                }
                Change::Recalibrate(_) | Change::FitCommand(_) => {}
            }
        }
        for (id, changes) in by_entry {
            let entry = self.study.entry(id)?;
            let chosen = with_choices(entry, accepted);
            applied.extend(self.refine_model(entry, &changes, &chosen)?);
        }
        Ok(applied)
    }

    /// Changes a file in its place.
    fn in_place(
        &self,
        file: &str,
        proposal: &Proposal,
        make: &dyn Fn(&str) -> Result<String, String>,
    ) -> Result<Applied, Problem> {
        let file_path = Path::new(file);
        let source = texts::read(self.study, file_path)?;
        let text = make(&source.text).map_err(|reason| refused(&proposal.title, &reason))?;
        texts::write(self.study, file_path, &text)?;
        Ok(Applied {
            entry: None,
            file: file.to_owned(),
            what: proposal.title.clone(),
        })
    }

    /// Changes several files in their places: all are made before the first is written.
    fn together(
        &self,
        texts: &[(String, Exchange)],
        proposal: &Proposal,
    ) -> Result<Vec<Applied>, Problem> {
        let mut made = Vec::new();
        for (file, exchange) in texts {
            let path = self.study.folder.join(file);
            let text = exchange.make(&host::files::read_source(&path)?.text);
            let text = text.map_err(|reason| refused(&proposal.title, &reason))?;
            made.push((file, path, text));
        }
        let write = |(file, path, text): (&String, PathBuf, String)| {
            write_text(&path, &text, &path)?;
            Ok(Applied {
                entry: None,
                file: file.clone(),
                what: proposal.title.clone(),
            })
        };
        made.into_iter().map(write).collect()
    }

    fn refine_model(
        &self,
        entry: &Entry,
        changes: &[&ModelChange],
        chosen: &[Calibration],
    ) -> Result<Vec<Applied>, Problem> {
        let Some(model) = entry.work.model() else {
            return Ok(Vec::new());
        };
        let source = texts::read(self.study, model)?;
        let mut steps = vec![self.step(model, &source.text, SetTo::of(entry), changes)?];
        while steps.len() < self.rounds {
            let Some(last) = steps.last() else { break };
            let asset = Asset {
                entry,
                path: model,
                text: &last.text,
            };
            let found = of_model(self.study, self.result, &asset, self.solver)?;
            // Whether a branch belongs to the system is for a person to say.
            let is_next = |change: &&ModelChange| !is_of_structure(change);
            let next = found.changes.iter().map(|(change, _)| change);
            let next: Vec<&ModelChange> = next.filter(is_next).collect();
            if next.is_empty() {
                break;
            }
            let step = self.step(model, &last.text, last.set_to.clone(), &next)?;
            steps.push(step);
        }
        self.write_models((entry, chosen), model, &steps)
    }

    /// Makes changes one after the other on one text.
    fn step(
        &self,
        path: &Path,
        text: &str,
        set_to: Vec<SetTo>,
        changes: &[&ModelChange],
    ) -> Result<Step, Problem> {
        let mut step = Step {
            text: text.to_owned(),
            what: Vec::new(),
            set_to,
        };
        for change in changes {
            let Changed {
                text,
                what,
                constant,
                ..
            } = change
                .make(&step.text, &self.solver.at(path))
                .map_err(|reason| refused(change.mode(), &reason))?;
            step.text = text;
            step.what.push(what);
            if let Some(SetConstant {
                name,
                is_complement,
                is_solved,
                value: _,
            }) = constant
            {
                step.set_to.retain(|it| it.name != name);
                step.set_to.push(SetTo {
                    // What was solved for is set to the counts, but is not their share.
                    key: if is_solved { "parameter" } else { "constant" },
                    name,
                    from: change.counts().evidence.clone(),
                    subject: change.subject(),
                    held: false,
                    is_complement,
                });
            }
        }
        Ok(step)
    }

    fn write_models(
        &self,
        (entry, chosen): (&Entry, &[Calibration]),
        model: &Path,
        steps: &[Step],
    ) -> Result<Vec<Applied>, Problem> {
        let (mut ids, mut files, mut entries) = (Vec::new(), Vec::new(), String::new());
        let mut applied = Vec::new();
        for (place, step) in steps.iter().enumerate() {
            let id = Names::next_id(self.study, &entry.id, &ids);
            let file = Names::free_model(&self.study.folder, model, &files);
            let folder = &self.study.folder;
            write_prism(&folder.join(&file), &step.text, &folder.join(model))?;
            let what = step.what.join("; ");
            let new = NewEntry {
                id: id.clone(),
                title: format!("{}, refined", entry.title.trim_end_matches(", refined")),
                technique: "model-checking",
                conditions: entry.conditions.clone(),
                assets: vec![("model", file.clone().into())],
                intermediate: place + 1 < steps.len(),
                changed: format!("{what}."),
                set_to: step.set_to.clone(),
                chosen: chosen.to_vec(),
            };
            entries.push_str(&new.text());
            applied.push(Applied {
                entry: Some(id.clone()),
                file: file.clone(),
                what,
            });
            ids.push(id);
            files.push(file);
        }
        append_to_ledger(self.study, &entries)?;
        Ok(applied)
    }
}

/// Puts entries behind those of the ledger.
pub fn append_to_ledger(study: &Study, entries: &str) -> Result<(), Problem> {
    let path = study.folder.join("ledger.toml");
    let mut text = host::files::read_source(&path)?.text;
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text.push_str(entries);
    write_text(&path, &text, &path)
}

fn refused(what: &str, reason: &str) -> Problem {
    Problem::new(
        "cannot-refine",
        format!("{} cannot be changed: {reason}", what.replace('_', " ")),
    )
    .remedy("accept the proposals one after the other, and look at each diff")
}
