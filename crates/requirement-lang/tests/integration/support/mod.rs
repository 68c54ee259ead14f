//! Sentences put together from parts, and words over four propositions, for tests of the meaning.

#![allow(dead_code, reason = "each test uses a part")]

use requirement_lang::Span;
use requirement_lang::compile::property::{Model, Property, property};
use requirement_lang::expression::{Atom, Expression};
use requirement_lang::semantics::{self, Word};
use requirement_lang::sentence::{
    Condition, ConditionKind, Duration, Scope, ScopeKind, Sentence, Stage, Timing,
};
use temporal::formula::{Formula, Interval, Window};

/// The propositions: mode, condition, response, stop; bit `i` of a letter is proposition `i`.
pub const NAMES: [&str; 5] = ["m", "c", "r", "q", "s"];

pub fn name(index: usize) -> Expression {
    Expression::Atom(Atom {
        text: NAMES[index].to_owned(),
        span: Span::default(),
    })
}

/// A sentence over these parts.
pub fn sentence(
    scope: ScopeKind,
    condition: Option<ConditionKind>,
    stages: Vec<(Timing, Expression)>,
) -> Sentence {
    let stage = |(timing, response)| Stage {
        timing,
        response,
        span: Span::default(),
    };
    Sentence {
        scope: Scope {
            kind: scope,
            mode: if scope == ScopeKind::Global {
                Expression::True
            } else {
                name(0)
            },
            span: Span::default(),
        },
        condition: condition.map(|kind| Condition {
            kind,
            expression: name(1),
            span: Span::default(),
        }),
        component: "robot".to_owned(),
        probability: None,
        stages: stages.into_iter().map(stage).collect(),
    }
}

pub const CONDITIONS: [Option<ConditionKind>; 4] = [
    None,
    Some(ConditionKind::Upon),
    Some(ConditionKind::Whenever),
    Some(ConditionKind::Unless),
];

/// Every timing, those with a duration for 0, 1 and 2 steps.
pub fn timings() -> Vec<Timing> {
    let mut all = vec![
        Timing::Immediately,
        Timing::Next,
        Timing::Eventually,
        Timing::Always,
        Timing::Never,
        Timing::Until(name(3)),
        Timing::Before(name(3)),
    ];
    for steps in 0..=2 {
        let duration = Duration::steps(steps);
        all.push(Timing::Within(duration.clone()));
        all.push(Timing::For(duration.clone()));
        all.push(Timing::After(duration));
    }
    all
}

/// Every combination of scope, condition and timing of one stage.
pub fn single_stage_sentences() -> Vec<Sentence> {
    let mut all = Vec::new();
    for scope in ScopeKind::ALL {
        for condition in CONDITIONS {
            for timing in timings() {
                all.push(sentence(scope, condition, vec![(timing, name(2))]));
            }
        }
    }
    all
}

/// The letters that differ in the propositions of the sentence.
pub fn letters(sentence: &Sentence) -> Vec<u64> {
    let used = sentence.propositions();
    let mask = (0..NAMES.len())
        .filter(|index| used.contains(&NAMES[*index]))
        .fold(0_u64, |mask, index| mask | 1 << index);
    (0..1 << NAMES.len())
        .filter(|letter| letter & !mask == 0)
        .collect()
}

/// Calls `visit` with each word of this length.
pub fn words(letters: &[u64], length: usize, visit: &mut dyn FnMut(&[u64])) {
    let mut indices = vec![0; length];
    let mut word = vec![letters[0]; length];
    loop {
        visit(&word);
        let Some(place) = (0..length).find(|place| indices[*place] + 1 < letters.len()) else {
            return;
        };
        for earlier in 0..place {
            indices[earlier] = 0;
            word[earlier] = letters[0];
        }
        indices[place] += 1;
        word[place] = letters[indices[place]];
    }
}

fn truth_in(word: &[u64]) -> impl Fn(usize, &str) -> bool {
    move |position, text| {
        let index = NAMES.iter().position(|name| *name == text).unwrap();
        word[position] >> index & 1 == 1
    }
}

/// The meaning of the sentence on a finite word.
pub fn holds_finite(sentence: &Sentence, word: &[u64]) -> bool {
    let truth = truth_in(word);
    let word = Word {
        truth: &truth,
        length: word.len(),
        repeats_from: None,
    };
    semantics::holds(sentence, &word, 1.0)
}

/// The number of triggers in a finite word.
pub fn triggers(sentence: &Sentence, word: &[u64]) -> usize {
    let truth = truth_in(word);
    let word = Word {
        truth: &truth,
        length: word.len(),
        repeats_from: None,
    };
    semantics::triggers(sentence, &word)
}

