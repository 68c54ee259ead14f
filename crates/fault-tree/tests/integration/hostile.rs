//! Texts that are deep, large or wrong in a hundred thousand places. A quadratic walk would not end here within minutes.

use crate::support::{analysis, galileo, open_psa};

use std::fmt::Write;

use diagnostic::{Cancel, MOST_SHOWN};
use fault_tree::{Analysis, Options, decimal};

const MANY: usize = 100_000;

/// `g0 = e0 op (g1 = e1 op (...))`, or with the argument before the event.
fn chain(gate: impl Fn(usize) -> &'static str, is_event_first: bool) -> String {
    let mut text = String::from("toplevel g0;\n");
    for index in 0..MANY {
        let (event, next) = (format!("e{index}"), format!("g{}", index + 1));
        let arguments = if is_event_first {
            [event, next]
        } else {
            [next, event]
        };
        writeln!(
            text,
            "g{index} {} {} {};",
            gate(index),
            arguments[0],
            arguments[1]
        )
        .expect("a string");
    }
    writeln!(text, "g{MANY} prob=0.5;").expect("a string");
    (0..MANY).for_each(|index| writeln!(text, "e{index} prob=1e-6;").expect("a string"));
    text
}

#[test]
fn a_chain_of_a_hundred_thousand_gates_is_analysed() {
    let alternating = |index: usize| if index.is_multiple_of(2) { "or" } else { "and" };
    let cancel = Cancel::default();
    for is_event_first in [true, false] {
        let tree = galileo(&chain(|_| "or", is_event_first))
            .expect("a tree")
            .tree;
        let analysis = analysis(&tree);
        let found = analysis.probability(&cancel).expect("data").bounds;
        let expected = 1.0 - 0.5 * (MANY as f64 * (-1e-6_f64).ln_1p()).exp();
        assert!(
            (found.lower - expected).abs() < 1e-9 && found.width() < 1e-9,
            "{found:?} {expected}"
        );
        let sets = analysis.cut_sets(10, &cancel).expect("cut sets");
        assert_eq!(sets.count, (MANY as u64 + 1).into());
        assert!(sets.sets.iter().all(|set| set.len() == 1));

        let tree = galileo(&chain(alternating, is_event_first))
            .expect("a tree")
            .tree;
        let found = crate::support::analysis(&tree)
            .probability(&cancel)
            .expect("data")
            .bounds;
        assert!(
            found.contains(1e-6 + 1e-12) || (found.lower - 1e-6).abs() < 1e-11,
            "{found:?}"
        );
    }
}

#[test]
fn the_one_cut_set_of_a_deep_conjunction_has_all_events() {
    let tree = galileo(&chain(|_| "and", true)).expect("a tree").tree;
    let sets = analysis(&tree)
        .cut_sets(10, &Cancel::default())
        .expect("cut sets");
    assert_eq!(sets.sets.len(), 1);
    assert_eq!(sets.sets[0].len(), MANY + 1);
}

#[test]
fn formulas_of_xml_nest_as_deep_as_they_like() {
    let depth = MANY;
    let formula = "<not>".repeat(depth) + "<event name=\"a\"/>" + &"</not>".repeat(depth);
    let text = format!(
        "<opsa-mef><define-fault-tree name=\"t\"><define-gate name=\"T\">{formula}</define-gate></define-fault-tree><model-data>\
         <define-basic-event name=\"a\"><float value=\"0.1\"/></define-basic-event></model-data></opsa-mef>"
    );
    let tree = open_psa(&text).expect("a tree").tree;
    let found = analysis(&tree)
        .probability(&Cancel::default())
        .expect("data");
    assert_eq!(found.exact, decimal("0.1"));
}

#[test]
fn a_cycle_of_a_hundred_thousand_gates_is_shown_by_its_ends() {
    let mut text = String::from("toplevel g0;\n");
    (0..MANY).for_each(|index| {
        writeln!(text, "g{index} or g{};", (index + 1) % MANY).expect("a string")
    });
    let problem = galileo(&text).expect_err("a cycle");
    assert!(problem.others().is_empty());
    assert!(
        problem
            .message()
            .starts_with("`g0` depends on itself: g0 -> g1 -> "),
        "{}",
        problem.message()
    );
    assert!(
        problem.message().ends_with("-> g99999 -> g0"),
        "{}",
        problem.message()
    );
}

