//! Verdicts on hundreds of generated studies: every word of a verdict against the figures beside it, no value outside its
//! own interval, nothing left out in silence; and the error rates of verdicts, by sums and by simulation.

use crate::support;

use evidence::*;
use stats::special::binomial_pmf;
use support::{Uniform, any_study, at_least, counts, exact, piece, requirement, subject};

/// All that is concluded from a ledger.
struct Concluded {
    comparisons: Vec<Comparison>,
    conclusions: Vec<Conclusion>,
    combined: Vec<Combined>,
}

fn concluded(ledger: &[Evidence], requirements: &[Requirement], family: ErrorFamily) -> Concluded {
    let influences = Influences::learn(ledger);
    let levels = Levels::new(0.95, 0.95).expect("levels");
    let study = Study {
        requirements,
        failure_modes: &[],
        evidence: ledger,
        influences: &influences,
        looks: None,
        levels: levels.with_error_rates_of(family),
    };
    let comparisons = compare(&study);
    Concluded {
        conclusions: conclude(&study, &comparisons),
        combined: combine(&study, &comparisons, &Weights::default()),
        comparisons,
    }
}

fn one(ledger: &[Evidence], threshold: f64) -> Conclusion {
    let asked = [requirement(0, at_least(threshold))];
    concluded(ledger, &asked, ErrorFamily::Study)
        .conclusions
        .swap_remove(0)
}

/// The sides of a threshold, "met" and "missed", that an interval leaves.
fn shown_by(limits: Interval, threshold: Threshold, step: Step) -> Standing {
    // A computed value is compared with the tolerance of certainty.
    let rounding = if step == Step::Model { 2e-9 } else { 0.0 };
    let Threshold { direction, value } = threshold;
    let (met, missed) = match direction {
        Direction::AtLeast => (
            limits.low >= value - rounding,
            limits.high < value - rounding,
        ),
        Direction::AtMost => (
            limits.high <= value + rounding,
            limits.low > value + rounding,
        ),
    };
    match (met, missed) {
        (_, true) => Standing::Denies,
        (true, _) => Standing::Supports,
        _ => Standing::Neither,
    }
}

fn within(value: f64, interval: Interval, what: &str) {
    let Interval { low, high } = interval;
    assert!(
        low - 1e-9 <= value && value <= high + 1e-9,
        "{what}: {value} outside {interval:?}"
    );
}

/// Each piece's figures: limit, p-value and word say the same.
fn check_standings(ledger: &[Evidence], requirement: &Requirement, conclusion: &Conclusion) {
    let threshold = requirement.threshold.unwrap_or(Threshold {
        direction: Direction::AtLeast,
        value: 1.0,
    });
    for it in &conclusion.standings {
        let by_p = if it.p_met <= it.level_missed {
            Standing::Denies
        } else if it.p_not_met <= it.level_met {
            Standing::Supports
        } else {
            Standing::Neither
        };
        assert_eq!(it.standing, by_p, "{it:?}");
        let is_certainty = threshold.value >= 1.0;
        if !is_certainty && it.step != Step::Corroborated {
            assert_eq!(
                it.standing,
                shown_by(it.limits, threshold, it.step),
                "{threshold:?} {it:?}"
            );
        }
        let piece = ledger
            .iter()
            .find(|piece| piece.id == it.evidence)
            .expect("known");
        let own = piece.finding(&Subject::Requirement(requirement.id.clone()));
        let other = requirement.same_quantity_as.clone();
        let quantity = other.map(Subject::Requirement);
        let finding = own
            .or_else(|| piece.finding(quantity.as_ref()?))
            .expect("found");
        let estimate = finding.measure.estimate().expect("a number");
        within(estimate, it.limits, &format!("{it:?}"));
        if !it.elsewhere {
            assert!(conclusion.statement.contains(&it.words), "{conclusion:?}");
        }
    }
}

