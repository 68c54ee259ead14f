//! Formatting of models and property files: their layout, and nothing else.
//!
//! Definition: a text is cut into items (a declaration, a command, the head of a module); each item stands on a
//! line of its own, with the blanks that its tokens call for, and on several lines if it is wider than
//! [`WIDTH`] or has comments inside. One blank line at most is kept between items.
//! Deviation: what [`Display`](std::fmt::Display) of a syntax tree prints has neither comments nor the parentheses that the
//! author put for the reader; here both stay, so tokens are laid out rather than trees.
//! Guarantee: tokens and comments are those of the given text in the same order, and a formatted text is
//! formatted to itself (both tested on random layouts of models).

mod items;
mod layout;
mod spacing;

use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lexer::{Token, tokenize};
use items::{Item, Kind};
use layout::Layout;

/// The widest line, in characters, unless an item cannot be broken further.
pub const WIDTH: usize = 100;

/// Blanks for each level of modules and reward structures.
const INDENT: usize = 2;

/// The same model, laid out anew.
///
/// ```
/// let text = "dtmc\nmodule m // one\nx:[0..1] ;[]x=0->(x'=1);endmodule";
/// let formatted = "dtmc\n\nmodule m // one\n  x : [0..1];\n  [] x=0 -> (x'=1);\nendmodule\n";
/// assert_eq!(prism_lang::format_model(text).unwrap(), formatted);
/// ```
///
/// # Errors
/// The mistakes of a text that does not parse: where its items end is not known.
pub fn format_model(text: &str) -> Result<String, Diagnostics> {
    without_errors(crate::parse_model(text).diagnostics)?;
    let (tokens, _) = tokenize(text);
    let items = items::of_model(&tokens);
    Ok(Page::of(text, &tokens).write(&items))
}

/// The same property file, laid out anew.
///
/// ```
/// let text = "// First.\nP=?[F<=3 \"done\"];";
/// let formatted = "// First.\nP=? [ F<=3 \"done\" ];\n";
/// assert_eq!(prism_lang::format_properties(text).unwrap(), formatted);
/// ```
///
/// # Errors
/// The mistakes of a text that does not parse.
pub fn format_properties(text: &str) -> Result<String, Diagnostics> {
    let parsed = crate::parse_properties(text);
    without_errors(parsed.diagnostics)?;
    let (tokens, _) = tokenize(text);
    let items = items::of_properties(&parsed.tree, &tokens);
    Ok(Page::of(text, &tokens).write(&items))
}

fn without_errors(diagnostics: Vec<Diagnostic>) -> Result<(), Diagnostics> {
    match diagnostics
        .iter()
        .any(|diagnostic| diagnostic.severity == Severity::Error)
    {
        true => Err(diagnostics.into()),
        false => Ok(()),
    }
}

/// A comment, with how many line breaks stand before it, and how many blanks behind the last of them.
#[derive(Clone, Copy, Debug)]
struct Comment<'t> {
    text: &'t str,
    breaks: usize,
    blanks: usize,
}

impl Comment<'_> {
    /// Writes it behind a line, as far apart as its author aligned it.
    fn behind(&self, line: &mut String) {
        let blanks = self.blanks.max(1);
        line.extend(std::iter::repeat_n(' ', blanks));
        line.push_str(self.text);
    }
}

/// What stands before a token: comments, and the line breaks behind the last one.
#[derive(Clone, Debug, Default)]
struct Gap<'t> {
    comments: Vec<Comment<'t>>,
    breaks: usize,
    is_empty: bool,
}

impl<'t> Gap<'t> {
    fn of(blanks: &'t str) -> Self {
        let mut gap = Gap {
            is_empty: blanks.is_empty(),
            ..Gap::default()
        };
        let mut rest = blanks;
        while let Some(at) = rest.find("//") {
            let end = rest[at..]
                .find('\n')
                .map_or(rest.len(), |length| at + length);
            gap.comments.push(Comment {
                text: rest[at..end].trim_end(),
                breaks: line_breaks(&rest[..at]),
                blanks: rest[..at].chars().rev().take_while(|c| *c == ' ').count(),
            });
            rest = &rest[end..];
        }
        gap.breaks = line_breaks(rest);
        gap
    }
}

