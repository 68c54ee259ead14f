//! A model whose agreement with the system is shown and declared to carry over to a requirement.
//!
//! # Definition
//! Let a model M say of a requirement that its rate is `q`, and let it (or the same model under other conditions) agree
//! with the system on another quantity or under other conditions, the *anchor*: a comparison of `compare` that is
//! independent, with trials of the system, and whose outcome is "corroborates". The study declares that the difference
//! between M and the system is below the requirement's margin `m` here wherever it is below the anchor's margin there.
//! Then the system's rate `p` is above `q - m` and below `q + m`, and
//!
//! ```text
//! p-value of "p < t"  = max(p-value of the anchor's equivalence, p-value of "q < t + m")
//! p-value of "p >= t" = max(p-value of the anchor's equivalence, p-value of "q >= t - m")
//! ```
//!
//! with `m` the larger of the requirement's margin and the anchor's: agreement within 40 points carries no more than 40
//! points over. Where several trials of the system are compared on the anchor, the smallest of their p-values is multiplied by
//! their number, and all that is declared to carry over to a requirement shares the level. Nothing carries over where any of
//! the trials conflicts with the model on any anchor that is declared for it here. A model that was calibrated on the trials
//! only fits them: it is no anchor; nor are trials of one person or session alone, which tell of this one, nor a decision
//! process whose range over all schedulers is wider than the margin: some scheduler agrees with almost anything.
//!
//! For the requirement that is its own anchor this is never stronger than the trials' own counts, since equivalence with
//! `q` within `m` shows no more of `p` than that it is above `q - m`. It is meant for what the trials did not cover.
//!
//! # Source
//! R. L. Berger, "Multiparameter hypothesis testing and acceptance sampling" (1982), for the larger of two p-values
//! (intersection-union test): one of the two hypotheses is true where the claim is false and the declaration holds.
//!
//! # Assumes
//! The declaration, which nothing tests: a false one makes wrong verdicts frequent (`ERROR_RATES.md` has a row). The tests
//! of the anchor and of the model hold their levels; nothing of how they depend on each other.
//!
//! # Guarantee
//! Given the declaration, a claim shown at a level is wrong with at most that probability, with no division between the
//! two tests.

use super::judge::Asked;
use super::stand::{self, ClaimLevels};
use super::words::{self, percent_down, percent_up};
use super::{Piece, is_trial, limits};
use crate::compare::words::{list, p_value, points};
use crate::compare::{Belief, Study};
use crate::{
    CarryOver, Comparison, Direction, Evidence, Interval, Measure, Outcome, PieceStanding,
    Relation, Requirement, Step, Subject, Threshold,
};

/// A carried-over model, or why it carries nothing over.
#[derive(Clone)]
pub(super) struct Transfer<'a> {
    pub declared: &'a CarryOver,
    /// The model's number on the requirement.
    pub piece: Piece<'a>,
    /// Agreement on the anchor, or why none is shown.
    pub anchor: Result<Anchor, String>,
}

/// Agreement of a model with trials of the system.
#[derive(Clone)]
pub(super) struct Anchor {
    /// p-value of equivalence.
    pub p: f64,
    /// The margin within which it is shown.
    margin: f64,
    /// The trials with which it is shown, on what and within which margin.
    with: String,
}

/// Why a model does not agree with trials of the system.
struct NoAnchor {
    reason: String,
    is_conflict: bool,
}

/// The declared transfers of a requirement whose model is current.
pub(super) fn transfers<'a>(
    study: &Study<'a>,
    requirement: &'a Requirement,
    pieces: &[Piece<'a>],
    comparisons: &[Comparison],
) -> Vec<Transfer<'a>> {
    let declared = requirement.carries_over.iter();
    let current = declared.filter_map(|declared| {
        let mut pieces = pieces.iter();
        let piece = pieces.find(|piece| piece.evidence.id == declared.evidence)?;
        let of = || {
            (
                declared,
                piece.clone(),
                anchor(study, declared, comparisons),
            )
        };
        (!is_trial(piece.evidence)).then(of)
    });
    let current: Vec<_> = current.collect();
    let conflicts: Vec<(String, String)> = current
        .iter()
        .filter_map(|(declared, _, anchor)| {
            let none = anchor.as_ref().err().filter(|none| none.is_conflict)?;
            Some((declared.evidence.clone(), none.reason.clone()))
        })
        .collect();
    let transfer =
        |(declared, piece, anchor): (&'a CarryOver, Piece<'a>, Result<Anchor, NoAnchor>)| {
            Transfer {
                declared,
                anchor: match conflicts.iter().find(|(id, _)| id == &declared.evidence) {
                    Some((_, reason)) => Err(reason.clone()),
                    None => anchor.map_err(|none| none.reason),
                },
                piece,
            }
        };
    current.into_iter().map(transfer).collect()
}

