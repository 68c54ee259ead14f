//! The assurance case: sound as an argument, complete, and nothing added.

use crate::fixture;

use evidence::*;
use report::assurance::{Argument, Kind, case, provenance, yaml};
use serde_json::Value;
use std::collections::BTreeSet;

fn studies() -> [StudyResult; 3] {
    [fixture::study(), fixture::empty(), fixture::hostile()]
}

/// What GSN asks of every argument.
fn check(argument: &Argument) {
    let ids: BTreeSet<&str> = argument.nodes.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(ids.len(), argument.nodes.len(), "identifiers are unique");
    let mut referred = BTreeSet::new();
    for node in &argument.nodes {
        assert!(node.id.starts_with(node.kind.prefix()), "{}", node.id);
        let claims = matches!(node.kind, Kind::Goal | Kind::Strategy);
        assert_eq!(
            node.undeveloped,
            claims && node.supported_by.is_empty(),
            "{}",
            node.id
        );
        for id in node.supported_by.iter().chain(&node.in_context_of) {
            assert!(ids.contains(id.as_str()), "{id}");
            assert!(referred.insert(id.as_str()), "{id} has one place");
        }
        if let Some(target) = &node.challenges {
            assert_eq!(node.kind, Kind::CounterGoal);
            assert!(ids.contains(target.as_str()) && *target != node.id);
        }
        if node.defeated {
            assert!(argument.challengers(&node.id).count() > 0, "{}", node.id);
        }
        if let Some(point) = &node.claim_point {
            assert!(
                point.at == node.id || node.supported_by.contains(&point.at),
                "{point:?}"
            );
        }
    }
    let tops = argument
        .nodes
        .iter()
        .filter(|n| n.challenges.is_none() && !referred.contains(n.id.as_str()));
    let tops: Vec<&str> = tops.map(|n| n.id.as_str()).collect();
    assert_eq!(
        tops,
        [argument.nodes[0].id.as_str()],
        "one claim is at the top"
    );
}

#[test]
fn arguments_are_well_formed() {
    for study in studies() {
        let case = case(&study);
        check(&case.safety);
        check(&case.confidence);
    }
}

#[test]
fn every_claim_point_is_argued() {
    let case = case(&fixture::study());
    let points = case
        .safety
        .nodes
        .iter()
        .filter_map(|n| n.claim_point.as_ref());
    let points: Vec<&str> = points.map(|p| p.name.as_str()).collect();
    assert!(points.len() >= 5, "{points:?}");
    for point in points {
        let start = format!("{point}: ");
        let goals = case.confidence.nodes.iter();
        assert_eq!(
            goals.filter(|n| n.text.starts_with(&start)).count(),
            1,
            "{point}"
        );
    }
}

#[test]
fn evidence_is_cited_by_identifier_and_hash() {
    let study = fixture::study();
    let case = case(&study);
    let mut cited = BTreeSet::new();
    for node in case
        .safety
        .nodes
        .iter()
        .filter(|n| matches!(n.kind, Kind::Solution | Kind::CounterSolution))
    {
        let citation = node
            .citation
            .as_ref()
            .expect("a solution of the safety argument cites");
        let piece = study
            .evidence
            .iter()
            .find(|e| e.id == citation.evidence)
            .expect("known evidence");
        assert_eq!(citation.inputs, piece.inputs);
        cited.insert(citation.evidence.as_str());
    }
    for conclusion in &study.conclusions {
        for id in &conclusion.rests_on {
            assert!(cited.contains(id.as_str()), "{id}");
        }
    }
}

/// The verdict decides what becomes of a goal, and conflicts and gaps are not left out.
#[test]
fn the_argument_says_what_the_study_concluded() {
    let study = fixture::study();
    let case = case(&study);
    for conclusion in &study.conclusions {
        let start = format!("Requirement {} holds", conclusion.requirement);
        let goal = case
            .safety
            .nodes
            .iter()
            .find(|n| n.text.starts_with(&start))
            .expect("a goal");
        let challenged = case.safety.challengers(&goal.id).next().is_some();
        match conclusion.verdict {
            Verdict::Violated => assert!(goal.defeated, "{}", goal.id),
            Verdict::Conflicting => assert!(challenged && !goal.defeated, "{}", goal.id),
            Verdict::NotCovered => assert!(goal.undeveloped || !goal.supported_by.is_empty()),
            Verdict::Satisfied => assert!(!goal.defeated, "{}", goal.id),
            Verdict::Undecided => assert!(!goal.defeated, "{}", goal.id),
        }
    }
    let texts: Vec<&str> = case.safety.nodes.iter().map(|n| n.text.as_str()).collect();
    for gap in &study.gaps {
        if let Subject::Requirement(_) = gap.subject {
            assert!(
                texts.iter().any(|t| t.contains(&gap.reason)),
                "{}",
                gap.reason
            );
        }
    }
}

