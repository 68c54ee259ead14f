//! Random trees with shared events and gates, by rates, ranges and counts, against enumeration.

use std::collections::BTreeMap;

use crate::support::{Sketch, analysis, cut_sets_as_bits, encloses, galileo, open_psa};

use diagnostic::{Cancel, Source};
use fault_tree::{
    Analysis, BigRational, Connective, EventData, Guarantee, Options, Order, Settings, decimal,
    read_galileo,
};
use proptest::prelude::*;

fn connective(kind: u8, count: usize) -> Connective {
    match kind {
        0 | 1 => Connective::And,
        2 | 3 => Connective::Or,
        4 => Connective::AtLeast(count.div_ceil(2)),
        5 if count == 2 => Connective::Xor,
        6 => Connective::Nand,
        7 if count == 1 => Connective::Not,
        _ => Connective::Nor,
    }
}

/// Trees over so many events.
fn sketches(events: usize) -> impl Strategy<Value = Sketch> {
    let probabilities =
        prop::collection::vec((1_u32..1000).prop_map(|it| format!("0.{it:03}")), events);
    let gate = (
        0_u8..9,
        prop::collection::vec(any::<prop::sample::Index>(), 1..5),
    );
    (probabilities, prop::collection::vec(gate, 1..9)).prop_map(move |(probabilities, drawn)| {
        let mut gates = Vec::new();
        for (number, (kind, arguments)) in drawn.into_iter().enumerate() {
            let chosen = arguments.iter().map(|it| it.index(events + number));
            let mut chosen: Vec<usize> = chosen
                .collect::<std::collections::BTreeSet<_>>()
                .into_iter()
                .collect();
            if number > 0 && !chosen.contains(&(events + number - 1)) {
                // The gate before is used, so that nothing is left over.
                chosen.push(events + number - 1);
            }
            gates.push((connective(kind, chosen.len()), chosen));
        }
        Sketch {
            probabilities,
            gates,
        }
    })
}

