//! The verdict on one requirement from how each piece stands, and the step of it.
//!
//! # Definition
//! In this order, over the standings under the conditions of the conclusion:
//!
//! | verdict | step | when |
//! |---|---|---|
//! | not covered | none | nothing has a number on it |
//! | conflicting | of the system | two trials of the system conflict and stand differently |
//! | undecided | none | of two trials of the system that are shown to differ by less than the margin one supports it, the other leans to the other side, and none denies it |
//! | violated | of the system | independent trials of the system deny it |
//! | satisfied | of the system | independent trials of the system support it |
//! | conflicting | none | two pieces conflict and stand differently |
//! | violated, satisfied | corroborated | a model whose agreement carries over denies or supports it |
//! | violated | in simulation, for the model | a simulation or model denies it |
//! | satisfied | in simulation, for the model | one supports it |
//! | undecided | none | else |
//!
//! Trials that rest on other trials decide nothing beside these, and trials or simulated runs of one person, session or other
//! cluster alone nothing of others, unless the study declares that this one stands for all ([`crate::Evidence::is_of_one_subject`]).
//!
//! A piece *conflicts* with another where the comparison of both says so (`compare`) and they are independent. That one
//! supports and another denies is no conflict by itself: their rates may lie close on either side of the threshold.
//!
//! Then what denies the requirement under other conditions is added: a requirement is asked under each of them. A model
//! that denies it there gives way to trials of the system under the same conditions that support it. Trials of the system that leave
//! it open there leave it undecided, however many models speak of either conditions.
//!
//! # Assumes
//! The standings are those of tests that hold their levels, and all trials of the system under the same conditions speak of
//! one rate. Where two are shown not to, and lie on both sides of the threshold, nothing is called satisfied.
//!
//! # Guarantee
//! A verdict of the system rests on trials of the system alone, at their error rates; no number of models changes it. A verdict on a
//! lower step has no error rate of the system, and says so.

use crate::{PieceStanding, Standing, Step, Verdict};

/// A verdict with the step on which it stands.
pub(super) type Decided = (Verdict, Option<Step>);

/// A piece with how it stands and whether it may decide.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    pub standing: PieceStanding,
    /// `false` for trials that rest on other trials which take part, and for those of one subject alone.
    pub decides: bool,
    /// Under which conditions.
    pub conditions: String,
}

/// Pairs of independent pieces whose rates are shown to differ.
#[derive(Clone, Debug, Default)]
pub(super) struct Apart {
    /// Those that conflict: the estimates are the margin or more apart.
    pub conflicts: Vec<(String, String)>,
    /// All others.
    pub within_margin: Vec<(String, String)>,
}

/// The verdict on standings, with the pairs of independent pieces that differ.
pub(super) fn decide(judged: &[Judged], apart: &Apart) -> Decided {
    let here: Vec<&Judged> = judged.iter().filter(|it| !it.standing.elsewhere).collect();
    let decided = decide_here(&here, apart);
    let elsewhere = denied_elsewhere(judged);
    match (decided, elsewhere) {
        ((Verdict::Satisfied, Some(Step::System)), None) if !left_open(judged).is_empty() => {
            (Verdict::Undecided, None)
        }
        ((Verdict::NotCovered | Verdict::Conflicting, _), _) | (_, None) => decided,
        ((Verdict::Violated, step), other) => (Verdict::Violated, step.max(other)),
        (_, other) => (Verdict::Violated, other),
    }
}

fn decide_here(here: &[&Judged], apart: &Apart) -> Decided {
    if here.is_empty() {
        return (Verdict::NotCovered, None);
    }
    let trials = of_steps(here, &[Step::System]);
    if lean_apart(&trials, &apart.within_margin).is_some() {
        return (Verdict::Undecided, None);
    }
    if let Some(verdict) = by_trials(&trials, &apart.conflicts) {
        return (verdict, Some(Step::System));
    }
    if stand_differently(here, &apart.conflicts) {
        return (Verdict::Conflicting, None);
    }
    let models = [
        &[Step::Corroborated][..],
        &[Step::Simulation, Step::Model][..],
    ];
    for steps in models {
        let models = of_steps(here, steps);
        for (standing, verdict) in [
            (Standing::Denies, Verdict::Violated),
            (Standing::Supports, Verdict::Satisfied),
        ] {
            if let Some(step) = highest(&models, standing) {
                return (verdict, Some(step));
            }
        }
    }
    (Verdict::Undecided, None)
}

/// What the trials of the system say, if they decide.
fn by_trials(trials: &[&Judged], conflicts: &[(String, String)]) -> Option<Verdict> {
    let any = |wanted: Standing| {
        let mut trials = trials.iter();
        trials.any(|it| it.decides && it.standing.standing == wanted)
    };
    if stand_differently(trials, conflicts) {
        Some(Verdict::Conflicting)
    } else if any(Standing::Denies) {
        Some(Verdict::Violated)
    } else if any(Standing::Supports) {
        Some(Verdict::Satisfied)
    } else {
        None
    }
}

