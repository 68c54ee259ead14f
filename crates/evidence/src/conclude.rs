//! Conclusions: what the current evidence says about each requirement.
//!
//! # Definition
//! *Current* is, under the conditions that most techniques share, the latest evidence of each
//! technique that has a number on the requirement and is neither intermediate nor reproduced by
//! another; of experiments and operation all of it, since a later trial of the robot does not refine an earlier one as a
//! later model does. What is not current is listed with the reason (`excluded`), and what is intermediate and would
//! change the verdict is named in its statement.
//!
//! A requirement speaks of the system. So a verdict stands on a step of the ladder ([`Step`]): trials of the system
//! decide first; then a model whose agreement with the system is shown and declared to carry over (`transfer`); then a
//! simulation or a model by itself, whose verdict speaks of itself alone. `ladder` has the table, and a requirement
//! names the step that it needs ([`Requirement::needs`]).
//!
//! The level `alpha` of a claim ("met" or "missed") is divided
//!
//! * among the requirements of the study by Holm's procedure (`levels`), or not at all where the study asks for an error
//!   rate for each requirement;
//! * among the independent pieces of trials and the carried-over models that can make the claim of one requirement
//!   (Bonferroni). Independent are those trials, roots of lineage first, that rest on none accepted before them. Models
//!   that speak for themselves are divided among themselves.
//!
//! A requirement without a threshold asks for certainty. Trials alone cannot show it, however many
//! pass, while one failure denies it; a computed probability within [`CERTAINTY`] of 1 supports it, for the model.
//!
//! # Assumes
//! Trials of the system under the same conditions have one rate, the system's. They are independent, or of people who are
//! independent draws of those whom the requirement speaks of, with rates of a beta distribution. Sizes were fixed in
//! advance, or all looks are recorded; no piece and no requirement was left out for its outcome. Runs without a verdict may
//! be either. That a model's agreement carries over is declared and not tested.
//!
//! # Guarantee
//! The probability that a requirement which the system does not meet is called *satisfied* on the step "of the system"
//! or "corroborated" is at most `alpha`, and so is that of one which it meets being called *violated* there; with the
//! error rate of the study, both hold for any of its requirements. For a carried-over model this rests on the declaration
//! that its agreement carries over. On the steps "in simulation" and "for the model" the same holds of the rate of the
//! simulator or model: of the system such a verdict says nothing. *Satisfied* speaks of the conditions of its pieces,
//! which the report names; *violated* of some condition that the study declares.
//!
//! Attempts of people who differ keep it as far as these differ as the beta-binomial model has it and are many: at divided
//! levels an error is up to twice as frequent (`compare/by_cluster.rs`). `ERROR_RATES.md` has the rates, those over looks and
//! those of what is carried over.
//!
//! How often a requirement that the system does not meet is called satisfied on any step, and on one that is enough, beside
//! a model with a typed-in constant or a simulator; in percent of 4000 seeded studies (standard error at most 0.4 at 5), by
//! `cargo run -p corroborate-evidence --release --example ladder`:
//!
//! | threshold | system | trials | beside it | satisfied on any step | and enough |
//! |---|---|---|---|---|---|
//! | 0.9 | 0.85 | 10 | model, 95 % | 82.8 | 0.0 |
//! | 0.9 | 0.85 | 10 | model, 99 % | 55.4 | 0.0 |
//! | 0.9 | 0.85 | 10 | simulator, 970 of 1000 | 55.4 | 0.0 |
//! | 0.9 | 0.85 | 50 | model, 95 % | 50.3 | 0.1 |
//! | 0.9 | 0.85 | 50 | model, 99 % | 20.7 | 0.1 |
//! | 0.9 | 0.85 | 50 | simulator, 970 of 1000 | 34.9 | 0.1 |
//! | 0.9 | 0.85 | 200 | model, 95 % | 31.0 | 0.1 |
//! | 0.9 | 0.85 | 200 | model, 99 % | 4.1 | 0.1 |
//! | 0.9 | 0.85 | 200 | simulator, 970 of 1000 | 17.9 | 0.1 |
//! | 0.9 | 0.89 | 10 | model, 95 % | 91.0 | 0.0 |
//! | 0.9 | 0.89 | 10 | model, 99 % | 70.8 | 0.0 |
//! | 0.9 | 0.89 | 10 | simulator, 970 of 1000 | 70.8 | 0.0 |
//! | 0.9 | 0.89 | 50 | model, 95 % | 82.0 | 1.9 |
//! | 0.9 | 0.89 | 50 | model, 99 % | 52.0 | 1.9 |
//! | 0.9 | 0.89 | 50 | simulator, 970 of 1000 | 68.6 | 1.9 |
//! | 0.9 | 0.89 | 200 | model, 95 % | 89.0 | 1.2 |
//! | 0.9 | 0.89 | 200 | model, 99 % | 45.9 | 1.2 |
//! | 0.9 | 0.89 | 200 | simulator, 970 of 1000 | 78.6 | 1.2 |
//! | 0.95 | 0.9 | 10 | model, 95 % | 92.6 | 0.0 |
//! | 0.95 | 0.9 | 10 | model, 99 % | 74.5 | 0.0 |
//! | 0.95 | 0.9 | 10 | simulator, 970 of 1000 | 74.5 | 0.0 |
//! | 0.95 | 0.9 | 50 | model, 95 % | 61.0 | 0.0 |
//! | 0.95 | 0.9 | 50 | model, 99 % | 61.0 | 0.0 |
//! | 0.95 | 0.9 | 50 | simulator, 970 of 1000 | 61.0 | 0.0 |
//! | 0.95 | 0.9 | 200 | model, 95 % | 13.5 | 0.0 |
//! | 0.95 | 0.9 | 200 | model, 99 % | 13.5 | 0.0 |
//! | 0.95 | 0.9 | 200 | simulator, 970 of 1000 | 13.5 | 0.0 |
//!
//! How often one or more verdicts of the system are wrong in a study with several requirements, all at their thresholds of
//! 90 %, with the error rate of the study and with that of each requirement:
//!
//! | requirements | trials | error rate of | any false "violated" | any false "satisfied" |
//! |---|---|---|---|---|
//! | 1 | 50 | the study | 2.3 | 3.1 |
//! | 1 | 50 | each | 2.3 | 3.1 |
//! | 1 | 200 | the study | 4.4 | 3.2 |
//! | 1 | 200 | each | 4.4 | 3.2 |
//! | 2 | 50 | the study | 4.6 | 1.0 |
//! | 2 | 50 | each | 4.6 | 6.2 |
//! | 2 | 200 | the study | 3.5 | 3.2 |
//! | 2 | 200 | each | 8.8 | 6.0 |
//! | 5 | 50 | the study | 4.7 | 2.5 |
//! | 5 | 50 | each | 11.3 | 15.3 |
//! | 5 | 200 | the study | 4.5 | 3.8 |
//! | 5 | 200 | each | 19.6 | 14.7 |
//! | 10 | 50 | the study | 3.1 | 0.0 |
//! | 10 | 50 | each | 21.2 | 29.0 |
//! | 10 | 200 | the study | 3.2 | 3.7 |
//! | 10 | 200 | each | 35.6 | 27.8 |
//!
//! `tests/integration/verdicts.rs` has the sums over all counts for the first, and a small version of the second.

