//! Up to which intraclass correlation decisions hold, against the tests that decide them.

use evidence::{
    ASSUMED_GROUP, CORRELATIONS, ClusterTests, Direction, Evidence, Influences, Levels,
    Requirement, Study, Threshold, Verdict, bear_clustering, compare, conclude,
};
use stats::{EffectiveSample, Sample, clustered_test_above};

fn experiment(id: &str, count: u64, trials: u64) -> Evidence {
    let finding = serde_json::json!({
        "subject": { "kind": "requirement", "id": "1" },
        "measure": {
            "kind": "counts", "count": count, "trials": trials, "effective_trials": null,
            "interval": { "low": 0.0, "high": 1.0 },
        },
        "undecided": 0, "witnesses": [], "readings": [],
    });
    let piece = serde_json::json!({
        "id": id, "title": id, "technique": "experiment",
        "tool": { "name": "the robot", "version": "", "settings": "" },
        "assets": [], "conditions": "typical", "changed": "", "calibrated": [], "intermediate": false,
        "published": false, "findings": [finding], "inputs": "",
    });
    serde_json::from_value(piece).expect("a piece of evidence")
}

/// The verdict and the sensitivities of the only requirement, at least 90 %, and of the pairs.
fn judged(
    evidence: &[Evidence],
) -> (
    Verdict,
    Vec<evidence::ClusterSensitivity>,
    Vec<Option<evidence::ClusterSensitivity>>,
) {
    let requirement: Requirement = serde_json::from_value(serde_json::json!({
        "id": "1", "text": "It works.", "margin": 0.1,
    }))
    .expect("a requirement");
    let requirement = Requirement {
        threshold: Some(Threshold {
            direction: Direction::AtLeast,
            value: 0.9,
        }),
        ..requirement
    };
    let influences = Influences::default();
    let requirements = [requirement];
    let study = Study {
        requirements: &requirements,
        failure_modes: &[],
        evidence,
        influences: &influences,
        levels: Levels::new(0.95, 0.95).expect("levels"),
        looks: None,
    };
    let mut comparisons = compare(&study);
    let mut conclusions = conclude(&study, &comparisons);
    bear_clustering(&study, &mut comparisons, &mut conclusions);
    let pairs = comparisons.into_iter().map(|pair| pair.clustering);
    let conclusion = conclusions.remove(0);
    (conclusion.verdict, conclusion.clustering, pairs.collect())
}

/// The largest correlation before the first at which the test of the threshold does not reject.
fn expected(count: u64, trials: u64, group: u64) -> Option<f64> {
    let sample = Sample {
        successes: count,
        trials,
    };
    let mut below = 0.0;
    for correlation in CORRELATIONS {
        let size = trials as f64 / (1.0 + (group as f64 - 1.0) * correlation);
        let worth = EffectiveSample::at_size(sample, size).expect("a size");
        if clustered_test_above(worth, 0.9) > 0.05 {
            return Some(below);
        }
        below = correlation;
    }
    None
}

#[test]
fn a_verdict_holds_as_far_as_its_test_does() {
    let mut holds = Vec::new();
    for (count, trials) in [(190, 200), (195, 200), (198, 200), (1980, 2000)] {
        let (verdict, clustering, _) = judged(&[experiment("E", count, trials)]);
        assert_eq!(verdict, Verdict::Satisfied);
        let [found] = clustering.as_slice() else {
            panic!("{clustering:?}");
        };
        assert!(found.is_assumed && found.group_size == ASSUMED_GROUP as f64);
        assert_eq!(found.evidence, ["E"]);
        assert_eq!(
            found.holds_up_to,
            expected(count, trials, ASSUMED_GROUP),
            "{found:?}"
        );
        holds.push(found.holds_up_to.unwrap_or(2.0));
    }
    assert!(holds.is_sorted() && holds[0] < holds[3], "{holds:?}");
}

#[test]
fn trials_of_one_person_are_that_many_of_one_group() {
    let mut piece = experiment("E", 195, 200);
    piece.clusters = Some(ClusterTests {
        subjects: 1,
        one_for_all: Some("the arm works alone".into()),
        effective_trials: 200.0,
        ..ClusterTests::default()
    });
    let (_, clustering, _) = judged(&[piece.clone()]);
    assert_eq!(clustering[0].holds_up_to, expected(195, 200, 200));
    assert!(!clustering[0].is_assumed && clustering[0].group_size == 200.0);
    assert!(
        clustering[0]
            .statement
            .contains("one person or session, declared to stand for all"),
        "{clustering:?}"
    );
    // Without the declaration they decide nothing of others.
    if let Some(clusters) = &mut piece.clusters {
        clusters.one_for_all = None;
    }
    assert_eq!(judged(&[piece.clone()]).0, Verdict::Undecided);
    // Of several people who did one trial each nothing is unknown.
    piece.clusters = Some(ClusterTests {
        subjects: 200,
        ..ClusterTests::default()
    });
    assert!(judged(&[piece]).1.is_empty());
}

#[test]
fn agreement_has_its_own_correlation_and_what_is_undecided_has_none() {
    let alike = [experiment("A", 380, 400), experiment("B", 378, 400)];
    let (_, _, pairs) = judged(&alike);
    let found = pairs[0].as_ref().expect("an agreement");
    assert_eq!(found.evidence, ["A", "B"]);
    assert!(
        found
            .holds_up_to
            .is_some_and(|most| most > 0.0 && most < 1.0),
        "{found:?}"
    );
    let few = [experiment("A", 9, 10), experiment("B", 8, 10)];
    let (verdict, clustering, pairs) = judged(&few);
    assert_eq!(verdict, Verdict::Undecided);
    assert!(clustering.is_empty() && pairs[0].is_none());
}
