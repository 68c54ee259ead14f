//! The program run on generated studies, as a user would run it, and what it says held against what was planted.
//!
//! # Definition
//! For each study: `run`, `diagnose`, `refine`, and where the first proposal changes a file in which the fault can be
//! fixed, `refine --accept` in a copy.
//!
//! * *Found*: a conflict, or an open suspect with a score of 1 or more, on a subject that the fault touches.
//! * *First suspect right*: the first open suspect, the one that `diagnose` prints first, is a culprit and touches one of
//!   these subjects. *Strongly so*: and its score is 1 or more. A conflict that is shown by little data is shared out
//!   between the pieces that differ, so that none of them need reach that.
//! * *Repaired*: the first proposal changes such a file, at a line that can fix it, and afterwards no suspect with a
//!   score of 1 or more is open on these subjects.
//! * *Harmful*: a proposal that changes a text in which nothing is wrong; or one that moves a value of the model further
//!   from the truth than it was, by more than 2 points, and to more than the margin of 5 points from it. It is
//!   *unwarned* if it has no note, breaks nothing by its own words, and needs no decision.
//! * *False alarm*: a conflict in a study in which nothing is wrong, or an open suspect with a score of 2 or more.
//! * A study that the program *refuses* is found if the message names a file in which the fault is.

use super::catalogue::Generated;
use super::plant::Plant;
use super::write::write;
use evidence::STRONG;
use rayon::prelude::*;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the program made of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The message with which it refused the study.
    pub refused: Option<String>,
    /// Pairs that conflict, as `subject: left-right`.
    pub conflicts: Vec<String>,
    /// Open suspects, the first first.
    pub suspects: Vec<Suspected>,
    /// Whether the fault was found.
    pub found: bool,
    /// Whether the first suspect is right.
    pub is_first_right: bool,
    /// Whether it is, with a score of 1 or more.
    pub is_first_strong: bool,
    /// The first proposal's headline.
    pub offered: Option<String>,
    /// Whether the first proposal repairs the study.
    pub is_repaired: bool,
    /// Harmful proposals without a warning.
    pub harmful: Vec<String>,
}

/// An open suspect.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspected {
    /// The kind of asset.
    pub kind: String,
    /// Its file and part.
    pub place: String,
    /// The subjects.
    pub subjects: Vec<String>,
    /// The score.
    pub score: f64,
}

impl Outcome {
    /// Whether something is held to be wrong.
    #[must_use]
    pub fn is_alarm(&self) -> bool {
        self.refused.is_some()
            || !self.conflicts.is_empty()
            || self.suspects.iter().any(|it| it.score >= 2.0)
    }

    /// A line on what was missed, if anything was.
    #[must_use]
    pub fn missed(&self, study: &Generated) -> Option<String> {
        let planted = &study.planted;
        let is_sound = planted.plant == Plant::Nothing;
        let repairable = !planted.mended_in.is_empty();
        let fine = match is_sound {
            true => !self.is_alarm() && self.harmful.is_empty(),
            false => {
                self.is_first_right && (self.is_repaired || !repairable) && self.harmful.is_empty()
            }
        };
        let first = self.suspects.first().map_or("no suspect".to_owned(), |it| {
            format!(
                "{} {} on {} ({:.1})",
                it.kind,
                it.place,
                it.subjects.join(" "),
                it.score
            )
        });
        (!fine).then(|| {
            format!(
                "{} {} (power {:.2}; {}): {}{}{}; first {first}; offered {}{}{}",
                study.name,
                planted.plant.name(),
                planted.power,
                planted.words,
                if self.found { "found" } else { "not found" },
                if self.is_first_right { ", located" } else { "" },
                if self.is_repaired { ", repaired" } else { "" },
                self.offered.as_deref().unwrap_or("nothing"),
                if self.harmful.is_empty() {
                    String::new()
                } else {
                    format!("; harmful: {}", self.harmful.join(", "))
                },
                self.refused
                    .as_ref()
                    .map_or(String::new(), |text| format!("; refused: {text}")),
            )
        })
    }
}

