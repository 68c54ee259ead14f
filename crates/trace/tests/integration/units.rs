//! Units: conversion against exact arithmetic, and predicates over signals with units.

use proptest::prelude::*;
use trace::units::{Dimension, QuantityValue, Unit};
use trace::{Cursor, Field, Parameters, Predicate, PredicateErrorKind, Trace, Vocabulary};

fn unit(text: &str) -> Unit {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

fn value(text: &str) -> QuantityValue {
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn si_values() {
    // By hand from the definitions of the SI brochure and NIST SP 811.
    let cases = [
        ("250 mm/s", 0.25),
        ("250mm/s", 0.25),
        ("10 cm", 0.1),
        ("3.6 km/h", 1.0),
        ("0.9 km/h", 0.25),
        ("-40 mm", -0.04),
        ("1e3 us", 1e-3),
        ("500 ms", 0.5),
        ("2 min", 120.0),
        ("1.5 h", 5400.0),
        ("20 g", 0.02),
        ("1.2 kN", 1200.0),
        ("140 N/cm^2", 1.4e6),
        ("140 N/cm2", 1.4e6),
        ("0.1 MPa", 1e5),
        ("5 N*m", 5.0),
        ("5 N m", 5.0),
        ("5 N\u{b7}m", 5.0),
        ("50 mNm", 0.05),
        ("2 kW h", 7.2e6),
        ("2 kWh", 7.2e6),
        ("9.81 m/s\u{b2}", 9.81),
        ("9.81 m s^-2", 9.81),
        ("9.81 m s\u{207b}\u{b2}", 9.81),
        ("4 mm\u{b2}", 4e-6),
        ("2 J/(kg*K)", 2.0),
        ("2 J/kg/K", 2.0),
        ("3 1/min", 0.05),
        ("50 %", 0.5),
        ("1 in", 0.0254),
        ("12 inches", 0.3048),
        ("1 ft", 0.3048),
        ("60 mph", 26.8224),
        ("1 lb", 0.453_592_37),
        ("1 lbf", 4.448_221_615_260_5),
        ("1 gn", 9.80665),
        ("2 L", 0.002),
        ("1 bar", 1e5),
        ("1 hPa", 100.0),
        ("7", 7.0),
        ("+7 1", 7.0),
    ];
    for (text, expected) in cases {
        assert_eq!(value(text).si_value(), expected, "{text}");
    }
    let pi = std::f64::consts::PI;
    for (text, expected) in [
        ("180 deg", pi),
        ("40\u{b0}", pi * 2.0 / 9.0),
        ("1 rev", 2.0 * pi),
        ("30 rpm", pi),
        ("1 psi", 6_894.757_293_168_361),
    ] {
        let found = value(text).si_value();
        assert!(
            (found - expected).abs() <= 2.0 * f64::EPSILON * expected,
            "{text}: {found}"
        );
    }
}

#[test]
fn dimensions_have_names_and_units() {
    let cases = [
        ("mm/s", "speed", "m/s"),
        ("N", "force", "N"),
        ("N*m", "energy or torque", "N*m"),
        ("N/cm^2", "pressure", "Pa"),
        ("deg/s", "angular speed", "rad/s"),
        ("rpm", "angular speed", "rad/s"),
        ("%", "plain number", "1"),
        ("V", "voltage", "V"),
        ("kg*m/(s*K)", "m*kg/(s*K)", "m*kg/(s*K)"),
        ("1/m^2", "1/m^2", "1/m^2"),
    ];
    for (text, name, si_unit) in cases {
        let dimension = unit(text).dimension();
        assert_eq!(dimension.to_string(), name, "{text}");
        assert_eq!(dimension.si_unit(), si_unit, "{text}");
        // The coherent unit can be read again.
        assert!(unit(si_unit).same_as(&Unit::coherent(dimension)), "{text}");
    }
    assert_eq!(unit("m/s").dimension(), Dimension::of(1, 0, -1));
}

#[test]
fn wrong_units_are_refused_with_a_remedy() {
    let cases = [
        ("", "no finite number"),
        ("mm", "no finite number"),
        ("1e999 m", "no finite number"),
        ("0x10", "no unit x10"),
        ("nan", "no finite number"),
        ("inf", "no finite number"),
        ("5 mms", "no unit mms; did you mean mm?"),
        ("5 mvolt", "no unit mvolt"),
        ("5 furlongs", "no unit furlongs; write SI units"),
        ("5 m/", "this is not a unit"),
        ("5 m/q", "no unit q"),
        ("5 m/s*kg", "can be read in two ways"),
        ("5 m/s kg", "can be read in two ways"),
        ("5 (m", "this is not a unit"),
        ("5 m)", "this is not a unit"),
        ("5 m^", "this is not a unit"),
        ("5 m^2^2", "this is not a unit"),
        ("5 m^200", "this is not a unit"),
        ("5 m200", "no unit m200"),
        ("5 m^99*m^99", "too large"),
        ("5 km^99", "too large"),
        ("20 degC", "degC is a scale with an offset"),
        ("20 \u{b0}C", "scale with an offset"),
        ("0,5 m", "this is not a unit"),
        ("5 mm 3", "this is not a unit"),
    ];
    for (text, expected) in cases {
        let error = text.parse::<QuantityValue>().expect_err(text);
        assert!(error.to_string().contains(expected), "{text}: {error}");
        assert!(
            error.text.get(error.span.clone()).is_some(),
            "{text}: {error:?}"
        );
    }
}

/// Decimal texts with up to 15 digits.
fn decimal() -> impl Strategy<Value = (u64, i32)> {
    (1..1_000_000_000_000_000_u64, -18..4_i32)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn prefixes_move_the_point_exactly((digits, exponent) in decimal()) {
        for (prefixed, shift) in [("mm", -3), ("cm", -2), ("km", 3), ("um", -6), ("nm", -9)] {
            let found = value(&format!("{digits}e{exponent} {prefixed}"));
            // Reading the shifted number rounds once.
            let expected: f64 = format!("{digits}e{}", exponent + shift).parse().unwrap();
            prop_assert_eq!(found.si_value().to_bits(), expected.to_bits(), "{}", found);
            prop_assert_eq!(found.value_in(&unit(prefixed)), Some(found.number()));
        }
    }

    #[test]
    fn rational_factors_round_once(thousandths in 1..1_000_000_u64) {
        // v km/h is 5 v / 18 m/s; with v = n / 1000 that is 5 n / 18000, both exact as doubles.
        let text = format!("{}.{:03} km/h", thousandths / 1000, thousandths % 1000);
        let expected = (5 * thousandths) as f64 / 18_000.0;
        prop_assert_eq!(value(&text).si_value().to_bits(), expected.to_bits(), "{}", text);
    }

    #[test]
    fn there_and_back_again(digits in 1..1_000_000_u32, at in 0..6_usize, to in 0..6_usize) {
        let lengths = ["m", "mm", "km", "in", "ft", "mi"];
        let (from, to) = (unit(lengths[at]), unit(lengths[to]));
        let there = from.conversion_to(&to).expect("both are lengths");
        let back = to.conversion_to(&from).expect("both are lengths");
        let number = f64::from(digits);
        let returned = back.apply(there.apply(number));
        prop_assert!((returned - number).abs() <= 4.0 * f64::EPSILON * number);
    }

    #[test]
    fn products_and_quotients_are_written_as_they_can_be_read(
        first in 0..6_usize, second in 0..6_usize, third in 0..6_usize, divided in any::<[bool; 2]>(),
    ) {
        let units = ["m", "mm/s", "N*m", "1", "J/(kg*K)", "deg"].map(unit);
        let combined = |left: &Unit, right: &Unit, divided: bool| {
            let found = if divided { left.divided_by(right) } else { left.times(right) };
            found.expect("it is in range")
        };
        let left = combined(&units[first], &units[second], divided[0]);
        for found in [combined(&left, &units[third], divided[1]), combined(&units[third], &left, divided[1])] {
            prop_assert!(unit(found.text()).same_as(&found), "{}", found);
        }
    }

    #[test]
    fn any_text_is_parsed_without_panic(text in "[0-9a-zA-Z%^/*(). \u{b0}\u{b2}\u{207b}-]{0,20}") {
        if let Ok(found) = text.parse::<QuantityValue>() {
            // What is written back is the same.
            prop_assert_eq!(&value(&found.to_string()), &found);
        }
        if let Err(error) = text.parse::<Unit>() {
            prop_assert!(error.text.get(error.span.clone()).is_some());
        }
    }
}

/// A hand in m and world, an object in mm and world, a cup in mm in the camera's frame.
fn layout() -> Trace {
    let mut trace = Trace::new();
    let place = |unit: &str, frame: &str| {
        let axes = ["x", "y", "z"];
        let fields = axes.map(|axis| Field::number(axis, unit).in_frame(frame));
        fields.to_vec()
    };
    trace.add_channel("/hand", place("m", "world")).unwrap();
    trace.add_channel("/object", place("mm", "world")).unwrap();
    trace.add_channel("/cup", place("m", "camera")).unwrap();
    trace.add_channel("/loose", place("", "world")).unwrap();
    let robot = vec![
        Field::number("speed", "m/s"),
        Field::number("force", "N"),
        Field::number("area", "cm^2"),
        Field::number("heading", "deg"),
        Field::number("yaw", "rad"),
        Field::number("fingers", "counts"),
        Field::number("ratio", "1"),
        Field::number("time", "s"),
        Field::number("plain", ""),
    ];
    trace.add_channel("/robot", robot).unwrap();
    trace
}

fn recording() -> Trace {
    let mut trace = layout();
    let rows: [&[f64]; 5] = [
        &[0.5, 0.25, 1.0],
        &[500.0, 250.0, 1250.0],
        &[0.5, 0.25, 1.0],
        &[1.0, 2.0, 3.0],
        &[0.25, 10.0, 2.0, 350.0, 0.1, 8.0, 0.5, 2.0, 7.0],
    ];
    for (channel, row) in trace.channels.iter_mut().zip(rows) {
        channel.push(0.0, row).unwrap();
    }
    trace
}

fn truth_of(text: &str) -> Option<bool> {
    let trace = recording();
    let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&trace));
    let bound = bound.unwrap_or_else(|error| panic!("{error}"));
    let mut cursor = Cursor::new(&trace);
    cursor.seek(0.0);
    bound.eval(&cursor)
}

