//! Unit tests of slips in the text of a model.

use super::*;

#[test]
fn updates_do_what_others_do_or_leave_something_out() {
    let model = "dtmc
module door
  s : [0..2] init 0;
  near : bool init true;
  [] s=0 -> 0.5 : (s'=1) & (near'=false) + 0.5 : (s'=2);
  [] s>0 -> true;
endmodule
";
    let read = Read::new(model).expect("a model");
    let made: Vec<String> = slips(&read)
        .iter()
        .filter_map(|(_, it)| it.make(&read).ok())
        .collect();
    for wanted in [
        "0.5 : (s'=1) + 0.5 : (s'=2);",
        "0.5 : (s'=2) & (near'=false) + 0.5 : (s'=2);",
        "0.5 : (s'=1) & (near'=false) + 0.5 : (s'=2) & (near'=false);",
        "0.5 : (s'=1) & (near'=false) + 0.5 : (s'=1) & (near'=false);",
        "0.5 : (s'=1) & (near'=false) + 0.5 : true;",
    ] {
        assert!(
            made.iter().any(|it| it.contains(wanted)),
            "no {wanted} in {made:#?}"
        );
    }
    assert!(made.iter().all(|text| Read::new(text).is_ok()));
}

const TURNS: &str = "dtmc
const double slips = 0.2;
const int most = 2;
const int away = 3;
formula tired = (turns>=most) | s=away;
module crank
  s : [0..away] init 0;
  turns : [0..5] init 0;
  wet : bool init false;
  [] (s=0) & (turns<4) & !wet -> 0.5 : (s'=1) + 0.5 : (turns'=turns+1);
  [] s=0 & (turns>=4 | wet) -> (s'=2);
  [] s>0 -> true;
endmodule
";

fn all_made(text: &str) -> Vec<(u8, String)> {
    let read = Read::new(text).expect("a model");
    let all = slips(&read).into_iter();
    all.map(|(kind, it)| (kind, it.make(&read).expect("it can be made")))
        .collect()
}

#[test]
fn limits_are_moved_wherever_they_stand() {
    let made = all_made(TURNS);
    for (kind, wanted) in [
        (0, "const double slips = 0.8;"),
        (0, "const double slips = 0.02;"),
        (2, "turns : [0..5] init 3;"),
        (2, "wet : bool init true;"),
        (1, "const int most = 3;"),
        (1, "const int most = 0;"),
        (
            3,
            "(turns<5) & !wet -> 0.5 : (s'=1) + 0.5 : (turns'=turns+1);\n  [] s=0 & (turns>=5 | wet)",
        ),
        (4, "(turns<=4) & !wet"),
        (4, "(turns>4) & !wet"),
        (4, "(turns<3) & !wet"),
        (4, "(turns<4) & wet"),
        (4, "(turns<4) | !wet"),
        (4, "(turns>=4 & wet)"),
        (4, "(turns>=4 | !wet)"),
        (4, "tired = (turns>=4) | s=away;"),
        (4, "(turns<most) & !wet"),
        (4, "tired = (turns<most) | s=away;"),
        (4, "tired = (turns>=most) | s!=away;"),
        (5, "[] s=0 & (turns>=4 | wet) -> 0.5 : (s'=1)"),
        (5, "[] (s=0) & (turns<4) & !wet -> (s'=2);"),
    ] {
        let found = made
            .iter()
            .any(|(of, text)| *of == kind && text.contains(wanted));
        assert!(found, "no {wanted} of kind {kind}");
    }
    // Each is a text of its own that can be read, and only what is compared by order or ends a range is moved.
    assert!(
        made.iter()
            .all(|(_, text)| Read::new(text).is_ok() || text.contains("away = "))
    );
    assert!(made.iter().all(|(_, text)| text != TURNS));
}

#[test]
fn names_of_states_are_no_limits() {
    let text = TURNS
        .replace("[0..away]", "[0..3]")
        .replace("s>0", "s=1 | s=2");
    let made = all_made(&text);
    assert!(made.iter().all(|(_, it)| it.contains("away = 3;")));
    assert!(
        made.iter()
            .filter(|(kind, _)| *kind == 3)
            .all(|(_, it)| it.contains("s=1 | s=2"))
    );
}

#[test]
fn a_chain_of_operands_is_joined_otherwise_throughout() {
    let text = TURNS.replace(
        "(turns>=most) | s=away;",
        "!(turns>=most & s=away & wet) | wet;",
    );
    let made = all_made(&text);
    let wanted = "!(turns>=most | s=away | wet) | wet;";
    assert!(
        made.iter()
            .any(|(kind, it)| *kind == 4 && it.contains(wanted))
    );
    // One of its operators alone is another change.
    let one = "!(turns>=most & s=away | wet) | wet;";
    assert!(made.iter().any(|(_, it)| it.contains(one)));
}

#[test]
fn a_variable_of_states_may_begin_with_each_of_them() {
    let made = all_made(TURNS);
    for value in 1..=3 {
        let wanted = format!("s : [0..away] init {value};");
        assert!(
            made.iter()
                .any(|(kind, it)| *kind == 2 && it.contains(&wanted))
        );
    }
}
