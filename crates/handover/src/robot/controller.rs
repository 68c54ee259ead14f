//! The robot's high-level code: the handover as a state machine.
//!
//! Reset to a pose, wait to be activated, fetch the object, bring it, announce, wait for "ready",
//! wait, sense, decide once, and release or end. Each arm movement after the reset asks the motion
//! planner first. If the planner does not answer in time the code fails: the state becomes
//! [`State::Crashed`] and no command ever changes again. That gap is the robot's, kept on purpose.

use super::interface::{Commands, HandCommand, PlannerStatus, Readings};
use super::sensing::{SensorNodes, SensorReport};
use crate::scenario::{JointAngles, Scenario};

/// Where the robot's code is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the steps of the programme")]
pub enum State {
    Reset,
    AwaitActivation,
    Prepare,
    Above,
    Pickup,
    Grasp,
    Lift,
    Serve,
    Announce,
    AwaitReady,
    Wait,
    Sense,
    Decide,
    Release,
    Done,
    Crashed,
}

impl State {
    /// All states with their names, in the order of the trace's enumeration.
    pub const NAMES: [(State, &'static str); 16] = [
        (State::Reset, "reset"),
        (State::AwaitActivation, "await_activation"),
        (State::Prepare, "prepare"),
        (State::Above, "above"),
        (State::Pickup, "pickup"),
        (State::Grasp, "grasp"),
        (State::Lift, "lift"),
        (State::Serve, "serve"),
        (State::Announce, "announce"),
        (State::AwaitReady, "await_ready"),
        (State::Wait, "wait"),
        (State::Sense, "sense"),
        (State::Decide, "decide"),
        (State::Release, "release"),
        (State::Done, "done"),
        (State::Crashed, "crashed"),
    ];

    /// Whether nothing more will happen.
    #[must_use]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Done | Self::Crashed)
    }
}

/// What the robot has decided about the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Nothing yet.
    None,
    /// To let go of it.
    Release,
    /// To keep it.
    Keep,
    /// To end because the human or the sensors did not respond in time.
    TimeOut,
}

impl Decision {
    /// All decisions with their names, in the order of the trace's enumeration.
    pub const NAMES: [(Decision, &'static str); 4] = [
        (Decision::None, "none"),
        (Decision::Release, "release"),
        (Decision::Keep, "keep"),
        (Decision::TimeOut, "time_out"),
    ];
}

/// The pose the robot is told to reset to: joint angles in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct ResetPose(pub JointAngles);

/// Progress of one planned movement.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Movement {
    /// The planner was asked at this time.
    Planning(f64),
    /// The arm has been moving since this time.
    Moving(f64),
}

/// The state machine with its memory.
#[derive(Debug, Clone)]
pub struct Controller {
    scenario: Scenario,
    arm_joints: Vec<String>,
    state: State,
    entered_secs: f64,
    movement: Movement,
    /// How often this movement's call may still be made again.
    retries_left: u32,
    commands: Commands,
    sensors: Option<SensorNodes>,
    next_reading_secs: f64,
    sensing_done: bool,
    decision: Decision,
}

impl Controller {
    /// The robot's code as it starts at time 0. `arm_joints` names the arm encoders in the order of
    /// [`Readings::arm_rad`].
    #[must_use]
    pub fn new(scenario: &Scenario, arm_joints: Vec<String>, reset: ResetPose) -> Self {
        Self {
            scenario: scenario.clone(),
            arm_joints,
            state: State::Reset,
            entered_secs: 0.0,
            movement: Movement::Planning(0.0),
            retries_left: 0,
            commands: Commands {
                arm_target_rad: reset.0,
                restricted: false,
                hand: HandCommand::Open,
                announcing: false,
                planner_requests: 0,
            },
            sensors: None,
            next_reading_secs: 0.0,
            sensing_done: false,
            decision: Decision::None,
        }
    }

    /// Runs one tick: at most one change of state.
    pub fn tick(&mut self, readings: &Readings<'_>) {
        let now = readings.clock_secs;
        let elapsed = now - self.entered_secs + 1e-9;
        let programme = &self.scenario.programme;
        match self.state {
            State::Reset if elapsed >= programme.reset_secs => {
                self.enter(State::AwaitActivation, now)
            }
            State::AwaitActivation if readings.activated => self.plan(State::Prepare, now),
            State::Prepare | State::Above | State::Pickup | State::Lift | State::Serve => {
                self.move_arm(readings);
            }
            State::Grasp => self.grasp(elapsed, now),
            State::Announce if elapsed >= programme.announce_secs => {
                self.commands.announcing = false;
                self.enter(State::AwaitReady, now);
            }
            State::AwaitReady if readings.human_ready => self.enter(State::Wait, now),
            State::AwaitReady if elapsed >= programme.ready_timeout_secs => self.time_out(now),
            State::Wait if elapsed >= programme.wait_before_sensing_secs => {
                self.begin_sensing(readings)
            }
            State::Sense => self.sense(readings, elapsed),
            State::Decide => self.act_on_decision(now),
            State::Release if elapsed >= programme.release_secs => self.enter(State::Done, now),
            _ => {}
        }
    }

    /// What the robot wants now.
    #[must_use]
    pub fn commands(&self) -> &Commands {
        &self.commands
    }

    /// Where the robot's code is.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// What has been decided.
    #[must_use]
    pub fn decision(&self) -> Decision {
        self.decision
    }

    /// Whether the robot is waiting for its motion planner.
    #[must_use]
    pub fn is_planning(&self) -> bool {
        let moves = [
            State::Prepare,
            State::Above,
            State::Pickup,
            State::Lift,
            State::Serve,
        ];
        moves.contains(&self.state) && matches!(self.movement, Movement::Planning(_))
    }

