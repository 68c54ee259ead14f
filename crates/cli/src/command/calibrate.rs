//! `corroborate calibrate`: simulator parameters from an evidence's counts.

mod counts;
mod file;
mod report;

use super::rare::bench::TestBench;
use super::{Done, Setting, json, use_threads};
use crate::args::{Calibrate, Format};
use crate::outcome::Outcome;
use crate::problem::{Problem, Source, write_whole};
use crate::store::{Inputs, Store};
use crate::study::Study;
use crate::technique::confidence;
use crate::technique::judging::Judges;
use crate::technique::simulation::Seeds;
use campaign::calibration::{Calibration, CalibrationOptions, Episode, Observed};
use file::{CalibrationText, merge};
use rayon::prelude::*;
use report::{CalibrationReport, DirectionReport, ModeReport, ParameterReport};
use serde::{Deserialize, Serialize};
use stats::{Confidence, Sample, fisher_exact, holm};
use std::fmt::Write;
use std::ops::Range;
use stimulus::{Settings, Space};
use toml::Table;

/// Episodes that are kept together.
const CHUNK: usize = 32;

/// Numbers of the episodes that check the fitted set begin here.
const CHECK_FROM: u64 = 1_000_000;

/// Below this, after Holm's correction, a difference counts.
const DIFFERENCE: f64 = 0.05;

/// What is kept of a chunk of episodes: for each, the outcome of each way to fail.
#[derive(Debug, Serialize, Deserialize)]
struct Outcomes(Vec<Vec<Option<bool>>>);

/// Fits, checks, and writes the fitted set.
pub fn calibrate(arguments: &Calibrate, setting: &Setting) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    let source = Source::read(&arguments.file)?;
    let text = CalibrationText::read(&source)?;
    let level = confidence(text.confidence)?;
    let observed = counts::observed(&study, &text)?;
    let base = base_parameters(&study, &text)?;
    let scenario = Source::read(&study.folder.join(&text.scenario))?;
    let library = setting.physics_library.as_deref();
    let bench = TestBench::new(&scenario, &base, &text.test, library)?;
    let space = text.space();
    bench.bench_accepts(&space)?;
    let folder = arguments.out.clone();
    let folder = folder.unwrap_or_else(|| study.folder.join("results/calibration"));
    let mut inputs = Inputs::default();
    bench.inputs(&mut inputs)?;
    inputs.add("calibration", source.text.as_bytes());
    inputs.add("study", format!("{:?}", study.forms).as_bytes());
    let work = Work {
        judges: Judges::new(&study, |subject| {
            observed.iter().any(|it| it.mode == subject.id())
        })?,
        store: Store::open(&folder)?,
        seeds: Seeds::new(study.about.seed, &format!("calibration: {}", text.name)),
        text: &text,
        bench: &bench,
        observed,
        space,
        inputs,
        setting,
    };
    let report = work.report(&base, level)?;
    if let Some(path) = &arguments.to {
        write_whole(path, report.parameter_set.as_bytes())?;
    }
    Ok(Done {
        outcome: if report.reproduces {
            Outcome::Holds
        } else {
            Outcome::Violated
        },
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => report.text(),
        },
    })
}

/// The parameters to begin with, with what is known in them.
fn base_parameters(study: &Study, text: &CalibrationText) -> Result<Source, Problem> {
    let source = Source::read(&study.folder.join(&text.parameters))?;
    let mut table: Table =
        toml::from_str(&source.text).map_err(|error| Problem::from_toml(&source, &error))?;
    merge(&mut table, &text.known);
    table.insert("name".into(), text.name.clone().into());
    Ok(Source {
        text: written(&table)?,
        name: source.name,
    })
}

fn written(table: &Table) -> Result<String, Problem> {
    toml::to_string(table).map_err(|error| Problem::new("cannot-write", error.to_string()))
}

impl TestBench {
    /// Fails unless the corners of the space can be simulated.
    fn bench_accepts(&self, space: &Space) -> Result<(), Problem> {
        for corner in [0.0, 0.5, 1.0] {
            let unit = vec![corner; space.dimensions()];
            self.bench
                .world(&self.stimulus(space, &unit)?, 0)
                .map_err(|error| super::rare::bench::simulation_problem(error, 0))?;
        }
        Ok(())
    }
}

struct Work<'a> {
    text: &'a CalibrationText,
    bench: &'a TestBench,
    judges: Judges<'a>,
    observed: Vec<Observed>,
    space: Space,
    store: Store,
    inputs: Inputs,
    seeds: Seeds,
    setting: &'a Setting,
}

