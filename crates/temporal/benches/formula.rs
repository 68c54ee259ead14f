//! How many samples a second the engine for discrete time judges.
//!
//! Run with `cargo bench -p corroborate-temporal`. Every case judges a million samples, counts the triggers and
//! keeps the last 10,000 samples to explain a violation; none is decided before the end, so nothing
//! is skipped. Signals: `busy` changes at random at every
//! sample; `calm` has a request every two windows, answered just before its deadline; `idle` never
//! changes. For "until", `busy` has its left operand true except at its answers.

use divan::Bencher;
use divan::counter::ItemsCount;
use temporal::formula::{Ending, FormulaMonitor, Settings, parse};
use temporal::monitor::{Monitor, MonitorSpec, Stage};

fn main() {
    divan::main();
}

const SAMPLES: usize = 1_000_000;

/// A signal of two atoms, a hundredth of a second apart.
struct Signal {
    name: &'static str,
    values: Vec<[f64; 2]>,
}

/// Numbers in [0, 1) that do not repeat soon (xorshift).
fn noise() -> impl FnMut() -> f64 {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Requests and answers, where every request is answered within `window` samples.
fn requests(window: usize) -> Vec<Signal> {
    let mut random = noise();
    let busy = (0..SAMPLES)
        .map(|at| {
            let request = random() - 0.5;
            let answer = if at % (window / 2) == 0 { 1.0 } else { -1.0 };
            [request, answer * (0.1 + random())]
        })
        .collect();
    let calm = (0..SAMPLES)
        .map(|at| {
            let phase = at % (2 * window);
            let request = if phase == 0 { 1.0 } else { -1.0 };
            let answer = if phase == window - 1 { 1.0 } else { -1.0 };
            [request * (0.1 + random()), answer * (0.1 + random())]
        })
        .collect();
    let idle = (0..SAMPLES)
        .map(|_| [-0.1 - random(), -0.1 - random()])
        .collect();
    named(busy, calm, idle)
}

fn named(busy: Vec<[f64; 2]>, calm: Vec<[f64; 2]>, idle: Vec<[f64; 2]>) -> Vec<Signal> {
    [("busy", busy), ("calm", calm), ("idle", idle)]
        .into_iter()
        .map(|(name, values)| Signal { name, values })
        .collect()
}

/// Two signals of which the first holds until the second comes, within `window` samples.
fn holds(window: usize) -> Vec<Signal> {
    let mut random = noise();
    let mut hold = |period: usize, also: bool| -> Vec<[f64; 2]> {
        (0..SAMPLES)
            .map(|at| {
                let reached = at % period == period - 1;
                let held = if reached && !also { -1.0 } else { 1.0 };
                let reached = if reached { 1.0 } else { -1.0 };
                [held * (0.1 + random()), reached * (0.1 + random())]
            })
            .collect()
    };
    let (busy, calm, idle) = (hold(2, false), hold(window / 2, false), hold(window, true));
    named(busy, calm, idle)
}

/// How samples are given.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    OneByOne,
    InColumns,
}
use Given::{InColumns, OneByOne};

fn judge(bencher: Bencher<'_, '_>, text: &str, given: Given, robustness: bool, signal: &Signal) {
    let formula = parse(text, &|_| None)
        .expect("the formula is right")
        .formula;
    let settings = Settings {
        robustness,
        ..Settings::discrete(Ending::Inconclusive)
    };
    let monitor = FormulaMonitor::compile(&formula, &settings).expect("the formula is right");
    let times_secs: Vec<f64> = (0..SAMPLES).map(|at| at as f64 * 0.01).collect();
    let columns = [0, 1].map(|atom| signal.values.iter().map(|it| it[atom]).collect::<Vec<_>>());
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut judge = monitor.start();
        if given == InColumns {
            let columns = [columns[0].as_slice(), columns[1].as_slice()];
            let columns = divan::black_box(&columns);
            judge.step_many(&times_secs, columns).expect("times ascend");
        } else {
            for (time_secs, values) in times_secs.iter().zip(&signal.values) {
                let step = judge.step(*time_secs, divan::black_box(values));
                step.expect("times ascend");
            }
        }
        assert_eq!(judge.verdict(), None, "the signal {} decides", signal.name);
        judge.finish(true)
    });
}