/// Two trials of the system that are shown to differ, of which the first supports the requirement, the second leans to the other side
/// of the threshold, and none denies it: they are not of one rate, so that one of them decides nothing of it.
pub(super) fn lean_apart<'j>(
    trials: &[&'j Judged],
    differ: &[(String, String)],
) -> Option<(&'j Judged, &'j Judged)> {
    let of = |id: &str| trials.iter().find(|it| it.standing.evidence == id);
    if trials
        .iter()
        .any(|it| it.decides && it.standing.standing == Standing::Denies)
    {
        return None;
    }
    let both = differ.iter().filter_map(|(one, other)| {
        let (one, other) = (*of(one)?, *of(other)?);
        [(one, other), (other, one)]
            .into_iter()
            .find(|(one, other)| {
                let leans_away = other.standing.p_met < other.standing.p_not_met;
                one.decides && one.standing.standing == Standing::Supports && leans_away
            })
    });
    both.into_iter().next()
}

fn of_steps<'a>(here: &[&'a Judged], steps: &[Step]) -> Vec<&'a Judged> {
    let wanted = |it: &&&Judged| steps.contains(&it.standing.step);
    here.iter().filter(wanted).copied().collect()
}

/// Whether two of them conflict and stand differently.
fn stand_differently(judged: &[&Judged], conflicts: &[(String, String)]) -> bool {
    let standing = |id: &str| {
        let mut judged = judged.iter();
        let own =
            judged.find(|it| it.standing.evidence == id && it.standing.step != Step::Corroborated);
        own.map(|it| it.standing.standing)
    };
    conflicts
        .iter()
        .any(|(left, right)| match (standing(left), standing(right)) {
            (Some(left), Some(right)) => left != right,
            _ => false,
        })
}

/// The highest step on which a piece stands so.
fn highest(judged: &[&Judged], wanted: Standing) -> Option<Step> {
    let so = judged
        .iter()
        .filter(|it| it.decides && it.standing.standing == wanted);
    so.map(|it| it.standing.step).max()
}

/// The highest step on which something denies the requirement under other conditions.
fn denied_elsewhere(judged: &[Judged]) -> Option<Step> {
    let elsewhere = judged.iter().filter(|it| it.standing.elsewhere);
    let denies = elsewhere.filter(|it| is_denial(it, judged));
    denies.map(|it| it.standing.step).max()
}

/// The trials of the system that leave the requirement open under other conditions than those of the verdict, where none there decide it: it
/// is asked under these, too. How many models speak of which conditions changes nothing of that.
pub(super) fn left_open(judged: &[Judged]) -> Vec<&Judged> {
    let is_open = |it: &&Judged| {
        let is_of_system = |other: &Judged| {
            other.standing.elsewhere
                && other.decides
                && other.conditions == it.conditions
                && other.standing.step == Step::System
        };
        let mut there = judged.iter().filter(|other| is_of_system(other));
        is_of_system(it) && there.all(|other| other.standing.standing == Standing::Neither)
    };
    judged.iter().filter(is_open).collect()
}

