//! Whether a sentence of ours and a formula of FRET's mean the same: on words.
//!
//! # Definition
//! Two questions, each decided on words over the truth values of the comparisons and names of both:
//!
//! * *whole runs*: both hold of the same words that go on for ever (FRET's `ftInfAUExpanded`, else `ftExpanded` where `LAST`
//!   holds nowhere);
//! * *runs that end*: both hold of the same words that end (FRET's `ptExpanded` at the last position, and `ftExpanded` at the
//!   first). Here FRET excuses what could still have come in time, and a sentence of ours does not: what a monitor says of an
//!   unfinished recording is a matter of its ending.
//!
//! # Method
//! All words up to a length that the number of letters allows, short ones first; then drawn ones whose letters stay for as long
//! as durations last, one more and one less, so that every bound is met from both sides. Letters are all valuations where those
//! are few, else of every combination of the sentence's parts and their operands two valuations. A word that tells them apart is made as short and
//! as false as it goes.
//!
//! # Guarantee
//! A word that is shown tells them apart (each truth is computed by the definition of its side). That none was found is no
//! proof: how many words were tried, and up to which length all, is said. Comparisons count as independent: a word may have
//! `x > 1` and `x < 0` at once.
//!
//! # Cost
//! Words times positions times bounds; durations beyond [`LONGEST`] are refused.

use super::expression;
use super::words::{Atoms, Node, Word};
use requirement_lang::expression::Expression;
use requirement_lang::semantics::{Word as SentenceWord, holds};
use requirement_lang::sentence::{Amount, Sentence};

/// The longest duration in time points.
pub const LONGEST: usize = 1_000;
/// The most comparisons and names.
const MOST_ATOMS: usize = 60;
/// How many words of all lengths are tried.
const ALL_WORDS: usize = 3_000;
/// How many drawn ones, at most, and steps of work on them.
const DRAWN_WORDS: usize = 1_500;
const WORK: usize = 60_000_000;
const MOST_LETTERS: usize = 24;

/// What a comparison came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Comparison {
    /// No word told them apart.
    Same {
        /// How many words were tried.
        words: usize,
        /// Up to this length, all words over the chosen letters were.
        all_up_to: usize,
    },
    /// They differ.
    Differs(Box<Trace>),
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
}

impl std::fmt::Display for Trace {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut steps: Vec<String> = Vec::new();
        for (at, step) in self.steps.iter().enumerate() {
            let what = match step.is_empty() {
                true => "nothing holds".to_owned(),
                false => step.join(", "),
            };
            let from = if self.repeats_from == Some(at) {
                "for ever: "
            } else {
                ""
            };
            steps.push(format!("{from}{what}"));
        }
        let end = if self.repeats_from.is_none() {
            "; the run ends"
        } else {
            ""
        };
        let word = |it: bool| if it { "holds" } else { "does not hold" };
        write!(
            out,
            "{}{end}: the sentence {}, FRET's {} {}",
            steps.join("; then "),
            word(self.sentence),
            self.formula_name,
            word(self.formula)
        )
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
    match Setup::new(sentence, definitions, step_secs, formulas, ends) {
        Ok(setup) => setup.compare(),
        Err(reason) => Comparison::NotCompared(reason),
    }
}

struct Setup<'s> {
    sentence: &'s Sentence,
    step_secs: f64,
    /// What each atom of the sentence is.
    own: Vec<(String, Node)>,
    formulas: Vec<(&'static str, Node, bool)>,
    atoms: Atoms,
    ends: bool,
    memory: (usize, usize),
    longest: usize,
}

