//! An episode in progress.
//!
//! It draws everything random from streams under its seed, builds the physics afresh, and
//! interleaves physics (every step), tracking, the robot's code and the recorder, each at its own
//! rate counted in whole steps. Nothing carries over from one episode to the next, so a [`World`]
//! used before gives the same bytes as a new one, on any thread.

use testbench::{Cancel, End, SimError, Stream, Watch};
use trace::Trace;

use super::episode::Episode;
use super::human::{Human, View};
use super::judge::{Observed, Outcome, Truth, judge};
use super::planner::Planner;
use super::plant::Plant;
use super::recorder::Recorder;
use super::setup::{Setup, World};
use super::tracking::{Reading, Tracker, TruePoses};
use super::view;
use crate::model::PhysicalDraws;
use crate::outside::OutsideReadings;
use crate::purpose::Purpose;
use crate::robot::{Controller, HandCommand, PlannerStatus, Readings, SensorReport, State};
use crate::scenario::{Rates, Scenario};

/// How many steps pass between looks at the cancel flag and at the engine's warnings.
const CHECK_STEPS: u64 = 500;

/// Periods of what does not happen at every step, in steps.
#[derive(Debug, Clone, Copy)]
struct Periods {
    controller: u64,
    tracking: u64,
    sensors: u64,
    truth_record: u64,
    tracking_record: u64,
}

/// What the robot's sensors said when they were last written down.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct SensorsSaid {
    sensing: bool,
    done: bool,
    report: Option<SensorReport>,
}

/// An episode in progress.
pub(crate) struct Run {
    world: World,
    longest_steps: u64,
    seed: u64,
    periods: Periods,
    plant: Plant,
    controller: Controller,
    human: Human,
    tracker: Tracker,
    planner: Planner,
    recorder: Recorder,
    outcome: Outcome,
    reading: Option<Reading>,
    pub(crate) from_outside: OutsideReadings,
    planner_status: PlannerStatus,
    announced: bool,
    ended_at_secs: Option<f64>,
    truth: Option<Truth>,
    arm_rad: Vec<f64>,
    finger_counts: Vec<i64>,
    sensors_said: SensorsSaid,
}

impl Run {
    /// The episode of `world` with `seed` at its beginning.
    pub(crate) fn new(world: &World, seed: u64) -> Result<Self, SimError> {
        let setup = world.setup();
        let (scenario, parameters) = (&setup.scenario, &setup.parameters);
        let draws = world.physical_draws(seed);
        let stream = |purpose| Stream::new(seed, purpose);
        let human = Human::new(
            &scenario.human,
            &setup.test,
            &parameters.human,
            &mut stream(Purpose::Human),
            stream(Purpose::HumanTiming),
        );
        let mut recorder = Recorder::new()?;
        describe(&mut recorder, setup, seed, &draws);
        let settings = &scenario.simulation;
        Ok(Self {
            world: world.clone(),
            longest_steps: (settings.longest_secs / settings.time_step_secs) as u64,
            seed,
            periods: periods(scenario),
            plant: Plant::new(&setup.physics, scenario, parameters, &draws, setup.contacts)?,
            controller: Controller::new(scenario, setup.arm_joints.clone(), world.reset_pose(seed)),
            human,
            tracker: Tracker::new(
                &parameters.tracking,
                &scenario.tracking,
                stream(Purpose::Tracking),
            ),
            planner: Planner::new(&parameters.planner, stream(Purpose::Planner)),
            recorder,
            outcome: Outcome::new(),
            reading: None,
            from_outside: OutsideReadings::default(),
            planner_status: PlannerStatus::Idle,
            announced: false,
            ended_at_secs: None,
            truth: None,
            arm_rad: Vec::new(),
            finger_counts: Vec::new(),
            sensors_said: SensorsSaid::default(),
        })
    }

    /// The same episode once more, in exactly the same state. With a new seed, whatever is still to
    /// be drawn from there on is drawn from that seed's streams; what was drawn and has had an
    /// effect (the object, the robot's pose, where the human stands) stays.
    pub(crate) fn duplicate(&self, new_seed: Option<u64>) -> Result<Self, SimError> {
        let mut copy = Self {
            world: self.world.clone(),
            plant: self.plant.duplicate()?,
            controller: self.controller.clone(),
            human: self.human.clone(),
            tracker: self.tracker.clone(),
            planner: self.planner.clone(),
            recorder: self.recorder.clone(),
            outcome: self.outcome.clone(),
            arm_rad: self.arm_rad.clone(),
            finger_counts: self.finger_counts.clone(),
            ..*self
        };
        if let Some(seed) = new_seed {
            copy.draw_anew(seed);
        }
        Ok(copy)
    }

