//! The rounds of a calibration, its episodes, and what they give.

use super::base::Base;
use super::conclusion::{conclusion, held_out_runs, mode_reports};
use super::counts::Reality;
use super::file::{CODE, CalibrationText};
use super::parameter_set;
use crate::technique::rows::{self, Rows, Value};
use crate::technique::simulation::Seeds;
use crate::test_bench::{simulation_problem, stimulus_at};
use campaign::calibration::{Calibration, CalibrationOptions, Episode, Identifiability, Posterior};
use diagnostic::Problem;
use evidence::{
    CalibrationReport, DirectionReport, Identification, LineageReport, ParameterReport,
};
use host::Host;
use host::Stage;
use host::store::{Inputs, Store};
use judging::Judges;
use rayon::prelude::*;
use rig::Rig;
use serde::{Deserialize, Serialize};
use stats::Confidence;
use std::ops::Range;
use std::path::Path;
use stimulus::{Space, Stimulus};
use temporal::monitor::Verdict;
use testbench::Unwatched;

/// Episodes that are kept together.
const CHUNK: usize = 32;

/// Numbers of the episodes that check the fitted set begin here.
const CHECK_FROM: u64 = 1_000_000;

/// For each episode, the outcome of each way to fail.
pub type Outcomes = Vec<Vec<Option<bool>>>;

/// What is kept of a chunk of episodes.
#[derive(Debug, Serialize, Deserialize)]
struct Kept(Outcomes);

/// What episodes are run for, which decides their physics.
#[derive(Debug, Clone, Copy)]
enum Episodes {
    /// The fit.
    Round,
    /// The check of the fitted set.
    Check,
}

/// A calibration, ready to be done.
pub struct Work<'a> {
    pub text: &'a CalibrationText,
    /// That of the rounds, in the physics that the file chooses.
    pub rig: &'a dyn Rig,
    /// That of the check of the fitted set: of the full physics.
    pub check_rig: &'a dyn Rig,
    /// Whether the fit rests on episodes of the fast physics.
    pub is_fast: bool,
    pub judges: Judges<'a>,
    pub reality: Reality,
    pub space: Space,
    pub store: Store,
    /// What an episode of the rounds depends on.
    pub inputs: Inputs,
    /// What an episode of the check depends on.
    pub check_inputs: Inputs,
    pub seeds: Seeds,
    pub host: &'a Host,
    /// The level at which likeness is shown.
    pub agreement: Confidence,
    pub lineage: LineageReport,
}

