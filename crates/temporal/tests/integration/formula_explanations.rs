//! Explanations of violations: they are there, they are sound, and they are short.

use crate::formulas;

use formulas::{Numbers, of_one, of_two, sample_windows, small, windows};
use temporal::formula::semantics::Word;
use temporal::formula::semantics::dense::TickWord;
use temporal::formula::{
    Ending, Explanation, Formula, FormulaMonitor, Interval, RobustnessBounds, Settings, TimeModel,
    Verdict, parse, semantics,
};

const ENDINGS: [Ending; 4] = [
    Ending::Inconclusive,
    Ending::Weak,
    Ending::Strong,
    Ending::Finite,
];

/// Ticks of one second, and the truth of two atoms.
type Trace = Vec<(usize, [Option<bool>; 2])>;

fn settings(time: TimeModel, ending: Ending) -> Settings {
    match time {
        TimeModel::Discrete => Settings::discrete(ending),
        TimeModel::Dense => Settings::dense(ending),
    }
}

fn judge(formula: &Formula, trace: &Trace, settings: &Settings) -> (Verdict, Option<Explanation>) {
    let mut judge = FormulaMonitor::compile(formula, settings)
        .expect("sensible")
        .start();
    for (tick, atoms) in trace {
        judge
            .step_truth(*tick as f64, &atoms[..formula.atom_count()])
            .expect("times ascend");
    }
    let report = judge.finish(true);
    (report.verdict, report.explanation)
}

/// The verdict by the definition.
fn by_definition(formula: &Formula, trace: &Trace, time: TimeModel, ending: Ending) -> Verdict {
    let value = match time {
        TimeModel::Discrete => {
            let mut word = Word::default();
            for (tick, atoms) in trace {
                word.push_truth(*tick as f64, atoms);
            }
            semantics::value(formula, &word, ending)
        }
        TimeModel::Dense => {
            let bounds = |atoms: &[Option<bool>; 2]| atoms.map(RobustnessBounds::of_truth).to_vec();
            let word = TickWord {
                ticks: trace.iter().map(|sample| sample.0).collect(),
                atoms: trace.iter().map(|sample| bounds(&sample.1)).collect(),
            };
            semantics::dense::value(formula, &word, ending)
        }
    };
    value.expect("sensible").verdict()
}

/// Whether the atom's value at a sample is part of the explanation.
fn is_responsible(
    explanation: &Explanation,
    trace: &Trace,
    time: TimeModel,
    sample: usize,
    atom: usize,
) -> bool {
    let from = trace[sample].0 as f64;
    // In dense time a sample's value holds up to the next sample, not included.
    let to = trace.get(sample + 1).map_or(from, |next| next.0 as f64);
    explanation.atoms.iter().any(|part| {
        part.atom.0 == atom
            && match time {
                TimeModel::Discrete => part.from_secs <= from && from <= part.to_secs,
                TimeModel::Dense => {
                    part.from_secs < to && from < part.to_secs
                        || part.from_secs <= from && from <= part.to_secs
                        || part.from_secs == part.to_secs
                            && from <= part.from_secs
                            && part.from_secs < to
                }
            }
    })
}

