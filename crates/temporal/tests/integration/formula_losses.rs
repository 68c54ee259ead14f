//! Traces with a loss: a verdict that is given is that of every completion.

use crate::formulas as common_formulas;

use common_formulas::Numbers;
use proptest::prelude::*;
use temporal::formula::semantics::dense::{self, TickWord};
use temporal::formula::semantics::{self, Word};
use temporal::formula::{
    Ending, Formula, FormulaMonitor, Interval, RobustnessBounds, Settings, Verdict, parse,
};

type Atoms = [Option<bool>; 2];

/// Samples at tenths of seconds, and a loss between two of them.
#[derive(Debug, Clone)]
struct Lossy {
    before: Vec<(f64, Atoms)>,
    loss: (f64, f64),
    after: Vec<(f64, Atoms)>,
}

fn judged(formula: &Formula, lossy: &Lossy, settings: &Settings) -> Verdict {
    let settings = Settings {
        losses: true,
        explain_samples: 0,
        ..settings.clone()
    };
    let mut judge = FormulaMonitor::compile(formula, &settings).unwrap().start();
    let count = formula.atom_count();
    for (time_secs, atoms) in &lossy.before {
        judge.step_truth(*time_secs, &atoms[..count]).unwrap();
    }
    let unknown = (vec![None; count], vec![f64::NAN; count]);
    let next_secs = lossy.after.first().map_or(f64::INFINITY, |it| it.0);
    let now = (&unknown.0[..], &unknown.1[..]);
    judge.lose(lossy.loss, next_secs, now).unwrap();
    for (time_secs, atoms) in &lossy.after {
        judge.step_truth(*time_secs, &atoms[..count]).unwrap();
    }
    match judge.finish(true).verdict {
        Verdict::NotCovered => Verdict::Satisfied,
        verdict => verdict,
    }
}

/// All completions with up to two samples, at a few times of the loss, with all values.
fn completions(lossy: &Lossy) -> Vec<Vec<(f64, Atoms)>> {
    let (from, to) = lossy.loss;
    let truths = [[false, false], [true, false], [false, true], [true, true]];
    let times = [from, (from + to) / 2.0, to];
    let mut lost: Vec<Vec<(f64, Atoms)>> = vec![vec![]];
    for (place, time) in times.iter().enumerate() {
        for truth in truths {
            let one = (*time, truth.map(Some));
            lost.push(vec![one]);
            for second in &times[place..] {
                lost.extend(truths.map(|truth| vec![one, (*second, truth.map(Some))]));
            }
        }
    }
    let whole = |lost: Vec<(f64, Atoms)>| [&lossy.before[..], &lost, &lossy.after].concat();
    lost.into_iter().map(whole).collect()
}

fn is_sound(formula: &Formula, lossy: &Lossy) {
    for ending in [Ending::Finite, Ending::Inconclusive] {
        let said = judged(formula, lossy, &Settings::discrete(ending));
        if said == Verdict::Inconclusive {
            continue;
        }
        for completion in completions(lossy) {
            let mut word = Word::default();
            for (time_secs, atoms) in &completion {
                word.push_truth(*time_secs, atoms);
            }
            let meant = semantics::value(formula, &word, ending).unwrap().verdict();
            assert_eq!(said, meant, "{formula} on {lossy:?} completed to {word:?}");
        }
    }
}

/// Traces of five samples, of which the loss comes behind the `behind`-th.
fn traces(behind: usize, numbers: &mut Numbers) -> Lossy {
    let times = [0.0, 0.5, 1.0, 2.0, 2.5];
    let mut samples: Vec<(f64, Atoms)> = Vec::new();
    for time in times {
        let truth = [numbers.below(2) == 1, numbers.below(3) > 0];
        samples.push((time, truth.map(Some)));
    }
    let after = samples.split_off(behind);
    let begin = samples.last().map_or(-1.0, |it| it.0);
    let end = after.first().map_or(4.0, |it| it.0);
    let middle = (begin + end) / 2.0;
    let loss = match numbers.below(3) {
        0 => (begin + 0.1, end - 0.1),
        1 => (middle, middle),
        _ => (begin + 0.25, middle),
    };
    Lossy {
        before: samples,
        loss,
        after,
    }
}