impl<'s> Setup<'s> {
    fn new(
        sentence: &'s Sentence,
        definitions: &[(String, String)],
        step_secs: f64,
        formulas: &[Formula<'_>],
        ends: bool,
    ) -> Result<Self, String> {
        let mut atoms = Atoms::default();
        let mut own = Vec::new();
        for text in sentence.propositions() {
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
        let of_sentence = atoms.texts.clone();
        let mut read = Vec::new();
        for formula in formulas {
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
            return Err(format!(
                "FRET's formula speaks of `{other}`, and the sentence does not"
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
        let durations = sentence.stages.iter().filter_map(|stage| {
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
        Ok(Self {
            sentence,
            step_secs,
            own,
            formulas: read,
            atoms,
            ends,
            memory,
            longest,
        })
    }

    /// The truth of the sentence and of the first formula that differs from it; of the last one, if none does.
    fn truths(&self, word: &Word) -> (bool, bool, &'static str) {
        let word = &word.written_out(self.memory);
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
        let sentence = holds(self.sentence, &sentence_word, self.step_secs);
        let mut last = (sentence, sentence, "formula");
        for (name, node, at_end) in &self.formulas {
            let values = node.truth(word);
            let value = match at_end {
                true => values.last(),
                false => values.first(),
            };
            last = (sentence, value.copied().unwrap_or(true), name);
            if last.0 != last.1 {
                break;
            }
        }
        last
    }

    fn differs(&self, word: &Word) -> bool {
        let (sentence, formula, _) = self.truths(word);
        sentence != formula
    }

    fn compare(&self) -> Comparison {
        let letters = self.letters();
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
            all_up_to = length;
        }
        let mut draw = Draw(0x5eed);
        let long = 3 * (self.longest + 3) + self.memory.1;
        let most = (WORK / (long * long / 4).max(1)).clamp(40, DRAWN_WORDS);
        let around = self
            .around_the_bound(&letters)
            .into_iter()
            .take(2 * most / 3);
        let mut words: Vec<Word> = around.collect();
        while words.len() < most {
            words.push(self.drawn(&letters, &mut draw));
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

    /// The letters of which words are made.
    fn letters(&self) -> Vec<u64> {
        let count = self.atoms.texts.len();
        if count <= 3 {
            return (0..1_u64 << count).collect();
        }
        let parts = self.parts();
        let mut draw = Draw(7);
        let mask = (1_u64 << count) - 1;
        let valuations: Vec<u64> = match count <= 12 {
            true => (0..1_u64 << count).collect(),
            false => (0..4096).map(|at| draw.biased(at) & mask).collect(),
        };
        let key = |letter: u64| -> Vec<bool> {
            let truths = parts.iter().map(|part| self.now(part, letter));
            truths.collect()
        };
        // One of each kind, and then another of it, from the other end.
        let mut letters = first_of_each(valuations.iter().copied(), &key);
        letters.extend(first_of_each(valuations.iter().rev().copied(), &key));
        letters.sort_unstable();
        letters.dedup();
        letters
    }

    /// The parts of the sentence, with their operands and the operands of those.
    fn parts(&self) -> Vec<&Expression> {
        const MOST: usize = 10;
        let mut parts = self.sentence.expressions();
        let mut from = 0;
        for _ in 0..2 {
            let deeper: Vec<&Expression> =
                parts[from..].iter().flat_map(|it| it.operands()).collect();
            from = parts.len();
            parts.extend(deeper);
        }
        parts.truncate(MOST);
        parts
    }

    /// The truth of a part of the sentence in a word of one letter.
    fn now(&self, part: &Expression, letter: u64) -> bool {
        let word = Word {
            letters: vec![letter],
            repeats_from: Some(0),
        };
        part.eval(&|text| {
            let atom = self.own.iter().find(|(known, _)| known == text);
            atom.is_some_and(|(_, node)| node.truth(&word)[0])
        })
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

    fn drawn(&self, letters: &[u64], draw: &mut Draw) -> Word {
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
        let repeats_from = (!self.ends).then(|| draw.below(word.len()));
        Word {
            letters: word,
            repeats_from,
        }
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
        let names = |letter: &u64| {
            let all = self.atoms.texts.iter().enumerate();
            all.filter(|(bit, _)| letter >> bit & 1 == 1)
                .map(|(_, text)| text.trim_matches(['(', ')']).to_owned())
                .collect()
        };
        Comparison::Differs(Box::new(Trace {
            steps: word.letters.iter().map(names).collect(),
            repeats_from: word.repeats_from,
            sentence,
            formula,
            formula_name,
        }))
    }
}

/// The first letter of each kind, as far as there is room.
fn first_of_each(letters: impl Iterator<Item = u64>, kind: &dyn Fn(u64) -> Vec<bool>) -> Vec<u64> {
    let mut seen: Vec<Vec<bool>> = Vec::new();
    let mut chosen = Vec::new();
    for letter in letters {
        if chosen.len() >= MOST_LETTERS / 2 {
            break;
        }
        let kind = kind(letter);
        if !seen.contains(&kind) {
            seen.push(kind);
            chosen.push(letter);
        }
    }
    chosen
}

/// Drawn numbers, the same every time.
///
/// Source: S. Vigna, SplitMix64 (2015), public domain.
struct Draw(u64);

impl Draw {
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

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }
}
