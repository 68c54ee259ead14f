//! Conclusions: what the current evidence says about each requirement.
//!
//! # Definition
//! *Current* is, under the conditions that most techniques share, the latest evidence of each
//! technique that has a number on the requirement and is neither intermediate nor reproduced by
//! another; of experiments and operation all of it, since a later trial of the robot does not refine an earlier one as a
//! later model does. *Independent* are those of it, roots of lineage first, that rest on none accepted
//! before them. With `k` independent pieces, each is judged one-sidedly at level `1 - alpha/k`:
//! it *supports* the threshold, *denies* it, or does *neither*.
//!
//! | verdict | when |
//! |---|---|
//! | not covered | there is no current evidence |
//! | conflicting | two current pieces conflict and stand differently, or one supports and one denies |
//! | violated | an independent piece denies; or none of this, and one under other conditions does (`elsewhere`) |
//! | satisfied | an independent piece supports and no current piece denies |
//! | undecided | else |
//!
//! A requirement without a threshold asks for certainty. Trials alone cannot show it, however many
//! pass, while one failure denies it; a computed probability within [`CERTAINTY`] of 1 supports it.
//!
//! The common bound is the smallest one-sided lower limit of all current pieces (for a requirement of
//! "at most": the largest upper limit), each at the level `1 - alpha`. It is above the rate of some
//! piece only if it is above the smallest of the rates, and then the limit of the piece with that rate
//! is wrong: so *all rates are at least the bound* holds with confidence `1 - alpha` whatever the number
//! of pieces and their dependence, without a correction for being several (an intersection-union test;
//! R. L. Berger, "Multiparameter hypothesis testing and acceptance sampling", 1982).
//!
//! How often it holds, in percent of 1000 seeded studies (`tests/calibration.rs`, `table_of_common_bounds`; standard
//! error at most 0.7), beside limits that hold all at once (Sidak's), which is more than the statement says; in brackets
//! the mean of the bound. 150 trials of their own or ten people with ten each.
//!
//! | rates | of them alike by person (10 x 10, correlation 0.3) | the bound | all at once |
//! |---|---|---|---|
//! | 0.9, 0.9 | none | 99.8 (0.834) | 100.0 (0.824) |
//! | 0.85, 0.95 | none | 94.4 (0.793) | 98.1 (0.783) |
//! | 0.9, 0.9, 0.9 | none | 100.0 (0.825) | 100.0 (0.809) |
//! | 0.85, 0.95, 0.95 | none | 96.3 (0.792) | 99.0 (0.776) |
//! | 0.9, 0.9, 0.9, 0.9 | none | 100.0 (0.822) | 100.0 (0.802) |
//! | 0.85, 0.95, 0.95, 0.95 | none | 94.8 (0.795) | 99.5 (0.775) |
//! | 0.9, 0.9 | the first | 100.0 (0.728) | 100.0 (0.698) |
//! | 0.85, 0.95 | the first | 96.2 (0.673) | 97.4 (0.641) |
//! | 0.9, 0.9, 0.9 | the first | 100.0 (0.728) | 100.0 (0.682) |
//! | 0.85, 0.95, 0.95 | the first | 97.1 (0.673) | 98.4 (0.624) |
//! | 0.9, 0.9, 0.9, 0.9 | the first | 100.0 (0.724) | 100.0 (0.668) |
//! | 0.85, 0.95, 0.95, 0.95 | the first | 95.7 (0.675) | 97.9 (0.614) |
//! | 0.9, 0.9 | all | 99.7 (0.681) | 99.9 (0.647) |
//! | 0.85, 0.95 | all | 99.4 (0.661) | 100.0 (0.627) |
//! | 0.9, 0.9, 0.9 | all | 100.0 (0.651) | 100.0 (0.596) |
//! | 0.85, 0.95, 0.95 | all | 100.0 (0.648) | 100.0 (0.593) |
//! | 0.9, 0.9, 0.9, 0.9 | all | 100.0 (0.636) | 100.0 (0.566) |
//! | 0.85, 0.95, 0.95, 0.95 | all | 100.0 (0.649) | 100.0 (0.579) |
//!
//! # Guarantee
//! A verdict *violated* or *satisfied* that rests on counts is wrong with probability at most
//! `alpha`, over the sampling of the independent pieces. *Satisfied* speaks of the conditions of those pieces, which the
//! report names; *violated* of some condition that the study declares.