pub(crate) mod alone;
pub(crate) mod combined;
mod common;
pub(crate) mod coverage;
mod elsewhere;
mod excluded;
mod fewer;
mod further_people;
mod judge;
mod ladder;
mod levels;
mod limits;
mod stand;
mod statement;
pub(crate) mod threshold;
mod transfer;
mod words;

use crate::compare::{Belief, Lineage, Study};
use crate::looks::{is_open, looking};
use crate::{
    Comparison, Conclusion, Denominator, Direction, ErrorRate, Evidence, Finding, Interval,
    Measure, Outcome, Requirement, Standing, Subject, Technique, Threshold,
};
use common::{common_bound, over_the_same_runs};
use judge::{Asked, Level};
pub(crate) use limits::of_tests;
pub(crate) use stand::at_one_look;
use std::collections::BTreeMap;
pub use words::{AS_ALIKE, effective_size};

#[cfg(doc)]
use crate::Step;

/// A computed probability this near to 1 counts as certain: far below what any trial could tell
/// and above the bounds' width of a sound method.
pub const CERTAINTY: f64 = 1e-9;

/// Draws a conclusion about every requirement, in their order.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn conclude(study: &Study<'_>, comparisons: &[Comparison]) -> Vec<Conclusion> {
    let lineage = study.lineage();
    let asked: Vec<Asked> = study
        .requirements
        .iter()
        .map(|requirement| Asked::new(study, &lineage, requirement, comparisons))
        .collect();
    let levels = judge::levels(study, &asked);
    let pairs = asked.iter().zip(&levels);
    pairs
        .map(|(asked, level)| conclusion(study, asked, level))
        .collect()
}

