//! The relations of a pair (`Relation`), each with what it states: the largest probability over a grid of true rates that
//! what a relation states is wrong, as the sum over all outcomes. Of "they differ" the rates are equal, of "they differ by
//! less than the margin" they are the margin or more apart.

use super::several::concluded;
use super::support::{at_least, counts, exact, piece, requirement};
use super::table::{Job, Rate, Row, all};
use evidence::*;
use stats::special::binomial_pmf;

/// What is compared.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub first: u64,
    /// `Err` for a known rate.
    pub second: Result<u64, f64>,
    pub margin: f64,
}

/// Rates that are gone through, from 0 to 1.
const POINTS: u32 = 200;

/// The relation of every outcome, by rows of the first side.
fn relations(case: &Case) -> Vec<Vec<Relation>> {
    let asked = [Requirement {
        margin: case.margin,
        ..requirement(0, at_least(0.5))
    }];
    let of = |first: u64, second: Measure| {
        let technique = match case.second {
            Ok(_) => Technique::Simulation,
            Err(_) => Technique::ModelChecking,
        };
        let ledger = [
            piece(
                "E",
                Technique::Experiment,
                vec![(0, counts(first, case.first))],
            ),
            piece("S", technique, vec![(0, second)]),
        ];
        concluded(&ledger, &asked, None).0[0]
            .relation
            .expect("a relation")
    };
    let row = |first: u64| match case.second {
        Ok(trials) => (0..=trials)
            .map(|it| of(first, counts(it, trials)))
            .collect(),
        Err(known) => vec![of(first, exact(known))],
    };
    (0..=case.first).map(row).collect()
}

/// For each relation its largest probabilities over rates that are equal, less than the margin apart, and the margin or
/// more apart.
pub struct Largest(pub [[f64; 3]; RELATIONS.len()]);

pub const RELATIONS: [Relation; 6] = [
    Relation::Equivalent,
    Relation::TrivialDifference,
    Relation::DifferenceWithinMargin,
    Relation::Different,
    Relation::Indeterminate,
    Relation::IndeterminateOutside,
];

/// Of relations taken together.
pub struct Together {
    /// "They differ", of equal rates.
    pub different: f64,
    /// "They agree", of rates that are the margin or more apart.
    pub agree: f64,
    /// "They conflict", of rates that are less than the margin apart: nothing is promised of it.
    pub conflict_within: f64,
}

pub fn largest(case: &Case) -> (Largest, Together) {
    let relations = relations(case);
    let weights = |trials: u64, rate: f64| -> Vec<f64> {
        (0..=trials)
            .map(|it| binomial_pmf(it, trials, rate))
            .collect()
    };
    let (mut found, mut together) = ([[0.0_f64; 3]; RELATIONS.len()], [0.0_f64; 3]);
    for (a, b, kind) in rates(case) {
        let first = weights(case.first, a);
        let second = case.second.map_or(vec![1.0], |trials| weights(trials, b));
        let mut sums = [0.0; RELATIONS.len()];
        for (row, x) in relations.iter().zip(&first) {
            for (relation, y) in row.iter().zip(&second) {
                let place = RELATIONS.iter().position(|it| it == relation);
                sums[place.expect("all are listed")] += x * y;
            }
        }
        for (most, sum) in found.iter_mut().zip(sums) {
            most[kind] = most[kind].max(sum);
        }
        let of = match kind {
            0 => sums[1] + sums[2] + sums[3],
            1 => sums[3],
            _ => sums[0] + sums[1],
        };
        together[kind] = together[kind].max(of);
    }
    let together = Together {
        different: together[0],
        agree: together[2],
        conflict_within: together[1],
    };
    (Largest(found), together)
}

/// True rates with what they are: 0 equal, 1 apart by less than the margin, 2 by the margin or more.
fn rates(case: &Case) -> Vec<(f64, f64, usize)> {
    let grid = || (0..=POINTS).map(|it| f64::from(it) / f64::from(POINTS));
    let seconds: Vec<f64> = match case.second {
        Ok(_) => grid().collect(),
        Err(known) => vec![known],
    };
    let mut all = Vec::new();
    for b in seconds {
        all.push((b, b, 0));
        for sign in [-1.0, 1.0] {
            for (share, kind) in [(0.5, 1), (0.99, 1), (1.0, 2), (1.5, 2), (2.5, 2)] {
                let a = b + sign * share * case.margin;
                if (0.0..=1.0).contains(&a) {
                    all.push((a, b, kind));
                }
            }
        }
    }
    all
}

fn rows_of(case: &Case) -> Vec<Row> {
    let second = match case.second {
        Ok(trials) => format!("{trials} trials"),
        Err(known) => format!("a model's {known}"),
    };
    let name = format!("{} trials and {second}, margin {}", case.first, case.margin);
    let (Largest(cells), together) = largest(case);
    let row = |statement, rate, most| Row {
        case: name.clone(),
        statement,
        rate: Rate::Exact(rate),
        most,
    };
    let half = Some(0.05);
    vec![
        row("equivalent, though apart by the margin", cells[0][2], half),
        row(
            "trivial difference, though apart by the margin",
            cells[1][2],
            half,
        ),
        row("trivial difference, though equal", cells[1][0], half),
        row(
            "difference within the margin, though equal",
            cells[2][0],
            half,
        ),
        row("different, though equal", cells[3][0], half),
        row(
            "any relation of a difference, though equal",
            together.different,
            half,
        ),
        row(
            "any relation of agreement, though apart by the margin",
            together.agree,
            half,
        ),
        row(
            "different, though apart by less than the margin",
            together.conflict_within,
            None,
        ),
    ]
}

pub fn rows(_: u64) -> Vec<Row> {
    let cases = [
        (12, Ok(12), 0.2),
        (20, Ok(60), 0.2),
        (60, Ok(60), 0.1),
        (40, Ok(200), 0.15),
        (60, Err(0.9), 0.1),
        (200, Err(0.95), 0.05),
        (1000, Err(0.5), 0.05),
    ];
    let jobs: Vec<Job<'_>> = cases
        .into_iter()
        .map(|(first, second, margin)| {
            let case = Case {
                first,
                second,
                margin,
            };
            Box::new(move || rows_of(&case)) as Job<'_>
        })
        .collect();
    all(&jobs)
}
