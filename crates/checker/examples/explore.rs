//! Explores a model and prints its size, the time it took and the peak of the memory.
//!
//! With `NO_REWARDS` in the environment, reward structures are left out; `THREADS` is 1 or 2.
//!
//! `cargo run --release -p corroborate-checker --example explore -- MODEL [name=value,...]`

use std::time::Instant;

use checker::explore::{ExploreOptions, explore_with};
use prism_lang::{Constants, parse_model, resolve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("give the path of a model")?;
    let constants = Constants::parse(&arguments.next().unwrap_or_default())?;
    let text = std::fs::read_to_string(&path)?;
    let parsed = parse_model(&text).into_result();
    let tree = parsed.map_err(|found| format!("{found:?}"))?;
    let model = resolve(&tree, &constants).map_err(|found| format!("{found:?}"))?;
    let start = Instant::now();
    let options = ExploreOptions {
        rewards: std::env::var_os("NO_REWARDS").map(|_| Vec::new()),
        threads: std::env::var("THREADS").map_or(Ok(2), |n| n.parse())?,
        ..ExploreOptions::default()
    };
    let space = explore_with::<f64>(&model, options, &|_| true)?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{path}: {} states, {} choices, {} transitions, {} deadlocks; {seconds:.3} s, {:.2} M states/s, {:.1} M transitions/s{}",
        space.num_states(),
        space.num_choices(),
        space.num_transitions(),
        space.deadlocks().len(),
        space.num_states() as f64 / seconds / 1e6,
        space.num_transitions() as f64 / seconds / 1e6,
        peak().map_or(String::new(), |mib| format!(", peak {mib} MiB")),
    );
    Ok(())
}

/// The greatest resident size of this process, where the system tells.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024)
}
