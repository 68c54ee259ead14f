//! The robot's code by itself: no physics, no simulator, only readings and commands.

use crate::common;

use handover::SensorsOutside;
use handover::robot::{
    Controller, Decision, HandCommand, PlannerStatus, Readings, ResetPose, State, TrackedPoses,
};
use testbench::geometry::{IDENTITY, Pose};

/// A perfect body: the arm is where it is told to be, the planner answers at once.
struct Bench {
    controller: Controller,
    joints: Vec<String>,
    clock_secs: f64,
    tracking: Option<TrackedPoses>,
    activated: bool,
    ready: bool,
    planner: PlannerStatus,
    finger: i64,
    seen: Vec<State>,
}

impl Bench {
    fn new() -> Self {
        let scenario = common::scenario();
        let joints: Vec<String> = scenario.robot.poses.neutral.keys().cloned().collect();
        let reset = ResetPose(scenario.robot.poses.neutral.clone());
        // The head looks at the object from one metre away; the hand is on the object.
        let human_head = Pose {
            position_m: [0.0; 3],
            orientation: IDENTITY,
        };
        let tracking = TrackedPoses {
            time_secs: 0.0,
            object_m: [1.0, 0.0, 0.0],
            human_hand_m: [1.0, 0.0, -0.1],
            human_head,
        };
        Self {
            controller: Controller::new(&scenario, joints.clone(), reset),
            joints,
            clock_secs: 0.0,
            tracking: Some(tracking),
            activated: true,
            ready: true,
            planner: PlannerStatus::Answered,
            finger: 0,
            seen: vec![State::Reset],
        }
    }

    fn tick(&mut self) {
        let target = &self.controller.commands().arm_target_rad;
        let arm_rad: Vec<f64> = self.joints.iter().map(|joint| target[joint]).collect();
        self.controller.tick(&Readings {
            clock_secs: self.clock_secs,
            arm_rad: &arm_rad,
            finger_counts: &[self.finger],
            tracking: self.tracking.as_ref(),
            activated: self.activated,
            human_ready: self.ready,
            planner: self.planner,
            sensors: SensorsOutside::default(),
        });
        self.clock_secs += 0.02;
        if self.seen.last() != Some(&self.controller.state()) {
            self.seen.push(self.controller.state());
        }
    }

    /// Ticks until the robot has ended or `longest_secs` have gone by.
    fn run(&mut self, longest_secs: f64) {
        let end = self.clock_secs + longest_secs;
        while self.clock_secs < end && !self.controller.state().is_final() {
            // A pull moves a finger once the fingers have been read for a while.
            if self
                .controller
                .sensor_report()
                .is_some_and(|report| report.pressure.is_some())
            {
                self.finger = 100;
            }
            self.tick();
        }
    }
}

#[test]
fn a_ready_human_gets_the_object_through_every_step_in_order() {
    let mut bench = Bench::new();
    bench.run(60.0);
    let expected: Vec<State> = State::NAMES
        .iter()
        .map(|(state, _)| *state)
        .filter(|state| *state != State::Crashed)
        .collect();
    assert_eq!(bench.seen, expected);
    assert_eq!(bench.controller.decision(), Decision::Release);
    assert_eq!(bench.controller.commands().hand, HandCommand::Open);
    // 5 reset, 2.1 grasp, 0.5 announcement, 3 wait, 3 sensing, 1 release, and two ticks for each
    // of the five movements.
    assert!(
        (bench.clock_secs - 14.6).abs() < 0.6,
        "{} s",
        bench.clock_secs
    );
}

#[test]
fn without_an_answer_from_the_planner_the_code_crashes_after_two_seconds_and_stays_so() {
    let mut bench = Bench::new();
    bench.planner = PlannerStatus::Working;
    bench.run(60.0);
    assert_eq!(bench.controller.state(), State::Crashed);
    assert!(
        (bench.clock_secs - 7.0).abs() < 0.1,
        "{} s",
        bench.clock_secs
    );
    let frozen = bench.controller.commands().clone();
    bench.planner = PlannerStatus::Answered;
    for _ in 0..500 {
        bench.tick();
    }
    assert_eq!(
        (bench.controller.state(), bench.controller.commands()),
        (State::Crashed, &frozen)
    );
}

#[test]
fn without_activation_nothing_moves() {
    let mut bench = Bench::new();
    bench.activated = false;
    bench.run(200.0);
    assert_eq!(bench.controller.state(), State::AwaitActivation);
    assert_eq!(bench.controller.commands().planner_requests, 0);
}

#[test]
fn without_ready_or_without_tracking_the_robot_times_out_and_keeps_the_object() {
    for (ready, tracked) in [(false, true), (true, false)] {
        let mut bench = Bench::new();
        bench.ready = ready;
        if !tracked {
            bench.tracking = None;
        }
        bench.run(200.0);
        assert_eq!(bench.controller.state(), State::Done);
        assert_eq!(bench.controller.decision(), Decision::TimeOut);
        assert_eq!(bench.controller.commands().hand, HandCommand::Grasp);
        // 60 s after the announcement, or after the wait.
        let expected_secs = if ready { 71.0 } else { 68.0 };
        assert!(
            (bench.clock_secs - expected_secs).abs() < 1.5,
            "{} s",
            bench.clock_secs
        );
    }
}

#[test]
fn a_hand_that_is_elsewhere_keeps_the_object_in_the_robot_s_hand() {
    let mut bench = Bench::new();
    if let Some(tracking) = &mut bench.tracking {
        tracking.human_hand_m = [0.0; 3];
    }
    bench.run(60.0);
    assert_eq!(bench.controller.decision(), Decision::Keep);
    assert_eq!(bench.controller.commands().hand, HandCommand::Grasp);
}
