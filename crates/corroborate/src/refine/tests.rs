//! The published path of the handover's formal model, by the changes that are
//! offered and nothing else.

use super::solver::Solver;
use evidence::Subject;
use host::Cancel;
use prism_lang::Constants;
use refinement::{Counts, ModelChange, rate_of};
use std::path::{Path, PathBuf};
use study::Study;

fn handover() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../case-studies/handover")
}

fn counts(evidence: &str, count: u64, trials: u64) -> Counts {
    Counts::of_independent(evidence, count, trials).expect("counts")
}

fn states(text: &str) -> (usize, usize) {
    let tree = prism_lang::parse_model(text)
        .into_result()
        .expect("a model");
    let model = prism_lang::resolve(&tree, &Constants::new()).expect("a model");
    let space = checker::explore::explore::<f64>(&model).expect("a state space");
    (space.num_states(), space.num_transitions())
}

fn denied(sensor: &str) -> (String, String) {
    (
        format!("false_negative_{sensor}"),
        format!("{sensor}State=ok & {sensor}SensorState=notOk"),
    )
}

fn rate(sensor: &str, count: u64) -> ModelChange {
    let (mode, occurs) = denied(sensor);
    ModelChange::Rate {
        mode,
        occurs,
        counts: counts("E3", count, 98),
    }
}

fn branch(mode: &str, occurs: &str, after: &str, counts: Counts) -> ModelChange {
    ModelChange::Branch {
        subject: Subject::FailureMode(mode.into()),
        name: mode.into(),
        occurs: occurs.into(),
        after: Some(after.into()),
        at: None,
        counts,
    }
}

/// Values, states and transitions after each step: those of the published second
/// to fifth model (Webster et al. 2020, section 5), whose constants are the same
/// counts to 8 digits.
#[test]
fn the_first_model_becomes_the_fifth_by_offered_changes() {
    let study = Study::load(&handover()).expect("the handover");
    let interrupt = Cancel::default();
    let solver = Solver::new(&study, &interrupt);
    let path = Path::new("models/handover_v1.prism");
    let first = std::fs::read_to_string(handover().join(path)).expect("a model");
    let (mode, occurs) = denied("pressure");
    let once = ModelChange::Once {
        mode,
        occurs,
        counts: counts("E3", 7, 98),
    };
    let grip = branch(
        "grip_failure",
        "robotState=handoverUnsuccessful",
        "robotState=GPLOk",
        counts("E3", 2, 100),
    );
    let planner = branch(
        "runtime_error",
        "robotState=motionError",
        "true",
        counts("E4-published", 1, 500),
    );
    let sensors = vec![rate("gaze", 0), rate("pressure", 7), rate("location", 3)];
    let steps = [
        (sensors, 1.0, (31_120, 150_955)),
        (vec![once], 0.9001457729154516, (15_614, 54_969)),
        (vec![grip], 0.8821428574571426, (15_615, 54_971)),
        (vec![planner], 0.8803785717422283, (15_623, 54_998)),
    ];
    let mut text = first;
    for (changes, success, size) in steps {
        let mut values = Default::default();
        for change in changes {
            let changed = change.make(&text, &solver.at(path)).expect("a change");
            (text, values) = (changed.text, changed.values);
        }
        let value = values[&Subject::Requirement("1a".into())].expect("a value");
        assert!((value - success).abs() < 2e-9, "{value} is not {success}");
        assert_eq!(states(&text), size);
    }
    let kept = std::fs::read_to_string(handover().join(path)).expect("a model");
    let lines: Vec<&str> = text.lines().collect();
    let gone = kept.lines().filter(|line| !lines.contains(line)).count();
    // Seven definitions, two commands of the sensors with their three other
    // lines, two copies, two commands of the robot.
    assert!(gone <= 18, "{gone} lines of the first model are gone");
}

#[test]
fn a_change_that_does_not_give_the_rate_is_not_made() {
    let study = Study::load(&handover()).expect("the handover");
    let interrupt = Cancel::default();
    let solver = Solver::new(&study, &interrupt);
    let path = Path::new("models/handover_v3.prism");
    let text = std::fs::read_to_string(handover().join(path)).expect("a model");
    // Nothing that the humans module assigns is a robot's state.
    let strange = branch(
        "grip_failure",
        "noSuchState=lost",
        "true",
        counts("E3", 2, 100),
    );
    let refusal = strange
        .make(&text, &solver.at(path))
        .expect_err("no variable");
    assert!(refusal.contains("noSuchState"), "{refusal}");
    // Each is read once already, so a second latch would change nothing.
    let (mode, occurs) = denied("location");
    let again = ModelChange::Once {
        mode: mode.clone(),
        occurs,
        counts: counts("E3", 3, 98),
    };
    let changed = again.make(&text, &solver.at(path)).expect("a change");
    let rate = rate_of(&changed.values, &mode).expect("a rate");
    assert!((rate - 0.030612245).abs() < 1e-12, "{rate}");
}
