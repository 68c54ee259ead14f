//! The lines of a text that a message shows.
//!
//! The renderer looks through all the text that it is given, for each message anew. An excerpt has the lines that are pointed
//! at; of what lies between them only the line breaks, so that lines keep their numbers, and of long lines only the beginning.

use std::ops::Range;

/// Up to this many bytes, the text is shown as it is.
const SMALL: usize = 4_096;
/// Lines that are kept before and behind one that is pointed at.
const AROUND: usize = 5;
/// Lines between two places from which on the related one is left out.
const FAR: usize = 100_000;
/// How far into its line a place may be and be shown with its line.
const LONGEST_LINE: usize = 4_096;
/// How much of a long line is kept behind the place that is pointed at.
const TAIL: usize = 120;

/// Lines of a text with the places in them.
#[derive(Clone, Debug, PartialEq)]
pub struct Excerpt {
    /// The lines.
    pub text: String,
    /// The number of the first of them in the whole text, counted from one.
    pub first_line: usize,
    /// The place, in bytes of these lines.
    pub span: Range<usize>,
    /// Other places that matter, in bytes of these lines, each with a short note.
    pub related: Vec<(Range<usize>, String)>,
}

impl Excerpt {
    /// What is shown for a place and for those that have to do with it; `None` if the place is too far into a long line.
    pub fn new(
        text: &str,
        span: Range<usize>,
        related: Vec<(Range<usize>, String)>,
    ) -> Option<Self> {
        let related = related
            .into_iter()
            .map(|(place, note)| (within(text, place), note));
        let related: Vec<_> = related.collect();
        let places = || std::iter::once(&span).chain(related.iter().map(|(place, _)| place));
        let start = places().map(|place| place.start).min()?;
        let end = places().map(|place| place.end).max()?;
        // With the line before: what is missing at the end of a text is shown behind its last line.
        let start = line_start(text, line_start(text, start).saturating_sub(1));
        let end = end + text[end..].find('\n').map_or(text.len() - end, |at| at + 1);
        let first_line = text[..start].matches('\n').count() + 1;
        let shift = |place: &Range<usize>| place.start - start..place.end - start;
        let whole = Self {
            text: String::new(),
            first_line,
            span: shift(&span),
            related: related
                .iter()
                .map(|(place, note)| (shift(place), note.clone()))
                .collect(),
        };
        let lines = &text[start..end];
        if lines.len() <= SMALL {
            let text = lines.to_owned();
            return Some(Self { text, ..whole });
        }
        if !related.is_empty() && lines.matches('\n').count() > FAR {
            return Self::new(text, span, Vec::new());
        }
        whole.cut(lines)
    }

    /// Keeps what is near the places; these are offsets in `lines`.
    fn cut(self, lines: &str) -> Option<Self> {
        let places = || std::iter::once(&self.span).chain(self.related.iter().map(|(p, _)| p));
        let mut starts: Vec<(usize, &str)> = Vec::new();
        let mut at = 0;
        for line in lines.split_inclusive('\n') {
            starts.push((at, line));
            at += line.len();
        }
        if lines.ends_with('\n') {
            starts.push((at, ""));
        }
        let line_of = |offset: usize| starts.partition_point(|(start, _)| *start <= offset) - 1;
        let ends: Vec<usize> = places()
            .flat_map(|place| [place.start, place.end])
            .collect();
        let mut kept = vec![false; starts.len()];
        for end in &ends {
            let line = line_of(*end);
            let last = (line + AROUND).min(starts.len() - 1);
            kept[line.saturating_sub(AROUND)..=last].fill(true);
        }
        let mut text = String::new();
        // Of each line: where it starts in the excerpt, and how much of it is there.
        let mut parts: Vec<(usize, usize)> = Vec::with_capacity(starts.len());
        for ((start, line), kept) in starts.iter().zip(kept) {
            let content = line.trim_end_matches('\n');
            let here =
                |place: &&Range<usize>| (*start..=start + content.len()).contains(&place.start);
            let furthest = places().filter(here).map(|place| place.start - start).max();
            let furthest = furthest.unwrap_or(0);
            let length = match (kept, content.len() > LONGEST_LINE) {
                (false, _) => 0,
                (true, false) => content.len(),
                (true, true) if furthest > LONGEST_LINE => return None,
                (true, true) => boundary(content, furthest + TAIL),
            };
            parts.push((text.len(), length));
            text.push_str(&content[..length]);
            if length < content.len() && kept {
                text.push('…');
            }
            if line.ends_with('\n') {
                text.push('\n');
            }
        }
        let moved = |offset: usize| {
            let line = line_of(offset);
            parts[line].0 + (offset - starts[line].0).min(parts[line].1)
        };
        let shift = |place: &Range<usize>| moved(place.start)..moved(place.end);
        Some(Self {
            span: shift(&self.span),
            related: self
                .related
                .iter()
                .map(|(place, note)| (shift(place), note.clone()))
                .collect(),
            text,
            ..self
        })
    }
}

/// The part of a range that lies in the text, between characters.
pub(crate) fn within(text: &str, range: Range<usize>) -> Range<usize> {
    let start = boundary(text, range.start);
    start..boundary(text, range.end).max(start)
}

/// The last boundary of characters up to an offset.
fn boundary(text: &str, offset: usize) -> usize {
    let mut at = offset.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn line_start(text: &str, offset: usize) -> usize {
    text[..offset].rfind('\n').map_or(0, |at| at + 1)
}
