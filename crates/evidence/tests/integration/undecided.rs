//! Runs that reached no verdict: what is said holds whatever they would have shown.

use crate::support::{at_least, counts, exact, piece, requirement};
use evidence::*;
use stats::{Confidence, Sample};

fn counted(sample: Sample) -> Result<Measure, stats::StatsError> {
    Measure::of_counts(sample, None, Confidence::P95)
}

/// Trials of which some reached no verdict, which count both ways.
fn open(id: &str, (count, trials): (u64, u64), undecided: u64) -> Evidence {
    let mut piece = piece(id, Technique::Operation, vec![(0, counts(count, trials))]);
    for finding in &mut piece.findings {
        finding.undecided = undecided;
        let both_ways = finding
            .clone()
            .counting_undecided(Confidence::P95, &counted);
        *finding = both_ways.expect("counts");
    }
    piece
}

/// The same with the runs as they may have been.
fn completed(id: &str, (count, trials): (u64, u64), [passed, undecided]: [u64; 2]) -> Evidence {
    let all = counts(count + passed, trials + undecided);
    piece(id, Technique::Operation, vec![(0, all)])
}

fn verdict(ledger: &[Evidence], threshold: f64, looks: Option<&Looks>) -> Conclusion {
    let influences = Influences::learn(ledger);
    let study = Study {
        requirements: &[requirement(0, at_least(threshold))],
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let comparisons = compare(&study);
    conclude(&study, &comparisons).swap_remove(0)
}

fn comparison(ledger: &[Evidence], looks: Option<&Looks>) -> Comparison {
    let influences = Influences::learn(ledger);
    let study = Study {
        requirements: &[requirement(0, at_least(0.9))],
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    compare(&study).swap_remove(0)
}

/// A verdict is made exactly if every completion makes it; limits are the widest.
#[test]
fn a_verdict_needs_every_completion() {
    let mut seen = std::collections::BTreeSet::new();
    for (known, undecided) in [
        ((90, 90), 0),
        ((90, 90), 1),
        ((90, 90), 10),
        ((200, 200), 4),
        ((60, 100), 3),
        ((60, 100), 60),
        ((88, 92), 2),
    ] {
        let found = verdict(&[open("O", known, undecided)], 0.9, None);
        let all: Vec<Conclusion> = (0..=undecided)
            .map(|passed| verdict(&[completed("O", known, [passed, undecided])], 0.9, None))
            .collect();
        let shared = all.iter().all(|one| one.verdict == all[0].verdict);
        let expected = if shared {
            all[0].verdict
        } else {
            Verdict::Undecided
        };
        assert_eq!(found.verdict, expected, "{known:?} {undecided}: {found:?}");
        let standing = &found.standings[0];
        for one in &all {
            let one = &one.standings[0];
            assert!(standing.p_not_met >= one.p_not_met - 1e-12);
            assert!(standing.p_met >= one.p_met - 1e-12);
            assert!(standing.limits.low <= one.limits.low + 1e-9);
            assert!(standing.limits.high >= one.limits.high - 1e-9);
        }
        seen.insert(format!("{:?}", found.verdict));
        let said = &found.statement;
        assert_eq!(
            said.contains("counted against and for"),
            undecided > 0,
            "{said}"
        );
    }
    assert_eq!(seen.len(), 3, "{seen:?}");
}

/// What long runs that were cut off would have shown is not known: 60 of 60 with 40 cut off may be 60 of 100.
#[test]
fn runs_that_were_cut_off_are_no_passes() {
    let without = verdict(&[open("O", (60, 60), 0)], 0.9, None);
    assert_eq!(without.verdict, Verdict::Satisfied);
    let with = verdict(&[open("O", (60, 60), 40)], 0.9, None);
    assert_eq!(with.verdict, Verdict::Undecided);
    let excluded = &with.excluded_trials[0];
    assert_eq!(excluded.trials, 40);
    assert!(
        excluded.words.contains("counted against and for"),
        "{}",
        excluded.words
    );
    // Certainty is refuted by a violation that was seen, not by one that may have been.
    let certain = |ledger: &[Evidence]| verdict(ledger, 1.0, None).verdict;
    assert_eq!(certain(&[open("O", (60, 60), 40)]), Verdict::Undecided);
    assert_eq!(certain(&[open("O", (59, 60), 40)]), Verdict::Violated);
}

/// Agreement and conflict of a pair are those of all completions, against counts and against a known value.
#[test]
fn a_pair_needs_every_completion() {
    let mut seen = std::collections::BTreeSet::new();
    let others = [
        piece("M", Technique::ModelChecking, vec![(0, exact(0.9))]),
        piece("S", Technique::Simulation, vec![(0, counts(450, 500))]),
        piece("S", Technique::Simulation, vec![(0, counts(150, 500))]),
    ];
    for other in others {
        for (known, undecided) in [
            ((450, 500), 0),
            ((450, 500), 5),
            ((450, 500), 80),
            ((20, 60), 2),
            ((20, 60), 60),
        ] {
            let found = comparison(&[open("O", known, undecided), other.clone()], None);
            let all: Vec<Comparison> = (0..=undecided)
                .map(|passed| {
                    let one = completed("O", known, [passed, undecided]);
                    comparison(&[one, other.clone()], None)
                })
                .collect();
            let outcome = |wanted| all.iter().all(|one| one.outcome == wanted);
            for wanted in [Outcome::Corroborates, Outcome::Conflicts] {
                // Never more than all of them say.
                if found.outcome == wanted {
                    assert!(outcome(wanted), "{known:?} {undecided}: {found:?}");
                }
                if outcome(wanted) {
                    assert_eq!(found.outcome, wanted, "{known:?} {undecided}");
                }
            }
            for one in &all {
                assert!(
                    found.p_difference >= one.p_difference,
                    "{known:?} {undecided}"
                );
                assert!(
                    found.p_equivalence >= one.p_equivalence,
                    "{known:?} {undecided}"
                );
            }
            seen.insert(format!("{:?} {}", found.outcome, undecided > 0));
        }
    }
    assert!(seen.len() > 4, "{seen:?}");
}

/// Over looks, too: nothing is shown that one completion would not show at the same looks.
#[test]
fn looks_count_undecided_runs_both_ways() {
    let looks = |counts: &[(u64, u64, u64)]| {
        let pieces = counts.iter().map(|(count, trials, undecided)| {
            Look::of(&[open("O", (*count, *trials), *undecided)])
        });
        Looks {
            looks: pieces.collect(),
        }
    };
    // One of the undecided runs of the first look got its verdict by the second.
    let before = looks(&[(30, 30, 4), (60, 60, 3)]);
    let found = verdict(&[open("O", (120, 120), 3)], 0.9, Some(&before));
    for passed in 0..=3 {
        let then = Looks {
            looks: vec![
                Look::of(&[completed("O", (30, 30), [passed, 3])]),
                Look::of(&[completed("O", (60, 60), [passed, 3])]),
            ],
        };
        let one = verdict(&[completed("O", (120, 120), [passed, 3])], 0.9, Some(&then));
        let (all, one) = (&found.standings[0], &one.standings[0]);
        assert!(
            all.p_not_met >= one.p_not_met * (1.0 - 1e-9),
            "{passed}: {all:?} {one:?}"
        );
    }
    let single = verdict(&[open("O", (120, 120), 3)], 0.9, None);
    assert!(found.standings[0].p_not_met > single.standings[0].p_not_met);
    let model = piece("M", Technique::ModelChecking, vec![(0, exact(0.95))]);
    let ledger = [open("O", (120, 120), 3), model];
    assert!(comparison(&ledger, Some(&before)).p_equivalence.is_some());
}

/// What looked satisfied while undecided runs were left out is not satisfied by that earlier look: a look of an older version
/// tells of none.
#[test]
fn an_early_look_that_tells_of_no_undecided_runs_shows_nothing_by_itself() {
    let before = Looks {
        looks: vec![Look::of(&[open("O", (60, 60), 0)])],
    };
    for (now, undecided) in [((60, 60), 20), ((61, 62), 20)] {
        let found = verdict(&[open("O", now, undecided)], 0.9, Some(&before));
        assert_eq!(found.verdict, Verdict::Undecided, "{found:?}");
        assert!(found.standings[0].p_not_met > 0.5, "{found:?}");
    }
    // And it shows what it shows where there are none.
    let found = verdict(&[open("O", (61, 62), 0)], 0.9, Some(&before));
    assert_eq!(found.verdict, Verdict::Satisfied, "{found:?}");
}

/// Trials are not planned on runs of which nobody knows what they showed, and these are not pooled.
#[test]
fn plans_and_pools_leave_them_out() {
    let ledger = [
        open("O", (45, 50), 4),
        piece("T", Technique::Experiment, vec![(0, counts(46, 50))]),
    ];
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &[requirement(0, at_least(0.9))],
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        looks: None,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let mut comparisons = compare(&study);
    let planned = undecided(&study, &mut comparisons, &TrialCosts::default());
    assert!(planned.is_empty(), "{planned:?}");
    assert!(
        comparisons[0].reason.contains("4 runs without a verdict"),
        "{:?}",
        comparisons[0]
    );
    let pooled = combine(&study, &comparisons, &Weights::default()).swap_remove(0);
    assert!(
        pooled.left_out["O"].contains("without a verdict"),
        "{pooled:?}"
    );
    assert_eq!(pooled.pieces.keys().collect::<Vec<_>>(), ["T"]);
}
