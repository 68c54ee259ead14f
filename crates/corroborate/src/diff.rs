//! Two results of a study compared: what an edit made stale, what stands, what changed beyond chance, what got cheaper.
//!
//! # Definition
//! A piece of evidence *stands* if the hash of all that it depends on is the same in both results; else it was made stale and
//! produced again. A rate of evidence that was produced again *changed beyond chance* if the hypothesis that it is the same is rejected at the
//! study's confidence, by the test by which the study compares two pieces of evidence ([`evidence::compare`]), with Holm's correction
//! for all rates that are compared here.
//!
//! # Assumes
//! The trials of the two results are independent. Where they share seeds or the earlier trials are among the later ones, their
//! outcomes go together, and the test rejects more seldom than it may.
//!
//! # Guarantee
//! The probability that any rate is said to have changed beyond chance that did not is at most one minus the confidence, as far as the
//! tests of [`evidence::compare`] keep theirs. Costs are as they were measured, and times vary from run to run.

use crate::outcome::{Ended, Outcome};
use crate::results::{RESULT, read_result_file};
use diagnostic::Problem;
use evidence::{
    Conclusion, Direction, Evidence, Influences, Levels, Requirement, StudyResult, Subject,
    Verdict, compare,
};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Two results to be compared.
#[derive(Clone, Debug)]
pub struct DiffRequest {
    /// The earlier one: a folder of results, a study that has been run, or the file of a result.
    pub old: PathBuf,
    /// The later one.
    pub new: PathBuf,
}

/// What became of a piece of evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// All that it depends on is the same.
    Stands,
    /// It was made stale and produced again.
    ProducedAgain,
    /// It is new.
    New,
    /// It is gone.
    Gone,
}

/// A file on which evidence rests, and what became of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FileChange {
    /// Its path in the study.
    pub path: String,
    /// `changed`, `added` or `removed`.
    pub change: String,
}

/// A piece of evidence in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct EvidenceChange {
    /// Its identifier.
    pub id: String,
    /// Its title.
    pub title: String,
    /// What became of it.
    pub fate: Fate,
    /// Files that are not the same, of what was produced again. None of them means other settings, other counts that its constants were set to,
    /// or another build.
    pub files: Vec<FileChange>,
}

/// A requirement's verdict in both results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct VerdictChange {
    /// The requirement.
    pub requirement: String,
    /// The verdict before with the step on which it stood; `None` if it was not concluded.
    pub before: Option<String>,
    /// The verdict now.
    pub after: Option<String>,
    /// Whether it is another one.
    pub changed: bool,
    /// Whether it got worse: it was satisfied on a step that is enough and is not, or it is violated or of conflicting evidence and was
    /// not.
    pub worse: bool,
    /// What is concluded now, in words.
    pub statement: String,
}

/// A requirement that has another identifier now: none of the two results has both, and the text is the same and no other's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Renamed {
    /// Its identifier before.
    pub before: String,
    /// Its identifier now, by which everything else here names it.
    pub after: String,
}

/// What a requirement asks for in both results, where that is not the same: its verdicts are then answers to two questions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct AskedChange {
    /// The requirement.
    pub requirement: String,
    /// What it asked for: its threshold, and the margin within which rates agree.
    pub before: String,
    /// What it asks for now.
    pub after: String,
}

/// A rate of evidence that was produced again.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RateChange {
    /// The evidence.
    pub evidence: String,
    /// What the rate is of.
    pub subject: Subject,
    /// The rate before.
    pub before: f64,
    /// The rate now.
    pub after: f64,
    /// The p-value of the rate being the same.
    pub p: f64,
    /// The same, corrected for all rates that are compared.
    pub p_corrected: f64,
    /// Whether it changed beyond chance.
    pub beyond_chance: bool,
    /// Whether it changed by more than the study's margin, within which two rates count as agreeing: the smaller one, if that was
    /// changed, too.
    pub beyond_margin: bool,
    /// Whether the change is for the worse: fewer runs satisfy a requirement, or a failure occurs more often.
    pub worse: bool,
}

/// A cost in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CostChange {
    /// The evidence.
    pub evidence: String,
    /// What is counted: `processor seconds`, `seconds`, `states`.
    pub of: String,
    /// Before.
    pub before: f64,
    /// Now.
    pub after: f64,
}

