//! For the requirements that are undecided: how many further trials would settle them.
//!
//! # Definition
//! A requirement is settled by a piece of evidence, on a step that is enough for it, that shows, at the level of the
//! conclusions, that its threshold is met or that it is missed (see `conclude`). With `n` further trials, whose
//! successes `Y` have the beta-binomial distribution of Jeffreys' posterior,
//!
//! ```text
//! chance(n) = P(Y <= last y that shows the rate to be below) + P(Y >= first y that shows it to be above)
//! ```
//!
//! The plan is an `n` with `chance(n)` of at least the wanted power, found by doubling and halving.
//! Plans are made for each independent piece that counts and to which trials can be added. A
//! requirement of certainty has none: no number of trials shows it.
//!
//! # Source
//! A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in clinical trial design" (2005).
//!
//! # Assumes
//! Further trials come from the rate of those so far, whose posterior is Jeffreys' at the effective size, and further
//! people are as alike. The levels stay those of today.
//!
//! # Guarantee
//! The chance is that of `stats::Predictive` (exact up to 65536 trials). Whole numbers make it a
//! sawtooth, so that some smaller `n` may reach it, too. Clustered trials count at their design
//! effect of today, of further subjects with as many trials each as those of today have: more trials of the same
//! subjects tell less. Simulated (`promised`), 10 people with 10 trials each and 20 more at a correlation of 0.3 keep
//! what is promised on average by the test at the effective size; the conclusion asks the likelihood of people's counts,
//! too, so that a plan of further people is held against all tests of the conclusion ([`super::further_people`]).

use super::further_people::{Shown, checked};
use super::words::is_certainty;
use super::{Piece, current, independent_among, looked_at, quantity, threshold_of};
use crate::compare::{Belief, FurtherSubjects, Study, TrialCosts};
use crate::conclude::stand::shown_below_and_above;
use crate::looks::{is_open, over_looks};
use crate::{Conclusion, Direction, Requirement, Step, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{BetaPosterior, Confidence, EffectiveSample, Predictive};

/// Trials beyond which no plan is made.
const MOST_TRIALS: u64 = 10_000_000;

/// Further trials of one piece of evidence that would settle a requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Deciding {
    /// The requirement's identifier.
    pub requirement: String,
    /// The evidence to which they are added.
    pub evidence: String,
    /// How many; `None` if up to 10^7 would not settle it.
    pub trials: Option<u64>,
    /// What they cost, in the unit of the costs.
    pub cost: Option<f64>,
    /// The chance that they settle it, given what is known now.
    pub chance: Option<f64>,
    /// The chance that they show the requirement to be satisfied.
    #[serde(default)]
    pub satisfied: Option<f64>,
    /// The chance that they show it to be violated.
    #[serde(default)]
    pub violated: Option<f64>,
    /// By whom they are made, where those so far are of people or sessions with several each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<FurtherSubjects>,
}

/// Why no further trials are planned for an open requirement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct NotPlanned {
    /// The requirement's identifier.
    pub requirement: String,
    /// Why, and what would be needed, in a sentence.
    pub reason: String,
}

/// The reasons for all open and conflicting requirements without a plan, in their order.
pub(crate) fn not_planned(
    study: &Study<'_>,
    conclusions: &[Conclusion],
    planned: &[Deciding],
) -> Vec<NotPlanned> {
    let without = conclusions.iter().filter(|conclusion| {
        let is_open = conclusion.is_open() || conclusion.verdict == Verdict::Conflicting;
        is_open
            && !planned
                .iter()
                .any(|it| it.requirement == conclusion.requirement)
    });
    let reasons = without.filter_map(|conclusion| {
        let mut requirements = study.requirements.iter();
        let requirement = requirements.find(|it| it.id == conclusion.requirement)?;
        Some(NotPlanned {
            requirement: requirement.id.clone(),
            reason: why_not_planned(study, requirement, conclusion),
        })
    });
    reasons.collect()
}

