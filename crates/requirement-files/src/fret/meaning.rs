//! Whether a sentence of ours and a formula of FRET's mean the same: on words.
//!
//! # Definition
//! Two questions, each decided on words over the truth values of the comparisons and names of both:
//!
//! * *whole runs*: both hold of the same words that go on for ever (FRET's `ftInfAUExpanded`, else `ftExpanded` where `LAST`
//!   holds nowhere);
//! * *runs that end*: both hold of the same words that end (FRET's `ptExpanded` at the last position, and `ftExpanded` at the
//!   first). Here FRET excuses what could still have come in time, and a sentence of ours does not: what a monitor says of an
//!   unfinished recording is a matter of its ending. So a formula that holds where the sentence does not is an *excuse* if the
//!   sentence could still come to hold: some continuation of the word, which goes on for ever, satisfies it
//!   (`continuation.rs`). Without one it is a difference as any other, and so is a formula that does not hold where the sentence
//!   does; differences are looked for first.
//!
//! # Deviation
//! FRET excuses each trigger by itself. Where several triggers ask for what cannot come together (`after 3 ticks`, triggered at
//! two positions that follow each other, asks for the response at one position and forbids it there), no continuation satisfies
//! the sentence, and FRET's own formula differs from it.
//!
//! # Method
//! Letters are valuations, one of each combination of truths of the largest parts without time of both sides: what else differs
//! in a letter changes neither side. Up to [`ALL_VALUATIONS`] names all valuations are looked at, so that a word over the letters
//! stands for every word; of more names those in which all or none hold but for one or two, drawn ones, and the neighbours of
//! those that were found.
//!
//! All words up to a length that the number of letters allows, short ones first; then words of one letter but for one position;
//! then drawn ones whose letters stay for as long as durations last, one more and one less, so that every bound is met from both
//! sides. A word that tells them apart is made as short and as false as it goes.
//!
//! # Guarantee
//! A word that is shown tells them apart (each truth is computed by the definition of its side), and a continuation that is
//! shown satisfies the sentence. That none was found is no proof: how many words were tried, and up to which length all over both sides' names, is said. Comparisons count as independent: a word may have
//! `x > 1` and `x < 0` at once.
//!
//! # Cost
//! Words times positions times bounds; durations beyond [`LONGEST`] are refused.

use super::continuation::{Tail, continuation};
use super::expression;
use super::words::{Atoms, Node, Word};
use requirement_lang::expression::Expression;
use requirement_lang::semantics::{Word as SentenceWord, holds};
use requirement_lang::sentence::{Amount, Sentence};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

/// The longest duration in time points.
pub const LONGEST: usize = 1_000;
/// The most comparisons and names.
const MOST_ATOMS: usize = 60;
/// How many words of all lengths are tried.
const ALL_WORDS: usize = 3_000;
/// How many drawn ones, at most, and steps of work on them.
const DRAWN_WORDS: usize = 1_500;
const WORK: usize = 60_000_000;
const MOST_LETTERS: usize = 512;
/// Up to so many names all valuations are looked at.
const ALL_VALUATIONS: usize = 16;
/// The most words of one letter but for one position.
const BUT_FOR_ONE: usize = 2_000;
/// How many words without a continuation are looked at, at most, while one of them is made small.
const BROKEN_WORDS: usize = 120;

/// What a comparison came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Comparison {
    /// No word told them apart.
    Same {
        /// How many words were tried.
        words: usize,
        /// Up to this length, all words over the names of both sides were, each or one that both sides judge like it.
        all_up_to: usize,
    },
    /// They differ.
    Differs(Box<Trace>),
    /// On runs that end, FRET's formula excuses what could still come, and in nothing else did they differ.
    Excuses {
        /// A word that is excused, with what could still come.
        trace: Box<Trace>,
        /// How many words were tried.
        words: usize,
        /// Up to this length, all words over the names of both sides were, each or one that both sides judge like it.
        all_up_to: usize,
    },
    /// They were not compared, for this reason.
    NotCompared(String),
}

/// A word that tells two readings apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// What holds at each time point.
    pub steps: Vec<Vec<String>>,
    /// From which time point on it repeats for ever; `None` if it ends.
    pub repeats_from: Option<usize>,
    /// Whether the sentence holds.
    pub sentence: bool,
    /// Whether FRET's formula does.
    pub formula: bool,
    /// Which of FRET's formulas.
    pub formula_name: &'static str,
    /// What could still come so that the sentence holds, and from which of these time points on it repeats for ever.
    pub could_come: Option<(Vec<Vec<String>>, usize)>,
}

