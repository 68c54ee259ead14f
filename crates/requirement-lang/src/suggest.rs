//! "Did you mean": the known word nearest to an unknown one.
//!
//! Definition: the least number of insertions, deletions and substitutions of letters (ignoring
//! case) that turn one word into the other; suggested if at most a third of the word's letters,
//! rounded up; of equal ones the first. Source: the dynamic programme of Wagner and Fischer, "The
//! string-to-string correction problem", Journal of the ACM 21(1), 1974. Cost: product of lengths.

/// The nearest of `known` to `word`, if one is near.
pub(crate) fn nearest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let allowed = word.chars().count().div_ceil(3);
    known
        .into_iter()
        .map(|name| (distance(word, name), name))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

fn distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (index, from) in left.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = index + 1;
        for (column, &to) in right.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[column + 1];
            row[column + 1] = replaced.min(row[column] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_textbook() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
    }

    #[test]
    fn only_near_words_are_suggested() {
        assert_eq!(nearest("shal", ["shall", "satisfy"]), Some("shall"));
        assert_eq!(nearest("banana", ["shall", "satisfy"]), None);
    }
}
