//! One episode: a scenario, a parameter set and a seed give one trace, bit for bit.
//!
//! An episode draws everything random from streams under its seed, builds the physics afresh, and
//! interleaves physics (every step), tracking, the robot's code and the recorder, each at its own
//! rate counted in whole steps. Nothing carries over from one episode to the next, so a [`World`]
//! used before gives the same bytes as a new one, on any thread.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use trace::{Trace, TraceError};

use super::human::{Human, View, Wrench};
use super::judge::{Observed, Outcome, Truth, judge};
use super::planner::Planner;
use super::plant::{Plant, arm_joint_names};
use super::recorder::Recorder;
use super::tracking::{Reading, Tracker, TruePoses};
use crate::model::{PhysicalDraws, standing_pose};
use crate::mujoco::{Engine, EngineError};
use crate::outside::{Nothing, Outside, OutsideReadings};
use crate::random::{Purpose, Stream};
use crate::robot::{
    Controller, HandCommand, PlannerStatus, Readings, ResetPose, SensorReport, State,
};
use crate::scenario::{AbstractTest, Parameters, Rates, Scenario};

/// A flag by which a caller ends an episode early, from any thread.
#[derive(Debug, Default)]
pub struct Cancel(AtomicBool);

impl Cancel {
    /// Asks running episodes to end.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`Cancel::cancel`] was called.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why an episode gave no trace.
#[derive(Debug)]
pub enum SimError {
    /// The physics engine refused the model.
    Engine(EngineError),
    /// The recording could not be written, which means that the physics gave no number.
    Trace(TraceError),
    /// The physics became unstable.
    Unstable {
        /// The seed of the episode.
        seed: u64,
        /// When, in simulated seconds.
        time_secs: f64,
    },
    /// The caller cancelled the episode.
    Cancelled,
    /// There is no abstract test of this name.
    UnknownTest {
        /// The name asked for.
        name: String,
    },
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engine(error) => write!(f, "{error}"),
            Self::Trace(error) => write!(f, "the episode could not be recorded: {error}"),
            Self::Unstable { seed, time_secs } => write!(
                f,
                "the physics became unstable at {time_secs:.3} s in the episode with seed {seed}; shorten simulation.time_step_secs or soften the stiffest servo or contact"
            ),
            Self::Cancelled => write!(f, "the episode was cancelled"),
            Self::UnknownTest { name } => write!(
                f,
                "the scenario has no abstract test \"{name}\"; name one of its abstract_test tables"
            ),
        }
    }
}

impl std::error::Error for SimError {}

impl From<EngineError> for SimError {
    fn from(error: EngineError) -> Self {
        Self::Engine(error)
    }
}

impl From<TraceError> for SimError {
    fn from(error: TraceError) -> Self {
        Self::Trace(error)
    }
}

/// What an episode gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Everything recorded.
    pub trace: Trace,
    /// How it ended, in short.
    pub outcome: Outcome,
    /// Physics steps taken.
    pub steps: u64,
    /// Simulated time.
    pub sim_secs: f64,
}

/// A scenario with a parameter set and a test, ready to run episodes.
#[derive(Debug, Clone)]
pub struct World {
    engine: Engine,
    scenario: Scenario,
    parameters: Parameters,
    test: AbstractTest,
    arm_joints: Vec<String>,
}

impl World {
    /// A world whose human enacts the scenario's first abstract test.
    ///
    /// # Errors
    /// When the physics engine refuses the scenario's model.
    pub fn new(
        engine: &Engine,
        scenario: &Scenario,
        parameters: &Parameters,
    ) -> Result<Self, SimError> {
        let Some(test) = scenario.abstract_tests.first() else {
            return Err(SimError::UnknownTest {
                name: String::new(),
            });
        };
        let world = Self {
            engine: engine.clone(),
            scenario: scenario.clone(),
            parameters: parameters.clone(),
            test: test.clone(),
            arm_joints: arm_joint_names(scenario),
        };
        // A model that cannot be built is found here rather than in the first episode.
        Plant::new(engine, scenario, parameters, &world.physical_draws(0))?;
        Ok(world)
    }

    /// The same world with the human enacting another abstract test.
    ///
    /// # Errors
    /// [`SimError::UnknownTest`].
    pub fn with_test(mut self, name: &str) -> Result<Self, SimError> {
        let test = self.scenario.abstract_test(name);
        let unknown = || SimError::UnknownTest {
            name: name.to_owned(),
        };
        self.test = test.ok_or_else(unknown)?.clone();
        Ok(self)
    }

