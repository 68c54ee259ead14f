//! Says how much processor time episodes take in each state of the robot, recording on.
//!
//! `cargo run --release -p corroborate-handover --example profile -- tuned 20 [first seed]`
//!
//! The full physics alone; with `CAMPAIGN_FAST=1` the fast one alone. With `CAMPAIGN_FAST=both` the two take
//! turns, seed by seed, with a third: the engine alone, which takes the steps of the full physics' episode with nothing
//! around them and ends in the same bits. The last lines are the speeds of the three, in times real time on one core,
//! and as ratios to that of the engine alone.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::time::Duration;

use handover::robot::State;
use handover::{EngineAlone, HandoverBench};
use testbench::{Cancel, Engine, Savable, Status, Unwatched};

/// Processor time of this thread.
fn used() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Time spent, by the robot's state: seconds of the processor and simulated ones.
#[derive(Debug, Default)]
struct Spent {
    by_state: BTreeMap<u64, (f64, f64)>,
    start_secs: f64,
    total_secs: f64,
    sim_secs: f64,
    episodes: f64,
}

impl Spent {
    fn episode(&mut self, bench: &HandoverBench, seed: u64) -> Result<(), Box<dyn Error>> {
        let stimulus = bench.own_test("typical use")?;
        let began = used();
        let mut running = bench.start(&stimulus, seed)?;
        self.start_secs += (used() - began).as_secs_f64();
        loop {
            let part = used();
            let from_secs = bench.now_secs(&running);
            let until_secs = from_secs + 0.02;
            let status =
                bench.advance(&mut running, until_secs, &mut Unwatched, &Cancel::default())?;
            let robot = bench.so_far(&running).channel("/robot");
            let robot = robot.ok_or("the trace has no topic of the robot")?;
            let state = robot.values[robot.values.len() - robot.fields.len()] as u64;
            let entry = self.by_state.entry(state).or_default();
            entry.0 += (used() - part).as_secs_f64();
            entry.1 += bench.now_secs(&running) - from_secs;
            if status != Status::Running {
                break;
            }
        }
        self.sim_secs += bench.now_secs(&running);
        bench.finish(running)?;
        self.total_secs += (used() - began).as_secs_f64();
        self.episodes += 1.0;
        Ok(())
    }

    /// The engine's steps of an episode, without building the physics.
    fn engine_alone(&mut self, bench: &HandoverBench, seed: u64) -> Result<(), Box<dyn Error>> {
        let world = bench.world(&bench.own_test("typical use")?, seed)?;
        let alone = EngineAlone::record(&world, seed)?.ok_or("it is the fast physics")?;
        let mut steps = alone.start()?;
        let began = used();
        let count = steps.take();
        self.total_secs += (used() - began).as_secs_f64();
        self.sim_secs += count as f64 * 0.002;
        self.episodes += 1.0;
        match steps.ended_the_same() {
            true => Ok(()),
            false => Err("the engine alone ends elsewhere".into()),
        }
    }

    fn print(&self) {
        println!("state                simulated s      ms  us per 2 ms  (per episode)");
        for (state, (secs, sim_secs)) in &self.by_state {
            let name = State::NAMES.get(*state as usize);
            println!(
                "{:<20} {:>10.2} {:>8.2} {:>10.1}",
                name.map_or("?", |(_, name)| name),
                sim_secs / self.episodes,
                1e3 * secs / self.episodes,
                1e6 * secs / sim_secs * 0.002
            );
        }
        println!(
            "building the physics {:.2} ms; everything {:.1} ms for {:.1} s: {:.0} times real time",
            1e3 * self.start_secs / self.episodes,
            1e3 * self.total_secs / self.episodes,
            self.sim_secs / self.episodes,
            self.sim_secs / self.total_secs
        );
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = arguments.first().map_or("tuned", String::as_str);
    let count: u64 = arguments.get(1).map_or(Ok(20), |text| text.parse())?;
    let first_seed: u64 = arguments.get(2).map_or(Ok(1), |text| text.parse())?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = root.join("case-studies/handover/simulation");
    let engine = Engine::load(&root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0"))?;
    let text = std::fs::read_to_string(folder.join("scenario.toml"))?;
    let physics = |fast: bool| -> Result<String, toml::de::Error> {
        let mut scenario: toml::Table = text.parse()?;
        if let Some(toml::Value::Table(table)) = scenario.get_mut("simulation") {
            table.insert("fast".to_owned(), fast.into());
        }
        Ok(scenario.to_string())
    };
    let (full, fast) = (physics(false)?, physics(true)?);
    let parameters = std::fs::read_to_string(folder.join(format!("{set}.toml")))?;
    let scenarios = match std::env::var("CAMPAIGN_FAST").as_deref() {
        Ok("both") => vec![full, fast],
        Ok("1") => vec![fast],
        _ => vec![full],
    };
    let benches = scenarios
        .iter()
        .map(|scenario| HandoverBench::new(&engine, scenario, &parameters))
        .collect::<Result<Vec<_>, _>>()?;
    let mut spent: Vec<Spent> = benches.iter().map(|_| Spent::default()).collect();
    let mut alone = Spent::default();
    for seed in first_seed..first_seed + count {
        for (bench, spent) in benches.iter().zip(&mut spent) {
            spent.episode(bench, seed)?;
        }
        if benches.len() > 1 {
            alone.engine_alone(&benches[0], seed)?;
        }
    }
    spent.iter().for_each(Spent::print);
    if let [full, fast] = &spent[..] {
        let speed = |it: &Spent| it.sim_secs / it.total_secs;
        for (name, it) in [("full", full), ("fast", fast), ("engine alone", &alone)] {
            println!(
                "{name:<14} {:>6.1} times real time on a core, {:>5.2} of the engine alone",
                speed(it),
                speed(it) / speed(&alone)
            );
        }
    }
    Ok(())
}
