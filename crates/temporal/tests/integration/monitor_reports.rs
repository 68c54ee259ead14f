//! What monitors say: files, errors, first failures, recordings that were cut short.

use temporal::monitor::{
    Failure, FailureReason, Monitor, MonitorReport, MonitorSpec, SpecError, Stage, Verdict,
};

/// The monitor of the handover: the object stays in the hand until sensing is done, then the
/// sensors are satisfied, the robot decides and has released.
const HANDOVER: &str = r#"
    when = "grasps"
    then = [
        { hold = "in_hand", until = "sensed" },
        { assert = "sensors_ok" },
        { wait_for = "decided", within_secs = 5 },
        { assert = "released" },
    ]
    repeat = "once"
    at_end = "fail_pending"
"#;

fn monitor(text: &str) -> Monitor {
    let spec: MonitorSpec = toml::from_str(text).expect("the text is a monitor");
    let again = toml::to_string(&spec).expect("it can be written");
    assert_eq!(
        toml::from_str::<MonitorSpec>(&again).expect("it can be read again"),
        spec
    );
    Monitor::compile(&spec).expect("the monitor makes sense")
}

/// Judges a word in which each sample lists the propositions that are true there.
fn judge(text: &str, word: &[(f64, &[&str])], complete: bool) -> MonitorReport {
    let monitor = monitor(text);
    let names = monitor.propositions();
    let samples = word.iter().map(|&(time_secs, truths)| {
        (time_secs, move |proposition: usize| {
            Some(truths.contains(&names[proposition].as_str()))
        })
    });
    monitor
        .judge(samples, complete)
        .expect("the times are in order")
}

#[test]
fn a_handover_that_succeeds() {
    let word: [(f64, &[&str]); 5] = [
        (0.0, &[]),
        (1.0, &["grasps", "in_hand"]),
        (2.0, &["grasps", "in_hand"]),
        (3.0, &["sensed", "sensors_ok"]),
        (8.0, &["decided", "released"]),
    ];
    let report = judge(HANDOVER, &word, true);
    assert_eq!(
        (report.triggered, report.passed, report.verdict),
        (1, 1, Verdict::Satisfied)
    );
    assert_eq!(report.first_failure, None);
    // Nothing can follow, so that it does not matter that the recording was cut short.
    assert_eq!(judge(HANDOVER, &word, false).verdict, Verdict::Satisfied);
    assert_eq!(
        judge(HANDOVER, &word[..4], false).verdict,
        Verdict::Inconclusive
    );
    assert_eq!(
        judge(HANDOVER, &word[..1], false).verdict,
        Verdict::NotCovered
    );
}

#[test]
fn each_way_to_fail_names_its_place() {
    let failure = |word: &[(f64, &[&str])]| {
        let report = judge(HANDOVER, word, true);
        assert_eq!((report.failed, report.verdict), (1, Verdict::Violated));
        report.first_failure.expect("it failed")
    };
    let expected = |time_secs, stage, proposition: &str, seen_false: (f64, f64), reason| Failure {
        time_secs,
        stage,
        proposition: proposition.to_owned(),
        triggered_at_secs: 1.0,
        false_from_secs: seen_false.0,
        false_to_secs: seen_false.1,
        reason,
    };
    let grasp: (f64, &[&str]) = (1.0, &["grasps", "in_hand"]);
    let sensed: (f64, &[&str]) = (3.0, &["sensed", "sensors_ok"]);
    let dropped = failure(&[grasp, (2.0, &[]), sensed]);
    assert_eq!(
        dropped,
        expected(2.0, 0, "in_hand", (2.0, 2.0), FailureReason::HoldBroken)
    );
    let refused = failure(&[grasp, (3.0, &["sensed"])]);
    assert_eq!(
        refused,
        expected(
            3.0,
            1,
            "sensors_ok",
            (3.0, 3.0),
            FailureReason::AssertedFalse
        )
    );
    let late = failure(&[grasp, sensed, (8.5, &["decided", "released"])]);
    // It was true then, but late: it was false from the beginning of the stage to the deadline.
    assert_eq!(
        late,
        expected(8.5, 2, "decided", (3.0, 8.0), FailureReason::Deadline)
    );
    let kept = failure(&[grasp, sensed, (8.0, &["decided"])]);
    assert_eq!(
        kept,
        expected(8.0, 3, "released", (8.0, 8.0), FailureReason::AssertedFalse)
    );
    let ended = failure(&[grasp, (2.0, &["in_hand"])]);
    assert_eq!(
        ended,
        expected(2.0, 0, "sensed", (1.0, 2.0), FailureReason::EndOfTrace)
    );
}

