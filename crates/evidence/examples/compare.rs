//! A model and trials of one requirement: compared, concluded from, and what would decide.
//!
//! `cargo run -p corroborate-evidence --example compare`

use evidence::{
    Evidence, Finding, Influences, Levels, Measure, Requirement, Study, Subject, Technique,
    compare, conclude,
};
use stats::{Confidence, Sample};

fn main() -> Result<(), stats::StatsError> {
    let subject = Subject::Requirement("1".into());
    let requirements = [Requirement::new("1", "At least 85 % of grasps succeed.")
        .at_least(0.85)
        .margin(0.1)];

    let model = Evidence::new("E1", Technique::ModelChecking)
        .titled("Formal model")
        .found(Finding::new(subject.clone(), Measure::exact(0.93)));
    let grasped = Measure::of_counts(Sample::new(188, 200)?, None, Confidence::P95)?;
    let trials = Evidence::new("E2", Technique::Experiment)
        .titled("Two hundred grasps")
        .found(Finding::new(subject, grasped));

    let ledger = [model, trials];
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &requirements,
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        levels: Levels::new(0.95, 0.95)?,
        looks: None,
    };
    let comparisons = compare(&study);
    for pair in &comparisons {
        println!("{} and {}: {:?}", pair.left, pair.right, pair.outcome);
    }
    for conclusion in conclude(&study, &comparisons) {
        println!("{}: {}", conclusion.requirement, conclusion.verdict.words());
    }
    Ok(())
}
