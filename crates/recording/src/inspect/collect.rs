//! One pass over a recording.

use std::collections::BTreeMap;

use super::fields::{FieldSummary, fields_of};
use super::periods::Periods;
use super::{FrameInspection, InspectOptions, Inspection, TopicInspection};
use crate::decode::{Extractor, FieldPath};
use crate::reader::{RawMessage, Reader, TopicInfo};
use crate::signals::transforms_of;
use crate::transform::{Transform, TransformBuffer};

/// What was seen of one topic.
struct Seen {
    info: TopicInfo,
    periods: Periods,
    messages: u64,
    bytes: u64,
    first_nanos: Option<i64>,
    last_nanos: Option<i64>,
    /// Of the stamp, or of nothing if the messages have none.
    extractor: Option<Extractor>,
    has_stamp: bool,
    behind_nanos: Option<(i64, i64)>,
    unstamped: u64,
    undecodable: Option<String>,
    misfits: u64,
    first_misfit: Option<String>,
    fields: Vec<FieldSummary>,
}

/// The transforms of all topics.
struct Frames {
    buffer: TransformBuffer,
    problems: BTreeMap<String, u64>,
}

pub(super) fn collect(reader: &mut dyn Reader, options: &InspectOptions) -> Inspection {
    let mut topics: Vec<Seen> = reader.topics().iter().map(Seen::new).collect();
    let mut frames = Frames {
        buffer: TransformBuffer::new(0.0),
        problems: BTreeMap::new(),
    };
    let mut error = None;
    loop {
        let known = topics.len();
        match reader.next() {
            Ok(None) => break,
            Err(problem) => {
                error = Some(problem.to_string());
                break;
            }
            Ok(Some(message)) if message.topic.index() < known => {
                topics[message.topic.index()].take(&message, &mut frames);
            }
            Ok(Some(message)) => {
                // The topic is new; the message has to be let go before it can be looked at.
                let data = message.data.to_vec();
                let (topic, log_nanos, publish_nanos) =
                    (message.topic, message.log_nanos, message.publish_nanos);
                let offset = message.offset;
                topics.extend(reader.topics()[known..].iter().map(Seen::new));
                let message = RawMessage {
                    topic,
                    log_nanos,
                    publish_nanos,
                    data: &data,
                    offset,
                };
                if let Some(seen) = topics.get_mut(topic.index()) {
                    seen.take(&message, &mut frames);
                }
            }
        }
    }
    let mut topics: Vec<TopicInspection> = topics
        .into_iter()
        .map(|seen| seen.summary(options))
        .collect();
    topics.sort_by(|left, right| left.name.cmp(&right.name));
    Inspection {
        messages: topics.iter().map(|topic| topic.messages).sum(),
        first_nanos: topics.iter().filter_map(|topic| topic.first_nanos).min(),
        last_nanos: topics.iter().filter_map(|topic| topic.last_nanos).max(),
        topics,
        files: reader.storage(),
        frames: frames.summary(),
        frame_problems: frames.problems.into_iter().collect(),
        losses: reader.losses().iter().map(ToString::to_string).collect(),
        complete: reader.complete() && error.is_none(),
        error,
    }
}

impl Frames {
    fn take(&mut self, info: &TopicInfo, message: &RawMessage<'_>) {
        let Ok(transforms) = transforms_of(&info.encoding, message.data) else {
            return;
        };
        for one in transforms {
            let is_static = info.name.ends_with("tf_static");
            let time_secs = one.stamp_nanos as f64 / 1e9;
            let inserted = Transform::new(one.translation_m, one.rotation_xyzw).and_then(|pose| {
                self.buffer
                    .insert(&one.parent, &one.child, time_secs, pose, is_static)
            });
            if let Err(problem) = inserted {
                // Times differ from one to the next; what counts is what happens.
                let text = match problem {
                    crate::TransformProblem::TooOld { child, .. } => {
                        format!("transforms of frame {child} go back in time")
                    }
                    other => format!("{} in {}: {other}", one.child, one.parent),
                };
                *self.problems.entry(text).or_default() += 1;
            }
        }
    }

    fn summary(&self) -> Vec<FrameInspection> {
        let edges = self.buffer.edges();
        let edges = edges.map(|(frame, parent, is_static)| FrameInspection {
            frame: frame.to_owned(),
            parent: parent.to_owned(),
            is_static,
        });
        edges.collect()
    }
}

