//! Numbers of a text that have a name: the parameters of a program that is not ours.
//!
//! # Definition
//! A named number is written `name = number`, `name: number`, or `name number` where that is all of the line. Behind the
//! number stands the end of the line, or one of `;`, `,` and the beginning of a comment, so that a factor of an expression
//! is not one. Comments begin with `#` or `//`. Quotes around the name are left out.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! Only the number's digits are replaced; all else of the text stays as it is written. What the number means to the
//! program is not known: that is found by running it.

use crate::model_change::digits;
use std::ops::Range;

/// A number with its name and place.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedNumber {
    /// The name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// The place of its digits in the text.
    pub span: Range<usize>,
}

impl NamedNumber {
    /// The text with another value in its place.
    #[must_use]
    pub fn set(&self, text: &str, value: f64) -> String {
        let mut changed = text.to_owned();
        changed.replace_range(self.span.clone(), &Self::written(value));
        changed
    }

    /// A value as it is written into the text: six significant digits.
    #[must_use]
    pub fn written(value: f64) -> String {
        digits(value)
    }
}

/// All named numbers of a text, in their order.
#[must_use]
pub fn named_numbers(text: &str) -> Vec<NamedNumber> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let code = &line[..comment(line)];
        of_line(code, start, &mut found);
        start += line.len();
    }
    found
}

/// Whether a text holds nothing but named numbers, one a line, and comments.
#[must_use]
pub fn is_all_named(text: &str) -> bool {
    let lines = text.lines().map(|line| line[..comment(line)].trim());
    let mut lines = lines
        .filter(|line| !line.is_empty() && !is_heading(line))
        .peekable();
    lines.peek().is_some() && lines.all(|line| !named_numbers(line).is_empty())
}

/// `[section]` of a file of settings.
fn is_heading(line: &str) -> bool {
    line.starts_with('[') && line.ends_with(']')
}

/// Where the comment of a line begins.
fn comment(line: &str) -> usize {
    let places = [line.find('#'), line.find("//")];
    places.into_iter().flatten().min().unwrap_or(line.len())
}

fn of_line(code: &str, start: usize, found: &mut Vec<NamedNumber>) {
    let is_part = |c: char| c.is_alphanumeric() || ".+-_".contains(c);
    let mut at = 0;
    while let Some(offset) = code[at..].find(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        let from = at + offset;
        let length = code[from..]
            .find(|c: char| !is_part(c))
            .unwrap_or(code.len() - from);
        at = from + length;
        let before = &code[..from];
        let begins = !before.ends_with(|c: char| is_part(c));
        let word = &code[from..at];
        let Some(value) = word.parse::<f64>().ok().filter(|v| begins && v.is_finite()) else {
            continue;
        };
        let rest = code[at..].trim_start();
        let ends = rest.is_empty() || rest.starts_with([';', ',']);
        if let Some(name) = name_before(before, rest.is_empty()).filter(|_| ends) {
            found.push(NamedNumber {
                name,
                value,
                span: start + from..start + at,
            });
        }
    }
}

/// The name that stands before a number, if one does.
fn name_before(before: &str, is_last: bool) -> Option<String> {
    let before = before.trim_end();
    let is_name = |c: char| c.is_alphanumeric() || "_.-".contains(c);
    let (rest, is_sole) = match before.strip_suffix(['=', ':']) {
        Some(rest) => (rest.trim_end(), false),
        None => (before, true),
    };
    let rest = rest.trim_end_matches(['"', '\'']);
    let name: String = rest
        .chars()
        .rev()
        .take_while(|c| is_name(*c))
        .collect::<Vec<char>>()
        .into_iter()
        .rev()
        .collect();
    let is_word = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let is_whole = rest.trim_start() == name;
    (is_word && (!is_sole || is_last && is_whole)).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<(String, f64)> {
        let all = named_numbers(text).into_iter();
        all.map(|it| (it.name, it.value)).collect()
    }

    #[test]
    fn numbers_with_a_name_are_found_in_files_of_parameters_and_in_programs() {
        let text = "# name 7\nsim_slip 0.03\nmedian.speed: 2e-1 # m/s 3\n\"gap\": 0.4,\n";
        let wanted = [("sim_slip", 0.03), ("median.speed", 0.2), ("gap", 0.4)];
        assert_eq!(
            names(text),
            wanted.map(|(name, value)| (name.to_owned(), value))
        );
        let text = "at = 2; limit = 40 * v; n = 3, f(7) x == 9\nif (a < 5) rate=-0.5;";
        let wanted = [("at", 2.0), ("n", 3.0), ("rate", -0.5)];
        assert_eq!(
            names(text),
            wanted.map(|(name, value)| (name.to_owned(), value))
        );
        assert!(names("print x 7 y\nw7 = q8\n1 2 3\n").is_empty());
    }

    #[test]
    fn only_the_digits_are_replaced() {
        let text = "a = 1;  slip = 0.03; # 0.03\n";
        let slip = &named_numbers(text)[1];
        assert_eq!(
            slip.set(text, 0.1234567),
            "a = 1;  slip = 0.123457; # 0.03\n"
        );
    }

    #[test]
    fn a_file_of_parameters_holds_nothing_else() {
        assert!(is_all_named("# all\n[physics]\nslip 0.03\ngap = 2\n"));
        assert!(!is_all_named("gap = 2\nrun()\n") && !is_all_named("# nothing\n"));
    }
}
