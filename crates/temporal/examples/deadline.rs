//! A requirement with a deadline, judged while time passes: the gripper has to open within two seconds of the release.
//!
//! `cargo run -p corroborate-temporal --example deadline`

use std::error::Error;
use temporal::formula::{Ending, FormulaMonitor, Settings, parse};

fn main() -> Result<(), Box<dyn Error>> {
    // Names without a unit are atoms; `release_time` is a declared parameter.
    let declared = |name: &str| (name == "release_time").then_some(2.0);
    let parsed = parse(
        "always (released => eventually[0, release_time] open)",
        &declared,
    )?;
    let settings = Settings::dense(Ending::Inconclusive).with_robustness();
    let mut judge = FormulaMonitor::compile(&parsed.formula, &settings)?.start();

    // At each time, by how much each atom holds, in the order of `parsed.atoms`: above 0 it is true.
    let samples = [
        (0.0, [-1.0, -0.08]),
        (1.0, [1.0, -0.08]),
        (2.5, [1.0, 0.01]),
        (4.0, [-1.0, 0.02]),
    ];
    for (time_secs, atoms) in samples {
        judge.step(time_secs, &atoms)?;
    }
    let report = judge.finish(true);
    println!("{}: {:?}", parsed.formula, report.verdict);
    println!(
        "put to the test {} times, decided at {:?} s",
        report.triggered, report.decided_at_secs
    );
    if let Some(bounds) = report.robustness {
        println!("robustness between {} and {}", bounds.low, bounds.high);
    }
    Ok(())
}