/// One current piece of evidence on a requirement.
#[derive(Clone)]
pub(crate) struct Piece<'a> {
    pub evidence: &'a Evidence,
    /// What it found on the requirement, or on the one with the same quantity.
    pub finding: &'a Finding,
    pub belief: Belief,
    /// The interval that it was published with, if it counts.
    pub counted: Option<Interval>,
}

impl<'a> Piece<'a> {
    /// Whether all its trials that count here are of one person, session or other cluster that does not stand for all.
    pub fn is_of_one_subject(&self) -> bool {
        self.evidence.is_of_one_subject_on(&self.finding.subject)
    }

    /// What a piece of evidence says about a requirement, if it has a number on it.
    fn of(evidence: &'a Evidence, requirement: &Requirement, quantity: &Subject) -> Option<Self> {
        let own = Subject::Requirement(requirement.id.clone());
        let finding = evidence
            .finding(&own)
            .or_else(|| evidence.finding(quantity))?;
        // A number over other runs than those that the requirement speaks of.
        if matches!(finding.denominator, Denominator::OtherTrigger { .. })
            || finding.counts_untriggered()
        {
            return None;
        }
        let counted = match &finding.measure {
            Measure::Counts { interval, .. } => Some(*interval),
            _ => None,
        };
        Some(Self {
            evidence,
            finding,
            belief: Belief::of_finding(finding).ok()?,
            counted,
        })
    }
}

fn conclusion(study: &Study<'_>, asked: &Asked<'_>, level: &Level) -> Conclusion {
    let judged = asked.judge(level);
    let (verdict, step) = ladder::decide(&judged, &asked.apart());
    let confidence = study.levels.confidence;
    let together = over_the_same_runs(&asked.pieces);
    let bound = common_bound(&together, asked.threshold.direction, confidence);
    let excluded = excluded::excluded(study, asked, level, (verdict, step));
    let statement = statement::Statement {
        asked,
        level,
        judged: &judged,
        verdict,
        step,
        excluded: &excluded,
        is_looked_at_again: study.looks.is_some(),
    };
    Conclusion {
        requirement: asked.requirement.id.clone(),
        verdict,
        step,
        needs: asked.requirement.needs,
        statement: statement.words(),
        excluded,
        excluded_trials: excluded::excluded_trials(study, asked),
        error_rate: ErrorRate {
            level: confidence.alpha(),
            holds_for: study.levels.family,
            quantities: level.quantities,
        },
        common_lower_bound: bound.filter(|_| {
            // What is over other runs is of another rate: nothing is said of all of them then.
            asked.threshold.direction == Direction::AtLeast && together.len() == asked.pieces.len()
        }),
        rests_on: rests_on(asked, &judged),
        independent_agreement: agreement(&asked.among, true),
        fitted_agreement: agreement(&asked.among, false),
        clustering: Vec::new(),
        looking: asked
            .pieces
            .iter()
            .filter_map(|piece| looking(&piece.evidence.id, &piece.belief, study.levels.confidence))
            .collect(),
        standings: judged.into_iter().map(|judged| judged.standing).collect(),
    }
}

/// The current evidence, and that which denies the requirement under other conditions.
fn rests_on(asked: &Asked<'_>, judged: &[ladder::Judged]) -> Vec<String> {
    let current = asked.pieces.iter().map(|piece| piece.evidence.id.clone());
    let elsewhere = judged.iter().filter(|it| it.standing.elsewhere);
    let denied = elsewhere.filter(|it| it.decides && it.standing.standing == Standing::Denies);
    current
        .chain(denied.map(|it| it.standing.evidence.clone()))
        .collect()
}

