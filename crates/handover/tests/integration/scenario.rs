//! Bad scenarios and libraries are refused with one clear message.

use crate::common;

use handover::{Parameters, Scenario};
use testbench::Engine;

/// Parses the handover's scenario with one text replaced; gives the message.
fn refused(from: &str, to: &str) -> String {
    let text = common::handover_file("scenario.toml");
    assert!(text.contains(from), "the test's text {from} is in the file");
    let broken = text.replacen(from, to, 1);
    Scenario::parse(&broken)
        .expect_err("it must be refused")
        .to_string()
}

#[test]
fn a_misspelt_joint_names_the_pose_and_the_joint() {
    let message = refused("above = { hip_rotor", "above = { hip_roter");
    assert!(
        message.contains("robot.poses.above") && message.contains("hip_roter"),
        "{message}"
    );
}

#[test]
fn a_parent_that_is_not_there_is_named() {
    let message = refused(r#"parent = "hip_rotor""#, r#"parent = "hip""#);
    assert!(
        message.contains("body.hip_flexor.parent") && message.contains("`hip`"),
        "{message}"
    );
}

#[test]
fn an_unknown_key_gives_its_line() {
    let message = refused("time_step_secs", "timestep_secs");
    assert!(
        message.contains("timestep_secs") && message.contains("line"),
        "{message}"
    );
}

#[test]
fn a_rate_that_does_not_fit_the_time_step_is_refused() {
    assert!(refused("tracking_hz = 100", "tracking_hz = 120").contains("rates.tracking_hz"));
}

#[test]
fn an_action_with_two_verbs_is_refused() {
    let message = refused(
        r#"{ receive_signal = "announcement" }"#,
        r#"{ receive_signal = "announcement", send_signal = "ready" }"#,
    );
    assert!(message.contains("exactly one"), "{message}");
}

#[test]
fn a_probability_above_one_and_an_inverted_range_are_refused() {
    let text = common::handover_file("tuned.toml");
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "the test's text {from} is in the file");
        Parameters::parse(&text.replacen(from, to, 1))
            .expect_err("it must be refused")
            .to_string()
    };
    let message = refused("failure_rate_per_run = 0.002", "failure_rate_per_run = 2.0");
    assert!(
        message.contains("planner.failure_rate_per_run"),
        "{message}"
    );
    let message = refused("[1.0, 10.0]", "[10.0, 1.0]");
    assert!(message.contains("human.pull_up_newtons"), "{message}");
}

#[test]
fn a_library_that_is_not_there_says_what_to_run() {
    let error = Engine::load(std::path::Path::new("/nowhere/libmujoco.so")).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("/nowhere/libmujoco.so") && message.contains("tools/mujoco"),
        "{message}"
    );
}

#[test]
fn another_library_is_not_taken_for_the_engine() {
    // The C library is loadable everywhere this runs, and is not MuJoCo.
    let error = Engine::load(std::path::Path::new("libc.so.6")).unwrap_err();
    assert!(error.to_string().contains("tools/mujoco"), "{error}");
}
