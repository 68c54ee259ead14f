//! Counted against predicted, and against the fitted set.

use super::counts::Reality;
use super::report::{HeldOutRunsReport, ModeReport, PredictionReport};
use super::work::{Outcomes, bad_calibration};
use crate::problem::Problem;
use campaign::calibration::{Calibration, Posterior, Prediction, Predictive};
use stats::{Sample, fisher_exact, holm};

/// Below this, after Holm's correction, a difference counts.
const DIFFERENCE: f64 = 0.05;

/// Each way to fail: what was counted, what is predicted, what the fitted set shows.
pub fn mode_reports(
    reality: &Reality,
    calibration: &Calibration,
    posterior: &Posterior,
    check: &Outcomes,
) -> Result<Vec<ModeReport>, Problem> {
    let predicted = calibration.predictive(posterior);
    let modes = predicted.into_iter().zip(calibration.fits()).enumerate();
    modes
        .map(|(mode, (predicted, fit))| {
            let outcomes: Vec<bool> = check.iter().filter_map(|it| it[mode]).collect();
            let occurred = outcomes.iter().filter(|it| **it).count() as u64;
            // With what is held out: the fitted set should show all that was counted.
            let whole = &reality.observed[mode];
            let sample = |k, n| Sample::new(k, n).map_err(bad_calibration);
            let checked = sample(occurred, outcomes.len() as u64)?;
            let counted = sample(whole.occurrences, whole.opportunities)?;
            Ok(ModeReport {
                id: whole.mode.clone(),
                held_out: whole.held_out,
                occurrences: whole.occurrences,
                opportunities: whole.opportunities,
                fitted_occurrences: predicted.counted.occurrences,
                fitted_opportunities: predicted.counted.opportunities,
                by_subject: !whole.clusters.is_empty(),
                intraclass_correlation: predicted.correlation,
                predicted_rate: predicted.rate,
                predicted_low: predicted.counted.low,
                predicted_high: predicted.counted.high,
                predictive_p: predicted.counted.p_value,
                surface_p: fit.p_value,
                check_occurrences: checked.successes,
                check_opportunities: checked.trials,
                check_p: fisher_exact(checked, counted),
            })
        })
        .collect()
}

/// Each group of subjects, predicted from the others.
pub fn held_out_runs(
    reality: &Reality,
    calibration: &Calibration,
) -> Result<Vec<HeldOutRunsReport>, Problem> {
    (reality.held_out.iter())
        .map(|group| {
            let without = calibration
                .with_observed(reality.without(group))
                .map_err(bad_calibration)?;
            let predictive = without.predictive(&without.posterior());
            let predictions = predictive.into_iter().filter_map(prediction_report);
            Ok(HeldOutRunsReport {
                subjects: reality.names(group),
                fitted_set_without_them: reality.kept_out,
                predictions: predictions.collect(),
            })
        })
        .collect()
}

fn prediction_report(predictive: Predictive) -> Option<PredictionReport> {
    let Prediction {
        occurrences,
        opportunities,
        low,
        high,
        p_value,
    } = predictive.held_out_runs?;
    Some(PredictionReport {
        id: predictive.observed.mode,
        occurrences,
        opportunities,
        predicted_low: low,
        predicted_high: high,
        predictive_p: p_value,
    })
}

/// Whether neither the fitted set's counts nor any prediction of what was held
/// out differ from what was counted.
pub fn reproduces(modes: &[ModeReport], runs: &[HeldOutRunsReport]) -> bool {
    let checks: Vec<f64> = modes.iter().map(|mode| mode.check_p).collect();
    let held_out = modes.iter().filter(|mode| mode.held_out);
    let of_modes = held_out.filter_map(|mode| mode.predictive_p);
    let of_runs = runs.iter().flat_map(|group| &group.predictions);
    let of_runs = of_runs.filter_map(|prediction| prediction.predictive_p);
    let predictions: Vec<f64> = of_modes.chain(of_runs).collect();
    let differs = |p_values: &[f64]| holm(p_values).iter().any(|p| *p < DIFFERENCE);
    !differs(&checks) && !differs(&predictions)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(held_out: bool, predictive_p: f64, check_p: f64) -> ModeReport {
        ModeReport {
            id: "slip".into(),
            held_out,
            occurrences: 2,
            opportunities: 100,
            fitted_occurrences: 2,
            fitted_opportunities: 100,
            by_subject: false,
            intraclass_correlation: None,
            predicted_rate: 0.02,
            predicted_low: 0,
            predicted_high: 6,
            predictive_p: Some(predictive_p),
            surface_p: None,
            check_occurrences: 4,
            check_opportunities: 200,
            check_p,
        }
    }

    fn runs(predictive_p: f64) -> HeldOutRunsReport {
        HeldOutRunsReport {
            subjects: vec!["3".into()],
            fitted_set_without_them: true,
            predictions: vec![PredictionReport {
                id: "slip".into(),
                occurrences: 3,
                opportunities: 10,
                predicted_low: 0,
                predicted_high: 2,
                predictive_p: Some(predictive_p),
            }],
        }
    }

    #[test]
    fn what_was_held_out_and_the_fitted_set_decide() {
        let good = [mode(false, 0.5, 0.9), mode(true, 0.3, 0.4)];
        assert!(reproduces(&good, &[]) && reproduces(&good, &[runs(0.2)]));
        assert!(!reproduces(&good, &[runs(0.001)]));
        assert!(!reproduces(
            &[mode(false, 0.5, 0.001), mode(true, 0.3, 0.4)],
            &[]
        ));
        assert!(!reproduces(
            &[mode(false, 0.5, 0.9), mode(true, 0.001, 0.4)],
            &[]
        ));
        // The p-value of what was fitted only shows that fitting worked.
        assert!(reproduces(&[mode(false, 0.001, 0.9)], &[]));
    }
}
