//! Parsing accepts the language, finds every mistake, and printing is its inverse.

use prism_lang::{parse_model, parse_properties};

const MODEL: &str = r#"
// a comment
dtmc
const int n = 3; const double p; const bool fast = true; const m = n+1;
formula busy = x>0 & (y<n | !b);
label "done" = x=n;
global g : [0..1] init 0;
module first
  x : [0..n] init 0;
  b : bool init false;
  [] x<n & !b -> p:(x'=x+1) & (b'=true) + 1-p:true;
  [go] busy ? x=1 : x=2 -> (x'=min(x+1, n)) & (b'=!b);
  [go] x=n -> true;
endmodule
module second = first [x=y, b=c] endmodule
init x=0 | x=n endinit
rewards "steps" [] true : 1; [go] x=1 : 2.5; busy : x/2; endrewards
"#;

/// A tree without its places.
fn shape(tree: &impl std::fmt::Debug) -> String {
    let text = format!("{tree:?}");
    let mut shape = String::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find("Span {") {
        shape.push_str(&rest[..at]);
        let end = rest[at..].find('}').map_or(rest.len(), |e| at + e + 1);
        rest = &rest[end..];
    }
    shape + rest
}

#[test]
fn a_model_with_every_construct_is_read_and_printed_back() {
    let parsed = parse_model(MODEL);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let printed = parsed.tree.to_string();
    let again = parse_model(&printed);
    assert!(
        again.diagnostics.is_empty(),
        "{printed}\n{:?}",
        again.diagnostics
    );
    assert_eq!(shape(&parsed.tree), shape(&again.tree), "{printed}");
    assert_eq!(parsed.tree.modules.len(), 2);
    assert_eq!(parsed.tree.rewards[0].items.len(), 3);
}

#[test]
fn operators_bind_as_in_prism() {
    for (text, meant) in [
        ("!a = b", "!(a = b)"),
        ("a => b => c", "a => (b => c)"),
        ("a <=> b => c", "(a <=> b) => c"),
        ("a | b & c", "a | (b & c)"),
        ("a = b < c", "a = (b < c)"),
        ("x - 1 - 2", "(x - 1) - 2"),
        ("2 ^ 3 ^ 2", "2 ^ (3 ^ 2)"),
        ("-2 ^ 2", "(-2) ^ 2"),
        ("2 * -x", "2 * (-x)"),
        ("a ? b : c ? d : e", "a ? b : (c ? d : e)"),
        ("a => b ? c : d", "(a => b) ? c : d"),
        ("func(min, 1, 2)", "min(1, 2)"),
    ] {
        let [bare, grouped] = [text, meant].map(|t| parse_model(&format!("formula f = {t};")));
        assert!(
            bare.diagnostics.is_empty(),
            "{text}: {:?}",
            bare.diagnostics
        );
        assert_eq!(
            shape(&bare.tree.formulas),
            shape(&grouped.tree.formulas),
            "{text}"
        );
    }
}

#[test]
fn temporal_operators_bind_as_in_prism() {
    for (text, meant) in [
        ("F a & b", "F (a & b)"),
        ("G F a | b", "G (F (a | b))"),
        ("a & b U c => d", "(a & b) U (c => d)"),
        ("F a U G b", "(F a) U (G b)"),
        ("F<=t (a)", "F<=t a"),
        ("F<=2+3 a", "F<=(2+3) a"),
        ("a U[2,7] b", "a U[2,7] (b)"),
        ("X X a", "X (X a)"),
    ] {
        let [bare, grouped] = [text, meant].map(|t| parse_properties(&format!("P=? [ {t} ]")));
        assert!(
            bare.diagnostics.is_empty(),
            "{text}: {:?}",
            bare.diagnostics
        );
        let [bare, grouped] = [bare, grouped].map(|p| shape(&p.tree.properties[0].formula));
        assert_eq!(bare, grouped, "{text}");
    }
}