impl Work<'_> {
    /// Does it.
    pub fn report(&self, base: &Base<'_>, level: Confidence) -> Result<CalibrationReport, Problem> {
        let mut rows = Rows::default();
        let calibration = self.rounds(&mut rows)?;
        let posterior = calibration.posterior();
        let unit = self.text.point.of(&posterior);
        let fitted = self.space.at(&unit);
        let settings = self
            .space
            .settings(&fitted)
            .map_err(|error| Problem::new("bad-settings", error.to_string()))?;
        let units = vec![unit; self.text.check_episodes as usize];
        let check = self.episodes("fitted set", Episodes::Check, CHECK_FROM, &units)?;
        self.rows(&mut rows, "check", CHECK_FROM, (&units, &check));
        let about = [
            ("calibration", self.text.name.as_str()),
            ("evidence", &self.text.evidence),
        ];
        rows.write(&self.store.folder().join(rows::FILE), &about)?;
        let (reality, agreement) = (&self.reality, self.agreement);
        let modes = mode_reports(reality, &calibration, &posterior, &check, agreement)?;
        let held_out_runs = held_out_runs(reality, &calibration)?;
        let (conclusion, because) = conclusion(&modes, &held_out_runs);
        let parameters = self.parameters(&posterior, &fitted.0, level);
        let body = base.with(&settings)?;
        let heading = self.heading(base.file, &parameters, calibration.episodes().len());
        let directions = posterior.directions().into_iter();
        Ok(CalibrationReport {
            format: "2.0".into(),
            engine: self.check_rig.engine(),
            evidence: self.text.evidence.clone(),
            guarantee: self.guarantee(),
            episodes: calibration.episodes().len() as u64,
            effective_size: posterior.effective_size(),
            confidence: level.level(),
            correlations: posterior.correlations(),
            directions: directions
                .map(|d| DirectionReport {
                    loadings: d.loadings,
                    variance_share: d.variance_share,
                    identifiability: identification(d.identifiability),
                })
                .collect(),
            conclusion,
            because,
            lineage: self.lineage.clone(),
            parameter_set: heading + &body,
            parameters,
            modes,
            held_out_runs,
        })
    }

    fn guarantee(&self) -> String {
        let rounds = match self.is_fast {
            true => "episodes of the fast physics, which is approximate",
            false => "seeded episodes",
        };
        let check = match self.is_fast {
            true => "episodes of the fitted set in the full physics",
            false => "episodes of the fitted set",
        };
        format!(
            "estimated: posterior by response surfaces (logistic, quadratic) over {rounds}; checked by {check}"
        )
    }

    fn heading(&self, file: &Path, fitted: &[ParameterReport], episodes: usize) -> String {
        parameter_set::heading(&parameter_set::Written {
            about: self.text,
            file,
            reality: &self.reality,
            fitted,
            lineage: &self.lineage,
            engine: &self.check_rig.engine(),
            is_fast: self.is_fast,
            episodes,
        })
    }

    fn parameters(
        &self,
        posterior: &Posterior,
        fitted: &[f64],
        level: Confidence,
    ) -> Vec<ParameterReport> {
        let parameters = self.space.parameters.iter().zip(fitted);
        let parameters = parameters.zip(posterior.marginals(level));
        let report = |((parameter, fitted), marginal): (
            (&stimulus::Parameter, &f64),
            campaign::calibration::Marginal,
        )| {
            let at = |unit: f64| parameter.distribution.quantile(unit);
            ParameterReport {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                sets: parameter.sets.clone(),
                prior: parameter.distribution.support(),
                fitted: *fitted,
                median: at(marginal.median),
                low: at(marginal.interval.low),
                high: at(marginal.interval.high),
                contraction: marginal.contraction,
                deviation_ratio: (1.0 - marginal.contraction).max(0.0).sqrt(),
                identifiability: identification(Identifiability::of(marginal.contraction)),
            }
        };
        parameters.map(report).collect()
    }

    /// The rows of episodes at points of the unit cube, numbered from `first`.
    fn rows(
        &self,
        rows: &mut Rows,
        part: &str,
        first: u64,
        (units, outcomes): (&[Vec<f64>], &Outcomes),
    ) {
        for (number, (unit, outcomes)) in (first..).zip(units.iter().zip(outcomes)) {
            rows.begin();
            rows.plain(
                "part",
                "round, or check of the fitted set",
                Value::Text(part.into()),
            );
            rows.plain("episode", "its number", Value::U64(number));
            let seed = self.seeds.of(number);
            rows.plain(
                "seed",
                "from which everything random is drawn",
                Value::U64(seed),
            );
            for (parameter, value) in self.space.parameters.iter().zip(&self.space.at(unit).0) {
                rows.parameter(parameter, *value);
            }
            for (observed, outcome) in self.reality.observed.iter().zip(outcomes) {
                let meaning = "violated or occurred; missing without opportunity";
                if let Some(outcome) = outcome {
                    rows.plain(&observed.mode, meaning, Value::Bool(*outcome));
                }
            }
        }
    }

    fn rounds(&self, rows: &mut Rows) -> Result<Calibration, Problem> {
        let options = CalibrationOptions {
            dimensions: self.space.dimensions(),
            points: self.text.points,
            seed: self.seeds.of(0),
        };
        let mut calibration =
            Calibration::new(self.reality.fitted(), options).map_err(bad_calibration)?;
        let count = self.text.episodes_per_round;
        for round in 0..self.text.rounds {
            let units = calibration.ask(count as usize);
            let title = format!("round {} of {}", round + 1, self.text.rounds);
            let first = 1 + round * count;
            let outcomes = self.episodes(&title, Episodes::Round, first, &units)?;
            self.rows(
                rows,
                &format!("round {}", round + 1),
                first,
                (&units, &outcomes),
            );
            for (unit, outcomes) in units.into_iter().zip(outcomes) {
                let told = calibration.tell(Episode { unit, outcomes });
                told.map_err(bad_calibration)?;
            }
        }
        Ok(calibration)
    }

    /// Episodes at points of the unit cube, numbered from `first`; chunks that
    /// are kept are not run again.
    fn episodes(
        &self,
        title: &str,
        of: Episodes,
        first: u64,
        units: &[Vec<f64>],
    ) -> Result<Outcomes, Problem> {
        let stage = self.host.events.begin(title, units.len() as u64);
        let mut all = Vec::with_capacity(units.len());
        for from in (0..units.len()).step_by(CHUNK) {
            let range = from..(from + CHUNK).min(units.len());
            let mut inputs = match of {
                Episodes::Round => self.inputs.clone(),
                Episodes::Check => self.check_inputs.clone(),
            };
            inputs.add_json("units", &&units[range.clone()]);
            inputs.add("first", &(first + from as u64).to_le_bytes());
            let inputs = inputs.hash();
            let name = format!("episodes-{:07}.json", first + from as u64);
            let outcomes = match self.store.fresh(&name, &inputs) {
                Some(Kept(outcomes)) => {
                    range.clone().for_each(|_| stage.advance());
                    outcomes
                }
                None => {
                    let made = self.chunk(of, (first, units), range, &stage)?;
                    self.store.keep(&name, &inputs, Kept(made.clone()))?;
                    made
                }
            };
            all.extend(outcomes);
        }
        Ok(all)
    }

    fn chunk(
        &self,
        of: Episodes,
        (first, units): (u64, &[Vec<f64>]),
        range: Range<usize>,
        stage: &Stage,
    ) -> Result<Outcomes, Problem> {
        let one = |index: usize| {
            let stimulus = stimulus_at(self.rig.stimulus(), &self.space, &units[index])?;
            let outcomes = self.episode(of, &stimulus, self.seeds.of(first + index as u64))?;
            stage.advance();
            Ok(outcomes)
        };
        range.into_par_iter().map(one).collect()
    }

    /// Runs one episode and says of each way to fail: violated or occurred (`true`), not (`false`),
    /// or no opportunity.
    fn episode(
        &self,
        of: Episodes,
        stimulus: &Stimulus,
        seed: u64,
    ) -> Result<Vec<Option<bool>>, Problem> {
        self.host.go_on()?;
        let cancel = &self.host.cancel;
        let rig = match of {
            Episodes::Round => self.rig,
            Episodes::Check => self.check_rig,
        };
        let recorded = rig
            .run(stimulus, seed, &mut Unwatched, cancel)
            .map_err(|error| simulation_problem(error, seed))?;
        let judgements = self.judges.judge(&recorded.trace)?;
        let of = |mode: &str| {
            let judgement = judgements
                .iter()
                .find(|j| j.subject.id() == mode && j.reading.is_none());
            match judgement?.findings.verdict {
                Verdict::Violated => Some(true),
                Verdict::Satisfied => Some(false),
                Verdict::NotCovered | Verdict::Inconclusive => None,
            }
        };
        let modes = self.reality.observed.iter();
        Ok(modes.map(|observed| of(&observed.mode)).collect())
    }
}

/// An error of the campaign as a problem.
pub fn bad_calibration(error: impl std::fmt::Display) -> Problem {
    Problem::new(CODE, error.to_string()).remedy("correct the calibration's file")
}

fn identification(of: Identifiability) -> Identification {
    match of {
        Identifiability::Identified => Identification::Identified,
        Identifiability::Weak => Identification::WeaklyIdentified,
        Identifiability::Unidentified => Identification::NotIdentified,
    }
}
