//! The engine for discrete time against the definition: after every sample of every short word, for
//! all small formulas and many larger ones.

use proptest::prelude::*;
use temporal::formula::discrete::{DiscreteJudge, DiscreteMonitor};
use temporal::formula::semantics::{self, Word};
use temporal::formula::{
    Bound, Ending, Formula, FormulaMonitor, Interval, Settings, TimeUnit, Verdict, parse,
};

const ENDINGS: [Ending; 4] = [
    Ending::Inconclusive,
    Ending::Weak,
    Ending::Strong,
    Ending::Finite,
];

/// Samples of two atoms: both truth values of each, and one of them unknown.
const TRUTHS: [[Option<bool>; 2]; 6] = [
    [Some(false), Some(false)],
    [Some(true), Some(false)],
    [Some(false), Some(true)],
    [Some(true), Some(true)],
    [None, Some(false)],
    [Some(true), None],
];

/// Whether an operator of the past has an operand that speaks of the future.
fn looks_back_on_the_future(formula: &Formula) -> bool {
    fn speaks_of_future(formula: &Formula) -> bool {
        let own = matches!(
            formula,
            Formula::Next(_)
                | Formula::Eventually(..)
                | Formula::Always(..)
                | Formula::Until(..)
                | Formula::WeakUntil(..)
                | Formula::Release(..)
        );
        own || formula.operands().into_iter().any(speaks_of_future)
    }
    let past = matches!(
        formula,
        Formula::Once(..) | Formula::Historically(..) | Formula::Since(..)
    );
    let operands = formula.operands();
    (past && operands.iter().any(|inner| speaks_of_future(inner)))
        || operands.into_iter().any(looks_back_on_the_future)
}

/// A formula with a judge for each ending, and the word they have seen.
#[derive(Clone)]
struct Run<'f> {
    formula: &'f Formula,
    prompt: bool,
    judges: Vec<DiscreteJudge>,
    word: Word,
}

impl<'f> Run<'f> {
    fn new(formula: &'f Formula) -> Self {
        let judges = ENDINGS
            .iter()
            .map(|&ending| {
                let settings = Settings::discrete(ending).with_robustness();
                DiscreteMonitor::compile(formula, &settings)
                    .unwrap()
                    .start()
            })
            .collect();
        Run {
            formula,
            prompt: !looks_back_on_the_future(formula),
            judges,
            word: Word::default(),
        }
    }

    fn step_truth(&mut self, time_secs: f64, atoms: &[Option<bool>]) {
        self.word.push_truth(time_secs, atoms);
        for judge in &mut self.judges {
            // The engine wants as many values as there are atoms.
            let count = self.formula.atom_count();
            judge.step_truth(time_secs, &atoms[..count]).unwrap();
        }
        self.agrees();
    }

    fn step_values(&mut self, time_secs: f64, atoms: &[f64]) {
        self.word.push_values(time_secs, atoms);
        for judge in &mut self.judges {
            let count = self.formula.atom_count();
            judge.step(time_secs, &atoms[..count]).unwrap();
        }
        self.agrees();
    }

    /// Several samples of one instant.
    fn step_instant(&mut self, time_secs: f64, samples: &[[Option<bool>; 2]]) {
        let count = self.formula.atom_count();
        let value = |truth: &Option<bool>| match truth {
            Some(true) => f64::INFINITY,
            Some(false) => f64::NEG_INFINITY,
            None => f64::NAN,
        };
        let values: Vec<Vec<f64>> = samples
            .iter()
            .map(|atoms| atoms[..count].iter().map(value).collect())
            .collect();
        let both: Vec<(&[Option<bool>], &[f64])> = samples
            .iter()
            .zip(&values)
            .map(|(atoms, values)| (&atoms[..count], &values[..]))
            .collect();
        for atoms in samples {
            self.word.push_truth(time_secs, atoms);
        }
        for judge in &mut self.judges {
            judge.step_instant(time_secs, &both).unwrap();
        }
        self.agrees();
    }