    /// The physical draws of the episode with `seed`.
    #[must_use]
    pub fn physical_draws(&self, seed: u64) -> PhysicalDraws {
        let mut stream = Stream::new(seed, Purpose::Object);
        let object = &self.parameters.object;
        let object_mass_kg = object.mass_kg.draw(&mut stream);
        let friction = self.parameters.hand.friction.draw(&mut stream);
        let [x_m, y_m] = self.scenario.object.position_m;
        let x_m = x_m + object.x_error_m.draw(&mut stream);
        let y_m = y_m + object.y_error_m.draw(&mut stream);
        let yaw_rad = object.yaw_rad.draw(&mut stream);
        let object_pose = standing_pose(&self.scenario, x_m, y_m, yaw_rad);
        PhysicalDraws {
            object_mass_kg,
            friction,
            object_pose,
        }
    }

    /// The pose the robot resets to in the episode with `seed`.
    fn reset_pose(&self, seed: u64) -> ResetPose {
        let mut stream = Stream::new(seed, Purpose::RobotPose);
        let mut angles = self.scenario.robot.poses.neutral.clone();
        for joint in &self.scenario.programme.reset_joints {
            let offset_rad = self.scenario.programme.reset_spread_rad.draw(&mut stream);
            *angles.entry(joint.clone()).or_insert(0.0) += offset_rad;
        }
        ResetPose(angles)
    }
}

/// Runs one episode.
///
/// # Errors
/// [`SimError::Cancelled`] when `cancel` is set, [`SimError::Unstable`] when the physics fails.
pub fn run_episode(world: &mut World, seed: u64, cancel: &Cancel) -> Result<Episode, SimError> {
    run_episode_with(world, seed, cancel, &mut Nothing)
}

/// Runs one episode that is joined to `outside`.
///
/// # Errors
/// [`SimError::Cancelled`] when `cancel` is set or `outside` breaks off, [`SimError::Unstable`]
/// when the physics fails.
pub fn run_episode_with(
    world: &mut World,
    seed: u64,
    cancel: &Cancel,
    outside: &mut dyn Outside,
) -> Result<Episode, SimError> {
    let mut run = Run::new(world, seed)?;
    let longest_steps =
        (world.scenario.simulation.longest_secs / world.scenario.simulation.time_step_secs) as u64;
    while run.plant.steps() < longest_steps && !run.is_over() {
        if run.plant.steps() % CANCEL_CHECK_STEPS == 0 && cancel.is_cancelled() {
            return Err(SimError::Cancelled);
        }
        run.from_outside = outside.readings();
        run.advance()?;
        if outside
            .step(run.plant.now_secs(), run.recorder.so_far())
            .is_break()
        {
            return Err(SimError::Cancelled);
        }
    }
    run.finish()
}

/// How many steps pass between looks at the cancel flag and at the engine's warnings.
const CANCEL_CHECK_STEPS: u64 = 500;

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
struct Run<'a> {
    world: &'a World,
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
    from_outside: OutsideReadings,
    planner_status: PlannerStatus,
    announced: bool,
    ended_at_secs: Option<f64>,
    truth: Option<Truth>,
    arm_rad: Vec<f64>,
    finger_counts: Vec<i64>,
    sensors_said: SensorsSaid,
}