/// Time points in words.
fn in_words(steps: &[Vec<String>], repeats_from: Option<usize>) -> String {
    let of = |(at, step): (usize, &Vec<String>)| {
        let what = match step.is_empty() {
            true => "nothing holds".to_owned(),
            false => step.join(", "),
        };
        let from = if repeats_from == Some(at) {
            "for ever: "
        } else {
            ""
        };
        format!("{from}{what}")
    };
    let steps: Vec<String> = steps.iter().enumerate().map(of).collect();
    steps.join("; then ")
}

impl std::fmt::Display for Trace {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let end = if self.repeats_from.is_none() {
            "; the run ends"
        } else {
            ""
        };
        let word = |it: bool| if it { "holds" } else { "does not hold" };
        write!(
            out,
            "{}{end}: the sentence {}, FRET's {} {}",
            in_words(&self.steps, self.repeats_from),
            word(self.sentence),
            self.formula_name,
            word(self.formula)
        )?;
        match &self.could_come {
            Some((steps, from)) => write!(
                out,
                "; FRET excuses what could still come: {}",
                in_words(steps, Some(*from))
            ),
            None => Ok(()),
        }
    }
}

/// One of FRET's formulas, and where it is evaluated.
pub(crate) struct Formula<'f> {
    pub(crate) name: &'static str,
    pub(crate) text: &'f str,
    /// Whether it is asked at the last position of words that end.
    pub(crate) at_end: bool,
}

/// Compares a sentence with formulas, on words that end or on words that do not.
pub(crate) fn compared(
    sentence: &Sentence,
    definitions: &[(String, String)],
    step_secs: f64,
    formulas: &[Formula<'_>],
    ends: bool,
) -> Comparison {
    let asked = Asked {
        definitions,
        formulas,
        other: None,
    };
    match Setup::new(sentence, &asked, step_secs, ends) {
        Ok(mut setup) => setup.compare(),
        Err(reason) => Comparison::NotCompared(reason),
    }
}

/// Compares a sentence with another sentence, which stands in FRET's text, on words that do not end.
pub(crate) fn compared_sentences(
    sentence: &Sentence,
    other: &Sentence,
    step_secs: f64,
) -> Comparison {
    let asked = Asked {
        definitions: &[],
        formulas: &[],
        other: Some(other),
    };
    match Setup::new(sentence, &asked, step_secs, false) {
        Ok(mut setup) => setup.compare(),
        Err(reason) => Comparison::NotCompared(reason),
    }
}

/// With what a sentence is compared: formulas, or another sentence.
struct Asked<'a, 's> {
    definitions: &'a [(String, String)],
    formulas: &'a [Formula<'a>],
    other: Option<&'s Sentence>,
}

/// What each proposition of a sentence is, beside those that are known.
fn propositions(
    sentence: &Sentence,
    definitions: &[(String, String)],
    atoms: &mut Atoms,
    own: &mut Vec<(String, Node)>,
) -> Result<(), String> {
    for text in sentence.propositions() {
        if own.iter().any(|(known, _)| known == text) {
            continue;
        }
        let defined = definitions.iter().find(|(name, _)| name == text);
        let meaning = defined.map_or(text, |(_, meaning)| meaning);
        let read = expression::expression(meaning)
            .map_err(|reason| format!("`{text}` is not an expression of FRET's: {reason}"))?;
        let node = match (&read, defined) {
            // By itself `FTP` is a name like any other in a sentence of ours.
            (expression::Expr::Point(name), None) => {
                atoms.compile(&expression::Expr::Name((*name).to_owned()))?
            }
            _ => atoms.compile(&read)?,
        };
        own.push((text.to_owned(), node));
    }
    Ok(())
}

/// An expression of a sentence, with what its atoms are.
fn node_of(expression: &Expression, own: &[(String, Node)]) -> Node {
    let not = |node: Node| Node::Not(Box::new(node));
    let one = |it: &Expression| Box::new(node_of(it, own));
    let all = |all: &[Expression], join: fn(Box<Node>, Box<Node>) -> Node| {
        let nodes = all.iter().map(|it| node_of(it, own));
        let joined = nodes.reduce(|left, right| join(Box::new(left), Box::new(right)));
        joined.unwrap_or(Node::Constant(true))
    };
    match expression {
        Expression::True | Expression::Missing => Node::Constant(true),
        Expression::False => Node::Constant(false),
        Expression::Atom(atom) => {
            let known = own.iter().find(|(text, _)| *text == atom.text);
            known.map_or(Node::Constant(false), |(_, node)| node.clone())
        }
        Expression::Not(inner) => Node::Not(one(inner)),
        Expression::And(parts) => all(parts, Node::And),
        Expression::Or(parts) => all(parts, Node::Or),
        Expression::Implies(left, right) => Node::Or(Box::new(not(*one(left))), one(right)),
        Expression::Iff(left, right) => Node::Iff(one(left), one(right)),
    }
}