    /// What the engine would say now is what the definition says.
    fn agrees(&self) {
        for (judge, ending) in self.judges.iter().zip(ENDINGS) {
            let meant = semantics::value(self.formula, &self.word, ending).unwrap();
            if ending == Ending::Inconclusive {
                let bounds = judge.robustness_bounds();
                assert_eq!(bounds, Some(meant), "{} on {:?}", self.formula, self.word);
                let verdict = Some(meant.verdict()).filter(|it| *it != Verdict::Inconclusive);
                if self.prompt || judge.verdict().is_some() {
                    assert_eq!(
                        judge.verdict(),
                        verdict,
                        "{} on {:?}",
                        self.formula,
                        self.word
                    );
                }
            }
            let report = judge.clone().finish(true);
            if self.prompt || ending != Ending::Inconclusive {
                let verdict = match report.verdict {
                    Verdict::NotCovered => meant.verdict(),
                    verdict => verdict,
                };
                assert_eq!(
                    verdict,
                    meant.verdict(),
                    "{} on {:?} ({ending:?})",
                    self.formula,
                    self.word
                );
            }
            assert_eq!(
                report.robustness,
                Some(meant),
                "{} on {:?} ({ending:?})",
                self.formula,
                self.word
            );
        }
    }
}

/// All words of up to `length` more samples out of `samples`, at the times given.
fn all_words(run: &Run<'_>, times_secs: &[f64], samples: &[[Option<bool>; 2]]) {
    let Some((&time_secs, later)) = times_secs.split_first() else {
        return;
    };
    for atoms in samples {
        let mut run = run.clone();
        run.step_truth(time_secs, atoms);
        all_words(&run, later, samples);
    }
}

fn bound(value: f64, unit: TimeUnit) -> Bound {
    Bound { value, unit }
}

/// No bounds, windows in samples, and windows in seconds.
fn intervals(seconds: bool) -> Vec<Interval> {
    let unit = if seconds {
        TimeUnit::Seconds
    } else {
        TimeUnit::Samples
    };
    let window = |low, high: Option<f64>| Interval {
        low: bound(low, unit),
        high: high.map(|high| bound(high, unit)),
    };
    vec![
        window(0.0, None),
        window(0.0, Some(1.0)),
        window(1.0, Some(2.0)),
        window(1.0, None),
    ]
}

fn with_one(inner: &Formula, intervals: &[Interval]) -> Vec<Formula> {
    let boxed = || Box::new(inner.clone());
    let mut all = vec![
        Formula::Not(boxed()),
        Formula::Next(boxed()),
        Formula::Previous(boxed()),
        Formula::Rise(boxed()),
        Formula::Fall(boxed()),
    ];
    for &interval in intervals {
        all.push(Formula::Eventually(interval, boxed()));
        all.push(Formula::Always(interval, boxed()));
        all.push(Formula::Once(interval, boxed()));
        all.push(Formula::Historically(interval, boxed()));
    }
    all
}

fn with_two(left: &Formula, right: &Formula, intervals: &[Interval]) -> Vec<Formula> {
    let boxed = || (Box::new(left.clone()), Box::new(right.clone()));
    let mut all = vec![
        Formula::and(left.clone(), right.clone()),
        Formula::or(left.clone(), right.clone()),
        Formula::Implies(boxed().0, boxed().1),
        Formula::Iff(boxed().0, boxed().1),
    ];
    for &interval in intervals {
        all.push(Formula::Until(interval, boxed().0, boxed().1));
        all.push(Formula::WeakUntil(interval, boxed().0, boxed().1));
        all.push(Formula::Release(interval, boxed().0, boxed().1));
        all.push(Formula::Since(interval, boxed().0, boxed().1));
    }
    all
}

/// All formulas with one operator.
fn small_formulas(intervals: &[Interval]) -> Vec<Formula> {
    let atoms = [Formula::atom(0), Formula::atom(1)];
    let mut all = Vec::new();
    for left in &atoms {
        all.extend(with_one(left, intervals));
        for right in &atoms {
            all.extend(with_two(left, right, intervals));
        }
    }
    all
}