/// Checks the explanation of a violation; returns whether there was one.
fn check(
    formula: &Formula,
    trace: &Trace,
    time: TimeModel,
    ending: Ending,
    numbers: &mut Numbers,
) -> bool {
    let what = || format!("{formula} on {trace:?} with {time:?} {ending:?}");
    let (verdict, explanation) = judge(formula, trace, &settings(time, ending));
    if verdict != Verdict::Violated {
        assert_eq!(explanation, None, "{}", what());
        return false;
    }
    let explanation = explanation.unwrap_or_else(|| panic!("no explanation: {}", what()));
    for part in &explanation.atoms {
        assert!(explanation.from_secs <= part.from_secs && part.to_secs <= explanation.to_secs);
        let shown = trace
            .iter()
            .any(|sample| sample.1[part.atom.0] == Some(part.value));
        assert!(shown, "{part:?} never was: {}", what());
    }
    // Everything else unknown, and everything else at random.
    for attempt in 0..4 {
        let mut changed = trace.clone();
        for (sample, _) in trace.iter().enumerate() {
            for atom in 0..2 {
                if !is_responsible(&explanation, trace, time, sample, atom) {
                    changed[sample].1[atom] = if attempt == 0 {
                        None
                    } else {
                        Some(numbers.below(2) == 0)
                    };
                }
            }
        }
        let after = by_definition(formula, &changed, time, ending);
        assert_eq!(
            after,
            Verdict::Violated,
            "{explanation:?} does not force it: {}, {changed:?}",
            what()
        );
    }
    // With other endings the end itself may do what an atom did before.
    if (time, ending) == (TimeModel::Discrete, Ending::Inconclusive) && explanation.atoms.len() <= 8
    {
        // What came after the sample that determined it may do what an atom did before.
        let decided = (1..=trace.len()).find(|&count| {
            by_definition(formula, &trace[..count].to_vec(), time, ending) == Verdict::Violated
        });
        let seen = trace[..decided.unwrap_or(trace.len())].to_vec();
        check_that_nothing_is_idle(formula, &seen, &explanation);
    }
    true
}

/// Without any one part, everything else being unknown, the violation is not certain.
fn check_that_nothing_is_idle(formula: &Formula, trace: &Trace, explanation: &Explanation) {
    for left_out in 0..explanation.atoms.len() {
        let mut fewer = explanation.clone();
        fewer.atoms.remove(left_out);
        let mut changed = trace.clone();
        for (sample, row) in changed.iter_mut().enumerate() {
            for atom in 0..2 {
                if !is_responsible(&fewer, trace, TimeModel::Discrete, sample, atom) {
                    row.1[atom] = None;
                }
            }
        }
        let after = by_definition(formula, &changed, TimeModel::Discrete, Ending::Inconclusive);
        assert_ne!(
            after,
            Verdict::Violated,
            "{formula} on {trace:?}: {explanation:?}, part {left_out}"
        );
    }
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
                0 => None,
                number => Some(number % 2 == 0),
            };
            (tick, [atom(), atom()])
        })
        .collect()
}

fn small_formulas(time: TimeModel) -> (Vec<Formula>, Vec<Formula>) {
    match time {
        TimeModel::Dense => small(&windows(), false),
        TimeModel::Discrete => {
            let mut all = sample_windows();
            all.extend(windows().into_iter().skip(1).take(2));
            small(&all, true)
        }
    }
}

#[test]
fn violations_of_small_formulas_are_explained() {
    for time in [TimeModel::Discrete, TimeModel::Dense] {
        let (one, two) = small_formulas(time);
        let mut numbers = Numbers(5);
        let mut violated = 0;
        for (formulas, traces) in [(&one, 60), (&two, 3)] {
            for formula in formulas {
                for _ in 0..traces {
                    let ending = ENDINGS[numbers.below(4) as usize];
                    let trace = random_trace(&mut numbers, 5);
                    violated += usize::from(check(formula, &trace, time, ending, &mut numbers));
                }
            }
        }
        assert!(violated > 5_000, "{violated}");
    }
}

#[test]
fn violations_of_larger_formulas_are_explained() {
    for time in [TimeModel::Discrete, TimeModel::Dense] {
        let mut numbers = Numbers(9);
        let mut violated = 0;
        for _ in 0..3_000 {
            let formula = random_formula(&mut numbers, time, 4);
            let ending = ENDINGS[numbers.below(4) as usize];
            let trace = random_trace(&mut numbers, 12);
            violated += usize::from(check(&formula, &trace, time, ending, &mut numbers));
        }
        assert!(violated > 500, "{violated}");
    }
}

