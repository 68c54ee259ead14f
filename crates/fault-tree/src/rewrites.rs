//! Single changes of a tree's structure, made on its text.
//!
//! # Definition
//! Of each gate, one at a time:
//!
//! * its kind becomes another: `and`, `or` and "at least k of n" the next one in the order of how many have to occur (`or`, 2 of n,
//!   ..., `and`), and `or` and `and` each other; `not`, `nand`, `nor` and `xor` lose their negation or change as `and` and `or` do;
//! * one of its arguments belongs to another gate, or a basic event that no gate has is one of its arguments;
//! * one of its arguments is left out, if another gate has it, too: what nothing else has was written to be used.
//!
//! What these make is a text of the same format. One that cannot be read, such as one with a cycle, is the caller's to leave out;
//! so is one that makes no event more or less probable.
//!
//! # Guarantee
//! All else of the text stays as it is written. The order is that of the text, changes of kind first.

use std::ops::Range;

use crate::galileo::written_in_galileo;
use crate::open_psa::written_in_open_psa;
use crate::tree::Connective;

/// Changes of one text, at most.
const MOST: usize = 500;

/// What a change is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RewriteKind {
    /// The kind of a gate.
    Gate,
    /// An argument of a gate, which belongs to another one, or to one that does not have it.
    Argument,
}

/// A change of a tree's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rewrite {
    /// What it is of.
    pub kind: RewriteKind,
    /// The gate's name; that of the gate that it stands in, for a formula within one.
    pub gate: String,
    /// Where the gate's kind is written, or its argument, in bytes of the text.
    pub place: usize,
    /// What is done, in one clause.
    pub what: String,
    /// The text with the change.
    pub text: String,
}

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Galileo's.
    Galileo,
    /// That of the Open-PSA initiative.
    OpenPsa,
}

/// A gate as it is written.
#[derive(Debug)]
pub(crate) struct WrittenGate {
    pub name: String,
    pub connective: Connective,
    /// Where its kind stands: one place in Galileo's format, an opening and a closing tag in the other.
    pub words: Vec<Range<usize>>,
    /// Its arguments, with their names if they are no formulas.
    pub arguments: Vec<(Option<String>, Range<usize>)>,
}

/// What of a text is needed to change its structure.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub gates: Vec<WrittenGate>,
    /// The names of the basic events.
    pub events: Vec<String>,
}

impl Format {
    /// How a kind of gate with so many arguments is written, for each of its places.
    fn words(self, connective: Connective, count: usize) -> Vec<String> {
        let word = match connective {
            Connective::And => "and",
            Connective::Or => "or",
            Connective::Not => "not",
            Connective::Xor => "xor",
            Connective::Nand => "nand",
            Connective::Nor => "nor",
            Connective::AtLeast(least) => {
                return match self {
                    Self::Galileo => vec![format!("{least}of{count}")],
                    Self::OpenPsa => vec![
                        format!("<atleast min=\"{least}\">"),
                        "</atleast>".to_owned(),
                    ],
                };
            }
        };
        match self {
            Self::Galileo => vec![word.to_owned()],
            Self::OpenPsa => vec![format!("<{word}>"), format!("</{word}>")],
        }
    }
}

