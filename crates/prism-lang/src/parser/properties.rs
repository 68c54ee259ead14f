//! Property files, and single properties as given on a command line.

use super::{Parse, Parser};
use crate::ast::{Property, PropertyFile, UnreadProperty};
use crate::diagnostic::{Diagnostic, Parsed, Span};
use crate::lexer::TokenKind;

/// Words at which something new starts in a property file.
const PARTS: &[&str] = &["const", "label", "formula"];

/// Words at which a property can start.
const OPERATORS: &[&str] = &[
    "P", "Pmin", "Pmax", "R", "Rmin", "Rmax", "S", "A", "E", "filter",
];

/// Reads a property file, or a single property.
///
/// Never fails: the tree holds what was understood, the diagnostics all mistakes. Properties end with `;`,
/// which may be left out before a new line's `P`, name or declaration. A mistake in a property costs that property: it is
/// among the [`unread`](PropertyFile::unread) ones, and reading goes on at the next.
///
/// ```
/// let parsed = prism_lang::parse_properties("\"safe\": P>=0.99 [ G !\"broken\" ]; P=? [ F x=3 ]");
/// assert!(parsed.diagnostics.is_empty());
/// assert_eq!(parsed.tree.properties[0].text, "P>=0.99 [ G !\"broken\" ]");
/// ```
pub fn parse_properties(text: &str) -> Parsed<PropertyFile> {
    let mut parser = Parser::new(text);
    let mut tree = PropertyFile::default();
    let mut all: Vec<(UnreadProperty, bool)> = Vec::new();
    while !parser.at_end() {
        let start = parser.at;
        let is_read = parser.property_part(&mut tree).is_ok();
        if !is_read && parser.starts_declaration(start) {
            parser.recover(PARTS);
        } else if !is_read {
            parser.recover_behind_property(start);
        }
        if !parser.starts_declaration(start) {
            all.push((parser.region(start, all.len()), is_read));
        }
    }
    let diagnostics = parser.finish();
    // The lexer's mistakes spoil a property that could be parsed without them.
    let errors: Vec<&Diagnostic> = diagnostics.iter().filter(|d| d.is_error()).collect();
    all.retain(|(property, is_read)| {
        let first = errors.partition_point(|e| e.span.start < property.span.start);
        !is_read || errors.get(first).is_some_and(|error| property.has(error))
    });
    tree.unread = all.into_iter().map(|(property, _)| property).collect();
    let unread = &tree.unread;
    let is_unread = |property: &Property| {
        let begun = unread.partition_point(|p| p.span.start <= property.span.start);
        begun > 0 && property.span.start < unread[begun - 1].span.end
    };
    tree.properties.retain(|property| !is_unread(property));
    Parsed { tree, diagnostics }
}

impl Parser<'_> {
    /// Whether the token at this place starts a constant, a label or a formula.
    fn starts_declaration(&self, at: usize) -> bool {
        let token = self.tokens[at];
        token.kind == TokenKind::Keyword
            && matches!(token.text, "const" | "rate" | "prob" | "formula" | "label")
    }

    /// From the token at `start` to the one that is next.
    fn region(&self, start: usize, index: usize) -> UnreadProperty {
        let (first, next) = (self.tokens[start], self.peek().span);
        let has_name = first.kind == TokenKind::Quoted
            && self.tokens.get(start + 1).is_some_and(|t| t.text == ":");
        let formula = if has_name { start + 2 } else { start };
        let formula = self.tokens[formula.min(self.tokens.len() - 1)].span.start;
        let end = self.previous_span().end.max(first.span.end);
        let text = self.text.get(formula..end).unwrap_or("");
        UnreadProperty {
            index,
            name: has_name.then(|| super::name_of(&first)),
            text: text
                .trim_end_matches([';', ' ', '\n', '\t', '\r'])
                .to_owned(),
            span: Span::new(first.span.start, next.start.max(end)),
        }
    }

    /// Skips to behind the next `;`, or to before the next declaration, or before what starts a property on a line of its own,
    /// not further to the right than the property that began at `start`: lines of one property are indented.
    fn recover_behind_property(&mut self, start: usize) {
        let own = self.indentation(self.tokens[start].span.start);
        if self.at == start {
            self.advance();
        }
        while !self.at_end() && !self.accept(";") {
            let token = self.peek();
            let is_keyword = token.kind == TokenKind::Keyword;
            let can_start =
                token.kind == TokenKind::Quoted || is_keyword && OPERATORS.contains(&token.text);
            let column = self.column(token.span.start);
            if is_keyword && PARTS.contains(&token.text)
                || can_start && column.is_some_and(|column| column <= own)
            {
                return;
            }
            self.advance();
        }
        while self.accept(";") {}
    }

    /// How far the line of a token is indented.
    fn indentation(&self, start: usize) -> usize {
        let line = &self.text[self.text[..start].rfind('\n').map_or(0, |at| at + 1)..];
        line.len() - line.trim_start().len()
    }

    /// How far a token is indented, if it is the first of its line.
    fn column(&self, start: usize) -> Option<usize> {
        let before = &self.text[..start];
        let line = &before[before.rfind('\n').map_or(0, |at| at + 1)..];
        line.trim().is_empty().then_some(line.len())
    }

    fn property_part(&mut self, file: &mut PropertyFile) -> Parse<()> {
        let token = self.peek();
        let keyword = if token.kind == TokenKind::Keyword {
            token.text
        } else {
            ""
        };
        match keyword {
            "const" | "rate" | "prob" => file.constants.push(self.constant()?),
            "formula" => file.formulas.push(self.formula()?),
            "label" => file.labels.push(self.label()?),
            _ => file.properties.push(self.property()?),
        }
        while self.accept(";") {}
        Ok(())
    }

    fn property(&mut self) -> Parse<Property> {
        let name = if self.peek().kind == TokenKind::Quoted && self.is_symbol_ahead(1, ":") {
            let name = super::name_of(&self.advance());
            self.advance();
            Some(name)
        } else {
            None
        };
        let start = self.peek().span;
        let formula = self.property_formula()?;
        // With the parentheses around the whole, which leave no node.
        let span = start.to(self.previous_span());
        self.end_of_property()?;
        let text = span.of(self.text).to_owned();
        Ok(Property {
            name,
            formula,
            text,
            span,
        })
    }

    fn end_of_property(&mut self) -> Parse<()> {
        let token = self.peek();
        let next_starts = match token.kind {
            TokenKind::End | TokenKind::Quoted => true,
            TokenKind::Keyword => !matches!(token.text, "U" | "W" | "endmodule"),
            _ => self.is_symbol(";") || self.starts_property_on_new_line(),
        };
        if next_starts {
            return Ok(());
        }
        if matches!(token.text, "]" | ")" | "}") {
            let message = format!("this `{}` closes nothing.", token.text);
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy("Remove it."));
            return Err(super::Reported);
        }
        Err(self.expected("an operator or `;`"))
    }

    /// Whether what follows stands on a line of its own and can start a formula.
    fn starts_property_on_new_line(&self) -> bool {
        let token = self.peek();
        let between = self.previous_span().end..token.span.start;
        let new_line = self
            .text
            .get(between)
            .is_some_and(|blanks| blanks.contains('\n'));
        let starts = match token.kind {
            TokenKind::Name | TokenKind::Integer | TokenKind::Real => true,
            _ => matches!(token.text, "(" | "!") || self.is_doubled("<") || self.is_doubled("["),
        };
        new_line && starts
    }
}
