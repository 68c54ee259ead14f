//! How often a requirement is called satisfied, or violated, that is not: on each step of the ladder.
//!
//! `cargo run -p corroborate-evidence --release --example ladder` prints the tables of `conclude`. Seeded, so that it prints the same
//! each time.

#[path = "../tests/integration/support/mod.rs"]
mod support;

use evidence::*;
use support::{Uniform, counts, exact, piece};

fn conclusions(
    ledger: &[Evidence],
    requirements: usize,
    threshold: f64,
    family: ErrorFamily,
) -> Vec<Conclusion> {
    let requirement = |index: usize| Requirement {
        id: index.to_string(),
        threshold: Some(Threshold {
            direction: Direction::AtLeast,
            value: threshold,
        }),
        margin: 0.1,
        ..Requirement::default()
    };
    let requirements: Vec<Requirement> = (0..requirements).map(requirement).collect();
    let influences = Influences::learn(ledger);
    let levels = Levels::new(0.95, 0.95)
        .expect("levels")
        .with_error_rates_of(family);
    let study = Study {
        requirements: &requirements,
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks: None,
        levels,
    };
    conclude(&study, &compare(&study))
}

/// A model with a constant, or a simulator, beside trials of a system below the threshold.
fn one_requirement() {
    const STUDIES: u64 = 4000;
    println!("| threshold | system | trials | beside it | satisfied on any step | and enough |");
    println!("|---|---|---|---|---|---|");
    for (threshold, truth) in [(0.9, 0.85), (0.9, 0.89), (0.95, 0.9)] {
        for trials in [10, 50, 200] {
            for (name, technique, value) in [
                ("model, 95 %", Technique::ModelChecking, 0.95),
                ("model, 99 %", Technique::ModelChecking, 0.99),
                ("simulator, 970 of 1000", Technique::Simulation, 0.97),
            ] {
                let mut uniform = Uniform(1);
                let (mut any, mut enough) = (0, 0);
                for _ in 0..STUDIES {
                    let model = match technique {
                        Technique::Simulation => counts((1000.0 * value) as u64, 1000),
                        _ => exact(value),
                    };
                    let counted = counts(uniform.count(trials, truth), trials);
                    let ledger = [
                        piece("M", technique, vec![(0, model)]),
                        piece("E", Technique::Experiment, vec![(0, counted)]),
                    ];
                    let found = &conclusions(&ledger, 1, threshold, ErrorFamily::Study)[0];
                    any += u64::from(found.verdict == Verdict::Satisfied);
                    enough += u64::from(found.is_enough());
                }
                let share = |count: u64| format!("{:.1}", 100.0 * count as f64 / STUDIES as f64);
                println!(
                    "| {threshold} | {truth} | {trials} | {name} | {} | {} |",
                    share(any),
                    share(enough)
                );
            }
        }
    }
}

/// Several requirements, all of them at their thresholds.
fn several_requirements() {
    const STUDIES: u64 = 4000;
    println!(
        "\n| requirements | trials | error rate of | any false \"violated\" | any false \"satisfied\" |"
    );
    println!("|---|---|---|---|---|");
    for requirements in [1, 2, 5, 10] {
        for trials in [50, 200] {
            for family in [ErrorFamily::Study, ErrorFamily::Requirement] {
                let mut uniform = Uniform(2);
                let (mut violated, mut satisfied) = (0, 0);
                for _ in 0..STUDIES {
                    let measures = |uniform: &mut Uniform| -> Vec<(usize, Measure)> {
                        let all = 0..requirements;
                        all.map(|it| (it, counts(uniform.count(trials, 0.9), trials)))
                            .collect()
                    };
                    let ledger = [piece("E", Technique::Experiment, measures(&mut uniform))];
                    let found = conclusions(&ledger, requirements, 0.9, family);
                    let any =
                        |wanted: Verdict| u64::from(found.iter().any(|c| c.verdict == wanted));
                    violated += any(Verdict::Violated);
                    satisfied += any(Verdict::Satisfied);
                }
                let share = |count: u64| format!("{:.1}", 100.0 * count as f64 / STUDIES as f64);
                let of = match family {
                    ErrorFamily::Study => "the study",
                    ErrorFamily::Requirement => "each",
                };
                println!(
                    "| {requirements} | {trials} | {of} | {} | {} |",
                    share(violated),
                    share(satisfied)
                );
            }
        }
    }
}

fn main() {
    one_requirement();
    several_requirements();
}
