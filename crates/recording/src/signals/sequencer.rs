//! From rows and transforms as they arrive to the values of all signals at one instant after
//! another.
//!
//! What arrives is put in order of time first ([`ReorderBuffer`]). Then rows that need a transform
//! wait for it, and all rows wait until it is known what the linearly interpolated signals are at
//! their time. An instant is the time of one or more rows; it is given out once no earlier row, and
//! no other row of the same time, can come. When the last value of a signal becomes too old, that
//! is an instant as well, one nanosecond later, so that a monitor sees the value go.

use std::collections::VecDeque;

use trace::{Snapshot, Trace, TraceError};

use super::frames::FrameSource;
use super::linear::Samples;
use super::plan::{Output, SourcePlan};
use super::report::{Notes, StreamNoteKind};
use crate::clock::{Late, ReorderBuffer, TimeSettings, nanos_of_secs};
use crate::topic_map::Interpolation;
use crate::transform::{Transform, TransformBuffer};

/// Times from here on (3 years, in seconds) are taken for dates and counted from the first instant.
const DATE_NANOS: i64 = 100_000_000_000_000_000;

/// What arrives.
#[derive(Debug)]
enum Item {
    Row { source: usize, slot: usize },
    Transform(Box<Edge>),
}

#[derive(Debug)]
struct Edge {
    parent: String,
    child: String,
    pose: Transform,
    is_static: bool,
    offset: u64,
}

/// What is given out.
#[derive(Debug)]
enum Ready {
    Row {
        source: usize,
        slot: usize,
    },
    /// Linearly interpolated values end here.
    Touch,
}

/// Rows of one width, kept without allocating anew for each.
#[derive(Debug, Default)]
struct Rows {
    width: usize,
    values: Vec<f64>,
    free: Vec<usize>,
}

impl Rows {
    fn keep(&mut self, row: &[f64]) -> usize {
        let slot = self.free.pop().unwrap_or_else(|| {
            let slot = self.values.len() / self.width.max(1);
            self.values.resize(self.values.len() + self.width, f64::NAN);
            slot
        });
        let from = slot * self.width;
        self.values[from..from + self.width].copy_from_slice(&row[..self.width]);
        slot
    }

    fn get(&self, slot: usize) -> &[f64] {
        &self.values[slot * self.width..(slot + 1) * self.width]
    }
}

/// The state of one source.
#[derive(Debug)]
struct Source {
    plan: SourcePlan,
    /// As they arrive.
    arrived: Rows,
    /// As they are given out.
    ready: Rows,
    frames: Option<FrameSource>,
    /// If any output is linear.
    samples: Option<Samples>,
    /// The widest gap between samples that is bridged, and whether the one behind the newest
    /// sample is known to be wider.
    bridged_nanos: i64,
    gap_seen: bool,
    /// For each output, when its value becomes too old; `i64::MAX` if it has none or never does.
    expiry_nanos: Vec<i64>,
}

/// Puts everything in order; see the module's documentation.
#[derive(Debug)]
pub(super) struct Sequencer {
    sources: Vec<Source>,
    incoming: ReorderBuffer<Item>,
    /// In order of time.
    outgoing: Outgoing,
    frames: TransformBuffer,
    frame_wait_nanos: i64,
    /// The time up to which everything has come; `i64::MIN` before the first item.
    now_nanos: i64,
    finished: bool,
    at_once: bool,
    /// The earliest time at which a value may become too old.
    next_expiry_nanos: i64,
    snapshot: Snapshot,
    changed: Vec<bool>,
    origin_nanos: Option<i64>,
}

/// What is ready, in order of time and then of arrival.
#[derive(Debug, Default)]
struct Outgoing {
    queue: VecDeque<(i64, Ready)>,
}

