use testbench::Distribution;
use testbench::geometry::compose;

use super::*;
use crate::purpose::Purpose;
use crate::scenario::Action;

fn action(after_secs: f64) -> Action {
    Action {
        send_signal: None,
        receive_signal: None,
        set_param: None,
        after_secs: Distribution::Constant(after_secs),
    }
}

fn human() -> Human {
    let body = Body {
        head_position_m: [1.0, 0.0, 1.5],
        hand_rest_m: [1.0, 0.0, 0.7],
        hand_on_object_m: [0.0, -0.1, -0.1],
        hand_box_m: [0.1; 3],
        reach_secs: 1.0,
        reach_lowest_object_m: 0.6,
        pull_secs: 3.0,
        pull_onset_secs: 0.5,
        pull_travel_m: 0.08,
        pull_line_m: 0.0,
        patience_secs: 20.0,
        hold_stiffness_n_m: 300.0,
        hold_damping_ns_m: 25.0,
        hold_limit_newtons: 40.0,
        hold_torque_nm_rad: 0.3,
        hold_torque_damping_nms_rad: 0.01,
    };
    let draws = HumanDraws {
        head_height_offset_m: Distribution::Constant(0.1),
        yaw_error_rad: Distribution::Constant(0.0),
        yaw_error_when_away_rad: Distribution::Constant(0.8),
        pull_forward_newtons: Distribution::Constant(6.0),
        pull_up_newtons: Distribution::Constant(8.0),
    };
    let ready = HumanParameters {
        gaze: Some(true),
        pressure: Some(true),
        location: Some(true),
    };
    let test = AbstractTest {
        name: "test".to_owned(),
        actions: vec![
            Action {
                send_signal: Some(HumanSignal::Activate),
                ..action(1.0)
            },
            Action {
                receive_signal: Some(RobotSignal::Announcement),
                ..action(0.0)
            },
            Action {
                send_signal: Some(HumanSignal::Ready),
                ..action(0.5)
            },
            Action {
                set_param: Some(ready),
                ..action(0.0)
            },
        ],
    };
    let mut stream = Stream::new(1, Purpose::Human);
    Human::new(
        &body,
        &test,
        &draws,
        &mut stream,
        Stream::new(1, Purpose::HumanTiming),
    )
}

fn view(now_secs: f64, announced: bool, object_m: Vector) -> View {
    let object = Pose {
        position_m: object_m,
        orientation: IDENTITY,
    };
    View {
        now_secs,
        announced,
        robot_lets_go: false,
        object,
    }
}

/// Runs at 100 Hz from `from` to `to` seconds.
fn run(human: &mut Human, from: u32, to: u32, announced: bool, object_m: Vector) {
    for tick in from * 100..to * 100 {
        human.update(&view(f64::from(tick) / 100.0, announced, object_m));
    }
}

#[test]
fn signals_go_out_after_their_delays_and_wait_for_the_robot() {
    let mut human = human();
    human.update(&view(0.0, false, [0.4, 0.2, 1.0]));
    assert!(!human.activated());
    run(&mut human, 0, 9, false, [0.4, 0.2, 1.0]);
    assert!(human.activated() && !human.ready());
    run(&mut human, 9, 10, true, [0.4, 0.2, 1.0]);
    assert!(human.ready() && human.applied() == [true; 3]);
}

#[test]
fn patience_ends() {
    let mut human = human();
    run(&mut human, 0, 20, false, [0.4, 0.2, 1.0]);
    assert!(!human.has_given_up());
    run(&mut human, 20, 22, false, [0.4, 0.2, 1.0]);
    assert!(human.has_given_up());
}

#[test]
fn the_pull_grows_lasts_and_ends_and_the_hand_arrives() {
    let mut human = human();
    run(&mut human, 0, 10, true, [0.4, 0.2, 1.0]);
    // Ready at 1.5 s; the pull begins there and the hand sets out.
    assert!(
        (norm(human.pull_newtons(1.75)) - 5.0).abs() < 1e-9,
        "half of hypot(6, 8)"
    );
    assert!((norm(human.pull_newtons(3.0)) - 10.0).abs() < 1e-9);
    assert_eq!(norm(human.pull_newtons(4.6)), 0.0);
    assert_eq!(human.hand_m(9.0), [0.4, 0.1, 0.9]);
    // Minimum jerk is half way at half time.
    let half_way = human.hand_m(2.0);
    assert!((half_way[0] - 0.7).abs() < 1e-6, "{half_way:?}");
}

#[test]
fn an_object_on_the_floor_is_neither_reached_for_nor_pulled() {
    let mut human = human();
    run(&mut human, 0, 10, true, [0.4, 0.2, 0.1]);
    assert_eq!(human.hand_m(9.0), [1.0, 0.0, 0.7]);
    assert_eq!(norm(human.pull_newtons(3.0)), 0.0);
}

#[test]
fn a_rotation_vector_undoes_itself() {
    let from = about([0.3, -1.0, 0.2], 0.7);
    let to = about([0.0, 0.5, 1.0], -1.9);
    let between = rotation_between(from, to);
    let turned = compose(about(between, norm(between)), from);
    let same = (0..4).map(|part| turned[part] * to[part]).sum::<f64>();
    assert!((same.abs() - 1.0).abs() < 1e-12);
}
