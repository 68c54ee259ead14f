//! What each entry of a ledger needs, read, compiled and checked before anything runs.

use corroborate::corroboration::{Piece, is_rounding};
use corroborate::technique;
use corroborate::technique::campaign::{OutsideCommand, Until};
use corroborate::technique::experiment::Tables;
use corroborate::technique::model_checking::{Compiled, CountedConstant};
use corroborate::technique::operation::Recordings;
use corroborate::technique::simulation::Campaign;
use diagnostic::{Problem, did_you_mean};
use evidence::{AssetRole, Measure};
use host::Host;
use std::collections::BTreeMap;
use std::path::Path;
use study::{Calibrated, Entry, Study, Work, quoted_names};

/// What an entry needs, read and checked before anything runs.
pub(super) enum Prepared<'a> {
    Check(Box<Compiled<'a>>),
    Simulate(Box<Campaign>),
    Command(Box<OutsideCommand>),
    /// The physics library is missing; said when the entry's turn comes, so
    /// that all else still runs.
    CannotSimulate(Problem),
    Read(Tables),
    Judge(Recordings),
}

pub(super) fn prepare<'a>(study: &'a Study, setting: &Host) -> Result<Vec<Prepared<'a>>, Problem> {
    let prepared = study
        .ledger
        .iter()
        .map(|entry| match &entry.work {
            Work::Check { model, .. } => {
                let compiled = Compiled::new(study, model)?;
                check_constants(study, entry, &compiled)?;
                compiled.warn(&|line| setting.events.say(line));
                Ok(Prepared::Check(Box::new(compiled)))
            }
            Work::Simulate {
                scenario,
                parameters,
                ..
            } => {
                let library = setting.physics_library.as_deref();
                prepared_campaign(Campaign::new(study, scenario, parameters, library))
            }
            Work::SimulateScene { scene, test, .. } => {
                let library = setting.physics_library.as_deref();
                let campaign = Campaign::of_scene(study, scene, test.as_deref(), library);
                prepared_campaign(campaign)
            }
            Work::Command { command, .. } => {
                let command = OutsideCommand::new(study, command)?;
                Ok(Prepared::Command(Box::new(command)))
            }
            Work::Read {
                cohort,
                requirements,
                failure_modes,
                ..
            } => Ok(Prepared::Read(Tables::read(
                study,
                cohort.as_deref(),
                requirements.as_deref(),
                failure_modes.as_deref(),
            )?)),
            Work::Judge { recordings, .. } => {
                Ok(Prepared::Judge(Recordings::find(study, recordings)?))
            }
        })
        .collect::<Result<Vec<_>, Problem>>()?;
    judging::Judges::new(study, |_| true)?;
    every_proposition_is_expressed_somewhere(study, &prepared, setting)?;
    Ok(prepared)
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
    let with_rule = study
        .ledger
        .iter()
        .filter_map(|entry| Some((entry, entry.sampling.until.as_ref()?)));
    with_rule
        .map(|(entry, text)| {
            let until = Until::new(study, text).map_err(|problem| problem.about(&entry.id))?;
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
    setting: &Host,
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
            setting.events.say(&format!(
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

/// The constants whose counts are uncertain, with the counts; `value_of` tells a constant of the model.
pub fn counted_constants(
    study: &Study,
    entry: &Entry,
    before: &[Piece],
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<Vec<CountedConstant>, Problem> {
    let mut counted = Vec::new();
    check_values(study, entry, before, value_of)?;
    // A step on the way is not compared, so its uncertainty is not asked for.
    if entry.intermediate {
        return Ok(counted);
    }
    for calibrated in &entry.calibrated {
        let Some(constant) = &calibrated.constant else {
            continue;
        };
        let calibration = &calibrated.calibration;
        // With --only, the evidence that supplies the counts may be left out;
        // the result is then kept under other inputs.
        let finding = before
            .iter()
            .find(|piece| piece.evidence.id == calibration.from)
            .and_then(|piece| piece.evidence.finding(&calibration.subject));
        let Some(finding) = finding else {
            continue;
        };
        let bad = |error: stats::StatsError| Problem::new("bad-counts", error.to_string());
        let Some(sample) = calibrated.sample(&finding.measure).map_err(bad)? else {
            return Err(Problem::new(
                "bad-calibration",
                format!(
                    "`{}` of {} was set to {}'s count of {}, which has none",
                    calibration.parameter,
                    entry.id,
                    calibration.from,
                    calibration.subject.id()
                ),
            )
            .remedy("calibrate from evidence that counts"));
        };
        counted.push(CountedConstant {
            name: constant.clone(),
            sample,
            subject: calibration.subject.clone(),
            held: calibrated.held,
        });
    }
    Ok(counted)
}

/// Holds each constant against the counts that the ledger says it was set to: a model that computes with another number
/// would be shown with the uncertainty of this one.
fn check_values(
    study: &Study,
    entry: &Entry,
    before: &[Piece],
    value_of: &dyn Fn(&str) -> Option<f64>,
) -> Result<(), Problem> {
    for calibrated in &entry.calibrated {
        let calibration = &calibrated.calibration;
        let source = before.iter().find(|p| p.evidence.id == calibration.from);
        let finding = source.and_then(|piece| piece.evidence.finding(&calibration.subject));
        let rate = finding.and_then(|finding| finding.measure.estimate());
        let value = calibrated.constant.as_deref().and_then(value_of);
        let (Some(finding), Some(rate), Some(value)) = (finding, rate, value) else {
            continue;
        };
        let set_to = calibrated.value_of(rate);
        if is_rounding(value, set_to) {
            continue;
        }
        return Err(match is_rounding(value, 1.0 - set_to) {
            true => complement_mistaken(study, entry, calibrated, value, rate),
            false => other_value(study, entry, calibrated, value, &finding.measure),
        });
    }
    Ok(())
}

/// A constant that is not what the ledger says it was set to.
fn other_value(
    study: &Study,
    entry: &Entry,
    calibrated: &Calibrated,
    value: f64,
    measure: &Measure,
) -> Problem {
    let calibration = &calibrated.calibration;
    let rate = measure.estimate().unwrap_or(f64::NAN);
    let file = match &entry.work {
        Work::Check { model, .. } => model.to_string_lossy().replace('\\', "/"),
        _ => entry.id.clone(),
    };
    let (counted, written) = match *measure {
        Measure::Counts { count, trials, .. } => {
            let of_constant = match calibrated.is_complement {
                true => trials.saturating_sub(count),
                false => count,
            };
            (
                format!("{count}/{trials} = "),
                format!("{of_constant}/{trials}"),
            )
        }
        _ => (String::new(), calibrated.value_of(rate).to_string()),
    };
    let complement = match calibrated.is_complement {
        true => format!(", so that the constant should be {:.6}", 1.0 - rate),
        false => String::new(),
    };
    Problem::new(
        "bad-calibration",
        format!(
            "`{name}` is {value} in {file} ({id}), but the ledger says that it was set to {from}'s rate of {subject}, \
             which is {counted}{rate:.6}{complement}",
            name = calibration.parameter,
            id = entry.id,
            from = calibration.from,
            subject = calibration.subject.id(),
        ),
    )
    .at(&study.ledger_source, calibrated.span.clone())
    .remedy(format!(
        "write `const double {} = {written};` in {file}, or remove this line of the ledger if the constant has another \
         source",
        calibration.parameter
    ))
}

/// A constant that is the complement of what it is said to be: its uncertainty would be that of another number.
fn complement_mistaken(
    study: &Study,
    entry: &Entry,
    calibrated: &Calibrated,
    value: f64,
    rate: f64,
) -> Problem {
    let calibration = &calibrated.calibration;
    let (is, remedy) = match calibrated.is_complement {
        false => (
            "1 minus that",
            "add `complement = true` if the constant is the probability that it does not happen",
        ),
        true => (
            "that itself, and not 1 minus it",
            "leave `complement` out if the constant is the probability that it happens",
        ),
    };
    Problem::new(
        "bad-calibration",
        format!(
            "`{}` of {} is {value}, but {} counts a rate of {rate} for {}: the constant is {is}",
            calibration.parameter,
            entry.id,
            calibration.from,
            calibration.subject.id(),
        ),
    )
    .at(&study.ledger_source, calibrated.span.clone())
    .remedy(remedy)
}

/// What each entry rests on.
pub(super) fn all_assets<'a>(
    study: &'a Study,
    prepared: &[Prepared],
) -> Result<BTreeMap<&'a str, Vec<evidence::Asset>>, Problem> {
    let entries = study.ledger.iter().zip(prepared);
    entries
        .map(|(entry, prepared)| {
            let mut assets = assets(study, entry)?;
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

/// The files that an entry names, with their hashes.
pub fn assets(study: &Study, entry: &Entry) -> Result<Vec<evidence::Asset>, Problem> {
    use AssetRole::{Data, RequirementModel, SystemModel};
    let mut files: Vec<(AssetRole, &Path)> = Vec::new();
    match &entry.work {
        Work::Check { model, .. } => files.push((SystemModel, model)),
        Work::Simulate {
            scenario,
            parameters,
            ..
        } => files.extend([(SystemModel, scenario.as_path()), (SystemModel, parameters)]),
        Work::SimulateScene { scene, .. } => files.push((SystemModel, scene)),
        Work::Read {
            cohort,
            requirements,
            failure_modes,
            ..
        } => {
            let tables = [cohort, requirements, failure_modes];
            files.extend(tables.into_iter().flatten().map(|t| (Data, t.as_path())));
        }
        Work::Judge { .. } | Work::Command { .. } => {
            let map = Path::new("topics.toml");
            if study.folder.join(map).exists() {
                files.push((RequirementModel, map));
            }
        }
    }
    files.push((RequirementModel, Path::new("requirements.toml")));
    files.push((RequirementModel, Path::new("vocabulary.toml")));
    files
        .into_iter()
        .map(|(role, path)| technique::asset(&study.folder, role, path))
        .collect()
}
