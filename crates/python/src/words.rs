//! What a remedy says to a caller of Python, who has arguments of functions and no options of a command line.
//!
//! The libraries write remedies in the words of the command, since they do not know who is spoken to. Here an option becomes the
//! argument by which a function of the package takes the same: `--out FOLDER` is `out=FOLDER`, `--trust` is `trust=True`,
//! `-const p=...` is `constants={"p": ...}`; `` `corroborate run STUDY` `` is `` `Study("STUDY").run()` ``. Another whole command
//! (`` `corroborate inspect FILE` ``) stays, since the package brings it, and so does an option that no function has.

/// Options whose argument in Python is `True`.
const FLAGS: [&str; 6] = [
    "certify",
    "fair",
    "partial",
    "trust",
    "with-recordings",
    "witness",
];

/// Options with a value, and what the argument is called where that is another name.
const VALUES: [(&str, &str); 11] = [
    ("key", "key"),
    ("map", "map"),
    ("max-states", "max_states"),
    ("method", "method"),
    ("only", "only"),
    ("out", "out"),
    ("pdf", "pdf"),
    ("precision", "precision"),
    ("sbom", "sboms"),
    ("timeout", "timeout"),
    ("to", "to"),
];

/// Where remedies say that an option is one, which an argument is not.
const OF_THE_COMMAND: &str = " on the command line";

/// A remedy in the words of Python.
pub(crate) fn in_python(remedy: &str) -> String {
    // Every other part stands between backticks.
    let parts = remedy.split('`').enumerate().map(|(place, part)| {
        let is_code = place % 2 == 1;
        match is_code && part.starts_with("corroborate ") {
            true => of_study(part).unwrap_or_else(|| part.to_owned()),
            false => translated(part, is_code),
        }
    });
    parts.collect::<Vec<_>>().join("`")
}

/// A command on a study as the method that does the same; nothing for others, and for options that it has not.
fn of_study(command: &str) -> Option<String> {
    let words: Vec<&str> = command.split(' ').collect();
    let method = words.get(1).filter(|it| ["run", "plan"].contains(it))?;
    match words.get(2..)? {
        [] => Some(format!("Study.{method}()")),
        [study] => Some(format!("Study({study:?}).{method}()")),
        [study, "--out", out] => Some(format!("Study({study:?}, out={out:?}).{method}()")),
        _ => None,
    }
}

fn translated(part: &str, is_code: bool) -> String {
    let of_check = part.strip_prefix("check ").filter(|_| is_code);
    if let Some(options) = of_check.filter(|it| it.starts_with('-')) {
        return format!("Model.check({})", options_translated(options));
    }
    options_translated(part)
}

fn options_translated(part: &str) -> String {
    let (mut found, mut rest) = (String::new(), part);
    while let Some(at) = rest.find('-') {
        let (before, option) = rest.split_at(at);
        found.push_str(before);
        let is_first = before.is_empty() || before.ends_with([' ', '(']);
        match is_first.then(|| argument(option)).flatten() {
            Some((argument, behind)) => {
                found.push_str(&argument);
                rest = behind.strip_prefix(OF_THE_COMMAND).unwrap_or(behind);
            }
            None => {
                found.push('-');
                rest = &option[1..];
            }
        }
    }
    found + rest
}

/// The argument for the option with which a text begins, and what follows; nothing where Python has none.
fn argument(text: &str) -> Option<(String, &str)> {
    if let Some(constant) = text.strip_prefix("-const ") {
        let (name, value) = constant.split_once('=')?;
        let ends = value.find([' ', ';', ',']).unwrap_or(value.len());
        let (value, behind) = value.split_at(ends);
        return Some((format!("constants={{\"{name}\": {value}}}"), behind));
    }
    let named = text.strip_prefix("--")?;
    let ends = named.find(|c: char| !c.is_ascii_lowercase() && c != '-');
    let (name, behind) = named.split_at(ends.unwrap_or(named.len()));
    if FLAGS.contains(&name) {
        return Some((format!("{}=True", name.replace('-', "_")), behind));
    }
    let (_, keyword) = VALUES.iter().find(|(option, _)| *option == name)?;
    // `FILE`, `FOLDER`: what the value is.
    let word = behind.strip_prefix(' ').unwrap_or_default();
    let length = word.find(|c: char| !c.is_ascii_uppercase());
    let word = &word[..length.unwrap_or(word.len())];
    Some(match word.len() {
        0 | 1 => (format!("{keyword}=..."), behind),
        length => (format!("{keyword}={word}"), &behind[1 + length..]),
    })
}

#[cfg(test)]
mod tests {
    use super::in_python;

    #[test]
    fn an_option_is_the_argument_by_which_a_function_takes_the_same() {
        for (remedy, expected) in [
            (
                "Give it one here, or from outside with `-const x=...`.",
                "Give it one here, or from outside with `constants={\"x\": ...}`.",
            ),
            (
                "say in the topic map (topics.toml, or --map) where the signal is",
                "say in the topic map (topics.toml, or map=...) where the signal is",
            ),
            (
                "judge what there is all the same (--partial on the command line)",
                "judge what there is all the same (partial=True)",
            ),
            (
                "give it more time (`check --timeout`), or make the model smaller",
                "give it more time (`Model.check(timeout=...)`), or make the model smaller",
            ),
            (
                "`check` takes more with --max-states",
                "`check` takes more with max_states=...",
            ),
            (
                "`--out FOLDER` puts results elsewhere, `--sbom FILE` adds a bill",
                "`out=FOLDER` puts results elsewhere, `sboms=FILE` adds a bill",
            ),
            (
                "run `corroborate run my/one --out r` first; `corroborate plan my/one` says what changed",
                "run `Study(\"my/one\", out=\"r\").run()` first; `Study(\"my/one\").plan()` says what changed",
            ),
            (
                "run it as a whole: `corroborate run`",
                "run it as a whole: `Study.run()`",
            ),
            (
                "leave recordings out (without --with-recordings)",
                "leave recordings out (without with_recordings=True)",
            ),
        ] {
            assert_eq!(in_python(remedy), expected);
        }
    }

    #[test]
    fn commands_and_what_python_does_not_have_stay() {
        for same in [
            "name folders that `corroborate run STUDY --shard K/N --out FOLDER` wrote",
            "leave out the choice of a physics (--physics on the command line)",
            "a well-known name, 3 - 2, --outer, and - alone",
            "an unclosed `corroborate run --out",
            "",
        ] {
            assert_eq!(in_python(same), same);
        }
    }
}
