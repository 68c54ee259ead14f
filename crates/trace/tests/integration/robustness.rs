//! Robustness against its definition, and its agreement with truth, over random predicates.

use proptest::prelude::*;
use trace::{Field, Predicate, SignalIndex, SignalValues, Trace};

/// A number in the test's own form, in metres.
#[derive(Debug, Clone)]
enum Number {
    /// Centimetres, written so.
    Constant(i32),
    /// A signal in m or mm, by its position.
    Signal(usize),
    Difference(Box<Number>, Box<Number>),
    Greatest(Box<Number>, Box<Number>),
}

/// A truth value in the test's own form.
#[derive(Debug, Clone)]
enum Truth {
    Flag(usize),
    State(bool, usize),
    Not(Box<Truth>),
    Binary(&'static str, Box<Truth>, Box<Truth>),
    Same(bool, Box<Truth>, Box<Truth>),
    Compare(&'static str, Number, Number),
}

const NUMBERS: [&str; 3] = ["/a.x", "/a.y", "/b.far"];
const FLAGS: [&str; 2] = ["/a.ready", "/b.ready"];
const STATES: [&str; 2] = ["open", "closed"];

fn layout() -> Trace {
    let mut trace = Trace::new();
    let near = vec![
        Field::number("x", "m"),
        Field::number("y", "m"),
        Field::bool("ready"),
    ];
    trace.add_channel("/a", near).expect("it is well-formed");
    let far = vec![
        Field::number("far", "mm"),
        Field::bool("ready"),
        Field::enumeration("state", STATES),
    ];
    trace.add_channel("/b", far).expect("it is well-formed");
    trace
}

/// Values for the six signals of the layout, some missing.
#[derive(Debug, Clone)]
struct Values([f64; 6]);

impl SignalValues for Values {
    fn raw(&self, signal: SignalIndex) -> f64 {
        self.0[signal.channel * 3 + signal.field]
    }
}

fn number_text(number: &Number) -> String {
    match number {
        Number::Constant(centimetres) => format!("({centimetres} cm)"),
        Number::Signal(index) => NUMBERS[*index].to_owned(),
        Number::Difference(left, right) => {
            format!("({} - {})", number_text(left), number_text(right))
        }
        Number::Greatest(left, right) => {
            format!("max({}, {})", number_text(left), number_text(right))
        }
    }
}

fn truth_text(truth: &Truth) -> String {
    match truth {
        Truth::Flag(index) => FLAGS[*index].to_owned(),
        Truth::State(equal, index) => {
            let operator = if *equal { "=" } else { "!=" };
            format!("/b.state {operator} '{}'", STATES[*index])
        }
        Truth::Not(inner) => format!("!({})", truth_text(inner)),
        Truth::Binary(operator, left, right) => {
            format!("({}) {operator} ({})", truth_text(left), truth_text(right))
        }
        Truth::Same(equal, left, right) => {
            let operator = if *equal { "=" } else { "!=" };
            format!(
                "(({}) {operator} ({}))",
                truth_text(left),
                truth_text(right)
            )
        }
        Truth::Compare(operator, left, right) => {
            format!("{} {operator} {}", number_text(left), number_text(right))
        }
    }
}

/// The value in metres.
fn eval(number: &Number, values: &Values) -> Option<f64> {
    let value = match number {
        Number::Constant(centimetres) => f64::from(*centimetres) / 100.0,
        Number::Signal(index) => [values.0[0], values.0[1], values.0[3] / 1000.0][*index],
        Number::Difference(left, right) => eval(left, values)? - eval(right, values)?,
        Number::Greatest(left, right) => eval(left, values)?.max(eval(right, values)?),
    };
    (!value.is_nan()).then_some(value)
}

/// The interval in which the robustness lies, whatever the missing values are; by the definition,
/// with unknown parts anywhere between minus and plus infinity.
fn bounds(truth: &Truth, values: &Values) -> (f64, f64) {
    const INFINITE: f64 = f64::INFINITY;
    let sure = |value: Option<bool>| match value {
        Some(true) => (INFINITE, INFINITE),
        Some(false) => (-INFINITE, -INFINITE),
        None => (-INFINITE, INFINITE),
    };
    let flag = |value: f64| (!value.is_nan()).then_some(value == 1.0);
    let negated = |(low, high): (f64, f64)| (-high, -low);
    let both = |left: (f64, f64), right: (f64, f64)| (left.0.min(right.0), left.1.min(right.1));
    match truth {
        Truth::Flag(index) => sure(flag([values.0[2], values.0[4]][*index])),
        Truth::State(equal, index) => {
            let state = values.0[5];
            sure((!state.is_nan()).then_some((state == *index as f64) == *equal))
        }
        Truth::Not(inner) => negated(bounds(inner, values)),
        Truth::Binary(operator, left, right) => {
            let (left, right) = (bounds(left, values), bounds(right, values));
            match *operator {
                "&" => both(left, right),
                "|" => negated(both(negated(left), negated(right))),
                _ => negated(both(left, negated(right))),
            }
        }
        Truth::Same(equal, left, right) => {
            let (left, right) = (bounds(left, values), bounds(right, values));
            let (yes, no) = (both(left, right), both(negated(left), negated(right)));
            let same = (yes.0.max(no.0), yes.1.max(no.1));
            if *equal { same } else { negated(same) }
        }
        Truth::Compare(operator, left, right) => {
            let (Some(left), Some(right)) = (eval(left, values), eval(right, values)) else {
                return (-INFINITE, INFINITE);
            };
            let value = match *operator {
                "<" | "<=" => right - left,
                ">" | ">=" => left - right,
                "=" => -(left - right).abs(),
                _ => (left - right).abs(),
            };
            (value, value)
        }
    }
}

fn number() -> impl Strategy<Value = Number> {
    let leaf = prop_oneof![
        (-200..200_i32).prop_map(Number::Constant),
        (0..NUMBERS.len()).prop_map(Number::Signal),
    ];
    leaf.prop_recursive(2, 6, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone())
                .prop_map(|(left, right)| Number::Difference(Box::new(left), Box::new(right))),
            (inner.clone(), inner)
                .prop_map(|(left, right)| Number::Greatest(Box::new(left), Box::new(right))),
        ]
    })
}

