//! A small reader of HTML as this crate writes it: every attribute quoted,
//! every element closed. Stricter than a browser, so that what passes here is
//! read the same everywhere.
#![allow(dead_code)]

const VOID: [&str; 5] = ["meta", "link", "br", "hr", "input"];

/// A start tag.
#[derive(Debug)]
pub struct Element<'a> {
    pub name: &'a str,
    pub attributes: Vec<(&'a str, &'a str)>,
}

impl Element<'_> {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(_, v)| *v)
    }
}

enum Piece<'a> {
    Open(Element<'a>),
    Close(&'a str),
    Text(&'a str),
}

/// Cuts the page into tags and text; the content of `style` and `script` is
/// skipped.
fn pieces(page: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = page.strip_prefix("<!DOCTYPE html>").unwrap_or(page);
    while !rest.is_empty() {
        let Some(tag) = rest.strip_prefix('<') else {
            let end = rest.find('<').unwrap_or(rest.len());
            pieces.push(Piece::Text(&rest[..end]));
            rest = &rest[end..];
            continue;
        };
        let end = tag_end(tag);
        let inside = &tag[..end];
        rest = &tag[end + 1..];
        if let Some(name) = inside.strip_prefix('/') {
            pieces.push(Piece::Close(name));
            continue;
        }
        let element = element(inside);
        if element.name == "style" || element.name == "script" {
            let close = format!("</{}>", element.name);
            rest = &rest[rest.find(&close).expect("raw text is closed")..];
        }
        pieces.push(Piece::Open(element));
    }
    pieces
}

/// Place of the `>` that ends the tag, quotes respected.
fn tag_end(tag: &str) -> usize {
    let mut quoted = false;
    for (place, c) in tag.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '>' if !quoted => return place,
            _ => {}
        }
    }
    panic!("a tag never ends: {}", &tag[..tag.len().min(60)]);
}

fn element(inside: &str) -> Element<'_> {
    let (name, mut rest) = inside.split_once(' ').unwrap_or((inside, ""));
    assert!(
        name.chars().all(|c| c.is_ascii_alphanumeric()),
        "element {name:?}"
    );
    let mut attributes = Vec::new();
    while !rest.is_empty() {
        let end = rest.find(['=', ' ']).unwrap_or(rest.len());
        let name = &rest[..end];
        assert!(
            !name.is_empty() && !name.contains(['<', '"', '\'']),
            "attribute {name:?}"
        );
        rest = &rest[end..];
        let Some(quoted) = rest.strip_prefix("=\"") else {
            attributes.push((name, ""));
            rest = rest.trim_start();
            continue;
        };
        let close = quoted.find('"').expect("the attribute's quote is closed");
        attributes.push((name, &quoted[..close]));
        rest = quoted[close + 1..].trim_start();
    }
    Element { name, attributes }
}

/// All start tags of the page.
pub fn elements(page: &str) -> impl Iterator<Item = Element<'_>> {
    pieces(page).into_iter().filter_map(|piece| match piece {
        Piece::Open(element) => Some(element),
        _ => None,
    })
}

/// The page's text, with the escapes undone.
pub fn text(page: &str) -> String {
    let texts = pieces(page).into_iter().filter_map(|piece| match piece {
        Piece::Text(text) => Some(text),
        _ => None,
    });
    let joined: String = texts.collect();
    joined
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&amp;", "&")
}

/// Panics unless every element is closed in its turn and every `&` is an
/// escape.
pub fn check(page: &str) {
    let mut open = Vec::new();
    for piece in pieces(page) {
        match piece {
            Piece::Open(element) if VOID.contains(&element.name) => {}
            Piece::Open(element) => open.push(element.name),
            Piece::Close(name) => assert_eq!(open.pop(), Some(name), "closed out of turn"),
            Piece::Text(text) => check_escapes(text),
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

fn check_escapes(text: &str) {
    for (place, _) in text.match_indices('&') {
        let known = ["&amp;", "&lt;", "&gt;", "&quot;"];
        let escape = known.iter().any(|e| text[place..].starts_with(e));
        assert!(escape, "a bare & in {text:?}");
    }
    assert!(!text.contains('>'), "a bare > in {text:?}");
}

#[test]
fn the_checker_finds_faults() {
    for fault in [
        "<p><b></p></b>",
        "<p>",
        "<p>a & b</p>",
        "<p class=\"x>y</p>",
    ] {
        assert!(
            std::panic::catch_unwind(|| check(fault)).is_err(),
            "{fault}"
        );
    }
    check("<p title=\"a > b\">x &amp; y<br></p>");
}
