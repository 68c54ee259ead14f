//! Splits IDL into tokens.

use crate::schema::SchemaError;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Token {
    pub(super) text: String,
    pub(super) line: usize,
}

/// Splits the text into names (with `::`), numbers, quoted texts and single signs.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, SchemaError> {
    let mut found = Vec::new();
    let mut in_comment = false;
    for (index, whole) in text.lines().enumerate() {
        let trimmed = whole.trim();
        let is_rule = trimmed.len() >= 3 && trimmed.bytes().all(|b| b == b'=');
        if !in_comment && (trimmed.starts_with('#') || trimmed.starts_with("IDL:") || is_rule) {
            continue;
        }
        let mut rest = whole;
        loop {
            if in_comment {
                let Some(end) = rest.find("*/") else { break };
                rest = &rest[end + 2..];
                in_comment = false;
            }
            rest = rest.trim_start();
            if rest.is_empty() || rest.starts_with("//") {
                break;
            }
            if let Some(after) = rest.strip_prefix("/*") {
                (rest, in_comment) = (after, true);
                continue;
            }
            let length = token_length(rest, index + 1)?;
            found.push(Token {
                text: rest[..length].to_owned(),
                line: index + 1,
            });
            rest = &rest[length..];
        }
    }
    Ok(found)
}

fn token_length(rest: &str, line: usize) -> Result<usize, SchemaError> {
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || b"_.:".contains(&byte);
    let bytes = rest.as_bytes();
    if bytes[0] == b'"' || bytes[0] == b'\'' {
        let mut at = 1;
        while at < bytes.len() && bytes[at] != bytes[0] {
            at += if bytes[at] == b'\\' { 2 } else { 1 };
        }
        if at >= bytes.len() {
            return Err(SchemaError::new(line, "a quoted text has no end"));
        }
        return Ok(at + 1);
    }
    let length = bytes.iter().take_while(|byte| is_word(**byte)).count();
    // A single colon is a sign of its own (inheritance).
    if length > 0 && bytes[..length] != *b":" {
        return Ok(length);
    }
    Ok(rest.chars().next().map_or(1, char::len_utf8))
}
