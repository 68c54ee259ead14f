//! Texts with `${expressions}` and `$(substitutions)` in them.

/// A part of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part<'t> {
    /// As it is.
    Plain(&'t str),
    /// Between `${` and `}`.
    Expression(&'t str),
    /// Between `$(` and `)`.
    Substitution(&'t str),
}

/// The parts of a text. `$$` before `{` or `(` is one `$`, and what follows it is as it is.
pub(super) fn parts(text: &str) -> Result<Vec<Part<'_>>, String> {
    let mut parts = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let Some(at) = rest.find('$') else {
            parts.push(Part::Plain(rest));
            break;
        };
        if at > 0 {
            parts.push(Part::Plain(&rest[..at]));
            rest = &rest[at..];
            continue;
        }
        let dollars = rest.len() - rest.trim_start_matches('$').len();
        let behind = &rest[dollars..];
        if dollars > 1 && behind.starts_with(['{', '(']) {
            // One dollar and the bracket are dropped as one.
            parts.push(Part::Plain(&rest[1..=dollars]));
            rest = &rest[dollars + 1..];
            continue;
        }
        let (close, is_expression) = match behind.chars().next() {
            Some('{') if dollars == 1 => ('}', true),
            Some('(') if dollars == 1 => (')', false),
            _ => {
                // A dollar by itself, with what is behind it up to the next.
                let end = behind.find('$').map_or(rest.len(), |at| dollars + at);
                parts.push(Part::Plain(&rest[..end]));
                rest = &rest[end..];
                continue;
            }
        };
        let Some(end) = rest.find(close) else {
            return Err(format!("`{}` is not closed by `{close}`", &rest[..2]));
        };
        let inner = &rest[2..end];
        parts.push(match is_expression {
            true => Part::Expression(inner),
            false => Part::Substitution(inner),
        });
        rest = &rest[end + 1..];
    }
    Ok(parts)
}

/// A parameter of a macro.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Parameter {
    /// Its name; of blocks with `*` or `**` before it.
    pub name: String,
    /// Whether it is that of the caller, where the caller has one (`^`).
    pub forwards: bool,
    /// What it is otherwise.
    pub default: Option<String>,
}

/// The parameters in the attribute `params` of a macro.
pub(super) fn parameters(text: &str) -> Vec<Parameter> {
    let mut found = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let (parameter, behind) = parameter(rest);
        found.push(parameter);
        rest = behind.trim_start();
    }
    found
}

fn parameter(text: &str) -> (Parameter, &str) {
    let end = text.find(|it: char| it.is_whitespace() || it == ':' || it == '=');
    let (name, behind) = text.split_at(end.unwrap_or(text.len()));
    let sign = behind.trim_start();
    let value = sign.strip_prefix(":=").or_else(|| sign.strip_prefix('='));
    let Some(value) = value.map(str::trim_start).filter(|_| !name.is_empty()) else {
        // Without a default it is all up to the next blank.
        let end = text.find(char::is_whitespace).unwrap_or(text.len());
        let (name, behind) = text.split_at(end);
        let parameter = Parameter {
            name: name.to_owned(),
            forwards: false,
            default: None,
        };
        return (parameter, behind);
    };
    let (forwards, value) = match value.strip_prefix('^') {
        Some(value) => (true, value.strip_prefix('|').unwrap_or(value)),
        None => (false, value),
    };
    let length = default_length(value);
    let (default, behind) = value.split_at(length);
    let parameter = Parameter {
        name: name.to_owned(),
        forwards,
        default: (!default.is_empty()).then(|| default.to_owned()),
    };
    (parameter, behind)
}

/// How long a default is: an expression, a substitution, or words and texts in quotes up to a blank.
fn default_length(text: &str) -> usize {
    for (open, close) in [("${", '}'), ("$(", ')')] {
        if let Some(end) = text.strip_prefix(open).and_then(|rest| rest.find(close)) {
            let length = open.len() + end + 1;
            if text[length..]
                .chars()
                .next()
                .is_none_or(char::is_whitespace)
            {
                return length;
            }
        }
    }
    let mut quote = None;
    for (place, character) in text.char_indices() {
        match (quote, character) {
            (None, '\'' | '"') => quote = Some(character),
            (Some(open), it) if open == it => quote = None,
            (None, it) if it.is_whitespace() => return place,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_cut_where_the_python_program_does() {
        use Part::{Expression, Plain, Substitution};
        for (text, expected) in [
            ("", vec![]),
            ("a", vec![Plain("a")]),
            ("${x}", vec![Expression("x")]),
            ("a${x}b", vec![Plain("a"), Expression("x"), Plain("b")]),
            ("$(arg x)/y", vec![Substitution("arg x"), Plain("/y")]),
            ("$${x}", vec![Plain("${"), Plain("x}")]),
            ("$$$(x)", vec![Plain("$$("), Plain("x)")]),
            ("5$", vec![Plain("5"), Plain("$")]),
            ("$5 ${x}", vec![Plain("$5 "), Expression("x")]),
        ] {
            assert_eq!(parts(text), Ok(expected), "{text}");
        }
        assert!(parts("${x").is_err() && parts("$(x").is_err());
    }

    #[test]
    fn parameters_have_defaults_in_every_form() {
        let text =
            "a b:=1  c:='x y' *origin **content d:=^ e:=^|${pi/2} f=$(arg g) h:=${x + 1} i:=''";
        let found = parameters(text);
        let all: Vec<(&str, bool, Option<&str>)> = found
            .iter()
            .map(|it| (it.name.as_str(), it.forwards, it.default.as_deref()))
            .collect();
        let expected = [
            ("a", false, None),
            ("b", false, Some("1")),
            ("c", false, Some("'x y'")),
            ("*origin", false, None),
            ("**content", false, None),
            ("d", true, None),
            ("e", true, Some("${pi/2}")),
            ("f", false, Some("$(arg g)")),
            ("h", false, Some("${x + 1}")),
            ("i", false, Some("''")),
        ];
        assert_eq!(all, expected);
    }
}
