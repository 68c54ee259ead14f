//! Trials of one person tell of this person: they decide a requirement of the system only where the study declares that this
//! one stands for all, and where one violation refutes certainty.

use crate::support::{at_least, counts, exact, piece, requirement, subject};
use evidence::*;

fn of_one(id: &str, count: u64, trials: u64, because: Option<&str>) -> Evidence {
    one_by(Technique::Experiment, id, (count, trials), because)
}

fn one_by(
    technique: Technique,
    id: &str,
    (count, trials): (u64, u64),
    because: Option<&str>,
) -> Evidence {
    let mut piece = piece(id, technique, vec![(0, counts(count, trials))]);
    let one = ClusterTests {
        effective_trials: trials as f64,
        subjects: 1,
        ..ClusterTests::default()
    };
    piece.clusters = Some(one.with_one_for_all(because.map(str::to_owned)));
    piece
}

struct Judged {
    conclusion: Conclusion,
    pooled: Combined,
    synthesis: Synthesis,
    comparisons: Vec<Comparison>,
}

fn judged(ledger: &[Evidence], threshold: f64) -> Judged {
    let influences = Influences::learn(ledger);
    let study = Study {
        requirements: &[requirement(0, at_least(threshold))],
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks: None,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let comparisons = compare(&study);
    let conclusions = conclude(&study, &comparisons);
    let pooled = combine(&study, &comparisons, &Weights::default()).swap_remove(0);
    let costs = TrialCosts::default();
    let synthesis = synthesise(
        &study,
        (&comparisons, vec![]),
        &conclusions,
        costs,
        &Weights::default(),
    );
    Judged {
        conclusion: conclusions[0].clone(),
        pooled,
        synthesis,
        comparisons,
    }
}

#[test]
fn four_hundred_trials_of_one_person_decide_nothing_of_others() {
    for (count, word) in [(398, "398/400"), (200, "200/400")] {
        let found = judged(&[of_one("E", count, 400, None)], 0.9);
        let conclusion = &found.conclusion;
        assert_eq!(conclusion.verdict, Verdict::Undecided, "{conclusion:?}");
        let said = &conclusion.statement;
        assert!(
            said.contains(word) && said.contains("of one person or session alone"),
            "{said}"
        );
        let left_out = &conclusion.excluded[0];
        assert_eq!(left_out.reason, ExclusionReason::OneSubject);
        assert!(left_out.words.contains("one_for_all"), "{}", left_out.words);
        assert!(found.pooled.interval.is_none(), "{:?}", found.pooled);
        assert!(
            found.synthesis.deciding.is_empty(),
            "{:?}",
            found.synthesis.deciding
        );
        let why = &found.synthesis.not_planned[0].reason;
        assert!(why.contains("more of the same one"), "{why}");
    }
}

#[test]
fn a_declared_assumption_lets_one_decide_and_stands_beside_the_verdict() {
    let because = "the arm works alone";
    let conclusion = judged(&[of_one("E", 398, 400, Some(because))], 0.9).conclusion;
    assert_eq!(conclusion.verdict, Verdict::Satisfied, "{conclusion:?}");
    let said = "declared to stand for all (\"the arm works alone\")";
    assert!(
        conclusion.statement.contains(said),
        "{}",
        conclusion.statement
    );
    assert!(conclusion.excluded.is_empty());
}

#[test]
fn a_failure_of_one_person_refutes_certainty() {
    let conclusion = judged(&[of_one("E", 399, 400, None)], 1.0).conclusion;
    assert_eq!(conclusion.verdict, Verdict::Violated, "{conclusion:?}");
}

/// Beside trials with several people they neither share the level nor take their place; that they differ is said of this one, and
/// decides nothing; and under other conditions they refute nothing.
#[test]
fn one_person_does_not_stand_beside_several() {
    let several = piece("F", Technique::Experiment, vec![(0, counts(97, 100))]);
    let alone = judged(std::slice::from_ref(&several), 0.9).conclusion;
    let both = judged(&[of_one("E", 380, 400, None), several.clone()], 0.9).conclusion;
    let own = |it: &Conclusion| it.standings.iter().find(|it| it.evidence == "F").cloned();
    assert_eq!(own(&alone), own(&both));
    assert_eq!(both.verdict, alone.verdict, "{both:?}");
    let apart = judged(&[of_one("E", 20, 400, None), several.clone()], 0.9).conclusion;
    assert_eq!(apart.verdict, alone.verdict, "{apart:?}");
    let said = "E and F differ by 92 points, beyond chance, which is said of one alone and is not a conflict.";
    assert!(apart.statement.contains(said), "{}", apart.statement);

    let mut elsewhere = of_one("E", 20, 400, None);
    elsewhere.conditions = "wet".into();
    let there = judged(&[several, elsewhere], 0.9).conclusion;
    assert_eq!(there.verdict, alone.verdict, "{there:?}");
}

/// A model in the dry beside several people in the wet: they are tried there, whoever alone was in the dry.
#[test]
fn one_person_does_not_choose_the_conditions() {
    let model = piece("M", Technique::ModelChecking, vec![(0, exact(0.97))]);
    let mut several = piece("F", Technique::Experiment, vec![(0, counts(97, 100))]);
    several.conditions = "wet".into();
    let alone = judged(&[model.clone(), several.clone()], 0.9).conclusion;
    let one = of_one("E", 380, 400, None);
    let both = judged(&[model, several, one], 0.9).conclusion;
    assert_eq!(
        (both.verdict, both.step),
        (alone.verdict, alone.step),
        "{both:?}"
    );
}

#[test]
fn no_agreement_with_one_person_carries_a_model_over_to_the_system() {
    let ledger = |because| {
        [
            piece(
                "M",
                Technique::ModelChecking,
                vec![(0, exact(0.97)), (1, exact(0.97))],
            ),
            of_one("E", 388, 400, because),
        ]
    };
    let decided = |because| {
        let ledger = ledger(because);
        let influences = Influences::learn(&ledger);
        let mut asked = requirement(1, at_least(0.8));
        asked.carries_over = vec![CarryOver {
            evidence: "M".into(),
            shown_by: "M".into(),
            on: subject(0),
            because: "the same arm".into(),
        }];
        let study = Study {
            requirements: &[requirement(0, None), asked],
            failure_modes: &[],
            evidence: &ledger,
            influences: &influences,
            looks: None,
            levels: Levels::new(0.95, 0.95).expect("levels"),
        };
        let comparisons = compare(&study);
        conclude(&study, &comparisons)[1].step
    };
    assert_eq!(decided(Some("one arm")), Some(Step::Corroborated));
    assert_eq!(decided(None), Some(Step::Model));
}

/// Simulated runs of one cluster, as of one task of a learned policy, satisfy and refute nothing, conflict with nothing beyond
/// the one trial that they are worth, and take no place; a reason lets them.
#[test]
fn simulated_runs_of_one_cluster_decide_nothing_either() {
    let one = |count, because| one_by(Technique::Simulation, "S", (count, 200), because);
    let several = |count| piece("T", Technique::Simulation, vec![(0, counts(count, 200))]);
    for (count, with_a_reason) in [(200, Verdict::Satisfied), (0, Verdict::Violated)] {
        let found = judged(&[one(count, None)], 0.9);
        let conclusion = &found.conclusion;
        assert_eq!(
            (conclusion.verdict, conclusion.step),
            (Verdict::Undecided, None),
            "{conclusion:?}"
        );
        let left_out = &conclusion.excluded[0];
        assert_eq!(left_out.reason, ExclusionReason::OneSubject);
        assert!(left_out.words.contains("of one cluster"), "{left_out:?}");
        assert!(found.pooled.interval.is_none(), "{:?}", found.pooled);
        assert!(found.synthesis.deciding.is_empty());

        let declared = judged(&[one(count, Some("one task is all"))], 0.9).conclusion;
        assert_eq!(declared.verdict, with_a_reason, "{declared:?}");

        // Later than runs of several, and the other way round.
        let rest = judged(&[several(200 - count)], 0.9).conclusion;
        let after = judged(&[several(200 - count), one(count, None)], 0.9).conclusion;
        assert_eq!(
            (after.verdict, after.step),
            (rest.verdict, rest.step),
            "{after:?}"
        );
        // Beside a model that computes the contrary, and trials of the system.
        // One run may go either way with both of its rates.
        let often = if count == 0 { 170 } else { 60 };
        let rate = often as f64 / 200.0;
        let model = piece("M", Technique::ModelChecking, vec![(0, exact(rate))]);
        let trials = piece("F", Technique::Experiment, vec![(0, counts(often, 200))]);
        for other in [model, trials] {
            let alone = judged(std::slice::from_ref(&other), 0.9).conclusion;
            let both = judged(&[one(count, None), other.clone()], 0.9);
            assert_eq!(
                both.conclusion.verdict,
                alone.verdict,
                "{both:?}",
                both = both.conclusion
            );
            let declared = judged(&[one(count, Some("one task is all")), other], 0.9);
            let conflicts = |it: &Judged| {
                it.comparisons
                    .iter()
                    .any(|it| it.outcome == Outcome::Conflicts)
            };
            assert!(!conflicts(&both) && conflicts(&declared));
        }
    }
    let mut there = one(0, None);
    there.conditions = "wet".into();
    let alone = judged(&[several(200)], 0.9).conclusion;
    let both = judged(&[several(200), there], 0.9).conclusion;
    assert_eq!(both.verdict, alone.verdict, "{both:?}");
}

#[test]
fn simulated_runs_of_one_cluster_carry_nothing_over_to_the_system() {
    let step = |because| {
        let mut runs = one_by(Technique::Simulation, "S", (194, 200), because);
        runs = runs.found(Finding::new(subject(1), counts(194, 200)));
        let trials = piece("F", Technique::Experiment, vec![(0, counts(388, 400))]);
        let ledger = [runs, trials];
        let influences = Influences::learn(&ledger);
        let mut asked = requirement(1, at_least(0.8));
        asked.carries_over = vec![CarryOver {
            evidence: "S".into(),
            shown_by: "S".into(),
            on: subject(0),
            because: "the same arm".into(),
        }];
        let study = Study {
            requirements: &[requirement(0, None), asked],
            failure_modes: &[],
            evidence: &ledger,
            influences: &influences,
            looks: None,
            levels: Levels::new(0.95, 0.95).expect("levels"),
        };
        conclude(&study, &compare(&study))[1].step
    };
    assert_eq!(step(Some("one task is all")), Some(Step::Corroborated));
    assert_eq!(step(None), None);
}

/// What one person did differs from a model beyond chance: a relation that is shown of this one, and neither a conflict nor, where
/// they are alike, corroboration. A model that excludes what one did is refuted by it.
#[test]
fn what_is_shown_of_one_person_is_no_outcome_between_evidence() {
    let compared = |count, known, because| {
        let model = piece("M", Technique::ModelChecking, vec![(0, exact(known))]);
        let found = judged(&[model, of_one("E", count, 400, because)], 0.9);
        found.comparisons[0].clone()
    };
    let apart = compared(200, 0.97, None);
    assert_eq!(
        (apart.relation, apart.outcome),
        (Some(Relation::Different), Outcome::Inconclusive),
        "{apart:?}"
    );
    let said = "This is not a conflict: all trials of E are of one person or session alone, and how others go is not known.";
    assert!(apart.reason.contains(said), "{}", apart.reason);
    let alike = compared(388, 0.97, None);
    assert_eq!(alike.outcome, Outcome::Inconclusive, "{alike:?}");
    assert!(
        alike.reason.contains("This is not corroboration"),
        "{}",
        alike.reason
    );

    let outcome = |count, known, because| compared(count, known, because).outcome;
    assert_eq!(outcome(200, 1.0, None), Outcome::Conflicts);
    // That one did what certainty asks for shows nothing of others.
    assert_eq!(outcome(400, 1.0, None), Outcome::Inconclusive);
    let because = Some("the arm works alone");
    assert_eq!(outcome(200, 0.97, because), Outcome::Conflicts);
    assert_eq!(outcome(388, 0.97, because), Outcome::Corroborates);
}

/// Ten people of whom one alone triggers a requirement: its trials are all of this one, whatever the piece has otherwise.
#[test]
fn trials_that_one_of_several_has_are_of_one() {
    let row = |successes, trials| stats::Sample { successes, trials };
    let mut rows = vec![row(60, 60)];
    rows.extend([row(0, 0); 9]);
    let measure = Measure::of_clusters(&rows, stats::Confidence::P95).expect("a measure");
    let mut piece = piece("E", Technique::Experiment, vec![(0, measure)]);
    piece.clusters = Some(ClusterTests {
        effective_trials: 60.0,
        subjects: 10,
        ..ClusterTests::default()
    });
    assert!(!piece.is_of_one_subject() && piece.is_of_one_subject_on(&subject(0)));
    let found = judged(&[piece], 0.8);
    assert_eq!(
        found.conclusion.verdict,
        Verdict::Undecided,
        "{:?}",
        found.conclusion
    );
}

/// Two cohorts that conflict do so whoever alone was tried besides.
#[test]
fn one_person_takes_no_level_from_a_conflict_of_others() {
    let several = |id: &str, count| piece(id, Technique::Experiment, vec![(0, counts(count, 30))]);
    let both = [several("A", 30), several("B", 24)];
    let corrected = |ledger: &[Evidence]| {
        let all = judged(ledger, 0.5).comparisons;
        let mut own = all
            .into_iter()
            .filter(|it| it.left == "A" && it.right == "B");
        own.next().expect("the pair").p_difference_corrected
    };
    let with_more: Vec<Evidence> = both
        .iter()
        .cloned()
        .chain([of_one("C", 25, 30, None), of_one("D", 26, 30, None)])
        .collect();
    assert_eq!(corrected(&with_more), corrected(&both));
}

/// A word that was chosen because a model agrees makes agreement with the model a fit. The trials stay trials: both tables decide,
/// in whatever order the ledger has them, and stay independent of each other.
#[test]
fn a_chosen_reading_takes_no_trials_from_the_verdict() {
    let chosen = |mut piece: Evidence| {
        piece.calibrated = vec![Calibration {
            parameter: "a column".into(),
            from: "M".into(),
            subject: subject(0),
            chosen: true,
        }];
        piece
    };
    let model = || piece("M", Technique::ModelChecking, vec![(0, exact(0.86))]);
    let trials = |id: &str, count| {
        chosen(piece(
            id,
            Technique::Experiment,
            vec![(0, counts(count, 1200))],
        ))
    };
    let (good, bad) = (trials("G", 1010), trials("B", 900));
    for ledger in [[model(), good.clone(), bad.clone()], [model(), bad, good]] {
        let found = judged(&ledger, 0.8);
        assert_eq!(
            found.conclusion.verdict,
            Verdict::Violated,
            "{:?}",
            found.conclusion
        );
        for pair in &found.comparisons {
            let is_with_model = pair.left == "M" || pair.right == "M";
            assert_eq!(pair.independent, !is_with_model, "{pair:?}");
        }
        let said = "\"a column\" was chosen because it agrees with M";
        let statement = &found.conclusion.statement;
        assert!(statement.contains(&format!("In G {said}")), "{statement}");
        assert!(statement.contains(&format!("In B {said}")), "{statement}");
    }
}
