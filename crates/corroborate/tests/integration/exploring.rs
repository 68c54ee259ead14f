//! What looks for more than a run does, as functions: explored, shrunk, replayed, calibrated, and what is wrong with a request.
//! Needs `python3`, in which the cart's simulator is written; no physics library.

use crate::support::{Copy, host};
use corroborate::evidence::Stopped;
use corroborate::explore::ExploreRequest;
use corroborate::host::{Event, Host};
use corroborate::replay::{RegressionsRequest, ReplayRequest, check_regressions, replay_with_page};
use corroborate::technique::exploration::ExplorationReport;
use corroborate::{
    CalibrateRequest, EnginesRequest, Problem, RareRequest, ReplayReport, ShrinkReport,
    ShrinkRequest,
};
use std::sync::Mutex;

/// How the cart is explored: its speed varies, so that it touches the obstacle in some episodes.
const EXPLORATION: &str = r#"
evidence = "sim"
sources = ["own", "random"]
designs = ["boundary", "random"]

[budget]
episodes = 12
batch = 6

[grammar]
name = "random"
length = [1, 2]

[[grammar.action]]
send_signal = "go"

[[parameter]]
name = "speed"
sets = ["cart.speed_cm_per_s"]
uniform = [100.0, 200.0]
nominal = 150.0
"#;

fn cart() -> Copy {
    let cart = Copy::of_cart(40);
    std::fs::write(cart.path("exploration.toml"), EXPLORATION).expect("it is written");
    cart
}

fn silent() -> Host {
    host(|_| false).0
}

fn explored(cart: &Copy, host: &Host) -> ExplorationReport {
    let request = ExploreRequest::new(cart.path(""), "exploration.toml");
    corroborate::explore(&request, host).expect("it explores")
}

fn json(value: &impl serde::Serialize) -> String {
    corroborate::results::json(value).expect("JSON")
}

/// How many episodes of an exploration were run, and how many were taken from its journal.
fn run_and_taken(events: &Mutex<Vec<Event>>) -> (usize, u64) {
    let events = events.lock().expect("the events");
    let run = events
        .iter()
        .filter(|event| matches!(event, Event::Advanced { .. }));
    let taken = events.iter().map(|event| match event {
        Event::Skipped { steps, .. } => *steps,
        _ => 0,
    });
    (run.count(), taken.sum())
}

#[test]
fn an_exploration_is_cancelled_by_its_host_and_goes_on_to_the_same_result() {
    let whole = explored(&cart(), &silent());
    assert_eq!(whole.found.episodes, 12);
    assert_eq!(whole.found.stopped, Stopped::Budget);

    let cart = cart();
    let (stopping, first) = host(|event| matches!(event, Event::Advanced { done: 8, .. }));
    let part = explored(&cart, &stopping);
    assert_eq!(part.found.stopped, Stopped::Interrupted);
    // Only whole batches are counted; what of the next was run is in the journal.
    assert_eq!(part.found.episodes, 6);
    let (run_first, _) = run_and_taken(&first);
    let (going_on, second) = host(|_| false);
    let report = explored(&cart, &going_on);
    assert_eq!(json(&report), json(&whole));
    let (run, taken) = run_and_taken(&second);
    assert_eq!((run + taken as usize, run_first as u64), (12, taken));
    let kept = std::fs::read_to_string(cart.path("results/exploration/exploration.json"));
    // With a digest before what is printed.
    let kept = kept.expect("it is written");
    let lines = kept.lines().filter(|it| !it.starts_with("  \"digest\": "));
    let without: String = lines.map(|line| format!("{line}\n")).collect();
    assert_eq!(without, json(&report));
    assert_ne!(without, kept);
}

/// The file of the finding that the cart touches the obstacle, relative to the study.
fn touches(report: &ExplorationReport) -> String {
    let mut findings = report.found.findings.iter();
    let found = findings.find(|it| it.found.in_words == "requirement clear is violated");
    format!(
        "results/exploration/{}",
        found.expect("it is found").found.file
    )
}

fn shrunk(cart: &Copy, episode: &str) -> ShrinkReport {
    let request = ShrinkRequest {
        budget: 40,
        name: Some("touches".into()),
        ..ShrinkRequest::new(cart.path(""), episode)
    };
    corroborate::shrink(&request, &silent()).expect("it is shrunk")
}

