//! An argument in the YAML of gsn2x (version 4), a program that checks and
//! draws arguments in the Goal Structuring Notation.
//!
//! Elements are a mapping from identifier to attributes. Texts are written as
//! double-quoted scalars (YAML 1.2, section 7.3.1), in which every character
//! can stand for itself or be escaped, so no text can end its scalar.

use super::node::{Argument, Node};

/// Characters after which gsn2x breaks a line.
const WRAP: usize = 45;

/// The argument as one YAML document.
///
/// Solutions carry two further attributes, which gsn2x shows on request
/// (`gsn2x -l=evidence -l=blake3`): the identifier of the evidence, and the
/// hash of all its inputs. Their links lead to its in-toto statement.
pub fn yaml(argument: &Argument) -> String {
    let mut text = format!(
        "module:\n  name: {}\n  brief: {}\n  charWrap: {WRAP}\n",
        quoted(&argument.name),
        quoted(&argument.brief)
    );
    for node in &argument.nodes {
        element(&mut text, node);
    }
    text
}

fn element(text: &mut String, node: &Node) {
    text.push_str(&format!("{}:\n", quoted(&node.id)));
    let mut put = |name: &str, value: &str| text.push_str(&format!("  {name}: {value}\n"));
    put("text", &quoted(&node.text));
    if !node.supported_by.is_empty() {
        put("supportedBy", &list(&node.supported_by));
    }
    if !node.in_context_of.is_empty() {
        put("inContextOf", &list(&node.in_context_of));
    }
    if node.undeveloped {
        put("undeveloped", "true");
    }
    if node.defeated {
        put("defeated", "true");
    }
    if let Some(target) = &node.challenges {
        put("challenges", &quoted(target));
    }
    if let Some(point) = &node.claim_point {
        let value = format!("{{{}: [{}]}}", quoted(&point.name), quoted(&point.at));
        put("acp", &value);
    }
    if let Some(citation) = &node.citation {
        put("url", &quoted(&super::statement_file(&citation.evidence)));
        put("evidence", &quoted(&citation.evidence));
        put("blake3", &quoted(&citation.inputs));
    }
}

fn list(ids: &[String]) -> String {
    let quoted: Vec<String> = ids.iter().map(|id| quoted(id)).collect();
    format!("[{}]", quoted.join(", "))
}

/// A double-quoted scalar.
fn quoted(text: &str) -> String {
    let mut scalar = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => scalar.push_str("\\\""),
            '\\' => scalar.push_str("\\\\"),
            '\n' => scalar.push_str("\\n"),
            '\t' => scalar.push_str("\\t"),
            '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}' => {
                scalar.push_str(&format!("\\u{:04x}", u32::from(c)));
            }
            c if c.is_control() => scalar.push_str(&format!("\\x{:02x}", u32::from(c))),
            c => scalar.push(c),
        }
    }
    scalar.push('"');
    scalar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_can_end_its_scalar() {
        assert_eq!(quoted("a \"b\" \\ c\n: #"), "\"a \\\"b\\\" \\\\ c\\n: #\"");
        assert_eq!(quoted("\u{1b}[31m\u{85}"), "\"\\x1b[31m\\x85\"");
    }
}
