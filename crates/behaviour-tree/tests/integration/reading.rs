//! What is read, what is abstracted with a note, and all mistakes at once.

use behaviour_tree::{Kind, Leaf, Options, Outcome, read, to_prism};
use diagnostic::{Problem, Source};

use crate::support::{reading, try_read};

fn tree(inner: &str) -> String {
    format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">{inner}</BehaviorTree></root>")
}

/// Code, line and message of each problem.
fn said(problem: &Problem) -> Vec<(String, usize, String)> {
    let all = std::iter::once(problem).chain(problem.others());
    all.map(|it| {
        let line = it.place().map_or(0, |place| place.line);
        assert!(it.what_to_do().is_some(), "{it:?}");
        (it.code.to_owned(), line, it.message().to_owned())
    })
    .collect()
}

#[test]
fn all_mistakes_of_all_files_are_said_with_their_lines() {
    let text = "<root BTCPP_format=\"4\" main_tree_to_execute=\"A\">\n\
        <include path=\"b.xml\"/>\n\
        <BehaviorTree ID=\"A\">\n\
        <Sequence>\n\
        <Inverter><X/><Y/></Inverter>\n\
        <Repeat><X/></Repeat>\n\
        <Action/>\n\
        <SubTree ID=\"A\"/>\n\
        <IfThenElse><X/></IfThenElse>\n\
        <AlwaysSuccess><X/></AlwaysSuccess>\n\
        <SubTree ID=\"B\"/>\n\
        <Fallback/>\n\
        </Sequence>\n\
        </BehaviorTree>\n\
        </root>";
    let other =
        "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"B\">\n<X/>\n<Y/>\n</BehaviorTree></root>";
    let mut include = |path: &str, from: &str| {
        assert_eq!((path, from), ("b.xml", "a.xml"));
        Ok(Source::new("b.xml", other))
    };
    let problem = read(&Source::new("a.xml", text), None, &mut include).expect_err("mistakes");
    let found = said(&problem);
    let lines: Vec<usize> = found.iter().map(|it| it.1).collect();
    assert_eq!(lines, [5, 6, 7, 8, 9, 10, 12, 2], "{found:#?}");
    assert!(found.iter().all(|it| it.0 == "bad-behaviour-tree"));
}

#[test]
fn what_cannot_be_found_is_said() {
    let codes = |text: &str| said(&try_read(text).expect_err(text))[0].clone();
    let root = |inner: &str| format!("<root BTCPP_format=\"4\">{inner}</root>");
    for (text, code, part) in [
        ("<root", "bad-behaviour-tree", "not well-formed"),
        ("<robot/>", "bad-behaviour-tree", "`robot`"),
        (
            "<root BTCPP_format=\"5\"/>",
            "unsupported-behaviour-tree",
            "`5`",
        ),
        ("<root/>", "bad-behaviour-tree", "no `BehaviorTree`"),
    ] {
        let found = codes(text);
        assert!(found.0 == code && found.2.contains(part), "{found:?}");
    }
    let two = root(
        "<BehaviorTree ID=\"A\"><X/></BehaviorTree><BehaviorTree ID=\"B\"><X/></BehaviorTree>",
    );
    assert!(codes(&two).2.contains("several trees"));
    // One that is part of no other is taken, and that is said.
    let outer = root(
        "<BehaviorTree ID=\"A\"><X/></BehaviorTree><BehaviorTree ID=\"B\"><SubTree ID=\"A\"/></BehaviorTree>",
    );
    let found = reading(&outer);
    assert_eq!(found.tree.id, "B");
    assert!(
        found.notes[0]
            .message()
            .contains("`B` is taken for the tree to execute")
    );
    let twice = root(
        "<BehaviorTree ID=\"A\"><X/></BehaviorTree><BehaviorTree ID=\"A\"><X/></BehaviorTree>",
    );
    assert!(codes(&twice).2.contains("defined twice"));
    assert!(
        codes(&root("<include path=\"x.xml\"/>"))
            .2
            .contains("cannot be included")
    );
    let deep = format!(
        "{}<X/>{}",
        "<Inverter>".repeat(300),
        "</Inverter>".repeat(300)
    );
    let found = codes(&tree(&deep));
    assert_eq!(found.0, "unsupported-behaviour-tree");
}