#[test]
fn a_finding_is_made_small_and_kept_and_run_again_as_a_regression() {
    let cart = cart();
    let file = touches(&explored(&cart, &silent()));
    let report = shrunk(&cart, &file);
    assert_eq!(report.after.actions, 0);
    assert!(report.test.actions.is_empty() && report.causes.len() <= 1);
    assert!(report.episodes <= 40);

    let request = RegressionsRequest::new(cart.path(""));
    let checked = check_regressions(&request, &silent()).expect("there is one");
    assert!(checked.all_as_expected());
    assert_eq!(checked.regressions[0].same_bytes, Some(true));
    // One that cannot be read is told in its place, with a remedy for those who ask.
    std::fs::write(cart.path("regressions/torn.toml"), "format = ").expect("it is written");
    let checked = check_regressions(&request, &silent()).expect("there are two");
    assert!(!checked.all_as_expected() && checked.regressions[1].shown);
    let torn = &checked.regressions[0];
    assert!(torn.problem.as_ref().is_some_and(Problem::has_place));
    let error = torn.error.as_ref().expect("a reason");
    assert!(error.contains("torn.toml:1:"), "{error}");
    assert!(!json(&checked).contains("\"problem\""));
}

#[test]
fn a_replay_writes_recordings_and_a_page_only_if_a_face_draws_one() {
    let cart = cart();
    let file = touches(&explored(&cart, &silent()));
    let request = ReplayRequest::new(cart.path(""), &file).out(cart.path("one"));
    let report = corroborate::replay(&request, &silent()).expect("it is replayed");
    assert_eq!((report.shown, report.same_bytes), (Some(true), Some(true)));
    let names = |report: &ReplayReport| -> Vec<String> {
        let names = report.files.iter().map(|file| file.rsplit('/').next());
        names.flatten().map(str::to_owned).collect()
    };
    let recordings = ["recording.mcap", "verdicts.mcap", "scene.mcap"];
    assert_eq!(names(&report), recordings);

    let pages = Mutex::new(Vec::new());
    let drawn = replay_with_page(&request, &silent(), &|page| {
        pages.lock().expect("whole").push(page.clone());
        "drawn".to_owned()
    });
    let drawn = drawn.expect("it is replayed");
    assert_eq!(names(&drawn)[0], "replay.html");
    assert_eq!(
        std::fs::read_to_string(cart.path("one/replay.html")).expect("a page"),
        "drawn"
    );
    let pages = pages.into_inner().expect("whole");
    let [page] = &pages[..] else {
        panic!("{} pages", pages.len())
    };
    assert_eq!(page.title, "Requirement clear is violated");
    let signal = page.signals.iter().find(|it| it.name == "/cart.gap");
    assert!(!signal.expect("it is judged by").causes.is_empty());
    assert!(
        page.marks
            .iter()
            .any(|mark| mark.text.contains("clear is violated"))
    );
    assert_eq!(drawn.recording, report.recording);
}

#[test]
fn what_a_request_names_wrongly_is_an_error_with_its_code() {
    let cart = cart();
    let study = cart.path("");
    let replay = |episode: &str| {
        let request = ReplayRequest::new(&study, episode);
        corroborate::replay(&request, &silent())
            .expect_err("wrong")
            .code
    };
    assert_eq!(replay("nothing.toml"), "no-finding");
    assert_eq!(replay("sim:0"), "bad-episode");
    assert_eq!(replay("sim:41"), "bad-episode");
    let unknown = ReplayRequest {
        only: vec!["cleer".into()],
        ..ReplayRequest::new(&study, "sim:1")
    };
    let problem = corroborate::replay(&unknown, &silent()).expect_err("wrong");
    assert_eq!(problem.code, "unknown-subject");
    let none = check_regressions(&RegressionsRequest::new(&study), &silent());
    assert_eq!(none.expect_err("there are none").code, "no-regressions");
    let shrink = |name: &str| {
        let request = ShrinkRequest {
            only: Some("clear".into()),
            name: Some(name.into()),
            ..ShrinkRequest::new(&study, "sim:1")
        };
        corroborate::shrink(&request, &silent())
            .expect_err("wrong")
            .code
    };
    assert_eq!(shrink("../x"), "bad-name");
    std::fs::create_dir(cart.path("regressions")).expect("made");
    std::fs::write(cart.path("regressions/there.toml"), "").expect("written");
    assert_eq!(shrink("there"), "already-there");
    let engines = corroborate::engines(&EnginesRequest::new(&study, "sim"), &silent());
    assert_eq!(engines.expect_err("a command").code, "not-a-simulation");
    let missing = |problem: Problem| assert_eq!(problem.code, "cannot-read");
    missing(corroborate::rare(&RareRequest::new(&study, "no.toml"), &silent()).expect_err("no"));
    let request = CalibrateRequest::new(&study, "no.toml");
    missing(corroborate::calibrate(&request, &silent()).expect_err("no"));
}
