//! Truth of a formula on an ultimately periodic word `u v v v ...`, by the definition itself.
//!
//! The positions of `u v` are the nodes of a graph in which each has one successor, the last one's
//! being the first of `v`. The truth at a position depends on the node alone, so each operator is a
//! table over the nodes. An unbounded until is decided by looking `|u v|` steps ahead of its lower
//! bound: from there on nodes repeat.
//!
//! Cost `O(|phi| n (n + h))` for `n` nodes and the largest bound `h`. This is the oracle that the
//! automata are tested against: it shares no code with them.

use super::{Ltl, StepBound};

/// Nodes of an ultimately periodic word.
struct Lasso<'a> {
    letters: Vec<&'a u64>,
    loop_start: usize,
}

impl Lasso<'_> {
    fn successor(&self, node: usize) -> usize {
        if node + 1 < self.letters.len() {
            node + 1
        } else {
            self.loop_start
        }
    }
}

impl Ltl {
    /// Whether the formula holds at the start of the word `prefix cycle cycle ...`.
    ///
    /// A letter is a set of atomic propositions: bit `i` is proposition `i`. Propositions from 64 on
    /// are false. An empty `cycle` is read as a cycle of one letter in which nothing holds.
    #[must_use]
    pub fn holds_on_lasso(&self, prefix: &[u64], cycle: &[u64]) -> bool {
        let cycle = if cycle.is_empty() { &[0][..] } else { cycle };
        let lasso = Lasso {
            letters: prefix.iter().chain(cycle).collect(),
            loop_start: prefix.len(),
        };
        truth(self, &lasso)[0]
    }
}

/// Truth at each node.
fn truth(formula: &Ltl, lasso: &Lasso<'_>) -> Vec<bool> {
    let nodes = lasso.letters.len();
    match formula {
        Ltl::True => vec![true; nodes],
        Ltl::False => vec![false; nodes],
        Ltl::Ap(index) => (lasso.letters.iter())
            .map(|letter| *index < 64 && **letter >> index & 1 == 1)
            .collect(),
        Ltl::Not(inner) => not(truth(inner, lasso)),
        Ltl::And(left, right) => and(truth(left, lasso), &truth(right, lasso)),
        Ltl::Or(left, right) => not(and(not(truth(left, lasso)), &not(truth(right, lasso)))),
        Ltl::Next(inner) => {
            let inner = truth(inner, lasso);
            (0..nodes)
                .map(|node| inner[lasso.successor(node)])
                .collect()
        }
        Ltl::Until(left, right, bound) => {
            until(&truth(left, lasso), &truth(right, lasso), *bound, lasso)
        }
        Ltl::Release(left, right, bound) => {
            let (left, right) = (not(truth(left, lasso)), not(truth(right, lasso)));
            not(until(&left, &right, *bound, lasso))
        }
        Ltl::WeakUntil(left, right, bound) => {
            let (left, right) = (truth(left, lasso), truth(right, lasso));
            let waiting = and(left.clone(), &not(right.clone()));
            let given_up = and(not(left), &not(right));
            not(until(&waiting, &given_up, *bound, lasso))
        }
        Ltl::Finally(inner, bound) => {
            until(&vec![true; nodes], &truth(inner, lasso), *bound, lasso)
        }
        Ltl::Globally(inner, bound) => {
            let inner = not(truth(inner, lasso));
            not(until(&vec![true; nodes], &inner, *bound, lasso))
        }
    }
}

fn not(mut table: Vec<bool>) -> Vec<bool> {
    table.iter_mut().for_each(|value| *value = !*value);
    table
}

fn and(mut left: Vec<bool>, right: &[bool]) -> Vec<bool> {
    (left.iter_mut().zip(right)).for_each(|(left, right)| *left &= right);
    left
}

fn until(left: &[bool], right: &[bool], bound: StepBound, lasso: &Lasso<'_>) -> Vec<bool> {
    let nodes = left.len();
    let last = (bound.upper).unwrap_or_else(|| bound.lower.saturating_add(nodes as u64));
    let from = |start: usize| {
        let mut node = start;
        for step in 0..=last {
            if step >= bound.lower && right[node] {
                return true;
            }
            if !left[node] {
                return false;
            }
            node = lasso.successor(node);
        }
        false
    };
    (0..nodes).map(from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: u64 = 1;
    const B: u64 = 2;

    #[test]
    fn operators_on_words_worked_out_by_hand() {
        let until = Ltl::until(Ltl::Ap(0), Ltl::Ap(1));
        assert!(until.holds_on_lasso(&[A, A, B], &[0]));
        assert!(!until.holds_on_lasso(&[A, 0, B], &[0]));
        assert!(!until.holds_on_lasso(&[], &[A]));
        assert!(Ltl::weak_until(Ltl::Ap(0), Ltl::Ap(1)).holds_on_lasso(&[], &[A]));
        let release = Ltl::release(Ltl::Ap(0), Ltl::Ap(1));
        assert!(release.holds_on_lasso(&[B, A | B], &[0]));
        assert!(!release.holds_on_lasso(&[B, A], &[B]));
        let recurring = Ltl::globally(Ltl::finally(Ltl::Ap(0)));
        assert!(recurring.holds_on_lasso(&[0, 0], &[0, A]));
        assert!(!recurring.holds_on_lasso(&[A, A], &[0]));
    }

    #[test]
    fn windows_include_both_ends() {
        let within = |lower, upper| {
            Ltl::finally(Ltl::Ap(0))
                .within(StepBound::between(lower, upper))
                .holds_on_lasso(&[0, 0, A], &[0])
        };
        assert!(within(2, 2) && within(0, 2) && within(2, 9));
        assert!(!within(0, 1) && !within(3, 9) && !within(2, 1));
        let always_later = Ltl::globally(Ltl::Ap(0)).within(StepBound {
            lower: 2,
            upper: None,
        });
        assert!(always_later.holds_on_lasso(&[0, 0], &[A]));
        assert!(!always_later.holds_on_lasso(&[0, 0, 0], &[A]));
    }
}