#[test]
fn a_deadline_is_met_on_time_in_spite_of_rounding() {
    let text = "when = \"go\"\nthen = [{ wait_for = \"done\", within_secs = 0.1 }]\n";
    let mut late = 0;
    for start in 0..10_000 {
        let begin = f64::from(start) * 0.05;
        let end = f64::from(start + 2) * 0.05;
        late += u32::from(end - begin > 0.1);
        let report = judge(text, &[(begin, &["go"]), (end, &["done"])], true);
        assert_eq!(report.verdict, Verdict::Satisfied, "from {begin} to {end}");
        let after = end + 1e-6;
        let report = judge(text, &[(begin, &["go"]), (after, &["done"])], true);
        assert_eq!(report.verdict, Verdict::Violated, "from {begin} to {after}");
    }
    assert!(
        late > 1000,
        "plain subtraction would have called {late} of them late"
    );
}

#[test]
fn invariants_are_judged_at_each_sample() {
    let monitor = Monitor::compile(&MonitorSpec::invariant("near", "slow")).unwrap();
    let word = [
        (0.0, [Some(false), Some(false)]),
        (0.1, [Some(true), Some(true)]),
        (0.2, [None, Some(false)]),
        (0.3, [Some(true), None]),
        (0.4, [Some(true), Some(false)]),
        (0.5, [Some(true), Some(false)]),
    ];
    let samples = word.map(|(time_secs, values)| (time_secs, move |id: usize| values[id]));
    let report = monitor.judge(samples, true).unwrap();
    assert_eq!((report.triggered, report.passed, report.failed), (4, 1, 2));
    assert_eq!((report.inconclusive, report.when_unknown), (1, 1));
    assert_eq!(report.first_failure.unwrap().time_secs, 0.4);
    let report = monitor.judge(samples[..2].to_vec(), true).unwrap();
    assert_eq!(report.verdict, Verdict::Satisfied);
    let report = monitor.judge(samples[..4].to_vec(), true).unwrap();
    assert_eq!(report.verdict, Verdict::Inconclusive);
}

#[test]
fn samples_must_come_in_order() {
    let monitor = Monitor::compile(&MonitorSpec::invariant("a", "b")).unwrap();
    let mut judge = monitor.start();
    let all = |_: usize| Some(true);
    judge.step(1.0, &all).unwrap();
    for bad in [1.0, 0.5, f64::NAN, f64::INFINITY] {
        assert!(judge.step(bad, &all).is_err(), "{bad}");
    }
    judge.step(1.5, &all).unwrap();
    assert_eq!(judge.finish(true).passed, 2);
}

#[test]
fn specifications_that_make_no_sense_are_refused() {
    let message = |text: &str| toml::from_str::<MonitorSpec>(text).unwrap_err().to_string();
    let stage = |stage: &str| message(&format!("when = \"a\"\nthen = [{stage}]\n"));
    assert!(stage("{}").contains("must be exactly one of"));
    assert!(stage("{ assert = \"a\", wait_for = \"b\" }").contains("must be exactly one of"));
    assert!(stage("{ hold = \"a\" }").contains("must say until when"));
    assert!(stage("{ assert = \"a\", within_secs = 1 }").contains("use \"wait_for\""));
    assert!(stage("{ await = \"a\" }").contains("unknown field"));
    assert!(message("then = []").contains("missing field `when`"));
    assert!(message("when = \"a\"\nthen = []\nrepeat = \"twice\"").contains("every_trigger"));

    let compile = |spec| Monitor::compile(&spec).unwrap_err();
    assert_eq!(compile(MonitorSpec::new("a", vec![])), SpecError::NoStages);
    assert_eq!(
        compile(MonitorSpec::invariant("a", " ")),
        SpecError::EmptyProposition
    );
    let wait = Stage::WaitFor {
        proposition: "b".into(),
        within_secs: Some(-1.0),
    };
    let error = compile(MonitorSpec::new("a", vec![wait]));
    assert!(matches!(error, SpecError::BadWithin { .. }));
}
