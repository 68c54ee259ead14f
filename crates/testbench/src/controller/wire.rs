//! The messages of the lock-step protocol as JSON; see [`super::protocol`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use trace::Field;

use super::{Description, Inputs, Message, Outputs, Port, Setup};

/// The protocol's version. A controller that speaks another is refused.
pub(super) const VERSION: u32 = 1;

/// From the bench to the controller.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Question<'a> {
    Hello {
        protocol: u32,
    },
    Setup {
        seed: u64,
        period_secs: f64,
        sensors: BTreeMap<&'a str, PortForm<'a>>,
        actuators: BTreeMap<&'a str, PortForm<'a>>,
        settings: &'a serde_json::Map<String, serde_json::Value>,
    },
    Tick {
        time_secs: f64,
        sensors: BTreeMap<&'a str, MeasurementForm<'a>>,
        messages: Vec<MessageForm<'a>>,
    },
    End {},
}

#[derive(Debug, Serialize)]
pub(super) struct PortForm<'a> {
    kind: &'a str,
    fields: BTreeMap<&'a str, PortFieldForm<'a>>,
    facts: &'a BTreeMap<String, f64>,
}

#[derive(Debug, Serialize)]
struct PortFieldForm<'a> {
    unit: &'a str,
    length: usize,
}

/// NaN becomes `null`, as `serde_json` writes it.
#[derive(Debug, Serialize)]
pub(super) struct MeasurementForm<'a> {
    time_secs: f64,
    values: &'a BTreeMap<String, Vec<f64>>,
}

#[derive(Debug, Serialize)]
pub(super) struct MessageForm<'a> {
    name: &'a str,
    time_secs: f64,
}

/// From the controller to the bench.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Answer {
    Hello {
        protocol: u32,
        name: String,
        version: String,
        #[serde(default)]
        sends: Vec<String>,
        #[serde(default)]
        receives: Vec<String>,
        #[serde(default)]
        reports: BTreeMap<String, ReportForm>,
    },
    Ready {},
    Commands {
        #[serde(default)]
        commands: BTreeMap<String, BTreeMap<String, f64>>,
        #[serde(default)]
        messages: Vec<String>,
        #[serde(default)]
        reports: BTreeMap<String, ReportValue>,
        #[serde(default)]
        finished: bool,
    },
    Ended {},
    Error {
        message: String,
    },
}

/// What kind of value a report has.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum ReportForm {
    /// A number in a unit.
    Number { unit: String },
    /// A truth value.
    Bool {},
    /// One of these names.
    Enumeration { names: Vec<String> },
}

/// A value that is reported.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum ReportValue {
    Bool(bool),
    Number(f64),
    Name(String),
}

impl<'a> Question<'a> {
    pub(super) fn setup(setup: &'a Setup) -> Self {
        Self::Setup {
            seed: setup.seed,
            period_secs: setup.period_secs,
            sensors: ports(&setup.sensors),
            actuators: ports(&setup.actuators),
            settings: &setup.settings,
        }
    }

    pub(super) fn tick(inputs: &'a Inputs) -> Self {
        let sensors = inputs.measurements.iter().map(|(name, measurement)| {
            let form = MeasurementForm {
                time_secs: measurement.time_secs,
                values: &measurement.values,
            };
            (name.as_str(), form)
        });
        let message = |message: &'a Message| MessageForm {
            name: &message.name,
            time_secs: message.time_secs,
        };
        Self::Tick {
            time_secs: inputs.time_secs,
            sensors: sensors.collect(),
            messages: inputs.messages.iter().map(message).collect(),
        }
    }

    /// What it is called in errors.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Hello { .. } => "hello",
            Self::Setup { .. } => "setup",
            Self::Tick { .. } => "tick",
            Self::End {} => "end",
        }
    }
}

fn ports(ports: &[Port]) -> BTreeMap<&str, PortForm<'_>> {
    ports
        .iter()
        .map(|port| {
            let fields = port.fields.iter().map(|field| {
                let form = PortFieldForm {
                    unit: &field.unit,
                    length: field.length,
                };
                (field.name.as_str(), form)
            });
            let form = PortForm {
                kind: &port.kind,
                fields: fields.collect(),
                facts: &port.facts,
            };
            (port.name.as_str(), form)
        })
        .collect()
}

/// The description that a `hello` gives.
pub(super) fn description(
    name: String,
    version: String,
    sends: Vec<String>,
    receives: Vec<String>,
    reports: BTreeMap<String, ReportForm>,
) -> Description {
    let reports = reports.into_iter().map(|(name, form)| match form {
        ReportForm::Number { unit } => Field::number(name, unit),
        ReportForm::Bool {} => Field::bool(name),
        ReportForm::Enumeration { names } => Field::enumeration(name, names),
    });
    Description {
        name,
        version,
        sends,
        receives,
        reports: reports.collect(),
    }
}

/// The outputs that `commands` gives, reported names as their indices.
pub(super) fn outputs(
    description: &Description,
    commands: BTreeMap<String, BTreeMap<String, f64>>,
    messages: Vec<String>,
    reports: BTreeMap<String, ReportValue>,
    finished: bool,
) -> Result<Outputs, String> {
    let reports = reports
        .into_iter()
        .map(|(name, value)| Ok((name.clone(), number_of(description, &name, value)?)));
    Ok(Outputs {
        commands,
        messages,
        reports: reports.collect::<Result<_, String>>()?,
        finished,
    })
}

fn number_of(description: &Description, name: &str, value: ReportValue) -> Result<f64, String> {
    use trace::FieldKind::{Bool, Enumeration, Number};
    let declared = description.reports.iter().find(|field| field.name == name);
    let Some(field) = declared else {
        return Err(format!(
            "it reports `{name}`, which its hello does not declare under `reports`"
        ));
    };
    match (value, &field.kind) {
        (ReportValue::Bool(value), Bool) => Ok(f64::from(u8::from(value))),
        (ReportValue::Number(value), Number) => Ok(value),
        (ReportValue::Name(value), Enumeration(names)) => names
            .iter()
            .position(|known| *known == value)
            .map(|index| index as f64)
            .ok_or_else(|| {
                format!("it reports `{name}` as `{value}`, which is not one of its names")
            }),
        _ => Err(format!(
            "it reports `{name}` as another kind of value than it declared"
        )),
    }
}
