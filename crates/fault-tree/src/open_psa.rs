//! Fault trees of the Open-PSA Model Exchange Format.
//!
//! Source: S. Epstein, A. Rauzy, *Open-PSA Model Exchange Format*, version 2.0d, 2008, sections 3 and 4.
//!
//! | element | read as |
//! |---|---|
//! | `define-fault-tree`, `define-component`, `model-data` | containers; all names are public, and names are global |
//! | `define-gate` with `and`, `or`, `atleast`, `not`, `xor` (of two), `nand`, `nor`, `constant`, references | a gate |
//! | `define-basic-event` with a number or `exponential` | a basic event |
//! | `define-house-event` | a house event; false without a value, as the format says |
//! | `define-parameter` with a number | a number by name |
//! | `float`, `int`, `parameter`, `system-mission-time` | numbers |
//! | attributes `occurrences` and `trials`, or `probability-lower` and `probability-upper`, of a basic event | counts or an interval, which go before the event's expression |
//!
//! Everything else (event trees, common-cause groups, distributions, arithmetic, private names) is refused by name and place.
//! The attributes are how the format lets a tool add what it has no element for; other tools pass over them.

mod events;
mod formula;
mod written;

pub(crate) use written::written_in_open_psa;

use std::collections::HashMap;
use std::ops::Range;

use diagnostic::{Problem, Source};
use roxmltree::{Document, Node, ParsingOptions};

use crate::draft::{Body, Draft};
use crate::mistakes::Mistakes;
use crate::reading::{Reading, Settings};

/// Nodes that one text may hold (elements, texts, comments).
const MAX_NODES: u32 = 20_000_000;

/// Reads the fault trees of a text in the Open-PSA format, as one tree.
///
/// # Errors
/// All mistakes of the text as one problem, each with its place and a remedy: what is not well-formed, not defined, defined
/// twice or depends on itself (`bad-fault-tree`), and what is well-formed and not understood (`unsupported-fault-tree`).
pub fn read_open_psa(source: &Source, settings: &Settings) -> Result<Reading, Problem> {
    let mut mistakes = Mistakes::new(source);
    let document = match parsed(&source.text) {
        Ok(document) => document,
        Err(error) => {
            let at = offset(&source.text, error.pos());
            mistakes.add(
                at..at + 1,
                format!("this is not well-formed XML: {error}"),
                "correct it here",
            );
            return Err(mistakes.into_problem(&[]).expect("one mistake"));
        }
    };
    let mut draft = Draft::default();
    let root = document.root_element();
    if root.tag_name().name() == "opsa-mef" {
        let mut reader = Reader {
            settings,
            parameters: HashMap::new(),
            draft: &mut draft,
            mistakes: &mut mistakes,
        };
        let definitions = reader.definitions(root);
        reader.parameters(&definitions);
        definitions.iter().for_each(|it| reader.define(*it));
    } else {
        let message = format!("the outermost element is `{}`", root.tag_name().name());
        mistakes.add(
            tag(root),
            message,
            "an Open-PSA model begins with `<opsa-mef>`",
        );
    }
    draft.resolve(source, mistakes)
}

fn parsed(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
}

struct Reader<'a, 'd, 'm> {
    settings: &'a Settings,
    parameters: HashMap<&'d str, Node<'d, 'd>>,
    draft: &'a mut Draft,
    mistakes: &'a mut Mistakes<'m>,
}

impl<'d> Reader<'_, 'd, '_> {
    /// The definitions within all containers, in the order of the text.
    fn definitions(&mut self, root: Node<'d, 'd>) -> Vec<Node<'d, 'd>> {
        let mut found = Vec::new();
        let mut open = vec![root];
        while let Some(container) = open.pop() {
            for child in container.children().filter(Node::is_element) {
                match child.tag_name().name() {
                    "label" | "attributes" => {}
                    "define-fault-tree" | "define-component" | "model-data" => open.push(child),
                    "define-gate" | "define-basic-event" | "define-house-event"
                    | "define-parameter" => {
                        found.push(child);
                    }
                    other => {
                        let message =
                            format!("`{other}` is not read: only fault trees and their data are");
                        self.mistakes.refuse(
                            tag(child),
                            message,
                            "take it away, or use a tool that reads it",
                        );
                    }
                }
            }
        }
        found.sort_by_key(|it| it.range().start);
        found
    }

    fn parameters(&mut self, definitions: &[Node<'d, 'd>]) {
        for definition in definitions
            .iter()
            .filter(|it| it.has_tag_name("define-parameter"))
        {
            let Some((name, span)) = self.name(*definition) else {
                continue;
            };
            if self.parameters.insert(name, *definition).is_some() {
                let message = format!("the parameter `{name}` is defined twice");
                self.mistakes.add(span, message, "keep one of them");
            }
        }
    }

    fn define(&mut self, definition: Node<'d, 'd>) {
        if definition.has_tag_name("define-parameter") {
            return;
        }
        let Some((name, span)) = self.name(definition) else {
            return;
        };
        if definition.attribute("role") == Some("private") {
            let message =
                format!("`{name}` is private to its container, and names are global here");
            self.mistakes
                .refuse(span.clone(), message, "make it public, and its name unique");
        }
        let name = Some(name.to_owned());
        match definition.tag_name().name() {
            "define-gate" => self.gate(name, span, definition),
            "define-house-event" => {
                let body = self.house(definition);
                self.draft.define(name, span, body);
            }
            _ => {
                let body = self.basic(definition).map_or(Body::Unknown, Body::Basic);
                self.draft.define(name, span, body);
            }
        }
    }

    /// The attribute `name`, which a definition or a reference needs.
    fn name(&mut self, node: Node<'d, 'd>) -> Option<(&'d str, Range<usize>)> {
        let found = node
            .attribute_node("name")
            .filter(|it| !it.value().is_empty());
        if found.is_none() {
            let message = format!("`{}` has no name", node.tag_name().name());
            self.mistakes
                .add(tag(node), message, "write `name=\"...\"`");
        }
        found.map(|it| (it.value(), it.range_value()))
    }
}

/// The child elements that say something: without labels and attributes.
fn content<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    let elements = node.children().filter(Node::is_element);
    elements.filter(|it| !matches!(it.tag_name().name(), "label" | "attributes"))
}

/// The place of an element: the beginning of its tag.
fn tag(node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start;
    start..start + 1 + node.tag_name().name().len()
}

/// The byte of a line and a column, as the parser of XML counts them.
fn offset(text: &str, position: roxmltree::TextPos) -> usize {
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines
        .by_ref()
        .take(position.row as usize - 1)
        .map(str::len)
        .sum();
    let line = lines.next().unwrap_or_default();
    let column = line
        .char_indices()
        .nth(position.col.saturating_sub(1) as usize);
    before + column.map_or(line.len(), |(index, _)| index)
}
