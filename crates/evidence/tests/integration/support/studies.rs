//! Studies that are drawn: nothing in them is chosen to fit.

use super::{Uniform, at_least, computed, exact, piece, requirement, subject};
use evidence::*;
use stats::{Confidence, Sample};

/// A measure of any kind, near a rate.
pub fn any_measure(uniform: &mut Uniform, technique: Technique, rate: f64) -> Measure {
    match technique {
        Technique::ModelChecking => match uniform.of(&[0, 1, 2, 3, 4]) {
            0 => exact(rate),
            4 => Measure::NotExpressible {
                reason: "It has no distances.".into(),
            },
            1 => {
                let (low, high) = ((rate - 0.01).max(0.0), (rate + 0.01).min(1.0));
                computed(rate, Guarantee::Bounded { low, high }, None)
            }
            2 => {
                let reason = "it stopped".to_owned();
                computed(rate, Guarantee::Estimated { reason }, None)
            }
            _ => {
                let of = |share: f64| rate * (0.8 + 0.2 * share);
                let quantiles: Vec<f64> = (0..100).map(|i| of((i as f64 + 0.5) / 100.0)).collect();
                let credible = CredibleInterval {
                    mean: of(0.5),
                    interval: Interval {
                        low: of(0.025),
                        high: of(0.975),
                    },
                    solves: 100,
                    by_function: false,
                    spread: vec![],
                    quantiles,
                    robust: None,
                    ends: None,
                    out_of_reach: 0.0,
                };
                computed(of(0.5), Guarantee::Exact { rational: None }, Some(credible))
            }
        },
        _ => {
            let trials = uniform.of(&[0, 3, 20, 60, 200, 1000]);
            let sample = Sample {
                successes: uniform.count(trials, rate),
                trials,
            };
            if trials >= 20 && uniform.chance(0.3) {
                let size = uniform.of(&[2, 5, 10]);
                let people = uniform.people((trials / size) as usize, size, rate, 0.2);
                return Measure::of_clusters(&people, Confidence::P95).expect("counts");
            }
            let worth = (trials > 3 && uniform.chance(0.3)).then_some(0.4 * trials as f64);
            match trials {
                0 => Measure::NotCovered {
                    reason: "It never came up.".into(),
                    constant: None,
                },
                _ => Measure::of_counts(sample, worth, Confidence::P95).expect("a measure"),
            }
        }
    }
}

/// A study of any kind.
pub fn any_study(uniform: &mut Uniform) -> (Vec<Evidence>, Vec<Requirement>) {
    let count = 1 + (uniform.draw() * 4.0) as usize;
    let mut requirements: Vec<Requirement> = (0..count)
        .map(|index| {
            let value = uniform.of(&[0.5, 0.8, 0.9, 0.95, 0.99]);
            requirement(
                index,
                uniform.of(&[
                    None,
                    at_least(value),
                    at_least(value),
                    Some((Direction::AtMost, value)),
                    Some((Direction::AtMost, 1.0 - value)),
                ]),
            )
        })
        .collect();
    if count > 1 && uniform.chance(0.3) {
        requirements[count - 1].same_quantity_as = Some("0".into());
    }
    for requirement in &mut requirements {
        requirement.needs = uniform.of(&Step::ALL);
    }
    let rates: Vec<f64> = (0..count)
        .map(|_| uniform.of(&[0.05, 0.5, 0.85, 0.9, 0.95, 0.99, 1.0]))
        .collect();
    let mut ledger: Vec<Evidence> = Vec::new();
    for place in 0..1 + (uniform.draw() * 5.0) as usize {
        let technique = uniform.of(&[
            Technique::ModelChecking,
            Technique::Simulation,
            Technique::Experiment,
            Technique::Operation,
        ]);
        let off = uniform.of(&[0.0, 0.0, -0.05, 0.03]);
        let mut findings = Vec::new();
        for (index, rate) in rates.iter().enumerate() {
            let own = requirements[index].same_quantity_as.is_none();
            if own && uniform.chance(0.8) {
                let rate = (rate + off).clamp(0.0, 1.0);
                findings.push((index, any_measure(uniform, technique, rate)));
            }
        }
        let mut piece = piece(&format!("E{place}"), technique, findings);
        for finding in &mut piece.findings {
            finding.undecided = uniform.of(&[0, 0, 0, 1, 7]);
            triggered(uniform, finding);
        }
        if uniform.chance(0.2) {
            piece.conditions = "crowded".into();
        }
        piece.intermediate = uniform.chance(0.15);
        if place > 0 && uniform.chance(0.2) {
            piece.calibrated = vec![Calibration {
                parameter: "p".into(),
                from: "E0".into(),
                subject: subject(0),
                chosen: false,
            }];
        }
        ledger.push(piece);
    }
    (ledger, requirements)
}

/// Makes a figure that of the runs that trigger its subject, or of all, with how often these come.
fn triggered(uniform: &mut Uniform, finding: &mut Finding) {
    let share = uniform.of(&[0.1, 0.5]);
    match (uniform.of(&[0, 0, 0, 1, 2]), &finding.measure) {
        (1, Measure::Counts { trials, .. }) => {
            finding.denominator = Denominator::Triggered;
            let sample = Sample {
                successes: *trials,
                trials: (*trials as f64 / share) as u64,
            };
            let of_all = Measure::of_counts(sample, None, Confidence::P95).expect("counts");
            finding.trigger = (finding.undecided == 0).then(|| Box::new(of_all));
        }
        (1, Measure::Probability { .. }) => {
            finding.denominator = Denominator::Triggered;
            finding.trigger = Some(Box::new(exact(share)));
        }
        (2, Measure::Probability { .. }) => {
            finding.denominator = Denominator::AllRuns {
                reason: "Its trigger is unknown.".into(),
            };
        }
        _ => {}
    }
}
