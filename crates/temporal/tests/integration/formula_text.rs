//! Formulas as text: what is read, how mistakes are reported, and that printing keeps the formula.

use proptest::prelude::*;
use temporal::formula::{
    AtomText, Bound, Formula, FormulaError, Interval, Parsed, TimeUnit, parse,
};

fn no_parameters(_: &str) -> Option<f64> {
    None
}

fn read(text: &str) -> Parsed {
    parse(text, &no_parameters).unwrap_or_else(|error| panic!("{error}"))
}

fn error(text: &str) -> FormulaError {
    parse(text, &no_parameters).expect_err(text)
}

/// The formula with atoms p0, p1 and so on, and the texts of the atoms.
fn shape(text: &str) -> (String, Vec<String>) {
    let parsed = read(text);
    let texts = parsed.atoms.into_iter().map(|atom| atom.text).collect();
    (parsed.formula.to_string(), texts)
}

#[test]
fn atoms_are_taken_as_they_are_written() {
    let cases = [
        ("grasped", "p0", vec!["grasped"]),
        (
            "/robot.hand_speed < 250 mm/s",
            "p0",
            vec!["/robot.hand_speed < 250 mm/s"],
        ),
        (
            "(a.x - b.x) < 3 & c",
            "p0 and p1",
            vec!["(a.x - b.x) < 3", "c"],
        ),
        ("(p & q) | r", "(p0 and p1) or p2", vec!["p", "q", "r"]),
        (
            "norm(/a.x, /a.y) < 3 => distance(/a, /b) > 2",
            "p0 => p1",
            vec!["norm(/a.x, /a.y) < 3", "distance(/a, /b) > 2"],
        ),
        ("((a + b) * 2 >= c)", "p0", vec!["(a + b) * 2 >= c"]),
        ("-(a + b) < 3 -> c", "p0 => p1", vec!["-(a + b) < 3", "c"]),
        (
            "/robot.state = 'F and G' U `odd until name` > 1",
            "p0 until p1",
            vec!["/robot.state = 'F and G'", "`odd until name` > 1"],
        ),
        (
            "/robot.until < 3 and /U/and.W[3] != 2",
            "p0 and p1",
            vec!["/robot.until < 3", "/U/and.W[3] != 2"],
        ),
        (
            "F[0, 1 s] /until.x / 2 < 3 and p U[1 s, inf) /and.y > /U/since.x",
            "(eventually[0 s, 1 s] p0) and (p1 until[1 s, inf] p2)",
            vec!["/until.x / 2 < 3", "p", "/and.y > /U/since.x"],
        ),
        ("/a.x[3] /divisor < 3", "p0", vec!["/a.x[3] /divisor < 3"]),
        (
            "not a < b <=> !(c) -> d",
            "(not p0) <=> ((not p1) => p2)",
            vec!["a < b", "c", "d"],
        ),
        ("a<3 and a < 3 or a  <  3", "(p0 and p0) or p0", vec!["a<3"]),
        ("true or false", "true or false", vec![]),
        ("load < 5 % and x", "p0 and p1", vec!["load < 5 %", "x"]),
    ];
    for (text, formula, atoms) in cases {
        let atoms: Vec<String> = atoms.into_iter().map(str::to_owned).collect();
        assert_eq!(shape(text), (formula.to_owned(), atoms), "{text}");
    }
}

#[test]
fn operators_have_aliases_and_precedence() {
    let cases = [
        ("G a", "always p0"),
        ("globally a", "always p0"),
        ("F[0,2 s] a", "eventually[0 s, 2 s] p0"),
        ("a U b and c", "(p0 until p1) and p2"),
        ("a U b U c", "p0 until (p1 until p2)"),
        ("a => b => c", "p0 => (p1 => p2)"),
        ("not F a U b", "(not (eventually p0)) until p1"),
        ("G(a -> F[0,50] b)", "always (p0 => (eventually[0, 50] p1))"),
        ("a S[1 s, inf) b", "p0 since[1 s, inf] p1"),
        ("a W b || a R b", "(p0 weak_until p1) or (p0 release p1)"),
        ("X Y H O a", "next (previous (historically (once p0)))"),
        ("rise(a) and fall (b)", "(rise p0) and (fall p1)"),
        ("always ( (a) )", "always p0"),
    ];
    for (text, formula) in cases {
        assert_eq!(shape(text).0, formula, "{text}");
    }
}

