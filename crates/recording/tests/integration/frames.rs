//! Frames in recordings that `rosbags` wrote, against positions that SciPy computed. The files and
//! the numbers are made by `files/make_frames.py`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use recording::{OpenOptions, SignalStream, TopicMap, open};
use trace::Table;

type Checked = Result<(), Box<dyn std::error::Error>>;

const MAP: &str = r#"
[time]
from = "header"
reorder = "50 ms"
["/position"]
position_of = "hand"
in_frame = "world"
["/rotation"]
orientation_of = "hand"
in_frame = "world"
["/point"]
point = "/person.point"
in_frame = "world"
["/away.distance"]
distance_between = ["hand", "world"]
"#;

fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/frames")
}

/// Numbers by what they are and their time in nanoseconds.
type Expected = BTreeMap<(String, i64), [f64; 4]>;

fn expected() -> Result<Expected, Box<dyn std::error::Error>> {
    let table = Table::read(&files().join("expected.csv"))?;
    let what = table.column("what")?.as_texts();
    let nanos = table.column("nanos")?.as_integers()?;
    let mut columns = Vec::new();
    for name in ["x", "y", "z", "w"] {
        columns.push(table.column(name)?.as_numbers()?);
    }
    let rows = what.iter().zip(nanos).enumerate();
    let rows = rows.map(|(row, (what, nanos))| {
        let values = std::array::from_fn(|axis| columns[axis][row]);
        (((*what).to_owned(), nanos), values)
    });
    Ok(rows.collect())
}

#[test]
fn frames_agree_with_scipy() -> Checked {
    let expected = expected()?;
    let map = TopicMap::parse("map", MAP).map_err(|mut errors| errors.remove(0))?;
    for file in ["frames.bag", "frames"] {
        let reader = open(&files().join(file), &OpenOptions::default())?;
        let stream = SignalStream::new(reader, &map, &[]);
        let mut stream = stream.map_err(|mut errors| errors.remove(0))?;
        let mut checked: BTreeMap<&str, usize> = BTreeMap::new();
        while let Some(instant) = stream.next_instant()? {
            for (what, axes) in [("position", 3), ("rotation", 4), ("point", 3)] {
                let Some(numbers) = expected.get(&(what.to_owned(), instant.time_nanos)) else {
                    continue;
                };
                for (axis, number) in ["x", "y", "z", "w"].iter().zip(numbers).take(axes) {
                    let signal = stream.layout().signal(&format!("/{what}.{axis}"));
                    let found = stream.snapshot().value(signal.ok_or("no such signal")?);
                    let close = found.is_some_and(|found| (found - number).abs() < 1e-9);
                    assert!(
                        close,
                        "{file} {what}.{axis} {instant:?}: {found:?}, not {number}"
                    );
                }
                *checked.entry(what).or_default() += 1;
            }
            let far = stream
                .layout()
                .signal("/away.distance")
                .ok_or("no distance")?;
            if let Some([x, y, z, _]) = expected.get(&("position".to_owned(), instant.time_nanos)) {
                let found = stream.snapshot().value(far).ok_or("no distance")?;
                assert!((found - x.hypot(*y).hypot(*z)).abs() < 1e-9);
            }
        }
        let total: usize = checked.values().sum();
        assert_eq!(total, expected.len(), "{file}: {checked:?}");
        assert!(
            stream
                .notes()
                .iter()
                .all(|note| !note.kind.is_loss() || note.topic != "/person")
        );
    }
    Ok(())
}
