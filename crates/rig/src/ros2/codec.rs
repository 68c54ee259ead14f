//! Between what a controller is told and answers, and messages of ROS 2 as bytes.

use recording::{
    Extractor, FieldPath, Ros2Encoder, Ros2Source, Ros2Topic, TopicInfo, TypeDefinitions,
};
use testbench::controller::{Measurement, Outputs, PortField};
use trace::{Field, Trace};

/// The channel from whose rows messages are made.
const CHANNEL: &str = "/in";
/// Its first field, always true.
const SENT: &str = "sent now";

/// What a field of a message is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// When it was measured or sent.
    Time,
    /// A field of the sensor, or one of its numbers, `ranges[3]`.
    Field(String),
    Number(f64),
    Bool(bool),
    Text(String),
    List(Vec<Source>),
}

/// Makes the messages of a topic to the node.
#[derive(Clone, Debug)]
pub struct Outbound {
    topic: Ros2Topic,
    layout: Trace,
    fields: Vec<PortField>,
    missing: Option<f64>,
}

impl Outbound {
    /// The encoder for a sensor with these fields, or for a message without any.
    pub fn new(
        name: &str,
        type_name: &str,
        fields: &[PortField],
        sources: &[(String, Source)],
        missing: Option<f64>,
    ) -> Result<Self, String> {
        let failed = |reason: String| format!("{name}: {reason}");
        let mut layout = Trace::new();
        let channel = fields.iter().flat_map(numbers_of).map(|(name, field)| {
            // The two truth values that sensors have.
            match field.name.as_str() {
                "seen" | "touching" => Field::bool(name),
                _ => Field::number(name, &field.unit),
            }
        });
        // A channel has a field, also where a message has no values.
        let channel = std::iter::once(Field::bool(SENT)).chain(channel);
        layout
            .add_channel(CHANNEL, channel.collect())
            .map_err(|error| failed(error.to_string()))?;
        let mut given = Vec::new();
        for (path, source) in sources {
            spread(path, source, fields, &mut given).map_err(failed)?;
        }
        let topic = Ros2Topic {
            name: name.to_owned(),
            type_name: type_name.to_owned(),
            rows_of: CHANNEL.to_owned(),
            fields: given,
        };
        Ros2Encoder::new(&layout, &topic).map_err(|error| failed(error.to_string()))?;
        Ok(Self {
            topic,
            layout,
            fields: fields.to_vec(),
            missing,
        })
    }

    /// The message of a measurement, or of something sent then, which has no values.
    pub fn encode(&self, measurement: &Measurement) -> Result<Vec<u8>, String> {
        let mut trace = self.layout.clone();
        let mut row = vec![1.0];
        for field in &self.fields {
            let numbers = measurement.values.get(&field.name);
            let numbers = numbers.map_or(&[][..], Vec::as_slice);
            let known = (0..field.length).map(|place| numbers.get(place).copied());
            row.extend(known.map(|number| number.unwrap_or(f64::NAN)));
        }
        let failed = |reason: String| format!("{}: {reason}", self.topic.name);
        trace.channels[0]
            .push(measurement.time_secs, &row)
            .map_err(|error| failed(error.to_string()))?;
        let topic = self.with_missing(&row);
        let encoder = Ros2Encoder::new(&trace, &topic).map_err(|e| failed(e.to_string()))?;
        let mut message = Vec::new();
        match encoder.encode(&trace, 0, nanos(measurement.time_secs), &mut message) {
            Ok(true) => Ok(message),
            Ok(false) => Err(failed(
                "a number that could not be measured does not fit its field; give `missing` or another field"
                    .into(),
            )),
            Err(error) => Err(failed(error.to_string())),
        }
    }
}

impl Outbound {
    /// The topic with the substitute for each number that is missing in `row`. A trace cannot hold
    /// it, since it may be infinite.
    fn with_missing(&self, row: &[f64]) -> Ros2Topic {
        let mut topic = self.topic.clone();
        let Some(missing) = self.missing else {
            return topic;
        };
        for (_, source) in &mut topic.fields {
            let Ros2Source::Signal(name) = source else {
                continue;
            };
            let number = self.layout.signal(name).and_then(|it| row.get(it.field));
            if number.is_some_and(|number| number.is_nan()) {
                *source = Ros2Source::Number(missing);
            }
        }
        topic
    }
}

