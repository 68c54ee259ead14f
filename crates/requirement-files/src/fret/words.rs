//! Words on which formulas are evaluated, and formulas over them.
//!
//! # Definition
//! A word gives each atom a truth value at each position; it ends, or goes on for ever by repeating its last positions. On a
//! word that ends, `X`, `F`, `U` ask for a position that is there (finite LTL), and `LAST` holds at the last one; on one that
//! goes on, `LAST` holds nowhere. `Y` and `S`, `O` ask for a position before; `Z` and `H`, `T` do not. `FTP` is the first
//! position. FRET's functions are the past formulas that it writes for them: `preBool(i, e)` is `i` at the first position and
//! `e` a position earlier elsewhere; `persisted(n, e)` is `H[0,n] e` where n positions lie before; `occurred(n, e)` is
//! `O[0,n] e`; `persists` and `occurs` look as far ahead.
//!
//! # Method
//! Past operators depend on how often the repeated part was passed, until it no longer matters: the word is written out so
//! often that all past operators of the formula have settled. Unbounded future operators are fixed points, found by two passes
//! against time.
//!
//! # Cost
//! Positions times operators, times the bound of those that begin later than now.

use super::expression::{Bound, Expr};

/// An atom's index.
pub(crate) type Index = usize;

/// A formula whose atoms are numbered.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    Constant(bool),
    Atom(Index),
    Not(Box<Node>),
    And(Box<Node>, Box<Node>),
    Or(Box<Node>, Box<Node>),
    Iff(Box<Node>, Box<Node>),
    Next(Box<Node>),
    Until(Bound, Box<Node>, Box<Node>),
    /// The value at the first position, elsewhere that of the position before.
    Before(bool, Box<Node>),
    Since(Bound, Box<Node>, Box<Node>),
    Last,
    First,
}

/// The atoms of formulas by their texts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Atoms {
    pub(crate) texts: Vec<String>,
}

impl Atoms {
    /// The number of this atom.
    fn index(&mut self, text: String) -> Index {
        match self.texts.iter().position(|known| *known == text) {
            Some(index) => index,
            None => {
                self.texts.push(text);
                self.texts.len() - 1
            }
        }
    }

    /// A formula with its atoms numbered.
    ///
    /// # Errors
    /// What in it has no meaning here.
    pub(crate) fn compile(&mut self, read: &Expr) -> Result<Node, String> {
        let not = |node: Node| Node::Not(Box::new(node));
        let mut one = |inner: &Expr| self.compile(inner).map(Box::new);
        Ok(match read {
            Expr::True => Node::Constant(true),
            Expr::False => Node::Constant(false),
            Expr::Not(inner) => Node::Not(one(inner)?),
            Expr::And(left, right) => Node::And(one(left)?, one(right)?),
            Expr::Or(left, right) => Node::Or(one(left)?, one(right)?),
            Expr::Implies(left, right) => Node::Or(Box::new(Node::Not(one(left)?)), one(right)?),
            Expr::Iff(left, right) => Node::Iff(one(left)?, one(right)?),
            Expr::Xor(left, right) => not(Node::Iff(one(left)?, one(right)?)),
            Expr::Prefix(sign, bound, inner) => {
                let inner = one(inner)?;
                return prefix(*sign, *bound, inner);
            }
            Expr::Infix('U', bound, left, right) => Node::Until(*bound, one(left)?, one(right)?),
            Expr::Infix('V', bound, left, right) => not(Node::Until(
                *bound,
                Box::new(Node::Not(one(left)?)),
                Box::new(Node::Not(one(right)?)),
            )),
            Expr::Infix('S', bound, left, right) => Node::Since(*bound, one(left)?, one(right)?),
            Expr::Infix(_, bound, left, right) => not(Node::Since(
                *bound,
                Box::new(Node::Not(one(left)?)),
                Box::new(Node::Not(one(right)?)),
            )),
            Expr::Point("LAST") => Node::Last,
            Expr::Point(_) => Node::First,
            Expr::Probability(..) => return Err("a probability stands inside of it".into()),
            Expr::Call(name, arguments) => return self.call(name, arguments, read),
            atom => Node::Atom(self.index(atom.to_string())),
        })
    }

