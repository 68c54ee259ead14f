//! Items on one line, or on several.

use super::spacing::{Role, Roles, is_apart};
use super::{INDENT, WIDTH, indented};
use crate::lexer::{Token, TokenKind};
use std::ops::Range;

/// An item's tokens, and what they are to each other.
pub(super) struct Layout<'t> {
    pub(super) tokens: &'t [Token<'t>],
    pub(super) roles: &'t Roles,
}

impl Layout<'_> {
    /// The lines of some of the item's tokens, broken where the outermost brackets and the weakest operators are
    /// if one line would be too wide.
    pub(super) fn lines(&self, range: Range<usize>, indent: usize) -> Vec<String> {
        let line = indented(indent, &self.line(range.clone()));
        if line.chars().count() <= WIDTH {
            return vec![line];
        }
        let places = self.weakest(range.clone());
        if places.is_empty() {
            return vec![line];
        }
        let starts = std::iter::once(range.start).chain(places.iter().copied());
        let ends = places.iter().copied().chain([range.end]);
        let mut lines = Vec::new();
        for (start, end) in starts.zip(ends) {
            let indent = indent + if start == range.start { 0 } else { INDENT };
            lines.append(&mut self.lines(start..end, indent));
        }
        lines
    }

    fn line(&self, range: Range<usize>) -> String {
        let mut line = String::new();
        for i in range.clone() {
            if i > range.start && is_apart(self.roles.of(i - 1), self.roles.of(i)) {
                line.push(' ');
            }
            let token = &self.tokens[i];
            match token.kind {
                TokenKind::Quoted => line.extend(["\"", token.text, "\""]),
                TokenKind::Primed => line.extend([token.text, "'"]),
                _ => line.push_str(token.text),
            }
        }
        line
    }

    /// The tokens to begin a line with: those where breaking disturbs least.
    fn weakest(&self, range: Range<usize>) -> Vec<usize> {
        let mut depth = 0_usize;
        let mut least = usize::MAX;
        let mut places = Vec::new();
        for i in range.clone() {
            if matches!(self.roles.of(i), Role::Close | Role::WideClose) {
                depth = depth.saturating_sub(1);
            }
            if i > range.start
                && let Some(strength) = self.strength(i)
            {
                let level = 16 * depth + strength;
                if level < least {
                    places.clear();
                    least = level;
                }
                if level == least {
                    places.push(i);
                }
            }
            if matches!(self.roles.of(i), Role::Open { .. } | Role::WideOpen) {
                depth += 1;
            }
        }
        places
    }

    /// How much belongs together what stands before and behind this place; none where no line ends.
    fn strength(&self, i: usize) -> Option<usize> {
        let (before, token) = (&self.tokens[i - 1], &self.tokens[i]);
        let is_wide = |i: usize| self.roles.of(i) == Role::Wide;
        match token.text {
            _ if self.roles.separators[i] => Some(0),
            _ if before.text == "->" || self.roles.definition == Some(i - 1) => Some(0),
            "U" | "W" if token.kind == TokenKind::Keyword => Some(1),
            "?" | ":" if is_wide(i) => Some(2),
            "<=>" => Some(3),
            "=>" => Some(4),
            "|" if is_wide(i) => Some(5),
            "&" => Some(6),
            _ if before.text == "," => Some(7),
            "+" | "-" if self.roles.of(i) != Role::Prefix => Some(8),
            "*" | "/" => Some(9),
            _ => None,
        }
    }
}
