//! Every form of every combination of scope, condition and timing means what the semantics says, on
//! all short words.

use crate::support;

use requirement_lang::Sentence;
use requirement_lang::compile::coverage::bins;
use requirement_lang::compile::goal::trace_goal;
use requirement_lang::compile::monitor::monitor;
use requirement_lang::sentence::{ScopeKind, Timing};
use support::{
    CONDITIONS, bits, holds_finite, holds_lasso, letters, name, property_of, renumbered, sentence,
    single_stage_sentences, timings, triggers, truth, words,
};
use temporal::formula::Ending;
use temporal::formula::semantics::{Word, value};

/// The longest words, so that there are at most about five thousand.
fn longest(letters: usize) -> usize {
    match letters {
        0..5 => 6,
        5..9 => 4,
        _ => 3,
    }
}

#[test]
fn monitors_mean_their_sentences_on_all_short_finite_words() {
    let mut judged = 0_u64;
    for sentence in single_stage_sentences() {
        judged += monitor_agrees(&sentence, 0);
    }
    assert!(judged > 1_000_000, "{judged} judgements");
}

#[test]
#[ignore = "takes some 20 s: words one letter longer than in the test before"]
fn monitors_mean_their_sentences_on_longer_finite_words() {
    for sentence in single_stage_sentences() {
        monitor_agrees(&sentence, 1);
    }
}

/// Compares on all words, and says on how many.
fn monitor_agrees(sentence: &Sentence, longer: usize) -> u64 {
    let monitor = monitor(sentence).unwrap();
    let goal = trace_goal(sentence).unwrap();
    let atoms = bits(&monitor.requirement.atoms);
    let alphabet = letters(sentence);
    let (mut count, mut held) = (0, 0);
    for length in 1..=longest(alphabet.len()) + longer {
        words(&alphabet, length, &mut |word| {
            let expected = holds_finite(sentence, word);
            let found = truth(&monitor.requirement.formula, &atoms, word) & 1 == 1;
            assert_eq!(found, expected, "{sentence} as {monitor} on {word:?}");
            let times = truth(&monitor.trigger, &atoms, word).count_ones() as usize;
            assert_eq!(
                times,
                triggers(sentence, word),
                "triggers of {sentence} on {word:?}"
            );
            let reached = truth(&goal.reach.formula, &atoms, word) & 1 == 1;
            assert_eq!(reached, times > 0, "goal of {sentence} on {word:?}");
            count += 1;
            held += u64::from(expected);
        });
    }
    assert!(
        held > 0 && held < count,
        "{sentence} holds of {held} of {count} words"
    );
    count
}

#[test]
fn the_reference_of_the_formulas_agrees_with_the_evaluator_of_these_tests() {
    for sentence in single_stage_sentences() {
        let monitor = monitor(&sentence).unwrap();
        let atoms = bits(&monitor.requirement.atoms);
        let alphabet = letters(&sentence);
        let length = if alphabet.len() > 8 { 2 } else { 3 };
        words(&alphabet, length, &mut |word| {
            let mut trace = Word::default();
            for (position, letter) in word.iter().enumerate() {
                let atoms: Vec<Option<bool>> = atoms
                    .iter()
                    .map(|bit| Some(letter >> bit & 1 == 1))
                    .collect();
                trace.push_truth(position as f64, &atoms);
            }
            let formula = &monitor.requirement.formula;
            let found = value(formula, &trace, Ending::Finite).unwrap().truth();
            assert_eq!(
                found,
                Some(truth(formula, &atoms, word) & 1 == 1),
                "{monitor} on {word:?}"
            );
        });
    }
}

#[test]
fn properties_mean_their_sentences_on_all_short_infinite_words() {
    let mut judged = 0_u64;
    for sentence in single_stage_sentences() {
        judged += property_agrees(&sentence);
    }
    assert!(judged > 200_000, "{judged} judgements");
}

