//! One fault in place of several: names that were mixed up, a failure that one piece alone shows, a step whose error is of
//! first order.

use super::*;
use evidence::{Counted, changed_places};

fn suspects(ledger: &[Evidence], conflicts: &[Comparison], more: Vec<Clue>) -> Vec<Suspect> {
    let (requirements, failure_modes) = (requirements(), modes());
    let matter = Matter {
        requirements: &requirements,
        failure_modes: &failure_modes,
        evidence: ledger,
        comparisons: conflicts,
        cells: &[],
        tables: &[],
        study: "handover",
    };
    rank(&matter, more)
}

/// A model with two rates, a simulation with counts of both, and a table.
fn with_table(model: [f64; 2], table: [u64; 2]) -> Vec<Evidence> {
    let [grip, pressure] = [mode("grip"), mode("pressure")];
    let formal = vec![
        computed(grip.clone(), model[0]),
        computed(pressure.clone(), model[1]),
    ];
    let simulated = vec![
        counted(grip.clone(), 7, 100),
        counted(pressure.clone(), 2, 84),
    ];
    let told = vec![
        counted(grip, table[0], 161),
        counted(pressure, table[1], 200),
    ];
    vec![
        piece("M", Technique::ModelChecking, "m.prism", formal),
        piece("S", Technique::Simulation, "s.toml", simulated),
        piece("X", Technique::Experiment, "x.csv", told),
    ]
}

#[test]
fn one_exchange_of_names_is_likelier_than_two_wrong_rates() {
    let both = [
        conflict(mode("grip"), "M", "X"),
        conflict(mode("pressure"), "M", "X"),
    ];
    let found = suspects(&with_table([0.146, 0.014], [3, 25]), &both, vec![]);
    assert_eq!(found[0].asset.kind, SuspectKind::Data, "{found:?}");
    assert!(
        found[0].title.contains("the wrong way round"),
        "{}",
        found[0].title
    );
    assert!(found[0].score > 2.0 && found.len() == 1, "{found:?}");
    // One wrong rate is no exchange, whichever of the two is it.
    for (model, table) in [([0.146, 0.125], [3, 25]), ([0.146, 0.014], [23, 25])] {
        let ledger = with_table(model, table);
        let margin = |_: &Subject| 0.05;
        assert_eq!(mixed_up(&ledger, &ledger[2], &margin), None);
        let found = suspects(&ledger, &both, vec![]);
        assert!(
            found.iter().all(|s| !s.title.contains("wrong way")),
            "{found:?}"
        );
    }
}

/// A requirement and a failure mode are columns of one cohort, whose headers may have been exchanged; totals of them are in tables of
/// their own.
#[test]
fn a_requirement_and_a_failure_mode_are_exchanged_in_a_cohort_alone() {
    let [kept, slip] = [requirement("1a"), mode("grip")];
    let of_people = |subject: &Subject, count| {
        let each = (0..10).map(|_| Sample::new(count, 20).unwrap());
        let each: Vec<Sample> = each.collect();
        finding(
            subject.clone(),
            Measure::of_clusters(&each, Confidence::P95).unwrap(),
        )
    };
    let with = |told| {
        let formal = vec![computed(kept.clone(), 0.95), computed(slip.clone(), 0.2)];
        vec![
            piece("M", Technique::ModelChecking, "m.prism", formal),
            piece("X", Technique::Experiment, "x.csv", told),
        ]
    };
    let margin = |_: &Subject| 0.05;
    let ledger = with(vec![of_people(&kept, 4), of_people(&slip, 19)]);
    let found = mixed_up(&ledger, &ledger[1], &margin).expect("exchanged");
    assert_eq!((found.modes, found.is_whole), ([&kept, &slip], true));
    let right = with(vec![of_people(&kept, 19), of_people(&slip, 4)]);
    assert_eq!(mixed_up(&right, &right[1], &margin), None);
    let totals = with(vec![
        counted(kept.clone(), 40, 200),
        counted(slip.clone(), 190, 200),
    ]);
    assert_eq!(mixed_up(&totals, &totals[1], &margin), None);
}

/// A model with two requirements, and a table of these counts of 800 each.
fn with_requirements(model: [f64; 2], passed: [u64; 2]) -> Vec<Evidence> {
    let of = |counts: [u64; 2], trials| {
        let ids = ["1a", "3"].into_iter().zip(counts);
        ids.map(|(id, count)| counted(requirement(id), count, trials))
            .collect::<Vec<_>>()
    };
    let computed = [
        computed(requirement("1a"), model[0]),
        computed(requirement("3"), model[1]),
    ];
    vec![
        piece("M", Technique::ModelChecking, "m.prism", computed.into()),
        piece("X", Technique::Experiment, "f.csv", of(passed, 800)),
    ]
}