/// What differs between two results of a study.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DiffReport {
    /// The form of this report; what begins with the same number can be read alike.
    pub format: String,
    /// The study's title, in the later result.
    pub title: String,
    /// The level at which a change is said to be beyond chance.
    pub confidence: f64,
    /// Every piece of evidence of either.
    pub evidence: Vec<EvidenceChange>,
    /// Requirements that have another identifier now.
    pub renamed: Vec<Renamed>,
    /// Every requirement of either.
    pub verdicts: Vec<VerdictChange>,
    /// Requirements of both that do not ask for the same.
    pub asked: Vec<AskedChange>,
    /// The rates that could be compared, of evidence that was produced again.
    pub rates: Vec<RateChange>,
    /// Costs of evidence that was produced again.
    pub costs: Vec<CostChange>,
}

/// Compares two results of a study. Neither has to be of the files that the study has now.
///
/// # Errors
/// `not-run` where there is no result, `bad-result` for one that cannot be read.
pub fn diff(request: &DiffRequest) -> Result<DiffReport, Problem> {
    let [old, new] = [&request.old, &request.new].map(|path| read_result_file(&file_of(path)));
    let (mut old, new) = (old?, new?);
    let renamed = renamed(&old, &new);
    renamed.iter().for_each(|it| rename(&mut old, it));
    let evidence = evidence_changes(&old, &new);
    let again: Vec<(&Evidence, &Evidence)> = (evidence.iter())
        .filter(|it| it.fate == Fate::ProducedAgain)
        .filter_map(|it| Some((piece(&old, &it.id)?, piece(&new, &it.id)?)))
        .collect();
    Ok(DiffReport {
        format: "1.1".into(),
        renamed,
        title: new.title.clone(),
        confidence: new.confidence,
        verdicts: verdict_changes(&old, &new),
        asked: asked_changes(&old, &new),
        rates: rate_changes(&old, &new, &again)?,
        costs: cost_changes(&old, &new, &again),
        evidence,
    })
}

/// Requirements that only one of the results has, with one and the same text.
fn renamed(old: &StudyResult, new: &StudyResult) -> Vec<Renamed> {
    let only = |of: &StudyResult, other: &StudyResult| -> Vec<Requirement> {
        let is_new = |it: &&Requirement| other.requirements.iter().all(|known| known.id != it.id);
        of.requirements.iter().filter(is_new).cloned().collect()
    };
    let (gone, come) = (only(old, new), only(new, old));
    let of_text = |all: &[Requirement], text: &str| -> Option<String> {
        let mut found = all.iter().filter(|it| it.text == text);
        let first = found.next()?;
        found.next().is_none().then(|| first.id.clone())
    };
    let pairs = come.iter().filter_map(|it| {
        let (before, after) = (of_text(&gone, &it.text)?, of_text(&come, &it.text)?);
        Some(Renamed { before, after })
    });
    pairs.collect()
}

/// The earlier result with the requirement's present identifier.
fn rename(result: &mut StudyResult, renamed: &Renamed) {
    let set = |id: &mut String| {
        if *id == renamed.before {
            id.clone_from(&renamed.after);
        }
    };
    let requirements = result.requirements.iter_mut().map(|it| &mut it.id);
    let conclusions = result.conclusions.iter_mut().map(|it| &mut it.requirement);
    requirements.chain(conclusions).for_each(set);
    let findings = result.evidence.iter_mut();
    for finding in findings.flat_map(|it| &mut it.findings) {
        if let Subject::Requirement(id) = &mut finding.subject {
            set(id);
        }
    }
}

/// The file of a result, if this is a folder of results or a study that has been run.
fn file_of(path: &Path) -> PathBuf {
    let places = [path.join(RESULT), path.join("results").join(RESULT)];
    match path.is_dir() {
        true => places
            .iter()
            .find(|it| it.exists())
            .unwrap_or(&places[0])
            .clone(),
        false => path.to_owned(),
    }
}

fn piece<'a>(result: &'a StudyResult, id: &str) -> Option<&'a Evidence> {
    result.evidence.iter().find(|it| it.id == id)
}

