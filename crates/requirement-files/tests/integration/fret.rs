//! FRET's files, sentences and formulas.

use crate::support::{changed, every_text_can_be_changed, item, read};
use requirement_files::fret::{Comparison, Formulas, compare, translated};
use requirement_files::{Change, Field, Format};
use requirement_lang::{Context, parse};

/// Written by hand in the form of FRET's exports.
const FILE: &str = r#"{
  "requirements": [
    {
      "reqid": "ARM-1", "parent_reqid": "SYS-1", "project": "Arm", "rationale": "People é",
      "fulltext": "When near the arm shall within 2 ticks satisfy slow",
      "status": null, "_id": "7f",
      "semantics": {"type": "nasa", "ftExpanded": "((LAST V (((! near) & ((! LAST) & (X near))) -> (X ((F[0,2] slow) | (F[0,1] LAST))))) & (near -> ((F[0,2] slow) | (F[0,1] LAST))))"}
    },
    {"reqid": "ARM-2", "parent_reqid": "", "fulltext": "free text", "semantics": {}}
  ],
  "variables": [{"variable_name": "near"}]
}
"#;

fn future(formula: &str) -> Formulas {
    Formulas {
        future: Some(formula.into()),
        ..Formulas::default()
    }
}

#[test]
fn a_file_is_read_and_changed_in_place() {
    let document = read(Format::Fret, FILE).expect("a file");
    let first = document.items[0].item.clone();
    assert_eq!(
        (first.rationale.as_str(), &first.parents[..]),
        ("People é", &["SYS-1".to_owned()][..])
    );
    assert_eq!(document.notes, ["Kept in the file: 1 variable of FRET."]);
    every_text_can_be_changed(&document);

    let mut new = first;
    new.status = "in \"progress\"".into();
    let text = changed(&document, &[Change::Set(new.clone(), vec![Field::Status])]);
    assert_eq!(
        text,
        FILE.replace("\"status\": null", "\"status\": \"in \\\"progress\\\"\"")
    );
    // Formulas belong to the sentence of which they were made.
    new.text = "The arm shall always satisfy slow".into();
    let text = changed(&document, &[Change::Set(new, vec![Field::Text])]);
    assert!(
        text.contains("\"semantics\": {}\n    },") && !text.contains("LAST"),
        "{text}"
    );
    let list = FILE
        .replace("{\n  \"requirements\": ", "")
        .replace(",\n  \"variables\": [{\"variable_name\": \"near\"}]\n}", "");
    let document = read(Format::Fret, &list).expect("a list");
    let text = changed(
        &document,
        &[Change::Add(item("ARM-3", "x\ny", &["ARM-1", "ARM-2"]))],
    );
    let again = read(Format::Fret, &text).expect("again");
    assert_eq!(
        again.items[2].item,
        item("ARM-3", "x\ny", &["ARM-1", "ARM-2"])
    );
    assert!(text.contains("\"project\": \"Arm\""), "{text}");
}

#[test]
fn mistakes_are_placed_and_told_together() {
    let text = FILE
        .replace("\"reqid\": \"ARM-1\"", "\"reqid\": 1")
        .replace("\"fulltext\": \"free text\", ", "");
    let problem = read(Format::Fret, &text).expect_err("two mistakes");
    assert_eq!(problem.others().len(), 1, "{problem}");
    for bad in [
        "",
        "{}",
        "[1]",
        "{\"requirements\": {}}",
        "[{\"reqid\": \"\", \"fulltext\": \"\"}]",
    ] {
        assert!(read(Format::Fret, bad).expect_err(bad).has_place(), "{bad}");
    }
}

#[test]
fn sentences_are_translated_word_by_word() {
    for (text, expected) in [
        (
            "FSM shall always satisfy (limits & !standby) => pullup",
            "The FSM shall always satisfy limits and not standby => pullup",
        ),
        (
            "when in hdg mode, upon a & b is false the R shall immediately satisfy c",
            "While hdg, when not (a and b), the R shall immediately satisfy c",
        ),
        (
            "Only before m shall the r for 3 ticks satisfy x = 1",
            "Only before m, the r shall for 3 steps satisfy x = 1",
        ),
        (
            "unless c the r shall until q satisfy a => b => c",
            "Unless c, the r shall until q satisfy (a => b) => c",
        ),
        (
            "The r shall with probability >= 0.9 eventually satisfy a xor b.",
            "The r shall with probability at least 0.9 eventually satisfy not (a <=> b)",
        ),
        (
            "except while m, when a or unless b the r shall never satisfy c",
            "When not in m, when a or not b, the r shall never satisfy c",
        ),
        (
            "the r shall after 4 ticks satisfy c",
            "The r shall after 5 steps satisfy c",
        ),
        (
            "the r shall within 5 minutes satisfy if a then b",
            "The r shall within 5 min satisfy a => b",
        ),
        (
            "the r shall at the next timepoint satisfy p(a, b) & -3.0 < x",
            "The r shall at the next step satisfy p_a_b and -3.0 < x",
        ),
    ] {
        let read = translated(text).map(|it| it.text);
        assert_eq!(read.as_deref(), Ok(expected), "{text}");
    }
    for text in [
        "",
        "free text",
        "the r shall finally satisfy x",
        "the r shall satisfy",
        "r shall within x ticks satisfy y",
        "r shall always satisfy at the previous occurrence of a, b",
        "r shall always satisfy 3",
        "the ¬ shall",
    ] {
        assert!(translated(text).is_err(), "{text}");
    }
}

