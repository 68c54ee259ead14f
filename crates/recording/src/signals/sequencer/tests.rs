//! The sequencer, fed by hand.

use super::*;
use crate::signals::plan::{FrameQuantity, FrameQuantityKind, Output, Treatment};
use trace::{Field, SignalIndex};

const MS: i64 = 1_000_000;

fn output(field: usize, interpolation: Interpolation, staleness_ms: Option<i64>) -> Output {
    Output {
        signal: SignalIndex { channel: 0, field },
        column: 0,
        interpolation,
        staleness_nanos: staleness_ms.map(|ms| ms * MS),
    }
}

fn plan(outputs: Vec<Output>, treatment: Treatment, width: usize) -> SourcePlan {
    SourcePlan {
        name: "/t".to_owned(),
        width,
        treatment,
        outputs,
    }
}

fn layout(fields: usize) -> Trace {
    let mut layout = Trace::new();
    let fields = (0..fields)
        .map(|index| Field::number(format!("f{index}"), "m"))
        .collect();
    layout.add_channel("/s", fields).unwrap();
    layout
}

fn settings() -> TimeSettings {
    TimeSettings {
        reorder_secs: 0.05,
        ..TimeSettings::default()
    }
}

/// All instants in milliseconds (rounded up) with the values of the fields.
fn drain(sequencer: &mut Sequencer, fields: usize, notes: &mut Notes) -> Vec<(i64, Vec<f64>)> {
    let mut all = Vec::new();
    while let Some(nanos) = sequencer.next(notes).unwrap() {
        let value = |field| {
            sequencer
                .snapshot()
                .value(SignalIndex { channel: 0, field })
        };
        let values = (0..fields)
            .map(|field| value(field).unwrap_or(-1.0))
            .collect();
        all.push((nanos, values));
    }
    all
}

#[test]
fn instants_join_rows_of_one_time_in_order() {
    let hold = |field| {
        plan(
            vec![output(field, Interpolation::Hold, None)],
            Treatment::Plain,
            1,
        )
    };
    let mut sequencer = Sequencer::new(&layout(2), vec![hold(0), hold(1)], &settings());
    let mut notes = Notes::default();
    for (source, ms, arrival_ms) in [(0, 20, 20), (1, 10, 30), (1, 20, 40), (0, 30, 45)] {
        sequencer
            .row(source, ms * MS, arrival_ms * MS, &[ms as f64])
            .unwrap();
    }
    assert!(drain(&mut sequencer, 2, &mut notes).is_empty()); // within the window
    sequencer.finish(None);
    let expected = [
        (10, vec![-1.0, 10.0]),
        (20, vec![20.0, 20.0]),
        (30, vec![30.0, 20.0]),
    ];
    assert_eq!(
        drain(&mut sequencer, 2, &mut notes),
        expected.map(|(ms, values)| (ms * MS, values))
    );
    assert_eq!(sequencer.secs(30 * MS), 0.03);
}

#[test]
fn a_value_that_becomes_too_old_is_an_instant() {
    let outputs = |field, staleness| {
        plan(
            vec![output(field, Interpolation::Hold, staleness)],
            Treatment::Plain,
            1,
        )
    };
    let sources = vec![outputs(0, Some(10)), outputs(1, None)];
    let mut sequencer = Sequencer::new(&layout(2), sources, &settings());
    for (source, ms) in [(0, 0), (0, 10), (1, 20), (1, 30), (0, 40)] {
        sequencer
            .row(source, ms * MS, ms * MS, &[ms as f64])
            .unwrap();
    }
    sequencer.finish(None);
    let found = drain(&mut sequencer, 2, &mut Notes::default());
    let expected = [
        (0, [0.0, -1.0]),
        (10 * MS, [10.0, -1.0]),
        (20 * MS, [10.0, 20.0]),
        (20 * MS + 1, [-1.0, 20.0]),
        (30 * MS, [-1.0, 30.0]),
        (40 * MS, [40.0, 30.0]),
    ];
    assert_eq!(
        found,
        expected.map(|(nanos, values)| (nanos, values.to_vec()))
    );
}

