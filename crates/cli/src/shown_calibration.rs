//! What a calibration found, for people.

use diagnostic::counted;
use evidence::{CalibrationReport, Likeness, ModeReport, PredictionReport};
use std::fmt::{Result, Write};

/// Correlations of at least this are told.
const NOTABLE: f64 = 0.4;

/// For people.
pub fn as_text(report: &CalibrationReport) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(text: &mut String, report: &CalibrationReport) -> Result {
    writeln!(
        text,
        "Fitted to {}, from {}",
        report.evidence,
        counted(report.episodes, "episode")
    )?;
    writeln!(text, "  {}", report.guarantee)?;
    write_parameters(text, report)?;
    write_directions(text, report)?;
    writeln!(text, "\nWays to fail")?;
    writeln!(
        text,
        "  {:<26} {:>8}  {:>17}  {:>6}  {:>10}  {:>6}  {:>6}  {:>6}",
        "", "counted", "predicted (95 %)", "p", "fitted set", "p", "margin", "p"
    )?;
    for mode in &report.modes {
        write_mode(text, mode)?;
    }
    write_held_out_runs(text, report)?;
    let conclusion = report.conclusion.words();
    writeln!(
        text,
        "\nFitted set and {}: {conclusion}; {}.",
        report.evidence, report.because
    )
}

fn write_parameters(text: &mut String, report: &CalibrationReport) -> Result {
    let interval = format!("median [{} %]", 100.0 * report.confidence);
    writeln!(
        text,
        "\nParameters\n  {:<24} {:>18}  {:>28}  {:>8}  {:>6}  {:>8}  by learnt: 80 %, 50 %, less",
        "", "prior", interval, "fitted", "learnt", "sd/prior"
    )?;
    for it in &report.parameters {
        let unit = it
            .unit
            .as_ref()
            .map_or(String::new(), |unit| format!(" ({unit})"));
        writeln!(
            text,
            "  {:<24} {:>18}  {:>28}  {:>8.4}  {:>4.0} %  {:>8.2}  {}",
            format!("{}{unit}", it.name),
            format!("{:.4} to {:.4}", it.prior[0], it.prior[1]),
            format!("{:.4} [{:.4}, {:.4}]", it.median, it.low, it.high),
            it.fitted,
            100.0 * it.contraction.max(0.0),
            it.deviation_ratio,
            it.identifiability.words(),
        )?;
    }
    Ok(())
}

fn write_directions(text: &mut String, report: &CalibrationReport) -> Result {
    for direction in &report.directions {
        let parts = report.parameters.iter().zip(&direction.loadings);
        let parts = parts
            .filter(|(_, loading)| loading.abs() > 0.2)
            .map(|(parameter, loading)| format!("{loading:+.2} {}", parameter.name));
        let parts: Vec<String> = parts.collect();
        let said = direction.identifiability.words();
        writeln!(
            text,
            "  {said}: {} ({:.0} % of the prior's variance is left)",
            parts.join(" "),
            100.0 * direction.variance_share
        )?;
    }
    for (i, row) in report.correlations.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if correlation.abs() >= NOTABLE {
                writeln!(
                    text,
                    "  known only together: {} and {} (correlation {correlation:+.2})",
                    report.parameters[j].name, report.parameters[i].name
                )?;
            }
        }
    }
    Ok(())
}

fn write_held_out_runs(text: &mut String, report: &CalibrationReport) -> Result {
    for group in &report.held_out_runs {
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

fn p_value(p: Option<f64>) -> String {
    p.map_or("-".into(), |p| format!("{p:.3}"))
}

fn write_mode(text: &mut String, mode: &ModeReport) -> Result {
    let how = match (mode.held_out, mode.intraclass_correlation) {
        (true, _) if mode.likeness == Likeness::Fit => {
            let share = 100.0 * mode.derived_share.unwrap_or(1.0);
            format!("held out, but follows from what was fitted ({share:.0} % of its occurrences)")
        }
        (true, _) => format!("held out: {}", mode.likeness.words()),
        (false, _) if mode.likeness == Likeness::Different => "fitted: different".to_owned(),
        (false, None) => "fitted".to_owned(),
        (false, Some(correlation)) => {
            format!("fitted; trials of one subject correlate by {correlation:.2}")
        }
    };
    writeln!(
        text,
        "  {:<26} {:>8}  {:>17}  {:>6}  {:>10}  {:>6.3}  {:>6}  {:>6}  {how}",
        mode.id,
        format!("{}/{}", mode.fitted_occurrences, mode.fitted_opportunities),
        format!("{} to {}", mode.predicted_low, mode.predicted_high),
        p_value(mode.predictive_p),
        format!("{}/{}", mode.check_occurrences, mode.check_opportunities),
        mode.check_p,
        mode.margin,
        p_value(mode.equivalence_p),
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