fn truth() -> impl Strategy<Value = Truth> {
    let comparison = prop::sample::select(&["=", "!=", "<", "<=", ">", ">="][..]);
    let leaf = prop_oneof![
        1 => (0..FLAGS.len()).prop_map(Truth::Flag),
        1 => (any::<bool>(), 0..STATES.len()).prop_map(|(equal, state)| Truth::State(equal, state)),
        4 => (comparison, number(), number())
            .prop_map(|(operator, left, right)| Truth::Compare(operator, left, right)),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
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

fn values() -> impl Strategy<Value = Values> {
    let number = || prop_oneof![5 => (-200..200_i32).prop_map(|it| f64::from(it) / 100.0), 1 => Just(f64::NAN)];
    let flag = || prop_oneof![5 => (0..2_i32).prop_map(f64::from), 1 => Just(f64::NAN)];
    (number(), number(), flag(), number(), flag(), flag()).prop_map(
        |(x, y, first, far, second, state)| {
            // The third number is in mm.
            Values([x, y, first, far * 1000.0, second, state])
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn robustness_is_what_it_is_defined_to_be(truth in truth(), values in values()) {
        let text = truth_text(&truth);
        let bound = Predicate::parse(&text).and_then(|predicate| predicate.bind(&layout()));
        let bound = bound.map_err(|error| TestCaseError::fail(error.to_string()))?;
        let (found, robustness) = (bound.eval(&values), bound.robustness(&values));
        prop_assert_eq!(bound.judge(&values), found.zip(robustness), "{}", text);
        prop_assert_eq!(found.is_some(), robustness.is_some(), "{}", text);
        let (low, high) = bounds(&truth, &values);
        // Numbers are rounded to doubles, in metres here and in metres or millimetres there.
        let near = |left: f64, right: f64| left == right || (left - right).abs() < 1e-12;
        match (found, robustness) {
            (Some(truth), Some(robustness)) => {
                prop_assert!(if truth { robustness >= 0.0 } else { robustness <= 0.0 }, "{}: {}", text, robustness);
                // What is left out as unknown can only make it greater in size.
                let expected = if truth { low } else { high };
                prop_assert!(near(robustness, expected), "{}: {} not in {} to {}", text, robustness, low, high);
            }
            _ => prop_assert!(low <= 1e-12 && high >= -1e-12, "{}: {} to {}", text, low, high),
        }
    }

    #[test]
    fn what_is_responsible_suffices(truth in truth(), values in values()) {
        let text = truth_text(&truth);
        let bound = Predicate::parse(&text).and_then(|predicate| predicate.bind(&layout()));
        let bound = bound.map_err(|error| TestCaseError::fail(error.to_string()))?;
        let (found, all) = (bound.responsible(&values), bound.signals());
        prop_assert!(found.iter().all(|signal| all.contains(signal)));
        prop_assert_eq!(bound.eval(&values).is_none() && !found.is_empty(), false);
        // The others may as well be missing.
        let kept = |signals: &[SignalIndex]| {
            let mut kept = [f64::NAN; 6];
            for signal in signals {
                kept[signal.channel * 3 + signal.field] = values.raw(*signal);
            }
            bound.eval(&Values(kept))
        };
        prop_assert_eq!(kept(&found), bound.eval(&values), "{}", text);
        prop_assert_eq!(kept(&all), bound.eval(&values), "{}", text);
    }

    #[test]
    fn limits_in_other_units_leave_robustness_as_it_is(limit in 1..5000_u32, metres in -3.0..3.0_f64) {
        let values = Values([metres, 0.0, 0.0, metres * 1000.0, 0.0, 0.0]);
        let robustness = |text: &str| {
            let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout()));
            bound.expect("it is well-formed").robustness(&values).expect("all is known")
        };
        let expected = robustness(&format!("/a.x < {limit}e-3"));
        prop_assert_eq!(robustness(&format!("/a.x < {limit} mm")).to_bits(), expected.to_bits());
        prop_assert_eq!(robustness(&format!("/a.x < {limit}e-6 km")).to_bits(), expected.to_bits());
        let near = |text: String| (robustness(&text) - expected).abs() < 1e-12;
        let (united, bare) = (format!("/b.far < {limit} mm"), format!("/b.far < {limit}"));
        prop_assert!(near(united) && near(bare));
    }
}

#[test]
fn the_border_and_the_extremes() {
    let values = Values([1.0, f64::INFINITY, 1.0, 1000.0, 0.0, f64::NAN]);
    let judged = |text: &str| {
        let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout()));
        bound
            .unwrap_or_else(|error| panic!("{error}"))
            .judge(&values)
    };
    assert_eq!(judged("/a.x < 1 m"), Some((false, 0.0)));
    assert_eq!(judged("/a.x <= 1 m"), Some((true, 0.0)));
    assert_eq!(judged("/a.x = /b.far"), Some((true, 0.0)));
    assert_eq!(judged("/a.x != 75 cm"), Some((true, 0.25)));
    assert_eq!(judged("/a.y > 5 m"), Some((true, f64::INFINITY)));
    assert_eq!(judged("/a.y > /a.y"), Some((false, 0.0)));
    assert_eq!(judged("/a.ready"), Some((true, f64::INFINITY)));
    assert_eq!(judged("/b.state = 'open'"), None);
    // The unknown state cannot make this true, so at least 0.5 m are missing.
    assert_eq!(
        judged("/a.x < 50 cm & /b.state = 'open'"),
        Some((false, -0.5))
    );
    assert_eq!(judged("/a.x < 50 cm | /b.state = 'open'"), None);
    assert_eq!(
        judged("/a.x > 50 cm | /b.state = 'open'"),
        Some((true, 0.5))
    );
}

