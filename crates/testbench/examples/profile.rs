//! Says how much processor time episodes take in each state of the robot.
//!
//! `cargo run --release -p testbench --example profile -- tuned 20 [first seed]`

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use testbench::robot::State;
use testbench::{Cancel, Engine, HandoverBench, Savable, Status, Unwatched};

/// Processor time of this thread.
fn used() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = arguments.first().map_or("tuned", String::as_str);
    let count: u64 = arguments.get(1).map_or(Ok(20), |text| text.parse())?;
    let first_seed: u64 = arguments.get(2).map_or(Ok(1), |text| text.parse())?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = root.join("case-studies/handover/simulation");
    let engine = Engine::load(&root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0"))?;
    let mut scenario = std::fs::read_to_string(folder.join("scenario.toml"))?;
    if std::env::var_os("CAMPAIGN_FAST").is_some() {
        scenario = scenario.replacen("[simulation]", "[simulation]\nfast = true", 1);
    }
    let bench = HandoverBench::new(
        &engine,
        &scenario,
        &std::fs::read_to_string(folder.join(format!("{set}.toml")))?,
    )?;
    let stimulus = bench.own_test("typical use")?;
    let mut spent: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    let (mut start_secs, mut total_secs, mut total_sim_secs) = (0.0, 0.0, 0.0);
    for seed in first_seed..first_seed + count {
        let began = used();
        let mut running = bench.start(&stimulus, seed)?;
        start_secs += (used() - began).as_secs_f64();
        loop {
            let part = used();
            let from_secs = bench.now_secs(&running);
            let until_secs = from_secs + 0.02;
            let status =
                bench.advance(&mut running, until_secs, &mut Unwatched, &Cancel::default())?;
            let robot = bench.so_far(&running).channel("/robot");
            let robot = robot.ok_or("the trace has no topic of the robot")?;
            let state = robot.values[robot.values.len() - robot.fields.len()] as u64;
            let entry = spent.entry(state).or_default();
            entry.0 += (used() - part).as_secs_f64();
            entry.1 += bench.now_secs(&running) - from_secs;
            if status != Status::Running {
                break;
            }
        }
        total_sim_secs += bench.now_secs(&running);
        bench.finish(running)?;
        total_secs += (used() - began).as_secs_f64();
    }
    let count = count as f64;
    println!("state                simulated s      ms  us per 2 ms  (per episode)");
    for (state, (secs, sim_secs)) in spent {
        let name = State::NAMES
            .get(state as usize)
            .map_or("?", |(_, name)| name);
        println!(
            "{name:<20} {:>10.2} {:>8.2} {:>10.1}",
            sim_secs / count,
            1e3 * secs / count,
            1e6 * secs / sim_secs * 0.002
        );
    }
    println!(
        "building the physics {:.2} ms; everything {:.1} ms for {:.1} s: {:.0} times real time",
        1e3 * start_secs / count,
        1e3 * total_secs / count,
        total_sim_secs / count,
        total_sim_secs / total_secs
    );
    Ok(())
}