#[test]
fn bounds_have_units_and_parameters() {
    let interval = |text: &str| {
        let named = |name: &str| (name == "release_time").then_some(2.5);
        parse(&format!("F{text} a"), &named)
            .unwrap_or_else(|error| panic!("{error}"))
            .formula
            .interval()
            .unwrap()
    };
    assert_eq!(interval("[0, 500 ms]"), Interval::secs(0.0, 0.5));
    assert_eq!(interval("[1, 2 ms]"), Interval::secs(0.001, 0.002));
    assert_eq!(interval("[3 ms, 1 s]"), Interval::secs(0.003, 1.0));
    assert_eq!(interval("[1 min, 2 h]"), Interval::secs(60.0, 7200.0));
    assert_eq!(interval("[7 us, 9000 ns]"), Interval::secs(7e-6, 9e-6));
    assert_eq!(interval("[0, release_time]"), Interval::secs(0.0, 2.5));
    assert_eq!(interval("[0, 50 samples]"), Interval::samples(0, 50));
    assert_eq!(interval(""), Interval::UNBOUNDED);
    let unstated = |value| Bound {
        value,
        unit: TimeUnit::Unstated,
    };
    assert_eq!(
        interval("[2, inf]"),
        Interval {
            low: unstated(2.0),
            high: None
        }
    );
}

#[test]
fn mistakes_have_a_place_and_a_remedy() {
    let cases = [
        ("", "", "a statement is missing before the end"),
        ("a and", "", "a statement is missing before the end"),
        ("a and or b", "or", "a statement is missing before \"or\""),
        ("(a and b", "(", "this \"(\" is never closed"),
        ("a)", ")", "this \")\" closes nothing"),
        ("F[0, 2 a", "a", "\"a\" is not a unit of time"),
        (
            "F[0, 2 s a",
            "a",
            "\"a\" stands where the interval needs \"]\"",
        ),
        ("F[0 a", "a", "\"a\" is not a unit of time"),
        (
            "F[50] a",
            "]",
            "\"]\" stands where the interval needs \",\"",
        ),
        (
            "F[0, limit] a",
            "limit",
            "\"limit\" is not the name of a duration",
        ),
        (
            "F[3, 2 s] a",
            "[3, 2 s]",
            "the interval [3 s, 2 s] ends before it begins",
        ),
        (
            "F[1 s, 2 samples] a",
            "[1 s, 2 samples]",
            "the interval [1 s, 2 samples] begins in one unit and ends in another",
        ),
        (
            "a < U",
            "U",
            "the operator \"U\" stands where a value is needed",
        ),
        ("a <", "<", "something is missing behind \"<\""),
        ("F<=20 a", "<=", "something is missing before \"<=\""),
        ("a AND b", "AND", "\"AND\" directly follows \"a\""),
        ("min(a, b < 3", "(", "this bracket is never closed"),
        (
            "a, b",
            ",",
            "a comma can only separate the arguments of a function",
        ),
        (
            "a = 'b",
            "'b",
            "the quotation that begins with ' does not end",
        ),
        ("a # b", "#", "'#' means nothing here"),
        ("eventually[0:5] a", ":", "':' means nothing here"),
    ];
    for (text, place, message) in cases {
        let found = error(text);
        assert_eq!(found.message, message, "{text}");
        assert_eq!(&text[found.span.clone()], place, "{text}");
        assert!(!found.remedy.is_empty(), "{text}");
    }
    assert!(error("eventually[0:5] a").remedy.contains("[0, 5 samples]"));
    let shown = error("größe < 3 and").to_string();
    assert!(
        shown.contains("column 14: a statement is missing"),
        "{shown}"
    );
}

#[test]
fn deep_nesting_is_refused_and_not_a_crash() {
    for (open, close) in [
        ("(", ")"),
        ("not ", ""),
        ("a => ", ""),
        ("a U ", ""),
        ("F[0,1] ", ""),
    ] {
        let text = format!("{}a{}", open.repeat(100_000), close.repeat(100_000));
        assert_eq!(
            error(&text).message,
            "the formula is nested too deeply",
            "{open}"
        );
    }
    let long = vec!["a"; 100_000].join(" and ");
    assert_eq!(read(&long).formula.size(), 100_001);
}

fn interval() -> impl Strategy<Value = Interval> {
    prop_oneof![
        Just(Interval::UNBOUNDED),
        (0u32..9, 0u32..9).prop_map(|(low, more)| Interval::samples(low, low + more)),
        (0u32..9, 0u32..9).prop_map(|(low, more)| {
            Interval::secs(f64::from(low) / 7.0, f64::from(low + more) / 7.0)
        }),
        (1u32..9).prop_map(|low| Interval {
            low: Bound::secs(f64::from(low) / 3.0),
            high: None
        }),
    ]
}