    fn call(&mut self, name: &str, arguments: &[Expr], whole: &Expr) -> Result<Node, String> {
        let count = |argument: &Expr| match argument {
            Expr::Number(number) => number
                .parse::<u32>()
                .map_err(|_| format!("`{number}` counts no positions")),
            other => Err(format!("`{other}` counts no positions")),
        };
        match (name, arguments) {
            ("preBool", [first, inner]) => {
                let first = match first {
                    Expr::True => true,
                    Expr::False => false,
                    other => return Err(format!("`preBool` begins with `{other}`")),
                };
                Ok(Node::Before(first, Box::new(self.compile(inner)?)))
            }
            ("persisted", [steps, inner]) => {
                let steps = count(steps)?;
                let held = prefix('H', Some((0, steps)), Box::new(self.compile(inner)?))?;
                // So many positions lie before: none of the last `steps` was the first.
                let Some(earlier) = steps.checked_sub(1) else {
                    return Ok(held);
                };
                let young = prefix('O', Some((0, earlier)), Box::new(Node::First))?;
                Ok(Node::And(
                    Box::new(held),
                    Box::new(Node::Not(Box::new(young))),
                ))
            }
            ("occurred", [steps, inner]) => prefix(
                'O',
                Some((0, count(steps)?)),
                Box::new(self.compile(inner)?),
            ),
            ("persists", [steps, inner]) => prefix(
                'G',
                Some((0, count(steps)?)),
                Box::new(self.compile(inner)?),
            ),
            ("occurs", [steps, inner]) => prefix(
                'F',
                Some((0, count(steps)?)),
                Box::new(self.compile(inner)?),
            ),
            ("prevOcc" | "nextOcc", _) => Err(format!("`{name}` is not evaluated here")),
            _ => Ok(Node::Atom(self.index(whole.to_string()))),
        }
    }
}

fn prefix(sign: char, bound: Bound, inner: Box<Node>) -> Result<Node, String> {
    let all = || Box::new(Node::Constant(true));
    let not = |node: Node| Node::Not(Box::new(node));
    if bound.is_some() && matches!(sign, 'X' | 'Y' | 'Z') {
        return Err(format!("`{sign}` has a bound"));
    }
    Ok(match sign {
        'X' => Node::Next(inner),
        'F' => Node::Until(bound, all(), inner),
        'G' => not(Node::Until(bound, all(), Box::new(Node::Not(inner)))),
        'Y' => Node::Before(false, inner),
        'Z' => Node::Before(true, inner),
        'O' => Node::Since(bound, all(), inner),
        'H' => not(Node::Since(bound, all(), Box::new(Node::Not(inner)))),
        _ => return Err(format!("`{sign}` is not an operator")),
    })
}

impl Node {
    /// How many past operators there are, and the sum of the bounds of the bounded ones.
    pub(crate) fn memory(&self) -> (usize, usize) {
        let add = |one: (usize, usize), two: (usize, usize)| (one.0 + two.0, one.1 + two.1);
        match self {
            Self::Constant(_) | Self::Atom(_) | Self::Last | Self::First => (0, 0),
            Self::Not(inner) | Self::Next(inner) => inner.memory(),
            Self::And(left, right)
            | Self::Or(left, right)
            | Self::Iff(left, right)
            | Self::Until(_, left, right) => add(left.memory(), right.memory()),
            Self::Before(_, inner) => add(inner.memory(), (1, 1)),
            Self::Since(bound, left, right) => {
                let bound = bound.map_or(0, |(_, to)| to as usize + 1);
                add(add(left.memory(), right.memory()), (1, bound))
            }
        }
    }

    /// The longest bound in it.
    pub(crate) fn longest(&self) -> usize {
        match self {
            Self::Constant(_) | Self::Atom(_) | Self::Last | Self::First => 0,
            Self::Not(inner) | Self::Next(inner) | Self::Before(_, inner) => inner.longest(),
            Self::And(left, right) | Self::Or(left, right) | Self::Iff(left, right) => {
                left.longest().max(right.longest())
            }
            Self::Until(bound, left, right) | Self::Since(bound, left, right) => {
                let own = bound.map_or(0, |(_, to)| to as usize);
                own.max(left.longest()).max(right.longest())
            }
        }
    }

