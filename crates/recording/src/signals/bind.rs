//! From the signals that are wanted to what has to be read of which topic.

mod error;

use std::collections::{BTreeMap, BTreeSet};

use trace::units::Unit;
use trace::{Channel, Field, FieldKind, SignalIndex, Trace};

pub use self::error::BindError;
use super::plan::{FrameQuantity, FrameQuantityKind, Output, SourcePlan, Treatment};
use crate::csv_rows::columns::UNIT_OF;
use crate::reader::TopicInfo;
use crate::topic_map::{Interpolation, MappedSignal, SignalSource, TopicMap};

/// One column of a row that is made of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ColumnPlan {
    /// A number, scaled.
    Number {
        path: String,
        scale: f64,
        offset: f64,
    },
    /// A truth value.
    Bool { path: String },
    /// One of these names, or its number.
    Name { path: String, names: Vec<String> },
    /// The norm of numbers, scaled.
    Norm {
        paths: Vec<String>,
        scale: f64,
        offset: f64,
    },
    /// The number of a frame: this one, or that which the message's header names.
    Frame { name: Option<String> },
}

impl ColumnPlan {
    /// The paths of a message that it reads.
    pub(super) fn paths(&self) -> impl Iterator<Item = &str> {
        let paths = match self {
            ColumnPlan::Number { path, .. }
            | ColumnPlan::Bool { path }
            | ColumnPlan::Name { path, .. } => std::slice::from_ref(path),
            ColumnPlan::Norm { paths, .. } => paths.as_slice(),
            ColumnPlan::Frame { .. } => &[],
        };
        paths.iter().map(String::as_str)
    }
}

/// A row that is made of each message of a topic.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RowPlan {
    /// The source whose row it is.
    pub source: usize,
    /// What the columns have in common, if they need no transform: the elements that they are picked
    /// from, and how long their values count. So a signal does not depend on which others are wanted.
    pub group: String,
    pub columns: Vec<ColumnPlan>,
    /// For each column, the entry that asked for it, for errors.
    pub asked_by: Vec<(String, usize)>,
}

/// What is made of each message of a topic.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TopicPlan {
    pub name: String,
    pub rows: Vec<RowPlan>,
}

/// What a stream has to do.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Binding {
    /// The signals, as channels without rows.
    pub layout: Trace,
    pub sources: Vec<SourcePlan>,
    pub topics: Vec<TopicPlan>,
    /// Signals whose topics the recording does not have.
    pub absent: Vec<BindError>,
}

/// What kind of values stand at a path of a topic.
pub(super) type KindOf<'a> = dyn Fn(&TopicInfo, &str) -> Result<FieldKind, String> + 'a;

/// Finds the signals `wanted`, by the map or as they are written, among `topics` of a recording with this metadata.
pub(super) fn bind(
    (topics, metadata): (&[TopicInfo], &BTreeMap<String, String>),
    map: &TopicMap,
    wanted: &[String],
    kind_of: &KindOf<'_>,
) -> Result<Binding, Vec<BindError>> {
    let mut binder = Binder {
        topics,
        metadata,
        kind_of,
        errors: Vec::new(),
        done: BTreeSet::new(),
        binding: Binding {
            layout: Trace::new(),
            sources: Vec::new(),
            topics: Vec::new(),
            absent: Vec::new(),
        },
    };
    for name in wanted {
        match map.find(name) {
            Some((entry, _)) => binder.entry(entry),
            None => binder.identity(name),
        }
    }
    if binder.errors.is_empty() {
        Ok(binder.binding)
    } else {
        Err(binder.errors)
    }
}

struct Binder<'a> {
    topics: &'a [TopicInfo],
    metadata: &'a BTreeMap<String, String>,
    kind_of: &'a KindOf<'a>,
    errors: Vec<BindError>,
    /// The entries and signals that were bound.
    done: BTreeSet<String>,
    binding: Binding,
}

