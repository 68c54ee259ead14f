//! Prints the numbers at places in a topic's messages as CSV, of a recording in any format.
//!
//! `cargo run -p corroborate-recording --example read_signals -- case-studies/handover/recordings/episode-00002.mcap /person/distance data`

use recording::{Extractor, FieldPath, OpenOptions, open};
use std::error::Error;
use std::io::{BufWriter, Write};
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, topic, fields @ ..] = arguments.as_slice() else {
        return Err("usage: read_signals FILE TOPIC FIELD...".into());
    };
    let mut reader = open(Path::new(file), &OpenOptions::default())?;
    let Some(topic) = reader.topics().iter().find(|it| it.name == *topic).cloned() else {
        let names = reader.topics().iter().map(|it| it.name.as_str());
        let names: Vec<&str> = names.collect();
        return Err(format!("{file} has no topic {topic}; it has {}", names.join(", ")).into());
    };
    let paths = fields.iter().map(|field| FieldPath::parse(field));
    let paths = paths.collect::<Result<Vec<_>, _>>()?;
    let mut extractor = Extractor::new(&topic, &paths)?;
    // Other topics are not even decompressed where the format has an index.
    reader.select(&|it| it.id == topic.id);

    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(out, "log_nanos,{}", fields.join(","))?;
    let mut values = vec![0.0; paths.len()];
    while let Some(message) = reader.next()? {
        extractor.extract(message.data, &mut values)?;
        let shown: Vec<String> = values.iter().map(ToString::to_string).collect();
        writeln!(out, "{},{}", message.log_nanos, shown.join(","))?;
    }
    out.flush()?;
    for loss in reader.losses() {
        eprintln!("lost: {loss}");
    }
    Ok(())
}
