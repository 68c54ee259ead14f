//! How often a requirement is triggered is compared only where both shares are of the same population of runs.

use crate::support::{counts, exact, requirement, subject};
use evidence::*;

fn triggered(
    id: &str,
    technique: Technique,
    role: AssetRole,
    measure: Measure,
    share: Measure,
) -> Evidence {
    let mut finding = Finding::new(subject(0), measure);
    finding.denominator = Denominator::Triggered;
    finding.trigger = Some(Box::new(share));
    let mut piece = Evidence::new(id, technique).found(finding);
    piece.assets = vec![Asset {
        role,
        path: id.to_owned(),
        hash: String::new(),
    }];
    piece
}

fn model() -> Evidence {
    let role = AssetRole::SystemModel;
    triggered("M", Technique::ModelChecking, role, exact(0.9), exact(0.1))
}

fn counted(technique: Technique, role: AssetRole) -> Evidence {
    triggered("T", technique, role, counts(90, 100), counts(100, 100))
}

fn compared(ledger: [Evidence; 2]) -> Comparison {
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &[requirement(0, None)],
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        looks: None,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    compare(&study).swap_remove(0)
}

fn left_out(ledger: [Evidence; 2], because: &str) {
    let found = compared(ledger);
    let reason = found.trigger_not_compared.unwrap_or_default();
    assert!(found.trigger.is_none(), "{:?}", found.trigger);
    assert!(reason.contains(because), "{reason}");
    assert!(!found.reason.contains("these shares"), "{}", found.reason);
}

#[test]
fn shares_of_a_model_and_of_a_campaign_or_operation_under_the_same_conditions_are_compared() {
    let campaign = counted(Technique::Simulation, AssetRole::SystemModel);
    let found = compared([model(), campaign]);
    assert_eq!(found.trigger.expect("shares").outcome, Outcome::Conflicts);
    assert_eq!(found.trigger_not_compared, None);
    let found = compared([model(), counted(Technique::Operation, AssetRole::Data)]);
    assert!(found.trigger.is_some() && found.trigger_not_compared.is_none());
}

/// A cohort's attempts may be those in which it was triggered; a published table's, too.
#[test]
fn attempts_that_people_set_up_or_chose_are_no_sample_of_all_runs() {
    let because = "The runs of T were set up or chosen by people";
    left_out(
        [model(), counted(Technique::Experiment, AssetRole::Data)],
        because,
    );
    left_out(
        [model(), counted(Technique::Simulation, AssetRole::Data)],
        because,
    );
}

#[test]
fn runs_under_other_conditions_and_other_triggers_are_others() {
    let mut elsewhere = counted(Technique::Simulation, AssetRole::SystemModel);
    elsewhere.conditions = "wet".into();
    left_out([model(), elsewhere], "M and T hold for other conditions");
    let mut other = model();
    other.findings[0].denominator = Denominator::OtherTrigger {
        trigger: "near".into(),
        monitor: "late".into(),
    };
    let campaign = counted(Technique::Simulation, AssetRole::SystemModel);
    left_out([other, campaign], "of different triggers");
}

/// What is known of neither is not told as a comparison.
#[test]
fn where_a_share_is_unknown_there_is_nothing_to_compare() {
    let mut unknown = model();
    unknown.findings[0].trigger = None;
    let campaign = counted(Technique::Simulation, AssetRole::SystemModel);
    let found = compared([unknown, campaign]);
    assert!(found.trigger.is_none() && found.trigger_not_compared.is_none());
}
