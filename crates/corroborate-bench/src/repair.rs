//! The first proposal applied, and the study run again.
//!
//! # Definition
//! The suspects are gone through in their order; the first that has an offer ([`refinement::Ground::first_against`]) gives
//! the first proposal. It is made on the asset's text by the code of the product. Then what rests on the asset is
//! produced again, from the same truth, with the same people and recordings. The study is *repaired* if
//!
//! * no pair of evidence conflicts on a subject that the fault touched, no form of it differs from its sentence, no
//!   failure mode is missing, and no method that stopped early counts; and
//! * the asset is right: a constant was set to counts whose 95 % interval holds the truth; the 95 % interval of a fitted
//!   parameter's posterior does (from its least value on, where nothing was counted: D. Brown, T. Cai and A. DasGupta,
//!   "Interval estimation for a binomial proportion", 2001, section 4.1.2, for the same at the ends of Jeffreys'); with
//!   the smaller step, that of the simulator's own runs does; a form means what its sentence says; a table has the right
//!   names.
//!
//! *Not repairable* by a change of a text is a failure that the simulator lacks (somebody has to program it), and there
//! is nothing to repair where the answer that counts is that of the sound method.

use crate::fault::{Assets, Fault, SetTo, Site};
use crate::formal::Formal;
use crate::random::Random;
use crate::requirements::{failure_modes, stated};
use crate::score::is_open;
use crate::study::{LEVEL, Synthetic, formal_text, ids};
use crate::texts;
use campaign::calibration::{Calibration, CalibrationOptions, Episode, Observed};
use checker::Method;
use evidence::{Interval, Outcome, Subject};
use refinement::{
    Asked, Counts, Exchange, Ground, Model, ModelChange, Offer, Solver, TextChange, Values, Word,
};
use stats::Confidence;

/// What came of the first proposal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Repair {
    /// No text can be changed so that the fault is gone, or there is nothing to repair.
    NotRepairable,
    /// Nothing was offered.
    NothingOffered,
    /// It could not be made, or something else stayed wrong.
    Failed(Flaw),
    /// The study is repaired.
    Repaired,
}

/// Why a proposal did not repair the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Flaw {
    /// It changes another asset than the faulty one, or another part of it.
    AnotherAsset,
    /// It could not be made.
    NotMade,
    /// Something on the subject still disagrees.
    StillDisagrees,
    /// The asset does not have the truth within its interval.
    NotTheTruth,
}

/// Whether a change of a text could repair the planted fault.
#[must_use]
pub fn is_repairable(study: &Synthetic) -> bool {
    match (study.planted.site, study.planted.fault) {
        (None, _) | (Some(Site::Simulation), Fault::MissingMode) => false,
        (Some(Site::Solver), _) => study.assets.methods.first() != Some(&Method::Sound),
        _ => true,
    }
}

/// Applies the first proposal, and runs the study again.
///
/// # Errors
/// What could not be produced, in words.
pub fn repair(study: &Synthetic) -> Result<Repair, String> {
    if !is_repairable(study) {
        return Ok(Repair::NotRepairable);
    }
    let Some(offer) = first_offer(study)? else {
        return Ok(Repair::NothingOffered);
    };
    if !touches_fault(study, &offer) {
        return Ok(Repair::Failed(Flaw::AnotherAsset));
    }
    let Ok(changed) = applied(study, &offer) else {
        return Ok(Repair::Failed(Flaw::NotMade));
    };
    let again = study.again(changed.assets)?;
    Ok(if still_disagrees(&again) {
        Repair::Failed(Flaw::StillDisagrees)
    } else if !is_the_truth(&again, &offer, &changed.fitted) {
        Repair::Failed(Flaw::NotTheTruth)
    } else {
        Repair::Repaired
    })
}

/// Solves texts of a study's formal model.
struct Texts<'a>(&'a Assets);

impl Solver for Texts<'_> {
    fn values(&self, text: &str) -> Result<Values, String> {
        let formal = Formal::new(text.to_owned(), &self.0.vocabulary, &self.0.forms)?;
        Ok(formal.values()?.into_iter().collect())
    }
}

