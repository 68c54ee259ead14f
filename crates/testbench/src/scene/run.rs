//! One episode of a scene: the loop that joins physics, people, sensors, controllers and recording.
//!
//! At each time step, in this order: people move on to the step's end (at their rate); sensors that
//! are due measure; what has arrived is recorded; the test acts; controllers that are due tick;
//! commands that are due take effect; the truth is recorded; the physics steps. Every rate is counted
//! in whole steps, so nothing drifts.

mod frozen;
mod truth;

use std::collections::VecDeque;
use std::sync::Arc;

use stimulus::Stimulus;

use super::actuating::Actuating;
use super::bench::Prepared;
use super::build::{Built, build};
use super::compliant::{Compliant, Toucher};
use super::data::whole_steps;
use super::draws::Draws;
use super::grip::Grips;
use super::measure::{Scenery, yaw_of};
use super::person::poses_of;
use super::piloting::Piloting;
use super::recorder::{Recorder, sensor_row};
use super::script::{Known, Reach, Script};
use super::sensing::Sensing;
use super::taking::Taking;
use super::truth::{Declared, Witness};
use super::walker::{PersonSeen, RobotSeen, Surroundings, Walker};
use crate::bench::ScenarioError;
use crate::bench::{Creep, End, Failure, OutOfReach, Recorded, SimError, Watch};
use crate::controller::ControllerError;
use crate::physics::{Physics, Touch};

pub(super) use frozen::Frozen;

/// An episode in progress.
pub(super) struct Run {
    pub(super) prepared: Arc<Prepared>,
    pub(super) seed: u64,
    draws: Draws,
    built: Built,
    physics: Box<dyn Physics>,
    people: Vec<Walker>,
    /// Who of them takes something.
    takings: Vec<Option<Taking>>,
    sensors: Vec<Sensing>,
    actuators: Vec<Actuating>,
    pub(super) pilots: Vec<Piloting>,
    script: Script,
    known: Known,
    pub(super) recorder: Recorder,
    witness: Witness,
    grips: Grips,
    touches: Vec<Touch>,
    /// What people who give way can be touched by.
    touchers: Vec<Toucher>,
    /// What touches their skin in the step to come.
    skin: Vec<Touch>,
    /// Largest forces since the last row, by robot: of people, of other things.
    forces: Vec<[f64; 2]>,
    arrived: Vec<bool>,
    steps: u64,
    record_steps: u64,
    people_steps: u64,
    finished_secs: Option<f64>,
    commands: VecDeque<(f64, usize, usize, f64)>,
}

impl Run {
    /// Begins an episode.
    pub(super) fn new(
        prepared: Arc<Prepared>,
        stimulus: &Stimulus,
        seed: u64,
    ) -> Result<Self, SimError> {
        let data = &prepared.data;
        let draws = Draws { seed };
        let mut built = build(data, &prepared.models, draws)?;
        let always = Recorder::new(data, &[], &[])?.trace;
        let declared = Declared::new(data, &built, &always, &prepared.truth);
        let declared = declared.map_err(|unknown| SimError::Stimulus {
            reason: format!("a signal of truth that is read is not there any more: {unknown}"),
        })?;
        declared.ask_wrenches(&mut built.layout);
        let witness = Witness::new(&declared, data, &built.layout);
        let step_secs = data.simulation.time_step_secs;
        let steps = |key: &str, period_secs: f64| whole_steps(key, period_secs, step_secs);
        let physics = (prepared.physics)(&built.layout)?;
        let people = data.people.iter().zip(&built.people);
        let people: Vec<Walker> = people
            .map(|(person, body)| {
                let walker = Walker::new(person, body.radius_m, draws);
                walker.in_group(data.group_of(person))
            })
            .collect();
        let robot_of = |name: &str| data.robots.iter().position(|robot| robot.name == name);
        let mut sensors = Vec::new();
        for sensor in &data.sensors {
            let robot = robot_of(&sensor.robot).unwrap_or(0);
            let period = steps("sensor.rate_hz", 1.0 / sensor.rate_hz)?;
            sensors.push(Sensing::new(sensor, robot, &built, period, draws));
        }
        let actuators = data.actuators.iter().enumerate();
        let actuators: Vec<Actuating> = actuators
            .map(|(index, actuator)| {
                let robot = robot_of(&actuator.robot).unwrap_or(0);
                let of = (data, prepared.models.as_ref(), &built);
                Actuating::new(actuator, index, robot, of, draws)
            })
            .collect();
        let mut pilots = Vec::new();
        for controller in &data.controllers {
            let robot = robot_of(&controller.robot).unwrap_or(0);
            let period = steps("controller.period_secs", controller.period_secs)?;
            let mut pilot = Piloting::start(&prepared, controller, robot, period, draws)?;
            pilot.set_up(controller, (&data.sensors, &sensors), &actuators, draws)?;
            pilots.push(pilot);
        }
        let descriptions: Vec<_> = pilots
            .iter()
            .map(|pilot| pilot.description().clone())
            .collect();
        let known = known(data, &descriptions);
        known
            .check(&stimulus.test)
            .map_err(|reason| SimError::Stimulus { reason })?;
        let mut run = Self {
            recorder: Recorder::new(data, &descriptions, &witness.blocks)?,
            witness,
            grips: Grips::new(&built),
            script: Script::new(&stimulus.test),
            known,
            seed,
            draws,
            physics,
            touches: Vec::new(),
            touchers: Toucher::of(&built.layout, &built.people),
            skin: Vec::new(),
            forces: vec![[0.0; 2]; built.robots.len()],
            arrived: vec![false; people.len()],
            takings: data
                .people
                .iter()
                .map(|it| Taking::new(it, data, &built, draws))
                .collect(),
            people,
            sensors,
            actuators,
            pilots,
            steps: 0,
            record_steps: steps("simulation.record_hz", 1.0 / data.simulation.record_hz)?,
            people_steps: steps("simulation.people_hz", 1.0 / data.simulation.people_hz)?,
            finished_secs: None,
            commands: VecDeque::new(),
            built,
            prepared: Arc::clone(&prepared),
        };
        run.describe(stimulus);
        run.place();
        Ok(run)
    }