fn line_breaks(blanks: &str) -> usize {
    blanks.bytes().filter(|&byte| byte == b'\n').count()
}

/// The lines written so far, and what they are made of.
struct Page<'t> {
    tokens: &'t [Token<'t>],
    /// What stands before each token.
    gaps: Vec<Gap<'t>>,
    lines: Vec<String>,
}

impl<'t> Page<'t> {
    fn of(text: &'t str, tokens: &'t [Token<'t>]) -> Self {
        let starts = std::iter::once(0).chain(tokens.iter().map(|token| token.span.end));
        let gaps = starts
            .zip(tokens)
            .map(|(start, token)| Gap::of(&text[start..token.span.start]))
            .collect();
        Page {
            tokens,
            gaps,
            lines: Vec::new(),
        }
    }

    fn write(mut self, items: &[Item]) -> String {
        let mut before = None;
        for item in items {
            let depth = match item.kind {
                // What is said last in a block is said inside of it.
                Kind::Closing => item.depth + 1,
                _ => item.depth,
            };
            let may_part = before != Some(Kind::Opening);
            let must_part = item.kind == Kind::Opening || before == Some(Kind::Closing);
            self.comments_before(item.first, depth, may_part, must_part);
            self.item(item);
            before = Some(item.kind);
        }
        let end = self.tokens.len() - 1;
        self.comments_before(end, 0, true, false);
        while self.lines.last().is_some_and(String::is_empty) {
            self.lines.pop();
        }
        self.lines
            .iter()
            .fold(String::new(), |page, line| page + line + "\n")
    }

    /// Writes the comments before an item, and the blank lines around them: those of the text where there
    /// may be any, and one where there must be.
    fn comments_before(&mut self, token: usize, depth: usize, may_part: bool, must_part: bool) {
        let gap = std::mem::take(&mut self.gaps[token]);
        let (mut may_part, mut must_part) = (may_part, must_part);
        for comment in &gap.comments {
            if comment.breaks == 0
                && let Some(line) = self.lines.last_mut()
            {
                comment.behind(line);
                continue;
            }
            self.part(comment.breaks, may_part, must_part);
            self.lines.push(indented(depth * INDENT, comment.text));
            (may_part, must_part) = (true, false);
        }
        self.part(gap.breaks, may_part, must_part);
    }

    fn part(&mut self, breaks: usize, may_part: bool, must_part: bool) {
        let is_inside = self.lines.last().is_some_and(|line| !line.is_empty());
        if is_inside && (must_part || may_part && breaks > 1) {
            self.lines.push(String::new());
        }
    }

    /// Writes an item, on a new line for each comment inside and where it is too wide.
    fn item(&mut self, item: &Item) {
        let roles = spacing::roles(self.tokens, &self.gaps, item);
        let layout = Layout {
            tokens: &self.tokens[item.first..item.end],
            roles: &roles,
        };
        let indent = item.depth * INDENT;
        let mut first = item.first;
        let mut is_head = true;
        while first < item.end {
            let next_comment = (first + 1..item.end).find(|&i| !self.gaps[i].comments.is_empty());
            let end = next_comment.unwrap_or(item.end);
            let at = if is_head { indent } else { indent + INDENT };
            let mut lines = layout.lines(first - item.first..end - item.first, at);
            self.lines.append(&mut lines);
            if end < item.end {
                for comment in std::mem::take(&mut self.gaps[end].comments) {
                    self.comment_inside(comment, indent + INDENT);
                }
            }
            first = end;
            is_head = false;
        }
    }

    /// Writes a comment behind what stands before it, or on a line of its own.
    fn comment_inside(&mut self, comment: Comment<'t>, indent: usize) {
        match self.lines.last_mut() {
            Some(line) if comment.breaks == 0 => comment.behind(line),
            _ => self.lines.push(indented(indent, comment.text)),
        }
    }
}

fn indented(indent: usize, text: &str) -> String {
    format!("{:indent$}{text}", "")
}

#[cfg(test)]
mod tests;