/// Whether a piece under other conditions denies the requirement and no trials of the system there support it.
pub(super) fn is_denial(piece: &Judged, judged: &[Judged]) -> bool {
    let overruled = || {
        judged.iter().any(|other| {
            other.standing.elsewhere
                && other.decides
                && other.conditions == piece.conditions
                && other.standing.step == Step::System
                && other.standing.standing == Standing::Supports
        })
    };
    piece.decides
        && piece.standing.standing == Standing::Denies
        && (piece.standing.step == Step::System || !overruled())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Interval;

    fn piece(id: &str, step: Step, standing: Standing) -> Judged {
        Judged {
            standing: PieceStanding {
                evidence: id.to_owned(),
                step,
                standing,
                p_not_met: 0.5,
                p_met: 0.5,
                level_met: 0.05,
                level_missed: 0.05,
                limits: Interval {
                    low: 0.0,
                    high: 1.0,
                },
                elsewhere: false,
                condition: String::new(),
                words: String::new(),
            },
            decides: true,
            conditions: "here".to_owned(),
        }
    }

    fn elsewhere(step: Step, standing: Standing) -> Judged {
        let mut piece = piece("X", step, standing);
        piece.standing.elsewhere = true;
        piece.conditions = "there".to_owned();
        piece
    }

    use Standing::{Denies, Neither, Supports};
    use Step::{Corroborated, Model, Simulation, System};

    #[test]
    fn trials_of_the_system_decide_over_models() {
        for model in [Model, Simulation, Corroborated] {
            for (trials, says, verdict) in [
                (Supports, Denies, Verdict::Satisfied),
                (Denies, Supports, Verdict::Violated),
            ] {
                let pieces = [piece("M", model, says), piece("E", System, trials)];
                assert_eq!(decide(&pieces, &Apart::default()), (verdict, Some(System)));
            }
        }
    }

    #[test]
    fn a_model_alone_speaks_of_itself() {
        let alone = |step, standing| decide(&[piece("M", step, standing)], &Apart::default());
        assert_eq!(alone(Model, Supports), (Verdict::Satisfied, Some(Model)));
        assert_eq!(
            alone(Simulation, Denies),
            (Verdict::Violated, Some(Simulation))
        );
        assert_eq!(alone(Model, Neither), (Verdict::Undecided, None));
        let both = [piece("M", Model, Denies), piece("S", Simulation, Supports)];
        assert_eq!(
            decide(&both, &Apart::default()),
            (Verdict::Violated, Some(Model))
        );
    }

    #[test]
    fn a_conflict_needs_a_pair_that_conflicts() {
        let pieces = [piece("E", System, Supports), piece("F", System, Denies)];
        assert_eq!(
            decide(&pieces, &Apart::default()),
            (Verdict::Violated, Some(System))
        );
        let pair = [("E".to_owned(), "F".to_owned())];
        assert_eq!(
            decide(&pieces, &conflict(&pair)),
            (Verdict::Conflicting, Some(System))
        );
        let with_model = [piece("E", System, Neither), piece("M", Model, Supports)];
        let pair = [("M".to_owned(), "E".to_owned())];
        assert_eq!(
            decide(&with_model, &conflict(&pair)),
            (Verdict::Conflicting, None)
        );
        let decided = [piece("E", System, Denies), piece("M", Model, Supports)];
        assert_eq!(
            decide(&decided, &conflict(&pair)),
            (Verdict::Violated, Some(System))
        );
    }

    fn conflict(pairs: &[(String, String)]) -> Apart {
        Apart {
            conflicts: pairs.to_vec(),
            ..Apart::default()
        }
    }

    #[test]
    fn trials_that_differ_on_both_sides_of_the_threshold_leave_it_undecided() {
        let apart = Apart {
            within_margin: vec![("F".to_owned(), "E".to_owned())],
            ..Apart::default()
        };
        let leaning = |p_met: f64| {
            let mut piece = piece("F", System, Neither);
            piece.standing.p_met = p_met;
            piece
        };
        let supporting = piece("E", System, Supports);
        let away = [supporting.clone(), leaning(0.1)];
        assert_eq!(decide(&away, &apart), (Verdict::Undecided, None));
        assert_eq!(
            decide(&away, &Apart::default()),
            (Verdict::Satisfied, Some(System))
        );
        let near = [supporting.clone(), leaning(0.9)];
        assert_eq!(decide(&near, &apart), (Verdict::Satisfied, Some(System)));
        // What is denied stays so.
        let denied = [supporting, leaning(0.1), piece("G", System, Denies)];
        assert_eq!(decide(&denied, &apart), (Verdict::Violated, Some(System)));
    }

    #[test]
    fn trials_that_rest_on_others_do_not_decide() {
        let mut copy = piece("F", System, Supports);
        copy.decides = false;
        let pieces = [piece("E", System, Neither), copy];
        assert_eq!(
            decide(&pieces, &Apart::default()),
            (Verdict::Undecided, None)
        );
    }

    #[test]
    fn what_is_open_under_other_conditions_is_undecided_however_many_models_there_are() {
        let night = piece("E", System, Supports);
        let open = [night.clone(), elsewhere(System, Neither)];
        assert_eq!(decide(&open, &Apart::default()), (Verdict::Undecided, None));
        let satisfied = (Verdict::Satisfied, Some(System));
        let shown = [night.clone(), elsewhere(System, Supports)];
        assert_eq!(decide(&shown, &Apart::default()), satisfied);
        let with_model = [
            night,
            piece("M", Model, Neither),
            elsewhere(System, Neither),
        ];
        assert_eq!(
            decide(&with_model, &Apart::default()),
            (Verdict::Undecided, None)
        );
    }

    #[test]
    fn denials_under_other_conditions_count_unless_the_system_passes_there() {
        let here = piece("E", System, Supports);
        let simulated = elsewhere(Simulation, Denies);
        let both = [here.clone(), simulated.clone()];
        assert_eq!(
            decide(&both, &Apart::default()),
            (Verdict::Violated, Some(Simulation))
        );
        let passed = [here.clone(), simulated, elsewhere(System, Supports)];
        assert_eq!(
            decide(&passed, &Apart::default()),
            (Verdict::Satisfied, Some(System))
        );
        let failed = [here, elsewhere(System, Denies)];
        assert_eq!(
            decide(&failed, &Apart::default()),
            (Verdict::Violated, Some(System))
        );
    }
}