/// The subject under which a requirement's quantity is compared.
fn quantity(requirements: &[Requirement], requirement: &Requirement) -> Subject {
    let mut id = &requirement.id;
    let mut next = requirement.same_quantity_as.as_ref();
    // As many steps as there are requirements, so that a circle ends.
    for _ in requirements {
        let Some(other) = next else { break };
        id = other;
        next = requirements
            .iter()
            .find(|candidate| &candidate.id == other)
            .and_then(|candidate| candidate.same_quantity_as.as_ref());
    }
    Subject::Requirement(id.clone())
}

/// The current evidence on a requirement, in the ledger's order.
fn current<'a>(
    evidence: &'a [Evidence],
    requirement: &Requirement,
    quantity: &Subject,
) -> Vec<Piece<'a>> {
    let says = |piece: &Evidence| Piece::of(piece, requirement, quantity).is_some();
    let indices = current_evidence(evidence, says);
    let pieces = indices.into_iter().map(|index| &evidence[index]);
    pieces
        .filter_map(|piece| Piece::of(piece, requirement, quantity))
        .collect()
}

/// The same pieces with the looks at them, where trials may be added.
fn looked_at<'a>(
    study: &Study<'_>,
    pieces: Vec<Piece<'a>>,
    (requirement, quantity): (&Requirement, &Subject),
) -> Vec<Piece<'a>> {
    let Some(looks) = study.looks else {
        return pieces;
    };
    let own = Subject::Requirement(requirement.id.clone());
    let with_looks = |piece: Piece<'a>| {
        if !is_open(piece.evidence) {
            return piece;
        }
        let subject = match piece.evidence.finding(&own) {
            Some(_) => &own,
            None => quantity,
        };
        let before = looks.before(&piece.evidence.id, subject, &piece.belief);
        Piece {
            belief: piece.belief.looked_at(&before),
            ..piece
        }
    };
    pieces.into_iter().map(with_looks).collect()
}

/// Evidence that counts and would be current, if a later piece of the same technique did not take its place.
pub(crate) fn superseded<'a>(
    evidence: &'a [Evidence],
    requirement: &Requirement,
    quantity: &Subject,
    pieces: &[Piece<'_>],
) -> Vec<&'a Evidence> {
    let is_current = |id: &str| pieces.iter().any(|piece| piece.evidence.id == id);
    let conditions = pieces.first().map(|piece| &piece.evidence.conditions);
    evidence
        .iter()
        .filter(|piece| stands_for_itself(piece))
        .filter(|piece| Some(&piece.conditions) == conditions && !is_current(&piece.id))
        .filter(|piece| {
            let said = Piece::of(piece, requirement, quantity);
            said.is_some_and(|it| it.counted.is_some())
        })
        .collect()
}

/// Whether a piece of evidence is neither a step on the way nor reproduced by another.
fn stands_for_itself(piece: &Evidence) -> bool {
    !piece.intermediate && piece.reproduced_by.is_none()
}

/// Positions of the latest evidence of each technique that `counts`, neither intermediate nor
/// reproduced by another, under the conditions that most techniques share; of several such, those under which the system was
/// tried, with more than one person or session.
pub(crate) fn latest_of_each_technique(
    evidence: &[Evidence],
    counts: impl Fn(&Evidence) -> bool,
) -> Vec<usize> {
    // What is of one person, session or other cluster decides nothing of others, so it chooses no conditions either.
    let tells = |piece: &Evidence| !piece.is_of_one_subject();
    let mut by_conditions: BTreeMap<&str, BTreeMap<Technique, usize>> = BTreeMap::new();
    for (index, piece) in evidence.iter().enumerate() {
        if stands_for_itself(piece) && counts(piece) {
            let latest = by_conditions.entry(&piece.conditions).or_default();
            // Nor does it take the place of what tells of others.
            match latest.get(&piece.technique) {
                Some(known) if tells(&evidence[*known]) && !tells(piece) => {}
                _ => _ = latest.insert(piece.technique, index),
            }
        }
    }
    let is_tried = |conditions: &str| {
        let mut trials = evidence.iter().filter(|piece| is_trial(piece));
        trials.any(|piece| piece.conditions == conditions && tells(piece))
    };
    let telling = |conditions: &str, latest: &BTreeMap<Technique, usize>| {
        let mut pieces: Vec<&Evidence> = evidence.iter().collect();
        pieces.retain(|piece| piece.conditions == conditions && tells(piece));
        let has = |technique: &&Technique| pieces.iter().any(|it| it.technique == **technique);
        latest.keys().filter(has).count()
    };
    let most = by_conditions
        .into_iter()
        .max_by_key(|(conditions, latest)| {
            let last = latest.values().max().copied();
            let techniques = telling(conditions, latest);
            (techniques, is_tried(conditions), latest.len(), last)
        });
    let latest = most.map(|(_, latest)| latest).unwrap_or_default();
    let mut indices: Vec<usize> = latest.into_values().collect();
    indices.sort_unstable();
    indices
}

