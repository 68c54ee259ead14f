//! Controllers at work: what has arrived for them, what they want, and checks of the latter.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::actuating::Actuating;
use super::bench::Prepared;
use super::data::{ControllerData, Sensor};
use super::draws::Draws;
use super::sensing::Sensing;
use crate::controller::{
    Controller, ControllerError, Description, Inputs, Measurement, Message, Outputs, Setup,
};
use trace::FieldKind;

/// A controller in an episode.
pub(super) struct Piloting {
    pub(super) robot: usize,
    pub(super) period_steps: u64,
    pub(super) latency_secs: f64,
    controller: Box<dyn Controller>,
    waiting: Inputs,
    setup: Setup,
    /// What it was told and answered, if that is kept.
    log: Option<Vec<Arc<(Inputs, Outputs)>>>,
    /// Whether it has finished, what it has said, what it reports: the row of its topic.
    is_finished: bool,
    said: Vec<bool>,
    reported: Vec<f64>,
}

/// What makes a controller again what it was.
#[derive(Debug, Clone)]
pub(super) struct PilotLog {
    robot: usize,
    period_steps: u64,
    latency_secs: f64,
    setup: Setup,
    ticks: Vec<Arc<(Inputs, Outputs)>>,
    waiting: Inputs,
    is_finished: bool,
    said: Vec<bool>,
    reported: Vec<f64>,
}

impl Piloting {
    /// Keeps from now on what the controller is told and answers.
    pub(super) fn keep_log(&mut self) {
        self.log = Some(Vec::new());
    }

    /// What makes the controller again what it is.
    pub(super) fn log(&self) -> PilotLog {
        PilotLog {
            robot: self.robot,
            period_steps: self.period_steps,
            latency_secs: self.latency_secs,
            setup: self.setup.clone(),
            ticks: self.log.clone().unwrap_or_default(),
            waiting: self.waiting.clone(),
            is_finished: self.is_finished,
            said: self.said.clone(),
            reported: self.reported.clone(),
        }
    }

    /// A new controller that has been told all that another was told.
    pub(super) fn replay(
        prepared: &Prepared,
        data: &ControllerData,
        log: &PilotLog,
    ) -> Result<Self, ControllerError> {
        let mut controller = (prepared.controllers)(data)?;
        controller.set_up(&log.setup)?;
        for tick in &log.ticks {
            let (inputs, outputs) = tick.as_ref();
            if controller.tick(inputs)? != *outputs {
                return Err(ControllerError::Failed {
                    message: format!(
                        "told the same again it answers otherwise at {} s, so an episode with it cannot be continued; let it depend on nothing but its inputs and its seed",
                        inputs.time_secs
                    ),
                });
            }
        }
        Ok(Self {
            robot: log.robot,
            period_steps: log.period_steps,
            latency_secs: log.latency_secs,
            setup: log.setup.clone(),
            log: Some(log.ticks.clone()),
            waiting: log.waiting.clone(),
            is_finished: log.is_finished,
            said: log.said.clone(),
            reported: log.reported.clone(),
            controller,
        })
    }

    /// Starts the controller.
    pub(super) fn start(
        prepared: &Prepared,
        data: &ControllerData,
        robot: usize,
        period_steps: u64,
        draws: Draws,
    ) -> Result<Self, ControllerError> {
        let controller = (prepared.controllers)(data)?;
        let description = controller.describe();
        Ok(Self {
            robot,
            period_steps,
            latency_secs: draws.of("controller", &data.name, "latency_secs", &data.latency_secs),
            waiting: Inputs::default(),
            setup: Setup::default(),
            log: None,
            is_finished: false,
            said: vec![false; description.sends.len()],
            reported: vec![f64::NAN; description.reports.len()],
            controller,
        })
    }

    pub(super) fn description(&self) -> &Description {
        self.controller.describe()
    }

    /// Tells the controller what there is.
    pub(super) fn set_up(
        &mut self,
        data: &ControllerData,
        (sensors, sensing): (&[Sensor], &[Sensing]),
        actuators: &[Actuating],
        draws: Draws,
    ) -> Result<(), ControllerError> {
        let own = sensors.iter().zip(sensing);
        let own = own.filter(|(_, sensing)| sensing.robot == self.robot);
        let setup = Setup {
            // Whole numbers beyond 2^53 do not survive JSON everywhere.
            seed: draws.seed & ((1 << 53) - 1),
            period_secs: data.period_secs,
            sensors: own.map(|(sensor, sensing)| sensing.port(sensor)).collect(),
            actuators: actuators
                .iter()
                .filter(|actuator| actuator.robot == self.robot)
                .map(Actuating::port)
                .collect(),
            settings: settings_of(data, draws)?,
        };
        self.controller.set_up(&setup)?;
        self.setup = setup;
        Ok(())
    }

    /// A measurement has arrived.
    pub(super) fn receive(&mut self, sensor: &str, measurement: Measurement) {
        self.waiting
            .measurements
            .insert(sensor.to_owned(), measurement);
    }

