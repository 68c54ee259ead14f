//! Property files, and single properties as given on a command line.

use super::{Parse, Parser};
use crate::ast::{Property, PropertyFile};
use crate::diagnostic::{Diagnostic, Parsed};
use crate::lexer::TokenKind;

/// Words at which something new starts in a property file.
const PARTS: &[&str] = &["const", "label", "formula"];

/// Reads a property file, or a single property.
///
/// Never fails: the tree holds what was understood, the diagnostics all mistakes. Properties end with `;`,
/// which may be left out before a new line's `P`, name or declaration.
///
/// ```
/// let parsed = prism_lang::parse_properties("\"safe\": P>=0.99 [ G !\"broken\" ]; P=? [ F x=3 ]");
/// assert!(parsed.diagnostics.is_empty());
/// assert_eq!(parsed.tree.properties[0].text, "P>=0.99 [ G !\"broken\" ]");
/// ```
pub fn parse_properties(text: &str) -> Parsed<PropertyFile> {
    let mut parser = Parser::new(text);
    let mut tree = PropertyFile::default();
    while !parser.at_end() {
        if parser.property_part(&mut tree).is_err() {
            parser.recover(PARTS);
        }
    }
    Parsed {
        tree,
        diagnostics: parser.finish(),
    }
}

impl Parser<'_> {
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
