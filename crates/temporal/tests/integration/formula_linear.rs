//! Dense time with signals that go in straight lines between samples.

use crate::formulas;

use formulas::{Numbers, of_one, of_two};
use temporal::formula::{
    Ending, Formula, FormulaMonitor, FormulaReport, Interpolation, Interval, Settings, Verdict,
    parse,
};

/// Times in seconds and the value of each of two atoms.
type Trace = Vec<(f64, [f64; 2])>;

fn judge(formula: &Formula, trace: &Trace, interpolation: Interpolation) -> FormulaReport {
    let settings = Settings {
        interpolation,
        ..Settings::dense(Ending::Finite).with_robustness()
    };
    let mut judge = FormulaMonitor::compile(formula, &settings)
        .expect("sensible")
        .start();
    for (time_secs, atoms) in trace {
        judge
            .step(*time_secs, &atoms[..formula.atom_count()])
            .expect("times ascend");
    }
    judge.finish(true)
}

fn random_formula(numbers: &mut Numbers, depth: u64) -> Formula {
    if depth == 0 {
        return Formula::atom(numbers.below(2) as usize);
    }
    let low = numbers.below(3) as f64;
    let window = match numbers.below(4) {
        0 => Interval::UNBOUNDED,
        _ => Interval::secs(low, low + 1.0 + numbers.below(4) as f64),
    };
    let left = random_formula(numbers, depth - 1);
    let all = if numbers.below(2) == 0 {
        of_one(&left, &[window], false)
    } else {
        of_two(&left, &random_formula(numbers, depth - 1), &[window])
    };
    all[numbers.below(all.len() as u64) as usize].clone()
}

/// Samples some seconds apart; values are odd, so that no line is at zero at a sample.
fn random_trace(numbers: &mut Numbers) -> Trace {
    let mut time_secs = 0.0;
    let samples = 2 + numbers.below(6);
    (0..samples)
        .map(|_| {
            let mut atom = || [-3.0, -1.0, 1.0, 3.0][numbers.below(4) as usize];
            let sample = (time_secs, [atom(), atom()]);
            time_secs += [4.0, 8.0][numbers.below(2) as usize];
            sample
        })
        .collect()
}

/// The value of an atom at a time, by the line through the samples around it.
fn on_line(trace: &Trace, atom: usize, time_secs: f64) -> f64 {
    let after = trace
        .iter()
        .position(|sample| sample.0 > time_secs)
        .unwrap_or(trace.len() - 1)
        .max(1);
    let ((from, first), (to, last)) = (trace[after - 1], trace[after]);
    first[atom] + (last[atom] - first[atom]) * (time_secs - from) / (to - from)
}

/// The same signals, sampled again `rate` times a second.
fn resampled(trace: &Trace, rate: usize) -> Trace {
    let seconds = trace.last().map_or(0, |sample| sample.0 as usize);
    let at = |step: usize| {
        let time_secs = step as f64 / rate as f64;
        (
            time_secs,
            [0, 1].map(|atom| on_line(trace, atom, time_secs)),
        )
    };
    (0..=seconds * rate).map(at).collect()
}

#[test]
fn truth_changes_where_the_line_crosses_zero() {
    // From 1 to -1 within 4 s, and back: p is false from 2 s on, and true from 6 s on.
    let trace = vec![(0.0, [1.0, 0.0]), (4.0, [-1.0, 0.0]), (8.0, [1.0, 0.0])];
    let satisfied = |text: &str| {
        let formula = parse(text, &|_| None).expect("a formula").formula;
        judge(&formula, &trace, Interpolation::Linear).verdict == Verdict::Satisfied
    };
    assert!(satisfied("always[0, 1.999999999 s] p"));
    assert!(!satisfied("always[0, 2 s] p"));
    assert!(satisfied("always[2 s, 5.999999999 s] not p"));
    assert!(satisfied("always[6 s, 8 s] p"));
    assert!(satisfied(
        "always (fall(p) => eventually[4 s, 4 s] rise(p))"
    ));
}