    /// The sensor of a name.
    pub(super) fn sensor_mut(&mut self, name: &str) -> Option<&mut Sensing> {
        self.sensors.iter_mut().find(|sensor| sensor.name == name)
    }

    /// Facts for the recording's metadata.
    fn describe(&mut self, stimulus: &Stimulus) {
        let (engine, version) = self.physics.engine();
        let recorder = &mut self.recorder;
        recorder.note("scene", &self.prepared.data.name);
        recorder.note("abstract_test", &stimulus.test.name);
        recorder.note("seed", self.seed);
        recorder.note("engine", engine);
        recorder.note("engine_version", version);
        recorder.note(
            "time_step_secs",
            self.prepared.data.simulation.time_step_secs,
        );
        for (controller, pilot) in self.prepared.data.controllers.iter().zip(&self.pilots) {
            let description = pilot.description();
            let text = format!("{} {}", description.name, description.version);
            recorder.note(&format!("controller.{}", controller.name), text);
        }
        for (key, value) in &stimulus.settings {
            recorder.note(&format!("setting.{key}"), value);
        }
    }

    /// Brings joints and people to where they begin.
    fn place(&mut self) {
        for robot in &self.built.robots {
            for (joint, position) in &robot.start {
                self.physics.set_joint(*joint, *position);
            }
        }
        self.lead_people(None);
        self.physics.refresh();
    }

    /// People are where they went in `secs`, or where they are placed at first.
    fn lead_people(&mut self, secs: Option<f64>) {
        let then_secs = secs.map_or(0.0, |_| self.now_secs() + self.built.layout.time_step_secs);
        for (walker, body) in self.people.iter().zip(&mut self.built.people) {
            let poses = poses_of(walker.body, body.height_m, &walker.stance);
            if let Some(compliant) = &mut body.compliant {
                compliant.want(&poses, then_secs, secs);
                continue;
            }
            for (body, pose) in body.bodies.clone().zip(&poses) {
                self.physics.lead(body, pose);
                self.witness.lead(body, pose, secs);
            }
        }
    }

    /// Simulated time.
    pub(super) fn now_secs(&self) -> f64 {
        self.steps as f64 * self.prepared.data.simulation.time_step_secs
    }

    /// How the episode ends now, if it does.
    pub(super) fn end(&self) -> Option<End> {
        let simulation = &self.prepared.data.simulation;
        let after = |secs: f64| self.now_secs() + 1e-9 >= secs + simulation.end_after_secs;
        if self.recorder.is_enough {
            return Some(End::Watched);
        }
        let is_over = self.finished_secs.is_some_and(after)
            || self.now_secs() + 1e-9 >= simulation.duration_secs;
        is_over.then_some(End::Over)
    }