impl Work<'_> {
    fn report(&self, base: &Source, level: Confidence) -> Result<CalibrationReport, Problem> {
        let calibration = self.rounds()?;
        let posterior = calibration.posterior();
        let fitted = self.space.at(&posterior.mean());
        let settings = self
            .space
            .settings(&fitted)
            .map_err(|error| Problem::new("bad-settings", error.to_string()))?;
        let units = vec![posterior.mean(); self.text.check_episodes as usize];
        let check = self.episodes("fitted set", CHECK_FROM, &units)?;
        let modes = self.modes(&calibration, &check)?;
        let parameters = self.space.parameters.iter().zip(&fitted.0);
        let parameters = parameters.zip(posterior.marginals(level));
        let parameters: Vec<ParameterReport> = parameters
            .map(|((parameter, fitted), marginal)| {
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
                }
            })
            .collect();
        let directions = posterior.directions().into_iter();
        Ok(CalibrationReport {
            format: "1.0".into(),
            engine: self.bench.engine.clone(),
            evidence: self.text.evidence.clone(),
            guarantee: "estimated: posterior by response surfaces (logistic, quadratic) over seeded episodes; checked by episodes of the fitted set".into(),
            episodes: calibration.episodes().len() as u64,
            effective_size: posterior.effective_size(),
            confidence: level.level(),
            correlations: posterior.correlations(),
            directions: directions
                .map(|d| DirectionReport {
                    loadings: d.loadings,
                    variance_share: d.variance_share,
                    unidentified: d.unidentified,
                })
                .collect(),
            reproduces: reproduces(&modes),
            parameter_set: self.parameter_set(base, &settings, &parameters, &modes)?,
            parameters,
            modes,
        })
    }

    fn rounds(&self) -> Result<Calibration, Problem> {
        let options = CalibrationOptions {
            dimensions: self.space.dimensions(),
            points: self.text.points,
            seed: self.seeds.of(0),
        };
        let mut calibration =
            Calibration::new(self.observed.clone(), options).map_err(bad_calibration)?;
        let count = self.text.episodes_per_round;
        for round in 0..self.text.rounds {
            let units = calibration.ask(count as usize);
            let title = format!("round {} of {}", round + 1, self.text.rounds);
            let outcomes = self.episodes(&title, 1 + round * count, &units)?;
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
        first: u64,
        units: &[Vec<f64>],
    ) -> Result<Vec<Vec<Option<bool>>>, Problem> {
        let stage = self.setting.talk.begin(title, units.len() as u64);
        let mut all = Vec::with_capacity(units.len());
        for from in (0..units.len()).step_by(CHUNK) {
            let range = from..(from + CHUNK).min(units.len());
            let mut inputs = self.inputs.clone();
            inputs.add_json("units", &&units[range.clone()]);
            inputs.add("first", &(first + from as u64).to_le_bytes());
            let inputs = inputs.hash();
            let name = format!("episodes-{:07}.json", first + from as u64);
            let outcomes = match self.store.fresh(&name, &inputs) {
                Some(Outcomes(outcomes)) => {
                    range.clone().for_each(|_| stage.advance());
                    outcomes
                }
                None => {
                    let made = self.chunk(first, units, range, &stage)?;
                    self.store.keep(&name, &inputs, Outcomes(made.clone()))?;
                    made
                }
            };
            all.extend(outcomes);
        }
        Ok(all)
    }

    fn chunk(
        &self,
        first: u64,
        units: &[Vec<f64>],
        range: Range<usize>,
        stage: &crate::talk::Stage,
    ) -> Result<Vec<Vec<Option<bool>>>, Problem> {
        let one = |index: usize| {
            let stimulus = self.bench.stimulus(&self.space, &units[index])?;
            let seed = self.seeds.of(first + index as u64);
            let outcomes = counts::episode(
                self.bench,
                &self.judges,
                &self.observed,
                &stimulus,
                seed,
                self.setting,
            )?;
            stage.advance();
            Ok(outcomes)
        };
        range.into_par_iter().map(one).collect()
    }

    fn modes(
        &self,
        calibration: &Calibration,
        check: &[Vec<Option<bool>>],
    ) -> Result<Vec<ModeReport>, Problem> {
        let posterior = calibration.posterior();
        let predicted = calibration.predictive(&posterior);
        let modes = predicted.into_iter().zip(calibration.fits()).enumerate();
        modes
            .map(|(mode, (predicted, fit))| {
                let outcomes: Vec<bool> = check.iter().filter_map(|it| it[mode]).collect();
                let occurred = outcomes.iter().filter(|it| **it).count() as u64;
                let observed = predicted.observed;
                let sample = |k, n| Sample::new(k, n).map_err(bad_calibration);
                let checked = sample(occurred, outcomes.len() as u64)?;
                let counted = sample(observed.occurrences, observed.opportunities)?;
                Ok(ModeReport {
                    id: observed.mode,
                    held_out: observed.held_out,
                    occurrences: observed.occurrences,
                    opportunities: observed.opportunities,
                    predicted_rate: predicted.rate,
                    predicted_low: predicted.count_low,
                    predicted_high: predicted.count_high,
                    predictive_p: predicted.p_value,
                    surface_p: fit.p_value,
                    check_occurrences: checked.successes,
                    check_opportunities: checked.trials,
                    check_p: fisher_exact(checked, counted),
                })
            })
            .collect()
    }

    /// The fitted set as TOML, with what each value was fitted to.
    fn parameter_set(
        &self,
        base: &Source,
        settings: &Settings,
        parameters: &[ParameterReport],
        modes: &[ModeReport],
    ) -> Result<String, Problem> {
        let table: Table =
            toml::from_str(&base.text).map_err(|error| Problem::from_toml(base, &error))?;
        let mut data: Table = [("parameters".to_owned(), table.into())]
            .into_iter()
            .collect();
        stimulus::apply(&mut data, settings)
            .map_err(|error| Problem::new("bad-settings", error.to_string()))?;
        let body = match data.remove("parameters") {
            Some(toml::Value::Table(table)) => written(&table)?,
            _ => String::new(),
        };
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_heading(&mut text, self.text, parameters, modes);
        Ok(text + &body)
    }
}