/// The p-value of equivalence with trials of the system on the anchor, or why there is none.
fn anchor(
    study: &Study<'_>,
    declared: &CarryOver,
    comparisons: &[Comparison],
) -> Result<Anchor, NoAnchor> {
    let none = |reason: String| NoAnchor {
        reason,
        is_conflict: false,
    };
    let subject = match &declared.on {
        Subject::Requirement(id) => {
            let mut requirements = study.requirements.iter();
            match requirements.find(|requirement| &requirement.id == id) {
                Some(requirement) => super::quantity(study.requirements, requirement),
                None => declared.on.clone(),
            }
        }
        mode @ Subject::FailureMode(_) => mode.clone(),
    };
    let model = &declared.shown_by;
    let on = declared.on.id();
    let with_trials: Vec<(&Comparison, &str)> = comparisons
        .iter()
        .filter(|it| it.subject == subject && it.outcome != Outcome::NotComparable)
        .filter_map(|it| Some((it, other_side(it, model)?)))
        .filter(|(_, other)| is_trial_in(study.evidence, other))
        .collect();
    if let Some((_, other)) = with_trials
        .iter()
        .find(|(it, _)| it.outcome == Outcome::Conflicts)
    {
        return Err(NoAnchor {
            reason: format!("{model} and {other} conflict on {on}"),
            is_conflict: true,
        });
    }
    // That one person alone differs is no conflict, and no reason to carry anything over either.
    if let Some((_, other)) = with_trials
        .iter()
        .find(|(it, _)| it.relation == Some(Relation::Different))
    {
        return Err(none(format!(
            "{model} and {other} differ on {on}, which is said of one alone"
        )));
    }
    let is_of_one_subject = |evidence: &[Evidence], id: &str| {
        let mut pieces = evidence.iter();
        pieces.any(|piece| piece.id == id && piece.is_of_one_subject_on(&subject))
    };
    if is_of_one_subject(study.evidence, &declared.evidence)
        || is_of_one_subject(study.evidence, model)
    {
        return Err(none(format!(
            "all runs of {} are of one cluster, of which alone they tell",
            declared.evidence
        )));
    }
    let widest = with_trials.iter().map(|(it, _)| it.margin);
    let widest = widest.fold(0.0, f64::max);
    if let Some(width) = width_of_range(study.evidence, model, &subject)
        && width > widest
    {
        return Err(none(format!(
            "{model} gives a range of {} over all schedulers on {on}, wider than the margin: that some of them agrees does not \
             say which is the system's",
            points(width)
        )));
    }
    let independent: Vec<&(&Comparison, &str)> = with_trials
        .iter()
        .filter(|(it, other)| it.independent && !is_of_one_subject(study.evidence, other))
        .collect();
    let count = independent.len() as f64;
    let shown = independent
        .iter()
        .filter(|(it, _)| it.outcome == Outcome::Corroborates);
    let best = shown
        .map(|(it, other)| ((p_of_equivalence(it) * count).min(1.0), *other, it.margin))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((p, other, margin)) => Ok(Anchor {
            p,
            margin,
            with: format!(
                "{other} on {on} within {}{}",
                points(margin),
                left_out(study.evidence, &subject)
            ),
        }),
        None if independent.is_empty() => Err(none(format!(
            "no independent trials of the system are compared with {model} on {on}"
        ))),
        None => Err(none(format!(
            "agreement of {model} with the system on {on} is not shown"
        ))),
    }
}

/// The study's own trials of the system on the anchor that it leaves out, which nothing is compared with.
fn left_out(evidence: &[Evidence], subject: &Subject) -> String {
    let hidden = evidence.iter().filter(|piece| {
        let is_left_out = piece.intermediate || piece.reproduced_by.is_some();
        is_trial(piece) && is_left_out && !piece.published
    });
    let named = hidden.filter_map(|piece| match piece.finding(subject)?.measure {
        Measure::Counts { count, trials, .. } => {
            Some(format!("{} ({count} of {trials})", piece.id))
        }
        _ => None,
    });
    let named: Vec<String> = named.collect();
    match named.is_empty() {
        true => String::new(),
        false => format!(
            " (the study leaves out {}, which speaks of it, too)",
            list(&named)
        ),
    }
}

