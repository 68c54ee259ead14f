//! Attempts of people who differ: their rates have a beta distribution with an intraclass correlation. Beside them stand a
//! model that computes the mean and a simulation that counts at it.

use super::several::{concluded, is_of_system};
use super::support::{Uniform, at_least, counts, exact, piece, requirement};
use super::table::{Job, Row, all};
use evidence::*;
use stats::Confidence;

/// Who made the attempts, and what is asked.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub people: usize,
    pub each: u64,
    pub correlation: f64,
    pub rate: f64,
    pub requirements: usize,
}

const MARGIN: f64 = 0.1;

/// Wrong statements of studies: a conflict somewhere, a verdict of the system somewhere (violated, satisfied), agreement
/// of the people with a simulation a margin away, and an interval of the first rate that misses it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wrong {
    pub conflicts: u64,
    pub violated: u64,
    pub satisfied: u64,
    pub agreements: u64,
    pub misses: u64,
}

pub fn wrong(case: &Case, studies: u64) -> Wrong {
    let mut uniform = Uniform(1000 * case.people as u64 + case.requirements as u64);
    let asked: Vec<Requirement> = (0..case.requirements)
        .map(|it| requirement(it, at_least(case.rate)))
        .collect();
    let mut wrong = Wrong::default();
    for _ in 0..studies {
        let by_people: Vec<Measure> = (0..case.requirements)
            .map(|_| {
                let people = uniform.people(case.people, case.each, case.rate, case.correlation);
                Measure::of_clusters(&people, Confidence::P95).expect("counts")
            })
            .collect();
        let interval = by_people[0].interval().expect("an interval");
        wrong.misses += u64::from(!interval.contains(case.rate));
        let all = |measures: Vec<Measure>| measures.into_iter().enumerate().collect();
        let mut simulated = |rate: f64| -> Vec<Measure> {
            let one = |_| counts(uniform.count(400, rate), 400);
            (0..case.requirements).map(one).collect()
        };
        let ledger = [
            piece(
                "M",
                Technique::ModelChecking,
                all(vec![exact(case.rate); case.requirements]),
            ),
            piece("S", Technique::Simulation, all(simulated(case.rate))),
            piece("E", Technique::Experiment, all(by_people.clone())),
        ];
        let (comparisons, found) = concluded(&ledger, &asked, None);
        let any = |verdict| u64::from(found.iter().any(|it| is_of_system(it, verdict)));
        wrong.conflicts += u64::from(
            comparisons
                .iter()
                .any(|it| it.p_difference_corrected.is_some_and(|p| p <= 0.05)),
        );
        wrong.violated += any(Verdict::Violated);
        wrong.satisfied += any(Verdict::Satisfied);
        let apart = [
            piece(
                "S",
                Technique::Simulation,
                vec![(0, counts(uniform.count(400, case.rate - MARGIN), 400))],
            ),
            piece("E", Technique::Experiment, vec![(0, by_people[0].clone())]),
        ];
        let (comparisons, _) = concluded(&apart, &asked[..1], None);
        wrong.agreements += u64::from(comparisons[0].outcome == Outcome::Corroborates);
    }
    wrong
}

fn of(case: &Case, studies: u64) -> Vec<Row> {
    let found = wrong(case, studies);
    let name = format!(
        "{} people x {}, correlation {}, rate {}, {}",
        case.people,
        case.each,
        case.correlation,
        case.rate,
        match case.requirements {
            1 => "1 requirement".to_owned(),
            many => format!("{many} requirements"),
        }
    );
    let row = |statement, found| Row::counted(&name, statement, (found, studies), Some(0.05));
    vec![
        row("a difference, somewhere", found.conflicts),
        row("violated, somewhere", found.violated),
        row("satisfied, somewhere", found.satisfied),
        row("agrees with a rate a margin away", found.agreements),
        row("the interval misses the rate", found.misses),
    ]
}

pub fn rows(studies: u64) -> Vec<Row> {
    let mut jobs: Vec<Job<'_>> = Vec::new();
    for (people, each) in [(5, 10), (10, 10), (20, 5)] {
        for (correlation, rate) in [(0.0, 0.9), (0.1, 0.9), (0.3, 0.9), (0.3, 0.7)] {
            for requirements in [1, 4] {
                let case = Case {
                    people,
                    each,
                    correlation,
                    rate,
                    requirements,
                };
                let studies = studies / requirements as u64;
                jobs.push(Box::new(move || of(&case, studies)));
            }
        }
    }
    // Whose attempts are so alike that the likely cohort has nobody who fails.
    for requirements in [1, 4] {
        let case = Case {
            people: 25,
            each: 4,
            correlation: 0.6,
            rate: 0.9,
            requirements,
        };
        jobs.push(Box::new(move || of(&case, studies)));
    }
    all(&jobs)
}
