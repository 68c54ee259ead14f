//! What predicates compare with what.

use trace::units::Dimension;
use trace::{
    Comparison, Field, Measure, Parameters, Predicate, ThresholdOrigin, Trace, Vocabulary,
    axis_boxes,
};

fn vocabulary() -> Vocabulary {
    let parameters = Parameters::new([("near", "10 cm"), ("slow", "250 mm/s")]);
    let entries = [
        ("gap", "distance(/hand, /object)"),
        ("dx", "/hand.x - /object.x"),
        ("limit", "near - 5 cm"),
        ("close", "gap < near"),
        (
            "boxed",
            "abs(dx) < 0.05 & abs(/hand.y - /object.y) < 5 cm & abs(/object.z - /hand.z) <= 50 mm",
        ),
        ("safe", "close => slow > /robot.speed"),
    ];
    Vocabulary::with_parameters(entries, parameters.expect("they are well-formed"))
        .expect("it is well-formed")
}

fn layout() -> Trace {
    let mut trace = Trace::new();
    for topic in ["/hand", "/object"] {
        let fields = ["x", "y", "z"].map(|axis| Field::number(axis, "m"));
        trace.add_channel(topic, fields.to_vec()).unwrap();
    }
    trace
        .add_channel("/robot", vec![Field::number("speed", "mm/s")])
        .unwrap();
    trace
}

fn comparisons(text: &str) -> Vec<Comparison> {
    vocabulary()
        .predicate(text)
        .expect("it is well-formed")
        .comparisons()
}

#[test]
fn limits_are_found_with_their_places_through_the_vocabulary() {
    let found = comparisons("safe & 3 > 2");
    let [close, slow] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(close.quantity, "gap");
    let axes = ["x", "y", "z"].map(str::to_owned).to_vec();
    let (first, second) = ("/hand".to_owned(), "/object".to_owned());
    assert_eq!(
        close.measure,
        Measure::Distance {
            first,
            second,
            axes
        }
    );
    assert_eq!(close.signals.len(), 6);
    assert!(close.negated, "it stands on the left of an implication");
    assert_eq!(
        close.threshold.origin,
        ThresholdOrigin::Parameter("near".to_owned())
    );
    assert_eq!(close.threshold.si_value, Some(0.1));
    assert_eq!(close.threshold.dimension(), Some(Dimension::LENGTH));
    assert_eq!(close.entry.as_deref(), Some("close"));
    assert_eq!(&close.text[close.span.clone()], "gap < near");

    assert_eq!(slow.quantity, "/robot.speed");
    assert_eq!(slow.operator.to_string(), "<");
    assert!(!slow.negated);
    assert_eq!(slow.measure, Measure::Signal("/robot.speed".to_owned()));
    assert_eq!(
        (slow.threshold.number, slow.threshold.si_value),
        (250.0, Some(0.25))
    );
    assert_eq!(&slow.text[slow.threshold.span.clone()], "slow");
}

#[test]
fn numbers_without_a_unit_get_that_of_the_layout() {
    let predicate = Predicate::parse("/robot.speed < 250 | -1 <= /hand.x * 2").unwrap();
    let bare = predicate.comparisons();
    assert!(
        bare.iter()
            .all(|it| it.threshold.unit.is_none() && it.threshold.si_value.is_none())
    );
    let found = predicate.comparisons_in(&layout()).unwrap();
    assert_eq!(found[0].threshold.si_value, Some(0.25));
    assert_eq!(
        found[0].threshold.unit.as_ref().map(|unit| unit.text()),
        Some("mm/s")
    );
    assert_eq!(found[1].threshold.si_value, Some(-1.0));
    assert_eq!(found[1].threshold.origin, ThresholdOrigin::Literal);
    assert_eq!(found[1].operator.to_string(), ">=");
    assert!(predicate.comparisons_in(&Trace::new()).is_err());
}

