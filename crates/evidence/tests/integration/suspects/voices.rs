//! Models that share an assumption, files that are not told apart, and single edits that explain a conflict.

use super::*;

fn ranked(ledger: &[Evidence], conflicts: &[Comparison], more: Vec<Clue>) -> Vec<Suspect> {
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

/// A model and a simulation that agree, and a table that differs from both.
fn two_models_and_a_table() -> Vec<Evidence> {
    let grip = mode("grip");
    vec![
        piece(
            "M",
            Technique::ModelChecking,
            "m.prism",
            vec![computed(grip.clone(), 0.35)],
        ),
        piece(
            "S",
            Technique::Simulation,
            "s.toml",
            vec![counted(grip.clone(), 35, 100)],
        ),
        piece(
            "X",
            Technique::Experiment,
            "x.csv",
            vec![counted(grip, 6, 100)],
        ),
    ]
}

fn both_conflict() -> [Comparison; 2] {
    [
        conflict(mode("grip"), "M", "X"),
        conflict(mode("grip"), "S", "X"),
    ]
}

fn set_to(from: &str) -> Calibration {
    Calibration {
        parameter: "p".into(),
        from: from.into(),
        subject: mode("grip"),
        chosen: false,
    }
}

#[test]
fn two_models_with_one_assumption_do_not_make_the_experiment_the_odd_one_out() {
    // Independent of each other, they do.
    let apart = two_models_and_a_table();
    let found = ranked(&apart, &both_conflict(), vec![]);
    assert_eq!(found[0].asset.kind, SuspectKind::Data, "{found:?}");
    // Set to the same counts, copied from each other, or out of the same file: they do not.
    let mut calibrated = two_models_and_a_table();
    calibrated[0].calibrated = vec![set_to("old")];
    calibrated[1].calibrated = vec![set_to("old")];
    let mut copied = two_models_and_a_table();
    copied[1].calibrated = vec![set_to("M")];
    let mut shared = two_models_and_a_table();
    let common = shared[0].assets[0].clone();
    shared[1].assets.push(common);
    for ledger in [calibrated, copied, shared] {
        let found = ranked(&ledger, &both_conflict(), vec![]);
        assert_ne!(found[0].asset.kind, SuspectKind::Data, "{found:?}");
        let of_data = found.iter().find(|s| s.asset.kind == SuspectKind::Data);
        let odd = of_data.and_then(Suspect::odd_one_out);
        assert!(odd.is_none_or(|odd| odd < 0.5), "{found:?}");
    }
    // Counts of something else are no common assumption about this.
    let mut other = two_models_and_a_table();
    for piece in &mut other[..2] {
        piece.calibrated = vec![Calibration {
            subject: mode("pressure"),
            ..set_to("old")
        }];
    }
    let found = ranked(&other, &both_conflict(), vec![]);
    assert_eq!(found[0].asset.kind, SuspectKind::Data, "{found:?}");
}

#[test]
fn voices_partition_the_pieces_whatever_their_order() {
    let mut ledger = two_models_and_a_table();
    ledger[1].calibrated = vec![set_to("X")];
    let subject = mode("grip");
    let ids = |order: [usize; 3]| -> Vec<Vec<String>> {
        let pieces: Vec<&Evidence> = order.iter().map(|at| &ledger[*at]).collect();
        let all = voices(&pieces, &subject).into_iter().map(|voice| {
            let mut ids: Vec<String> = voice.iter().map(|piece| piece.id.clone()).collect();
            ids.sort();
            ids
        });
        let mut all: Vec<Vec<String>> = all.collect();
        all.sort();
        all
    };
    let wanted = vec![vec!["M".to_owned()], vec!["S".to_owned(), "X".to_owned()]];
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2], [2, 0, 1]] {
        assert_eq!(ids(order), wanted);
    }
}

#[test]
fn a_simulation_is_named_by_what_says_how_it_behaves_with_its_other_files() {
    let mut ledger = two_models_and_a_table();
    ledger[1].assets = ["scene.toml", "robot.urdf", "hand.stl"]
        .map(|path| Asset {
            role: AssetRole::SystemModel,
            path: path.into(),
            hash: String::new(),
        })
        .to_vec();
    let asset = system_model(&ledger[1]);
    assert_eq!(asset.file.as_deref(), Some("scene.toml"));
    assert_eq!(asset.together, ["robot.urdf", "hand.stl"]);
    let said = asset.together_in_words().expect("others");
    assert!(said.contains("robot.urdf, hand.stl"), "{said}");
}