impl Outgoing {
    /// Puts `item` behind everything of its time or earlier; nearly always at the end.
    fn push(&mut self, time_nanos: i64, item: Ready) {
        let place = match self.queue.back() {
            Some((last, _)) if *last > time_nanos => {
                self.queue.partition_point(|(time, _)| *time <= time_nanos)
            }
            _ => self.queue.len(),
        };
        self.queue.insert(place, (time_nanos, item));
    }

    fn front_nanos(&self) -> Option<i64> {
        self.queue.front().map(|(time, _)| *time)
    }

    fn pop_at(&mut self, time_nanos: i64) -> Option<Ready> {
        if self.front_nanos()? > time_nanos {
            return None;
        }
        self.queue.pop_front().map(|(_, item)| item)
    }
}

impl Sequencer {
    pub fn new(layout: &Trace, plans: Vec<SourcePlan>, time: &TimeSettings) -> Self {
        let mut frames = TransformBuffer::new(time.frame_history_secs.max(time.frame_wait_secs));
        let sources = plans
            .into_iter()
            .map(|plan| Source::new(plan, &mut frames))
            .collect();
        let reorder_nanos = nanos_of_secs(time.reorder_secs);
        Sequencer {
            sources,
            incoming: ReorderBuffer::new(reorder_nanos, time.reorder_messages),
            outgoing: Outgoing::default(),
            frames,
            frame_wait_nanos: nanos_of_secs(time.frame_wait_secs),
            now_nanos: i64::MIN,
            finished: false,
            at_once: reorder_nanos == 0,
            next_expiry_nanos: i64::MAX,
            snapshot: Snapshot::new(layout),
            changed: vec![false; layout.channels.len()],
            origin_nanos: None,
        }
    }

    /// The frames as far as they are known.
    pub fn frames(&mut self) -> &mut TransformBuffer {
        &mut self.frames
    }

    /// Takes a row of `source`, measured at `time_nanos` and read at `arrival_nanos` of log time.
    pub fn row(
        &mut self,
        source: usize,
        time_nanos: i64,
        arrival_nanos: i64,
        row: &[f64],
    ) -> Result<(), Late> {
        let arrived = &mut self.sources[source].arrived;
        let slot = arrived.keep(row);
        let item = Item::Row { source, slot };
        let taken = self.incoming.push(time_nanos, arrival_nanos, item);
        if taken.is_err() {
            arrived.free.push(slot);
        }
        taken
    }

    /// Takes the pose of frame `child` in frame `parent`, read at byte `offset`.
    #[allow(clippy::too_many_arguments)] // They are what a transform is.
    pub fn transform(
        &mut self,
        time_nanos: i64,
        arrival_nanos: i64,
        (parent, child): (&str, &str),
        pose: Transform,
        is_static: bool,
        offset: u64,
    ) -> Result<(), Late> {
        let edge = Edge {
            parent: parent.to_owned(),
            child: child.to_owned(),
            pose,
            is_static,
            offset,
        };
        let item = Item::Transform(Box::new(edge));
        self.incoming.push(time_nanos, arrival_nanos, item)
    }

    /// Nothing more will arrive.
    pub fn finish(&mut self) {
        self.finished = true;
    }

    /// Moves to the next instant and gives its time in nanoseconds; `None` if more has to arrive
    /// first, or after the end.
    pub fn next(&mut self, notes: &mut Notes) -> Result<Option<i64>, TraceError> {
        loop {
            if let Some(front) = self.outgoing.front_nanos()
                && front <= self.horizon_nanos()
            {
                return self.instant(front).map(Some);
            }
            let popped = match self.incoming.pop() {
                None if self.finished => self.incoming.pop_any(),
                popped => popped,
            };
            match popped {
                Some((time_nanos, item)) => self.take(time_nanos, item, notes),
                None if self.finished && self.now_nanos != i64::MAX => {
                    self.now_nanos = i64::MAX;
                    self.resolve(notes);
                    self.close();
                }
                None => return Ok(None),
            }
        }
    }

