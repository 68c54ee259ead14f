//! Two studies in one process, each with a host of its own: neither knows of the other. Needs `python3`, in which the
//! cart's simulator is written.

use crate::support::{Copy, host, notes};
use corroborate::host::{Event, Host};
use corroborate::{Freshness, RunRequest, StudyResult};

/// A study as it was run: what it says, and its files.
fn run(study: &Copy, host: &Host) -> StudyResult {
    let report = corroborate::run(&RunRequest::new(study.path("")), host).expect("it runs");
    report.into_study().expect("all was asked for")
}

#[test]
fn two_studies_side_by_side_give_the_same_bytes_as_one_after_another() {
    let never = |_: &Event| false;
    let studies = || [Copy::of_template("Model of the dock"), Copy::of_cart(20)];
    let one_after_another = studies();
    for study in &one_after_another {
        run(study, &host(never).0);
    }
    let at_once = studies();
    let told: Vec<Vec<String>> = std::thread::scope(|scope| {
        let threads = at_once.each_ref().map(|study| {
            scope.spawn(move || {
                let (host, events) = host(never);
                run(study, &host);
                notes(&events)
            })
        });
        threads.map(|thread| thread.join().expect("it ends")).into()
    });
    for (alone, beside) in one_after_another.iter().zip(&at_once) {
        let (alone, beside) = (alone.results(), beside.results());
        assert_eq!(
            alone.keys().collect::<Vec<_>>(),
            beside.keys().collect::<Vec<_>>()
        );
        for (name, bytes) in &alone {
            assert!(beside[name] == *bytes, "{} differs", name.display());
        }
    }
    // Each host hears of its own study alone.
    let says = |of: usize, words: &str| told[of].iter().any(|line| line.contains(words));
    assert!(says(0, "Model of the dock") && !says(0, "cart"), "{told:?}");
    assert!(says(1, "cart") && !says(1, "dock"), "{told:?}");
}

#[test]
fn one_that_is_cancelled_leaves_the_other_running_and_goes_on_where_it_stopped() {
    let third_episode = |event: &Event| matches!(event, Event::Advanced { done: 3, .. });
    let (cart, dock) = (Copy::of_cart(20), Copy::of_template("Model"));
    let request = RunRequest::new(cart.path(""));
    let (interrupted, finished) = std::thread::scope(|scope| {
        let interrupted = scope.spawn(|| corroborate::run(&request, &host(third_episode).0));
        let finished = scope.spawn(|| run(&dock, &host(|_| false).0));
        let interrupted = interrupted.join().expect("it ends");
        (interrupted, finished.join().expect("it ends"))
    });
    let problem = interrupted.expect_err("it was cancelled");
    assert!(problem.is_interruption(), "{problem}");
    assert!(!finished.conclusions.is_empty());

    let (silent, _) = host(|_| false);
    let planned = corroborate::plan(&request, &silent).expect("a plan");
    let simulation = &planned.evidence[0];
    assert_eq!(simulation.freshness, Freshness::NotProduced);
    let kept = simulation.kept_episodes.expect("it is a simulation");
    assert!((3..20).contains(&kept), "{kept}");

    let (host, events) = host(|_| false);
    run(&cart, &host);
    let events = events.lock().expect("the events");
    let skipped = events.iter().find_map(|event| match event {
        Event::Skipped { steps, .. } => Some(*steps),
        _ => None,
    });
    assert_eq!(skipped, Some(kept));
    let whole = Copy::of_cart(20);
    run(&whole, &silent);
    assert!(whole.results() == cart.results());
}
