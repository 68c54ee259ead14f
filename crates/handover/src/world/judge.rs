//! What is true in the world, apart from what the robot's sensors say; and how an episode ended.
//!
//! These are observations for the trace and a summary for people. Requirements are judged by
//! monitors on the trace, not here.

use testbench::geometry::{Pose, Vector, add, norm, subtract, within_box};

use super::human::Human;
use super::plant::{Grip, ObjectState};
use crate::robot::{Controller, Decision, State, TrackedPoses};
use crate::robot::{gaze_satisfied, location_satisfied};
use crate::scenario::Scenario;

/// The truth at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Truth {
    pub(crate) object: ObjectState,
    pub(crate) hand_m: Vector,
    pub(crate) hand_speed_m_s: f64,
    pub(crate) grip: Grip,
    /// The object is within the tolerance of where the hand holds it.
    pub(crate) in_hand: bool,
    pub(crate) human_hand_m: Vector,
    pub(crate) human_head: Pose,
    /// From the robot's hand to the human's hand or head, whichever is nearer; between centres.
    pub(crate) human_distance_m: f64,
    pub(crate) pull_newtons: f64,
    /// The human really looks at, pulls on and has the hand at the object.
    pub(crate) gaze: bool,
    pub(crate) pressure: bool,
    pub(crate) location: bool,
    pub(crate) human_holds: bool,
}

impl Truth {
    /// The human is really ready to take the object.
    pub(crate) fn human_ready(&self) -> bool {
        self.gaze && self.pressure && self.location
    }
}

/// What the plant and the human give to judge by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Observed {
    pub(crate) now_secs: f64,
    pub(crate) object: ObjectState,
    pub(crate) hand_m: Vector,
    pub(crate) hand_velocity_m_s: Vector,
    pub(crate) grip: Grip,
}

/// Judges one moment.
pub(crate) fn judge(scenario: &Scenario, observed: &Observed, human: &Human) -> Truth {
    let Observed {
        now_secs,
        object,
        hand_m,
        ..
    } = *observed;
    let rules = &scenario.truth;
    let human_hand_m = human.hand_m(now_secs);
    let human_head = human.head();
    let real = TrackedPoses {
        time_secs: now_secs,
        object_m: object.pose.position_m,
        human_hand_m,
        human_head,
    };
    let holding_point = add(object.pose.position_m, rules.in_hand_offset_m);
    let distance = |point| norm(subtract(hand_m, point));
    let pull_newtons = norm(human.pull_newtons(now_secs));
    Truth {
        object,
        hand_m,
        hand_speed_m_s: norm(observed.hand_velocity_m_s),
        grip: observed.grip,
        in_hand: within_box(hand_m, holding_point, rules.in_hand_tolerance_m),
        human_hand_m,
        human_head,
        human_distance_m: distance(human_hand_m).min(distance(human_head.position_m)),
        pull_newtons,
        gaze: human.applied()[0] && gaze_satisfied(&scenario.sensors, &real),
        pressure: pull_newtons >= rules.weakest_pull_newtons,
        location: human.applied()[2] && location_satisfied(&scenario.sensors, &real),
        human_holds: human.holds_object(),
    }
}

/// How an episode ended, in short.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// What the robot decided.
    pub decision: Decision,
    /// The robot's code crashed.
    pub crashed: bool,
    /// The robot closed its hand to grasp.
    pub grasped: bool,
    /// The object left the hand between the end of the grasp and the end of sensing.
    pub grip_failure: bool,
    /// What the sensors said at the end of sensing; `None` if it did not come to that.
    pub gaze_ok: Option<bool>,
    /// See [`Outcome::gaze_ok`].
    pub pressure_ok: Option<bool>,
    /// See [`Outcome::gaze_ok`].
    pub location_ok: Option<bool>,
    /// The human was ready in truth at some moment of sensing.
    pub human_was_ready: bool,
    /// Grasped, kept in hand until sensing was done, all sensors satisfied, and released.
    pub success: bool,
    /// At the end the human holds the object, above the height of a dropped one.
    pub object_with_human: bool,
    /// Largest speed of the robot's hand during the reset, m/s.
    pub reset_peak_speed_m_s: f64,
    /// Largest finger displacement the pressure sensor read, in counts.
    pub finger_displacement_counts: i64,
    /// Largest pull of the human, newtons.
    pub peak_pull_newtons: f64,
    /// Shortest distance between the robot's hand and the human's hand or head, m.
    pub closest_human_m: f64,
}

impl Outcome {
    /// Before anything has happened.
    pub(crate) fn new() -> Self {
        Self {
            decision: Decision::None,
            crashed: false,
            grasped: false,
            grip_failure: false,
            gaze_ok: None,
            pressure_ok: None,
            location_ok: None,
            human_was_ready: false,
            success: false,
            object_with_human: false,
            reset_peak_speed_m_s: 0.0,
            finger_displacement_counts: 0,
            peak_pull_newtons: 0.0,
            closest_human_m: f64::INFINITY,
        }
    }

    /// Takes in one moment.
    pub(crate) fn observe(&mut self, truth: &Truth, controller: &Controller) {
        let state = controller.state();
        let carrying = matches!(
            state,
            State::Lift
                | State::Serve
                | State::Announce
                | State::AwaitReady
                | State::Wait
                | State::Sense
        );
        self.grasped |= carrying;
        if carrying && (!truth.in_hand || truth.grip.contacts == 0) {
            self.grip_failure = true;
        }
        if state == State::Reset {
            self.reset_peak_speed_m_s = self.reset_peak_speed_m_s.max(truth.hand_speed_m_s);
        }
        self.human_was_ready |= state == State::Sense && truth.human_ready();
        self.peak_pull_newtons = self.peak_pull_newtons.max(truth.pull_newtons);
        self.closest_human_m = self.closest_human_m.min(truth.human_distance_m);
    }

    /// Closes the summary.
    pub(crate) fn finish(&mut self, truth: &Truth, controller: &Controller, lowest_m: f64) {
        self.decision = controller.decision();
        self.crashed = controller.state() == State::Crashed;
        self.finger_displacement_counts = controller.finger_displacement_counts();
        if controller.sensing_done()
            && let Some(report) = controller.sensor_report()
        {
            self.gaze_ok = report.gaze;
            self.pressure_ok = report.pressure;
            self.location_ok = report.location;
        }
        self.success = self.grasped
            && !self.grip_failure
            && self.decision == Decision::Release
            && !self.crashed;
        self.object_with_human = truth.human_holds && truth.object.pose.position_m[2] >= lowest_m;
    }
}