/// The numbers of a field with their names in the layout.
fn numbers_of(field: &PortField) -> impl Iterator<Item = (String, &PortField)> {
    (0..field.length).map(move |place| (signal_of(field, place), field))
}

fn signal_of(field: &PortField, place: usize) -> String {
    match field.length {
        1 => field.name.clone(),
        _ => format!("{}.{place}", field.name),
    }
}

/// Gives `path`, or each of its elements, what `source` says.
fn spread(
    path: &str,
    source: &Source,
    fields: &[PortField],
    given: &mut Vec<(String, Ros2Source)>,
) -> Result<(), String> {
    let fixed = match source {
        Source::Time => Ros2Source::Stamp,
        Source::Number(number) => Ros2Source::Number(*number),
        Source::Bool(value) => Ros2Source::Bool(*value),
        Source::Text(text) => Ros2Source::Text(text.clone()),
        Source::List(list) => {
            for (place, element) in list.iter().enumerate() {
                spread(&format!("{path}[{place}]"), element, fields, given)?;
            }
            return Ok(());
        }
        Source::Field(text) => return spread_field(path, text, fields, given),
    };
    given.push((path.to_owned(), fixed));
    Ok(())
}

fn spread_field(
    path: &str,
    text: &str,
    fields: &[PortField],
    given: &mut Vec<(String, Ros2Source)>,
) -> Result<(), String> {
    let (name, place) = match text.strip_suffix(']').and_then(|text| text.split_once('[')) {
        Some((name, place)) => (name, place.parse::<usize>().ok()),
        None => (text, None),
    };
    let unknown = || {
        let known = fields.iter().map(|field| match field.length {
            1 => field.name.clone(),
            length => format!("{} ({length} numbers)", field.name),
        });
        let known: Vec<String> = known.collect();
        format!(
            "`{path}` is given `{text}`, which is not a field of the sensor; it has {}; a fixed text is written {{ text = \"{text}\" }}",
            if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            }
        )
    };
    let field = fields.iter().find(|field| field.name == name);
    let field = field.ok_or_else(unknown)?;
    let signal =
        |place: usize| Ros2Source::Signal(format!("{CHANNEL}.{}", signal_of(field, place)));
    match place {
        Some(place) if place < field.length => given.push((path.to_owned(), signal(place))),
        None if text.contains('[') => return Err(unknown()),
        Some(_) => return Err(unknown()),
        None if field.length == 1 => given.push((path.to_owned(), signal(0))),
        None => {
            given
                .extend((0..field.length).map(|place| (format!("{path}[{place}]"), signal(place))));
        }
    }
    Ok(())
}

/// Where a value of a message from the node goes.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    Command {
        actuator: String,
        field: String,
    },
    Report {
        name: String,
        /// For texts, what they may be.
        names: Option<Vec<String>>,
    },
    /// A message that is sent while the value is true.
    Message(String),
    Finished,
}

impl Target {
    pub fn command(actuator: &str, field: &str) -> Self {
        Self::Command {
            actuator: actuator.to_owned(),
            field: field.to_owned(),
        }
    }
}

/// Reads the messages of a topic from the node.
#[derive(Clone, Debug)]
pub struct Inbound {
    name: String,
    extractor: Extractor,
    targets: Vec<(String, Target)>,
    is_stamped: bool,
}