    /// Up to which time everything that matters is known.
    fn horizon_nanos(&self) -> i64 {
        let mut horizon = match (self.now_nanos, self.at_once) {
            // More of the same time may come.
            (now, false) if now != i64::MAX => now.saturating_sub(1),
            (now, _) => now,
        };
        for source in &self.sources {
            let known = source.known_nanos(self.now_nanos);
            horizon = horizon.min(known);
            let newest = source.samples.as_ref().and_then(Samples::newest_nanos);
            if let Some(newest) = newest
                && known.saturating_sub(newest) <= source.bridged_nanos
            {
                horizon = horizon.min(newest);
            }
        }
        horizon
    }

    fn take(&mut self, time_nanos: i64, item: Item, notes: &mut Notes) {
        self.now_nanos = time_nanos;
        self.origin_nanos.get_or_insert(origin_of(time_nanos));
        match item {
            Item::Row { source, slot } => {
                let state = &mut self.sources[source];
                state.arrived.free.push(slot);
                // Borrowing the row and giving out its slot are both short.
                let row: &[f64] = state.arrived.get(slot);
                match &mut state.frames {
                    Some(frames) => frames.row(time_nanos, row),
                    None => {
                        let ready = state.ready.keep(row);
                        state.give(source, time_nanos, ready, &mut self.outgoing);
                    }
                }
            }
            Item::Transform(edge) => self.take_edge(time_nanos, &edge, notes),
        }
        self.resolve(notes);
        for source in &mut self.sources {
            source.look_for_gap(source.known_nanos(time_nanos), &mut self.outgoing);
        }
    }

    fn take_edge(&mut self, time_nanos: i64, edge: &Edge, notes: &mut Notes) {
        // Transforms are kept by seconds; counted from the first item they are exact enough.
        let time_secs = self.secs(time_nanos);
        let Edge {
            parent,
            child,
            pose,
            is_static,
            offset,
        } = edge;
        match self
            .frames
            .insert(parent, child, time_secs, *pose, *is_static)
        {
            Ok(frame) => {
                let waiting = self
                    .sources
                    .iter_mut()
                    .filter_map(|source| source.frames.as_mut());
                for source in waiting {
                    source.transform(time_nanos, frame, &self.frames);
                }
            }
            Err(problem) => notes.add(StreamNoteKind::BadTransform, "/tf", *offset, || {
                problem.to_string()
            }),
        }
    }

    /// Gives out the rows whose transforms have come, or have not come in time.
    fn resolve(&mut self, notes: &mut Notes) {
        let give_up_nanos = match self.now_nanos {
            i64::MAX => i64::MAX,
            now => now.saturating_sub(self.frame_wait_nanos),
        };
        let origin_nanos = self.origin_nanos();
        let secs = |nanos: i64| nanos.saturating_sub(origin_nanos) as f64 / 1e9;
        for (index, source) in self.sources.iter_mut().enumerate() {
            let Some(mut frames) = source.frames.take() else {
                continue;
            };
            while let Some(found) = frames.resolve(&self.frames, give_up_nanos, secs) {
                if let Some(error) = &found.missing {
                    let note = || error.to_string();
                    notes.add(StreamNoteKind::NoTransform, &source.plan.name, 0, note);
                }
                let slot = source.ready.keep(&found.row);
                source.give(index, found.time_nanos, slot, &mut self.outgoing);
            }
            source.frames = Some(frames);
        }
    }

    /// At the end, values are missing behind the last sample if something else comes later.
    fn close(&mut self) {
        let last_nanos = self
            .outgoing
            .queue
            .back()
            .map_or(i64::MIN, |(time, _)| *time);
        for source in &mut self.sources {
            let newest = source.samples.as_ref().and_then(Samples::newest_nanos);
            if newest.is_some_and(|newest| newest < last_nanos) {
                source.look_for_gap(i64::MAX, &mut self.outgoing);
            }
        }
    }

