//! XML text to a plain tree whose elements and attributes know their places.
//!
//! The parser (`roxmltree`) needs no entities here: a document type declaration is refused, so nothing can expand. The
//! tree is owned, so that included files can be spliced into it.

use std::sync::Arc;

use crate::diagnostics::{Place, Problem};

/// Elements may be nested this deep; robots need some twenty levels, MJCF one more for each link of a chain.
pub(crate) const MAX_DEPTH: usize = 400;

/// Nodes that one text may hold (elements, texts, comments).
const MAX_NODES: u32 = 4_000_000;

/// An element.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub name: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Element>,
    /// The text between its tags, without that of its children, trimmed.
    pub text: String,
    pub place: Place,
}

/// An attribute.
#[derive(Debug, Clone)]
pub(crate) struct Attribute {
    pub name: String,
    pub value: String,
    pub place: Place,
}

impl Element {
    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|known| known.name == name)
    }

    /// The value of the attribute called `name`.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|found| found.value.as_str())
    }

    /// The first child called `name`.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The children called `name`.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The text of the first child called `name`.
    pub fn text_of(&self, name: &str) -> Option<&str> {
        self.child(name).map(|child| child.text.as_str())
    }
}

/// Byte offsets at which lines start, to find places without a walk for each.
struct Lines<'a> {
    file: Arc<str>,
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn new(file: &str, text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(breaks.map(|(index, _)| index + 1));
        Self {
            file: file.into(),
            text,
            starts: starts.collect(),
        }
    }

    fn place(&self, offset: usize) -> Place {
        let line = self.starts.partition_point(|start| *start <= offset).max(1);
        let start = self.starts.get(line - 1).copied().unwrap_or(0);
        // Very long lines are counted in bytes, so that a file of one line is not walked for each of its elements.
        let before = self.text.get(start..offset).unwrap_or("");
        let characters = if before.len() < 10_000 {
            before.chars().count()
        } else {
            before.len()
        };
        Place {
            file: Arc::clone(&self.file),
            line: u32::try_from(line).unwrap_or(u32::MAX),
            column: u32::try_from(characters + 1).unwrap_or(u32::MAX),
        }
    }
}

/// The place of the first character of a file.
pub(crate) fn start_of(file: &str) -> Place {
    Place {
        file: file.into(),
        line: 1,
        column: 1,
    }
}

/// Reads `text`, known as `file`.
pub(crate) fn read(file: &str, text: &str) -> Result<Element, Problem> {
    // A byte order mark before the declaration is common on some systems.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Programs in C write the end of their strings along.
    let text = text.trim_end_matches('\0');
    let options = roxmltree::ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..roxmltree::ParsingOptions::default()
    };
    let tolerant = tolerant(text);
    let document = roxmltree::Document::parse_with_options(&tolerant, options)
        .map_err(|error| syntax_problem(file, &error))?;
    let lines = Lines::new(file, text);
    convert(document.root_element(), &lines, 1)
}

fn syntax_problem(file: &str, error: &roxmltree::Error) -> Problem {
    let position = error.pos();
    let place = Place {
        file: file.into(),
        line: position.row,
        column: position.col,
    };
    let message = error.to_string();
    // The parser's sentence ends with the position, which the place already says.
    let message = message.split(" at ").next().unwrap_or(&message).to_owned();
    let remedy = match error {
        roxmltree::Error::DtdDetected => "delete the <!DOCTYPE ...> declaration",
        roxmltree::Error::NodesLimitReached => "make the description smaller",
        _ => "correct the XML there",
    };
    Problem {
        place,
        message: format!("this is not well-formed XML: {message}"),
        remedy: remedy.to_owned(),
    }
}

/// Copies a node. The parser itself does not recurse into elements; this does, up to [`MAX_DEPTH`].
fn convert(
    node: roxmltree::Node<'_, '_>,
    lines: &Lines<'_>,
    depth: usize,
) -> Result<Element, Problem> {
    if depth > MAX_DEPTH {
        return Err(Problem {
            place: lines.place(node.range().start),
            message: format!("elements are nested more than {MAX_DEPTH} deep"),
            remedy: "split the description into several models".to_owned(),
        });
    }
    let attributes = node.attributes().map(|attribute| Attribute {
        name: original(lines.text, attribute.range().start, attribute.name()),
        value: attribute.value().to_owned(),
        place: lines.place(attribute.range().start),
    });
    let texts = node.children().filter(roxmltree::Node::is_text);
    let text: String = texts.filter_map(|child| child.text()).collect();
    let elements = node.children().filter(roxmltree::Node::is_element);
    Ok(Element {
        name: original(lines.text, node.range().start + 1, node.tag_name().name()),
        attributes: attributes.collect(),
        children: elements
            .map(|child| convert(child, lines, depth + 1))
            .collect::<Result<_, _>>()?,
        text: text.trim().to_owned(),
        place: lines.place(node.range().start),
    })
}

/// The text as strict XML of the same length, so that places stay: what the programs that wrote these languages accept
/// and the standard does not (`--` in comments, a declaration behind blanks, prefixes without a namespace).
///
/// Comments and processing instructions become blanks; a colon in a name becomes a full stop, and [`original`] finds it
/// again.
fn tolerant(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        result.push_str(&rest[..start]);
        rest = &rest[start..];
        let end = match rest.as_bytes() {
            [b'<', b'!', b'-', b'-', ..] => rest[4..].find("-->").map(|end| end + 7),
            [b'<', b'?', ..] => rest.find("?>").map(|end| end + 2),
            [b'<', b'!', b'[', ..] => rest.find("]]>").map(|end| end + 3),
            _ => Some(end_of_tag(rest)),
        };
        let (markup, behind) = rest.split_at(end.unwrap_or(rest.len()));
        match (markup.as_bytes(), end) {
            ([b'<', b'!', b'-', ..] | [b'<', b'?', ..], Some(_)) => blank(markup, &mut result),
            ([b'<', b'!', ..], _) | (_, None) => result.push_str(markup),
            _ => without_colons(markup, &mut result),
        }
        rest = behind;
    }
    result.push_str(rest);
    result
}

/// The length of a tag: up to the first `>` outside of quotes, or the whole rest.
fn end_of_tag(text: &str) -> usize {
    let mut quote = None;
    for (index, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return index + 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    text.len()
}

/// Blanks in place of a text, lines kept.
fn blank(text: &str, into: &mut String) {
    let line = |byte: u8| {
        if byte == b'\n' || byte == b'\r' {
            byte as char
        } else {
            ' '
        }
    };
    into.extend(text.bytes().map(line));
}

fn without_colons(tag: &str, into: &mut String) {
    let mut quote = None;
    for character in tag.chars() {
        match (quote, character) {
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            _ => {}
        }
        into.push(if quote.is_none() && character == ':' {
            '.'
        } else {
            character
        });
    }
}

/// The name as it was written, from the place where the parser found it.
fn original(text: &str, start: usize, name: &str) -> String {
    text.get(start..start + name.len())
        .unwrap_or(name)
        .to_owned()
}