const REGULAR_SECS: [f64; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
/// Windows of up to 2 s that are empty, hold several samples, or end exactly at one.
const IRREGULAR_SECS: [f64; 6] = [0.5, 0.7, 1.5, 3.5, 3.6, 9.0];

#[test]
fn all_formulas_with_one_operator_on_all_words_of_four_samples() {
    for seconds in [false, true] {
        let times = if seconds {
            IRREGULAR_SECS
        } else {
            REGULAR_SECS
        };
        for formula in small_formulas(&intervals(seconds)) {
            all_words(&Run::new(&formula), &times[..4], &TRUTHS[..4]);
            all_words(&Run::new(&formula), &times[..3], &TRUTHS);
        }
    }
}

/// All ways to give the samples of these instants, so many each.
fn all_instants(run: &Run<'_>, instants: &[(f64, usize)], samples: &[[Option<bool>; 2]]) {
    let Some((&(time_secs, count), later)) = instants.split_first() else {
        return;
    };
    let mut chosen = vec![vec![]];
    for _ in 0..count {
        let longer = |one: &Vec<[Option<bool>; 2]>| {
            let one = one.clone();
            let last = samples.iter().map(move |it| [&one[..], &[*it]].concat());
            last.collect::<Vec<_>>()
        };
        chosen = chosen.iter().flat_map(longer).collect();
    }
    for chosen in chosen {
        let mut run = run.clone();
        run.step_instant(time_secs, &chosen);
        all_instants(&run, later, samples);
    }
}

#[test]
fn all_formulas_with_one_operator_where_instants_have_several_samples() {
    // Windows of 1 and 2 s end and begin exactly there.
    let instants = [
        [(0.0, 1), (1.0, 2), (2.0, 1)],
        [(0.0, 2), (1.0, 1), (2.0, 2)],
    ];
    for seconds in [false, true] {
        for formula in small_formulas(&intervals(seconds)) {
            for instants in &instants {
                all_instants(&Run::new(&formula), instants, &TRUTHS[..4]);
            }
        }
    }
}

#[test]
fn a_window_that_ends_where_two_samples_are_holds_both() {
    let formula = parse("always[0, 1 s] a", &|_| None).unwrap().formula;
    let mut run = Run::new(&formula);
    let [yes, no] = [true, false].map(|a| [Some(a), None]);
    run.step_instant(0.0, &[yes]);
    run.step_instant(1.0, &[yes, no]);
    let report = run.judges[3].clone().finish(true);
    assert_eq!(report.verdict, Verdict::Violated);
}

/// Formulas with two operators, on all words of `length` samples: all, or those with some of the
/// windows and orders of operands.
fn two_operators(thorough: bool, length: usize) {
    for seconds in [false, true] {
        let times = if seconds {
            IRREGULAR_SECS
        } else {
            REGULAR_SECS
        };
        let intervals = intervals(seconds);
        let (inner, outer) = if thorough {
            (intervals.clone(), intervals)
        } else {
            (intervals[1..3].to_vec(), vec![intervals[0], intervals[2]])
        };
        let outer = outer.as_slice();
        for inner in small_formulas(&inner) {
            let mut formulas = with_one(&inner, outer);
            for atom in 0..2 {
                if thorough || atom == 0 {
                    formulas.extend(with_two(&inner, &Formula::atom(atom), outer));
                }
                if thorough || atom == 1 {
                    formulas.extend(with_two(&Formula::atom(atom), &inner, outer));
                }
            }
            for formula in &formulas {
                all_words(&Run::new(formula), &times[..length], &TRUTHS[..4]);
            }
        }
    }
}

#[test]
fn formulas_with_two_operators_on_all_words_of_three_samples() {
    two_operators(false, 3);
}

#[test]
#[ignore = "takes minutes; for changes of the engine (cargo test --release -- --ignored)"]
fn all_formulas_with_two_operators_and_any_window_on_all_words_of_four_samples() {
    two_operators(true, 4);
}

fn any_interval() -> impl Strategy<Value = Interval> {
    let low = prop_oneof![2 => Just(0.0), 1 => 0.0..4.0_f64];
    let length = prop_oneof![3 => (0.0..6.0_f64).prop_map(Some), 1 => Just(None)];
    (low, length, any::<bool>()).prop_map(|(low, length, seconds)| {
        if seconds {
            // Tenths, so that windows often end exactly at a sample.
            let tenths = |secs: f64| (secs * 10.0).round() / 10.0;
            Interval {
                low: bound(tenths(low), TimeUnit::Seconds),
                high: length.map(|length| bound(tenths(low + length), TimeUnit::Seconds)),
            }
        } else {
            Interval {
                low: bound(low.round(), TimeUnit::Samples),
                high: length.map(|length| bound((low + length).round(), TimeUnit::Samples)),
            }
        }
    })
}

fn any_formula() -> impl Strategy<Value = Formula> {
    formula_with(any_interval)
}

fn formula_with<S>(any_interval: impl Fn() -> S) -> impl Strategy<Value = Formula>
where
    S: Strategy<Value = Interval> + 'static,
{
    let leaf = prop_oneof![
        8 => (0..2_usize).prop_map(Formula::atom),
        1 => Just(Formula::True),
        1 => Just(Formula::False),
    ];
    leaf.prop_recursive(4, 12, 2, move |inner| {
        let one =
            (inner.clone(), any_interval(), 0..9_usize).prop_map(|(inner, interval, kind)| {
                let one = with_one(&inner, &[interval]);
                one[kind % one.len()].clone()
            });
        let two = (inner.clone(), inner, any_interval(), 0..8_usize).prop_map(
            |(left, right, interval, kind)| {
                let two = with_two(&left, &right, &[interval]);
                two[kind % two.len()].clone()
            },
        );
        prop_oneof![one, two]
    })
}

/// Steps of time in tenths of seconds, up to 3 s, mostly short.
fn any_times(count: usize) -> impl Strategy<Value = Vec<f64>> {
    let step = prop_oneof![4 => 1..8_u32, 1 => 8..30_u32];
    proptest::collection::vec(step, count).prop_map(|steps| {
        let ticks = steps.into_iter().scan(0, |sum, step| {
            *sum += step;
            Some(*sum)
        });
        ticks.map(|tick| f64::from(tick) / 10.0).collect()
    })
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (-4..=4_i32).prop_map(f64::from),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
        1 => Just(f64::NAN),
    ]
}