    fn draw_anew(&mut self, seed: u64) {
        self.seed = seed;
        let stream = |purpose| Stream::new(seed, purpose);
        let parameters = &self.world.setup().parameters;
        self.human.draw_anew(
            &parameters.human,
            &mut stream(Purpose::Human),
            stream(Purpose::HumanTiming),
        );
        self.tracker.draw_anew(stream(Purpose::Tracking));
        self.planner
            .draw_anew(&parameters.planner, stream(Purpose::Planner));
        self.recorder.note("resumed_with_seed", seed);
        self.recorder.note("resumed_at_secs", self.plant.now_secs());
    }

    /// Whether the robot has ended long enough ago, or the human has left.
    fn is_over(&self) -> bool {
        let after = self.world.setup().scenario.simulation.end_after_secs;
        self.human.has_given_up()
            || self
                .ended_at_secs
                .is_some_and(|ended| self.plant.now_secs() + 1e-9 >= ended + after)
    }

    /// Why the episode has ended, if it has.
    pub(crate) fn ended(&self) -> Option<End> {
        if self.recorder.is_finished() {
            return Some(End::Watched);
        }
        if self.is_over() {
            return Some(End::Over);
        }
        (self.plant.steps() >= self.longest_steps).then_some(End::Longest)
    }

    /// Looks, now and then, whether the episode may go on.
    pub(crate) fn check(&self, cancel: &Cancel) -> Result<(), SimError> {
        if self.plant.steps().is_multiple_of(CHECK_STEPS) && cancel.is_cancelled() {
            return Err(SimError::Cancelled);
        }
        Ok(())
    }

    /// The physics.
    pub(crate) fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The physics by itself.
    pub(crate) fn into_plant(self) -> Plant {
        self.plant
    }

    /// Simulated time.
    pub(crate) fn now_secs(&self) -> f64 {
        self.plant.now_secs()
    }

    /// What was recorded so far.
    pub(crate) fn so_far(&self) -> &Trace {
        self.recorder.so_far()
    }

    /// One time step, with everything that falls due at its beginning.
    pub(crate) fn advance(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let step = self.plant.steps();
        let due = |period: u64| step.is_multiple_of(period);
        if due(self.periods.tracking) {
            self.look(watch)?;
        }
        if due(self.periods.controller) {
            self.tick();
        }
        if due(self.periods.truth_record) {
            self.record(watch)?;
        }
        self.record_sensors(due(self.periods.sensors), watch)?;
        if due(CHECK_STEPS) && self.plant.warning_count() > 0 {
            return Err(SimError::Unstable {
                seed: self.seed,
                time_secs: self.plant.now_secs(),
            });
        }
        let wrench = self.human.acts_on_object().then(|| {
            self.human
                .wrench(self.plant.now_secs(), &self.plant.object())
        });
        self.plant.step(wrench.as_ref())?;
        Ok(())
    }

    /// The human acts and tracking takes a reading, both at the rate of tracking.
    fn look(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.plant.now_secs();
        let object = self.plant.object();
        let view = View {
            now_secs,
            announced: self.announced,
            robot_lets_go: self.controller.state() == State::Release
                && self.controller.commands().hand == HandCommand::Open,
            object: object.pose,
        };
        self.human.update(&view);
        let truth = TruePoses {
            object_m: object.pose.position_m,
            human_hand_m: self.human.hand_m(now_secs),
            human_head: self.human.head(),
        };
        let reading = self.tracker.read(now_secs, &truth);
        if self
            .plant
            .steps()
            .is_multiple_of(self.periods.tracking_record)
        {
            self.recorder.tracking(now_secs, &reading, watch)?;
        }
        self.reading = Some(reading);
        Ok(())
    }

    /// The robot's code runs, and its commands reach planner and drives.
    fn tick(&mut self) {
        let clock_secs = self.plant.now_secs();
        self.plant.arm_rad(&mut self.arm_rad);
        self.plant.finger_counts(
            self.world.setup().scenario.sensors.finger_counts_per_rad,
            &mut self.finger_counts,
        );
        let requests = self.controller.commands().planner_requests;
        self.planner_status = self.planner.update(requests, clock_secs);
        let outside = &self.from_outside;
        let tracking = self.reading.as_ref().map(|reading| reading.reported);
        let tracking = tracking.and_then(|reported| outside.tracked(reported));
        let readings = Readings {
            clock_secs,
            arm_rad: &self.arm_rad,
            finger_counts: &self.finger_counts,
            tracking: tracking.as_ref(),
            activated: outside.activated.or(Some(self.human.activated())) == Some(true),
            human_ready: outside.human_ready.or(Some(self.human.ready())) == Some(true),
            planner: self.planner_status,
            sensors: outside.sensors,
        };
        self.controller.tick(&readings);
        self.announced |= self.controller.commands().announcing;
        self.plant.command(self.controller.commands());
        if self.controller.state().is_final() && self.ended_at_secs.is_none() {
            self.ended_at_secs = Some(clock_secs);
        }
    }