fn formula() -> impl Strategy<Value = Formula> {
    let leaf = prop_oneof![
        Just(Formula::True),
        Just(Formula::False),
        (0usize..3).prop_map(Formula::atom)
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let one = (0usize..9, interval(), inner.clone()).prop_map(|(kind, window, inner)| {
            let inner = Box::new(inner);
            match kind {
                0 => Formula::Not(inner),
                1 => Formula::Next(inner),
                2 => Formula::Previous(inner),
                3 => Formula::Rise(inner),
                4 => Formula::Fall(inner),
                5 => Formula::Eventually(window, inner),
                6 => Formula::Always(window, inner),
                7 => Formula::Once(window, inner),
                _ => Formula::Historically(window, inner),
            }
        });
        let two = (0usize..6, interval(), inner.clone(), inner.clone()).prop_map(
            |(kind, window, left, right)| {
                let (left, right) = (Box::new(left), Box::new(right));
                match kind {
                    0 => Formula::Implies(left, right),
                    1 => Formula::Iff(left, right),
                    2 => Formula::Until(window, left, right),
                    3 => Formula::WeakUntil(window, left, right),
                    4 => Formula::Release(window, left, right),
                    _ => Formula::Since(window, left, right),
                }
            },
        );
        let many =
            (any::<bool>(), prop::collection::vec(inner, 2..4)).prop_map(|(and, operands)| {
                if and {
                    Formula::And(operands)
                } else {
                    Formula::Or(operands)
                }
            });
        prop_oneof![one, two, many]
    })
}

proptest! {
    #[test]
    fn printing_keeps_the_formula(formula in formula()) {
        let read_back = read(&formula.to_string());
        let names = read_back.atoms;
        prop_assert_eq!(same_numbers(&read_back.formula, &names), formula.clone());
        prop_assert_eq!(read_back.formula.display(&names).to_string(), formula.to_string());
    }

    #[test]
    fn any_text_gives_a_formula_or_a_mistake_in_it(text in "[aF()&!<>=\\[\\],0-9 s'/._Uü-]{0,24}") {
        match parse(&text, &no_parameters) {
            Ok(parsed) => prop_assert!(parsed.atoms.iter().all(|atom| text[atom.span.clone()] == atom.text)),
            Err(error) => prop_assert!(text.get(error.span).is_some()),
        }
    }
}

/// The formula with atom `pN` numbered N.
fn same_numbers(formula: &Formula, names: &[AtomText]) -> Formula {
    let again = |inner: &Formula| Box::new(same_numbers(inner, names));
    match formula {
        Formula::True => Formula::True,
        Formula::False => Formula::False,
        Formula::Atom(atom) => Formula::atom(
            names[atom.0].text[1..]
                .parse()
                .expect("an atom is printed pN"),
        ),
        Formula::Not(inner) => Formula::Not(again(inner)),
        Formula::Next(inner) => Formula::Next(again(inner)),
        Formula::Previous(inner) => Formula::Previous(again(inner)),
        Formula::Rise(inner) => Formula::Rise(again(inner)),
        Formula::Fall(inner) => Formula::Fall(again(inner)),
        Formula::And(operands) => {
            Formula::And(operands.iter().map(|inner| *again(inner)).collect())
        }
        Formula::Or(operands) => Formula::Or(operands.iter().map(|inner| *again(inner)).collect()),
        Formula::Implies(left, right) => Formula::Implies(again(left), again(right)),
        Formula::Iff(left, right) => Formula::Iff(again(left), again(right)),
        Formula::Eventually(window, inner) => Formula::Eventually(*window, again(inner)),
        Formula::Always(window, inner) => Formula::Always(*window, again(inner)),
        Formula::Once(window, inner) => Formula::Once(*window, again(inner)),
        Formula::Historically(window, inner) => Formula::Historically(*window, again(inner)),
        Formula::Until(window, left, right) => Formula::Until(*window, again(left), again(right)),
        Formula::WeakUntil(window, left, right) => {
            Formula::WeakUntil(*window, again(left), again(right))
        }
        Formula::Release(window, left, right) => {
            Formula::Release(*window, again(left), again(right))
        }
        Formula::Since(window, left, right) => Formula::Since(*window, again(left), again(right)),
    }
}

#[test]
fn windows_of_one_instant_are_found_where_they_ask_for_a_sample() {
    let instants = |text: &str| -> Vec<String> {
        let found = read(text).formula.exact_instants().into_iter();
        found.map(|interval| interval.to_string()).collect()
    };
    assert_eq!(instants("always (p => F[2 s, 2 s] q)"), ["[2 s, 2 s]"]);
    assert_eq!(
        instants("(p S[500 ms, 0.5 s] q) or not H[1, 1 s] (p U[1 s, 2 s] q)"),
        ["[0.5 s, 0.5 s]", "[1 s, 1 s]"]
    );
    for text in [
        "F[0 s, 0 s] p",
        "F[2, 2] p",
        "F[2 samples, 2 samples] p",
        "G[1 s, inf] p",
        "X p",
    ] {
        assert_eq!(instants(text), Vec::<String>::new(), "{text}");
    }
}
