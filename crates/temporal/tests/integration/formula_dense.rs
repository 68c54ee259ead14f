//! The engine for dense time against the definition, and the definition against a finer grid.

use crate::formulas;

use formulas::{Numbers, of_one, of_two, small, windows};
use temporal::formula::semantics::dense::{TickWord, value};
use temporal::formula::{
    Ending, Formula, FormulaMonitor, Interval, RobustnessBounds, Settings, TimeModel, Verdict,
    Window,
};

const ENDINGS: [Ending; 4] = [
    Ending::Inconclusive,
    Ending::Weak,
    Ending::Strong,
    Ending::Finite,
];

/// A trace: ticks, and the value of each of two atoms there, NaN for unknown.
type Trace = Vec<(usize, [f64; 2])>;

fn word(trace: &[(usize, [f64; 2])], truth: bool) -> TickWord {
    let bounds = |value: &f64| {
        let exact = RobustnessBounds::of_value(*value);
        if truth {
            RobustnessBounds::of_truth(exact.truth())
        } else {
            exact
        }
    };
    TickWord {
        ticks: trace.iter().map(|sample| sample.0).collect(),
        atoms: trace
            .iter()
            .map(|sample| sample.1.iter().map(bounds).collect())
            .collect(),
    }
}

/// Judges a trace by the engine and compares everything with the definition. Returns whether the
/// verdict came later than it could, and whether there was an early one.
fn compare(formula: &Formula, trace: &[(usize, [f64; 2])], ending: Ending) -> (bool, bool) {
    let settings = Settings::dense(ending).with_robustness();
    let what = || format!("{formula} on {trace:?} with {ending:?}");
    let mut judge = FormulaMonitor::compile(formula, &settings)
        .expect("it is sensible")
        .start();
    let mut late = false;
    let count = formula.atom_count();
    for (index, (tick, atoms)) in trace.iter().enumerate() {
        let verdict = judge
            .step(100.0 + *tick as f64, &atoms[..count])
            .expect("times ascend")
            .verdict;
        let prefix =
            value(formula, &word(&trace[..=index], true), Ending::Inconclusive).expect("as above");
        let seen = word(&trace[..=index], false);
        let bounds = value(formula, &seen, Ending::Inconclusive).expect("as above");
        assert_eq!(
            judge.robustness_bounds(),
            Some(bounds),
            "after {index}: {}",
            what()
        );
        match verdict {
            Some(verdict) => assert_eq!(verdict, prefix.verdict(), "after {index}: {}", what()),
            None => late |= prefix.truth().is_some(),
        }
    }
    let early = judge.verdict();
    let report = judge.finish(true);
    let truth = value(formula, &word(trace, true), ending).expect("as above");
    let verdict = if report.verdict == Verdict::NotCovered {
        assert!(report.triggered == 0 && truth.truth() != Some(false));
        truth.verdict()
    } else {
        report.verdict
    };
    assert_eq!(verdict, truth.verdict(), "{}", what());
    assert!(early.is_none_or(|early| early == verdict), "{}", what());
    let robustness = value(formula, &word(trace, false), ending).expect("as above");
    assert_eq!(report.robustness, Some(robustness), "{}", what());
    (late, early.is_some())
}

/// All traces of up to three samples one or two ticks apart, over atoms that are true, false or unknown.
fn short_traces() -> Vec<Trace> {
    let letters: Vec<[f64; 2]> = [3.0, -2.0, f64::NAN]
        .into_iter()
        .flat_map(|first| [5.0, -1.0, f64::NAN].map(|second| [first, second]))
        .collect();
    let mut all: Vec<Trace> = letters.iter().map(|letter| vec![(0, *letter)]).collect();
    let mut last = all.clone();
    for _ in 0..2 {
        let longer = last.iter().flat_map(|trace| {
            let end = trace.last().map_or(0, |sample| sample.0);
            letters.iter().flat_map(move |letter| {
                [1, 2].map(|gap| {
                    let mut longer = trace.clone();
                    longer.push((end + gap, *letter));
                    longer
                })
            })
        });
        last = longer.collect();
        all.extend(last.iter().cloned());
    }
    all
}

