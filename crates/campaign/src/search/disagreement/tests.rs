//! Planted disagreements are found, and none where none is planted.

use super::*;

fn square() -> Space {
    let parameter =
        |name| format!("[[parameter]]\nname = \"{name}\"\nsets = [\"{name}\"]\nuniform = [0, 1]\n");
    Space::from_toml(&["x", "y"].map(parameter).concat()).unwrap()
}

/// A prediction that depends on the context.
fn formal(context: &Point) -> f64 {
    0.95 - 0.1 * context.0[1]
}

/// A corner of 8 % of all contexts.
fn in_corner(context: &Point) -> bool {
    context.0[0] > 0.8 && context.0[1] < 0.4
}

struct Run {
    search: DisagreementSearch,
    explored_corner: usize,
    explored: usize,
}

fn run(seed: u64, corner_rate: Option<f64>, episodes: usize) -> Run {
    let options = DisagreementOptions {
        explore: 250,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), seed, options).unwrap();
    let mut simulator = Random::new(seed, "simulator");
    let (mut explored_corner, mut explored) = (0, 0);
    let mut used = 0;
    while used < episodes && !search.is_over() {
        let contexts = search.ask(10, &formal);
        let exploring = search.confirmation.is_none();
        let mut outcomes = Vec::new();
        for context in contexts {
            let rate = corner_rate
                .filter(|_| in_corner(&context))
                .unwrap_or(formal(&context));
            if exploring {
                explored += 1;
                explored_corner += usize::from(in_corner(&context));
            }
            outcomes.push((context, simulator.chance(rate)));
        }
        used += outcomes.len();
        search.tell(&outcomes);
    }
    Run {
        search,
        explored_corner,
        explored,
    }
}

#[test]
fn a_planted_disagreement_is_found_and_nothing_else() {
    let mut found = 0;
    let mut share = 0.0;
    for seed in 0..10 {
        let run = run(seed, Some(0.5), 900);
        let disagree: Vec<Finding> = run
            .search
            .findings()
            .into_iter()
            .filter(|finding| finding.agreement == Agreement::Disagrees)
            .collect();
        assert!(
            disagree.iter().all(|finding| in_corner(&finding.context)),
            "{disagree:?}"
        );
        found += usize::from(!disagree.is_empty());
        share += run.explored_corner as f64 / run.explored as f64 / 10.0;
    }
    assert!(found >= 9, "{found} of 10");
    // Blind sampling would spend 8 % of its episodes there.
    assert!(share > 0.16, "{share}");
}

#[test]
fn where_nothing_is_planted_nothing_is_found() {
    let runs = 30;
    let alarms = (0..runs)
        .filter(|seed| {
            let findings = run(100 + seed, None, 700).search.findings();
            findings.iter().any(|f| f.agreement == Agreement::Disagrees)
        })
        .count();
    // At most 5 % of 30 are expected: 1.5, and three deviations more are 5.1.
    assert!(alarms <= 5, "{alarms}");
}

#[test]
fn agreement_is_shown_as_well() {
    let contexts = vec![(Point(vec![0.0]), 0.9)];
    let mut confirmation = Confirmation::new(contexts, 0.1, 0.95).unwrap();
    let mut simulator = Random::new(1, "simulator");
    let mut episodes = 0;
    while !confirmation.is_over() && episodes < 5000 {
        for context in confirmation.ask(1) {
            confirmation.tell(&context, simulator.chance(0.9));
            episodes += 1;
        }
    }
    let finding = &confirmation.findings()[0];
    assert_eq!(finding.agreement, Agreement::Agrees);
    assert!(finding.interval.low >= 0.8 && finding.interval.high <= 1.0);
    assert!(confirmation.ask(5).is_empty());
    assert!(episodes < 1000, "{episodes}");
}

#[test]
fn what_cannot_happen_and_does_is_a_disagreement_at_once() {
    let mut confirmation = Confirmation::new(vec![(Point(vec![]), 0.0)], 0.0, 0.999).unwrap();
    confirmation.tell(&Point(vec![]), true);
    let finding = &confirmation.findings()[0];
    assert_eq!(finding.agreement, Agreement::Disagrees);
    assert!(finding.ln_evidence == f64::INFINITY && finding.sure_difference > 0.0);
}

#[test]
fn searches_go_on_from_their_written_form() {
    let options = DisagreementOptions {
        explore: 30,
        contexts: 3,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), 3, options).unwrap();
    let mut simulator = Random::new(3, "simulator");
    for round in 0..12 {
        let contexts = search.ask(6, &formal);
        let text = serde_json::to_string(&search).unwrap();
        let mut resumed: DisagreementSearch = serde_json::from_str(&text).unwrap();
        let outcomes: Vec<_> = contexts
            .into_iter()
            .map(|c| (c, simulator.chance(0.8)))
            .collect();
        search.tell(&outcomes);
        resumed.tell(&outcomes);
        assert_eq!(
            resumed.clone().ask(4, &formal),
            search.clone().ask(4, &formal),
            "{round}"
        );
        assert_eq!(resumed.findings(), search.findings());
    }
    assert_eq!(search.findings().len(), 3);
    assert_eq!(search.map(0, 1, 5, &formal).len(), 25);
}

#[test]
fn the_map_shows_where_it_is() {
    let search = run(4, Some(0.3), 250).search;
    let difference = |cell: &MapCell| cell.predicted - cell.simulated;
    let cells = search.map(0, 1, 10, &formal);
    let mean = |inside: bool| {
        let chosen: Vec<f64> = cells
            .iter()
            .filter(|cell| in_corner(&cell.context) == inside)
            .map(difference)
            .collect();
        chosen.iter().sum::<f64>() / chosen.len() as f64
    };
    assert!(
        mean(true) > 0.3 && mean(false).abs() < 0.15,
        "{} {}",
        mean(true),
        mean(false)
    );
}

#[test]
fn settings_out_of_range_are_refused() {
    let with = |change: fn(&mut DisagreementOptions)| {
        let mut options = DisagreementOptions::default();
        change(&mut options);
        DisagreementSearch::new(square(), 1, options)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    assert!(with(|o| o.margin = 1.0).starts_with("`margin`"));
    assert!(with(|o| o.explore = 0).starts_with("`explore`"));
    assert!(with(|o| o.contexts = 0).starts_with("`contexts`"));
    assert!(with(|o| o.confidence = 1.5).starts_with("`confidence`"));
    assert!(Confirmation::new(vec![(Point(vec![]), 1.5)], 0.1, 0.9).is_err());
}

#[test]
fn predictions_are_asked_for_sparingly() {
    let asked = std::cell::Cell::new(0_usize);
    let counted = |context: &Point| {
        asked.set(asked.get() + 1);
        formal(context)
    };
    let options = DisagreementOptions {
        explore: 100,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), 1, options).unwrap();
    let mut simulator = Random::new(1, "simulator");
    for _ in 0..40 {
        let contexts = search.ask(5, &counted);
        let outcomes: Vec<_> = contexts
            .into_iter()
            .map(|c| (c, simulator.chance(0.9)))
            .collect();
        search.tell(&outcomes);
    }
    // The pool, and for each explored context one when it is proposed and one when it is told.
    assert!(asked.get() <= 400 + 2 * 100, "{}", asked.get());
}
