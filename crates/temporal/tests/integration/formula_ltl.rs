//! The model checker's properties on finite traces: a verdict must be that of every infinite
//! continuation, by the model checker's own definition of LTL.

use crate::formulas;

use formulas::Numbers;
use temporal::formula::ltl::{StepError, Steps, from_ltl};
use temporal::formula::{Ending, FormulaMonitor, Settings, Verdict};
use temporal::ltl::{Ltl, StepBound};

fn random_bound(numbers: &mut Numbers) -> StepBound {
    let low = numbers.below(3);
    match numbers.below(4) {
        0 => StepBound::UNBOUNDED,
        1 => StepBound {
            lower: low,
            upper: None,
        },
        // Now and then the window is empty.
        _ => StepBound::between(low, (low + numbers.below(4)).saturating_sub(1)),
    }
}

fn random_property(numbers: &mut Numbers, depth: u64, next: bool) -> Ltl {
    if depth == 0 {
        return Ltl::Ap(numbers.below(2) as usize);
    }
    let left = random_property(numbers, depth - 1, next);
    let right = random_property(numbers, depth - 1, next);
    let bound = random_bound(numbers);
    match numbers.below(9) {
        0 => Ltl::negate(left),
        1 => Ltl::and(left, right),
        2 => Ltl::or(left, right),
        3 if next => Ltl::next(left),
        3 | 4 => Ltl::finally(left).within(bound),
        5 => Ltl::globally(left).within(bound),
        6 => Ltl::until(left, right).within(bound),
        7 => Ltl::release(left, right).within(bound),
        _ => Ltl::weak_until(left, right).within(bound),
    }
}

fn judge(property: &Ltl, steps: Steps, word: &[u64], step_secs: f64, ending: Ending) -> Verdict {
    let formula = from_ltl(property, steps).expect("it can be said of a trace");
    let settings = Settings::discrete(ending);
    let mut judge = FormulaMonitor::compile(&formula, &settings)
        .expect("sensible")
        .start();
    for (index, letter) in word.iter().enumerate() {
        let atoms: Vec<Option<bool>> = (0..formula.atom_count())
            .map(|atom| Some(letter >> atom & 1 == 1))
            .collect();
        judge
            .step_truth(index as f64 * step_secs, &atoms)
            .expect("times ascend");
    }
    let report = judge.finish(true);
    // That nothing triggered is not the question here.
    if report.verdict == Verdict::NotCovered && ending == Ending::Finite {
        Verdict::Satisfied
    } else {
        report.verdict
    }
}

#[test]
fn a_verdict_is_that_of_every_continuation() {
    let mut numbers = Numbers(3);
    let (mut satisfied, mut violated) = (0, 0);
    for _ in 0..4_000 {
        let depth = 1 + numbers.below(3);
        let property = random_property(&mut numbers, depth, true);
        let word: Vec<u64> = (0..=numbers.below(5)).map(|_| numbers.below(4)).collect();
        let verdict = judge(&property, Steps::Samples, &word, 0.1, Ending::Inconclusive);
        let expected = match verdict {
            Verdict::Satisfied => true,
            Verdict::Violated => false,
            _ => continue,
        };
        satisfied += usize::from(expected);
        violated += usize::from(!expected);
        for middle in 0..4 {
            for first in 0..4 {
                for second in 0..4 {
                    let prefix: Vec<u64> = word.iter().copied().chain([middle]).collect();
                    let holds = property.holds_on_lasso(&prefix, &[first, second]);
                    assert_eq!(
                        holds, expected,
                        "{property} on {word:?}, then {middle} ({first} {second})"
                    );
                }
            }
        }
    }
    assert!(satisfied > 500 && violated > 500, "{satisfied} {violated}");
}

#[test]
fn a_decided_word_is_found_to_be_when_its_property_looks_no_further() {
    // Of bounded properties without a bound beyond the word, every verdict is known.
    let mut numbers = Numbers(4);
    for _ in 0..2_000 {
        let inner = random_property(&mut numbers, 1, true);
        if !matches!(
            &inner,
            Ltl::And(..) | Ltl::Or(..) | Ltl::Not(..) | Ltl::Next(..)
        ) {
            continue;
        }
        let property = Ltl::finally(inner).within(StepBound::at_most(3));
        let word: Vec<u64> = (0..5).map(|_| numbers.below(4)).collect();
        let verdict = judge(&property, Steps::Samples, &word, 1.0, Ending::Inconclusive);
        let expected = if property.holds_on_lasso(&word, &[0]) {
            Verdict::Satisfied
        } else {
            Verdict::Violated
        };
        assert_eq!(verdict, expected, "{property} on {word:?}");
    }
}

#[test]
fn steps_that_last_as_long_as_samples_are_apart_mean_the_same() {
    let mut numbers = Numbers(5);
    for _ in 0..3_000 {
        let property = random_property(&mut numbers, 2, false);
        let word: Vec<u64> = (0..=numbers.below(9)).map(|_| numbers.below(4)).collect();
        for ending in [
            Ending::Inconclusive,
            Ending::Finite,
            Ending::Weak,
            Ending::Strong,
        ] {
            let by_samples = judge(&property, Steps::Samples, &word, 0.1, ending);
            let by_time = judge(&property, Steps::Secs(0.1), &word, 0.1, ending);
            assert_eq!(by_samples, by_time, "{property} on {word:?} {ending:?}");
        }
    }
}

#[test]
fn what_cannot_be_said_of_a_trace_is_refused() {
    let next = Ltl::next(Ltl::Ap(0));
    assert_eq!(from_ltl(&next, Steps::Secs(0.1)), Err(StepError::Next));
    let soon = Ltl::finally(Ltl::Ap(0)).within(StepBound::at_most(3));
    for secs in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            from_ltl(&soon, Steps::Secs(secs)),
            Err(StepError::Duration { .. })
        ));
    }
    let late = Ltl::finally(Ltl::Ap(0)).within(StepBound::at_most(u64::MAX));
    assert_eq!(
        from_ltl(&late, Steps::Samples),
        Err(StepError::Bound { steps: u64::MAX })
    );
}