pub(crate) mod alone;
pub(crate) mod combined;
pub(crate) mod coverage;
mod elsewhere;
mod stand;
pub(crate) mod threshold;

use crate::compare::words::{list, percent, points};
use crate::compare::{Belief, Lineage, Study};
use crate::{
    Comparison, Conclusion, Direction, Evidence, Interval, Measure, Outcome, Requirement, Subject,
    Technique, Threshold, Verdict,
};
use stand::{Stand, Standing};
use stats::Confidence;
use std::collections::BTreeMap;

/// A computed probability this near to 1 counts as certain: far below what any trial could tell
/// and above the bounds' width of a sound method.
pub const CERTAINTY: f64 = 1e-9;

/// Draws a conclusion about every requirement, in their order.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn conclude(study: &Study<'_>, comparisons: &[Comparison]) -> Vec<Conclusion> {
    let lineage = study.lineage();
    study
        .requirements
        .iter()
        .map(|requirement| conclusion(study, &lineage, requirement, comparisons))
        .collect()
}

/// One current piece of evidence on a requirement.
pub(crate) struct Piece<'a> {
    pub evidence: &'a Evidence,
    pub belief: Belief,
    /// The interval that it was published with, if it counts.
    pub counted: Option<Interval>,
}

fn conclusion(
    study: &Study<'_>,
    lineage: &Lineage<'_>,
    requirement: &Requirement,
    comparisons: &[Comparison],
) -> Conclusion {
    let quantity = quantity(study.requirements, requirement);
    let pieces = current(study.evidence, requirement, &quantity);
    let threshold = requirement.threshold.unwrap_or(Threshold {
        direction: Direction::AtLeast,
        value: 1.0,
    });
    let independent = independent(&pieces, lineage, &quantity);
    let elsewhere = elsewhere::elsewhere(study.evidence, requirement, &quantity, &pieces);
    let judged = independent.len() + elsewhere.len();
    let level = study.levels.confidence.simultaneous(judged);
    let stand = |piece: &Piece| Stand::of(&piece.evidence.id, &piece.belief, threshold, level);
    let stands: Vec<Stand> = pieces.iter().map(stand).collect();
    let mut denied: Vec<Stand> = elsewhere.iter().map(stand).collect();
    denied.retain(|stand| stand.standing == Standing::Denies);
    let among = among_current(comparisons, &quantity, &pieces);
    let verdict = match verdict(&stands, &independent, &among) {
        Verdict::Satisfied | Verdict::Undecided if !denied.is_empty() => Verdict::Violated,
        verdict => verdict,
    };
    let bound = common_bound(&pieces, threshold.direction, study.levels.confidence);
    Conclusion {
        requirement: requirement.id.clone(),
        verdict,
        statement: statement(
            verdict,
            &pieces,
            [&stands, &denied],
            &among,
            threshold,
            bound,
            study,
        ),
        common_lower_bound: bound.filter(|_| threshold.direction == Direction::AtLeast),
        rests_on: rests_on(&pieces, &denied),
        independent_agreement: agreement(&among, true),
        fitted_agreement: agreement(&among, false),
    }
}

/// The current evidence, and that which denies the requirement under other conditions.
fn rests_on(pieces: &[Piece<'_>], denied: &[Stand]) -> Vec<String> {
    let current = pieces.iter().map(|piece| &piece.evidence.id);
    let denied = denied.iter().map(|stand| &stand.id);
    current.chain(denied).cloned().collect()
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
    let says = |piece: &Evidence| says_something(piece, requirement, quantity).is_some();
    let indices = current_evidence(evidence, says);
    indices
        .into_iter()
        .filter_map(|index| {
            let evidence = &evidence[index];
            let (belief, counted) = says_something(evidence, requirement, quantity)?;
            Some(Piece {
                evidence,
                belief,
                counted,
            })
        })
        .collect()
}

/// What a piece of evidence says about a requirement, and the interval of its counts.
fn says_something(
    piece: &Evidence,
    requirement: &Requirement,
    quantity: &Subject,
) -> Option<(Belief, Option<Interval>)> {
    let own = Subject::Requirement(requirement.id.clone());
    let finding = piece.finding(&own).or_else(|| piece.finding(quantity))?;
    let counted = match &finding.measure {
        Measure::Counts { interval, .. } => Some(*interval),
        _ => None,
    };
    Some((Belief::of(&finding.measure).ok()?, counted))
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
            let said = says_something(piece, requirement, quantity);
            said.is_some_and(|(_, counted)| counted.is_some())
        })
        .collect()
}