fn why_not_planned(
    study: &Study<'_>,
    requirement: &Requirement,
    conclusion: &Conclusion,
) -> String {
    let quantity = quantity(study.requirements, requirement);
    if conclusion.verdict == Verdict::Conflicting {
        return "Pieces of evidence conflict; what explains it has to be found first, not further \
                trials."
            .to_owned();
    }
    let asked = threshold_of(requirement);
    if is_certainty(asked) {
        return "It asks for certainty, which no number of trials shows; one violation would refute \
                it."
        .to_owned();
    }
    if asked.value <= 0.0 || asked.value >= 1.0 {
        return "Every rate meets its threshold, so no trials are needed.".to_owned();
    }
    let pieces = current(study.evidence, requirement, &quantity);
    let mut counted = pieces.iter().filter(|piece| {
        piece.counted.is_some() && Step::of(piece.evidence.technique) >= requirement.needs
    });
    match counted.next() {
        None => match requirement.needs {
            Step::Model => {
                "It needs a verdict for the model, which no further trials decide.".to_owned()
            }
            Step::Simulation => {
                "It needs a verdict in simulation, and no simulated runs that count cover it."
                    .to_owned()
            }
            Step::Corroborated | Step::System => {
                "No trials of the system that count cover it, so there is no rate yet to plan with."
                    .to_owned()
            }
        },
        Some(piece) if piece.is_of_one_subject() => {
            let alone = pieces.iter().filter(|it| it.is_of_one_subject());
            let others =
                alone.filter(|it| it.counted.is_some() && it.evidence.technique.is_of_system());
            let others = match others.count() {
                0 | 1 => "",
                _ => {
                    " Each of several experiments is of one alone: rows of one table count together."
                }
            };
            format!(
                "All trials of {} are of {}; more of the same one decide nothing of others.{others}",
                piece.evidence.id,
                piece.evidence.one_subject()
            )
        }
        Some(piece) if piece.belief.has_undecided() && piece.belief.undecided() == 0 => format!(
            "Recordings of {} with the same messages count once and each: which is right has to be found out before further trials \
             are planned.",
            piece.evidence.id
        ),
        Some(piece) if piece.belief.has_undecided() => format!(
            "{} of {} reached no verdict and count both ways: what they would have shown has to be found out before further trials \
             are planned. Or declare in ledger.toml why they are missing at random: `undecided_at_random = \"reason\"`.",
            piece.belief.undecided(),
            piece.evidence.id
        ),
        Some(piece) if is_open(piece.evidence) => format!(
            "Trials of {} are alike within people, and what decides weighs each person's counts and the looks before: how many \
             more would decide cannot be said beforehand. Further people tell more than further trials of the same.",
            piece.evidence.id
        ),
        Some(piece) => format!(
            "No trials can be added to {}: it is published or rests on other trials.",
            piece.evidence.id
        ),
    }
}

/// Plans for every requirement whose conclusion is undecided, the cheapest first.
pub(crate) fn deciding(
    study: &Study<'_>,
    conclusions: &[Conclusion],
    costs: &TrialCosts,
) -> Vec<Deciding> {
    let open = conclusions.iter().filter(|conclusion| conclusion.is_open());
    let requirements = open.filter_map(|conclusion| {
        let mut requirements = study.requirements.iter();
        let requirement = requirements.find(|it| it.id == conclusion.requirement)?;
        Some((requirement, conclusion))
    });
    requirements
        .flat_map(|(requirement, conclusion)| plans(study, requirement, conclusion, costs))
        .collect()
}

