//! What is offered against the suspects, in their order, and the rest of what the models' failures ask for.
//!
//! The suspects are those of `corroborate diagnose`, where one was made of the same evidence; else what the evidence
//! itself shows. Only current evidence is changed: what later evidence of the technique replaced stays as it is.

use super::command::of_command;
use super::exchange::{Mixed, of_columns, of_entries, of_exchange};
use super::forms::of_forms;
use super::one_value::OneValue;
use super::proposal::{
    Asset, Change, Fitted, Offered, Proposal, asked, current, ground, is_simulated, model_proposal,
    states_of, words,
};
use super::simulator::of_simulator;
use super::solver::Solver;
use super::texts;
use super::trees::of_tree;
use crate::technique::matrix::edits::scratch::Scratch;
use diagnostic::Problem;
use evidence::{STRONG, StudyResult, Subject, Suspect, Symptom};
use host::Host;
use refinement::{FormChange, Model, Offer, Ranked, TextChange, Trial, unified};
use std::path::{Path, PathBuf};
use study::{Simulated, Study};

/// All that is offered for a study's result, without what one offer means for another (`finish` of [`Offered`]).
pub fn offered(
    study: &Study,
    result: &StudyResult,
    solver: &Solver,
    host: &Host,
) -> Result<Offered, Problem> {
    let mut sources = Vec::new();
    for entry in current(study, &result.evidence) {
        if let Some(model) = entry.work.model() {
            let source = texts::read(study, model)?;
            sources.push((entry, model, source.text, solver.at(model)));
        }
    }
    let (asked, words) = (asked(study), words(study));
    let models = sources.iter().map(|(entry, _, text, solver)| Model {
        evidence: &entry.id,
        text,
        asked: &asked,
        words: &words,
        solver,
        states: states_of(result, &entry.id),
    });
    let models: Vec<Model<'_>> = models.collect();
    let assets = sources
        .iter()
        .map(|(entry, path, text, _)| Asset { entry, path, text });
    let assets: Vec<Asset<'_>> = assets.collect();
    let simulations = current(study, &result.evidence)
        .into_iter()
        .filter(|entry| is_simulated(entry));
    let simulations: Vec<&str> = simulations.map(|entry| entry.id.as_str()).collect();
    let found = ground(study, result).against(result.suspected(), &models, &simulations);
    let found = found.map_err(|reason| solver.problem(reason))?;
    let mut offering = Offering {
        study,
        result,
        solver,
        assets,
        offered: Offered::default(),
    };
    let mut edits: Vec<&Suspect> = result.suspected().iter().filter(|s| s.is_open()).collect();
    for ranked in found.ranked {
        // What a suspect's own text should say comes before what else is offered for it.
        let rank = match ranked.is_harmful() {
            true => None,
            false => ranked.suspect,
        };
        let until = edits.partition_point(|s| rank.is_none_or(|rank| s.rank <= rank));
        for suspect in edits.drain(..until) {
            of_values(study, suspect, &mut offering.offered)?;
            of_tree((study, result), suspect, host, &mut offering.offered)?;
        }
        offering.add(ranked)?;
    }
    for suspect in edits {
        of_values(study, suspect, &mut offering.offered)?;
        of_tree((study, result), suspect, host, &mut offering.offered)?;
    }
    let mut offered = offering.offered;
    offered.refused.extend(found.refused);
    if result.diagnosis.is_none() && result.suspected().iter().any(Suspect::is_open) {
        offered.refused.push(UNDIAGNOSED.to_owned());
    }
    of_forms(study, result, &mut offered);
    offered.in_order(result.suspected());
    Ok(offered)
}

/// What is not offered before a diagnosis.
const UNDIAGNOSED: &str = "Words, limits, columns, bindings, forms, units and branches: `corroborate diagnose` tries them, and has not been run on \
                           these results.";

/// Offers on their way to proposals.
struct Offering<'a> {
    study: &'a Study,
    result: &'a StudyResult,
    solver: &'a Solver<'a>,
    assets: Vec<Asset<'a>>,
    offered: Offered,
}

