//! The table `ros2` of a scene's controller, read and checked.

use super::codec::{Inbound, Outbound, Source, Target};
use recording::TypeDefinitions;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;
use testbench::controller::{Description, Field, PortField};
use testbench::scene::{ControllerData, SceneData};

/// The topic on which simulated time is told.
pub const CLOCK: &str = "/clock";

/// How a controller is joined over ROS 2.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Join {
    /// What recordings call the program.
    name: Option<String>,
    /// Which version of the program it is, for the evidence.
    #[serde(default = "first_version")]
    version: String,
    /// An episode has one of them to itself.
    #[serde(default = "domain_zero")]
    pub domains: Vec<u16>,
    /// Addresses of this machine whose networks are used; all if there is none.
    #[serde(default)]
    pub networks: Vec<IpAddr>,
    /// Without it, time waits for the answers.
    pub real_time_factor: Option<f64>,
    /// How long to wait before time begins, for a node that is silent while time stands still.
    pub settle_secs: Option<f64>,
    /// Topics to the node.
    #[serde(default)]
    pub publish: Vec<Publish>,
    /// Topics from it.
    #[serde(default)]
    pub subscribe: Vec<Subscribe>,
}

/// A topic to the node: the measurements of a sensor, or a message of the test.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Publish {
    /// The topic.
    pub topic: String,
    /// The type of its messages.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The sensor whose measurements are published, or
    pub sensor: Option<String>,
    /// the message of a test that is published.
    pub message: Option<String>,
    /// What stands for a number that could not be measured; NaN without it.
    pub missing: Option<f64>,
    /// Whether who joins later gets the last message (transient local durability).
    #[serde(default)]
    pub latched: bool,
    /// What goes into each field: a field of the measurement, or a value.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, schemars::Schema>")]
    fields: BTreeMap<String, toml::Value>,
}

/// A topic from the node.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Subscribe {
    /// The topic.
    pub topic: String,
    /// The type of its messages.
    #[serde(rename = "type")]
    pub type_name: String,
    /// A field of type Time that repeats the time of the tick that is answered.
    pub stamp: Option<String>,
    /// By command, written `ACTUATOR.COMMAND`, the field of the message that holds it.
    #[serde(default)]
    commands: BTreeMap<String, String>,
    /// What of the message is recorded, by name.
    #[serde(default)]
    reports: BTreeMap<String, Report>,
    /// By message of the test, the field that says whether it is sent.
    #[serde(default)]
    sends: BTreeMap<String, String>,
    /// The field that says that the program has finished.
    finished: Option<String>,
}

/// What the node tells of its inside.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct Report {
    /// The field of the message.
    field: String,
    /// Its unit.
    unit: Option<String>,
    /// The labels of its values, if it is an enumeration.
    names: Option<Vec<String>>,
}

fn first_version() -> String {
    "1".into()
}

fn domain_zero() -> Vec<u16> {
    vec![0]
}

impl Join {
    /// Reads the table of a controller, if it has one.
    pub fn of(controller: &ControllerData) -> Result<Option<Self>, String> {
        let Some(table) = &controller.ros2 else {
            return Ok(None);
        };
        let join: Self = table
            .clone()
            .try_into()
            .map_err(|error: toml::de::Error| error.message().to_owned())?;
        join.check(controller)?;
        Ok(Some(join))
    }

    fn check(&self, controller: &ControllerData) -> Result<(), String> {
        if self.domains.is_empty() || self.domains.iter().any(|domain| *domain > 232) {
            return Err("`domains` are numbers from 0 to 232, at least one".into());
        }
        if self.subscribe.is_empty() {
            return Err("`subscribe` is missing: name the topics on which the node answers".into());
        }
        for (key, number) in [
            ("real_time_factor", self.real_time_factor),
            ("settle_secs", self.settle_secs),
        ] {
            if number.is_some_and(|number| !(1e-3..=1e3).contains(&number)) {
                return Err(format!("`{key}` has to be between 0.001 and 1000"));
            }
        }
        if controller.command.is_empty() && !controller.settings.is_empty() {
            return Err(
                "its `settings` reach a node as parameters of a program that is started here; name it with `command`, or leave them out"
                    .into(),
            );
        }
        let mut seen = BTreeSet::from([CLOCK]);
        let published = self.publish.iter().map(|it| it.topic.as_str());
        for topic in published.chain(self.subscribe.iter().map(|it| it.topic.as_str())) {
            if !topic.starts_with('/') {
                return Err(format!("the topic `{topic}` has to begin with a slash"));
            }
            if !seen.insert(topic) {
                return Err(format!("{topic} is there twice"));
            }
        }
        for topic in &self.publish {
            if topic.sensor.is_some() == topic.message.is_some() {
                return Err(format!(
                    "{} needs either `sensor` or `message`",
                    topic.topic
                ));
            }
        }
        Ok(())
    }

