//! From rows and transforms as they arrive to the values of all signals at one instant after
//! another.
//!
//! What arrives is put in order of time first ([`ReorderBuffer`]). Then rows that need a transform
//! wait for it, and all rows wait until it is known what the linearly interpolated signals are at
//! their time. An instant is the time of one or more rows; it is given out once no earlier row, and
//! no other row of the same time, can come. When the last value of a signal becomes too old, that
//! is an instant as well, one nanosecond later, so that a monitor sees the value go.

use trace::{Snapshot, Trace, TraceError};

use super::frames::FrameSource;
use super::linear::Samples;
use super::plan::SourcePlan;
use super::report::{Notes, StreamNoteKind};
use super::source::{Outgoing, Ready, Source, linear};
use crate::clock::{Late, ReorderBuffer, TimeSettings, nanos_of_secs};
use crate::topic_map::Interpolation;
use crate::transform::{FrameId, Transform, TransformBuffer};

/// Times from here on (3 years, in seconds) are taken for dates and counted from the first instant.
const DATE_NANOS: i64 = 100_000_000_000_000_000;

/// What arrives, and when in log time.
#[derive(Debug)]
struct Arrived {
    arrival_nanos: i64,
    item: Item,
}

#[derive(Debug)]
enum Item {
    Row { source: usize, slot: usize },
    Transform(Box<Edge>),
}

/// The pose of one frame in another, as it was recorded.
#[derive(Debug)]
pub(super) struct Edge {
    pub parent: String,
    pub child: String,
    pub pose: Transform,
    /// Where in the recording, in bytes.
    pub offset: u64,
}

/// Puts everything in order; see the module's documentation.
#[derive(Debug)]
pub(super) struct Sequencer {
    sources: Vec<Source>,
    incoming: ReorderBuffer<Arrived>,
    /// In order of time.
    outgoing: Outgoing,
    frames: TransformBuffer,
    frame_wait_nanos: i64,
    /// Static frames that have come since the last item.
    new_static: Vec<FrameId>,
    /// The most rows that wait for others; more are given out before all is known.
    max_waiting: usize,
    /// How far log time is ahead of the chosen time, at the last item and at the last row given.
    behind_nanos: i64,
    log_behind_nanos: i64,
    /// The last instant that was given out, and its log time.
    last_nanos: i64,
    log_nanos: i64,
    /// The time up to which everything has come; `i64::MIN` before the first item.
    now_nanos: i64,
    finished: bool,
    at_once: bool,
    /// Until when the recorder was at work, if that is known.
    end_nanos: Option<i64>,
    /// The earliest time at which a value may become too old.
    next_expiry_nanos: i64,
    snapshot: Snapshot,
    changed: Vec<bool>,
    /// For each signal, by channel and field: whether the last instant is one of its samples, and
    /// whether its value has become too old since its last one.
    sampled: Vec<Vec<bool>>,
    dropped: Vec<Vec<bool>>,
    /// The sources that have given a row to the last sample, and whether another sample of the same
    /// instant follows.
    seen: Vec<bool>,
    more: bool,
    origin_nanos: Option<i64>,
}

