//! Whether plans for clustered trials keep the chance that they promise: people are drawn, a plan is made from them,
//! further people are drawn and all of them concluded from. Rates are drawn as Jeffreys' prior has them.

use super::*;
use crate::uniform::Uniform;
use stats::{ClusteredRate, CommonCorrelation, Sample, clustered_rate, pool, wilson};

const LEVEL: Confidence = Confidence::P95;
const THRESHOLD: f64 = 0.8;

/// The chance that is promised for so many further trials, and whether they settle it.
fn promised_and_kept(now: &ClusteredRate, further: u64, then: &ClusteredRate) -> (f64, f64) {
    let effect = now.total.trials as f64 / now.worth.trials;
    let worth = (further as f64 / effect).round() as u64;
    let next = Predictive::new(&BetaPosterior::jeffreys(now.worth), worth);
    let (below, above) = chances(
        (now.worth, Looked(None)),
        effect > 1.0,
        &next,
        THRESHOLD,
        LEVEL,
    );
    let promised = below + above;
    let clustered = then.worth.trials < then.total.trials as f64;
    let (below, above) = shown_below_and_above(then.worth, clustered, THRESHOLD, LEVEL);
    (promised, f64::from(u8::from(below || above)))
}

#[test]
fn plans_for_people_keep_what_they_promise() {
    let (people, further, repetitions) = (10, 20, 60);
    let mut uniform = Uniform(1);
    let prior = BetaPosterior::new(0.5, 0.5).expect("Jeffreys' prior");
    // Counted by person; as totals with a common correlation; as totals taken for independent.
    let mut sums = [(0.0, 0.0); 3];
    for _ in 0..repetitions {
        let mean = prior.quantile(uniform.draw().clamp(0.01, 0.99));
        let (mut counted, mut other) = (
            uniform.people(people, 10, mean, 0.3),
            uniform.people(people, 10, 0.6, 0.3),
        );
        let rates = |counted: &[Sample], other: &[Sample]| {
            let common = CommonCorrelation::of(&[other]).expect("counts");
            let total = pool(counted).expect("counts");
            let sizes = vec![10; counted.len()];
            [
                clustered_rate(counted, LEVEL).expect("counts"),
                common.rate(total, &sizes, LEVEL).expect("counts"),
                ClusteredRate {
                    total,
                    clusters: 1,
                    method: stats::ClusterMethod::Independent,
                    interval: wilson(total, LEVEL),
                    worth: total.into(),
                },
            ]
        };
        let now = rates(&counted, &other);
        counted.extend(uniform.people(further, 10, mean, 0.3));
        other.extend(uniform.people(further, 10, 0.6, 0.3));
        let then = rates(&counted, &other);
        for (kind, sum) in sums.iter_mut().enumerate() {
            // What totals settle is judged with what is right: their common correlation.
            let judged = &then[kind.min(1)];
            let (promised, kept) = promised_and_kept(&now[kind], 10 * further as u64, judged);
            *sum = (sum.0 + promised, sum.1 + kept);
        }
    }
    let shares = sums.map(|(promised, kept)| {
        (
            promised / f64::from(repetitions),
            kept / f64::from(repetitions),
        )
    });
    // Four standard deviations of a share of the repetitions is 0.2; the draws are the same for all.
    assert!(shares[0].0 < shares[0].1 + 0.08, "{shares:?}");
    assert!(shares[1].0 < shares[1].1 + 0.08, "{shares:?}");
    assert!(shares[2].0 > shares[1].0 + 0.03, "{shares:?}");
}
