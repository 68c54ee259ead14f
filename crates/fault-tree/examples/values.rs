//! The values of many trees, one line each, for programs that compare them with others' (`conformance/peers`):
//! path, lower and upper bound of the top event's probability, its exact value or `-`, the number of minimal cut sets,
//! microseconds for the diagram and the probability together.
//!
//! ```text
//! cargo run --example values -- MISSION_TIME tree.dft ...
//! ```

use std::time::Instant;

use diagnostic::{Cancel, Problem, Source};
use fault_tree::{Analysis, Options, Settings, decimal, read_galileo, read_open_psa};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let settings = Settings {
        mission_time: arguments.next().as_deref().and_then(decimal),
    };
    for path in arguments {
        let source = Source::new(&path, std::fs::read_to_string(&path)?);
        let line = values(&source, &settings)
            .unwrap_or_else(|problem| format!("{}: {}", problem.code, problem.message()));
        println!("{path}\t{line}");
    }
    Ok(())
}

fn values(source: &Source, settings: &Settings) -> Result<String, Problem> {
    let cancel = Cancel::default();
    let reading = match source.name.ends_with(".xml") {
        true => read_open_psa(source, settings)?,
        false => read_galileo(source, settings)?,
    };
    let tree = reading.tree;
    let top = tree
        .top()
        .ok_or_else(|| Problem::new("bad-fault-tree", "no top event"))?;
    let start = Instant::now();
    let analysis = Analysis::new(&tree, top, Options::default(), &cancel)?;
    let found = analysis.probability(&cancel)?;
    let microseconds = start.elapsed().as_micros();
    let exact = found.exact.map_or("-".to_owned(), |it| it.to_string());
    let sets = analysis.cut_sets(0, &cancel)?.count;
    let (lower, upper) = (found.bounds.lower, found.bounds.upper);
    Ok(format!(
        "{lower:e}\t{upper:e}\t{exact}\t{sets}\t{microseconds}"
    ))
}