impl<'a> Run<'a> {
    fn new(world: &'a World, seed: u64) -> Result<Self, SimError> {
        let (scenario, parameters) = (&world.scenario, &world.parameters);
        let draws = world.physical_draws(seed);
        let stream = |purpose| Stream::new(seed, purpose);
        let human = Human::new(
            &scenario.human,
            &world.test,
            &parameters.human,
            &mut stream(Purpose::Human),
            stream(Purpose::HumanTiming),
        );
        let mut recorder = Recorder::new()?;
        describe(&mut recorder, world, seed, &draws);
        Ok(Self {
            world,
            seed,
            periods: periods(scenario),
            plant: Plant::new(&world.engine, scenario, parameters, &draws)?,
            controller: Controller::new(scenario, world.arm_joints.clone(), world.reset_pose(seed)),
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

    /// Whether the robot has ended long enough ago, or the human has left.
    fn is_over(&self) -> bool {
        let after = self.world.scenario.simulation.end_after_secs;
        self.human.has_given_up()
            || self
                .ended_at_secs
                .is_some_and(|ended| self.plant.now_secs() + 1e-9 >= ended + after)
    }

    /// One time step, with everything that falls due at its beginning.
    fn advance(&mut self) -> Result<(), SimError> {
        let step = self.plant.steps();
        let due = |period: u64| step.is_multiple_of(period);
        if due(self.periods.tracking) {
            self.look()?;
        }
        if due(self.periods.controller) {
            self.tick();
        }
        if due(self.periods.truth_record) {
            self.record()?;
        }
        self.record_sensors(due(self.periods.sensors))?;
        if due(CANCEL_CHECK_STEPS) && self.plant.warning_count() > 0 {
            return Err(SimError::Unstable {
                seed: self.seed,
                time_secs: self.plant.now_secs(),
            });
        }
        let wrench = if self.human.acts_on_object() {
            self.human
                .wrench(self.plant.now_secs(), &self.plant.object())
        } else {
            Wrench::default()
        };
        self.plant.step(&wrench);
        Ok(())
    }

    /// The human acts and tracking takes a reading, both at the rate of tracking.
    fn look(&mut self) -> Result<(), SimError> {
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
        self.plant
            .place_human(&truth.human_head, truth.human_hand_m);
        let reading = self.tracker.read(now_secs, &truth);
        if self
            .plant
            .steps()
            .is_multiple_of(self.periods.tracking_record)
        {
            self.recorder.tracking(now_secs, &reading)?;
        }
        self.reading = Some(reading);
        Ok(())
    }

    /// The robot's code runs, and its commands reach planner and drives.
    fn tick(&mut self) {
        let clock_secs = self.plant.now_secs();
        self.plant.arm_rad(&mut self.arm_rad);
        self.plant.finger_counts(
            self.world.scenario.sensors.finger_counts_per_rad,
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
    fn record_sensors(&mut self, due: bool) -> Result<(), SimError> {
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
                .sensors(now_secs, controller, self.reading.as_ref())?;
        }
        Ok(())
    }

    /// Judges the moment and writes it down.
    fn record(&mut self) -> Result<(), SimError> {
        let now_secs = self.plant.now_secs();
        let (hand_m, hand_velocity_m_s) = self.plant.hand();
        let observed = Observed {
            now_secs,
            object: self.plant.object(),
            hand_m,
            hand_velocity_m_s,
            grip: self.plant.grip(),
        };
        let truth = judge(&self.world.scenario, &observed, &self.human);
        self.outcome.observe(&truth, &self.controller);
        let glitch = self.reading.is_some_and(|reading| reading.glitch);
        self.recorder.robot(now_secs, &self.controller, &truth)?;
        self.recorder.truth(now_secs, &truth, glitch)?;
        self.recorder.human(now_secs, &self.human)?;
        self.truth = Some(truth);
        Ok(())
    }

    /// Closes the recording; it counts as cut short when the robot was still at it.
    fn finish(mut self) -> Result<Episode, SimError> {
        let complete = self.is_over();
        self.record()?;
        if self.plant.warning_count() > 0 {
            return Err(SimError::Unstable {
                seed: self.seed,
                time_secs: self.plant.now_secs(),
            });
        }
        if let Some(truth) = &self.truth {
            let lowest_m = self.world.scenario.human.reach_lowest_object_m;
            self.outcome.finish(truth, &self.controller, lowest_m);
        }
        Ok(Episode {
            trace: self.recorder.finish(complete),
            outcome: self.outcome,
            steps: self.plant.steps(),
            sim_secs: self.plant.now_secs(),
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
fn describe(recorder: &mut Recorder, world: &World, seed: u64, draws: &PhysicalDraws) {
    recorder.note("scenario", &world.scenario.name);
    recorder.note("parameters", &world.parameters.name);
    recorder.note("abstract_test", &world.test.name);
    recorder.note("seed", seed);
    recorder.note("engine", "MuJoCo");
    recorder.note("engine_version", world.engine.version());
    recorder.note("time_step_secs", world.scenario.simulation.time_step_secs);
    recorder.note("object_mass_kg", draws.object_mass_kg);
    recorder.note("friction", draws.friction);
    recorder.note("object_x_m", draws.object_pose.position_m[0]);
    recorder.note("object_y_m", draws.object_pose.position_m[1]);
}
