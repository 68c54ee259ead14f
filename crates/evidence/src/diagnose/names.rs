//! Two ways to fail, two requirements, or one of each, whose names were mixed up in a table.
//!
//! # Definition
//! Two names `a`, `b` of a piece of evidence were mixed up if the strengths (see [`mod@super::strength`]) with which its two
//! rates differ from those of all other evidence under the same conditions sum to at least [`MIXED_UP`] more as they are
//! than exchanged, each of both rates has a share of at least [`EACH`] in it, and exchanged they differ strongly (at least [`STRONG`]) from nobody; of several pairs the one that explains
//! most. Both have to stand in one table: of what is counted by person or session, where one may be a requirement and the other a
//! failure mode, since both are columns of it; or of totals of one kind. What was exchanged is the whole entry, or the occurrences alone (who counted opportunities by another list kept
//! them right; of failure modes alone): whichever explains more, of equal ones the whole. The exchange takes `T - T'` of a conflict on one of the two, `T'` being what is left with the other's rate.
//!
//! # Assumes
//! One exchange at most was made in a table, and all other evidence is right. That many pairs of names are tried is not
//! allowed for. Trials are independent, or count at their effective size.
//!
//! # Source and guarantee
//! One exchange in place of two wrong rates: the fewer things have to be wrong, the likelier (the method of difference, as
//! in [`super::rates`]). Both rates have to fit where the other stood, in all other evidence, which a single wrong rate
//! never makes them do beyond chance.

use super::matter::{Clue, Matter, is_by_subject, name_of};
use super::rates::figure;
use super::strength::{Rate, STRONG, strength};
use super::suspect::Symptom;
use crate::{Evidence, Finding, Inaccuracy, Measure, Subject};

/// From how many decades on an exchange of names explains something.
const MIXED_UP: f64 = 2.0;

/// The least share of each of the two rates, in decades: where one of them is right as it is, the other is wrong by itself.
const EACH: f64 = 0.5;

/// Two failure modes, two requirements, or one of each, of a piece that were written down as each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MixedUp<'p> {
    /// The failure modes and requirements.
    pub modes: [&'p Subject; 2],
    /// Whether their opportunities were exchanged, too.
    pub is_whole: bool,
}

/// The two failure modes and requirements of a piece that were mixed up, if the other evidence says so.
pub fn mixed_up<'p>(
    evidence: &[Evidence],
    piece: &'p Evidence,
    margin: &dyn Fn(&Subject) -> f64,
) -> Option<MixedUp<'p>> {
    let is_mode = |it: &Finding| matches!(it.subject, Subject::FailureMode(_));
    let against = |rates: &[(&Subject, Rate)]| against_others(evidence, piece, rates, margin);
    let mut best: Option<(f64, MixedUp<'_>)> = None;
    for (place, one) in piece.findings.iter().enumerate() {
        let alike = piece.findings[place + 1..].iter();
        let is_alike = |other: &&Finding| {
            let are_by_subject = [*other, one].map(is_by_subject);
            match is_mode(other) == is_mode(one) {
                true => are_by_subject[0] == are_by_subject[1],
                false => are_by_subject == [true, true] && have_same_trials(one, other),
            }
        };
        for other in alike.filter(is_alike) {
            let (a, b) = (&one.subject, &other.subject);
            let (Some(of_a), Some(of_b)) = (Rate::of(one), Rate::of(other)) else {
                continue;
            };
            let (now, _) = against(&[(a, of_a), (b, of_b)]);
            let are_modes = is_mode(one) && is_mode(other);
            let ways: &[bool] = if are_modes { &[true, false] } else { &[true] };
            for &is_whole in ways {
                let [Some(new_a), Some(new_b)] = exchanged(one, other, is_whole) else {
                    continue;
                };
                let (then, worst) = against(&[(a, new_a), (b, new_b)]);
                let explains = now - then;
                let share =
                    |subject, was, is| against(&[(subject, was)]).0 - against(&[(subject, is)]).0;
                let least = share(a, of_a, new_a).min(share(b, of_b, new_b));
                let is_best = best.as_ref().is_none_or(|(most, _)| explains > *most);
                if explains >= MIXED_UP && least >= EACH && worst < STRONG && is_best {
                    let modes = [a, b];
                    best = Some((explains, MixedUp { modes, is_whole }));
                }
            }
        }
    }
    best.map(|(_, found)| found)
}