pub(super) struct Setup<'s> {
    sentence: &'s Sentence,
    step_secs: f64,
    /// What each atom of the sentence is.
    own: Vec<(String, Node)>,
    /// Its expressions.
    expressions: Vec<Node>,
    formulas: Vec<(&'static str, Node, bool)>,
    other: Option<&'s Sentence>,
    atoms: Atoms,
    ends: bool,
    wanted: Wanted,
    /// What helped the last word that could be continued.
    helped: RefCell<Option<Tail>>,
    /// How many words without a continuation may still be looked at.
    broken_left: Cell<usize>,
    /// The letters of which words are made, and whether every valuation is judged like one of them.
    letters: Vec<u64>,
    are_all: bool,
    memory: (usize, usize),
    longest: usize,
}

/// Which words are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wanted {
    /// In which the sentence and a formula differ.
    Any,
    /// In which the sentence holds and a formula does not.
    Stricter,
    /// In which a formula holds, and the sentence does not and never will.
    Weaker,
}

impl<'s> Setup<'s> {
    fn new(
        sentence: &'s Sentence,
        asked: &Asked<'_, 's>,
        step_secs: f64,
        ends: bool,
    ) -> Result<Self, String> {
        let mut atoms = Atoms::default();
        let mut own = Vec::new();
        propositions(sentence, asked.definitions, &mut atoms, &mut own)?;
        let of_sentence = atoms.texts.clone();
        if let Some(other) = asked.other {
            propositions(other, asked.definitions, &mut atoms, &mut own)?;
        }
        let mut read = Vec::new();
        for formula in asked.formulas {
            let tree = expression::formula(formula.text)
                .map_err(|reason| format!("{} cannot be read: {reason}", formula.name))?;
            let node = atoms
                .compile(&tree)
                .map_err(|reason| format!("{}: {reason}", formula.name))?;
            read.push((formula.name, node, formula.at_end));
        }
        if let Some(other) = atoms.texts.get(of_sentence.len()..).and_then(<[_]>::first)
            && !of_sentence.is_empty()
        {
            let who = asked.other.map_or("FRET's formula", |_| "FRET's text");
            return Err(format!(
                "{who} speaks of `{other}`, and the sentence does not"
            ));
        }
        if atoms.texts.len() > MOST_ATOMS {
            return Err(format!(
                "it has more than {MOST_ATOMS} comparisons and names"
            ));
        }
        let nodes = || {
            read.iter()
                .map(|(_, node, _)| node)
                .chain(own.iter().map(|(_, node)| node))
        };
        let memory = nodes().map(Node::memory);
        let memory = memory.fold((0, 0), |all, it| (all.0 + it.0, all.1 + it.1));
        let sentences = || std::iter::once(sentence).chain(asked.other);
        let durations = sentences().flat_map(|it| &it.stages).filter_map(|stage| {
            Some(match stage.timing.duration()?.amount {
                Amount::Steps(steps) => steps as usize,
                Amount::Secs(secs) => (secs / step_secs) as usize,
                Amount::Missing => 0,
            })
        });
        let longest = durations
            .chain(nodes().map(Node::longest))
            .max()
            .unwrap_or(0);
        if longest > LONGEST {
            return Err(format!("a duration is longer than {LONGEST} time points"));
        }
        let expressions = sentences().flat_map(|it| it.expressions());
        let expressions = expressions.map(|it| node_of(it, &own)).collect();
        let mut setup = Self {
            sentence,
            step_secs,
            own,
            expressions,
            formulas: read,
            other: asked.other,
            atoms,
            ends,
            wanted: Wanted::Any,
            helped: RefCell::new(None),
            broken_left: Cell::new(BROKEN_WORDS),
            letters: Vec::new(),
            are_all: false,
            memory,
            longest,
        };
        (setup.letters, setup.are_all) = setup.letters();
        Ok(setup)
    }

