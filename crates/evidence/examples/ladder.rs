//! How often a requirement is called satisfied, or violated, that is not: on each step of the ladder.
//!
//! `cargo run -p evidence --release --example ladder` prints the tables of `conclude`. Seeded, so that it prints the same
//! each time.

use evidence::{
    Conclusion, Direction, ErrorFamily, Evidence, Finding, Guarantee, Influences, Interval, Levels,
    Measure, MethodAnswer, Requirement, Study, Subject, Technique, Threshold, Tool, Verdict,
    compare, conclude,
};

/// Uniform numbers: SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn count(&mut self, trials: u64, rate: f64) -> u64 {
        (0..trials).filter(|_| self.next() < rate).count() as u64
    }
}

fn counts(count: u64, trials: u64) -> Measure {
    Measure::Counts {
        count,
        trials,
        effective_trials: None,
        interval: Interval {
            low: 0.0,
            high: 1.0,
        },
    }
}

fn computed(value: f64) -> Measure {
    Measure::Probability {
        answer: MethodAnswer {
            method: "exact".into(),
            value,
            complement: None,
            guarantee: Guarantee::Exact { rational: None },
            iterations: None,
        },
        others: Vec::new(),
        credible: None,
    }
}

/// A piece with one measure for each requirement.
fn piece(id: &str, technique: Technique, measures: Vec<Measure>) -> Evidence {
    let finding = |(index, measure): (usize, Measure)| Finding {
        subject: Subject::Requirement(index.to_string()),
        measure,
        denominator: evidence::Denominator::default(),
        trigger: None,
        undecided: 0,
        witnesses: Vec::new(),
        readings: Vec::new(),
    };
    Evidence {
        id: id.into(),
        title: id.into(),
        technique,
        tool: Tool {
            name: String::new(),
            version: String::new(),
            settings: String::new(),
        },
        assets: Vec::new(),
        conditions: "typical".into(),
        changed: String::new(),
        calibrated: Vec::new(),
        intermediate: false,
        published: false,
        reproduced_by: None,
        findings: measures.into_iter().enumerate().map(finding).collect(),
        form_differences: Vec::new(),
        description_gaps: Vec::new(),
        failures: Vec::new(),
        clusters: None,
        shared_rows: Vec::new(),
        lineage_questions: Vec::new(),
        inputs: String::new(),
    }
}

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
                        _ => computed(value),
                    };
                    let counted = counts(uniform.count(trials, truth), trials);
                    let ledger = [
                        piece("M", technique, vec![model]),
                        piece("E", Technique::Experiment, vec![counted]),
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
                    let measures = |uniform: &mut Uniform| -> Vec<Measure> {
                        let all = 0..requirements;
                        all.map(|_| counts(uniform.count(trials, 0.9), trials))
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
