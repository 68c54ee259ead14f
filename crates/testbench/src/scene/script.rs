//! The abstract test at work: signals sent and awaited, parameters set, one action after another.

use std::collections::{BTreeMap, BTreeSet};

use stimulus::{AbstractTest, Setting, Verb};

use super::actuating::Actuating;
use super::data::{Activity, ArmPose, FaultKind};
use super::draws::Draws;
use super::drive_errors::ForcedDriveFault;
use super::sensing::Sensing;
use super::walker::Walker;

/// A test in an episode.
#[derive(Debug, Clone)]
pub(super) struct Script {
    test: AbstractTest,
    next: usize,
    /// When the action before was done, or the awaited signal came.
    since_secs: f64,
    /// The delay of the next action, once it is drawn.
    delay_secs: Option<f64>,
    is_heard: bool,
    heard: BTreeMap<String, u64>,
}

/// What a test may name, for checking it before the episode.
#[derive(Debug, Clone, Default)]
pub(super) struct Known {
    /// Messages that controllers receive.
    pub(super) sendable: BTreeSet<String>,
    /// Messages that controllers send, and events of people.
    pub(super) receivable: BTreeSet<String>,
    /// Names of people, of sensors and of actuators.
    pub(super) people: Vec<String>,
    /// Which of the people are replayed from recordings.
    pub(super) replayed: Vec<bool>,
    pub(super) sensors: Vec<String>,
    pub(super) actuators: Vec<String>,
    /// For each actuator the fields that a test may set, with units.
    pub(super) fields: Vec<Vec<String>>,
}

/// What a test acts on.
pub(super) struct Reach<'a> {
    pub(super) people: &'a mut [Walker],
    pub(super) sensors: &'a mut [Sensing],
    pub(super) actuators: &'a mut [Actuating],
}

/// Something that a test sets.
#[derive(Debug, Clone, PartialEq)]
enum Change {
    Activity(usize, Activity),
    Speed(usize, f64),
    Distracted(usize, bool),
    Arms(usize, ArmPose),
    Fault(usize, Option<FaultKind>),
    DriveFault(usize, Option<ForcedDriveFault>),
    Command(usize, usize, f64),
}

