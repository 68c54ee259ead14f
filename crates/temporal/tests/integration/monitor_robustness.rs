//! The robustness of staged monitors, by their own recursion, is that of their formulas.

use temporal::formula::{Ending, FormulaMonitor, RobustnessBounds, Settings};
use temporal::monitor::{
    AtEnd, Graded, MAX_UNBOUNDED_STAGES, Monitor, MonitorSpec, Repeat, SpaceTimeJudge, Stage,
    Trigger, Verdict,
};

/// Numbers that look random (a xorshift generator by G. Marsaglia, 2003).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: u64) -> u64 {
        (self.next() >> 11) % limit
    }
}

fn stage(numbers: &mut Numbers) -> Stage {
    let name = |number: u64| ["w", "p", "q", "r"][number as usize].to_owned();
    let within_secs = [None, None, Some(0.0), Some(0.3), Some(1.0), Some(2.5)];
    let within_secs = within_secs[numbers.below(6) as usize];
    let proposition = name(numbers.below(4));
    match numbers.below(3) {
        0 => Stage::Assert { proposition },
        1 => Stage::WaitFor {
            proposition,
            within_secs,
        },
        _ => Stage::Hold {
            proposition,
            until: name(numbers.below(4)),
            within_secs,
        },
    }
}

fn spec(numbers: &mut Numbers) -> MonitorSpec {
    let stages = 1 + numbers.below(5);
    MonitorSpec {
        trigger: [Trigger::BecomesTrue, Trigger::EachSample][numbers.below(2) as usize],
        repeat: [Repeat::EveryTrigger, Repeat::Once][numbers.below(2) as usize],
        at_end: [AtEnd::FailPending, AtEnd::InconclusivePending][numbers.below(2) as usize],
        ..MonitorSpec::new("w", (0..stages).map(|_| stage(numbers)).collect())
    }
}

type Word = Vec<(f64, Vec<f64>)>;

fn word(numbers: &mut Numbers, start_secs: f64) -> Word {
    let (mut tenths, unknown) = (0, numbers.below(3) == 0);
    let value = |numbers: &mut Numbers| match numbers.below(24) {
        0 if unknown => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::NEG_INFINITY,
        _ => numbers.below(41) as f64 - 20.0,
    };
    let sample = |_| {
        tenths += 1 + numbers.below(6);
        let values = (0..4).map(|_| value(numbers)).collect();
        (start_secs + tenths as f64 * 0.1, values)
    };
    (0..25).map(sample).collect()
}

fn of_formula(spec: &MonitorSpec, word: &Word, ending: Ending) -> RobustnessBounds {
    let staged = spec.to_formula().expect("sensible");
    let settings = Settings {
        explain_samples: 0,
        ..Settings::discrete(ending).with_robustness()
    };
    let monitor = FormulaMonitor::compile(&staged.formula, &settings).expect("sensible");
    let mut judge = monitor.start();
    for (time_secs, values) in word {
        let atoms: Vec<f64> = (staged.propositions.iter())
            .map(|name| values[position(name)])
            .collect();
        judge.step(*time_secs, &atoms).expect("times ascend");
    }
    judge.finish(true).robustness.expect("asked for")
}

fn position(name: &str) -> usize {
    let found = ["w", "p", "q", "r"].iter().position(|other| *other == name);
    found.expect("there are no others")
}