#[test]
fn formulas_with_one_operator_on_all_short_traces() {
    let (one, _) = small(&windows(), false);
    let traces = short_traces();
    let mut early = 0;
    for (number, formula) in one.iter().enumerate() {
        // Every trace, and over all formulas every ending for each.
        for (index, trace) in traces.iter().enumerate() {
            let (late, soon) = compare(formula, trace, ENDINGS[(number + index) % 4]);
            assert!(!late, "{formula} on {trace:?}");
            early += usize::from(soon);
        }
    }
    assert!(
        early > one.len(),
        "verdicts must come early where they can: {early}"
    );
}

#[test]
fn formulas_with_two_operators_on_some_traces_each() {
    let (_, two) = small(&windows(), false);
    let mut numbers = Numbers(1);
    let mut late = 0usize;
    for formula in &two {
        for _ in 0..6 {
            let ending = ENDINGS[numbers.below(4) as usize];
            late += usize::from(compare(formula, &random_trace(&mut numbers, 5), ending).0);
        }
    }
    // The verdict may come late, but seldom does.
    assert!(
        late * 20 < two.len() * 6,
        "late in {late} of {}",
        two.len() * 6
    );
}

fn random_trace(numbers: &mut Numbers, longest: u64) -> Trace {
    let mut tick = 0;
    let samples = 1 + numbers.below(longest);
    (0..samples)
        .map(|index| {
            tick += if index == 0 {
                0
            } else {
                1 + numbers.below(3) as usize
            };
            let mut atom = || match numbers.below(9) {
                0 => f64::NAN,
                number => number as f64 - 4.5,
            };
            (tick, [atom(), atom()])
        })
        .collect()
}

fn random_formula(numbers: &mut Numbers, depth: u64) -> Formula {
    random_formula_in(numbers, depth, 1.0)
}

/// The same with windows that begin and end at multiples of `unit_secs`.
fn random_formula_in(numbers: &mut Numbers, depth: u64, unit_secs: f64) -> Formula {
    if depth == 0 || numbers.below(6) == 0 {
        return Formula::atom(numbers.below(2) as usize);
    }
    let low = numbers.below(3) as f64;
    let window = match numbers.below(4) {
        0 => Interval::UNBOUNDED,
        _ => {
            let high = low + numbers.below(4) as f64;
            Interval::secs(low * unit_secs, high * unit_secs)
        }
    };
    let left = random_formula_in(numbers, depth - 1, unit_secs);
    let all = if numbers.below(2) == 0 {
        of_one(&left, &[window], false)
    } else {
        of_two(
            &left,
            &random_formula_in(numbers, depth - 1, unit_secs),
            &[window],
        )
    };
    all[numbers.below(all.len() as u64) as usize].clone()
}

#[test]
fn random_larger_formulas_on_longer_traces() {
    let mut numbers = Numbers(7);
    for _ in 0..6_000 {
        let formula = random_formula(&mut numbers, 4);
        let trace = random_trace(&mut numbers, 12);
        compare(&formula, &trace, ENDINGS[numbers.below(4) as usize]);
    }
}

#[test]
fn triggers_are_counted_by_their_intervals_of_holding() {
    let mut numbers = Numbers(13);
    let (mut counted, mut open) = (0, 0);
    for _ in 0..2_000 {
        // With windows and samples at even ticks, an odd one stands for all times around it.
        let trigger = random_formula_in(&mut numbers, 2, 2.0);
        let mut trace = random_trace(&mut numbers, 6);
        trace.iter_mut().for_each(|sample| sample.0 *= 2);
        let ending = [Ending::Inconclusive, Ending::Finite][numbers.below(2) as usize];
        let formula = Formula::always(
            Interval::UNBOUNDED,
            Formula::implies(trigger.clone(), Formula::atom(1)),
        );
        let settings = Settings::dense(ending);
        let monitor = FormulaMonitor::compile(&formula, &settings).expect("sensible");
        let mut judge = monitor.start();
        for (tick, atoms) in &trace {
            judge.step(*tick as f64, atoms).expect("times ascend");
        }
        let report = judge.finish(true);
        let last = trace.last().map_or(0, |sample| sample.0);
        let truth = |tick: usize| {
            let there = Interval::secs(tick as f64, tick as f64);
            let then = Formula::eventually(there, trigger.clone());
            let bounds = value(&then, &word(&trace, true), ending).expect("sensible");
            bounds.truth()
        };
        let truths: Vec<Option<bool>> = (0..=last).map(truth).collect();
        let begins = |tick: &usize| {
            let from_false = *tick == 0 || truths[tick - 1] == Some(false);
            truths[*tick] == Some(true) && from_false
        };
        let expected = (0..=last).filter(begins).count() as u64;
        assert_eq!(
            report.triggered, expected,
            "{trigger} on {trace:?} with {ending:?}"
        );
        counted += expected;
        open += (0..=last)
            .filter(begins)
            .filter(|tick| tick % 2 == 1)
            .count();
    }
    assert!(counted > 1_000 && open > 10, "{counted} {open}");
}