/// Columns, or rows, the wrong way round are looked for in the table of the requirements, not in the one beside it.
#[test]
fn columns_and_rows_of_requirements_that_were_exchanged_are_located_in_their_table() {
    let both = [
        conflict(requirement("1a"), "M", "X"),
        conflict(requirement("3"), "M", "X"),
    ];
    let tables = [TableOf {
        evidence: "X".into(),
        counts: Counted::Requirements,
        file: "r.csv".into(),
        bound_in: None,
    }];
    let (requirements, failure_modes) = (requirements(), modes());
    let first = |ledger: &[Evidence]| {
        let matter = Matter {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: ledger,
            comparisons: &both,
            cells: &[],
            tables: &tables,
            study: "laundry",
        };
        rank(&matter, vec![]).swap_remove(0)
    };
    let margin = |_: &Subject| 0.05;
    let columns = with_requirements([0.868, 0.6], [106, 320]);
    let exchanged = exchanged_columns(&columns, &columns[1], &margin);
    assert!(exchanged.is_some_and(|it| it.are_all && it.odds.is_none()));
    let found = first(&columns);
    assert_eq!(found.asset.file.as_deref(), Some("r.csv"), "{found:?}");
    assert_eq!(found.asset.together, ["f.csv"]);
    assert!(
        found
            .title
            .contains("passed and failed the wrong way round"),
        "{found:?}"
    );

    let rows = with_requirements([0.868, 0.6], [480, 694]);
    assert_eq!(exchanged_columns(&rows, &rows[1], &margin), None);
    let found = first(&rows);
    assert_eq!(found.asset.file.as_deref(), Some("r.csv"), "{found:?}");
    assert!(
        found
            .title
            .contains("requirement 1a and requirement 3 the wrong way round"),
        "{found:?}"
    );

    // Wrong, and no exchange fixes it; and one alone that says the contrary of a requirement that is rarely kept.
    for (model, passed) in [([0.868, 0.6], [106, 200]), ([0.132, 0.6], [694, 480])] {
        let ledger = with_requirements(model, passed);
        let found = first(&ledger);
        let exchanged = exchanged_columns(&ledger, &ledger[1], &margin);
        let named = exchanged.map_or_else(Vec::new, |it| it.rows);
        assert!(!named.contains(&requirement("3")), "{named:?}");
        assert!(model[0] > 0.5 || named.is_empty(), "{named:?}");
        assert!(
            model[0] > 0.5 || !found.title.contains("wrong way"),
            "{found:?}"
        );
    }
    // One row alone, of a requirement that all else keeps: a wrong model may be the complement by chance, so that the model
    // is named with it.
    let ledger = with_requirements([0.868, 0.6], [106, 480]);
    let exchanged = exchanged_columns(&ledger, &ledger[1], &margin).expect("a row");
    assert_eq!(exchanged.rows, [requirement("1a")]);
    assert!(!exchanged.are_all && exchanged.odds.is_some());
    let found = first(&ledger);
    assert_eq!(found.asset.part.as_deref(), Some("row `1a`"), "{found:?}");
}

#[test]
fn who_alone_shows_a_failure_may_be_the_one_that_is_wrong() {
    let ledger = |experiments: u64| {
        [
            piece(
                "M",
                Technique::ModelChecking,
                "m.prism",
                vec![missing("grip")],
            ),
            piece(
                "S",
                Technique::Simulation,
                "s.toml",
                vec![counted(mode("grip"), 15, 85)],
            ),
            piece(
                "X",
                Technique::Experiment,
                "x.csv",
                vec![counted(mode("grip"), experiments, 90)],
            ),
        ]
    };
    let found = suspects(&ledger(0), &[], vec![]);
    assert_eq!(found[0].asset.kind, SuspectKind::Simulation, "{found:?}");
    assert!(found[0].is_strong() && found[0].odd_one_out() > Some(0.9));
    let argument = "15 of 85 in S, and M has no such failure";
    assert!(
        found[0].explanation.starts_with(argument) && found[0].explanation.contains(" on grip "),
        "{}",
        found[0].explanation
    );
    // What the experiments show, too, the model lacks.
    let found = suspects(&ledger(15), &[], vec![]);
    assert_eq!(found[0].asset.kind, SuspectKind::FormalModel, "{found:?}");
    assert_eq!(found.len(), 1, "{found:?}");
}

