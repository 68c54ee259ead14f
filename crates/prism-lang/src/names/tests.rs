use super::*;
use crate::parse_model;

fn names(text: &str) -> Names {
    let parsed = parse_model(text);
    assert!(!parsed.has_errors(), "{:?}", parsed.diagnostics);
    Names::of_model(&parsed.tree, text)
}

fn lines(names: &Names, space: Space, name: &str, text: &str) -> Vec<(usize, Role)> {
    names
        .of(space, name)
        .map(|it| {
            assert_eq!(it.span.of(text), name);
            (crate::line_and_column(text, it.span.start).0, it.role)
        })
        .collect()
}

#[test]
fn a_copy_renames_variables_and_actions() {
    let text = "mdp
module a
  x : [0..1];
  [x] x=0 -> (x'=1);
  [go] true -> true;
endmodule
module b = a [x=y, go=stop]
endmodule
module c = b [y=z, x=w, stop=halt] endmodule
label \"l\" = y=1 & z=0;";
    let names = names(text);
    use Role::{Assignment, Definition, Replaced, Use};
    assert_eq!(
        lines(&names, Space::Value, "x", text),
        [
            (3, Definition),
            (4, Use),
            (4, Assignment),
            (7, Replaced),
            (9, Replaced)
        ]
    );
    // The copy `b` has the action `y`, too: one entry renames both.
    assert_eq!(lines(&names, Space::Action, "x", text)[0], (4, Definition));
    assert_eq!(
        lines(&names, Space::Action, "y", text),
        [(7, Use), (9, Replaced)]
    );
    assert_eq!(
        lines(&names, Space::Value, "y", text),
        [(7, Definition), (9, Replaced), (10, Use)]
    );
    assert_eq!(
        lines(&names, Space::Action, "stop", text),
        [(7, Use), (9, Replaced)]
    );
    assert_eq!(names.at(text.find("x=y").unwrap()).count(), 2);
}

/// Entries that change nothing, as published models have them, name what there is.
#[test]
fn an_entry_for_what_the_copied_module_does_not_have_is_one_of_the_name() {
    let text = "mdp
module a x : [0..1]; [] x=0 -> (x'=1); endmodule
module b = a [x=y, y=x] endmodule";
    let names = names(text);
    use Role::{Assignment, Definition, Replaced, Use};
    let of_x = [
        (2, Definition),
        (2, Use),
        (2, Assignment),
        (3, Replaced),
        (3, Use),
    ];
    assert_eq!(lines(&names, Space::Value, "x", text), of_x);
    assert_eq!(
        lines(&names, Space::Value, "y", text),
        [(3, Definition), (3, Replaced)]
    );
    assert_eq!(names.of(Space::Action, "x").count(), 0);
}

#[test]
fn quotes_blanks_and_primes_are_not_part_of_a_name() {
    let text = "dtmc module m x : bool; [] true -> (x' = !x); endmodule label \" up \" = x; rewards \"r\" true : 1; endrewards";
    let names = names(text);
    let spans: Vec<&str> = names.iter().map(|it| it.span.of(text)).collect();
    assert_eq!(spans, ["m", "x", "x", "x", "up", "x", "r"]);
    let file = "\"a\": P=? [ F \" up \" ]; R{\"r\"}=? [ C<=k ]; const int k; \"a\"";
    let parsed = crate::parse_properties(file);
    assert!(!parsed.has_errors(), "{:?}", parsed.diagnostics);
    let found = Names::of_properties(&parsed.tree, file);
    let spans: Vec<&str> = found.iter().map(|it| it.span.of(file)).collect();
    assert_eq!(spans, ["a", "up", "r", "k", "k", "a"]);
    assert_eq!(
        found.definition(Space::Label, "a").map(|it| it.span.start),
        Some(1)
    );
}

#[test]
fn a_text_with_mistakes_has_the_names_that_could_be_read() {
    let text =
        "dtmc const int n = ; module m x : [0..n]; [] x=0 -> (x'=; [] x=1 -> (x'=0); endmodule";
    let names = Names::of_model(&parse_model(text).tree, text);
    assert!(names.of(Space::Value, "x").count() >= 3);
    for it in names.iter() {
        assert_eq!(it.span.of(text), it.name);
    }
}