/// The words of the claim are those of the verdict, and the verdict is that of the strongest pieces.
fn check_words(found: &Concluded, conclusion: &Conclusion) {
    let statement = &conclusion.statement;
    let of = |step: Step, standing: Standing| {
        let mut standings = conclusion.standings.iter();
        standings.any(|it| it.step == step && it.standing == standing)
    };
    let claims = [
        ("is supported", Verdict::Satisfied),
        ("is refuted", Verdict::Violated),
        ("is neither supported nor refuted", Verdict::Undecided),
        ("because pieces of evidence conflict", Verdict::Conflicting),
        ("Not covered by any evidence", Verdict::NotCovered),
    ];
    for (words, verdict) in claims {
        assert_eq!(
            statement.contains(words),
            conclusion.verdict == verdict,
            "{conclusion:?}"
        );
    }
    match (conclusion.verdict, conclusion.step) {
        (Verdict::Satisfied, Some(step)) => assert!(of(step, Standing::Supports), "{conclusion:?}"),
        (Verdict::Violated, Some(step)) => assert!(of(step, Standing::Denies), "{conclusion:?}"),
        (Verdict::Satisfied | Verdict::Violated, None) => panic!("no step: {conclusion:?}"),
        (Verdict::Undecided | Verdict::NotCovered, step) => assert_eq!(step, None),
        (Verdict::Conflicting, _) => {}
    }
    let conflict = found.comparisons.iter().any(|it| {
        it.outcome == Outcome::Conflicts
            && conclusion.rests_on.contains(&it.left)
            && conclusion.rests_on.contains(&it.right)
    });
    let says_so = conclusion.verdict == Verdict::Conflicting || statement.contains(" conflict: ");
    assert!(!says_so || conflict, "no pair conflicts: {conclusion:?}");
    let enough = conclusion.step.is_some_and(|step| step >= conclusion.needs);
    let below = conclusion.verdict == Verdict::Satisfied && !enough;
    assert_eq!(
        statement.contains("This is not enough"),
        below,
        "{conclusion:?}"
    );
}

/// What found anything on a requirement takes part in its conclusion or is listed with a reason, once; what takes part is
/// listed only where it does not count on the step that is needed. Runs without a verdict are listed, too.
fn check_nothing_is_silent(
    ledger: &[Evidence],
    requirement: &Requirement,
    conclusion: &Conclusion,
) {
    let quantity = requirement
        .same_quantity_as
        .as_ref()
        .unwrap_or(&requirement.id);
    for piece in ledger {
        let finding = piece.finding(&Subject::Requirement(quantity.clone()));
        let mut listed = conclusion
            .excluded
            .iter()
            .filter(|it| it.evidence == piece.id);
        let (reason, again) = (listed.next(), listed.next());
        let part = conclusion.rests_on.contains(&piece.id);
        let what = format!("{} {conclusion:?}", piece.id);
        assert!(again.is_none(), "listed twice: {what}");
        assert_eq!(reason.is_some() || part, finding.is_some(), "{what}");
        if let Some(it) = reason {
            let of = &it.reason;
            let both = matches!(
                of,
                ExclusionReason::BelowNeededStep(_) | ExclusionReason::NotIndependent(_)
            );
            assert_eq!(part, both, "{what}");
            let silent = finding.is_some_and(|it| it.measure.estimate().is_none());
            assert_eq!(silent, of.is_silence(), "{what}");
            assert!(
                it.words.starts_with(&piece.id) && it.words.ends_with('.'),
                "{what}"
            );
        }
        let undecided = finding.map_or(0, |it| it.undecided);
        let trials = conclusion.excluded_trials.iter();
        let trials: Vec<u64> = trials
            .filter(|it| it.evidence == piece.id)
            .map(|it| it.trials)
            .collect();
        assert_eq!(trials.iter().sum::<u64>(), undecided, "{what}");
    }
    check_what_is_needed(requirement, conclusion);
}

/// A requirement that is satisfied on a step that is enough has a piece that supports it and is not listed as below it.
fn check_what_is_needed(requirement: &Requirement, conclusion: &Conclusion) {
    let is_below = |id: &str| {
        conclusion
            .excluded
            .iter()
            .any(|it| it.evidence == id && matches!(it.reason, ExclusionReason::BelowNeededStep(_)))
    };
    for it in conclusion.standings.iter().filter(|it| !it.elsewhere) {
        if it.step >= requirement.needs {
            assert!(!is_below(&it.evidence), "{conclusion:?}");
        } else if it.step != Step::Corroborated {
            let carried = conclusion
                .standings
                .iter()
                .any(|other| other.evidence == it.evidence && other.step == Step::Corroborated);
            assert!(carried || is_below(&it.evidence), "{conclusion:?}");
        }
    }
}

#[test]
fn every_word_of_a_verdict_holds_against_the_figures_beside_it() {
    let mut uniform = Uniform(1);
    let mut seen = std::collections::BTreeMap::new();
    for _ in 0..600 {
        let (ledger, requirements) = any_study(&mut uniform);
        let found = concluded(&ledger, &requirements, ErrorFamily::Study);
        for (requirement, conclusion) in requirements.iter().zip(&found.conclusions) {
            check_standings(&ledger, requirement, conclusion);
            check_words(&found, conclusion);
            check_nothing_is_silent(&ledger, requirement, conclusion);
            *seen
                .entry(format!("{:?} {:?}", conclusion.verdict, conclusion.step))
                .or_insert(0) += 1;
        }
    }
    // All kinds of verdict come up.
    for kind in [
        "Satisfied Some(System)",
        "Satisfied Some(Simulation)",
        "Satisfied Some(Model)",
        "Violated Some(System)",
        "Violated Some(Simulation)",
        "Violated Some(Model)",
        "Undecided None",
        "Conflicting None",
        "NotCovered None",
    ] {
        assert!(seen.contains_key(kind), "{kind} of {seen:?}");
    }
}