    /// One time step, with everything that falls due at its beginning.
    pub(super) fn step(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        self.sense(watch)?;
        self.enact();
        self.pilot(watch)?;
        self.let_go();
        self.act(watch)?;
        if self.steps.is_multiple_of(self.record_steps) {
            self.record(watch)?;
        }
        if (self.steps + 1).is_multiple_of(self.people_steps) {
            self.move_people();
        }
        let data = &self.prepared.data;
        let layout = &self.built.layout;
        self.witness.look(data, layout, self.physics.as_ref());
        self.hold_people();
        self.hold_attached();
        self.physics.step();
        self.steps += 1;
        self.touches.clear();
        self.physics.touches(&mut self.touches);
        self.touches.append(&mut self.skin);
        let now_secs = self.now_secs();
        let data = &self.prepared.data;
        self.witness.feel(data, now_secs, &self.touches);
        self.gather_forces();
        self.grip();
        if self.steps.is_multiple_of(500) {
            self.check_sound()?;
        }
        Ok(())
    }

    fn check_sound(&self) -> Result<(), SimError> {
        if self.physics.is_sound() {
            return Ok(());
        }
        Err(SimError::Unstable {
            seed: self.seed,
            time_secs: self.now_secs(),
        })
    }

    /// Sensors measure, and what has arrived is recorded and goes to the controllers.
    fn sense(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.now_secs();
        let mut scenery = Scenery {
            now_secs,
            physics: self.physics.as_ref(),
            built: &self.built,
            people: &self.people,
            data: &self.prepared.data,
            actuators: &self.actuators,
            touches: &self.touches,
        };
        for (index, sensor) in self.sensors.iter_mut().enumerate() {
            if self.steps.is_multiple_of(sensor.period_steps) {
                sensor.measure(&mut scenery);
            }
            while let Some(arrived) = sensor.arrived(now_secs) {
                let is_faulty = sensor.fault(arrived.measured_secs).is_some();
                let data = &self.prepared.data.sensors[index];
                let row = sensor_row(data, arrived.measured_secs, is_faulty, &arrived.values);
                self.recorder
                    .row(self.recorder.topics.sensors[index], now_secs, &row, watch)?;
                for pilot in self.pilots.iter_mut().filter(|p| p.robot == sensor.robot) {
                    pilot.receive(&sensor.name, arrived.measurement(&sensor.fields));
                }
            }
        }
        Ok(())
    }

    /// The test does what is due.
    fn enact(&mut self) {
        let now_secs = self.now_secs();
        for (index, walker) in self.people.iter().enumerate() {
            if walker.has_arrived() && !self.arrived[index] {
                self.arrived[index] = true;
                self.script
                    .hear(&format!("{}.arrived", self.known.people[index]));
            }
        }
        for (index, taking) in self.takings.iter_mut().enumerate() {
            if taking.as_mut().is_some_and(Taking::has_taken) {
                self.script
                    .hear(&format!("{}.took", self.known.people[index]));
            }
        }
        let mut sent = Vec::new();
        let mut reach = Reach {
            people: &mut self.people,
            sensors: &mut self.sensors,
            actuators: &mut self.actuators,
        };
        self.script
            .enact(now_secs, self.draws, &self.known, &mut reach, &mut sent);
        for signal in &sent {
            for group in self.actuators.iter_mut().filter_map(|it| it.group.as_mut()) {
                group.begin(signal, now_secs);
            }
            self.pilots
                .iter_mut()
                .for_each(|pilot| pilot.hear(signal, now_secs));
        }
    }

    /// Controllers that are due tick; their commands set out.
    fn pilot(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.now_secs();
        for index in 0..self.pilots.len() {
            let pilot = &mut self.pilots[index];
            if !self.steps.is_multiple_of(pilot.period_steps) {
                continue;
            }
            let outputs = pilot.tick(now_secs, &self.actuators)?;
            for message in &outputs.messages {
                self.script.hear(message);
            }
            let due_secs = now_secs + pilot.latency_secs;
            for (actuator, field, value) in pilot.commands(&outputs, &self.actuators) {
                self.commands.push_back((due_secs, actuator, field, value));
            }
            let row = pilot.row();
            self.recorder.row(
                self.recorder.topics.controllers[index],
                now_secs,
                &row,
                watch,
            )?;
        }
        let all_finished = !self.pilots.is_empty() && self.pilots.iter().all(Piloting::is_finished);
        if all_finished && self.finished_secs.is_none() {
            self.finished_secs = Some(now_secs);
        }
        Ok(())
    }

