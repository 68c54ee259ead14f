//! Two counted rates: their intervals, whether they differ, and whether they agree within a margin.
//!
//! `cargo run -p corroborate-stats --example two_rates -- 88 100 439 500 0.1`

use stats::{Confidence, Sample, boschloo_exact, exact_equivalence, wilson};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [a, n, b, m, margin] = arguments.as_slice() else {
        return Err("usage: two_rates SUCCESSES TRIALS SUCCESSES TRIALS MARGIN".into());
    };
    let first = Sample::new(a.parse()?, n.parse()?)?;
    let second = Sample::new(b.parse()?, m.parse()?)?;
    let margin: f64 = margin.parse()?;

    for sample in [first, second] {
        let interval = wilson(sample, Confidence::P95);
        println!(
            "{}/{}: 95 % interval {interval}",
            sample.successes, sample.trials
        );
    }
    println!("no difference: p = {:.3}", boschloo_exact(first, second));
    match exact_equivalence(first, second, margin) {
        Some(p) => println!("a difference of {margin} or more: p = {p:.3}"),
        None => println!("too many trials for the exact test of equivalence"),
    }
    Ok(())
}
