//! What each entry of a ledger needs, read, compiled and checked before anything runs.

use crate::technique;
use crate::technique::campaign::{OutsideCommand, Until};
use crate::technique::experiment::Tables;
use crate::technique::model_checking::Compiled;
use crate::technique::operation::Recordings;
use crate::technique::simulation::Campaign;
use diagnostic::{Problem, did_you_mean};
use host::Host;
use std::collections::BTreeMap;
use study::{Entry, Study, Work, quoted_names};

/// What an entry needs, read and checked before anything runs.
pub(crate) enum Prepared<'a> {
    Check(Box<Compiled<'a>>),
    Simulate(Box<Campaign>),
    Command(Box<OutsideCommand>),
    /// The physics library is missing; said when the entry's turn comes, so
    /// that all else still runs.
    CannotSimulate(Problem),
    Read(Tables),
    Judge(Recordings),
}

/// Prepares all entries; fails where a word of the study means nothing to what it is for.
pub(super) fn prepare<'a>(study: &'a Study, host: &Host) -> Result<Vec<Prepared<'a>>, Problem> {
    let entries = study.ledger.iter();
    let prepared: Vec<Prepared> = entries
        .map(|entry| prepared_entry(study, entry, host))
        .collect::<Result<_, Problem>>()?;
    judging::Judges::new(study, |_| true)?;
    every_proposition_is_expressed_somewhere(study, &prepared, host)?;
    Ok(prepared)
}

fn prepared_entry<'a>(
    study: &'a Study,
    entry: &'a Entry,
    host: &Host,
) -> Result<Prepared<'a>, Problem> {
    let library = host.physics_library.as_deref();
    Ok(match &entry.work {
        Work::Check { model, .. } => {
            let compiled = Compiled::new(study, model)?;
            check_constants(study, entry, &compiled)?;
            compiled.warn(&|line| host.events.say(line));
            Prepared::Check(Box::new(compiled))
        }
        Work::Simulate {
            scenario,
            parameters,
            ..
        } => prepared_campaign(Campaign::new(study, scenario, parameters, library))?,
        Work::SimulateScene { scene, test, .. } => {
            prepared_campaign(Campaign::of_scene(study, scene, test.as_deref(), library))?
        }
        Work::Command { command, .. } => {
            Prepared::Command(Box::new(OutsideCommand::new(study, command)?))
        }
        Work::Read {
            cohort,
            requirements,
            failure_modes,
            ..
        } => Prepared::Read(Tables::read(
            study,
            cohort.as_deref(),
            requirements.as_deref(),
            failure_modes.as_deref(),
        )?),
        Work::Judge { recordings, .. } => Prepared::Judge(Recordings::find(study, recordings)?),
    })
}

/// A campaign, or that simulations cannot run here.
fn prepared_campaign(campaign: Result<Campaign, Problem>) -> Result<Prepared<'static>, Problem> {
    match campaign {
        Ok(campaign) => Ok(Prepared::Simulate(Box::new(campaign))),
        Err(problem) if problem.code == "no-physics-library" => {
            Ok(Prepared::CannotSimulate(problem))
        }
        Err(problem) => Err(problem),
    }
}

/// The stopping rules of the ledger, held against the requirements.
pub(super) fn untils(study: &Study) -> Result<BTreeMap<&str, Until>, Problem> {
    let entries = study.ledger.iter().enumerate();
    let with_rule =
        entries.filter_map(|(place, entry)| Some((place, entry, entry.sampling.until.as_ref()?)));
    with_rule
        .map(|(place, entry, text)| {
            let at = || {
                let place = place.to_string();
                study::placed::toml_place(&study.ledger_source, &["evidence", &place, "until"])
            };
            let until = Until::new(study, text)
                .map_err(|problem| problem.about(&entry.id).at(&study.ledger_source, at()))?;
            Ok((entry.id.as_str(), until))
        })
        .collect()
}

/// What was set to a count must be a constant of the model.
fn check_constants(study: &Study, entry: &Entry, compiled: &Compiled) -> Result<(), Problem> {
    for calibrated in &entry.calibrated {
        let Some(name) = &calibrated.constant else {
            continue;
        };
        if compiled.constant(name).is_none() {
            let problem = Problem::new(
                "unknown-constant",
                format!(
                    "the model of {} has no number `{name}` among its constants",
                    entry.id
                ),
            )
            .at(&study.ledger_source, calibrated.span.clone());
            return Err(match did_you_mean(name, compiled.constants()) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy("name a constant that the model defines"),
            });
        }
    }
    Ok(())
}

/// A name that no model of the study knows is a mistake, not an abstraction; but a failure mode may
/// name a value that no model has yet, since that is what a model that does not know it lacks.
fn every_proposition_is_expressed_somewhere(
    study: &Study,
    prepared: &[Prepared],
    host: &Host,
) -> Result<(), Problem> {
    let models: Vec<&Compiled> = prepared
        .iter()
        .filter_map(|p| match p {
            Prepared::Check(compiled) => Some(compiled.as_ref()),
            _ => None,
        })
        .collect();
    for (name, proposition) in &study.vocabulary.propositions {
        let (Some(binding), Some(first)) = (&proposition.model, models.first()) else {
            continue;
        };
        if models.iter().any(|m| m.expressed.contains(name.as_str())) {
            continue;
        }
        let reason = first.not_expressed.get(name.as_str());
        let reason = reason.map_or("it cannot be evaluated", String::as_str);
        if is_a_failure(study, name) {
            host.events.say(&format!(
                "no model of the study knows `{name}`: {reason} (`corroborate refine` may offer it)"
            ));
            continue;
        }
        return Err(Problem::new(
            "unknown-name",
            format!("no model of the study expresses `{name}`: {reason}"),
        )
        .at(&study.vocabulary.source, binding.span.clone())
        .remedy("correct the name, or remove the `model` binding"));
    }
    Ok(())
}

/// Whether a proposition is all that some failure mode's occurrence asks for.
fn is_a_failure(study: &Study, proposition: &str) -> bool {
    let modes = study.forms.subjects.iter();
    let mut modes = modes.filter(|form| matches!(form.subject, evidence::Subject::FailureMode(_)));
    modes.any(|form| {
        let names = form.property.as_ref().map(|p| quoted_names(&p.text));
        matches!(names.as_deref(), Some([(only, _)]) if only == proposition)
    })
}

/// What each entry rests on.
pub(super) fn all_assets<'a>(
    study: &'a Study,
    prepared: &[Prepared],
) -> Result<BTreeMap<&'a str, Vec<evidence::Asset>>, Problem> {
    let entries = study.ledger.iter().zip(prepared);
    entries
        .map(|(entry, prepared)| {
            let mut assets = technique::assets(study, entry)?;
            match prepared {
                Prepared::Judge(recordings) => assets.extend_from_slice(recordings.assets()),
                Prepared::Simulate(campaign) => assets.extend_from_slice(campaign.assets()),
                Prepared::Command(command) => assets.extend_from_slice(command.assets()),
                _ => {}
            }
            Ok((entry.id.as_str(), assets))
        })
        .collect()
}
