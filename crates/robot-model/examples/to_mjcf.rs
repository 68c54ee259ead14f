//! Loads a description and writes it as MJCF; what was not carried over goes to standard error.
//!
//!     cargo run -p corroborate-robot-model --example to_mjcf -- robot.urdf [folder of packages]

use std::error::Error;
use std::path::{Path, PathBuf};

use robot_model::{MjcfOptions, parse, to_mjcf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("name a URDF, SDF or MJCF file")?;
    let packages = PathBuf::from(arguments.next().unwrap_or_else(|| ".".to_owned()));
    let text = std::fs::read_to_string(&file)?;
    let loaded = parse(&file, &text, &mut |address: &str| read(&packages, address))?;
    for gap in &loaded.gaps {
        eprintln!("gap: {gap}");
    }
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    let written = to_mjcf(&loaded.model, &MjcfOptions::default())?;
    for note in &written.notes {
        eprintln!("note: {note}");
    }
    print!("{}", written.text);
    Ok(())
}

/// `package://` and `model://` below the folder of packages, paths as they are.
fn read(packages: &Path, address: &str) -> Result<Vec<u8>, String> {
    let path = match address.split_once("://") {
        Some(("file", path)) => PathBuf::from(path),
        Some((_, path)) => packages.join(path),
        None => PathBuf::from(address),
    };
    std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))
}