fn property_agrees(sentence: &Sentence) -> u64 {
    let property = property_of(sentence);
    let alphabet = letters(sentence);
    let shapes: &[(usize, usize)] = if alphabet.len() > 8 {
        &[(0, 1), (0, 2), (1, 1)]
    } else {
        &[(0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (2, 1)]
    };
    let (mut count, mut held) = (0, 0);
    for &(prefix, cycle) in shapes {
        words(&alphabet, prefix + cycle, &mut |word| {
            let (start, rest) = word.split_at(prefix);
            let expected = holds_lasso(sentence, start, rest);
            let (first, second) = (renumbered(start, &property), renumbered(rest, &property));
            let found = property.ltl.holds_on_lasso(&first, &second);
            assert_eq!(
                found, expected,
                "{sentence} as {} on {start:?} {rest:?}",
                property.path
            );
            count += 1;
            held += u64::from(expected);
        });
    }
    assert!(
        held > 0 && held < count,
        "{sentence} holds of {held} of {count} words"
    );
    count
}

/// Sequences of two stages with each pair of timings in scopes of each kind, and one of three.
fn sequences() -> Vec<Sentence> {
    let mut all = Vec::new();
    let scopes = [
        ScopeKind::Global,
        ScopeKind::In,
        ScopeKind::Before,
        ScopeKind::After,
    ];
    for scope in scopes {
        for first in timings().into_iter().filter(Timing::completes) {
            for second in timings() {
                let stages = vec![(first.clone(), name(2)), (second, name(4))];
                all.push(sentence(scope, CONDITIONS[2], stages.clone()));
                all.push(sentence(scope, None, stages));
            }
        }
    }
    let three = [
        timings()[2].clone(),
        timings()[10].clone(),
        timings()[0].clone(),
    ];
    let responses = [name(2), name(4), name(3)];
    all.push(sentence(
        ScopeKind::In,
        CONDITIONS[1],
        three.into_iter().zip(responses).collect(),
    ));
    all
}

#[test]
fn sequences_of_stages_mean_what_the_semantics_says() {
    // Pseudorandom letters (the generator of Marsaglia, "Xorshift RNGs", 2003), so that words can be
    // longer than all of them would allow.
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut draw = |bound: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 33) as usize % bound
    };
    for sentence in sequences() {
        let monitor = monitor(&sentence).unwrap();
        let property = property_of(&sentence);
        let atoms = bits(&monitor.requirement.atoms);
        let alphabet = letters(&sentence);
        for _ in 0..400 {
            let word: Vec<u64> = (0..1 + draw(7))
                .map(|_| alphabet[draw(alphabet.len())])
                .collect();
            let found = truth(&monitor.requirement.formula, &atoms, &word) & 1 == 1;
            assert_eq!(
                found,
                holds_finite(&sentence, &word),
                "{sentence} as {monitor} on {word:?}"
            );
            let (prefix, cycle) = word.split_at(draw(word.len()));
            let (first, second) = (renumbered(prefix, &property), renumbered(cycle, &property));
            let found = property.ltl.holds_on_lasso(&first, &second);
            let expected = holds_lasso(&sentence, prefix, cycle);
            assert_eq!(
                found, expected,
                "{sentence} as {} on {prefix:?} {cycle:?}",
                property.path
            );
        }
    }
}

#[test]
fn bins_of_a_trigger_are_complete_and_exclude_each_other() {
    for sentence in single_stage_sentences() {
        let alphabet = letters(&sentence);
        let bins = bins(&sentence).unwrap();
        let hit = |name: &str, word: &[u64]| {
            let bin = bins.iter().find(|bin| bin.name == name).unwrap();
            truth(&bin.formula.formula, &bits(&bin.formula.atoms), word) & 1 == 1
        };
        words(
            &alphabet,
            2 + usize::from(alphabet.len() <= 8),
            &mut |word| {
                let (triggered, met, missed) = (
                    hit("triggered", word),
                    hit("met", word),
                    hit("missed", word),
                );
                let count = triggers(&sentence, word);
                assert_eq!(triggered, count > 0, "{sentence} on {word:?}");
                assert_eq!(met || missed, triggered, "{sentence} on {word:?}");
                assert_eq!(
                    missed,
                    !holds_finite(&sentence, word),
                    "{sentence} on {word:?}"
                );
                if count == 1 {
                    assert!(!(met && missed), "{sentence} on {word:?}");
                }
            },
        );
    }
}

#[test]
fn bins_of_a_deadline_tell_when_the_response_came() {
    for scope in [ScopeKind::Global, ScopeKind::In] {
        let timing = Timing::Within(requirement_lang::sentence::Duration::steps(2));
        let sentence = sentence(scope, CONDITIONS[1], vec![(timing, name(2))]);
        let bins = bins(&sentence).unwrap();
        words(&letters(&sentence), 4, &mut |word| {
            if triggers(&sentence, word) != 1 {
                return;
            }
            // By hand: the first position with scope and condition, then how far the response is.
            let has = |letter: &u64, bit: usize| letter >> bit & 1 == 1;
            let inside = |letter: &u64| scope == ScopeKind::Global || has(letter, 0);
            let start = word
                .iter()
                .position(|letter| inside(letter) && has(letter, 1))
                .unwrap();
            let rest: Vec<&u64> = word[start..].iter().take(3).collect();
            let lasting = rest.iter().take_while(|letter| inside(letter)).count();
            let delay = rest[..lasting].iter().position(|letter| has(letter, 2));
            let expected = match delay {
                Some(0 | 1) => vec!["response-first-half"],
                Some(_) => vec!["response-second-half"],
                None if lasting == 3 => vec!["response-late"],
                // The word ends before anything is decided.
                None if lasting == rest.len() => vec![],
                None => vec!["scope-ended-first"],
            };
            let named = [
                "response-first-half",
                "response-second-half",
                "response-late",
                "scope-ended-first",
            ];
            let hit = |bin: &&requirement_lang::compile::coverage::Bin| {
                truth(&bin.formula.formula, &bits(&bin.formula.atoms), word) & 1 == 1
            };
            let found: Vec<&str> = (bins.iter().filter(hit))
                .map(|bin| bin.name)
                .filter(|name| named.contains(name))
                .collect();
            assert_eq!(found, expected, "{sentence} on {word:?}");
        });
    }
}
