//! Simulator parameters from an evidence's counts: fitted, and checked by the fitted set's own episodes.

mod base;
mod basis;
mod conclusion;
mod counts;
mod file;
mod parameter_set;
mod work;

pub use file::{CalibrationText, HeldOutRuns, Point};

use crate::kept::{CALIBRATION, sealed};
use crate::rigs::Opening;
use crate::technique::confidence;
use crate::technique::simulation::{SearchPhysics, Seeds};
use base::Base;
use basis::{inputs, lineage, rig_accepts};
use counts::Reality;
use diagnostic::{Problem, Source};
use evidence::CalibrationReport;
use file::CODE;
use host::Host;
use host::files::write_whole;
use host::store::Store;
use judging::Judges;
use rig::{Rig, check_units};
use std::path::PathBuf;
use study::Study;
use study::placed::quoted;
use work::Work;

/// A calibration. [`CalibrateRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct CalibrateRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The calibration's file.
    pub file: PathBuf,
    /// Where finished parts and the result go; by default to the folder `results/calibration` of the study.
    pub out: Option<PathBuf>,
}

impl CalibrateRequest {
    /// The calibration of this file, in the study in this folder.
    pub fn new(study: impl Into<PathBuf>, file: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            file: file.into(),
            out: None,
        }
    }
}

/// Fits parameters of the simulator to the counts of an evidence, runs the fitted set in the full physics, and writes
/// `calibration.json` and the table of all episodes. The fitted set is in the report
/// ([`CalibrationReport::parameter_set`]). Finished parts are kept, and an earlier call's are taken.
///
/// # Errors
/// What the study's files and the calibration's file say wrong, each with its place, before anything runs; `interrupted` if the
/// host was asked to stop; `results-in-use` if another call writes to the same folder; `no-physics-library` if episodes cannot
/// be simulated here.
pub fn calibrate(request: &CalibrateRequest, host: &Host) -> Result<CalibrationReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let source = host::files::read_source(&request.file)?;
    let text = CalibrationText::read(&source)?;
    let level = confidence(text.confidence)?;
    let reality = Reality::read(&study, &source, &text)?;
    let base = Base::read(&study, &source, &text)?;
    let rigs = Rigs::open(&study, &source, &text, &base, host)?;
    let folder = request.out.clone();
    let folder = folder.unwrap_or_else(|| study.folder.join("results/calibration"));
    let (space, build) = (text.space(), &host.build);
    let work = Work {
        judges: Judges::new(&study, |subject| {
            let mut modes = reality.observed.iter();
            modes.any(|it| it.mode == subject.id())
        })?,
        inputs: inputs(&study, rigs.search(), &space, &reality, build),
        check_inputs: inputs(&study, rigs.full.as_ref(), &space, &reality, build),
        store: Store::open(&folder)?,
        seeds: Seeds::new(study.about.seed, &format!("calibration: {}", text.name)),
        text: &text,
        rig: rigs.search(),
        check_rig: rigs.full.as_ref(),
        is_fast: rigs.fast.is_some(),
        reality,
        space,
        host,
        agreement: confidence(study.about.agreement)?,
        lineage: lineage(&study, &source, &text, (base.simulated, rigs.full.as_ref()))?,
    };
    let report = work.report(&base, level)?;
    write_whole(&folder.join(CALIBRATION), sealed(&report)?.as_bytes())?;
    Ok(report)
}

/// The rig of the full physics, and that of the rounds, if they run in another.
struct Rigs {
    full: Box<dyn Rig>,
    fast: Option<Box<dyn Rig>>,
}

impl Rigs {
    /// Opens them, and tries what is to be fitted.
    fn open(
        study: &Study,
        source: &Source,
        text: &CalibrationText,
        base: &Base<'_>,
        host: &Host,
    ) -> Result<Self, Problem> {
        let opening = Opening {
            test: Some(&text.test),
            joined: Some(", "),
            instead: Some((base.file, &base.source)),
            ..Opening::new(study, host)
        };
        let full = opening.open(base.simulated)?;
        let fast =
            SearchPhysics::choose(text.physics, || full.in_fast_physics()).map_err(|message| {
                let span = quoted(source, "physics");
                let problem = Problem::new(CODE, message).at(source, span);
                problem.remedy("leave `physics` out")
            })?;
        let space = text.space();
        check_units(&space, source, CODE)?;
        rig_accepts(full.as_ref(), &space, source)?;
        Ok(Self { full, fast })
    }

    /// That of the rounds.
    fn search(&self) -> &dyn Rig {
        self.fast.as_ref().unwrap_or(&self.full).as_ref()
    }
}