/// Runs the program on all studies, whose folders are made in `folder`.
///
/// # Errors
/// What could not be written or started.
pub fn all(
    studies: &[Generated],
    program: &Path,
    folder: &Path,
    tell: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<Outcome>, String> {
    let done = AtomicUsize::new(0);
    let one = |study: &Generated| {
        let outcome = judge(study, program, folder);
        tell(done.fetch_add(1, Ordering::Relaxed) + 1, studies.len());
        outcome
    };
    studies.par_iter().map(one).collect()
}

/// What a call of the program gave.
struct Said {
    code: i32,
    out: String,
    talk: String,
}

fn call(program: &Path, words: &[&str]) -> Result<Said, String> {
    let output = Command::new(program)
        .args(words)
        // The studies are made here, and what they name was written with them.
        .arg("--trust")
        .output()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    Ok(Said {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        talk: String::from_utf8_lossy(&output.stderr).into_owned(),
    })
}

/// Runs the program on one study.
///
/// # Errors
/// What could not be written or started, or an answer that is not the JSON that was asked for.
pub fn judge(study: &Generated, program: &Path, folder: &Path) -> Result<Outcome, String> {
    let own = folder.join(&study.name);
    write(study, &own)?;
    let path = own.to_string_lossy();
    let mut outcome = Outcome::default();
    let said = call(program, &["run", &path, "--quiet", "-j", "1"])?;
    if is_refusal(said.code) {
        return Ok(refused(study, &said));
    }
    let result = own.join("results").join("study.json");
    let result = trace::read_text(&result).map_err(|error| error.to_string())?;
    outcome.conflicts = conflicts(&parsed(&study.name, &result)?);
    let said = call(
        program,
        &[
            "diagnose", &path, "--format", "json", "--paths", "400", "-j", "1",
        ],
    )?;
    if is_refusal(said.code) {
        return Ok(refused(study, &said));
    }
    outcome.suspects = suspects(&parsed(&study.name, &said.out)?);
    let touches = |subject: &String| study.planted.subjects.contains(subject);
    outcome.found = outcome
        .conflicts
        .iter()
        .any(|it| touches(&it.split(':').next().unwrap_or("").to_owned()))
        || outcome
            .suspects
            .iter()
            .any(|it| it.score >= STRONG && it.subjects.iter().any(touches));
    let is_right = |first: &&Suspected| {
        let named =
            |it: &super::plant::Culprit| it.kind == first.kind && first.place.contains(&it.names);
        study.planted.culprits.iter().any(named) && first.subjects.iter().any(touches)
    };
    let right = outcome.suspects.first().filter(is_right);
    (outcome.is_first_right, outcome.is_first_strong) =
        (right.is_some(), right.is_some_and(|it| it.score >= STRONG));
    let said = call(program, &["refine", &path, "--format", "json", "-j", "1"])?;
    if is_refusal(said.code) {
        outcome.offered = Some(format!("refine refused: {}", first_line(&said.talk)));
        return Ok(outcome);
    }
    let offers = parsed(&study.name, &said.out)?;
    let offers = offers["proposals"].as_array().cloned().unwrap_or_default();
    outcome.harmful = offers
        .iter()
        .filter(|offer| is_harmful(study, offer))
        .map(title)
        .collect();
    if let Some(first) = offers.first() {
        outcome.offered = Some(title(first));
        if is_in_place(study, first) {
            outcome.is_repaired = repairs(study, program, &path, first)?;
        }
    }
    Ok(outcome)
}

fn is_refusal(code: i32) -> bool {
    code == 2 || !(0..=100).contains(&code)
}

fn first_line(talk: &str) -> String {
    talk.lines()
        .find(|line| line.starts_with("error"))
        .unwrap_or("no message")
        .to_owned()
}

fn refused(study: &Generated, said: &Said) -> Outcome {
    let is_named = !study.planted.mended_in.is_empty()
        && study
            .planted
            .mended_in
            .iter()
            .any(|file| said.talk.contains(file));
    Outcome {
        refused: Some(first_line(&said.talk)),
        found: is_named,
        is_first_right: is_named,
        is_first_strong: is_named,
        ..Outcome::default()
    }
}

fn parsed(name: &str, text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("{name}: {error}"))
}

fn texts(value: &Value) -> Vec<String> {
    let all = value.as_array().into_iter().flatten();
    all.filter_map(|it| Some(it["id"].as_str()?.to_owned()))
        .collect()
}

