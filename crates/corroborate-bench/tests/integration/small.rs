//! The benchmark at a fixed seed, small enough for every change: what must not get worse.

use corroborate_bench::bench::{Line, Plan, run};
use corroborate_bench::family::Family;
use corroborate_bench::fault::Fault;
use corroborate_bench::repair::{Repair, repair};
use corroborate_bench::study::Synthetic;
use corroborate_bench::table::{page, tables};

fn share(lines: &[Line], wanted: impl Fn(&Line) -> bool, holds: impl Fn(&Line) -> bool) -> f64 {
    let chosen: Vec<&Line> = lines.iter().filter(|line| wanted(line)).collect();
    assert!(chosen.len() >= 10, "too few studies to speak of a share");
    chosen.iter().filter(|line| holds(line)).count() as f64 / chosen.len() as f64
}

#[test]
fn faults_are_found_and_located_and_nothing_is_taken_for_one() {
    let lines = run(&Plan::SMALL, &|_, _| ()).expect("all studies can be produced");
    // For whoever wants to see them (the step `benchmark` of .ci/run).
    let shown = concat!(env!("CARGO_TARGET_TMPDIR"), "/benchmark.md");
    std::fs::write(shown, page(&lines, Plan::SMALL.seed)).expect("written");
    let is_conflict = |line: &Line| line.score.fault.is_conflict();
    let strong = |line: &Line| is_conflict(line) && line.score.theory.known >= 0.95;
    let found = share(&lines, strong, |line| line.score.found);
    assert!(found >= 0.95, "found {found}");
    let located = |line: &Line| is_conflict(line) && line.score.found;
    let first = share(&lines, located, |line| line.score.rank == Some(1));
    let second = share(&lines, located, |line| {
        line.score.rank.is_some_and(|rank| rank <= 2)
    });
    assert!(
        first >= 0.9 && second >= 0.95,
        "first {first}, first or second {second}"
    );
    let sound = |line: &Line| line.score.fault == Fault::None;
    let alarms = share(&lines, sound, |line| line.score.found);
    // 5 % are allowed; of 40 studies 6 or more have then a probability of 0.014.
    assert!(alarms < 0.15, "false alarms {alarms}");
    let repairable = |line: &Line| is_conflict(line) && line.repair != Repair::NotRepairable;
    let repaired = share(&lines, repairable, |line| line.repair == Repair::Repaired);
    assert!(repaired >= 0.8, "repaired {repaired}");
    // Agreement of what was calibrated on the other is a fit, each time.
    assert!(lines.iter().all(|line| !line.score.false_independence));
    let tables = tables(&lines);
    assert!(tables.iter().all(|table| table.csv().lines().count() > 1));
    for table in &tables {
        let csv = table.csv();
        let mut widths = csv.lines().map(|line| line.split(',').count());
        assert!(widths.all(|width| width == table.headings.len()), "{csv}");
    }
}

#[test]
fn a_study_is_the_same_each_time_and_another_with_another_number() {
    let study =
        |number| Synthetic::new(Family::Serial, Fault::WrongRate, 7, number).expect("a study");
    let (one, again, other) = (study(3), study(3), study(4));
    assert_eq!(one.evidence, again.evidence);
    assert_eq!(one.suspects, again.suspects);
    assert_ne!(one.evidence, other.evidence);
}

#[test]
fn every_fault_can_be_planted_in_every_family_that_it_fits() {
    for family in [Family::Toy, Family::Serial, Family::Corridor] {
        for fault in Fault::ALL.into_iter().filter(|fault| fault.fits(family)) {
            let study = Synthetic::new(family, fault, 11, 0)
                .unwrap_or_else(|error| panic!("{}: {error}", fault.name()));
            assert_eq!(
                study.planted.site.is_some(),
                fault.is_conflict(),
                "{}",
                fault.name()
            );
            assert!(study.comparisons.len() > 5);
            let repair = repair(&study).unwrap_or_else(|error| panic!("{}: {error}", fault.name()));
            let is_planted = study.planted.site.is_some();
            assert!(is_planted || repair == Repair::NotRepairable);
        }
    }
}

/// The chain in the PRISM language and the simulator are the same task: the checker's answer is the rate of
/// the runs.
#[test]
fn the_formal_models_and_the_simulators_are_one_task() {
    for family in [Family::Toy, Family::Serial, Family::Corridor] {
        let study = Synthetic::new(family, Fault::None, 3, 8).expect("a study");
        are_one_task(&study);
    }
}

fn are_one_task(study: &Synthetic) {
    let mut random = corroborate_bench::random::Random::new(1, 1);
    let task = &study.setup.truth;
    let runs = 40_000;
    let counts = |what: &dyn Fn(&corroborate_bench::task::Run) -> bool, random: &mut _| {
        (0..runs).filter(|_| what(&task.run(random))).count() as f64 / f64::from(runs)
    };
    for finding in &study.piece("M").expect("the formal evidence").findings {
        let (truth, computed) = (study.truth(&finding.subject), finding.measure.estimate());
        if let (Some(truth), Some(computed), None) = (truth, computed, &study.setup.rig) {
            let subject = &finding.subject;
            assert!(
                (computed - truth).abs() < 1e-9,
                "{subject:?}: {computed} {truth}"
            );
        }
        let evidence::Subject::Requirement(id) = &finding.subject else {
            continue;
        };
        let limit = study.setup.limit_steps;
        let simulated = match id.as_str() {
            "done" | "ready" => counts(&|run| run.is_done(), &mut random),
            "in-time" => counts(&|run| run.is_done_by(limit), &mut random),
            _ => continue,
        };
        let truth = study.truth(&finding.subject).expect("a rate");
        // Five standard errors of 40,000 runs are at most 0.0125.
        assert!(
            (simulated - truth).abs() < 0.0125,
            "{id}: {simulated} {truth}"
        );
    }
}
