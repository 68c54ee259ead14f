//! Whether what a word that ends lacks could still come.
//!
//! # Definition
//! A sentence that does not hold of a word that ends is *open* there if it holds of some word that begins so and goes on for ever:
//! a *continuation*. Where it is not open, it is broken, and nothing that comes can mend it.
//!
//! # Source
//! The words from which a sentence is broken are the bad prefixes of O. Kupferman and M. Vardi, "Model checking of safety
//! properties", Formal Methods in System Design 19, 2001.
//!
//! # Method
//! Continuations are tried, in this order: each letter for ever; the word itself, repeated from each position; two letters, the
//! first for up to two positions more than the longest duration (first for as long as a duration that began where the word's
//! letter changed has still to run) and the other for ever; drawn ones. What helped the word before is tried first.
//!
//! # Guarantee
//! A continuation that is found is one. That none is found is no proof that there is none.
//!
//! # Cost
//! At most [`CONTINUATIONS`] evaluations of the sentence for each word, fewer of long ones.

use super::meaning::{Draw, Setup};
use super::words::Word;
use std::collections::BTreeSet;

/// The most continuations of one word.
const CONTINUATIONS: usize = 6_000;
/// At least so many, however long they are.
const FEWEST: usize = 300;
/// Positions of all continuations of one word, squared.
const WORK: usize = 40_000_000;
/// How many are drawn.
const DRAWN: usize = 200;
/// How many letters pairs are made of.
const PAIRED: usize = 24;

/// What follows a word: letters, of which the last stays for ever.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tail {
    first: u64,
    for_positions: usize,
    then: u64,
}

impl Tail {
    fn behind(&self, word: &Word) -> Word {
        let mut letters = word.letters.clone();
        letters.extend(std::iter::repeat_n(self.first, self.for_positions));
        letters.push(self.then);
        Word {
            repeats_from: Some(letters.len() - 1),
            letters,
        }
    }
}

/// A continuation of a word that ends, of which the sentence holds; `helped` is what helped before, and is kept up to date.
pub(super) fn continuation(
    setup: &Setup<'_>,
    word: &Word,
    helped: &mut Option<Tail>,
) -> Option<Word> {
    let holds = |longer: &Word| setup.sentence_holds(longer);
    let runs = runs(word, setup.longest());
    if let Some(tail) = helped.as_ref() {
        // The same letters, for as long as this word needs them.
        let again = runs.iter().take(32).map(|run| Tail {
            for_positions: *run,
            ..tail.clone()
        });
        let mut again = std::iter::once(tail.clone()).chain(again);
        if let Some(found) = again.find_map(|it| Some(it.behind(word)).filter(holds)) {
            return Some(found);
        }
    }
    let letters = setup.valuations();
    let for_ever = letters.iter().map(|letter| Tail {
        first: *letter,
        for_positions: 0,
        then: *letter,
    });
    let long = word.letters.len() + setup.longest() + 2;
    let most = (WORK / (long * long)).clamp(FEWEST, CONTINUATIONS);
    let paired = &letters[..letters.len().min(PAIRED)];
    let pairs = runs.iter().flat_map(|run| {
        let firsts = paired.iter().flat_map(move |first| {
            let thens = paired.iter().filter(move |then| *then != first);
            thens.map(move |then| (*first, *then))
        });
        firsts.map(|(first, then)| Tail {
            first,
            for_positions: *run,
            then,
        })
    });
    let mut try_all = |tails: &mut dyn Iterator<Item = Tail>| -> Option<Word> {
        for tail in tails {
            let longer = tail.behind(word);
            if holds(&longer) {
                *helped = Some(tail);
                return Some(longer);
            }
        }
        None
    };
    try_all(&mut for_ever.take(most))
        .or_else(|| repeated(word).find(holds))
        .or_else(|| try_all(&mut pairs.take(most)))
        .or_else(|| drawn(setup, word).find(holds))
}

/// The word repeated from each of its positions.
fn repeated(word: &Word) -> impl Iterator<Item = Word> {
    (0..word.letters.len()).take(64).map(|from| Word {
        letters: word.letters.clone(),
        repeats_from: Some(from),
    })
}

/// For how many positions the first of two letters stays: what is left of a duration that began where a letter changed comes first.
fn runs(word: &Word, longest: usize) -> Vec<usize> {
    let length = word.letters.len();
    let changes = (0..length).filter(|at| *at == 0 || word.letters[at - 1] != word.letters[*at]);
    let left = changes.flat_map(|at| {
        (0..4).filter_map(move |more| (at + longest + more).checked_sub(length + 1))
    });
    let mut seen = BTreeSet::new();
    left.chain(1..=longest + 2)
        .filter(|run| (1..=longest + 2).contains(run) && seen.insert(*run))
        .collect()
}

/// Drawn continuations.
fn drawn<'w>(setup: &'w Setup<'_>, word: &'w Word) -> impl Iterator<Item = Word> + 'w {
    let mut draw = Draw::new(0xc0de);
    (0..DRAWN).map(move |_| {
        let tail = setup.drawn_letters(&mut draw);
        let repeats_from = word.letters.len() + draw.below(tail.len());
        let letters = [word.letters.clone(), tail].concat();
        Word {
            letters,
            repeats_from: Some(repeats_from),
        }
    })
}