impl Binder<'_> {
    fn error(&mut self, signal: &str, line: usize, message: impl Into<String>) {
        self.errors.push(BindError {
            signal: signal.to_owned(),
            line,
            message: message.into(),
            is_lacking: false,
        });
    }

    /// That the recording has no such signal.
    fn lacks(&mut self, signal: &str, message: String) {
        self.errors.push(BindError {
            signal: signal.to_owned(),
            line: 0,
            message,
            is_lacking: true,
        });
    }

    /// The first topic that has a field of the last part of a name, as a question.
    fn meant(&self, name: &str) -> String {
        let name = name.trim_start_matches('/');
        let behind = |separator: char| name.split_once(separator).map(|(_, path)| path);
        let paths = [Some(name), behind('/'), behind('.')];
        let found = paths.into_iter().flatten().find_map(|path| {
            let has = |info: &&TopicInfo| (self.kind_of)(info, path).is_ok();
            Some((self.topics.iter().find(has)?, path))
        });
        found.map_or_else(String::new, |(topic, path)| {
            format!(" (did you mean {}.{path}?)", topic.name)
        })
    }

    /// A signal without an entry: the longest topic with which its name begins, and a path.
    fn identity(&mut self, name: &str) {
        if !self.done.insert(name.to_owned()) {
            return;
        }
        let Some((topic, path)) = split_at_topic(self.topics, name) else {
            let message = format!(
                "neither the topic map nor the recording has it; {}{}",
                self.there(),
                self.meant(name)
            );
            return self.lacks(name, message);
        };
        let infos: Vec<&TopicInfo> = self
            .topics
            .iter()
            .filter(|info| info.name == topic)
            .collect();
        let kind = match infos.first().map(|info| (self.kind_of)(info, path)) {
            Some(Ok(kind)) => kind,
            Some(Err(problem)) => return self.lacks(name, problem),
            None => return,
        };
        if let FieldKind::Enumeration(_) = kind {
            let message = "it is text; give it an entry in the topic map that lists its values";
            return self.error(name, 0, message);
        }
        let unit = self.unit(infos.first().copied(), path);
        let (topic, path) = (topic.to_owned(), path.to_owned());
        let slash = if topic.starts_with('/') { "" } else { "/" };
        let channel = format!("{slash}{topic}");
        let field = Field {
            name: path.clone(),
            unit,
            frame: None,
            kind: kind.clone(),
        };
        let column = match kind {
            FieldKind::Bool => ColumnPlan::Bool { path },
            _ => ColumnPlan::Number {
                path,
                scale: 1.0,
                offset: 0.0,
            },
        };
        let entry = MappedSignal::new(
            name,
            SignalSource::Value {
                from: name.to_owned(),
            },
        );
        let signal = self.add_field(&channel, field);
        self.plain(&topic, &entry, vec![column], &[signal]);
    }

    /// The unit of a field: as the header of its column says, if that is one, or as its message's type has it.
    fn unit(&self, info: Option<&TopicInfo>, path: &str) -> String {
        let Some(info) = info else {
            return String::new();
        };
        let stated = self.metadata.get(&format!("{UNIT_OF}{}.{path}", info.name));
        match stated.filter(|unit| unit.parse::<Unit>().is_ok()) {
            Some(unit) => unit.clone(),
            None => crate::inspect::usual_unit(info, path).to_owned(),
        }
    }

    /// A signal with an entry in the map, with all of its parts.
    fn entry(&mut self, entry: &MappedSignal) {
        if !self.done.insert(entry.name.clone()) {
            return;
        }
        match &entry.source {
            SignalSource::Value { from } => self.value(entry, from),
            SignalSource::Norm { of } => self.norm(entry, of),
            SignalSource::Point { of, in_frame } => self.point(entry, of, in_frame.as_ref(), true),
            SignalSource::Vector { of, in_frame } => {
                self.point(entry, of, in_frame.as_ref(), false)
            }
            SignalSource::PositionOf { frame, in_frame } => {
                self.quantity(entry, in_frame, frame, FrameQuantityKind::Position);
            }
            SignalSource::OrientationOf { frame, in_frame } => {
                self.quantity(entry, in_frame, frame, FrameQuantityKind::Orientation);
            }
            SignalSource::DistanceBetween {
                frames: [one, other],
            } => {
                self.quantity(entry, one, other, FrameQuantityKind::Distance);
            }
            SignalSource::SpeedOf { frame, in_frame } => {
                self.quantity(entry, in_frame, frame, FrameQuantityKind::Speed);
            }
        }
    }

    fn value(&mut self, entry: &MappedSignal, from: &str) {
        let (scale, offset) = (entry.scale, entry.offset);
        let signals = self.add_fields(entry);
        let Some((topic, path)) = self.find(entry, from) else {
            return;
        };
        let column = match &entry.kind {
            FieldKind::Number => ColumnPlan::Number {
                path,
                scale,
                offset,
            },
            FieldKind::Bool => ColumnPlan::Bool { path },
            FieldKind::Enumeration(names) => ColumnPlan::Name {
                path,
                names: names.clone(),
            },
        };
        self.plain(&topic, entry, vec![column], &signals);
    }

    fn norm(&mut self, entry: &MappedSignal, of: &[String]) {
        let (scale, offset) = (entry.scale, entry.offset);
        let signals = self.add_fields(entry);
        let mut found: Vec<(String, String)> = Vec::with_capacity(of.len());
        for path in of {
            match self.find(entry, path) {
                Some(place) => found.push(place),
                None => return,
            }
        }
        let Some(topic) = found.first().map(|(topic, _)| topic.clone()) else {
            return;
        };
        if found.iter().any(|(other, _)| *other != topic) {
            let message = "the numbers of a norm have to be of one topic; make signals of them, \
                           and use norm(...) in the requirement";
            return self.error(&entry.name, entry.line, message);
        }
        let paths = found.into_iter().map(|(_, path)| path).collect();
        let column = ColumnPlan::Norm {
            paths,
            scale,
            offset,
        };
        self.plain(&topic, entry, vec![column], &signals);
    }

    fn point(&mut self, entry: &MappedSignal, of: &str, in_frame: Option<&String>, is_point: bool) {
        let signals = self.add_fields(entry);
        let Some((topic, path)) = self.find(entry, &format!("{of}.x")) else {
            return;
        };
        let base = path.strip_suffix(".x").unwrap_or("");
        let part = |axis: &str| {
            let path = if base.is_empty() {
                axis.to_owned()
            } else {
                format!("{base}.{axis}")
            };
            ColumnPlan::Number {
                path,
                scale: entry.scale,
                offset: entry.offset,
            }
        };
        let mut columns: Vec<ColumnPlan> = ["x", "y", "z"].map(part).into();
        let Some(in_frame) = in_frame.filter(|_| entry.needs_frames()) else {
            return self.plain(&topic, entry, columns, &signals);
        };
        let Some(metres_per_unit) = self.metres_per_unit(entry, is_point) else {
            return;
        };
        columns.push(ColumnPlan::Frame {
            name: entry.frame.clone(),
        });
        let treatment = Treatment::Transform {
            in_frame: in_frame.clone(),
            is_point,
            metres_per_unit,
        };
        let source = self.add_source(&topic, columns.len(), treatment, entry, &signals);
        let row = RowPlan {
            source,
            group: String::new(),
            asked_by: vec![(entry.name.clone(), entry.line); columns.len()],
            columns,
        };
        self.topic(&topic).rows.push(row);
    }

    /// How many metres the unit of a point is, which a translation has to be divided by.
    fn metres_per_unit(&mut self, entry: &MappedSignal, is_point: bool) -> Option<f64> {
        let unit = match &entry.unit {
            Some(unit) if is_point => unit,
            _ => return Some(1.0),
        };
        let metre = trace::units::Unit::coherent(trace::units::Dimension::LENGTH);
        let parsed = unit.parse::<trace::units::Unit>().ok();
        let conversion = parsed.and_then(|unit| unit.conversion_to(&metre));
        if conversion.is_none() {
            let message = format!(
                "{unit} is not a unit of length, so the point cannot be shifted into another frame; \
                 give the unit of its coordinates"
            );
            self.error(&entry.name, entry.line, message);
        }
        conversion.map(|conversion| conversion.apply(1.0))
    }

    fn quantity(
        &mut self,
        entry: &MappedSignal,
        target: &str,
        source: &str,
        kind: FrameQuantityKind,
    ) {
        let signals = self.add_fields(entry);
        if !self
            .topics
            .iter()
            .any(|info| info.name == "/tf" || info.name == "/tf_static")
        {
            let message = format!(
                "the recording has neither /tf nor /tf_static; {}",
                self.there()
            );
            let error = BindError {
                signal: entry.name.clone(),
                line: entry.line,
                message,
                is_lacking: true,
            };
            self.binding.absent.push(error);
        }
        let quantity = FrameQuantity {
            target: target.to_owned(),
            source: source.to_owned(),
            kind,
        };
        self.add_source(&entry.name, 0, Treatment::Frames(quantity), entry, &signals);
    }

    /// The topic and path that `from` means; if there is none, the signal is absent.
    fn find(&mut self, entry: &MappedSignal, from: &str) -> Option<(String, String)> {
        if let Some((topic, path)) = split_at_topic(self.topics, from) {
            return Some((topic.to_owned(), path.to_owned()));
        }
        let message = format!("the recording has no topic for {from}; {}", self.there());
        self.binding.absent.push(BindError {
            signal: entry.name.clone(),
            line: entry.line,
            message,
            is_lacking: true,
        });
        // Topics of an unfinished recording may still come.
        MappedSignal::split(from).map(|(topic, path)| (topic.to_owned(), path.to_owned()))
    }

    /// What topics there are, in words.
    fn there(&self) -> String {
        const SHOWN: usize = 12;
        let names: BTreeSet<&str> = self.topics.iter().map(|info| info.name.as_str()).collect();
        let shown: Vec<&str> = names.iter().take(SHOWN).copied().collect();
        let more = names.len().saturating_sub(SHOWN);
        match (shown.is_empty(), more) {
            (true, _) => "it has no topics".to_owned(),
            (false, 0) => format!("it has {}", shown.join(", ")),
            (false, more) => format!("it has {} and {more} more", shown.join(", ")),
        }
    }

    fn add_fields(&mut self, entry: &MappedSignal) -> Vec<SignalIndex> {
        let names = entry.part_names();
        let topics = names.iter().filter_map(|name| MappedSignal::split(name));
        let topics: Vec<String> = topics.map(|(topic, _)| topic.to_owned()).collect();
        let fields = topics.into_iter().zip(entry.fields());
        fields
            .map(|(topic, field)| self.add_field(&topic, field))
            .collect()
    }

    fn add_field(&mut self, topic: &str, field: Field) -> SignalIndex {
        let channels = &mut self.binding.layout.channels;
        let found = channels.iter().position(|channel| channel.topic == topic);
        let channel = found.unwrap_or_else(|| {
            channels.push(Channel::new(topic, Vec::new()));
            channels.len() - 1
        });
        let fields = &mut channels[channel].fields;
        fields.push(field);
        SignalIndex {
            channel,
            field: fields.len() - 1,
        }
    }

    fn add_source(
        &mut self,
        name: &str,
        width: usize,
        treatment: Treatment,
        entry: &MappedSignal,
        signals: &[SignalIndex],
    ) -> usize {
        let outputs = signals.iter().enumerate();
        let outputs = outputs
            .map(|(column, signal)| output(entry, *signal, column))
            .collect();
        self.binding.sources.push(SourcePlan {
            name: name.to_owned(),
            width,
            treatment,
            outputs,
        });
        self.binding.sources.len() - 1
    }

    /// Adds columns that need no transform to the row that such columns of a topic share.
    fn plain(
        &mut self,
        topic: &str,
        entry: &MappedSignal,
        columns: Vec<ColumnPlan>,
        signals: &[SignalIndex],
    ) {
        let sources = &self.binding.sources;
        let group = group_of(entry, &columns);
        let is_plain =
            |row: &RowPlan| sources[row.source].treatment == Treatment::Plain && row.group == group;
        let rows = self.binding.topics.iter().filter(|plan| plan.name == topic);
        let known = rows
            .flat_map(|plan| &plan.rows)
            .find(|row| is_plain(row))
            .map(|row| row.source);
        let source = known.unwrap_or_else(|| {
            let source = self.add_source(topic, 0, Treatment::Plain, entry, &[]);
            let row = RowPlan {
                source,
                group,
                columns: Vec::new(),
                asked_by: Vec::new(),
            };
            self.topic(topic).rows.push(row);
            source
        });
        let plan = &mut self.binding.sources[source];
        for (column, signal) in signals.iter().enumerate() {
            plan.outputs
                .push(output(entry, *signal, plan.width + column));
        }
        plan.width += columns.len();
        let rows = self.topic(topic).rows.iter_mut();
        if let Some(row) = rows.into_iter().find(|row| row.source == source) {
            let asked_by = (entry.name.clone(), entry.line);
            row.asked_by
                .resize(row.columns.len() + columns.len(), asked_by);
            row.columns.extend(columns);
        }
    }

    fn topic(&mut self, name: &str) -> &mut TopicPlan {
        let topics = &mut self.binding.topics;
        let found = topics.iter().position(|plan| plan.name == name);
        let index = found.unwrap_or_else(|| {
            topics.push(TopicPlan {
                name: name.to_owned(),
                rows: Vec::new(),
            });
            topics.len() - 1
        });
        &mut topics[index]
    }
}