    /// Commands that are due take effect, and drives are brought on their way.
    fn act(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.now_secs();
        let mut changed = vec![self.steps == 0; self.actuators.len()];
        // Commands of controllers with different latencies are not in the order of their times.
        let is_due = |due_secs: f64| due_secs <= now_secs + 1e-9;
        let actuators = &mut self.actuators;
        self.commands.retain(|(due_secs, actuator, field, value)| {
            if is_due(*due_secs) {
                changed[*actuator] = true;
                actuators[*actuator].command(*field, *value);
            }
            !is_due(*due_secs)
        });
        let step_secs = self.prepared.data.simulation.time_step_secs;
        for (index, actuator) in self.actuators.iter_mut().enumerate() {
            let is_faulty = actuator.errors.is_faulty(now_secs);
            if changed[index] || actuator.is_told() || is_faulty != actuator.was_faulty {
                let topic = self.recorder.topics.actuators[index];
                let mut row = actuator.commanded.clone();
                row.push(f64::from(u8::from(is_faulty)));
                self.recorder.row(topic, now_secs, &row, watch)?;
            }
            actuator.was_faulty = is_faulty;
            let ended = actuator.act(self.physics.as_mut(), now_secs, step_secs);
            if let Some(ended) = ended {
                let how = match ended.out_of_reach {
                    None => "done",
                    Some((waypoint, left)) => {
                        let failed = OutOfReach::new(&ended.trajectory, waypoint, now_secs, left);
                        failed.add_to(&mut self.recorder.trace);
                        "failed"
                    }
                };
                self.script.hear(&format!("{}.{how}", ended.trajectory));
            }
        }
        Ok(())
    }

    /// What people who give way and those who touch them were pushed with in the last step acts no longer.
    fn let_go(&mut self) {
        let people = self.built.people.iter();
        let parts = people.flat_map(|it| it.compliant.iter().flat_map(Compliant::bodies));
        let taken = self
            .takings
            .iter()
            .flatten()
            .filter_map(Taking::pulled)
            .flatten();
        for body in self
            .touchers
            .iter()
            .map(Toucher::body)
            .chain(parts)
            .chain(taken)
        {
            self.physics.apply(body, [0.0; 3], [0.0; 3]);
        }
        for gripper in self
            .actuators
            .iter_mut()
            .filter_map(|it| it.gripper.as_mut())
        {
            gripper.let_go(self.physics.as_mut());
        }
    }

    /// Grippers hold what is attached to them.
    fn hold_attached(&mut self) {
        for taking in self.takings.iter_mut().flatten() {
            taking.pull(self.physics.as_mut());
        }
        for gripper in self
            .actuators
            .iter_mut()
            .filter_map(|it| it.gripper.as_mut())
        {
            gripper.pull(self.physics.as_mut());
        }
    }

    /// Grippers attach what there is to be attached, and let go of what tore off.
    fn grip(&mut self) {
        let grippers = || self.actuators.iter().filter_map(|it| it.gripper.as_ref());
        let mut taken: Vec<usize> = grippers().filter_map(|it| it.taken()).collect();
        let (data, built) = (&self.prepared.data, &self.built);
        let physics = self.physics.as_ref();
        for gripper in self
            .actuators
            .iter_mut()
            .filter_map(|it| it.gripper.as_mut())
        {
            gripper.feel(data, built, physics, &self.touches, &taken);
            taken.extend(gripper.taken());
        }
    }

    /// People who give way are held where they are wanted, and feel what touches them.
    fn hold_people(&mut self) {
        let Built { layout, people, .. } = &mut self.built;
        for compliant in people.iter_mut().filter_map(|it| it.compliant.as_mut()) {
            let physics = self.physics.as_mut();
            compliant.act(physics, layout, &self.touchers, &mut self.skin);
        }
    }

