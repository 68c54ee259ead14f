//! How drafts are written: texts with places to fill in, and foreign names and numbers in them.

use std::collections::BTreeSet;
use std::path::Path;

/// A text with each `@NAME@` replaced.
pub(super) fn filled(text: &str, values: &[(&str, &str)]) -> String {
    let mut rest = text;
    let mut out = String::with_capacity(text.len());
    // In one pass, so that what is filled in is not looked into again.
    while let Some(at) = rest.find('@') {
        let (before, from) = rest.split_at(at);
        out.push_str(before);
        let found = values.iter().find_map(|(name, value)| {
            let behind = from[1..].strip_prefix(name)?.strip_prefix('@')?;
            Some((*value, behind))
        });
        match found {
            Some((value, behind)) => {
                out.push_str(value);
                rest = behind;
            }
            None => {
                out.push('@');
                rest = &from[1..];
            }
        }
    }
    out + rest
}

/// A string of TOML, on one line.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            letter if letter.is_control() => out.push_str(&format!("\\u{:04X}", u32::from(letter))),
            letter => out.push(letter),
        }
    }
    out + "\""
}

/// Foreign text on one line of a comment or of a page, not too long: what would end the line becomes a space.
pub(super) fn comment(text: &str) -> String {
    let shown = |letter: char| if letter.is_control() { ' ' } else { letter };
    diagnostic::shortened(text).chars().map(shown).collect()
}

/// The name of a file without its folders.
pub(super) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    comment(&name.to_string_lossy())
}

/// Whether predicates over signals can have a name as it is.
pub(super) fn is_plain(name: &str) -> bool {
    let mut letters = name.chars();
    letters
        .next()
        .is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// A name that is plain and not among those taken: letters that are not become `_`.
pub(super) fn plain(name: &str, taken: &mut BTreeSet<String>) -> String {
    let letter = |it: char| if it.is_ascii_alphanumeric() { it } else { '_' };
    let mut base: String = name.chars().take(60).map(letter).collect();
    if !is_plain(&base) {
        base.insert(0, 'n');
    }
    let mut candidate = base.clone();
    let mut count = 2;
    while !taken.insert(candidate.clone()) {
        candidate = format!("{base}_{count}");
        count += 1;
    }
    candidate
}

/// A number with three digits, as a draft has it.
pub(super) fn rounded(number: f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return number;
    }
    let digits = 2 - number.abs().log10().floor() as i32;
    if !(-300..=300).contains(&digits) {
        return number;
    }
    let factor = 10_f64.powi(digits.abs());
    match digits >= 0 {
        true => (number * factor).round() / factor,
        false => (number / factor).round() * factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_not_looked_into_again() {
        let text = filled("a@b.c @NAME@ @NO@ @X@", &[("NAME", "@X@"), ("X", "1")]);
        assert_eq!(text, "a@b.c @X@ @NO@ 1");
    }

    #[test]
    fn foreign_names_stay_within_their_quotes_and_lines() {
        let name = "a\"b\\c\nd\u{7f}é";
        let text = format!("x = {} # {}\n", quoted(name), comment(name));
        let table: toml::Table = text.parse().expect("TOML");
        assert_eq!(table["x"].as_str(), Some(name));
    }

    #[test]
    fn plain_names_differ() {
        let mut taken = BTreeSet::new();
        assert_eq!(plain("left wheel", &mut taken), "left_wheel");
        assert_eq!(plain("left/wheel", &mut taken), "left_wheel_2");
        assert_eq!(plain("1\n", &mut taken), "n1_");
        assert!(is_plain(&plain("", &mut taken)));
    }

    #[test]
    fn three_digits_are_kept() {
        assert_eq!(rounded(0.123_456), 0.123);
        assert_eq!(rounded(-98_765.0), -98_800.0);
        assert_eq!(rounded(0.0), 0.0);
        assert!(rounded(1e-310) > 0.0);
    }
}
