//! How fast messages, and one field of each, come out of a recording in any format; one core.
//!
//!     cargo bench -p corroborate-recording --bench any_file -- PATH TOPIC FIELD
//!
//! Without arguments it measures a small table that it writes itself.

use std::path::{Path, PathBuf};
use std::time::Instant;

use recording::{Extractor, FieldPath, OpenOptions, open};

/// Rows of the table that is measured without arguments.
const ROWS: usize = 200_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // "cargo bench" passes flags of its own.
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    if let [path, topic, field] = &given[..] {
        return measure(Path::new(path), topic, field);
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("any_file.csv");
    let rows =
        (0..ROWS).map(|row| format!("{}.{:03},{row},0.5,-1.25e-3\n", row / 1_000, row % 1_000));
    std::fs::write(
        &path,
        format!("time_secs,a,b,c\n{}", rows.collect::<String>()),
    )?;
    measure(&path, "/csv", "b")
}

fn measure(path: &Path, topic: &str, field: &str) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let mut reader = open(path, &OpenOptions::default())?;
    let opened_secs = start.elapsed().as_secs_f64();
    let info = reader.topics().iter().find(|info| info.name == topic);
    let mut extractor = Extractor::new(
        info.ok_or("there is no such topic")?,
        &[field.parse::<FieldPath>()?],
    )?;
    reader.select(&|info| info.name == topic);
    let (mut messages, mut sum, mut value) = (0_u64, 0.0, [f64::NAN]);
    while let Some(message) = reader.next()? {
        extractor.extract(message.data, &mut value)?;
        sum += value[0];
        messages += 1;
    }
    let secs = start.elapsed().as_secs_f64();
    println!(
        "{}: opened in {opened_secs:.3} s, {messages} messages in {secs:.3} s, {:.2} million a second \
         (the sum of {field} is {sum})",
        path.display(),
        messages as f64 / secs / 1e6
    );
    Ok(())
}
