//! What judges traces, and what checks models, on all short words of all combinations of scope,
//! condition and timing: the engines against the definition with every ending, and the property
//! against the monitor.

use crate::support;

use requirement_lang::compile::monitor::monitor;
use requirement_lang::sentence::{Amount, Sentence, Timing};
use support::{bits, letters, property_of, renumbered, single_stage_sentences, words};
use temporal::formula::semantics::dense::TickWord;
use temporal::formula::semantics::{self, Word, dense};
use temporal::formula::{
    Ending, Formula, FormulaMonitor, RobustnessBounds, Settings, TimeModel, Verdict,
};

const ENDINGS: [Ending; 4] = [
    Ending::Inconclusive,
    Ending::Weak,
    Ending::Strong,
    Ending::Finite,
];

/// The truth of the atoms at each second.
type Rows = Vec<Vec<Option<bool>>>;

fn rows(word: &[u64], atoms: &[usize]) -> Rows {
    let truth = |letter: u64| atoms.iter().map(move |bit| Some(letter >> bit & 1 == 1));
    word.iter().map(|letter| truth(*letter).collect()).collect()
}

/// The verdict of an engine, whether or not the formula was triggered.
fn verdict(engine: &FormulaMonitor, rows: &Rows) -> Verdict {
    let mut judge = engine.start();
    for (second, row) in rows.iter().enumerate() {
        judge.step_truth(second as f64, row).unwrap();
    }
    judge.finish(true).verdict
}

/// Engines for all endings; what always holds triggers them, so nothing is "not covered".
fn engines(formula: &Formula, time: TimeModel) -> [FormulaMonitor; 4] {
    ENDINGS.map(|ending| {
        let settings = Settings {
            time,
            ending,
            trigger: Some(Formula::True),
            ..Settings::default()
        };
        FormulaMonitor::compile(formula, &settings).unwrap()
    })
}

fn meant_in_discrete_time(formula: &Formula, rows: &Rows, ending: Ending) -> Verdict {
    let mut word = Word::default();
    for (second, row) in rows.iter().enumerate() {
        word.push_truth(second as f64, row);
    }
    semantics::value(formula, &word, ending).unwrap().verdict()
}

fn meant_in_dense_time(formula: &Formula, rows: &Rows, ending: Ending) -> Verdict {
    let bounds = |row: &Vec<Option<bool>>| {
        let of = |truth: &Option<bool>| RobustnessBounds::of_truth(*truth);
        row.iter().map(of).collect()
    };
    let word = TickWord {
        ticks: (0..rows.len()).collect(),
        atoms: rows.iter().map(bounds).collect(),
    };
    dense::value(formula, &word, ending).unwrap().verdict()
}

/// The sentence with its steps read as seconds.
fn in_seconds(mut sentence: Sentence) -> Sentence {
    for stage in &mut sentence.stages {
        if let Timing::Within(duration) | Timing::For(duration) | Timing::After(duration) =
            &mut stage.timing
            && let Amount::Steps(steps) = duration.amount
        {
            duration.amount = Amount::Secs(f64::from(steps));
        }
    }
    sentence
}

/// Compares the engine with the definition; says how often each verdict was given.
fn compare(sentence: &Sentence, time: TimeModel, longest: usize) -> [u64; 3] {
    let form = monitor(sentence).unwrap();
    let formula = &form.requirement.formula;
    let engines = engines(formula, time);
    let atoms = bits(&form.requirement.atoms);
    let alphabet = letters(sentence);
    let mut given = [0; 3];
    for length in 1..=longest - usize::from(alphabet.len() > 8) {
        words(&alphabet, length, &mut |word| {
            let rows = rows(word, &atoms);
            for (engine, ending) in engines.iter().zip(ENDINGS) {
                let found = verdict(engine, &rows);
                let meant = match time {
                    TimeModel::Discrete => meant_in_discrete_time(formula, &rows, ending),
                    TimeModel::Dense => meant_in_dense_time(formula, &rows, ending),
                };
                assert_eq!(found, meant, "{sentence} on {word:?} with {ending:?}");
                given[match found {
                    Verdict::Satisfied => 0,
                    Verdict::Violated => 1,
                    _ => 2,
                }] += 1;
            }
        });
    }
    given
}