    /// Its largest parts in which nothing depends on time; whether it is one itself.
    pub(crate) fn timeless<'n>(&'n self, parts: &mut Vec<&'n Self>) -> bool {
        let before = parts.len();
        let is_one = match self {
            Self::Constant(_) | Self::Atom(_) => true,
            Self::Last | Self::First => false,
            Self::Not(inner) => inner.timeless(parts),
            Self::And(left, right) | Self::Or(left, right) | Self::Iff(left, right) => {
                let both = [left.timeless(parts), right.timeless(parts)];
                both == [true, true]
            }
            Self::Next(inner) | Self::Before(_, inner) => {
                inner.timeless(parts);
                false
            }
            Self::Until(_, left, right) | Self::Since(_, left, right) => {
                left.timeless(parts);
                right.timeless(parts);
                false
            }
        };
        if is_one {
            parts.truncate(before);
            parts.push(self);
        }
        is_one
    }

    /// The truth at each position.
    pub(crate) fn truth(&self, word: &Word) -> Vec<bool> {
        let length = word.letters.len();
        let map = |values: Vec<bool>, other: Vec<bool>, join: fn(bool, bool) -> bool| {
            values
                .into_iter()
                .zip(other)
                .map(|(a, b)| join(a, b))
                .collect()
        };
        match self {
            Self::Constant(value) => vec![*value; length],
            Self::Atom(index) => word.letters.iter().map(|it| it >> index & 1 == 1).collect(),
            Self::Last => (0..length).map(|at| word.next(at).is_none()).collect(),
            Self::First => (0..length).map(|at| at == 0).collect(),
            Self::Not(inner) => inner.truth(word).into_iter().map(|it| !it).collect(),
            Self::And(left, right) => map(left.truth(word), right.truth(word), |a, b| a && b),
            Self::Or(left, right) => map(left.truth(word), right.truth(word), |a, b| a || b),
            Self::Iff(left, right) => map(left.truth(word), right.truth(word), |a, b| a == b),
            Self::Next(inner) => {
                let inner = inner.truth(word);
                (0..length)
                    .map(|at| word.next(at).is_some_and(|next| inner[next]))
                    .collect()
            }
            Self::Before(first, inner) => {
                let inner = inner.truth(word);
                (0..length)
                    .map(|at| if at == 0 { *first } else { inner[at - 1] })
                    .collect()
            }
            Self::Until(bound, left, right) => {
                until(word, *bound, &left.truth(word), &right.truth(word))
            }
            Self::Since(bound, left, right) => {
                since(length, *bound, &left.truth(word), &right.truth(word))
            }
        }
    }
}

fn until(word: &Word, bound: Bound, left: &[bool], right: &[bool]) -> Vec<bool> {
    let length = left.len();
    let Some((from, to)) = bound else {
        // The least fixed point: false is assumed where the word goes round, and then what that gave.
        let mut values = vec![false; length];
        for _ in 0..2 {
            for at in (0..length).rev() {
                let later = word.next(at).is_some_and(|next| values[next]);
                values[at] = right[at] || (left[at] && later);
            }
        }
        return values;
    };
    if from == 0 {
        let mut steps = vec![u64::MAX; length];
        for _ in 0..2 {
            for at in (0..length).rev() {
                let later = word.next(at).map_or(u64::MAX, |next| steps[next]);
                steps[at] = match (right[at], left[at]) {
                    (true, _) => 0,
                    (false, true) => later.saturating_add(1),
                    (false, false) => u64::MAX,
                };
            }
        }
        return steps.into_iter().map(|it| it <= u64::from(to)).collect();
    }
    let at_position = |start: usize| {
        let mut at = start;
        for step in 0..=to {
            if step >= from && right[at] {
                return true;
            }
            match word.next(at) {
                Some(next) if left[at] => at = next,
                _ => return false,
            }
        }
        false
    };
    (0..length).map(at_position).collect()
}

fn since(length: usize, bound: Bound, left: &[bool], right: &[bool]) -> Vec<bool> {
    let (from, to) = bound.map_or((0, usize::MAX), |(from, to)| (from as usize, to as usize));
    if from == 0 {
        let mut before = usize::MAX;
        let steps = (0..length).map(|at| {
            before = match (right[at], left[at]) {
                (true, _) => 0,
                (false, true) => before.saturating_add(1),
                (false, false) => usize::MAX,
            };
            before
        });
        // As many steps as there can be are none.
        return steps.map(|it| it <= to && it < usize::MAX).collect();
    }
    let at_position = |start: usize| {
        let mut at = start;
        for step in 0..=to {
            if step >= from && right[at] {
                return true;
            }
            if !left[at] || at == 0 {
                return false;
            }
            at -= 1;
        }
        false
    };
    (0..length).map(at_position).collect()
}

/// A word: of each position the bits of the atoms that hold there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Word {
    pub(crate) letters: Vec<u64>,
    /// From where on it repeats for ever; `None` if it ends.
    pub(crate) repeats_from: Option<usize>,
}

impl Word {
    /// The position behind another.
    pub(crate) fn next(&self, at: usize) -> Option<usize> {
        match at + 1 < self.letters.len() {
            true => Some(at + 1),
            false => self.repeats_from,
        }
    }