impl Inbound {
    pub fn new(
        name: &str,
        type_name: &str,
        stamp: Option<&str>,
        targets: Vec<(String, Target)>,
        types: &TypeDefinitions,
    ) -> Result<Self, String> {
        let failed = |reason: String| format!("{name}: {reason}");
        let mut paths: Vec<String> = targets.iter().map(|(path, _)| path.clone()).collect();
        if let Some(stamp) = stamp {
            paths.extend([format!("{stamp}.sec"), format!("{stamp}.nanosec")]);
        }
        let paths: Result<Vec<FieldPath>, _> =
            paths.iter().map(|it| FieldPath::parse(it)).collect();
        let paths = paths.map_err(|error| failed(error.to_string()))?;
        let info = info_of(name, type_name, types);
        let extractor = Extractor::new(&info, &paths);
        let mut extractor = extractor.map_err(|error| failed(error.to_string()))?;
        for (place, (_, target)) in targets.iter().enumerate() {
            if let Target::Report {
                names: Some(names), ..
            } = target
            {
                extractor.set_names(place, names.clone());
            }
        }
        Ok(Self {
            name: name.to_owned(),
            extractor,
            targets,
            is_stamped: stamp.is_some(),
        })
    }

    /// Adds what a message says to `outputs`, and gives the time in nanoseconds that it repeats, if
    /// it repeats one.
    pub fn decode(&mut self, data: &[u8], outputs: &mut Outputs) -> Result<Option<i64>, String> {
        let mut values = vec![f64::NAN; self.extractor.paths().len()];
        let failed = |reason: String| format!("{}: {reason}", self.name);
        self.extractor
            .extract(data, &mut values)
            .map_err(|error| failed(error.to_string()))?;
        for ((path, target), value) in self.targets.iter().zip(&values) {
            if value.is_nan() {
                let reason = format!(
                    "a message has nothing at `{path}` that could be taken: it is absent, NaN, or no name of those declared"
                );
                return Err(failed(reason));
            }
            take(target, *value, outputs);
        }
        Ok(self.is_stamped.then(|| {
            let [secs, nanos] = [0, 1].map(|place| values[self.targets.len() + place]);
            // Whole numbers of 32 bits.
            secs as i64 * 1_000_000_000 + nanos as i64
        }))
    }
}

fn take(target: &Target, value: f64, outputs: &mut Outputs) {
    match target {
        Target::Command { actuator, field } => {
            let fields = outputs.commands.entry(actuator.clone()).or_default();
            fields.insert(field.clone(), value);
        }
        Target::Report { name, .. } => drop(outputs.reports.insert(name.clone(), value)),
        Target::Message(name) if value != 0.0 => outputs.messages.push(name.clone()),
        Target::Message(_) => {}
        Target::Finished => outputs.finished = value != 0.0,
    }
}

fn info_of(name: &str, type_name: &str, types: &TypeDefinitions) -> TopicInfo {
    let topic = live::Topic {
        id: 0,
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        encoding: "cdr".to_owned(),
        schema: None,
        qos: None,
        type_hash: None,
        origin: live::Origin::Outside,
        numbered: true,
    };
    topic.info(&|type_name| {
        types.text(type_name).map(|text| live::SchemaText {
            encoding: "ros2msg".into(),
            data: text.into_bytes(),
        })
    })
}

/// Seconds of simulated time in nanoseconds.
pub fn nanos(secs: f64) -> i64 {
    // A conversion from a double saturates.
    (secs * 1e9).round() as i64
}