#[test]
fn a_formula_of_the_same_meaning_is_found_the_same() {
    let document = read(Format::Fret, FILE).expect("a file");
    let translation = translated(&document.items[0].item.text).expect("a sentence");
    let formulas = document.items[0].formulas.as_ref().expect("formulas");
    let meaning = compare(&translation.sentence, formulas, Some(&translation), None);
    let Comparison::Same { words, all_up_to } = meaning.runs else {
        panic!("{:?}", meaning.runs);
    };
    assert!(words > 1_000 && all_up_to >= 3);
    // FRET excuses what could still have come; a sentence of ours does not.
    let Comparison::Excuses { trace, words, .. } = meaning.ends else {
        panic!("{:?}", meaning.ends);
    };
    assert!(words > 1_000);
    assert_eq!(
        trace.to_string(),
        "near; the run ends: the sentence does not hold, FRET's ftExpanded holds; FRET excuses what could still come: for ever: slow"
    );
}

/// A formula excuses only what could still come: one that holds where the sentence never will is another.
#[test]
fn a_formula_that_is_too_weak_on_runs_that_end_is_no_excuse() {
    let of = |text: &str, formula: &str| {
        let sentence = parse(text, &Context::default()).tree;
        compare(&sentence, &future(formula), None, None).ends
    };
    let within = "Whenever near, the arm shall within 2 steps satisfy slow";
    let after = "The arm shall after 3 steps satisfy slow";
    let response = "(LAST V (near -> ((F[0,2] slow) | (F[0,1] LAST))))";
    let late = "(((G[0,2] (! slow)) | (LAST V (! slow))) & ((F[0,3] slow) | (F[0,2] LAST)))";
    for (text, formula, to_come) in [
        (within, response, "for ever: slow"),
        (
            after,
            late,
            "nothing holds; then nothing holds; then for ever: slow",
        ),
    ] {
        let Comparison::Excuses { trace, .. } = of(text, formula) else {
            panic!("{text}: {:?}", of(text, formula));
        };
        let shown = trace.to_string();
        assert!(
            shown.ends_with(&format!("could still come: {to_come}")),
            "{shown}"
        );
    }
    let weaker = [
        (within, response, "TRUE"),
        (within, "F[0,2]", "F[0,3]"),
        (within, "F[0,1]", "F[0,2]"),
        (within, "slow)", "(slow | near))"),
        (within, "near ->", "(near & slow) ->"),
        (within, "[0,2] slow", "[0,40] slow"),
        (after, "F[0,3]", "F[0,4]"),
        (after, "F[0,2]", "F[0,3]"),
        (after, "G[0,2]", "G[0,1]"),
        (after, "G[0,2] (! slow)", "G[1,2] (! slow)"),
    ];
    for (text, old, new) in weaker {
        let formula = if text == within { response } else { late };
        assert!(formula.contains(old), "{old}");
        let found = of(text, &formula.replace(old, new));
        let Comparison::Differs(trace) = found else {
            panic!("{text} with {new}: {found:?}");
        };
        assert!(
            !trace.sentence && trace.formula && trace.could_come.is_none(),
            "{trace}"
        );
    }
}

#[test]
fn a_formula_of_another_meaning_is_shown_by_the_shortest_word() {
    let of = |text: &str, formula: &str| {
        let sentence = parse(text, &Context::default()).tree;
        compare(&sentence, &future(formula), None, None).runs
    };
    let next = of(
        "Whenever near, the arm shall immediately satisfy slow",
        "(LAST V (near -> (X slow)))",
    );
    let Comparison::Differs(trace) = next else {
        panic!("{next:?}");
    };
    assert_eq!(
        (trace.steps.len(), trace.sentence != trace.formula),
        (2, true),
        "{trace}"
    );
    // Bounds that differ by one, and are longer than all words that are tried exhaustively.
    for (bound, is_same) in [(40, true), (39, false), (41, false)] {
        let comparison = of(
            "The arm shall within 40 steps satisfy slow",
            &format!("(F[0,{bound}] slow)"),
        );
        assert_eq!(
            matches!(comparison, Comparison::Same { .. }),
            is_same,
            "{bound}: {comparison:?}"
        );
    }
    // Chained implications: FRET reads them from the left.
    let formula = "(LAST V ((a -> b) -> c))";
    assert!(matches!(
        of("The r shall always satisfy a => b => c", formula),
        Comparison::Differs(_)
    ));
    assert!(matches!(
        of("The r shall always satisfy (a => b) => c", formula),
        Comparison::Same { .. }
    ));
    // Other names are not guessed to be the same.
    let other = of("The r shall always satisfy stopped", "(LAST V halted)");
    assert!(
        matches!(other, Comparison::NotCompared(ref reason) if reason.contains("`halted`")),
        "{other:?}"
    );
    let long = of("The r shall within 99999 steps satisfy a", "(F[0,99999] a)");
    assert!(matches!(long, Comparison::NotCompared(_)));
}