    /// People go on to the end of this step.
    fn move_people(&mut self) {
        let data = &self.prepared.data.simulation;
        let period_secs = self.people_steps as f64 * data.time_step_secs;
        let then_secs = (self.steps + 1) as f64 * data.time_step_secs;
        let seen = |robot: &super::build::BuiltRobot| {
            let pose = self.physics.body_pose(robot.added.root);
            RobotSeen {
                x_m: pose.position_m[0],
                y_m: pose.position_m[1],
                yaw_rad: yaw_of(pose.orientation),
            }
        };
        let robots: Vec<RobotSeen> = self.built.robots.iter().map(seen).collect();
        let people: Vec<PersonSeen> = self.people.iter().map(Walker::seen).collect();
        let all = self.people.iter_mut().zip(&mut self.built.people);
        for (own, (walker, body)) in all.enumerate() {
            let around = Surroundings {
                robots: &robots,
                people: &people,
                own,
            };
            walker.update(then_secs, period_secs, around);
            if let Some(compliant) = &mut body.compliant {
                let newtons = compliant.pushed_newtons(period_secs);
                walker.step_back(newtons, compliant.balance_newtons, period_secs);
            }
        }
        let people = self.people.iter_mut().zip(&self.built.people);
        for ((walker, body), taking) in people.zip(&mut self.takings) {
            if let Some(taking) = taking {
                let times = (then_secs, period_secs);
                taking.update(times, walker, (body, &self.built), self.physics.as_mut());
            }
        }
        self.lead_people(Some(period_secs));
    }

    /// Ends the episode and closes the recording.
    pub(super) fn finish(mut self, end: End, watch: &mut dyn Watch) -> Result<Recorded, SimError> {
        self.record(watch)?;
        self.check_sound()?;
        let mut failure = None;
        for pilot in &mut self.pilots {
            if let Err(error) = pilot.end() {
                failure.get_or_insert(Failure::of_controller(&error, false));
            }
        }
        // One that fails only when all is over has been seen as a whole.
        self.recorder.trace.complete = end == End::Over;
        Ok(self.recorded(end, failure))
    }

    /// Ends the episode where a controller failed, with what was recorded up to there.
    pub(super) fn fail(
        mut self,
        error: ControllerError,
        watch: &mut dyn Watch,
    ) -> Result<Recorded, SimError> {
        self.record(watch)?;
        self.check_sound()?;
        self.recorder.trace.complete = false;
        let failure = Failure::of_controller(&error, false);
        Ok(self.recorded(End::Failed, Some(failure)))
    }

    fn recorded(mut self, end: End, failure: Option<Failure>) -> Recorded {
        if let Some(failure) = &failure {
            self.recorder.note("failed", failure.kind());
        }
        let crept = self.grips.crept(&self.prepared.data);
        if let (false, Ok(text)) = (crept.is_empty(), serde_json::to_string(&crept)) {
            self.recorder.note(Creep::KEY, text);
        }
        Recorded {
            sim_secs: self.now_secs(),
            trace: self.recorder.trace,
            steps: self.steps,
            end: match failure {
                Some(_) => End::Failed,
                None => end,
            },
            failure,
        }
    }
}

/// The fields of groups and grippers that a test may set, with their units.
fn settable(actuator: &super::data::Actuator) -> Vec<String> {
    use super::data::ActuatorKind;
    match actuator.kind {
        ActuatorKind::JointGroup(_) | ActuatorKind::Gripper(_) => {
            let fields = actuator.fields();
            fields.iter().map(super::data::key_with_unit).collect()
        }
        _ => Vec::new(),
    }
}

/// What tests may name in this scene.
pub(super) fn known(
    data: &super::data::SceneData,
    descriptions: &[crate::controller::Description],
) -> Known {
    let people: Vec<String> = data.people.iter().map(|p| p.name.clone()).collect();
    let takers = data.people.iter().filter(|it| it.takes.is_some());
    let events = people.iter().map(|name| format!("{name}.arrived"));
    let events = events.chain(takers.map(|it| format!("{}.took", it.name)));
    let trajectories = || data.trajectories.iter().map(|it| it.name.clone());
    let ends =
        trajectories().flat_map(|name| ["done", "failed"].map(|how| format!("{name}.{how}")));
    let sends = descriptions.iter().flat_map(|d| d.sends.iter().cloned());
    let receives = descriptions.iter().flat_map(|d| d.receives.iter().cloned());
    Known {
        sendable: receives.chain(trajectories()).collect(),
        receivable: sends.chain(events).chain(ends).collect(),
        fields: data.actuators.iter().map(settable).collect(),
        sensors: data.sensors.iter().map(|s| s.name.clone()).collect(),
        actuators: data.actuators.iter().map(|a| a.name.clone()).collect(),
        replayed: data.people.iter().map(|p| p.capture.is_some()).collect(),
        people,
    }
}

impl From<crate::controller::ControllerError> for SimError {
    fn from(error: crate::controller::ControllerError) -> Self {
        Self::Controller(error)
    }
}

/// Data that were checked before can still lack a link or joint of a description.
pub(super) fn unsuitable(error: &ScenarioError) -> SimError {
    SimError::Stimulus {
        reason: error.to_string(),
    }
}
