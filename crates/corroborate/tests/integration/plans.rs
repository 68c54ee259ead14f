//! What a plan says of evidence, before and after each change that makes it stale.

use crate::support::{Copy, host};
use corroborate::host::BuildId;
use corroborate::{CompareRequest, Freshness, RunPlan, RunRequest, VerifyRequest};

fn plan(study: &Copy, build: BuildId) -> RunPlan {
    let (mut host, _) = host(|_| false);
    host.build = build;
    corroborate::plan(&RunRequest::new(study.path("")), &host).expect("a plan")
}

/// What is planned for the model, for the experiments, and for their comparison.
fn states(study: &Copy) -> [Freshness; 3] {
    let plan = plan(study, corroborate::build());
    let [model, experiments] = &plan.evidence[..] else {
        panic!("{plan:?}");
    };
    let comparison = plan.comparison.clone().expect("all is asked for");
    [
        model.freshness.clone(),
        experiments.freshness.clone(),
        comparison,
    ]
}

fn run(study: &Copy) {
    corroborate::run(&RunRequest::new(study.path("")), &host(|_| false).0).expect("it runs");
}

fn awaits(ids: &[&str]) -> Freshness {
    let evidence = ids.iter().map(|id| (*id).to_owned()).collect();
    Freshness::Awaits { evidence }
}

#[test]
fn a_plan_says_what_is_stale_and_why_and_writes_nothing() {
    use Freshness::{Damaged, FilesChanged, Fresh, NotProduced, OtherInputs};
    let study = Copy::of_template("Model");
    assert_eq!(
        states(&study),
        [NotProduced, NotProduced, awaits(&["E1", "E2"])]
    );
    assert!(!study.path("results").exists());

    run(&study);
    assert_eq!(states(&study), [Fresh, Fresh, Fresh]);
    assert!(plan(&study, corroborate::build()).is_fresh());
    let by_another = plan(&study, BuildId::new("another build"));
    let stale = by_another.evidence.iter().map(|it| &it.freshness);
    assert!(stale.eq([&OtherInputs; 2]), "{by_another:?}");
    let took = by_another.evidence.iter().map(|it| it.last_took_secs);
    assert!(took.clone().all(|secs| secs.is_some()));
    assert_eq!(by_another.last_took_secs(), (took.flatten().sum(), 0));

    // Comments count: what is hashed is the file.
    study.edit("model.prism", "module", "// Changed.\nmodule");
    let files = vec!["model.prism".to_owned()];
    let changed = FilesChanged { files };
    assert_eq!(states(&study), [changed, Fresh, awaits(&["E1"])]);
    run(&study);

    study.edit("study.toml", "seed = 1", "seed = 2");
    assert_eq!(states(&study), [OtherInputs, Fresh, awaits(&["E1"])]);
    run(&study);

    study.edit(
        "results/evidence/E2.json",
        "\"trials\": 100",
        "\"trials\": 101",
    );
    assert_eq!(states(&study), [Fresh, Damaged, awaits(&["E2"])]);
    run(&study);

    std::fs::remove_file(study.path("results/comparison.json")).expect("it is there");
    assert_eq!(states(&study), [Fresh, Fresh, NotProduced]);
}

#[test]
fn a_plan_of_some_evidence_plans_no_comparison() {
    let study = Copy::of_template("Model");
    let request = RunRequest::new(study.path("")).only("E2");
    let plan = corroborate::plan(&request, &host(|_| false).0).expect("a plan");
    assert_eq!((plan.evidence.len(), plan.comparison), (1, None));
}

#[test]
fn a_mistake_in_the_study_is_found_by_a_plan() {
    let study = Copy::of_template("Model");
    study.edit("vocabulary.toml", "robot=docked", "robot=dokced");
    let request = RunRequest::new(study.path(""));
    let problem = corroborate::plan(&request, &host(|_| false).0).expect_err("a misspelt word");
    assert_eq!(problem.code, "unknown-name");
    assert!(problem.has_place());
}

#[test]
fn results_are_compared_and_verified_without_a_page() {
    let study = Copy::of_template("Model");
    let request = CompareRequest::new(study.path(""));
    let problem = corroborate::compare(&request).expect_err("it has not been run");
    assert_eq!(problem.code, "not-run");

    run(&study);
    let pairs = corroborate::compare(&request.evidence("E1")).expect("it has been run");
    assert!(!pairs.comparisons.is_empty());
    let (host, _) = host(|_| false);
    let request = VerifyRequest::new(study.path("results"));
    let report = corroborate::verify(&request, &host, None).expect("it is a study's");
    assert_eq!(report.faults, []);

    study.edit(
        "results/study.json",
        "\"confidence\": 0.95",
        "\"confidence\": 0.94",
    );
    let report = corroborate::verify(&request, &host, None).expect("it is a study's");
    assert_eq!(report.faults.len(), 1, "{:?}", report.faults);
    assert_eq!(report.faults[0].place, "/confidence");
}
