//! Pairs of evidence of which one looks copied from the other though no lineage says so.
//!
//! # Definition
//! A question ([`crate::LineageQuestion`]) is *open* if it blocks and no line of the ledger settles it. An open question
//! between two pieces makes them dependent on the subjects that it names and on those on which these bear
//! ([`super::Influences`]); on all if it names none. Pieces that rest on such a pair are dependent, too.
//!
//! # Assumes
//! Nothing of the data. What the ledger settles is taken for true.
//!
//! # Guarantee
//! How probable a coincidence has to be so that it is no question is decided where it is found; here nothing is tested.

use super::Influences;
use crate::{Evidence, LineageQuestion, Subject};
use std::collections::BTreeMap;

/// The questions of all evidence, by the identifiers of the pair in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Questions<'a>(BTreeMap<(&'a str, &'a str), Vec<&'a LineageQuestion>>);

impl<'a> Questions<'a> {
    pub fn of(evidence: &'a [Evidence]) -> Self {
        let mut pairs: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for piece in evidence {
            for question in &piece.lineage_questions {
                let pair = ordered(&piece.id, &question.with);
                pairs.entry(pair).or_default().push(question);
            }
        }
        Self(pairs)
    }

    /// The first open question between two pieces that bears on a subject.
    pub fn open(
        &self,
        (first, second): (&str, &str),
        subject: &Subject,
        influences: &Influences,
    ) -> Option<&'a LineageQuestion> {
        let mut between = self.between(first, second).filter(|it| it.is_open());
        between.find(|it| bears(it, subject, influences))
    }

    /// What chance explains but is worth saying: coincidences that are only noted.
    pub fn noted(&self, first: &str, second: &str, subject: &Subject) -> Vec<&'a LineageQuestion> {
        self.between(first, second)
            .filter(|it| !it.blocks && it.settled.is_none())
            .filter(|it| it.subjects.contains(subject))
            .collect()
    }

    fn between(
        &self,
        first: &str,
        second: &str,
    ) -> impl Iterator<Item = &'a LineageQuestion> + use<'a> {
        let found = self.0.get(&ordered(first, second));
        found.cloned().unwrap_or_default().into_iter()
    }
}

fn bears(question: &LineageQuestion, subject: &Subject, influences: &Influences) -> bool {
    let mut named = question.subjects.iter();
    question.subjects.is_empty() || named.any(|source| influences.bears(source, subject))
}

fn ordered<'s>(first: &'s str, second: &'s str) -> (&'s str, &'s str) {
    (first.min(second), first.max(second))
}

/// The question in words: what was found, where, and what settles it.
pub(super) fn in_words(question: &LineageQuestion) -> String {
    let places = match question.places.as_slice() {
        [] => String::new(),
        places => format!(" ({})", places.join(", ")),
    };
    let finding = question.finding.trim_end_matches('.');
    format!(
        "{finding}{places}; {}",
        question.remedy.trim_end_matches('.')
    )
}