#[test]
fn numbers_and_signals_are_brought_to_one_unit() {
    let truths = [
        "/robot.speed = 250 mm/s",
        "250 mm/s = /robot.speed",
        "/robot.speed = 0.9 km/h",
        "/robot.speed < 251 mm/s & /robot.speed > 249 mm/s",
        "-/robot.speed = -250 mm/s",
        "/hand.x = /object.x",
        "/object.x = /hand.x",
        "/object.x = 50 cm",
        "/object.x = 500",
        "/hand.z - /object.z = -250 mm",
        "/hand.z - /object.z = -25 cm",
        "max(/hand.x, /object.x, 40 cm) = 0.5 m",
        "abs(/hand.z - /object.z) < 26 cm",
        "distance(/hand, /object) = 25 cm",
        "/robot.force / /robot.area = 5 N/cm^2",
        "/robot.force / /robot.area = 50 kPa",
        "/hand.x / /robot.time = /robot.speed",
        "/hand.x / 2 s = /robot.speed",
        "/robot.speed * 2 = 0.5 m/s",
        "/robot.speed * /robot.time = 500 mm",
        "/robot.ratio = 50 %",
        "/robot.ratio = 0.5",
        "/robot.ratio + 1 = 1.5",
        "/robot.fingers = 8 & /robot.fingers / /robot.fingers = 1",
        "/robot.fingers / /robot.fingers > 50 %",
        "2 * /robot.fingers / 3 < 6 & 8 / /robot.fingers = 1",
        "/robot.plain = 7",
        "/robot.plain / 7 = 1",
        "25 cm + 250 mm = 0.5 m",
        "/hand.x > 0 & /hand.x - /object.x >= 0",
        "/robot.yaw / 1 rad = 0.1",
        "/robot.yaw < 6 deg & /robot.yaw > 5.7 deg",
        "angle_between(/robot.heading, 10 deg) > 19.99 deg",
        "angle_between(/robot.heading, 10 deg) < 20.01 deg",
        "angle_difference(/robot.heading, 10 deg) < 0",
        "angle_difference(10 deg, /robot.heading) > 0",
        "angle_between(/robot.heading, /robot.yaw) < 16 deg",
        // Of the two ends of half a turn, the positive one.
        "angle_difference(/robot.heading, 170 deg) = 180 deg",
        "angle_difference(170 deg, /robot.heading) = 180 deg",
        "angle_difference(/robot.heading + 720 deg, /robot.heading) = 0",
        // Lengths of vectors have no frame.
        "norm(/hand.x, /hand.y) < norm(/cup.x, 2 m)",
    ];
    for text in truths {
        assert_eq!(truth_of(text), Some(true), "{text}");
    }
}