/// Both models of time, where samples are on a grid of 0.1 s that binary numbers do not have, from
/// zero and from times of the calendar.
#[test]
fn deadlines_on_a_decimal_grid_are_met_at_all_times() {
    let parse = |text: &str| temporal::formula::parse(text, &|_| None).expect("a formula");
    let formula = parse("always (p => eventually[0.2 s, 0.3 s] q)").formula;
    for first_secs in [0.0, 3.3, 4_000_000.7, 1.76e9] {
        for begin in 0..50_u32 {
            for delay in 0..6_u32 {
                let settings = [
                    Settings::dense(Ending::Finite),
                    Settings::discrete(Ending::Finite),
                ];
                for settings in settings {
                    let monitor = FormulaMonitor::compile(&formula, &settings).expect("sensible");
                    let mut judge = monitor.start();
                    for step in begin..begin + 8 {
                        let atoms = [step == begin, step == begin + delay].map(Some);
                        let time_secs = first_secs + f64::from(step) * 0.1;
                        judge.step_truth(time_secs, &atoms).expect("times ascend");
                    }
                    // In dense time, q from 0.1 s after p on lasts until just before 0.2 s.
                    let expected = match delay {
                        2 | 3 => Verdict::Satisfied,
                        _ => Verdict::Violated,
                    };
                    let time = settings.time;
                    let found = judge.finish(true).verdict;
                    assert_eq!(
                        found, expected,
                        "{time:?}, {first_secs} s + {begin} + {delay}"
                    );
                }
            }
        }
    }
}

/// The definition counts in whole ticks; the engine is given tenths of seconds at other times.
#[test]
fn formulas_on_a_decimal_grid_are_judged_as_defined() {
    let mut numbers = Numbers(21);
    for round in 0..4_000 {
        let seed = numbers.below(1 << 40) + 1;
        let formula = random_formula_in(&mut Numbers(seed), 3, 1.0);
        let in_tenths = random_formula_in(&mut Numbers(seed), 3, 0.1);
        let trace = random_trace(&mut numbers, 8);
        let ending = ENDINGS[numbers.below(4) as usize];
        let settings = Settings {
            trigger: Some(Formula::True),
            ..Settings::dense(ending).with_robustness()
        };
        let monitor = FormulaMonitor::compile(&in_tenths, &settings).expect("sensible");
        let mut judge = monitor.start();
        let first_secs = [0.0, 17.3, 1_760_000_000.1][round % 3];
        let count = formula.atom_count();
        for (tick, atoms) in &trace {
            let time_secs = first_secs + *tick as f64 * 0.1;
            judge
                .step(time_secs, &atoms[..count])
                .expect("times ascend");
        }
        let report = judge.finish(true);
        let what = || format!("{formula} on {trace:?} with {ending:?} from {first_secs} s");
        let truth = value(&formula, &word(&trace, true), ending).expect("sensible");
        assert_eq!(report.verdict, truth.verdict(), "{}", what());
        let robustness = value(&formula, &word(&trace, false), ending).expect("sensible");
        assert_eq!(report.robustness, Some(robustness), "{}", what());
    }
}

/// Truth by the definition itself at points `GRID` to a tick: the quantifiers range over grid points
/// instead of all times. With a grid fine enough for the nesting, that is the same. (Complete traces.)
const GRID: usize = 8;

