//! The layout of `corroborate format`.

use crate::kind::Kind;
use crate::workspace::Workspace;
use ls_types::TextEdit;
use std::path::Path;

/// The edit that lays a document out anew; none if it is laid out already.
///
/// # Errors
/// Why it cannot be laid out: it does not parse, or is no text of the PRISM language.
pub fn edits(workspace: &Workspace, path: &Path) -> Result<Vec<TextEdit>, String> {
    let text = workspace.read(path).ok_or("there is no such text")?;
    let formatted = match workspace.kind(path) {
        Kind::Model => prism_lang::format_model(text.as_str()),
        Kind::Properties => prism_lang::format_properties(text.as_str()),
        Kind::Toml | Kind::Other => {
            return Err("only models and properties in the PRISM language are laid out".into());
        }
    };
    let formatted = formatted.map_err(|found| {
        let first = found.iter().find(|it| it.is_error());
        let first = first.map_or_else(String::new, |it| {
            let line = text.position(it.span.start).line + 1;
            format!(": line {line}: {}", it.message)
        });
        format!("a text with mistakes cannot be laid out{first}")
    })?;
    if formatted == text.as_str() {
        return Ok(Vec::new());
    }
    Ok(vec![TextEdit::new(text.whole(), formatted)])
}
