//! Formulas, from elements to definitions; each nested formula is a definition without a name.

use std::ops::Range;

use roxmltree::Node;

use super::{Reader, content, tag};
use crate::draft::{Argument, Body};
use crate::galileo::check_count;
use crate::tree::Connective;

impl<'d> Reader<'_, 'd, '_> {
    pub(super) fn gate(
        &mut self,
        name: Option<String>,
        span: Range<usize>,
        definition: Node<'d, 'd>,
    ) {
        let shown = name.clone().unwrap_or_default();
        let index = self.draft.define(name, span.clone(), Body::Unknown);
        let mut formulas = content(definition);
        let (Some(formula), None) = (formulas.next(), formulas.next()) else {
            return self.mistakes.add(
                span,
                format!("the gate `{shown}` has one formula"),
                "write one, for example `<and>`",
            );
        };
        // Formulas nest as deep as they like: those that are left to read are a list of our own.
        let mut open = vec![(formula, index)];
        while let Some((formula, index)) = open.pop() {
            let body = self.formula(formula, &mut open);
            self.draft.definitions[index].body = body;
        }
    }

    fn formula(&mut self, formula: Node<'d, 'd>, open: &mut Vec<(Node<'d, 'd>, usize)>) -> Body {
        let connective = match formula.tag_name().name() {
            "gate" | "basic-event" | "house-event" | "event" => {
                // A gate that is another by name.
                let argument = self.argument(formula, open);
                return argument.map_or(Body::Unknown, |it| Body::Gate(Connective::Or, vec![it]));
            }
            "constant" => return self.constant(formula).map_or(Body::Unknown, Body::House),
            "and" => Connective::And,
            "or" => Connective::Or,
            "not" => Connective::Not,
            "xor" => Connective::Xor,
            "nand" => Connective::Nand,
            "nor" => Connective::Nor,
            "atleast" => match self.least(formula) {
                Some(least) => Connective::AtLeast(least),
                None => return Body::Unknown,
            },
            other => {
                let message = format!("the formula `{other}` is not read");
                let remedy =
                    "use and, or, not, xor, nand, nor, atleast, constant, or the name of an event";
                self.mistakes.refuse(tag(formula), message, remedy);
                return Body::Unknown;
            }
        };
        let arguments: Vec<_> = content(formula).map(|it| self.argument(it, open)).collect();
        if let Err((message, remedy)) = check_count(connective, arguments.len()) {
            let message = format!("`{}` {message}", formula.tag_name().name());
            self.mistakes.add(tag(formula), message, remedy);
            return Body::Unknown;
        }
        let arguments: Option<Vec<Argument>> = arguments.into_iter().collect();
        arguments.map_or(Body::Unknown, |it| Body::Gate(connective, it))
    }

    fn argument(
        &mut self,
        node: Node<'d, 'd>,
        open: &mut Vec<(Node<'d, 'd>, usize)>,
    ) -> Option<Argument> {
        if !matches!(
            node.tag_name().name(),
            "gate" | "basic-event" | "house-event" | "event"
        ) {
            let index = self.draft.define(None, tag(node), Body::Unknown);
            open.push((node, index));
            return Some(Argument::Formula(index));
        }
        let (name, span) = self.name(node)?;
        if name.contains('.') {
            let message = format!("`{name}` is a path into a container, and names are global here");
            let remedy = "make the event public, and name it without its container";
            self.mistakes.refuse(span, message, remedy);
            return None;
        }
        Some(Argument::Name(name.to_owned(), span))
    }

    fn least(&mut self, formula: Node<'d, 'd>) -> Option<usize> {
        let least = formula.attribute("min").and_then(|it| it.parse().ok());
        if least.is_none() {
            let message = "`atleast` needs `min`, a whole number";
            self.mistakes.add(
                tag(formula),
                message,
                "write for example `<atleast min=\"2\">`",
            );
        }
        least
    }

    pub(super) fn constant(&mut self, node: Node<'d, 'd>) -> Option<bool> {
        match node.attribute("value") {
            Some("true") => Some(true),
            Some("false") => Some(false),
            _ => {
                let message = "`constant` has the value `true` or `false`";
                self.mistakes.add(
                    tag(node),
                    message,
                    "write for example `<constant value=\"true\"/>`",
                );
                None
            }
        }
    }
}