#[test]
fn what_does_not_go_together_is_refused() {
    let layout = layout();
    let cases = [
        (
            "/robot.speed < 10 cm",
            "/robot.speed < 10 cm",
            "a speed in m/s does not go together with a length in cm",
        ),
        (
            "/hand.x + /robot.speed > 0",
            "/hand.x + /robot.speed",
            "a length in m does not go together with a speed",
        ),
        (
            "/hand.x < /robot.time * 0.3",
            "/hand.x < /robot.time * 0.3",
            "a time in s",
        ),
        (
            "norm(/hand.x, /robot.force) > 1",
            "/hand.x, /robot.force",
            "a force in N",
        ),
        ("min(1 m, 5 cm, 1) > 0 m", "1", "several here (m, cm)"),
        (
            "/robot.yaw < 0.1 m/m",
            "/robot.yaw < 0.1 m/m",
            "an angle in rad does not go together with a plain number",
        ),
        (
            "/robot.fingers < 5 mm",
            "/robot.fingers < 5 mm",
            "an amount in counts does not go together with a length",
        ),
        (
            "/robot.plain < 5 mm",
            "5 mm",
            "the unit of /robot.plain is not declared",
        ),
        (
            "/hand.x - /object.x < 0.05",
            "0.05",
            "there are several here (m, mm)",
        ),
        (
            "/hand.x - /cup.x < 5 cm",
            "/hand.x - /cup.x",
            "/hand.x is expressed in the frame world and /cup.x in camera",
        ),
        (
            "distance(/hand, /cup) < 5 cm",
            "/hand, /cup",
            "frame world and /cup.x in camera",
        ),
        (
            "/hand.x + (/hand.x - /object.x) < 0.05",
            "0.05",
            "there are several here (m, mm)",
        ),
        (
            "max(/hand.x, /object.x, /loose.x) < 5 cm",
            "/loose.x",
            "there are several here (m, mm)",
        ),
        ("5 cm + 1 < /hand.x", "5 cm + 1", "a number without a unit"),
        (
            "2 * /hand.x < /cup.x",
            "2 * /hand.x < /cup.x",
            "frame world",
        ),
        (
            "/hand.x / 2 < /cup.x",
            "/hand.x / 2 < /cup.x",
            "frame world",
        ),
        (
            "abs(/hand.x) < -/cup.x",
            "abs(/hand.x) < -/cup.x",
            "frame world",
        ),
        (
            "norm(/hand.x, /cup.y) < 1 m",
            "/hand.x, /cup.y",
            "frame world",
        ),
        (
            "/hand.x < /cup.x",
            "/hand.x < /cup.x",
            "transform one of them",
        ),
        (
            "angle_between(/robot.plain, /robot.plain) < 1",
            "angle_between(/robot.plain, /robot.plain)",
            "an angle must stand",
        ),
        (
            "angle_between(/hand.x, 1 m) < 1",
            "angle_between(/hand.x, 1 m)",
            "this is a length in m, where an angle",
        ),
        (
            "derivative(/hand.x) < 1 m/s",
            "derivative",
            "a predicate sees the values of one moment only",
        ),
        ("/hand.x < 5 degC", "5 degC", "offset"),
        (
            "/robot.speed < 5 m/s * kg",
            "5 m/s * kg",
            "read in two ways",
        ),
    ];
    for (text, place, expected) in cases {
        let bound = Predicate::parse(text).and_then(|predicate| predicate.bind(&layout));
        let error = bound.expect_err(text);
        assert!(error.to_string().contains(expected), "{text}: {error}");
        assert_eq!(&text[error.span.clone()], place, "{error}");
    }
}

