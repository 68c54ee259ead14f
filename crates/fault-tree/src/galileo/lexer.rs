//! Text to words, each with its place.

use std::ops::Range;

use crate::mistakes::Mistakes;

/// A word of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// In quotation marks, without them.
    Quoted(&'a str),
    /// Anything else between blanks: a name, a keyword, a number.
    Word(&'a str),
    Equals,
    Semicolon,
}

pub(super) type Placed<'a> = (Token<'a>, Range<usize>);

pub(super) fn tokens<'a>(text: &'a str, mistakes: &mut Mistakes<'_>) -> Vec<Placed<'a>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = match first {
            '=' => push(&mut found, Token::Equals, at, 1),
            ';' => push(&mut found, Token::Semicolon, at, 1),
            '"' => quoted(rest, at, &mut found, mistakes),
            it if it.is_whitespace() => it.len_utf8(),
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => match rest.find("*/") {
                Some(end) => end + 2,
                None => {
                    mistakes.add(at..at + 2, "this comment does not end", "end it with `*/`");
                    rest.len()
                }
            },
            _ => {
                let length = word(rest);
                push(&mut found, Token::Word(&rest[..length]), at, length)
            }
        };
        at += length;
    }
    found
}

fn push<'a>(found: &mut Vec<Placed<'a>>, token: Token<'a>, at: usize, length: usize) -> usize {
    found.push((token, at..at + length));
    length
}

fn quoted<'a>(
    rest: &'a str,
    at: usize,
    found: &mut Vec<Placed<'a>>,
    mistakes: &mut Mistakes<'_>,
) -> usize {
    let ends = |c: char| c == '"' || c == '\n' || c == ';';
    let end = rest[1..].find(ends).map_or(rest.len(), |end| end + 1);
    let closed = rest[end..].starts_with('"');
    if !closed {
        mistakes.add(
            at..at + 1,
            "this name has no closing quotation mark",
            "end it with `\"` before `;` and the line's end",
        );
    } else if end == 1 {
        mistakes.add(
            at..at + 2,
            "this name is empty",
            "write a name between the quotation marks",
        );
    }
    let length = end + usize::from(closed);
    found.push((Token::Quoted(&rest[1..end]), at..at + length));
    length
}

/// How long a word is: it ends at a blank, `=`, `;`, a quotation mark or a comment.
fn word(rest: &str) -> usize {
    let mut indices = rest.char_indices();
    let end = indices.find(|(index, c)| {
        let is_comment = *c == '/'
            && *index > 0
            && (rest[*index..].starts_with("//") || rest[*index..].starts_with("/*"));
        c.is_whitespace() || matches!(c, '=' | ';' | '"') || is_comment
    });
    end.map_or(rest.len(), |(index, _)| index)
}
