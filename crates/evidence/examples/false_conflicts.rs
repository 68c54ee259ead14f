//! How often a study reports a conflict that is not there, by its number of requirements.
//!
//! `cargo run -p corroborate-evidence --release --example false_conflicts` prints the table in the documentation of `compare/closed.rs`.
//!
//! Each requirement has a model's exact value, a simulation and two experiments. All four have the same true rate, which
//! is the threshold, so that every conflict is false. In the second half of the table every second requirement has one
//! experiment whose rate is lower by 0.3: conflicts among the other pieces are false, and the study tests fewer true
//! hypotheses.

#[path = "../tests/integration/support/mod.rs"]
mod support;

use evidence::*;
use serde_json::{Value, json};
pub use support::Uniform;

/// Trials of the simulation and of both experiments.
const TRIALS: [u64; 3] = [200, 60, 40];
const IDS: [&str; 4] = ["M", "S", "E", "F"];
const RATES: [f64; 5] = [0.9, 0.95, 0.8, 0.6, 0.99];
/// Margins for which conflicts are counted.
pub const MARGINS: [f64; 3] = [0.001, 0.05, 0.1];

/// Which false statements a study made.
#[derive(Clone, Copy, Default)]
pub struct Found {
    /// A conflict between pieces of one rate, at each margin.
    pub conflict: [bool; 3],
    /// The model meets a threshold that an experiment or the simulation misses, tested at the level of one requirement
    /// divided by its pieces: what would be called conflicting by a verdict that did not go by the study's comparisons.
    pub uncorrected: bool,
    /// A conflict that is there was found.
    pub power: bool,
}

fn rate(requirement: usize) -> f64 {
    RATES[requirement % RATES.len()]
}

fn is_faulty(requirement: usize, faults: bool) -> bool {
    faults && requirement % 2 == 1
}

/// Parts of the ledger as they stand in a study's JSON.
fn evidence(counts: &[[u64; 3]]) -> Vec<Evidence> {
    let finding = |requirement: usize, piece: usize| -> Value {
        let measure = match piece {
            0 => {
                json!({"kind": "probability", "answer": {"method": "exact", "value": rate(requirement),
                "complement": null, "guarantee": {"kind": "exact"}, "iterations": null},
                "others": [], "credible": null})
            }
            _ => {
                json!({"kind": "counts", "count": counts[requirement][piece - 1], "trials": TRIALS[piece - 1],
                "effective_trials": null, "interval": {"low": 0.0, "high": 1.0}})
            }
        };
        json!({"subject": {"kind": "requirement", "id": requirement.to_string()}, "measure": measure,
            "undecided": 0, "witnesses": [], "readings": []})
    };
    let techniques = ["model-checking", "simulation", "experiment", "experiment"];
    let piece = |place: usize| {
        let findings: Vec<Value> = (0..counts.len()).map(|it| finding(it, place)).collect();
        let piece = json!({"id": IDS[place], "title": IDS[place], "technique": techniques[place],
            "tool": {"name": "", "version": "", "settings": ""}, "assets": [], "conditions": "typical",
            "changed": "", "calibrated": [], "intermediate": false, "published": false, "reproduced_by": null,
            "findings": findings, "form_differences": [], "failures": [], "clusters": null, "inputs": ""});
        serde_json::from_value(piece).expect("the form of evidence")
    };
    (0..IDS.len()).map(piece).collect()
}

fn requirements(count: usize) -> Vec<Requirement> {
    let one = |index: usize| Requirement {
        id: index.to_string(),
        threshold: Some(Threshold {
            direction: Direction::AtLeast,
            value: rate(index),
        }),
        margin: MARGINS[0],
        ..Requirement::default()
    };
    (0..count).map(one).collect()
}

/// One study of so many requirements, with faults in every second of them or without.
pub fn study(uniform: &mut Uniform, count: usize, faults: bool) -> Found {
    let draw = |uniform: &mut Uniform, requirement: usize| {
        let last = rate(requirement)
            - if is_faulty(requirement, faults) {
                0.3
            } else {
                0.0
            };
        let rates = [rate(requirement), rate(requirement), last];
        [0, 1, 2].map(|piece| uniform.count(TRIALS[piece], rates[piece]))
    };
    let counts: Vec<[u64; 3]> = (0..count).map(|it| draw(uniform, it)).collect();
    let (ledger, asked) = (evidence(&counts), requirements(count));
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &asked,
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        levels: Levels::new(0.95, 0.95).expect("levels"),
        looks: None,
    };
    let comparisons = compare(&study);
    let of = |c: &Comparison| c.subject.id().parse::<usize>().expect("a number");
    let is_true = |c: &&Comparison| is_faulty(of(c), faults) && c.right == IDS[3];
    let conflicts = |c: &&Comparison| c.outcome == Outcome::Conflicts;
    let conflict = MARGINS.map(|margin| {
        let mut all = comparisons.iter().filter(|c| !is_true(c)).filter(conflicts);
        all.any(|c| c.difference.is_some_and(|it| it.abs() >= margin))
    });
    let level = 0.05 / IDS.len() as f64;
    Found {
        conflict,
        uncorrected: (0..count)
            .filter(|it| !is_faulty(*it, faults))
            .any(|it| misses(it, &counts[it], level)),
        power: comparisons
            .iter()
            .filter(|c| is_true(c))
            .any(|c| conflicts(&c)),
    }
}

/// Whether a count shows the requirement to be missed.
fn misses(requirement: usize, counts: &[u64; 3], level: f64) -> bool {
    counts.iter().zip(TRIALS).any(|(count, trials)| {
        let sample = stats::Sample::new(*count, trials).expect("counts");
        stats::binomial_test_below(sample, rate(requirement)) <= level
    })
}

#[allow(dead_code)] // The test that includes this file has no use for it.
fn main() {
    println!("percent of studies with a false conflict (margins {MARGINS:?}),");
    println!("with a model that meets and a count that misses a threshold, and with a fault found");
    println!("requirements  faults  studies  conflicts          uncorrected  power");
    for (count, studies) in [(1, 2000), (2, 1000), (5, 400), (10, 200)] {
        for faults in [false, true] {
            let mut uniform = Uniform(count as u64 + 100 * u64::from(faults));
            let all: Vec<Found> = (0..studies)
                .map(|_| study(&mut uniform, count, faults))
                .collect();
            let share = |which: &dyn Fn(&Found) -> bool| {
                100.0 * all.iter().filter(|it| which(it)).count() as f64 / f64::from(studies)
            };
            let [a, b, c] = [0, 1, 2].map(|place| share(&|it: &Found| it.conflict[place]));
            println!(
                "{count:>12}  {faults:<6}  {studies:>7}  {a:5.2} {b:5.2} {c:5.2}  {:11.2}  {:5.1}",
                share(&|it: &Found| it.uncorrected),
                share(&|it: &Found| it.power)
            );
        }
    }
}