/// Positions of the evidence that speaks for now: the latest of each technique, and all trials of the robot itself under
/// the same conditions.
pub(crate) fn current_evidence(
    evidence: &[Evidence],
    counts: impl Fn(&Evidence) -> bool,
) -> Vec<usize> {
    let latest = latest_of_each_technique(evidence, &counts);
    let conditions = latest.first().map(|&index| &evidence[index].conditions);
    let counts_too = |piece: &Evidence| {
        is_trial(piece)
            && Some(&piece.conditions) == conditions
            && stands_for_itself(piece)
            && counts(piece)
    };
    (0..evidence.len())
        .filter(|index| latest.contains(index) || counts_too(&evidence[*index]))
        .collect()
}

/// Whether it is of the robot itself: later trials do not take the place of earlier ones.
fn is_trial(piece: &Evidence) -> bool {
    piece.technique.is_of_system()
}

/// Positions of the pieces that rest on none of those accepted before, roots first.
fn independent(pieces: &[Piece<'_>], lineage: &Lineage<'_>, quantity: &Subject) -> Vec<usize> {
    independent_among(pieces, (0..pieces.len()).collect(), lineage, quantity)
}

/// The same of these places alone, so that no piece is left out for one that takes no part.
fn independent_among(
    pieces: &[Piece<'_>],
    mut order: Vec<usize>,
    lineage: &Lineage<'_>,
    quantity: &Subject,
) -> Vec<usize> {
    let is_root = |piece: &Piece<'_>| match is_trial(piece.evidence) {
        true => lineage.is_root_of_counts(&piece.evidence.id, quantity),
        false => lineage.is_root(&piece.evidence.id, quantity),
    };
    order.sort_by_key(|&index| (!is_root(&pieces[index]), index));
    let mut accepted: Vec<usize> = Vec::new();
    for index in order {
        let id = &pieces[index].evidence.id;
        let free = accepted.iter().all(|&other| {
            let both = [&pieces[other], &pieces[index]];
            let found = match both.iter().all(|it| is_trial(it.evidence)) {
                true => lineage.dependence_of_counts(&pieces[other].evidence.id, id, quantity),
                false => lineage.dependence(&pieces[other].evidence.id, id, quantity),
            };
            found.is_none()
        });
        if free {
            accepted.push(index);
        }
    }
    accepted.sort_unstable();
    accepted
}

/// Comparisons of two current pieces on the quantity.
fn among_current<'a>(
    comparisons: &'a [Comparison],
    quantity: &Subject,
    pieces: &[Piece<'_>],
) -> Vec<&'a Comparison> {
    let is_current = |id: &str| pieces.iter().any(|piece| piece.evidence.id == id);
    comparisons
        .iter()
        .filter(|comparison| &comparison.subject == quantity)
        .filter(|comparison| is_current(&comparison.left) && is_current(&comparison.right))
        .collect()
}

/// What a requirement asks for; one without a threshold asks for certainty.
pub(crate) fn threshold_of(requirement: &Requirement) -> Threshold {
    requirement.threshold.unwrap_or(Threshold {
        direction: Direction::AtLeast,
        value: 1.0,
    })
}

fn agreement(among: &[&Comparison], independent: bool) -> Vec<String> {
    among
        .iter()
        .filter(|comparison| comparison.outcome == Outcome::Corroborates)
        .filter(|comparison| comparison.independent == independent)
        // What is possibly copied, or on the same draws, is neither: the comparison says what it is.
        .filter(|comparison| !comparison.possibly_copied && !comparison.paired)
        .map(|comparison| {
            let pair = format!("{} and {}", comparison.left, comparison.right);
            match comparison.reason.strip_prefix("They ") {
                Some(rest) => format!("{pair} {rest}"),
                None => format!("{pair}: {}", comparison.reason),
            }
        })
        .collect()
}
