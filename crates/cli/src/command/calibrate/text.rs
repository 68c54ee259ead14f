//! What a calibration found, for people.

use super::report::{CalibrationReport, ModeReport, PredictionReport};
use std::fmt::{Result, Write};

/// Correlations of at least this are told.
const NOTABLE: f64 = 0.4;

impl CalibrationReport {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> Result {
        writeln!(
            text,
            "Fitted to {}, from {} episodes",
            self.evidence, self.episodes
        )?;
        writeln!(text, "  {}", self.guarantee)?;
        self.write_parameters(text)?;
        self.write_directions(text)?;
        writeln!(text, "\nWays to fail")?;
        writeln!(
            text,
            "  {:<26} {:>8}  {:>17}  {:>6}  {:>10}  {:>6}",
            "", "counted", "predicted (95 %)", "p", "fitted set", "p"
        )?;
        for mode in &self.modes {
            write_mode(text, mode)?;
        }
        self.write_held_out_runs(text)?;
        let said = match self.reproduces {
            true => {
                "No difference was found between the fitted set, the predictions and what was counted"
            }
            false => {
                "The fitted set, or a prediction of what was held out, differs from what was counted"
            }
        };
        writeln!(text, "\n{said} (Holm, 5 %).")
    }

    fn write_parameters(&self, text: &mut String) -> Result {
        let interval = format!("median [{} %]", 100.0 * self.confidence);
        writeln!(
            text,
            "\nParameters\n  {:<24} {:>18}  {:>28}  {:>8}  {:>6}  {:>8}",
            "", "prior", interval, "fitted", "learnt", "sd/prior"
        )?;
        for it in &self.parameters {
            let unit = it
                .unit
                .as_ref()
                .map_or(String::new(), |unit| format!(" ({unit})"));
            writeln!(
                text,
                "  {:<24} {:>18}  {:>28}  {:>8.4}  {:>4.0} %  {:>8.2}",
                format!("{}{unit}", it.name),
                format!("{:.4} to {:.4}", it.prior[0], it.prior[1]),
                format!("{:.4} [{:.4}, {:.4}]", it.median, it.low, it.high),
                it.fitted,
                100.0 * it.contraction.max(0.0),
                it.deviation_ratio,
            )?;
        }
        Ok(())
    }

    fn write_directions(&self, text: &mut String) -> Result {
        for direction in &self.directions {
            let parts = self.parameters.iter().zip(&direction.loadings);
            let parts = parts
                .filter(|(_, loading)| loading.abs() > 0.2)
                .map(|(parameter, loading)| format!("{loading:+.2} {}", parameter.name));
            let parts: Vec<String> = parts.collect();
            let said = match direction.unidentified {
                true => "not identified",
                false => "identified",
            };
            writeln!(
                text,
                "  {said}: {} ({:.0} % of the prior's variance is left)",
                parts.join(" "),
                100.0 * direction.variance_share
            )?;
        }
        for (i, row) in self.correlations.iter().enumerate() {
            for (j, correlation) in row.iter().enumerate().take(i) {
                if correlation.abs() >= NOTABLE {
                    writeln!(
                        text,
                        "  known only together: {} and {} (correlation {correlation:+.2})",
                        self.parameters[j].name, self.parameters[i].name
                    )?;
                }
            }
        }
        Ok(())
    }

    fn write_held_out_runs(&self, text: &mut String) -> Result {
        for group in &self.held_out_runs {
            let fitted = match group.fitted_set_without_them {
                true => "kept out of the fit",
                false => "predicted from the others",
            };
            let names = group.subjects.join(", ");
            writeln!(text, "\nRuns of {names}, {fitted}")?;
            for prediction in &group.predictions {
                write_prediction(text, prediction)?;
            }
        }
        Ok(())
    }
}

fn p_value(p: Option<f64>) -> String {
    p.map_or("-".into(), |p| format!("{p:.3}"))
}

fn write_mode(text: &mut String, mode: &ModeReport) -> Result {
    let how = match (mode.held_out, mode.intraclass_correlation) {
        (true, _) => "held out".to_owned(),
        (false, None) => "fitted".to_owned(),
        (false, Some(correlation)) => {
            format!("fitted; trials of one subject correlate by {correlation:.2}")
        }
    };
    writeln!(
        text,
        "  {:<26} {:>8}  {:>17}  {:>6}  {:>10}  {:>6.3}  {how}",
        mode.id,
        format!("{}/{}", mode.fitted_occurrences, mode.fitted_opportunities),
        format!("{} to {}", mode.predicted_low, mode.predicted_high),
        p_value(mode.predictive_p),
        format!("{}/{}", mode.check_occurrences, mode.check_opportunities),
        mode.check_p,
    )?;
    match mode.surface_p {
        Some(p) if p < 0.01 => {
            let said = "its response surface does not fit its episodes";
            writeln!(text, "    {said} (p = {p:.4})")
        }
        _ => Ok(()),
    }
}

fn write_prediction(text: &mut String, it: &PredictionReport) -> Result {
    writeln!(
        text,
        "  {:<26} {:>8}  {:>17}  {:>6}",
        it.id,
        format!("{}/{}", it.occurrences, it.opportunities),
        format!("{} to {}", it.predicted_low, it.predicted_high),
        p_value(it.predictive_p),
    )
}