/// Subtrees that double in each of thirty levels are refused, not expanded.
#[test]
fn what_grows_without_bound_is_refused() {
    let mut text = "<root BTCPP_format=\"4\" main_tree_to_execute=\"T0\">".to_owned();
    for level in 0..30 {
        let next = level + 1;
        text += &format!(
            "<BehaviorTree ID=\"T{level}\"><Sequence><SubTree ID=\"T{next}\"/><SubTree ID=\"T{next}\"/></Sequence></BehaviorTree>"
        );
    }
    text += "<BehaviorTree ID=\"T30\"><X/></BehaviorTree></root>";
    let problem = try_read(&text).expect_err("too large");
    assert_eq!(problem.code, "unsupported-behaviour-tree");
}

#[test]
fn ports_of_subtrees_give_loops_their_numbers() {
    let text = |ports: &str| {
        format!(
            "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\
             <BehaviorTree ID=\"Main\"><SubTree ID=\"Sub\" {ports}/></BehaviorTree>\
             <BehaviorTree ID=\"Sub\"><RetryUntilSuccessful num_attempts=\"{{n}}\"><X/></RetryUntilSuccessful></BehaviorTree>\
             </root>"
        )
    };
    let kind = |ports: &str| {
        let found = reading(&text(ports));
        let kinds: Vec<Kind> = found.tree.nodes().map(|(_, it)| it.kind.clone()).collect();
        (kinds[1].clone(), found.notes.len())
    };
    assert_eq!(kind("n=\"4\""), (Kind::Retry(Some(4)), 0));
    assert_eq!(kind("n=\"-1\""), (Kind::Retry(None), 1));
    assert_eq!(kind("n=\"0\""), (Kind::Always(Outcome::Failure), 0));
    // Of an entry of the blackboard the value is not known: the loop is one leaf, and that is said.
    assert_eq!(kind("n=\"{m}\""), (Kind::Leaf(Leaf::Whole), 1));
    assert_eq!(kind(""), (Kind::Leaf(Leaf::Whole), 1));
}

#[test]
fn format_3_has_the_same_nodes_under_other_names() {
    let found = reading(
        "<root main_tree_to_execute=\"MainTree\"><BehaviorTree ID=\"MainTree\">\
         <SequenceStar name=\"root\">\
         <Parallel success_threshold=\"2\" failure_threshold=\"2\"><X/><Y/><Z/></Parallel>\
         <Parallel threshold=\"1\"><X/><Y/></Parallel>\
         <RunOnce><Action ID=\"X\" name=\"last\"/></RunOnce>\
         <SubTreePlus ID=\"MainTree2\"/>\
         </SequenceStar></BehaviorTree>\
         <BehaviorTree ID=\"MainTree2\"><BlackboardCheckInt value_A=\"{a}\" value_B=\"1\" return_on_mismatch=\"SUCCESS\"><X/></BlackboardCheckInt></BehaviorTree>\
         </root>",
    );
    let kinds: Vec<Kind> = found.tree.nodes().map(|(_, it)| it.kind.clone()).collect();
    let parallel = |successes, failures| Kind::Parallel {
        successes,
        failures,
        all: false,
    };
    assert!(matches!(kinds[0], Kind::Sequence { memory: true, .. }));
    assert_eq!(kinds[1], parallel(2, 2));
    assert_eq!(kinds[5], parallel(1, 2));
    assert_eq!(kinds[8], Kind::RunOnce { then_skip: false });
    assert_eq!(kinds[11], Kind::Gate(Outcome::Success));
}

