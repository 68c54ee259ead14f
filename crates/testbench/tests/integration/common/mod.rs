//! What the tests share: the repository's files, and the engine, if it is there.
#![allow(dead_code, reason = "each test program uses a part")]

use std::path::{Path, PathBuf};

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
