//! Coverage of sets: states and transitions of a model, goals, functions; and what is seen that
//! the set does not have.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Saturation, Share};

/// Which members of a known set were seen, in how many episodes, and what else was seen.
///
/// Members can be anything ordered: numbers of states, pairs of them for transitions, names.
///
/// ```
/// use campaign::SetCoverage;
/// // Transitions of a formal model, and what an abstracted trace did.
/// let mut transitions = SetCoverage::new([(0, 1), (1, 2), (2, 0)]);
/// let visits = transitions.record([(0, 1), (1, 0), (0, 1)]);
/// assert_eq!(visits.new, [(0, 1), (1, 0)]);
/// assert_eq!(visits.unknown, [(1, 0)]);   // behaviour the model has never heard of
/// assert_eq!(transitions.missing().collect::<Vec<_>>(), [&(1, 2), &(2, 0)]);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "T: Serialize", deserialize = "T: Deserialize<'de> + Ord"))]
pub struct SetCoverage<T> {
    known: BTreeSet<T>,
    #[serde(serialize_with = "as_pairs", deserialize_with = "from_pairs")]
    counts: BTreeMap<T, u64>,
    episodes: u64,
    news: Vec<u64>,
}

/// What one episode visited for the first time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visits<T> {
    /// Members seen for the first time, known or not, in order.
    pub new: Vec<T>,
    /// Those of them that the known set does not have.
    pub unknown: Vec<T>,
}

impl<T: Ord + Clone> SetCoverage<T> {
    /// Nothing of this set seen yet.
    #[must_use]
    pub fn new(known: impl IntoIterator<Item = T>) -> Self {
        Self {
            known: known.into_iter().collect(),
            counts: BTreeMap::new(),
            episodes: 0,
            news: Vec::new(),
        }
    }

    /// Records one episode.
    pub fn record(&mut self, seen: impl IntoIterator<Item = T>) -> Visits<T> {
        let seen: BTreeSet<T> = seen.into_iter().collect();
        let mut new = Vec::new();
        for member in seen {
            let count = self.counts.entry(member.clone()).or_insert(0);
            *count += 1;
            if *count == 1 {
                new.push(member);
            }
        }
        if !new.is_empty() {
            self.news.push(self.episodes);
        }
        self.episodes += 1;
        let unknown = new.iter().filter(|member| !self.known.contains(member));
        Visits {
            unknown: unknown.cloned().collect(),
            new,
        }
    }

    /// How many of the known members were seen.
    #[must_use]
    pub fn share(&self) -> Share {
        let covered = self
            .counts
            .keys()
            .filter(|member| self.known.contains(member));
        Share {
            covered: covered.count() as u64,
            total: self.known.len() as u64,
        }
    }

    /// Known members that were never seen, in order.
    pub fn missing(&self) -> impl Iterator<Item = &T> {
        self.known
            .iter()
            .filter(|member| !self.counts.contains_key(member))
    }

    /// What was seen that the set does not have, and in how many episodes, in order.
    pub fn unknown(&self) -> impl Iterator<Item = (&T, u64)> {
        let seen = self
            .counts
            .iter()
            .filter(|(member, _)| !self.known.contains(member));
        seen.map(|(member, count)| (member, *count))
    }

    /// In how many episodes a member was seen.
    #[must_use]
    pub fn count(&self, member: &T) -> u64 {
        self.counts.get(member).copied().unwrap_or(0)
    }

    /// How many episodes were recorded.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// What the counts say about members that were not seen yet.
    #[must_use]
    pub fn saturation(&self) -> Saturation {
        Saturation::new(self.episodes, self.counts.values().copied(), &self.news)
    }
}

/// JSON has only texts as keys; pairs hold any members.
fn as_pairs<T: Serialize, S: Serializer>(
    counts: &BTreeMap<T, u64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(counts)
}

fn from_pairs<'de, T: Deserialize<'de> + Ord, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<T, u64>, D::Error> {
    Ok(Vec::<(T, u64)>::deserialize(deserializer)?
        .into_iter()
        .collect())
}