/// The meaning of the sentence on the word `prefix cycle cycle ...`.
pub fn holds_lasso(sentence: &Sentence, prefix: &[u64], cycle: &[u64]) -> bool {
    let both = [prefix, cycle].concat();
    let truth = truth_in(&both);
    let word = Word {
        truth: &truth,
        length: both.len(),
        repeats_from: Some(prefix.len()),
    };
    semantics::holds(sentence, &word, 1.0)
}

/// The truth of a formula at each position of a finite word (LTLf with past), by its definition,
/// as bits. `atoms[i]` is the bit of the letters that atom `i` reads.
pub fn truth(formula: &Formula, atoms: &[usize], word: &[u64]) -> u64 {
    let length = word.len();
    let all = (1_u64 << length) - 1;
    let at = |bits: u64, position: usize| position < length && bits >> position & 1 == 1;
    let collect = |holds: &dyn Fn(usize) -> bool| {
        (0..length)
            .filter(|position| holds(*position))
            .fold(0, |bits, position| bits | 1 << position)
    };
    let inner = |formula: &Formula| truth(formula, atoms, word);
    match formula {
        Formula::True => all,
        Formula::False => 0,
        Formula::Atom(atom) => collect(&|position| word[position] >> atoms[atom.0] & 1 == 1),
        Formula::Not(operand) => all & !inner(operand),
        Formula::And(operands) => operands
            .iter()
            .fold(all, |bits, operand| bits & inner(operand)),
        Formula::Or(operands) => operands
            .iter()
            .fold(0, |bits, operand| bits | inner(operand)),
        Formula::Implies(left, right) => (all & !inner(left)) | inner(right),
        Formula::Iff(left, right) => all & !(inner(left) ^ inner(right)),
        Formula::Next(operand) => inner(operand) >> 1,
        Formula::Rise(operand) => {
            let bits = inner(operand);
            bits & !(bits << 1)
        }
        Formula::Eventually(interval, operand) => {
            let bits = inner(operand);
            collect(&|position| window(interval, position, length).any(|later| at(bits, later)))
        }
        Formula::Always(interval, operand) => {
            let bits = inner(operand);
            collect(&|position| window(interval, position, length).all(|later| at(bits, later)))
        }
        Formula::Until(interval, left, right) => {
            let (left, right) = (inner(left), inner(right));
            let reached = |position: usize, later: usize| {
                at(right, later) && (position..later).all(|k| at(left, k))
            };
            collect(&|position| {
                window(interval, position, length).any(|later| reached(position, later))
            })
        }
        Formula::WeakUntil(_, left, right) => {
            let (left, right) = (inner(left), inner(right));
            collect(&|position| {
                (position..length)
                    .find(|later| !at(left, *later) || at(right, *later))
                    .is_none_or(|later| at(right, later))
            })
        }
        Formula::Once(_, operand) => {
            let bits = inner(operand);
            collect(&|position| (0..=position).any(|earlier| at(bits, earlier)))
        }
        Formula::Historically(_, operand) => {
            let bits = inner(operand);
            collect(&|position| (0..=position).all(|earlier| at(bits, earlier)))
        }
        other => panic!("no sentence has a formula with {other}"),
    }
}

/// The positions of the word in the window.
fn window(interval: &Interval, position: usize, length: usize) -> std::ops::Range<usize> {
    let window = interval
        .window(temporal::formula::TimeModel::Discrete)
        .unwrap();
    let Window::Samples { low, high } = window else {
        panic!("these windows are in samples");
    };
    let end = high.map_or(length, |high| position + high as usize + 1);
    (position + low as usize).min(length)..end.min(length)
}

/// The bits of the atoms of a compiled formula.
pub fn bits(atoms: &[temporal::formula::AtomText]) -> Vec<usize> {
    let bit = |text: &str| NAMES.iter().position(|name| *name == text).unwrap();
    atoms.iter().map(|atom| bit(&atom.text)).collect()
}

/// The property of a sentence whose propositions keep their names.
pub fn property_of(sentence: &Sentence) -> Property {
    let model = Model {
        step_secs: None,
        proposition: &|text| Some(text.to_owned()),
    };
    property(sentence, &model).unwrap()
}

/// The letters with the propositions numbered as in the property.
pub fn renumbered(word: &[u64], property: &Property) -> Vec<u64> {
    let bit = |text: &String| NAMES.iter().position(|name| name == text).unwrap();
    let bits: Vec<usize> = property.propositions.iter().map(bit).collect();
    let letter = |letter: &u64| {
        (bits.iter().enumerate()).fold(0, |renumbered, (number, bit)| {
            renumbered | (letter >> bit & 1) << number
        })
    };
    word.iter().map(letter).collect()
}
