//! Dotted keys, and the name that was probably meant.

/// The parts of a dotted key in TOML's syntax: bare parts, or parts in single or double quotes
/// (without escapes) when they hold dots or spaces.
pub(crate) fn segments(key: &str) -> Result<Vec<String>, String> {
    let mut parts = Vec::new();
    let mut rest = key;
    loop {
        let (part, after) = first_segment(rest)?;
        parts.push(part.to_owned());
        match after.strip_prefix('.') {
            Some(next) => rest = next,
            None if after.is_empty() => return Ok(parts),
            None => return Err(format!("a dot is missing before `{after}`")),
        }
    }
}

fn first_segment(text: &str) -> Result<(&str, &str), String> {
    for quote in ['"', '\''] {
        if let Some(quoted) = text.strip_prefix(quote) {
            let end = quoted.find(quote);
            let end = end.ok_or_else(|| format!("the quote before `{quoted}` is not closed"))?;
            return Ok((&quoted[..end], &quoted[end + 1..]));
        }
    }
    let end = text.find('.').unwrap_or(text.len());
    match &text[..end] {
        "" => Err("a part between its dots is empty".to_owned()),
        part => Ok((part, &text[end..])),
    }
}

/// The known name that differs least from `word`, if it differs by at most a third of its letters, rounded up.
pub(crate) fn similar<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let limit = word.chars().count().div_ceil(3);
    known
        .into_iter()
        .map(|name| (distance(word, name), name))
        .filter(|(distance, _)| *distance <= limit)
        .min()
        .map(|(_, name)| name)
}

/// Edit distance (V. I. Levenshtein, 1966) by one row of the table.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, left) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, right) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(left != *right);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_split_as_toml_splits_them() {
        assert_eq!(segments("a.b-1.c").unwrap(), ["a", "b-1", "c"]);
        assert_eq!(
            segments(r#"people."Mr. X".speed"#).unwrap(),
            ["people", "Mr. X", "speed"]
        );
        for wrong in ["", "a.", ".a", "a..b", "\"a", "\"a\"b"] {
            assert!(segments(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_nearby_are_found() {
        assert_eq!(
            similar("frction", ["friction", "fraction"]),
            Some("fraction")
        );
        assert_eq!(similar("mass", ["velocity"]), None);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