impl Offering<'_> {
    fn add(&mut self, ranked: Ranked) -> Result<(), Problem> {
        let Ranked {
            suspect,
            offer,
            tried,
        } = ranked;
        let mut all = self.result.suspected().iter();
        let of = all.find(|it| Some(it.rank) == suspect);
        match (offer, of) {
            (
                Offer::Model {
                    evidence,
                    change,
                    changed,
                },
                _,
            ) => {
                let mut all = self.assets.iter();
                if let Some(asset) = all.find(|asset| asset.entry.id == evidence) {
                    let before = self.solver.values(asset.path, asset.text)?;
                    let change = (change, *changed);
                    let tried = tried.unwrap_or_default();
                    let ground = ground(self.study, self.result);
                    let left = ground.most_disagreement(&evidence, change.1.at_last());
                    let left = left.map(|(subject, left)| (subject.clone(), left));
                    let mut new =
                        model_proposal(self.result, asset, &before, (suspect, tried), change);
                    // Of several failures each is fixed by itself; a number that is fitted to a requirement, and a branch, have to explain all.
                    let left = left.filter(|(_, left)| {
                        *left > STRONG && (new.is_fitted() || new.is_structural())
                    });
                    if let Some((subject, _)) = left {
                        new.needs_decision = true;
                        new.notes.push(format!(
                            "The model still disagrees on {} then: what is wrong may lie elsewhere.",
                            subject.in_words()
                        ));
                    }
                    self.offered.add(new);
                }
            }
            (Offer::Form(change), Some(of)) => of_form(self.study, of, change, &mut self.offered),
            (Offer::Text { evidence, change }, Some(of)) => {
                of_text(self.study, of, &evidence, change, &mut self.offered)?;
            }
            (Offer::Parameters { evidence, counts }, _) => {
                let mut all = current(self.study, &self.result.evidence).into_iter();
                if let Some(entry) = all.find(|entry| entry.id == evidence) {
                    let modes: Vec<String> = counts.into_iter().map(|(mode, _)| mode).collect();
                    if let Some(command) = entry.work.command() {
                        return of_command(
                            self.study,
                            self.result,
                            (entry, command),
                            (of, &modes),
                            &mut self.offered,
                        );
                    }
                    // A simulator of ours is fitted to ways of failing alone.
                    if modes.is_empty() {
                        return Ok(());
                    }
                    of_simulator(
                        self.study,
                        self.result,
                        entry,
                        (suspect, &modes),
                        &mut self.offered,
                    )?;
                }
            }
            (
                Offer::Exchange {
                    evidence,
                    modes,
                    is_whole,
                },
                Some(of),
            ) => {
                let mixed = Mixed {
                    evidence: &evidence,
                    modes: &modes,
                    is_whole,
                };
                of_exchange(self.study, of, &mixed, &mut self.offered)?;
            }
            (Offer::Columns { evidence, rows }, Some(of)) => {
                of_columns(self.study, of, (&evidence, &rows), &mut self.offered)?;
            }
            (Offer::Entries { evidence }, Some(of)) => {
                of_entries(self.study, of, &evidence, &mut self.offered)?;
            }
            (
                Offer::Form(_)
                | Offer::Text { .. }
                | Offer::Exchange { .. }
                | Offer::Entries { .. }
                | Offer::Columns { .. },
                None,
            ) => {}
        }
        Ok(())
    }
}

/// The values that would make other evidence agree, where single edits explain what is held against a suspect.
fn of_values(study: &Study, suspect: &Suspect, offered: &mut Offered) -> Result<(), Problem> {
    let (Some(file), Some(line)) = (&suspect.asset.file, suspect.asset.line) else {
        return Ok(());
    };
    let source = texts::read(study, Path::new(file))?;
    let mut known: Vec<OneValue> = Vec::new();
    for symptom in &suspect.symptoms {
        let Symptom::EditExplains {
            found,
            instead,
            subject,
            pairs,
            ..
        } = symptom
        else {
            continue;
        };
        let value = OneValue {
            line,
            old: found.clone(),
            new: instead.clone(),
        };
        if known.contains(&value) {
            continue;
        }
        known.push(value.clone());
        let part = suspect.asset.part.as_deref().unwrap_or("it");
        let title = format!(
            "{part}: `{}` in place of `{found}`",
            instead.replace('\n', ", ")
        );
        let fitted = fitted(study, suspect, &source.text, (subject, pairs));
        let note = match &fitted {
            Some(of) => format!(
                "It is solved for: from then on, agreement with {} on {} is a fit, not corroboration.",
                of.from,
                of.subject.in_words()
            ),
            None => "This decides what a word, a form or a number of the study means; that it makes the evidence agree does not show \
                     that it is right."
                .to_owned(),
        };
        match value.make(&source.text) {
            Ok(changed) => offered.add(Proposal {
                title,
                file: file.clone(),
                diff: unified(file, file, &source.text, &changed),
                notes: vec![note],
                needs_decision: true,
                ..of(
                    suspect,
                    Change::Value {
                        file: file.clone(),
                        value,
                        fitted,
                    },
                )
            }),
            Err(reason) => offered.refused.push(format!("{title}: {reason}.")),
        }
    }
    Ok(())
}

