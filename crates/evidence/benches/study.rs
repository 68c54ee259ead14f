//! How long it takes to compare, conclude from and diagnose a full study: 8 requirements, 8 failure
//! modes, 4 techniques with 10^6 episodes in all, clustered experiments and a model whose constants
//! are uncertain.
//!
//! Run with `cargo bench -p corroborate-evidence`.

use divan::Bencher;
use evidence::*;
use stats::{BetaPosterior, Confidence, Draws};

fn main() {
    divan::main();
}

const REQUIREMENTS: usize = 8;
const MODES: usize = 8;

/// Rates that differ a little between techniques, so that all outcomes occur.
fn rate(subject: usize, piece: usize) -> f64 {
    let base = [0.88, 0.95, 0.999, 0.5, 1.0, 0.7, 0.97, 0.9][subject % 8];
    let shift = [0.0, 0.004, -0.012, 0.03][piece % 4] * ((subject % 3) as f64);
    if subject < REQUIREMENTS {
        (base - shift).clamp(0.0, 1.0)
    } else {
        (1.0 - base + shift).clamp(0.0, 1.0)
    }
}

fn counts(subject: usize, piece: usize, trials: u64, effect: f64) -> Measure {
    let count = (trials as f64 * rate(subject, piece)).round() as u64;
    Measure::Counts {
        by_subject: None,
        subjects: None,
        count,
        trials,
        effective_trials: (effect > 1.0).then_some(trials as f64 / effect),
        interval: Interval {
            low: 0.0,
            high: 1.0,
        },
    }
}

fn computed(subject: usize) -> Measure {
    let value = rate(subject, 0);
    let size = 300.0;
    let answer = MethodAnswer {
        method: "sound".into(),
        value,
        complement: None,
        guarantee: Guarantee::Bounded {
            low: value,
            high: value,
        },
        iterations: None,
    };
    let credible = BetaPosterior::new(value * size + 0.5, (1.0 - value) * size + 0.5)
        .ok()
        .map(|posterior| {
            let draws: Vec<f64> = (0..100)
                .map(|i| posterior.quantile((f64::from(i) + 0.5) / 100.0))
                .collect();
            let summary = Draws::new(&draws).map(|draws| draws.interval(Confidence::P95));
            let interval = summary.map_or(
                Interval {
                    low: 0.0,
                    high: 1.0,
                },
                |i| Interval {
                    low: i.low,
                    high: i.high,
                },
            );
            CredibleInterval {
                mean: posterior.mean(),
                interval,
                solves: 1000,
                by_function: false,
                spread: vec![],
                quantiles: draws,
                robust: None,
                ends: None,
                out_of_reach: 0.0,
            }
        });
    Measure::Probability {
        answer,
        others: vec![],
        credible,
    }
}

fn piece(
    index: usize,
    id: &str,
    technique: Technique,
    measure: impl Fn(usize) -> Measure,
) -> Evidence {
    let subject = |index: usize| {
        if index < REQUIREMENTS {
            Subject::Requirement(format!("{index}"))
        } else {
            Subject::FailureMode(format!("mode {}", index - REQUIREMENTS))
        }
    };
    Evidence {
        id: id.into(),
        title: format!("Piece {index}"),
        technique,
        tool: Tool {
            name: "any".into(),
            version: "1".into(),
            settings: String::new(),
        },
        assets: vec![],
        conditions: "typical".into(),
        changed: String::new(),
        calibrated: vec![],
        intermediate: false,
        published: false,
        reproduced_by: None,
        findings: (0..REQUIREMENTS + MODES)
            .map(|index| Finding {
                subject: subject(index),
                measure: measure(index),
                denominator: evidence::Denominator::default(),
                trigger: None,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: (0..50).map(|seed| format!("episode {seed}")).collect(),
                readings: vec![],
            })
            .collect(),
        form_differences: vec![],
        description_gaps: vec![],
        failures: vec![],
        clusters: None,
        shared_rows: Vec::new(),
        common_texts: Vec::new(),
        shared_seeds: Vec::new(),
        undecided_at_random: None,
        alike_trials: None,
        lineage_questions: Vec::new(),
        inputs: String::new(),
    }
}

struct Full {
    requirements: Vec<Requirement>,
    failure_modes: Vec<FailureMode>,
    evidence: Vec<Evidence>,
}

fn full() -> Full {
    let requirement = |index: usize| Requirement {
        id: format!("{index}"),
        text: String::new(),
        threshold: Some(Threshold {
            direction: Direction::AtLeast,
            value: 0.9,
        }),
        sentence: None,
        property: None,
        monitor: None,
        margin: 0.02,
        asks_for: None,
        same_quantity_as: None,
        ..Requirement::default()
    };
    let mode = |index: usize| FailureMode {
        id: format!("mode {index}"),
        name: String::new(),
        meaning: String::new(),
        margin: 0.02,
    };
    Full {
        requirements: (0..REQUIREMENTS).map(requirement).collect(),
        failure_modes: (0..MODES).map(mode).collect(),
        evidence: vec![
            piece(0, "model", Technique::ModelChecking, computed),
            piece(1, "simulation", Technique::Simulation, |s| {
                counts(s, 1, 900_000, 1.0)
            }),
            piece(2, "experiments", Technique::Experiment, |s| {
                counts(s, 2, 400, 1.8)
            }),
            piece(3, "operation", Technique::Operation, |s| {
                counts(s, 3, 99_600, 3.0)
            }),
        ],
    }
}

impl Full {
    fn study<'a>(&'a self, influences: &'a Influences) -> Result<Study<'a>, stats::StatsError> {
        Ok(Study {
            requirements: &self.requirements,
            failure_modes: &self.failure_modes,
            evidence: &self.evidence,
            influences,
            levels: Levels::new(0.95, 0.95)?,
            looks: None,
        })
    }
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn compare_conclude_and_diagnose(bencher: Bencher) {
    let full = full();
    let influences = Influences::learn(&full.evidence);
    let study = full.study(&influences).expect("levels are between 0 and 1");
    bencher.bench_local(|| {
        let comparisons = compare(&study);
        let conclusions = conclude(&study, &comparisons);
        let together = compare_together(&study, &comparisons);
        let matter = Matter {
            requirements: &full.requirements,
            failure_modes: &full.failure_modes,
            evidence: &full.evidence,
            comparisons: &comparisons,
            cells: &[],
            tables: &[],
            study: "full",
        };
        let suspects = rank(&matter, Vec::new());
        (
            comparisons,
            conclusions,
            together,
            suspects,
            coverage_gaps(&study),
        )
    });
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn plan_for_the_undecided(bencher: Bencher) {
    let full = full();
    let influences = Influences::learn(&full.evidence);
    let study = full.study(&influences).expect("levels are between 0 and 1");
    let comparisons = compare(&study);
    bencher.bench_local(|| undecided(&study, &mut comparisons.clone(), &TrialCosts::equal()));
}
