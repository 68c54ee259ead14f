//! Runs one episode and prints one topic of its trace as CSV; or, for the topic `model`, prints the
//! episode's physical model as MJCF, to look at in MuJoCo's viewer.
//!
//! `cargo run --release -p corroborate-handover --example episode -- tuned 1 /truth [abstract test]`
//!
//! With `CAMPAIGN_ENGINE=rapier` in Rapier instead of MuJoCo.

use std::path::Path;

use handover::{Parameters, Physics, Scenario, World, run_episode};
use testbench::{Cancel, Engine};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = arguments.first().map_or("tuned", String::as_str);
    let seed: u64 = arguments.get(1).map_or(Ok(1), |text| text.parse())?;
    let topic = arguments.get(2).map_or("/robot", String::as_str);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root
        .join("case-studies/handover/simulation")
        .join(format!("{set}.toml"));
    let folder = file.parent().ok_or("the parameter file is in no folder")?;
    let scenario = Scenario::parse(&std::fs::read_to_string(folder.join("scenario.toml"))?)?;
    let parameters = Parameters::parse(&std::fs::read_to_string(
        folder.join(format!("{set}.toml")),
    )?)?;
    let physics = match std::env::var("CAMPAIGN_ENGINE").as_deref() {
        Ok("rapier") => Physics::Rapier,
        _ => Engine::load(&root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0"))?.into(),
    };
    let mut world = World::new(physics, &scenario, &parameters)?;
    if let Some(test) = arguments.get(3) {
        world = world.with_test(test)?;
    }
    if topic == "model" {
        print!(
            "{}",
            handover::mjcf(&scenario, &parameters, &world.physical_draws(seed))
        );
        return Ok(());
    }
    let episode = run_episode(&world, seed, &Cancel::default())?;
    let channel = episode
        .trace
        .channel(topic)
        .ok_or("the trace has no such topic")?;
    let names: Vec<&str> = channel
        .fields
        .iter()
        .map(|field| field.name.as_str())
        .collect();
    println!("time_secs,{}", names.join(","));
    for (time, row) in channel
        .times_secs
        .iter()
        .zip(channel.values.chunks(names.len()))
    {
        let numbers: Vec<String> = row.iter().map(f64::to_string).collect();
        println!("{time},{}", numbers.join(","));
    }
    Ok(())
}