    /// The longest duration in time points.
    pub(super) fn longest(&self) -> usize {
        self.longest
    }

    /// The letters of which words are made.
    pub(super) fn valuations(&self) -> &[u64] {
        &self.letters
    }

    /// Whether the sentence holds of a word.
    pub(super) fn sentence_holds(&self, word: &Word) -> bool {
        self.holds_on(self.sentence, &word.written_out(self.memory))
    }

    fn holds_on(&self, sentence: &Sentence, word: &Word) -> bool {
        let own: Vec<(&str, Vec<bool>)> = self
            .own
            .iter()
            .map(|(text, node)| (text.as_str(), node.truth(word)))
            .collect();
        let truth = |at: usize, text: &str| {
            let atom = own.iter().find(|(known, _)| *known == text);
            atom.is_some_and(|(_, values)| values[at])
        };
        let sentence_word = SentenceWord {
            truth: &truth,
            length: word.letters.len(),
            repeats_from: word.repeats_from,
        };
        holds(sentence, &sentence_word, self.step_secs)
    }

    /// The truth of the sentence and of the first formula that differs from it; of the last one, if none does.
    fn truths(&self, word: &Word) -> (bool, bool, &'static str) {
        let word = &word.written_out(self.memory);
        let sentence = self.holds_on(self.sentence, word);
        if let Some(other) = self.other {
            return (sentence, self.holds_on(other, word), "text");
        }
        let mut last = (sentence, sentence, "formula");
        for (name, node, at_end) in &self.formulas {
            let values = node.truth(word);
            let value = match at_end {
                true => values.last(),
                false => values.first(),
            };
            let value = value.copied().unwrap_or(true);
            // A formula that differs to the other side is passed over where only one side is looked for.
            let is_wanted = match self.wanted {
                Wanted::Any => true,
                Wanted::Stricter => sentence,
                Wanted::Weaker => !sentence,
            };
            if sentence != value && is_wanted {
                return (sentence, value, name);
            }
            last = (sentence, sentence, name);
        }
        last
    }

    /// Whether a word tells them apart as it is asked.
    fn differs(&self, word: &Word) -> bool {
        let (sentence, formula, _) = self.truths(word);
        sentence != formula && (self.wanted != Wanted::Weaker || self.is_broken(word))
    }

    /// Whether a word that ends has no continuation that satisfies the sentence, as far as one was looked for.
    fn is_broken(&self, word: &Word) -> bool {
        // Only making a word small looks at so many.
        if self.broken_left.get() == 0 {
            return false;
        }
        let found = continuation(self, word, &mut self.helped.borrow_mut());
        if found.is_none() {
            self.broken_left.set(self.broken_left.get() - 1);
        }
        found.is_none()
    }

    /// On words that end, first a word in which the sentence holds and a formula does not, then one in which a formula holds and
    /// the sentence never will: such a one excuses nothing.
    fn compare(&mut self) -> Comparison {
        if !self.ends {
            return self.search();
        }
        self.wanted = Wanted::Stricter;
        let stricter = self.search();
        if let Comparison::Differs(_) = stricter {
            return stricter;
        }
        self.wanted = Wanted::Any;
        let Comparison::Differs(trace) = self.search() else {
            return stricter;
        };
        self.wanted = Wanted::Weaker;
        match self.search() {
            Comparison::Same { words, all_up_to } => Comparison::Excuses {
                trace,
                words,
                all_up_to,
            },
            weaker => weaker,
        }
    }

    fn search(&self) -> Comparison {
        let (letters, are_all) = (&self.letters, self.are_all);
        let mut tried = 0;
        let mut all_up_to = 0;
        for length in 1..=6 {
            let count = letters.len().checked_pow(length as u32);
            let shapes = if self.ends { 1 } else { length };
            let Some(count) = count.filter(|it| tried + it * shapes <= ALL_WORDS) else {
                break;
            };
            for number in 0..count {
                let mut rest = number;
                let word: Vec<u64> = (0..length)
                    .map(|_| {
                        let letter = letters[rest % letters.len()];
                        rest /= letters.len();
                        letter
                    })
                    .collect();
                for repeats_from in self.shapes(length) {
                    tried += 1;
                    let letters = word.clone();
                    let word = Word {
                        letters,
                        repeats_from,
                    };
                    if self.differs(&word) {
                        return self.told_apart(word);
                    }
                }
            }
            if are_all {
                all_up_to = length;
            }
        }
        let mut draw = Draw::new(0x5eed);
        let long = 3 * (self.longest + 3) + self.memory.1;
        let most = (WORK / (long * long / 4).max(1)).clamp(40, DRAWN_WORDS);
        let around = self
            .around_the_bound(letters)
            .into_iter()
            .take(2 * most / 3);
        let mut words: Vec<Word> = around.collect();
        let but_for_one = self.but_for_one(letters);
        let most = most + but_for_one.len();
        words.extend(but_for_one);
        while words.len() < most {
            words.push(self.drawn(&mut draw));
        }
        for word in words {
            tried += 1;
            if self.differs(&word) {
                return self.told_apart(word);
            }
        }
        Comparison::Same {
            words: tried,
            all_up_to,
        }
    }