/// Trials under other conditions stand in the argument with their reason, though no claim rests on them.
#[test]
fn what_is_left_out_is_named_in_the_argument() {
    let mut study = fixture::study();
    let words = "Z9 was done under other conditions: at night.";
    study.conclusions[0].excluded.push(Excluded {
        evidence: "Z9".into(),
        reason: ExclusionReason::OtherConditions("at night".into()),
        verdict_with_it: None,
        words: words.into(),
    });
    study.conclusions[0].excluded.push(Excluded {
        evidence: "Z8".into(),
        reason: ExclusionReason::NotCovered("nothing".into()),
        verdict_with_it: None,
        words: "Z8 never covered it.".into(),
    });
    let case = case(&study);
    let argument = &case.safety;
    let said = |text: &str| {
        argument
            .nodes
            .iter()
            .filter(|it| it.text.contains(text))
            .count()
    };
    assert_eq!((said(words), said("Z8 never")), (1, 0));
    check(argument);
}

#[test]
fn agreement_that_is_a_fit_supports_nothing() {
    let mut study = fixture::study();
    let solutions = |study: &StudyResult| {
        let case = case(study);
        let nodes = case.confidence.nodes.into_iter();
        nodes
            .filter(|n| n.kind == Kind::Solution && n.citation.is_none())
            .count()
    };
    for comparison in &mut study.comparisons {
        comparison.outcome = Outcome::Corroborates;
        comparison.independent = true;
    }
    assert!(solutions(&study) > 0);
    for comparison in &mut study.comparisons {
        comparison.independent = false;
    }
    assert_eq!(solutions(&study), 0);
}

#[test]
fn a_conflict_makes_a_counter_goal() {
    let mut study = fixture::study();
    for comparison in &mut study.comparisons {
        comparison.outcome = Outcome::Conflicts;
    }
    let case = case(&study);
    for conclusion in study.conclusions.iter().filter(|c| c.rests_on.len() > 1) {
        let start = format!("Requirement {} holds", conclusion.requirement);
        let goal = case
            .safety
            .nodes
            .iter()
            .find(|n| n.text.starts_with(&start))
            .expect("a goal");
        let conflicts = case
            .safety
            .challengers(&goal.id)
            .filter(|n| n.text.starts_with("The evidence conflicts"));
        let pairs = conclusion.rests_on.len() * (conclusion.rests_on.len() - 1) / 2;
        assert!((1..=pairs).contains(&conflicts.count()), "{}", goal.id);
    }
}

/// Every line of the YAML is a key with a value that a scalar can hold: no text breaks out.
#[test]
fn the_yaml_has_only_lines_of_its_own() {
    let keys = [
        "name",
        "brief",
        "charWrap",
        "text",
        "supportedBy",
        "inContextOf",
        "undeveloped",
        "defeated",
        "challenges",
        "acp",
        "url",
        "evidence",
        "blake3",
    ];
    for study in studies() {
        for argument in [case(&study).safety, case(&study).confidence] {
            for line in yaml(&argument).lines().skip(1) {
                match line.strip_prefix("  ") {
                    Some(rest) => {
                        let (key, value) = rest.split_once(": ").expect("a key and a value");
                        assert!(keys.contains(&key), "{line}");
                        assert!(!value.chars().any(char::is_control), "{line}");
                    }
                    None => assert!(line.starts_with('"') && line.ends_with("\":"), "{line}"),
                }
            }
        }
    }
}

#[test]
fn provenance_refers_to_what_it_declares() {
    for study in studies() {
        let text = provenance(&study);
        assert_eq!(text, provenance(&study));
        let document: Value = serde_json::from_str(&text).expect("JSON");
        let declared: BTreeSet<&str> = ["entity", "activity", "agent"]
            .iter()
            .filter_map(|table| document[table].as_object())
            .flat_map(|table| table.keys().map(String::as_str))
            .collect();
        let relations = [
            "used",
            "wasGeneratedBy",
            "wasAssociatedWith",
            "wasDerivedFrom",
            "alternateOf",
        ];
        for relation in relations
            .iter()
            .filter_map(|name| document[name].as_object())
        {
            for value in relation.values().filter_map(Value::as_object) {
                for (_, name) in value
                    .iter()
                    .filter(|(key, value)| key.starts_with("prov:") && value.is_string())
                {
                    assert!(declared.contains(name.as_str().expect("a name")), "{name}");
                }
            }
        }
        for piece in &study.evidence {
            assert!(text.contains(&serde_json::to_string(&piece.inputs).expect("JSON")));
        }
    }
}

/// Hostile texts, too: what stands in a text stays in it.
#[test]
#[ignore = "needs gsn2x (version 4) in PATH"]
fn gsn2x_finds_no_fault_in_any_study() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    for (place, study) in studies().iter().enumerate() {
        let case = case(study);
        for argument in [&case.safety, &case.confidence] {
            let file = folder.join(format!("{}-{place}.gsn.yaml", argument.name));
            std::fs::create_dir_all(&folder).expect("target folder");
            std::fs::write(&file, yaml(argument)).expect("written");
            let output = std::process::Command::new("gsn2x")
                .arg("-c")
                .arg(&file)
                .output();
            let output = output.expect("gsn2x runs");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(
                output.status.success() && said.is_empty(),
                "{place}: {said}"
            );
        }
    }
}