/// Those of the later result in its order, then those that are gone.
fn evidence_changes(old: &StudyResult, new: &StudyResult) -> Vec<EvidenceChange> {
    let now = new.evidence.iter().map(|it| {
        let before = piece(old, &it.id);
        let fate = match before {
            None => Fate::New,
            Some(before) if before.inputs == it.inputs => Fate::Stands,
            Some(_) => Fate::ProducedAgain,
        };
        change(
            it,
            fate,
            before.map_or(Vec::new(), |before| files(before, it)),
        )
    });
    let gone = old
        .evidence
        .iter()
        .filter(|it| piece(new, &it.id).is_none());
    let gone = gone.map(|it| change(it, Fate::Gone, Vec::new()));
    now.chain(gone).collect()
}

fn change(piece: &Evidence, fate: Fate, files: Vec<FileChange>) -> EvidenceChange {
    EvidenceChange {
        id: piece.id.clone(),
        title: piece.title.clone(),
        files: match fate {
            Fate::ProducedAgain => files,
            Fate::Stands | Fate::New | Fate::Gone => Vec::new(),
        },
        fate,
    }
}

/// The files that are not the same.
fn files(before: &Evidence, after: &Evidence) -> Vec<FileChange> {
    let hashes = |piece: &Evidence| -> BTreeMap<String, String> {
        let assets = piece.assets.iter();
        assets
            .map(|it| (it.path.clone(), it.hash.clone()))
            .collect()
    };
    let (before, after) = (hashes(before), hashes(after));
    let mut paths: Vec<&String> = before.keys().chain(after.keys()).collect();
    paths.sort();
    paths.dedup();
    let changes = paths.into_iter().filter_map(|path| {
        let change = match (before.get(path), after.get(path)) {
            (Some(old), Some(new)) if old == new => return None,
            (Some(_), Some(_)) => "changed",
            (None, _) => "added",
            (_, None) => "removed",
        };
        Some(FileChange {
            path: path.clone(),
            change: change.to_owned(),
        })
    });
    changes.collect()
}

fn verdict_changes(old: &StudyResult, new: &StudyResult) -> Vec<VerdictChange> {
    let of = |result: &StudyResult, id: &str| -> Option<Conclusion> {
        let found = result.conclusions.iter().find(|it| it.requirement == id);
        found.cloned()
    };
    let mut ids: Vec<&str> = new.requirements.iter().map(|it| it.id.as_str()).collect();
    for requirement in &old.requirements {
        if !ids.contains(&requirement.id.as_str()) {
            ids.push(&requirement.id);
        }
    }
    let changes = ids.into_iter().map(|id| {
        let (before, after) = (of(old, id), of(new, id));
        let words = |it: &Option<Conclusion>| it.as_ref().map(in_words);
        VerdictChange {
            requirement: id.to_owned(),
            changed: words(&before) != words(&after),
            worse: is_worse(before.as_ref(), after.as_ref()),
            before: words(&before),
            after: words(&after),
            statement: after.map_or_else(String::new, |it| it.statement),
        }
    });
    changes.collect()
}

/// The verdict with its step, as reports have it.
fn in_words(conclusion: &Conclusion) -> String {
    match conclusion.step {
        Some(step) => format!("{} {}", conclusion.verdict.words(), step.words()),
        None => conclusion.verdict.words().to_owned(),
    }
}

fn is_worse(before: Option<&Conclusion>, after: Option<&Conclusion>) -> bool {
    let is_enough = |it: Option<&Conclusion>| it.is_some_and(Conclusion::is_enough);
    let is_bad = |it: Option<&Conclusion>| {
        it.is_some_and(|it| matches!(it.verdict, Verdict::Violated | Verdict::Conflicting))
    };
    (is_enough(before) && !is_enough(after)) || (is_bad(after) && !is_bad(before))
}

fn asked_changes(old: &StudyResult, new: &StudyResult) -> Vec<AskedChange> {
    let changes = new.requirements.iter().filter_map(|now| {
        let before = old.requirements.iter().find(|it| it.id == now.id)?;
        let (before, after) = (asked(before), asked(now));
        (before != after).then(|| AskedChange {
            requirement: now.id.clone(),
            before,
            after,
        })
    });
    changes.collect()
}

/// The threshold and the margin of a requirement in words.
fn asked(requirement: &Requirement) -> String {
    let threshold = match requirement.threshold {
        None => "certainty".to_owned(),
        Some(it) => match it.direction {
            Direction::AtLeast => format!("at least {}", it.value),
            Direction::AtMost => format!("at most {}", it.value),
        },
    };
    format!("{threshold}, margin {}", requirement.margin)
}

