//! Formatted text as plain text, and plain text as formatted text.
//!
//! # Definition
//! Blocks (paragraphs, list items, rows, headings) and `br` begin a new line; runs of white space are one space, but for what
//! stands in `pre`. An object (a picture) is `[its name]`.

use roxmltree::Node;

/// How deeply elements are followed; what is deeper is read without its blocks.
const MAX_DEPTH: usize = 200;

const BLOCKS: [&str; 18] = [
    "p",
    "div",
    "li",
    "ul",
    "ol",
    "tr",
    "table",
    "h1",
    "h2",
    "h3",
    "h4",
    "h5",
    "h6",
    "pre",
    "blockquote",
    "dl",
    "dt",
    "dd",
];

/// The plain text of an element's content.
pub(super) fn text(node: Node<'_, '_>) -> String {
    let mut out = Out::default();
    out.content(node, 0, false);
    out.finished()
}

/// A plain text as the content of an element: one block, whose lines are kept.
pub(super) fn written(text: &str) -> String {
    let has_layout = text
        .lines()
        .any(|line| line.contains("  ") || line != line.trim() || line.contains('\t'));
    let (open, close, line_break) = match has_layout {
        true => ("<xhtml:pre>", "</xhtml:pre>", "\n"),
        false => ("", "", "<xhtml:br/>"),
    };
    let lines: Vec<String> = text.split('\n').map(escaped).collect();
    format!(
        "<xhtml:div xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">{open}{}{close}</xhtml:div>",
        lines.join(line_break)
    )
}

/// A text with what has a meaning in XML written otherwise.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\r' => out.push_str("&#13;"),
            other => out.push(other),
        }
    }
    out
}

#[derive(Default)]
struct Out {
    text: String,
    /// Whether the next text begins a new line.
    breaks: usize,
    /// Whether white space stands before the next text.
    space: bool,
}

impl Out {
    fn content(&mut self, node: Node<'_, '_>, depth: usize, is_pre: bool) {
        for child in node.children() {
            if child.is_text() {
                self.push(child.text().unwrap_or_default(), is_pre);
            } else if child.is_element() && depth < MAX_DEPTH {
                self.element(child, depth, is_pre);
            } else if child.is_element() {
                let texts = child.descendants().filter(Node::is_text);
                texts.for_each(|it| self.push(it.text().unwrap_or_default(), is_pre));
            }
        }
    }

    fn element(&mut self, node: Node<'_, '_>, depth: usize, is_pre: bool) {
        let name = node.tag_name().name();
        let is_block = BLOCKS.contains(&name);
        if name == "br" {
            self.breaks += 1;
            self.space = false;
            return;
        }
        if is_block {
            self.block();
        }
        if name == "object"
            && let Some(data) = node.attribute("data")
        {
            self.push(&format!("[{data}]"), false);
        }
        self.content(node, depth + 1, is_pre || name == "pre");
        if is_block {
            self.block();
        }
        if matches!(name, "td" | "th") {
            self.space = true;
        }
    }

    /// A block begins or ends here: its text stands in a line of its own.
    fn block(&mut self) {
        self.space = false;
        if !self.text.is_empty() {
            self.breaks = self.breaks.max(1);
        }
    }

    fn push(&mut self, text: &str, is_pre: bool) {
        if is_pre {
            self.line_breaks();
            self.text.push_str(text);
            return;
        }
        for letter in text.chars() {
            match letter.is_whitespace() && letter != '\u{a0}' {
                true => self.space = true,
                false => {
                    self.line_breaks();
                    if self.space && !self.text.is_empty() && !self.text.ends_with('\n') {
                        self.text.push(' ');
                    }
                    self.space = false;
                    self.text.push(letter);
                }
            }
        }
    }

    fn line_breaks(&mut self) {
        if self.breaks > 0 {
            self.text.extend(std::iter::repeat_n('\n', self.breaks));
            self.breaks = 0;
            self.space = false;
        }
    }

    fn finished(self) -> String {
        self.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use roxmltree::Document;

    fn of(content: &str) -> String {
        let xml = format!("<a xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">{content}</a>");
        text(Document::parse(&xml).expect("XML").root_element())
    }

    #[test]
    fn blocks_begin_lines_and_spaces_are_one() {
        assert_eq!(of("<div>a\n  b<p>c</p><p>d</p> e</div>"), "a b\nc\nd\ne");
        assert_eq!(
            of("<ul><li>one</li><li>two <b>2</b></li></ul>"),
            "one\ntwo 2"
        );
        assert_eq!(of("x<br/><br/>y &amp; z"), "x\n\ny & z");
        assert_eq!(of("<object data=\"p.png\"/>"), "[p.png]");
    }

    #[test]
    fn what_is_written_is_read_again() {
        for plain in [
            "a < b & \"c\"",
            "one\ntwo\n\nthree",
            "  code\n\tx  y",
            "é\u{a0}x",
        ] {
            assert_eq!(of(&written(plain)), plain);
        }
    }
}