#[test]
fn functions_of_the_past_mean_what_their_formulas_say() {
    let text = "the r shall always satisfy if preBool(false, a) & persisted(2, b) then c";
    let translation = translated(text).expect("a sentence");
    assert_eq!(translation.definitions.len(), 2);
    let past = "(H (((Y a) & ((H[0,2] b) & (H[0,1] (Y TRUE)))) -> c))";
    let of = |past: &str| {
        let formulas = Formulas {
            past: Some(past.into()),
            future: Some("(LAST V ((preBool(FALSE,a) & persisted(2,b)) -> c))".into()),
            ..Formulas::default()
        };
        compare(&translation.sentence, &formulas, Some(&translation), None)
    };
    let meaning = of(past);
    assert!(
        matches!(meaning.runs, Comparison::Same { .. }),
        "{:?}",
        meaning.runs
    );
    assert!(
        matches!(meaning.ends, Comparison::Same { .. }),
        "{:?}",
        meaning.ends
    );
    assert!(matches!(
        of(&past.replace("[0,1]", "[0,2]")).ends,
        Comparison::Differs(_)
    ));
}

#[test]
fn probabilities_of_a_response_and_of_a_run_are_told_apart() {
    let of = |text: &str, formula: &str| {
        let translation = translated(text).expect("a sentence");
        let formulas = Formulas {
            probabilistic: Some(formula.into()),
            ..Formulas::default()
        };
        compare(&translation.sentence, &formulas, Some(&translation), None)
    };
    let plain = of("the r shall within 3 ticks satisfy a", "(P>=1[(F<=3 a)])");
    assert_eq!(plain.probability, None);
    assert!(
        matches!(plain.runs, Comparison::Same { .. }),
        "{:?}",
        plain.runs
    );
    let whole = of(
        "the r shall with probability > 0.9 within 3 ticks satisfy a",
        "P>0.9[(F<=3 a)]",
    );
    assert_eq!(whole.probability, None);
    let nested = of(
        "whenever c the r shall with probability > 0.9 immediately satisfy a",
        "P>=1[(G (c => (P>0.9[a])))]",
    );
    assert!(nested.probability.is_some_and(|it| it.contains("> 0.9")));
    let other = of(
        "the r shall with probability > 0.8 within 3 ticks satisfy a",
        "P>0.9[(F<=3 a)]",
    );
    assert!(other.probability.is_some());
}

/// Of few names and of many: an operand that one side does not have is found, and the same is found to be the same.
#[test]
fn a_single_operand_tells_apart() {
    let of = |text: &str, formula: &str| {
        let read = parse(text, &Context::default());
        assert!(!read.has_errors(), "{text}");
        let formulas = Formulas {
            infinite: Some(formula.into()),
            ..Formulas::default()
        };
        compare(&read.tree, &formulas, None, None).runs
    };
    for count in [2, 5, 6, 9, 12, 24] {
        let names: Vec<String> = (0..count).map(|at| format!("a{at}")).collect();
        let dropped = count / 2;
        let mut fewer = names.clone();
        fewer.remove(dropped);
        let mut negated = names.clone();
        negated[dropped] = format!("(! {})", negated[dropped]);
        for (sign, place) in [("&", 0), ("|", 1)] {
            let join = |all: &[String]| format!("({})", all.join(&format!(" {sign} ")));
            let all = join(&names);
            let forms = [
                (format!("always satisfy {all}"), "(G PART)"),
                (format!("always satisfy {all} => b"), "(G (PART -> b))"),
                (format!("until {all} satisfy b"), "(PART V (b | PART))"),
                (format!("eventually satisfy {all}"), "(F PART)"),
            ];
            for (at, (text, formula)) in forms.into_iter().enumerate() {
                let text = format!("The robot shall {text}");
                for other in [join(&fewer), join(&negated)] {
                    let formula = formula.replace("PART", &other);
                    let found = of(&text, &formula);
                    assert!(
                        matches!(found, Comparison::Differs(_)),
                        "{text} against {formula}: {found:?}"
                    );
                }
                // That they are the same takes longest: each form once with few names and once with many.
                if (count + place) % 4 == at {
                    let same = of(&text, &formula.replace("PART", &all));
                    let Comparison::Same { all_up_to, .. } = same else {
                        panic!("{text}: {same:?}");
                    };
                    // Of more names not even all letters were looked at.
                    assert_eq!(all_up_to > 0, count <= 12, "{text}: {all_up_to}");
                }
            }
        }
    }
}