/// The other piece of a comparison in which this one takes part.
fn other_side<'c>(comparison: &'c Comparison, id: &str) -> Option<&'c str> {
    match (comparison.left == id, comparison.right == id) {
        (true, false) => Some(&comparison.right),
        (false, true) => Some(&comparison.left),
        _ => None,
    }
}

/// How wide the range over all schedulers is that a model gives; none if it gives none.
fn width_of_range(evidence: &[Evidence], id: &str, subject: &Subject) -> Option<f64> {
    let piece = evidence.iter().find(|piece| piece.id == id)?;
    let belief = Belief::of(&piece.finding(subject)?.measure).ok()?;
    belief.width_of_range()
}

fn is_trial_in(evidence: &[Evidence], id: &str) -> bool {
    evidence
        .iter()
        .any(|piece| piece.id == id && is_trial(piece))
}

fn p_of_equivalence(comparison: &Comparison) -> f64 {
    let posterior = comparison
        .probability_within_margin
        .map(|within| 1.0 - within);
    comparison.p_equivalence.or(posterior).unwrap_or(1.0)
}

impl Transfer<'_> {
    /// p-values of "not met" and "met"; 1 where nothing carries over.
    pub fn doubts(&self, threshold: Threshold, margin: f64) -> (f64, f64) {
        let Ok(anchor) = &self.anchor else {
            return (1.0, 1.0);
        };
        let margin = margin.max(anchor.margin);
        let shifted = |by: f64| {
            let value = threshold.value + by;
            (0.0..=1.0)
                .contains(&value)
                .then_some(Threshold { value, ..threshold })
        };
        let (up, down) = match threshold.direction {
            Direction::AtLeast => (margin, -margin),
            Direction::AtMost => (-margin, margin),
        };
        let not_met = shifted(up).map_or(1.0, |it| stand::doubts(&self.piece.belief, it).0);
        let met = shifted(down).map_or(1.0, |it| stand::doubts(&self.piece.belief, it).1);
        (not_met.max(anchor.p), met.max(anchor.p))
    }

    /// How it stands to the threshold.
    pub fn stand(&self, asked: &Asked<'_>, levels: ClaimLevels) -> PieceStanding {
        let (threshold, margin) = (asked.threshold, asked.requirement.margin);
        let margin = self
            .anchor
            .as_ref()
            .map_or(margin, |it| margin.max(it.margin));
        let (p_not_met, p_met) = self.doubts(threshold, margin);
        let own = limits::limits(&self.piece.belief, threshold, levels);
        let holds = |level: f64| self.anchor.as_ref().is_ok_and(|it| it.p <= level);
        let (for_low, for_high) = match threshold.direction {
            Direction::AtLeast => (levels.met, levels.missed),
            Direction::AtMost => (levels.missed, levels.met),
        };
        let limits = Interval {
            low: if holds(for_low) {
                (own.low - margin).max(0.0)
            } else {
                0.0
            },
            high: if holds(for_high) {
                (own.high + margin).min(1.0)
            } else {
                1.0
            },
        };
        PieceStanding {
            evidence: self.piece.evidence.id.clone(),
            step: Step::Corroborated,
            standing: stand::standing(p_not_met, p_met, levels),
            p_not_met,
            p_met,
            level_met: levels.met,
            level_missed: levels.missed,
            limits,
            elsewhere: false,
            condition: asked.named(&self.piece).condition(),
            words: self.words(limits, margin, (p_not_met, p_met), threshold),
        }
    }

    fn words(
        &self,
        limits: Interval,
        margin: f64,
        (p_not_met, p_met): (f64, f64),
        threshold: Threshold,
    ) -> String {
        let id = &self.piece.evidence.id;
        let with = match &self.anchor {
            Err(reason) => return format!("{id} does not carry over: {reason}"),
            Ok(anchor) => &anchor.with,
        };
        let declared = self.declared;
        let who = match declared.shown_by == declared.evidence {
            true => String::new(),
            false => format!(" as {}", declared.shown_by),
        };
        let because = &declared.because;
        let p = p_value(p_not_met.min(p_met));
        let against = words::hypothesis(threshold, p_met < p_not_met);
        format!(
            "{id}, which agrees{who} with {with}, carries over within {} as declared (\"{because}\"): rate {} to {} \
             (p {p} against {against})",
            points(margin),
            percent_down(limits.low),
            percent_up(limits.high),
        )
    }
}