/// Window or period in samples, signal, how it is given, and whether robustness is computed.
type Case = (usize, usize, Given, bool);

fn cases(windows: &[usize]) -> Vec<Case> {
    let mut cases = Vec::new();
    for robustness in [false, true] {
        for given in [OneByOne, InColumns] {
            for &window in windows {
                cases.extend((0..3).map(|signal| (window, signal, given, robustness)));
            }
        }
    }
    cases
}

/// `always (request => eventually[0, window] answer)`.
#[divan::bench(args = cases(&[50, 5_000]), sample_count = 5)]
fn response(bencher: Bencher<'_, '_>, (window, signal, given, robustness): Case) {
    let text = format!("always (request => eventually[0, {window} samples] answer)");
    judge(bencher, &text, given, robustness, &requests(window)[signal]);
}

/// The same with a window in seconds.
#[divan::bench(args = cases(&[50, 5_000]), sample_count = 5)]
fn response_in_seconds(bencher: Bencher<'_, '_>, (window, signal, given, robustness): Case) {
    let text = format!("always (request => eventually[0, {window}0 ms] answer)");
    judge(bencher, &text, given, robustness, &requests(window)[signal]);
}

/// `held until[0, 1000] reached` at every sample.
#[divan::bench(args = cases(&[1_000]), sample_count = 5)]
fn until(bencher: Bencher<'_, '_>, (window, signal, given, robustness): Case) {
    let text = format!("always (held until[0, {window} samples] reached)");
    judge(bencher, &text, given, robustness, &holds(window)[signal]);
}

/// The bounds of the robustness after every sample of `always (request => eventually[0, window]
/// answer)`, or of `always (held until[0, window] reached)`, for which what is stored is copied.
#[divan::bench(args = [(50, true), (5_000, true), (50, false)], sample_count = 3)]
fn bounds_at_every_sample(bencher: Bencher<'_, '_>, (window, response): (usize, bool)) {
    let (text, signals) = if response {
        let text = format!("always (request => eventually[0, {window} samples] answer)");
        (text, requests(window))
    } else {
        let text = format!("always (held until[0, {window} samples] reached)");
        (text, holds(window))
    };
    let formula = parse(&text, &|_| None)
        .expect("the formula is right")
        .formula;
    let settings = Settings::discrete(Ending::Inconclusive).with_robustness();
    let monitor = FormulaMonitor::compile(&formula, &settings).expect("the formula is right");
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut judge = monitor.start();
        for (at, values) in signals[1].values.iter().enumerate() {
            judge.step(at as f64 * 0.01, values).expect("times ascend");
            divan::black_box(judge.robustness_bounds());
        }
    });
}

/// The robustness of stages: a hold without a deadline, then a wait of so many samples; triggered
/// whenever the robustness of the first proposition becomes positive.
#[divan::bench(args = [50, 5_000], sample_count = 3)]
fn stages(bencher: Bencher<'_, '_>, window: usize) {
    let spec = MonitorSpec::new(
        "request",
        vec![
            Stage::Hold {
                proposition: "held".into(),
                until: "answer".into(),
                within_secs: None,
            },
            Stage::WaitFor {
                proposition: "answer".into(),
                within_secs: Some(window as f64 * 0.01),
            },
        ],
    );
    let monitor = Monitor::compile(&spec).expect("the monitor is right");
    let robustness = monitor.robustness().expect("there are two stages");
    let signal = &requests(window)[1];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut judge = robustness.start();
        for (at, [request, answer]) in signal.values.iter().enumerate() {
            let values = [*request, 1.0, *answer];
            let step = judge.step(at as f64 * 0.01, &|proposition| values[proposition]);
            step.expect("times ascend");
        }
        judge.stored()
    });
}