impl Seen {
    fn new(info: &TopicInfo) -> Self {
        let stamp = ["header.stamp.sec", "header.stamp.nanosec"].map(FieldPath::parse);
        let paths: Vec<FieldPath> = stamp.into_iter().filter_map(Result::ok).collect();
        let stamped = Extractor::new(info, &paths);
        let has_stamp = stamped.is_ok();
        let (extractor, undecodable) = match stamped.or_else(|_| Extractor::new(info, &[])) {
            Ok(extractor) => (Some(extractor), None),
            Err(error) => (None, Some(error.message)),
        };
        Seen {
            info: info.clone(),
            periods: Periods::new(),
            messages: 0,
            bytes: 0,
            first_nanos: None,
            last_nanos: None,
            extractor,
            has_stamp,
            behind_nanos: None,
            unstamped: 0,
            undecodable,
            misfits: 0,
            first_misfit: None,
            fields: Vec::new(),
        }
    }

    fn take(&mut self, message: &RawMessage<'_>, frames: &mut Frames) {
        self.messages += 1;
        self.bytes += message.data.len() as u64;
        let log_nanos = message.log_nanos;
        self.first_nanos = Some(
            self.first_nanos
                .map_or(log_nanos, |first| first.min(log_nanos)),
        );
        self.last_nanos = Some(
            self.last_nanos
                .map_or(log_nanos, |last| last.max(log_nanos)),
        );
        self.periods.push(log_nanos);
        let Some(extractor) = &mut self.extractor else {
            return;
        };
        if let Err(error) = extractor.verify(message.data) {
            self.misfits += 1;
            let at = message.offset;
            self.first_misfit
                .get_or_insert_with(|| format!("at byte {at}: {error}"));
            return;
        }
        self.stamp(message);
        if self.fields.is_empty() {
            self.fields = fields_of(&self.info, message.data);
        }
        let type_name = self.info.type_name.to_lowercase();
        if type_name.ends_with("/tfmessage") {
            frames.take(&self.info, message);
        }
    }

    fn stamp(&mut self, message: &RawMessage<'_>) {
        let mut stamp = [f64::NAN; 2];
        let Some(extractor) = self.extractor.as_mut().filter(|_| self.has_stamp) else {
            return;
        };
        if extractor.extract(message.data, &mut stamp).is_err()
            || stamp.iter().any(|it| it.is_nan())
        {
            return;
        }
        let stamp_nanos = (stamp[0] as i64)
            .saturating_mul(1_000_000_000)
            .saturating_add(stamp[1] as i64);
        if stamp_nanos == 0 {
            self.unstamped += 1;
            return;
        }
        let behind = message.log_nanos.saturating_sub(stamp_nanos);
        let (least, most) = self.behind_nanos.unwrap_or((behind, behind));
        self.behind_nanos = Some((least.min(behind), most.max(behind)));
    }

    fn summary(self, options: &InspectOptions) -> TopicInspection {
        let span_nanos = self.first_nanos.zip(self.last_nanos);
        let span_secs = span_nanos.map(|(first, last)| last.saturating_sub(first) as f64 / 1e9);
        let rate_hz = span_secs.filter(|secs| *secs > 0.0);
        let median = self.periods.median_secs();
        let longest = self.periods.longest_nanos();
        TopicInspection {
            rate_hz: rate_hz.map(|secs| (self.messages - 1) as f64 / secs),
            median_period_secs: median,
            jitter_secs: self.periods.deviation_secs(),
            longest_gap_secs: longest.map(|(nanos, _)| nanos as f64 / 1e9),
            longest_gap_at_nanos: longest.map(|(_, at)| at),
            gaps: median.map_or(0, |median| {
                self.periods.longer_than(options.gap_factor * median)
            }),
            out_of_order: self.periods.out_of_order(),
            behind_stamp_secs: self
                .behind_nanos
                .map(|(least, most)| (least as f64 / 1e9, most as f64 / 1e9)),
            name: self.info.name,
            type_name: self.info.type_name,
            encoding: self.info.encoding.to_string(),
            messages: self.messages,
            bytes: self.bytes,
            first_nanos: self.first_nanos,
            last_nanos: self.last_nanos,
            unstamped: self.unstamped,
            undecodable: self.undecodable,
            misfits: self.misfits,
            first_misfit: self.first_misfit,
            fields: self.fields,
        }
    }
}
