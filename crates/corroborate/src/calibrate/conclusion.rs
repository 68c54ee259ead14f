//! Counted against predicted, and against the fitted set: what is shown of their likeness.
//!
//! # Definition
//! Of each way to fail that was held out, fitted set and evidence are two counts. They are *equivalent* if
//! a difference of the study's margin or more is refuted at the study's level of agreement, *different* if
//! they differ beyond chance (Holm over all, 5 %) or its prediction does, and otherwise *undecided*. That no difference
//! was found shows nothing by itself. What was fitted is a *fit*; so is what follows from it, told
//! by the episodes: most of its occurrences come with one of something fitted, in the same
//! episode. A success rate whose failures were fitted one by one is such.
//!
//! All is equivalent if each held-out quantity is and there is one; different if anything differs, fitted or held
//! out, or the runs of people who were predicted from the others; else undecided. No correction is needed
//! for equivalence of all, since each has to be shown by itself.
//!
//! # Source and guarantee
//! The tests are those of `compare`: [`fn@stats::exact_equivalence`], and Fisher's for the difference; correlated trials (same person) are down-weighted,
//! for equivalence. The level of a wrong "equivalent" is that of those tests.

use super::counts::Reality;
use super::work::{Outcomes, bad_calibration};
use campaign::calibration::{Calibration, Posterior, Prediction, Predictive};
use diagnostic::Problem;
use evidence::{HeldOutRunsReport, Likeness, ModeReport, PredictionReport};
use stats::{
    Confidence, EffectiveSample, Sample, exact_equivalence, fisher_exact, holm, whole_counts,
};

/// Below this, after Holm's correction, a difference counts.
const DIFFERENCE: f64 = 0.05;

/// Of the occurrences of something held out, more than this share with something fitted: derived.
const DERIVED: f64 = 0.5;

/// Each way to fail: what was counted, what is predicted, what the fitted set shows.
pub fn mode_reports(
    reality: &Reality,
    calibration: &Calibration,
    posterior: &Posterior,
    check: &Outcomes,
    agreement: Confidence,
) -> Result<Vec<ModeReport>, Problem> {
    let simulated = || {
        let rounds = calibration.episodes().iter().map(|it| &it.outcomes);
        rounds.chain(check)
    };
    let mut reports = counted_reports(reality, calibration, posterior, check)?;
    for (mode, report) in reports.iter_mut().enumerate().filter(|(_, it)| it.held_out) {
        report.derived_share = derived_share(reality, mode, simulated());
    }
    judge(&mut reports, agreement);
    Ok(reports)
}

/// Of the episodes in which `mode` occurred, the share in which something fitted did; `None` if it
/// never occurred.
fn derived_share<'o>(
    reality: &Reality,
    mode: usize,
    episodes: impl Iterator<Item = &'o Vec<Option<bool>>>,
) -> Option<f64> {
    let (mut occurred, mut with_fitted) = (0_u64, 0_u64);
    for outcomes in episodes.filter(|outcomes| outcomes[mode] == Some(true)) {
        occurred += 1;
        let mut others = reality.observed.iter().zip(outcomes);
        let is_with = others.any(|(it, outcome)| !it.held_out && *outcome == Some(true));
        with_fitted += u64::from(is_with);
    }
    (occurred > 0).then(|| with_fitted as f64 / occurred as f64)
}

/// What is shown of each.
fn judge(reports: &mut [ModeReport], agreement: Confidence) {
    let checks: Vec<f64> = reports.iter().map(|it| it.check_p).collect();
    let predictions: Vec<f64> = reports
        .iter()
        .map(|it| it.predictive_p.filter(|_| it.held_out).unwrap_or(1.0))
        .collect();
    let corrected = holm(&checks).into_iter().zip(holm(&predictions));
    for (report, (check, prediction)) in reports.iter_mut().zip(corrected) {
        let is_derived = report.derived_share.is_some_and(|share| share > DERIVED);
        let is_alike = report.equivalence_p.is_some_and(|p| p <= agreement.alpha());
        report.likeness = if check < DIFFERENCE || prediction < DIFFERENCE {
            Likeness::Different
        } else if !report.held_out || is_derived {
            Likeness::Fit
        } else if is_alike {
            Likeness::Equivalent
        } else {
            Likeness::Undecided
        };
    }
}

/// p-value of "the two differ by the margin or more".
fn equivalence_p(evidence: Sample, worth: f64, fitted: Sample, margin: f64) -> Option<f64> {
    let effective = EffectiveSample {
        successes: evidence.rate()? * worth,
        trials: worth,
    };
    let all = whole_counts(evidence, effective).into_iter();
    all.map(|whole| exact_equivalence(whole, fitted, margin))
        .reduce(|a, b| Some(a?.max(b?)))?
}

