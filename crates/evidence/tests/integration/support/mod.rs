//! What the tests and the simulations of this crate share: seeded numbers, and pieces of evidence to judge.
#![allow(dead_code, reason = "each test and example uses its part")]

mod studies;
mod uniform;

use evidence::*;
use stats::{Confidence, Sample};
#[allow(unused_imports, reason = "each test and example uses its part")]
pub use studies::any_study;
pub use uniform::Uniform;

pub fn subject(index: usize) -> Subject {
    Subject::Requirement(index.to_string())
}

/// Counts of independent trials.
pub fn counts(count: u64, trials: u64) -> Measure {
    let sample = Sample::new(count, trials).expect("counts");
    Measure::of_counts(sample, None, Confidence::P95).expect("a measure")
}

pub fn computed(value: f64, guarantee: Guarantee, credible: Option<CredibleInterval>) -> Measure {
    Measure::Probability {
        answer: MethodAnswer {
            method: "sound".into(),
            value,
            complement: None,
            guarantee,
            iterations: None,
        },
        others: vec![],
        credible,
    }
}

/// A probability that a model computes exactly.
pub fn exact(value: f64) -> Measure {
    computed(value, Guarantee::Exact { rational: None }, None)
}

/// A piece of evidence with measures of requirements.
pub fn piece(id: &str, technique: Technique, findings: Vec<(usize, Measure)>) -> Evidence {
    let findings = findings.into_iter();
    findings.fold(Evidence::new(id, technique), |piece, (index, measure)| {
        piece.found(Finding::new(subject(index), measure))
    })
}

/// A requirement with a margin of 10 points.
pub fn requirement(index: usize, threshold: Option<(Direction, f64)>) -> Requirement {
    Requirement {
        id: index.to_string(),
        threshold: threshold.map(|(direction, value)| Threshold { direction, value }),
        margin: 0.1,
        ..Requirement::default()
    }
}

pub fn at_least(value: f64) -> Option<(Direction, f64)> {
    Some((Direction::AtLeast, value))
}
