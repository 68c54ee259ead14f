//! Which tokens belong together on a line.

use crate::ast::PropertyFile;
use crate::lexer::{Token, TokenKind};

/// What an item is, as far as its layout depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `module m`, `rewards "r"`: what follows is indented.
    Opening,
    /// `endmodule`, `endrewards`.
    Closing,
    /// A declaration with a name and `=`.
    Definition,
    /// A renamed module.
    Renaming,
    /// `system ... endsystem`, and other texts in which several symbols form one operator: only the width of
    /// blanks is changed.
    AsWritten,
    /// A property, in which brackets enclose formulas.
    Property,
    /// A command, a variable, an item of a reward structure, `init`, the model's type.
    Other,
}

/// Tokens that belong together: `first..end`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) first: usize,
    pub(super) end: usize,
    /// How many blocks it stands in.
    pub(super) depth: usize,
    pub(super) kind: Kind,
}

/// The items of a model without syntax errors.
pub(super) fn of_model(tokens: &[Token<'_>]) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let (mut first, mut depth) = (0, 0);
    while tokens[first].kind != TokenKind::End {
        let (end, kind) = model_item(tokens, first);
        if kind == Kind::Closing {
            depth = 0;
        }
        items.push(Item {
            first,
            end,
            depth,
            kind,
        });
        if kind == Kind::Opening {
            depth = 1;
        }
        first = end;
    }
    items
}

/// The end and the kind of the item that starts here.
fn model_item(tokens: &[Token<'_>], first: usize) -> (usize, Kind) {
    let is_keyword = tokens[first].kind == TokenKind::Keyword;
    let word = if is_keyword { tokens[first].text } else { "" };
    match word {
        "dtmc" | "probabilistic" | "mdp" | "nondeterministic" | "ctmc" | "stochastic" | "pta"
        | "pomdp" | "popta" => (first + 1, Kind::Other),
        "module" if tokens[first + 2].text == "=" => {
            (behind(tokens, first, "endmodule"), Kind::Renaming)
        }
        "module" => (first + 2, Kind::Opening),
        "rewards" => {
            let is_named = tokens[first + 1].kind == TokenKind::Quoted;
            (first + 1 + usize::from(is_named), Kind::Opening)
        }
        "endmodule" | "endrewards" => (first + 1, Kind::Closing),
        "init" => (behind(tokens, first, "endinit"), Kind::Other),
        "invariant" => (behind(tokens, first, "endinvariant"), Kind::Other),
        "system" => (behind(tokens, first, "endsystem"), Kind::AsWritten),
        "observables" => (behind(tokens, first, "endobservables"), Kind::Other),
        "const" | "rate" | "prob" | "formula" | "label" | "observable" => {
            (behind(tokens, first, ";"), Kind::Definition)
        }
        _ => (behind(tokens, first, ";"), Kind::Other),
    }
}

/// The place behind the next token with this text (or the end).
fn behind(tokens: &[Token<'_>], first: usize, text: &str) -> usize {
    let last = tokens.len() - 1;
    (first..last)
        .find(|&i| tokens[i].text == text && tokens[i].kind != TokenKind::Quoted)
        .map_or(last, |i| i + 1)
}

/// The items of a property file without syntax errors.
pub(super) fn of_properties(file: &PropertyFile, tokens: &[Token<'_>]) -> Vec<Item> {
    let definitions = (file.constants.iter().map(|constant| constant.span))
        .chain(file.formulas.iter().map(|formula| formula.span))
        .chain(file.labels.iter().map(|label| label.span))
        .map(|span| (span.start, Kind::Definition));
    let properties = file.properties.iter().map(|property| {
        let start = property
            .name
            .as_ref()
            .map_or(property.span, |name| name.span);
        (start.start, Kind::Property)
    });
    let mut starts: Vec<(usize, Kind)> = definitions.chain(properties).collect();
    starts.sort_unstable_by_key(|&(start, _)| start);
    let last = tokens.len() - 1;
    let place = |start: usize| tokens.partition_point(|token| token.span.start < start);
    let ends = (starts.iter().skip(1).map(|&(start, _)| place(start))).chain([last]);
    starts
        .iter()
        .zip(ends)
        .map(|(&(start, kind), end)| {
            let first = place(start);
            let is_doubled = (first + 1..end).any(|i| {
                matches!(tokens[i].text, "<" | "[" | "|")
                    && tokens[i].kind == TokenKind::Symbol
                    && tokens[i - 1].text == tokens[i].text
                    && tokens[i - 1].span.end == tokens[i].span.start
            });
            Item {
                first,
                end,
                depth: 0,
                kind: if is_doubled { Kind::AsWritten } else { kind },
            }
        })
        .collect()
}
