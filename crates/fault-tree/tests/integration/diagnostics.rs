//! What is said of a text with mistakes: all of them, each with its place and a remedy.

use crate::support::{analysis, galileo, open_psa};

use std::collections::BTreeMap;

use diagnostic::{Cancel, Problem, Source};
use fault_tree::{EventData, Reading, Settings, decimal, read_galileo, read_open_psa};

/// Line, column and message of every mistake.
fn mistakes(found: Result<Reading, Problem>) -> Vec<(usize, usize, String)> {
    let problem = found.expect_err("the text has mistakes");
    let all = std::iter::once(&problem).chain(problem.others());
    let shown = all.map(|it| {
        let place = it.place().expect("every mistake has a place");
        assert!(it.what_to_do().is_some(), "no remedy: {it}");
        (place.line, place.column, it.message().to_owned())
    });
    shown.collect()
}

fn expect(found: &[(usize, usize, String)], expected: &[(usize, usize, &str)]) {
    let found: Vec<_> = found
        .iter()
        .map(|(line, column, text)| (*line, *column, text.as_str()))
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn all_mistakes_of_a_galileo_text_are_placed() {
    let text = "toplevel \"T\";\n\
                \"T\" and \"A\" \"B\" \"missing\";\n\
                \"A\" prob=1.5;\n\
                \"B\" 2of3 \"C\" \"D\";\n\
                \"C\" lambda=0.1;\n\
                \"D\" prob=0.1 repair=2;\n\
                \"E\" pand \"A\" \"C\";\n\
                \"A\" prob=0.2;\n\
                \"F\" majority \"A\";\n\
                \"G\"";
    expect(
        &mistakes(galileo(text)),
        &[
            (2, 17, "`missing` is not defined"),
            (3, 10, "`prob` must be a number between 0 and 1 (got `1.5`)"),
            (4, 5, "`2of3` has 2 arguments, and says that they are 3"),
            (5, 1, "`C` has a failure rate, and no mission time is given"),
            (
                6,
                14,
                "`repair` is a repair rate, and only events that stay failed are read",
            ),
            (
                7,
                5,
                "`pand` is a dynamic gate: it depends on the order of failures, and only static trees are read",
            ),
            (8, 1, "`A` is defined twice"),
            (
                9,
                5,
                "`majority` is not a gate or an attribute that is known",
            ),
            (10, 1, "this statement does not end"),
            (10, 1, "`G` is neither a gate nor a basic event"),
        ],
    );
}

#[test]
fn every_dynamic_gate_is_refused_by_name() {
    for gate in [
        "pand", "por", "seq", "mutex", "fdep", "wsp", "csp", "hsp", "rdep", "inspect", "PAND",
        "pdep=0.3",
    ] {
        let text = format!("toplevel T; T {gate} A B; A prob=0.1; B prob=0.1;");
        let problem = galileo(&text).expect_err("it is dynamic");
        assert_eq!(problem.code, "unsupported-fault-tree", "{problem}");
        let word = gate.split('=').next().expect("a word");
        assert!(
            problem
                .message()
                .starts_with(&format!("`{word}` is a dynamic gate: ")),
            "{problem}"
        );
    }
    for attribute in ["cov", "res", "repl", "shape", "mean", "unheard"] {
        let problem = galileo(&format!("toplevel T; T or A; A prob=0.1 {attribute}=1;"))
            .expect_err("refused");
        assert_eq!(problem.code, "unsupported-fault-tree", "{problem}");
    }
}

#[test]
fn a_cycle_is_shown_as_a_path() {
    let text = "toplevel T;\nT or A;\nA or B;\nB and C E;\nC or A;\nE prob=0.1;";
    expect(
        &mistakes(galileo(text)),
        &[(3, 1, "`A` depends on itself: A -> B -> C -> A")],
    );
    expect(
        &mistakes(galileo("toplevel T; T or T;")),
        &[(1, 13, "`T` depends on itself: T -> T")],
    );
}

#[test]
fn a_similar_name_is_proposed() {
    let problem = galileo("toplevel T; T or pump_1; pump1 prob=0.1;").expect_err("a misspelt name");
    assert_eq!(problem.what_to_do(), Some("did you mean `pump1`?"));
}

#[test]
fn what_has_no_effect_is_a_warning() {
    let text = "toplevel T;\nT or A;\nA prob=0.1 dorm=0.5;\nB prob=0.1;";
    let reading = galileo(text).expect("a tree");
    let said: Vec<_> = reading
        .warnings
        .iter()
        .map(|it| (it.place().map(|p| p.line), it.message()))
        .collect();
    let dorm = "`dorm` has no effect: only a spare gate makes an event dormant, and a static tree has none";
    assert_eq!(said, [(Some(4), "`B` is not part of `T`"), (Some(3), dorm)]);
}

#[test]
fn comments_and_names_of_any_kind_are_read() {
    let text = "/* a\ncomment */ toplevel \"top event\"; // the rest\n\"top event\" 2of3 \"ä\" B' C; \"ä\" prob = 0.1 ;\
                B' prob=.5; C prob=1e-1;";
    let tree = galileo(text).expect("a tree").tree;
    assert_eq!(tree.basic_events().len(), 3);
    let found = analysis(&tree)
        .probability(&Cancel::default())
        .expect("data");
    // 0.1*0.5*0.9 + 0.1*0.1*0.5 + 0.9*0.5*0.1 + 0.1*0.5*0.1
    assert_eq!(found.exact, decimal("0.1"));
}

fn model(gates: &str, data: &str) -> String {
    format!(
        "<opsa-mef>\n<define-fault-tree name=\"t\">\n{gates}\n</define-fault-tree>\n<model-data>\n{data}\n</model-data>\n</opsa-mef>"
    )
}

#[test]
fn all_mistakes_of_an_open_psa_text_are_placed() {
    let gates = "<define-gate name=\"T\"><and><gate name=\"G\"/><event name=\"a\"/><basic-event name=\"none\"/></and></define-gate>\n\
                 <define-gate name=\"G\"><cardinality min=\"1\" max=\"2\"><event name=\"a\"/></cardinality></define-gate>\n\
                 <define-gate name=\"H\"><xor><event name=\"a\"/><event name=\"b\"/><event name=\"c\"/></xor></define-gate>\n\
                 <define-CCF-group name=\"x\"/>";
    let data = "<define-basic-event name=\"a\"><lognormal-deviate/></define-basic-event>\n\
                <define-basic-event name=\"b\"><exponential><float value=\"1e-3\"/><system-mission-time/></exponential></define-basic-event>\n\
                <define-basic-event name=\"c\"><parameter name=\"p\"/></define-basic-event>\n\
                <define-parameter name=\"p\"><parameter name=\"p\"/></define-parameter>\n\
                <define-basic-event name=\"d\"><attributes><attribute name=\"trials\" value=\"3\"/></attributes></define-basic-event>\n\
                <define-basic-event><float value=\"2\"/></define-basic-event>";
    let found = mistakes(open_psa(&model(gates, data)));
    let starts: Vec<(usize, &str)> = found
        .iter()
        .map(|(line, _, text)| (*line, &text[..text.len().min(33)]))
        .collect();
    assert_eq!(
        starts,
        [
            (3, "`none` is not defined"),
            (4, "the formula `cardinality` is not "),
            (5, "`xor` has two arguments, and not "),
            (6, "`define-CCF-group` is not read: o"),
            (9, "the expression `lognormal-deviate"),
            (10, "this needs the mission time, and "),
            (11, "this parameter depends on itself"),
            (13, "these attributes must be `occurre"),
            (14, "`define-basic-event` has no name"),
        ]
    );
}

#[test]
fn a_path_into_a_container_is_refused_as_such() {
    let gates = "<define-gate name=\"T\"><event name=\"t.a\"/></define-gate>";
    let problem = open_psa(&model(gates, "<define-basic-event name=\"a\"/>")).expect_err("a path");
    assert_eq!(problem.code, "unsupported-fault-tree");
    assert!(
        problem.message().starts_with("`t.a` is a path"),
        "{problem}"
    );
}

#[test]
fn the_format_s_own_ways_are_read() {
    let gates = "<define-component name=\"c\"><define-gate name=\"T\"><label>top</label><or><gate name=\"G\"/><house-event name=\"h\"/>\
                 <constant value=\"false\"/></or></define-gate></define-component>\n\
                 <define-gate name=\"G\"><basic-event name=\"a\"/></define-gate><define-house-event name=\"h\"/>";
    let data = "<define-basic-event name=\"a\"><exponential><parameter name=\"rate\"/><system-mission-time/></exponential></define-basic-event>\n\
                <define-parameter name=\"rate\" unit=\"hours-1\"><float value=\"0.001\"/></define-parameter>";
    let settings = Settings {
        mission_time: decimal("100"),
    };
    let tree = read_open_psa(&Source::new("t.xml", model(gates, data)), &settings)
        .expect("a tree")
        .tree;
    assert_eq!(tree.top(), tree.find("T"));
    let found = analysis(&tree)
        .probability(&Cancel::default())
        .expect("data")
        .bounds;
    let expected = -(-0.1_f64).exp_m1();
    assert!(found.contains(expected), "{found:?} {expected}");
}

#[test]
fn counts_and_ranges_stand_in_attributes() {
    let event = |name: &str, attributes: &[(&str, &str)]| {
        let attribute = |(name, value): &(&str, &str)| {
            format!("<attribute name=\"{name}\" value=\"{value}\"/>")
        };
        let attributes: String = attributes.iter().map(attribute).collect();
        format!(
            "<define-basic-event name=\"{name}\"><attributes>{attributes}</attributes><float value=\"0.5\"/></define-basic-event>"
        )
    };
    let gates = "<define-gate name=\"T\"><or><event name=\"a\"/><event name=\"b\"/><event name=\"c\"/></or></define-gate>";
    let data = event("a", &[("occurrences", "2"), ("trials", "40")])
        + &event(
            "b",
            &[("probability-lower", "0.1"), ("probability-upper", "0.2")],
        )
        + &event("c", &[("color", "red")]);
    let tree = open_psa(&model(gates, &data)).expect("a tree").tree;
    let kind = |name: &str| tree.node(tree.find(name).expect("an event")).kind.clone();
    let is = |data: Option<EventData>| fault_tree::NodeKind::Basic(data);
    assert_eq!(kind("a"), is(EventData::counts(2, 40)));
    assert_eq!(kind("b"), is(EventData::interval("0.1", "0.2")));
    assert_eq!(kind("c"), is(EventData::probability("0.5")));
}

#[test]
fn xml_that_is_not_well_formed_has_a_place() {
    let found = mistakes(open_psa(
        "<opsa-mef>\n<define-fault-tree name=\"x\">\n</opsa-mef>",
    ));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].0, 3, "{found:?}");
    let other = mistakes(open_psa("<robot/>"));
    assert_eq!(other[0].2, "the outermost element is `robot`");
    assert!(open_psa("<!DOCTYPE x [<!ENTITY a \"b\">]><opsa-mef/>").is_err());
}