/// A message with only a time.
pub fn at(time_secs: f64) -> Measurement {
    Measurement {
        time_secs,
        ..Measurement::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(name: &str, unit: &str, length: usize) -> PortField {
        PortField {
            name: name.into(),
            unit: unit.into(),
            length,
        }
    }

    fn types() -> TypeDefinitions {
        TypeDefinitions::new(&[]).expect("the known types")
    }

    fn report(path: &str) -> (String, Target) {
        let target = Target::Report {
            name: path.to_owned(),
            names: None,
        };
        (path.to_owned(), target)
    }

    #[test]
    fn a_measurement_is_read_back_from_its_message_with_its_time() {
        let fields = [field("ranges", "m", 3), field("seen", "1", 1)];
        let sources = [
            ("header.stamp".to_owned(), Source::Time),
            ("header.frame_id".to_owned(), Source::Text("lidar".into())),
            ("range_max".to_owned(), Source::Number(8.0)),
            ("ranges".to_owned(), Source::Field("ranges".into())),
            (
                "intensities[1]".to_owned(),
                Source::Field("ranges[0]".into()),
            ),
        ];
        let scan = "sensor_msgs/msg/LaserScan";
        let missing = Some(f64::INFINITY);
        let outbound = Outbound::new("/scan", scan, &fields, &sources, missing).expect("it fits");
        let mut measurement = at(1.25);
        let ranges = vec![1.5, f64::NAN, 0.1];
        measurement.values.insert("ranges".into(), ranges);
        measurement.values.insert("seen".into(), vec![1.0]);
        let message = outbound.encode(&measurement).expect("a message");
        let paths = [
            "range_max",
            "ranges[0]",
            "ranges[1]",
            "ranges[2]",
            "intensities[1]",
        ];
        let targets = paths.map(report).to_vec();
        let stamp = Some("header.stamp");
        let mut inbound = Inbound::new("/scan", scan, stamp, targets, &types()).expect("it fits");
        let mut outputs = Outputs::default();
        let stamp = inbound.decode(&message, &mut outputs).expect("read");
        assert_eq!(stamp, Some(1_250_000_000));
        let found = paths.map(|path| outputs.reports[path]);
        assert_eq!(found, [8.0, 1.5, f64::INFINITY, f64::from(0.1_f32), 1.5]);
    }

    #[test]
    fn what_does_not_fit_a_message_is_said_with_what_would() {
        let made = |path: &str, source: Source| {
            let fields = [field("x", "m", 1), field("ranges", "m", 3)];
            let sources = [(path.to_owned(), source)];
            let name = "std_msgs/msg/Float64";
            let made = Outbound::new("/x", name, &fields, &sources, None);
            made.map(|_| ()).expect_err(path)
        };
        let unknown = made("data", Source::Field("y".into()));
        assert!(
            unknown.contains("it has x, ranges (3 numbers)"),
            "{unknown}"
        );
        assert!(made("data", Source::Field("ranges[3]".into())).contains("ranges[3]"));
        assert!(made("date", Source::Number(1.0)).contains("date"));
        assert!(made("data", Source::Field("ranges".into())).contains("data[0]"));
        let made = Outbound::new("/x", "std_msgs/msg/Nothing", &[], &[], None);
        assert!(made.expect_err("no such type").contains("Nothing"));
    }

    #[test]
    fn answers_become_commands_messages_and_reports() {
        let state = Target::Report {
            name: "state".into(),
            names: Some(vec!["wait".into(), "drive".into()]),
        };
        let text = "std_msgs/msg/String";
        let targets = vec![("data".to_owned(), state)];
        let mut inbound = Inbound::new("/state", text, None, targets, &types()).expect("fits");
        let said = |text: &str| {
            let mut data = vec![0, 1, 0, 0];
            data.extend((text.len() as u32 + 1).to_le_bytes());
            data.extend(text.as_bytes());
            data.push(0);
            data
        };
        let mut outputs = Outputs::default();
        assert_eq!(inbound.decode(&said("drive"), &mut outputs), Ok(None));
        assert_eq!(outputs.reports["state"], 1.0);
        let unknown = inbound.decode(&said("fly"), &mut outputs);
        assert!(unknown.expect_err("no such name").contains("`data`"));
        assert!(inbound.decode(&[0, 1], &mut outputs).is_err());
        let targets = vec![
            ("data[0]".to_owned(), Target::command("drive", "speed")),
            ("data[1]".to_owned(), Target::Message("arrived".into())),
            ("data[2]".to_owned(), Target::Finished),
        ];
        let numbers = "std_msgs/msg/Float64MultiArray";
        let mut inbound = Inbound::new("/all", numbers, None, targets, &types()).expect("fits");
        let list = Source::List([0.5, 1.0, 0.0].map(Source::Number).to_vec());
        let sources = [("data".to_owned(), list)];
        let outbound = Outbound::new("/all", numbers, &[], &sources, None).expect("fits");
        let mut outputs = Outputs::default();
        let message = outbound.encode(&at(0.0)).expect("a message");
        inbound.decode(&message, &mut outputs).expect("read");
        assert_eq!(outputs.commands["drive"]["speed"], 0.5);
        assert_eq!(
            (outputs.messages, outputs.finished),
            (vec!["arrived".into()], false)
        );
    }
}
