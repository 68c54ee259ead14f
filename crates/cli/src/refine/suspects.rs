//! What is offered against the suspects of the diagnosis: forms by those of their sentences, a sound method first, a
//! smaller time step, names of a table exchanged.
//!
//! The suspects are those of `corroborate diagnose`, where one was made of the same evidence; else what the evidence
//! itself shows.

use super::proposal::{Change, Offered, Proposal};
use crate::problem::{Problem, Source};
use crate::study::{Study, Work};
use evidence::{Matter, StudyResult, Suspect, SuspectKind, rank};
use refinement::{FormChange, Ground, Offer, TextChange, unified};
use std::path::PathBuf;

/// What is offered for the suspects that are neither a formal model nor a simulation.
pub fn of_suspects(
    study: &Study,
    result: &StudyResult,
    offered: &mut Offered,
) -> Result<(), Problem> {
    let ground = Ground {
        evidence: &result.evidence,
        requirements: &study.requirements,
        failure_modes: &study.failure_modes,
        confidence: result.confidence,
    };
    for suspect in suspects(result) {
        if matches!(
            suspect.asset.kind,
            SuspectKind::FormalModel | SuspectKind::Simulation
        ) {
            continue;
        }
        let offers = ground.of_suspect(&suspect, &|_| None);
        for offer in offers.unwrap_or_default() {
            match offer {
                Offer::Form(change) => of_form(study, &suspect, change, offered),
                Offer::Text { evidence, change } => {
                    of_text(study, &suspect, &evidence, change, offered)?;
                }
                Offer::Model { .. } | Offer::Parameters { .. } => {}
            }
        }
    }
    Ok(())
}

fn suspects(result: &StudyResult) -> Vec<Suspect> {
    if let Some(diagnosis) = &result.diagnosis {
        return diagnosis.suspects.clone();
    }
    let matter = Matter {
        requirements: &result.requirements,
        failure_modes: &result.failure_modes,
        evidence: &result.evidence,
        comparisons: &result.comparisons,
        cells: &[],
        study: "",
    };
    rank(&matter, Vec::new())
}

fn of_form(study: &Study, suspect: &Suspect, change: FormChange, offered: &mut Offered) {
    let (requirement, form) = change.touches();
    let title = format!("requirement {requirement}: its {form} becomes that of its sentence");
    let text = &study.forms.source.text;
    match change.make(text) {
        Ok(changed) => {
            let diff = unified("requirements.toml", "requirements.toml", text, &changed);
            let note = "This decides what the requirement's text means: the sentence, not the form that is taken out.";
            offered.add(Proposal {
                title,
                file: "requirements.toml".into(),
                diff,
                notes: vec![note.into()],
                needs_decision: true,
                ..of(suspect, Change::Form(change.clone()))
            });
        }
        Err(reason) => offered.refused.push(format!("{title}: {reason}.")),
    }
}

fn of(suspect: &Suspect, change: Change) -> Proposal {
    Proposal {
        number: 0,
        suspect: None,
        title: String::new(),
        reason: format!("{}. {}", capital(&suspect.title), suspect.explanation),
        file: String::new(),
        diff: String::new(),
        effects: Vec::new(),
        notes: Vec::new(),
        needs_decision: false,
        change,
    }
}

fn capital(sentence: &str) -> String {
    let mut letters = sentence.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

fn of_text(
    study: &Study,
    suspect: &Suspect,
    evidence: &str,
    change: TextChange,
    offered: &mut Offered,
) -> Result<(), Problem> {
    let Some((file, change)) = place(study, evidence, change)? else {
        return Ok(());
    };
    let (title, needs_decision, note) = match &change {
        TextChange::Methods { first, .. } => (
            format!("{evidence}: the answer of `{first}` counts"),
            false,
            "Its bounds hold, so that no other method can be right where they differ.",
        ),
        TextChange::Step { divisor, .. } => (
            format!("{evidence}: a time step {divisor} times smaller"),
            false,
            "The number rests on an error that is proportional to the step; run `corroborate diagnose` again afterwards.",
        ),
        TextChange::Names { modes } => (
            format!(
                "{evidence}: `{}` and `{}` exchanged in its table",
                modes[0], modes[1]
            ),
            true,
            "Only who kept the table can tell: look at the original first.",
        ),
    };
    let shown = file.to_string_lossy().replace('\\', "/");
    let source = Source::read(&study.folder.join(&file))?;
    match change.make(&source.text) {
        Ok(changed) => offered.add(Proposal {
            title,
            diff: unified(&shown, &shown, &source.text, &changed),
            file: shown,
            notes: vec![note.into()],
            needs_decision,
            ..of(suspect, Change::Text { file, change })
        }),
        Err(reason) => offered.refused.push(format!("{title}: {reason}.")),
    }
    Ok(())
}

/// The file of a change, and how its place is named there; none where no file of the study has it.
fn place(
    study: &Study,
    evidence: &str,
    change: TextChange,
) -> Result<Option<(PathBuf, TextChange)>, Problem> {
    let work = &study.entry(evidence)?.work;
    Ok(match (change, work) {
        (change @ TextChange::Methods { .. }, _) => Some((PathBuf::from("ledger.toml"), change)),
        (TextChange::Step { key, divisor }, Work::Simulate { scenario, .. }) => {
            let key = key.strip_prefix("scenario.").unwrap_or(&key).to_owned();
            Some((scenario.clone(), TextChange::Step { key, divisor }))
        }
        (change @ TextChange::Step { .. }, Work::SimulateScene { scene, .. }) => {
            Some((scene.clone(), change))
        }
        (
            change @ TextChange::Names { .. },
            Work::Read {
                failure_modes: Some(file),
                ..
            },
        ) => Some((file.clone(), change)),
        _ => None,
    })
}
