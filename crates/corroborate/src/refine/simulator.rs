//! A simulation's parameters, fitted again to counts.
//!
//! The study says what may be fitted, within which ranges, in a calibration's
//! file; which failures disagree says whether it is to be done. What it gives is
//! known once it has run: hundreds of episodes.

use super::ledger_text::{Names, NewEntry, SetTo};
use super::proposal::{Change, Offered, Proposal};
use diagnostic::Problem;
use evidence::{Measure, StudyResult, Subject};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use study::{Entry, Simulated, Study};

/// A calibration that is to be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Recalibration {
    /// The entry whose parameters are fitted.
    pub entry: String,
    /// The calibration's file, relative to the study.
    pub file: PathBuf,
    /// The evidence that it is fitted to.
    pub from: String,
    /// What is fitted.
    pub fit: Vec<String>,
    /// The names of the parameters.
    pub parameters: Vec<String>,
    /// The fitted set's name.
    pub name: String,
}

/// What of a calibration's file is of interest here.
#[derive(Deserialize)]
struct Text {
    name: String,
    parameters: PathBuf,
    evidence: String,
    fit: Vec<String>,
    #[serde(rename = "parameter")]
    fitted: Vec<Named>,
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

/// What is offered for a simulation that is suspected for these failure modes.
pub fn of_simulator(
    study: &Study,
    result: &StudyResult,
    entry: &Entry,
    (suspect, disagrees): (Option<u32>, &[String]),
    offered: &mut Offered,
) -> Result<(), Problem> {
    let Some(parameters) = entry.work.simulated_parameters() else {
        return Ok(());
    };
    let Some((file, text)) = calibration(study, parameters)? else {
        offered.refused.push(format!(
            "{} of {}: no file of the study says which of {} may be fitted (`corroborate help calibrate`).",
            disagrees.join(", ").replace('_', " "),
            entry.id,
            parameters.display()
        ));
        return Ok(());
    };
    if let Some(mode) = disagrees.iter().find(|mode| text.fit.contains(mode)) {
        let subject = Subject::FailureMode(mode.clone());
        let reason = format!(
            "{} of {} disagrees with other evidence: {}.",
            disagrees.join(", ").replace('_', " "),
            entry.id,
            rates(result, &entry.id, &subject)
        );
        offered.add(proposal(entry, parameters, suspect, reason, file, text));
    }
    Ok(())
}

fn proposal(
    entry: &Entry,
    parameters: &Path,
    suspect: Option<u32>,
    reason: String,
    file: PathBuf,
    text: Text,
) -> Proposal {
    let names: Vec<String> = text.fitted.into_iter().map(|it| it.name).collect();
    let fit = text.fit.join(", ").replace('_', " ");
    Proposal {
        number: 0,
        suspect,
        title: format!(
            "{}: {} fitted to {}",
            entry.id,
            names.join(", "),
            text.evidence
        ),
        reason,
        file: parameters.display().to_string(),
        also: Vec::new(),
        chosen: Vec::new(),
        rivals: Vec::new(),
        diff: String::new(),
        effects: Vec::new(),
        tried: refinement::Trial::default(),
        notes: vec![
            format!(
                "`corroborate calibrate` is run on {}; the fitted values are known then.",
                file.display()
            ),
            format!(
                "From then on, agreement with {} on {fit} is a fit, not corroboration.",
                text.evidence
            ),
        ],
        needs_decision: false,
        change: Change::Recalibrate(Recalibration {
            entry: entry.id.clone(),
            file,
            from: text.evidence,
            fit: text.fit,
            parameters: names,
            name: text.name,
        }),
    }
}

fn rates(result: &StudyResult, id: &str, subject: &Subject) -> String {
    let counted = result.evidence.iter().filter_map(|piece| {
        let is_shown = piece.id == id || piece.technique.traits().is_counted_by_people;
        match piece.finding(subject)?.measure {
            Measure::Counts { count, trials, .. } if trials > 0 && is_shown => {
                Some(format!("{count} of {trials} in {}", piece.id))
            }
            _ => None,
        }
    });
    counted.collect::<Vec<_>>().join(", ")
}

/// The study's calibration of a parameter set.
fn calibration(study: &Study, parameters: &Path) -> Result<Option<(PathBuf, Text)>, Problem> {
    let fail = |error: std::io::Error| Problem::cannot_read(&study.folder, &error);
    let entries = std::fs::read_dir(&study.folder).map_err(fail)?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(PathBuf::from(entry.ok()?.file_name())))
        .filter(|file| file.extension().is_some_and(|it| it == "toml"))
        .collect();
    files.sort();
    for file in files {
        let source = host::files::read_source(&study.folder.join(&file))?;
        if let Ok(text) = toml::from_str::<Text>(&source.text)
            && text.parameters == parameters
        {
            return Ok(Some((file, text)));
        }
    }
    Ok(None)
}

impl Recalibration {
    /// The file of the fitted parameters, beside the old ones.
    pub fn target(&self, study: &Study, entry: &Entry) -> String {
        let Some(parameters) = entry.work.simulated_parameters() else {
            return format!("{}.toml", self.name);
        };
        let file = parameters.with_file_name(format!("{}.toml", self.name));
        let shown = file.to_string_lossy().replace('\\', "/");
        match study.folder.join(&file).exists() {
            true => Names::free_model(&study.folder, &file, &[]),
            false => shown,
        }
    }

    /// The entry that simulates with them, as many episodes as before unless told otherwise.
    pub fn new_entry(
        &self,
        entry: &Entry,
        id: String,
        target: &str,
        episodes: Option<u64>,
    ) -> NewEntry {
        let mut assets = Vec::new();
        if let Some(Simulated::Handover { scenario, .. }) = entry.work.simulated() {
            let episodes = episodes.unwrap_or_else(|| entry.work.episodes());
            let scenario = scenario.to_string_lossy().replace('\\', "/");
            assets.push(("scenario", scenario.into()));
            assets.push(("parameters", target.into()));
            assets.push(("episodes", i64::try_from(episodes).unwrap_or(100).into()));
        }
        let all = self.parameters.join(", ");
        // What is not fitted again rests on what it was set to.
        let mut set_to = SetTo::of(entry);
        set_to.retain(|old| {
            let mut names = old.name.split(", ");
            names.any(|name| !self.parameters.iter().any(|it| it == name))
        });
        set_to.extend(self.fit.iter().map(|mode| SetTo {
            key: "parameter",
            name: all.clone(),
            from: self.from.clone(),
            subject: Subject::FailureMode(mode.clone()),
            held: false,
            is_complement: false,
        }));
        NewEntry {
            id,
            title: format!("{}, fitted", entry.title),
            technique: "simulation",
            conditions: entry.conditions.clone(),
            assets,
            intermediate: false,
            changed: format!(
                "Of the simulation of {}, {all} are fitted to {}.",
                entry.id, self.from
            ),
            set_to,
            chosen: entry.chosen.clone(),
        }
    }
}