/// The least and the greatest probability over all ends of the ranges.
fn extremes(sketch: &Sketch, ranges: &[(BigRational, BigRational)]) -> (BigRational, BigRational) {
    let choices = (0..1_u32 << ranges.len()).map(|choice| {
        let end = |(bit, range): (usize, &(BigRational, BigRational))| match choice >> bit & 1 {
            1 => range.1.clone(),
            _ => range.0.clone(),
        };
        sketch.probability(&ranges.iter().enumerate().map(end).collect::<Vec<_>>())
    });
    let all: Vec<BigRational> = choices.collect();
    (
        all.iter().min().expect("some").clone(),
        all.iter().max().expect("some").clone(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn both_formats_and_both_orders_give_the_enumerated_answer(sketch in sketches(7)) {
        let expected = sketch.probability(&sketch.exact());
        let trees = [
            galileo(&sketch.galileo()).expect("a tree").tree,
            open_psa(&sketch.open_psa()).expect("a tree").tree,
        ];
        for tree in &trees {
            for order in [Order::SmallFirst, Order::LeftMost] {
                let options = Options { order, ..Options::default() };
                let analysis = Analysis::new(tree, tree.event(&sketch.top()).unwrap(), options, &Cancel::default()).unwrap();
                let found = analysis.probability(&Cancel::default()).unwrap();
                prop_assert_eq!(found.exact.as_ref(), Some(&expected));
                let sets: std::collections::BTreeSet<u32> = cut_sets_as_bits(tree, &analysis).into_iter().collect();
                prop_assert_eq!(sets, sketch.minimal_solutions());
                prop_assert_eq!(analysis.is_monotone(), sketch.is_monotone());
            }
        }
    }

    #[test]
    fn doubles_enclose_the_exact_value(sketch in sketches(8)) {
        let tree = galileo(&sketch.galileo()).expect("a tree").tree;
        let options = Options { exact_bits: 0, ..Options::default() };
        let analysis = Analysis::new(&tree, tree.top().unwrap(), options, &Cancel::default()).unwrap();
        let found = analysis.probability(&Cancel::default()).unwrap();
        let expected = sketch.probability(&sketch.exact());
        if analysis.nodes() > 0 {
            prop_assert_eq!(found.guarantee, Guarantee::Rounded);
        }
        prop_assert!(encloses(found.bounds.lower, found.bounds.upper, &expected));
        prop_assert!(found.bounds.width() < 1e-13);
    }

    #[test]
    fn ranges_are_attained_where_it_is_said_and_never_left(
        sketch in sketches(5),
        ends in prop::collection::vec((0_u32..=1000, 0_u32..=1000), 5),
    ) {
        let tree = galileo(&sketch.galileo()).expect("a tree").tree;
        let text = |it: u32| format!("{}e-3", it);
        let ranges: Vec<_> = ends.iter().map(|(a, b)| (text(*a.min(b)), text(*a.max(b)))).collect();
        let table: BTreeMap<String, EventData> = ranges.iter().enumerate()
            .map(|(index, (low, high))| (format!("e{index}"), EventData::interval(low, high).unwrap()))
            .collect();
        // Not every event has to be used.
        let table = table.into_iter().filter(|(name, _)| tree.find(name).is_some()).collect();
        let tree = tree.with_data(&table).unwrap();
        let found = analysis(&tree).probability(&Cancel::default()).unwrap();
        let numbers: Vec<_> = ranges.iter().map(|(a, b)| (decimal(a).unwrap(), decimal(b).unwrap())).collect();
        let (least, greatest) = extremes(&sketch, &numbers);
        prop_assert!(encloses(found.bounds.lower, found.bounds.upper, &least));
        prop_assert!(encloses(found.bounds.lower, found.bounds.upper, &greatest));
        // Five events are few enough to be tried, so the bounds are always attained.
        let is_range = matches!(found.guarantee, Guarantee::Range { is_attained: true });
        prop_assert!(is_range || matches!(found.guarantee, Guarantee::Exact), "{:?}", found.guarantee);
        let near = |bound: f64, value: &BigRational| {
            let difference = BigRational::from_float(bound).unwrap() - value;
            encloses(-1e-14, 1e-14, &difference)
        };
        prop_assert!(near(found.bounds.lower, &least) && near(found.bounds.upper, &greatest));
    }
}

#[test]
fn ranges_of_many_events_in_both_directions_are_said_not_to_be_attained() {
    // Eleven exclusive ors of two events each: too many for all ends to be tried.
    let mut text = String::from("toplevel T; T or");
    (0..11).for_each(|it| text.push_str(&format!(" x{it}")));
    text.push(';');
    (0..11).for_each(|it| {
        text.push_str(&format!(
            "x{it} xor a{it} b{it}; a{it} prob=0.5; b{it} prob=0.5;"
        ))
    });
    let tree = galileo(&text).expect("a tree").tree;
    let data = EventData::interval("0.1", "0.2").expect("an interval");
    let names = (0..11).flat_map(|it| [format!("a{it}"), format!("b{it}")]);
    let tree = tree
        .with_data(&names.map(|name| (name, data.clone())).collect())
        .expect("events");
    let found = analysis(&tree)
        .probability(&Cancel::default())
        .expect("data");
    assert_eq!(found.guarantee, Guarantee::Range { is_attained: false });
    // Each exclusive or is between 0.18 and 0.32 (at the corners of the square); none of eleven, and all.
    let (least, greatest) = (1.0 - 0.82_f64.powi(11), 1.0 - 0.68_f64.powi(11));
    assert!(
        found.bounds.lower <= least && found.bounds.upper >= greatest,
        "{found:?}"
    );
    assert!(!analysis(&tree).is_monotone());
}

#[test]
fn a_rate_is_one_minus_the_exponential() {
    let settings = |time: &str| Settings {
        mission_time: decimal(time),
    };
    for (rate, time) in [
        ("1e-12", "1"),
        ("1e-5", "100"),
        ("0.003", "10"),
        ("0.7", "3"),
        ("2", "15"),
        ("5", "1000"),
        ("0", "7"),
    ] {
        let text = format!("toplevel T; T or A; A lambda={rate};");
        let tree = read_galileo(&Source::new("t", text), &settings(time))
            .expect("a tree")
            .tree;
        let found = analysis(&tree)
            .probability(&Cancel::default())
            .expect("data")
            .bounds;
        let (rate, time): (f64, f64) = (rate.parse().unwrap(), time.parse().unwrap());
        // The library's function is right to about a unit in the last place.
        let expected = -(-rate * time).exp_m1();
        assert!(
            found.lower <= expected * (1.0 + 1e-15) && found.upper >= expected * (1.0 - 1e-15),
            "{found:?} {expected}"
        );
        assert!(found.width() <= 4e-15 * expected, "{found:?}");
    }
}

#[test]
fn counts_give_a_range_with_a_confidence() {
    let tree = galileo("toplevel T; T and A B; A prob=0.5; B prob=0.5;")
        .expect("a tree")
        .tree;
    let counts = |k, n| EventData::counts(k, n).expect("counts");
    let one = tree
        .clone()
        .with_data(&[("A".to_owned(), counts(3, 100))].into())
        .expect("A is an event");
    let found = analysis(&one)
        .probability(&Cancel::default())
        .expect("data");
    let guarantee = Guarantee::Statistical {
        confidence: 0.95,
        is_attained: true,
    };
    assert_eq!(found.guarantee, guarantee);
    // Clopper and Pearson's interval of 3 of 100 at 95 % by scipy.stats.binomtest(3, 100).proportion_ci().
    let (low, high) = (0.006_229_971_538_306_227, 0.085_176_052_974_280_28);
    assert!(
        (found.bounds.lower - low / 2.0).abs() < 1e-9
            && (found.bounds.upper - high / 2.0).abs() < 1e-9,
        "{found:?}"
    );
    // With two counts each has to hold at 97.5 %.
    let both = tree
        .with_data(
            &[
                ("A".to_owned(), counts(3, 100)),
                ("B".to_owned(), counts(0, 50)),
            ]
            .into(),
        )
        .expect("events");
    let found = analysis(&both)
        .probability(&Cancel::default())
        .expect("data");
    // None of 50 at 97.5 %: 1 - 0.0125^(1/50). 3 of 100: scipy, confidence_level=0.975.
    let high = 0.094_161_463_337_064_96 * (1.0 - 0.0125_f64.powf(0.02));
    assert_eq!(found.bounds.lower, 0.0);
    assert!((found.bounds.upper - high).abs() < 1e-9, "{found:?} {high}");
}
