//! What each entry of a ledger needs, read, compiled and checked before anything runs.

use crate::technique::campaign::Until;
use crate::technique::{self, Asked, Files, Prepared, Propositions, Techniques, technique_of};
use diagnostic::{Problem, did_you_mean};
use host::Host;
use std::collections::BTreeMap;
use study::{Entry, Study, quoted_names};

/// An entry whose files were read, with what was read of them.
pub(crate) struct Opened<'a> {
    /// Ready to be produced.
    pub(crate) work: Box<dyn Prepared + 'a>,
    /// What it read.
    pub(crate) files: Files<'a>,
}

/// Prepares all entries; fails where a word of the study means nothing to what it is for.
pub(super) fn prepare<'a>(
    study: &'a Study,
    others: &Techniques,
    host: &'a Host,
) -> Result<Vec<Opened<'a>>, Problem> {
    let open = |entry: &'a Entry| {
        let asked = Asked { study, entry, host };
        let files = Files::of(&study.folder);
        let work = technique_of(study, entry, others)?.prepare(asked, &files)?;
        Ok(Opened { work, files })
    };
    let opened: Vec<Opened<'a>> = study
        .ledger
        .iter()
        .map(open)
        .collect::<Result<_, Problem>>()?;
    judging::Judges::new(study, |_| true)?;
    every_proposition_is_expressed_somewhere(study, &opened, host)?;
    Ok(opened)
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
pub(crate) fn check_constants(
    study: &Study,
    entry: &Entry,
    (what, names): (&str, &[&str]),
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<(), Problem> {
    for calibrated in &entry.calibrated {
        let Some(name) = &calibrated.constant else {
            continue;
        };
        if value_of(name).is_none() {
            let problem = Problem::new(
                "unknown-constant",
                format!(
                    "the model of {} has no number `{name}` among its {what}",
                    entry.id
                ),
            )
            .at(&study.ledger_source, calibrated.span.clone());
            return Err(match did_you_mean(name, names.iter().copied()) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy(format!("name one of the model's {what}")),
            });
        }
    }
    Ok(())
}

/// A name that no model of the study knows is a mistake, not an abstraction; but a failure mode may
/// name a value that no model has yet, since that is what a model that does not know it lacks.
fn every_proposition_is_expressed_somewhere(
    study: &Study,
    prepared: &[Opened<'_>],
    host: &Host,
) -> Result<(), Problem> {
    let models = prepared.iter().filter_map(|it| it.work.propositions());
    let models: Vec<Propositions<'_>> = models.collect();
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
    prepared: &[Opened<'_>],
) -> Result<BTreeMap<&'a str, Vec<evidence::Asset>>, Problem> {
    let entries = study.ledger.iter().zip(prepared);
    entries
        .map(|(entry, prepared)| {
            let mut assets = technique::assets(study, entry)?;
            let named: Vec<String> = assets.iter().map(|it| it.path.clone()).collect();
            let read = prepared.files.read().into_iter();
            assets.extend(read.filter(|asset| !named.contains(&asset.path)));
            Ok((entry.id.as_str(), assets))
        })
        .collect()
}