fn random_formula(numbers: &mut Numbers, time: TimeModel, depth: u64) -> Formula {
    if depth == 0 || numbers.below(6) == 0 {
        return Formula::atom(numbers.below(2) as usize);
    }
    let (low, more) = (numbers.below(3) as u32, numbers.below(4) as u32);
    let window = match (numbers.below(4), time) {
        (0, _) => Interval::UNBOUNDED,
        (1, TimeModel::Discrete) => Interval::samples(low, low + more),
        _ => Interval::secs(f64::from(low), f64::from(low + more)),
    };
    let left = random_formula(numbers, time, depth - 1);
    let all = if numbers.below(2) == 0 {
        of_one(&left, &[window], time == TimeModel::Discrete)
    } else {
        of_two(&left, &random_formula(numbers, time, depth - 1), &[window])
    };
    all[numbers.below(all.len() as u64) as usize].clone()
}

/// The parts of an explanation as (atom, from, to, value).
fn parts(explanation: &Explanation) -> Vec<(usize, f64, f64, bool)> {
    let part = |part: &temporal::formula::Responsible| {
        (part.atom.0, part.from_secs, part.to_secs, part.value)
    };
    explanation.atoms.iter().map(part).collect()
}

#[test]
fn a_late_response_is_explained_by_the_request_and_the_silence_after_it() {
    let formula = parse("always (request => eventually[0, 2 s] answer)", &|_| None)
        .expect("a formula")
        .formula;
    // Requests at 1 s, answered at 2 s, and at 6 s, not answered.
    let trace: Trace = (0..10)
        .map(|tick| (tick, [Some(tick == 1 || tick == 6), Some(tick == 2)]))
        .collect();
    for time in [TimeModel::Discrete, TimeModel::Dense] {
        let (verdict, explanation) = judge(&formula, &trace, &settings(time, Ending::Inconclusive));
        let explanation = explanation.expect("it is violated");
        assert_eq!(verdict, Verdict::Violated);
        assert_eq!((explanation.from_secs, explanation.to_secs), (6.0, 8.0));
        assert_eq!(
            parts(&explanation),
            [(0, 6.0, 6.0, true), (1, 6.0, 8.0, false)]
        );
    }
}

#[test]
fn an_explanation_survives_a_long_trace_in_bounded_memory() {
    let formula = parse("always (p => once[0, 5 samples] q) and always r", &|_| None)
        .expect("a formula")
        .formula;
    let timed = parse("always (p => once[0, 5 s] q) and always r", &|_| None)
        .expect("a formula")
        .formula;
    for (formula, time) in [
        (&formula, TimeModel::Discrete),
        (&timed, TimeModel::Discrete),
        (&timed, TimeModel::Dense),
    ] {
        let settings = Settings {
            explain_samples: 50,
            ..settings(time, Ending::Inconclusive)
        };
        let mut judge = FormulaMonitor::compile(formula, &settings)
            .expect("sensible")
            .start();
        for tick in 0..100_000 {
            let atoms = [
                tick == 90_000 || tick == 3,
                tick % 10 == 3 && tick < 80_000,
                true,
            ];
            judge
                .step_truth(f64::from(tick), &atoms.map(Some))
                .expect("times ascend");
        }
        let explanation = judge.finish(false).explanation.expect("it is violated");
        let found = parts(&explanation);
        assert_eq!(found[0], (0, 90_000.0, 90_000.0, true), "{time:?}");
        assert_eq!(found[1], (1, 89_995.0, 90_000.0, false), "{time:?}");
        assert_eq!(found.len(), 2);
    }
}

#[test]
fn what_was_not_kept_is_not_guessed() {
    let formula = parse("always (p => historically q)", &|_| None)
        .expect("a formula")
        .formula;
    for time in [TimeModel::Discrete, TimeModel::Dense] {
        let settings = Settings {
            explain_samples: 50,
            ..settings(time, Ending::Inconclusive)
        };
        let mut judge = FormulaMonitor::compile(&formula, &settings)
            .expect("sensible")
            .start();
        for tick in 0..1_000 {
            // q was false long before p demanded it.
            let atoms = [tick == 900, tick != 10];
            judge
                .step_truth(f64::from(tick), &atoms.map(Some))
                .expect("times ascend");
        }
        let report = judge.finish(false);
        assert_eq!(
            (report.verdict, report.explanation),
            (Verdict::Violated, None)
        );
    }
}
