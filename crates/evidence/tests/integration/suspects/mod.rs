//! Who is suspected first, on the handover's first three pieces of evidence and on planted faults.

mod never;
mod odd;
mod voices;

use evidence::*;
use stats::{Confidence, Sample, wilson};

fn counted(subject: Subject, count: u64, trials: u64) -> Finding {
    let sample = Sample::new(count, trials).unwrap();
    let interval = wilson(sample, Confidence::P95);
    let interval = Interval {
        low: interval.low,
        high: interval.high,
    };
    finding(
        subject,
        Measure::Counts {
            by_subject: None,
            subjects: None,
            count,
            trials,
            effective_trials: None,
            interval,
        },
    )
}

fn finding(subject: Subject, measure: Measure) -> Finding {
    Finding {
        subject,
        measure,
        denominator: evidence::Denominator::default(),
        trigger: None,
        undecided: 0,
        left_out: 0,
        completions: None,
        witnesses: vec!["episode-00002.mcap".into()],
        readings: vec![],
    }
}

fn method(method: &str, value: f64, guarantee: Guarantee) -> MethodAnswer {
    MethodAnswer {
        method: method.into(),
        value,
        complement: None,
        guarantee,
        iterations: None,
    }
}

fn bounded(value: f64) -> Guarantee {
    let (low, high) = (value - 1e-9, (value + 1e-9).min(1.0));
    Guarantee::Bounded { low, high }
}

fn computed(subject: Subject, value: f64) -> Finding {
    let answer = method("sound", value, bounded(value));
    finding(
        subject,
        Measure::Probability {
            answer,
            others: vec![],
            credible: None,
        },
    )
}

fn requirement(id: &str) -> Subject {
    Subject::Requirement(id.into())
}

fn mode(id: &str) -> Subject {
    Subject::FailureMode(id.into())
}

fn piece(id: &str, technique: Technique, file: &str, findings: Vec<Finding>) -> Evidence {
    let role = match technique {
        Technique::ModelChecking | Technique::Simulation => AssetRole::SystemModel,
        _ => AssetRole::Data,
    };
    let text = String::new;
    Evidence {
        id: id.into(),
        title: id.into(),
        technique,
        tool: Tool {
            name: text(),
            version: text(),
            settings: text(),
        },
        assets: vec![Asset {
            role,
            path: file.into(),
            hash: text(),
        }],
        conditions: "typical".into(),
        changed: text(),
        calibrated: vec![],
        intermediate: false,
        published: false,
        reproduced_by: None,
        findings,
        form_differences: vec![],
        description_gaps: vec![],
        failures: vec![],
        clusters: None,
        shared_rows: Vec::new(),
        common_texts: Vec::new(),
        shared_seeds: Vec::new(),
        undecided_at_random: None,
        alike_trials: None,
        lineage_questions: Vec::new(),
        inputs: text(),
    }
}

fn conflict(subject: Subject, left: &str, right: &str) -> Comparison {
    Comparison {
        subject,
        left: left.into(),
        right: right.into(),
        outcome: Outcome::Conflicts,
        relation: None,
        independent: true,
        difference: None,
        difference_interval: None,
        margin: 0.05,
        p_difference: None,
        p_difference_corrected: None,
        p_equivalence: None,
        probability_within_margin: None,
        possibly_copied: false,
        paired: false,
        clustering: None,
        trigger: None,
        trigger_not_compared: None,
        looking: None,
        further_trials: vec![],
        reason: String::new(),
    }
}

fn requirements() -> Vec<Requirement> {
    let of = |id: &str, margin| Requirement {
        id: id.into(),
        text: String::new(),
        threshold: None,
        sentence: None,
        property: None,
        monitor: None,
        margin,
        asks_for: None,
        same_quantity_as: None,
        ..Requirement::default()
    };
    vec![of("1a", 0.10), of("3", 0.05)]
}

fn modes() -> Vec<FailureMode> {
    let of = |id: &str, margin| FailureMode {
        id: id.into(),
        name: id.into(),
        meaning: String::new(),
        margin,
    };
    vec![
        of("grip", 0.05),
        of("runtime_error", 0.02),
        of("pressure", 0.05),
    ]
}

fn ranked(evidence: &[Evidence], comparisons: &[Comparison], cells: &[Cell]) -> Vec<Suspect> {
    let (requirements, failure_modes) = (requirements(), modes());
    let matter = Matter {
        requirements: &requirements,
        failure_modes: &failure_modes,
        evidence,
        comparisons,
        cells,
        tables: &[],
        study: "handover",
    };
    rank(&matter, vec![])
}

