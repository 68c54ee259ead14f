//! Changes of a text by places, all else left as it is.

use std::ops::Range;

/// What stands at a place is replaced; an empty place is an insertion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Edit {
    pub(crate) span: Range<usize>,
    pub(crate) text: String,
}

impl Edit {
    pub(crate) fn replace(span: Range<usize>, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { span, text }
    }

    pub(crate) fn insert(at: usize, text: impl Into<String>) -> Self {
        Self::replace(at..at, text)
    }
}

/// The text with all edits made. Edits do not overlap; insertions at one place stand in the order given.
pub(crate) fn applied(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
    let mut new = String::with_capacity(text.len() + 64);
    let mut from = 0;
    for edit in edits {
        if edit.span.start < from {
            continue;
        }
        new.push_str(&text[from..edit.span.start]);
        new.push_str(&edit.text);
        from = edit.span.end;
    }
    new.push_str(&text[from..]);
    new
}

/// How a text ends its lines.
pub(crate) fn line_end(text: &str) -> &'static str {
    match text.find('\n') {
        Some(at) if text[..at].ends_with('\r') => "\r\n",
        _ => "\n",
    }
}

/// The beginning of the line in which a byte stands.
pub(crate) fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |before| before + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_leave_all_else_alone() {
        let edits = vec![
            Edit::replace(4..5, "X"),
            Edit::insert(0, ">"),
            Edit::insert(6, "1"),
            Edit::insert(6, "2"),
        ];
        assert_eq!(applied("abcdefg", edits), ">abcdXf12g");
        assert_eq!(line_end("a\r\nb"), "\r\n");
        assert_eq!(line_start("ab\ncd", 4), 3);
    }
}
