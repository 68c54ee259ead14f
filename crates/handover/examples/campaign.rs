//! Runs episodes of the handover and prints how they ended and how fast they ran.
//!
//! `cargo run --release -p corroborate-handover --example campaign -- tuned 100 [first seed] [abstract test]`
//!
//! With `CAMPAIGN_FAST=1` in the fast physics, with `CAMPAIGN_FAST=0` in the full one; otherwise as the
//! scenario has it. With `CAMPAIGN_ENGINE=rapier` in Rapier instead of MuJoCo.

use std::path::Path;
use std::time::Instant;

use handover::{Episode, Parameters, Physics, Scenario, World, run_episode};
use testbench::{Cancel, Engine};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = arguments.first().map_or("tuned", String::as_str);
    let count: u64 = arguments.get(1).map_or(Ok(100), |text| text.parse())?;
    let first_seed: u64 = arguments.get(2).map_or(Ok(1), |text| text.parse())?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A parameter file elsewhere brings the scenario beside it.
    let file = root
        .join("case-studies/handover/simulation")
        .join(format!("{set}.toml"));
    let folder = file.parent().ok_or("the parameter file is in no folder")?;
    let mut scenario = Scenario::parse(&std::fs::read_to_string(folder.join("scenario.toml"))?)?;
    if let Some(fast) = std::env::var_os("CAMPAIGN_FAST") {
        scenario.simulation.fast = fast == "1";
    }
    let parameters = Parameters::parse(&std::fs::read_to_string(&file)?)?;
    let physics = match std::env::var("CAMPAIGN_ENGINE").as_deref() {
        Ok("rapier") => Physics::Rapier,
        _ => Engine::load(&root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0"))?.into(),
    };
    let mut world = World::new(physics, &scenario, &parameters)?;
    if let Some(test) = arguments.get(3) {
        world = world.with_test(test)?;
    }
    let began = Instant::now();
    let episodes = (first_seed..first_seed + count)
        .map(|seed| run_episode(&world, seed, &Cancel::default()))
        .collect::<Result<Vec<Episode>, _>>()?;
    summarise(&episodes, began.elapsed().as_secs_f64());
    println!("hash of all traces {:016x}", hash(&episodes));
    if std::env::var_os("CAMPAIGN_DETAILS").is_some() {
        for episode in &episodes {
            println!("{:?} {:?}", episode.trace.metadata, episode.outcome);
        }
    }
    Ok(())
}

/// One number for every bit recorded: FNV-1a (Fowler, Noll, Vo 1991) over times and values.
fn hash(episodes: &[Episode]) -> u64 {
    let channels = episodes.iter().flat_map(|episode| &episode.trace.channels);
    let numbers = channels.flat_map(|channel| channel.times_secs.iter().chain(&channel.values));
    numbers
        .flat_map(|number| number.to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

/// Prints counts of each way an episode can end, and the ratio of simulated to real time.
fn summarise(episodes: &[Episode], wall_secs: f64) {
    let total = episodes.len();
    let count = |name: &str, test: &dyn Fn(&Episode) -> bool, of: usize| {
        let hits = episodes.iter().filter(|episode| test(episode)).count();
        println!(
            "{name:<28} {hits:>5} / {of:<5} {:>6.2} %",
            100.0 * hits as f64 / of.max(1) as f64
        );
    };
    let gripped = |e: &Episode| e.outcome.grasped && !e.outcome.grip_failure && !e.outcome.crashed;
    let opportunities = episodes.iter().filter(|episode| gripped(episode)).count();
    count("success", &|e| e.outcome.success, total);
    count("crashed", &|e| e.outcome.crashed, total);
    count("grip failure", &|e| e.outcome.grip_failure, total);
    count(
        "false negative gaze",
        &|e| gripped(e) && e.outcome.gaze_ok == Some(false),
        opportunities,
    );
    count(
        "false negative pressure",
        &|e| gripped(e) && e.outcome.pressure_ok == Some(false),
        opportunities,
    );
    count(
        "false negative location",
        &|e| gripped(e) && e.outcome.location_ok == Some(false),
        opportunities,
    );
    count(
        "reset above 0.25 m/s",
        &|e| e.outcome.reset_peak_speed_m_s >= 0.25,
        total,
    );
    count(
        "released, human holds it",
        &|e| e.outcome.object_with_human,
        total,
    );
    let sim_secs: f64 = episodes.iter().map(|episode| episode.sim_secs).sum();
    let steps: u64 = episodes.iter().map(|episode| episode.steps).sum();
    println!(
        "{:.1} s simulated in {wall_secs:.2} s: {:.0} times real time, {:.1} us a step, {:.1} s an episode",
        sim_secs,
        sim_secs / wall_secs,
        1e6 * wall_secs / steps as f64,
        sim_secs / total.max(1) as f64
    );
}