fn counted_reports(
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
                margin: reality.margins[mode],
                effective_opportunities: reality.effective[mode],
                equivalence_p: equivalence_p(
                    counted,
                    reality.effective[mode],
                    checked,
                    reality.margins[mode],
                ),
                derived_share: None,
                likeness: Likeness::Undecided,
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

/// What all of it shows, and why, in words.
pub fn conclusion(modes: &[ModeReport], runs: &[HeldOutRunsReport]) -> (Likeness, String) {
    let named = |likeness: Likeness| -> Vec<&str> {
        let those = modes.iter().filter(|mode| mode.likeness == likeness);
        those.map(|mode| mode.id.as_str()).collect()
    };
    let of_runs = runs.iter().flat_map(|group| &group.predictions);
    let p_values: Vec<f64> = of_runs.filter_map(|it| it.predictive_p).collect();
    let different = named(Likeness::Different);
    if !different.is_empty() {
        let because = format!("beyond chance differs: {}", different.join(", "));
        return (Likeness::Different, because);
    }
    if holm(&p_values).iter().any(|p| *p < DIFFERENCE) {
        let because = "the runs of some people differ from their prediction from the others";
        return (Likeness::Different, because.into());
    }
    let (alike, open) = (named(Likeness::Equivalent), named(Likeness::Undecided));
    let shown = |alike: &[&str]| match alike {
        [] => String::new(),
        alike => format!("; within the margin: {}", alike.join(", ")),
    };
    if !open.is_empty() {
        let because = format!(
            "no difference was found, and equivalence is not shown of: {}{}",
            open.join(", "),
            shown(&alike)
        );
        return (Likeness::Undecided, because);
    }
    if alike.is_empty() {
        let because = "nothing was held out that does not follow from what was fitted";
        return (Likeness::Undecided, because.into());
    }
    let because = format!(
        "all that was held out is within its margin: {}",
        alike.join(", ")
    );
    (Likeness::Equivalent, because)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts of the evidence and of the fitted set, at a margin of 5 points.
    fn mode(held_out: bool, evidence: (u64, u64), fitted: (u64, u64)) -> ModeReport {
        let sample = |(k, n): (u64, u64)| Sample::new(k, n).unwrap();
        let (counted, checked) = (sample(evidence), sample(fitted));
        ModeReport {
            id: "slip".into(),
            held_out,
            occurrences: evidence.0,
            opportunities: evidence.1,
            fitted_occurrences: evidence.0,
            fitted_opportunities: evidence.1,
            by_subject: false,
            intraclass_correlation: None,
            predicted_rate: 0.02,
            predicted_low: 0,
            predicted_high: 6,
            predictive_p: Some(0.5),
            surface_p: None,
            check_occurrences: fitted.0,
            check_opportunities: fitted.1,
            check_p: fisher_exact(checked, counted),
            margin: 0.05,
            effective_opportunities: evidence.1 as f64,
            equivalence_p: equivalence_p(counted, evidence.1 as f64, checked, 0.05),
            derived_share: None,
            likeness: Likeness::Undecided,
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

    fn concluded(mut modes: Vec<ModeReport>, runs: &[HeldOutRunsReport]) -> (Likeness, String) {
        judge(&mut modes, Confidence::P95);
        conclusion(&modes, runs)
    }

    #[test]
    fn no_difference_is_not_equivalence() {
        use Likeness::{Different, Equivalent, Undecided};
        let fit = || mode(false, (2, 100), (4, 200));
        // 2 of 100 against 4 of 200 is no difference, and too little to show that it is within 5 points ...
        let few = mode(true, (1, 20), (3, 60));
        assert_eq!(concluded(vec![fit(), few], &[]).0, Undecided);
        // ... with more trials it is shown; of people whose trials are all alike it is not.
        let many = || mode(true, (8, 400), (8, 400));
        let (likeness, because) = concluded(vec![fit(), many()], &[runs(0.2)]);
        assert_eq!(likeness, Equivalent, "{because}");
        let p = |worth| {
            let sample = Sample::new(8, 400).unwrap();
            equivalence_p(sample, worth, sample, 0.05).unwrap()
        };
        assert!(p(400.0) < 0.05 && p(20.0) > 0.05);
        // A difference counts, of what was fitted as well, and of runs that were predicted.
        let far = |held_out| mode(held_out, (2, 100), (80, 200));
        assert_eq!(concluded(vec![fit(), far(true)], &[]).0, Different);
        assert_eq!(concluded(vec![far(false), many()], &[]).0, Different);
        assert_eq!(concluded(vec![fit(), many()], &[runs(0.001)]).0, Different);
        let mut unlikely = many();
        unlikely.predictive_p = Some(0.001);
        assert_eq!(concluded(vec![fit(), unlikely], &[]).0, Different);
    }

    #[test]
    fn what_follows_from_a_fit_shows_nothing() {
        let derived = || ModeReport {
            derived_share: Some(0.97),
            ..mode(true, (8, 400), (8, 400))
        };
        let (likeness, because) = concluded(vec![mode(false, (2, 100), (4, 200)), derived()], &[]);
        assert_eq!(likeness, Likeness::Undecided);
        assert!(because.contains("follow from what was fitted"), "{because}");
        // It can contradict all the same.
        let far = ModeReport {
            derived_share: Some(0.97),
            ..mode(true, (2, 100), (80, 200))
        };
        assert_eq!(concluded(vec![far], &[]).0, Likeness::Different);
    }
}
