//! Failures that a model excludes, and others show.

use super::*;

fn model(grip: f64) -> Evidence {
    let findings = vec![computed(mode("grip"), grip)];
    piece("M", Technique::ModelChecking, "m.prism", findings)
}

fn simulated(count: u64, trials: u64) -> Evidence {
    let findings = vec![counted(mode("grip"), count, trials)];
    piece("S", Technique::Simulation, "s.toml", findings)
}

fn tried(count: u64, trials: u64) -> Evidence {
    let findings = vec![counted(mode("grip"), count, trials)];
    piece("X", Technique::Experiment, "x.csv", findings)
}

/// Few failures, each rate within the margin of 0 or nearly so; but two independent voices have seen what the model says
/// cannot happen.
#[test]
fn what_two_voices_have_seen_is_missing_in_the_model_that_excludes_it() {
    let ledger = [model(0.0), simulated(4, 21), tried(3, 71)];
    for conflicts in [vec![conflict(mode("grip"), "M", "S")], vec![]] {
        let suspects = ranked(&ledger, &conflicts, &[]);
        let first = &suspects[0];
        assert_eq!(first.asset.kind, SuspectKind::FormalModel, "{suspects:?}");
        assert!(first.score > 2.0, "{}", first.score);
        let lacks = |it: &Symptom| matches!(it, Symptom::MissingMode { mode, shown } if mode == "grip" && shown.len() == 2);
        assert!(first.symptoms.iter().any(lacks), "{:?}", first.symptoms);
    }
}

/// A rate that is small, but not 0, excludes nothing.
#[test]
fn a_small_rate_is_held_to_the_margin() {
    let ledger = [model(1e-4), simulated(2, 100), tried(1, 71)];
    assert!(ranked(&ledger, &[], &[]).is_empty());
    let excluded = [model(0.0), simulated(20, 1000), tried(14, 710)];
    assert!(!ranked(&excluded, &[], &[]).is_empty());
}

#[test]
fn what_one_voice_alone_shows_may_be_that_voices_error() {
    let ledger = [model(0.0), simulated(4, 21), tried(0, 71)];
    let conflicts = [
        conflict(mode("grip"), "M", "S"),
        conflict(mode("grip"), "S", "X"),
    ];
    let suspects = ranked(&ledger, &conflicts, &[]);
    assert_eq!(
        suspects[0].asset.kind,
        SuspectKind::Simulation,
        "{suspects:?}"
    );
}

#[test]
fn what_nobody_has_seen_is_excluded_by_right() {
    let ledger = [model(0.0), simulated(0, 1000), tried(0, 71)];
    assert!(ranked(&ledger, &[], &[]).is_empty());
}
