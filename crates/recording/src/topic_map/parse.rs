//! From TOML to entries, with the place of each mistake.

mod text;

use std::borrow::Cow;
use std::ops::Range;

use serde::Deserialize as _;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};
use trace::FieldKind;
use trace::duration::DurationError;

use self::text::{EntryText, InterpolationText, KindText, OneOrMore, TimeSourceText, TimeText};
use super::entry::{Interpolation, MappedSignal, SignalSource};
use super::{TopicMap, TopicMapError};
use crate::clock::{TimeSettings, TimeSource};

/// The longest duration that can be meant: ten years.
const MAX_DURATION_SECS: f64 = 3.2e8;

/// The JSON Schema of a topic map.
pub(super) fn schema() -> schemars::Schema {
    schemars::schema_for!(text::TopicMapText)
}

/// The file, from which mistakes are told.
struct Reader<'a> {
    file: &'a str,
    text: &'a str,
    errors: Vec<TopicMapError>,
}

pub(super) fn parse(file: &str, text: &str) -> Result<TopicMap, Vec<TopicMapError>> {
    let mut reader = Reader {
        file,
        text,
        errors: Vec::new(),
    };
    let mut map = TopicMap::default();
    match DeTable::parse(text) {
        Ok(table) => {
            // The table sorts its keys; the order of the file is that of their places.
            let mut entries: Vec<_> = table.into_inner().into_iter().collect();
            entries.sort_by_key(|(key, _)| key.span().start);
            for (key, value) in entries {
                reader.item(&mut map, &key, value);
            }
        }
        Err(error) => reader.toml_error(&error, 0..0),
    }
    if reader.errors.is_empty() {
        Ok(map)
    } else {
        reader.errors.sort_by_key(|error| error.span.start);
        Err(reader.errors)
    }
}