    /// Whether all readings for the decision have been taken.
    #[must_use]
    pub fn sensing_done(&self) -> bool {
        self.sensing_done
    }

    /// What the sensors say, once sensing has begun.
    #[must_use]
    pub fn sensor_report(&self) -> Option<SensorReport> {
        self.sensors.as_ref().map(SensorNodes::report)
    }

    /// The largest finger displacement seen while sensing, in counts.
    #[must_use]
    pub fn finger_displacement_counts(&self) -> i64 {
        self.sensors
            .as_ref()
            .map_or(0, SensorNodes::largest_displacement_counts)
    }

    fn enter(&mut self, state: State, now_secs: f64) {
        self.state = state;
        self.entered_secs = now_secs;
    }

    /// Enters a movement by asking the planner for it.
    fn plan(&mut self, state: State, now_secs: f64) {
        self.enter(state, now_secs);
        self.retries_left = self.scenario.programme.planner_retries;
        self.ask_planner(now_secs);
    }

    fn ask_planner(&mut self, now_secs: f64) {
        self.movement = Movement::Planning(now_secs);
        self.commands.planner_requests += 1;
    }

    /// The pose a movement leads to, and the state after it.
    fn movement_goal(&self) -> (&JointAngles, State) {
        let poses = &self.scenario.robot.poses;
        match self.state {
            State::Prepare => (&poses.prepare, State::Above),
            State::Above => (&poses.above, State::Pickup),
            State::Pickup => (&poses.pickup, State::Grasp),
            State::Lift => (&poses.above, State::Serve),
            _ => (&poses.serve, State::Announce),
        }
    }

    fn move_arm(&mut self, readings: &Readings<'_>) {
        let now = readings.clock_secs;
        let programme = &self.scenario.programme;
        match self.movement {
            Movement::Planning(_) if readings.planner == PlannerStatus::Answered => {
                self.commands.arm_target_rad = self.movement_goal().0.clone();
                self.commands.restricted = true;
                self.movement = Movement::Moving(now);
            }
            Movement::Planning(since) if now - since + 1e-9 >= programme.planner_timeout_secs => {
                if self.retries_left == 0 {
                    self.enter(State::Crashed, now);
                } else {
                    self.retries_left -= 1;
                    self.ask_planner(now);
                }
            }
            Movement::Planning(_) => {}
            Movement::Moving(since) => {
                let late = now - since + 1e-9 >= programme.arrive_timeout_secs;
                if late || self.has_arrived(readings.arm_rad) {
                    self.after_movement(now);
                }
            }
        }
    }

    /// Whether the arm encoders agree with the target.
    fn has_arrived(&self, arm_rad: &[f64]) -> bool {
        self.arm_joints.iter().zip(arm_rad).all(|(joint, angle)| {
            self.commands
                .arm_target_rad
                .get(joint)
                .is_none_or(|target| {
                    (target - angle).abs() <= self.scenario.programme.arrive_tolerance_rad
                })
        })
    }

    fn after_movement(&mut self, now_secs: f64) {
        let next = self.movement_goal().1;
        match next {
            State::Grasp => {
                self.commands.hand = HandCommand::Pregrasp;
                self.enter(next, now_secs);
            }
            State::Announce => {
                self.commands.announcing = true;
                self.enter(next, now_secs);
            }
            _ => self.plan(next, now_secs),
        }
    }

    fn grasp(&mut self, elapsed_secs: f64, now_secs: f64) {
        let programme = &self.scenario.programme;
        if elapsed_secs >= programme.pregrasp_secs {
            self.commands.hand = HandCommand::Grasp;
        }
        if elapsed_secs >= programme.pregrasp_secs + programme.grasp_secs {
            self.plan(State::Lift, now_secs);
        }
    }

    fn begin_sensing(&mut self, readings: &Readings<'_>) {
        let now = readings.clock_secs;
        let baseline = self.scenario.programme.finger_baseline_secs;
        let mut sensors = SensorNodes::begin(&self.scenario.sensors, baseline, now);
        sensors.read(readings);
        self.sensors = Some(sensors);
        self.next_reading_secs = now + self.reading_period_secs();
        self.enter(State::Sense, now);
    }

    fn reading_period_secs(&self) -> f64 {
        1.0 / f64::from(self.scenario.rates.sensing_hz)
    }

    fn sense(&mut self, readings: &Readings<'_>, elapsed_secs: f64) {
        let now = readings.clock_secs;
        let period = self.reading_period_secs();
        let Some(sensors) = &mut self.sensors else {
            return;
        };
        if now + 1e-9 < self.next_reading_secs {
            return;
        }
        sensors.read(readings);
        self.next_reading_secs += period;
        let report = sensors.report();
        if elapsed_secs >= self.scenario.programme.sensing_secs && report.complete() {
            self.sensing_done = true;
            self.decision = if report.all_satisfied() {
                Decision::Release
            } else {
                Decision::Keep
            };
            self.enter(State::Decide, now);
        } else if elapsed_secs >= self.scenario.programme.sensing_timeout_secs {
            self.time_out(now);
        }
    }

    fn time_out(&mut self, now_secs: f64) {
        self.decision = Decision::TimeOut;
        self.enter(State::Decide, now_secs);
    }

    fn act_on_decision(&mut self, now_secs: f64) {
        if self.decision == Decision::Release {
            self.commands.hand = HandCommand::Open;
            self.enter(State::Release, now_secs);
        } else {
            self.enter(State::Done, now_secs);
        }
    }
}