fn write_heading(
    text: &mut String,
    about: &CalibrationText,
    parameters: &[ParameterReport],
    modes: &[ModeReport],
) -> std::fmt::Result {
    writeln!(
        text,
        "# Written by `corroborate calibrate` from {}: agreement with what it was fitted to is a fit\n# and no independent confirmation.\n#",
        about.parameters.display()
    )?;
    writeln!(text, "# Fitted to the counts of {}:", about.evidence)?;
    for mode in modes.iter().filter(|mode| !mode.held_out) {
        writeln!(
            text,
            "#   {} {}/{}",
            mode.id, mode.occurrences, mode.opportunities
        )?;
    }
    writeln!(
        text,
        "# Fitted values (posterior mean), with their credible intervals:"
    )?;
    for it in parameters {
        let unit = it.unit.as_deref().unwrap_or("");
        writeln!(
            text,
            "#   {}: {:.5} {unit} [{:.5}, {:.5}], sets {}",
            it.name,
            it.fitted,
            it.low,
            it.high,
            it.sets.join(", ")
        )?;
    }
    writeln!(text)
}

/// Whether neither the fitted set's counts nor any prediction of what was held
/// out differ from what was counted.
fn reproduces(modes: &[ModeReport]) -> bool {
    let checks: Vec<f64> = modes.iter().map(|mode| mode.check_p).collect();
    let held_out = modes.iter().filter(|mode| mode.held_out);
    let predictions: Vec<f64> = held_out.filter_map(|mode| mode.predictive_p).collect();
    let differs = |p_values: &[f64]| holm(p_values).iter().any(|p| *p < DIFFERENCE);
    !differs(&checks) && !differs(&predictions)
}

fn bad_calibration(error: impl std::fmt::Display) -> Problem {
    Problem::new("bad-calibration-file", error.to_string()).remedy("correct the calibration's file")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CalibrationReport).into();
        crate::command::tests::assert_schema_is_committed("calibrate.schema.json", &schema);
    }

    fn mode(held_out: bool, predictive_p: f64, check_p: f64) -> ModeReport {
        ModeReport {
            id: "slip".into(),
            held_out,
            occurrences: 2,
            opportunities: 100,
            predicted_rate: 0.02,
            predicted_low: 0,
            predicted_high: 6,
            predictive_p: Some(predictive_p),
            surface_p: None,
            check_occurrences: 6,
            check_opportunities: 300,
            check_p,
        }
    }

    #[test]
    fn a_contradicted_prediction_or_check_is_no_reproduction() {
        assert!(reproduces(&[mode(false, 0.5, 0.9), mode(true, 0.3, 0.4)]));
        assert!(!reproduces(&[
            mode(false, 0.5, 0.001),
            mode(true, 0.3, 0.4)
        ]));
        assert!(!reproduces(&[
            mode(false, 0.5, 0.9),
            mode(true, 0.001, 0.4)
        ]));
        // The p-value of what was fitted only shows that fitting worked.
        assert!(reproduces(&[mode(false, 0.001, 0.9)]));
    }
}