    /// What a controller over this table says of itself.
    pub fn describe(&self, controller: &ControllerData) -> Description {
        let name = self.name.as_ref().unwrap_or(&controller.name);
        let mut description = Description::new(name, &self.version);
        let messages = self.publish.iter().filter_map(|it| it.message.clone());
        description.receives = messages.collect();
        for topic in &self.subscribe {
            description.sends.extend(topic.sends.keys().cloned());
            let reports = topic.reports.iter();
            description
                .reports
                .extend(reports.map(|(name, it)| match it {
                    Report {
                        names: Some(names), ..
                    } => Field::enumeration(name, names),
                    Report {
                        unit: Some(unit), ..
                    } => Field::number(name, unit),
                    _ => Field::bool(name),
                }));
        }
        // As a controller over the lock-step protocol describes itself: by name.
        description.reports.sort_by(|a, b| a.name.cmp(&b.name));
        description
    }

    /// The encoder of a topic to the node, of a sensor with these fields.
    pub fn outbound(topic: &Publish, fields: &[PortField]) -> Result<Outbound, String> {
        let mut sources = Vec::new();
        for (path, value) in &topic.fields {
            let source = source_of(value).ok_or_else(|| {
                format!(
                    "{}: `{path}` is given nothing that can be sent; give it a field of the sensor, \"time\", a number, a truth value, {{ text = \"…\" }} or a list of these",
                    topic.topic
                )
            })?;
            sources.push((path.clone(), source));
        }
        Outbound::new(
            &topic.topic,
            &topic.type_name,
            fields,
            &sources,
            topic.missing,
        )
    }

    /// The decoder of a topic from the node.
    pub fn inbound(topic: &Subscribe, types: &TypeDefinitions) -> Result<Inbound, String> {
        let mut targets = Vec::new();
        for (name, path) in &topic.commands {
            let Some((actuator, field)) = name.split_once('.') else {
                return Err(format!(
                    "{}: `{name}` has to be ACTUATOR.FIELD",
                    topic.topic
                ));
            };
            targets.push((path.clone(), Target::command(actuator, field)));
        }
        for (name, report) in &topic.reports {
            let target = Target::Report {
                name: name.clone(),
                names: report.names.clone(),
            };
            targets.push((report.field.clone(), target));
        }
        let sends = topic.sends.iter();
        targets.extend(sends.map(|(name, path)| (path.clone(), Target::Message(name.clone()))));
        let finished = topic.finished.iter();
        targets.extend(finished.map(|path| (path.clone(), Target::Finished)));
        let stamp = topic.stamp.as_deref();
        Inbound::new(&topic.topic, &topic.type_name, stamp, targets, types)
    }
}

fn source_of(value: &toml::Value) -> Option<Source> {
    Some(match value {
        toml::Value::String(text) if text == "time" => Source::Time,
        toml::Value::String(text) => Source::Field(text.clone()),
        toml::Value::Float(number) => Source::Number(*number),
        toml::Value::Integer(number) => Source::Number(f64::from(i32::try_from(*number).ok()?)),
        toml::Value::Boolean(value) => Source::Bool(*value),
        toml::Value::Table(table) if table.len() == 1 => {
            Source::Text(table.get("text")?.as_str()?.to_owned())
        }
        toml::Value::Array(list) => {
            Source::List(list.iter().map(source_of).collect::<Option<_>>()?)
        }
        _ => return None,
    })
}

/// As [`check`], of a scene's text; what else is wrong with it is found elsewhere.
pub fn check_text(scene: &str) -> Result<(), (String, String)> {
    let table = toml::from_str(scene).ok();
    match table.and_then(|table| SceneData::from_table(table).ok()) {
        Some(scene) => check(&scene),
        None => Ok(()),
    }
}

/// Checks the tables of all controllers of a scene before anything runs: types, fields, sensors,
/// actuators, domains.
///
/// # Errors
/// The key of the part that is wrong, and what is wrong.
fn check(scene: &SceneData) -> Result<(), (String, String)> {
    let mut domains = BTreeSet::new();
    for controller in &scene.controllers {
        let key = format!("controller.{}.ros2", controller.name);
        let place = |reason: String| (key.clone(), reason);
        let Some(join) = Join::of(controller).map_err(place)? else {
            continue;
        };
        let types = TypeDefinitions::new(&[]).map_err(|error| place(error.to_string()))?;
        if let Some(domain) = join.domains.iter().find(|domain| !domains.insert(**domain)) {
            return Err(place(format!(
                "the domain {domain} is that of another controller, or there twice; each controller has its own /clock and needs its own domain"
            )));
        }
        for (index, topic) in join.publish.iter().enumerate() {
            let place = |reason: String| (format!("{key}.publish.{index}"), reason);
            let fields = fields_of(topic, scene, controller).map_err(place)?;
            Join::outbound(topic, &fields).map_err(place)?;
        }
        for (index, topic) in join.subscribe.iter().enumerate() {
            let place = |reason: String| (format!("{key}.subscribe.{index}"), reason);
            Join::inbound(topic, &types).map_err(place)?;
            check_commands(topic, scene, controller).map_err(place)?;
        }
    }
    Ok(())
}