#[test]
fn it_is_that_of_the_formula_on_random_traces() {
    let mut numbers = Numbers(2_026);
    let (mut exact, mut finite) = (0, 0);
    for round in 0..6_000 {
        let spec = spec(&mut numbers);
        let word = word(&mut numbers, if round % 2 == 0 { 0.0 } else { 1.76e9 });
        let complete = round % 3 > 0;
        let monitor = Monitor::compile(&spec).expect("sensible");
        let names = monitor.propositions();
        let mut judge = monitor.start();
        let mut robustness = monitor.robustness().expect("few stages").start();
        for (time_secs, values) in &word {
            let value = |id: usize| values[position(&names[id])];
            let truth =
                |id: usize| (value(id) != 0.0 && !value(id).is_nan()).then(|| value(id) > 0.0);
            judge.step(*time_secs, &truth).expect("times ascend");
            robustness.step(*time_secs, &value).expect("times ascend");
        }
        let report = judge.finish(complete);
        let found = robustness.finish(complete, &report).expect("seen");
        let open = of_formula(&spec, &word, Ending::Inconclusive);
        let closed = of_formula(&spec, &word, Ending::Finite);
        let expected = match (complete, spec.at_end) {
            (false, _) => open,
            (true, AtEnd::FailPending) => closed,
            (true, AtEnd::InconclusivePending) => RobustnessBounds {
                low: closed.low,
                high: open.high,
            },
        };
        if found.exact {
            assert_eq!(found.bounds, expected, "{spec:?} on {word:?}");
            exact += 1;
            finite += usize::from(expected.value().is_some_and(f64::is_finite));
        } else {
            assert!(found.bounds.low >= expected.low, "{spec:?} on {word:?}");
        }
        match report.verdict {
            Verdict::Violated => assert!(found.bounds.low <= 0.0, "{spec:?} on {word:?}"),
            Verdict::Satisfied => assert!(found.bounds.high >= 0.0, "{spec:?} on {word:?}"),
            _ => {}
        }
    }
    assert!(exact > 3_000 && finite > 700, "{exact} {finite}");
}

#[test]
fn memory_is_bounded_by_the_deadlines() {
    // An unbounded stage behind one with a deadline, and more of them than the formula's engine takes.
    let hold = |p: &str, q: &str, within_secs| Stage::Hold {
        proposition: p.into(),
        until: q.into(),
        within_secs,
    };
    let spec = MonitorSpec::new(
        "w",
        vec![
            hold("p", "q", Some(2.0)),
            hold("q", "r", None),
            hold("r", "p", None),
            hold("p", "r", Some(1.0)),
            hold("w", "p", None),
            hold("p", "q", None),
            hold("q", "w", None),
        ],
    );
    let monitor = Monitor::compile(&spec).expect("sensible");
    let names = monitor.propositions();
    let mut robustness = monitor.robustness().expect("few stages").start();
    let mut numbers = Numbers(7);
    let mut most = 0;
    for sample in 0..20_000 {
        let values: Vec<f64> = (0..4).map(|_| numbers.below(201) as f64 - 100.0).collect();
        let value = |id: usize| values[position(&names[id])];
        robustness
            .step(f64::from(sample) * 0.1, &value)
            .expect("times ascend");
        most = most.max(robustness.stored());
    }
    // 31 samples of both deadlines, in each of the stages that wait for those behind, and 2^5.
    assert!(most < 2 * 8 * 31 + 32, "{most}");
}

#[test]
fn too_many_stages_without_a_deadline_are_refused_with_a_remedy() {
    let wait = Stage::WaitFor {
        proposition: "p".into(),
        within_secs: None,
    };
    let of = |count| {
        let monitor = Monitor::compile(&MonitorSpec::new("w", vec![wait.clone(); count]));
        monitor.expect("sensible").robustness()
    };
    assert!(of(MAX_UNBOUNDED_STAGES).is_ok());
    let error = of(MAX_UNBOUNDED_STAGES + 1).expect_err("too many");
    assert!(
        error
            .to_string()
            .contains("give some of them `within_secs`")
    );
}

/// The space-time robustness of a monitor on a trace; where `only_truth`, no proposition has a number.
fn space_time(
    monitor: &Monitor,
    word: &Word,
    ends_by_secs: Option<f64>,
    (complete, only_truth): (bool, bool),
) -> (Verdict, Option<f64>) {
    let names = monitor.propositions();
    let mut judge = monitor.start();
    let mut found = SpaceTimeJudge::new(monitor, ends_by_secs);
    let mut before = f64::INFINITY;
    for (time_secs, values) in word {
        let graded = |id: usize| {
            let value = values[position(&names[id])];
            Graded {
                truth: (value != 0.0 && !value.is_nan()).then_some(value > 0.0),
                degree: if only_truth { f64::INFINITY } else { value },
            }
        };
        judge
            .step(*time_secs, &|id| graded(id).truth)
            .expect("times ascend");
        found.step(*time_secs, &graded).expect("times ascend");
        let now = found.so_far().unwrap_or(f64::INFINITY);
        assert!(now <= before, "{before} rises to {now}");
        before = now;
    }
    (judge.finish(complete).verdict, found.finish(complete))
}

