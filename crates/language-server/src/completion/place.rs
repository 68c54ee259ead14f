//! Where in a text of the PRISM language something is to be written.

/// Where in a text of the PRISM language something is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// In a comment, or where a new name is invented.
    Nowhere,
    /// Between declarations of a model.
    TopLevel,
    /// Between the commands of a module.
    Module,
    /// In quotes; of a reward structure behind a brace.
    Quotes { of_rewards: bool },
    /// Between the brackets with which a command begins.
    Action,
    /// In an expression.
    Expression,
}

/// The text without its comments and without what stands in quotes, and whether its end is in either.
pub(super) fn plain(before: &str) -> (String, bool, bool) {
    let mut shown = String::with_capacity(before.len());
    let (mut in_comment, mut in_quotes) = (false, false);
    let mut characters = before.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\n' => {
                (in_comment, in_quotes) = (false, false);
                shown.push('\n');
            }
            _ if in_comment => {}
            '"' => {
                in_quotes = !in_quotes;
                shown.push('"');
            }
            '/' if !in_quotes && characters.peek() == Some(&'/') => in_comment = true,
            _ if in_quotes => {}
            other => shown.push(other),
        }
    }
    (shown, in_comment, in_quotes)
}

pub(super) fn place_in_model(before: &str) -> Place {
    let (shown, in_comment, in_quotes) = plain(before);
    if in_comment {
        return Place::Nowhere;
    }
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let rest = shown.trim_end_matches(is_part);
    if in_quotes {
        return in_quotes_of(&shown);
    }
    let words: Vec<&str> = rest
        .split(|c| !is_part(c))
        .filter(|it| !it.is_empty())
        .collect();
    let last_of = |open: &str, close: &str| {
        let open = words.iter().rposition(|it| *it == open);
        let close = words.iter().rposition(|it| *it == close);
        open.is_some() && open > close
    };
    let statement = rest.rsplit(';').next().unwrap_or("");
    let in_module = last_of("module", "endmodule");
    let trimmed = statement.trim();
    if in_module && trimmed.ends_with('[') && !trimmed.contains("->") && trimmed.len() == 1 {
        return Place::Action;
    }
    if in_module {
        // Behind the word `module` comes the new name, and behind that, on a line of its own, the first declaration.
        let mut parts = trimmed.split_whitespace();
        let is_header = parts.by_ref().any(|it| it == "module");
        return match (trimmed.is_empty(), is_header, parts.count()) {
            (true, ..) => Place::Module,
            (_, true, 1) if rest.ends_with('\n') => Place::Module,
            (_, true, 0 | 1) => Place::Nowhere,
            _ => Place::Expression,
        };
    }
    let of_type = [
        "dtmc",
        "ctmc",
        "mdp",
        "pta",
        "endmodule",
        "endrewards",
        "endinit",
        "endsystem",
    ];
    let is_top = trimmed.is_empty() || of_type.iter().any(|it| trimmed.ends_with(it));
    let invents = [
        "const", "int", "double", "bool", "formula", "label", "global", "module", "rewards",
    ];
    let last = trimmed.split_whitespace().next_back().unwrap_or("");
    let invents = invents.contains(&last);
    match (is_top, invents) {
        (true, _) => Place::TopLevel,
        (_, true) => Place::Nowhere,
        _ => Place::Expression,
    }
}

pub(super) fn in_quotes_of(shown: &str) -> Place {
    let before = shown.trim_end_matches('"').trim_end();
    let invents =
        before.ends_with("label") || before.ends_with("rewards") || before.ends_with("system");
    match invents {
        true => Place::Nowhere,
        false => Place::Quotes {
            of_rewards: before.ends_with('{')
                && before
                    .trim_end_matches('{')
                    .trim_end()
                    .ends_with(['R', '/']),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_models_are_told_apart() {
        for (before, place) in [
            ("", Place::TopLevel),
            ("dtmc\nco", Place::TopLevel),
            ("dtmc\nconst ", Place::Nowhere),
            ("dtmc\nconst int n = ", Place::Expression),
            ("dtmc // const int n = ", Place::Nowhere),
            ("dtmc\nmodule m\n", Place::Module),
            ("dtmc\nmodule m\n x : bool;\n [", Place::Action),
            ("dtmc\nmodule m\n x : bool;\n [a] x & ", Place::Expression),
            (
                "dtmc\nmodule m\n x : bool;\n [a] x -> (x'=",
                Place::Expression,
            ),
            ("dtmc\nmodule m\n x : [0..", Place::Expression),
            ("dtmc\nmodule m endmodule\n", Place::TopLevel),
            ("dtmc label \"", Place::Nowhere),
        ] {
            assert_eq!(place_in_model(before), place, "{before}");
        }
    }
}
