//! What each entry of a ledger needs, read, compiled and checked before anything runs.

use crate::technique::campaign::Until;
use crate::technique::model_checking::Unexpressed;
use crate::technique::{self, Asked, Files, Prepared, Techniques, technique_of};
use diagnostic::{Problem, Problems, did_you_mean};
use host::Host;
use std::collections::BTreeMap;
use study::{Entry, Study};

/// An entry whose files were read, with what was read of them.
pub(crate) struct Opened<'a> {
    /// Ready to be produced.
    pub(crate) work: Box<dyn Prepared + 'a>,
    /// What it read.
    pub(crate) files: Files<'a>,
}

/// Prepares all entries.
///
/// # Errors
/// Every word of the study that means nothing to what it is for, and every mistake of the files that it names.
pub(super) fn prepare<'a>(
    study: &'a Study,
    others: &Techniques,
    host: &'a Host,
) -> Result<Vec<Opened<'a>>, Problem> {
    let mut found = Problems::new();
    for source in [
        &study.about_source,
        &study.vocabulary.source,
        &study.forms.source,
        &study.ledger_source,
    ] {
        found.reads(source);
    }
    let mut opened = Vec::with_capacity(study.ledger.len());
    for entry in &study.ledger {
        if !found.is_ended() {
            opened.extend(found.keep(open(study, entry, others, host)));
        }
    }
    found.keep(topics(study));
    if !found.is_ended() {
        found.keep(judging::Judges::new(study, |_| true));
    }
    // Without one of the models, what it expresses is not known.
    if opened.len() == study.ledger.len() {
        let models = opened.iter().filter_map(|it| it.work.propositions());
        let unexpressed = Unexpressed::of(study, &models.collect::<Vec<_>>());
        for warning in &unexpressed.warnings {
            host.events.say(&warning.warning_line());
        }
        for mistake in unexpressed.mistakes {
            found.add(mistake);
        }
    }
    found.or(opened)
}

fn open<'a>(
    study: &'a Study,
    entry: &'a Entry,
    others: &Techniques,
    host: &'a Host,
) -> Result<Opened<'a>, Problem> {
    let asked = Asked { study, entry, host };
    let files = Files::of_study(study);
    let work = technique_of(study, entry, others)?.prepare(asked, &files)?;
    Ok(Opened { work, files })
}

/// Whether where recordings have the signals can be read, if the study says it.
fn topics(study: &Study) -> Result<(), Problem> {
    let path = study.folder.join("topics.toml");
    match path.exists() {
        true => {
            study.reach.check(&path)?;
            judging::recording::read_map(&path).map(drop)
        }
        false => Ok(()),
    }
}

/// What is wrong in the files that a study names whose own files have mistakes. What is said of its own files here may follow
/// from those mistakes, and is left out.
pub(super) fn look_further(study: &Study, others: &Techniques, host: &Host, found: &mut Problems) {
    let own = [
        study.about_source.name.clone(),
        study.folder.join("parameters.toml").display().to_string(),
        study.vocabulary.source.name.clone(),
        study.forms.source.name.clone(),
        study.ledger_source.name.clone(),
    ];
    let is_named = |problem: &Problem| problem.place().is_some_and(|it| !own.contains(&it.name));
    found.keep(topics(study));
    for entry in &study.ledger {
        let Err(problem) = open(study, entry, others, host) else {
            continue;
        };
        let named = problem.into_each().into_iter().filter(is_named);
        named.for_each(|problem| found.add(problem));
        if host.cancel.is_cancelled() {
            return;
        }
    }
}

/// The stopping rules of the ledger, held against the requirements.
pub(super) fn untils(study: &Study) -> Result<BTreeMap<&str, Until>, Problem> {
    let entries = study.ledger.iter().enumerate();
    let with_rule =
        entries.filter_map(|(place, entry)| Some((place, entry, entry.sampling.until.as_ref()?)));
    let mut found = Problems::new();
    let mut untils = BTreeMap::new();
    for (place, entry, text) in with_rule {
        let at = || {
            let place = place.to_string();
            study::placed::toml_place(&study.ledger_source, &["evidence", &place, "until"])
        };
        let until = Until::new(study, entry, text)
            .map_err(|problem| problem.about(&entry.id).at(&study.ledger_source, at()));
        untils.extend(found.keep(until).map(|until| (entry.id.as_str(), until)));
    }
    found.or(untils)
}

/// What was set to a count must be a constant of the model, and so must a number that was solved for, if it has a name: one that has
/// none is described ("0.3 of line 4").
pub(crate) fn check_constants(
    study: &Study,
    entry: &Entry,
    (what, names): (&str, &[&str]),
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<(), Problem> {
    let mut found = Problems::new();
    for calibrated in &entry.calibrated {
        let solved = &calibrated.calibration.parameter;
        let name = match &calibrated.constant {
            Some(name) => name,
            None if study::is_name(solved) => solved,
            None => continue,
        };
        if value_of(name).is_none() {
            let problem = Problem::new(
                "unknown-constant",
                format!("the model of {} has no `{name}` among its {what}", entry.id),
            )
            .at(&study.ledger_source, calibrated.span.clone());
            found.add(match did_you_mean(name, names.iter().copied()) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy(format!("name one of the model's {what}")),
            });
        }
    }
    found.or(())
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
