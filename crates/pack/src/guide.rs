//! The page that says how a pack is verified without this tool.

/// The page; with the key that signed, if one did.
pub(crate) fn page(signer: Option<&str>) -> String {
    let template = include_str!("VERIFY.md");
    let kept = match signer {
        Some(_) => ["signed", "unsigned"],
        None => ["unsigned", "signed"],
    };
    let text = without(template, kept[1]);
    let text = text.replace(&format!("<!-- {} -->\n", kept[0]), "");
    let text = text.replace(&format!("<!-- end {} -->\n", kept[0]), "");
    text.replace("{KEY}", signer.unwrap_or_default())
}

/// A text without the pieces between these marks.
fn without(text: &str, mark: &str) -> String {
    let (begin, end) = (
        format!("<!-- {mark} -->\n"),
        format!("<!-- end {mark} -->\n"),
    );
    let mut kept = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once(&begin) {
        kept.push_str(before);
        rest = behind.split_once(&end).map_or("", |(_, after)| after);
    }
    kept + rest
}