#[test]
fn linear_signals_are_known_at_every_instant_and_gaps_are_seen() {
    let sources = vec![
        plan(
            vec![output(0, Interpolation::Linear, Some(20))],
            Treatment::Plain,
            1,
        ),
        plan(
            vec![output(1, Interpolation::Hold, None)],
            Treatment::Plain,
            1,
        ),
    ];
    let mut sequencer = Sequencer::new(&layout(2), sources, &settings());
    let rows = [(1, 5), (0, 10), (1, 15), (0, 20), (1, 25), (0, 60), (1, 65)];
    for (source, ms) in rows {
        sequencer
            .row(source, ms * MS, ms * MS, &[ms as f64])
            .unwrap();
    }
    sequencer.finish(None);
    let found = drain(&mut sequencer, 2, &mut Notes::default());
    let expected = [
        (5 * MS, [-1.0, 5.0]),
        (10 * MS, [10.0, 5.0]),
        (15 * MS, [15.0, 15.0]),
        (20 * MS, [20.0, 15.0]),
        (20 * MS + 1, [-1.0, 15.0]),
        (25 * MS, [-1.0, 25.0]),
        (60 * MS, [60.0, 25.0]),
        (60 * MS + 1, [-1.0, 25.0]),
        (65 * MS, [-1.0, 65.0]),
    ];
    assert_eq!(
        found,
        expected.map(|(nanos, values)| (nanos, values.to_vec()))
    );
}

