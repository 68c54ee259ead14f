//! Rust source with all that is not code taken out, so that words in comments and texts do not count.

/// The code that users run: comments, texts and `#[cfg(test)]` items are blanked; line breaks stay, so that line
/// numbers hold.
pub fn product_code(source: &str) -> String {
    without_tests(&without_comments_and_texts(source))
}

/// Blanks comments, string literals and character literals.
pub fn without_comments_and_texts(source: &str) -> String {
    let bytes = source.as_bytes();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < bytes.len() {
        let end = skipped_until(bytes, at);
        if end > at {
            out.extend(
                bytes[at..end]
                    .iter()
                    .map(|&b| if b == b'\n' { '\n' } else { ' ' }),
            );
            at = end;
        } else {
            out.push(if bytes[at].is_ascii() {
                bytes[at] as char
            } else {
                ' '
            });
            at += 1;
        }
    }
    out
}

/// The end of the comment or literal that begins at `at`, or `at` if none begins there.
fn skipped_until(bytes: &[u8], at: usize) -> usize {
    let rest = &bytes[at..];
    if rest.starts_with(b"//") {
        return at + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }
    if rest.starts_with(b"/*") {
        return block_comment_end(bytes, at);
    }
    if rest.starts_with(b"\"") {
        return text_end(bytes, at + 1);
    }
    let word_before = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_');
    if rest[0] == b'r' && (!word_before || bytes[at - 1] == b'b') {
        let hashes = rest[1..].iter().take_while(|&&b| b == b'#').count();
        if rest.get(1 + hashes) == Some(&b'"') {
            return raw_text_end(bytes, at + 2 + hashes, hashes);
        }
    }
    if rest[0] == b'\'' {
        return at + character_length(rest);
    }
    at
}

fn block_comment_end(bytes: &[u8], at: usize) -> usize {
    let (mut depth, mut end) = (0usize, at);
    while end < bytes.len() {
        if bytes[end..].starts_with(b"/*") {
            depth += 1;
            end += 2;
        } else if bytes[end..].starts_with(b"*/") {
            depth -= 1;
            end += 2;
            if depth == 0 {
                return end;
            }
        } else {
            end += 1;
        }
    }
    end
}

fn text_end(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() && bytes[at] != b'"' {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(bytes.len())
}

fn raw_text_end(bytes: &[u8], from: usize, hashes: usize) -> usize {
    let mut closing = vec![b'"'];
    closing.extend(std::iter::repeat_n(b'#', hashes));
    let found = bytes[from..]
        .windows(closing.len())
        .position(|w| w == closing);
    found.map_or(bytes.len(), |p| from + p + closing.len())
}

/// Bytes of the character literal at the start of `rest`; 0 if it is a lifetime.
fn character_length(rest: &[u8]) -> usize {
    if rest.get(1) == Some(&b'\\') {
        let closing = rest.iter().skip(3).position(|&b| b == b'\'');
        return closing.map_or(0, |p| p + 4);
    }
    // One character is at most four bytes; a lifetime has no closing quote so near.
    let closing = rest.iter().skip(2).take(4).position(|&b| b == b'\'');
    let length = closing.map_or(0, |p| p + 3);
    let is_one_character = length > 0
        && std::str::from_utf8(&rest[1..length - 1]).is_ok_and(|t| t.chars().count() == 1);
    if is_one_character { length } else { 0 }
}

/// Blanks the items marked `#[cfg(test)]`.
fn without_tests(code: &str) -> String {
    let mut out = code.to_owned();
    while let Some(start) = out.find("#[cfg(test)]") {
        let end = item_end(&out, start);
        let blank: String = out[start..end]
            .chars()
            .map(|c| if c == '\n' { '\n' } else { ' ' })
            .collect();
        out.replace_range(start..end, &blank);
    }
    out
}

/// The end of the item whose attribute begins at `start`: its closing brace, or its semicolon.
fn item_end(code: &str, start: usize) -> usize {
    let mut depth = 0usize;
    for (offset, character) in code[start..].char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth <= 1 => return start + offset + 1,
            '}' => depth -= 1,
            ';' if depth == 0 => return start + offset + 1,
            _ => {}
        }
    }
    code.len()
}

/// The one-based lines of `code` on which `wanted` stands as whole words (`std::fs`, `println!`).
pub fn lines_with(code: &str, wanted: &str) -> Vec<usize> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let stands_alone = |line: &str, at: usize| {
        let before = line[..at].chars().next_back();
        let after = line[at + wanted.len()..].chars().next();
        let longer_before = before.is_some_and(is_word);
        let longer_after = after.is_some_and(is_word) && wanted.ends_with(is_word);
        !longer_before && !longer_after
    };
    let has = |line: &str| {
        line.match_indices(wanted)
            .any(|(at, _)| stands_alone(line, at))
    };
    let numbered = code.lines().enumerate();
    numbered
        .filter(|(_, line)| has(line))
        .map(|(index, _)| index + 1)
        .collect()
}

/// Writes imports of the standard library out, as [`with_groups_of`] does.
pub fn with_groups_written_out(code: &str) -> String {
    with_groups_of(code, "std::")
}