/// Plans for the pieces whose trials can bring the requirement to the step that it needs, at the levels of the conclusion.
fn plans(
    study: &Study<'_>,
    requirement: &Requirement,
    conclusion: &Conclusion,
    costs: &TrialCosts,
) -> Vec<Deciding> {
    let Some(asked) = requirement.threshold else {
        return Vec::new();
    };
    let (threshold, at_least) = (asked.value, asked.direction == Direction::AtLeast);
    if threshold <= 0.0 || threshold >= 1.0 {
        return Vec::new();
    }
    let quantity = quantity(study.requirements, requirement);
    let enough = |piece: &Piece| {
        // More trials of the same one tell no more of others.
        Step::of(piece.evidence.technique) >= requirement.needs && !piece.is_of_one_subject()
    };
    let mut pieces = current(study.evidence, requirement, &quantity);
    pieces.retain(enough);
    let pieces = looked_at(study, pieces, (requirement, &quantity));
    // A model that takes no part stands in no count's way.
    let is_counted = |at: &usize| matches!(pieces[*at].belief, Belief::Counts { .. });
    let places = (0..pieces.len()).filter(is_counted).collect();
    let free = independent_among(&pieces, places, &study.lineage(), &quantity);
    let plan = |piece: &Piece<'_>| {
        if piece.belief.has_undecided() {
            return None;
        }
        let level = level_of(conclusion, &piece.evidence.id)?;
        let Belief::Counts { effective, .. } = &piece.belief else {
            return None;
        };
        let effect = piece.belief.design_effect()?;
        let id = &piece.evidence.id;
        let looks = Looked::of(&piece.belief);
        if is_decided_already((*effective, looks), effect, threshold, level) {
            return None;
        }
        let found = least(
            (*effective, looks),
            effect,
            threshold,
            level,
            study.levels.power,
        );
        let by = found.and_then(|(trials, _)| FurtherSubjects::of(&piece.finding.measure, trials));
        let shown = shown_at(conclusion, piece);
        let asked_by_people = by.zip(shown).and_then(|(by, shown)| {
            let levels = (study.levels.confidence, study.levels.power);
            checked(&piece.finding.measure, by, (asked, shown), levels)
        });
        if let Some(plan) = asked_by_people {
            let trials = plan.map(|it| it.people.trials());
            return Some(Deciding {
                requirement: requirement.id.clone(),
                evidence: id.clone(),
                trials,
                cost: trials.map(|trials| trials as f64 * costs.of(id)),
                chance: plan.map(|it| it.met + it.missed),
                satisfied: plan.map(|it| it.met),
                violated: plan.map(|it| it.missed),
                by: plan.map(|it| it.people),
            });
        }
        // What whole people do.
        let trials = found.map(|(trials, _)| by.map_or(trials, FurtherSubjects::trials));
        Some(Deciding {
            requirement: requirement.id.clone(),
            evidence: id.clone(),
            trials,
            cost: trials.map(|trials| trials as f64 * costs.of(id)),
            chance: found.map(|(_, (below, above))| (below + above).min(1.0)),
            satisfied: found.map(|(_, (below, above))| if at_least { above } else { below }),
            violated: found.map(|(_, (below, above))| if at_least { below } else { above }),
            by,
        })
    };
    let open = free.into_iter().map(|index| &pieces[index]);
    let mut plans: Vec<Deciding> = open
        .filter(|piece| is_open(piece.evidence))
        .filter_map(plan)
        .collect();
    let cost = |plan: &Deciding| plan.cost.unwrap_or(f64::INFINITY);
    plans.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    plans
}

/// The levels at which a conclusion judges counts by person, of one look where they are looked at again.
fn shown_at(conclusion: &Conclusion, piece: &Piece<'_>) -> Option<Shown> {
    let mut standings = conclusion.standings.iter();
    let own =
        standings.find(|it| it.evidence == piece.evidence.id && it.step != Step::Corroborated)?;
    let share = match Looked::of(&piece.belief).0 {
        Some(_) => stats::SHARE_OF_A_LOOK,
        None => 1.0,
    };
    Some(Shown {
        met: own.level_met * share,
        missed: own.level_missed * share,
    })
}

/// The stricter of the levels at which a conclusion judges a piece.
fn level_of(conclusion: &Conclusion, id: &str) -> Option<Confidence> {
    let mut standings = conclusion.standings.iter();
    let own = standings.find(|it| it.evidence == id && it.step != Step::Corroborated)?;
    Confidence::new(1.0 - own.level_met.min(own.level_missed)).ok()
}

/// The counts with the looks at them, if they are looked at again.
#[derive(Clone, Copy)]
struct Looked<'a>(Option<&'a Belief>);

impl<'a> Looked<'a> {
    fn of(belief: &'a Belief) -> Self {
        let is_looked_at = matches!(
            belief,
            Belief::Counts {
                before: Some(_),
                ..
            }
        );
        Self(is_looked_at.then_some(belief))
    }
}