    /// The same word, with its repeated part written out until past operators with this memory have settled.
    pub(crate) fn written_out(&self, (operators, bounds): (usize, usize)) -> Self {
        let Some(start) = self.repeats_from.filter(|_| operators > 0) else {
            return self.clone();
        };
        let cycle = self.letters[start..].to_vec();
        let rounds = operators + 2 + bounds.div_ceil(cycle.len());
        let mut letters = self.letters.clone();
        for _ in 0..rounds {
            letters.extend(&cycle);
        }
        let repeats_from = Some(letters.len() - cycle.len());
        Self {
            letters,
            repeats_from,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fret::expression::formula;

    /// The truth by the definitions, each temporal operator by looking at all positions that it speaks of.
    fn by_definition(read: &Expr, word: &Word, at: usize) -> bool {
        // A position by how often it was passed: an index into the word written out far enough.
        let holds = |inner: &Expr, at: usize| by_definition(inner, word, at);
        let length = word.letters.len();
        let last = match word.repeats_from {
            // A word of four letters shows all that it ever shows within twice as many.
            Some(_) => at + 12,
            None => length - 1,
        };
        let letter = |at: usize| match word.repeats_from {
            Some(from) if at >= length => word.letters[from + (at - from) % (length - from)],
            _ => word.letters[at],
        };
        match read {
            Expr::True => true,
            Expr::Name(name) => letter(at) >> (name.as_bytes()[0] - b'a') & 1 == 1,
            Expr::Not(inner) => !holds(inner, at),
            Expr::And(left, right) => holds(left, at) && holds(right, at),
            Expr::Or(left, right) => holds(left, at) || holds(right, at),
            Expr::Point("LAST") => word.repeats_from.is_none() && at == last,
            Expr::Point(_) => at == 0,
            Expr::Prefix('X', _, inner) => {
                (word.repeats_from.is_some() || at < last) && holds(inner, at + 1)
            }
            Expr::Prefix('Y', _, inner) => at > 0 && holds(inner, at - 1),
            Expr::Prefix('Z', _, inner) => at == 0 || holds(inner, at - 1),
            Expr::Prefix(sign, bound, inner) => {
                let (from, to) = bound.unwrap_or((0, u32::MAX));
                let within = |step: usize| step >= from as usize && step <= to as usize;
                let ahead = (at..=last).filter(|it| within(it - at));
                let behind = (0..=at).filter(|it| within(at - it));
                match sign {
                    'F' => ahead.into_iter().any(|it| holds(inner, it)),
                    'G' => ahead.into_iter().all(|it| holds(inner, it)),
                    'O' => behind.into_iter().any(|it| holds(inner, it)),
                    _ => behind.into_iter().all(|it| holds(inner, it)),
                }
            }
            Expr::Infix('U', _, left, right) => {
                (at..=last).any(|it| holds(right, it) && (at..it).all(|before| holds(left, before)))
            }
            Expr::Infix('V', _, left, right) => {
                (at..=last).all(|it| holds(right, it) || (at..it).any(|before| holds(left, before)))
            }
            Expr::Infix('S', _, left, right) => {
                (0..=at).any(|it| holds(right, it) && (it + 1..=at).all(|since| holds(left, since)))
            }
            other => unreachable!("{other}"),
        }
    }

    #[test]
    fn truth_is_that_of_the_definitions() {
        let formulas = [
            "(F[0,2] a) | (F[0,1] LAST)",
            "LAST V (a -> (X b))",
            "a U b",
            "(G (a | (F b)))",
            "(b V (a | b)) & (F[2,4] b)",
            "(H (a | (O[0,2] b)))",
            "(G ((Y a) -> ((H[0,1] b) & (! (O[0,1] FTP)))))",
            "(F (a S (b & (Z (! a)))))",
            "(G[1,3] (a U (X b)))",
        ];
        let mut tried = 0;
        for text in formulas {
            // Implications by what they are.
            let read = formula(
                &text
                    .replace("LAST V (a -> (X b))", "LAST V ((! a) | (X b))")
                    .replace("(Y a) -> ", "(! (Y a)) | "),
            );
            let read = read.expect(text);
            let mut atoms = Atoms {
                texts: vec!["a".into(), "b".into()],
            };
            let node = atoms.compile(&read).expect(text);
            for number in 0..4_u64.pow(4) {
                let letters: Vec<u64> = (0..4).map(|at| number >> (2 * at) & 3).collect();
                for repeats_from in [None, Some(0), Some(1), Some(3)] {
                    let letters = letters.clone();
                    let word = Word {
                        letters,
                        repeats_from,
                    };
                    let written = word.written_out(node.memory());
                    let expected = by_definition(&read, &word, 0);
                    assert_eq!(node.truth(&written)[0], expected, "{text} {word:?}");
                    tried += 1;
                }
            }
        }
        assert_eq!(tried, 9 * 256 * 4);
    }
}
