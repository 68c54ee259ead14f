//! How the files of findings are called.

use std::collections::BTreeMap;
use study::Shows;

/// A file name that says what is shown; a number tells equal ones apart.
pub fn of_finding(shows: &Shows, taken: &mut BTreeMap<String, u64>) -> String {
    let words = match shows {
        Shows::Violated(id) => format!("violated-{id}"),
        Shows::FailureMode(id) => format!("failure-{id}"),
        Shows::Failed(kind) => kind.name().to_owned(),
        Shows::Unknown(step) => match &step.to {
            Some(to) => format!("unknown-{}", changes(&step.from, to)),
            None if step.from.is_empty() => "unknown-end-nothing".to_owned(),
            None => format!("unknown-end-{}", step.from),
        },
    };
    let safe = |c: char| {
        if c.is_ascii_alphanumeric() || c == '_' {
            c
        } else {
            '-'
        }
    };
    let mut name: String = words.chars().map(safe).take(80).collect();
    let count = taken.entry(name.clone()).or_insert(0);
    *count += 1;
    if *count > 1 {
        name = format!("{name}-{count}");
    }
    format!("{name}.toml")
}

/// What changes from one set of propositions to another.
fn changes(from: &str, to: &str) -> String {
    let (from, to): (Vec<&str>, Vec<&str>) = (
        from.split_whitespace().collect(),
        to.split_whitespace().collect(),
    );
    let gone = from
        .iter()
        .filter(|n| !to.contains(n))
        .map(|n| format!("not_{n}"));
    let come = to
        .iter()
        .filter(|n| !from.contains(n))
        .map(|n| (*n).to_owned());
    gone.chain(come).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use study::UnknownStep;

    #[test]
    fn names_say_what_changes_and_differ() {
        let step = |from: &str, to: Option<&str>| {
            Shows::Unknown(UnknownStep {
                exploration: "exploration.toml".into(),
                from: from.into(),
                to: to.map(str::to_owned),
            })
        };
        let mut taken = BTreeMap::new();
        let mut name = |shows: &Shows| of_finding(shows, &mut taken);
        let drop = step("activated in_hand", Some("activated"));
        assert_eq!(name(&drop), "unknown-not_in_hand.toml");
        let later = step("activated in_hand sensing", Some("activated sensing"));
        assert_eq!(name(&later), "unknown-not_in_hand-2.toml");
        assert_eq!(name(&step("activated", None)), "unknown-end-activated.toml");
        assert_eq!(name(&Shows::Violated("5/b".into())), "violated-5-b.toml");
    }
}