/// What columns must have in common with others to share a row with them.
fn group_of(entry: &MappedSignal, columns: &[ColumnPlan]) -> String {
    let paths = columns.iter().flat_map(|column| match column {
        ColumnPlan::Number { path, .. }
        | ColumnPlan::Bool { path }
        | ColumnPlan::Name { path, .. } => std::slice::from_ref(path),
        ColumnPlan::Norm { paths, .. } => &paths[..],
        ColumnPlan::Frame { .. } => &[],
    });
    let keys = paths.flat_map(|path| path.split('[').skip(1));
    let keys = keys.filter_map(|part| Some(part.rsplit_once(']')?.0));
    let keys: BTreeSet<&str> = keys.filter(|key| key.contains('=')).collect();
    let (interpolation, staleness) = (entry.interpolation, entry.staleness_secs);
    format!("{keys:?} {interpolation:?} {staleness:?}")
}

fn output(entry: &MappedSignal, signal: SignalIndex, column: usize) -> Output {
    let staleness_nanos = entry.staleness_secs.map(crate::clock::nanos_of_secs);
    Output {
        signal,
        column,
        interpolation: match entry.interpolation {
            Interpolation::Linear => Interpolation::Linear,
            Interpolation::Hold => Interpolation::Hold,
        },
        staleness_nanos,
    }
}

/// The longest topic with which `name` begins, and the path behind the dot. Signals begin with a
/// slash; topics of other systems than ROS need not.
fn split_at_topic<'t, 'n>(topics: &'t [TopicInfo], name: &'n str) -> Option<(&'t str, &'n str)> {
    let fitting = topics.iter().filter_map(|info| {
        let topic = info.name.as_str();
        let plain = name.strip_prefix(topic);
        let behind = plain.or_else(|| name.strip_prefix('/')?.strip_prefix(topic));
        let path = behind?.strip_prefix('.')?;
        (!path.is_empty() && !topic.is_empty()).then_some((topic, path))
    });
    fitting.max_by_key(|(topic, _)| topic.len())
}
