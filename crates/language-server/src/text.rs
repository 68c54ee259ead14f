//! A document's text, and its places as editors count them: lines from 0, columns in UTF-16 code units.

use ls_types::{Position, Range as LspRange, TextDocumentContentChangeEvent};
use std::ops::Range;

/// A text with the offsets at which its lines begin.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Text {
    text: String,
    /// The offset of each line's first byte; at least one.
    lines: Vec<usize>,
}

impl Text {
    /// A text.
    #[must_use]
    pub fn new(text: String) -> Self {
        let lines = starts_of_lines(&text);
        Self { text, lines }
    }

    /// The whole text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// The byte at which a place is. What is beyond a line's end is its end, what is beyond the text the text's end, and what is
    /// within a character its beginning.
    #[must_use]
    pub fn offset(&self, position: Position) -> usize {
        let Some(start) = self.lines.get(position.line as usize).copied() else {
            return self.text.len();
        };
        let mut units = 0;
        for (at, character) in self.line(position.line as usize).char_indices() {
            units += character.len_utf16();
            if units > position.character as usize {
                return start + at;
            }
        }
        start + self.line(position.line as usize).len()
    }

    /// The place of a byte.
    #[must_use]
    pub fn position(&self, offset: usize) -> Position {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let line = self.lines.partition_point(|start| *start <= offset) - 1;
        let before = &self.text[self.lines[line]..offset];
        let units = before.chars().map(char::len_utf16).sum::<usize>();
        Position::new(limited(line), limited(units))
    }

    /// The place of a part.
    #[must_use]
    pub fn range(&self, span: Range<usize>) -> LspRange {
        LspRange::new(self.position(span.start), self.position(span.end))
    }

    /// All of it.
    #[must_use]
    pub fn whole(&self) -> LspRange {
        self.range(0..self.text.len())
    }

    /// A line without what ends it.
    fn line(&self, line: usize) -> &str {
        let start = self.lines[line];
        let end = self.lines.get(line + 1).copied();
        self.text[start..end.unwrap_or(self.text.len())].trim_end_matches(['\n', '\r'])
    }

    /// The place that a message names by line and column, both from 1, the column in characters.
    #[must_use]
    pub fn offset_of_column(&self, line: usize, column: usize) -> usize {
        let line = line.saturating_sub(1);
        let Some(start) = self.lines.get(line).copied() else {
            return self.text.len();
        };
        let mut characters = self.line(line).char_indices();
        let at = characters.nth(column.saturating_sub(1));
        start + at.map_or(self.line(line).len(), |(at, _)| at)
    }

    /// Takes over a change, of a part or of all.
    pub fn change(&mut self, change: TextDocumentContentChangeEvent) {
        let Some(range) = change.range else {
            *self = Self::new(change.text);
            return;
        };
        let (start, end) = (self.offset(range.start), self.offset(range.end));
        let (start, end) = (start.min(end), start.max(end));
        self.text.replace_range(start..end, &change.text);
        self.lines = starts_of_lines(&self.text);
    }
}

fn limited(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// Lines end with a line feed, a carriage return, or both.
fn starts_of_lines(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let ends = (0..bytes.len()).filter(|at| match bytes[*at] {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    });
    std::iter::once(0).chain(ends.map(|at| at + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_utf_16_units() {
        let text = Text::new("aé𝄞b\r\nx".into());
        let places = [
            (0, 0, 0),
            (1, 0, 1),
            (3, 0, 2),
            (7, 0, 4),
            (8, 0, 5),
            (10, 1, 0),
            (11, 1, 1),
        ];
        for (offset, line, character) in places {
            let position = Position::new(line, character);
            assert_eq!(text.position(offset), position);
            assert_eq!(text.offset(position), offset);
        }
        assert_eq!(
            Text::new("a\rb\n\rc".into()).position(4),
            Position::new(2, 0)
        );
        // In the middle of a character, behind a line, behind the text.
        assert_eq!(text.offset(Position::new(0, 3)), 3);
        assert_eq!(text.offset(Position::new(0, 99)), 8);
        assert_eq!(text.offset(Position::new(9, 0)), 11);
        assert_eq!(text.position(2), Position::new(0, 1));
        assert_eq!(text.offset_of_column(1, 4), 7);
        assert_eq!(text.offset_of_column(7, 7), 11);
    }

    #[test]
    fn changes_of_parts_leave_the_text_that_the_whole_would_be() {
        let mut text = Text::new("one\ntwo\nthree\n".into());
        let range = |a: (u32, u32), b: (u32, u32)| {
            Some(LspRange::new(
                Position::new(a.0, a.1),
                Position::new(b.0, b.1),
            ))
        };
        for (range, new) in [
            (range((1, 0), (1, 3)), "2\n2½"),
            (range((0, 3), (1, 0)), ""),
            (range((9, 9), (9, 9)), "end\nend"),
            (range((0, 0), (0, 0)), "\n\n"),
            (range((3, 1), (1, 0)), "𝄞"),
            (None, "new\n"),
        ] {
            text.change(TextDocumentContentChangeEvent {
                range,
                range_length: None,
                text: new.into(),
            });
            assert_eq!(text, Text::new(text.as_str().to_owned()));
        }
        assert_eq!(text.as_str(), "new\n");
    }
}
