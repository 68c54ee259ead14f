//! What the tests share: the engine, if it is there, and the handover's files.
#![allow(dead_code, reason = "each test program uses a part")]

use std::path::{Path, PathBuf};

use handover::{Parameters, Scenario};
use testbench::Engine;

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The engine, or `None` with a note when the library is absent. Under `CI` it must be there.
pub fn engine() -> Option<Engine> {
    let library = root().join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
    if !library.exists() && std::env::var_os("CI").is_none() {
        println!("skipped: libmujoco not found (run tools/mujoco)");
        return None;
    }
    Some(Engine::load(&library).expect("the pinned library loads"))
}

/// A file of the handover's simulation.
pub fn handover_file(name: &str) -> String {
    let path = root().join("case-studies/handover/simulation").join(name);
    std::fs::read_to_string(path).expect("the case study's file is there")
}

/// The handover's scenario as text, in the full or the fast physics.
pub fn scenario_text(fast: bool) -> String {
    let text = handover_file("scenario.toml");
    let lines = text.lines().filter(|line| !line.starts_with("fast = "));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    let table = "[simulation]\n";
    assert!(text.contains(table), "the scenario has `{table}`");
    text.replacen(table, &format!("{table}fast = {fast}\n"), 1)
}

/// The handover's scenario in the full physics.
pub fn scenario() -> Scenario {
    Scenario::parse(&scenario_text(false)).expect("the scenario is sound")
}

/// A parameter set of the handover.
pub fn parameters(name: &str) -> Parameters {
    Parameters::parse(&handover_file(&format!("{name}.toml"))).expect("the parameters are sound")
}