/// The first proposal.
///
/// # Errors
/// What is wrong with the formal model.
pub fn first_offer(study: &Synthetic) -> Result<Option<Offer>, String> {
    let (requirements, failure_modes) = (
        stated(&study.assets.forms),
        failure_modes(&study.assets.modes),
    );
    let ground = Ground {
        evidence: &study.evidence,
        requirements: &requirements,
        failure_modes: &failure_modes,
        comparisons: &study.comparisons,
        confidence: LEVEL,
    };
    let (text, _) = formal_text(&study.setup, &study.assets)?;
    let asked: &[Asked] = &study.assets.vocabulary.asked;
    let words: Vec<Word> = asked
        .iter()
        .filter_map(|it| {
            Some(Word {
                subject: Subject::FailureMode(it.mode.clone()),
                name: it.mode.clone(),
                meaning: it.occurs.clone()?,
            })
        })
        .collect();
    let solver = Texts(&study.assets);
    let model = Model {
        evidence: ids::MODEL,
        text: &text,
        asked,
        words: &words,
        solver: &solver,
        states: None,
    };
    ground.first_against(&study.suspects, &[model], &[ids::SIMULATION])
}

/// Whether an offer is a change of the faulty asset at the place of the fault.
fn touches_fault(study: &Synthetic, offer: &Offer) -> bool {
    let planted = &study.planted;
    let is_subject = |id: &str| planted.subjects.iter().any(|subject| subject.id() == id);
    match (offer, planted.site) {
        (Offer::Model { change, .. }, Some(Site::FormalModel)) => is_subject(change.mode()),
        (Offer::Form(change), Some(Site::Property | Site::Monitor)) => {
            let (requirement, form) = change.touches();
            let wanted = match planted.site {
                Some(Site::Property) => "property",
                _ => "monitor",
            };
            is_subject(requirement) && form == wanted
        }
        (Offer::Parameters { counts, .. }, Some(Site::Simulation)) => {
            counts.iter().any(|(mode, _)| is_subject(mode))
        }
        (Offer::Text { change, .. }, Some(site)) => match change {
            TextChange::Methods { .. } => site == Site::Solver,
            TextChange::Step { .. } => site == Site::TimeStep,
        },
        (Offer::Exchange { modes, .. }, Some(Site::Data)) => {
            modes.iter().all(|mode| is_subject(mode.id()))
        }
        _ => false,
    }
}

/// The assets after a change.
struct Applied {
    assets: Assets,
    /// The intervals of fitted rates, by failure mode.
    fitted: Vec<(String, Interval)>,
}

/// The assets after a change of one text.
fn applied(study: &Synthetic, offer: &Offer) -> Result<Applied, String> {
    let mut fitted = Vec::new();
    let mut assets = study.assets.clone();
    match offer {
        Offer::Model {
            change, changed, ..
        } => {
            assets.formal_text = Some(changed.text.clone());
            set_formal(&mut assets, change)?;
            assets.set_to = changed
                .constant
                .iter()
                .map(|it| set_to(&it.name, it.is_complement, change.mode(), change.counts()))
                .collect();
        }
        Offer::Form(change) => {
            let text = change.make(&texts::requirements(&assets.forms))?;
            texts::read_requirements(&text, &mut assets.forms)?;
        }
        Offer::Text { change, .. } => match change {
            TextChange::Methods { .. } => {
                assets.methods =
                    texts::read_methods(&change.make(&texts::ledger(&assets.methods))?)?;
            }
            TextChange::Step { .. } => {
                let part = texts::read_step(&change.make(&texts::scene())?)?;
                let step = assets.step.as_mut().ok_or("no step is too large")?;
                step.step = part;
            }
        },
        // The table here has names and no counts, so that either kind of exchange is one of names.
        Offer::Exchange { modes, .. } => {
            let modes = modes.each_ref().map(|mode| mode.id().to_owned());
            let text = Exchange::Names { modes }.make(&texts::table(&assets))?;
            assets.columns = texts::read_table(&text, &assets.modes)?;
        }
        Offer::Columns { .. } => return Err("the table here has names and no counts".into()),
        Offer::Entries { .. } => return Err("all pieces here are under one condition".into()),
        Offer::Parameters { counts, .. } => fitted = fit(study, &mut assets, counts)?,
    }
    Ok(Applied { assets, fitted })
}

fn set_to(parameter: &str, is_complement: bool, mode: &str, counts: &Counts) -> SetTo {
    SetTo {
        parameter: parameter.to_owned(),
        is_complement,
        mode: mode.to_owned(),
        from: counts.evidence.clone(),
    }
}

/// The task that the changed model describes, from which its paths are drawn.
fn set_formal(assets: &mut Assets, change: &ModelChange) -> Result<(), String> {
    let place = assets.formal.stage_of(change.mode());
    let stage = &mut assets.formal.stages[place.ok_or("no such stage")?];
    stage.fails = change.counts().rate();
    stage.can_fail = true;
    Ok(())
}

