//! Text that quotes an input, without what would mean something to whatever shows it.
//!
//! # Definition
//! *Steering* are the control characters of ASCII and Latin-1 but line feed, tabulator and a carriage return before a line feed, the
//! overrides, embeddings and isolates of the bidirectional algorithm (U+202A to U+202E, U+2066 to U+2069), and the separators of lines and
//! paragraphs (U+2028, U+2029). Each is shown as a blank; in JSON, where it stands in a string, as its escape, which means the same.
//!
//! # Source
//! ECMA-48 (control functions); Unicode Standard Annex #9, section 2; N. Boucher and R. Anderson, "Trojan Source: Invisible
//! Vulnerabilities" (2023).
//!
//! # Guarantee
//! What is returned has no steering character: no input moves a cursor, renames a window, hides or reorders a text.

use std::borrow::Cow;

fn is_steering(letter: char, next: Option<char>) -> bool {
    match letter {
        '\n' | '\t' => false,
        '\r' => next != Some('\n'),
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{2028}' | '\u{2029}' => true,
        _ => letter.is_control(),
    }
}

/// The text with a blank for each steering character.
///
/// ```
/// use diagnostic::printable;
/// assert_eq!(printable("done\u{1b}[8m"), "done [8m");
/// assert_eq!(printable("a\u{202e}b\r\n\tc"), "a b\r\n\tc");
/// ```
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    replaced(text, |_| Cow::Borrowed(" "))
}

/// The same on one line: line feeds and tabulators are blanks, too.
///
/// ```
/// assert_eq!(diagnostic::printable_line("a\nb\u{7}c"), "a b c");
/// ```
#[must_use]
pub fn printable_line(text: &str) -> Cow<'_, str> {
    let plain = printable(text);
    match plain.contains(['\n', '\r', '\t']) {
        true => Cow::Owned(plain.replace(['\n', '\r', '\t'], " ")),
        false => plain,
    }
}

/// A JSON text whose strings have an escape for each steering character.
///
/// ```
/// assert_eq!(diagnostic::printable_json("{\"a\": \"\u{202e}\"}"), r#"{"a": "\u202e"}"#);
/// ```
#[must_use]
pub fn printable_json(text: &str) -> Cow<'_, str> {
    replaced(text, |letter| {
        Cow::Owned(format!("\\u{:04x}", u32::from(letter)))
    })
}

fn replaced(text: &str, by: impl Fn(char) -> Cow<'static, str>) -> Cow<'_, str> {
    let next = |at: usize| text[at..].chars().nth(1);
    let mut steering = text.char_indices();
    if !steering.any(|(at, letter)| is_steering(letter, next(at))) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for (at, letter) in text.char_indices() {
        match is_steering(letter, next(at)) {
            true => shown.push_str(&by(letter)),
            false => shown.push(letter),
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_steering_character_goes_and_all_others_stay() {
        let all: String = ('\0'..='\u{2fff}').collect();
        let shown = printable(&all);
        assert_eq!(shown.chars().count(), all.chars().count());
        for (before, after) in all.chars().zip(shown.chars()) {
            let stays = !before.is_control() && !"\u{2028}\u{2029}".contains(before);
            let reorders = ('\u{202a}'..='\u{202e}').contains(&before)
                || ('\u{2066}'..='\u{2069}').contains(&before);
            match stays && !reorders || "\n\t".contains(before) {
                true => assert_eq!(before, after),
                false => assert_eq!(after, ' ', "{before:?}"),
            }
        }
        // A carriage return that ends a line stays; one that goes back to its beginning does not.
        assert_eq!(printable("a\r\nb\rc"), "a\r\nb c");
    }

    #[test]
    fn an_escape_in_json_means_the_same() {
        let text = "x\u{7f}\u{9b}\u{202e}y";
        let json = format!("{{\"a\": \"{text}\"}}");
        let shown = printable_json(&json);
        assert_eq!(shown, r#"{"a": "x\u007f\u009b\u202ey"}"#);
        assert_eq!(printable(&shown), shown);
    }
}