    /// Moves everything to the instant `time_nanos`, or to an earlier one at which a value becomes
    /// too old.
    fn instant(&mut self, time_nanos: i64) -> Result<i64, TraceError> {
        self.changed.fill(false);
        if self.next_expiry_nanos < time_nanos
            && let Some(expiry_nanos) = self.expire(time_nanos)?
        {
            return Ok(expiry_nanos);
        }
        while let Some(item) = self.outgoing.pop_at(time_nanos) {
            if let Ready::Row { source, slot } = item {
                self.hold(source, slot, time_nanos)?;
            }
        }
        self.interpolate(time_nanos)?;
        Ok(time_nanos)
    }

    /// Takes the values of a row for the signals that hold them.
    fn hold(&mut self, index: usize, slot: usize, time_nanos: i64) -> Result<(), TraceError> {
        let time_secs = self.secs(time_nanos);
        let source = &mut self.sources[index];
        source.ready.free.push(slot);
        let row = &source.ready.values[slot * source.ready.width..][..source.ready.width];
        for (output, expiry) in source.plan.outputs.iter().zip(&mut source.expiry_nanos) {
            if output.interpolation == Interpolation::Linear {
                continue;
            }
            self.snapshot
                .update_field(output.signal, time_secs, row[output.column])?;
            self.changed[output.signal.channel] = true;
            if let Some(staleness) = output.staleness_nanos {
                *expiry = time_nanos.saturating_add(staleness).saturating_add(1);
                self.next_expiry_nanos = self.next_expiry_nanos.min(*expiry);
            }
        }
        Ok(())
    }

    fn interpolate(&mut self, time_nanos: i64) -> Result<(), TraceError> {
        let time_secs = self.secs(time_nanos);
        for source in &mut self.sources {
            let Some(samples) = &mut source.samples else {
                continue;
            };
            samples.advance(time_nanos);
            for output in linear(&source.plan.outputs) {
                let bridged = output.staleness_nanos.unwrap_or(0);
                let value = samples.value(output.column, time_nanos, bridged);
                self.snapshot
                    .update_field(output.signal, time_secs, value)?;
                self.changed[output.signal.channel] = true;
            }
        }
        Ok(())
    }

    /// Drops the values that become too old first, before `time_nanos`, and gives that time.
    fn expire(&mut self, time_nanos: i64) -> Result<Option<i64>, TraceError> {
        let all = self.sources.iter().flat_map(|source| &source.expiry_nanos);
        let first_nanos = all.copied().min().unwrap_or(i64::MAX);
        self.next_expiry_nanos = first_nanos;
        if first_nanos >= time_nanos {
            return Ok(None);
        }
        let time_secs = self.secs(first_nanos);
        for source in &mut self.sources {
            for (output, expiry) in source.plan.outputs.iter().zip(&mut source.expiry_nanos) {
                if *expiry == first_nanos {
                    self.snapshot
                        .update_field(output.signal, time_secs, f64::NAN)?;
                    self.changed[output.signal.channel] = true;
                    *expiry = i64::MAX;
                }
            }
        }
        self.interpolate(first_nanos)?;
        Ok(Some(first_nanos))
    }

    /// A time in seconds from the origin.
    pub fn secs(&self, time_nanos: i64) -> f64 {
        time_nanos.saturating_sub(self.origin_nanos()) as f64 / 1e9
    }

    /// From where seconds are counted.
    pub fn origin_nanos(&self) -> i64 {
        self.origin_nanos.unwrap_or(0)
    }

    /// The values at the last instant.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// For each channel of the layout, whether the last instant changed it.
    pub fn changed(&self) -> &[bool] {
        &self.changed
    }
}

fn linear(outputs: &[Output]) -> impl Iterator<Item = &Output> {
    let mut outputs = outputs.iter();
    std::iter::from_fn(move || outputs.find(|it| it.interpolation == Interpolation::Linear))
}

fn origin_of(first_nanos: i64) -> i64 {
    if first_nanos >= DATE_NANOS {
        first_nanos
    } else {
        0
    }
}