    /// A message has been sent; it arrives if the controller understands it.
    pub(super) fn hear(&mut self, signal: &str, time_secs: f64) {
        if self
            .description()
            .receives
            .iter()
            .any(|known| known == signal)
        {
            self.waiting.messages.push(Message {
                name: signal.to_owned(),
                time_secs,
            });
        }
    }

    /// Asks the controller, and checks what it answers.
    pub(super) fn tick(
        &mut self,
        now_secs: f64,
        actuators: &[Actuating],
    ) -> Result<Outputs, ControllerError> {
        let mut inputs = std::mem::take(&mut self.waiting);
        inputs.time_secs = now_secs;
        let outputs = self.controller.tick(&inputs)?;
        self.check(&outputs, actuators)?;
        let description = self.controller.describe();
        for (said, message) in self.said.iter_mut().zip(&description.sends) {
            *said |= outputs.messages.contains(message);
        }
        for (value, field) in self.reported.iter_mut().zip(&description.reports) {
            if let Some(reported) = outputs.reports.get(&field.name) {
                *value = *reported;
            }
        }
        self.is_finished |= outputs.finished;
        if let Some(log) = &mut self.log {
            log.push(Arc::new((inputs, outputs.clone())));
        }
        Ok(outputs)
    }

    /// Everything that is commanded, sent and reported exists, and is a number.
    fn check(&self, outputs: &Outputs, actuators: &[Actuating]) -> Result<(), ControllerError> {
        let own = || {
            actuators
                .iter()
                .filter(|actuator| actuator.robot == self.robot)
        };
        for (name, fields) in &outputs.commands {
            let Some(actuator) = own().find(|actuator| actuator.name == *name) else {
                let known = own().map(|actuator| actuator.name.clone());
                return Err(wrong(format!("a command to `{name}`"), known.collect()));
            };
            for (field, value) in fields {
                let known: Vec<String> = actuator.fields.iter().map(|f| f.name.clone()).collect();
                if !known.contains(field) {
                    return Err(wrong(format!("a command `{field}` to `{name}`"), known));
                }
                if !value.is_finite() {
                    let what = format!("{value} as the command `{field}` to `{name}`");
                    return Err(wrong(what, vec!["a need of finite numbers".to_owned()]));
                }
            }
        }
        let description = self.controller.describe();
        for message in &outputs.messages {
            if !description.sends.contains(message) {
                let known = description.sends.clone();
                return Err(wrong(format!("the message `{message}`"), known));
            }
        }
        for (name, value) in &outputs.reports {
            let field = description.reports.iter().find(|field| field.name == *name);
            if !field.is_some_and(|field| admits(&field.kind, *value)) {
                let known = description.reports.iter().map(|field| field.name.clone());
                return Err(wrong(
                    format!("{value} as report `{name}`"),
                    known.collect(),
                ));
            }
        }
        Ok(())
    }

    /// The commands as places of actuators and fields.
    pub(super) fn commands(
        &self,
        outputs: &Outputs,
        actuators: &[Actuating],
    ) -> Vec<(usize, usize, f64)> {
        let mut commands = Vec::new();
        for (name, fields) in &outputs.commands {
            let place = actuators.iter().position(|actuator| actuator.name == *name);
            let Some(place) = place else { continue };
            for (field, value) in fields {
                let known = &actuators[place].fields;
                if let Some(index) = known.iter().position(|f| f.name == *field) {
                    commands.push((place, index, *value));
                }
            }
        }
        commands
    }

    pub(super) fn is_finished(&self) -> bool {
        self.is_finished
    }

    /// The row of the controller's topic.
    pub(super) fn row(&self) -> Vec<f64> {
        let flag = |value: bool| f64::from(u8::from(value));
        let mut row = vec![flag(self.is_finished)];
        row.extend(self.said.iter().map(|said| flag(*said)));
        row.extend(&self.reported);
        row
    }

    pub(super) fn end(&mut self) -> Result<(), ControllerError> {
        self.controller.end()
    }
}

fn wrong(what: String, known: Vec<String>) -> ControllerError {
    ControllerError::Output { what, known }
}

fn admits(kind: &FieldKind, value: f64) -> bool {
    match kind {
        FieldKind::Number => value.is_finite(),
        FieldKind::Bool => value == 0.0 || value == 1.0,
        FieldKind::Enumeration(names) => {
            value.fract() == 0.0 && value >= 0.0 && value < names.len() as f64
        }
    }
}

/// The settings as JSON; a distribution becomes the number that the episode draws.
fn settings_of(
    data: &ControllerData,
    draws: Draws,
) -> Result<serde_json::Map<String, serde_json::Value>, ControllerError> {
    let bad = |key: &str, reason: String| ControllerError::Failed {
        message: format!("its setting `{key}` cannot be used: {reason}"),
    };
    let mut settings = BTreeMap::new();
    for (key, value) in &data.settings {
        let value = match value.clone().try_into::<stimulus::Distribution>() {
            Ok(distribution) if value.is_table() => {
                let field = format!("settings.{key}");
                let number = draws.of("controller", &data.name, &field, &distribution);
                serde_json::Value::from(number)
            }
            _ => serde_json::to_value(value).map_err(|error| bad(key, error.to_string()))?,
        };
        settings.insert(key.clone(), value);
    }
    Ok(settings.into_iter().collect())
}