/// All single changes of a text's structure.
#[must_use]
pub fn rewrites(text: &str, format: Format) -> Vec<Rewrite> {
    let written = match format {
        Format::Galileo => written_in_galileo(text),
        Format::OpenPsa => written_in_open_psa(text),
    };
    let gates = written.gates;
    let uses = |name: &str| {
        let all = gates.iter().flat_map(|it| &it.arguments);
        all.filter(|(own, _)| own.as_deref() == Some(name)).count()
    };
    let mut found: Vec<Rewrite> = Vec::new();
    for gate in &gates {
        let others = other_kinds(gate.connective, gate.arguments.len());
        found.extend(others.into_iter().map(|it| of_kind(text, format, gate, it)));
    }
    for name in written.events.iter().filter(|name| uses(name) == 0) {
        found.extend(gates.iter().filter_map(|it| with(text, format, it, name)));
    }
    for (at, gate) in gates.iter().enumerate() {
        for (place, (name, _)) in gate.arguments.iter().enumerate() {
            let Some(name) = name.as_deref().filter(|_| gate.arguments.len() > 1) else {
                continue;
            };
            let others = gates.iter().enumerate().filter(|(other, it)| {
                let has_it = it
                    .arguments
                    .iter()
                    .any(|(own, _)| own.as_deref() == Some(name));
                *other != at && !has_it && it.name != name
            });
            found.extend(
                others.filter_map(|(_, other)| moved(text, format, (gate, place, name), other)),
            );
        }
    }
    for gate in &gates {
        for (place, (name, _)) in gate.arguments.iter().enumerate() {
            if name.as_deref().is_some_and(|name| uses(name) > 1) {
                found.extend(without(text, format, gate, place));
            }
        }
    }
    found.truncate(MOST);
    found
}

/// The kinds that a gate may have been meant to be.
fn other_kinds(connective: Connective, count: usize) -> Vec<Connective> {
    let of_least = |least: usize| match least {
        1 => Connective::Or,
        all if all == count => Connective::And,
        least => Connective::AtLeast(least),
    };
    let next = |least: usize| {
        let mut near: Vec<usize> = [least.checked_sub(1), least.checked_add(1)]
            .into_iter()
            .flatten()
            .filter(|it| (1..=count).contains(it))
            .collect();
        // However many there are between them, these are mixed up most.
        if least == 1 || least == count {
            near.insert(0, count + 1 - least);
        }
        near.dedup();
        near
    };
    // With one argument all of them say the same.
    if count < 2 && !matches!(connective, Connective::Not) {
        return match connective {
            Connective::Nand | Connective::Nor => vec![Connective::Or],
            _ => Vec::new(),
        };
    }
    match connective {
        Connective::And => next(count).into_iter().map(of_least).collect(),
        Connective::Or => next(1).into_iter().map(of_least).collect(),
        Connective::AtLeast(least) => next(least).into_iter().map(of_least).collect(),
        Connective::Not => vec![Connective::Or],
        Connective::Xor => vec![Connective::Or, Connective::And],
        Connective::Nand => vec![Connective::And, Connective::Nor],
        Connective::Nor => vec![Connective::Or, Connective::Nand],
    }
}

/// Several places of a text replaced.
fn replaced(text: &str, mut places: Vec<(Range<usize>, String)>) -> String {
    places.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    let mut changed = text.to_owned();
    for (place, new) in places {
        changed.replace_range(place, &new);
    }
    changed
}

fn of_kind(text: &str, format: Format, gate: &WrittenGate, new: Connective) -> Rewrite {
    let count = gate.arguments.len();
    // In words as a person would say it, whatever the format.
    let said = |it: Connective| Format::Galileo.words(it, count).concat();
    let words = gate.words.iter().cloned().zip(format.words(new, count));
    Rewrite {
        kind: RewriteKind::Gate,
        gate: gate.name.clone(),
        place: gate.words.first().map_or(0, |it| it.start),
        what: format!(
            "the gate `{}` is `{}` in place of `{}`",
            gate.name,
            said(new),
            said(gate.connective)
        ),
        text: replaced(text, words.collect()),
    }
}

/// The kind of a gate with one argument more or less; as many of them have to occur as before, if there are so many.
fn counted(connective: Connective, count: usize) -> Option<Connective> {
    match connective {
        Connective::AtLeast(least) if least > count => None,
        Connective::Xor | Connective::Not => None,
        same => Some(same),
    }
}

