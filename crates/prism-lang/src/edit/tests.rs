//! The edits keep all other text, and the result parses and resolves.

use super::*;
use crate::{Constants, parse_model, resolve};

const MODEL: &str = "\
dtmc // a sensor and its copy
const double pTP = 0.95; // guessed
const double pFN = 1 - pTP;
const int idle = 0;
const int last = 1; // of the states

module robot
  s : [idle..last] init idle; // the robot

  [go] s=idle -> (s'=1);
endmodule

module sensor
  x : [0..2] init 0;

  [read] s=1 | s=0 -> pTP : (x'=1)
    + pFN : (x'=2);
  [skip] x=0 -> true;
endmodule

module other = sensor [ x=y, read=look ] endmodule
";

fn changed(edits: &[Edit]) -> String {
    let text = apply(MODEL, edits).expect("edits that do not overlap");
    let parsed = parse_model(&text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{text}\n{:?}",
        parsed.diagnostics
    );
    resolve(&parsed.tree, &Constants::new()).unwrap_or_else(|e| panic!("{text}\n{e:?}"));
    text
}

/// Lines that are in one text and not in the other.
fn differing(a: &str, b: &str) -> Vec<String> {
    let lines: Vec<&str> = b.lines().collect();
    let gone = a.lines().filter(|line| !lines.contains(line));
    gone.map(str::to_owned).collect()
}

#[test]
fn a_complement_changes_places_with_its_constant() {
    let tree = parse_model(MODEL).tree;
    let text = changed(&set_constant(&tree, "pFN", "7/98").expect("a constant"));
    assert_eq!(
        differing(&text, MODEL),
        [
            "const double pTP = 1 - pFN; // guessed",
            "const double pFN = 7/98;"
        ]
    );
    assert_eq!(
        set_constant(&tree, "pXX", "1"),
        Err(EditError::NoConstant("pXX".into()))
    );
}

#[test]
fn a_written_constant_is_set_alone() {
    let tree = parse_model(MODEL).tree;
    let text = changed(&set_constant(&tree, "pTP", "91/98").expect("a constant"));
    assert_eq!(
        differing(&text, MODEL),
        ["const double pTP = 91/98; // guessed"]
    );
}

#[test]
fn a_range_gets_a_named_value_and_a_command_a_branch() {
    let tree = parse_model(MODEL).tree;
    let extension = extend_range(MODEL, &tree, "s", 1, "lost").expect("a range");
    assert_eq!(extension.value, 2);
    let ModuleBody::Written { commands, .. } = &tree.modules[0].body else {
        panic!("the robot is written out");
    };
    let mut edits = extension.edits;
    edits.push(add_constants(
        MODEL,
        &tree,
        &["const double q = 2/100;".into()],
        None,
    ));
    edits.extend(add_branch(MODEL, &commands[0], "q", "s", "lost"));
    let text = changed(&edits);
    assert_eq!(
        differing(&text, MODEL),
        [
            "const int lost = 2;",
            "const int last = 2; // of the states",
            "const double q = 2/100;",
            "  [go] s=idle ->",
            "    1-q : (s'=1)",
            "    + q : (s'=lost);"
        ]
    );
    assert_eq!(
        extend_range(MODEL, &tree, "s", 1, "idle"),
        Err(EditError::NameTaken("idle".into()))
    );
}

#[test]
fn a_branch_beside_others_takes_its_share_of_each() {
    let tree = parse_model(MODEL).tree;
    let ModuleBody::Written { commands, .. } = &tree.modules[1].body else {
        panic!("the sensor is written out");
    };
    let text = changed(&add_branch(MODEL, &commands[0], "0.1", "x", "0"));
    assert!(
        text.contains(
            "->\n    pTP*(1-0.1) : (x'=1)\n    + pFN*(1-0.1) : (x'=2)\n    + 0.1 : (x'=0);"
        ),
        "{text}"
    );
}

#[test]
fn parentheses_within_a_probability_or_a_definition_go_with_it() {
    let text = "dtmc\nconst double q = 0.5*(1-0.2);\nconst double r = (1-q)*(q);\nmodule m\n  s : [0..2];\n  \
                [] s=0 -> q*(1-r) : (s'=1) + 1-q*(1-r) : (s'=1);\nendmodule\n";
    let tree = parse_model(text).tree;
    let ModuleBody::Written { commands, .. } = &tree.modules[0].body else {
        panic!("it is written out");
    };
    let of = |edits: &[super::Edit]| super::apply(text, edits).expect("applied");
    let branched = of(&add_branch(text, &commands[0], "0.1", "s", "2"));
    assert!(
        branched.contains(
            "(q*(1-r))*(1-0.1) : (s'=1) + (1-q*(1-r))*(1-0.1) : (s'=1)\n    + 0.1 : (s'=2);"
        ),
        "{branched}"
    );
    assert!(parse_model(&branched).into_result().is_ok());
    for (name, expected) in [
        ("q", "const double q = 0.3;"),
        ("r", "const double r = 0.3;"),
    ] {
        let set = of(&super::set_constant(&tree, name, "0.3").expect("a constant"));
        assert!(set.contains(expected), "{set}");
        assert!(parse_model(&set).into_result().is_ok());
    }
}

#[test]
fn a_draw_is_made_once_in_each_copy() {
    let tree = parse_model(MODEL).tree;
    let text = changed(&draw_once(MODEL, &tree, "x").expect("a draw"));
    assert_eq!(
        differing(&text, MODEL),
        [
            "  xDrawn : bool init false;",
            "  [read] (s=1 | s=0) & !xDrawn -> pTP : (x'=1) & (xDrawn'=true)",
            "    + pFN : (x'=2) & (xDrawn'=true);",
            "module other = sensor [ x=y, read=look, xDrawn=yDrawn ] endmodule"
        ]
    );
    // The copy's variable is not written out.
    assert_eq!(
        draw_once(MODEL, &tree, "y"),
        Err(EditError::NoVariable("y".into()))
    );
}

#[test]
fn overlapping_edits_are_refused() {
    let edits = [
        Edit::replace(Span::new(0, 4), "mdp"),
        Edit::replace(Span::new(2, 6), "x"),
    ];
    assert_eq!(apply(MODEL, &edits), Err(EditError::Overlapping));
    assert_eq!(
        apply("ab", &[Edit::insert(3, "c")]),
        Err(EditError::Overlapping)
    );
}