#[test]
fn properties_are_read_with_names_texts_and_places() {
    let text = "const int k = 5;\nlabel \"far\" = x>k;\n\
        // the first\n\"one\": P=? [ F<=k \"far\" ];\nP>=0.5 [ G !(x=1) ]\n\"two\": (x=0) & P<1/3 [ X x=1 ]";
    let parsed = parse_properties(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let texts: Vec<_> = parsed
        .tree
        .properties
        .iter()
        .map(|p| p.text.as_str())
        .collect();
    assert_eq!(
        texts,
        [
            "P=? [ F<=k \"far\" ]",
            "P>=0.5 [ G !(x=1) ]",
            "(x=0) & P<1/3 [ X x=1 ]"
        ]
    );
    for property in &parsed.tree.properties {
        assert_eq!(property.span.of(text), property.text);
    }
    let names: Vec<_> = parsed
        .tree
        .properties
        .iter()
        .map(|p| p.name.as_ref().map(|n| n.text.as_str()))
        .collect();
    assert_eq!(names, [Some("one"), None, Some("two")]);
}

#[test]
fn semicolons_may_be_left_out_between_lines() {
    let parsed = parse_properties(
        "P>0.5 [ F x=1 ]\nx=1\n(x=2) | y\n!y\n\"n\": P=? [ x=0 R x=1 ]\nR=? [ F x=1 ]",
    );
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    assert_eq!(parsed.tree.properties.len(), 6);
    let joined = parse_properties("P>0.5 [ F x=1 ] x=1");
    assert_eq!(joined.diagnostics[0].code, "syntax");
}

#[test]
fn deep_texts_are_refused_and_long_ones_are_not() {
    let deep = format!(
        "formula f = {}x{};",
        "(".repeat(100_000),
        ")".repeat(100_000)
    );
    let codes: Vec<_> = parse_model(&deep)
        .diagnostics
        .iter()
        .map(|d| d.code)
        .collect();
    assert_eq!(codes[0], "too-deep");
    let bangs = format!("formula f = {}x;", "!".repeat(100_000));
    assert_eq!(parse_model(&bangs).diagnostics[0].code, "too-deep");
    let sum = format!("formula f = x{};", "+1".repeat(100_000));
    assert_eq!(parse_model(&sum).diagnostics[0].code, "too-deep");
    let long = format!("formula f = x=0{};", " | x=1".repeat(100_000));
    let parsed = parse_model(&long);
    assert!(parsed.diagnostics.is_empty());
    assert_eq!(
        shape(&parse_model(&parsed.tree.to_string()).tree),
        shape(&parsed.tree)
    );
}

#[test]
fn every_mistake_of_a_text_is_found_in_one_run() {
    let text = "dtmc\nconst int a = ;\nmodule m\n x : [0..1;\n [] x=0 -> (x=1);\n [] x=1 (x'=0);\nendmodule\nlabel done = x=1;";
    let lines: Vec<_> = parse_model(text)
        .diagnostics
        .iter()
        .map(|d| (prism_lang::line_and_column(text, d.span.start).0, d.code))
        .collect();
    assert_eq!(
        lines,
        [
            (2, "syntax"),
            (4, "syntax"),
            (5, "missing-prime"),
            (6, "syntax"),
            (8, "syntax")
        ]
    );
}

#[test]
fn compositions_bind_as_in_prism() {
    for (text, meant) in [
        ("a ||| b || c", "a ||| (b || c)"),
        ("a ||| b ||| c || d", "a ||| b ||| (c || d)"),
        ("a |[x]| b || c", "(a |[x]| b) || c"),
        ("a / {x} {y<-z} || b", "((a / {x}) {y<-z}) || b"),
    ] {
        let [bare, grouped] = [text, meant].map(|t| parse_model(&format!("system {t} endsystem")));
        assert!(
            bare.diagnostics.is_empty(),
            "{text}: {:?}",
            bare.diagnostics
        );
        let [bare, grouped] = [bare, grouped].map(|p| shape(&p.tree.systems));
        assert_eq!(bare, grouped, "{text}");
    }
}

#[test]
fn every_operator_of_properties_is_read_and_printed_back() {
    for text in [
        "Pmin=? [ F a ]",
        "R{\"r\"}max=? [ F a ]",
        "R{\"r\"}/{\"s\"}=? [ S ]",
        "R{2}>=1.5 [ C<=k ]",
        "R=? [ C ]",
        "R=? [ I=k+1 ]",
        "R=? [ X F a ]",
        "Pminmax=? [ G a ]",
        "S>0.5 [ a ]",
        "A [ G E [ F a ] ]",
        "P=? [ a U[1,2] b {c}{min}{max} ]",
        "filter(+, P=? [ F a ]*2, b)",
        "filter(printall, a)",
        "<<*>> P>=0.5 [ F a ]",
        "[[1,two]] Rmin=? [ C ]",
        "<<>> (P>0.1 [ G a ] & b)",
        "multi(Pmax=? [ F a ], R<=5 [ C ])",
        "P=? [ F a ]+\"x\"",
        "a ? P=? [ X a ] : 1",
    ] {
        let parsed = parse_properties(text);
        assert!(
            parsed.diagnostics.is_empty(),
            "{text}: {:?}",
            parsed.diagnostics
        );
        assert_eq!(parsed.tree.to_string(), format!("{text};\n"));
    }
    for (old, new) in [
        ("P min=? [ X a ]", "Pmin=? [ X a ]"),
        ("R{1} max min=? [ C ]", "R{1}maxmin=? [ C ]"),
    ] {
        assert_eq!(parse_properties(old).tree.to_string(), format!("{new};\n"));
    }
}

/// Each mistake costs its own property; all are found.
#[test]
fn a_syntax_error_costs_its_own_property() {
    let text = "P=? [ F x=1 ];\n\
        \"a\": P=? [ F x=1 ;\n\
        \"b\": P=? [ G\n  P>0.5 [ F x=) ] ]\n\
        \"c\": P=? [ F x=2 ]\n\
        const int k = 3;\n\
        P=? [ F x=$1 ];\n\
        R=? [ F x=k ]; P= [ F x=1 ]; \"d\": S=? [ x=1 ]\n\
        P=? [ F x=1\n\
        \"a\" > 0";
    let parsed = parse_properties(text);
    let file = parsed.tree;
    let read: Vec<&str> = file.properties.iter().map(|p| p.text.as_str()).collect();
    let expected = [
        "P=? [ F x=1 ]",
        "P=? [ F x=2 ]",
        "R=? [ F x=k ]",
        "S=? [ x=1 ]",
        "\"a\" > 0",
    ];
    assert_eq!(read, expected);
    let unread: Vec<_> = (file.unread.iter())
        .map(|p| {
            (
                p.index,
                p.name.as_ref().map(|n| n.text.as_str()),
                p.text.as_str(),
            )
        })
        .collect();
    let expected = [
        (1, Some("a"), "P=? [ F x=1"),
        (2, Some("b"), "P=? [ G\n  P>0.5 [ F x=) ] ]"),
        (4, None, "P=? [ F x=$1 ]"),
        (6, None, "P= [ F x=1 ]"),
        (8, None, "P=? [ F x=1"),
    ];
    assert_eq!(unread, expected);
    assert_eq!(parsed.diagnostics.len(), 5, "{:?}", parsed.diagnostics);
    assert!(!file.has_errors_outside(&parsed.diagnostics));
    let parsed = parse_properties("label \"l\" x=1; P=? [ F \"l\" ]");
    assert!(parsed.tree.has_errors_outside(&parsed.diagnostics));
    // What refers to a property that could not be read says so.
    let file = parse_properties("\"a\": P=? [ F x= ]; \"a\" > 0.5;").tree;
    let model = parse_model("dtmc module m x : [0..3]; [] true -> true; endmodule").tree;
    let model = prism_lang::resolve(&model, &Default::default()).unwrap();
    let found = prism_lang::resolve_properties(&file, &model, &Default::default()).unwrap_err();
    assert_eq!((found.len(), found[0].code), (1, "unreadable"), "{found}");
}