impl Sequencer {
    pub fn new(layout: &Trace, plans: Vec<SourcePlan>, time: &TimeSettings) -> Self {
        let mut frames = TransformBuffer::new(time.frame_history_secs.max(time.frame_wait_secs));
        let sources = plans
            .into_iter()
            .map(|plan| Source::new(plan, &mut frames))
            .collect::<Vec<_>>();
        frames.bridge(time.frame_gap_secs);
        let none: Vec<Vec<bool>> = (layout.channels.iter())
            .map(|channel| vec![false; channel.fields.len()])
            .collect();
        let reorder_nanos = nanos_of_secs(time.reorder_secs);
        Sequencer {
            seen: vec![false; sources.len()],
            more: false,
            sampled: none.clone(),
            dropped: none,
            sources,
            incoming: ReorderBuffer::new(reorder_nanos, time.reorder_messages),
            outgoing: Outgoing::default(),
            frames,
            frame_wait_nanos: nanos_of_secs(time.frame_wait_secs),
            new_static: Vec::new(),
            max_waiting: time.reorder_messages,
            behind_nanos: 0,
            log_behind_nanos: 0,
            last_nanos: i64::MIN,
            log_nanos: i64::MIN,
            now_nanos: i64::MIN,
            finished: false,
            at_once: reorder_nanos == 0,
            end_nanos: None,
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
        let item = Arrived {
            arrival_nanos,
            item: Item::Row { source, slot },
        };
        let taken = self.incoming.push(time_nanos, arrival_nanos, item);
        if taken.is_err() {
            arrived.free.push(slot);
        }
        taken
    }

    /// Takes a transform that was measured at `time_nanos` and read at `arrival_nanos`.
    pub fn transform(
        &mut self,
        time_nanos: i64,
        arrival_nanos: i64,
        edge: Edge,
    ) -> Result<(), Late> {
        let item = Arrived {
            arrival_nanos,
            item: Item::Transform(Box::new(edge)),
        };
        self.incoming.push(time_nanos, arrival_nanos, item)
    }

    /// Takes a transform that holds for all times, so that it need not be put in order.
    pub fn static_transform(&mut self, edge: &Edge, notes: &mut Notes) {
        let frame = self.insert(0.0, edge, true, notes);
        self.new_static.extend(frame);
    }

    /// Nothing more will arrive; the recorder was at work until `end_nanos`, so that values that were
    /// too old by then became so, whatever other signals are read.
    pub fn finish(&mut self, end_nanos: Option<i64>) {
        self.finished = true;
        self.end_nanos = end_nanos;
    }

    /// Moves to the next instant and gives its time in nanoseconds; `None` if more has to arrive
    /// first, or after the end.
    pub fn next(&mut self, notes: &mut Notes) -> Result<Option<i64>, TraceError> {
        loop {
            // All rows of a message are taken before an instant is given, or it would hold half of
            // them.
            if self.at_once
                && let Some((time_nanos, item)) = self.incoming.pop()
            {
                self.take(time_nanos, item, notes);
                continue;
            }
            if let Some(front) = self.outgoing.front_nanos()
                && (front <= self.horizon_nanos() || self.outgoing.len() > self.max_waiting)
            {
                if front >= self.last_nanos {
                    return self.instant(front).map(Some);
                }
                self.drop_late(front, notes);
                continue;
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
                None => return self.old_by_the_end(),
            }
        }
    }

    /// Behind the last row, the next time at which a value became too old.
    fn old_by_the_end(&mut self) -> Result<Option<i64>, TraceError> {
        let Some(end_nanos) = self.end_nanos.filter(|_| self.finished) else {
            return Ok(None);
        };
        if self.next_expiry_nanos > end_nanos {
            return Ok(None);
        }
        self.begin_instant();
        self.expire(end_nanos.saturating_add(1))
    }

    fn begin_instant(&mut self) {
        self.changed.fill(false);
        (self.sampled.iter_mut()).for_each(|fields| fields.fill(false));
        self.seen.fill(false);
        self.more = false;
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

    fn take(&mut self, time_nanos: i64, arrived: Arrived, notes: &mut Notes) {
        self.behind_nanos = arrived.arrival_nanos.saturating_sub(time_nanos);
        self.now_nanos = time_nanos;
        self.origin_nanos.get_or_insert(origin_of(time_nanos));
        for frame in std::mem::take(&mut self.new_static) {
            self.tell_frames(time_nanos, frame);
        }
        match arrived.item {
            Item::Row { source, slot } => {
                let state = &mut self.sources[source];
                state.arrived.free.push(slot);
                // Borrowing the row and giving out its slot are both short.
                let row: &[f64] = state.arrived.get(slot);
                match &mut state.frames {
                    Some(frames) => frames.row(time_nanos, row),
                    None => {
                        let ready = state.ready.keep(row);
                        let behind_nanos = self.behind_nanos;
                        state.give(
                            source,
                            time_nanos,
                            (ready, behind_nanos),
                            &mut self.outgoing,
                        );
                    }
                }
            }
            Item::Transform(edge) => self.take_edge(time_nanos, &edge, notes),
        }
        self.resolve(notes);
        for (index, source) in self.sources.iter_mut().enumerate() {
            let known_nanos = source.known_nanos(time_nanos);
            source.look_for_gap(index, known_nanos, true, &mut self.outgoing);
        }
    }

    fn take_edge(&mut self, time_nanos: i64, edge: &Edge, notes: &mut Notes) {
        // Transforms are kept by seconds; counted from the first item they are exact enough.
        let time_secs = self.secs(time_nanos);
        if let Some(frame) = self.insert(time_secs, edge, false, notes) {
            self.tell_frames(time_nanos, frame);
        }
    }

    fn insert(
        &mut self,
        time_secs: f64,
        edge: &Edge,
        is_static: bool,
        notes: &mut Notes,
    ) -> Option<FrameId> {
        let (parent, child) = (&edge.parent, &edge.child);
        let inserted = self
            .frames
            .insert(parent, child, time_secs, edge.pose, is_static);
        if let Err(problem) = &inserted {
            let topic = if is_static { "/tf_static" } else { "/tf" };
            let note = || problem.to_string();
            notes.add(StreamNoteKind::BadTransform, topic, edge.offset, note);
        }
        inserted.ok()
    }

    /// Lets every quantity know that a transform on its way may have changed.
    fn tell_frames(&mut self, time_nanos: i64, frame: FrameId) {
        let sources = self.sources.iter_mut();
        for source in sources.filter_map(|source| source.frames.as_mut()) {
            source.transform(time_nanos, frame, &self.frames);
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
                let ready = (slot, self.behind_nanos);
                source.give(index, found.time_nanos, ready, &mut self.outgoing);
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
        for (index, source) in self.sources.iter_mut().enumerate() {
            let newest = source.samples.as_ref().and_then(Samples::newest_nanos);
            if newest.is_some_and(|newest| newest < last_nanos) {
                source.look_for_gap(index, i64::MAX, false, &mut self.outgoing);
            }
        }
    }

    /// Moves everything to the instant `time_nanos`, or to an earlier one at which a value becomes
    /// too old. Where a source has several rows of that time, each is a sample of the instant: the
    /// first rows of all sources are taken together, then the second ones, and so on.
    fn instant(&mut self, time_nanos: i64) -> Result<i64, TraceError> {
        self.begin_instant();
        self.log_nanos = time_nanos.saturating_add(self.log_behind_nanos);
        if self.next_expiry_nanos < time_nanos
            && let Some(expiry_nanos) = self.expire(time_nanos)?
        {
            return Ok(expiry_nanos);
        }
        loop {
            self.more = self.outgoing.is_row_of(time_nanos, &self.seen);
            if self.more {
                break;
            }
            match self.outgoing.pop_at(time_nanos) {
                None => break,
                Some(Ready::Row {
                    source,
                    slot,
                    behind_nanos,
                }) => {
                    self.log_nanos = time_nanos.saturating_add(behind_nanos);
                    self.log_behind_nanos = behind_nanos;
                    self.seen[source] = true;
                    self.hold(source, slot, time_nanos)?;
                }
                Some(Ready::Touch { source, is_sample }) => {
                    for output in &self.sources[source].plan.outputs {
                        self.sampled[output.signal.channel][output.signal.field] |= is_sample;
                        self.dropped[output.signal.channel][output.signal.field] = is_sample;
                    }
                }
            }
        }
        self.interpolate(time_nanos)?;
        self.last_nanos = time_nanos;
        Ok(time_nanos)
    }

    /// Leaves out what became known only after a later instant had to be given out.
    fn drop_late(&mut self, time_nanos: i64, notes: &mut Notes) {
        if let Some(Ready::Row { source, slot, .. }) = self.outgoing.pop_at(time_nanos) {
            let source = &mut self.sources[source];
            source.ready.free.push(slot);
            let note = || "more messages wait than are kept".to_owned();
            notes.add(StreamNoteKind::Late, &source.plan.name, 0, note);
        }
    }

    /// Takes the values of a row for the signals that hold them.
    fn hold(&mut self, index: usize, slot: usize, time_nanos: i64) -> Result<(), TraceError> {
        let time_secs = self.secs(time_nanos);
        let source = &mut self.sources[index];
        source.ready.free.push(slot);
        let row = &source.ready.values[slot * source.ready.width..][..source.ready.width];
        for (output, expiry) in source.plan.outputs.iter().zip(&mut source.expiry_nanos) {
            self.sampled[output.signal.channel][output.signal.field] = true;
            self.dropped[output.signal.channel][output.signal.field] = false;
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
                    self.sampled[output.signal.channel][output.signal.field] = true;
                    self.dropped[output.signal.channel][output.signal.field] = true;
                    *expiry = i64::MAX;
                }
            }
        }
        self.interpolate(first_nanos)?;
        self.log_nanos = first_nanos.saturating_add(self.log_behind_nanos);
        self.last_nanos = first_nanos;
        Ok(Some(first_nanos))
    }

    /// The time of the first that was taken and is not part of an instant yet, or of the first
    /// value that may become too old: up to there nothing can change but by what comes.
    pub fn steady_before_nanos(&self) -> i64 {
        let frames = self.sources.iter().filter_map(|it| it.frames.as_ref());
        let waiting = frames.filter_map(FrameSource::waiting_since);
        let first = [self.incoming.first_nanos(), self.outgoing.front_nanos()];
        let first = first.into_iter().flatten().chain(waiting).min();
        first.unwrap_or(i64::MAX).min(self.next_expiry_nanos)
    }

    /// A time in seconds from the origin.
    pub fn secs(&self, time_nanos: i64) -> f64 {
        time_nanos.saturating_sub(self.origin_nanos()) as f64 / 1e9
    }

    /// The time of the last instant; `None` before the first.
    pub fn last_nanos(&self) -> Option<i64> {
        (self.last_nanos != i64::MIN).then_some(self.last_nanos)
    }

    /// The log time of the last instant.
    pub fn log_nanos(&self) -> i64 {
        self.log_nanos
    }

    /// From where seconds are counted.
    pub fn origin_nanos(&self) -> i64 {
        self.origin_nanos.unwrap_or(0)
    }

    /// The values at the last instant.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// For each signal, by channel and field, whether the last instant is one of its samples.
    pub fn sampled(&self) -> &[Vec<bool>] {
        &self.sampled
    }

    /// For each signal, whether its value has become too old since its last sample.
    pub fn dropped(&self) -> &[Vec<bool>] {
        &self.dropped
    }

    /// Whether another sample of the last instant follows.
    pub fn more(&self) -> bool {
        self.more
    }

    /// Whether any value can become too old.
    pub fn can_drop(&self) -> bool {
        let mut outputs = self.sources.iter().flat_map(|it| &it.plan.outputs);
        outputs.any(|output| output.staleness_nanos.is_some())
    }

    /// For each channel of the layout, whether the last instant changed it.
    pub fn changed(&self) -> &[bool] {
        &self.changed
    }
}

fn origin_of(first_nanos: i64) -> i64 {
    if first_nanos >= DATE_NANOS {
        first_nanos
    } else {
        0
    }
}

#[cfg(test)]
mod tests;
