//! A stream seen through a snapshot against the same rows seen through a cursor, and staleness.

use proptest::prelude::*;
use trace::{Cursor, Field, SignalIndex, Snapshot, Trace, TraceError};

fn layout() -> Trace {
    let mut trace = Trace::new();
    let arm = vec![Field::number("x", "m"), Field::bool("ready")];
    trace.add_channel("/arm", arm).expect("it is well-formed");
    let state = vec![Field::enumeration("state", ["a", "b"])];
    trace
        .add_channel("/state", state)
        .expect("it is well-formed");
    trace
}

const SIGNALS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 0)];

proptest! {
    #[test]
    fn it_is_a_cursor_at_the_end_of_what_was_heard(
        rows in prop::collection::vec((0..2_usize, 0..4_u8, -3..3_i32, 0..3_u8), 0..12),
        staleness in 0..8_u8,
    ) {
        let mut trace = layout();
        let mut now = Snapshot::new(&trace);
        now.set_staleness(1, Some(f64::from(staleness)));
        let mut time_secs = 0.0;
        for (channel, wait, number, flag) in rows {
            time_secs += f64::from(wait);
            // Of three flags one stands for a missing value.
            let flag = if flag == 2 { f64::NAN } else { f64::from(flag) };
            let row = if channel == 0 { vec![f64::from(number), flag] } else { vec![flag] };
            trace.channels[channel].push(time_secs, &row).expect("time goes on");
            now.update(channel, time_secs, &row).expect("time goes on");
            let mut cursor = Cursor::new(&trace);
            cursor.seek(time_secs);
            prop_assert_eq!(now.time_secs(), time_secs);
            for (channel, field) in SIGNALS {
                let signal = SignalIndex { channel, field };
                let updated = trace.channels[channel].times_secs.last().copied();
                prop_assert_eq!(now.updated_secs(signal), updated);
                let limit = if channel == 1 { f64::from(staleness) } else { f64::INFINITY };
                let stale = updated.is_some_and(|updated| time_secs - updated > limit);
                prop_assert_eq!(now.is_stale(signal), stale);
                prop_assert_eq!(now.value(signal), cursor.value(signal).filter(|_| !stale));
            }
        }
        now.clear();
        for (channel, field) in SIGNALS {
            prop_assert_eq!(now.value(SignalIndex { channel, field }), None);
        }
    }
}

#[test]
fn fields_may_come_one_by_one() {
    let mut now = Snapshot::new(&layout());
    let (x, ready) = (
        SignalIndex {
            channel: 0,
            field: 0,
        },
        SignalIndex {
            channel: 0,
            field: 1,
        },
    );
    now.set_field_staleness(x, Some(1.0));
    now.update_field(x, 1.0, 0.5).unwrap();
    now.update_field(ready, 2.5, 1.0).unwrap();
    assert_eq!((now.value(x), now.value(ready)), (None, Some(1.0)));
    assert!(now.is_stale(x));
    assert_eq!(
        (now.updated_secs(x), now.updated_secs(ready)),
        (Some(1.0), Some(2.5))
    );
    now.set_field_staleness(x, Some(1.5));
    assert_eq!(now.value(x), Some(0.5));
    now.advance(1.0);
    assert_eq!(now.time_secs(), 2.5);
    // There is no staleness below 0.
    for staleness_secs in [-1.0, f64::NAN] {
        now.set_field_staleness(ready, Some(staleness_secs));
        assert_eq!(now.value(ready), Some(1.0));
    }
    now.advance(2.6);
    assert_eq!(now.value(ready), None);
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mut now = Snapshot::new(&layout());
    now.update(0, 5.0, &[1.0, 1.0]).unwrap();
    let x = SignalIndex {
        channel: 0,
        field: 0,
    };
    assert!(matches!(
        now.update(0, 4.0, &[2.0, 0.0]),
        Err(TraceError::TimeBackwards { .. })
    ));
    assert!(matches!(
        now.update(0, f64::NAN, &[2.0, 0.0]),
        Err(TraceError::TimeNotFinite { .. })
    ));
    assert!(matches!(
        now.update(0, 6.0, &[2.0]),
        Err(TraceError::RowLength { .. })
    ));
    assert!(matches!(
        now.update(0, 6.0, &[2.0, 0.5]),
        Err(TraceError::BadValue { .. })
    ));
    assert!(matches!(
        now.update(1, 6.0, &[2.0]),
        Err(TraceError::BadValue { .. })
    ));
    assert!(matches!(
        now.update(2, 6.0, &[2.0]),
        Err(TraceError::BadName { .. })
    ));
    let beyond = SignalIndex {
        channel: 0,
        field: 9,
    };
    assert!(matches!(
        now.update_field(beyond, 6.0, 1.0),
        Err(TraceError::RowLength { .. })
    ));
    assert_eq!(now.value(beyond), None);
    assert_eq!((now.value(x), now.time_secs()), (Some(1.0), 5.0));
    // A range finder reports infinity where nothing is in reach.
    now.update(0, 6.0, &[f64::INFINITY, 1.0]).unwrap();
    assert_eq!(now.value(x), Some(f64::INFINITY));
}