#[test]
fn space_time_robustness_is_negative_exactly_where_the_monitor_is_violated() {
    let mut numbers = Numbers(2_010);
    let (mut violated, mut satisfied) = (0, 0);
    for round in 0..6_000 {
        let spec = spec(&mut numbers);
        let word = word(&mut numbers, 0.0);
        let monitor = Monitor::compile(&spec).expect("sensible");
        // Late enough, too early, and unknown.
        let ends_by_secs = [Some(60.0), Some(3.0), None][round % 3];
        let how = (round % 4 > 0, round % 5 == 0);
        let (verdict, found) = space_time(&monitor, &word, ends_by_secs, how);
        let is_negative = found.is_some_and(|found| found < 0.0);
        assert_eq!(
            is_negative,
            verdict == Verdict::Violated,
            "{found:?} {spec:?} {word:?}"
        );
        assert!(found.is_none_or(|found| found.is_finite() && found != 0.0));
        let is_met = matches!(verdict, Verdict::Violated | Verdict::Satisfied);
        assert!(!is_met || found.is_some(), "{spec:?} {word:?}");
        violated += usize::from(verdict == Verdict::Violated);
        satisfied += usize::from(verdict == Verdict::Satisfied);
    }
    assert!(
        violated > 1_000 && satisfied > 300,
        "{violated} {satisfied}"
    );
}

#[test]
fn space_time_robustness_measures_time_and_numbers() {
    let (yes, no) = (f64::INFINITY, f64::NEG_INFINITY);
    let of = |stages: Vec<Stage>, ends_by_secs, word: &[(f64, [f64; 4])]| {
        let spec = MonitorSpec {
            at_end: AtEnd::FailPending,
            ..MonitorSpec::new("w", stages)
        };
        let monitor = Monitor::compile(&spec).expect("sensible");
        let word: Word = word.iter().map(|(t, v)| (*t, v.to_vec())).collect();
        space_time(&monitor, &word, ends_by_secs, (true, false)).1
    };
    let wait = |within_secs| Stage::WaitFor {
        proposition: "p".into(),
        within_secs,
    };
    let comes = [
        (0.0, [yes, no, no, no]),
        (3.0, [yes, yes, no, no]),
        (9.0, [yes, yes, no, no]),
    ];
    // A quarter of 4 s left; half of 2 s too late; of 12 s three quarters left.
    assert_eq!(of(vec![wait(Some(4.0))], None, &comes), Some(0.25));
    assert_eq!(of(vec![wait(Some(2.0))], None, &comes), Some(-0.5));
    assert_eq!(of(vec![wait(None)], Some(12.0), &comes), Some(0.75));
    // It never comes; the nearest of what is held; the time since what is asserted is so.
    assert_eq!(of(vec![wait(None)], Some(12.0), &comes[..1]), Some(-1.0));
    let hold = Stage::Hold {
        proposition: "q".into(),
        until: "p".into(),
        within_secs: None,
    };
    let held = [
        (0.0, [yes, no, 0.5, no]),
        (1.0, [yes, no, 0.125, no]),
        (2.0, [yes, yes, -3.0, no]),
    ];
    assert_eq!(of(vec![hold], Some(100.0), &held), Some(0.125));
    let assert = Stage::Assert {
        proposition: "p".into(),
    };
    let asserted = [(0.0, [no, yes, no, no]), (3.0, [yes, yes, no, no])];
    assert_eq!(of(vec![assert.clone()], None, &asserted), Some(0.75));
    // Without a trigger, how near it was.
    let near = [(0.0, [-0.5, -2.0, no, no]), (1.0, [-0.25, -2.0, no, no])];
    assert_eq!(of(vec![assert], None, &near), Some(0.25));
}