/// Of an error of first order half is left at half the step: what is extrapolated speaks against the step, if the step
/// has an effect beyond chance.
#[test]
fn the_rest_of_an_error_of_first_order_is_the_steps() {
    let ledger = [
        piece(
            "M",
            Technique::ModelChecking,
            "m.prism",
            vec![computed(mode("grip"), 0.04)],
        ),
        piece(
            "S",
            Technique::Simulation,
            "s.toml",
            vec![counted(mode("grip"), 24, 100)],
        ),
    ];
    let conflicts = [conflict(mode("grip"), "M", "S")];
    let shares = |changed: &str, score: f64| {
        let clue = Clue {
            inaccuracy: Inaccuracy::Tool,
            asset: SuspectAsset {
                kind: SuspectKind::TimeStep,
                file: None,
                part: Some("time_step_secs = 0.01".into()),
                evidence: vec!["S".into()],
                together: Vec::new(),
                line: None,
            },
            subject: mode("grip"),
            score,
            title: "S comes out otherwise".into(),
            explanation: String::new(),
            symptom: Symptom::RunsOtherwise {
                subject: mode("grip"),
                changed: changed.into(),
                violated: [24, 18],
                episodes: 100,
                differing: 6,
            },
            figures: vec![],
            witnesses: vec![],
            ruled_out: vec![],
            resolved_by: None,
        };
        let found = suspects(&ledger, &conflicts, vec![clue]);
        let of = |kind| {
            let suspect = found.iter().find(|s| s.asset.kind == kind);
            suspect.map_or(0.0, |s| s.score)
        };
        [SuspectKind::TimeStep, SuspectKind::Simulation].map(of)
    };
    let ([step, model], [by_chance, rest]) = (shares(HALF_STEP, 1.2), shares(HALF_STEP, 0.4));
    assert!(
        step > by_chance && model < rest,
        "{step} {model} {by_chance} {rest}"
    );
    // Whatever is extrapolated, the two add up to what the simulation had.
    assert!((step + model - by_chance - rest).abs() < 1e-9);
    // Nothing is halved in another engine.
    assert_eq!(shares("the full physics", 1.2)[1], rest);
}

/// Tables of two conditions, each with what was counted under the other; the model of the second, and a simulator.
#[test]
fn tables_of_two_conditions_that_changed_places_are_told() {
    let under = |conditions: &str, piece: Evidence| Evidence {
        conditions: conditions.into(),
        ..piece
    };
    let requirement = || requirement("1a");
    let formal = |id, file, value| {
        let findings = vec![computed(requirement(), value)];
        piece(id, Technique::ModelChecking, file, findings)
    };
    let table = |id, file, count| {
        let findings = vec![counted(requirement(), count, 200)];
        piece(id, Technique::Experiment, file, findings)
    };
    let study = |calm: u64, windy: u64, simulated: u64| {
        let findings = vec![counted(requirement(), simulated, 200)];
        let simulated = piece("S", Technique::Simulation, "s.toml", findings);
        vec![
            formal("M1", "calm.prism", 0.9),
            under("windy", formal("M2", "windy.prism", 0.6)),
            table("T1", "calm.csv", calm),
            under("windy", table("T2", "windy.csv", windy)),
            under("windy", simulated),
        ]
    };
    let margin = |_: &Subject| 0.05;
    let swapped = study(121, 181, 118);
    let other = |ledger: &[Evidence], place: usize| {
        changed_places(ledger, &ledger[place], &margin).map(|it| it.id.clone())
    };
    assert_eq!(other(&swapped, 2).as_deref(), Some("T2"));
    assert_eq!(other(&swapped, 3).as_deref(), Some("T1"));
    // The models would not agree with the simulator then.
    assert_eq!(other(&swapped, 0), None);
    let conflicts = [
        conflict(requirement(), "M1", "T1"),
        conflict(requirement(), "M2", "T2"),
        conflict(requirement(), "S", "T2"),
    ];
    let found = suspects(&swapped, &conflicts, vec![]);
    assert!(found[0].title.contains("changed places"), "{found:?}");
    assert_eq!(
        found[0].asset.file.as_deref(),
        Some("ledger.toml"),
        "{found:?}"
    );
    assert!(found[0].asset.together.contains(&"calm.csv".to_owned()));
    // One of them is wrong, and fits nowhere; or is right where it stands.
    for ledger in [
        study(121, 140, 118),
        study(181, 121, 118),
        study(121, 121, 118),
    ] {
        assert!((0..ledger.len()).all(|place| other(&ledger, place).is_none()));
    }
    // Without a simulator the models may be what changed places.
    let without = &swapped[..4];
    assert_eq!(other(without, 0).as_deref(), Some("M2"));
    let found = suspects(without, &conflicts[..2], vec![]);
    let parts: Vec<&str> = found
        .iter()
        .filter_map(|it| it.asset.part.as_deref())
        .collect();
    let both = ["the files of M1 and M2", "the files of T1 and T2"];
    assert!(both.iter().all(|it| parts.contains(it)), "{found:?}");
    assert!(
        found[0].asset.together.contains(&"calm.prism".to_owned()),
        "{found:?}"
    );
}
