//! Models of which most was written once.
//!
//! # Definition
//! The texts of two models are held against each other statement by statement (up to a `;`, of XML up to a `>`), without
//! comments and blanks, each as often as it stands there. Two pieces that are computed from models have a text in common if
//! more than half of the statements of the shorter model stand in the other, and there are at least [`FEWEST`] of them: a
//! copy, or a revision. What the one has wrong the other has, too, so that they have one voice against all others
//! (`evidence::voices`) and do not agree independently.
//!
//! # Assumes
//! Two authors do not write most statements alike.
//!
//! # Guarantee
//! None for models under other names: a copy whose variables were renamed is not found. That two people write most
//! statements alike, with the same names and numbers, has no probability that could be computed; where it happened, the
//! ledger's `independent` says so.

use super::constants;
use diagnostic::Problem;
use evidence::{AssetRole, CommonText, Evidence};
use std::collections::BTreeMap;
use study::Study;

/// So many statements in common tell more than that both are models of the same kind.
const FEWEST: u64 = 4;

/// A model's statements, each with how often it is there.
type Statements = BTreeMap<String, u64>;

/// Fills in the texts that models have in common with earlier ones, but those that the ledger calls independent.
pub(super) fn fill(study: &Study, evidence: &mut [Evidence]) -> Result<(), Problem> {
    let mut models: Vec<(usize, String, Statements)> = Vec::new();
    for (place, piece) in evidence.iter().enumerate() {
        if !piece.technique.is_of_model() {
            continue;
        }
        let files = piece.assets.iter();
        for asset in files.filter(|asset| asset.role == AssetRole::SystemModel) {
            let statements = statements(&constants::text(study, &asset.path)?);
            models.push((place, asset.path.clone(), statements));
        }
    }
    let is_independent = |one: &str, other: &str| {
        let entry = study.ledger.iter().find(|entry| entry.id == one);
        entry.is_some_and(|entry| entry.independent.reason(other).is_some())
    };
    let mut found = Vec::new();
    for (number, (later, path, ours)) in models.iter().enumerate() {
        for (earlier, other, theirs) in &models[..number] {
            let [id, with] = [later, earlier].map(|place| evidence[*place].id.as_str());
            let is_settled = id == with || is_independent(id, with) || is_independent(with, id);
            let same = in_common(ours, theirs);
            let statements = all(ours).min(all(theirs));
            if !is_settled && same >= FEWEST && 2 * same > statements {
                let text = CommonText {
                    with: with.to_owned(),
                    files: [other.clone(), path.clone()],
                    same,
                    statements,
                };
                found.push((*later, text));
            }
        }
    }
    for (place, text) in found {
        evidence[place].common_texts.push(text);
    }
    Ok(())
}

fn all(statements: &Statements) -> u64 {
    statements.values().sum()
}

fn in_common(one: &Statements, other: &Statements) -> u64 {
    let times = |(statement, times): (&String, &u64)| {
        let theirs = other.get(statement).copied().unwrap_or(0);
        theirs.min(*times)
    };
    one.iter().map(times).sum()
}

/// The statements of a text.
fn statements(text: &str) -> Statements {
    let text = without_comments(text);
    let end = if text.trim_start().starts_with('<') {
        '>'
    } else {
        ';'
    };
    let mut found = Statements::new();
    for statement in text.split(end) {
        let statement: String = statement.split_whitespace().collect();
        if statement.chars().any(char::is_alphabetic) {
            *found.entry(statement).or_insert(0) += 1;
        }
    }
    found
}

/// A text without `// ...`, `/* ... */` and `<!-- ... -->`.
fn without_comments(text: &str) -> String {
    let mut rest = text;
    let mut kept = String::with_capacity(text.len());
    let kinds = [("//", "\n"), ("/*", "*/"), ("<!--", "-->")];
    loop {
        let next = kinds
            .iter()
            .filter_map(|kind| Some((rest.find(kind.0)?, kind)))
            .min();
        let Some((at, (open, close))) = next else {
            kept.push_str(rest);
            return kept;
        };
        kept.push_str(&rest[..at]);
        kept.push(' ');
        let inside = &rest[at + open.len()..];
        rest = match inside.find(close) {
            Some(end) => &inside[end + close.len()..],
            None => "",
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_blanks_and_the_order_make_no_other_statements() {
        let one =
            statements("dtmc\nmodule m // here\n s : [0..2];\n [] s=0 -> 0.5:(s'=1)+0.5:(s'=2);");
        let other = statements(
            "/* a; b */ dtmc module m s:[0..2];[]s=0->0.5:(s'=1) + 0.5:(s'=2); // end; of it",
        );
        assert_eq!(one, other);
        assert_eq!(all(&one), 2);
        let revised =
            statements("dtmc module m s : [0..2]; [] s=0 -> 0.4:(s'=1) + 0.6:(s'=2); s; s;");
        assert_eq!(in_common(&one, &revised), 1);
        assert_eq!(all(&revised), 4);
        let tree = statements("<!-- > --><a name=\"x\">\n<b/></a>");
        assert_eq!(all(&tree), 3);
    }
}