/// Writes grouped imports from `path` out, one path each, on the line where the group begins: `use std::{fs, io}` also reads
/// `std::fs std::io`. Only the first level of a group is written out.
pub fn with_groups_of(code: &str, path: &str) -> String {
    let mut out = code.to_owned();
    let mut from = 0;
    while let Some(found) = out[from..].find(&format!("{path}{{")) {
        let open = from + found + path.len();
        let close = item_end(&out, open);
        let inner = out[open + 1..close.saturating_sub(1)].replace('\n', " ");
        let paths: String = first_level(&inner)
            .iter()
            .map(|name| format!(" {path}{} ", name.trim()))
            .collect();
        out.insert_str(open - path.len(), &paths);
        from = open + paths.len() + 1;
    }
    out
}

fn first_level(group: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0usize, 0);
    for (at, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[start..]);
    parts
}

/// The lines of matches over one of these enums that have an arm for the rest: `_`, or a name of its own, in the place
/// where arms before it name variants.
pub fn silent_matches(code: &str, enums: &[&str]) -> Vec<usize> {
    let is_word = |at: usize| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_')
    };
    let silent = code
        .match_indices("match ")
        .filter(|(at, _)| is_word(*at) && takes_the_rest(&patterns(&code[*at..]), enums))
        .map(|(at, _)| code[..at].matches('\n').count() + 1);
    silent.collect()
}

fn takes_the_rest(patterns: &[String], enums: &[&str]) -> bool {
    let alternatives = patterns.iter().flat_map(|pattern| {
        let without_guard = pattern.split(" if ").next().unwrap_or_default();
        split_at_first_level(without_guard, "|")
    });
    let arms: Vec<Vec<&str>> = alternatives.map(places_of).collect();
    let names = |text: &str| {
        let mut enums = enums.iter();
        enums.any(|name| !lines_with(text, &format!("{name}::")).is_empty())
    };
    let is_catching = |text: &str| {
        let text = text.trim_start_matches('&');
        text.starts_with(|c: char| c == '_' || c.is_lowercase())
            && text.chars().all(|c| c.is_alphanumeric() || c == '_')
            && !["true", "false"].contains(&text)
    };
    let width = arms.iter().map(Vec::len).max().unwrap_or(0);
    (0..width).any(|place| {
        let of_place = arms.iter().map(|arm| arm.get(place).or(arm.first()));
        let mut after = of_place.flatten().skip_while(|text| !names(text));
        after.any(|text| is_catching(text))
    })
}

/// A pattern's places: those of a tuple, or itself alone.
fn places_of(pattern: &str) -> Vec<&str> {
    let inner = pattern
        .strip_prefix('(')
        .and_then(|it| it.strip_suffix(')'));
    inner.map_or_else(|| vec![pattern], |it| split_at_first_level(it, ","))
}

fn split_at_first_level<'t>(text: &'t str, separator: &str) -> Vec<&'t str> {
    let (mut parts, mut rest) = (Vec::new(), text);
    while let Some(at) = at_first_level(rest, separator) {
        parts.push(rest[..at].trim());
        rest = &rest[at + separator.len()..];
    }
    parts.push(rest.trim());
    parts
}

/// The patterns of the arms of the match that begins here.
fn patterns(code: &str) -> Vec<String> {
    let Some(open) = opening_brace(code) else {
        return Vec::new();
    };
    let body = &code[open + 1..item_end(code, open).saturating_sub(1).max(open + 1)];
    let (mut patterns, mut from) = (Vec::new(), 0);
    while let Some(arrow) = at_first_level(&body[from..], "=>") {
        patterns.push(body[from..from + arrow].trim().to_owned());
        let rest = from + arrow + 2;
        let space = body[rest..].len() - body[rest..].trim_start().len();
        let after = match body[rest + space..].starts_with('{') {
            true => item_end(body, rest + space),
            false => rest + at_first_level(&body[rest..], ",").unwrap_or(body.len() - rest),
        };
        from =
            after + body[after..].len() - body[after..].trim_start_matches([',', ' ', '\n']).len();
    }
    patterns
}

/// Where the arms of a match begin, which what is matched does not contain in the open.
fn opening_brace(code: &str) -> Option<usize> {
    at_first_level(code, "{")
}

/// Where a text stands outside of all brackets.
fn at_first_level(code: &str, wanted: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, letter) in code.char_indices() {
        if depth == 0 && code[at..].starts_with(wanted) {
            return Some(at);
        }
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    None
}

#[test]
fn a_match_that_names_some_variants_and_takes_the_rest_is_found() {
    let found = |arms: &str| {
        let code = format!("fn f() {{\n    match (a, b) {{ {arms} }}\n}}");
        silent_matches(&code, &["Kind"])
    };
    for silent in [
        "Kind::A => 1, _ => 2",
        "Kind::A { .. } => { f(x) } other => 2",
        "(Kind::A, 1) => g(|| 1), (_, true) => 2, (Kind::B, _) => 3",
        "&Kind::A if x => 1, _ if y => 2, Kind::A | Kind::B => 3",
    ] {
        assert_eq!(found(silent), [2], "{silent}");
    }
    for exhaustive in [
        "Kind::A => 1, Kind::B => 2",
        "(Kind::A, _) => 1, (Kind::B, true) => 2, (Kind::B, other) => 3",
        "(1, _) => 1, (2, Kind::A) => 2, (3, Kind::B) | (4, Kind::A) => 3",
        "Other::A => 1, _ => 2",
        "MyKind::A => 1, _ => 2",
        "Some(Kind::A) => { match x { _ => 1 } } Some(Kind::B) | None => 2",
    ] {
        assert_eq!(found(exhaustive), [0; 0], "{exhaustive}");
    }
}