    /// Writes the sensors down when a row is due, and at once when what they say has changed: a
    /// monitor must not see the end of sensing later than the hand that opens because of it.
    fn record_sensors(&mut self, due: bool, watch: &mut dyn Watch) -> Result<(), SimError> {
        let controller = &self.controller;
        let said = SensorsSaid {
            sensing: controller.state() == State::Sense,
            done: controller.sensing_done(),
            report: controller.sensor_report(),
        };
        if due || said != self.sensors_said {
            self.sensors_said = said;
            let now_secs = self.plant.now_secs();
            self.recorder
                .sensors(now_secs, controller, self.reading.as_ref(), watch)?;
        }
        Ok(())
    }

    /// Judges the moment and writes it down.
    fn record(&mut self, watch: &mut dyn Watch) -> Result<(), SimError> {
        let now_secs = self.plant.now_secs();
        let (hand_m, hand_velocity_m_s) = self.plant.hand();
        let observed = Observed {
            now_secs,
            object: self.plant.object(),
            hand_m,
            hand_velocity_m_s,
            grip: self.plant.grip(),
        };
        let truth = judge(&self.world.setup().scenario, &observed, &self.human);
        self.outcome.observe(&truth, &self.controller);
        let glitch = self.reading.is_some_and(|reading| reading.glitch);
        let recorder = &mut self.recorder;
        recorder.robot(now_secs, &self.controller, &truth, watch)?;
        recorder.truth(now_secs, &truth, glitch, watch)?;
        recorder.human(now_secs, &self.human, watch)?;
        if let Some(viewer) = watch.viewer() {
            let (setup, human) = (self.world.setup(), &self.human);
            let poses = view::poses(setup, &self.plant, (&human.head(), human.hand_m(now_secs)));
            viewer.see(now_secs, &|| view::geometry(setup), &poses);
        }
        self.truth = Some(truth);
        Ok(())
    }

    /// Closes the recording; it counts as cut short when the robot was still at it.
    pub(crate) fn finish(mut self, watch: &mut dyn Watch) -> Result<Episode, SimError> {
        let end = self.ended().unwrap_or(End::Watched);
        self.record(watch)?;
        if self.plant.warning_count() > 0 {
            return Err(SimError::Unstable {
                seed: self.seed,
                time_secs: self.plant.now_secs(),
            });
        }
        if let Some(truth) = &self.truth {
            let lowest_m = self.world.setup().scenario.human.reach_lowest_object_m;
            self.outcome.finish(truth, &self.controller, lowest_m);
        }
        Ok(Episode {
            trace: self.recorder.finish(end == End::Over),
            outcome: self.outcome,
            steps: self.plant.steps(),
            sim_secs: self.plant.now_secs(),
            end,
        })
    }
}

fn periods(scenario: &Scenario) -> Periods {
    let steps = |hz| Rates::steps_between(hz, scenario.simulation.time_step_secs);
    let rates = &scenario.rates;
    Periods {
        controller: steps(rates.controller_hz),
        tracking: steps(rates.tracking_hz),
        sensors: steps(rates.sensing_hz),
        truth_record: steps(rates.truth_record_hz),
        tracking_record: steps(rates.tracking_record_hz),
    }
}

/// Facts about the episode, for the trace's metadata.
fn describe(recorder: &mut Recorder, setup: &Setup, seed: u64, draws: &PhysicalDraws) {
    recorder.note("scenario", &setup.scenario.name);
    recorder.note("parameters", &setup.parameters.name);
    recorder.note("abstract_test", &setup.test.name);
    recorder.note("seed", seed);
    recorder.note("engine", setup.physics.name());
    recorder.note("engine_version", setup.physics.version());
    recorder.note("time_step_secs", setup.scenario.simulation.time_step_secs);
    recorder.note("object_mass_kg", draws.object_mass_kg);
    recorder.note("friction", draws.friction);
    recorder.note("object_x_m", draws.object_pose.position_m[0]);
    recorder.note("object_y_m", draws.object_pose.position_m[1]);
}