impl Reader<'_> {
    fn error(&mut self, span: Range<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        let error = TopicMapError::new(self.file, self.text, span, message, remedy);
        self.errors.push(error);
    }

    fn toml_error(&mut self, error: &toml::de::Error, around: Range<usize>) {
        let span = error.span().unwrap_or(around);
        let remedy = "the documentation of topic maps lists what an entry can say";
        self.error(span, error.message().to_owned(), remedy);
    }

    /// Takes one table of the file; each on its own, so that every mistake is told at once.
    fn item(
        &mut self,
        map: &mut TopicMap,
        key: &Spanned<Cow<'_, str>>,
        value: Spanned<DeValue<'_>>,
    ) {
        let span = value.span();
        let value = ValueDeserializer::from(value);
        if key.get_ref() == "time" {
            match TimeText::deserialize(value) {
                Ok(text) => map.time = self.time(text),
                Err(error) => self.toml_error(&error, span),
            }
            return;
        }
        match EntryText::deserialize(value) {
            Ok(text) => {
                if let Some(entry) = self.entry(key, text) {
                    self.check_names(map, &entry, key.span());
                    map.signals.push(entry);
                }
            }
            Err(error) => self.toml_error(&error, span),
        }
    }

    fn time(&mut self, text: TimeText) -> TimeSettings {
        let usual = TimeSettings::default();
        let mut or = |duration: Option<Spanned<String>>, usual: f64| {
            duration
                .and_then(|text| self.duration_secs(&text))
                .unwrap_or(usual)
        };
        TimeSettings {
            source: match text.from {
                None | Some(TimeSourceText::Log) => TimeSource::Log,
                Some(TimeSourceText::Publish) => TimeSource::Publish,
                Some(TimeSourceText::Header) => TimeSource::Header,
                Some(TimeSourceText::Clock) => TimeSource::Clock,
            },
            reorder_secs: or(text.reorder, usual.reorder_secs),
            frame_wait_secs: or(text.frame_wait, usual.frame_wait_secs),
            frame_history_secs: or(text.frame_history, usual.frame_history_secs),
            frame_gap_secs: or(text.frame_gap, usual.frame_gap_secs),
            ..usual
        }
    }

    fn entry(&mut self, key: &Spanned<Cow<'_, str>>, text: EntryText) -> Option<MappedSignal> {
        let in_frame = text.in_frame.as_ref();
        let source = self.source(key, &text)?;
        let takes_frame = !matches!(
            source,
            SignalSource::Value { .. }
                | SignalSource::Norm { .. }
                | SignalSource::DistanceBetween { .. }
        );
        if let (false, Some(in_frame)) = (takes_frame, in_frame) {
            let remedy = "use point or vector, or write the recorded frame as frame";
            self.error(
                in_frame.span(),
                "in_frame turns points and vectors, not single values",
                remedy,
            );
        }
        let staleness_secs = text
            .staleness
            .as_ref()
            .and_then(|text| self.duration_secs(text));
        let before = self.text.get(..key.span().start).unwrap_or("");
        let entry = MappedSignal {
            line: 1 + before.matches('\n').count(),
            unit: text.unit.as_ref().map(|unit| unit.get_ref().clone()),
            frame: text
                .frame
                .as_ref()
                .map(|frame| plain_frame(frame.get_ref())),
            kind: self.kind(&text),
            scale: text.scale.as_ref().map_or(1.0, |scale| *scale.get_ref()),
            offset: text.offset.as_ref().map_or(0.0, |offset| *offset.get_ref()),
            interpolation: match text.interpolation.as_ref().map(|it| *it.get_ref()) {
                Some(InterpolationText::Linear) => Interpolation::Linear,
                None | Some(InterpolationText::Hold) => Interpolation::Hold,
            },
            staleness_secs,
            ..MappedSignal::new(key.get_ref().as_ref(), source)
        };
        self.check_meaning(&entry, &text);
        Some(entry)
    }

    /// The one way in which the entry says where its values come from.
    fn source(&mut self, key: &Spanned<Cow<'_, str>>, text: &EntryText) -> Option<SignalSource> {
        let mut found: Vec<(Range<usize>, &str, SignalSource)> = Vec::new();
        let in_frame = text
            .in_frame
            .as_ref()
            .map(|frame| plain_frame(frame.get_ref()));
        // Frames that are missing here are complained about below.
        let seen_from = in_frame.clone().unwrap_or_default();
        if let Some(from) = &text.from {
            let source = SignalSource::Value {
                from: from.get_ref().clone(),
            };
            found.push((from.span(), "from", source));
        }
        if let Some(norm) = &text.norm {
            let of = match norm.get_ref() {
                OneOrMore::One(path) => ["x", "y", "z"].map(|axis| format!("{path}.{axis}")).into(),
                OneOrMore::More(paths) => paths.clone(),
            };
            found.push((norm.span(), "norm", SignalSource::Norm { of }));
        }
        if let Some(point) = &text.point {
            let of = point.get_ref().clone();
            let source = SignalSource::Point {
                of,
                in_frame: in_frame.clone(),
            };
            found.push((point.span(), "point", source));
        }
        if let Some(vector) = &text.vector {
            let of = vector.get_ref().clone();
            found.push((
                vector.span(),
                "vector",
                SignalSource::Vector { of, in_frame },
            ));
        }
        let frames = [
            (&text.position_of, "position_of"),
            (&text.orientation_of, "orientation_of"),
            (&text.speed_of, "speed_of"),
        ];
        for (frame, word) in frames {
            let Some(frame) = frame else { continue };
            let (name, in_frame) = (plain_frame(frame.get_ref()), seen_from.clone());
            let source = match word {
                "position_of" => SignalSource::PositionOf {
                    frame: name,
                    in_frame,
                },
                "orientation_of" => SignalSource::OrientationOf {
                    frame: name,
                    in_frame,
                },
                _ => SignalSource::SpeedOf {
                    frame: name,
                    in_frame,
                },
            };
            if seen_from.is_empty() {
                let message = format!("{word} needs the frame from which it is seen");
                self.error(
                    frame.span(),
                    message,
                    "add in_frame = \"world\" or the frame you mean",
                );
            }
            found.push((frame.span(), word, source));
        }
        if let Some(frames) = &text.distance_between {
            let names = frames.get_ref().each_ref().map(|frame| plain_frame(frame));
            let source = SignalSource::DistanceBetween { frames: names };
            found.push((frames.span(), "distance_between", source));
        }
        self.one_of(key, found)
    }

    fn one_of(
        &mut self,
        key: &Spanned<Cow<'_, str>>,
        mut found: Vec<(Range<usize>, &str, SignalSource)>,
    ) -> Option<SignalSource> {
        if let [(_, first, _), (span, second, _), ..] = found.as_slice() {
            let message = format!("this entry has both {first} and {second}");
            let span = span.clone();
            self.error(span, message, "keep the one that you mean");
            return None;
        }
        let Some((span, _, source)) = found.pop() else {
            let remedy = "add from = \"/topic.field\", point, vector, norm, position_of, \
                          orientation_of, distance_between or speed_of";
            self.error(
                key.span(),
                "this entry does not say where its values come from",
                remedy,
            );
            return None;
        };
        let paths: Vec<&String> = match &source {
            SignalSource::Value { from } => vec![from],
            SignalSource::Norm { of } => of.iter().collect(),
            SignalSource::Point { of, .. } | SignalSource::Vector { of, .. } => vec![of],
            _ => Vec::new(),
        };
        if matches!(&source, SignalSource::Norm { of } if of.is_empty()) {
            self.error(span, "the norm of nothing", "list the paths of the numbers");
            return None;
        }
        if paths.iter().any(|path| !is_path(path)) {
            let remedy = "write the topic, a dot and the field, as in /joint_states.velocity[0]";
            self.error(span, "this is not a path into a topic", remedy);
            return None;
        }
        Some(source)
    }

    fn kind(&mut self, text: &EntryText) -> FieldKind {
        match (&text.kind, &text.values) {
            (Some(kind), Some(values)) => {
                let _ = kind;
                let remedy = "leave one of the two out";
                self.error(
                    values.span(),
                    "values makes names of it, kind something else",
                    remedy,
                );
                FieldKind::Number
            }
            (_, Some(values)) => {
                let names = values.get_ref();
                let repeated = names
                    .iter()
                    .enumerate()
                    .find(|(at, name)| names[..*at].contains(name));
                if let Some((_, name)) = repeated {
                    let message = format!("{name} is listed twice");
                    self.error(values.span(), message, "list each name once");
                }
                if names.is_empty() {
                    self.error(
                        values.span(),
                        "there is no name",
                        "list the names of the values",
                    );
                }
                FieldKind::Enumeration(names.clone())
            }
            (Some(kind), None) if *kind.get_ref() == KindText::Bool => FieldKind::Bool,
            _ => FieldKind::Number,
        }
    }

    /// Checks that what is said about the values makes sense together.
    fn check_meaning(&mut self, entry: &MappedSignal, text: &EntryText) {
        let is_number = entry.kind == FieldKind::Number;
        let has_kind = text
            .kind
            .as_ref()
            .map(Spanned::span)
            .or(text.values.as_ref().map(Spanned::span));
        if let (true, Some(span)) = (
            !matches!(entry.source, SignalSource::Value { .. }),
            has_kind,
        ) && !is_number
        {
            self.error(
                span,
                "only a single value can be a truth value or a name",
                "use from",
            );
        }
        let from_frames = !matches!(
            entry.source,
            SignalSource::Value { .. }
                | SignalSource::Norm { .. }
                | SignalSource::Point { .. }
                | SignalSource::Vector { .. }
        );
        let changed = [
            text.unit.as_ref().map(Spanned::span),
            text.scale.as_ref().map(Spanned::span),
            text.offset.as_ref().map(Spanned::span),
            text.frame.as_ref().map(Spanned::span),
        ];
        if let (true, Some(span)) = (from_frames, changed.into_iter().flatten().next()) {
            let remedy = "leave it out: transforms are in metres, seen from in_frame";
            self.error(
                span,
                "this does not apply to what comes from transforms",
                remedy,
            );
        }
        for factor in [&text.scale, &text.offset].into_iter().flatten() {
            if !is_number || !factor.get_ref().is_finite() {
                let remedy = "give a finite number, for numbers only";
                self.error(factor.span(), "this cannot scale the values", remedy);
            }
        }
        if let Some(scale) = text.scale.as_ref().filter(|scale| *scale.get_ref() == 0.0) {
            self.error(
                scale.span(),
                "a scale of 0 makes every value the same",
                "give the factor",
            );
        }
        let Some(interpolation) = text.interpolation.as_ref() else {
            return;
        };
        if entry.interpolation == Interpolation::Hold {
            return;
        }
        if !is_number || matches!(entry.source, SignalSource::OrientationOf { .. }) {
            let remedy = "use interpolation = \"hold\"";
            self.error(
                interpolation.span(),
                "this cannot be interpolated linearly",
                remedy,
            );
        }
        if entry.staleness_secs.is_none() && text.staleness.is_none() {
            let remedy = "add staleness = \"0.5 s\" or what fits: wider gaps are not bridged";
            self.error(
                interpolation.span(),
                "linear interpolation needs a staleness",
                remedy,
            );
        }
    }

    /// Checks that the names of the new entry's signals are names, and new.
    fn check_names(&mut self, map: &TopicMap, entry: &MappedSignal, span: Range<usize>) {
        for name in entry.part_names() {
            if MappedSignal::split(&name).is_none() {
                let message = format!("{} is not a valid name of a signal", entry.name);
                let remedy = "write a topic, a dot and a field, as in [\"/robot.hand_speed\"]";
                self.error(span.clone(), message, remedy);
                return;
            }
            if let Some((other, _)) = map.find(&name) {
                let message = format!("{name} is given by the entry of line {} too", other.line);
                self.error(span.clone(), message, "rename one of the two");
            }
        }
    }

    /// The seconds that `text` means, for example `0.5 s` or `20 ms`.
    fn duration_secs(&mut self, text: &Spanned<String>) -> Option<f64> {
        let read = trace::duration::seconds(text.get_ref()).ok();
        let secs = read.filter(|secs| *secs <= MAX_DURATION_SECS);
        if secs.is_none() {
            let message = format!("\"{}\" is not a valid duration", text.get_ref());
            self.error(text.span(), message, DurationError::REMEDY);
        }
        secs
    }
}

/// Whether there is something before and behind a dot. Topics of other systems than ROS need not
/// begin with a slash.
fn is_path(path: &str) -> bool {
    path.split_once('.')
        .is_some_and(|(topic, field)| !topic.is_empty() && !field.is_empty())
}

/// The name of a frame without the slash with which ROS 1 sometimes begins it.
fn plain_frame(name: &str) -> String {
    name.strip_prefix('/').unwrap_or(name).to_owned()
}

#[cfg(test)]
mod tests;
