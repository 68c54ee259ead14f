//! Several requirements, all at their thresholds: a model computes the threshold exactly, a simulation and two experiments
//! count at it. Then every "violated", "satisfied" and "conflicting evidence" of the system is wrong (of "satisfied" in
//! the limit, from below the threshold).

use super::support::{Uniform, at_least, counts, exact, piece, requirement};
use super::table::{Job, Row, all};
use evidence::*;

const THRESHOLD: f64 = 0.9;

/// What is said of requirements on a ledger, without looks.
pub fn concluded(
    ledger: &[Evidence],
    requirements: &[Requirement],
    looks: Option<&Looks>,
) -> (Vec<Comparison>, Vec<Conclusion>) {
    let influences = Influences::learn(ledger);
    let study = Study {
        requirements,
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let comparisons = compare(&study);
    let conclusions = conclude(&study, &comparisons);
    (comparisons, conclusions)
}

/// Whether a conclusion has this verdict of the system.
pub fn is_of_system(conclusion: &Conclusion, verdict: Verdict) -> bool {
    conclusion.verdict == verdict && conclusion.step >= Some(Step::Corroborated)
}

fn several(count: usize, trials: u64, studies: u64) -> Vec<Row> {
    let asked: Vec<Requirement> = (0..count)
        .map(|it| requirement(it, at_least(THRESHOLD)))
        .collect();
    let mut uniform = Uniform(100 * count as u64 + trials);
    let mut wrong = [0; 3];
    for _ in 0..studies {
        let mut drawn = |id, technique, trials| {
            let one = |it| (it, counts(uniform.count(trials, THRESHOLD), trials));
            piece(id, technique, (0..count).map(one).collect())
        };
        let ledger = [
            drawn("S", Technique::Simulation, 200),
            drawn("E", Technique::Experiment, trials),
            drawn("F", Technique::Experiment, 40),
            piece(
                "M",
                Technique::ModelChecking,
                (0..count).map(|it| (it, exact(THRESHOLD))).collect(),
            ),
        ];
        let (_, found) = concluded(&ledger, &asked, None);
        let any = |holds: &dyn Fn(&Conclusion) -> bool| u64::from(found.iter().any(holds));
        wrong[0] += any(&|it| is_of_system(it, Verdict::Violated));
        wrong[1] += any(&|it| is_of_system(it, Verdict::Satisfied));
        wrong[2] += any(&|it| it.verdict == Verdict::Conflicting);
    }
    let case = match count {
        1 => format!("1 requirement, {trials} and 40 trials"),
        _ => format!("{count} requirements, {trials} and 40 trials"),
    };
    let statements = [
        "violated, somewhere",
        "satisfied, somewhere",
        "conflicting evidence, somewhere",
    ];
    let rows = statements.into_iter().zip(wrong);
    rows.map(|(statement, wrong)| Row::counted(&case, statement, (wrong, studies), Some(0.05)))
        .collect()
}

pub fn rows(studies: u64) -> Vec<Row> {
    let mut jobs: Vec<Job<'_>> = Vec::new();
    for trials in [60, 200] {
        for count in [1, 5, 10] {
            let studies = (studies / count as u64).max(20);
            jobs.push(Box::new(move || several(count, trials, studies)));
        }
    }
    all(&jobs)
}