/// Episodes of a round of a calibration, and its rounds.
const EPISODES: usize = 300;
const ROUNDS: usize = 3;

/// The largest rate that a parameter of the simulator can have.
const LARGEST: f64 = 0.6;

/// Fits the simulator's rates to counts, each ruled by a parameter of its own, by the calibration of the product.
fn fit(
    study: &Synthetic,
    assets: &mut Assets,
    counts: &[(String, Counts)],
) -> Result<Vec<(String, Interval)>, String> {
    let words = |error: campaign::CampaignError| error.to_string();
    let observed = counts
        .iter()
        .map(|(mode, it)| Observed::new(mode, it.count, it.trials));
    let places: Option<Vec<usize>> = counts
        .iter()
        .map(|(mode, _)| assets.simulator.stage_of(mode))
        .collect();
    let places = places.ok_or("the simulator has no such failure")?;
    let options = CalibrationOptions {
        dimensions: counts.len(),
        points: 2000,
        seed: study.seed.1,
    };
    let mut calibration = Calibration::new(observed.collect(), options).map_err(words)?;
    let mut random = Random::new(study.seed.0 ^ 0xca11, study.seed.1);
    for _ in 0..ROUNDS {
        for unit in calibration.ask(EPISODES) {
            let mut task = assets.simulated(1.0);
            for (place, unit) in places.iter().zip(&unit) {
                task.stages[*place].fails = LARGEST * unit;
            }
            let run = task.run(&mut random);
            let outcome = |place: &usize| run.reached(*place).then(|| run.failed_at(*place));
            let outcomes = places.iter().map(outcome).collect();
            calibration
                .tell(Episode { unit, outcomes })
                .map_err(words)?;
        }
    }
    let posterior = calibration.posterior();
    let marginals = posterior.marginals(Confidence::P95);
    let mut fitted = Vec::new();
    let values = posterior.mean().into_iter().zip(marginals);
    for ((place, (unit, marginal)), (mode, it)) in places.iter().zip(values).zip(counts) {
        assets.simulator.stages[*place].fails = LARGEST * unit;
        let parameter = format!("{mode} of the simulator");
        assets.fitted.push(set_to(&parameter, false, mode, it));
        let low = if it.count == 0 {
            0.0
        } else {
            LARGEST * marginal.interval.low
        };
        let high = LARGEST * marginal.interval.high;
        fitted.push((mode.clone(), Interval { low, high }));
    }
    Ok(fitted)
}

fn still_disagrees(study: &Synthetic) -> bool {
    let is_subject = |subject: &Subject| study.planted.subjects.contains(subject);
    let mut all = study.comparisons.iter();
    all.any(|c| c.outcome == Outcome::Conflicts && is_subject(&c.subject)) || is_open(study)
}

/// Whether the asset that was changed has the truth within its interval.
fn is_the_truth(study: &Synthetic, offer: &Offer, fitted: &[(String, Interval)]) -> bool {
    let holds = |interval: Interval, mode: &str| {
        let truth = study.truth(&Subject::FailureMode(mode.to_owned()));
        truth.is_some_and(|truth| interval.contains(truth))
    };
    let counted = |id: &str, mode: &str| {
        let subject = Subject::FailureMode(mode.to_owned());
        let finding = study.piece(id).and_then(|piece| piece.finding(&subject));
        let interval = finding.and_then(|finding| finding.measure.interval());
        interval.is_some_and(|interval| holds(interval, mode))
    };
    let is_planted = |mode: &str| study.planted.subjects.iter().any(|s| s.id() == mode);
    match offer {
        Offer::Model { change, .. } => counted(&change.counts().evidence, change.mode()),
        Offer::Parameters { .. } => {
            let mut touched = fitted.iter().filter(|(mode, _)| is_planted(mode));
            touched.all(|(mode, interval)| holds(*interval, mode))
        }
        Offer::Text { change, .. } => match change {
            TextChange::Step { .. } => {
                let mut modes = study.planted.subjects.iter();
                modes.all(|subject| match subject {
                    Subject::FailureMode(mode) => counted(ids::SIMULATION, mode),
                    Subject::Requirement(_) => true,
                })
            }
            TextChange::Methods { .. } => study.assets.methods.first() == Some(&Method::Sound),
        },
        Offer::Exchange { .. } => study.assets.columns.is_sorted(),
        Offer::Columns { .. } | Offer::Entries { .. } => false,
        Offer::Form(change) => {
            let (requirement, _) = change.touches();
            let mut forms = study.assets.forms.iter();
            forms.any(|form| form.id == requirement && form.is_sentence())
        }
    }
}