    fn shapes(&self, length: usize) -> Vec<Option<usize>> {
        match self.ends {
            true => vec![None],
            false => (0..length).map(Some).collect(),
        }
    }

    /// The letters of which words are made, and whether every valuation is judged like one of them.
    fn letters(&self) -> (Vec<u64>, bool) {
        let count = self.atoms.texts.len();
        let mask = (1_u64 << count) - 1;
        let parts = self.parts();
        let mut valuations = Vec::new();
        for base in [0, mask] {
            valuations.push(base);
            for one in 0..count {
                valuations.push(base ^ (1 << one));
            }
        }
        if count <= ALL_VALUATIONS {
            valuations.extend(0..=mask);
            let letters = first_of_each(&valuations, &parts);
            let are_all = letters.len() < MOST_LETTERS;
            return (letters, are_all);
        }
        for base in [0, mask] {
            for one in 0..count {
                valuations.extend((0..one).map(|other| base ^ (1 << one) ^ (1 << other)));
            }
        }
        let mut draw = Draw::new(7);
        valuations.extend((0..4096).map(|at| draw.biased(at) & mask));
        let mut letters = first_of_each(&valuations, &parts);
        for _ in 0..3 {
            let near = letters.iter().flat_map(|letter| {
                let beside = (0..count).map(move |bit| letter ^ (1 << bit));
                std::iter::once(*letter).chain(beside)
            });
            let near: Vec<u64> = letters.iter().copied().chain(near).collect();
            letters = first_of_each(&near, &parts);
        }
        (letters, false)
    }

    /// The largest parts of both sides in which nothing depends on time.
    fn parts(&self) -> Vec<&Node> {
        let mut parts = Vec::new();
        let expressions = self.expressions.iter();
        let formulas = self.formulas.iter().map(|(_, node, _)| node);
        for node in expressions.chain(formulas) {
            node.timeless(&mut parts);
        }
        parts
    }

    /// Words of one letter in which another stands at one position.
    fn but_for_one(&self, letters: &[u64]) -> Vec<Word> {
        const LENGTH: usize = 4;
        let mut words = Vec::new();
        for one in letters.iter().take(64) {
            for other in letters.iter().take(64).filter(|it| *it != one) {
                for at in 0..LENGTH {
                    let mut letters = vec![*other; LENGTH];
                    letters[at] = *one;
                    let from = if at + 1 < LENGTH { LENGTH - 1 } else { 0 };
                    words.push(Word {
                        letters,
                        repeats_from: (!self.ends).then_some(from),
                    });
                }
            }
        }
        // Evenly from all, with a step that has no factor in common with their order.
        let step = (words.len().div_ceil(BUT_FOR_ONE)) | 1;
        words.into_iter().step_by(step).collect()
    }

    /// Words in which one letter stays for just about as long as the longest duration, and another follows.
    fn around_the_bound(&self, letters: &[u64]) -> Vec<Word> {
        let d = self.longest;
        let mut words = Vec::new();
        if d < 2 {
            return words;
        }
        for stay in [d + 1, d, d + 2, d - 1] {
            for one in letters.iter().take(12) {
                for other in letters.iter().rev().take(12).filter(|it| *it != one) {
                    let mut word = vec![*one; stay];
                    word.push(*other);
                    words.push(Word {
                        repeats_from: (!self.ends).then_some(word.len() - 1),
                        letters: word,
                    });
                }
            }
        }
        // Evenly from all, so that the first of them are of all lengths.
        let step = words.len().div_ceil(97).max(1);
        let mixed = (0..step).flat_map(|start| (start..words.len()).step_by(step));
        mixed.map(|at| words[at].clone()).collect()
    }