fn truth_on_grid(formula: &Formula, trace: &[(usize, [f64; 2])]) -> Vec<bool> {
    let count = trace.last().map_or(0, |sample| sample.0 * GRID + 1);
    let of = |formula: &Formula| truth_on_grid(formula, trace);
    let distances = |interval: &Interval| match interval.window(TimeModel::Dense) {
        Ok(Window::Seconds {
            low_secs,
            high_secs,
        }) => {
            let points = |secs: f64| secs.min(1e6) as usize * GRID;
            (points(low_secs), points(high_secs))
        }
        other => panic!("{other:?}"),
    };
    let until = |interval: &Interval, left: Vec<bool>, right: Vec<bool>| -> Vec<bool> {
        let (low, high) = distances(interval);
        let at = |at: usize| {
            (at + low..=(at + high).min(count - 1))
                .any(|end| right[end] && left[at..end].iter().all(|held| *held))
        };
        (0..count).map(at).collect()
    };
    let since = |interval: &Interval, left: Vec<bool>, right: Vec<bool>| -> Vec<bool> {
        let (low, high) = distances(interval);
        let at = |at: usize| {
            (at.saturating_sub(high)..=at)
                .filter(|begin| begin + low <= at)
                .any(|begin| right[begin] && left[begin + 1..=at].iter().all(|held| *held))
        };
        (0..count).map(at).collect()
    };
    let not = |values: Vec<bool>| -> Vec<bool> { values.into_iter().map(|value| !value).collect() };
    let all = vec![true; count];
    match formula {
        Formula::Atom(atom) => (0..count)
            .map(|at| {
                let sample = trace
                    .iter()
                    .rposition(|sample| sample.0 * GRID <= at)
                    .expect("traces begin at 0");
                trace[sample].1[atom.0] > 0.0
            })
            .collect(),
        Formula::Not(inner) => not(of(inner)),
        Formula::Eventually(interval, inner) => until(interval, all, of(inner)),
        Formula::Always(interval, inner) => not(until(interval, all, not(of(inner)))),
        Formula::Once(interval, inner) => since(interval, all, of(inner)),
        Formula::Historically(interval, inner) => not(since(interval, all, not(of(inner)))),
        Formula::Until(interval, left, right) => until(interval, of(left), of(right)),
        Formula::Release(interval, left, right) => {
            not(until(interval, not(of(left)), not(of(right))))
        }
        Formula::Since(interval, left, right) => since(interval, of(left), of(right)),
        other => panic!("{other} is not needed here"),
    }
}

#[test]
fn places_stand_for_all_times() {
    let mut numbers = Numbers(11);
    let mut compared = 0;
    while compared < 3_000 {
        let formula = random_formula(&mut numbers, 2);
        let trace: Trace = (random_trace(&mut numbers, 4).into_iter())
            .map(|(tick, atoms)| {
                (
                    tick,
                    atoms.map(|atom| if atom.is_nan() { -1.0 } else { atom }),
                )
            })
            .collect();
        if has_other_operators(&formula) {
            continue;
        }
        compared += 1;
        let by_places = value(&formula, &word(&trace, true), Ending::Finite).expect("sensible");
        let on_grid = truth_on_grid(&formula, &trace)[0];
        assert_eq!(by_places.truth(), Some(on_grid), "{formula} on {trace:?}");
    }
}

fn has_other_operators(formula: &Formula) -> bool {
    matches!(
        formula,
        Formula::And(_)
            | Formula::Or(_)
            | Formula::Implies(..)
            | Formula::Iff(..)
            | Formula::WeakUntil(..)
            | Formula::Rise(_)
            | Formula::Fall(_)
    ) || formula.operands().into_iter().any(has_other_operators)
}