#[test]
fn an_edit_takes_its_share_from_the_system_models_of_the_pairs_that_it_explains() {
    let ledger = two_models_and_a_table();
    let conflicts = [conflict(mode("grip"), "S", "X")];
    let edit = |pair: [&str; 2], share: f64| Clue {
        inaccuracy: Inaccuracy::RequirementModel,
        asset: SuspectAsset {
            kind: SuspectKind::Vocabulary,
            file: Some("topics.toml".into()),
            part: Some("/x, unit".into()),
            evidence: pair.map(str::to_owned).to_vec(),
            together: Vec::new(),
            line: Some(3),
        },
        subject: mode("grip"),
        score: 5.0 * share,
        title: "a unit".into(),
        explanation: String::new(),
        symptom: Symptom::EditExplains {
            subject: mode("grip"),
            found: "m".into(),
            instead: "cm".into(),
            pairs: vec![pair.map(str::to_owned)],
            share,
        },
        figures: vec![],
        witnesses: vec![],
        ruled_out: vec![],
        resolved_by: None,
    };
    let score = |found: &[Suspect], kind: SuspectKind| {
        let own = found.iter().find(|s| s.asset.kind == kind);
        own.map_or(0.0, |s| s.score)
    };
    let plain = ranked(&ledger, &conflicts, vec![]);
    let own = ranked(&ledger, &conflicts, vec![edit(["S", "X"], 0.9)]);
    let other = ranked(&ledger, &conflicts, vec![edit(["M", "Y"], 0.9)]);
    for kind in [SuspectKind::Data, SuspectKind::Simulation] {
        let whole = score(&plain, kind);
        assert!((score(&own, kind) - 0.1 * whole).abs() < 1e-9, "{own:?}");
        assert_eq!(score(&other, kind), whole);
    }
    assert_eq!(own[0].asset.line, Some(3));
}

#[test]
fn traces_without_a_verdict_may_all_count_and_may_all_not() {
    let subject = mode("grip");
    let place = CellPlace {
        traces: Traces::Model,
        judged_by: JudgedBy::Property,
        evidence: "M",
        subject: &subject,
    };
    let verdicts = VerdictCounts {
        violated: 55,
        undecided: 945,
        ..VerdictCounts::default()
    };
    let cell = place.filled(verdicts, Confidence::P95);
    assert_eq!(cell.shares(), [0.055, 1.0]);
    assert_eq!(cell.share_near(0.2), 0.2);
    assert_eq!(cell.share_near(0.01), 0.055);
}

/// Runs of a simulator and recordings are read through the same words: where both differ from what people counted, the words
/// are named before the table; where one of them agrees with it, they are not.
#[test]
fn a_simulator_and_recordings_that_agree_accuse_what_both_are_read_through() {
    let read = |id: &str, technique, count: u64| {
        let mut finding = counted(requirement("3"), count, 100);
        finding.witnesses = vec!["run-1".to_owned()];
        piece(id, technique, &format!("{id}.csv"), vec![finding])
    };
    // No run is a witness of what people counted.
    let table = |count| {
        let mut finding = counted(requirement("3"), count, 300);
        finding.witnesses.clear();
        piece("X", Technique::Experiment, "x.csv", vec![finding])
    };
    let among = |ledger: &[Evidence], pairs: &[[&str; 2]]| {
        let all = pairs.iter();
        let all: Vec<Comparison> = all
            .map(|[one, other]| conflict(requirement("3"), one, other))
            .collect();
        ranked(ledger, &all, vec![])
    };
    let ledger = [
        read("S", Technique::Simulation, 55),
        read("O", Technique::Experiment, 52),
        table(292),
    ];
    let found = among(&ledger, &[["S", "X"], ["O", "X"]]);
    let [first, second, ..] = found.as_slice() else {
        panic!("{found:?}");
    };
    assert_eq!(first.asset.kind, SuspectKind::Vocabulary, "{found:?}");
    assert_eq!(first.asset.evidence, ["S", "O"]);
    assert_eq!(second.asset.file.as_deref(), Some("x.csv"), "{found:?}");
    // The recordings agree with the table, through the same words.
    let ledger = [
        read("S", Technique::Simulation, 55),
        read("O", Technique::Experiment, 97),
        table(292),
    ];
    let found = among(&ledger, &[["S", "X"], ["S", "O"]]);
    let is_word = |it: &Suspect| it.asset.kind == SuspectKind::Vocabulary && it.score > 1.0;
    assert!(!found.iter().any(is_word), "{found:?}");
    assert_eq!(found[0].asset.evidence, ["S"], "{found:?}");
    // One piece alone is misread rather than wrong if all its runs are alike.
    for (count, is_named) in [(0, true), (55, false)] {
        let ledger = [read("O", Technique::Experiment, count), table(292)];
        let found = among(&ledger, &[["O", "X"]]);
        let named = found[0].asset.kind == SuspectKind::Vocabulary;
        assert_eq!(named, is_named, "{found:?}");
    }
}
