//! Every small tree against the enumeration of its truth assignments, without rounding.

use crate::support::{
    PROBABILITIES, Sketch, analysis, cut_sets_as_bits, encloses, galileo, open_psa,
};

use diagnostic::Cancel;
use fault_tree::{BigRational, Connective, CutSetKind, FaultTree, Guarantee, decimal};

/// Every gate over some of `arguments`, in which `needed` is, if one is.
fn gates(arguments: usize, needed: Option<usize>) -> Vec<(Connective, Vec<usize>)> {
    let mut found = Vec::new();
    for subset in 1_u32..1 << arguments {
        if needed.is_some_and(|it| subset >> it & 1 == 0) {
            continue;
        }
        let chosen: Vec<usize> = (0..arguments)
            .filter(|bit| subset >> bit & 1 == 1)
            .collect();
        let mut kinds = vec![
            Connective::And,
            Connective::Or,
            Connective::Nand,
            Connective::Nor,
        ];
        kinds.extend((1..=chosen.len()).map(Connective::AtLeast));
        match chosen.len() {
            1 => kinds.push(Connective::Not),
            2 => kinds.push(Connective::Xor),
            _ => {}
        }
        found.extend(kinds.into_iter().map(|kind| (kind, chosen.clone())));
    }
    found
}

fn sketch(events: usize, gates: Vec<(Connective, Vec<usize>)>) -> Sketch {
    let probabilities = PROBABILITIES[..events].iter().map(|it| (*it).to_owned());
    Sketch {
        probabilities: probabilities.collect(),
        gates,
    }
}

/// Holds everything that is computed of a tree against enumeration.
fn check(sketch: &Sketch, tree: &FaultTree) {
    let text = || sketch.galileo();
    let analysis = analysis(tree);
    let events = sketch.exact();
    let expected = sketch.probability(&events);
    let probability = analysis
        .probability(&Cancel::default())
        .expect("all events have data");
    assert_eq!(probability.guarantee, Guarantee::Exact, "{}", text());
    assert_eq!(probability.exact.as_ref(), Some(&expected), "{}", text());
    let bounds = probability.bounds;
    assert!(
        encloses(bounds.lower, bounds.upper, &expected),
        "{}",
        text()
    );
    assert!(
        bounds.upper <= bounds.lower.next_up().next_up(),
        "{bounds:?} {}",
        text()
    );
    assert_eq!(analysis.is_monotone(), sketch.is_monotone(), "{}", text());
    let sets = cut_sets_as_bits(tree, &analysis);
    let unique: std::collections::BTreeSet<u32> = sets.iter().copied().collect();
    assert_eq!(unique.len(), sets.len(), "{}", text());
    assert_eq!(unique, sketch.minimal_solutions(), "{}", text());
    assert!(sets.is_sorted_by_key(|set| set.count_ones()), "{}", text());
    let kind = analysis
        .cut_sets(0, &Cancel::default())
        .expect("a small tree")
        .kind;
    assert_eq!(
        kind == CutSetKind::MinimalCutSets,
        sketch.is_monotone(),
        "{}",
        text()
    );
    check_importance(sketch, tree, &expected);
}

fn check_importance(sketch: &Sketch, tree: &FaultTree, top: &BigRational) {
    let zero = decimal("0").expect("a number");
    let given = |event: usize, value: &str| {
        let mut events = sketch.exact();
        events[event] = decimal(value).expect("a number");
        sketch.probability(&events)
    };
    for found in analysis(tree)
        .importance(&Cancel::default())
        .expect("all events have data")
    {
        let event: usize = tree.name(found.event)[1..].parse().expect("e0, e1, ...");
        let (with, without) = (given(event, "1"), given(event, "0"));
        let own = &sketch.exact()[event];
        let birnbaum = &with - &without;
        assert!(encloses(
            found.birnbaum.lower,
            found.birnbaum.upper,
            &birnbaum
        ));
        assert!(found.birnbaum.width() < 1e-14, "{found:?}");
        if *top == zero {
            continue;
        }
        let criticality = found.criticality.expect("a possible event");
        assert!(
            encloses(
                criticality.lower,
                criticality.upper,
                &(own * &birnbaum / top)
            ),
            "{found:?} {}",
            sketch.galileo()
        );
        assert!(criticality.width() < 1e-10, "{found:?}");
        let achievement = found.risk_achievement_worth.expect("a possible event");
        assert!(
            encloses(achievement.lower, achievement.upper, &(&with / top)),
            "{found:?}"
        );
        let reduction = found.risk_reduction_worth.expect("a possible event");
        match without == zero {
            true => assert_eq!(reduction.upper, f64::INFINITY),
            false => assert!(
                encloses(reduction.lower, reduction.upper, &(top / &without)),
                "{found:?}"
            ),
        }
    }
}

#[test]
fn every_tree_of_one_or_two_gates_over_three_events() {
    let mut count = 0;
    for first in gates(3, None) {
        let one = sketch(3, vec![first.clone()]);
        check(&one, &galileo(&one.galileo()).expect("a tree").tree);
        for second in gates(4, Some(3)) {
            let two = sketch(3, vec![first.clone(), second]);
            check(&two, &galileo(&two.galileo()).expect("a tree").tree);
            count += 1;
        }
    }
    assert_eq!(count, gates(3, None).len() * gates(4, Some(3)).len());
    assert!(count > 2_000, "{count}");
}

#[test]
fn trees_of_three_gates_over_four_events_in_both_formats() {
    // One of 1,501: the first two gates over events, the third over all.
    let (first, third) = (gates(4, None), gates(6, Some(5)));
    let mut number = 0_usize;
    for a in &first {
        for b in &first {
            for c in &third {
                number += 1;
                if !number.is_multiple_of(1_501) {
                    continue;
                }
                let sketch = sketch(4, vec![a.clone(), b.clone(), c.clone()]);
                check(&sketch, &galileo(&sketch.galileo()).expect("a tree").tree);
                let mut reading = open_psa(&sketch.open_psa()).expect("a tree").tree;
                if reading.top().is_none() {
                    // The first gate may not be used, so that the format leaves open which is the top event.
                    let top = reading.event(&sketch.top()).expect("the last gate");
                    reading = reading.with_top(top);
                }
                check(&sketch, &reading);
            }
        }
    }
    assert!(number / 1_501 > 300, "{number}");
}