#[test]
fn no_value_lies_outside_its_own_interval() {
    let mut uniform = Uniform(2);
    for _ in 0..400 {
        let (ledger, requirements) = any_study(&mut uniform);
        let found = concluded(&ledger, &requirements, ErrorFamily::Study);
        for finding in ledger.iter().flat_map(|piece| &piece.findings) {
            if let (Some(value), Some(interval)) =
                (finding.measure.estimate(), finding.measure.interval())
            {
                within(value, interval, "finding");
            }
        }
        for it in &found.comparisons {
            if let (Some(difference), Some(interval)) = (it.difference, it.difference_interval) {
                within(difference, interval, &it.reason);
            }
        }
        for it in &found.combined {
            if let (Some(rate), Some(interval)) = (it.rate, it.interval) {
                within(rate, interval, &it.statement);
            }
        }
    }
}

/// The chance that a typed-in constant makes a system below the threshold "satisfied" on a step that is enough, as the sum
/// over all counts; and that it is called so at all, which says of what.
#[test]
fn a_typed_in_constant_decides_for_the_model_alone() {
    let (threshold, truth, trials) = (0.9, 0.85, 10);
    let (mut any, mut enough) = (0.0, 0.0);
    for count in 0..=trials {
        let ledger = [
            piece("M", Technique::ModelChecking, vec![(0, exact(0.95))]),
            piece("E", Technique::Experiment, vec![(0, counts(count, trials))]),
        ];
        let found = one(&ledger, threshold);
        let weight = binomial_pmf(count, trials, truth);
        let satisfied = found.verdict == Verdict::Satisfied;
        any += weight * f64::from(u8::from(satisfied));
        enough += weight * f64::from(u8::from(found.is_enough()));
        if satisfied && !found.is_enough() {
            assert!(found.statement.contains("for the model only"), "{found:?}");
        }
    }
    assert!(any > 0.8 && enough < 0.05, "{any} {enough}");
}

/// The same over grids, as sums over all counts: never more often than the level, beside models of any value.
#[test]
fn a_false_verdict_of_the_system_is_rare_whatever_a_model_says() {
    for (threshold, trials) in [(0.6, 20), (0.9, 40), (0.95, 120)] {
        for model in [None, Some(0.3), Some(threshold), Some(1.0)] {
            let of = |count: u64| {
                let counted = piece("E", Technique::Experiment, vec![(0, counts(count, trials))]);
                let mut ledger = vec![counted];
                if let Some(value) = model {
                    ledger.insert(
                        0,
                        piece("M", Technique::ModelChecking, vec![(0, exact(value))]),
                    );
                }
                one(&ledger, threshold)
            };
            let found: Vec<Conclusion> = (0..=trials).map(of).collect();
            let chance = |truth: f64, wanted: Verdict| -> f64 {
                let of_system =
                    |c: &Conclusion| c.verdict == wanted && c.step >= Some(Step::Corroborated);
                let counted = found.iter().zip(0..).filter(|(c, _)| of_system(c));
                counted
                    .map(|(_, count)| binomial_pmf(count, trials, truth))
                    .sum()
            };
            for step in 0..=20 {
                let truth = f64::from(step) / 20.0;
                let wrong = match truth < threshold {
                    true => Verdict::Satisfied,
                    false => Verdict::Violated,
                };
                let wrong = chance(truth, wrong);
                assert!(
                    wrong <= 0.05 + 1e-9,
                    "{threshold} {trials} {model:?} {truth}: {wrong}"
                );
            }
        }
    }
}

/// Requirements at their thresholds: a small version of the table of `conclude`.
#[test]
fn false_verdicts_of_several_requirements_are_as_rare_as_of_one() {
    let (requirements, trials, studies) = (5_usize, 60_u64, 400);
    let asked: Vec<Requirement> = (0..requirements)
        .map(|i| requirement(i, at_least(0.9)))
        .collect();
    let mut wrong = [[0_u32; 2]; 2];
    let mut uniform = Uniform(3);
    for _ in 0..studies {
        let findings = (0..requirements).map(|i| (i, counts(uniform.count(trials, 0.9), trials)));
        let ledger = [piece("E", Technique::Experiment, findings.collect())];
        for (row, family) in [ErrorFamily::Study, ErrorFamily::Requirement]
            .into_iter()
            .enumerate()
        {
            let found = concluded(&ledger, &asked, family).conclusions;
            for (column, verdict) in [Verdict::Violated, Verdict::Satisfied]
                .into_iter()
                .enumerate()
            {
                wrong[row][column] += u32::from(found.iter().any(|c| c.verdict == verdict));
            }
        }
    }
    let share = |count: u32| f64::from(count) / f64::from(studies);
    let tolerance = 4.0 * (0.05_f64 * 0.95 / f64::from(studies)).sqrt();
    for count in wrong[0] {
        assert!(share(count) <= 0.05 + tolerance, "{wrong:?}");
    }
    // Without the correction it is seen, so that the test can fail.
    assert!(share(wrong[1][0]) > 0.05 + tolerance, "{wrong:?}");
}

