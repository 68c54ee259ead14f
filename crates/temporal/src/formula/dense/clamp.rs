//! Clamps, and the composition of those in a sliding window.
//!
//! A clamp is the function u -> max(floor, min(ceiling, u)). At one place, `f until g` has the value
//! max(g, min(f, u)), where u is its value just after, and `f release g` min(g, max(f, u)): both
//! are clamps of u. Clamps are closed under composition, so the value of an operator over a window
//! is the composition of the clamps of its places, applied to what is after the window. And a
//! clamp composed with itself is itself, so a stretch in which the operands are constant
//! contributes one clamp, however long it is.
//!
//! The composition over a window that slides is kept in two stacks (K. Tangwongsan et al.,
//! "General incremental sliding-window aggregation", VLDB 2015, section on two-stacks): O(1)
//! amortised for each stretch that enters or leaves.

/// The function u -> max(floor, min(ceiling, u)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clamp {
    pub(super) floor: f64,
    pub(super) ceiling: f64,
}

impl Clamp {
    pub(super) const IDENTITY: Clamp = Clamp {
        floor: f64::NEG_INFINITY,
        ceiling: f64::INFINITY,
    };

    /// u -> max(value, u)
    pub(super) const fn at_least(value: f64) -> Self {
        Clamp {
            floor: value,
            ceiling: f64::INFINITY,
        }
    }

    /// u -> min(value, u)
    pub(super) const fn at_most(value: f64) -> Self {
        Clamp {
            floor: f64::NEG_INFINITY,
            ceiling: value,
        }
    }

    /// First `inner`, then this.
    pub(super) fn after(self, inner: Clamp) -> Clamp {
        Clamp {
            floor: self.floor.max(self.ceiling.min(inner.floor)),
            ceiling: self.ceiling.min(inner.ceiling),
        }
    }

    pub(super) fn apply(self, value: f64) -> f64 {
        self.floor.max(self.ceiling.min(value))
    }

    /// Whether the result does not depend on the argument.
    pub(super) fn is_constant(self) -> bool {
        self.floor >= self.ceiling
    }
}

/// Which end of a window is applied last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outermost {
    /// The oldest: for operators of the future.
    Oldest,
    /// The newest: for operators of the past.
    Newest,
}

/// The clamps in a sliding window, and their composition.
#[derive(Debug, Clone)]
pub(super) struct Sliding {
    outermost: Outermost,
    /// Nothing ever leaves, so that only the composition is kept.
    endless: bool,
    /// For each older clamp, the newest of them first: the composition from it on to the newest of them.
    older: Vec<Clamp>,
    /// The newer clamps, the oldest first.
    newer: Vec<Clamp>,
    newer_total: Clamp,
}

impl Sliding {
    pub(super) fn new(outermost: Outermost, endless: bool) -> Self {
        Sliding {
            outermost,
            endless,
            older: Vec::new(),
            newer: Vec::new(),
            newer_total: Clamp::IDENTITY,
        }
    }

    fn compose(&self, older: Clamp, newer: Clamp) -> Clamp {
        match self.outermost {
            Outermost::Oldest => older.after(newer),
            Outermost::Newest => newer.after(older),
        }
    }

    pub(super) fn push(&mut self, clamp: Clamp) {
        self.newer_total = self.compose(self.newer_total, clamp);
        if !self.endless {
            self.newer.push(clamp);
        }
    }

    /// Removes the oldest.
    pub(super) fn pop(&mut self) {
        if self.older.is_empty() {
            let mut total = Clamp::IDENTITY;
            while let Some(clamp) = self.newer.pop() {
                total = self.compose(clamp, total);
                self.older.push(total);
            }
            self.newer_total = Clamp::IDENTITY;
        }
        self.older.pop();
    }

    /// The composition of all.
    pub(super) fn total(&self) -> Clamp {
        let older = self.older.last().copied().unwrap_or(Clamp::IDENTITY);
        self.compose(older, self.newer_total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUES: [f64; 5] = [f64::NEG_INFINITY, -1.0, 0.0, 2.0, f64::INFINITY];

    fn all() -> Vec<Clamp> {
        let pairs = VALUES
            .iter()
            .flat_map(|&floor| VALUES.map(|ceiling| Clamp { floor, ceiling }));
        pairs.collect()
    }

    #[test]
    fn composition_is_that_of_functions_and_a_clamp_is_idempotent() {
        for first in all() {
            for second in all() {
                let both = second.after(first);
                for value in VALUES {
                    assert_eq!(both.apply(value), second.apply(first.apply(value)));
                }
            }
            for value in VALUES {
                assert_eq!(first.apply(first.apply(value)), first.apply(value));
            }
            let results: Vec<f64> = VALUES.iter().map(|&value| first.apply(value)).collect();
            assert_eq!(
                first.is_constant(),
                results.iter().all(|result| *result == results[0])
            );
        }
    }

    #[test]
    fn a_sliding_window_has_the_composition_of_its_clamps() {
        for outermost in [Outermost::Oldest, Outermost::Newest] {
            let mut sliding = Sliding::new(outermost, false);
            let mut plain: Vec<Clamp> = Vec::new();
            // A fixed pseudo-random walk: add two thirds of the time, else remove.
            let mut state = 1u32;
            for _ in 0..5_000 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if plain.is_empty() || !(state >> 16).is_multiple_of(3) && plain.len() < 12 {
                    let clamp = all()[(state >> 20) as usize % 25];
                    sliding.push(clamp);
                    plain.push(clamp);
                } else {
                    sliding.pop();
                    plain.remove(0);
                }
                for value in VALUES {
                    let apply = |value: f64, clamp: &Clamp| clamp.apply(value);
                    let expected = match outermost {
                        Outermost::Oldest => plain.iter().rev().fold(value, apply),
                        Outermost::Newest => plain.iter().fold(value, apply),
                    };
                    assert_eq!(sliding.total().apply(value), expected);
                }
            }
        }
    }
}