#[test]
fn assumptions_are_reported() {
    let layout = layout();
    let lints = |text: &str| -> Vec<String> {
        let bound = Predicate::parse(text).unwrap().bind(&layout).unwrap();
        let shown = |lint: &trace::PredicateLint| {
            assert!(lint.to_string().contains("in \""), "{lint}");
            format!("{}: {}", &text[lint.span.clone()], lint.kind)
        };
        bound.lints().iter().map(shown).collect()
    };
    let found = lints("/robot.speed < 0.25 & /robot.ratio > 0.5 & /hand.x > 0 & /robot.plain < 3");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("0.25: this number has no unit and is taken in m/s"),
        "{found:?}"
    );
    let found = lints("distance(/hand, /loose) < 10 cm");
    assert!(
        found[0].contains("the unit of /loose.x is not declared and taken to be m"),
        "{found:?}"
    );
    assert_eq!(lints("/robot.speed < 250 mm/s"), [""; 0]);
}

#[test]
fn units_end_where_they_must() {
    // A unit extends over operators only as long as units follow.
    assert_eq!(truth_of("/robot.speed < 1 m/s & true"), Some(true));
    assert_eq!(truth_of("/robot.speed < 1 m / s and true"), Some(true));
    assert_eq!(truth_of("/robot.speed * 2 s > 1 mm*2"), Some(true));
    assert_eq!(truth_of("1 m//robot.time > /robot.speed"), Some(true));
    assert_eq!(truth_of("(5 cm) < /hand.x"), Some(true));
    assert_eq!(truth_of("/hand.x < 2 m * min(1, 2)"), Some(true));
    assert_eq!(truth_of("4 m / 1 s = 4 m/s"), Some(true));
    assert_eq!(truth_of("/robot.ratio = 50% | false"), Some(true));
    let deep = format!("/hand.x < 1 m / {}2{}", "(".repeat(20), ")".repeat(20));
    assert_eq!(truth_of(&deep), Some(false));
    assert!(Predicate::parse("/hand.x < 5 (m)").is_err());
    let error = Predicate::parse("/robot.ratio < 5and true").expect_err("no unit");
    assert!(
        error.to_string().contains("there is no unit and"),
        "{error}"
    );
    let error = Predicate::parse("/hand.x < 5 m 3").expect_err("two numbers");
    assert!(
        matches!(error.kind, PredicateErrorKind::Unexpected { .. }),
        "{error}"
    );
}

