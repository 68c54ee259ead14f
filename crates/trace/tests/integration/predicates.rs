//! Predicates against a plain evaluation of their trees, and what is said of wrong ones.

use proptest::prelude::*;
use trace::{Cursor, Field, Predicate, PredicateErrorKind, Quantity, Trace, Vocabulary};

/// A number in the test's own form.
#[derive(Debug, Clone)]
enum Number {
    Constant(f64),
    Signal(&'static str),
    Negate(Box<Number>),
    Binary(&'static str, Box<Number>, Box<Number>),
    Call(&'static str, Vec<Number>),
}

/// A truth value in the test's own form.
#[derive(Debug, Clone)]
enum Truth {
    Constant(bool),
    Flag(&'static str),
    State(bool, usize),
    Not(Box<Truth>),
    Binary(&'static str, Box<Truth>, Box<Truth>),
    Same(bool, Box<Truth>, Box<Truth>),
    Compare(&'static str, Number, Number),
}

const STATES: [&str; 3] = ["sense", "it's", "wait for it"];
const SIGNALS: [&str; 3] = ["/robot/arm.hand.x", "/robot/arm.speed", "/human.pull"];
const FLAGS: [&str; 2] = ["/robot/arm.crashed", "/human.ready"];

fn quoted_state(index: usize) -> String {
    let quote = if STATES[index].contains('\'') {
        '"'
    } else {
        '\''
    };
    format!("{quote}{}{quote}", STATES[index])
}

/// Levels of precedence, from implication to atoms.
fn wrap(text: String, level: u8, needed: u8) -> String {
    if level < needed {
        format!("({text})")
    } else {
        text
    }
}

/// The text with as few brackets as the precedence allows; `spelling` picks among equal operators.
fn number_text(number: &Number, needed: u8) -> String {
    match number {
        Number::Constant(value) => format!("{value:?}"),
        Number::Signal(name) => (*name).to_owned(),
        Number::Negate(inner) => wrap(format!("-{}", number_text(inner, 7)), 7, needed),
        Number::Binary(operator, left, right) => {
            let level = if matches!(*operator, "+" | "-") { 5 } else { 6 };
            let (left, right) = (number_text(left, level), number_text(right, level + 1));
            wrap(format!("{left} {operator}{right}"), level, needed)
        }
        Number::Call(name, arguments) => {
            let arguments: Vec<String> = arguments.iter().map(|it| number_text(it, 5)).collect();
            format!("{name}({})", arguments.join(", "))
        }
    }
}

fn truth_text(truth: &Truth, needed: u8, words: bool) -> String {
    let spell = |word: &str, sign: &str| {
        if words {
            word.to_owned()
        } else {
            sign.to_owned()
        }
    };
    match truth {
        Truth::Constant(value) => value.to_string(),
        Truth::Flag(name) => (*name).to_owned(),
        Truth::State(equal, index) => {
            let operator = if *equal {
                spell("==", "=")
            } else {
                "!=".to_owned()
            };
            wrap(
                format!("/human.state {operator} {}", quoted_state(*index)),
                4,
                needed,
            )
        }
        Truth::Not(inner) => {
            let inner = truth_text(inner, 3, words);
            wrap(format!("{}{inner}", spell("not ", "!")), 3, needed)
        }
        Truth::Binary(operator, left, right) => {
            let (level, sign) = match *operator {
                "=>" => (0, "=>".to_owned()),
                "|" => (1, spell("or", "||")),
                _ => (2, spell("and", "&")),
            };
            // Implication groups to the right, the others to the left.
            let (before, after) = if level == 0 {
                (1, 0)
            } else {
                (level, level + 1)
            };
            let left = truth_text(left, before, words);
            let right = truth_text(right, after, words);
            wrap(format!("{left} {sign} {right}"), level, needed)
        }
        Truth::Same(equal, left, right) => {
            let operator = if *equal { "=" } else { "!=" };
            let (left, right) = (truth_text(left, 8, words), truth_text(right, 8, words));
            wrap(format!("{left} {operator} {right}"), 4, needed)
        }
        Truth::Compare(operator, left, right) => {
            let text = format!(
                "{} {operator} {}",
                number_text(left, 5),
                number_text(right, 5)
            );
            wrap(text, 4, needed)
        }
    }
}

/// The value of a signal by looking through all rows.
fn lookup(trace: &Trace, name: &str, time_secs: f64) -> Option<f64> {
    let channel = trace.channels.iter().find(|channel| {
        name.strip_prefix(&channel.topic)
            .is_some_and(|rest| rest.starts_with('.'))
    })?;
    let field = channel.field_index(&name[channel.topic.len() + 1..])?;
    let mut value = None;
    for (row, &time) in channel.times_secs.iter().enumerate() {
        if time <= time_secs {
            value = Some(channel.row(row)[field]);
        }
    }
    value.filter(|value| !value.is_nan())
}

fn eval_number(number: &Number, trace: &Trace, time_secs: f64) -> Option<f64> {
    let eval = |number: &Number| eval_number(number, trace, time_secs);
    let value = match number {
        Number::Constant(value) => *value,
        Number::Signal(name) => lookup(trace, name, time_secs)?,
        Number::Negate(inner) => -eval(inner)?,
        Number::Binary(operator, left, right) => {
            let (left, right) = (eval(left)?, eval(right)?);
            match *operator {
                "+" => left + right,
                "-" => left - right,
                "*" => left * right,
                _ if right == 0.0 => return None,
                _ => left / right,
            }
        }
        Number::Call(name, arguments) => {
            let values: Option<Vec<f64>> = arguments.iter().map(eval).collect();
            let values = values?;
            match *name {
                "abs" => values[0].abs(),
                "min" => values.iter().copied().reduce(f64::min)?,
                "max" => values.iter().copied().reduce(f64::max)?,
                _ => values.iter().map(|value| value * value).sum::<f64>().sqrt(),
            }
        }
    };
    (!value.is_nan()).then_some(value)
}

fn eval_truth(truth: &Truth, trace: &Trace, time_secs: f64) -> Option<bool> {
    let eval = |truth: &Truth| eval_truth(truth, trace, time_secs);
    match truth {
        Truth::Constant(value) => Some(*value),
        Truth::Flag(name) => lookup(trace, name, time_secs).map(|value| value == 1.0),
        Truth::State(equal, index) => {
            lookup(trace, "/human.state", time_secs).map(|it| (it == *index as f64) == *equal)
        }
        Truth::Not(inner) => eval(inner).map(|value| !value),
        Truth::Binary(operator, left, right) => {
            let (left, right) = (eval(left), eval(right));
            let left = if *operator == "=>" {
                left.map(|value| !value)
            } else {
                left
            };
            // What decides the connective alone, on either side.
            let decisive = *operator != "&";
            if left == Some(decisive) || right == Some(decisive) {
                Some(decisive)
            } else {
                left.and(right).map(|_| !decisive)
            }
        }
        Truth::Same(equal, left, right) => Some((eval(left)? == eval(right)?) == *equal),
        Truth::Compare(operator, left, right) => {
            let left = eval_number(left, trace, time_secs)?;
            let right = eval_number(right, trace, time_secs)?;
            Some(match *operator {
                "=" => left == right,
                "!=" => left != right,
                "<" => left < right,
                "<=" => left <= right,
                ">" => left > right,
                _ => left >= right,
            })
        }
    }
}

fn number() -> impl Strategy<Value = Number> {
    let leaf = prop_oneof![
        prop_oneof![Just(0.0), Just(1.0), Just(2.5), Just(1e-3), Just(1e300)]
            .prop_map(Number::Constant),
        prop::sample::select(&SIGNALS[..]).prop_map(Number::Signal),
    ];
    leaf.prop_recursive(4, 16, 3, |inner| {
        let operator = prop::sample::select(&["+", "-", "*", "/"][..]);
        let name = prop::sample::select(&["min", "max", "norm"][..]);
        prop_oneof![
            inner.clone().prop_map(|it| Number::Negate(Box::new(it))),
            (operator, inner.clone(), inner.clone()).prop_map(|(operator, left, right)| {
                Number::Binary(operator, Box::new(left), Box::new(right))
            }),
            inner.clone().prop_map(|it| Number::Call("abs", vec![it])),
            (name, prop::collection::vec(inner, 1..4))
                .prop_map(|(name, arguments)| Number::Call(name, arguments)),
        ]
    })
}

fn truth() -> impl Strategy<Value = Truth> {
    let comparison = prop::sample::select(&["=", "!=", "<", "<=", ">", ">="][..]);
    let leaf = prop_oneof![
        any::<bool>().prop_map(Truth::Constant),
        prop::sample::select(&FLAGS[..]).prop_map(Truth::Flag),
        (any::<bool>(), 0..STATES.len()).prop_map(|(equal, state)| Truth::State(equal, state)),
        (comparison, number(), number())
            .prop_map(|(operator, left, right)| Truth::Compare(operator, left, right)),
    ];
    leaf.prop_recursive(5, 32, 2, |inner| {
        let operator = prop::sample::select(&["&", "|", "=>"][..]);
        prop_oneof![
            inner.clone().prop_map(|it| Truth::Not(Box::new(it))),
            (operator, inner.clone(), inner.clone()).prop_map(|(operator, left, right)| {
                Truth::Binary(operator, Box::new(left), Box::new(right))
            }),
            (any::<bool>(), inner.clone(), inner).prop_map(|(equal, left, right)| {
                Truth::Same(equal, Box::new(left), Box::new(right))
            }),
        ]
    })
}

/// Signals whose units are not declared, so that any of them go together; `units.rs` has others.
fn layout() -> Trace {
    let mut trace = Trace::new();
    let arm = vec![
        Field::number("hand.x", ""),
        Field::number("speed", ""),
        Field::bool("crashed"),
    ];
    trace.add_channel("/robot/arm", arm).unwrap();
    let human = vec![
        Field::number("pull", ""),
        Field::bool("ready"),
        Field::enumeration("state", STATES),
    ];
    trace.add_channel("/human", human).unwrap();
    trace
}

/// A recording of a few rows with small values, some missing, some at equal times.
fn recording() -> impl Strategy<Value = Trace> {
    let value = || prop_oneof![4 => (-2..3_i32).prop_map(f64::from), 1 => Just(f64::NAN)];
    let flag = || prop_oneof![4 => (0..2_i32).prop_map(f64::from), 1 => Just(f64::NAN)];
    let state = prop_oneof![4 => (0..3_i32).prop_map(f64::from), 1 => Just(f64::NAN)];
    let arm = prop::collection::vec((0..6_i32, value(), value(), flag()), 0..5);
    let human = prop::collection::vec((0..6_i32, value(), flag(), state), 0..5);
    (arm, human).prop_map(|(mut arm, mut human)| {
        let mut trace = layout();
        arm.sort_by_key(|row| row.0);
        human.sort_by_key(|row| row.0);
        for (index, rows) in [arm, human].into_iter().enumerate() {
            for (time, first, second, third) in rows {
                trace.channels[index]
                    .push(f64::from(time), &[first, second, third])
                    .unwrap();
            }
        }
        trace
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn predicates_mean_what_their_trees_mean(
        truth in truth(), trace in recording(), words in any::<bool>(),
    ) {
        let text = truth_text(&truth, 0, words);
        let predicate = Predicate::parse(&text).map_err(|it| TestCaseError::fail(it.to_string()))?;
        let bound = predicate.bind(&trace).map_err(|it| TestCaseError::fail(it.to_string()))?;
        // The layout alone is enough to bind to.
        prop_assert_eq!(&bound, &predicate.bind(&layout()).unwrap());
        let mut cursor = Cursor::new(&trace);
        // Forwards, and then back and forth.
        for half in [-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 4, 5, -1, 9] {
            let time_secs = f64::from(half) / 2.0;
            cursor.seek(time_secs);
            let expected = eval_truth(&truth, &trace, time_secs);
            prop_assert_eq!(bound.eval(&cursor), expected, "{} at {}", text, time_secs);
        }
    }

    #[test]
    fn quantities_mean_what_their_trees_mean(number in number(), trace in recording()) {
        let text = number_text(&number, 5);
        let quantity = Quantity::parse(&text).map_err(|it| TestCaseError::fail(it.to_string()))?;
        let bound = quantity.bind(&trace).map_err(|it| TestCaseError::fail(it.to_string()))?;
        let mut cursor = Cursor::new(&trace);
        for time_secs in [0.0, 2.0, 7.0] {
            cursor.seek(time_secs);
            let expected = eval_number(&number, &trace, time_secs).map(f64::to_bits);
            let found = bound.eval(&cursor).map(f64::to_bits);
            prop_assert_eq!(found, expected, "{} at {}", text, time_secs);
        }
    }

    #[test]
    fn any_text_is_parsed_without_panic(text in "[-/a-z0-9.()&|!=<>'\"` ,+*é^%°²]{0,40}") {
        if let Ok(predicate) = Predicate::parse(&text) {
            let _ = predicate.bind(&layout());
        }
        let _ = Vocabulary::new([("a", text.as_str()), ("b", "a & c"), ("c", "true")]);
    }
}

/// What is said of `text`, in the vocabulary `near`, `pull`.
fn error(text: &str) -> String {
    let vocabulary =
        Vocabulary::new([("near", "/robot/arm.hand.x < 0.1"), ("pull", "/human.pull")]).unwrap();
    let bound = vocabulary
        .predicate(text)
        .and_then(|predicate| predicate.bind(&layout()));
    bound.expect_err("it is wrong").to_string()
}

#[test]
fn errors_name_the_place_and_the_remedy() {
    let cases = [
        ("", "column 1: found the end, where a number, a signal"),
        ("/human.pull >", "column 14: found the end"),
        ("near &", "column 7: found the end"),
        (
            "near near",
            "column 6: found the name near, where an operator or the end",
        ),
        (
            "(near",
            "column 6: found the end, where an operator or \")\"",
        ),
        ("near # now", "column 6: found '#'"),
        ("0 < pull < 1", "column 10: comparisons cannot be chained"),
        (
            "pull < 5cmm",
            "column 8: there is no unit cmm; did you mean mm?",
        ),
        ("pull < 1.2.3", "found \"1.2.3\""),
        ("pull < 1e999", "found \"1e999\""),
        (
            "/human.state = 'sense",
            "column 16: this quote is not closed",
        ),
        (
            "/human.stat = 'sense'",
            "no signal /human.stat; did you mean /human.state?",
        ),
        (
            "/wrench.torque > 1",
            "no signal /wrench.torque; list its signals",
        ),
        ("nera", "the name nera; did you mean near?"),
        ("hypot(1, 2) > 1", "there is no function hypot"),
        ("mim(1, 2) > 1", "no function mim; did you mean min?"),
        ("abs(1, 2) > 1", "abs has the wrong arguments; write abs(a)"),
        ("distance(1, 2) > 1", "distance has the wrong arguments"),
        (
            "distance(/human, /robot/arm) > 1",
            "column 10: the trace has no signal /human.x",
        ),
        (
            "/human.state = 'sens'",
            "column 16: there is no value 'sens' here; there are 'sense'",
        ),
        (
            "pull",
            "column 1: this is a number, where something true or false",
        ),
        (
            "near + 1 > 2",
            "column 1: this is a truth value, where a number",
        ),
        (
            "near & /human.state",
            "column 8: this is a value of an enumeration",
        ),
        (
            "near = 1",
            "a truth value cannot be compared so with a number",
        ),
        (
            "near < /human.ready",
            "a truth value cannot be compared so with a truth value",
        ),
        (
            "/human.state > 'sense'",
            "cannot be compared so with the name 'sense'",
        ),
        ("'sense' = 'sense'", "cannot be compared so"),
        ("é & near", "column 1: nothing is defined with the name é"),
    ];
    for (text, expected) in cases {
        let message = error(text);
        assert!(message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn slashes_divide_behind_operands_and_begin_signals_elsewhere() {
    let mut trace = layout();
    trace.channels[0].push(0.0, &[6.0, 2.0, 0.0]).unwrap();
    trace.channels[1].push(0.0, &[3.0, 1.0, 0.0]).unwrap();
    let mut cursor = Cursor::new(&trace);
    cursor.seek(0.0);
    let cases = [
        ("/robot/arm.hand.x/2", 3.0),
        ("/robot/arm.hand.x/ /human.pull", 2.0),
        ("/robot/arm.hand.x//human.pull", 2.0),
        ("12 / /robot/arm.hand.x / /robot/arm.speed", 1.0),
        ("(1 + 2)/`/human.pull`", 1.0),
        ("2 - 3 - 4", -5.0),
        ("-2 * -3", 6.0),
        ("norm(3, 4, 12)", 13.0),
    ];
    for (text, expected) in cases {
        let quantity = Quantity::parse(text).unwrap().bind(&trace).unwrap();
        assert_eq!(quantity.eval(&cursor), Some(expected), "{text}");
    }
}

#[test]
fn distance_is_between_places() {
    let mut trace = Trace::new();
    let place =
        |prefix: &str| ["x", "y", "z"].map(|it| Field::number(format!("{prefix}{it}"), "m"));
    trace.add_channel("/hand", place("").to_vec()).unwrap();
    trace
        .add_channel("/truth", place("object.").to_vec())
        .unwrap();
    trace.channels[0].push(0.0, &[1.0, 2.0, 3.0]).unwrap();
    trace.channels[1].push(0.0, &[3.0, 5.0, 9.0]).unwrap();
    let distance = Quantity::parse("distance(/hand, /truth.object)").unwrap();
    let signals: Vec<String> = distance.signals().into_iter().collect();
    assert_eq!(signals.len(), 6);
    assert!(signals.contains(&"/truth.object.z".to_owned()));
    let distance = distance.bind(&trace).unwrap();
    let mut cursor = Cursor::new(&trace);
    cursor.seek(1.0);
    assert_eq!(distance.eval(&cursor), Some(7.0));
}

#[test]
fn vocabularies_find_circles_and_unknown_names() {
    let kinds = |entries: &[(&str, &str)]| -> Vec<PredicateErrorKind> {
        let errors = Vocabulary::new(entries.iter().copied()).unwrap_err();
        errors.into_iter().map(|error| error.kind).collect()
    };
    let cycle = |names: &[&str]| PredicateErrorKind::Cycle {
        names: names.iter().map(|name| (*name).to_owned()).collect(),
    };
    assert_eq!(kinds(&[("a", "!a")]), [cycle(&["a", "a"])]);
    assert_eq!(
        kinds(&[("a", "b & d"), ("b", "true | c"), ("c", "a"), ("d", "true")]),
        [cycle(&["a", "b", "c", "a"])]
    );
    assert_eq!(kinds(&[("a", "b"), ("b", "b & c"), ("c", "c")]).len(), 2);
    let errors = kinds(&[("a", "x & y"), ("b", "(")]);
    assert!(matches!(
        errors[..],
        [PredicateErrorKind::Unexpected { .. }]
    ));
    let errors = kinds(&[("a", "x & y"), ("b", "a")]);
    assert!(
        matches!(&errors[..], [PredicateErrorKind::UnknownName { name, .. }, _] if name == "x")
    );
    for bad in ["", "1a", "a b", "not", "min", "/a"] {
        let errors = kinds(&[(bad, "true")]);
        assert!(
            matches!(errors[..], [PredicateErrorKind::BadName { .. }]),
            "{bad}"
        );
    }
    let errors = kinds(&[("a", "true"), ("a", "false")]);
    assert!(matches!(
        errors[..],
        [PredicateErrorKind::DuplicateName { .. }]
    ));
}

#[test]
fn names_expand_with_their_own_places() {
    let vocabulary = Vocabulary::new([
        ("reach", "norm(/robot/arm.hand.x, /robot/arm.speed)"),
        ("near", "reach < 0.1 & /human.redy"),
        ("safe", "near => /human.pull < 1"),
    ])
    .unwrap();
    let safe = vocabulary.predicate("safe").unwrap();
    let signals: Vec<String> = safe.signals().into_iter().collect();
    let expected = [
        "/human.pull",
        "/human.redy",
        "/robot/arm.hand.x",
        "/robot/arm.speed",
    ];
    assert_eq!(signals, expected);
    let error = safe.bind(&layout()).unwrap_err();
    assert_eq!(error.entry.as_deref(), Some("near"));
    assert_eq!(&error.text[error.span.clone()], "/human.redy");
}

#[test]
fn what_is_too_large_is_refused() {
    let deep = format!("{}true{}", "(".repeat(100_000), ")".repeat(100_000));
    assert_eq!(
        Predicate::parse(&deep).unwrap_err().kind,
        PredicateErrorKind::TooLarge
    );
    let minus = format!("{}1 > 0", "-".repeat(100_000));
    assert_eq!(
        Predicate::parse(&minus).unwrap_err().kind,
        PredicateErrorKind::TooLarge
    );
    let long = vec!["true"; 100_000].join(" & ");
    assert_eq!(
        Predicate::parse(&long).unwrap_err().kind,
        PredicateErrorKind::TooLarge
    );
    assert!(Predicate::parse(&vec!["true"; 200].join(" & ")).is_ok());
    // Each entry doubles the one before.
    let entries = (1..60).map(|it| (format!("e{it}"), format!("e{0} & e{0}", it - 1)));
    let entries = entries.chain([("e0".to_owned(), "true".to_owned())]);
    let doubled = Vocabulary::new(entries).unwrap().predicate("e59").unwrap();
    assert_eq!(
        doubled.bind(&layout()).unwrap_err().kind,
        PredicateErrorKind::TooLarge
    );
}