/// The places to be replaced so that an argument is gone.
fn taken_out(
    text: &str,
    format: Format,
    gate: &WrittenGate,
    place: usize,
) -> Option<Vec<(Range<usize>, String)>> {
    let count = gate.arguments.len().checked_sub(1).filter(|it| *it > 0)?;
    let connective = counted(gate.connective, count)?;
    let own = gate.arguments.get(place)?.1.clone();
    // With the blanks before it; not with a line's end, since what stands before that may be a comment.
    let before = &text[..own.start];
    let kept = before.trim_end().len();
    let start = match before[kept..].contains('\n') {
        true => own.start,
        false => kept,
    };
    let mut places = vec![(start..own.end, String::new())];
    if matches!(connective, Connective::AtLeast(_)) {
        places.extend(
            gate.words
                .iter()
                .cloned()
                .zip(format.words(connective, count)),
        );
    }
    Some(places)
}

fn without(text: &str, format: Format, gate: &WrittenGate, place: usize) -> Option<Rewrite> {
    let (name, own) = gate.arguments.get(place)?;
    let places = taken_out(text, format, gate, place)?;
    let name = name.as_deref().unwrap_or("a formula");
    Some(Rewrite {
        kind: RewriteKind::Argument,
        gate: gate.name.clone(),
        place: own.start,
        what: format!("the gate `{}` is without `{name}`", gate.name),
        text: replaced(text, places),
    })
}

/// The places to be replaced so that a gate has one more argument, as it is to be written.
fn put_in(
    format: Format,
    gate: &WrittenGate,
    argument: &str,
) -> Option<Vec<(Range<usize>, String)>> {
    let count = gate.arguments.len() + 1;
    let connective = counted(gate.connective, count)?;
    let end = gate.arguments.last()?.1.end;
    let mut places = vec![(end..end, format!(" {argument}"))];
    if matches!(connective, Connective::AtLeast(_)) {
        places.extend(
            gate.words
                .iter()
                .cloned()
                .zip(format.words(connective, count)),
        );
    }
    Some(places)
}

fn with(text: &str, format: Format, gate: &WrittenGate, name: &str) -> Option<Rewrite> {
    let argument = match format {
        Format::Galileo => format!("\"{name}\""),
        Format::OpenPsa => format!("<event name=\"{name}\"/>"),
    };
    Some(Rewrite {
        kind: RewriteKind::Argument,
        gate: gate.name.clone(),
        place: gate.words.first()?.start,
        what: format!("the gate `{}` has `{name}`, too", gate.name),
        text: replaced(text, put_in(format, gate, &argument)?),
    })
}