/// The margin within which rates of a subject agree.
fn margin(result: &StudyResult, subject: &Subject) -> Option<f64> {
    match subject {
        Subject::Requirement(id) => {
            let found = result.requirements.iter().find(|it| &it.id == id);
            found.map(|it| it.margin)
        }
        Subject::FailureMode(id) => {
            let found = result.failure_modes.iter().find(|it| &it.id == id);
            found.map(|it| it.margin)
        }
    }
}

/// Each pair is a study of its own, in which nothing is known of where the two come from; the correction is over all of them.
fn rate_changes(
    old_result: &StudyResult,
    new: &StudyResult,
    again: &[(&Evidence, &Evidence)],
) -> Result<Vec<RateChange>, Problem> {
    let bad = |error: stats::StatsError| Problem::new("bad-result", error.to_string());
    let levels = Levels::new(new.confidence, new.confidence).map_err(bad)?;
    let mut changes = Vec::new();
    for (before, after) in again {
        let pieces = [alone(before, "before"), alone(after, "after")];
        let influences = Influences::learn(&[]);
        let compared = compare(&evidence::Study {
            requirements: &new.requirements,
            failure_modes: &new.failure_modes,
            evidence: &pieces,
            influences: &influences,
            levels,
            looks: None,
        });
        for it in compared {
            let rate = |piece: &Evidence| piece.finding(&it.subject)?.measure.estimate();
            let (Some(p), Some(old), Some(now)) = (it.p_difference, rate(before), rate(after))
            else {
                continue;
            };
            let margin =
                margin(old_result, &it.subject).map_or(it.margin, |old| old.min(it.margin));
            changes.push(RateChange {
                evidence: after.id.clone(),
                worse: match it.subject {
                    Subject::Requirement(_) => now < old,
                    Subject::FailureMode(_) => now > old,
                },
                subject: it.subject,
                before: old,
                after: now,
                p,
                p_corrected: p,
                beyond_chance: false,
                beyond_margin: (now - old).abs() > margin,
            });
        }
    }
    let all: Vec<f64> = changes.iter().map(|it| it.p).collect();
    for (change, corrected) in changes.iter_mut().zip(stats::holm(&all)) {
        change.p_corrected = corrected;
        change.beyond_chance = corrected <= 1.0 - new.confidence;
    }
    Ok(changes)
}

/// A piece under a name of its own, with nothing of where it comes from: the two are taken for independent.
fn alone(piece: &Evidence, name: &str) -> Evidence {
    Evidence {
        id: name.to_owned(),
        conditions: String::new(),
        calibrated: Vec::new(),
        intermediate: false,
        reproduced_by: None,
        shared_rows: Vec::new(),
        common_texts: Vec::new(),
        shared_seeds: Vec::new(),
        lineage_questions: Vec::new(),
        ..piece.clone()
    }
}

fn cost_changes(
    old: &StudyResult,
    new: &StudyResult,
    again: &[(&Evidence, &Evidence)],
) -> Vec<CostChange> {
    let mut changes = Vec::new();
    for (_, after) in again {
        let cost = |result: &StudyResult| {
            let found = result.costs.iter().find(|it| it.evidence == after.id);
            found.cloned()
        };
        let (Some(before), Some(now)) = (cost(old), cost(new)) else {
            continue;
        };
        let mut push = |of: &str, pair: Option<(f64, f64)>| {
            changes.extend(pair.map(|(before, now)| CostChange {
                evidence: after.id.clone(),
                of: of.to_owned(),
                before,
                after: now,
            }));
        };
        push("seconds", Some((before.wall_secs, now.wall_secs)));
        push("processor seconds", before.cpu_secs.zip(now.cpu_secs));
        let states = before.states.zip(now.states);
        push(
            "states",
            states.map(|(before, now)| (before as f64, now as f64)),
        );
    }
    changes
}

impl Ended for DiffReport {
    /// Whether a verdict got worse, or a rate did beyond chance and beyond the margin.
    fn outcome(&self) -> Outcome {
        let verdict = self.verdicts.iter().any(|it| it.worse);
        let is_bad = |it: &RateChange| it.worse && it.beyond_chance && it.beyond_margin;
        let rate = self.rates.iter().any(is_bad);
        match verdict || rate {
            true => Outcome::Violated,
            false => Outcome::Holds,
        }
    }
}
