//! Unit tests of changes that lead to values which a model declares or asks for.

use super::*;

const MODEL: &str = "dtmc
module tries
  s : [0..3] init 0;
  tries : [0..4] init 1;
  cuts : [0..1] init 0;
  [] s=0 & tries<2 -> 0.5 : (s'=1) + 0.5 : (tries'=tries+1);
  [] s=0 & tries=2 -> (s'=2);
  [] s=1 & cuts=0 -> 0.5 : (s'=2) + 0.5 : (s'=3);
  [] s=1 & cuts=1 -> 0.5 : (s'=2) + 0.5 : (s'=3);
  [] s>1 -> true;
endmodule
";

fn made(change: &Idle) -> String {
    let read = Read::new(MODEL).expect("a model");
    change.make(&read).expect("it can be made")
}

#[test]
fn ends_of_ranges_beginnings_and_what_guards_ask_for_are_tried() {
    let read = Read::new(MODEL).expect("a model");
    let all = changes(&read);
    let of = |wanted: u8| {
        all.iter()
            .filter(move |(kind, _)| *kind == wanted)
            .map(|(_, it)| it)
    };
    let limits: Vec<String> = of(0).map(made).collect();
    assert_eq!(limits.len(), 2, "{all:?}");
    assert!(
        limits[1].contains("tries<4") && limits[1].contains("tries=4"),
        "{}",
        limits[1]
    );
    assert!(limits[1].contains("tries : [0..4] init 1"));
    let begins: Vec<String> = of(1).map(made).collect();
    assert!(begins[0].contains("tries : [0..4] init 0;"), "{begins:?}");
    let outcomes: Vec<String> = of(2).map(made).collect();
    let wanted = "[] s=1 & cuts=0 -> 0.5 : (s'=2) + 0.5 : (cuts'=1);";
    assert!(
        outcomes.iter().any(|it| it.contains(wanted)),
        "{outcomes:#?}"
    );
    assert_eq!(never_taken(MODEL), Some(("cuts=1".into(), 9)));
}

#[test]
fn a_model_that_uses_what_it_declares_has_none() {
    let right = MODEL
        .replace("tries<2", "tries<4")
        .replace("tries=2", "tries=4")
        .replace("init 1", "init 0")
        .replacen("0.5 : (s'=3)", "0.5 : (cuts'=1)", 1);
    let read = Read::new(&right).expect("a model");
    assert_eq!(changes(&read), []);
    assert_eq!(never_taken(&right), None);
}

#[test]
fn what_nothing_uses_counts_how_often_it_is_tried_again() {
    let model = "dtmc
module door
  s : [0..2] init 0;
  tries : [0..1] init 0;
  [] s=0 -> 0.5 : (s'=1) + 0.5 : (s'=2);
  [] s>0 -> true;
endmodule
";
    let read = Read::new(model).expect("a model");
    let all = changes(&read);
    assert!(all.iter().all(|(kind, _)| *kind == 3), "{all:?}");
    let made: Vec<String> = all
        .iter()
        .filter_map(|(_, it)| it.make(&read).ok())
        .collect();
    let wanted = "  [] (s=0) & tries<1 -> 0.5 : (s'=1) + 0.5 : (s'=1) & (tries'=tries+1);
  [] (s=0) & tries=1 -> 0.5 : (s'=1) + 0.5 : (s'=2);
";
    assert!(made.iter().any(|it| it.contains(wanted)), "{made:#?}");
    assert!(made.iter().all(|text| Read::new(text).is_ok()));
}

#[test]
fn a_value_that_a_guard_asks_for_may_hold_at_the_beginning() {
    let model = MODEL.replace("cuts : [0..1] init 0", "cuts : [0..1] init 1");
    let model = model.replace(
        "(s'=3);\n  [] s=1 & cuts=1",
        "(cuts'=1);\n  [] s=1 & cuts=1",
    );
    let read = Read::new(&model).expect("a model");
    let begins = Idle::Begin {
        variable: "cuts".into(),
        new: "0".into(),
    };
    assert!(changes(&read).contains(&(1, begins)));
}

#[test]
fn what_a_guard_asks_for_is_counted_to() {
    let model = MODEL
        .replace("(tries'=tries+1)", "(s'=3)")
        .replace("init 1", "init 0");
    let read = Read::new(&model).expect("a model");
    let made: Vec<String> = changes(&read)
        .iter()
        .filter_map(|(_, it)| it.make(&read).ok())
        .collect();
    let wanted = "[] s=0 & tries<2 -> 0.5 : (s'=1) + 0.5 : (tries'=tries+1);";
    assert!(made.iter().any(|it| it.contains(wanted)), "{made:#?}");
}