/// Agreement on one requirement carries over to another where it is declared, less the margin, and nowhere else.
#[test]
fn a_model_carries_over_only_where_it_is_declared_and_agrees() {
    let asked = |carries: bool| {
        let mut all = [
            requirement(0, at_least(0.5)),
            requirement(1, at_least(0.85)),
        ];
        if carries {
            all[1].carries_over = vec![CarryOver {
                evidence: "M".into(),
                shown_by: "M".into(),
                on: subject(0),
                because: "the same mechanism".into(),
            }];
        }
        all
    };
    let ledger = |passed: u64, value: f64| {
        [
            piece(
                "M",
                Technique::ModelChecking,
                vec![(0, exact(0.9)), (1, exact(value))],
            ),
            piece("E", Technique::Experiment, vec![(0, counts(passed, 200))]),
        ]
    };
    let of = |passed, value, carries| {
        let found = concluded(&ledger(passed, value), &asked(carries), ErrorFamily::Study);
        let conclusion = found.conclusions[1].clone();
        (conclusion.verdict, conclusion.step)
    };
    let satisfied = Verdict::Satisfied;
    assert_eq!(of(180, 0.99, true), (satisfied, Some(Step::Corroborated)));
    assert_eq!(of(180, 0.99, false), (satisfied, Some(Step::Model)));
    // 90 % less the margin of 10 points is no 85 %.
    assert_eq!(of(180, 0.9, true), (satisfied, Some(Step::Model)));
    assert_eq!(
        of(180, 0.7, true),
        (Verdict::Violated, Some(Step::Corroborated))
    );
    // The model does not agree with the system on what it is declared to carry over from.
    assert_eq!(of(140, 0.99, true), (satisfied, Some(Step::Model)));
}

/// A model under other conditions that stands later in the ledger takes nothing from one that holds where the system was
/// tried; where it is the declared one, that it is not used is said.
#[test]
fn conditions_under_which_the_system_was_tried_go_before_others() {
    let mut asked = [
        requirement(0, at_least(0.5)),
        requirement(1, at_least(0.85)),
    ];
    let carries = |id: &str| {
        vec![CarryOver {
            evidence: id.into(),
            shown_by: "M".into(),
            on: subject(0),
            because: "the same mechanism".into(),
        }]
    };
    let both = vec![(0, exact(0.9)), (1, exact(0.99))];
    let mut wet = piece("W", Technique::ModelChecking, both.clone());
    wet.conditions = "wet".into();
    let ledger = [
        piece("M", Technique::ModelChecking, both),
        wet,
        piece("E", Technique::Experiment, vec![(0, counts(180, 200))]),
    ];
    asked[1].carries_over = carries("M");
    let found = concluded(&ledger, &asked, ErrorFamily::Study).conclusions[1].clone();
    assert_eq!(found.step, Some(Step::Corroborated), "{found:?}");
    asked[1].carries_over = carries("W");
    let found = concluded(&ledger, &asked, ErrorFamily::Study).conclusions[1].clone();
    assert_eq!(found.step, Some(Step::Model), "{found:?}");
    let said = "W holds under other conditions (wet) and does not refute it there. It is declared to carry over";
    assert!(
        found.excluded.iter().any(|it| it.words.starts_with(said)),
        "{:?}",
        found.excluded
    );
}

#[test]
fn trials_that_are_marked_as_intermediate_are_named_in_the_statement() {
    let mut hidden = piece("E", Technique::Experiment, vec![(0, counts(60, 100))]);
    hidden.intermediate = true;
    let ledger = [
        hidden,
        piece("F", Technique::Experiment, vec![(0, counts(100, 100))]),
    ];
    let found = one(&ledger, 0.9);
    assert_eq!(found.verdict, Verdict::Satisfied);
    assert_eq!(found.excluded.len(), 1, "{found:?}");
    let said =
        "E is left out as intermediate; with it the verdict would be violated (of the system).";
    assert!(found.statement.contains(said), "{}", found.statement);
}
