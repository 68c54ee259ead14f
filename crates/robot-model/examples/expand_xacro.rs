//! Prints the XML that a xacro file stands for.
//!
//!     cargo run -p corroborate-robot-model --example expand_xacro -- robot.urdf.xacro [folder of packages [NAME=VALUE ...]]

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("name a xacro file")?;
    let packages = PathBuf::from(arguments.next().unwrap_or_else(|| ".".to_owned()));
    let pairs = arguments.filter_map(|it| {
        let (name, value) = it.split_once('=')?;
        Some((name.to_owned(), value.to_owned()))
    });
    let given = pairs.collect();
    let text = std::fs::read_to_string(&file)?;
    let mut read = |address: &str| {
        let path = match address.split_once("://") {
            Some(("package" | "model", path)) => packages.join(path),
            Some((_, path)) => PathBuf::from(path),
            None => PathBuf::from(address),
        };
        std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    print!(
        "{}",
        robot_model::expand_xacro(&file, &text, &given, &mut read)?
    );
    Ok(())
}