fn fields_of(
    topic: &Publish,
    scene: &SceneData,
    controller: &ControllerData,
) -> Result<Vec<PortField>, String> {
    let Some(name) = &topic.sensor else {
        return Ok(Vec::new());
    };
    let own = || {
        let sensors = scene.sensors.iter();
        sensors.filter(|sensor| sensor.robot == controller.robot)
    };
    match own().find(|sensor| sensor.name == *name) {
        Some(sensor) => Ok(sensor.fields()),
        None => {
            let known: Vec<&str> = own().map(|sensor| sensor.name.as_str()).collect();
            Err(format!(
                "{}: the robot has no sensor `{name}`; it has {}",
                topic.topic,
                known.join(", ")
            ))
        }
    }
}

fn check_commands(
    topic: &Subscribe,
    scene: &SceneData,
    controller: &ControllerData,
) -> Result<(), String> {
    let own = scene.actuators.iter();
    let own = own.filter(|actuator| actuator.robot == controller.robot);
    let known: Vec<String> = own
        .flat_map(|actuator| {
            let fields = actuator.fields().into_iter();
            fields.map(|field| format!("{}.{}", actuator.name, field.name))
        })
        .collect();
    match topic.commands.keys().find(|name| !known.contains(name)) {
        Some(name) => Err(format!(
            "{}: there is no command `{name}`; there is {}",
            topic.topic,
            known.join(", ")
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
        name = "s"
        simulation = { duration_secs = 1.0 }
        abstract_test = [{ name = "t", actions = [] }]
        robot = [{ name = "r", file = "r.urdf" }]
        actuator = [{ name = "drive", robot = "r", kind = "velocity", joint = "j", gain = 1.0, limit = 1.0 }]
        sensor = [{ name = "pose", robot = "r", kind = "pose", rate_hz = 10.0 }]
        [[controller]]
        name = "c"
        robot = "r"
        command = ["node"]
        period_secs = 0.1
        [controller.ros2]
        domains = [7]
        [[controller.ros2.publish]]
        topic = "/x"
        type = "std_msgs/msg/Float64"
        sensor = "pose"
        fields = { data = "x" }
        [[controller.ros2.publish]]
        topic = "/go"
        type = "std_msgs/msg/Bool"
        message = "go"
        fields = { data = true }
        [[controller.ros2.subscribe]]
        topic = "/v"
        type = "std_msgs/msg/Float64"
        commands = { "drive.velocity" = "data" }
        [[controller.ros2.subscribe]]
        topic = "/state"
        type = "std_msgs/msg/String"
        reports.state = { field = "data", names = ["a", "b"] }
        [[controller.ros2.subscribe]]
        topic = "/level"
        type = "std_msgs/msg/Float64"
        reports.level = { field = "data", unit = "1" }
    "#;

    #[test]
    fn a_table_says_what_its_controller_hears_sends_and_reports() {
        assert_eq!(check_text(SCENE), Ok(()));
        let table = toml::from_str(SCENE).expect("TOML");
        let scene = SceneData::from_table(table).expect("a scene");
        let join = Join::of(&scene.controllers[0]).expect("it is sound");
        let description = join.expect("a table").describe(&scene.controllers[0]);
        assert_eq!(
            (description.name.as_str(), description.version.as_str()),
            ("c", "1")
        );
        assert_eq!(description.receives, ["go"]);
        let reports: Vec<_> = description
            .reports
            .iter()
            .map(|it| it.name.as_str())
            .collect();
        assert_eq!(reports, ["level", "state"]);
    }

    #[test]
    fn what_is_wrong_in_a_table_is_said_with_its_place() {
        for (old, new, key, expected) in [
            ("[7]", "[]", "controller.c.ros2", "`domains`"),
            ("[7]", "[999]", "controller.c.ros2", "0 to 232"),
            ("domains", "domain", "controller.c.ros2", "domain"),
            (
                "\"pose\"\n        fields",
                "\"pos\"\n        fields",
                "publish.0",
                "it has pose",
            ),
            ("data = \"x\"", "data = \"xx\"", "publish.0", "turn_rate"),
            ("data = true", "date = true", "publish.1", "date"),
            (
                "message = \"go\"",
                "",
                "controller.c.ros2",
                "either `sensor` or `message`",
            ),
            (
                "drive.velocity",
                "drive.speed",
                "subscribe.0",
                "there is drive.velocity",
            ),
            (
                "drive.velocity",
                "velocity",
                "subscribe.0",
                "ACTUATOR.FIELD",
            ),
            (
                "std_msgs/msg/String",
                "std_msgs/msg/Sting",
                "subscribe.1",
                "Sting",
            ),
            ("\"/v\"", "\"/x\"", "controller.c.ros2", "there twice"),
            ("\"/v\"", "\"v\"", "controller.c.ros2", "slash"),
            (
                "command = [\"node\"]",
                "settings = { a = 1 }",
                "controller.c.ros2",
                "`command`",
            ),
        ] {
            let scene = SCENE.replacen(old, new, 1);
            assert_ne!(scene, SCENE, "{old}");
            let (place, reason) = check_text(&scene).expect_err(new);
            assert!(place.ends_with(key), "{new}: {place}");
            assert!(reason.contains(expected), "{new}: {reason}");
        }
    }
}