/// Whether a piece of evidence is neither a step on the way nor reproduced by another.
fn stands_for_itself(piece: &Evidence) -> bool {
    !piece.intermediate && piece.reproduced_by.is_none()
}

/// Positions of the latest evidence of each technique that `counts`, neither intermediate nor
/// reproduced by another, under the conditions that most techniques share.
pub(crate) fn latest_of_each_technique(
    evidence: &[Evidence],
    counts: impl Fn(&Evidence) -> bool,
) -> Vec<usize> {
    let mut by_conditions: BTreeMap<&str, BTreeMap<Technique, usize>> = BTreeMap::new();
    for (index, piece) in evidence.iter().enumerate() {
        if stands_for_itself(piece) && counts(piece) {
            let latest = by_conditions.entry(&piece.conditions).or_default();
            latest.insert(piece.technique, index);
        }
    }
    let most = by_conditions
        .into_values()
        .max_by_key(|latest| (latest.len(), latest.values().max().copied()));
    let mut indices: Vec<usize> = most.unwrap_or_default().into_values().collect();
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
    matches!(
        piece.technique,
        Technique::Experiment | Technique::Operation
    )
}

/// Positions of the pieces that rest on none of those accepted before, roots first.
fn independent(pieces: &[Piece<'_>], lineage: &Lineage<'_>, quantity: &Subject) -> Vec<usize> {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by_key(|&index| {
        (
            !lineage.is_root(&pieces[index].evidence.id, quantity),
            index,
        )
    });
    let mut accepted: Vec<usize> = Vec::new();
    for index in order {
        let id = &pieces[index].evidence.id;
        let free = accepted.iter().all(|&other| {
            lineage
                .dependence(&pieces[other].evidence.id, id, quantity)
                .is_none()
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

fn verdict(stands: &[Stand], independent: &[usize], among: &[&Comparison]) -> Verdict {
    if stands.is_empty() {
        return Verdict::NotCovered;
    }
    let standing = |id: &str| {
        stands
            .iter()
            .find(|stand| stand.id == id)
            .map(|s| s.standing)
    };
    let torn = among.iter().any(|comparison| {
        comparison.outcome == Outcome::Conflicts
            && standing(&comparison.left) != standing(&comparison.right)
    });
    let any = |wanted| stands.iter().any(|stand| stand.standing == wanted);
    let independently = |wanted| {
        independent
            .iter()
            .any(|&index| stands[index].standing == wanted)
    };
    if torn || (any(Standing::Supports) && any(Standing::Denies)) {
        Verdict::Conflicting
    } else if independently(Standing::Denies) {
        Verdict::Violated
    } else if independently(Standing::Supports) && !any(Standing::Denies) {
        Verdict::Satisfied
    } else {
        Verdict::Undecided
    }
}

/// What all pieces support at once: "at least" or "at most" this, as the requirement asks.
fn common_bound(pieces: &[Piece<'_>], direction: Direction, level: Confidence) -> Option<f64> {
    let beliefs = pieces.iter().map(|piece| &piece.belief);
    match direction {
        Direction::AtLeast => beliefs
            .map(|belief| belief.lower_limit(level))
            .reduce(f64::min),
        Direction::AtMost => beliefs
            .map(|belief| belief.upper_limit(level))
            .reduce(f64::max),
    }
}

fn statement(
    verdict: Verdict,
    pieces: &[Piece<'_>],
    [stands, denied]: [&[Stand]; 2],
    among: &[&Comparison],
    threshold: Threshold,
    bound: Option<f64>,
    study: &Study<'_>,
) -> String {
    if verdict == Verdict::NotCovered {
        return "No current evidence says anything about it.".to_owned();
    }
    let figures: Vec<String> = stands.iter().map(|stand| stand.words.clone()).collect();
    let mut words = format!("{} {}.", opening(verdict, threshold), list(&figures));
    if !denied.is_empty() {
        let figures: Vec<String> = denied.iter().map(|stand| stand.words.clone()).collect();
        words.push_str(&format!(" Under other conditions {}.", list(&figures)));
    }
    for conflict in among
        .iter()
        .filter(|comparison| comparison.outcome == Outcome::Conflicts)
    {
        let size = points(conflict.difference.unwrap_or(0.0).abs());
        words.push_str(&format!(
            " {} and {} conflict by {size}.",
            conflict.left, conflict.right
        ));
    }
    // Without a conflict of two rates it is the threshold on which they part.
    let of = |wanted: Standing| {
        let standing = stands.iter().filter(|stand| stand.standing == wanted);
        list(&standing.map(|stand| stand.id.clone()).collect::<Vec<_>>())
    };
    let mut conflicts = among.iter().map(|comparison| comparison.outcome);
    if verdict == Verdict::Conflicting && !conflicts.any(|it| it == Outcome::Conflicts) {
        let (met, missed) = (of(Standing::Supports), of(Standing::Denies));
        words.push_str(&format!(" By {met} it is met, by {missed} it is missed."));
    }
    let trials_alone = pieces
        .iter()
        .all(|piece| matches!(piece.belief, Belief::Counts { .. }));
    if verdict == Verdict::Undecided && threshold.value >= 1.0 && trials_alone {
        words.push_str(" Trials alone cannot show certainty.");
    }
    if let Some(bound) = bound {
        let ids: Vec<String> = stands.iter().map(|stand| stand.id.clone()).collect();
        let common = common_statement(&ids, threshold.direction, bound, study.levels.confidence);
        words.push_str(&format!(" {common}"));
    }
    words
}

fn opening(verdict: Verdict, threshold: Threshold) -> String {
    let asked = stand::in_words(threshold);
    match verdict {
        Verdict::Satisfied => format!("It holds ({asked})."),
        Verdict::Violated => format!("It does not hold ({asked})."),
        Verdict::Conflicting => format!("The evidence contradicts itself ({asked})."),
        _ => format!("The evidence does not decide ({asked})."),
    }
}

/// The common bound in a sentence that stays true when its number is rounded.
fn common_statement(
    ids: &[String],
    direction: Direction,
    bound: f64,
    confidence: Confidence,
) -> String {
    let who = match ids {
        [only] => format!("{only} supports"),
        [_, _] => format!("{} both support", list(ids)),
        _ => format!("{} all support", list(ids)),
    };
    let level = percent(confidence.level());
    let what = match direction {
        Direction::AtLeast => format!("at least {}", percent_down(bound)),
        Direction::AtMost => format!("at most {}", percent_up(bound)),
    };
    format!("{who} {what} with {level} confidence.")
}

/// A lower bound in percent, rounded down so that the sentence stays true.
fn percent_down(bound: f64) -> String {
    if bound >= 1.0 {
        return percent(1.0);
    }
    let mut scale = 1e3;
    while 1.0 - bound < 1.0 / scale && scale < 1e12 {
        scale *= 10.0;
    }
    percent((bound * scale).floor() / scale)
}

/// An upper bound in percent, rounded up.
fn percent_up(bound: f64) -> String {
    if bound <= 0.0 {
        return percent(0.0);
    }
    let mut scale = 1e3;
    while bound < 1.0 / scale && scale < 1e12 {
        scale *= 10.0;
    }
    percent(((bound * scale).ceil() / scale).min(1.0))
}

fn agreement(among: &[&Comparison], independent: bool) -> Vec<String> {
    among
        .iter()
        .filter(|comparison| comparison.outcome == Outcome::Corroborates)
        .filter(|comparison| comparison.independent == independent)
        .map(|comparison| {
            let pair = format!("{} and {}", comparison.left, comparison.right);
            match comparison.reason.strip_prefix("They ") {
                Some(rest) => format!("{pair} {rest}"),
                None => format!("{pair}: {}", comparison.reason),
            }
        })
        .collect()
}