/// The most that a judge stores while it judges a trace of `length` samples, which does not decide.
fn most_stored(text: &str, length: u32) -> usize {
    let formula = temporal::formula::parse(text, &|_| None).unwrap().formula;
    let settings = Settings::discrete(Ending::Inconclusive).with_robustness();
    let mut judge = DiscreteMonitor::compile(&formula, &settings)
        .unwrap()
        .start();
    let mut most = 0;
    for at in 0..length {
        // No period, and no order.
        let value = f64::from(at.wrapping_mul(2_654_435_761) % 1_009) - 300.0;
        let request = if at % 7 == 0 { value } else { -1.0 };
        let answer = if at % 40 == 39 {
            500.0
        } else {
            value.min(-1.0)
        };
        let progress = judge.step(f64::from(at) * 0.1, &[request, answer]).unwrap();
        assert_eq!(progress.verdict, None);
        most = most.max(judge.stored());
    }
    most
}

/// Formulas with bounds, and nested ones without, need no more memory for a longer trace.
#[test]
fn memory_does_not_grow_with_the_trace() {
    for text in [
        "always (p => eventually[0, 50 samples] q)",
        "always (p => eventually[0, 5 s] q)",
        "always (eventually[0, 5 s] q and (p or (not q) until[0, 50 samples] q))",
        "always (not p or (once[0, 5 s] true and historically[1, 2 s] eventually[0, 5 s] q))",
        "always (p => eventually q)",
        "always (p => (true until (q and eventually (not q))))",
    ] {
        let short = most_stored(text, 2_000);
        // How many values dominate others within a window is a matter of chance.
        let long = most_stored(text, 20_000);
        assert!(short < 1_000 && long < 2 * short, "{text}: {short}, {long}");
    }
}