#[test]
fn verdicts_are_those_of_the_signals_sampled_finely() {
    // Crossings lie at eighths of a tick of 8 s, or quarters of 4 s, so at whole seconds; they are
    // then samples of the finer trace, and truth between samples is that of the one before.
    let mut numbers = Numbers(2);
    let (mut satisfied, mut different) = (0, 0);
    for _ in 0..3_000 {
        let formula = random_formula(&mut numbers, 2);
        let trace = random_trace(&mut numbers);
        let fine: Trace = (resampled(&trace, 1).into_iter())
            .map(|(time_secs, atoms)| {
                // At the crossing itself the new truth begins: that of the line half a second later.
                let later = [0, 1].map(|atom| on_line(&trace, atom, time_secs + 0.5));
                let truth = [0, 1].map(|atom| {
                    if atoms[atom] == 0.0 {
                        later[atom]
                    } else {
                        atoms[atom]
                    }
                });
                (time_secs, truth)
            })
            .collect();
        let linear = judge(&formula, &trace, Interpolation::Linear).verdict;
        assert_eq!(
            linear,
            judge(&formula, &fine, Interpolation::Hold).verdict,
            "{formula} on {trace:?}"
        );
        different += usize::from(linear != judge(&formula, &trace, Interpolation::Hold).verdict);
        satisfied += usize::from(linear == Verdict::Satisfied);
    }
    assert!(
        satisfied > 300 && different > 100,
        "{satisfied} {different}"
    );
}

#[test]
fn robustness_lies_within_its_bounds() {
    let mut numbers = Numbers(6);
    // Slopes are at most 6 in 4 s, and samples 1/16 s apart.
    let tolerance = 6.0 / 4.0 / 16.0;
    let mut exact = 0;
    for _ in 0..1_000 {
        let formula = random_formula(&mut numbers, 2);
        if formula.to_string().contains("rise") || formula.to_string().contains("fall") {
            // These depend on where exactly the samples are.
            continue;
        }
        let trace = random_trace(&mut numbers);
        let bounds = judge(&formula, &trace, Interpolation::Linear)
            .robustness
            .expect("asked for");
        let fine = judge(&formula, &resampled(&trace, 16), Interpolation::Hold)
            .robustness
            .expect("asked for");
        let value = fine.value().expect("all is known");
        let what = format!("{value} is not in {bounds:?}: {formula} on {trace:?}");
        assert!(
            bounds.low - tolerance <= value && value <= bounds.high + tolerance,
            "{what}"
        );
        exact += usize::from(bounds.value().is_some());
    }
    assert!(exact > 100, "{exact}");
}

#[test]
fn extremes_over_whole_windows_are_exact() {
    let trace = vec![(0.0, [3.0, 0.0]), (4.0, [-1.0, 0.0]), (8.0, [2.0, 0.0])];
    for (text, robustness) in [
        ("always p", -1.0),
        ("eventually p", 3.0),
        ("eventually[4 s, 8 s] p", 2.0),
    ] {
        let formula = parse(text, &|_| None).expect("a formula").formula;
        let found = judge(&formula, &trace, Interpolation::Linear)
            .robustness
            .expect("asked for");
        assert_eq!(found.value(), Some(robustness), "{text}");
    }
}

#[test]
fn a_violation_is_explained_by_the_part_of_the_line() {
    let trace = vec![(0.0, [1.0, 0.0]), (4.0, [-1.0, 0.0]), (8.0, [-3.0, 0.0])];
    let formula = parse("always[0, 3 s] p", &|_| None)
        .expect("a formula")
        .formula;
    let explanation = judge(&formula, &trace, Interpolation::Linear)
        .explanation
        .expect("it is violated");
    assert_eq!((explanation.from_secs, explanation.to_secs), (2.0, 2.0));
    assert!(!explanation.atoms[0].value);
}

#[test]
fn what_has_no_line_is_held_and_what_is_unknown_stays_so() {
    let formula = parse("always[0, 3 s] p", &|_| None)
        .expect("a formula")
        .formula;
    let verdict = |last: f64| {
        let trace = vec![(0.0, [1.0, 0.0]), (4.0, [last, 0.0])];
        judge(&formula, &trace, Interpolation::Linear).verdict
    };
    assert_eq!(verdict(f64::NEG_INFINITY), Verdict::Satisfied);
    assert_eq!(verdict(-1.0), Verdict::Violated);
    assert_eq!(verdict(f64::NAN), Verdict::Inconclusive);
}