/// Formulas as people write them, on traces with known and unknown values.
#[test]
fn formulas_written_by_hand_are_judged_as_defined() {
    let texts = [
        "always (p => eventually[0, 2 s] q)",
        "always (rise(p) => (not q until[1 s, 3 s] q))",
        "always (p => always[0, 2 s] not q)",
        "always (rise(p) => eventually[0, 1 s] always[0, 2 s] q)",
        "always (fall(p) => once[0, 2 s] q)",
        "always (q => historically[0, 1 s] p)",
        "always (q => (p since[0, 3 s] rise(p)))",
        "eventually always p",
        "always eventually q",
        "p until (q and eventually[1 s, 2 s] not p)",
        "(not p) weak_until q",
        "q release[0, 4 s] p",
        "always ((p and not q) => ((p until[0, 2 s] q) or always[0, 2 s] not q))",
        "always (rise(p) => ((p and not q) until[0, 3 s] (q and eventually[0, 1 s] not p)))",
        "(eventually[0, 3 s] p) <=> (eventually[1 s, 2 s] q)",
        "not ((p until[0, 1 s] q) and (q until[2 s, 2 s] p))",
        "always[1 s, 4 s] (once[1 s, 1 s] p => eventually[1 s, 1 s] q)",
        "always (p => (q or eventually[0, 2 s] (q and historically[0, 1 s] not p)))",
    ];
    let mut numbers = Numbers(31);
    for text in texts {
        let parsed = temporal::formula::parse(text, &|_| None).expect("a formula");
        // Atoms are numbered as they come; p is the first of the trace in any case.
        let swapped = parsed.atoms[0].text == "q";
        for round in 0..300 {
            let mut trace = random_trace(&mut numbers, 9);
            if swapped {
                trace.iter_mut().for_each(|sample| sample.1.swap(0, 1));
            }
            compare(&parsed.formula, &trace, ENDINGS[round % 4]);
        }
    }
}

#[test]
fn memory_is_bounded_by_the_windows() {
    let text = "always (p => eventually[0, 2 s] (q and once[0, 1 s] p)) and always historically[0, 3 s] (p or q)";
    let formula = temporal::formula::parse(text, &|_| None)
        .expect("a formula")
        .formula;
    let settings = Settings::dense(Ending::Finite).with_robustness();
    let mut judge = FormulaMonitor::compile(&formula, &settings)
        .expect("sensible")
        .start();
    let mut numbers = Numbers(3);
    let mut most = 0;
    for sample in 0..200_000 {
        let atoms = [
            1.0 + numbers.below(1000) as f64,
            1.0 + numbers.below(1000) as f64,
        ];
        judge
            .step(f64::from(sample) * 0.1, &atoms)
            .expect("times ascend");
        most = most.max(judge.stored());
    }
    // 20 samples within the longest future, 30 within the longest past, a few operators.
    assert!(most < 1_000, "{most} stretches were stored");
    assert_eq!(judge.finish(true).verdict, Verdict::Satisfied);
}

#[test]
fn times_are_nanoseconds() {
    let formula = temporal::formula::parse("always[0, 0.3 s] p", &|_| None)
        .expect("a formula")
        .formula;
    let monitor =
        FormulaMonitor::compile(&formula, &Settings::dense(Ending::Finite)).expect("sensible");
    // 0.1 + 0.2 is a little more than 0.3 in binary, but the same nanosecond.
    let mut judge = monitor.start();
    judge.step_truth(0.0, &[Some(true)]).expect("first");
    let progress = judge.step_truth(0.1 + 0.2, &[Some(false)]).expect("later");
    assert_eq!(progress.verdict, Some(Verdict::Violated));
    // Half a nanosecond later is the same time.
    assert!(judge.step_truth(0.300_000_000_3, &[Some(true)]).is_err());
    assert!(judge.step_truth(f64::NAN, &[Some(true)]).is_err());
    assert!(judge.step_truth(1e300, &[Some(true)]).is_err());
    assert!(judge.step_truth(1.0, &[]).is_err());
    assert!(judge.step_truth(1.0, &[Some(true)]).is_ok());
}

#[test]
fn samples_mean_nothing_in_dense_time() {
    for text in ["next p", "always previous p", "eventually[0, 5 samples] p"] {
        let formula = temporal::formula::parse(text, &|_| None)
            .expect("a formula")
            .formula;
        let error =
            FormulaMonitor::compile(&formula, &Settings::dense(Ending::Finite)).expect_err(text);
        assert!(
            error.to_string().contains("use seconds, or discrete time"),
            "{error}"
        );
    }
}