#[test]
fn a_table_of_data_is_checked_as_a_whole() {
    let tree = galileo("toplevel T; T or A B; A prob=0.1; B prob=0.1;")
        .expect("a tree")
        .tree;
    let data = EventData::counts(1, 10).expect("counts");
    let wrong = EventData::Counts {
        occurrences: 3,
        trials: 2,
    };
    let table: BTreeMap<String, EventData> =
        [("T", data.clone()), ("a", data.clone()), ("B", wrong)]
            .map(|(name, data)| (name.to_owned(), data))
            .into();
    let problem = tree.clone().with_data(&table).expect_err("three mistakes");
    let all: Vec<&str> = std::iter::once(&problem)
        .chain(problem.others())
        .map(|it| it.message())
        .collect();
    assert_eq!(
        all,
        [
            "`B`: counts need at least one trial, and no more occurrences than trials",
            "`T` is not a basic event, so it cannot be given data",
            "the fault tree has no event `a`",
        ]
    );
}

#[test]
fn events_without_data_have_cut_sets_and_no_probability() {
    let gates =
        "<define-gate name=\"T\"><and><event name=\"a\"/><event name=\"b\"/></and></define-gate>";
    let data = "<define-basic-event name=\"a\"/><define-basic-event name=\"b\"/>";
    let tree = open_psa(&model(gates, data)).expect("a tree").tree;
    let analysis = analysis(&tree);
    let problem = analysis
        .probability(&Cancel::default())
        .expect_err("no data");
    assert_eq!(
        (problem.code, problem.message()),
        ("missing-event-data", "no probability is known of `a`, `b`")
    );
    assert_eq!(
        analysis
            .cut_sets(9, &Cancel::default())
            .expect("cut sets")
            .sets
            .len(),
        1
    );
}

#[test]
fn several_roots_leave_the_question_open() {
    let gates = "<define-gate name=\"T\"><event name=\"a\"/></define-gate><define-gate name=\"U\"><event name=\"a\"/></define-gate>";
    let reading = open_psa(&model(gates, "<define-basic-event name=\"a\"/>")).expect("a tree");
    assert_eq!(reading.tree.top(), None);
    let names: Vec<&str> = reading
        .tree
        .roots()
        .iter()
        .map(|id| reading.tree.name(*id))
        .collect();
    assert_eq!(names, ["T", "U"]);
    assert!(
        reading.warnings[0].message().ends_with("T, U"),
        "{}",
        reading.warnings[0]
    );
}

#[test]
fn a_rate_needs_the_mission_time_that_is_given() {
    let source = Source::new("t.dft", "toplevel T; T or A; A lambda=2e-3;");
    let settings = Settings {
        mission_time: decimal("10"),
    };
    assert!(read_galileo(&source, &Settings::default()).is_err());
    assert!(read_galileo(&source, &settings).is_ok());
}
