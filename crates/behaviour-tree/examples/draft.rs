//! The PRISM model of a behaviour tree; what it leaves out goes to standard error:
//!
//! ```text
//! cargo run -p corroborate-behaviour-tree --example draft -- tree.xml [TREE_ID]
//! ```

use behaviour_tree::{Options, read, to_prism};
use diagnostic::{Problem, Source};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments
        .next()
        .ok_or("name a file with a behaviour tree")?;
    let main = arguments.next();
    let source = Source::new(&path, std::fs::read_to_string(&path)?);
    let mut include = |path: &str, from: &str| {
        let folder = Path::new(from).parent().unwrap_or(Path::new(""));
        let path = folder.join(path);
        let text = std::fs::read_to_string(&path);
        let text = text.map_err(|error| Problem::cannot_read(&path, &error))?;
        Ok(Source::new(path.display().to_string(), text))
    };
    let reading = read(&source, main.as_deref(), &mut include)?;
    for note in &reading.notes {
        eprintln!("{}", note.warning_line());
    }
    print!("{}", to_prism(&reading.tree, &Options::default()).text);
    Ok(())
}