fn conflicts(result: &Value) -> Vec<String> {
    let all = result["comparisons"].as_array().into_iter().flatten();
    let conflicting = all.filter(|it| it["outcome"] == "conflicts");
    conflicting
        .map(|it| {
            let text = |key: &str| it[key].as_str().unwrap_or("").to_owned();
            format!(
                "{}:{}-{}",
                it["subject"]["id"].as_str().unwrap_or(""),
                text("left"),
                text("right")
            )
        })
        .collect()
}

fn suspects(diagnosis: &Value) -> Vec<Suspected> {
    let all = diagnosis["suspects"].as_array().into_iter().flatten();
    let open = all.filter(|it| it["resolved_by"].is_null());
    let read = open.map(|it| {
        let asset = &it["asset"];
        let text = |key: &str| asset[key].as_str().unwrap_or("").to_owned();
        Suspected {
            kind: text("kind"),
            place: format!("{} {}", text("file"), text("part")),
            subjects: texts(&it["subjects"]),
            score: it["score"].as_f64().unwrap_or(0.0),
        }
    });
    read.collect()
}

fn title(offer: &Value) -> String {
    offer["title"].as_str().unwrap_or("").to_owned()
}

/// Whether a proposal changes a file in which the fault can be fixed, at a line that can fix it.
fn is_in_place(study: &Generated, offer: &Value) -> bool {
    let file = offer["file"].as_str().unwrap_or("");
    let diff = offer["diff"].as_str().unwrap_or("");
    let mut changed = diff.lines().filter(|line| line.starts_with(['+', '-']));
    study
        .planted
        .mended_in
        .iter()
        .any(|name| file.ends_with(name))
        && (study.planted.mended_by.is_empty()
            || diff.is_empty()
            || changed.any(|line| line.contains(&study.planted.mended_by)))
}

/// The true value of a subject that the model has.
fn truth(study: &Generated, subject: &str) -> Option<f64> {
    let machine = &study.draft.truth;
    match machine.mode(subject) {
        Some(mode) => machine.rate(mode),
        None => (subject == super::files::ids::DONE).then(|| machine.reaches(machine.done)),
    }
}

fn is_harmful(study: &Generated, offer: &Value) -> bool {
    let any = |key: &str| offer[key].as_array().is_some_and(|all| !all.is_empty());
    let is_warned = any("notes") || any("breaks") || offer["needs_decision"] == true;
    let file = offer["file"].as_str().unwrap_or("");
    let is_model = file.ends_with(super::files::names::MODEL);
    let effects = offer["effects"].as_array().into_iter().flatten();
    let mut worse = effects.filter_map(|effect| {
        let right = truth(study, effect["subject"]["id"].as_str()?)?;
        let (before, after) = (effect["before"].as_f64()?, effect["after"].as_f64()?);
        let (was, is) = ((before - right).abs(), (after - right).abs());
        Some(is > was + 0.02 && is > 0.05)
    });
    let elsewhere = !is_model
        && !study
            .planted
            .mended_in
            .iter()
            .any(|name| file.ends_with(name));
    !is_warned && (elsewhere || worse.any(|it| it))
}

/// Whether the study is repaired by its first proposal.
fn repairs(study: &Generated, program: &Path, path: &str, offer: &Value) -> Result<bool, String> {
    let number = offer["number"].as_u64().unwrap_or(1).to_string();
    let to = format!("{path}-repaired");
    let said = call(
        program,
        &[
            "refine", path, "--accept", &number, "--to", &to, "--format", "json", "-j", "1",
        ],
    )?;
    if is_refusal(said.code) {
        return Ok(false);
    }
    // What `refine` leaves open has no subjects, so the copy is asked.
    let said = call(
        program,
        &[
            "diagnose", &to, "--format", "json", "--paths", "400", "-j", "1",
        ],
    )?;
    if is_refusal(said.code) {
        return Ok(false);
    }
    let left = suspects(&parsed(&study.name, &said.out)?);
    let touches = |subject: &String| study.planted.subjects.contains(subject);
    let mut strong = left.iter().filter(|it| it.score >= STRONG);
    Ok(!strong.any(|it| it.subjects.iter().any(touches)))
}