fn edge(parent: &str, child: &str, x: f64) -> Edge {
    Edge {
        parent: parent.to_owned(),
        child: child.to_owned(),
        pose: Transform::new([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap(),
        offset: 0,
    }
}

#[test]
fn points_wait_for_their_transforms_without_disturbing_the_order() {
    let treatment = Treatment::Transform {
        in_frame: "world".into(),
        is_point: true,
        metres_per_unit: 0.001,
    };
    let sources = vec![
        plan(vec![output(0, Interpolation::Hold, None)], treatment, 4),
        plan(
            vec![output(1, Interpolation::Hold, None)],
            Treatment::Plain,
            1,
        ),
    ];
    let mut sequencer = Sequencer::new(&layout(2), sources, &settings());
    let camera = f64::from(sequencer.frames().frame("camera").number());
    let mut notes = Notes::default();
    // The camera moves by 1 m/s and is told every 20 ms; the point stands at 5 mm in it.
    for ms in 0..100 {
        let at = ms * MS;
        if ms % 20 == 0 {
            sequencer
                .transform(at, at, edge("world", "camera", ms as f64 / 1e3))
                .unwrap();
        }
        if ms % 10 == 5 {
            sequencer.row(0, at, at, &[5.0, 0.0, 0.0, camera]).unwrap();
            sequencer.row(1, at + MS, at + MS, &[ms as f64]).unwrap();
        }
    }
    let before_end = drain(&mut sequencer, 2, &mut notes);
    assert!(before_end.len() >= 8, "{before_end:?}");
    sequencer.finish(None);
    let mut found = before_end;
    found.extend(drain(&mut sequencer, 2, &mut notes));
    assert!(found.is_sorted_by_key(|(nanos, _)| *nanos));
    assert_eq!(found.len(), 20);
    for (nanos, values) in found
        .iter()
        .filter(|(nanos, _)| nanos % (10 * MS) == 5 * MS)
    {
        let ms = (nanos / MS) as f64;
        let expected = if ms < 80.0 { ms + 5.0 } else { -1.0 }; // the last transform is at 80 ms
        assert!((values[0] - expected).abs() < 1e-9, "{nanos} {values:?}");
    }
    let notes = notes.list();
    assert_eq!(
        (notes[0].kind, notes[0].count),
        (StreamNoteKind::NoTransform, 2)
    );
}

#[test]
fn quantities_of_frames_have_a_value_at_each_sample_on_the_way() {
    let quantity = |kind| {
        Treatment::Frames(FrameQuantity {
            target: "world".into(),
            source: "hand".into(),
            kind,
        })
    };
    let sources = vec![
        plan(
            vec![output(0, Interpolation::Hold, None)],
            quantity(FrameQuantityKind::Position),
            0,
        ),
        plan(
            vec![output(1, Interpolation::Hold, None)],
            quantity(FrameQuantityKind::Speed),
            0,
        ),
    ];
    let mut sequencer = Sequencer::new(&layout(2), sources, &settings());
    sequencer.static_transform(&edge("base", "rail", 1.0), &mut Notes::default());
    sequencer
        .transform(0, 0, edge("other", "thing", 1.0))
        .unwrap();
    for ms in [10, 20, 30, 40] {
        let at = ms * MS;
        let x = ms as f64 / 1000.0;
        sequencer
            .transform(at, at, edge("rail", "hand", 2.0 * x))
            .unwrap();
        if ms != 30 {
            sequencer
                .transform(at, at, edge("world", "base", -x))
                .unwrap();
        }
    }
    sequencer.finish(None);
    let found = drain(&mut sequencer, 2, &mut Notes::default());
    let times: Vec<i64> = found.iter().map(|(nanos, _)| nanos / MS).collect();
    assert_eq!(times, [10, 20, 30, 40]);
    for (index, (nanos, values)) in found.iter().enumerate() {
        let secs = *nanos as f64 / 1e9;
        assert!((values[0] - (1.0 + secs)).abs() < 1e-12, "{values:?}");
        let speed = if index == 0 { -1.0 } else { 1.0 };
        assert!((values[1] - speed).abs() < 1e-9, "{values:?}");
    }
}

#[test]
fn dates_are_counted_from_the_first_item() {
    let hold = plan(
        vec![output(0, Interpolation::Hold, None)],
        Treatment::Plain,
        1,
    );
    let mut sequencer = Sequencer::new(&layout(1), vec![hold], &settings());
    let start = 1_700_000_000_123_456_789;
    for later in [0, 1, 1_500_000_000] {
        sequencer
            .row(0, start + later, start + later, &[0.0])
            .unwrap();
    }
    sequencer.finish(None);
    let found = drain(&mut sequencer, 1, &mut Notes::default());
    let secs: Vec<f64> = found
        .iter()
        .map(|(nanos, _)| sequencer.secs(*nanos))
        .collect();
    assert_eq!(secs, [0.0, 1e-9, 1.5]);
    assert_eq!(sequencer.origin_nanos(), start);
}

/// A sensor whose stamp stands still must not fill the memory.
#[test]
fn what_waits_is_bounded_even_if_time_stands_still() {
    let treatment = Treatment::Transform {
        in_frame: "world".into(),
        is_point: true,
        metres_per_unit: 1.0,
    };
    let sources = vec![
        plan(
            vec![output(0, Interpolation::Hold, None)],
            Treatment::Plain,
            1,
        ),
        plan(vec![output(1, Interpolation::Hold, None)], treatment, 4),
    ];
    let settings = TimeSettings {
        reorder_messages: 10,
        ..settings()
    };
    let mut sequencer = Sequencer::new(&layout(2), sources, &settings);
    let camera = f64::from(sequencer.frames().frame("camera").number());
    let mut notes = Notes::default();
    sequencer
        .row(1, 4 * MS, 0, &[1.0, 0.0, 0.0, camera])
        .unwrap();
    let mut given = 0;
    for arrival in 0..1000 {
        sequencer
            .row(0, 5 * MS, arrival * MS, &[arrival as f64])
            .unwrap();
        given += drain(&mut sequencer, 2, &mut notes).len();
        assert!(sequencer.outgoing.len() <= 11);
    }
    assert!(given > 10);
    sequencer.finish(None);
    drain(&mut sequencer, 2, &mut notes);
    // The point was known to be missing only when later rows had been given out.
    let kinds: Vec<_> = notes.list().iter().map(|note| note.kind).collect();
    assert_eq!(kinds, [StreamNoteKind::Late, StreamNoteKind::NoTransform]);
}