fn moved(
    text: &str,
    format: Format,
    (gate, place, name): (&WrittenGate, usize, &str),
    to: &WrittenGate,
) -> Option<Rewrite> {
    let mut places = taken_out(text, format, gate, place)?;
    let own = gate.arguments.get(place)?.1.clone();
    places.extend(put_in(format, to, &text[own.clone()])?);
    Some(Rewrite {
        kind: RewriteKind::Argument,
        gate: gate.name.clone(),
        place: own.start,
        what: format!(
            "`{name}` is an argument of the gate `{}` in place of `{}`",
            to.name, gate.name
        ),
        text: replaced(text, places),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GALILEO: &str = "toplevel \"dry\";
\"dry\" or \"no pump or valve\" \"leak\";
\"no pump or valve\" and \"a\" \"b\" \"c\";
\"leak\" 2of3 \"d\" \"e\" \"f\";
\"a\" prob=0.1; // not \"b\"
";

    fn changed_lines(old: &str, new: &str) -> Vec<String> {
        let known: Vec<&str> = old.lines().collect();
        let lines = new.lines().filter(|line| !known.contains(line));
        lines.map(str::to_owned).collect()
    }

    fn of(text: &str, format: Format, kind: RewriteKind) -> Vec<Vec<String>> {
        let all = rewrites(text, format).into_iter();
        let own = all.filter(|it| it.kind == kind);
        own.map(|it| changed_lines(text, &it.text)).collect()
    }

    #[test]
    fn each_gate_becomes_each_of_its_neighbours() {
        let found = of(GALILEO, Format::Galileo, RewriteKind::Gate);
        assert_eq!(
            found.concat(),
            [
                "\"dry\" and \"no pump or valve\" \"leak\";",
                "\"no pump or valve\" or \"a\" \"b\" \"c\";",
                "\"no pump or valve\" 2of3 \"a\" \"b\" \"c\";",
                "\"leak\" or \"d\" \"e\" \"f\";",
                "\"leak\" and \"d\" \"e\" \"f\";",
            ]
        );
    }

    #[test]
    fn arguments_belong_to_another_gate_or_to_one_that_has_none() {
        let text = format!("{GALILEO}\"d\" prob=0.1;\n\"g\" prob=0.1;\n");
        let found = of(&text, Format::Galileo, RewriteKind::Argument);
        let has = |lines: &[&str]| found.iter().any(|it| it == lines);
        assert!(
            has(&["\"leak\" 2of4 \"d\" \"e\" \"f\" \"g\";"]),
            "{found:#?}"
        );
        assert!(
            has(&[
                "\"no pump or valve\" and \"a\" \"b\";",
                "\"leak\" 2of4 \"d\" \"e\" \"f\" \"c\";",
            ]),
            "{found:#?}"
        );
    }

    const OPEN_PSA: &str = "<opsa-mef>
<define-gate name=\"dry\">
<nor>
<gate name=\"pumps\"/>
<not>
<basic-event name=\"water\"/>
</not>
</nor>
</define-gate>
<define-gate name=\"pumps\">
<atleast min=\"2\">
<basic-event name=\"a\"/>
<basic-event name=\"b\"/>
<basic-event name=\"c\"/>
</atleast>
</define-gate>
</opsa-mef>
";

    #[test]
    fn formulas_of_open_psa_change_both_their_tags() {
        let found = of(OPEN_PSA, Format::OpenPsa, RewriteKind::Gate);
        assert_eq!(
            found,
            [
                vec!["<or>", "</or>"],
                vec!["<nand>", "</nand>"],
                vec!["<or>", "</or>"],
                vec!["<or>", "</or>"],
                vec!["<and>", "</and>"],
            ]
            .map(|lines| lines
                .into_iter()
                .map(str::to_owned)
                .collect::<Vec<String>>())
        );
        let all = rewrites(OPEN_PSA, Format::OpenPsa);
        let places = all.iter().filter(|it| it.kind == RewriteKind::Gate);
        let places: Vec<(&str, &str)> = places
            .map(|it| (it.gate.as_str(), &OPEN_PSA[it.place..it.place + 4]))
            .collect();
        let expected = [
            ("dry", "<nor"),
            ("dry", "<nor"),
            ("dry", "<not"),
            ("pumps", "<atl"),
            ("pumps", "<atl"),
        ];
        assert_eq!(places, expected);
    }

    #[test]
    fn what_is_made_can_be_read_unless_it_has_a_cycle() {
        let events: String = "bcdef"
            .chars()
            .map(|it| format!("\"{it}\" prob=0.1;\n"))
            .collect();
        let text = format!("{GALILEO}{events}");
        let mut read = 0;
        for it in rewrites(&text, Format::Galileo) {
            let source = diagnostic::Source {
                name: "tree".into(),
                text: it.text.clone(),
            };
            match crate::read_galileo(&source, &crate::Settings::default()) {
                Ok(_) => read += 1,
                Err(problem) => assert!(
                    format!("{problem:?}").contains("depends on itself"),
                    "{}: {problem:?}",
                    it.text
                ),
            }
        }
        assert!(read > 15, "{read}");
    }

    #[test]
    fn an_argument_that_is_used_twice_is_left_out_and_a_comment_before_it_stays() {
        let text = "\"x\" and \"y\" // the first\n \"b\";\n\"y\" 2of3 \"b\" \"c\" \"d\";\n";
        let found = rewrites(text, Format::Galileo);
        let without = found.iter().filter(|it| it.what.contains("without"));
        let without: Vec<&str> = without.map(|it| it.text.as_str()).collect();
        let expected = [
            text.replace("\n \"b\";", "\n ;"),
            text.replace("2of3 \"b\"", "2of2"),
        ];
        assert_eq!(without, expected);
    }
}
