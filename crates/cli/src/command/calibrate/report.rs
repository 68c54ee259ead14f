//! What a calibration found, as JSON and as text.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// What `calibrate --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CalibrationReport {
    /// Version of this form.
    pub format: String,
    /// The physics engine with its version.
    pub engine: String,
    /// The evidence whose counts were to be reproduced.
    pub evidence: String,
    /// What the numbers rest on.
    pub guarantee: String,
    /// Episodes that the posterior rests on.
    pub episodes: u64,
    /// What the posterior's sample is worth in independent points.
    pub effective_size: f64,
    /// Level of the intervals.
    pub confidence: f64,
    /// What was fitted.
    pub parameters: Vec<ParameterReport>,
    /// Correlations of the parameters, row by row, on the scale of their priors.
    pub correlations: Vec<Vec<f64>>,
    /// Directions of the parameters, the least known first.
    pub directions: Vec<DirectionReport>,
    /// Ways to fail, fitted ones first.
    pub modes: Vec<ModeReport>,
    /// Whether the fitted set reproduces what was counted.
    pub reproduces: bool,
    /// The fitted parameter set, as TOML.
    pub parameter_set: String,
}

/// One fitted parameter.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ParameterReport {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// The keys that it sets.
    pub sets: Vec<String>,
    /// Lowest and highest value of the prior.
    pub prior: [f64; 2],
    /// The value of the fitted set.
    pub fitted: f64,
    /// The posterior's median.
    pub median: f64,
    /// Lower end of the credible interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How much of the prior's variance is gone, on the prior's scale.
    pub contraction: f64,
}

/// A direction of the parameters.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DirectionReport {
    /// How much of it each parameter is.
    pub loadings: Vec<f64>,
    /// Posterior variance over prior variance.
    pub variance_share: f64,
    /// Whether the counts hardly say anything about it.
    pub unidentified: bool,
}

/// One way to fail.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ModeReport {
    /// The requirement or failure mode.
    pub id: String,
    /// Whether it was kept out of the fit.
    pub held_out: bool,
    /// How often it occurred in the evidence.
    pub occurrences: u64,
    /// How often it could have.
    pub opportunities: u64,
    /// The predicted rate.
    pub predicted_rate: f64,
    /// Counts between which 95 % of the predictions lie.
    pub predicted_low: u64,
    /// Upper end.
    pub predicted_high: u64,
    /// Two-sided predictive p-value of what was counted.
    pub predictive_p: Option<f64>,
    /// Probability of the surface's deviations from its episodes if it is right.
    pub surface_p: Option<f64>,
    /// Occurrences in the fitted set's episodes.
    pub check_occurrences: u64,
    /// Opportunities there.
    pub check_opportunities: u64,
    /// Fisher's exact p-value of fitted set against evidence.
    pub check_p: f64,
}

impl CalibrationReport {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        writeln!(
            text,
            "Fitted to {}, from {} episodes",
            self.evidence, self.episodes
        )?;
        writeln!(text, "  {}\n", self.guarantee)?;
        writeln!(text, "Parameters (prior -> median [interval], learnt)")?;
        for it in &self.parameters {
            let unit = it.unit.as_deref().unwrap_or("");
            writeln!(
                text,
                "  {:<24} [{:.4}, {:.4}] -> {:.4} [{:.4}, {:.4}] {unit}  {:.0} %; fitted {:.4}",
                it.name,
                it.prior[0],
                it.prior[1],
                it.median,
                it.low,
                it.high,
                100.0 * it.contraction.max(0.0),
                it.fitted
            )?;
        }
        self.write_directions(text)?;
        writeln!(text, "\nWays to fail (counted; predicted; fitted set)")?;
        for mode in &self.modes {
            write_mode(text, mode)?;
        }
        writeln!(
            text,
            "\nThe fitted set {} what was counted.",
            if self.reproduces {
                "reproduces"
            } else {
                "does not reproduce"
            }
        )
    }

    fn write_directions(&self, text: &mut String) -> std::fmt::Result {
        let unidentified = self.directions.iter().filter(|d| d.unidentified);
        for direction in unidentified {
            let parts = self.parameters.iter().zip(&direction.loadings);
            let parts = parts
                .filter(|(_, loading)| loading.abs() > 0.2)
                .map(|(parameter, loading)| format!("{loading:+.2} {}", parameter.name));
            writeln!(
                text,
                "  not identified: {} ({:.0} % of the prior's variance is left)",
                parts.collect::<Vec<_>>().join(" "),
                100.0 * direction.variance_share
            )?;
        }
        for (i, row) in self.correlations.iter().enumerate() {
            for (j, correlation) in row.iter().enumerate().take(i) {
                if correlation.abs() >= 0.4 {
                    writeln!(
                        text,
                        "  hang together: {} and {} (correlation {correlation:+.2})",
                        self.parameters[j].name, self.parameters[i].name
                    )?;
                }
            }
        }
        Ok(())
    }
}

fn write_mode(text: &mut String, mode: &ModeReport) -> std::fmt::Result {
    writeln!(
        text,
        "  {:<26} {:>3}/{:<4} {:>3} to {:<3} (p = {})  {:>3}/{:<4} (p = {:.3})  {}",
        mode.id,
        mode.occurrences,
        mode.opportunities,
        mode.predicted_low,
        mode.predicted_high,
        mode.predictive_p.map_or("-".into(), |p| format!("{p:.3}")),
        mode.check_occurrences,
        mode.check_opportunities,
        mode.check_p,
        if mode.held_out { "held out" } else { "fitted" }
    )?;
    match mode.surface_p {
        Some(p) if p < 0.01 => {
            writeln!(
                text,
                "    its response surface does not fit its episodes (p = {p:.4})"
            )
        }
        _ => Ok(()),
    }
}