#[test]
fn computed_limits_name_their_parameters() {
    let found = comparisons("gap >= limit & !(gap = 2 * near) & (gap > 1 m) = (gap < 2 m)");
    assert_eq!(found.len(), 4);
    assert_eq!(
        found[0].threshold.origin,
        ThresholdOrigin::Expression(vec!["near".to_owned()])
    );
    // 0.1 - 0.05 in doubles.
    assert_eq!(found[0].threshold.si_value, Some(0.05));
    assert_eq!(found[1].threshold.number, 20.0);
    assert!(found[1].negated);
    assert_eq!(found[2].threshold.number, 1.0);
    assert_eq!(comparisons("dx < /hand.y & true").len(), 0);
}

#[test]
fn a_box_is_told_from_a_ball() {
    let found = comparisons("boxed");
    assert_eq!(found.len(), 3);
    let boxes = axis_boxes(&found);
    let [only] = &boxes[..] else {
        panic!("{boxes:?}")
    };
    assert_eq!((&only.first[..], &only.second[..]), ("/hand", "/object"));
    assert_eq!(only.axes.keys().collect::<Vec<_>>(), ["x", "y", "z"]);
    let limits = vocabulary()
        .predicate("boxed")
        .unwrap()
        .comparisons_in(&layout())
        .unwrap();
    assert!(
        limits.iter().all(|it| it.threshold.si_value == Some(0.05)),
        "{limits:?}"
    );
    // The two sides of one coordinate are no box yet, nor is a distance.
    assert!(axis_boxes(&comparisons("dx < 5 cm & dx > -5 cm & close")).is_empty());
    // It does not matter whether the limits stand in one text.
    let apart = Vocabulary::new([
        ("at_x", "/hand.x - /object.x < 1 m & /hand.x - /cup.x < 1 m"),
        (
            "at_y",
            "/hand.y - /object.y < 1 m & /robot.y - /object.y < 1 m",
        ),
    ]);
    let apart = apart.unwrap().predicate("at_x & at_y").unwrap();
    let apart = apart.comparisons();
    assert_eq!(axis_boxes(&apart).len(), 1);
    assert_eq!(axis_boxes(&apart)[0].second, "/object");
    let measure = |text: &str| comparisons(text).remove(0).measure;
    assert!(matches!(
        measure("norm(/hand.x - /object.x, /hand.y - /object.y) < 1 m"),
        Measure::Distance { axes, .. } if axes == ["x", "y"]
    ));
    assert!(matches!(
        measure("max(abs(dx), abs(/hand.y - /object.y)) < 1 m"),
        Measure::GreatestAxisDifference { axes, .. } if axes == ["x", "y"]
    ));
    assert_eq!(
        measure("max(dx, abs(/hand.y - /object.y)) < 1 m"),
        Measure::Other
    );
    assert_eq!(measure("/hand.x - /object.y < 1 m"), Measure::Other);
    assert_eq!(measure("/hand.x - /hand.x < 1 m"), Measure::Other);
}

#[test]
fn every_constant_is_listed() {
    let predicate = vocabulary().predicate("safe & gap * 2 > limit").unwrap();
    let constants = predicate.constants();
    let shown: Vec<(Option<&str>, String, Option<&str>)> = constants
        .iter()
        .map(|it| {
            (
                it.parameter.as_deref(),
                it.value.to_string(),
                it.entry.as_deref(),
            )
        })
        .collect();
    assert_eq!(
        shown,
        [
            (Some("near"), "10 cm".to_owned(), Some("close")),
            (Some("slow"), "250 mm/s".to_owned(), Some("safe")),
            (None, "2".to_owned(), None),
            (Some("near"), "10 cm".to_owned(), Some("limit")),
            (None, "5 cm".to_owned(), Some("limit")),
        ]
    );
    assert_eq!(&constants[4].text[constants[4].span.clone()], "5 cm");
}

#[test]
fn long_chains_of_entries_are_followed() {
    let entries = (1..5000).map(|it| (format!("e{it}"), format!("!e{}", it - 1)));
    let entries = entries.chain([("e0".to_owned(), "/hand.x < 1 m".to_owned())]);
    let vocabulary = Vocabulary::new(entries).expect("it is well-formed");
    let found = vocabulary.predicate("e4999").unwrap().comparisons();
    assert_eq!(found.len(), 1);
    assert!(found[0].negated);
}