/// The outer window falls between two samples, while the inner one still waits for its third: what is
/// missing is of no sample in the outer window.
#[test]
fn a_window_without_samples_is_settled_once_it_is_over() {
    let text = "always[2.8 s, 2.8 s] always[0 samples, 3 samples] p";
    let formula = parse(text, &|_| None).unwrap().formula;
    let mut run = Run::new(&formula);
    for time_secs in [0.1, 1.1, 2.4, 3.0] {
        run.step_truth(time_secs, &[Some(false), None]);
    }
    let bounds = run.judges[0].robustness_bounds().unwrap();
    assert_eq!((bounds.low, bounds.high), (f64::INFINITY, f64::INFINITY));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn random_formulas_on_random_truth(
        formula in any_formula(),
        times in any_times(14),
        picks in proptest::collection::vec(0..16_usize, 14),
    ) {
        let mut run = Run::new(&formula);
        for (time_secs, pick) in times.into_iter().zip(picks) {
            // Unknown atoms are rarer.
            let sample = if pick < 13 { pick % 4 } else { 4 + pick % 2 };
            run.step_truth(time_secs, &TRUTHS[sample]);
        }
    }

    #[test]
    fn random_formulas_without_bounds(
        formula in formula_with(|| Just(Interval::UNBOUNDED)),
        values in proptest::collection::vec((any_value(), any_value()), 8),
    ) {
        let mut run = Run::new(&formula);
        for (at, (first, second)) in values.into_iter().enumerate() {
            run.step_values(at as f64, &[first, second]);
        }
    }

    #[test]
    fn samples_in_columns_are_judged_as_one_by_one(
        formula in any_formula(),
        trigger in any_formula(),
        times in any_times(24),
        values in proptest::collection::vec((any_value(), any_value()), 24),
        cut in 0..24_usize,
    ) {
        for ending in ENDINGS {
            let settings = Settings {
                trigger: Some(trigger.clone()),
                explain_samples: 7,
                ..Settings::discrete(ending).with_robustness()
            };
            let monitor = FormulaMonitor::compile(&formula, &settings).unwrap();
            let count = formula.atom_count().max(trigger.atom_count());
            let mut single = monitor.start();
            for (time_secs, value) in times.iter().zip(&values) {
                single.step(*time_secs, &[value.0, value.1][..count]).unwrap();
            }
            let columns: [Vec<f64>; 2] = values.iter().copied().unzip::<_, _, Vec<_>, Vec<_>>().into();
            let mut many = monitor.start();
            for range in [0..cut, cut..24] {
                let columns = columns.each_ref().map(|column| &column[range.clone()]);
                many.step_many(&times[range], &columns[..count]).unwrap();
            }
            prop_assert_eq!(single.verdict(), many.verdict());
            prop_assert_eq!(single.finish(true), many.finish(true));
        }
    }

    #[test]
    fn triggers_are_counted_where_they_become_true(
        trigger in any_formula(),
        times in any_times(10),
        picks in proptest::collection::vec(0..6_usize, 10),
    ) {
        let settings = Settings {
            trigger: Some(trigger.clone()),
            ..Settings::discrete(Ending::Finite)
        };
        let monitor = DiscreteMonitor::compile(&Formula::True, &settings).unwrap();
        let mut judge = monitor.start();
        let mut word = Word::default();
        for (time_secs, pick) in times.into_iter().zip(picks) {
            judge.step_truth(time_secs, &TRUTHS[pick][..trigger.atom_count()]).unwrap();
            word.push_truth(time_secs, &TRUTHS[pick]);
        }
        let rises = semantics::values(&Formula::rise(trigger), &word, Ending::Finite).unwrap();
        let rises = rises.iter().filter(|bounds| bounds.truth() == Some(true)).count();
        prop_assert_eq!(judge.finish(true).triggered, rises as u64);
    }

    #[test]
    fn random_formulas_on_random_values(
        formula in any_formula(),
        times in any_times(14),
        values in proptest::collection::vec((any_value(), any_value()), 14),
    ) {
        let mut run = Run::new(&formula);
        for (time_secs, (first, second)) in times.into_iter().zip(values) {
            run.step_values(time_secs, &[first, second]);
        }
    }
}