#[test]
fn the_signals_that_decide() {
    let values = Values([1.0, 2.0, 1.0, 3000.0, 0.0, f64::NAN]);
    let layout = layout();
    let names = |text: &str| -> Vec<String> {
        let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout));
        let found = bound
            .unwrap_or_else(|error| panic!("{error}"))
            .responsible(&values);
        let all: Vec<String> = layout.signal_names().collect();
        found
            .iter()
            .map(|it| all[it.channel * 3 + it.field].clone())
            .collect()
    };
    assert_eq!(names("/a.x < 50 cm & /a.y < 5 m"), ["/a.x"]);
    assert_eq!(names("/a.x < 50 cm & /a.y < 1 m"), ["/a.x", "/a.y"]);
    assert_eq!(names("/a.x < 5 m & /a.y < 5 m & true"), ["/a.x", "/a.y"]);
    assert_eq!(
        names("/a.x < 50 cm | /b.far - /a.x > 1 m"),
        ["/b.far", "/a.x"]
    );
    assert_eq!(names("!(/a.ready => /b.ready)"), ["/a.ready", "/b.ready"]);
    assert_eq!(names("/b.state = 'open' & /b.ready"), ["/b.ready"]);
    assert_eq!(names("/b.state = 'open'"), [""; 0]);
}

#[test]
fn the_dimension_of_the_robustness() {
    let dimension = |text: &str| {
        let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout()));
        let found = bound
            .unwrap_or_else(|error| panic!("{error}"))
            .robustness_dimension();
        found.map(|dimension| dimension.to_string())
    };
    assert_eq!(
        dimension("/a.x < 1 m & /b.far > 2 mm & /a.ready").as_deref(),
        Some("length")
    );
    assert_eq!(dimension("/a.x < 1 m & /a.x * /a.y > 2 mm^2"), None);
    assert_eq!(dimension("/a.ready"), None);
}
