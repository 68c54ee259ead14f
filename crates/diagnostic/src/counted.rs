//! Numbers of things in words.

use std::fmt::Display;

/// A number with its noun, which is given in the singular: "1 state", "2 states", "0 properties".
///
/// ```
/// use diagnostic::counted;
/// assert_eq!(counted(1, "state"), "1 state");
/// assert_eq!(counted(0, "property"), "0 properties");
/// assert_eq!(counted(2_u64, "day"), "2 days");
/// ```
pub fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    if count == "1" {
        return format!("{count} {noun}");
    }
    match noun.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'i', 'o', 'u']) => format!("{count} {stem}ies"),
        _ => format!("{count} {noun}s"),
    }
}