fn missing(id: &str) -> Finding {
    let reason = "The model does not express it.".to_owned();
    finding(mode(id), Measure::NotExpressible { reason })
}

fn first_model() -> Evidence {
    let findings = vec![
        computed(requirement("1a"), 1.0),
        computed(requirement("3"), 1.0),
        missing("grip"),
        missing("runtime_error"),
    ];
    piece("E1", Technique::ModelChecking, "models/v1.prism", findings)
}

fn untuned() -> Evidence {
    let findings = vec![
        counted(requirement("1a"), 80, 100),
        counted(requirement("3"), 80, 80),
        counted(mode("grip"), 20, 100),
        counted(mode("runtime_error"), 0, 100),
    ];
    piece(
        "E2",
        Technique::Simulation,
        "simulation/untuned.toml",
        findings,
    )
}

fn experiments() -> Evidence {
    let findings = vec![
        counted(requirement("1a"), 88, 100),
        counted(requirement("3"), 88, 98),
        counted(mode("grip"), 3, 100),
        counted(mode("runtime_error"), 0, 100),
    ];
    piece(
        "E3",
        Technique::Experiment,
        "experiments/modes.csv",
        findings,
    )
}

#[test]
fn the_first_model_is_named_first_for_the_modes_it_lacks() {
    let ledger = [first_model(), untuned(), experiments()];
    let conflicts = [
        conflict(requirement("1a"), "E1", "E2"),
        conflict(requirement("1a"), "E1", "E3"),
        conflict(mode("grip"), "E2", "E3"),
    ];
    let suspects = ranked(&ledger, &conflicts, &[]);
    let first = &suspects[0];
    assert_eq!(first.asset.file.as_deref(), Some("models/v1.prism"));
    assert_eq!(first.asset.kind, SuspectKind::FormalModel);
    assert!(first.score > 2.0, "{}", first.score);
    let lacks = |symptom: &Symptom| {
        matches!(symptom, Symptom::MissingMode { mode, shown }
            if mode == "grip" && shown[0] == ("E2".to_owned(), 20, 100))
    };
    assert!(first.symptoms.iter().any(lacks), "{:?}", first.symptoms);
    let replay = "corroborate replay handover E2:2";
    assert!(
        first.witnesses.iter().any(|w| w.replay == replay),
        "{:?}",
        first.witnesses
    );
    // Of simulation and experiments, which differ in grip failures, the simulation.
    assert_eq!(
        suspects[1].asset.file.as_deref(),
        Some("simulation/untuned.toml")
    );
    let ranks: Vec<u32> = suspects.iter().map(|s| s.rank).collect();
    assert_eq!(ranks, (1..=suspects.len() as u32).collect::<Vec<_>>());
}

#[test]
fn a_reading_that_removes_a_conflict_accuses_the_monitor_and_clears_the_models() {
    let mut tuned = untuned();
    tuned.findings = vec![counted(requirement("3"), 446, 446)];
    tuned.findings[0].readings = vec![Reading {
        name: "human".into(),
        meaning: "by what the human does".into(),
        count: 446,
        trials: 493,
        differing: 47,
        witnesses: vec!["episode-00017.mcap".into()],
    }];
    let ledger = [experiments(), tuned];
    let suspects = ranked(&ledger, &[conflict(requirement("3"), "E3", "E2")], &[]);
    let first = &suspects[0];
    assert_eq!(first.inaccuracy, Inaccuracy::RequirementModel);
    assert_eq!(first.asset.part.as_deref(), Some("requirement 3, monitor"));
    assert!(
        first.ruled_out[0].contains("the system models"),
        "{:?}",
        first.ruled_out
    );
    assert_eq!(
        first.witnesses[0].replay,
        "corroborate replay handover E2:17"
    );
    assert_eq!(suspects.len(), 1, "{suspects:?}");
}

