//! Files of calibrations and of rare events that are wrong: each mistake is told with its line, before a physics library is
//! asked for.

use crate::support::{Copy, host};
use corroborate::{CalibrateRequest, Problem, RareRequest};

/// Fails unless the problem is told of this line of the file, or of any line of it.
fn told_at(problem: &Problem, file: &str, line: Option<usize>, message: &str) {
    let place = problem.place().expect("it has a place");
    assert!(place.name.ends_with(file), "{}", place.name);
    assert!(
        line.is_none_or(|line| line == place.line),
        "{}",
        problem.line()
    );
    let excerpt = place.excerpt.as_ref().map(|it| it.text.as_str());
    let said = [Some(problem.message()), problem.what_to_do(), excerpt];
    let said: Vec<&str> = said.into_iter().flatten().collect();
    let said = said.join("\n");
    assert!(said.contains(message), "no `{message}`: {said}");
}

#[test]
fn a_wrong_calibration_is_told_with_its_line() {
    for (old, new, message) in [
        (
            "evidence = \"E3\"",
            "evidence = \"E33\"",
            "no evidence `E33`",
        ),
        (
            "evidence = \"E3\"",
            "evidence = \"E1\"",
            "no tables of counts",
        ),
        (
            "fit = [\"grip_failure\"",
            "fit = [\"grip_failur\"",
            "did you mean `grip_failure`",
        ),
        (
            "hold_out = [\"runtime_error\"",
            "hold_out = [\"grip_failure\"",
            "named twice",
        ),
        (
            "hold_out = [\"runtime_error\"",
            "hold_out = [\"2\"",
            "was not counted",
        ),
        ("folds = 5", "folds = 1", "two folds"),
        ("folds = 5", "folds = 11", "cannot be divided"),
        (
            "hold_out_runs.folds = 5",
            "hold_out_runs.subjects = [\"11\"]",
            "no subject `11`",
        ),
        (
            "hold_out_runs.folds = 5",
            "hold_out_runs.share = 1.5",
            "not between 0 and 1",
        ),
        (
            "hold_out_runs.folds = 5",
            "hold_out_runs.sets = 5",
            "unknown",
        ),
        (
            "no_opportunity_after.false_negative_pressure = [\"grip_failure\"]",
            "",
            "not known by subject",
        ),
        (
            "no_opportunity_after.false_negative_pressure = [\"grip_failure\"]",
            "no_opportunity_after.false_negative_pressure = [\"false_negative_location\"]",
            "97 opportunities",
        ),
        (
            "parameters.hand.friction.uniform.0",
            "scenario.hand",
            "`scenario.hand`",
        ),
        (
            "uniform = [0.28, 0.6]",
            "uniform = [0.6, 0.28]",
            "lowest friction",
        ),
        (
            "inertia = \"geometry\"",
            "intertia = \"geometry\"",
            "intertia",
        ),
        (
            "episodes_per_round = 400",
            "episodes_per_round = 0",
            "no episodes",
        ),
        (
            "fit = [\"grip_failure\", \"false_negative_pressure\", \"false_negative_location\"]",
            "fit = []",
            "nothing is fitted",
        ),
    ] {
        let study = Copy::of("case-studies/handover");
        study.edit("calibration.toml", old, new);
        let request = CalibrateRequest::new(study.path(""), study.path("calibration.toml"));
        let problem = corroborate::calibrate(&request, &host(|_| false).0).expect_err(new);
        told_at(&problem, "calibration.toml", None, message);
    }
}

#[test]
fn wrong_rare_events_are_told_with_their_line() {
    let three = Some("three bad readings in a row");
    for (old, new, of, message) in [
        ("limit = 0.04", "limit = 0.01", three, "do not rise"),
        ("killed = 20", "killed = 100", three, "cannot be killed"),
        (
            "killed = 20\nreplications = 8",
            "killed = 33\nreplications = 8",
            Some("too fast in the reset"),
            "33 chains",
        ),
        ("longest = ", "largest = ", None, "largest"),
        (
            "until_secs = 4.0",
            "until_secs = -4.0",
            None,
            "`until_secs` must be more than 0 (got -4)",
        ),
        (
            "replications = 10",
            "replications = 1",
            None,
            "`replications` must be at least 2",
        ),
        ("six bad readings", "three bad readings", None, "two events"),
        ("scenario = ", "scene = ", None, "neither a scene"),
        (
            "uniform = [0.2, 0.4]",
            "uniform = [0.4, 0.2]",
            None,
            "reset speed",
        ),
    ] {
        let study = Copy::of("case-studies/handover");
        study.edit("rare.toml", old, new);
        let text = std::fs::read_to_string(study.path("rare.toml")).expect("a text");
        let names = |name: &str| {
            text.lines()
                .position(|line| line.contains(&format!("\"{name}\"")))
        };
        let line = of.map(|name| names(name).expect("an event") + 1);
        let request = RareRequest::new(study.path(""), study.path("rare.toml"));
        let problem = corroborate::rare(&request, &host(|_| false).0).expect_err(new);
        told_at(&problem, "rare.toml", line, message);
    }
    let study = Copy::of("case-studies/handover");
    let mut request = RareRequest::new(study.path(""), study.path("rare.toml"));
    request.only.push("three in a row".into());
    let problem = corroborate::rare(&request, &host(|_| false).0).expect_err("unknown");
    assert_eq!(problem.code, "bad-rare-event");
    let remedy = problem.what_to_do().expect("a remedy");
    assert!(remedy.contains("three bad readings in a row"), "{remedy}");
}