fn compare_all(time: TimeModel, longest: usize) -> [u64; 3] {
    let mut total = [0; 3];
    for sentence in single_stage_sentences() {
        let sentence = match time {
            TimeModel::Discrete => sentence,
            TimeModel::Dense => in_seconds(sentence),
        };
        if time == TimeModel::Dense && monitor(&sentence).unwrap().needs_discrete_time() {
            continue;
        }
        let given = compare(&sentence, time, longest);
        total
            .iter_mut()
            .zip(given)
            .for_each(|(sum, more)| *sum += more);
    }
    total
}

#[test]
fn with_every_ending_the_engine_for_discrete_time_judges_sentences_as_defined() {
    let given = compare_all(TimeModel::Discrete, 3);
    assert!(given.iter().all(|count| *count > 20_000), "{given:?}");
}

#[test]
fn with_every_ending_the_engine_for_dense_time_judges_sentences_as_defined() {
    let given = compare_all(TimeModel::Dense, 3);
    assert!(given.iter().all(|count| *count > 20_000), "{given:?}");
}

/// What the monitor has decided after so many letters, the property says of every infinite word that
/// begins so. Counts the words, and those that were decided either way.
fn property_agrees(sentence: &Sentence) -> [u64; 3] {
    let property = property_of(sentence);
    let form = monitor(sentence).unwrap();
    let [open, ..] = engines(&form.requirement.formula, TimeModel::Discrete);
    let atoms = bits(&form.requirement.atoms);
    let alphabet = letters(sentence);
    let shapes: &[(usize, usize)] = if alphabet.len() > 8 {
        &[(0, 1), (1, 1)]
    } else {
        &[(0, 1), (0, 2), (1, 1), (1, 2), (2, 1)]
    };
    let mut counts = [0; 3];
    for &(prefix, cycle) in shapes {
        words(&alphabet, prefix + cycle, &mut |word| {
            let (start, rest) = word.split_at(prefix);
            let (first, second) = (renumbered(start, &property), renumbered(rest, &property));
            let holds = property.ltl.holds_on_lasso(&first, &second);
            // Long enough for durations of two steps behind a trigger in the cycle.
            let long = [start, rest, rest, rest, rest, rest].concat();
            let decided = verdict(&open, &rows(&long, &atoms));
            counts[0] += 1;
            match decided {
                Verdict::Satisfied => counts[1] += 1,
                Verdict::Violated => counts[2] += 1,
                _ => return,
            }
            assert_eq!(
                decided == Verdict::Satisfied,
                holds,
                "{sentence} as {form} and as {} on {start:?} {rest:?}",
                property.path
            );
        });
    }
    counts
}

#[test]
fn what_a_monitor_has_decided_the_property_says_of_all_that_can_follow() {
    let mut total = [0; 3];
    for sentence in single_stage_sentences() {
        let counts = property_agrees(&sentence);
        total
            .iter_mut()
            .zip(counts)
            .for_each(|(sum, more)| *sum += more);
    }
    let [judged, satisfied, violated] = total;
    assert!(
        judged > 300_000 && satisfied > 200 && violated > 100_000,
        "{total:?}"
    );
}

/// The other way round: of no beginning of an infinite word that has the property does the monitor
/// say that it is violated, and with the benefit of the doubt it is satisfied.
#[test]
fn a_monitor_never_blames_what_has_the_property() {
    let mut seen = 0_u64;
    for sentence in &single_stage_sentences() {
        let property = property_of(sentence);
        let form = monitor(sentence).unwrap();
        let [open, weak, ..] = engines(&form.requirement.formula, TimeModel::Discrete);
        let atoms = bits(&form.requirement.atoms);
        words(&letters(sentence), 2, &mut |word| {
            let (start, rest) = word.split_at(1);
            let (first, second) = (renumbered(start, &property), renumbered(rest, &property));
            let long = [start, rest, rest, rest, rest, rest].concat();
            let rows = rows(&long, &atoms);
            if property.ltl.holds_on_lasso(&first, &second) {
                assert_ne!(
                    verdict(&open, &rows),
                    Verdict::Violated,
                    "{sentence} on {word:?}"
                );
                assert_eq!(
                    verdict(&weak, &rows),
                    Verdict::Satisfied,
                    "{sentence} on {word:?}"
                );
                seen += 1;
            }
        });
    }
    assert!(seen > 10_000, "{seen}");
}