/// The handover's requirement 3: the sentence says what the monitor says, and the experiments contradict both.
#[test]
fn what_people_counted_comes_before_the_sentence() {
    let judged = |id: &str, technique, file: &str, main, cell, judged_by, count| {
        let piece = piece(id, technique, file, vec![main]);
        let (is_model, id) = (technique == Technique::ModelChecking, id.to_owned());
        let traces = match is_model {
            true => Traces::Model,
            false => Traces::Simulator,
        };
        let cell = Cell {
            cell,
            traces,
            judged_by,
            evidence: id,
            subject: requirement("3"),
            count,
            trials: 500,
            runs: 500,
            undecided: 0,
            interval: None,
            not_judged: None,
        };
        (piece, cell)
    };
    let own = |count| counted(requirement("3"), count, 500);
    let by_property = ('B', JudgedBy::Property);
    let named = |experiments: (u64, u64)| {
        let (letter, form) = by_property;
        let (mut simulated, of_runs) = judged(
            "E4",
            Technique::Simulation,
            "s.toml",
            own(500),
            letter,
            form,
            449,
        );
        simulated.form_differences = vec![FormDifference {
            subject: requirement("3"),
            reference: "sentence".into(),
            reference_verdict: RunVerdict::Satisfied,
            form: "property".into(),
            verdict: RunVerdict::Violated,
            count: 51,
            runs: 500,
            witnesses: vec!["episode-00005.mcap".into()],
        }];
        let value = computed(requirement("3"), 0.88);
        let (formal, of_paths) = judged(
            "E5",
            Technique::ModelChecking,
            "m",
            value,
            'D',
            JudgedBy::Monitor,
            500,
        );
        let mut on_paths = of_paths.clone();
        (on_paths.cell, on_paths.judged_by, on_paths.count) = ('A', JudgedBy::Property, 440);
        let counts = vec![counted(requirement("3"), experiments.0, experiments.1)];
        let people = piece("E3", Technique::Experiment, "people.csv", counts);
        let ledger = [people, simulated, formal];
        let conflicts = [conflict(requirement("3"), "E4", "E5")];
        let suspects = ranked(&ledger, &conflicts, &[of_runs, of_paths, on_paths]);
        let first = suspects.into_iter().next().expect("a suspect");
        (first.asset.part.unwrap_or_default(), first.explanation)
    };
    let (part, why) = named((88, 98));
    assert_eq!(part, "requirement 3, monitor", "{why}");
    assert!(why.contains("the sentence says the same"), "{why}");
    // Where they take the side of the sentence, or of none since they are few, the property is in doubt.
    assert_eq!(named((98, 98)).0, "requirement 3, property");
    assert_eq!(named((5, 5)).0, "requirement 3, property");
}

#[test]
fn a_wrong_rate_accuses_the_one_that_differs_from_all_others() {
    for (odd, file) in [(0, "models/v2.prism"), (1, "sim.toml"), (2, "counts.csv")] {
        let rate = |place| if place == odd { 30 } else { 7 };
        let ledger = [
            piece(
                "M",
                Technique::ModelChecking,
                "models/v2.prism",
                vec![computed(mode("pressure"), rate(0) as f64 / 100.0)],
            ),
            piece(
                "S",
                Technique::Simulation,
                "sim.toml",
                vec![counted(mode("pressure"), 5 * rate(1), 500)],
            ),
            piece(
                "X",
                Technique::Experiment,
                "counts.csv",
                vec![counted(mode("pressure"), 3 * rate(2), 300)],
            ),
        ];
        let ids = ["M", "S", "X"];
        let others = (0..3).filter(|place| *place != odd);
        let conflicts: Vec<Comparison> = others
            .map(|other| conflict(mode("pressure"), ids[odd], ids[other]))
            .collect();
        let suspects = ranked(&ledger, &conflicts, &[]);
        assert_eq!(
            suspects[0].asset.file.as_deref(),
            Some(file),
            "{suspects:?}"
        );
        assert!(suspects[0].score > 2.0);
    }
}

/// A suspect may be read without its headline, and be found on several requirements.
#[test]
fn an_argument_names_the_requirement_that_it_was_found_on() {
    let of = |id: &str, technique, file: &str, kept: [u64; 2]| {
        let findings = [("1a", kept[0]), ("3", kept[1])];
        let findings = findings.map(|(subject, count)| counted(requirement(subject), count, 200));
        piece(id, technique, file, findings.to_vec())
    };
    let mut simulated = of("S", Technique::Simulation, "sim.toml", [120, 110]);
    simulated.form_differences = vec![FormDifference {
        subject: requirement("3"),
        reference: "sentence".into(),
        reference_verdict: RunVerdict::Satisfied,
        form: "monitor".into(),
        verdict: RunVerdict::Violated,
        count: 60,
        runs: 200,
        witnesses: vec![],
    }];
    let people = of("X", Technique::Experiment, "x.csv", [190, 190]);
    let conflicts = ["1a", "3"].map(|id| conflict(requirement(id), "S", "X"));
    for suspect in ranked(&[simulated, people], &conflicts, &[]) {
        for subject in &suspect.subjects {
            let name = subject.in_words();
            assert!(suspect.explanation.contains(&name), "{name}: {suspect:?}");
        }
    }
}

