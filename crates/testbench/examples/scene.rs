//! Runs a scene's episodes and prints one topic of the last as CSV, and how long they took.
//!
//! `cargo run --release --example scene -- LIBRARY SCENE.toml TEST EPISODES TOPIC`
//!
//! LIBRARY is MuJoCo's, or `rapier` for the engine that is built in.
//!
//! Controllers are run as processes, as their `command` says, from the scene's folder.

use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

use stimulus::Stimulus;
use testbench::controller::{Controller, ControllerError, LockStep, Lost, RemoteController};
use testbench::scene::{ControllerData, SceneBench, mujoco, rapier};
use testbench::{Bench, Cancel, Engine, Unwatched};

/// A process that answers line by line.
struct Process {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Process {
    fn start(data: &ControllerData, folder: &Path) -> Result<Self, ControllerError> {
        let transport = |reason: String| ControllerError::Transport { reason };
        let clients = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../clients/python");
        let Some((program, arguments)) = data.command.split_first() else {
            return Err(transport("the scene names no command".to_owned()));
        };
        let mut child = Command::new(program)
            .args(arguments)
            .current_dir(folder)
            .env("PYTHONPATH", clients)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| transport(error.to_string()))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(transport("the process has no input or output".to_owned()));
        };
        Ok(Self {
            child,
            input,
            output: BufReader::new(output),
        })
    }
}

impl LockStep for Process {
    fn exchange(&mut self, line: &str) -> Result<String, Lost> {
        let gone = |error: std::io::Error| Lost::Gone(error.to_string());
        writeln!(self.input, "{line}").map_err(gone)?;
        let mut answer = String::new();
        match self.output.read_line(&mut answer).map_err(gone)? {
            0 => Err(Lost::Gone("the process has ended".to_owned())),
            _ => Ok(answer),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended by itself; then there is nothing to end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [library, scene, test, episodes, topic] = arguments.as_slice() else {
        return Err("give LIBRARY SCENE.toml TEST EPISODES TOPIC".into());
    };
    let scene = PathBuf::from(scene);
    let folder = scene.parent().unwrap_or(Path::new(".")).to_owned();
    let files = folder.clone();
    let read = move |path: &str| std::fs::read(files.join(path)).map_err(|e| e.to_string());
    let start = Arc::new(move |data: &ControllerData| {
        let process = Process::start(data, &folder)?;
        Ok(Box::new(RemoteController::connect(process)?) as Box<dyn Controller>)
    });
    let physics = match library.as_str() {
        "rapier" => rapier(),
        library => mujoco(&Engine::load(Path::new(library))?),
    };
    let text = std::fs::read_to_string(&scene)?;
    let (bench, gaps) = SceneBench::new(&text, &read, physics, start)?;
    for gap in &gaps {
        eprintln!("{gap}");
    }
    let stimulus = bench.data().abstract_test(test).ok_or("no such test")?;
    let stimulus = Stimulus::of(stimulus.clone());
    let (mut steps, mut simulated_secs, began) = (0, 0.0, Instant::now());
    for seed in 1..=episodes.parse::<u64>()? {
        let recorded = bench.run(&stimulus, seed, &mut Unwatched, &Cancel::default())?;
        steps += recorded.steps;
        simulated_secs += recorded.sim_secs;
        let trace = &recorded.trace;
        let least = |signal: &str| {
            let index = trace.signal(signal)?;
            let channel = &trace.channels[index.channel];
            let values = (0..channel.len()).map(|row| channel.row(row)[index.field]);
            values.min_by(f64::total_cmp)
        };
        eprintln!(
            "seed {seed}: {:.1} s, nearest person {:.3} m",
            recorded.sim_secs,
            least("/truth/carrier.person_distance").unwrap_or(f64::NAN)
        );
        if seed.to_string() == *episodes
            && let Some(channel) = trace.channel(topic)
        {
            let names: Vec<&str> = channel.fields.iter().map(|f| f.name.as_str()).collect();
            println!("time,{}", names.join(","));
            for (row, time_secs) in channel.times_secs.iter().enumerate() {
                let values: Vec<String> = channel.row(row).iter().map(f64::to_string).collect();
                println!("{time_secs},{}", values.join(","));
            }
        }
    }
    let secs = began.elapsed().as_secs_f64();
    eprintln!(
        "{steps} steps, {simulated_secs:.1} s simulated in {secs:.1} s: {:.0} times real time",
        simulated_secs / secs
    );
    Ok(())
}
