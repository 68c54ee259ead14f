//! Did you mean: the known name nearest to an unknown one.
//!
//! Definition: the least number of insertions, deletions, replacements and swaps of neighbours that turn one
//! word into the other (Damerau, "A technique for computer detection and correction of spelling errors",
//! Communications of the ACM 7(3), 1964; here restricted, no part edited twice). A name is suggested if that
//! number is at most a third of the word's length (rounded down; for a shorter word only its case may differ);
//! of several, the first. Cost: product of lengths.

/// Longest word that is compared.
const LONGEST: usize = 100;

/// The nearest of `known`, if one is near.
pub(crate) fn suggest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    // Nobody mistypes a longer one, and its distance would take long.
    if word.len() > LONGEST {
        return None;
    }
    let allowed = word.chars().count() / 3;
    known
        .into_iter()
        // Each character takes one to four bytes; the distance is at least the difference of the lengths.
        .filter(|name| name.len() <= 4 * (word.len() + allowed))
        .map(|name| (distance(word, name), name))
        .filter(|(d, _)| *d <= allowed)
        .min_by_key(|(d, _)| *d)
        .map(|(_, name)| name)
}

fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (
        a.to_lowercase().chars().collect(),
        b.to_lowercase().chars().collect(),
    );
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut next = vec![i];
        for j in 1..=b.len() {
            let replaced = row[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(row[j] + 1).min(next[j - 1] + 1);
            let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if swapped {
                best = best.min(before[j - 2] + 1);
            }
            next.push(best);
        }
        before = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_suggested_and_far_ones_are_not() {
        let known = ["robotState", "humanState", "time"];
        assert_eq!(suggest("robtoState", known), Some("robotState"));
        assert_eq!(suggest("tiem", known), Some("time"));
        assert_eq!(suggest("Time", known), Some("time"));
        assert_eq!(suggest("x", ["y", "z"]), None);
        assert_eq!(suggest("X", ["y", "x"]), Some("x"));
    }

    #[test]
    fn distances_are_those_of_hand_counted_examples() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("ab", "ba"), 1);
        assert_eq!(distance("", "abc"), 3);
    }
}