impl Source {
    fn new(plan: SourcePlan, frames: &mut TransformBuffer) -> Self {
        let rows = |width| Rows {
            width,
            ..Rows::default()
        };
        let columns = plan.outputs.iter().map(|output| output.column + 1);
        let ready_width = columns.max().unwrap_or(0);
        Source {
            arrived: rows(plan.width),
            ready: rows(ready_width),
            frames: FrameSource::new(&plan, frames),
            samples: plan.is_linear().then(Samples::default),
            bridged_nanos: plan.bridged_nanos(),
            gap_seen: false,
            expiry_nanos: vec![i64::MAX; plan.outputs.len()],
            plan,
        }
    }

    /// A row is ready: it is a sample of what is interpolated, and an instant.
    fn give(&mut self, index: usize, time_nanos: i64, slot: usize, outgoing: &mut Outgoing) {
        self.look_for_gap(time_nanos, outgoing);
        if let Some(samples) = &mut self.samples {
            samples.push(time_nanos, self.ready.get(slot));
            self.gap_seen = false;
        }
        outgoing.push(
            time_nanos,
            Ready::Row {
                source: index,
                slot,
            },
        );
    }

    /// If no sample can come before `known_nanos`, and that is too far from the newest one, values
    /// are missing right behind that, which is an instant.
    fn look_for_gap(&mut self, known_nanos: i64, outgoing: &mut Outgoing) {
        let newest = self.samples.as_ref().and_then(Samples::newest_nanos);
        if let Some(newest) = newest
            && !self.gap_seen
            && known_nanos.saturating_sub(newest) > self.bridged_nanos
        {
            self.gap_seen = true;
            outgoing.push(newest.saturating_add(1), Ready::Touch);
        }
    }

    /// Up to which time all rows of this source have come, if all items up to `now_nanos` have.
    fn known_nanos(&self, now_nanos: i64) -> i64 {
        let waiting = self.frames.as_ref().and_then(FrameSource::waiting_since);
        waiting.map_or(now_nanos, |since| since.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::plan::{FrameQuantity, FrameQuantityKind, Treatment};
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
        sequencer.finish();
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
        sequencer.finish();
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
        sequencer.finish();
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

    fn shifted(x: f64) -> Transform {
        Transform::new([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap()
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
                    .transform(
                        at,
                        at,
                        ("world", "camera"),
                        shifted(ms as f64 / 1e3),
                        false,
                        0,
                    )
                    .unwrap();
            }
            if ms % 10 == 5 {
                sequencer.row(0, at, at, &[5.0, 0.0, 0.0, camera]).unwrap();
                sequencer.row(1, at + MS, at + MS, &[ms as f64]).unwrap();
            }
        }
        let before_end = drain(&mut sequencer, 2, &mut notes);
        assert!(before_end.len() >= 8, "{before_end:?}");
        sequencer.finish();
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
        sequencer
            .transform(0, 0, ("base", "rail"), shifted(1.0), true, 0)
            .unwrap();
        sequencer
            .transform(0, 0, ("other", "thing"), shifted(1.0), false, 0)
            .unwrap();
        for ms in [10, 20, 30, 40] {
            let at = ms * MS;
            let x = ms as f64 / 1000.0;
            sequencer
                .transform(at, at, ("rail", "hand"), shifted(2.0 * x), false, 0)
                .unwrap();
            if ms != 30 {
                sequencer
                    .transform(at, at, ("world", "base"), shifted(-x), false, 0)
                    .unwrap();
            }
        }
        sequencer.finish();
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
        sequencer.finish();
        let found = drain(&mut sequencer, 1, &mut Notes::default());
        let secs: Vec<f64> = found
            .iter()
            .map(|(nanos, _)| sequencer.secs(*nanos))
            .collect();
        assert_eq!(secs, [0.0, 1e-9, 1.5]);
        assert_eq!(sequencer.origin_nanos(), start);
    }
}