#[test]
fn parameters_have_units() {
    let parameters = || {
        let entries = [("near", "10 cm"), ("slow", "250 mm/s"), ("share", "0.5")];
        Parameters::new(entries).expect("they are well-formed")
    };
    let vocabulary = Vocabulary::with_parameters(
        [("close", "distance(/hand, /object) <= near + 150 mm")],
        parameters(),
    );
    let vocabulary = vocabulary.expect("it is well-formed");
    let trace = recording();
    let holds = |text: &str| {
        let bound = vocabulary.predicate(text).and_then(|it| it.bind(&trace));
        let mut cursor = Cursor::new(&trace);
        cursor.seek(0.0);
        bound
            .unwrap_or_else(|error| panic!("{error}"))
            .eval(&cursor)
    };
    assert_eq!(
        holds("close & /robot.speed <= slow & /robot.ratio = share"),
        Some(true)
    );
    assert_eq!(holds("/robot.speed < slow"), Some(false));
    let wrong = vocabulary
        .predicate("/robot.speed < near")
        .unwrap()
        .bind(&trace)
        .unwrap_err();
    assert!(wrong.to_string().contains("a length in cm"), "{wrong}");
    let unknown = vocabulary.predicate("/robot.speed < slov").unwrap_err();
    assert!(
        unknown.to_string().contains("did you mean slow?"),
        "{unknown}"
    );

    let errors = Vocabulary::with_parameters([("near", "true")], parameters()).unwrap_err();
    assert!(matches!(
        errors[0].kind,
        PredicateErrorKind::DuplicateName { .. }
    ));
    let errors = Parameters::new([
        ("a b", "1 m"),
        ("c", "1 q"),
        ("d", "1"),
        ("d", "2"),
        ("min", "1"),
    ]);
    let errors: Vec<String> = errors
        .unwrap_err()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(errors.len(), 4, "{errors:?}");
    assert!(
        errors[0].contains("\"a b\" cannot be the name"),
        "{errors:?}"
    );
    assert!(
        errors[1].contains("the parameter c: in \"1 q\": there is no unit q"),
        "{errors:?}"
    );
    assert!(
        errors[2].contains("the parameter d is declared twice"),
        "{errors:?}"
    );
}