#[test]
fn a_hundred_thousand_mistakes_are_counted_and_fifty_are_shown() {
    let mut text = String::from("toplevel T; T or");
    (0..MANY).for_each(|index| write!(text, "\n missing{index}").expect("a string"));
    text.push(';');
    (0..MANY).for_each(|index| writeln!(text, "e{index} prob=2;").expect("a string"));
    let problem = galileo(&text).expect_err("mistakes");
    assert_eq!(problem.others().len() + 1, MOST_SHOWN);
    let rest = format!("{} more mistakes", 2 * MANY - MOST_SHOWN);
    assert!(
        problem.rest().expect("more").starts_with(&rest),
        "{:?}",
        problem.rest()
    );
    // Nothing but warnings: of each event that is not used.
    let mut text = String::from("toplevel T; T prob=0.1;\n");
    (0..MANY).for_each(|index| writeln!(text, "e{index} prob=0.2 dorm=1;").expect("a string"));
    assert!(galileo(&text).expect("a tree").warnings.len() <= 2 * MOST_SHOWN);
}

/// Two rows of events that have to be paired in the order of the text, which no order of a walk in depth finds: the diagram of
/// the conjunction of `(a_i or b_(s(i)))` is small, that of a threshold over many shared gates is not.
fn large() -> String {
    let mut text = String::from("toplevel T;\nT 15of30");
    (0..30).for_each(|gate| write!(text, " g{gate}").expect("a string"));
    text.push_str(";\n");
    for gate in 0..30 {
        let events = [gate * 7 % 60, (gate * 13 + 29) % 60, (gate * 17 + 11) % 60];
        writeln!(
            text,
            "g{gate} and e{} e{} e{};",
            events[0], events[1], events[2]
        )
        .expect("a string");
    }
    (0..60).for_each(|event| writeln!(text, "e{event} prob=0.5;").expect("a string"));
    text
}

#[test]
fn the_limit_of_nodes_ends_with_an_error_and_no_number() {
    let tree = galileo(&large()).expect("a tree").tree;
    let options = Options {
        nodes: 10_000,
        ..Options::default()
    };
    let problem = Analysis::new(&tree, tree.top().unwrap(), options, &Cancel::default())
        .expect_err("a limit");
    assert_eq!(problem.code, "fault-tree-limit");
    assert!(problem.message().contains("10000 nodes"), "{problem}");
}

#[test]
fn the_work_ends_when_it_is_asked_to() {
    let tree = galileo(&large()).expect("a tree").tree;
    let cancel = Cancel::default();
    cancel.cancel();
    let options = Options {
        nodes: usize::MAX,
        ..Options::default()
    };
    let problem =
        Analysis::new(&tree, tree.top().unwrap(), options, &cancel).expect_err("an interruption");
    assert!(problem.is_interruption());
    // Of an analysis that is there, each question ends, too.
    let tree = galileo(&chain(|_| "or", true)).expect("a tree").tree;
    let analysis = analysis(&tree);
    assert!(
        analysis
            .probability(&cancel)
            .expect_err("an interruption")
            .is_interruption()
    );
    assert!(
        analysis
            .cut_sets(1, &cancel)
            .expect_err("an interruption")
            .is_interruption()
    );
    assert!(
        analysis
            .importance(&cancel)
            .expect_err("an interruption")
            .is_interruption()
    );
}

#[test]
fn numbers_of_any_length_are_refused_or_read_at_once() {
    for number in [
        "1e-999999999",
        "1e999999999999999999999",
        "-1",
        "0x1",
        "1e",
        "e5",
        "",
        "nan",
        "inf",
        "1_000",
    ] {
        let text = format!("toplevel T; T or A; A prob={number};");
        assert!(galileo(&text).is_err(), "{number}");
    }
    let long = format!("0.{}", "1".repeat(5_000));
    assert_eq!(decimal(&long), None);
    assert_eq!(decimal("0e99999"), decimal("0"));
    assert_eq!(decimal("1.50"), decimal("15e-1"));
}

#[test]
fn any_text_is_read_or_refused() {
    let alphabet = [
        "\"", ";", "=", "toplevel", " ", "T", "and", "2of3", "prob", "0.1", "/*", "*/", "//", "\n",
        "ä", "of", "vot2",
    ];
    let mut state = 7_u64;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..12 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            text.push_str(alphabet[(state >> 33) as usize % alphabet.len()]);
        }
        let _ = galileo(&text).map(|it| it.tree.top());
    }
}