/// Whether the test of a plan decides without a further trial. The conclusion, which is open, then weighs what that test does
/// not have (people's own counts, and what looks before them cost there), and a plan by it would promise a decision by the
/// next trial.
fn is_decided_already(
    (known, looks): (EffectiveSample, Looked<'_>),
    effect: f64,
    threshold: f64,
    level: Confidence,
) -> bool {
    let none = Predictive::new(&BetaPosterior::jeffreys(known), 0);
    let (below, above) = chances((known, looks), effect > 1.0, &none, threshold, level);
    below + above > 0.0
}

/// Trials with at least this chance of settling it, and the chances of showing the rate to be below and to be above.
fn least(
    (known, looks): (EffectiveSample, Looked<'_>),
    effect: f64,
    threshold: f64,
    level: Confidence,
    power: f64,
) -> Option<(u64, (f64, f64))> {
    let posterior = BetaPosterior::jeffreys(known);
    let chance = |trials: u64| {
        let worth = (trials as f64 / effect).round() as u64;
        let next = Predictive::new(&posterior, worth);
        chances((known, looks), effect > 1.0, &next, threshold, level)
    };
    let suffices = |trials: u64| {
        let (below, above) = chance(trials);
        below + above >= power
    };
    let mut enough = 1;
    while !suffices(enough) {
        if enough >= MOST_TRIALS {
            return None;
        }
        enough = (2 * enough).min(MOST_TRIALS);
    }
    let mut too_few = enough / 2;
    // To within 1 in 100: more exactly, the sawtooth decides.
    while enough - too_few > 1 && enough - too_few > enough / 100 {
        let middle = u64::midpoint(too_few, enough);
        if suffices(middle) {
            enough = middle;
        } else {
            too_few = middle;
        }
    }
    Some((enough, chance(enough)))
}

/// The chances that further trials show the rate to be below a threshold, and to be above.
fn chances(
    (known, looks): (EffectiveSample, Looked<'_>),
    is_clustered: bool,
    next: &Predictive,
    threshold: f64,
    level: Confidence,
) -> (f64, f64) {
    let after = |y: u64| EffectiveSample {
        successes: known.successes + y as f64,
        trials: known.trials + next.trials() as f64,
    };
    let shown = |y: u64| match looks.0 {
        Some(now) => {
            let (below, at_least) =
                over_looks::doubts(&over_looks::after(now, after(y)), threshold);
            (at_least <= level.alpha(), below <= level.alpha())
        }
        None => shown_below_and_above(after(y), is_clustered, threshold, level),
    };
    let all = next.trials();
    // The more successes, the less is it shown to be below, and the more to be above.
    let below = first(all, |y| !shown(y).0);
    let above = first(all, |y| shown(y).1);
    let mut chances = (0.0, 0.0);
    if below > 0 {
        chances.0 = next.probability(0, below - 1);
    }
    if above <= all {
        chances.1 = next.probability(above.max(below), all);
    }
    chances
}

/// The least of `0..=all` that `holds`, when it holds for all after that; `all + 1` if for none.
fn first(all: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut low, mut high) = (0, all + 1);
    while low < high {
        let middle = u64::midpoint(low, high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

#[cfg(test)]
mod promised;

#[cfg(test)]
mod tests {
    use super::*;
    use stats::Sample;

    fn sample(successes: u64, trials: u64) -> EffectiveSample {
        Sample { successes, trials }.into()
    }

    /// By summing over every outcome.
    #[test]
    fn the_chance_is_the_sum_over_outcomes() {
        for (successes, trials, threshold, further) in [
            (17, 20, 0.95, 40),
            (0, 5, 0.5, 30),
            (5, 5, 0.6, 12),
            (19, 20, 0.95, 300),
        ] {
            let known = sample(successes, trials);
            let next = Predictive::new(&BetaPosterior::jeffreys(known), further);
            let shown = |y: &u64| {
                let after = sample(successes + y, trials + further);
                let (below, above) =
                    shown_below_and_above(after, false, threshold, Confidence::P95);
                below || above
            };
            let all = (0..=further).filter(shown);
            let expected: f64 = all.map(|y| next.probability(y, y)).sum();
            let known = (known, Looked(None));
            let (below, above) = chances(known, false, &next, threshold, Confidence::P95);
            let found = below + above;
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    /// 36 of 36 at the effective size show more than 0.9; a conclusion that is open all the same has another reason.
    #[test]
    fn nothing_is_planned_by_a_test_that_decides_already() {
        let decided = |successes, trials| {
            let known = (sample(successes, trials), Looked(None));
            is_decided_already(known, 1.0, 0.9, Confidence::P95)
        };
        assert!(decided(36, 36));
        assert!(decided(10, 36));
        assert!(!decided(34, 36));
    }

    #[test]
    fn clear_rates_take_few_trials_and_close_ones_many() {
        let needed = |successes, trials| {
            least(
                (sample(successes, trials), Looked(None)),
                1.0,
                0.9,
                Confidence::P95,
                0.8,
            )
            .map(|found| found.0)
        };
        let (clear, close) = (needed(70, 80), needed(899, 1000));
        assert!(clear < close && clear.is_some(), "{clear:?} {close:?}");
        // Twice as many where two trials are worth one (by the test of trials that are alike).
        let plain = least(
            (sample(35, 40), Looked(None)),
            1.0 + 1e-9,
            0.9,
            Confidence::P95,
            0.8,
        )
        .unwrap()
        .0;
        let alike = least(
            (sample(35, 40), Looked(None)),
            2.0,
            0.9,
            Confidence::P95,
            0.8,
        )
        .unwrap()
        .0;
        let ratio = alike as f64 / plain as f64;
        assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    }
}
