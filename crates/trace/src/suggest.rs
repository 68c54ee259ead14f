//! "Did you mean": the known name nearest to an unknown one.
//!
//! Definition: the name with the least edit distance (insertions, deletions and substitutions of
//! letters, ignoring case), if that is at most a third of the letters, rounded up. Source: the
//! dynamic programme of Wagner and Fischer, "The string-to-string correction problem", Journal of
//! the ACM 21(1), 1974. Cost: O(|a| |b|) for each known name. Of equal ones the first is taken.

/// The nearest of `known` to `name`, if any is near enough to be worth suggesting.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let limit = name.chars().count().div_ceil(3);
    let mut best: Option<(usize, &str)> = None;
    for candidate in known {
        let distance = edit_distance(name, candidate);
        if distance <= limit && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate.to_owned())
}

/// The names of `known` nearest to `name`, nearest first, at most `most` of them and as far away as [`nearest`] goes.
#[must_use]
pub fn nearest_few<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    most: usize,
) -> Vec<String> {
    let limit = name.chars().count().div_ceil(3);
    let ranked = known.into_iter().map(|it| (edit_distance(name, it), it));
    let mut ranked: Vec<_> = ranked.filter(|(distance, _)| *distance <= limit).collect();
    // Stable, so that of equal ones the first stays first.
    ranked.sort_by_key(|(distance, _)| *distance);
    let names = ranked.into_iter().map(|(_, it)| it.to_owned());
    names.take(most).collect()
}

fn edit_distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (index, from) in left.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = index + 1;
        for (column, &to) in right.iter().enumerate() {
            let substituted = diagonal + usize::from(from != to);
            diagonal = row[column + 1];
            row[column + 1] = substituted.min(row[column] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distance_of_textbook_pairs() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("Robot", "robot"), 0);
    }

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["/robot.hand_speed", "/robot.state"];
        assert_eq!(
            nearest("/robot.hand_sped", known),
            Some("/robot.hand_speed".to_owned())
        );
        assert_eq!(nearest("/camera.image", known), None);
        let words = ["shall", "satisfy"];
        assert_eq!(nearest("shal", words), Some("shall".to_owned()));
        assert_eq!(nearest("banana", words), None);
        assert_eq!(nearest_few("shal", words, 3), ["shall"]);
        assert_eq!(
            nearest_few("speed", ["velocity", "sped", "speeds", "spend"], 2),
            ["sped", "speeds"]
        );
    }
}