impl Known {
    /// Checks that the scene understands everything that the test does.
    ///
    /// # Errors
    /// In one sentence with what would do.
    pub(super) fn check(&self, test: &AbstractTest) -> Result<(), String> {
        let list = |names: &BTreeSet<String>| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            if names.is_empty() {
                "nothing".to_owned()
            } else {
                names.join(", ")
            }
        };
        for action in &test.actions {
            match &action.verb {
                Verb::Send(signal) if !self.sendable.contains(signal) => {
                    return Err(format!(
                        "it sends `{signal}`, which no controller receives; they receive {}",
                        list(&self.sendable)
                    ));
                }
                Verb::Receive(signal) if !self.receivable.contains(signal) => {
                    return Err(format!(
                        "it waits for `{signal}`, which nothing sends; there is {}",
                        list(&self.receivable)
                    ));
                }
                Verb::Set(values) => {
                    for (key, value) in values {
                        self.change(key, value)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// What setting `key` does.
    fn change(&self, key: &str, value: &Setting) -> Result<Change, String> {
        let (name, field) = key.rsplit_once('.').unwrap_or((key, ""));
        let person = self.people.iter().position(|known| known == name);
        let sensor = self.sensors.iter().position(|known| known == name);
        let actuator = self.actuators.iter().position(|known| known == name);
        let wrong = |allowed: &str| Err(format!("it sets `{key}` to {value}; it may be {allowed}"));
        let is_replayed = person.is_some_and(|it| self.replayed.get(it) == Some(&true));
        match (person, sensor, field, value) {
            (Some(_), _, field, value)
                if is_replayed
                    && !(field == "activity"
                        && ["walk", "stand"]
                            .iter()
                            .any(|it| *value == Setting::Text((*it).to_owned()))) =>
            {
                let what = "of somebody who is replayed from a recording; only `activity` can be set, to walk (it goes on) or stand (it rests)";
                Err(format!("it sets `{key}` to {value}, {what}"))
            }
            (Some(person), _, "activity", Setting::Text(text)) => {
                match of_name(&Activity::NAMES, text) {
                    Some(activity) => Ok(Change::Activity(person, activity)),
                    None => wrong("stand, walk, approach or follow"),
                }
            }
            (Some(person), _, "arms", Setting::Text(text)) => {
                match of_name(&ArmPose::NAMES, text) {
                    Some(arms) => Ok(Change::Arms(person, arms)),
                    None => wrong("swing, reach, carry or withdraw"),
                }
            }
            (Some(person), _, "distracted", Setting::Bool(distracted)) => {
                Ok(Change::Distracted(person, *distracted))
            }
            (Some(person), _, "speed_m_s", Setting::Number(speed_m_s)) => {
                if (0.0..=12.0).contains(speed_m_s) {
                    return Ok(Change::Speed(person, *speed_m_s));
                }
                wrong("0 to 12")
            }
            (None, Some(sensor), "fault", Setting::Text(text)) => match text.as_str() {
                "none" => Ok(Change::Fault(sensor, None)),
                "stuck" => Ok(Change::Fault(sensor, Some(FaultKind::Stuck))),
                "silent" => Ok(Change::Fault(sensor, Some(FaultKind::Silent))),
                _ => wrong("none, stuck or silent"),
            },
            (None, None, "fault", Setting::Text(text)) if actuator.is_some() => {
                let actuator = actuator.unwrap_or_default();
                match text.as_str() {
                    "none" => Ok(Change::DriveFault(actuator, None)),
                    "stuck" => Ok(Change::DriveFault(actuator, Some(ForcedDriveFault::Stuck))),
                    "limp" => Ok(Change::DriveFault(actuator, Some(ForcedDriveFault::Limp))),
                    _ => wrong("none, stuck or limp"),
                }
            }
            (None, None, field, Setting::Number(number)) if number.is_finite() => {
                let named = actuator.and_then(|actuator| {
                    let place = self
                        .fields
                        .get(actuator)?
                        .iter()
                        .position(|it| it == field)?;
                    Some(Change::Command(actuator, place, *number))
                });
                named.ok_or_else(|| self.unsettable(key, value))
            }
            _ => Err(self.unsettable(key, value)),
        }
    }

    /// What can be set instead.
    fn unsettable(&self, key: &str, value: &Setting) -> String {
        let named = self.actuators.iter().zip(&self.fields);
        let commands: Vec<String> = named
            .flat_map(|(name, fields)| fields.iter().map(move |field| format!("{name}.{field}")))
            .collect();
        let commands = match commands.is_empty() {
            true => String::new(),
            false => format!(
                "; numbers of groups and grippers are {}",
                commands.join(", ")
            ),
        };
        format!(
            "it sets `{key}` to {value}, which cannot be set; settable are PERSON.activity, PERSON.arms (texts), PERSON.speed_m_s (a number), PERSON.distracted (true or false), SENSOR.fault and ACTUATOR.fault (texts), with the people {}, the sensors {} and the actuators {}",
            self.people.join(", "),
            self.sensors.join(", "),
            self.actuators.join(", ")
        ) + &commands
    }
}

fn of_name<T: Copy>(names: &[(T, &str)], name: &str) -> Option<T> {
    names
        .iter()
        .find(|(_, known)| *known == name)
        .map(|(value, _)| *value)
}

impl Script {
    pub(super) fn new(test: &AbstractTest) -> Self {
        Self {
            test: test.clone(),
            next: 0,
            since_secs: 0.0,
            delay_secs: None,
            is_heard: false,
            heard: BTreeMap::new(),
        }
    }

    /// A signal was sent by a controller or is an event of a person.
    pub(super) fn hear(&mut self, signal: &str) {
        *self.heard.entry(signal.to_owned()).or_default() += 1;
    }

    /// How many actions are done.
    pub(super) fn done(&self) -> usize {
        self.next
    }

    /// Whether all are.
    pub(super) fn is_done(&self) -> bool {
        self.next >= self.test.actions.len()
    }

    /// Does what is due; the signals that are sent are appended to `sent`.
    pub(super) fn enact(
        &mut self,
        now_secs: f64,
        draws: Draws,
        known: &Known,
        reach: &mut Reach<'_>,
        sent: &mut Vec<String>,
    ) {
        while let Some(action) = self.test.actions.get(self.next) {
            if let (Verb::Receive(signal), false) = (&action.verb, self.is_heard) {
                // Each signal is taken once.
                let Some(count) = self.heard.get_mut(signal).filter(|count| **count > 0) else {
                    return;
                };
                *count -= 1;
                self.is_heard = true;
                self.since_secs = now_secs;
            }
            let key = format!("test.{}.after_secs", self.next);
            let delay_secs = self
                .delay_secs
                .unwrap_or_else(|| draws.number(&key, &action.after_secs));
            self.delay_secs = Some(delay_secs);
            if now_secs + 1e-9 < self.since_secs + delay_secs {
                return;
            }
            match &action.verb {
                Verb::Send(signal) => sent.push(signal.clone()),
                Verb::Receive(_) => {}
                Verb::Set(values) => {
                    let changes = values.iter().filter_map(|(k, v)| known.change(k, v).ok());
                    changes.for_each(|change| make(&change, reach));
                }
            }
            self.next += 1;
            self.since_secs = now_secs;
            self.delay_secs = None;
            self.is_heard = false;
        }
    }
}

fn make(change: &Change, reach: &mut Reach<'_>) {
    let Reach {
        people,
        sensors,
        actuators,
    } = reach;
    match *change {
        Change::Activity(person, activity) => people[person].activity = activity,
        Change::Speed(person, speed_m_s) => people[person].walking_m_s = speed_m_s,
        Change::Distracted(person, distracted) => people[person].distracted = distracted,
        Change::Arms(person, arms) => people[person].hold_arms(arms),
        Change::Fault(sensor, fault) => sensors[sensor].forced = fault,
        Change::DriveFault(actuator, fault) => actuators[actuator].errors.forced = fault,
        Change::Command(actuator, field, value) => actuators[actuator].command(field, value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stimulus::{Action, Distribution};

    #[test]
    fn actions_follow_one_another_and_signals_are_taken_once() {
        let test = AbstractTest::new(
            "t",
            vec![
                Action::send("go").after(Distribution::Constant(1.0)),
                Action::receive("arrived"),
                Action::receive("arrived").after(Distribution::Constant(0.5)),
                Action::send("back"),
            ],
        );
        let mut script = Script::new(&test);
        let (draws, known) = (Draws { seed: 1 }, Known::default());
        let at = |script: &mut Script, now_secs: f64| {
            let mut sent = Vec::new();
            let mut reach = Reach {
                people: &mut [],
                sensors: &mut [],
                actuators: &mut [],
            };
            script.enact(now_secs, draws, &known, &mut reach, &mut sent);
            sent
        };
        assert!(at(&mut script, 0.9).is_empty());
        assert_eq!(at(&mut script, 1.0), ["go"]);
        script.hear("arrived");
        assert!(at(&mut script, 2.0).is_empty());
        assert_eq!(script.done(), 2);
        assert!(at(&mut script, 3.0).is_empty());
        script.hear("arrived");
        assert!(at(&mut script, 4.0).is_empty());
        assert_eq!(at(&mut script, 4.5), ["back"]);
        assert!(script.is_done());
    }

    #[test]
    fn what_a_scene_does_not_know_is_refused_with_what_it_knows() {
        let known = Known {
            sendable: ["go".to_owned()].into(),
            receivable: ["arrived".to_owned()].into(),
            people: vec!["anna".to_owned()],
            replayed: vec![false],
            sensors: vec!["lidar".to_owned()],
            actuators: vec!["drive".to_owned(), "hand".to_owned()],
            fields: vec![Vec::new(), vec!["width_m".to_owned()]],
        };
        let error = |action: Action| known.check(&AbstractTest::new("t", vec![action]));
        assert!(
            error(Action::send("gone"))
                .unwrap_err()
                .contains("they receive go")
        );
        assert!(
            error(Action::receive("x"))
                .unwrap_err()
                .contains("there is arrived")
        );
        assert!(
            error(Action::set("anna.activity", "fly"))
                .unwrap_err()
                .contains("stand, walk")
        );
        assert!(
            error(Action::set("anna.mood", true))
                .unwrap_err()
                .contains("cannot be set")
        );
        assert!(
            error(Action::set("lidar.fault", 1.0))
                .unwrap_err()
                .contains("cannot be set")
        );
        assert!(error(Action::set("lidar.fault", "stuck")).is_ok());
        assert!(
            error(Action::set("drive.fault", "silent"))
                .unwrap_err()
                .contains("none, stuck or limp")
        );
        assert!(error(Action::set("drive.fault", "limp")).is_ok());
        assert!(error(Action::set("anna.speed_m_s", 1.5)).is_ok());
        assert!(error(Action::set("hand.width_m", 0.02)).is_ok());
        assert!(
            error(Action::set("hand.width", 0.02))
                .unwrap_err()
                .contains("hand.width_m")
        );
    }
}
