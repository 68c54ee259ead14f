//! Which tests there are already, and which few of them are enough.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use stimulus::{AbstractTest, Stimulus};

/// The tests that were there before, by their content.
///
/// ```
/// use campaign::Known;
/// use stimulus::{AbstractTest, Action};
/// let mut known = Known::default();
/// assert!(known.is_new(&AbstractTest::new("one", vec![Action::send("a")])));
/// assert!(!known.is_new(&AbstractTest::new("same under another name", vec![Action::send("a")])));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Known {
    contents: BTreeSet<String>,
}

impl Known {
    /// Whether a test was not there before; from now on it is.
    pub fn is_new(&mut self, test: &AbstractTest) -> bool {
        self.contents
            .insert(Stimulus::of(test.clone()).content_hash())
    }

    /// How many different tests there were.
    #[must_use]
    pub fn len(&self) -> usize {
        self.contents.len()
    }

    /// Whether there was none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contents.is_empty()
    }
}

/// Few tests that reach every goal that can be reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cover<G> {
    /// Places (from 0) of the chosen tests, with the goals that each was the first to reach.
    pub chosen: Vec<(usize, Vec<G>)>,
    /// Goals that no test reaches.
    pub unreached: Vec<G>,
}

/// Chooses tests, always the one that reaches most of the goals still open (the first of equals):
/// the greedy cover of V. Chvatal (1979), at most 1 + ln(goals) times as large as the smallest.
///
/// ```
/// let reached = [vec!["a"], vec!["a", "b", "c"], vec!["c", "d"]];
/// let cover = campaign::smallest_cover(&["a", "b", "c", "d", "e"], &reached);
/// assert_eq!(cover.chosen, [(1, vec!["a", "b", "c"]), (2, vec!["d"])]);
/// assert_eq!(cover.unreached, ["e"]);
/// ```
#[must_use]
pub fn smallest_cover<G: Ord + Clone>(goals: &[G], reached_by_test: &[Vec<G>]) -> Cover<G> {
    let mut open: BTreeSet<G> = goals.iter().cloned().collect();
    let mut chosen = Vec::new();
    loop {
        let gain = |reached: &Vec<G>| -> BTreeSet<G> {
            reached
                .iter()
                .filter(|goal| open.contains(goal))
                .cloned()
                .collect()
        };
        let gains = reached_by_test.iter().map(gain).enumerate();
        // The last of equal maxima would be taken: order backwards to take the first.
        let best = gains.rev().max_by_key(|(_, gain)| gain.len());
        match best {
            Some((index, gain)) if !gain.is_empty() => {
                open.retain(|goal| !gain.contains(goal));
                chosen.push((index, gain.into_iter().collect()));
            }
            _ => break,
        }
    }
    Cover {
        chosen,
        unreached: open.into_iter().collect(),
    }
}
