//! How many predicates are evaluated in a second, on a stream and on a recording.
//!
//! Run with `cargo bench -p corroborate-trace`.

use divan::Bencher;
use divan::counter::ItemsCount;
use trace::{BoundPredicate, Cursor, Field, Predicate, Snapshot, Trace};

fn main() {
    divan::main();
}

/// Rows of one pass.
const ROWS: usize = 10_000;

const PREDICATES: [&str; 4] = [
    "/robot.hand_speed < 250 mm/s",
    "/robot.hand_speed < 250 mm/s & /robot.state = 'release'",
    "distance(/human.hand, /robot.hand) < 10 cm => /robot.hand_speed < 250 mm/s",
    "abs(/robot.hand.x - /human.hand.x) < 5 cm & abs(/robot.hand.y - /human.hand.y) < 5 cm",
];

fn layout() -> Trace {
    let mut trace = Trace::new();
    let hand = || ["x", "y", "z"].map(|axis| Field::number(format!("hand.{axis}"), "m"));
    let mut robot = vec![
        Field::number("hand_speed", "m/s"),
        Field::enumeration("state", ["carry", "release"]),
    ];
    robot.extend(hand());
    trace
        .add_channel("/robot", robot)
        .expect("the layout is well-formed");
    trace
        .add_channel("/human", hand().to_vec())
        .expect("the layout is well-formed");
    trace
}

/// The rows of the robot; values that keep every predicate from being decided early.
fn rows() -> Vec<[f64; 5]> {
    let row = |index: usize| {
        let phase = index as f64 / 100.0;
        [0.2 + 0.1 * phase.sin(), 1.0, 0.05 * phase.cos(), 0.02, 0.9]
    };
    (0..ROWS).map(row).collect()
}

fn bound(text: &str) -> BoundPredicate {
    let predicate = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout()));
    predicate.expect("the predicate is well-formed")
}

/// A snapshot in which everything has a value.
fn snapshot() -> Snapshot {
    let mut now = Snapshot::new(&layout());
    now.update(1, 0.0, &[0.0, 0.0, 0.9]).expect("the row fits");
    now.update(0, 0.0, &rows()[0]).expect("the row fits");
    now
}

/// Evaluation alone, on values that stay.
#[divan::bench(args = PREDICATES)]
fn truth(bencher: Bencher, text: &str) {
    let (predicate, now) = (bound(text), snapshot());
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        (0..ROWS)
            .filter(|_| predicate.eval(divan::black_box(&now)) == Some(true))
            .count()
    });
}

/// Robustness alone, on values that stay.
#[divan::bench(args = PREDICATES)]
fn robustness(bencher: Bencher, text: &str) {
    let (predicate, now) = (bound(text), snapshot());
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        (0..ROWS)
            .filter_map(|_| predicate.robustness(divan::black_box(&now)))
            .fold(f64::INFINITY, f64::min)
    });
}

/// A stream: each row arrives, and the predicate is evaluated.
#[divan::bench(args = PREDICATES)]
fn stream(bencher: Bencher, text: &str) {
    let (predicate, rows) = (bound(text), rows());
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        let mut now = snapshot();
        let mut held = 0;
        for (index, row) in rows.iter().enumerate() {
            now.update(0, index as f64, row).expect("time goes on");
            held += usize::from(predicate.eval(&now) == Some(true));
        }
        held
    });
}

/// A recording: a cursor goes from row to row, and the predicate is evaluated.
#[divan::bench(args = PREDICATES)]
fn recording(bencher: Bencher, text: &str) {
    let predicate = bound(text);
    let mut trace = layout();
    trace.channels[1]
        .push(0.0, &[0.0, 0.0, 0.9])
        .expect("the row fits");
    for (index, row) in rows().iter().enumerate() {
        trace.channels[0]
            .push(index as f64, row)
            .expect("the row fits");
    }
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        let mut cursor = Cursor::new(&trace);
        let mut held = 0;
        for index in 0..ROWS {
            cursor.seek(index as f64);
            held += usize::from(predicate.eval(&cursor) == Some(true));
        }
        held
    });
}
