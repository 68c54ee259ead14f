//! The figures of a verdict say one thing: limit and verdict, words and numbers, the bound that all pieces support and
//! the limits of each. Studies are drawn; nothing in them is chosen to fit.

use crate::support;

use evidence::*;
use stats::{Confidence, EffectiveSample};
use support::{Uniform, at_least, counts, exact, piece, requirement};

/// Counts of an experiment, of people in half of the studies.
fn counted(uniform: &mut Uniform, rate: f64) -> Measure {
    let trials = uniform.of(&[3, 20, 100, 400]);
    if uniform.of(&[true, false]) {
        let sample = uniform.sample(trials, rate);
        return counts(sample.successes, sample.trials);
    }
    let size = uniform.of(&[2, 5, 10]);
    let correlation = uniform.of(&[0.05, 0.3]);
    let number = trials.div_ceil(size).max(2) as usize;
    let people = uniform.people(number, size, rate, correlation);
    Measure::of_clusters(&people, Confidence::P95).expect("counts")
}

fn drawn(uniform: &mut Uniform) -> (Vec<Evidence>, Requirement) {
    let rate = uniform.of(&[0.02, 0.5, 0.8, 0.9, 0.97, 1.0]);
    let value = uniform.of(&[0.1, 0.5, 0.85, 0.9, 0.95]);
    let threshold = match uniform.of(&[true, false]) {
        true => at_least(value),
        false => Some((Direction::AtMost, value)),
    };
    let mut ledger = vec![piece(
        "E",
        Technique::Experiment,
        vec![(0, counted(uniform, rate))],
    )];
    if uniform.of(&[true, false]) {
        let measure = counted(uniform, rate);
        ledger.push(piece("S", Technique::Simulation, vec![(0, measure)]));
    }
    if uniform.of(&[true, false]) {
        let value = (rate + uniform.of(&[-0.1, 0.0, 0.01])).clamp(0.0, 1.0);
        ledger.push(piece(
            "M",
            Technique::ModelChecking,
            vec![(0, exact(value))],
        ));
    }
    (ledger, requirement(0, threshold))
}

fn concluded(ledger: &[Evidence], requirement: &Requirement, looks: Option<&Looks>) -> Conclusion {
    let influences = Influences::learn(ledger);
    let study = Study {
        requirements: std::slice::from_ref(requirement),
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    conclude(&study, &compare(&study)).swap_remove(0)
}

/// The limit in words: what stands after the first "rate >= " or "rate <= " and before " %", where a limit is given.
fn limit_in_words(words: &str) -> Option<(bool, f64)> {
    let words = words.split_once(" limit, ")?.0;
    let start = words.find("rate ")?;
    let (sign, rest) = words[start..].split_at("rate >= ".len());
    let number = rest.split_once(" %")?.0;
    Some((sign.contains(">="), number.parse::<f64>().ok()? / 100.0))
}

fn assert_coherent(found: &Conclusion, asked: Threshold, ledger: &[Evidence]) {
    for standing in &found.standings {
        let what = format!("{} of {asked:?}", standing.words);
        let Interval { low, high } = standing.limits;
        let value = asked.value;
        // Which side of the threshold the limits show the rate to be on: the standing, and nothing else.
        let (above, below) = (low >= value, high <= value);
        let (met, missed) = match asked.direction {
            Direction::AtLeast => (above, below),
            Direction::AtMost => (below, above),
        };
        // A limit that is the threshold itself decides by the test, which is exact there.
        if (low - value).abs() > 1e-9 && (high - value).abs() > 1e-9 {
            assert_eq!(standing.standing == Standing::Supports, met, "{what}");
            assert_eq!(standing.standing == Standing::Denies, missed, "{what}");
        }
        if let Some((is_lower, said)) = limit_in_words(&standing.words) {
            let shown = match is_lower {
                true => said >= value,
                false => said <= value,
            };
            let leans = match standing.standing {
                Standing::Neither => false,
                Standing::Supports | Standing::Denies => true,
            };
            assert_eq!(shown, leans, "{what}: {said}");
            let limit = if is_lower { low } else { high };
            assert!((said - limit).abs() < 0.01, "{what}: {said} for {limit}");
        }
        let of = |piece: &&Evidence| piece.id == standing.evidence;
        let own = ledger.iter().find(of).expect("a piece of the study");
        let estimate = own.findings[0].measure.estimate().expect("a number");
        assert!(
            low <= estimate + 1e-9 && estimate <= high + 1e-9,
            "{what}: {estimate} in {low} to {high}"
        );
    }
}

/// The bound that all support is the weakest of the limits at which they are judged: no piece is given two.
fn assert_one_bound(found: &Conclusion) {
    let Some(bound) = found.common_lower_bound else {
        return;
    };
    // One requirement that is judged by one piece has the whole level, as the common bound does.
    let [only] = found.standings.as_slice() else {
        return;
    };
    if (only.level_met - 0.05).abs() < 1e-12 {
        let limit = only.limits.low;
        assert!(
            (bound - limit).abs() < 1e-9,
            "{bound} {limit}: {}",
            only.words
        );
    }
}

#[test]
fn limits_words_and_verdicts_say_one_thing() {
    let mut uniform = Uniform(11);
    let mut decided = [0, 0];
    for _ in 0..60 {
        let (ledger, requirement) = drawn(&mut uniform);
        let looks = uniform.of(&[true, false]).then(|| Looks {
            looks: vec![Look::of(&ledger)],
        });
        let found = concluded(&ledger, &requirement, looks.as_ref());
        let asked = requirement.threshold.expect("a threshold");
        assert_coherent(&found, asked, &ledger);
        if looks.is_none() {
            assert_one_bound(&found);
        }
        decided[0] += usize::from(found.verdict == Verdict::Satisfied);
        decided[1] += usize::from(found.verdict == Verdict::Violated);
    }
    assert!(decided[0] > 5 && decided[1] > 5, "{decided:?}");
}

/// The interval that one look would have had is that of the tests at one look, and looking never narrows it.
#[test]
fn what_looking_cost_is_the_difference_of_two_intervals() {
    let mut uniform = Uniform(12);
    for _ in 0..20 {
        let (ledger, requirement) = drawn(&mut uniform);
        let looks = Looks {
            looks: vec![Look::of(&ledger)],
        };
        let found = concluded(&ledger, &requirement, Some(&looks));
        for looking in &found.looking {
            let all = looking.interval.expect("an interval");
            let once = looking.single_look_interval.expect("an interval");
            let words = &looking.statement;
            assert!(
                all.low <= once.low + 1e-9 && once.high <= all.high + 1e-9,
                "{words}"
            );
            let [piece] = looking.evidence.as_slice() else {
                panic!("one piece: {words}")
            };
            let own = ledger.iter().find(|it| &it.id == piece).expect("a piece");
            let Measure::Counts {
                count,
                trials,
                effective_trials: None,
                ..
            } = own.findings[0].measure
            else {
                continue;
            };
            // Independent trials at one look: Clopper and Pearson's interval.
            let whole = EffectiveSample::from(stats::Sample::new(count, trials).expect("counts"));
            let exact = stats::IntervalMethod::ClopperPearson.interval(whole, Confidence::P95);
            assert!((once.low - exact.low).abs() < 1e-9, "{words}");
            assert!((once.high - exact.high).abs() < 1e-9, "{words}");
        }
    }
}
