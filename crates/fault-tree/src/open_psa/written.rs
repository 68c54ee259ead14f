//! Where the formulas of a text stand.

use std::ops::Range;

use roxmltree::Node;

use super::{content, parsed};
use crate::rewrites::{Written, WrittenGate};
use crate::tree::Connective;

/// The formulas of a text's gates, and its events; none if the text is not well-formed.
pub(crate) fn written_in_open_psa(text: &str) -> Written {
    let Ok(document) = parsed(text) else {
        return Written::default();
    };
    let mut found = Vec::new();
    let definitions = document.descendants();
    for definition in definitions.filter(|it| it.has_tag_name("define-gate")) {
        let Some(name) = definition.attribute("name") else {
            continue;
        };
        let mut open: Vec<Node<'_, '_>> = content(definition).collect();
        while let Some(formula) = open.pop() {
            open.extend(content(formula));
            found.extend(gate(text, name, formula));
        }
    }
    found.sort_by_key(|it| it.words.first().map(|word| word.start));
    let events = document.descendants();
    let events = events.filter(|it| it.has_tag_name("define-basic-event"));
    let events = events.filter_map(|it| Some(it.attribute("name")?.to_owned()));
    Written {
        gates: found,
        events: events.collect(),
    }
}

fn gate(text: &str, name: &str, formula: Node<'_, '_>) -> Option<WrittenGate> {
    let connective = match formula.tag_name().name() {
        "and" => Connective::And,
        "or" => Connective::Or,
        "not" => Connective::Not,
        "xor" => Connective::Xor,
        "nand" => Connective::Nand,
        "nor" => Connective::Nor,
        "atleast" => Connective::AtLeast(formula.attribute("min")?.parse().ok()?),
        _ => return None,
    };
    let arguments = content(formula).map(|it| {
        let is_name = matches!(
            it.tag_name().name(),
            "gate" | "basic-event" | "house-event" | "event"
        );
        let name = it.attribute("name").filter(|_| is_name);
        (name.map(str::to_owned), it.range())
    });
    let arguments: Vec<(Option<String>, Range<usize>)> = arguments.collect();
    let whole = formula.range();
    let first = formula.first_child()?.range().start;
    let last = formula.last_child()?.range().end;
    let tags = [whole.start..first, last..whole.end];
    // The blanks between a tag and what it holds belong to neither.
    let trimmed = |it: Range<usize>| {
        let written = text.get(it.clone())?.trim_end();
        Some(it.start..it.start + written.len())
    };
    let words: Option<Vec<Range<usize>>> = tags.into_iter().map(trimmed).collect();
    (!arguments.is_empty()).then_some(WrittenGate {
        name: name.to_owned(),
        connective,
        words: words?,
        arguments,
    })
}
