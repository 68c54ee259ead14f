//! What a face calls after a run: diagnosis, assurance case, requirements, recordings and single properties, as functions
//! from requests to reports, with the outcome of each.

use crate::support::{Copy, host};
use corroborate::assure::Argued;
use corroborate::host::Event;
use corroborate::query::{ModelInput, PropertyInput};
use corroborate::requirements::library;
use corroborate::{
    AssureRequest, CheckRequest, DiagnoseRequest, Drawing, Ended, MonitorRequest, Outcome,
    RequirementsRequest, RunRequest, StudyResult, VerifyRequest,
};

const NEVER: fn(&Event) -> bool = |_| false;

/// A page and an argument of a face's own.
fn page(result: &StudyResult) -> String {
    format!("{} with {} suspects", result.title, result.suspects.len())
}

fn argued(result: &StudyResult) -> Argued {
    Argued {
        files: vec![("argument.txt".into(), result.title.clone())],
        elements: 3,
        undeveloped: 2,
        defeated: 1,
    }
}

fn drawing() -> Drawing<'static> {
    Drawing {
        page: &page,
        argument: &argued,
        statement_file: &|id| format!("signed/{id}.json"),
    }
}

fn read(study: &Copy, name: &str) -> String {
    std::fs::read_to_string(study.path(name)).expect("it was written")
}

#[test]
fn a_study_that_was_run_is_diagnosed_assured_and_verified() {
    let study = Copy::of_template("Model of the dock");
    let (host, _) = host(NEVER);
    let request = RunRequest::new(study.path(""));
    corroborate::run_with_page(&request, &host, &page).expect("it runs");

    let diagnose = DiagnoseRequest::new(study.path(""));
    let diagnosis = corroborate::diagnose::diagnose_with_page(&diagnose, &host, &page);
    let diagnosis = diagnosis.expect("it can be diagnosed");
    assert_eq!(diagnosis.effort.paths, 1000);
    let kept: StudyResult =
        serde_json::from_str(&read(&study, "results/study.json")).expect("a result");
    assert_eq!(kept.diagnosis.as_ref(), Some(&diagnosis));
    let is_open = |score: f64, resolved: bool| score >= 1.0 && !resolved;
    let suspects = &diagnosis.suspects;
    let any = (suspects.iter()).any(|it| is_open(it.score, it.resolved_by.is_some()));
    assert_eq!(diagnosis.outcome() == Outcome::Violated, any);

    let written = corroborate::assure(&AssureRequest::new(study.path("")), &drawing());
    let written = written.expect("it is written");
    let counts = (written.elements, written.undeveloped, written.defeated);
    assert_eq!(counts, (3, 2, 1));
    for name in &written.files {
        assert!(written.folder.join(name).is_file(), "{name}");
    }
    let statement = read(&study, "results/assurance/study.intoto.json");
    assert!(statement.contains("argument.txt"), "{statement}");
    assert!(study.path("results/assurance/signed/E1.json").is_file());

    let verify = VerifyRequest::new(study.path("results"));
    let report = corroborate::verify(&verify, &host, Some(&drawing())).expect("it is verified");
    assert_eq!(report.outcome(), Outcome::Holds, "{:?}", report.faults);
    std::fs::write(study.path("results/assurance/argument.txt"), "other").expect("written");
    let report = corroborate::verify(&verify, &host, Some(&drawing())).expect("it is verified");
    assert_eq!(report.outcome(), Outcome::Violated);
}

#[test]
fn a_path_is_looked_at_by_the_name_that_a_diagnosis_gives_it() {
    let study = Copy::of_template("Model of the dock");
    let (host, _) = host(NEVER);
    let path = corroborate::diagnose::sampled_path(&study.path(""), "E1:3", &host);
    let path = path.expect("a path");
    assert_eq!((path.evidence.as_str(), path.number), ("E1", 3));
    assert!(!path.steps.is_empty());
    for name in ["E1", "E1:0", "E1:x", "E2:1"] {
        let problem = corroborate::diagnose::sampled_path(&study.path(""), name, &host);
        assert_eq!(problem.expect_err(name).code, "bad-path", "{name}");
    }
}

#[test]
fn requirements_are_shown_and_held_against_recordings() {
    let study = Copy::of("crates/corroborate/templates/recordings");
    let (host, events) = host(NEVER);
    let request = RequirementsRequest::new(study.path("")).recording(study.path("recordings"));
    let report = corroborate::requirements(&request, &host).expect("they are shown");
    assert!(!report.requirements.is_empty() && !report.recordings.is_empty());
    assert_eq!(report.outcome(), Outcome::Holds, "{:?}", report.drift);
    assert!(!events.lock().expect("the events").is_empty());

    let ready = library();
    assert!(ready.templates.iter().all(|it| !it.sentence.is_empty()));
    assert!(serde_json::to_value(&ready).is_ok());
}

#[test]
fn recordings_are_judged_by_the_monitors_of_a_study() {
    let study = Copy::of("crates/corroborate/templates/recordings");
    let (host, _) = host(NEVER);
    let monitored = corroborate::judging::Monitored::Study {
        folder: study.path(""),
        only: Vec::new(),
    };
    let request = MonitorRequest {
        recordings: vec![study.path("recordings")],
        ..MonitorRequest::new(monitored)
    };
    let report = corroborate::monitor(&request, &host).expect("they are judged");
    assert_eq!(
        report.outcome() == Outcome::Violated,
        report.is_violated(),
        "what is violated comes first"
    );
}

#[test]
fn a_property_of_a_model_is_checked() {
    let study = Copy::of_template("Model of the dock");
    let (host, _) = host(NEVER);
    let checked = |property: &str| {
        let request = CheckRequest {
            properties: vec![PropertyInput::Text(property.into())],
            ..CheckRequest::new(ModelInput::File(study.path("model.prism")))
        };
        let found = corroborate::check(&request, &host, &|_| Ok(())).expect("it is checked");
        (found.report.outcome(), found.problem.map(|it| it.code))
    };
    assert_eq!(checked("P>=0 [ F true ]"), (Outcome::Holds, None));
    assert_eq!(checked("P<0.5 [ F true ]"), (Outcome::Violated, None));
    let (outcome, problem) = checked("P<0.5 [ F no_such_name ]");
    assert_eq!(outcome, Outcome::Wrong);
    assert!(problem.is_some(), "a face tells what is wrong and where");
}