#[test]
fn what_is_not_modelled_is_noted_at_its_line() {
    let text = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">\n\
        <ReactiveSequence>\n\
        <IsReady/>\n\
        <Mystery><X/></Mystery>\n\
        <Timeout msec=\"5\"><X/></Timeout>\n\
        <Delay delay_msec=\"5\"><X/></Delay>\n\
        <Parallel success_count=\"1\" failure_count=\"1\"><X/><Y/></Parallel>\n\
        <Parallel success_count=\"2\" failure_count=\"1\"><X/><Y/></Parallel>\n\
        <RoundRobin><X/><Y/></RoundRobin>\n\
        <RoundRobin wrap_around=\"true\"><X/><Y/></RoundRobin>\n\
        <X _skipIf=\"a > b\"/>\n\
        <SubTree ID=\"Elsewhere\"/>\n\
        <Parallel success_count=\"1\"><X _skipIf=\"a\"/><Y/></Parallel>\n\
        <KeepRunningUntilFailure><X/></KeepRunningUntilFailure>\n\
        </ReactiveSequence></BehaviorTree></root>";
    let found = reading(text);
    let lines: Vec<usize> = found
        .notes
        .iter()
        .map(|it| it.place().expect("a place").line)
        .collect();
    assert_eq!(
        lines,
        [2, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14],
        "{:#?}",
        found.notes
    );
    assert!(
        found
            .notes
            .iter()
            .all(|it| it.code == "abstracted-behaviour-tree")
    );
    let whole = found
        .tree
        .leaves()
        .filter(|(_, it)| it.kind == Kind::Leaf(Leaf::Whole));
    assert_eq!(whole.count(), 3);
}

#[test]
fn labels_tell_leaves_of_one_name_apart() {
    let found = reading(&tree(
        "<Fallback><Sequence name=\"go there\"><Drive/><Drive name=\"2nd drive\"/></Sequence>\
         <Sequence name=\"go back\"><Drive/><Drive/></Sequence><Drive_if/>\
         <Precondition name=\"Drive\" if=\"a\"><Stop/></Precondition></Fallback>",
    ));
    let model = to_prism(&found.tree, &Options::default());
    let names: Vec<&str> = model.constants.iter().map(|it| it.name.as_str()).collect();
    let mut unique = names.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), names.len(), "{names:?}");
    assert!(
        names.contains(&"p_n2nd_drive") && names.contains(&"p_Drive_if"),
        "{names:?}"
    );
    let places: Vec<String> = found.tree.leaves().map(|(_, it)| it.path.clone()).collect();
    assert_eq!(places[1], "Fallback/go there/2nd drive");
}

/// A name of a file may hold anything; a comment stays on its line, and the model is read.
#[test]
fn names_cannot_leave_their_comment() {
    let found = reading(&tree("<X name=\"a&#10;b*/ endmodule &quot;\"/>"));
    let options = Options {
        values: [("p_a_b_endmodule".to_owned(), 0.25)].into(),
        ..Options::default()
    };
    let text = to_prism(&found.tree, &options).text;
    let (values, states) = crate::support::values(&text, &["P=? [ F \"success\" ]".to_owned()]);
    assert!((values[0] - 0.25).abs() < 1e-12);
    assert_eq!(states, 5);
}

#[test]
fn retries_count_and_the_chain_is_small() {
    let found = reading(&tree(
        "<RetryUntilSuccessful num_attempts=\"3\"><X/></RetryUntilSuccessful>",
    ));
    let options = Options {
        values: [("p_X".to_owned(), 0.5)].into(),
        ..Options::default()
    };
    let text = to_prism(&found.tree, &options).text;
    let properties = ["P=? [ F \"failure\" ]".to_owned()];
    let (values, states) = crate::support::values(&text, &properties);
    assert!((values[0] - 0.125).abs() < 1e-12);
    // For each of three rounds: executed, succeeded, failed, decided; two ends.
    assert_eq!(states, 3 * 4 + 2);
}

/// As the parser that BehaviorTree.CPP uses takes it.
#[test]
fn scripts_may_have_bare_ampersands() {
    let found = reading(&tree("<X _skipIf=\"a && b &lt; 2 &amp;&amp; !c\"/>"));
    let (_, script) = &found.tree.node(found.tree.root()).preconditions[0];
    assert_eq!(script.text, "a && b < 2 && !c");
    let text = to_prism(&found.tree, &Options::default()).text;
    assert!(
        text.contains("_skipIf=\"a && b < 2 && !c\" is true"),
        "{text}"
    );
}