#[test]
fn a_solver_that_stopped_early_is_named_before_the_models() {
    let mut model = first_model();
    model.findings = vec![computed(requirement("1a"), 0.0)];
    let reason = "it stopped".to_owned();
    model.findings[0].measure = Measure::Probability {
        answer: method("prism-default", 0.5, Guarantee::Estimated { reason }),
        others: vec![method("sound", 0.86, bounded(0.86))],
        credible: None,
    };
    let ledger = [model, experiments()];
    let suspects = ranked(&ledger, &[conflict(requirement("1a"), "E1", "E3")], &[]);
    assert_eq!(suspects[0].asset.kind, SuspectKind::Solver, "{suspects:?}");
    assert_eq!(suspects[0].inaccuracy, Inaccuracy::Tool);
}

#[test]
fn the_same_property_on_runs_separates_requirement_from_system() {
    let cell = |count| Cell {
        cell: 'B',
        traces: Traces::Simulator,
        judged_by: JudgedBy::Property,
        evidence: "E2".into(),
        subject: requirement("1a"),
        count,
        trials: 100,
        runs: 100,
        undecided: 0,
        interval: None,
        not_judged: None,
    };
    let ledger = [first_model(), untuned()];
    let conflicts = [conflict(requirement("1a"), "E1", "E2")];
    // The property agrees with the model on the simulator's runs: the monitor is to blame.
    let suspects = ranked(&ledger, &conflicts, &[cell(100)]);
    let monitor = |s: &Suspect| s.asset.part.as_deref() == Some("requirement 1a, monitor");
    let of_monitor = suspects
        .iter()
        .find(|s| monitor(s))
        .expect("the monitor is named");
    assert!(of_monitor.score > 1.0, "{}", of_monitor.score);
    // It agrees with the monitor: the models are.
    let suspects = ranked(&ledger, &conflicts, &[cell(80)]);
    assert!(suspects.iter().all(|s| !monitor(s)), "{suspects:?}");
    assert_eq!(suspects[0].asset.file.as_deref(), Some("models/v1.prism"));
}

/// What judges some hundred paths says less than a computed value. A conflict that only shrinks for that is not explained.
#[test]
fn a_form_that_says_the_same_on_the_same_paths_explains_nothing() {
    let cell = |cell, judged_by, traces, evidence: &str, count, trials| Cell {
        cell,
        traces,
        judged_by,
        evidence: evidence.into(),
        subject: requirement("1a"),
        count,
        trials,
        runs: trials,
        undecided: 0,
        interval: None,
        not_judged: None,
    };
    let paths = |letter, judged_by, count| cell(letter, judged_by, Traces::Model, "M", count, 400);
    let runs = |letter, judged_by| cell(letter, judged_by, Traces::Simulator, "S", 575, 1000);
    let model = vec![computed(requirement("1a"), 0.8)];
    let simulated = vec![counted(requirement("1a"), 575, 1000)];
    let ledger = [
        piece("M", Technique::ModelChecking, "models/v2.prism", model),
        piece("S", Technique::Simulation, "sim.toml", simulated),
    ];
    let conflicts = [conflict(requirement("1a"), "M", "S")];
    let on_runs = [runs('B', JudgedBy::Property), runs('E', JudgedBy::Monitor)];
    let of_forms = |own: Option<u64>, monitor: u64| {
        let mut cells = on_runs.to_vec();
        cells.extend(own.map(|count| paths('A', JudgedBy::Property, count)));
        cells.push(paths('D', JudgedBy::Monitor, monitor));
        let suspects = ranked(&ledger, &conflicts, &cells);
        let is_form = |s: &&Suspect| s.inaccuracy == Inaccuracy::RequirementModel;
        suspects
            .iter()
            .filter(is_form)
            .map(|s| s.score)
            .sum::<f64>()
    };
    assert_eq!(of_forms(Some(318), 318), 0.0);
    // The property could not be judged on paths, and the monitor does not contradict it.
    assert_eq!(of_forms(None, 318), 0.0);
    // On the same paths the monitor finds what the simulation does.
    assert!(of_forms(Some(318), 228) > 10.0);
    assert!(of_forms(None, 228) > 10.0);
}
