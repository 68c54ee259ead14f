//! Where blanks stand between tokens.

use super::Gap;
use super::items::{Item, Kind};
use crate::lexer::{Token, TokenKind};

/// What a token is to its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A name, a keyword, a number.
    Word,
    /// An operator with a blank on either side.
    Wide,
    /// An operator without blanks.
    Narrow,
    /// An operator before its operand.
    Prefix,
    /// A bracket that opens, with or without a blank before it where the tokens leave that open.
    Open { apart: bool },
    /// A bracket that closes.
    Close,
    /// The bracket that opens a formula of a property: blanks inside.
    WideOpen,
    /// The bracket that closes it.
    WideClose,
    /// `,` with a blank behind it, `:` behind a property's name, `?` for what is asked.
    Behind,
    /// `,` in an interval.
    Comma,
    /// `;`
    End,
    /// Any token of an item whose blanks stay: whether there is one before it.
    Kept { apart: bool },
}

/// The roles of an item's tokens, and what stands between updates.
pub(super) struct Roles {
    roles: Vec<Role>,
    /// The `+` between updates.
    pub(super) separators: Vec<bool>,
    /// The `=` behind the name of what is defined.
    pub(super) definition: Option<usize>,
}

impl Roles {
    pub(super) fn of(&self, token: usize) -> Role {
        self.roles[token]
    }
}

/// An open bracket.
struct Bracket {
    is_wide: bool,
    is_square: bool,
    /// Of an assignment.
    is_assignment: bool,
}

/// The roles of an item's tokens (counted from its first).
pub(super) fn roles(tokens: &[Token<'_>], gaps: &[Gap<'_>], item: &Item) -> Roles {
    let own = &tokens[item.first..item.end];
    let apart = |i: usize| !gaps[item.first + i].is_empty;
    if item.kind == Kind::AsWritten {
        let roles = (0..own.len()).map(|i| Role::Kept { apart: apart(i) });
        return Roles {
            roles: roles.collect(),
            separators: vec![false; own.len()],
            definition: None,
        };
    }
    let mut found = Roles {
        roles: Vec::with_capacity(own.len()),
        separators: vec![false; own.len()],
        definition: None,
    };
    let mut open: Vec<Bracket> = Vec::new();
    let defines = matches!(item.kind, Kind::Definition | Kind::Renaming);
    // Whether the token before ends an update.
    let mut ends_update = false;
    for (i, token) in own.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| &own[i]);
        let text = if token.kind == TokenKind::Symbol {
            token.text
        } else {
            ""
        };
        let was_update = std::mem::replace(&mut ends_update, false);
        let role = match text {
            "" => {
                ends_update = token.text == "true"
                    && before.is_some_and(|b| matches!(b.text, ":" | "->" | "+"));
                // `R{"time"}max=?` is one operator.
                let is_optimum = token.text.starts_with("min") || token.text.starts_with("max");
                if is_optimum && before.is_some_and(|b| b.text == "}") {
                    Role::Narrow
                } else {
                    Role::Word
                }
            }
            "(" | "[" | "{" => {
                let is_wide = text == "["
                    && item.kind == Kind::Property
                    && !before.is_some_and(|b| is_bounded(b));
                open.push(Bracket {
                    is_wide,
                    is_square: text == "[",
                    is_assignment: own.get(i + 1).is_some_and(|t| t.kind == TokenKind::Primed),
                });
                if is_wide {
                    Role::WideOpen
                } else {
                    Role::Open {
                        apart: before.is_some_and(|b| stands_apart(b, text, item.kind, apart(i))),
                    }
                }
            }
            ")" | "]" | "}" => {
                let bracket = open.pop();
                ends_update = bracket.as_ref().is_some_and(|b| b.is_assignment);
                if bracket.is_some_and(|b| b.is_wide) {
                    Role::WideClose
                } else {
                    Role::Close
                }
            }
            "," => {
                let is_interval = open.last().is_some_and(|b| b.is_square && !b.is_wide);
                if is_interval && item.kind != Kind::Renaming {
                    Role::Comma
                } else {
                    Role::Behind
                }
            }
            ";" => Role::End,
            "&" | "|" | "=>" | "<=>" | "->" => Role::Wide,
            "?" if before.is_some_and(|b| b.text == "=") => Role::Behind,
            ":" if item.kind == Kind::Property && i == 1 => Role::Behind,
            "?" | ":" => Role::Wide,
            "=" if defines && found.definition.is_none() && open.is_empty() => {
                found.definition = Some(i);
                Role::Wide
            }
            "+" if was_update => {
                found.separators[i] = true;
                Role::Wide
            }
            "!" => Role::Prefix,
            "-" if before.is_none_or(|b| !ends_operand(b)) => Role::Prefix,
            // As its author writes it; what stands before it may be the end of a line.
            "+" | "-" | "*" | "/" | "=" | "!=" | "<" | "<=" | ">" | ">="
                if i + 1 < own.len() && apart(i + 1) && own[i + 1].text != "?" =>
            {
                Role::Wide
            }
            _ => Role::Narrow,
        };
        found.roles.push(role);
    }
    found
}

/// Whether a blank stands between two neighbours.
pub(super) fn is_apart(before: Role, next: Role) -> bool {
    use Role::*;
    match (before, next) {
        (_, Kept { apart }) => apart,
        (_, End | Close | Behind | Comma | Narrow) => false,
        (WideOpen, _) | (_, WideClose | WideOpen | Wide) => true,
        (Open { .. } | Prefix | Narrow | Comma, _) => false,
        (Wide | Behind, _) => true,
        (_, Open { apart }) => apart,
        _ => true,
    }
}

/// Whether an operand ends with this token, so that `-` behind it is binary.
fn ends_operand(token: &Token<'_>) -> bool {
    match token.kind {
        TokenKind::Symbol => matches!(token.text, ")" | "]" | "}"),
        TokenKind::Keyword => matches!(token.text, "true" | "false"),
        _ => true,
    }
}

/// Whether `[` behind this token opens a bound in steps or time.
fn is_bounded(token: &Token<'_>) -> bool {
    token.kind == TokenKind::Keyword && matches!(token.text, "F" | "G" | "U" | "W" | "X" | "R")
}

/// Whether a blank stands between a token and the bracket behind it, where no operator decides that.
fn stands_apart(before: &Token<'_>, bracket: &str, kind: Kind, is_written_apart: bool) -> bool {
    match (bracket, before.kind) {
        ("(", TokenKind::Keyword) => !matches!(before.text, "min" | "max" | "func" | "filter"),
        // A call; in a property perhaps a bound that is a constant: `F<=T (x=1)`.
        ("(", TokenKind::Name) => kind == Kind::Property && is_written_apart,
        ("[", TokenKind::Keyword) => !is_bounded(before),
        ("{", TokenKind::Keyword) => before.text != "R",
        ("{", TokenKind::Symbol) => before.text != "}",
        _ => true,
    }
}