/// The lineage of a fault tree's number that was solved for; none of other texts.
fn fitted(
    study: &Study,
    suspect: &Suspect,
    text: &str,
    (subject, pairs): (&Subject, &[[String; 2]]),
) -> Option<Fitted> {
    let file = suspect.asset.file.as_deref()?;
    let line = suspect.asset.line?;
    let written = text
        .lines()
        .nth(usize::try_from(line).ok()?.checked_sub(1)?)?;
    // The event whose number stands in the line, or else the number by its place.
    let event = written.trim_start().strip_prefix('"');
    let event = event.and_then(|it| it.split('"').next());
    let name = match event.filter(|it| study::is_name(it)) {
        Some(event) => event.to_owned(),
        None => format!(
            "{} of line {line}",
            suspect.asset.part.as_deref()?.trim_matches('`')
        ),
    };
    pairs.iter().find_map(|[entry, from]| {
        let work = &study.ledger.iter().find(|it| &it.id == entry)?.work;
        (work.tree()?.to_string_lossy().replace('\\', "/") == file).then(|| Fitted {
            entry: entry.clone(),
            name: name.clone(),
            from: from.clone(),
            subject: subject.clone(),
        })
    })
}

fn of_form(study: &Study, suspect: &Suspect, change: FormChange, offered: &mut Offered) {
    let (requirement, form) = change.touches();
    let title = format!("requirement {requirement}: its {form} becomes that of its sentence");
    let text = &study.forms.source.text;
    let made = change.make(text).and_then(|changed| {
        can_be_asked(study, &changed)?;
        Ok(changed)
    });
    match made {
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

/// Whether each formal model still answers with other requirements.
fn can_be_asked(study: &Study, requirements: &str) -> Result<(), String> {
    let words = |problem: Problem| problem.warning_line();
    let scratch = Scratch::new(study, &study.folder.join("results")).map_err(words)?;
    let changed = scratch.with_changed("requirements.toml", &|text| {
        requirements.clone_into(text);
    });
    let changed = changed.map_err(words)?;
    let never = host::Cancel::default();
    let solver = Solver::new(&changed, &never);
    for entry in study.ledger.iter().filter(|entry| !entry.intermediate) {
        if let Some(model) = entry.work.model() {
            let source = texts::read(study, model).map_err(words)?;
            solver.values(model, &source.text).map_err(words)?;
        }
    }
    Ok(())
}

pub(super) fn of(suspect: &Suspect, change: Change) -> Proposal {
    Proposal {
        number: 0,
        suspect: Some(suspect.rank),
        title: String::new(),
        reason: format!("{}. {}", capital(&suspect.title), suspect.explanation),
        file: String::new(),
        also: Vec::new(),
        diff: String::new(),
        effects: Vec::new(),
        notes: Vec::new(),
        chosen: Vec::new(),
        rivals: Vec::new(),
        tried: Trial::default(),
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
    let (title, note) = match &change {
        TextChange::Methods { first, .. } => (
            format!("{evidence}: the answer of `{first}` counts"),
            "Its bounds hold, so that no other method can be right where they differ.",
        ),
        TextChange::Step { divisor, .. } => (
            format!("{evidence}: a time step {divisor} times smaller"),
            "The number rests on an error that is proportional to the step; run `corroborate diagnose` again afterwards.",
        ),
    };
    let shown = file.to_string_lossy().replace('\\', "/");
    let source = texts::read(study, &file)?;
    match change.make(&source.text) {
        Ok(changed) => offered.add(Proposal {
            title,
            diff: unified(&shown, &shown, &source.text, &changed),
            file: shown,
            notes: vec![note.into()],
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
    let simulated = study.entry(evidence)?.work.simulated();
    Ok(match (change, simulated) {
        (change @ TextChange::Methods { .. }, _) => Some((PathBuf::from("ledger.toml"), change)),
        (TextChange::Step { key, divisor }, Some(Simulated::Handover { scenario, .. })) => {
            let key = key.strip_prefix("scenario.").unwrap_or(&key).to_owned();
            Some((scenario.to_owned(), TextChange::Step { key, divisor }))
        }
        (change @ TextChange::Step { .. }, Some(Simulated::Scene { scene, .. })) => {
            Some((scene.to_owned(), change))
        }
        (TextChange::Step { .. }, Some(Simulated::Command(_)) | None) => None,
    })
}