    fn drawn(&self, draw: &mut Draw) -> Word {
        let letters = self.drawn_letters(draw);
        let repeats_from = (!self.ends).then(|| draw.below(letters.len()));
        Word {
            letters,
            repeats_from,
        }
    }

    /// Letters that stay for as long as durations last, one more and one less.
    pub(super) fn drawn_letters(&self, draw: &mut Draw) -> Vec<u64> {
        let letters = &self.letters;
        let mask = (1_u64 << self.atoms.texts.len()) - 1;
        let d = self.longest;
        let stays = [1, 1, 2, 3, d.saturating_sub(1), d, d + 1, d + 2];
        let mut word = Vec::new();
        for _ in 0..2 + draw.below(5) {
            let letter = match draw.below(3) {
                0 => {
                    let bias = draw.below(3);
                    draw.biased(bias) & mask
                }
                _ => letters[draw.below(letters.len())],
            };
            let stay = stays[draw.below(stays.len())].max(1);
            word.extend(std::iter::repeat_n(letter, stay));
            if word.len() > 3 * (d + 3) {
                break;
            }
        }
        word
    }

    /// A word that tells them apart, made small.
    fn told_apart(&self, mut word: Word) -> Comparison {
        let mut at = 0;
        while at < word.letters.len() && word.letters.len() > 1 {
            let mut shorter = word.clone();
            shorter.letters.remove(at);
            shorter.repeats_from = shorter.repeats_from.map(|from| match from > at {
                true => from - 1,
                false => from.min(shorter.letters.len() - 1),
            });
            match self.differs(&shorter) {
                true => word = shorter,
                false => at += 1,
            }
        }
        for at in 0..word.letters.len() {
            for bit in 0..self.atoms.texts.len() {
                let mut simpler = word.clone();
                simpler.letters[at] &= !(1 << bit);
                if simpler != word && self.differs(&simpler) {
                    word = simpler;
                }
            }
        }
        let (sentence, formula, formula_name) = self.truths(&word);
        let could_come = match self.ends && formula && self.wanted == Wanted::Any {
            true => self.could_come(&word),
            false => None,
        };
        Comparison::Differs(Box::new(Trace {
            steps: self.named(&word.letters),
            repeats_from: word.repeats_from,
            sentence,
            formula,
            formula_name,
            could_come,
        }))
    }

    /// What could come behind a word so that the sentence holds.
    fn could_come(&self, word: &Word) -> Option<(Vec<Vec<String>>, usize)> {
        let longer = continuation(self, word, &mut self.helped.borrow_mut())?;
        let behind = longer.letters.get(word.letters.len()..)?;
        // The word itself, repeated, comes as a whole.
        let from = longer.repeats_from?;
        Some(match behind.is_empty() {
            true => (self.named(&word.letters[from..]), 0),
            false => (self.named(behind), from - word.letters.len()),
        })
    }

    /// What holds at each position.
    fn named(&self, letters: &[u64]) -> Vec<Vec<String>> {
        let names = |letter: &u64| {
            let all = self.atoms.texts.iter().enumerate();
            all.filter(|(bit, _)| letter >> bit & 1 == 1)
                .map(|(_, text)| text.trim_matches(['(', ')']).to_owned())
                .collect()
        };
        letters.iter().map(names).collect()
    }
}

/// The first valuation of each combination of truths of these, as far as there is room.
fn first_of_each(valuations: &[u64], parts: &[&Node]) -> Vec<u64> {
    let all = Word {
        letters: valuations.to_vec(),
        repeats_from: None,
    };
    let truths: Vec<Vec<bool>> = parts.iter().map(|part| part.truth(&all)).collect();
    let mut seen: BTreeSet<Vec<bool>> = BTreeSet::new();
    let mut chosen = Vec::new();
    for (at, letter) in valuations.iter().enumerate() {
        if chosen.len() >= MOST_LETTERS {
            break;
        }
        if seen.insert(truths.iter().map(|it| it[at]).collect()) {
            chosen.push(*letter);
        }
    }
    chosen
}

/// Drawn numbers, the same every time.
///
/// Source: S. Vigna, SplitMix64 (2015), public domain.
pub(super) struct Draw(u64);

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Bits of which an eighth, a half or seven eighths are set, in turn.
    fn biased(&mut self, at: usize) -> u64 {
        let [one, two, three] = [self.next(), self.next(), self.next()];
        match at % 3 {
            0 => one & two & three,
            1 => one,
            _ => one | two | three,
        }
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }
}