fn have_same_trials(one: &Finding, other: &Finding) -> bool {
    let trials = |it: &Finding| match it.measure {
        Measure::Counts { trials, .. } => Some(trials),
        _ => None,
    };
    trials(one) == trials(other)
}

/// The rates of two findings after their entries, or only their occurrences, changed places.
fn exchanged(one: &Finding, other: &Finding, is_whole: bool) -> [Option<Rate>; 2] {
    match is_whole {
        true => [Rate::of(other), Rate::of(one)],
        false => [with_occurrences(one, other), with_occurrences(other, one)],
    }
}

/// A finding's opportunities with the occurrences of another.
fn with_occurrences(own: &Finding, other: &Finding) -> Option<Rate> {
    let Measure::Counts { count, .. } = other.measure else {
        return None;
    };
    let Measure::Counts {
        trials,
        effective_trials,
        ..
    } = own.measure
    else {
        return None;
    };
    let size = effective_trials.unwrap_or(trials as f64);
    (count <= trials && trials > 0).then(|| Rate::Counted {
        count: count as f64 / trials as f64 * size,
        open: 0.0,
        trials: size,
    })
}

/// How strongly rates differ from those of all other evidence: the sum, and the strongest.
fn against_others(
    evidence: &[Evidence],
    piece: &Evidence,
    rates: &[(&Subject, Rate)],
    margin: &dyn Fn(&Subject) -> f64,
) -> (f64, f64) {
    let (mut sum, mut most) = (0.0, 0.0_f64);
    let others = evidence.iter().filter(|other| {
        other.id != piece.id && !other.intermediate && other.conditions == piece.conditions
    });
    for other in others {
        for &(subject, rate) in rates {
            let theirs = Rate::on(other, subject);
            let apart = theirs.map_or(0.0, |r| strength(r, rate, margin(subject)));
            sum += apart;
            most = most.max(apart);
        }
    }
    (sum, most)
}

impl Matter<'_> {
    /// What of a conflict goes away if a table's two names are exchanged: the clue, and what is left.
    pub(super) fn of_names(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
        whole: f64,
    ) -> Option<(Clue, f64)> {
        let is_table = super::exchanged::is_table(piece);
        let margin = |subject: &Subject| self.margin(subject);
        let found = is_table
            .then(|| mixed_up(self.evidence, piece, &margin))
            .flatten()?;
        let modes = found.modes;
        let other = match modes {
            [a, b] if a == subject => b,
            [a, b] if b == subject => a,
            _ => return None,
        };
        let [exchanged, _] = exchanged(
            piece.finding(subject)?,
            piece.finding(other)?,
            found.is_whole,
        );
        let exchanged = exchanged?;
        let theirs = Rate::on(against, subject)?;
        let rest = strength(exchanged, theirs, self.margin(subject)).min(whole);
        let value = piece.finding(subject)?.measure.estimate()?;
        let clue = Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: self.table_and_words(piece, subject),
            subject: subject.clone(),
            score: whole - rest,
            title: format!(
                "{} has {} and {} the wrong way round",
                piece.id,
                name_of(modes[0]),
                name_of(modes[1])
            ),
            explanation: format!(
                "With the counts of {} and {} exchanged {} differs strongly from nothing else on either; of the conflict with \
                 {} (Bayes factor 10^{whole:.1}) 10^{rest:.1} is left.",
                name_of(modes[0]),
                name_of(modes[1]),
                piece.id,
                against.id
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: piece.id.clone(),
                value,
                others: vec![super::rates::counts_of(against, subject)],
            },
            figures: vec![
                figure("conflict, log10 Bayes factor", whole),
                figure(
                    "left of it with the names exchanged, log10 Bayes factor",
                    rest,
                ),
            ],
            witnesses: Vec::new(),
            ruled_out: Vec::new(),
            resolved_by: self.mended(piece, against, subject),
        };
        Some((clue, rest))
    }
}