#[test]
fn verdicts_of_small_formulas_are_those_of_all_completions() {
    let mut numbers = Numbers(1);
    let windows = [
        Interval::UNBOUNDED,
        Interval::secs(0.0, 1.0),
        Interval::secs(0.5, 2.0),
    ];
    for windows in [&windows[..], &common_formulas::sample_windows()[..]] {
        let (one, two) = common_formulas::small(windows, true);
        for formula in one.iter().chain(two.iter().step_by(7)) {
            for behind in 0..=5 {
                is_sound(formula, &traces(behind, &mut numbers));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn verdicts_of_nested_formulas_are_those_of_all_completions(
        inner in 0..10_000_usize, outer in 0..10_000_usize, behind in 0..=5_usize, seed in any::<u64>(),
    ) {
        let windows = [Interval::UNBOUNDED, Interval::secs(0.0, 0.7), Interval::samples(0, 2)];
        let (_, two) = common_formulas::small(&windows, true);
        let part = two[inner % two.len()].clone();
        let all = [
            common_formulas::of_one(&part, &windows, true),
            common_formulas::of_two(&part, &Formula::atom(1), &windows),
            common_formulas::of_two(&Formula::atom(0), &part, &windows),
        ]
        .concat();
        is_sound(&all[outer % all.len()], &traces(behind, &mut Numbers(seed)));
    }
}

#[test]
fn verdicts_in_dense_time_are_those_of_all_completions() {
    let mut numbers = Numbers(5);
    let windows = [
        Interval::UNBOUNDED,
        Interval::secs(0.0, 1.0),
        Interval::secs(1.0, 2.0),
    ];
    let (one, two) = common_formulas::small(&windows, false);
    for formula in one.iter().chain(two.iter().step_by(5)) {
        let samples: Vec<(usize, Atoms)> = [0, 1, 4, 5]
            .into_iter()
            .map(|tick| (tick, [0, 1].map(|_| Some(numbers.below(2) == 1))))
            .collect();
        let seconds = |it: &(usize, Atoms)| (it.0 as f64, it.1);
        let lossy = Lossy {
            before: samples[..2].iter().map(seconds).collect(),
            loss: (2.0, 3.0),
            after: samples[2..].iter().map(seconds).collect(),
        };
        let said = judged(formula, &lossy, &Settings::dense(Ending::Finite));
        if said == Verdict::Inconclusive {
            continue;
        }
        for completion in completions(&Lossy {
            loss: (2.0, 3.0),
            ..lossy.clone()
        }) {
            // Those at whole ticks, one at each.
            let mut word = TickWord::default();
            for (time_secs, atoms) in &completion {
                let tick = time_secs.round() as usize;
                if time_secs.fract() == 0.0 && word.ticks.last() != Some(&tick) {
                    word.ticks.push(tick);
                    word.atoms
                        .push(atoms.map(RobustnessBounds::of_truth).to_vec());
                }
            }
            let meant = dense::value(formula, &word, Ending::Finite)
                .unwrap()
                .verdict();
            assert_eq!(said, meant, "{formula} on {lossy:?} completed to {word:?}");
        }
    }
}

#[test]
fn what_is_certain_is_said() {
    let yes = [Some(true), Some(true)];
    let no = [Some(false), Some(true)];
    let lossy = |last| Lossy {
        before: vec![(0.0, yes), (0.5, yes)],
        loss: (0.6, 0.9),
        after: vec![(1.0, last), (3.0, yes)],
    };
    let judged = |text: &str, last| {
        let formula = parse(text, &|_| None).unwrap().formula;
        judged_finite(&formula, &lossy(last))
    };
    assert_eq!(judged("always a", no), Verdict::Violated);
    assert_eq!(judged("always a", yes), Verdict::Inconclusive);
    assert_eq!(judged("always[0, 0.5 s] a", yes), Verdict::Satisfied);
    assert_eq!(judged("always[0, 1.9 s] a", yes), Verdict::Inconclusive);
    assert_eq!(judged("always[2 s, 3 s] a", yes), Verdict::Satisfied);
    assert_eq!(judged("eventually (not a)", no), Verdict::Satisfied);
    assert_eq!(judged("eventually (not a)", yes), Verdict::Inconclusive);
    assert_eq!(judged("next a", yes), Verdict::Satisfied);
    assert_eq!(judged("next next a", yes), Verdict::Inconclusive);
    assert_eq!(
        judged("always (a => eventually[0, 2 s] a)", yes),
        Verdict::Inconclusive
    );
}

fn judged_finite(formula: &Formula, lossy: &Lossy) -> Verdict {
    judged(formula, lossy, &Settings::discrete(Ending::Finite))
}
